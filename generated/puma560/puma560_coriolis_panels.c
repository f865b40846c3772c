/* puma560: coriolis of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *C, const int stream)
{
    (void)stream;
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
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes W33 = qd[1] + qd[2];
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes W34 = qd[3] - W2e3;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes W36 = qd[5] - W2e5;
    const lanes l1_P11r2 = -S2 * W1e2;
    const lanes l1_P22r2 = -C2 * W2e2;
    const lanes l1_A3r2 = l1_P11r2 + l1_P22r2;
    const lanes l1_3r2 = -puma560_geometry_R2 * l1_A3r2;
    const lanes l1_P12d3 = -S2 * W2e2;
    const lanes l1_P13d3 = -qd[1] * S2;
    const lanes l1_2d3 = puma560_geometry_D3 * l1_P12d3;
    const lanes l1_3d3 = puma560_geometry_D3 * l1_P13d3 + l1_3r2;
    const lanes l1_1d3 = -puma560_geometry_D3 * l1_P22r2;
    const lanes E1_1e3 = -C2 * S3 - S2 * C3;
    const lanes E1_2e3 = S2 * S3 - C2 * C3;
    const lanes l1_1e3 = C3 * l1_1d3 + S3 * l1_2d3;
    const lanes l1_2e3 = C3 * l1_2d3 - S3 * l1_1d3;
    const lanes l1_P11r3 = W1e3 * E1_1e3;
    const lanes l1_P22r3 = W2e3 * E1_2e3;
    const lanes l1_A3r3 = l1_P11r3 + l1_P22r3;
    const lanes l1_3r3 = l1_3d3 - puma560_geometry_R3 * l1_A3r3;
    const lanes l1_P12d4 = W33 * E1_1e3;
    const lanes l1_P13d4 = -W2e3 * E1_1e3;
    const lanes l1_2d4 = puma560_geometry_D4 * l1_P12d4 + l1_3r3;
    const lanes l1_3d4 = puma560_geometry_D4 * l1_P13d4 - l1_2e3;
    const lanes l1_1d4 = l1_1e3 - puma560_geometry_D4 * l1_P22r3;
    const lanes E1_1e4 = C4 * E1_1e3;
    const lanes E1_2e4 = -S4 * E1_1e3;
    const lanes l1_1e4 = C4 * l1_1d4 + S4 * l1_2d4;
    const lanes l1_2e4 = C4 * l1_2d4 - S4 * l1_1d4;
    const lanes l1_P31r4 = -W1e4 * E1_2e3;
    const lanes l1_P32r4 = -W2e4 * E1_2e3;
    const lanes l1_P11r4 = W1e4 * E1_1e4;
    const lanes l1_P22r4 = W2e4 * E1_2e4;
    const lanes l1_A3r4 = l1_P11r4 + l1_P22r4;
    const lanes l1_1r4 = puma560_geometry_R4 * l1_P31r4 + l1_1e4;
    const lanes l1_2r4 = puma560_geometry_R4 * l1_P32r4 + l1_2e4;
    const lanes l1_3r4 = l1_3d4 - puma560_geometry_R4 * l1_A3r4;
    const lanes E1_1e5 = C5 * E1_1e4 + S5 * E1_2e3;
    const lanes E1_2e5 = C5 * E1_2e3 - S5 * E1_1e4;
    const lanes l1_1e5 = C5 * l1_1r4 - S5 * l1_3r4;
    const lanes l1_2e5 = -C5 * l1_3r4 - S5 * l1_1r4;
    const lanes E1_1e6 = C6 * E1_1e5 + S6 * E1_2e4;
    const lanes E1_2e6 = C6 * E1_2e4 - S6 * E1_1e5;
    const lanes l1_1e6 = C6 * l1_1e5 + S6 * l1_2r4;
    const lanes l1_2e6 = C6 * l1_2r4 - S6 * l1_1e5;
    const lanes h2v1_1 = -qd[1] * X[7];
    const lanes h2v1_2 = qd[1] * X[6];
    const lanes h2v1_3 = X[7] * W1e2 - X[6] * W2e2;
    const lanes t2v1 = X[1] + X[5];
    const lanes h2v1 = 0.5 * t2v1;
    const lanes j12v1 = X[1] - h2v1;
    const lanes j32v1 = X[5] - h2v1;
    const lanes k2v1_1 = -X[2] * C2 - S2 * j12v1;
    const lanes k2v1_2 = C2 * h2v1 - X[2] * S2;
    const lanes k2v1_3 = -X[3] * S2 - X[4] * C2;
    const lanes F2v1_1 = -C2 * h2v1_3;
    const lanes F2v1_2 = S2 * h2v1_3;
    const lanes N2v1_1 = X[7] * l1_3r2 + W2e2 * k2v1_3 - qd[1] * k2v1_2;
    const lanes N2v1_2 = qd[1] * k2v1_1 - X[6] * l1_3r2 - W1e2 * k2v1_3;
    const lanes N2v1_3 = W1e2 * k2v1_2 - W2e2 * k2v1_1;
    const lanes h3v1_1 = -X[14] * W33;
    const lanes h3v1_2 = X[13] * W33;
    const lanes h3v1_3 = X[14] * W1e3 - X[13] * W2e3;
    const lanes t3v1 = X[8] + X[12];
    const lanes h3v1 = 0.5 * t3v1;
    const lanes j13v1 = X[8] - h3v1;
    const lanes j33v1 = X[12] - h3v1;
    const lanes k3v1_1 = X[9] * E1_2e3 + E1_1e3 * j13v1;
    const lanes k3v1_2 = X[9] * E1_1e3 - E1_2e3 * h3v1;
    const lanes k3v1_3 = X[10] * E1_1e3 + X[11] * E1_2e3;
    const lanes F3v1_1 = E1_2e3 * h3v1_3;
    const lanes F3v1_2 = -E1_1e3 * h3v1_3;
    const lanes F3v1_3 = E1_1e3 * h3v1_2 - E1_2e3 * h3v1_1;
    const lanes N3v1_1 = X[14] * l1_3r3 + W2e3 * k3v1_3 - W33 * k3v1_2;
    const lanes N3v1_2 = W33 * k3v1_1 - X[13] * l1_3r3 - W1e3 * k3v1_3;
    const lanes N3v1_3 = X[13] * l1_2e3 + W1e3 * k3v1_2 - X[14] * l1_1e3 - W2e3 * k3v1_1;
    const lanes h4v1_1 = -X[22] * W34;
    const lanes h4v1_2 = X[21] * W34;
    const lanes h4v1_3 = X[22] * W1e4 - X[21] * W2e4;
    const lanes t4v1 = X[16] + X[20];
    const lanes h4v1 = 0.5 * t4v1;
    const lanes j14v1 = X[16] - h4v1;
    const lanes j34v1 = X[20] - h4v1;
    const lanes k4v1_1 = X[17] * E1_2e4 + E1_1e4 * j14v1 - X[18] * E1_2e3;
    const lanes k4v1_2 = X[17] * E1_1e4 - X[19] * E1_2e3 - E1_2e4 * h4v1;
    const lanes k4v1_3 = X[18] * E1_1e4 + X[19] * E1_2e4 - E1_2e3 * j34v1;
    const lanes F4v1_1 = E1_2e3 * h4v1_2 + E1_2e4 * h4v1_3;
    const lanes F4v1_2 = -E1_2e3 * h4v1_1 - E1_1e4 * h4v1_3;
    const lanes F4v1_3 = E1_1e4 * h4v1_2 - E1_2e4 * h4v1_1;
    const lanes N4v1_1 = X[22] * l1_3r4 + W2e4 * k4v1_3 - W34 * k4v1_2;
    const lanes N4v1_2 = W34 * k4v1_1 - X[21] * l1_3r4 - W1e4 * k4v1_3;
    const lanes N4v1_3 = X[21] * l1_2r4 + W1e4 * k4v1_2 - X[22] * l1_1r4 - W2e4 * k4v1_1;
    const lanes h5v1_1 = -X[30] * W35;
    const lanes h5v1_2 = X[29] * W35;
    const lanes h5v1_3 = X[30] * W1e5 - X[29] * W2e5;
    const lanes t5v1 = X[24] + X[28];
    const lanes h5v1 = 0.5 * t5v1;
    const lanes j15v1 = X[24] - h5v1;
    const lanes j35v1 = X[28] - h5v1;
    const lanes k5v1_1 = X[25] * E1_2e5 + X[26] * E1_2e4 + E1_1e5 * j15v1;
    const lanes k5v1_2 = X[25] * E1_1e5 + X[27] * E1_2e4 - E1_2e5 * h5v1;
    const lanes k5v1_3 = X[26] * E1_1e5 + X[27] * E1_2e5 + E1_2e4 * j35v1;
    const lanes F5v1_1 = E1_2e5 * h5v1_3 - E1_2e4 * h5v1_2;
    const lanes F5v1_2 = E1_2e4 * h5v1_1 - E1_1e5 * h5v1_3;
    const lanes F5v1_3 = E1_1e5 * h5v1_2 - E1_2e5 * h5v1_1;
    const lanes N5v1_1 = X[30] * l1_2r4 + W2e5 * k5v1_3 - W35 * k5v1_2;
    const lanes N5v1_2 = W35 * k5v1_1 - X[29] * l1_2r4 - W1e5 * k5v1_3;
    const lanes N5v1_3 = X[29] * l1_2e5 + W1e5 * k5v1_2 - X[30] * l1_1e5 - W2e5 * k5v1_1;
    const lanes h6v1_1 = -X[38] * W36;
    const lanes h6v1_2 = X[37] * W36;
    const lanes h6v1_3 = X[38] * W1e6 - X[37] * W2e6;
    const lanes t6v1 = X[32] + X[36];
    const lanes h6v1 = 0.5 * t6v1;
    const lanes j16v1 = X[32] - h6v1;
    const lanes j36v1 = X[36] - h6v1;
    const lanes k6v1_1 = X[33] * E1_2e6 + E1_1e6 * j16v1 - X[34] * E1_2e5;
    const lanes k6v1_2 = X[33] * E1_1e6 - X[35] * E1_2e5 - E1_2e6 * h6v1;
    const lanes k6v1_3 = X[34] * E1_1e6 + X[35] * E1_2e6 - E1_2e5 * j36v1;
    const lanes F6v1_1 = E1_2e5 * h6v1_2 + E1_2e6 * h6v1_3;
    const lanes F6v1_2 = -E1_2e5 * h6v1_1 - E1_1e6 * h6v1_3;
    const lanes F6v1_3 = E1_1e6 * h6v1_2 - E1_2e6 * h6v1_1;
    const lanes N6v1_1 = W2e6 * k6v1_3 - X[38] * l1_2e5 - W36 * k6v1_2;
    const lanes N6v1_2 = X[37] * l1_2e5 + W36 * k6v1_1 - W1e6 * k6v1_3;
    const lanes N6v1_3 = X[37] * l1_2e6 + W1e6 * k6v1_2 - X[38] * l1_1e6 - W2e6 * k6v1_1;
    lanes_put(&C[30], N6v1_3, stream);
    const lanes Fbc11e6 = C6 * F6v1_1 - S6 * F6v1_2;
    const lanes Fbc12e6 = C6 * F6v1_2 + S6 * F6v1_1;
    const lanes Nbc11e6 = C6 * N6v1_1 - S6 * N6v1_2;
    const lanes Nbc12e6 = C6 * N6v1_2 + S6 * N6v1_1;
    const lanes Fc1s5_6_1 = F5v1_1 + Fbc11e6;
    const lanes Fc1s5_6_2 = F5v1_2 - F6v1_3;
    const lanes Fc1s5_6_3 = F5v1_3 + Fbc12e6;
    const lanes Nc1s5_6_1 = N5v1_1 + Nbc11e6;
    const lanes Nc1s5_6_2 = N5v1_2 - N6v1_3;
    const lanes Nc1s5_6_3 = N5v1_3 + Nbc12e6;
    lanes_put(&C[24], Nc1s5_6_3, stream);
    const lanes Fbc11e5 = C5 * Fc1s5_6_1 - S5 * Fc1s5_6_2;
    const lanes Fbc12e5 = C5 * Fc1s5_6_2 + S5 * Fc1s5_6_1;
    const lanes Nbc11e5 = C5 * Nc1s5_6_1 - S5 * Nc1s5_6_2;
    const lanes Nbc12e5 = C5 * Nc1s5_6_2 + S5 * Nc1s5_6_1;
    const lanes Fc1s4_5_1 = F4v1_1 + Fbc11e5;
    const lanes Fc1s4_5_2 = F4v1_2 + Fc1s5_6_3;
    const lanes Fc1s4_5_3 = F4v1_3 - Fbc12e5;
    const lanes Nc1s4_5_1 = N4v1_1 + Nbc11e5;
    const lanes Nc1s4_5_2 = N4v1_2 + Nc1s5_6_3;
    const lanes Nc1s4_5_3 = N4v1_3 - Nbc12e5;
    lanes_put(&C[18], Nc1s4_5_3, stream);
    const lanes Nbc11r4 = Nc1s4_5_1 - puma560_geometry_R4 * Fc1s4_5_2;
    const lanes Nbc12r4 = puma560_geometry_R4 * Fc1s4_5_1 + Nc1s4_5_2;
    const lanes Fbc11e4 = C4 * Fc1s4_5_1 - S4 * Fc1s4_5_2;
    const lanes Fbc12e4 = C4 * Fc1s4_5_2 + S4 * Fc1s4_5_1;
    const lanes Nbc11e4 = C4 * Nbc11r4 - S4 * Nbc12r4;
    const lanes Nbc12e4 = C4 * Nbc12r4 + S4 * Nbc11r4;
    const lanes Nbc12d4 = Nbc12e4 - puma560_geometry_D4 * Fc1s4_5_3;
    const lanes Nbc13d4 = puma560_geometry_D4 * Fbc12e4 + Nc1s4_5_3;
    const lanes Fc1s3_4_1 = F3v1_1 + Fbc11e4;
    const lanes Fc1s3_4_2 = F3v1_2 - Fc1s4_5_3;
    const lanes Fc1s3_4_3 = F3v1_3 + Fbc12e4;
    const lanes Nc1s3_4_1 = N3v1_1 + Nbc11e4;
    const lanes Nc1s3_4_2 = N3v1_2 - Nbc13d4;
    const lanes Nc1s3_4_3 = N3v1_3 + Nbc12d4;
    lanes_put(&C[12], Nc1s3_4_3, stream);
    const lanes Nbc11r3 = Nc1s3_4_1 - puma560_geometry_R3 * Fc1s3_4_2;
    const lanes Nbc12r3 = puma560_geometry_R3 * Fc1s3_4_1 + Nc1s3_4_2;
    const lanes Fbc11e3 = C3 * Fc1s3_4_1 - S3 * Fc1s3_4_2;
    const lanes Fbc12e3 = C3 * Fc1s3_4_2 + S3 * Fc1s3_4_1;
    const lanes Nbc11e3 = C3 * Nbc11r3 - S3 * Nbc12r3;
    const lanes Nbc12e3 = C3 * Nbc12r3 + S3 * Nbc11r3;
    const lanes Nbc12d3 = Nbc12e3 - puma560_geometry_D3 * Fc1s3_4_3;
    const lanes Nbc13d3 = puma560_geometry_D3 * Fbc12e3 + Nc1s3_4_3;
    const lanes Fc1s2_3_1 = F2v1_1 + Fbc11e3;
    const lanes Fc1s2_3_2 = F2v1_2 + Fbc12e3;
    const lanes Nc1s2_3_1 = N2v1_1 + Nbc11e3;
    const lanes Nc1s2_3_2 = N2v1_2 + Nbc12d3;
    const lanes Nc1s2_3_3 = N2v1_3 + Nbc13d3;
    lanes_put(&C[6], Nc1s2_3_3, stream);
    const lanes Nbc11r2 = Nc1s2_3_1 - puma560_geometry_R2 * Fc1s2_3_2;
    const lanes Nbc12r2 = puma560_geometry_R2 * Fc1s2_3_1 + Nc1s2_3_2;
    const lanes Nbc12e2 = C2 * Nbc12r2 + S2 * Nbc11r2;
    lanes_put(&C[0], -Nbc12e2, stream);
    const lanes l2_3d3 = puma560_geometry_D3 * W1e2;
    const lanes l2_1d3 = -qd[1] * puma560_geometry_D3;
    const lanes l2_1e3 = C3 * l2_1d3;
    const lanes l2_2e3 = -S3 * l2_1d3;
    const lanes l2_2d4 = puma560_geometry_D4 * W1e3 + l2_3d3;
    const lanes l2_1d4 = l2_1e3 - puma560_geometry_D4 * W33;
    const lanes e2_1e4 = C4 * W2e3;
    const lanes e2_2e4 = -S4 * W2e3;
    const lanes l2_1e4 = C4 * l2_1d4 + S4 * l2_2d4;
    const lanes l2_2e4 = C4 * l2_2d4 - S4 * l2_1d4;
    const lanes l2_P11r4 = S4 * W1e4;
    const lanes l2_P22r4 = C4 * W2e4;
    const lanes l2_A3r4 = l2_P11r4 + l2_P22r4;
    const lanes l2_1r4 = puma560_geometry_R4 * e2_2e4 + l2_1e4;
    const lanes l2_2r4 = l2_2e4 - puma560_geometry_R4 * e2_1e4;
    const lanes l2_3r4 = -puma560_geometry_R4 * l2_A3r4 - l2_2e3;
    const lanes E2_1e5 = S4 * C5;
    const lanes E2_2e5 = -S4 * S5;
    const lanes e2_1e5 = C5 * e2_1e4 - S5 * W1e3;
    const lanes e2_2e5 = -C5 * W1e3 - S5 * e2_1e4;
    const lanes l2_1e5 = C5 * l2_1r4 - S5 * l2_3r4;
    const lanes l2_2e5 = -C5 * l2_3r4 - S5 * l2_1r4;
    const lanes E2_1e6 = C4 * S6 + C6 * E2_1e5;
    const lanes E2_2e6 = C4 * C6 - S6 * E2_1e5;
    const lanes e2_1e6 = C6 * e2_1e5 + S6 * e2_2e4;
    const lanes e2_2e6 = C6 * e2_2e4 - S6 * e2_1e5;
    const lanes l2_1e6 = C6 * l2_1e5 + S6 * l2_2r4;
    const lanes l2_2e6 = C6 * l2_2r4 - S6 * l2_1e5;
    const lanes N2v2_1 = X[1] * W2e2 + W2e2 * j32v1 - qd[1] * X[4] - X[2] * W1e2;
    const lanes N2v2_2 = qd[1] * X[3] + X[2] * W2e2 - W1e2 * j32v1;
    const lanes F3v2_3 = X[13] * W1e3 + X[14] * W2e3;
    const lanes N3v2_1 = X[8] * W2e3 + X[14] * l2_3d3 + W2e3 * j33v1 - X[9] * W1e3 - X[11] * W33;
    const lanes N3v2_2 = X[9] * W2e3 + X[10] * W33 - X[13] * l2_3d3 - W1e3 * j33v1;
    const lanes N3v2_3 = X[13] * l2_2e3 - X[14] * l2_1e3;
    const lanes k4v2_1 = X[17] * C4 + S4 * j14v1;
    const lanes k4v2_2 = X[17] * S4 - C4 * h4v1;
    const lanes k4v2_3 = X[18] * S4 + X[19] * C4;
    const lanes F4v2_1 = C4 * h4v1_3 - X[22] * W1e3;
    const lanes F4v2_2 = X[21] * W1e3 - S4 * h4v1_3;
    const lanes F4v2_3 = X[22] * e2_1e4 + S4 * h4v1_2 - X[21] * e2_2e4 - C4 * h4v1_1;
    const lanes N4v2_1 = X[16] * e2_1e4 + X[17] * e2_2e4 + X[18] * W1e3 + X[22] * l2_3r4 + W2e4 * k4v2_3 - W34 * k4v2_2;
    const lanes N4v2_2 = X[17] * e2_1e4 + X[19] * W1e3 + W34 * k4v2_1 - X[21] * l2_3r4 - W1e4 * k4v2_3;
    const lanes N4v2_3 = X[18] * e2_1e4 + X[19] * e2_2e4 + X[20] * W1e3 + X[21] * l2_2r4 + W1e4 * k4v2_2 - X[22] * l2_1r4 - W2e4 * k4v2_1;
    const lanes k5v2_1 = X[25] * E2_2e5 + X[26] * C4 + j15v1 * E2_1e5;
    const lanes k5v2_2 = X[25] * E2_1e5 + X[27] * C4 - h5v1 * E2_2e5;
    const lanes k5v2_3 = X[26] * E2_1e5 + X[27] * E2_2e5 + C4 * j35v1;
    const lanes F5v2_1 = h5v1_3 * E2_2e5 - X[30] * e2_2e4 - C4 * h5v1_2;
    const lanes F5v2_2 = X[29] * e2_2e4 + C4 * h5v1_1 - h5v1_3 * E2_1e5;
    const lanes F5v2_3 = X[30] * e2_1e5 + h5v1_2 * E2_1e5 - X[29] * e2_2e5 - h5v1_1 * E2_2e5;
    const lanes N5v2_1 = X[24] * e2_1e5 + X[25] * e2_2e5 + X[26] * e2_2e4 + X[30] * l2_2r4 + W2e5 * k5v2_3 - W35 * k5v2_2;
    const lanes N5v2_2 = X[25] * e2_1e5 + X[27] * e2_2e4 + W35 * k5v2_1 - X[29] * l2_2r4 - W1e5 * k5v2_3;
    const lanes N5v2_3 = X[26] * e2_1e5 + X[27] * e2_2e5 + X[28] * e2_2e4 + X[29] * l2_2e5 + W1e5 * k5v2_2 - X[30] * l2_1e5 - W2e5 * k5v2_1;
    const lanes k6v2_1 = X[33] * E2_2e6 + j16v1 * E2_1e6 - X[34] * E2_2e5;
    const lanes k6v2_2 = X[33] * E2_1e6 - X[35] * E2_2e5 - h6v1 * E2_2e6;
    const lanes k6v2_3 = X[34] * E2_1e6 + X[35] * E2_2e6 - j36v1 * E2_2e5;
    const lanes F6v2_1 = X[38] * e2_2e5 + h6v1_2 * E2_2e5 + h6v1_3 * E2_2e6;
    const lanes F6v2_2 = -X[37] * e2_2e5 - h6v1_1 * E2_2e5 - h6v1_3 * E2_1e6;
    const lanes F6v2_3 = X[38] * e2_1e6 + h6v1_2 * E2_1e6 - X[37] * e2_2e6 - h6v1_1 * E2_2e6;
    const lanes N6v2_1 = X[32] * e2_1e6 + X[33] * e2_2e6 + W2e6 * k6v2_3 - X[34] * e2_2e5 - X[38] * l2_2e5 - W36 * k6v2_2;
    const lanes N6v2_2 = X[33] * e2_1e6 + X[37] * l2_2e5 + W36 * k6v2_1 - X[35] * e2_2e5 - W1e6 * k6v2_3;
    const lanes N6v2_3 = X[34] * e2_1e6 + X[35] * e2_2e6 + X[37] * l2_2e6 + W1e6 * k6v2_2 - X[36] * e2_2e5 - X[38] * l2_1e6 - W2e6 * k6v2_1;
    lanes_put(&C[31], N6v2_3, stream);
    const lanes Fbc21e6 = C6 * F6v2_1 - S6 * F6v2_2;
    const lanes Fbc22e6 = C6 * F6v2_2 + S6 * F6v2_1;
    const lanes Nbc21e6 = C6 * N6v2_1 - S6 * N6v2_2;
    const lanes Nbc22e6 = C6 * N6v2_2 + S6 * N6v2_1;
    const lanes Fc2s5_6_1 = F5v2_1 + Fbc21e6;
    const lanes Fc2s5_6_2 = F5v2_2 - F6v2_3;
    const lanes Fc2s5_6_3 = F5v2_3 + Fbc22e6;
    const lanes Nc2s5_6_1 = N5v2_1 + Nbc21e6;
    const lanes Nc2s5_6_2 = N5v2_2 - N6v2_3;
    const lanes Nc2s5_6_3 = N5v2_3 + Nbc22e6;
    lanes_put(&C[25], Nc2s5_6_3, stream);
    const lanes Fbc21e5 = C5 * Fc2s5_6_1 - S5 * Fc2s5_6_2;
    const lanes Fbc22e5 = C5 * Fc2s5_6_2 + S5 * Fc2s5_6_1;
    const lanes Nbc21e5 = C5 * Nc2s5_6_1 - S5 * Nc2s5_6_2;
    const lanes Nbc22e5 = C5 * Nc2s5_6_2 + S5 * Nc2s5_6_1;
    const lanes Fc2s4_5_1 = F4v2_1 + Fbc21e5;
    const lanes Fc2s4_5_2 = F4v2_2 + Fc2s5_6_3;
    const lanes Fc2s4_5_3 = F4v2_3 - Fbc22e5;
    const lanes Nc2s4_5_1 = N4v2_1 + Nbc21e5;
    const lanes Nc2s4_5_2 = N4v2_2 + Nc2s5_6_3;
    const lanes Nc2s4_5_3 = N4v2_3 - Nbc22e5;
    lanes_put(&C[19], Nc2s4_5_3, stream);
    const lanes Nbc21r4 = Nc2s4_5_1 - puma560_geometry_R4 * Fc2s4_5_2;
    const lanes Nbc22r4 = puma560_geometry_R4 * Fc2s4_5_1 + Nc2s4_5_2;
    const lanes Fbc21e4 = C4 * Fc2s4_5_1 - S4 * Fc2s4_5_2;
    const lanes Fbc22e4 = C4 * Fc2s4_5_2 + S4 * Fc2s4_5_1;
    const lanes Nbc21e4 = C4 * Nbc21r4 - S4 * Nbc22r4;
    const lanes Nbc22e4 = C4 * Nbc22r4 + S4 * Nbc21r4;
    const lanes Nbc22d4 = Nbc22e4 - puma560_geometry_D4 * Fc2s4_5_3;
    const lanes Nbc23d4 = puma560_geometry_D4 * Fbc22e4 + Nc2s4_5_3;
    const lanes Fc2s3_4_1 = Fbc21e4 - h3v1_2;
    const lanes Fc2s3_4_2 = h3v1_1 - Fc2s4_5_3;
    const lanes Fc2s3_4_3 = F3v2_3 + Fbc22e4;
    const lanes Nc2s3_4_1 = N3v2_1 + Nbc21e4;
    const lanes Nc2s3_4_2 = N3v2_2 - Nbc23d4;
    const lanes Nc2s3_4_3 = N3v2_3 + Nbc22d4;
    lanes_put(&C[13], Nc2s3_4_3, stream);
    const lanes Nbc21r3 = Nc2s3_4_1 - puma560_geometry_R3 * Fc2s3_4_2;
    const lanes Nbc22r3 = puma560_geometry_R3 * Fc2s3_4_1 + Nc2s3_4_2;
    const lanes Fbc21e3 = C3 * Fc2s3_4_1 - S3 * Fc2s3_4_2;
    const lanes Fbc22e3 = C3 * Fc2s3_4_2 + S3 * Fc2s3_4_1;
    const lanes Nbc21e3 = C3 * Nbc21r3 - S3 * Nbc22r3;
    const lanes Nbc22e3 = C3 * Nbc22r3 + S3 * Nbc21r3;
    const lanes Nbc22d3 = Nbc22e3 - puma560_geometry_D3 * Fc2s3_4_3;
    const lanes Nbc23d3 = puma560_geometry_D3 * Fbc22e3 + Nc2s3_4_3;
    lanes_put(&C[7], Nbc23d3, stream);
    const lanes Fc2s2_3_1 = Fbc21e3 - h2v1_2;
    const lanes Fc2s2_3_2 = h2v1_1 + Fbc22e3;
    const lanes Nc2s2_3_1 = N2v2_1 + Nbc21e3;
    const lanes Nc2s2_3_2 = N2v2_2 + Nbc22d3;
    const lanes Nbc21r2 = Nc2s2_3_1 - puma560_geometry_R2 * Fc2s2_3_2;
    const lanes Nbc22r2 = puma560_geometry_R2 * Fc2s2_3_1 + Nc2s2_3_2;
    const lanes Nbc22e2 = C2 * Nbc22r2 + S2 * Nbc21r2;
    lanes_put(&C[1], -Nbc22e2, stream);
    const lanes l3_2d4 = puma560_geometry_D4 * W1e3;
    const lanes l3_1d4 = -puma560_geometry_D4 * W33;
    const lanes l3_1e4 = C4 * l3_1d4 + S4 * l3_2d4;
    const lanes l3_2e4 = C4 * l3_2d4 - S4 * l3_1d4;
    const lanes l3_1r4 = puma560_geometry_R4 * e2_2e4 + l3_1e4;
    const lanes l3_2r4 = l3_2e4 - puma560_geometry_R4 * e2_1e4;
    const lanes l3_3r4 = -puma560_geometry_R4 * l2_A3r4;
    const lanes l3_1e5 = C5 * l3_1r4 - S5 * l3_3r4;
    const lanes l3_2e5 = -C5 * l3_3r4 - S5 * l3_1r4;
    const lanes l3_1e6 = C6 * l3_1e5 + S6 * l3_2r4;
    const lanes l3_2e6 = C6 * l3_2r4 - S6 * l3_1e5;
    const lanes N3v3_1 = X[8] * W2e3 + W2e3 * j33v1 - X[9] * W1e3 - X[11] * W33;
    const lanes N3v3_2 = X[9] * W2e3 + X[10] * W33 - W1e3 * j33v1;
    const lanes N4v3_1 = X[16] * e2_1e4 + X[17] * e2_2e4 + X[18] * W1e3 + X[22] * l3_3r4 + W2e4 * k4v2_3 - W34 * k4v2_2;
    const lanes N4v3_2 = X[17] * e2_1e4 + X[19] * W1e3 + W34 * k4v2_1 - X[21] * l3_3r4 - W1e4 * k4v2_3;
    const lanes N4v3_3 = X[18] * e2_1e4 + X[19] * e2_2e4 + X[20] * W1e3 + X[21] * l3_2r4 + W1e4 * k4v2_2 - X[22] * l3_1r4 - W2e4 * k4v2_1;
    const lanes N5v3_1 = X[24] * e2_1e5 + X[25] * e2_2e5 + X[26] * e2_2e4 + X[30] * l3_2r4 + W2e5 * k5v2_3 - W35 * k5v2_2;
    const lanes N5v3_2 = X[25] * e2_1e5 + X[27] * e2_2e4 + W35 * k5v2_1 - X[29] * l3_2r4 - W1e5 * k5v2_3;
    const lanes N5v3_3 = X[26] * e2_1e5 + X[27] * e2_2e5 + X[28] * e2_2e4 + X[29] * l3_2e5 + W1e5 * k5v2_2 - X[30] * l3_1e5 - W2e5 * k5v2_1;
    const lanes N6v3_1 = X[32] * e2_1e6 + X[33] * e2_2e6 + W2e6 * k6v2_3 - X[34] * e2_2e5 - X[38] * l3_2e5 - W36 * k6v2_2;
    const lanes N6v3_2 = X[33] * e2_1e6 + X[37] * l3_2e5 + W36 * k6v2_1 - X[35] * e2_2e5 - W1e6 * k6v2_3;
    const lanes N6v3_3 = X[34] * e2_1e6 + X[35] * e2_2e6 + X[37] * l3_2e6 + W1e6 * k6v2_2 - X[36] * e2_2e5 - X[38] * l3_1e6 - W2e6 * k6v2_1;
    lanes_put(&C[32], N6v3_3, stream);
    const lanes Nbc31e6 = C6 * N6v3_1 - S6 * N6v3_2;
    const lanes Nbc32e6 = C6 * N6v3_2 + S6 * N6v3_1;
    const lanes Nc3s5_6_1 = N5v3_1 + Nbc31e6;
    const lanes Nc3s5_6_2 = N5v3_2 - N6v3_3;
    const lanes Nc3s5_6_3 = N5v3_3 + Nbc32e6;
    lanes_put(&C[26], Nc3s5_6_3, stream);
    const lanes Nbc31e5 = C5 * Nc3s5_6_1 - S5 * Nc3s5_6_2;
    const lanes Nbc32e5 = C5 * Nc3s5_6_2 + S5 * Nc3s5_6_1;
    const lanes Nc3s4_5_1 = N4v3_1 + Nbc31e5;
    const lanes Nc3s4_5_2 = N4v3_2 + Nc3s5_6_3;
    const lanes Nc3s4_5_3 = N4v3_3 - Nbc32e5;
    lanes_put(&C[20], Nc3s4_5_3, stream);
    const lanes Nbc31r4 = Nc3s4_5_1 - puma560_geometry_R4 * Fc2s4_5_2;
    const lanes Nbc32r4 = puma560_geometry_R4 * Fc2s4_5_1 + Nc3s4_5_2;
    const lanes Nbc31e4 = C4 * Nbc31r4 - S4 * Nbc32r4;
    const lanes Nbc32e4 = C4 * Nbc32r4 + S4 * Nbc31r4;
    const lanes Nbc32d4 = Nbc32e4 - puma560_geometry_D4 * Fc2s4_5_3;
    lanes_put(&C[14], Nbc32d4, stream);
    const lanes Nbc33d4 = puma560_geometry_D4 * Fbc22e4 + Nc3s4_5_3;
    const lanes Nc3s3_4_1 = N3v3_1 + Nbc31e4;
    const lanes Nc3s3_4_2 = N3v3_2 - Nbc33d4;
    const lanes Nbc31r3 = Nc3s3_4_1 - puma560_geometry_R3 * Fc2s3_4_2;
    const lanes Nbc32r3 = puma560_geometry_R3 * Fc2s3_4_1 + Nc3s3_4_2;
    const lanes Nbc31e3 = C3 * Nbc31r3 - S3 * Nbc32r3;
    const lanes Nbc32e3 = C3 * Nbc32r3 + S3 * Nbc31r3;
    const lanes Nbc32d3 = Nbc32e3 - puma560_geometry_D3 * Fc2s3_4_3;
    const lanes Nbc33d3 = puma560_geometry_D3 * Fbc22e3 + Nbc32d4;
    lanes_put(&C[8], Nbc33d3, stream);
    const lanes Nbc31r2 = Nbc31e3 - puma560_geometry_R2 * Fbc22e3;
    const lanes Nbc32r2 = puma560_geometry_R2 * Fbc21e3 + Nbc32d3;
    const lanes Nbc32e2 = C2 * Nbc32r2 + S2 * Nbc31r2;
    lanes_put(&C[2], -Nbc32e2, stream);
    const lanes e4_1e5 = C5 * W2e4;
    const lanes e4_2e5 = -S5 * W2e4;
    const lanes E4_1e6 = -S5 * C6;
    const lanes E4_2e6 = S5 * S6;
    const lanes e4_1e6 = C6 * e4_1e5 - S6 * W1e4;
    const lanes e4_2e6 = -C6 * W1e4 - S6 * e4_1e5;
    const lanes F4v4_3 = X[21] * W1e4 + X[22] * W2e4;
    const lanes N4v4_1 = X[16] * W2e4 + W2e4 * j34v1 - X[17] * W1e4 - X[19] * W34;
    const lanes N4v4_2 = X[17] * W2e4 + X[18] * W34 - W1e4 * j34v1;
    const lanes k5v4_1 = -X[25] * C5 - S5 * j15v1;
    const lanes k5v4_2 = C5 * h5v1 - X[25] * S5;
    const lanes k5v4_3 = -X[26] * S5 - X[27] * C5;
    const lanes F5v4_1 = X[30] * W1e4 - C5 * h5v1_3;
    const lanes F5v4_2 = S5 * h5v1_3 - X[29] * W1e4;
    const lanes F5v4_3 = X[30] * e4_1e5 + C5 * h5v1_1 - X[29] * e4_2e5 - S5 * h5v1_2;
    const lanes N5v4_1 = X[24] * e4_1e5 + X[25] * e4_2e5 + W2e5 * k5v4_3 - X[26] * W1e4 - W35 * k5v4_2;
    const lanes N5v4_2 = X[25] * e4_1e5 + W35 * k5v4_1 - X[27] * W1e4 - W1e5 * k5v4_3;
    const lanes N5v4_3 = X[26] * e4_1e5 + X[27] * e4_2e5 + W1e5 * k5v4_2 - X[28] * W1e4 - W2e5 * k5v4_1;
    const lanes k6v4_1 = X[33] * E4_2e6 + X[34] * C5 + j16v1 * E4_1e6;
    const lanes k6v4_2 = X[33] * E4_1e6 + X[35] * C5 - h6v1 * E4_2e6;
    const lanes k6v4_3 = X[34] * E4_1e6 + X[35] * E4_2e6 + C5 * j36v1;
    const lanes F6v4_1 = X[38] * e4_2e5 + h6v1_3 * E4_2e6 - C5 * h6v1_2;
    const lanes F6v4_2 = C5 * h6v1_1 - X[37] * e4_2e5 - h6v1_3 * E4_1e6;
    const lanes F6v4_3 = X[38] * e4_1e6 + h6v1_2 * E4_1e6 - X[37] * e4_2e6 - h6v1_1 * E4_2e6;
    const lanes N6v4_1 = X[32] * e4_1e6 + X[33] * e4_2e6 + W2e6 * k6v4_3 - X[34] * e4_2e5 - W36 * k6v4_2;
    const lanes N6v4_2 = X[33] * e4_1e6 + W36 * k6v4_1 - X[35] * e4_2e5 - W1e6 * k6v4_3;
    const lanes N6v4_3 = X[34] * e4_1e6 + X[35] * e4_2e6 + W1e6 * k6v4_2 - X[36] * e4_2e5 - W2e6 * k6v4_1;
    lanes_put(&C[33], N6v4_3, stream);
    const lanes Fbc41e6 = C6 * F6v4_1 - S6 * F6v4_2;
    const lanes Fbc42e6 = C6 * F6v4_2 + S6 * F6v4_1;
    const lanes Nbc41e6 = C6 * N6v4_1 - S6 * N6v4_2;
    const lanes Nbc42e6 = C6 * N6v4_2 + S6 * N6v4_1;
    const lanes Fc4s5_6_1 = F5v4_1 + Fbc41e6;
    const lanes Fc4s5_6_2 = F5v4_2 - F6v4_3;
    const lanes Fc4s5_6_3 = F5v4_3 + Fbc42e6;
    const lanes Nc4s5_6_1 = N5v4_1 + Nbc41e6;
    const lanes Nc4s5_6_2 = N5v4_2 - N6v4_3;
    const lanes Nc4s5_6_3 = N5v4_3 + Nbc42e6;
    lanes_put(&C[27], Nc4s5_6_3, stream);
    const lanes Fbc41e5 = C5 * Fc4s5_6_1 - S5 * Fc4s5_6_2;
    const lanes Fbc42e5 = C5 * Fc4s5_6_2 + S5 * Fc4s5_6_1;
    const lanes Nbc41e5 = C5 * Nc4s5_6_1 - S5 * Nc4s5_6_2;
    const lanes Nbc42e5 = C5 * Nc4s5_6_2 + S5 * Nc4s5_6_1;
    lanes_put(&C[21], -Nbc42e5, stream);
    const lanes Fc4s4_5_1 = Fbc41e5 - h4v1_2;
    const lanes Fc4s4_5_2 = h4v1_1 + Fc4s5_6_3;
    const lanes Fc4s4_5_3 = F4v4_3 - Fbc42e5;
    const lanes Nc4s4_5_1 = N4v4_1 + Nbc41e5;
    const lanes Nc4s4_5_2 = N4v4_2 + Nc4s5_6_3;
    const lanes Nbc41r4 = Nc4s4_5_1 - puma560_geometry_R4 * Fc4s4_5_2;
    const lanes Nbc42r4 = puma560_geometry_R4 * Fc4s4_5_1 + Nc4s4_5_2;
    const lanes Fbc41e4 = C4 * Fc4s4_5_1 - S4 * Fc4s4_5_2;
    const lanes Fbc42e4 = C4 * Fc4s4_5_2 + S4 * Fc4s4_5_1;
    const lanes Nbc41e4 = C4 * Nbc41r4 - S4 * Nbc42r4;
    const lanes Nbc42e4 = C4 * Nbc42r4 + S4 * Nbc41r4;
    const lanes Nbc42d4 = Nbc42e4 - puma560_geometry_D4 * Fc4s4_5_3;
    lanes_put(&C[15], Nbc42d4, stream);
    const lanes Nbc43d4 = puma560_geometry_D4 * Fbc42e4 - Nbc42e5;
    const lanes Nbc41r3 = puma560_geometry_R3 * Fc4s4_5_3 + Nbc41e4;
    const lanes Nbc42r3 = puma560_geometry_R3 * Fbc41e4 - Nbc43d4;
    const lanes Fbc41e3 = C3 * Fbc41e4 + S3 * Fc4s4_5_3;
    const lanes Fbc42e3 = S3 * Fbc41e4 - C3 * Fc4s4_5_3;
    const lanes Nbc41e3 = C3 * Nbc41r3 - S3 * Nbc42r3;
    const lanes Nbc42e3 = C3 * Nbc42r3 + S3 * Nbc41r3;
    const lanes Nbc42d3 = Nbc42e3 - puma560_geometry_D3 * Fbc42e4;
    const lanes Nbc43d3 = puma560_geometry_D3 * Fbc42e3 + Nbc42d4;
    lanes_put(&C[9], Nbc43d3, stream);
    const lanes Nbc41r2 = Nbc41e3 - puma560_geometry_R2 * Fbc42e3;
    const lanes Nbc42r2 = puma560_geometry_R2 * Fbc41e3 + Nbc42d3;
    const lanes Nbc42e2 = C2 * Nbc42r2 + S2 * Nbc41r2;
    lanes_put(&C[3], -Nbc42e2, stream);
    const lanes e5_1e6 = C6 * W2e5;
    const lanes e5_2e6 = -S6 * W2e5;
    const lanes F5v5_3 = X[29] * W1e5 + X[30] * W2e5;
    const lanes N5v5_1 = X[24] * W2e5 + W2e5 * j35v1 - X[25] * W1e5 - X[27] * W35;
    const lanes N5v5_2 = X[25] * W2e5 + X[26] * W35 - W1e5 * j35v1;
    const lanes k6v5_1 = X[33] * C6 + S6 * j16v1;
    const lanes k6v5_2 = X[33] * S6 - C6 * h6v1;
    const lanes k6v5_3 = X[34] * S6 + X[35] * C6;
    const lanes F6v5_1 = C6 * h6v1_3 - X[38] * W1e5;
    const lanes F6v5_2 = X[37] * W1e5 - S6 * h6v1_3;
    const lanes F6v5_3 = X[38] * e5_1e6 + S6 * h6v1_2 - X[37] * e5_2e6 - C6 * h6v1_1;
    const lanes N6v5_1 = X[32] * e5_1e6 + X[33] * e5_2e6 + X[34] * W1e5 + W2e6 * k6v5_3 - W36 * k6v5_2;
    const lanes N6v5_2 = X[33] * e5_1e6 + X[35] * W1e5 + W36 * k6v5_1 - W1e6 * k6v5_3;
    const lanes N6v5_3 = X[34] * e5_1e6 + X[35] * e5_2e6 + X[36] * W1e5 + W1e6 * k6v5_2 - W2e6 * k6v5_1;
    lanes_put(&C[34], N6v5_3, stream);
    const lanes Fbc51e6 = C6 * F6v5_1 - S6 * F6v5_2;
    const lanes Fbc52e6 = C6 * F6v5_2 + S6 * F6v5_1;
    const lanes Nbc51e6 = C6 * N6v5_1 - S6 * N6v5_2;
    const lanes Nbc52e6 = C6 * N6v5_2 + S6 * N6v5_1;
    lanes_put(&C[28], Nbc52e6, stream);
    const lanes Fc5s5_6_1 = Fbc51e6 - h5v1_2;
    const lanes Fc5s5_6_2 = h5v1_1 - F6v5_3;
    const lanes Fc5s5_6_3 = F5v5_3 + Fbc52e6;
    const lanes Nc5s5_6_1 = N5v5_1 + Nbc51e6;
    const lanes Nc5s5_6_2 = N5v5_2 - N6v5_3;
    const lanes Fbc51e5 = C5 * Fc5s5_6_1 - S5 * Fc5s5_6_2;
    const lanes Fbc52e5 = C5 * Fc5s5_6_2 + S5 * Fc5s5_6_1;
    const lanes Nbc51e5 = C5 * Nc5s5_6_1 - S5 * Nc5s5_6_2;
    const lanes Nbc52e5 = C5 * Nc5s5_6_2 + S5 * Nc5s5_6_1;
    lanes_put(&C[22], -Nbc52e5, stream);
    const lanes Nbc51r4 = Nbc51e5 - puma560_geometry_R4 * Fc5s5_6_3;
    const lanes Nbc52r4 = puma560_geometry_R4 * Fbc51e5 + Nbc52e6;
    const lanes Fbc51e4 = C4 * Fbc51e5 - S4 * Fc5s5_6_3;
    const lanes Fbc52e4 = C4 * Fc5s5_6_3 + S4 * Fbc51e5;
    const lanes Nbc51e4 = C4 * Nbc51r4 - S4 * Nbc52r4;
    const lanes Nbc52e4 = C4 * Nbc52r4 + S4 * Nbc51r4;
    const lanes Nbc52d4 = puma560_geometry_D4 * Fbc52e5 + Nbc52e4;
    lanes_put(&C[16], Nbc52d4, stream);
    const lanes Nbc53d4 = puma560_geometry_D4 * Fbc52e4 - Nbc52e5;
    const lanes Nbc51r3 = Nbc51e4 - puma560_geometry_R3 * Fbc52e5;
    const lanes Nbc52r3 = puma560_geometry_R3 * Fbc51e4 - Nbc53d4;
    const lanes Fbc51e3 = C3 * Fbc51e4 - S3 * Fbc52e5;
    const lanes Fbc52e3 = C3 * Fbc52e5 + S3 * Fbc51e4;
    const lanes Nbc51e3 = C3 * Nbc51r3 - S3 * Nbc52r3;
    const lanes Nbc52e3 = C3 * Nbc52r3 + S3 * Nbc51r3;
    const lanes Nbc52d3 = Nbc52e3 - puma560_geometry_D3 * Fbc52e4;
    const lanes Nbc53d3 = puma560_geometry_D3 * Fbc52e3 + Nbc52d4;
    lanes_put(&C[10], Nbc53d3, stream);
    const lanes Nbc51r2 = Nbc51e3 - puma560_geometry_R2 * Fbc52e3;
    const lanes Nbc52r2 = puma560_geometry_R2 * Fbc51e3 + Nbc52d3;
    const lanes Nbc52e2 = C2 * Nbc52r2 + S2 * Nbc51r2;
    lanes_put(&C[4], -Nbc52e2, stream);
    const lanes F6v6_3 = X[37] * W1e6 + X[38] * W2e6;
    const lanes N6v6_1 = X[32] * W2e6 + W2e6 * j36v1 - X[33] * W1e6 - X[35] * W36;
    const lanes N6v6_2 = X[33] * W2e6 + X[34] * W36 - W1e6 * j36v1;
    const lanes Fbc61e6 = -C6 * h6v1_2 - S6 * h6v1_1;
    const lanes Fbc62e6 = C6 * h6v1_1 - S6 * h6v1_2;
    const lanes Nbc61e6 = C6 * N6v6_1 - S6 * N6v6_2;
    const lanes Nbc62e6 = C6 * N6v6_2 + S6 * N6v6_1;
    lanes_put(&C[29], Nbc62e6, stream);
    const lanes Fbc61e5 = C5 * Fbc61e6 + S5 * F6v6_3;
    const lanes Fbc62e5 = S5 * Fbc61e6 - C5 * F6v6_3;
    const lanes Nbc61e5 = C5 * Nbc61e6;
    const lanes Nbc62e5 = S5 * Nbc61e6;
    lanes_put(&C[23], -Nbc62e5, stream);
    const lanes Nbc61r4 = Nbc61e5 - puma560_geometry_R4 * Fbc62e6;
    const lanes Nbc62r4 = puma560_geometry_R4 * Fbc61e5 + Nbc62e6;
    const lanes Fbc61e4 = C4 * Fbc61e5 - S4 * Fbc62e6;
    const lanes Fbc62e4 = C4 * Fbc62e6 + S4 * Fbc61e5;
    const lanes Nbc61e4 = C4 * Nbc61r4 - S4 * Nbc62r4;
    const lanes Nbc62e4 = C4 * Nbc62r4 + S4 * Nbc61r4;
    const lanes Nbc62d4 = puma560_geometry_D4 * Fbc62e5 + Nbc62e4;
    lanes_put(&C[17], Nbc62d4, stream);
    const lanes Nbc63d4 = puma560_geometry_D4 * Fbc62e4 - Nbc62e5;
    const lanes Nbc61r3 = Nbc61e4 - puma560_geometry_R3 * Fbc62e5;
    const lanes Nbc62r3 = puma560_geometry_R3 * Fbc61e4 - Nbc63d4;
    const lanes Fbc61e3 = C3 * Fbc61e4 - S3 * Fbc62e5;
    const lanes Fbc62e3 = C3 * Fbc62e5 + S3 * Fbc61e4;
    const lanes Nbc61e3 = C3 * Nbc61r3 - S3 * Nbc62r3;
    const lanes Nbc62e3 = C3 * Nbc62r3 + S3 * Nbc61r3;
    const lanes Nbc62d3 = Nbc62e3 - puma560_geometry_D3 * Fbc62e4;
    const lanes Nbc63d3 = puma560_geometry_D3 * Fbc62e3 + Nbc62d4;
    lanes_put(&C[11], Nbc63d3, stream);
    const lanes Nbc61r2 = Nbc61e3 - puma560_geometry_R2 * Fbc62e3;
    const lanes Nbc62r2 = puma560_geometry_R2 * Fbc61e3 + Nbc62d3;
    const lanes Nbc62e2 = C2 * Nbc62r2 + S2 * Nbc61r2;
    lanes_put(&C[5], -Nbc62e2, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *C)
{
    return panel(q, qd, X, C, 0);
}

int puma560_coriolis_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
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
    lanes lanes_C[BLOCKS(36u)];
    double scratch[36u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_C, 0, sizeof lanes_C);
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
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_C);
        lanes_store(lanes_C, 36u, count, stream, scratch, &C[k * 36u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *C)
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
        apart *lanes_C = (apart *)&C[k * 36u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_C, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_C);
    }
    return status;
}

int puma560_coriolis_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    if (!(streamed(stream, C))) {
        return panels(0, N, strides, q, qd, X, C);
    }
    const int status = panels(1, N, strides, q, qd, X, C);
    stream_end();
    return status;
}

#else

int puma560_coriolis_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_coriolis(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &C[k * 36u]);
    }
    return status;
}

int puma560_coriolis_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    return puma560_coriolis_rows(stream, N, strides, q, qd, X, C);
}

#endif

size_t puma560_coriolis_width(void)
{
    return puma560_WIDTH;
}

void puma560_coriolis_batch(size_t N, const double *q, const double *qd, const double *X, double *C)
{
    (void)puma560_coriolis_rows(0, N, NULL, q, qd, X, C);
}
