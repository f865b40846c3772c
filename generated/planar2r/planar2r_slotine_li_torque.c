/* planar2r: M qddr + C(q, qd) qdr + g + friction(qd), C of Christoffel's symbols
 * 20 mul, 12 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_slotine_li_torque(const double q[2], const double qd[2], const double qdr[2], const double qddr[2], const double X[4], double tau[2])
{
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double W32 = qd[0] + qd[1];
    const double vP33d2 = qd[0] * qdr[0];
    const double v2d2 = qddr[0] * planar2r_geometry_L1;
    const double v1d2 = -planar2r_geometry_L1 * vP33d2;
    const double l1e2 = C2 * v1d2 + S2 * v2d2;
    const double l2e2 = C2 * v2d2 - S2 * v1d2;
    const double e3j2 = qddr[0] + qddr[1];
    const double E3j2 = qdr[0] + qdr[1];
    const double N1_3 = qddr[0] * X[0];
    const double h2_1 = -X[3] * W32;
    const double h2_2 = X[2] * W32;
    const double F2_1 = -X[3] * e3j2 - E3j2 * h2_2;
    const double F2_2 = X[2] * e3j2 + E3j2 * h2_1;
    const double N2_3 = X[1] * e3j2 + X[2] * l2e2 - X[3] * l1e2;
    tau[1] = N2_3;
    const double Fbs2e2 = C2 * F2_2 + S2 * F2_1;
    const double Nbs3d2 = planar2r_geometry_L1 * Fbs2e2 + N2_3;
    const double Nss1_2_3 = N1_3 + Nbs3d2;
    tau[0] = Nss1_2_3;
}
