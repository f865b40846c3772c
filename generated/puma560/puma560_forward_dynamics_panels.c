/* puma560: forward_dynamics of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

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
    const lanes W1e2 = -qd[0] * S2;
    const lanes W2e2 = -qd[0] * C2;
    const lanes Z1e2 = -gz * S2;
    const lanes Z2e2 = -gz * C2;
    const lanes X12 = qd[1] * W2e2;
    const lanes X22 = -qd[1] * W1e2;
    const lanes ZP11r2 = W1e2 * W1e2;
    const lanes ZP22r2 = W2e2 * W2e2;
    const lanes ZA3r2 = ZP11r2 + ZP22r2;
    const lanes Z3r2 = -puma560_geometry_R2 * ZA3r2;
    const lanes ZP12d3 = W1e2 * W2e2;
    const lanes ZA3d3 = -2.0 * X22;
    const lanes ZP33d3 = qd[1] * qd[1];
    const lanes ZA1d3 = ZP22r2 + ZP33d3;
    const lanes Z2d3 = puma560_geometry_D3 * ZP12d3 + Z2e2;
    const lanes Z3d3 = puma560_geometry_D3 * ZA3d3 + Z3r2;
    const lanes Z1d3 = Z1e2 - puma560_geometry_D3 * ZA1d3;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes W33 = qd[1] + qd[2];
    const lanes ZP13r3 = W1e3 * W33;
    const lanes ZA1r3 = X23 + ZP13r3;
    const lanes ZP23r3 = W2e3 * W33;
    const lanes ZA2r3 = ZP23r3 - X13;
    const lanes ZP11r3 = W1e3 * W1e3;
    const lanes ZP22r3 = W2e3 * W2e3;
    const lanes ZA3r3 = ZP11r3 + ZP22r3;
    const lanes Z1r3 = puma560_geometry_R3 * ZA1r3 + Z1e3;
    const lanes Z2r3 = puma560_geometry_R3 * ZA2r3 + Z2e3;
    const lanes Z3r3 = Z3d3 - puma560_geometry_R3 * ZA3r3;
    const lanes ZA2d4 = ZP13r3 - X23;
    const lanes ZP13d4 = -W1e3 * W2e3;
    const lanes ZP22d4 = W33 * W33;
    const lanes ZA1d4 = ZP22r3 + ZP22d4;
    const lanes Z2d4 = puma560_geometry_D4 * ZA2d4 + Z3r3;
    const lanes Z3d4 = puma560_geometry_D4 * ZP13d4 - Z2r3;
    const lanes Z1d4 = Z1r3 - puma560_geometry_D4 * ZA1d4;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes X1e4 = C4 * X13;
    const lanes X2e4 = -S4 * X13;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes W34 = qd[3] - W2e3;
    const lanes ZP13r4 = W1e4 * W34;
    const lanes ZA1r4 = X24 + ZP13r4;
    const lanes ZP23r4 = W2e4 * W34;
    const lanes ZA2r4 = ZP23r4 - X14;
    const lanes ZP11r4 = W1e4 * W1e4;
    const lanes ZP22r4 = W2e4 * W2e4;
    const lanes ZA3r4 = ZP11r4 + ZP22r4;
    const lanes Z1r4 = puma560_geometry_R4 * ZA1r4 + Z1e4;
    const lanes Z2r4 = puma560_geometry_R4 * ZA2r4 + Z2e4;
    const lanes Z3r4 = Z3d4 - puma560_geometry_R4 * ZA3r4;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes X1e5 = C5 * X14 + S5 * X23;
    const lanes X2e5 = C5 * X23 - S5 * X14;
    const lanes Z1e5 = C5 * Z1r4 - S5 * Z3r4;
    const lanes Z2e5 = -C5 * Z3r4 - S5 * Z1r4;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes X1e6 = C6 * X15 + S6 * X24;
    const lanes X2e6 = C6 * X24 - S6 * X15;
    const lanes Z1e6 = C6 * Z1e5 + S6 * Z2r4;
    const lanes Z2e6 = C6 * Z2r4 - S6 * Z1e5;
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes W36 = qd[5] - W2e5;
    const lanes Q22 = ZP11r2 + ZP33d3;
    const lanes A322 = 2.0 * X12;
    const lanes B12 = ZP22r2 - ZP33d3;
    const lanes J31_2 = X[1] - X[5];
    const lanes B22 = ZP33d3 - ZP11r2;
    const lanes B32 = ZP11r2 - ZP22r2;
    const lanes F2_1 = X[7] * ZP12d3 - X[6] * ZA1d3;
    const lanes F2_2 = X[6] * ZP12d3 - X[7] * Q22;
    const lanes N2_1 = X[1] * X12 + X[3] * ZP12d3 + X[4] * B12 + X[5] * X12 + X[7] * Z3r2 - X[2] * ZA3d3;
    const lanes N2_2 = X[2] * A322 + X[3] * B22 - X[4] * ZP12d3 - X[6] * Z3r2 - X22 * J31_2;
    const lanes N2_3 = X[2] * B32 + X[6] * Z2e2 - X[1] * ZP12d3 - X[7] * Z1e2;
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes A323 = X13 + ZP23r3;
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes J31_3 = X[8] - X[12];
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes B33 = ZP11r3 - ZP22r3;
    const lanes F3_1 = -X[13] * ZA1d4 - X[14] * ZP13d4;
    const lanes F3_2 = -X[13] * ZP13d4 - X[14] * Q23;
    const lanes F3_3 = X[13] * ZA2d4 + X[14] * A323;
    const lanes N3_1 = X[8] * X13 + X[11] * B13 + X[12] * ZP23r3 + X[14] * Z3r3 - X[9] * ZA2d4 - X[10] * ZP13d4;
    const lanes N3_2 = X[9] * A323 + X[10] * B23 + X[11] * ZP13d4 + ZP13r3 * J31_3 - X[13] * Z3r3;
    const lanes N3_3 = X[8] * ZP13d4 + X[9] * B33 + X[11] * ZA1r3 + X[13] * Z2r3 - X[10] * ZA2r3 - X[14] * Z1r3;
    const lanes P124 = W1e4 * W2e4;
    const lanes P334 = W34 * W34;
    const lanes Q14 = ZP22r4 + P334;
    const lanes A214 = P124 - X23;
    const lanes A314 = ZP13r4 - X24;
    const lanes Q24 = ZP11r4 + P334;
    const lanes A324 = X14 + ZP23r4;
    const lanes A124 = X23 + P124;
    const lanes B14 = ZP22r4 - P334;
    const lanes J31_4 = X[16] - X[20];
    const lanes B24 = P334 - ZP11r4;
    const lanes B34 = ZP11r4 - ZP22r4;
    const lanes F4_1 = X[22] * A124 - X[21] * Q14;
    const lanes F4_2 = X[21] * A214 - X[22] * Q24;
    const lanes F4_3 = X[21] * A314 + X[22] * A324;
    const lanes N4_1 = X[16] * X14 + X[18] * A214 + X[19] * B14 + X[20] * ZP23r4 + X[22] * Z3r4 - X[17] * A314;
    const lanes N4_2 = X[17] * A324 + X[18] * B24 + ZP13r4 * J31_4 - X[19] * A124 - X[21] * Z3r4;
    const lanes N4_3 = X[17] * B34 + X[19] * ZA1r4 + X[21] * Z2r4 - X[16] * P124 - X[18] * ZA2r4 - X[20] * X23 - X[22] * Z1r4;
    const lanes P115 = W1e5 * W1e5;
    const lanes P125 = W1e5 * W2e5;
    const lanes P135 = W1e5 * W35;
    const lanes P225 = W2e5 * W2e5;
    const lanes P235 = W2e5 * W35;
    const lanes P335 = W35 * W35;
    const lanes Q15 = P225 + P335;
    const lanes A215 = X24 + P125;
    const lanes A315 = P135 - X25;
    const lanes Q25 = P115 + P335;
    const lanes A325 = X15 + P235;
    const lanes A125 = P125 - X24;
    const lanes A3215 = X25 + P135;
    const lanes B15 = P225 - P335;
    const lanes J31_5 = X[24] - X[28];
    const lanes A3125 = X15 - P235;
    const lanes B25 = P335 - P115;
    const lanes B35 = P115 - P225;
    const lanes F5_1 = X[30] * A125 - X[29] * Q15;
    const lanes F5_2 = X[29] * A215 - X[30] * Q25;
    const lanes F5_3 = X[29] * A315 + X[30] * A325;
    const lanes N5_1 = X[24] * X15 + X[26] * A215 + X[27] * B15 + X[28] * P235 + X[30] * Z2r4 - X[25] * A315;
    const lanes N5_2 = X[25] * A325 + X[26] * B25 + P135 * J31_5 - X[27] * A125 - X[29] * Z2r4;
    const lanes N5_3 = X[25] * B35 + X[26] * A3125 + X[27] * A3215 + X[28] * X24 + X[29] * Z2e5 - X[24] * P125 - X[30] * Z1e5;
    const lanes P116 = W1e6 * W1e6;
    const lanes P126 = W1e6 * W2e6;
    const lanes P136 = W1e6 * W36;
    const lanes P226 = W2e6 * W2e6;
    const lanes P236 = W2e6 * W36;
    const lanes P336 = W36 * W36;
    const lanes Q16 = P226 + P336;
    const lanes A216 = P126 - X25;
    const lanes A316 = P136 - X26;
    const lanes Q26 = P116 + P336;
    const lanes A326 = X16 + P236;
    const lanes A126 = X25 + P126;
    const lanes A3216 = X26 + P136;
    const lanes B16 = P226 - P336;
    const lanes J31_6 = X[32] - X[36];
    const lanes A3126 = X16 - P236;
    const lanes B26 = P336 - P116;
    const lanes B36 = P116 - P226;
    const lanes F6_1 = X[38] * A126 - X[37] * Q16;
    const lanes F6_2 = X[37] * A216 - X[38] * Q26;
    const lanes F6_3 = X[37] * A316 + X[38] * A326;
    const lanes N6_1 = X[32] * X16 + X[34] * A216 + X[35] * B16 + X[36] * P236 - X[33] * A316 - X[38] * Z2e5;
    const lanes N6_2 = X[33] * A326 + X[34] * B26 + X[37] * Z2e5 + P136 * J31_6 - X[35] * A126;
    const lanes N6_3 = X[33] * B36 + X[34] * A3126 + X[35] * A3216 + X[37] * Z2e6 - X[32] * P126 - X[36] * X25 - X[38] * Z1e6;
    const lanes Fb1e6 = C6 * F6_1 - S6 * F6_2;
    const lanes Fb2e6 = C6 * F6_2 + S6 * F6_1;
    const lanes Nb1e6 = C6 * N6_1 - S6 * N6_2;
    const lanes Nb2e6 = C6 * N6_2 + S6 * N6_1;
    const lanes Fs5_6_1 = F5_1 + Fb1e6;
    const lanes Fs5_6_2 = F5_2 - F6_3;
    const lanes Fs5_6_3 = F5_3 + Fb2e6;
    const lanes Ns5_6_1 = N5_1 + Nb1e6;
    const lanes Ns5_6_2 = N5_2 - N6_3;
    const lanes Ns5_6_3 = N5_3 + Nb2e6;
    const lanes Fb1e5 = C5 * Fs5_6_1 - S5 * Fs5_6_2;
    const lanes Fb2e5 = C5 * Fs5_6_2 + S5 * Fs5_6_1;
    const lanes Nb1e5 = C5 * Ns5_6_1 - S5 * Ns5_6_2;
    const lanes Nb2e5 = C5 * Ns5_6_2 + S5 * Ns5_6_1;
    const lanes Fs4_5_1 = F4_1 + Fb1e5;
    const lanes Fs4_5_2 = F4_2 + Fs5_6_3;
    const lanes Fs4_5_3 = F4_3 - Fb2e5;
    const lanes Ns4_5_1 = N4_1 + Nb1e5;
    const lanes Ns4_5_2 = N4_2 + Ns5_6_3;
    const lanes Ns4_5_3 = N4_3 - Nb2e5;
    const lanes Nb1r4 = Ns4_5_1 - puma560_geometry_R4 * Fs4_5_2;
    const lanes Nb2r4 = puma560_geometry_R4 * Fs4_5_1 + Ns4_5_2;
    const lanes Fb1e4 = C4 * Fs4_5_1 - S4 * Fs4_5_2;
    const lanes Fb2e4 = C4 * Fs4_5_2 + S4 * Fs4_5_1;
    const lanes Nb1e4 = C4 * Nb1r4 - S4 * Nb2r4;
    const lanes Nb2e4 = C4 * Nb2r4 + S4 * Nb1r4;
    const lanes Nb2d4 = Nb2e4 - puma560_geometry_D4 * Fs4_5_3;
    const lanes Nb3d4 = puma560_geometry_D4 * Fb2e4 + Ns4_5_3;
    const lanes Fs3_4_1 = F3_1 + Fb1e4;
    const lanes Fs3_4_2 = F3_2 - Fs4_5_3;
    const lanes Fs3_4_3 = F3_3 + Fb2e4;
    const lanes Ns3_4_1 = N3_1 + Nb1e4;
    const lanes Ns3_4_2 = N3_2 - Nb3d4;
    const lanes Ns3_4_3 = N3_3 + Nb2d4;
    const lanes Nb1r3 = Ns3_4_1 - puma560_geometry_R3 * Fs3_4_2;
    const lanes Nb2r3 = puma560_geometry_R3 * Fs3_4_1 + Ns3_4_2;
    const lanes Fb1e3 = C3 * Fs3_4_1 - S3 * Fs3_4_2;
    const lanes Fb2e3 = C3 * Fs3_4_2 + S3 * Fs3_4_1;
    const lanes Nb1e3 = C3 * Nb1r3 - S3 * Nb2r3;
    const lanes Nb2e3 = C3 * Nb2r3 + S3 * Nb1r3;
    const lanes Nb2d3 = Nb2e3 - puma560_geometry_D3 * Fs3_4_3;
    const lanes Nb3d3 = puma560_geometry_D3 * Fb2e3 + Ns3_4_3;
    const lanes Fs2_3_1 = F2_1 + Fb1e3;
    const lanes Fs2_3_2 = F2_2 + Fb2e3;
    const lanes Ns2_3_1 = N2_1 + Nb1e3;
    const lanes Ns2_3_2 = N2_2 + Nb2d3;
    const lanes Ns2_3_3 = N2_3 + Nb3d3;
    const lanes Nb1r2 = Ns2_3_1 - puma560_geometry_R2 * Fs2_3_2;
    const lanes Nb2r2 = puma560_geometry_R2 * Fs2_3_1 + Ns2_3_2;
    const lanes Nb2e2 = C2 * Nb2r2 + S2 * Nb1r2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T1 = qd[0] * X[41] + X[40] * sFS1 - Nb2e2;
    const lanes T2 = qd[1] * X[43] + X[42] * sFS2 + Ns2_3_3;
    const lanes T3 = qd[2] * X[45] + X[44] * sFS3 + Ns3_4_3;
    const lanes T4 = qd[3] * X[47] + X[46] * sFS4 + Ns4_5_3;
    const lanes T5 = qd[4] * X[49] + X[48] * sFS5 + Ns5_6_3;
    const lanes T6 = qd[5] * X[51] + X[50] * sFS6 + N6_3;
    const lanes b1 = tau[0] - T1;
    const lanes b2 = tau[1] - T2;
    const lanes b3 = tau[2] - T3;
    const lanes b4 = tau[3] - T4;
    const lanes b5 = tau[4] - T5;
    const lanes b6 = tau[5] - T6;
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
    const lanes y6_1 = b1 - b6 * l6_1;
    const lanes y6_2 = b2 - b6 * l6_2;
    const lanes y6_3 = b3 - b6 * l6_3;
    const lanes y6_4 = b4 - b6 * l6_4;
    const lanes y6_5 = b5 - b6 * l6_5;
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
    lanes_put(&qdd[0], o1, stream);
    const lanes o2 = d2 * y3_2 - l2_1 * o1;
    lanes_put(&qdd[1], o2, stream);
    const lanes o3 = d3 * y4_3 - l3_1 * o1 - l3_2 * o2;
    lanes_put(&qdd[2], o3, stream);
    const lanes o4 = d4 * y5_4 - l4_1 * o1 - l4_2 * o2 - l4_3 * o3;
    lanes_put(&qdd[3], o4, stream);
    const lanes o5 = d5 * y6_5 - l5_1 * o1 - l5_2 * o2 - l5_3 * o3 - l5_4 * o4;
    lanes_put(&qdd[4], o5, stream);
    const lanes o6 = b6 * d6 - l6_1 * o1 - l6_2 * o2 - l6_3 * o3 - l6_4 * o4 - l6_5 * o5;
    lanes_put(&qdd[5], o6, stream);
    const mask singular = (mask)(M6_6 <= 0.0) | (mask)(m6_5_5 <= 0.0) | (mask)(m5_4_4 <= 0.0) | (mask)(m4_3_3 <= 0.0) | (mask)(m3_2_2 <= 0.0) | (mask)(m2_1_1 <= 0.0);
    const mask odd = (~(mask)(M6_6 > 0.0) & ~(mask)(M6_6 <= 0.0)) | (~(mask)(m6_5_5 > 0.0) & ~(mask)(m6_5_5 <= 0.0)) | (~(mask)(m5_4_4 > 0.0) & ~(mask)(m5_4_4 <= 0.0)) | (~(mask)(m4_3_3 > 0.0) & ~(mask)(m4_3_3 <= 0.0)) | (~(mask)(m3_2_2 > 0.0) & ~(mask)(m3_2_2 <= 0.0)) | (~(mask)(m2_1_1 > 0.0) & ~(mask)(m2_1_1 <= 0.0)) | (~(mask)(o1 - o1 == 0.0)) | (~(mask)(o2 - o2 == 0.0)) | (~(mask)(o3 - o3 == 0.0)) | (~(mask)(o4 - o4 == 0.0)) | (~(mask)(o5 - o5 == 0.0)) | (~(mask)(o6 - o6 == 0.0));
    const int status = (lanes_any(singular) ? (int)puma560_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int)puma560_NOT_FINITE : 0);
    return status;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *tau, const lanes *X, apart *qdd)
{
    return panel(q, qd, tau, X, qdd, 0);
}

int puma560_forward_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_tau = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_tau[REACH(6u)];
    lanes lanes_tau[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(tau, 6u, lanes_tau);
    lanes_shared(X, 52u, lanes_X);
    lanes lanes_qdd[BLOCKS(6u)];
    double scratch[6u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_qdd, 0, sizeof lanes_qdd);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_tau != 0u) {
            lanes_read(tau, 6u, stride_tau, k, N, padded_tau, lanes_tau);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_tau, lanes_X, (apart *)lanes_qdd);
        lanes_store(lanes_qdd, 6u, count, stream, scratch, &qdd[k * 6u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_tau = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_tau[REACH(6u)];
    lanes lanes_tau[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(tau, 6u, lanes_tau);
    lanes_shared(X, 52u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_tau != 0u) {
            lanes_read(tau, 6u, stride_tau, k, N, padded_tau, lanes_tau);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_qdd = (apart *)&qdd[k * 6u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_tau, lanes_X, lanes_qdd, 1) : plain(lanes_q, lanes_qd, lanes_tau, lanes_X, lanes_qdd);
    }
    return status;
}

int puma560_forward_dynamics_panels(int stream, size_t N, const size_t *strides,
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

int puma560_forward_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_tau = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        status |= puma560_forward_dynamics(&q[k * stride_q], &qd[k * stride_qd], &tau[k * stride_tau], &X[k * stride_X], &qdd[k * 6u]);
    }
    return status;
}

int puma560_forward_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    return puma560_forward_dynamics_rows(stream, N, strides, q, qd, tau, X, qdd);
}

#endif

size_t puma560_forward_dynamics_width(void)
{
    return puma560_WIDTH;
}

int puma560_forward_dynamics_batch(size_t N, const double *q, const double *qd, const double *tau, const double *X, double *qdd)
{
    return puma560_forward_dynamics_rows(0, N, NULL, q, qd, tau, X, qdd);
}
