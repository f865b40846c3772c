"""From filtered logs to linear systems y = W X: the models of energy, momentum and torque.

Energy (Gautier and Khalil 1988), one equation a window (t1, t2):

    integral qd^T tau dt = [h(t2) - h(t1)]^T X_inertial + [integral f dt]^T X_friction

with h the energy regressor and f the columns of friction power. Momentum, n equations a window:

    integral tau dt = {[p(t2) - p(t1)] - integral dL/dq dt} X_inertial + integral F dt X_friction

with p and dL/dq the columns of the momentum regressor and F those of friction torque. Neither needs
accelerations. Torque, n equations an instant: tau = W X, both sides through the low-pass of the
comparison band (Gautier's parallel filter).

Models are evaluated chunk by chunk at the nodes of a log. The band determines the spacing of the
nodes. Only the rows that an estimator needs are kept, some tens a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symgen.data.mask import Bools, untouched
from symgen.data.raw import Places
from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.features import Features
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.integrals import over_windows
from symgen.estimation.values import FloatArray
from symgen.estimation.windows import place_windows, window_rows
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True, eq=False)
class Equations:
    """Equations of one log: W (K, p), y (K,), t (K,) end of each window (or the sample) in s.

    `correlation` is the number of rows that share samples (overlapping windows). It is 0 for rows
    that are no time series, such as static poses. `joint` is the position of the joint, None for
    energy. y is in J, N m s or N m. `Z` are instruments, (K, p): the same rows along a motion
    without the noise in W. `rest` (K,) marks the rows that a rest of the joint affects. Their W and
    y are multiplied by `rest_weight`. `features` are random functions of the state along the same
    rows, (K, m), see `features.py`; None if the misfit is not estimated.
    """

    name: str
    W: FloatArray
    y: FloatArray
    t: FloatArray
    correlation: int
    joint: int | None = None
    Z: FloatArray | None = None
    rest: Bools | None = None
    rest_weight: float = 1.0
    features: FloatArray | None = None

    @property
    def rows(self) -> int:
        """Number of equations."""
        return len(self.y)

    @property
    def square(self) -> float:
        """Sum of the squares of y."""
        return float(np.sum(self.y**2))

    def rss(self, X: FloatArray) -> float:
        """Return the sum of the squares of y - W X."""
        return float(np.sum((self.y - self.W @ X) ** 2))

    @property
    def scale(self) -> FloatArray:
        """Factors of W and y in each row, (K,)."""
        if self.rest is None:
            return np.ones(len(self.y))
        return np.where(self.rest, self.rest_weight, 1.0)

    def with_rest_weight(self, weight: float) -> Equations:
        """Return the equations with another weight of rows at rest."""
        if self.rest is None or weight == self.rest_weight:
            return self
        change = np.where(self.rest, weight / self.rest_weight, 1.0)
        return replace(self.weighed(change), rest_weight=weight)

    def where(self, chosen: Bools | slice) -> Equations:
        """Return the chosen rows."""
        some: dict[str, Any] = {}
        for key in ("W", "y", "t", "Z", "rest", "features"):
            rows = getattr(self, key)
            some[key] = None if rows is None else rows[chosen]
        return replace(self, **some)

    def weighed(self, weight: FloatArray) -> Equations:
        """Return the equations with their rows multiplied by (K,) weights."""
        rows = weight[:, None]
        features = None if self.features is None else self.features * rows
        return replace(self, W=self.W * rows, y=self.y * weight, features=features)


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """The equations of every log and the names of the columns, as an estimator takes them."""

    names: tuple[str, ...]
    logs: tuple[Equations, ...]

    @property
    def W(self) -> FloatArray:
        """All regressor rows, (K, p)."""
        return np.concatenate([e.W for e in self.logs])

    def weighed(self, weights: Sequence[FloatArray]) -> LinearSystem:
        """Return the equations with their rows multiplied by weights, (K,) a log."""
        pairs = zip(self.logs, weights, strict=True)
        return replace(self, logs=tuple(e.weighed(w) for e, w in pairs))


def joint_equations(
    log: FilteredLog,
    W: FloatArray,
    y: FloatArray,
    t: FloatArray,
    correlation: int,
    features: FloatArray | None,
    rests: Bools | None,
    free: Bools | None,
) -> tuple[Equations, ...]:
    """Return equations from their rows, joint by joint.

    Args:
        log: the log of the rows.
        W: (m, K, p).
        y: (K, m).
        t: (K,) times of the rows, s.
        correlation: rows that share samples.
        features: (m, K, f) random functions of the state, or None.
        rests: (K, m) rows that a rest of their joint affects; None for none.
        free: (K, m) rows that no mask touches; None for all.
    """
    out = []
    for j, torque in enumerate(y.T):
        F = None if features is None else features[j]
        e = Equations(log.name, np.ascontiguousarray(W[j]), torque, t, correlation, j, features=F)
        if rests is not None and rests[:, j].any():
            assert log.band.rests is not None  # None only if no joint rests
            e = replace(e, rest=rests[:, j]).with_rest_weight(log.band.rests.weight[j])
        out.append(e if free is None else e.where(free[:, j]))
    return tuple(out)


def _energy_terms(
    evaluator: Evaluator, q: FloatArray, qd: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the columns of energy, (K, 1, p_inertial), and of friction power, (K, 1, p)."""
    h = evaluator.energy_regressor(q, qd)
    power = np.column_stack([np.zeros_like(h), evaluator.friction_power(q, qd)])
    return h[:, None], power[:, None]


def _momentum_terms(
    evaluator: Evaluator, q: FloatArray, qd: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the columns of momentum, (K, n, p_inertial), and of its rate of change, (K, n, p)."""
    momentum, slope = evaluator["momentum_regressor"](q, qd)
    rates = -slope
    if evaluator.has("friction_torque"):
        rates = np.concatenate([rates, evaluator["friction_torque"](q, qd)], axis=2)
    return momentum, rates


def _untouched(flags: Bools, first: Places, last: Places) -> Bools:
    """Return which windows (K, m) contain no flagged sample, for flags (N, m)."""
    return np.column_stack([untouched(column, first, last) for column in flags.T])


def window_equations(
    evaluator: Evaluator,
    log: FilteredLog,
    model: str,
    window: float,
    features: Features | None = None,
) -> tuple[Equations, ...]:
    """Build the equations of one log in sliding windows: one energy equation, or one for each
    joint.

    Args:
        evaluator: the compiled model.
        log: the log in the band of the run.
        model: energy or momentum.
        window: length of the windows, s.
        features: random functions of the state for the model misfit.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    w = place_windows(log, window)
    first, last = w.spans(len(log.t))

    energy = model == "energy"

    def terms(q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        state, rates = (_energy_terms if energy else _momentum_terms)(evaluator, q, qd)
        if features is None:
            return state, rates
        functions = features.powers(q, qd) if energy else features(q, qd)
        return state, np.concatenate([rates, functions], axis=2)

    rows = window_rows(terms, *log.nodes(w.stride), w, log.step)
    p = len(evaluator.model.base.names)
    signal = np.sum(log.qd * log.tau, axis=1, keepdims=True) if energy else log.tau
    y = over_windows(signal, log.step, last, w.steps * w.stride)
    F = None if features is None else rows[:, :, p:]
    resting, free = None, None
    if log.at_rest is not None and not energy:
        resting = ~_untouched(log.at_rest, first, last)
    if log.mask is not None:
        masked = log.mask.robot[:, None] if energy else log.mask.joint
        free = _untouched(masked, first, last)
    equations = joint_equations(
        log, rows[:, :, :p], y, log.t[last], w.correlation, F, resting, free
    )
    return tuple(replace(e, joint=None) for e in equations) if energy else equations


def torque_at(evaluator: Evaluator, X: FloatArray, *motion: FloatArray) -> FloatArray:
    """Return the model's torque (k, n) with parameters X (p,) at states.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        X: (p,) parameters.
        motion: the arrays of `FilteredLog.motion`, k states.
    """
    joints, base = motion[:3], motion[3:]
    return np.asarray(evaluator["inverse_dynamics"](*joints, X, *base))


def torque_columns(
    evaluator: Evaluator, motion: Sequence[FloatArray], X: FloatArray | None = None
) -> FloatArray:
    """Return the regressor W with tau = W X, (N, n, p).

    Effects that use the model's torque have no fixed column. symgen takes the derivative of the
    torque with respect to their coefficient at the given X. At the solution X the regressor is
    exact.

    Args:
        evaluator: the compiled model, with torque_regressor, and inverse_dynamics for such effects.
        motion: the arrays of `FilteredLog.motion`, N samples.
        X: (p,) at which the model's torque is taken; None leaves out these columns.
    """
    W: FloatArray = evaluator["torque_regressor"](*motion)
    base = evaluator.model.base
    if X is None or base.linear == len(base.parameters):
        return W
    rigid = np.concatenate([X[: base.linear], np.zeros(len(X) - base.linear)])
    at = torque_at(evaluator, rigid, *motion)
    units = np.eye(len(X))[base.linear :]
    columns = [torque_at(evaluator, rigid + unit, *motion) - at for unit in units]
    return np.concatenate([W, np.stack(columns, axis=2)], axis=2)


def torque_rows(evaluator: Evaluator, log: FilteredLog, X: FloatArray | None = None) -> FloatArray:
    """Return the torque regressor of a log in the comparison band, (K, n, p); see `log.measured`.

    Columns that are zero for every motion are not filtered.

    Args:
        evaluator: the compiled model, with the kernel torque_regressor.
        log: the log in the band of the run.
        X: (p,) at which effects use the model's torque, see `torque_columns`.
    """
    base = evaluator.model.base
    if log.mask is not None or (X is not None and base.linear < len(base.parameters)):
        return log.modelled(lambda *motion: torque_columns(evaluator, motion, X))
    kernel = evaluator["torque_regressor"]
    filled = list(kernel.kernel.filled[0])

    def entries(*motion: FloatArray) -> FloatArray:
        return np.asarray(kernel(*motion)).reshape(len(motion[0]), -1)[:, filled]

    out: FloatArray = np.zeros((len(log.kept), kernel.kernel.size))
    out[:, filled] = log.modelled(entries)
    return out.reshape(len(out), evaluator.model.robot.n, -1)


def torque_equations(
    evaluator: Evaluator,
    log: FilteredLog,
    X: FloatArray | None = None,
    features: Features | None = None,
    measured: FloatArray | None = None,
) -> tuple[Equations, ...]:
    """Build the torque equations of one log, joint by joint, in the comparison band.

    Args:
        evaluator, log, X: see `torque_rows`.
        features: random functions of the state for the model misfit.
        measured: `log.measured`, (K, n), if already known from another cutoff.
    """
    y = log.measured if measured is None else measured
    W = torque_rows(evaluator, log, X).transpose(1, 0, 2)
    correlation = 1 if log.rows.cutoff is None else PER_PERIOD // 2
    F = None if features is None else features.in_band(log.modelled).transpose(1, 0, 2)
    free = None if log.mask is None else log.free
    return joint_equations(log, W, y, log.compared_t, correlation, F, log.resting, free)
