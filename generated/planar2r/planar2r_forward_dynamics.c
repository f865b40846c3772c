/* planar2r: accelerations under torques tau; not 0 where M is not positive definite
 * 23 mul, 13 add, 2 div, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"

#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "the status of this file needs NaN: compile it without -ffast-math and -ffinite-math-only"
#endif
#include "planar2r_math.h"

planar2r_IN_SECTION int planar2r_forward_dynamics(const double q[2], const double qd[2], const double tau[2], const double X[4], double qdd[2])
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
    const double Fb2e2 = C2 * F2_2 + S2 * F2_1;
    const double Nb3d2 = planar2r_geometry_L1 * Fb2e2 + N2_3;
    const double b1 = tau[0] - Nb3d2;
    const double b2 = tau[1] - N2_3;
    const double m2_1e2 = X[2] * C2 - X[3] * S2;
    const double xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const double J33d2_2 = X[1] + xd2_2;
    const double J33s1_2 = X[0] + J33d2_2;
    const double Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    const double d2 = 1.0 / X[1];
    const double l2_1 = Nbm23d2 * d2;
    const double m2_1_1 = J33s1_2 - Nbm23d2 * l2_1;
    const double d1 = 1.0 / m2_1_1;
    const double y2_1 = b1 - b2 * l2_1;
    const double o1 = d1 * y2_1;
    qdd[0] = o1;
    const double o2 = b2 * d2 - l2_1 * o1;
    qdd[1] = o2;
    const double guard[2] = { X[1], m2_1_1 };
    int status = planar2r_OK;
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!(guard[i] > 0.0)) {
            status = (guard[i] <= 0.0) ? planar2r_NOT_POSITIVE_DEFINITE : planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!((qdd[i] - qdd[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    return status;
}
