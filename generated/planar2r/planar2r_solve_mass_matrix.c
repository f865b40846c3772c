/* planar2r: x of M(q) x = b
 * 11 mul, 7 add, 2 div, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"

#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "the status of this file needs NaN: compile it without -ffast-math and -ffinite-math-only"
#endif
#include "planar2r_math.h"

planar2r_IN_SECTION int planar2r_solve_mass_matrix(const double q[2], const double b[2], const double X[4], double x[2])
{
    const planar2r_angles1 q_1 = planar2r_sincos1(&q[1]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double m2_1e2 = X[2] * C2 - X[3] * S2;
    const double xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const double J33d2_2 = X[1] + xd2_2;
    const double J33s1_2 = X[0] + J33d2_2;
    const double Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    const double d2 = 1.0 / X[1];
    const double l2_1 = Nbm23d2 * d2;
    const double m2_1_1 = J33s1_2 - Nbm23d2 * l2_1;
    const double d1 = 1.0 / m2_1_1;
    const double y2_1 = b[0] - b[1] * l2_1;
    const double o1 = d1 * y2_1;
    x[0] = o1;
    const double o2 = b[1] * d2 - l2_1 * o1;
    x[1] = o2;
    const double guard[2] = { X[1], m2_1_1 };
    int status = planar2r_OK;
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!(guard[i] > 0.0)) {
            status = (guard[i] <= 0.0) ? planar2r_NOT_POSITIVE_DEFINITE : planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!((x[i] - x[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    return status;
}
