/* planar2r: p = M qd and rate = C' qd - g: dp/dt = tau - friction + rate
 * 14 mul, 7 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_generalized_momentum(const double q[2], const double qd[2], const double X[4], double p_out[2], double rate_out[2])
{
    rate_out[0] = 0.0;
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double V2d2 = qd[0] * planar2r_geometry_L1;
    const double V1e2 = S2 * V2d2;
    const double V2e2 = C2 * V2d2;
    const double W32 = qd[0] + qd[1];
    const double k1_3 = qd[0] * X[0];
    const double l2_1 = -X[3] * W32;
    const double l2_2 = X[2] * W32;
    const double k2_3 = X[1] * W32 + X[2] * V2e2 - X[3] * V1e2;
    p_out[1] = k2_3;
    const double Fbk2e2 = C2 * l2_2 + S2 * l2_1;
    const double Nbk3d2 = planar2r_geometry_L1 * Fbk2e2 + k2_3;
    const double Nks1_2_3 = k1_3 + Nbk3d2;
    p_out[0] = Nks1_2_3;
    const double r2 = V2e2 * l2_1 - V1e2 * l2_2;
    rate_out[1] = r2;
}
