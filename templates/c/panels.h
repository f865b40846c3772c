/* {{ name }}: {{ k.name }} on panels of samples, for the machine that compiles it.
 *
 * stream: whether outputs are written past the cache. Inputs are rows of samples. Outputs of _rows
 * are, too; those of _panels are (ceil(N / width), size, width) and begin at a multiple of 8 width
 * bytes; what stands behind the last sample repeats it, and what is zero for every sample is left as
 * it was: the caller has put zeros there. Not 0: the result of a sample has no meaning.
 */
#ifndef {{ name }}_{{ k.name }}_PANELS_H
#define {{ name }}_{{ k.name }}_PANELS_H

#include <stddef.h>

size_t {{ name }}_{{ k.name }}_width(void);
int {{ name }}_{{ k.name }}_rows(int stream, size_t N, {{ k.plain }});
int {{ name }}_{{ k.name }}_panels(int stream, size_t N, {{ k.plain }});

#endif
