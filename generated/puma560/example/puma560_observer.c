/* puma560: an example of collision detection, once a millisecond, without sensors of force.
 *
 * A momentum observer (De Luca and Mattone, 2005): dp/dt = tau + C'qd - g - friction + what pushes on
 * the robot, and r = K (p - p(0) - integral of (tau + C'qd - g - friction + r) dt) follows that with a
 * delay of 1/K. No acceleration is needed, no matrix is inverted.
 *
 * The simulated robot follows a reference under computed torque; speeds are noisy, and controller and
 * observer have every mass, inertia and friction 5 % wrong. In turn each joint is pushed by 15 N m or
 * N for 20 ms. Exit status 0 when each is seen on its joint within 10 ms, and nothing else ever.
 */
#include "puma560_simulated.h"

static const real KP = 900, KD = 60; /* 1/s2 and 1/s, of the errors of position and speed */
static const real K = 200;           /* 1/s, of the observer */
static const real PUSH = 15, LEVEL = 8; /* N m, or N */

int main(void)
{
    enum { PERIOD = 1500, BEGIN = 1000, END = 1020, QUIET = 1200 };
    unsigned seed = 1;
    int failed = 0, wrong = 0, slowest = 0, seen = 0;
    double largest = 0.0; /* of r where nothing pushes */
    real r[N] = { 0 }, sum[N] = { 0 }, before[N] = { 0 }, tau[N] = { 0 }, r_qdd[N];
    motion x, ref;
    reference(0.0, &x, r_qdd);
    for (int step = 0; step < N * PERIOD; ++step) {
        const int joint = step / PERIOD, phase = step % PERIOD;
        real p[N], rate[N], rubs[N], qdd[N], acts[N];
        motion measured = x;
        int most = 0;
        reference(step * DT, &ref, r_qdd);
        for (int j = 0; j < N; ++j) {
            seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
            measured.qd[j] += (real)(4e-3 * ((double)seed / 2147483648.0 - 0.5));
        }
        puma560_generalized_momentum(measured.q, measured.qd, ASSUMED, p, rate);
        puma560_friction(measured.qd, ASSUMED, rubs);
        for (int j = 0; j < N; ++j) {
            rate[j] -= rubs[j];
            sum[j] = step == 0 ? p[j] : sum[j] + (real)DT * (tau[j] + (rate[j] + before[j]) / 2 + r[j]);
            r[j] = K * (p[j] - sum[j]);
            before[j] = rate[j];
            most = fabs((double)r[j]) > fabs((double)r[most]) ? j : most;
            qdd[j] = r_qdd[j] + KD * (ref.qd[j] - measured.qd[j]) + KP * (ref.q[j] - x.q[j]);
        }
        if (phase < BEGIN || phase >= QUIET) {
            largest = fmax(largest, fabs((double)r[most]));
            seen = 0;
        } else if (seen == 0 && fabs((double)r[most]) > (double)LEVEL) {
            seen = 1;
            wrong += most != joint;
            slowest = phase - BEGIN > slowest ? phase - BEGIN : slowest;
        }
        slowest = phase == QUIET - 1 && seen == 0 ? PERIOD : slowest;
        puma560_inverse_dynamics(measured.q, measured.qd, qdd, ASSUMED, tau);
        for (int j = 0; j < N; ++j) {
            acts[j] = tau[j] + (j == joint && phase >= BEGIN && phase < END ? PUSH : 0);
        }
        failed |= move(&x, acts);
    }
    printf("slowest: %d ms\non another joint: %d\nlargest without a push: %.2f\n", slowest, wrong, largest);
    return failed == 0 && wrong == 0 && slowest <= 10 && largest < (double)LEVEL ? 0 : 1;
}
