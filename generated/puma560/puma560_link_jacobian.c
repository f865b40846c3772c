/* puma560: Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning
 * 174 mul, 125 add, 6 sincos for one sample, as written here.
 */
#include "puma560.h"
#include "puma560_math.h"

puma560_IN_SECTION int puma560_link_jacobian(const double q[6], size_t link, const double point[3], double J[36])
{
    int status = puma560_NO_SUCH_LINK;
    if ((link >= 1u) && (link <= 6u)) {
        const double X_at1 = (double)(link == 1u);
        const double X_at2 = (double)(link == 2u);
        const double X_at3 = (double)(link == 3u);
        const double X_at4 = (double)(link == 4u);
        const double X_at5 = (double)(link == 5u);
        const double X_at6 = (double)(link == 6u);
        J[12] = 0.0;
        J[18] = 0.0;
        J[24] = 0.0;
        J[31] = 0.0;
        J[32] = 0.0;
        const puma560_angles4 q_0 = puma560_sincos4(q);
        const puma560_angles2 q_4 = puma560_sincos2(&q[4]);
        const double C1 = q_0.c[0];
        const double S1 = q_0.s[0];
        const double C2 = q_0.c[1];
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
        const double R0c1 = X_at1 * C1 + X_at2 * R1e2_1 + X_at3 * R1e3_1 + X_at4 * R1e4_1 + X_at5 * R1e5_1 + X_at6 * R1e6_1;
        const double R0c2 = X_at1 * S1 + X_at2 * R1e2_2 + X_at3 * R1e3_2 + X_at4 * R1e4_2 + X_at5 * R1e5_2 + X_at6 * R1e6_2;
        const double R0c3 = X_at3 * R1e3_3 + X_at4 * R1e4_3 + X_at5 * R1e5_3 + X_at6 * R1e6_3 - X_at2 * S2;
        const double R1c1 = X_at2 * R2e2_1 + X_at3 * R2e3_1 + X_at4 * R2e4_1 + X_at5 * R2e5_1 + X_at6 * R2e6_1 - X_at1 * S1;
        const double R1c2 = X_at1 * C1 + X_at2 * R2e2_2 + X_at3 * R2e3_2 + X_at4 * R2e4_2 + X_at5 * R2e5_2 + X_at6 * R2e6_2;
        const double R1c3 = X_at3 * R2e3_3 + X_at4 * R2e4_3 + X_at5 * R2e5_3 + X_at6 * R2e6_3 - X_at2 * C2;
        const double R2c1 = X_at5 * R2e4_1 - X_at2 * S1 - X_at3 * S1 - X_at4 * R2e3_1 - X_at6 * R2e5_1;
        const double R2c2 = X_at2 * C1 + X_at3 * C1 + X_at5 * R2e4_2 - X_at4 * R2e3_2 - X_at6 * R2e5_2;
        const double R2c3 = X_at1 + X_at5 * R2e4_3 - X_at4 * R2e3_3 - X_at6 * R2e5_3;
        const double R3c1 = X_at2 * pr2_1 + X_at3 * pr3_1 + X_at4 * pr4_1 + X_at5 * pr4_1 + X_at6 * pr4_1;
        const double R3c2 = X_at2 * pr2_2 + X_at3 * pr3_2 + X_at4 * pr4_2 + X_at5 * pr4_2 + X_at6 * pr4_2;
        const double R3c3 = X_at3 * pd3_3 + X_at4 * pr4_3 + X_at5 * pr4_3 + X_at6 * pr4_3;
        const double t1 = point[0] * R0c1 + point[1] * R1c1 + point[2] * R2c1 + R3c1;
        const double t2 = point[0] * R0c2 + point[1] * R1c2 + point[2] * R2c2 + R3c2;
        const double t3 = point[0] * R0c3 + point[1] * R1c3 + point[2] * R2c3 + R3c3;
        const double a1 = X_at1 + X_at2 + X_at3 + X_at4 + X_at5 + X_at6;
        J[30] = a1;
        const double v1_1 = -t2 * a1;
        J[0] = v1_1;
        const double v1_2 = t1 * a1;
        J[6] = v1_2;
        const double a2 = X_at2 + X_at3 + X_at4 + X_at5 + X_at6;
        const double z2_1 = -S1 * a2;
        J[19] = z2_1;
        const double z2_2 = C1 * a2;
        J[25] = z2_2;
        const double r2_1 = t1 - pr2_1;
        const double r2_2 = t2 - pr2_2;
        const double v2_1 = t3 * z2_2;
        J[1] = v2_1;
        const double v2_2 = -t3 * z2_1;
        J[7] = v2_2;
        const double v2_3 = z2_1 * r2_2 - z2_2 * r2_1;
        J[13] = v2_3;
        const double a3 = X_at3 + X_at4 + X_at5 + X_at6;
        const double z3_1 = -S1 * a3;
        J[20] = z3_1;
        const double z3_2 = C1 * a3;
        J[26] = z3_2;
        const double r3_1 = t1 - pr3_1;
        const double r3_2 = t2 - pr3_2;
        const double r3_3 = t3 - pd3_3;
        const double v3_1 = z3_2 * r3_3;
        J[2] = v3_1;
        const double v3_2 = -z3_1 * r3_3;
        J[8] = v3_2;
        const double v3_3 = z3_1 * r3_2 - z3_2 * r3_1;
        J[14] = v3_3;
        const double a4 = X_at4 + X_at5 + X_at6;
        const double z4_1 = -R2e3_1 * a4;
        J[21] = z4_1;
        const double z4_2 = -R2e3_2 * a4;
        J[27] = z4_2;
        const double z4_3 = -R2e3_3 * a4;
        J[33] = z4_3;
        const double r4_1 = t1 - pr4_1;
        const double r4_2 = t2 - pr4_2;
        const double r4_3 = t3 - pr4_3;
        const double v4_1 = z4_2 * r4_3 - z4_3 * r4_2;
        J[3] = v4_1;
        const double v4_2 = z4_3 * r4_1 - z4_1 * r4_3;
        J[9] = v4_2;
        const double v4_3 = z4_1 * r4_2 - z4_2 * r4_1;
        J[15] = v4_3;
        const double a5 = X_at5 + X_at6;
        const double z5_1 = R2e4_1 * a5;
        J[22] = z5_1;
        const double z5_2 = R2e4_2 * a5;
        J[28] = z5_2;
        const double z5_3 = R2e4_3 * a5;
        J[34] = z5_3;
        const double v5_1 = r4_3 * z5_2 - r4_2 * z5_3;
        J[4] = v5_1;
        const double v5_2 = r4_1 * z5_3 - r4_3 * z5_1;
        J[10] = v5_2;
        const double v5_3 = r4_2 * z5_1 - r4_1 * z5_2;
        J[16] = v5_3;
        const double z6_1 = -X_at6 * R2e5_1;
        J[23] = z6_1;
        const double z6_2 = -X_at6 * R2e5_2;
        J[29] = z6_2;
        const double z6_3 = -X_at6 * R2e5_3;
        J[35] = z6_3;
        const double v6_1 = r4_3 * z6_2 - r4_2 * z6_3;
        J[5] = v6_1;
        const double v6_2 = r4_1 * z6_3 - r4_3 * z6_1;
        J[11] = v6_2;
        const double v6_3 = r4_2 * z6_1 - r4_1 * z6_2;
        J[17] = v6_3;
        status = puma560_OK;
    }
    return status;
}

int puma560_link_jacobian_batch(size_t N, const double *q, size_t link, const double *point, double *J)
{
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= puma560_link_jacobian(&q[k * 6u], link, &point[k * 3u], &J[k * 36u]);
    }
    return status;
}
