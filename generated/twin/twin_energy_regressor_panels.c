/* twin: energy_regressor of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, apart *out, const int stream)
{
    (void)stream;
    const double b2 = 0.6;
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
    const double Ub2 = b2 * gz;
    const lanes V3d2 = -qd[0] * d2;
    const lanes W1e2 = qd[0] * S2;
    const lanes G1e2 = -gz * S2;
    const lanes DXZ2 = qd[1] * W1e2;
    lanes_put(&out[3], DXZ2, stream);
    const lanes W2e2 = qd[0] * C2;
    const lanes G2e2 = -gz * C2;
    const lanes DXY2 = W1e2 * W2e2;
    lanes_put(&out[2], DXY2, stream);
    const lanes DYZ2 = qd[1] * W2e2;
    lanes_put(&out[4], DYZ2, stream);
    const lanes DMX2 = -V3d2 * W2e2 - G1e2;
    lanes_put(&out[6], DMX2, stream);
    const lanes DMY2 = V3d2 * W1e2 - G2e2;
    lanes_put(&out[7], DMY2, stream);
    const lanes V2d3 = qd[1] * d3;
    const lanes V3d3 = V3d2 - d3 * W2e2;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes DXY3 = W1e3 * W2e3;
    lanes_put(&out[9], DXY3, stream);
    const lanes V1e3 = S3 * V2d3;
    const lanes V2e3 = C3 * V2d3;
    const lanes G1e3 = C3 * G1e2 + S3 * G2e2;
    const lanes G2e3 = C3 * G2e2 - S3 * G1e2;
    const lanes W33 = qd[1] + qd[2];
    const lanes DXZ3 = W1e3 * W33;
    lanes_put(&out[10], DXZ3, stream);
    const lanes DYZ3 = W2e3 * W33;
    lanes_put(&out[11], DYZ3, stream);
    const lanes DMX3 = V2e3 * W33 - V3d3 * W2e3 - G1e3;
    lanes_put(&out[13], DMX3, stream);
    const lanes W34 = qd[3] - W2e3;
    const lanes DMY3 = V3d3 * W1e3 - V1e3 * W33 - G2e3;
    lanes_put(&out[14], DMY3, stream);
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes DXZ4 = W1e4 * W34;
    lanes_put(&out[18], DXZ4, stream);
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes DXY4 = W1e4 * W2e4;
    lanes_put(&out[17], DXY4, stream);
    const lanes DYZ4 = W2e4 * W34;
    lanes_put(&out[19], DYZ4, stream);
    const lanes V1e4 = C4 * V1e3 + S4 * V3d3;
    const lanes V2e4 = C4 * V3d3 - S4 * V1e3;
    const lanes G1e4 = C4 * G1e3;
    const lanes G2e4 = -S4 * G1e3;
    const lanes V1r4 = r4 * W2e4 + V1e4;
    const lanes V2r4 = V2e4 - r4 * W1e4;
    const lanes DMX4 = V2e3 * W2e4 + W34 * V2r4 - G1e4;
    lanes_put(&out[21], DMX4, stream);
    const lanes DMY4 = -V2e3 * W1e4 - G2e4 - W34 * V1r4;
    lanes_put(&out[22], DMY4, stream);
    const lanes W1e5 = qd[0] * S5;
    const lanes G1e5 = -gz * S5;
    const lanes DXZ5 = qd[4] * W1e5;
    lanes_put(&out[26], DXZ5, stream);
    const lanes W2e5 = qd[0] * C5;
    const lanes G2e5 = -gz * C5;
    const lanes Ur6 = R6 * G2e5 + Ub2;
    const lanes DXY5 = W1e5 * W2e5;
    lanes_put(&out[25], DXY5, stream);
    const lanes DYZ5 = qd[4] * W2e5;
    lanes_put(&out[27], DYZ5, stream);
    const lanes DMX5 = -V3d2 * W2e5 - G1e5;
    lanes_put(&out[29], DMX5, stream);
    const lanes DMY5 = V3d2 * W1e5 - G2e5;
    lanes_put(&out[30], DMY5, stream);
    const lanes V2r6 = V3d2 - R6 * W1e5;
    const lanes V1r6 = qd[4] * R6;
    const lanes DMX6 = -qd[4] * qd[5] - W2e5 * V2r6 - G1e5;
    lanes_put(&out[31], DMX6, stream);
    const lanes DMY6 = qd[5] * W1e5 + W2e5 * V1r6;
    lanes_put(&out[32], DMY6, stream);
    const lanes DMZ6 = qd[4] * V1r6 + G2e5 - W1e5 * V2r6;
    lanes_put(&out[33], DMZ6, stream);
    const lanes W1e7 = C7 * W1e5 + S7 * W2e5;
    const lanes W2e7 = C7 * W2e5 - S7 * W1e5;
    const lanes DXY7 = W1e7 * W2e7;
    lanes_put(&out[37], DXY7, stream);
    const lanes V1e7 = C7 * V1r6 - qd[5] * S7;
    const lanes V2e7 = -qd[5] * C7 - S7 * V1r6;
    const lanes EDM6 = qd[5] * qd[5] + V1r6 * V1r6 + V2r6 * V2r6;
    const lanes DM6 = 0.5 * EDM6 + Ur6;
    lanes_put(&out[34], DM6, stream);
    const lanes G1e7 = C7 * G1e5 + S7 * G2e5;
    const lanes G2e7 = C7 * G2e5 - S7 * G1e5;
    const lanes W37 = qd[4] + qd[6];
    const lanes DXZ7 = W1e7 * W37;
    lanes_put(&out[38], DXZ7, stream);
    const lanes DYZ7 = W2e7 * W37;
    lanes_put(&out[39], DYZ7, stream);
    const lanes DMX7 = V2e7 * W37 - V2r6 * W2e7 - G1e7;
    lanes_put(&out[41], DMX7, stream);
    const lanes DMY7 = V2r6 * W1e7 - V1e7 * W37 - G2e7;
    lanes_put(&out[42], DMY7, stream);
    const lanes Hqd1 = 0.5 * qd[0];
    const lanes DZZ1 = qd[0] * Hqd1;
    lanes_put(&out[0], DZZ1, stream);
    const lanes HW1e2 = 0.5 * W1e2;
    const lanes DXX2 = W1e2 * HW1e2;
    lanes_put(&out[1], DXX2, stream);
    const lanes Hqd2 = 0.5 * qd[1];
    const lanes DZZ2 = qd[1] * Hqd2;
    lanes_put(&out[5], DZZ2, stream);
    const lanes HW1e3 = 0.5 * W1e3;
    const lanes DXX3 = W1e3 * HW1e3;
    lanes_put(&out[8], DXX3, stream);
    const lanes HW33 = 0.5 * W33;
    const lanes DZZ3 = W33 * HW33;
    lanes_put(&out[12], DZZ3, stream);
    const lanes Hqd3 = 0.5 * qd[2];
    const lanes DIA3 = qd[2] * Hqd3;
    lanes_put(&out[15], DIA3, stream);
    const lanes HW1e4 = 0.5 * W1e4;
    const lanes DXX4 = W1e4 * HW1e4;
    lanes_put(&out[16], DXX4, stream);
    const lanes HW34 = 0.5 * W34;
    const lanes DZZ4 = W34 * HW34;
    lanes_put(&out[20], DZZ4, stream);
    const lanes Hqd4 = 0.5 * qd[3];
    const lanes DIA4 = qd[3] * Hqd4;
    lanes_put(&out[23], DIA4, stream);
    const lanes HW1e5 = 0.5 * W1e5;
    const lanes DXX5 = W1e5 * HW1e5;
    lanes_put(&out[24], DXX5, stream);
    const lanes Hqd5 = 0.5 * qd[4];
    const lanes DZZ5 = qd[4] * Hqd5;
    lanes_put(&out[28], DZZ5, stream);
    const lanes Hqd6 = 0.5 * qd[5];
    const lanes DIA6 = qd[5] * Hqd6;
    lanes_put(&out[35], DIA6, stream);
    const lanes HW1e7 = 0.5 * W1e7;
    const lanes DXX7 = W1e7 * HW1e7;
    lanes_put(&out[36], DXX7, stream);
    const lanes HW37 = 0.5 * W37;
    const lanes DZZ7 = W37 * HW37;
    lanes_put(&out[40], DZZ7, stream);
    const lanes Hqd7 = 0.5 * qd[6];
    const lanes DIA7 = qd[6] * Hqd7;
    lanes_put(&out[43], DIA7, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, apart *out)
{
    return panel(q, qd, out, 0);
}

int twin_energy_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes lanes_out[BLOCKS(44u)];
    double scratch[44u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        status |= plain(lanes_q, lanes_qd, (apart *)lanes_out);
        lanes_store(lanes_out, 44u, count, stream, scratch, &out[k * 44u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        apart *lanes_out = (apart *)&out[k * 44u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_out);
    }
    return status;
}

int twin_energy_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    if (!(streamed(stream, out))) {
        return panels(0, N, strides, q, qd, out);
    }
    const int status = panels(1, N, strides, q, qd, out);
    stream_end();
    return status;
}

#else

int twin_energy_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_energy_regressor(&q[k * stride_q], &qd[k * stride_qd], &out[k * 44u]);
    }
    return status;
}

int twin_energy_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    return twin_energy_regressor_rows(stream, N, strides, q, qd, out);
}

#endif

size_t twin_energy_regressor_width(void)
{
    return twin_WIDTH;
}

void twin_energy_regressor_batch(size_t N, const double *q, const double *qd, double *out)
{
    (void)twin_energy_regressor_rows(0, N, NULL, q, qd, out);
}
