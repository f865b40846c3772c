/* twin: friction of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *qd, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes T1 = qd[0] * X[45] + X[44] * sFS1;
    lanes_put(&tau[0], T1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[47] + X[46] * sFS2;
    lanes_put(&tau[1], T2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[49] + X[48] * sFS3;
    lanes_put(&tau[2], T3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[51] + X[50] * sFS4;
    lanes_put(&tau[3], T4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[53] + X[52] * sFS5;
    lanes_put(&tau[4], T5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[55] + X[54] * sFS6;
    lanes_put(&tau[5], T6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    const lanes T7 = qd[6] * X[57] + X[56] * sFS7;
    lanes_put(&tau[6], T7, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *qd, const lanes *X, apart *tau)
{
    return panel(qd, X, tau, 0);
}

int twin_friction_rows(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 58u, lanes_X);
    lanes lanes_tau[BLOCKS(7u)];
    double scratch[7u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_qd, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 7u, count, stream, scratch, &tau[k * 7u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 58u, lanes_X);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 7u];
        status |= stream ? panel(lanes_qd, lanes_X, lanes_tau, 1) : plain(lanes_qd, lanes_X, lanes_tau);
    }
    return status;
}

int twin_friction_panels(int stream, size_t N, const size_t *strides,
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

int twin_friction_rows(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_friction(&qd[k * stride_qd], &X[k * stride_X], &tau[k * 7u]);
    }
    return status;
}

int twin_friction_panels(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    return twin_friction_rows(stream, N, strides, qd, X, tau);
}

#endif

size_t twin_friction_width(void)
{
    return twin_WIDTH;
}

void twin_friction_batch(size_t N, const double *qd, const double *X, double *tau)
{
    (void)twin_friction_rows(0, N, NULL, qd, X, tau);
}
