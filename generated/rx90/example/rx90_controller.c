/* rx90: an example of a controller that calls the model once a millisecond.
 *
 * Computed torque, tau = ID(q, qd, qdd_r + Kd (qd_r - qd) + Kp (q_r - q)), moves a simulated robot
 * along a reference r. Every mass, inertia and friction that it assumes is 5 % wrong; meanwhile the
 * identifier learns them from q, qd and tau. Then tau = D (Kd (qd_r - qd) + Kp (q_r - q)) does the
 * same: a PD controller of the same gains, D the diagonal of the mass matrix at the start.
 *
 * Prints the tracking errors (root of the mean square over time and joints, rad or m) and the error
 * of the parameters. Exit status 0 when computed torque tracks at least 10 times better.
 */
#include "rx90_identifier.h"
#include "rx90_simulated.h"

enum { STEPS = 20000, WINDOW = 200 };
static const real KP = 900, KD = 60; /* 1/s2 and 1/s: both poles at 30 rad/s */

/* Follow the reference and return the tracking error: by computed torque, which the identifier
 * watches, or, without one, by PD. */
static double track(void *identifier, int *failed)
{
    double sum = 0.0;
    real r_qdd[N], tau[N] = { 0 }, M[N * N], X[P];
    motion x, r;
    for (int i = 0; i < P; ++i) {
        X[i] = ASSUMED[i]; /* until the identifier knows better */
    }
    reference(0.0, &x, r_qdd);
    rx90_mass_matrix(x.q, ASSUMED, M);
    for (int k = 0; k < STEPS; ++k) {
        real qdd[N], mean[N];
        reference(k * DT, &r, r_qdd);
        for (int j = 0; j < N; ++j) {
            const real e = r.q[j] - x.q[j], feedback = KD * (r.qd[j] - x.qd[j]) + KP * e;
            qdd[j] = r_qdd[j] + feedback;
            mean[j] = tau[j];
            tau[j] = M[j * N + j] * feedback;
            sum += pow((double)e, 2.0) / (STEPS * N);
        }
        if (identifier != NULL) {
            rx90_inverse_dynamics(x.q, x.qd, qdd, ASSUMED, tau);
            for (int j = 0; j < N; ++j) { /* drives hold each torque: about a sample, their mean acts */
                mean[j] = k == 0 ? tau[j] : (mean[j] + tau[j]) / 2;
            }
            *failed |= rx90_identifier_step(identifier, x.q, x.qd, mean, (real)DT);
            if ((k + 1) % (STEPS / 4) == 0) {
                (void)rx90_identifier_read(identifier, X, NULL);
                printf("parameters after %.0f s: %.1e of their norm wrong\n", (k + 1) * DT, wrong(X));
            }
        }
        *failed |= move(&x, tau);
    }
    return sqrt(sum);
}

int main(void)
{
    static union {
        rx90_identifier head;
        unsigned char bytes[rx90_IDENTIFIER_BYTES(WINDOW)];
    } memory;
    int failed = rx90_identifier_init(&memory, sizeof memory, WINDOW, rx90_WINDOW_SLIDING, 1);
    printf("parameters assumed: %.1e of their norm wrong\n", wrong(ASSUMED));
    const double model = track(&memory, &failed), pd = track(NULL, &failed);
    printf("computed torque: %.2e\nPD: %.2e\nratio: %.1f\n", model, pd, pd / model);
    return failed == 0 && 10 * model <= pd ? 0 : 1;
}
