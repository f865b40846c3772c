/* {{ name }} on a GPU: the functions of {{ name }}.h for N states at once, one thread for each state.
 *
 * Arrays are in device memory, entry by entry: entry i of state k is at [i * N + k]; a matrix has
 * its entries in rows. X{{ ", g" if gravity_input }} and what is no state of the arm are shared by all states, without k. With
 * x_each != 0 each state has an X, at [i * N + k].
 * status: N numbers of {{ name }}_status, one for each state; NULL: none.
 * stream: a cudaStream_t; NULL: the default stream.
 * Returns the cudaError_t of the launch, or one that an earlier call left; 0: launched. Compile {{ name }}.cu with nvcc. Compiled as C++, it
 * has the same functions for arrays in the memory of the processor.
 */
#ifndef {{ name }}_CUDA_H
#define {{ name }}_CUDA_H

#include "{{ name }}.h"

#ifdef __cplusplus
extern "C" {
#endif
{% for k in kernels %}
{% set each = k.arguments | selectattr("name", "equalto", "X") | list %}
{% set end = ";" %}

/* {{ k.doc | join("\n * ") }} */
{% include "cuda_prototype.c" %}
{% endfor %}

#ifdef __cplusplus
}
#endif

#endif
