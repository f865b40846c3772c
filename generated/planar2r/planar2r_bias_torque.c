/* planar2r: h = C qd + g + friction
 * 12 mul, 4 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_bias_torque(const double q[2], const double qd[2], const double X[4], double h[2])
{
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double ZP33d2 = qd[0] * qd[0];
    const double Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const double Z1e2 = C2 * Z1d2;
    const double Z2e2 = -S2 * Z1d2;
    const double W32 = qd[0] + qd[1];
    const double P332 = W32 * W32;
    const double F2_1 = -X[2] * P332;
    const double F2_2 = -X[3] * P332;
    const double N2_3 = X[2] * Z2e2 - X[3] * Z1e2;
    h[1] = N2_3;
    const double Fb2e2 = C2 * F2_2 + S2 * F2_1;
    const double Nb3d2 = planar2r_geometry_L1 * Fb2e2 + N2_3;
    h[0] = Nb3d2;
}
