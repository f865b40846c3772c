/* twin: mass_matrix of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *X, apart *M, const int stream)
{
    (void)stream;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_6 = lanes_turn(q[6]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[6]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_6 = lanes_far(q[6], q_6);
    }
    const lanes M4_4 = X[20] + X[23];
    lanes_put(&M[24], M4_4, stream);
    const lanes M6_6 = X[34] + X[35];
    lanes_put(&M[40], M6_6, stream);
    const lanes M7_7 = X[40] + X[43];
    lanes_put(&M[48], M7_7, stream);
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
    const lanes Nbm62e5 = X[32] * S5;
    lanes_put(&M[5], Nbm62e5, stream);
    lanes_put(&M[35], Nbm62e5, stream);
    const lanes R6 = q[5] + d3;
    const lanes C7 = q_6.c;
    const lanes S7 = q_6.s;
    const lanes Te7_7 = 2.0 * X[37];
    const lanes ze7_7 = X[36] * S7 + C7 * Te7_7;
    const lanes J11e7_7 = X[36] - S7 * ze7_7;
    const lanes J22e7_7 = S7 * ze7_7;
    const lanes J12e7_7 = C7 * ze7_7 - X[37];
    const lanes J13e7_7 = X[38] * C7 - X[39] * S7;
    const lanes J23e7_7 = X[38] * S7 + X[39] * C7;
    const lanes Nbm72e5 = C5 * J23e7_7 + S5 * J13e7_7;
    lanes_put(&M[6], Nbm72e5, stream);
    lanes_put(&M[42], Nbm72e5, stream);
    const lanes J23r6_6 = -X[32] * R6 - J23e7_7;
    const lanes J13s5_6 = X[26] + J13e7_7;
    const lanes J23s5_6 = X[27] - J23r6_6;
    const lanes J23e5_5 = C5 * J23s5_6 + S5 * J13s5_6;
    lanes_put(&M[4], J23e5_5, stream);
    lanes_put(&M[28], J23e5_5, stream);
    const lanes m7_1e7 = X[41] * C7 - X[42] * S7;
    lanes_put(&M[41], -m7_1e7, stream);
    lanes_put(&M[47], -m7_1e7, stream);
    const lanes m7_2e7 = X[41] * S7 + X[42] * C7;
    const lanes m1s6_7 = X[31] + m7_1e7;
    lanes_put(&M[33], -m1s6_7, stream);
    lanes_put(&M[39], -m1s6_7, stream);
    const lanes J13r6_6 = -R6 * m1s6_7 - J12e7_7;
    const lanes J12s5_6 = X[25] - J13r6_6;
    const lanes m1s5_6 = X[29] + m1s6_7;
    const lanes Te5_5 = 2.0 * J12s5_6;
    const lanes Nbm72r6 = X[40] - R6 * m7_2e7;
    lanes_put(&M[34], Nbm72r6, stream);
    lanes_put(&M[46], Nbm72r6, stream);
    const lanes m3s6_7 = X[33] - m7_2e7;
    const lanes wr6_6 = X[34] * R6;
    const lanes xr6_6 = R6 * (2.0 * m3s6_7 + wr6_6);
    const lanes J11r6_6 = J11e7_7 + xr6_6;
    const lanes J22r6_6 = X[40] + xr6_6;
    const lanes m3r6_6 = m3s6_7 + wr6_6;
    const lanes J11s5_6 = X[24] + J11r6_6;
    const lanes J33s5_6 = X[28] + J22r6_6;
    lanes_put(&M[32], J33s5_6, stream);
    const lanes m2s5_6 = X[30] - m3r6_6;
    const lanes De5_5 = J11s5_6 - J22e7_7;
    const lanes ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const lanes J22e5_5 = S5 * ze5_5 + J22e7_7;
    const lanes m5_1e5 = C5 * m1s5_6 - S5 * m2s5_6;
    const lanes wd5_5 = X[34] * d2;
    const lanes xd5_5 = d2 * (2.0 * m5_1e5 + wd5_5);
    const lanes J22d5_5 = J22e5_5 + xd5_5;
    const lanes J33s1_5 = X[0] + J22d5_5;
    const lanes J13r4_4 = X[18] - X[21] * r4;
    const lanes J23r4_4 = X[19] - X[22] * r4;
    const lanes Te4_4 = 2.0 * X[17];
    const lanes ze4_4 = X[16] * S4 + C4 * Te4_4;
    const lanes J11e4_4 = X[16] - S4 * ze4_4;
    const lanes J11s3_4 = X[8] + J11e4_4;
    const lanes J22e4_4 = S4 * ze4_4;
    const lanes J12e4_4 = C4 * ze4_4 - X[17];
    const lanes J13s3_4 = X[10] + J12e4_4;
    const lanes J33s3_4 = X[12] + J22e4_4;
    const lanes M3_3 = X[15] + J33s3_4;
    lanes_put(&M[16], M3_3, stream);
    const lanes J13e4_4 = C4 * J13r4_4 - S4 * J23r4_4;
    const lanes J23e4_4 = C4 * J23r4_4 + S4 * J13r4_4;
    lanes_put(&M[17], J23e4_4, stream);
    lanes_put(&M[23], J23e4_4, stream);
    const lanes m4_1e4 = X[21] * C4 - X[22] * S4;
    const lanes m4_2e4 = X[21] * S4 + X[22] * C4;
    const lanes J12s3_4 = X[9] - J13e4_4;
    const lanes J23s3_4 = X[11] - J23e4_4;
    const lanes m1s3_4 = X[13] + m4_1e4;
    const lanes De3_3 = J11s3_4 - X[20];
    const lanes Te3_3 = 2.0 * J12s3_4;
    const lanes ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const lanes J11e3_3 = J11s3_4 - S3 * ze3_3;
    const lanes J12e3_3 = C3 * ze3_3 - J12s3_4;
    const lanes J22e3_3 = X[20] + S3 * ze3_3;
    const lanes J11s2_3 = X[1] + J11e3_3;
    const lanes J13e3_3 = C3 * J13s3_4 - S3 * J23s3_4;
    const lanes J23e3_3 = C3 * J23s3_4 + S3 * J13s3_4;
    const lanes Nbm32e2 = C2 * J23e3_3 + S2 * J13e3_3;
    lanes_put(&M[2], Nbm32e2, stream);
    lanes_put(&M[14], Nbm32e2, stream);
    const lanes J13d3_3 = J13e3_3 - d3 * m4_2e4;
    const lanes J13s2_3 = X[3] + J13d3_3;
    const lanes J23s2_3 = X[4] + J23e3_3;
    const lanes J23e2_2 = C2 * J23s2_3 + S2 * J13s2_3;
    lanes_put(&M[1], J23e2_2, stream);
    lanes_put(&M[7], J23e2_2, stream);
    const lanes Fbm42e3 = -S3 * m4_2e4;
    const lanes Nbm43d3 = d3 * Fbm42e3 + J23e4_4;
    lanes_put(&M[10], Nbm43d3, stream);
    lanes_put(&M[22], Nbm43d3, stream);
    const lanes m3_1e3 = C3 * m1s3_4 - X[14] * S3;
    const lanes m3_2e3 = X[14] * C3 + S3 * m1s3_4;
    const lanes J12d3_3 = J12e3_3 - d3 * m3_2e3;
    const lanes J12s2_3 = X[2] + J12d3_3;
    const lanes m2s2_3 = X[7] + m3_2e3;
    const lanes Te2_2 = 2.0 * J12s2_3;
    const lanes Nbm33d3 = d3 * m3_1e3 + J33s3_4;
    lanes_put(&M[9], Nbm33d3, stream);
    lanes_put(&M[15], Nbm33d3, stream);
    const lanes xd3_3 = 2.0 * d3 * m3_1e3;
    const lanes J22d3_3 = J22e3_3 + xd3_3;
    const lanes J33d3_3 = J33s3_4 + xd3_3;
    const lanes J33s2_3 = X[5] + J33d3_3;
    lanes_put(&M[8], J33s2_3, stream);
    const lanes m1s2_3 = X[6] + m3_1e3;
    const lanes De2_2 = J11s2_3 - J22d3_3;
    const lanes ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const lanes J22e2_2 = S2 * ze2_2 + J22d3_3;
    const lanes m2_1e2 = C2 * m1s2_3 - S2 * m2s2_3;
    const lanes xd2_2 = 2.0 * d2 * m2_1e2;
    const lanes J22d2_2 = J22e2_2 + xd2_2;
    const lanes J33s1_2 = J33s1_5 + J22d2_2;
    lanes_put(&M[0], J33s1_2, stream);
    const lanes Nbm41e3 = X[20] * S3 + C3 * J13e4_4;
    const lanes Nbm42e3 = S3 * J13e4_4 - X[20] * C3;
    const lanes Nbm42d3 = Nbm42e3 - d3 * m4_1e4;
    const lanes Nbm42e2 = C2 * Nbm42d3 + S2 * Nbm41e3;
    const lanes Nbm42d2 = Nbm42e2 - d2 * m4_1e4;
    lanes_put(&M[3], Nbm42d2, stream);
    lanes_put(&M[21], Nbm42d2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *X, apart *M)
{
    return panel(q, X, M, 0);
}

int twin_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_X[REACH(44u)];
    lanes lanes_X[BLOCKS(44u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(X, 44u, lanes_X);
    lanes lanes_M[BLOCKS(49u)];
    double scratch[49u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_M, 0, sizeof lanes_M);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_load(X, 44u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_X, (apart *)lanes_M);
        lanes_store(lanes_M, 49u, count, stream, scratch, &M[k * 49u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_X[REACH(44u)];
    lanes lanes_X[BLOCKS(44u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(X, 44u, lanes_X);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_load(X, 44u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_M = (apart *)&M[k * 49u];
        status |= stream ? panel(lanes_q, lanes_X, lanes_M, 1) : plain(lanes_q, lanes_X, lanes_M);
    }
    return status;
}

int twin_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    if (!(streamed(stream, M))) {
        return panels(0, N, strides, q, X, M);
    }
    const int status = panels(1, N, strides, q, X, M);
    stream_end();
    return status;
}

#else

int twin_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_mass_matrix(&q[k * stride_q], &X[k * stride_X], &M[k * 49u]);
    }
    return status;
}

int twin_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    return twin_mass_matrix_rows(stream, N, strides, q, X, M);
}

#endif

size_t twin_mass_matrix_width(void)
{
    return twin_WIDTH;
}

void twin_mass_matrix_batch(size_t N, const double *q, const double *X, double *M)
{
    (void)twin_mass_matrix_rows(0, N, NULL, q, X, M);
}
