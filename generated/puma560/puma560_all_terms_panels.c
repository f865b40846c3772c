/* puma560: all_terms of as many samples at once as a vector register holds. */
#include "puma560_panels.h"
#include "puma560_lanes.h"

#if puma560_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel(const lanes *q, const lanes *qd, const lanes *X, apart *M, apart *h, apart *tau, apart *J_out, apart *T_out, const int stream)
{
    (void)stream;
    const double gz = 9.81;
    lanes_put(&J_out[30], lanes_all(1.0), stream);
    lanes_put(&T_out[10], lanes_all(1.0), stream);
    lanes_put(&T_out[15], lanes_all(1.0), stream);
    lanes_put(&T_out[31], lanes_all(1.0), stream);
    lanes_put(&T_out[47], lanes_all(1.0), stream);
    lanes_put(&T_out[63], lanes_all(1.0), stream);
    lanes_put(&T_out[79], lanes_all(1.0), stream);
    lanes_put(&T_out[95], lanes_all(1.0), stream);
    turned q_0 = lanes_turn(q[0]);
    turned q_1 = lanes_turn(q[1]);
    turned q_2 = lanes_turn(q[2]);
    turned q_3 = lanes_turn(q[3]);
    turned q_4 = lanes_turn(q[4]);
    turned q_5 = lanes_turn(q[5]);
    if (lanes_any(~(mask)(lanes_abs(q[0]) + lanes_abs(q[1]) + lanes_abs(q[2]) + lanes_abs(q[3]) + lanes_abs(q[4]) + lanes_abs(q[5]) <= NEAR))) {
        q_0 = lanes_far(q[0], q_0);
        q_1 = lanes_far(q[1], q_1);
        q_2 = lanes_far(q[2], q_2);
        q_3 = lanes_far(q[3], q_3);
        q_4 = lanes_far(q[4], q_4);
        q_5 = lanes_far(q[5], q_5);
    }
    const lanes M6_6 = X[36] + X[39];
    lanes_put(&M[35], M6_6, stream);
    const lanes C2 = q_1.c;
    lanes_put(&T_out[25], -C2, stream);
    const lanes S2 = q_1.s;
    lanes_put(&T_out[24], -S2, stream);
    const lanes C3 = q_2.c;
    const lanes S3 = q_2.s;
    const lanes C4 = q_3.c;
    const lanes S4 = q_3.s;
    const lanes C5 = q_4.c;
    const lanes S5 = q_4.s;
    const lanes C6 = q_5.c;
    const lanes S6 = q_5.s;
    const lanes Te6_6 = 2.0 * X[33];
    const lanes ze6_6 = X[32] * S6 + C6 * Te6_6;
    const lanes J11e6_6 = X[32] - S6 * ze6_6;
    const lanes J11s5_6 = X[24] + J11e6_6;
    const lanes J22e6_6 = S6 * ze6_6;
    const lanes J12e6_6 = C6 * ze6_6 - X[33];
    const lanes J13s5_6 = X[26] + J12e6_6;
    const lanes J33s5_6 = X[28] + J22e6_6;
    const lanes M5_5 = X[31] + J33s5_6;
    lanes_put(&M[28], M5_5, stream);
    const lanes J13e6_6 = X[34] * C6 - X[35] * S6;
    const lanes J23e6_6 = X[34] * S6 + X[35] * C6;
    lanes_put(&M[29], J23e6_6, stream);
    lanes_put(&M[34], J23e6_6, stream);
    const lanes m6_1e6 = X[37] * C6 - X[38] * S6;
    const lanes m6_2e6 = X[37] * S6 + X[38] * C6;
    const lanes J12s5_6 = X[25] - J13e6_6;
    const lanes J23s5_6 = X[27] - J23e6_6;
    const lanes m1s5_6 = X[29] + m6_1e6;
    const lanes De5_5 = J11s5_6 - X[36];
    const lanes Te5_5 = 2.0 * J12s5_6;
    const lanes ze5_5 = C5 * Te5_5 + S5 * De5_5;
    const lanes J11e5_5 = J11s5_6 - S5 * ze5_5;
    const lanes J12e5_5 = C5 * ze5_5 - J12s5_6;
    const lanes J22e5_5 = X[36] + S5 * ze5_5;
    const lanes J11s4_5 = X[16] + J11e5_5;
    const lanes J13s4_5 = X[18] - J12e5_5;
    const lanes J33s4_5 = X[20] + J22e5_5;
    const lanes M4_4 = X[23] + J33s4_5;
    lanes_put(&M[21], M4_4, stream);
    const lanes J13e5_5 = C5 * J13s5_6 - S5 * J23s5_6;
    const lanes J23e5_5 = C5 * J23s5_6 + S5 * J13s5_6;
    lanes_put(&M[22], -J23e5_5, stream);
    lanes_put(&M[27], -J23e5_5, stream);
    const lanes m5_1e5 = C5 * m1s5_6 - X[30] * S5;
    const lanes m5_2e5 = X[30] * C5 + S5 * m1s5_6;
    const lanes J12s4_5 = X[17] + J13e5_5;
    const lanes J23s4_5 = X[19] - J23e5_5;
    const lanes m1s4_5 = X[21] + m5_1e5;
    const lanes J13r4_4 = J13s4_5 - puma560_geometry_R4 * m1s4_5;
    const lanes m2s4_5 = X[22] + m6_2e6;
    const lanes J23r4_4 = J23s4_5 - puma560_geometry_R4 * m2s4_5;
    const lanes xr4_4 = -2.0 * puma560_geometry_R4 * m5_2e5;
    const lanes J11r4_4 = J11s4_5 + xr4_4;
    const lanes J22r4_4 = J33s5_6 + xr4_4;
    const lanes Nbm52r4 = J33s5_6 - puma560_geometry_R4 * m5_2e5;
    const lanes De4_4 = J11r4_4 - J22r4_4;
    const lanes Te4_4 = 2.0 * J12s4_5;
    const lanes ze4_4 = C4 * Te4_4 + S4 * De4_4;
    const lanes J11e4_4 = J11r4_4 - S4 * ze4_4;
    const lanes J22e4_4 = S4 * ze4_4 + J22r4_4;
    const lanes J12e4_4 = C4 * ze4_4 - J12s4_5;
    const lanes J11s3_4 = X[8] + J11e4_4;
    const lanes J13e4_4 = C4 * J13r4_4 - S4 * J23r4_4;
    const lanes J23e4_4 = C4 * J23r4_4 + S4 * J13r4_4;
    lanes_put(&M[15], J23e4_4, stream);
    lanes_put(&M[20], J23e4_4, stream);
    const lanes m4_1e4 = C4 * m1s4_5 - S4 * m2s4_5;
    const lanes m4_2e4 = C4 * m2s4_5 + S4 * m1s4_5;
    const lanes J12d4_4 = J12e4_4 - puma560_geometry_D4 * m4_2e4;
    const lanes J13s3_4 = X[10] + J12d4_4;
    const lanes xd4_4 = 2.0 * puma560_geometry_D4 * m4_1e4;
    const lanes J22d4_4 = J22e4_4 + xd4_4;
    const lanes J33d4_4 = J33s4_5 + xd4_4;
    const lanes J33s3_4 = X[12] + J22d4_4;
    const lanes Nbm43d4 = puma560_geometry_D4 * m4_1e4 + J33s4_5;
    const lanes Nbm42r3 = -puma560_geometry_R3 * m4_2e4 - Nbm43d4;
    const lanes M3_3 = X[15] + J33s3_4;
    lanes_put(&M[14], M3_3, stream);
    const lanes J13d4_4 = puma560_geometry_D4 * m5_2e5 + J13e4_4;
    const lanes J12s3_4 = X[9] - J13d4_4;
    const lanes J23s3_4 = X[11] - J23e4_4;
    const lanes m1s3_4 = X[13] + m4_1e4;
    const lanes J13r3_3 = J13s3_4 - puma560_geometry_R3 * m1s3_4;
    const lanes m2s3_4 = X[14] + m5_2e5;
    const lanes J23r3_3 = J23s3_4 - puma560_geometry_R3 * m2s3_4;
    const lanes xr3_3 = 2.0 * puma560_geometry_R3 * m4_2e4;
    const lanes J11r3_3 = J11s3_4 + xr3_3;
    const lanes J22r3_3 = J33d4_4 + xr3_3;
    const lanes De3_3 = J11r3_3 - J22r3_3;
    const lanes Te3_3 = 2.0 * J12s3_4;
    const lanes ze3_3 = C3 * Te3_3 + S3 * De3_3;
    const lanes J11e3_3 = J11r3_3 - S3 * ze3_3;
    const lanes J22e3_3 = S3 * ze3_3 + J22r3_3;
    const lanes J12e3_3 = C3 * ze3_3 - J12s3_4;
    const lanes J11s2_3 = X[1] + J11e3_3;
    const lanes J13e3_3 = C3 * J13r3_3 - S3 * J23r3_3;
    const lanes J23e3_3 = C3 * J23r3_3 + S3 * J13r3_3;
    const lanes m3_1e3 = C3 * m1s3_4 - S3 * m2s3_4;
    const lanes m3_2e3 = C3 * m2s3_4 + S3 * m1s3_4;
    const lanes J12d3_3 = J12e3_3 - puma560_geometry_D3 * m3_2e3;
    const lanes J12s2_3 = X[2] + J12d3_3;
    const lanes Te2_2 = 2.0 * J12s2_3;
    const lanes Nbm33d3 = puma560_geometry_D3 * m3_1e3 + J33s3_4;
    lanes_put(&M[8], Nbm33d3, stream);
    lanes_put(&M[13], Nbm33d3, stream);
    const lanes xd3_3 = 2.0 * puma560_geometry_D3 * m3_1e3;
    const lanes J22d3_3 = J22e3_3 + xd3_3;
    const lanes J33d3_3 = J33s3_4 + xd3_3;
    const lanes J33s2_3 = X[5] + J33d3_3;
    lanes_put(&M[7], J33s2_3, stream);
    const lanes J13d3_3 = J13e3_3 - puma560_geometry_D3 * m4_2e4;
    const lanes J13s2_3 = X[3] + J13d3_3;
    const lanes Nbm31r2 = J13e3_3 - puma560_geometry_R2 * m3_1e3;
    const lanes m1s2_3 = X[6] + m3_1e3;
    const lanes J13r2_2 = J13s2_3 - puma560_geometry_R2 * m1s2_3;
    const lanes J23s2_3 = X[4] + J23e3_3;
    const lanes Nbm32r2 = J23e3_3 - puma560_geometry_R2 * m3_2e3;
    const lanes m2s2_3 = X[7] + m3_2e3;
    const lanes J23r2_2 = J23s2_3 - puma560_geometry_R2 * m2s2_3;
    const lanes J23e2_2 = C2 * J23r2_2 + S2 * J13r2_2;
    lanes_put(&M[1], -J23e2_2, stream);
    lanes_put(&M[6], -J23e2_2, stream);
    const lanes Nbm32e2 = C2 * Nbm32r2 + S2 * Nbm31r2;
    lanes_put(&M[2], -Nbm32e2, stream);
    lanes_put(&M[12], -Nbm32e2, stream);
    const lanes xr2_2 = 2.0 * puma560_geometry_R2 * m4_2e4;
    const lanes J11r2_2 = J11s2_3 + xr2_2;
    const lanes J22r2_2 = J22d3_3 + xr2_2;
    const lanes De2_2 = J11r2_2 - J22r2_2;
    const lanes ze2_2 = C2 * Te2_2 + S2 * De2_2;
    const lanes J22e2_2 = S2 * ze2_2 + J22r2_2;
    const lanes J33s1_2 = X[0] + J22e2_2;
    lanes_put(&M[0], J33s1_2, stream);
    const lanes Fbm41e3 = -C3 * m4_2e4;
    const lanes Fbm42e3 = -S3 * m4_2e4;
    const lanes Nbm43d3 = puma560_geometry_D3 * Fbm42e3 + J23e4_4;
    lanes_put(&M[9], Nbm43d3, stream);
    lanes_put(&M[19], Nbm43d3, stream);
    const lanes Nbm41e3 = C3 * J13e4_4 - S3 * Nbm42r3;
    const lanes Nbm42e3 = C3 * Nbm42r3 + S3 * J13e4_4;
    const lanes Nbm42d3 = Nbm42e3 - puma560_geometry_D3 * m4_1e4;
    const lanes Nbm41r2 = Nbm41e3 - puma560_geometry_R2 * Fbm42e3;
    const lanes Nbm42r2 = puma560_geometry_R2 * Fbm41e3 + Nbm42d3;
    const lanes Nbm42e2 = C2 * Nbm42r2 + S2 * Nbm41r2;
    lanes_put(&M[3], -Nbm42e2, stream);
    lanes_put(&M[18], -Nbm42e2, stream);
    const lanes Fbm51e4 = -C4 * m5_2e5;
    const lanes Fbm52e4 = -S4 * m5_2e5;
    const lanes Nbm53d4 = puma560_geometry_D4 * Fbm52e4 - J23e5_5;
    const lanes Nbm52r3 = puma560_geometry_R3 * Fbm51e4 - Nbm53d4;
    const lanes Nbm51e4 = C4 * J13e5_5 - S4 * Nbm52r4;
    const lanes Nbm52e4 = C4 * Nbm52r4 + S4 * J13e5_5;
    const lanes Nbm52d4 = puma560_geometry_D4 * m5_1e5 + Nbm52e4;
    lanes_put(&M[16], Nbm52d4, stream);
    lanes_put(&M[26], Nbm52d4, stream);
    const lanes Nbm51r3 = Nbm51e4 - puma560_geometry_R3 * m5_1e5;
    const lanes Fbm51e3 = C3 * Fbm51e4 - S3 * m5_1e5;
    const lanes Fbm52e3 = C3 * m5_1e5 + S3 * Fbm51e4;
    const lanes Nbm53d3 = puma560_geometry_D3 * Fbm52e3 + Nbm52d4;
    lanes_put(&M[10], Nbm53d3, stream);
    lanes_put(&M[25], Nbm53d3, stream);
    const lanes Nbm51e3 = C3 * Nbm51r3 - S3 * Nbm52r3;
    const lanes Nbm52e3 = C3 * Nbm52r3 + S3 * Nbm51r3;
    const lanes Nbm52d3 = Nbm52e3 - puma560_geometry_D3 * Fbm52e4;
    const lanes Nbm51r2 = Nbm51e3 - puma560_geometry_R2 * Fbm52e3;
    const lanes Nbm52r2 = puma560_geometry_R2 * Fbm51e3 + Nbm52d3;
    const lanes Nbm52e2 = C2 * Nbm52r2 + S2 * Nbm51r2;
    lanes_put(&M[4], -Nbm52e2, stream);
    lanes_put(&M[24], -Nbm52e2, stream);
    const lanes Fbm61e5 = -C5 * m6_2e6;
    const lanes Fbm62e5 = -S5 * m6_2e6;
    const lanes Nbm62r4 = puma560_geometry_R4 * Fbm61e5 + J23e6_6;
    const lanes Nbm61e5 = X[36] * S5 + C5 * J13e6_6;
    const lanes Nbm62e5 = S5 * J13e6_6 - X[36] * C5;
    lanes_put(&M[23], -Nbm62e5, stream);
    lanes_put(&M[33], -Nbm62e5, stream);
    const lanes Nbm61r4 = Nbm61e5 - puma560_geometry_R4 * m6_1e6;
    const lanes Fbm61e4 = C4 * Fbm61e5 - S4 * m6_1e6;
    const lanes Fbm62e4 = C4 * m6_1e6 + S4 * Fbm61e5;
    const lanes Nbm63d4 = puma560_geometry_D4 * Fbm62e4 - Nbm62e5;
    const lanes Nbm62r3 = puma560_geometry_R3 * Fbm61e4 - Nbm63d4;
    const lanes Nbm61e4 = C4 * Nbm61r4 - S4 * Nbm62r4;
    const lanes Nbm62e4 = C4 * Nbm62r4 + S4 * Nbm61r4;
    const lanes Nbm62d4 = puma560_geometry_D4 * Fbm62e5 + Nbm62e4;
    lanes_put(&M[17], Nbm62d4, stream);
    lanes_put(&M[32], Nbm62d4, stream);
    const lanes Nbm61r3 = Nbm61e4 - puma560_geometry_R3 * Fbm62e5;
    const lanes Fbm61e3 = C3 * Fbm61e4 - S3 * Fbm62e5;
    const lanes Fbm62e3 = C3 * Fbm62e5 + S3 * Fbm61e4;
    const lanes Nbm63d3 = puma560_geometry_D3 * Fbm62e3 + Nbm62d4;
    lanes_put(&M[11], Nbm63d3, stream);
    lanes_put(&M[31], Nbm63d3, stream);
    const lanes Nbm61e3 = C3 * Nbm61r3 - S3 * Nbm62r3;
    const lanes Nbm62e3 = C3 * Nbm62r3 + S3 * Nbm61r3;
    const lanes Nbm62d3 = Nbm62e3 - puma560_geometry_D3 * Fbm62e4;
    const lanes Nbm61r2 = Nbm61e3 - puma560_geometry_R2 * Fbm62e3;
    const lanes Nbm62r2 = puma560_geometry_R2 * Fbm61e3 + Nbm62d3;
    const lanes Nbm62e2 = C2 * Nbm62r2 + S2 * Nbm61r2;
    lanes_put(&M[5], -Nbm62e2, stream);
    lanes_put(&M[30], -Nbm62e2, stream);
    const lanes W1e2 = -qd[0] * S2;
    const lanes W2e2 = -qd[0] * C2;
    const lanes Z1e2 = -gz * S2;
    const lanes Z2e2 = -gz * C2;
    const lanes X12 = qd[1] * W2e2;
    const lanes X22 = -qd[1] * W1e2;
    const lanes ZP11r2 = W1e2 * W1e2;
    const lanes ZP22r2 = W2e2 * W2e2;
    const lanes ZA3r2 = ZP11r2 + ZP22r2;
    const lanes Z3r2 = -puma560_geometry_R2 * ZA3r2;
    const lanes ZP12d3 = W1e2 * W2e2;
    const lanes ZA3d3 = -2.0 * X22;
    const lanes ZP33d3 = qd[1] * qd[1];
    const lanes ZA1d3 = ZP22r2 + ZP33d3;
    const lanes Z2d3 = puma560_geometry_D3 * ZP12d3 + Z2e2;
    const lanes Z3d3 = puma560_geometry_D3 * ZA3d3 + Z3r2;
    const lanes Z1d3 = Z1e2 - puma560_geometry_D3 * ZA1d3;
    const lanes F2_1 = X[7] * ZP12d3 - X[6] * ZA1d3;
    const lanes W1e3 = C3 * W1e2 + S3 * W2e2;
    const lanes W2e3 = C3 * W2e2 - S3 * W1e2;
    const lanes X1e3 = C3 * X12 + S3 * X22;
    const lanes X13 = qd[2] * W2e3 + X1e3;
    const lanes X2e3 = C3 * X22 - S3 * X12;
    const lanes X23 = X2e3 - qd[2] * W1e3;
    const lanes Z1e3 = C3 * Z1d3 + S3 * Z2d3;
    const lanes Z2e3 = C3 * Z2d3 - S3 * Z1d3;
    const lanes W33 = qd[1] + qd[2];
    const lanes ZP13r3 = W1e3 * W33;
    const lanes ZA1r3 = X23 + ZP13r3;
    const lanes Z1r3 = puma560_geometry_R3 * ZA1r3 + Z1e3;
    const lanes ZP23r3 = W2e3 * W33;
    const lanes ZA2r3 = ZP23r3 - X13;
    const lanes Z2r3 = puma560_geometry_R3 * ZA2r3 + Z2e3;
    const lanes ZP11r3 = W1e3 * W1e3;
    const lanes ZP22r3 = W2e3 * W2e3;
    const lanes ZA3r3 = ZP11r3 + ZP22r3;
    const lanes Z3r3 = Z3d3 - puma560_geometry_R3 * ZA3r3;
    const lanes ZA2d4 = ZP13r3 - X23;
    const lanes ZP13d4 = -W1e3 * W2e3;
    const lanes W34 = qd[3] - W2e3;
    const lanes ZP22d4 = W33 * W33;
    const lanes ZA1d4 = ZP22r3 + ZP22d4;
    const lanes Z2d4 = puma560_geometry_D4 * ZA2d4 + Z3r3;
    const lanes Z3d4 = puma560_geometry_D4 * ZP13d4 - Z2r3;
    const lanes Z1d4 = Z1r3 - puma560_geometry_D4 * ZA1d4;
    const lanes F3_1 = -X[13] * ZA1d4 - X[14] * ZP13d4;
    const lanes W1e4 = C4 * W1e3 + S4 * W33;
    const lanes W2e4 = C4 * W33 - S4 * W1e3;
    const lanes X1e4 = C4 * X13;
    const lanes X14 = qd[3] * W2e4 + X1e4;
    const lanes X2e4 = -S4 * X13;
    const lanes X24 = X2e4 - qd[3] * W1e4;
    const lanes Z1e4 = C4 * Z1d4 + S4 * Z2d4;
    const lanes Z2e4 = C4 * Z2d4 - S4 * Z1d4;
    const lanes ZP13r4 = W1e4 * W34;
    const lanes ZA1r4 = X24 + ZP13r4;
    const lanes Z1r4 = puma560_geometry_R4 * ZA1r4 + Z1e4;
    const lanes ZP23r4 = W2e4 * W34;
    const lanes ZA2r4 = ZP23r4 - X14;
    const lanes Z2r4 = puma560_geometry_R4 * ZA2r4 + Z2e4;
    const lanes ZP11r4 = W1e4 * W1e4;
    const lanes ZP22r4 = W2e4 * W2e4;
    const lanes ZA3r4 = ZP11r4 + ZP22r4;
    const lanes Z3r4 = Z3d4 - puma560_geometry_R4 * ZA3r4;
    const lanes W1e5 = C5 * W1e4 - S5 * W34;
    const lanes W2e5 = -C5 * W34 - S5 * W1e4;
    const lanes P124 = W1e4 * W2e4;
    const lanes W35 = qd[4] + W2e4;
    const lanes P334 = W34 * W34;
    const lanes X1e5 = C5 * X14 + S5 * X23;
    const lanes X15 = qd[4] * W2e5 + X1e5;
    const lanes X2e5 = C5 * X23 - S5 * X14;
    const lanes X25 = X2e5 - qd[4] * W1e5;
    const lanes Z1e5 = C5 * Z1r4 - S5 * Z3r4;
    const lanes Z2e5 = -C5 * Z3r4 - S5 * Z1r4;
    const lanes W1e6 = C6 * W1e5 + S6 * W35;
    const lanes W2e6 = C6 * W35 - S6 * W1e5;
    const lanes X1e6 = C6 * X15 + S6 * X24;
    const lanes X16 = qd[5] * W2e6 + X1e6;
    const lanes X2e6 = C6 * X24 - S6 * X15;
    const lanes X26 = X2e6 - qd[5] * W1e6;
    const lanes Z1e6 = C6 * Z1e5 + S6 * Z2r4;
    const lanes Z2e6 = C6 * Z2r4 - S6 * Z1e5;
    const lanes W36 = qd[5] - W2e5;
    const lanes Q22 = ZP11r2 + ZP33d3;
    const lanes F2_2 = X[6] * ZP12d3 - X[7] * Q22;
    const lanes A322 = 2.0 * X12;
    const lanes B12 = ZP22r2 - ZP33d3;
    const lanes B22 = ZP33d3 - ZP11r2;
    const lanes B32 = ZP11r2 - ZP22r2;
    const lanes N2_1 = X[1] * X12 + X[3] * ZP12d3 + X[4] * B12 + X[5] * X12 + X[7] * Z3r2 - X[2] * ZA3d3;
    const lanes N2_3 = X[2] * B32 + X[6] * Z2e2 - X[1] * ZP12d3 - X[7] * Z1e2;
    const lanes J31_2 = X[1] - X[5];
    const lanes N2_2 = X[2] * A322 + X[3] * B22 - X[4] * ZP12d3 - X[6] * Z3r2 - X22 * J31_2;
    const lanes Q23 = ZP11r3 + ZP22d4;
    const lanes F3_2 = -X[13] * ZP13d4 - X[14] * Q23;
    const lanes A323 = X13 + ZP23r3;
    const lanes B13 = ZP22r3 - ZP22d4;
    const lanes B23 = ZP22d4 - ZP11r3;
    const lanes B33 = ZP11r3 - ZP22r3;
    const lanes N3_1 = X[8] * X13 + X[11] * B13 + X[12] * ZP23r3 + X[14] * Z3r3 - X[9] * ZA2d4 - X[10] * ZP13d4;
    const lanes F3_3 = X[13] * ZA2d4 + X[14] * A323;
    const lanes N3_3 = X[8] * ZP13d4 + X[9] * B33 + X[11] * ZA1r3 + X[13] * Z2r3 - X[10] * ZA2r3 - X[14] * Z1r3;
    const lanes J31_3 = X[8] - X[12];
    const lanes N3_2 = X[9] * A323 + X[10] * B23 + X[11] * ZP13d4 + ZP13r3 * J31_3 - X[13] * Z3r3;
    const lanes Q14 = ZP22r4 + P334;
    const lanes A214 = P124 - X23;
    const lanes A314 = ZP13r4 - X24;
    const lanes Q24 = ZP11r4 + P334;
    const lanes F4_2 = X[21] * A214 - X[22] * Q24;
    const lanes A324 = X14 + ZP23r4;
    const lanes A124 = X23 + P124;
    const lanes F4_1 = X[22] * A124 - X[21] * Q14;
    const lanes B14 = ZP22r4 - P334;
    const lanes B24 = P334 - ZP11r4;
    const lanes B34 = ZP11r4 - ZP22r4;
    const lanes N4_1 = X[16] * X14 + X[18] * A214 + X[19] * B14 + X[20] * ZP23r4 + X[22] * Z3r4 - X[17] * A314;
    const lanes F4_3 = X[21] * A314 + X[22] * A324;
    const lanes N4_3 = X[17] * B34 + X[19] * ZA1r4 + X[21] * Z2r4 - X[16] * P124 - X[18] * ZA2r4 - X[20] * X23 - X[22] * Z1r4;
    const lanes J31_4 = X[16] - X[20];
    const lanes N4_2 = X[17] * A324 + X[18] * B24 + ZP13r4 * J31_4 - X[19] * A124 - X[21] * Z3r4;
    const lanes P115 = W1e5 * W1e5;
    const lanes P125 = W1e5 * W2e5;
    const lanes P135 = W1e5 * W35;
    const lanes P225 = W2e5 * W2e5;
    const lanes P235 = W2e5 * W35;
    const lanes P335 = W35 * W35;
    const lanes Q15 = P225 + P335;
    const lanes A215 = X24 + P125;
    const lanes A315 = P135 - X25;
    const lanes Q25 = P115 + P335;
    const lanes F5_2 = X[29] * A215 - X[30] * Q25;
    const lanes A325 = X15 + P235;
    const lanes A125 = P125 - X24;
    const lanes F5_1 = X[30] * A125 - X[29] * Q15;
    const lanes A3215 = X25 + P135;
    const lanes B15 = P225 - P335;
    const lanes B25 = P335 - P115;
    const lanes B35 = P115 - P225;
    const lanes N5_1 = X[24] * X15 + X[26] * A215 + X[27] * B15 + X[28] * P235 + X[30] * Z2r4 - X[25] * A315;
    const lanes A3125 = X15 - P235;
    const lanes F5_3 = X[29] * A315 + X[30] * A325;
    const lanes N5_3 = X[25] * B35 + X[26] * A3125 + X[27] * A3215 + X[28] * X24 + X[29] * Z2e5 - X[24] * P125 - X[30] * Z1e5;
    const lanes J31_5 = X[24] - X[28];
    const lanes N5_2 = X[25] * A325 + X[26] * B25 + P135 * J31_5 - X[27] * A125 - X[29] * Z2r4;
    const lanes P116 = W1e6 * W1e6;
    const lanes P126 = W1e6 * W2e6;
    const lanes P136 = W1e6 * W36;
    const lanes P226 = W2e6 * W2e6;
    const lanes P236 = W2e6 * W36;
    const lanes P336 = W36 * W36;
    const lanes Q16 = P226 + P336;
    const lanes A216 = P126 - X25;
    const lanes A316 = P136 - X26;
    const lanes A3216 = X26 + P136;
    const lanes Q26 = P116 + P336;
    const lanes F6_2 = X[37] * A216 - X[38] * Q26;
    const lanes A326 = X16 + P236;
    const lanes A126 = X25 + P126;
    const lanes F6_1 = X[38] * A126 - X[37] * Q16;
    const lanes B16 = P226 - P336;
    const lanes B26 = P336 - P116;
    const lanes B36 = P116 - P226;
    const lanes N6_1 = X[32] * X16 + X[34] * A216 + X[35] * B16 + X[36] * P236 - X[33] * A316 - X[38] * Z2e5;
    const lanes A3126 = X16 - P236;
    const lanes F6_3 = X[37] * A316 + X[38] * A326;
    const lanes N6_3 = X[33] * B36 + X[34] * A3126 + X[35] * A3216 + X[37] * Z2e6 - X[32] * P126 - X[36] * X25 - X[38] * Z1e6;
    const lanes Fs5_6_2 = F5_2 - F6_3;
    const lanes Ns5_6_2 = N5_2 - N6_3;
    const lanes J31_6 = X[32] - X[36];
    const lanes N6_2 = X[33] * A326 + X[34] * B26 + X[37] * Z2e5 + P136 * J31_6 - X[35] * A126;
    const lanes Fb1e6 = C6 * F6_1 - S6 * F6_2;
    const lanes Fb2e6 = C6 * F6_2 + S6 * F6_1;
    const lanes Fs5_6_1 = F5_1 + Fb1e6;
    const lanes Fs5_6_3 = F5_3 + Fb2e6;
    const lanes Fs4_5_2 = F4_2 + Fs5_6_3;
    const lanes Nb1e6 = C6 * N6_1 - S6 * N6_2;
    const lanes Nb2e6 = C6 * N6_2 + S6 * N6_1;
    const lanes Ns5_6_1 = N5_1 + Nb1e6;
    const lanes Ns5_6_3 = N5_3 + Nb2e6;
    const lanes Ns4_5_2 = N4_2 + Ns5_6_3;
    const lanes Fb1e5 = C5 * Fs5_6_1 - S5 * Fs5_6_2;
    const lanes Fb2e5 = C5 * Fs5_6_2 + S5 * Fs5_6_1;
    const lanes Fs4_5_1 = F4_1 + Fb1e5;
    const lanes Fs4_5_3 = F4_3 - Fb2e5;
    const lanes Nb2r4 = puma560_geometry_R4 * Fs4_5_1 + Ns4_5_2;
    const lanes Fs3_4_2 = F3_2 - Fs4_5_3;
    const lanes Nb1e5 = C5 * Ns5_6_1 - S5 * Ns5_6_2;
    const lanes Nb2e5 = C5 * Ns5_6_2 + S5 * Ns5_6_1;
    const lanes Ns4_5_1 = N4_1 + Nb1e5;
    const lanes Ns4_5_3 = N4_3 - Nb2e5;
    const lanes Nb1r4 = Ns4_5_1 - puma560_geometry_R4 * Fs4_5_2;
    const lanes Fb1e4 = C4 * Fs4_5_1 - S4 * Fs4_5_2;
    const lanes Fb2e4 = C4 * Fs4_5_2 + S4 * Fs4_5_1;
    const lanes Fs3_4_1 = F3_1 + Fb1e4;
    const lanes Fs3_4_3 = F3_3 + Fb2e4;
    const lanes Nb3d4 = puma560_geometry_D4 * Fb2e4 + Ns4_5_3;
    const lanes Ns3_4_2 = N3_2 - Nb3d4;
    const lanes Nb2r3 = puma560_geometry_R3 * Fs3_4_1 + Ns3_4_2;
    const lanes Nb1e4 = C4 * Nb1r4 - S4 * Nb2r4;
    const lanes Nb2e4 = C4 * Nb2r4 + S4 * Nb1r4;
    const lanes Nb2d4 = Nb2e4 - puma560_geometry_D4 * Fs4_5_3;
    const lanes Ns3_4_1 = N3_1 + Nb1e4;
    const lanes Ns3_4_3 = N3_3 + Nb2d4;
    const lanes Nb1r3 = Ns3_4_1 - puma560_geometry_R3 * Fs3_4_2;
    const lanes Fb1e3 = C3 * Fs3_4_1 - S3 * Fs3_4_2;
    const lanes Fb2e3 = C3 * Fs3_4_2 + S3 * Fs3_4_1;
    const lanes Fs2_3_1 = F2_1 + Fb1e3;
    const lanes Fs2_3_2 = F2_2 + Fb2e3;
    const lanes Nb3d3 = puma560_geometry_D3 * Fb2e3 + Ns3_4_3;
    const lanes Ns2_3_3 = N2_3 + Nb3d3;
    const lanes Nb1e3 = C3 * Nb1r3 - S3 * Nb2r3;
    const lanes Nb2e3 = C3 * Nb2r3 + S3 * Nb1r3;
    const lanes Nb2d3 = Nb2e3 - puma560_geometry_D3 * Fs3_4_3;
    const lanes Ns2_3_1 = N2_1 + Nb1e3;
    const lanes Ns2_3_2 = N2_2 + Nb2d3;
    const lanes Nb1r2 = Ns2_3_1 - puma560_geometry_R2 * Fs2_3_2;
    const lanes Nb2r2 = puma560_geometry_R2 * Fs2_3_1 + Ns2_3_2;
    const lanes Nb2e2 = C2 * Nb2r2 + S2 * Nb1r2;
    const lanes sFS1 = lanes_sign(qd[0]);
    const lanes T1 = qd[0] * X[41] + X[40] * sFS1 - Nb2e2;
    lanes_put(&h[0], T1, stream);
    const lanes sFS2 = lanes_sign(qd[1]);
    const lanes T2 = qd[1] * X[43] + X[42] * sFS2 + Ns2_3_3;
    lanes_put(&h[1], T2, stream);
    const lanes sFS3 = lanes_sign(qd[2]);
    const lanes T3 = qd[2] * X[45] + X[44] * sFS3 + Ns3_4_3;
    lanes_put(&h[2], T3, stream);
    const lanes sFS4 = lanes_sign(qd[3]);
    const lanes T4 = qd[3] * X[47] + X[46] * sFS4 + Ns4_5_3;
    lanes_put(&h[3], T4, stream);
    const lanes sFS5 = lanes_sign(qd[4]);
    const lanes T5 = qd[4] * X[49] + X[48] * sFS5 + Ns5_6_3;
    lanes_put(&h[4], T5, stream);
    const lanes sFS6 = lanes_sign(qd[5]);
    const lanes T6 = qd[5] * X[51] + X[50] * sFS6 + N6_3;
    lanes_put(&h[5], T6, stream);
    const lanes Z1e3_ = C3 * Z1e2 + S3 * Z2e2;
    const lanes Z2e3_ = C3 * Z2e2 - S3 * Z1e2;
    const lanes N2_3_ = X[6] * Z2e2 - X[7] * Z1e2;
    const lanes Z1e4_ = C4 * Z1e3_;
    const lanes Z2e4_ = -S4 * Z1e3_;
    const lanes N3_3_ = X[13] * Z2e3_ - X[14] * Z1e3_;
    const lanes Z1e5_ = C5 * Z1e4_ + S5 * Z2e3_;
    const lanes Z2e5_ = C5 * Z2e3_ - S5 * Z1e4_;
    const lanes N4_3_ = X[21] * Z2e4_ - X[22] * Z1e4_;
    const lanes Z1e6_ = C6 * Z1e5_ + S6 * Z2e4_;
    const lanes Z2e6_ = C6 * Z2e4_ - S6 * Z1e5_;
    const lanes N5_3_ = X[29] * Z2e5_ - X[30] * Z1e5_;
    const lanes N6_3_ = X[37] * Z2e6_ - X[38] * Z1e6_;
    lanes_put(&tau[5], N6_3_, stream);
    const lanes N4_1_ = -X[22] * Z2e3_;
    const lanes N4_2_ = X[21] * Z2e3_;
    const lanes N5_1_ = X[30] * Z2e4_;
    const lanes N5_2_ = -X[29] * Z2e4_;
    const lanes Ns5_6_2_ = N5_2_ - N6_3_;
    const lanes N6_1_ = -X[38] * Z2e5_;
    const lanes N6_2_ = X[37] * Z2e5_;
    const lanes Nb1e6_ = C6 * N6_1_ - S6 * N6_2_;
    const lanes Nb2e6_ = C6 * N6_2_ + S6 * N6_1_;
    const lanes Ns5_6_1_ = N5_1_ + Nb1e6_;
    const lanes Ns5_6_3_ = N5_3_ + Nb2e6_;
    lanes_put(&tau[4], Ns5_6_3_, stream);
    const lanes Ns4_5_2_ = N4_2_ + Ns5_6_3_;
    const lanes Nb1e5_ = C5 * Ns5_6_1_ - S5 * Ns5_6_2_;
    const lanes Nb2e5_ = C5 * Ns5_6_2_ + S5 * Ns5_6_1_;
    const lanes Ns4_5_1_ = N4_1_ + Nb1e5_;
    const lanes Ns4_5_3_ = N4_3_ - Nb2e5_;
    lanes_put(&tau[3], Ns4_5_3_, stream);
    const lanes Nb1e4_ = C4 * Ns4_5_1_ - S4 * Ns4_5_2_;
    const lanes Nb2e4_ = C4 * Ns4_5_2_ + S4 * Ns4_5_1_;
    const lanes Ns3_4_3_ = N3_3_ + Nb2e4_;
    lanes_put(&tau[2], Ns3_4_3_, stream);
    const lanes Ns2_3_3_ = N2_3_ + Ns3_4_3_;
    lanes_put(&tau[1], Ns2_3_3_, stream);
    const lanes Nb1e3_ = C3 * Nb1e4_ + S3 * Ns4_5_3_;
    const lanes Nb2e3_ = S3 * Nb1e4_ - C3 * Ns4_5_3_;
    const lanes Nb2e2_ = C2 * Nb2e3_ + S2 * Nb1e3_;
    lanes_put(&tau[0], -Nb2e2_, stream);
    const lanes C1 = q_0.c;
    lanes_put(&J_out[25], C1, stream);
    lanes_put(&J_out[26], C1, stream);
    lanes_put(&T_out[0], C1, stream);
    lanes_put(&T_out[5], C1, stream);
    lanes_put(&T_out[22], C1, stream);
    lanes_put(&T_out[38], C1, stream);
    const lanes S1 = q_0.s;
    lanes_put(&J_out[19], -S1, stream);
    lanes_put(&J_out[20], -S1, stream);
    lanes_put(&T_out[1], -S1, stream);
    lanes_put(&T_out[4], S1, stream);
    lanes_put(&T_out[18], -S1, stream);
    lanes_put(&T_out[34], -S1, stream);
    const lanes R1e2_1 = C2 * C1;
    lanes_put(&T_out[16], R1e2_1, stream);
    const lanes R1e2_2 = C2 * S1;
    lanes_put(&T_out[20], R1e2_2, stream);
    const lanes R2e2_1 = -S2 * C1;
    lanes_put(&T_out[17], R2e2_1, stream);
    const lanes R2e2_2 = -S2 * S1;
    lanes_put(&T_out[21], R2e2_2, stream);
    const lanes pr2_1 = -puma560_geometry_R2 * S1;
    lanes_put(&T_out[19], pr2_1, stream);
    const lanes pr2_2 = puma560_geometry_R2 * C1;
    lanes_put(&T_out[23], pr2_2, stream);
    const lanes pd3_1 = puma560_geometry_D3 * R1e2_1 + pr2_1;
    const lanes pr3_1 = pd3_1 - puma560_geometry_R3 * S1;
    lanes_put(&T_out[35], pr3_1, stream);
    const lanes pd3_2 = puma560_geometry_D3 * R1e2_2 + pr2_2;
    const lanes pr3_2 = puma560_geometry_R3 * C1 + pd3_2;
    lanes_put(&T_out[39], pr3_2, stream);
    const lanes pd3_3 = -puma560_geometry_D3 * S2;
    lanes_put(&T_out[43], pd3_3, stream);
    const lanes R1e3_1 = C3 * R1e2_1 + S3 * R2e2_1;
    lanes_put(&T_out[32], R1e3_1, stream);
    const lanes R2e3_1 = C3 * R2e2_1 - S3 * R1e2_1;
    lanes_put(&J_out[21], -R2e3_1, stream);
    lanes_put(&T_out[33], R2e3_1, stream);
    lanes_put(&T_out[50], -R2e3_1, stream);
    const lanes R1e3_2 = C3 * R1e2_2 + S3 * R2e2_2;
    lanes_put(&T_out[36], R1e3_2, stream);
    const lanes R2e3_2 = C3 * R2e2_2 - S3 * R1e2_2;
    lanes_put(&J_out[27], -R2e3_2, stream);
    lanes_put(&T_out[37], R2e3_2, stream);
    lanes_put(&T_out[54], -R2e3_2, stream);
    const lanes R1e3_3 = -C2 * S3 - S2 * C3;
    lanes_put(&T_out[40], R1e3_3, stream);
    const lanes R2e3_3 = S2 * S3 - C2 * C3;
    lanes_put(&J_out[33], -R2e3_3, stream);
    lanes_put(&T_out[41], R2e3_3, stream);
    lanes_put(&T_out[58], -R2e3_3, stream);
    const lanes pd4_1 = puma560_geometry_D4 * R1e3_1 + pr3_1;
    const lanes pr4_1 = pd4_1 - puma560_geometry_R4 * R2e3_1;
    lanes_put(&J_out[6], pr4_1, stream);
    lanes_put(&T_out[51], pr4_1, stream);
    lanes_put(&T_out[67], pr4_1, stream);
    lanes_put(&T_out[83], pr4_1, stream);
    const lanes a2_1 = pr4_1 - pr2_1;
    const lanes a3_1 = pr4_1 - pr3_1;
    const lanes pd4_2 = puma560_geometry_D4 * R1e3_2 + pr3_2;
    const lanes pr4_2 = pd4_2 - puma560_geometry_R4 * R2e3_2;
    lanes_put(&J_out[0], -pr4_2, stream);
    lanes_put(&T_out[55], pr4_2, stream);
    lanes_put(&T_out[71], pr4_2, stream);
    lanes_put(&T_out[87], pr4_2, stream);
    const lanes a2_2 = pr4_2 - pr2_2;
    const lanes v2_3 = -C1 * a2_1 - S1 * a2_2;
    lanes_put(&J_out[13], v2_3, stream);
    const lanes a3_2 = pr4_2 - pr3_2;
    const lanes v3_3 = -C1 * a3_1 - S1 * a3_2;
    lanes_put(&J_out[14], v3_3, stream);
    const lanes pd4_3 = puma560_geometry_D4 * R1e3_3 + pd3_3;
    const lanes pr4_3 = pd4_3 - puma560_geometry_R4 * R2e3_3;
    lanes_put(&T_out[59], pr4_3, stream);
    lanes_put(&T_out[75], pr4_3, stream);
    lanes_put(&T_out[91], pr4_3, stream);
    const lanes v2_1 = C1 * pr4_3;
    lanes_put(&J_out[1], v2_1, stream);
    const lanes v2_2 = S1 * pr4_3;
    lanes_put(&J_out[7], v2_2, stream);
    const lanes a3_3 = pr4_3 - pd3_3;
    const lanes v3_1 = C1 * a3_3;
    lanes_put(&J_out[2], v3_1, stream);
    const lanes v3_2 = S1 * a3_3;
    lanes_put(&J_out[8], v3_2, stream);
    const lanes R1e4_1 = C4 * R1e3_1 - S4 * S1;
    lanes_put(&T_out[48], R1e4_1, stream);
    const lanes R2e4_1 = -C4 * S1 - S4 * R1e3_1;
    lanes_put(&J_out[22], R2e4_1, stream);
    lanes_put(&T_out[49], R2e4_1, stream);
    lanes_put(&T_out[66], R2e4_1, stream);
    const lanes R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
    lanes_put(&J_out[23], -R2e5_1, stream);
    lanes_put(&T_out[65], R2e5_1, stream);
    lanes_put(&T_out[82], -R2e5_1, stream);
    const lanes R1e5_1 = C5 * R1e4_1 + S5 * R2e3_1;
    lanes_put(&T_out[64], R1e5_1, stream);
    const lanes R1e6_1 = C6 * R1e5_1 + S6 * R2e4_1;
    lanes_put(&T_out[80], R1e6_1, stream);
    const lanes R2e6_1 = C6 * R2e4_1 - S6 * R1e5_1;
    lanes_put(&T_out[81], R2e6_1, stream);
    const lanes R1e4_2 = C4 * R1e3_2 + S4 * C1;
    lanes_put(&T_out[52], R1e4_2, stream);
    const lanes R2e4_2 = C4 * C1 - S4 * R1e3_2;
    lanes_put(&J_out[28], R2e4_2, stream);
    lanes_put(&T_out[53], R2e4_2, stream);
    lanes_put(&T_out[70], R2e4_2, stream);
    const lanes R1e4_3 = C4 * R1e3_3;
    lanes_put(&T_out[56], R1e4_3, stream);
    const lanes R2e4_3 = -S4 * R1e3_3;
    lanes_put(&J_out[34], R2e4_3, stream);
    lanes_put(&T_out[57], R2e4_3, stream);
    lanes_put(&T_out[74], R2e4_3, stream);
    const lanes R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
    lanes_put(&J_out[29], -R2e5_2, stream);
    lanes_put(&T_out[69], R2e5_2, stream);
    lanes_put(&T_out[86], -R2e5_2, stream);
    const lanes R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
    lanes_put(&J_out[35], -R2e5_3, stream);
    lanes_put(&T_out[73], R2e5_3, stream);
    lanes_put(&T_out[90], -R2e5_3, stream);
    const lanes R1e5_2 = C5 * R1e4_2 + S5 * R2e3_2;
    lanes_put(&T_out[68], R1e5_2, stream);
    const lanes R1e5_3 = C5 * R1e4_3 + S5 * R2e3_3;
    lanes_put(&T_out[72], R1e5_3, stream);
    const lanes R1e6_2 = C6 * R1e5_2 + S6 * R2e4_2;
    lanes_put(&T_out[84], R1e6_2, stream);
    const lanes R1e6_3 = C6 * R1e5_3 + S6 * R2e4_3;
    lanes_put(&T_out[88], R1e6_3, stream);
    const lanes R2e6_2 = C6 * R2e4_2 - S6 * R1e5_2;
    lanes_put(&T_out[85], R2e6_2, stream);
    const lanes R2e6_3 = C6 * R2e4_3 - S6 * R1e5_3;
    lanes_put(&T_out[89], R2e6_3, stream);
    return 0;
}

/* Compiled once for rows and panels. */
ONCE int plain(const lanes *q, const lanes *qd, const lanes *X, apart *M, apart *h, apart *tau, apart *J_out, apart *T_out)
{
    return panel(q, qd, X, M, h, tau, J_out, T_out, 0);
}

int puma560_all_terms_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(X, 52u, lanes_X);
    lanes lanes_M[BLOCKS(36u)];
    lanes lanes_h[BLOCKS(6u)];
    lanes lanes_tau[BLOCKS(6u)];
    lanes lanes_J_out[BLOCKS(36u)];
    lanes lanes_T_out[BLOCKS(96u)];
    double scratch[96u * puma560_WIDTH] __attribute__((aligned(64)));
    memset(lanes_M, 0, sizeof lanes_M);
    memset(lanes_h, 0, sizeof lanes_h);
    memset(lanes_tau, 0, sizeof lanes_tau);
    memset(lanes_J_out, 0, sizeof lanes_J_out);
    memset(lanes_T_out, 0, sizeof lanes_T_out);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        const size_t count = (N - k < puma560_WIDTH) ? (N - k) : puma560_WIDTH;
        if (stride_q != 0u) {
            lanes_load(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        status |= plain(lanes_q, lanes_qd, lanes_X, (apart *)lanes_M, (apart *)lanes_h, (apart *)lanes_tau, (apart *)lanes_J_out, (apart *)lanes_T_out);
        lanes_store(lanes_M, 36u, count, stream, scratch, &M[k * 36u]);
        lanes_store(lanes_h, 6u, count, stream, scratch, &h[k * 6u]);
        lanes_store(lanes_tau, 6u, count, stream, scratch, &tau[k * 6u]);
        lanes_store(lanes_J_out, 36u, count, stream, scratch, &J_out[k * 36u]);
        lanes_store(lanes_T_out, 96u, count, stream, scratch, &T_out[k * 96u]);
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    double padded_q[REACH(6u)];
    lanes lanes_q[BLOCKS(6u)];
    double padded_qd[REACH(6u)];
    lanes lanes_qd[BLOCKS(6u)];
    double padded_X[REACH(52u)];
    lanes lanes_X[BLOCKS(52u)];
    if (N == 0u) {
        return 0;
    }
    lanes_shared(q, 6u, lanes_q);
    lanes_shared(qd, 6u, lanes_qd);
    lanes_shared(X, 52u, lanes_X);
    for (size_t k = 0; k < N; k += puma560_WIDTH) {
        if (stride_q != 0u) {
            lanes_load(q, 6u, stride_q, k, N, padded_q, lanes_q);
        }
        if (stride_qd != 0u) {
            lanes_load(qd, 6u, stride_qd, k, N, padded_qd, lanes_qd);
        }
        if (stride_X != 0u) {
            lanes_load(X, 52u, stride_X, k, N, padded_X, lanes_X);
        }
        apart *lanes_M = (apart *)&M[k * 36u];
        apart *lanes_h = (apart *)&h[k * 6u];
        apart *lanes_tau = (apart *)&tau[k * 6u];
        apart *lanes_J_out = (apart *)&J_out[k * 36u];
        apart *lanes_T_out = (apart *)&T_out[k * 96u];
        status |= stream ? panel(lanes_q, lanes_qd, lanes_X, lanes_M, lanes_h, lanes_tau, lanes_J_out, lanes_T_out, 1) : plain(lanes_q, lanes_qd, lanes_X, lanes_M, lanes_h, lanes_tau, lanes_J_out, lanes_T_out);
    }
    return status;
}

int puma560_all_terms_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    if (!(streamed(stream, M) && streamed(stream, h) && streamed(stream, tau) && streamed(stream, J_out) && streamed(stream, T_out))) {
        return panels(0, N, strides, q, qd, X, M, h, tau, J_out, T_out);
    }
    const int status = panels(1, N, strides, q, qd, X, M, h, tau, J_out, T_out);
    stream_end();
    return status;
}

#else

int puma560_all_terms_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    int status = 0;
    const size_t stride_q = (strides != NULL) ? strides[0] : 6u;
    const size_t stride_qd = (strides != NULL) ? strides[1] : 6u;
    const size_t stride_X = (strides != NULL) ? strides[2] : 0u;
    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        puma560_all_terms(&q[k * stride_q], &qd[k * stride_qd], &X[k * stride_X], &M[k * 36u], &h[k * 6u], &tau[k * 6u], &J_out[k * 36u], &T_out[k * 96u]);
    }
    return status;
}

int puma560_all_terms_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    return puma560_all_terms_rows(stream, N, strides, q, qd, X, M, h, tau, J_out, T_out);
}

#endif

size_t puma560_all_terms_width(void)
{
    return puma560_WIDTH;
}

void puma560_all_terms_batch(size_t N, const double *q, const double *qd, const double *X, double *M, double *h, double *tau, double *J_out, double *T_out)
{
    (void)puma560_all_terms_rows(0, N, NULL, q, qd, X, M, h, tau, J_out, T_out);
}
