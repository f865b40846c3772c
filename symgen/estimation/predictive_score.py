"""How well a model predicts motion that it was not fitted on: what effects compete by.

The rows of torque equations are cut into folds of different motion. With b the parameters fitted
to all other folds,

    score = -1/2 sum over folds f and joints j of m log(c / m + s^2),     c = |y - W b|^2 on (f, j)

the log of a predictive density whose scale is integrated out: a fold that is predicted badly costs
its logarithm alone. m is the number of rows over one temperature for all candidates, which stands
for their correlation; s is what no model of the joint is righter than, so that differences below it
decide nothing.

Candidates stream through: with the rows of the model kept as products by fold, columns on a joint
cost their own products with these. Products are those of the residual, so that nothing cancels.
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


def price_of_size(part: float) -> float:
    """Return the log of the density of Student's t at 0 over that at a size, nats.

    Args:
        part: the size over the expected one.
    """
    return (FREEDOM + 1) / 2 * math.log1p(part**2 / FREEDOM)


def motion_folds(logs: Sequence[FilteredLog], count: int = FOLDS) -> NDArray[np.intp]:
    """Return the fold of each kept instant of some logs, (K,); -1 where two folds meet.

    Folds are put together from regions of state, position and speed of all joints, so that each is
    motion that the others do not have; what comes again is in the fold that it was in. A motion
    that runs through the regions too fast to be told apart is cut into spans of time.
    """
    from scipy.cluster.vq import kmeans2

    q, qd = (np.concatenate([getattr(s, x)[s.kept] for s in logs]) for x in ("q", "qd"))
    state = np.hstack([(x - x.mean(0)) / np.maximum(x.std(0), 1e-300) for x in (q, qd)])
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
        own, t = fold[span], log.compared_t
        changes = np.diff(own) != 0
        meets = np.r_[changes, False] | np.r_[False, changes]
        # of the rows on a side of a meeting, those less than half of it away
        rows = math.ceil(apart / 2 / (t[1] - t[0]) - 0.5) if len(t) > 1 else 1
        out[span][touched(meets, rows - 1)] = -1
    return out


def repeats_motion(logs: Sequence[FilteredLog], others: Sequence[FilteredLog]) -> bool:
    """Whether other logs hardly show a state (q, qd, qdd) that some logs do not show."""
    from scipy.spatial import cKDTree

    def states(log: FilteredLog, at: NDArray[np.int64] | slice) -> FloatArray:
        return np.hstack([log.q, log.qd, log.qdd])[at]

    known = np.concatenate([states(log, slice(None, None, log.stride)) for log in logs])
    asked = np.concatenate([states(log, log.kept) for log in others])
    spread = np.maximum(known.std(axis=0), 1e-300) * np.sqrt(known.shape[1])
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


class Fit(NamedTuple):
    """A model with columns beside it.

    Attributes:
        score: log of the predictive density, up to a constant of the rows.
        left: (n,) held-out variance of each joint.
        coefficients: (m,) of the columns, fitted to all folds.
        torque: (n,) RMS of what the columns add to each joint.
        rests: part of the score that is of rests.
    """

    score: float
    left: FloatArray
    coefficients: FloatArray
    torque: FloatArray
    rests: float = 0.0


@dataclass(frozen=True, eq=False)
class Folded:
    """Columns of N candidates on the same J joints, m each, with the weight of their rows, by fold.

    Attributes:
        joints: positions.
        rows: (J, folds, L, N m).
        squares: (J, folds, N, m, m) products of the columns of each candidate.
        rests: (R, N, m) their means at rests; None where rests are no part of the score.
    """

    joints: tuple[int, ...]
    rows: FloatArray
    squares: FloatArray
    rests: FloatArray | None


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
class Rests:
    """Where joints stand, and friction is anything between its limits: one row for each rest.

    Attributes:
        joint: (R,) position of the joint.
        rows: (R, 2) first kept row, and the row after the last.
        W: (R, p) mean regressor, with the speed of the joint zero.
        residual: (R,) mean of y - W X.
        limit: (R,) of static friction, N m or N.
    """

    joint: NDArray[np.intp]
    rows: NDArray[np.intp]
    W: FloatArray
    residual: FloatArray
    limit: FloatArray

    @cached_property
    def _of(self) -> dict[int, tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]]:
        """Rests of each joint, their rows one after the other, and where those of each begin."""
        out = {}
        for j in map(int, np.unique(self.joint)):
            own = np.flatnonzero(self.joint == j)
            rows = [np.arange(a, b) for a, b in self.rows[own]]
            starts = np.cumsum([0, *map(len, rows[:-1])])
            out[j] = own, np.concatenate(rows), starts
        return out

    def means(self, columns: Columns) -> FloatArray:
        """Return the means of columns (K, m) by joint, (R, m)."""
        out = np.zeros((len(self.joint), next(iter(columns.values())).shape[1]))
        for j in self._of.keys() & columns.keys():
            own, rows, starts = self._of[j]
            count = np.diff([*starts, len(rows)])
            out[own] = np.add.reduceat(columns[j][rows], starts) / count[:, None]
        return out


@dataclass(frozen=True, eq=False)
class PredictiveScore:
    """The rows of a model, and what predicts them on folds that it was not fitted on.

    A rest counts as one row more, by the distance of its torque from the limits of static friction.
    No fit is made of rests.

    Attributes:
        W: (K, n, p) regressor.
        residual: (K, n) of y - W X, X the least-squares fit to all rows.
        weight: (K, n) of the rows; 0.0 for those without a say.
        sigma: (n,) by which the joints are weighed in the fits.
        fold: (K,) from `motion_folds`.
        misfit: (n,) what no model is righter than, N m or N.
        rests: where joints stand; None where that is no part of the score.
    """

    W: FloatArray
    residual: FloatArray
    weight: FloatArray
    sigma: FloatArray
    fold: NDArray[np.intp]
    misfit: FloatArray
    rests: Rests | None = None

    @cached_property
    def _order(self) -> NDArray[np.intp]:
        """Rows of each fold, (folds, L), filled up with K, a row of zeros."""
        count = int(self.fold.max()) + 1
        if not count:
            raise IdentificationError("the logs are too short: no motion in them tests another")
        rows = [np.flatnonzero(self.fold == f) for f in range(count)]
        out = np.full((count, max(map(len, rows))), len(self.fold))
        for f, own in enumerate(rows):
            out[f, : len(own)] = own
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

    @cached_property
    def _r(self) -> FloatArray:
        """Whitened residual by joint and fold, (n, folds, L)."""
        return np.asarray(np.moveaxis(self._folded(self.residual * self.weight / self.sigma), 2, 0))

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
        squares = np.maximum(squares, 0.0) * self.sigma[:, None] ** 2
        count = np.maximum(self.counts, 1e-300)
        variance = squares / count + self.misfit[:, None] ** 2
        logs = np.log(np.maximum(variance, 1e-300))
        score = -0.5 / TEMPERATURE * np.sum(self.counts * logs, axis=(-2, -1))
        return score, np.asarray(squares.sum(axis=-1) / count.sum(axis=1))

    def _squares(self, d: FloatArray) -> FloatArray:
        """Return what X + d, d (folds, N, p), leaves of joints on each fold, (N, n, folds)."""
        moved = self._RR @ d.swapaxes(1, 2)  # (n, folds, p, N)
        left = np.sum(d.swapaxes(1, 2) * (moved - 2 * self._Rr[..., None]), axis=2)
        return np.asarray(np.moveaxis(self._rr[..., None] + left, 2, 0))

    @cached_property
    def squares(self) -> FloatArray:
        """(n, folds) sums of squares that fits to the other folds leave of each fold."""
        return np.asarray(self._squares(self._base[:-1, None])[0] * self.sigma[:, None] ** 2)

    @property
    def apart(self) -> FloatArray:
        """(folds, p) what the fit without each fold adds to X."""
        return np.asarray(self._base[:-1] / self._norms)

    @cached_property
    def alone(self) -> Fit:
        """The model without anything beside it."""
        d = self._base[:-1, None]
        score, left = self._scored(self._squares(d))
        rests = float(self._at_rest(d)[0])
        none = np.zeros(0), np.zeros(len(self.sigma))
        return Fit(float(score[0]) + rests, left[0], *none, rests)

    @cached_property
    def _rest_fold(self) -> NDArray[np.intp]:
        """Fold of each rest, that of most of its rows; the first where folds only meet."""
        assert self.rests is not None
        folds = [self.fold[a:b] for a, b in self.rests.rows]
        return np.array([np.bincount(f[f >= 0], minlength=1).argmax() for f in folds])

    def _at_rest(self, d: FloatArray, more: FloatArray | float = 0.0) -> FloatArray:
        """Return what rests add to the score of fits that add d (folds, N, p) to X, (N,).

            -1/2 sum of log(1 + e^2 / s^2),    e beyond the limits, s^2 of the mean of a rest

        Args:
            d: in units of `_norms`.
            more: (R, N) torque of further columns with the coefficients of each rest's fold.
        """
        rests = self.rests
        if rests is None:
            return np.zeros(d.shape[1])
        model = np.einsum("rp,rnp->rn", rests.W, (d / self._norms)[self._rest_fold])
        left = rests.residual[:, None] - model - more
        beyond = np.maximum(np.abs(left) - rests.limit[:, None], 0.0)
        count = np.maximum(np.diff(rests.rows)[:, 0] / TEMPERATURE, 1.0)
        known = (self.sigma**2)[rests.joint] / count + (self.misfit**2)[rests.joint]
        far = np.log1p(beyond**2 / np.maximum(known, 1e-300)[:, None])
        return np.asarray(-0.5 * far.sum(axis=0))

    @cached_property
    def held_out(self) -> FloatArray:
        """(K, n) residual of each row by the fit to the other folds; to all where folds meet."""
        out = np.zeros_like(self.residual)
        for f, d in zip((*range(len(self._base) - 1), -1), self._base, strict=True):
            at = self.fold == f
            out[at] = self.residual[at] - self.W[at] @ (d / self._norms)
        return out

    def _squares_of(self, left: FloatArray) -> FloatArray:
        """Return the sums of squares of residuals (K, n) on each fold, (n, folds)."""
        out = np.zeros(self.counts.shape)
        for f, _ in enumerate(self.counts[0]):
            out[:, f] = np.sum(left[self.fold == f] ** 2, axis=0)
        return out

    def fitted_without(self, inside: NDArray[np.bool_]) -> Fit:
        """Return how fits in which some rows (K, n) have no say predict all rows."""
        squares = self._squares_of(self.weight * self._without(inside).held_out)
        score, variance = self._scored(squares / self.sigma[:, None] ** 2)
        return Fit(float(score), variance, np.zeros(0), np.zeros(len(self.sigma)))

    def gained_without(self, inside: NDArray[np.bool_]) -> tuple[float, Fit, FloatArray]:
        """Return how much better other rows are predicted by fits in which some have no say.

        Args:
            inside: (K, n) these rows.

        Returns:
            What the score of the others gains, the model on the others, and (n,) the mean square
            of the residuals of these rows.
        """
        other = self._without(inside)
        kept = np.where(inside | (self.fold < 0)[:, None], 0.0, self.weight)
        own = np.where(inside, self.weight, 0.0)
        before = self._squares_of(kept * self.held_out)
        score, _ = other._scored(before / self.sigma[:, None] ** 2)
        left = other.alone
        squares = np.sum((own * other.held_out) ** 2, axis=0)
        variance = squares / np.maximum(np.sum(own**2, axis=0), 1e-300)
        return left.score - left.rests - float(score), left, variance

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
        rests = self.rests
        means = None if rests is None else np.stack([rests.means(c) for c in columns], axis=1)
        return Folded(joints, rows, squares, means)

    def beside(self, columns: Columns, size: float = np.inf) -> Fit:
        """Score the model with columns (K, m) beside it on some joints.

        Args:
            columns: by position of the joint.
            size: RMS of the torque that a column is expected to have, N m or N: its coefficient is
                drawn to zero as by a normal prior of that scale.
        """
        return next(self.each(self.folded([columns]), size))

    def each(self, columns: Folded, size: FloatArray | float = np.inf) -> Iterator[Fit]:
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
        more = np.einsum("fna,jfna->njf", b, slope)
        squares[:, joints] += more
        scores, left = self._scored(squares)
        rests = np.zeros(len(scores))
        if columns.rests is not None:
            coefficients = (b / own.norms)[self._rest_fold]
            rests = self._at_rest(d, np.sum(columns.rests * coefficients, axis=2))
        rows, last = np.sqrt(self.counts.sum(axis=1)), own.b[-1]
        power = np.einsum("na,jnab,nb->nj", last, own.CC.sum(axis=1), last)
        torque = np.zeros((len(last), len(self.sigma)))
        part = self.sigma[joints] / np.maximum(rows[joints], 1e-300)
        torque[:, joints] = part * np.sqrt(np.maximum(power, 0.0))
        for fit in zip(scores + rests, left, last / own.norms, torque, rests, strict=True):
            yield Fit(float(fit[0]), *fit[1:4], float(fit[4]))

    def fits(self, columns: Columns, size: float = np.inf) -> tuple[FloatArray, FloatArray]:
        """Return what fits with columns beside the model give; arguments as for `beside`.

        Returns:
            What they add to X, (folds + 1, p), and the columns' coefficients, (folds + 1, m): of
            the rows outside each fold; of all, last.
        """
        own = self._solved(self.folded([columns]), size)
        return own.d[:, 0] / self._norms, own.b[:, 0] / own.norms[0]

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

    def _without(self, inside: NDArray[np.bool_]) -> PredictiveScore:
        """Return the score without some rows (K, n): its products are these less theirs."""
        other = replace(self, weight=np.where(inside, 0.0, self.weight))
        RR, Rr, rr = self._RR.copy(), self._Rr.copy(), self._rr.copy()
        lost = np.flatnonzero(inside.any(axis=1) & (self.fold >= 0))
        weight = np.where(inside, self.weight, 0.0)[lost] / self.sigma
        R, r = self.W[lost] * weight[:, :, None] / self._norms, self.residual[lost] * weight
        for f in np.unique(self.fold[lost]):
            own = self.fold[lost] == f
            for j in range(len(self.sigma)):
                a, e = R[own, j], r[own, j]
                RR[j, f] -= a.T @ a
                Rr[j, f] -= a.T @ e
                rr[j, f] -= e @ e
        other.__dict__.update(_norms=self._norms, _RR=RR, _Rr=Rr, _rr=rr)
        return other


def _of_others(products: FloatArray) -> FloatArray:
    """Return products (J, folds, ...) of all joints, of rows outside each fold; of all, last."""
    by_fold = products.sum(axis=0)
    whole = by_fold.sum(axis=0)
    return np.concatenate([whole - by_fold, whole[None]])
