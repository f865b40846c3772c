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
#include "panda.h"

#include <math.h>
#include <stdio.h>

enum { N = panda_JOINTS, P = panda_PARAMETERS };

typedef panda_real real;

static const double DT = 1e-3; /* s */
static const real SHARE = (real)0.8; /* of the friction, where it is compensated */
static const real PUSH = 8;              /* of a hand, N m or N on each joint in turn */

/* The parameters X of the simulated robot, to which a program may add, and as the controller has them:
 * every mass, inertia and friction 5 % wrong. */
static real ACTUAL[] = {
    1.27608,
    1.200704,
    -0.038493,
    0.032232,
    0.061386,
    1.774166,
    -0.213399,
    -3.664757,
    0.095706,
    0.02418,
    0.029714,
    -0.036533,
    0.352127,
    0.981486,
    -0.191497,
    0.20033,
    1.322596,
    0.241654,
    -0.0034,
    -0.004692,
    1.511964,
    -0.651616,
    2.87472,
    0.694691,
    0.282063,
    0.046643,
    0.037706,
    -0.032138,
    0.443015,
    -0.364939,
    -0.234105,
    0.809581,
    0.077147,
    0.01924,
    0.091622,
    -0.013382,
    0.366558,
    -0.331635,
    -0.01218,
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
    1.323761,
    1.203655,
    -0.036568,
    0.030621,
    0.058317,
    1.748443,
    -0.202729,
    -3.653962,
    0.092264,
    0.026201,
    0.0312,
    -0.03836,
    0.354899,
    0.990514,
    -0.210908,
    0.210346,
    1.347862,
    0.244904,
    -0.00323,
    -0.004457,
    1.533458,
    -0.653562,
    2.916836,
    0.659957,
    0.267819,
    0.048975,
    0.039591,
    -0.033745,
    0.436819,
    -0.383186,
    -0.191295,
    0.85006,
    0.088994,
    0.01901,
    0.087041,
    -0.012713,
    0.366647,
    -0.299641,
    -0.019884,
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
            failed |= panda_forward_dynamics(y.q, y.qd, tau, ACTUAL, rate.qd);
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
        X[i] = i < panda_INERTIAL ? ASSUMED[i] : share * ASSUMED[i];
    }
    for (int j = 0; j < N; ++j) {
        x.q[j] = begin[j] = (real)(0.7 * cos(2.0 * pose + j));
    }
    for (int k = 0; k < 500; ++k) {
        real tau[N] = { 0 };
        if (share >= 0) {
            panda_bias_torque(x.q, x.qd, X, tau);
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
