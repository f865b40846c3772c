#include "NAME_least_squares.h"

#include <math.h>
#include <string.h>

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

/* sqrt in the precision of the package: the double one is slow on a single-precision FPU. */
static NAME_real square_root(NAME_real x)
{
    return sizeof(NAME_real) == sizeof(float) ? (NAME_real)sqrtf((float)x)
                                              : (NAME_real)sqrt((double)x);
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

/* entry += change, where carry holds what rounding has added to entry too much (Kahan). */
static void add(NAME_real *entry, NAME_real *carry, NAME_real change)
{
    const NAME_real part = change - *carry;
    const NAME_real sum = *entry + part;
    *carry = (sum - *entry) - part;
    *entry = sum;
}

/* Rotate the equation row'X = y into [R z], both scaled by 1 - fade on the way, from column first
 * on; row is overwritten. Returns what is left of y, which is orthogonal to all columns.
 *
 * The smaller of the two numbers is divided by the larger, so that no square overflows; a row of R
 * that is still empty (pivot 0) takes the equation over as it is. No branch depends on the data
 * but those two: every row costs the same.
 *
 * Rotation and fading are applied as a change, with half = tan(angle / 2): cosine above + sine
 * below is above + sine (below - half above). A row that comes after many turns R by a small angle
 * only: the change has the row's size, its rounding too, and the compensated sum loses none of it.
 * So rounding errs by a share of each row, as if the row had been measured that much worse; errors
 * of the size of R, which add up over the rows, do not arise. The diagonal goes the same way as the
 * rest of its row, so that columns in proportion stay in proportion.
 */
static NAME_real rotate(NAME_least_squares *s, NAME_real *row, NAME_real y, int first,
                        NAME_real fade)
{
    for (int i = first; i < NAME_PARAMETERS; i++) {
        const int width = NAME_PARAMETERS - i;
        NAME_real *R = s->R + diagonal(i);
        NAME_real *carry = s->R_carry + diagonal(i);
        const NAME_real pivot = R[0] - fade * R[0];
        const NAME_real size = magnitude(row[i]);
        NAME_real sine = 0;
        NAME_real half = 0;
        if (size > pivot) {
            const NAME_real ratio = pivot / size;
            const NAME_real scale = square_root(1 + ratio * ratio);
            sine = (row[i] < 0 ? -1 : 1) / scale;
            half = (row[i] < 0 ? -1 : 1) / (scale + ratio);
        } else if (pivot > 0) {
            const NAME_real ratio = row[i] / pivot;
            const NAME_real scale = square_root(1 + ratio * ratio);
            sine = ratio / scale;
            half = ratio / (scale + 1);
        }
        for (int j = 0; j < width; j++) {
            const NAME_real above = R[j] - fade * R[j];
            const NAME_real below = row[i + j];
            add(R + j, carry + j, sine * (below - half * above) - fade * R[j]);
            row[i + j] = below - sine * (above + half * below);
        }
        const NAME_real above = s->z[i] - fade * s->z[i];
        add(s->z + i, s->z_carry + i, sine * (y - half * above) - fade * s->z[i]);
        y = y - sine * (above + half * y);
    }
    return y;
}

int NAME_least_squares_init(NAME_least_squares *s, NAME_real forgetting)
{
    if (!(forgetting > 0 && forgetting <= 1)) {
        return 1;
    }
    memset(s, 0, sizeof *s);
    s->forgetting = forgetting;
    /* 1 - root, without cancellation */
    s->fade = (1 - forgetting) / (1 + square_root(forgetting));
    return 0;
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
    const double rest = (double)rotate(s, work, y, 0, s->fade);
    s->rss = (double)s->forgetting * s->rss + rest * rest;
    s->count = (double)s->forgetting * s->count + 1.0;
    return 0;
}

int NAME_least_squares_foresee(const NAME_least_squares *s, const NAME_real *row, NAME_real y,
                               NAME_real *innovation, NAME_real *leverage)
{
    NAME_real u[NAME_PARAMETERS]; /* R'u = row, so that row'X = u'z */
    NAME_real predicted = 0;
    NAME_real sum = 0;
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        if (!(s->R[diagonal(i)] > 0)) {
            return 1;
        }
        u[i] = row[i];
    }
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        const NAME_real *R = s->R + diagonal(i);
        u[i] /= R[0];
        for (int j = i + 1; j < NAME_PARAMETERS; j++) {
            u[j] -= R[j - i] * u[i];
        }
        predicted += u[i] * s->z[i];
        sum += u[i] * u[i];
    }
    *innovation = y - predicted;
    *leverage = sum;
    return 0;
}

void NAME_least_squares_merge(NAME_least_squares *s, const NAME_least_squares *other)
{
    NAME_real row[NAME_PARAMETERS];
    double rss = s->rss + other->rss;
    const double count = s->count + other->count;
    /* From the last row up: row i changes rows i.. of s only, so that other may be s. */
    for (int i = NAME_PARAMETERS - 1; i >= 0; i--) {
        const NAME_real *R = other->R + diagonal(i);
        for (int j = i; j < NAME_PARAMETERS; j++) {
            row[j] = R[j - i];
        }
        const double rest = (double)rotate(s, row, other->z[i], i, 0);
        rss += rest * rest;
    }
    s->rss = rss;
    s->count = count;
}

/* The number (from 1) of the first column that depends on those before it, or 0. */
static int undetermined(const NAME_least_squares *s)
{
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        NAME_real largest = 0;
        for (int i = 0; i <= j; i++) {
            const NAME_real size = magnitude(s->R[diagonal(i) + j - i]);
            largest = size > largest ? size : largest;
        }
        if (!(largest > 0)) {
            return j + 1;
        }
        NAME_real sum = 0;
        for (int i = 0; i <= j; i++) {
            const NAME_real part = s->R[diagonal(i) + j - i] / largest;
            sum += part * part;
        }
        if (!(s->R[diagonal(j)] > tolerance() * largest * square_root(sum))) {
            return j + 1;
        }
    }
    return 0;
}

/* Solve R(0..last, 0..last) x = x in place. */
static void back_substitute(const NAME_least_squares *s, NAME_real *x, int last)
{
    for (int i = last; i >= 0; i--) {
        const NAME_real *R = s->R + diagonal(i);
        NAME_real sum = x[i];
        for (int j = i + 1; j <= last; j++) {
            sum -= R[j - i] * x[j];
        }
        x[i] = sum / R[0];
    }
}

int NAME_least_squares_solve(const NAME_least_squares *s, NAME_real *X, NAME_real *std,
                             NAME_real *rss)
{
    const int culprit = undetermined(s);
    if (culprit != 0) {
        return culprit;
    }
    memcpy(X, s->z, sizeof s->z);
    back_substitute(s, X, NAME_PARAMETERS - 1);
    if (rss != NULL) {
        *rss = (NAME_real)s->rss;
    }
    if (std != NULL) {
        const double freedom = s->count - (double)NAME_PARAMETERS;
        const NAME_real sigma =
            freedom > 0.0 ? square_root((NAME_real)(s->rss / freedom)) : (NAME_real)NAN;
        NAME_real column[NAME_PARAMETERS]; /* of sigma R^-1, one at a time */
        for (int i = 0; i < NAME_PARAMETERS; i++) {
            std[i] = 0;
        }
        for (int j = 0; j < NAME_PARAMETERS; j++) {
            for (int i = 0; i < j; i++) {
                column[i] = 0;
            }
            column[j] = sigma;
            back_substitute(s, column, j);
            for (int i = 0; i <= j; i++) {
                std[i] += column[i] * column[i];
            }
        }
        for (int i = 0; i < NAME_PARAMETERS; i++) {
            std[i] = square_root(std[i]);
        }
    }
    return 0;
}
