/* planar2r: torque_regressor of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, apart *out, const int stream)
{
    (void)stream;
    lanes_put(&out[0], qdd[0], stream);
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes L1_1e2 = planar2r_geometry_L1 * S2;
    const lanes L1_2e2 = planar2r_geometry_L1 * C2;
    const lanes W32 = qd[0] + qd[1];
    const lanes ZP33d2 = qd[0] * qd[0];
    const lanes Z2d2 = qdd[0] * planar2r_geometry_L1;
    const lanes Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const lanes Z1e2 = C2 * Z1d2 + S2 * Z2d2;
    lanes_put(&out[7], -Z1e2, stream);
    const lanes Z2e2 = C2 * Z2d2 - S2 * Z1d2;
    lanes_put(&out[6], Z2e2, stream);
    const lanes X32 = qdd[0] + qdd[1];
    lanes_put(&out[1], X32, stream);
    lanes_put(&out[5], X32, stream);
    const lanes P332 = W32 * W32;
    const lanes TMX2_1 = L1_2e2 * X32 + Z2e2 - L1_1e2 * P332;
    lanes_put(&out[2], TMX2_1, stream);
    const lanes TMY2_1 = -L1_1e2 * X32 - L1_2e2 * P332 - Z1e2;
    lanes_put(&out[3], TMY2_1, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, apart *out)
{
    return panel(q, qd, qdd, out, 0);
}

int planar2r_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_qdd[REACH(2u)];
    lanes lanes_qdd[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(qdd, 2u, lanes_qdd);
    lanes lanes_out[BLOCKS(8u)];
    double scratch[8u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_read(qdd, 2u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdd, (apart *)lanes_out);
        lanes_store(lanes_out, 8u, count, stream, scratch, &out[k * 8u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_qdd[REACH(2u)];
    lanes lanes_qdd[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(qdd, 2u, lanes_qdd);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_read(qdd, 2u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        apart *lanes_out = (apart *)&out[k * 8u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_out);
    }
    return status;
}

int planar2r_torque_regressor_panels(int stream, size_t N, const size_t *strides,
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

int planar2r_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 2u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_torque_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &out[k * 8u]);
    }
    return status;
}

int planar2r_torque_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    return planar2r_torque_regressor_rows(stream, N, strides, q, qd, qdd, out);
}

#endif

size_t planar2r_torque_regressor_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_torque_regressor_batch(size_t N, const double *q, const double *qd, const double *qdd, double *out)
{
    (void)planar2r_torque_regressor_rows(0, N, NULL, q, qd, qdd, out);
}
