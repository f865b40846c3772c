/* {{ name }}: kernels on panels: as many samples at once as a vector register holds.
 *
 * The compiler's flags choose the width: 8 doubles or 16 floats with AVX-512, half with AVX and
 * AVX2, a quarter with SSE2 and NEON; 1 in C++, with another compiler than gcc and clang, and on
 * other processors. {{ name }}_KERNEL_width() tells the width that a kernel was compiled with.
 *
 * Inputs are rows of samples. strides[i] is the distance of two rows of input i, in numbers, in the
 * order of the arguments; 0: all samples share it. NULL: rows without gaps, X{{ " and g" if gravity_input }} shared.
 * Outputs of _rows are rows without gaps. Those of _panels are (ceil(N / width), size, width): entry
 * [k, i, l] is output i of sample k width + l. What stands behind the last sample repeats it, and
 * entries that are zero for every sample may be left as they were: put zeros there once.
 * stream: not 0 writes outputs past the cache, where they begin at a multiple of 64 bytes.
 * Returns the status of the _batch form; 0 where a kernel cannot fail.
 */
#ifndef {{ name }}_PANELS_H
#define {{ name }}_PANELS_H

#include "{{ name }}.h"

#ifdef __cplusplus
extern "C" {
#endif
{% for k in kernels %}

size_t {{ name }}_{{ k.name }}_width(void);
{% for form in ("rows", "panels") %}
int {{ name }}_{{ k.name }}_{{ form }}(int stream, size_t N, const size_t *strides,
{% for line in k.batch_lines %}
    {{ line }}{{ ");" if loop.last }}
{% endfor %}
{% endfor %}
{% endfor %}

#ifdef __cplusplus
}
#endif

#endif
