/* puma560: friction of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *qd, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T1 = qd[0] * X[41] + X[40] * sFS1;
    lanes_put(&tau[0], T1, stream);
    const lanes T2 = qd[1] * X[43] + X[42] * sFS2;
    lanes_put(&tau[1], T2, stream);
    const lanes T3 = qd[2] * X[45] + X[44] * sFS3;
    lanes_put(&tau[2], T3, stream);
    const lanes T4 = qd[3] * X[47] + X[46] * sFS4;
    lanes_put(&tau[3], T4, stream);
    const lanes T5 = qd[4] * X[49] + X[48] * sFS5;
    lanes_put(&tau[4], T5, stream);
    const lanes T6 = qd[5] * X[51] + X[50] * sFS6;
    lanes_put(&tau[5], T6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *qd, const lanes *X, apart *tau)
{
    return panel(qd, X, tau, 0);
}

int puma560_friction_rows(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(X, 52u, lanes_X);
    lanes lanes_tau[BLOCKS(6u)];
    double scratch[6u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_qd, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 6u, count, stream, scratch, &tau[k * 6u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(X, 52u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 6u];
        status |= stream ? panel(lanes_qd, lanes_X, lanes_tau, 1) : plain(lanes_qd, lanes_X, lanes_tau);
    }
    return status;
}

int puma560_friction_panels(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    if (!(streamed(stream, tau))) {
        return panels(0, N, strides, qd, X, tau);
    }
    const int status = panels(1, N, strides, qd, X, tau);
    stream_end();
    return status;
}

#else

int puma560_friction_rows(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_friction(&qd[k * stride_qd], &X[k * stride_X], &tau[k * 6u]);
    }
    return status;
}

int puma560_friction_panels(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    return puma560_friction_rows(stream, N, strides, qd, X, tau);
}

#endif

size_t puma560_friction_width(void)
{
    return puma560_WIDTH;
}

void puma560_friction_batch(size_t N, const double *qd, const double *X, double *tau)
{
    (void)puma560_friction_rows(0, N, NULL, qd, X, tau);
}
