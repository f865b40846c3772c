/* rx90: columns DE + DU of kinetic plus potential energy: E + U = out . X
 * 113 mul, 42 add, 5 sincos for one sample.
 */
#include "rx90.h"

#include <math.h>

void rx90_energy_regressor(const double *q, const double *qd, double *out)
{
    const double gz = 9.81;
    const double C2 = cos(q[1]);
    const double S2 = sin(q[1]);
    const double C3 = cos(q[2]);
    const double S3 = sin(q[2]);
    const double C4 = cos(q[3]);
    const double S4 = sin(q[3]);
    const double C5 = cos(q[4]);
    const double S5 = sin(q[4]);
    const double C6 = cos(q[5]);
    const double S6 = sin(q[5]);
    const double W1e2 = qd[0] * S2;
    const double W2e2 = qd[0] * C2;
    const double G1e2 = -gz * S2;
    const double G2e2 = -gz * C2;
    const double V2d3 = qd[1] * rx90_geometry_D3;
    const double V3d3 = -rx90_geometry_D3 * W2e2;
    const double W1e3 = C3 * W1e2 + S3 * W2e2;
    const double W2e3 = C3 * W2e2 - S3 * W1e2;
    const double V1e3 = S3 * V2d3;
    const double V2e3 = C3 * V2d3;
    const double G1e3 = C3 * G1e2 + S3 * G2e2;
    const double G2e3 = C3 * G2e2 - S3 * G1e2;
    const double W33 = qd[1] + qd[2];
    const double W1e4 = C4 * W1e3 - S4 * W33;
    const double W2e4 = -C4 * W33 - S4 * W1e3;
    const double V1e4 = C4 * V1e3 - S4 * V3d3;
    const double V2e4 = -C4 * V3d3 - S4 * V1e3;
    const double G1e4 = C4 * G1e3;
    const double G2e4 = -S4 * G1e3;
    const double W34 = qd[3] + W2e3;
    const double V1r4 = rx90_geometry_R4 * W2e4 + V1e4;
    const double V2r4 = V2e4 - rx90_geometry_R4 * W1e4;
    const double W1e5 = C5 * W1e4 + S5 * W34;
    const double W2e5 = C5 * W34 - S5 * W1e4;
    const double V1e5 = C5 * V1r4 + S5 * V2e3;
    const double V2e5 = C5 * V2e3 - S5 * V1r4;
    const double G1e5 = C5 * G1e4 + S5 * G2e3;
    const double G2e5 = C5 * G2e3 - S5 * G1e4;
    const double W35 = qd[4] - W2e4;
    const double W1e6 = C6 * W1e5 - S6 * W35;
    const double W2e6 = -C6 * W35 - S6 * W1e5;
    const double V1e6 = C6 * V1e5 + S6 * V2r4;
    const double V2e6 = C6 * V2r4 - S6 * V1e5;
    const double G1e6 = C6 * G1e5 + S6 * G2e4;
    const double G2e6 = C6 * G2e4 - S6 * G1e5;
    const double W36 = qd[5] + W2e5;
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
    const double DMX3 = V2e3 * W33 - V3d3 * W2e3 - G1e3;
    const double DMY3 = V3d3 * W1e3 - V1e3 * W33 - G2e3;
    const double Hqd3 = 0.5 * qd[2];
    const double DIA3 = qd[2] * Hqd3;
    const double HW1e4 = 0.5 * W1e4;
    const double DXX4 = W1e4 * HW1e4;
    const double DXY4 = W1e4 * W2e4;
    const double DXZ4 = W1e4 * W34;
    const double DYZ4 = W2e4 * W34;
    const double HW34 = 0.5 * W34;
    const double DZZ4 = W34 * HW34;
    const double DMX4 = W34 * V2r4 - V2e3 * W2e4 - G1e4;
    const double DMY4 = V2e3 * W1e4 - G2e4 - W34 * V1r4;
    const double Hqd4 = 0.5 * qd[3];
    const double DIA4 = qd[3] * Hqd4;
    const double HW1e5 = 0.5 * W1e5;
    const double DXX5 = W1e5 * HW1e5;
    const double DXY5 = W1e5 * W2e5;
    const double DXZ5 = W1e5 * W35;
    const double DYZ5 = W2e5 * W35;
    const double HW35 = 0.5 * W35;
    const double DZZ5 = W35 * HW35;
    const double DMX5 = V2r4 * W2e5 + V2e5 * W35 - G1e5;
    const double DMY5 = -V2r4 * W1e5 - V1e5 * W35 - G2e5;
    const double Hqd5 = 0.5 * qd[4];
    const double DIA5 = qd[4] * Hqd5;
    const double HW1e6 = 0.5 * W1e6;
    const double DXX6 = W1e6 * HW1e6;
    const double DXY6 = W1e6 * W2e6;
    const double DXZ6 = W1e6 * W36;
    const double DYZ6 = W2e6 * W36;
    const double HW36 = 0.5 * W36;
    const double DZZ6 = W36 * HW36;
    const double DMX6 = V2e6 * W36 - V2e5 * W2e6 - G1e6;
    const double DMY6 = V2e5 * W1e6 - V1e6 * W36 - G2e6;
    const double Hqd6 = 0.5 * qd[5];
    const double DIA6 = qd[5] * Hqd6;
    out[0] = DZZ1;
    out[1] = DXX2;
    out[2] = DXY2;
    out[3] = DXZ2;
    out[4] = DYZ2;
    out[5] = DZZ2;
    out[6] = -G1e2;
    out[7] = -G2e2;
    out[8] = DXX3;
    out[9] = DXY3;
    out[10] = DXZ3;
    out[11] = DYZ3;
    out[12] = DZZ3;
    out[13] = DMX3;
    out[14] = DMY3;
    out[15] = DIA3;
    out[16] = DXX4;
    out[17] = DXY4;
    out[18] = DXZ4;
    out[19] = DYZ4;
    out[20] = DZZ4;
    out[21] = DMX4;
    out[22] = DMY4;
    out[23] = DIA4;
    out[24] = DXX5;
    out[25] = DXY5;
    out[26] = DXZ5;
    out[27] = DYZ5;
    out[28] = DZZ5;
    out[29] = DMX5;
    out[30] = DMY5;
    out[31] = DIA5;
    out[32] = DXX6;
    out[33] = DXY6;
    out[34] = DXZ6;
    out[35] = DYZ6;
    out[36] = DZZ6;
    out[37] = DMX6;
    out[38] = DMY6;
    out[39] = DIA6;
}

void rx90_energy_regressor_batch(size_t N, const double *q, const double *qd, double *out)
{
    for (size_t k = 0; k < N; ++k) {
        rx90_energy_regressor(&q[k * 6u], &qd[k * 6u], &out[k * 40u]);
    }
}
