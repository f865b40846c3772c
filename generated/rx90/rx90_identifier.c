#include "rx90_identifier.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* Ring entry: DL (rx90_INERTIAL values), then the running integrals (rx90_INTEGRANDS values). */
#define SLOT (rx90_PARAMETERS + 1)

/* Of two neighbouring steps the one may be so many times the other. Beyond it the parabola
 * extrapolates far from its points, and noise in them would grow with the square of the ratio. */
#define LARGEST_RATIO 10

/* The offset of state is the alignment it needs. */
struct rx90_identifier_alignment {
    char byte;
    rx90_identifier state;
};

static int all_finite(const rx90_real *x, int length)
{
    int finite = 1;
    for (int i = 0; i < length; i++) {
        finite = finite && isfinite(x[i]);
    }
    return finite;
}

static rx90_real *slot(rx90_identifier *s, size_t position)
{
    return (rx90_real *)(void *)(s + 1) + position * SLOT;
}

/* The integrands at one sample. */
static void integrands(const rx90_real *q, const rx90_real *qd, const rx90_real *tau,
                       rx90_real *out)
{
    rx90_real power = 0;
    for (int j = 0; j < rx90_JOINTS; j++) {
        power += qd[j] * tau[j];
    }
    out[0] = power;
#if rx90_PARAMETERS > rx90_INERTIAL
    rx90_friction_power(q, qd, out + 1);
#else
    (void)q;
#endif
}

/* Three-point Adams-Moulton: the parabola through the values a, b, c, first and second apart in
 * time, integrated over the second interval (last nonzero) or over the first; the trapezoid minus
 * h^3/6 times the second divided difference. The error per step is of fourth order, of the whole of
 * third, on uneven steps too. At a reversal the Coulomb column |qd| has a kink: there, and only
 * there, the step is of second order.
 */
static void integrate(const rx90_real *a, const rx90_real *b, const rx90_real *c, rx90_real first,
                      rx90_real second, int last, rx90_real *out)
{
    const rx90_real h = last ? second : first;
    const rx90_real other = last ? first : second;
    const int uneven = h > LARGEST_RATIO * other;
    const rx90_real weight = uneven ? 0 : h * (h / (first + second)) / 6;
    const rx90_real ratio = uneven ? 0 : h / other;
    for (int i = 0; i < rx90_INTEGRANDS; i++) {
        const rx90_real own = last ? c[i] - b[i] : b[i] - a[i];
        const rx90_real next = last ? b[i] - a[i] : c[i] - b[i];
        const rx90_real bend = last ? own - ratio * next : ratio * next - own;
        const rx90_real ends = last ? b[i] + c[i] : a[i] + b[i];
        out[i] = h * ends / 2 - weight * bend;
    }
}

/* Add to the running integrals. Compensated (Kahan): over a long window of many small steps a plain
 * float sum would lose them digit by digit. */
static void accumulate(rx90_identifier *s, const rx90_real *increment)
{
    for (int i = 0; i < rx90_INTEGRANDS; i++) {
        const rx90_real part = increment[i] - s->carry[i];
        const rx90_real sum = s->sum[i] + part;
        s->carry[i] = (sum - s->sum[i]) - part;
        s->sum[i] = sum;
    }
}

static void rebase(rx90_identifier *s)
{
    memset(s->sum, 0, sizeof s->sum);
    memset(s->carry, 0, sizeof s->carry);
    s->position = 0;
}

/* The equation of a window: change of energy, work of friction; work of the motors. */
static void equation(const rx90_real *energy, const rx90_real *start, const rx90_real *integral,
                     rx90_real *row, rx90_real *y)
{
    for (int i = 0; i < rx90_INERTIAL; i++) {
        row[i] = energy[i] - start[i];
    }
    for (int i = 1; i < rx90_INTEGRANDS; i++) {
        row[rx90_INERTIAL + i - 1] = integral[i];
    }
    *y = integral[0];
}

/* Mode sliding. The integral over a window is a difference of running integrals. Running from the
 * first sample they would grow for ever, and their difference would drown in their rounding. So
 * they start again from 0 every `window` samples: a window that began in the block before this one
 * is (that block's integral - what it held where the window began) + (this block's so far). None of
 * the three exceeds what one window holds, so the error does not grow with the run; and every step
 * costs the same, whatever the length of the window.
 */
static int slide(rx90_identifier *s, const rx90_real *energy, rx90_real *row, rx90_real *y)
{
    if (s->position == s->window) {
        memcpy(s->block, s->sum, sizeof s->block);
        rebase(s);
        s->full = 1;
    }
    rx90_real *oldest = slot(s, s->position);
    if (s->full) {
        rx90_real integral[rx90_INTEGRANDS];
        for (int i = 0; i < rx90_INTEGRANDS; i++) {
            integral[i] = (s->block[i] - oldest[rx90_INERTIAL + i]) + s->sum[i];
        }
        equation(energy, oldest, integral, row, y);
    }
    memcpy(oldest, energy, rx90_INERTIAL * sizeof *oldest);
    memcpy(oldest + rx90_INERTIAL, s->sum, sizeof s->sum);
    return s->full;
}

/* Pass one interval, which ends where DL is energy. Nonzero when a window closes there; row and y
 * are its equation. */
static int advance(rx90_identifier *s, const rx90_real *increment, const rx90_real *energy,
                   rx90_real *row, rx90_real *y)
{
    accumulate(s, increment);
    s->position++;
    if (s->mode == rx90_WINDOW_SLIDING) {
        return slide(s, energy, row, y);
    }
    if (s->mode == rx90_WINDOW_CONSECUTIVE && s->position < s->window) {
        return 0;
    }
    equation(energy, s->start, s->sum, row, y);
    if (s->mode == rx90_WINDOW_CONSECUTIVE) {
        memcpy(s->start, energy, sizeof s->start);
        rebase(s);
    }
    return 1;
}

size_t rx90_identifier_size(size_t window)
{
    const size_t room = SIZE_MAX - sizeof(rx90_identifier);
    return window > room / (SLOT * sizeof(rx90_real)) ? 0 : rx90_IDENTIFIER_BYTES(window);
}

int rx90_identifier_init(void *state, size_t bytes, size_t window, int mode, rx90_real forgetting)
{
    rx90_identifier *s = (rx90_identifier *)state;
    const int sliding = mode == rx90_WINDOW_SLIDING;
    const int windowed = sliding || mode == rx90_WINDOW_CONSECUTIVE;
    const size_t needed = rx90_identifier_size(sliding ? window : 0);
    const size_t alignment = offsetof(struct rx90_identifier_alignment, state);
    if (s == NULL || (uintptr_t)state % alignment != 0 || needed == 0 || bytes < needed) {
        return 1;
    }
    if (!(windowed ? window > 0 : mode == rx90_WINDOW_START) ||
        !(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(state, 0, needed);
    s->mode = mode;
    s->window = window;
    return rx90_least_squares_init(&s->least_squares, forgetting);
}

int rx90_identifier_step(void *state, const rx90_real *q, const rx90_real *qd,
                         const rx90_real *tau, rx90_real dt)
{
    rx90_identifier *s = (rx90_identifier *)state;
    rx90_real energy[rx90_INERTIAL];
    rx90_real values[rx90_INTEGRANDS];
    if (!all_finite(q, rx90_JOINTS) || !all_finite(qd, rx90_JOINTS) ||
        !all_finite(tau, rx90_JOINTS) || (s->samples > 0 && !(dt > 0 && isfinite(dt)))) {
        return 1;
    }
    rx90_energy_regressor(q, qd, energy);
    integrands(q, qd, tau, values);
    if (!all_finite(energy, rx90_INERTIAL) || !all_finite(values, rx90_INTEGRANDS)) {
        return 1; /* finite, but so large that its energy is not */
    }
    if (s->samples == 0) {
        memcpy(s->start, energy, sizeof s->start);
        if (s->mode == rx90_WINDOW_SLIDING) {
            memset(slot(s, 0), 0, SLOT * sizeof(rx90_real));
            memcpy(slot(s, 0), energy, sizeof energy);
        }
        s->samples = 1;
    } else if (s->samples == 1) {
        memcpy(s->energy, energy, sizeof s->energy);
        s->samples = 2;
    } else {
        rx90_real increment[rx90_INTEGRANDS];
        rx90_real row[rx90_PARAMETERS];
        rx90_real y = 0;
        if (s->samples == 2) {
            /* Only now can the first interval be integrated; a window that ended with it is not
             * used, so that no step takes in more than one row. */
            integrate(s->before, s->latest, values, s->dt, dt, 0, increment);
            (void)advance(s, increment, s->energy, row, &y);
            s->samples = 3;
        }
        integrate(s->before, s->latest, values, s->dt, dt, 1, increment);
        if (advance(s, increment, energy, row, &y)) {
            (void)rx90_least_squares_update(&s->least_squares, row, y);
        }
    }
    memcpy(s->before, s->latest, sizeof s->before);
    memcpy(s->latest, values, sizeof s->latest);
    s->dt = dt;
    return 0;
}

void rx90_identifier_restart(void *state)
{
    rx90_identifier *s = (rx90_identifier *)state;
    rebase(s);
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
