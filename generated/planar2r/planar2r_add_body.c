/* planar2r: fix a body on a link, in X: its mass, the centre of mass in the frame of the link, and inertia
 * XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it off
 * 10 mul, 7 add for one sample, as written here.
 */
#include "planar2r.h"

planar2r_IN_SECTION int planar2r_add_body(double X[4], size_t link, double mass, const double com[3], const double inertia[6])
{
    int status = planar2r_NO_SUCH_LINK;
    if ((link >= 1u) && (link <= 2u)) {
        const double X_at1 = (double)(link == 1u);
        const double X_at2 = (double)(link == 2u);
        const double cZZ1R_M2 = 0.25;
        const double m1 = mass * com[0];
        const double m2 = mass * com[1];
        const double s1 = com[0] * m1;
        const double s2 = com[1] * m2;
        const double JZZ = inertia[5] + s1 + s2;
        const double BZZ1 = X_at1 * JZZ;
        const double BZZ2 = X_at2 * JZZ;
        const double BMX2 = X_at2 * m1;
        const double BMY2 = X_at2 * m2;
        const double BM2 = X_at2 * mass;
        const double NZZ1R = X[0] + cZZ1R_M2 * BM2 + BZZ1;
        X[0] = NZZ1R;
        const double NZZ2 = X[1] + BZZ2;
        X[1] = NZZ2;
        const double NMX2 = X[2] + BMX2;
        X[2] = NMX2;
        const double NMY2 = X[3] + BMY2;
        X[3] = NMY2;
        status = planar2r_OK;
    }
    return status;
}
