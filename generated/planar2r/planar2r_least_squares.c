#include "planar2r_least_squares.h"

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
static planar2r_real tolerance(void)
{
    return sizeof(planar2r_real) == sizeof(float) ? (planar2r_real)1e-4 : (planar2r_real)1e-10;
}

static planar2r_real magnitude(planar2r_real x)
{
    return x < 0 ? -x : x;
}

/* Index in the packed triangle of the diagonal entry of row i (from 0). */
static int diagonal(int i)
{
    return i * planar2r_PARAMETERS - i * (i - 1) / 2;
}

/* x'y, of `size` numbers. */
static planar2r_real product(const planar2r_real *x, const planar2r_real *y, int size)
{
    planar2r_real sum[LANES] = {0};
    planar2r_real rest = 0;
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
static void subtract(planar2r_real *x, const planar2r_real *y, planar2r_real factor, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        planar2r_real part[LANES];
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
static void turn(planar2r_real *R, planar2r_real *row,
                 planar2r_real sine, planar2r_real half, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        planar2r_real old[LANES];
        planar2r_real below[LANES];
        planar2r_real total[LANES];
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
        const planar2r_real above = R[j];
        const planar2r_real below = row[j];
        R[j] += sine * (below - half * above);
        row[j] = below - sine * (above + half * below);
    }
}

/* Turn row i of [R z] and another row [row right]. */
static void turn_row(planar2r_least_squares *s, int i, planar2r_real *row, planar2r_real *right,
                     planar2r_real sine, planar2r_real half)
{
    const int at = diagonal(i);
    turn(s->R + at, row + i, sine, half,
        planar2r_PARAMETERS - i);
    turn(s->z + i, right, sine, half, 1);
}

/* Sine and tan(angle / 2) of the rotation that takes `below` into `pivot`, which is not negative.
 * The smaller of the two is divided by the larger, so that no square overflows. */
static void angle(planar2r_real pivot, planar2r_real below, planar2r_real *sine, planar2r_real *half)
{
    const planar2r_real size = magnitude(below);
    *sine = 0;
    *half = 0;
    if (size > pivot) {
        const planar2r_real ratio = pivot / size;
        const planar2r_real scale = sqrt(1 + ratio * ratio);
        *sine = (below < 0 ? -1 : 1) / scale;
        *half = (below < 0 ? -1 : 1) / (scale + ratio);
    } else if (pivot > 0) {
        const planar2r_real ratio = below / pivot;
        const planar2r_real scale = sqrt(1 + ratio * ratio);
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
static planar2r_real rotate(planar2r_least_squares *s, planar2r_real *row, planar2r_real y, int first)
{
    planar2r_real rest = y;
    for (int i = first; i < planar2r_PARAMETERS; i++) {
        planar2r_real sine = 0;
        planar2r_real half = 0;
        angle(s->R[diagonal(i)], row[i], &sine, &half);
        turn_row(s, i, row, &rest, sine, half);
    }
    return rest;
}

/* Whether column j depends on those before it. */
static int dependent(const planar2r_real *R, int j)
{
    planar2r_real largest = 0;
    planar2r_real sum = 0;
    for (int i = 0; i <= j; i++) {
        const planar2r_real size = magnitude(R[diagonal(i) + j - i]);
        largest = size > largest ? size : largest;
    }
    if (!(largest > 0)) {
        return 1;
    }
    for (int i = 0; i <= j; i++) {
        const planar2r_real part = R[diagonal(i) + j - i] / largest;
        sum += part * part;
    }
    return !(R[diagonal(j)] > tolerance() * largest * sqrt(sum));
}

/* 0, or the number of the first parameter that is not determined. */
static int undetermined(const planar2r_real *R)
{
    for (int j = 0; j < planar2r_PARAMETERS; j++) {
        if (dependent(R, j)) {
            return j + 1;
        }
    }
    return 0;
}

int planar2r_least_squares_init(planar2r_least_squares *s, planar2r_real forgetting)
{
    if (!(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(s, 0, sizeof *s);
    s->forgetting = forgetting;
    s->kept = 1;
    if (forgetting < 1) {
        const planar2r_real quarter = 1 / (4 * (1 - forgetting));
        const planar2r_real most = (planar2r_real)LONGEST;
        s->cycle = (long)(quarter < most ? quarter : most);
        s->cycle = (s->cycle > 2 * planar2r_PARAMETERS ? s->cycle : 2 * planar2r_PARAMETERS) +
                   planar2r_PARAMETERS;
        planar2r_real weight = forgetting;
        for (long left = s->cycle; left > 0; left /= 2) {
            s->kept *= left % 2 != 0 ? weight : 1;
            weight *= weight;
        }
        s->kept = s->kept > (planar2r_real)FLT_MIN ? s->kept : (planar2r_real)FLT_MIN;
    }
    return 0;
}

/* Solve R(0..last, 0..last) x = x in place. */
static void back_substitute(const planar2r_real *R, planar2r_real *x, int last)
{
    for (int i = last; i >= 0; i--) {
        const planar2r_real *row = R + diagonal(i);
        x[i] = (x[i] - product(row + 1, x + i + 1, last - i)) / row[0];
    }
}

/* Solve R'u = u in place, where u is 0 before entry k. Returns u'u. */
static planar2r_real forward_substitute(const planar2r_real *R, planar2r_real *u, int k)
{
    planar2r_real sum = 0;
    for (int i = k; i < planar2r_PARAMETERS; i++) {
        const planar2r_real *row = R + diagonal(i);
        u[i] /= row[0];
        subtract(u + i + 1, row + 1, u[i], planar2r_PARAMETERS - i - 1);
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
static void forget(planar2r_least_squares *s, int k)
{
    const int size = planar2r_PARAMETERS - k;
    const planar2r_real least = (planar2r_real)LEAST_SHARE * (1 - s->kept);
    planar2r_real *b = s->gathered + diagonal(k);
    planar2r_real u[planar2r_PARAMETERS] = {0};
    planar2r_real work[planar2r_PARAMETERS] = {0};
    memcpy(u + k, b, (size_t)size * sizeof u[0]);
    (void)forward_substitute(s->R, u, k);
    back_substitute(s->R, u, planar2r_PARAMETERS - 1); /* (R'R)^-1 b */
    for (int j = k + 1; j < planar2r_PARAMETERS; j++) {
        const planar2r_real *taken = s->gathered + diagonal(j);
        subtract(b + j - k, taken, product(u + j, taken, planar2r_PARAMETERS - j), planar2r_PARAMETERS - j);
    }
    memset(u, 0, sizeof u);
    memcpy(u + k, b, (size_t)size * sizeof u[0]);
    const planar2r_real sum = forward_substitute(s->R, u, k);
    if (!(sum > least)) {
        memset(b, 0, (size_t)size * sizeof u[0]);
        return;
    }
    const planar2r_real share = sqrt((1 - s->kept) / sum);
    const planar2r_real unit = sqrt(s->kept / sum);
    planar2r_real right = 0;
    planar2r_real rest = sqrt(s->kept);
    for (int i = planar2r_PARAMETERS - 1; i >= 0; i--) {
        const planar2r_real v = share * u[i];
        const planar2r_real length = sqrt(rest * rest + v * v);
        turn_row(s, i, work, &right, -v / length, -v / (length + rest));
        rest = length;
    }
    for (int i = 0; i < size; i++) {
        b[i] *= unit;
    }
}

/* Gather a row, which is overwritten, or forget along a row of what has been gathered. */
static void advance(planar2r_least_squares *s, planar2r_real *row)
{
    const long left = s->cycle - s->rows;
    if (left > planar2r_PARAMETERS) {
        for (int i = 0; i < planar2r_PARAMETERS; i++) {
            planar2r_real *B = s->gathered + diagonal(i);
            planar2r_real sine = 0;
            planar2r_real half = 0;
            angle(B[0], row[i], &sine, &half);
            for (int j = 0; j < planar2r_PARAMETERS - i; j++) {
                const planar2r_real above = B[j];
                const planar2r_real below = row[i + j];
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

int planar2r_least_squares_update(planar2r_least_squares *s, const planar2r_real *row, planar2r_real y)
{
    planar2r_real work[planar2r_PARAMETERS];
    int finite = isfinite(y) ? 1 : 0;
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        finite = finite && isfinite(row[i]);
        work[i] = row[i];
    }
    if (!finite) {
        return 1;
    }
    const planar2r_real rest = rotate(s, work, y, 0);
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

int planar2r_least_squares_foresee(const planar2r_least_squares *s, const planar2r_real *row, planar2r_real y,
                               planar2r_real *u, planar2r_real *innovation, planar2r_real *leverage)
{
    planar2r_real predicted = 0;
    memcpy(u, row, planar2r_PARAMETERS * sizeof *u);
    if (s->determined == 0) {
        return 1;
    }
    *leverage = forward_substitute(s->R, u, 0);
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        predicted += u[i] * s->z[i];
    }
    *innovation = y - predicted;
    return 0;
}

void planar2r_least_squares_merge(planar2r_least_squares *s, const planar2r_least_squares *other)
{
    planar2r_real row[planar2r_PARAMETERS];
    planar2r_real rss = other->rss;
    const planar2r_real count = other->count;
    /* From the last row up: row i changes rows i.. of s only, so that other may be s. */
    for (int i = planar2r_PARAMETERS - 1; i >= 0; i--) {
        const planar2r_real *R = other->R + diagonal(i);
        for (int j = i; j < planar2r_PARAMETERS; j++) {
            row[j] = R[j - i];
        }
        const planar2r_real rest = rotate(s, row, other->z[i], i);
        rss += rest * rest;
    }
    s->rss += rss;
    s->count += count;
    s->determined = s->determined != 0 || undetermined(s->R) == 0;
}

/* Standard deviation of an equation; NAN without a degree of freedom. */
static planar2r_real deviation(const planar2r_least_squares *s)
{
    const planar2r_real freedom = s->count - (planar2r_real)planar2r_PARAMETERS;
    return freedom > 0 ? sqrt(s->rss / freedom) : (planar2r_real)NAN;
}

/* Add the squares of column j of sigma R^-1, rows 0 to j. */
static void add_squares(const planar2r_real *R, planar2r_real sigma, int j, planar2r_real *sum)
{
    planar2r_real column[planar2r_PARAMETERS];
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
static void sum_squares(const planar2r_real *R, planar2r_real sigma, planar2r_real *sum)
{
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        sum[i] = 0;
    }
    for (int j = 0; j < planar2r_PARAMETERS; j++) {
        add_squares(R, sigma, j, sum);
    }
}

int planar2r_least_squares_variances(const planar2r_least_squares *s, planar2r_real *out)
{
    const int missing = undetermined(s->R);
    if (missing == 0) {
        sum_squares(s->R, 1, out);
    }
    return missing;
}

void planar2r_least_squares_back(const planar2r_least_squares *s, planar2r_real *x)
{
    back_substitute(s->R, x, planar2r_PARAMETERS - 1);
}

int planar2r_least_squares_solve(const planar2r_least_squares *s, planar2r_real *X, planar2r_real *std,
                             planar2r_real *rss)
{
    const int missing = undetermined(s->R);
    if (missing != 0) {
        return missing;
    }
    memcpy(X, s->z, sizeof s->z);
    back_substitute(s->R, X, planar2r_PARAMETERS - 1);
    if (rss != NULL) {
        *rss = s->rss;
    }
    if (std != NULL) {
        const planar2r_real sigma = deviation(s);
        sum_squares(s->R, sigma, std);
        for (int i = 0; i < planar2r_PARAMETERS; i++) {
            std[i] = sqrt(std[i]);
        }
    }
    return 0;
}

void planar2r_least_squares_begin(planar2r_least_squares_solution *found, const planar2r_least_squares *s)
{
    memcpy(found->R, s->R, sizeof s->R);
    memcpy(found->z, s->z, sizeof s->z);
    memset(found->squares, 0, sizeof found->squares);
    found->sigma = deviation(s);
    found->left = planar2r_PARAMETERS + 1;
}

int planar2r_least_squares_proceed(planar2r_least_squares_solution *found, int pieces)
{
    for (int k = 0; k < pieces && found->left > 0; k++) {
        const int j = planar2r_PARAMETERS + 1 - found->left;
        found->left--;
        if (j == planar2r_PARAMETERS) {
            back_substitute(found->R, found->z, planar2r_PARAMETERS - 1);
            memcpy(found->X, found->z, sizeof found->z);
            for (int i = 0; i < planar2r_PARAMETERS; i++) {
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
