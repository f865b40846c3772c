/* planar2r: Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning
 * 20 mul, 11 add, 2 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION int planar2r_link_jacobian(const double q[2], size_t link, const double point[3], double J[12])
{
    int status = planar2r_NO_SUCH_LINK;
    if ((link >= 1u) && (link <= 2u)) {
        const double X_at1 = (double)(link == 1u);
        const double X_at2 = (double)(link == 2u);
        J[4] = 0.0;
        J[5] = 0.0;
        J[6] = 0.0;
        J[7] = 0.0;
        J[8] = 0.0;
        J[9] = 0.0;
        J[11] = X_at2;
        const planar2r_angles2 q_0 = planar2r_sincos2(q);
        const double C1 = q_0.c[0];
        const double S1 = q_0.s[0];
        const double C2 = q_0.c[1];
        const double S2 = q_0.s[1];
        const double pd2_1 = planar2r_geometry_L1 * C1;
        const double pd2_2 = planar2r_geometry_L1 * S1;
        const double R1e2_1 = C1 * C2 - S1 * S2;
        const double R1e2_2 = C1 * S2 + S1 * C2;
        const double R0c1 = X_at1 * C1 + X_at2 * R1e2_1;
        const double R0c2 = X_at1 * S1 + X_at2 * R1e2_2;
        const double R2c3 = X_at1 + X_at2;
        J[10] = R2c3;
        const double R3c1 = X_at2 * pd2_1;
        const double R3c2 = X_at2 * pd2_2;
        const double t1 = point[0] * R0c1 + R3c1 - point[1] * R0c2;
        const double t2 = point[0] * R0c2 + point[1] * R0c1 + R3c2;
        const double v1_1 = -R2c3 * t2;
        J[0] = v1_1;
        const double v1_2 = R2c3 * t1;
        J[2] = v1_2;
        const double r2_1 = t1 - pd2_1;
        const double r2_2 = t2 - pd2_2;
        const double v2_1 = -X_at2 * r2_2;
        J[1] = v2_1;
        const double v2_2 = X_at2 * r2_1;
        J[3] = v2_2;
        status = planar2r_OK;
    }
    return status;
}

int planar2r_link_jacobian_batch(size_t N, const double *q, size_t link, const double *point, double *J)
{
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= planar2r_link_jacobian(&q[k * 2u], link, &point[k * 3u], &J[k * 12u]);
    }
    return status;
}
