/* planar2r: C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric
 * 11 mul, 4 add, 1 sincos for one sample.
 */
#include "planar2r.h"

#include <math.h>

void planar2r_coriolis(const double *q, const double *qd, const double *X, double *C)
{
    const double C2 = cos(q[1]);
    const double S2 = sin(q[1]);
    const double W32 = qd[0] + qd[1];
    const double l1_1d2 = -qd[0] * planar2r_geometry_L1;
    const double l1_1e2 = C2 * l1_1d2;
    const double l1_2e2 = -S2 * l1_1d2;
    const double h2v1_1 = -X[3] * W32;
    const double h2v1_2 = X[2] * W32;
    const double N2v1_3 = X[2] * l1_2e2 - X[3] * l1_1e2;
    const double Fbc12e2 = C2 * h2v1_1 - S2 * h2v1_2;
    const double Nbc13d2 = planar2r_geometry_L1 * Fbc12e2 + N2v1_3;
    const double Nbc23d2 = planar2r_geometry_L1 * Fbc12e2;
    C[0] = Nbc13d2;
    C[1] = Nbc23d2;
    C[2] = N2v1_3;
    C[3] = 0.0;
}

void planar2r_coriolis_batch(size_t N, const double *q, const double *qd, const double *X, double *C)
{
    for (size_t k = 0; k < N; ++k) {
        planar2r_coriolis(&q[k * 2u], &qd[k * 2u], X, &C[k * 4u]);
    }
}
