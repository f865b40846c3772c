/* panda: an example of a controller that calls the model once a millisecond.
 *
 * Computed torque, tau = ID(q, qd, qdd_r + Kd (qd_r - qd) + Kp (q_r - q)), moves a simulated robot
 * along a reference r. Every mass, inertia and friction that it assumes is 5 % wrong; meanwhile the
 * identifier learns them from q, qd and tau. Then tau = D (Kd (qd_r - qd) + Kp (q_r - q)) does the
 * same: a PD controller of the same gains, D the diagonal of the mass matrix at the start.
 *
 * Prints the tracking errors (root of the mean square over time and joints, rad or m) and the error
 * of the parameters. Exit status 0 when computed torque tracks at least 10 times better.
 */
#include "panda.h"
#include "panda_identifier.h"

#include <math.h>
#include <stdio.h>

enum { N = panda_JOINTS, P = panda_PARAMETERS, STEPS = 20000, WINDOW = 200 };

typedef panda_real real;

static const double DT = 1e-3; /* s */
static const real KP = 900;    /* 1/s2, of the error of position: both poles at 30 rad/s */
static const real KD = 60;     /* 1/s, of the error of speed */

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
    panda_mass_matrix(r.q, ASSUMED, M);
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
            panda_inverse_dynamics(x.q, x.qd, qdd, ASSUMED, tau);
            /* The drive holds each torque for a step: about a sample, their mean acts. */
            for (int j = 0; j < N; ++j) {
                held[j] = k > 0 ? (held[j] + tau[j]) / 2 : tau[j];
            }
            *failed |= panda_identifier_step(identifier, x.q, x.qd, held, (real)DT);
            if ((k + 1) % (STEPS / 4) == 0) {
                (void)panda_identifier_read(identifier, X, NULL);
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
        panda_identifier head;
        unsigned char bytes[panda_IDENTIFIER_BYTES(WINDOW)];
    } memory;
    int failed = panda_identifier_init(&memory, sizeof memory, WINDOW, panda_WINDOW_SLIDING, 1);

    printf("parameters assumed: %.1e of their norm wrong\n", wrong(ASSUMED));
    const double model = track(&memory, &failed);
    const double pd = track(NULL, &failed);
    printf("computed torque: %.2e\nPD: %.2e\nratio: %.1f\n", model, pd, pd / model);
    if (failed != 0) {
        printf("failed: a call refused its arguments\n");
    }
    return failed == 0 && 10 * model <= pd ? 0 : 1;
}
