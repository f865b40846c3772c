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
#ifndef puma560_IDENTIFIER_PROJECT_H
#define puma560_IDENTIFIER_PROJECT_H

#include "puma560_identifier.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Standard parameters, in this order:
 * XX1, XY1, XZ1, YY1, YZ1, ZZ1, MX1, MY1, MZ1, M1, IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2,
 * MZ2, M2, IA2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3, MY3, MZ3, M3, IA3, XX4, XY4, XZ4, YY4, YZ4,
 * ZZ4, MX4, MY4, MZ4, M4, IA4, XX5, XY5, XZ5, YY5, YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6,
 * XZ6, YY6, YZ6, ZZ6, MX6, MY6, MZ6, M6, IA6, FS1, FV1, FS2, FV2, FS3, FV3, FS4, FV4, FS5, FV5,
 * FS6, FV6
 */
#define puma560_STANDARD 78

/* X (puma560_PARAMETERS values) that minimises (X - Y)' R'R (X - Y) among the possible ones, Y and R
 * what the identifier has learned.
 *
 * X0: standard parameters of a possible robot (puma560_STANDARD values), such as those of a CAD file:
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
 * Each step takes some puma560_PARAMETERS^3 products: with 50 parameters, all take milliseconds, so do
 * not call it in a control cycle. The stack holds puma560_PARAMETERS^2 / 2 numbers and more; there is
 * no allocation.
 *
 * Returns puma560_OK; otherwise X is left as it is: puma560_NOT_EXCITED, the data do not determine Y;
 * puma560_NOT_POSITIVE_DEFINITE, X0 is not such a robot; puma560_NOT_FINITE, a number of X0 is not finite.
 */
int puma560_identifier_project(const void *state, const puma560_real *X0, puma560_real *X);

#ifdef __cplusplus
}
#endif

#endif
