/* panda: Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning
 * 93 mul, 58 add, 6 sincos for one sample, as written here.
 */
#include "panda.h"
#include "panda_math.h"

void panda_jacobian(const double q[7], double J_out[42])
{
    const double r1 = 0.333;
    J_out[6] = 0.0;
    J_out[13] = 0.0;
    J_out[14] = 0.0;
    J_out[20] = 0.0;
    J_out[21] = 0.0;
    J_out[28] = 0.0;
    J_out[36] = 0.0;
    J_out[35] = 1.0;
    const panda_angles4 q_0 = panda_sincos4(q);
    const panda_angles2 q_4 = panda_sincos2(&q[4]);
    const double C1 = q_0.c[0];
    J_out[29] = C1;
    const double S1 = q_0.s[0];
    J_out[22] = -S1;
    const double C2 = q_0.c[1];
    J_out[37] = C2;
    const double S2 = q_0.s[1];
    const double C3 = q_0.c[2];
    const double S3 = q_0.s[2];
    const double C4 = q_0.c[3];
    const double S4 = q_0.s[3];
    const double C5 = q_4.c[0];
    const double S5 = q_4.s[0];
    const double C6 = q_4.c[1];
    const double S6 = q_4.s[1];
    const double R1e2_1 = C1 * C2;
    const double R1e2_2 = S1 * C2;
    const double R2e2_1 = -C1 * S2;
    J_out[23] = -R2e2_1;
    const double R2e2_2 = -S1 * S2;
    J_out[30] = -R2e2_2;
    const double R1e3_1 = C3 * R1e2_1 - S1 * S3;
    const double R2e3_1 = -S1 * C3 - S3 * R1e2_1;
    J_out[24] = -R2e3_1;
    const double R1e3_2 = C1 * S3 + C3 * R1e2_2;
    const double R2e3_2 = C1 * C3 - S3 * R1e2_2;
    J_out[31] = -R2e3_2;
    const double R1e3_3 = -S2 * C3;
    const double R2e3_3 = S2 * S3;
    J_out[38] = -R2e3_3;
    const double pr3_1 = -panda_geometry_R3 * R2e2_1;
    const double pr3_2 = -panda_geometry_R3 * R2e2_2;
    const double pr3_3 = r1 + panda_geometry_R3 * C2;
    const double pd4_1 = panda_geometry_D4 * R1e3_1 + pr3_1;
    const double pd4_2 = panda_geometry_D4 * R1e3_2 + pr3_2;
    const double pd4_3 = panda_geometry_D4 * R1e3_3 + pr3_3;
    const double R1e4_1 = C4 * R1e3_1 - S4 * R2e2_1;
    const double R2e4_1 = -C4 * R2e2_1 - S4 * R1e3_1;
    J_out[25] = R2e4_1;
    const double R1e4_2 = C4 * R1e3_2 - S4 * R2e2_2;
    const double R2e4_2 = -C4 * R2e2_2 - S4 * R1e3_2;
    J_out[32] = R2e4_2;
    const double R1e4_3 = C2 * S4 + C4 * R1e3_3;
    const double R2e4_3 = C2 * C4 - S4 * R1e3_3;
    J_out[39] = R2e4_3;
    const double pd5_1 = pd4_1 - panda_geometry_D4 * R1e4_1;
    const double pr5_1 = panda_geometry_R5 * R2e4_1 + pd5_1;
    const double pd5_2 = pd4_2 - panda_geometry_D4 * R1e4_2;
    const double pr5_2 = panda_geometry_R5 * R2e4_2 + pd5_2;
    const double pd5_3 = pd4_3 - panda_geometry_D4 * R1e4_3;
    const double pr5_3 = panda_geometry_R5 * R2e4_3 + pd5_3;
    const double R1e5_1 = C5 * R1e4_1 + S5 * R2e3_1;
    const double R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
    J_out[26] = -R2e5_1;
    const double R2e6_1 = C6 * R2e4_1 - S6 * R1e5_1;
    J_out[27] = -R2e6_1;
    const double R1e6_1 = C6 * R1e5_1 + S6 * R2e4_1;
    const double pd7_1 = panda_geometry_D7 * R1e6_1 + pr5_1;
    J_out[7] = pd7_1;
    const double a3_1 = pd7_1 - pr3_1;
    const double a4_1 = pd7_1 - pd4_1;
    const double a5_1 = pd7_1 - pr5_1;
    const double R1e5_2 = C5 * R1e4_2 + S5 * R2e3_2;
    const double R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
    J_out[33] = -R2e5_2;
    const double R2e6_2 = C6 * R2e4_2 - S6 * R1e5_2;
    J_out[34] = -R2e6_2;
    const double R1e6_2 = C6 * R1e5_2 + S6 * R2e4_2;
    const double pd7_2 = panda_geometry_D7 * R1e6_2 + pr5_2;
    J_out[0] = -pd7_2;
    const double v2_3 = -C1 * pd7_1 - S1 * pd7_2;
    J_out[15] = v2_3;
    const double a3_2 = pd7_2 - pr3_2;
    const double v3_3 = R2e2_2 * a3_1 - R2e2_1 * a3_2;
    J_out[16] = v3_3;
    const double a4_2 = pd7_2 - pd4_2;
    const double v4_3 = R2e3_2 * a4_1 - R2e3_1 * a4_2;
    J_out[17] = v4_3;
    const double a5_2 = pd7_2 - pr5_2;
    const double v5_3 = R2e4_1 * a5_2 - R2e4_2 * a5_1;
    J_out[18] = v5_3;
    const double v6_3 = R2e5_2 * a5_1 - R2e5_1 * a5_2;
    J_out[19] = v6_3;
    const double R1e5_3 = C5 * R1e4_3 + S5 * R2e3_3;
    const double R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
    J_out[40] = -R2e5_3;
    const double R2e6_3 = C6 * R2e4_3 - S6 * R1e5_3;
    J_out[41] = -R2e6_3;
    const double R1e6_3 = C6 * R1e5_3 + S6 * R2e4_3;
    const double pd7_3 = panda_geometry_D7 * R1e6_3 + pr5_3;
    const double a3_3 = pd7_3 - pr3_3;
    const double v3_1 = -C2 * a3_2 - R2e2_2 * a3_3;
    J_out[2] = v3_1;
    const double v3_2 = C2 * a3_1 + R2e2_1 * a3_3;
    J_out[9] = v3_2;
    const double a4_3 = pd7_3 - pd4_3;
    const double v4_1 = R2e3_3 * a4_2 - R2e3_2 * a4_3;
    J_out[3] = v4_1;
    const double v4_2 = R2e3_1 * a4_3 - R2e3_3 * a4_1;
    J_out[10] = v4_2;
    const double a5_3 = pd7_3 - pr5_3;
    const double a1_3 = pd7_3 - r1;
    const double v2_1 = C1 * a1_3;
    J_out[1] = v2_1;
    const double v2_2 = S1 * a1_3;
    J_out[8] = v2_2;
    const double v5_1 = R2e4_2 * a5_3 - R2e4_3 * a5_2;
    J_out[4] = v5_1;
    const double v5_2 = R2e4_3 * a5_1 - R2e4_1 * a5_3;
    J_out[11] = v5_2;
    const double v6_1 = R2e5_3 * a5_2 - R2e5_2 * a5_3;
    J_out[5] = v6_1;
    const double v6_2 = R2e5_1 * a5_3 - R2e5_3 * a5_1;
    J_out[12] = v6_2;
}

void panda_jacobian_batch(size_t N, const double *q, double *J_out)
{
    for (size_t k = 0; k < N; ++k) {
        panda_jacobian(&q[k * 7u], &J_out[k * 42u]);
    }
}
