/* planar2r: jacobian of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, apart *J_out, const int stream)
{
    (void)stream;
    lanes_put(&J_out[10], lanes_all(1.0), stream);
    lanes_put(&J_out[11], lanes_all(1.0), stream);
    turned q_0 = lanes_turn(q[0]);
    if (lanes_any(~(mask)(lanes_abs(q[0]) <= NEAR))) {
        q_0 = lanes_far(q[0], q_0);
    }
    const lanes C1 = q_0.c;
    const lanes S1 = q_0.s;
    const lanes pd2_1 = planar2r_geometry_L1 * C1;
    lanes_put(&J_out[2], pd2_1, stream);
    const lanes pd2_2 = planar2r_geometry_L1 * S1;
    lanes_put(&J_out[0], -pd2_2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, apart *J_out)
{
    return panel(q, J_out, 0);
}

int planar2r_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes lanes_J_out[BLOCKS(12u)];
    double scratch[12u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_J_out, 0, sizeof lanes_J_out);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        status |= plain(lanes_q, (apart *)lanes_J_out);
        lanes_store(lanes_J_out, 12u, count, stream, scratch, &J_out[k * 12u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        apart *lanes_J_out = (apart *)&J_out[k * 12u];
        status |= stream ? panel(lanes_q, lanes_J_out, 1) : plain(lanes_q, lanes_J_out);
    }
    return status;
}

int planar2r_jacobian_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    if (!(streamed(stream, J_out))) {
        return panels(0, N, strides, q, J_out);
    }
    const int status = panels(1, N, strides, q, J_out);
    stream_end();
    return status;
}

#else

int planar2r_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_jacobian(&q[k * stride_q], &J_out[k * 12u]);
    }
    return status;
}

int planar2r_jacobian_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    return planar2r_jacobian_rows(stream, N, strides, q, J_out);
}

#endif

size_t planar2r_jacobian_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_jacobian_batch(size_t N, const double *q, double *J_out)
{
    (void)planar2r_jacobian_rows(0, N, NULL, q, J_out);
}
