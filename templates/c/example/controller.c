/* {{ name }}: an example of a controller that calls the model once a millisecond.
 *
 * Computed torque, tau = ID(q, qd, qdd_r + Kd (qd_r - qd) + Kp (q_r - q)), moves a simulated robot
 * along a reference r. Every mass, inertia and friction that it assumes is {{ percent }} % wrong; meanwhile the
 * identifier learns them from q, qd and tau. Then tau = D (Kd (qd_r - qd) + Kp (q_r - q)) does the
 * same: a PD controller of the same gains, D the diagonal of the mass matrix at the start.
 *
 * Prints the tracking errors (root of the mean square over time and joints, rad or m) and the error
 * of the parameters. Exit status 0 when computed torque tracks at least {{ better }} times better.
 */
#include "{{ name }}.h"
#include "{{ name }}_identifier.h"

#include <math.h>
#include <stdio.h>

enum { N = {{ name }}_JOINTS, P = {{ name }}_PARAMETERS, STEPS = 20000, WINDOW = 200 };

typedef {{ name }}_real real;

static const double DT = 1e-3; /* s */
static const real KP = 900;    /* 1/s2, of the error of position: both poles at 30 rad/s */
static const real KD = 60;     /* 1/s, of the error of speed */

{% include "example/robot.c" %}

{% include "example/reference.c" %}

{% include "example/control.c" %}

int main(void)
{
    static union {
        {{ name }}_identifier head;
        unsigned char bytes[{{ name }}_IDENTIFIER_BYTES(WINDOW)];
    } memory;
    int failed = {{ name }}_identifier_init(&memory, sizeof memory, WINDOW, {{ name }}_WINDOW_SLIDING, 1);

    printf("parameters assumed: %.1e of their norm wrong\n", wrong(ASSUMED));
    const double model = track(&memory, &failed);
    const double pd = track(NULL, &failed);
    printf("computed torque: %.2e\nPD: %.2e\nratio: %.1f\n", model, pd, pd / model);
    if (failed != 0) {
        printf("failed: a call refused its arguments\n");
    }
    return failed == 0 && {{ better }} * model <= pd ? 0 : 1;
}
