/* planar2r: generalized_momentum of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *p_out, apart *rate_out, const int stream)
{
    (void)stream;
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes V2d2 = qd[0] * planar2r_geometry_L1;
    const lanes V1e2 = S2 * V2d2;
    const lanes V2e2 = C2 * V2d2;
    const lanes W32 = qd[0] + qd[1];
    const lanes k1_3 = qd[0] * X[0];
    const lanes l2_1 = -X[3] * W32;
    const lanes l2_2 = X[2] * W32;
    const lanes k2_3 = X[1] * W32 + X[2] * V2e2 - X[3] * V1e2;
    lanes_put(&p_out[1], k2_3, stream);
    const lanes Fbk2e2 = C2 * l2_2 + S2 * l2_1;
    const lanes Nbk3d2 = planar2r_geometry_L1 * Fbk2e2 + k2_3;
    const lanes Nks1_2_3 = k1_3 + Nbk3d2;
    lanes_put(&p_out[0], Nks1_2_3, stream);
    const lanes r2 = V2e2 * l2_1 - V1e2 * l2_2;
    lanes_put(&rate_out[1], r2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *p_out, apart *rate_out)
{
    return panel(q, qd, X, p_out, rate_out, 0);
}

int planar2r_generalized_momentum_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
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
    lanes lanes_p_out[BLOCKS(2u)];
    lanes lanes_rate_out[BLOCKS(2u)];
    double scratch[2u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_p_out, 0, sizeof lanes_p_out);
    memset(lanes_rate_out, 0, sizeof lanes_rate_out);
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
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_p_out, (apart *)lanes_rate_out);
        lanes_store(lanes_p_out, 2u, count, stream, scratch, &p_out[k * 2u]);
        lanes_store(lanes_rate_out, 2u, count, stream, scratch, &rate_out[k * 2u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
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
        apart *lanes_p_out = (apart *)&p_out[k * 2u];
        apart *lanes_rate_out = (apart *)&rate_out[k * 2u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_p_out, lanes_rate_out, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_p_out, lanes_rate_out);
    }
    return status;
}

int planar2r_generalized_momentum_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    if (!(streamed(stream, p_out) && streamed(stream, rate_out))) {
        return panels(0, N, strides, q, qd, X, p_out, rate_out);
    }
    const int status = panels(1, N, strides, q, qd, X, p_out, rate_out);
    stream_end();
    return status;
}

#else

int planar2r_generalized_momentum_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_generalized_momentum(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &p_out[k * 2u], &rate_out[k * 2u]);
    }
    return status;
}

int planar2r_generalized_momentum_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    return planar2r_generalized_momentum_rows(stream, N, strides, q, qd, X, p_out, rate_out);
}

#endif

size_t planar2r_generalized_momentum_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_generalized_momentum_batch(size_t N, const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    (void)planar2r_generalized_momentum_rows(0, N, NULL, q, qd, X, p_out, rate_out);
}
