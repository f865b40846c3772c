int main(void)
{
    int failed = 0;
    double aside[2] = { 0.0, 0.0 }, off[2] = { 0.0, 0.0 }, before = 0.0;
    real X[P], T[16 * LINKS], J[6 * N], e[6], tau[N];
    motion x = rest(1.0), start = x;
    assume((real){{ share }}, X);
    for (int step = 0; step < 24000; ++step) { /* 3 s for each body, in the last of which a push */
        const int told = step < 12000, b = step / 3000 % 4, phase = step % 3000;
        if (phase == 0) {
            failed |= {{ name }}_add_body(ACTUAL, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            if (told != 0) {
                failed |= {{ name }}_add_body(X, LINK, BODY[b].mass, BODY[b].com, BODY[b].inertia);
            }
            {{ name }}_frames(x.q, T);
        }
        {{ name }}_bias_torque(x.q, x.qd, X{{ g }}, tau);
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
    return failed == 0 && off[1] <= 0.15{% if falls %} && 3 * aside[1] <= aside[0]{% endif %} ? 0 : 1;
}
