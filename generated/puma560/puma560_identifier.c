#include "puma560_identifier.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#define FRICTION (puma560_PARAMETERS - puma560_INERTIAL)

/* An interval is integrated by the polynomial through its two ends and so many samples on each
 * side, as far as there are any. */
#define REACH puma560_IDENTIFIER_DELAY
#define NODES puma560_IDENTIFIER_NODES
/* Values of the samples that may still end an interval. */
#define VALUES (puma560_IDENTIFIER_DELAY + 1)

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
    AT_RING = puma560_IDENTIFIER_ARRAYS /* value + integral at the latest `window` samples (sliding) */
};

/* The offset of state is the alignment it needs. */
struct puma560_identifier_alignment {
    char byte;
    puma560_identifier state;
};

/* Whether these can be numbers of a robot; NaN cannot. */
static int all_plausible(const puma560_real *x)
{
    int plausible = 1;
    for (int j = 0; j < puma560_JOINTS; j++) {
        plausible = plausible && x[j] <= (puma560_real)LARGEST_SAMPLE &&
                    x[j] >= (puma560_real)-LARGEST_SAMPLE;
    }
    return plausible;
}

static int all_finite(const puma560_real *x, size_t length)
{
    int finite = 1;
    for (size_t i = 0; i < length; i++) {
        finite = finite && isfinite(x[i]);
    }
    return finite;
}

static puma560_real *array(puma560_identifier *s, size_t index)
{
    return (puma560_real *)(void *)(s + 1) + index * s->width;
}

/* The energy model: its inertial columns are differences alone, their rates stay 0. */
static void energy(const puma560_real *q, const puma560_real *qd, const puma560_real *tau, puma560_real *value,
                   puma560_real *rate)
{
    puma560_real power = 0;
    for (int j = 0; j < puma560_JOINTS; j++) {
        power += qd[j] * tau[j];
    }
    puma560_energy_regressor(q, qd, value);
#if puma560_PARAMETERS > puma560_INERTIAL
    puma560_friction_power(q, qd, rate + puma560_INERTIAL);
#endif
    rate[puma560_PARAMETERS] = power;
}

/* Weights of `count` nodes x for the integral over (0, 1), exact for the polynomial through the
 * nodes: Lagrange's polynomials at the three points of Gauss and Legendre, which integrate the
 * fifth degree. Returns the sum of the sizes of the weights. */
static puma560_real weigh(const puma560_real *x, int count, puma560_real *weight)
{
    static const puma560_real at[3] = {(puma560_real)0.11270166537925831, (puma560_real)0.5,
                                    (puma560_real)0.8872983346207417};
    static const puma560_real share[3] = {(puma560_real)(5.0 / 18.0), (puma560_real)(8.0 / 18.0),
                                       (puma560_real)(5.0 / 18.0)};
    puma560_real gain = 0;
    for (int i = 0; i < count; i++) {
        puma560_real below = 1;
        puma560_real above[3] = {share[0], share[1], share[2]};
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
static void integrate(puma560_identifier *s, int left)
{
    const puma560_real *steps = s->steps + (NODES - s->samples); /* steps[j]: from node j to j + 1 */
    const puma560_real h = steps[left];
    puma560_real x[NODES];
    puma560_real weight[NODES] = {0};
    const puma560_real *rate[NODES];
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
    puma560_real *sum = array(s, AT_SUM);
    puma560_real *carry = array(s, AT_CARRY);
    for (size_t i = 0; i < s->width; i++) {
        puma560_real increment = 0;
        for (int j = 0; j < count; j++) {
            increment += weight[j] * rate[j][i];
        }
        const puma560_real part = increment - carry[i];
        const puma560_real total = sum[i] + part;
        carry[i] = (total - sum[i]) - part;
        sum[i] = total;
    }
}

static void rebase(puma560_identifier *s)
{
    memset(array(s, AT_SUM), 0, s->width * sizeof(puma560_real));
    memset(array(s, AT_CARRY), 0, s->width * sizeof(puma560_real));
    s->position = 0;
}

/* What is wrong with an equation, if anything: the innovation test and the excitation test. */
static int judged(puma560_identifier *s, const puma560_real *row, puma560_real y)
{
    const puma560_least_squares *past = &s->least_squares;
    const size_t longest = s->mode == puma560_WINDOW_SLIDING ? s->window : 0;
    const size_t patience = 2 * (size_t)s->equations * (longest + NODES);
    const double freedom = past->count - (double)puma560_PARAMETERS;
    const puma560_real least =
        (puma560_real)LEAST_LEVERAGE * (puma560_real)puma560_PARAMETERS * (1 - past->forgetting);
    const puma560_real size = y < 0 ? -y : y;
    puma560_real innovation = 0;
    puma560_real leverage = 0;
    const int open = puma560_least_squares_foresee(past, row, y, &innovation, &leverage);
    const puma560_real wrong = innovation < 0 ? -innovation : innovation;
    if (open == 0 && leverage < least) {
        return puma560_NOT_EXCITED;
    }
    if (open == 0 && freedom > 0.0 && wrong > (puma560_real)LEAST_WRONG * s->largest) {
        const double gate = GATE * sqrt(past->rss / freedom * (1.0 + (double)leverage));
        if ((double)wrong > gate) {
            s->refused++;
            if (s->refused <= patience) {
                return puma560_OUTLIER;
            }
        }
    } else {
        s->refused = 0;
    }
    s->largest = size > s->largest ? size : s->largest;
    return puma560_OK;
}

/* Take in the equations of the window from `start` to where the value is `end`. */
static void close_window(puma560_identifier *s, const puma560_real *end, const puma560_real *start)
{
    const puma560_real *sum = array(s, AT_SUM);
    const puma560_real *block = array(s, AT_BLOCK);
    const size_t equations = (size_t)s->equations;
    for (size_t e = 0; e < equations; e++) {
        puma560_real row[puma560_PARAMETERS + 1];
        for (size_t i = 0; i <= puma560_PARAMETERS; i++) {
            const size_t k = i < puma560_INERTIAL     ? e * puma560_INERTIAL + i
                             : i < puma560_PARAMETERS ? equations * puma560_INERTIAL + e * FRICTION +
                                                         (i - puma560_INERTIAL)
                                                   : equations * puma560_PARAMETERS + e;
            row[i] = ((end[k] + sum[k]) - start[k]) + block[k];
        }
        const int status = judged(s, row, row[puma560_PARAMETERS]);
        if (status == puma560_OK) {
            (void)puma560_least_squares_update(&s->least_squares, row, row[puma560_PARAMETERS]);
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
static void advance(puma560_identifier *s, const puma560_real *end)
{
    const size_t bytes = s->width * sizeof(puma560_real);
    s->position++;
    if (s->mode != puma560_WINDOW_SLIDING) {
        if (s->mode == puma560_WINDOW_START || s->position == s->window) {
            close_window(s, end, array(s, AT_START));
        }
        if (s->mode == puma560_WINDOW_CONSECUTIVE && s->position == s->window) {
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
    const puma560_real *sum = array(s, AT_SUM);
    puma560_real *oldest = array(s, AT_RING + s->position);
    if (s->full) {
        close_window(s, end, oldest);
    }
    for (size_t i = 0; i < s->width; i++) {
        oldest[i] = end[i] + sum[i];
    }
}

size_t puma560_identifier_size(size_t window)
{
    return puma560_identifier_size_of(1, window);
}

size_t puma560_identifier_size_of(int equations, size_t window)
{
    if (equations < 1 || equations > puma560_JOINTS) {
        return 0;
    }
    const size_t slot = (size_t)equations * (puma560_PARAMETERS + 1) * sizeof(puma560_real);
    const size_t room = SIZE_MAX - sizeof(puma560_identifier) - AT_RING * slot;
    return window > room / slot ? 0 : puma560_IDENTIFIER_BYTES_OF(equations, window);
}

int puma560_identifier_init(void *state, size_t bytes, size_t window, int mode, puma560_real forgetting)
{
    return puma560_identifier_init_of(state, bytes, window, mode, forgetting, 1, energy);
}

int puma560_identifier_init_of(void *state, size_t bytes, size_t window, int mode,
                            puma560_real forgetting, int equations, puma560_identifier_columns *columns)
{
    puma560_identifier *s = (puma560_identifier *)state;
    const int sliding = mode == puma560_WINDOW_SLIDING;
    const int windowed = sliding || mode == puma560_WINDOW_CONSECUTIVE;
    const size_t needed = puma560_identifier_size_of(equations, sliding ? window : 0);
    const size_t alignment = offsetof(struct puma560_identifier_alignment, state);
    if (s == NULL || (uintptr_t)state % alignment != 0 || needed == 0 || bytes < needed) {
        return 1;
    }
    if (!(windowed ? window > 0 : mode == puma560_WINDOW_START) ||
        !(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(state, 0, needed);
    s->columns = columns;
    s->equations = equations;
    s->width = (size_t)equations * (puma560_PARAMETERS + 1);
    s->mode = mode;
    s->window = window;
    return puma560_least_squares_init(&s->least_squares, forgetting);
}

int puma560_identifier_step(void *state, const puma560_real *q, const puma560_real *qd,
                         const puma560_real *tau, puma560_real dt)
{
    puma560_identifier *s = (puma560_identifier *)state;
    /* Written over the oldest sample, which nobody reads any more. */
    puma560_real *rate = array(s, (size_t)(AT_RATE + s->next));
    puma560_real *value = array(s, (size_t)(AT_VALUE + s->next % VALUES));
    if (!all_plausible(q) || !all_plausible(qd) || !all_plausible(tau) ||
        (s->samples > 0 && !(dt > 0 && isfinite(dt)))) {
        return puma560_NOT_FINITE;
    }
    s->columns(q, qd, tau, value, rate);
    if (!all_finite(value, s->width) || !all_finite(rate, s->width)) {
        return puma560_NOT_FINITE;
    }
    s->status = puma560_OK;
    memmove(s->steps, s->steps + 1, sizeof s->steps - sizeof s->steps[0]);
    s->steps[NODES - 2] = dt;
    s->next = (s->next + 1) % NODES;
    s->samples += s->samples < NODES;
    if (s->samples == 1) {
        memcpy(array(s, s->mode == puma560_WINDOW_SLIDING ? AT_RING : AT_START), value,
               s->width * sizeof(puma560_real));
    } else if (s->samples >= REACH + 2) {
        integrate(s, s->samples - REACH - 2);
        advance(s, array(s, (size_t)(AT_VALUE + s->next % VALUES)));
        if (s->mode == puma560_WINDOW_START && (s->status & puma560_OUTLIER) != 0) {
            puma560_identifier_restart(state); /* every later window would hold the outlier, too */
        }
    }
    return puma560_OK;
}

int puma560_identifier_status(const void *state)
{
    return ((const puma560_identifier *)state)->status;
}

void puma560_identifier_restart(void *state)
{
    puma560_identifier *s = (puma560_identifier *)state;
    rebase(s);
    s->next = 0;
    s->samples = 0;
    s->full = 0;
}

int puma560_identifier_run(void *state, size_t N, const puma560_real *t, const puma560_real *q,
                        const puma560_real *qd, const puma560_real *tau)
{
    puma560_identifier_restart(state);
    for (size_t k = 0; k < N; k++) {
        const size_t at = k * puma560_JOINTS;
        const puma560_real dt = k > 0 ? t[k] - t[k - 1] : 0;
        if ((k == 0 && !isfinite(t[0])) ||
            puma560_identifier_step(state, q + at, qd + at, tau + at, dt) != 0) {
            return k < (size_t)INT_MAX ? (int)(k + 1) : INT_MAX;
        }
    }
    return 0;
}

int puma560_identifier_read(const void *state, puma560_real *X, puma560_real *std)
{
    return puma560_least_squares_solve(puma560_identifier_state(state), X, std, NULL);
}

const puma560_least_squares *puma560_identifier_state(const void *state)
{
    return &((const puma560_identifier *)state)->least_squares;
}
