/* planar2r: mass matrix M(q)
 * 5 mul, 4 add, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_mass_matrix(const double q[2], const double X[4], double M[4])
{
    M[3] = X[1];
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double m2_1e2 = X[2] * C2 - X[3] * S2;
    const double xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const double J33d2_2 = X[1] + xd2_2;
    const double J33s1_2 = X[0] + J33d2_2;
    M[0] = J33s1_2;
    const double Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    M[1] = Nbm23d2;
    M[2] = Nbm23d2;
}
