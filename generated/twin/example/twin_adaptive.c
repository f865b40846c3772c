/* twin: an example of adaptive control (Slotine and Li, 1987), once a millisecond.
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
#include "twin.h"

#include <math.h>
#include <stdio.h>

enum { N = twin_JOINTS, P = twin_PARAMETERS };

typedef twin_real real;

static const double DT = 1e-3; /* s */
static const real L = 10, K = 10; /* 1/s */

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
    twin_mass_matrix(x.q, ASSUMED, M);
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
        twin_slotine_li_regressor(x.q, x.qd, qdr, qddr, Y);
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
