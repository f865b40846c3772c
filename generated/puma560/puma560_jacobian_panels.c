/* puma560: jacobian of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, apart *J_out, const int stream)
{
    (void)stream;
    lanes_put(&J_out[30], lanes_all(1.0), stream);
    turned q_0 = lanes_turn(q[0]);
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    if (lanes_any(~(mask)(lanes_abs(q[0]) + lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) <= NEAR))) {
        q_0 = lanes_far(q[0], q_0);
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
    }
    const lanes C1 = q_0.c;
    lanes_put(&J_out[25], C1, stream);
    lanes_put(&J_out[26], C1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&J_out[19], -S1, stream);
    lanes_put(&J_out[20], -S1, stream);
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
    const lanes R1e2_1 = C1 * C2;
    const lanes R1e2_2 = S1 * C2;
    const lanes R2e2_1 = -C1 * S2;
    const lanes R2e2_2 = -S1 * S2;
    const lanes pr2_1 = -puma560_geometry_R2 * S1;
    const lanes pr2_2 = puma560_geometry_R2 * C1;
    const lanes pd3_1 = puma560_geometry_D3 * R1e2_1 + pr2_1;
    const lanes pd3_2 = puma560_geometry_D3 * R1e2_2 + pr2_2;
    const lanes pd3_3 = -puma560_geometry_D3 * S2;
    const lanes R1e3_1 = C3 * R1e2_1 + S3 * R2e2_1;
    const lanes R1e3_2 = C3 * R1e2_2 + S3 * R2e2_2;
    const lanes R1e3_3 = -C2 * S3 - S2 * C3;
    const lanes R2e3_1 = C3 * R2e2_1 - S3 * R1e2_1;
    lanes_put(&J_out[21], -R2e3_1, stream);
    const lanes R2e3_2 = C3 * R2e2_2 - S3 * R1e2_2;
    lanes_put(&J_out[27], -R2e3_2, stream);
    const lanes R2e3_3 = S2 * S3 - C2 * C3;
    lanes_put(&J_out[33], -R2e3_3, stream);
    const lanes pr3_1 = pd3_1 - puma560_geometry_R3 * S1;
    const lanes pr3_2 = puma560_geometry_R3 * C1 + pd3_2;
    const lanes pd4_1 = puma560_geometry_D4 * R1e3_1 + pr3_1;
    const lanes pd4_2 = puma560_geometry_D4 * R1e3_2 + pr3_2;
    const lanes pd4_3 = puma560_geometry_D4 * R1e3_3 + pd3_3;
    const lanes R1e4_1 = C4 * R1e3_1 - S1 * S4;
    const lanes R1e4_2 = C1 * S4 + C4 * R1e3_2;
    const lanes R1e4_3 = C4 * R1e3_3;
    const lanes R2e4_1 = -S1 * C4 - S4 * R1e3_1;
    lanes_put(&J_out[22], R2e4_1, stream);
    const lanes R2e4_2 = C1 * C4 - S4 * R1e3_2;
    lanes_put(&J_out[28], R2e4_2, stream);
    const lanes R2e4_3 = -S4 * R1e3_3;
    lanes_put(&J_out[34], R2e4_3, stream);
    const lanes pr4_1 = pd4_1 - puma560_geometry_R4 * R2e3_1;
    lanes_put(&J_out[6], pr4_1, stream);
    const lanes pr4_2 = pd4_2 - puma560_geometry_R4 * R2e3_2;
    lanes_put(&J_out[0], -pr4_2, stream);
    const lanes pr4_3 = pd4_3 - puma560_geometry_R4 * R2e3_3;
    const lanes R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
    lanes_put(&J_out[23], -R2e5_1, stream);
    const lanes R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
    lanes_put(&J_out[29], -R2e5_2, stream);
    const lanes R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
    lanes_put(&J_out[35], -R2e5_3, stream);
    const lanes a2_1 = pr4_1 - pr2_1;
    const lanes a2_2 = pr4_2 - pr2_2;
    const lanes v2_1 = C1 * pr4_3;
    lanes_put(&J_out[1], v2_1, stream);
    const lanes v2_2 = S1 * pr4_3;
    lanes_put(&J_out[7], v2_2, stream);
    const lanes v2_3 = -C1 * a2_1 - S1 * a2_2;
    lanes_put(&J_out[13], v2_3, stream);
    const lanes a3_1 = pr4_1 - pr3_1;
    const lanes a3_2 = pr4_2 - pr3_2;
    const lanes a3_3 = pr4_3 - pd3_3;
    const lanes v3_1 = C1 * a3_3;
    lanes_put(&J_out[2], v3_1, stream);
    const lanes v3_2 = S1 * a3_3;
    lanes_put(&J_out[8], v3_2, stream);
    const lanes v3_3 = -C1 * a3_1 - S1 * a3_2;
    lanes_put(&J_out[14], v3_3, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, apart *J_out)
{
    return panel(q, J_out, 0);
}

int puma560_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes lanes_J_out[BLOCKS(36u)];
    double scratch[36u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_J_out, 0, sizeof lanes_J_out);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        status |= plain(lanes_q, (apart *)lanes_J_out);
        lanes_store(lanes_J_out, 36u, count, stream, scratch, &J_out[k * 36u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        apart *lanes_J_out = (apart *)&J_out[k * 36u];
        status |= stream ? panel(lanes_q, lanes_J_out, 1) : plain(lanes_q, lanes_J_out);
    }
    return status;
}

int puma560_jacobian_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    if (!(streamed(stream, J_out))) {
        return panels(0, N, strides, q, J_out);
    }
    const int status = panels(1, N, strides, q, J_out);
    stream_end();
    return status;
}

#else

int puma560_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_jacobian(&q[k * stride_q], &J_out[k * 36u]);
    }
    return status;
}

int puma560_jacobian_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    return puma560_jacobian_rows(stream, N, strides, q, J_out);
}

#endif

size_t puma560_jacobian_width(void)
{
    return puma560_WIDTH;
}

void puma560_jacobian_batch(size_t N, const double *q, double *J_out)
{
    (void)puma560_jacobian_rows(0, N, NULL, q, J_out);
}
