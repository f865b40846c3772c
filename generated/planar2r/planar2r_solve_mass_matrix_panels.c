/* planar2r: solve_mass_matrix of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *b, const lanes *X, apart *x, const int stream)
{
    (void)stream;
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
    const lanes Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    const lanes d2 = 1.0 / X[1];
    const lanes l2_1 = Nbm23d2 * d2;
    const lanes m2_1_1 = J33s1_2 - Nbm23d2 * l2_1;
    const lanes d1 = 1.0 / m2_1_1;
    const lanes y2_1 = b[0] - b[1] * l2_1;
    const lanes o1 = d1 * y2_1;
    lanes_put(&x[0], o1, stream);
    const lanes o2 = b[1] * d2 - l2_1 * o1;
    lanes_put(&x[1], o2, stream);
    const mask singular = (mask)(X[1] <= 0.0) | (mask)(m2_1_1 <= 0.0);
    const mask odd = (~(mask)(X[1] > 0.0) & ~(mask)(X[1] <= 0.0)) | (~(mask)(m2_1_1 > 0.0) & ~(mask)(m2_1_1 <= 0.0)) | (~(mask)(o1 - o1 == 0.0)) | (~(mask)(o2 - o2 == 0.0));
    const int status = (lanes_any(singular) ? (int)planar2r_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int)planar2r_NOT_FINITE : 0);
    return status;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *b, const lanes *X, apart *x)
{
    return panel(q, b, X, x, 0);
}

int planar2r_solve_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_b = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_b[REACH(2u)];
    lanes lanes_b[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(b, 2u, lanes_b);
    lanes_shared(X, 4u, lanes_X);
    lanes lanes_x[BLOCKS(2u)];
    double scratch[2u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_x, 0, sizeof lanes_x);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_b != 0u) {
            lanes_read(b, 2u, stride_b, k, N, padded_b, lanes_b);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_b, lanes_X, (apart *)lanes_x);
        lanes_store(lanes_x, 2u, count, stream, scratch, &x[k * 2u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *b, const double *X, double *x)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_b = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_b[REACH(2u)];
    lanes lanes_b[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(b, 2u, lanes_b);
    lanes_shared(X, 4u, lanes_X);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_b != 0u) {
            lanes_read(b, 2u, stride_b, k, N, padded_b, lanes_b);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_x = (apart *)&x[k * 2u];
        status |= stream ? panel(lanes_q, lanes_b, lanes_X, lanes_x, 1) : plain(lanes_q, lanes_b, lanes_X, lanes_x);
    }
    return status;
}

int planar2r_solve_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    if (!(streamed(stream, x))) {
        return panels(0, N, strides, q, b, X, x);
    }
    const int status = panels(1, N, strides, q, b, X, x);
    stream_end();
    return status;
}

#else

int planar2r_solve_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_b = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        status |= planar2r_solve_mass_matrix(&q[k * stride_q], &b[k * stride_b], &X[k * stride_X], &x[k * 2u]);
    }
    return status;
}

int planar2r_solve_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x)
{
    return planar2r_solve_mass_matrix_rows(stream, N, strides, q, b, X, x);
}

#endif

size_t planar2r_solve_mass_matrix_width(void)
{
    return planar2r_WIDTH;
}

int planar2r_solve_mass_matrix_batch(size_t N, const double *q, const double *b, const double *X, double *x)
{
    return planar2r_solve_mass_matrix_rows(0, N, NULL, q, b, X, x);
}
