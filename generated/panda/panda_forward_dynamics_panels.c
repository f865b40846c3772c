/* panda: forward_dynamics of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *tau, const lanes *X, apart *qdd, const int stream)
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
    const lanes b1 = tau[0] - T1;
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[51] + X[50] * sFS2 + Ns2_3_3;
    const lanes b2 = tau[1] - T2;
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[53] + X[52] * sFS3 + Ns3_4_3;
    const lanes b3 = tau[2] - T3;
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[55] + X[54] * sFS4 + Ns4_5_3;
    const lanes b4 = tau[3] - T4;
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[57] + X[56] * sFS5 + Ns5_6_3;
    const lanes b5 = tau[4] - T5;
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[59] + X[58] * sFS6 + Ns6_7_3;
    const lanes b6 = tau[5] - T6;
    const lanes sFS7 = lanes_sign(qd[6]);
    const lanes T7 = qd[6] * X[61] + X[60] * sFS7 + N7_3;
    const lanes b7 = tau[6] - T7;
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
    const lanes d7 = 1.0 / M7_7;
    const lanes l7_1 = -Nbm72e2 * d7;
    const lanes m7_1_1 = J33s1_2 + Nbm72e2 * l7_1;
    const lanes y7_1 = b1 - b7 * l7_1;
    const lanes l7_2 = Nbm72e3 * d7;
    const lanes m7_2_1 = Nbm72e2 * l7_2 - J23e2_2;
    const lanes m7_2_2 = J33s2_3 - Nbm72e3 * l7_2;
    const lanes y7_2 = b2 - b7 * l7_2;
    const lanes l7_3 = Nbm72d4 * d7;
    const lanes m7_3_1 = Nbm72e2 * l7_3 - Nbm32e2;
    const lanes m7_3_2 = J23e3_3 - Nbm72e3 * l7_3;
    const lanes m7_3_3 = M3_3 - Nbm72d4 * l7_3;
    const lanes y7_3 = b3 - b7 * l7_3;
    const lanes l7_4 = -Nbm72d5 * d7;
    const lanes m7_4_1 = Nbm72e2 * l7_4 - Nbm42e2;
    const lanes m7_4_2 = Nbm42e3 - Nbm72e3 * l7_4;
    const lanes m7_4_3 = J23e4_4 - Nbm72d4 * l7_4;
    const lanes m7_4_4 = Nbm72d5 * l7_4 + M4_4;
    const lanes y7_4 = b4 - b7 * l7_4;
    const lanes l7_5 = Nbm72e6 * d7;
    const lanes m7_5_1 = Nbm72e2 * l7_5 - Nbm52e2;
    const lanes m7_5_2 = Nbm52e3 - Nbm72e3 * l7_5;
    const lanes m7_5_3 = Nbm52d4 - Nbm72d4 * l7_5;
    const lanes m7_5_4 = Nbm72d5 * l7_5 - J23e5_5;
    const lanes m7_5_5 = M5_5 - Nbm72e6 * l7_5;
    const lanes y7_5 = b5 - b7 * l7_5;
    const lanes l7_6 = J23e7_7 * d7;
    const lanes m7_6_1 = Nbm72e2 * l7_6 - Nbm62e2;
    const lanes m7_6_2 = Nbm62e3 - Nbm72e3 * l7_6;
    const lanes m7_6_3 = Nbm62d4 - Nbm72d4 * l7_6;
    const lanes m7_6_4 = Nbm72d5 * l7_6 - Nbm62d5;
    const lanes m7_6_5 = J23e6_6 - Nbm72e6 * l7_6;
    const lanes m7_6_6 = M6_6 - J23e7_7 * l7_6;
    const lanes d6 = 1.0 / m7_6_6;
    const lanes y7_6 = b6 - b7 * l7_6;
    const lanes l6_1 = m7_6_1 * d6;
    const lanes m6_1_1 = m7_1_1 - m7_6_1 * l6_1;
    const lanes y6_1 = y7_1 - l6_1 * y7_6;
    const lanes l6_2 = m7_6_2 * d6;
    const lanes m6_2_1 = m7_2_1 - m7_6_1 * l6_2;
    const lanes m6_2_2 = m7_2_2 - m7_6_2 * l6_2;
    const lanes y6_2 = y7_2 - l6_2 * y7_6;
    const lanes l6_3 = m7_6_3 * d6;
    const lanes m6_3_1 = m7_3_1 - m7_6_1 * l6_3;
    const lanes m6_3_2 = m7_3_2 - m7_6_2 * l6_3;
    const lanes m6_3_3 = m7_3_3 - m7_6_3 * l6_3;
    const lanes y6_3 = y7_3 - l6_3 * y7_6;
    const lanes l6_4 = m7_6_4 * d6;
    const lanes m6_4_1 = m7_4_1 - m7_6_1 * l6_4;
    const lanes m6_4_2 = m7_4_2 - m7_6_2 * l6_4;
    const lanes m6_4_3 = m7_4_3 - m7_6_3 * l6_4;
    const lanes m6_4_4 = m7_4_4 - m7_6_4 * l6_4;
    const lanes y6_4 = y7_4 - l6_4 * y7_6;
    const lanes l6_5 = m7_6_5 * d6;
    const lanes m6_5_1 = m7_5_1 - m7_6_1 * l6_5;
    const lanes m6_5_2 = m7_5_2 - m7_6_2 * l6_5;
    const lanes m6_5_3 = m7_5_3 - m7_6_3 * l6_5;
    const lanes m6_5_4 = m7_5_4 - m7_6_4 * l6_5;
    const lanes m6_5_5 = m7_5_5 - m7_6_5 * l6_5;
    const lanes d5 = 1.0 / m6_5_5;
    const lanes y6_5 = y7_5 - l6_5 * y7_6;
    const lanes l5_1 = m6_5_1 * d5;
    const lanes m5_1_1 = m6_1_1 - m6_5_1 * l5_1;
    const lanes y5_1 = y6_1 - l5_1 * y6_5;
    const lanes l5_2 = m6_5_2 * d5;
    const lanes m5_2_1 = m6_2_1 - m6_5_1 * l5_2;
    const lanes m5_2_2 = m6_2_2 - m6_5_2 * l5_2;
    const lanes y5_2 = y6_2 - l5_2 * y6_5;
    const lanes l5_3 = m6_5_3 * d5;
    const lanes m5_3_1 = m6_3_1 - m6_5_1 * l5_3;
    const lanes m5_3_2 = m6_3_2 - m6_5_2 * l5_3;
    const lanes m5_3_3 = m6_3_3 - m6_5_3 * l5_3;
    const lanes y5_3 = y6_3 - l5_3 * y6_5;
    const lanes l5_4 = m6_5_4 * d5;
    const lanes m5_4_1 = m6_4_1 - m6_5_1 * l5_4;
    const lanes m5_4_2 = m6_4_2 - m6_5_2 * l5_4;
    const lanes m5_4_3 = m6_4_3 - m6_5_3 * l5_4;
    const lanes m5_4_4 = m6_4_4 - m6_5_4 * l5_4;
    const lanes d4 = 1.0 / m5_4_4;
    const lanes y5_4 = y6_4 - l5_4 * y6_5;
    const lanes l4_1 = m5_4_1 * d4;
    const lanes m4_1_1 = m5_1_1 - m5_4_1 * l4_1;
    const lanes y4_1 = y5_1 - l4_1 * y5_4;
    const lanes l4_2 = m5_4_2 * d4;
    const lanes m4_2_1 = m5_2_1 - m5_4_1 * l4_2;
    const lanes m4_2_2 = m5_2_2 - m5_4_2 * l4_2;
    const lanes y4_2 = y5_2 - l4_2 * y5_4;
    const lanes l4_3 = m5_4_3 * d4;
    const lanes m4_3_1 = m5_3_1 - m5_4_1 * l4_3;
    const lanes m4_3_2 = m5_3_2 - m5_4_2 * l4_3;
    const lanes m4_3_3 = m5_3_3 - m5_4_3 * l4_3;
    const lanes d3 = 1.0 / m4_3_3;
    const lanes y4_3 = y5_3 - l4_3 * y5_4;
    const lanes l3_1 = m4_3_1 * d3;
    const lanes m3_1_1 = m4_1_1 - m4_3_1 * l3_1;
    const lanes y3_1 = y4_1 - l3_1 * y4_3;
    const lanes l3_2 = m4_3_2 * d3;
    const lanes m3_2_1 = m4_2_1 - m4_3_1 * l3_2;
    const lanes m3_2_2 = m4_2_2 - m4_3_2 * l3_2;
    const lanes d2 = 1.0 / m3_2_2;
    const lanes y3_2 = y4_2 - l3_2 * y4_3;
    const lanes l2_1 = m3_2_1 * d2;
    const lanes m2_1_1 = m3_1_1 - m3_2_1 * l2_1;
    const lanes d1 = 1.0 / m2_1_1;
    const lanes y2_1 = y3_1 - l2_1 * y3_2;
    const lanes o1 = d1 * y2_1;
    lanes_put(&qdd[0], o1, stream);
    const lanes o2 = d2 * y3_2 - l2_1 * o1;
    lanes_put(&qdd[1], o2, stream);
    const lanes o3 = d3 * y4_3 - l3_1 * o1 - l3_2 * o2;
    lanes_put(&qdd[2], o3, stream);
    const lanes o4 = d4 * y5_4 - l4_1 * o1 - l4_2 * o2 - l4_3 * o3;
    lanes_put(&qdd[3], o4, stream);
    const lanes o5 = d5 * y6_5 - l5_1 * o1 - l5_2 * o2 - l5_3 * o3 - l5_4 * o4;
    lanes_put(&qdd[4], o5, stream);
    const lanes o6 = d6 * y7_6 - l6_1 * o1 - l6_2 * o2 - l6_3 * o3 - l6_4 * o4 - l6_5 * o5;
    lanes_put(&qdd[5], o6, stream);
    const lanes o7 = b7 * d7 - l7_1 * o1 - l7_2 * o2 - l7_3 * o3 - l7_4 * o4 - l7_5 * o5 - l7_6 * o6;
    lanes_put(&qdd[6], o7, stream);
    const mask singular = (mask)(M7_7 <= 0.0) | (mask)(m7_6_6 <= 0.0) | (mask)(m6_5_5 <= 0.0) | (mask)(m5_4_4 <= 0.0) | (mask)(m4_3_3 <= 0.0) | (mask)(m3_2_2 <= 0.0) | (mask)(m2_1_1 <= 0.0);
    const mask odd = (~(mask)(M7_7 > 0.0) & ~(mask)(M7_7 <= 0.0)) | (~(mask)(m7_6_6 > 0.0) & ~(mask)(m7_6_6 <= 0.0)) | (~(mask)(m6_5_5 > 0.0) & ~(mask)(m6_5_5 <= 0.0)) | (~(mask)(m5_4_4 > 0.0) & ~(mask)(m5_4_4 <= 0.0)) | (~(mask)(m4_3_3 > 0.0) & ~(mask)(m4_3_3 <= 0.0)) | (~(mask)(m3_2_2 > 0.0) & ~(mask)(m3_2_2 <= 0.0)) | (~(mask)(m2_1_1 > 0.0) & ~(mask)(m2_1_1 <= 0.0)) | (~(mask)(o1 - o1 == 0.0)) | (~(mask)(o2 - o2 == 0.0)) | (~(mask)(o3 - o3 == 0.0)) | (~(mask)(o4 - o4 == 0.0)) | (~(mask)(o5 - o5 == 0.0)) | (~(mask)(o6 - o6 == 0.0)) | (~(mask)(o7 - o7 == 0.0));
    const int status = (lanes_any(singular) ? (int)panda_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int)panda_NOT_FINITE : 0);
    return status;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *tau, const lanes *X, apart *qdd)
{
    return panel(q, qd, tau, X, qdd, 0);
}

int panda_forward_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_tau = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_tau[REACH(7u)];
    lanes lanes_tau[BLOCKS(7u)];
    double padded_X[REACH(62u)];
    lanes lanes_X[BLOCKS(62u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(tau, 7u, lanes_tau);
    lanes_shared(X, 62u, lanes_X);
    lanes lanes_qdd[BLOCKS(7u)];
    double scratch[7u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_qdd, 0, sizeof lanes_qdd);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        const size_t count = (N - k < panda_WIDTH) ? (N - k) : panda_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_tau != 0u) {
            lanes_load(tau, 7u, stride_tau, k, N, padded_tau, lanes_tau);
        }
        if (stride_X != 0u) {
            lanes_load(X, 62u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_tau, lanes_X, (apart *)lanes_qdd);
        lanes_store(lanes_qdd, 7u, count, stream, scratch, &qdd[k * 7u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_tau = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_tau[REACH(7u)];
    lanes lanes_tau[BLOCKS(7u)];
    double padded_X[REACH(62u)];
    lanes lanes_X[BLOCKS(62u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(tau, 7u, lanes_tau);
    lanes_shared(X, 62u, lanes_X);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_tau != 0u) {
            lanes_load(tau, 7u, stride_tau, k, N, padded_tau, lanes_tau);
        }
        if (stride_X != 0u) {
            lanes_load(X, 62u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_qdd = (apart *)&qdd[k * 7u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_tau, lanes_X, lanes_qdd, 1) : plain(lanes_q, lanes_qd, lanes_tau, lanes_X, lanes_qdd);
    }
    return status;
}

int panda_forward_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    if (!(streamed(stream, qdd))) {
        return panels(0, N, strides, q, qd, tau, X, qdd);
    }
    const int status = panels(1, N, strides, q, qd, tau, X, qdd);
    stream_end();
    return status;
}

#else

int panda_forward_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_tau = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        status |= panda_forward_dynamics(&q[k * stride_q], &qd[k * stride_qd], &tau[k * stride_tau], &X[k * stride_X], &qdd[k * 7u]);
    }
    return status;
}

int panda_forward_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    return panda_forward_dynamics_rows(stream, N, strides, q, qd, tau, X, qdd);
}

#endif

size_t panda_forward_dynamics_width(void)
{
    return panda_WIDTH;
}

int panda_forward_dynamics_batch(size_t N, const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    return panda_forward_dynamics_rows(0, N, NULL, q, qd, tau, X, qdd);
}
