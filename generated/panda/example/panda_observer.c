/* panda: an example of collision detection, once a millisecond, without sensors of force.
 *
 * A momentum observer (De Luca and Mattone, 2005): dp/dt = tau + C'qd - g - friction + what pushes on
 * the robot, and r = K (p - p(0) - integral of (tau + C'qd - g - friction + r) dt) follows that with a
 * delay of 1/K. No acceleration is needed, no matrix is inverted.
 *
 * The simulated robot follows a reference under computed torque; speeds are noisy, and controller and
 * observer have every mass, inertia and friction 5 % wrong. In turn each joint is pushed by 15 N m or
 * N for 20 ms. Exit status 0 when each is seen on its joint within 10 ms, and nothing else ever.
 */
#include "panda.h"

#include <math.h>
#include <stdio.h>

enum { N = panda_JOINTS, P = panda_PARAMETERS };

typedef panda_real real;

static const double DT = 1e-3; /* s */
static const real KP = 900, KD = 60; /* 1/s2 and 1/s, of the errors of position and speed */
static const real K = 200;           /* 1/s, of the observer */
static const real PUSH = 15, LEVEL = 8; /* N m, or N */

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
    panda_mass_matrix(x->q, ASSUMED, M);
    panda_coriolis(x->q, x->qd, ASSUMED, C);
    panda_bias_torque(x->q, x->qd, ASSUMED, rate);
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
        panda_inverse_dynamics(measured.q, measured.qd, qdd, ASSUMED, tau);
        for (int j = 0; j < N; ++j) {
            acts[j] = tau[j] + (j == joint && phase >= BEGIN && phase < END ? PUSH : 0);
        }
        failed |= move(&x, acts);
    }
    printf("slowest: %d ms\non another joint: %d\nlargest without a push: %.2f\n", slowest, wrong, largest);
    return failed == 0 && wrong == 0 && slowest <= 10 && largest < (double)LEVEL ? 0 : 1;
}
