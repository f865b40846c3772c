/* twin: momentum_regressor of as many samples at once as a vector register holds. */
#include "twin_panels.h"
#include "twin_lanes.h"

#if twin_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, apart *p_out, apart *dl_out, const int stream)
{
    (void)stream;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    const double gz = 9.81;
    lanes_put(&p_out[0], qd[0], stream);
    lanes_put(&p_out[49], qd[1], stream);
    lanes_put(&p_out[103], qd[2], stream);
    lanes_put(&p_out[155], qd[3], stream);
    lanes_put(&p_out[204], qd[4], stream);
    lanes_put(&p_out[207], -qd[5], stream);
    lanes_put(&p_out[251], -qd[4], stream);
    lanes_put(&p_out[254], qd[5], stream);
    lanes_put(&p_out[255], qd[5], stream);
    lanes_put(&p_out[307], qd[6], stream);
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
    const lanes QYZ2_1 = qd[1] * C2;
    lanes_put(&p_out[4], QYZ2_1, stream);
    const lanes S2 = q_1.s;
    const lanes QXZ2_1 = qd[1] * S2;
    lanes_put(&p_out[3], QXZ2_1, stream);
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes QYZ5_1 = qd[4] * C5;
    lanes_put(&p_out[27], QYZ5_1, stream);
    const lanes S5 = q_4.s;
    const lanes QXZ5_1 = qd[4] * S5;
    lanes_put(&p_out[26], QXZ5_1, stream);
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
    const lanes V3d2 = -qd[0] * d2;
    const lanes W1e2 = qd[0] * S2;
    lanes_put(&p_out[47], W1e2, stream);
    const lanes ZP13d3 = qd[1] * W1e2;
    lanes_put(&dl_out[48], -ZP13d3, stream);
    const lanes QXX2_1 = S2 * W1e2;
    lanes_put(&p_out[1], QXX2_1, stream);
    const lanes QMY2_1 = S2 * V3d2 - d2 * W1e2;
    lanes_put(&p_out[7], QMY2_1, stream);
    const lanes W2e2 = qd[0] * C2;
    lanes_put(&p_out[48], W2e2, stream);
    const lanes ZP12d3 = W1e2 * W2e2;
    lanes_put(&dl_out[45], ZP12d3, stream);
    const lanes QXY2_1 = C2 * W1e2 + S2 * W2e2;
    lanes_put(&p_out[2], QXY2_1, stream);
    const lanes G1e2 = -gz * S2;
    const lanes SXY2_2 = W2e2 * W2e2 - W1e2 * W1e2;
    lanes_put(&dl_out[46], SXY2_2, stream);
    const lanes SXZ2_2 = qd[1] * W2e2;
    lanes_put(&dl_out[47], SXZ2_2, stream);
    const lanes QMX2_1 = d2 * W2e2 - C2 * V3d2;
    lanes_put(&p_out[6], QMX2_1, stream);
    const lanes G2e2 = -gz * C2;
    const lanes SMX2_2 = V3d2 * W1e2 + G2e2;
    lanes_put(&dl_out[50], SMX2_2, stream);
    const lanes SMY2_2 = V3d2 * W2e2 - G1e2;
    lanes_put(&dl_out[51], SMY2_2, stream);
    const lanes V2d3 = qd[1] * d3;
    const lanes V3d3 = V3d2 - d3 * W2e2;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    lanes_put(&p_out[54], W1e3, stream);
    lanes_put(&p_out[98], W1e3, stream);
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    lanes_put(&p_out[55], W2e3, stream);
    lanes_put(&p_out[99], W2e3, stream);
    const lanes J2_3d3 = d3 * W1e2;
    const lanes QXX3_1 = E1_1e3 * W1e3;
    lanes_put(&p_out[8], QXX3_1, stream);
    const lanes SXX3_2 = W1e3 * W2e3;
    lanes_put(&dl_out[52], SXX3_2, stream);
    lanes_put(&dl_out[96], SXX3_2, stream);
    const lanes QXY3_1 = E1_1e3 * W2e3 + E1_2e3 * W1e3;
    lanes_put(&p_out[9], QXY3_1, stream);
    const lanes SXY3_2 = W2e3 * W2e3 - W1e3 * W1e3;
    lanes_put(&dl_out[53], SXY3_2, stream);
    lanes_put(&dl_out[97], SXY3_2, stream);
    const lanes QMX3_1 = -L1_3d3 * W2e3 - E1_2e3 * V3d3;
    lanes_put(&p_out[13], QMX3_1, stream);
    const lanes QMY3_1 = L1_3d3 * W1e3 + E1_1e3 * V3d3;
    lanes_put(&p_out[14], QMY3_1, stream);
    const lanes V1e3 = S3 * V2d3;
    lanes_put(&p_out[102], -V1e3, stream);
    const lanes V2e3 = C3 * V2d3;
    lanes_put(&p_out[101], V2e3, stream);
    const lanes G1e3 = C3 * G1e2 + S3 * G2e2;
    const lanes G2e3 = C3 * G2e2 - S3 * G1e2;
    const lanes SMX3_2 = V3d3 * W1e3 + G2e3 - W2e3 * J2_3d3;
    lanes_put(&dl_out[57], SMX3_2, stream);
    const lanes SMY3_2 = V3d3 * W2e3 + W1e3 * J2_3d3 - G1e3;
    lanes_put(&dl_out[58], SMY3_2, stream);
    const lanes W33 = qd[1] + qd[2];
    lanes_put(&p_out[56], W33, stream);
    lanes_put(&p_out[100], W33, stream);
    const lanes QXZ3_1 = E1_1e3 * W33;
    lanes_put(&p_out[10], QXZ3_1, stream);
    const lanes SXZ3_2 = W2e3 * W33;
    lanes_put(&dl_out[54], SXZ3_2, stream);
    lanes_put(&dl_out[98], SXZ3_2, stream);
    const lanes QYZ3_1 = E1_2e3 * W33;
    lanes_put(&p_out[11], QYZ3_1, stream);
    const lanes SYZ3_2 = -W1e3 * W33;
    lanes_put(&dl_out[55], SYZ3_2, stream);
    lanes_put(&dl_out[99], SYZ3_2, stream);
    const lanes QMX3_2 = L2_2e3 * W33 + V2e3;
    lanes_put(&p_out[57], QMX3_2, stream);
    const lanes SMX3_3 = V3d3 * W1e3 + G2e3 - V1e3 * W33;
    lanes_put(&dl_out[101], SMX3_3, stream);
    const lanes QMY3_2 = -L2_1e3 * W33 - V1e3;
    lanes_put(&p_out[58], QMY3_2, stream);
    const lanes SMY3_3 = V3d3 * W2e3 - V2e3 * W33 - G1e3;
    lanes_put(&dl_out[102], SMY3_3, stream);
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    lanes_put(&p_out[150], W1e4, stream);
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    lanes_put(&p_out[151], W2e4, stream);
    const lanes QXX4_1 = E1_1e4 * W1e4;
    lanes_put(&p_out[16], QXX4_1, stream);
    const lanes QXX4_2e = S4 * W1e4;
    lanes_put(&p_out[60], QXX4_2e, stream);
    lanes_put(&p_out[104], QXX4_2e, stream);
    const lanes SXX4_4 = W1e4 * W2e4;
    lanes_put(&dl_out[148], SXX4_4, stream);
    const lanes QXY4_1 = E1_1e4 * W2e4 + E1_2e4 * W1e4;
    lanes_put(&p_out[17], QXY4_1, stream);
    const lanes QXY4_2e = C4 * W1e4 + S4 * W2e4;
    lanes_put(&p_out[61], QXY4_2e, stream);
    lanes_put(&p_out[105], QXY4_2e, stream);
    const lanes SXY4_4 = W2e4 * W2e4 - W1e4 * W1e4;
    lanes_put(&dl_out[149], SXY4_4, stream);
    const lanes V1e4 = C4 * V1e3 + S4 * V3d3;
    const lanes V2e4 = C4 * V3d3 - S4 * V1e3;
    const lanes V1r4 = r4 * W2e4 + V1e4;
    lanes_put(&p_out[154], -V1r4, stream);
    const lanes V2r4 = V2e4 - r4 * W1e4;
    lanes_put(&p_out[153], V2r4, stream);
    const lanes G1e4 = C4 * G1e3;
    const lanes G2e4 = -S4 * G1e3;
    const lanes SMX4_1 = E1_2e4 * G2e3 - E1_2e3 * G2e4;
    lanes_put(&dl_out[21], SMX4_1, stream);
    const lanes SMY4_1 = E1_2e3 * G1e4 - E1_1e4 * G2e3;
    lanes_put(&dl_out[22], SMY4_1, stream);
    const lanes W34 = qd[3] - W2e3;
    lanes_put(&p_out[152], W34, stream);
    const lanes ZP13r4 = W1e4 * W34;
    lanes_put(&dl_out[151], -ZP13r4, stream);
    const lanes ZP23r4 = W2e4 * W34;
    lanes_put(&dl_out[150], ZP23r4, stream);
    const lanes QXZ4_1 = E1_1e4 * W34 - E1_2e3 * W1e4;
    lanes_put(&p_out[18], QXZ4_1, stream);
    const lanes QXZ4_2e = S4 * W34;
    lanes_put(&p_out[62], QXZ4_2e, stream);
    lanes_put(&p_out[106], QXZ4_2e, stream);
    const lanes QYZ4_1 = E1_2e4 * W34 - E1_2e3 * W2e4;
    lanes_put(&p_out[19], QYZ4_1, stream);
    const lanes QYZ4_2e = C4 * W34;
    lanes_put(&p_out[63], QYZ4_2e, stream);
    lanes_put(&p_out[107], QYZ4_2e, stream);
    const lanes QZZ4_1 = -E1_2e3 * W34;
    lanes_put(&p_out[20], QZZ4_1, stream);
    const lanes SZZ4_2 = W1e3 * W34;
    lanes_put(&dl_out[64], SZZ4_2, stream);
    lanes_put(&dl_out[108], SZZ4_2, stream);
    const lanes QMX4_1 = E1_2e4 * V2e3 + L1_2r4 * W34 - E1_2e3 * V2r4;
    lanes_put(&p_out[21], QMX4_1, stream);
    const lanes SMX4_4 = G2e4 - V2e3 * W1e4 - W34 * V1r4;
    lanes_put(&dl_out[153], SMX4_4, stream);
    const lanes QMY4_1 = E1_2e3 * V1r4 - E1_1e4 * V2e3 - L1_1r4 * W34;
    lanes_put(&p_out[22], QMY4_1, stream);
    const lanes SMY4_4 = -V2e3 * W2e4 - G1e4 - W34 * V2r4;
    lanes_put(&dl_out[154], SMY4_4, stream);
    const lanes W1e5 = qd[0] * S5;
    lanes_put(&p_out[202], W1e5, stream);
    lanes_put(&p_out[252], W1e5, stream);
    const lanes QXX5_1 = S5 * W1e5;
    lanes_put(&p_out[24], QXX5_1, stream);
    const lanes SYZ5_5 = -qd[4] * W1e5;
    lanes_put(&dl_out[203], SYZ5_5, stream);
    const lanes QMY5_1 = S5 * V3d2 - d2 * W1e5;
    lanes_put(&p_out[30], QMY5_1, stream);
    const lanes SMZ6_6 = qd[4] * qd[4] + W1e5 * W1e5;
    lanes_put(&dl_out[253], SMZ6_6, stream);
    const lanes W2e5 = qd[0] * C5;
    lanes_put(&p_out[203], W2e5, stream);
    const lanes ZP13r6 = -W1e5 * W2e5;
    lanes_put(&dl_out[200], -ZP13r6, stream);
    lanes_put(&dl_out[251], -ZP13r6, stream);
    const lanes ZP23r6 = -qd[4] * W2e5;
    lanes_put(&dl_out[202], -ZP23r6, stream);
    lanes_put(&dl_out[252], -ZP23r6, stream);
    const lanes QXY5_1 = C5 * W1e5 + S5 * W2e5;
    lanes_put(&p_out[25], QXY5_1, stream);
    const lanes SXY5_5 = W2e5 * W2e5 - W1e5 * W1e5;
    lanes_put(&dl_out[201], SXY5_5, stream);
    const lanes QMX5_1 = d2 * W2e5 - C5 * V3d2;
    lanes_put(&p_out[29], QMX5_1, stream);
    const lanes G1e5 = -gz * S5;
    const lanes SMY5_5 = V3d2 * W2e5 - G1e5;
    lanes_put(&dl_out[206], SMY5_5, stream);
    const lanes G2e5 = -gz * C5;
    const lanes SMX5_5 = V3d2 * W1e5 + G2e5;
    lanes_put(&dl_out[205], SMX5_5, stream);
    const lanes V2r6 = V3d2 - R6 * W1e5;
    const lanes SMZ5_1 = C5 * G1e5 - S5 * G2e5;
    lanes_put(&dl_out[32], SMZ5_1, stream);
    const lanes QMX6_1 = -C5 * V2r6 - L1_2r6 * W2e5;
    lanes_put(&p_out[31], QMX6_1, stream);
    const lanes QMZ6_1 = -S5 * V2r6 - L1_2r6 * W1e5;
    lanes_put(&p_out[33], QMZ6_1, stream);
    const lanes QM6_1 = L1_2r6 * V2r6;
    lanes_put(&p_out[34], QM6_1, stream);
    const lanes V1r6 = qd[4] * R6;
    const lanes QMY6_1 = qd[5] * S5 + C5 * V1r6;
    lanes_put(&p_out[32], QMY6_1, stream);
    const lanes SMY6_5 = qd[5] * W2e5 - W1e5 * V1r6;
    lanes_put(&dl_out[208], SMY6_5, stream);
    const lanes QMZ6_5 = qd[4] * R6 + V1r6;
    lanes_put(&p_out[209], QMZ6_5, stream);
    const lanes QM6_5 = R6 * V1r6;
    lanes_put(&p_out[210], QM6_5, stream);
    const lanes SM6_6 = qd[4] * V1r6 - W1e5 * V2r6 - G2e5;
    lanes_put(&dl_out[254], SM6_6, stream);
    const lanes W1e7 = C7 * W1e5 + S7 * W2e5;
    lanes_put(&p_out[214], W1e7, stream);
    lanes_put(&p_out[302], W1e7, stream);
    const lanes QXX7_1 = E1_1e7 * W1e7;
    lanes_put(&p_out[36], QXX7_1, stream);
    const lanes QMY7_1 = L1_2r6 * W1e7 + E1_1e7 * V2r6;
    lanes_put(&p_out[42], QMY7_1, stream);
    const lanes W2e7 = C7 * W2e5 - S7 * W1e5;
    lanes_put(&p_out[215], W2e7, stream);
    lanes_put(&p_out[303], W2e7, stream);
    const lanes SXX7_5 = W1e7 * W2e7;
    lanes_put(&dl_out[212], SXX7_5, stream);
    lanes_put(&dl_out[300], SXX7_5, stream);
    const lanes QXY7_1 = E1_1e7 * W2e7 + E1_2e7 * W1e7;
    lanes_put(&p_out[37], QXY7_1, stream);
    const lanes SXY7_5 = W2e7 * W2e7 - W1e7 * W1e7;
    lanes_put(&dl_out[213], SXY7_5, stream);
    lanes_put(&dl_out[301], SXY7_5, stream);
    const lanes QMX7_1 = -L1_2r6 * W2e7 - E1_2e7 * V2r6;
    lanes_put(&p_out[41], QMX7_1, stream);
    const lanes V1e7 = C7 * V1r6 - qd[5] * S7;
    lanes_put(&p_out[306], -V1e7, stream);
    const lanes V2e7 = -qd[5] * C7 - S7 * V1r6;
    lanes_put(&p_out[305], V2e7, stream);
    const lanes G1e7 = C7 * G1e5 + S7 * G2e5;
    const lanes G2e7 = C7 * G2e5 - S7 * G1e5;
    const lanes W37 = qd[4] + qd[6];
    lanes_put(&p_out[216], W37, stream);
    lanes_put(&p_out[304], W37, stream);
    const lanes QXZ7_1 = E1_1e7 * W37;
    lanes_put(&p_out[38], QXZ7_1, stream);
    const lanes SXZ7_5 = W2e7 * W37;
    lanes_put(&dl_out[214], SXZ7_5, stream);
    lanes_put(&dl_out[302], SXZ7_5, stream);
    const lanes QYZ7_1 = E1_2e7 * W37;
    lanes_put(&p_out[39], QYZ7_1, stream);
    const lanes SYZ7_5 = -W1e7 * W37;
    lanes_put(&dl_out[215], SYZ7_5, stream);
    lanes_put(&dl_out[303], SYZ7_5, stream);
    const lanes QMX7_5 = L5_2e7 * W37 + V2e7;
    lanes_put(&p_out[217], QMX7_5, stream);
    const lanes QMX7_6 = -C7 * W37;
    lanes_put(&p_out[261], QMX7_6, stream);
    const lanes J6_1e7 = qd[4] * C7;
    const lanes SMX7_7 = V2r6 * W1e7 + G2e7 - V1e7 * W37;
    lanes_put(&dl_out[305], SMX7_7, stream);
    const lanes QMY7_5 = -L5_1e7 * W37 - V1e7;
    lanes_put(&p_out[218], QMY7_5, stream);
    const lanes QMY7_6 = S7 * W37;
    lanes_put(&p_out[262], QMY7_6, stream);
    const lanes J6_2e7 = -qd[4] * S7;
    const lanes SMX7_6 = W1e5 * W2e7 + W37 * J6_2e7;
    lanes_put(&dl_out[261], SMX7_6, stream);
    const lanes SMY7_6 = -W1e5 * W1e7 - W37 * J6_1e7;
    lanes_put(&dl_out[262], SMY7_6, stream);
    const lanes SMY7_7 = V2r6 * W2e7 - V2e7 * W37 - G1e7;
    lanes_put(&dl_out[306], SMY7_7, stream);
    const lanes I2_1e4 = C4 * W2e3;
    const lanes I2_2e4 = -S4 * W2e3;
    const lanes SXX4_2 = W1e4 * I2_1e4;
    lanes_put(&dl_out[60], SXX4_2, stream);
    lanes_put(&dl_out[104], SXX4_2, stream);
    const lanes SXY4_2 = W1e4 * I2_2e4 + W2e4 * I2_1e4;
    lanes_put(&dl_out[61], SXY4_2, stream);
    lanes_put(&dl_out[105], SXY4_2, stream);
    const lanes SXZ4_2 = W1e3 * W1e4 + W34 * I2_1e4;
    lanes_put(&dl_out[62], SXZ4_2, stream);
    lanes_put(&dl_out[106], SXZ4_2, stream);
    const lanes SYZ4_2 = W1e3 * W2e4 + W34 * I2_2e4;
    lanes_put(&dl_out[63], SYZ4_2, stream);
    lanes_put(&dl_out[107], SYZ4_2, stream);
    const lanes J2_1e4 = S4 * J2_3d3;
    const lanes J2_2e4 = C4 * J2_3d3;
    const lanes J2_1r4 = r4 * I2_2e4 + J2_1e4;
    const lanes J2_2r4 = J2_2e4 - r4 * I2_1e4;
    const lanes SMX4_2 = C4 * G2e3 + W1e3 * V2r4 + V2e3 * I2_2e4 + W34 * J2_2r4;
    lanes_put(&dl_out[65], SMX4_2, stream);
    const lanes SMY4_2 = -S4 * G2e3 - W1e3 * V1r4 - V2e3 * I2_1e4 - W34 * J2_1r4;
    lanes_put(&dl_out[66], SMY4_2, stream);
    const lanes J3_1e4 = C4 * V2e3;
    const lanes QMX4_2 = L2_2e3 * W2e4 + L2_2r4 * W34 + J3_1e4;
    lanes_put(&p_out[65], QMX4_2, stream);
    const lanes QMX4_3 = L3_2r4 * W34 + J3_1e4;
    lanes_put(&p_out[109], QMX4_3, stream);
    const lanes J3_1r4 = r4 * I2_2e4 + J3_1e4;
    const lanes SMY4_3 = V1e3 * W1e4 - S4 * G2e3 - W1e3 * V1r4 - V2e3 * I2_1e4 - W34 * J3_1r4;
    lanes_put(&dl_out[110], SMY4_3, stream);
    const lanes J3_2e4 = -S4 * V2e3;
    const lanes J3_2r4 = J3_2e4 - r4 * I2_1e4;
    const lanes SMX4_3 = C4 * G2e3 + W1e3 * V2r4 + V2e3 * I2_2e4 + W34 * J3_2r4 - V1e3 * W2e4;
    lanes_put(&dl_out[109], SMX4_3, stream);
    const lanes QMY4_2 = J3_2e4 - L2_2e3 * W1e4 - L2_1r4 * W34;
    lanes_put(&p_out[66], QMY4_2, stream);
    const lanes QMY4_3 = J3_2e4 - L3_1r4 * W34;
    lanes_put(&p_out[110], QMY4_3, stream);
    const lanes J5_2r6 = -R6 * W2e5;
    lanes_put(&p_out[208], -J5_2r6, stream);
    const lanes SMX6_5 = W1e5 * V2r6 + G2e5 - W2e5 * J5_2r6;
    lanes_put(&dl_out[207], SMX6_5, stream);
    const lanes SMZ6_5 = G1e5 - W1e5 * J5_2r6 - W2e5 * V2r6;
    lanes_put(&dl_out[209], SMZ6_5, stream);
    const lanes SM6_5 = R6 * G1e5 + V2r6 * J5_2r6;
    lanes_put(&dl_out[210], SM6_5, stream);
    const lanes SMX7_5 = V2r6 * W1e7 + G2e7 - W2e7 * J5_2r6;
    lanes_put(&dl_out[217], SMX7_5, stream);
    const lanes SMY7_5 = V2r6 * W2e7 + W1e7 * J5_2r6 - G1e7;
    lanes_put(&dl_out[218], SMY7_5, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, apart *p_out, apart *dl_out)
{
    return panel(q, qd, p_out, dl_out, 0);
}

int twin_momentum_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    lanes lanes_p_out[BLOCKS(308u)];
    lanes lanes_dl_out[BLOCKS(308u)];
    double scratch[308u * twin_WIDTH] __attribute__((aligned(64)));
    memset(lanes_p_out, 0, sizeof lanes_p_out);
    memset(lanes_dl_out, 0, sizeof lanes_dl_out);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        const size_t count = (N - k < twin_WIDTH) ? (N - k) : twin_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        status |= plain(lanes_q, lanes_qd, (apart *)lanes_p_out, (apart *)lanes_dl_out);
        lanes_store(lanes_p_out, 308u, count, stream, scratch, &p_out[k * 308u]);
        lanes_store(lanes_dl_out, 308u, count, stream, scratch, &dl_out[k * 308u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    double padded_q[REACH(7u)];
    lanes lanes_q[BLOCKS(7u)];
    double padded_qd[REACH(7u)];
    lanes lanes_qd[BLOCKS(7u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 7u, lanes_q);
    lanes_shared(qd, 7u, lanes_qd);
    for (size_t k = 0; k < N; k += twin_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 7u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 7u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        apart *lanes_p_out = (apart *)&p_out[k * 308u];
        apart *lanes_dl_out = (apart *)&dl_out[k * 308u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_p_out, lanes_dl_out, 1) : plain(lanes_q, lanes_qd, lanes_p_out, lanes_dl_out);
    }
    return status;
}

int twin_momentum_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    if (!(streamed(stream, p_out) && streamed(stream, dl_out))) {
        return panels(0, N, strides, q, qd, p_out, dl_out);
    }
    const int status = panels(1, N, strides, q, qd, p_out, dl_out);
    stream_end();
    return status;
}

#else

int twin_momentum_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        twin_momentum_regressor(&q[k * stride_q], &qd[k * stride_qd], &p_out[k * 308u], &dl_out[k * 308u]);
    }
    return status;
}

int twin_momentum_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    return twin_momentum_regressor_rows(stream, N, strides, q, qd, p_out, dl_out);
}

#endif

size_t twin_momentum_regressor_width(void)
{
    return twin_WIDTH;
}

void twin_momentum_regressor_batch(size_t N, const double *q, const double *qd, double *p_out, double *dl_out)
{
    (void)twin_momentum_regressor_rows(0, N, NULL, q, qd, p_out, dl_out);
}
