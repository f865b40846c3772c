/* {{ name }}: forward dynamics as a unit of the Functional Mock-up Interface 2.0.
 *
 * Model exchange: states q, qd; inputs tau. Co-simulation: the method of Runge and Kutta of fourth
 * order, torques held over a communication step, which is divided into steps of at most
 * integration_step.
{% if dry %}
 *
 * FS sign(v) of dry friction is FS tanh(v/coulomb_width) here, so that a joint comes to rest without
 * an event: at rest under a load it creeps, slower than coulomb_width or not far above. Keep
 * integration_step below about coulomb_width M/FS, M the inertia that the joint feels.
{% endif %}
 */
#include "fmi2.h"

#include <math.h>
#include <string.h>

#include "{{ name }}.h"

enum {
    N = {{ name }}_JOINTS,
    P = {{ name }}_PARAMETERS,
    TAU = 0, /* value references: where each array begins */
    Q = N,
    QD = 2 * N,
    DER = 3 * N, /* of q, then of qd */
    X = 5 * N,
    STEP = 5 * N + P,
{% if dry %}
    WIDTH,
{% endif %}
    VALUES
};

static const char guid[] = "{{ guid }}";
static const fmi2Real start[VALUES] = {
    [X] = {{ starts|join(", ") }},
};
{% if dry %}

/* Dry friction: X[place] sign(v) with v = qd[first] + ratio qd[second] acts on both joints. */
static const struct {
    int place;
    int first;
    int second;
    fmi2Real ratio;
} dry[] = {
{% for d in dry %}
    { {{ d.place }}, {{ d.first }}, {{ d.second }}, {{ d.ratio }} },
{% endfor %}
};
{% endif %}

typedef struct {
    fmi2Real time;
    fmi2Real value[VALUES];
} state;

typedef struct {
    state now;
    fmi2CallbackFunctions use;
    int known; /* nonzero: the derivatives are those of the other values */
    char name[64];
} instance;

static fmi2Status fail(const instance *m, const char *why)
{
    if (m->use.logger != NULL) {
        m->use.logger(m->use.componentEnvironment, m->name, fmi2Error, "logStatusError", why);
    }
    return fmi2Error;
}

/* The accelerations of a state. Returns 0; nonzero: M is not positive definite. */
static int accelerate(const fmi2Real *value, const fmi2Real *q, const fmi2Real *qd, fmi2Real *qdd)
{
    {{ name }}_real position[N], speed[N], torque[N], parameters[P], out[N];
    fmi2Real tau[N];
    (void)memcpy(tau, value + TAU, sizeof tau);
{% if dry %}
    for (size_t i = 0; i < sizeof dry / sizeof dry[0]; ++i) {
        const fmi2Real v = qd[dry[i].first] + dry[i].ratio * qd[dry[i].second];
        const fmi2Real sign = (fmi2Real)((v > 0) - (v < 0));
        const fmi2Real less = value[X + dry[i].place] * (sign - tanh(v / value[WIDTH]));
        tau[dry[i].first] += less;
        tau[dry[i].second] += dry[i].ratio * less;
    }
{% endif %}
    for (int j = 0; j < N; ++j) {
        position[j] = ({{ name }}_real)q[j];
        speed[j] = ({{ name }}_real)qd[j];
        torque[j] = ({{ name }}_real)tau[j];
    }
    for (int i = 0; i < P; ++i) {
        parameters[i] = ({{ name }}_real)value[X + i];
    }
    const int status = {{ name }}_forward_dynamics(position, speed, torque, parameters, out);
    for (int j = 0; j < N; ++j) {
        qdd[j] = (fmi2Real)out[j];
    }
    return status;
}

/* Bring the derivatives up to date. */
static fmi2Status derive(instance *m)
{
    fmi2Real *value = m->now.value;
    if (m->known == 0) {
        (void)memcpy(value + DER, value + QD, N * sizeof *value);
        if (accelerate(value, value + Q, value + QD, value + DER + N) != 0) {
            return fail(m, "the mass matrix is not positive definite: look at the parameters");
        }
        m->known = 1;
    }
    return fmi2OK;
}

/* One step h of Runge and Kutta's method. Returns 0; nonzero: M is not positive definite. */
static int advance(fmi2Real *value, fmi2Real h)
{
    static const fmi2Real reach[] = { 0.0, 0.5, 0.5, 1.0 };
    static const fmi2Real weight[] = { 1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6 };
    fmi2Real rate[2 * N] = { 0 }, mean[2 * N] = { 0 };
    int failed = 0;
    for (int stage = 0; stage < 4; ++stage) {
        fmi2Real x[2 * N];
        for (int i = 0; i < 2 * N; ++i) {
            x[i] = value[Q + i] + reach[stage] * h * rate[i];
        }
        (void)memcpy(rate, x + N, N * sizeof *x);
        failed |= accelerate(value, x, x + N, rate + N);
        for (int i = 0; i < 2 * N; ++i) {
            mean[i] += weight[stage] * rate[i];
        }
    }
    for (int i = 0; i < 2 * N; ++i) {
        value[Q + i] += h * mean[i];
    }
    return failed;
}

{% include "interface.c" %}
