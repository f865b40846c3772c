"""What every estimator shares: a solution, triangular factors, and robust standard errors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from symgen.errors import IdentificationError
from symgen.estimation.fold import Summary, bartlett, scores, summaries, triangle
from symgen.estimation.system import LinearSystem
from symgen.estimation.values import Contrast, Endogeneity

FloatArray = NDArray[np.float64]
#: Singular values of the scaled regressor under this share of the largest are zero.
SINGULAR = 1e-8
_AT_ONCE = 64  # factors that are merged together
_FULL = 0.99  # leverage of a row that alone determines a parameter


@dataclass(frozen=True, eq=False)
class Solution:
    """What an estimator gives.

    Attributes:
        X: the parameters, (p,), in the units of the model.
        covariance: of X, (p, p), robust to residuals that are correlated in time.
        condition_number: of the regressor with its columns scaled to unit norm.
        weights: one a log, of its residuals (1/sigma, times the root of one given).
        notes: what was done, in words.
        endogeneity: tests of whether least squares is biased.
        comparison: the same parameters by other methods.
    """

    X: FloatArray
    covariance: FloatArray
    condition_number: float
    weights: tuple[float, ...]
    notes: tuple[str, ...] = ()
    endogeneity: tuple[Endogeneity, ...] = ()
    comparison: tuple[Contrast, ...] = ()


def require_rows(system: LinearSystem) -> None:
    """Refuse a system with no more equations than parameters.

    Raises:
        IdentificationError: it has too few.
    """
    rows, p = sum(len(e.y) for e in system.logs), len(system.names)
    if rows <= p:
        raise IdentificationError(f"{rows} equations for {p} parameters: the log is too short")


def factors(system: LinearSystem, weights: Sequence[FloatArray] | None = None) -> list[FloatArray]:
    """Return the triangular factor of [W y] of every log, (p + 1, p + 1) or shorter.

    Args:
        system: the equations.
        weights: of the rows, (K,) a log.
    """
    if weights is None:
        return [s.factor for s in summaries(system)]
    rows = [np.column_stack([e.W, e.y]) for e in system.logs]
    rows = [w[:, None] * r for w, r in zip(weights, rows, strict=True)]
    return [triangle(r) for r in rows]


def merged(
    parts: Iterable[FloatArray], weights: FloatArray, names: tuple[str, ...]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Merge weighted factors of [W y] and solve.

    Args:
        parts: rows of [W y], or their factors, each (k, p + 1).
        weights: one a part.
        names: of the p columns of W.

    Returns:
        X (p,), the norms of the columns (p,), and the triangular factor R (p, p) of the scaled W.

    Raises:
        IdentificationError: the data do not determine the parameters; the message says which.
    """
    p = len(names)
    whole: FloatArray = np.zeros((0, p + 1))
    weighed = (w * f for w, f in zip(weights, parts, strict=True))
    while group := list(islice(weighed, _AT_ONCE)):
        whole = triangle(np.concatenate([whole, *group]))
    scale = column_norms(whole[:, :p])
    R = whole[:p, :p] / scale
    lost = undetermined(R, names)
    if lost:
        raise IdentificationError(lost)
    X: FloatArray = np.linalg.solve(R, whole[:p, p]) / scale
    return X, scale, R


def log_weights(
    parts: Sequence[Summary], names: tuple[str, ...], passes: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Weigh each log by the standard deviation of its own residual, iterated; and as it is given.

    Args:
        parts: the summaries of the logs; gone through once a pass.
        names: of the columns.
        passes: how often the weights are taken anew; 0 for equal weights.

    Returns:
        The weights (1/sigma, one a log, times the root of the one it was given), and what `merged`
        gives with them.
    """
    own = np.sqrt([s.weight for s in parts])
    weights = own
    X, scale, R = merged((s.factor for s in parts), weights, names)
    for _ in range(passes if len(parts) > 1 else 0):
        sigma = np.sqrt([s.rss(X) / s.rows for s in parts])
        weights = own * inverse_deviation(sigma)
        X, scale, R = merged((s.factor for s in parts), weights, names)
    return weights, X, scale, R


def inverse_deviation(sigma: FloatArray) -> FloatArray:
    """Return 1/sigma, where no sigma counts as less than a millionth of the largest."""
    out: FloatArray = 1 / np.maximum(sigma, max(1e-6 * sigma.max(), 1e-300))
    return out


def robust_covariance(
    system: LinearSystem, bread: FloatArray, scores: Sequence[FloatArray]
) -> FloatArray:
    """Return the sandwich covariance (p, p), robust to correlated residuals, see `sandwich`.

    Args:
        system: whose logs the scores belong to.
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        scores: s_i, (K, p) a log.
    """
    counts = [Summary(e.W[:0], len(e.y), e.correlation) for e in system.logs]
    meat = np.zeros_like(bread)
    for s, count in zip(scores, counts, strict=True):
        meat += bartlett(s, count.lag)
    return sandwich(bread, meat, counts)


def sandwich(bread: FloatArray, meat: FloatArray, parts: Iterable[Summary]) -> FloatArray:
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
    stretches = m = 0.0
    for part in parts:
        stretches += part.rows / part.lag
        m += part.rows / max(part.correlation, 1)
    b = 1 / max(stretches, 1.0)
    wider = 1 + (2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    factor = wider**2 * m / max(m - len(bread), 1.0)
    out: FloatArray = factor * (bread @ meat @ bread.T)
    return out


def least_squares_solution(
    system: LinearSystem,
    X: FloatArray,
    scale: FloatArray,
    R: FloatArray,
    weights: Sequence[float | FloatArray],
) -> Solution:
    """Return the solution of weighted least squares with its precision.

    Args:
        system: the equations.
        X: the parameters.
        scale: norms of the weighted columns.
        R: triangular factor of the weighted, scaled regressor.
        weights: of each log: a number, or one a row.
    """
    inverse = np.linalg.inv(R)
    rows = [scores(e, X, scale, w) for w, e in zip(weights, system.logs, strict=True)]
    rows = [
        s if e.correlation else s / (1 - _leverage(w, e.W / scale @ inverse))[:, None]
        for s, w, e in zip(rows, weights, system.logs, strict=True)
    ]
    covariance = robust_covariance(system, inverse @ inverse.T, rows) / np.outer(scale, scale)
    return Solution(X, covariance, condition(R), tuple(float(np.mean(w)) for w in weights))


def _leverage(weight: float | FloatArray, rows: FloatArray) -> FloatArray:
    """Return h of weighted rows W R^-1: how much of its own residual each one takes away.

    Rows that are no series are few, and scores over 1 - h make up for it (MacKinnon and White
    1985, HC3).
    """
    h = np.square(weight) * np.einsum("ka,ka->k", rows, rows)
    return np.asarray(np.minimum(h, _FULL))


def weighed(system: LinearSystem, weights: Sequence[FloatArray]) -> Solution:
    """Return the least-squares estimate with a weight for every row.

    Args:
        system: the equations.
        weights: of the residuals, (K,) a log.

    Raises:
        IdentificationError: the data do not determine the parameters.
    """
    require_rows(system)
    parts = factors(system, weights)
    X, scale, R = merged(parts, np.ones(len(parts)), system.names)
    return least_squares_solution(system, X, scale, R, weights)


def condition(R: FloatArray) -> float:
    """Return the condition number of a triangular factor."""
    singular = np.linalg.svd(R, compute_uv=False)
    return float(singular[0] / singular[-1])


def column_norms(R: FloatArray) -> FloatArray:
    """Return the norms of the columns; 1 for a column that is zero."""
    norms: FloatArray = np.linalg.norm(R, axis=0)
    return np.where(norms > 0, norms, 1.0)


def undetermined(R: FloatArray, names: tuple[str, ...]) -> str:
    """Return in words which parameters a scaled regressor does not determine, or ''.

    Args:
        R: triangular factor of the regressor with columns of unit norm, (p, p).
        names: of its columns.
    """
    _, singular, right = np.linalg.svd(R)
    null = right[singular <= SINGULAR * singular[0]]
    if len(null) == 0:
        return ""
    share = np.sqrt((null**2).sum(axis=0))
    involved = [name for name, s in zip(names, share, strict=True) if s > 1e-3]
    what = ", ".join(involved[:8]) + (", ..." if len(involved) > 8 else "")
    return (
        f"the information matrix is singular: these data do not determine {what} "
        f"({len(null)} of {len(names)} combinations of parameters have no effect on them)"
    )
