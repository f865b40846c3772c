/* panda: jacobian of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, apart *J_out, const int stream)
{
    (void)stream;
    const double r1 = 0.333;
    lanes_put(&J_out[35], lanes_all(1.0), stream);
    turned q_0 = lanes_turn(q[0]);
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_5 = lanes_turn(q[5]);
    if (lanes_any(~(mask)(lanes_abs(q[0]) + lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[5]) <= NEAR))) {
        q_0 = lanes_far(q[0], q_0);
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_5 = lanes_far(q[5], q_5);
    }
    const lanes C1 = q_0.c;
    lanes_put(&J_out[29], C1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&J_out[22], -S1, stream);
    const lanes C2 = q_1.c;
    lanes_put(&J_out[37], C2, stream);
    const lanes S2 = q_1.s;
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
    const lanes C6 = q_5.c;
    const lanes S6 = q_5.s;
    const lanes R1e2_1 = C1 * C2;
    const lanes R1e2_2 = S1 * C2;
    const lanes R2e2_1 = -C1 * S2;
    lanes_put(&J_out[23], -R2e2_1, stream);
    const lanes R2e2_2 = -S1 * S2;
    lanes_put(&J_out[30], -R2e2_2, stream);
    const lanes R1e3_1 = C3 * R1e2_1 - S1 * S3;
    const lanes R2e3_1 = -S1 * C3 - S3 * R1e2_1;
    lanes_put(&J_out[24], -R2e3_1, stream);
    const lanes R1e3_2 = C1 * S3 + C3 * R1e2_2;
    const lanes R2e3_2 = C1 * C3 - S3 * R1e2_2;
    lanes_put(&J_out[31], -R2e3_2, stream);
    const lanes R1e3_3 = -S2 * C3;
    const lanes R2e3_3 = S2 * S3;
    lanes_put(&J_out[38], -R2e3_3, stream);
    const lanes pr3_1 = -panda_geometry_R3 * R2e2_1;
    const lanes pr3_2 = -panda_geometry_R3 * R2e2_2;
    const lanes pr3_3 = r1 + panda_geometry_R3 * C2;
    const lanes pd4_1 = panda_geometry_D4 * R1e3_1 + pr3_1;
    const lanes pd4_2 = panda_geometry_D4 * R1e3_2 + pr3_2;
    const lanes pd4_3 = panda_geometry_D4 * R1e3_3 + pr3_3;
    const lanes R1e4_1 = C4 * R1e3_1 - S4 * R2e2_1;
    const lanes R2e4_1 = -C4 * R2e2_1 - S4 * R1e3_1;
    lanes_put(&J_out[25], R2e4_1, stream);
    const lanes R1e4_2 = C4 * R1e3_2 - S4 * R2e2_2;
    const lanes R2e4_2 = -C4 * R2e2_2 - S4 * R1e3_2;
    lanes_put(&J_out[32], R2e4_2, stream);
    const lanes R1e4_3 = C2 * S4 + C4 * R1e3_3;
    const lanes R2e4_3 = C2 * C4 - S4 * R1e3_3;
    lanes_put(&J_out[39], R2e4_3, stream);
    const lanes pd5_1 = pd4_1 - panda_geometry_D4 * R1e4_1;
    const lanes pr5_1 = panda_geometry_R5 * R2e4_1 + pd5_1;
    const lanes pd5_2 = pd4_2 - panda_geometry_D4 * R1e4_2;
    const lanes pr5_2 = panda_geometry_R5 * R2e4_2 + pd5_2;
    const lanes pd5_3 = pd4_3 - panda_geometry_D4 * R1e4_3;
    const lanes pr5_3 = panda_geometry_R5 * R2e4_3 + pd5_3;
    const lanes R1e5_1 = C5 * R1e4_1 + S5 * R2e3_1;
    const lanes R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
    lanes_put(&J_out[26], -R2e5_1, stream);
    const lanes R2e6_1 = C6 * R2e4_1 - S6 * R1e5_1;
    lanes_put(&J_out[27], -R2e6_1, stream);
    const lanes R1e6_1 = C6 * R1e5_1 + S6 * R2e4_1;
    const lanes pd7_1 = panda_geometry_D7 * R1e6_1 + pr5_1;
    lanes_put(&J_out[7], pd7_1, stream);
    const lanes a3_1 = pd7_1 - pr3_1;
    const lanes a4_1 = pd7_1 - pd4_1;
    const lanes a5_1 = pd7_1 - pr5_1;
    const lanes R1e5_2 = C5 * R1e4_2 + S5 * R2e3_2;
    const lanes R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
    lanes_put(&J_out[33], -R2e5_2, stream);
    const lanes R2e6_2 = C6 * R2e4_2 - S6 * R1e5_2;
    lanes_put(&J_out[34], -R2e6_2, stream);
    const lanes R1e6_2 = C6 * R1e5_2 + S6 * R2e4_2;
    const lanes pd7_2 = panda_geometry_D7 * R1e6_2 + pr5_2;
    lanes_put(&J_out[0], -pd7_2, stream);
    const lanes v2_3 = -C1 * pd7_1 - S1 * pd7_2;
    lanes_put(&J_out[15], v2_3, stream);
    const lanes a3_2 = pd7_2 - pr3_2;
    const lanes v3_3 = R2e2_2 * a3_1 - R2e2_1 * a3_2;
    lanes_put(&J_out[16], v3_3, stream);
    const lanes a4_2 = pd7_2 - pd4_2;
    const lanes v4_3 = R2e3_2 * a4_1 - R2e3_1 * a4_2;
    lanes_put(&J_out[17], v4_3, stream);
    const lanes a5_2 = pd7_2 - pr5_2;
    const lanes v5_3 = R2e4_1 * a5_2 - R2e4_2 * a5_1;
    lanes_put(&J_out[18], v5_3, stream);
    const lanes v6_3 = R2e5_2 * a5_1 - R2e5_1 * a5_2;
    lanes_put(&J_out[19], v6_3, stream);
    const lanes R1e5_3 = C5 * R1e4_3 + S5 * R2e3_3;
    const lanes R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
    lanes_put(&J_out[40], -R2e5_3, stream);
    const lanes R2e6_3 = C6 * R2e4_3 - S6 * R1e5_3;
    lanes_put(&J_out[41], -R2e6_3, stream);
    const lanes R1e6_3 = C6 * R1e5_3 + S6 * R2e4_3;
    const lanes pd7_3 = panda_geometry_D7 * R1e6_3 + pr5_3;
    const lanes a3_3 = pd7_3 - pr3_3;
    const lanes v3_1 = -C2 * a3_2 - R2e2_2 * a3_3;
    lanes_put(&J_out[2], v3_1, stream);
    const lanes v3_2 = C2 * a3_1 + R2e2_1 * a3_3;
    lanes_put(&J_out[9], v3_2, stream);
    const lanes a4_3 = pd7_3 - pd4_3;
    const lanes v4_1 = R2e3_3 * a4_2 - R2e3_2 * a4_3;
    lanes_put(&J_out[3], v4_1, stream);
    const lanes v4_2 = R2e3_1 * a4_3 - R2e3_3 * a4_1;
    lanes_put(&J_out[10], v4_2, stream);
    const lanes a5_3 = pd7_3 - pr5_3;
    const lanes a1_3 = pd7_3 - r1;
    const lanes v2_1 = C1 * a1_3;
    lanes_put(&J_out[1], v2_1, stream);
    const lanes v2_2 = S1 * a1_3;
    lanes_put(&J_out[8], v2_2, stream);
    const lanes v5_1 = R2e4_2 * a5_3 - R2e4_3 * a5_2;
    lanes_put(&J_out[4], v5_1, stream);
    const lanes v5_2 = R2e4_3 * a5_1 - R2e4_1 * a5_3;
    lanes_put(&J_out[11], v5_2, stream);
    const lanes v6_1 = R2e5_3 * a5_2 - R2e5_2 * a5_3;
    lanes_put(&J_out[5], v6_1, stream);
    const lanes v6_2 = R2e5_1 * a5_3 - R2e5_3 * a5_1;
    lanes_put(&J_out[12], v6_2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, apart *J_out)
{
    return panel(q, J_out, 0);
}

int panda_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes lanes_J_out[BLOCKS(42u)];
    double scratch[42u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_J_out, 0, sizeof lanes_J_out);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        const size_t count = (N - k < panda_WIDTH) ? (N - k) : panda_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        status |= plain(lanes_q, (apart *)lanes_J_out);
        lanes_store(lanes_J_out, 42u, count, stream, scratch, &J_out[k * 42u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        apart *lanes_J_out = (apart *)&J_out[k * 42u];
        status |= stream ? panel(lanes_q, lanes_J_out, 1) : plain(lanes_q, lanes_J_out);
    }
    return status;
}

int panda_jacobian_panels(int stream, size_t N, const size_t *strides,
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

int panda_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        panda_jacobian(&q[k * stride_q], &J_out[k * 42u]);
    }
    return status;
}

int panda_jacobian_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out)
{
    return panda_jacobian_rows(stream, N, strides, q, J_out);
}

#endif

size_t panda_jacobian_width(void)
{
    return panda_WIDTH;
}

void panda_jacobian_batch(size_t N, const double *q, double *J_out)
{
    (void)panda_jacobian_rows(0, N, NULL, q, J_out);
}
