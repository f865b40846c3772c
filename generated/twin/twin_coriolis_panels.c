/* twin: coriolis of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *C, const int stream)
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
    const lanes W1e2 = qd[0] * S2;
    const lanes W2e2 = qd[0] * C2;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes W33 = qd[1] + qd[2];
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes W34 = qd[3] - W2e3;
    const lanes W1e5 = qd[0] * S5;
    const lanes W2e5 = qd[0] * C5;
    const lanes W1e7 = C7 * W1e5 + S7 * W2e5;
    const lanes W2e7 = C7 * W2e5 - S7 * W1e5;
    const lanes W37 = qd[4] + qd[6];
    const lanes l1_1d2 = -qd[0] * d2;
    const lanes l1_1e2 = C2 * l1_1d2;
    const lanes l1_2e2 = -S2 * l1_1d2;
    const lanes l1_P12d3 = S2 * W2e2;
    const lanes l1_2d3 = d3 * l1_P12d3 + l1_2e2;
    const lanes l1_P13d3 = qd[1] * S2;
    const lanes l1_3d3 = d3 * l1_P13d3;
    const lanes l1_P22d3 = C2 * W2e2;
    const lanes l1_1d3 = l1_1e2 - d3 * l1_P22d3;
    const lanes E1_1e3 = C2 * S3 + S2 * C3;
    const lanes E1_2e3 = C2 * C3 - S2 * S3;
    const lanes l1_1e3 = C3 * l1_1d3 + S3 * l1_2d3;
    const lanes l1_2e3 = C3 * l1_2d3 - S3 * l1_1d3;
    const lanes E1_1e4 = C4 * E1_1e3;
    const lanes E1_2e4 = -S4 * E1_1e3;
    const lanes l1_1e4 = C4 * l1_1e3 + S4 * l1_3d3;
    const lanes l1_2e4 = C4 * l1_3d3 - S4 * l1_1e3;
    const lanes l1_P31r4 = -W1e4 * E1_2e3;
    const lanes l1_1r4 = r4 * l1_P31r4 + l1_1e4;
    const lanes l1_P32r4 = -W2e4 * E1_2e3;
    const lanes l1_2r4 = r4 * l1_P32r4 + l1_2e4;
    const lanes l1_P11r4 = W1e4 * E1_1e4;
    const lanes l1_P22r4 = W2e4 * E1_2e4;
    const lanes l1_A3r4 = l1_P11r4 + l1_P22r4;
    const lanes l1_3r4 = -r4 * l1_A3r4 - l1_2e3;
    const lanes l1_1e5 = C5 * l1_1d2;
    const lanes l1_2e5 = -S5 * l1_1d2;
    const lanes l1_P31r6 = -C5 * W1e5;
    const lanes l1_1r6 = R6 * l1_P31r6 + l1_1e5;
    const lanes l1_P32r6 = -qd[4] * C5;
    const lanes l1_2r6 = R6 * l1_P32r6;
    const lanes l1p6_2 = l1_2r6 - qd[5] * S5;
    const lanes l1_P11r6 = S5 * W1e5;
    const lanes l1_3r6 = -R6 * l1_P11r6 - l1_2e5;
    const lanes E1_1e7 = C5 * S7 + S5 * C7;
    const lanes E1_2e7 = C5 * C7 - S5 * S7;
    const lanes l1_1e7 = C7 * l1_1r6 - S7 * l1_3r6;
    const lanes l1_2e7 = -C7 * l1_3r6 - S7 * l1_1r6;
    const lanes h2v1_1 = -qd[1] * X[7];
    const lanes h2v1_2 = qd[1] * X[6];
    const lanes F2v1_3 = S2 * h2v1_2 - C2 * h2v1_1;
    const lanes t2v1 = X[1] + X[5];
    const lanes h2v1 = 0.5 * t2v1;
    const lanes j12v1 = X[1] - h2v1;
    const lanes k2v1_1 = X[2] * C2 + S2 * j12v1;
    const lanes j32v1 = X[5] - h2v1;
    const lanes k2v1_2 = X[2] * S2 - C2 * h2v1;
    const lanes N2v1_3 = X[6] * l1_2e2 + W1e2 * k2v1_2 - X[7] * l1_1e2 - W2e2 * k2v1_1;
    const lanes k2v1_3 = X[3] * S2 + X[4] * C2;
    const lanes N2v1_1 = W2e2 * k2v1_3 - qd[1] * k2v1_2;
    const lanes N2v1_2 = qd[1] * k2v1_1 - W1e2 * k2v1_3;
    const lanes h3v1_1 = -X[14] * W33;
    const lanes h3v1_2 = X[13] * W33;
    const lanes h3v1_3 = X[14] * W1e3 - X[13] * W2e3;
    const lanes t3v1 = X[8] + X[12];
    const lanes h3v1 = 0.5 * t3v1;
    const lanes j13v1 = X[8] - h3v1;
    const lanes k3v1_1 = X[9] * E1_2e3 + E1_1e3 * j13v1;
    const lanes j33v1 = X[12] - h3v1;
    const lanes k3v1_2 = X[9] * E1_1e3 - E1_2e3 * h3v1;
    const lanes N3v1_3 = X[13] * l1_2e3 + W1e3 * k3v1_2 - X[14] * l1_1e3 - W2e3 * k3v1_1;
    const lanes k3v1_3 = X[10] * E1_1e3 + X[11] * E1_2e3;
    const lanes N3v1_1 = X[14] * l1_3d3 + W2e3 * k3v1_3 - W33 * k3v1_2;
    const lanes N3v1_2 = W33 * k3v1_1 - X[13] * l1_3d3 - W1e3 * k3v1_3;
    const lanes F3v1_1 = E1_2e3 * h3v1_3;
    const lanes F3v1_2 = -E1_1e3 * h3v1_3;
    const lanes F3v1_3 = E1_1e3 * h3v1_2 - E1_2e3 * h3v1_1;
    const lanes h4v1_1 = -X[22] * W34;
    const lanes h4v1_2 = X[21] * W34;
    const lanes h4v1_3 = X[22] * W1e4 - X[21] * W2e4;
    const lanes t4v1 = X[16] + X[20];
    const lanes h4v1 = 0.5 * t4v1;
    const lanes j14v1 = X[16] - h4v1;
    const lanes j34v1 = X[20] - h4v1;
    const lanes k4v1_1 = X[17] * E1_2e4 + E1_1e4 * j14v1 - X[18] * E1_2e3;
    const lanes k4v2_1 = X[17] * C4 + S4 * j14v1;
    const lanes k4v1_2 = X[17] * E1_1e4 - X[19] * E1_2e3 - E1_2e4 * h4v1;
    const lanes N4v1_3 = X[21] * l1_2r4 + W1e4 * k4v1_2 - X[22] * l1_1r4 - W2e4 * k4v1_1;
    lanes_put(&C[21], N4v1_3, stream);
    const lanes Nc1s3_4_2 = N3v1_2 - N4v1_3;
    const lanes k4v2_2 = X[17] * S4 - C4 * h4v1;
    const lanes k4v1_3 = X[18] * E1_1e4 + X[19] * E1_2e4 - E1_2e3 * j34v1;
    const lanes N4v1_1 = X[22] * l1_3r4 + W2e4 * k4v1_3 - W34 * k4v1_2;
    const lanes N4v1_2 = W34 * k4v1_1 - X[21] * l1_3r4 - W1e4 * k4v1_3;
    const lanes F4v1_1 = E1_2e3 * h4v1_2 + E1_2e4 * h4v1_3;
    const lanes F4v1_2 = -E1_2e3 * h4v1_1 - E1_1e4 * h4v1_3;
    const lanes F4v1_3 = E1_1e4 * h4v1_2 - E1_2e4 * h4v1_1;
    const lanes Nbc11r4 = N4v1_1 - r4 * F4v1_2;
    const lanes Nbc12r4 = r4 * F4v1_1 + N4v1_2;
    const lanes Fc1s3_4_2 = F3v1_2 - F4v1_3;
    const lanes h5v1_1 = -qd[4] * X[30];
    const lanes h5v1_2 = qd[4] * X[29];
    const lanes F5v1_3 = S5 * h5v1_2 - C5 * h5v1_1;
    const lanes t5v1 = X[24] + X[28];
    const lanes h5v1 = 0.5 * t5v1;
    const lanes j15v1 = X[24] - h5v1;
    const lanes k5v1_1 = X[25] * C5 + S5 * j15v1;
    const lanes j35v1 = X[28] - h5v1;
    const lanes k5v1_2 = X[25] * S5 - C5 * h5v1;
    const lanes N5v1_3 = X[29] * l1_2e5 + W1e5 * k5v1_2 - X[30] * l1_1e5 - W2e5 * k5v1_1;
    const lanes k5v1_3 = X[26] * S5 + X[27] * C5;
    const lanes N5v1_1 = W2e5 * k5v1_3 - qd[4] * k5v1_2;
    const lanes N5v1_2 = qd[4] * k5v1_1 - W1e5 * k5v1_3;
    const lanes h6v1_1 = qd[4] * X[33] + X[32] * W2e5;
    const lanes h6v1_2 = -X[31] * W2e5 - X[33] * W1e5;
    const lanes h6v1_3 = X[32] * W1e5 - qd[4] * X[31];
    const lanes F6v1_1 = X[34] * l1_1r6 + C5 * h6v1_2;
    const lanes F6v1_3 = X[34] * l1_3r6 + S5 * h6v1_2;
    const lanes F6v1_2 = X[34] * l1p6_2 - C5 * h6v1_1 - S5 * h6v1_3;
    const lanes F6v5_1 = qd[5] * X[34] + h6v1_3 - X[32] * W1e5;
    const lanes N6v1_1 = X[32] * l1_3r6 - X[33] * l1p6_2;
    const lanes N6v1_2 = X[33] * l1_1r6 - X[31] * l1_3r6;
    const lanes N6v1_3 = X[31] * l1p6_2 - X[32] * l1_1r6;
    const lanes h7v1_1 = -X[42] * W37;
    const lanes h7v1_2 = X[41] * W37;
    const lanes h7v1_3 = X[42] * W1e7 - X[41] * W2e7;
    const lanes t7v1 = X[36] + X[40];
    const lanes h7v1 = 0.5 * t7v1;
    const lanes j17v1 = X[36] - h7v1;
    const lanes k7v1_1 = X[37] * E1_2e7 + E1_1e7 * j17v1;
    const lanes j37v1 = X[40] - h7v1;
    const lanes k7v1_2 = X[37] * E1_1e7 - E1_2e7 * h7v1;
    const lanes N7v1_3 = X[41] * l1_2e7 + W1e7 * k7v1_2 - X[42] * l1_1e7 - W2e7 * k7v1_1;
    lanes_put(&C[42], N7v1_3, stream);
    const lanes Nc1s6_7_2 = N6v1_2 + N7v1_3;
    const lanes k7v1_3 = X[38] * E1_1e7 + X[39] * E1_2e7;
    const lanes N7v1_1 = X[42] * l1p6_2 + W2e7 * k7v1_3 - W37 * k7v1_2;
    const lanes N7v1_2 = W37 * k7v1_1 - X[41] * l1p6_2 - W1e7 * k7v1_3;
    const lanes F7v1_1 = E1_2e7 * h7v1_3;
    const lanes F7v1_2 = -E1_1e7 * h7v1_3;
    const lanes F7v1_3 = E1_1e7 * h7v1_2 - E1_2e7 * h7v1_1;
    const lanes Fc1s6_7_2 = F6v1_2 + F7v1_3;
    const lanes Fc1s5_6_3 = F5v1_3 + Fc1s6_7_2;
    const lanes Fbc11e7 = C7 * F7v1_1 - S7 * F7v1_2;
    const lanes Fbc12e7 = C7 * F7v1_2 + S7 * F7v1_1;
    const lanes Fc1s6_7_1 = F6v1_1 + Fbc11e7;
    const lanes Fc1s6_7_3 = F6v1_3 - Fbc12e7;
    lanes_put(&C[35], Fc1s6_7_3, stream);
    const lanes Nbc12r6 = R6 * Fc1s6_7_1 + Nc1s6_7_2;
    const lanes Nc1s5_6_3 = N5v1_3 + Nbc12r6;
    lanes_put(&C[28], Nc1s5_6_3, stream);
    const lanes Nbc11e7 = C7 * N7v1_1 - S7 * N7v1_2;
    const lanes Nbc12e7 = C7 * N7v1_2 + S7 * N7v1_1;
    const lanes Nc1s6_7_1 = N6v1_1 + Nbc11e7;
    const lanes Nc1s6_7_3 = N6v1_3 - Nbc12e7;
    const lanes Nbc11r6 = Nc1s6_7_1 - R6 * Fc1s6_7_2;
    const lanes Nc1s5_6_1 = N5v1_1 + Nbc11r6;
    const lanes Nc1s5_6_2 = N5v1_2 - Nc1s6_7_3;
    const lanes Nbc12e5 = C5 * Nc1s5_6_2 + S5 * Nc1s5_6_1;
    const lanes Nbc12d5 = Nbc12e5 - d2 * Fc1s5_6_3;
    const lanes Fbc11e4 = C4 * F4v1_1 - S4 * F4v1_2;
    const lanes Fbc12e4 = C4 * F4v1_2 + S4 * F4v1_1;
    const lanes Fc1s3_4_1 = F3v1_1 + Fbc11e4;
    const lanes Fc1s3_4_3 = F3v1_3 + Fbc12e4;
    const lanes Fbc12e3 = C3 * Fc1s3_4_2 + S3 * Fc1s3_4_1;
    const lanes Fc1s2_3_3 = F2v1_3 + Fc1s3_4_3;
    const lanes Nbc11e4 = C4 * Nbc11r4 - S4 * Nbc12r4;
    const lanes Nbc12e4 = C4 * Nbc12r4 + S4 * Nbc11r4;
    const lanes Nc1s3_4_1 = N3v1_1 + Nbc11e4;
    const lanes Nc1s3_4_3 = N3v1_3 + Nbc12e4;
    lanes_put(&C[14], Nc1s3_4_3, stream);
    const lanes Nbc13d3 = d3 * Fbc12e3 + Nc1s3_4_3;
    const lanes Nc1s2_3_3 = N2v1_3 + Nbc13d3;
    lanes_put(&C[7], Nc1s2_3_3, stream);
    const lanes Nbc11e3 = C3 * Nc1s3_4_1 - S3 * Nc1s3_4_2;
    const lanes Nbc12e3 = C3 * Nc1s3_4_2 + S3 * Nc1s3_4_1;
    const lanes Nbc12d3 = Nbc12e3 - d3 * Fc1s3_4_3;
    const lanes Nc1s2_3_1 = N2v1_1 + Nbc11e3;
    const lanes Nc1s2_3_2 = N2v1_2 + Nbc12d3;
    const lanes Nbc12e2 = C2 * Nc1s2_3_2 + S2 * Nc1s2_3_1;
    const lanes Nbc12d2 = Nbc12e2 - d2 * Fc1s2_3_3;
    const lanes Nc1s1_2_3 = Nbc12d5 + Nbc12d2;
    lanes_put(&C[0], Nc1s1_2_3, stream);
    const lanes l2_3d3 = d3 * W1e2;
    const lanes l2_1d3 = -qd[1] * d3;
    const lanes l2_1e3 = C3 * l2_1d3;
    const lanes l2_2e3 = -S3 * l2_1d3;
    const lanes e2_1e4 = C4 * W2e3;
    const lanes e2_2e4 = -S4 * W2e3;
    const lanes l2_1e4 = C4 * l2_1e3 + S4 * l2_3d3;
    const lanes l2_1r4 = r4 * e2_2e4 + l2_1e4;
    const lanes l2_2e4 = C4 * l2_3d3 - S4 * l2_1e3;
    const lanes l2_2r4 = l2_2e4 - r4 * e2_1e4;
    const lanes N3v2_3 = X[13] * l2_2e3 - X[14] * l2_1e3;
    const lanes N4v2_3 = X[18] * e2_1e4 + X[19] * e2_2e4 + X[20] * W1e3 + X[21] * l2_2r4 + W1e4 * k4v2_2 - X[22] * l2_1r4 - W2e4 * k4v2_1;
    lanes_put(&C[22], N4v2_3, stream);
    const lanes l2_P11r4 = S4 * W1e4;
    const lanes l2_P22r4 = C4 * W2e4;
    const lanes l2_A3r4 = l2_P11r4 + l2_P22r4;
    const lanes l2_3r4 = -r4 * l2_A3r4 - l2_2e3;
    const lanes l3_3r4 = -r4 * l2_A3r4;
    const lanes F2v2_3 = X[6] * W1e2 + X[7] * W2e2;
    const lanes N2v2_1 = X[1] * W2e2 + W2e2 * j32v1 - qd[1] * X[4] - X[2] * W1e2;
    const lanes N2v2_2 = qd[1] * X[3] + X[2] * W2e2 - W1e2 * j32v1;
    const lanes F3v2_3 = X[13] * W1e3 + X[14] * W2e3;
    const lanes N3v2_1 = X[8] * W2e3 + X[14] * l2_3d3 + W2e3 * j33v1 - X[9] * W1e3 - X[11] * W33;
    const lanes N3v2_2 = X[9] * W2e3 + X[10] * W33 - X[13] * l2_3d3 - W1e3 * j33v1;
    const lanes Nc2s3_4_2 = N3v2_2 - N4v2_3;
    const lanes k4v2_3 = X[18] * S4 + X[19] * C4;
    const lanes F4v2_1 = C4 * h4v1_3 - X[22] * W1e3;
    const lanes F4v2_2 = X[21] * W1e3 - S4 * h4v1_3;
    const lanes F4v2_3 = X[22] * e2_1e4 + S4 * h4v1_2 - X[21] * e2_2e4 - C4 * h4v1_1;
    const lanes Fc2s3_4_2 = h3v1_1 - F4v2_3;
    const lanes N4v2_1 = X[16] * e2_1e4 + X[17] * e2_2e4 + X[18] * W1e3 + X[22] * l2_3r4 + W2e4 * k4v2_3 - W34 * k4v2_2;
    const lanes N4v2_2 = X[17] * e2_1e4 + X[19] * W1e3 + W34 * k4v2_1 - X[21] * l2_3r4 - W1e4 * k4v2_3;
    const lanes Nbc21r4 = N4v2_1 - r4 * F4v2_2;
    const lanes Nbc22r4 = r4 * F4v2_1 + N4v2_2;
    const lanes Fbc21e4 = C4 * F4v2_1 - S4 * F4v2_2;
    const lanes Fc2s3_4_1 = Fbc21e4 - h3v1_2;
    const lanes Fbc22e3 = C3 * Fc2s3_4_2 + S3 * Fc2s3_4_1;
    const lanes Fbc22e4 = C4 * F4v2_2 + S4 * F4v2_1;
    const lanes Fc2s3_4_3 = F3v2_3 + Fbc22e4;
    const lanes Fc2s2_3_3 = F2v2_3 + Fc2s3_4_3;
    const lanes Nbc21e4 = C4 * Nbc21r4 - S4 * Nbc22r4;
    const lanes Nbc22e4 = C4 * Nbc22r4 + S4 * Nbc21r4;
    const lanes Nc2s3_4_1 = N3v2_1 + Nbc21e4;
    const lanes Nc2s3_4_3 = N3v2_3 + Nbc22e4;
    lanes_put(&C[15], Nc2s3_4_3, stream);
    const lanes Nbc23d3 = d3 * Fbc22e3 + Nc2s3_4_3;
    lanes_put(&C[8], Nbc23d3, stream);
    const lanes Nbc21e3 = C3 * Nc2s3_4_1 - S3 * Nc2s3_4_2;
    const lanes Nbc22e3 = C3 * Nc2s3_4_2 + S3 * Nc2s3_4_1;
    const lanes Nbc22d3 = Nbc22e3 - d3 * Fc2s3_4_3;
    const lanes Nc2s2_3_1 = N2v2_1 + Nbc21e3;
    const lanes Nc2s2_3_2 = N2v2_2 + Nbc22d3;
    const lanes Nbc22e2 = C2 * Nc2s2_3_2 + S2 * Nc2s2_3_1;
    const lanes Nbc22d2 = Nbc22e2 - d2 * Fc2s2_3_3;
    lanes_put(&C[1], Nbc22d2, stream);
    const lanes l3_1r4 = r4 * e2_2e4;
    const lanes l3_2r4 = -r4 * e2_1e4;
    const lanes N4v3_3 = X[18] * e2_1e4 + X[19] * e2_2e4 + X[20] * W1e3 + X[21] * l3_2r4 + W1e4 * k4v2_2 - X[22] * l3_1r4 - W2e4 * k4v2_1;
    lanes_put(&C[23], N4v3_3, stream);
    const lanes N4v3_1 = X[16] * e2_1e4 + X[17] * e2_2e4 + X[18] * W1e3 + X[22] * l3_3r4 + W2e4 * k4v2_3 - W34 * k4v2_2;
    const lanes N4v3_2 = X[17] * e2_1e4 + X[19] * W1e3 + W34 * k4v2_1 - X[21] * l3_3r4 - W1e4 * k4v2_3;
    const lanes Nbc31r4 = N4v3_1 - r4 * F4v2_2;
    const lanes Nbc32r4 = r4 * F4v2_1 + N4v3_2;
    const lanes N3v3_1 = X[8] * W2e3 + W2e3 * j33v1 - X[9] * W1e3 - X[11] * W33;
    const lanes N3v3_2 = X[9] * W2e3 + X[10] * W33 - W1e3 * j33v1;
    const lanes Nc3s3_4_2 = N3v3_2 - N4v3_3;
    const lanes Nbc31e4 = C4 * Nbc31r4 - S4 * Nbc32r4;
    const lanes Nbc32e4 = C4 * Nbc32r4 + S4 * Nbc31r4;
    lanes_put(&C[16], Nbc32e4, stream);
    const lanes Nc3s3_4_1 = N3v3_1 + Nbc31e4;
    const lanes Nbc33d3 = d3 * Fbc22e3 + Nbc32e4;
    lanes_put(&C[9], Nbc33d3, stream);
    const lanes Nbc31e3 = C3 * Nc3s3_4_1 - S3 * Nc3s3_4_2;
    const lanes Nbc32e3 = C3 * Nc3s3_4_2 + S3 * Nc3s3_4_1;
    const lanes Nbc32d3 = Nbc32e3 - d3 * Fc2s3_4_3;
    const lanes Nbc32e2 = C2 * Nbc32d3 + S2 * Nbc31e3;
    const lanes Nbc32d2 = Nbc32e2 - d2 * Fc2s3_4_3;
    lanes_put(&C[2], Nbc32d2, stream);
    const lanes F4v4_3 = X[21] * W1e4 + X[22] * W2e4;
    const lanes N4v4_1 = X[16] * W2e4 + W2e4 * j34v1 - X[17] * W1e4 - X[19] * W34;
    const lanes N4v4_2 = X[17] * W2e4 + X[18] * W34 - W1e4 * j34v1;
    const lanes Nbc41r4 = N4v4_1 - r4 * h4v1_1;
    const lanes Nbc42r4 = N4v4_2 - r4 * h4v1_2;
    const lanes Fbc41e4 = -C4 * h4v1_2 - S4 * h4v1_1;
    const lanes Fbc42e4 = C4 * h4v1_1 - S4 * h4v1_2;
    const lanes Fbc42e3 = S3 * Fbc41e4 - C3 * F4v4_3;
    const lanes Nbc41e4 = C4 * Nbc41r4 - S4 * Nbc42r4;
    const lanes Nbc42e4 = C4 * Nbc42r4 + S4 * Nbc41r4;
    lanes_put(&C[17], Nbc42e4, stream);
    const lanes Nbc41e3 = C3 * Nbc41e4;
    const lanes Nbc42e3 = S3 * Nbc41e4;
    const lanes Nbc42d3 = Nbc42e3 - d3 * Fbc42e4;
    const lanes Nbc43d3 = d3 * Fbc42e3 + Nbc42e4;
    lanes_put(&C[10], Nbc43d3, stream);
    const lanes Nbc42e2 = C2 * Nbc42d3 + S2 * Nbc41e3;
    const lanes Nbc42d2 = Nbc42e2 - d2 * Fbc42e4;
    lanes_put(&C[3], Nbc42d2, stream);
    const lanes l5_2r6 = -R6 * W2e5;
    const lanes l5_3r6 = -qd[4] * R6;
    const lanes F6v5_3 = X[32] * W2e5 + X[34] * l5_3r6 - h6v1_1;
    const lanes l5_1e7 = qd[5] * C7 - S7 * l5_3r6;
    const lanes l5_2e7 = -qd[5] * S7 - C7 * l5_3r6;
    const lanes N7v5_3 = X[41] * l5_2e7 - X[42] * l5_1e7;
    lanes_put(&C[46], N7v5_3, stream);
    const lanes F5v5_3 = X[29] * W1e5 + X[30] * W2e5;
    const lanes N5v5_1 = X[24] * W2e5 + W2e5 * j35v1 - qd[4] * X[27] - X[25] * W1e5;
    const lanes N5v5_2 = qd[4] * X[26] + X[25] * W2e5 - W1e5 * j35v1;
    const lanes F6v5_2 = X[31] * W1e5 + X[34] * l5_2r6 - X[33] * W2e5;
    const lanes N6v5_1 = X[32] * l5_3r6 - X[33] * l5_2r6;
    const lanes N6v5_2 = qd[5] * X[33] - X[31] * l5_3r6;
    const lanes Nc5s6_7_2 = N6v5_2 + N7v5_3;
    const lanes N6v5_3 = X[31] * l5_2r6 - qd[5] * X[32];
    const lanes F7v5_3 = X[41] * W1e7 + X[42] * W2e7;
    const lanes Fc5s6_7_2 = F6v5_2 + F7v5_3;
    const lanes Fc5s5_6_3 = F5v5_3 + Fc5s6_7_2;
    const lanes N7v5_1 = X[36] * W2e7 + X[42] * l5_2r6 + W2e7 * j37v1 - X[37] * W1e7 - X[39] * W37;
    const lanes N7v5_2 = X[37] * W2e7 + X[38] * W37 - X[41] * l5_2r6 - W1e7 * j37v1;
    const lanes Fbc51e7 = -C7 * h7v1_2 - S7 * h7v1_1;
    const lanes Fbc52e7 = C7 * h7v1_1 - S7 * h7v1_2;
    lanes_put(&C[41], -Fbc52e7, stream);
    const lanes Fc5s6_7_1 = F6v5_1 + Fbc51e7;
    const lanes Fc5s6_7_3 = F6v5_3 - Fbc52e7;
    lanes_put(&C[39], Fc5s6_7_3, stream);
    const lanes Nbc52r6 = R6 * Fc5s6_7_1 + Nc5s6_7_2;
    lanes_put(&C[32], Nbc52r6, stream);
    const lanes Nbc72r6 = R6 * Fbc51e7;
    lanes_put(&C[34], Nbc72r6, stream);
    const lanes Nbc51e7 = C7 * N7v5_1 - S7 * N7v5_2;
    const lanes Nbc52e7 = C7 * N7v5_2 + S7 * N7v5_1;
    const lanes Nc5s6_7_1 = N6v5_1 + Nbc51e7;
    const lanes Nc5s6_7_3 = N6v5_3 - Nbc52e7;
    const lanes Nbc51r6 = Nc5s6_7_1 - R6 * Fc5s6_7_2;
    const lanes Nc5s5_6_1 = N5v5_1 + Nbc51r6;
    const lanes Nc5s5_6_2 = N5v5_2 - Nc5s6_7_3;
    const lanes Nbc52e5 = C5 * Nc5s5_6_2 + S5 * Nc5s5_6_1;
    const lanes Nbc52d5 = Nbc52e5 - d2 * Fc5s5_6_3;
    lanes_put(&C[4], Nbc52d5, stream);
    const lanes l6_1e7 = qd[4] * C7;
    const lanes l6_2e7 = -qd[4] * S7;
    const lanes N7v6_3 = X[41] * l6_2e7 - X[42] * l6_1e7;
    lanes_put(&C[47], N7v6_3, stream);
    const lanes F6v6_1 = qd[4] * X[34];
    const lanes F6v6_2 = -X[34] * W1e5;
    const lanes N6v6_1 = X[33] * W1e5;
    const lanes N6v6_2 = qd[4] * X[33];
    const lanes Nc6s6_7_2 = N6v6_2 + N7v6_3;
    const lanes Nbc62r6 = R6 * F6v6_1 + Nc6s6_7_2;
    lanes_put(&C[33], Nbc62r6, stream);
    const lanes N6v6_3 = -qd[4] * X[32] - X[31] * W1e5;
    const lanes N7v6_1 = -X[42] * W1e5;
    const lanes N7v6_2 = X[41] * W1e5;
    const lanes Nbc61e7 = C7 * N7v6_1 - S7 * N7v6_2;
    const lanes Nbc62e7 = C7 * N7v6_2 + S7 * N7v6_1;
    const lanes Nc6s6_7_1 = N6v6_1 + Nbc61e7;
    const lanes Nc6s6_7_3 = N6v6_3 - Nbc62e7;
    const lanes Nbc61r6 = Nc6s6_7_1 - R6 * F6v6_2;
    const lanes Nbc62e5 = S5 * Nbc61r6 - C5 * Nc6s6_7_3;
    const lanes Nbc62d5 = Nbc62e5 - d2 * F6v6_2;
    lanes_put(&C[5], Nbc62d5, stream);
    const lanes N7v7_1 = X[36] * W2e7 + W2e7 * j37v1 - X[37] * W1e7 - X[39] * W37;
    const lanes N7v7_2 = X[37] * W2e7 + X[38] * W37 - W1e7 * j37v1;
    const lanes Nbc71e7 = C7 * N7v7_1 - S7 * N7v7_2;
    const lanes Nbc72e7 = C7 * N7v7_2 + S7 * N7v7_1;
    const lanes Nbc71r6 = Nbc71e7 - R6 * F7v5_3;
    const lanes Nbc72e5 = C5 * Nbc72e7 + S5 * Nbc71r6;
    const lanes Nbc72d5 = Nbc72e5 - d2 * F7v5_3;
    lanes_put(&C[6], Nbc72d5, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *C)
{
    return panel(q, qd, X, C, 0);
}

int twin_coriolis_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(44u)];
    lanes lanes_X[BLOCKS(44u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 44u, lanes_X);
    lanes lanes_C[BLOCKS(49u)];
    double scratch[49u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_C, 0, sizeof lanes_C);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 44u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_C);
        lanes_store(lanes_C, 49u, count, stream, scratch, &C[k * 49u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *C)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_X[REACH(44u)];
    lanes lanes_X[BLOCKS(44u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(X, 44u, lanes_X);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 44u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_C = (apart *)&C[k * 49u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_C, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_C);
    }
    return status;
}

int twin_coriolis_panels(int stream, size_t N, const size_t *strides,
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

int twin_coriolis_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_coriolis(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &C[k * 49u]);
    }
    return status;
}

int twin_coriolis_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C)
{
    return twin_coriolis_rows(stream, N, strides, q, qd, X, C);
}

#endif

size_t twin_coriolis_width(void)
{
    return twin_WIDTH;
}

void twin_coriolis_batch(size_t N, const double *q, const double *qd, const double *X, double *C)
{
    (void)twin_coriolis_rows(0, N, NULL, q, qd, X, C);
}
