"""From filtered logs to linear systems y = W X: the models of energy, momentum and torque.

Energy (Gautier and Khalil 1988), one equation a window (t1, t2):

    integral qd^T tau dt = [h(t2) - h(t1)]^T X_inertial + [integral f dt]^T X_friction

with h the energy regressor and f the columns of friction power. Momentum, n equations a window:

    integral tau dt = {[p(t2) - p(t1)] - integral dL/dq dt} X_inertial + integral F dt X_friction

with p and dL/dq the columns of the momentum regressor and F those of friction torque. Neither needs
accelerations. On a floating base, momentum has six more equations, and energy the work of measured
forces, both in a frame that falls freely (`falling.py`). Torque, n equations (n + 6 on such a base)
an instant: tau = W X, both sides through the low-pass of the
comparison band (Gautier's parallel filter).

Models are evaluated chunk by chunk at the nodes of a log. The band determines the spacing of the
nodes. Only the rows that an estimator needs are kept, some tens a second.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from symgen.data.mask import untouched
from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.falling import FreeFall, free_fall
from symgen.estimation.features import Features
from symgen.estimation.filtered_log import FilteredLog, Nodes, spans_of
from symgen.estimation.floating import projected
from symgen.estimation.values import FloatArray
from symgen.estimation.windows import over_windows, place_windows, rates_only, window_rows
from symgen.runtime.evaluator import Evaluator


class Extent(NamedTuple):
    """Number of times of a log, and of rows that share samples; 0 if they are no time series."""

    times: int
    correlation: int


@dataclass(frozen=True, eq=False)
class Equations:
    """The weighted equations y = W X of one joint in one log, without those of zero weight.

    Attributes:
        W: (k, p).
        y: (k,).
        correlation: number of rows that share samples, see `Extent`.
        joint: position of the joint, None for energy.
        Z: (k, p) instruments, or None.
        features: (k, f) random functions of the state, or None.
        shared: whether its errors are correlated with those of the equations before, of the same
            samples.
    """

    W: FloatArray
    y: FloatArray
    correlation: int = 1
    joint: int | None = None
    Z: FloatArray | None = None
    features: FloatArray | None = None
    shared: bool = False

    @property
    def rows(self) -> int:
        """Number of equations."""
        return len(self.y)

    @property
    def square(self) -> float:
        """Sum of the squares of y."""
        return float(np.sum(self.y**2))

    def residual(self, X: FloatArray) -> FloatArray:
        """Return y - W X, (k,)."""
        return self.y - self.W @ X

    def rss(self, X: FloatArray) -> float:
        """Return the sum of the squares of y - W X."""
        return float(np.sum(self.residual(X) ** 2))

    def weighed(self, weight: FloatArray) -> Equations:
        """Return the equations multiplied by (k,) weights."""
        rows = weight[:, None]
        features = None if self.features is None else self.features * rows
        return replace(self, W=self.W * rows, y=self.y * weight, features=features)


@dataclass(frozen=True, eq=False)
class Rows:
    """Equations y = W X of some logs: at K times, one row for each of m joints, or for energy.

    Attributes:
        names: (p,) names of the columns.
        W: (K, m, p).
        y: (K, m), in N m or N of a joint, N m s or N s, or J.
        t: (K,) end of each window, or time of the sample, s.
        weight: (K, m) weight of each residual. It is 0 where a mask excludes the row, and that of
            the band where the joint rests.
        extents: number of times of each log, in the order of the rows.
        energy: whether the rows are those of energy.
        Z: (K, m, p) instruments: the same rows along a motion without the noise in W.
        features: (K, m, f) random functions of the state along the rows, see `features.py`; None if
            the misfit is not estimated.
        shared: whether the errors of the equations of a sample are correlated, as on a floating
            base: noise of its motion and projected noise are in all of them.
    """

    names: tuple[str, ...]
    W: FloatArray
    y: FloatArray
    t: FloatArray
    weight: FloatArray
    extents: tuple[Extent, ...]
    energy: bool = False
    Z: FloatArray | None = None
    features: FloatArray | None = None
    shared: bool = False

    @property
    def count(self) -> int:
        """Number of rows with a weight."""
        return int(np.count_nonzero(self.weight))

    @property
    def spans(self) -> list[slice]:
        """The place of each log."""
        return spans_of(extent.times for extent in self.extents)

    @property
    def parts(self) -> list[Equations]:
        """The equations of each log and joint."""
        return list(self.each_part())

    def each_part(self) -> Iterator[Equations]:
        """Yield the equations of each log and joint, of which memory need not hold all."""
        for at, extent in zip(self.spans, self.extents, strict=True):
            for j in range(self.y.shape[1]):
                yield self.part(at, j, extent.correlation)

    def part(self, at: slice, j: int, correlation: int = 1) -> Equations:
        """Return the equations of one joint in a span of rows."""
        weight = self.weight[at, j]
        used, even = weight != 0, (weight == 1).all()

        def of(x: FloatArray) -> FloatArray:
            rows = x[at, j]
            return rows if even else (rows[used].T * weight[used]).T

        Z = None if self.Z is None else of(self.Z)
        features = None if self.features is None else of(self.features)
        joint = None if self.energy else j
        shared = self.shared and j > 0
        return Equations(of(self.W), of(self.y), correlation, joint, Z, features, shared)

    def with_regressor(self, W: FloatArray) -> Rows:
        """Return the rows with another regressor, (K, m, p); numbers name its columns."""
        numbers = range(W.shape[2])
        return replace(self, names=tuple(map(str, numbers)), W=W)

    def weighed(self, weight: FloatArray) -> Rows:
        """Return the rows with their residuals multiplied by weights, (K, m) or (K, 1)."""
        return replace(self, weight=self.weight * weight)


def join(logs: Sequence[Rows]) -> Rows:
    """Return the rows of several logs as one."""
    first = logs[0]
    if len(logs) == 1:
        return first
    joined: dict[str, Any] = {}
    for key in ("W", "y", "t", "weight", "Z", "features"):
        parts = [getattr(log, key) for log in logs]
        joined[key] = None if any(x is None for x in parts) else np.concatenate(parts)
    extents = tuple(itertools.chain.from_iterable(log.extents for log in logs))
    return replace(first, extents=extents, **joined)


def _energy_terms(
    evaluator: Evaluator, q: FloatArray, qd: FloatArray, *base: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the columns of energy, (K, 1, p_inertial), and their slopes that no torque makes with
    the columns of friction power, (K, 1, p). `base` is v and w of a floating base.
    """
    h = evaluator["energy_regressor"](*kernel_inputs((q, qd, *base)))
    power = np.column_stack([np.zeros_like(h), evaluator.friction_power(q, qd)])
    return h[:, None], power[:, None]


def _momentum_terms(
    evaluator: Evaluator, q: FloatArray, qd: FloatArray, *base: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the columns of momentum, (K, m, p_inertial), and of dL/dq and friction torque, (K, m,
    p). `base` is v and w of a floating base.
    """
    momentum, rates = evaluator["momentum_regressor"](*kernel_inputs((q, qd, *base)))
    if evaluator.has("friction_torque"):
        friction = evaluator["friction_torque"](q, qd)
        above = momentum.shape[1] - friction.shape[1]
        rows = np.pad(friction, ((0, 0), (above, 0), (0, 0)))
        rates = np.concatenate([rates, rows], axis=2)
    return momentum, rates


#: Returns the equations of a log with their columns, see `torque_equations`.
Filling = Callable[[Evaluator, Features | None], Rows]


def window_filling(log: FilteredLog, model: str, window: float) -> Filling:
    """Return the equations of one log in sliding windows, without their columns: one energy
    equation, or one for each joint, behind those of a floating base. The log itself is not kept.

    Args:
        log: the log in the band of the run.
        model: energy or momentum.
        window: length of the windows, s.

    Raises:
        IdentificationError: the window does not fit the log, or a force on a floating base is
            unknown.
    """
    w = place_windows(log, window)
    step = log.step
    first, last = w.spans(len(log.t))
    t = log.t[last]
    q, qd = log.nodes(w.stride)
    energy = model == "energy"
    columns = _energy_terms if energy else _momentum_terms
    base = free_fall(log) if log.base_rows else None
    count = 1 if base else None  # each window has its own frame

    def signal(at: slice) -> FloatArray:
        if not energy:
            return log.tau[at]
        speeds = np.hstack([*(base.speeds(at) if base else ()), log.qd[at]])
        return np.asarray(np.sum(speeds * log.tau[at], axis=1, keepdims=True))

    y = over_windows(signal, len(log.t), w, step, count)
    weight = np.ones(y.shape)
    if log.at_rest is not None and not energy:
        weight *= log.rest_weight(~untouched(log.at_rest, first, last))
    if log.mask is not None:
        masked = log.mask.robot[:, None] if energy else log.mask.joint
        weight *= untouched(masked, first, last)
    extents = (Extent(len(y), w.correlation),)
    base_rows = log.base_rows
    fall = base and FreeFall(*(np.ascontiguousarray(x[:: w.stride]) for x in base))

    def filled(evaluator: Evaluator, features: Features | None) -> Rows:
        integrated = partial(window_rows, len(q), w, step)

        def terms(at: slice) -> tuple[FloatArray, FloatArray]:
            return columns(evaluator, q[at], qd[at], *(fall.speeds(at) if fall else ()))

        W, F = integrated(terms, count), None
        if features is not None:
            of_equations = partial(features.of_equations, base_rows=base_rows)
            functions = features.powers if energy else of_equations
            F = integrated(rates_only(lambda at: functions(q[at], qd[at])))
        names, shared = evaluator.model.base.names, base_rows > 0
        return Rows(names, W, y, t, weight, extents, energy, features=F, shared=shared)

    return filled


def torque_at(evaluator: Evaluator, X: FloatArray, *motion: FloatArray) -> FloatArray:
    """Return the model's torque (k, n) with parameters X (p,) at states.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        X: (p,) parameters.
        motion: the arrays of `FilteredLog.motion`, k states.
    """
    joints, base = kernel_inputs(motion[:3]), motion[3:]
    return np.asarray(evaluator["inverse_dynamics"](*joints, X, *base))


def kernel_inputs(motion: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the arrays of a motion that kernels take: a robot without joints has no q."""
    return [x for x in motion if x.shape[1]]


def torque_along(evaluator: Evaluator, X: FloatArray, log: FilteredLog) -> FloatArray:
    """Return the model's torque along a log at the full rate, (N, m), as measured in `log.tau`."""
    torque = torque_at(evaluator, X, *map(np.ascontiguousarray, log.motion))
    return projected(torque, log.contacts())


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
    W: FloatArray = evaluator["torque_regressor"](*kernel_inputs(motion))
    base = evaluator.model.base
    if X is None or base.linear == len(base.parameters):
        return W
    effects = np.arange(len(X)) >= base.linear
    rigid = np.where(effects, 0.0, X)
    at = torque_at(evaluator, rigid, *motion)
    units = np.eye(len(X))[effects]
    columns = [torque_at(evaluator, rigid + unit, *motion) - at for unit in units]
    return np.concatenate([W, np.stack(columns, axis=2)], axis=2)


def torque_rows(evaluator: Evaluator, nodes: Nodes, X: FloatArray | None = None) -> FloatArray:
    """Return the torque regressor of a log in the comparison band, (K, n, p); see `log.measured`.

    Columns that are zero for every motion are not filtered.

    Args:
        evaluator: the compiled model, with the kernel torque_regressor.
        nodes: the log in the band of the run, at its nodes.
        X: (p,) at which effects use the model's torque, see `torque_columns`.
    """
    base = evaluator.model.base
    changed = nodes.weight is not None or nodes.contacts is not None
    if changed or (X is not None and base.linear < len(base.parameters)):
        return nodes.modelled(lambda *motion: torque_columns(evaluator, motion, X))
    kernel = evaluator["torque_regressor"]
    filled = list(kernel.kernel.filled[0])

    def entries(*motion: FloatArray) -> FloatArray:
        return np.asarray(kernel(*kernel_inputs(motion))).reshape(len(motion[0]), -1)[:, filled]

    out: FloatArray = np.zeros((len(nodes.rows.kept), kernel.kernel.size))
    out[:, filled] = nodes.modelled(entries)
    return out.reshape(len(out), len(evaluator.model.robot.kinds), -1)


def torque_filling(
    log: FilteredLog, X: FloatArray | None, measured: FloatArray | None = None
) -> Filling:
    """Return the torque equations of one log without their columns, see `torque_equations`. The
    log itself is not kept.
    """
    y = log.measured if measured is None else measured
    t, nodes = log.compared_t, log.at_nodes()
    correlation = 1 if log.rows.cutoff is None else PER_PERIOD // 2
    weight = log.rest_weight(log.resting) * log.free
    extents, shared = (Extent(len(y), correlation),), log.base_rows > 0

    def filled(evaluator: Evaluator, features: Features | None) -> Rows:
        W = torque_rows(evaluator, nodes, X)
        F = None if features is None else features.in_band(nodes)
        names = evaluator.model.base.names[: W.shape[2]]
        return Rows(names, W, y, t, weight, extents, features=F, shared=shared)

    return filled


def torque_equations(
    evaluator: Evaluator,
    log: FilteredLog,
    X: FloatArray | None = None,
    features: Features | None = None,
    measured: FloatArray | None = None,
) -> Rows:
    """Build the torque equations of one log in the comparison band.

    Args:
        evaluator, X: see `torque_rows`.
        log: the log in the band of the run.
        features: random functions of the state for the model misfit.
        measured: `log.measured`, (K, n), if already known from another cutoff.
    """
    return torque_filling(log, X, measured)(evaluator, features)
