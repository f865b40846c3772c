/* puma560: generalized_momentum of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *p_out, apart *rate_out, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_5 = lanes_turn(q[5]);
    if (lanes_any(~(mask)(lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[5]) <= NEAR))) {
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_5 = lanes_far(q[5], q_5);
    }
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
    const lanes W1e2 = -qd[0] * S2;
    const lanes W2e2 = -qd[0] * C2;
    const lanes V1r2 = puma560_geometry_R2 * W2e2;
    const lanes V2r2 = -puma560_geometry_R2 * W1e2;
    const lanes V2d3 = qd[1] * puma560_geometry_D3 + V2r2;
    const lanes V3d3 = -puma560_geometry_D3 * W2e2;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes V1e3 = C3 * V1r2 + S3 * V2d3;
    const lanes V2e3 = C3 * V2d3 - S3 * V1r2;
    const lanes W33 = qd[1] + qd[2];
    const lanes V1r3 = puma560_geometry_R3 * W2e3 + V1e3;
    const lanes V2r3 = V2e3 - puma560_geometry_R3 * W1e3;
    const lanes V2d4 = V3d3 - puma560_geometry_D4 * W2e3;
    const lanes V3d4 = -puma560_geometry_D4 * W33 - V2r3;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes V1e4 = C4 * V1r3 + S4 * V2d4;
    const lanes V2e4 = C4 * V2d4 - S4 * V1r3;
    const lanes W34 = qd[3] - W2e3;
    const lanes V1r4 = puma560_geometry_R4 * W2e4 + V1e4;
    const lanes V2r4 = V2e4 - puma560_geometry_R4 * W1e4;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes V1e5 = C5 * V1r4 - S5 * V3d4;
    const lanes V2e5 = -C5 * V3d4 - S5 * V1r4;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes V1e6 = C6 * V1e5 + S6 * V2r4;
    const lanes V2e6 = C6 * V2r4 - S6 * V1e5;
    const lanes W36 = qd[5] - W2e5;
    const lanes k1_3 = qd[0] * X[0];
    const lanes l2_1 = -qd[1] * X[7];
    const lanes l2_2 = qd[1] * X[6];
    const lanes k2_1 = qd[1] * X[3] + X[1] * W1e2 + X[2] * W2e2;
    const lanes k2_2 = qd[1] * X[4] + X[2] * W1e2;
    const lanes k2_3 = qd[1] * X[5] + X[3] * W1e2 + X[4] * W2e2 + X[6] * V2r2 - X[7] * V1r2;
    const lanes l3_1 = -X[14] * W33;
    const lanes l3_2 = X[13] * W33;
    const lanes l3_3 = X[14] * W1e3 - X[13] * W2e3;
    const lanes k3_1 = X[8] * W1e3 + X[9] * W2e3 + X[10] * W33 + X[14] * V3d3;
    const lanes k3_2 = X[9] * W1e3 + X[11] * W33 - X[13] * V3d3;
    const lanes k3_3 = X[10] * W1e3 + X[11] * W2e3 + X[12] * W33 + X[13] * V2r3 - X[14] * V1r3;
    const lanes l4_1 = -X[22] * W34;
    const lanes l4_2 = X[21] * W34;
    const lanes l4_3 = X[22] * W1e4 - X[21] * W2e4;
    const lanes k4_1 = X[16] * W1e4 + X[17] * W2e4 + X[18] * W34 + X[22] * V3d4;
    const lanes k4_2 = X[17] * W1e4 + X[19] * W34 - X[21] * V3d4;
    const lanes k4_3 = X[18] * W1e4 + X[19] * W2e4 + X[20] * W34 + X[21] * V2r4 - X[22] * V1r4;
    const lanes l5_1 = -X[30] * W35;
    const lanes l5_2 = X[29] * W35;
    const lanes l5_3 = X[30] * W1e5 - X[29] * W2e5;
    const lanes k5_1 = X[24] * W1e5 + X[25] * W2e5 + X[26] * W35 + X[30] * V2r4;
    const lanes k5_2 = X[25] * W1e5 + X[27] * W35 - X[29] * V2r4;
    const lanes k5_3 = X[26] * W1e5 + X[27] * W2e5 + X[28] * W35 + X[29] * V2e5 - X[30] * V1e5;
    const lanes l6_1 = -X[38] * W36;
    const lanes l6_2 = X[37] * W36;
    const lanes l6_3 = X[38] * W1e6 - X[37] * W2e6;
    const lanes k6_1 = X[32] * W1e6 + X[33] * W2e6 + X[34] * W36 - X[38] * V2e5;
    const lanes k6_2 = X[33] * W1e6 + X[35] * W36 + X[37] * V2e5;
    const lanes k6_3 = X[34] * W1e6 + X[35] * W2e6 + X[36] * W36 + X[37] * V2e6 - X[38] * V1e6;
    const lanes Fbk1e6 = C6 * l6_1 - S6 * l6_2;
    const lanes Fbk2e6 = C6 * l6_2 + S6 * l6_1;
    const lanes Nbk1e6 = C6 * k6_1 - S6 * k6_2;
    const lanes Nbk2e6 = C6 * k6_2 + S6 * k6_1;
    const lanes Fks5_6_1 = l5_1 + Fbk1e6;
    const lanes Fks5_6_2 = l5_2 - l6_3;
    const lanes Fks5_6_3 = l5_3 + Fbk2e6;
    const lanes Nks5_6_1 = k5_1 + Nbk1e6;
    const lanes Nks5_6_2 = k5_2 - k6_3;
    const lanes Nks5_6_3 = k5_3 + Nbk2e6;
    const lanes Fbk1e5 = C5 * Fks5_6_1 - S5 * Fks5_6_2;
    const lanes Fbk2e5 = C5 * Fks5_6_2 + S5 * Fks5_6_1;
    const lanes Nbk1e5 = C5 * Nks5_6_1 - S5 * Nks5_6_2;
    const lanes Nbk2e5 = C5 * Nks5_6_2 + S5 * Nks5_6_1;
    const lanes Fks4_5_1 = l4_1 + Fbk1e5;
    const lanes Fks4_5_2 = l4_2 + Fks5_6_3;
    const lanes Fks4_5_3 = l4_3 - Fbk2e5;
    const lanes Nks4_5_1 = k4_1 + Nbk1e5;
    const lanes Nks4_5_2 = k4_2 + Nks5_6_3;
    const lanes Nks4_5_3 = k4_3 - Nbk2e5;
    const lanes Nbk1r4 = Nks4_5_1 - puma560_geometry_R4 * Fks4_5_2;
    const lanes Nbk2r4 = puma560_geometry_R4 * Fks4_5_1 + Nks4_5_2;
    const lanes Fbk1e4 = C4 * Fks4_5_1 - S4 * Fks4_5_2;
    const lanes Fbk2e4 = C4 * Fks4_5_2 + S4 * Fks4_5_1;
    const lanes Nbk1e4 = C4 * Nbk1r4 - S4 * Nbk2r4;
    const lanes Nbk2e4 = C4 * Nbk2r4 + S4 * Nbk1r4;
    const lanes Nbk2d4 = Nbk2e4 - puma560_geometry_D4 * Fks4_5_3;
    const lanes Nbk3d4 = puma560_geometry_D4 * Fbk2e4 + Nks4_5_3;
    const lanes Fks3_4_1 = l3_1 + Fbk1e4;
    const lanes Fks3_4_2 = l3_2 - Fks4_5_3;
    const lanes Fks3_4_3 = l3_3 + Fbk2e4;
    const lanes Nks3_4_1 = k3_1 + Nbk1e4;
    const lanes Nks3_4_2 = k3_2 - Nbk3d4;
    const lanes Nks3_4_3 = k3_3 + Nbk2d4;
    const lanes Nbk1r3 = Nks3_4_1 - puma560_geometry_R3 * Fks3_4_2;
    const lanes Nbk2r3 = puma560_geometry_R3 * Fks3_4_1 + Nks3_4_2;
    const lanes Fbk1e3 = C3 * Fks3_4_1 - S3 * Fks3_4_2;
    const lanes Fbk2e3 = C3 * Fks3_4_2 + S3 * Fks3_4_1;
    const lanes Nbk1e3 = C3 * Nbk1r3 - S3 * Nbk2r3;
    const lanes Nbk2e3 = C3 * Nbk2r3 + S3 * Nbk1r3;
    const lanes Nbk2d3 = Nbk2e3 - puma560_geometry_D3 * Fks3_4_3;
    const lanes Nbk3d3 = puma560_geometry_D3 * Fbk2e3 + Nks3_4_3;
    const lanes Fks2_3_1 = l2_1 + Fbk1e3;
    const lanes Fks2_3_2 = l2_2 + Fbk2e3;
    const lanes Nks2_3_1 = k2_1 + Nbk1e3;
    const lanes Nks2_3_2 = k2_2 + Nbk2d3;
    const lanes Nks2_3_3 = k2_3 + Nbk3d3;
    lanes_put(&p_out[1], Nks2_3_3, stream);
    const lanes Nbk1r2 = Nks2_3_1 - puma560_geometry_R2 * Fks2_3_2;
    const lanes Nbk2r2 = puma560_geometry_R2 * Fks2_3_1 + Nks2_3_2;
    const lanes Nbk2e2 = C2 * Nbk2r2 + S2 * Nbk1r2;
    const lanes Nks1_2_3 = k1_3 - Nbk2e2;
    lanes_put(&p_out[0], Nks1_2_3, stream);
    const lanes r2 = W2e2 * Nks2_3_1 + V2r2 * Fks2_3_1 - W1e2 * Nks2_3_2 - V1r2 * Fks2_3_2;
    const lanes r3 = W2e3 * Nks3_4_1 + V2r3 * Fks3_4_1 - W1e3 * Nks3_4_2 - V1r3 * Fks3_4_2;
    const lanes r4 = W2e4 * Nks4_5_1 + V2r4 * Fks4_5_1 - W1e4 * Nks4_5_2 - V1r4 * Fks4_5_2;
    const lanes r5 = W2e5 * Nks5_6_1 + V2e5 * Fks5_6_1 - W1e5 * Nks5_6_2 - V1e5 * Fks5_6_2;
    const lanes r6 = W2e6 * k6_1 + V2e6 * l6_1 - W1e6 * k6_2 - V1e6 * l6_2;
    const lanes Z1e2 = -gz * S2;
    const lanes Z2e2 = -gz * C2;
    const lanes Z1e3 = C3 * Z1e2 + S3 * Z2e2;
    const lanes Z2e3 = C3 * Z2e2 - S3 * Z1e2;
    const lanes Z1e4 = C4 * Z1e3;
    const lanes Z2e4 = -S4 * Z1e3;
    const lanes Z1e5 = C5 * Z1e4 + S5 * Z2e3;
    const lanes Z2e5 = C5 * Z2e3 - S5 * Z1e4;
    const lanes Z1e6 = C6 * Z1e5 + S6 * Z2e4;
    const lanes Z2e6 = C6 * Z2e4 - S6 * Z1e5;
    const lanes N2_3 = X[6] * Z2e2 - X[7] * Z1e2;
    const lanes N3_3 = X[13] * Z2e3 - X[14] * Z1e3;
    const lanes N4_1 = -X[22] * Z2e3;
    const lanes N4_2 = X[21] * Z2e3;
    const lanes N4_3 = X[21] * Z2e4 - X[22] * Z1e4;
    const lanes N5_1 = X[30] * Z2e4;
    const lanes N5_2 = -X[29] * Z2e4;
    const lanes N5_3 = X[29] * Z2e5 - X[30] * Z1e5;
    const lanes N6_1 = -X[38] * Z2e5;
    const lanes N6_2 = X[37] * Z2e5;
    const lanes N6_3 = X[37] * Z2e6 - X[38] * Z1e6;
    const lanes Nb1e6 = C6 * N6_1 - S6 * N6_2;
    const lanes Nb2e6 = C6 * N6_2 + S6 * N6_1;
    const lanes Ns5_6_1 = N5_1 + Nb1e6;
    const lanes Ns5_6_2 = N5_2 - N6_3;
    const lanes Ns5_6_3 = N5_3 + Nb2e6;
    const lanes Nb1e5 = C5 * Ns5_6_1 - S5 * Ns5_6_2;
    const lanes Nb2e5 = C5 * Ns5_6_2 + S5 * Ns5_6_1;
    const lanes Ns4_5_1 = N4_1 + Nb1e5;
    const lanes Ns4_5_2 = N4_2 + Ns5_6_3;
    const lanes Ns4_5_3 = N4_3 - Nb2e5;
    const lanes Nb1e4 = C4 * Ns4_5_1 - S4 * Ns4_5_2;
    const lanes Nb2e4 = C4 * Ns4_5_2 + S4 * Ns4_5_1;
    const lanes Ns3_4_3 = N3_3 + Nb2e4;
    const lanes Nb1e3 = C3 * Nb1e4 + S3 * Ns4_5_3;
    const lanes Nb2e3 = S3 * Nb1e4 - C3 * Ns4_5_3;
    const lanes Ns2_3_3 = N2_3 + Ns3_4_3;
    const lanes Nb2e2 = C2 * Nb2e3 + S2 * Nb1e3;
    lanes_put(&rate_out[0], Nb2e2, stream);
    const lanes p3 = qd[2] * X[15] + Nks3_4_3;
    lanes_put(&p_out[2], p3, stream);
    const lanes p4 = qd[3] * X[23] + Nks4_5_3;
    lanes_put(&p_out[3], p4, stream);
    const lanes p5 = qd[4] * X[31] + Nks5_6_3;
    lanes_put(&p_out[4], p5, stream);
    const lanes p6 = qd[5] * X[39] + k6_3;
    lanes_put(&p_out[5], p6, stream);
    const lanes R2_ = r2 - Ns2_3_3;
    lanes_put(&rate_out[1], R2_, stream);
    const lanes R3_ = r3 - Ns3_4_3;
    lanes_put(&rate_out[2], R3_, stream);
    const lanes R4_ = r4 - Ns4_5_3;
    lanes_put(&rate_out[3], R4_, stream);
    const lanes R5 = r5 - Ns5_6_3;
    lanes_put(&rate_out[4], R5, stream);
    const lanes R6 = r6 - N6_3;
    lanes_put(&rate_out[5], R6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *p_out, apart *rate_out)
{
    return panel(q, qd, X, p_out, rate_out, 0);
}

int puma560_generalized_momentum_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_X[REACH(40u)];
    lanes lanes_X[BLOCKS(40u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(X, 40u, lanes_X);
    lanes lanes_p_out[BLOCKS(6u)];
    lanes lanes_rate_out[BLOCKS(6u)];
    double scratch[6u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_p_out, 0, sizeof lanes_p_out);
    memset(lanes_rate_out, 0, sizeof lanes_rate_out);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 40u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_p_out, (apart *)lanes_rate_out);
        lanes_store(lanes_p_out, 6u, count, stream, scratch, &p_out[k * 6u]);
        lanes_store(lanes_rate_out, 6u, count, stream, scratch, &rate_out[k * 6u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_X[REACH(40u)];
    lanes lanes_X[BLOCKS(40u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(X, 40u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_read(X, 40u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_p_out = (apart *)&p_out[k * 6u];
        apart *lanes_rate_out = (apart *)&rate_out[k * 6u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_p_out, lanes_rate_out, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_p_out, lanes_rate_out);
    }
    return status;
}

int puma560_generalized_momentum_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    if (!(streamed(stream, p_out) && streamed(stream, rate_out))) {
        return panels(0, N, strides, q, qd, X, p_out, rate_out);
    }
    const int status = panels(1, N, strides, q, qd, X, p_out, rate_out);
    stream_end();
    return status;
}

#else

int puma560_generalized_momentum_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_generalized_momentum(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &p_out[k * 6u], &rate_out[k * 6u]);
    }
    return status;
}

int puma560_generalized_momentum_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    return puma560_generalized_momentum_rows(stream, N, strides, q, qd, X, p_out, rate_out);
}

#endif

size_t puma560_generalized_momentum_width(void)
{
    return puma560_WIDTH;
}

void puma560_generalized_momentum_batch(size_t N, const double *q, const double *qd, const double *X, double *p_out, double *rate_out)
{
    (void)puma560_generalized_momentum_rows(0, N, NULL, q, qd, X, p_out, rate_out);
}
