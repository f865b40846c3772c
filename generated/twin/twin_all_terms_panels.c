/* twin: all_terms of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *M, apart *h, apart *tau, apart *J_out, apart *T_out, const int stream)
{
    (void)stream;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    const double gz = 9.81;
    const double b2 = 0.6;
    lanes_put(&J_out[35], lanes_all(1.0), stream);
    lanes_put(&T_out[10], lanes_all(1.0), stream);
    lanes_put(&T_out[15], lanes_all(1.0), stream);
    lanes_put(&T_out[27], lanes_all(b2), stream);
    lanes_put(&T_out[31], lanes_all(1.0), stream);
    lanes_put(&T_out[47], lanes_all(1.0), stream);
    lanes_put(&T_out[63], lanes_all(1.0), stream);
    lanes_put(&T_out[75], lanes_all(b2), stream);
    lanes_put(&T_out[79], lanes_all(1.0), stream);
    lanes_put(&T_out[95], lanes_all(1.0), stream);
    lanes_put(&T_out[111], lanes_all(1.0), stream);
    turned q_0 = lanes_turn(q[0]);
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_6 = lanes_turn(q[6]);
    if (lanes_any(~(mask)(lanes_abs(q[0]) + lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[6]) <= NEAR))) {
        q_0 = lanes_far(q[0], q_0);
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_6 = lanes_far(q[6], q_6);
    }
    const lanes M4_4 = X[20] + X[23];
    lanes_put(&M[24], M4_4, stream);
    const lanes M6_6 = X[34] + X[35];
    lanes_put(&M[40], M6_6, stream);
    const lanes M7_7 = X[40] + X[43];
    lanes_put(&M[48], M7_7, stream);
    const lanes C2 = q_1.c;
    lanes_put(&T_out[25], C2, stream);
    const lanes S2 = q_1.s;
    lanes_put(&T_out[24], S2, stream);
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    lanes_put(&J_out[19], -C5, stream);
    lanes_put(&T_out[73], C5, stream);
    lanes_put(&T_out[90], -C5, stream);
    const lanes S5 = q_4.s;
    lanes_put(&T_out[72], S5, stream);
    lanes_put(&T_out[88], S5, stream);
    const lanes Nbm62e5 = X[32] * S5;
    lanes_put(&M[5], Nbm62e5, stream);
    lanes_put(&M[35], Nbm62e5, stream);
    const lanes R6 = q[5] + d3;
    const lanes C7 = q_6.c;
    const lanes S7 = q_6.s;
    const lanes R1e7_3 = C5 * S7 + S5 * C7;
    lanes_put(&T_out[104], R1e7_3, stream);
    const lanes R2e7_3 = C5 * C7 - S5 * S7;
    lanes_put(&T_out[105], R2e7_3, stream);
    const lanes Te7_7 = 2.0 * X[37];
    const lanes ze7_7 = X[36] * S7 + C7 * Te7_7;
    const lanes J11e7_7 = X[36] - S7 * ze7_7;
    const lanes J22e7_7 = S7 * ze7_7;
    const lanes J12e7_7 = C7 * ze7_7 - X[37];
    const lanes J13e7_7 = X[38] * C7 - X[39] * S7;
    const lanes J23e7_7 = X[38] * S7 + X[39] * C7;
    const lanes Nbm72e5 = C5 * J23e7_7 + S5 * J13e7_7;
    lanes_put(&M[6], Nbm72e5, stream);
    lanes_put(&M[42], Nbm72e5, stream);
    const lanes J23r6_6 = -X[32] * R6 - J23e7_7;
    const lanes J13s5_6 = X[26] + J13e7_7;
    const lanes J23s5_6 = X[27] - J23r6_6;
    const lanes J23e5_5 = C5 * J23s5_6 + S5 * J13s5_6;
    lanes_put(&M[4], J23e5_5, stream);
    lanes_put(&M[28], J23e5_5, stream);
    const lanes m7_1e7 = X[41] * C7 - X[42] * S7;
    lanes_put(&M[41], -m7_1e7, stream);
    lanes_put(&M[47], -m7_1e7, stream);
    const lanes m1s6_7 = X[31] + m7_1e7;
    lanes_put(&M[33], -m1s6_7, stream);
    lanes_put(&M[39], -m1s6_7, stream);
    const lanes J13r6_6 = -R6 * m1s6_7 - J12e7_7;
    const lanes J12s5_6 = X[25] - J13r6_6;
    const lanes m1s5_6 = X[29] + m1s6_7;
    const lanes Te5_5 = 2.0 * J12s5_6;
    const lanes m7_2e7 = X[41] * S7 + X[42] * C7;
    const lanes Nbm72r6 = X[40] - R6 * m7_2e7;
    lanes_put(&M[34], Nbm72r6, stream);
    lanes_put(&M[46], Nbm72r6, stream);
    const lanes m3s6_7 = X[33] - m7_2e7;
    const lanes wr6_6 = X[34] * R6;
    const lanes xr6_6 = R6 * (2.0 * m3s6_7 + wr6_6);
    const lanes J11r6_6 = J11e7_7 + xr6_6;
    const lanes J22r6_6 = X[40] + xr6_6;
    const lanes m3r6_6 = m3s6_7 + wr6_6;
    const lanes J11s5_6 = X[24] + J11r6_6;
    const lanes J33s5_6 = X[28] + J22r6_6;
    lanes_put(&M[32], J33s5_6, stream);
    const lanes m2s5_6 = X[30] - m3r6_6;
    const lanes De5_5 = J11s5_6 - J22e7_7;
    const lanes ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const lanes J22e5_5 = S5 * ze5_5 + J22e7_7;
    const lanes m5_1e5 = C5 * m1s5_6 - S5 * m2s5_6;
    const lanes wd5_5 = X[34] * d2;
    const lanes xd5_5 = d2 * (2.0 * m5_1e5 + wd5_5);
    const lanes J22d5_5 = J22e5_5 + xd5_5;
    const lanes J33s1_5 = X[0] + J22d5_5;
    const lanes J13r4_4 = X[18] - X[21] * r4;
    const lanes J23r4_4 = X[19] - X[22] * r4;
    const lanes Te4_4 = 2.0 * X[17];
    const lanes ze4_4 = X[16] * S4 + C4 * Te4_4;
    const lanes J11e4_4 = X[16] - S4 * ze4_4;
    const lanes J11s3_4 = X[8] + J11e4_4;
    const lanes J22e4_4 = S4 * ze4_4;
    const lanes J12e4_4 = C4 * ze4_4 - X[17];
    const lanes J13s3_4 = X[10] + J12e4_4;
    const lanes J33s3_4 = X[12] + J22e4_4;
    const lanes M3_3 = X[15] + J33s3_4;
    lanes_put(&M[16], M3_3, stream);
    const lanes J13e4_4 = C4 * J13r4_4 - S4 * J23r4_4;
    const lanes J23e4_4 = C4 * J23r4_4 + S4 * J13r4_4;
    lanes_put(&M[17], J23e4_4, stream);
    lanes_put(&M[23], J23e4_4, stream);
    const lanes m4_1e4 = X[21] * C4 - X[22] * S4;
    const lanes m4_2e4 = X[21] * S4 + X[22] * C4;
    const lanes J12s3_4 = X[9] - J13e4_4;
    const lanes J23s3_4 = X[11] - J23e4_4;
    const lanes m1s3_4 = X[13] + m4_1e4;
    const lanes De3_3 = J11s3_4 - X[20];
    const lanes Te3_3 = 2.0 * J12s3_4;
    const lanes ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const lanes J11e3_3 = J11s3_4 - S3 * ze3_3;
    const lanes J12e3_3 = C3 * ze3_3 - J12s3_4;
    const lanes J22e3_3 = X[20] + S3 * ze3_3;
    const lanes J11s2_3 = X[1] + J11e3_3;
    const lanes J13e3_3 = C3 * J13s3_4 - S3 * J23s3_4;
    const lanes J23e3_3 = C3 * J23s3_4 + S3 * J13s3_4;
    const lanes Nbm32e2 = C2 * J23e3_3 + S2 * J13e3_3;
    lanes_put(&M[2], Nbm32e2, stream);
    lanes_put(&M[14], Nbm32e2, stream);
    const lanes J13d3_3 = J13e3_3 - d3 * m4_2e4;
    const lanes J13s2_3 = X[3] + J13d3_3;
    const lanes J23s2_3 = X[4] + J23e3_3;
    const lanes J23e2_2 = C2 * J23s2_3 + S2 * J13s2_3;
    lanes_put(&M[1], J23e2_2, stream);
    lanes_put(&M[7], J23e2_2, stream);
    const lanes Fbm42e3 = -S3 * m4_2e4;
    const lanes Nbm43d3 = d3 * Fbm42e3 + J23e4_4;
    lanes_put(&M[10], Nbm43d3, stream);
    lanes_put(&M[22], Nbm43d3, stream);
    const lanes m3_1e3 = C3 * m1s3_4 - X[14] * S3;
    const lanes m3_2e3 = X[14] * C3 + S3 * m1s3_4;
    const lanes J12d3_3 = J12e3_3 - d3 * m3_2e3;
    const lanes J12s2_3 = X[2] + J12d3_3;
    const lanes m2s2_3 = X[7] + m3_2e3;
    const lanes Te2_2 = 2.0 * J12s2_3;
    const lanes Nbm33d3 = d3 * m3_1e3 + J33s3_4;
    lanes_put(&M[9], Nbm33d3, stream);
    lanes_put(&M[15], Nbm33d3, stream);
    const lanes xd3_3 = 2.0 * d3 * m3_1e3;
    const lanes J22d3_3 = J22e3_3 + xd3_3;
    const lanes J33d3_3 = J33s3_4 + xd3_3;
    const lanes J33s2_3 = X[5] + J33d3_3;
    lanes_put(&M[8], J33s2_3, stream);
    const lanes m1s2_3 = X[6] + m3_1e3;
    const lanes De2_2 = J11s2_3 - J22d3_3;
    const lanes ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const lanes J22e2_2 = S2 * ze2_2 + J22d3_3;
    const lanes m2_1e2 = C2 * m1s2_3 - S2 * m2s2_3;
    const lanes xd2_2 = 2.0 * d2 * m2_1e2;
    const lanes J22d2_2 = J22e2_2 + xd2_2;
    const lanes J33s1_2 = J33s1_5 + J22d2_2;
    lanes_put(&M[0], J33s1_2, stream);
    const lanes Nbm41e3 = X[20] * S3 + C3 * J13e4_4;
    const lanes Nbm42e3 = S3 * J13e4_4 - X[20] * C3;
    const lanes Nbm42d3 = Nbm42e3 - d3 * m4_1e4;
    const lanes Nbm42e2 = C2 * Nbm42d3 + S2 * Nbm41e3;
    const lanes Nbm42d2 = Nbm42e2 - d2 * m4_1e4;
    lanes_put(&M[3], Nbm42d2, stream);
    lanes_put(&M[21], Nbm42d2, stream);
    const lanes ZP22d2 = qd[0] * qd[0];
    const lanes Z1d2 = -d2 * ZP22d2;
    const lanes W1e2 = qd[0] * S2;
    const lanes W2e2 = qd[0] * C2;
    const lanes Z1e2 = gz * S2 + C2 * Z1d2;
    const lanes Z2e2 = gz * C2 - S2 * Z1d2;
    const lanes X12 = qd[1] * W2e2;
    const lanes X22 = -qd[1] * W1e2;
    const lanes ZP12d3 = W1e2 * W2e2;
    const lanes ZA3d3 = -2.0 * X22;
    const lanes ZP22d3 = W2e2 * W2e2;
    const lanes ZP33d3 = qd[1] * qd[1];
    const lanes ZA1d3 = ZP22d3 + ZP33d3;
    const lanes Z1d3 = Z1e2 - d3 * ZA1d3;
    const lanes Z2d3 = d3 * ZP12d3 + Z2e2;
    const lanes Z3d3 = d3 * ZA3d3;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes P112 = W1e2 * W1e2;
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    const lanes W33 = qd[1] + qd[2];
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes X1e4 = C4 * X13;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X2e4 = -S4 * X13;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes Z1e4 = C4 * Z1e3 + S4 * Z3d3;
    const lanes Z2e4 = C4 * Z3d3 - S4 * Z1e3;
    const lanes W34 = qd[3] - W2e3;
    const lanes ZP13r4 = W1e4 * W34;
    const lanes ZA1r4 = X24 + ZP13r4;
    const lanes Z1r4 = r4 * ZA1r4 + Z1e4;
    const lanes A314 = ZP13r4 - X24;
    const lanes ZP23r4 = W2e4 * W34;
    const lanes P334 = W34 * W34;
    const lanes ZA2r4 = ZP23r4 - X14;
    const lanes Z2r4 = r4 * ZA2r4 + Z2e4;
    const lanes ZP11r4 = W1e4 * W1e4;
    const lanes P124 = W1e4 * W2e4;
    const lanes ZP22r4 = W2e4 * W2e4;
    const lanes ZA3r4 = ZP11r4 + ZP22r4;
    const lanes Z3r4 = -r4 * ZA3r4 - Z2e3;
    const lanes W1e5 = qd[0] * S5;
    const lanes W2e5 = qd[0] * C5;
    const lanes Z1e5 = gz * S5 + C5 * Z1d2;
    const lanes Z2e5 = gz * C5 - S5 * Z1d2;
    const lanes X15 = qd[4] * W2e5;
    const lanes X25 = -qd[4] * W1e5;
    const lanes ZP13r6 = -W1e5 * W2e5;
    const lanes ZA2r6 = -2.0 * X15;
    const lanes ZP11r6 = W1e5 * W1e5;
    const lanes ZP22r6 = qd[4] * qd[4];
    const lanes ZA3r6 = ZP11r6 + ZP22r6;
    const lanes Z1r6 = R6 * ZP13r6 + Z1e5;
    const lanes Z2r6 = R6 * ZA2r6;
    const lanes Z3r6 = -R6 * ZA3r6 - Z2e5;
    const lanes F6_3 = X[31] * ZP13r6 + X[34] * Z3r6 - X[33] * ZA3r6;
    const lanes Y6 = 2.0 * qd[5];
    const lanes Z16 = qd[4] * Y6 + Z1r6;
    const lanes Z26 = Z2r6 - W1e5 * Y6;
    const lanes W1e7 = C7 * W1e5 + S7 * W2e5;
    const lanes W2e7 = C7 * W2e5 - S7 * W1e5;
    const lanes P225 = W2e5 * W2e5;
    const lanes X1e7 = C7 * X15 + S7 * X25;
    const lanes X17 = qd[6] * W2e7 + X1e7;
    const lanes X2e7 = C7 * X25 - S7 * X15;
    const lanes X27 = X2e7 - qd[6] * W1e7;
    const lanes Z1e7 = C7 * Z16 - S7 * Z3r6;
    const lanes Z2e7 = -C7 * Z3r6 - S7 * Z16;
    const lanes W37 = qd[4] + qd[6];
    const lanes A322 = 2.0 * X12;
    const lanes B12 = ZP22d3 - ZP33d3;
    const lanes B22 = ZP33d3 - P112;
    const lanes B32 = P112 - ZP22d3;
    const lanes N2_1 = X[1] * X12 + X[3] * ZP12d3 + X[4] * B12 + X[5] * X12 - X[2] * ZA3d3;
    const lanes F2_3 = X[6] * ZA3d3 + X[7] * A322;
    const lanes N2_3 = X[2] * B32 + X[6] * Z2e2 - X[1] * ZP12d3 - X[7] * Z1e2;
    const lanes J31_2 = X[1] - X[5];
    const lanes N2_2 = X[2] * A322 + X[3] * B22 - X[4] * ZP12d3 - X22 * J31_2;
    const lanes P113 = W1e3 * W1e3;
    const lanes P123 = W1e3 * W2e3;
    const lanes P133 = W1e3 * W33;
    const lanes P223 = W2e3 * W2e3;
    const lanes P233 = W2e3 * W33;
    const lanes P333 = W33 * W33;
    const lanes Q13 = P223 + P333;
    const lanes F3_1 = X[14] * P123 - X[13] * Q13;
    const lanes A313 = P133 - X23;
    const lanes Q23 = P113 + P333;
    const lanes F3_2 = X[13] * P123 - X[14] * Q23;
    const lanes A323 = X13 + P233;
    const lanes A3213 = X23 + P133;
    const lanes B13 = P223 - P333;
    const lanes B23 = P333 - P113;
    const lanes B33 = P113 - P223;
    const lanes N3_1 = X[8] * X13 + X[10] * P123 + X[11] * B13 + X[12] * P233 + X[14] * Z3d3 - X[9] * A313;
    const lanes A3123 = X13 - P233;
    const lanes F3_3 = X[13] * A313 + X[14] * A323;
    const lanes N3_3 = X[9] * B33 + X[10] * A3123 + X[11] * A3213 + X[13] * Z2e3 - X[8] * P123 - X[14] * Z1e3;
    const lanes J31_3 = X[8] - X[12];
    const lanes N3_2 = X[9] * A323 + X[10] * B23 + P133 * J31_3 - X[11] * P123 - X[13] * Z3d3;
    const lanes Q14 = ZP22r4 + P334;
    const lanes A214 = P124 - X23;
    const lanes Q24 = ZP11r4 + P334;
    const lanes F4_2 = X[21] * A214 - X[22] * Q24;
    const lanes A324 = X14 + ZP23r4;
    const lanes A124 = X23 + P124;
    const lanes F4_1 = X[22] * A124 - X[21] * Q14;
    const lanes B14 = ZP22r4 - P334;
    const lanes B24 = P334 - ZP11r4;
    const lanes B34 = ZP11r4 - ZP22r4;
    const lanes N4_1 = X[16] * X14 + X[18] * A214 + X[19] * B14 + X[20] * ZP23r4 + X[22] * Z3r4 - X[17] * A314;
    const lanes F4_3 = X[21] * A314 + X[22] * A324;
    const lanes N4_3 = X[17] * B34 + X[19] * ZA1r4 + X[21] * Z2r4 - X[16] * P124 - X[18] * ZA2r4 - X[20] * X23 - X[22] * Z1r4;
    const lanes Nb1r4 = N4_1 - r4 * F4_2;
    const lanes Fs3_4_2 = F3_2 - F4_3;
    const lanes Ns3_4_2 = N3_2 - N4_3;
    const lanes J31_4 = X[16] - X[20];
    const lanes N4_2 = X[17] * A324 + X[18] * B24 + ZP13r4 * J31_4 - X[19] * A124 - X[21] * Z3r4;
    const lanes Nb2r4 = r4 * F4_1 + N4_2;
    const lanes Q15 = ZP22r6 + P225;
    const lanes F6_1 = X[33] * ZP13r6 + X[34] * Z16 - X[31] * Q15;
    const lanes A315 = -2.0 * X25;
    const lanes B15 = P225 - ZP22r6;
    const lanes B25 = ZP22r6 - ZP11r6;
    const lanes N5_1 = X[24] * X15 + X[27] * B15 + X[28] * X15 - X[25] * A315 - X[26] * ZP13r6;
    const lanes J31_5 = X[24] - X[28];
    const lanes N5_2 = X[26] * B25 + X[27] * ZP13r6 - X[25] * ZA2r6 - X25 * J31_5;
    const lanes B35 = ZP11r6 - P225;
    const lanes N5_3 = X[24] * ZP13r6 + X[25] * B35 + X[29] * Z2e5 - X[30] * Z1e5;
    const lanes Q26 = ZP11r6 + P225;
    const lanes F6_2 = X[31] * A315 + X[33] * ZA2r6 + X[34] * Z26 - X[32] * Q26;
    const lanes F5_3 = X[29] * A315 - X[30] * ZA2r6;
    const lanes N6_1 = X[32] * Z3r6 - X[33] * Z26;
    const lanes N6_2 = X[33] * Z16 - X[31] * Z3r6;
    const lanes N6_3 = X[31] * Z26 - X[32] * Z16;
    const lanes P117 = W1e7 * W1e7;
    const lanes P127 = W1e7 * W2e7;
    const lanes P137 = W1e7 * W37;
    const lanes P227 = W2e7 * W2e7;
    const lanes P237 = W2e7 * W37;
    const lanes P337 = W37 * W37;
    const lanes Q17 = P227 + P337;
    const lanes F7_1 = X[42] * P127 - X[41] * Q17;
    const lanes A317 = P137 - X27;
    const lanes A3217 = X27 + P137;
    const lanes Q27 = P117 + P337;
    const lanes F7_2 = X[41] * P127 - X[42] * Q27;
    const lanes A327 = X17 + P237;
    const lanes B17 = P227 - P337;
    const lanes B27 = P337 - P117;
    const lanes B37 = P117 - P227;
    const lanes N7_1 = X[36] * X17 + X[38] * P127 + X[39] * B17 + X[40] * P237 + X[42] * Z26 - X[37] * A317;
    const lanes A3127 = X17 - P237;
    const lanes F7_3 = X[41] * A317 + X[42] * A327;
    const lanes N7_3 = X[37] * B37 + X[38] * A3127 + X[39] * A3217 + X[41] * Z2e7 - X[36] * P127 - X[42] * Z1e7;
    const lanes Fs6_7_2 = F6_2 + F7_3;
    const lanes Ns6_7_2 = N6_2 + N7_3;
    const lanes Fs5_6_3 = F5_3 + Fs6_7_2;
    const lanes J31_7 = X[36] - X[40];
    const lanes N7_2 = X[37] * A327 + X[38] * B27 + P137 * J31_7 - X[39] * P127 - X[41] * Z26;
    const lanes Fb1e7 = C7 * F7_1 - S7 * F7_2;
    const lanes Fb2e7 = C7 * F7_2 + S7 * F7_1;
    const lanes Fs6_7_1 = F6_1 + Fb1e7;
    const lanes Fs6_7_3 = F6_3 - Fb2e7;
    const lanes Nb2r6 = R6 * Fs6_7_1 + Ns6_7_2;
    const lanes Ns5_6_3 = N5_3 + Nb2r6;
    const lanes Nb1e7 = C7 * N7_1 - S7 * N7_2;
    const lanes Nb2e7 = C7 * N7_2 + S7 * N7_1;
    const lanes Ns6_7_1 = N6_1 + Nb1e7;
    const lanes Ns6_7_3 = N6_3 - Nb2e7;
    const lanes Nb1r6 = Ns6_7_1 - R6 * Fs6_7_2;
    const lanes Ns5_6_1 = N5_1 + Nb1r6;
    const lanes Ns5_6_2 = N5_2 - Ns6_7_3;
    const lanes Nb2e5 = C5 * Ns5_6_2 + S5 * Ns5_6_1;
    const lanes Nb2d5 = Nb2e5 - d2 * Fs5_6_3;
    const lanes Fb1e4 = C4 * F4_1 - S4 * F4_2;
    const lanes Fb2e4 = C4 * F4_2 + S4 * F4_1;
    const lanes Fs3_4_1 = F3_1 + Fb1e4;
    const lanes Fs3_4_3 = F3_3 + Fb2e4;
    const lanes Fb2e3 = C3 * Fs3_4_2 + S3 * Fs3_4_1;
    const lanes Fs2_3_3 = F2_3 + Fs3_4_3;
    const lanes Nb1e4 = C4 * Nb1r4 - S4 * Nb2r4;
    const lanes Nb2e4 = C4 * Nb2r4 + S4 * Nb1r4;
    const lanes Ns3_4_1 = N3_1 + Nb1e4;
    const lanes Ns3_4_3 = N3_3 + Nb2e4;
    const lanes Nb3d3 = d3 * Fb2e3 + Ns3_4_3;
    const lanes Ns2_3_3 = N2_3 + Nb3d3;
    const lanes Nb1e3 = C3 * Ns3_4_1 - S3 * Ns3_4_2;
    const lanes Nb2e3 = C3 * Ns3_4_2 + S3 * Ns3_4_1;
    const lanes Nb2d3 = Nb2e3 - d3 * Fs3_4_3;
    const lanes Ns2_3_1 = N2_1 + Nb1e3;
    const lanes Ns2_3_2 = N2_2 + Nb2d3;
    const lanes Nb2e2 = C2 * Ns2_3_2 + S2 * Ns2_3_1;
    const lanes Nb2d2 = Nb2e2 - d2 * Fs2_3_3;
    const lanes Ns1_2_3 = Nb2d5 + Nb2d2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes T1 = qd[0] * X[45] + X[44] * sFS1 + Ns1_2_3;
    lanes_put(&h[0], T1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[47] + X[46] * sFS2 + Ns2_3_3;
    lanes_put(&h[1], T2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[49] + X[48] * sFS3 + Ns3_4_3;
    lanes_put(&h[2], T3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[51] + X[50] * sFS4 + N4_3;
    lanes_put(&h[3], T4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[53] + X[52] * sFS5 + Ns5_6_3;
    lanes_put(&h[4], T5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[55] + X[54] * sFS6 + Fs6_7_3;
    lanes_put(&h[5], T6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    const lanes T7 = qd[6] * X[57] + X[56] * sFS7 + N7_3;
    lanes_put(&h[6], T7, stream);
    const lanes Z1e2_ = gz * S2;
    const lanes Z2e2_ = gz * C2;
    const lanes Z1e3_ = C3 * Z1e2_ + S3 * Z2e2_;
    const lanes Z2e3_ = C3 * Z2e2_ - S3 * Z1e2_;
    const lanes N2_3_ = X[6] * Z2e2_ - X[7] * Z1e2_;
    const lanes Z1e4_ = C4 * Z1e3_;
    const lanes Z2e4_ = -S4 * Z1e3_;
    const lanes N3_3_ = X[13] * Z2e3_ - X[14] * Z1e3_;
    const lanes N4_3_ = X[21] * Z2e4_ - X[22] * Z1e4_;
    lanes_put(&tau[3], N4_3_, stream);
    const lanes Z1e5_ = gz * S5;
    const lanes Z2e5_ = gz * C5;
    const lanes F6_3_ = -X[34] * Z2e5_;
    lanes_put(&tau[5], F6_3_, stream);
    const lanes Z1e7_ = C7 * Z1e5_ + S7 * Z2e5_;
    const lanes Z2e7_ = C7 * Z2e5_ - S7 * Z1e5_;
    const lanes N7_3_ = X[41] * Z2e7_ - X[42] * Z1e7_;
    lanes_put(&tau[6], N7_3_, stream);
    const lanes N4_1_ = -X[22] * Z2e3_;
    const lanes N4_2_ = X[21] * Z2e3_;
    const lanes N5_3_ = X[29] * Z2e5_ - X[30] * Z1e5_;
    const lanes F6_1_ = X[34] * Z1e5_;
    const lanes N6_1_ = -X[32] * Z2e5_;
    const lanes N6_2_ = X[31] * Z2e5_ + X[33] * Z1e5_;
    const lanes N6_3_ = -X[32] * Z1e5_;
    const lanes Ns6_7_2_ = N6_2_ + N7_3_;
    const lanes Nb2r6_ = R6 * F6_1_ + Ns6_7_2_;
    const lanes Ns5_6_3_ = N5_3_ + Nb2r6_;
    lanes_put(&tau[4], Ns5_6_3_, stream);
    const lanes Nb2e5_ = S5 * N6_1_ - C5 * N6_3_;
    const lanes Nb1e4_ = C4 * N4_1_ - S4 * N4_2_;
    const lanes Nb2e4_ = C4 * N4_2_ + S4 * N4_1_;
    const lanes Ns3_4_3_ = N3_3_ + Nb2e4_;
    lanes_put(&tau[2], Ns3_4_3_, stream);
    const lanes Ns2_3_3_ = N2_3_ + Ns3_4_3_;
    lanes_put(&tau[1], Ns2_3_3_, stream);
    const lanes Nb1e3_ = C3 * Nb1e4_ + S3 * N4_3_;
    const lanes Nb2e3_ = S3 * Nb1e4_ - C3 * N4_3_;
    const lanes Nb2e2_ = C2 * Nb2e3_ + S2 * Nb1e3_;
    const lanes Ns1_2_3_ = Nb2e5_ + Nb2e2_;
    lanes_put(&tau[0], Ns1_2_3_, stream);
    const lanes C1 = q_0.c;
    lanes_put(&J_out[25], -C1, stream);
    lanes_put(&J_out[27], -C1, stream);
    lanes_put(&T_out[0], C1, stream);
    lanes_put(&T_out[5], C1, stream);
    lanes_put(&T_out[18], C1, stream);
    lanes_put(&T_out[34], C1, stream);
    lanes_put(&T_out[66], -C1, stream);
    lanes_put(&T_out[81], -C1, stream);
    lanes_put(&T_out[98], -C1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&J_out[32], -S1, stream);
    lanes_put(&J_out[34], -S1, stream);
    lanes_put(&T_out[1], -S1, stream);
    lanes_put(&T_out[4], S1, stream);
    lanes_put(&T_out[22], S1, stream);
    lanes_put(&T_out[38], S1, stream);
    lanes_put(&T_out[70], -S1, stream);
    lanes_put(&T_out[85], -S1, stream);
    lanes_put(&T_out[102], -S1, stream);
    const lanes pd2_1 = -d2 * S1;
    lanes_put(&T_out[19], pd2_1, stream);
    lanes_put(&T_out[67], -pd2_1, stream);
    const lanes pd2_2 = d2 * C1;
    lanes_put(&T_out[23], pd2_2, stream);
    lanes_put(&T_out[71], -pd2_2, stream);
    const lanes R2e5_1 = -S5 * S1;
    lanes_put(&J_out[5], -R2e5_1, stream);
    lanes_put(&T_out[65], R2e5_1, stream);
    lanes_put(&T_out[82], -R2e5_1, stream);
    const lanes R2e5_2 = S5 * C1;
    lanes_put(&J_out[12], -R2e5_2, stream);
    lanes_put(&T_out[69], R2e5_2, stream);
    lanes_put(&T_out[86], -R2e5_2, stream);
    const lanes pr6_1 = -R6 * R2e5_1 - pd2_1;
    lanes_put(&J_out[7], pr6_1, stream);
    lanes_put(&T_out[83], pr6_1, stream);
    lanes_put(&T_out[99], pr6_1, stream);
    const lanes a5_1 = pd2_1 + pr6_1;
    const lanes pr6_2 = -R6 * R2e5_2 - pd2_2;
    lanes_put(&J_out[0], -pr6_2, stream);
    lanes_put(&T_out[87], pr6_2, stream);
    lanes_put(&T_out[103], pr6_2, stream);
    const lanes pr6_3 = b2 - C5 * R6;
    lanes_put(&T_out[91], pr6_3, stream);
    lanes_put(&T_out[107], pr6_3, stream);
    const lanes a5_2 = pd2_2 + pr6_2;
    const lanes a5_3 = pr6_3 - b2;
    const lanes v5_1 = -S1 * a5_3;
    lanes_put(&J_out[4], v5_1, stream);
    const lanes v5_2 = C1 * a5_3;
    lanes_put(&J_out[11], v5_2, stream);
    const lanes v5_3 = S1 * a5_1 - C1 * a5_2;
    lanes_put(&J_out[18], v5_3, stream);
    const lanes R1e2_1 = -C2 * S1;
    lanes_put(&T_out[16], R1e2_1, stream);
    const lanes pd3_1 = d3 * R1e2_1 + pd2_1;
    lanes_put(&T_out[35], pd3_1, stream);
    const lanes R1e2_2 = C2 * C1;
    lanes_put(&T_out[20], R1e2_2, stream);
    const lanes pd3_2 = d3 * R1e2_2 + pd2_2;
    lanes_put(&T_out[39], pd3_2, stream);
    const lanes R2e2_1 = S2 * S1;
    lanes_put(&T_out[17], R2e2_1, stream);
    const lanes R2e2_2 = -S2 * C1;
    lanes_put(&T_out[21], R2e2_2, stream);
    const lanes pd3_3 = d3 * S2 + b2;
    lanes_put(&T_out[43], pd3_3, stream);
    const lanes R1e3_1 = C3 * R1e2_1 + S3 * R2e2_1;
    lanes_put(&T_out[32], R1e3_1, stream);
    const lanes R2e3_1 = C3 * R2e2_1 - S3 * R1e2_1;
    lanes_put(&T_out[33], R2e3_1, stream);
    lanes_put(&T_out[50], -R2e3_1, stream);
    const lanes R1e4_1 = C4 * R1e3_1 + S4 * C1;
    lanes_put(&T_out[48], R1e4_1, stream);
    const lanes R2e4_1 = C4 * C1 - S4 * R1e3_1;
    lanes_put(&T_out[49], R2e4_1, stream);
    const lanes pr4_1 = pd3_1 - r4 * R2e3_1;
    lanes_put(&T_out[51], pr4_1, stream);
    const lanes R1e5_2 = -C5 * C1;
    lanes_put(&T_out[68], R1e5_2, stream);
    lanes_put(&T_out[84], R1e5_2, stream);
    const lanes R1e5_1 = C5 * S1;
    lanes_put(&T_out[64], R1e5_1, stream);
    lanes_put(&T_out[80], R1e5_1, stream);
    const lanes R1e7_1 = C7 * R1e5_1 + S7 * R2e5_1;
    lanes_put(&T_out[96], R1e7_1, stream);
    const lanes R1e7_2 = C7 * R1e5_2 + S7 * R2e5_2;
    lanes_put(&T_out[100], R1e7_2, stream);
    const lanes R2e7_1 = C7 * R2e5_1 - S7 * R1e5_1;
    lanes_put(&T_out[97], R2e7_1, stream);
    const lanes R2e7_2 = C7 * R2e5_2 - S7 * R1e5_2;
    lanes_put(&T_out[101], R2e7_2, stream);
    const lanes R1e3_2 = C3 * R1e2_2 + S3 * R2e2_2;
    lanes_put(&T_out[36], R1e3_2, stream);
    const lanes R2e3_2 = C3 * R2e2_2 - S3 * R1e2_2;
    lanes_put(&T_out[37], R2e3_2, stream);
    lanes_put(&T_out[54], -R2e3_2, stream);
    const lanes R1e4_2 = C4 * R1e3_2 + S4 * S1;
    lanes_put(&T_out[52], R1e4_2, stream);
    const lanes R2e4_2 = C4 * S1 - S4 * R1e3_2;
    lanes_put(&T_out[53], R2e4_2, stream);
    const lanes pr4_2 = pd3_2 - r4 * R2e3_2;
    lanes_put(&T_out[55], pr4_2, stream);
    const lanes R1e3_3 = C2 * S3 + S2 * C3;
    lanes_put(&T_out[40], R1e3_3, stream);
    const lanes R2e3_3 = C2 * C3 - S2 * S3;
    lanes_put(&T_out[41], R2e3_3, stream);
    lanes_put(&T_out[58], -R2e3_3, stream);
    const lanes R1e4_3 = C4 * R1e3_3;
    lanes_put(&T_out[56], R1e4_3, stream);
    const lanes R2e4_3 = -S4 * R1e3_3;
    lanes_put(&T_out[57], R2e4_3, stream);
    const lanes pr4_3 = pd3_3 - r4 * R2e3_3;
    lanes_put(&T_out[59], pr4_3, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *M, apart *h, apart *tau, apart *J_out, apart *T_out)
{
    return panel(q, qd, X, M, h, tau, J_out, T_out, 0);
}

int twin_all_terms_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 58u, lanes_X);
    lanes lanes_M[BLOCKS(49u)];
    lanes lanes_h[BLOCKS(7u)];
    lanes lanes_tau[BLOCKS(7u)];
    lanes lanes_J_out[BLOCKS(42u)];
    lanes lanes_T_out[BLOCKS(112u)];
    double scratch[112u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_M, 0, sizeof lanes_M);
    memset(lanes_h, 0, sizeof lanes_h);
    memset(lanes_tau, 0, sizeof lanes_tau);
    memset(lanes_J_out, 0, sizeof lanes_J_out);
    memset(lanes_T_out, 0, sizeof lanes_T_out);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_M, (apart *)lanes_h, (apart *)lanes_tau, (apart *)lanes_J_out, (apart *)lanes_T_out);
        lanes_store(lanes_M, 49u, count, stream, scratch, &M[k * 49u]);
        lanes_store(lanes_h, 7u, count, stream, scratch, &h[k * 7u]);
        lanes_store(lanes_tau, 7u, count, stream, scratch, &tau[k * 7u]);
        lanes_store(lanes_J_out, 42u, count, stream, scratch, &J_out[k * 42u]);
        lanes_store(lanes_T_out, 112u, count, stream, scratch, &T_out[k * 112u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 58u, lanes_X);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_M = (apart *)&M[k * 49u];
        apart *lanes_h = (apart *)&h[k * 7u];
        apart *lanes_tau = (apart *)&tau[k * 7u];
        apart *lanes_J_out = (apart *)&J_out[k * 42u];
        apart *lanes_T_out = (apart *)&T_out[k * 112u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_M, lanes_h, lanes_tau, lanes_J_out, lanes_T_out, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_M, lanes_h, lanes_tau, lanes_J_out, lanes_T_out);
    }
    return status;
}

int twin_all_terms_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    if (!(streamed(stream, M) && streamed(stream, h) && streamed(stream, tau) && streamed(stream, J_out) && streamed(stream, T_out))) {
        return panels(0, N, strides, q, qd, X, M, h, tau, J_out, T_out);
    }
    const int status = panels(1, N, strides, q, qd, X, M, h, tau, J_out, T_out);
    stream_end();
    return status;
}

#else

int twin_all_terms_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_all_terms(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &M[k * 49u], &h[k * 7u], &tau[k * 7u], &J_out[k * 42u], &T_out[k * 112u]);
    }
    return status;
}

int twin_all_terms_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    return twin_all_terms_rows(stream, N, strides, q, qd, X, M, h, tau, J_out, T_out);
}

#endif

size_t twin_all_terms_width(void)
{
    return twin_WIDTH;
}

void twin_all_terms_batch(size_t N, const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    (void)twin_all_terms_rows(0, N, NULL, q, qd, X, M, h, tau, J_out, T_out);
}
