/* planar2r: bias_torque of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *h, const int stream)
{
    (void)stream;
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes ZP33d2 = qd[0] * qd[0];
    const lanes Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const lanes Z1e2 = C2 * Z1d2;
    const lanes Z2e2 = -S2 * Z1d2;
    const lanes W32 = qd[0] + qd[1];
    const lanes P332 = W32 * W32;
    const lanes F2_1 = -X[2] * P332;
    const lanes F2_2 = -X[3] * P332;
    const lanes N2_3 = X[2] * Z2e2 - X[3] * Z1e2;
    lanes_put(&h[1], N2_3, stream);
    const lanes Fb2e2 = C2 * F2_2 + S2 * F2_1;
    const lanes Nb3d2 = planar2r_geometry_L1 * Fb2e2 + N2_3;
    lanes_put(&h[0], Nb3d2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *h)
{
    return panel(q, qd, X, h, 0);
}

int planar2r_bias_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(X, 4u, lanes_X);
    lanes lanes_h[BLOCKS(2u)];
    double scratch[2u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_h, 0, sizeof lanes_h);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_h);
        lanes_store(lanes_h, 2u, count, stream, scratch, &h[k * 2u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *h)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(X, 4u, lanes_X);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_h = (apart *)&h[k * 2u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_h, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_h);
    }
    return status;
}

int planar2r_bias_torque_panels(int stream, size_t N, const size_t *strides,
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

int planar2r_bias_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_bias_torque(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &h[k * 2u]);
    }
    return status;
}

int planar2r_bias_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h)
{
    return planar2r_bias_torque_rows(stream, N, strides, q, qd, X, h);
}

#endif

size_t planar2r_bias_torque_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_bias_torque_batch(size_t N, const double *q, const double *qd, const double *X, double *h)
{
    (void)planar2r_bias_torque_rows(0, N, NULL, q, qd, X, h);
}
