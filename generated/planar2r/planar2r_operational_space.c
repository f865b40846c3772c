/* planar2r: operational space of a point in the frame of a link, in frame 0: Lambda = (J M^-1 J')^-1 of the
 * rows of link_jacobian with select 1 (the others 0), J# = M^-1 J' Lambda, and the part (I - J'
 * J#') tau of a torque that does not accelerate these rows; not 0 where these rows depend on each
 * other, or M is not positive definite
 * 157 mul, 96 add, 10 div, 2 sincos, 6 other for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

#include <math.h>

static int of_link(const double q[2], size_t link, const double point[3], const double select[6], const double tau[2], const double X[4], double Lambda_out[36], double inverse_out[12], double null_out[2])
{
    const double X_at1 = (double)(link == 1u);
    const double X_at2 = (double)(link == 2u);
    const double thirds = 1.3333333333333333;
    Lambda_out[2] = 0.0;
    Lambda_out[3] = 0.0;
    Lambda_out[4] = 0.0;
    Lambda_out[8] = 0.0;
    Lambda_out[9] = 0.0;
    Lambda_out[10] = 0.0;
    Lambda_out[12] = 0.0;
    Lambda_out[13] = 0.0;
    Lambda_out[15] = 0.0;
    Lambda_out[16] = 0.0;
    Lambda_out[17] = 0.0;
    Lambda_out[18] = 0.0;
    Lambda_out[19] = 0.0;
    Lambda_out[20] = 0.0;
    Lambda_out[22] = 0.0;
    Lambda_out[23] = 0.0;
    Lambda_out[24] = 0.0;
    Lambda_out[25] = 0.0;
    Lambda_out[26] = 0.0;
    Lambda_out[27] = 0.0;
    Lambda_out[29] = 0.0;
    Lambda_out[32] = 0.0;
    Lambda_out[33] = 0.0;
    Lambda_out[34] = 0.0;
    inverse_out[2] = 0.0;
    inverse_out[3] = 0.0;
    inverse_out[4] = 0.0;
    inverse_out[8] = 0.0;
    inverse_out[9] = 0.0;
    inverse_out[10] = 0.0;
    const planar2r_angles2 q_0 = planar2r_sincos2(q);
    const double C1 = q_0.c[0];
    const double S1 = q_0.s[0];
    const double C2 = q_0.c[1];
    const double S2 = q_0.s[1];
    const double pd2_1 = planar2r_geometry_L1 * C1;
    const double pd2_2 = planar2r_geometry_L1 * S1;
    const double R1e2_1 = C1 * C2 - S1 * S2;
    const double R0c1 = X_at1 * C1 + X_at2 * R1e2_1;
    const double R1e2_2 = C1 * S2 + S1 * C2;
    const double R0c2 = X_at1 * S1 + X_at2 * R1e2_2;
    const double m2_1e2 = X[2] * C2 - X[3] * S2;
    const double R2c3 = X_at1 + X_at2;
    const double R3c1 = X_at2 * pd2_1;
    const double t1 = point[0] * R0c1 + R3c1 - point[1] * R0c2;
    const double r2_1 = t1 - pd2_1;
    const double v1_2 = R2c3 * t1;
    const double v2_2 = X_at2 * r2_1;
    const double j1_1 = select[1] * v1_2;
    const double j1_2 = select[1] * v2_2;
    const double R3c2 = X_at2 * pd2_2;
    const double t2 = point[0] * R0c2 + point[1] * R0c1 + R3c2;
    const double r2_2 = t2 - pd2_2;
    const double v1_1 = -R2c3 * t2;
    const double v2_1 = -X_at2 * r2_2;
    const double j0_1 = select[0] * v1_1;
    const double j0_2 = select[0] * v2_1;
    const double j5_1 = select[5] * R2c3;
    const double xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const double J33d2_2 = X[1] + xd2_2;
    const double J33s1_2 = X[0] + J33d2_2;
    const double Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    const double d2 = 1.0 / X[1];
    const double l2_1 = Nbm23d2 * d2;
    const double m2_1_1 = J33s1_2 - Nbm23d2 * l2_1;
    const double iD0 = 1.0 / m2_1_1;
    const double j5_2 = X_at2 * select[5];
    const double o0 = 1.0 - select[0];
    const double o1 = 1.0 - select[1];
    const double o2 = 1.0 - select[2];
    const double ks2 = o2 * o2;
    const double o3 = 1.0 - select[3];
    const double ks3 = o3 * o3;
    const double o4 = 1.0 - select[4];
    const double ks4 = o4 * o4;
    const double o5 = 1.0 - select[5];
    const double ks0 = j0_1 * j0_1 + j0_2 * j0_2 + o0 * o0;
    const double ki0 = 1.0 / ks0;
    const double kd01 = j0_1 * j1_1 + j0_2 * j1_2;
    const double kr01 = ki0 * kd01;
    const double kq01_1 = j1_1 - j0_1 * kr01;
    const double kq01_2 = j1_2 - j0_2 * kr01;
    const double ks1 = o1 * o1 + kq01_1 * kq01_1 + kq01_2 * kq01_2;
    const double ki1 = 1.0 / ks1;
    const double ki2 = 1.0 / ks2;
    const double e3 = select[2] * ki2;
    Lambda_out[14] = e3;
    const double ki3 = 1.0 / ks3;
    const double e4 = select[3] * ki3;
    Lambda_out[21] = e4;
    const double ki4 = 1.0 / ks4;
    const double e5 = select[4] * ki4;
    Lambda_out[28] = e5;
    const double kd05 = j0_1 * j5_1 + j0_2 * j5_2;
    const double kr05 = ki0 * kd05;
    const double kq05_1 = j5_1 - j0_1 * kr05;
    const double kq05_2 = j5_2 - j0_2 * kr05;
    const double kd15 = kq01_1 * kq05_1 + kq01_2 * kq05_2;
    const double kr15 = ki1 * kd15;
    const double kq15_1 = kq05_1 - kq01_1 * kr15;
    const double kq15_2 = kq05_2 - kq01_2 * kr15;
    const double ks5 = o5 * o5 + kq15_1 * kq15_1 + kq15_2 * kq15_2;
    const double kT05 = kr01 * kr15 - kr05;
    const double a01 = fabs(kr01);
    const double a05 = fabs(kT05);
    const double a15 = fabs(kr15);
    const double y0_0 = j0_1 - l2_1 * j0_2;
    const double y1_0 = j1_1 - l2_1 * j1_2;
    const double y5_0 = j5_1 - l2_1 * j5_2;
    const double tw0_1 = iD0 * y0_0;
    const double tw0_2 = d2 * j0_2;
    const double ts0 = j0_2 * tw0_2 + o0 * o0 + y0_0 * tw0_1;
    const double ti0 = 1.0 / ts0;
    const double td01 = j1_2 * tw0_2 + y1_0 * tw0_1;
    const double tr01 = ti0 * td01;
    const double tq01_1 = y1_0 - y0_0 * tr01;
    const double tq01_2 = j1_2 - j0_2 * tr01;
    const double tw1_1 = iD0 * tq01_1;
    const double tw1_2 = d2 * tq01_2;
    const double ts1 = o1 * o1 + tq01_1 * tw1_1 + tq01_2 * tw1_2;
    const double ti1 = 1.0 / ts1;
    const double td05 = j5_2 * tw0_2 + y5_0 * tw0_1;
    const double tr05 = ti0 * td05;
    const double tq05_1 = y5_0 - y0_0 * tr05;
    const double e1 = select[0] * ti0;
    const double z0_1 = tw0_1 * e1;
    const double z0_2 = tw0_2 * e1;
    const double w0_1 = z0_2 - l2_1 * z0_1;
    const double tq05_2 = j5_2 - j0_2 * tr05;
    const double td15 = tw1_1 * tq05_1 + tw1_2 * tq05_2;
    const double tr15 = ti1 * td15;
    const double tq15_1 = tq05_1 - tq01_1 * tr15;
    const double tq15_2 = tq05_2 - tq01_2 * tr15;
    const double tw5_1 = iD0 * tq15_1;
    const double tw5_2 = d2 * tq15_2;
    const double ts5 = o5 * o5 + tq15_1 * tw5_1 + tq15_2 * tw5_2;
    const double ti5 = 1.0 / ts5;
    const double tT05 = tr01 * tr15 - tr05;
    const double e2 = select[1] * ti1;
    const double e6 = select[5] * ti5;
    Lambda_out[35] = e6;
    const double z1_1 = tw1_1 * e2;
    const double z1_2 = tw1_2 * e2;
    const double z5_1 = tw5_1 * e6;
    inverse_out[5] = z5_1;
    const double z5_2 = tw5_2 * e6;
    const double w1_1 = z1_2 - l2_1 * z1_1;
    const double w5_1 = z5_2 - l2_1 * z5_1;
    inverse_out[11] = w5_1;
    const double c0_1 = tT05 * z5_1 + z0_1 - tr01 * z1_1;
    inverse_out[0] = c0_1;
    const double c0_2 = z1_1 - tr15 * z5_1;
    inverse_out[1] = c0_2;
    const double c1_1 = tT05 * w5_1 + w0_1 - tr01 * w1_1;
    inverse_out[6] = c1_1;
    const double c1_2 = w1_1 - tr15 * w5_1;
    inverse_out[7] = c1_2;
    const double f1 = tau[0] * c0_1 + tau[1] * c1_1;
    const double f2 = tau[0] * c0_2 + tau[1] * c1_2;
    const double f6 = tau[0] * z5_1 + tau[1] * w5_1;
    const double N0 = tau[0] - j0_1 * f1 - j1_1 * f2 - j5_1 * f6;
    null_out[0] = N0;
    const double N1 = tau[1] - j0_2 * f1 - j1_2 * f2 - j5_2 * f6;
    null_out[1] = N1;
    const double h0_2 = -tr01 * e2;
    const double h0_6 = tT05 * e6;
    Lambda_out[5] = h0_6;
    Lambda_out[30] = h0_6;
    const double h1_6 = -tr15 * e6;
    Lambda_out[11] = h1_6;
    Lambda_out[31] = h1_6;
    const double La00 = tT05 * h0_6 + e1 - tr01 * h0_2;
    Lambda_out[0] = La00;
    const double La01 = h0_2 - tr15 * h0_6;
    Lambda_out[1] = La01;
    Lambda_out[6] = La01;
    const double La11 = e2 - tr15 * h1_6;
    Lambda_out[7] = La11;
    const double rho = 0.5 * X_at2;
    const double sizeX_c1 = fabs(point[0]);
    const double sizeX_c2 = fabs(point[1]);
    const double sizeX_c3 = fabs(point[2]);
    const double reach = rho + sizeX_c1 + sizeX_c2 + sizeX_c3;
    const double axes = 47.1 * X_at1 + 54.2 * X_at2;
    const double levers = 77.3 * X_at1 + 100.6 * X_at2;
    const double swung = reach * levers;
    const double turning = 1.42 * X_at2 + X_at1;
    const double offv = turning * swung;
    const double offw = axes * turning;
    const double third = thirds - 1.0;
    const double epsilon = 3.0 * third - 1.0;
    const double roundoff = 0.5 * epsilon;
    const double off0 = offv * roundoff;
    const double off1 = offw * roundoff;
    const double g0 = ks0 - off0 * off0;
    const double l1 = off0 + off0 * a01;
    const double g1 = ks1 - l1 * l1;
    const double g2 = ks2 - off0 * off0;
    const double g3 = ks3 - off1 * off1;
    const double g4 = ks4 - off1 * off1;
    const double l5 = off0 * a05 + off0 * a15 + off1;
    const double g5 = ks5 - l5 * l5;
    const double guard[8] = { X[1], m2_1_1, g0, g1, g2, g3, g4, g5 };
    int status = planar2r_OK;
    for (size_t i = 0u; (i < 8u) && (status == 0); ++i) {
        if (!(guard[i] > 0.0)) {
            status = (guard[i] <= 0.0) ? planar2r_NOT_POSITIVE_DEFINITE : planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 36u) && (status == 0); ++i) {
        if (!((Lambda_out[i] - Lambda_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 12u) && (status == 0); ++i) {
        if (!((inverse_out[i] - inverse_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!((null_out[i] - null_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    return status;
}

int planar2r_operational_space(const double q[2], size_t link, const double point[3], const double select[6], const double tau[2], const double X[4], double Lambda_out[36], double inverse_out[12], double null_out[2])
{
    int status = planar2r_NO_SUCH_LINK;
    if ((link >= 1u) && (link <= 2u)) {
        status = of_link(q, link, point, select, tau, X, Lambda_out, inverse_out, null_out);
    }
    return status;
}

int planar2r_operational_space_batch(size_t N, const double *q, size_t link, const double *point, const double *select, const double *tau, const double *X, double *Lambda_out, double *inverse_out, double *null_out)
{
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= planar2r_operational_space(&q[k * 2u], link, &point[k * 3u], &select[k * 6u], &tau[k * 2u], X, &Lambda_out[k * 36u], &inverse_out[k * 12u], &null_out[k * 2u]);
    }
    return status;
}
