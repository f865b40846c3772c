"""Least squares on a linear system: values, precision, condition, and what cannot be determined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.errors import IdentificationError
from symgen.identification.system import LinearSystem

FloatArray = NDArray[np.float64]
METHODS = ("ols", "wls")
#: Singular values of the scaled regressor under this share of the largest are zero.
SINGULAR = 1e-8
_WLS_PASSES = 3
_LAGS = 4


@dataclass(frozen=True, eq=False)
class Solution:
    """A least-squares solution: X (p,), its covariance (p, p), and the condition of the regressor.

    `weights` has one weight a log, of its residuals (1/sigma, times the root of one given).
    """

    X: FloatArray
    covariance: FloatArray
    condition_number: float
    weights: tuple[float, ...]


def solve(system: LinearSystem, method: str = "wls") -> Solution:
    """Solve y = W X by QR on columns scaled to unit norm.

    Each log is reduced once to the triangular factor of [W y]; all else works on the factors.
    "ols" weighs all equations alike; "wls" weighs each log by the standard deviation of its own
    residual (iterated), which for one log is the same; both times the weight that a log was given.
    The covariance is robust to correlated
    residuals (Newey and West 1987, Bartlett weights b_k over four times the rows that overlap):

        cov = c (W'W)^-1 [sum over logs, lags k of b_k s_i s_(i+k)'] (W'W)^-1,    s_i = w_i e_i

    with c = m/(m - p) for m windows that do not overlap.

    Args:
        system: the equations, log by log.
        method: "ols" or "wls".

    Raises:
        IdentificationError: the data do not determine the parameters; the message says which.
    """
    if method not in METHODS:
        raise IdentificationError(f"method {method!r}; accepted: {', '.join(METHODS)}")
    p = len(system.names)
    rows = [len(e.y) for e in system.logs]
    if sum(rows) <= p:
        raise IdentificationError(f"{sum(rows)} equations for {p} parameters: the log is too short")
    factors = [triangle(np.column_stack([e.W, e.y])) for e in system.logs]
    own = np.sqrt([e.weight for e in system.logs])
    weights = own
    X, scale, R = _from_factors(factors, weights, system.names)
    if method == "wls" and len(factors) > 1:
        for _ in range(_WLS_PASSES):
            rss = [float(np.sum((f[:, -1] - f[:, :-1] @ X) ** 2)) for f in factors]
            sigma = np.sqrt(np.array(rss) / np.array(rows))
            weights = own / np.maximum(sigma, max(1e-6 * sigma.max(), 1e-300))
            X, scale, R = _from_factors(factors, weights, system.names)
    return _with_precision(system, X, scale, R, weights)


def precision(system: LinearSystem, X: FloatArray) -> Solution:
    """Return the precision of an estimate X that came from elsewhere, all equations alike."""
    factors = [triangle(np.column_stack([e.W, e.y])) for e in system.logs]
    weights = np.ones(len(factors))
    _, scale, R = _from_factors(factors, weights, system.names)
    return _with_precision(system, X, scale, R, weights)


def _with_precision(
    system: LinearSystem, X: FloatArray, scale: FloatArray, R: FloatArray, weights: FloatArray
) -> Solution:
    inverse = np.linalg.inv(R)
    bread = inverse @ inverse.T
    meat = np.zeros_like(bread)
    for w, e in zip(weights, system.logs, strict=True):
        scores = (w * w * (e.y - e.W @ X))[:, None] * (e.W / scale)
        meat += _bartlett(scores, _LAGS * e.correlation)
    separate = sum(len(e.y) / e.correlation for e in system.logs)
    small_sample = separate / max(separate - len(X), 1.0)
    covariance = small_sample * (bread @ meat @ bread) / np.outer(scale, scale)
    singular = np.linalg.svd(R, compute_uv=False)
    return Solution(X, covariance, float(singular[0] / singular[-1]), tuple(map(float, weights)))


def _from_factors(
    factors: Sequence[FloatArray], weights: FloatArray, names: tuple[str, ...]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Merge weighted factors of [W y]; return X, the norms of the columns, and the scaled R."""
    p = len(names)
    merged = triangle(np.concatenate([w * f for w, f in zip(weights, factors, strict=True)]))
    scale = column_norms(merged[:, :p])
    R = merged[:p, :p] / scale
    lost = undetermined(R, names)
    if lost:
        raise IdentificationError(lost)
    X: FloatArray = np.linalg.solve(R, merged[:p, p]) / scale
    return X, scale, R


def triangle(rows: FloatArray) -> FloatArray:
    """Return the triangular factor R of rows = Q R."""
    R: FloatArray = np.asarray(np.linalg.qr(rows, mode="r"))
    return R


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


def _bartlett(scores: FloatArray, lag: int) -> FloatArray:
    """Return the long-run covariance sum of scores (K, p): overlapping sums over `lag` rows."""
    lag = max(1, min(lag, len(scores) // 4))
    zeros = np.zeros((lag, scores.shape[1]))
    total = np.cumsum(np.concatenate([zeros, scores, zeros]), axis=0)
    sums = total[lag:] - total[:-lag]
    meat: FloatArray = sums.T @ sums / lag
    return meat
