"""The score of the search: how well a model predicts held-out motion.

The rows of torque equations are divided into folds of different motion. With b the parameters
fitted to all other folds, the score is

    score = -1/2 sum over folds f and joints j of m log(c / m + s^2),     c = |y - W b|^2 on (f, j)

It is the log of a predictive density whose scale is integrated out. A badly predicted fold
therefore costs only its logarithm. m is the number of rows divided by a temperature, the same for
all candidates, because rows are correlated. s is the smallest error to expect of any model of the
joint, so smaller differences have no influence.

The rows of the model are stored as products by fold. Columns on a joint need only their products
with these rows. Another torque needs one product with the regressor.
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
from symgen.policy import NEAR, REPEATED, TEMPERATURE

#: Columns (K, m) by joint, or by equation: those of a floating base come before those of joints.
Columns = Mapping[int, FloatArray]
#: Name and joints of a hypothesis.
Key = tuple[str, tuple[int, ...]]
FOLDS = 6
FREEDOM = 3.0  # degrees of freedom of Student's t, the prior of sizes
#: Digits of log-odds in comparisons: of hypotheses that fit alike, the first one counts.
DIGITS = 6
_REGIONS = 12  # number of regions of state that form the folds
_ROUNDS, _SEED = 30, 1988  # of Lloyd's algorithm
_SEPARATION = 0.5  # distance between rows of two folds, in periods of the comparison band
_LOST = 0.5  # largest part of the rows that may be lost between folds
_DEPENDENT = 1e-9  # regularisation of products of unit columns, which may be dependent
#: Smallest divisor, for quantities that may be zero.
TINY = 1e-300


def price_of_size(part: float) -> float:
    """Return the log of the ratio of Student's t density at 0 to that at a size, nats.

    Args:
        part: ratio of the size to the expected size.
    """
    return (FREEDOM + 1) / 2 * math.log1p(part**2 / FREEDOM)


def worth_and_gain(
    was: FloatArray, now: FloatArray, size: FloatArray, rows: Sequence[int]
) -> tuple[float, float]:
    """Return how much a hypothesis lowers the held-out error.

    Args:
        was, now: (m,) held-out variance of each equation without and with it.
        size: (m,) RMS of the measured torque.
        rows: its equations; empty for all.

    Returns:
        worth: square root of the largest reduction of a variance, as a part of a joint's torque.
        gain: explained share of the sum of squares of its equations.
    """
    at = list(rows) or slice(None)
    fell = (was - now) / size**2
    worth = float(np.sqrt(max(fell.max(), 0.0)))
    gain = fell[at].sum() / max(float((was / size**2)[at].sum()), TINY)
    return worth, float(gain)


def motion_folds(logs: Sequence[FilteredLog]) -> NDArray[np.intp]:
    """Return the fold of each kept sample of some logs, (K,); -1 where two folds meet.

    A fold consists of regions of state: positions and speeds of all joints. Each fold is therefore
    motion that the others lack, and repeated motion stays in one fold. If the motion crosses the
    regions so fast that most samples lie between folds, spans of time replace the regions. They do
    so too on a floating base: a region may hold every lift of a foot, and the other folds would
    then not determine the parameters.
    """
    from scipy.cluster.vq import kmeans2

    states = [np.hstack([log.q[log.kept], log.qd[log.kept]]) for log in logs]
    state = np.concatenate(states)
    spread = np.maximum(state.std(axis=0), TINY)
    state = (state - state.mean(axis=0)) / spread
    regions = min(_REGIONS, len(state))
    _, region = kmeans2(state, regions, minit="++", seed=_SEED, iter=_ROUNDS)
    fold = _separate(logs, _filled(region))
    if np.mean(fold < 0) > _LOST or logs[0].base_rows:
        spans = np.arange(len(state)) * regions // len(state)
        fold = _separate(logs, spans % FOLDS)
    return fold


def _filled(region: NDArray[np.int32]) -> NDArray[np.intp]:
    """Return folds of about equal size: each region, by size, goes to the smallest fold."""
    sizes = np.bincount(region)
    filled, fold_of = np.zeros(FOLDS), np.zeros(len(sizes), dtype=int)
    for r in np.argsort(-sizes, kind="stable"):
        fold_of[r] = int(np.argmin(filled))
        filled[fold_of[r]] += sizes[r]
    return fold_of[region]


def _separate(logs: Sequence[FilteredLog], fold: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return folds with -1 for the rows where two of them meet."""
    out = fold.copy()
    separation = _SEPARATION / min(log.band.comparison_hz for log in logs)
    for log, span in zip(logs, kept_spans(logs), strict=True):
        of_log, t = fold[span], log.compared_t
        changes = np.diff(of_log) != 0
        meets = np.r_[changes, False] | np.r_[False, changes]
        # rows on each side of a boundary that are less than half of the distance away
        rows = math.ceil(separation / 2 / (t[1] - t[0]) - 0.5) if len(t) > 1 else 1
        out[span][touched(meets, rows - 1)] = -1
    return out


def repeats_motion(logs: Sequence[FilteredLog], others: Sequence[FilteredLog]) -> bool:
    """Whether almost all states (q, qd, qdd) of other logs also occur in some logs.

    Args:
        logs: some logs.
        others: other logs.
    """
    from scipy.spatial import cKDTree

    def states(log: FilteredLog, at: NDArray[np.int64] | slice) -> FloatArray:
        return np.hstack(log.motion)[at]

    known = np.concatenate([states(log, slice(None, None, log.stride)) for log in logs])
    other = np.concatenate([states(log, log.kept) for log in others])
    spread = np.maximum(known.std(axis=0), TINY) * np.sqrt(known.shape[1])
    far, _ = cKDTree(known / spread).query(other / spread, distance_upper_bound=NEAR)
    return bool(np.mean(far < NEAR) > REPEATED)


def everywhere(torque: FloatArray) -> Columns:
    """Return columns (K, n, m) by position of the joint."""
    return {j: torque[:, j] for j in range(torque.shape[1])}


def dense(columns: Columns, shape: tuple[int, ...]) -> FloatArray:
    """Return the columns of all joints, (K, n, m), for the shape (K, n)."""
    m = next(iter(columns.values())).shape[1]
    out = np.zeros((*shape, m))
    for j, c in columns.items():
        out[:, j] = c
    return out


class ScoreFit(NamedTuple):
    """The fit of a model with more columns, or with another torque.

    Attributes:
        score: log of the predictive density, up to a constant of the rows.
        variance: (n,) held-out variance of each joint.
        squares: (n, folds) held-out sums of squares of each fold.
        coefficients: (m,) of the columns, fitted to all folds.
        torque: (n,) RMS torque of the columns on each joint.
    """

    score: float
    variance: FloatArray
    squares: FloatArray
    coefficients: FloatArray
    torque: FloatArray


@dataclass(frozen=True, eq=False)
class Folded:
    """Weighted columns of N candidates on the same J joints, m columns each, by fold.

    Attributes:
        joints: positions.
        rows: (J, folds, L, N m) columns.
        squares: (J, folds, N, m, m) products of the columns of each candidate.
    """

    joints: tuple[int, ...]
    rows: FloatArray
    squares: FloatArray


class _Solved(NamedTuple):
    """Whitened columns of N candidates, of unit norm, and fits of the model with each of them.

    Attributes:
        norms: (N, m) of the columns before they are scaled.
        CC, CR, Cr: (J, folds, N, ..) products of the columns with themselves, with the columns of
            the model, and with the residual.
        d, b: (folds + 1, N, p) change of X, and (folds + 1, N, m) coefficients.
    """

    norms: FloatArray
    CC: FloatArray
    CR: FloatArray
    Cr: FloatArray
    d: FloatArray
    b: FloatArray


@dataclass(frozen=True, eq=False)
class PredictiveScore:
    """The rows of a model, and how well fits to other folds predict each fold.

    Attributes:
        W: (K, n, p) regressor.
        residual: (K, n) y - W X, with X the least-squares fit to all rows.
        weight: (K, n) weight of the rows; 0.0 for unused rows.
        sigma: (n,) standard deviation that weights the joints in the fits, N m or N.
        fold: (K,) from `motion_folds`.
        misfit: (n,) smallest error to expect of any model, N m or N.
        temperature: number of correlated rows that count as one.
    """

    W: FloatArray
    residual: FloatArray
    weight: FloatArray
    sigma: FloatArray
    fold: NDArray[np.intp]
    misfit: FloatArray
    temperature: float = TEMPERATURE

    @cached_property
    def _order(self) -> NDArray[np.intp]:
        """Rows of each fold, (folds, L), padded with K, the index of a row of zeros."""
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
        weight = self.weight / self.sigma
        norms = np.sqrt(np.einsum("knp,kn->p", self.W**2, weight**2))
        return np.where(norms > 0, norms, 1.0)

    @cached_property
    def _R(self) -> FloatArray:
        """Whitened columns of the model by joint and fold, (n, folds, L, p)."""
        return self._whitened(self.W / self._norms)

    def _whitened(self, x: FloatArray) -> FloatArray:
        """Return rows (K, n, ...), whitened, by joint and fold, (n, folds, L, ...)."""
        weight = self.weight / self.sigma
        rows = self._folded((x.T * weight.T).T)
        return np.ascontiguousarray(np.moveaxis(rows, 2, 0))

    @cached_property
    def _r(self) -> FloatArray:
        return self._whitened(self.residual)

    @cached_property
    def _RR(self) -> FloatArray:
        return self._R.swapaxes(2, 3) @ self._R

    @cached_property
    def _Rr(self) -> FloatArray:
        return self._along(self._r)

    def _along(self, r: FloatArray) -> FloatArray:
        """Return the products of the columns with a whitened residual, (n, folds, p)."""
        return (self._R.swapaxes(2, 3) @ r[..., None])[..., 0]

    @cached_property
    def _inverse(self) -> FloatArray:
        """(folds + 1, p, p) inverse products of the rows outside each fold; of all rows last."""
        others = _of_others(self._RR)
        p = others.shape[-1]
        return np.asarray(np.linalg.inv(others + _DEPENDENT * np.eye(p))) if p else others

    def _moved(self, Rr: FloatArray) -> FloatArray:
        """Return the change of X in the fit to the other folds, and to all rows, (folds + 1, p).

        Args:
            Rr: (n, folds, p) products of the columns with the residual.
        """
        products = _of_others(Rr)[..., None]
        return (self._inverse @ products)[..., 0]

    @cached_property
    def _base(self) -> FloatArray:
        return self._moved(self._Rr)

    @cached_property
    def counts(self) -> FloatArray:
        """(n, folds) number of rows, from squared weights."""
        return np.moveaxis(self._folded(self.weight**2).sum(axis=1), 1, 0)

    def _scored(self, squares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the score and the variance by joint for held-out squares (..., n, folds)."""
        count = np.maximum(self.counts, TINY)
        variance = squares / count + self.misfit[:, None] ** 2
        logs = np.log(np.maximum(variance, TINY))
        score = -0.5 / self.temperature * np.sum(self.counts * logs, axis=(-2, -1))
        return score, (squares.sum(axis=-1) / count.sum(axis=1))

    def _in_units(self, squares: FloatArray) -> FloatArray:
        """Return whitened squares (..., n, folds) in the unit of the torque squared."""
        return np.maximum(squares, 0.0) * self.sigma[:, None] ** 2

    def _squares(self, d: FloatArray, Rr: FloatArray, r: FloatArray) -> FloatArray:
        """Return the sums of squares for the parameters X + d, (N, n, folds).

        Args:
            d: (folds, N, p) change of X for each fold.
            Rr: (n, folds, p) products of the columns with the residual.
            r: (n, folds, L) whitened residual.
        """
        d = d.swapaxes(1, 2)
        moved = self._RR @ d  # (n, folds, p, N)
        change = np.sum(d * (moved - 2 * Rr[..., None]), axis=2)
        squares = np.sum(r**2, axis=2)[..., None] + change
        return np.moveaxis(squares, 2, 0)

    @cached_property
    def alone(self) -> ScoreFit:
        """The fit of the model without more columns."""
        return self.of_torque(0.0)

    def of_torque(self, change: FloatArray | float) -> ScoreFit:
        """Return the fit of the model without more columns, for a torque y + change, (K, n)."""
        r = self._whitened(self.residual + change)
        Rr = self._along(r)
        d = self._moved(Rr)[:-1, None]
        squares = self._in_units(self._squares(d, Rr, r)[0])
        score, variance = self._scored(squares)
        none = np.zeros(len(self.sigma))
        return ScoreFit(float(score), variance, squares, none[:0], none)

    @cached_property
    def held_out(self) -> FloatArray:
        """(K, n) held-out residual of each row; where folds meet, of the fit to all rows."""
        out = np.zeros_like(self.residual)
        for f, d in zip((*range(len(self._base) - 1), -1), self._base, strict=True):
            at = self.fold == f
            out[at] = self.residual[at] - self.W[at] @ (d / self._norms)
        return out

    def gained_without(self, inside: NDArray[np.bool_]) -> tuple[float, ScoreFit, FloatArray]:
        """Return how much better a fit without some rows predicts the other rows.

        Args:
            inside: (K, n) rows that the fit does not use.

        Returns:
            The gain of the score on the other rows, the fit to the other rows, and (n,) the mean
            square of the residuals of the rows inside.
        """
        other = replace(self, weight=np.where(inside, 0.0, self.weight))
        before = self._folded((other.weight * self.held_out) ** 2).sum(axis=1).T
        score, _ = other._scored(before)
        there = np.where(inside, self.weight, 0.0)
        squares = np.sum((there * other.held_out) ** 2, axis=0)
        variance = squares / np.maximum(np.sum(there**2, axis=0), TINY)
        return other.alone.score - float(score), other.alone, variance

    def folded(self, columns: Sequence[Columns]) -> Folded:
        """Return the columns (K, m) of candidates on the same joints by fold, for `each`.

        All scores with the same rows and weights can use the result.
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

    def fit_with(self, columns: Columns, size: float = np.inf) -> ScoreFit:
        """Return the fit of the model with columns (K, m) on some joints.

        Args:
            columns: columns by position of the joint.
            size: scale of the normal prior of a column's RMS torque, N m or N. The prior draws the
                coefficient to zero.
        """
        return next(self.each(self.folded([columns]), size))

    def each(self, columns: Folded, size: FloatArray | float = np.inf) -> Iterator[ScoreFit]:
        """Yield the fit of the model with each of N candidates, as `fit_with` returns it.

        Args:
            columns: columns of the candidates.
            size: as for `fit_with`; one for all candidates, or (N,).
        """
        solved, joints = self._solved(columns, size), list(columns.joints)
        d, b = solved.d[:-1], solved.b[:-1]
        squares = self._squares(d, self._Rr, self._r)
        slope = (solved.CC @ b[..., None])[..., 0] - 2 * solved.Cr
        slope += 2 * np.einsum("fnp,jfnap->jfna", d, solved.CR)
        squares[:, joints] += np.einsum("fna,jfna->njf", b, slope)
        squares = self._in_units(squares)
        scores, variance = self._scored(squares)
        rows, last = np.sqrt(self.counts.sum(axis=1)), solved.b[-1]
        power = np.einsum("na,jnab,nb->nj", last, solved.CC.sum(axis=1), last)
        torque = np.zeros((len(last), len(self.sigma)))
        part = self.sigma[joints] / np.maximum(rows[joints], TINY)
        torque[:, joints] = part * np.sqrt(np.maximum(power, 0.0))
        coefficients = last / solved.norms
        for k, score in enumerate(scores):
            yield ScoreFit(float(score), variance[k], squares[k], coefficients[k], torque[k])

    def _solved(self, columns: Folded, size: FloatArray | float) -> _Solved:
        """Fit the model with each candidate to the rows outside each fold, and to all rows."""
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
        rows = np.sqrt(np.maximum(self.counts.sum(axis=1), TINY))
        expected = np.broadcast_to(size / np.max(self.sigma[joints] / rows[joints]), count)
        loose = (_DEPENDENT + expected**-2.0)[:, None, None] * np.eye(m)
        S = _of_others(CC) - HB @ B.swapaxes(2, 3) + loose
        h = _of_others(Cr) - (flat @ self._base[..., None]).reshape(B.shape[:3])
        b = np.asarray(np.linalg.solve(S, h[..., None])[..., 0], dtype=float)
        d = self._base[:, None] - np.einsum("fnap,fna->fnp", HB, b)
        return _Solved(norms, CC, CR, Cr, d, b)


def _of_others(products: FloatArray) -> FloatArray:
    """Return products (J, folds, ...) over the rows outside each fold; over all rows last."""
    by_fold = products.sum(axis=0)
    total = by_fold.sum(axis=0)
    return np.concatenate([total - by_fold, total[None]])
