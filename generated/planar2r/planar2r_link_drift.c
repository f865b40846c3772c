/* planar2r: dJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0
 * 24 mul, 10 add, 2 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION int planar2r_link_drift(const double q[2], const double qd[2], size_t link, const double point[3], double a[6])
{
    int status = planar2r_NO_SUCH_LINK;
    if ((link >= 1u) && (link <= 2u)) {
        const double X_at1 = (double)(link == 1u);
        const double X_at2 = (double)(link == 2u);
        a[2] = 0.0;
        a[3] = 0.0;
        a[4] = 0.0;
        a[5] = 0.0;
        const planar2r_angles2 q_0 = planar2r_sincos2(q);
        const double C1 = q_0.c[0];
        const double S1 = q_0.s[0];
        const double C2 = q_0.c[1];
        const double S2 = q_0.s[1];
        const double R1e2_1 = C1 * C2 - S1 * S2;
        const double R1e2_2 = C1 * S2 + S1 * C2;
        const double ZP33d2 = qd[0] * qd[0];
        const double Z1d2 = -planar2r_geometry_L1 * ZP33d2;
        const double Z1e2 = C2 * Z1d2;
        const double Z2e2 = -S2 * Z1d2;
        const double W32 = qd[0] + qd[1];
        const double wc3 = qd[0] * X_at1 + X_at2 * W32;
        const double yc1 = X_at2 * Z1e2;
        const double yc2 = X_at2 * Z2e2;
        const double R0c1 = X_at1 * C1 + X_at2 * R1e2_1;
        const double R0c2 = X_at1 * S1 + X_at2 * R1e2_2;
        const double s1 = -point[1] * wc3;
        const double s2 = point[0] * wc3;
        const double u1 = yc1 - wc3 * s2;
        const double u2 = wc3 * s1 + yc2;
        const double D0_0 = R0c1 * u1 - R0c2 * u2;
        a[0] = D0_0;
        const double D0_1 = R0c1 * u2 + R0c2 * u1;
        a[1] = D0_1;
        status = planar2r_OK;
    }
    return status;
}

int planar2r_link_drift_batch(size_t N, const double *q, const double *qd, size_t link, const double *point, double *a)
{
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= planar2r_link_drift(&q[k * 2u], &qd[k * 2u], link, &point[k * 3u], &a[k * 6u]);
    }
    return status;
}
