/* twin: an example of a compliant tool (impedance control, Hogan 1985), once a millisecond.
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
#include "twin.h"

#include <math.h>
#include <stdio.h>

enum { N = twin_JOINTS, P = twin_PARAMETERS };

typedef twin_real real;

static const double DT = 1e-3; /* s */
enum { LINK = 7, LINKS = 7 }; /* that carries the tool; all of them */
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

/* Axes of the link's frame and a point of it, in frame 0: four vectors. */
static void place(const real *q, const real *point, real *x)
{
    real T[16 * LINKS];
    twin_frames(q, T);
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
    twin_link_jacobian(x->q, LINK, point, J);
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
        X[i] = (i < twin_INERTIAL ? 1 : (real)0.8) * ASSUMED[i];
    }
    for (int j = 0; j < N; ++j) {
        x.q[j] = start[j] = (real)(0.8 * cos(1.0 + j));
    }
    for (int step = 0; step < 9000; ++step) {
        const int b = step / 3000, phase = step % 3000;
        if (phase == 0) {
            twin_add_body(ACTUAL, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            if (told != 0) {
                twin_add_body(X, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
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
        twin_bias_torque(x.q, x.qd, X, h);
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
    twin_add_body(ACTUAL, LINK, -BODY[0].mass, BODY[0].com, BODY[0].inertia);
    const double untold = handle(0, &off[0], &failed);
    printf("told: %.2e\nnot told: %.2e\noff F/K: %.3f\n", told, untold, off[1]);
    return failed == 0 && off[1] <= 0.15 && 3 * told <= untold ? 0 : 1;
}
