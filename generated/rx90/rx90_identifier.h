/* Identification on line by the energy model (Gautier and Khalil, 1988).
 *
 * Over a window (t1, t2) the work of the motors is the change of energy plus the work of friction:
 *
 *     integral qd'tau dt = [DL(t2) - DL(t1)]' X_inertial + [integral DF dt]' X_friction
 *
 * with DL from rx90_energy_regressor and DF from rx90_friction_power. No acceleration is needed.
 * Every window that closes is one row of a recursive least squares (rx90_least_squares.h). Where
 * rx90_identifier_momentum.h is in the package, it begins a state with n equations a window.
 *
 * Integrals are those of the polynomial of fifth degree through the six samples around each step
 * (of lower degree in the first two), for uneven steps too: of sixth order where the integrand is
 * smooth. At a reversal, where the Coulomb column |qd| has a kink, they are of second order, as
 * those of any such rule. Samples on both sides are needed: a window closes
 * rx90_IDENTIFIER_DELAY samples after its last, and the last ones of a log end no window.
 *
 * One thread at a time per state; states are independent. The caller owns the memory, aligned as
 * malloc aligns it or as a double is. Do not compile with -ffast-math.
 *
 *     static union {
 *         rx90_identifier head;
 *         unsigned char bytes[rx90_IDENTIFIER_BYTES(200)];
 *     } memory;
 *     rx90_identifier_init(&memory, sizeof memory, 200, rx90_WINDOW_SLIDING, 1);
 *     for (;;) {
 *         ... measure q, qd, tau ...
 *         rx90_identifier_step(&memory, q, qd, tau, dt);
 *         if (rx90_identifier_read(&memory, X, std) == 0) { ... X is determined ... }
 *     }
 */
#ifndef rx90_IDENTIFIER_H
#define rx90_IDENTIFIER_H

#include <stddef.h>

#include "rx90_least_squares.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    /* Every window starts at the first sample, as in the original paper. For short experiments:
     * errors of torque and integration add up over the run. */
    rx90_WINDOW_START = 0,
    /* Every sample closes a window that began `window` samples before. The windows overlap, so
     * their residuals are correlated and std comes out too small, by up to sqrt(window). */
    rx90_WINDOW_SLIDING = 1,
    /* A window begins where the last one ended: one row every `window` samples. */
    rx90_WINDOW_CONSECUTIVE = 2
};

enum {
    /* Samples that an interval waits for, after its end. */
    rx90_IDENTIFIER_DELAY = 2,
    rx90_IDENTIFIER_NODES = (2 * rx90_IDENTIFIER_DELAY) + 2,
    /* Arrays behind the head, the ring apart. */
    rx90_IDENTIFIER_ARRAYS = rx90_IDENTIFIER_NODES + rx90_IDENTIFIER_DELAY + 1 + 4
};

/* What a model is to the identifier. For each equation of a window,
 *
 *     [w, y] = change of value over the window + integral of rate,    w'X = y.
 *
 * At a sample this writes value and rate, each in three blocks: `equations` times the inertial
 * columns, then as often the friction columns, then the right-hand sides. Both are 0 at first: what
 * is always 0 need not be written. */
typedef void rx90_identifier_columns(const rx90_real *q, const rx90_real *qd,
                                     const rx90_real *tau, rx90_real *value, rx90_real *rate);

/* The head of the memory, public only to give its size to the compiler. Behind it arrays of `width`
 * values, in mode sliding one for each of the last `window` samples among them. */
typedef struct rx90_identifier {
    rx90_least_squares least_squares;
    rx90_identifier_columns *columns;
    size_t width;    /* equations (rx90_PARAMETERS + 1) */
    size_t window;
    size_t position; /* intervals since the base */
    rx90_real steps[rx90_IDENTIFIER_NODES - 1]; /* between the latest samples, the newest last */
    int equations;   /* a window */
    int mode;
    int next;        /* where the next sample goes, cyclic */
    int samples;     /* how many of the latest there are, up to rx90_IDENTIFIER_NODES */
    int full;        /* nonzero: the ring holds a whole window */
    int status;      /* of the latest step: bits of rx90_status */
    size_t refused;  /* equations in a row that were outliers */
    rx90_real largest; /* right-hand side of an equation taken */
} rx90_identifier;

/* Bytes of memory for a window of so many samples, as a constant expression. */
#define rx90_IDENTIFIER_BYTES(window) rx90_IDENTIFIER_BYTES_OF(1, window)
#define rx90_IDENTIFIER_BYTES_OF(equations, window)                          \
    (sizeof(rx90_identifier) + ((size_t)rx90_IDENTIFIER_ARRAYS + (window)) * \
        (size_t)(equations) * (rx90_PARAMETERS + 1) * sizeof(rx90_real))

/* The same as a function; 0 when it exceeds a size_t. Only mode sliding needs memory for its
 * window: 0 is enough for the two others. */
size_t rx90_identifier_size(size_t window);

/* Begin with no data.
 *
 * state: at least rx90_identifier_size(window) bytes; window: length in samples, at least 1,
 * ignored in mode start; forgetting, in (0, 1]: weight of the past, per row (1: keep everything;
 * below 1, equations that would teach less than is forgotten are left out: see the status).
 * Returns 0; nonzero (and the memory untouched) when an argument is out of range, the memory too
 * small or badly aligned.
 */
int rx90_identifier_init(void *state, size_t bytes, size_t window, int mode,
                         rx90_real forgetting);

/* The same for another model that is linear in X and has equations of this kind, from 1 to
 * rx90_JOINTS of them a window; all take the same weight, and forgetting is per equation. */
size_t rx90_identifier_size_of(int equations, size_t window);
int rx90_identifier_init_of(void *state, size_t bytes, size_t window, int mode,
                            rx90_real forgetting, int equations,
                            rx90_identifier_columns *columns);

/* Take the next sample: q, qd, tau of rx90_JOINTS values each, in rad or m, per s, N m or N; dt > 0
 * in s, the time since the last sample that was taken (ignored for the first). Returns 0; nonzero,
 * and the sample is as if it had never been, when a number is not finite or larger than 1e9, which
 * no robot's is, or dt not positive.
 *
 * At most one window closes, the first with the fourth sample at the earliest; the work is bounded,
 * whatever the window. Beside a step much longer than its neighbours (from about three times on)
 * fewer samples are used, down to the trapezoid: no polynomial reaches so far.
 */
int rx90_identifier_step(void *state, const rx90_real *q, const rx90_real *qd,
                         const rx90_real *tau, rx90_real dt);

/* What came of the equations that the latest step closed, as bits: rx90_OK, all were taken, or
 * there were none; otherwise some were not, and what was learned before stays as it is.
 *
 * rx90_OUTLIER: the right-hand side is more than 10 standard deviations from what the X so far,
 * known as well as it is, predicts, and by more than a tenth of the largest right-hand side taken
 * so far: a sample in the window is absurd. Windows that start at the first sample begin anew.
 * Where twice as many equations in a row are outliers as a window has samples, it is the robot
 * that has changed, and they are taken.
 *
 * rx90_NOT_EXCITED: with forgetting f, an equation makes the past weigh (1 - f) rx90_PARAMETERS
 * less, over all directions; one that brings less than a hundredth of that (its leverage, see
 * rx90_least_squares.h) would replace what is known by noise, as at standstill.
 *
 * Before X is determined nothing can be compared, and every equation is taken.
 */
int rx90_identifier_status(const void *state);

/* Forget the open windows, not what was learned: the next sample is a first one. For a new log, or
 * after a gap in the samples. */
void rx90_identifier_restart(void *state);

/* Restart, then step through a whole log: t (N,), q, qd, tau (N, rx90_JOINTS), row-major. Returns
 * 0, or the number (from 1) of the sample that was refused, where it stops (INT_MAX when the number
 * is larger). In float let t start near 0: at 1000 s its resolution is 6e-5 s.
 */
int rx90_identifier_run(void *state, size_t N, const rx90_real *t, const rx90_real *q,
                        const rx90_real *qd, const rx90_real *tau);

/* The parameters X and, unless NULL, their standard deviations, rx90_PARAMETERS values each.
 * Returns what rx90_least_squares_solve returns: 0, or the number of the first parameter that the
 * data do not determine. */
int rx90_identifier_read(const void *state, rx90_real *X, rx90_real *std);

/* The least squares inside, to look at or to merge into another. */
const rx90_least_squares *rx90_identifier_state(const void *state);

#ifdef __cplusplus
}
#endif

#endif
