#include "planar2r_least_squares.h"

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
static planar2r_real tolerance(void)
{
    return sizeof(planar2r_real) == sizeof(float) ? (planar2r_real)1e-4 : (planar2r_real)1e-10;
}

/* sqrt in the precision of the package: the double one is slow on a single-precision FPU. */
static planar2r_real square_root(planar2r_real x)
{
    return sizeof(planar2r_real) == sizeof(float) ? (planar2r_real)sqrtf((float)x)
                                              : (planar2r_real)sqrt((double)x);
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

/* entry += change, where carry holds what rounding has added to entry too much (Kahan). */
static void add(planar2r_real *entry, planar2r_real *carry, planar2r_real change)
{
    const planar2r_real part = change - *carry;
    const planar2r_real sum = *entry + part;
    *carry = (sum - *entry) - part;
    *entry = sum;
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

/* Turn a row of R, faded, and what is left of an equation by an angle: see rotate. */
static void turn(planar2r_real *R, planar2r_real *carry, planar2r_real *row, planar2r_real sine, planar2r_real half,
                 planar2r_real fade, int size)
{
    int j = 0;
    for (; j + LANES <= size; j += LANES) {
        planar2r_real old[LANES];
        planar2r_real below[LANES];
        planar2r_real part[LANES];
        planar2r_real total[LANES];
        for (int l = 0; l < LANES; l++) {
            old[l] = R[j + l];
            below[l] = row[j + l];
            part[l] = carry[j + l];
        }
        for (int l = 0; l < LANES; l++) {
            const planar2r_real above = old[l] - fade * old[l];
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
        const planar2r_real above = R[j] - fade * R[j];
        const planar2r_real below = row[j];
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
static planar2r_real rotate(planar2r_least_squares *s, planar2r_real *row, planar2r_real y, int first,
                        planar2r_real fade)
{
    for (int i = first; i < planar2r_PARAMETERS; i++) {
        planar2r_real *R = s->R + diagonal(i);
        const planar2r_real pivot = R[0] - fade * R[0];
        const planar2r_real size = magnitude(row[i]);
        planar2r_real sine = 0;
        planar2r_real half = 0;
        if (size > pivot) {
            const planar2r_real ratio = pivot / size;
            const planar2r_real scale = square_root(1 + ratio * ratio);
            sine = (row[i] < 0 ? -1 : 1) / scale;
            half = (row[i] < 0 ? -1 : 1) / (scale + ratio);
        } else if (pivot > 0) {
            const planar2r_real ratio = row[i] / pivot;
            const planar2r_real scale = square_root(1 + ratio * ratio);
            sine = ratio / scale;
            half = ratio / (scale + 1);
        }
        turn(R, s->R_carry + diagonal(i), row + i, sine, half, fade, planar2r_PARAMETERS - i);
        const planar2r_real above = s->z[i] - fade * s->z[i];
        add(s->z + i, s->z_carry + i, sine * (y - half * above) - fade * s->z[i]);
        y = y - sine * (above + half * y);
    }
    return y;
}

int planar2r_least_squares_init(planar2r_least_squares *s, planar2r_real forgetting)
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
    const double rest = (double)rotate(s, work, y, 0, s->fade);
    s->rss = (double)s->forgetting * s->rss + rest * rest;
    s->count = (double)s->forgetting * s->count + 1.0;
    return 0;
}

int planar2r_least_squares_foresee(const planar2r_least_squares *s, const planar2r_real *row, planar2r_real y,
                               planar2r_real *innovation, planar2r_real *leverage)
{
    planar2r_real u[planar2r_PARAMETERS]; /* R'u = row, so that row'X = u'z */
    planar2r_real predicted = 0;
    planar2r_real sum = 0;
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        if (!(s->R[diagonal(i)] > 0)) {
            return 1;
        }
        u[i] = row[i];
    }
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        const planar2r_real *R = s->R + diagonal(i);
        u[i] /= R[0];
        subtract(u + i + 1, R + 1, u[i], planar2r_PARAMETERS - i - 1);
        predicted += u[i] * s->z[i];
        sum += u[i] * u[i];
    }
    *innovation = y - predicted;
    *leverage = sum;
    return 0;
}

void planar2r_least_squares_merge(planar2r_least_squares *s, const planar2r_least_squares *other)
{
    planar2r_real row[planar2r_PARAMETERS];
    double rss = s->rss + other->rss;
    const double count = s->count + other->count;
    /* From the last row up: row i changes rows i.. of s only, so that other may be s. */
    for (int i = planar2r_PARAMETERS - 1; i >= 0; i--) {
        const planar2r_real *R = other->R + diagonal(i);
        for (int j = i; j < planar2r_PARAMETERS; j++) {
            row[j] = R[j - i];
        }
        const double rest = (double)rotate(s, row, other->z[i], i, 0);
        rss += rest * rest;
    }
    s->rss = rss;
    s->count = count;
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
    return !(R[diagonal(j)] > tolerance() * largest * square_root(sum));
}

/* Solve R(0..last, 0..last) x = x in place. */
static void back_substitute(const planar2r_real *R, planar2r_real *x, int last)
{
    for (int i = last; i >= 0; i--) {
        const planar2r_real *row = R + diagonal(i);
        x[i] = (x[i] - product(row + 1, x + i + 1, last - i)) / row[0];
    }
}

/* Standard deviation of an equation; NAN without a degree of freedom. */
static planar2r_real deviation(const planar2r_least_squares *s)
{
    const double freedom = s->count - (double)planar2r_PARAMETERS;
    return freedom > 0.0 ? square_root((planar2r_real)(s->rss / freedom)) : (planar2r_real)NAN;
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

int planar2r_least_squares_solve(const planar2r_least_squares *s, planar2r_real *X, planar2r_real *std,
                             planar2r_real *rss)
{
    for (int j = 0; j < planar2r_PARAMETERS; j++) {
        if (dependent(s->R, j)) {
            return j + 1;
        }
    }
    memcpy(X, s->z, sizeof s->z);
    back_substitute(s->R, X, planar2r_PARAMETERS - 1);
    if (rss != NULL) {
        *rss = (planar2r_real)s->rss;
    }
    if (std != NULL) {
        const planar2r_real sigma = deviation(s);
        for (int i = 0; i < planar2r_PARAMETERS; i++) {
            std[i] = 0;
        }
        for (int j = 0; j < planar2r_PARAMETERS; j++) {
            add_squares(s->R, sigma, j, std);
        }
        for (int i = 0; i < planar2r_PARAMETERS; i++) {
            std[i] = square_root(std[i]);
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
