/* planar2r: energy of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *T_out, apart *U_out, const int stream)
{
    (void)stream;
    (void)U_out;
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
    const lanes HW32 = 0.5 * W32;
    const lanes DZZ2 = W32 * HW32;
    const lanes DMX2 = V2e2 * W32;
    const lanes DMY2 = -V1e2 * W32;
    const lanes Tsum = X[0] * DZZ1 + X[1] * DZZ2 + X[2] * DMX2 + X[3] * DMY2;
    lanes_put(&T_out[0], Tsum, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *T_out, apart *U_out)
{
    return panel(q, qd, X, T_out, U_out, 0);
}

int planar2r_energy_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *T_out, double *U_out)
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
    lanes lanes_T_out[BLOCKS(1u)];
    lanes lanes_U_out[BLOCKS(1u)];
    double scratch[1u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_T_out, 0, sizeof lanes_T_out);
    memset(lanes_U_out, 0, sizeof lanes_U_out);
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
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_T_out, (apart *)lanes_U_out);
        lanes_store(lanes_T_out, 1u, count, stream, scratch, &T_out[k * 1u]);
        lanes_store(lanes_U_out, 1u, count, stream, scratch, &U_out[k * 1u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *T_out, double *U_out)
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
        apart *lanes_T_out = (apart *)&T_out[k * 1u];
        apart *lanes_U_out = (apart *)&U_out[k * 1u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_T_out, lanes_U_out, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_T_out, lanes_U_out);
    }
    return status;
}

int planar2r_energy_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *T_out, double *U_out)
{
    if (!(streamed(stream, T_out) && streamed(stream, U_out))) {
        return panels(0, N, strides, q, qd, X, T_out, U_out);
    }
    const int status = panels(1, N, strides, q, qd, X, T_out, U_out);
    stream_end();
    return status;
}

#else

int planar2r_energy_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *T_out, double *U_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_energy(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &T_out[k * 1u], &U_out[k * 1u]);
    }
    return status;
}

int planar2r_energy_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *T_out, double *U_out)
{
    return planar2r_energy_rows(stream, N, strides, q, qd, X, T_out, U_out);
}

#endif

size_t planar2r_energy_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_energy_batch(size_t N, const double *q, const double *qd, const double *X, double *T_out, double *U_out)
{
    (void)planar2r_energy_rows(0, N, NULL, q, qd, X, T_out, U_out);
}
