/* puma560: inverse_dynamics of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *tau, const int stream)
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
    const lanes X1e2 = -qdd[0] * S2;
    const lanes X2e2 = -qdd[0] * C2;
    const lanes Z1e2 = -gz * S2;
    const lanes Z2e2 = -gz * C2;
    const lanes X12 = qd[1] * W2e2 + X1e2;
    const lanes X22 = X2e2 - qd[1] * W1e2;
    const lanes ZP13r2 = qd[1] * W1e2;
    const lanes ZA1r2 = X22 + ZP13r2;
    const lanes ZP23r2 = qd[1] * W2e2;
    const lanes ZA2r2 = ZP23r2 - X12;
    const lanes ZP11r2 = W1e2 * W1e2;
    const lanes ZP22r2 = W2e2 * W2e2;
    const lanes ZA3r2 = ZP11r2 + ZP22r2;
    const lanes Z1r2 = puma560_geometry_R2 * ZA1r2 + Z1e2;
    const lanes Z2r2 = puma560_geometry_R2 * ZA2r2 + Z2e2;
    const lanes Z3r2 = -puma560_geometry_R2 * ZA3r2;
    const lanes ZP12d3 = W1e2 * W2e2;
    const lanes ZA2d3 = qdd[1] + ZP12d3;
    const lanes ZA3d3 = ZP13r2 - X22;
    const lanes ZP33d3 = qd[1] * qd[1];
    const lanes ZA1d3 = ZP22r2 + ZP33d3;
    const lanes Z2d3 = puma560_geometry_D3 * ZA2d3 + Z2r2;
    const lanes Z3d3 = puma560_geometry_D3 * ZA3d3 + Z3r2;
    const lanes Z1d3 = Z1r2 - puma560_geometry_D3 * ZA1d3;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes X33 = qdd[1] + qdd[2];
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
    const lanes ZA3d4 = ZP13d4 - X33;
    const lanes ZP22d4 = W33 * W33;
    const lanes ZA1d4 = ZP22r3 + ZP22d4;
    const lanes Z2d4 = puma560_geometry_D4 * ZA2d4 + Z3r3;
    const lanes Z3d4 = puma560_geometry_D4 * ZA3d4 - Z2r3;
    const lanes Z1d4 = Z1r3 - puma560_geometry_D4 * ZA1d4;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes X1e4 = C4 * X13 + S4 * X33;
    const lanes X2e4 = C4 * X33 - S4 * X13;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes X34 = qdd[3] - X23;
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
    const lanes X1e5 = C5 * X14 - S5 * X34;
    const lanes X2e5 = -C5 * X34 - S5 * X14;
    const lanes Z1e5 = C5 * Z1r4 - S5 * Z3r4;
    const lanes Z2e5 = -C5 * Z3r4 - S5 * Z1r4;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes X35 = qdd[4] + X24;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes X1e6 = C6 * X15 + S6 * X35;
    const lanes X2e6 = C6 * X35 - S6 * X15;
    const lanes Z1e6 = C6 * Z1e5 + S6 * Z2r4;
    const lanes Z2e6 = C6 * Z2r4 - S6 * Z1e5;
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes X36 = qdd[5] - X25;
    const lanes W36 = qd[5] - W2e5;
    const lanes N1_3 = qdd[0] * X[0];
    const lanes Q22 = ZP11r2 + ZP33d3;
    const lanes A322 = X12 + ZP23r2;
    const lanes A122 = ZP12d3 - qdd[1];
    const lanes B12 = ZP22r2 - ZP33d3;
    const lanes J31_2 = X[1] - X[5];
    const lanes B22 = ZP33d3 - ZP11r2;
    const lanes B32 = ZP11r2 - ZP22r2;
    const lanes F2_1 = X[7] * A122 - X[6] * ZA1d3;
    const lanes F2_2 = X[6] * ZA2d3 - X[7] * Q22;
    const lanes N2_1 = X[1] * X12 + X[3] * ZA2d3 + X[4] * B12 + X[5] * ZP23r2 + X[7] * Z3r2 - X[2] * ZA3d3;
    const lanes N2_2 = X[2] * A322 + X[3] * B22 + ZP13r2 * J31_2 - X[4] * A122 - X[6] * Z3r2;
    const lanes N2_3 = qdd[1] * X[5] + X[2] * B32 + X[4] * ZA1r2 + X[6] * Z2r2 - X[1] * ZP12d3 - X[3] * ZA2r2 - X[7] * Z1r2;
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes A323 = X13 + ZP23r3;
    const lanes A123 = -X33 - ZP13d4;
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes J31_3 = X[8] - X[12];
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes B33 = ZP11r3 - ZP22r3;
    const lanes F3_1 = X[14] * A123 - X[13] * ZA1d4;
    const lanes F3_2 = -X[13] * ZA3d4 - X[14] * Q23;
    const lanes F3_3 = X[13] * ZA2d4 + X[14] * A323;
    const lanes N3_1 = X[8] * X13 + X[11] * B13 + X[12] * ZP23r3 + X[14] * Z3r3 - X[9] * ZA2d4 - X[10] * ZA3d4;
    const lanes N3_2 = X[9] * A323 + X[10] * B23 + ZP13r3 * J31_3 - X[11] * A123 - X[13] * Z3r3;
    const lanes N3_3 = X[8] * ZP13d4 + X[9] * B33 + X[11] * ZA1r3 + X[12] * X33 + X[13] * Z2r3 - X[10] * ZA2r3 - X[14] * Z1r3;
    const lanes P124 = W1e4 * W2e4;
    const lanes P334 = W34 * W34;
    const lanes Q14 = ZP22r4 + P334;
    const lanes A214 = X34 + P124;
    const lanes A314 = ZP13r4 - X24;
    const lanes Q24 = ZP11r4 + P334;
    const lanes A324 = X14 + ZP23r4;
    const lanes A124 = P124 - X34;
    const lanes B14 = ZP22r4 - P334;
    const lanes J31_4 = X[16] - X[20];
    const lanes B24 = P334 - ZP11r4;
    const lanes B34 = ZP11r4 - ZP22r4;
    const lanes F4_1 = X[22] * A124 - X[21] * Q14;
    const lanes F4_2 = X[21] * A214 - X[22] * Q24;
    const lanes F4_3 = X[21] * A314 + X[22] * A324;
    const lanes N4_1 = X[16] * X14 + X[18] * A214 + X[19] * B14 + X[20] * ZP23r4 + X[22] * Z3r4 - X[17] * A314;
    const lanes N4_2 = X[17] * A324 + X[18] * B24 + ZP13r4 * J31_4 - X[19] * A124 - X[21] * Z3r4;
    const lanes N4_3 = X[17] * B34 + X[19] * ZA1r4 + X[20] * X34 + X[21] * Z2r4 - X[16] * P124 - X[18] * ZA2r4 - X[22] * Z1r4;
    const lanes P115 = W1e5 * W1e5;
    const lanes P125 = W1e5 * W2e5;
    const lanes P135 = W1e5 * W35;
    const lanes P225 = W2e5 * W2e5;
    const lanes P235 = W2e5 * W35;
    const lanes P335 = W35 * W35;
    const lanes Q15 = P225 + P335;
    const lanes A215 = X35 + P125;
    const lanes A315 = P135 - X25;
    const lanes Q25 = P115 + P335;
    const lanes A325 = X15 + P235;
    const lanes A125 = P125 - X35;
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
    const lanes N5_3 = X[25] * B35 + X[26] * A3125 + X[27] * A3215 + X[28] * X35 + X[29] * Z2e5 - X[24] * P125 - X[30] * Z1e5;
    const lanes P116 = W1e6 * W1e6;
    const lanes P126 = W1e6 * W2e6;
    const lanes P136 = W1e6 * W36;
    const lanes P226 = W2e6 * W2e6;
    const lanes P236 = W2e6 * W36;
    const lanes P336 = W36 * W36;
    const lanes Q16 = P226 + P336;
    const lanes A216 = X36 + P126;
    const lanes A316 = P136 - X26;
    const lanes Q26 = P116 + P336;
    const lanes A326 = X16 + P236;
    const lanes A126 = P126 - X36;
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
    const lanes N6_3 = X[33] * B36 + X[34] * A3126 + X[35] * A3216 + X[36] * X36 + X[37] * Z2e6 - X[32] * P126 - X[38] * Z1e6;
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
    const lanes Ns1_2_3 = N1_3 - Nb2e2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T1 = qd[0] * X[41] + X[40] * sFS1 + Ns1_2_3;
    lanes_put(&tau[0], T1, stream);
    const lanes T2 = qd[1] * X[43] + X[42] * sFS2 + Ns2_3_3;
    lanes_put(&tau[1], T2, stream);
    const lanes T3 = qd[2] * X[45] + qdd[2] * X[15] + X[44] * sFS3 + Ns3_4_3;
    lanes_put(&tau[2], T3, stream);
    const lanes T4 = qd[3] * X[47] + qdd[3] * X[23] + X[46] * sFS4 + Ns4_5_3;
    lanes_put(&tau[3], T4, stream);
    const lanes T5 = qd[4] * X[49] + qdd[4] * X[31] + X[48] * sFS5 + Ns5_6_3;
    lanes_put(&tau[4], T5, stream);
    const lanes T6 = qd[5] * X[51] + qdd[5] * X[39] + X[50] * sFS6 + N6_3;
    lanes_put(&tau[5], T6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *tau)
{
    return panel(q, qd, qdd, X, tau, 0);
}

int puma560_inverse_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdd[REACH(6u)];
    lanes lanes_qdd[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdd, 6u, lanes_qdd);
    lanes_shared(X, 52u, lanes_X);
    lanes lanes_tau[BLOCKS(6u)];
    double scratch[6u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_read(qdd, 6u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 6u, count, stream, scratch, &tau[k * 6u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdd[REACH(6u)];
    lanes lanes_qdd[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdd, 6u, lanes_qdd);
    lanes_shared(X, 52u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_read(qdd, 6u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 6u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_tau, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_tau);
    }
    return status;
}

int puma560_inverse_dynamics_panels(int stream, size_t N, const size_t *strides,
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

int puma560_inverse_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_inverse_dynamics(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &X[k * stride_X], &tau[k * 6u]);
    }
    return status;
}

int puma560_inverse_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    return puma560_inverse_dynamics_rows(stream, N, strides, q, qd, qdd, X, tau);
}

#endif

size_t puma560_inverse_dynamics_width(void)
{
    return puma560_WIDTH;
}

void puma560_inverse_dynamics_batch(size_t N, const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    (void)puma560_inverse_dynamics_rows(0, N, NULL, q, qd, qdd, X, tau);
}
