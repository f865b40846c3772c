/* panda: what the examples share, and no controller needs: a simulated robot and a reference. */
#ifndef panda_SIMULATED_H
#define panda_SIMULATED_H

#include "panda.h"

#include <math.h>
#include <stdio.h>

enum { N = panda_JOINTS, P = panda_PARAMETERS };

typedef panda_real real;

static const double DT = 1e-3; /* s */

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
static inline motion after(const motion *x, const motion *rate, real h)
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
static inline int move(motion *x, const real *tau)
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
static inline void reference(double t, motion *r, real *qdd)
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

/* At rest, in a pose that the phase stands for. */
static inline motion rest(double phase)
{
    motion x = { { 0 }, { 0 } };
    for (int j = 0; j < N; ++j) {
        x.q[j] = (real)(0.8 * cos(phase + j));
    }
    return x;
}

/* ASSUMED, with a share of its friction. */
static inline void assume(real share, real *X)
{
    for (int i = 0; i < P; ++i) {
        X[i] = i < panda_INERTIAL ? ASSUMED[i] : share * ASSUMED[i];
    }
}

/* How far parameters are from those of the robot, relative to their norm. */
static inline double wrong(const real *X)
{
    double error = 0.0, norm = 0.0;
    for (int i = 0; i < P; ++i) {
        error += pow((double)X[i] - (double)ACTUAL[i], 2.0);
        norm += pow((double)ACTUAL[i], 2.0);
    }
    return sqrt(error / norm);
}

static inline double length(const real *e)
{
    return sqrt(pow((double)e[0], 2.0) + pow((double)e[1], 2.0) + pow((double)e[2], 2.0));
}

/* How far the frame t (4, 4) is from `to`: a point of it, m, and its axes, sum of t_i x to_i / 2. */
static inline void apart(const real *t, const real *to, const real *point, real *e)
{
    for (int i = 0; i < 3; ++i) {
        const int a = 4 * ((i + 1) % 3), b = 4 * ((i + 2) % 3);
        e[i] = to[4 * i + 3] - t[4 * i + 3];
        e[3 + i] = 0;
        for (int c = 0; c < 3; ++c) {
            e[i] += (to[4 * i + c] - t[4 * i + c]) * point[c];
            e[3 + i] += (t[a + c] * to[b + c] - t[b + c] * to[a + c]) / 2;
        }
    }
}

/* A hand pushes a point of Jacobian J (6, N) along the way that all joints together move it: its
 * torque is added to tau. Returns how far e goes along that way. */
static inline double push(real force, const real *J, const real *e, real *tau)
{
    real way[3] = { 0 };
    double along = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < N; ++j) {
            way[i] += J[i * N + j];
        }
        along += (double)(way[i] * e[i]);
    }
    const double norm = length(way);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < N; ++j) {
            tau[j] += J[i * N + j] * way[i] * force / (real)norm;
        }
    }
    return along / norm;
}

#endif
