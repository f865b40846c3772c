/* {{ name }}: an example of collision detection, once a millisecond, without sensors of force.
 *
 * A momentum observer (De Luca and Mattone, 2005): dp/dt = tau + C'qd - g - friction + what pushes on
 * the robot, and r = K (p - p(0) - integral of (tau + C'qd - g - friction + r) dt) follows that with a
 * delay of 1/K. No acceleration is needed, no matrix is inverted.
 *
 * The simulated robot follows a reference under computed torque; speeds are noisy, and controller and
 * observer have every mass, inertia and friction {{ percent }} % wrong. In turn each joint is pushed by 15 N m or
 * N for 20 ms. Exit status 0 when each is seen on its joint within 10 ms, and nothing else ever.
 */
#include "{{ name }}_simulated.h"

static const real KP = 900, KD = 60; /* 1/s2 and 1/s, of the errors of position and speed */
static const real K = 200;           /* 1/s, of the observer */
static const real PUSH = 15, LEVEL = 8; /* N m, or N */

{% include "example/observe.c" %}
