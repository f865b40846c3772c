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
#include "planar2r_simulated.h"

enum { STEPS = 60000, TENTH = STEPS / 10 };
static const real L = 10, K = 10; /* 1/s */

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
