/* rx90: M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with L from
 * its last row
 * 175 mul, 141 add, 5 div, 5 sincos for one sample, as written here.
 */
#include "rx90.h"
#include "rx90_math.h"

int rx90_mass_matrix_factor(const double q[6], const double X[40], double L_out[36], double D_out[6])
{
    L_out[6] = 0.0;
    L_out[12] = 0.0;
    L_out[13] = 0.0;
    L_out[18] = 0.0;
    L_out[19] = 0.0;
    L_out[20] = 0.0;
    L_out[24] = 0.0;
    L_out[25] = 0.0;
    L_out[26] = 0.0;
    L_out[27] = 0.0;
    L_out[30] = 0.0;
    L_out[31] = 0.0;
    L_out[32] = 0.0;
    L_out[33] = 0.0;
    L_out[34] = 0.0;
    L_out[0] = 1.0;
    L_out[7] = 1.0;
    L_out[14] = 1.0;
    L_out[21] = 1.0;
    L_out[28] = 1.0;
    L_out[35] = 1.0;
    const rx90_angles4 q_1 = rx90_sincos4(&q[1]);
    const rx90_angles1 q_5 = rx90_sincos1(&q[5]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double C3 = q_1.c[1];
    const double S3 = q_1.s[1];
    const double C4 = q_1.c[2];
    const double S4 = q_1.s[2];
    const double C5 = q_1.c[3];
    const double S5 = q_1.s[3];
    const double C6 = q_5.c[0];
    const double S6 = q_5.s[0];
    const double Te6_6 = 2.0 * X[33];
    const double ze6_6 = X[32] * S6 + C6 * Te6_6;
    const double J11e6_6 = X[32] - S6 * ze6_6;
    const double J11s5_6 = X[24] + J11e6_6;
    const double J22e6_6 = S6 * ze6_6;
    const double J12e6_6 = C6 * ze6_6 - X[33];
    const double J13s5_6 = X[26] - J12e6_6;
    const double J33s5_6 = X[28] + J22e6_6;
    const double J13e6_6 = X[34] * C6 - X[35] * S6;
    const double J23e6_6 = X[34] * S6 + X[35] * C6;
    const double m6_1e6 = X[37] * C6 - X[38] * S6;
    const double m6_2e6 = X[37] * S6 + X[38] * C6;
    const double J12s5_6 = X[25] + J13e6_6;
    const double J23s5_6 = X[27] - J23e6_6;
    const double m1s5_6 = X[29] + m6_1e6;
    const double De5_5 = J11s5_6 - X[36];
    const double Te5_5 = 2.0 * J12s5_6;
    const double ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const double J11e5_5 = J11s5_6 - S5 * ze5_5;
    const double J12e5_5 = C5 * ze5_5 - J12s5_6;
    const double J22e5_5 = X[36] + S5 * ze5_5;
    const double J11s4_5 = X[16] + J11e5_5;
    const double J13s4_5 = X[18] + J12e5_5;
    const double J33s4_5 = X[20] + J22e5_5;
    const double J13e5_5 = C5 * J13s5_6 - S5 * J23s5_6;
    const double J23e5_5 = C5 * J23s5_6 + S5 * J13s5_6;
    const double m5_1e5 = C5 * m1s5_6 - X[30] * S5;
    const double m5_2e5 = X[30] * C5 + S5 * m1s5_6;
    const double J12s4_5 = X[17] - J13e5_5;
    const double J23s4_5 = X[19] - J23e5_5;
    const double m1s4_5 = X[21] + m5_1e5;
    const double J13r4_4 = J13s4_5 - rx90_geometry_R4 * m1s4_5;
    const double m2s4_5 = X[22] + m6_2e6;
    const double J23r4_4 = J23s4_5 - rx90_geometry_R4 * m2s4_5;
    const double xr4_4 = 2.0 * rx90_geometry_R4 * m5_2e5;
    const double J11r4_4 = J11s4_5 + xr4_4;
    const double J22r4_4 = J33s5_6 + xr4_4;
    const double De4_4 = J11r4_4 - J22r4_4;
    const double Te4_4 = 2.0 * J12s4_5;
    const double ze4_4 = C4 * Te4_4 + S4 * De4_4;
    const double J11e4_4 = J11r4_4 - S4 * ze4_4;
    const double J22e4_4 = S4 * ze4_4 + J22r4_4;
    const double J12e4_4 = C4 * ze4_4 - J12s4_5;
    const double J11s3_4 = X[8] + J11e4_4;
    const double J13s3_4 = X[10] - J12e4_4;
    const double J33s3_4 = X[12] + J22e4_4;
    const double J13e4_4 = C4 * J13r4_4 - S4 * J23r4_4;
    const double J23e4_4 = C4 * J23r4_4 + S4 * J13r4_4;
    const double m4_1e4 = C4 * m1s4_5 - S4 * m2s4_5;
    const double m4_2e4 = C4 * m2s4_5 + S4 * m1s4_5;
    const double J12s3_4 = X[9] + J13e4_4;
    const double J23s3_4 = X[11] - J23e4_4;
    const double m1s3_4 = X[13] + m4_1e4;
    const double m2s3_4 = X[14] + m5_2e5;
    const double De3_3 = J11s3_4 - J33s4_5;
    const double Te3_3 = 2.0 * J12s3_4;
    const double ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const double J11e3_3 = J11s3_4 - S3 * ze3_3;
    const double J12e3_3 = C3 * ze3_3 - J12s3_4;
    const double J22e3_3 = S3 * ze3_3 + J33s4_5;
    const double J11s2_3 = X[1] + J11e3_3;
    const double J13e3_3 = C3 * J13s3_4 - S3 * J23s3_4;
    const double J23e3_3 = C3 * J23s3_4 + S3 * J13s3_4;
    const double m3_1e3 = C3 * m1s3_4 - S3 * m2s3_4;
    const double m3_2e3 = C3 * m2s3_4 + S3 * m1s3_4;
    const double J12d3_3 = J12e3_3 - rx90_geometry_D3 * m3_2e3;
    const double J12s2_3 = X[2] + J12d3_3;
    const double Te2_2 = 2.0 * J12s2_3;
    const double xd3_3 = 2.0 * rx90_geometry_D3 * m3_1e3;
    const double J22d3_3 = J22e3_3 + xd3_3;
    const double J33d3_3 = J33s3_4 + xd3_3;
    const double J33s2_3 = X[5] + J33d3_3;
    const double De2_2 = J11s2_3 - J22d3_3;
    const double ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const double J22e2_2 = S2 * ze2_2 + J22d3_3;
    const double J33s1_2 = X[0] + J22e2_2;
    const double Nbm33d3 = rx90_geometry_D3 * m3_1e3 + J33s3_4;
    const double M3_3 = X[15] + J33s3_4;
    const double J13d3_3 = rx90_geometry_D3 * m4_2e4 + J13e3_3;
    const double J13s2_3 = X[3] + J13d3_3;
    const double Nbm32e2 = C2 * J23e3_3 + S2 * J13e3_3;
    const double J23s2_3 = X[4] + J23e3_3;
    const double J23e2_2 = C2 * J23s2_3 + S2 * J13s2_3;
    const double Fbm42e3 = -S3 * m4_2e4;
    const double Nbm43d3 = rx90_geometry_D3 * Fbm42e3 - J23e4_4;
    const double Nbm41e3 = C3 * J13e4_4 - S3 * J33s4_5;
    const double Nbm42e3 = C3 * J33s4_5 + S3 * J13e4_4;
    const double Nbm42d3 = rx90_geometry_D3 * m4_1e4 + Nbm42e3;
    const double Nbm42e2 = C2 * Nbm42d3 + S2 * Nbm41e3;
    const double M4_4 = X[23] + J33s4_5;
    const double Nbm52r4 = -rx90_geometry_R4 * m5_2e5 - J33s5_6;
    const double M5_5 = X[31] + J33s5_6;
    const double Fbm51e4 = -C4 * m5_2e5;
    const double Fbm52e4 = -S4 * m5_2e5;
    const double Fbm52e3 = C3 * m5_1e5 + S3 * Fbm51e4;
    const double Nbm51e4 = C4 * J13e5_5 - S4 * Nbm52r4;
    const double Nbm52e4 = C4 * Nbm52r4 + S4 * J13e5_5;
    const double Nbm53d3 = rx90_geometry_D3 * Fbm52e3 - Nbm52e4;
    const double Nbm51e3 = C3 * Nbm51e4 - S3 * J23e5_5;
    const double Nbm52e3 = C3 * J23e5_5 + S3 * Nbm51e4;
    const double Nbm52d3 = rx90_geometry_D3 * Fbm52e4 + Nbm52e3;
    const double Nbm52e2 = C2 * Nbm52d3 + S2 * Nbm51e3;
    const double Fbm61e5 = -C5 * m6_2e6;
    const double Fbm62e5 = -S5 * m6_2e6;
    const double Nbm61e5 = C5 * J13e6_6 - X[36] * S5;
    const double Nbm62e5 = X[36] * C5 + S5 * J13e6_6;
    const double Nbm61r4 = Nbm61e5 - rx90_geometry_R4 * m6_1e6;
    const double Nbm62r4 = rx90_geometry_R4 * Fbm61e5 + J23e6_6;
    const double Fbm61e4 = C4 * Fbm61e5 - S4 * m6_1e6;
    const double Fbm62e4 = C4 * m6_1e6 + S4 * Fbm61e5;
    const double Fbm62e3 = C3 * Fbm62e5 + S3 * Fbm61e4;
    const double Nbm61e4 = C4 * Nbm61r4 - S4 * Nbm62r4;
    const double Nbm62e4 = C4 * Nbm62r4 + S4 * Nbm61r4;
    const double Nbm63d3 = rx90_geometry_D3 * Fbm62e3 - Nbm62e4;
    const double Nbm61e3 = C3 * Nbm61e4 - S3 * Nbm62e5;
    const double Nbm62e3 = C3 * Nbm62e5 + S3 * Nbm61e4;
    const double Nbm62d3 = rx90_geometry_D3 * Fbm62e4 + Nbm62e3;
    const double Nbm62e2 = C2 * Nbm62d3 + S2 * Nbm61e3;
    const double M6_6 = X[36] + X[39];
    D_out[5] = M6_6;
    const double d6 = 1.0 / M6_6;
    const double l6_1 = Nbm62e2 * d6;
    L_out[5] = l6_1;
    const double m6_1_1 = J33s1_2 - Nbm62e2 * l6_1;
    const double l6_2 = Nbm63d3 * d6;
    L_out[11] = l6_2;
    const double m6_2_1 = J23e2_2 - Nbm62e2 * l6_2;
    const double m6_2_2 = J33s2_3 - Nbm63d3 * l6_2;
    const double l6_3 = -Nbm62e4 * d6;
    L_out[17] = l6_3;
    const double m6_3_1 = Nbm32e2 - Nbm62e2 * l6_3;
    const double m6_3_2 = Nbm33d3 - Nbm63d3 * l6_3;
    const double m6_3_3 = Nbm62e4 * l6_3 + M3_3;
    const double l6_4 = Nbm62e5 * d6;
    L_out[23] = l6_4;
    const double l6_5 = -J23e6_6 * d6;
    L_out[29] = l6_5;
    const double m6_4_1 = Nbm42e2 - Nbm62e2 * l6_4;
    const double m6_4_2 = Nbm43d3 - Nbm63d3 * l6_4;
    const double m6_4_3 = Nbm62e4 * l6_4 - J23e4_4;
    const double m6_4_4 = M4_4 - Nbm62e5 * l6_4;
    const double m6_5_1 = Nbm52e2 - Nbm62e2 * l6_5;
    const double m6_5_2 = Nbm53d3 - Nbm63d3 * l6_5;
    const double m6_5_3 = Nbm62e4 * l6_5 - Nbm52e4;
    const double m6_5_4 = J23e5_5 - Nbm62e5 * l6_5;
    const double m6_5_5 = J23e6_6 * l6_5 + M5_5;
    D_out[4] = m6_5_5;
    const double d5 = 1.0 / m6_5_5;
    const double l5_1 = m6_5_1 * d5;
    L_out[4] = l5_1;
    const double m5_1_1 = m6_1_1 - m6_5_1 * l5_1;
    const double l5_2 = m6_5_2 * d5;
    L_out[10] = l5_2;
    const double m5_2_1 = m6_2_1 - m6_5_1 * l5_2;
    const double m5_2_2 = m6_2_2 - m6_5_2 * l5_2;
    const double l5_3 = m6_5_3 * d5;
    L_out[16] = l5_3;
    const double l5_4 = m6_5_4 * d5;
    L_out[22] = l5_4;
    const double m5_3_1 = m6_3_1 - m6_5_1 * l5_3;
    const double m5_3_2 = m6_3_2 - m6_5_2 * l5_3;
    const double m5_3_3 = m6_3_3 - m6_5_3 * l5_3;
    const double m5_4_1 = m6_4_1 - m6_5_1 * l5_4;
    const double m5_4_2 = m6_4_2 - m6_5_2 * l5_4;
    const double m5_4_3 = m6_4_3 - m6_5_3 * l5_4;
    const double m5_4_4 = m6_4_4 - m6_5_4 * l5_4;
    D_out[3] = m5_4_4;
    const double d4 = 1.0 / m5_4_4;
    const double l4_1 = m5_4_1 * d4;
    L_out[3] = l4_1;
    const double m4_1_1 = m5_1_1 - m5_4_1 * l4_1;
    const double l4_2 = m5_4_2 * d4;
    L_out[9] = l4_2;
    const double l4_3 = m5_4_3 * d4;
    L_out[15] = l4_3;
    const double m4_2_1 = m5_2_1 - m5_4_1 * l4_2;
    const double m4_2_2 = m5_2_2 - m5_4_2 * l4_2;
    const double m4_3_1 = m5_3_1 - m5_4_1 * l4_3;
    const double m4_3_2 = m5_3_2 - m5_4_2 * l4_3;
    const double m4_3_3 = m5_3_3 - m5_4_3 * l4_3;
    D_out[2] = m4_3_3;
    const double d3 = 1.0 / m4_3_3;
    const double l3_1 = m4_3_1 * d3;
    L_out[2] = l3_1;
    const double l3_2 = m4_3_2 * d3;
    L_out[8] = l3_2;
    const double m3_1_1 = m4_1_1 - m4_3_1 * l3_1;
    const double m3_2_1 = m4_2_1 - m4_3_1 * l3_2;
    const double m3_2_2 = m4_2_2 - m4_3_2 * l3_2;
    D_out[1] = m3_2_2;
    const double d2 = 1.0 / m3_2_2;
    const double l2_1 = m3_2_1 * d2;
    L_out[1] = l2_1;
    const double m2_1_1 = m3_1_1 - m3_2_1 * l2_1;
    D_out[0] = m2_1_1;
    const double guard[6] = { m2_1_1, m3_2_2, m4_3_3, m5_4_4, m6_5_5, M6_6 };
    int status = rx90_OK;
    for (size_t i = 0u; (i < 6u) && (status == 0); ++i) {
        if (!(guard[i] > 0.0)) {
            status = (guard[i] <= 0.0) ? rx90_NOT_POSITIVE_DEFINITE : rx90_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 36u) && (status == 0); ++i) {
        if (!((L_out[i] - L_out[i]) == 0.0)) {
            status = rx90_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 6u) && (status == 0); ++i) {
        if (!((D_out[i] - D_out[i]) == 0.0)) {
            status = rx90_NOT_FINITE;
        }
    }
    return status;
}

int rx90_mass_matrix_factor_batch(size_t N, const double *q, const double *X, double *L_out, double *D_out)
{
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= rx90_mass_matrix_factor(&q[k * 6u], X, &L_out[k * 36u], &D_out[k * 6u]);
    }
    return status;
}
