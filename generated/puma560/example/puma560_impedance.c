/* puma560: an example of a compliant tool (impedance control, Hogan 1985), once a millisecond.
 *
 *     tau = J'(K e - D v) + C qd + g + 0.8 friction,    e = (x_r - x, sum of a x a_r / 2),
 *
 * with J and v = J qd of the tool's point x and a the axes of its frame: pushed by F the point gives way
 * by F/K. A weak spring on every joint holds what does not move the tool. At run time a tool is mounted,
 * a load taken, which moves the point, and both are put down again, and add_body tells the model of each.
 * Every mass, inertia and friction of the arm is 5 % wrong in it. Then a controller that nobody tells
 * does it.
 *
 * Prints, in m, how far the point is from its place before a push, at most, for both, and how far off
 * F/K it goes, relative. Exit status 0 when that is at most 15 % and the first at most a third of the
 * second.
 */
#include "puma560_simulated.h"

enum { LINK = 6, LINKS = 6 }; /* that carries the tool; all of them */
static const real K[2] = { 4000, 200 }, D[2] = { 200, 10 }; /* N/m, N m/rad; N s/m, N m s/rad */
static const real HOLD = 5, DAMP = 2, F = 40; /* N m/rad and N m s/rad, or N/m and N s/m; N, of a push */

/* A tool and a load come and go: mass, centre of mass, inertia about it, and then the tool's point. */
static const struct {
    real mass, com[3], inertia[6], point[3];
} BODY[] = {
    { 1, { 0, 0, (real)0.06 }, { (real)0.01, 0, 0, (real)0.01, 0, (real)0.01 }, { 0, 0, (real)0.12 } },
    { 3, { 0, 0, (real)0.18 }, { (real)0.02, 0, 0, (real)0.02, 0, (real)0.02 }, { 0, 0, (real)0.18 } },
    { -3, { 0, 0, (real)0.18 }, { (real)-0.02, 0, 0, (real)-0.02, 0, (real)-0.02 }, { 0, 0, (real)0.12 } },
    { -1, { 0, 0, (real)0.06 }, { (real)-0.01, 0, 0, (real)-0.01, 0, (real)-0.01 }, { 0, 0, 0 } },
};

/* Add the torque of springs and dampers that hold a point of the link and its frame where that is `to`;
 * gives J of the point, and e. Returns 0; nonzero when there is no such link. */
static int spring(const motion *x, const real *point, const real *to, real *J, real *e, real *tau)
{
    real T[16 * LINKS];
    puma560_frames(x->q, T);
    const int failed = puma560_link_jacobian(x->q, LINK, point, J);
    apart(&T[16 * (LINK - 1)], to, point, e);
    for (int i = 0; i < 6; ++i) {
        real pull = K[i / 3] * e[i];
        for (int j = 0; j < N; ++j) { pull -= D[i / 3] * J[i * N + j] * x->qd[j]; }
        for (int j = 0; j < N; ++j) { tau[j] += J[i * N + j] * pull; }
    }
    return failed;
}

int main(void)
{
    int failed = 0;
    double aside[2] = { 0.0, 0.0 }, off[2] = { 0.0, 0.0 }, before = 0.0;
    real X[P], T[16 * LINKS], J[6 * N], e[6], tau[N];
    motion x = rest(1.0), start = x;
    assume((real)0.8, X);
    for (int step = 0; step < 24000; ++step) { /* 3 s for each body, in the last of which a push */
        const int told = step < 12000, b = step / 3000 % 4, phase = step % 3000;
        if (phase == 0) {
            failed |= puma560_add_body(ACTUAL, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            if (told != 0) {
                failed |= puma560_add_body(X, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            }
            puma560_frames(x.q, T);
        }
        puma560_bias_torque(x.q, x.qd, X, tau);
        failed |= spring(&x, BODY[b].point, &T[16 * (LINK - 1)], J, e, tau);
        for (int j = 0; j < N; ++j) {
            tau[j] += HOLD * (start.q[j] - x.q[j]) - DAMP * x.qd[j];
        }
        const double at = push(phase < 2000 ? 0 : F, J, e, tau);
        if (phase == 1999) {
            before = at;
            aside[told] = fmax(aside[told], length(e));
        } else if (phase == 2999) {
            off[told] = fmax(off[told], fabs((before - at) * (double)(K[0] / F) - 1.0));
        }
        failed |= move(&x, tau);
    }
    printf("told: %.2e\nnot told: %.2e\noff F/K: %.3f\n", aside[1], aside[0], off[1]);
    return failed == 0 && off[1] <= 0.15 && 3 * aside[1] <= aside[0] ? 0 : 1;
}
