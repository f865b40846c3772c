/* twin: inverse_dynamics of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    const double gz = 9.81;
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_6 = lanes_turn(q[6]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[6]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
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
    const lanes R6 = q[5] + d3;
    const lanes C7 = q_6.c;
    const lanes S7 = q_6.s;
    const lanes ZP22d2 = qd[0] * qd[0];
    const lanes Z1d2 = -d2 * ZP22d2;
    const lanes Z3d2 = -qdd[0] * d2;
    const lanes W1e2 = qd[0] * S2;
    const lanes W2e2 = qd[0] * C2;
    const lanes X1e2 = qdd[0] * S2;
    const lanes X12 = qd[1] * W2e2 + X1e2;
    const lanes X2e2 = qdd[0] * C2;
    const lanes X22 = X2e2 - qd[1] * W1e2;
    const lanes Z1e2 = gz * S2 + C2 * Z1d2;
    const lanes Z2e2 = gz * C2 - S2 * Z1d2;
    const lanes ZP12d3 = W1e2 * W2e2;
    const lanes ZA2d3 = qdd[1] + ZP12d3;
    const lanes ZP13d3 = qd[1] * W1e2;
    const lanes ZA3d3 = ZP13d3 - X22;
    const lanes ZP22d3 = W2e2 * W2e2;
    const lanes ZP33d3 = qd[1] * qd[1];
    const lanes ZA1d3 = ZP22d3 + ZP33d3;
    const lanes Z1d3 = Z1e2 - d3 * ZA1d3;
    const lanes Z2d3 = d3 * ZA2d3 + Z2e2;
    const lanes Z3d3 = d3 * ZA3d3 + Z3d2;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes P112 = W1e2 * W1e2;
    const lanes P232 = qd[1] * W2e2;
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes A3212 = X22 + ZP13d3;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    const lanes X33 = qdd[1] + qdd[2];
    const lanes W33 = qd[1] + qd[2];
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes X1e4 = C4 * X13 + S4 * X33;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X2e4 = C4 * X33 - S4 * X13;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes Z1e4 = C4 * Z1e3 + S4 * Z3d3;
    const lanes Z2e4 = C4 * Z3d3 - S4 * Z1e3;
    const lanes X34 = qdd[3] - X23;
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
    const lanes X1e5 = qdd[0] * S5;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X2e5 = qdd[0] * C5;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes Z1e5 = gz * S5 + C5 * Z1d2;
    const lanes Z2e5 = gz * C5 - S5 * Z1d2;
    const lanes ZP13r6 = -W1e5 * W2e5;
    const lanes ZA1r6 = qdd[4] + ZP13r6;
    const lanes ZP23r6 = -qd[4] * W2e5;
    const lanes ZA2r6 = ZP23r6 - X15;
    const lanes ZP11r6 = W1e5 * W1e5;
    const lanes ZP22r6 = qd[4] * qd[4];
    const lanes ZA3r6 = ZP11r6 + ZP22r6;
    const lanes Z1r6 = R6 * ZA1r6 + Z1e5;
    const lanes Z2r6 = R6 * ZA2r6 + Z3d2;
    const lanes Z3r6 = -R6 * ZA3r6 - Z2e5;
    const lanes Z36 = qdd[5] + Z3r6;
    const lanes Y6 = 2.0 * qd[5];
    const lanes Z16 = qd[4] * Y6 + Z1r6;
    const lanes Z26 = Z2r6 - W1e5 * Y6;
    const lanes W1e7 = C7 * W1e5 + S7 * W2e5;
    const lanes W2e7 = C7 * W2e5 - S7 * W1e5;
    const lanes P135 = qd[4] * W1e5;
    const lanes P225 = W2e5 * W2e5;
    const lanes X1e7 = C7 * X15 + S7 * X25;
    const lanes X17 = qd[6] * W2e7 + X1e7;
    const lanes X2e7 = C7 * X25 - S7 * X15;
    const lanes X27 = X2e7 - qd[6] * W1e7;
    const lanes Z1e7 = C7 * Z16 - S7 * Z36;
    const lanes Z2e7 = -C7 * Z36 - S7 * Z16;
    const lanes X37 = qdd[4] + qdd[6];
    const lanes W37 = qd[4] + qd[6];
    const lanes N1_3 = qdd[0] * X[0];
    const lanes A322 = X12 + P232;
    const lanes A122 = ZP12d3 - qdd[1];
    const lanes B12 = ZP22d3 - ZP33d3;
    const lanes B22 = ZP33d3 - P112;
    const lanes B32 = P112 - ZP22d3;
    const lanes N2_1 = X[1] * X12 + X[3] * ZA2d3 + X[4] * B12 + X[5] * P232 + X[7] * Z3d2 - X[2] * ZA3d3;
    const lanes A3122 = X12 - P232;
    const lanes F2_3 = X[6] * ZA3d3 + X[7] * A322;
    const lanes N2_3 = qdd[1] * X[5] + X[2] * B32 + X[3] * A3122 + X[4] * A3212 + X[6] * Z2e2 - X[1] * ZP12d3 - X[7] * Z1e2;
    const lanes J31_2 = X[1] - X[5];
    const lanes N2_2 = X[2] * A322 + X[3] * B22 + ZP13d3 * J31_2 - X[4] * A122 - X[6] * Z3d2;
    const lanes P113 = W1e3 * W1e3;
    const lanes P123 = W1e3 * W2e3;
    const lanes P133 = W1e3 * W33;
    const lanes P223 = W2e3 * W2e3;
    const lanes P233 = W2e3 * W33;
    const lanes P333 = W33 * W33;
    const lanes Q13 = P223 + P333;
    const lanes A213 = X33 + P123;
    const lanes A313 = P133 - X23;
    const lanes A3213 = X23 + P133;
    const lanes Q23 = P113 + P333;
    const lanes F3_2 = X[13] * A213 - X[14] * Q23;
    const lanes A323 = X13 + P233;
    const lanes A123 = P123 - X33;
    const lanes F3_1 = X[14] * A123 - X[13] * Q13;
    const lanes B13 = P223 - P333;
    const lanes B23 = P333 - P113;
    const lanes B33 = P113 - P223;
    const lanes N3_1 = X[8] * X13 + X[10] * A213 + X[11] * B13 + X[12] * P233 + X[14] * Z3d3 - X[9] * A313;
    const lanes A3123 = X13 - P233;
    const lanes F3_3 = X[13] * A313 + X[14] * A323;
    const lanes N3_3 = X[9] * B33 + X[10] * A3123 + X[11] * A3213 + X[12] * X33 + X[13] * Z2e3 - X[8] * P123 - X[14] * Z1e3;
    const lanes J31_3 = X[8] - X[12];
    const lanes N3_2 = X[9] * A323 + X[10] * B23 + P133 * J31_3 - X[11] * A123 - X[13] * Z3d3;
    const lanes Q14 = ZP22r4 + P334;
    const lanes A214 = X34 + P124;
    const lanes Q24 = ZP11r4 + P334;
    const lanes F4_2 = X[21] * A214 - X[22] * Q24;
    const lanes A324 = X14 + ZP23r4;
    const lanes A124 = P124 - X34;
    const lanes F4_1 = X[22] * A124 - X[21] * Q14;
    const lanes B14 = ZP22r4 - P334;
    const lanes B24 = P334 - ZP11r4;
    const lanes B34 = ZP11r4 - ZP22r4;
    const lanes N4_1 = X[16] * X14 + X[18] * A214 + X[19] * B14 + X[20] * ZP23r4 + X[22] * Z3r4 - X[17] * A314;
    const lanes F4_3 = X[21] * A314 + X[22] * A324;
    const lanes N4_3 = X[17] * B34 + X[19] * ZA1r4 + X[20] * X34 + X[21] * Z2r4 - X[16] * P124 - X[18] * ZA2r4 - X[22] * Z1r4;
    const lanes Nb1r4 = N4_1 - r4 * F4_2;
    const lanes Fs3_4_2 = F3_2 - F4_3;
    const lanes Ns3_4_2 = N3_2 - N4_3;
    const lanes J31_4 = X[16] - X[20];
    const lanes N4_2 = X[17] * A324 + X[18] * B24 + ZP13r4 * J31_4 - X[19] * A124 - X[21] * Z3r4;
    const lanes Nb2r4 = r4 * F4_1 + N4_2;
    const lanes Q15 = ZP22r6 + P225;
    const lanes A215 = qdd[4] - ZP13r6;
    const lanes A315 = P135 - X25;
    const lanes A3215 = X25 + P135;
    const lanes F6_1 = X[32] * A3215 + X[33] * ZA1r6 + X[34] * Z16 - X[31] * Q15;
    const lanes B15 = P225 - ZP22r6;
    const lanes B25 = ZP22r6 - ZP11r6;
    const lanes N5_1 = X[24] * X15 + X[26] * A215 + X[27] * B15 + X[30] * Z3d2 - X[25] * A315 - X[28] * ZP23r6;
    const lanes A3125 = X15 + ZP23r6;
    const lanes F6_3 = X[32] * A3125 + X[34] * Z36 - X[31] * A215 - X[33] * ZA3r6;
    const lanes J31_5 = X[24] - X[28];
    const lanes N5_2 = X[26] * B25 + X[27] * ZA1r6 + P135 * J31_5 - X[25] * ZA2r6 - X[29] * Z3d2;
    const lanes B35 = ZP11r6 - P225;
    const lanes N5_3 = qdd[4] * X[28] + X[24] * ZP13r6 + X[25] * B35 + X[26] * A3125 + X[27] * A3215 + X[29] * Z2e5 - X[30] * Z1e5;
    const lanes Q26 = ZP11r6 + P225;
    const lanes F6_2 = X[31] * A315 + X[33] * ZA2r6 + X[34] * Z26 - X[32] * Q26;
    const lanes F5_3 = X[29] * A315 - X[30] * ZA2r6;
    const lanes N6_1 = X[32] * Z36 - X[33] * Z26;
    const lanes N6_2 = X[33] * Z16 - X[31] * Z36;
    const lanes N6_3 = X[31] * Z26 - X[32] * Z16;
    const lanes P117 = W1e7 * W1e7;
    const lanes P127 = W1e7 * W2e7;
    const lanes P137 = W1e7 * W37;
    const lanes P227 = W2e7 * W2e7;
    const lanes P237 = W2e7 * W37;
    const lanes P337 = W37 * W37;
    const lanes Q17 = P227 + P337;
    const lanes A217 = X37 + P127;
    const lanes A317 = P137 - X27;
    const lanes A3217 = X27 + P137;
    const lanes Q27 = P117 + P337;
    const lanes F7_2 = X[41] * A217 - X[42] * Q27;
    const lanes A327 = X17 + P237;
    const lanes A127 = P127 - X37;
    const lanes F7_1 = X[42] * A127 - X[41] * Q17;
    const lanes B17 = P227 - P337;
    const lanes B27 = P337 - P117;
    const lanes B37 = P117 - P227;
    const lanes N7_1 = X[36] * X17 + X[38] * A217 + X[39] * B17 + X[40] * P237 + X[42] * Z26 - X[37] * A317;
    const lanes A3127 = X17 - P237;
    const lanes F7_3 = X[41] * A317 + X[42] * A327;
    const lanes N7_3 = X[37] * B37 + X[38] * A3127 + X[39] * A3217 + X[40] * X37 + X[41] * Z2e7 - X[36] * P127 - X[42] * Z1e7;
    const lanes Fs6_7_2 = F6_2 + F7_3;
    const lanes Ns6_7_2 = N6_2 + N7_3;
    const lanes Fs5_6_3 = F5_3 + Fs6_7_2;
    const lanes J31_7 = X[36] - X[40];
    const lanes N7_2 = X[37] * A327 + X[38] * B27 + P137 * J31_7 - X[39] * A127 - X[41] * Z26;
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
    const lanes Ns1_5_3 = N1_3 + Nb2d5;
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
    const lanes Ns1_2_3 = Ns1_5_3 + Nb2d2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes T1 = qd[0] * X[45] + X[44] * sFS1 + Ns1_2_3;
    lanes_put(&tau[0], T1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[47] + X[46] * sFS2 + Ns2_3_3;
    lanes_put(&tau[1], T2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[49] + qdd[2] * X[15] + X[48] * sFS3 + Ns3_4_3;
    lanes_put(&tau[2], T3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[51] + qdd[3] * X[23] + X[50] * sFS4 + N4_3;
    lanes_put(&tau[3], T4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[53] + X[52] * sFS5 + Ns5_6_3;
    lanes_put(&tau[4], T5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[55] + qdd[5] * X[35] + X[54] * sFS6 + Fs6_7_3;
    lanes_put(&tau[5], T6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    const lanes T7 = qd[6] * X[57] + qdd[6] * X[43] + X[56] * sFS7 + N7_3;
    lanes_put(&tau[6], T7, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *tau)
{
    return panel(q, qd, qdd, X, tau, 0);
}

int twin_inverse_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdd[REACH(7u)];
    lanes lanes_qdd[BLOCKS(7u)];
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdd, 7u, lanes_qdd);
    lanes_shared(X, 58u, lanes_X);
    lanes lanes_tau[BLOCKS(7u)];
    double scratch[7u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_load(qdd, 7u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 7u, count, stream, scratch, &tau[k * 7u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdd[REACH(7u)];
    lanes lanes_qdd[BLOCKS(7u)];
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdd, 7u, lanes_qdd);
    lanes_shared(X, 58u, lanes_X);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_load(qdd, 7u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 7u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_tau, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_tau);
    }
    return status;
}

int twin_inverse_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    if (!(streamed(stream, tau))) {
        return panels(0, N, strides, q, qd, qdd, X, tau);
    }
    const int status = panels(1, N, strides, q, qd, qdd, X, tau);
    stream_end();
    return status;
}

#else

int twin_inverse_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_inverse_dynamics(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &X[k * stride_X], &tau[k * 7u]);
    }
    return status;
}

int twin_inverse_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    return twin_inverse_dynamics_rows(stream, N, strides, q, qd, qdd, X, tau);
}

#endif

size_t twin_inverse_dynamics_width(void)
{
    return twin_WIDTH;
}

void twin_inverse_dynamics_batch(size_t N, const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    (void)twin_inverse_dynamics_rows(0, N, NULL, q, qd, qdd, X, tau);
}
