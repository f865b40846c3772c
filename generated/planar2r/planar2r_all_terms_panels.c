/* planar2r: all_terms of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *M, apart *h, apart *tau, apart *J_out, apart *T_out, const int stream)
{
    (void)stream;
    (void)tau;
    lanes_put(&M[3], X[1], stream);
    lanes_put(&J_out[10], lanes_all(1.0), stream);
    lanes_put(&J_out[11], lanes_all(1.0), stream);
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
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes m2_1e2 = X[2] * C2 - X[3] * S2;
    const lanes Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    lanes_put(&M[1], Nbm23d2, stream);
    lanes_put(&M[2], Nbm23d2, stream);
    const lanes xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const lanes J33d2_2 = X[1] + xd2_2;
    const lanes J33s1_2 = X[0] + J33d2_2;
    lanes_put(&M[0], J33s1_2, stream);
    const lanes ZP33d2 = qd[0] * qd[0];
    const lanes Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const lanes Z1e2 = C2 * Z1d2;
    const lanes Z2e2 = -S2 * Z1d2;
    const lanes N2_3 = X[2] * Z2e2 - X[3] * Z1e2;
    lanes_put(&h[1], N2_3, stream);
    const lanes W32 = qd[0] + qd[1];
    const lanes P332 = W32 * W32;
    const lanes F2_1 = -X[2] * P332;
    const lanes F2_2 = -X[3] * P332;
    const lanes Fb2e2 = C2 * F2_2 + S2 * F2_1;
    const lanes Nb3d2 = planar2r_geometry_L1 * Fb2e2 + N2_3;
    lanes_put(&h[0], Nb3d2, stream);
    const lanes C1 = q_0.c;
    lanes_put(&T_out[0], C1, stream);
    lanes_put(&T_out[5], C1, stream);
    const lanes pd2_1 = planar2r_geometry_L1 * C1;
    lanes_put(&J_out[2], pd2_1, stream);
    lanes_put(&T_out[19], pd2_1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&T_out[1], -S1, stream);
    lanes_put(&T_out[4], S1, stream);
    const lanes pd2_2 = planar2r_geometry_L1 * S1;
    lanes_put(&J_out[0], -pd2_2, stream);
    lanes_put(&T_out[23], pd2_2, stream);
    const lanes R1e2_1 = C2 * C1 - S2 * S1;
    lanes_put(&T_out[16], R1e2_1, stream);
    lanes_put(&T_out[21], R1e2_1, stream);
    const lanes R1e2_2 = C2 * S1 + S2 * C1;
    lanes_put(&T_out[17], -R1e2_2, stream);
    lanes_put(&T_out[20], R1e2_2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *M, apart *h, apart *tau, apart *J_out, apart *T_out)
{
    return panel(q, qd, X, M, h, tau, J_out, T_out, 0);
}

int planar2r_all_terms_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
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
    lanes lanes_M[BLOCKS(4u)];
    lanes lanes_h[BLOCKS(2u)];
    lanes lanes_tau[BLOCKS(2u)];
    lanes lanes_J_out[BLOCKS(12u)];
    lanes lanes_T_out[BLOCKS(32u)];
    double scratch[32u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_M, 0, sizeof lanes_M);
    memset(lanes_h, 0, sizeof lanes_h);
    memset(lanes_tau, 0, sizeof lanes_tau);
    memset(lanes_J_out, 0, sizeof lanes_J_out);
    memset(lanes_T_out, 0, sizeof lanes_T_out);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_M, (apart *)lanes_h, (apart *)lanes_tau, (apart *)lanes_J_out, (apart *)lanes_T_out);
        lanes_store(lanes_M, 4u, count, stream, scratch, &M[k * 4u]);
        lanes_store(lanes_h, 2u, count, stream, scratch, &h[k * 2u]);
        lanes_store(lanes_tau, 2u, count, stream, scratch, &tau[k * 2u]);
        lanes_store(lanes_J_out, 12u, count, stream, scratch, &J_out[k * 12u]);
        lanes_store(lanes_T_out, 32u, count, stream, scratch, &T_out[k * 32u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
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
            lanes_load(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_M = (apart *)&M[k * 4u];
        apart *lanes_h = (apart *)&h[k * 2u];
        apart *lanes_tau = (apart *)&tau[k * 2u];
        apart *lanes_J_out = (apart *)&J_out[k * 12u];
        apart *lanes_T_out = (apart *)&T_out[k * 32u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_M, lanes_h, lanes_tau, lanes_J_out, lanes_T_out, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_M, lanes_h, lanes_tau, lanes_J_out, lanes_T_out);
    }
    return status;
}

int planar2r_all_terms_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    if (!(streamed(stream, M) && streamed(stream, h) && streamed(stream, tau) && streamed(stream, J_out) && streamed(stream, T_out))) {
        return panels(0, N, strides, q, qd, X, M, h, tau, J_out, T_out);
    }
    const int status = panels(1, N, strides, q, qd, X, M, h, tau, J_out, T_out);
    stream_end();
    return status;
}

#else

int planar2r_all_terms_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_all_terms(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &M[k * 4u], &h[k * 2u], &tau[k * 2u], &J_out[k * 12u], &T_out[k * 32u]);
    }
    return status;
}

int planar2r_all_terms_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    return planar2r_all_terms_rows(stream, N, strides, q, qd, X, M, h, tau, J_out, T_out);
}

#endif

size_t planar2r_all_terms_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_all_terms_batch(size_t N, const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    (void)planar2r_all_terms_rows(0, N, NULL, q, qd, X, M, h, tau, J_out, T_out);
}
