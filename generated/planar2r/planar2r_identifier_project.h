/* The physically possible parameters that are nearest to what an identifier has learned.
 *
 * X is possible if some links give it whose pseudo-inertias [[S, m], [m', M]], S = tr(J)/2 I - J,
 * are positive definite, with friction and rotor inertia above 0 (Wensing, Kim, Slotine 2018).
 *
 * Sources: Lee, Wensing, Park, Geometric robot dynamic identification, 2020 (log-determinant
 * divergence); Helmberg, Rendl, Vanderbei, Wolkowicz, An interior-point method for semidefinite
 * programming, 1996 (direction of the step); Mehrotra, On the implementation of a primal-dual
 * interior point method, 1992 (predictor and corrector).
 */
#ifndef planar2r_IDENTIFIER_PROJECT_H
#define planar2r_IDENTIFIER_PROJECT_H

#include "planar2r_identifier.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Standard parameters, in this order:
 * XX1, XY1, XZ1, YY1, YZ1, ZZ1, MX1, MY1, MZ1, M1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, M2
 */
#define planar2r_STANDARD 20

/* X (planar2r_PARAMETERS values) that minimises (X - Y)' R'R (X - Y) among the possible ones, Y and R
 * what the identifier has learned.
 *
 * X0: standard parameters of a possible robot (planar2r_STANDARD values), such as those of a CAD file:
 * all pseudo-inertias positive definite, all friction and rotor inertias above 0. The search begins
 * there and takes 40 steps, each a predictor and a corrector, towards the s and z of
 *
 *     P Z = mu I for each link,   z = mu y0 + G'R'R (G s - Y),   X = G s,
 *
 * where mu falls to 0, P and Z are the matrices of s and z, and z is mu y0 at X0. All P and Z stay
 * positive definite: X is always possible, and the nearest that was passed. That is almost always
 * the nearest possible one; X may be farther from Y if the distance is small or links of X0 are
 * almost flat.
 *
 * Each step takes some planar2r_PARAMETERS^3 products: with 50 parameters, all take milliseconds, so do
 * not call it in a control cycle. The stack holds planar2r_PARAMETERS^2 / 2 numbers and more; there is
 * no allocation.
 *
 * Returns planar2r_OK; otherwise X is left as it is: planar2r_NOT_EXCITED, the data do not determine Y;
 * planar2r_NOT_POSITIVE_DEFINITE, X0 is not such a robot; planar2r_NOT_FINITE, a number of X0 is not finite.
 */
int planar2r_identifier_project(const void *state, const planar2r_real *X0, planar2r_real *X);

#ifdef __cplusplus
}
#endif

#endif
