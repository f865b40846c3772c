/* twin: an example of collision detection, once a millisecond, without sensors of force.
 *
 * A momentum observer (De Luca and Mattone, 2005): dp/dt = tau + C'qd - g - friction + what pushes on
 * the robot, and r = K (p - p(0) - integral of (tau + C'qd - g - friction + r) dt) follows that with a
 * delay of 1/K. No acceleration is needed, no matrix is inverted.
 *
 * The simulated robot follows a reference under computed torque; speeds are noisy, and controller and
 * observer have every mass, inertia and friction 5 % wrong. In turn each joint is pushed by 15 N m or
 * N for 20 ms. Exit status 0 when each is seen on its joint within 10 ms, and nothing else ever.
 */
#include "twin.h"

#include <math.h>
#include <stdio.h>

enum { N = twin_JOINTS, P = twin_PARAMETERS };

typedef twin_real real;

static const double DT = 1e-3; /* s */
static const real KP = 900, KD = 60; /* 1/s2 and 1/s, of the errors of position and speed */
static const real K = 200;           /* 1/s, of the observer */
static const real PUSH = 15, LEVEL = 8; /* N m, or N */

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

/* The reference: a sum of sines in each joint, rad or m, with its first two derivatives. */
static void reference(double t, motion *r, real *qdd)
{
    for (int j = 0; j < N; ++j) {
        double sum[3] = { 0.0, 0.0, 0.0 };
        for (int k = 1; k <= 5; ++k) {
            const double w = 0.9 * k + 0.17 * (j + 1); /* rad/s */
            const double phase = w * t + k * k + j;
            sum[0] += 0.2 * sin(phase);
            sum[1] += 0.2 * w * cos(phase);
            sum[2] -= 0.2 * w * w * sin(phase);
        }
        r->q[j] = (real)sum[0];
        r->qd[j] = (real)sum[1];
        qdd[j] = (real)sum[2];
    }
}

/* p = M qd, and rate = C'qd - g - friction = (C + C') qd - h. */
static void momentum(const motion *x, real *p, real *rate)
{
    real M[N * N], C[N * N];
    twin_mass_matrix(x->q, ASSUMED, M);
    twin_coriolis(x->q, x->qd, ASSUMED, C);
    twin_bias_torque(x->q, x->qd, ASSUMED, rate);
    for (int j = 0; j < N; ++j) {
        p[j] = 0;
        rate[j] = -rate[j];
        for (int k = 0; k < N; ++k) {
            p[j] += M[j * N + k] * x->qd[k];
            rate[j] += (C[j * N + k] + C[k * N + j]) * x->qd[k];
        }
    }
}

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
        real p[N], rate[N], qdd[N], acts[N];
        motion measured = x;
        int most = 0;
        reference(step * DT, &ref, r_qdd);
        for (int j = 0; j < N; ++j) {
            seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
            measured.qd[j] += (real)(4e-3 * ((double)seed / 2147483648.0 - 0.5));
        }
        momentum(&measured, p, rate);
        for (int j = 0; j < N; ++j) {
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
        twin_inverse_dynamics(measured.q, measured.qd, qdd, ASSUMED, tau);
        for (int j = 0; j < N; ++j) {
            acts[j] = tau[j] + (j == joint && phase >= BEGIN && phase < END ? PUSH : 0);
        }
        failed |= move(&x, acts);
    }
    printf("slowest: %d ms\non another joint: %d\nlargest without a push: %.2f\n", slowest, wrong, largest);
    return failed == 0 && wrong == 0 && slowest <= 10 && largest < (double)LEVEL ? 0 : 1;
}
