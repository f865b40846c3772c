"""The whitened torque equations of logs: torque, regressor and residual, row by row.

Rows are the torque equations of `symgen.estimation.system`: one joint at one kept sample of the
comparison band. They are divided by the standard deviation of their joint's residual. A mask
removes rows. No sample is weighted before the filter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import accumulate, chain, pairwise, starmap
from typing import TypeVar

import numpy as np

from symgen.data.mask import SLOW, STOP, STOPPED, Bools, mean_speeds, rms, stops, touched
from symgen.estimation.cutoff import rest_weight
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.predictive_score import Columns, dense
from symgen.estimation.solve import SINGULAR, column_norms, shortest
from symgen.estimation.summary import Summary, bounded_deviation, triangle
from symgen.estimation.system import torque_rows
from symgen.estimation.values import FloatArray
from symgen.parallel import in_order, own_threads
from symgen.runtime.evaluator import Evaluator

Item = TypeVar("Item")
_TOGETHER = 16  # number of items whose columns pass the filter at once
_WHITENING = 3
_TINY = 1e-300
_FREE = 1e-5  # norm of a unit column beside the model, above which the column is independent
SETTLING = 5  # rounds in which columns that contain the model's torque follow it
_REST = 0.005  # of the RMS speed


def standing(log: FilteredLog) -> Bools:
    """Return where joints are at rest, (N, n): below 0.2 % of their largest speed."""
    largest = np.abs(mean_speeds(log.q, log.step, STOP)).max(axis=0)
    return stops(log.q, log.step, np.where(largest > 0, SLOW * STOPPED * largest, -1.0))


def static(log: FilteredLog) -> Bools:
    """Return the kept rows that static friction of a resting joint affects, (K, n).

    There the friction can take any value between its limits, which no column can represent.
    """
    still = standing(log)
    return np.column_stack([touched(joint, log.reach // 2)[log.kept] for joint in still.T])


def compared(log: FilteredLog, x: FloatArray) -> FloatArray:
    """Return a signal (N, ...) in the comparison band at the kept samples, (K, ...)."""
    return log.unmasked.compared(x)


def in_band(
    logs: Sequence[FilteredLog],
    items: Iterable[Item],
    columns: Callable[[Item, int], Columns],
    strides: Sequence[int | None] | None = None,
) -> Iterator[Columns]:
    """Yield the columns (K, m) of some items, in the comparison band, at the kept samples.

    One filter call for many columns is faster than one for each. Threads work on several items.

    Args:
        logs: logs with K kept samples in all.
        items: the items that have columns.
        columns: gives the columns (N, m) of an item along a log, by the index of the log; it must
            be thread-safe.
        strides: step, in samples of each log, between the N samples of a column; None if they are
            all samples or the nodes.
    """
    every = strides or [None] * len(logs)

    def filtered(batch: Sequence[Item]) -> list[Columns]:
        by_log = [[columns(item, k) for item in batch] for k in range(len(logs))]
        parts = []
        for log, stride, found in zip(logs, every, by_log, strict=True):
            raw = np.concatenate([c for own in found for c in own.values()], axis=1)
            parts.append(log.unmasked.compared(raw, stride))
        whole = np.concatenate(parts)
        widths = [c.shape[1] for own in by_log[0] for c in own.values()]
        spans = starmap(slice, pairwise(accumulate(widths, initial=0)))
        return [{j: np.ascontiguousarray(whole[:, next(spans)]) for j in own} for own in by_log[0]]

    waiting = list(items)
    batches = [waiting[k : k + _TOGETHER] for k in range(0, len(waiting), _TOGETHER)]
    threads = min(own_threads(), max(1, len(batches)))
    return chain.from_iterable(in_order(filtered, batches, threads))


def modelled(
    log: FilteredLog, model: Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
) -> FloatArray:
    """Return a function of q, qd, qdd in the comparison band at the kept samples, (K, ...)."""
    return np.concatenate([x for _, x in log.unmasked.modelled(model)])


@dataclass(frozen=True, eq=False)
class WhitenedSystem:
    """The whitened rows of some logs, and their residual beside the model.

    Attributes:
        logs: logs in the band of the run.
        W: (K, n, p) regressor of the model at K kept samples.
        y: (K, n) torque.
        X: (p,) least-squares parameters.
        sigma: (n,) standard deviation of each joint's residual.
        moves: (K, n) weight of the rows: 1.0 where the joint moves, 0.0 at reversals and at rest,
            where friction is undefined.
    """

    logs: tuple[FilteredLog, ...]
    W: FloatArray
    y: FloatArray
    X: FloatArray
    sigma: FloatArray
    moves: FloatArray

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.y.shape[1])

    @cached_property
    def residual(self) -> FloatArray:
        """Whitened residual (K, n)."""
        return self.moves * (self.y - self.W @ self.X) / self.sigma

    @property
    def _whitened(self) -> FloatArray:
        """Whitened regressor, (K n, p)."""
        weight = (self.moves / self.sigma)[:, :, None]
        return (self.W * weight).reshape(self.y.size, self.W.shape[2])

    @cached_property
    def basis(self) -> FloatArray:
        """Orthonormal basis (K, n, r) of the columns of the whitened model."""
        rows = self._whitened
        if rows.shape[1] == 0:
            return np.zeros((*self.y.shape, 0))
        norms = column_norms(rows)
        _, values, turn = np.linalg.svd(triangle(rows) / norms)
        kept = values > 1e-9 * values[0]
        left = rows @ (turn[kept].T / (norms[:, None] * values[kept]))
        return np.ascontiguousarray(left.reshape(*self.y.shape, -1))

    @cached_property
    def rank(self) -> int:
        """Rank of the regressor."""
        R = triangle(self._whitened)
        values = np.linalg.svd(R / column_norms(R), compute_uv=False)
        return int(np.count_nonzero(values > SINGULAR * values[:1]))

    @cached_property
    def size(self) -> FloatArray:
        """RMS of the measured torque in the band, (n,); 1 for a joint without torque."""
        found = rms(np.concatenate([log.unmasked.measured for log in self.logs]))
        found = bounded_deviation(found, found)
        return np.where(found > 0, found, 1.0)

    def with_columns(self, columns: Iterable[Columns]) -> WhitenedSystem:
        """Return the equations of the model with more columns."""
        more = [dense(c, self.y.shape) for c in columns]
        W = np.concatenate([self.W, *more], axis=2)
        return _solved(self.logs, W, self.y, self.moves) if more else self


def explained(system: WhitenedSystem, columns: Columns) -> FloatArray:
    """Return the part of the whitened residual that columns explain beside the model, (K, n)."""
    weight = (system.moves / system.sigma)[:, :, None]
    rows = (dense(columns, system.y.shape) * weight).reshape(system.y.size, -1)
    rows = rows / column_norms(rows)
    basis = system.basis.reshape(system.y.size, -1)
    left, values, _ = np.linalg.svd(rows - basis @ (basis.T @ rows), full_matrices=False)
    free = left[:, values > _FREE]
    return np.asarray((free @ (free.T @ system.residual.ravel())).reshape(system.y.shape))


def gain_of(system: WhitenedSystem, columns: Columns) -> float:
    """Return the share of the sum of squares of its joints that columns explain."""
    whole = float(np.sum(system.residual[:, list(columns)] ** 2))
    return float(np.sum(explained(system, columns) ** 2)) / whole if whole else 0.0


def fitted_system(evaluator: Evaluator, logs: Sequence[FilteredLog]) -> WhitenedSystem:
    """Fit the model to logs; columns that contain the model's torque are iterated a few times."""
    y = np.concatenate([log.unmasked.measured for log in logs])

    def fitted(X: FloatArray | None) -> WhitenedSystem:
        W = np.concatenate([torque_rows(evaluator, log.unmasked, X) for log in logs])
        return whitened(logs, W, y)

    found = fitted(None)
    base = evaluator.model.base
    for _ in range(SETTLING if base.linear < len(base.parameters) else 0):
        found = fitted(np.pad(found.X, (0, len(base.parameters) - len(found.X))))
    return found


def given_system(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray
) -> WhitenedSystem:
    """Return the equations for given parameters (p,): y is the residual, and W is empty."""
    model = partial(torque_at, evaluator, X)
    y = np.concatenate([log.unmasked.measured - modelled(log, model) for log in logs])
    return whitened(logs, np.zeros((*y.shape, 0)), y)


def torque_at(
    evaluator: Evaluator, X: FloatArray, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Return the model's torque at given states, (k, n)."""
    return np.asarray(evaluator["inverse_dynamics"](q, qd, qdd, X))


def model_torque(evaluator: Evaluator, X: FloatArray, log: FilteredLog) -> FloatArray:
    """Return the model's torque along a log at the full rate, (N, n)."""
    return torque_at(evaluator, X, log.q, log.qd, log.qdd)


def whitened(logs: Sequence[FilteredLog], W: FloatArray, y: FloatArray) -> WhitenedSystem:
    """Solve y = W X, with joints weighted by the standard deviation of their residual.

    Rows that static friction affects only determine what the other rows leave undetermined.
    """
    rows, still = _rows(logs), np.concatenate([static(log) for log in logs])
    found = _solved(logs, W, y, np.where(still, 0.0, rows))
    if not still.any():
        return found
    whole = replace(found, moves=rows)
    return found if found.rank == whole.rank else _solved(logs, W, y, rows)


def estimated(system: WhitenedSystem) -> WhitenedSystem:
    """Return the equations with all rows; rows at rest are weighted by their own residual.

    Their weight is the residual std of the joint in motion over that at rest, as in `identify`.
    """
    logs, W, y = system.logs, system.W, system.y
    still = np.concatenate([_resting(log) for log in logs])
    found = _solved(logs, W, y, _rows(logs))
    for _ in range(_WHITENING if still.any() else 0):
        left, free = y - W @ found.X, found.moves > 0
        weight = [rest_weight(left[counts, j], still[counts, j]) for j, counts in enumerate(free.T)]
        found = _solved(logs, W, y, np.where(still & free, weight, found.moves))
    return found


def _solved(
    logs: Sequence[FilteredLog], W: FloatArray, y: FloatArray, moves: FloatArray
) -> WhitenedSystem:
    """Solve y = W X with weights (K, n) of the rows."""
    joints = [
        Summary(triangle(moves[:, [j]] * np.column_stack([W[:, j], y[:, j]])), len(y))
        for j in range(y.shape[1])
    ]
    least = 1e-6 * float(np.sqrt(np.mean(y**2))) + _TINY  # a dead channel has no spread
    torque = rms(y)
    floor = np.maximum(1e-6 * torque, least * 1e-3)
    sigma = bounded_deviation(np.maximum(np.std(y, axis=0), least), torque)
    X = np.zeros(W.shape[2])
    for _ in range(_WHITENING):
        rows = np.concatenate([s.factor / size for s, size in zip(joints, sigma, strict=True)])
        X = shortest(rows)
        square = np.array([s.rss(X) for s in joints]) / np.maximum((moves**2).sum(axis=0), 1.0)
        sigma = bounded_deviation(np.maximum(np.sqrt(square), floor), torque)
    return WhitenedSystem(tuple(logs), W, y, X, sigma, moves)


def _resting(log: FilteredLog) -> Bools:
    """Return the kept rows that belong to rests, (K, n), as in `identify`."""
    if log.resting is None:
        return np.zeros((len(log.kept), log.tau.shape[1]), dtype=bool)
    return log.resting


def _rows(logs: Sequence[FilteredLog]) -> FloatArray:
    """Return the weight of the rows, (K, n).

    It is 1.0 where a joint moves faster than 0.5 % of its RMS speed, the weight of the band at
    rests, and 0.0 where the row is masked.
    """
    out = []
    for log in logs:
        weight = (np.abs(log.qd) > _REST * rms(log.qd))[log.kept].astype(float)
        if log.band.rests is not None:
            weight = np.where(_resting(log), log.band.rests.weight, weight)
        out.append(weight * log.clear[log.kept])
    return np.concatenate(out)
