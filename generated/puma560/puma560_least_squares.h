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
#ifndef puma560_LEAST_SQUARES_H
#define puma560_LEAST_SQUARES_H

#include "puma560.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Initialise with puma560_least_squares_init; read freely, never write.
 *
 * Rounding errs by some 1e-16 of R a row, less than any measurement after 10^9 rows.
 */
typedef struct puma560_least_squares {
    /* Upper triangle, row after row: R(i,j), i <= j, at i*p - i*(i-1)/2 + j - i; R(i,i) >= 0. */
    puma560_real R[puma560_PARAMETERS * (puma560_PARAMETERS + 1) / 2];
    puma560_real z[puma560_PARAMETERS]; /* Q'y */
    puma560_real rss;   /* weighted sum of squared residuals */
    puma560_real count; /* weighted number of rows */
    puma560_real gathered[puma560_PARAMETERS * (puma560_PARAMETERS + 1) / 2]; /* B */
    puma560_real forgetting; /* weight of the past, per row */
    puma560_real kept;       /* forgetting^cycle */
    long cycle;           /* rows between the beginnings of two B */
    long rows;            /* since the last beginning */
    int determined;       /* nonzero: the rows determine X */
} puma560_least_squares;

/* Begin with no data. forgetting, in (0, 1]: see above; 1 keeps everything. Until X is determined
 * nothing is forgotten. Returns 0; nonzero (and s untouched) when forgetting is outside (0, 1].
 */
int puma560_least_squares_init(puma560_least_squares *s, puma560_real forgetting);

/* Add the equation row'X = y, row of length puma560_PARAMETERS. Returns 0; nonzero (and s untouched)
 * when a number is not finite.
 */
int puma560_least_squares_update(puma560_least_squares *s, const puma560_real *row, puma560_real y);

/* What the equation row'X = y would bring: innovation = y - row'X with the X so far, and leverage
 * h = row' (R'R)^-1 row, the part of all information on its combination of parameters that would be
 * its own, over that of the past. With sigma as below, the innovation has the variance
 * sigma^2 (1 + leverage). u (puma560_PARAMETERS values) solves R'u = row. Returns 0; nonzero (and
 * nothing but u written) while X is not determined.
 */
int puma560_least_squares_foresee(const puma560_least_squares *s, const puma560_real *row, puma560_real y,
                               puma560_real *u, puma560_real *innovation, puma560_real *leverage);

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

/* The diagonal of (R'R)^-1, puma560_PARAMETERS values: the variances of X over sigma^2. Returns what
 * puma560_least_squares_solve returns. */
int puma560_least_squares_variances(const puma560_least_squares *s, puma560_real *out);

/* Solve R x = x in place. */
void puma560_least_squares_back(const puma560_least_squares *s, puma560_real *x);

/* A solution in pieces, for a cycle that a whole one would not fit: of what s holds when it begins,
 * whatever is added to s meanwhile.
 */
typedef struct puma560_least_squares_solution {
    puma560_real X[puma560_PARAMETERS];   /* as solve gives them; the last good ones */
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
