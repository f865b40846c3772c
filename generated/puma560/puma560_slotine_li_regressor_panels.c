/* puma560: slotine_li_regressor of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, apart *out, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    lanes_put(&out[0], qddr[0], stream);
    lanes_put(&out[41], qd[0], stream);
    lanes_put(&out[95], qd[1], stream);
    lanes_put(&out[119], qddr[2], stream);
    lanes_put(&out[149], qd[2], stream);
    lanes_put(&out[179], qddr[3], stream);
    lanes_put(&out[203], qd[3], stream);
    lanes_put(&out[239], qddr[4], stream);
    lanes_put(&out[257], qd[4], stream);
    lanes_put(&out[299], qddr[5], stream);
    lanes_put(&out[311], qd[5], stream);
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
    const lanes L1_1r2 = -puma560_geometry_R2 * C2;
    const lanes L1_2r2 = puma560_geometry_R2 * S2;
    const lanes L1_3d3 = puma560_geometry_D3 * C2;
    const lanes E1_1e3 = -C2 * S3 - S2 * C3;
    const lanes E1_2e3 = S2 * S3 - C2 * C3;
    const lanes L1_1e3 = C3 * L1_1r2 + S3 * L1_2r2;
    const lanes L1_2e3 = C3 * L1_2r2 - S3 * L1_1r2;
    const lanes L2_1e3 = puma560_geometry_D3 * S3;
    const lanes L2_2e3 = puma560_geometry_D3 * C3;
    const lanes L1_1r3 = puma560_geometry_R3 * E1_2e3 + L1_1e3;
    const lanes L1_2r3 = L1_2e3 - puma560_geometry_R3 * E1_1e3;
    const lanes L1_2d4 = L1_3d3 - puma560_geometry_D4 * E1_2e3;
    const lanes L2_3d4 = -puma560_geometry_D4 - L2_2e3;
    const lanes E1_1e4 = C4 * E1_1e3;
    const lanes E1_2e4 = -S4 * E1_1e3;
    const lanes L1_1e4 = C4 * L1_1r3 + S4 * L1_2d4;
    const lanes L1_2e4 = C4 * L1_2d4 - S4 * L1_1r3;
    const lanes L2_1e4 = C4 * L2_1e3;
    const lanes L2_2e4 = -S4 * L2_1e3;
    const lanes L1_1r4 = puma560_geometry_R4 * E1_2e4 + L1_1e4;
    const lanes L1_2r4 = L1_2e4 - puma560_geometry_R4 * E1_1e4;
    const lanes L2_1r4 = puma560_geometry_R4 * C4 + L2_1e4;
    const lanes L2_2r4 = L2_2e4 - puma560_geometry_R4 * S4;
    const lanes L3_1r4 = puma560_geometry_R4 * C4;
    const lanes L3_2r4 = -puma560_geometry_R4 * S4;
    const lanes E1_1e5 = C5 * E1_1e4 + S5 * E1_2e3;
    const lanes E1_2e5 = C5 * E1_2e3 - S5 * E1_1e4;
    const lanes L1_1e5 = C5 * L1_1r4 + S5 * L1_2r3;
    const lanes L1_2e5 = C5 * L1_2r3 - S5 * L1_1r4;
    const lanes E2_1e5 = S4 * C5;
    const lanes E2_2e5 = -S4 * S5;
    const lanes L2_1e5 = C5 * L2_1r4 - S5 * L2_3d4;
    const lanes L2_2e5 = -C5 * L2_3d4 - S5 * L2_1r4;
    const lanes L3_1e5 = puma560_geometry_D4 * S5 + C5 * L3_1r4;
    const lanes L3_2e5 = puma560_geometry_D4 * C5 - S5 * L3_1r4;
    const lanes E1_1e6 = C6 * E1_1e5 + S6 * E1_2e4;
    const lanes E1_2e6 = C6 * E1_2e4 - S6 * E1_1e5;
    const lanes L1_1e6 = C6 * L1_1e5 + S6 * L1_2r4;
    const lanes L1_2e6 = C6 * L1_2r4 - S6 * L1_1e5;
    const lanes E2_1e6 = C4 * S6 + C6 * E2_1e5;
    const lanes E2_2e6 = C4 * C6 - S6 * E2_1e5;
    const lanes L2_1e6 = C6 * L2_1e5 + S6 * L2_2r4;
    const lanes L2_2e6 = C6 * L2_2r4 - S6 * L2_1e5;
    const lanes L3_1e6 = C6 * L3_1e5 + S6 * L3_2r4;
    const lanes L3_2e6 = C6 * L3_2r4 - S6 * L3_1e5;
    const lanes E4_1e6 = -S5 * C6;
    const lanes E4_2e6 = S5 * S6;
    const lanes W1e2 = -qd[0] * S2;
    const lanes W2e2 = -qd[0] * C2;
    const lanes G1e2 = gz * S2;
    const lanes G2e2 = gz * C2;
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
    const lanes e1j2 = qdr[1] * W2e2 + e1e2;
    const lanes e2j2 = e2e2 - qdr[1] * W1e2;
    const lanes vP31r2 = qdr[1] * W1e2;
    const lanes vA1r2 = e2j2 + vP31r2;
    const lanes vP32r2 = qdr[1] * W2e2;
    const lanes vA2r2 = vP32r2 - e1j2;
    const lanes vP11r2 = W1e2 * E1e2;
    const lanes vP22r2 = W2e2 * E2e2;
    const lanes vA3r2 = vP11r2 + vP22r2;
    const lanes v1r2 = puma560_geometry_R2 * vA1r2 - G1e2;
    lanes_put(&out[59], -v1r2, stream);
    const lanes v2r2 = puma560_geometry_R2 * vA2r2 - G2e2;
    lanes_put(&out[58], v2r2, stream);
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
    lanes_put(&out[118], -v1r3, stream);
    const lanes v2r3 = puma560_geometry_R3 * vA2r3 + l2e3;
    lanes_put(&out[117], v2r3, stream);
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
    lanes_put(&out[178], -v1r4, stream);
    const lanes v2r4 = puma560_geometry_R4 * vA2r4 + l2e4;
    lanes_put(&out[177], v2r4, stream);
    const lanes v3r4 = v3d4 - puma560_geometry_R4 * vA3r4;
    const lanes E1e5 = C5 * E1e4 - S5 * E3j4;
    const lanes E2e5 = -C5 * E3j4 - S5 * E1e4;
    const lanes e1e5 = C5 * e1j4 - S5 * e3j4;
    const lanes e2e5 = -C5 * e3j4 - S5 * e1j4;
    const lanes l1e5 = C5 * v1r4 - S5 * v3r4;
    lanes_put(&out[238], -l1e5, stream);
    const lanes l2e5 = -C5 * v3r4 - S5 * v1r4;
    lanes_put(&out[237], l2e5, stream);
    const lanes e1j5 = qdr[4] * W2e5 + e1e5;
    const lanes e2j5 = e2e5 - qdr[4] * W1e5;
    const lanes e3j5 = qddr[4] + e2j4;
    const lanes E3j5 = qdr[4] + E2e4;
    const lanes E1e6 = C6 * E1e5 + S6 * E3j5;
    const lanes E2e6 = C6 * E3j5 - S6 * E1e5;
    const lanes e1e6 = C6 * e1j5 + S6 * e3j5;
    const lanes e2e6 = C6 * e3j5 - S6 * e1j5;
    const lanes l1e6 = C6 * l1e5 + S6 * v2r4;
    lanes_put(&out[298], -l1e6, stream);
    const lanes l2e6 = C6 * v2r4 - S6 * l1e5;
    lanes_put(&out[297], l2e6, stream);
    const lanes e1j6 = qdr[5] * W2e6 + e1e6;
    const lanes e2j6 = e2e6 - qdr[5] * W1e6;
    const lanes e3j6 = qddr[5] - e2j5;
    const lanes E3j6 = qdr[5] - E2e5;
    const lanes nXX2_1 = 0.5 * qd[1] * E2e2 + e1j2 - 0.5 * qdr[1] * W2e2;
    const lanes nXX2_2 = 0.5 * qd[1] * E1e2 + 0.5 * qdr[1] * W1e2;
    const lanes nXX2_3 = -0.5 * W1e2 * E2e2 - 0.5 * W2e2 * E1e2;
    lanes_put(&out[53], nXX2_3, stream);
    const lanes TXX2_1 = -C2 * nXX2_2 - S2 * nXX2_1;
    lanes_put(&out[1], TXX2_1, stream);
    const lanes nXY2_1 = e2j2 - qd[1] * E1e2;
    const lanes nXY2_2 = qd[1] * E2e2 + e1j2;
    const lanes nXY2_3 = W1e2 * E1e2 - W2e2 * E2e2;
    lanes_put(&out[54], nXY2_3, stream);
    const lanes TXY2_1 = -C2 * nXY2_2 - S2 * nXY2_1;
    lanes_put(&out[2], TXY2_1, stream);
    const lanes nXZ2_1 = qddr[1] + W2e2 * E1e2;
    const lanes nXZ2_2 = qd[1] * qdr[1] - W1e2 * E1e2;
    const lanes nXZ2_3 = e1j2 - qdr[1] * W2e2;
    lanes_put(&out[55], nXZ2_3, stream);
    const lanes TXZ2_1 = -C2 * nXZ2_2 - S2 * nXZ2_1;
    lanes_put(&out[3], TXZ2_1, stream);
    const lanes nYY2_1 = -0.5 * qd[1] * E2e2 - 0.5 * qdr[1] * W2e2;
    const lanes nYZ2_1 = W2e2 * E2e2 - qd[1] * qdr[1];
    const lanes nYZ2_2 = qddr[1] - W1e2 * E2e2;
    const lanes nYZ2_3 = qdr[1] * W1e2 + e2j2;
    lanes_put(&out[56], nYZ2_3, stream);
    const lanes TYZ2_1 = -C2 * nYZ2_2 - S2 * nYZ2_1;
    lanes_put(&out[4], TYZ2_1, stream);
    const lanes nZZ2_3 = 0.5 * W2e2 * E1e2 + qddr[1] - 0.5 * W1e2 * E2e2;
    lanes_put(&out[57], nZZ2_3, stream);
    const lanes TZZ2_1 = C2 * nXX2_2 + S2 * nYY2_1;
    lanes_put(&out[5], TZZ2_1, stream);
    const lanes fMX2_1 = -qd[1] * qdr[1] - W2e2 * E2e2;
    const lanes TMX2_1 = C2 * v3r2 + L1_1r2 * fMX2_1 + L1_2r2 * nXZ2_1;
    lanes_put(&out[6], TMX2_1, stream);
    const lanes fMY2_2 = -qd[1] * qdr[1] - W1e2 * E1e2;
    const lanes TMY2_1 = L1_2r2 * fMY2_2 - S2 * v3r2 - L1_1r2 * nYZ2_2;
    lanes_put(&out[7], TMY2_1, stream);
    const lanes nXX3_1 = 0.5 * W33 * E2e3 + e1j3 - 0.5 * W2e3 * E3j3;
    const lanes nXX3_2 = 0.5 * W1e3 * E3j3 + 0.5 * W33 * E1e3;
    const lanes nXX3_3 = -0.5 * W1e3 * E2e3 - 0.5 * W2e3 * E1e3;
    lanes_put(&out[60], nXX3_3, stream);
    lanes_put(&out[112], nXX3_3, stream);
    const lanes TXX3_1 = E1_1e3 * nXX3_1 + E1_2e3 * nXX3_2;
    lanes_put(&out[8], TXX3_1, stream);
    const lanes nXY3_1 = e2j3 - W33 * E1e3;
    const lanes nXY3_2 = W33 * E2e3 + e1j3;
    const lanes nXY3_3 = W1e3 * E1e3 - W2e3 * E2e3;
    lanes_put(&out[61], nXY3_3, stream);
    lanes_put(&out[113], nXY3_3, stream);
    const lanes TXY3_1 = E1_1e3 * nXY3_1 + E1_2e3 * nXY3_2;
    lanes_put(&out[9], TXY3_1, stream);
    const lanes nXZ3_1 = W2e3 * E1e3 + e3j3;
    const lanes nXZ3_2 = W33 * E3j3 - W1e3 * E1e3;
    const lanes nXZ3_3 = e1j3 - W2e3 * E3j3;
    lanes_put(&out[62], nXZ3_3, stream);
    lanes_put(&out[114], nXZ3_3, stream);
    const lanes TXZ3_1 = E1_1e3 * nXZ3_1 + E1_2e3 * nXZ3_2;
    lanes_put(&out[10], TXZ3_1, stream);
    const lanes nYY3_1 = -0.5 * W2e3 * E3j3 - 0.5 * W33 * E2e3;
    const lanes nYZ3_1 = W2e3 * E2e3 - W33 * E3j3;
    const lanes nYZ3_2 = e3j3 - W1e3 * E2e3;
    const lanes nYZ3_3 = W1e3 * E3j3 + e2j3;
    lanes_put(&out[63], nYZ3_3, stream);
    lanes_put(&out[115], nYZ3_3, stream);
    const lanes TYZ3_1 = E1_1e3 * nYZ3_1 + E1_2e3 * nYZ3_2;
    lanes_put(&out[11], TYZ3_1, stream);
    const lanes nZZ3_3 = 0.5 * W2e3 * E1e3 + e3j3 - 0.5 * W1e3 * E2e3;
    lanes_put(&out[64], nZZ3_3, stream);
    lanes_put(&out[116], nZZ3_3, stream);
    const lanes TZZ3_1 = -E1_1e3 * nYY3_1 - E1_2e3 * nXX3_2;
    lanes_put(&out[12], TZZ3_1, stream);
    const lanes fMX3_1 = -W2e3 * E2e3 - W33 * E3j3;
    const lanes TMX3_1 = L1_1r3 * fMX3_1 + L1_2r3 * nXZ3_1 - L1_3d3 * nXY3_1 - E1_2e3 * v3r3;
    lanes_put(&out[13], TMX3_1, stream);
    const lanes TMX3_2 = L2_1e3 * fMX3_1 + L2_2e3 * nXZ3_1 + v2r3;
    lanes_put(&out[65], TMX3_2, stream);
    const lanes fMY3_2 = -W1e3 * E1e3 - W33 * E3j3;
    const lanes TMY3_1 = L1_3d3 * nXY3_2 + E1_1e3 * v3r3 + L1_2r3 * fMY3_2 - L1_1r3 * nYZ3_2;
    lanes_put(&out[14], TMY3_1, stream);
    const lanes TMY3_2 = L2_2e3 * fMY3_2 - L2_1e3 * nYZ3_2 - v1r3;
    lanes_put(&out[66], TMY3_2, stream);
    const lanes nXX4_1 = 0.5 * W34 * E2e4 + e1j4 - 0.5 * W2e4 * E3j4;
    const lanes nXX4_2 = 0.5 * W1e4 * E3j4 + 0.5 * W34 * E1e4;
    const lanes nXX4_3 = -0.5 * W1e4 * E2e4 - 0.5 * W2e4 * E1e4;
    lanes_put(&out[172], nXX4_3, stream);
    const lanes TXX4_1 = E1_1e4 * nXX4_1 + E1_2e4 * nXX4_2 - E1_2e3 * nXX4_3;
    lanes_put(&out[16], TXX4_1, stream);
    const lanes TXX4_2e = C4 * nXX4_2 + S4 * nXX4_1;
    lanes_put(&out[68], TXX4_2e, stream);
    lanes_put(&out[120], TXX4_2e, stream);
    const lanes nXY4_1 = e2j4 - W34 * E1e4;
    const lanes nXY4_2 = W34 * E2e4 + e1j4;
    const lanes nXY4_3 = W1e4 * E1e4 - W2e4 * E2e4;
    lanes_put(&out[173], nXY4_3, stream);
    const lanes TXY4_1 = E1_1e4 * nXY4_1 + E1_2e4 * nXY4_2 - E1_2e3 * nXY4_3;
    lanes_put(&out[17], TXY4_1, stream);
    const lanes TXY4_2e = C4 * nXY4_2 + S4 * nXY4_1;
    lanes_put(&out[69], TXY4_2e, stream);
    lanes_put(&out[121], TXY4_2e, stream);
    const lanes nXZ4_1 = W2e4 * E1e4 + e3j4;
    const lanes nXZ4_2 = W34 * E3j4 - W1e4 * E1e4;
    const lanes nXZ4_3 = e1j4 - W2e4 * E3j4;
    lanes_put(&out[174], nXZ4_3, stream);
    const lanes TXZ4_1 = E1_1e4 * nXZ4_1 + E1_2e4 * nXZ4_2 - E1_2e3 * nXZ4_3;
    lanes_put(&out[18], TXZ4_1, stream);
    const lanes TXZ4_2e = C4 * nXZ4_2 + S4 * nXZ4_1;
    lanes_put(&out[70], TXZ4_2e, stream);
    lanes_put(&out[122], TXZ4_2e, stream);
    const lanes nYY4_1 = -0.5 * W2e4 * E3j4 - 0.5 * W34 * E2e4;
    const lanes nYZ4_1 = W2e4 * E2e4 - W34 * E3j4;
    const lanes nYZ4_2 = e3j4 - W1e4 * E2e4;
    const lanes nYZ4_3 = W1e4 * E3j4 + e2j4;
    lanes_put(&out[175], nYZ4_3, stream);
    const lanes TYZ4_1 = E1_1e4 * nYZ4_1 + E1_2e4 * nYZ4_2 - E1_2e3 * nYZ4_3;
    lanes_put(&out[19], TYZ4_1, stream);
    const lanes TYZ4_2e = C4 * nYZ4_2 + S4 * nYZ4_1;
    lanes_put(&out[71], TYZ4_2e, stream);
    lanes_put(&out[123], TYZ4_2e, stream);
    const lanes nZZ4_3 = 0.5 * W2e4 * E1e4 + e3j4 - 0.5 * W1e4 * E2e4;
    lanes_put(&out[176], nZZ4_3, stream);
    const lanes TZZ4_1 = -E1_2e3 * nZZ4_3 - E1_1e4 * nYY4_1 - E1_2e4 * nXX4_2;
    lanes_put(&out[20], TZZ4_1, stream);
    const lanes TZZ4_2e = -C4 * nXX4_2 - S4 * nYY4_1;
    lanes_put(&out[72], TZZ4_2e, stream);
    lanes_put(&out[124], TZZ4_2e, stream);
    const lanes fMX4_1 = -W2e4 * E2e4 - W34 * E3j4;
    const lanes TMX4_1 = L1_2r3 * nXY4_1 + L1_1r4 * fMX4_1 + L1_2r4 * nXZ4_1 - E1_2e3 * v2r4 - E1_2e4 * v3r4;
    lanes_put(&out[21], TMX4_1, stream);
    const lanes TMX4_2e = -C4 * v3r4;
    const lanes TMX4_2 = L2_1r4 * fMX4_1 + L2_2r4 * nXZ4_1 + TMX4_2e - L2_3d4 * nXY4_1;
    lanes_put(&out[73], TMX4_2, stream);
    const lanes TMX4_3 = puma560_geometry_D4 * nXY4_1 + L3_1r4 * fMX4_1 + L3_2r4 * nXZ4_1 + TMX4_2e;
    lanes_put(&out[125], TMX4_3, stream);
    const lanes fMY4_2 = -W1e4 * E1e4 - W34 * E3j4;
    const lanes TMY4_1 = E1_2e3 * v1r4 + E1_1e4 * v3r4 + L1_2r4 * fMY4_2 - L1_2r3 * nXY4_2 - L1_1r4 * nYZ4_2;
    lanes_put(&out[22], TMY4_1, stream);
    const lanes TMY4_2e = S4 * v3r4;
    const lanes TMY4_2 = L2_3d4 * nXY4_2 + L2_2r4 * fMY4_2 + TMY4_2e - L2_1r4 * nYZ4_2;
    lanes_put(&out[74], TMY4_2, stream);
    const lanes TMY4_3 = L3_2r4 * fMY4_2 + TMY4_2e - puma560_geometry_D4 * nXY4_2 - L3_1r4 * nYZ4_2;
    lanes_put(&out[126], TMY4_3, stream);
    const lanes nXX5_1 = 0.5 * W35 * E2e5 + e1j5 - 0.5 * W2e5 * E3j5;
    const lanes nXX5_2 = 0.5 * W1e5 * E3j5 + 0.5 * W35 * E1e5;
    const lanes nXX5_3 = -0.5 * W1e5 * E2e5 - 0.5 * W2e5 * E1e5;
    lanes_put(&out[232], nXX5_3, stream);
    const lanes TXX5_1 = E1_2e4 * nXX5_3 + E1_1e5 * nXX5_1 + E1_2e5 * nXX5_2;
    lanes_put(&out[24], TXX5_1, stream);
    const lanes TXX5_2e = C4 * nXX5_3 + E2_1e5 * nXX5_1 + E2_2e5 * nXX5_2;
    lanes_put(&out[76], TXX5_2e, stream);
    lanes_put(&out[128], TXX5_2e, stream);
    const lanes TXX5_4 = -C5 * nXX5_2 - S5 * nXX5_1;
    lanes_put(&out[180], TXX5_4, stream);
    const lanes nXY5_1 = e2j5 - W35 * E1e5;
    const lanes nXY5_2 = W35 * E2e5 + e1j5;
    const lanes nXY5_3 = W1e5 * E1e5 - W2e5 * E2e5;
    lanes_put(&out[233], nXY5_3, stream);
    const lanes TXY5_1 = E1_2e4 * nXY5_3 + E1_1e5 * nXY5_1 + E1_2e5 * nXY5_2;
    lanes_put(&out[25], TXY5_1, stream);
    const lanes TXY5_2e = C4 * nXY5_3 + E2_1e5 * nXY5_1 + E2_2e5 * nXY5_2;
    lanes_put(&out[77], TXY5_2e, stream);
    lanes_put(&out[129], TXY5_2e, stream);
    const lanes TXY5_4 = -C5 * nXY5_2 - S5 * nXY5_1;
    lanes_put(&out[181], TXY5_4, stream);
    const lanes nXZ5_1 = W2e5 * E1e5 + e3j5;
    const lanes nXZ5_2 = W35 * E3j5 - W1e5 * E1e5;
    const lanes nXZ5_3 = e1j5 - W2e5 * E3j5;
    lanes_put(&out[234], nXZ5_3, stream);
    const lanes TXZ5_1 = E1_2e4 * nXZ5_3 + E1_1e5 * nXZ5_1 + E1_2e5 * nXZ5_2;
    lanes_put(&out[26], TXZ5_1, stream);
    const lanes TXZ5_2e = C4 * nXZ5_3 + E2_1e5 * nXZ5_1 + E2_2e5 * nXZ5_2;
    lanes_put(&out[78], TXZ5_2e, stream);
    lanes_put(&out[130], TXZ5_2e, stream);
    const lanes TXZ5_4 = -C5 * nXZ5_2 - S5 * nXZ5_1;
    lanes_put(&out[182], TXZ5_4, stream);
    const lanes nYY5_1 = -0.5 * W2e5 * E3j5 - 0.5 * W35 * E2e5;
    const lanes nYZ5_1 = W2e5 * E2e5 - W35 * E3j5;
    const lanes nYZ5_2 = e3j5 - W1e5 * E2e5;
    const lanes nYZ5_3 = W1e5 * E3j5 + e2j5;
    lanes_put(&out[235], nYZ5_3, stream);
    const lanes TYZ5_1 = E1_2e4 * nYZ5_3 + E1_1e5 * nYZ5_1 + E1_2e5 * nYZ5_2;
    lanes_put(&out[27], TYZ5_1, stream);
    const lanes TYZ5_2e = C4 * nYZ5_3 + E2_1e5 * nYZ5_1 + E2_2e5 * nYZ5_2;
    lanes_put(&out[79], TYZ5_2e, stream);
    lanes_put(&out[131], TYZ5_2e, stream);
    const lanes TYZ5_4 = -C5 * nYZ5_2 - S5 * nYZ5_1;
    lanes_put(&out[183], TYZ5_4, stream);
    const lanes nZZ5_3 = 0.5 * W2e5 * E1e5 + e3j5 - 0.5 * W1e5 * E2e5;
    lanes_put(&out[236], nZZ5_3, stream);
    const lanes TZZ5_1 = E1_2e4 * nZZ5_3 - E1_1e5 * nYY5_1 - E1_2e5 * nXX5_2;
    lanes_put(&out[28], TZZ5_1, stream);
    const lanes TZZ5_2e = C4 * nZZ5_3 - E2_1e5 * nYY5_1 - E2_2e5 * nXX5_2;
    lanes_put(&out[80], TZZ5_2e, stream);
    lanes_put(&out[132], TZZ5_2e, stream);
    const lanes TZZ5_4 = C5 * nXX5_2 + S5 * nYY5_1;
    lanes_put(&out[184], TZZ5_4, stream);
    const lanes fMX5_1 = -W2e5 * E2e5 - W35 * E3j5;
    const lanes TMX5_1 = E1_2e4 * l2e5 + L1_1e5 * fMX5_1 + L1_2e5 * nXZ5_1 - L1_2r4 * nXY5_1 - E1_2e5 * v2r4;
    lanes_put(&out[29], TMX5_1, stream);
    const lanes TMX5_2e = C4 * l2e5 - E2_2e5 * v2r4;
    const lanes TMX5_2 = L2_1e5 * fMX5_1 + L2_2e5 * nXZ5_1 + TMX5_2e - L2_2r4 * nXY5_1;
    lanes_put(&out[81], TMX5_2, stream);
    const lanes TMX5_3 = L3_1e5 * fMX5_1 + L3_2e5 * nXZ5_1 + TMX5_2e - L3_2r4 * nXY5_1;
    lanes_put(&out[133], TMX5_3, stream);
    const lanes TMX5_4 = C5 * v2r4;
    lanes_put(&out[185], TMX5_4, stream);
    const lanes fMY5_2 = -W1e5 * E1e5 - W35 * E3j5;
    const lanes TMY5_1 = L1_2r4 * nXY5_2 + E1_1e5 * v2r4 + L1_2e5 * fMY5_2 - E1_2e4 * l1e5 - L1_1e5 * nYZ5_2;
    lanes_put(&out[30], TMY5_1, stream);
    const lanes TMY5_2e = E2_1e5 * v2r4 - C4 * l1e5;
    const lanes TMY5_2 = L2_2r4 * nXY5_2 + L2_2e5 * fMY5_2 + TMY5_2e - L2_1e5 * nYZ5_2;
    lanes_put(&out[82], TMY5_2, stream);
    const lanes TMY5_3 = L3_2r4 * nXY5_2 + L3_2e5 * fMY5_2 + TMY5_2e - L3_1e5 * nYZ5_2;
    lanes_put(&out[134], TMY5_3, stream);
    const lanes TMY5_4 = -S5 * v2r4;
    lanes_put(&out[186], TMY5_4, stream);
    const lanes nXX6_1 = 0.5 * W36 * E2e6 + e1j6 - 0.5 * W2e6 * E3j6;
    const lanes nXX6_2 = 0.5 * W1e6 * E3j6 + 0.5 * W36 * E1e6;
    const lanes nXX6_3 = -0.5 * W1e6 * E2e6 - 0.5 * W2e6 * E1e6;
    lanes_put(&out[292], nXX6_3, stream);
    const lanes TXX6_1 = E1_1e6 * nXX6_1 + E1_2e6 * nXX6_2 - E1_2e5 * nXX6_3;
    lanes_put(&out[32], TXX6_1, stream);
    const lanes TXX6_2e = E2_1e6 * nXX6_1 + E2_2e6 * nXX6_2 - E2_2e5 * nXX6_3;
    lanes_put(&out[84], TXX6_2e, stream);
    lanes_put(&out[136], TXX6_2e, stream);
    const lanes TXX6_4 = C5 * nXX6_3 + E4_1e6 * nXX6_1 + E4_2e6 * nXX6_2;
    lanes_put(&out[188], TXX6_4, stream);
    const lanes TXX6_5 = C6 * nXX6_2 + S6 * nXX6_1;
    lanes_put(&out[240], TXX6_5, stream);
    const lanes nXY6_1 = e2j6 - W36 * E1e6;
    const lanes nXY6_2 = W36 * E2e6 + e1j6;
    const lanes nXY6_3 = W1e6 * E1e6 - W2e6 * E2e6;
    lanes_put(&out[293], nXY6_3, stream);
    const lanes TXY6_1 = E1_1e6 * nXY6_1 + E1_2e6 * nXY6_2 - E1_2e5 * nXY6_3;
    lanes_put(&out[33], TXY6_1, stream);
    const lanes TXY6_2e = E2_1e6 * nXY6_1 + E2_2e6 * nXY6_2 - E2_2e5 * nXY6_3;
    lanes_put(&out[85], TXY6_2e, stream);
    lanes_put(&out[137], TXY6_2e, stream);
    const lanes TXY6_4 = C5 * nXY6_3 + E4_1e6 * nXY6_1 + E4_2e6 * nXY6_2;
    lanes_put(&out[189], TXY6_4, stream);
    const lanes TXY6_5 = C6 * nXY6_2 + S6 * nXY6_1;
    lanes_put(&out[241], TXY6_5, stream);
    const lanes nXZ6_1 = W2e6 * E1e6 + e3j6;
    const lanes nXZ6_2 = W36 * E3j6 - W1e6 * E1e6;
    const lanes nXZ6_3 = e1j6 - W2e6 * E3j6;
    lanes_put(&out[294], nXZ6_3, stream);
    const lanes TXZ6_1 = E1_1e6 * nXZ6_1 + E1_2e6 * nXZ6_2 - E1_2e5 * nXZ6_3;
    lanes_put(&out[34], TXZ6_1, stream);
    const lanes TXZ6_2e = E2_1e6 * nXZ6_1 + E2_2e6 * nXZ6_2 - E2_2e5 * nXZ6_3;
    lanes_put(&out[86], TXZ6_2e, stream);
    lanes_put(&out[138], TXZ6_2e, stream);
    const lanes TXZ6_4 = C5 * nXZ6_3 + E4_1e6 * nXZ6_1 + E4_2e6 * nXZ6_2;
    lanes_put(&out[190], TXZ6_4, stream);
    const lanes TXZ6_5 = C6 * nXZ6_2 + S6 * nXZ6_1;
    lanes_put(&out[242], TXZ6_5, stream);
    const lanes nYY6_1 = -0.5 * W2e6 * E3j6 - 0.5 * W36 * E2e6;
    const lanes nYZ6_1 = W2e6 * E2e6 - W36 * E3j6;
    const lanes nYZ6_2 = e3j6 - W1e6 * E2e6;
    const lanes nYZ6_3 = W1e6 * E3j6 + e2j6;
    lanes_put(&out[295], nYZ6_3, stream);
    const lanes TYZ6_1 = E1_1e6 * nYZ6_1 + E1_2e6 * nYZ6_2 - E1_2e5 * nYZ6_3;
    lanes_put(&out[35], TYZ6_1, stream);
    const lanes TYZ6_2e = E2_1e6 * nYZ6_1 + E2_2e6 * nYZ6_2 - E2_2e5 * nYZ6_3;
    lanes_put(&out[87], TYZ6_2e, stream);
    lanes_put(&out[139], TYZ6_2e, stream);
    const lanes TYZ6_4 = C5 * nYZ6_3 + E4_1e6 * nYZ6_1 + E4_2e6 * nYZ6_2;
    lanes_put(&out[191], TYZ6_4, stream);
    const lanes TYZ6_5 = C6 * nYZ6_2 + S6 * nYZ6_1;
    lanes_put(&out[243], TYZ6_5, stream);
    const lanes nZZ6_3 = 0.5 * W2e6 * E1e6 + e3j6 - 0.5 * W1e6 * E2e6;
    lanes_put(&out[296], nZZ6_3, stream);
    const lanes TZZ6_1 = -E1_2e5 * nZZ6_3 - E1_1e6 * nYY6_1 - E1_2e6 * nXX6_2;
    lanes_put(&out[36], TZZ6_1, stream);
    const lanes TZZ6_2e = -E2_2e5 * nZZ6_3 - E2_1e6 * nYY6_1 - E2_2e6 * nXX6_2;
    lanes_put(&out[88], TZZ6_2e, stream);
    lanes_put(&out[140], TZZ6_2e, stream);
    const lanes TZZ6_4 = C5 * nZZ6_3 - E4_1e6 * nYY6_1 - E4_2e6 * nXX6_2;
    lanes_put(&out[192], TZZ6_4, stream);
    const lanes TZZ6_5 = -C6 * nXX6_2 - S6 * nYY6_1;
    lanes_put(&out[244], TZZ6_5, stream);
    const lanes fMX6_1 = -W2e6 * E2e6 - W36 * E3j6;
    const lanes TMX6_1 = L1_2e5 * nXY6_1 + E1_2e6 * l2e5 + L1_1e6 * fMX6_1 + L1_2e6 * nXZ6_1 - E1_2e5 * l2e6;
    lanes_put(&out[37], TMX6_1, stream);
    const lanes TMX6_2e = E2_2e6 * l2e5 - E2_2e5 * l2e6;
    const lanes TMX6_2 = L2_2e5 * nXY6_1 + L2_1e6 * fMX6_1 + L2_2e6 * nXZ6_1 + TMX6_2e;
    lanes_put(&out[89], TMX6_2, stream);
    const lanes TMX6_3 = L3_2e5 * nXY6_1 + L3_1e6 * fMX6_1 + L3_2e6 * nXZ6_1 + TMX6_2e;
    lanes_put(&out[141], TMX6_3, stream);
    const lanes TMX6_4 = C5 * l2e6 + E4_2e6 * l2e5;
    lanes_put(&out[193], TMX6_4, stream);
    const lanes TMX6_5 = C6 * l2e5;
    lanes_put(&out[245], TMX6_5, stream);
    const lanes fMY6_2 = -W1e6 * E1e6 - W36 * E3j6;
    const lanes TMY6_1 = E1_2e5 * l1e6 + L1_2e6 * fMY6_2 - L1_2e5 * nXY6_2 - E1_1e6 * l2e5 - L1_1e6 * nYZ6_2;
    lanes_put(&out[38], TMY6_1, stream);
    const lanes TMY6_2e = E2_2e5 * l1e6 - E2_1e6 * l2e5;
    const lanes TMY6_2 = L2_2e6 * fMY6_2 + TMY6_2e - L2_2e5 * nXY6_2 - L2_1e6 * nYZ6_2;
    lanes_put(&out[90], TMY6_2, stream);
    const lanes TMY6_3 = L3_2e6 * fMY6_2 + TMY6_2e - L3_2e5 * nXY6_2 - L3_1e6 * nYZ6_2;
    lanes_put(&out[142], TMY6_3, stream);
    const lanes TMY6_4 = -C5 * l1e6 - E4_1e6 * l2e5;
    lanes_put(&out[194], TMY6_4, stream);
    const lanes TMY6_5 = -S6 * l2e5;
    lanes_put(&out[246], TMY6_5, stream);
    const lanes sFS1 = lanes_sign(qd[0]);
    lanes_put(&out[40], sFS1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    lanes_put(&out[94], sFS2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    lanes_put(&out[148], sFS3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    lanes_put(&out[202], sFS4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    lanes_put(&out[256], sFS5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    lanes_put(&out[310], sFS6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdr, const lanes *qddr, apart *out)
{
    return panel(q, qd, qdr, qddr, out, 0);
}

int puma560_slotine_li_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdr[REACH(6u)];
    lanes lanes_qdr[BLOCKS(6u)];
    double padded_qddr[REACH(6u)];
    lanes lanes_qddr[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdr, 6u, lanes_qdr);
    lanes_shared(qddr, 6u, lanes_qddr);
    lanes lanes_out[BLOCKS(312u)];
    double scratch[312u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
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
        status |= plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, (apart *)lanes_out);
        lanes_store(lanes_out, 312u, count, stream, scratch, &out[k * 312u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdr[REACH(6u)];
    lanes lanes_qdr[BLOCKS(6u)];
    double padded_qddr[REACH(6u)];
    lanes lanes_qddr[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdr, 6u, lanes_qdr);
    lanes_shared(qddr, 6u, lanes_qddr);
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
        apart *lanes_out = (apart *)&out[k * 312u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdr, lanes_qddr, lanes_out);
    }
    return status;
}

int puma560_slotine_li_regressor_panels(int stream, size_t N, const size_t *strides,
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

int puma560_slotine_li_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdr = (strides != NULL) ? strides[2] : 6u;
    const size_t stride_qddr = (strides != NULL) ? strides[3] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_slotine_li_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdr[k * stride_qdr], &qddr[k * stride_qddr], &out[k * 312u]);
    }
    return status;
}

int puma560_slotine_li_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    return puma560_slotine_li_regressor_rows(stream, N, strides, q, qd, qdr, qddr, out);
}

#endif

size_t puma560_slotine_li_regressor_width(void)
{
    return puma560_WIDTH;
}

void puma560_slotine_li_regressor_batch(size_t N, const double *q, const double *qd, const double *qdr, const double *qddr, double *out)
{
    (void)puma560_slotine_li_regressor_rows(0, N, NULL, q, qd, qdr, qddr, out);
}
