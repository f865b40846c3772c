/* twin: torque_regressor of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, apart *out, const int stream)
{
    (void)stream;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    const double gz = 9.81;
    lanes_put(&out[0], qdd[0], stream);
    lanes_put(&out[45], qd[0], stream);
    lanes_put(&out[63], qdd[1], stream);
    lanes_put(&out[105], qd[1], stream);
    lanes_put(&out[131], qdd[2], stream);
    lanes_put(&out[165], qd[2], stream);
    lanes_put(&out[197], qdd[3], stream);
    lanes_put(&out[225], qd[3], stream);
    lanes_put(&out[260], qdd[4], stream);
    lanes_put(&out[285], qd[4], stream);
    lanes_put(&out[325], qdd[5], stream);
    lanes_put(&out[345], qd[5], stream);
    lanes_put(&out[391], qdd[6], stream);
    lanes_put(&out[405], qd[6], stream);
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
    const lanes sFS1 = lanes_sign(qd[0]);
    lanes_put(&out[44], sFS1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    lanes_put(&out[104], sFS2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    lanes_put(&out[164], sFS3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    lanes_put(&out[224], sFS4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    lanes_put(&out[284], sFS5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    lanes_put(&out[344], sFS6, stream);
    const lanes sFS7 = lanes_sign(qd[6]);
    lanes_put(&out[404], sFS7, stream);
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
    const lanes L1_3d3 = -d2 - d3 * C2;
    const lanes E1_1e3 = C2 * S3 + S2 * C3;
    const lanes E1_2e3 = C2 * C3 - S2 * S3;
    const lanes L2_1e3 = d3 * S3;
    const lanes L2_2e3 = d3 * C3;
    const lanes E1_1e4 = C4 * E1_1e3;
    const lanes E1_2e4 = -S4 * E1_1e3;
    const lanes L1_1e4 = S4 * L1_3d3;
    const lanes L1_1r4 = r4 * E1_2e4 + L1_1e4;
    const lanes L1_2e4 = C4 * L1_3d3;
    const lanes L1_2r4 = L1_2e4 - r4 * E1_1e4;
    const lanes L2_1e4 = C4 * L2_1e3;
    const lanes L2_1r4 = r4 * C4 + L2_1e4;
    const lanes L2_2e4 = -S4 * L2_1e3;
    const lanes L2_2r4 = L2_2e4 - r4 * S4;
    const lanes L3_1r4 = r4 * C4;
    const lanes L3_2r4 = -r4 * S4;
    const lanes L1_2r6 = -d2 - S5 * R6;
    const lanes E1_1e7 = C5 * S7 + S5 * C7;
    const lanes E1_2e7 = C5 * C7 - S5 * S7;
    const lanes L5_1e7 = R6 * C7;
    const lanes L5_2e7 = -R6 * S7;
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
    const lanes ZP22d2 = qd[0] * qd[0];
    const lanes Z1d2 = -d2 * ZP22d2;
    const lanes Z3d2 = -qdd[0] * d2;
    const lanes X1e2 = qdd[0] * S2;
    const lanes X12 = qd[1] * W2e2 + X1e2;
    const lanes X2e2 = qdd[0] * C2;
    const lanes X22 = X2e2 - qd[1] * W1e2;
    const lanes Z1e2 = gz * S2 + C2 * Z1d2;
    lanes_put(&out[65], -Z1e2, stream);
    const lanes Z2e2 = gz * C2 - S2 * Z1d2;
    lanes_put(&out[64], Z2e2, stream);
    const lanes ZP12d3 = W1e2 * W2e2;
    lanes_put(&out[59], -ZP12d3, stream);
    const lanes ZA2d3 = qdd[1] + ZP12d3;
    const lanes Z2d3 = d3 * ZA2d3 + Z2e2;
    const lanes A2312 = qdd[1] - ZP12d3;
    const lanes ZP13d3 = qd[1] * W1e2;
    const lanes P112 = W1e2 * W1e2;
    const lanes TXX2_1 = C2 * ZP13d3 + S2 * X12;
    lanes_put(&out[1], TXX2_1, stream);
    const lanes A3212 = X22 + ZP13d3;
    lanes_put(&out[62], A3212, stream);
    const lanes ZA3d3 = ZP13d3 - X22;
    const lanes TMX2_1 = -d2 * ZA3d3 - C2 * Z3d2;
    lanes_put(&out[6], TMX2_1, stream);
    const lanes ZP22d3 = W2e2 * W2e2;
    const lanes P232 = qd[1] * W2e2;
    const lanes B32 = P112 - ZP22d3;
    lanes_put(&out[60], B32, stream);
    const lanes A3122 = X12 - P232;
    lanes_put(&out[61], A3122, stream);
    const lanes TZZ2_1 = S2 * P232 - C2 * ZP13d3;
    lanes_put(&out[5], TZZ2_1, stream);
    const lanes A2132 = X12 + P232;
    const lanes TXY2_1 = C2 * A2132 - S2 * ZA3d3;
    lanes_put(&out[2], TXY2_1, stream);
    const lanes Z3d3 = d3 * ZA3d3 + Z3d2;
    const lanes TMY2_1 = S2 * Z3d2 - d2 * A2132;
    lanes_put(&out[7], TMY2_1, stream);
    const lanes ZP33d3 = qd[1] * qd[1];
    const lanes B22 = ZP33d3 - P112;
    const lanes TXZ2_1 = C2 * B22 + S2 * ZA2d3;
    lanes_put(&out[3], TXZ2_1, stream);
    const lanes ZA1d3 = ZP22d3 + ZP33d3;
    const lanes Z1d3 = Z1e2 - d3 * ZA1d3;
    const lanes B12 = ZP22d3 - ZP33d3;
    const lanes TYZ2_1 = C2 * A2312 + S2 * B12;
    lanes_put(&out[4], TYZ2_1, stream);
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    lanes_put(&out[130], -Z1e3, stream);
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    lanes_put(&out[129], Z2e3, stream);
    const lanes X33 = qdd[1] + qdd[2];
    lanes_put(&out[70], X33, stream);
    lanes_put(&out[128], X33, stream);
    const lanes X1e4 = C4 * X13 + S4 * X33;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X2e4 = C4 * X33 - S4 * X13;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes Z1e4 = C4 * Z1e3 + S4 * Z3d3;
    const lanes Z2e4 = C4 * Z3d3 - S4 * Z1e3;
    const lanes X34 = qdd[3] - X23;
    lanes_put(&out[194], X34, stream);
    const lanes ZP13r4 = W1e4 * W34;
    const lanes TXX4_2e = C4 * ZP13r4 + S4 * X14;
    lanes_put(&out[74], TXX4_2e, stream);
    lanes_put(&out[132], TXX4_2e, stream);
    const lanes ZA1r4 = X24 + ZP13r4;
    lanes_put(&out[193], ZA1r4, stream);
    const lanes Z1r4 = r4 * ZA1r4 + Z1e4;
    lanes_put(&out[196], -Z1r4, stream);
    const lanes A1234 = X24 - ZP13r4;
    const lanes ZP23r4 = W2e4 * W34;
    const lanes P334 = W34 * W34;
    const lanes TZZ4_1 = E1_1e4 * ZP23r4 - E1_2e3 * X34 - E1_2e4 * ZP13r4;
    lanes_put(&out[20], TZZ4_1, stream);
    const lanes TZZ4_2e = S4 * ZP23r4 - C4 * ZP13r4;
    lanes_put(&out[78], TZZ4_2e, stream);
    lanes_put(&out[136], TZZ4_2e, stream);
    const lanes ZA2r4 = ZP23r4 - X14;
    lanes_put(&out[192], -ZA2r4, stream);
    const lanes Z2r4 = r4 * ZA2r4 + Z2e4;
    lanes_put(&out[195], Z2r4, stream);
    const lanes A2134 = X14 + ZP23r4;
    const lanes TXY4_2e = C4 * A2134 + S4 * A1234;
    lanes_put(&out[75], TXY4_2e, stream);
    lanes_put(&out[133], TXY4_2e, stream);
    const lanes ZP11r4 = W1e4 * W1e4;
    const lanes P124 = W1e4 * W2e4;
    lanes_put(&out[190], -P124, stream);
    const lanes ZP22r4 = W2e4 * W2e4;
    const lanes TXX4_1 = E1_2e3 * P124 + E1_1e4 * X14 + E1_2e4 * ZP13r4;
    lanes_put(&out[16], TXX4_1, stream);
    const lanes ZA3r4 = ZP11r4 + ZP22r4;
    const lanes Z3r4 = -r4 * ZA3r4 - Z2e3;
    const lanes X1e5 = qdd[0] * S5;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X2e5 = qdd[0] * C5;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes Z1e5 = gz * S5 + C5 * Z1d2;
    lanes_put(&out[262], -Z1e5, stream);
    const lanes Z2e5 = gz * C5 - S5 * Z1d2;
    lanes_put(&out[261], Z2e5, stream);
    const lanes ZP13r6 = -W1e5 * W2e5;
    lanes_put(&out[256], ZP13r6, stream);
    const lanes ZA1r6 = qdd[4] + ZP13r6;
    const lanes Z1r6 = R6 * ZA1r6 + Z1e5;
    const lanes A1325 = qdd[4] - ZP13r6;
    lanes_put(&out[321], -A1325, stream);
    const lanes ZP23r6 = -qd[4] * W2e5;
    const lanes P225 = W2e5 * W2e5;
    const lanes A3125 = X15 + ZP23r6;
    lanes_put(&out[258], A3125, stream);
    lanes_put(&out[322], A3125, stream);
    const lanes ZA2r6 = ZP23r6 - X15;
    const lanes TMY5_1 = d2 * ZA2r6 + S5 * Z3d2;
    lanes_put(&out[30], TMY5_1, stream);
    const lanes ZP11r6 = W1e5 * W1e5;
    const lanes B35 = ZP11r6 - P225;
    lanes_put(&out[257], B35, stream);
    const lanes ZP22r6 = qd[4] * qd[4];
    const lanes ZA3r6 = ZP11r6 + ZP22r6;
    lanes_put(&out[323], -ZA3r6, stream);
    const lanes Z3r6 = -R6 * ZA3r6 - Z2e5;
    const lanes Z36 = qdd[5] + Z3r6;
    lanes_put(&out[324], Z36, stream);
    const lanes Z2r6 = R6 * ZA2r6 + Z3d2;
    const lanes Y6 = 2.0 * qd[5];
    const lanes Z16 = qd[4] * Y6 + Z1r6;
    const lanes Z26 = Z2r6 - W1e5 * Y6;
    const lanes P135 = qd[4] * W1e5;
    const lanes TXX5_1 = C5 * P135 + S5 * X15;
    lanes_put(&out[24], TXX5_1, stream);
    const lanes TZZ5_1 = -C5 * P135 - S5 * ZP23r6;
    lanes_put(&out[28], TZZ5_1, stream);
    const lanes TMZ6_1 = L1_2r6 * ZA2r6 - S5 * Z26;
    lanes_put(&out[33], TMZ6_1, stream);
    const lanes TMZ6_5 = R6 * ZA1r6 + Z16;
    lanes_put(&out[265], TMZ6_5, stream);
    const lanes TM6_1 = L1_2r6 * Z26;
    lanes_put(&out[34], TM6_1, stream);
    const lanes TM6_5 = R6 * Z16;
    lanes_put(&out[266], TM6_5, stream);
    const lanes X1e7 = C7 * X15 + S7 * X25;
    const lanes X2e7 = C7 * X25 - S7 * X15;
    const lanes X17 = qd[6] * W2e7 + X1e7;
    const lanes X27 = X2e7 - qd[6] * W1e7;
    const lanes Z1e7 = C7 * Z16 - S7 * Z36;
    lanes_put(&out[390], -Z1e7, stream);
    const lanes Z2e7 = -C7 * Z36 - S7 * Z16;
    lanes_put(&out[389], Z2e7, stream);
    const lanes X37 = qdd[4] + qdd[6];
    lanes_put(&out[272], X37, stream);
    lanes_put(&out[388], X37, stream);
    const lanes P113 = W1e3 * W1e3;
    const lanes P123 = W1e3 * W2e3;
    lanes_put(&out[66], -P123, stream);
    lanes_put(&out[124], -P123, stream);
    const lanes P133 = W1e3 * W33;
    const lanes TXX3_1 = E1_1e3 * X13 + E1_2e3 * P133;
    lanes_put(&out[8], TXX3_1, stream);
    const lanes A3213 = X23 + P133;
    lanes_put(&out[69], A3213, stream);
    lanes_put(&out[127], A3213, stream);
    const lanes A1233 = X23 - P133;
    const lanes TMX3_1 = -L1_3d3 * A1233 - E1_2e3 * Z3d3;
    lanes_put(&out[13], TMX3_1, stream);
    const lanes P223 = W2e3 * W2e3;
    const lanes P233 = W2e3 * W33;
    const lanes P333 = W33 * W33;
    const lanes B33 = P113 - P223;
    lanes_put(&out[67], B33, stream);
    lanes_put(&out[125], B33, stream);
    const lanes A3123 = X13 - P233;
    lanes_put(&out[68], A3123, stream);
    lanes_put(&out[126], A3123, stream);
    const lanes A2133 = X13 + P233;
    const lanes TXY3_1 = E1_1e3 * A1233 + E1_2e3 * A2133;
    lanes_put(&out[9], TXY3_1, stream);
    const lanes TZZ3_1 = E1_1e3 * P233 - E1_2e3 * P133;
    lanes_put(&out[12], TZZ3_1, stream);
    const lanes TMY3_1 = L1_3d3 * A2133 + E1_1e3 * Z3d3;
    lanes_put(&out[14], TMY3_1, stream);
    const lanes A1323 = X33 + P123;
    const lanes A2313 = X33 - P123;
    const lanes B23 = P333 - P113;
    const lanes TXZ3_1 = E1_1e3 * A1323 + E1_2e3 * B23;
    lanes_put(&out[10], TXZ3_1, stream);
    const lanes Q23 = P113 + P333;
    const lanes TMY3_2 = -L2_1e3 * A2313 - L2_2e3 * Q23 - Z1e3;
    lanes_put(&out[72], TMY3_2, stream);
    const lanes B13 = P223 - P333;
    const lanes TYZ3_1 = E1_1e3 * B13 + E1_2e3 * A2313;
    lanes_put(&out[11], TYZ3_1, stream);
    const lanes Q13 = P223 + P333;
    const lanes TMX3_2 = L2_2e3 * A1323 + Z2e3 - L2_1e3 * Q13;
    lanes_put(&out[71], TMX3_2, stream);
    const lanes B34 = ZP11r4 - ZP22r4;
    lanes_put(&out[191], B34, stream);
    const lanes TXY4_1 = E1_1e4 * A1234 + E1_2e4 * A2134 - E1_2e3 * B34;
    lanes_put(&out[17], TXY4_1, stream);
    const lanes A1324 = X34 + P124;
    const lanes A2314 = X34 - P124;
    const lanes B24 = P334 - ZP11r4;
    const lanes TXZ4_1 = E1_2e3 * ZA2r4 + E1_1e4 * A1324 + E1_2e4 * B24;
    lanes_put(&out[18], TXZ4_1, stream);
    const lanes TXZ4_2e = C4 * B24 + S4 * A1324;
    lanes_put(&out[76], TXZ4_2e, stream);
    lanes_put(&out[134], TXZ4_2e, stream);
    const lanes Q24 = ZP11r4 + P334;
    const lanes TMY4_1 = E1_2e3 * Z1r4 + E1_1e4 * Z3r4 - L1_1r4 * A2314 - L1_2r4 * Q24;
    lanes_put(&out[22], TMY4_1, stream);
    const lanes B14 = ZP22r4 - P334;
    const lanes TYZ4_1 = E1_1e4 * B14 + E1_2e4 * A2314 - E1_2e3 * ZA1r4;
    lanes_put(&out[19], TYZ4_1, stream);
    const lanes TYZ4_2e = C4 * A2314 + S4 * B14;
    lanes_put(&out[77], TYZ4_2e, stream);
    lanes_put(&out[135], TYZ4_2e, stream);
    const lanes Q14 = ZP22r4 + P334;
    const lanes TMX4_1 = L1_2r4 * A1324 - E1_2e3 * Z2r4 - E1_2e4 * Z3r4 - L1_1r4 * Q14;
    lanes_put(&out[21], TMX4_1, stream);
    const lanes TMX4_2e = -C4 * Z3r4;
    const lanes TMX4_2 = L2_2e3 * A1234 + L2_2r4 * A1324 + TMX4_2e - L2_1r4 * Q14;
    lanes_put(&out[79], TMX4_2, stream);
    const lanes TMX4_3 = L3_2r4 * A1324 + TMX4_2e - L3_1r4 * Q14;
    lanes_put(&out[137], TMX4_3, stream);
    const lanes TMY4_2e = S4 * Z3r4;
    const lanes TMY4_2 = TMY4_2e - L2_2e3 * A2134 - L2_1r4 * A2314 - L2_2r4 * Q24;
    lanes_put(&out[80], TMY4_2, stream);
    const lanes TMY4_3 = TMY4_2e - L3_1r4 * A2314 - L3_2r4 * Q24;
    lanes_put(&out[138], TMY4_3, stream);
    const lanes A1235 = X25 - P135;
    const lanes TXY5_1 = S5 * A1235 - C5 * ZA2r6;
    lanes_put(&out[25], TXY5_1, stream);
    const lanes A3215 = X25 + P135;
    lanes_put(&out[259], A3215, stream);
    const lanes TMX5_1 = d2 * A1235 - C5 * Z3d2;
    lanes_put(&out[29], TMX5_1, stream);
    const lanes TMX6_1 = -C5 * Z26 - L1_2r6 * A1235;
    lanes_put(&out[31], TMX6_1, stream);
    const lanes TMY6_5 = R6 * A3215;
    lanes_put(&out[264], TMY6_5, stream);
    const lanes B25 = ZP22r6 - ZP11r6;
    const lanes TXZ5_1 = C5 * B25 + S5 * A1325;
    lanes_put(&out[26], TXZ5_1, stream);
    const lanes Q35 = ZP11r6 + P225;
    const lanes TMY6_1 = C5 * Z16 + S5 * Z36 - L1_2r6 * Q35;
    lanes_put(&out[32], TMY6_1, stream);
    const lanes B15 = P225 - ZP22r6;
    const lanes TYZ5_1 = C5 * ZA1r6 + S5 * B15;
    lanes_put(&out[27], TYZ5_1, stream);
    const lanes Q15 = ZP22r6 + P225;
    const lanes TMX6_5 = -R6 * Q15 - Z36;
    lanes_put(&out[263], TMX6_5, stream);
    const lanes P117 = W1e7 * W1e7;
    const lanes P127 = W1e7 * W2e7;
    lanes_put(&out[268], -P127, stream);
    lanes_put(&out[384], -P127, stream);
    const lanes P137 = W1e7 * W37;
    const lanes TXX7_1 = E1_1e7 * X17 + E1_2e7 * P137;
    lanes_put(&out[36], TXX7_1, stream);
    const lanes A3217 = X27 + P137;
    lanes_put(&out[271], A3217, stream);
    lanes_put(&out[387], A3217, stream);
    const lanes A1237 = X27 - P137;
    const lanes TMX7_1 = -L1_2r6 * A1237 - E1_2e7 * Z26;
    lanes_put(&out[41], TMX7_1, stream);
    const lanes P227 = W2e7 * W2e7;
    const lanes P237 = W2e7 * W37;
    const lanes P337 = W37 * W37;
    const lanes B37 = P117 - P227;
    lanes_put(&out[269], B37, stream);
    lanes_put(&out[385], B37, stream);
    const lanes A3127 = X17 - P237;
    lanes_put(&out[270], A3127, stream);
    lanes_put(&out[386], A3127, stream);
    const lanes A2137 = X17 + P237;
    const lanes TXY7_1 = E1_1e7 * A1237 + E1_2e7 * A2137;
    lanes_put(&out[37], TXY7_1, stream);
    const lanes TZZ7_1 = E1_1e7 * P237 - E1_2e7 * P137;
    lanes_put(&out[40], TZZ7_1, stream);
    const lanes TMY7_1 = L1_2r6 * A2137 + E1_1e7 * Z26;
    lanes_put(&out[42], TMY7_1, stream);
    const lanes A1327 = X37 + P127;
    const lanes A2317 = X37 - P127;
    const lanes B27 = P337 - P117;
    const lanes TXZ7_1 = E1_1e7 * A1327 + E1_2e7 * B27;
    lanes_put(&out[38], TXZ7_1, stream);
    const lanes Q27 = P117 + P337;
    const lanes TMY7_5 = -L5_1e7 * A2317 - L5_2e7 * Q27 - Z1e7;
    lanes_put(&out[274], TMY7_5, stream);
    const lanes TMY7_6 = C7 * Q27 + S7 * A2317;
    lanes_put(&out[332], TMY7_6, stream);
    const lanes B17 = P227 - P337;
    const lanes TYZ7_1 = E1_1e7 * B17 + E1_2e7 * A2317;
    lanes_put(&out[39], TYZ7_1, stream);
    const lanes Q17 = P227 + P337;
    const lanes TMX7_5 = L5_2e7 * A1327 + Z2e7 - L5_1e7 * Q17;
    lanes_put(&out[273], TMX7_5, stream);
    const lanes TMX7_6 = S7 * Q17 - C7 * A1327;
    lanes_put(&out[331], TMX7_6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, apart *out)
{
    return panel(q, qd, qdd, out, 0);
}

int twin_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdd[REACH(7u)];
    lanes lanes_qdd[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdd, 7u, lanes_qdd);
    lanes lanes_out[BLOCKS(406u)];
    double scratch[406u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_load(qdd, 7u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdd, (apart *)lanes_out);
        lanes_store(lanes_out, 406u, count, stream, scratch, &out[k * 406u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    double padded_qdd[REACH(7u)];
    lanes lanes_qdd[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes_shared(qdd, 7u, lanes_qdd);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_load(qdd, 7u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        apart *lanes_out = (apart *)&out[k * 406u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_out);
    }
    return status;
}

int twin_torque_regressor_panels(int stream, size_t N, const size_t *strides,
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

int twin_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_torque_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &out[k * 406u]);
    }
    return status;
}

int twin_torque_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    return twin_torque_regressor_rows(stream, N, strides, q, qd, qdd, out);
}

#endif

size_t twin_torque_regressor_width(void)
{
    return twin_WIDTH;
}

void twin_torque_regressor_batch(size_t N, const double *q, const double *qd, const double *qdd, double *out)
{
    (void)twin_torque_regressor_rows(0, N, NULL, q, qd, qdd, out);
}
