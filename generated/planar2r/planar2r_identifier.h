/* Identification on line by the energy model (Gautier and Khalil, 1988).
 *
 * Over a window (t1, t2) the work of the motors is the change of energy plus the work of friction:
 *
 *     integral qd'tau dt = [DL(t2) - DL(t1)]' X_inertial + [integral DF dt]' X_friction
 *
 * with DL from planar2r_energy_regressor and DF from planar2r_friction_power. No acceleration is needed.
 * Every window that closes is one row of a recursive least squares (planar2r_least_squares.h).
 *
 * One thread at a time per state; states are independent. The caller owns the memory, aligned as
 * malloc aligns it or as a double is. Do not compile with -ffast-math.
 *
 *     static union {
 *         planar2r_identifier head;
 *         unsigned char bytes[planar2r_IDENTIFIER_BYTES(200)];
 *     } memory;
 *     planar2r_identifier_init(&memory, sizeof memory, 200, planar2r_WINDOW_SLIDING, 1);
 *     for (;;) {
 *         ... measure q, qd, tau ...
 *         planar2r_identifier_step(&memory, q, qd, tau, dt);
 *         if (planar2r_identifier_read(&memory, X, std) == 0) { ... X is determined ... }
 *     }
 */
#ifndef planar2r_IDENTIFIER_H
#define planar2r_IDENTIFIER_H

#include <stddef.h>

#include "planar2r_least_squares.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    /* Every window starts at the first sample, as in the original paper. For short experiments:
     * errors of torque and integration add up over the run. */
    planar2r_WINDOW_START = 0,
    /* Every sample closes a window that began `window` samples before. The windows overlap, so
     * their residuals are correlated and std comes out too small, by up to sqrt(window). */
    planar2r_WINDOW_SLIDING = 1,
    /* A window begins where the last one ended: one row every `window` samples. */
    planar2r_WINDOW_CONSECUTIVE = 2
};

/* What is integrated: the power qd'tau, then the columns of the friction power. */
enum { planar2r_INTEGRANDS = 1 + planar2r_PARAMETERS - planar2r_INERTIAL };

/* The head of the memory, public only to give its size to the compiler. In mode sliding the ring
 * follows it: for each of the last `window` samples DL and the running integrals. */
typedef struct planar2r_identifier {
    planar2r_least_squares least_squares;
    planar2r_real start[planar2r_INERTIAL];     /* DL where the window began (start, consecutive) */
    planar2r_real energy[planar2r_INERTIAL];    /* DL at the second sample */
    planar2r_real before[planar2r_INTEGRANDS];  /* integrands one sample before the latest */
    planar2r_real latest[planar2r_INTEGRANDS];  /* integrands at the latest sample */
    planar2r_real sum[planar2r_INTEGRANDS];     /* integrals since the base */
    planar2r_real carry[planar2r_INTEGRANDS];   /* what rounding lost from them (Kahan) */
    planar2r_real block[planar2r_INTEGRANDS];   /* integrals of the block before the base (sliding) */
    planar2r_real dt;                       /* the latest step */
    size_t window;
    size_t position;                    /* intervals since the base */
    int mode;
    int samples;                        /* 0, 1, 2, then 3 for more */
    int full;                           /* nonzero: the ring holds a whole window */
} planar2r_identifier;

/* Bytes of memory for a window of so many samples, as a constant expression. */
#define planar2r_IDENTIFIER_BYTES(window) \
    (sizeof(planar2r_identifier) + (size_t)(window) * (planar2r_PARAMETERS + 1) * sizeof(planar2r_real))

/* The same as a function; 0 when it exceeds a size_t. Only mode sliding needs memory for its
 * window: 0 is enough for the two others. */
size_t planar2r_identifier_size(size_t window);

/* Begin with no data.
 *
 * state: at least planar2r_identifier_size(window) bytes; window: length in samples, at least 1,
 * ignored in mode start; forgetting, in (0, 1]: weight of the past, per row (1: keep everything;
 * below 1, do not feed samples while the robot stands still: nothing new replaces what fades).
 * Returns 0; nonzero (and the memory untouched) when an argument is out of range, the memory too
 * small or badly aligned.
 */
int planar2r_identifier_init(void *state, size_t bytes, size_t window, int mode,
                         planar2r_real forgetting);

/* Take the next sample: q, qd, tau of planar2r_JOINTS values each, in rad or m, per s, N m or N; dt > 0
 * in s, the time since the sample before (ignored for the first sample). Returns 0; nonzero (and
 * the state untouched) when a number is not finite or dt not positive. The first row comes with the
 * third sample at the earliest. A step more than ten times as long as the one before it (the very
 * first: as the one after it) is integrated by the trapezoid: no parabola reaches so far.
 */
int planar2r_identifier_step(void *state, const planar2r_real *q, const planar2r_real *qd,
                         const planar2r_real *tau, planar2r_real dt);

/* Forget the open windows, not what was learned: the next sample is a first one. For a new log, or
 * after a gap in the samples. */
void planar2r_identifier_restart(void *state);

/* Restart, then step through a whole log: t (N,), q, qd, tau (N, planar2r_JOINTS), row-major. Returns
 * 0, or the number (from 1) of the sample that was refused, where it stops (INT_MAX when the number
 * is larger). In float let t start near 0: at 1000 s its resolution is 6e-5 s.
 */
int planar2r_identifier_run(void *state, size_t N, const planar2r_real *t, const planar2r_real *q,
                        const planar2r_real *qd, const planar2r_real *tau);

/* The parameters X and, unless NULL, their standard deviations, planar2r_PARAMETERS values each.
 * Returns what planar2r_least_squares_solve returns: 0, or the number of the first parameter that the
 * data do not determine. */
int planar2r_identifier_read(const void *state, planar2r_real *X, planar2r_real *std);

/* The least squares inside, to look at or to merge into another. */
const planar2r_least_squares *planar2r_identifier_state(const void *state);

#ifdef __cplusplus
}
#endif

#endif
