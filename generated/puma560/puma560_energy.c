/* puma560: kinetic energy T and potential energy U, U up to a constant
 * 173 mul, 89 add, 5 sincos for one sample, as written here.
 */
#include "puma560.h"
#include "puma560_math.h"

void puma560_energy(const double q[6], const double qd[6], const double X[40], double T_out[1], double U_out[1])
{
    const double gz = 9.81;
    const puma560_angles4 q_1 = puma560_sincos4(&q[1]);
    const puma560_angles1 q_5 = puma560_sincos1(&q[5]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double C3 = q_1.c[1];
    const double S3 = q_1.s[1];
    const double C4 = q_1.c[2];
    const double S4 = q_1.s[2];
    const double C5 = q_1.c[3];
    const double S5 = q_1.s[3];
    const double C6 = q_5.c[0];
    const double S6 = q_5.s[0];
    const double W1e2 = -qd[0] * S2;
    const double G1e2 = gz * S2;
    const double W2e2 = -qd[0] * C2;
    const double G2e2 = gz * C2;
    const double V1r2 = puma560_geometry_R2 * W2e2;
    const double V2r2 = -puma560_geometry_R2 * W1e2;
    const double V2d3 = qd[1] * puma560_geometry_D3 + V2r2;
    const double DMX2 = qd[1] * V2r2;
    const double V3d3 = -puma560_geometry_D3 * W2e2;
    const double W1e3 = C3 * W1e2 + S3 * W2e2;
    const double W2e3 = C3 * W2e2 - S3 * W1e2;
    const double V1e3 = C3 * V1r2 + S3 * V2d3;
    const double V2e3 = C3 * V2d3 - S3 * V1r2;
    const double V1r3 = puma560_geometry_R3 * W2e3 + V1e3;
    const double V2r3 = V2e3 - puma560_geometry_R3 * W1e3;
    const double DMY2 = -qd[1] * V1r2;
    const double W33 = qd[1] + qd[2];
    const double V2d4 = V3d3 - puma560_geometry_D4 * W2e3;
    const double V3d4 = -puma560_geometry_D4 * W33 - V2r3;
    const double DMX3 = W33 * V2r3 - V3d3 * W2e3;
    const double DMY3 = V3d3 * W1e3 - W33 * V1r3;
    const double W1e4 = C4 * W1e3 + S4 * W33;
    const double W2e4 = C4 * W33 - S4 * W1e3;
    const double V1e4 = C4 * V1r3 + S4 * V2d4;
    const double V2e4 = C4 * V2d4 - S4 * V1r3;
    const double V1r4 = puma560_geometry_R4 * W2e4 + V1e4;
    const double V2r4 = V2e4 - puma560_geometry_R4 * W1e4;
    const double W34 = qd[3] - W2e3;
    const double W1e5 = C5 * W1e4 - S5 * W34;
    const double W2e5 = -C5 * W34 - S5 * W1e4;
    const double V1e5 = C5 * V1r4 - S5 * V3d4;
    const double V2e5 = -C5 * V3d4 - S5 * V1r4;
    const double DMY4 = V3d4 * W1e4 - W34 * V1r4;
    const double DMX4 = W34 * V2r4 - V3d4 * W2e4;
    const double W35 = qd[4] + W2e4;
    const double W1e6 = C6 * W1e5 + S6 * W35;
    const double W2e6 = C6 * W35 - S6 * W1e5;
    const double V1e6 = C6 * V1e5 + S6 * V2r4;
    const double V2e6 = C6 * V2r4 - S6 * V1e5;
    const double DMY5 = V2r4 * W1e5 - V1e5 * W35;
    const double DMX5 = V2e5 * W35 - V2r4 * W2e5;
    const double W36 = qd[5] - W2e5;
    const double DMX6 = V2e5 * W2e6 + V2e6 * W36;
    const double DMY6 = -V2e5 * W1e6 - V1e6 * W36;
    const double G1e3 = C3 * G1e2 + S3 * G2e2;
    const double G2e3 = C3 * G2e2 - S3 * G1e2;
    const double G1e4 = C4 * G1e3;
    const double G2e4 = -S4 * G1e3;
    const double G1e5 = C5 * G1e4 + S5 * G2e3;
    const double G2e5 = C5 * G2e3 - S5 * G1e4;
    const double G1e6 = C6 * G1e5 + S6 * G2e4;
    const double G2e6 = C6 * G2e4 - S6 * G1e5;
    const double Usum = -X[6] * G1e2 - X[7] * G2e2 - X[13] * G1e3 - X[14] * G2e3 - X[21] * G1e4 - X[22] * G2e4 - X[29] * G1e5 - X[30] * G2e5 - X[37] * G1e6 - X[38] * G2e6;
    U_out[0] = Usum;
    const double Hqd1 = 0.5 * qd[0];
    const double DZZ1 = qd[0] * Hqd1;
    const double HW1e2 = 0.5 * W1e2;
    const double DXX2 = W1e2 * HW1e2;
    const double DXY2 = W1e2 * W2e2;
    const double DXZ2 = qd[1] * W1e2;
    const double DYZ2 = qd[1] * W2e2;
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
    const double DXZ5 = W1e5 * W35;
    const double DYZ5 = W2e5 * W35;
    const double HW35 = 0.5 * W35;
    const double DZZ5 = W35 * HW35;
    const double Hqd5 = 0.5 * qd[4];
    const double DIA5 = qd[4] * Hqd5;
    const double HW1e6 = 0.5 * W1e6;
    const double DXX6 = W1e6 * HW1e6;
    const double DXY6 = W1e6 * W2e6;
    const double DXZ6 = W1e6 * W36;
    const double DYZ6 = W2e6 * W36;
    const double HW36 = 0.5 * W36;
    const double DZZ6 = W36 * HW36;
    const double Hqd6 = 0.5 * qd[5];
    const double DIA6 = qd[5] * Hqd6;
    const double Tsum = X[0] * DZZ1 + X[1] * DXX2 + X[2] * DXY2 + X[3] * DXZ2 + X[4] * DYZ2 + X[5] * DZZ2 + X[6] * DMX2 + X[7] * DMY2 + X[8] * DXX3 + X[9] * DXY3 + X[10] * DXZ3 + X[11] * DYZ3 + X[12] * DZZ3 + X[13] * DMX3 + X[14] * DMY3 + X[15] * DIA3 + X[16] * DXX4 + X[17] * DXY4 + X[18] * DXZ4 + X[19] * DYZ4 + X[20] * DZZ4 + X[21] * DMX4 + X[22] * DMY4 + X[23] * DIA4 + X[24] * DXX5 + X[25] * DXY5 + X[26] * DXZ5 + X[27] * DYZ5 + X[28] * DZZ5 + X[29] * DMX5 + X[30] * DMY5 + X[31] * DIA5 + X[32] * DXX6 + X[33] * DXY6 + X[34] * DXZ6 + X[35] * DYZ6 + X[36] * DZZ6 + X[37] * DMX6 + X[38] * DMY6 + X[39] * DIA6;
    T_out[0] = Tsum;
}

void puma560_energy_batch(size_t N, const double *q, const double *qd, const double *X, double *T_out, double *U_out)
{
    for (size_t k = 0; k < N; ++k) {
        puma560_energy(&q[k * 6u], &qd[k * 6u], X, &T_out[k * 1u], &U_out[k * 1u]);
    }
}
