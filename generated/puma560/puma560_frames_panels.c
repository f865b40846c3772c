/* puma560: frames of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, apart *T_out, const int stream)
{
    (void)stream;
    lanes_put(&T_out[10], lanes_all(1.0), stream);
    lanes_put(&T_out[15], lanes_all(1.0), stream);
    lanes_put(&T_out[31], lanes_all(1.0), stream);
    lanes_put(&T_out[47], lanes_all(1.0), stream);
    lanes_put(&T_out[63], lanes_all(1.0), stream);
    lanes_put(&T_out[79], lanes_all(1.0), stream);
    lanes_put(&T_out[95], lanes_all(1.0), stream);
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
    lanes_put(&T_out[0], C1, stream);
    lanes_put(&T_out[5], C1, stream);
    lanes_put(&T_out[22], C1, stream);
    lanes_put(&T_out[38], C1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&T_out[1], -S1, stream);
    lanes_put(&T_out[4], S1, stream);
    lanes_put(&T_out[18], -S1, stream);
    lanes_put(&T_out[34], -S1, stream);
    const lanes C2 = q_1.c;
    lanes_put(&T_out[25], -C2, stream);
    const lanes S2 = q_1.s;
    lanes_put(&T_out[24], -S2, stream);
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
    const lanes C6 = q_5.c;
    const lanes S6 = q_5.s;
    const lanes R1e2_1 = C1 * C2;
    lanes_put(&T_out[16], R1e2_1, stream);
    const lanes R1e2_2 = S1 * C2;
    lanes_put(&T_out[20], R1e2_2, stream);
    const lanes R2e2_1 = -C1 * S2;
    lanes_put(&T_out[17], R2e2_1, stream);
    const lanes R2e2_2 = -S1 * S2;
    lanes_put(&T_out[21], R2e2_2, stream);
    const lanes pr2_1 = -puma560_geometry_R2 * S1;
    lanes_put(&T_out[19], pr2_1, stream);
    const lanes pr2_2 = puma560_geometry_R2 * C1;
    lanes_put(&T_out[23], pr2_2, stream);
    const lanes pd3_1 = puma560_geometry_D3 * R1e2_1 + pr2_1;
    const lanes pd3_2 = puma560_geometry_D3 * R1e2_2 + pr2_2;
    const lanes pd3_3 = -puma560_geometry_D3 * S2;
    lanes_put(&T_out[43], pd3_3, stream);
    const lanes R1e3_1 = C3 * R1e2_1 + S3 * R2e2_1;
    lanes_put(&T_out[32], R1e3_1, stream);
    const lanes R1e3_2 = C3 * R1e2_2 + S3 * R2e2_2;
    lanes_put(&T_out[36], R1e3_2, stream);
    const lanes R1e3_3 = -C2 * S3 - S2 * C3;
    lanes_put(&T_out[40], R1e3_3, stream);
    const lanes R2e3_1 = C3 * R2e2_1 - S3 * R1e2_1;
    lanes_put(&T_out[33], R2e3_1, stream);
    lanes_put(&T_out[50], -R2e3_1, stream);
    const lanes R2e3_2 = C3 * R2e2_2 - S3 * R1e2_2;
    lanes_put(&T_out[37], R2e3_2, stream);
    lanes_put(&T_out[54], -R2e3_2, stream);
    const lanes R2e3_3 = S2 * S3 - C2 * C3;
    lanes_put(&T_out[41], R2e3_3, stream);
    lanes_put(&T_out[58], -R2e3_3, stream);
    const lanes pr3_1 = pd3_1 - puma560_geometry_R3 * S1;
    lanes_put(&T_out[35], pr3_1, stream);
    const lanes pr3_2 = puma560_geometry_R3 * C1 + pd3_2;
    lanes_put(&T_out[39], pr3_2, stream);
    const lanes pd4_1 = puma560_geometry_D4 * R1e3_1 + pr3_1;
    const lanes pd4_2 = puma560_geometry_D4 * R1e3_2 + pr3_2;
    const lanes pd4_3 = puma560_geometry_D4 * R1e3_3 + pd3_3;
    const lanes R1e4_1 = C4 * R1e3_1 - S1 * S4;
    lanes_put(&T_out[48], R1e4_1, stream);
    const lanes R1e4_2 = C1 * S4 + C4 * R1e3_2;
    lanes_put(&T_out[52], R1e4_2, stream);
    const lanes R1e4_3 = C4 * R1e3_3;
    lanes_put(&T_out[56], R1e4_3, stream);
    const lanes R2e4_1 = -S1 * C4 - S4 * R1e3_1;
    lanes_put(&T_out[49], R2e4_1, stream);
    lanes_put(&T_out[66], R2e4_1, stream);
    const lanes R2e4_2 = C1 * C4 - S4 * R1e3_2;
    lanes_put(&T_out[53], R2e4_2, stream);
    lanes_put(&T_out[70], R2e4_2, stream);
    const lanes R2e4_3 = -S4 * R1e3_3;
    lanes_put(&T_out[57], R2e4_3, stream);
    lanes_put(&T_out[74], R2e4_3, stream);
    const lanes pr4_1 = pd4_1 - puma560_geometry_R4 * R2e3_1;
    lanes_put(&T_out[51], pr4_1, stream);
    lanes_put(&T_out[67], pr4_1, stream);
    lanes_put(&T_out[83], pr4_1, stream);
    const lanes pr4_2 = pd4_2 - puma560_geometry_R4 * R2e3_2;
    lanes_put(&T_out[55], pr4_2, stream);
    lanes_put(&T_out[71], pr4_2, stream);
    lanes_put(&T_out[87], pr4_2, stream);
    const lanes pr4_3 = pd4_3 - puma560_geometry_R4 * R2e3_3;
    lanes_put(&T_out[59], pr4_3, stream);
    lanes_put(&T_out[75], pr4_3, stream);
    lanes_put(&T_out[91], pr4_3, stream);
    const lanes R1e5_1 = C5 * R1e4_1 + S5 * R2e3_1;
    lanes_put(&T_out[64], R1e5_1, stream);
    const lanes R1e5_2 = C5 * R1e4_2 + S5 * R2e3_2;
    lanes_put(&T_out[68], R1e5_2, stream);
    const lanes R1e5_3 = C5 * R1e4_3 + S5 * R2e3_3;
    lanes_put(&T_out[72], R1e5_3, stream);
    const lanes R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
    lanes_put(&T_out[65], R2e5_1, stream);
    lanes_put(&T_out[82], -R2e5_1, stream);
    const lanes R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
    lanes_put(&T_out[69], R2e5_2, stream);
    lanes_put(&T_out[86], -R2e5_2, stream);
    const lanes R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
    lanes_put(&T_out[73], R2e5_3, stream);
    lanes_put(&T_out[90], -R2e5_3, stream);
    const lanes R1e6_1 = C6 * R1e5_1 + S6 * R2e4_1;
    lanes_put(&T_out[80], R1e6_1, stream);
    const lanes R1e6_2 = C6 * R1e5_2 + S6 * R2e4_2;
    lanes_put(&T_out[84], R1e6_2, stream);
    const lanes R1e6_3 = C6 * R1e5_3 + S6 * R2e4_3;
    lanes_put(&T_out[88], R1e6_3, stream);
    const lanes R2e6_1 = C6 * R2e4_1 - S6 * R1e5_1;
    lanes_put(&T_out[81], R2e6_1, stream);
    const lanes R2e6_2 = C6 * R2e4_2 - S6 * R1e5_2;
    lanes_put(&T_out[85], R2e6_2, stream);
    const lanes R2e6_3 = C6 * R2e4_3 - S6 * R1e5_3;
    lanes_put(&T_out[89], R2e6_3, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, apart *T_out)
{
    return panel(q, T_out, 0);
}

int puma560_frames_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes lanes_T_out[BLOCKS(96u)];
    double scratch[96u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_T_out, 0, sizeof lanes_T_out);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        status |= plain(lanes_q, (apart *)lanes_T_out);
        lanes_store(lanes_T_out, 96u, count, stream, scratch, &T_out[k * 96u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, double *T_out)
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
        apart *lanes_T_out = (apart *)&T_out[k * 96u];
        status |= stream ? panel(lanes_q, lanes_T_out, 1) : plain(lanes_q, lanes_T_out);
    }
    return status;
}

int puma560_frames_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    if (!(streamed(stream, T_out))) {
        return panels(0, N, strides, q, T_out);
    }
    const int status = panels(1, N, strides, q, T_out);
    stream_end();
    return status;
}

#else

int puma560_frames_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_frames(&q[k * stride_q], &T_out[k * 96u]);
    }
    return status;
}

int puma560_frames_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out)
{
    return puma560_frames_rows(stream, N, strides, q, T_out);
}

#endif

size_t puma560_frames_width(void)
{
    return puma560_WIDTH;
}

void puma560_frames_batch(size_t N, const double *q, double *T_out)
{
    (void)puma560_frames_rows(0, N, NULL, q, T_out);
}
