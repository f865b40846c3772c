/* A load that the arm grips, on line: its ten inertial parameters, with X of the arm known.
 *
 * load: XX XY XZ YY YZ ZZ MX MY MZ M (kg m2, kg m, kg), about the origin of the frame of the link
 * of [payload] in robot.toml, or of the last moving link. NAME_add_load adds it to X.
 *
 * Over a window (t1, t2) the impulse that the arm with X does not explain is that of the load:
 *
 *     integral (tau - F X_friction + rate) dt - [p(t2) - p(t1)]
 *         = {P(t2) - P(t1) - integral DL dt} load
 *
 * with p and rate of NAME_generalized_momentum, F of NAME_friction_torque, and P and DL of
 * NAME_load_momentum. No acceleration is needed. A window has two halves of about 0.05 s, and the
 * next one begins in its middle; an equation is the mean over the windows that begin in the first
 * half and end at the same place of the second. Integrals are those of parabolas.
 *
 * The equations of the latest `memory` seconds count, and no older ones. The weight of a joint's
 * equations is 1 over the variance of their errors, from the median of these. Errors of X, torque
 * sensors and friction are in it as far as they change from window to window; the std contain
 * nothing of an error of X that stays, which counts as part of the load.
 *
 * Rest, wild samples: as in NAME_identifier.h. Equations of a joint that rested are left out. While
 * all joints rest nothing is learned.
 *
 * Changes. An equation that errs by more than ten standard deviations is left out. After three such
 * windows in a row of a joint, what was learned before is forgotten: the load is another one.
 *
 * One thread at a time per state; states are independent. The work of a step is bounded. It does
 * not compile with -ffast-math.
 *
 *     static NAME_payload memory;
 *     NAME_payload_init(&memory, sizeof memory, 3, 0.3f, 1);
 *     for (;;) {
 *         ... measure q, qd, tau ...
 *         NAME_payload_step(&memory, q, qd, tau, dt, X{{ g }});
 *         if (NAME_payload_read(&memory, load, std) == NAME_OK) {
 *             NAME_add_load(X, load, loaded);
 *         }
 *         ... inverse dynamics with `loaded`; X stays that of the arm alone ...
 *     }
 */
#ifndef NAME_PAYLOAD_H
#define NAME_PAYLOAD_H

#include <stddef.h>
#include <stdint.h>

#include "NAME.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    NAME_PAYLOAD_PARAMETERS = 10,
    NAME_PAYLOAD_TRIANGLE = NAME_PAYLOAD_PARAMETERS * (NAME_PAYLOAD_PARAMETERS + 1) / 2,
    NAME_PAYLOAD_COLUMNS = NAME_JOINTS * (NAME_PAYLOAD_PARAMETERS + 1),
    /* Samples on each side that a sample is compared with, and all of these. */
    NAME_PAYLOAD_SIDE = 3,
    NAME_PAYLOAD_AROUND = 2 * NAME_PAYLOAD_SIDE + 1,
    /* Parts of the memory; the oldest is forgotten as a whole. */
    NAME_PAYLOAD_BANKS = 4
};

/* Length of the intervals in which joints rest or move, s; they have three samples at least. */
#define NAME_REST_TIME 0.01

/* What is known of a joint. */
typedef struct NAME_payload_joint {
    NAME_real stated;    /* standard deviation of the noise of qd; 0: it is estimated */
    NAME_real noise;     /* the estimate; 0: there is none yet */
    NAME_real past[3];   /* speeds of which the noise is estimated, the newest last */
    NAME_real latest[2]; /* speeds of the latest two samples */
    NAME_real sum;       /* of the sizes of speeds in the interval */
    NAME_real held;      /* position at rest */
    int still;           /* nonzero: at rest */
    NAME_real impulse;   /* of the size of the torque, in this half of a window */
    NAME_real error;     /* standard deviation of its equations; 0: not yet known */
    NAME_real last;      /* error of the last one, in these */
    int equations;       /* that it was estimated from, up to some */
    int far;             /* windows in a row that contradict the load */
    int rested[2];       /* nonzero: in this half of a window, in the half before */
} NAME_payload_joint;

/* What equations have taught: the triangle of their QR decomposition, row after row, and the rest
 * of their right-hand sides. */
typedef struct NAME_payload_equations {
    NAME_real R[NAME_PAYLOAD_TRIANGLE];
    NAME_real z[NAME_PAYLOAD_PARAMETERS];
    NAME_real rss;
    NAME_real count;
} NAME_payload_equations;

/* The memory. Initialise with NAME_payload_init; never write. */
typedef struct NAME_payload {
    NAME_payload_equations bank[NAME_PAYLOAD_BANKS]; /* cyclic */
    NAME_payload_equations all; /* of all banks, and what was assumed at first */
    NAME_real assumed[NAME_PAYLOAD_PARAMETERS];      /* standard deviations */
    NAME_real torques[NAME_PAYLOAD_TRIANGLE]; /* what a load does, over many positions and speeds */
    NAME_real memory;   /* s */
    NAME_real age;      /* of the newest bank, s */
    NAME_real products; /* mean of the products of a joint's errors in neighbouring windows */
    NAME_real squares;  /* mean of the squares of errors */
    int newest;
    int changing;       /* nonzero: the load has changed and is not yet known */
    /* q, qd, tau of the samples around the next one to be taken, cyclic; the steps to them. */
    NAME_real around[NAME_PAYLOAD_AROUND][3 * NAME_JOINTS];
    NAME_real step_to[NAME_PAYLOAD_AROUND];
    NAME_real spread[3 * NAME_JOINTS];
    NAME_real skipped;  /* time of samples that were refused, s */
    int arrived;        /* how many there are */
    int arriving;       /* where the next one goes */
    int wild;           /* nonzero: a number was wild */
    NAME_payload_joint joint[NAME_JOINTS];
    NAME_real interval; /* time in it, s */
    int within;         /* samples in it */
    NAME_real look;     /* time in it of the speed that the noise is estimated of */
    int looked;         /* nonzero: it has passed */
    NAME_real since;    /* time since the last such speed */
    NAME_real spans[3]; /* times between the latest ones, the newest last */
    int looks;          /* since the first sample, up to 3 */
    uint32_t draw;      /* a random number */
    int seen;           /* nonzero: there was a sample */
    int resting;        /* nonzero: all joints rest */
    /* Of the latest three samples, the newest last: what is integrated, and the steps to them. */
    NAME_real rate[3][NAME_PAYLOAD_COLUMNS];
    NAME_real steps[2];
    int samples;        /* how many there are, up to 3 */
    NAME_real integral[NAME_PAYLOAD_COLUMNS]; /* from the beginning of this half */
    NAME_real sum[NAME_PAYLOAD_COLUMNS];      /* of value + integral, over its samples */
    NAME_real before[NAME_PAYLOAD_COLUMNS];   /* mean over the half before */
    NAME_real elapsed;  /* time in this half, s */
    NAME_real count;    /* samples in it */
    int halves;         /* nonzero: there is a half before */
    int fresh;          /* nonzero: a window has ended since all joints rested */
{% if gravity_input %}
    NAME_real g[3];     /* gravity at the latest sample */
{% endif %}
} NAME_payload;

/* Bytes of a state: sizeof(NAME_payload). */
size_t NAME_payload_size(void);

/* Begin with no data.
 *
 * mass, reach: of the loads that may be expected, in kg, and how far the mass lies from the origin
 * of the link's frame, in m. Before there is data, the load is 0 with the standard deviations mass,
 * mass reach and mass reach^2; data soon outweigh them, and a load of three times the mass is
 * found, too. memory: in s, such as 1; longer where the arm moves slowly.
 * Returns 0; nonzero (and the memory untouched) when a number is not positive, or the memory too
 * small or badly aligned.
 */
int NAME_payload_init(void *state, size_t bytes, NAME_real mass, NAME_real reach,
                      NAME_real memory);

/* Take the next sample: q, qd, tau of NAME_JOINTS values each, in rad or m, per s, N m or N; dt > 0
 * in s, the time since the last call (ignored for the first); X: of the arm without the load.
 * Returns 0; NAME_NOT_FINITE, and the sample is left out, when a number is not finite or larger
 * than 1e9, or dt not positive.
{% if gravity_input %}
 * g: gravity in frame 0, m/s2. Where it changes, new windows begin: round what a sensor says of it.
{% endif %}
 */
int NAME_payload_step(void *state, const NAME_real *q, const NAME_real *qd, const NAME_real *tau,
                      NAME_real dt, const NAME_real *X{{ G }});

/* The load and its standard deviations, 10 values each. They are always written. Returns NAME_OK, or
 * why they are not to be used: keep the load that was read before.
 *
 * NAME_NOT_EXCITED: all joints rest, or have moved for less than a window, or the memory says too
 * little of the load: over all positions, three standard deviations of its torque are more than a
 * tenth of that of the load that init expects. A parameter that the motion does not excite keeps a
 * large std; if its torque is small, that is no reason.
 * NAME_CHANGING: the latest equations contradict each other or the load, which has changed; or the
 * arm touches something.
 */
int NAME_payload_read(const void *state, NAME_real *load, NAME_real *std);

/* The noise of qd: standard deviations, NAME_JOINTS values in rad/s or m/s. 0, or NULL for all
 * joints: it is estimated, as at first. Returns 0; nonzero (and nothing changed) where a number is
 * negative or not finite. */
int NAME_payload_rest(void *state, const NAME_real *noise);

#ifdef __cplusplus
}
#endif

#endif
