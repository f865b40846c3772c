/* puma560: momentum_regressor of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, apart *p_out, apart *dl_out, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    lanes_put(&p_out[0], qd[0], stream);
    lanes_put(&p_out[45], qd[1], stream);
    lanes_put(&p_out[95], qd[2], stream);
    lanes_put(&p_out[143], qd[3], stream);
    lanes_put(&p_out[191], qd[4], stream);
    lanes_put(&p_out[239], qd[5], stream);
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
    lanes_put(&p_out[43], W1e2, stream);
    const lanes W2e2 = -qd[0] * C2;
    lanes_put(&p_out[44], W2e2, stream);
    const lanes G1e2 = gz * S2;
    const lanes G2e2 = gz * C2;
    const lanes V1r2 = puma560_geometry_R2 * W2e2;
    lanes_put(&p_out[47], -V1r2, stream);
    const lanes V2r2 = -puma560_geometry_R2 * W1e2;
    lanes_put(&p_out[46], V2r2, stream);
    const lanes V2d3 = qd[1] * puma560_geometry_D3 + V2r2;
    const lanes V3d3 = -puma560_geometry_D3 * W2e2;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    lanes_put(&p_out[50], W1e3, stream);
    lanes_put(&p_out[90], W1e3, stream);
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    lanes_put(&p_out[51], W2e3, stream);
    lanes_put(&p_out[91], W2e3, stream);
    const lanes V1e3 = C3 * V1r2 + S3 * V2d3;
    const lanes V2e3 = C3 * V2d3 - S3 * V1r2;
    const lanes G1e3 = C3 * G1e2 + S3 * G2e2;
    const lanes G2e3 = C3 * G2e2 - S3 * G1e2;
    const lanes W33 = qd[1] + qd[2];
    lanes_put(&p_out[52], W33, stream);
    lanes_put(&p_out[92], W33, stream);
    const lanes V1r3 = puma560_geometry_R3 * W2e3 + V1e3;
    lanes_put(&p_out[94], -V1r3, stream);
    const lanes V2r3 = V2e3 - puma560_geometry_R3 * W1e3;
    lanes_put(&p_out[93], V2r3, stream);
    const lanes V2d4 = V3d3 - puma560_geometry_D4 * W2e3;
    const lanes V3d4 = -puma560_geometry_D4 * W33 - V2r3;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    lanes_put(&p_out[138], W1e4, stream);
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    lanes_put(&p_out[139], W2e4, stream);
    const lanes V1e4 = C4 * V1r3 + S4 * V2d4;
    const lanes V2e4 = C4 * V2d4 - S4 * V1r3;
    const lanes G1e4 = C4 * G1e3;
    const lanes G2e4 = -S4 * G1e3;
    const lanes W34 = qd[3] - W2e3;
    lanes_put(&p_out[140], W34, stream);
    const lanes V1r4 = puma560_geometry_R4 * W2e4 + V1e4;
    lanes_put(&p_out[142], -V1r4, stream);
    const lanes V2r4 = V2e4 - puma560_geometry_R4 * W1e4;
    lanes_put(&p_out[141], V2r4, stream);
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    lanes_put(&p_out[186], W1e5, stream);
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    lanes_put(&p_out[187], W2e5, stream);
    const lanes V1e5 = C5 * V1r4 - S5 * V3d4;
    lanes_put(&p_out[190], -V1e5, stream);
    const lanes V2e5 = -C5 * V3d4 - S5 * V1r4;
    lanes_put(&p_out[189], V2e5, stream);
    const lanes G1e5 = C5 * G1e4 + S5 * G2e3;
    const lanes G2e5 = C5 * G2e3 - S5 * G1e4;
    const lanes W35 = qd[4] + W2e4;
    lanes_put(&p_out[188], W35, stream);
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    lanes_put(&p_out[234], W1e6, stream);
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    lanes_put(&p_out[235], W2e6, stream);
    const lanes V1e6 = C6 * V1e5 + S6 * V2r4;
    lanes_put(&p_out[238], -V1e6, stream);
    const lanes V2e6 = C6 * V2r4 - S6 * V1e5;
    lanes_put(&p_out[237], V2e6, stream);
    const lanes G1e6 = C6 * G1e5 + S6 * G2e4;
    const lanes G2e6 = C6 * G2e4 - S6 * G1e5;
    const lanes W36 = qd[5] - W2e5;
    lanes_put(&p_out[236], W36, stream);
    const lanes ZP13r2 = qd[1] * W1e2;
    lanes_put(&dl_out[44], -ZP13r2, stream);
    const lanes ZP23r2 = qd[1] * W2e2;
    lanes_put(&dl_out[43], ZP23r2, stream);
    const lanes ZP12d3 = W1e2 * W2e2;
    lanes_put(&dl_out[41], ZP12d3, stream);
    const lanes ZP13r3 = W1e3 * W33;
    lanes_put(&dl_out[51], -ZP13r3, stream);
    lanes_put(&dl_out[91], -ZP13r3, stream);
    const lanes ZP23r3 = W2e3 * W33;
    lanes_put(&dl_out[50], ZP23r3, stream);
    lanes_put(&dl_out[90], ZP23r3, stream);
    const lanes ZP13d4 = -W1e3 * W2e3;
    lanes_put(&dl_out[48], -ZP13d4, stream);
    lanes_put(&dl_out[88], -ZP13d4, stream);
    const lanes ZP13r4 = W1e4 * W34;
    lanes_put(&dl_out[139], -ZP13r4, stream);
    const lanes ZP23r4 = W2e4 * W34;
    lanes_put(&dl_out[138], ZP23r4, stream);
    const lanes J2_3d3 = puma560_geometry_D3 * W1e2;
    const lanes J2_1e3 = C3 * V2r2 - S3 * V1r2;
    const lanes J2_2e3 = -C3 * V1r2 - S3 * V2r2;
    const lanes J2_1r3 = J2_1e3 - puma560_geometry_R3 * W1e3;
    const lanes J2_2r3 = J2_2e3 - puma560_geometry_R3 * W2e3;
    const lanes J2_2d4 = puma560_geometry_D4 * W1e3 + J2_3d3;
    const lanes J3_2d4 = puma560_geometry_D4 * W1e3;
    const lanes I2_1e4 = C4 * W2e3;
    const lanes I2_2e4 = -S4 * W2e3;
    const lanes J2_1e4 = C4 * J2_1r3 + S4 * J2_2d4;
    const lanes J2_2e4 = C4 * J2_2d4 - S4 * J2_1r3;
    const lanes J3_1e4 = C4 * V2r3 + S4 * J3_2d4;
    const lanes J3_2e4 = C4 * J3_2d4 - S4 * V2r3;
    const lanes J2_1r4 = puma560_geometry_R4 * I2_2e4 + J2_1e4;
    const lanes J2_2r4 = J2_2e4 - puma560_geometry_R4 * I2_1e4;
    const lanes J3_1r4 = puma560_geometry_R4 * I2_2e4 + J3_1e4;
    const lanes J3_2r4 = J3_2e4 - puma560_geometry_R4 * I2_1e4;
    const lanes I2_1e5 = C5 * I2_1e4 - S5 * W1e3;
    const lanes I2_2e5 = -C5 * W1e3 - S5 * I2_1e4;
    const lanes J2_1e5 = C5 * J2_1r4 + S5 * J2_2r3;
    const lanes J2_2e5 = C5 * J2_2r3 - S5 * J2_1r4;
    const lanes J3_1e5 = C5 * J3_1r4 - S5 * V1r3;
    const lanes J3_2e5 = -C5 * V1r3 - S5 * J3_1r4;
    const lanes I4_1e5 = C5 * W2e4;
    const lanes I4_2e5 = -S5 * W2e4;
    const lanes J4_1e5 = C5 * V2r4;
    lanes_put(&p_out[149], J4_1e5, stream);
    const lanes J4_2e5 = -S5 * V2r4;
    lanes_put(&p_out[150], J4_2e5, stream);
    const lanes I2_1e6 = C6 * I2_1e5 + S6 * I2_2e4;
    const lanes I2_2e6 = C6 * I2_2e4 - S6 * I2_1e5;
    const lanes J2_1e6 = C6 * J2_1e5 + S6 * J2_2r4;
    const lanes J2_2e6 = C6 * J2_2r4 - S6 * J2_1e5;
    const lanes J3_1e6 = C6 * J3_1e5 + S6 * J3_2r4;
    const lanes J3_2e6 = C6 * J3_2r4 - S6 * J3_1e5;
    const lanes I4_1e6 = C6 * I4_1e5 - S6 * W1e4;
    const lanes I4_2e6 = -C6 * W1e4 - S6 * I4_1e5;
    const lanes J4_1e6 = C6 * J4_1e5 - S6 * V1r4;
    const lanes J4_2e6 = -C6 * V1r4 - S6 * J4_1e5;
    const lanes I5_1e6 = C6 * W2e5;
    const lanes I5_2e6 = -S6 * W2e5;
    const lanes J5_1e6 = C6 * V2e5;
    lanes_put(&p_out[197], J5_1e6, stream);
    const lanes J5_2e6 = -S6 * V2e5;
    lanes_put(&p_out[198], J5_2e6, stream);
    const lanes QXX2_1 = -S2 * W1e2;
    lanes_put(&p_out[1], QXX2_1, stream);
    const lanes QXY2_1 = -C2 * W1e2 - S2 * W2e2;
    lanes_put(&p_out[2], QXY2_1, stream);
    const lanes SXY2_2 = W2e2 * W2e2 - W1e2 * W1e2;
    lanes_put(&dl_out[42], SXY2_2, stream);
    const lanes QXZ2_1 = -qd[1] * S2;
    lanes_put(&p_out[3], QXZ2_1, stream);
    const lanes QYZ2_1 = -qd[1] * C2;
    lanes_put(&p_out[4], QYZ2_1, stream);
    const lanes QMX2_1 = qd[1] * L1_2r2;
    lanes_put(&p_out[6], QMX2_1, stream);
    const lanes SMX2_2 = G2e2 - qd[1] * V1r2;
    lanes_put(&dl_out[46], SMX2_2, stream);
    const lanes QMY2_1 = -qd[1] * L1_1r2;
    lanes_put(&p_out[7], QMY2_1, stream);
    const lanes SMY2_2 = -qd[1] * V2r2 - G1e2;
    lanes_put(&dl_out[47], SMY2_2, stream);
    const lanes QXX3_1 = E1_1e3 * W1e3;
    lanes_put(&p_out[8], QXX3_1, stream);
    const lanes QXY3_1 = E1_1e3 * W2e3 + E1_2e3 * W1e3;
    lanes_put(&p_out[9], QXY3_1, stream);
    const lanes SXY3_2 = W2e3 * W2e3 - W1e3 * W1e3;
    lanes_put(&dl_out[49], SXY3_2, stream);
    lanes_put(&dl_out[89], SXY3_2, stream);
    const lanes QXZ3_1 = E1_1e3 * W33;
    lanes_put(&p_out[10], QXZ3_1, stream);
    const lanes QYZ3_1 = E1_2e3 * W33;
    lanes_put(&p_out[11], QYZ3_1, stream);
    const lanes QMX3_1 = L1_2r3 * W33 - L1_3d3 * W2e3 - E1_2e3 * V3d3;
    lanes_put(&p_out[13], QMX3_1, stream);
    const lanes QMX3_2 = L2_2e3 * W33 + V2r3;
    lanes_put(&p_out[53], QMX3_2, stream);
    const lanes SMX3_2 = V3d3 * W1e3 + G2e3 + W33 * J2_2r3 - W2e3 * J2_3d3;
    lanes_put(&dl_out[53], SMX3_2, stream);
    const lanes SMX3_3 = V3d3 * W1e3 + G2e3 - W33 * V1r3;
    lanes_put(&dl_out[93], SMX3_3, stream);
    const lanes QMY3_1 = L1_3d3 * W1e3 + E1_1e3 * V3d3 - L1_1r3 * W33;
    lanes_put(&p_out[14], QMY3_1, stream);
    const lanes QMY3_2 = -L2_1e3 * W33 - V1r3;
    lanes_put(&p_out[54], QMY3_2, stream);
    const lanes SMY3_2 = V3d3 * W2e3 + W1e3 * J2_3d3 - G1e3 - W33 * J2_1r3;
    lanes_put(&dl_out[54], SMY3_2, stream);
    const lanes SMY3_3 = V3d3 * W2e3 - G1e3 - W33 * V2r3;
    lanes_put(&dl_out[94], SMY3_3, stream);
    const lanes QXX4_1 = E1_1e4 * W1e4;
    lanes_put(&p_out[16], QXX4_1, stream);
    const lanes QXX4_2e = S4 * W1e4;
    lanes_put(&p_out[56], QXX4_2e, stream);
    lanes_put(&p_out[96], QXX4_2e, stream);
    const lanes SXX4_2 = W1e4 * I2_1e4;
    lanes_put(&dl_out[56], SXX4_2, stream);
    lanes_put(&dl_out[96], SXX4_2, stream);
    const lanes SXX4_4 = W1e4 * W2e4;
    lanes_put(&dl_out[136], SXX4_4, stream);
    const lanes QXY4_1 = E1_1e4 * W2e4 + E1_2e4 * W1e4;
    lanes_put(&p_out[17], QXY4_1, stream);
    const lanes QXY4_2e = C4 * W1e4 + S4 * W2e4;
    lanes_put(&p_out[57], QXY4_2e, stream);
    lanes_put(&p_out[97], QXY4_2e, stream);
    const lanes SXY4_2 = W1e4 * I2_2e4 + W2e4 * I2_1e4;
    lanes_put(&dl_out[57], SXY4_2, stream);
    lanes_put(&dl_out[97], SXY4_2, stream);
    const lanes SXY4_4 = W2e4 * W2e4 - W1e4 * W1e4;
    lanes_put(&dl_out[137], SXY4_4, stream);
    const lanes QXZ4_1 = E1_1e4 * W34 - E1_2e3 * W1e4;
    lanes_put(&p_out[18], QXZ4_1, stream);
    const lanes QXZ4_2e = S4 * W34;
    lanes_put(&p_out[58], QXZ4_2e, stream);
    lanes_put(&p_out[98], QXZ4_2e, stream);
    const lanes SXZ4_2 = W1e3 * W1e4 + W34 * I2_1e4;
    lanes_put(&dl_out[58], SXZ4_2, stream);
    lanes_put(&dl_out[98], SXZ4_2, stream);
    const lanes QYZ4_1 = E1_2e4 * W34 - E1_2e3 * W2e4;
    lanes_put(&p_out[19], QYZ4_1, stream);
    const lanes QYZ4_2e = C4 * W34;
    lanes_put(&p_out[59], QYZ4_2e, stream);
    lanes_put(&p_out[99], QYZ4_2e, stream);
    const lanes SYZ4_2 = W1e3 * W2e4 + W34 * I2_2e4;
    lanes_put(&dl_out[59], SYZ4_2, stream);
    lanes_put(&dl_out[99], SYZ4_2, stream);
    const lanes QZZ4_1 = -E1_2e3 * W34;
    lanes_put(&p_out[20], QZZ4_1, stream);
    const lanes SZZ4_2 = W1e3 * W34;
    lanes_put(&dl_out[60], SZZ4_2, stream);
    lanes_put(&dl_out[100], SZZ4_2, stream);
    const lanes QMX4_1 = L1_2r3 * W2e4 + L1_2r4 * W34 - E1_2e3 * V2r4 - E1_2e4 * V3d4;
    lanes_put(&p_out[21], QMX4_1, stream);
    const lanes QMX4_2e = -C4 * V3d4;
    const lanes QMX4_2 = L2_2r4 * W34 + QMX4_2e - L2_3d4 * W2e4;
    lanes_put(&p_out[61], QMX4_2, stream);
    const lanes QMX4_3 = puma560_geometry_D4 * W2e4 + L3_2r4 * W34 + QMX4_2e;
    lanes_put(&p_out[101], QMX4_3, stream);
    const lanes SMX4_1 = E1_2e4 * G2e3 - E1_2e3 * G2e4;
    lanes_put(&dl_out[21], SMX4_1, stream);
    const lanes SMX4_2 = C4 * G2e3 + W1e3 * V2r4 + W2e4 * J2_2r3 + W34 * J2_2r4 - V3d4 * I2_2e4;
    lanes_put(&dl_out[61], SMX4_2, stream);
    const lanes SMX4_3 = C4 * G2e3 + W1e3 * V2r4 + W34 * J3_2r4 - V1r3 * W2e4 - V3d4 * I2_2e4;
    lanes_put(&dl_out[101], SMX4_3, stream);
    const lanes SMX4_4 = V3d4 * W1e4 + G2e4 - W34 * V1r4;
    lanes_put(&dl_out[141], SMX4_4, stream);
    const lanes QMY4_1 = E1_2e3 * V1r4 + E1_1e4 * V3d4 - L1_2r3 * W1e4 - L1_1r4 * W34;
    lanes_put(&p_out[22], QMY4_1, stream);
    const lanes QMY4_2e = S4 * V3d4;
    const lanes QMY4_2 = L2_3d4 * W1e4 + QMY4_2e - L2_1r4 * W34;
    lanes_put(&p_out[62], QMY4_2, stream);
    const lanes QMY4_3 = QMY4_2e - puma560_geometry_D4 * W1e4 - L3_1r4 * W34;
    lanes_put(&p_out[102], QMY4_3, stream);
    const lanes SMY4_1 = E1_2e3 * G1e4 - E1_1e4 * G2e3;
    lanes_put(&dl_out[22], SMY4_1, stream);
    const lanes SMY4_2 = V3d4 * I2_1e4 - S4 * G2e3 - W1e3 * V1r4 - W1e4 * J2_2r3 - W34 * J2_1r4;
    lanes_put(&dl_out[62], SMY4_2, stream);
    const lanes SMY4_3 = V1r3 * W1e4 + V3d4 * I2_1e4 - S4 * G2e3 - W1e3 * V1r4 - W34 * J3_1r4;
    lanes_put(&dl_out[102], SMY4_3, stream);
    const lanes SMY4_4 = V3d4 * W2e4 - G1e4 - W34 * V2r4;
    lanes_put(&dl_out[142], SMY4_4, stream);
    const lanes QXX5_1 = E1_1e5 * W1e5;
    lanes_put(&p_out[24], QXX5_1, stream);
    const lanes QXX5_2e = E2_1e5 * W1e5;
    lanes_put(&p_out[64], QXX5_2e, stream);
    lanes_put(&p_out[104], QXX5_2e, stream);
    const lanes QXX5_4 = -S5 * W1e5;
    lanes_put(&p_out[144], QXX5_4, stream);
    const lanes SXX5_2 = W1e5 * I2_1e5;
    lanes_put(&dl_out[64], SXX5_2, stream);
    lanes_put(&dl_out[104], SXX5_2, stream);
    const lanes SXX5_4 = W1e5 * I4_1e5;
    lanes_put(&dl_out[144], SXX5_4, stream);
    const lanes SXX5_5 = W1e5 * W2e5;
    lanes_put(&dl_out[184], SXX5_5, stream);
    const lanes QXY5_1 = E1_1e5 * W2e5 + E1_2e5 * W1e5;
    lanes_put(&p_out[25], QXY5_1, stream);
    const lanes QXY5_2e = E2_1e5 * W2e5 + E2_2e5 * W1e5;
    lanes_put(&p_out[65], QXY5_2e, stream);
    lanes_put(&p_out[105], QXY5_2e, stream);
    const lanes QXY5_4 = -C5 * W1e5 - S5 * W2e5;
    lanes_put(&p_out[145], QXY5_4, stream);
    const lanes SXY5_2 = W1e5 * I2_2e5 + W2e5 * I2_1e5;
    lanes_put(&dl_out[65], SXY5_2, stream);
    lanes_put(&dl_out[105], SXY5_2, stream);
    const lanes SXY5_4 = W1e5 * I4_2e5 + W2e5 * I4_1e5;
    lanes_put(&dl_out[145], SXY5_4, stream);
    const lanes SXY5_5 = W2e5 * W2e5 - W1e5 * W1e5;
    lanes_put(&dl_out[185], SXY5_5, stream);
    const lanes QXZ5_1 = E1_2e4 * W1e5 + E1_1e5 * W35;
    lanes_put(&p_out[26], QXZ5_1, stream);
    const lanes QXZ5_2e = C4 * W1e5 + E2_1e5 * W35;
    lanes_put(&p_out[66], QXZ5_2e, stream);
    lanes_put(&p_out[106], QXZ5_2e, stream);
    const lanes QXZ5_4 = -S5 * W35;
    lanes_put(&p_out[146], QXZ5_4, stream);
    const lanes SXZ5_2 = W1e5 * I2_2e4 + W35 * I2_1e5;
    lanes_put(&dl_out[66], SXZ5_2, stream);
    lanes_put(&dl_out[106], SXZ5_2, stream);
    const lanes SXZ5_4 = W35 * I4_1e5 - W1e4 * W1e5;
    lanes_put(&dl_out[146], SXZ5_4, stream);
    const lanes SXZ5_5 = W2e5 * W35;
    lanes_put(&dl_out[186], SXZ5_5, stream);
    const lanes QYZ5_1 = E1_2e4 * W2e5 + E1_2e5 * W35;
    lanes_put(&p_out[27], QYZ5_1, stream);
    const lanes QYZ5_2e = C4 * W2e5 + E2_2e5 * W35;
    lanes_put(&p_out[67], QYZ5_2e, stream);
    lanes_put(&p_out[107], QYZ5_2e, stream);
    const lanes QYZ5_4 = -C5 * W35;
    lanes_put(&p_out[147], QYZ5_4, stream);
    const lanes SYZ5_2 = W2e5 * I2_2e4 + W35 * I2_2e5;
    lanes_put(&dl_out[67], SYZ5_2, stream);
    lanes_put(&dl_out[107], SYZ5_2, stream);
    const lanes SYZ5_4 = W35 * I4_2e5 - W1e4 * W2e5;
    lanes_put(&dl_out[147], SYZ5_4, stream);
    const lanes SYZ5_5 = -W1e5 * W35;
    lanes_put(&dl_out[187], SYZ5_5, stream);
    const lanes QZZ5_1 = E1_2e4 * W35;
    lanes_put(&p_out[28], QZZ5_1, stream);
    const lanes QZZ5_2e = C4 * W35;
    lanes_put(&p_out[68], QZZ5_2e, stream);
    lanes_put(&p_out[108], QZZ5_2e, stream);
    const lanes SZZ5_2 = W35 * I2_2e4;
    lanes_put(&dl_out[68], SZZ5_2, stream);
    lanes_put(&dl_out[108], SZZ5_2, stream);
    const lanes SZZ5_4 = -W1e4 * W35;
    lanes_put(&dl_out[148], SZZ5_4, stream);
    const lanes QMX5_1 = E1_2e4 * V2e5 + L1_2e5 * W35 - L1_2r4 * W2e5 - E1_2e5 * V2r4;
    lanes_put(&p_out[29], QMX5_1, stream);
    const lanes QMX5_2e = C4 * V2e5 - E2_2e5 * V2r4;
    const lanes QMX5_2 = L2_2e5 * W35 + QMX5_2e - L2_2r4 * W2e5;
    lanes_put(&p_out[69], QMX5_2, stream);
    const lanes QMX5_3 = L3_2e5 * W35 + QMX5_2e - L3_2r4 * W2e5;
    lanes_put(&p_out[109], QMX5_3, stream);
    const lanes SMX5_1 = E1_2e4 * G2e5 - E1_2e5 * G2e4;
    lanes_put(&dl_out[29], SMX5_1, stream);
    const lanes SMX5_2 = C4 * G2e5 + V2e5 * I2_2e4 + W35 * J2_2e5 - E2_2e5 * G2e4 - V2r4 * I2_2e5 - W2e5 * J2_2r4;
    lanes_put(&dl_out[69], SMX5_2, stream);
    const lanes SMX5_3 = C4 * G2e5 + V2e5 * I2_2e4 + W35 * J3_2e5 - E2_2e5 * G2e4 - V2r4 * I2_2e5 - W2e5 * J3_2r4;
    lanes_put(&dl_out[109], SMX5_3, stream);
    const lanes SMX5_4 = C5 * G2e4 + V1r4 * W2e5 + W35 * J4_2e5 - W1e4 * V2e5 - V2r4 * I4_2e5;
    lanes_put(&dl_out[149], SMX5_4, stream);
    const lanes SMX5_5 = V2r4 * W1e5 + G2e5 - V1e5 * W35;
    lanes_put(&dl_out[189], SMX5_5, stream);
    const lanes QMY5_1 = L1_2r4 * W1e5 + E1_1e5 * V2r4 - E1_2e4 * V1e5 - L1_1e5 * W35;
    lanes_put(&p_out[30], QMY5_1, stream);
    const lanes QMY5_2e = E2_1e5 * V2r4 - C4 * V1e5;
    const lanes QMY5_2 = L2_2r4 * W1e5 + QMY5_2e - L2_1e5 * W35;
    lanes_put(&p_out[70], QMY5_2, stream);
    const lanes QMY5_3 = L3_2r4 * W1e5 + QMY5_2e - L3_1e5 * W35;
    lanes_put(&p_out[110], QMY5_3, stream);
    const lanes SMY5_1 = E1_1e5 * G2e4 - E1_2e4 * G1e5;
    lanes_put(&dl_out[30], SMY5_1, stream);
    const lanes SMY5_2 = E2_1e5 * G2e4 + V2r4 * I2_1e5 + W1e5 * J2_2r4 - C4 * G1e5 - V1e5 * I2_2e4 - W35 * J2_1e5;
    lanes_put(&dl_out[70], SMY5_2, stream);
    const lanes SMY5_3 = E2_1e5 * G2e4 + V2r4 * I2_1e5 + W1e5 * J3_2r4 - C4 * G1e5 - V1e5 * I2_2e4 - W35 * J3_1e5;
    lanes_put(&dl_out[110], SMY5_3, stream);
    const lanes SMY5_4 = W1e4 * V1e5 + V2r4 * I4_1e5 - S5 * G2e4 - V1r4 * W1e5 - W35 * J4_1e5;
    lanes_put(&dl_out[150], SMY5_4, stream);
    const lanes SMY5_5 = V2r4 * W2e5 - V2e5 * W35 - G1e5;
    lanes_put(&dl_out[190], SMY5_5, stream);
    const lanes QXX6_1 = E1_1e6 * W1e6;
    lanes_put(&p_out[32], QXX6_1, stream);
    const lanes QXX6_2e = E2_1e6 * W1e6;
    lanes_put(&p_out[72], QXX6_2e, stream);
    lanes_put(&p_out[112], QXX6_2e, stream);
    const lanes QXX6_4 = E4_1e6 * W1e6;
    lanes_put(&p_out[152], QXX6_4, stream);
    const lanes QXX6_5 = S6 * W1e6;
    lanes_put(&p_out[192], QXX6_5, stream);
    const lanes SXX6_2 = W1e6 * I2_1e6;
    lanes_put(&dl_out[72], SXX6_2, stream);
    lanes_put(&dl_out[112], SXX6_2, stream);
    const lanes SXX6_4 = W1e6 * I4_1e6;
    lanes_put(&dl_out[152], SXX6_4, stream);
    const lanes SXX6_5 = W1e6 * I5_1e6;
    lanes_put(&dl_out[192], SXX6_5, stream);
    const lanes SXX6_6 = W1e6 * W2e6;
    lanes_put(&dl_out[232], SXX6_6, stream);
    const lanes QXY6_1 = E1_1e6 * W2e6 + E1_2e6 * W1e6;
    lanes_put(&p_out[33], QXY6_1, stream);
    const lanes QXY6_2e = E2_1e6 * W2e6 + E2_2e6 * W1e6;
    lanes_put(&p_out[73], QXY6_2e, stream);
    lanes_put(&p_out[113], QXY6_2e, stream);
    const lanes QXY6_4 = E4_1e6 * W2e6 + E4_2e6 * W1e6;
    lanes_put(&p_out[153], QXY6_4, stream);
    const lanes QXY6_5 = C6 * W1e6 + S6 * W2e6;
    lanes_put(&p_out[193], QXY6_5, stream);
    const lanes SXY6_2 = W1e6 * I2_2e6 + W2e6 * I2_1e6;
    lanes_put(&dl_out[73], SXY6_2, stream);
    lanes_put(&dl_out[113], SXY6_2, stream);
    const lanes SXY6_4 = W1e6 * I4_2e6 + W2e6 * I4_1e6;
    lanes_put(&dl_out[153], SXY6_4, stream);
    const lanes SXY6_5 = W1e6 * I5_2e6 + W2e6 * I5_1e6;
    lanes_put(&dl_out[193], SXY6_5, stream);
    const lanes SXY6_6 = W2e6 * W2e6 - W1e6 * W1e6;
    lanes_put(&dl_out[233], SXY6_6, stream);
    const lanes QXZ6_1 = E1_1e6 * W36 - E1_2e5 * W1e6;
    lanes_put(&p_out[34], QXZ6_1, stream);
    const lanes QXZ6_2e = E2_1e6 * W36 - E2_2e5 * W1e6;
    lanes_put(&p_out[74], QXZ6_2e, stream);
    lanes_put(&p_out[114], QXZ6_2e, stream);
    const lanes QXZ6_4 = C5 * W1e6 + E4_1e6 * W36;
    lanes_put(&p_out[154], QXZ6_4, stream);
    const lanes QXZ6_5 = S6 * W36;
    lanes_put(&p_out[194], QXZ6_5, stream);
    const lanes SXZ6_2 = W36 * I2_1e6 - W1e6 * I2_2e5;
    lanes_put(&dl_out[74], SXZ6_2, stream);
    lanes_put(&dl_out[114], SXZ6_2, stream);
    const lanes SXZ6_4 = W36 * I4_1e6 - W1e6 * I4_2e5;
    lanes_put(&dl_out[154], SXZ6_4, stream);
    const lanes SXZ6_5 = W1e5 * W1e6 + W36 * I5_1e6;
    lanes_put(&dl_out[194], SXZ6_5, stream);
    const lanes SXZ6_6 = W2e6 * W36;
    lanes_put(&dl_out[234], SXZ6_6, stream);
    const lanes QYZ6_1 = E1_2e6 * W36 - E1_2e5 * W2e6;
    lanes_put(&p_out[35], QYZ6_1, stream);
    const lanes QYZ6_2e = E2_2e6 * W36 - E2_2e5 * W2e6;
    lanes_put(&p_out[75], QYZ6_2e, stream);
    lanes_put(&p_out[115], QYZ6_2e, stream);
    const lanes QYZ6_4 = C5 * W2e6 + E4_2e6 * W36;
    lanes_put(&p_out[155], QYZ6_4, stream);
    const lanes QYZ6_5 = C6 * W36;
    lanes_put(&p_out[195], QYZ6_5, stream);
    const lanes SYZ6_2 = W36 * I2_2e6 - W2e6 * I2_2e5;
    lanes_put(&dl_out[75], SYZ6_2, stream);
    lanes_put(&dl_out[115], SYZ6_2, stream);
    const lanes SYZ6_4 = W36 * I4_2e6 - W2e6 * I4_2e5;
    lanes_put(&dl_out[155], SYZ6_4, stream);
    const lanes SYZ6_5 = W1e5 * W2e6 + W36 * I5_2e6;
    lanes_put(&dl_out[195], SYZ6_5, stream);
    const lanes SYZ6_6 = -W1e6 * W36;
    lanes_put(&dl_out[235], SYZ6_6, stream);
    const lanes QZZ6_1 = -E1_2e5 * W36;
    lanes_put(&p_out[36], QZZ6_1, stream);
    const lanes QZZ6_2e = -E2_2e5 * W36;
    lanes_put(&p_out[76], QZZ6_2e, stream);
    lanes_put(&p_out[116], QZZ6_2e, stream);
    const lanes QZZ6_4 = C5 * W36;
    lanes_put(&p_out[156], QZZ6_4, stream);
    const lanes SZZ6_2 = -W36 * I2_2e5;
    lanes_put(&dl_out[76], SZZ6_2, stream);
    lanes_put(&dl_out[116], SZZ6_2, stream);
    const lanes SZZ6_4 = -W36 * I4_2e5;
    lanes_put(&dl_out[156], SZZ6_4, stream);
    const lanes SZZ6_5 = W1e5 * W36;
    lanes_put(&dl_out[196], SZZ6_5, stream);
    const lanes QMX6_1 = L1_2e5 * W2e6 + E1_2e6 * V2e5 + L1_2e6 * W36 - E1_2e5 * V2e6;
    lanes_put(&p_out[37], QMX6_1, stream);
    const lanes QMX6_2e = E2_2e6 * V2e5 - E2_2e5 * V2e6;
    const lanes QMX6_2 = L2_2e5 * W2e6 + L2_2e6 * W36 + QMX6_2e;
    lanes_put(&p_out[77], QMX6_2, stream);
    const lanes QMX6_3 = L3_2e5 * W2e6 + L3_2e6 * W36 + QMX6_2e;
    lanes_put(&p_out[117], QMX6_3, stream);
    const lanes QMX6_4 = C5 * V2e6 + E4_2e6 * V2e5;
    lanes_put(&p_out[157], QMX6_4, stream);
    const lanes SMX6_1 = E1_2e6 * G2e5 - E1_2e5 * G2e6;
    lanes_put(&dl_out[37], SMX6_1, stream);
    const lanes SMX6_2 = E2_2e6 * G2e5 + V2e5 * I2_2e6 + W2e6 * J2_2e5 + W36 * J2_2e6 - E2_2e5 * G2e6 - V2e6 * I2_2e5;
    lanes_put(&dl_out[77], SMX6_2, stream);
    const lanes SMX6_3 = E2_2e6 * G2e5 + V2e5 * I2_2e6 + W2e6 * J3_2e5 + W36 * J3_2e6 - E2_2e5 * G2e6 - V2e6 * I2_2e5;
    lanes_put(&dl_out[117], SMX6_3, stream);
    const lanes SMX6_4 = C5 * G2e6 + E4_2e6 * G2e5 + V2e5 * I4_2e6 + W2e6 * J4_2e5 + W36 * J4_2e6 - V2e6 * I4_2e5;
    lanes_put(&dl_out[157], SMX6_4, stream);
    const lanes SMX6_5 = C6 * G2e5 + W1e5 * V2e6 + V2e5 * I5_2e6 + W36 * J5_2e6 - V1e5 * W2e6;
    lanes_put(&dl_out[197], SMX6_5, stream);
    const lanes SMX6_6 = G2e6 - V2e5 * W1e6 - V1e6 * W36;
    lanes_put(&dl_out[237], SMX6_6, stream);
    const lanes QMY6_1 = E1_2e5 * V1e6 - L1_2e5 * W1e6 - E1_1e6 * V2e5 - L1_1e6 * W36;
    lanes_put(&p_out[38], QMY6_1, stream);
    const lanes QMY6_2e = E2_2e5 * V1e6 - E2_1e6 * V2e5;
    const lanes QMY6_2 = QMY6_2e - L2_2e5 * W1e6 - L2_1e6 * W36;
    lanes_put(&p_out[78], QMY6_2, stream);
    const lanes QMY6_3 = QMY6_2e - L3_2e5 * W1e6 - L3_1e6 * W36;
    lanes_put(&p_out[118], QMY6_3, stream);
    const lanes QMY6_4 = -C5 * V1e6 - E4_1e6 * V2e5;
    lanes_put(&p_out[158], QMY6_4, stream);
    const lanes SMY6_1 = E1_2e5 * G1e6 - E1_1e6 * G2e5;
    lanes_put(&dl_out[38], SMY6_1, stream);
    const lanes SMY6_2 = E2_2e5 * G1e6 + V1e6 * I2_2e5 - E2_1e6 * G2e5 - V2e5 * I2_1e6 - W1e6 * J2_2e5 - W36 * J2_1e6;
    lanes_put(&dl_out[78], SMY6_2, stream);
    const lanes SMY6_3 = E2_2e5 * G1e6 + V1e6 * I2_2e5 - E2_1e6 * G2e5 - V2e5 * I2_1e6 - W1e6 * J3_2e5 - W36 * J3_1e6;
    lanes_put(&dl_out[118], SMY6_3, stream);
    const lanes SMY6_4 = V1e6 * I4_2e5 - C5 * G1e6 - E4_1e6 * G2e5 - V2e5 * I4_1e6 - W1e6 * J4_2e5 - W36 * J4_1e6;
    lanes_put(&dl_out[158], SMY6_4, stream);
    const lanes SMY6_5 = V1e5 * W1e6 - S6 * G2e5 - W1e5 * V1e6 - V2e5 * I5_1e6 - W36 * J5_1e6;
    lanes_put(&dl_out[198], SMY6_5, stream);
    const lanes SMY6_6 = -V2e5 * W2e6 - V2e6 * W36 - G1e6;
    lanes_put(&dl_out[238], SMY6_6, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, apart *p_out, apart *dl_out)
{
    return panel(q, qd, p_out, dl_out, 0);
}

int puma560_momentum_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes lanes_p_out[BLOCKS(240u)];
    lanes lanes_dl_out[BLOCKS(240u)];
    double scratch[240u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_p_out, 0, sizeof lanes_p_out);
    memset(lanes_dl_out, 0, sizeof lanes_dl_out);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        status |= plain(lanes_q, lanes_qd, (apart *)lanes_p_out, (apart *)lanes_dl_out);
        lanes_store(lanes_p_out, 240u, count, stream, scratch, &p_out[k * 240u]);
        lanes_store(lanes_dl_out, 240u, count, stream, scratch, &dl_out[k * 240u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_read(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_read(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        apart *lanes_p_out = (apart *)&p_out[k * 240u];
        apart *lanes_dl_out = (apart *)&dl_out[k * 240u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_p_out, lanes_dl_out, 1) : plain(lanes_q, lanes_qd, lanes_p_out, lanes_dl_out);
    }
    return status;
}

int puma560_momentum_regressor_panels(int stream, size_t N, const size_t *strides,
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

int puma560_momentum_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_momentum_regressor(&q[k * stride_q], &qd[k * stride_qd], &p_out[k * 240u], &dl_out[k * 240u]);
    }
    return status;
}

int puma560_momentum_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out)
{
    return puma560_momentum_regressor_rows(stream, N, strides, q, qd, p_out, dl_out);
}

#endif

size_t puma560_momentum_regressor_width(void)
{
    return puma560_WIDTH;
}

void puma560_momentum_regressor_batch(size_t N, const double *q, const double *qd, double *p_out, double *dl_out)
{
    (void)puma560_momentum_regressor_rows(0, N, NULL, q, qd, p_out, dl_out);
}
