"""Output error: parameters whose simulated positions are nearest to the measured ones.

    min over X and the start states x0_w    sum over windows w, samples k and joints j of
        ((q_m(k, j) - q(k, j; X, x0_w)) / sigma_j)^2

The robot is simulated over short windows under the measured torques, each from a free start state
(multiple shooting, Bock 1981). Noise of q is no part of the simulation, so that it does not bias X,
as it biases least squares on a measured regressor. The steps are those of Gauss and Newton, damped
as Levenberg and Marquardt do; the start states are eliminated window by window (Golub and Pereyra
1973). The sensitivities S = dx/d(X, x0) follow the variational equations of the simulated motion,

    S_q' = S_v,    M S_v' = -W - (dtau/dq) S_q - (dtau/dqd) S_v

with W the torque regressor and the emitted derivatives of inverse dynamics. A joint that sticks has
no S_v, and where a joint reverses, the step of its friction counts as a slope between two samples.
Windows grow from stage to stage: the sum of squares of short ones has fewer minima (Ribeiro et al.
2020), as friction has less time to stop a joint for good. The delay of the torques and the
constants of effects join X: their columns of W are the derivatives of the torque by them.

If the gains of a controller gave the torques, tau = kp (qr - q) + kd (qdr - qd), the loop is
simulated: the robot with kp q + kd qd moves under kp qr + kd qdr, which has no noise of q.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.errors import ParameterError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.playback import (
    HORIZONS,
    TOLERANCE,
    Gains,
    Window,
    at_nodes,
    between,
    consecutive_windows,
)
from symgen.estimation.values import FloatArray
from symgen.identification.assessment import KNOWN
from symgen.runtime.effect_constants import EffectConstants
from symgen.runtime.evaluator import Evaluator
from symgen.runtime.integrator import TOLERANCE as FINEST
from symgen.runtime.integrator import Law, integrate
from symgen.runtime.plant import KERNELS, Mask, Plant, plant, with_torque

#: Of the model that is refined.
NEEDED = (*KERNELS, "inverse_dynamics_derivatives", "torque_regressor")
#: Folds of windows, each compared with parameters of the others.
FOLDS = 5
#: Probability of keeping the refinement where it is no better, and the standard deviations beyond
#: which a normal number is so improbable.
_LEVEL, _BEYOND = 0.05, 1.96
_AT_ONCE = 60  # windows
_ROUNDS = 12  # of the start states
_STEPS = 50  # of the parameters
_WEIGHED = 3  # rounds after which sigma stays
_LINE = 2  # nodes that a start state can meet
#: Part of the standard deviation below which a step counts as none.
_SETTLED = 0.02
#: Part of sigma that the errors of all steps of the integrator in a window may add up to. Errors
#: are not smooth in z: larger ones hide the slope of the sum of squares.
_EXACT = 0.1
#: Part of the squares of a window, and of a step of its start state, at which the search ends.
_GAIN, _SHORT = 1e-3, 1e-2
_DAMPING, _LEAST_DAMPED, _MOST_DAMPED = 1e-4, 1e-8, 1e4
#: Singular value of dq/dx0, of the largest, below which a start state has no effect: the speed of a
#: joint that sticks.
_NO_EFFECT = 1e-2


@dataclass(frozen=True, eq=False)
class RefinedConstants:
    """Constants of effects by output error.

    Attributes:
        every: the constants.
        values: (c,) fitted, or those of the robot file.
        fitted: (c,) whether the logs determine a constant, so that it was fitted.
    """

    every: EffectConstants
    values: FloatArray
    fitted: Mask


@dataclass(frozen=True, eq=False)
class Refinement:
    """Parameters by output error, and whether they simulate held-out windows better.

    Attributes:
        X: (p,).
        covariance: of X, then of the delay where it is fitted, then of the fitted constants.
        delay: by which the torques of the logs are late, s.
        constants: of effects.
        before: (windows,) mean square of measured minus simulated positions, over sigma^2, of the
            linear estimate of the other folds of windows.
        after: the same of output error on the other folds.
    """

    X: FloatArray
    covariance: FloatArray
    delay: float
    constants: RefinedConstants
    before: FloatArray
    after: FloatArray

    @property
    def p_value(self) -> float:
        """Probability of squares that are so much smaller where there is no difference.

        By the one-sided signed-rank test of Wilcoxon (1945): squares are far from normal, as a
        stop or a reversal makes some windows much larger than others.
        """
        from scipy.stats import wilcoxon

        return float(wilcoxon(self.before, self.after, alternative="greater").pvalue)

    @property
    def better(self) -> bool:
        """Whether held-out windows are nearer to the refined motion than by chance."""
        return self.p_value < _LEVEL

    @property
    def residuals(self) -> tuple[float, float]:
        """RMS of measured minus simulated positions over sigma, before and after."""
        before, after = (float(np.sqrt(x.mean())) for x in (self.before, self.after))
        return before, after


def refine(
    evaluator: Evaluator,
    logs: Sequence[FilteredLog],
    X: FloatArray,
    *,
    without: Callable[[Sequence[Window]], FloatArray],
    late: bool = False,
    gains: Gains | None = None,
) -> Refinement:
    """Refine parameters by output error.

    Each fold of windows, a fifth of the logs' time, is simulated with two sets of parameters that
    have not seen it: the linear estimate of the other folds, and the output error of the other
    folds, by the step of Gauss and Newton that leaves the fold out. The start state of a window is
    unknown to both. Each gets the best one, so that noise of a measured start has no say.

    Args:
        evaluator: with the kernels of NEEDED.
        logs: the training logs.
        X: (p,) to begin with, the linear estimate.
        without: the linear estimate of the logs without some windows.
        late: whether the torques of all joints are known to be late by a time, which is fitted
            too. Otherwise it is fitted if the windows show it.
        gains: of the controller; if they gave the torques of all logs, the loop is simulated.

    Raises:
        ParameterError: the robot with X cannot be simulated, or the logs are too short.
    """
    lengths = [consecutive_windows(logs, seconds) for seconds in HORIZONS]
    windows = lengths[-1]
    if len(windows) < FOLDS:
        raise ParameterError(
            f"{len(windows)} windows of {HORIZONS[-1]:g} s in the training logs; accepted: "
            f"{FOLDS} or more"
        )
    if any(log.samples.command is None for log in logs):
        gains = None
    stages = [cut for cut in (_cut(w, gains is not None) for w in lengths) if _sampled(cut)]
    whole, every = stages[-1], EffectConstants.of(evaluator.model)
    # In a loop that is late, its gains act late too: no delay of the torques alone.
    unknowns = _Unknowns(
        evaluator, gains is None, every, np.ones(len(every.names), dtype=bool), gains
    )
    unknowns, first, sigma = _begin(unknowns, whole, unknowns.start(X))
    parts = first.linearized(unknowns, whole, sigma)
    unknowns = unknowns.determined(first, parts)
    if unknowns.late and not (late or _delayed(parts, len(X))):
        unknowns = replace(unknowns, late=False)
    while True:
        z = unknowns.start(X)
        for cut in stages:
            staged, state, sigma = _begin(unknowns, cut, z)
            state, sigma = _fit(staged, cut, state, sigma)
            z = state.z
        parts = state.linearized(unknowns, whole, sigma)
        covariance = _covariance(parts)
        known = unknowns.determined(state, parts, np.diag(covariance))
        if np.array_equal(known.fitted, unknowns.fitted):
            break
        unknowns = known
    H, g = (np.array(x) for x in zip(*_products(parts), strict=True))
    folds = np.arange(len(windows)) * FOLDS // len(windows)
    before, after = np.empty(len(windows)), np.empty(len(windows))
    for fold in range(FOLDS):
        left = folds == fold
        rows = _by_log(left, whole)
        own = [k for k, r in enumerate(rows) if r.any()]
        cut = [whole[k].where(rows[k]) for k in own]
        begins = [[x.starts[k][rows[k]] for k in own] for x in (first, state)]
        linear = unknowns.start(without([w for w, out in zip(windows, left, strict=True) if out]))
        step = np.linalg.lstsq(H[~left].sum(axis=0), g[~left].sum(axis=0), rcond=None)[0]
        before[left], after[left] = (
            _squares(_settled(unknowns, cut, _nearest(unknowns, cut, z, begins, sigma), sigma),
                     cut, sigma)
            for z in (linear, state.z + step)
        )  # fmt: skip
    each = whole[0].q[0].size
    found, delay, c = unknowns.split(state.z)
    constants = RefinedConstants(every, c, unknowns.fitted)
    return Refinement(found, covariance, delay, constants, before / each, after / each)


def _sampled(windows: Sequence[Windows]) -> bool:
    """Return whether a window has more nodes than its line takes, so that something is left."""
    return len(windows[0].t) > 2 * _LINE


def _delayed(parts: Sequence[_Part], place: int) -> bool:
    """Return whether the equations at no delay show one, whose place in z is given."""
    H, g = _sums(parts)
    delay = np.linalg.lstsq(H, g, rcond=None)[0][place]
    return bool(abs(delay) > _BEYOND * np.sqrt(_covariance(parts)[place, place]))


def _nearest(
    unknowns: _Unknowns,
    windows: Sequence[Windows],
    z: FloatArray,
    begins: Sequence[list[FloatArray]],
    sigma: FloatArray,
) -> _State:
    """Return the state at z in which each window has the better of two start states."""
    one, other = (_State.of(unknowns, windows, z, starts) for starts in begins)
    better = _squares(other, windows, sigma) < _squares(one, windows, sigma)
    return one.with_windows(other, _by_log(better, windows))


def _squares(state: _State, windows: Sequence[Windows], sigma: FloatArray) -> FloatArray:
    """Return the sum of the squares of weighted residuals of each window."""
    return np.concatenate([np.sum((r / sigma) ** 2, axis=(1, 2)) for r in state.residuals(windows)])


def _settled(
    unknowns: _Unknowns, windows: Sequence[Windows], state: _State, sigma: FloatArray
) -> _State:
    """Return the state with z fixed after steps of the start states, each window on its own."""
    part = [np.ones(len(s)) for s in state.starts]
    none = np.zeros(len(state.z))
    for _ in range(_ROUNDS):
        steps = [p.start_step(none) for p in state.linearized(unknowns, windows, sigma)]
        before = _by_log(_squares(state, windows, sigma), windows)
        tried = [s + a[:, None] * d for s, a, d in zip(state.starts, part, steps, strict=True)]
        trial = _State.of(unknowns, windows, state.z, tried)
        after = _by_log(_squares(trial, windows, sigma), windows)
        good = [a < b for a, b in zip(after, before, strict=True)]
        part = [np.where(g, np.minimum(1.0, 2 * a), a / 4) for g, a in zip(good, part, strict=True)]
        state = state.with_windows(trial, good)
        gain = [np.where(g, 1 - a / b, 0) for g, a, b in zip(good, after, before, strict=True)]
        if all(np.all((x < _GAIN) & (g | (a < _SHORT)))
               for x, g, a in zip(gain, good, part, strict=True)):  # fmt: skip
            break
    return state


def _by_log(x: NDArray[Any], windows: Sequence[Windows]) -> list[NDArray[Any]]:
    return np.split(x, np.cumsum([len(w.start) for w in windows])[:-1])


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of a log as they are fitted.

    Attributes:
        torque: (N, n) torque of the whole log, at its nodes, without that of a closed loop.
        rows: (W, K) nodes of each window.
        t: (K,) s.
        q: (W, K, n) measured positions, below a quarter of the rate of t.
        start: (W, 2 n) first states.
    """

    torque: FloatArray
    rows: NDArray[np.intp]
    t: FloatArray
    q: FloatArray
    start: FloatArray

    @property
    def step(self) -> float:
        """Time between two nodes, s."""
        return float(self.t[1] - self.t[0])

    @property
    def clock(self) -> FloatArray:
        """Time (W,) from the first node of the log to the start of each window, s."""
        return np.asarray(self.rows[:, 0] * self.step, dtype=np.float64)

    def law(self) -> Law:
        """Return the torques as a function of the time after the first node of the log."""
        torque = between(self.torque, 0.0, self.step)
        return lambda t, q, qd: torque(t)  # noqa: ARG005

    def tau(self, delay: float) -> FloatArray:
        """Return the torques (W, K, n) at the nodes, if they are late by a delay, s."""
        times = np.asarray(self.rows * self.step + delay, dtype=np.float64)
        return between(self.torque, 0.0, self.step)(times.ravel()).reshape(self.q.shape)

    def rate(self, delay: float) -> FloatArray:
        """Return the derivative of the torques by the delay, (W, K, n)."""
        half = self.step / 2
        return (self.tau(delay + half) - self.tau(delay - half)) / self.step

    def where(self, chosen: Mask) -> Windows:
        """Return some of the windows."""
        rows = self.rows[chosen]
        return Windows(self.torque, rows, self.t, self.q[chosen], self.start[chosen])


def _cut(windows: Sequence[Window], closed: bool) -> list[Windows]:
    """Return windows as arrays at the nodes of their logs, some at once.

    Args:
        windows: of logs.
        closed: whether the torque is the part that the reference of the controller gives.
    """
    out = []
    groups = [
        (log, own[k : k + _AT_ONCE])
        for log in dict.fromkeys(w.log for w in windows)
        for own in [[w.start for w in windows if w.log is log]]
        for k in range(0, len(own), _AT_ONCE)
    ]
    for log, starts in groups:
        every = log.stride
        at = np.array(starts) // every
        rows = at[:, None] + np.arange(round(windows[0].seconds / (every * log.step)) + 1)
        torque = log.samples.command if closed else log.tau
        assert torque is not None  # a loop is closed where all logs have a reference
        q, tau = (at_nodes(log, x) for x in (log.samples.q, torque))
        state = np.concatenate([x[at] for x in log.nodes(every)], axis=1)
        t = np.asarray(np.arange(rows.shape[1]) * (every * log.step), dtype=np.float64)
        out.append(Windows(tau, rows, t, q[rows], state))
    return out


@dataclass(frozen=True, eq=False)
class _Unknowns:
    """What is fitted beside the start states: z = (X, the delay if `late`, fitted constants).

    Attributes:
        evaluator: with the kernels of NEEDED.
        late: whether the delay is fitted.
        every: the constants of effects.
        fitted: (c,) which of them are fitted.
        gains: kp and kd of the loop that is simulated, None where there is none.
        tolerance: of a step of the integrator.
    """

    evaluator: Evaluator
    late: bool
    every: EffectConstants
    fitted: Mask
    gains: Gains | None = None
    tolerance: float = TOLERANCE

    def start(self, X: FloatArray) -> FloatArray:
        """Return z of X, no delay, and the constants of the robot file."""
        return np.concatenate([X, np.zeros(int(self.late)), self.every.values[self.fitted]])

    def split(self, z: FloatArray) -> tuple[FloatArray, float, FloatArray]:
        """Return X (p,), the delay of the torques, s, and all constants (c,)."""
        p = len(self.evaluator.model.base.names)
        c = self.every.values.copy()
        c[self.fitted] = z[p + self.late :]
        return z[:p], float(z[p : p + self.late].sum()), c

    def plant(self, z: FloatArray) -> Plant:
        """Return the robot with unknowns z."""
        X, _, c = self.split(z)
        out = plant(self.evaluator, self.every.without(X) if self.fitted.any() else X)
        if self.fitted.any():
            out = with_torque(out, lambda q, qd: self.every.torque(q, qd, X, c))
        if self.gains is not None:
            kp, kd = self.gains
            out = with_torque(out, lambda q, qd: kp * q + kd * qd)
        return out

    def slopes(
        self, z: FloatArray, w: Windows, q: FloatArray, qd: FloatArray, qdd: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the derivatives of the torque by z, q and qd at samples of windows, (N, n, _)."""
        X, delay, c = self.split(z)
        columns = [self.evaluator["torque_regressor"](q, qd, qdd)]
        own = self.every.without(X) if self.fitted.any() else X
        by_q, by_qd = self.evaluator["inverse_dynamics_derivatives"](q, qd, qdd, own)
        if self.late:
            columns.append(-w.rate(delay).reshape(*q.shape, 1))
        if self.fitted.any():
            more = self.every.slopes(q, qd, X, c)
            columns[0][..., self.every.places] = more.W[..., self.every.places]
            columns.append(more.by_c[..., self.fitted])
            by_q, by_qd = by_q + more.by_q, by_qd + more.by_qd
        if self.gains is not None:
            by_q, by_qd = (x + np.diag(k) for x, k in zip((by_q, by_qd), self.gains, strict=True))
        return np.concatenate(columns, axis=2), by_q, by_qd

    def determined(
        self, state: _State, parts: Sequence[_Part], variance: FloatArray | float = 0.0
    ) -> _Unknowns:
        """Return these unknowns without the constants that the logs do not determine.

        They determine a constant if one standard deviation of it, up or down, changes the torque of
        its effect by no more than a parameter is uncertain that counts as known.

        Args:
            state: at which `parts` are linearized.
            parts: the equations.
            variance: of z; that of white noise counts where it is larger.
        """
        if not self.fitted.any():
            return self
        X, _, c = self.split(state.z)
        q, qd = (np.concatenate([x.reshape(-1, x.shape[2]) for x in each])
                 for each in zip(*state.motions, strict=True))  # fmt: skip
        H, _ = _sums(parts)
        size = np.sqrt(np.diag(H))
        scaled = H / np.outer(*2 * [np.where(size > 0, size, 1.0)])
        white = np.diag(np.linalg.inv(scaled + len(H) * np.finfo(float).eps * np.eye(len(H))))
        std = np.sqrt(np.maximum(white / np.maximum(size, 1e-150) ** 2, variance))
        kept, each = self.fitted.copy(), std[len(H) - self.fitted.sum() :]
        for i, s in zip(np.flatnonzero(self.fitted), each, strict=True):
            own, at = np.zeros_like(X), self.every.places[self.every.own[:, i]]
            own[at] = X[at]
            now = self.every.torque(q, qd, own, c)
            most = KNOWN / 100 * np.linalg.norm(now)
            for step in (-s, s):
                with suppress(ParameterError):
                    other = self.every.torque(q, qd, own, c + step * np.eye(len(c))[i])
                    kept[i] &= np.linalg.norm(other - now) <= most
                    continue
                kept[i] = False
        return replace(self, fitted=kept)


def _simulate(
    moved: Plant, w: Windows, start: FloatArray, delay: float, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Return q and qd, (W, K, n)."""
    q, qd = np.split(start, 2, axis=1)
    motion = integrate(
        moved, w.law(), w.t, q, qd, smooth=True, clock=w.clock + delay, tolerance=tolerance
    )
    return motion.q, motion.qd


def sensitivities(
    moved: Plant, unknowns: _Unknowns, z: FloatArray, w: Windows, q: FloatArray, qd: FloatArray
) -> FloatArray:
    """Return dq/d(z, x0) along simulated windows, (W, K, n, p + 2 n).

    Args:
        moved: the robot with parameters X.
        unknowns: what z stands for.
        z: (p,) unknowns.
        w: the windows.
        q, qd: (W, K, n) simulated motion.
    """
    runs, K, n = q.shape
    p, m, h = len(z), len(moved.A), w.step
    _, delay, _ = unknowns.split(z)
    flat_q, flat_qd = q.reshape(-1, n), qd.reshape(-1, n)
    tau = w.tau(delay).reshape(-1, n)
    speed = moved.speed(flat_qd)
    mode = np.where(np.abs(speed) > 1e-10, np.sign(speed), 0.0)
    qdd, _ = moved.accelerate(flat_q, flat_qd, tau, mode)
    W, by_q, by_qd = unknowns.slopes(z, w, flat_q, flat_qd, qdd)
    low, high = moved.limits(flat_q, flat_qd)
    step = np.broadcast_to(high - low, speed.shape)
    M = moved.mass(flat_q)
    held = (mode == 0)[:, :, None] * moved.A
    system = np.zeros((len(M), n + m, n + m))
    system[:, :n, :n], system[:, :n, n:], system[:, n:, :n] = M, held.transpose(0, 2, 1), held
    rest = np.arange(n, n + m)
    system[:, rest, rest] = np.where(mode == 0, 0.0, 1.0)
    inverse = np.linalg.inv(system)[:, :n, :n]  # of M where nothing sticks
    shape = (runs, K)
    keep = (inverse @ M).reshape(*shape, n, n)
    inverse, W, by_q, by_qd = (x.reshape(*shape, *x.shape[1:]) for x in (inverse, W, by_q, by_qd))
    mode, speed, step = (x.reshape(*shape, m) for x in (mode, speed, step))
    width = p + 2 * n
    S = np.zeros((runs, 2 * n, width))
    S[:, :, p:] = np.eye(2 * n)
    out = np.empty((runs, K, n, width))
    out[:, 0] = S[:, :n]
    eye = np.eye(2 * n)

    def slopes(k: int, turned: FloatArray) -> tuple[FloatArray, FloatArray]:
        A = np.zeros((runs, 2 * n, 2 * n))
        A[:, :n, n:] = np.eye(n)
        A[:, n:, :n] = -inverse[:, k] @ by_q[:, k]
        A[:, n:, n:] = -inverse[:, k] @ (by_qd[:, k] + turned)
        B = np.zeros((runs, 2 * n, width))
        B[:, n:, : W.shape[-1]] = -inverse[:, k] @ W[:, k]
        return A, B

    for k in range(K - 1):
        change = np.abs(speed[:, k + 1] - speed[:, k])
        jump = np.where(
            mode[:, k] * mode[:, k + 1] < 0, step[:, k] / np.maximum(change, 1e-12), 0.0
        )
        turned = np.einsum("rm,mi,mj->rij", jump, moved.A, moved.A)
        (A0, B0), (A1, B1) = slopes(k, turned), slopes(k + 1, turned)
        right = S + h / 2 * (A0 @ S + B0 + B1)
        S = np.linalg.solve(eye - h / 2 * A1, right)
        S[:, n:] = keep[:, k + 1] @ S[:, n:]
        out[:, k + 1] = S[:, :n]
    return out


def _begin(
    unknowns: _Unknowns, windows: Sequence[Windows], z: FloatArray
) -> tuple[_Unknowns, _State, FloatArray]:
    """Return the unknowns with the tolerance for these windows, the best state at z, and sigma."""
    starts = [w.start for w in windows]
    state = _State.of(unknowns, windows, z, starts)
    sigma = _deviations(windows, state)
    summed = _EXACT * float(sigma.min()) / len(windows[0].t)
    unknowns = replace(unknowns, tolerance=float(np.clip(summed, FINEST, TOLERANCE)))
    return unknowns, _settled(unknowns, windows, state, sigma), sigma


def _fit(
    unknowns: _Unknowns, windows: Sequence[Windows], state: _State, sigma: FloatArray
) -> tuple[_State, FloatArray]:
    """Return the state of the least cost, and sigma (n,).

    Raises:
        ParameterError: the steps do not settle.
    """
    z = state.z
    damping = _DAMPING
    for done in range(_STEPS):
        parts = state.linearized(unknowns, windows, sigma)
        H, g = _sums(parts)
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        scaled, cost, trial = H / np.outer(size, size), state.cost(windows, sigma), None
        while trial is None and damping <= _MOST_DAMPED:
            step = np.linalg.solve(scaled + damping * np.eye(len(z)), g / size) / size
            with suppress(ParameterError):  # a step to a robot that cannot move is too long
                trial = _stepped(unknowns, windows, state, parts, step, sigma)
                trial = trial if trial.cost(windows, sigma) < cost else None
            damping *= 10
        if trial is None:
            break
        std = np.sqrt(np.diag(_covariance(parts)))
        settled = np.all(np.abs(trial.z - state.z) <= _SETTLED * std)
        state, damping = trial, max(damping / 100, _LEAST_DAMPED)
        if settled and done >= _WEIGHED:
            break
        if done < _WEIGHED:
            sigma = _deviations(windows, state)
    else:
        raise ParameterError(f"output error does not settle in {_STEPS} steps")
    return state, sigma


def _stepped(
    unknowns: _Unknowns,
    windows: Sequence[Windows],
    state: _State,
    parts: Sequence[_Part],
    step: FloatArray,
    sigma: FloatArray,
) -> _State:
    """Return the state after a step of z.

    Each window takes the better of two start states: the best one of the linear equations, and the
    one that only follows the step. At a stop or a reversal the first can be worse for any step.
    """
    begins = [
        [s + p.start_step(step, own) for s, p in zip(state.starts, parts, strict=True)]
        for own in (1.0, 0.0)
    ]
    return _nearest(unknowns, windows, state.z + step, begins, sigma)


@dataclass(frozen=True, eq=False)
class _State:
    """Parameters z, start states, and the motion that follows from them."""

    z: FloatArray
    starts: list[FloatArray]
    moved: Plant
    motions: list[tuple[FloatArray, FloatArray]]

    @classmethod
    def of(
        cls, unknowns: _Unknowns, windows: Sequence[Windows], z: FloatArray,
        starts: list[FloatArray],
    ) -> _State:  # fmt: skip
        _, delay, _ = unknowns.split(z)
        moved = unknowns.plant(z)
        motions = [
            _simulate(moved, w, s, delay, unknowns.tolerance)
            for w, s in zip(windows, starts, strict=True)
        ]
        return cls(z, starts, moved, motions)

    def with_windows(self, other: _State, which: Sequence[Mask]) -> _State:
        """Return this state with the windows of another, of the same X, where `which` is true."""
        starts, motions = [], []
        for k, rows in enumerate(which):
            wide = rows[:, None, None]
            starts.append(np.where(rows[:, None], other.starts[k], self.starts[k]))
            (q, qd), (new_q, new_qd) = self.motions[k], other.motions[k]
            motions.append((np.where(wide, new_q, q), np.where(wide, new_qd, qd)))
        return _State(self.z, starts, self.moved, motions)

    def residuals(self, windows: Sequence[Windows]) -> list[FloatArray]:
        """Return measured minus simulated positions, (W, K, n) of each log."""
        return [w.q - q for w, (q, _) in zip(windows, self.motions, strict=True)]

    def linearized(
        self, unknowns: _Unknowns, windows: Sequence[Windows], sigma: FloatArray
    ) -> list[_Part]:
        """Return the equations of each log at this state."""
        return [
            _Part.of(w, sigma, motion, sensitivities(self.moved, unknowns, self.z, w, *motion))
            for w, motion in zip(windows, self.motions, strict=True)
        ]

    def cost(self, windows: Sequence[Windows], sigma: FloatArray) -> float:
        """Return the sum of the squares of weighted residuals."""
        return float(sum(np.sum((r / sigma) ** 2) for r in self.residuals(windows)))


@dataclass(frozen=True, eq=False)
class _Part:
    """The equations of one log without its start states: residuals r = J dX by window.

    Attributes:
        J: (W, K n, p).
        r: (W, K n).
        back: (W, 2 n, K n) from residuals to a step of the start states.
        full: residuals and dq/dX with the effect of the start states.
    """

    J: FloatArray
    r: FloatArray
    back: FloatArray
    full: tuple[FloatArray, FloatArray]

    @classmethod
    def of(
        cls, w: Windows, sigma: FloatArray, motion: tuple[FloatArray, FloatArray], S: FloatArray
    ) -> _Part:
        p = S.shape[3] - w.start.shape[1]
        whole = np.concatenate([S, (w.q - motion[0])[..., None]], axis=3)
        whole /= sigma[:, None]
        whole = whole.reshape(len(whole), -1, whole.shape[-1])
        J0 = whole[:, :, p:-1]
        back = np.linalg.pinv(J0, rcond=_NO_EFFECT)
        left = whole - J0 @ (back @ whole)
        return cls(left[:, :, :p], left[:, :, -1], back, (whole[:, :, -1], whole[:, :, :p]))

    def sums(self) -> tuple[FloatArray, FloatArray]:
        """Return J' J and J' r over the windows."""
        J = self.J.reshape(-1, self.J.shape[2])
        return J.T @ J, J.T @ self.r.ravel()

    def start_step(self, step: FloatArray, own: float = 1.0) -> FloatArray:
        """Return the best step of the start states (W, 2 n) after a step of X.

        Args:
            step: (p,).
            own: part of the residuals that the start states take away beside those of the step.
        """
        r, J = self.full
        return np.asarray((self.back @ (own * r - J @ step)[:, :, None])[:, :, 0])


def _sums(parts: Sequence[_Part]) -> tuple[FloatArray, FloatArray]:
    """Return J' J and J' r over all windows."""
    H, g = (np.sum(x, axis=0) for x in zip(*(part.sums() for part in parts), strict=True))
    return H, g


def _products(parts: Sequence[_Part]) -> list[tuple[FloatArray, FloatArray]]:
    """Return J' J and J' r of each window."""
    return [(J.T @ J, J.T @ r) for part in parts for J, r in zip(part.J, part.r, strict=True)]


def _covariance(parts: Sequence[_Part]) -> FloatArray:
    """Return the jackknife covariance of z: residuals of two windows are independent.

    It is wider by the critical value at 5 % of Student's law, with a degree of freedom less than
    there are windows, over that of the normal law.
    """
    from scipy.special import stdtrit

    own = _products(parts)
    H, g = (sum(x) for x in zip(*own, strict=True))
    moves = np.array([np.linalg.lstsq(H - h, g - s, rcond=None)[0] for h, s in own])
    spread = moves - moves.mean(axis=0)
    wider = stdtrit(len(own) - 1, 1 - _LEVEL / 2) / _BEYOND
    return np.asarray(wider**2 * spread.T @ spread * (len(own) - 1) / len(own))


def _deviations(windows: Sequence[Windows], state: _State) -> FloatArray:
    """Return sigma (n,) of the residuals, without the line that a start state takes of a window."""
    total, count = np.zeros(windows[0].q.shape[2]), 0
    for r in state.residuals(windows):
        K = r.shape[1]
        Q, _ = np.linalg.qr(np.stack([np.ones(K), np.arange(K)], axis=1))
        left = r - np.einsum("ki,li,wlj->wkj", Q, Q, r, optimize=True)
        total += np.sum(left**2, axis=(0, 1))
        count += len(r) * (K - _LINE)
    return np.sqrt(np.maximum(total / count, 1e-300))
