/* planar2r: mass_matrix of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *X, apart *M, const int stream)
{
    (void)stream;
    lanes_put(&M[3], X[1], stream);
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes m2_1e2 = X[2] * C2 - X[3] * S2;
    const lanes xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const lanes J33d2_2 = X[1] + xd2_2;
    const lanes J33s1_2 = X[0] + J33d2_2;
    lanes_put(&M[0], J33s1_2, stream);
    const lanes Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    lanes_put(&M[1], Nbm23d2, stream);
    lanes_put(&M[2], Nbm23d2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *X, apart *M)
{
    return panel(q, X, M, 0);
}

int planar2r_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(X, 4u, lanes_X);
    lanes lanes_M[BLOCKS(4u)];
    double scratch[4u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_M, 0, sizeof lanes_M);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_X, (apart *)lanes_M);
        lanes_store(lanes_M, 4u, count, stream, scratch, &M[k * 4u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(X, 4u, lanes_X);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_M = (apart *)&M[k * 4u];
        status |= stream ? panel(lanes_q, lanes_X, lanes_M, 1) : plain(lanes_q, lanes_X, lanes_M);
    }
    return status;
}

int planar2r_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    if (!(streamed(stream, M))) {
        return panels(0, N, strides, q, X, M);
    }
    const int status = panels(1, N, strides, q, X, M);
    stream_end();
    return status;
}

#else

int planar2r_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_mass_matrix(&q[k * stride_q], &X[k * stride_X], &M[k * 4u]);
    }
    return status;
}

int planar2r_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    return planar2r_mass_matrix_rows(stream, N, strides, q, X, M);
}

#endif

size_t planar2r_mass_matrix_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_mass_matrix_batch(size_t N, const double *q, const double *X, double *M)
{
    (void)planar2r_mass_matrix_rows(0, N, NULL, q, X, M);
}
