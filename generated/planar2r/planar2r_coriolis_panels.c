/* planar2r: coriolis of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *C, const int stream)
{
    (void)stream;
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes W32 = qd[0] + qd[1];
    const lanes l1_1d2 = -qd[0] * planar2r_geometry_L1;
    const lanes l1_1e2 = C2 * l1_1d2;
    const lanes l1_2e2 = -S2 * l1_1d2;
    const lanes h2v1_1 = -X[3] * W32;
    const lanes h2v1_2 = X[2] * W32;
    const lanes N2v1_3 = X[2] * l1_2e2 - X[3] * l1_1e2;
    lanes_put(&C[2], N2v1_3, stream);
    const lanes Fbc12e2 = C2 * h2v1_1 - S2 * h2v1_2;
    const lanes Nbc13d2 = planar2r_geometry_L1 * Fbc12e2 + N2v1_3;
    lanes_put(&C[0], Nbc13d2, stream);
    const lanes Nbc23d2 = planar2r_geometry_L1 * Fbc12e2;
    lanes_put(&C[1], Nbc23d2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *C)
{
    return panel(q, qd, X, C, 0);
}

int planar2r_coriolis_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
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
    lanes lanes_C[BLOCKS(4u)];
    double scratch[4u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_C, 0, sizeof lanes_C);
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
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_C);
        lanes_store(lanes_C, 4u, count, stream, scratch, &C[k * 4u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *C)
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
        apart *lanes_C = (apart *)&C[k * 4u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_C, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_C);
    }
    return status;
}

int planar2r_coriolis_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    if (!(streamed(stream, C))) {
        return panels(0, N, strides, q, qd, X, C);
    }
    const int status = panels(1, N, strides, q, qd, X, C);
    stream_end();
    return status;
}

#else

int planar2r_coriolis_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_coriolis(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &C[k * 4u]);
    }
    return status;
}

int planar2r_coriolis_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    return planar2r_coriolis_rows(stream, N, strides, q, qd, X, C);
}

#endif

size_t planar2r_coriolis_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_coriolis_batch(size_t N, const double *q, const double *qd, const double *X, double *C)
{
    (void)planar2r_coriolis_rows(0, N, NULL, q, qd, X, C);
}
