/* rx90: dJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0
 * 246 mul, 161 add, 6 sincos for one sample, as written here.
 */
#include "rx90.h"
#include "rx90_math.h"

int rx90_link_drift(const double q[6], const double qd[6], size_t link, const double point[3], double a[6])
{
    int status = rx90_NO_SUCH_LINK;
    if ((link >= 1u) && (link <= 6u)) {
        const double X_at1 = (double)(link == 1u);
        const double X_at2 = (double)(link == 2u);
        const double X_at3 = (double)(link == 3u);
        const double X_at4 = (double)(link == 4u);
        const double X_at5 = (double)(link == 5u);
        const double X_at6 = (double)(link == 6u);
        const rx90_angles4 q_0 = rx90_sincos4(q);
        const rx90_angles2 q_4 = rx90_sincos2(&q[4]);
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
        const double R1e3_1 = C3 * R1e2_1 + S3 * R2e2_1;
        const double R1e3_2 = C3 * R1e2_2 + S3 * R2e2_2;
        const double R1e3_3 = C2 * S3 + S2 * C3;
        const double R2e3_1 = C3 * R2e2_1 - S3 * R1e2_1;
        const double R2e3_2 = C3 * R2e2_2 - S3 * R1e2_2;
        const double R2e3_3 = C2 * C3 - S2 * S3;
        const double R1e4_1 = C4 * R1e3_1 - S1 * S4;
        const double R1e4_2 = C1 * S4 + C4 * R1e3_2;
        const double R1e4_3 = C4 * R1e3_3;
        const double R2e4_1 = -S1 * C4 - S4 * R1e3_1;
        const double R2e4_2 = C1 * C4 - S4 * R1e3_2;
        const double R2e4_3 = -S4 * R1e3_3;
        const double R1e5_1 = C5 * R1e4_1 + S5 * R2e3_1;
        const double R1e5_2 = C5 * R1e4_2 + S5 * R2e3_2;
        const double R1e5_3 = C5 * R1e4_3 + S5 * R2e3_3;
        const double R2e5_1 = C5 * R2e3_1 - S5 * R1e4_1;
        const double R2e5_2 = C5 * R2e3_2 - S5 * R1e4_2;
        const double R2e5_3 = C5 * R2e3_3 - S5 * R1e4_3;
        const double R1e6_1 = C6 * R1e5_1 + S6 * R2e4_1;
        const double R0c1 = X_at1 * C1 + X_at2 * R1e2_1 + X_at3 * R1e3_1 + X_at4 * R1e4_1 + X_at5 * R1e5_1 + X_at6 * R1e6_1;
        const double R2e6_1 = C6 * R2e4_1 - S6 * R1e5_1;
        const double R1c1 = X_at2 * R2e2_1 + X_at3 * R2e3_1 + X_at4 * R2e4_1 + X_at5 * R2e5_1 + X_at6 * R2e6_1 - X_at1 * S1;
        const double R2c1 = X_at2 * S1 + X_at3 * S1 + X_at4 * R2e3_1 + X_at6 * R2e5_1 - X_at5 * R2e4_1;
        const double R1e6_2 = C6 * R1e5_2 + S6 * R2e4_2;
        const double R0c2 = X_at1 * S1 + X_at2 * R1e2_2 + X_at3 * R1e3_2 + X_at4 * R1e4_2 + X_at5 * R1e5_2 + X_at6 * R1e6_2;
        const double R2e6_2 = C6 * R2e4_2 - S6 * R1e5_2;
        const double R1c2 = X_at1 * C1 + X_at2 * R2e2_2 + X_at3 * R2e3_2 + X_at4 * R2e4_2 + X_at5 * R2e5_2 + X_at6 * R2e6_2;
        const double R2c2 = X_at4 * R2e3_2 + X_at6 * R2e5_2 - X_at2 * C1 - X_at3 * C1 - X_at5 * R2e4_2;
        const double R1e6_3 = C6 * R1e5_3 + S6 * R2e4_3;
        const double R0c3 = X_at2 * S2 + X_at3 * R1e3_3 + X_at4 * R1e4_3 + X_at5 * R1e5_3 + X_at6 * R1e6_3;
        const double R2e6_3 = C6 * R2e4_3 - S6 * R1e5_3;
        const double W1e2 = qd[0] * S2;
        const double R1c3 = X_at2 * C2 + X_at3 * R2e3_3 + X_at4 * R2e4_3 + X_at5 * R2e5_3 + X_at6 * R2e6_3;
        const double W2e2 = qd[0] * C2;
        const double R2c3 = X_at1 + X_at4 * R2e3_3 + X_at6 * R2e5_3 - X_at5 * R2e4_3;
        const double X12 = qd[1] * W2e2;
        const double X22 = -qd[1] * W1e2;
        const double ZP12d3 = W1e2 * W2e2;
        const double Z2d3 = rx90_geometry_D3 * ZP12d3;
        const double ZA3d3 = -2.0 * X22;
        const double Z3d3 = rx90_geometry_D3 * ZA3d3;
        const double ZP22d3 = W2e2 * W2e2;
        const double ZP33d3 = qd[1] * qd[1];
        const double ZA1d3 = ZP22d3 + ZP33d3;
        const double Z1d3 = -rx90_geometry_D3 * ZA1d3;
        const double W1e3 = C3 * W1e2 + S3 * W2e2;
        const double W2e3 = C3 * W2e2 - S3 * W1e2;
        const double X1e3 = C3 * X12 + S3 * X22;
        const double X13 = qd[2] * W2e3 + X1e3;
        const double X2e3 = C3 * X22 - S3 * X12;
        const double X23 = X2e3 - qd[2] * W1e3;
        const double Z1e3 = C3 * Z1d3 + S3 * Z2d3;
        const double Z2e3 = C3 * Z2d3 - S3 * Z1d3;
        const double W33 = qd[1] + qd[2];
        const double W1e4 = C4 * W1e3 - S4 * W33;
        const double W2e4 = -C4 * W33 - S4 * W1e3;
        const double X1e4 = C4 * X13;
        const double X14 = qd[3] * W2e4 + X1e4;
        const double X2e4 = -S4 * X13;
        const double X24 = X2e4 - qd[3] * W1e4;
        const double Z1e4 = C4 * Z1e3 - S4 * Z3d3;
        const double Z2e4 = -C4 * Z3d3 - S4 * Z1e3;
        const double W34 = qd[3] + W2e3;
        const double ZP13r4 = W1e4 * W34;
        const double ZA1r4 = X24 + ZP13r4;
        const double Z1r4 = rx90_geometry_R4 * ZA1r4 + Z1e4;
        const double ZP23r4 = W2e4 * W34;
        const double ZA2r4 = ZP23r4 - X14;
        const double Z2r4 = rx90_geometry_R4 * ZA2r4 + Z2e4;
        const double ZP11r4 = W1e4 * W1e4;
        const double ZP22r4 = W2e4 * W2e4;
        const double ZA3r4 = ZP11r4 + ZP22r4;
        const double Z3r4 = Z2e3 - rx90_geometry_R4 * ZA3r4;
        const double W1e5 = C5 * W1e4 + S5 * W34;
        const double W2e5 = C5 * W34 - S5 * W1e4;
        const double X1e5 = C5 * X14 + S5 * X23;
        const double X15 = qd[4] * W2e5 + X1e5;
        const double X2e5 = C5 * X23 - S5 * X14;
        const double X25 = X2e5 - qd[4] * W1e5;
        const double Z1e5 = C5 * Z1r4 + S5 * Z3r4;
        const double Z2e5 = C5 * Z3r4 - S5 * Z1r4;
        const double yc3 = X_at3 * Z3d3 + X_at4 * Z3r4 + X_at6 * Z2e5 - X_at5 * Z2r4;
        const double W35 = qd[4] - W2e4;
        const double W1e6 = C6 * W1e5 - S6 * W35;
        const double wc1 = X_at2 * W1e2 + X_at3 * W1e3 + X_at4 * W1e4 + X_at5 * W1e5 + X_at6 * W1e6;
        const double W2e6 = -C6 * W35 - S6 * W1e5;
        const double wc2 = X_at2 * W2e2 + X_at3 * W2e3 + X_at4 * W2e4 + X_at5 * W2e5 + X_at6 * W2e6;
        const double W36 = qd[5] + W2e5;
        const double wc3 = qd[0] * X_at1 + qd[1] * X_at2 + X_at3 * W33 + X_at4 * W34 + X_at5 * W35 + X_at6 * W36;
        const double X1e6 = C6 * X15 + S6 * X24;
        const double X16 = qd[5] * W2e6 + X1e6;
        const double xc1 = X_at2 * X12 + X_at3 * X13 + X_at4 * X14 + X_at5 * X15 + X_at6 * X16;
        const double X2e6 = C6 * X24 - S6 * X15;
        const double X26 = X2e6 - qd[5] * W1e6;
        const double xc2 = X_at2 * X22 + X_at3 * X23 + X_at4 * X24 + X_at5 * X25 + X_at6 * X26;
        const double xc3 = X_at4 * X23 + X_at6 * X25 - X_at5 * X24;
        const double D1_0 = xc1 * R0c1 + xc2 * R1c1 + xc3 * R2c1;
        a[3] = D1_0;
        const double D1_1 = xc1 * R0c2 + xc2 * R1c2 + xc3 * R2c2;
        a[4] = D1_1;
        const double D1_2 = xc1 * R0c3 + xc2 * R1c3 + xc3 * R2c3;
        a[5] = D1_2;
        const double Z1e6 = C6 * Z1e5 + S6 * Z2r4;
        const double Z2e6 = C6 * Z2r4 - S6 * Z1e5;
        const double yc1 = X_at3 * Z1e3 + X_at4 * Z1r4 + X_at5 * Z1e5 + X_at6 * Z1e6;
        const double yc2 = X_at3 * Z2e3 + X_at4 * Z2r4 + X_at5 * Z2e5 + X_at6 * Z2e6;
        const double s1 = point[2] * wc2 - point[1] * wc3;
        const double s2 = point[0] * wc3 - point[2] * wc1;
        const double u3 = point[1] * xc1 + wc1 * s2 + yc3 - point[0] * xc2 - wc2 * s1;
        const double s3 = point[1] * wc1 - point[0] * wc2;
        const double u1 = point[2] * xc2 + wc2 * s3 + yc1 - point[1] * xc3 - wc3 * s2;
        const double u2 = point[0] * xc3 + wc3 * s1 + yc2 - point[2] * xc1 - wc1 * s3;
        const double D0_0 = R0c1 * u1 + R1c1 * u2 + R2c1 * u3;
        a[0] = D0_0;
        const double D0_1 = R0c2 * u1 + R1c2 * u2 + R2c2 * u3;
        a[1] = D0_1;
        const double D0_2 = R0c3 * u1 + R1c3 * u2 + R2c3 * u3;
        a[2] = D0_2;
        status = rx90_OK;
    }
    return status;
}

int rx90_link_drift_batch(size_t N, const double *q, const double *qd, size_t link, const double *point, double *a)
{
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= rx90_link_drift(&q[k * 6u], &qd[k * 6u], link, &point[k * 3u], &a[k * 6u]);
    }
    return status;
}
