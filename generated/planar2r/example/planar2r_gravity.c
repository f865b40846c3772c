/* planar2r: an example of a robot that is led by hand: its weight and its friction are compensated.
 *
 *     tau = C qd + g + s friction,    s < 1,
 *
 * is one call of bias_torque with the friction in X taken s times. Every mass, inertia and friction that
 * the controller assumes is 5 % wrong. From three poses the simulated robot is left alone, without and
 * with compensation, and then pushed by a hand, with its weight compensated alone and with its friction,
 * too. Exit status 0 when it falls at least 10 times less far than without.
 */
#include "planar2r.h"

#include <math.h>
#include <stdio.h>

enum { N = planar2r_JOINTS, P = planar2r_PARAMETERS };

typedef planar2r_real real;

static const double DT = 1e-3; /* s */
static const real SHARE = (real)0.8; /* of the friction, where it is compensated */
static const real PUSH = 8;              /* of a hand, N m or N on each joint in turn */

/* The parameters X of the simulated robot, to which a program may add, and as the controller has them:
 * every mass, inertia and friction 5 % wrong. */
static real ACTUAL[] = {
    0.898583,
    0.214296,
    0.143341,
    -0.268162,
};
static const real ASSUMED[] = {
    0.872729,
    0.203581,
    0.136174,
    -0.254754,
};

typedef struct {
    real q[N];
    real qd[N];
} motion;

/* The motion `after` a time h at the speeds and accelerations of `rate`. */
static motion after(const motion *x, const motion *rate, real h)
{
    motion y;
    for (int j = 0; j < N; ++j) {
        y.q[j] = x->q[j] + h * rate->q[j];
        y.qd[j] = x->qd[j] + h * rate->qd[j];
    }
    return y;
}

/* What a robot does in a step of the controller: four steps of Runge and Kutta's fourth-order
 * method under constant torque. Returns 0; nonzero when the mass matrix is not positive definite. */
static int move(motion *x, const real *tau)
{
    const real h = (real)(DT / 4);
    int failed = 0;
    for (int i = 0; i < 4; ++i) {
        motion mean = { { 0 }, { 0 } };
        motion rate = mean;
        for (int stage = 0; stage < 4; ++stage) {
            const real reach = stage == 0 ? 0 : stage == 3 ? h : h / 2;
            const real weight = stage == 0 || stage == 3 ? (real)1 / 6 : (real)1 / 3;
            const motion y = after(x, &rate, reach);
            for (int j = 0; j < N; ++j) {
                rate.q[j] = y.qd[j];
            }
            failed |= planar2r_forward_dynamics(y.q, y.qd, tau, ACTUAL, rate.qd);
            mean = after(&mean, &rate, weight);
        }
        *x = after(x, &mean, h);
    }
    return failed;
}

/* How far the robot goes from a pose in 0.5 s: pushed for 0.1 s on one joint, and with a share of the
 * friction compensated; a share below 0 stands for no compensation at all. */
static double distance(int pose, int joint, real push, real share, int *failed)
{
    motion x = { { 0 }, { 0 } };
    real X[P], begin[N];
    double sum = 0.0;
    for (int i = 0; i < P; ++i) {
        X[i] = i < planar2r_INERTIAL ? ASSUMED[i] : share * ASSUMED[i];
    }
    for (int j = 0; j < N; ++j) {
        x.q[j] = begin[j] = (real)(0.7 * cos(2.0 * pose + j));
    }
    for (int k = 0; k < 500; ++k) {
        real tau[N] = { 0 };
        if (share >= 0) {
            planar2r_bias_torque(x.q, x.qd, X, tau);
        }
        tau[joint] += k < 100 ? push : 0;
        *failed |= move(&x, tau);
    }
    for (int j = 0; j < N; ++j) {
        sum += pow((double)(x.q[j] - begin[j]), 2.0);
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
    return failed == 0 && 10 * drifts <= falls ? 0 : 1;
}
