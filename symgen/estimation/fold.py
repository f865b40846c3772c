"""What equations leave behind for least squares: summaries that merge, in any order and grouping.

    equations of a chunk  ->  Summary (triangle R of [W y], rows)   -> merged by log and joint
    merged summaries      ->  weights, X                            (regression.log_weights)
    X, equations again    ->  sums of scores over `lag` rows        -> added up
    sums                  ->  covariance of X                       (regression.sandwich)

A log in memory is folded as one chunk. One that is read piece by piece gives the same numbers, as
its chunks bring the rows before their own with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.system import Equations, LinearSystem

FloatArray = NDArray[np.float64]
#: Bartlett's weights end after so many times the rows that overlap.
LAGS = 8
#: Rows for each column from which a triangle is made by Cholesky's factor, and what its diagonal,
#: of columns of unit norm, is at least for that.
_TALL, _DEPENDENT = 4, 1e-6
_TOGETHER = 8  # triangles that are merged at once


@dataclass(frozen=True, eq=False)
class Summary:
    """The equations of one joint of a log, or of some chunks of it.

    Attributes:
        factor: triangular R of [W y] = Q R, (k, p + 1) with k at most p + 1; without the log's
            weight.
        rows: number of equations.
        correlation: rows that share samples.
        weight: of the log's squared residuals beside those of others.
    """

    factor: FloatArray
    rows: int
    correlation: int = 1
    weight: float = 1.0

    @property
    def lag(self) -> int:
        """Rows over which scores are summed."""
        return max(1, min(LAGS * self.correlation, self.rows // 4))

    @property
    def square(self) -> float:
        """Sum of the squares of y."""
        return float(np.sum(self.factor[:, -1] ** 2))

    def rss(self, X: FloatArray) -> float:
        """Return the sum of the squares of y - W X."""
        return float(np.sum((self.factor[:, -1] - self.factor[:, :-1] @ X) ** 2))


def summarised(e: Equations) -> Summary:
    """Return the summary of equations."""
    factor = triangle(np.column_stack([e.W, e.y]))
    return Summary(factor, len(e.y), e.correlation, e.weight)


def summaries(system: LinearSystem) -> list[Summary]:
    """Return the summary of every log."""
    return [summarised(e) for e in system.logs]


def merged_tree(parts: Sequence[Summary]) -> Summary:
    """Merge the summaries of the chunks of one log: some neighbours at once, then what is left.

    A few triangles on top of each other are tall enough for Cholesky's factor.
    """
    while len(parts) > 1:
        parts = [_merged(parts[k : k + _TOGETHER]) for k in range(0, len(parts), _TOGETHER)]
    return parts[0]


def _merged(parts: Sequence[Summary]) -> Summary:
    factor = triangle(np.concatenate([s.factor for s in parts]))
    return replace(parts[0], factor=factor, rows=sum(s.rows for s in parts))


def triangle(rows: FloatArray) -> FloatArray:
    """Return the triangular factor R of rows = Q R.

    Many rows by Cholesky's factor of A'A, twice (Yamamoto, Nakatsukasa, Yanagisawa and Fukaya 2015,
    "Roundoff error analysis of the CholeskyQR2 algorithm"): as exact as Householder's reflections
    up to a condition number of some 1e7, above which these are taken, and several times as fast.
    """
    moved = _moved(rows)
    if len(moved) < rows.shape[1] <= len(rows):
        R = np.zeros((rows.shape[1],) * 2)
        R[np.ix_(moved, moved)] = triangle(rows[:, moved])
        return R
    found = _cholesky_qr(rows) if len(rows) > _TALL * rows.shape[1] else None
    return np.asarray(np.linalg.qr(rows, mode="r")) if found is None else found


def _cholesky_qr(A: FloatArray) -> FloatArray | None:
    """Return R by two rounds of Cholesky; None where the columns are too near to dependent."""
    products = A.T @ A
    scale = np.sqrt(np.diag(products))
    if not scale.all():  # columns so small that their squares are zero
        return None
    try:
        first = np.linalg.cholesky(products / np.outer(scale, scale)).T
        if np.diag(first).min(initial=1.0) < _DEPENDENT:
            return None
        Q = A @ (np.linalg.inv(first) / scale[:, None])
        return np.asarray(np.linalg.cholesky(Q.T @ Q).T @ (first * scale))
    except np.linalg.LinAlgError:
        return None


def scores(
    e: Equations, X: FloatArray, scale: FloatArray, weight: float | FloatArray
) -> FloatArray:
    """Return w^2 (y - W X) W / scale of every row, (K, p).

    Args:
        e: the equations.
        X: (p,) at which they are taken.
        scale: (p,) norms of the weighted columns.
        weight: of the rows: a number, or (K,).
    """
    out: FloatArray = e.W / scale
    out *= (np.square(weight) * (e.y - e.W @ X))[:, None]
    return out


def bartlett(scores: FloatArray, lag: int, lead: int = 0, ended: bool = True) -> FloatArray:
    """Return the long-run covariance sum of scores (K, p): overlapping sums over `lag` rows.

    Args:
        scores: of consecutive rows of a log.
        lag: rows of a sum.
        lead: rows before those that are this chunk's own: sums that end in them are another's.
        ended: whether the log ends with these rows.
    """
    moved, last = _moved(scores), lag + len(scores)
    total = np.zeros((last + (lag if ended else 0), len(moved)))
    np.cumsum(scores[:, moved], axis=0, out=total[lag:last])
    total[last:] = total[last - 1]
    sums = (total[lag:] - total[:-lag])[lead:]
    meat = np.zeros((scores.shape[1],) * 2)
    meat[np.ix_(moved, moved)] = sums.T @ sums / lag
    return meat


def _moved(rows: FloatArray) -> NDArray[np.intp]:
    """Return the columns that are not zero: of one joint, many are."""
    return np.flatnonzero(rows.any(axis=0))
