/* Recursive least squares in square-root information form.
 *
 * The rows w'X = y seen so far are kept as the triangular factor of their QR decomposition,
 * [W y] = Q [R z; 0 e], updated one row at a time by Givens rotations.
 *
 * With forgetting, what is known is forgotten in the directions that new rows excite, and in no
 * other. A second triangle B gathers rows of about a quarter of the memory, and at least 2 p. Each
 * of the next p rows takes one row b of B, the last first, without its part along those taken
 * before, in the metric of (R'R)^-1, and forgets the share 1 - kept of what is known of b'X, where
 * kept = forgetting^rows for the rows of the whole cycle:
 *
 *     R'R <- R'R - (1 - kept) / h b b',   h = b' (R'R)^-1 b,   where X stays as it is,
 *
 * if h is at least a hundredth of 1 - kept: less is noise. Rows that excite all directions make the
 * past fade by `forgetting` a row, as exponential forgetting does.
 *
 * Sources: Golub and Van Loan, Matrix Computations, 5.1 (rotations) and 6.5 (appending and deleting
 * a row); Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. V (SRIF);
 * Lai and Bernstein, SIFt-RLS: subspace of information forgetting recursive least squares, 2024.
 *
 * No allocation and no static data: the caller owns every state. The work of an update, a merge
 * and a solution depends on the number of parameters only. Needs NaN and infinity: it does not
 * compile with -ffast-math.
 */
#ifndef NAME_LEAST_SQUARES_H
#define NAME_LEAST_SQUARES_H

#include "NAME.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Initialise with NAME_least_squares_init; read freely, never write.
 *
{% if dtype == "float" %}
 * Rounding errors do not grow with the number of rows, with forgetting or without: what adds up
 * over rows is compensated, at twice the memory (a plain float stops counting at 2^24). What
 * remains is as if each row had been rounded once more. Measured without forgetting, X against a
 * solution in double of the same rows: 2e-7 to 6e-7 after 10^6 and after 10^7 rows of 12 parameters
 * whose columns, scaled to one norm, have the condition number 8; it grows with that number.
{% else %}
 * Rounding errs by some 1e-16 of R a row, less than any measurement after 10^9 rows.
{% endif %}
 */
typedef struct NAME_least_squares {
    /* Upper triangle, row after row: R(i,j), i <= j, at i*p - i*(i-1)/2 + j - i; R(i,i) >= 0. */
    NAME_real R[NAME_PARAMETERS * (NAME_PARAMETERS + 1) / 2];
    NAME_real z[NAME_PARAMETERS]; /* Q'y */
    NAME_real rss;   /* weighted sum of squared residuals */
    NAME_real count; /* weighted number of rows */
{% if dtype == "float" %}
    /* What rounding has put into these too much: R is R - R_carry, and so on. */
    NAME_real R_carry[NAME_PARAMETERS * (NAME_PARAMETERS + 1) / 2];
    NAME_real z_carry[NAME_PARAMETERS];
    NAME_real rss_carry;
    NAME_real count_carry;
{% endif %}
    NAME_real gathered[NAME_PARAMETERS * (NAME_PARAMETERS + 1) / 2]; /* B */
    NAME_real forgetting; /* weight of the past, per row */
    NAME_real kept;       /* forgetting^cycle */
    long cycle;           /* rows between the beginnings of two B */
    long rows;            /* since the last beginning */
    int determined;       /* nonzero: the rows determine X */
} NAME_least_squares;

/* Begin with no data. forgetting, in (0, 1]: see above; 1 keeps everything. Until X is determined
 * nothing is forgotten. Returns 0; nonzero (and s untouched) when forgetting is outside (0, 1].
 */
int NAME_least_squares_init(NAME_least_squares *s, NAME_real forgetting);

/* Add the equation row'X = y, row of length NAME_PARAMETERS. Returns 0; nonzero (and s untouched)
 * when a number is not finite.
 */
int NAME_least_squares_update(NAME_least_squares *s, const NAME_real *row, NAME_real y);

/* What the equation row'X = y would bring: innovation = y - row'X with the X so far, and leverage
 * h = row' (R'R)^-1 row, the part of all information on its combination of parameters that would be
 * its own, over that of the past. With sigma as below, the innovation has the variance
 * sigma^2 (1 + leverage). u (NAME_PARAMETERS values) solves R'u = row. Returns 0; nonzero (and
 * nothing but u written) while X is not determined.
 */
int NAME_least_squares_foresee(const NAME_least_squares *s, const NAME_real *row, NAME_real y,
                               NAME_real *u, NAME_real *innovation, NAME_real *leverage);

/* Add to s all that other holds, with the weights the rows have there and without ageing s: chunks
 * of a log, or months of logs, solved apart and merged give the solution of the whole. other is
 * read only, and may be s.
 */
void NAME_least_squares_merge(NAME_least_squares *s, const NAME_least_squares *other);

/* Solve for X (NAME_PARAMETERS values).
 *
 * std (same length): sigma times the norms of the rows of R^-1, sigma^2 = rss / (count - p). It
 * takes the residuals of the rows as independent. NAN when count <= p: the data then say nothing
 * about their own noise. rss: sum of squared residuals. std and rss may be NULL.
 *
 * Returns 0, or the number (from 1) of the first parameter that the data do not determine, that is
 * whose column of W depends on the columns before it; nothing is written then, so that X stays the
 * last good one.
 */
int NAME_least_squares_solve(const NAME_least_squares *s, NAME_real *X, NAME_real *std,
                             NAME_real *rss);

/* The diagonal of (R'R)^-1, NAME_PARAMETERS values: the variances of X over sigma^2. Returns what
 * NAME_least_squares_solve returns. */
int NAME_least_squares_variances(const NAME_least_squares *s, NAME_real *out);

/* Solve R x = x in place. */
void NAME_least_squares_back(const NAME_least_squares *s, NAME_real *x);

/* A solution in pieces, for a cycle that a whole one would not fit: of what s holds when it begins,
 * whatever is added to s meanwhile.
 */
typedef struct NAME_least_squares_solution {
    NAME_real X[NAME_PARAMETERS];   /* as solve gives them; the last good ones */
    NAME_real std[NAME_PARAMETERS]; /* until a solution is complete */
    int missing; /* 0, or the number (from 1) of the first parameter that is not determined */
    int left;    /* pieces to go */
    NAME_real sigma;
    NAME_real squares[NAME_PARAMETERS];
    NAME_real R[NAME_PARAMETERS * (NAME_PARAMETERS + 1) / 2];
    NAME_real z[NAME_PARAMETERS];
} NAME_least_squares_solution;

/* Begin a solution: copies R and z. */
void NAME_least_squares_begin(NAME_least_squares_solution *found, const NAME_least_squares *s);

/* Go on by so many pieces, of NAME_PARAMETERS + 1 in all, each of at most NAME_PARAMETERS^2 / 2
 * products. Returns how many are left: 0 when `missing` is set, and where that is 0 X and std.
 */
int NAME_least_squares_proceed(NAME_least_squares_solution *found, int pieces);

#ifdef __cplusplus
}
#endif

#endif
