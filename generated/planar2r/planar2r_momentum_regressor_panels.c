/* planar2r: momentum_regressor of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, apart *p_out, apart *dl_out, const int stream)
{
    (void)stream;
    lanes_put(&p_out[0], qd[0], stream);
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes L1_1e2 = planar2r_geometry_L1 * S2;
    const lanes L1_2e2 = planar2r_geometry_L1 * C2;
    const lanes V2d2 = qd[0] * planar2r_geometry_L1;
    const lanes V1e2 = S2 * V2d2;
    lanes_put(&p_out[7], -V1e2, stream);
    const lanes V2e2 = C2 * V2d2;
    lanes_put(&p_out[6], V2e2, stream);
    const lanes W32 = qd[0] + qd[1];
    lanes_put(&p_out[1], W32, stream);
    lanes_put(&p_out[5], W32, stream);
    const lanes QMX2_1 = L1_2e2 * W32 + V2e2;
    lanes_put(&p_out[2], QMX2_1, stream);
    const lanes SMX2_2 = -V1e2 * W32;
    lanes_put(&dl_out[6], SMX2_2, stream);
    const lanes QMY2_1 = -L1_1e2 * W32 - V1e2;
    lanes_put(&p_out[3], QMY2_1, stream);
    const lanes SMY2_2 = -V2e2 * W32;
    lanes_put(&dl_out[7], SMY2_2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, apart *p_out, apart *dl_out)
{
    return panel(q, qd, p_out, dl_out, 0);
}

int planar2r_momentum_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes lanes_p_out[BLOCKS(8u)];
    lanes lanes_dl_out[BLOCKS(8u)];
    double scratch[8u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_p_out, 0, sizeof lanes_p_out);
    memset(lanes_dl_out, 0, sizeof lanes_dl_out);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        status |= plain(lanes_q, lanes_qd, (apart *)lanes_p_out, (apart *)lanes_dl_out);
        lanes_store(lanes_p_out, 8u, count, stream, scratch, &p_out[k * 8u]);
        lanes_store(lanes_dl_out, 8u, count, stream, scratch, &dl_out[k * 8u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        apart *lanes_p_out = (apart *)&p_out[k * 8u];
        apart *lanes_dl_out = (apart *)&dl_out[k * 8u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_p_out, lanes_dl_out, 1) : plain(lanes_q, lanes_qd, lanes_p_out, lanes_dl_out);
    }
    return status;
}

int planar2r_momentum_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    if (!(streamed(stream, p_out) && streamed(stream, dl_out))) {
        return panels(0, N, strides, q, qd, p_out, dl_out);
    }
    const int status = panels(1, N, strides, q, qd, p_out, dl_out);
    stream_end();
    return status;
}

#else

int planar2r_momentum_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_momentum_regressor(&q[k * stride_q], &qd[k * stride_qd], &p_out[k * 8u], &dl_out[k * 8u]);
    }
    return status;
}

int planar2r_momentum_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    return planar2r_momentum_regressor_rows(stream, N, strides, q, qd, p_out, dl_out);
}

#endif

size_t planar2r_momentum_regressor_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_momentum_regressor_batch(size_t N, const double *q, const double *qd, double *p_out, double *dl_out)
{
    (void)planar2r_momentum_regressor_rows(0, N, NULL, q, qd, p_out, dl_out);
}
