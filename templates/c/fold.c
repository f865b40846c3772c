/* {{ name }}: rows of {{ k.name }} and their right-hand side, folded into a triangle. */
#include "{{ name }}_{{ k.name }}_panels.h"
#include "{{ name }}_{{ k.name }}_fold.h"
#include "{{ name }}_lanes.inc"

/* Columns with the right-hand side; rows of a sample; panels of a block. */
#define COLUMNS {{ k.columns + 1 }}u
#define COLUMNS4 ((COLUMNS + 3u) / 4u * 4u)
#define EACH {{ k.rows }}u
#define SAMPLES {{ k.panels }}u
#define ROWS (EACH * SAMPLES)
#include "{{ name }}_fold.inc"

/* Rows of a sample that are not zero up to a column. */
static const size_t reached[{{ k.reached|length }}] = { {{ k.reached|join(", ") }} };

typedef struct {
    lanes panels[SAMPLES * EACH * (COLUMNS - 1u)];
    lanes block[COLUMNS4 * ROWS];
    lanes sums[COLUMNS4 * (COLUMNS4 + 4u) / 2u];
    double R[COLUMNS4 * COLUMNS4];
} memory;

size_t {{ name }}_{{ k.name }}_fold_size(void)
{
    return sizeof(memory);
}

void {{ name }}_{{ k.name }}_fold({{ k.parameters }})
{
    memory *m = room;
    size_t reach[COLUMNS4];
    memset(m, 0, sizeof *m);
    for (size_t i = 0; i < COLUMNS4; ++i) {
        reach[i] = i < COLUMNS - 1u ? reached[i] * SAMPLES : ROWS;
    }
    for (size_t k = 0; k < N; k += SAMPLES * WIDTH) {
        const size_t count = N - k < SAMPLES * WIDTH ? N - k : SAMPLES * WIDTH;
        {{ name }}_{{ k.name }}_panels(0, count, {{ k.strides }}, (double *)m->panels);
        fold_scaled(m->panels, &y[k * EACH], &weights[varying ? k * EACH : 0], varying, count, m->block);
        if (orthogonal) {
            fold_orthogonal(m->block, reach, m->R);
        } else {
            fold_normal(m->block, reach, m->sums);
        }
    }
    if (!orthogonal) {
        fold_normal_end(m->sums, out);
        return;
    }
    for (size_t i = 0; i < COLUMNS; ++i) {
        memcpy(&out[i * COLUMNS], &m->R[i * COLUMNS4], COLUMNS * sizeof(double));
    }
}
