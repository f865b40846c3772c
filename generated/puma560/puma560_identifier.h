/* Identification on line by the energy model (Gautier and Khalil, 1988).
 *
 * Over a window (t1, t2) the work of the motors is the change of energy plus the work of friction:
 *
 *     integral qd'tau dt = [DL(t2) - DL(t1)]' X_inertial + [integral DF dt]' X_friction
 *
 * with DL from puma560_energy_regressor and DF from puma560_friction_power. No acceleration is needed.
 * Every window that closes is one row of a recursive least squares (puma560_least_squares.h). Where
 * puma560_identifier_momentum.h is in the package, it begins a state with n equations a window.
 *
 * Integrals are those of the polynomial of fifth degree through the six samples around each step
 * (of lower degree in the first two), for uneven steps too: of sixth order where the integrand is
 * smooth. At a reversal, where the Coulomb column |qd| has a kink, they are of second order, as
 * those of any such rule. The weight of a sample in them is known five samples later: then its
 * columns are evaluated, once, and added to the windows that it belongs to, so that no column is
 * kept for a sample. Three samples more are waited for, to find wild ones. A window closes
 * puma560_IDENTIFIER_DELAY samples after its last; its equations are taken one a step from then on (a
 * few a step where a window has fewer samples than that). What has not been taken when a log ends
 * is not.
 *
 * One thread at a time per state; states are independent. The caller owns the memory, aligned as
 * malloc aligns it or as a double is. It does not compile with -ffast-math.
 *
 *     static union {
 *         puma560_identifier head;
 *         unsigned char bytes[puma560_IDENTIFIER_BYTES(200)];
 *     } memory;
 *     puma560_identifier_init(&memory, sizeof memory, 200, puma560_WINDOW_SLIDING, 1);
 *     for (;;) {
 *         ... measure q, qd, tau ...
 *         puma560_identifier_step(&memory, q, qd, tau, dt);
 *         status = puma560_identifier_read(&memory, X, std);
 *         if (status == puma560_OK) { ... X is that of the robot ... }
 *         if (status == puma560_CHANGING) { ... X is that of before a change ... }
 *     }
 *
 * Rest. A joint rests where the mean size of its speed over puma560_REST_TIME is at most 3 standard
 * deviations of the noise of qd: stated by puma560_identifier_rest, or estimated from third
 * differences of qd. Static friction can then take any value between its limits. The identifier
 * takes the speed of such a joint as 0 and its position as constant. The momentum model leaves out
 * the joint's equations of windows in which it rested. While all joints rest nothing is learned
 * and nothing forgotten, the status is puma560_NOT_EXCITED, and new windows begin with the next
 * motion.
 *
 * With forgetting below 1 only what the motion excites is forgotten (puma560_least_squares.h); all
 * else stays as it was. The memory should be longer than the period of the motion: what a quarter
 * of it does not excite is not forgotten. puma560_identifier_excited tells what that is.
 *
 * Wild samples. Each number of a sample is compared with the median of itself and of three on each
 * side, and replaced by that of the six where it is farther away than ten times the shortest
 * interval that holds half of them, and than ten times what one in ten of such intervals exceeds
 * (Hampel's test). A jump is not wild. Up to three wild samples in a row are found, not the first
 * three of a log.
 *
 * Changes. An equation that contradicts X is an outlier: a longer disturbance, or the robot has
 * changed, or X is wrong, as after outliers at the start. So a second estimate, the challenger,
 * learns the same equations from a later beginning, and is judged by itself alone. If it predicts
 * equations that neither has seen better than X, it takes the place of X; otherwise it begins anew.
 * It is as old as the larger of a memory and 256 equations, or 4 puma560_PARAMETERS of them, when that
 * is decided (shorter at first). Without forgetting each challenger is twice as old as the last
 * one; but one begins, of 4096 equations at most, when more than a fifth of the equations are
 * outliers. While the motion does not determine all parameters, nothing takes the place of X.
 *
 * Reading X and std takes many times as long as a step. In a cycle that it would not fit, read in
 * pieces, from a copy of what has been learned when it began:
 *
 *     static puma560_least_squares_solution found;
 *     puma560_least_squares_begin(&found, puma560_identifier_state(&memory));
 *     ... then in every cycle, after the step ...
 *         if (puma560_least_squares_proceed(&found, 4) == 0) {
 *             if (found.missing == 0) { ... found.X, found.std ... }
 *             puma560_least_squares_begin(&found, puma560_identifier_state(&memory));
 *         }
 */
#ifndef puma560_IDENTIFIER_H
#define puma560_IDENTIFIER_H

#include <stddef.h>
#include <stdint.h>

#include "puma560_least_squares.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    /* Every window starts at the first sample, as in the original paper; one closes every so many
     * samples as it has equations. For short experiments: errors of torque and integration add up
     * over the run. */
    puma560_WINDOW_START = 0,
    /* Windows of `window` samples, the next even number of them, each of which begins in the middle
     * of the one before: two open at a time. An equation is the mean over all windows of half that
     * length that lie in it, that is, weighted by a triangle: what the noise of a single sample at
     * an end does to it falls with the number of samples. Neighbours share half of their samples,
     * so std comes out too small, by up to a fifth. */
    puma560_WINDOW_SLIDING = 1,
    /* A window begins where the last one ended: one row every `window` samples. */
    puma560_WINDOW_CONSECUTIVE = 2
};

enum {
    /* Samples that an interval is integrated by. */
    puma560_IDENTIFIER_NODES = 6,
    /* Samples on each side that a sample is compared with, and all of these. */
    puma560_IDENTIFIER_SIDE = 3,
    puma560_IDENTIFIER_AROUND = 2 * puma560_IDENTIFIER_SIDE + 1,
    /* Samples that a window waits for, after its last. */
    puma560_IDENTIFIER_DELAY = puma560_IDENTIFIER_NODES + 1 + puma560_IDENTIFIER_SIDE,
    /* Windows that a sample may belong to beside its own, where they are short. */
    puma560_IDENTIFIER_BESIDE = puma560_IDENTIFIER_NODES - 1,
    /* Arrays behind the head, the windows apart. */
    puma560_IDENTIFIER_ARRAYS = 4
};

/* Length of the intervals in which joints rest or move, s; they have three samples at least. */
#define puma560_REST_TIME 0.01

/* What is known of a joint: its rest, and what is left of the equations in which it moved. */
typedef struct puma560_identifier_joint {
    puma560_real stated;    /* standard deviation of the noise of qd; 0: it is estimated */
    puma560_real noise;     /* the estimate; 0: there is none yet */
    puma560_real past[3];   /* speeds of which the noise is estimated, the newest last */
    puma560_real latest[2]; /* speeds of the latest two samples */
    puma560_real sum;       /* of the sizes of speeds in the interval */
    puma560_real held;      /* position at rest */
    int still;           /* nonzero: at rest */
    puma560_real rss;       /* its share of the sum of squares, with forgetting */
    puma560_real count;     /* and of the number of equations */
} puma560_identifier_joint;

/* What equations have taught. */
typedef struct puma560_identifier_estimate {
    puma560_least_squares least_squares;
    puma560_real largest; /* right-hand side of an equation taken */
    size_t contradicted; /* rises with equations that contradict X, falls with others */
    puma560_real missed;  /* mean square of recent innovations, over their variance */
    puma560_real allowed; /* the part of X in that variance */
} puma560_identifier_estimate;

/* What a model is to the identifier. For each equation of a window,
 *
 *     [w, y] = change of value over the window + integral of rate,    w'X = y.
 *
 * At a sample this writes value and rate, each in three blocks: `equations` times the inertial
 * columns, then as often the friction columns, then the right-hand sides. Both are 0 at first: what
 * is always 0 need not be written. */
typedef void puma560_identifier_columns(const puma560_real *q, const puma560_real *qd,
                                     const puma560_real *tau, puma560_real *value, puma560_real *rate);

/* The head of the memory, public only to give its size to the compiler. Behind it arrays of `width`
 * values, one for each open window among them. */
typedef struct puma560_identifier {
    puma560_identifier_estimate estimate[2]; /* the one that is read, and its challenger */
    int read;        /* which is read: 0 or 1 */
    size_t age;      /* of the challenger, in equations */
    size_t span;     /* to its end */
    int changing;    /* nonzero: recent equations contradict the X that is read */
    int examined;    /* rows of its R that the challenger has been examined by */
    puma560_real leverage; /* of the challenger on these */
    puma560_real lead;  /* sum of its scores */
    puma560_real squares; /* sum of their squares */
    puma560_identifier_columns *columns;
    size_t width;    /* equations (puma560_PARAMETERS + 1) */
    size_t length;   /* intervals between the beginnings of two windows */
    size_t left;     /* to the next beginning, from the third before the oldest sample on */
    /* q, qd, tau of the samples around the next one to be taken, cyclic; the steps to them. */
    puma560_real around[puma560_IDENTIFIER_AROUND][3 * puma560_JOINTS];
    puma560_real step_to[puma560_IDENTIFIER_AROUND];
    int arrived;     /* how many there are */
    int arriving;    /* where the next one goes */
    puma560_real spread[3 * puma560_JOINTS]; /* of half of them: one in ten is larger */
    int wild;        /* puma560_OUTLIER: a number was, since equations were looked at */
    /* q, qd, tau of the latest samples, cyclic, and their weights in the intervals around them. */
    puma560_real sample[puma560_IDENTIFIER_NODES][3 * puma560_JOINTS];
    puma560_real weight[puma560_IDENTIFIER_NODES][puma560_IDENTIFIER_NODES];
    puma560_real steps[puma560_IDENTIFIER_NODES - 1]; /* between them, the newest last */
    int equations;   /* a window */
    int rows;        /* equations taken a step, at most */
    int mode;
    int next;        /* where the next sample goes */
    int samples;     /* how many of the latest there are, up to puma560_IDENTIFIER_NODES */
    int begun;       /* nonzero: the first sample is behind */
    int places;      /* for windows, cyclic */
    int place;       /* of the window that began last at the third interval before the oldest */
    int newest;      /* place of the window that began last */
    int carry;       /* which carry is that of the newest: 0 or 1 */
    int whole;       /* nonzero: a window has begun in which the oldest sample falls (sliding) */
    int last;        /* place of the window whose equations are taken */
    int pending;     /* how many are still to be taken */
    int status;      /* of the equations looked at last: bits of puma560_status */
    puma560_identifier_joint joint[puma560_JOINTS];
    puma560_real interval;  /* time in it, s */
    int within;          /* samples in it */
    puma560_real look;      /* time in it of the speed that the noise is estimated of */
    int looked;          /* nonzero: it has passed */
    puma560_real since;     /* time since the last such speed */
    puma560_real spans[3];  /* times between the latest ones, the newest last */
    int looks;           /* since the first sample, up to 3 */
    uint32_t draw;       /* a random number */
    int seen;            /* nonzero: there was a sample */
    int resting;         /* nonzero: all joints rest */
    /* Joints that rested in each open window. */
    unsigned char rested[puma560_IDENTIFIER_BESIDE + 2][puma560_JOINTS];
    puma560_real forgetting; /* per sample */
    /* What the samples of this memory, and of the one before it, took from each variance of X, over
     * sigma^2. */
    puma560_real gained[puma560_PARAMETERS];
    puma560_real gained_before[puma560_PARAMETERS];
    puma560_real aged; /* share of this memory that has passed */
} puma560_identifier;

/* Bytes of memory for a window of so many samples, as a constant expression: the same for every
 * window of at least twice (equations + 4) samples. */
#define puma560_IDENTIFIER_BYTES(window) puma560_IDENTIFIER_BYTES_OF(1, window)
#define puma560_IDENTIFIER_BYTES_OF(equations, window)                                       \
    (sizeof(puma560_identifier) +                                                            \
        ((size_t)puma560_IDENTIFIER_ARRAYS + puma560_IDENTIFIER_PLACES(equations, window)) *    \
            (size_t)(equations) * (puma560_PARAMETERS + 1) * sizeof(puma560_real))
#define puma560_IDENTIFIER_PLACES(equations, window)                                         \
    ((size_t)(window) / 2u + (size_t)(window) % 2u >= (size_t)(equations) + 4u            \
        ? 3u : (size_t)puma560_IDENTIFIER_BESIDE + 2u)

/* The same as a function; 0 where there is no such identifier. Only mode sliding needs memory for
 * its window: 0 is enough for the two others. */
size_t puma560_identifier_size(size_t window);

/* Begin with no data.
 *
 * state: at least puma560_identifier_size(window) bytes; window: length in samples, at least 1,
 * ignored in mode start; forgetting, in (0, 1]: weight of the past, per sample of a motion that
 * excites all parameters (1: keep everything; below 1, equations that would teach much less than
 * they replace are left out: see the status). So
 * 1 / (1 - forgetting) samples are remembered, whatever the mode, the window and the equations of a
 * window, and 4 puma560_PARAMETERS equations at least.
 * Returns 0; nonzero (and the memory untouched) when an argument is out of range, the memory too
 * small or badly aligned.
 */
int puma560_identifier_init(void *state, size_t bytes, size_t window, int mode,
                         puma560_real forgetting);

/* The same for another model that is linear in X and has equations of this kind, from 1 to
 * puma560_JOINTS of them a window, which all take the same weight. */
size_t puma560_identifier_size_of(int equations, size_t window);
int puma560_identifier_init_of(void *state, size_t bytes, size_t window, int mode,
                            puma560_real forgetting, int equations,
                            puma560_identifier_columns *columns);

/* Take the next sample: q, qd, tau of puma560_JOINTS values each, in rad or m, per s, N m or N; dt > 0
 * in s, the time since the last sample that was taken (ignored for the first). Returns 0; nonzero,
 * and the sample is as if it had never been, when a number is not finite or larger than 1e9, which
 * no robot's is, or dt not positive.
 *
 * At most one window closes, the first with the twelfth sample at the earliest; the work is
 * bounded, whatever the window: the columns of one sample, and one equation of each of the two
 * estimates, with two rows of their comparison. Beside a step much longer than
 * its neighbours (from about three times on) fewer samples are used, down to the trapezoid: no
 * polynomial reaches so far.
 */
int puma560_identifier_step(void *state, const puma560_real *q, const puma560_real *qd,
                         const puma560_real *tau, puma560_real dt);

/* What came of the equations that a step looked at last, as bits: puma560_OK, all were taken, or there
 * were none so far; otherwise some were not, and what was learned before stays as it is.
 *
 * puma560_OUTLIER: the right-hand side is more than 10 standard deviations from what the X so far,
 * known as well as it is, predicts, and by more than a thousandth of the largest right-hand side
 * taken so far, or an equation is not finite. Windows that start at the first sample begin anew. Or
 * a number of a sample was wild since equations were looked at before, and has been replaced.
 *
 * puma560_NOT_EXCITED: with forgetting f, equations leave the past a share f of its weight, which is
 * (1 - f) puma560_PARAMETERS less over all directions; one that brings less than a hundredth of that
 * (its leverage, see puma560_least_squares.h) would replace what is known by noise. Also where all
 * joints rest, or the joint of an equation.
 *
 * puma560_CHANGING: the robot is no longer the one that X is of. More than a fifth of the equations
 * contradict X by more than three standard deviations, for as many as eight windows have; at most a
 * ninth does so by chance, whatever the noise (Chebyshev). X then stays, and a second estimate goes
 * on from it: known so much worse that these equations agree. It takes the place of X when it
 * predicts new equations better, and when three standard deviations of what it predicts for the
 * motion of before, too, are less than what X misses. The bit also ends when X is right again, or
 * when no other X is better for a long time: then the equations are as noisy as that.
 *
 * Before X is determined nothing can be compared, and every equation is taken.
 */
int puma560_identifier_status(const void *state);

/* Forget the open windows and equations that are still to be taken, not what was learned: the next
 * sample is a first one. For a new log, or after a gap in the samples. */
void puma560_identifier_restart(void *state);

/* Restart, then step through a whole log: t (N,), q, qd, tau (N, puma560_JOINTS), row-major. Returns
 * 0, or the number (from 1) of the sample that was refused, where it stops (INT_MAX when the number
 * is larger). In float let t start near 0: at 1000 s its resolution is 6e-5 s.
 */
int puma560_identifier_run(void *state, size_t N, const puma560_real *t, const puma560_real *q,
                        const puma560_real *qd, const puma560_real *tau);

/* The parameters X and, unless NULL, their standard deviations, puma560_PARAMETERS values each.
 * Returns what puma560_least_squares_solve returns, 0 or the number of the first parameter that the
 * data do not determine; or puma560_CHANGING: X and std are those of before a change of the robot,
 * such as a load, until another X is better (see puma560_identifier_status). */
int puma560_identifier_read(const void *state, puma560_real *X, puma560_real *std);

/* The noise of qd: standard deviations, puma560_JOINTS values in rad/s or m/s. 0, or NULL for all
 * joints: it is estimated, as at first. Returns 0; nonzero (and nothing changed) where a number is
 * negative or not finite. */
int puma560_identifier_rest(void *state, const puma560_real *noise);

/* How far the samples of one to two memories determine each parameter: puma560_PARAMETERS values,
 * from 0, where X and std are older, to 1. It is what these samples took from the variance of X,
 * over that variance, at most 1. Takes as long as reading std. Returns what puma560_identifier_read
 * returns. */
int puma560_identifier_excited(const void *state, puma560_real *out);

/* The least squares inside, to look at or to merge into another. */
const puma560_least_squares *puma560_identifier_state(const void *state);

#ifdef __cplusplus
}
#endif

#endif
