/* twin: M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with L from
 * its last row
 * 123 mul, 107 add, 6 div, 5 sincos for one sample, as written here.
 */
#include "twin.h"
#include "twin_math.h"

int twin_mass_matrix_factor(const double q[7], const double X[44], double L_out[49], double D_out[7])
{
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    L_out[7] = 0.0;
    L_out[11] = 0.0;
    L_out[12] = 0.0;
    L_out[13] = 0.0;
    L_out[14] = 0.0;
    L_out[15] = 0.0;
    L_out[18] = 0.0;
    L_out[19] = 0.0;
    L_out[20] = 0.0;
    L_out[21] = 0.0;
    L_out[22] = 0.0;
    L_out[23] = 0.0;
    L_out[25] = 0.0;
    L_out[26] = 0.0;
    L_out[27] = 0.0;
    L_out[28] = 0.0;
    L_out[29] = 0.0;
    L_out[30] = 0.0;
    L_out[31] = 0.0;
    L_out[35] = 0.0;
    L_out[36] = 0.0;
    L_out[37] = 0.0;
    L_out[38] = 0.0;
    L_out[39] = 0.0;
    L_out[42] = 0.0;
    L_out[43] = 0.0;
    L_out[44] = 0.0;
    L_out[45] = 0.0;
    L_out[46] = 0.0;
    L_out[47] = 0.0;
    L_out[0] = 1.0;
    L_out[8] = 1.0;
    L_out[16] = 1.0;
    L_out[24] = 1.0;
    L_out[32] = 1.0;
    L_out[40] = 1.0;
    L_out[48] = 1.0;
    const twin_angles4 q_1 = twin_sincos4(&q[1]);
    const twin_angles1 q_6 = twin_sincos1(&q[6]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double C3 = q_1.c[1];
    const double S3 = q_1.s[1];
    const double C4 = q_1.c[2];
    const double S4 = q_1.s[2];
    const double C5 = q_1.c[3];
    const double S5 = q_1.s[3];
    const double R6 = q[5] + d3;
    const double C7 = q_6.c[0];
    const double S7 = q_6.s[0];
    const double Te7_7 = 2.0 * X[37];
    const double ze7_7 = X[36] * S7 + C7 * Te7_7;
    const double J11e7_7 = X[36] - S7 * ze7_7;
    const double J22e7_7 = S7 * ze7_7;
    const double J12e7_7 = C7 * ze7_7 - X[37];
    const double J13e7_7 = X[38] * C7 - X[39] * S7;
    const double J23e7_7 = X[38] * S7 + X[39] * C7;
    const double m7_1e7 = X[41] * C7 - X[42] * S7;
    const double m7_2e7 = X[41] * S7 + X[42] * C7;
    const double m1s6_7 = X[31] + m7_1e7;
    const double J13r6_6 = -R6 * m1s6_7 - J12e7_7;
    const double J12s5_6 = X[25] - J13r6_6;
    const double Te5_5 = 2.0 * J12s5_6;
    const double m3s6_7 = X[33] - m7_2e7;
    const double Nbm72r6 = X[40] - R6 * m7_2e7;
    const double wr6_6 = X[34] * R6;
    const double xr6_6 = R6 * (2.0 * m3s6_7 + wr6_6);
    const double J11r6_6 = J11e7_7 + xr6_6;
    const double J22r6_6 = X[40] + xr6_6;
    const double J23r6_6 = -X[32] * R6 - J23e7_7;
    const double m3r6_6 = m3s6_7 + wr6_6;
    const double J11s5_6 = X[24] + J11r6_6;
    const double J23s5_6 = X[27] - J23r6_6;
    const double J33s5_6 = X[28] + J22r6_6;
    const double m2s5_6 = X[30] - m3r6_6;
    const double De5_5 = J11s5_6 - J22e7_7;
    const double ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const double J22e5_5 = S5 * ze5_5 + J22e7_7;
    const double Nbm72e5 = C5 * J23e7_7 + S5 * J13e7_7;
    const double J13s5_6 = X[26] + J13e7_7;
    const double J23e5_5 = C5 * J23s5_6 + S5 * J13s5_6;
    const double m1s5_6 = X[29] + m1s6_7;
    const double m5_1e5 = C5 * m1s5_6 - S5 * m2s5_6;
    const double Nbm62e5 = X[32] * S5;
    const double wd5_5 = X[34] * d2;
    const double xd5_5 = d2 * (2.0 * m5_1e5 + wd5_5);
    const double J22d5_5 = J22e5_5 + xd5_5;
    const double J33s1_5 = X[0] + J22d5_5;
    const double J13r4_4 = X[18] - X[21] * r4;
    const double J23r4_4 = X[19] - X[22] * r4;
    const double Te4_4 = 2.0 * X[17];
    const double ze4_4 = X[16] * S4 + C4 * Te4_4;
    const double J11e4_4 = X[16] - S4 * ze4_4;
    const double J11s3_4 = X[8] + J11e4_4;
    const double J22e4_4 = S4 * ze4_4;
    const double J12e4_4 = C4 * ze4_4 - X[17];
    const double J13s3_4 = X[10] + J12e4_4;
    const double J33s3_4 = X[12] + J22e4_4;
    const double J13e4_4 = C4 * J13r4_4 - S4 * J23r4_4;
    const double J23e4_4 = C4 * J23r4_4 + S4 * J13r4_4;
    const double m4_1e4 = X[21] * C4 - X[22] * S4;
    const double m4_2e4 = X[21] * S4 + X[22] * C4;
    const double J12s3_4 = X[9] - J13e4_4;
    const double J23s3_4 = X[11] - J23e4_4;
    const double m1s3_4 = X[13] + m4_1e4;
    const double De3_3 = J11s3_4 - X[20];
    const double Te3_3 = 2.0 * J12s3_4;
    const double ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const double J11e3_3 = J11s3_4 - S3 * ze3_3;
    const double J12e3_3 = C3 * ze3_3 - J12s3_4;
    const double J22e3_3 = X[20] + S3 * ze3_3;
    const double J11s2_3 = X[1] + J11e3_3;
    const double J13e3_3 = C3 * J13s3_4 - S3 * J23s3_4;
    const double J23e3_3 = C3 * J23s3_4 + S3 * J13s3_4;
    const double m3_1e3 = C3 * m1s3_4 - X[14] * S3;
    const double m3_2e3 = X[14] * C3 + S3 * m1s3_4;
    const double J12d3_3 = J12e3_3 - d3 * m3_2e3;
    const double J12s2_3 = X[2] + J12d3_3;
    const double m2s2_3 = X[7] + m3_2e3;
    const double Te2_2 = 2.0 * J12s2_3;
    const double xd3_3 = 2.0 * d3 * m3_1e3;
    const double J22d3_3 = J22e3_3 + xd3_3;
    const double J33d3_3 = J33s3_4 + xd3_3;
    const double J33s2_3 = X[5] + J33d3_3;
    const double De2_2 = J11s2_3 - J22d3_3;
    const double ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const double J22e2_2 = S2 * ze2_2 + J22d3_3;
    const double J13d3_3 = J13e3_3 - d3 * m4_2e4;
    const double J13s2_3 = X[3] + J13d3_3;
    const double Nbm32e2 = C2 * J23e3_3 + S2 * J13e3_3;
    const double J23s2_3 = X[4] + J23e3_3;
    const double J23e2_2 = C2 * J23s2_3 + S2 * J13s2_3;
    const double Fbm42e3 = -S3 * m4_2e4;
    const double Nbm43d3 = d3 * Fbm42e3 + J23e4_4;
    const double m1s2_3 = X[6] + m3_1e3;
    const double m2_1e2 = C2 * m1s2_3 - S2 * m2s2_3;
    const double xd2_2 = 2.0 * d2 * m2_1e2;
    const double J22d2_2 = J22e2_2 + xd2_2;
    const double J33s1_2 = J33s1_5 + J22d2_2;
    const double Nbm33d3 = d3 * m3_1e3 + J33s3_4;
    const double M3_3 = X[15] + J33s3_4;
    const double Nbm41e3 = X[20] * S3 + C3 * J13e4_4;
    const double Nbm42e3 = S3 * J13e4_4 - X[20] * C3;
    const double Nbm42d3 = Nbm42e3 - d3 * m4_1e4;
    const double Nbm42e2 = C2 * Nbm42d3 + S2 * Nbm41e3;
    const double Nbm42d2 = Nbm42e2 - d2 * m4_1e4;
    const double M4_4 = X[20] + X[23];
    D_out[3] = M4_4;
    const double d4 = 1.0 / M4_4;
    const double M6_6 = X[34] + X[35];
    const double M7_7 = X[40] + X[43];
    D_out[6] = M7_7;
    const double d7 = 1.0 / M7_7;
    const double l7_1 = Nbm72e5 * d7;
    L_out[6] = l7_1;
    const double m7_1_1 = J33s1_2 - Nbm72e5 * l7_1;
    const double l7_5 = Nbm72r6 * d7;
    L_out[34] = l7_5;
    const double l7_6 = -m7_1e7 * d7;
    L_out[41] = l7_6;
    const double m7_5_1 = J23e5_5 - Nbm72e5 * l7_5;
    const double m7_5_5 = J33s5_6 - Nbm72r6 * l7_5;
    const double m7_6_1 = Nbm62e5 - Nbm72e5 * l7_6;
    const double m7_6_5 = -m1s6_7 - Nbm72r6 * l7_6;
    const double m7_6_6 = m7_1e7 * l7_6 + M6_6;
    D_out[5] = m7_6_6;
    const double d6 = 1.0 / m7_6_6;
    const double l6_1 = m7_6_1 * d6;
    L_out[5] = l6_1;
    const double l6_5 = m7_6_5 * d6;
    L_out[33] = l6_5;
    const double m6_1_1 = m7_1_1 - m7_6_1 * l6_1;
    const double m6_5_1 = m7_5_1 - m7_6_1 * l6_5;
    const double m6_5_5 = m7_5_5 - m7_6_5 * l6_5;
    D_out[4] = m6_5_5;
    const double d5 = 1.0 / m6_5_5;
    const double l5_1 = m6_5_1 * d5;
    L_out[4] = l5_1;
    const double m5_1_1 = m6_1_1 - m6_5_1 * l5_1;
    const double l4_1 = Nbm42d2 * d4;
    L_out[3] = l4_1;
    const double m4_1_1 = m5_1_1 - Nbm42d2 * l4_1;
    const double l4_2 = Nbm43d3 * d4;
    L_out[10] = l4_2;
    const double l4_3 = J23e4_4 * d4;
    L_out[17] = l4_3;
    const double m4_2_1 = J23e2_2 - Nbm42d2 * l4_2;
    const double m4_2_2 = J33s2_3 - Nbm43d3 * l4_2;
    const double m4_3_1 = Nbm32e2 - Nbm42d2 * l4_3;
    const double m4_3_2 = Nbm33d3 - Nbm43d3 * l4_3;
    const double m4_3_3 = M3_3 - J23e4_4 * l4_3;
    D_out[2] = m4_3_3;
    const double d3_ = 1.0 / m4_3_3;
    const double l3_1 = m4_3_1 * d3_;
    L_out[2] = l3_1;
    const double l3_2 = m4_3_2 * d3_;
    L_out[9] = l3_2;
    const double m3_1_1 = m4_1_1 - m4_3_1 * l3_1;
    const double m3_2_1 = m4_2_1 - m4_3_1 * l3_2;
    const double m3_2_2 = m4_2_2 - m4_3_2 * l3_2;
    D_out[1] = m3_2_2;
    const double d2_ = 1.0 / m3_2_2;
    const double l2_1 = m3_2_1 * d2_;
    L_out[1] = l2_1;
    const double m2_1_1 = m3_1_1 - m3_2_1 * l2_1;
    D_out[0] = m2_1_1;
    const double guard[7] = { m2_1_1, m3_2_2, m4_3_3, M4_4, m6_5_5, m7_6_6, M7_7 };
    int status = twin_OK;
    for (size_t i = 0u; (i < 7u) && (status == 0); ++i) {
        if (!(guard[i] > 0.0)) {
            status = (guard[i] <= 0.0) ? twin_NOT_POSITIVE_DEFINITE : twin_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 49u) && (status == 0); ++i) {
        if (!((L_out[i] - L_out[i]) == 0.0)) {
            status = twin_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 7u) && (status == 0); ++i) {
        if (!((D_out[i] - D_out[i]) == 0.0)) {
            status = twin_NOT_FINITE;
        }
    }
    return status;
}

int twin_mass_matrix_factor_batch(size_t N, const double *q, const double *X, double *L_out, double *D_out)
{
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= twin_mass_matrix_factor(&q[k * 7u], X, &L_out[k * 49u], &D_out[k * 7u]);
    }
    return status;
}
