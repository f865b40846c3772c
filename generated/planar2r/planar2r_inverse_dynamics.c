/* planar2r: torque of a motion: tau = M qdd + C qd + g + friction
 * 19 mul, 11 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_inverse_dynamics(const double q[2], const double qd[2], const double qdd[2], const double X[4], double tau[2])
{
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double ZP33d2 = qd[0] * qd[0];
    const double Z2d2 = qdd[0] * planar2r_geometry_L1;
    const double Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const double Z1e2 = C2 * Z1d2 + S2 * Z2d2;
    const double Z2e2 = C2 * Z2d2 - S2 * Z1d2;
    const double X32 = qdd[0] + qdd[1];
    const double W32 = qd[0] + qd[1];
    const double N1_3 = qdd[0] * X[0];
    const double P332 = W32 * W32;
    const double F2_1 = -X[2] * P332 - X[3] * X32;
    const double F2_2 = X[2] * X32 - X[3] * P332;
    const double N2_3 = X[1] * X32 + X[2] * Z2e2 - X[3] * Z1e2;
    tau[1] = N2_3;
    const double Fb2e2 = C2 * F2_2 + S2 * F2_1;
    const double Nb3d2 = planar2r_geometry_L1 * Fb2e2 + N2_3;
    const double Ns1_2_3 = N1_3 + Nb3d2;
    tau[0] = Ns1_2_3;
}
