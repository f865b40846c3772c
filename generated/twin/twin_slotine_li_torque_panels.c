/* twin: slotine_li_torque of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, const lanes *X, apart *tau, const int stream)
{
    (void)stream;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    const double gz = 9.81;
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
    const lanes vP22d2 = qd[0] * qdr[0];
    const lanes v1d2 = -d2 * vP22d2;
    const lanes v3d2 = -qddr[0] * d2;
    const lanes E1e2 = qdr[0] * S2;
    const lanes E2e2 = qdr[0] * C2;
    const lanes e1e2 = qddr[0] * S2;
    const lanes e1j2 = qdr[1] * W2e2 + e1e2;
    const lanes e2e2 = qddr[0] * C2;
    const lanes e2j2 = e2e2 - qdr[1] * W1e2;
    const lanes l1e2 = gz * S2 + C2 * v1d2;
    const lanes l2e2 = gz * C2 - S2 * v1d2;
    const lanes vP12d3 = W2e2 * E1e2;
    const lanes vA2d3 = qddr[1] + vP12d3;
    const lanes v2d3 = d3 * vA2d3 + l2e2;
    const lanes vP13d3 = qd[1] * E1e2;
    const lanes vA3d3 = vP13d3 - e2j2;
    const lanes v3d3 = d3 * vA3d3 + v3d2;
    const lanes vP22d3 = W2e2 * E2e2;
    const lanes vP33d3 = qd[1] * qdr[1];
    const lanes vA1d3 = vP22d3 + vP33d3;
    const lanes v1d3 = l1e2 - d3 * vA1d3;
    const lanes E1e3 = C3 * E1e2 + S3 * E2e2;
    const lanes E2e3 = C3 * E2e2 - S3 * E1e2;
    const lanes e1e3 = C3 * e1j2 + S3 * e2j2;
    const lanes e1j3 = qdr[2] * W2e3 + e1e3;
    const lanes e2e3 = C3 * e2j2 - S3 * e1j2;
    const lanes e2j3 = e2e3 - qdr[2] * W1e3;
    const lanes l1e3 = C3 * v1d3 + S3 * v2d3;
    const lanes l2e3 = C3 * v2d3 - S3 * v1d3;
    const lanes e3j3 = qddr[1] + qddr[2];
    const lanes E3j3 = qdr[1] + qdr[2];
    const lanes E1e4 = C4 * E1e3 + S4 * E3j3;
    const lanes E2e4 = C4 * E3j3 - S4 * E1e3;
    const lanes e1e4 = C4 * e1j3 + S4 * e3j3;
    const lanes e1j4 = qdr[3] * W2e4 + e1e4;
    const lanes e2e4 = C4 * e3j3 - S4 * e1j3;
    const lanes e2j4 = e2e4 - qdr[3] * W1e4;
    const lanes l1e4 = C4 * l1e3 + S4 * v3d3;
    const lanes l2e4 = C4 * v3d3 - S4 * l1e3;
    const lanes e3j4 = qddr[3] - e2j3;
    const lanes E3j4 = qdr[3] - E2e3;
    const lanes vP31r4 = W1e4 * E3j4;
    const lanes vA1r4 = e2j4 + vP31r4;
    const lanes v1r4 = r4 * vA1r4 + l1e4;
    const lanes vP32r4 = W2e4 * E3j4;
    const lanes vA2r4 = vP32r4 - e1j4;
    const lanes v2r4 = r4 * vA2r4 + l2e4;
    const lanes vP11r4 = W1e4 * E1e4;
    const lanes vP22r4 = W2e4 * E2e4;
    const lanes vA3r4 = vP11r4 + vP22r4;
    const lanes v3r4 = -r4 * vA3r4 - l2e3;
    const lanes E1e5 = qdr[0] * S5;
    const lanes E2e5 = qdr[0] * C5;
    const lanes e1e5 = qddr[0] * S5;
    const lanes e1j5 = qdr[4] * W2e5 + e1e5;
    const lanes e2e5 = qddr[0] * C5;
    const lanes e2j5 = e2e5 - qdr[4] * W1e5;
    const lanes l1e5 = gz * S5 + C5 * v1d2;
    const lanes l2e5 = gz * C5 - S5 * v1d2;
    const lanes vP31r6 = -W1e5 * E2e5;
    const lanes vA1r6 = qddr[4] + vP31r6;
    const lanes v1r6 = R6 * vA1r6 + l1e5;
    const lanes l1j6 = qd[4] * qdr[5] + qd[5] * qdr[4] + v1r6;
    const lanes vP32r6 = -qd[4] * E2e5;
    const lanes vA2r6 = vP32r6 - e1j5;
    const lanes v2r6 = R6 * vA2r6 + v3d2;
    const lanes l2j6 = v2r6 - qd[5] * E1e5 - qdr[5] * W1e5;
    const lanes vP11r6 = W1e5 * E1e5;
    const lanes vP22r6 = qd[4] * qdr[4];
    const lanes vA3r6 = vP11r6 + vP22r6;
    const lanes v3r6 = -R6 * vA3r6 - l2e5;
    const lanes l3j6 = qddr[5] + v3r6;
    const lanes E1e7 = C7 * E1e5 + S7 * E2e5;
    const lanes E2e7 = C7 * E2e5 - S7 * E1e5;
    const lanes e1e7 = C7 * e1j5 + S7 * e2j5;
    const lanes e1j7 = qdr[6] * W2e7 + e1e7;
    const lanes e2e7 = C7 * e2j5 - S7 * e1j5;
    const lanes e2j7 = e2e7 - qdr[6] * W1e7;
    const lanes l1e7 = C7 * l1j6 - S7 * l3j6;
    const lanes l2e7 = -C7 * l3j6 - S7 * l1j6;
    const lanes e3j7 = qddr[4] + qddr[6];
    const lanes E3j7 = qdr[4] + qdr[6];
    const lanes N1_3 = qddr[0] * X[0];
    const lanes h2_1 = -qd[1] * X[7];
    const lanes h2_2 = qd[1] * X[6];
    const lanes F2_3 = X[7] * e1j2 + E1e2 * h2_2 - X[6] * e2j2 - E2e2 * h2_1;
    const lanes t2 = X[1] + X[5];
    const lanes h2 = 0.5 * t2;
    const lanes j12 = X[1] - h2;
    const lanes k2_1 = qdr[1] * X[3] + X[2] * E2e2 + E1e2 * j12;
    const lanes j32 = X[5] - h2;
    const lanes k2_2 = qdr[1] * X[4] + X[2] * E1e2 - E2e2 * h2;
    const lanes k2_3 = qdr[1] * j32 + X[3] * E1e2 + X[4] * E2e2;
    const lanes N2_3 = qddr[1] * X[5] + X[3] * e1j2 + X[4] * e2j2 + X[6] * l2e2 + W1e2 * k2_2 - X[7] * l1e2 - W2e2 * k2_1;
    const lanes N2_1 = qddr[1] * X[3] + X[1] * e1j2 + X[2] * e2j2 + X[7] * v3d2 + W2e2 * k2_3 - qd[1] * k2_2;
    const lanes N2_2 = qd[1] * k2_1 + qddr[1] * X[4] + X[2] * e1j2 - X[6] * v3d2 - W1e2 * k2_3;
    const lanes h3_1 = -X[14] * W33;
    const lanes h3_2 = X[13] * W33;
    const lanes h3_3 = X[14] * W1e3 - X[13] * W2e3;
    const lanes t3 = X[8] + X[12];
    const lanes h3 = 0.5 * t3;
    const lanes j13 = X[8] - h3;
    const lanes k3_1 = X[9] * E2e3 + X[10] * E3j3 + E1e3 * j13;
    const lanes j33 = X[12] - h3;
    const lanes k3_2 = X[9] * E1e3 + X[11] * E3j3 - E2e3 * h3;
    const lanes k3_3 = X[10] * E1e3 + X[11] * E2e3 + E3j3 * j33;
    const lanes N3_3 = X[10] * e1j3 + X[11] * e2j3 + X[12] * e3j3 + X[13] * l2e3 + W1e3 * k3_2 - X[14] * l1e3 - W2e3 * k3_1;
    const lanes N3_1 = X[8] * e1j3 + X[9] * e2j3 + X[10] * e3j3 + X[14] * v3d3 + W2e3 * k3_3 - W33 * k3_2;
    const lanes F3_3 = X[14] * e1j3 + E1e3 * h3_2 - X[13] * e2j3 - E2e3 * h3_1;
    const lanes F3_1 = E2e3 * h3_3 - X[14] * e3j3 - E3j3 * h3_2;
    const lanes F3_2 = X[13] * e3j3 + E3j3 * h3_1 - E1e3 * h3_3;
    const lanes N3_2 = X[9] * e1j3 + X[11] * e3j3 + W33 * k3_1 - X[13] * v3d3 - W1e3 * k3_3;
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
    const lanes N4_3 = X[18] * e1j4 + X[19] * e2j4 + X[20] * e3j4 + X[21] * v2r4 + W1e4 * k4_2 - X[22] * v1r4 - W2e4 * k4_1;
    const lanes N4_1 = X[16] * e1j4 + X[17] * e2j4 + X[18] * e3j4 + X[22] * v3r4 + W2e4 * k4_3 - W34 * k4_2;
    const lanes F4_3 = X[22] * e1j4 + E1e4 * h4_2 - X[21] * e2j4 - E2e4 * h4_1;
    const lanes F4_1 = E2e4 * h4_3 - X[22] * e3j4 - E3j4 * h4_2;
    const lanes F4_2 = X[21] * e3j4 + E3j4 * h4_1 - E1e4 * h4_3;
    const lanes N4_2 = X[17] * e1j4 + X[19] * e3j4 + W34 * k4_1 - X[21] * v3r4 - W1e4 * k4_3;
    const lanes Nbs1r4 = N4_1 - r4 * F4_2;
    const lanes Nbs2r4 = r4 * F4_1 + N4_2;
    const lanes Fss3_4_2 = F3_2 - F4_3;
    const lanes Nss3_4_2 = N3_2 - N4_3;
    const lanes h5_1 = -qd[4] * X[30];
    const lanes h5_2 = qd[4] * X[29];
    const lanes F5_3 = X[30] * e1j5 + E1e5 * h5_2 - X[29] * e2j5 - E2e5 * h5_1;
    const lanes t5 = X[24] + X[28];
    const lanes h5 = 0.5 * t5;
    const lanes j15 = X[24] - h5;
    const lanes k5_1 = qdr[4] * X[26] + X[25] * E2e5 + E1e5 * j15;
    const lanes j35 = X[28] - h5;
    const lanes k5_2 = qdr[4] * X[27] + X[25] * E1e5 - E2e5 * h5;
    const lanes k5_3 = qdr[4] * j35 + X[26] * E1e5 + X[27] * E2e5;
    const lanes N5_3 = qddr[4] * X[28] + X[26] * e1j5 + X[27] * e2j5 + X[29] * l2e5 + W1e5 * k5_2 - X[30] * l1e5 - W2e5 * k5_1;
    const lanes N5_1 = qddr[4] * X[26] + X[24] * e1j5 + X[25] * e2j5 + X[30] * v3d2 + W2e5 * k5_3 - qd[4] * k5_2;
    const lanes N5_2 = qd[4] * k5_1 + qddr[4] * X[27] + X[25] * e1j5 - X[29] * v3d2 - W1e5 * k5_3;
    const lanes h6_1 = qd[4] * X[33] + X[32] * W2e5;
    const lanes h6_2 = -X[31] * W2e5 - X[33] * W1e5;
    const lanes h6_3 = X[32] * W1e5 - qd[4] * X[31];
    const lanes F6_1 = qdr[4] * h6_3 + qddr[4] * X[33] + X[32] * e2j5 + X[34] * l1j6 + E2e5 * h6_2;
    const lanes F6_2 = X[34] * l2j6 - X[31] * e2j5 - X[33] * e1j5 - E1e5 * h6_3 - E2e5 * h6_1;
    const lanes F6_3 = X[32] * e1j5 + X[34] * l3j6 + E1e5 * h6_2 - qdr[4] * h6_1 - qddr[4] * X[31];
    const lanes N6_1 = X[32] * l3j6 - X[33] * l2j6;
    const lanes N6_2 = X[33] * l1j6 - X[31] * l3j6;
    const lanes N6_3 = X[31] * l2j6 - X[32] * l1j6;
    const lanes h7_1 = -X[42] * W37;
    const lanes h7_2 = X[41] * W37;
    const lanes h7_3 = X[42] * W1e7 - X[41] * W2e7;
    const lanes t7 = X[36] + X[40];
    const lanes h7 = 0.5 * t7;
    const lanes j17 = X[36] - h7;
    const lanes k7_1 = X[37] * E2e7 + X[38] * E3j7 + E1e7 * j17;
    const lanes j37 = X[40] - h7;
    const lanes k7_2 = X[37] * E1e7 + X[39] * E3j7 - E2e7 * h7;
    const lanes k7_3 = X[38] * E1e7 + X[39] * E2e7 + E3j7 * j37;
    const lanes N7_3 = X[38] * e1j7 + X[39] * e2j7 + X[40] * e3j7 + X[41] * l2e7 + W1e7 * k7_2 - X[42] * l1e7 - W2e7 * k7_1;
    const lanes N7_1 = X[36] * e1j7 + X[37] * e2j7 + X[38] * e3j7 + X[42] * l2j6 + W2e7 * k7_3 - W37 * k7_2;
    const lanes F7_3 = X[42] * e1j7 + E1e7 * h7_2 - X[41] * e2j7 - E2e7 * h7_1;
    const lanes F7_1 = E2e7 * h7_3 - X[42] * e3j7 - E3j7 * h7_2;
    const lanes F7_2 = X[41] * e3j7 + E3j7 * h7_1 - E1e7 * h7_3;
    const lanes N7_2 = X[37] * e1j7 + X[39] * e3j7 + W37 * k7_1 - X[41] * l2j6 - W1e7 * k7_3;
    const lanes Fss6_7_2 = F6_2 + F7_3;
    const lanes Nss6_7_2 = N6_2 + N7_3;
    const lanes Fss5_6_3 = F5_3 + Fss6_7_2;
    const lanes Fbs1e7 = C7 * F7_1 - S7 * F7_2;
    const lanes Fbs2e7 = C7 * F7_2 + S7 * F7_1;
    const lanes Fss6_7_1 = F6_1 + Fbs1e7;
    const lanes Fss6_7_3 = F6_3 - Fbs2e7;
    const lanes Nbs2r6 = R6 * Fss6_7_1 + Nss6_7_2;
    const lanes Nss5_6_3 = N5_3 + Nbs2r6;
    const lanes Nbs1e7 = C7 * N7_1 - S7 * N7_2;
    const lanes Nbs2e7 = C7 * N7_2 + S7 * N7_1;
    const lanes Nss6_7_1 = N6_1 + Nbs1e7;
    const lanes Nss6_7_3 = N6_3 - Nbs2e7;
    const lanes Nbs1r6 = Nss6_7_1 - R6 * Fss6_7_2;
    const lanes Nss5_6_1 = N5_1 + Nbs1r6;
    const lanes Nss5_6_2 = N5_2 - Nss6_7_3;
    const lanes Nbs2e5 = C5 * Nss5_6_2 + S5 * Nss5_6_1;
    const lanes Nbs2d5 = Nbs2e5 - d2 * Fss5_6_3;
    const lanes Nss1_5_3 = N1_3 + Nbs2d5;
    const lanes Fbs1e4 = C4 * F4_1 - S4 * F4_2;
    const lanes Fbs2e4 = C4 * F4_2 + S4 * F4_1;
    const lanes Fss3_4_1 = F3_1 + Fbs1e4;
    const lanes Fss3_4_3 = F3_3 + Fbs2e4;
    const lanes Fbs2e3 = C3 * Fss3_4_2 + S3 * Fss3_4_1;
    const lanes Fss2_3_3 = F2_3 + Fss3_4_3;
    const lanes Nbs1e4 = C4 * Nbs1r4 - S4 * Nbs2r4;
    const lanes Nbs2e4 = C4 * Nbs2r4 + S4 * Nbs1r4;
    const lanes Nss3_4_1 = N3_1 + Nbs1e4;
    const lanes Nss3_4_3 = N3_3 + Nbs2e4;
    const lanes Nbs3d3 = d3 * Fbs2e3 + Nss3_4_3;
    const lanes Nss2_3_3 = N2_3 + Nbs3d3;
    const lanes Nbs1e3 = C3 * Nss3_4_1 - S3 * Nss3_4_2;
    const lanes Nbs2e3 = C3 * Nss3_4_2 + S3 * Nss3_4_1;
    const lanes Nbs2d3 = Nbs2e3 - d3 * Fss3_4_3;
    const lanes Nss2_3_1 = N2_1 + Nbs1e3;
    const lanes Nss2_3_2 = N2_2 + Nbs2d3;
    const lanes Nbs2e2 = C2 * Nss2_3_2 + S2 * Nss2_3_1;
    const lanes Nbs2d2 = Nbs2e2 - d2 * Fss2_3_3;
    const lanes Nss1_2_3 = Nss1_5_3 + Nbs2d2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes T1 = qd[0] * X[45] + X[44] * sFS1 + Nss1_2_3;
    lanes_put(&tau[0], T1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[47] + X[46] * sFS2 + Nss2_3_3;
    lanes_put(&tau[1], T2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[49] + qddr[2] * X[15] + X[48] * sFS3 + Nss3_4_3;
    lanes_put(&tau[2], T3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[51] + qddr[3] * X[23] + X[50] * sFS4 + N4_3;
    lanes_put(&tau[3], T4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[53] + X[52] * sFS5 + Nss5_6_3;
    lanes_put(&tau[4], T5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[55] + qddr[5] * X[35] + X[54] * sFS6 + Fss6_7_3;
    lanes_put(&tau[5], T6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    const lanes T7 = qd[6] * X[57] + qddr[6] * X[43] + X[56] * sFS7 + N7_3;
    lanes_put(&tau[6], T7, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, const lanes *X, apart *tau)
{
    return panel(q, qd, qdr, qddr, X, tau, 0);
}

int twin_slotine_li_torque_rows(int stream, size_t N, const size_t *strides,
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
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdr, 7u, lanes_qdr);
    lanes_shared(qddr, 7u, lanes_qddr);
    lanes_shared(X, 58u, lanes_X);
    lanes lanes_tau[BLOCKS(7u)];
    double scratch[7u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
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
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
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
    double padded_X[REACH(58u)];
    lanes lanes_X[BLOCKS(58u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdr, 7u, lanes_qdr);
    lanes_shared(qddr, 7u, lanes_qddr);
    lanes_shared(X, 58u, lanes_X);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
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
            lanes_load(X, 58u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 7u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, lanes_tau, 1) : plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, lanes_tau);
    }
    return status;
}

int twin_slotine_li_torque_panels(int stream, size_t N, const size_t *strides,
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

int twin_slotine_li_torque_rows(int stream, size_t N, const size_t *strides,
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
        twin_slotine_li_torque(&q[k * stride_q], &qd[k * stride_qd], &qdr[k * stride_qdr], &qddr[k * stride_qddr], &X[k * stride_X], &tau[k * 7u]);
    }
    return status;
}

int twin_slotine_li_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    return twin_slotine_li_torque_rows(stream, N, strides, q, qd, qdr, qddr, X, tau);
}

#endif

size_t twin_slotine_li_torque_width(void)
{
    return twin_WIDTH;
}

void twin_slotine_li_torque_batch(size_t N, const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    (void)twin_slotine_li_torque_rows(0, N, NULL, q, qd, qdr, qddr, X, tau);
}
