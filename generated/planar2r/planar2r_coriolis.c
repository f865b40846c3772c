/* planar2r: C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric
 * 11 mul, 4 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_coriolis(const double q[2], const double qd[2], const double X[4], double C[4])
{
    C[3] = 0.0;
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double W32 = qd[0] + qd[1];
    const double l1_1d2 = -qd[0] * planar2r_geometry_L1;
    const double l1_1e2 = C2 * l1_1d2;
    const double l1_2e2 = -S2 * l1_1d2;
    const double h2v1_1 = -X[3] * W32;
    const double h2v1_2 = X[2] * W32;
    const double N2v1_3 = X[2] * l1_2e2 - X[3] * l1_1e2;
    C[2] = N2v1_3;
    const double Fbc12e2 = C2 * h2v1_1 - S2 * h2v1_2;
    const double Nbc13d2 = planar2r_geometry_L1 * Fbc12e2 + N2v1_3;
    C[0] = Nbc13d2;
    const double Nbc23d2 = planar2r_geometry_L1 * Fbc12e2;
    C[1] = Nbc23d2;
}
