/* panda: an example of a robot that is led by hand: its weight and its friction are compensated.
 *
 *     tau = C qd + g + s friction,    s < 1,
 *
 * is one call of bias_torque with the friction in X taken s times. Every mass, inertia and friction that
 * the controller assumes is 5 % wrong. From three poses the simulated robot is left alone, without and
 * with compensation, and then pushed by a hand, with its weight compensated alone and with its friction,
 * too. Exit status 0 when it falls at least 10 times less far than without, and a push moves it farther
 * where friction is compensated.
 */
#include "panda_simulated.h"

static const real SHARE = (real)0.8; /* of the friction, where it is compensated */
static const real PUSH = 8;              /* of a hand, N m or N on each joint in turn */

/* How far the robot goes from a pose in 0.5 s: pushed for 0.1 s on one joint, and with a share of the
 * friction compensated; a share below 0 stands for no compensation at all. */
static double distance(int pose, int joint, real force, real share, int *failed)
{
    const motion begin = rest(2.0 * pose);
    motion x = begin;
    real X[P];
    double sum = 0.0;
    assume(share, X);
    for (int k = 0; k < 500; ++k) {
        real tau[N] = { 0 };
        if (share >= 0) {
            panda_bias_torque(x.q, x.qd, X, tau);
        }
        tau[joint] += k < 100 ? force : 0;
        *failed |= move(&x, tau);
    }
    for (int j = 0; j < N; ++j) {
        sum += pow((double)(x.q[j] - begin.q[j]), 2.0);
    }
    return sqrt(sum);
}

int main(void)
{
    int failed = 0;
    double falls = 0.0, drifts = 0.0, heavy = 0.0, light = 0.0;
    for (int pose = 0; pose < 3; ++pose) {
        falls += distance(pose, 0, 0, -1, &failed) / 3;
        drifts += distance(pose, 0, 0, SHARE, &failed) / 3;
        for (int j = 0; j < N; ++j) {
            heavy += distance(pose, j, PUSH, 0, &failed) / (3 * N);
            light += distance(pose, j, PUSH, SHARE, &failed) / (3 * N);
        }
    }
    printf("falls: %.2e\ncompensated: %.2e\npushed: %.2e\nfriction, too: %.2e\n", falls, drifts, heavy, light);
    return failed == 0 && 10 * drifts <= falls && light > heavy ? 0 : 1;
}
