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
#ifndef NAME_IDENTIFIER_PROJECT_H
#define NAME_IDENTIFIER_PROJECT_H

#include "NAME_identifier.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Standard parameters, in this order:
{% for line in order %}
 * {{ line }}
{% endfor %}
 */
#define NAME_STANDARD {{ standard }}

/* X (NAME_PARAMETERS values) that minimises (X - Y)' R'R (X - Y) among the possible ones, Y and R
 * what the identifier has learned.
 *
 * X0: standard parameters of a possible robot (NAME_STANDARD values), such as those of a CAD file:
 * all pseudo-inertias positive definite, all friction and rotor inertias above 0. The search begins
 * there and takes {{ steps }} steps, each a predictor and a corrector, towards the s and z of
 *
 *     P Z = mu I for each link,   z = mu y0 + G'R'R (G s - Y),   X = G s,
 *
 * where mu falls to 0, P and Z are the matrices of s and z, and z is mu y0 at X0. All P and Z stay
 * positive definite: X is always possible, and the nearest that was passed. That is almost always
 * the nearest possible one; X may be farther from Y if the distance is small or links of X0 are
 * almost flat.
 *
 * Each step takes some NAME_PARAMETERS^3 products: with 50 parameters, all take milliseconds, so do
 * not call it in a control cycle. The stack holds NAME_PARAMETERS^2 / 2 numbers and more; there is
 * no allocation.
 *
 * Returns NAME_OK; otherwise X is left as it is: NAME_NOT_EXCITED, the data do not determine Y;
 * NAME_NOT_POSITIVE_DEFINITE, X0 is not such a robot; NAME_NOT_FINITE, a number of X0 is not finite.
 */
int NAME_identifier_project(const void *state, const NAME_real *X0, NAME_real *X);

#ifdef __cplusplus
}
#endif

#endif
