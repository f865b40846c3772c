/* puma560: an example of adaptive control (Slotine and Li, 1987), once a millisecond.
 *
 *     tau = Y(q, qd, qdr, qddr) X + K D s,    dX/dt = G Y's,    s = qdr - qd,
 *     qdr = qd_r + L (q_r - q),    qddr = qdd_r + L (qd_r - qd),
 *
 * moves a simulated robot along a reference r: Y is slotine_li_regressor, D the diagonal of the mass
 * matrix at the start, G diagonal. X begins with every mass, inertia and friction 5 % wrong, and
 * (X - actual)'G^-1 (X - actual), with the kinetic energy of s, can only fall.
 *
 * Prints the tracking error (root of the mean square over a tenth of the time, rad or m) at the begin
 * and at the end, and how far X is from the robot's, in the metric of G and relative to the begin. Exit
 * status 0 when the tracking error has fallen at least 3 times, and X has come closer.
 */
#include "puma560.h"

#include <math.h>
#include <stdio.h>

enum { N = puma560_JOINTS, P = puma560_PARAMETERS };

typedef puma560_real real;

static const double DT = 1e-3; /* s */
static const real L = 10, K = 10; /* 1/s */

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
            failed |= puma560_forward_dynamics(y.q, y.qd, tau, ACTUAL, rate.qd);
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

/* The diagonal of G, larger where the parameter is. */
static real G(int i)
{
    return (real)(fabs((double)ASSUMED[i]) + 0.05);
}

/* sqrt((X - actual)'G^-1 (X - actual)), relative to that of ASSUMED. */
static double distance(const real *X)
{
    double sum = 0.0, begin = 0.0;
    for (int i = 0; i < P; ++i) {
        sum += pow((double)(X[i] - ACTUAL[i]), 2.0) / (double)G(i);
        begin += pow((double)(ASSUMED[i] - ACTUAL[i]), 2.0) / (double)G(i);
    }
    return sqrt(sum / begin);
}

int main(void)
{
    enum { STEPS = 60000, TENTH = STEPS / 10 };
    int failed = 0;
    double errors[10] = { 0.0 };
    real X[P], M[N * N], r_qdd[N];
    motion x, r;
    for (int i = 0; i < P; ++i) {
        X[i] = ASSUMED[i];
    }
    reference(0.0, &x, r_qdd);
    puma560_mass_matrix(x.q, ASSUMED, M);
    for (int step = 0; step < STEPS; ++step) {
        real qdr[N], qddr[N], s[N], tau[N], Y[N * P];
        reference(step * DT, &r, r_qdd);
        for (int j = 0; j < N; ++j) {
            const real e = r.q[j] - x.q[j];
            qdr[j] = r.qd[j] + L * e;
            qddr[j] = r_qdd[j] + L * (r.qd[j] - x.qd[j]);
            s[j] = qdr[j] - x.qd[j];
            tau[j] = K * M[j * N + j] * s[j];
            errors[step / TENTH] += pow((double)e, 2.0) / (TENTH * N);
        }
        puma560_slotine_li_regressor(x.q, x.qd, qdr, qddr, Y);
        for (int j = 0; j < N; ++j) {
            for (int i = 0; i < P; ++i) {
                tau[j] += Y[j * P + i] * X[i];
            }
        }
        for (int i = 0; i < P; ++i) {
            for (int j = 0; j < N; ++j) {
                X[i] += (real)DT * G(i) * Y[j * P + i] * s[j];
            }
        }
        failed |= move(&x, tau);
    }
    printf("begin: %.2e\nend: %.2e\ndistance: %.3f\n", sqrt(errors[0]), sqrt(errors[9]), distance(X));
    return failed == 0 && 9 * errors[9] <= errors[0] && distance(X) < 0.7 ? 0 : 1;
}
