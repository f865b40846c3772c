/* planar2r: a simulated robot and a reference, which no controller needs. */
#ifndef planar2r_SIMULATED_H
#define planar2r_SIMULATED_H

#include "planar2r.h"

#include <math.h>
#include <stdio.h>

enum { N = planar2r_JOINTS, P = planar2r_PARAMETERS };

typedef planar2r_real real;

static const double DT = 1e-3; /* s */

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
            failed |= planar2r_forward_dynamics(y.q, y.qd, tau, ACTUAL, rate.qd);
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
        X[i] = i < planar2r_INERTIAL ? ASSUMED[i] : share * ASSUMED[i];
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

#endif
