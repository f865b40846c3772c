/* planar2r: columns of torque: tau = out X, friction included
 * 14 mul, 8 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_torque_regressor(const double q[2], const double qd[2], const double qdd[2], double out[8])
{
    out[4] = 0.0;
    out[0] = qdd[0];
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double L1_1e2 = planar2r_geometry_L1 * S2;
    const double L1_2e2 = planar2r_geometry_L1 * C2;
    const double W32 = qd[0] + qd[1];
    const double ZP33d2 = qd[0] * qd[0];
    const double Z2d2 = qdd[0] * planar2r_geometry_L1;
    const double Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const double Z1e2 = C2 * Z1d2 + S2 * Z2d2;
    out[7] = -Z1e2;
    const double Z2e2 = C2 * Z2d2 - S2 * Z1d2;
    out[6] = Z2e2;
    const double X32 = qdd[0] + qdd[1];
    out[1] = X32;
    out[5] = X32;
    const double P332 = W32 * W32;
    const double TMX2_1 = L1_2e2 * X32 + Z2e2 - L1_1e2 * P332;
    out[2] = TMX2_1;
    const double TMY2_1 = -L1_1e2 * X32 - L1_2e2 * P332 - Z1e2;
    out[3] = TMY2_1;
}
