/* twin: an example of a robot that is led by hand: its weight and its friction are compensated.
 *
 *     tau = C qd + g + s friction,    s < 1,
 *
 * is one call of bias_torque with the friction in X taken s times. Every mass, inertia and friction that
 * the controller assumes is 5 % wrong. From three poses the simulated robot is left alone, without and
 * with compensation, and then pushed by a hand, with its weight compensated alone and with its friction,
 * too. Exit status 0 when it falls at least 10 times less far than without, and a push moves it farther
 * where friction is compensated.
 */
#include "twin.h"

#include <math.h>
#include <stdio.h>

enum { N = twin_JOINTS, P = twin_PARAMETERS };

typedef twin_real real;

static const double DT = 1e-3; /* s */
static const real SHARE = (real)0.8; /* of the friction, where it is compensated */
static const real PUSH = 8;              /* of a hand, N m or N on each joint in turn */

/* The parameters X of the simulated robot, to which a program may add, and as the controller has them:
 * every mass, inertia and friction 5 % wrong. */
static real ACTUAL[] = {
    2.619846,
    -0.314079,
    -0.038493,
    0.112239,
    0.061386,
    0.993738,
    1.010528,
    -0.406421,
    0.182635,
    0.032295,
    0.029714,
    -0.036533,
    0.31601,
    0.23575,
    -0.682458,
    0.20033,
    0.002121,
    -0.003239,
    -0.0034,
    -0.004692,
    0.095176,
    -0.067896,
    -0.09368,
    0.694691,
    0.006215,
    -0.044979,
    0.049631,
    -0.018756,
    1.239033,
    -0.364939,
    0.311048,
    -0.485761,
    0.154082,
    0.545153,
    4.641717,
    0.833029,
    -0.008539,
    -0.006433,
    0.006878,
    0.003691,
    0.170115,
    -0.144918,
    -0.077753,
    0.248433,
    0.30298,
    0.52913,
    0.246849,
    0.661164,
    0.296033,
    0.262668,
    0.87615,
    0.241379,
    0.218364,
    0.175477,
    0.7872,
    0.888984,
    0.694636,
    0.779699,
};
static const real ASSUMED[] = {
    2.681934,
    -0.317418,
    -0.036568,
    0.114628,
    0.058317,
    0.963095,
    1.023479,
    -0.3861,
    0.174847,
    0.033909,
    0.0312,
    -0.03836,
    0.314891,
    0.247537,
    -0.677321,
    0.210346,
    0.002015,
    -0.003077,
    -0.00323,
    -0.004457,
    0.090417,
    -0.064501,
    -0.088996,
    0.659957,
    0.004408,
    -0.038066,
    0.05092,
    -0.021032,
    1.272638,
    -0.383186,
    0.3266,
    -0.461473,
    0.154691,
    0.517896,
    4.584774,
    0.791377,
    -0.008966,
    -0.006755,
    0.007222,
    0.003875,
    0.17862,
    -0.152164,
    -0.08164,
    0.260855,
    0.318129,
    0.555586,
    0.234507,
    0.628106,
    0.310835,
    0.275802,
    0.832343,
    0.22931,
    0.229283,
    0.184251,
    0.74784,
    0.844535,
    0.729368,
    0.818684,
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
            failed |= twin_forward_dynamics(y.q, y.qd, tau, ACTUAL, rate.qd);
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
        X[i] = i < twin_INERTIAL ? ASSUMED[i] : share * ASSUMED[i];
    }
    for (int j = 0; j < N; ++j) {
        x.q[j] = begin[j] = (real)(0.7 * cos(2.0 * pose + j));
    }
    for (int k = 0; k < 500; ++k) {
        real tau[N] = { 0 };
        if (share >= 0) {
            twin_bias_torque(x.q, x.qd, X, tau);
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
    return failed == 0 && 10 * drifts <= falls && light > heavy ? 0 : 1;
}
