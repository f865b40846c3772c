/* puma560: gravity_torque of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_5 = lanes_turn(q[5]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[5]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_5 = lanes_far(q[5], q_5);
    }
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
    const lanes C6 = q_5.c;
    const lanes S6 = q_5.s;
    const lanes Z1e2 = -gz * S2;
    const lanes Z2e2 = -gz * C2;
    const lanes Z1e3 = C3 * Z1e2 + S3 * Z2e2;
    const lanes Z2e3 = C3 * Z2e2 - S3 * Z1e2;
    const lanes Z1e4 = C4 * Z1e3;
    const lanes Z2e4 = -S4 * Z1e3;
    const lanes Z1e5 = C5 * Z1e4 + S5 * Z2e3;
    const lanes Z2e5 = C5 * Z2e3 - S5 * Z1e4;
    const lanes Z1e6 = C6 * Z1e5 + S6 * Z2e4;
    const lanes Z2e6 = C6 * Z2e4 - S6 * Z1e5;
    const lanes N2_3 = X[6] * Z2e2 - X[7] * Z1e2;
    const lanes N3_3 = X[13] * Z2e3 - X[14] * Z1e3;
    const lanes N4_1 = -X[22] * Z2e3;
    const lanes N4_2 = X[21] * Z2e3;
    const lanes N4_3 = X[21] * Z2e4 - X[22] * Z1e4;
    const lanes N5_1 = X[30] * Z2e4;
    const lanes N5_2 = -X[29] * Z2e4;
    const lanes N5_3 = X[29] * Z2e5 - X[30] * Z1e5;
    const lanes N6_1 = -X[38] * Z2e5;
    const lanes N6_2 = X[37] * Z2e5;
    const lanes N6_3 = X[37] * Z2e6 - X[38] * Z1e6;
    lanes_put(&tau[5], N6_3, stream);
    const lanes Nb1e6 = C6 * N6_1 - S6 * N6_2;
    const lanes Nb2e6 = C6 * N6_2 + S6 * N6_1;
    const lanes Ns5_6_1 = N5_1 + Nb1e6;
    const lanes Ns5_6_2 = N5_2 - N6_3;
    const lanes Ns5_6_3 = N5_3 + Nb2e6;
    lanes_put(&tau[4], Ns5_6_3, stream);
    const lanes Nb1e5 = C5 * Ns5_6_1 - S5 * Ns5_6_2;
    const lanes Nb2e5 = C5 * Ns5_6_2 + S5 * Ns5_6_1;
    const lanes Ns4_5_1 = N4_1 + Nb1e5;
    const lanes Ns4_5_2 = N4_2 + Ns5_6_3;
    const lanes Ns4_5_3 = N4_3 - Nb2e5;
    lanes_put(&tau[3], Ns4_5_3, stream);
    const lanes Nb1e4 = C4 * Ns4_5_1 - S4 * Ns4_5_2;
    const lanes Nb2e4 = C4 * Ns4_5_2 + S4 * Ns4_5_1;
    const lanes Ns3_4_3 = N3_3 + Nb2e4;
    lanes_put(&tau[2], Ns3_4_3, stream);
    const lanes Nb1e3 = C3 * Nb1e4 + S3 * Ns4_5_3;
    const lanes Nb2e3 = S3 * Nb1e4 - C3 * Ns4_5_3;
    const lanes Ns2_3_3 = N2_3 + Ns3_4_3;
    lanes_put(&tau[1], Ns2_3_3, stream);
    const lanes Nb2e2 = C2 * Nb2e3 + S2 * Nb1e3;
    lanes_put(&tau[0], -Nb2e2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *X, apart *tau)
{
    return panel(q, X, tau, 0);
}

int puma560_gravity_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_X[REACH(40u)];
    lanes lanes_X[BLOCKS(40u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(X, 40u, lanes_X);
    lanes lanes_tau[BLOCKS(6u)];
    double scratch[6u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_read(X, 40u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 6u, count, stream, scratch, &tau[k * 6u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_X[REACH(40u)];
    lanes lanes_X[BLOCKS(40u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(X, 40u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_read(X, 40u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 6u];
        status |= stream ? panel(lanes_q, lanes_X, lanes_tau, 1) : plain(lanes_q, lanes_X, lanes_tau);
    }
    return status;
}

int puma560_gravity_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *tau)
{
    if (!(streamed(stream, tau))) {
        return panels(0, N, strides, q, X, tau);
    }
    const int status = panels(1, N, strides, q, X, tau);
    stream_end();
    return status;
}

#else

int puma560_gravity_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_gravity_torque(&q[k * stride_q], &X[k * stride_X], &tau[k * 6u]);
    }
    return status;
}

int puma560_gravity_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *tau)
{
    return puma560_gravity_torque_rows(stream, N, strides, q, X, tau);
}

#endif

size_t puma560_gravity_torque_width(void)
{
    return puma560_WIDTH;
}

void puma560_gravity_torque_batch(size_t N, const double *q, const double *X, double *tau)
{
    (void)puma560_gravity_torque_rows(0, N, NULL, q, X, tau);
}
