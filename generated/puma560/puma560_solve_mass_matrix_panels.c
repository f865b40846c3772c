/* puma560: solve_mass_matrix of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *b, const lanes *X, apart *x, const int stream)
{
    (void)stream;
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_5 = lanes_turn(q[5]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[5]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_5 = lanes_far(q[5], q_5);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
    const lanes C6 = q_5.c;
    const lanes S6 = q_5.s;
    const lanes Te6_6 = 2.0 * X[33];
    const lanes ze6_6 = X[32] * S6 + C6 * Te6_6;
    const lanes J11e6_6 = X[32] - S6 * ze6_6;
    const lanes J22e6_6 = S6 * ze6_6;
    const lanes J12e6_6 = C6 * ze6_6 - X[33];
    const lanes J13e6_6 = X[34] * C6 - X[35] * S6;
    const lanes J23e6_6 = X[34] * S6 + X[35] * C6;
    const lanes m6_1e6 = X[37] * C6 - X[38] * S6;
    const lanes m6_2e6 = X[37] * S6 + X[38] * C6;
    const lanes J11s5_6 = X[24] + J11e6_6;
    const lanes J12s5_6 = X[25] - J13e6_6;
    const lanes J13s5_6 = X[26] + J12e6_6;
    const lanes J23s5_6 = X[27] - J23e6_6;
    const lanes J33s5_6 = X[28] + J22e6_6;
    const lanes m1s5_6 = X[29] + m6_1e6;
    const lanes De5_5 = J11s5_6 - X[36];
    const lanes Te5_5 = 2.0 * J12s5_6;
    const lanes ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const lanes J11e5_5 = J11s5_6 - S5 * ze5_5;
    const lanes J22e5_5 = X[36] + S5 * ze5_5;
    const lanes J12e5_5 = C5 * ze5_5 - J12s5_6;
    const lanes J13e5_5 = C5 * J13s5_6 - S5 * J23s5_6;
    const lanes J23e5_5 = C5 * J23s5_6 + S5 * J13s5_6;
    const lanes m5_1e5 = C5 * m1s5_6 - X[30] * S5;
    const lanes m5_2e5 = X[30] * C5 + S5 * m1s5_6;
    const lanes J11s4_5 = X[16] + J11e5_5;
    const lanes J12s4_5 = X[17] + J13e5_5;
    const lanes J13s4_5 = X[18] - J12e5_5;
    const lanes J23s4_5 = X[19] - J23e5_5;
    const lanes J33s4_5 = X[20] + J22e5_5;
    const lanes m1s4_5 = X[21] + m5_1e5;
    const lanes m2s4_5 = X[22] + m6_2e6;
    const lanes xr4_4 = -2.0 * puma560_geometry_R4 * m5_2e5;
    const lanes J11r4_4 = J11s4_5 + xr4_4;
    const lanes J22r4_4 = J33s5_6 + xr4_4;
    const lanes J13r4_4 = J13s4_5 - puma560_geometry_R4 * m1s4_5;
    const lanes J23r4_4 = J23s4_5 - puma560_geometry_R4 * m2s4_5;
    const lanes De4_4 = J11r4_4 - J22r4_4;
    const lanes Te4_4 = 2.0 * J12s4_5;
    const lanes ze4_4 = C4 * Te4_4 + S4 * De4_4;
    const lanes J11e4_4 = J11r4_4 - S4 * ze4_4;
    const lanes J22e4_4 = S4 * ze4_4 + J22r4_4;
    const lanes J12e4_4 = C4 * ze4_4 - J12s4_5;
    const lanes J13e4_4 = C4 * J13r4_4 - S4 * J23r4_4;
    const lanes J23e4_4 = C4 * J23r4_4 + S4 * J13r4_4;
    const lanes m4_1e4 = C4 * m1s4_5 - S4 * m2s4_5;
    const lanes m4_2e4 = C4 * m2s4_5 + S4 * m1s4_5;
    const lanes xd4_4 = 2.0 * puma560_geometry_D4 * m4_1e4;
    const lanes J22d4_4 = J22e4_4 + xd4_4;
    const lanes J33d4_4 = J33s4_5 + xd4_4;
    const lanes J12d4_4 = J12e4_4 - puma560_geometry_D4 * m4_2e4;
    const lanes J13d4_4 = puma560_geometry_D4 * m5_2e5 + J13e4_4;
    const lanes J11s3_4 = X[8] + J11e4_4;
    const lanes J12s3_4 = X[9] - J13d4_4;
    const lanes J13s3_4 = X[10] + J12d4_4;
    const lanes J23s3_4 = X[11] - J23e4_4;
    const lanes J33s3_4 = X[12] + J22d4_4;
    const lanes m1s3_4 = X[13] + m4_1e4;
    const lanes m2s3_4 = X[14] + m5_2e5;
    const lanes xr3_3 = 2.0 * puma560_geometry_R3 * m4_2e4;
    const lanes J11r3_3 = J11s3_4 + xr3_3;
    const lanes J22r3_3 = J33d4_4 + xr3_3;
    const lanes J13r3_3 = J13s3_4 - puma560_geometry_R3 * m1s3_4;
    const lanes J23r3_3 = J23s3_4 - puma560_geometry_R3 * m2s3_4;
    const lanes De3_3 = J11r3_3 - J22r3_3;
    const lanes Te3_3 = 2.0 * J12s3_4;
    const lanes ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const lanes J11e3_3 = J11r3_3 - S3 * ze3_3;
    const lanes J22e3_3 = S3 * ze3_3 + J22r3_3;
    const lanes J12e3_3 = C3 * ze3_3 - J12s3_4;
    const lanes J13e3_3 = C3 * J13r3_3 - S3 * J23r3_3;
    const lanes J23e3_3 = C3 * J23r3_3 + S3 * J13r3_3;
    const lanes m3_1e3 = C3 * m1s3_4 - S3 * m2s3_4;
    const lanes m3_2e3 = C3 * m2s3_4 + S3 * m1s3_4;
    const lanes xd3_3 = 2.0 * puma560_geometry_D3 * m3_1e3;
    const lanes J22d3_3 = J22e3_3 + xd3_3;
    const lanes J33d3_3 = J33s3_4 + xd3_3;
    const lanes J12d3_3 = J12e3_3 - puma560_geometry_D3 * m3_2e3;
    const lanes J13d3_3 = J13e3_3 - puma560_geometry_D3 * m4_2e4;
    const lanes J11s2_3 = X[1] + J11e3_3;
    const lanes J12s2_3 = X[2] + J12d3_3;
    const lanes J13s2_3 = X[3] + J13d3_3;
    const lanes J23s2_3 = X[4] + J23e3_3;
    const lanes J33s2_3 = X[5] + J33d3_3;
    const lanes m1s2_3 = X[6] + m3_1e3;
    const lanes m2s2_3 = X[7] + m3_2e3;
    const lanes xr2_2 = 2.0 * puma560_geometry_R2 * m4_2e4;
    const lanes J11r2_2 = J11s2_3 + xr2_2;
    const lanes J22r2_2 = J22d3_3 + xr2_2;
    const lanes J13r2_2 = J13s2_3 - puma560_geometry_R2 * m1s2_3;
    const lanes J23r2_2 = J23s2_3 - puma560_geometry_R2 * m2s2_3;
    const lanes De2_2 = J11r2_2 - J22r2_2;
    const lanes Te2_2 = 2.0 * J12s2_3;
    const lanes ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const lanes J22e2_2 = S2 * ze2_2 + J22r2_2;
    const lanes J23e2_2 = C2 * J23r2_2 + S2 * J13r2_2;
    const lanes J33s1_2 = X[0] + J22e2_2;
    const lanes Nbm33d3 = puma560_geometry_D3 * m3_1e3 + J33s3_4;
    const lanes Nbm31r2 = J13e3_3 - puma560_geometry_R2 * m3_1e3;
    const lanes Nbm32r2 = J23e3_3 - puma560_geometry_R2 * m3_2e3;
    const lanes Nbm32e2 = C2 * Nbm32r2 + S2 * Nbm31r2;
    const lanes Nbm43d4 = puma560_geometry_D4 * m4_1e4 + J33s4_5;
    const lanes Nbm42r3 = -puma560_geometry_R3 * m4_2e4 - Nbm43d4;
    const lanes Fbm41e3 = -C3 * m4_2e4;
    const lanes Fbm42e3 = -S3 * m4_2e4;
    const lanes Nbm41e3 = C3 * J13e4_4 - S3 * Nbm42r3;
    const lanes Nbm42e3 = C3 * Nbm42r3 + S3 * J13e4_4;
    const lanes Nbm42d3 = Nbm42e3 - puma560_geometry_D3 * m4_1e4;
    const lanes Nbm43d3 = puma560_geometry_D3 * Fbm42e3 + J23e4_4;
    const lanes Nbm41r2 = Nbm41e3 - puma560_geometry_R2 * Fbm42e3;
    const lanes Nbm42r2 = puma560_geometry_R2 * Fbm41e3 + Nbm42d3;
    const lanes Nbm42e2 = C2 * Nbm42r2 + S2 * Nbm41r2;
    const lanes Nbm52r4 = J33s5_6 - puma560_geometry_R4 * m5_2e5;
    const lanes Fbm51e4 = -C4 * m5_2e5;
    const lanes Fbm52e4 = -S4 * m5_2e5;
    const lanes Nbm51e4 = C4 * J13e5_5 - S4 * Nbm52r4;
    const lanes Nbm52e4 = C4 * Nbm52r4 + S4 * J13e5_5;
    const lanes Nbm52d4 = puma560_geometry_D4 * m5_1e5 + Nbm52e4;
    const lanes Nbm53d4 = puma560_geometry_D4 * Fbm52e4 - J23e5_5;
    const lanes Nbm51r3 = Nbm51e4 - puma560_geometry_R3 * m5_1e5;
    const lanes Nbm52r3 = puma560_geometry_R3 * Fbm51e4 - Nbm53d4;
    const lanes Fbm51e3 = C3 * Fbm51e4 - S3 * m5_1e5;
    const lanes Fbm52e3 = C3 * m5_1e5 + S3 * Fbm51e4;
    const lanes Nbm51e3 = C3 * Nbm51r3 - S3 * Nbm52r3;
    const lanes Nbm52e3 = C3 * Nbm52r3 + S3 * Nbm51r3;
    const lanes Nbm52d3 = Nbm52e3 - puma560_geometry_D3 * Fbm52e4;
    const lanes Nbm53d3 = puma560_geometry_D3 * Fbm52e3 + Nbm52d4;
    const lanes Nbm51r2 = Nbm51e3 - puma560_geometry_R2 * Fbm52e3;
    const lanes Nbm52r2 = puma560_geometry_R2 * Fbm51e3 + Nbm52d3;
    const lanes Nbm52e2 = C2 * Nbm52r2 + S2 * Nbm51r2;
    const lanes Fbm61e5 = -C5 * m6_2e6;
    const lanes Fbm62e5 = -S5 * m6_2e6;
    const lanes Nbm61e5 = X[36] * S5 + C5 * J13e6_6;
    const lanes Nbm62e5 = S5 * J13e6_6 - X[36] * C5;
    const lanes Nbm61r4 = Nbm61e5 - puma560_geometry_R4 * m6_1e6;
    const lanes Nbm62r4 = puma560_geometry_R4 * Fbm61e5 + J23e6_6;
    const lanes Fbm61e4 = C4 * Fbm61e5 - S4 * m6_1e6;
    const lanes Fbm62e4 = C4 * m6_1e6 + S4 * Fbm61e5;
    const lanes Nbm61e4 = C4 * Nbm61r4 - S4 * Nbm62r4;
    const lanes Nbm62e4 = C4 * Nbm62r4 + S4 * Nbm61r4;
    const lanes Nbm62d4 = puma560_geometry_D4 * Fbm62e5 + Nbm62e4;
    const lanes Nbm63d4 = puma560_geometry_D4 * Fbm62e4 - Nbm62e5;
    const lanes Nbm61r3 = Nbm61e4 - puma560_geometry_R3 * Fbm62e5;
    const lanes Nbm62r3 = puma560_geometry_R3 * Fbm61e4 - Nbm63d4;
    const lanes Fbm61e3 = C3 * Fbm61e4 - S3 * Fbm62e5;
    const lanes Fbm62e3 = C3 * Fbm62e5 + S3 * Fbm61e4;
    const lanes Nbm61e3 = C3 * Nbm61r3 - S3 * Nbm62r3;
    const lanes Nbm62e3 = C3 * Nbm62r3 + S3 * Nbm61r3;
    const lanes Nbm62d3 = Nbm62e3 - puma560_geometry_D3 * Fbm62e4;
    const lanes Nbm63d3 = puma560_geometry_D3 * Fbm62e3 + Nbm62d4;
    const lanes Nbm61r2 = Nbm61e3 - puma560_geometry_R2 * Fbm62e3;
    const lanes Nbm62r2 = puma560_geometry_R2 * Fbm61e3 + Nbm62d3;
    const lanes Nbm62e2 = C2 * Nbm62r2 + S2 * Nbm61r2;
    const lanes M3_3 = X[15] + J33s3_4;
    const lanes M4_4 = X[23] + J33s4_5;
    const lanes M5_5 = X[31] + J33s5_6;
    const lanes M6_6 = X[36] + X[39];
    const lanes d6 = 1.0 / M6_6;
    const lanes l6_1 = -Nbm62e2 * d6;
    const lanes l6_2 = Nbm63d3 * d6;
    const lanes l6_3 = Nbm62d4 * d6;
    const lanes l6_4 = -Nbm62e5 * d6;
    const lanes l6_5 = J23e6_6 * d6;
    const lanes m6_1_1 = J33s1_2 + Nbm62e2 * l6_1;
    const lanes m6_2_1 = Nbm62e2 * l6_2 - J23e2_2;
    const lanes m6_2_2 = J33s2_3 - Nbm63d3 * l6_2;
    const lanes m6_3_1 = Nbm62e2 * l6_3 - Nbm32e2;
    const lanes m6_3_2 = Nbm33d3 - Nbm63d3 * l6_3;
    const lanes m6_3_3 = M3_3 - Nbm62d4 * l6_3;
    const lanes m6_4_1 = Nbm62e2 * l6_4 - Nbm42e2;
    const lanes m6_4_2 = Nbm43d3 - Nbm63d3 * l6_4;
    const lanes m6_4_3 = J23e4_4 - Nbm62d4 * l6_4;
    const lanes m6_4_4 = Nbm62e5 * l6_4 + M4_4;
    const lanes m6_5_1 = Nbm62e2 * l6_5 - Nbm52e2;
    const lanes m6_5_2 = Nbm53d3 - Nbm63d3 * l6_5;
    const lanes m6_5_3 = Nbm52d4 - Nbm62d4 * l6_5;
    const lanes m6_5_4 = Nbm62e5 * l6_5 - J23e5_5;
    const lanes m6_5_5 = M5_5 - J23e6_6 * l6_5;
    const lanes d5 = 1.0 / m6_5_5;
    const lanes l5_1 = m6_5_1 * d5;
    const lanes l5_2 = m6_5_2 * d5;
    const lanes l5_3 = m6_5_3 * d5;
    const lanes l5_4 = m6_5_4 * d5;
    const lanes m5_1_1 = m6_1_1 - m6_5_1 * l5_1;
    const lanes m5_2_1 = m6_2_1 - m6_5_1 * l5_2;
    const lanes m5_2_2 = m6_2_2 - m6_5_2 * l5_2;
    const lanes m5_3_1 = m6_3_1 - m6_5_1 * l5_3;
    const lanes m5_3_2 = m6_3_2 - m6_5_2 * l5_3;
    const lanes m5_3_3 = m6_3_3 - m6_5_3 * l5_3;
    const lanes m5_4_1 = m6_4_1 - m6_5_1 * l5_4;
    const lanes m5_4_2 = m6_4_2 - m6_5_2 * l5_4;
    const lanes m5_4_3 = m6_4_3 - m6_5_3 * l5_4;
    const lanes m5_4_4 = m6_4_4 - m6_5_4 * l5_4;
    const lanes d4 = 1.0 / m5_4_4;
    const lanes l4_1 = m5_4_1 * d4;
    const lanes l4_2 = m5_4_2 * d4;
    const lanes l4_3 = m5_4_3 * d4;
    const lanes m4_1_1 = m5_1_1 - m5_4_1 * l4_1;
    const lanes m4_2_1 = m5_2_1 - m5_4_1 * l4_2;
    const lanes m4_2_2 = m5_2_2 - m5_4_2 * l4_2;
    const lanes m4_3_1 = m5_3_1 - m5_4_1 * l4_3;
    const lanes m4_3_2 = m5_3_2 - m5_4_2 * l4_3;
    const lanes m4_3_3 = m5_3_3 - m5_4_3 * l4_3;
    const lanes d3 = 1.0 / m4_3_3;
    const lanes l3_1 = m4_3_1 * d3;
    const lanes l3_2 = m4_3_2 * d3;
    const lanes m3_1_1 = m4_1_1 - m4_3_1 * l3_1;
    const lanes m3_2_1 = m4_2_1 - m4_3_1 * l3_2;
    const lanes m3_2_2 = m4_2_2 - m4_3_2 * l3_2;
    const lanes d2 = 1.0 / m3_2_2;
    const lanes l2_1 = m3_2_1 * d2;
    const lanes m2_1_1 = m3_1_1 - m3_2_1 * l2_1;
    const lanes d1 = 1.0 / m2_1_1;
    const lanes y6_1 = b[0] - b[5] * l6_1;
    const lanes y6_2 = b[1] - b[5] * l6_2;
    const lanes y6_3 = b[2] - b[5] * l6_3;
    const lanes y6_4 = b[3] - b[5] * l6_4;
    const lanes y6_5 = b[4] - b[5] * l6_5;
    const lanes y5_1 = y6_1 - l5_1 * y6_5;
    const lanes y5_2 = y6_2 - l5_2 * y6_5;
    const lanes y5_3 = y6_3 - l5_3 * y6_5;
    const lanes y5_4 = y6_4 - l5_4 * y6_5;
    const lanes y4_1 = y5_1 - l4_1 * y5_4;
    const lanes y4_2 = y5_2 - l4_2 * y5_4;
    const lanes y4_3 = y5_3 - l4_3 * y5_4;
    const lanes y3_1 = y4_1 - l3_1 * y4_3;
    const lanes y3_2 = y4_2 - l3_2 * y4_3;
    const lanes y2_1 = y3_1 - l2_1 * y3_2;
    const lanes o1 = d1 * y2_1;
    lanes_put(&x[0], o1, stream);
    const lanes o2 = d2 * y3_2 - l2_1 * o1;
    lanes_put(&x[1], o2, stream);
    const lanes o3 = d3 * y4_3 - l3_1 * o1 - l3_2 * o2;
    lanes_put(&x[2], o3, stream);
    const lanes o4 = d4 * y5_4 - l4_1 * o1 - l4_2 * o2 - l4_3 * o3;
    lanes_put(&x[3], o4, stream);
    const lanes o5 = d5 * y6_5 - l5_1 * o1 - l5_2 * o2 - l5_3 * o3 - l5_4 * o4;
    lanes_put(&x[4], o5, stream);
    const lanes o6 = b[5] * d6 - l6_1 * o1 - l6_2 * o2 - l6_3 * o3 - l6_4 * o4 - l6_5 * o5;
    lanes_put(&x[5], o6, stream);
    const mask singular = (mask)(M6_6 <= 0.0) | (mask)(m6_5_5 <= 0.0) | (mask)(m5_4_4 <= 0.0) | (mask)(m4_3_3 <= 0.0) | (mask)(m3_2_2 <= 0.0) | (mask)(m2_1_1 <= 0.0);
    const mask odd = (~(mask)(M6_6 > 0.0) & ~(mask)(M6_6 <= 0.0)) | (~(mask)(m6_5_5 > 0.0) & ~(mask)(m6_5_5 <= 0.0)) | (~(mask)(m5_4_4 > 0.0) & ~(mask)(m5_4_4 <= 0.0)) | (~(mask)(m4_3_3 > 0.0) & ~(mask)(m4_3_3 <= 0.0)) | (~(mask)(m3_2_2 > 0.0) & ~(mask)(m3_2_2 <= 0.0)) | (~(mask)(m2_1_1 > 0.0) & ~(mask)(m2_1_1 <= 0.0)) | (~(mask)(o1 - o1 == 0.0)) | (~(mask)(o2 - o2 == 0.0)) | (~(mask)(o3 - o3 == 0.0)) | (~(mask)(o4 - o4 == 0.0)) | (~(mask)(o5 - o5 == 0.0)) | (~(mask)(o6 - o6 == 0.0));
    const int status = (lanes_any(singular) ? (int)puma560_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int)puma560_NOT_FINITE : 0);
    return status;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *b, const lanes *X, apart *x)
{
    return panel(q, b, X, x, 0);
}

int puma560_solve_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_b = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_b[REACH(6u)];
    lanes lanes_b[BLOCKS(6u)];
    double padded_X[REACH(40u)];
    lanes lanes_X[BLOCKS(40u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(b, 6u, lanes_b);
    lanes_shared(X, 40u, lanes_X);
    lanes lanes_x[BLOCKS(6u)];
    double scratch[6u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_x, 0, sizeof lanes_x);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_b != 0u) {
            lanes_read(b, 6u, stride_b, k, N, padded_b, lanes_b);
        }
        if (stride_X != 0u) {
            lanes_read(X, 40u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_b, lanes_X, (apart *)lanes_x);
        lanes_store(lanes_x, 6u, count, stream, scratch, &x[k * 6u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *b, const double *X, double *x)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_b = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_b[REACH(6u)];
    lanes lanes_b[BLOCKS(6u)];
    double padded_X[REACH(40u)];
    lanes lanes_X[BLOCKS(40u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(b, 6u, lanes_b);
    lanes_shared(X, 40u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_b != 0u) {
            lanes_read(b, 6u, stride_b, k, N, padded_b, lanes_b);
        }
        if (stride_X != 0u) {
            lanes_read(X, 40u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_x = (apart *)&x[k * 6u];
        status |= stream ? panel(lanes_q, lanes_b, lanes_X, lanes_x, 1) : plain(lanes_q, lanes_b, lanes_X, lanes_x);
    }
    return status;
}

int puma560_solve_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    if (!(streamed(stream, x))) {
        return panels(0, N, strides, q, b, X, x);
    }
    const int status = panels(1, N, strides, q, b, X, x);
    stream_end();
    return status;
}

#else

int puma560_solve_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_b = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        status |= puma560_solve_mass_matrix(&q[k * stride_q], &b[k * stride_b], &X[k * stride_X], &x[k * 6u]);
    }
    return status;
}

int puma560_solve_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    return puma560_solve_mass_matrix_rows(stream, N, strides, q, b, X, x);
}

#endif

size_t puma560_solve_mass_matrix_width(void)
{
    return puma560_WIDTH;
}

int puma560_solve_mass_matrix_batch(size_t N, const double *q, const double *b, const double *X, double *x)
{
    return puma560_solve_mass_matrix_rows(0, N, NULL, q, b, X, x);
}
