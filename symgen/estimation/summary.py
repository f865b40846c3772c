"""Summaries of equations for least squares: triangles by log and joint, products by block of time.

    equations of a segment -> Summary (triangle R of [W y], rows)   -> merged by log and joint
    merged summaries      ->  weights, X                            (solve.log_weights)
    X, equations again    ->  sums of scores over `lag` rows        -> added up
    sums                  ->  covariance of X                       (covariance.sandwich)

A log in memory is summarised at once. A log that is read segment by segment gives the same numbers,
because each segment contains the rows before it that its equations need.

A block holds the products [W y]'[W y] of a stretch of time. Models and bands are compared on
blocks. A fit without some blocks, its error on these, and the scatter of estimates from block to
block follow from the products alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.data.raw import Places
from symgen.errors import IdentificationError
from symgen.estimation.system import Equations, Rows
from symgen.estimation.values import FloatArray

#: Bartlett's weights end after this multiple of the number of overlapping rows.
LAGS = 8
#: Rows per column from which Cholesky's factor gives the triangle, and the smallest diagonal of a
#: triangle with columns of unit norm for which it does.
_TALL, _DEPENDENT = 4, 1e-6
#: Blocks of time in all training logs, and contiguous folds of blocks.
BLOCKS, FOLDS = 20, 5
_A_FOLD = BLOCKS // FOLDS
_ROUNDS = 2
_RANK = 1e-13  # of an eigenvalue of the scaled matrix: 3e-7 of a singular value


@dataclass(frozen=True, eq=False)
class Summary:
    """The equations of one joint, in a log or in some of its segments.

    Attributes:
        factor: triangular R of [W y] = Q R, (k, p + 1) with k at most p + 1.
        rows: number of equations.
        correlation: rows that share samples.
        joint: position of the joint, None for energy.
        features: F'[W F y] of random functions F of the state, (m, p + m + 1); None without any.
        shared: as in `Equations`.
    """

    factor: FloatArray
    rows: int
    correlation: int = 1
    joint: int | None = None
    features: FloatArray | None = None
    shared: bool = False

    @property
    def lag(self) -> int:
        """Number of rows over which scores are summed."""
        return max(1, min(LAGS * self.correlation, self.rows // 4))

    @property
    def independent(self) -> float:
        """Approximate number of rows that share no samples."""
        return self.rows / max(self.correlation, 1)

    @property
    def square(self) -> float:
        """Sum of the squares of y."""
        return float(np.sum(self.factor[:, -1] ** 2))

    def of_scaled(self, scale: float) -> Summary:
        """Return the summary of the equations for another unit of y."""
        factor = self.factor.copy()
        factor[:, -1] *= scale
        return replace(self, factor=factor)

    def rss(self, X: FloatArray) -> float:
        """Return the sum of the squares of y - W X."""
        W, y = self.factor[:, :-1], self.factor[:, -1]
        return float(np.sum((y - W @ X) ** 2))


def summarise(e: Equations) -> Summary:
    """Return the summary of equations."""
    F, features = e.features, None
    if F is not None:
        features = F.T @ np.column_stack([e.W, F, e.y])
    factor = triangle(np.column_stack([e.W, e.y]))
    return Summary(factor, e.rows, e.correlation, e.joint, features, e.shared)


def summaries(equations: Iterable[Equations]) -> list[Summary]:
    """Return the summary of the equations of each log and joint."""
    return [summarise(e) for e in equations]


def merge_summaries(parts: Sequence[Summary]) -> Summary:
    """Merge the summaries of the segments of one log."""
    factor = triangle(np.concatenate([s.factor for s in parts]))
    products = [s.features for s in parts if s.features is not None]
    features = np.sum(products, axis=0) if products else None
    rows = sum(s.rows for s in parts)
    return replace(parts[0], factor=factor, rows=rows, features=features)


def triangle(rows: FloatArray) -> FloatArray:
    """Return the triangular factor R of rows = Q R.

    For many rows, R comes from Cholesky's factor of A'A, applied twice (Yamamoto, Nakatsukasa,
    Yanagisawa and Fukaya 2015, "Roundoff error analysis of the CholeskyQR2 algorithm"). This is
    several times as fast as Householder's reflections, and as exact up to a condition number of
    about 1e7. Above that, Householder's reflections are used.
    """
    moved = nonzero_columns(rows)
    if len(moved) < rows.shape[1] <= len(rows):
        R = np.zeros((rows.shape[1],) * 2)
        R[np.ix_(moved, moved)] = triangle(rows[:, moved])
        return R
    factor = _cholesky_qr(rows) if len(rows) > _TALL * rows.shape[1] else None
    return np.asarray(np.linalg.qr(rows, mode="r")) if factor is None else factor


def _cholesky_qr(A: FloatArray) -> FloatArray | None:
    """Return R by two rounds of Cholesky; None if the columns are nearly dependent."""
    products = A.T @ A
    scale = np.sqrt(np.diag(products))
    if not scale.all():  # a column so small that its squares are zero
        return None
    try:
        first = np.linalg.cholesky(products / np.outer(scale, scale)).T
        if np.diag(first).min(initial=1.0) < _DEPENDENT:
            return None
        Q = A @ (np.linalg.inv(first) / scale[:, None])
        second = np.linalg.cholesky(Q.T @ Q).T
        return np.asarray(second @ (first * scale))
    except np.linalg.LinAlgError:
        return None


def nonzero_columns(rows: FloatArray) -> Places:
    """Return the columns that are not zero: many are zero for one joint."""
    return np.flatnonzero(rows.any(axis=0))


@dataclass(frozen=True, eq=False)
class Blocks:
    """Summaries of the equations of some logs.

    Attributes:
        grams: (B, m, p + 1, p + 1), [W y]'[W y] of every block and joint (m is 1 for energy).
        rows: (B, m) number of equations.
    """

    grams: FloatArray
    rows: FloatArray

    @property
    def size(self) -> FloatArray:
        """(m,) RMS of y."""
        squares = self.grams[:, :, -1, -1].sum(axis=0)
        count = np.maximum(self.rows.sum(axis=0), 1.0)
        rms = bounded_deviation(np.sqrt(squares / count), squares)
        return np.where(rms > 0, rms, 1.0)

    def fit(self, without: Sequence[int] | Places = ()) -> FloatArray:
        """Solve weighted least squares without some blocks; joints are weighted by their residual.

        Returns:
            X (p,); the shortest solution in units of the columns if the rows do not determine it.
        """
        others = np.asarray(without, dtype=int)
        grams = np.delete(self.grams, others, axis=0).sum(axis=0)
        rows = np.delete(self.rows, others, axis=0).sum(axis=0)
        variance = least = self.size**2
        squares = grams[:, -1, -1]
        X: FloatArray = np.zeros(grams.shape[-1] - 1)
        for _ in range(_ROUNDS):
            X = solve_gram(np.einsum("j,jab->ab", 1 / variance, grams))
            residual = residual_squares(grams, X) / np.maximum(rows, 1.0)
            variance = bounded_deviation(np.maximum(residual, 1e-12 * least), squares)
        return X

    def errors(self, blocks: Sequence[int], X: FloatArray) -> FloatArray:
        """Return the sum of squared residuals in some blocks, (m,)."""
        return residual_squares(self.grams[list(blocks)].sum(axis=0), X)


def bounded_deviation(sigma: FloatArray, squares: FloatArray) -> FloatArray:
    """Return deviations (or variances) of equations, (m,), with a lower bound for those without
    torque.

    X = 0 solves 0 = W X exactly. The small residual of such an equation is therefore no measure of
    its noise, and a weight from it would draw X to zero. Its deviation is at least the median of
    the others.

    Args:
        sigma: (m,) deviations of the residuals.
        squares: (m,) sums of the squares of y; 0 without torque.
    """
    silent = squares == 0
    if silent.all():
        return sigma
    return np.where(silent, np.maximum(sigma, np.median(sigma[~silent])), sigma)


def solve_gram(gram: FloatArray) -> FloatArray:
    """Solve least squares from [W y]'[W y]; the shortest solution if it is not unique."""
    root = inverse_root(gram[:-1, :-1], _RANK)
    products = root.T @ gram[:-1, -1]
    return root @ products


def inverse_root(gram: FloatArray, rank: float) -> FloatArray:
    """Return B (p, r) with B B' the pseudoinverse of products of columns, in their units.

    Args:
        gram: (p, p) products.
        rank: share of the largest eigenvalue below which an eigenvalue is zero.
    """
    scale = np.sqrt(np.maximum(np.diag(gram), 0.0))
    scale = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    kept = values > rank * values[-1]
    unit = vectors[:, kept] / np.sqrt(values[kept])
    return np.asarray(unit / scale[:, None])


def residual_squares(grams: FloatArray, X: FloatArray) -> FloatArray:
    """Return ||y - W X||^2 of summaries (m, p + 1, p + 1), (m,)."""
    v = np.append(-X, 1.0)
    return np.asarray(np.maximum(np.einsum("a,jab,b->j", v, grams, v), 0.0))


def block_summary(rows: Rows, reach: float = 0.0) -> Blocks:
    """Summarise equations by blocks of the total training time.

    A row belongs to the block in which it ends. If it begins in another fold, it is left out.

    Args:
        rows: the rows of some logs, each in the order of time.
        reach: time in s that an equation reaches back.

    Raises:
        IdentificationError: a joint has no equation in a log.
    """
    used = rows.weight != 0
    ends = []
    for at in rows.spans:
        if not used[at].any(axis=0).all():
            raise IdentificationError("a log is too short for any equation")
        t = rows.t[at][used[at].any(axis=1)]
        ends.append((t[0], t[-1]))
    total = sum(end - start for start, end in ends) or 1.0
    p, count = len(rows.names), np.zeros((BLOCKS, rows.y.shape[1]))
    grams = np.zeros((*count.shape, p + 1, p + 1))
    before = 0.0
    for at, (start, end) in zip(rows.spans, ends, strict=True):
        place = (before + rows.t[at] - start) / total  # 0 .. 1
        first, last = (
            np.clip((x * BLOCKS).astype(int), 0, BLOCKS - 1) for x in (place - reach / total, place)
        )
        for b in np.unique(last):
            of_fold = np.searchsorted(first, b - b % _A_FOLD)
            begin = max(of_fold, np.searchsorted(last, b))
            stop = np.searchsorted(last, b, side="right")
            inside = slice(at.start + begin, at.start + stop)
            y = rows.y[inside, :, None]
            Wy = np.concatenate([rows.W[inside], y], axis=2)
            Wy = (Wy * rows.weight[inside, :, None]).swapaxes(0, 1)
            grams[b] += Wy.swapaxes(1, 2) @ Wy
            count[b] += used[inside].sum(axis=0)
        before += end - start
    return Blocks(grams, count)


def block_errors(equations: Blocks, torques: Blocks) -> FloatArray:
    """Return the squared torque error of every block under the fit without its fold, (B, m).

    The error of each joint is relative to its measured torque. Blocks without rows are 0.

    Args:
        equations: summary of the equations to fit.
        torques: summary of the torque equations, which give the error.
    """
    measured = torques.grams[:, :, -1, -1].sum(axis=0)
    share = 1 / np.where(measured > 0, measured, np.inf)
    out = np.zeros(torques.rows.shape)
    for fold in np.split(np.arange(BLOCKS), FOLDS):
        X = equations.fit(fold)
        for b in fold:
            out[b] = torques.errors([b], X) * share
    return out
