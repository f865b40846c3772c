/* planar2r: columns of power: qd' tau = out . X, the rate of energy plus friction
 * 19 mul, 8 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_power_regressor(const double q[2], const double qd[2], const double qdd[2], double out[4])
{
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double V2d2 = qd[0] * planar2r_geometry_L1;
    const double V1e2 = S2 * V2d2;
    const double V2e2 = C2 * V2d2;
    const double W32 = qd[0] + qd[1];
    const double ZP33d2 = qd[0] * qd[0];
    const double Z2d2 = qdd[0] * planar2r_geometry_L1;
    const double Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const double Z1e2 = C2 * Z1d2 + S2 * Z2d2;
    const double Z2e2 = C2 * Z2d2 - S2 * Z1d2;
    const double X32 = qdd[0] + qdd[1];
    const double RZZ1 = qd[0] * qdd[0];
    out[0] = RZZ1;
    const double P332 = W32 * W32;
    const double RZZ2 = W32 * X32;
    out[1] = RZZ2;
    const double RMX2 = V2e2 * X32 + W32 * Z2e2 - V1e2 * P332;
    out[2] = RMX2;
    const double RMY2 = -V1e2 * X32 - V2e2 * P332 - W32 * Z1e2;
    out[3] = RMY2;
}
