/* puma560: an example of a controller that calls the model once a millisecond.
 *
 * Computed torque, tau = ID(q, qd, qdd_r + Kd (qd_r - qd) + Kp (q_r - q)), moves a simulated robot
 * along a reference r. Every mass, inertia and friction that it assumes is 5 % wrong; meanwhile the
 * identifier learns them from q, qd and tau. Then tau = D (Kd (qd_r - qd) + Kp (q_r - q)) does the
 * same: a PD controller of the same gains, D the diagonal of the mass matrix at the start.
 *
 * Prints the tracking errors (root of the mean square over time and joints, rad or m) and the error
 * of the parameters. Exit status 0 when computed torque tracks at least 10 times better.
 */
#include "puma560.h"
#include "puma560_identifier.h"

#include <math.h>
#include <stdio.h>

enum { N = puma560_JOINTS, P = puma560_PARAMETERS, STEPS = 20000, WINDOW = 200 };

typedef puma560_real real;

static const double DT = 1e-3; /* s */
static const real KP = 900;    /* 1/s2, of the error of position: both poles at 30 rad/s */
static const real KD = 60;     /* 1/s, of the error of speed */

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

/* How far parameters are from those of the robot, relative to their norm. */
static double wrong(const real *X)
{
    double error = 0.0;
    double norm = 0.0;
    for (int i = 0; i < P; ++i) {
        error += ((double)X[i] - (double)ACTUAL[i]) * ((double)X[i] - (double)ACTUAL[i]);
        norm += (double)ACTUAL[i] * (double)ACTUAL[i];
    }
    return sqrt(error / norm);
}

/* Follow the reference and return the tracking error: by computed torque, which the identifier
 * watches, or, without one, by PD. */
static double track(void *identifier, int *failed)
{
    double sum = 0.0;
    real r_qdd[N], tau[N], M[N * N], X[P];
    motion x, r;
    reference(0.0, &r, r_qdd);
    x = r;
    for (int i = 0; i < P; ++i) {
        X[i] = ASSUMED[i]; /* until the identifier knows better */
    }
    puma560_mass_matrix(r.q, ASSUMED, M);
    for (int k = 0; k < STEPS; ++k) {
        real qdd[N], held[N];
        reference(k * DT, &r, r_qdd);
        for (int j = 0; j < N; ++j) {
            const real e = r.q[j] - x.q[j];
            const real feedback = KD * (r.qd[j] - x.qd[j]) + KP * e;
            qdd[j] = r_qdd[j] + feedback;
            held[j] = k > 0 ? tau[j] : 0;
            tau[j] = M[j * N + j] * feedback;
            sum += (double)e * (double)e;
        }
        if (identifier != NULL) {
            puma560_inverse_dynamics(x.q, x.qd, qdd, ASSUMED, tau);
            /* The drive holds each torque for a step: about a sample, their mean acts. */
            for (int j = 0; j < N; ++j) {
                held[j] = k > 0 ? (held[j] + tau[j]) / 2 : tau[j];
            }
            *failed |= puma560_identifier_step(identifier, x.q, x.qd, held, (real)DT);
            if ((k + 1) % (STEPS / 4) == 0) {
                (void)puma560_identifier_read(identifier, X, NULL);
                printf("parameters after %.0f s: %.1e of their norm wrong\n", (k + 1) * DT, wrong(X));
            }
        }
        *failed |= move(&x, tau);
    }
    return sqrt(sum / ((double)STEPS * (double)N));
}

int main(void)
{
    static union {
        puma560_identifier head;
        unsigned char bytes[puma560_IDENTIFIER_BYTES(WINDOW)];
    } memory;
    int failed = puma560_identifier_init(&memory, sizeof memory, WINDOW, puma560_WINDOW_SLIDING, 1);

    printf("parameters assumed: %.1e of their norm wrong\n", wrong(ASSUMED));
    const double model = track(&memory, &failed);
    const double pd = track(NULL, &failed);
    printf("computed torque: %.2e\nPD: %.2e\nratio: %.1f\n", model, pd, pd / model);
    if (failed != 0) {
        printf("failed: a call refused its arguments\n");
    }
    return failed == 0 && 10 * model <= pd ? 0 : 1;
}
