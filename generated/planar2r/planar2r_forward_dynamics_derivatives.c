/* planar2r: dqdd/dq, dqdd/dqd and dqdd/dtau; the derivative of sign(qd) is 0
 * 72 mul, 35 add, 2 div, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"

#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "the status of this file needs NaN: compile it without -ffast-math and -ffinite-math-only"
#endif
#include "planar2r_math.h"

planar2r_IN_SECTION int planar2r_forward_dynamics_derivatives(const double q[2], const double qd[2], const double tau[2], const double X[4], double dq_out[4], double dqd_out[4], double dtau_out[4])
{
    dq_out[0] = 0.0;
    dq_out[2] = 0.0;
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
    dtau_out[0] = d1;
    const double y2_1 = b1 - b2 * l2_1;
    const double o1 = d1 * y2_1;
    const double o2 = b2 * d2 - l2_1 * o1;
    const double V2d2 = qd[0] * planar2r_geometry_L1;
    const double V1e2 = S2 * V2d2;
    const double V2e2 = C2 * V2d2;
    const double Z2d2 = planar2r_geometry_L1 * o1;
    const double Z1e2_ = C2 * Z1d2 + S2 * Z2d2;
    const double Z2e2_ = C2 * Z2d2 - S2 * Z1d2;
    const double X32 = o1 + o2;
    const double F2_1_ = -X[2] * P332 - X[3] * X32;
    const double F2_2_ = X[2] * X32 - X[3] * P332;
    const double Fb1e2_ = C2 * F2_1_ - S2 * F2_2_;
    const double l2_1_ = -X[3] * W32;
    const double l2_2 = X[2] * W32;
    const double r32 = X[2] * V1e2 + X[3] * V2e2;
    const double R332 = 2.0 * r32;
    const double m2_1e2_ = C2 * l2_1_ - S2 * l2_2;
    const double xd2_2_ = 2.0 * planar2r_geometry_L1 * m2_1e2_;
    const double J33d2_2_ = R332 + xd2_2_;
    const double b2_1 = 2.0 * V2e2;
    const double b2_2 = -2.0 * V1e2;
    const double np2_3 = -X[2] * Z1e2_ - X[3] * Z2e2_;
    const double fq2_1 = -2.0 * l2_2;
    const double fq2_2 = 2.0 * l2_1_;
    const double nq2_3 = X[2] * b2_2 + R332 - X[3] * b2_1;
    const double Nbp23d2 = planar2r_geometry_L1 * Fb1e2_ + np2_3;
    const double Fbq22e2 = C2 * fq2_2 + S2 * fq2_1;
    const double Nbq23d2 = planar2r_geometry_L1 * Fbq22e2 + nq2_3;
    const double i1_2 = -l2_1 * d1;
    dtau_out[1] = i1_2;
    dtau_out[2] = i1_2;
    const double y2_1_ = J33d2_2_ - l2_1 * R332;
    const double v1_1 = d1 * y2_1_;
    dqd_out[0] = -v1_1;
    const double v1_2 = d2 * R332 - l2_1 * v1_1;
    dqd_out[2] = -v1_2;
    const double i2_2 = d2 - l2_1 * i1_2;
    dtau_out[3] = i2_2;
    const double y2_1__ = Nbp23d2 - l2_1 * np2_3;
    const double u2_1 = d1 * y2_1__;
    dq_out[1] = -u2_1;
    const double u2_2 = d2 * np2_3 - l2_1 * u2_1;
    dq_out[3] = -u2_2;
    const double y2_1___ = Nbq23d2 - l2_1 * nq2_3;
    const double v2_1 = d1 * y2_1___;
    dqd_out[1] = -v2_1;
    const double v2_2 = d2 * nq2_3 - l2_1 * v2_1;
    dqd_out[3] = -v2_2;
    const double guard[2] = { X[1], m2_1_1 };
    int status = planar2r_OK;
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!(guard[i] > 0.0)) {
            status = (guard[i] <= 0.0) ? planar2r_NOT_POSITIVE_DEFINITE : planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 4u) && (status == 0); ++i) {
        if (!((dq_out[i] - dq_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 4u) && (status == 0); ++i) {
        if (!((dqd_out[i] - dqd_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 4u) && (status == 0); ++i) {
        if (!((dtau_out[i] - dtau_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    return status;
}
