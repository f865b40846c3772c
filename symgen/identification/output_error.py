"""Output error: parameters whose simulated positions are nearest to the measured ones.

    min over X and the start states x0_w    sum over windows w, samples k, joints j of
        ((q_m(k, j) - q(k, j; X, x0_w)) / sigma_j)^2

The robot is simulated over short windows under the measured torques, each from a free start state
(multiple shooting, Bock 1981). Noise of q is no part of the simulation, so that it does not bias X,
as it biases least squares on a measured regressor. The steps are those of Gauss and Newton, damped
as Levenberg and Marquardt do; the start states are eliminated window by window (Golub and Pereyra
1973). The sensitivities S = dx/d(X, x0) follow the variational equations along the simulated motion,

    S_q' = S_v,    M S_v' = -W - (dtau/dq) S_q - (dtau/dqd) S_v

with W the torque regressor and the emitted derivatives of inverse dynamics. A joint that sticks has
no S_v, and where a joint reverses, the step of its friction counts as a slope between two samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from symgen.data.mask import spans
from symgen.errors import ParameterError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.playback import at_nodes
from symgen.estimation.values import FloatArray
from symgen.runtime.evaluator import Evaluator
from symgen.runtime.integrator import integrate
from symgen.runtime.plant import KERNELS, Plant, plant

#: Of the model that is refined.
NEEDED = (*KERNELS, "inverse_dynamics_derivatives", "torque_regressor")
#: Length of a window, s: the longest horizon of a verdict.
SECONDS = 1.0
_TOLERANCE = 1e-5
_ROUNDS = 12
_WEIGHED = 3  # rounds after which the weights stay
#: Part of the standard deviation below which a step counts as none.
_SETTLED = 0.02
_DAMPING, _MOST_DAMPED = 1e-4, 1e4


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of a log as they are simulated.

    Attributes:
        tau: (W, K, n) torques from each sample to the next: their mean.
        t: (K,) s.
        q: (W, K, n) measured positions, below a quarter of the rate of t.
        start: (W, 2 n) first states.
    """

    tau: FloatArray
    t: FloatArray
    q: FloatArray
    start: FloatArray
    cutoff: float


@dataclass(frozen=True, eq=False)
class OutputErrorFit:
    """Parameters by output error.

    Attributes:
        X: (p,).
        covariance: (p, p), robust to residuals that are correlated within a window and joint.
        rounds: number of steps.
    """

    X: FloatArray
    covariance: FloatArray
    rounds: int


def cut_windows(logs: Sequence[FilteredLog]) -> list[Windows]:
    """Return the windows of logs, one after another, clear of their masks."""
    out = []
    for log in logs:
        every = log.stride
        q = at_nodes(log, log.samples.q)
        count = round(SECONDS / (every * log.step))
        whole = spans(np.all(log.clear, axis=1))
        starts = [
            k
            for a, b in whole
            for k in range(-(-a // every) * every, b - count * every, count * every)
        ]
        if not starts or count < 2:
            continue
        at = np.array(starts)
        rows = at[:, None] // every + np.arange(count + 1)
        state = np.concatenate([log.q[at], log.qd[at]], axis=1)
        t = np.arange(count + 1) * (every * log.step)
        tau = at_nodes(log, log.tau)
        tau = np.concatenate([_means(tau), tau[-1:]])
        out.append(Windows(tau[rows], t, q[rows], state, log.band.cutoff_hz))
    return out


def _means(x: FloatArray) -> FloatArray:
    """Return the means of x (N, c) from each sample to the next, (N - 1, c), of cubics through four."""
    wide = np.concatenate([2 * x[:1] - x[1:2], x, 2 * x[-1:] - x[-2:-1]])
    return np.asarray((13 * (x[:-1] + x[1:]) - wide[:-3] - wide[3:]) / 24)


def _no_torque(t: FloatArray, q: FloatArray, qd: FloatArray) -> FloatArray:  # noqa: ARG001
    return np.zeros_like(q)


def _simulate(moved: Plant, w: Windows, start: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return q and qd, (W, K, n)."""
    n = w.q.shape[2]
    motion = integrate(
        moved, _no_torque, w.t, start[:, :n], start[:, n:], unseen=w.tau, tolerance=_TOLERANCE
    )
    return motion.q, motion.qd


def sensitivities(
    moved: Plant, evaluator: Evaluator, X: FloatArray, w: Windows, q: FloatArray, qd: FloatArray
) -> FloatArray:
    """Return dq/d(X, x0) along simulated windows, (W, K, n, p + 2 n).

    Args:
        moved: the robot with parameters X.
        evaluator: with the kernels of NEEDED.
        X: (p,).
        w: the windows.
        q, qd: (W, K, n) simulated motion.
    """
    runs, K, n = q.shape
    p, m, h = len(X), len(moved.A), w.t[1] - w.t[0]
    flat_q, flat_qd = q.reshape(-1, n), qd.reshape(-1, n)
    tau = w.tau.reshape(-1, n)
    speed = moved.speed(flat_qd)
    mode = np.where(np.abs(speed) > 1e-10, np.sign(speed), 0.0)
    qdd, _ = moved.accelerate(flat_q, flat_qd, tau, mode)
    W = evaluator["torque_regressor"](flat_q, flat_qd, qdd)
    by_q, by_qd = evaluator["inverse_dynamics_derivatives"](flat_q, flat_qd, qdd, X)
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
    mode, speed = mode.reshape(*shape, m), speed.reshape(*shape, m)
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
            mode[:, k] * mode[:, k + 1] < 0, 2 * moved.force / np.maximum(change, 1e-12), 0.0
        )
        turned = np.einsum("rm,mi,mj->rij", jump, moved.A, moved.A)
        (A0, B0), (A1, B1) = slopes(k, turned), slopes(k + 1, turned)
        right = S + h / 2 * (A0 @ S + B0 + B1)
        S = np.linalg.solve(eye - h / 2 * A1, right)
        S[:, n:] = keep[:, k + 1] @ S[:, n:]
        out[:, k + 1] = S[:, :n]
    return out


def fit_output_error(
    evaluator: Evaluator, windows: Sequence[Windows], X: FloatArray
) -> OutputErrorFit:
    """Fit parameters to the measured positions.

    Args:
        evaluator: with the kernels of NEEDED.
        windows: of the training logs.
        X: (p,) to begin with.

    Raises:
        ParameterError: the robot with X cannot be simulated.
    """
    state = _State.of(evaluator, windows, X, [w.start for w in windows])
    damping, done, weights = _DAMPING, 0, None
    for done in range(1, _ROUNDS + 1):
        if done <= _WEIGHED:
            weights = _weights(windows, state)
        assert weights is not None
        parts = [_Part.of(own, w, evaluator, state, F)
                 for own, w, F in zip(range(len(windows)), windows, weights, strict=True)]  # fmt: skip
        H, g = _sums(parts)
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        scaled = H / np.outer(size, size)
        cost = state.cost(windows, weights)
        trial, step = None, np.zeros_like(X)
        while trial is None and damping <= _MOST_DAMPED:
            step = np.linalg.solve(scaled + damping * np.eye(len(X)), g / size) / size
            starts = [s + p.start_step(step) for s, p in zip(state.starts, parts, strict=True)]
            with suppress(ParameterError):
                trial = _State.of(evaluator, windows, state.X + step, starts)
            if trial is not None and trial.cost(windows, weights) >= cost:
                trial = None
            damping *= 10
        if trial is None:
            break
        state, damping = trial, max(damping / 100, 1e-8)
        std = np.sqrt(np.abs(np.diag(np.linalg.pinv(scaled)))) / size
        if done > _WEIGHED and np.all(np.abs(step) <= _SETTLED * std):
            break
    parts = [_Part.of(own, w, evaluator, state, F)
             for own, w, F in zip(range(len(windows)), windows, weights, strict=True)]  # fmt: skip
    return OutputErrorFit(state.X, _covariance(parts), done)


@dataclass(frozen=True, eq=False)
class _State:
    """Parameters, start states, and the motion that follows from them."""

    X: FloatArray
    starts: list[FloatArray]
    moved: Plant
    motions: list[tuple[FloatArray, FloatArray]]

    @classmethod
    def of(
        cls, evaluator: Evaluator, windows: Sequence[Windows], X: FloatArray,
        starts: list[FloatArray],
    ) -> _State:  # fmt: skip
        moved = plant(evaluator, X)
        motions = [_simulate(moved, w, s) for w, s in zip(windows, starts, strict=True)]
        return cls(X, starts, moved, motions)

    def residuals(self, windows: Sequence[Windows]) -> list[FloatArray]:
        """Return measured minus simulated positions, (W, K, n) of each log."""
        return [w.q - q for w, (q, _) in zip(windows, self.motions, strict=True)]

    def cost(self, windows: Sequence[Windows], weights: Sequence[FloatArray]) -> float:
        """Return the sum of the squares of weighted residuals."""
        parts = zip(weights, self.residuals(windows), strict=True)
        return float(sum(np.sum(np.einsum("jkl,wlj->wkj", F, r) ** 2) for F, r in parts))


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
    def of(cls, own: int, w: Windows, evaluator: Evaluator, state: _State, F: FloatArray) -> _Part:
        p, (q, qd) = len(state.X), state.motions[own]
        J = sensitivities(state.moved, evaluator, state.X, w, q, qd)
        whole = np.concatenate([J, (w.q - q)[..., None]], axis=3)
        whole = np.einsum("jkl,wljc->wkjc", F, whole, optimize=True)
        whole = whole.reshape(len(whole), -1, whole.shape[-1])
        J0 = whole[:, :, p:-1]
        back = np.linalg.pinv(J0, rcond=1e-2)  # the speed of a joint that sticks has no effect
        left = whole - J0 @ (back @ whole)
        return cls(left[:, :, :p], left[:, :, -1], back, (whole[:, :, -1], whole[:, :, :p]))

    def start_step(self, step: FloatArray) -> FloatArray:
        """Return the best step of the start states (W, 2 n) after a step of X."""
        r, J = self.full
        return np.asarray((self.back @ (r - J @ step)[:, :, None])[:, :, 0])


def _sums(parts: Sequence[_Part]) -> tuple[FloatArray, FloatArray]:
    H = sum(np.einsum("wap,waq->pq", p.J, p.J, optimize=True) for p in parts)
    return np.asarray(H), np.asarray(sum(np.einsum("wap,wa->p", p.J, p.r) for p in parts))


def _covariance(parts: Sequence[_Part]) -> FloatArray:
    """Return the jackknife covariance of X: residuals of two windows are independent."""
    own = [(J.T @ J, J.T @ r) for part in parts for J, r in zip(part.J, part.r, strict=True)]
    H, g = (sum(x) for x in zip(*own, strict=True))
    moves = np.array([np.linalg.lstsq(H - h, g - s, rcond=None)[0] for h, s in own])
    spread = moves - moves.mean(axis=0)
    return np.asarray(spread.T @ spread * (len(own) - 1) / len(own))


def _weights(windows: Sequence[Windows], state: _State) -> list[FloatArray]:
    """Return the whitening (n, K, K) of the residuals of each log.

        cov of r_j over time = sigma_j^2 (I + rho_j L),    L of white noise that is integrated twice

    I is noise of the encoder, L that of the torque, and of what the model misses. sigma and rho are
    those of largest likelihood once a line, which the start state takes, is out of each window.
    """
    out = []
    for w, r in zip(windows, state.residuals(windows), strict=True):
        K, n = r.shape[1:]
        steps = np.arange(K)
        G = np.maximum(steps[:, None] - np.arange(K - 1) - 0.5, 0.0)
        L = G @ G.T
        L /= np.trace(L) / K
        Q, _ = np.linalg.qr(np.stack([np.ones(K), steps], axis=1), mode="complete")
        U = Q[:, 2:]
        size, V = np.linalg.eigh(U.T @ L @ U)
        z = np.einsum("ki,wkj->wij", U @ V, r)
        square = np.mean(z**2, axis=0)  # (K - 2, n)
        grid = np.concatenate([[0.0], np.logspace(-6, 8, 71)])
        scale = 1 + grid[:, None] * np.maximum(size, 0.0)  # (grid, K - 2)
        variance = np.mean(square[None] / scale[:, :, None], axis=1)  # (grid, n)
        best = np.argmin(np.log(variance) + np.mean(np.log(scale), axis=1)[:, None], axis=0)
        count = min(K, 2 + math.ceil(2 * w.t[-1] * w.cutoff))
        D = np.cos(np.pi / K * np.arange(count)[:, None] * (steps + 0.5))
        F = [
            np.linalg.solve(
                np.linalg.cholesky(variance[b, j] * (D @ (np.eye(K) + grid[b] * L) @ D.T)), D
            )
            for j, b in enumerate(best)
        ]
        out.append(np.array(F))
    return out
