/* panda: mass_matrix_factor of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *X, apart *L_out, apart *D_out, const int stream)
{
    (void)stream;
    lanes_put(&L_out[0], lanes_all(1.0), stream);
    lanes_put(&L_out[8], lanes_all(1.0), stream);
    lanes_put(&L_out[16], lanes_all(1.0), stream);
    lanes_put(&L_out[24], lanes_all(1.0), stream);
    lanes_put(&L_out[32], lanes_all(1.0), stream);
    lanes_put(&L_out[40], lanes_all(1.0), stream);
    lanes_put(&L_out[48], lanes_all(1.0), stream);
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_5 = lanes_turn(q[5]);
    turned q_6 = lanes_turn(q[6]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[5]) + lanes_abs(q[6]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_5 = lanes_far(q[5], q_5);
        q_6 = lanes_far(q[6], q_6);
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
    const lanes C7 = q_6.c;
    const lanes S7 = q_6.s;
    const lanes Te7_7 = 2.0 * X[41];
    const lanes ze7_7 = X[40] * S7 + C7 * Te7_7;
    const lanes J11e7_7 = X[40] - S7 * ze7_7;
    const lanes J11s6_7 = X[32] + J11e7_7;
    const lanes J22e7_7 = S7 * ze7_7;
    const lanes J12e7_7 = C7 * ze7_7 - X[41];
    const lanes J13e7_7 = X[42] * C7 - X[43] * S7;
    const lanes J23e7_7 = X[42] * S7 + X[43] * C7;
    const lanes m7_1e7 = X[45] * C7 - X[46] * S7;
    const lanes m7_2e7 = X[45] * S7 + X[46] * C7;
    const lanes J12d7_7 = J12e7_7 - panda_geometry_D7 * m7_2e7;
    const lanes J13s6_7 = X[34] + J12d7_7;
    const lanes xd7_7 = 2.0 * panda_geometry_D7 * m7_1e7;
    const lanes J22d7_7 = J22e7_7 + xd7_7;
    const lanes J33d7_7 = X[44] + xd7_7;
    const lanes J33s6_7 = X[36] + J22d7_7;
    const lanes J12s6_7 = X[33] - J13e7_7;
    const lanes J23s6_7 = X[35] - J23e7_7;
    const lanes m1s6_7 = X[37] + m7_1e7;
    const lanes De6_6 = J11s6_7 - J33d7_7;
    const lanes Te6_6 = 2.0 * J12s6_7;
    const lanes ze6_6 = C6 * Te6_6 + S6 * De6_6;
    const lanes J11e6_6 = J11s6_7 - S6 * ze6_6;
    const lanes J22e6_6 = S6 * ze6_6 + J33d7_7;
    const lanes J12e6_6 = C6 * ze6_6 - J12s6_7;
    const lanes J11s5_6 = X[24] + J11e6_6;
    const lanes J13s5_6 = X[26] + J12e6_6;
    const lanes J33s5_6 = X[28] + J22e6_6;
    const lanes J13e6_6 = C6 * J13s6_7 - S6 * J23s6_7;
    const lanes J23e6_6 = C6 * J23s6_7 + S6 * J13s6_7;
    const lanes m6_1e6 = C6 * m1s6_7 - X[38] * S6;
    const lanes m6_2e6 = X[38] * C6 + S6 * m1s6_7;
    const lanes J12s5_6 = X[25] - J13e6_6;
    const lanes J23s5_6 = X[27] - J23e6_6;
    const lanes m1s5_6 = X[29] + m6_1e6;
    const lanes J13r5_5 = J13s5_6 - panda_geometry_R5 * m1s5_6;
    const lanes m2s5_6 = X[30] - m7_2e7;
    const lanes J23r5_5 = J23s5_6 - panda_geometry_R5 * m2s5_6;
    const lanes xr5_5 = 2.0 * panda_geometry_R5 * m6_2e6;
    const lanes J11r5_5 = J11s5_6 + xr5_5;
    const lanes J22r5_5 = J33s6_7 + xr5_5;
    const lanes De5_5 = J11r5_5 - J22r5_5;
    const lanes Te5_5 = 2.0 * J12s5_6;
    const lanes ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const lanes J11e5_5 = J11r5_5 - S5 * ze5_5;
    const lanes J22e5_5 = S5 * ze5_5 + J22r5_5;
    const lanes J12e5_5 = C5 * ze5_5 - J12s5_6;
    const lanes J11s4_5 = X[16] + J11e5_5;
    const lanes J13e5_5 = C5 * J13r5_5 - S5 * J23r5_5;
    const lanes J23e5_5 = C5 * J23r5_5 + S5 * J13r5_5;
    const lanes m5_1e5 = C5 * m1s5_6 - S5 * m2s5_6;
    const lanes m5_2e5 = C5 * m2s5_6 + S5 * m1s5_6;
    const lanes J12d5_5 = panda_geometry_D4 * m5_2e5 + J12e5_5;
    const lanes J13s4_5 = X[18] - J12d5_5;
    const lanes xd5_5 = -2.0 * panda_geometry_D4 * m5_1e5;
    const lanes J22d5_5 = J22e5_5 + xd5_5;
    const lanes J33d5_5 = J33s5_6 + xd5_5;
    const lanes J33s4_5 = X[20] + J22d5_5;
    const lanes J13d5_5 = panda_geometry_D4 * m6_2e6 + J13e5_5;
    const lanes J12s4_5 = X[17] + J13d5_5;
    const lanes J23s4_5 = X[19] - J23e5_5;
    const lanes m1s4_5 = X[21] + m5_1e5;
    const lanes m2s4_5 = X[22] + m6_2e6;
    const lanes De4_4 = J11s4_5 - J33d5_5;
    const lanes Te4_4 = 2.0 * J12s4_5;
    const lanes ze4_4 = C4 * Te4_4 + S4 * De4_4;
    const lanes J11e4_4 = J11s4_5 - S4 * ze4_4;
    const lanes J22e4_4 = S4 * ze4_4 + J33d5_5;
    const lanes J12e4_4 = C4 * ze4_4 - J12s4_5;
    const lanes J11s3_4 = X[8] + J11e4_4;
    const lanes J13e4_4 = C4 * J13s4_5 - S4 * J23s4_5;
    const lanes J23e4_4 = C4 * J23s4_5 + S4 * J13s4_5;
    const lanes m4_1e4 = C4 * m1s4_5 - S4 * m2s4_5;
    const lanes m4_2e4 = C4 * m2s4_5 + S4 * m1s4_5;
    const lanes J12d4_4 = J12e4_4 - panda_geometry_D4 * m4_2e4;
    const lanes J13s3_4 = X[10] + J12d4_4;
    const lanes xd4_4 = 2.0 * panda_geometry_D4 * m4_1e4;
    const lanes J22d4_4 = J22e4_4 + xd4_4;
    const lanes J33d4_4 = J33s4_5 + xd4_4;
    const lanes J33s3_4 = X[12] + J22d4_4;
    const lanes J13d4_4 = panda_geometry_D4 * m5_2e5 + J13e4_4;
    const lanes J12s3_4 = X[9] - J13d4_4;
    const lanes J23s3_4 = X[11] - J23e4_4;
    const lanes m1s3_4 = X[13] + m4_1e4;
    const lanes J13r3_3 = J13s3_4 - panda_geometry_R3 * m1s3_4;
    const lanes Nbm43d4 = panda_geometry_D4 * m4_1e4 + J33s4_5;
    const lanes Nbm42r3 = -panda_geometry_R3 * m4_2e4 - Nbm43d4;
    const lanes xr3_3 = 2.0 * panda_geometry_R3 * m4_2e4;
    const lanes J11r3_3 = J11s3_4 + xr3_3;
    const lanes J22r3_3 = J33d4_4 + xr3_3;
    const lanes M4_4 = X[23] + J33s4_5;
    const lanes m2s3_4 = X[14] + m5_2e5;
    const lanes J23r3_3 = J23s3_4 - panda_geometry_R3 * m2s3_4;
    const lanes De3_3 = J11r3_3 - J22r3_3;
    const lanes Te3_3 = 2.0 * J12s3_4;
    const lanes ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const lanes J11e3_3 = J11r3_3 - S3 * ze3_3;
    const lanes J22e3_3 = S3 * ze3_3 + J22r3_3;
    const lanes J12e3_3 = C3 * ze3_3 - J12s3_4;
    const lanes J11s2_3 = X[1] + J11e3_3;
    const lanes J13s2_3 = X[3] + J12e3_3;
    const lanes J33s2_3 = X[5] + J22e3_3;
    const lanes De2_2 = J11s2_3 - J33s3_4;
    const lanes J13e3_3 = C3 * J13r3_3 - S3 * J23r3_3;
    const lanes J23e3_3 = C3 * J23r3_3 + S3 * J13r3_3;
    const lanes J12s2_3 = X[2] - J13e3_3;
    const lanes Te2_2 = 2.0 * J12s2_3;
    const lanes ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const lanes J22e2_2 = S2 * ze2_2 + J33s3_4;
    const lanes J33s1_2 = X[0] + J22e2_2;
    const lanes Nbm32e2 = S2 * J13e3_3 - C2 * J33s3_4;
    const lanes M3_3 = X[15] + J33s3_4;
    const lanes J23s2_3 = X[4] - J23e3_3;
    const lanes J23e2_2 = C2 * J23s2_3 + S2 * J13s2_3;
    const lanes Nbm41e3 = C3 * J13e4_4 - S3 * Nbm42r3;
    const lanes Nbm42e3 = C3 * Nbm42r3 + S3 * J13e4_4;
    const lanes Nbm42e2 = S2 * Nbm41e3 - C2 * J23e4_4;
    const lanes Nbm53d5 = J33s5_6 - panda_geometry_D4 * m5_1e5;
    const lanes M5_5 = X[31] + J33s5_6;
    const lanes Fbm51e4 = -C4 * m5_2e5;
    const lanes Fbm52e4 = -S4 * m5_2e5;
    const lanes Nbm53d4 = panda_geometry_D4 * Fbm52e4 - J23e5_5;
    const lanes Nbm52r3 = panda_geometry_R3 * Fbm51e4 - Nbm53d4;
    const lanes Nbm51e4 = C4 * J13e5_5 - S4 * Nbm53d5;
    const lanes Nbm52e4 = C4 * Nbm53d5 + S4 * J13e5_5;
    const lanes Nbm52d4 = panda_geometry_D4 * m5_1e5 + Nbm52e4;
    const lanes Nbm51r3 = Nbm51e4 - panda_geometry_R3 * m5_1e5;
    const lanes Nbm51e3 = C3 * Nbm51r3 - S3 * Nbm52r3;
    const lanes Nbm52e3 = C3 * Nbm52r3 + S3 * Nbm51r3;
    const lanes Nbm52e2 = S2 * Nbm51e3 - C2 * Nbm52d4;
    const lanes Nbm62r5 = -panda_geometry_R5 * m6_2e6 - J33s6_7;
    const lanes M6_6 = X[39] + J33s6_7;
    const lanes Fbm61e5 = -C5 * m6_2e6;
    const lanes Fbm62e5 = -S5 * m6_2e6;
    const lanes Nbm61e5 = C5 * J13e6_6 - S5 * Nbm62r5;
    const lanes Nbm62e5 = C5 * Nbm62r5 + S5 * J13e6_6;
    const lanes Nbm62d5 = panda_geometry_D4 * m6_1e6 + Nbm62e5;
    const lanes Nbm63d5 = J23e6_6 - panda_geometry_D4 * Fbm62e5;
    const lanes Fbm61e4 = C4 * Fbm61e5 - S4 * m6_1e6;
    const lanes Fbm62e4 = C4 * m6_1e6 + S4 * Fbm61e5;
    const lanes Nbm63d4 = panda_geometry_D4 * Fbm62e4 - Nbm62d5;
    const lanes Nbm62r3 = panda_geometry_R3 * Fbm61e4 - Nbm63d4;
    const lanes Nbm61e4 = C4 * Nbm61e5 - S4 * Nbm63d5;
    const lanes Nbm62e4 = C4 * Nbm63d5 + S4 * Nbm61e5;
    const lanes Nbm62d4 = panda_geometry_D4 * Fbm62e5 + Nbm62e4;
    const lanes Nbm61r3 = Nbm61e4 - panda_geometry_R3 * Fbm62e5;
    const lanes Nbm61e3 = C3 * Nbm61r3 - S3 * Nbm62r3;
    const lanes Nbm62e3 = C3 * Nbm62r3 + S3 * Nbm61r3;
    const lanes Nbm62e2 = S2 * Nbm61e3 - C2 * Nbm62d4;
    const lanes Nbm73d7 = X[44] + panda_geometry_D7 * m7_1e7;
    const lanes Fbm71e6 = -C6 * m7_2e7;
    const lanes Fbm72e6 = -S6 * m7_2e7;
    const lanes Nbm71e6 = C6 * J13e7_7 + S6 * Nbm73d7;
    const lanes Nbm72e6 = S6 * J13e7_7 - C6 * Nbm73d7;
    const lanes Nbm71r5 = panda_geometry_R5 * m7_1e7 + Nbm71e6;
    const lanes Nbm72r5 = panda_geometry_R5 * Fbm71e6 - J23e7_7;
    const lanes Fbm71e5 = C5 * Fbm71e6 + S5 * m7_1e7;
    const lanes Fbm72e5 = S5 * Fbm71e6 - C5 * m7_1e7;
    const lanes Nbm71e5 = C5 * Nbm71r5 - S5 * Nbm72r5;
    const lanes Nbm72e5 = C5 * Nbm72r5 + S5 * Nbm71r5;
    const lanes Nbm72d5 = panda_geometry_D4 * Fbm72e6 + Nbm72e5;
    const lanes Nbm73d5 = Nbm72e6 - panda_geometry_D4 * Fbm72e5;
    const lanes Fbm71e4 = C4 * Fbm71e5 - S4 * Fbm72e6;
    const lanes Fbm72e4 = C4 * Fbm72e6 + S4 * Fbm71e5;
    const lanes Nbm73d4 = panda_geometry_D4 * Fbm72e4 - Nbm72d5;
    const lanes Nbm72r3 = panda_geometry_R3 * Fbm71e4 - Nbm73d4;
    const lanes Nbm71e4 = C4 * Nbm71e5 - S4 * Nbm73d5;
    const lanes Nbm72e4 = C4 * Nbm73d5 + S4 * Nbm71e5;
    const lanes Nbm72d4 = panda_geometry_D4 * Fbm72e5 + Nbm72e4;
    const lanes Nbm71r3 = Nbm71e4 - panda_geometry_R3 * Fbm72e5;
    const lanes Nbm71e3 = C3 * Nbm71r3 - S3 * Nbm72r3;
    const lanes Nbm72e3 = C3 * Nbm72r3 + S3 * Nbm71r3;
    const lanes Nbm72e2 = S2 * Nbm71e3 - C2 * Nbm72d4;
    const lanes M7_7 = X[44] + X[47];
    lanes_put(&D_out[6], M7_7, stream);
    const lanes d7 = 1.0 / M7_7;
    const lanes l7_1 = -Nbm72e2 * d7;
    lanes_put(&L_out[6], l7_1, stream);
    const lanes m7_1_1 = J33s1_2 + Nbm72e2 * l7_1;
    const lanes l7_2 = Nbm72e3 * d7;
    lanes_put(&L_out[13], l7_2, stream);
    const lanes m7_2_1 = Nbm72e2 * l7_2 - J23e2_2;
    const lanes m7_2_2 = J33s2_3 - Nbm72e3 * l7_2;
    const lanes l7_3 = Nbm72d4 * d7;
    lanes_put(&L_out[20], l7_3, stream);
    const lanes m7_3_1 = Nbm72e2 * l7_3 - Nbm32e2;
    const lanes m7_3_2 = J23e3_3 - Nbm72e3 * l7_3;
    const lanes m7_3_3 = M3_3 - Nbm72d4 * l7_3;
    const lanes l7_4 = -Nbm72d5 * d7;
    lanes_put(&L_out[27], l7_4, stream);
    const lanes m7_4_1 = Nbm72e2 * l7_4 - Nbm42e2;
    const lanes m7_4_2 = Nbm42e3 - Nbm72e3 * l7_4;
    const lanes m7_4_3 = J23e4_4 - Nbm72d4 * l7_4;
    const lanes m7_4_4 = Nbm72d5 * l7_4 + M4_4;
    const lanes l7_5 = Nbm72e6 * d7;
    lanes_put(&L_out[34], l7_5, stream);
    const lanes l7_6 = J23e7_7 * d7;
    lanes_put(&L_out[41], l7_6, stream);
    const lanes m7_5_1 = Nbm72e2 * l7_5 - Nbm52e2;
    const lanes m7_5_2 = Nbm52e3 - Nbm72e3 * l7_5;
    const lanes m7_5_3 = Nbm52d4 - Nbm72d4 * l7_5;
    const lanes m7_5_4 = Nbm72d5 * l7_5 - J23e5_5;
    const lanes m7_5_5 = M5_5 - Nbm72e6 * l7_5;
    const lanes m7_6_1 = Nbm72e2 * l7_6 - Nbm62e2;
    const lanes m7_6_2 = Nbm62e3 - Nbm72e3 * l7_6;
    const lanes m7_6_3 = Nbm62d4 - Nbm72d4 * l7_6;
    const lanes m7_6_4 = Nbm72d5 * l7_6 - Nbm62d5;
    const lanes m7_6_5 = J23e6_6 - Nbm72e6 * l7_6;
    const lanes m7_6_6 = M6_6 - J23e7_7 * l7_6;
    lanes_put(&D_out[5], m7_6_6, stream);
    const lanes d6 = 1.0 / m7_6_6;
    const lanes l6_1 = m7_6_1 * d6;
    lanes_put(&L_out[5], l6_1, stream);
    const lanes m6_1_1 = m7_1_1 - m7_6_1 * l6_1;
    const lanes l6_2 = m7_6_2 * d6;
    lanes_put(&L_out[12], l6_2, stream);
    const lanes m6_2_1 = m7_2_1 - m7_6_1 * l6_2;
    const lanes m6_2_2 = m7_2_2 - m7_6_2 * l6_2;
    const lanes l6_3 = m7_6_3 * d6;
    lanes_put(&L_out[19], l6_3, stream);
    const lanes m6_3_1 = m7_3_1 - m7_6_1 * l6_3;
    const lanes m6_3_2 = m7_3_2 - m7_6_2 * l6_3;
    const lanes m6_3_3 = m7_3_3 - m7_6_3 * l6_3;
    const lanes l6_4 = m7_6_4 * d6;
    lanes_put(&L_out[26], l6_4, stream);
    const lanes l6_5 = m7_6_5 * d6;
    lanes_put(&L_out[33], l6_5, stream);
    const lanes m6_4_1 = m7_4_1 - m7_6_1 * l6_4;
    const lanes m6_4_2 = m7_4_2 - m7_6_2 * l6_4;
    const lanes m6_4_3 = m7_4_3 - m7_6_3 * l6_4;
    const lanes m6_4_4 = m7_4_4 - m7_6_4 * l6_4;
    const lanes m6_5_1 = m7_5_1 - m7_6_1 * l6_5;
    const lanes m6_5_2 = m7_5_2 - m7_6_2 * l6_5;
    const lanes m6_5_3 = m7_5_3 - m7_6_3 * l6_5;
    const lanes m6_5_4 = m7_5_4 - m7_6_4 * l6_5;
    const lanes m6_5_5 = m7_5_5 - m7_6_5 * l6_5;
    lanes_put(&D_out[4], m6_5_5, stream);
    const lanes d5 = 1.0 / m6_5_5;
    const lanes l5_1 = m6_5_1 * d5;
    lanes_put(&L_out[4], l5_1, stream);
    const lanes m5_1_1 = m6_1_1 - m6_5_1 * l5_1;
    const lanes l5_2 = m6_5_2 * d5;
    lanes_put(&L_out[11], l5_2, stream);
    const lanes m5_2_1 = m6_2_1 - m6_5_1 * l5_2;
    const lanes m5_2_2 = m6_2_2 - m6_5_2 * l5_2;
    const lanes l5_3 = m6_5_3 * d5;
    lanes_put(&L_out[18], l5_3, stream);
    const lanes l5_4 = m6_5_4 * d5;
    lanes_put(&L_out[25], l5_4, stream);
    const lanes m5_3_1 = m6_3_1 - m6_5_1 * l5_3;
    const lanes m5_3_2 = m6_3_2 - m6_5_2 * l5_3;
    const lanes m5_3_3 = m6_3_3 - m6_5_3 * l5_3;
    const lanes m5_4_1 = m6_4_1 - m6_5_1 * l5_4;
    const lanes m5_4_2 = m6_4_2 - m6_5_2 * l5_4;
    const lanes m5_4_3 = m6_4_3 - m6_5_3 * l5_4;
    const lanes m5_4_4 = m6_4_4 - m6_5_4 * l5_4;
    lanes_put(&D_out[3], m5_4_4, stream);
    const lanes d4 = 1.0 / m5_4_4;
    const lanes l4_1 = m5_4_1 * d4;
    lanes_put(&L_out[3], l4_1, stream);
    const lanes m4_1_1 = m5_1_1 - m5_4_1 * l4_1;
    const lanes l4_2 = m5_4_2 * d4;
    lanes_put(&L_out[10], l4_2, stream);
    const lanes l4_3 = m5_4_3 * d4;
    lanes_put(&L_out[17], l4_3, stream);
    const lanes m4_2_1 = m5_2_1 - m5_4_1 * l4_2;
    const lanes m4_2_2 = m5_2_2 - m5_4_2 * l4_2;
    const lanes m4_3_1 = m5_3_1 - m5_4_1 * l4_3;
    const lanes m4_3_2 = m5_3_2 - m5_4_2 * l4_3;
    const lanes m4_3_3 = m5_3_3 - m5_4_3 * l4_3;
    lanes_put(&D_out[2], m4_3_3, stream);
    const lanes d3 = 1.0 / m4_3_3;
    const lanes l3_1 = m4_3_1 * d3;
    lanes_put(&L_out[2], l3_1, stream);
    const lanes l3_2 = m4_3_2 * d3;
    lanes_put(&L_out[9], l3_2, stream);
    const lanes m3_1_1 = m4_1_1 - m4_3_1 * l3_1;
    const lanes m3_2_1 = m4_2_1 - m4_3_1 * l3_2;
    const lanes m3_2_2 = m4_2_2 - m4_3_2 * l3_2;
    lanes_put(&D_out[1], m3_2_2, stream);
    const lanes d2 = 1.0 / m3_2_2;
    const lanes l2_1 = m3_2_1 * d2;
    lanes_put(&L_out[1], l2_1, stream);
    const lanes m2_1_1 = m3_1_1 - m3_2_1 * l2_1;
    lanes_put(&D_out[0], m2_1_1, stream);
    const mask singular = (mask)(M7_7 <= 0.0) | (mask)(m7_6_6 <= 0.0) | (mask)(m6_5_5 <= 0.0) | (mask)(m5_4_4 <= 0.0) | (mask)(m4_3_3 <= 0.0) | (mask)(m3_2_2 <= 0.0) | (mask)(m2_1_1 <= 0.0);
    const mask odd = (~(mask)(M7_7 > 0.0) & ~(mask)(M7_7 <= 0.0)) | (~(mask)(m7_6_6 > 0.0) & ~(mask)(m7_6_6 <= 0.0)) | (~(mask)(m6_5_5 > 0.0) & ~(mask)(m6_5_5 <= 0.0)) | (~(mask)(m5_4_4 > 0.0) & ~(mask)(m5_4_4 <= 0.0)) | (~(mask)(m4_3_3 > 0.0) & ~(mask)(m4_3_3 <= 0.0)) | (~(mask)(m3_2_2 > 0.0) & ~(mask)(m3_2_2 <= 0.0)) | (~(mask)(m2_1_1 > 0.0) & ~(mask)(m2_1_1 <= 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l2_1 - l2_1 == 0.0)) | (~(mask)(l3_1 - l3_1 == 0.0)) | (~(mask)(l4_1 - l4_1 == 0.0)) | (~(mask)(l5_1 - l5_1 == 0.0)) | (~(mask)(l6_1 - l6_1 == 0.0)) | (~(mask)(l7_1 - l7_1 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l3_2 - l3_2 == 0.0)) | (~(mask)(l4_2 - l4_2 == 0.0)) | (~(mask)(l5_2 - l5_2 == 0.0)) | (~(mask)(l6_2 - l6_2 == 0.0)) | (~(mask)(l7_2 - l7_2 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l4_3 - l4_3 == 0.0)) | (~(mask)(l5_3 - l5_3 == 0.0)) | (~(mask)(l6_3 - l6_3 == 0.0)) | (~(mask)(l7_3 - l7_3 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l5_4 - l5_4 == 0.0)) | (~(mask)(l6_4 - l6_4 == 0.0)) | (~(mask)(l7_4 - l7_4 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l6_5 - l6_5 == 0.0)) | (~(mask)(l7_5 - l7_5 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l7_6 - l7_6 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(m2_1_1 - m2_1_1 == 0.0)) | (~(mask)(m3_2_2 - m3_2_2 == 0.0)) | (~(mask)(m4_3_3 - m4_3_3 == 0.0)) | (~(mask)(m5_4_4 - m5_4_4 == 0.0)) | (~(mask)(m6_5_5 - m6_5_5 == 0.0)) | (~(mask)(m7_6_6 - m7_6_6 == 0.0)) | (~(mask)(M7_7 - M7_7 == 0.0));
    const int status = (lanes_any(singular) ? (int)panda_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int)panda_NOT_FINITE : 0);
    return status;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *X, apart *L_out, apart *D_out)
{
    return panel(q, X, L_out, D_out, 0);
}

int panda_mass_matrix_factor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_X[REACH(48u)];
    lanes lanes_X[BLOCKS(48u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(X, 48u, lanes_X);
    lanes lanes_L_out[BLOCKS(49u)];
    lanes lanes_D_out[BLOCKS(7u)];
    double scratch[49u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_L_out, 0, sizeof lanes_L_out);
    memset(lanes_D_out, 0, sizeof lanes_D_out);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        const size_t count = (N - k < panda_WIDTH) ? (N - k) : panda_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_load(X, 48u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_X, (apart *)lanes_L_out, (apart *)lanes_D_out);
        lanes_store(lanes_L_out, 49u, count, stream, scratch, &L_out[k * 49u]);
        lanes_store(lanes_D_out, 7u, count, stream, scratch, &D_out[k * 7u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *X, double *L_out, double *D_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_X[REACH(48u)];
    lanes lanes_X[BLOCKS(48u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(X, 48u, lanes_X);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_load(X, 48u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_L_out = (apart *)&L_out[k * 49u];
        apart *lanes_D_out = (apart *)&D_out[k * 7u];
        status |= stream ? panel(lanes_q, lanes_X, lanes_L_out, lanes_D_out, 1) : plain(lanes_q, lanes_X, lanes_L_out, lanes_D_out);
    }
    return status;
}

int panda_mass_matrix_factor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    if (!(streamed(stream, L_out) && streamed(stream, D_out))) {
        return panels(0, N, strides, q, X, L_out, D_out);
    }
    const int status = panels(1, N, strides, q, X, L_out, D_out);
    stream_end();
    return status;
}

#else

int panda_mass_matrix_factor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        status |= panda_mass_matrix_factor(&q[k * stride_q], &X[k * stride_X], &L_out[k * 49u], &D_out[k * 7u]);
    }
    return status;
}

int panda_mass_matrix_factor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    return panda_mass_matrix_factor_rows(stream, N, strides, q, X, L_out, D_out);
}

#endif

size_t panda_mass_matrix_factor_width(void)
{
    return panda_WIDTH;
}

int panda_mass_matrix_factor_batch(size_t N, const double *q, const double *X, double *L_out, double *D_out)
{
    return panda_mass_matrix_factor_rows(0, N, NULL, q, X, L_out, D_out);
}
