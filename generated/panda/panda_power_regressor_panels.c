/* panda: power_regressor of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, apart *out, const int stream)
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
    const lanes P331 = qd[0] * qd[0];
    lanes_put(&out[49], P331, stream);
    const lanes RZZ1 = qd[0] * qdd[0];
    lanes_put(&out[0], RZZ1, stream);
    const lanes RIA3 = qd[2] * qdd[2];
    lanes_put(&out[15], RIA3, stream);
    const lanes RIA4 = qd[3] * qdd[3];
    lanes_put(&out[23], RIA4, stream);
    const lanes RIA5 = qd[4] * qdd[4];
    lanes_put(&out[31], RIA5, stream);
    const lanes RIA6 = qd[5] * qdd[5];
    lanes_put(&out[39], RIA6, stream);
    const lanes RIA7 = qd[6] * qdd[6];
    lanes_put(&out[47], RIA7, stream);
    const lanes DFS1 = lanes_abs(qd[0]);
    lanes_put(&out[48], DFS1, stream);
    const lanes DFS2 = lanes_abs(qd[1]);
    lanes_put(&out[50], DFS2, stream);
    const lanes DFS3 = lanes_abs(qd[2]);
    lanes_put(&out[52], DFS3, stream);
    const lanes DFV3 = qd[2] * qd[2];
    lanes_put(&out[53], DFV3, stream);
    const lanes DFS4 = lanes_abs(qd[3]);
    lanes_put(&out[54], DFS4, stream);
    const lanes DFV4 = qd[3] * qd[3];
    lanes_put(&out[55], DFV4, stream);
    const lanes DFS5 = lanes_abs(qd[4]);
    lanes_put(&out[56], DFS5, stream);
    const lanes DFV5 = qd[4] * qd[4];
    lanes_put(&out[57], DFV5, stream);
    const lanes DFS6 = lanes_abs(qd[5]);
    lanes_put(&out[58], DFS6, stream);
    const lanes DFV6 = qd[5] * qd[5];
    lanes_put(&out[59], DFV6, stream);
    const lanes DFS7 = lanes_abs(qd[6]);
    lanes_put(&out[60], DFS7, stream);
    const lanes DFV7 = qd[6] * qd[6];
    lanes_put(&out[61], DFV7, stream);
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
    const lanes G1e2 = gz * S2;
    const lanes X1e2 = -qdd[0] * S2;
    const lanes X12 = qd[1] * W2e2 + X1e2;
    const lanes RMY2 = qd[1] * G1e2;
    lanes_put(&out[7], RMY2, stream);
    const lanes G2e2 = gz * C2;
    const lanes X2e2 = -qdd[0] * C2;
    const lanes X22 = X2e2 - qd[1] * W1e2;
    const lanes RMX2 = -qd[1] * G2e2;
    lanes_put(&out[6], RMX2, stream);
    const lanes W1e3 = qd[1] * S3 + C3 * W1e2;
    const lanes W2e3 = qd[1] * C3 - S3 * W1e2;
    const lanes G1e3 = C3 * G1e2;
    const lanes G2e3 = -S3 * G1e2;
    const lanes W33 = qd[2] - W2e2;
    const lanes V1r3 = panda_geometry_R3 * W2e3;
    const lanes V2r3 = -panda_geometry_R3 * W1e3;
    const lanes V2d4 = -panda_geometry_D4 * W2e3;
    const lanes V3d4 = -panda_geometry_D4 * W33 - V2r3;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes V1e4 = C4 * V1r3 + S4 * V2d4;
    const lanes V2e4 = C4 * V2d4 - S4 * V1r3;
    const lanes W34 = qd[3] - W2e3;
    const lanes V2d5 = -panda_geometry_D4 * W2e4 - V3d4;
    const lanes V3d5 = V2e4 - panda_geometry_D4 * W34;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes V1e5 = C5 * V1e4 + S5 * V2d5;
    const lanes V2e5 = C5 * V2d5 - S5 * V1e4;
    const lanes V1r5 = panda_geometry_R5 * W2e5 + V1e5;
    const lanes V2r5 = V2e5 - panda_geometry_R5 * W1e5;
    const lanes W35 = qd[4] + W2e4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes V1e6 = C6 * V1r5 + S6 * V3d5;
    const lanes V2e6 = C6 * V3d5 - S6 * V1r5;
    const lanes W36 = qd[5] - W2e5;
    const lanes V2d7 = -panda_geometry_D7 * W2e6 - V2r5;
    const lanes V3d7 = -panda_geometry_D7 * W36 - V2e6;
    const lanes W1e7 = C7 * W1e6 + S7 * W36;
    const lanes W2e7 = C7 * W36 - S7 * W1e6;
    const lanes V1e7 = C7 * V1e6 + S7 * V2d7;
    const lanes V2e7 = C7 * V2d7 - S7 * V1e6;
    const lanes W37 = qd[6] - W2e6;
    const lanes X1e3 = qdd[1] * S3 + C3 * X12;
    const lanes X2e3 = qdd[1] * C3 - S3 * X12;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes X33 = qdd[2] - X22;
    const lanes ZP13r3 = W1e3 * W33;
    const lanes ZA1r3 = X23 + ZP13r3;
    const lanes Z1r3 = panda_geometry_R3 * ZA1r3 - G1e3;
    const lanes ZP23r3 = W2e3 * W33;
    const lanes RZZ3 = W1e3 * ZP23r3 + W33 * X33 - W2e3 * ZP13r3;
    lanes_put(&out[12], RZZ3, stream);
    const lanes ZA2r3 = ZP23r3 - X13;
    const lanes Z2r3 = panda_geometry_R3 * ZA2r3 - G2e3;
    const lanes A2133 = X13 + ZP23r3;
    const lanes ZP11r3 = W1e3 * W1e3;
    const lanes ZP22r3 = W2e3 * W2e3;
    const lanes ZA3r3 = ZP11r3 + ZP22r3;
    const lanes Z3r3 = G2e2 - panda_geometry_R3 * ZA3r3;
    const lanes ZA2d4 = ZP13r3 - X23;
    const lanes X34 = qdd[3] - X23;
    const lanes ZP13d4 = -W1e3 * W2e3;
    const lanes RXX3 = W1e3 * X13 + W2e3 * ZP13r3 + W33 * ZP13d4;
    lanes_put(&out[8], RXX3, stream);
    const lanes ZA3d4 = ZP13d4 - X33;
    const lanes A2313 = X33 + ZP13d4;
    const lanes ZP22d4 = W33 * W33;
    const lanes ZA1d4 = ZP22r3 + ZP22d4;
    const lanes RMX3 = W33 * Z2r3 - W2e3 * Z3r3 - V1r3 * ZA1d4 - V2r3 * ZA3d4;
    lanes_put(&out[13], RMX3, stream);
    const lanes Z3d4 = panda_geometry_D4 * ZA3d4 - Z2r3;
    const lanes Z1d4 = Z1r3 - panda_geometry_D4 * ZA1d4;
    const lanes Z2d4 = panda_geometry_D4 * ZA2d4 + Z3r3;
    const lanes X1e4 = C4 * X13 + S4 * X33;
    const lanes X2e4 = C4 * X33 - S4 * X13;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    const lanes ZP12d5 = -W1e4 * W34;
    const lanes ZA2d5 = X24 + ZP12d5;
    const lanes ZP13d5 = W1e4 * W2e4;
    const lanes RXX4 = W1e4 * X14 - W2e4 * ZP12d5 - W34 * ZP13d5;
    lanes_put(&out[16], RXX4, stream);
    const lanes ZA3d5 = X34 + ZP13d5;
    const lanes A2314 = X34 - ZP13d5;
    const lanes ZP22d5 = W34 * W34;
    const lanes ZP33d5 = W2e4 * W2e4;
    const lanes ZA1d5 = ZP22d5 + ZP33d5;
    const lanes RMX4 = V2e4 * ZA3d5 + W34 * Z2e4 - V3d4 * ZA2d5 - W2e4 * Z3d4 - V1e4 * ZA1d5;
    lanes_put(&out[21], RMX4, stream);
    const lanes Z3d5 = Z2e4 - panda_geometry_D4 * ZA3d5;
    const lanes Z1d5 = panda_geometry_D4 * ZA1d5 + Z1e4;
    const lanes Z2d5 = -panda_geometry_D4 * ZA2d5 - Z3d4;
    const lanes X1e5 = C5 * X14 - S5 * X34;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X2e5 = -C5 * X34 - S5 * X14;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes Z1e5 = C5 * Z1d5 + S5 * Z2d5;
    const lanes Z2e5 = C5 * Z2d5 - S5 * Z1d5;
    const lanes X35 = qdd[4] + X24;
    const lanes A3214 = X24 - ZP12d5;
    const lanes ZP13r5 = W1e5 * W35;
    const lanes ZA1r5 = X25 + ZP13r5;
    const lanes Z1r5 = panda_geometry_R5 * ZA1r5 + Z1e5;
    const lanes ZP23r5 = W2e5 * W35;
    const lanes RZZ5 = W1e5 * ZP23r5 + W35 * X35 - W2e5 * ZP13r5;
    lanes_put(&out[28], RZZ5, stream);
    const lanes ZA2r5 = ZP23r5 - X15;
    const lanes Z2r5 = panda_geometry_R5 * ZA2r5 + Z2e5;
    const lanes A2135 = X15 + ZP23r5;
    const lanes ZP11r5 = W1e5 * W1e5;
    const lanes ZP22r5 = W2e5 * W2e5;
    const lanes ZA3r5 = ZP11r5 + ZP22r5;
    const lanes Z3r5 = Z3d5 - panda_geometry_R5 * ZA3r5;
    const lanes X1e6 = C6 * X15 + S6 * X35;
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X2e6 = C6 * X35 - S6 * X15;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes Z1e6 = C6 * Z1r5 + S6 * Z3r5;
    const lanes Z2e6 = C6 * Z3r5 - S6 * Z1r5;
    const lanes X36 = qdd[5] - X25;
    const lanes A1235 = X25 - ZP13r5;
    const lanes ZP12d7 = W1e6 * W36;
    const lanes ZA2d7 = ZP12d7 - X26;
    const lanes ZP13d7 = -W1e6 * W2e6;
    const lanes RXX6 = W1e6 * X16 + W2e6 * ZP12d7 + W36 * ZP13d7;
    lanes_put(&out[32], RXX6, stream);
    const lanes ZA3d7 = ZP13d7 - X36;
    const lanes A2316 = X36 + ZP13d7;
    const lanes ZP22d7 = W36 * W36;
    const lanes ZP33d7 = W2e6 * W2e6;
    const lanes ZA1d7 = ZP22d7 + ZP33d7;
    const lanes RMX6 = W2e6 * Z2r5 + W36 * Z2e6 - V2r5 * ZA2d7 - V1e6 * ZA1d7 - V2e6 * ZA3d7;
    lanes_put(&out[37], RMX6, stream);
    const lanes Z3d7 = panda_geometry_D7 * ZA3d7 - Z2e6;
    const lanes Z1d7 = Z1e6 - panda_geometry_D7 * ZA1d7;
    const lanes Z2d7 = panda_geometry_D7 * ZA2d7 - Z2r5;
    const lanes X1e7 = C7 * X16 + S7 * X36;
    const lanes X17 = qd[6] * W2e7 + X1e7;
    const lanes X2e7 = C7 * X36 - S7 * X16;
    const lanes X27 = X2e7 - qd[6] * W1e7;
    const lanes Z1e7 = C7 * Z1d7 + S7 * Z2d7;
    const lanes Z2e7 = C7 * Z2d7 - S7 * Z1d7;
    const lanes X37 = qdd[6] - X26;
    const lanes A3216 = X26 + ZP12d7;
    const lanes P112 = W1e2 * W1e2;
    const lanes P122 = W1e2 * W2e2;
    const lanes P132 = qd[1] * W1e2;
    const lanes RXX2 = W1e2 * X12 + W2e2 * P132 - qd[1] * P122;
    lanes_put(&out[1], RXX2, stream);
    const lanes P222 = W2e2 * W2e2;
    const lanes P232 = qd[1] * W2e2;
    const lanes RZZ2 = qd[1] * qdd[1] + W1e2 * P232 - W2e2 * P132;
    lanes_put(&out[5], RZZ2, stream);
    const lanes P332 = qd[1] * qd[1];
    lanes_put(&out[51], P332, stream);
    const lanes A1232 = X22 - P132;
    const lanes A3212 = X22 + P132;
    const lanes A2132 = X12 + P232;
    const lanes A3122 = X12 - P232;
    const lanes B32 = P112 - P222;
    const lanes RXY2 = qd[1] * B32 + W1e2 * A1232 + W2e2 * A2132;
    lanes_put(&out[2], RXY2, stream);
    const lanes B22 = P332 - P112;
    const lanes B12 = P222 - P332;
    const lanes A1322 = qdd[1] + P122;
    const lanes RXZ2 = qd[1] * A3122 + W1e2 * A1322 + W2e2 * B22;
    lanes_put(&out[3], RXZ2, stream);
    const lanes A2312 = qdd[1] - P122;
    const lanes RYZ2 = qd[1] * A3212 + W1e2 * B12 + W2e2 * A2312;
    lanes_put(&out[4], RYZ2, stream);
    const lanes B33 = ZP11r3 - ZP22r3;
    const lanes RXY3 = W2e3 * A2133 + W33 * B33 - W1e3 * ZA2d4;
    lanes_put(&out[9], RXY3, stream);
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes RYZ3 = W1e3 * B13 + W2e3 * A2313 + W33 * ZA1r3;
    lanes_put(&out[11], RYZ3, stream);
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes RXZ3 = W2e3 * B23 - W1e3 * ZA3d4 - W33 * ZA2r3;
    lanes_put(&out[10], RXZ3, stream);
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes RMY3 = W1e3 * Z3r3 - W33 * Z1r3 - V1r3 * A2313 - V2r3 * Q23;
    lanes_put(&out[14], RMY3, stream);
    const lanes P114 = W1e4 * W1e4;
    const lanes P234 = W2e4 * W34;
    const lanes RZZ4 = W1e4 * P234 + W2e4 * ZP12d5 + W34 * X34;
    lanes_put(&out[20], RZZ4, stream);
    const lanes A2134 = X14 + P234;
    const lanes A3124 = X14 - P234;
    const lanes B34 = P114 - ZP33d5;
    const lanes RXY4 = W1e4 * ZA2d5 + W2e4 * A2134 + W34 * B34;
    lanes_put(&out[17], RXY4, stream);
    const lanes B14 = ZP33d5 - ZP22d5;
    const lanes RYZ4 = W1e4 * B14 + W2e4 * A2314 + W34 * A3214;
    lanes_put(&out[19], RYZ4, stream);
    const lanes B24 = ZP22d5 - P114;
    const lanes RXZ4 = W1e4 * ZA3d5 + W2e4 * B24 + W34 * A3124;
    lanes_put(&out[18], RXZ4, stream);
    const lanes Q24 = ZP22d5 + P114;
    const lanes RMY4 = V3d4 * A2134 + W1e4 * Z3d4 - V1e4 * A2314 - V2e4 * Q24 - W34 * Z1e4;
    lanes_put(&out[22], RMY4, stream);
    const lanes P125 = W1e5 * W2e5;
    const lanes RXX5 = W1e5 * X15 + W2e5 * ZP13r5 - W35 * P125;
    lanes_put(&out[24], RXX5, stream);
    const lanes P335 = W35 * W35;
    const lanes B35 = ZP11r5 - ZP22r5;
    const lanes RXY5 = W1e5 * A1235 + W2e5 * A2135 + W35 * B35;
    lanes_put(&out[25], RXY5, stream);
    const lanes A1325 = X35 + P125;
    const lanes A2315 = X35 - P125;
    const lanes B25 = P335 - ZP11r5;
    const lanes RXZ5 = W1e5 * A1325 + W2e5 * B25 - W35 * ZA2r5;
    lanes_put(&out[26], RXZ5, stream);
    const lanes Q25 = ZP11r5 + P335;
    const lanes RMY5 = V3d5 * A2135 + W1e5 * Z3r5 - W35 * Z1r5 - V1r5 * A2315 - V2r5 * Q25;
    lanes_put(&out[30], RMY5, stream);
    const lanes B15 = ZP22r5 - P335;
    const lanes RYZ5 = W1e5 * B15 + W2e5 * A2315 + W35 * ZA1r5;
    lanes_put(&out[27], RYZ5, stream);
    const lanes Q15 = ZP22r5 + P335;
    const lanes RMX5 = W35 * Z2r5 + V2r5 * A1325 - V3d5 * A1235 - W2e5 * Z3r5 - V1r5 * Q15;
    lanes_put(&out[29], RMX5, stream);
    const lanes P116 = W1e6 * W1e6;
    const lanes P236 = W2e6 * W36;
    const lanes RZZ6 = W1e6 * P236 + W36 * X36 - W2e6 * ZP12d7;
    lanes_put(&out[36], RZZ6, stream);
    const lanes A2136 = X16 + P236;
    const lanes A3126 = X16 - P236;
    const lanes B36 = P116 - ZP33d7;
    const lanes RXY6 = W2e6 * A2136 + W36 * B36 - W1e6 * ZA2d7;
    lanes_put(&out[33], RXY6, stream);
    const lanes B16 = ZP33d7 - ZP22d7;
    const lanes RYZ6 = W1e6 * B16 + W2e6 * A2316 + W36 * A3216;
    lanes_put(&out[35], RYZ6, stream);
    const lanes B26 = ZP22d7 - P116;
    const lanes RXZ6 = W2e6 * B26 + W36 * A3126 - W1e6 * ZA3d7;
    lanes_put(&out[34], RXZ6, stream);
    const lanes Q26 = ZP22d7 + P116;
    const lanes RMY6 = -V2r5 * A2136 - W1e6 * Z2r5 - V1e6 * A2316 - V2e6 * Q26 - W36 * Z1e6;
    lanes_put(&out[38], RMY6, stream);
    const lanes P117 = W1e7 * W1e7;
    const lanes P127 = W1e7 * W2e7;
    const lanes P137 = W1e7 * W37;
    const lanes RXX7 = W1e7 * X17 + W2e7 * P137 - W37 * P127;
    lanes_put(&out[40], RXX7, stream);
    const lanes P227 = W2e7 * W2e7;
    const lanes P237 = W2e7 * W37;
    const lanes RZZ7 = W1e7 * P237 + W37 * X37 - W2e7 * P137;
    lanes_put(&out[44], RZZ7, stream);
    const lanes P337 = W37 * W37;
    const lanes A1237 = X27 - P137;
    const lanes A3217 = X27 + P137;
    const lanes A2137 = X17 + P237;
    const lanes A3127 = X17 - P237;
    const lanes B37 = P117 - P227;
    const lanes RXY7 = W1e7 * A1237 + W2e7 * A2137 + W37 * B37;
    lanes_put(&out[41], RXY7, stream);
    const lanes A1327 = X37 + P127;
    const lanes A2317 = X37 - P127;
    const lanes B27 = P337 - P117;
    const lanes RXZ7 = W1e7 * A1327 + W2e7 * B27 + W37 * A3127;
    lanes_put(&out[42], RXZ7, stream);
    const lanes Q27 = P117 + P337;
    const lanes RMY7 = V3d7 * A2137 + W1e7 * Z3d7 - V1e7 * A2317 - V2e7 * Q27 - W37 * Z1e7;
    lanes_put(&out[46], RMY7, stream);
    const lanes B17 = P227 - P337;
    const lanes RYZ7 = W1e7 * B17 + W2e7 * A2317 + W37 * A3217;
    lanes_put(&out[43], RYZ7, stream);
    const lanes Q17 = P227 + P337;
    const lanes RMX7 = V2e7 * A1327 + W37 * Z2e7 - V3d7 * A1237 - W2e7 * Z3d7 - V1e7 * Q17;
    lanes_put(&out[45], RMX7, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, apart *out)
{
    return panel(q, qd, qdd, out, 0);
}

int panda_power_regressor_rows(int stream, size_t N, const size_t *strides,
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
    lanes lanes_out[BLOCKS(62u)];
    double scratch[62u * panda_WIDTH] __attribute__((aligned(64)));
    memset(lanes_out, 0, sizeof lanes_out);
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        const size_t count = (N - k < panda_WIDTH) ? (N - k) : panda_WIDTH;
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
        lanes_store(lanes_out, 62u, count, stream, scratch, &out[k * 62u]);
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
    for (size_t k = 0; k < N; k += panda_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_qdd != 0u) {
            lanes_load(qdd, 7u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        apart *lanes_out = (apart *)&out[k * 62u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_out);
    }
    return status;
}

int panda_power_regressor_panels(int stream, size_t N, const size_t *strides,
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

int panda_power_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        panda_power_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &out[k * 62u]);
    }
    return status;
}

int panda_power_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    return panda_power_regressor_rows(stream, N, strides, q, qd, qdd, out);
}

#endif

size_t panda_power_regressor_width(void)
{
    return panda_WIDTH;
}

void panda_power_regressor_batch(size_t N, const double *q, const double *qd, const double *qdd, double *out)
{
    (void)panda_power_regressor_rows(0, N, NULL, q, qd, qdd, out);
}
