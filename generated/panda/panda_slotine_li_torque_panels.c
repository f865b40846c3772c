/* panda: slotine_li_torque of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    const double gz = 9.81;
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
    const lanes W1e2 = -qd[0] * S2;
    const lanes W2e2 = -qd[0] * C2;
    const lanes W1e3 = qd[1] * S3 + C3 * W1e2;
    const lanes W2e3 = qd[1] * C3 - S3 * W1e2;
    const lanes W33 = qd[2] - W2e2;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes W34 = qd[3] - W2e3;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes W36 = qd[5] - W2e5;
    const lanes W1e7 = C7 * W1e6 + S7 * W36;
    const lanes W2e7 = C7 * W36 - S7 * W1e6;
    const lanes W37 = qd[6] - W2e6;
    const lanes E1e2 = -qdr[0] * S2;
    const lanes E2e2 = -qdr[0] * C2;
    const lanes e1e2 = -qddr[0] * S2;
    const lanes e1j2 = qdr[1] * W2e2 + e1e2;
    const lanes e2e2 = -qddr[0] * C2;
    const lanes e2j2 = e2e2 - qdr[1] * W1e2;
    const lanes l1e2 = -gz * S2;
    const lanes l2e2 = -gz * C2;
    const lanes E1e3 = qdr[1] * S3 + C3 * E1e2;
    const lanes E2e3 = qdr[1] * C3 - S3 * E1e2;
    const lanes e1e3 = qddr[1] * S3 + C3 * e1j2;
    const lanes e1j3 = qdr[2] * W2e3 + e1e3;
    const lanes e2e3 = qddr[1] * C3 - S3 * e1j2;
    const lanes e2j3 = e2e3 - qdr[2] * W1e3;
    const lanes l1e3 = C3 * l1e2;
    const lanes l2e3 = -S3 * l1e2;
    const lanes e3j3 = qddr[2] - e2j2;
    const lanes E3j3 = qdr[2] - E2e2;
    const lanes vP31r3 = W1e3 * E3j3;
    const lanes vA1r3 = e2j3 + vP31r3;
    const lanes v1r3 = panda_geometry_R3 * vA1r3 + l1e3;
    const lanes vP32r3 = W2e3 * E3j3;
    const lanes vA2r3 = vP32r3 - e1j3;
    const lanes v2r3 = panda_geometry_R3 * vA2r3 + l2e3;
    const lanes vP11r3 = W1e3 * E1e3;
    const lanes vP22r3 = W2e3 * E2e3;
    const lanes vA3r3 = vP11r3 + vP22r3;
    const lanes v3r3 = -panda_geometry_R3 * vA3r3 - l2e2;
    const lanes vP12d4 = W33 * E1e3;
    const lanes vA2d4 = vP12d4 - e2j3;
    const lanes v2d4 = panda_geometry_D4 * vA2d4 + v3r3;
    const lanes vP13d4 = -W2e3 * E1e3;
    const lanes vA3d4 = vP13d4 - e3j3;
    const lanes v3d4 = panda_geometry_D4 * vA3d4 - v2r3;
    const lanes vP22d4 = W33 * E3j3;
    const lanes vA1d4 = vP22r3 + vP22d4;
    const lanes v1d4 = v1r3 - panda_geometry_D4 * vA1d4;
    const lanes E1e4 = C4 * E1e3 + S4 * E3j3;
    const lanes E2e4 = C4 * E3j3 - S4 * E1e3;
    const lanes e1e4 = C4 * e1j3 + S4 * e3j3;
    const lanes e1j4 = qdr[3] * W2e4 + e1e4;
    const lanes e2e4 = C4 * e3j3 - S4 * e1j3;
    const lanes e2j4 = e2e4 - qdr[3] * W1e4;
    const lanes l1e4 = C4 * v1d4 + S4 * v2d4;
    const lanes l2e4 = C4 * v2d4 - S4 * v1d4;
    const lanes e3j4 = qddr[3] - e2j3;
    const lanes E3j4 = qdr[3] - E2e3;
    const lanes vP12d5 = -W34 * E1e4;
    const lanes vA2d5 = e2j4 + vP12d5;
    const lanes v2d5 = -panda_geometry_D4 * vA2d5 - v3d4;
    const lanes vP13d5 = W2e4 * E1e4;
    const lanes vA3d5 = e3j4 + vP13d5;
    const lanes v3d5 = l2e4 - panda_geometry_D4 * vA3d5;
    const lanes vP22d5 = W34 * E3j4;
    const lanes vP33d5 = W2e4 * E2e4;
    const lanes vA1d5 = vP22d5 + vP33d5;
    const lanes v1d5 = panda_geometry_D4 * vA1d5 + l1e4;
    const lanes E1e5 = C5 * E1e4 - S5 * E3j4;
    const lanes E2e5 = -C5 * E3j4 - S5 * E1e4;
    const lanes e1e5 = C5 * e1j4 - S5 * e3j4;
    const lanes e1j5 = qdr[4] * W2e5 + e1e5;
    const lanes e2e5 = -C5 * e3j4 - S5 * e1j4;
    const lanes e2j5 = e2e5 - qdr[4] * W1e5;
    const lanes l1e5 = C5 * v1d5 + S5 * v2d5;
    const lanes l2e5 = C5 * v2d5 - S5 * v1d5;
    const lanes e3j5 = qddr[4] + e2j4;
    const lanes E3j5 = qdr[4] + E2e4;
    const lanes vP31r5 = W1e5 * E3j5;
    const lanes vA1r5 = e2j5 + vP31r5;
    const lanes v1r5 = panda_geometry_R5 * vA1r5 + l1e5;
    const lanes vP32r5 = W2e5 * E3j5;
    const lanes vA2r5 = vP32r5 - e1j5;
    const lanes v2r5 = panda_geometry_R5 * vA2r5 + l2e5;
    const lanes vP11r5 = W1e5 * E1e5;
    const lanes vP22r5 = W2e5 * E2e5;
    const lanes vA3r5 = vP11r5 + vP22r5;
    const lanes v3r5 = v3d5 - panda_geometry_R5 * vA3r5;
    const lanes E1e6 = C6 * E1e5 + S6 * E3j5;
    const lanes E2e6 = C6 * E3j5 - S6 * E1e5;
    const lanes e1e6 = C6 * e1j5 + S6 * e3j5;
    const lanes e1j6 = qdr[5] * W2e6 + e1e6;
    const lanes e2e6 = C6 * e3j5 - S6 * e1j5;
    const lanes e2j6 = e2e6 - qdr[5] * W1e6;
    const lanes l1e6 = C6 * v1r5 + S6 * v3r5;
    const lanes l2e6 = C6 * v3r5 - S6 * v1r5;
    const lanes e3j6 = qddr[5] - e2j5;
    const lanes E3j6 = qdr[5] - E2e5;
    const lanes vP12d7 = W36 * E1e6;
    const lanes vA2d7 = vP12d7 - e2j6;
    const lanes v2d7 = panda_geometry_D7 * vA2d7 - v2r5;
    const lanes vP13d7 = -W2e6 * E1e6;
    const lanes vA3d7 = vP13d7 - e3j6;
    const lanes v3d7 = panda_geometry_D7 * vA3d7 - l2e6;
    const lanes vP22d7 = W36 * E3j6;
    const lanes vP33d7 = W2e6 * E2e6;
    const lanes vA1d7 = vP22d7 + vP33d7;
    const lanes v1d7 = l1e6 - panda_geometry_D7 * vA1d7;
    const lanes E1e7 = C7 * E1e6 + S7 * E3j6;
    const lanes E2e7 = C7 * E3j6 - S7 * E1e6;
    const lanes e1e7 = C7 * e1j6 + S7 * e3j6;
    const lanes e1j7 = qdr[6] * W2e7 + e1e7;
    const lanes e2e7 = C7 * e3j6 - S7 * e1j6;
    const lanes e2j7 = e2e7 - qdr[6] * W1e7;
    const lanes l1e7 = C7 * v1d7 + S7 * v2d7;
    const lanes l2e7 = C7 * v2d7 - S7 * v1d7;
    const lanes e3j7 = qddr[6] - e2j6;
    const lanes E3j7 = qdr[6] - E2e6;
    const lanes N1_3 = qddr[0] * X[0];
    const lanes t2 = X[1] + X[5];
    const lanes h2 = 0.5 * t2;
    const lanes j12 = X[1] - h2;
    const lanes k2_1 = qdr[1] * X[3] + X[2] * E2e2 + E1e2 * j12;
    const lanes j32 = X[5] - h2;
    const lanes k2_2 = qdr[1] * X[4] + X[2] * E1e2 - E2e2 * h2;
    const lanes k2_3 = qdr[1] * j32 + X[3] * E1e2 + X[4] * E2e2;
    const lanes N2_3 = qddr[1] * X[5] + X[3] * e1j2 + X[4] * e2j2 + X[6] * l2e2 + W1e2 * k2_2 - X[7] * l1e2 - W2e2 * k2_1;
    const lanes N2_1 = qddr[1] * X[3] + X[1] * e1j2 + X[2] * e2j2 + W2e2 * k2_3 - qd[1] * k2_2;
    const lanes N2_2 = qd[1] * k2_1 + qddr[1] * X[4] + X[2] * e1j2 - W1e2 * k2_3;
    const lanes h3_1 = -X[14] * W33;
    const lanes h3_2 = X[13] * W33;
    const lanes h3_3 = X[14] * W1e3 - X[13] * W2e3;
    const lanes F3_1 = E2e3 * h3_3 - X[14] * e3j3 - E3j3 * h3_2;
    const lanes F3_2 = X[13] * e3j3 + E3j3 * h3_1 - E1e3 * h3_3;
    const lanes t3 = X[8] + X[12];
    const lanes h3 = 0.5 * t3;
    const lanes j13 = X[8] - h3;
    const lanes k3_1 = X[9] * E2e3 + X[10] * E3j3 + E1e3 * j13;
    const lanes j33 = X[12] - h3;
    const lanes k3_2 = X[9] * E1e3 + X[11] * E3j3 - E2e3 * h3;
    const lanes k3_3 = X[10] * E1e3 + X[11] * E2e3 + E3j3 * j33;
    const lanes N3_3 = X[10] * e1j3 + X[11] * e2j3 + X[12] * e3j3 + X[13] * v2r3 + W1e3 * k3_2 - X[14] * v1r3 - W2e3 * k3_1;
    const lanes N3_1 = X[8] * e1j3 + X[9] * e2j3 + X[10] * e3j3 + X[14] * v3r3 + W2e3 * k3_3 - W33 * k3_2;
    const lanes N3_2 = X[9] * e1j3 + X[11] * e3j3 + W33 * k3_1 - X[13] * v3r3 - W1e3 * k3_3;
    const lanes h4_1 = -X[22] * W34;
    const lanes h4_2 = X[21] * W34;
    const lanes h4_3 = X[22] * W1e4 - X[21] * W2e4;
    const lanes t4 = X[16] + X[20];
    const lanes h4 = 0.5 * t4;
    const lanes j14 = X[16] - h4;
    const lanes k4_1 = X[17] * E2e4 + X[18] * E3j4 + E1e4 * j14;
    const lanes j34 = X[20] - h4;
    const lanes k4_2 = X[17] * E1e4 + X[19] * E3j4 - E2e4 * h4;
    const lanes k4_3 = X[18] * E1e4 + X[19] * E2e4 + E3j4 * j34;
    const lanes N4_3 = X[18] * e1j4 + X[19] * e2j4 + X[20] * e3j4 + X[21] * l2e4 + W1e4 * k4_2 - X[22] * l1e4 - W2e4 * k4_1;
    const lanes N4_1 = X[16] * e1j4 + X[17] * e2j4 + X[18] * e3j4 + X[22] * v3d4 + W2e4 * k4_3 - W34 * k4_2;
    const lanes F4_3 = X[22] * e1j4 + E1e4 * h4_2 - X[21] * e2j4 - E2e4 * h4_1;
    const lanes F4_1 = E2e4 * h4_3 - X[22] * e3j4 - E3j4 * h4_2;
    const lanes F4_2 = X[21] * e3j4 + E3j4 * h4_1 - E1e4 * h4_3;
    const lanes N4_2 = X[17] * e1j4 + X[19] * e3j4 + W34 * k4_1 - X[21] * v3d4 - W1e4 * k4_3;
    const lanes h5_1 = -X[30] * W35;
    const lanes h5_2 = X[29] * W35;
    const lanes h5_3 = X[30] * W1e5 - X[29] * W2e5;
    const lanes t5 = X[24] + X[28];
    const lanes h5 = 0.5 * t5;
    const lanes j15 = X[24] - h5;
    const lanes k5_1 = X[25] * E2e5 + X[26] * E3j5 + E1e5 * j15;
    const lanes j35 = X[28] - h5;
    const lanes k5_2 = X[25] * E1e5 + X[27] * E3j5 - E2e5 * h5;
    const lanes k5_3 = X[26] * E1e5 + X[27] * E2e5 + E3j5 * j35;
    const lanes N5_3 = X[26] * e1j5 + X[27] * e2j5 + X[28] * e3j5 + X[29] * v2r5 + W1e5 * k5_2 - X[30] * v1r5 - W2e5 * k5_1;
    const lanes N5_1 = X[24] * e1j5 + X[25] * e2j5 + X[26] * e3j5 + X[30] * v3r5 + W2e5 * k5_3 - W35 * k5_2;
    const lanes F5_3 = X[30] * e1j5 + E1e5 * h5_2 - X[29] * e2j5 - E2e5 * h5_1;
    const lanes F5_1 = E2e5 * h5_3 - X[30] * e3j5 - E3j5 * h5_2;
    const lanes F5_2 = X[29] * e3j5 + E3j5 * h5_1 - E1e5 * h5_3;
    const lanes N5_2 = X[25] * e1j5 + X[27] * e3j5 + W35 * k5_1 - X[29] * v3r5 - W1e5 * k5_3;
    const lanes h6_1 = -X[38] * W36;
    const lanes h6_2 = X[37] * W36;
    const lanes h6_3 = X[38] * W1e6 - X[37] * W2e6;
    const lanes t6 = X[32] + X[36];
    const lanes h6 = 0.5 * t6;
    const lanes j16 = X[32] - h6;
    const lanes k6_1 = X[33] * E2e6 + X[34] * E3j6 + E1e6 * j16;
    const lanes j36 = X[36] - h6;
    const lanes k6_2 = X[33] * E1e6 + X[35] * E3j6 - E2e6 * h6;
    const lanes k6_3 = X[34] * E1e6 + X[35] * E2e6 + E3j6 * j36;
    const lanes N6_3 = X[34] * e1j6 + X[35] * e2j6 + X[36] * e3j6 + X[37] * l2e6 + W1e6 * k6_2 - X[38] * l1e6 - W2e6 * k6_1;
    const lanes N6_1 = X[32] * e1j6 + X[33] * e2j6 + X[34] * e3j6 + W2e6 * k6_3 - X[38] * v2r5 - W36 * k6_2;
    const lanes F6_3 = X[38] * e1j6 + E1e6 * h6_2 - X[37] * e2j6 - E2e6 * h6_1;
    const lanes F6_1 = E2e6 * h6_3 - X[38] * e3j6 - E3j6 * h6_2;
    const lanes F6_2 = X[37] * e3j6 + E3j6 * h6_1 - E1e6 * h6_3;
    const lanes N6_2 = X[33] * e1j6 + X[35] * e3j6 + X[37] * v2r5 + W36 * k6_1 - W1e6 * k6_3;
    const lanes h7_1 = -X[46] * W37;
    const lanes h7_2 = X[45] * W37;
    const lanes h7_3 = X[46] * W1e7 - X[45] * W2e7;
    const lanes t7 = X[40] + X[44];
    const lanes h7 = 0.5 * t7;
    const lanes j17 = X[40] - h7;
    const lanes k7_1 = X[41] * E2e7 + X[42] * E3j7 + E1e7 * j17;
    const lanes j37 = X[44] - h7;
    const lanes k7_2 = X[41] * E1e7 + X[43] * E3j7 - E2e7 * h7;
    const lanes k7_3 = X[42] * E1e7 + X[43] * E2e7 + E3j7 * j37;
    const lanes N7_3 = X[42] * e1j7 + X[43] * e2j7 + X[44] * e3j7 + X[45] * l2e7 + W1e7 * k7_2 - X[46] * l1e7 - W2e7 * k7_1;
    const lanes N7_1 = X[40] * e1j7 + X[41] * e2j7 + X[42] * e3j7 + X[46] * v3d7 + W2e7 * k7_3 - W37 * k7_2;
    const lanes F7_3 = X[46] * e1j7 + E1e7 * h7_2 - X[45] * e2j7 - E2e7 * h7_1;
    const lanes F7_1 = E2e7 * h7_3 - X[46] * e3j7 - E3j7 * h7_2;
    const lanes F7_2 = X[45] * e3j7 + E3j7 * h7_1 - E1e7 * h7_3;
    const lanes N7_2 = X[41] * e1j7 + X[43] * e3j7 + W37 * k7_1 - X[45] * v3d7 - W1e7 * k7_3;
    const lanes Fss6_7_2 = F6_2 - F7_3;
    const lanes Fbs1e7 = C7 * F7_1 - S7 * F7_2;
    const lanes Fbs2e7 = C7 * F7_2 + S7 * F7_1;
    const lanes Fss6_7_1 = F6_1 + Fbs1e7;
    const lanes Fss6_7_3 = F6_3 + Fbs2e7;
    const lanes Nbs3d7 = panda_geometry_D7 * Fbs2e7 + N7_3;
    const lanes Nss6_7_2 = N6_2 - Nbs3d7;
    const lanes Fss5_6_2 = F5_2 - Fss6_7_3;
    const lanes Nbs1e7 = C7 * N7_1 - S7 * N7_2;
    const lanes Nbs2e7 = C7 * N7_2 + S7 * N7_1;
    const lanes Nbs2d7 = Nbs2e7 - panda_geometry_D7 * F7_3;
    const lanes Nss6_7_1 = N6_1 + Nbs1e7;
    const lanes Nss6_7_3 = N6_3 + Nbs2d7;
    const lanes Nss5_6_2 = N5_2 - Nss6_7_3;
    const lanes Fbs1e6 = C6 * Fss6_7_1 - S6 * Fss6_7_2;
    const lanes Fbs2e6 = C6 * Fss6_7_2 + S6 * Fss6_7_1;
    const lanes Fss5_6_1 = F5_1 + Fbs1e6;
    const lanes Fss5_6_3 = F5_3 + Fbs2e6;
    const lanes Nbs2r5 = panda_geometry_R5 * Fss5_6_1 + Nss5_6_2;
    const lanes Fss4_5_2 = F4_2 + Fss5_6_3;
    const lanes Nbs1e6 = C6 * Nss6_7_1 - S6 * Nss6_7_2;
    const lanes Nbs2e6 = C6 * Nss6_7_2 + S6 * Nss6_7_1;
    const lanes Nss5_6_1 = N5_1 + Nbs1e6;
    const lanes Nss5_6_3 = N5_3 + Nbs2e6;
    const lanes Nbs1r5 = Nss5_6_1 - panda_geometry_R5 * Fss5_6_2;
    const lanes Fbs1e5 = C5 * Fss5_6_1 - S5 * Fss5_6_2;
    const lanes Fbs2e5 = C5 * Fss5_6_2 + S5 * Fss5_6_1;
    const lanes Fss4_5_1 = F4_1 + Fbs1e5;
    const lanes Fss4_5_3 = F4_3 - Fbs2e5;
    const lanes Nbs3d5 = Nss5_6_3 - panda_geometry_D4 * Fbs2e5;
    const lanes Nss4_5_2 = N4_2 + Nbs3d5;
    const lanes Fss3_4_2 = F3_2 - Fss4_5_3;
    const lanes Nbs1e5 = C5 * Nbs1r5 - S5 * Nbs2r5;
    const lanes Nbs2e5 = C5 * Nbs2r5 + S5 * Nbs1r5;
    const lanes Nbs2d5 = panda_geometry_D4 * Fss5_6_3 + Nbs2e5;
    const lanes Nss4_5_1 = N4_1 + Nbs1e5;
    const lanes Nss4_5_3 = N4_3 - Nbs2d5;
    const lanes Fbs1e4 = C4 * Fss4_5_1 - S4 * Fss4_5_2;
    const lanes Fbs2e4 = C4 * Fss4_5_2 + S4 * Fss4_5_1;
    const lanes Nbs3d4 = panda_geometry_D4 * Fbs2e4 + Nss4_5_3;
    const lanes Fss3_4_1 = F3_1 + Fbs1e4;
    const lanes Nss3_4_2 = N3_2 - Nbs3d4;
    const lanes Nbs2r3 = panda_geometry_R3 * Fss3_4_1 + Nss3_4_2;
    const lanes Nbs1e4 = C4 * Nss4_5_1 - S4 * Nss4_5_2;
    const lanes Nbs2e4 = C4 * Nss4_5_2 + S4 * Nss4_5_1;
    const lanes Nbs2d4 = Nbs2e4 - panda_geometry_D4 * Fss4_5_3;
    const lanes Nss3_4_1 = N3_1 + Nbs1e4;
    const lanes Nss3_4_3 = N3_3 + Nbs2d4;
    const lanes Nbs1r3 = Nss3_4_1 - panda_geometry_R3 * Fss3_4_2;
    const lanes Nss2_3_2 = N2_2 - Nss3_4_3;
    const lanes Nbs1e3 = C3 * Nbs1r3 - S3 * Nbs2r3;
    const lanes Nbs2e3 = C3 * Nbs2r3 + S3 * Nbs1r3;
    const lanes Nss2_3_1 = N2_1 + Nbs1e3;
    const lanes Nss2_3_3 = N2_3 + Nbs2e3;
    const lanes Nbs2e2 = C2 * Nss2_3_2 + S2 * Nss2_3_1;
    const lanes Nss1_2_3 = N1_3 - Nbs2e2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes T1 = qd[0] * X[49] + X[48] * sFS1 + Nss1_2_3;
    lanes_put(&tau[0], T1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[51] + X[50] * sFS2 + Nss2_3_3;
    lanes_put(&tau[1], T2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[53] + qddr[2] * X[15] + X[52] * sFS3 + Nss3_4_3;
    lanes_put(&tau[2], T3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[55] + qddr[3] * X[23] + X[54] * sFS4 + Nss4_5_3;
    lanes_put(&tau[3], T4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[57] + qddr[4] * X[31] + X[56] * sFS5 + Nss5_6_3;
    lanes_put(&tau[4], T5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[59] + qddr[5] * X[39] + X[58] * sFS6 + Nss6_7_3;
    lanes_put(&tau[5], T6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    const lanes T7 = qd[6] * X[61] + qddr[6] * X[47] + X[60] * sFS7 + N7_3;
    lanes_put(&tau[6], T7, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, const lanes *X, apart *tau)
{
    return panel(q, qd, qdr, qddr, X, tau, 0);
}

int panda_slotine_li_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[4] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdr[REACH(7u)];
    lanes lanes_qdr[BLOCKS(7u)];
    double padded_qddr[REACH(7u)];
    lanes lanes_qddr[BLOCKS(7u)];
    double padded_X[REACH(62u)];
    lanes lanes_X[BLOCKS(62u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdr, 7u, lanes_qdr);
    lanes_shared(qddr, 7u, lanes_qddr);
    lanes_shared(X, 62u, lanes_X);
    lanes lanes_tau[BLOCKS(7u)];
    double scratch[7u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        const size_t count = (N - k < panda_WIDTH) ? (N - k) : panda_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdr != 0u) {
            lanes_load(qdr, 7u, stride_qdr, k, N, padded_qdr, lanes_qdr);
        }
        if (stride_qddr != 0u) {
            lanes_load(qddr, 7u, stride_qddr, k, N, padded_qddr, lanes_qddr);
        }
        if (stride_X != 0u) {
            lanes_load(X, 62u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 7u, count, stream, scratch, &tau[k * 7u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[4] : 0u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdr[REACH(7u)];
    lanes lanes_qdr[BLOCKS(7u)];
    double padded_qddr[REACH(7u)];
    lanes lanes_qddr[BLOCKS(7u)];
    double padded_X[REACH(62u)];
    lanes lanes_X[BLOCKS(62u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdr, 7u, lanes_qdr);
    lanes_shared(qddr, 7u, lanes_qddr);
    lanes_shared(X, 62u, lanes_X);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdr != 0u) {
            lanes_load(qdr, 7u, stride_qdr, k, N, padded_qdr, lanes_qdr);
        }
        if (stride_qddr != 0u) {
            lanes_load(qddr, 7u, stride_qddr, k, N, padded_qddr, lanes_qddr);
        }
        if (stride_X != 0u) {
            lanes_load(X, 62u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 7u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, lanes_tau, 1) : plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, lanes_tau);
    }
    return status;
}

int panda_slotine_li_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    if (!(streamed(stream, tau))) {
        return panels(0, N, strides, q, qd, qdr, qddr, X, tau);
    }
    const int status = panels(1, N, strides, q, qd, qdr, qddr, X, tau);
    stream_end();
    return status;
}

#else

int panda_slotine_li_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 7u;
    const size_t stride_X = (strides != NULL) ? strides[4] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        panda_slotine_li_torque(&q[k * stride_q], &qd[k * stride_qd], &qdr[k * stride_qdr], &qddr[k * stride_qddr], &X[k * stride_X], &tau[k * 7u]);
    }
    return status;
}

int panda_slotine_li_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    return panda_slotine_li_torque_rows(stream, N, strides, q, qd, qdr, qddr, X, tau);
}

#endif

size_t panda_slotine_li_torque_width(void)
{
    return panda_WIDTH;
}

void panda_slotine_li_torque_batch(size_t N, const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    (void)panda_slotine_li_torque_rows(0, N, NULL, q, qd, qdr, qddr, X, tau);
}
