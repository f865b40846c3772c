/* twin: jacobian of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, apart *J_out, const int stream)
{
    (void)stream;
    const double b2 = 0.6;
    const double d2 = 0.2;
    const double d3 = 0.3;
    lanes_put(&J_out[35], lanes_all(1.0), stream);
    turned q_0 = lanes_turn(q[0]);
    turned q_4 = lanes_turn(q[4]);
    if (lanes_any(~(mask)(lanes_abs(q[0]) + lanes_abs(q[4]) <= NEAR))) {
        q_0 = lanes_far(q[0], q_0);
        q_4 = lanes_far(q[4], q_4);
    }
    const lanes C1 = q_0.c;
    lanes_put(&J_out[25], -C1, stream);
    lanes_put(&J_out[27], -C1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&J_out[32], -S1, stream);
    lanes_put(&J_out[34], -S1, stream);
    const lanes C5 = q_4.c;
    lanes_put(&J_out[19], -C5, stream);
    const lanes S5 = q_4.s;
    const lanes R6 = q[5] + d3;
    const lanes pr6_3 = b2 - C5 * R6;
    const lanes a5_3 = pr6_3 - b2;
    const lanes v5_1 = -S1 * a5_3;
    lanes_put(&J_out[4], v5_1, stream);
    const lanes v5_2 = C1 * a5_3;
    lanes_put(&J_out[11], v5_2, stream);
    const lanes pd2_1 = -d2 * S1;
    const lanes pd2_2 = d2 * C1;
    const lanes R2e5_1 = -S1 * S5;
    lanes_put(&J_out[5], -R2e5_1, stream);
    const lanes R2e5_2 = C1 * S5;
    lanes_put(&J_out[12], -R2e5_2, stream);
    const lanes pr6_1 = -R6 * R2e5_1 - pd2_1;
    lanes_put(&J_out[7], pr6_1, stream);
    const lanes pr6_2 = -R6 * R2e5_2 - pd2_2;
    lanes_put(&J_out[0], -pr6_2, stream);
    const lanes a5_1 = pd2_1 + pr6_1;
    const lanes a5_2 = pd2_2 + pr6_2;
    const lanes v5_3 = S1 * a5_1 - C1 * a5_2;
    lanes_put(&J_out[18], v5_3, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, apart *J_out)
{
    return panel(q, J_out, 0);
}

int twin_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes lanes_J_out[BLOCKS(42u)];
    double scratch[42u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_J_out, 0, sizeof lanes_J_out);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        status |= plain(lanes_q, (apart *)lanes_J_out);
        lanes_store(lanes_J_out, 42u, count, stream, scratch, &J_out[k * 42u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        apart *lanes_J_out = (apart *)&J_out[k * 42u];
        status |= stream ? panel(lanes_q, lanes_J_out, 1) : plain(lanes_q, lanes_J_out);
    }
    return status;
}

int twin_jacobian_panels(int stream, size_t N, const size_t *strides,
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

int twin_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_jacobian(&q[k * stride_q], &J_out[k * 42u]);
    }
    return status;
}

int twin_jacobian_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    return twin_jacobian_rows(stream, N, strides, q, J_out);
}

#endif

size_t twin_jacobian_width(void)
{
    return twin_WIDTH;
}

void twin_jacobian_batch(size_t N, const double *q, double *J_out)
{
    (void)twin_jacobian_rows(0, N, NULL, q, J_out);
}
