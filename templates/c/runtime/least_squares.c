#include "NAME_least_squares.h"
{% include "nan.c" %}

#include <float.h>
#include <math.h>
#include <string.h>

/* Loops over so many numbers at a time become vector instructions at -O2, too: each reads into
 * arrays of its own before it writes, so that nothing can be in the way. */
#define LANES 4

/* The share of what balances forgetting that a row of B must bring: less is noise. */
#define LEAST_SHARE 0.01
#define LONGEST 1000000000 /* rows of a cycle */

/* R(j,j) / ||R(:,j)|| is the sine of the angle between column j of W and the span of the columns
 * before it. On a dependent column rounding leaves a value there: measured, 1e-7 in float and 2e-16
 * in double after 10^4 to 10^6 rows, more where the rows themselves are small differences of large
 * numbers. The limits lie well above that; in float a parameter below its limit has few digits
 * left, in double any sensor noise has drowned it.
 */
static NAME_real tolerance(void)
{
    return sizeof(NAME_real) == sizeof(float) ? (NAME_real)1e-4 : (NAME_real)1e-10;
}

static NAME_real magnitude(NAME_real x)
{
    return x < 0 ? -x : x;
}

/* Index in the packed triangle of the diagonal entry of row i (from 0). */
static int diagonal(int i)
{
    return i * NAME_PARAMETERS - i * (i - 1) / 2;
}

{% if dtype == "float" %}
/* entry += change, where carry holds what rounding has added to entry too much (Kahan). */
static void add(NAME_real *entry, NAME_real *carry, NAME_real change)
{
    const NAME_real part = change - *carry;
    const NAME_real sum = *entry + part;
    *carry = (sum - *entry) - part;
    *entry = sum;
}

{% endif %}
/* x'y, of `size` numbers. */
static NAME_real product(const NAME_real *x, const NAME_real *y, int size)
{
    NAME_real sum[LANES] = {0};
    NAME_real rest = 0;
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        for (int l = 0; l < LANES; l++) {
            sum[l] += x[j + l] * y[j + l];
        }
    }
    for (; j < size; j++) {
        rest += x[j] * y[j];
    }
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + rest;
}

/* x -= factor y, of `size` numbers. */
static void subtract(NAME_real *x, const NAME_real *y, NAME_real factor, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        NAME_real part[LANES];
        for (int l = 0; l < LANES; l++) {
            part[l] = x[j + l] - factor * y[j + l];
        }
        for (int l = 0; l < LANES; l++) {
            x[j + l] = part[l];
        }
    }
    for (; j < size; j++) {
        x[j] -= factor * y[j];
    }
}

/* Turn a row of a triangle and another row by an angle: see rotate. */
static void turn(NAME_real *R{{ ", NAME_real *carry" if dtype == "float" }}, NAME_real *row,
                 NAME_real sine, NAME_real half, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        NAME_real old[LANES];
        NAME_real below[LANES];
{% if dtype == "float" %}
        NAME_real part[LANES];
{% endif %}
        NAME_real total[LANES];
        for (int l = 0; l < LANES; l++) {
            old[l] = R[j + l];
            below[l] = row[j + l];
{% if dtype == "float" %}
            part[l] = carry[j + l];
{% endif %}
        }
        for (int l = 0; l < LANES; l++) {
{% if dtype == "float" %}
            part[l] = sine * (below[l] - half * old[l]) - part[l];
            below[l] = below[l] - sine * (old[l] + half * below[l]);
            total[l] = old[l] + part[l];
            part[l] = (total[l] - old[l]) - part[l];
{% else %}
            total[l] = old[l] + sine * (below[l] - half * old[l]);
            below[l] = below[l] - sine * (old[l] + half * below[l]);
{% endif %}
        }
        for (int l = 0; l < LANES; l++) {
            R[j + l] = total[l];
            row[j + l] = below[l];
{% if dtype == "float" %}
            carry[j + l] = part[l];
{% endif %}
        }
    }
    for (; j < size; j++) {
        const NAME_real above = R[j];
        const NAME_real below = row[j];
{% if dtype == "float" %}
        add(R + j, carry + j, sine * (below - half * above));
{% else %}
        R[j] += sine * (below - half * above);
{% endif %}
        row[j] = below - sine * (above + half * below);
    }
}

/* Turn row i of [R z] and another row [row right]. */
static void turn_row(NAME_least_squares *s, int i, NAME_real *row, NAME_real *right,
                     NAME_real sine, NAME_real half)
{
    const int at = diagonal(i);
    turn(s->R + at{{ ", s->R_carry + at" if dtype == "float" }}, row + i, sine, half,
        NAME_PARAMETERS - i);
    turn(s->z + i{{ ", s->z_carry + i" if dtype == "float" }}, right, sine, half, 1);
}

/* Sine and tan(angle / 2) of the rotation that takes `below` into `pivot`, which is not negative.
 * The smaller of the two is divided by the larger, so that no square overflows. */
static void angle(NAME_real pivot, NAME_real below, NAME_real *sine, NAME_real *half)
{
    const NAME_real size = magnitude(below);
    *sine = 0;
    *half = 0;
    if (size > pivot) {
        const NAME_real ratio = pivot / size;
        const NAME_real scale = {{ sqrt }}(1 + ratio * ratio);
        *sine = (below < 0 ? -1 : 1) / scale;
        *half = (below < 0 ? -1 : 1) / (scale + ratio);
    } else if (pivot > 0) {
        const NAME_real ratio = below / pivot;
        const NAME_real scale = {{ sqrt }}(1 + ratio * ratio);
        *sine = ratio / scale;
        *half = ratio / (scale + 1);
    }
}

/* Rotate the equation row'X = y into [R z], from column first on; row is overwritten. Returns what
 * is left of y, which is orthogonal to all columns.
 *
 * A row of R that is still empty (pivot 0) takes the equation over as it is. No branch depends on
 * the data but those of the angle: every row costs the same.
 *
 * A rotation is applied as a change, with half = tan(angle / 2): cosine above + sine below is
 * above + sine (below - half above). A row that comes after many turns R by a small angle only: the
 * change has the row's size, its rounding too.
{% if dtype == "float" %}
 * The compensated sum loses none of it.
{% endif %}
 * So rounding errs by a share of each row, as if the row had been measured that much worse. The
 * diagonal goes the same way as the rest of its row, so that columns in proportion stay in
 * proportion.
 */
static NAME_real rotate(NAME_least_squares *s, NAME_real *row, NAME_real y, int first)
{
    NAME_real rest = y;
    for (int i = first; i < NAME_PARAMETERS; i++) {
        NAME_real sine = 0;
        NAME_real half = 0;
        angle(s->R[diagonal(i)], row[i], &sine, &half);
        turn_row(s, i, row, &rest, sine, half);
    }
    return rest;
}

/* Whether column j depends on those before it. */
static int dependent(const NAME_real *R, int j)
{
    NAME_real largest = 0;
    NAME_real sum = 0;
    for (int i = 0; i <= j; i++) {
        const NAME_real size = magnitude(R[diagonal(i) + j - i]);
        largest = size > largest ? size : largest;
    }
    if (!(largest > 0)) {
        return 1;
    }
    for (int i = 0; i <= j; i++) {
        const NAME_real part = R[diagonal(i) + j - i] / largest;
        sum += part * part;
    }
    return !(R[diagonal(j)] > tolerance() * largest * {{ sqrt }}(sum));
}

/* 0, or the number of the first parameter that is not determined. */
static int undetermined(const NAME_real *R)
{
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        if (dependent(R, j)) {
            return j + 1;
        }
    }
    return 0;
}

int NAME_least_squares_init(NAME_least_squares *s, NAME_real forgetting)
{
    if (!(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(s, 0, sizeof *s);
    s->forgetting = forgetting;
    s->kept = 1;
    if (forgetting < 1) {
        const NAME_real quarter = 1 / (4 * (1 - forgetting));
        const NAME_real most = (NAME_real)LONGEST;
        s->cycle = (long)(quarter < most ? quarter : most);
        s->cycle = (s->cycle > 2 * NAME_PARAMETERS ? s->cycle : 2 * NAME_PARAMETERS) +
                   NAME_PARAMETERS;
        NAME_real weight = forgetting;
        for (long left = s->cycle; left > 0; left /= 2) {
            s->kept *= left % 2 != 0 ? weight : 1;
            weight *= weight;
        }
        s->kept = s->kept > (NAME_real)FLT_MIN ? s->kept : (NAME_real)FLT_MIN;
    }
    return 0;
}

/* Solve R(0..last, 0..last) x = x in place. */
static void back_substitute(const NAME_real *R, NAME_real *x, int last)
{
    for (int i = last; i >= 0; i--) {
        const NAME_real *row = R + diagonal(i);
        x[i] = (x[i] - product(row + 1, x + i + 1, last - i)) / row[0];
    }
}

/* Solve R'u = u in place, where u is 0 before entry k. Returns u'u. */
static NAME_real forward_substitute(const NAME_real *R, NAME_real *u, int k)
{
    NAME_real sum = 0;
    for (int i = k; i < NAME_PARAMETERS; i++) {
        const NAME_real *row = R + diagonal(i);
        u[i] /= row[0];
        subtract(u + i + 1, row + 1, u[i], NAME_PARAMETERS - i - 1);
        sum += u[i] * u[i];
    }
    return sum;
}

/* Forget the share 1 - kept of what is known of b'X, where b is row k of B without its part along
 * the rows behind it. Leaves b of the length 1 in the metric of R'R as it will be, so that the next
 * ones lose their part along it, or 0 where it is noise.
 *
 * With R'u = b and v = sqrt((1 - kept) / u'u) u, the rotations that turn [sqrt(kept) v] into [1 0],
 * the last entry first, turn [0; R] into [v'R; R*] with R*'R* = R'R - R'v v'R. They turn z, that is
 * R X, into R* X. */
static void forget(NAME_least_squares *s, int k)
{
    const int size = NAME_PARAMETERS - k;
    const NAME_real least = (NAME_real)LEAST_SHARE * (1 - s->kept);
    NAME_real *b = s->gathered + diagonal(k);
    NAME_real u[NAME_PARAMETERS] = {0};
    NAME_real work[NAME_PARAMETERS] = {0};
    memcpy(u + k, b, (size_t)size * sizeof u[0]);
    (void)forward_substitute(s->R, u, k);
    back_substitute(s->R, u, NAME_PARAMETERS - 1); /* (R'R)^-1 b */
    for (int j = k + 1; j < NAME_PARAMETERS; j++) {
        const NAME_real *taken = s->gathered + diagonal(j);
        subtract(b + j - k, taken, product(u + j, taken, NAME_PARAMETERS - j), NAME_PARAMETERS - j);
    }
    memset(u, 0, sizeof u);
    memcpy(u + k, b, (size_t)size * sizeof u[0]);
    const NAME_real sum = forward_substitute(s->R, u, k);
    if (!(sum > least)) {
        memset(b, 0, (size_t)size * sizeof u[0]);
        return;
    }
    const NAME_real share = {{ sqrt }}((1 - s->kept) / sum);
    const NAME_real unit = {{ sqrt }}(s->kept / sum);
    NAME_real right = 0;
    NAME_real rest = {{ sqrt }}(s->kept);
    for (int i = NAME_PARAMETERS - 1; i >= 0; i--) {
        const NAME_real v = share * u[i];
        const NAME_real length = {{ sqrt }}(rest * rest + v * v);
        turn_row(s, i, work, &right, -v / length, -v / (length + rest));
        rest = length;
    }
    for (int i = 0; i < size; i++) {
        b[i] *= unit;
    }
}

/* Gather a row, which is overwritten, or forget along a row of what has been gathered. */
static void advance(NAME_least_squares *s, NAME_real *row)
{
    const long left = s->cycle - s->rows;
    if (left > NAME_PARAMETERS) {
        for (int i = 0; i < NAME_PARAMETERS; i++) {
            NAME_real *B = s->gathered + diagonal(i);
            NAME_real sine = 0;
            NAME_real half = 0;
            angle(B[0], row[i], &sine, &half);
            for (int j = 0; j < NAME_PARAMETERS - i; j++) {
                const NAME_real above = B[j];
                const NAME_real below = row[i + j];
                B[j] = above + sine * (below - half * above);
                row[i + j] = below - sine * (above + half * below);
            }
        }
    } else {
        forget(s, (int)left - 1);
    }
    s->rows++;
    if (s->rows == s->cycle) {
        s->rows = 0;
        memset(s->gathered, 0, sizeof s->gathered);
    }
}

int NAME_least_squares_update(NAME_least_squares *s, const NAME_real *row, NAME_real y)
{
    NAME_real work[NAME_PARAMETERS];
    int finite = isfinite(y) ? 1 : 0;
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        finite = finite && isfinite(row[i]);
        work[i] = row[i];
    }
    if (!finite) {
        return 1;
    }
    const NAME_real rest = rotate(s, work, y, 0);
    s->rss *= s->forgetting;
    s->count *= s->forgetting;
{% if dtype == "float" %}
    s->rss_carry *= s->forgetting;
    s->count_carry *= s->forgetting;
    add(&s->rss, &s->rss_carry, rest * rest);
    add(&s->count, &s->count_carry, 1);
{% else %}
    s->rss += rest * rest;
    s->count += 1;
{% endif %}
    if (s->forgetting < 1 && s->determined != 0) {
        memcpy(work, row, sizeof work);
        advance(s, work);
    }
    s->determined = s->determined != 0 || undetermined(s->R) == 0;
    return 0;
}

int NAME_least_squares_foresee(const NAME_least_squares *s, const NAME_real *row, NAME_real y,
                               NAME_real *u, NAME_real *innovation, NAME_real *leverage)
{
    NAME_real predicted = 0;
    memcpy(u, row, NAME_PARAMETERS * sizeof *u);
    if (s->determined == 0) {
        return 1;
    }
    *leverage = forward_substitute(s->R, u, 0);
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        predicted += u[i] * s->z[i];
    }
    *innovation = y - predicted;
    return 0;
}

void NAME_least_squares_merge(NAME_least_squares *s, const NAME_least_squares *other)
{
    NAME_real row[NAME_PARAMETERS];
    NAME_real rss = other->rss;
    const NAME_real count = other->count;
    /* From the last row up: row i changes rows i.. of s only, so that other may be s. */
    for (int i = NAME_PARAMETERS - 1; i >= 0; i--) {
        const NAME_real *R = other->R + diagonal(i);
        for (int j = i; j < NAME_PARAMETERS; j++) {
            row[j] = R[j - i];
        }
        const NAME_real rest = rotate(s, row, other->z[i], i);
        rss += rest * rest;
    }
{% if dtype == "float" %}
    add(&s->rss, &s->rss_carry, rss);
    add(&s->count, &s->count_carry, count);
{% else %}
    s->rss += rss;
    s->count += count;
{% endif %}
    s->determined = s->determined != 0 || undetermined(s->R) == 0;
}

/* Standard deviation of an equation; NAN without a degree of freedom. */
static NAME_real deviation(const NAME_least_squares *s)
{
    const NAME_real freedom = s->count - (NAME_real)NAME_PARAMETERS;
    return freedom > 0 ? {{ sqrt }}(s->rss / freedom) : (NAME_real)NAN;
}

/* Add the squares of column j of sigma R^-1, rows 0 to j. */
static void add_squares(const NAME_real *R, NAME_real sigma, int j, NAME_real *sum)
{
    NAME_real column[NAME_PARAMETERS];
    for (int i = 0; i < j; i++) {
        column[i] = 0;
    }
    column[j] = sigma;
    back_substitute(R, column, j);
    for (int i = 0; i <= j; i++) {
        sum[i] += column[i] * column[i];
    }
}

/* The squares of the rows of sigma R^-1. */
static void sum_squares(const NAME_real *R, NAME_real sigma, NAME_real *sum)
{
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        sum[i] = 0;
    }
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        add_squares(R, sigma, j, sum);
    }
}

int NAME_least_squares_variances(const NAME_least_squares *s, NAME_real *out)
{
    const int missing = undetermined(s->R);
    if (missing == 0) {
        sum_squares(s->R, 1, out);
    }
    return missing;
}

void NAME_least_squares_back(const NAME_least_squares *s, NAME_real *x)
{
    back_substitute(s->R, x, NAME_PARAMETERS - 1);
}

int NAME_least_squares_solve(const NAME_least_squares *s, NAME_real *X, NAME_real *std,
                             NAME_real *rss)
{
    const int missing = undetermined(s->R);
    if (missing != 0) {
        return missing;
    }
    memcpy(X, s->z, sizeof s->z);
    back_substitute(s->R, X, NAME_PARAMETERS - 1);
    if (rss != NULL) {
        *rss = s->rss;
    }
    if (std != NULL) {
        const NAME_real sigma = deviation(s);
        sum_squares(s->R, sigma, std);
        for (int i = 0; i < NAME_PARAMETERS; i++) {
            std[i] = {{ sqrt }}(std[i]);
        }
    }
    return 0;
}

void NAME_least_squares_begin(NAME_least_squares_solution *found, const NAME_least_squares *s)
{
    memcpy(found->R, s->R, sizeof s->R);
    memcpy(found->z, s->z, sizeof s->z);
    memset(found->squares, 0, sizeof found->squares);
    found->sigma = deviation(s);
    found->left = NAME_PARAMETERS + 1;
}

int NAME_least_squares_proceed(NAME_least_squares_solution *found, int pieces)
{
    for (int k = 0; k < pieces && found->left > 0; k++) {
        const int j = NAME_PARAMETERS + 1 - found->left;
        found->left--;
        if (j == NAME_PARAMETERS) {
            back_substitute(found->R, found->z, NAME_PARAMETERS - 1);
            memcpy(found->X, found->z, sizeof found->z);
            for (int i = 0; i < NAME_PARAMETERS; i++) {
                found->std[i] = {{ sqrt }}(found->squares[i]);
            }
            found->missing = 0;
        } else if (dependent(found->R, j)) {
            found->missing = j + 1;
            found->left = 0;
        } else {
            add_squares(found->R, found->sigma, j, found->squares);
        }
    }
    return found->left;
}
