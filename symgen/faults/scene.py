"""The torque equations of all logs, and the model fitted to them, in which causes compete."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import rms
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.predictive_score import Columns, PredictiveScore, dense, motion_folds
from symgen.estimation.summary import Blocks
from symgen.estimation.system import torque_rows
from symgen.estimation.values import FloatArray
from symgen.runtime.evaluator import Evaluator
from symgen.symbolic.variation import Variation, variation

#: Returns values (k, ...) from q, qd, qdd, (k, n) each.
State = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
#: States that are evaluated at once: in fewer, a tape's calls cost more than its arithmetic.
_TOGETHER = 2048
_STATES = 200  # number of states for the mean of an inertia


@dataclass(frozen=True, eq=False)
class Rows:
    """The torque equations of all logs, in the comparison band.

    Attributes:
        evaluator: the compiled model.
        logs: training logs, then validation logs.
        train: number of the training logs.
        misfit: smallest model error to expect, as a part of a joint's torque.
    """

    evaluator: Evaluator
    logs: tuple[FilteredLog, ...]
    train: int
    misfit: float

    @cached_property
    def W(self) -> FloatArray:
        """(K, n, p) regressor of the model."""
        return np.concatenate([torque_rows(self.evaluator, log.unmasked) for log in self.logs])

    @cached_property
    def y(self) -> FloatArray:
        """(K, n) measured torque."""
        return np.concatenate([log.unmasked.measured for log in self.logs])

    @cached_property
    def weight(self) -> FloatArray:
        """(K, n) 1.0 for rows that count: out of reach of masked samples, and not at rest."""
        clear = [log.clear[log.kept] for log in self.logs]
        rests = [log.resting for log in self.logs]
        counts = [c if r is None else c & ~r for c, r in zip(clear, rests, strict=True)]
        return np.concatenate(counts).astype(float)

    @cached_property
    def size(self) -> FloatArray:
        """(n,) RMS of the measured torque."""
        found = rms(self.y)
        return np.where(found > 0, found, 1.0)

    @cached_property
    def fold(self) -> NDArray[np.intp]:
        """(K,) fold of each row."""
        return motion_folds(self.logs)

    @cached_property
    def t(self) -> FloatArray:
        """(K,) time of each row in its log, scaled to 0 .. 1."""
        parts = [log.compared_t for log in self.logs]
        return np.concatenate([(t - t[0]) / max(t[-1] - t[0], 1e-300) for t in parts])

    def along(self, state: State, together: int = _TOGETHER, *, smooth: bool = False) -> FloatArray:
        """Return a function (k, ...) of q, qd, qdd in the comparison band, (K, ...).

        Args:
            state: the function.
            together: approximate number of states that are evaluated at once.
            smooth: whether the function contains no sign(qd); then fewer states are needed.
        """
        parts = (
            log.unmasked.modelled(state, together, log.smooth_stride if smooth else None)
            for log in self.logs
        )
        return np.concatenate([x for part in parts for _, x in part])

    def held(self, weight: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Return a function (k, n, ...) of q alone in the comparison band, (K, n, ...)."""
        shape = weight(self.logs[0].q[:1]).shape[1:]

        def flat(q: FloatArray) -> FloatArray:
            return weight(q).reshape(len(q), -1)

        parts = [x for log in self.logs for _, x in log.unmasked.held(flat)]
        return np.concatenate(parts).reshape(-1, *shape)

    @cached_property
    def at_rest(self) -> FloatArray:
        """(K, n, p) regressor of the weight: inertial columns at zero speed and acceleration."""
        regressor, inertial = self.evaluator["torque_regressor"], self.evaluator.model.inertial

        def weight(q: FloatArray) -> FloatArray:
            out = np.array(regressor(q, 0 * q, 0 * q))
            out[:, :, inertial:] = 0.0
            return out

        return self.held(weight)

    @cached_property
    def waves(self) -> FloatArray:
        """(K, n, 2 WAVES) random functions of the state, which stand for what a model misses."""
        known = features_of(self.logs, self.evaluator.model.robot.sigma)
        return self.along(lambda q, qd, _: known(q, qd))

    def turned(self, signs: FloatArray) -> Rows:
        """Return the rows with torques multiplied by signs (n,)."""
        out = replace(self)
        out.__dict__.update(W=self.W, y=self.y * signs, weight=self.weight, fold=self.fold)
        return out

    def with_torques(self, logs: tuple[FilteredLog, ...]) -> Rows:
        """Return the rows with torques of logs of the same motion; rows must count in both."""
        out = replace(self, logs=logs)
        same = all(a.q is b.q and a.qd is b.qd for a, b in zip(logs, self.logs, strict=True))
        clear = np.concatenate([log.clear[log.kept] for log in logs])
        out.__dict__.update(fold=self.fold, weight=self.weight * clear)
        if same:
            out.__dict__.update(W=self.W)
        return out

    @cached_property
    def variation(self) -> Variation:
        """The links with variable gravity and lengths."""
        return variation(replace(self.evaluator.model.robot, sought=()))


@dataclass(frozen=True, eq=False)
class Scene:
    """The model fitted to its rows, with columns of missing physics.

    Attributes:
        rows: the torque equations.
        physics: columns without a name.
    """

    rows: Rows
    physics: tuple[Columns, ...] = ()

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.rows.evaluator.model.robot.n

    @property
    def driven(self) -> list[int]:
        """The joints that motors drive: the others have no torque that could be wrong."""
        passive = self.rows.evaluator.model.robot.passive
        return [j for j in range(self.n) if j not in passive]

    @property
    def compared(self) -> list[int]:
        """The joints whose torque can be compared with that of other driven joints."""
        return self.driven if len(self.driven) > 1 else []

    def blocks(self, W: FloatArray, weight: FloatArray) -> Blocks:
        """Return the products of a regressor (K, n, p) and the torque, by joint."""
        rows = np.concatenate([W, self.rows.y[:, :, None]], axis=2) * weight[:, :, None]
        by_joint = np.ascontiguousarray(rows.transpose(1, 0, 2))
        grams = by_joint.swapaxes(1, 2) @ by_joint
        return Blocks(grams[None], (weight**2).sum(axis=0)[None])

    def fitted(self, blocks: Blocks) -> tuple[FloatArray, FloatArray]:
        """Return X (p,) and the standard deviation of each joint's residual, (n,)."""
        X = blocks.fit()
        left = blocks.errors([0], X) / np.maximum(blocks.rows[0], 1.0)
        return X, np.maximum(np.sqrt(left), 1e-6 * self.rows.size)

    def scored(self, W: FloatArray, weight: FloatArray | None = None) -> PredictiveScore:
        """Fit a model with regressor (K, n, p) and return the score of columns beside it."""
        rows = self.rows
        weight = rows.weight if weight is None else weight
        W = np.concatenate([W, *(dense(c, rows.y.shape) for c in self.physics)], axis=2)
        X, sigma = self.fitted(self.blocks(W, weight))
        return PredictiveScore(W, rows.y - W @ X, weight, sigma, rows.fold, rows.misfit * rows.size)

    @cached_property
    def score(self) -> PredictiveScore:
        """The predictive score of columns beside the model."""
        return self.scored(self.rows.W)

    @property
    def worst(self) -> float:
        """Largest torque error on a fold, with fits to the other folds; 0.0 without torque.

            max over folds of RMS(error of the fold) / RMS(torque of all folds)

        Where a motion needs little torque, a small error is a large part of it, but no worse.
        """
        rows, torque = self.rows.weight**2, (self.rows.y * self.rows.weight) ** 2
        left = self.score.squares.sum(axis=0)
        of_fold = np.array([rows[self.rows.fold == f].sum() for f in range(len(left))])
        mean = float(torque.sum() / max(rows.sum(), 1e-300))
        worst = np.max(left / np.maximum(of_fold, 1.0), initial=0.0)
        return math.sqrt(worst / mean) if mean else 0.0

    @cached_property
    def model(self) -> FloatArray:
        """(K, n) torque of the model."""
        return self.rows.y - self.score.residual

    @cached_property
    def X(self) -> FloatArray:
        """(p,) least-squares parameters of the model, all logs together."""
        return self.fitted(self.blocks(self.rows.W, self.rows.weight))[0]

    @property
    def whole(self) -> FloatArray:
        """(p,) the same; 0.0 for parameters in which the model is not linear."""
        return np.pad(self.X, (0, len(self.rows.evaluator.model.base.parameters) - len(self.X)))

    def torque(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Return the model's torque, (k, n)."""
        evaluator = self.rows.evaluator
        if evaluator.has("inverse_dynamics"):  # a tenth of the time of the regressor
            return np.asarray(evaluator["inverse_dynamics"](q, qd, qdd, self.whole))
        return np.asarray(evaluator["torque_regressor"](q, qd, qdd))[:, :, : len(self.X)] @ self.X


def mean_friction_power(
    evaluator: Evaluator, logs: Sequence[FilteredLog], states: int = _STATES
) -> tuple[FloatArray, FloatArray]:
    """Return the mean power that friction takes from each joint, and the RMS of its speed.

        mean of qd_j W_j, W_j the columns of friction

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the logs with the motion.
        states: smallest number of states for the mean.

    Returns:
        (n, p) by base parameter, 0.0 for others than friction; (n,) rad/s or m/s.
    """
    q, qd = (np.concatenate([getattr(log, key)[log.kept] for log in logs]) for key in ("q", "qd"))
    every = slice(None, None, max(1, len(q) // states))
    q, qd = (np.ascontiguousarray(x[every]) for x in (q, qd))
    W = np.array(evaluator["torque_regressor"](q, qd, np.zeros_like(q)))
    W[:, :, : evaluator.model.inertial] = 0.0
    offsets = [b.name.startswith("OF") for b in evaluator.model.base.parameters][: W.shape[2]]
    W[:, :, offsets] = 0.0  # an offset does not dissipate
    return np.mean(W * qd[:, :, None], axis=0), rms(qd)


def mean_inertia(evaluator: Evaluator, logs: Sequence[FilteredLog], j: int) -> FloatArray:
    """Return the mean derivative of the inertia about joint j by the base parameters, (p,)."""
    q = np.concatenate([log.q[log.kept] for log in logs])
    q = np.ascontiguousarray(q[:: max(1, len(q) // _STATES)])
    regressor, zero = evaluator["torque_regressor"], np.zeros_like(q)
    one = zero.copy()
    one[:, j] = 1.0
    return np.asarray(np.mean((regressor(q, zero, one) - regressor(q, zero, zero))[:, j], axis=0))
