"""The covariance of an estimate, robust to correlated residuals and to model misfit.

Residuals are correlated in time. The covariance therefore sums scores over neighbouring rows (Newey
and West 1987). With few independent stretches these sums are too small, because the fit has
followed the data. The variance is therefore at least that of white noise, estimated by restricted
likelihood (`misfit`). Misfit recurs whenever the robot returns to a state, so no sum over
neighbouring rows contains it. Its covariance is a separate term.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from symgen.estimation.misfit import Products, covariances
from symgen.estimation.summary import Summary, nonzero_columns
from symgen.estimation.system import Equations
from symgen.estimation.values import FloatArray
from symgen.policy import BEYOND

_SMALLEST = 1e-30  # variance, relative to the wanted one, that counts as zero


def scores(e: Equations, X: FloatArray, weight: float = 1.0) -> FloatArray:
    """Return the scores w^2 (y - W X) W, (K, p), of rows with one weight w."""
    error = weight**2 * e.residual(X)
    return error[:, None] * e.W


def bartlett(scores: FloatArray, lag: int) -> FloatArray:
    """Return the long-run covariance sum of the scores (K, p) of a log, over `lag` rows."""
    moved, last = nonzero_columns(scores), lag + len(scores)
    total = np.zeros((last + lag, len(moved)))
    np.cumsum(scores[:, moved], axis=0, out=total[lag:last])
    total[last:] = total[last - 1]
    sums = total[lag:] - total[:-lag]
    meat = np.zeros((scores.shape[1],) * 2)
    square = np.ix_(moved, moved)
    meat[square] = sums.T @ sums / lag
    return meat


def long_run(parts: Iterable[tuple[FloatArray, int, bool]]) -> Iterator[FloatArray]:
    """Yield the long-run covariance sums (p, p) of scores.

    Args:
        parts: scores (K, p), number of rows to sum over, and whether their errors are correlated
            with those of the part before, of the same samples. The scores of a sample are then
            added first.
    """
    total, lag = np.zeros((0, 0)), 1
    for scores, rows, shared in parts:
        if shared and total.shape == scores.shape:
            total = total + scores
            continue
        if total.size:
            yield bartlett(total, lag)
        total, lag = scores, rows
    if total.size:
        yield bartlett(total, lag)


def summed_scores(scores: Iterable[FloatArray], parts: Sequence[Summary]) -> FloatArray:
    """Return the long-run covariance sum (p, p) of the scores of all logs, (K, p) each."""
    pairs = zip(scores, parts, strict=True)
    sums = long_run((s, part.lag, part.shared) for s, part in pairs)
    return np.asarray(np.sum([*sums], axis=0))


def robust_covariance(
    X: FloatArray,
    bread: FloatArray,
    meat: FloatArray,
    parts: Sequence[Summary],
    weights: Iterable[float] | FloatArray,
    crosses: Sequence[FloatArray | None] = (),
) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of an estimate from noise and from model misfit, (p, p) each.

    Args:
        X: the estimate, (p,).
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        meat: `summed_scores` of the s_i, (p, p).
        parts: the logs.
        weights: weights of the rows in that derivative, one a log.
        crosses: Z'[Z F] of the instruments Z and functions F of the logs; None without instruments.
    """
    known = crosses or [None] * len(parts)
    products = []
    for s, w, cross in zip(parts, weights, known, strict=True):
        of_part = Products.of_summary(s, w, cross)
        products.append((s.joint, of_part))
    white, misfit = covariances(X, bread, products)
    return widened(sandwich(bread, meat, parts), white), misfit


def sandwich(bread: FloatArray, meat: FloatArray, parts: Sequence[Summary]) -> FloatArray:
    """Return the covariance (p, p), robust to correlated residuals (Newey and West 1987).

        cov = c f^2 A [sum over logs, lags k of b_k s_i s_(i+k)'] A',    c = m/(m - p)

    with Bartlett weights b_k over eight times the number of overlapping rows, and m windows that do
    not overlap. f is the 5 % critical value of Kiefer and Vogelsang (2005) over that of the normal
    distribution. It accounts for the uncertainty of the sum itself when there are few independent
    stretches.

    Args:
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        meat: the bracketed sum, (p, p).
        parts: the logs, for their numbers of rows and lags.
    """
    stretches = sum(part.rows / part.lag for part in parts)
    m = sum(part.independent for part in parts)
    b = 1 / max(stretches, 1.0)
    wider = 1 + (2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    factor = wider**2 * m / max(m - len(bread), 1.0)
    return factor * (bread @ meat @ bread.T)


def is_chance(values: FloatArray, covariance: FloatArray) -> bool:
    """Whether values (k,) together are as near to zero as one within BEYOND deviations.

    Wald's test of x' C^-1 x, with the covariance C (k, k).
    """
    from scipy.stats import chi2

    statistic = float(values @ np.linalg.pinv(covariance, hermitian=True) @ values)
    return bool(chi2.sf(statistic, len(values)) > math.erfc(BEYOND / math.sqrt(2)))


def widened(covariance: FloatArray, least: FloatArray) -> FloatArray:
    """Return a covariance with standard deviations at least those of `least`, (p, p) both."""
    smallest = np.maximum(np.diag(least), 1e-300)
    zero = np.maximum(_SMALLEST * smallest, 1e-300)
    variances = np.maximum(np.diag(covariance), zero)
    wider = np.sqrt(np.maximum(smallest / variances, 1.0))
    return np.asarray(covariance * np.outer(wider, wider))
