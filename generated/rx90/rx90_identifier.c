#include "rx90_identifier.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#define FRICTION (rx90_PARAMETERS - rx90_INERTIAL)

/* An interval is integrated by the polynomial through its two ends and so many samples on each
 * side, as far as there are any. */
#define REACH rx90_IDENTIFIER_DELAY
#define NODES rx90_IDENTIFIER_NODES
/* Values of the samples that may still end an interval. */
#define VALUES (rx90_IDENTIFIER_DELAY + 1)

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
    AT_RING = rx90_IDENTIFIER_ARRAYS /* value + integral at the latest `window` samples (sliding) */
};

/* The offset of state is the alignment it needs. */
struct rx90_identifier_alignment {
    char byte;
    rx90_identifier state;
};

/* Whether these can be numbers of a robot; NaN cannot. */
static int all_plausible(const rx90_real *x)
{
    int plausible = 1;
    for (int j = 0; j < rx90_JOINTS; j++) {
        plausible = plausible && x[j] <= (rx90_real)LARGEST_SAMPLE &&
                    x[j] >= (rx90_real)-LARGEST_SAMPLE;
    }
    return plausible;
}

static int all_finite(const rx90_real *x, size_t length)
{
    int finite = 1;
    for (size_t i = 0; i < length; i++) {
        finite = finite && isfinite(x[i]);
    }
    return finite;
}

static rx90_real *array(rx90_identifier *s, size_t index)
{
    return (rx90_real *)(void *)(s + 1) + index * s->width;
}

/* The energy model: its inertial columns are differences alone, their rates stay 0. */
static void energy(const rx90_real *q, const rx90_real *qd, const rx90_real *tau, rx90_real *value,
                   rx90_real *rate)
{
    rx90_real power = 0;
    for (int j = 0; j < rx90_JOINTS; j++) {
        power += qd[j] * tau[j];
    }
    rx90_energy_regressor(q, qd, value);
#if rx90_PARAMETERS > rx90_INERTIAL
    rx90_friction_power(q, qd, rate + rx90_INERTIAL);
#endif
    rate[rx90_PARAMETERS] = power;
}

/* Weights of `count` nodes x for the integral over (0, 1), exact for the polynomial through the
 * nodes: Lagrange's polynomials at the three points of Gauss and Legendre, which integrate the
 * fifth degree. Returns the sum of the sizes of the weights. */
static rx90_real weigh(const rx90_real *x, int count, rx90_real *weight)
{
    static const rx90_real at[3] = {(rx90_real)0.11270166537925831, (rx90_real)0.5,
                                    (rx90_real)0.8872983346207417};
    static const rx90_real share[3] = {(rx90_real)(5.0 / 18.0), (rx90_real)(8.0 / 18.0),
                                       (rx90_real)(5.0 / 18.0)};
    rx90_real gain = 0;
    for (int i = 0; i < count; i++) {
        rx90_real below = 1;
        rx90_real above[3] = {share[0], share[1], share[2]};
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
static void integrate(rx90_identifier *s, int left)
{
    const rx90_real *steps = s->steps + (NODES - s->samples); /* steps[j]: from node j to j + 1 */
    const rx90_real h = steps[left];
    rx90_real x[NODES];
    rx90_real weight[NODES] = {0};
    const rx90_real *rate[NODES];
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
    rx90_real *sum = array(s, AT_SUM);
    rx90_real *carry = array(s, AT_CARRY);
    for (size_t i = 0; i < s->width; i++) {
        rx90_real increment = 0;
        for (int j = 0; j < count; j++) {
            increment += weight[j] * rate[j][i];
        }
        const rx90_real part = increment - carry[i];
        const rx90_real total = sum[i] + part;
        carry[i] = (total - sum[i]) - part;
        sum[i] = total;
    }
}

static void rebase(rx90_identifier *s)
{
    memset(array(s, AT_SUM), 0, s->width * sizeof(rx90_real));
    memset(array(s, AT_CARRY), 0, s->width * sizeof(rx90_real));
    s->position = 0;
}

/* What is wrong with an equation, if anything: the innovation test and the excitation test. */
static int judged(rx90_identifier *s, const rx90_real *row, rx90_real y)
{
    const rx90_least_squares *past = &s->least_squares;
    const size_t longest = s->mode == rx90_WINDOW_SLIDING ? s->window : 0;
    const size_t patience = 2 * (size_t)s->equations * (longest + NODES);
    const double freedom = past->count - (double)rx90_PARAMETERS;
    const rx90_real least =
        (rx90_real)LEAST_LEVERAGE * (rx90_real)rx90_PARAMETERS * (1 - past->forgetting);
    const rx90_real size = y < 0 ? -y : y;
    rx90_real innovation = 0;
    rx90_real leverage = 0;
    const int open = rx90_least_squares_foresee(past, row, y, &innovation, &leverage);
    const rx90_real wrong = innovation < 0 ? -innovation : innovation;
    if (open == 0 && leverage < least) {
        return rx90_NOT_EXCITED;
    }
    if (open == 0 && freedom > 0.0 && wrong > (rx90_real)LEAST_WRONG * s->largest) {
        const double gate = GATE * sqrt(past->rss / freedom * (1.0 + (double)leverage));
        if ((double)wrong > gate) {
            s->refused++;
            if (s->refused <= patience) {
                return rx90_OUTLIER;
            }
        }
    } else {
        s->refused = 0;
    }
    s->largest = size > s->largest ? size : s->largest;
    return rx90_OK;
}

/* Take in the equations of the window from `start` to where the value is `end`. */
static void close_window(rx90_identifier *s, const rx90_real *end, const rx90_real *start)
{
    const rx90_real *sum = array(s, AT_SUM);
    const rx90_real *block = array(s, AT_BLOCK);
    const size_t equations = (size_t)s->equations;
    for (size_t e = 0; e < equations; e++) {
        rx90_real row[rx90_PARAMETERS + 1];
        for (size_t i = 0; i <= rx90_PARAMETERS; i++) {
            const size_t k = i < rx90_INERTIAL     ? e * rx90_INERTIAL + i
                             : i < rx90_PARAMETERS ? equations * rx90_INERTIAL + e * FRICTION +
                                                         (i - rx90_INERTIAL)
                                                   : equations * rx90_PARAMETERS + e;
            row[i] = ((end[k] + sum[k]) - start[k]) + block[k];
        }
        const int status = judged(s, row, row[rx90_PARAMETERS]);
        if (status == rx90_OK) {
            (void)rx90_least_squares_update(&s->least_squares, row, row[rx90_PARAMETERS]);
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
static void advance(rx90_identifier *s, const rx90_real *end)
{
    const size_t bytes = s->width * sizeof(rx90_real);
    s->position++;
    if (s->mode != rx90_WINDOW_SLIDING) {
        if (s->mode == rx90_WINDOW_START || s->position == s->window) {
            close_window(s, end, array(s, AT_START));
        }
        if (s->mode == rx90_WINDOW_CONSECUTIVE && s->position == s->window) {
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
    const rx90_real *sum = array(s, AT_SUM);
    rx90_real *oldest = array(s, AT_RING + s->position);
    if (s->full) {
        close_window(s, end, oldest);
    }
    for (size_t i = 0; i < s->width; i++) {
        oldest[i] = end[i] + sum[i];
    }
}

size_t rx90_identifier_size(size_t window)
{
    return rx90_identifier_size_of(1, window);
}

size_t rx90_identifier_size_of(int equations, size_t window)
{
    if (equations < 1 || equations > rx90_JOINTS) {
        return 0;
    }
    const size_t slot = (size_t)equations * (rx90_PARAMETERS + 1) * sizeof(rx90_real);
    const size_t room = SIZE_MAX - sizeof(rx90_identifier) - AT_RING * slot;
    return window > room / slot ? 0 : rx90_IDENTIFIER_BYTES_OF(equations, window);
}

int rx90_identifier_init(void *state, size_t bytes, size_t window, int mode, rx90_real forgetting)
{
    return rx90_identifier_init_of(state, bytes, window, mode, forgetting, 1, energy);
}

int rx90_identifier_init_of(void *state, size_t bytes, size_t window, int mode,
                            rx90_real forgetting, int equations, rx90_identifier_columns *columns)
{
    rx90_identifier *s = (rx90_identifier *)state;
    const int sliding = mode == rx90_WINDOW_SLIDING;
    const int windowed = sliding || mode == rx90_WINDOW_CONSECUTIVE;
    const size_t needed = rx90_identifier_size_of(equations, sliding ? window : 0);
    const size_t alignment = offsetof(struct rx90_identifier_alignment, state);
    if (s == NULL || (uintptr_t)state % alignment != 0 || needed == 0 || bytes < needed) {
        return 1;
    }
    if (!(windowed ? window > 0 : mode == rx90_WINDOW_START) ||
        !(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(state, 0, needed);
    s->columns = columns;
    s->equations = equations;
    s->width = (size_t)equations * (rx90_PARAMETERS + 1);
    s->mode = mode;
    s->window = window;
    return rx90_least_squares_init(&s->least_squares, forgetting);
}

int rx90_identifier_step(void *state, const rx90_real *q, const rx90_real *qd,
                         const rx90_real *tau, rx90_real dt)
{
    rx90_identifier *s = (rx90_identifier *)state;
    /* Written over the oldest sample, which nobody reads any more. */
    rx90_real *rate = array(s, (size_t)(AT_RATE + s->next));
    rx90_real *value = array(s, (size_t)(AT_VALUE + s->next % VALUES));
    if (!all_plausible(q) || !all_plausible(qd) || !all_plausible(tau) ||
        (s->samples > 0 && !(dt > 0 && isfinite(dt)))) {
        return rx90_NOT_FINITE;
    }
    s->columns(q, qd, tau, value, rate);
    if (!all_finite(value, s->width) || !all_finite(rate, s->width)) {
        return rx90_NOT_FINITE;
    }
    s->status = rx90_OK;
    memmove(s->steps, s->steps + 1, sizeof s->steps - sizeof s->steps[0]);
    s->steps[NODES - 2] = dt;
    s->next = (s->next + 1) % NODES;
    s->samples += s->samples < NODES;
    if (s->samples == 1) {
        memcpy(array(s, s->mode == rx90_WINDOW_SLIDING ? AT_RING : AT_START), value,
               s->width * sizeof(rx90_real));
    } else if (s->samples >= REACH + 2) {
        integrate(s, s->samples - REACH - 2);
        advance(s, array(s, (size_t)(AT_VALUE + s->next % VALUES)));
        if (s->mode == rx90_WINDOW_START && (s->status & rx90_OUTLIER) != 0) {
            rx90_identifier_restart(state); /* every later window would hold the outlier, too */
        }
    }
    return rx90_OK;
}

int rx90_identifier_status(const void *state)
{
    return ((const rx90_identifier *)state)->status;
}

void rx90_identifier_restart(void *state)
{
    rx90_identifier *s = (rx90_identifier *)state;
    rebase(s);
    s->next = 0;
    s->samples = 0;
    s->full = 0;
}

int rx90_identifier_run(void *state, size_t N, const rx90_real *t, const rx90_real *q,
                        const rx90_real *qd, const rx90_real *tau)
{
    rx90_identifier_restart(state);
    for (size_t k = 0; k < N; k++) {
        const size_t at = k * rx90_JOINTS;
        const rx90_real dt = k > 0 ? t[k] - t[k - 1] : 0;
        if ((k == 0 && !isfinite(t[0])) ||
            rx90_identifier_step(state, q + at, qd + at, tau + at, dt) != 0) {
            return k < (size_t)INT_MAX ? (int)(k + 1) : INT_MAX;
        }
    }
    return 0;
}

int rx90_identifier_read(const void *state, rx90_real *X, rx90_real *std)
{
    return rx90_least_squares_solve(rx90_identifier_state(state), X, std, NULL);
}

const rx90_least_squares *rx90_identifier_state(const void *state)
{
    return &((const rx90_identifier *)state)->least_squares;
}
