/* puma560: friction_power of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, apart *out, const int stream)
{
    (void)stream;
    (void)q;
    const lanes DFS1 = lanes_abs(qd[0]);
    lanes_put(&out[0], DFS1, stream);
    const lanes DFV1 = qd[0] * qd[0];
    lanes_put(&out[1], DFV1, stream);
    const lanes DFS2 = lanes_abs(qd[1]);
    lanes_put(&out[2], DFS2, stream);
    const lanes DFV2 = qd[1] * qd[1];
    lanes_put(&out[3], DFV2, stream);
    const lanes DFS3 = lanes_abs(qd[2]);
    lanes_put(&out[4], DFS3, stream);
    const lanes DFV3 = qd[2] * qd[2];
    lanes_put(&out[5], DFV3, stream);
    const lanes DFS4 = lanes_abs(qd[3]);
    lanes_put(&out[6], DFS4, stream);
    const lanes DFV4 = qd[3] * qd[3];
    lanes_put(&out[7], DFV4, stream);
    const lanes DFS5 = lanes_abs(qd[4]);
    lanes_put(&out[8], DFS5, stream);
    const lanes DFV5 = qd[4] * qd[4];
    lanes_put(&out[9], DFV5, stream);
    const lanes DFS6 = lanes_abs(qd[5]);
    lanes_put(&out[10], DFS6, stream);
    const lanes DFV6 = qd[5] * qd[5];
    lanes_put(&out[11], DFV6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, apart *out)
{
    return panel(q, qd, out, 0);
}

int puma560_friction_power_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes lanes_out[BLOCKS(12u)];
    double scratch[12u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        status |= plain(lanes_q, lanes_qd, (apart *)lanes_out);
        lanes_store(lanes_out, 12u, count, stream, scratch, &out[k * 12u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        apart *lanes_out = (apart *)&out[k * 12u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_out);
    }
    return status;
}

int puma560_friction_power_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    if (!(streamed(stream, out))) {
        return panels(0, N, strides, q, qd, out);
    }
    const int status = panels(1, N, strides, q, qd, out);
    stream_end();
    return status;
}

#else

int puma560_friction_power_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_friction_power(&q[k * stride_q], &qd[k * stride_qd], &out[k * 12u]);
    }
    return status;
}

int puma560_friction_power_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out)
{
    return puma560_friction_power_rows(stream, N, strides, q, qd, out);
}

#endif

size_t puma560_friction_power_width(void)
{
    return puma560_WIDTH;
}

void puma560_friction_power_batch(size_t N, const double *q, const double *qd, double *out)
{
    (void)puma560_friction_power_rows(0, N, NULL, q, qd, out);
}
