"""From samples to linear systems y = W X: the models of energy, momentum and torque.

Energy (Gautier and Khalil 1988), one equation a window (t1, t2):

    integral qd^T tau dt = [h(t2) - h(t1)]^T X_inertial + [integral f dt]^T X_friction

with h the energy regressor and f the columns of friction power. Momentum, n equations a window:

    integral tau dt = {[p(t2) - p(t1)] - integral dL/dq dt} X_inertial + integral F dt X_friction

with p and dL/dq the columns of the momentum regressor and F those of friction torque. Neither needs
accelerations; integrals are those of the cubic spline through the samples. Torque, n equations a
sample: tau = W X, both sides through the same zero-phase low-pass (Gautier's parallel filter), with
W on positions and speeds that passed a wider one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.data.bandwidth import rigid_band, wide_band
from symgen.data.mask import untouched
from symgen.data.signals import (
    Samples,
    can_filter,
    cumulative_integral,
    differentiate,
    filter_reach,
    lowpass,
)
from symgen.errors import IdentificationError
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
WINDOWS = ("sliding", "consecutive", "start")
_OVERLAP = 10
_SAMPLES_PER_PERIOD = 4  # of the highest frequency that passes the filter


@dataclass(frozen=True, eq=False)
class Equations:
    """Equations of one log: W (K, p), y (K,), t (K,) end of each window (or the sample) in s.

    `correlation` is the number of rows that share samples: overlapping windows. `joint` is the
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


def energy_equations(
    evaluator: Evaluator, samples: Samples, window: float, mode: str = "sliding"
) -> Equations:
    """Build the energy equations of one log.

    Args:
        evaluator: the compiled model.
        samples: the log on a uniform grid.
        window: length of the windows, s; without meaning in mode "start".
        mode: "sliding" (a window ends at every sample), "consecutive", or "start" (every window
            begins at the first sample, as in the original paper).

    Raises:
        IdentificationError: the window does not fit the log.
    """
    steps = _window_steps(samples, window, mode)
    h = evaluator.energy_regressor(samples.q, samples.qd)
    f = evaluator.friction_power(samples.q, samples.qd)
    power = np.einsum("ij,ij->i", samples.qd, samples.tau)
    integrals = cumulative_integral(np.column_stack([f, power]), samples.step)
    whole = np.column_stack([h, integrals])
    if mode == "start":
        first, last = np.zeros(len(whole) - 1, dtype=int), np.arange(1, len(whole))
    else:
        hop = 1 if mode == "sliding" else steps
        last = np.arange(steps, len(whole), hop)
        first = last - steps
    if samples.mask is not None:
        clean = untouched(samples.mask.robot, first, last)
        first, last = first[clean], last[clean]
    difference = whole[last] - whole[first]
    correlation = {"sliding": steps, "consecutive": 1, "start": len(last) // 4}[mode]
    return Equations(
        samples.name, difference[:, :-1], difference[:, -1], samples.t[last], max(1, correlation)
    )


def _window_steps(samples: Samples, window: float, mode: str) -> int:
    """Return the length of a window in samples; refuse one that does not fit the log."""
    if mode not in WINDOWS:
        raise IdentificationError(f"windows {mode!r}; accepted: {', '.join(WINDOWS)}")
    length = samples.t[-1] - samples.t[0]
    if mode != "start" and not 0 < window < length:
        raise IdentificationError(
            f"{samples.name}: a window of {window:g} s does not fit a log of {length:.3g} s"
        )
    steps = max(1, round(window / samples.step))
    if mode != "start" and abs(steps * samples.step - window) > 0.5 * samples.step + 1e-12:
        raise IdentificationError(
            f"{samples.name}: a window of {window:g} s is shorter than half a sample "
            f"({samples.step:g} s)"
        )
    return steps


def momentum_equations(
    evaluator: Evaluator, samples: Samples, window: float
) -> tuple[Equations, ...]:
    """Build the momentum equations of one log, joint by joint, in sliding windows.

    A window begins at every tenth part of its length.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    steps = _window_steps(samples, window, "sliding")
    p, slope = evaluator["momentum_regressor"](samples.q, samples.qd)
    friction = _friction_torque(evaluator, samples)
    hop = max(1, steps // _OVERLAP)
    last = np.arange(steps, len(samples.t), hop)
    out = []
    for j in range(samples.q.shape[1]):
        rates = np.column_stack([slope[:, j], friction[:, j], samples.tau[:, j]])
        integral = cumulative_integral(rates, samples.step)
        end = last
        if samples.mask is not None:
            end = last[untouched(samples.mask.joint[:, j], last - steps, last)]
        change = integral[end] - integral[end - steps]
        inertial = p.shape[2]
        W = np.column_stack(
            [p[end, j] - p[end - steps, j] - change[:, :inertial], change[:, inertial:-1]]
        )
        name = f"{samples.name}, joint {j + 1}"
        out.append(Equations(name, W, change[:, -1], samples.t[end], max(1, steps // hop), j))
    return tuple(out)


def _friction_torque(evaluator: Evaluator, samples: Samples) -> FloatArray:
    """Return the columns of friction torque (N, n, p - p_inertial)."""
    model = evaluator.model
    if len(model.base.parameters) == model.inertial:
        return np.zeros((*samples.q.shape, 0))
    return np.asarray(evaluator["friction_torque"](samples.q, samples.qd))


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


def torque_equations(
    evaluator: Evaluator, samples: Samples, cutoff: float | None, X: FloatArray | None = None
) -> tuple[Equations, ...]:
    """Build the torque equations of one log, joint by joint, in the motion's band.

    Args:
        evaluator: the compiled model, with the kernel torque_regressor.
        samples: the log on a uniform grid.
        cutoff: of the low-pass, Hz; None for `rigid_band`.
        X: (p,) at which effects take the model's torque, see `torque_columns`.
    """
    band = cutoff or rigid_band(samples)
    filtered = can_filter(band, samples.step)

    def smooth(x: FloatArray) -> FloatArray:
        return lowpass(x, samples.step, band) if filtered else x

    q, qd = samples.q, samples.qd
    wide = wide_band(samples, band)
    if can_filter(wide, samples.step):
        q, qd = (lowpass(x, samples.step, wide) for x in (q, qd))
    W = torque_columns(evaluator, q, qd, differentiate(qd, samples.step), X)
    every = max(1, int(1 / (_SAMPLES_PER_PERIOD * band * samples.step))) if filtered else 1
    margin = filter_reach(band, samples.step) if filtered else 0  # the filter's run-in
    kept = slice(margin, len(samples.t) - margin, every)
    tau = smooth(samples.tau)
    equations = [
        Equations(
            f"{samples.name}, joint {j + 1}",
            smooth(np.ascontiguousarray(W[:, j]))[kept],
            tau[kept, j],
            samples.t[kept],
            _SAMPLES_PER_PERIOD // 2,
            j,
        )
        for j in range(samples.q.shape[1])
    ]
    if samples.mask is not None:
        clean = ~samples.mask.near(margin)[kept]
        equations = [e.where(clean[:, j], e.name) for j, e in enumerate(equations)]
    return tuple(equations)
