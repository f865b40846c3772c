/* puma560: energy_regressor of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, apart *out, const int stream)
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
    const lanes G1e3 = C3 * G1e2 + S3 * G2e2;
    const lanes G2e3 = C3 * G2e2 - S3 * G1e2;
    const lanes W33 = qd[1] + qd[2];
    const lanes V1r3 = puma560_geometry_R3 * W2e3 + V1e3;
    const lanes V2r3 = V2e3 - puma560_geometry_R3 * W1e3;
    const lanes V2d4 = V3d3 - puma560_geometry_D4 * W2e3;
    const lanes V3d4 = -puma560_geometry_D4 * W33 - V2r3;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes V1e4 = C4 * V1r3 + S4 * V2d4;
    const lanes V2e4 = C4 * V2d4 - S4 * V1r3;
    const lanes G1e4 = C4 * G1e3;
    const lanes G2e4 = -S4 * G1e3;
    const lanes W34 = qd[3] - W2e3;
    const lanes V1r4 = puma560_geometry_R4 * W2e4 + V1e4;
    const lanes V2r4 = V2e4 - puma560_geometry_R4 * W1e4;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes V1e5 = C5 * V1r4 - S5 * V3d4;
    const lanes V2e5 = -C5 * V3d4 - S5 * V1r4;
    const lanes G1e5 = C5 * G1e4 + S5 * G2e3;
    const lanes G2e5 = C5 * G2e3 - S5 * G1e4;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes V1e6 = C6 * V1e5 + S6 * V2r4;
    const lanes V2e6 = C6 * V2r4 - S6 * V1e5;
    const lanes G1e6 = C6 * G1e5 + S6 * G2e4;
    const lanes G2e6 = C6 * G2e4 - S6 * G1e5;
    const lanes W36 = qd[5] - W2e5;
    const lanes Hqd1 = 0.5 * qd[0];
    const lanes DZZ1 = qd[0] * Hqd1;
    lanes_put(&out[0], DZZ1, stream);
    const lanes HW1e2 = 0.5 * W1e2;
    const lanes DXX2 = W1e2 * HW1e2;
    lanes_put(&out[1], DXX2, stream);
    const lanes DXY2 = W1e2 * W2e2;
    lanes_put(&out[2], DXY2, stream);
    const lanes DXZ2 = qd[1] * W1e2;
    lanes_put(&out[3], DXZ2, stream);
    const lanes DYZ2 = qd[1] * W2e2;
    lanes_put(&out[4], DYZ2, stream);
    const lanes Hqd2 = 0.5 * qd[1];
    const lanes DZZ2 = qd[1] * Hqd2;
    lanes_put(&out[5], DZZ2, stream);
    const lanes DMX2 = qd[1] * V2r2 - G1e2;
    lanes_put(&out[6], DMX2, stream);
    const lanes DMY2 = -qd[1] * V1r2 - G2e2;
    lanes_put(&out[7], DMY2, stream);
    const lanes HW1e3 = 0.5 * W1e3;
    const lanes DXX3 = W1e3 * HW1e3;
    lanes_put(&out[8], DXX3, stream);
    const lanes DXY3 = W1e3 * W2e3;
    lanes_put(&out[9], DXY3, stream);
    const lanes DXZ3 = W1e3 * W33;
    lanes_put(&out[10], DXZ3, stream);
    const lanes DYZ3 = W2e3 * W33;
    lanes_put(&out[11], DYZ3, stream);
    const lanes HW33 = 0.5 * W33;
    const lanes DZZ3 = W33 * HW33;
    lanes_put(&out[12], DZZ3, stream);
    const lanes DMX3 = W33 * V2r3 - V3d3 * W2e3 - G1e3;
    lanes_put(&out[13], DMX3, stream);
    const lanes DMY3 = V3d3 * W1e3 - G2e3 - W33 * V1r3;
    lanes_put(&out[14], DMY3, stream);
    const lanes Hqd3 = 0.5 * qd[2];
    const lanes DIA3 = qd[2] * Hqd3;
    lanes_put(&out[15], DIA3, stream);
    const lanes HW1e4 = 0.5 * W1e4;
    const lanes DXX4 = W1e4 * HW1e4;
    lanes_put(&out[16], DXX4, stream);
    const lanes DXY4 = W1e4 * W2e4;
    lanes_put(&out[17], DXY4, stream);
    const lanes DXZ4 = W1e4 * W34;
    lanes_put(&out[18], DXZ4, stream);
    const lanes DYZ4 = W2e4 * W34;
    lanes_put(&out[19], DYZ4, stream);
    const lanes HW34 = 0.5 * W34;
    const lanes DZZ4 = W34 * HW34;
    lanes_put(&out[20], DZZ4, stream);
    const lanes DMX4 = W34 * V2r4 - V3d4 * W2e4 - G1e4;
    lanes_put(&out[21], DMX4, stream);
    const lanes DMY4 = V3d4 * W1e4 - G2e4 - W34 * V1r4;
    lanes_put(&out[22], DMY4, stream);
    const lanes Hqd4 = 0.5 * qd[3];
    const lanes DIA4 = qd[3] * Hqd4;
    lanes_put(&out[23], DIA4, stream);
    const lanes HW1e5 = 0.5 * W1e5;
    const lanes DXX5 = W1e5 * HW1e5;
    lanes_put(&out[24], DXX5, stream);
    const lanes DXY5 = W1e5 * W2e5;
    lanes_put(&out[25], DXY5, stream);
    const lanes DXZ5 = W1e5 * W35;
    lanes_put(&out[26], DXZ5, stream);
    const lanes DYZ5 = W2e5 * W35;
    lanes_put(&out[27], DYZ5, stream);
    const lanes HW35 = 0.5 * W35;
    const lanes DZZ5 = W35 * HW35;
    lanes_put(&out[28], DZZ5, stream);
    const lanes DMX5 = V2e5 * W35 - V2r4 * W2e5 - G1e5;
    lanes_put(&out[29], DMX5, stream);
    const lanes DMY5 = V2r4 * W1e5 - V1e5 * W35 - G2e5;
    lanes_put(&out[30], DMY5, stream);
    const lanes Hqd5 = 0.5 * qd[4];
    const lanes DIA5 = qd[4] * Hqd5;
    lanes_put(&out[31], DIA5, stream);
    const lanes HW1e6 = 0.5 * W1e6;
    const lanes DXX6 = W1e6 * HW1e6;
    lanes_put(&out[32], DXX6, stream);
    const lanes DXY6 = W1e6 * W2e6;
    lanes_put(&out[33], DXY6, stream);
    const lanes DXZ6 = W1e6 * W36;
    lanes_put(&out[34], DXZ6, stream);
    const lanes DYZ6 = W2e6 * W36;
    lanes_put(&out[35], DYZ6, stream);
    const lanes HW36 = 0.5 * W36;
    const lanes DZZ6 = W36 * HW36;
    lanes_put(&out[36], DZZ6, stream);
    const lanes DMX6 = V2e5 * W2e6 + V2e6 * W36 - G1e6;
    lanes_put(&out[37], DMX6, stream);
    const lanes DMY6 = -V2e5 * W1e6 - V1e6 * W36 - G2e6;
    lanes_put(&out[38], DMY6, stream);
    const lanes Hqd6 = 0.5 * qd[5];
    const lanes DIA6 = qd[5] * Hqd6;
    lanes_put(&out[39], DIA6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, apart *out)
{
    return panel(q, qd, out, 0);
}

int puma560_energy_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes lanes_out[BLOCKS(40u)];
    double scratch[40u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        status |= plain(lanes_q, lanes_qd, (apart *)lanes_out);
        lanes_store(lanes_out, 40u, count, stream, scratch, &out[k * 40u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        apart *lanes_out = (apart *)&out[k * 40u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_out);
    }
    return status;
}

int puma560_energy_regressor_panels(int stream, size_t N, const size_t *strides,
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

int puma560_energy_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_energy_regressor(&q[k * stride_q], &qd[k * stride_qd], &out[k * 40u]);
    }
    return status;
}

int puma560_energy_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    return puma560_energy_regressor_rows(stream, N, strides, q, qd, out);
}

#endif

size_t puma560_energy_regressor_width(void)
{
    return puma560_WIDTH;
}

void puma560_energy_regressor_batch(size_t N, const double *q, const double *qd, double *out)
{
    (void)puma560_energy_regressor_rows(0, N, NULL, q, qd, out);
}
