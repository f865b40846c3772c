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
#ifndef panda_LEAST_SQUARES_H
#define panda_LEAST_SQUARES_H

#include "panda.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Initialise with panda_least_squares_init; read freely, never write.
 *
 * Rounding errors do not grow with the number of rows, with forgetting or without: what adds up
 * over rows is compensated, at twice the memory of R and z, and rss and count are double in a float
 * package too (a float stops counting at 2^24). What remains is as if each row had been rounded
 * once more. Measured in float, X against a solution in double of the same rows: 2e-7 to 6e-7 after
 * 10^6 and after 10^7 rows of 12 parameters whose columns, scaled to one norm, have the condition
 * number 8; it grows with that number.
 */
typedef struct panda_least_squares {
    /* Upper triangle, row after row: R(i,j), i <= j, at i*p - i*(i-1)/2 + j - i; R(i,i) >= 0. */
    panda_real R[panda_PARAMETERS * (panda_PARAMETERS + 1) / 2];
    panda_real z[panda_PARAMETERS]; /* Q'y */
    /* What rounding has put into R and z too much: they are R - R_carry and z - z_carry. */
    panda_real R_carry[panda_PARAMETERS * (panda_PARAMETERS + 1) / 2];
    panda_real z_carry[panda_PARAMETERS];
    panda_real forgetting; /* weight of the past, per row */
    panda_real fade;       /* 1 - its square root */
    double rss;                   /* weighted sum of squared residuals */
    double count;                 /* weighted number of rows */
} panda_least_squares;

/* Begin with no data. forgetting, in (0, 1]: a row that is k rows old weighs forgetting^k; 1 keeps
 * everything. Returns 0; nonzero (and s untouched) when forgetting is outside (0, 1].
 */
int panda_least_squares_init(panda_least_squares *s, panda_real forgetting);

/* Add the equation row'X = y, row of length panda_PARAMETERS. Returns 0; nonzero (and s untouched)
 * when a number is not finite.
 */
int panda_least_squares_update(panda_least_squares *s, const panda_real *row, panda_real y);

/* What the equation row'X = y would bring: innovation = y - row'X with the X so far, and leverage =
 * row' (R'R)^-1 row, the part of all information on its combination of parameters that would be its
 * own, over that of the past. With sigma as below, the innovation has the variance
 * sigma^2 (1 + leverage). Returns 0; nonzero (and nothing written) while X is not determined.
 */
int panda_least_squares_foresee(const panda_least_squares *s, const panda_real *row, panda_real y,
                               panda_real *innovation, panda_real *leverage);

/* Add to s all that other holds, with the weights the rows have there and without ageing s: chunks
 * of a log, or months of logs, solved apart and merged give the solution of the whole. other is
 * read only, and may be s.
 */
void panda_least_squares_merge(panda_least_squares *s, const panda_least_squares *other);

/* Solve for X (panda_PARAMETERS values).
 *
 * std (same length): sigma times the norms of the rows of R^-1, sigma^2 = rss / (count - p). It
 * takes the residuals of the rows as independent. NAN when count <= p: the data then say nothing
 * about their own noise. rss: sum of squared residuals. std and rss may be NULL.
 *
 * Returns 0, or the number (from 1) of the first parameter that the data do not determine, that is
 * whose column of W depends on the columns before it; nothing is written then, so that X stays the
 * last good one.
 */
int panda_least_squares_solve(const panda_least_squares *s, panda_real *X, panda_real *std,
                             panda_real *rss);

/* A solution in pieces, for a cycle that a whole one would not fit: of what s holds when it begins,
 * whatever is added to s meanwhile.
 */
typedef struct panda_least_squares_solution {
    panda_real X[panda_PARAMETERS];   /* as panda_least_squares_solve gives them; the last good ones */
    panda_real std[panda_PARAMETERS]; /* until a solution is complete */
    int missing; /* 0, or the number (from 1) of the first parameter that is not determined */
    int left;    /* pieces to go */
    panda_real sigma;
    panda_real squares[panda_PARAMETERS];
    panda_real R[panda_PARAMETERS * (panda_PARAMETERS + 1) / 2];
    panda_real z[panda_PARAMETERS];
} panda_least_squares_solution;

/* Begin a solution: copies R and z. */
void panda_least_squares_begin(panda_least_squares_solution *found, const panda_least_squares *s);

/* Go on by so many pieces, of panda_PARAMETERS + 1 in all, each of at most panda_PARAMETERS^2 / 2
 * products. Returns how many are left: 0 when `missing` is set, and where that is 0 X and std.
 */
int panda_least_squares_proceed(panda_least_squares_solution *found, int pieces);

#ifdef __cplusplus
}
#endif

#endif
