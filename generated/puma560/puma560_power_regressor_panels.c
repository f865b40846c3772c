/* puma560: power_regressor of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, apart *out, const int stream)
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
    const lanes G1e2 = gz * S2;
    const lanes G2e2 = gz * C2;
    const lanes V1r2 = puma560_geometry_R2 * W2e2;
    const lanes V2r2 = -puma560_geometry_R2 * W1e2;
    const lanes V2d3 = qd[1] * puma560_geometry_D3 + V2r2;
    const lanes V3d3 = -puma560_geometry_D3 * W2e2;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes V1e3 = C3 * V1r2 + S3 * V2d3;
    const lanes V2e3 = C3 * V2d3 - S3 * V1r2;
    const lanes W33 = qd[1] + qd[2];
    const lanes V1r3 = puma560_geometry_R3 * W2e3 + V1e3;
    const lanes V2r3 = V2e3 - puma560_geometry_R3 * W1e3;
    const lanes V2d4 = V3d3 - puma560_geometry_D4 * W2e3;
    const lanes V3d4 = -puma560_geometry_D4 * W33 - V2r3;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes V1e4 = C4 * V1r3 + S4 * V2d4;
    const lanes V2e4 = C4 * V2d4 - S4 * V1r3;
    const lanes W34 = qd[3] - W2e3;
    const lanes V1r4 = puma560_geometry_R4 * W2e4 + V1e4;
    const lanes V2r4 = V2e4 - puma560_geometry_R4 * W1e4;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes V1e5 = C5 * V1r4 - S5 * V3d4;
    const lanes V2e5 = -C5 * V3d4 - S5 * V1r4;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes V1e6 = C6 * V1e5 + S6 * V2r4;
    const lanes V2e6 = C6 * V2r4 - S6 * V1e5;
    const lanes W36 = qd[5] - W2e5;
    const lanes X1e2 = -qdd[0] * S2;
    const lanes X2e2 = -qdd[0] * C2;
    const lanes X12 = qd[1] * W2e2 + X1e2;
    const lanes X22 = X2e2 - qd[1] * W1e2;
    const lanes ZP13r2 = qd[1] * W1e2;
    const lanes ZA1r2 = X22 + ZP13r2;
    const lanes ZP23r2 = qd[1] * W2e2;
    const lanes ZA2r2 = ZP23r2 - X12;
    const lanes ZP11r2 = W1e2 * W1e2;
    const lanes ZP22r2 = W2e2 * W2e2;
    const lanes ZA3r2 = ZP11r2 + ZP22r2;
    const lanes Z1r2 = puma560_geometry_R2 * ZA1r2 - G1e2;
    const lanes Z2r2 = puma560_geometry_R2 * ZA2r2 - G2e2;
    const lanes Z3r2 = -puma560_geometry_R2 * ZA3r2;
    const lanes ZP12d3 = W1e2 * W2e2;
    const lanes ZA2d3 = qdd[1] + ZP12d3;
    const lanes ZA3d3 = ZP13r2 - X22;
    const lanes ZP33d3 = qd[1] * qd[1];
    lanes_put(&out[43], ZP33d3, stream);
    const lanes ZA1d3 = ZP22r2 + ZP33d3;
    const lanes Z2d3 = puma560_geometry_D3 * ZA2d3 + Z2r2;
    const lanes Z3d3 = puma560_geometry_D3 * ZA3d3 + Z3r2;
    const lanes Z1d3 = Z1r2 - puma560_geometry_D3 * ZA1d3;
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes X33 = qdd[1] + qdd[2];
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
    const lanes X1e4 = C4 * X13 + S4 * X33;
    const lanes X2e4 = C4 * X33 - S4 * X13;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes X34 = qdd[3] - X23;
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
    const lanes X1e5 = C5 * X14 - S5 * X34;
    const lanes X2e5 = -C5 * X34 - S5 * X14;
    const lanes Z1e5 = C5 * Z1r4 - S5 * Z3r4;
    const lanes Z2e5 = -C5 * Z3r4 - S5 * Z1r4;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes X35 = qdd[4] + X24;
    const lanes X1e6 = C6 * X15 + S6 * X35;
    const lanes X2e6 = C6 * X35 - S6 * X15;
    const lanes Z1e6 = C6 * Z1e5 + S6 * Z2r4;
    const lanes Z2e6 = C6 * Z2r4 - S6 * Z1e5;
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes X36 = qdd[5] - X25;
    const lanes P331 = qd[0] * qd[0];
    lanes_put(&out[41], P331, stream);
    const lanes RZZ1 = qd[0] * qdd[0];
    lanes_put(&out[0], RZZ1, stream);
    const lanes RXX2 = W1e2 * X12 + W2e2 * ZP13r2 - qd[1] * ZP12d3;
    lanes_put(&out[1], RXX2, stream);
    const lanes A2132 = X12 + ZP23r2;
    const lanes B32 = ZP11r2 - ZP22r2;
    const lanes RXY2 = qd[1] * B32 + W2e2 * A2132 - W1e2 * ZA3d3;
    lanes_put(&out[2], RXY2, stream);
    const lanes B22 = ZP33d3 - ZP11r2;
    const lanes RXZ2 = W1e2 * ZA2d3 + W2e2 * B22 - qd[1] * ZA2r2;
    lanes_put(&out[3], RXZ2, stream);
    const lanes A2312 = qdd[1] - ZP12d3;
    const lanes B12 = ZP22r2 - ZP33d3;
    const lanes RYZ2 = qd[1] * ZA1r2 + W1e2 * B12 + W2e2 * A2312;
    lanes_put(&out[4], RYZ2, stream);
    const lanes RZZ2 = qd[1] * qdd[1] + W1e2 * ZP23r2 - W2e2 * ZP13r2;
    lanes_put(&out[5], RZZ2, stream);
    const lanes RMX2 = qd[1] * Z2r2 + V2r2 * ZA2d3 - W2e2 * Z3r2 - V1r2 * ZA1d3;
    lanes_put(&out[6], RMX2, stream);
    const lanes Q22 = ZP11r2 + ZP33d3;
    const lanes RMY2 = W1e2 * Z3r2 - qd[1] * Z1r2 - V1r2 * A2312 - V2r2 * Q22;
    lanes_put(&out[7], RMY2, stream);
    const lanes RXX3 = W1e3 * X13 + W2e3 * ZP13r3 + W33 * ZP13d4;
    lanes_put(&out[8], RXX3, stream);
    const lanes A2133 = X13 + ZP23r3;
    const lanes B33 = ZP11r3 - ZP22r3;
    const lanes RXY3 = W2e3 * A2133 + W33 * B33 - W1e3 * ZA2d4;
    lanes_put(&out[9], RXY3, stream);
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes RXZ3 = W2e3 * B23 - W1e3 * ZA3d4 - W33 * ZA2r3;
    lanes_put(&out[10], RXZ3, stream);
    const lanes A2313 = X33 + ZP13d4;
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes RYZ3 = W1e3 * B13 + W2e3 * A2313 + W33 * ZA1r3;
    lanes_put(&out[11], RYZ3, stream);
    const lanes RZZ3 = W1e3 * ZP23r3 + W33 * X33 - W2e3 * ZP13r3;
    lanes_put(&out[12], RZZ3, stream);
    const lanes RMX3 = V3d3 * ZA2d4 + W33 * Z2r3 - W2e3 * Z3r3 - V1r3 * ZA1d4 - V2r3 * ZA3d4;
    lanes_put(&out[13], RMX3, stream);
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes RMY3 = V3d3 * A2133 + W1e3 * Z3r3 - W33 * Z1r3 - V1r3 * A2313 - V2r3 * Q23;
    lanes_put(&out[14], RMY3, stream);
    const lanes RIA3 = qd[2] * qdd[2];
    lanes_put(&out[15], RIA3, stream);
    const lanes P124 = W1e4 * W2e4;
    const lanes P334 = W34 * W34;
    const lanes RXX4 = W1e4 * X14 + W2e4 * ZP13r4 - W34 * P124;
    lanes_put(&out[16], RXX4, stream);
    const lanes A1234 = X24 - ZP13r4;
    const lanes A2134 = X14 + ZP23r4;
    const lanes B34 = ZP11r4 - ZP22r4;
    const lanes RXY4 = W1e4 * A1234 + W2e4 * A2134 + W34 * B34;
    lanes_put(&out[17], RXY4, stream);
    const lanes A1324 = X34 + P124;
    const lanes B24 = P334 - ZP11r4;
    const lanes RXZ4 = W1e4 * A1324 + W2e4 * B24 - W34 * ZA2r4;
    lanes_put(&out[18], RXZ4, stream);
    const lanes A2314 = X34 - P124;
    const lanes B14 = ZP22r4 - P334;
    const lanes RYZ4 = W1e4 * B14 + W2e4 * A2314 + W34 * ZA1r4;
    lanes_put(&out[19], RYZ4, stream);
    const lanes RZZ4 = W1e4 * ZP23r4 + W34 * X34 - W2e4 * ZP13r4;
    lanes_put(&out[20], RZZ4, stream);
    const lanes Q14 = ZP22r4 + P334;
    const lanes RMX4 = W34 * Z2r4 + V2r4 * A1324 - V3d4 * A1234 - W2e4 * Z3r4 - V1r4 * Q14;
    lanes_put(&out[21], RMX4, stream);
    const lanes Q24 = ZP11r4 + P334;
    const lanes RMY4 = V3d4 * A2134 + W1e4 * Z3r4 - W34 * Z1r4 - V1r4 * A2314 - V2r4 * Q24;
    lanes_put(&out[22], RMY4, stream);
    const lanes RIA4 = qd[3] * qdd[3];
    lanes_put(&out[23], RIA4, stream);
    const lanes P115 = W1e5 * W1e5;
    const lanes P125 = W1e5 * W2e5;
    const lanes P135 = W1e5 * W35;
    const lanes P225 = W2e5 * W2e5;
    const lanes P235 = W2e5 * W35;
    const lanes P335 = W35 * W35;
    const lanes RXX5 = W1e5 * X15 + W2e5 * P135 - W35 * P125;
    lanes_put(&out[24], RXX5, stream);
    const lanes A1235 = X25 - P135;
    const lanes A2135 = X15 + P235;
    const lanes B35 = P115 - P225;
    const lanes RXY5 = W1e5 * A1235 + W2e5 * A2135 + W35 * B35;
    lanes_put(&out[25], RXY5, stream);
    const lanes A1325 = X35 + P125;
    const lanes A3125 = X15 - P235;
    const lanes B25 = P335 - P115;
    const lanes RXZ5 = W1e5 * A1325 + W2e5 * B25 + W35 * A3125;
    lanes_put(&out[26], RXZ5, stream);
    const lanes A2315 = X35 - P125;
    const lanes A3215 = X25 + P135;
    const lanes B15 = P225 - P335;
    const lanes RYZ5 = W1e5 * B15 + W2e5 * A2315 + W35 * A3215;
    lanes_put(&out[27], RYZ5, stream);
    const lanes RZZ5 = W1e5 * P235 + W35 * X35 - W2e5 * P135;
    lanes_put(&out[28], RZZ5, stream);
    const lanes Q15 = P225 + P335;
    const lanes RMX5 = V2e5 * A1325 + W35 * Z2e5 - V2r4 * A1235 - W2e5 * Z2r4 - V1e5 * Q15;
    lanes_put(&out[29], RMX5, stream);
    const lanes Q25 = P115 + P335;
    const lanes RMY5 = V2r4 * A2135 + W1e5 * Z2r4 - V1e5 * A2315 - V2e5 * Q25 - W35 * Z1e5;
    lanes_put(&out[30], RMY5, stream);
    const lanes RIA5 = qd[4] * qdd[4];
    lanes_put(&out[31], RIA5, stream);
    const lanes P116 = W1e6 * W1e6;
    const lanes P126 = W1e6 * W2e6;
    const lanes P136 = W1e6 * W36;
    const lanes P226 = W2e6 * W2e6;
    const lanes P236 = W2e6 * W36;
    const lanes P336 = W36 * W36;
    const lanes RXX6 = W1e6 * X16 + W2e6 * P136 - W36 * P126;
    lanes_put(&out[32], RXX6, stream);
    const lanes A1236 = X26 - P136;
    const lanes A2136 = X16 + P236;
    const lanes B36 = P116 - P226;
    const lanes RXY6 = W1e6 * A1236 + W2e6 * A2136 + W36 * B36;
    lanes_put(&out[33], RXY6, stream);
    const lanes A1326 = X36 + P126;
    const lanes A3126 = X16 - P236;
    const lanes B26 = P336 - P116;
    const lanes RXZ6 = W1e6 * A1326 + W2e6 * B26 + W36 * A3126;
    lanes_put(&out[34], RXZ6, stream);
    const lanes A2316 = X36 - P126;
    const lanes A3216 = X26 + P136;
    const lanes B16 = P226 - P336;
    const lanes RYZ6 = W1e6 * B16 + W2e6 * A2316 + W36 * A3216;
    lanes_put(&out[35], RYZ6, stream);
    const lanes RZZ6 = W1e6 * P236 + W36 * X36 - W2e6 * P136;
    lanes_put(&out[36], RZZ6, stream);
    const lanes Q16 = P226 + P336;
    const lanes RMX6 = V2e5 * A1236 + W2e6 * Z2e5 + V2e6 * A1326 + W36 * Z2e6 - V1e6 * Q16;
    lanes_put(&out[37], RMX6, stream);
    const lanes Q26 = P116 + P336;
    const lanes RMY6 = -V2e5 * A2136 - W1e6 * Z2e5 - V1e6 * A2316 - V2e6 * Q26 - W36 * Z1e6;
    lanes_put(&out[38], RMY6, stream);
    const lanes RIA6 = qd[5] * qdd[5];
    lanes_put(&out[39], RIA6, stream);
    const lanes DFS1 = lanes_abs(qd[0]);
    lanes_put(&out[40], DFS1, stream);
    const lanes DFS2 = lanes_abs(qd[1]);
    lanes_put(&out[42], DFS2, stream);
    const lanes DFS3 = lanes_abs(qd[2]);
    lanes_put(&out[44], DFS3, stream);
    const lanes DFV3 = qd[2] * qd[2];
    lanes_put(&out[45], DFV3, stream);
    const lanes DFS4 = lanes_abs(qd[3]);
    lanes_put(&out[46], DFS4, stream);
    const lanes DFV4 = qd[3] * qd[3];
    lanes_put(&out[47], DFV4, stream);
    const lanes DFS5 = lanes_abs(qd[4]);
    lanes_put(&out[48], DFS5, stream);
    const lanes DFV5 = qd[4] * qd[4];
    lanes_put(&out[49], DFV5, stream);
    const lanes DFS6 = lanes_abs(qd[5]);
    lanes_put(&out[50], DFS6, stream);
    const lanes DFV6 = qd[5] * qd[5];
    lanes_put(&out[51], DFV6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, apart *out)
{
    return panel(q, qd, qdd, out, 0);
}

int puma560_power_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdd[REACH(6u)];
    lanes lanes_qdd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdd, 6u, lanes_qdd);
    lanes lanes_out[BLOCKS(52u)];
    double scratch[52u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
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
        status |= plain(lanes_q, lanes_qd, lanes_qdd, (apart *)lanes_out);
        lanes_store(lanes_out, 52u, count, stream, scratch, &out[k * 52u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdd[REACH(6u)];
    lanes lanes_qdd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdd, 6u, lanes_qdd);
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
        apart *lanes_out = (apart *)&out[k * 52u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_out);
    }
    return status;
}

int puma560_power_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    if (!(streamed(stream, out))) {
        return panels(0, N, strides, q, qd, qdd, out);
    }
    const int status = panels(1, N, strides, q, qd, qdd, out);
    stream_end();
    return status;
}

#else

int puma560_power_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_power_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &out[k * 52u]);
    }
    return status;
}

int puma560_power_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    return puma560_power_regressor_rows(stream, N, strides, q, qd, qdd, out);
}

#endif

size_t puma560_power_regressor_width(void)
{
    return puma560_WIDTH;
}

void puma560_power_regressor_batch(size_t N, const double *q, const double *qd, const double *qdd, double *out)
{
    (void)puma560_power_regressor_rows(0, N, NULL, q, qd, qdd, out);
}
