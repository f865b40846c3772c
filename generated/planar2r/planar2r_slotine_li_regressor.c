/* planar2r: columns of M qddr + C(q, qd) qdr + g + friction(qd) = out X, C of Christoffel's symbols
 * 14 mul, 9 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_slotine_li_regressor(const double q[2], const double qd[2], const double qdr[2], const double qddr[2], double out[8])
{
    out[4] = 0.0;
    out[0] = qddr[0];
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double L1_1e2 = planar2r_geometry_L1 * S2;
    const double L1_2e2 = planar2r_geometry_L1 * C2;
    const double W32 = qd[0] + qd[1];
    const double vP33d2 = qd[0] * qdr[0];
    const double v2d2 = qddr[0] * planar2r_geometry_L1;
    const double v1d2 = -planar2r_geometry_L1 * vP33d2;
    const double l1e2 = C2 * v1d2 + S2 * v2d2;
    out[7] = -l1e2;
    const double l2e2 = C2 * v2d2 - S2 * v1d2;
    out[6] = l2e2;
    const double e3j2 = qddr[0] + qddr[1];
    out[1] = e3j2;
    out[5] = e3j2;
    const double E3j2 = qdr[0] + qdr[1];
    const double nXZ2_2 = W32 * E3j2;
    const double TMX2_1 = L1_2e2 * e3j2 + l2e2 - L1_1e2 * nXZ2_2;
    out[2] = TMX2_1;
    const double TMY2_1 = -L1_1e2 * e3j2 - L1_2e2 * nXZ2_2 - l1e2;
    out[3] = TMY2_1;
}
