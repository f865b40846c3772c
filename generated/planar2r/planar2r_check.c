/* planar2r: every kernel at seeded points against values computed with 50 digits.
 * Exit status 0 when each agrees to 1e-13 of the largest entry of its output.
 */
#include "planar2r.h"

#include <math.h>
#include <stdio.h>

static double error_of(const planar2r_real *out, const double *expected, size_t size)
{
    double largest = 0.0;
    double scale = 0.0;
    for (size_t i = 0; i < size; ++i) {
        largest = fmax(largest, fabs((double)out[i] - expected[i]));
        scale = fmax(scale, fabs(expected[i]));
    }
    return scale > 0.0 ? largest / scale : largest;
}

int main(void)
{
    double worst = 0.0;
    {
        static const planar2r_real q[4][2] = {
            { 1.249753, -1.515806 },
            { -0.011803, 1.662689 },
            { -1.803803, 1.510417 },
            { 0.231825, 1.114176 },
        };
        static const planar2r_real qd[4][2] = {
            { 0.473249, -1.699241 },
            { 0.506265, -0.94712 },
            { -0.943617, -0.473669 },
            { -1.369869, -1.260397 },
        };
        static const double expected[4][4] = {
            { 0.1119823080005, 0.751528192032, -0.015944640960898666, -0.2896612329874579 },
            { 0.1281521251125, 0.0971765655125, 0.010240311705579024, 0.11112389211026373 },
            { 0.4452065213445, 1.004349802898, 0.04035037827491097, -0.6674690471732186 },
            { 0.9382705385805, 3.459149615378, 0.794338781755376, -1.6169861076863432 },
        };
        double here = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real out[4];
            planar2r_energy_regressor(q[i], qd[i], out);
            here = fmax(here, error_of(out, expected[i], 4));
        }
        printf("energy_regressor %.2e\n", here);
        worst = fmax(worst, here);
    }
    return worst <= 1e-13 ? 0 : 1;
}
