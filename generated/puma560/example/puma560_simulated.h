/* puma560: a simulated robot and a reference, which no controller needs. */
#ifndef puma560_SIMULATED_H
#define puma560_SIMULATED_H

#include "puma560.h"

#include <math.h>
#include <stdio.h>

enum { N = puma560_JOINTS, P = puma560_PARAMETERS };

typedef puma560_real real;

static const double DT = 1e-3; /* s */

/* The parameters X of the simulated robot, to which a program may add, and as the controller has them:
 * every mass, inertia and friction 5 % wrong. */
static real ACTUAL[] = {
    3.604273,
    -1.700236,
    -0.038493,
    0.526642,
    0.061386,
    2.379895,
    3.847127,
    -0.406421,
    1.387888,
    -0.029783,
    0.029714,
    -0.036533,
    1.52727,
    0.087807,
    -3.347846,
    0.20033,
    0.13433,
    -0.003239,
    -0.0034,
    -0.004692,
    0.227384,
    -0.067896,
    0.157771,
    0.694691,
    0.2685,
    0.046643,
    0.037706,
    -0.032138,
    0.429452,
    -0.364939,
    -0.234105,
    0.809581,
    -0.079898,
    0.011925,
    0.091622,
    -0.013382,
    0.182386,
    -0.485761,
    0.070951,
    0.833029,
    0.438141,
    0.363829,
    0.450114,
    0.656796,
    0.728032,
    0.248433,
    0.30298,
    0.52913,
    0.246849,
    0.661164,
    0.296033,
    0.262668,
};
static const real ASSUMED[] = {
    3.636789,
    -1.700052,
    -0.036568,
    0.530174,
    0.058317,
    2.345728,
    3.851221,
    -0.3861,
    1.365387,
    -0.027204,
    0.0312,
    -0.03836,
    1.511338,
    0.102052,
    -3.314841,
    0.210346,
    0.140835,
    -0.003077,
    -0.00323,
    -0.004457,
    0.229236,
    -0.064501,
    0.175028,
    0.659957,
    0.253578,
    0.048975,
    0.039591,
    -0.033745,
    0.422578,
    -0.383186,
    -0.191295,
    0.85006,
    -0.075903,
    0.011328,
    0.087041,
    -0.012713,
    0.173267,
    -0.461473,
    0.067404,
    0.791377,
    0.460049,
    0.38202,
    0.427608,
    0.623956,
    0.764433,
    0.260855,
    0.287831,
    0.502673,
    0.259192,
    0.694222,
    0.281232,
    0.249535,
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
            failed |= puma560_forward_dynamics(y.q, y.qd, tau, ACTUAL, rate.qd);
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
        X[i] = i < puma560_INERTIAL ? ASSUMED[i] : share * ASSUMED[i];
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
