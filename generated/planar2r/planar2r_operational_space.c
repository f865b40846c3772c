/* planar2r: operational space of a point in the frame of a link, in frame 0: Lambda = (J M^-1 J')^-1 of the
 * rows of link_jacobian with select 1 (the others 0), J# = M^-1 J' Lambda, and the part (I - J'
 * J#') tau of a torque that does not accelerate these rows
 * 151 mul, 81 add, 8 div, 2 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

static int of_link(const double q[2], size_t link, const double point[3], const double select[6], const double tau[2], const double X[4], double Lambda_out[36], double inverse_out[12], double null_out[2])
{
    const double X_at1 = (double)(link == 1u);
    const double X_at2 = (double)(link == 2u);
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
    const double R3c2 = X_at2 * pd2_2;
    const double t2 = point[0] * R0c2 + point[1] * R0c1 + R3c2;
    const double r2_2 = t2 - pd2_2;
    const double v1_1 = -R2c3 * t2;
    const double v2_1 = -X_at2 * r2_2;
    const double xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const double J33d2_2 = X[1] + xd2_2;
    const double J33s1_2 = X[0] + J33d2_2;
    const double Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    const double d2 = 1.0 / X[1];
    const double l2_1 = Nbm23d2 * d2;
    const double m2_1_1 = J33s1_2 - Nbm23d2 * l2_1;
    const double iD0 = 1.0 / m2_1_1;
    const double y0_0 = v1_1 - v2_1 * l2_1;
    const double y1_0 = v1_2 - v2_2 * l2_1;
    const double y5_0 = R2c3 - X_at2 * l2_1;
    const double z0_0 = iD0 * y0_0;
    const double z0_1 = v2_1 * d2;
    const double z1_0 = iD0 * y1_0;
    const double z5_0 = iD0 * y5_0;
    const double z1_1 = v2_2 * d2;
    const double z5_1 = X_at2 * d2;
    const double m55 = X_at2 * z5_1 + y5_0 * z5_0;
    const double w0_1 = z0_1 - l2_1 * z0_0;
    const double m00 = v2_1 * z0_1 + y0_0 * z0_0;
    const double w1_1 = z1_1 - l2_1 * z1_0;
    const double w5_1 = z5_1 - l2_1 * z5_0;
    const double S00 = select[0] * select[0];
    const double o0 = 1.0 - select[0];
    const double A00 = m00 * S00 + o0 * o0;
    const double m01 = v2_1 * z1_1 + y0_0 * z1_0;
    const double m05 = v2_1 * z5_1 + y0_0 * z5_0;
    const double m11 = v2_2 * z1_1 + y1_0 * z1_0;
    const double m15 = v2_2 * z5_1 + y1_0 * z5_0;
    const double S01 = select[0] * select[1];
    const double A01 = m01 * S01;
    const double S05 = select[0] * select[5];
    const double A05 = m05 * S05;
    const double S11 = select[1] * select[1];
    const double o1 = 1.0 - select[1];
    const double A11 = m11 * S11 + o1 * o1;
    const double S15 = select[1] * select[5];
    const double A15 = m15 * S15;
    const double o2 = 1.0 - select[2];
    const double A22 = o2 * o2;
    const double o3 = 1.0 - select[3];
    const double A33 = o3 * o3;
    const double o4 = 1.0 - select[4];
    const double A44 = o4 * o4;
    const double S55 = select[5] * select[5];
    const double o5 = 1.0 - select[5];
    const double A55 = m55 * S55 + o5 * o5;
    const double b5 = 1024.0 * A55;
    const double e5 = A55 + b5;
    const double g5 = e5 - b5;
    const double ip5 = 1.0 / A55;
    const double u05 = A05 * ip5;
    const double u15 = A15 * ip5;
    const double b4 = 1024.0 * A44;
    const double e4 = A44 + b4;
    const double g4 = e4 - b4;
    const double ip4 = 1.0 / A44;
    const double l44 = select[4] * ip4;
    const double La44 = select[4] * l44;
    Lambda_out[28] = La44;
    const double b3 = 1024.0 * A33;
    const double e3 = A33 + b3;
    const double g3 = e3 - b3;
    const double ip3 = 1.0 / A33;
    const double l33 = select[3] * ip3;
    const double La33 = select[3] * l33;
    Lambda_out[21] = La33;
    const double b2 = 1024.0 * A22;
    const double e2 = A22 + b2;
    const double g2 = e2 - b2;
    const double ip2 = 1.0 / A22;
    const double l22 = select[2] * ip2;
    const double La22 = select[2] * l22;
    Lambda_out[14] = La22;
    const double h15 = A55 * u15;
    const double v01 = A01 - u05 * h15;
    const double p1 = A11 - u15 * h15;
    const double b1 = 1024.0 * A11;
    const double h05 = A55 * u05;
    const double e1 = p1 + b1;
    const double g1 = e1 - b1;
    const double ip1 = 1.0 / p1;
    const double u01 = ip1 * v01;
    const double h01 = p1 * u01;
    const double p0 = A00 - u05 * h05 - u01 * h01;
    const double b0 = 1024.0 * A00;
    const double e0 = p0 + b0;
    const double g0 = e0 - b0;
    const double ip0 = 1.0 / p0;
    const double r0_1 = -u01 * ip0;
    const double r0_5 = -u05 * ip0 - u15 * r0_1;
    const double l05 = select[5] * r0_5;
    const double La05 = select[0] * l05;
    Lambda_out[5] = La05;
    const double r1_1 = ip1 - u01 * r0_1;
    const double t5_1 = -u15 * ip1;
    const double r1_5 = -u05 * r0_1 - u15 * r1_1;
    const double l11 = select[1] * r1_1;
    const double La11 = select[1] * l11;
    Lambda_out[7] = La11;
    const double l15 = select[5] * r1_5;
    const double La15 = select[1] * l15;
    Lambda_out[11] = La15;
    const double s5_0 = u15 * u01 - u05;
    const double t5_0 = ip0 * s5_0;
    const double r5_1 = t5_1 - u01 * t5_0;
    const double r5_5 = ip5 - u05 * t5_0 - u15 * r5_1;
    const double l00 = select[0] * ip0;
    const double La00 = select[0] * l00;
    Lambda_out[0] = La00;
    const double l50 = select[0] * t5_0;
    const double La50 = select[5] * l50;
    Lambda_out[30] = La50;
    const double l51 = select[1] * r5_1;
    const double La51 = select[5] * l51;
    Lambda_out[31] = La51;
    const double l55 = select[5] * r5_5;
    const double La55 = select[5] * l55;
    Lambda_out[35] = La55;
    const double l01 = select[1] * r0_1;
    const double La01 = select[0] * l01;
    Lambda_out[1] = La01;
    const double l10 = select[0] * r0_1;
    const double La10 = select[1] * l10;
    Lambda_out[6] = La10;
    const double c0_0 = z0_0 * La00 + z1_0 * La10 + z5_0 * La50;
    inverse_out[0] = c0_0;
    const double c1_0 = w0_1 * La00 + w1_1 * La10 + w5_1 * La50;
    inverse_out[6] = c1_0;
    const double f0 = tau[0] * c0_0 + tau[1] * c1_0;
    const double c0_1 = z0_0 * La01 + z1_0 * La11 + z5_0 * La51;
    inverse_out[1] = c0_1;
    const double c0_5 = z0_0 * La05 + z1_0 * La15 + z5_0 * La55;
    inverse_out[5] = c0_5;
    const double c1_1 = w0_1 * La01 + w1_1 * La11 + w5_1 * La51;
    inverse_out[7] = c1_1;
    const double c1_5 = w0_1 * La05 + w1_1 * La15 + w5_1 * La55;
    inverse_out[11] = c1_5;
    const double f1 = tau[0] * c0_1 + tau[1] * c1_1;
    const double f5 = tau[0] * c0_5 + tau[1] * c1_5;
    const double N0 = tau[0] - R2c3 * f5 - v1_1 * f0 - v1_2 * f1;
    null_out[0] = N0;
    const double N1 = tau[1] - X_at2 * f5 - v2_1 * f0 - v2_2 * f1;
    null_out[1] = N1;
    const double guard[8] = { X[1], m2_1_1, g5, g4, g3, g2, g1, g0 };
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
