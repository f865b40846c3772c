/* Hold for 2 s and be pushed for 1 s, three times; returns the largest distance before a push. */
static double handle(int told, double *off, int *failed)
{
    motion x = { { 0 }, { 0 } };
    real X[P], start[N], to[12], at[12], before[12], way[3], J[6 * N], h[N], tau[N];
    double aside = 0.0;
    for (int i = 0; i < P; ++i) {
        X[i] = (i < {{ name }}_INERTIAL ? 1 : (real){{ share }}) * ASSUMED[i];
    }
    for (int j = 0; j < N; ++j) {
        x.q[j] = start[j] = (real)(0.8 * cos(1.0 + j));
    }
    for (int step = 0; step < 9000; ++step) {
        const int b = step / 3000, phase = step % 3000;
        if (phase == 0) {
            {{ name }}_add_body(ACTUAL, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            if (told != 0) {
                {{ name }}_add_body(X, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
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
        {{ name }}_bias_torque(x.q, x.qd, X, h);
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
