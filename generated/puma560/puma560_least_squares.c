#include "puma560_least_squares.h"

#include <math.h>
#include <string.h>

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

/* sqrt in the precision of the package: the double one is slow on a single-precision FPU. */
static puma560_real square_root(puma560_real x)
{
    return sizeof(puma560_real) == sizeof(float) ? (puma560_real)sqrtf((float)x)
                                              : (puma560_real)sqrt((double)x);
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

/* entry += change, where carry holds what rounding has added to entry too much (Kahan). */
static void add(puma560_real *entry, puma560_real *carry, puma560_real change)
{
    const puma560_real part = change - *carry;
    const puma560_real sum = *entry + part;
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
static puma560_real rotate(puma560_least_squares *s, puma560_real *row, puma560_real y, int first,
                        puma560_real fade)
{
    for (int i = first; i < puma560_PARAMETERS; i++) {
        const int width = puma560_PARAMETERS - i;
        puma560_real *R = s->R + diagonal(i);
        puma560_real *carry = s->R_carry + diagonal(i);
        const puma560_real pivot = R[0] - fade * R[0];
        const puma560_real size = magnitude(row[i]);
        puma560_real sine = 0;
        puma560_real half = 0;
        if (size > pivot) {
            const puma560_real ratio = pivot / size;
            const puma560_real scale = square_root(1 + ratio * ratio);
            sine = (row[i] < 0 ? -1 : 1) / scale;
            half = (row[i] < 0 ? -1 : 1) / (scale + ratio);
        } else if (pivot > 0) {
            const puma560_real ratio = row[i] / pivot;
            const puma560_real scale = square_root(1 + ratio * ratio);
            sine = ratio / scale;
            half = ratio / (scale + 1);
        }
        for (int j = 0; j < width; j++) {
            const puma560_real above = R[j] - fade * R[j];
            const puma560_real below = row[i + j];
            add(R + j, carry + j, sine * (below - half * above) - fade * R[j]);
            row[i + j] = below - sine * (above + half * below);
        }
        const puma560_real above = s->z[i] - fade * s->z[i];
        add(s->z + i, s->z_carry + i, sine * (y - half * above) - fade * s->z[i]);
        y = y - sine * (above + half * y);
    }
    return y;
}

int puma560_least_squares_init(puma560_least_squares *s, puma560_real forgetting)
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
    const double rest = (double)rotate(s, work, y, 0, s->fade);
    s->rss = (double)s->forgetting * s->rss + rest * rest;
    s->count = (double)s->forgetting * s->count + 1.0;
    return 0;
}

int puma560_least_squares_foresee(const puma560_least_squares *s, const puma560_real *row, puma560_real y,
                               puma560_real *innovation, puma560_real *leverage)
{
    puma560_real u[puma560_PARAMETERS]; /* R'u = row, so that row'X = u'z */
    puma560_real predicted = 0;
    puma560_real sum = 0;
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        if (!(s->R[diagonal(i)] > 0)) {
            return 1;
        }
        u[i] = row[i];
    }
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        const puma560_real *R = s->R + diagonal(i);
        u[i] /= R[0];
        for (int j = i + 1; j < puma560_PARAMETERS; j++) {
            u[j] -= R[j - i] * u[i];
        }
        predicted += u[i] * s->z[i];
        sum += u[i] * u[i];
    }
    *innovation = y - predicted;
    *leverage = sum;
    return 0;
}

void puma560_least_squares_merge(puma560_least_squares *s, const puma560_least_squares *other)
{
    puma560_real row[puma560_PARAMETERS];
    double rss = s->rss + other->rss;
    const double count = s->count + other->count;
    /* From the last row up: row i changes rows i.. of s only, so that other may be s. */
    for (int i = puma560_PARAMETERS - 1; i >= 0; i--) {
        const puma560_real *R = other->R + diagonal(i);
        for (int j = i; j < puma560_PARAMETERS; j++) {
            row[j] = R[j - i];
        }
        const double rest = (double)rotate(s, row, other->z[i], i, 0);
        rss += rest * rest;
    }
    s->rss = rss;
    s->count = count;
}

/* The number (from 1) of the first column that depends on those before it, or 0. */
static int undetermined(const puma560_least_squares *s)
{
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        puma560_real largest = 0;
        for (int i = 0; i <= j; i++) {
            const puma560_real size = magnitude(s->R[diagonal(i) + j - i]);
            largest = size > largest ? size : largest;
        }
        if (!(largest > 0)) {
            return j + 1;
        }
        puma560_real sum = 0;
        for (int i = 0; i <= j; i++) {
            const puma560_real part = s->R[diagonal(i) + j - i] / largest;
            sum += part * part;
        }
        if (!(s->R[diagonal(j)] > tolerance() * largest * square_root(sum))) {
            return j + 1;
        }
    }
    return 0;
}

/* Solve R(0..last, 0..last) x = x in place. */
static void back_substitute(const puma560_least_squares *s, puma560_real *x, int last)
{
    for (int i = last; i >= 0; i--) {
        const puma560_real *R = s->R + diagonal(i);
        puma560_real sum = x[i];
        for (int j = i + 1; j <= last; j++) {
            sum -= R[j - i] * x[j];
        }
        x[i] = sum / R[0];
    }
}

int puma560_least_squares_solve(const puma560_least_squares *s, puma560_real *X, puma560_real *std,
                             puma560_real *rss)
{
    const int culprit = undetermined(s);
    if (culprit != 0) {
        return culprit;
    }
    memcpy(X, s->z, sizeof s->z);
    back_substitute(s, X, puma560_PARAMETERS - 1);
    if (rss != NULL) {
        *rss = (puma560_real)s->rss;
    }
    if (std != NULL) {
        const double freedom = s->count - (double)puma560_PARAMETERS;
        const puma560_real sigma =
            freedom > 0.0 ? square_root((puma560_real)(s->rss / freedom)) : (puma560_real)NAN;
        puma560_real column[puma560_PARAMETERS]; /* of sigma R^-1, one at a time */
        for (int i = 0; i < puma560_PARAMETERS; i++) {
            std[i] = 0;
        }
        for (int j = 0; j < puma560_PARAMETERS; j++) {
            for (int i = 0; i < j; i++) {
                column[i] = 0;
            }
            column[j] = sigma;
            back_substitute(s, column, j);
            for (int i = 0; i <= j; i++) {
                std[i] += column[i] * column[i];
            }
        }
        for (int i = 0; i < puma560_PARAMETERS; i++) {
            std[i] = square_root(std[i]);
        }
    }
    return 0;
}
