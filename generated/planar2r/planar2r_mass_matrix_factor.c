/* planar2r: M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with L from
 * its last row
 * 7 mul, 5 add, 1 div, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"

#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "the status of this file needs NaN: compile it without -ffast-math and -ffinite-math-only"
#endif
#include "planar2r_math.h"

planar2r_IN_SECTION int planar2r_mass_matrix_factor(const double q[2], const double X[4], double L_out[4], double D_out[2])
{
    L_out[2] = 0.0;
    L_out[0] = 1.0;
    L_out[3] = 1.0;
    D_out[1] = X[1];
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
    L_out[1] = l2_1;
    const double m2_1_1 = J33s1_2 - Nbm23d2 * l2_1;
    D_out[0] = m2_1_1;
    const double guard[2] = { X[1], m2_1_1 };
    int status = planar2r_OK;
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!(guard[i] > 0.0)) {
            status = (guard[i] <= 0.0) ? planar2r_NOT_POSITIVE_DEFINITE : planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 4u) && (status == 0); ++i) {
        if (!((L_out[i] - L_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    for (size_t i = 0u; (i < 2u) && (status == 0); ++i) {
        if (!((D_out[i] - D_out[i]) == 0.0)) {
            status = planar2r_NOT_FINITE;
        }
    }
    return status;
}
