/* puma560: homogeneous transforms 0T_j of all links, fixed ones included
 * 63 mul, 32 add, 6 sincos for one sample.
 */
#include "puma560.h"

#include <math.h>

void puma560_frames(const double *q, double *T_out)
{
    const double C1 = cos(q[0]);
    const double S1 = sin(q[0]);
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
    const double R1e2_1 = C1 * C2;
    const double R1e2_2 = S1 * C2;
    const double R2e2_1 = -C1 * S2;
    const double R2e2_2 = -S1 * S2;
    const double pr2_1 = -puma560_geometry_R2 * S1;
    const double pr2_2 = puma560_geometry_R2 * C1;
    const double pd3_1 = puma560_geometry_D3 * R1e2_1 + pr2_1;
    const double pd3_2 = puma560_geometry_D3 * R1e2_2 + pr2_2;
    const double pd3_3 = -puma560_geometry_D3 * S2;
    const double R1e3_1 = C3 * R1e2_1 + S3 * R2e2_1;
    const double R1e3_2 = C3 * R1e2_2 + S3 * R2e2_2;
    const double R1e3_3 = -C2 * S3 - S2 * C3;
    const double R2e3_1 = C3 * R2e2_1 - S3 * R1e2_1;
    const double R2e3_2 = C3 * R2e2_2 - S3 * R1e2_2;
    const double R2e3_3 = S2 * S3 - C2 * C3;
    const double pr3_1 = pd3_1 - puma560_geometry_R3 * S1;
    const double pr3_2 = puma560_geometry_R3 * C1 + pd3_2;
    const double pd4_1 = puma560_geometry_D4 * R1e3_1 + pr3_1;
    const double pd4_2 = puma560_geometry_D4 * R1e3_2 + pr3_2;
    const double pd4_3 = puma560_geometry_D4 * R1e3_3 + pd3_3;
    const double R1e4_1 = C4 * R1e3_1 - S1 * S4;
    const double R1e4_2 = C1 * S4 + C4 * R1e3_2;
    const double R1e4_3 = C4 * R1e3_3;
    const double R2e4_1 = -S1 * C4 - S4 * R1e3_1;
    const double R2e4_2 = C1 * C4 - S4 * R1e3_2;
    const double R2e4_3 = -S4 * R1e3_3;
    const double pr4_1 = pd4_1 - puma560_geometry_R4 * R2e3_1;
    const double pr4_2 = pd4_2 - puma560_geometry_R4 * R2e3_2;
    const double pr4_3 = pd4_3 - puma560_geometry_R4 * R2e3_3;
    const double R1e5_1 = C5 * R1e4_1 + S5 * R2e3_1;
    const double R1e5_2 = C5 * R1e4_2 + S5 * R2e3_2;
    const double R1e5_3 = C5 * R1e4_3 + S5 * R2e3_3;
    const double R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
    const double R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
    const double R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
    const double R1e6_1 = C6 * R1e5_1 + S6 * R2e4_1;
    const double R1e6_2 = C6 * R1e5_2 + S6 * R2e4_2;
    const double R1e6_3 = C6 * R1e5_3 + S6 * R2e4_3;
    const double R2e6_1 = C6 * R2e4_1 - S6 * R1e5_1;
    const double R2e6_2 = C6 * R2e4_2 - S6 * R1e5_2;
    const double R2e6_3 = C6 * R2e4_3 - S6 * R1e5_3;
    T_out[0] = C1;
    T_out[1] = -S1;
    T_out[2] = 0.0;
    T_out[3] = 0.0;
    T_out[4] = S1;
    T_out[5] = C1;
    T_out[6] = 0.0;
    T_out[7] = 0.0;
    T_out[8] = 0.0;
    T_out[9] = 0.0;
    T_out[10] = 1.0;
    T_out[11] = 0.0;
    T_out[12] = 0.0;
    T_out[13] = 0.0;
    T_out[14] = 0.0;
    T_out[15] = 1.0;
    T_out[16] = R1e2_1;
    T_out[17] = R2e2_1;
    T_out[18] = -S1;
    T_out[19] = pr2_1;
    T_out[20] = R1e2_2;
    T_out[21] = R2e2_2;
    T_out[22] = C1;
    T_out[23] = pr2_2;
    T_out[24] = -S2;
    T_out[25] = -C2;
    T_out[26] = 0.0;
    T_out[27] = 0.0;
    T_out[28] = 0.0;
    T_out[29] = 0.0;
    T_out[30] = 0.0;
    T_out[31] = 1.0;
    T_out[32] = R1e3_1;
    T_out[33] = R2e3_1;
    T_out[34] = -S1;
    T_out[35] = pr3_1;
    T_out[36] = R1e3_2;
    T_out[37] = R2e3_2;
    T_out[38] = C1;
    T_out[39] = pr3_2;
    T_out[40] = R1e3_3;
    T_out[41] = R2e3_3;
    T_out[42] = 0.0;
    T_out[43] = pd3_3;
    T_out[44] = 0.0;
    T_out[45] = 0.0;
    T_out[46] = 0.0;
    T_out[47] = 1.0;
    T_out[48] = R1e4_1;
    T_out[49] = R2e4_1;
    T_out[50] = -R2e3_1;
    T_out[51] = pr4_1;
    T_out[52] = R1e4_2;
    T_out[53] = R2e4_2;
    T_out[54] = -R2e3_2;
    T_out[55] = pr4_2;
    T_out[56] = R1e4_3;
    T_out[57] = R2e4_3;
    T_out[58] = -R2e3_3;
    T_out[59] = pr4_3;
    T_out[60] = 0.0;
    T_out[61] = 0.0;
    T_out[62] = 0.0;
    T_out[63] = 1.0;
    T_out[64] = R1e5_1;
    T_out[65] = R2e5_1;
    T_out[66] = R2e4_1;
    T_out[67] = pr4_1;
    T_out[68] = R1e5_2;
    T_out[69] = R2e5_2;
    T_out[70] = R2e4_2;
    T_out[71] = pr4_2;
    T_out[72] = R1e5_3;
    T_out[73] = R2e5_3;
    T_out[74] = R2e4_3;
    T_out[75] = pr4_3;
    T_out[76] = 0.0;
    T_out[77] = 0.0;
    T_out[78] = 0.0;
    T_out[79] = 1.0;
    T_out[80] = R1e6_1;
    T_out[81] = R2e6_1;
    T_out[82] = -R2e5_1;
    T_out[83] = pr4_1;
    T_out[84] = R1e6_2;
    T_out[85] = R2e6_2;
    T_out[86] = -R2e5_2;
    T_out[87] = pr4_2;
    T_out[88] = R1e6_3;
    T_out[89] = R2e6_3;
    T_out[90] = -R2e5_3;
    T_out[91] = pr4_3;
    T_out[92] = 0.0;
    T_out[93] = 0.0;
    T_out[94] = 0.0;
    T_out[95] = 1.0;
}

void puma560_frames_batch(size_t N, const double *q, double *T_out)
{
    for (size_t k = 0; k < N; ++k) {
        puma560_frames(&q[k * 6u], &T_out[k * 96u]);
    }
}
