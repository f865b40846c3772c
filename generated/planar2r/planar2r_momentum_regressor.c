/* planar2r: columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq
 * 9 mul, 3 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_momentum_regressor(const double q[2], const double qd[2], double p_out[8], double dl_out[8])
{
    p_out[4] = 0.0;
    p_out[0] = qd[0];
    dl_out[0] = 0.0;
    dl_out[1] = 0.0;
    dl_out[2] = 0.0;
    dl_out[3] = 0.0;
    dl_out[4] = 0.0;
    dl_out[5] = 0.0;
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double L1_1e2 = planar2r_geometry_L1 * S2;
    const double L1_2e2 = planar2r_geometry_L1 * C2;
    const double V2d2 = qd[0] * planar2r_geometry_L1;
    const double V1e2 = S2 * V2d2;
    p_out[7] = -V1e2;
    const double V2e2 = C2 * V2d2;
    p_out[6] = V2e2;
    const double W32 = qd[0] + qd[1];
    p_out[1] = W32;
    p_out[5] = W32;
    const double QMX2_1 = L1_2e2 * W32 + V2e2;
    p_out[2] = QMX2_1;
    const double SMX2_2 = -V1e2 * W32;
    dl_out[6] = SMX2_2;
    const double QMY2_1 = -L1_1e2 * W32 - V1e2;
    p_out[3] = QMY2_1;
    const double SMY2_2 = -V2e2 * W32;
    dl_out[7] = SMY2_2;
}
