#include "NAME_payload.h"
{% include "nan.c" %}

#include <float.h>
#include <math.h>
#include <string.h>

#define TEN NAME_PAYLOAD_PARAMETERS
#define ROWS (NAME_JOINTS * TEN)
#define COLUMNS NAME_PAYLOAD_COLUMNS

/* The largest size of q, qd and tau that is no fault of the measurement. */
#define LARGEST_SAMPLE 1e9
/* A wild sample and an outlier differ by so many times their usual deviation. */
#define GATE 10
/* So many windows in a row that are outliers are another load. */
#define MANY 3
/* Length of half a window, s. */
#define HALF 0.05
/* A step so many times as long as the one before, or longer than NAME_REST_TIME then, is a gap. */
#define LONGER 4
/* The median of normal errors, in standard deviations; the estimate moves by this share an equation
 * or more while there are few. */
#define MEDIAN 0.6745
#define LEAST_GAIN 0.05
/* The error of an equation is at first this share of the impulse of the torque, and never below
 * these shares of that of its joint and of all: sensors are no better. */
#define FIRST_ERROR 0.01
#define LEAST_ERROR 1e-4
#define LEAST_OF_ALL 1e-6
/* Equations contradict each other where their errors are so many times as large as usual. */
#define FAR 3
/* The correlation of the errors of neighbouring windows lies between these. */
#define OVERLAP 0.25
#define LARGEST_CORRELATION 0.9
/* The torque of the load is known where its standard deviation is this share of what is expected. */
#define KNOWN (1.0 / 30.0)
/* Positions in which that is asked{{ ", and gravity there, m/s2" if gravity_input }}. */
#define POSITIONS 64
{% if gravity_input %}
#define WEIGHT 9.81
{% endif %}
#define TURN 6.283185307179586

{% set part = "payload" %}
{% set PART = "PAYLOAD" %}
{% include "runtime/sample_limits.c" %}

/* The offset of state is the alignment it needs. */
struct NAME_payload_alignment {
    char byte;
    NAME_payload state;
};

static int all_plausible(const NAME_real *x, int count)
{
    int plausible = 1;
    for (int j = 0; j < count; j++) {
        plausible = plausible && x[j] <= (NAME_real)LARGEST_SAMPLE &&
                    x[j] >= (NAME_real)-LARGEST_SAMPLE;
    }
    return plausible;
}

/* Place of the diagonal of row i in a triangle. */
static int diagonal(int i)
{
    return i * TEN - i * (i - 1) / 2;
}

/* Forget the open window. */
static void rebase(NAME_payload *s)
{
    s->samples = 0;
    s->halves = 0;
    s->count = 0;
    s->elapsed = 0;
    memset(s->integral, 0, sizeof s->integral);
    memset(s->sum, 0, sizeof s->sum);
    for (int j = 0; j < NAME_JOINTS; j++) {
        s->joint[j].impulse = 0;
        s->joint[j].rested[0] = 0;
        s->joint[j].far = 0;
    }
}

{% include "runtime/samples.c" %}


/* Add the equation row'load = y, whose first `from` columns are 0, by Givens rotations. */
static void add(NAME_payload_equations *e, NAME_real *row, NAME_real y, int from)
{
    for (int i = from; i < TEN; i++) {
        NAME_real *R = e->R + diagonal(i);
        const NAME_real length = {{ sqrt }}(R[0] * R[0] + row[i] * row[i]);
        if (length > 0) {
            const NAME_real c = R[0] / length;
            const NAME_real sine = row[i] / length;
            const NAME_real z = e->z[i];
            for (int k = i; k < TEN; k++) {
                const NAME_real old = R[k - i];
                R[k - i] = c * old + sine * row[k];
                row[k] = c * row[k] - sine * old;
            }
            e->z[i] = c * z + sine * y;
            y = c * y - sine * z;
        }
    }
    e->rss += y * y;
}

/* Collect what all banks hold, and what was assumed. */
static void collect(NAME_payload *s)
{
    NAME_payload_equations *all = &s->all;
    memset(all, 0, sizeof *all);
    for (int i = 0; i < TEN; i++) {
        all->R[diagonal(i)] = 1 / s->assumed[i];
    }
    for (int b = 0; b < NAME_PAYLOAD_BANKS; b++) {
        const NAME_payload_equations *bank = s->bank + b;
        for (int i = 0; i < TEN && bank->count > 0; i++) {
            NAME_real row[TEN] = {0};
            memcpy(row + i, bank->R + diagonal(i), (size_t)(TEN - i) * sizeof *row);
            add(all, row, bank->z[i], i);
        }
        all->rss += bank->rss;
        all->count += bank->count;
    }
}

/* Time passes: the oldest part of the memory makes room for a new one. */
static void pass(NAME_payload *s, NAME_real dt)
{
    const NAME_real length = s->memory / NAME_PAYLOAD_BANKS;
    int ended = 0;
    s->age += dt;
    for (int b = 0; b < NAME_PAYLOAD_BANKS && s->age >= length; b++) {
        s->newest = (s->newest + 1) % NAME_PAYLOAD_BANKS;
        memset(s->bank + s->newest, 0, sizeof s->bank[0]);
        s->age -= length;
        ended = 1;
    }
    s->age = s->age < length ? s->age : 0; /* a gap longer than the memory */
    if (ended) {
        collect(s);
    }
}

/* Leverage of a row, and the error of its prediction. */
static NAME_real foresee(const NAME_payload_equations *e, const NAME_real *row, NAME_real y,
                         NAME_real *innovation)
{
    NAME_real left[TEN];
    NAME_real leverage = 0;
    memcpy(left, row, sizeof left);
    *innovation = y;
    for (int i = 0; i < TEN; i++) {
        const NAME_real *R = e->R + diagonal(i);
        const NAME_real u = left[i] / R[0];
        for (int k = i + 1; k < TEN; k++) {
            left[k] -= u * R[k - i];
        }
        leverage += u * u;
        *innovation -= u * e->z[i];
    }
    return leverage;
}

/* Move the error of a joint's equations to the median of their sizes, which are `ratio` now. */
static void learn_error(NAME_payload_joint *x, NAME_real ratio)
{
    const int few = (NAME_real)LEAST_GAIN * (NAME_real)(x->equations + 1) < 1;
    x->equations += few;
    const NAME_real gain = few ? 1 / (NAME_real)x->equations : (NAME_real)LEAST_GAIN;
    x->error *= ratio > (NAME_real)MEDIAN ? 1 + gain : 1 / (1 + gain);
}

/* Take the equation of a joint. */
static void take(NAME_payload *s, NAME_payload_joint *x, NAME_real *row, NAME_real y,
                 NAME_real least)
{
    NAME_payload_equations *bank = s->bank + s->newest;
    NAME_real innovation = 0;
    x->error = x->error > 0 ? x->error : (NAME_real)FIRST_ERROR * x->impulse;
    x->error = x->error > least ? x->error : least;
    for (int i = 0; i < TEN; i++) {
        row[i] /= x->error;
    }
    const NAME_real scaled = y / x->error;
    const NAME_real leverage = foresee(&s->all, row, scaled, &innovation);
    const NAME_real size = innovation < 0 ? -innovation : innovation;
    const NAME_real ratio = size / {{ sqrt }}(1 + leverage);
    const int learned = (NAME_real)LEAST_GAIN * (NAME_real)(x->equations + 1) >= 1;
    if (!isfinite(ratio)) {
        return;
    }
    if (leverage < 1) {
        learn_error(x, ratio);
    }
    if (ratio < GATE) {
        const NAME_real gain = (NAME_real)LEAST_GAIN / NAME_JOINTS;
        const NAME_real error = innovation < 0 ? -ratio : ratio;
        s->products += gain * (error * x->last - s->products);
        s->squares += gain * (error * error - s->squares);
        x->last = error;
    }
    x->far = learned && ratio > GATE ? x->far + 1 : 0;
    if (x->far > 0 && x->far < MANY) {
        return;
    }
    if (x->far == MANY) {
        memset(s->bank, 0, sizeof s->bank);
        s->changing = 1;
    }
    add(bank, row, scaled, 0);
    bank->count += 1;
}

/* Whether the torque of the load is known: the mean of its variance over many positions, against
 * that of the load that was assumed. inverse: of R. */
static int known(const NAME_payload *s, const NAME_real *inverse, NAME_real variance)
{
    NAME_real missing = 0;
    NAME_real expected = 0;
    for (int i = 0; i < TEN; i++) {
        for (int k = i; k < TEN; k++) {
            NAME_real covariance = 0;
            for (int c = k; c < TEN; c++) {
                covariance += inverse[diagonal(i) + c - i] * inverse[diagonal(k) + c - k];
            }
            missing += (i == k ? 1 : 2) * s->torques[diagonal(i) + k - i] * covariance;
        }
        expected += s->torques[diagonal(i)] * s->assumed[i] * s->assumed[i];
    }
    return missing * variance <= (NAME_real)(KNOWN * KNOWN) * expected;
}

/* Invert a triangle. */
static void invert(const NAME_real *R, NAME_real *inverse)
{
    for (int c = 0; c < TEN; c++) {
        inverse[diagonal(c)] = 1 / R[diagonal(c)];
        for (int i = c - 1; i >= 0; i--) {
            NAME_real sum = 0;
            for (int k = i + 1; k <= c; k++) {
                sum += R[diagonal(i) + k - i] * inverse[diagonal(k) + c - k];
            }
            inverse[diagonal(i) + c - i] = -sum / R[diagonal(i)];
        }
    }
}

/* Variance of the equations over what it was taken to be, at least 1. */
static NAME_real variance(const NAME_payload *s)
{
    const NAME_real found = s->all.count > 0 ? s->all.rss / s->all.count : 0;
    return found > 1 ? found : 1;
}

/* By how much the correlation r of errors of neighbouring windows enlarges the variance of what is
 * learned: (1 + r) / (1 - r), as if r^k were that over k windows. Windows that share half of their
 * samples have 1 / 4. */
static NAME_real repeated(const NAME_payload *s)
{
    const NAME_real found = s->squares > 0 ? s->products / s->squares : 0;
    const NAME_real least = (NAME_real)OVERLAP;
    const NAME_real most = (NAME_real)LARGEST_CORRELATION;
    const NAME_real r = found > least ? found : least;
    return r < most ? (1 + r) / (1 - r) : (1 + most) / (1 - most);
}

/* End half a window: the change of its mean is an equation of each joint. */
static void close_half(NAME_payload *s)
{
    NAME_real mean[COLUMNS];
    NAME_real all = 0;
    for (int i = 0; i < COLUMNS; i++) {
        mean[i] = s->sum[i] / s->count;
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        all += s->joint[j].impulse;
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        NAME_payload_joint *x = s->joint + j;
        NAME_real row[TEN];
        const NAME_real y = mean[ROWS + j] - s->before[ROWS + j];
        const NAME_real least =
            (NAME_real)LEAST_ERROR * x->impulse + (NAME_real)LEAST_OF_ALL * all;
        for (int i = 0; i < TEN; i++) {
            row[i] = mean[j * TEN + i] - s->before[j * TEN + i];
        }
        if (s->halves != 0 && least > 0 && x->rested[0] == 0 && x->rested[1] == 0) {
            take(s, x, row, y, least);
        } else {
            x->far = 0;
        }
        x->rested[1] = x->rested[0];
        x->rested[0] = x->still;
        x->impulse = 0;
    }
    for (int i = 0; i < COLUMNS; i++) {
        s->before[i] = mean[i] - s->integral[i];
    }
    memset(s->sum, 0, sizeof s->sum);
    memset(s->integral, 0, sizeof s->integral);
    s->count = 0;
    s->elapsed = 0;
    s->fresh = s->fresh != 0 || s->halves != 0;
    s->halves = 1;
    collect(s);
    if (s->changing != 0) {
        NAME_real inverse[NAME_PAYLOAD_TRIANGLE];
        invert(s->all.R, inverse);
        s->changing = !known(s, inverse, variance(s) * repeated(s));
    }
}

/* Value and rate of the columns at a sample: those of the load, joint by joint, then what the arm
 * does not explain. */
static void evaluate(const NAME_real *x, const NAME_real *X{{ G }}, NAME_real *value, NAME_real *rate)
{
    NAME_real p[NAME_JOINTS];
    NAME_real slope[NAME_JOINTS];
    NAME_load_momentum(x, x + NAME_JOINTS{{ g }}, value, rate);
    NAME_generalized_momentum(x, x + NAME_JOINTS, X{{ g }}, p, slope);
    for (int i = 0; i < ROWS; i++) {
        rate[i] = -rate[i];
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        value[ROWS + j] = -p[j];
        rate[ROWS + j] = x[2 * NAME_JOINTS + j] + slope[j];
    }
#if NAME_PARAMETERS > NAME_INERTIAL
    enum { FRICTION = NAME_PARAMETERS - NAME_INERTIAL };
    NAME_real F[NAME_JOINTS * FRICTION];
    NAME_friction_torque(x, x + NAME_JOINTS, F);
    for (int j = 0; j < NAME_JOINTS; j++) {
        for (int k = 0; k < FRICTION; k++) {
            rate[ROWS + j] -= F[j * FRICTION + k] * X[NAME_INERTIAL + k];
        }
    }
#endif
}

/* Integrate over the latest step: by the parabola through the latest three samples, or by the
 * trapezoid where there are two, or where the step is much longer than the one before. */
static void integrate(NAME_payload *s)
{
    const NAME_real h = s->steps[1];
    const NAME_real b = s->steps[0];
    NAME_real weight[3] = {0, h / 2, h / 2};
    if (s->samples == 3 && h < LONGER * b) {
        weight[0] = -h * h * h / (6 * b * (b + h));
        weight[1] = h * (3 * b + h) / (6 * b);
        weight[2] = h * (3 * b + 2 * h) / (6 * (b + h));
    }
    for (int i = 0; i < COLUMNS; i++) {
        s->integral[i] += weight[0] * s->rate[0][i] + weight[1] * s->rate[1][i] +
                          weight[2] * s->rate[2][i];
    }
}

/* Take the sample in the middle of those around it; the first ones as they came. */
static void take_sample(NAME_payload *s, const NAME_real *X)
{
    const int place = (s->arriving + NAME_PAYLOAD_SIDE) % NAME_PAYLOAD_AROUND;
    const NAME_real dt = s->step_to[place];
    NAME_real x[3 * NAME_JOINTS];
    NAME_real value[COLUMNS];
    for (int k = 0; k < 3 * NAME_JOINTS && s->arrived == NAME_PAYLOAD_AROUND; k++) {
        tame(s, k);
    }
    memcpy(x, s->around[place], sizeof x);
    pass(s, dt);
    find_rest(s, x, x + NAME_JOINTS, dt);
    if (s->resting != 0) {
        s->fresh = 0;
        return;
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        NAME_payload_joint *joint = s->joint + j;
        const NAME_real tau = x[2 * NAME_JOINTS + j];
        joint->impulse += dt * (tau < 0 ? -tau : tau);
        if (joint->still != 0) {
            joint->rested[0] = 1;
            x[j] = joint->held;
            x[NAME_JOINTS + j] = 0;
        }
    }
    memmove(s->rate[0], s->rate[1], 2 * sizeof s->rate[0]);
    s->steps[0] = s->steps[1];
    s->steps[1] = dt;
    evaluate(x, X{{ ", s->g" if gravity_input }}, value, s->rate[2]);
    s->samples += s->samples < 3;
    if (s->samples > 1) {
        integrate(s);
        s->elapsed += dt;
    }
    for (int i = 0; i < COLUMNS; i++) {
        s->sum[i] += value[i] + s->integral[i];
    }
    s->count += 1;
    if (s->within == 0 && s->elapsed >= (NAME_real)(HALF - NAME_REST_TIME / 2)) {
        close_half(s);
    }
}

static NAME_real draw(uint32_t *last)
{
    *last = (DRAW_FACTOR * *last + DRAW_TERM) % DRAW_RANGE;
    return (NAME_real)*last / (NAME_real)DRAW_RANGE - (NAME_real)0.5;
}

/* What a unit of each parameter does in many positions, at speeds of up to 1: torque and momentum. */
static void survey(NAME_payload *s)
{
    uint32_t last = 1;
    NAME_real state[2 * NAME_JOINTS];
    NAME_real columns[2 * ROWS];
    for (int position = 0; position < POSITIONS; position++) {
        for (int j = 0; j < NAME_JOINTS; j++) {
            state[j] = (NAME_real)TURN * draw(&last);
            state[NAME_JOINTS + j] = 2 * draw(&last);
        }
{% if gravity_input %}
        NAME_real g[3];
        for (int i = 0; i < 3; i++) {
            g[i] = 2 * (NAME_real)WEIGHT * draw(&last);
        }
{% endif %}
        NAME_load_momentum(state, state + NAME_JOINTS{{ g }}, columns, columns + ROWS);
        for (int row = 0; row < 2 * NAME_JOINTS; row++) {
            const NAME_real *a = columns + row * TEN;
            for (int i = 0; i < TEN; i++) {
                for (int k = i; k < TEN; k++) {
                    s->torques[diagonal(i) + k - i] += a[i] * a[k];
                }
            }
        }
    }
}

size_t NAME_payload_size(void)
{
    return sizeof(NAME_payload);
}

int NAME_payload_init(void *state, size_t bytes, NAME_real mass, NAME_real reach,
                      NAME_real memory)
{
    NAME_payload *s = (NAME_payload *)state;
    const size_t alignment = offsetof(struct NAME_payload_alignment, state);
    if (s == NULL || (uintptr_t)state % alignment != 0 || bytes < sizeof *s) {
        return 1;
    }
    if (!(mass > 0 && isfinite(mass) && reach > 0 && isfinite(reach)) ||
        !(memory > 0 && isfinite(memory))) {
        return 1;
    }
    memset(s, 0, sizeof *s);
    for (int i = 0; i < TEN; i++) {
        s->assumed[i] = mass * (i < 6 ? reach * reach : i < 9 ? reach : 1);
    }
    s->memory = memory;
    survey(s);
    rebase(s);
    collect(s);
    return NAME_OK;
}

int NAME_payload_step(void *state, const NAME_real *q, const NAME_real *qd, const NAME_real *tau,
                      NAME_real dt, const NAME_real *X{{ G }})
{
    NAME_payload *s = (NAME_payload *)state;
    const NAME_real step = dt + s->skipped;
    if (s->arrived > 0 && !(dt > 0 && isfinite(dt))) {
        return NAME_NOT_FINITE;
    }
    if (!all_plausible(q, NAME_JOINTS) || !all_plausible(qd, NAME_JOINTS) ||
        !all_plausible(tau, NAME_JOINTS) || !all_plausible(X, NAME_PARAMETERS)
        {{- " || !all_plausible(g, 3)" if gravity_input }}) {
        s->skipped = s->arrived > 0 ? step : 0;
        return NAME_NOT_FINITE;
    }
    s->skipped = 0;
    const int latest = (s->arriving + NAME_PAYLOAD_AROUND - 1) % NAME_PAYLOAD_AROUND;
    int broken = s->arrived > 1 && step > LONGER * s->step_to[latest] && step > (NAME_real)NAME_REST_TIME;
{% if gravity_input %}
    for (int i = 0; i < 3; i++) {
        broken = broken || s->g[i] < g[i] || s->g[i] > g[i];
        s->g[i] = g[i];
    }
{% endif %}
    if (broken) { /* no window holds a gap{{ ", or two mountings" if gravity_input }} */
        rebase(s);
        s->arrived = 0;
        pass(s, step);
    }
    NAME_real *sample = s->around[s->arriving];
    memcpy(sample, q, NAME_JOINTS * sizeof *q);
    memcpy(sample + NAME_JOINTS, qd, NAME_JOINTS * sizeof *qd);
    memcpy(sample + 2 * NAME_JOINTS, tau, NAME_JOINTS * sizeof *tau);
    s->step_to[s->arriving] = s->arrived > 0 ? step : 0;
    s->arriving = (s->arriving + 1) % NAME_PAYLOAD_AROUND;
    s->arrived += s->arrived < NAME_PAYLOAD_AROUND;
    if (s->arrived > NAME_PAYLOAD_SIDE) {
        take_sample(s, X);
    }
    return NAME_OK;
}

int NAME_payload_read(const void *state, NAME_real *load, NAME_real *std)
{
    const NAME_payload *s = (const NAME_payload *)state;
    NAME_real inverse[NAME_PAYLOAD_TRIANGLE];
    const NAME_real factor = variance(s) * repeated(s);
    int contradicted = variance(s) > FAR * FAR;
    invert(s->all.R, inverse);
    for (int i = 0; i < TEN; i++) {
        NAME_real square = 0;
        load[i] = 0;
        for (int k = i; k < TEN; k++) {
            const NAME_real part = inverse[diagonal(i) + k - i];
            load[i] += part * s->all.z[k];
            square += part * part;
        }
        std[i] = {{ sqrt }}(factor * square);
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        contradicted = contradicted || s->joint[j].far > 0;
    }
    if (contradicted) {
        return NAME_CHANGING;
    }
    if (s->changing != 0) {
        return NAME_CHANGING;
    }
    return s->fresh != 0 && known(s, inverse, factor) ? NAME_OK : NAME_NOT_EXCITED;
}

int NAME_payload_rest(void *state, const NAME_real *noise)
{
    NAME_payload *s = (NAME_payload *)state;
    for (int j = 0; noise != NULL && j < NAME_JOINTS; j++) {
        if (!(noise[j] >= 0 && noise[j] <= (NAME_real)LARGEST_SAMPLE)) {
            return NAME_NOT_FINITE;
        }
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        s->joint[j].stated = noise != NULL ? noise[j] : 0;
    }
    return NAME_OK;
}
