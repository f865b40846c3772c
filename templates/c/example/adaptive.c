/* {{ name }}: an example of adaptive control (Slotine and Li, 1987), once a millisecond.
 *
 *     tau = Y(q, qd, qdr, qddr) X + K D s,    dX/dt = G Y's,    s = qdr - qd,
 *     qdr = qd_r + L (q_r - q),    qddr = qdd_r + L (qd_r - qd),
 *
 * moves a simulated robot along a reference r: Y is slotine_li_regressor, D the diagonal of the mass
 * matrix at the start, G diagonal. X begins with every mass, inertia and friction {{ percent }} % wrong, and
 * (X - actual)'G^-1 (X - actual), with the kinetic energy of s, can only fall.
 *
 * Prints the tracking error (root of the mean square over a tenth of the time, rad or m) at the begin
 * and at the end, and how far X is from the robot's, in the metric of G and relative to the begin. Exit
 * status 0 when the tracking error has fallen at least 3 times, and X has come closer.
 */
#include "{{ name }}_simulated.h"

enum { STEPS = 60000, TENTH = STEPS / 10 };
static const real L = 10, K = 10; /* 1/s */

/* The diagonal of G, larger where the parameter is. */
static real G(int i)
{
    return (real)(fabs((double)ASSUMED[i]) + 0.05);
}

/* sqrt((X - actual)'G^-1 (X - actual)), relative to that of ASSUMED. */
static double distance(const real *X)
{
    double sum = 0.0, begin = 0.0;
    for (int i = 0; i < P; ++i) {
        sum += pow((double)(X[i] - ACTUAL[i]), 2.0) / (double)G(i);
        begin += pow((double)(ASSUMED[i] - ACTUAL[i]), 2.0) / (double)G(i);
    }
    return sqrt(sum / begin);
}

{% include "example/adapt.c" %}
