/* planar2r: slotine_li_regressor of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, apart *out, const int stream)
{
    (void)stream;
    lanes_put(&out[0], qddr[0], stream);
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes L1_1e2 = planar2r_geometry_L1 * S2;
    const lanes L1_2e2 = planar2r_geometry_L1 * C2;
    const lanes W32 = qd[0] + qd[1];
    const lanes vP33d2 = qd[0] * qdr[0];
    const lanes v2d2 = qddr[0] * planar2r_geometry_L1;
    const lanes v1d2 = -planar2r_geometry_L1 * vP33d2;
    const lanes l1e2 = C2 * v1d2 + S2 * v2d2;
    lanes_put(&out[7], -l1e2, stream);
    const lanes l2e2 = C2 * v2d2 - S2 * v1d2;
    lanes_put(&out[6], l2e2, stream);
    const lanes e3j2 = qddr[0] + qddr[1];
    lanes_put(&out[1], e3j2, stream);
    lanes_put(&out[5], e3j2, stream);
    const lanes E3j2 = qdr[0] + qdr[1];
    const lanes nXZ2_2 = W32 * E3j2;
    const lanes TMX2_1 = L1_2e2 * e3j2 + l2e2 - L1_1e2 * nXZ2_2;
    lanes_put(&out[2], TMX2_1, stream);
    const lanes TMY2_1 = -L1_1e2 * e3j2 - L1_2e2 * nXZ2_2 - l1e2;
    lanes_put(&out[3], TMY2_1, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, apart *out)
{
    return panel(q, qd, qdr, qddr, out, 0);
}

int planar2r_slotine_li_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 2u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_qdr[REACH(2u)];
    lanes lanes_qdr[BLOCKS(2u)];
    double padded_qddr[REACH(2u)];
    lanes lanes_qddr[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(qdr, 2u, lanes_qdr);
    lanes_shared(qddr, 2u, lanes_qddr);
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
        if (stride_qdr != 0u) {
            lanes_read(qdr, 2u, stride_qdr, k, N, padded_qdr, lanes_qdr);
        }
        if (stride_qddr != 0u) {
            lanes_read(qddr, 2u, stride_qddr, k, N, padded_qddr, lanes_qddr);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, (apart *)lanes_out);
        lanes_store(lanes_out, 8u, count, stream, scratch, &out[k * 8u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 2u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_qdr[REACH(2u)];
    lanes lanes_qdr[BLOCKS(2u)];
    double padded_qddr[REACH(2u)];
    lanes lanes_qddr[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(qdr, 2u, lanes_qdr);
    lanes_shared(qddr, 2u, lanes_qddr);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdr != 0u) {
            lanes_read(qdr, 2u, stride_qdr, k, N, padded_qdr, lanes_qdr);
        }
        if (stride_qddr != 0u) {
            lanes_read(qddr, 2u, stride_qddr, k, N, padded_qddr, lanes_qddr);
        }
        apart *lanes_out = (apart *)&out[k * 8u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_out);
    }
    return status;
}

int planar2r_slotine_li_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    if (!(streamed(stream, out))) {
        return panels(0, N, strides, q, qd, qdr, qddr, out);
    }
    const int status = panels(1, N, strides, q, qd, qdr, qddr, out);
    stream_end();
    return status;
}

#else

int planar2r_slotine_li_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 2u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 2u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_slotine_li_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdr[k * stride_qdr], &qddr[k * stride_qddr], &out[k * 8u]);
    }
    return status;
}

int planar2r_slotine_li_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    return planar2r_slotine_li_regressor_rows(stream, N, strides, q, qd, qdr, qddr, out);
}

#endif

size_t planar2r_slotine_li_regressor_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_slotine_li_regressor_batch(size_t N, const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    (void)planar2r_slotine_li_regressor_rows(0, N, NULL, q, qd, qdr, qddr, out);
}
