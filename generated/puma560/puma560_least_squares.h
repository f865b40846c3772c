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
#ifndef puma560_LEAST_SQUARES_H
#define puma560_LEAST_SQUARES_H

#include "puma560.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Initialise with puma560_least_squares_init; read freely, never write.
 *
 * Rounding errors do not grow with the number of rows, with forgetting or without: what adds up
 * over rows is compensated, at twice the memory of R and z, and rss and count are double in a float
 * package too (a float stops counting at 2^24). What remains is as if each row had been rounded
 * once more. Measured in float, X against a solution in double of the same rows: 2e-7 to 6e-7 after
 * 10^6 and after 10^7 rows of 12 parameters whose columns, scaled to one norm, have the condition
 * number 8; it grows with that number.
 */
typedef struct puma560_least_squares {
    /* Upper triangle, row after row: R(i,j), i <= j, at i*p - i*(i-1)/2 + j - i; R(i,i) >= 0. */
    puma560_real R[puma560_PARAMETERS * (puma560_PARAMETERS + 1) / 2];
    puma560_real z[puma560_PARAMETERS]; /* Q'y */
    /* What rounding has put into R and z too much: they are R - R_carry and z - z_carry. */
    puma560_real R_carry[puma560_PARAMETERS * (puma560_PARAMETERS + 1) / 2];
    puma560_real z_carry[puma560_PARAMETERS];
    puma560_real forgetting; /* weight of the past, per row */
    puma560_real fade;       /* 1 - its square root */
    double rss;                   /* weighted sum of squared residuals */
    double count;                 /* weighted number of rows */
} puma560_least_squares;

/* Begin with no data. forgetting, in (0, 1]: a row that is k rows old weighs forgetting^k; 1 keeps
 * everything. Returns 0; nonzero (and s untouched) when forgetting is outside (0, 1].
 */
int puma560_least_squares_init(puma560_least_squares *s, puma560_real forgetting);

/* Add the equation row'X = y, row of length puma560_PARAMETERS. Returns 0; nonzero (and s untouched)
 * when a number is not finite.
 */
int puma560_least_squares_update(puma560_least_squares *s, const puma560_real *row, puma560_real y);

/* What the equation row'X = y would bring: innovation = y - row'X with the X so far, and leverage =
 * row' (R'R)^-1 row, the part of all information on its combination of parameters that would be its
 * own, over that of the past. With sigma as below, the innovation has the variance
 * sigma^2 (1 + leverage). Returns 0; nonzero (and nothing written) while X is not determined.
 */
int puma560_least_squares_foresee(const puma560_least_squares *s, const puma560_real *row, puma560_real y,
                               puma560_real *innovation, puma560_real *leverage);

/* Add to s all that other holds, with the weights the rows have there and without ageing s: chunks
 * of a log, or months of logs, solved apart and merged give the solution of the whole. other is
 * read only, and may be s.
 */
void puma560_least_squares_merge(puma560_least_squares *s, const puma560_least_squares *other);

/* Solve for X (puma560_PARAMETERS values).
 *
 * std (same length): sigma times the norms of the rows of R^-1, sigma^2 = rss / (count - p). It
 * takes the residuals of the rows as independent. NAN when count <= p: the data then say nothing
 * about their own noise. rss: sum of squared residuals. std and rss may be NULL.
 *
 * Returns 0, or the number (from 1) of the first parameter that the data do not determine, that is
 * whose column of W depends on the columns before it; nothing is written then, so that X stays the
 * last good one.
 */
int puma560_least_squares_solve(const puma560_least_squares *s, puma560_real *X, puma560_real *std,
                             puma560_real *rss);

/* A solution in pieces, for a cycle that a whole one would not fit: of what s holds when it begins,
 * whatever is added to s meanwhile.
 */
typedef struct puma560_least_squares_solution {
    puma560_real X[puma560_PARAMETERS];   /* as puma560_least_squares_solve gives them; the last good ones */
    puma560_real std[puma560_PARAMETERS]; /* until a solution is complete */
    int missing; /* 0, or the number (from 1) of the first parameter that is not determined */
    int left;    /* pieces to go */
    puma560_real sigma;
    puma560_real squares[puma560_PARAMETERS];
    puma560_real R[puma560_PARAMETERS * (puma560_PARAMETERS + 1) / 2];
    puma560_real z[puma560_PARAMETERS];
} puma560_least_squares_solution;

/* Begin a solution: copies R and z. */
void puma560_least_squares_begin(puma560_least_squares_solution *found, const puma560_least_squares *s);

/* Go on by so many pieces, of puma560_PARAMETERS + 1 in all, each of at most puma560_PARAMETERS^2 / 2
 * products. Returns how many are left: 0 when `missing` is set, and where that is 0 X and std.
 */
int puma560_least_squares_proceed(puma560_least_squares_solution *found, int pieces);

#ifdef __cplusplus
}
#endif

#endif
