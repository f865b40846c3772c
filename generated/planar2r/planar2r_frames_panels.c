/* planar2r: frames of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, apart *T_out, const int stream)
{
    (void)stream;
    lanes_put(&T_out[10], lanes_all(1.0), stream);
    lanes_put(&T_out[15], lanes_all(1.0), stream);
    lanes_put(&T_out[26], lanes_all(1.0), stream);
    lanes_put(&T_out[31], lanes_all(1.0), stream);
    turned q_0 = lanes_turn(q[0]);
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[0]) + lanes_abs(q[1]) <= NEAR))) {
        q_0 = lanes_far(q[0], q_0);
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C1 = q_0.c;
    lanes_put(&T_out[0], C1, stream);
    lanes_put(&T_out[5], C1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&T_out[1], -S1, stream);
    lanes_put(&T_out[4], S1, stream);
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes pd2_1 = planar2r_geometry_L1 * C1;
    lanes_put(&T_out[19], pd2_1, stream);
    const lanes pd2_2 = planar2r_geometry_L1 * S1;
    lanes_put(&T_out[23], pd2_2, stream);
    const lanes R1e2_1 = C1 * C2 - S1 * S2;
    lanes_put(&T_out[16], R1e2_1, stream);
    lanes_put(&T_out[21], R1e2_1, stream);
    const lanes R1e2_2 = C1 * S2 + S1 * C2;
    lanes_put(&T_out[17], -R1e2_2, stream);
    lanes_put(&T_out[20], R1e2_2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, apart *T_out)
{
    return panel(q, T_out, 0);
}

int planar2r_frames_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes lanes_T_out[BLOCKS(32u)];
    double scratch[32u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_T_out, 0, sizeof lanes_T_out);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        status |= plain(lanes_q, (apart *)lanes_T_out);
        lanes_store(lanes_T_out, 32u, count, stream, scratch, &T_out[k * 32u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, double *T_out)
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
        apart *lanes_T_out = (apart *)&T_out[k * 32u];
        status |= stream ? panel(lanes_q, lanes_T_out, 1) : plain(lanes_q, lanes_T_out);
    }
    return status;
}

int planar2r_frames_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    if (!(streamed(stream, T_out))) {
        return panels(0, N, strides, q, T_out);
    }
    const int status = panels(1, N, strides, q, T_out);
    stream_end();
    return status;
}

#else

int planar2r_frames_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_frames(&q[k * stride_q], &T_out[k * 32u]);
    }
    return status;
}

int planar2r_frames_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    return planar2r_frames_rows(stream, N, strides, q, T_out);
}

#endif

size_t planar2r_frames_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_frames_batch(size_t N, const double *q, double *T_out)
{
    (void)planar2r_frames_rows(0, N, NULL, q, T_out);
}
