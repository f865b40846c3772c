#include "puma560_least_squares.h"

#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "the status of this file needs NaN: compile it without -ffast-math and -ffinite-math-only"
#endif

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
static puma560_real tolerance(void)
{
    return sizeof(puma560_real) == sizeof(float) ? (puma560_real)1e-4 : (puma560_real)1e-10;
}

static puma560_real magnitude(puma560_real x)
{
    return x < 0 ? -x : x;
}

/* Index in the packed triangle of the diagonal entry of row i (from 0). */
static int diagonal(int i)
{
    return i * puma560_PARAMETERS - i * (i - 1) / 2;
}

/* x'y, of `size` numbers. */
static puma560_real product(const puma560_real *x, const puma560_real *y, int size)
{
    puma560_real sum[LANES] = {0};
    puma560_real rest = 0;
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
static void subtract(puma560_real *x, const puma560_real *y, puma560_real factor, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        puma560_real part[LANES];
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
static void turn(puma560_real *R, puma560_real *row,
                 puma560_real sine, puma560_real half, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        puma560_real old[LANES];
        puma560_real below[LANES];
        puma560_real total[LANES];
        for (int l = 0; l < LANES; l++) {
            old[l] = R[j + l];
            below[l] = row[j + l];
        }
        for (int l = 0; l < LANES; l++) {
            total[l] = old[l] + sine * (below[l] - half * old[l]);
            below[l] = below[l] - sine * (old[l] + half * below[l]);
        }
        for (int l = 0; l < LANES; l++) {
            R[j + l] = total[l];
            row[j + l] = below[l];
        }
    }
    for (; j < size; j++) {
        const puma560_real above = R[j];
        const puma560_real below = row[j];
        R[j] += sine * (below - half * above);
        row[j] = below - sine * (above + half * below);
    }
}

/* Turn row i of [R z] and another row [row right]. */
static void turn_row(puma560_least_squares *s, int i, puma560_real *row, puma560_real *right,
                     puma560_real sine, puma560_real half)
{
    const int at = diagonal(i);
    turn(s->R + at, row + i, sine, half,
        puma560_PARAMETERS - i);
    turn(s->z + i, right, sine, half, 1);
}

/* Sine and tan(angle / 2) of the rotation that takes `below` into `pivot`, which is not negative.
 * The smaller of the two is divided by the larger, so that no square overflows. */
static void angle(puma560_real pivot, puma560_real below, puma560_real *sine, puma560_real *half)
{
    const puma560_real size = magnitude(below);
    *sine = 0;
    *half = 0;
    if (size > pivot) {
        const puma560_real ratio = pivot / size;
        const puma560_real scale = sqrt(1 + ratio * ratio);
        *sine = (below < 0 ? -1 : 1) / scale;
        *half = (below < 0 ? -1 : 1) / (scale + ratio);
    } else if (pivot > 0) {
        const puma560_real ratio = below / pivot;
        const puma560_real scale = sqrt(1 + ratio * ratio);
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
 * So rounding errs by a share of each row, as if the row had been measured that much worse. The
 * diagonal goes the same way as the rest of its row, so that columns in proportion stay in
 * proportion.
 */
static puma560_real rotate(puma560_least_squares *s, puma560_real *row, puma560_real y, int first)
{
    puma560_real rest = y;
    for (int i = first; i < puma560_PARAMETERS; i++) {
        puma560_real sine = 0;
        puma560_real half = 0;
        angle(s->R[diagonal(i)], row[i], &sine, &half);
        turn_row(s, i, row, &rest, sine, half);
    }
    return rest;
}

/* Whether column j depends on those before it. */
static int dependent(const puma560_real *R, int j)
{
    puma560_real largest = 0;
    puma560_real sum = 0;
    for (int i = 0; i <= j; i++) {
        const puma560_real size = magnitude(R[diagonal(i) + j - i]);
        largest = size > largest ? size : largest;
    }
    if (!(largest > 0)) {
        return 1;
    }
    for (int i = 0; i <= j; i++) {
        const puma560_real part = R[diagonal(i) + j - i] / largest;
        sum += part * part;
    }
    return !(R[diagonal(j)] > tolerance() * largest * sqrt(sum));
}

/* 0, or the number of the first parameter that is not determined. */
static int undetermined(const puma560_real *R)
{
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        if (dependent(R, j)) {
            return j + 1;
        }
    }
    return 0;
}

int puma560_least_squares_init(puma560_least_squares *s, puma560_real forgetting)
{
    if (!(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(s, 0, sizeof *s);
    s->forgetting = forgetting;
    s->kept = 1;
    if (forgetting < 1) {
        const puma560_real quarter = 1 / (4 * (1 - forgetting));
        const puma560_real most = (puma560_real)LONGEST;
        s->cycle = (long)(quarter < most ? quarter : most);
        s->cycle = (s->cycle > 2 * puma560_PARAMETERS ? s->cycle : 2 * puma560_PARAMETERS) +
                   puma560_PARAMETERS;
        puma560_real weight = forgetting;
        for (long left = s->cycle; left > 0; left /= 2) {
            s->kept *= left % 2 != 0 ? weight : 1;
            weight *= weight;
        }
        s->kept = s->kept > (puma560_real)FLT_MIN ? s->kept : (puma560_real)FLT_MIN;
    }
    return 0;
}

/* Solve R(0..last, 0..last) x = x in place. */
static void back_substitute(const puma560_real *R, puma560_real *x, int last)
{
    for (int i = last; i >= 0; i--) {
        const puma560_real *row = R + diagonal(i);
        x[i] = (x[i] - product(row + 1, x + i + 1, last - i)) / row[0];
    }
}

/* Solve R'u = u in place, where u is 0 before entry k. Returns u'u. */
static puma560_real forward_substitute(const puma560_real *R, puma560_real *u, int k)
{
    puma560_real sum = 0;
    for (int i = k; i < puma560_PARAMETERS; i++) {
        const puma560_real *row = R + diagonal(i);
        u[i] /= row[0];
        subtract(u + i + 1, row + 1, u[i], puma560_PARAMETERS - i - 1);
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
static void forget(puma560_least_squares *s, int k)
{
    const int size = puma560_PARAMETERS - k;
    const puma560_real least = (puma560_real)LEAST_SHARE * (1 - s->kept);
    puma560_real *b = s->gathered + diagonal(k);
    puma560_real u[puma560_PARAMETERS] = {0};
    puma560_real work[puma560_PARAMETERS] = {0};
    memcpy(u + k, b, (size_t)size * sizeof u[0]);
    (void)forward_substitute(s->R, u, k);
    back_substitute(s->R, u, puma560_PARAMETERS - 1); /* (R'R)^-1 b */
    for (int j = k + 1; j < puma560_PARAMETERS; j++) {
        const puma560_real *taken = s->gathered + diagonal(j);
        subtract(b + j - k, taken, product(u + j, taken, puma560_PARAMETERS - j), puma560_PARAMETERS - j);
    }
    memset(u, 0, sizeof u);
    memcpy(u + k, b, (size_t)size * sizeof u[0]);
    const puma560_real sum = forward_substitute(s->R, u, k);
    if (!(sum > least)) {
        memset(b, 0, (size_t)size * sizeof u[0]);
        return;
    }
    const puma560_real share = sqrt((1 - s->kept) / sum);
    const puma560_real unit = sqrt(s->kept / sum);
    puma560_real right = 0;
    puma560_real rest = sqrt(s->kept);
    for (int i = puma560_PARAMETERS - 1; i >= 0; i--) {
        const puma560_real v = share * u[i];
        const puma560_real length = sqrt(rest * rest + v * v);
        turn_row(s, i, work, &right, -v / length, -v / (length + rest));
        rest = length;
    }
    for (int i = 0; i < size; i++) {
        b[i] *= unit;
    }
}

/* Gather a row, which is overwritten, or forget along a row of what has been gathered. */
static void advance(puma560_least_squares *s, puma560_real *row)
{
    const long left = s->cycle - s->rows;
    if (left > puma560_PARAMETERS) {
        for (int i = 0; i < puma560_PARAMETERS; i++) {
            puma560_real *B = s->gathered + diagonal(i);
            puma560_real sine = 0;
            puma560_real half = 0;
            angle(B[0], row[i], &sine, &half);
            for (int j = 0; j < puma560_PARAMETERS - i; j++) {
                const puma560_real above = B[j];
                const puma560_real below = row[i + j];
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

int puma560_least_squares_update(puma560_least_squares *s, const puma560_real *row, puma560_real y)
{
    puma560_real work[puma560_PARAMETERS];
    int finite = isfinite(y) ? 1 : 0;
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        finite = finite && isfinite(row[i]);
        work[i] = row[i];
    }
    if (!finite) {
        return 1;
    }
    const puma560_real rest = rotate(s, work, y, 0);
    s->rss *= s->forgetting;
    s->count *= s->forgetting;
    s->rss += rest * rest;
    s->count += 1;
    if (s->forgetting < 1 && s->determined != 0) {
        memcpy(work, row, sizeof work);
        advance(s, work);
    }
    s->determined = s->determined != 0 || undetermined(s->R) == 0;
    return 0;
}

int puma560_least_squares_foresee(const puma560_least_squares *s, const puma560_real *row, puma560_real y,
                               puma560_real *u, puma560_real *innovation, puma560_real *leverage)
{
    puma560_real predicted = 0;
    memcpy(u, row, puma560_PARAMETERS * sizeof *u);
    if (s->determined == 0) {
        return 1;
    }
    *leverage = forward_substitute(s->R, u, 0);
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        predicted += u[i] * s->z[i];
    }
    *innovation = y - predicted;
    return 0;
}

void puma560_least_squares_merge(puma560_least_squares *s, const puma560_least_squares *other)
{
    puma560_real row[puma560_PARAMETERS];
    puma560_real rss = other->rss;
    const puma560_real count = other->count;
    /* From the last row up: row i changes rows i.. of s only, so that other may be s. */
    for (int i = puma560_PARAMETERS - 1; i >= 0; i--) {
        const puma560_real *R = other->R + diagonal(i);
        for (int j = i; j < puma560_PARAMETERS; j++) {
            row[j] = R[j - i];
        }
        const puma560_real rest = rotate(s, row, other->z[i], i);
        rss += rest * rest;
    }
    s->rss += rss;
    s->count += count;
    s->determined = s->determined != 0 || undetermined(s->R) == 0;
}

/* Standard deviation of an equation; NAN without a degree of freedom. */
static puma560_real deviation(const puma560_least_squares *s)
{
    const puma560_real freedom = s->count - (puma560_real)puma560_PARAMETERS;
    return freedom > 0 ? sqrt(s->rss / freedom) : (puma560_real)NAN;
}

/* Add the squares of column j of sigma R^-1, rows 0 to j. */
static void add_squares(const puma560_real *R, puma560_real sigma, int j, puma560_real *sum)
{
    puma560_real column[puma560_PARAMETERS];
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
static void sum_squares(const puma560_real *R, puma560_real sigma, puma560_real *sum)
{
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        sum[i] = 0;
    }
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        add_squares(R, sigma, j, sum);
    }
}

int puma560_least_squares_variances(const puma560_least_squares *s, puma560_real *out)
{
    const int missing = undetermined(s->R);
    if (missing == 0) {
        sum_squares(s->R, 1, out);
    }
    return missing;
}

void puma560_least_squares_back(const puma560_least_squares *s, puma560_real *x)
{
    back_substitute(s->R, x, puma560_PARAMETERS - 1);
}

int puma560_least_squares_solve(const puma560_least_squares *s, puma560_real *X, puma560_real *std,
                             puma560_real *rss)
{
    const int missing = undetermined(s->R);
    if (missing != 0) {
        return missing;
    }
    memcpy(X, s->z, sizeof s->z);
    back_substitute(s->R, X, puma560_PARAMETERS - 1);
    if (rss != NULL) {
        *rss = s->rss;
    }
    if (std != NULL) {
        const puma560_real sigma = deviation(s);
        sum_squares(s->R, sigma, std);
        for (int i = 0; i < puma560_PARAMETERS; i++) {
            std[i] = sqrt(std[i]);
        }
    }
    return 0;
}

void puma560_least_squares_begin(puma560_least_squares_solution *found, const puma560_least_squares *s)
{
    memcpy(found->R, s->R, sizeof s->R);
    memcpy(found->z, s->z, sizeof s->z);
    memset(found->squares, 0, sizeof found->squares);
    found->sigma = deviation(s);
    found->left = puma560_PARAMETERS + 1;
}

int puma560_least_squares_proceed(puma560_least_squares_solution *found, int pieces)
{
    for (int k = 0; k < pieces && found->left > 0; k++) {
        const int j = puma560_PARAMETERS + 1 - found->left;
        found->left--;
        if (j == puma560_PARAMETERS) {
            back_substitute(found->R, found->z, puma560_PARAMETERS - 1);
            memcpy(found->X, found->z, sizeof found->z);
            for (int i = 0; i < puma560_PARAMETERS; i++) {
                found->std[i] = sqrt(found->squares[i]);
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
