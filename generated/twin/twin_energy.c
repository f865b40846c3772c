/* twin: kinetic energy T and potential energy U, U up to a constant
 * 177 mul, 89 add, 5 sincos for one sample, as written here.
 */
#include "twin.h"
#include "twin_math.h"

void twin_energy(const double q[7], const double qd[7], const double X[44], double T_out[1], double U_out[1])
{
    const double b2 = 0.6;
    const double d2 = 0.2;
    const double d3 = 0.3;
    const double r4 = 0.25;
    const double gz = 9.81;
    const twin_angles4 q_1 = twin_sincos4(&q[1]);
    const twin_angles1 q_6 = twin_sincos1(&q[6]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double C3 = q_1.c[1];
    const double S3 = q_1.s[1];
    const double C4 = q_1.c[2];
    const double S4 = q_1.s[2];
    const double C5 = q_1.c[3];
    const double S5 = q_1.s[3];
    const double R6 = q[5] + d3;
    const double C7 = q_6.c[0];
    const double S7 = q_6.s[0];
    const double V3d2 = -qd[0] * d2;
    const double W1e2 = qd[0] * S2;
    const double G1e2 = -gz * S2;
    const double W2e2 = qd[0] * C2;
    const double G2e2 = -gz * C2;
    const double V2d3 = qd[1] * d3;
    const double V3d3 = V3d2 - d3 * W2e2;
    const double W1e3 = C3 * W1e2 + S3 * W2e2;
    const double W2e3 = C3 * W2e2 - S3 * W1e2;
    const double V1e3 = S3 * V2d3;
    const double V2e3 = C3 * V2d3;
    const double W33 = qd[1] + qd[2];
    const double W1e4 = C4 * W1e3 + S4 * W33;
    const double W2e4 = C4 * W33 - S4 * W1e3;
    const double V1e4 = C4 * V1e3 + S4 * V3d3;
    const double V1r4 = r4 * W2e4 + V1e4;
    const double V2e4 = C4 * V3d3 - S4 * V1e3;
    const double V2r4 = V2e4 - r4 * W1e4;
    const double DMY3 = V3d3 * W1e3 - V1e3 * W33;
    const double DMX3 = V2e3 * W33 - V3d3 * W2e3;
    const double W34 = qd[3] - W2e3;
    const double DMX4 = V2e3 * W2e4 + W34 * V2r4;
    const double DMY4 = -V2e3 * W1e4 - W34 * V1r4;
    const double W1e5 = qd[0] * S5;
    const double G1e5 = -gz * S5;
    const double W2e5 = qd[0] * C5;
    const double G2e5 = -gz * C5;
    const double V1r6 = qd[4] * R6;
    const double V2r6 = V3d2 - R6 * W1e5;
    const double W1e7 = C7 * W1e5 + S7 * W2e5;
    const double W2e7 = C7 * W2e5 - S7 * W1e5;
    const double V1e7 = C7 * V1r6 - qd[5] * S7;
    const double V2e7 = -qd[5] * C7 - S7 * V1r6;
    const double W37 = qd[4] + qd[6];
    const double DMX7 = V2e7 * W37 - V2r6 * W2e7;
    const double DMY7 = V2r6 * W1e7 - V1e7 * W37;
    const double Ub2 = b2 * gz;
    const double Ur6 = R6 * G2e5 + Ub2;
    const double G1e3 = C3 * G1e2 + S3 * G2e2;
    const double G2e3 = C3 * G2e2 - S3 * G1e2;
    const double G1e4 = C4 * G1e3;
    const double G2e4 = -S4 * G1e3;
    const double G1e7 = C7 * G1e5 + S7 * G2e5;
    const double G2e7 = C7 * G2e5 - S7 * G1e5;
    const double Usum = X[33] * G2e5 + X[34] * Ur6 - X[6] * G1e2 - X[7] * G2e2 - X[13] * G1e3 - X[14] * G2e3 - X[21] * G1e4 - X[22] * G2e4 - X[29] * G1e5 - X[30] * G2e5 - X[31] * G1e5 - X[41] * G1e7 - X[42] * G2e7;
    U_out[0] = Usum;
    const double Hqd1 = 0.5 * qd[0];
    const double DZZ1 = qd[0] * Hqd1;
    const double HW1e2 = 0.5 * W1e2;
    const double DXX2 = W1e2 * HW1e2;
    const double DXY2 = W1e2 * W2e2;
    const double DXZ2 = qd[1] * W1e2;
    const double DMY2 = V3d2 * W1e2;
    const double DYZ2 = qd[1] * W2e2;
    const double DMX2 = -V3d2 * W2e2;
    const double Hqd2 = 0.5 * qd[1];
    const double DZZ2 = qd[1] * Hqd2;
    const double HW1e3 = 0.5 * W1e3;
    const double DXX3 = W1e3 * HW1e3;
    const double DXY3 = W1e3 * W2e3;
    const double DXZ3 = W1e3 * W33;
    const double DYZ3 = W2e3 * W33;
    const double HW33 = 0.5 * W33;
    const double DZZ3 = W33 * HW33;
    const double Hqd3 = 0.5 * qd[2];
    const double DIA3 = qd[2] * Hqd3;
    const double HW1e4 = 0.5 * W1e4;
    const double DXX4 = W1e4 * HW1e4;
    const double DXY4 = W1e4 * W2e4;
    const double DXZ4 = W1e4 * W34;
    const double DYZ4 = W2e4 * W34;
    const double HW34 = 0.5 * W34;
    const double DZZ4 = W34 * HW34;
    const double Hqd4 = 0.5 * qd[3];
    const double DIA4 = qd[3] * Hqd4;
    const double HW1e5 = 0.5 * W1e5;
    const double DXX5 = W1e5 * HW1e5;
    const double DXY5 = W1e5 * W2e5;
    const double DXZ5 = qd[4] * W1e5;
    const double DYZ5 = qd[4] * W2e5;
    const double Hqd5 = 0.5 * qd[4];
    const double DZZ5 = qd[4] * Hqd5;
    const double DMX5 = -V3d2 * W2e5;
    const double DMY5 = V3d2 * W1e5;
    const double DMX6 = -qd[4] * qd[5] - W2e5 * V2r6;
    const double DMY6 = qd[5] * W1e5 + W2e5 * V1r6;
    const double DMZ6 = qd[4] * V1r6 - W1e5 * V2r6;
    const double EDM6 = qd[5] * qd[5] + V1r6 * V1r6 + V2r6 * V2r6;
    const double DM6 = 0.5 * EDM6;
    const double Hqd6 = 0.5 * qd[5];
    const double DIA6 = qd[5] * Hqd6;
    const double HW1e7 = 0.5 * W1e7;
    const double DXX7 = W1e7 * HW1e7;
    const double DXY7 = W1e7 * W2e7;
    const double DXZ7 = W1e7 * W37;
    const double DYZ7 = W2e7 * W37;
    const double HW37 = 0.5 * W37;
    const double DZZ7 = W37 * HW37;
    const double Hqd7 = 0.5 * qd[6];
    const double DIA7 = qd[6] * Hqd7;
    const double Tsum = X[0] * DZZ1 + X[1] * DXX2 + X[2] * DXY2 + X[3] * DXZ2 + X[4] * DYZ2 + X[5] * DZZ2 + X[6] * DMX2 + X[7] * DMY2 + X[8] * DXX3 + X[9] * DXY3 + X[10] * DXZ3 + X[11] * DYZ3 + X[12] * DZZ3 + X[13] * DMX3 + X[14] * DMY3 + X[15] * DIA3 + X[16] * DXX4 + X[17] * DXY4 + X[18] * DXZ4 + X[19] * DYZ4 + X[20] * DZZ4 + X[21] * DMX4 + X[22] * DMY4 + X[23] * DIA4 + X[24] * DXX5 + X[25] * DXY5 + X[26] * DXZ5 + X[27] * DYZ5 + X[28] * DZZ5 + X[29] * DMX5 + X[30] * DMY5 + X[31] * DMX6 + X[32] * DMY6 + X[33] * DMZ6 + X[34] * DM6 + X[35] * DIA6 + X[36] * DXX7 + X[37] * DXY7 + X[38] * DXZ7 + X[39] * DYZ7 + X[40] * DZZ7 + X[41] * DMX7 + X[42] * DMY7 + X[43] * DIA7;
    T_out[0] = Tsum;
}

void twin_energy_batch(size_t N, const double *q, const double *qd, const double *X, double *T_out, double *U_out)
{
    for (size_t k = 0; k < N; ++k) {
        twin_energy(&q[k * 7u], &qd[k * 7u], X, &T_out[k * 1u], &U_out[k * 1u]);
    }
}
