/* The physically possible parameters that are nearest to what an identifier has learned.
 *
 * X is possible if some links give it whose pseudo-inertias [[S, m], [m', M]], S = tr(J)/2 I - J,
 * are positive definite, with friction and rotor inertia above 0 (Wensing, Kim, Slotine 2018).
 *
 * Sources: Lee, Wensing, Park, Geometric robot dynamic identification, 2020 (log-determinant
 * divergence); Boyd and Vandenberghe, Convex Optimization, ch. 11 (barrier method).
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
 * there and takes {{ steps }} steps of Newton's method on
 *
 *     |R (G s - Y)|^2 / 2 + mu (log-determinant divergence of s from X0),    X = G s,
 *
 * where mu is halved after every full step. Each step ends on the segment from the parameters
 * before it, where these are possible: X always is. It is not always the nearest: with noisy logs of
 * six robots it was farther from Y by a median of {{ "3" if dtype == "float" else "2" }} %, and by {{ "a factor of 4" if dtype == "float" else "54 %" }} at most.
 *
 * Each step takes some NAME_PARAMETERS^3 products, and the stack holds NAME_PARAMETERS^2 / 2 numbers.
 * Measured in double at 2.5 GHz: 0.6 ms with 19 parameters, 3.4 ms with 52; 22 kB of stack with 62.
 * So do not call it in a control cycle. There is no allocation.
 *
 * Returns NAME_OK; otherwise X is left as it is: NAME_NOT_EXCITED, the data do not determine Y;
 * NAME_NOT_POSITIVE_DEFINITE, X0 is not such a robot; NAME_NOT_FINITE, a number of X0 is not finite.
 */
int NAME_identifier_project(const void *state, const NAME_real *X0, NAME_real *X);

#ifdef __cplusplus
}
#endif

#endif
