/* panda: mass_matrix of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *X, apart *M, const int stream)
{
    (void)stream;
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_5 = lanes_turn(q[5]);
    turned q_6 = lanes_turn(q[6]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[5]) + lanes_abs(q[6]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_5 = lanes_far(q[5], q_5);
        q_6 = lanes_far(q[6], q_6);
    }
    const lanes M7_7 = X[44] + X[47];
    lanes_put(&M[48], M7_7, stream);
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
    const lanes C7 = q_6.c;
    const lanes S7 = q_6.s;
    const lanes Te7_7 = 2.0 * X[41];
    const lanes ze7_7 = X[40] * S7 + C7 * Te7_7;
    const lanes J11e7_7 = X[40] - S7 * ze7_7;
    const lanes J11s6_7 = X[32] + J11e7_7;
    const lanes J22e7_7 = S7 * ze7_7;
    const lanes J12e7_7 = C7 * ze7_7 - X[41];
    const lanes J13e7_7 = X[42] * C7 - X[43] * S7;
    const lanes J23e7_7 = X[42] * S7 + X[43] * C7;
    lanes_put(&M[41], J23e7_7, stream);
    lanes_put(&M[47], J23e7_7, stream);
    const lanes m7_1e7 = X[45] * C7 - X[46] * S7;
    const lanes m7_2e7 = X[45] * S7 + X[46] * C7;
    const lanes J12d7_7 = J12e7_7 - panda_geometry_D7 * m7_2e7;
    const lanes J13s6_7 = X[34] + J12d7_7;
    const lanes xd7_7 = 2.0 * panda_geometry_D7 * m7_1e7;
    const lanes J22d7_7 = J22e7_7 + xd7_7;
    const lanes J33d7_7 = X[44] + xd7_7;
    const lanes J33s6_7 = X[36] + J22d7_7;
    const lanes M6_6 = X[39] + J33s6_7;
    lanes_put(&M[40], M6_6, stream);
    const lanes J12s6_7 = X[33] - J13e7_7;
    const lanes J23s6_7 = X[35] - J23e7_7;
    const lanes m1s6_7 = X[37] + m7_1e7;
    const lanes De6_6 = J11s6_7 - J33d7_7;
    const lanes Te6_6 = 2.0 * J12s6_7;
    const lanes ze6_6 = C6 * Te6_6 + S6 * De6_6;
    const lanes J11e6_6 = J11s6_7 - S6 * ze6_6;
    const lanes J22e6_6 = S6 * ze6_6 + J33d7_7;
    const lanes J12e6_6 = C6 * ze6_6 - J12s6_7;
    const lanes J11s5_6 = X[24] + J11e6_6;
    const lanes J13s5_6 = X[26] + J12e6_6;
    const lanes J33s5_6 = X[28] + J22e6_6;
    const lanes M5_5 = X[31] + J33s5_6;
    lanes_put(&M[32], M5_5, stream);
    const lanes J13e6_6 = C6 * J13s6_7 - S6 * J23s6_7;
    const lanes J23e6_6 = C6 * J23s6_7 + S6 * J13s6_7;
    lanes_put(&M[33], J23e6_6, stream);
    lanes_put(&M[39], J23e6_6, stream);
    const lanes m6_1e6 = C6 * m1s6_7 - X[38] * S6;
    const lanes m6_2e6 = X[38] * C6 + S6 * m1s6_7;
    const lanes J12s5_6 = X[25] - J13e6_6;
    const lanes J23s5_6 = X[27] - J23e6_6;
    const lanes m1s5_6 = X[29] + m6_1e6;
    const lanes J13r5_5 = J13s5_6 - panda_geometry_R5 * m1s5_6;
    const lanes m2s5_6 = X[30] - m7_2e7;
    const lanes J23r5_5 = J23s5_6 - panda_geometry_R5 * m2s5_6;
    const lanes xr5_5 = 2.0 * panda_geometry_R5 * m6_2e6;
    const lanes J11r5_5 = J11s5_6 + xr5_5;
    const lanes J22r5_5 = J33s6_7 + xr5_5;
    const lanes Nbm62r5 = -panda_geometry_R5 * m6_2e6 - J33s6_7;
    const lanes De5_5 = J11r5_5 - J22r5_5;
    const lanes Te5_5 = 2.0 * J12s5_6;
    const lanes ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const lanes J11e5_5 = J11r5_5 - S5 * ze5_5;
    const lanes J22e5_5 = S5 * ze5_5 + J22r5_5;
    const lanes J12e5_5 = C5 * ze5_5 - J12s5_6;
    const lanes J11s4_5 = X[16] + J11e5_5;
    const lanes J13e5_5 = C5 * J13r5_5 - S5 * J23r5_5;
    const lanes J23e5_5 = C5 * J23r5_5 + S5 * J13r5_5;
    lanes_put(&M[25], -J23e5_5, stream);
    lanes_put(&M[31], -J23e5_5, stream);
    const lanes m5_1e5 = C5 * m1s5_6 - S5 * m2s5_6;
    const lanes m5_2e5 = C5 * m2s5_6 + S5 * m1s5_6;
    const lanes J12d5_5 = panda_geometry_D4 * m5_2e5 + J12e5_5;
    const lanes J13s4_5 = X[18] - J12d5_5;
    const lanes xd5_5 = -2.0 * panda_geometry_D4 * m5_1e5;
    const lanes J22d5_5 = J22e5_5 + xd5_5;
    const lanes J33d5_5 = J33s5_6 + xd5_5;
    const lanes J33s4_5 = X[20] + J22d5_5;
    const lanes Nbm53d5 = J33s5_6 - panda_geometry_D4 * m5_1e5;
    const lanes M4_4 = X[23] + J33s4_5;
    lanes_put(&M[24], M4_4, stream);
    const lanes J13d5_5 = panda_geometry_D4 * m6_2e6 + J13e5_5;
    const lanes J12s4_5 = X[17] + J13d5_5;
    const lanes J23s4_5 = X[19] - J23e5_5;
    const lanes m1s4_5 = X[21] + m5_1e5;
    const lanes m2s4_5 = X[22] + m6_2e6;
    const lanes De4_4 = J11s4_5 - J33d5_5;
    const lanes Te4_4 = 2.0 * J12s4_5;
    const lanes ze4_4 = C4 * Te4_4 + S4 * De4_4;
    const lanes J11e4_4 = J11s4_5 - S4 * ze4_4;
    const lanes J22e4_4 = S4 * ze4_4 + J33d5_5;
    const lanes J12e4_4 = C4 * ze4_4 - J12s4_5;
    const lanes J11s3_4 = X[8] + J11e4_4;
    const lanes J13e4_4 = C4 * J13s4_5 - S4 * J23s4_5;
    const lanes J23e4_4 = C4 * J23s4_5 + S4 * J13s4_5;
    lanes_put(&M[17], J23e4_4, stream);
    lanes_put(&M[23], J23e4_4, stream);
    const lanes m4_1e4 = C4 * m1s4_5 - S4 * m2s4_5;
    const lanes m4_2e4 = C4 * m2s4_5 + S4 * m1s4_5;
    const lanes J12d4_4 = J12e4_4 - panda_geometry_D4 * m4_2e4;
    const lanes J13s3_4 = X[10] + J12d4_4;
    const lanes xd4_4 = 2.0 * panda_geometry_D4 * m4_1e4;
    const lanes J22d4_4 = J22e4_4 + xd4_4;
    const lanes J33d4_4 = J33s4_5 + xd4_4;
    const lanes J33s3_4 = X[12] + J22d4_4;
    const lanes Nbm43d4 = panda_geometry_D4 * m4_1e4 + J33s4_5;
    const lanes m1s3_4 = X[13] + m4_1e4;
    const lanes J13r3_3 = J13s3_4 - panda_geometry_R3 * m1s3_4;
    const lanes Nbm42r3 = -panda_geometry_R3 * m4_2e4 - Nbm43d4;
    const lanes xr3_3 = 2.0 * panda_geometry_R3 * m4_2e4;
    const lanes J11r3_3 = J11s3_4 + xr3_3;
    const lanes J22r3_3 = J33d4_4 + xr3_3;
    const lanes Nbm42e3 = C3 * Nbm42r3 + S3 * J13e4_4;
    lanes_put(&M[10], Nbm42e3, stream);
    lanes_put(&M[22], Nbm42e3, stream);
    const lanes Nbm41e3 = C3 * J13e4_4 - S3 * Nbm42r3;
    const lanes J13d4_4 = panda_geometry_D4 * m5_2e5 + J13e4_4;
    const lanes J12s3_4 = X[9] - J13d4_4;
    const lanes Nbm42e2 = S2 * Nbm41e3 - C2 * J23e4_4;
    lanes_put(&M[3], -Nbm42e2, stream);
    lanes_put(&M[21], -Nbm42e2, stream);
    const lanes J23s3_4 = X[11] - J23e4_4;
    const lanes M3_3 = X[15] + J33s3_4;
    lanes_put(&M[16], M3_3, stream);
    const lanes m2s3_4 = X[14] + m5_2e5;
    const lanes J23r3_3 = J23s3_4 - panda_geometry_R3 * m2s3_4;
    const lanes De3_3 = J11r3_3 - J22r3_3;
    const lanes Te3_3 = 2.0 * J12s3_4;
    const lanes ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const lanes J11e3_3 = J11r3_3 - S3 * ze3_3;
    const lanes J22e3_3 = S3 * ze3_3 + J22r3_3;
    const lanes J12e3_3 = C3 * ze3_3 - J12s3_4;
    const lanes J11s2_3 = X[1] + J11e3_3;
    const lanes J13s2_3 = X[3] + J12e3_3;
    const lanes J33s2_3 = X[5] + J22e3_3;
    lanes_put(&M[8], J33s2_3, stream);
    const lanes De2_2 = J11s2_3 - J33s3_4;
    const lanes J13e3_3 = C3 * J13r3_3 - S3 * J23r3_3;
    const lanes J23e3_3 = C3 * J23r3_3 + S3 * J13r3_3;
    lanes_put(&M[9], J23e3_3, stream);
    lanes_put(&M[15], J23e3_3, stream);
    const lanes J23s2_3 = X[4] - J23e3_3;
    const lanes J23e2_2 = C2 * J23s2_3 + S2 * J13s2_3;
    lanes_put(&M[1], -J23e2_2, stream);
    lanes_put(&M[7], -J23e2_2, stream);
    const lanes Nbm32e2 = S2 * J13e3_3 - C2 * J33s3_4;
    lanes_put(&M[2], -Nbm32e2, stream);
    lanes_put(&M[14], -Nbm32e2, stream);
    const lanes J12s2_3 = X[2] - J13e3_3;
    const lanes Te2_2 = 2.0 * J12s2_3;
    const lanes ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const lanes J22e2_2 = S2 * ze2_2 + J33s3_4;
    const lanes J33s1_2 = X[0] + J22e2_2;
    lanes_put(&M[0], J33s1_2, stream);
    const lanes Fbm51e4 = -C4 * m5_2e5;
    const lanes Fbm52e4 = -S4 * m5_2e5;
    const lanes Nbm53d4 = panda_geometry_D4 * Fbm52e4 - J23e5_5;
    const lanes Nbm52r3 = panda_geometry_R3 * Fbm51e4 - Nbm53d4;
    const lanes Nbm51e4 = C4 * J13e5_5 - S4 * Nbm53d5;
    const lanes Nbm52e4 = C4 * Nbm53d5 + S4 * J13e5_5;
    const lanes Nbm52d4 = panda_geometry_D4 * m5_1e5 + Nbm52e4;
    lanes_put(&M[18], Nbm52d4, stream);
    lanes_put(&M[30], Nbm52d4, stream);
    const lanes Nbm51r3 = Nbm51e4 - panda_geometry_R3 * m5_1e5;
    const lanes Nbm52e3 = C3 * Nbm52r3 + S3 * Nbm51r3;
    lanes_put(&M[11], Nbm52e3, stream);
    lanes_put(&M[29], Nbm52e3, stream);
    const lanes Nbm51e3 = C3 * Nbm51r3 - S3 * Nbm52r3;
    const lanes Nbm52e2 = S2 * Nbm51e3 - C2 * Nbm52d4;
    lanes_put(&M[4], -Nbm52e2, stream);
    lanes_put(&M[28], -Nbm52e2, stream);
    const lanes Fbm61e5 = -C5 * m6_2e6;
    const lanes Fbm62e5 = -S5 * m6_2e6;
    const lanes Nbm63d5 = J23e6_6 - panda_geometry_D4 * Fbm62e5;
    const lanes Nbm61e5 = C5 * J13e6_6 - S5 * Nbm62r5;
    const lanes Nbm62e5 = C5 * Nbm62r5 + S5 * J13e6_6;
    const lanes Nbm62d5 = panda_geometry_D4 * m6_1e6 + Nbm62e5;
    lanes_put(&M[26], -Nbm62d5, stream);
    lanes_put(&M[38], -Nbm62d5, stream);
    const lanes Fbm61e4 = C4 * Fbm61e5 - S4 * m6_1e6;
    const lanes Fbm62e4 = C4 * m6_1e6 + S4 * Fbm61e5;
    const lanes Nbm63d4 = panda_geometry_D4 * Fbm62e4 - Nbm62d5;
    const lanes Nbm62r3 = panda_geometry_R3 * Fbm61e4 - Nbm63d4;
    const lanes Nbm61e4 = C4 * Nbm61e5 - S4 * Nbm63d5;
    const lanes Nbm62e4 = C4 * Nbm63d5 + S4 * Nbm61e5;
    const lanes Nbm62d4 = panda_geometry_D4 * Fbm62e5 + Nbm62e4;
    lanes_put(&M[19], Nbm62d4, stream);
    lanes_put(&M[37], Nbm62d4, stream);
    const lanes Nbm61r3 = Nbm61e4 - panda_geometry_R3 * Fbm62e5;
    const lanes Nbm62e3 = C3 * Nbm62r3 + S3 * Nbm61r3;
    lanes_put(&M[12], Nbm62e3, stream);
    lanes_put(&M[36], Nbm62e3, stream);
    const lanes Nbm61e3 = C3 * Nbm61r3 - S3 * Nbm62r3;
    const lanes Nbm62e2 = S2 * Nbm61e3 - C2 * Nbm62d4;
    lanes_put(&M[5], -Nbm62e2, stream);
    lanes_put(&M[35], -Nbm62e2, stream);
    const lanes Nbm73d7 = X[44] + panda_geometry_D7 * m7_1e7;
    const lanes Fbm71e6 = -C6 * m7_2e7;
    const lanes Fbm72e6 = -S6 * m7_2e7;
    const lanes Nbm72r5 = panda_geometry_R5 * Fbm71e6 - J23e7_7;
    const lanes Nbm71e6 = C6 * J13e7_7 + S6 * Nbm73d7;
    const lanes Nbm72e6 = S6 * J13e7_7 - C6 * Nbm73d7;
    lanes_put(&M[34], Nbm72e6, stream);
    lanes_put(&M[46], Nbm72e6, stream);
    const lanes Nbm71r5 = panda_geometry_R5 * m7_1e7 + Nbm71e6;
    const lanes Fbm71e5 = C5 * Fbm71e6 + S5 * m7_1e7;
    const lanes Fbm72e5 = S5 * Fbm71e6 - C5 * m7_1e7;
    const lanes Nbm73d5 = Nbm72e6 - panda_geometry_D4 * Fbm72e5;
    const lanes Nbm71e5 = C5 * Nbm71r5 - S5 * Nbm72r5;
    const lanes Nbm72e5 = C5 * Nbm72r5 + S5 * Nbm71r5;
    const lanes Nbm72d5 = panda_geometry_D4 * Fbm72e6 + Nbm72e5;
    lanes_put(&M[27], -Nbm72d5, stream);
    lanes_put(&M[45], -Nbm72d5, stream);
    const lanes Fbm71e4 = C4 * Fbm71e5 - S4 * Fbm72e6;
    const lanes Fbm72e4 = C4 * Fbm72e6 + S4 * Fbm71e5;
    const lanes Nbm73d4 = panda_geometry_D4 * Fbm72e4 - Nbm72d5;
    const lanes Nbm72r3 = panda_geometry_R3 * Fbm71e4 - Nbm73d4;
    const lanes Nbm71e4 = C4 * Nbm71e5 - S4 * Nbm73d5;
    const lanes Nbm72e4 = C4 * Nbm73d5 + S4 * Nbm71e5;
    const lanes Nbm72d4 = panda_geometry_D4 * Fbm72e5 + Nbm72e4;
    lanes_put(&M[20], Nbm72d4, stream);
    lanes_put(&M[44], Nbm72d4, stream);
    const lanes Nbm71r3 = Nbm71e4 - panda_geometry_R3 * Fbm72e5;
    const lanes Nbm72e3 = C3 * Nbm72r3 + S3 * Nbm71r3;
    lanes_put(&M[13], Nbm72e3, stream);
    lanes_put(&M[43], Nbm72e3, stream);
    const lanes Nbm71e3 = C3 * Nbm71r3 - S3 * Nbm72r3;
    const lanes Nbm72e2 = S2 * Nbm71e3 - C2 * Nbm72d4;
    lanes_put(&M[6], -Nbm72e2, stream);
    lanes_put(&M[42], -Nbm72e2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *X, apart *M)
{
    return panel(q, X, M, 0);
}

int panda_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_X[REACH(48u)];
    lanes lanes_X[BLOCKS(48u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(X, 48u, lanes_X);
    lanes lanes_M[BLOCKS(49u)];
    double scratch[49u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_M, 0, sizeof lanes_M);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        const size_t count = (N - k < panda_WIDTH) ? (N - k) : panda_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_load(X, 48u, stride_X, k, N, padded_X, lanes_X);
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
    double padded_X[REACH(48u)];
    lanes lanes_X[BLOCKS(48u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(X, 48u, lanes_X);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_X != 0u) {
            lanes_load(X, 48u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_M = (apart *)&M[k * 49u];
        status |= stream ? panel(lanes_q, lanes_X, lanes_M, 1) : plain(lanes_q, lanes_X, lanes_M);
    }
    return status;
}

int panda_mass_matrix_panels(int stream, size_t N, const size_t *strides,
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

int panda_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[1] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        panda_mass_matrix(&q[k * stride_q], &X[k * stride_X], &M[k * 49u]);
    }
    return status;
}

int panda_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M)
{
    return panda_mass_matrix_rows(stream, N, strides, q, X, M);
}

#endif

size_t panda_mass_matrix_width(void)
{
    return panda_WIDTH;
}

void panda_mass_matrix_batch(size_t N, const double *q, const double *X, double *M)
{
    (void)panda_mass_matrix_rows(0, N, NULL, q, X, M);
}
