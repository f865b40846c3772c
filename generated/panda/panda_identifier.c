#include "panda_identifier.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#define FRICTION (panda_PARAMETERS - panda_INERTIAL)

/* An interval is integrated by the polynomial through its two ends and so many samples on each
 * side, as far as there are any. */
#define REACH panda_IDENTIFIER_DELAY
#define NODES panda_IDENTIFIER_NODES
/* Values of the samples that may still end an interval. */
#define VALUES (panda_IDENTIFIER_DELAY + 1)

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
    AT_RING = panda_IDENTIFIER_ARRAYS /* value + integral at the latest `window` samples (sliding) */
};

/* The offset of state is the alignment it needs. */
struct panda_identifier_alignment {
    char byte;
    panda_identifier state;
};

/* Whether these can be numbers of a robot; NaN cannot. */
static int all_plausible(const panda_real *x)
{
    int plausible = 1;
    for (int j = 0; j < panda_JOINTS; j++) {
        plausible = plausible && x[j] <= (panda_real)LARGEST_SAMPLE &&
                    x[j] >= (panda_real)-LARGEST_SAMPLE;
    }
    return plausible;
}

static int all_finite(const panda_real *x, size_t length)
{
    int finite = 1;
    for (size_t i = 0; i < length; i++) {
        finite = finite && isfinite(x[i]);
    }
    return finite;
}

static panda_real *array(panda_identifier *s, size_t index)
{
    return (panda_real *)(void *)(s + 1) + index * s->width;
}

/* The energy model: its inertial columns are differences alone, their rates stay 0. */
static void energy(const panda_real *q, const panda_real *qd, const panda_real *tau, panda_real *value,
                   panda_real *rate)
{
    panda_real power = 0;
    for (int j = 0; j < panda_JOINTS; j++) {
        power += qd[j] * tau[j];
    }
    panda_energy_regressor(q, qd, value);
#if panda_PARAMETERS > panda_INERTIAL
    panda_friction_power(q, qd, rate + panda_INERTIAL);
#endif
    rate[panda_PARAMETERS] = power;
}

/* Weights of `count` nodes x for the integral over (0, 1), exact for the polynomial through the
 * nodes: Lagrange's polynomials at the three points of Gauss and Legendre, which integrate the
 * fifth degree. Returns the sum of the sizes of the weights. */
static panda_real weigh(const panda_real *x, int count, panda_real *weight)
{
    static const panda_real at[3] = {(panda_real)0.11270166537925831, (panda_real)0.5,
                                    (panda_real)0.8872983346207417};
    static const panda_real share[3] = {(panda_real)(5.0 / 18.0), (panda_real)(8.0 / 18.0),
                                       (panda_real)(5.0 / 18.0)};
    panda_real gain = 0;
    for (int i = 0; i < count; i++) {
        panda_real below = 1;
        panda_real above[3] = {share[0], share[1], share[2]};
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
static void integrate(panda_identifier *s, int left)
{
    const panda_real *steps = s->steps + (NODES - s->samples); /* steps[j]: from node j to j + 1 */
    const panda_real h = steps[left];
    panda_real x[NODES];
    panda_real weight[NODES] = {0};
    const panda_real *rate[NODES];
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
    panda_real *sum = array(s, AT_SUM);
    panda_real *carry = array(s, AT_CARRY);
    for (size_t i = 0; i < s->width; i++) {
        panda_real increment = 0;
        for (int j = 0; j < count; j++) {
            increment += weight[j] * rate[j][i];
        }
        const panda_real part = increment - carry[i];
        const panda_real total = sum[i] + part;
        carry[i] = (total - sum[i]) - part;
        sum[i] = total;
    }
}

static void rebase(panda_identifier *s)
{
    memset(array(s, AT_SUM), 0, s->width * sizeof(panda_real));
    memset(array(s, AT_CARRY), 0, s->width * sizeof(panda_real));
    s->position = 0;
}

/* What is wrong with an equation, if anything: the innovation test and the excitation test. */
static int judged(panda_identifier *s, const panda_real *row, panda_real y)
{
    const panda_least_squares *past = &s->least_squares;
    const size_t longest = s->mode == panda_WINDOW_SLIDING ? s->window : 0;
    const size_t patience = 2 * (size_t)s->equations * (longest + NODES);
    const double freedom = past->count - (double)panda_PARAMETERS;
    const panda_real least =
        (panda_real)LEAST_LEVERAGE * (panda_real)panda_PARAMETERS * (1 - past->forgetting);
    const panda_real size = y < 0 ? -y : y;
    panda_real innovation = 0;
    panda_real leverage = 0;
    const int open = panda_least_squares_foresee(past, row, y, &innovation, &leverage);
    const panda_real wrong = innovation < 0 ? -innovation : innovation;
    if (open == 0 && leverage < least) {
        return panda_NOT_EXCITED;
    }
    if (open == 0 && freedom > 0.0 && wrong > (panda_real)LEAST_WRONG * s->largest) {
        const double gate = GATE * sqrt(past->rss / freedom * (1.0 + (double)leverage));
        if ((double)wrong > gate) {
            s->refused++;
            if (s->refused <= patience) {
                return panda_OUTLIER;
            }
        }
    } else {
        s->refused = 0;
    }
    s->largest = size > s->largest ? size : s->largest;
    return panda_OK;
}

/* Take in the equations of the window from `start` to where the value is `end`. */
static void close_window(panda_identifier *s, const panda_real *end, const panda_real *start)
{
    const panda_real *sum = array(s, AT_SUM);
    const panda_real *block = array(s, AT_BLOCK);
    const size_t equations = (size_t)s->equations;
    for (size_t e = 0; e < equations; e++) {
        panda_real row[panda_PARAMETERS + 1];
        for (size_t i = 0; i <= panda_PARAMETERS; i++) {
            const size_t k = i < panda_INERTIAL     ? e * panda_INERTIAL + i
                             : i < panda_PARAMETERS ? equations * panda_INERTIAL + e * FRICTION +
                                                         (i - panda_INERTIAL)
                                                   : equations * panda_PARAMETERS + e;
            row[i] = ((end[k] + sum[k]) - start[k]) + block[k];
        }
        const int status = judged(s, row, row[panda_PARAMETERS]);
        if (status == panda_OK) {
            (void)panda_least_squares_update(&s->least_squares, row, row[panda_PARAMETERS]);
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
static void advance(panda_identifier *s, const panda_real *end)
{
    const size_t bytes = s->width * sizeof(panda_real);
    s->position++;
    if (s->mode != panda_WINDOW_SLIDING) {
        if (s->mode == panda_WINDOW_START || s->position == s->window) {
            close_window(s, end, array(s, AT_START));
        }
        if (s->mode == panda_WINDOW_CONSECUTIVE && s->position == s->window) {
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
    const panda_real *sum = array(s, AT_SUM);
    panda_real *oldest = array(s, AT_RING + s->position);
    if (s->full) {
        close_window(s, end, oldest);
    }
    for (size_t i = 0; i < s->width; i++) {
        oldest[i] = end[i] + sum[i];
    }
}

size_t panda_identifier_size(size_t window)
{
    return panda_identifier_size_of(1, window);
}

size_t panda_identifier_size_of(int equations, size_t window)
{
    if (equations < 1 || equations > panda_JOINTS) {
        return 0;
    }
    const size_t slot = (size_t)equations * (panda_PARAMETERS + 1) * sizeof(panda_real);
    const size_t room = SIZE_MAX - sizeof(panda_identifier) - AT_RING * slot;
    return window > room / slot ? 0 : panda_IDENTIFIER_BYTES_OF(equations, window);
}

int panda_identifier_init(void *state, size_t bytes, size_t window, int mode, panda_real forgetting)
{
    return panda_identifier_init_of(state, bytes, window, mode, forgetting, 1, energy);
}

int panda_identifier_init_of(void *state, size_t bytes, size_t window, int mode,
                            panda_real forgetting, int equations, panda_identifier_columns *columns)
{
    panda_identifier *s = (panda_identifier *)state;
    const int sliding = mode == panda_WINDOW_SLIDING;
    const int windowed = sliding || mode == panda_WINDOW_CONSECUTIVE;
    const size_t needed = panda_identifier_size_of(equations, sliding ? window : 0);
    const size_t alignment = offsetof(struct panda_identifier_alignment, state);
    if (s == NULL || (uintptr_t)state % alignment != 0 || needed == 0 || bytes < needed) {
        return 1;
    }
    if (!(windowed ? window > 0 : mode == panda_WINDOW_START) ||
        !(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(state, 0, needed);
    s->columns = columns;
    s->equations = equations;
    s->width = (size_t)equations * (panda_PARAMETERS + 1);
    s->mode = mode;
    s->window = window;
    return panda_least_squares_init(&s->least_squares, forgetting);
}

int panda_identifier_step(void *state, const panda_real *q, const panda_real *qd,
                         const panda_real *tau, panda_real dt)
{
    panda_identifier *s = (panda_identifier *)state;
    /* Written over the oldest sample, which nobody reads any more. */
    panda_real *rate = array(s, (size_t)(AT_RATE + s->next));
    panda_real *value = array(s, (size_t)(AT_VALUE + s->next % VALUES));
    if (!all_plausible(q) || !all_plausible(qd) || !all_plausible(tau) ||
        (s->samples > 0 && !(dt > 0 && isfinite(dt)))) {
        return panda_NOT_FINITE;
    }
    s->columns(q, qd, tau, value, rate);
    if (!all_finite(value, s->width) || !all_finite(rate, s->width)) {
        return panda_NOT_FINITE;
    }
    s->status = panda_OK;
    memmove(s->steps, s->steps + 1, sizeof s->steps - sizeof s->steps[0]);
    s->steps[NODES - 2] = dt;
    s->next = (s->next + 1) % NODES;
    s->samples += s->samples < NODES;
    if (s->samples == 1) {
        memcpy(array(s, s->mode == panda_WINDOW_SLIDING ? AT_RING : AT_START), value,
               s->width * sizeof(panda_real));
    } else if (s->samples >= REACH + 2) {
        integrate(s, s->samples - REACH - 2);
        advance(s, array(s, (size_t)(AT_VALUE + s->next % VALUES)));
        if (s->mode == panda_WINDOW_START && (s->status & panda_OUTLIER) != 0) {
            panda_identifier_restart(state); /* every later window would hold the outlier, too */
        }
    }
    return panda_OK;
}

int panda_identifier_status(const void *state)
{
    return ((const panda_identifier *)state)->status;
}

void panda_identifier_restart(void *state)
{
    panda_identifier *s = (panda_identifier *)state;
    rebase(s);
    s->next = 0;
    s->samples = 0;
    s->full = 0;
}

int panda_identifier_run(void *state, size_t N, const panda_real *t, const panda_real *q,
                        const panda_real *qd, const panda_real *tau)
{
    panda_identifier_restart(state);
    for (size_t k = 0; k < N; k++) {
        const size_t at = k * panda_JOINTS;
        const panda_real dt = k > 0 ? t[k] - t[k - 1] : 0;
        if ((k == 0 && !isfinite(t[0])) ||
            panda_identifier_step(state, q + at, qd + at, tau + at, dt) != 0) {
            return k < (size_t)INT_MAX ? (int)(k + 1) : INT_MAX;
        }
    }
    return 0;
}

int panda_identifier_read(const void *state, panda_real *X, panda_real *std)
{
    return panda_least_squares_solve(panda_identifier_state(state), X, std, NULL);
}

const panda_least_squares *panda_identifier_state(const void *state)
{
    return &((const panda_identifier *)state)->least_squares;
}
