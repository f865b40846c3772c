/* rx90: Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning
 * 46 mul, 21 add, 5 sincos for one sample, as written here.
 */
#include "rx90.h"
#include "rx90_math.h"

void rx90_jacobian(const double q[6], double J_out[36])
{
    J_out[3] = 0.0;
    J_out[4] = 0.0;
    J_out[5] = 0.0;
    J_out[9] = 0.0;
    J_out[10] = 0.0;
    J_out[11] = 0.0;
    J_out[12] = 0.0;
    J_out[15] = 0.0;
    J_out[16] = 0.0;
    J_out[17] = 0.0;
    J_out[18] = 0.0;
    J_out[24] = 0.0;
    J_out[31] = 0.0;
    J_out[32] = 0.0;
    J_out[30] = 1.0;
    const rx90_angles4 q_0 = rx90_sincos4(q);
    const rx90_angles1 q_4 = rx90_sincos1(&q[4]);
    const double C1 = q_0.c[0];
    J_out[25] = -C1;
    J_out[26] = -C1;
    const double S1 = q_0.s[0];
    J_out[19] = S1;
    J_out[20] = S1;
    const double C2 = q_0.c[1];
    const double S2 = q_0.s[1];
    const double C3 = q_0.c[2];
    const double S3 = q_0.s[2];
    const double C4 = q_0.c[3];
    const double S4 = q_0.s[3];
    const double C5 = q_4.c[0];
    const double S5 = q_4.s[0];
    const double R1e2_1 = C1 * C2;
    const double R1e2_2 = S1 * C2;
    const double R2e2_1 = -C1 * S2;
    const double R2e2_2 = -S1 * S2;
    const double pd3_1 = rx90_geometry_D3 * R1e2_1;
    const double pd3_2 = rx90_geometry_D3 * R1e2_2;
    const double pd3_3 = rx90_geometry_D3 * S2;
    const double R1e3_1 = C3 * R1e2_1 + S3 * R2e2_1;
    const double R2e3_1 = C3 * R2e2_1 - S3 * R1e2_1;
    J_out[21] = R2e3_1;
    const double R2e4_1 = -S1 * C4 - S4 * R1e3_1;
    J_out[22] = -R2e4_1;
    const double R1e4_1 = C4 * R1e3_1 - S1 * S4;
    const double R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
    J_out[23] = R2e5_1;
    const double pr4_1 = rx90_geometry_R4 * R2e3_1 + pd3_1;
    J_out[6] = pr4_1;
    const double a3_1 = pr4_1 - pd3_1;
    const double R1e3_2 = C3 * R1e2_2 + S3 * R2e2_2;
    const double R2e3_2 = C3 * R2e2_2 - S3 * R1e2_2;
    J_out[27] = R2e3_2;
    const double R2e4_2 = C1 * C4 - S4 * R1e3_2;
    J_out[28] = -R2e4_2;
    const double R1e4_2 = C1 * S4 + C4 * R1e3_2;
    const double R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
    J_out[29] = R2e5_2;
    const double pr4_2 = rx90_geometry_R4 * R2e3_2 + pd3_2;
    J_out[0] = -pr4_2;
    const double v2_3 = C1 * pr4_1 + S1 * pr4_2;
    J_out[13] = v2_3;
    const double a3_2 = pr4_2 - pd3_2;
    const double v3_3 = C1 * a3_1 + S1 * a3_2;
    J_out[14] = v3_3;
    const double R1e3_3 = C2 * S3 + S2 * C3;
    const double R2e3_3 = C2 * C3 - S2 * S3;
    J_out[33] = R2e3_3;
    const double R1e4_3 = C4 * R1e3_3;
    const double R2e4_3 = -S4 * R1e3_3;
    J_out[34] = -R2e4_3;
    const double R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
    J_out[35] = R2e5_3;
    const double pr4_3 = rx90_geometry_R4 * R2e3_3 + pd3_3;
    const double v2_1 = -C1 * pr4_3;
    J_out[1] = v2_1;
    const double v2_2 = -S1 * pr4_3;
    J_out[7] = v2_2;
    const double a3_3 = pr4_3 - pd3_3;
    const double v3_1 = -C1 * a3_3;
    J_out[2] = v3_1;
    const double v3_2 = -S1 * a3_3;
    J_out[8] = v3_2;
}
