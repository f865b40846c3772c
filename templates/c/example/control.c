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
    {{ name }}_mass_matrix(r.q, ASSUMED, M);
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
            {{ name }}_inverse_dynamics(x.q, x.qd, qdd, ASSUMED, tau);
            /* The drive holds each torque for a step: about a sample, their mean acts. */
            for (int j = 0; j < N; ++j) {
                held[j] = k > 0 ? (held[j] + tau[j]) / 2 : tau[j];
            }
            *failed |= {{ name }}_identifier_step(identifier, x.q, x.qd, held, (real)DT);
            if ((k + 1) % (STEPS / 4) == 0) {
                (void){{ name }}_identifier_read(identifier, X, NULL);
                printf("parameters after %.0f s: %.1e of their norm wrong\n", (k + 1) * DT, wrong(X));
            }
        }
        *failed |= move(&x, tau);
    }
    return sqrt(sum / ((double)STEPS * (double)N));
}
