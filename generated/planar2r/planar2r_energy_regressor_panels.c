/* planar2r: energy_regressor of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, apart *out, const int stream)
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
    const lanes Hqd1 = 0.5 * qd[0];
    const lanes DZZ1 = qd[0] * Hqd1;
    lanes_put(&out[0], DZZ1, stream);
    const lanes HW32 = 0.5 * W32;
    const lanes DZZ2 = W32 * HW32;
    lanes_put(&out[1], DZZ2, stream);
    const lanes DMX2 = V2e2 * W32;
    lanes_put(&out[2], DMX2, stream);
    const lanes DMY2 = -V1e2 * W32;
    lanes_put(&out[3], DMY2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, apart *out)
{
    return panel(q, qd, out, 0);
}

int planar2r_energy_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
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
    lanes lanes_out[BLOCKS(4u)];
    double scratch[4u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        status |= plain(lanes_q, lanes_qd, (apart *)lanes_out);
        lanes_store(lanes_out, 4u, count, stream, scratch, &out[k * 4u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, double *out)
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
        apart *lanes_out = (apart *)&out[k * 4u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_out);
    }
    return status;
}

int planar2r_energy_regressor_panels(int stream, size_t N, const size_t *strides,
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

int planar2r_energy_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_energy_regressor(&q[k * stride_q], &qd[k * stride_qd], &out[k * 4u]);
    }
    return status;
}

int planar2r_energy_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    return planar2r_energy_regressor_rows(stream, N, strides, q, qd, out);
}

#endif

size_t planar2r_energy_regressor_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_energy_regressor_batch(size_t N, const double *q, const double *qd, double *out)
{
    (void)planar2r_energy_regressor_rows(0, N, NULL, q, qd, out);
}
