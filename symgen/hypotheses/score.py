"""How well a model predicts motion that it was not fitted on: the one score of the search.

The rows of torque equations are cut into folds of different motion. With b the parameters fitted
to all other folds,

    score = -1/2 sum over folds f and joints j of m log(c / m + s^2),     c = |y - W b|^2 on (f, j)

the log of a predictive density whose scale is integrated out: a fold that is predicted badly costs
its logarithm alone. m is the number of rows over one temperature for all candidates, which stands
for their correlation; s is what no model of the joint is righter than, so that differences below it
decide nothing.

The rows of the model are kept as products by fold. Columns on a joint cost their own products with
these; another torque costs one product with the regressor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import touched
from symgen.errors import IdentificationError
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.values import FloatArray

#: Columns (K, m) on joints, by position of the movable joint.
Columns = Mapping[int, FloatArray]
#: Name and joints of a hypothesis.
Key = tuple[str, tuple[int, ...]]
FOLDS = 6
#: Rows at four a period of the band that count as one: the temperature of all scores.
TEMPERATURE = 4.0
FREEDOM = 3.0  # of Student's t, the law of sizes that are expected but not known
_REGIONS = 12  # of state, from which the folds are put together
_ROUNDS, _SEED = 30, 1988  # of Lloyd's algorithm
_APART = 0.5  # periods of the comparison band between rows of two folds
_LOST = 0.5  # part of the rows that may be lost where folds meet
#: Distance of two states of one motion, in spreads of all; part of the rows that repeat others.
_SAME, _REPEATED = 0.05, 0.9
_DEPENDENT = 1e-9  # of a column: what is left of it beside the others
#: Least divisor of what may be zero.
TINY = 1e-300


def price_of_size(part: float) -> float:
    """Return the log of the density of Student's t at 0 over that at a size, nats.

    Args:
        part: the size over the expected one.
    """
    return (FREEDOM + 1) / 2 * math.log1p(part**2 / FREEDOM)


def worth_and_gain(
    was: FloatArray, now: FloatArray, size: FloatArray, joints: Sequence[int]
) -> tuple[float, float]:
    """Return what a hypothesis lowers the held-out error by.

    Args:
        was, now: (n,) held-out variance of each joint without and with it.
        size: (n,) RMS of the measured torque.
        joints: positions of its joints; none for all.

    Returns:
        The largest reduction of a joint as a part of its torque, from squares, and the share of the
        sum of squares of its joints.
    """
    at = list(joints) or slice(None)
    fell = (was - now) / size**2
    worth = float(np.sqrt(max(fell.max(), 0.0)))
    gain = fell[at].sum() / max(float((was / size**2)[at].sum()), TINY)
    return worth, float(gain)


def motion_folds(logs: Sequence[FilteredLog], count: int = FOLDS) -> NDArray[np.intp]:
    """Return the fold of each kept instant of some logs, (K,); -1 where two folds meet.

    Folds are put together from regions of state, position and speed of all joints, so that each is
    motion that the others do not have; what comes again is in the fold that it was in. A motion
    that runs through the regions too fast to be told apart is cut into spans of time.
    """
    from scipy.cluster.vq import kmeans2

    q, qd = (np.concatenate([getattr(s, x)[s.kept] for s in logs]) for x in ("q", "qd"))
    state = np.hstack([(x - x.mean(0)) / np.maximum(x.std(0), TINY) for x in (q, qd)])
    regions = min(_REGIONS, len(state))
    _, region = kmeans2(state, regions, minit="++", seed=_SEED, iter=_ROUNDS)
    fold = _set_apart(logs, _filled(region, count))
    if np.mean(fold < 0) > _LOST:
        spans = np.arange(len(state)) * regions // len(state)
        fold = _set_apart(logs, spans % count)
    return fold


def _filled(region: NDArray[np.int32], count: int) -> NDArray[np.intp]:
    """Return folds of about equal size, put together from regions, the largest first."""
    sizes = np.bincount(region)
    filled, fold_of = np.zeros(count), np.zeros(len(sizes), dtype=int)
    for r in np.argsort(-sizes, kind="stable"):
        fold_of[r] = int(np.argmin(filled))
        filled[fold_of[r]] += sizes[r]
    return np.asarray(fold_of[region])


def _set_apart(logs: Sequence[FilteredLog], fold: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return folds with -1 for the rows where two of them meet."""
    out = fold.copy()
    apart = _APART / min(log.band.comparison_hz for log in logs)
    for log, span in zip(logs, kept_spans(logs), strict=True):
        of_log, t = fold[span], log.compared_t
        changes = np.diff(of_log) != 0
        meets = np.r_[changes, False] | np.r_[False, changes]
        # of the rows on a side of a meeting, those less than half of it away
        rows = math.ceil(apart / 2 / (t[1] - t[0]) - 0.5) if len(t) > 1 else 1
        out[span][touched(meets, rows - 1)] = -1
    return out


def repeats_motion(logs: Sequence[FilteredLog], others: Sequence[FilteredLog]) -> bool:
    """Whether other logs hardly show a state (q, qd, qdd) that some logs do not show."""
    from scipy.spatial import cKDTree

    def states(log: FilteredLog, at: NDArray[np.int64] | slice) -> FloatArray:
        return np.hstack(log.motion)[at]

    known = np.concatenate([states(log, slice(None, None, log.stride)) for log in logs])
    asked = np.concatenate([states(log, log.kept) for log in others])
    spread = np.maximum(known.std(axis=0), TINY) * np.sqrt(known.shape[1])
    far, _ = cKDTree(known / spread).query(asked / spread, distance_upper_bound=_SAME)
    return bool(np.mean(far < _SAME) > _REPEATED)


def everywhere(torque: FloatArray) -> Columns:
    """Return columns (K, n, m) by joint."""
    return {j: torque[:, j] for j in range(torque.shape[1])}


def dense(columns: Columns, shape: tuple[int, ...]) -> FloatArray:
    """Return the columns of all joints, (K, n, m), for the shape (K, n)."""
    m = next(iter(columns.values())).shape[1]
    out = np.zeros((*shape, m))
    for j, c in columns.items():
        out[:, j] = c
    return out


class ScoreFit(NamedTuple):
    """A model with columns beside it, or for another torque.

    Attributes:
        score: log of the predictive density, up to a constant of the rows.
        left: (n,) held-out variance of each joint.
        squares: (n, folds) sums of squares that fits to the other folds leave of each fold.
        coefficients: (m,) of the columns, fitted to all folds.
        torque: (n,) RMS of what the columns add to each joint.
    """

    score: float
    left: FloatArray
    squares: FloatArray
    coefficients: FloatArray
    torque: FloatArray


@dataclass(frozen=True, eq=False)
class Folded:
    """Columns of N candidates on the same J joints, m each, with the weight of their rows, by fold.

    Attributes:
        joints: positions.
        rows: (J, folds, L, N m).
        squares: (J, folds, N, m, m) products of the columns of each candidate.
    """

    joints: tuple[int, ...]
    rows: FloatArray
    squares: FloatArray


class _Solved(NamedTuple):
    """Whitened columns of N candidates, of unit norm, and fits of the model with each of them.

    Attributes:
        norms: (N, m) of the columns before.
        CC, CR, Cr: products of the columns, (J, folds, N, ..), with themselves, model and residual.
        d, b: (folds + 1, N, p) what is added to X, and (folds + 1, N, m) coefficients.
    """

    norms: FloatArray
    CC: FloatArray
    CR: FloatArray
    Cr: FloatArray
    d: FloatArray
    b: FloatArray


@dataclass(frozen=True, eq=False)
class PredictiveScore:
    """The rows of a model, and what predicts them on folds that it was not fitted on.

    Attributes:
        W: (K, n, p) regressor.
        residual: (K, n) of y - W X, X the least-squares fit to all rows.
        weight: (K, n) of the rows; 0.0 for those without a say.
        sigma: (n,) by which the joints are weighed in the fits.
        fold: (K,) from `motion_folds`.
        misfit: (n,) what no model is righter than, N m or N.
    """

    W: FloatArray
    residual: FloatArray
    weight: FloatArray
    sigma: FloatArray
    fold: NDArray[np.intp]
    misfit: FloatArray

    @cached_property
    def _order(self) -> NDArray[np.intp]:
        """Rows of each fold, (folds, L), filled up with K, a row of zeros."""
        count = int(self.fold.max()) + 1
        if not count:
            raise IdentificationError("the logs are too short: no motion in them tests another")
        rows = [np.flatnonzero(self.fold == f) for f in range(count)]
        out = np.full((count, max(map(len, rows))), len(self.fold))
        for f, of_fold in enumerate(rows):
            out[f, : len(of_fold)] = of_fold
        return out

    def _folded(self, x: FloatArray) -> FloatArray:
        """Return rows (K, ...) by fold, (folds, L, ...)."""
        return np.concatenate([x, np.zeros((1, *x.shape[1:]))])[self._order]

    @cached_property
    def _norms(self) -> FloatArray:
        rows = self.W * (self.weight / self.sigma)[:, :, None]
        norms = np.sqrt(np.sum(rows**2, axis=(0, 1)))
        return np.where(norms > 0, norms, 1.0)

    @cached_property
    def _R(self) -> FloatArray:
        """Whitened columns of the model by joint and fold, (n, folds, L, p)."""
        rows = self.W * (self.weight / self.sigma)[:, :, None] / self._norms
        return np.ascontiguousarray(np.moveaxis(self._folded(rows), 2, 0))

    def _whitened(self, residual: FloatArray) -> FloatArray:
        """Return a residual (K, n), whitened, by joint and fold, (n, folds, L)."""
        rows = self._folded(residual * self.weight / self.sigma)
        return np.ascontiguousarray(np.moveaxis(rows, 2, 0))

    @cached_property
    def _r(self) -> FloatArray:
        return self._whitened(self.residual)

    @cached_property
    def _RR(self) -> FloatArray:
        return np.asarray(self._R.swapaxes(2, 3) @ self._R)

    @cached_property
    def _Rr(self) -> FloatArray:
        return np.asarray((self._R.swapaxes(2, 3) @ self._r[..., None])[..., 0])

    @cached_property
    def _rr(self) -> FloatArray:
        return np.asarray(np.sum(self._r**2, axis=2))

    @cached_property
    def _inverse(self) -> FloatArray:
        """(folds + 1, p, p) inverse of the products of the rows outside each fold; of all, last."""
        others = _of_others(self._RR)
        p = others.shape[-1]
        return np.asarray(np.linalg.inv(others + _DEPENDENT * np.eye(p))) if p else others

    @cached_property
    def _base(self) -> FloatArray:
        """(folds + 1, p) what the fit to the other folds adds to X; of all, last."""
        return np.asarray((self._inverse @ _of_others(self._Rr)[..., None])[..., 0])

    @cached_property
    def counts(self) -> FloatArray:
        """(n, folds) number of rows."""
        return np.asarray(np.moveaxis(self._folded(self.weight**2).sum(axis=1), 1, 0))

    def _scored(self, squares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the score and the held-out variance by joint, of squares (..., n, folds)."""
        count = np.maximum(self.counts, TINY)
        variance = squares / count + self.misfit[:, None] ** 2
        logs = np.log(np.maximum(variance, TINY))
        score = -0.5 / TEMPERATURE * np.sum(self.counts * logs, axis=(-2, -1))
        return score, np.asarray(squares.sum(axis=-1) / count.sum(axis=1))

    def _in_units(self, squares: FloatArray) -> FloatArray:
        """Return whitened squares (..., n, folds) in the unit of the torque squared."""
        return np.maximum(squares, 0.0) * self.sigma[:, None] ** 2

    def _squares(self, d: FloatArray) -> FloatArray:
        """Return what X + d, d (folds, N, p), leaves of joints on each fold, (N, n, folds)."""
        moved = self._RR @ d.swapaxes(1, 2)  # (n, folds, p, N)
        left = np.sum(d.swapaxes(1, 2) * (moved - 2 * self._Rr[..., None]), axis=2)
        return np.asarray(np.moveaxis(self._rr[..., None] + left, 2, 0))

    def density(self, counts: FloatArray) -> float:
        """Return the score of the model alone for so many rows, (n, folds), with the same errors.

        Other rows may have a say where a log is changed; then this compares.
        """
        variance = self.alone.squares / np.maximum(self.counts, 1.0) + self.misfit[:, None] ** 2
        logs = np.log(np.maximum(variance, TINY))
        return -0.5 / TEMPERATURE * float(np.sum(counts * logs))

    @cached_property
    def alone(self) -> ScoreFit:
        """The model without anything beside it."""
        return self.of_torque(0.0)

    def of_torque(self, change: FloatArray | float) -> ScoreFit:
        """Return the model without anything beside it for a torque y + change, (K, n)."""
        r = self._whitened(self.residual + change)
        Rr = (self._R.swapaxes(2, 3) @ r[..., None])[..., 0]
        d = (self._inverse @ _of_others(Rr)[..., None])[:-1, :, 0]
        moved = (self._RR @ d[..., None])[..., 0]
        squares = np.sum(r**2, axis=2) + np.sum(d * (moved - 2 * Rr), axis=2)
        squares = self._in_units(squares)
        score, left = self._scored(squares)
        return ScoreFit(float(score), left, squares, np.zeros(0), np.zeros(len(self.sigma)))

    @cached_property
    def held_out(self) -> FloatArray:
        """(K, n) residual of each row by the fit to the other folds; to all where folds meet."""
        out = np.zeros_like(self.residual)
        for f, d in zip((*range(len(self._base) - 1), -1), self._base, strict=True):
            at = self.fold == f
            out[at] = self.residual[at] - self.W[at] @ (d / self._norms)
        return out

    def gained_without(self, inside: NDArray[np.bool_]) -> tuple[float, ScoreFit, FloatArray]:
        """Return how much better other rows are predicted by fits in which some have no say.

        Args:
            inside: (K, n) these rows.

        Returns:
            What the score of the others gains, the model on the others, and (n,) the mean square
            of the residuals of these rows.
        """
        other = replace(self, weight=np.where(inside, 0.0, self.weight))
        before = self._folded((other.weight * self.held_out) ** 2).sum(axis=1).T
        score, _ = other._scored(before)
        there = np.where(inside, self.weight, 0.0)
        squares = np.sum((there * other.held_out) ** 2, axis=0)
        variance = squares / np.maximum(np.sum(there**2, axis=0), TINY)
        return other.alone.score - float(score), other.alone, variance

    def folded(self, columns: Sequence[Columns]) -> Folded:
        """Return the columns (K, m) of candidates on the same joints, as they are scored.

        All scores of the same rows with the same weights take them.
        """
        joints = tuple(columns[0])
        m = columns[0][joints[0]].shape[1]
        parts = [
            self._folded(np.concatenate([c[j] for c in columns], axis=1) * self.weight[:, [j]])
            for j in joints
        ]
        rows = np.array(parts)
        each = rows.reshape(*rows.shape[:3], -1, m)
        squares = np.einsum("jflna,jflnb->jfnab", each, each, optimize=m > 1)
        return Folded(joints, rows, squares)

    def beside(self, columns: Columns, size: float = np.inf) -> ScoreFit:
        """Score the model with columns (K, m) beside it on some joints.

        Args:
            columns: by position of the joint.
            size: RMS of the torque that a column is expected to have, N m or N: its coefficient is
                drawn to zero as by a normal prior of that scale.
        """
        return next(self.each(self.folded([columns]), size))

    def each(self, columns: Folded, size: FloatArray | float = np.inf) -> Iterator[ScoreFit]:
        """Yield the score of the model with each of N candidates beside it, as `beside` does.

        Args:
            columns: of the candidates.
            size: one for all, or one for each, (N,).
        """
        own, joints = self._solved(columns, size), list(columns.joints)
        d, b = own.d[:-1], own.b[:-1]
        squares = self._squares(d)
        slope = (own.CC @ b[..., None])[..., 0] - 2 * own.Cr
        slope += 2 * np.einsum("fnp,jfnap->jfna", d, own.CR)
        squares[:, joints] += np.einsum("fna,jfna->njf", b, slope)
        squares = self._in_units(squares)
        scores, left = self._scored(squares)
        rows, last = np.sqrt(self.counts.sum(axis=1)), own.b[-1]
        power = np.einsum("na,jnab,nb->nj", last, own.CC.sum(axis=1), last)
        torque = np.zeros((len(last), len(self.sigma)))
        part = self.sigma[joints] / np.maximum(rows[joints], TINY)
        torque[:, joints] = part * np.sqrt(np.maximum(power, 0.0))
        coefficients = last / own.norms
        for k, score in enumerate(scores):
            yield ScoreFit(float(score), left[k], squares[k], coefficients[k], torque[k])

    def _solved(self, columns: Folded, size: FloatArray | float) -> _Solved:
        """Fit the model with each candidate beside it to the rows outside each fold, and to all."""
        joints = list(columns.joints)
        count, m = columns.squares.shape[2:4]
        sigma = self.sigma[joints, None, None]
        CC = columns.squares / (sigma**2)[..., None, None]
        raw = np.einsum("jfnaa->na", CC)
        norms = np.sqrt(np.where(raw > 0, raw, 1.0))
        CC = CC / (norms[:, :, None] * norms[:, None, :])
        shape = (*columns.rows.shape[:2], count, m)
        scale = sigma[..., None] * norms
        pairs = zip(self._R[joints], columns.rows, strict=True)
        CR = np.array([C.swapaxes(1, 2) @ R for R, C in pairs]).reshape(*shape, -1)
        CR = CR / scale[..., None]
        Cr = (self._r[joints][:, :, None] @ columns.rows).reshape(shape) / scale
        B = _of_others(CR)  # (folds + 1, N, m, p)
        flat = B.reshape(len(B), count * m, -1)
        HB = (flat @ self._inverse).reshape(B.shape)
        rows = np.sqrt(self.counts.sum(axis=1))
        expected = np.broadcast_to(size / np.max(self.sigma[joints] / rows[joints]), count)
        loose = (_DEPENDENT + expected**-2.0)[:, None, None] * np.eye(m)
        S = _of_others(CC) - HB @ B.swapaxes(2, 3) + loose
        h = _of_others(Cr) - (flat @ self._base[..., None]).reshape(B.shape[:3])
        b = np.asarray(np.linalg.solve(S, h[..., None])[..., 0], dtype=float)
        d = self._base[:, None] - np.einsum("fnap,fna->fnp", HB, b)
        return _Solved(norms, CC, CR, Cr, d, b)


def _of_others(products: FloatArray) -> FloatArray:
    """Return products (J, folds, ...) of all joints, of rows outside each fold; of all, last."""
    by_fold = products.sum(axis=0)
    whole = by_fold.sum(axis=0)
    return np.concatenate([whole - by_fold, whole[None]])
