"""From filtered logs to linear systems y = W X: the models of energy, momentum and torque.

Energy (Gautier and Khalil 1988), one equation a window (t1, t2):

    integral qd^T tau dt = [h(t2) - h(t1)]^T X_inertial + [integral f dt]^T X_friction

with h the energy regressor and f the columns of friction power. Momentum, n equations a window:

    integral tau dt = {[p(t2) - p(t1)] - integral dL/dq dt} X_inertial + integral F dt X_friction

with p and dL/dq the columns of the momentum regressor and F those of friction torque. Neither needs
accelerations. Torque, n equations an instant: tau = W X, both sides through the low-pass of the
comparison band (Gautier's parallel filter).

Models are evaluated chunk by chunk at the nodes of a log, which lie as close as its band asks for;
what is kept are the rows that an estimator needs, some tens a second.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import untouched
from symgen.errors import IdentificationError
from symgen.estimation.decimation import PER_PERIOD
from symgen.estimation.filtered import FilteredLog
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
_OVERLAP = 10
_CHUNK = 4096  # nodes that are evaluated at once
_POINTS = 6  # of the polynomial through the samples around an interval
_FINE = 20  # nodes of a window, at least, where the log has so many


@dataclass(frozen=True, eq=False)
class Equations:
    """Equations of one log: W (K, p), y (K,), t (K,) end of each window (or the sample) in s.

    `correlation` is the number of rows that share samples: overlapping windows; 0 for rows that are
    no series at all, as still poses are. `joint` is the
    position of the joint whose equations these are, None for energy. y is in J, N m s or N m.
    `Z` are instruments, (K, p): the same rows along a motion that is free of the noise in W.
    `weight` is that of the log's squared residuals beside those of others.
    """

    name: str
    W: FloatArray
    y: FloatArray
    t: FloatArray
    correlation: int
    joint: int | None = None
    weight: float = 1.0
    Z: FloatArray | None = None

    def where(self, chosen: NDArray[np.bool_], name: str) -> Equations:
        """Return some of the equations, under a name."""
        Z = None if self.Z is None else self.Z[chosen]
        return replace(self, name=name, W=self.W[chosen], y=self.y[chosen], t=self.t[chosen], Z=Z)

    def columns(self, chosen: Sequence[int]) -> Equations:
        """Return the equations of some of the parameters."""
        Z = None if self.Z is None else self.Z[:, chosen]
        return replace(self, W=self.W[:, chosen], Z=Z)


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """What an estimator takes: the equations of every log, and the names of the columns."""

    names: tuple[str, ...]
    logs: tuple[Equations, ...]

    @property
    def W(self) -> FloatArray:
        """All regressor rows, (K, p)."""
        return np.concatenate([e.W for e in self.logs])

    @property
    def y(self) -> FloatArray:
        """All left-hand sides, (K,)."""
        return np.concatenate([e.y for e in self.logs])


@dataclass(frozen=True)
class Windows:
    """Sliding windows of a log, in nodes.

    Attributes:
        stride: samples from node to node.
        steps: nodes of a window.
        hop: nodes from the end of a window to that of the next.
    """

    stride: int
    steps: int
    hop: int


def _windows(log: FilteredLog, window: float) -> Windows:
    """Place the windows of a log.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    length = float(log.t[-1] - log.t[0])
    if not 0 < window < length:
        raise IdentificationError(
            f"{log.name}: a window of {window:g} s does not fit a log of {length:.3g} s"
        )
    steps = max(1, round(window / log.step))
    if abs(steps * log.step - window) > 0.5 * log.step + 1e-12:
        raise IdentificationError(
            f"{log.name}: a window of {window:g} s is shorter than half a sample ({log.step:g} s)"
        )
    return windows(log.step, log.stride, window)


def windows(step: float, stride: int, window: float) -> Windows:
    """Place windows, which end at every tenth part of their length.

    Args:
        step: of the log, s.
        stride: samples from node to node, at most.
        window: their length, s.
    """
    steps = max(1, round(window / step))
    stride = min(stride, max(1, steps // _FINE))
    nodes = max(1, round(steps / stride))
    return Windows(stride, nodes, max(1, nodes // _OVERLAP))


def _chunks(nodes: int, steps: int, hop: int) -> Iterator[tuple[slice, slice]]:
    """Yield the ends of windows (numbers of nodes), and the nodes that they need."""
    last = range(steps, nodes, hop)
    a_chunk = max(1, max(_CHUNK, 2 * steps) // hop)
    for first in range(0, len(last), a_chunk):
        ends = last[first : first + a_chunk]
        low = max(ends[0] - steps - _POINTS, 0)
        yield slice(ends[0], ends[-1] + 1, hop), slice(low, min(ends[-1] + 1 + _POINTS, nodes))


def energy_equations(evaluator: Evaluator, log: FilteredLog, window: float) -> Equations:
    """Build the energy equations of one log, in sliding windows.

    Args:
        evaluator: the compiled model.
        log: the log in the band of the run.
        window: length of the windows, s.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    w = _windows(log, window)
    q, qd = (x[:: w.stride] for x in (log.q, log.qd))
    power = np.einsum("ij,ij->i", log.qd, log.tau)[:, None]
    work = cumulative_integral(power, log.step)[:: w.stride, 0]
    parts, last = [], np.arange(w.steps, len(q), w.hop)
    for ends, span in _chunks(len(q), w.steps, w.hop):
        at = np.arange(ends.start, ends.stop, ends.step) - span.start
        q_, qd_ = (np.ascontiguousarray(x[span]) for x in (q, qd))
        h = evaluator.energy_regressor(q_, qd_)
        f = evaluator.friction_power(q_, qd_)
        whole = np.column_stack([h, cumulative_integral(f, w.stride * log.step)])
        parts.append(whole[at] - whole[at - w.steps])
    y = work[last] - work[last - w.steps]
    e = Equations(
        log.name, np.concatenate(parts), y, log.t[last * w.stride], max(1, w.steps // w.hop)
    )
    if log.mask is None:
        return e
    clean = untouched(log.mask.robot, (last - w.steps) * w.stride, last * w.stride)
    return e.where(clean, e.name)


def momentum_equations(
    evaluator: Evaluator, log: FilteredLog, window: float
) -> tuple[Equations, ...]:
    """Build the momentum equations of one log, joint by joint, in sliding windows.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    w = _windows(log, window)
    q, qd = (x[:: w.stride] for x in (log.q, log.qd))
    impulse = cumulative_integral(log.tau, log.step)[:: w.stride]
    last = np.arange(w.steps, len(q), w.hop)
    n, done = q.shape[1], 0
    W = np.empty((n, len(last), len(evaluator.model.base.names)))
    for ends, span in _chunks(len(q), w.steps, w.hop):
        at = np.arange(ends.start, ends.stop, ends.step) - span.start
        q_, qd_ = (np.ascontiguousarray(x[span]) for x in (q, qd))
        p, slope = evaluator["momentum_regressor"](q_, qd_)
        inertial = p[at] - p[at - w.steps]
        rates = np.concatenate([slope, _friction_torque(evaluator, q_, qd_)], axis=2)
        integral = cumulative_integral(rates, w.stride * log.step)
        change = integral[at] - integral[at - w.steps]
        count = p.shape[2]
        now = slice(done, done + len(at))
        W[:, now, :count] = (inertial - change[:, :, :count]).transpose(1, 0, 2)
        W[:, now, count:] = change[:, :, count:].transpose(1, 0, 2)
        done += len(at)
    y = impulse[last] - impulse[last - w.steps]
    t = log.t[last * w.stride]
    out = []
    for j in range(y.shape[1]):
        name = f"{log.name}, joint {j + 1}"
        e = Equations(name, W[j], y[:, j], t, max(1, w.steps // w.hop), j)
        if log.mask is not None:
            mask = log.mask.joint[:, j]
            e = e.where(untouched(mask, (last - w.steps) * w.stride, last * w.stride), name)
        out.append(e)
    return tuple(out)


def _friction_torque(evaluator: Evaluator, q: FloatArray, qd: FloatArray) -> FloatArray:
    """Return the columns of friction torque (N, n, p - p_inertial)."""
    model = evaluator.model
    if len(model.base.parameters) == model.inertial:
        return np.zeros((*q.shape, 0))
    return np.asarray(evaluator["friction_torque"](q, qd))


def cumulative_integral(y: FloatArray, step: float) -> FloatArray:
    """Integrate from the first sample to each one: F_k = int from t_0 to t_k of y dt.

    Every interval takes the integral of the polynomial of degree five through the six samples
    around it: exact up to that degree, where the trapezoid biases coarse logs.

    Args:
        y: (N, ...) signal in uniform steps, N at least 2.
        step: sampling step in s.

    Returns:
        The integral, of the shape of y, zero at the first sample.
    """
    points = min(_POINTS, len(y))
    before = (points - 2) // 2
    pieces: FloatArray = np.empty((len(y) - 1, *y.shape[1:]))
    inner = len(y) - points + 1  # intervals with samples on both sides
    weights = _interval_weights(points, before)
    middle = pieces[before : before + inner]
    middle[...] = weights[0] * y[:inner]
    for k in range(1, points):
        middle += weights[k] * y[k : k + inner]
    for k in range(before):
        pieces[k] = np.tensordot(_interval_weights(points, k), y[:points], 1)
    for k in range(before + inner, len(y) - 1):
        at = k - (len(y) - points)
        pieces[k] = np.tensordot(_interval_weights(points, at), y[-points:], 1)
    out = np.zeros(y.shape)
    np.cumsum(pieces, axis=0, out=out[1:])
    out *= step
    return out


@cache
def _interval_weights(points: int, at: int) -> FloatArray:
    """Return the weights of some samples in the integral from sample `at` to the next."""
    powers = np.vander(np.arange(points) - at, points, increasing=True).astype(float)
    return np.linalg.solve(powers.T, 1.0 / np.arange(1, points + 1))


def torque_columns(
    evaluator: Evaluator,
    q: FloatArray,
    qd: FloatArray,
    qdd: FloatArray,
    X: FloatArray | None = None,
) -> FloatArray:
    """Return the regressor W with tau = W X, (N, n, p).

    Effects that hold the model's torque have no column of their own: theirs is taken at given
    parameters, as the change of torque with their coefficient. At the X that solves the equations
    the whole is exact.

    Args:
        evaluator: the compiled model, with torque_regressor, and inverse_dynamics for such effects.
        q, qd, qdd: (N, n).
        X: (p,) at which the model's torque is taken; None leaves these columns away.
    """
    W: FloatArray = evaluator["torque_regressor"](q, qd, qdd)
    base = evaluator.model.base
    if X is None or base.linear == len(base.parameters):
        return W
    rigid = np.concatenate([X[: base.linear], np.zeros(len(X) - base.linear)])
    inverse = evaluator["inverse_dynamics"]
    at = inverse(q, qd, qdd, rigid)
    units = np.eye(len(X))[base.linear :]
    columns = [inverse(q, qd, qdd, rigid + unit) - at for unit in units]
    return np.concatenate([W, np.stack(columns, axis=2)], axis=2)


def torque_rows(evaluator: Evaluator, log: FilteredLog, X: FloatArray | None = None) -> FloatArray:
    """Return the torque regressor of a log in the comparison band, (K, n, p); see `log.measured`.

    Args:
        evaluator: the compiled model, with the kernel torque_regressor.
        log: the log in the band of the run.
        X: (p,) at which effects take the model's torque, see `torque_columns`.
    """
    chunks = log.modelled(lambda q, qd, qdd: torque_columns(evaluator, q, qd, qdd, X))
    return np.concatenate([W for _, W in chunks])


def torque_equations(
    evaluator: Evaluator, log: FilteredLog, X: FloatArray | None = None
) -> tuple[Equations, ...]:
    """Build the torque equations of one log, joint by joint, in the comparison band.

    Args: see `torque_rows`.
    """
    W, y, t = torque_rows(evaluator, log, X), log.measured, log.t[log.kept]
    correlation = 1 if log.rows.cutoff is None else PER_PERIOD // 2
    out = []
    for j in range(y.shape[1]):
        name = f"{log.name}, joint {j + 1}"
        e = Equations(name, np.ascontiguousarray(W[:, j]), y[:, j], t, correlation, j)
        out.append(e if log.mask is None else e.where(log.free[:, j], name))
    return tuple(out)
