/* planar2r: an example of adaptive control (Slotine and Li, 1987), once a millisecond.
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
#include "planar2r.h"

#include <math.h>
#include <stdio.h>

enum { N = planar2r_JOINTS, P = planar2r_PARAMETERS };

typedef planar2r_real real;

static const double DT = 1e-3; /* s */
static const real L = 10, K = 10; /* 1/s */

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
    planar2r_mass_matrix(x.q, ASSUMED, M);
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
        planar2r_slotine_li_regressor(x.q, x.qd, qdr, qddr, Y);
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
