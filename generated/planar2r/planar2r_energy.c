/* planar2r: kinetic energy T and potential energy U, U up to a constant
 * 13 mul, 4 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_energy(const double q[2], const double qd[2], const double X[4], double T_out[1], double U_out[1])
{
    U_out[0] = 0.0;
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double V2d2 = qd[0] * planar2r_geometry_L1;
    const double V1e2 = S2 * V2d2;
    const double V2e2 = C2 * V2d2;
    const double W32 = qd[0] + qd[1];
    const double Hqd1 = 0.5 * qd[0];
    const double DZZ1 = qd[0] * Hqd1;
    const double HW32 = 0.5 * W32;
    const double DZZ2 = W32 * HW32;
    const double DMX2 = V2e2 * W32;
    const double DMY2 = -V1e2 * W32;
    const double Tsum = X[0] * DZZ1 + X[1] * DZZ2 + X[2] * DMX2 + X[3] * DMY2;
    T_out[0] = Tsum;
}
