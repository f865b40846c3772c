/* twin: mass_matrix_factor of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *X, apart *L_out, apart *D_out, const int stream)
{
    (void)stream;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    lanes_put(&L_out[0], lanes_all(1.0), stream);
    lanes_put(&L_out[8], lanes_all(1.0), stream);
    lanes_put(&L_out[16], lanes_all(1.0), stream);
    lanes_put(&L_out[24], lanes_all(1.0), stream);
    lanes_put(&L_out[32], lanes_all(1.0), stream);
    lanes_put(&L_out[40], lanes_all(1.0), stream);
    lanes_put(&L_out[48], lanes_all(1.0), stream);
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
    const lanes C2 = q_1.c;
    const lanes S2 = q_1.s;
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
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
    const lanes m7_1e7 = X[41] * C7 - X[42] * S7;
    const lanes m7_2e7 = X[41] * S7 + X[42] * C7;
    const lanes m1s6_7 = X[31] + m7_1e7;
    const lanes J13r6_6 = -R6 * m1s6_7 - J12e7_7;
    const lanes J12s5_6 = X[25] - J13r6_6;
    const lanes Te5_5 = 2.0 * J12s5_6;
    const lanes m3s6_7 = X[33] - m7_2e7;
    const lanes Nbm72r6 = X[40] - R6 * m7_2e7;
    const lanes wr6_6 = X[34] * R6;
    const lanes xr6_6 = R6 * (2.0 * m3s6_7 + wr6_6);
    const lanes J11r6_6 = J11e7_7 + xr6_6;
    const lanes J22r6_6 = X[40] + xr6_6;
    const lanes J23r6_6 = -X[32] * R6 - J23e7_7;
    const lanes m3r6_6 = m3s6_7 + wr6_6;
    const lanes J11s5_6 = X[24] + J11r6_6;
    const lanes J23s5_6 = X[27] - J23r6_6;
    const lanes J33s5_6 = X[28] + J22r6_6;
    const lanes m2s5_6 = X[30] - m3r6_6;
    const lanes De5_5 = J11s5_6 - J22e7_7;
    const lanes ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const lanes J22e5_5 = S5 * ze5_5 + J22e7_7;
    const lanes Nbm72e5 = C5 * J23e7_7 + S5 * J13e7_7;
    const lanes J13s5_6 = X[26] + J13e7_7;
    const lanes J23e5_5 = C5 * J23s5_6 + S5 * J13s5_6;
    const lanes m1s5_6 = X[29] + m1s6_7;
    const lanes m5_1e5 = C5 * m1s5_6 - S5 * m2s5_6;
    const lanes Nbm62e5 = X[32] * S5;
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
    const lanes J13e4_4 = C4 * J13r4_4 - S4 * J23r4_4;
    const lanes J23e4_4 = C4 * J23r4_4 + S4 * J13r4_4;
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
    const lanes m3_1e3 = C3 * m1s3_4 - X[14] * S3;
    const lanes m3_2e3 = X[14] * C3 + S3 * m1s3_4;
    const lanes J12d3_3 = J12e3_3 - d3 * m3_2e3;
    const lanes J12s2_3 = X[2] + J12d3_3;
    const lanes m2s2_3 = X[7] + m3_2e3;
    const lanes Te2_2 = 2.0 * J12s2_3;
    const lanes xd3_3 = 2.0 * d3 * m3_1e3;
    const lanes J22d3_3 = J22e3_3 + xd3_3;
    const lanes J33d3_3 = J33s3_4 + xd3_3;
    const lanes J33s2_3 = X[5] + J33d3_3;
    const lanes De2_2 = J11s2_3 - J22d3_3;
    const lanes ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const lanes J22e2_2 = S2 * ze2_2 + J22d3_3;
    const lanes J13d3_3 = J13e3_3 - d3 * m4_2e4;
    const lanes J13s2_3 = X[3] + J13d3_3;
    const lanes Nbm32e2 = C2 * J23e3_3 + S2 * J13e3_3;
    const lanes J23s2_3 = X[4] + J23e3_3;
    const lanes J23e2_2 = C2 * J23s2_3 + S2 * J13s2_3;
    const lanes Fbm42e3 = -S3 * m4_2e4;
    const lanes Nbm43d3 = d3 * Fbm42e3 + J23e4_4;
    const lanes m1s2_3 = X[6] + m3_1e3;
    const lanes m2_1e2 = C2 * m1s2_3 - S2 * m2s2_3;
    const lanes xd2_2 = 2.0 * d2 * m2_1e2;
    const lanes J22d2_2 = J22e2_2 + xd2_2;
    const lanes J33s1_2 = J33s1_5 + J22d2_2;
    const lanes Nbm33d3 = d3 * m3_1e3 + J33s3_4;
    const lanes M3_3 = X[15] + J33s3_4;
    const lanes Nbm41e3 = X[20] * S3 + C3 * J13e4_4;
    const lanes Nbm42e3 = S3 * J13e4_4 - X[20] * C3;
    const lanes Nbm42d3 = Nbm42e3 - d3 * m4_1e4;
    const lanes Nbm42e2 = C2 * Nbm42d3 + S2 * Nbm41e3;
    const lanes Nbm42d2 = Nbm42e2 - d2 * m4_1e4;
    const lanes M4_4 = X[20] + X[23];
    lanes_put(&D_out[3], M4_4, stream);
    const lanes d4 = 1.0 / M4_4;
    const lanes M6_6 = X[34] + X[35];
    const lanes M7_7 = X[40] + X[43];
    lanes_put(&D_out[6], M7_7, stream);
    const lanes d7 = 1.0 / M7_7;
    const lanes l7_1 = Nbm72e5 * d7;
    lanes_put(&L_out[6], l7_1, stream);
    const lanes m7_1_1 = J33s1_2 - Nbm72e5 * l7_1;
    const lanes l7_5 = Nbm72r6 * d7;
    lanes_put(&L_out[34], l7_5, stream);
    const lanes l7_6 = -m7_1e7 * d7;
    lanes_put(&L_out[41], l7_6, stream);
    const lanes m7_5_1 = J23e5_5 - Nbm72e5 * l7_5;
    const lanes m7_5_5 = J33s5_6 - Nbm72r6 * l7_5;
    const lanes m7_6_1 = Nbm62e5 - Nbm72e5 * l7_6;
    const lanes m7_6_5 = -m1s6_7 - Nbm72r6 * l7_6;
    const lanes m7_6_6 = m7_1e7 * l7_6 + M6_6;
    lanes_put(&D_out[5], m7_6_6, stream);
    const lanes d6 = 1.0 / m7_6_6;
    const lanes l6_1 = m7_6_1 * d6;
    lanes_put(&L_out[5], l6_1, stream);
    const lanes l6_5 = m7_6_5 * d6;
    lanes_put(&L_out[33], l6_5, stream);
    const lanes m6_1_1 = m7_1_1 - m7_6_1 * l6_1;
    const lanes m6_5_1 = m7_5_1 - m7_6_1 * l6_5;
    const lanes m6_5_5 = m7_5_5 - m7_6_5 * l6_5;
    lanes_put(&D_out[4], m6_5_5, stream);
    const lanes d5 = 1.0 / m6_5_5;
    const lanes l5_1 = m6_5_1 * d5;
    lanes_put(&L_out[4], l5_1, stream);
    const lanes m5_1_1 = m6_1_1 - m6_5_1 * l5_1;
    const lanes l4_1 = Nbm42d2 * d4;
    lanes_put(&L_out[3], l4_1, stream);
    const lanes m4_1_1 = m5_1_1 - Nbm42d2 * l4_1;
    const lanes l4_2 = Nbm43d3 * d4;
    lanes_put(&L_out[10], l4_2, stream);
    const lanes l4_3 = J23e4_4 * d4;
    lanes_put(&L_out[17], l4_3, stream);
    const lanes m4_2_1 = J23e2_2 - Nbm42d2 * l4_2;
    const lanes m4_2_2 = J33s2_3 - Nbm43d3 * l4_2;
    const lanes m4_3_1 = Nbm32e2 - Nbm42d2 * l4_3;
    const lanes m4_3_2 = Nbm33d3 - Nbm43d3 * l4_3;
    const lanes m4_3_3 = M3_3 - J23e4_4 * l4_3;
    lanes_put(&D_out[2], m4_3_3, stream);
    const lanes d3_ = 1.0 / m4_3_3;
    const lanes l3_1 = m4_3_1 * d3_;
    lanes_put(&L_out[2], l3_1, stream);
    const lanes l3_2 = m4_3_2 * d3_;
    lanes_put(&L_out[9], l3_2, stream);
    const lanes m3_1_1 = m4_1_1 - m4_3_1 * l3_1;
    const lanes m3_2_1 = m4_2_1 - m4_3_1 * l3_2;
    const lanes m3_2_2 = m4_2_2 - m4_3_2 * l3_2;
    lanes_put(&D_out[1], m3_2_2, stream);
    const lanes d2_ = 1.0 / m3_2_2;
    const lanes l2_1 = m3_2_1 * d2_;
    lanes_put(&L_out[1], l2_1, stream);
    const lanes m2_1_1 = m3_1_1 - m3_2_1 * l2_1;
    lanes_put(&D_out[0], m2_1_1, stream);
    const mask singular = (mask)(M7_7 <= 0.0) | (mask)(m7_6_6 <= 0.0) | (mask)(m6_5_5 <= 0.0) | (mask)(M4_4 <= 0.0) | (mask)(m4_3_3 <= 0.0) | (mask)(m3_2_2 <= 0.0) | (mask)(m2_1_1 <= 0.0);
    const mask odd = (~(mask)(M7_7 > 0.0) & ~(mask)(M7_7 <= 0.0)) | (~(mask)(m7_6_6 > 0.0) & ~(mask)(m7_6_6 <= 0.0)) | (~(mask)(m6_5_5 > 0.0) & ~(mask)(m6_5_5 <= 0.0)) | (~(mask)(M4_4 > 0.0) & ~(mask)(M4_4 <= 0.0)) | (~(mask)(m4_3_3 > 0.0) & ~(mask)(m4_3_3 <= 0.0)) | (~(mask)(m3_2_2 > 0.0) & ~(mask)(m3_2_2 <= 0.0)) | (~(mask)(m2_1_1 > 0.0) & ~(mask)(m2_1_1 <= 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l2_1 - l2_1 == 0.0)) | (~(mask)(l3_1 - l3_1 == 0.0)) | (~(mask)(l4_1 - l4_1 == 0.0)) | (~(mask)(l5_1 - l5_1 == 0.0)) | (~(mask)(l6_1 - l6_1 == 0.0)) | (~(mask)(l7_1 - l7_1 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l3_2 - l3_2 == 0.0)) | (~(mask)(l4_2 - l4_2 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l4_3 - l4_3 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l6_5 - l6_5 == 0.0)) | (~(mask)(l7_5 - l7_5 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(l7_6 - l7_6 == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(0.0) - lanes_all(0.0) == 0.0)) | (~(mask)(lanes_all(1.0) - lanes_all(1.0) == 0.0)) | (~(mask)(m2_1_1 - m2_1_1 == 0.0)) | (~(mask)(m3_2_2 - m3_2_2 == 0.0)) | (~(mask)(m4_3_3 - m4_3_3 == 0.0)) | (~(mask)(M4_4 - M4_4 == 0.0)) | (~(mask)(m6_5_5 - m6_5_5 == 0.0)) | (~(mask)(m7_6_6 - m7_6_6 == 0.0)) | (~(mask)(M7_7 - M7_7 == 0.0));
    const int status = (lanes_any(singular) ? (int)twin_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int)twin_NOT_FINITE : 0);
    return status;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *X, apart *L_out, apart *D_out)
{
    return panel(q, X, L_out, D_out, 0);
}

int twin_mass_matrix_factor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
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
    lanes lanes_L_out[BLOCKS(49u)];
    lanes lanes_D_out[BLOCKS(7u)];
    double scratch[49u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_L_out, 0, sizeof lanes_L_out);
    memset(lanes_D_out, 0, sizeof lanes_D_out);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_load(X, 44u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_X, (apart *)lanes_L_out, (apart *)lanes_D_out);
        lanes_store(lanes_L_out, 49u, count, stream, scratch, &L_out[k * 49u]);
        lanes_store(lanes_D_out, 7u, count, stream, scratch, &D_out[k * 7u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *X, double *L_out, double *D_out)
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
        apart *lanes_L_out = (apart *)&L_out[k * 49u];
        apart *lanes_D_out = (apart *)&D_out[k * 7u];
        status |= stream ? panel(lanes_q, lanes_X, lanes_L_out, lanes_D_out, 1) : plain(lanes_q, lanes_X, lanes_L_out, lanes_D_out);
    }
    return status;
}

int twin_mass_matrix_factor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    if (!(streamed(stream, L_out) && streamed(stream, D_out))) {
        return panels(0, N, strides, q, X, L_out, D_out);
    }
    const int status = panels(1, N, strides, q, X, L_out, D_out);
    stream_end();
    return status;
}

#else

int twin_mass_matrix_factor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        status |= twin_mass_matrix_factor(&q[k * stride_q], &X[k * stride_X], &L_out[k * 49u], &D_out[k * 7u]);
    }
    return status;
}

int twin_mass_matrix_factor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out)
{
    return twin_mass_matrix_factor_rows(stream, N, strides, q, X, L_out, D_out);
}

#endif

size_t twin_mass_matrix_factor_width(void)
{
    return twin_WIDTH;
}

int twin_mass_matrix_factor_batch(size_t N, const double *q, const double *X, double *L_out, double *D_out)
{
    return twin_mass_matrix_factor_rows(0, N, NULL, q, X, L_out, D_out);
}
