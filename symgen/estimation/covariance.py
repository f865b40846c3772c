"""The covariance of an estimate, robust to correlated residuals and to what a model misses.

Residuals that are correlated in time are summed up over neighbours (Newey and West 1987). Sums over
few stretches are short, as the fit has followed them: white noise of the size that restricted
likelihood finds is the least (`misfit`). What a model misses comes back whenever the robot comes
by, so that no sum over neighbours tells it: that stands beside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from symgen.estimation.misfit import Products, covariances
from symgen.estimation.summary import Summary, nonzero_columns
from symgen.estimation.system import Equations
from symgen.estimation.values import FloatArray


def scores(e: Equations, X: FloatArray, weight: float = 1.0) -> FloatArray:
    """Return w^2 (y - W X) W of every row, (K, p), for rows of one weight w."""
    return np.asarray(weight**2 * (e.y - e.W @ X)[:, None] * e.W)


def bartlett(scores: FloatArray, lag: int, lead: int = 0, ended: bool = True) -> FloatArray:
    """Return the long-run covariance sum of scores (K, p): overlapping sums over `lag` rows.

    Args:
        scores: of consecutive rows of a log.
        lag: rows of a sum.
        lead: rows before those that are this segment's own: sums that end in them are another's.
        ended: whether the log ends with these rows.
    """
    moved, last = nonzero_columns(scores), lag + len(scores)
    total = np.zeros((last + (lag if ended else 0), len(moved)))
    np.cumsum(scores[:, moved], axis=0, out=total[lag:last])
    total[last:] = total[last - 1]
    sums = (total[lag:] - total[:-lag])[lead:]
    meat = np.zeros((scores.shape[1],) * 2)
    meat[np.ix_(moved, moved)] = sums.T @ sums / lag
    return meat


def summed_scores(scores: Iterable[FloatArray], parts: Sequence[Summary]) -> FloatArray:
    """Return the long-run covariance sum (p, p) of the scores of all logs, (K, p) each."""
    pairs = zip(scores, parts, strict=True)
    return np.asarray(np.sum([bartlett(s, part.lag) for s, part in pairs], axis=0))


def robust_covariance(
    X: FloatArray,
    bread: FloatArray,
    meat: FloatArray,
    parts: Sequence[Summary],
    weights: Iterable[float] | FloatArray,
    crosses: Sequence[FloatArray | None] = (),
) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of an estimate, (p, p) each: of noise, and of what the model misses.

    Args:
        X: the estimate, (p,).
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        meat: `summed_scores` of the s_i, (p, p).
        parts: the logs.
        weights: of their rows in that derivative, one a log.
        crosses: Z'[Z F] of their instruments Z and functions F; none without instruments.
    """
    each = zip(parts, weights, crosses or [None] * len(parts), strict=True)
    products = [Products.of_summary(s, w, cross) for s, w, cross in each]
    white, misfit = covariances(X, bread, products)
    return widened(sandwich(bread, meat, parts), white), misfit


def sandwich(bread: FloatArray, meat: FloatArray, parts: Sequence[Summary]) -> FloatArray:
    """Return the covariance (p, p), robust to correlated residuals (Newey and West 1987).

        cov = c f^2 A [sum over logs, lags k of b_k s_i s_(i+k)'] A',    c = m/(m - p)

    with Bartlett weights b_k over eight times the rows that overlap, m windows that do not, and f
    the critical value at 5 % of Kiefer and Vogelsang (2005) over that of the normal law: the sum
    itself is uncertain where few independent stretches are summed.

    Args:
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        meat: what is in the brackets, (p, p).
        parts: the logs, of which rows and lags count.
    """
    stretches = sum(part.rows / part.lag for part in parts)
    m = sum(part.independent for part in parts)
    b = 1 / max(stretches, 1.0)
    wider = 1 + (2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    factor = wider**2 * m / max(m - len(bread), 1.0)
    return factor * (bread @ meat @ bread.T)


def widened(covariance: FloatArray, least: FloatArray) -> FloatArray:
    """Return a covariance whose deviations are at least those of another, (p, p) both."""
    own, other = (np.maximum(np.diag(C), 1e-300) for C in (covariance, least))
    wider = np.sqrt(np.maximum(other / own, 1.0))
    return np.asarray(covariance * np.outer(wider, wider))
