/* puma560: an example of a compliant tool (impedance control, Hogan 1985), once a millisecond.
 *
 *     tau = J'(K e - D v) + C qd + g + 0.8 friction,    e = (x_r - x, sum of a x a_r / 2),
 *
 * with J and v = J qd of the tool's point x and a the axes of its frame: pushed by F the point gives way
 * by F/K. A weak spring on every joint holds what does not move the tool. At run time a tool is mounted,
 * a load taken, which moves the point, and put down again, and add_body tells the model of each. Every
 * mass, inertia and friction of the arm is 5 % wrong in it. Then a controller that nobody tells does it.
 *
 * Prints, in m, how far the point is from its place before a push, at most, for both, and how far off
 * F/K it goes, relative. Exit status 0 when that is at most 15 % and the first at most a third of the
 * second.
 */
#include "puma560.h"

#include <math.h>
#include <stdio.h>

enum { N = puma560_JOINTS, P = puma560_PARAMETERS };

typedef puma560_real real;

static const double DT = 1e-3; /* s */
enum { LINK = 6, LINKS = 6 }; /* that carries the tool; all of them */
static const real K[2] = { 4000, 200 }, D[2] = { 200, 10 }; /* N/m, N m/rad; N s/m, N m s/rad */
static const real HOLD = 5, DAMP = 2;                       /* N m/rad and N m s/rad, or N/m and N s/m */
static const real F = 40;                                   /* N, of a push */

/* A tool is mounted, a load taken and put down: mass, centre of mass, inertia about it, and the point. */
static const struct {
    real mass, com[3], inertia[6], point[3];
} BODY[] = {
    { 1, { 0, 0, (real)0.06 }, { (real)0.01, 0, 0, (real)0.01, 0, (real)0.01 }, { 0, 0, (real)0.12 } },
    { 3, { 0, 0, (real)0.18 }, { (real)0.02, 0, 0, (real)0.02, 0, (real)0.02 }, { 0, 0, (real)0.18 } },
    { -3, { 0, 0, (real)0.18 }, { (real)-0.02, 0, 0, (real)-0.02, 0, (real)-0.02 }, { 0, 0, (real)0.12 } },
};

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

/* Axes of the link's frame and a point of it, in frame 0: four vectors. */
static void place(const real *q, const real *point, real *x)
{
    real T[16 * LINKS];
    puma560_frames(q, T);
    for (int i = 0; i < 3; ++i) {
        const real *row = &T[16 * (LINK - 1) + 4 * i];
        x[9 + i] = row[3];
        for (int axis = 0; axis < 3; ++axis) {
            x[3 * axis + i] = row[axis];
            x[9 + i] += row[axis] * point[axis];
        }
    }
}

/* The torque of springs and dampers between the tool and its place `to`, and J of its point. */
static void spring(const motion *x, const real *point, const real *to, real *J, real *tau)
{
    real at[12], pull[6];
    place(x->q, point, at);
    puma560_link_jacobian(x->q, LINK, point, J);
    for (int i = 0; i < 6; ++i) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        real e = i < 3 ? to[9 + i] - at[9 + i] : 0;
        for (int axis = 0; i >= 3 && axis < 9; axis += 3) {
            e += (at[axis + a] * to[axis + b] - at[axis + b] * to[axis + a]) / 2;
        }
        pull[i] = K[i / 3] * e;
        for (int j = 0; j < N; ++j) {
            pull[i] -= D[i / 3] * J[i * N + j] * x->qd[j];
        }
    }
    for (int j = 0; j < N; ++j) {
        tau[j] = 0;
        for (int i = 0; i < 6; ++i) {
            tau[j] += J[i * N + j] * pull[i];
        }
    }
}

/* Hold for 2 s and be pushed for 1 s, three times; returns the largest distance before a push. */
static double handle(int told, double *off, int *failed)
{
    motion x = { { 0 }, { 0 } };
    real X[P], start[N], to[12], at[12], before[12], way[3], J[6 * N], h[N], tau[N];
    double aside = 0.0;
    for (int i = 0; i < P; ++i) {
        X[i] = (i < puma560_INERTIAL ? 1 : (real)0.8) * ASSUMED[i];
    }
    for (int j = 0; j < N; ++j) {
        x.q[j] = start[j] = (real)(0.8 * cos(1.0 + j));
    }
    for (int step = 0; step < 9000; ++step) {
        const int b = step / 3000, phase = step % 3000;
        if (phase == 0) {
            puma560_add_body(ACTUAL, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            if (told != 0) {
                puma560_add_body(X, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            }
            place(x.q, BODY[b].point, to);
        }
        spring(&x, BODY[b].point, to, J, tau);
        if (phase == 2000) { /* the push is along what all joints together move */
            double norm = 0.0, far = 0.0;
            place(x.q, BODY[b].point, before);
            for (int i = 0; i < 3; ++i) {
                way[i] = 0;
                for (int j = 0; j < N; ++j) {
                    way[i] += J[i * N + j];
                }
                norm += pow((double)way[i], 2.0);
                far += pow((double)(before[9 + i] - to[9 + i]), 2.0);
            }
            aside = fmax(aside, sqrt(far));
            for (int i = 0; i < 3; ++i) {
                way[i] *= F / (real)sqrt(norm);
            }
        }
        puma560_bias_torque(x.q, x.qd, X, h);
        for (int j = 0; j < N; ++j) {
            tau[j] += h[j] + HOLD * (start[j] - x.q[j]) - DAMP * x.qd[j];
            for (int i = 0; i < 3 && phase >= 2000; ++i) {
                tau[j] += J[i * N + j] * way[i];
            }
        }
        *failed |= move(&x, tau);
        if (phase == 2999) {
            double gone = 0.0;
            place(x.q, BODY[b].point, at);
            for (int i = 0; i < 3; ++i) {
                gone += (double)((at[9 + i] - before[9 + i]) * way[i] * K[0] / (F * F));
            }
            *off = fmax(*off, fabs(gone - 1.0));
        }
    }
    return aside;
}

int main(void)
{
    int failed = 0;
    double off[2] = { 0.0, 0.0 };
    const double told = handle(1, &off[1], &failed);
    puma560_add_body(ACTUAL, LINK, -BODY[0].mass, BODY[0].com, BODY[0].inertia);
    const double untold = handle(0, &off[0], &failed);
    printf("told: %.2e\nnot told: %.2e\noff F/K: %.3f\n", told, untold, off[1]);
    return failed == 0 && off[1] <= 0.15 && 3 * told <= untold ? 0 : 1;
}
