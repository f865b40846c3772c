/* {{ name }}: an example of a compliant tool (impedance control, Hogan 1985), once a millisecond.
 *
 *     tau = J'(K e - D v) + C qd + g + {{ share }} friction,    e = (x_r - x, sum of a x a_r / 2),
 *
 * with J and v = J qd of the tool's point x and a the axes of its frame: pushed by F the point gives way
 * by F/K. A weak spring on every joint holds what does not move the tool. At run time a tool is mounted,
 * a load taken, which moves the point, and both are put down again, and add_body tells the model of each.
 * Every mass, inertia and friction of the arm is {{ percent }} % wrong in it. Then a controller that nobody tells
 * does it.
 *
 * Prints, in m, how far the point is from its place before a push, at most, for both, and how far off
 * F/K it goes, relative. Exit status 0 when that is at most 15 %{% if falls %} and the first at most a third of the
 * second{% endif %}.
 */
#include "{{ name }}_simulated.h"

enum { LINK = {{ link }}, LINKS = {{ links }} }; /* that carries the tool; all of them */
static const real K[2] = { 4000, 200 }, D[2] = { 200, 10 }; /* N/m, N m/rad; N s/m, N m s/rad */
static const real HOLD = 5, DAMP = 2, F = 40; /* N m/rad and N m s/rad, or N/m and N s/m; N, of a push */

/* A tool and a load come and go: mass, centre of mass, inertia about it, and then the tool's point. */
static const struct {
    real mass, com[3], inertia[6], point[3];
} BODY[] = {
    { 1, { 0, 0, (real)0.06 }, { (real)0.01, 0, 0, (real)0.01, 0, (real)0.01 }, { 0, 0, (real)0.12 } },
    { 3, { 0, 0, (real)0.18 }, { (real)0.02, 0, 0, (real)0.02, 0, (real)0.02 }, { 0, 0, (real)0.18 } },
    { -3, { 0, 0, (real)0.18 }, { (real)-0.02, 0, 0, (real)-0.02, 0, (real)-0.02 }, { 0, 0, (real)0.12 } },
    { -1, { 0, 0, (real)0.06 }, { (real)-0.01, 0, 0, (real)-0.01, 0, (real)-0.01 }, { 0, 0, 0 } },
};

{% include "example/spring.c" %}

{% include "example/handling.c" %}
