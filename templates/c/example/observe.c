int main(void)
{
    enum { PERIOD = 1500, BEGIN = 1000, END = 1020, QUIET = 1200 };
    unsigned seed = 1;
    int failed = 0, wrong = 0, slowest = 0, seen = 0;
    double largest = 0.0; /* of r where nothing pushes */
    real r[N] = { 0 }, sum[N] = { 0 }, before[N] = { 0 }, tau[N] = { 0 }, r_qdd[N];
    motion x, ref;
    reference(0.0, &x, r_qdd);
    for (int step = 0; step < N * PERIOD; ++step) {
        const int joint = step / PERIOD, phase = step % PERIOD;
        real p[N], rate[N], rubs[N], qdd[N], acts[N];
        motion measured = x;
        int most = 0;
        reference(step * DT, &ref, r_qdd);
        for (int j = 0; j < N; ++j) {
            seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
            measured.qd[j] += (real)(4e-3 * ((double)seed / 2147483648.0 - 0.5));
        }
        {{ name }}_generalized_momentum(measured.q, measured.qd, ASSUMED{{ g }}, p, rate);
        {{ name }}_friction(measured.qd, ASSUMED, rubs);
        for (int j = 0; j < N; ++j) {
            rate[j] -= rubs[j];
            sum[j] = step == 0 ? p[j] : sum[j] + (real)DT * (tau[j] + (rate[j] + before[j]) / 2 + r[j]);
            r[j] = K * (p[j] - sum[j]);
            before[j] = rate[j];
            most = fabs((double)r[j]) > fabs((double)r[most]) ? j : most;
            qdd[j] = r_qdd[j] + KD * (ref.qd[j] - measured.qd[j]) + KP * (ref.q[j] - x.q[j]);
        }
        if (phase < BEGIN || phase >= QUIET) {
            largest = fmax(largest, fabs((double)r[most]));
            seen = 0;
        } else if (seen == 0 && fabs((double)r[most]) > (double)LEVEL) {
            seen = 1;
            wrong += most != joint;
            slowest = phase - BEGIN > slowest ? phase - BEGIN : slowest;
        }
        slowest = phase == QUIET - 1 && seen == 0 ? PERIOD : slowest;
        {{ name }}_inverse_dynamics(measured.q, measured.qd, qdd, ASSUMED{{ g }}, tau);
        for (int j = 0; j < N; ++j) {
            acts[j] = tau[j] + (j == joint && phase >= BEGIN && phase < END ? PUSH : 0);
        }
        failed |= move(&x, acts);
    }
    printf("slowest: %d ms\non another joint: %d\nlargest without a push: %.2f\n", slowest, wrong, largest);
    return failed == 0 && wrong == 0 && slowest <= 10 && largest < (double)LEVEL ? 0 : 1;
}
