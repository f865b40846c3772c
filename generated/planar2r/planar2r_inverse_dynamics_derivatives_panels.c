/* planar2r: inverse_dynamics_derivatives of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *dq_out, apart *dqd_out, const int stream)
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
    const lanes ZP33d2 = qd[0] * qd[0];
    const lanes Z2d2 = qdd[0] * planar2r_geometry_L1;
    const lanes Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const lanes Z1e2 = C2 * Z1d2 + S2 * Z2d2;
    const lanes Z2e2 = C2 * Z2d2 - S2 * Z1d2;
    const lanes X32 = qdd[0] + qdd[1];
    const lanes P332 = W32 * W32;
    const lanes F2_1 = -X[2] * P332 - X[3] * X32;
    const lanes F2_2 = X[2] * X32 - X[3] * P332;
    const lanes Fb1e2 = C2 * F2_1 - S2 * F2_2;
    const lanes l2_1 = -X[3] * W32;
    const lanes l2_2 = X[2] * W32;
    const lanes r32 = X[2] * V1e2 + X[3] * V2e2;
    const lanes R332 = 2.0 * r32;
    lanes_put(&dqd_out[2], R332, stream);
    const lanes m2_1e2_ = C2 * l2_1 - S2 * l2_2;
    const lanes xd2_2_ = 2.0 * planar2r_geometry_L1 * m2_1e2_;
    const lanes J33d2_2_ = R332 + xd2_2_;
    lanes_put(&dqd_out[0], J33d2_2_, stream);
    const lanes b2_1 = 2.0 * V2e2;
    const lanes b2_2 = -2.0 * V1e2;
    const lanes np2_3 = -X[2] * Z1e2 - X[3] * Z2e2;
    lanes_put(&dq_out[3], np2_3, stream);
    const lanes fq2_1 = -2.0 * l2_2;
    const lanes fq2_2 = 2.0 * l2_1;
    const lanes nq2_3 = X[2] * b2_2 + R332 - X[3] * b2_1;
    lanes_put(&dqd_out[3], nq2_3, stream);
    const lanes Nbp23d2 = planar2r_geometry_L1 * Fb1e2 + np2_3;
    lanes_put(&dq_out[1], Nbp23d2, stream);
    const lanes Fbq22e2 = C2 * fq2_2 + S2 * fq2_1;
    const lanes Nbq23d2 = planar2r_geometry_L1 * Fbq22e2 + nq2_3;
    lanes_put(&dqd_out[1], Nbq23d2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, const lanes *X, apart *dq_out, apart *dqd_out)
{
    return panel(q, qd, qdd, X, dq_out, dqd_out, 0);
}

int planar2r_inverse_dynamics_derivatives_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double *dqd_out)
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
    lanes lanes_dq_out[BLOCKS(4u)];
    lanes lanes_dqd_out[BLOCKS(4u)];
    double scratch[4u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_dq_out, 0, sizeof lanes_dq_out);
    memset(lanes_dqd_out, 0, sizeof lanes_dqd_out);
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
        status |= plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, (apart *)lanes_dq_out, (apart *)lanes_dqd_out);
        lanes_store(lanes_dq_out, 4u, count, stream, scratch, &dq_out[k * 4u]);
        lanes_store(lanes_dqd_out, 4u, count, stream, scratch, &dqd_out[k * 4u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double *dqd_out)
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
        apart *lanes_dq_out = (apart *)&dq_out[k * 4u];
        apart *lanes_dqd_out = (apart *)&dqd_out[k * 4u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_dq_out, lanes_dqd_out, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_X, lanes_dq_out, lanes_dqd_out);
    }
    return status;
}

int planar2r_inverse_dynamics_derivatives_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double *dqd_out)
{
    if (!(streamed(stream, dq_out) && streamed(stream, dqd_out))) {
        return panels(0, N, strides, q, qd, qdd, X, dq_out, dqd_out);
    }
    const int status = panels(1, N, strides, q, qd, qdd, X, dq_out, dqd_out);
    stream_end();
    return status;
}

#else

int planar2r_inverse_dynamics_derivatives_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double *dqd_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 2u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[3] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_inverse_dynamics_derivatives(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &X[k * stride_X], &dq_out[k * 4u], &dqd_out[k * 4u]);
    }
    return status;
}

int planar2r_inverse_dynamics_derivatives_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double *dqd_out)
{
    return planar2r_inverse_dynamics_derivatives_rows(stream, N, strides, q, qd, qdd, X, dq_out, dqd_out);
}

#endif

size_t planar2r_inverse_dynamics_derivatives_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_inverse_dynamics_derivatives_batch(size_t N, const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double *dqd_out)
{
    (void)planar2r_inverse_dynamics_derivatives_rows(0, N, NULL, q, qd, qdd, X, dq_out, dqd_out);
}
