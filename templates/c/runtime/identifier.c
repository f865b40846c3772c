#include "NAME_identifier.h"
{% include "nan.c" %}

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#define FRICTION (NAME_PARAMETERS - NAME_INERTIAL)

/* An interval is integrated by the polynomial through its two ends and so many samples on each
 * side, as far as there are any. */
#define REACH ((NAME_IDENTIFIER_NODES - 2) / 2)
#define NODES NAME_IDENTIFIER_NODES

/* Loops over so many numbers at a time become vector instructions at -O2, too. */
#define LANES 4

/* By so much the rule may enlarge errors of the samples: the sum of the sizes of its weights over
 * the step. Six points at even steps have 1.26. Beside an interval much longer than its neighbours
 * the polynomial extrapolates far from its points; fewer points are taken then. */
#define LARGEST_GAIN 2

/* The largest size of q, qd and tau that is no fault of the measurement. */
#define LARGEST_SAMPLE 1e9

/* An outlier differs from its prediction by so many standard deviations, which hold what the model
 * misses, and by this share of the largest right-hand side: integrals over a reversal, where
 * friction jumps, err by less. */
#define GATE 10
#define LEAST_WRONG 0.001
/* The share of the mean leverage, which balances forgetting, that an equation must have. */
#define LEAST_LEVERAGE 0.01

/* Equations of the first challenger, at least, and in proportion to the parameters. It competes
 * from half of the latter on. A memory has as many in proportion. */
#define LEAST_SPAN 256
#define SPAN_SHARE 4
#define LONGEST_SPAN 1000000000u
/* An equation contradicts X from FAR standard deviations on. Whatever the distribution of errors,
 * at most one in FAR^2 does so by chance (Chebyshev). Where more than one in FAR_SHARE + 1 does,
 * for as many as MANY windows have, the robot is another one. A ratio counts up to LARGEST. */
#define FAR 3
#define FAR_SHARE 4u
#define MANY 8u
#define LARGEST 1000
/* Each equation examines a challenger by so many rows of R. */
#define EXAMINED 2
/* A challenger that began from a doubt has the time of so many first ones. */
#define DOUBTED 4u
/* A challenger leads by so many times the root of the sum of the squares of its scores. */
#define LEAD 8

{% set part = "identifier" %}
{% set PART = "IDENTIFIER" %}
{% include "runtime/sample_limits.c" %}

/* The arrays behind the head, of `width` values each: [value or rate] of the inertial columns of
 * all equations, then of their friction columns, then of their right-hand sides. */
enum {
    AT_VALUE = 0, /* of the sample that is looked at */
    AT_RATE,
    AT_CARRY,     /* what rounding put into the two newest windows too much (Kahan) */
    AT_TOTAL_CARRY = AT_CARRY + 1, /* (start, where there is one window at a time) */
    AT_WINDOW = NAME_IDENTIFIER_ARRAYS, /* change of value + integral of rate, of each window */
    AT_TOTAL = AT_WINDOW + NAME_IDENTIFIER_BESIDE + 1 /* of all windows so far (start) */
};

/* The offset of state is the alignment it needs. */
struct NAME_identifier_alignment {
    char byte;
    NAME_identifier state;
};

/* Whether these can be numbers of a robot; NaN cannot. */
static int all_plausible(const NAME_real *x)
{
    int plausible = 1;
    for (int j = 0; j < NAME_JOINTS; j++) {
        plausible = plausible && x[j] <= (NAME_real)LARGEST_SAMPLE &&
                    x[j] >= (NAME_real)-LARGEST_SAMPLE;
    }
    return plausible;
}

static int all_finite(const NAME_real *x, size_t length)
{
    int finite = 1;
    for (size_t i = 0; i < length; i++) {
        finite = finite && isfinite(x[i]);
    }
    return finite;
}

static NAME_real *array(NAME_identifier *s, size_t index)
{
    return (NAME_real *)(void *)(s + 1) + index * s->width;
}

/* The energy model: its inertial columns are differences alone, their rates stay 0. */
static void energy(const NAME_real *q, const NAME_real *qd, const NAME_real *tau{{ G -}}
                   , NAME_real *value,
                   NAME_real *rate)
{
    NAME_real power = 0;
    for (int j = 0; j < NAME_JOINTS; j++) {
        power += qd[j] * tau[j];
    }
    NAME_energy_regressor(q, qd{{ g }}, value);
#if NAME_PARAMETERS > NAME_INERTIAL
    NAME_friction_power(q, qd, rate + NAME_INERTIAL);
#endif
    rate[NAME_PARAMETERS] = power;
}

/* Weights of `count` nodes x for the integral over (0, 1), exact for the polynomial through the
 * nodes: Lagrange's polynomials at the three points of Gauss and Legendre, which integrate the
 * fifth degree. Returns the sum of the sizes of the weights. */
static NAME_real weigh(const NAME_real *x, int count, NAME_real *weight)
{
    static const NAME_real at[3] = {(NAME_real)0.11270166537925831, (NAME_real)0.5,
                                    (NAME_real)0.8872983346207417};
    static const NAME_real share[3] = {(NAME_real)(5.0 / 18.0), (NAME_real)(8.0 / 18.0),
                                       (NAME_real)(5.0 / 18.0)};
    NAME_real gain = 0;
    for (int i = 0; i < count; i++) {
        NAME_real below = 1;
        NAME_real above[3] = {share[0], share[1], share[2]};
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

/* Give the samples around the interval that begins at node `left` of the latest `samples` ones
 * their weights in its integral. */
static void integrate(NAME_identifier *s, int left)
{
    const NAME_real *steps = s->steps + (NODES - s->samples); /* steps[j]: from node j to j + 1 */
    const NAME_real h = steps[left];
    NAME_real x[NODES];
    NAME_real weight[NODES] = {0};
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
        const int node = first + j;
        s->weight[(s->next + NODES - s->samples + node) % NODES][left + REACH + 1 - node] =
            weight[j] * h;
    }
}

/* sum += factor x, where carry holds what rounding has added too much (Kahan): over a long window
 * of many small steps a plain float sum would lose them digit by digit. */
static void accumulate(NAME_real *sum, NAME_real *carry, const NAME_real *x, NAME_real factor,
                       size_t size)
{
    size_t i = 0;
    for (; i + LANES <= size; i += LANES) {
        NAME_real old[LANES];
        NAME_real part[LANES];
        NAME_real total[LANES];
        for (int l = 0; l < LANES; l++) {
            old[l] = sum[i + (size_t)l];
            part[l] = factor * x[i + (size_t)l] - carry[i + (size_t)l];
        }
        for (int l = 0; l < LANES; l++) {
            total[l] = old[l] + part[l];
            part[l] = (total[l] - old[l]) - part[l];
        }
        for (int l = 0; l < LANES; l++) {
            sum[i + (size_t)l] = total[l];
            carry[i + (size_t)l] = part[l];
        }
    }
    for (; i < size; i++) {
        const NAME_real part = factor * x[i] - carry[i];
        const NAME_real total = sum[i] + part;
        carry[i] = (total - sum[i]) - part;
        sum[i] = total;
    }
}

/* The same without a carry. */
static void add_plain(NAME_real *sum, const NAME_real *x, NAME_real factor, size_t size)
{
    size_t i = 0;
    for (; i + LANES <= size; i += LANES) {
        NAME_real total[LANES];
        for (int l = 0; l < LANES; l++) {
            total[l] = sum[i + (size_t)l] + factor * x[i + (size_t)l];
        }
        for (int l = 0; l < LANES; l++) {
            sum[i + (size_t)l] = total[l];
        }
    }
    for (; i < size; i++) {
        sum[i] += factor * x[i];
    }
}

static int place_before(const NAME_identifier *s, int place)
{
    return place == 0 ? s->places - 1 : place - 1;
}

static int place_after(const NAME_identifier *s, int place)
{
    return place + 1 == s->places ? 0 : place + 1;
}

/* A window older than the two newest gets what the samples around its end bring, five at most: its
 * carry is gone, at the cost of one rounding. */
static void add_to_window(NAME_identifier *s, int place, const NAME_real *x, NAME_real factor)
{
    NAME_real *sum = array(s, (size_t)(AT_WINDOW + place));
    const int older = AT_CARRY + 1 - s->carry;
    if (place == s->newest) {
        accumulate(sum, array(s, (size_t)(AT_CARRY + s->carry)), x, factor, s->width);
    } else if (s->mode == NAME_WINDOW_SLIDING && place == place_before(s, s->newest)) {
        accumulate(sum, array(s, (size_t)older), x, factor, s->width);
    } else {
        add_plain(sum, x, factor, s->width);
    }
}

static void begin_window(NAME_identifier *s, int place)
{
    const size_t bytes = s->width * sizeof(NAME_real);
    s->newest = place;
    memset(s->rested[place], 0, sizeof s->rested[place]);
    s->carry = s->mode == NAME_WINDOW_SLIDING ? 1 - s->carry : 0;
    memset(array(s, (size_t)(AT_WINDOW + place)), 0, bytes);
    memset(array(s, (size_t)(AT_CARRY + s->carry)), 0, bytes);
}

/* Forget the samples and the open windows. */
static void rebase(NAME_identifier *s)
{
    const int before = REACH + 1; /* the first sample */
    s->samples = 0;
    s->begun = 0;
    s->place = 0;
    s->left = s->length + (size_t)before;
    s->whole = 0;
    s->pending = 0;
    begin_window(s, s->places - 1); /* what falls to the window before the first one */
    begin_window(s, 0);
    if (s->mode == NAME_WINDOW_START) {
        memset(array(s, AT_TOTAL), 0, s->width * sizeof(NAME_real));
        memset(array(s, AT_TOTAL_CARRY), 0, s->width * sizeof(NAME_real));
    }
}

/* What an estimate says of an equation. */
typedef struct verdict {
    NAME_real u[NAME_PARAMETERS]; /* as of NAME_least_squares_foresee */
    NAME_real leverage;           /* 0 while X is not determined */
    NAME_real wrong;              /* size of the innovation, or negative */
    int status;                   /* what is wrong with the equation, if anything */
} verdict;

/* Variance of an equation; NaN, infinite or negative without a degree of freedom. */
static NAME_real noise(const NAME_identifier_estimate *x)
{
    return x->least_squares.rss / (x->least_squares.count - (NAME_real)NAME_PARAMETERS);
}

/* Note by how many standard deviations an equation errs, as a share of the latest `recent` ones. */
static void note(NAME_identifier_estimate *x, const verdict *v, NAME_real ratio, size_t recent)
{
    const NAME_real square = ratio < LARGEST ? ratio * ratio : (NAME_real)LARGEST * LARGEST;
    x->missed += (square - x->missed) / (NAME_real)recent;
    x->allowed += (v->leverage / (1 + v->leverage) - x->allowed) / (NAME_real)recent;
    if (ratio > FAR && 2 * x->least_squares.count > SPAN_SHARE * NAME_PARAMETERS) {
        x->contradicted += FAR_SHARE;
    } else if (x->contradicted > 0) {
        x->contradicted--;
    }
}

/* The innovation test and the excitation test. */
static void judge(NAME_identifier_estimate *x, const NAME_real *row, NAME_real y, size_t recent,
                  verdict *v)
{
    const NAME_least_squares *past = &x->least_squares;
    const NAME_real variance = noise(x);
    const NAME_real least =
        (NAME_real)LEAST_LEVERAGE * (NAME_real)NAME_PARAMETERS * (1 - past->forgetting);
    const NAME_real size = y < 0 ? -y : y;
    NAME_real innovation = 0;
    v->leverage = 0;
    v->wrong = -1;
    v->status = NAME_OK;
    if (NAME_least_squares_foresee(past, row, y, v->u, &innovation, &v->leverage) == 0) {
        NAME_real ratio = 0; /* to the standard deviation */
        v->wrong = innovation < 0 ? -innovation : innovation;
        if (variance > 0 && v->wrong > (NAME_real)LEAST_WRONG * x->largest) {
            ratio = v->wrong / {{ sqrt }}(variance * (1 + v->leverage));
        }
        if (v->leverage < least) {
            v->status = NAME_NOT_EXCITED;
        } else if (ratio > GATE) {
            v->status = NAME_OUTLIER;
        }
        note(x, v, ratio, recent);
    }
    if (v->status == NAME_OK) {
        x->largest = size > x->largest ? size : x->largest;
    }
}

/* A sample more: after a memory of them, what it gained becomes that of the last one. */
static void age(NAME_identifier *s)
{
    s->aged += 1 - s->forgetting;
    if (s->aged >= 1) {
        memcpy(s->gained_before, s->gained, sizeof s->gained);
        memset(s->gained, 0, sizeof s->gained);
        s->aged = 0;
    }
}

/* Share what the latest equation leaves among the joints that moved in its window: only these
 * forget what they had. The variance of equations is the mean of those of all joints, so that a
 * joint which moves alone, with less noise than the others, does not change the std of what they
 * have taught. */
static void share_residual(NAME_identifier *s)
{
    NAME_least_squares *past = &s->estimate[s->read].least_squares;
    const unsigned char *rested = s->rested[s->last];
    NAME_real variance = 0;
    NAME_real count = 0;
    int moved = 0;
    int known = 0;
    for (int j = 0; j < NAME_JOINTS; j++) {
        moved += rested[j] == 0;
    }
    const int sharing = moved > 0 ? moved : NAME_JOINTS;
    const NAME_real part = 1 / (NAME_real)sharing;
    for (int j = 0; j < NAME_JOINTS; j++) {
        NAME_identifier_joint *x = s->joint + j;
        if (moved == 0 || rested[j] == 0) {
            x->rss = past->forgetting * x->rss + part * past->rss;
            x->count = past->forgetting * x->count + part;
        }
        if (x->count > 0) {
            variance += x->rss / x->count;
            known++;
        }
        count += x->count;
    }
    past->rss = variance / (NAME_real)known * count;
    past->count = count;
}

/* Learn an equation: it takes g_i^2 / (1 + leverage) from each variance, g = (R'R)^-1 row. */
static void learn(NAME_identifier *s, const NAME_real *row, NAME_real y, NAME_real *u,
                  NAME_real leverage)
{
    NAME_least_squares *past = &s->estimate[s->read].least_squares;
    if (leverage > 0) {
        NAME_least_squares_back(past, u);
        for (int i = 0; i < NAME_PARAMETERS; i++) {
            s->gained[i] += u[i] * u[i] / (1 + leverage);
        }
    }
    if (past->forgetting < 1) {
        past->rss = 0;
{% if dtype == "float" %}
        past->rss_carry = 0;
{% endif %}
        (void)NAME_least_squares_update(past, row, y);
        share_residual(s);
    } else {
        (void)NAME_least_squares_update(past, row, y);
    }
}

/* Begin a challenger that knows what it does. */
static void begin(NAME_identifier *s, size_t span)
{
    s->age = 0;
    s->span = span;
    s->lead = 0;
    s->squares = 0;
    s->examined = 0;
}

/* Begin a challenger with no data. */
static void challenge(NAME_identifier *s, size_t span)
{
    NAME_identifier_estimate *young = s->estimate + (1 - s->read);
    memset(young, 0, sizeof *young);
    (void)NAME_least_squares_init(&young->least_squares, 1);
    begin(s, span);
}

static size_t first_span(void)
{
    return SPAN_SHARE * NAME_PARAMETERS > LEAST_SPAN ? SPAN_SHARE * NAME_PARAMETERS : LEAST_SPAN;
}

/* Begin a challenger from an estimate that recent equations contradict: with its X, known so much
 * worse that these agree. What no equation excites stays as it is. */
static void doubt(NAME_identifier *s, const NAME_identifier_estimate *from)
{
    NAME_identifier_estimate *young = s->estimate + (1 - s->read);
    NAME_least_squares *x = &young->least_squares;
    const NAME_real part = from->allowed / from->missed;
    const NAME_real least = (NAME_real)1 / ((NAME_real)LARGEST * LARGEST);
    const NAME_real weight = {{ sqrt }}(part > 1 ? 1 : part > least ? part : least);
    if (from != young) {
        *young = *from;
    }
    young->contradicted = 0;
    young->missed = 0;
    young->allowed = 0;
    for (int i = 0; i < NAME_PARAMETERS * (NAME_PARAMETERS + 1) / 2; i++) {
        x->R[i] *= weight;
{% if dtype == "float" %}
        x->R_carry[i] *= weight;
{% endif %}
        x->gathered[i] = 0;
    }
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        x->z[i] *= weight;
{% if dtype == "float" %}
        x->z_carry[i] *= weight;
{% endif %}
    }
    x->count = 2 * NAME_PARAMETERS;
    x->rss = noise(s->estimate + s->read) * NAME_PARAMETERS;
{% if dtype == "float" %}
    x->count_carry = 0;
    x->rss_carry = 0;
{% endif %}
    x->forgetting = 1;
    x->rows = 0;
    begin(s, DOUBTED * first_span());
}

/* Read the challenger from now on: all that it knows is recent. */
static void replace(NAME_identifier *s)
{
    const NAME_least_squares *before = &s->estimate[s->read].least_squares;
    NAME_least_squares *after = &s->estimate[1 - s->read].least_squares;
    after->forgetting = before->forgetting;
    after->kept = before->kept;
    after->cycle = before->cycle;
    for (int j = 0; j < NAME_JOINTS; j++) {
        s->joint[j].rss = after->rss / NAME_JOINTS;
        s->joint[j].count = after->count / NAME_JOINTS;
    }
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        s->gained[i] = (NAME_real)FLT_MAX / 4;
    }
    s->read = 1 - s->read;
    s->estimate[s->read].contradicted = 0;
    s->changing = 0;
    challenge(s, first_span());
}

/* Equations that contradict X, as they count, from which on the robot is another one. */
static size_t many(const NAME_identifier *s)
{
    return (size_t)FAR_SHARE * MANY * (size_t)s->equations;
}

/* Whether the challenger predicts better, and not by chance: see compete. */
static int leads(const NAME_identifier *s)
{
    return s->lead > 0 && s->lead * s->lead > LEAD * LEAD * s->squares;
}

/* Look for a change of the robot in the equations that contradict the estimates. */
static void find_change(NAME_identifier *s)
{
    NAME_identifier_estimate *settled = s->estimate + s->read;
    NAME_identifier_estimate *young = s->estimate + (1 - s->read);
    if (s->changing == 0 && settled->contradicted >= many(s)) {
        s->changing = 1;
        doubt(s, settled);
    } else if (s->changing != 0 && settled->contradicted == 0 && !leads(s)) {
        s->changing = 0;
        challenge(s, first_span());
    } else if (s->changing != 0 && young->contradicted >= many(s)) {
        doubt(s, young);
    }
    if (settled->contradicted > many(s)) {
        settled->contradicted = many(s);
    }
}

/* No X explains the equations better than the settled one: they are so much worse than it took them
 * to be. */
static void go_on(NAME_identifier *s)
{
    NAME_identifier_estimate *settled = s->estimate + s->read;
    const NAME_real worse = settled->missed > 1 ? settled->missed : 1;
    settled->least_squares.rss *= worse;
    for (int j = 0; j < NAME_JOINTS; j++) {
        s->joint[j].rss *= worse;
    }
    settled->contradicted = 0;
    s->changing = 0;
}

/* Whether FAR standard deviations of what the challenger predicts are less than what the settled X
 * misses. That is asked of the equations that taught the settled X, too, for which the rows of its
 * R stand: a challenger that fits where the robot moves now, and nowhere else, waits. Leverage, the
 * mean of those of these rows, is how many times as large its variance is in the metric of the
 * settled X, noise apart:
 *
 *     FAR^2 allowed leverage noise(challenger) / noise(settled) <= missed. */
static int examine(NAME_identifier *s)
{
    const NAME_identifier_estimate *settled = s->estimate + s->read;
    const NAME_identifier_estimate *young = s->estimate + (1 - s->read);
    const NAME_real *R = settled->least_squares.R;
    NAME_real u[NAME_PARAMETERS];
    NAME_real innovation = 0;
    NAME_real leverage = 0;
    s->leverage = s->examined > 0 ? s->leverage : 0;
    for (int i = 0; i < EXAMINED && s->examined < NAME_PARAMETERS; i++) {
        const int at = s->examined;
        NAME_real row[NAME_PARAMETERS] = {0};
        memcpy(row + at, R + at * NAME_PARAMETERS - at * (at - 1) / 2,
            (size_t)(NAME_PARAMETERS - at) * sizeof *R);
        (void)NAME_least_squares_foresee(&young->least_squares, row, 0, u, &innovation, &leverage);
        s->leverage += leverage / NAME_PARAMETERS;
        s->examined++;
    }
    if (s->examined < NAME_PARAMETERS) {
        return 0;
    }
    s->examined = 0;
    return !(noise(settled) > 0) || FAR * FAR * settled->allowed * s->leverage * noise(young) <=
                                        settled->missed * noise(settled);
}

/* Compare what the two estimates predict of an equation that neither has seen. The score lies
 * between -1 and 1, and is near 0 where both are equally wrong, as for an outlier. If the older one
 * is as good, a score is as likely negative as positive, and
 *
 *     P(sum of scores >= c sqrt(sum of their squares)) <= exp(-c^2 / 2),
 *
 * whatever the distribution of the noise (Hoeffding). Neighbouring windows are not independent: c
 * is chosen with room for that. */
static void compete(NAME_identifier *s, NAME_real wrong_old, NAME_real wrong_young)
{
    const NAME_real sum = wrong_old + wrong_young;
    const size_t half = s->changing != 0 ? 0 : (size_t)(SPAN_SHARE / 2) * NAME_PARAMETERS;
    const NAME_real least = (NAME_real)LEAST_WRONG * s->estimate[1 - s->read].largest;
    const NAME_real forgetting = s->estimate[s->read].least_squares.forgetting;
    s->age++;
    if (s->age > half && wrong_old >= 0 && wrong_young >= 0 && sum > least) {
        const NAME_real score = (wrong_old - wrong_young) / sum;
        s->lead += score;
        s->squares += score * score;
    }
    const int due = s->age >= s->span;
    const int better = leads(s);
    const int alone = wrong_old < 0 && wrong_young >= 0; /* the old one knows no X */
    if ((due && alone) || (better && (due || s->changing != 0) && examine(s))) {
        replace(s);
    } else if (due && !better) {
        const int longer = (1 - forgetting) * (NAME_real)s->span < 1 && s->span < LONGEST_SPAN;
        if (s->changing != 0) {
            go_on(s);
        }
        challenge(s, longer ? 2u * s->span : s->span);
    }
}

/* Let both estimates learn an equation that does not contradict them. Returns what is wrong with it
 * for the one that is read. */
static int learn_both(NAME_identifier *s, const NAME_real *row, NAME_real y)
{
    NAME_identifier_estimate *young = s->estimate + (1 - s->read);
    verdict old;
    verdict other;
    if (!all_finite(row, NAME_PARAMETERS) || !isfinite(y)) {
        return NAME_OUTLIER;
    }
    const size_t recent = (size_t)MANY * (size_t)s->equations;
    judge(s->estimate + s->read, row, y, recent + (s->changing != 0 ? s->age : 0), &old);
    if (old.status == NAME_OK && s->changing == 0) {
        learn(s, row, y, old.u, old.leverage);
    }
    if (s->mode != NAME_WINDOW_START) { /* its windows all hold the same samples */
        judge(young, row, y, recent, &other);
        if (other.status == NAME_OK) {
            (void)NAME_least_squares_update(&young->least_squares, row, y);
        }
        compete(s, old.wrong, other.wrong);
        find_change(s);
    }
    return old.status;
}

/* Take in the next equation of the window that has closed. Returns what is wrong with it. */
static int take_row(NAME_identifier *s)
{
    const size_t equations = (size_t)s->equations;
    const int taken = s->equations - s->pending;
    const size_t e = (size_t)taken;
    const NAME_real *sum =
        array(s, (size_t)(s->mode == NAME_WINDOW_START ? AT_TOTAL : AT_WINDOW + s->last));
    NAME_real row[NAME_PARAMETERS + 1];
    for (size_t i = 0; i <= NAME_PARAMETERS; i++) {
        row[i] = sum[i < NAME_INERTIAL     ? e * NAME_INERTIAL + i
                     : i < NAME_PARAMETERS ? equations * NAME_INERTIAL + e * FRICTION +
                                                 (i - NAME_INERTIAL)
                                           : equations * NAME_PARAMETERS + e];
    }
    const int alone = s->equations == NAME_JOINTS && NAME_JOINTS > 1; /* the equation of a joint */
    s->pending--;
    return alone && s->rested[s->last][e] != 0 ? NAME_NOT_EXCITED
                                               : learn_both(s, row, row[NAME_PARAMETERS]);
}

/* Pass the end of a window: its equations are to be taken. */
static void close_window(NAME_identifier *s)
{
    if (s->mode == NAME_WINDOW_START) {
        accumulate(array(s, AT_TOTAL), array(s, AT_TOTAL_CARRY),
            array(s, (size_t)(AT_WINDOW + s->place)), 1, s->width);
    }
    if (s->mode != NAME_WINDOW_SLIDING) {
        s->last = s->place;
        s->pending = s->equations;
    } else if (s->whole != 0) {
        s->last = place_before(s, s->place);
        s->pending = s->equations;
    }
    s->whole = 1;
}

/* A joint rested in the open windows. */
static void mark(NAME_identifier *s, int joint)
{
    s->rested[s->place][joint] = 1;
    if (s->mode == NAME_WINDOW_SLIDING) {
        s->rested[place_before(s, s->place)][joint] = 1;
    }
}

{% include "runtime/samples.c" %}

/* Look at the oldest sample, whose weights are known in all intervals that it has a part in: from
 * the third before it on.
 *
 * Mode sliding. Windows begin every `length` intervals. The mean of the windows of `length`
 * intervals that begin in one of these stretches gives interval k of it (from 0) the weight
 * (k + 1) / length, interval k of the next the rest to 1, and the values at the beginnings of
 * intervals -1 / length here and 1 / length there. Two windows are open at a time, each of them a
 * sum that starts from 0 and never exceeds what it stands for: the error does not grow with the
 * run, and every step costs the same, whatever the length.
 */
static void absorb(NAME_identifier *s)
{
    const int sliding = s->mode == NAME_WINDOW_SLIDING;
    const NAME_real *x = s->sample[s->next];
    const NAME_real *weight = s->weight[s->next];
    const NAME_real share = 1 / (NAME_real)s->length;
    NAME_real *value = array(s, AT_VALUE);
    NAME_real *rate = array(s, AT_RATE);
    NAME_real rising = 0;
    NAME_real falling = 0;
    size_t left = s->left;
    int place = s->place;
    s->columns(x, x + NAME_JOINTS, x + 2 * NAME_JOINTS{{ ", s->g" if gravity_input }}, value, rate);
    for (int j = 0; j < NAME_JOINTS; j++) {
        if (s->joint[j].still != 0) {
            mark(s, j);
        }
    }
    if (s->begun == 0 && !sliding) {
        add_to_window(s, place, value, -1);
    }
    for (int j = 0; j < NODES; j++) {
        left--;
        const NAME_real rest = sliding ? share * (NAME_real)left : 0;
        rising += (1 - rest) * weight[j];
        falling += rest * weight[j];
        if (sliding && j == REACH + 1) {
            add_to_window(s, place, value, -share);
            add_to_window(s, place_before(s, place), value, share);
        }
        if (left == 0 || j == NODES - 1) {
            add_to_window(s, place, rate, rising);
            if (sliding) {
                add_to_window(s, place_before(s, place), rate, falling);
            }
            rising = 0;
            falling = 0;
        }
        if (left == 0 && j < NODES - 1) {
            const int after = place_after(s, place);
            if (j == NODES - 2 || s->begun == 0) {
                begin_window(s, after);
            }
            if (!sliding && j == REACH) {
                add_to_window(s, place, value, 1);
                add_to_window(s, after, value, -1);
            }
            place = after;
            left = s->length;
        }
    }
    s->begun = 1;
    s->left--;
    if (s->left == 0) {
        close_window(s);
        s->place = place_after(s, s->place);
        s->left = s->length;
    }
}

/* Take the sample in the middle of those around it; the first ones as they came. */
static void take_sample(NAME_identifier *s)
{
    const int place = (s->arriving + NAME_IDENTIFIER_SIDE) % NAME_IDENTIFIER_AROUND;
    const NAME_real *x = s->around[place];
    const NAME_real dt = s->step_to[place];
    for (int k = 0; k < 3 * NAME_JOINTS && s->arrived == NAME_IDENTIFIER_AROUND; k++) {
        tame(s, k);
    }
    age(s);
    find_rest(s, x, x + NAME_JOINTS, dt);
    if (s->resting != 0) {
        s->status = NAME_NOT_EXCITED;
        return;
    }
    NAME_real *sample = s->sample[s->next]; /* the oldest, which nobody needs any more */
    memcpy(sample, x, sizeof s->sample[0]);
    for (int j = 0; j < NAME_JOINTS; j++) {
        if (s->joint[j].still != 0) {
            sample[j] = s->joint[j].held;
            sample[NAME_JOINTS + j] = 0;
        }
    }
    memset(s->weight[s->next], 0, sizeof s->weight[0]);
    memmove(s->steps, s->steps + 1, sizeof s->steps - sizeof s->steps[0]);
    s->steps[NODES - 2] = dt;
    s->next = (s->next + 1) % NODES;
    s->samples += s->samples < NODES;
    if (s->samples >= REACH + 2) {
        integrate(s, s->samples - REACH - 2);
    }
    if (s->samples == NODES) {
        absorb(s);
    }
    if (s->pending > 0) {
        int status = NAME_OK;
        for (int row = 0; row < s->rows && s->pending > 0; row++) {
            status |= take_row(s);
        }
        if (s->mode == NAME_WINDOW_START && (status & NAME_OUTLIER) != 0) {
            rebase(s); /* every later window would hold the outlier, too */
        }
        s->status = status | s->wild;
        s->wild = 0;
    }
}

/* x^exponent, for x in (0, 1]; at least FLT_MIN, of which nothing is left. */
static NAME_real power(NAME_real x, size_t exponent)
{
    NAME_real out = 1;
    NAME_real square = x;
    for (size_t left = exponent; left > 0; left /= 2) {
        out *= left % 2 != 0 ? square : 1;
        square *= square;
    }
    return out > (NAME_real)FLT_MIN ? out : (NAME_real)FLT_MIN;
}

/* x^(1 / degree), for x in (0, 1], by Newton's method from above. */
static NAME_real root(NAME_real x, int degree)
{
    NAME_real y = 1 - (1 - x) / (NAME_real)degree;
    for (int i = 0; i < ROOT_STEPS && degree > 1; i++) {
        NAME_real below = 1;
        for (int k = 1; k < degree; k++) {
            below *= y;
        }
        y -= (y * below - x) / ((NAME_real)degree * below);
    }
    return y;
}

size_t NAME_identifier_size(size_t window)
{
    return NAME_identifier_size_of(1, window);
}

size_t NAME_identifier_size_of(int equations, size_t window)
{
    if (equations < 1 || equations > NAME_JOINTS) {
        return 0;
    }
    return NAME_IDENTIFIER_BYTES_OF(equations, window);
}

int NAME_identifier_init(void *state, size_t bytes, size_t window, int mode, NAME_real forgetting)
{
    return NAME_identifier_init_of(state, bytes, window, mode, forgetting, 1, energy);
}

int NAME_identifier_init_of(void *state, size_t bytes, size_t window, int mode,
                            NAME_real forgetting, int equations, NAME_identifier_columns *columns)
{
    NAME_identifier *s = (NAME_identifier *)state;
    const int sliding = mode == NAME_WINDOW_SLIDING;
    const int windowed = sliding || mode == NAME_WINDOW_CONSECUTIVE;
    const size_t needed = NAME_identifier_size_of(equations, sliding ? window : 0);
    const size_t alignment = offsetof(struct NAME_identifier_alignment, state);
    if (s == NULL || (uintptr_t)state % alignment != 0 || needed == 0 || bytes < needed) {
        return 1;
    }
    if (!(windowed ? window > 0 : mode == NAME_WINDOW_START) ||
        !(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(state, 0, needed);
    s->columns = columns;
    s->equations = equations;
    s->width = (size_t)equations * (NAME_PARAMETERS + 1);
    s->mode = mode;
    s->length = mode == NAME_WINDOW_START ? (size_t)equations
                : sliding                 ? window / 2 + window % 2
                                          : window;
    /* A window that has closed waits for its equations to be taken before its place is used. */
    s->places = sliding ? (int)NAME_IDENTIFIER_PLACES(equations, window)
                        : NAME_IDENTIFIER_BESIDE + 1;
    const size_t rows = ((size_t)equations - 1u) / s->length + 1u;
    s->rows = (int)rows;
    rebase(s);
    challenge(s, first_span());
    /* Per equation: so many come every `length` samples. */
    const NAME_real kept = power(root(forgetting, equations), s->length);
    const NAME_real most = (NAME_real)1 / (SPAN_SHARE * NAME_PARAMETERS);
    const int shortest = 1 - kept > most; /* a memory holds no fewer equations */
    s->forgetting =
        shortest ? 1 - most * (NAME_real)equations / (NAME_real)s->length : forgetting;
    return NAME_least_squares_init(&s->estimate[s->read].least_squares, shortest ? 1 - most : kept);
}

int NAME_identifier_step(void *state, const NAME_real *q, const NAME_real *qd,
                         const NAME_real *tau, NAME_real dt{{ G }})
{
    NAME_identifier *s = (NAME_identifier *)state;
    if (!all_plausible(q) || !all_plausible(qd) || !all_plausible(tau) ||
        (s->arrived > 0 && !(dt > 0 && isfinite(dt)))) {
        return NAME_NOT_FINITE;
    }
{% if gravity_input %}
    if (!all_finite(g, 3)) {
        return NAME_NOT_FINITE;
    }
{% endif %}
{% if gravity_input %}
    int turned = 0;
    for (int i = 0; i < 3; i++) {
        turned = turned || s->g[i] < g[i] || s->g[i] > g[i];
        s->g[i] = g[i];
    }
    if (turned) { /* no window holds two mountings */
        rebase(s);
        s->arrived = 0;
    }
{% endif %}
    NAME_real *sample = s->around[s->arriving];
    memcpy(sample, q, NAME_JOINTS * sizeof *q);
    memcpy(sample + NAME_JOINTS, qd, NAME_JOINTS * sizeof *qd);
    memcpy(sample + 2 * NAME_JOINTS, tau, NAME_JOINTS * sizeof *tau);
    s->step_to[s->arriving] = s->arrived > 0 ? dt : 0;
    s->arriving = (s->arriving + 1) % NAME_IDENTIFIER_AROUND;
    s->arrived += s->arrived < NAME_IDENTIFIER_AROUND;
    if (s->arrived > NAME_IDENTIFIER_SIDE) {
        take_sample(s);
    }
    return NAME_OK;
}

int NAME_identifier_status(const void *state)
{
    const NAME_identifier *s = (const NAME_identifier *)state;
    return s->status | (s->changing != 0 ? NAME_CHANGING : NAME_OK);
}

void NAME_identifier_restart(void *state)
{
    NAME_identifier *s = (NAME_identifier *)state;
    rebase(s);
    s->next = 0;
    s->arrived = 0;
    s->seen = 0;
    s->interval = 0;
    s->within = 0;
    s->since = 0;
    s->looks = 0;
    s->look = 0;
    s->looked = 0;
    s->resting = 0;
    for (int j = 0; j < NAME_JOINTS; j++) {
        s->joint[j].sum = 0;
        s->joint[j].still = 0;
    }
}

int NAME_identifier_rest(void *state, const NAME_real *noise)
{
    NAME_identifier *s = (NAME_identifier *)state;
    for (int j = 0; noise != NULL && j < NAME_JOINTS; j++) {
        if (!(noise[j] >= 0 && noise[j] <= (NAME_real)LARGEST_SAMPLE)) {
            return NAME_NOT_FINITE;
        }
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        s->joint[j].stated = noise != NULL ? noise[j] : 0;
    }
    return NAME_OK;
}

int NAME_identifier_excited(const void *state, NAME_real *out)
{
    const NAME_identifier *s = (const NAME_identifier *)state;
    const int missing = NAME_least_squares_variances(NAME_identifier_state(state), out);
    for (int i = 0; missing == 0 && i < NAME_PARAMETERS; i++) {
        const NAME_real share = (s->gained[i] + s->gained_before[i]) / out[i];
        out[i] = share < 1 ? share : 1;
    }
    return missing;
}

int NAME_identifier_run(void *state, size_t N, const NAME_real *t, const NAME_real *q,
                        const NAME_real *qd, const NAME_real *tau{{ G }})
{
    NAME_identifier_restart(state);
    for (size_t k = 0; k < N; k++) {
        const size_t at = k * NAME_JOINTS;
        const NAME_real dt = k > 0 ? t[k] - t[k - 1] : 0;
        if ((k == 0 && !isfinite(t[0])) ||
            NAME_identifier_step(state, q + at, qd + at, tau + at, dt{{ g }}) != 0) {
            return k < (size_t)INT_MAX ? (int)(k + 1) : INT_MAX;
        }
    }
    return 0;
}

int NAME_identifier_read(const void *state, NAME_real *X, NAME_real *std)
{
    const NAME_identifier *s = (const NAME_identifier *)state;
    const int missing = NAME_least_squares_solve(NAME_identifier_state(state), X, std, NULL);
    return missing == 0 && s->changing != 0 ? NAME_CHANGING : missing;
}

const NAME_least_squares *NAME_identifier_state(const void *state)
{
    const NAME_identifier *s = (const NAME_identifier *)state;
    return &s->estimate[s->read].least_squares;
}
