/* panda: bias_torque of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *h, const int stream)
{
    (void)stream;
    const double gz = 9.81;
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
    const lanes W1e2 = -qd[0] * S2;
    const lanes W2e2 = -qd[0] * C2;
    const lanes Z1e2 = -gz * S2;
    const lanes Z2e2 = -gz * C2;
    const lanes X12 = qd[1] * W2e2;
    const lanes X22 = -qd[1] * W1e2;
    const lanes W1e3 = qd[1] * S3 + C3 * W1e2;
    const lanes W2e3 = qd[1] * C3 - S3 * W1e2;
    const lanes X1e3 = C3 * X12;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X2e3 = -S3 * X12;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes Z1e3 = C3 * Z1e2;
    const lanes Z2e3 = -S3 * Z1e2;
    const lanes W33 = qd[2] - W2e2;
    const lanes ZP13r3 = W1e3 * W33;
    const lanes ZA1r3 = X23 + ZP13r3;
    const lanes Z1r3 = panda_geometry_R3 * ZA1r3 + Z1e3;
    const lanes ZP23r3 = W2e3 * W33;
    const lanes ZA2r3 = ZP23r3 - X13;
    const lanes Z2r3 = panda_geometry_R3 * ZA2r3 + Z2e3;
    const lanes ZP11r3 = W1e3 * W1e3;
    const lanes ZP22r3 = W2e3 * W2e3;
    const lanes ZA3r3 = ZP11r3 + ZP22r3;
    const lanes Z3r3 = -panda_geometry_R3 * ZA3r3 - Z2e2;
    const lanes ZA2d4 = ZP13r3 - X23;
    const lanes ZP13d4 = -W1e3 * W2e3;
    const lanes W34 = qd[3] - W2e3;
    const lanes ZA3d4 = X22 + ZP13d4;
    const lanes ZP22d4 = W33 * W33;
    const lanes ZA1d4 = ZP22r3 + ZP22d4;
    const lanes Z2d4 = panda_geometry_D4 * ZA2d4 + Z3r3;
    const lanes Z3d4 = panda_geometry_D4 * ZA3d4 - Z2r3;
    const lanes Z1d4 = Z1r3 - panda_geometry_D4 * ZA1d4;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes X1e4 = C4 * X13 - S4 * X22;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X2e4 = -C4 * X22 - S4 * X13;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    const lanes ZP12d5 = -W1e4 * W34;
    const lanes ZA2d5 = X24 + ZP12d5;
    const lanes ZP13d5 = W1e4 * W2e4;
    const lanes ZA3d5 = ZP13d5 - X23;
    const lanes ZP22d5 = W34 * W34;
    const lanes ZP33d5 = W2e4 * W2e4;
    const lanes ZA1d5 = ZP22d5 + ZP33d5;
    const lanes Z2d5 = -panda_geometry_D4 * ZA2d5 - Z3d4;
    const lanes Z3d5 = Z2e4 - panda_geometry_D4 * ZA3d5;
    const lanes Z1d5 = panda_geometry_D4 * ZA1d5 + Z1e4;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes P114 = W1e4 * W1e4;
    const lanes P234 = W2e4 * W34;
    const lanes W35 = qd[4] + W2e4;
    const lanes X1e5 = C5 * X14 + S5 * X23;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X2e5 = C5 * X23 - S5 * X14;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes Z1e5 = C5 * Z1d5 + S5 * Z2d5;
    const lanes Z2e5 = C5 * Z2d5 - S5 * Z1d5;
    const lanes ZP13r5 = W1e5 * W35;
    const lanes ZA1r5 = X25 + ZP13r5;
    const lanes Z1r5 = panda_geometry_R5 * ZA1r5 + Z1e5;
    const lanes ZP23r5 = W2e5 * W35;
    const lanes ZA2r5 = ZP23r5 - X15;
    const lanes Z2r5 = panda_geometry_R5 * ZA2r5 + Z2e5;
    const lanes ZP11r5 = W1e5 * W1e5;
    const lanes ZP22r5 = W2e5 * W2e5;
    const lanes ZA3r5 = ZP11r5 + ZP22r5;
    const lanes Z3r5 = Z3d5 - panda_geometry_R5 * ZA3r5;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes P125 = W1e5 * W2e5;
    const lanes W36 = qd[5] - W2e5;
    const lanes P335 = W35 * W35;
    const lanes X1e6 = C6 * X15 + S6 * X24;
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X2e6 = C6 * X24 - S6 * X15;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes Z1e6 = C6 * Z1r5 + S6 * Z3r5;
    const lanes Z2e6 = C6 * Z3r5 - S6 * Z1r5;
    const lanes ZP12d7 = W1e6 * W36;
    const lanes ZA2d7 = ZP12d7 - X26;
    const lanes ZP13d7 = -W1e6 * W2e6;
    const lanes ZA3d7 = X25 + ZP13d7;
    const lanes ZP22d7 = W36 * W36;
    const lanes ZP33d7 = W2e6 * W2e6;
    const lanes ZA1d7 = ZP22d7 + ZP33d7;
    const lanes Z2d7 = panda_geometry_D7 * ZA2d7 - Z2r5;
    const lanes Z3d7 = panda_geometry_D7 * ZA3d7 - Z2e6;
    const lanes Z1d7 = Z1e6 - panda_geometry_D7 * ZA1d7;
    const lanes W1e7 = C7 * W1e6 + S7 * W36;
    const lanes W2e7 = C7 * W36 - S7 * W1e6;
    const lanes P116 = W1e6 * W1e6;
    const lanes P236 = W2e6 * W36;
    const lanes W37 = qd[6] - W2e6;
    const lanes X1e7 = C7 * X16 - S7 * X25;
    const lanes X17 = qd[6] * W2e7 + X1e7;
    const lanes X2e7 = -C7 * X25 - S7 * X16;
    const lanes X27 = X2e7 - qd[6] * W1e7;
    const lanes Z1e7 = C7 * Z1d7 + S7 * Z2d7;
    const lanes Z2e7 = C7 * Z2d7 - S7 * Z1d7;
    const lanes P112 = W1e2 * W1e2;
    const lanes P122 = W1e2 * W2e2;
    const lanes P222 = W2e2 * W2e2;
    const lanes P332 = qd[1] * qd[1];
    const lanes A312 = -2.0 * X22;
    const lanes A322 = 2.0 * X12;
    const lanes B12 = P222 - P332;
    const lanes B22 = P332 - P112;
    const lanes B32 = P112 - P222;
    const lanes N2_1 = X[1] * X12 + X[3] * P122 + X[4] * B12 + X[5] * X12 - X[2] * A312;
    const lanes N2_3 = X[2] * B32 + X[6] * Z2e2 - X[1] * P122 - X[7] * Z1e2;
    const lanes J31_2 = X[1] - X[5];
    const lanes N2_2 = X[2] * A322 + X[3] * B22 - X[4] * P122 - X22 * J31_2;
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes F3_2 = -X[13] * ZA3d4 - X[14] * Q23;
    const lanes A323 = X13 + ZP23r3;
    const lanes A123 = X22 - ZP13d4;
    const lanes F3_1 = X[14] * A123 - X[13] * ZA1d4;
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes B33 = ZP11r3 - ZP22r3;
    const lanes N3_1 = X[8] * X13 + X[11] * B13 + X[12] * ZP23r3 + X[14] * Z3r3 - X[9] * ZA2d4 - X[10] * ZA3d4;
    const lanes N3_3 = X[8] * ZP13d4 + X[9] * B33 + X[11] * ZA1r3 + X[13] * Z2r3 - X[10] * ZA2r3 - X[12] * X22 - X[14] * Z1r3;
    const lanes J31_3 = X[8] - X[12];
    const lanes N3_2 = X[9] * A323 + X[10] * B23 + ZP13r3 * J31_3 - X[11] * A123 - X[13] * Z3r3;
    const lanes Q24 = ZP22d5 + P114;
    const lanes F4_2 = X[21] * ZA3d5 - X[22] * Q24;
    const lanes A324 = X14 + P234;
    const lanes A124 = X23 + ZP13d5;
    const lanes F4_1 = X[22] * A124 - X[21] * ZA1d5;
    const lanes A3214 = X24 - ZP12d5;
    const lanes B14 = ZP33d5 - ZP22d5;
    const lanes B24 = ZP22d5 - P114;
    const lanes B34 = P114 - ZP33d5;
    const lanes N4_1 = X[16] * X14 + X[17] * ZA2d5 + X[18] * ZA3d5 + X[19] * B14 + X[20] * P234 + X[22] * Z3d4;
    const lanes A3124 = X14 - P234;
    const lanes F4_3 = X[22] * A324 - X[21] * ZA2d5;
    const lanes N4_3 = X[17] * B34 + X[18] * A3124 + X[19] * A3214 + X[21] * Z2e4 - X[16] * ZP13d5 - X[20] * X23 - X[22] * Z1e4;
    const lanes J31_4 = X[16] - X[20];
    const lanes N4_2 = X[17] * A324 + X[18] * B24 - X[19] * A124 - X[21] * Z3d4 - ZP12d5 * J31_4;
    const lanes Q15 = ZP22r5 + P335;
    const lanes A215 = X24 + P125;
    const lanes A315 = ZP13r5 - X25;
    const lanes Q25 = ZP11r5 + P335;
    const lanes F5_2 = X[29] * A215 - X[30] * Q25;
    const lanes A325 = X15 + ZP23r5;
    const lanes A125 = P125 - X24;
    const lanes F5_1 = X[30] * A125 - X[29] * Q15;
    const lanes B15 = ZP22r5 - P335;
    const lanes B25 = P335 - ZP11r5;
    const lanes B35 = ZP11r5 - ZP22r5;
    const lanes N5_1 = X[24] * X15 + X[26] * A215 + X[27] * B15 + X[28] * ZP23r5 + X[30] * Z3r5 - X[25] * A315;
    const lanes F5_3 = X[29] * A315 + X[30] * A325;
    const lanes N5_3 = X[25] * B35 + X[27] * ZA1r5 + X[28] * X24 + X[29] * Z2r5 - X[24] * P125 - X[26] * ZA2r5 - X[30] * Z1r5;
    const lanes J31_5 = X[24] - X[28];
    const lanes N5_2 = X[25] * A325 + X[26] * B25 + ZP13r5 * J31_5 - X[27] * A125 - X[29] * Z3r5;
    const lanes Q26 = ZP22d7 + P116;
    const lanes F6_2 = -X[37] * ZA3d7 - X[38] * Q26;
    const lanes A326 = X16 + P236;
    const lanes A126 = X25 - ZP13d7;
    const lanes F6_1 = X[38] * A126 - X[37] * ZA1d7;
    const lanes A3216 = X26 + ZP12d7;
    const lanes B16 = ZP33d7 - ZP22d7;
    const lanes B26 = ZP22d7 - P116;
    const lanes B36 = P116 - ZP33d7;
    const lanes N6_1 = X[32] * X16 + X[35] * B16 + X[36] * P236 - X[33] * ZA2d7 - X[34] * ZA3d7 - X[38] * Z2r5;
    const lanes A3126 = X16 - P236;
    const lanes F6_3 = X[37] * ZA2d7 + X[38] * A326;
    const lanes N6_3 = X[32] * ZP13d7 + X[33] * B36 + X[34] * A3126 + X[35] * A3216 + X[37] * Z2e6 - X[36] * X25 - X[38] * Z1e6;
    const lanes J31_6 = X[32] - X[36];
    const lanes N6_2 = X[33] * A326 + X[34] * B26 + X[37] * Z2r5 + ZP12d7 * J31_6 - X[35] * A126;
    const lanes P117 = W1e7 * W1e7;
    const lanes P127 = W1e7 * W2e7;
    const lanes P137 = W1e7 * W37;
    const lanes P227 = W2e7 * W2e7;
    const lanes P237 = W2e7 * W37;
    const lanes P337 = W37 * W37;
    const lanes Q17 = P227 + P337;
    const lanes A217 = P127 - X26;
    const lanes A317 = P137 - X27;
    const lanes A3217 = X27 + P137;
    const lanes Q27 = P117 + P337;
    const lanes F7_2 = X[45] * A217 - X[46] * Q27;
    const lanes A327 = X17 + P237;
    const lanes A127 = X26 + P127;
    const lanes F7_1 = X[46] * A127 - X[45] * Q17;
    const lanes B17 = P227 - P337;
    const lanes B27 = P337 - P117;
    const lanes B37 = P117 - P227;
    const lanes N7_1 = X[40] * X17 + X[42] * A217 + X[43] * B17 + X[44] * P237 + X[46] * Z3d7 - X[41] * A317;
    const lanes A3127 = X17 - P237;
    const lanes F7_3 = X[45] * A317 + X[46] * A327;
    const lanes N7_3 = X[41] * B37 + X[42] * A3127 + X[43] * A3217 + X[45] * Z2e7 - X[40] * P127 - X[44] * X26 - X[46] * Z1e7;
    const lanes Fs6_7_2 = F6_2 - F7_3;
    const lanes J31_7 = X[40] - X[44];
    const lanes N7_2 = X[41] * A327 + X[42] * B27 + P137 * J31_7 - X[43] * A127 - X[45] * Z3d7;
    const lanes Fb1e7 = C7 * F7_1 - S7 * F7_2;
    const lanes Fb2e7 = C7 * F7_2 + S7 * F7_1;
    const lanes Fs6_7_1 = F6_1 + Fb1e7;
    const lanes Fs6_7_3 = F6_3 + Fb2e7;
    const lanes Nb3d7 = panda_geometry_D7 * Fb2e7 + N7_3;
    const lanes Ns6_7_2 = N6_2 - Nb3d7;
    const lanes Fs5_6_2 = F5_2 - Fs6_7_3;
    const lanes Nb1e7 = C7 * N7_1 - S7 * N7_2;
    const lanes Nb2e7 = C7 * N7_2 + S7 * N7_1;
    const lanes Nb2d7 = Nb2e7 - panda_geometry_D7 * F7_3;
    const lanes Ns6_7_1 = N6_1 + Nb1e7;
    const lanes Ns6_7_3 = N6_3 + Nb2d7;
    const lanes Ns5_6_2 = N5_2 - Ns6_7_3;
    const lanes Fb1e6 = C6 * Fs6_7_1 - S6 * Fs6_7_2;
    const lanes Fb2e6 = C6 * Fs6_7_2 + S6 * Fs6_7_1;
    const lanes Fs5_6_1 = F5_1 + Fb1e6;
    const lanes Fs5_6_3 = F5_3 + Fb2e6;
    const lanes Nb2r5 = panda_geometry_R5 * Fs5_6_1 + Ns5_6_2;
    const lanes Fs4_5_2 = F4_2 + Fs5_6_3;
    const lanes Nb1e6 = C6 * Ns6_7_1 - S6 * Ns6_7_2;
    const lanes Nb2e6 = C6 * Ns6_7_2 + S6 * Ns6_7_1;
    const lanes Ns5_6_1 = N5_1 + Nb1e6;
    const lanes Ns5_6_3 = N5_3 + Nb2e6;
    const lanes Nb1r5 = Ns5_6_1 - panda_geometry_R5 * Fs5_6_2;
    const lanes Fb1e5 = C5 * Fs5_6_1 - S5 * Fs5_6_2;
    const lanes Fb2e5 = C5 * Fs5_6_2 + S5 * Fs5_6_1;
    const lanes Fs4_5_1 = F4_1 + Fb1e5;
    const lanes Fs4_5_3 = F4_3 - Fb2e5;
    const lanes Nb3d5 = Ns5_6_3 - panda_geometry_D4 * Fb2e5;
    const lanes Ns4_5_2 = N4_2 + Nb3d5;
    const lanes Fs3_4_2 = F3_2 - Fs4_5_3;
    const lanes Nb1e5 = C5 * Nb1r5 - S5 * Nb2r5;
    const lanes Nb2e5 = C5 * Nb2r5 + S5 * Nb1r5;
    const lanes Nb2d5 = panda_geometry_D4 * Fs5_6_3 + Nb2e5;
    const lanes Ns4_5_1 = N4_1 + Nb1e5;
    const lanes Ns4_5_3 = N4_3 - Nb2d5;
    const lanes Fb1e4 = C4 * Fs4_5_1 - S4 * Fs4_5_2;
    const lanes Fb2e4 = C4 * Fs4_5_2 + S4 * Fs4_5_1;
    const lanes Nb3d4 = panda_geometry_D4 * Fb2e4 + Ns4_5_3;
    const lanes Fs3_4_1 = F3_1 + Fb1e4;
    const lanes Ns3_4_2 = N3_2 - Nb3d4;
    const lanes Nb2r3 = panda_geometry_R3 * Fs3_4_1 + Ns3_4_2;
    const lanes Nb1e4 = C4 * Ns4_5_1 - S4 * Ns4_5_2;
    const lanes Nb2e4 = C4 * Ns4_5_2 + S4 * Ns4_5_1;
    const lanes Nb2d4 = Nb2e4 - panda_geometry_D4 * Fs4_5_3;
    const lanes Ns3_4_1 = N3_1 + Nb1e4;
    const lanes Ns3_4_3 = N3_3 + Nb2d4;
    const lanes Nb1r3 = Ns3_4_1 - panda_geometry_R3 * Fs3_4_2;
    const lanes Ns2_3_2 = N2_2 - Ns3_4_3;
    const lanes Nb1e3 = C3 * Nb1r3 - S3 * Nb2r3;
    const lanes Nb2e3 = C3 * Nb2r3 + S3 * Nb1r3;
    const lanes Ns2_3_1 = N2_1 + Nb1e3;
    const lanes Ns2_3_3 = N2_3 + Nb2e3;
    const lanes Nb2e2 = C2 * Ns2_3_2 + S2 * Ns2_3_1;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes T1 = qd[0] * X[49] + X[48] * sFS1 - Nb2e2;
    lanes_put(&h[0], T1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[51] + X[50] * sFS2 + Ns2_3_3;
    lanes_put(&h[1], T2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[53] + X[52] * sFS3 + Ns3_4_3;
    lanes_put(&h[2], T3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[55] + X[54] * sFS4 + Ns4_5_3;
    lanes_put(&h[3], T4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[57] + X[56] * sFS5 + Ns5_6_3;
    lanes_put(&h[4], T5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[59] + X[58] * sFS6 + Ns6_7_3;
    lanes_put(&h[5], T6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    const lanes T7 = qd[6] * X[61] + X[60] * sFS7 + N7_3;
    lanes_put(&h[6], T7, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *h)
{
    return panel(q, qd, X, h, 0);
}

int panda_bias_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(62u)];
    lanes lanes_X[BLOCKS(62u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 62u, lanes_X);
    lanes lanes_h[BLOCKS(7u)];
    double scratch[7u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_h, 0, sizeof lanes_h);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        const size_t count = (N - k < panda_WIDTH) ? (N - k) : panda_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 62u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_h);
        lanes_store(lanes_h, 7u, count, stream, scratch, &h[k * 7u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *h)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(62u)];
    lanes lanes_X[BLOCKS(62u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 62u, lanes_X);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 62u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_h = (apart *)&h[k * 7u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_h, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_h);
    }
    return status;
}

int panda_bias_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h)
{
    if (!(streamed(stream, h))) {
        return panels(0, N, strides, q, qd, X, h);
    }
    const int status = panels(1, N, strides, q, qd, X, h);
    stream_end();
    return status;
}

#else

int panda_bias_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        panda_bias_torque(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &h[k * 7u]);
    }
    return status;
}

int panda_bias_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h)
{
    return panda_bias_torque_rows(stream, N, strides, q, qd, X, h);
}

#endif

size_t panda_bias_torque_width(void)
{
    return panda_WIDTH;
}

void panda_bias_torque_batch(size_t N, const double *q, const double *qd, const double *X, double *h)
{
    (void)panda_bias_torque_rows(0, N, NULL, q, qd, X, h);
}
