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
#ifndef twin_LEAST_SQUARES_H
#define twin_LEAST_SQUARES_H

#include "twin.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Initialise with twin_least_squares_init; read freely, never write.
 *
 * rss and count are double in a float package too: a float stops counting at 2^24, five hours at
 * 1 kHz. R and z grow with the number of rows as well; without forgetting, rounding in float costs
 * 1e-4 of X after 10^5 rows and 5e-3 after 10^6 (measured). For longer logs in float, begin a new
 * state every 10^5 rows or so and merge it into a total, or forget (0.9999 and less).
 */
typedef struct twin_least_squares {
    /* Upper triangle, row after row: R(i,j), i <= j, at i*p - i*(i-1)/2 + j - i; R(i,i) >= 0. */
    twin_real R[twin_PARAMETERS * (twin_PARAMETERS + 1) / 2];
    twin_real z[twin_PARAMETERS]; /* Q'y */
    twin_real forgetting;         /* weight of the past, per row */
    twin_real root;               /* its square root */
    double rss;                   /* weighted sum of squared residuals */
    double count;                 /* weighted number of rows */
} twin_least_squares;

/* Begin with no data. forgetting, in (0, 1]: a row that is k rows old weighs forgetting^k; 1 keeps
 * everything. Returns 0; nonzero (and s untouched) when forgetting is outside (0, 1].
 */
int twin_least_squares_init(twin_least_squares *s, twin_real forgetting);

/* Add the equation row'X = y, row of length twin_PARAMETERS. Returns 0; nonzero (and s untouched)
 * when a number is not finite.
 */
int twin_least_squares_update(twin_least_squares *s, const twin_real *row, twin_real y);

/* Add to s all that other holds, with the weights the rows have there and without ageing s: chunks
 * of a log, or months of logs, solved apart and merged give the solution of the whole. other is
 * read only, and may be s.
 */
void twin_least_squares_merge(twin_least_squares *s, const twin_least_squares *other);

/* Solve for X (twin_PARAMETERS values).
 *
 * std (same length): sigma times the norms of the rows of R^-1, sigma^2 = rss / (count - p). It
 * takes the residuals of the rows as independent. NAN when count <= p: the data then say nothing
 * about their own noise. rss: sum of squared residuals. std and rss may be NULL.
 *
 * Returns 0, or the number (from 1) of the first parameter that the data do not determine, that is
 * whose column of W depends on the columns before it; nothing is written then, so that X stays the
 * last good one.
 */
int twin_least_squares_solve(const twin_least_squares *s, twin_real *X, twin_real *std,
                             twin_real *rss);

#ifdef __cplusplus
}
#endif

#endif
