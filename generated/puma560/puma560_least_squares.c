#include "puma560_least_squares.h"

#include <math.h>
#include <string.h>

/* Loops over so many numbers at a time become vector instructions at -O2, too: each reads into
 * arrays of its own before it writes, so that nothing can be in the way. */
#define LANES 4

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

/* Turn a row of R, faded, and what is left of an equation by an angle: see rotate. */
static void turn(puma560_real *R, puma560_real *carry, puma560_real *row, puma560_real sine, puma560_real half,
                 puma560_real fade, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        puma560_real old[LANES];
        puma560_real below[LANES];
        puma560_real part[LANES];
        puma560_real total[LANES];
        for (int l = 0; l < LANES; l++) {
            old[l] = R[j + l];
            below[l] = row[j + l];
            part[l] = carry[j + l];
        }
        for (int l = 0; l < LANES; l++) {
            const puma560_real above = old[l] - fade * old[l];
            part[l] = (sine * (below[l] - half * above) - fade * old[l]) - part[l];
            below[l] = below[l] - sine * (above + half * below[l]);
            total[l] = old[l] + part[l];
            part[l] = (total[l] - old[l]) - part[l];
        }
        for (int l = 0; l < LANES; l++) {
            R[j + l] = total[l];
            row[j + l] = below[l];
            carry[j + l] = part[l];
        }
    }
    for (; j < size; j++) {
        const puma560_real above = R[j] - fade * R[j];
        const puma560_real below = row[j];
        add(R + j, carry + j, sine * (below - half * above) - fade * R[j]);
        row[j] = below - sine * (above + half * below);
    }
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
        puma560_real *R = s->R + diagonal(i);
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
        turn(R, s->R_carry + diagonal(i), row + i, sine, half, fade, puma560_PARAMETERS - i);
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
        subtract(u + i + 1, R + 1, u[i], puma560_PARAMETERS - i - 1);
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
    return !(R[diagonal(j)] > tolerance() * largest * square_root(sum));
}

/* Solve R(0..last, 0..last) x = x in place. */
static void back_substitute(const puma560_real *R, puma560_real *x, int last)
{
    for (int i = last; i >= 0; i--) {
        const puma560_real *row = R + diagonal(i);
        x[i] = (x[i] - product(row + 1, x + i + 1, last - i)) / row[0];
    }
}

/* Standard deviation of an equation; NAN without a degree of freedom. */
static puma560_real deviation(const puma560_least_squares *s)
{
    const double freedom = s->count - (double)puma560_PARAMETERS;
    return freedom > 0.0 ? square_root((puma560_real)(s->rss / freedom)) : (puma560_real)NAN;
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

int puma560_least_squares_solve(const puma560_least_squares *s, puma560_real *X, puma560_real *std,
                             puma560_real *rss)
{
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        if (dependent(s->R, j)) {
            return j + 1;
        }
    }
    memcpy(X, s->z, sizeof s->z);
    back_substitute(s->R, X, puma560_PARAMETERS - 1);
    if (rss != NULL) {
        *rss = (puma560_real)s->rss;
    }
    if (std != NULL) {
        const puma560_real sigma = deviation(s);
        for (int i = 0; i < puma560_PARAMETERS; i++) {
            std[i] = 0;
        }
        for (int j = 0; j < puma560_PARAMETERS; j++) {
            add_squares(s->R, sigma, j, std);
        }
        for (int i = 0; i < puma560_PARAMETERS; i++) {
            std[i] = square_root(std[i]);
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
                found->std[i] = square_root(found->squares[i]);
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
