/* planar2r: dtau/dq and dtau/dqd; dtau/dqdd is mass_matrix; the derivative of sign(qd) is 0
 * 38 mul, 16 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_inverse_dynamics_derivatives(const double q[2], const double qd[2], const double qdd[2], const double X[4], double dq_out[4], double dqd_out[4])
{
    dq_out[0] = 0.0;
    dq_out[2] = 0.0;
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
    const double P332 = W32 * W32;
    const double F2_1 = -X[2] * P332 - X[3] * X32;
    const double F2_2 = X[2] * X32 - X[3] * P332;
    const double Fb1e2 = C2 * F2_1 - S2 * F2_2;
    const double l2_1 = -X[3] * W32;
    const double l2_2 = X[2] * W32;
    const double r32 = X[2] * V1e2 + X[3] * V2e2;
    const double R332 = 2.0 * r32;
    dqd_out[2] = R332;
    const double m2_1e2_ = C2 * l2_1 - S2 * l2_2;
    const double xd2_2_ = 2.0 * planar2r_geometry_L1 * m2_1e2_;
    const double J33d2_2_ = R332 + xd2_2_;
    dqd_out[0] = J33d2_2_;
    const double b2_1 = 2.0 * V2e2;
    const double b2_2 = -2.0 * V1e2;
    const double np2_3 = -X[2] * Z1e2 - X[3] * Z2e2;
    dq_out[3] = np2_3;
    const double fq2_1 = -2.0 * l2_2;
    const double fq2_2 = 2.0 * l2_1;
    const double nq2_3 = X[2] * b2_2 + R332 - X[3] * b2_1;
    dqd_out[3] = nq2_3;
    const double Nbp23d2 = planar2r_geometry_L1 * Fb1e2 + np2_3;
    dq_out[1] = Nbp23d2;
    const double Fbq22e2 = C2 * fq2_2 + S2 * fq2_1;
    const double Nbq23d2 = planar2r_geometry_L1 * Fbq22e2 + nq2_3;
    dqd_out[1] = Nbq23d2;
}
