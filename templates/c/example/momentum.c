/* p = M qd, and rate = C'qd - g - friction = (C + C') qd - h. */
static void momentum(const motion *x, real *p, real *rate)
{
    real M[N * N], C[N * N];
    {{ name }}_mass_matrix(x->q, ASSUMED, M);
    {{ name }}_coriolis(x->q, x->qd, ASSUMED, C);
    {{ name }}_bias_torque(x->q, x->qd, ASSUMED, rate);
    for (int j = 0; j < N; ++j) {
        p[j] = 0;
        rate[j] = -rate[j];
        for (int k = 0; k < N; ++k) {
            p[j] += M[j * N + k] * x->qd[k];
            rate[j] += (C[j * N + k] + C[k * N + j]) * x->qd[k];
        }
    }
}
