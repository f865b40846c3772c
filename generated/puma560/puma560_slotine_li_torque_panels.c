/* puma560: slotine_li_torque of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

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
    const lanes E1e2 = -qdr[0] * S2;
    const lanes E2e2 = -qdr[0] * C2;
    const lanes e1e2 = -qddr[0] * S2;
    const lanes e2e2 = -qddr[0] * C2;
    const lanes l1e2 = -gz * S2;
    const lanes l2e2 = -gz * C2;
    const lanes e1j2 = qdr[1] * W2e2 + e1e2;
    const lanes e2j2 = e2e2 - qdr[1] * W1e2;
    const lanes vP31r2 = qdr[1] * W1e2;
    const lanes vA1r2 = e2j2 + vP31r2;
    const lanes vP32r2 = qdr[1] * W2e2;
    const lanes vA2r2 = vP32r2 - e1j2;
    const lanes vP11r2 = W1e2 * E1e2;
    const lanes vP22r2 = W2e2 * E2e2;
    const lanes vA3r2 = vP11r2 + vP22r2;
    const lanes v1r2 = puma560_geometry_R2 * vA1r2 + l1e2;
    const lanes v2r2 = puma560_geometry_R2 * vA2r2 + l2e2;
    const lanes v3r2 = -puma560_geometry_R2 * vA3r2;
    const lanes vP12d3 = W2e2 * E1e2;
    const lanes vA2d3 = qddr[1] + vP12d3;
    const lanes vP13d3 = qd[1] * E1e2;
    const lanes vA3d3 = vP13d3 - e2j2;
    const lanes vP33d3 = qd[1] * qdr[1];
    const lanes vA1d3 = vP22r2 + vP33d3;
    const lanes v2d3 = puma560_geometry_D3 * vA2d3 + v2r2;
    const lanes v3d3 = puma560_geometry_D3 * vA3d3 + v3r2;
    const lanes v1d3 = v1r2 - puma560_geometry_D3 * vA1d3;
    const lanes E1e3 = C3 * E1e2 + S3 * E2e2;
    const lanes E2e3 = C3 * E2e2 - S3 * E1e2;
    const lanes e1e3 = C3 * e1j2 + S3 * e2j2;
    const lanes e2e3 = C3 * e2j2 - S3 * e1j2;
    const lanes l1e3 = C3 * v1d3 + S3 * v2d3;
    const lanes l2e3 = C3 * v2d3 - S3 * v1d3;
    const lanes e1j3 = qdr[2] * W2e3 + e1e3;
    const lanes e2j3 = e2e3 - qdr[2] * W1e3;
    const lanes e3j3 = qddr[1] + qddr[2];
    const lanes E3j3 = qdr[1] + qdr[2];
    const lanes vP31r3 = W1e3 * E3j3;
    const lanes vA1r3 = e2j3 + vP31r3;
    const lanes vP32r3 = W2e3 * E3j3;
    const lanes vA2r3 = vP32r3 - e1j3;
    const lanes vP11r3 = W1e3 * E1e3;
    const lanes vP22r3 = W2e3 * E2e3;
    const lanes vA3r3 = vP11r3 + vP22r3;
    const lanes v1r3 = puma560_geometry_R3 * vA1r3 + l1e3;
    const lanes v2r3 = puma560_geometry_R3 * vA2r3 + l2e3;
    const lanes v3r3 = v3d3 - puma560_geometry_R3 * vA3r3;
    const lanes vP12d4 = W33 * E1e3;
    const lanes vA2d4 = vP12d4 - e2j3;
    const lanes vP13d4 = -W2e3 * E1e3;
    const lanes vA3d4 = vP13d4 - e3j3;
    const lanes vP22d4 = W33 * E3j3;
    const lanes vA1d4 = vP22r3 + vP22d4;
    const lanes v2d4 = puma560_geometry_D4 * vA2d4 + v3r3;
    const lanes v3d4 = puma560_geometry_D4 * vA3d4 - v2r3;
    const lanes v1d4 = v1r3 - puma560_geometry_D4 * vA1d4;
    const lanes E1e4 = C4 * E1e3 + S4 * E3j3;
    const lanes E2e4 = C4 * E3j3 - S4 * E1e3;
    const lanes e1e4 = C4 * e1j3 + S4 * e3j3;
    const lanes e2e4 = C4 * e3j3 - S4 * e1j3;
    const lanes l1e4 = C4 * v1d4 + S4 * v2d4;
    const lanes l2e4 = C4 * v2d4 - S4 * v1d4;
    const lanes e1j4 = qdr[3] * W2e4 + e1e4;
    const lanes e2j4 = e2e4 - qdr[3] * W1e4;
    const lanes e3j4 = qddr[3] - e2j3;
    const lanes E3j4 = qdr[3] - E2e3;
    const lanes vP31r4 = W1e4 * E3j4;
    const lanes vA1r4 = e2j4 + vP31r4;
    const lanes vP32r4 = W2e4 * E3j4;
    const lanes vA2r4 = vP32r4 - e1j4;
    const lanes vP11r4 = W1e4 * E1e4;
    const lanes vP22r4 = W2e4 * E2e4;
    const lanes vA3r4 = vP11r4 + vP22r4;
    const lanes v1r4 = puma560_geometry_R4 * vA1r4 + l1e4;
    const lanes v2r4 = puma560_geometry_R4 * vA2r4 + l2e4;
    const lanes v3r4 = v3d4 - puma560_geometry_R4 * vA3r4;
    const lanes E1e5 = C5 * E1e4 - S5 * E3j4;
    const lanes E2e5 = -C5 * E3j4 - S5 * E1e4;
    const lanes e1e5 = C5 * e1j4 - S5 * e3j4;
    const lanes e2e5 = -C5 * e3j4 - S5 * e1j4;
    const lanes l1e5 = C5 * v1r4 - S5 * v3r4;
    const lanes l2e5 = -C5 * v3r4 - S5 * v1r4;
    const lanes e1j5 = qdr[4] * W2e5 + e1e5;
    const lanes e2j5 = e2e5 - qdr[4] * W1e5;
    const lanes e3j5 = qddr[4] + e2j4;
    const lanes E3j5 = qdr[4] + E2e4;
    const lanes E1e6 = C6 * E1e5 + S6 * E3j5;
    const lanes E2e6 = C6 * E3j5 - S6 * E1e5;
    const lanes e1e6 = C6 * e1j5 + S6 * e3j5;
    const lanes e2e6 = C6 * e3j5 - S6 * e1j5;
    const lanes l1e6 = C6 * l1e5 + S6 * v2r4;
    const lanes l2e6 = C6 * v2r4 - S6 * l1e5;
    const lanes e1j6 = qdr[5] * W2e6 + e1e6;
    const lanes e2j6 = e2e6 - qdr[5] * W1e6;
    const lanes e3j6 = qddr[5] - e2j5;
    const lanes E3j6 = qdr[5] - E2e5;
    const lanes N1_3 = qddr[0] * X[0];
    const lanes h2_1 = -qd[1] * X[7];
    const lanes h2_2 = qd[1] * X[6];
    const lanes h2_3 = X[7] * W1e2 - X[6] * W2e2;
    const lanes t2 = X[1] + X[5];
    const lanes h2 = 0.5 * t2;
    const lanes j12 = X[1] - h2;
    const lanes j32 = X[5] - h2;
    const lanes k2_1 = qdr[1] * X[3] + X[2] * E2e2 + E1e2 * j12;
    const lanes k2_2 = qdr[1] * X[4] + X[2] * E1e2 - E2e2 * h2;
    const lanes k2_3 = qdr[1] * j32 + X[3] * E1e2 + X[4] * E2e2;
    const lanes F2_1 = E2e2 * h2_3 - qdr[1] * h2_2 - qddr[1] * X[7];
    const lanes F2_2 = qdr[1] * h2_1 + qddr[1] * X[6] - E1e2 * h2_3;
    const lanes N2_1 = qddr[1] * X[3] + X[1] * e1j2 + X[2] * e2j2 + X[7] * v3r2 + W2e2 * k2_3 - qd[1] * k2_2;
    const lanes N2_2 = qd[1] * k2_1 + qddr[1] * X[4] + X[2] * e1j2 - X[6] * v3r2 - W1e2 * k2_3;
    const lanes N2_3 = qddr[1] * X[5] + X[3] * e1j2 + X[4] * e2j2 + X[6] * v2r2 + W1e2 * k2_2 - X[7] * v1r2 - W2e2 * k2_1;
    const lanes h3_1 = -X[14] * W33;
    const lanes h3_2 = X[13] * W33;
    const lanes h3_3 = X[14] * W1e3 - X[13] * W2e3;
    const lanes t3 = X[8] + X[12];
    const lanes h3 = 0.5 * t3;
    const lanes j13 = X[8] - h3;
    const lanes j33 = X[12] - h3;
    const lanes k3_1 = X[9] * E2e3 + X[10] * E3j3 + E1e3 * j13;
    const lanes k3_2 = X[9] * E1e3 + X[11] * E3j3 - E2e3 * h3;
    const lanes k3_3 = X[10] * E1e3 + X[11] * E2e3 + E3j3 * j33;
    const lanes F3_1 = E2e3 * h3_3 - X[14] * e3j3 - E3j3 * h3_2;
    const lanes F3_2 = X[13] * e3j3 + E3j3 * h3_1 - E1e3 * h3_3;
    const lanes F3_3 = X[14] * e1j3 + E1e3 * h3_2 - X[13] * e2j3 - E2e3 * h3_1;
    const lanes N3_1 = X[8] * e1j3 + X[9] * e2j3 + X[10] * e3j3 + X[14] * v3r3 + W2e3 * k3_3 - W33 * k3_2;
    const lanes N3_2 = X[9] * e1j3 + X[11] * e3j3 + W33 * k3_1 - X[13] * v3r3 - W1e3 * k3_3;
    const lanes N3_3 = X[10] * e1j3 + X[11] * e2j3 + X[12] * e3j3 + X[13] * v2r3 + W1e3 * k3_2 - X[14] * v1r3 - W2e3 * k3_1;
    const lanes h4_1 = -X[22] * W34;
    const lanes h4_2 = X[21] * W34;
    const lanes h4_3 = X[22] * W1e4 - X[21] * W2e4;
    const lanes t4 = X[16] + X[20];
    const lanes h4 = 0.5 * t4;
    const lanes j14 = X[16] - h4;
    const lanes j34 = X[20] - h4;
    const lanes k4_1 = X[17] * E2e4 + X[18] * E3j4 + E1e4 * j14;
    const lanes k4_2 = X[17] * E1e4 + X[19] * E3j4 - E2e4 * h4;
    const lanes k4_3 = X[18] * E1e4 + X[19] * E2e4 + E3j4 * j34;
    const lanes F4_1 = E2e4 * h4_3 - X[22] * e3j4 - E3j4 * h4_2;
    const lanes F4_2 = X[21] * e3j4 + E3j4 * h4_1 - E1e4 * h4_3;
    const lanes F4_3 = X[22] * e1j4 + E1e4 * h4_2 - X[21] * e2j4 - E2e4 * h4_1;
    const lanes N4_1 = X[16] * e1j4 + X[17] * e2j4 + X[18] * e3j4 + X[22] * v3r4 + W2e4 * k4_3 - W34 * k4_2;
    const lanes N4_2 = X[17] * e1j4 + X[19] * e3j4 + W34 * k4_1 - X[21] * v3r4 - W1e4 * k4_3;
    const lanes N4_3 = X[18] * e1j4 + X[19] * e2j4 + X[20] * e3j4 + X[21] * v2r4 + W1e4 * k4_2 - X[22] * v1r4 - W2e4 * k4_1;
    const lanes h5_1 = -X[30] * W35;
    const lanes h5_2 = X[29] * W35;
    const lanes h5_3 = X[30] * W1e5 - X[29] * W2e5;
    const lanes t5 = X[24] + X[28];
    const lanes h5 = 0.5 * t5;
    const lanes j15 = X[24] - h5;
    const lanes j35 = X[28] - h5;
    const lanes k5_1 = X[25] * E2e5 + X[26] * E3j5 + E1e5 * j15;
    const lanes k5_2 = X[25] * E1e5 + X[27] * E3j5 - E2e5 * h5;
    const lanes k5_3 = X[26] * E1e5 + X[27] * E2e5 + E3j5 * j35;
    const lanes F5_1 = E2e5 * h5_3 - X[30] * e3j5 - E3j5 * h5_2;
    const lanes F5_2 = X[29] * e3j5 + E3j5 * h5_1 - E1e5 * h5_3;
    const lanes F5_3 = X[30] * e1j5 + E1e5 * h5_2 - X[29] * e2j5 - E2e5 * h5_1;
    const lanes N5_1 = X[24] * e1j5 + X[25] * e2j5 + X[26] * e3j5 + X[30] * v2r4 + W2e5 * k5_3 - W35 * k5_2;
    const lanes N5_2 = X[25] * e1j5 + X[27] * e3j5 + W35 * k5_1 - X[29] * v2r4 - W1e5 * k5_3;
    const lanes N5_3 = X[26] * e1j5 + X[27] * e2j5 + X[28] * e3j5 + X[29] * l2e5 + W1e5 * k5_2 - X[30] * l1e5 - W2e5 * k5_1;
    const lanes h6_1 = -X[38] * W36;
    const lanes h6_2 = X[37] * W36;
    const lanes h6_3 = X[38] * W1e6 - X[37] * W2e6;
    const lanes t6 = X[32] + X[36];
    const lanes h6 = 0.5 * t6;
    const lanes j16 = X[32] - h6;
    const lanes j36 = X[36] - h6;
    const lanes k6_1 = X[33] * E2e6 + X[34] * E3j6 + E1e6 * j16;
    const lanes k6_2 = X[33] * E1e6 + X[35] * E3j6 - E2e6 * h6;
    const lanes k6_3 = X[34] * E1e6 + X[35] * E2e6 + E3j6 * j36;
    const lanes F6_1 = E2e6 * h6_3 - X[38] * e3j6 - E3j6 * h6_2;
    const lanes F6_2 = X[37] * e3j6 + E3j6 * h6_1 - E1e6 * h6_3;
    const lanes F6_3 = X[38] * e1j6 + E1e6 * h6_2 - X[37] * e2j6 - E2e6 * h6_1;
    const lanes N6_1 = X[32] * e1j6 + X[33] * e2j6 + X[34] * e3j6 + W2e6 * k6_3 - X[38] * l2e5 - W36 * k6_2;
    const lanes N6_2 = X[33] * e1j6 + X[35] * e3j6 + X[37] * l2e5 + W36 * k6_1 - W1e6 * k6_3;
    const lanes N6_3 = X[34] * e1j6 + X[35] * e2j6 + X[36] * e3j6 + X[37] * l2e6 + W1e6 * k6_2 - X[38] * l1e6 - W2e6 * k6_1;
    const lanes Fbs1e6 = C6 * F6_1 - S6 * F6_2;
    const lanes Fbs2e6 = C6 * F6_2 + S6 * F6_1;
    const lanes Nbs1e6 = C6 * N6_1 - S6 * N6_2;
    const lanes Nbs2e6 = C6 * N6_2 + S6 * N6_1;
    const lanes Fss5_6_1 = F5_1 + Fbs1e6;
    const lanes Fss5_6_2 = F5_2 - F6_3;
    const lanes Fss5_6_3 = F5_3 + Fbs2e6;
    const lanes Nss5_6_1 = N5_1 + Nbs1e6;
    const lanes Nss5_6_2 = N5_2 - N6_3;
    const lanes Nss5_6_3 = N5_3 + Nbs2e6;
    const lanes Fbs1e5 = C5 * Fss5_6_1 - S5 * Fss5_6_2;
    const lanes Fbs2e5 = C5 * Fss5_6_2 + S5 * Fss5_6_1;
    const lanes Nbs1e5 = C5 * Nss5_6_1 - S5 * Nss5_6_2;
    const lanes Nbs2e5 = C5 * Nss5_6_2 + S5 * Nss5_6_1;
    const lanes Fss4_5_1 = F4_1 + Fbs1e5;
    const lanes Fss4_5_2 = F4_2 + Fss5_6_3;
    const lanes Fss4_5_3 = F4_3 - Fbs2e5;
    const lanes Nss4_5_1 = N4_1 + Nbs1e5;
    const lanes Nss4_5_2 = N4_2 + Nss5_6_3;
    const lanes Nss4_5_3 = N4_3 - Nbs2e5;
    const lanes Nbs1r4 = Nss4_5_1 - puma560_geometry_R4 * Fss4_5_2;
    const lanes Nbs2r4 = puma560_geometry_R4 * Fss4_5_1 + Nss4_5_2;
    const lanes Fbs1e4 = C4 * Fss4_5_1 - S4 * Fss4_5_2;
    const lanes Fbs2e4 = C4 * Fss4_5_2 + S4 * Fss4_5_1;
    const lanes Nbs1e4 = C4 * Nbs1r4 - S4 * Nbs2r4;
    const lanes Nbs2e4 = C4 * Nbs2r4 + S4 * Nbs1r4;
    const lanes Nbs2d4 = Nbs2e4 - puma560_geometry_D4 * Fss4_5_3;
    const lanes Nbs3d4 = puma560_geometry_D4 * Fbs2e4 + Nss4_5_3;
    const lanes Fss3_4_1 = F3_1 + Fbs1e4;
    const lanes Fss3_4_2 = F3_2 - Fss4_5_3;
    const lanes Fss3_4_3 = F3_3 + Fbs2e4;
    const lanes Nss3_4_1 = N3_1 + Nbs1e4;
    const lanes Nss3_4_2 = N3_2 - Nbs3d4;
    const lanes Nss3_4_3 = N3_3 + Nbs2d4;
    const lanes Nbs1r3 = Nss3_4_1 - puma560_geometry_R3 * Fss3_4_2;
    const lanes Nbs2r3 = puma560_geometry_R3 * Fss3_4_1 + Nss3_4_2;
    const lanes Fbs1e3 = C3 * Fss3_4_1 - S3 * Fss3_4_2;
    const lanes Fbs2e3 = C3 * Fss3_4_2 + S3 * Fss3_4_1;
    const lanes Nbs1e3 = C3 * Nbs1r3 - S3 * Nbs2r3;
    const lanes Nbs2e3 = C3 * Nbs2r3 + S3 * Nbs1r3;
    const lanes Nbs2d3 = Nbs2e3 - puma560_geometry_D3 * Fss3_4_3;
    const lanes Nbs3d3 = puma560_geometry_D3 * Fbs2e3 + Nss3_4_3;
    const lanes Fss2_3_1 = F2_1 + Fbs1e3;
    const lanes Fss2_3_2 = F2_2 + Fbs2e3;
    const lanes Nss2_3_1 = N2_1 + Nbs1e3;
    const lanes Nss2_3_2 = N2_2 + Nbs2d3;
    const lanes Nss2_3_3 = N2_3 + Nbs3d3;
    const lanes Nbs1r2 = Nss2_3_1 - puma560_geometry_R2 * Fss2_3_2;
    const lanes Nbs2r2 = puma560_geometry_R2 * Fss2_3_1 + Nss2_3_2;
    const lanes Nbs2e2 = C2 * Nbs2r2 + S2 * Nbs1r2;
    const lanes Nss1_2_3 = N1_3 - Nbs2e2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T1 = qd[0] * X[41] + X[40] * sFS1 + Nss1_2_3;
    lanes_put(&tau[0], T1, stream);
    const lanes T2 = qd[1] * X[43] + X[42] * sFS2 + Nss2_3_3;
    lanes_put(&tau[1], T2, stream);
    const lanes T3 = qd[2] * X[45] + qddr[2] * X[15] + X[44] * sFS3 + Nss3_4_3;
    lanes_put(&tau[2], T3, stream);
    const lanes T4 = qd[3] * X[47] + qddr[3] * X[23] + X[46] * sFS4 + Nss4_5_3;
    lanes_put(&tau[3], T4, stream);
    const lanes T5 = qd[4] * X[49] + qddr[4] * X[31] + X[48] * sFS5 + Nss5_6_3;
    lanes_put(&tau[4], T5, stream);
    const lanes T6 = qd[5] * X[51] + qddr[5] * X[39] + X[50] * sFS6 + N6_3;
    lanes_put(&tau[5], T6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, const lanes *X, apart *tau)
{
    return panel(q, qd, qdr, qddr, X, tau, 0);
}

int puma560_slotine_li_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[4] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdr[REACH(6u)];
    lanes lanes_qdr[BLOCKS(6u)];
    double padded_qddr[REACH(6u)];
    lanes lanes_qddr[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdr, 6u, lanes_qdr);
    lanes_shared(qddr, 6u, lanes_qddr);
    lanes_shared(X, 52u, lanes_X);
    lanes lanes_tau[BLOCKS(6u)];
    double scratch[6u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_tau, 0, sizeof lanes_tau);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdr != 0u) {
            lanes_read(qdr, 6u, stride_qdr, k, N, padded_qdr, lanes_qdr);
        }
        if (stride_qddr != 0u) {
            lanes_read(qddr, 6u, stride_qddr, k, N, padded_qddr, lanes_qddr);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, (apart *)lanes_tau);
        lanes_store(lanes_tau, 6u, count, stream, scratch, &tau[k * 6u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[4] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdr[REACH(6u)];
    lanes lanes_qdr[BLOCKS(6u)];
    double padded_qddr[REACH(6u)];
    lanes lanes_qddr[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdr, 6u, lanes_qdr);
    lanes_shared(qddr, 6u, lanes_qddr);
    lanes_shared(X, 52u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdr != 0u) {
            lanes_read(qdr, 6u, stride_qdr, k, N, padded_qdr, lanes_qdr);
        }
        if (stride_qddr != 0u) {
            lanes_read(qddr, 6u, stride_qddr, k, N, padded_qddr, lanes_qddr);
        }
        if (stride_X != 0u) {
            lanes_read(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_tau = (apart *)&tau[k * 6u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, lanes_tau, 1) : plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_X, lanes_tau);
    }
    return status;
}

int puma560_slotine_li_torque_panels(int stream, size_t N, const size_t *strides,
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

int puma560_slotine_li_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[4] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_slotine_li_torque(&q[k * stride_q], &qd[k * stride_qd], &qdr[k * stride_qdr], &qddr[k * stride_qddr], &X[k * stride_X], &tau[k * 6u]);
    }
    return status;
}

int puma560_slotine_li_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    return puma560_slotine_li_torque_rows(stream, N, strides, q, qd, qdr, qddr, X, tau);
}

#endif

size_t puma560_slotine_li_torque_width(void)
{
    return puma560_WIDTH;
}

void puma560_slotine_li_torque_batch(size_t N, const double *q, const double *qd, const double *qdr, const double *qddr, const double *X, double *tau)
{
    (void)puma560_slotine_li_torque_rows(0, N, NULL, q, qd, qdr, qddr, X, tau);
}
