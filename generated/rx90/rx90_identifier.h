/* Identification on line by the energy model (Gautier and Khalil, 1988).
 *
 * Over a window (t1, t2) the work of the motors is the change of energy plus the work of friction:
 *
 *     integral qd'tau dt = [DL(t2) - DL(t1)]' X_inertial + [integral DF dt]' X_friction
 *
 * with DL from rx90_energy_regressor and DF from rx90_friction_power. No acceleration is needed.
 * Every window that closes is one row of a recursive least squares (rx90_least_squares.h).
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

/* What is integrated: the power qd'tau, then the columns of the friction power. */
enum { rx90_INTEGRANDS = 1 + rx90_PARAMETERS - rx90_INERTIAL };

/* The head of the memory, public only to give its size to the compiler. In mode sliding the ring
 * follows it: for each of the last `window` samples DL and the running integrals. */
typedef struct rx90_identifier {
    rx90_least_squares least_squares;
    rx90_real start[rx90_INERTIAL];     /* DL where the window began (start, consecutive) */
    rx90_real energy[rx90_INERTIAL];    /* DL at the second sample */
    rx90_real before[rx90_INTEGRANDS];  /* integrands one sample before the latest */
    rx90_real latest[rx90_INTEGRANDS];  /* integrands at the latest sample */
    rx90_real sum[rx90_INTEGRANDS];     /* integrals since the base */
    rx90_real carry[rx90_INTEGRANDS];   /* what rounding lost from them (Kahan) */
    rx90_real block[rx90_INTEGRANDS];   /* integrals of the block before the base (sliding) */
    rx90_real dt;                       /* the latest step */
    size_t window;
    size_t position;                    /* intervals since the base */
    int mode;
    int samples;                        /* 0, 1, 2, then 3 for more */
    int full;                           /* nonzero: the ring holds a whole window */
} rx90_identifier;

/* Bytes of memory for a window of so many samples, as a constant expression. */
#define rx90_IDENTIFIER_BYTES(window) \
    (sizeof(rx90_identifier) + (size_t)(window) * (rx90_PARAMETERS + 1) * sizeof(rx90_real))

/* The same as a function; 0 when it exceeds a size_t. Only mode sliding needs memory for its
 * window: 0 is enough for the two others. */
size_t rx90_identifier_size(size_t window);

/* Begin with no data.
 *
 * state: at least rx90_identifier_size(window) bytes; window: length in samples, at least 1,
 * ignored in mode start; forgetting, in (0, 1]: weight of the past, per row (1: keep everything;
 * below 1, do not feed samples while the robot stands still: nothing new replaces what fades).
 * Returns 0; nonzero (and the memory untouched) when an argument is out of range, the memory too
 * small or badly aligned.
 */
int rx90_identifier_init(void *state, size_t bytes, size_t window, int mode,
                         rx90_real forgetting);

/* Take the next sample: q, qd, tau of rx90_JOINTS values each, in rad or m, per s, N m or N; dt > 0
 * in s, the time since the sample before (ignored for the first sample). Returns 0; nonzero (and
 * the state untouched) when a number is not finite or dt not positive. The first row comes with the
 * third sample at the earliest. A step more than ten times as long as the one before it (the very
 * first: as the one after it) is integrated by the trapezoid: no parabola reaches so far.
 */
int rx90_identifier_step(void *state, const rx90_real *q, const rx90_real *qd,
                         const rx90_real *tau, rx90_real dt);

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
