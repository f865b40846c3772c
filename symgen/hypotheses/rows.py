"""The rows of a search: torque equations of logs, joint by joint, solved by weighted least squares.

Rows are the torque equations of `symgen.estimation.system`: one joint at one kept sample of the
comparison band. They are divided by the standard deviation of their joint's residual. Masked
samples have zero weight. So have reversals and rests, because friction is undefined there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial

import numpy as np

from symgen.data.mask import rms
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import (
    SINGULAR,
    column_norms,
    reweighted,
    shortest_of,
    weighted_triangle,
)
from symgen.estimation.summary import Summary, bounded_deviation, summarise
from symgen.estimation.system import Rows, join, torque_equations
from symgen.estimation.values import FloatArray
from symgen.hypotheses.score import TINY, Columns, dense
from symgen.runtime.evaluator import Evaluator

_WHITENING = 2  # rounds in which the weights of the joints follow their residuals
_EXACT = 1e-6  # smallest standard deviation of a joint's residual, as a part of its torque
_FREE = 1e-5  # a unit column is independent if more than this norm is orthogonal to the model
_REVERSAL = 0.005  # speed of a reversal, as a part of the RMS speed
SETTLING = 3  # rounds in which columns that contain the model's torque follow it


@dataclass(frozen=True, eq=False, kw_only=True)
class FittedRows(Rows):
    """The rows of some logs, and the least-squares fit to them.

    The weight of a row is 1.0 in motion, and 0.0 at reversals, at rest and at masked samples.

    Attributes:
        logs: logs in the band of the run.
        X: (p,) least-squares parameters.
        sigma: (m,) standard deviation of the residual of each equation.
        joints: summary of the weighted [W y] of each equation.

    An equation is that of a joint, or of a floating base, which come first: m = n + 6. Else m = n.
    """

    logs: tuple[FilteredLog, ...]
    X: FloatArray
    sigma: FloatArray
    joints: tuple[Summary, ...]

    @property
    def residual(self) -> FloatArray:
        """Residual y - W X, (K, n)."""
        return self.y - self.W @ self.X

    @cached_property
    def whitened_residual(self) -> FloatArray:
        """Whitened residual (K, n)."""
        return self.weight * self.residual / self.sigma

    def whitened(self, columns: FloatArray) -> FloatArray:
        """Return columns (K, n, m) as rows of the fit, (K n, m)."""
        weight = (self.weight / self.sigma)[:, :, None]
        return (columns * weight).reshape(self.y.size, -1)

    def orthogonal_part(self, rows: FloatArray) -> FloatArray:
        """Return the part of whitened columns (K n, m) that is orthogonal to the model."""
        basis = self.basis.reshape(self.y.size, -1)
        return rows - basis @ (basis.T @ rows)

    @cached_property
    def directions(self) -> FloatArray:
        """Matrix (p, r) from the whitened model to an orthonormal basis of its columns."""
        R = weighted_triangle(self.joints, 1 / self.sigma)[:, :-1]
        if not R.size:
            return np.zeros((R.shape[1], 0))
        norms = column_norms(R)
        _, values, turn = np.linalg.svd(R / norms)
        kept = values > SINGULAR * values[0]
        return np.asarray((turn[kept] / norms).T / values[kept])

    @cached_property
    def basis(self) -> FloatArray:
        """Orthonormal basis (K, n, r) of the columns of the whitened model."""
        basis = self.whitened(self.W) @ self.directions
        return np.ascontiguousarray(basis.reshape(*self.y.shape, -1))

    @property
    def rank(self) -> int:
        """Rank of the regressor."""
        return int(self.directions.shape[1])

    @property
    def measured(self) -> FloatArray:
        """Measured torque in the band, (K, n)."""
        return np.concatenate([log.unmasked.measured for log in self.logs])

    @cached_property
    def size(self) -> FloatArray:
        """RMS of the measured torque in the band, (m,); 1 for a joint without torque. The forces on
        a floating base have one size, and so have the moments on it.
        """
        torque = rms(self.measured)
        for first in range(0, self.logs[0].base_rows, 3):
            torque[first : first + 3] = rms(torque[first : first + 3])
        torque = bounded_deviation(torque, torque)
        return np.where(torque > 0, torque, 1.0)

    def with_torque(self, factors: FloatArray) -> FittedRows:
        """Return the fit to torques that are multiplied by factors, (n,)."""
        joints = [*map(Summary.of_scaled, self.joints, factors)]
        return _whitened(self.logs, replace(self, y=self.y * factors), joints)

    def with_columns(self, columns: Iterable[Columns]) -> FittedRows:
        """Return the rows of the model with more columns."""
        added = [*columns]
        if not added:
            return self
        more = [dense(c, self.y.shape) for c in added]
        rows = self.with_regressor(np.concatenate([self.W, *more], axis=2))
        count = len(rows.names) - len(self.names)
        # Most effects have non-zero columns on one joint only.
        reached, joints = {j for c in added for j in c}, []
        for j, s in enumerate(self.joints):
            joints.append(_of_joint(rows, j) if j in reached else _widened(s, count))
        return _whitened(self.logs, rows, joints, 1 / self.sigma)


def explained(rows: FittedRows, columns: Columns) -> FloatArray:
    """Return the part of the whitened residual that columns explain after the model, (K, n)."""
    flat = rows.whitened(dense(columns, rows.y.shape))
    independent = rows.orthogonal_part(flat / column_norms(flat))
    basis, values, _ = np.linalg.svd(independent, full_matrices=False)
    free = basis[:, values > _FREE]
    along = free.T @ rows.whitened_residual.ravel()
    return np.asarray((free @ along).reshape(rows.y.shape))


def make_rows(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray | None = None
) -> FittedRows:
    """Return the rows of a model on logs, with fixed or fitted parameters.

    Columns that contain the model's torque are iterated a few times.

    Args:
        evaluator: the compiled model.
        logs: logs in the band of the run.
        X: (p,) fixed parameters: then y is the residual, and W is empty. None to fit them.
    """

    def at(X: FloatArray | None) -> Rows:
        return join([torque_equations(evaluator, log.unmasked, X) for log in logs])

    if X is not None:
        known = at(X)
        remaining = replace(known, y=known.y - known.W @ X)
        return fitted(logs, remaining.with_regressor(known.W[:, :, :0]))
    rows = fitted(logs, at(None))
    base = evaluator.model.base
    for _ in range(SETTLING if base.linear < len(base.parameters) else 0):
        missing = len(base.parameters) - len(rows.X)
        rows = fitted(logs, at(np.pad(rows.X, (0, missing))))
    return rows


def fitted(logs: Sequence[FilteredLog], rows: Rows) -> FittedRows:
    """Solve y = W X, with joints weighted by the standard deviation of their residual.

    Rows that a rest of their joint affects are used only if the other rows lack rank.

    Args:
        logs: the logs of the rows.
        rows: the rows; their weights are replaced.
    """
    moving = _solved(logs, rows, 0.0)
    full = moving.rank == len(moving.X)
    if full or all(log.resting is None for log in logs):
        return moving
    every = _solved(logs, rows, 1.0)
    return moving if moving.rank == every.rank else every


def rest_weights(rows: FittedRows) -> FloatArray:
    """Return the weights of rows (K, n) in which rests have the weight of `identify`."""
    return np.concatenate([_moving(log, log.rest_weight(log.resting)) for log in rows.logs])


def _solved(logs: Sequence[FilteredLog], rows: Rows, rests: float) -> FittedRows:
    """Solve y = W X with a weight of rows at rest."""
    weight = np.concatenate([_moving(log, rests) for log in logs])
    weighted = replace(rows, weight=weight)
    joints = [_of_joint(weighted, j) for j in range(weight.shape[1])]
    return _whitened(logs, weighted, joints)


def _of_joint(rows: Rows, j: int) -> Summary:
    """Return the summary of the rows of a joint in all logs."""
    return summarise(rows.part(slice(None), j))


def _widened(s: Summary, count: int) -> Summary:
    """Return a summary with columns of zeros after the columns of the model."""
    W, y = np.hsplit(s.factor, [-1])
    zeros = np.zeros((len(W), count))
    return replace(s, factor=np.hstack([W, zeros, y]))


def _whitened(
    logs: Sequence[FilteredLog],
    rows: Rows,
    joints: Sequence[Summary],
    near: FloatArray | None = None,
) -> FittedRows:
    """Solve with joints weighted by the standard deviation of their residual.

    Args:
        logs: the logs of the rows.
        rows, joints: the rows, and the summary of those of each joint.
        near: (n,) weights of a fit with fewer columns, which save a round; None if there is none.
    """
    y, torque = rows.y, rms(rows.y)
    count = np.maximum((rows.weight**2).sum(axis=0), 1.0)
    # A joint without torque takes its floor from the torque of all joints.
    of_all = math.sqrt(float(np.mean(y**2)))
    floor = np.maximum(_EXACT * torque, _EXACT**2 * of_all + TINY)

    def inverse(deviation: FloatArray) -> FloatArray:
        return 1 / bounded_deviation(np.maximum(deviation, floor), torque)

    def weigh(X: FloatArray) -> FloatArray:
        squares = np.array([s.rss(X) for s in joints])
        return inverse(np.sqrt(squares / count))

    first = inverse(np.std(y, axis=0)) if near is None else near
    rounds = _WHITENING - (near is not None)
    _, X = reweighted(partial(shortest_of, joints), weigh, first, rounds)
    known = {field.name: getattr(rows, field.name) for field in fields(Rows)}
    sigma = 1 / weigh(X)
    return FittedRows(**known, logs=tuple(logs), X=X, sigma=sigma, joints=tuple(joints))


def _moving(log: FilteredLog, rests: float | FloatArray) -> FloatArray:
    """Return the weights of rows (K, n): 1.0 in motion, 0.0 at reversals and where masked.

    Args:
        log: a log in the band of the run.
        rests: weight of the rows that a rest of their joint affects, one or (K, m).
    """
    speed, clear = np.abs(log.qd[log.kept]), log.clear[log.kept]
    moves = speed > _REVERSAL * rms(log.qd)
    moves = clear * np.pad(moves, ((0, 0), (log.base_rows, 0)), constant_values=True)
    if log.resting is None:
        return moves.astype(float)
    return np.where(log.resting, clear * rests, moves)
