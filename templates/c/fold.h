/* {{ name }}: rows of {{ k.name }} and their right-hand side, folded into a triangle.
 *
 * out: (columns + 1, columns + 1), the last column of y. Of the rows A = weights [W, y] it is A'A, or,
 * where orthogonal, the upper triangle R with R'R = A'A by reflections. weights: one number for each
 * row of a sample, or (varying) of every sample. room: _fold_size() bytes that begin a cache line.
 */
#ifndef {{ name }}_{{ k.name }}_FOLD_H
#define {{ name }}_{{ k.name }}_FOLD_H

#include <stddef.h>

size_t {{ name }}_{{ k.name }}_fold_size(void);
void {{ name }}_{{ k.name }}_fold({{ k.parameters }});

#endif
