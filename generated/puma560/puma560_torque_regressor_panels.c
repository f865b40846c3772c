/* puma560: torque_regressor of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, apart *out, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    lanes_put(&out[0], qdd[0], stream);
    lanes_put(&out[41], qd[0], stream);
    lanes_put(&out[57], qdd[1], stream);
    lanes_put(&out[95], qd[1], stream);
    lanes_put(&out[119], qdd[2], stream);
    lanes_put(&out[149], qd[2], stream);
    lanes_put(&out[179], qdd[3], stream);
    lanes_put(&out[203], qd[3], stream);
    lanes_put(&out[239], qdd[4], stream);
    lanes_put(&out[257], qd[4], stream);
    lanes_put(&out[299], qdd[5], stream);
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
    const lanes X1e2 = -qdd[0] * S2;
    const lanes X2e2 = -qdd[0] * C2;
    const lanes X12 = qd[1] * W2e2 + X1e2;
    const lanes X22 = X2e2 - qd[1] * W1e2;
    const lanes ZP13r2 = qd[1] * W1e2;
    const lanes ZA1r2 = X22 + ZP13r2;
    lanes_put(&out[56], ZA1r2, stream);
    const lanes ZP23r2 = qd[1] * W2e2;
    const lanes ZA2r2 = ZP23r2 - X12;
    lanes_put(&out[55], -ZA2r2, stream);
    const lanes ZP11r2 = W1e2 * W1e2;
    const lanes ZP22r2 = W2e2 * W2e2;
    const lanes ZA3r2 = ZP11r2 + ZP22r2;
    const lanes Z1r2 = puma560_geometry_R2 * ZA1r2 - G1e2;
    lanes_put(&out[59], -Z1r2, stream);
    const lanes Z2r2 = puma560_geometry_R2 * ZA2r2 - G2e2;
    lanes_put(&out[58], Z2r2, stream);
    const lanes Z3r2 = -puma560_geometry_R2 * ZA3r2;
    const lanes ZP12d3 = W1e2 * W2e2;
    lanes_put(&out[53], -ZP12d3, stream);
    const lanes ZA2d3 = qdd[1] + ZP12d3;
    const lanes ZA3d3 = ZP13r2 - X22;
    const lanes ZP33d3 = qd[1] * qd[1];
    const lanes ZA1d3 = ZP22r2 + ZP33d3;
    const lanes Z2d3 = puma560_geometry_D3 * ZA2d3 + Z2r2;
    const lanes Z3d3 = puma560_geometry_D3 * ZA3d3 + Z3r2;
    const lanes Z1d3 = Z1r2 - puma560_geometry_D3 * ZA1d3;
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes X33 = qdd[1] + qdd[2];
    lanes_put(&out[64], X33, stream);
    lanes_put(&out[116], X33, stream);
    const lanes ZP13r3 = W1e3 * W33;
    const lanes ZA1r3 = X23 + ZP13r3;
    lanes_put(&out[63], ZA1r3, stream);
    lanes_put(&out[115], ZA1r3, stream);
    const lanes ZP23r3 = W2e3 * W33;
    const lanes ZA2r3 = ZP23r3 - X13;
    lanes_put(&out[62], -ZA2r3, stream);
    lanes_put(&out[114], -ZA2r3, stream);
    const lanes ZP11r3 = W1e3 * W1e3;
    const lanes ZP22r3 = W2e3 * W2e3;
    const lanes ZA3r3 = ZP11r3 + ZP22r3;
    const lanes Z1r3 = puma560_geometry_R3 * ZA1r3 + Z1e3;
    lanes_put(&out[118], -Z1r3, stream);
    const lanes Z2r3 = puma560_geometry_R3 * ZA2r3 + Z2e3;
    lanes_put(&out[117], Z2r3, stream);
    const lanes Z3r3 = Z3d3 - puma560_geometry_R3 * ZA3r3;
    const lanes ZA2d4 = ZP13r3 - X23;
    const lanes ZP13d4 = -W1e3 * W2e3;
    lanes_put(&out[60], ZP13d4, stream);
    lanes_put(&out[112], ZP13d4, stream);
    const lanes ZA3d4 = ZP13d4 - X33;
    const lanes ZP22d4 = W33 * W33;
    const lanes ZA1d4 = ZP22r3 + ZP22d4;
    const lanes Z2d4 = puma560_geometry_D4 * ZA2d4 + Z3r3;
    const lanes Z3d4 = puma560_geometry_D4 * ZA3d4 - Z2r3;
    const lanes Z1d4 = Z1r3 - puma560_geometry_D4 * ZA1d4;
    const lanes X1e4 = C4 * X13 + S4 * X33;
    const lanes X2e4 = C4 * X33 - S4 * X13;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes X34 = qdd[3] - X23;
    lanes_put(&out[176], X34, stream);
    const lanes ZP13r4 = W1e4 * W34;
    const lanes ZA1r4 = X24 + ZP13r4;
    lanes_put(&out[175], ZA1r4, stream);
    const lanes ZP23r4 = W2e4 * W34;
    const lanes ZA2r4 = ZP23r4 - X14;
    lanes_put(&out[174], -ZA2r4, stream);
    const lanes ZP11r4 = W1e4 * W1e4;
    const lanes ZP22r4 = W2e4 * W2e4;
    const lanes ZA3r4 = ZP11r4 + ZP22r4;
    const lanes Z1r4 = puma560_geometry_R4 * ZA1r4 + Z1e4;
    lanes_put(&out[178], -Z1r4, stream);
    const lanes Z2r4 = puma560_geometry_R4 * ZA2r4 + Z2e4;
    lanes_put(&out[177], Z2r4, stream);
    const lanes Z3r4 = Z3d4 - puma560_geometry_R4 * ZA3r4;
    const lanes X1e5 = C5 * X14 - S5 * X34;
    const lanes X2e5 = -C5 * X34 - S5 * X14;
    const lanes Z1e5 = C5 * Z1r4 - S5 * Z3r4;
    lanes_put(&out[238], -Z1e5, stream);
    const lanes Z2e5 = -C5 * Z3r4 - S5 * Z1r4;
    lanes_put(&out[237], Z2e5, stream);
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes X35 = qdd[4] + X24;
    lanes_put(&out[236], X35, stream);
    const lanes X1e6 = C6 * X15 + S6 * X35;
    const lanes X2e6 = C6 * X35 - S6 * X15;
    const lanes Z1e6 = C6 * Z1e5 + S6 * Z2r4;
    lanes_put(&out[298], -Z1e6, stream);
    const lanes Z2e6 = C6 * Z2r4 - S6 * Z1e5;
    lanes_put(&out[297], Z2e6, stream);
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes X36 = qdd[5] - X25;
    lanes_put(&out[296], X36, stream);
    const lanes TXX2_1 = -C2 * ZP13r2 - S2 * X12;
    lanes_put(&out[1], TXX2_1, stream);
    const lanes A2132 = X12 + ZP23r2;
    const lanes B32 = ZP11r2 - ZP22r2;
    lanes_put(&out[54], B32, stream);
    const lanes TXY2_1 = S2 * ZA3d3 - C2 * A2132;
    lanes_put(&out[2], TXY2_1, stream);
    const lanes B22 = ZP33d3 - ZP11r2;
    const lanes TXZ2_1 = -C2 * B22 - S2 * ZA2d3;
    lanes_put(&out[3], TXZ2_1, stream);
    const lanes A2312 = qdd[1] - ZP12d3;
    const lanes B12 = ZP22r2 - ZP33d3;
    const lanes TYZ2_1 = -C2 * A2312 - S2 * B12;
    lanes_put(&out[4], TYZ2_1, stream);
    const lanes TZZ2_1 = C2 * ZP13r2 - S2 * ZP23r2;
    lanes_put(&out[5], TZZ2_1, stream);
    const lanes TMX2_1 = C2 * Z3r2 + L1_2r2 * ZA2d3 - L1_1r2 * ZA1d3;
    lanes_put(&out[6], TMX2_1, stream);
    const lanes Q22 = ZP11r2 + ZP33d3;
    const lanes TMY2_1 = -S2 * Z3r2 - L1_1r2 * A2312 - L1_2r2 * Q22;
    lanes_put(&out[7], TMY2_1, stream);
    const lanes TXX3_1 = E1_1e3 * X13 + E1_2e3 * ZP13r3;
    lanes_put(&out[8], TXX3_1, stream);
    const lanes A2133 = X13 + ZP23r3;
    const lanes B33 = ZP11r3 - ZP22r3;
    lanes_put(&out[61], B33, stream);
    lanes_put(&out[113], B33, stream);
    const lanes TXY3_1 = E1_2e3 * A2133 - E1_1e3 * ZA2d4;
    lanes_put(&out[9], TXY3_1, stream);
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes TXZ3_1 = E1_2e3 * B23 - E1_1e3 * ZA3d4;
    lanes_put(&out[10], TXZ3_1, stream);
    const lanes A2313 = X33 + ZP13d4;
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes TYZ3_1 = E1_1e3 * B13 + E1_2e3 * A2313;
    lanes_put(&out[11], TYZ3_1, stream);
    const lanes TZZ3_1 = E1_1e3 * ZP23r3 - E1_2e3 * ZP13r3;
    lanes_put(&out[12], TZZ3_1, stream);
    const lanes TMX3_1 = L1_3d3 * ZA2d4 - E1_2e3 * Z3r3 - L1_1r3 * ZA1d4 - L1_2r3 * ZA3d4;
    lanes_put(&out[13], TMX3_1, stream);
    const lanes TMX3_2 = Z2r3 - L2_1e3 * ZA1d4 - L2_2e3 * ZA3d4;
    lanes_put(&out[65], TMX3_2, stream);
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes TMY3_1 = L1_3d3 * A2133 + E1_1e3 * Z3r3 - L1_1r3 * A2313 - L1_2r3 * Q23;
    lanes_put(&out[14], TMY3_1, stream);
    const lanes TMY3_2 = -L2_1e3 * A2313 - L2_2e3 * Q23 - Z1r3;
    lanes_put(&out[66], TMY3_2, stream);
    const lanes P124 = W1e4 * W2e4;
    lanes_put(&out[172], -P124, stream);
    const lanes P334 = W34 * W34;
    const lanes TXX4_1 = E1_2e3 * P124 + E1_1e4 * X14 + E1_2e4 * ZP13r4;
    lanes_put(&out[16], TXX4_1, stream);
    const lanes TXX4_2e = C4 * ZP13r4 + S4 * X14;
    lanes_put(&out[68], TXX4_2e, stream);
    lanes_put(&out[120], TXX4_2e, stream);
    const lanes A1234 = X24 - ZP13r4;
    const lanes A2134 = X14 + ZP23r4;
    const lanes B34 = ZP11r4 - ZP22r4;
    lanes_put(&out[173], B34, stream);
    const lanes TXY4_1 = E1_1e4 * A1234 + E1_2e4 * A2134 - E1_2e3 * B34;
    lanes_put(&out[17], TXY4_1, stream);
    const lanes TXY4_2e = C4 * A2134 + S4 * A1234;
    lanes_put(&out[69], TXY4_2e, stream);
    lanes_put(&out[121], TXY4_2e, stream);
    const lanes A1324 = X34 + P124;
    const lanes B24 = P334 - ZP11r4;
    const lanes TXZ4_1 = E1_2e3 * ZA2r4 + E1_1e4 * A1324 + E1_2e4 * B24;
    lanes_put(&out[18], TXZ4_1, stream);
    const lanes TXZ4_2e = C4 * B24 + S4 * A1324;
    lanes_put(&out[70], TXZ4_2e, stream);
    lanes_put(&out[122], TXZ4_2e, stream);
    const lanes A2314 = X34 - P124;
    const lanes B14 = ZP22r4 - P334;
    const lanes TYZ4_1 = E1_1e4 * B14 + E1_2e4 * A2314 - E1_2e3 * ZA1r4;
    lanes_put(&out[19], TYZ4_1, stream);
    const lanes TYZ4_2e = C4 * A2314 + S4 * B14;
    lanes_put(&out[71], TYZ4_2e, stream);
    lanes_put(&out[123], TYZ4_2e, stream);
    const lanes TZZ4_1 = E1_1e4 * ZP23r4 - E1_2e3 * X34 - E1_2e4 * ZP13r4;
    lanes_put(&out[20], TZZ4_1, stream);
    const lanes TZZ4_2e = S4 * ZP23r4 - C4 * ZP13r4;
    lanes_put(&out[72], TZZ4_2e, stream);
    lanes_put(&out[124], TZZ4_2e, stream);
    const lanes Q14 = ZP22r4 + P334;
    const lanes TMX4_1 = L1_2r3 * A1234 + L1_2r4 * A1324 - E1_2e3 * Z2r4 - E1_2e4 * Z3r4 - L1_1r4 * Q14;
    lanes_put(&out[21], TMX4_1, stream);
    const lanes TMX4_2e = -C4 * Z3r4;
    const lanes TMX4_2 = L2_2r4 * A1324 + TMX4_2e - L2_3d4 * A1234 - L2_1r4 * Q14;
    lanes_put(&out[73], TMX4_2, stream);
    const lanes TMX4_3 = puma560_geometry_D4 * A1234 + L3_2r4 * A1324 + TMX4_2e - L3_1r4 * Q14;
    lanes_put(&out[125], TMX4_3, stream);
    const lanes Q24 = ZP11r4 + P334;
    const lanes TMY4_1 = E1_2e3 * Z1r4 + E1_1e4 * Z3r4 - L1_2r3 * A2134 - L1_1r4 * A2314 - L1_2r4 * Q24;
    lanes_put(&out[22], TMY4_1, stream);
    const lanes TMY4_2e = S4 * Z3r4;
    const lanes TMY4_2 = L2_3d4 * A2134 + TMY4_2e - L2_1r4 * A2314 - L2_2r4 * Q24;
    lanes_put(&out[74], TMY4_2, stream);
    const lanes TMY4_3 = TMY4_2e - puma560_geometry_D4 * A2134 - L3_1r4 * A2314 - L3_2r4 * Q24;
    lanes_put(&out[126], TMY4_3, stream);
    const lanes P115 = W1e5 * W1e5;
    const lanes P125 = W1e5 * W2e5;
    lanes_put(&out[232], -P125, stream);
    const lanes P135 = W1e5 * W35;
    const lanes P225 = W2e5 * W2e5;
    const lanes P235 = W2e5 * W35;
    const lanes P335 = W35 * W35;
    const lanes TXX5_1 = E1_1e5 * X15 + E1_2e5 * P135 - E1_2e4 * P125;
    lanes_put(&out[24], TXX5_1, stream);
    const lanes TXX5_2e = E2_1e5 * X15 + E2_2e5 * P135 - C4 * P125;
    lanes_put(&out[76], TXX5_2e, stream);
    lanes_put(&out[128], TXX5_2e, stream);
    const lanes TXX5_4 = -C5 * P135 - S5 * X15;
    lanes_put(&out[180], TXX5_4, stream);
    const lanes A1235 = X25 - P135;
    const lanes A2135 = X15 + P235;
    const lanes B35 = P115 - P225;
    lanes_put(&out[233], B35, stream);
    const lanes TXY5_1 = E1_2e4 * B35 + E1_1e5 * A1235 + E1_2e5 * A2135;
    lanes_put(&out[25], TXY5_1, stream);
    const lanes TXY5_2e = C4 * B35 + E2_1e5 * A1235 + E2_2e5 * A2135;
    lanes_put(&out[77], TXY5_2e, stream);
    lanes_put(&out[129], TXY5_2e, stream);
    const lanes TXY5_4 = -C5 * A2135 - S5 * A1235;
    lanes_put(&out[181], TXY5_4, stream);
    const lanes A1325 = X35 + P125;
    const lanes A3125 = X15 - P235;
    lanes_put(&out[234], A3125, stream);
    const lanes B25 = P335 - P115;
    const lanes TXZ5_1 = E1_2e4 * A3125 + E1_1e5 * A1325 + E1_2e5 * B25;
    lanes_put(&out[26], TXZ5_1, stream);
    const lanes TXZ5_2e = C4 * A3125 + E2_1e5 * A1325 + E2_2e5 * B25;
    lanes_put(&out[78], TXZ5_2e, stream);
    lanes_put(&out[130], TXZ5_2e, stream);
    const lanes TXZ5_4 = -C5 * B25 - S5 * A1325;
    lanes_put(&out[182], TXZ5_4, stream);
    const lanes A2315 = X35 - P125;
    const lanes A3215 = X25 + P135;
    lanes_put(&out[235], A3215, stream);
    const lanes B15 = P225 - P335;
    const lanes TYZ5_1 = E1_2e4 * A3215 + E1_1e5 * B15 + E1_2e5 * A2315;
    lanes_put(&out[27], TYZ5_1, stream);
    const lanes TYZ5_2e = C4 * A3215 + E2_1e5 * B15 + E2_2e5 * A2315;
    lanes_put(&out[79], TYZ5_2e, stream);
    lanes_put(&out[131], TYZ5_2e, stream);
    const lanes TYZ5_4 = -C5 * A2315 - S5 * B15;
    lanes_put(&out[183], TYZ5_4, stream);
    const lanes TZZ5_1 = E1_2e4 * X35 + E1_1e5 * P235 - E1_2e5 * P135;
    lanes_put(&out[28], TZZ5_1, stream);
    const lanes TZZ5_2e = C4 * X35 + E2_1e5 * P235 - E2_2e5 * P135;
    lanes_put(&out[80], TZZ5_2e, stream);
    lanes_put(&out[132], TZZ5_2e, stream);
    const lanes TZZ5_4 = C5 * P135 - S5 * P235;
    lanes_put(&out[184], TZZ5_4, stream);
    const lanes Q15 = P225 + P335;
    const lanes TMX5_1 = E1_2e4 * Z2e5 + L1_2e5 * A1325 - L1_2r4 * A1235 - E1_2e5 * Z2r4 - L1_1e5 * Q15;
    lanes_put(&out[29], TMX5_1, stream);
    const lanes TMX5_2e = C4 * Z2e5 - E2_2e5 * Z2r4;
    const lanes TMX5_2 = L2_2e5 * A1325 + TMX5_2e - L2_2r4 * A1235 - L2_1e5 * Q15;
    lanes_put(&out[81], TMX5_2, stream);
    const lanes TMX5_3 = L3_2e5 * A1325 + TMX5_2e - L3_2r4 * A1235 - L3_1e5 * Q15;
    lanes_put(&out[133], TMX5_3, stream);
    const lanes TMX5_4 = C5 * Z2r4;
    lanes_put(&out[185], TMX5_4, stream);
    const lanes Q25 = P115 + P335;
    const lanes TMY5_1 = L1_2r4 * A2135 + E1_1e5 * Z2r4 - E1_2e4 * Z1e5 - L1_1e5 * A2315 - L1_2e5 * Q25;
    lanes_put(&out[30], TMY5_1, stream);
    const lanes TMY5_2e = E2_1e5 * Z2r4 - C4 * Z1e5;
    const lanes TMY5_2 = L2_2r4 * A2135 + TMY5_2e - L2_1e5 * A2315 - L2_2e5 * Q25;
    lanes_put(&out[82], TMY5_2, stream);
    const lanes TMY5_3 = L3_2r4 * A2135 + TMY5_2e - L3_1e5 * A2315 - L3_2e5 * Q25;
    lanes_put(&out[134], TMY5_3, stream);
    const lanes TMY5_4 = -S5 * Z2r4;
    lanes_put(&out[186], TMY5_4, stream);
    const lanes P116 = W1e6 * W1e6;
    const lanes P126 = W1e6 * W2e6;
    lanes_put(&out[292], -P126, stream);
    const lanes P136 = W1e6 * W36;
    const lanes P226 = W2e6 * W2e6;
    const lanes P236 = W2e6 * W36;
    const lanes P336 = W36 * W36;
    const lanes TXX6_1 = E1_2e5 * P126 + E1_1e6 * X16 + E1_2e6 * P136;
    lanes_put(&out[32], TXX6_1, stream);
    const lanes TXX6_2e = E2_2e5 * P126 + E2_1e6 * X16 + E2_2e6 * P136;
    lanes_put(&out[84], TXX6_2e, stream);
    lanes_put(&out[136], TXX6_2e, stream);
    const lanes TXX6_4 = E4_1e6 * X16 + E4_2e6 * P136 - C5 * P126;
    lanes_put(&out[188], TXX6_4, stream);
    const lanes TXX6_5 = C6 * P136 + S6 * X16;
    lanes_put(&out[240], TXX6_5, stream);
    const lanes A1236 = X26 - P136;
    const lanes A2136 = X16 + P236;
    const lanes B36 = P116 - P226;
    lanes_put(&out[293], B36, stream);
    const lanes TXY6_1 = E1_1e6 * A1236 + E1_2e6 * A2136 - E1_2e5 * B36;
    lanes_put(&out[33], TXY6_1, stream);
    const lanes TXY6_2e = E2_1e6 * A1236 + E2_2e6 * A2136 - E2_2e5 * B36;
    lanes_put(&out[85], TXY6_2e, stream);
    lanes_put(&out[137], TXY6_2e, stream);
    const lanes TXY6_4 = C5 * B36 + E4_1e6 * A1236 + E4_2e6 * A2136;
    lanes_put(&out[189], TXY6_4, stream);
    const lanes TXY6_5 = C6 * A2136 + S6 * A1236;
    lanes_put(&out[241], TXY6_5, stream);
    const lanes A1326 = X36 + P126;
    const lanes A3126 = X16 - P236;
    lanes_put(&out[294], A3126, stream);
    const lanes B26 = P336 - P116;
    const lanes TXZ6_1 = E1_1e6 * A1326 + E1_2e6 * B26 - E1_2e5 * A3126;
    lanes_put(&out[34], TXZ6_1, stream);
    const lanes TXZ6_2e = E2_1e6 * A1326 + E2_2e6 * B26 - E2_2e5 * A3126;
    lanes_put(&out[86], TXZ6_2e, stream);
    lanes_put(&out[138], TXZ6_2e, stream);
    const lanes TXZ6_4 = C5 * A3126 + E4_1e6 * A1326 + E4_2e6 * B26;
    lanes_put(&out[190], TXZ6_4, stream);
    const lanes TXZ6_5 = C6 * B26 + S6 * A1326;
    lanes_put(&out[242], TXZ6_5, stream);
    const lanes A2316 = X36 - P126;
    const lanes A3216 = X26 + P136;
    lanes_put(&out[295], A3216, stream);
    const lanes B16 = P226 - P336;
    const lanes TYZ6_1 = E1_1e6 * B16 + E1_2e6 * A2316 - E1_2e5 * A3216;
    lanes_put(&out[35], TYZ6_1, stream);
    const lanes TYZ6_2e = E2_1e6 * B16 + E2_2e6 * A2316 - E2_2e5 * A3216;
    lanes_put(&out[87], TYZ6_2e, stream);
    lanes_put(&out[139], TYZ6_2e, stream);
    const lanes TYZ6_4 = C5 * A3216 + E4_1e6 * B16 + E4_2e6 * A2316;
    lanes_put(&out[191], TYZ6_4, stream);
    const lanes TYZ6_5 = C6 * A2316 + S6 * B16;
    lanes_put(&out[243], TYZ6_5, stream);
    const lanes TZZ6_1 = E1_1e6 * P236 - E1_2e5 * X36 - E1_2e6 * P136;
    lanes_put(&out[36], TZZ6_1, stream);
    const lanes TZZ6_2e = E2_1e6 * P236 - E2_2e5 * X36 - E2_2e6 * P136;
    lanes_put(&out[88], TZZ6_2e, stream);
    lanes_put(&out[140], TZZ6_2e, stream);
    const lanes TZZ6_4 = C5 * X36 + E4_1e6 * P236 - E4_2e6 * P136;
    lanes_put(&out[192], TZZ6_4, stream);
    const lanes TZZ6_5 = S6 * P236 - C6 * P136;
    lanes_put(&out[244], TZZ6_5, stream);
    const lanes Q16 = P226 + P336;
    const lanes TMX6_1 = L1_2e5 * A1236 + E1_2e6 * Z2e5 + L1_2e6 * A1326 - E1_2e5 * Z2e6 - L1_1e6 * Q16;
    lanes_put(&out[37], TMX6_1, stream);
    const lanes TMX6_2e = E2_2e6 * Z2e5 - E2_2e5 * Z2e6;
    const lanes TMX6_2 = L2_2e5 * A1236 + L2_2e6 * A1326 + TMX6_2e - L2_1e6 * Q16;
    lanes_put(&out[89], TMX6_2, stream);
    const lanes TMX6_3 = L3_2e5 * A1236 + L3_2e6 * A1326 + TMX6_2e - L3_1e6 * Q16;
    lanes_put(&out[141], TMX6_3, stream);
    const lanes TMX6_4 = C5 * Z2e6 + E4_2e6 * Z2e5;
    lanes_put(&out[193], TMX6_4, stream);
    const lanes TMX6_5 = C6 * Z2e5;
    lanes_put(&out[245], TMX6_5, stream);
    const lanes Q26 = P116 + P336;
    const lanes TMY6_1 = E1_2e5 * Z1e6 - L1_2e5 * A2136 - E1_1e6 * Z2e5 - L1_1e6 * A2316 - L1_2e6 * Q26;
    lanes_put(&out[38], TMY6_1, stream);
    const lanes TMY6_2e = E2_2e5 * Z1e6 - E2_1e6 * Z2e5;
    const lanes TMY6_2 = TMY6_2e - L2_2e5 * A2136 - L2_1e6 * A2316 - L2_2e6 * Q26;
    lanes_put(&out[90], TMY6_2, stream);
    const lanes TMY6_3 = TMY6_2e - L3_2e5 * A2136 - L3_1e6 * A2316 - L3_2e6 * Q26;
    lanes_put(&out[142], TMY6_3, stream);
    const lanes TMY6_4 = -C5 * Z1e6 - E4_1e6 * Z2e5;
    lanes_put(&out[194], TMY6_4, stream);
    const lanes TMY6_5 = -S6 * Z2e5;
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
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, apart *out)
{
    return panel(q, qd, qdd, out, 0);
}

int puma560_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdd[REACH(6u)];
    lanes lanes_qdd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdd, 6u, lanes_qdd);
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
        if (stride_qdd != 0u) {
            lanes_read(qdd, 6u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdd, (apart *)lanes_out);
        lanes_store(lanes_out, 312u, count, stream, scratch, &out[k * 312u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_qdd[REACH(6u)];
    lanes lanes_qdd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(qdd, 6u, lanes_qdd);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_read(qdd, 6u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        apart *lanes_out = (apart *)&out[k * 312u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_out);
    }
    return status;
}

int puma560_torque_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    if (!(streamed(stream, out))) {
        return panels(0, N, strides, q, qd, qdd, out);
    }
    const int status = panels(1, N, strides, q, qd, qdd, out);
    stream_end();
    return status;
}

#else

int puma560_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_torque_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &out[k * 312u]);
    }
    return status;
}

int puma560_torque_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    return puma560_torque_regressor_rows(stream, N, strides, q, qd, qdd, out);
}

#endif

size_t puma560_torque_regressor_width(void)
{
    return puma560_WIDTH;
}

void puma560_torque_regressor_batch(size_t N, const double *q, const double *qd, const double *qdd, double *out)
{
    (void)puma560_torque_regressor_rows(0, N, NULL, q, qd, qdd, out);
}
