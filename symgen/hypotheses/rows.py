"""The rows of a search: torque equations of logs, joint by joint, solved by weighted least squares.

Rows are the torque equations of `symgen.estimation.system`: one joint at one kept sample of the
comparison band. They are divided by the standard deviation of their joint's residual. Masked
samples have zero weight. So have reversals and rests, because friction is undefined there.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from symgen.data.mask import rms
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import SINGULAR, column_norms, shortest
from symgen.estimation.summary import Summary, bounded_deviation, triangle
from symgen.estimation.system import torque_at, torque_rows
from symgen.estimation.values import FloatArray
from symgen.hypotheses.score import TINY, Columns, dense
from symgen.runtime.evaluator import Evaluator

_WHITENING = 3  # rounds in which the weights of the joints follow their residuals
_EXACT = 1e-6  # smallest standard deviation of a joint's residual, as a part of its torque
_FREE = 1e-5  # a unit column is independent if more than this norm is orthogonal to the model
_REVERSAL = 0.005  # speed of a reversal, as a part of the RMS speed
SETTLING = 3  # rounds in which columns that contain the model's torque follow it


@dataclass(frozen=True, eq=False)
class Rows:
    """The rows of some logs, and the least-squares fit to them.

    Attributes:
        logs: logs in the band of the run.
        W: (K, n, p) regressor of the model at K kept samples.
        y: (K, n) torque, N m or N.
        X: (p,) least-squares parameters.
        sigma: (n,) standard deviation of each joint's residual.
        moves: (K, n) weight of the rows: 1.0 in motion; 0.0 at reversals, at rest and at masked
            samples.
        joints: summary of [W y] of each joint, with these weights.
    """

    logs: tuple[FilteredLog, ...]
    W: FloatArray
    y: FloatArray
    X: FloatArray
    sigma: FloatArray
    moves: FloatArray
    joints: tuple[Summary, ...]

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.y.shape[1])

    @property
    def residual(self) -> FloatArray:
        """Residual y - W X, (K, n)."""
        return self.y - self.W @ self.X

    @cached_property
    def whitened_residual(self) -> FloatArray:
        """Whitened residual (K, n)."""
        return self.moves * self.residual / self.sigma

    def whitened(self, columns: FloatArray) -> FloatArray:
        """Return columns (K, n, m) as rows of the fit, (K n, m)."""
        weight = (self.moves / self.sigma)[:, :, None]
        return (columns * weight).reshape(self.y.size, -1)

    def orthogonal_part(self, rows: FloatArray) -> FloatArray:
        """Return the part of whitened columns (K n, m) that is orthogonal to the model."""
        basis = self.basis.reshape(self.y.size, -1)
        return rows - basis @ (basis.T @ rows)

    @cached_property
    def basis(self) -> FloatArray:
        """Orthonormal basis (K, n, r) of the columns of the whitened model."""
        if self.W.shape[2] == 0:
            return np.zeros((*self.y.shape, 0))
        rows = self.whitened(self.W)
        norms = column_norms(rows)
        _, values, turn = np.linalg.svd(triangle(rows) / norms)
        kept = values > SINGULAR * values[0]
        basis = rows @ (turn[kept].T / (norms[:, None] * values[kept]))
        return np.ascontiguousarray(basis.reshape(*self.y.shape, -1))

    @property
    def rank(self) -> int:
        """Rank of the regressor."""
        return int(self.basis.shape[2])

    @cached_property
    def size(self) -> FloatArray:
        """RMS of the measured torque in the band, (n,); 1 for a joint without torque."""
        torque = rms(np.concatenate([log.unmasked.measured for log in self.logs]))
        torque = bounded_deviation(torque, torque)
        return np.where(torque > 0, torque, 1.0)

    def with_columns(self, columns: Iterable[Columns]) -> Rows:
        """Return the rows of the model with more columns."""
        added = [*columns]
        if not added:
            return self
        W = np.concatenate([self.W, *(dense(c, self.y.shape) for c in added)], axis=2)
        count, reached = W.shape[2] - self.W.shape[2], {j for c in added for j in c}
        # Most effects have non-zero columns on one joint only.
        joints = [
            _summary(W, self.y, self.moves, j) if j in reached else _widened(s, count)
            for j, s in enumerate(self.joints)
        ]
        return _weighted(replace(self, W=W, joints=tuple(joints)))


def explained(rows: Rows, columns: Columns) -> FloatArray:
    """Return the part of the whitened residual that columns explain after the model, (K, n)."""
    flat = rows.whitened(dense(columns, rows.y.shape))
    independent = rows.orthogonal_part(flat / column_norms(flat))
    basis, values, _ = np.linalg.svd(independent, full_matrices=False)
    free = basis[:, values > _FREE]
    return np.asarray((free @ (free.T @ rows.whitened_residual.ravel())).reshape(rows.y.shape))


def make_rows(
    evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray | None = None
) -> Rows:
    """Return the rows of a model on logs, with fixed or fitted parameters.

    Columns that contain the model's torque are iterated a few times.

    Args:
        evaluator: the compiled model.
        logs: logs in the band of the run.
        X: (p,) fixed parameters: then y is the residual, and W is empty. None to fit them.
    """
    y = np.concatenate([log.unmasked.measured for log in logs])
    if X is not None:
        model = partial(torque_at, evaluator, X)
        y = y - np.concatenate([log.unmasked.modelled(model) for log in logs])
        return fitted(logs, np.zeros((*y.shape, 0)), y)

    def at(X: FloatArray | None) -> Rows:
        W = np.concatenate([torque_rows(evaluator, log.unmasked, X) for log in logs])
        return fitted(logs, W, y)

    rows = at(None)
    base = evaluator.model.base
    for _ in range(SETTLING if base.linear < len(base.parameters) else 0):
        rows = at(np.pad(rows.X, (0, len(base.parameters) - len(rows.X))))
    return rows


def model_torque(evaluator: Evaluator, X: FloatArray, log: FilteredLog) -> FloatArray:
    """Return the model's torque along a log at the full rate, (N, n)."""
    return torque_at(evaluator, X, *log.motion)


def fitted(logs: Sequence[FilteredLog], W: FloatArray, y: FloatArray) -> Rows:
    """Solve y = W X, with joints weighted by the standard deviation of their residual.

    Rows that a rest of their joint affects are used only if the other rows lack rank.
    """
    moving = solved(logs, W, y, np.concatenate([_moving(log, 0.0) for log in logs]))
    if all(log.resting is None for log in logs):
        return moving
    moves = np.concatenate([_moving(log, 1.0) for log in logs])
    all_rows = replace(moving, moves=moves)
    return moving if moving.rank == all_rows.rank else solved(logs, W, y, moves)


def with_rests(rows: Rows) -> Rows:
    """Return rows in which rests have the weight that `identify` gives them."""
    if all(log.resting is None for log in rows.logs):
        return rows
    moves = []
    for log in rows.logs:
        moves.append(_moving(log, 1.0 if log.band.rests is None else log.band.rests.weight))
    return solved(rows.logs, rows.W, rows.y, np.concatenate(moves))


def solved(logs: Sequence[FilteredLog], W: FloatArray, y: FloatArray, moves: FloatArray) -> Rows:
    """Solve y = W X with weights (K, n) of the rows."""
    joints = tuple(_summary(W, y, moves, j) for j in range(y.shape[1]))
    X, sigma = np.zeros(W.shape[2]), np.ones(y.shape[1])
    return _weighted(Rows(tuple(logs), W, y, X, sigma, moves, joints))


def _summary(W: FloatArray, y: FloatArray, moves: FloatArray, j: int) -> Summary:
    """Return the summary of the rows of a joint."""
    return Summary(triangle(moves[:, [j]] * np.column_stack([W[:, j], y[:, j]])), len(y))


def _widened(s: Summary, count: int) -> Summary:
    """Return a summary with columns of zeros after the columns of the model."""
    zeros = np.zeros((len(s.factor), count))
    factor = np.concatenate([s.factor[:, :-1], zeros, s.factor[:, -1:]], axis=1)
    return replace(s, factor=factor)


def _weighted(rows: Rows) -> Rows:
    """Return rows with joints weighted by the standard deviation of their residual."""
    joints, y = rows.joints, rows.y
    torque, count = rms(y), np.maximum((rows.moves**2).sum(axis=0), 1.0)
    # A joint without torque takes its floor from the torque of all joints.
    floor = np.maximum(_EXACT * torque, _EXACT**2 * float(rms(y.ravel()[:, None])[0]) + TINY)
    sigma = bounded_deviation(np.maximum(np.std(y, axis=0), floor), torque)
    X = rows.X
    for _ in range(_WHITENING):
        X = shortest(
            np.concatenate([s.factor / size for s, size in zip(joints, sigma, strict=True)])
        )
        square = np.array([s.rss(X) for s in joints]) / count
        sigma = bounded_deviation(np.maximum(np.sqrt(square), floor), torque)
    return replace(rows, X=X, sigma=sigma)


def _moving(log: FilteredLog, rests: float | Sequence[float]) -> FloatArray:
    """Return the weights of rows (K, n): 1.0 in motion, 0.0 at reversals and where masked.

    Args:
        log: a log in the band of the run.
        rests: weight of the rows that a rest of their joint affects, one or (n,).
    """
    moves = (np.abs(log.qd) > _REVERSAL * rms(log.qd))[log.kept] & log.clear[log.kept]
    if log.resting is None:
        return moves.astype(float)
    return np.where(log.resting, log.clear[log.kept] * np.asarray(rests), moves * 1.0)
