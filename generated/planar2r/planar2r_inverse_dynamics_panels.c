/* planar2r: inverse_dynamics of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    turned q_1 = lanes_turn(q[1]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes ZP33d2 = qd[0] * qd[0];
    const lanes Z2d2 = qdd[0] * planar2r_geometry_L1;
    const lanes Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const lanes Z1e2 = C2 * Z1d2 + S2 * Z2d2;
    const lanes Z2e2 = C2 * Z2d2 - S2 * Z1d2;
    const lanes X32 = qdd[0] + qdd[1];
    const lanes W32 = qd[0] + qd[1];
    const lanes N1_3 = qdd[0] * X[0];
    const lanes P332 = W32 * W32;
    const lanes F2_1 = -X[2] * P332 - X[3] * X32;
    const lanes F2_2 = X[2] * X32 - X[3] * P332;
    const lanes N2_3 = X[1] * X32 + X[2] * Z2e2 - X[3] * Z1e2;
    lanes_put(&tau[1], N2_3, stream);
    const lanes Fb2e2 = C2 * F2_2 + S2 * F2_1;
    const lanes Nb3d2 = planar2r_geometry_L1 * Fb2e2 + N2_3;
    const lanes Ns1_2_3 = N1_3 + Nb3d2;
    lanes_put(&tau[0], Ns1_2_3, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *tau)
{
    return panel(q, qd, qdd, X, tau, 0);
}

int planar2r_inverse_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_qdd[REACH(2u)];
    lanes lanes_qdd[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(qdd, 2u, lanes_qdd);
    lanes_shared(X, 4u, lanes_X);
    lanes lanes_tau[BLOCKS(2u)];
    double scratch[2u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_read(qdd, 2u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 2u, count, stream, scratch, &tau[k * 2u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    double padded_q[REACH(2u)];
    lanes lanes_q[BLOCKS(2u)];
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_qdd[REACH(2u)];
    lanes lanes_qdd[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 2u, lanes_q);
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(qdd, 2u, lanes_qdd);
    lanes_shared(X, 4u, lanes_X);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 2u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_read(qdd, 2u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 2u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_tau, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_tau);
    }
    return status;
}

int planar2r_inverse_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    if (!(streamed(stream, tau))) {
        return panels(0, N, strides, q, qd, qdd, X, tau);
    }
    const int status = panels(1, N, strides, q, qd, qdd, X, tau);
    stream_end();
    return status;
}

#else

int planar2r_inverse_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_inverse_dynamics(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &X[k * stride_X], &tau[k * 2u]);
    }
    return status;
}

int planar2r_inverse_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    return planar2r_inverse_dynamics_rows(stream, N, strides, q, qd, qdd, X, tau);
}

#endif

size_t planar2r_inverse_dynamics_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_inverse_dynamics_batch(size_t N, const double *q, const double *qd, const double *qdd, const double *X, double *tau)
{
    (void)planar2r_inverse_dynamics_rows(0, N, NULL, q, qd, qdd, X, tau);
}
