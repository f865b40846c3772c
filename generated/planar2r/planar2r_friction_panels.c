/* planar2r: friction of as many samples at once as a vector register holds. */
#include "planar2r_panels.h"
#include "planar2r_lanes.h"

#if planar2r_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *qd, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    (void)tau;
    (void)qd;
    (void)X;
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *qd, const lanes *X, apart *tau)
{
    return panel(qd, X, tau, 0);
}

int planar2r_friction_rows(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(X, 4u, lanes_X);
    lanes lanes_tau[BLOCKS(2u)];
    double scratch[2u * planar2r_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        const size_t count = (N - k < planar2r_WIDTH) ? (N - k) : planar2r_WIDTH;
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_qd, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 2u, count, stream, scratch, &tau[k * 2u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_qd[REACH(2u)];
    lanes lanes_qd[BLOCKS(2u)];
    double padded_X[REACH(4u)];
    lanes lanes_X[BLOCKS(4u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(qd, 2u, lanes_qd);
    lanes_shared(X, 4u, lanes_X);
    for (size_t k = 0; k < N; k += planar2r_WIDTH) {
        if (stride_qd != 0u) {
            lanes_read(qd, 2u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 4u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 2u];
        status |= stream ? panel(lanes_qd, lanes_X, lanes_tau, 1) : plain(lanes_qd, lanes_X, lanes_tau);
    }
    return status;
}

int planar2r_friction_panels(int stream, size_t N, const size_t *strides,
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

int planar2r_friction_rows(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_qd = (strides != NULL) ? strides[0] : 2u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        planar2r_friction(&qd[k * stride_qd], &X[k * stride_X], &tau[k * 2u]);
    }
    return status;
}

int planar2r_friction_panels(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau)
{
    return planar2r_friction_rows(stream, N, strides, qd, X, tau);
}

#endif

size_t planar2r_friction_width(void)
{
    return planar2r_WIDTH;
}

void planar2r_friction_batch(size_t N, const double *qd, const double *X, double *tau)
{
    (void)planar2r_friction_rows(0, N, NULL, qd, X, tau);
}
