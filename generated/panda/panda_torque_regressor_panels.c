/* panda: torque_regressor of as many samples at once as a vector register holds. */
#include "panda_panels.h"
#include "panda_lanes.h"

#if panda_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *qdd, apart *out, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    lanes_put(&out[0], qdd[0], stream);
    lanes_put(&out[49], qd[0], stream);
    lanes_put(&out[67], qdd[1], stream);
    lanes_put(&out[113], qd[1], stream);
    lanes_put(&out[139], qdd[2], stream);
    lanes_put(&out[177], qd[2], stream);
    lanes_put(&out[209], qdd[3], stream);
    lanes_put(&out[241], qd[3], stream);
    lanes_put(&out[279], qdd[4], stream);
    lanes_put(&out[305], qd[4], stream);
    lanes_put(&out[349], qdd[5], stream);
    lanes_put(&out[369], qd[5], stream);
    lanes_put(&out[419], qdd[6], stream);
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
    const lanes X1e2 = -qdd[0] * S2;
    const lanes X12 = qd[1] * W2e2 + X1e2;
    const lanes X2e2 = -qdd[0] * C2;
    const lanes X22 = X2e2 - qd[1] * W1e2;
    const lanes X1e3 = qdd[1] * S3 + C3 * X12;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X2e3 = qdd[1] * C3 - S3 * X12;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes X33 = qdd[2] - X22;
    lanes_put(&out[136], X33, stream);
    const lanes ZP13r3 = W1e3 * W33;
    const lanes TXX3_2 = C3 * ZP13r3 + S3 * X13;
    lanes_put(&out[70], TXX3_2, stream);
    const lanes ZA1r3 = X23 + ZP13r3;
    lanes_put(&out[135], ZA1r3, stream);
    const lanes Z1r3 = panda_geometry_R3 * ZA1r3 - G1e3;
    lanes_put(&out[138], -Z1r3, stream);
    const lanes ZP23r3 = W2e3 * W33;
    const lanes ZP22d4 = W33 * W33;
    const lanes TZZ3_1 = C2 * X33 + E1_1e3 * ZP23r3 - E1_2e3 * ZP13r3;
    lanes_put(&out[12], TZZ3_1, stream);
    const lanes TZZ3_2 = S3 * ZP23r3 - C3 * ZP13r3;
    lanes_put(&out[74], TZZ3_2, stream);
    const lanes ZA2r3 = ZP23r3 - X13;
    lanes_put(&out[134], -ZA2r3, stream);
    const lanes Z2r3 = panda_geometry_R3 * ZA2r3 - G2e3;
    lanes_put(&out[137], Z2r3, stream);
    const lanes A2133 = X13 + ZP23r3;
    const lanes ZP11r3 = W1e3 * W1e3;
    const lanes ZP13d4 = -W1e3 * W2e3;
    lanes_put(&out[132], ZP13d4, stream);
    const lanes ZP22r3 = W2e3 * W2e3;
    const lanes TXX3_1 = C2 * ZP13d4 + E1_1e3 * X13 + E1_2e3 * ZP13r3;
    lanes_put(&out[8], TXX3_1, stream);
    const lanes ZA2d4 = ZP13r3 - X23;
    const lanes X34 = qdd[3] - X23;
    lanes_put(&out[206], X34, stream);
    const lanes TXY3_2 = C3 * A2133 - S3 * ZA2d4;
    lanes_put(&out[71], TXY3_2, stream);
    const lanes ZA3r3 = ZP11r3 + ZP22r3;
    const lanes Z3r3 = G2e2 - panda_geometry_R3 * ZA3r3;
    const lanes ZA3d4 = ZP13d4 - X33;
    const lanes A2313 = X33 + ZP13d4;
    const lanes ZA1d4 = ZP22r3 + ZP22d4;
    const lanes TMX3_1 = C2 * Z2r3 - E1_2e3 * Z3r3 - L1_1r3 * ZA1d4 - L1_2r3 * ZA3d4;
    lanes_put(&out[13], TMX3_1, stream);
    const lanes Z3d4 = panda_geometry_D4 * ZA3d4 - Z2r3;
    const lanes TMX3_2 = -C3 * Z3r3 - L2_1r3 * ZA1d4 - L2_2r3 * ZA3d4;
    lanes_put(&out[75], TMX3_2, stream);
    const lanes Z1d4 = Z1r3 - panda_geometry_D4 * ZA1d4;
    const lanes Z2d4 = panda_geometry_D4 * ZA2d4 + Z3r3;
    const lanes X1e4 = C4 * X13 + S4 * X33;
    const lanes X2e4 = C4 * X33 - S4 * X13;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    lanes_put(&out[208], -Z1e4, stream);
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    lanes_put(&out[207], Z2e4, stream);
    const lanes ZP12d5 = -W1e4 * W34;
    const lanes TXX4_3 = S4 * X14 - C4 * ZP12d5;
    lanes_put(&out[140], TXX4_3, stream);
    const lanes ZA2d5 = X24 + ZP12d5;
    const lanes TMX4_3 = panda_geometry_D4 * ZA2d5 - C4 * Z3d4;
    lanes_put(&out[145], TMX4_3, stream);
    const lanes ZP13d5 = W1e4 * W2e4;
    lanes_put(&out[202], -ZP13d5, stream);
    const lanes P114 = W1e4 * W1e4;
    const lanes TXX4_1 = E1_2e3 * ZP13d5 + E1_1e4 * X14 - E1_2e4 * ZP12d5;
    lanes_put(&out[16], TXX4_1, stream);
    const lanes TXX4_2 = C3 * ZP13d5 + E2_1e4 * X14 - E2_2e4 * ZP12d5;
    lanes_put(&out[78], TXX4_2, stream);
    const lanes ZA3d5 = X34 + ZP13d5;
    const lanes A2314 = X34 - ZP13d5;
    const lanes ZP22d5 = W34 * W34;
    const lanes P234 = W2e4 * W34;
    const lanes ZP33d5 = W2e4 * W2e4;
    const lanes TZZ4_1 = E1_1e4 * P234 + E1_2e4 * ZP12d5 - E1_2e3 * X34;
    lanes_put(&out[20], TZZ4_1, stream);
    const lanes TZZ4_2 = E2_1e4 * P234 + E2_2e4 * ZP12d5 - C3 * X34;
    lanes_put(&out[82], TZZ4_2, stream);
    const lanes TZZ4_3 = C4 * ZP12d5 + S4 * P234;
    lanes_put(&out[144], TZZ4_3, stream);
    const lanes A3214 = X24 - ZP12d5;
    lanes_put(&out[205], A3214, stream);
    const lanes X35 = qdd[4] + X24;
    lanes_put(&out[276], X35, stream);
    const lanes ZA1d5 = ZP22d5 + ZP33d5;
    const lanes TMX4_1 = L1_2e4 * ZA3d5 - E1_2e3 * Z2e4 - L1_3d4 * ZA2d5 - E1_2e4 * Z3d4 - L1_1e4 * ZA1d5;
    lanes_put(&out[21], TMX4_1, stream);
    const lanes TMX4_2 = L2_2r3 * ZA2d5 + L2_2e4 * ZA3d5 - C3 * Z2e4 - E2_2e4 * Z3d4 - L2_1e4 * ZA1d5;
    lanes_put(&out[83], TMX4_2, stream);
    const lanes Z3d5 = Z2e4 - panda_geometry_D4 * ZA3d5;
    const lanes Z1d5 = panda_geometry_D4 * ZA1d5 + Z1e4;
    const lanes Z2d5 = -panda_geometry_D4 * ZA2d5 - Z3d4;
    const lanes X1e5 = C5 * X14 - S5 * X34;
    const lanes X2e5 = -C5 * X34 - S5 * X14;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes Z1e5 = C5 * Z1d5 + S5 * Z2d5;
    const lanes Z2e5 = C5 * Z2d5 - S5 * Z1d5;
    const lanes ZP13r5 = W1e5 * W35;
    const lanes TXX5_4 = -C5 * ZP13r5 - S5 * X15;
    lanes_put(&out[210], TXX5_4, stream);
    const lanes ZA1r5 = X25 + ZP13r5;
    lanes_put(&out[275], ZA1r5, stream);
    const lanes Z1r5 = panda_geometry_R5 * ZA1r5 + Z1e5;
    lanes_put(&out[278], -Z1r5, stream);
    const lanes ZP23r5 = W2e5 * W35;
    const lanes P335 = W35 * W35;
    const lanes TZZ5_1 = E1_2e4 * X35 + E1_1e5 * ZP23r5 - E1_2e5 * ZP13r5;
    lanes_put(&out[28], TZZ5_1, stream);
    const lanes TZZ5_2 = E2_2e4 * X35 + E2_1e5 * ZP23r5 - E2_2e5 * ZP13r5;
    lanes_put(&out[90], TZZ5_2, stream);
    const lanes TZZ5_3 = C4 * X35 + E3_1e5 * ZP23r5 - E3_2e5 * ZP13r5;
    lanes_put(&out[152], TZZ5_3, stream);
    const lanes TZZ5_4 = C5 * ZP13r5 - S5 * ZP23r5;
    lanes_put(&out[214], TZZ5_4, stream);
    const lanes ZA2r5 = ZP23r5 - X15;
    lanes_put(&out[274], -ZA2r5, stream);
    const lanes Z2r5 = panda_geometry_R5 * ZA2r5 + Z2e5;
    lanes_put(&out[277], Z2r5, stream);
    const lanes A2135 = X15 + ZP23r5;
    const lanes TMX6_5 = C6 * Z2r5;
    lanes_put(&out[285], TMX6_5, stream);
    const lanes TMY6_5 = -S6 * Z2r5;
    lanes_put(&out[286], TMY6_5, stream);
    const lanes ZP11r5 = W1e5 * W1e5;
    const lanes P125 = W1e5 * W2e5;
    lanes_put(&out[272], -P125, stream);
    const lanes ZP22r5 = W2e5 * W2e5;
    const lanes TXX5_1 = E1_1e5 * X15 + E1_2e5 * ZP13r5 - E1_2e4 * P125;
    lanes_put(&out[24], TXX5_1, stream);
    const lanes TXX5_2 = E2_1e5 * X15 + E2_2e5 * ZP13r5 - E2_2e4 * P125;
    lanes_put(&out[86], TXX5_2, stream);
    const lanes TXX5_3 = E3_1e5 * X15 + E3_2e5 * ZP13r5 - C4 * P125;
    lanes_put(&out[148], TXX5_3, stream);
    const lanes A1235 = X25 - ZP13r5;
    const lanes X36 = qdd[5] - X25;
    lanes_put(&out[346], X36, stream);
    const lanes TXY5_4 = -C5 * A2135 - S5 * A1235;
    lanes_put(&out[211], TXY5_4, stream);
    const lanes ZA3r5 = ZP11r5 + ZP22r5;
    const lanes Z3r5 = Z3d5 - panda_geometry_R5 * ZA3r5;
    const lanes X1e6 = C6 * X15 + S6 * X35;
    const lanes X2e6 = C6 * X35 - S6 * X15;
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes Z1e6 = C6 * Z1r5 + S6 * Z3r5;
    lanes_put(&out[348], -Z1e6, stream);
    const lanes Z2e6 = C6 * Z3r5 - S6 * Z1r5;
    lanes_put(&out[347], Z2e6, stream);
    const lanes ZP12d7 = W1e6 * W36;
    const lanes TXX6_5 = C6 * ZP12d7 + S6 * X16;
    lanes_put(&out[280], TXX6_5, stream);
    const lanes ZA2d7 = ZP12d7 - X26;
    const lanes ZP13d7 = -W1e6 * W2e6;
    lanes_put(&out[342], ZP13d7, stream);
    const lanes P116 = W1e6 * W1e6;
    const lanes TXX6_1 = E1_1e6 * X16 + E1_2e6 * ZP12d7 - E1_2e5 * ZP13d7;
    lanes_put(&out[32], TXX6_1, stream);
    const lanes TXX6_2 = E2_1e6 * X16 + E2_2e6 * ZP12d7 - E2_2e5 * ZP13d7;
    lanes_put(&out[94], TXX6_2, stream);
    const lanes TXX6_3 = E3_1e6 * X16 + E3_2e6 * ZP12d7 - E3_2e5 * ZP13d7;
    lanes_put(&out[156], TXX6_3, stream);
    const lanes TXX6_4 = C5 * ZP13d7 + E4_1e6 * X16 + E4_2e6 * ZP12d7;
    lanes_put(&out[218], TXX6_4, stream);
    const lanes ZA3d7 = ZP13d7 - X36;
    const lanes A2316 = X36 + ZP13d7;
    const lanes ZP22d7 = W36 * W36;
    const lanes P236 = W2e6 * W36;
    const lanes ZP33d7 = W2e6 * W2e6;
    const lanes TZZ6_1 = E1_1e6 * P236 - E1_2e5 * X36 - E1_2e6 * ZP12d7;
    lanes_put(&out[36], TZZ6_1, stream);
    const lanes TZZ6_2 = E2_1e6 * P236 - E2_2e5 * X36 - E2_2e6 * ZP12d7;
    lanes_put(&out[98], TZZ6_2, stream);
    const lanes TZZ6_3 = E3_1e6 * P236 - E3_2e5 * X36 - E3_2e6 * ZP12d7;
    lanes_put(&out[160], TZZ6_3, stream);
    const lanes TZZ6_4 = C5 * X36 + E4_1e6 * P236 - E4_2e6 * ZP12d7;
    lanes_put(&out[222], TZZ6_4, stream);
    const lanes TZZ6_5 = S6 * P236 - C6 * ZP12d7;
    lanes_put(&out[284], TZZ6_5, stream);
    const lanes A3216 = X26 + ZP12d7;
    lanes_put(&out[345], A3216, stream);
    const lanes X37 = qdd[6] - X26;
    lanes_put(&out[416], X37, stream);
    const lanes ZA1d7 = ZP22d7 + ZP33d7;
    const lanes TMX6_1 = E1_2e6 * Z2r5 - E1_2e5 * Z2e6 - L1_2r5 * ZA2d7 - L1_1e6 * ZA1d7 - L1_2e6 * ZA3d7;
    lanes_put(&out[37], TMX6_1, stream);
    const lanes TMX6_2 = E2_2e6 * Z2r5 - E2_2e5 * Z2e6 - L2_2r5 * ZA2d7 - L2_1e6 * ZA1d7 - L2_2e6 * ZA3d7;
    lanes_put(&out[99], TMX6_2, stream);
    const lanes TMX6_3 = E3_2e6 * Z2r5 - E3_2e5 * Z2e6 - L3_2r5 * ZA2d7 - L3_1e6 * ZA1d7 - L3_2e6 * ZA3d7;
    lanes_put(&out[161], TMX6_3, stream);
    const lanes TMX6_4 = C5 * Z2e6 + E4_2e6 * Z2r5 - L4_2r5 * ZA2d7 - L4_1e6 * ZA1d7 - L4_2e6 * ZA3d7;
    lanes_put(&out[223], TMX6_4, stream);
    const lanes Z3d7 = panda_geometry_D7 * ZA3d7 - Z2e6;
    const lanes Z1d7 = Z1e6 - panda_geometry_D7 * ZA1d7;
    const lanes Z2d7 = panda_geometry_D7 * ZA2d7 - Z2r5;
    const lanes X1e7 = C7 * X16 + S7 * X36;
    const lanes X2e7 = C7 * X36 - S7 * X16;
    const lanes X17 = qd[6] * W2e7 + X1e7;
    const lanes X27 = X2e7 - qd[6] * W1e7;
    const lanes Z1e7 = C7 * Z1d7 + S7 * Z2d7;
    lanes_put(&out[418], -Z1e7, stream);
    const lanes Z2e7 = C7 * Z2d7 - S7 * Z1d7;
    lanes_put(&out[417], Z2e7, stream);
    const lanes P112 = W1e2 * W1e2;
    const lanes P122 = W1e2 * W2e2;
    lanes_put(&out[63], -P122, stream);
    const lanes P132 = qd[1] * W1e2;
    const lanes TXX2_1 = -C2 * P132 - S2 * X12;
    lanes_put(&out[1], TXX2_1, stream);
    const lanes A3212 = X22 + P132;
    lanes_put(&out[66], A3212, stream);
    const lanes A1232 = X22 - P132;
    const lanes P222 = W2e2 * W2e2;
    const lanes P232 = qd[1] * W2e2;
    const lanes B32 = P112 - P222;
    lanes_put(&out[64], B32, stream);
    const lanes A3122 = X12 - P232;
    lanes_put(&out[65], A3122, stream);
    const lanes A2132 = X12 + P232;
    const lanes TXY2_1 = -C2 * A2132 - S2 * A1232;
    lanes_put(&out[2], TXY2_1, stream);
    const lanes TZZ2_1 = C2 * P132 - S2 * P232;
    lanes_put(&out[5], TZZ2_1, stream);
    const lanes P332 = qd[1] * qd[1];
    const lanes B22 = P332 - P112;
    const lanes B12 = P222 - P332;
    const lanes A1322 = qdd[1] + P122;
    const lanes TXZ2_1 = -C2 * B22 - S2 * A1322;
    lanes_put(&out[3], TXZ2_1, stream);
    const lanes A2312 = qdd[1] - P122;
    const lanes TYZ2_1 = -C2 * A2312 - S2 * B12;
    lanes_put(&out[4], TYZ2_1, stream);
    const lanes B33 = ZP11r3 - ZP22r3;
    lanes_put(&out[133], B33, stream);
    const lanes TXY3_1 = C2 * B33 + E1_2e3 * A2133 - E1_1e3 * ZA2d4;
    lanes_put(&out[9], TXY3_1, stream);
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes TYZ3_1 = C2 * ZA1r3 + E1_1e3 * B13 + E1_2e3 * A2313;
    lanes_put(&out[11], TYZ3_1, stream);
    const lanes TYZ3_2 = C3 * A2313 + S3 * B13;
    lanes_put(&out[73], TYZ3_2, stream);
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes TXZ3_1 = E1_2e3 * B23 - C2 * ZA2r3 - E1_1e3 * ZA3d4;
    lanes_put(&out[10], TXZ3_1, stream);
    const lanes TXZ3_2 = C3 * B23 - S3 * ZA3d4;
    lanes_put(&out[72], TXZ3_2, stream);
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes TMY3_1 = E1_1e3 * Z3r3 - C2 * Z1r3 - L1_1r3 * A2313 - L1_2r3 * Q23;
    lanes_put(&out[14], TMY3_1, stream);
    const lanes TMY3_2 = S3 * Z3r3 - L2_1r3 * A2313 - L2_2r3 * Q23;
    lanes_put(&out[76], TMY3_2, stream);
    const lanes A2134 = X14 + P234;
    const lanes TXY4_3 = C4 * A2134 + S4 * ZA2d5;
    lanes_put(&out[141], TXY4_3, stream);
    const lanes A3124 = X14 - P234;
    lanes_put(&out[204], A3124, stream);
    const lanes TMY4_3 = S4 * Z3d4 - panda_geometry_D4 * A2134;
    lanes_put(&out[146], TMY4_3, stream);
    const lanes B34 = P114 - ZP33d5;
    lanes_put(&out[203], B34, stream);
    const lanes TXY4_1 = E1_1e4 * ZA2d5 + E1_2e4 * A2134 - E1_2e3 * B34;
    lanes_put(&out[17], TXY4_1, stream);
    const lanes TXY4_2 = E2_1e4 * ZA2d5 + E2_2e4 * A2134 - C3 * B34;
    lanes_put(&out[79], TXY4_2, stream);
    const lanes B14 = ZP33d5 - ZP22d5;
    const lanes TYZ4_1 = E1_1e4 * B14 + E1_2e4 * A2314 - E1_2e3 * A3214;
    lanes_put(&out[19], TYZ4_1, stream);
    const lanes TYZ4_2 = E2_1e4 * B14 + E2_2e4 * A2314 - C3 * A3214;
    lanes_put(&out[81], TYZ4_2, stream);
    const lanes TYZ4_3 = C4 * A2314 + S4 * B14;
    lanes_put(&out[143], TYZ4_3, stream);
    const lanes B24 = ZP22d5 - P114;
    const lanes TXZ4_1 = E1_1e4 * ZA3d5 + E1_2e4 * B24 - E1_2e3 * A3124;
    lanes_put(&out[18], TXZ4_1, stream);
    const lanes TXZ4_2 = E2_1e4 * ZA3d5 + E2_2e4 * B24 - C3 * A3124;
    lanes_put(&out[80], TXZ4_2, stream);
    const lanes TXZ4_3 = C4 * B24 + S4 * ZA3d5;
    lanes_put(&out[142], TXZ4_3, stream);
    const lanes Q24 = ZP22d5 + P114;
    const lanes TMY4_1 = E1_2e3 * Z1e4 + L1_3d4 * A2134 + E1_1e4 * Z3d4 - L1_1e4 * A2314 - L1_2e4 * Q24;
    lanes_put(&out[22], TMY4_1, stream);
    const lanes TMY4_2 = C3 * Z1e4 + E2_1e4 * Z3d4 - L2_2r3 * A2134 - L2_1e4 * A2314 - L2_2e4 * Q24;
    lanes_put(&out[84], TMY4_2, stream);
    const lanes B35 = ZP11r5 - ZP22r5;
    lanes_put(&out[273], B35, stream);
    const lanes TXY5_1 = E1_2e4 * B35 + E1_1e5 * A1235 + E1_2e5 * A2135;
    lanes_put(&out[25], TXY5_1, stream);
    const lanes TXY5_2 = E2_2e4 * B35 + E2_1e5 * A1235 + E2_2e5 * A2135;
    lanes_put(&out[87], TXY5_2, stream);
    const lanes TXY5_3 = C4 * B35 + E3_1e5 * A1235 + E3_2e5 * A2135;
    lanes_put(&out[149], TXY5_3, stream);
    const lanes A1325 = X35 + P125;
    const lanes A2315 = X35 - P125;
    const lanes B25 = P335 - ZP11r5;
    const lanes TXZ5_1 = E1_1e5 * A1325 + E1_2e5 * B25 - E1_2e4 * ZA2r5;
    lanes_put(&out[26], TXZ5_1, stream);
    const lanes TXZ5_2 = E2_1e5 * A1325 + E2_2e5 * B25 - E2_2e4 * ZA2r5;
    lanes_put(&out[88], TXZ5_2, stream);
    const lanes TXZ5_3 = E3_1e5 * A1325 + E3_2e5 * B25 - C4 * ZA2r5;
    lanes_put(&out[150], TXZ5_3, stream);
    const lanes TXZ5_4 = -C5 * B25 - S5 * A1325;
    lanes_put(&out[212], TXZ5_4, stream);
    const lanes Q25 = ZP11r5 + P335;
    const lanes TMY5_1 = L1_3d5 * A2135 + E1_1e5 * Z3r5 - E1_2e4 * Z1r5 - L1_1r5 * A2315 - L1_2r5 * Q25;
    lanes_put(&out[30], TMY5_1, stream);
    const lanes TMY5_2 = L2_3d5 * A2135 + E2_1e5 * Z3r5 - E2_2e4 * Z1r5 - L2_1r5 * A2315 - L2_2r5 * Q25;
    lanes_put(&out[92], TMY5_2, stream);
    const lanes TMY5_3 = E3_1e5 * Z3r5 - C4 * Z1r5 - L3_1r5 * A2315 - L3_2r5 * Q25;
    lanes_put(&out[154], TMY5_3, stream);
    const lanes TMY5_4 = -panda_geometry_D4 * A2135 - S5 * Z3r5 - L4_1r5 * A2315 - L4_2r5 * Q25;
    lanes_put(&out[216], TMY5_4, stream);
    const lanes B15 = ZP22r5 - P335;
    const lanes TYZ5_1 = E1_2e4 * ZA1r5 + E1_1e5 * B15 + E1_2e5 * A2315;
    lanes_put(&out[27], TYZ5_1, stream);
    const lanes TYZ5_2 = E2_2e4 * ZA1r5 + E2_1e5 * B15 + E2_2e5 * A2315;
    lanes_put(&out[89], TYZ5_2, stream);
    const lanes TYZ5_3 = C4 * ZA1r5 + E3_1e5 * B15 + E3_2e5 * A2315;
    lanes_put(&out[151], TYZ5_3, stream);
    const lanes TYZ5_4 = -C5 * A2315 - S5 * B15;
    lanes_put(&out[213], TYZ5_4, stream);
    const lanes Q15 = ZP22r5 + P335;
    const lanes TMX5_1 = E1_2e4 * Z2r5 + L1_2r5 * A1325 - L1_3d5 * A1235 - E1_2e5 * Z3r5 - L1_1r5 * Q15;
    lanes_put(&out[29], TMX5_1, stream);
    const lanes TMX5_2 = E2_2e4 * Z2r5 + L2_2r5 * A1325 - L2_3d5 * A1235 - E2_2e5 * Z3r5 - L2_1r5 * Q15;
    lanes_put(&out[91], TMX5_2, stream);
    const lanes TMX5_3 = C4 * Z2r5 + L3_2r5 * A1325 - E3_2e5 * Z3r5 - L3_1r5 * Q15;
    lanes_put(&out[153], TMX5_3, stream);
    const lanes TMX5_4 = panda_geometry_D4 * A1235 + C5 * Z3r5 + L4_2r5 * A1325 - L4_1r5 * Q15;
    lanes_put(&out[215], TMX5_4, stream);
    const lanes A2136 = X16 + P236;
    const lanes TXY6_5 = C6 * A2136 - S6 * ZA2d7;
    lanes_put(&out[281], TXY6_5, stream);
    const lanes A3126 = X16 - P236;
    lanes_put(&out[344], A3126, stream);
    const lanes B36 = P116 - ZP33d7;
    lanes_put(&out[343], B36, stream);
    const lanes TXY6_1 = E1_2e6 * A2136 - E1_2e5 * B36 - E1_1e6 * ZA2d7;
    lanes_put(&out[33], TXY6_1, stream);
    const lanes TXY6_2 = E2_2e6 * A2136 - E2_2e5 * B36 - E2_1e6 * ZA2d7;
    lanes_put(&out[95], TXY6_2, stream);
    const lanes TXY6_3 = E3_2e6 * A2136 - E3_2e5 * B36 - E3_1e6 * ZA2d7;
    lanes_put(&out[157], TXY6_3, stream);
    const lanes TXY6_4 = C5 * B36 + E4_2e6 * A2136 - E4_1e6 * ZA2d7;
    lanes_put(&out[219], TXY6_4, stream);
    const lanes B16 = ZP33d7 - ZP22d7;
    const lanes TYZ6_1 = E1_1e6 * B16 + E1_2e6 * A2316 - E1_2e5 * A3216;
    lanes_put(&out[35], TYZ6_1, stream);
    const lanes TYZ6_2 = E2_1e6 * B16 + E2_2e6 * A2316 - E2_2e5 * A3216;
    lanes_put(&out[97], TYZ6_2, stream);
    const lanes TYZ6_3 = E3_1e6 * B16 + E3_2e6 * A2316 - E3_2e5 * A3216;
    lanes_put(&out[159], TYZ6_3, stream);
    const lanes TYZ6_4 = C5 * A3216 + E4_1e6 * B16 + E4_2e6 * A2316;
    lanes_put(&out[221], TYZ6_4, stream);
    const lanes TYZ6_5 = C6 * A2316 + S6 * B16;
    lanes_put(&out[283], TYZ6_5, stream);
    const lanes B26 = ZP22d7 - P116;
    const lanes TXZ6_1 = E1_2e6 * B26 - E1_2e5 * A3126 - E1_1e6 * ZA3d7;
    lanes_put(&out[34], TXZ6_1, stream);
    const lanes TXZ6_2 = E2_2e6 * B26 - E2_2e5 * A3126 - E2_1e6 * ZA3d7;
    lanes_put(&out[96], TXZ6_2, stream);
    const lanes TXZ6_3 = E3_2e6 * B26 - E3_2e5 * A3126 - E3_1e6 * ZA3d7;
    lanes_put(&out[158], TXZ6_3, stream);
    const lanes TXZ6_4 = C5 * A3126 + E4_2e6 * B26 - E4_1e6 * ZA3d7;
    lanes_put(&out[220], TXZ6_4, stream);
    const lanes TXZ6_5 = C6 * B26 - S6 * ZA3d7;
    lanes_put(&out[282], TXZ6_5, stream);
    const lanes Q26 = ZP22d7 + P116;
    const lanes TMY6_1 = E1_2e5 * Z1e6 - L1_2r5 * A2136 - E1_1e6 * Z2r5 - L1_1e6 * A2316 - L1_2e6 * Q26;
    lanes_put(&out[38], TMY6_1, stream);
    const lanes TMY6_2 = E2_2e5 * Z1e6 - L2_2r5 * A2136 - E2_1e6 * Z2r5 - L2_1e6 * A2316 - L2_2e6 * Q26;
    lanes_put(&out[100], TMY6_2, stream);
    const lanes TMY6_3 = E3_2e5 * Z1e6 - L3_2r5 * A2136 - E3_1e6 * Z2r5 - L3_1e6 * A2316 - L3_2e6 * Q26;
    lanes_put(&out[162], TMY6_3, stream);
    const lanes TMY6_4 = -C5 * Z1e6 - L4_2r5 * A2136 - E4_1e6 * Z2r5 - L4_1e6 * A2316 - L4_2e6 * Q26;
    lanes_put(&out[224], TMY6_4, stream);
    const lanes P117 = W1e7 * W1e7;
    const lanes P127 = W1e7 * W2e7;
    lanes_put(&out[412], -P127, stream);
    const lanes P137 = W1e7 * W37;
    const lanes TXX7_1 = E1_2e6 * P127 + E1_1e7 * X17 + E1_2e7 * P137;
    lanes_put(&out[40], TXX7_1, stream);
    const lanes TXX7_2 = E2_2e6 * P127 + E2_1e7 * X17 + E2_2e7 * P137;
    lanes_put(&out[102], TXX7_2, stream);
    const lanes TXX7_3 = E3_2e6 * P127 + E3_1e7 * X17 + E3_2e7 * P137;
    lanes_put(&out[164], TXX7_3, stream);
    const lanes TXX7_4 = E4_2e6 * P127 + E4_1e7 * X17 + E4_2e7 * P137;
    lanes_put(&out[226], TXX7_4, stream);
    const lanes TXX7_5 = C6 * P127 + E5_1e7 * X17 + E5_2e7 * P137;
    lanes_put(&out[288], TXX7_5, stream);
    const lanes TXX7_6 = C7 * P137 + S7 * X17;
    lanes_put(&out[350], TXX7_6, stream);
    const lanes P227 = W2e7 * W2e7;
    const lanes P237 = W2e7 * W37;
    const lanes P337 = W37 * W37;
    const lanes TZZ7_1 = E1_1e7 * P237 - E1_2e6 * X37 - E1_2e7 * P137;
    lanes_put(&out[44], TZZ7_1, stream);
    const lanes TZZ7_2 = E2_1e7 * P237 - E2_2e6 * X37 - E2_2e7 * P137;
    lanes_put(&out[106], TZZ7_2, stream);
    const lanes TZZ7_3 = E3_1e7 * P237 - E3_2e6 * X37 - E3_2e7 * P137;
    lanes_put(&out[168], TZZ7_3, stream);
    const lanes TZZ7_4 = E4_1e7 * P237 - E4_2e6 * X37 - E4_2e7 * P137;
    lanes_put(&out[230], TZZ7_4, stream);
    const lanes TZZ7_5 = E5_1e7 * P237 - C6 * X37 - E5_2e7 * P137;
    lanes_put(&out[292], TZZ7_5, stream);
    const lanes TZZ7_6 = S7 * P237 - C7 * P137;
    lanes_put(&out[354], TZZ7_6, stream);
    const lanes A1237 = X27 - P137;
    const lanes A3217 = X27 + P137;
    lanes_put(&out[415], A3217, stream);
    const lanes TMX7_6 = panda_geometry_D7 * A1237 - C7 * Z3d7;
    lanes_put(&out[355], TMX7_6, stream);
    const lanes A2137 = X17 + P237;
    const lanes TXY7_6 = C7 * A2137 + S7 * A1237;
    lanes_put(&out[351], TXY7_6, stream);
    const lanes A3127 = X17 - P237;
    lanes_put(&out[414], A3127, stream);
    const lanes TMY7_6 = S7 * Z3d7 - panda_geometry_D7 * A2137;
    lanes_put(&out[356], TMY7_6, stream);
    const lanes B37 = P117 - P227;
    lanes_put(&out[413], B37, stream);
    const lanes TXY7_1 = E1_1e7 * A1237 + E1_2e7 * A2137 - E1_2e6 * B37;
    lanes_put(&out[41], TXY7_1, stream);
    const lanes TXY7_2 = E2_1e7 * A1237 + E2_2e7 * A2137 - E2_2e6 * B37;
    lanes_put(&out[103], TXY7_2, stream);
    const lanes TXY7_3 = E3_1e7 * A1237 + E3_2e7 * A2137 - E3_2e6 * B37;
    lanes_put(&out[165], TXY7_3, stream);
    const lanes TXY7_4 = E4_1e7 * A1237 + E4_2e7 * A2137 - E4_2e6 * B37;
    lanes_put(&out[227], TXY7_4, stream);
    const lanes TXY7_5 = E5_1e7 * A1237 + E5_2e7 * A2137 - C6 * B37;
    lanes_put(&out[289], TXY7_5, stream);
    const lanes A1327 = X37 + P127;
    const lanes A2317 = X37 - P127;
    const lanes B27 = P337 - P117;
    const lanes TXZ7_1 = E1_1e7 * A1327 + E1_2e7 * B27 - E1_2e6 * A3127;
    lanes_put(&out[42], TXZ7_1, stream);
    const lanes TXZ7_2 = E2_1e7 * A1327 + E2_2e7 * B27 - E2_2e6 * A3127;
    lanes_put(&out[104], TXZ7_2, stream);
    const lanes TXZ7_3 = E3_1e7 * A1327 + E3_2e7 * B27 - E3_2e6 * A3127;
    lanes_put(&out[166], TXZ7_3, stream);
    const lanes TXZ7_4 = E4_1e7 * A1327 + E4_2e7 * B27 - E4_2e6 * A3127;
    lanes_put(&out[228], TXZ7_4, stream);
    const lanes TXZ7_5 = E5_1e7 * A1327 + E5_2e7 * B27 - C6 * A3127;
    lanes_put(&out[290], TXZ7_5, stream);
    const lanes TXZ7_6 = C7 * B27 + S7 * A1327;
    lanes_put(&out[352], TXZ7_6, stream);
    const lanes Q27 = P117 + P337;
    const lanes TMY7_1 = E1_2e6 * Z1e7 + L1_3d7 * A2137 + E1_1e7 * Z3d7 - L1_1e7 * A2317 - L1_2e7 * Q27;
    lanes_put(&out[46], TMY7_1, stream);
    const lanes TMY7_2 = E2_2e6 * Z1e7 + L2_3d7 * A2137 + E2_1e7 * Z3d7 - L2_1e7 * A2317 - L2_2e7 * Q27;
    lanes_put(&out[108], TMY7_2, stream);
    const lanes TMY7_3 = E3_2e6 * Z1e7 + L3_3d7 * A2137 + E3_1e7 * Z3d7 - L3_1e7 * A2317 - L3_2e7 * Q27;
    lanes_put(&out[170], TMY7_3, stream);
    const lanes TMY7_4 = E4_2e6 * Z1e7 + L4_3d7 * A2137 + E4_1e7 * Z3d7 - L4_1e7 * A2317 - L4_2e7 * Q27;
    lanes_put(&out[232], TMY7_4, stream);
    const lanes TMY7_5 = C6 * Z1e7 + E5_1e7 * Z3d7 - L5_1e7 * A2317 - L5_2e7 * Q27;
    lanes_put(&out[294], TMY7_5, stream);
    const lanes B17 = P227 - P337;
    const lanes TYZ7_1 = E1_1e7 * B17 + E1_2e7 * A2317 - E1_2e6 * A3217;
    lanes_put(&out[43], TYZ7_1, stream);
    const lanes TYZ7_2 = E2_1e7 * B17 + E2_2e7 * A2317 - E2_2e6 * A3217;
    lanes_put(&out[105], TYZ7_2, stream);
    const lanes TYZ7_3 = E3_1e7 * B17 + E3_2e7 * A2317 - E3_2e6 * A3217;
    lanes_put(&out[167], TYZ7_3, stream);
    const lanes TYZ7_4 = E4_1e7 * B17 + E4_2e7 * A2317 - E4_2e6 * A3217;
    lanes_put(&out[229], TYZ7_4, stream);
    const lanes TYZ7_5 = E5_1e7 * B17 + E5_2e7 * A2317 - C6 * A3217;
    lanes_put(&out[291], TYZ7_5, stream);
    const lanes TYZ7_6 = C7 * A2317 + S7 * B17;
    lanes_put(&out[353], TYZ7_6, stream);
    const lanes Q17 = P227 + P337;
    const lanes TMX7_1 = L1_2e7 * A1327 - E1_2e6 * Z2e7 - L1_3d7 * A1237 - E1_2e7 * Z3d7 - L1_1e7 * Q17;
    lanes_put(&out[45], TMX7_1, stream);
    const lanes TMX7_2 = L2_2e7 * A1327 - E2_2e6 * Z2e7 - L2_3d7 * A1237 - E2_2e7 * Z3d7 - L2_1e7 * Q17;
    lanes_put(&out[107], TMX7_2, stream);
    const lanes TMX7_3 = L3_2e7 * A1327 - E3_2e6 * Z2e7 - L3_3d7 * A1237 - E3_2e7 * Z3d7 - L3_1e7 * Q17;
    lanes_put(&out[169], TMX7_3, stream);
    const lanes TMX7_4 = L4_2e7 * A1327 - E4_2e6 * Z2e7 - L4_3d7 * A1237 - E4_2e7 * Z3d7 - L4_1e7 * Q17;
    lanes_put(&out[231], TMX7_4, stream);
    const lanes TMX7_5 = L5_2e7 * A1327 - C6 * Z2e7 - E5_2e7 * Z3d7 - L5_1e7 * Q17;
    lanes_put(&out[293], TMX7_5, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *qdd, apart *out)
{
    return panel(q, qd, qdd, out, 0);
}

int panda_torque_regressor_rows(int stream, size_t N, const size_t *strides,
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
        if (stride_qdd != 0u) {
            lanes_load(qdd, 7u, stride_qdd, k, N, padded_qdd, lanes_qdd);
        }
        status |= plain(lanes_q, lanes_qd, lanes_qdd, (apart *)lanes_out);
        lanes_store(lanes_out, 434u, count, stream, scratch, &out[k * 434u]);
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
        apart *lanes_out = (apart *)&out[k * 434u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_qdd, lanes_out, 1) : plain(lanes_q, lanes_qd, lanes_qdd, lanes_out);
    }
    return status;
}

int panda_torque_regressor_panels(int stream, size_t N, const size_t *strides,
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

int panda_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 7u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 7u;
    const size_t stride_qdd = (strides != NULL) ? strides[2] : 7u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        panda_torque_regressor(&q[k * stride_q], &qd[k * stride_qd], &qdd[k * stride_qdd], &out[k * 434u]);
    }
    return status;
}

int panda_torque_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out)
{
    return panda_torque_regressor_rows(stream, N, strides, q, qd, qdd, out);
}

#endif

size_t panda_torque_regressor_width(void)
{
    return panda_WIDTH;
}

void panda_torque_regressor_batch(size_t N, const double *q, const double *qd, const double *qdd, double *out)
{
    (void)panda_torque_regressor_rows(0, N, NULL, q, qd, qdd, out);
}
