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
    {{ name }}_mass_matrix(x.q, ASSUMED, M);
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
        {{ name }}_slotine_li_regressor(x.q, x.qd, qdr, qddr{{ g }}, Y);
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
