/* Recursive least squares in square-root information form.
 *
 * The rows w'X = y seen so far are kept as the triangular factor of their QR decomposition,
 * [W y] = Q [R z; 0 e], updated one row at a time by Givens rotations.
 *
 * Sources: Golub and Van Loan, Matrix Computations, 5.1 (rotations) and 6.5 (appending a row);
 * Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. V (SRIF).
 *
 * No allocation and no static data: the caller owns every state. The work of an update, a merge
 * and a solution depends on the number of parameters only. Needs NaN and infinity: do not compile
 * with -ffast-math.
 */
#ifndef rx90_LEAST_SQUARES_H
#define rx90_LEAST_SQUARES_H

#include "rx90.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Initialise with rx90_least_squares_init; read freely, never write.
 *
 * Rounding errors do not grow with the number of rows, with forgetting or without: what adds up
 * over rows is compensated, at twice the memory of R and z, and rss and count are double in a float
 * package too (a float stops counting at 2^24). What remains is as if each row had been rounded
 * once more. Measured in float, X against a solution in double of the same rows: 2e-7 to 6e-7 after
 * 10^6 and after 10^7 rows of 12 parameters whose columns, scaled to one norm, have the condition
 * number 8; it grows with that number.
 */
typedef struct rx90_least_squares {
    /* Upper triangle, row after row: R(i,j), i <= j, at i*p - i*(i-1)/2 + j - i; R(i,i) >= 0. */
    rx90_real R[rx90_PARAMETERS * (rx90_PARAMETERS + 1) / 2];
    rx90_real z[rx90_PARAMETERS]; /* Q'y */
    /* What rounding has put into R and z too much: they are R - R_carry and z - z_carry. */
    rx90_real R_carry[rx90_PARAMETERS * (rx90_PARAMETERS + 1) / 2];
    rx90_real z_carry[rx90_PARAMETERS];
    rx90_real forgetting; /* weight of the past, per row */
    rx90_real fade;       /* 1 - its square root */
    double rss;                   /* weighted sum of squared residuals */
    double count;                 /* weighted number of rows */
} rx90_least_squares;

/* Begin with no data. forgetting, in (0, 1]: a row that is k rows old weighs forgetting^k; 1 keeps
 * everything. Returns 0; nonzero (and s untouched) when forgetting is outside (0, 1].
 */
int rx90_least_squares_init(rx90_least_squares *s, rx90_real forgetting);

/* Add the equation row'X = y, row of length rx90_PARAMETERS. Returns 0; nonzero (and s untouched)
 * when a number is not finite.
 */
int rx90_least_squares_update(rx90_least_squares *s, const rx90_real *row, rx90_real y);

/* What the equation row'X = y would bring: innovation = y - row'X with the X so far, and leverage =
 * row' (R'R)^-1 row, the part of all information on its combination of parameters that would be its
 * own, over that of the past. With sigma as below, the innovation has the variance
 * sigma^2 (1 + leverage). Returns 0; nonzero (and nothing written) while X is not determined.
 */
int rx90_least_squares_foresee(const rx90_least_squares *s, const rx90_real *row, rx90_real y,
                               rx90_real *innovation, rx90_real *leverage);

/* Add to s all that other holds, with the weights the rows have there and without ageing s: chunks
 * of a log, or months of logs, solved apart and merged give the solution of the whole. other is
 * read only, and may be s.
 */
void rx90_least_squares_merge(rx90_least_squares *s, const rx90_least_squares *other);

/* Solve for X (rx90_PARAMETERS values).
 *
 * std (same length): sigma times the norms of the rows of R^-1, sigma^2 = rss / (count - p). It
 * takes the residuals of the rows as independent. NAN when count <= p: the data then say nothing
 * about their own noise. rss: sum of squared residuals. std and rss may be NULL.
 *
 * Returns 0, or the number (from 1) of the first parameter that the data do not determine, that is
 * whose column of W depends on the columns before it; nothing is written then, so that X stays the
 * last good one.
 */
int rx90_least_squares_solve(const rx90_least_squares *s, rx90_real *X, rx90_real *std,
                             rx90_real *rss);

/* A solution in pieces, for a cycle that a whole one would not fit: of what s holds when it begins,
 * whatever is added to s meanwhile.
 */
typedef struct rx90_least_squares_solution {
    rx90_real X[rx90_PARAMETERS];   /* as rx90_least_squares_solve gives them; the last good ones */
    rx90_real std[rx90_PARAMETERS]; /* until a solution is complete */
    int missing; /* 0, or the number (from 1) of the first parameter that is not determined */
    int left;    /* pieces to go */
    rx90_real sigma;
    rx90_real squares[rx90_PARAMETERS];
    rx90_real R[rx90_PARAMETERS * (rx90_PARAMETERS + 1) / 2];
    rx90_real z[rx90_PARAMETERS];
} rx90_least_squares_solution;

/* Begin a solution: copies R and z. */
void rx90_least_squares_begin(rx90_least_squares_solution *found, const rx90_least_squares *s);

/* Go on by so many pieces, of rx90_PARAMETERS + 1 in all, each of at most rx90_PARAMETERS^2 / 2
 * products. Returns how many are left: 0 when `missing` is set, and where that is 0 X and std.
 */
int rx90_least_squares_proceed(rx90_least_squares_solution *found, int pieces);

#ifdef __cplusplus
}
#endif

#endif
