#include "twin_identifier.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#define FRICTION (twin_PARAMETERS - twin_INERTIAL)

/* An interval is integrated by the polynomial through its two ends and so many samples on each
 * side, as far as there are any. */
#define REACH twin_IDENTIFIER_DELAY
#define NODES twin_IDENTIFIER_NODES
/* Values of the samples that may still end an interval. */
#define VALUES (twin_IDENTIFIER_DELAY + 1)

/* By so much the rule may enlarge errors of the samples: the sum of the sizes of its weights over
 * the step. Six points at even steps have 1.26. Beside an interval much longer than its neighbours
 * the polynomial extrapolates far from its points; fewer points are taken then. */
#define LARGEST_GAIN 2

/* The largest size of q, qd and tau that is no fault of the measurement. */
#define LARGEST_SAMPLE 1e9

/* An outlier differs from its prediction by so many standard deviations, and by this share of the
 * largest right-hand side: residuals of a model that is not quite right grow with the motion. */
#define GATE 10
#define LEAST_WRONG 0.1
/* The share of the mean leverage, which balances forgetting, that an equation must have. */
#define LEAST_LEVERAGE 0.01

/* The arrays behind the head, of `width` values each: [value or rate] of the inertial columns of
 * all equations, then of their friction columns, then of their right-hand sides. */
enum {
    AT_RATE = 0,                 /* rates at the latest NODES samples, cyclic */
    AT_VALUE = AT_RATE + NODES,  /* values at the latest VALUES samples, cyclic */
    AT_START = AT_VALUE + VALUES, /* value where the window began (start, consecutive) */
    AT_SUM,                      /* integrals since the base */
    AT_CARRY,                    /* what rounding put into them too much (Kahan) */
    AT_BLOCK,                    /* integrals of the block before the base (sliding) */
    AT_RING = twin_IDENTIFIER_ARRAYS /* value + integral at the latest `window` samples (sliding) */
};

/* The offset of state is the alignment it needs. */
struct twin_identifier_alignment {
    char byte;
    twin_identifier state;
};

/* Whether these can be numbers of a robot; NaN cannot. */
static int all_plausible(const twin_real *x)
{
    int plausible = 1;
    for (int j = 0; j < twin_JOINTS; j++) {
        plausible = plausible && x[j] <= (twin_real)LARGEST_SAMPLE &&
                    x[j] >= (twin_real)-LARGEST_SAMPLE;
    }
    return plausible;
}

static int all_finite(const twin_real *x, size_t length)
{
    int finite = 1;
    for (size_t i = 0; i < length; i++) {
        finite = finite && isfinite(x[i]);
    }
    return finite;
}

static twin_real *array(twin_identifier *s, size_t index)
{
    return (twin_real *)(void *)(s + 1) + index * s->width;
}

/* The energy model: its inertial columns are differences alone, their rates stay 0. */
static void energy(const twin_real *q, const twin_real *qd, const twin_real *tau, twin_real *value,
                   twin_real *rate)
{
    twin_real power = 0;
    for (int j = 0; j < twin_JOINTS; j++) {
        power += qd[j] * tau[j];
    }
    twin_energy_regressor(q, qd, value);
#if twin_PARAMETERS > twin_INERTIAL
    twin_friction_power(q, qd, rate + twin_INERTIAL);
#endif
    rate[twin_PARAMETERS] = power;
}

/* Weights of `count` nodes x for the integral over (0, 1), exact for the polynomial through the
 * nodes: Lagrange's polynomials at the three points of Gauss and Legendre, which integrate the
 * fifth degree. Returns the sum of the sizes of the weights. */
static twin_real weigh(const twin_real *x, int count, twin_real *weight)
{
    static const twin_real at[3] = {(twin_real)0.11270166537925831, (twin_real)0.5,
                                    (twin_real)0.8872983346207417};
    static const twin_real share[3] = {(twin_real)(5.0 / 18.0), (twin_real)(8.0 / 18.0),
                                       (twin_real)(5.0 / 18.0)};
    twin_real gain = 0;
    for (int i = 0; i < count; i++) {
        twin_real below = 1;
        twin_real above[3] = {share[0], share[1], share[2]};
        for (int j = 0; j < count; j++) {
            if (j != i) {
                below *= x[i] - x[j];
                for (int g = 0; g < 3; g++) {
                    above[g] *= at[g] - x[j];
                }
            }
        }
        weight[i] = (above[0] + above[1] + above[2]) / below;
        gain += weight[i] < 0 ? -weight[i] : weight[i];
    }
    return gain;
}

/* Add the integral over the interval that begins at node `left` of the latest `samples` ones to the
 * running integrals. Compensated (Kahan): over a long window of many small steps a plain float sum
 * would lose them digit by digit. */
static void integrate(twin_identifier *s, int left)
{
    const twin_real *steps = s->steps + (NODES - s->samples); /* steps[j]: from node j to j + 1 */
    const twin_real h = steps[left];
    twin_real x[NODES];
    twin_real weight[NODES] = {0};
    const twin_real *rate[NODES];
    int first = left;
    int count = 2;
    x[left] = 0;
    x[left + 1] = 1;
    for (int j = left - 1; j >= 0; j--) {
        x[j] = x[j + 1] - steps[j] / h;
    }
    for (int j = left + 2; j < s->samples; j++) {
        x[j] = x[j - 1] + steps[j - 1] / h;
    }
    for (int reach = REACH; reach >= 0; reach--) {
        const int last = left + 1 + reach;
        first = left > reach ? left - reach : 0;
        count = (last < s->samples ? last + 1 : s->samples) - first;
        if (weigh(x + first, count, weight) <= LARGEST_GAIN) { /* not so for NaN */
            break;
        }
    }
    for (int j = 0; j < count; j++) {
        rate[j] = array(s, (size_t)(AT_RATE + (s->next + NODES - s->samples + first + j) % NODES));
        weight[j] *= h;
    }
    twin_real *sum = array(s, AT_SUM);
    twin_real *carry = array(s, AT_CARRY);
    for (size_t i = 0; i < s->width; i++) {
        twin_real increment = 0;
        for (int j = 0; j < count; j++) {
            increment += weight[j] * rate[j][i];
        }
        const twin_real part = increment - carry[i];
        const twin_real total = sum[i] + part;
        carry[i] = (total - sum[i]) - part;
        sum[i] = total;
    }
}

static void rebase(twin_identifier *s)
{
    memset(array(s, AT_SUM), 0, s->width * sizeof(twin_real));
    memset(array(s, AT_CARRY), 0, s->width * sizeof(twin_real));
    s->position = 0;
}

/* What is wrong with an equation, if anything: the innovation test and the excitation test. */
static int judged(twin_identifier *s, const twin_real *row, twin_real y)
{
    const twin_least_squares *past = &s->least_squares;
    const size_t longest = s->mode == twin_WINDOW_SLIDING ? s->window : 0;
    const size_t patience = 2 * (size_t)s->equations * (longest + NODES);
    const double freedom = past->count - (double)twin_PARAMETERS;
    const twin_real least =
        (twin_real)LEAST_LEVERAGE * (twin_real)twin_PARAMETERS * (1 - past->forgetting);
    const twin_real size = y < 0 ? -y : y;
    twin_real innovation = 0;
    twin_real leverage = 0;
    const int open = twin_least_squares_foresee(past, row, y, &innovation, &leverage);
    const twin_real wrong = innovation < 0 ? -innovation : innovation;
    if (open == 0 && leverage < least) {
        return twin_NOT_EXCITED;
    }
    if (open == 0 && freedom > 0.0 && wrong > (twin_real)LEAST_WRONG * s->largest) {
        const double gate = GATE * sqrt(past->rss / freedom * (1.0 + (double)leverage));
        if ((double)wrong > gate) {
            s->refused++;
            if (s->refused <= patience) {
                return twin_OUTLIER;
            }
        }
    } else {
        s->refused = 0;
    }
    s->largest = size > s->largest ? size : s->largest;
    return twin_OK;
}

/* Take in the equations of the window from `start` to where the value is `end`. */
static void close_window(twin_identifier *s, const twin_real *end, const twin_real *start)
{
    const twin_real *sum = array(s, AT_SUM);
    const twin_real *block = array(s, AT_BLOCK);
    const size_t equations = (size_t)s->equations;
    for (size_t e = 0; e < equations; e++) {
        twin_real row[twin_PARAMETERS + 1];
        for (size_t i = 0; i <= twin_PARAMETERS; i++) {
            const size_t k = i < twin_INERTIAL     ? e * twin_INERTIAL + i
                             : i < twin_PARAMETERS ? equations * twin_INERTIAL + e * FRICTION +
                                                         (i - twin_INERTIAL)
                                                   : equations * twin_PARAMETERS + e;
            row[i] = ((end[k] + sum[k]) - start[k]) + block[k];
        }
        const int status = judged(s, row, row[twin_PARAMETERS]);
        if (status == twin_OK) {
            (void)twin_least_squares_update(&s->least_squares, row, row[twin_PARAMETERS]);
        }
        s->status |= status;
    }
}

/* Pass one interval, which has been integrated and ends where the value is `end`.
 *
 * Mode sliding. The integral over a window is a difference of running integrals. Running from the
 * first sample they would grow for ever, and their difference would drown in their rounding. So
 * they start again from 0 every `window` samples: a window that began in the block before this one
 * is (this block's so far - what that block held where the window began) + (that block's integral).
 * None of the three exceeds what one window holds, so the error does not grow with the run; and
 * every step costs the same, whatever the length of the window.
 */
static void advance(twin_identifier *s, const twin_real *end)
{
    const size_t bytes = s->width * sizeof(twin_real);
    s->position++;
    if (s->mode != twin_WINDOW_SLIDING) {
        if (s->mode == twin_WINDOW_START || s->position == s->window) {
            close_window(s, end, array(s, AT_START));
        }
        if (s->mode == twin_WINDOW_CONSECUTIVE && s->position == s->window) {
            memcpy(array(s, AT_START), end, bytes);
            rebase(s);
        }
        return;
    }
    if (s->position == s->window) {
        memcpy(array(s, AT_BLOCK), array(s, AT_SUM), bytes);
        rebase(s);
        s->full = 1;
    }
    const twin_real *sum = array(s, AT_SUM);
    twin_real *oldest = array(s, AT_RING + s->position);
    if (s->full) {
        close_window(s, end, oldest);
    }
    for (size_t i = 0; i < s->width; i++) {
        oldest[i] = end[i] + sum[i];
    }
}

size_t twin_identifier_size(size_t window)
{
    return twin_identifier_size_of(1, window);
}

size_t twin_identifier_size_of(int equations, size_t window)
{
    if (equations < 1 || equations > twin_JOINTS) {
        return 0;
    }
    const size_t slot = (size_t)equations * (twin_PARAMETERS + 1) * sizeof(twin_real);
    const size_t room = SIZE_MAX - sizeof(twin_identifier) - AT_RING * slot;
    return window > room / slot ? 0 : twin_IDENTIFIER_BYTES_OF(equations, window);
}

int twin_identifier_init(void *state, size_t bytes, size_t window, int mode, twin_real forgetting)
{
    return twin_identifier_init_of(state, bytes, window, mode, forgetting, 1, energy);
}

int twin_identifier_init_of(void *state, size_t bytes, size_t window, int mode,
                            twin_real forgetting, int equations, twin_identifier_columns *columns)
{
    twin_identifier *s = (twin_identifier *)state;
    const int sliding = mode == twin_WINDOW_SLIDING;
    const int windowed = sliding || mode == twin_WINDOW_CONSECUTIVE;
    const size_t needed = twin_identifier_size_of(equations, sliding ? window : 0);
    const size_t alignment = offsetof(struct twin_identifier_alignment, state);
    if (s == NULL || (uintptr_t)state % alignment != 0 || needed == 0 || bytes < needed) {
        return 1;
    }
    if (!(windowed ? window > 0 : mode == twin_WINDOW_START) ||
        !(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(state, 0, needed);
    s->columns = columns;
    s->equations = equations;
    s->width = (size_t)equations * (twin_PARAMETERS + 1);
    s->mode = mode;
    s->window = window;
    return twin_least_squares_init(&s->least_squares, forgetting);
}

int twin_identifier_step(void *state, const twin_real *q, const twin_real *qd,
                         const twin_real *tau, twin_real dt)
{
    twin_identifier *s = (twin_identifier *)state;
    /* Written over the oldest sample, which nobody reads any more. */
    twin_real *rate = array(s, (size_t)(AT_RATE + s->next));
    twin_real *value = array(s, (size_t)(AT_VALUE + s->next % VALUES));
    if (!all_plausible(q) || !all_plausible(qd) || !all_plausible(tau) ||
        (s->samples > 0 && !(dt > 0 && isfinite(dt)))) {
        return twin_NOT_FINITE;
    }
    s->columns(q, qd, tau, value, rate);
    if (!all_finite(value, s->width) || !all_finite(rate, s->width)) {
        return twin_NOT_FINITE;
    }
    s->status = twin_OK;
    memmove(s->steps, s->steps + 1, sizeof s->steps - sizeof s->steps[0]);
    s->steps[NODES - 2] = dt;
    s->next = (s->next + 1) % NODES;
    s->samples += s->samples < NODES;
    if (s->samples == 1) {
        memcpy(array(s, s->mode == twin_WINDOW_SLIDING ? AT_RING : AT_START), value,
               s->width * sizeof(twin_real));
    } else if (s->samples >= REACH + 2) {
        integrate(s, s->samples - REACH - 2);
        advance(s, array(s, (size_t)(AT_VALUE + s->next % VALUES)));
        if (s->mode == twin_WINDOW_START && (s->status & twin_OUTLIER) != 0) {
            twin_identifier_restart(state); /* every later window would hold the outlier, too */
        }
    }
    return twin_OK;
}

int twin_identifier_status(const void *state)
{
    return ((const twin_identifier *)state)->status;
}

void twin_identifier_restart(void *state)
{
    twin_identifier *s = (twin_identifier *)state;
    rebase(s);
    s->next = 0;
    s->samples = 0;
    s->full = 0;
}

int twin_identifier_run(void *state, size_t N, const twin_real *t, const twin_real *q,
                        const twin_real *qd, const twin_real *tau)
{
    twin_identifier_restart(state);
    for (size_t k = 0; k < N; k++) {
        const size_t at = k * twin_JOINTS;
        const twin_real dt = k > 0 ? t[k] - t[k - 1] : 0;
        if ((k == 0 && !isfinite(t[0])) ||
            twin_identifier_step(state, q + at, qd + at, tau + at, dt) != 0) {
            return k < (size_t)INT_MAX ? (int)(k + 1) : INT_MAX;
        }
    }
    return 0;
}

int twin_identifier_read(const void *state, twin_real *X, twin_real *std)
{
    return twin_least_squares_solve(twin_identifier_state(state), X, std, NULL);
}

const twin_least_squares *twin_identifier_state(const void *state)
{
    return &((const twin_identifier *)state)->least_squares;
}
