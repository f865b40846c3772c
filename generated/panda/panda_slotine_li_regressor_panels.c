/* panda: slotine_li_regressor of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, apart *out, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    lanes_put(&out[0], qddr[0], stream);
    lanes_put(&out[49], qd[0], stream);
    lanes_put(&out[113], qd[1], stream);
    lanes_put(&out[139], qddr[2], stream);
    lanes_put(&out[177], qd[2], stream);
    lanes_put(&out[209], qddr[3], stream);
    lanes_put(&out[241], qd[3], stream);
    lanes_put(&out[279], qddr[4], stream);
    lanes_put(&out[305], qd[4], stream);
    lanes_put(&out[349], qddr[5], stream);
    lanes_put(&out[369], qd[5], stream);
    lanes_put(&out[419], qddr[6], stream);
    lanes_put(&out[433], qd[6], stream);
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
    const lanes sFS1 = lanes_sign(qd[0]);
    lanes_put(&out[48], sFS1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    lanes_put(&out[112], sFS2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    lanes_put(&out[176], sFS3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    lanes_put(&out[240], sFS4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    lanes_put(&out[304], sFS5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    lanes_put(&out[368], sFS6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    lanes_put(&out[432], sFS7, stream);
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
    const lanes E1_1e3 = -S2 * C3;
    const lanes E1_2e3 = S2 * S3;
    const lanes L1_1r3 = panda_geometry_R3 * E1_2e3;
    const lanes L1_2r3 = -panda_geometry_R3 * E1_1e3;
    const lanes L2_1r3 = panda_geometry_R3 * C3;
    const lanes L2_2r3 = -panda_geometry_R3 * S3;
    const lanes L1_2d4 = -panda_geometry_D4 * E1_2e3;
    const lanes L1_3d4 = -panda_geometry_D4 * C2 - L1_2r3;
    const lanes L2_2d4 = -panda_geometry_D4 * C3;
    const lanes E1_1e4 = C2 * S4 + C4 * E1_1e3;
    const lanes E1_2e4 = C2 * C4 - S4 * E1_1e3;
    const lanes L1_1e4 = C4 * L1_1r3 + S4 * L1_2d4;
    const lanes L1_2e4 = C4 * L1_2d4 - S4 * L1_1r3;
    const lanes E2_1e4 = S3 * C4;
    const lanes E2_2e4 = -S3 * S4;
    const lanes L2_1e4 = C4 * L2_1r3 + S4 * L2_2d4;
    const lanes L2_2e4 = C4 * L2_2d4 - S4 * L2_1r3;
    const lanes L1_2d5 = -panda_geometry_D4 * E1_2e4 - L1_3d4;
    const lanes L1_3d5 = panda_geometry_D4 * E1_2e3 + L1_2e4;
    const lanes L2_2d5 = L2_2r3 - panda_geometry_D4 * E2_2e4;
    const lanes L2_3d5 = panda_geometry_D4 * C3 + L2_2e4;
    const lanes L3_2d5 = panda_geometry_D4 - panda_geometry_D4 * C4;
    const lanes E1_1e5 = C5 * E1_1e4 + S5 * E1_2e3;
    const lanes E1_2e5 = C5 * E1_2e3 - S5 * E1_1e4;
    const lanes L1_1e5 = C5 * L1_1e4 + S5 * L1_2d5;
    const lanes L1_2e5 = C5 * L1_2d5 - S5 * L1_1e4;
    const lanes L1_1r5 = panda_geometry_R5 * E1_2e5 + L1_1e5;
    const lanes L1_2r5 = L1_2e5 - panda_geometry_R5 * E1_1e5;
    const lanes E2_1e5 = C3 * S5 + C5 * E2_1e4;
    const lanes E2_2e5 = C3 * C5 - S5 * E2_1e4;
    const lanes L2_1e5 = C5 * L2_1e4 + S5 * L2_2d5;
    const lanes L2_2e5 = C5 * L2_2d5 - S5 * L2_1e4;
    const lanes L2_1r5 = panda_geometry_R5 * E2_2e5 + L2_1e5;
    const lanes L2_2r5 = L2_2e5 - panda_geometry_R5 * E2_1e5;
    const lanes E3_1e5 = S4 * C5;
    const lanes E3_2e5 = -S4 * S5;
    const lanes L3_1e5 = S5 * L3_2d5;
    const lanes L3_2e5 = C5 * L3_2d5;
    const lanes L3_1r5 = panda_geometry_R5 * E3_2e5 + L3_1e5;
    const lanes L3_2r5 = L3_2e5 - panda_geometry_R5 * E3_1e5;
    const lanes L4_1r5 = -panda_geometry_R5 * C5;
    const lanes L4_2r5 = panda_geometry_R5 * S5;
    const lanes E1_1e6 = C6 * E1_1e5 + S6 * E1_2e4;
    const lanes E1_2e6 = C6 * E1_2e4 - S6 * E1_1e5;
    const lanes L1_1e6 = C6 * L1_1r5 + S6 * L1_3d5;
    const lanes L1_2e6 = C6 * L1_3d5 - S6 * L1_1r5;
    const lanes E2_1e6 = C6 * E2_1e5 + S6 * E2_2e4;
    const lanes E2_2e6 = C6 * E2_2e4 - S6 * E2_1e5;
    const lanes L2_1e6 = C6 * L2_1r5 + S6 * L2_3d5;
    const lanes L2_2e6 = C6 * L2_3d5 - S6 * L2_1r5;
    const lanes E3_1e6 = C4 * S6 + C6 * E3_1e5;
    const lanes E3_2e6 = C4 * C6 - S6 * E3_1e5;
    const lanes L3_1e6 = C6 * L3_1r5;
    const lanes L3_2e6 = -S6 * L3_1r5;
    const lanes E4_1e6 = -S5 * C6;
    const lanes E4_2e6 = S5 * S6;
    const lanes L4_1e6 = C6 * L4_1r5 - panda_geometry_D4 * S6;
    const lanes L4_2e6 = -panda_geometry_D4 * C6 - S6 * L4_1r5;
    const lanes L1_2d7 = -panda_geometry_D7 * E1_2e6 - L1_2r5;
    const lanes L1_3d7 = panda_geometry_D7 * E1_2e5 - L1_2e6;
    const lanes L2_2d7 = -panda_geometry_D7 * E2_2e6 - L2_2r5;
    const lanes L2_3d7 = panda_geometry_D7 * E2_2e5 - L2_2e6;
    const lanes L3_2d7 = -panda_geometry_D7 * E3_2e6 - L3_2r5;
    const lanes L3_3d7 = panda_geometry_D7 * E3_2e5 - L3_2e6;
    const lanes L4_2d7 = -panda_geometry_D7 * E4_2e6 - L4_2r5;
    const lanes L4_3d7 = -panda_geometry_D7 * C5 - L4_2e6;
    const lanes L5_2d7 = -panda_geometry_D7 * C6;
    const lanes E1_1e7 = C7 * E1_1e6 - S7 * E1_2e5;
    const lanes E1_2e7 = -C7 * E1_2e5 - S7 * E1_1e6;
    const lanes L1_1e7 = C7 * L1_1e6 + S7 * L1_2d7;
    const lanes L1_2e7 = C7 * L1_2d7 - S7 * L1_1e6;
    const lanes E2_1e7 = C7 * E2_1e6 - S7 * E2_2e5;
    const lanes E2_2e7 = -C7 * E2_2e5 - S7 * E2_1e6;
    const lanes L2_1e7 = C7 * L2_1e6 + S7 * L2_2d7;
    const lanes L2_2e7 = C7 * L2_2d7 - S7 * L2_1e6;
    const lanes E3_1e7 = C7 * E3_1e6 - S7 * E3_2e5;
    const lanes E3_2e7 = -C7 * E3_2e5 - S7 * E3_1e6;
    const lanes L3_1e7 = C7 * L3_1e6 + S7 * L3_2d7;
    const lanes L3_2e7 = C7 * L3_2d7 - S7 * L3_1e6;
    const lanes E4_1e7 = C5 * S7 + C7 * E4_1e6;
    const lanes E4_2e7 = C5 * C7 - S7 * E4_1e6;
    const lanes L4_1e7 = C7 * L4_1e6 + S7 * L4_2d7;
    const lanes L4_2e7 = C7 * L4_2d7 - S7 * L4_1e6;
    const lanes E5_1e7 = S6 * C7;
    const lanes E5_2e7 = -S6 * S7;
    const lanes L5_1e7 = S7 * L5_2d7;
    const lanes L5_2e7 = C7 * L5_2d7;
    const lanes W1e2 = -qd[0] * S2;
    const lanes W2e2 = -qd[0] * C2;
    const lanes G1e2 = gz * S2;
    lanes_put(&out[69], G1e2, stream);
    const lanes G2e2 = gz * C2;
    lanes_put(&out[68], -G2e2, stream);
    const lanes W1e3 = qd[1] * S3 + C3 * W1e2;
    const lanes W2e3 = qd[1] * C3 - S3 * W1e2;
    const lanes G1e3 = C3 * G1e2;
    const lanes G2e3 = -S3 * G1e2;
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
    const lanes nXX2_3 = -0.5 * W1e2 * E2e2 - 0.5 * W2e2 * E1e2;
    lanes_put(&out[63], nXX2_3, stream);
    const lanes nXY2_3 = W1e2 * E1e2 - W2e2 * E2e2;
    lanes_put(&out[64], nXY2_3, stream);
    const lanes nZZ2_3 = 0.5 * W2e2 * E1e2 + qddr[1] - 0.5 * W1e2 * E2e2;
    lanes_put(&out[67], nZZ2_3, stream);
    const lanes e1e2 = -qddr[0] * S2;
    const lanes e1j2 = qdr[1] * W2e2 + e1e2;
    const lanes nXZ2_3 = e1j2 - qdr[1] * W2e2;
    lanes_put(&out[65], nXZ2_3, stream);
    const lanes e2e2 = -qddr[0] * C2;
    const lanes e2j2 = e2e2 - qdr[1] * W1e2;
    const lanes nYZ2_3 = qdr[1] * W1e2 + e2j2;
    lanes_put(&out[66], nYZ2_3, stream);
    const lanes E1e3 = qdr[1] * S3 + C3 * E1e2;
    const lanes E2e3 = qdr[1] * C3 - S3 * E1e2;
    const lanes e1e3 = qddr[1] * S3 + C3 * e1j2;
    const lanes e1j3 = qdr[2] * W2e3 + e1e3;
    const lanes e2e3 = qddr[1] * C3 - S3 * e1j2;
    const lanes e2j3 = e2e3 - qdr[2] * W1e3;
    const lanes e3j3 = qddr[2] - e2j2;
    const lanes nXY2_1 = e2j2 - qd[1] * E1e2;
    const lanes E3j3 = qdr[2] - E2e2;
    const lanes vP31r3 = W1e3 * E3j3;
    const lanes vA1r3 = e2j3 + vP31r3;
    const lanes v1r3 = panda_geometry_R3 * vA1r3 - G1e3;
    lanes_put(&out[138], -v1r3, stream);
    const lanes vP32r3 = W2e3 * E3j3;
    const lanes vA2r3 = vP32r3 - e1j3;
    const lanes v2r3 = panda_geometry_R3 * vA2r3 - G2e3;
    lanes_put(&out[137], v2r3, stream);
    const lanes vP11r3 = W1e3 * E1e3;
    const lanes vP22r3 = W2e3 * E2e3;
    const lanes vA3r3 = vP11r3 + vP22r3;
    const lanes v3r3 = G2e2 - panda_geometry_R3 * vA3r3;
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
    lanes_put(&out[208], -l1e4, stream);
    const lanes l2e4 = C4 * v2d4 - S4 * v1d4;
    lanes_put(&out[207], l2e4, stream);
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
    lanes_put(&out[278], -v1r5, stream);
    const lanes vP32r5 = W2e5 * E3j5;
    const lanes vA2r5 = vP32r5 - e1j5;
    const lanes v2r5 = panda_geometry_R5 * vA2r5 + l2e5;
    lanes_put(&out[277], v2r5, stream);
    const lanes TMX6_5 = C6 * v2r5;
    lanes_put(&out[285], TMX6_5, stream);
    const lanes TMY6_5 = -S6 * v2r5;
    lanes_put(&out[286], TMY6_5, stream);
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
    lanes_put(&out[348], -l1e6, stream);
    const lanes l2e6 = C6 * v3r5 - S6 * v1r5;
    lanes_put(&out[347], l2e6, stream);
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
    lanes_put(&out[418], -l1e7, stream);
    const lanes l2e7 = C7 * v2d7 - S7 * v1d7;
    lanes_put(&out[417], l2e7, stream);
    const lanes e3j7 = qddr[6] - e2j6;
    const lanes E3j7 = qdr[6] - E2e6;
    const lanes nXX2_1 = 0.5 * qd[1] * E2e2 + e1j2 - 0.5 * qdr[1] * W2e2;
    const lanes nXY2_2 = qd[1] * E2e2 + e1j2;
    const lanes TXY2_1 = -C2 * nXY2_2 - S2 * nXY2_1;
    lanes_put(&out[2], TXY2_1, stream);
    const lanes nXX2_2 = 0.5 * qd[1] * E1e2 + 0.5 * qdr[1] * W1e2;
    const lanes TXX2_1 = -C2 * nXX2_2 - S2 * nXX2_1;
    lanes_put(&out[1], TXX2_1, stream);
    const lanes nXZ2_1 = qddr[1] + W2e2 * E1e2;
    const lanes nXZ2_2 = qd[1] * qdr[1] - W1e2 * E1e2;
    const lanes TXZ2_1 = -C2 * nXZ2_2 - S2 * nXZ2_1;
    lanes_put(&out[3], TXZ2_1, stream);
    const lanes nYZ2_2 = qddr[1] - W1e2 * E2e2;
    const lanes nYY2_1 = -0.5 * qd[1] * E2e2 - 0.5 * qdr[1] * W2e2;
    const lanes nYZ2_1 = W2e2 * E2e2 - qd[1] * qdr[1];
    const lanes TYZ2_1 = -C2 * nYZ2_2 - S2 * nYZ2_1;
    lanes_put(&out[4], TYZ2_1, stream);
    const lanes TZZ2_1 = C2 * nXX2_2 + S2 * nYY2_1;
    lanes_put(&out[5], TZZ2_1, stream);
    const lanes nXX3_1 = 0.5 * W33 * E2e3 + e1j3 - 0.5 * W2e3 * E3j3;
    const lanes nXX3_2 = 0.5 * W1e3 * E3j3 + 0.5 * W33 * E1e3;
    const lanes TXX3_2 = C3 * nXX3_2 + S3 * nXX3_1;
    lanes_put(&out[70], TXX3_2, stream);
    const lanes nXX3_3 = -0.5 * W1e3 * E2e3 - 0.5 * W2e3 * E1e3;
    lanes_put(&out[132], nXX3_3, stream);
    const lanes TXX3_1 = C2 * nXX3_3 + E1_1e3 * nXX3_1 + E1_2e3 * nXX3_2;
    lanes_put(&out[8], TXX3_1, stream);
    const lanes nXY3_1 = e2j3 - W33 * E1e3;
    const lanes nYZ3_3 = W1e3 * E3j3 + e2j3;
    lanes_put(&out[135], nYZ3_3, stream);
    const lanes nXY3_2 = W33 * E2e3 + e1j3;
    const lanes TXY3_2 = C3 * nXY3_2 + S3 * nXY3_1;
    lanes_put(&out[71], TXY3_2, stream);
    const lanes nXZ3_3 = e1j3 - W2e3 * E3j3;
    lanes_put(&out[134], nXZ3_3, stream);
    const lanes nXY3_3 = W1e3 * E1e3 - W2e3 * E2e3;
    lanes_put(&out[133], nXY3_3, stream);
    const lanes TXY3_1 = C2 * nXY3_3 + E1_1e3 * nXY3_1 + E1_2e3 * nXY3_2;
    lanes_put(&out[9], TXY3_1, stream);
    const lanes nXZ3_1 = W2e3 * E1e3 + e3j3;
    const lanes nXZ3_2 = W33 * E3j3 - W1e3 * E1e3;
    const lanes TXZ3_1 = C2 * nXZ3_3 + E1_1e3 * nXZ3_1 + E1_2e3 * nXZ3_2;
    lanes_put(&out[10], TXZ3_1, stream);
    const lanes TXZ3_2 = C3 * nXZ3_2 + S3 * nXZ3_1;
    lanes_put(&out[72], TXZ3_2, stream);
    const lanes nYY3_1 = -0.5 * W2e3 * E3j3 - 0.5 * W33 * E2e3;
    const lanes TZZ3_2 = -C3 * nXX3_2 - S3 * nYY3_1;
    lanes_put(&out[74], TZZ3_2, stream);
    const lanes nYZ3_1 = W2e3 * E2e3 - W33 * E3j3;
    const lanes nYZ3_2 = e3j3 - W1e3 * E2e3;
    const lanes TYZ3_1 = C2 * nYZ3_3 + E1_1e3 * nYZ3_1 + E1_2e3 * nYZ3_2;
    lanes_put(&out[11], TYZ3_1, stream);
    const lanes TYZ3_2 = C3 * nYZ3_2 + S3 * nYZ3_1;
    lanes_put(&out[73], TYZ3_2, stream);
    const lanes nZZ3_3 = 0.5 * W2e3 * E1e3 + e3j3 - 0.5 * W1e3 * E2e3;
    lanes_put(&out[136], nZZ3_3, stream);
    const lanes TZZ3_1 = C2 * nZZ3_3 - E1_1e3 * nYY3_1 - E1_2e3 * nXX3_2;
    lanes_put(&out[12], TZZ3_1, stream);
    const lanes fMX3_1 = -W2e3 * E2e3 - W33 * E3j3;
    const lanes TMX3_1 = C2 * v2r3 + L1_1r3 * fMX3_1 + L1_2r3 * nXZ3_1 - E1_2e3 * v3r3;
    lanes_put(&out[13], TMX3_1, stream);
    const lanes TMX3_2 = L2_1r3 * fMX3_1 + L2_2r3 * nXZ3_1 - C3 * v3r3;
    lanes_put(&out[75], TMX3_2, stream);
    const lanes fMY3_2 = -W1e3 * E1e3 - W33 * E3j3;
    const lanes TMY3_1 = E1_1e3 * v3r3 + L1_2r3 * fMY3_2 - C2 * v1r3 - L1_1r3 * nYZ3_2;
    lanes_put(&out[14], TMY3_1, stream);
    const lanes TMY3_2 = S3 * v3r3 + L2_2r3 * fMY3_2 - L2_1r3 * nYZ3_2;
    lanes_put(&out[76], TMY3_2, stream);
    const lanes nXX4_1 = 0.5 * W34 * E2e4 + e1j4 - 0.5 * W2e4 * E3j4;
    const lanes nXX4_2 = 0.5 * W1e4 * E3j4 + 0.5 * W34 * E1e4;
    const lanes TXX4_3 = C4 * nXX4_2 + S4 * nXX4_1;
    lanes_put(&out[140], TXX4_3, stream);
    const lanes nXX4_3 = -0.5 * W1e4 * E2e4 - 0.5 * W2e4 * E1e4;
    lanes_put(&out[202], nXX4_3, stream);
    const lanes TXX4_1 = E1_1e4 * nXX4_1 + E1_2e4 * nXX4_2 - E1_2e3 * nXX4_3;
    lanes_put(&out[16], TXX4_1, stream);
    const lanes TXX4_2 = E2_1e4 * nXX4_1 + E2_2e4 * nXX4_2 - C3 * nXX4_3;
    lanes_put(&out[78], TXX4_2, stream);
    const lanes nXY4_1 = e2j4 - W34 * E1e4;
    const lanes nYZ4_3 = W1e4 * E3j4 + e2j4;
    lanes_put(&out[205], nYZ4_3, stream);
    const lanes TMX4_3 = panda_geometry_D4 * nXY4_1 - C4 * v3d4;
    lanes_put(&out[145], TMX4_3, stream);
    const lanes nXY4_2 = W34 * E2e4 + e1j4;
    const lanes TXY4_3 = C4 * nXY4_2 + S4 * nXY4_1;
    lanes_put(&out[141], TXY4_3, stream);
    const lanes nXZ4_3 = e1j4 - W2e4 * E3j4;
    lanes_put(&out[204], nXZ4_3, stream);
    const lanes TMY4_3 = S4 * v3d4 - panda_geometry_D4 * nXY4_2;
    lanes_put(&out[146], TMY4_3, stream);
    const lanes nXY4_3 = W1e4 * E1e4 - W2e4 * E2e4;
    lanes_put(&out[203], nXY4_3, stream);
    const lanes TXY4_1 = E1_1e4 * nXY4_1 + E1_2e4 * nXY4_2 - E1_2e3 * nXY4_3;
    lanes_put(&out[17], TXY4_1, stream);
    const lanes TXY4_2 = E2_1e4 * nXY4_1 + E2_2e4 * nXY4_2 - C3 * nXY4_3;
    lanes_put(&out[79], TXY4_2, stream);
    const lanes nXZ4_1 = W2e4 * E1e4 + e3j4;
    const lanes nXZ4_2 = W34 * E3j4 - W1e4 * E1e4;
    const lanes TXZ4_1 = E1_1e4 * nXZ4_1 + E1_2e4 * nXZ4_2 - E1_2e3 * nXZ4_3;
    lanes_put(&out[18], TXZ4_1, stream);
    const lanes TXZ4_2 = E2_1e4 * nXZ4_1 + E2_2e4 * nXZ4_2 - C3 * nXZ4_3;
    lanes_put(&out[80], TXZ4_2, stream);
    const lanes TXZ4_3 = C4 * nXZ4_2 + S4 * nXZ4_1;
    lanes_put(&out[142], TXZ4_3, stream);
    const lanes nYY4_1 = -0.5 * W2e4 * E3j4 - 0.5 * W34 * E2e4;
    const lanes TZZ4_3 = -C4 * nXX4_2 - S4 * nYY4_1;
    lanes_put(&out[144], TZZ4_3, stream);
    const lanes nYZ4_1 = W2e4 * E2e4 - W34 * E3j4;
    const lanes nYZ4_2 = e3j4 - W1e4 * E2e4;
    const lanes TYZ4_1 = E1_1e4 * nYZ4_1 + E1_2e4 * nYZ4_2 - E1_2e3 * nYZ4_3;
    lanes_put(&out[19], TYZ4_1, stream);
    const lanes TYZ4_2 = E2_1e4 * nYZ4_1 + E2_2e4 * nYZ4_2 - C3 * nYZ4_3;
    lanes_put(&out[81], TYZ4_2, stream);
    const lanes TYZ4_3 = C4 * nYZ4_2 + S4 * nYZ4_1;
    lanes_put(&out[143], TYZ4_3, stream);
    const lanes nZZ4_3 = 0.5 * W2e4 * E1e4 + e3j4 - 0.5 * W1e4 * E2e4;
    lanes_put(&out[206], nZZ4_3, stream);
    const lanes TZZ4_1 = -E1_2e3 * nZZ4_3 - E1_1e4 * nYY4_1 - E1_2e4 * nXX4_2;
    lanes_put(&out[20], TZZ4_1, stream);
    const lanes TZZ4_2 = -C3 * nZZ4_3 - E2_1e4 * nYY4_1 - E2_2e4 * nXX4_2;
    lanes_put(&out[82], TZZ4_2, stream);
    const lanes fMX4_1 = -W2e4 * E2e4 - W34 * E3j4;
    const lanes TMX4_1 = L1_1e4 * fMX4_1 + L1_2e4 * nXZ4_1 - E1_2e3 * l2e4 - L1_3d4 * nXY4_1 - E1_2e4 * v3d4;
    lanes_put(&out[21], TMX4_1, stream);
    const lanes TMX4_2 = L2_2r3 * nXY4_1 + L2_1e4 * fMX4_1 + L2_2e4 * nXZ4_1 - C3 * l2e4 - E2_2e4 * v3d4;
    lanes_put(&out[83], TMX4_2, stream);
    const lanes fMY4_2 = -W1e4 * E1e4 - W34 * E3j4;
    const lanes TMY4_1 = E1_2e3 * l1e4 + L1_3d4 * nXY4_2 + E1_1e4 * v3d4 + L1_2e4 * fMY4_2 - L1_1e4 * nYZ4_2;
    lanes_put(&out[22], TMY4_1, stream);
    const lanes TMY4_2 = C3 * l1e4 + E2_1e4 * v3d4 + L2_2e4 * fMY4_2 - L2_2r3 * nXY4_2 - L2_1e4 * nYZ4_2;
    lanes_put(&out[84], TMY4_2, stream);
    const lanes nXX5_1 = 0.5 * W35 * E2e5 + e1j5 - 0.5 * W2e5 * E3j5;
    const lanes nXX5_2 = 0.5 * W1e5 * E3j5 + 0.5 * W35 * E1e5;
    const lanes TXX5_4 = -C5 * nXX5_2 - S5 * nXX5_1;
    lanes_put(&out[210], TXX5_4, stream);
    const lanes nXX5_3 = -0.5 * W1e5 * E2e5 - 0.5 * W2e5 * E1e5;
    lanes_put(&out[272], nXX5_3, stream);
    const lanes TXX5_1 = E1_2e4 * nXX5_3 + E1_1e5 * nXX5_1 + E1_2e5 * nXX5_2;
    lanes_put(&out[24], TXX5_1, stream);
    const lanes TXX5_2 = E2_2e4 * nXX5_3 + E2_1e5 * nXX5_1 + E2_2e5 * nXX5_2;
    lanes_put(&out[86], TXX5_2, stream);
    const lanes TXX5_3 = C4 * nXX5_3 + E3_1e5 * nXX5_1 + E3_2e5 * nXX5_2;
    lanes_put(&out[148], TXX5_3, stream);
    const lanes nXY5_1 = e2j5 - W35 * E1e5;
    const lanes nYZ5_3 = W1e5 * E3j5 + e2j5;
    lanes_put(&out[275], nYZ5_3, stream);
    const lanes nXY5_2 = W35 * E2e5 + e1j5;
    const lanes TXY5_4 = -C5 * nXY5_2 - S5 * nXY5_1;
    lanes_put(&out[211], TXY5_4, stream);
    const lanes nXZ5_3 = e1j5 - W2e5 * E3j5;
    lanes_put(&out[274], nXZ5_3, stream);
    const lanes nXY5_3 = W1e5 * E1e5 - W2e5 * E2e5;
    lanes_put(&out[273], nXY5_3, stream);
    const lanes TXY5_1 = E1_2e4 * nXY5_3 + E1_1e5 * nXY5_1 + E1_2e5 * nXY5_2;
    lanes_put(&out[25], TXY5_1, stream);
    const lanes TXY5_2 = E2_2e4 * nXY5_3 + E2_1e5 * nXY5_1 + E2_2e5 * nXY5_2;
    lanes_put(&out[87], TXY5_2, stream);
    const lanes TXY5_3 = C4 * nXY5_3 + E3_1e5 * nXY5_1 + E3_2e5 * nXY5_2;
    lanes_put(&out[149], TXY5_3, stream);
    const lanes nXZ5_1 = W2e5 * E1e5 + e3j5;
    const lanes nXZ5_2 = W35 * E3j5 - W1e5 * E1e5;
    const lanes TXZ5_1 = E1_2e4 * nXZ5_3 + E1_1e5 * nXZ5_1 + E1_2e5 * nXZ5_2;
    lanes_put(&out[26], TXZ5_1, stream);
    const lanes TXZ5_2 = E2_2e4 * nXZ5_3 + E2_1e5 * nXZ5_1 + E2_2e5 * nXZ5_2;
    lanes_put(&out[88], TXZ5_2, stream);
    const lanes TXZ5_3 = C4 * nXZ5_3 + E3_1e5 * nXZ5_1 + E3_2e5 * nXZ5_2;
    lanes_put(&out[150], TXZ5_3, stream);
    const lanes TXZ5_4 = -C5 * nXZ5_2 - S5 * nXZ5_1;
    lanes_put(&out[212], TXZ5_4, stream);
    const lanes nYY5_1 = -0.5 * W2e5 * E3j5 - 0.5 * W35 * E2e5;
    const lanes TZZ5_4 = C5 * nXX5_2 + S5 * nYY5_1;
    lanes_put(&out[214], TZZ5_4, stream);
    const lanes nYZ5_1 = W2e5 * E2e5 - W35 * E3j5;
    const lanes nYZ5_2 = e3j5 - W1e5 * E2e5;
    const lanes TYZ5_1 = E1_2e4 * nYZ5_3 + E1_1e5 * nYZ5_1 + E1_2e5 * nYZ5_2;
    lanes_put(&out[27], TYZ5_1, stream);
    const lanes TYZ5_2 = E2_2e4 * nYZ5_3 + E2_1e5 * nYZ5_1 + E2_2e5 * nYZ5_2;
    lanes_put(&out[89], TYZ5_2, stream);
    const lanes TYZ5_3 = C4 * nYZ5_3 + E3_1e5 * nYZ5_1 + E3_2e5 * nYZ5_2;
    lanes_put(&out[151], TYZ5_3, stream);
    const lanes TYZ5_4 = -C5 * nYZ5_2 - S5 * nYZ5_1;
    lanes_put(&out[213], TYZ5_4, stream);
    const lanes nZZ5_3 = 0.5 * W2e5 * E1e5 + e3j5 - 0.5 * W1e5 * E2e5;
    lanes_put(&out[276], nZZ5_3, stream);
    const lanes TZZ5_1 = E1_2e4 * nZZ5_3 - E1_1e5 * nYY5_1 - E1_2e5 * nXX5_2;
    lanes_put(&out[28], TZZ5_1, stream);
    const lanes TZZ5_2 = E2_2e4 * nZZ5_3 - E2_1e5 * nYY5_1 - E2_2e5 * nXX5_2;
    lanes_put(&out[90], TZZ5_2, stream);
    const lanes TZZ5_3 = C4 * nZZ5_3 - E3_1e5 * nYY5_1 - E3_2e5 * nXX5_2;
    lanes_put(&out[152], TZZ5_3, stream);
    const lanes fMX5_1 = -W2e5 * E2e5 - W35 * E3j5;
    const lanes TMX5_1 = E1_2e4 * v2r5 + L1_1r5 * fMX5_1 + L1_2r5 * nXZ5_1 - L1_3d5 * nXY5_1 - E1_2e5 * v3r5;
    lanes_put(&out[29], TMX5_1, stream);
    const lanes TMX5_2 = E2_2e4 * v2r5 + L2_1r5 * fMX5_1 + L2_2r5 * nXZ5_1 - L2_3d5 * nXY5_1 - E2_2e5 * v3r5;
    lanes_put(&out[91], TMX5_2, stream);
    const lanes TMX5_3 = C4 * v2r5 + L3_1r5 * fMX5_1 + L3_2r5 * nXZ5_1 - E3_2e5 * v3r5;
    lanes_put(&out[153], TMX5_3, stream);
    const lanes TMX5_4 = panda_geometry_D4 * nXY5_1 + C5 * v3r5 + L4_1r5 * fMX5_1 + L4_2r5 * nXZ5_1;
    lanes_put(&out[215], TMX5_4, stream);
    const lanes fMY5_2 = -W1e5 * E1e5 - W35 * E3j5;
    const lanes TMY5_1 = L1_3d5 * nXY5_2 + E1_1e5 * v3r5 + L1_2r5 * fMY5_2 - E1_2e4 * v1r5 - L1_1r5 * nYZ5_2;
    lanes_put(&out[30], TMY5_1, stream);
    const lanes TMY5_2 = L2_3d5 * nXY5_2 + E2_1e5 * v3r5 + L2_2r5 * fMY5_2 - E2_2e4 * v1r5 - L2_1r5 * nYZ5_2;
    lanes_put(&out[92], TMY5_2, stream);
    const lanes TMY5_3 = E3_1e5 * v3r5 + L3_2r5 * fMY5_2 - C4 * v1r5 - L3_1r5 * nYZ5_2;
    lanes_put(&out[154], TMY5_3, stream);
    const lanes TMY5_4 = L4_2r5 * fMY5_2 - panda_geometry_D4 * nXY5_2 - S5 * v3r5 - L4_1r5 * nYZ5_2;
    lanes_put(&out[216], TMY5_4, stream);
    const lanes nXX6_1 = 0.5 * W36 * E2e6 + e1j6 - 0.5 * W2e6 * E3j6;
    const lanes nXX6_2 = 0.5 * W1e6 * E3j6 + 0.5 * W36 * E1e6;
    const lanes TXX6_5 = C6 * nXX6_2 + S6 * nXX6_1;
    lanes_put(&out[280], TXX6_5, stream);
    const lanes nXX6_3 = -0.5 * W1e6 * E2e6 - 0.5 * W2e6 * E1e6;
    lanes_put(&out[342], nXX6_3, stream);
    const lanes TXX6_1 = E1_1e6 * nXX6_1 + E1_2e6 * nXX6_2 - E1_2e5 * nXX6_3;
    lanes_put(&out[32], TXX6_1, stream);
    const lanes TXX6_2 = E2_1e6 * nXX6_1 + E2_2e6 * nXX6_2 - E2_2e5 * nXX6_3;
    lanes_put(&out[94], TXX6_2, stream);
    const lanes TXX6_3 = E3_1e6 * nXX6_1 + E3_2e6 * nXX6_2 - E3_2e5 * nXX6_3;
    lanes_put(&out[156], TXX6_3, stream);
    const lanes TXX6_4 = C5 * nXX6_3 + E4_1e6 * nXX6_1 + E4_2e6 * nXX6_2;
    lanes_put(&out[218], TXX6_4, stream);
    const lanes nXY6_1 = e2j6 - W36 * E1e6;
    const lanes nYZ6_3 = W1e6 * E3j6 + e2j6;
    lanes_put(&out[345], nYZ6_3, stream);
    const lanes nXY6_2 = W36 * E2e6 + e1j6;
    const lanes TXY6_5 = C6 * nXY6_2 + S6 * nXY6_1;
    lanes_put(&out[281], TXY6_5, stream);
    const lanes nXZ6_3 = e1j6 - W2e6 * E3j6;
    lanes_put(&out[344], nXZ6_3, stream);
    const lanes nXY6_3 = W1e6 * E1e6 - W2e6 * E2e6;
    lanes_put(&out[343], nXY6_3, stream);
    const lanes TXY6_1 = E1_1e6 * nXY6_1 + E1_2e6 * nXY6_2 - E1_2e5 * nXY6_3;
    lanes_put(&out[33], TXY6_1, stream);
    const lanes TXY6_2 = E2_1e6 * nXY6_1 + E2_2e6 * nXY6_2 - E2_2e5 * nXY6_3;
    lanes_put(&out[95], TXY6_2, stream);
    const lanes TXY6_3 = E3_1e6 * nXY6_1 + E3_2e6 * nXY6_2 - E3_2e5 * nXY6_3;
    lanes_put(&out[157], TXY6_3, stream);
    const lanes TXY6_4 = C5 * nXY6_3 + E4_1e6 * nXY6_1 + E4_2e6 * nXY6_2;
    lanes_put(&out[219], TXY6_4, stream);
    const lanes nXZ6_1 = W2e6 * E1e6 + e3j6;
    const lanes nXZ6_2 = W36 * E3j6 - W1e6 * E1e6;
    const lanes TXZ6_1 = E1_1e6 * nXZ6_1 + E1_2e6 * nXZ6_2 - E1_2e5 * nXZ6_3;
    lanes_put(&out[34], TXZ6_1, stream);
    const lanes TXZ6_2 = E2_1e6 * nXZ6_1 + E2_2e6 * nXZ6_2 - E2_2e5 * nXZ6_3;
    lanes_put(&out[96], TXZ6_2, stream);
    const lanes TXZ6_3 = E3_1e6 * nXZ6_1 + E3_2e6 * nXZ6_2 - E3_2e5 * nXZ6_3;
    lanes_put(&out[158], TXZ6_3, stream);
    const lanes TXZ6_4 = C5 * nXZ6_3 + E4_1e6 * nXZ6_1 + E4_2e6 * nXZ6_2;
    lanes_put(&out[220], TXZ6_4, stream);
    const lanes TXZ6_5 = C6 * nXZ6_2 + S6 * nXZ6_1;
    lanes_put(&out[282], TXZ6_5, stream);
    const lanes nYY6_1 = -0.5 * W2e6 * E3j6 - 0.5 * W36 * E2e6;
    const lanes TZZ6_5 = -C6 * nXX6_2 - S6 * nYY6_1;
    lanes_put(&out[284], TZZ6_5, stream);
    const lanes nYZ6_1 = W2e6 * E2e6 - W36 * E3j6;
    const lanes nYZ6_2 = e3j6 - W1e6 * E2e6;
    const lanes TYZ6_1 = E1_1e6 * nYZ6_1 + E1_2e6 * nYZ6_2 - E1_2e5 * nYZ6_3;
    lanes_put(&out[35], TYZ6_1, stream);
    const lanes TYZ6_2 = E2_1e6 * nYZ6_1 + E2_2e6 * nYZ6_2 - E2_2e5 * nYZ6_3;
    lanes_put(&out[97], TYZ6_2, stream);
    const lanes TYZ6_3 = E3_1e6 * nYZ6_1 + E3_2e6 * nYZ6_2 - E3_2e5 * nYZ6_3;
    lanes_put(&out[159], TYZ6_3, stream);
    const lanes TYZ6_4 = C5 * nYZ6_3 + E4_1e6 * nYZ6_1 + E4_2e6 * nYZ6_2;
    lanes_put(&out[221], TYZ6_4, stream);
    const lanes TYZ6_5 = C6 * nYZ6_2 + S6 * nYZ6_1;
    lanes_put(&out[283], TYZ6_5, stream);
    const lanes nZZ6_3 = 0.5 * W2e6 * E1e6 + e3j6 - 0.5 * W1e6 * E2e6;
    lanes_put(&out[346], nZZ6_3, stream);
    const lanes TZZ6_1 = -E1_2e5 * nZZ6_3 - E1_1e6 * nYY6_1 - E1_2e6 * nXX6_2;
    lanes_put(&out[36], TZZ6_1, stream);
    const lanes TZZ6_2 = -E2_2e5 * nZZ6_3 - E2_1e6 * nYY6_1 - E2_2e6 * nXX6_2;
    lanes_put(&out[98], TZZ6_2, stream);
    const lanes TZZ6_3 = -E3_2e5 * nZZ6_3 - E3_1e6 * nYY6_1 - E3_2e6 * nXX6_2;
    lanes_put(&out[160], TZZ6_3, stream);
    const lanes TZZ6_4 = C5 * nZZ6_3 - E4_1e6 * nYY6_1 - E4_2e6 * nXX6_2;
    lanes_put(&out[222], TZZ6_4, stream);
    const lanes fMX6_1 = -W2e6 * E2e6 - W36 * E3j6;
    const lanes TMX6_1 = L1_2r5 * nXY6_1 + E1_2e6 * v2r5 + L1_1e6 * fMX6_1 + L1_2e6 * nXZ6_1 - E1_2e5 * l2e6;
    lanes_put(&out[37], TMX6_1, stream);
    const lanes TMX6_2 = L2_2r5 * nXY6_1 + E2_2e6 * v2r5 + L2_1e6 * fMX6_1 + L2_2e6 * nXZ6_1 - E2_2e5 * l2e6;
    lanes_put(&out[99], TMX6_2, stream);
    const lanes TMX6_3 = L3_2r5 * nXY6_1 + E3_2e6 * v2r5 + L3_1e6 * fMX6_1 + L3_2e6 * nXZ6_1 - E3_2e5 * l2e6;
    lanes_put(&out[161], TMX6_3, stream);
    const lanes TMX6_4 = C5 * l2e6 + L4_2r5 * nXY6_1 + E4_2e6 * v2r5 + L4_1e6 * fMX6_1 + L4_2e6 * nXZ6_1;
    lanes_put(&out[223], TMX6_4, stream);
    const lanes fMY6_2 = -W1e6 * E1e6 - W36 * E3j6;
    const lanes TMY6_1 = E1_2e5 * l1e6 + L1_2e6 * fMY6_2 - L1_2r5 * nXY6_2 - E1_1e6 * v2r5 - L1_1e6 * nYZ6_2;
    lanes_put(&out[38], TMY6_1, stream);
    const lanes TMY6_2 = E2_2e5 * l1e6 + L2_2e6 * fMY6_2 - L2_2r5 * nXY6_2 - E2_1e6 * v2r5 - L2_1e6 * nYZ6_2;
    lanes_put(&out[100], TMY6_2, stream);
    const lanes TMY6_3 = E3_2e5 * l1e6 + L3_2e6 * fMY6_2 - L3_2r5 * nXY6_2 - E3_1e6 * v2r5 - L3_1e6 * nYZ6_2;
    lanes_put(&out[162], TMY6_3, stream);
    const lanes TMY6_4 = L4_2e6 * fMY6_2 - C5 * l1e6 - L4_2r5 * nXY6_2 - E4_1e6 * v2r5 - L4_1e6 * nYZ6_2;
    lanes_put(&out[224], TMY6_4, stream);
    const lanes nXX7_1 = 0.5 * W37 * E2e7 + e1j7 - 0.5 * W2e7 * E3j7;
    const lanes nXX7_2 = 0.5 * W1e7 * E3j7 + 0.5 * W37 * E1e7;
    const lanes TXX7_6 = C7 * nXX7_2 + S7 * nXX7_1;
    lanes_put(&out[350], TXX7_6, stream);
    const lanes nXX7_3 = -0.5 * W1e7 * E2e7 - 0.5 * W2e7 * E1e7;
    lanes_put(&out[412], nXX7_3, stream);
    const lanes TXX7_1 = E1_1e7 * nXX7_1 + E1_2e7 * nXX7_2 - E1_2e6 * nXX7_3;
    lanes_put(&out[40], TXX7_1, stream);
    const lanes TXX7_2 = E2_1e7 * nXX7_1 + E2_2e7 * nXX7_2 - E2_2e6 * nXX7_3;
    lanes_put(&out[102], TXX7_2, stream);
    const lanes TXX7_3 = E3_1e7 * nXX7_1 + E3_2e7 * nXX7_2 - E3_2e6 * nXX7_3;
    lanes_put(&out[164], TXX7_3, stream);
    const lanes TXX7_4 = E4_1e7 * nXX7_1 + E4_2e7 * nXX7_2 - E4_2e6 * nXX7_3;
    lanes_put(&out[226], TXX7_4, stream);
    const lanes TXX7_5 = E5_1e7 * nXX7_1 + E5_2e7 * nXX7_2 - C6 * nXX7_3;
    lanes_put(&out[288], TXX7_5, stream);
    const lanes nXY7_1 = e2j7 - W37 * E1e7;
    const lanes nYZ7_3 = W1e7 * E3j7 + e2j7;
    lanes_put(&out[415], nYZ7_3, stream);
    const lanes TMX7_6 = panda_geometry_D7 * nXY7_1 - C7 * v3d7;
    lanes_put(&out[355], TMX7_6, stream);
    const lanes nXY7_2 = W37 * E2e7 + e1j7;
    const lanes TXY7_6 = C7 * nXY7_2 + S7 * nXY7_1;
    lanes_put(&out[351], TXY7_6, stream);
    const lanes nXZ7_3 = e1j7 - W2e7 * E3j7;
    lanes_put(&out[414], nXZ7_3, stream);
    const lanes TMY7_6 = S7 * v3d7 - panda_geometry_D7 * nXY7_2;
    lanes_put(&out[356], TMY7_6, stream);
    const lanes nXY7_3 = W1e7 * E1e7 - W2e7 * E2e7;
    lanes_put(&out[413], nXY7_3, stream);
    const lanes TXY7_1 = E1_1e7 * nXY7_1 + E1_2e7 * nXY7_2 - E1_2e6 * nXY7_3;
    lanes_put(&out[41], TXY7_1, stream);
    const lanes TXY7_2 = E2_1e7 * nXY7_1 + E2_2e7 * nXY7_2 - E2_2e6 * nXY7_3;
    lanes_put(&out[103], TXY7_2, stream);
    const lanes TXY7_3 = E3_1e7 * nXY7_1 + E3_2e7 * nXY7_2 - E3_2e6 * nXY7_3;
    lanes_put(&out[165], TXY7_3, stream);
    const lanes TXY7_4 = E4_1e7 * nXY7_1 + E4_2e7 * nXY7_2 - E4_2e6 * nXY7_3;
    lanes_put(&out[227], TXY7_4, stream);
    const lanes TXY7_5 = E5_1e7 * nXY7_1 + E5_2e7 * nXY7_2 - C6 * nXY7_3;
    lanes_put(&out[289], TXY7_5, stream);
    const lanes nXZ7_1 = W2e7 * E1e7 + e3j7;
    const lanes nXZ7_2 = W37 * E3j7 - W1e7 * E1e7;
    const lanes TXZ7_1 = E1_1e7 * nXZ7_1 + E1_2e7 * nXZ7_2 - E1_2e6 * nXZ7_3;
    lanes_put(&out[42], TXZ7_1, stream);
    const lanes TXZ7_2 = E2_1e7 * nXZ7_1 + E2_2e7 * nXZ7_2 - E2_2e6 * nXZ7_3;
    lanes_put(&out[104], TXZ7_2, stream);
    const lanes TXZ7_3 = E3_1e7 * nXZ7_1 + E3_2e7 * nXZ7_2 - E3_2e6 * nXZ7_3;
    lanes_put(&out[166], TXZ7_3, stream);
    const lanes TXZ7_4 = E4_1e7 * nXZ7_1 + E4_2e7 * nXZ7_2 - E4_2e6 * nXZ7_3;
    lanes_put(&out[228], TXZ7_4, stream);
    const lanes TXZ7_5 = E5_1e7 * nXZ7_1 + E5_2e7 * nXZ7_2 - C6 * nXZ7_3;
    lanes_put(&out[290], TXZ7_5, stream);
    const lanes TXZ7_6 = C7 * nXZ7_2 + S7 * nXZ7_1;
    lanes_put(&out[352], TXZ7_6, stream);
    const lanes nYY7_1 = -0.5 * W2e7 * E3j7 - 0.5 * W37 * E2e7;
    const lanes TZZ7_6 = -C7 * nXX7_2 - S7 * nYY7_1;
    lanes_put(&out[354], TZZ7_6, stream);
    const lanes nYZ7_1 = W2e7 * E2e7 - W37 * E3j7;
    const lanes nYZ7_2 = e3j7 - W1e7 * E2e7;
    const lanes TYZ7_1 = E1_1e7 * nYZ7_1 + E1_2e7 * nYZ7_2 - E1_2e6 * nYZ7_3;
    lanes_put(&out[43], TYZ7_1, stream);
    const lanes TYZ7_2 = E2_1e7 * nYZ7_1 + E2_2e7 * nYZ7_2 - E2_2e6 * nYZ7_3;
    lanes_put(&out[105], TYZ7_2, stream);
    const lanes TYZ7_3 = E3_1e7 * nYZ7_1 + E3_2e7 * nYZ7_2 - E3_2e6 * nYZ7_3;
    lanes_put(&out[167], TYZ7_3, stream);
    const lanes TYZ7_4 = E4_1e7 * nYZ7_1 + E4_2e7 * nYZ7_2 - E4_2e6 * nYZ7_3;
    lanes_put(&out[229], TYZ7_4, stream);
    const lanes TYZ7_5 = E5_1e7 * nYZ7_1 + E5_2e7 * nYZ7_2 - C6 * nYZ7_3;
    lanes_put(&out[291], TYZ7_5, stream);
    const lanes TYZ7_6 = C7 * nYZ7_2 + S7 * nYZ7_1;
    lanes_put(&out[353], TYZ7_6, stream);
    const lanes nZZ7_3 = 0.5 * W2e7 * E1e7 + e3j7 - 0.5 * W1e7 * E2e7;
    lanes_put(&out[416], nZZ7_3, stream);
    const lanes TZZ7_1 = -E1_2e6 * nZZ7_3 - E1_1e7 * nYY7_1 - E1_2e7 * nXX7_2;
    lanes_put(&out[44], TZZ7_1, stream);
    const lanes TZZ7_2 = -E2_2e6 * nZZ7_3 - E2_1e7 * nYY7_1 - E2_2e7 * nXX7_2;
    lanes_put(&out[106], TZZ7_2, stream);
    const lanes TZZ7_3 = -E3_2e6 * nZZ7_3 - E3_1e7 * nYY7_1 - E3_2e7 * nXX7_2;
    lanes_put(&out[168], TZZ7_3, stream);
    const lanes TZZ7_4 = -E4_2e6 * nZZ7_3 - E4_1e7 * nYY7_1 - E4_2e7 * nXX7_2;
    lanes_put(&out[230], TZZ7_4, stream);
    const lanes TZZ7_5 = -C6 * nZZ7_3 - E5_1e7 * nYY7_1 - E5_2e7 * nXX7_2;
    lanes_put(&out[292], TZZ7_5, stream);
    const lanes fMX7_1 = -W2e7 * E2e7 - W37 * E3j7;
    const lanes TMX7_1 = L1_1e7 * fMX7_1 + L1_2e7 * nXZ7_1 - E1_2e6 * l2e7 - L1_3d7 * nXY7_1 - E1_2e7 * v3d7;
    lanes_put(&out[45], TMX7_1, stream);
    const lanes TMX7_2 = L2_1e7 * fMX7_1 + L2_2e7 * nXZ7_1 - E2_2e6 * l2e7 - L2_3d7 * nXY7_1 - E2_2e7 * v3d7;
    lanes_put(&out[107], TMX7_2, stream);
    const lanes TMX7_3 = L3_1e7 * fMX7_1 + L3_2e7 * nXZ7_1 - E3_2e6 * l2e7 - L3_3d7 * nXY7_1 - E3_2e7 * v3d7;
    lanes_put(&out[169], TMX7_3, stream);
    const lanes TMX7_4 = L4_1e7 * fMX7_1 + L4_2e7 * nXZ7_1 - E4_2e6 * l2e7 - L4_3d7 * nXY7_1 - E4_2e7 * v3d7;
    lanes_put(&out[231], TMX7_4, stream);
    const lanes TMX7_5 = L5_1e7 * fMX7_1 + L5_2e7 * nXZ7_1 - C6 * l2e7 - E5_2e7 * v3d7;
    lanes_put(&out[293], TMX7_5, stream);
    const lanes fMY7_2 = -W1e7 * E1e7 - W37 * E3j7;
    const lanes TMY7_1 = E1_2e6 * l1e7 + L1_3d7 * nXY7_2 + E1_1e7 * v3d7 + L1_2e7 * fMY7_2 - L1_1e7 * nYZ7_2;
    lanes_put(&out[46], TMY7_1, stream);
    const lanes TMY7_2 = E2_2e6 * l1e7 + L2_3d7 * nXY7_2 + E2_1e7 * v3d7 + L2_2e7 * fMY7_2 - L2_1e7 * nYZ7_2;
    lanes_put(&out[108], TMY7_2, stream);
    const lanes TMY7_3 = E3_2e6 * l1e7 + L3_3d7 * nXY7_2 + E3_1e7 * v3d7 + L3_2e7 * fMY7_2 - L3_1e7 * nYZ7_2;
    lanes_put(&out[170], TMY7_3, stream);
    const lanes TMY7_4 = E4_2e6 * l1e7 + L4_3d7 * nXY7_2 + E4_1e7 * v3d7 + L4_2e7 * fMY7_2 - L4_1e7 * nYZ7_2;
    lanes_put(&out[232], TMY7_4, stream);
    const lanes TMY7_5 = C6 * l1e7 + E5_1e7 * v3d7 + L5_2e7 * fMY7_2 - L5_1e7 * nYZ7_2;
    lanes_put(&out[294], TMY7_5, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, apart *out)
{
    return panel(q, qd, qdr, qddr, out, 0);
}

int panda_slotine_li_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdr[REACH(7u)];
    lanes lanes_qdr[BLOCKS(7u)];
    double padded_qddr[REACH(7u)];
    lanes lanes_qddr[BLOCKS(7u)];
    if (stride_q == 0u) {
        lanes_shared(q, 7u, lanes_q);
    }
    if (stride_qd == 0u) {
        lanes_shared(qd, 7u, lanes_qd);
    }
    if (stride_qdr == 0u) {
        lanes_shared(qdr, 7u, lanes_qdr);
    }
    if (stride_qddr == 0u) {
        lanes_shared(qddr, 7u, lanes_qddr);
    }
    lanes lanes_out[BLOCKS(434u)];
    double scratch[434u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
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
        status |= plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, (apart *)lanes_out);
        lanes_store(lanes_out, 434u, count, stream, scratch, &out[k * 434u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdr[REACH(7u)];
    lanes lanes_qdr[BLOCKS(7u)];
    double padded_qddr[REACH(7u)];
    lanes lanes_qddr[BLOCKS(7u)];
    if (stride_q == 0u) {
        lanes_shared(q, 7u, lanes_q);
    }
    if (stride_qd == 0u) {
        lanes_shared(qd, 7u, lanes_qd);
    }
    if (stride_qdr == 0u) {
        lanes_shared(qdr, 7u, lanes_qdr);
    }
    if (stride_qddr == 0u) {
        lanes_shared(qddr, 7u, lanes_qddr);
    }
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
        apart *lanes_out = (apart *)&out[k * 434u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_out);
    }
    return status;
}

int panda_slotine_li_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    if (!(streamed(stream, out))) {
        return panels(0, N, strides, q, qd, qdr, qddr, out);
    }
    const int status = panels(1, N, strides, q, qd, qdr, qddr, out);
    stream_end();
    return status;
}

#else

int panda_slotine_li_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 7u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        panda_slotine_li_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdr[k * stride_qdr], &qddr[k * stride_qddr], &out[k * 434u]);
    }
    return status;
}

int panda_slotine_li_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    return panda_slotine_li_regressor_rows(stream, N, strides, q, qd, qdr, qddr, out);
}

#endif

size_t panda_slotine_li_regressor_width(void)
{
    return panda_WIDTH;
}

void panda_slotine_li_regressor_batch(size_t N, const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    (void)panda_slotine_li_regressor_rows(0, N, NULL, q, qd, qdr, qddr, out);
}
