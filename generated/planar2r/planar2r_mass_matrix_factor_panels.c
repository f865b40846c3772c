/* planar2r: mass_matrix_factor of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *X, apart *L_out, apart *D_out, const int stream)
{
    (void)stream;
    lanes_put(&L_out[0], lanes_all(1.0), stream);
    lanes_put(&L_out[3], lanes_all(1.0), stream);
    lanes_put(&D_out[1], X[1], stream);
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
    lanes_put(&L_out[1], l2_1, stream);
    const lanes m2_1_1 = J33s1_2 - Nbm23d2 * l2_1;
    lanes_put(&D_out[0], m2_1_1, stream);
    const mask singular = (mask)(X[1] <= 0.0) | (mask)(m2_1_1 <= 0.0);
    const mask odd = (~(mask)(X[1] > 0.0) & ~(mask)(X[1] <= 0.0)) | (~(mask)(m2_1_1 > 0.0) & ~(mask)(m2_1_1 <= 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l2_1 - l2_1 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(m2_1_1 - m2_1_1 == 0.0)) | (~(mask)(X[1] - X[1] == 0.0));
    const int status = (lanes_any(singular) ? (int)planar2r_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int)planar2r_NOT_FINITE : 0);
    return status;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *X, apart *L_out, apart *D_out)
{
    return panel(q, X, L_out, D_out, 0);
}

int planar2r_mass_matrix_factor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
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
    lanes lanes_L_out[BLOCKS(4u)];
    lanes lanes_D_out[BLOCKS(2u)];
    double scratch[4u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_L_out, 0, sizeof lanes_L_out);
    memset(lanes_D_out, 0, sizeof lanes_D_out);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_X, (apart *)lanes_L_out, (apart *)lanes_D_out);
        lanes_store(lanes_L_out, 4u, count, stream, scratch, &L_out[k * 4u]);
        lanes_store(lanes_D_out, 2u, count, stream, scratch, &D_out[k * 2u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *X, double *L_out, double *D_out)
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
        apart *lanes_L_out = (apart *)&L_out[k * 4u];
        apart *lanes_D_out = (apart *)&D_out[k * 2u];
        status |= stream ? panel(lanes_q, lanes_X, lanes_L_out, lanes_D_out, 1) : plain(lanes_q, lanes_X, lanes_L_out, lanes_D_out);
    }
    return status;
}

int planar2r_mass_matrix_factor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    if (!(streamed(stream, L_out) && streamed(stream, D_out))) {
        return panels(0, N, strides, q, X, L_out, D_out);
    }
    const int status = panels(1, N, strides, q, X, L_out, D_out);
    stream_end();
    return status;
}

#else

int planar2r_mass_matrix_factor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        status |= planar2r_mass_matrix_factor(&q[k * stride_q], &X[k * stride_X], &L_out[k * 4u], &D_out[k * 2u]);
    }
    return status;
}

int planar2r_mass_matrix_factor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    return planar2r_mass_matrix_factor_rows(stream, N, strides, q, X, L_out, D_out);
}

#endif

size_t planar2r_mass_matrix_factor_width(void)
{
    return planar2r_WIDTH;
}

int planar2r_mass_matrix_factor_batch(size_t N, const double *q, const double *X, double *L_out, double *D_out)
{
    return planar2r_mass_matrix_factor_rows(0, N, NULL, q, X, L_out, D_out);
}
