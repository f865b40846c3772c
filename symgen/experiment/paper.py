"""The example of Gautier and Khalil (1988): two revolute joints, its motion, noise and set-ups.

Joint 1 follows a cubic, q1 = D (3 s^2 - 2 s^3) with s = t/T; joint 2 a sine, q2 = A (1 - cos w t).
Set-up (a), the paper's figure 3: the robot follows the reference exactly, the measurements alone
are noisy. Set-up (b), its figure 2: torques computed from wrong parameters X_d, plus torque noise,
drive a simulated robot; what is known to the identification is the computed torque.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.casadi_model import casadi_function
from symgen.codegen.model import derive
from symgen.data.spline import interpolated
from symgen.robot.types import Robot

FloatArray = NDArray[np.float64]

X_TRUE = np.array([1.702, 0.05644, 0.15, 0.075])
NAMES = ("ZZ1R", "ZZ2", "MX2", "MY2")
PAPER_ERRORS = np.array([5.6e-4, 0.016, 0.011, 0.019])
SAMPLES = 100
STEP = 0.0622
_W = 2.0
_A = 1.0
_ENCODER_POINTS = 14_400
_TACHOMETER = np.array([0.005, 0.01])
#: Ratio of X_d to X in set-up (b), and standard deviation of the torque noise over RMS torque.
WRONG = 1.2
TORQUE_NOISE = 0.01
_SUBSTEPS, _COARSE = 8, 2


@dataclass(frozen=True, eq=False)
class Runs:
    """Measured runs: t (N,), q, qd, tau (runs, N, 2)."""

    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray


def reference(t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the reference motion q, qd, qdd, each (N, 2), rad and s; peak speeds 1 and 2 rad/s."""
    T = SAMPLES * STEP
    D = T / 1.5
    s = t / T
    q = np.stack([D * (3 * s**2 - 2 * s**3), _A * (1 - np.cos(_W * t))], axis=-1)
    qd = np.stack([6 * D / T * (s - s**2), _A * _W * np.sin(_W * t)], axis=-1)
    qdd = np.stack([6 * D / T**2 * (1 - 2 * s), _A * _W**2 * np.cos(_W * t)], axis=-1)
    return q, qd, qdd


def times() -> FloatArray:
    """Return the sampling times: 0 and the paper's 100 samples, s."""
    return np.arange(SAMPLES + 1) * np.float64(STEP)


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Torques and accelerations of a robot.

    Attributes:
        inverse: casadi.Function (q, qd, qdd, X) -> tau, each a column.
        forward: casadi.Function (q, qd, tau, X) -> qdd.
    """

    inverse: Any
    forward: Any


def dynamics(robot: Robot) -> Dynamics:
    """Derive the dynamics of a robot."""
    model = derive(robot, ("inverse_dynamics", "forward_dynamics"))
    return Dynamics(*(casadi_function(model, kernel) for kernel in model.kernels))


def exact_run(dynamics: Dynamics) -> Runs:
    """Return the reference with its torque and no noise at all."""
    t = times()
    q, qd, qdd = reference(t)
    return Runs(t, q[None], qd[None], _torque(dynamics, q, qd, qdd, X_TRUE)[None])


def setup_a(
    dynamics: Dynamics, runs: int, seed: int, *, tachometer: float = 1.0, mirrored: bool = False
) -> Runs:
    """Return runs that follow the reference exactly, with noisy measurements.

    Args:
        dynamics: of the robot.
        runs: how many.
        seed: of the noise.
        tachometer: factor of the tachometers' noise.
        mirrored: whether the second half of the runs has the noise of the first with the other
            sign. What is odd in the noise then cancels in means over runs, and bias stands out.
    """
    clean = exact_run(dynamics)
    draw = _Noise(np.random.default_rng([seed, 1]), runs, mirrored)
    q, qd = _measured(draw, np.repeat(clean.q, runs, 0), np.repeat(clean.qd, runs, 0), tachometer)
    return Runs(clean.t, q, qd, np.repeat(clean.tau, runs, 0))


def setup_b(
    dynamics: Dynamics, runs: int, seed: int, *, tachometer: float = 1.0, mirrored: bool = False
) -> Runs:
    """Return runs of a simulated robot driven by wrong computed torques plus torque noise.

    The robot is integrated by Runge and Kutta's fourth-order rule, 8 steps a sample; the noise is
    constant over a sample. Arguments as those of `setup_a`.
    """
    t = times()
    draw = _Noise(np.random.default_rng([seed, 2]), runs, mirrored)
    computed = _torque(dynamics, *reference(t), WRONG * X_TRUE)
    noise = TORQUE_NOISE * np.sqrt(np.mean(computed**2, axis=0)) * draw.normal((len(t), 2))
    exact = _torque(dynamics, *reference(_stages(_SUBSTEPS)), WRONG * X_TRUE)
    true = _integrated(dynamics, np.repeat(X_TRUE[None], runs, 0), exact, _SUBSTEPS, noise)
    return Runs(t, *_measured(draw, *true, tachometer), np.repeat(computed[None], runs, 0))


def free_run(dynamics: Dynamics, X: FloatArray, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the motion of the model under known torques, free of noise: q, qd (runs, N, 2).

    Args:
        dynamics: of the robot.
        X: parameters of each run, (runs, 4).
        tau: torques at the sampling times, the same for all runs, (N, 2); a spline between.
    """
    known = interpolated(times(), tau)(_stages(_COARSE))
    return _integrated(dynamics, X, known, _COARSE, np.zeros((len(X), len(tau), 2)))


def _stages(substeps: int) -> FloatArray:
    """Return the times at which an integration looks at the torque: ends and middles of steps."""
    return np.arange(2 * substeps * SAMPLES + 1) * (np.float64(STEP) / (2 * substeps))


def _integrated(
    dynamics: Dynamics, X: FloatArray, tau: FloatArray, substeps: int, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Integrate from the start of the reference, by Runge and Kutta's fourth-order rule.

    Args:
        dynamics: of the robot.
        X: parameters of each run, (runs, 4).
        tau: torques at `_stages(substeps)`.
        substeps: steps a sample.
        noise: added to the torque, constant over a sample, (runs, N, 2).
    """
    runs = len(X)
    forward, parameters = dynamics.forward.map(runs), X.T

    def rate(q: FloatArray, qd: FloatArray, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        return qd, np.array(forward(q, qd, tau, parameters))

    start = reference(np.zeros(1))
    q, qd = (np.repeat(x.T, runs, 1) for x in start[:2])
    states = [(q, qd)]
    h = STEP / substeps
    for k in range(SAMPLES):
        for i in range(substeps):
            at = 2 * (k * substeps + i)
            first, middle, last = (w[:, None] + noise[:, k].T for w in tau[at : at + 3])
            a1, b1 = rate(q, qd, first)
            a2, b2 = rate(q + h / 2 * a1, qd + h / 2 * b1, middle)
            a3, b3 = rate(q + h / 2 * a2, qd + h / 2 * b2, middle)
            a4, b4 = rate(q + h * a3, qd + h * b3, last)
            q = q + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            qd = qd + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
        states.append((q, qd))
    q, qd = (np.array([s[i].T for s in states]).transpose(1, 0, 2) for i in (0, 1))
    return q, qd


def proportional_run(dynamics: Dynamics, seed: int | None = None) -> Runs:
    """Return the motion the paper warns of: joint 2 moves as joint 1 does, at half its speed."""
    t = times()
    q, qd, qdd = (np.stack([x[:, 0], 0.5 * x[:, 0]], axis=-1) for x in reference(t))
    tau = _torque(dynamics, q, qd, qdd, X_TRUE)
    if seed is not None:
        draw = _Noise(np.random.default_rng([seed, 3]), 1, False)
        (q,), (qd,) = _measured(draw, q[None], qd[None])
    return Runs(t, q[None], qd[None], tau[None])


@dataclass(frozen=True, eq=False)
class _Noise:
    """Random numbers of shape (runs, *shape); mirrored, the second half negates the first."""

    draw: np.random.Generator
    runs: int
    mirrored: bool

    def normal(self, shape: tuple[int, ...]) -> FloatArray:
        return self._signed(self.draw.normal(size=(self._count(), *shape)))

    def uniform(self, half: float, shape: tuple[int, ...]) -> FloatArray:
        return self._signed(self.draw.uniform(-half, half, (self._count(), *shape)))

    def _count(self) -> int:
        return (self.runs + 1) // 2 if self.mirrored else self.runs

    def _signed(self, x: FloatArray) -> FloatArray:
        return np.concatenate([x, -x])[: self.runs] if self.mirrored else x


def _measured(
    draw: _Noise, q: FloatArray, qd: FloatArray, tachometer: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Add the encoders' error, uniform over a step, and the tachometers' noise."""
    step = 2 * math.pi / _ENCODER_POINTS
    return (
        q + draw.uniform(step / 2, q.shape[1:]),
        qd + tachometer * _TACHOMETER * draw.normal(qd.shape[1:]),
    )


def _torque(
    dynamics: Dynamics, q: FloatArray, qd: FloatArray, qdd: FloatArray, X: FloatArray
) -> FloatArray:
    """Return the torque (N, 2) of the robot with parameters X along a motion."""
    count = len(q)
    function = dynamics.inverse.map(count)
    return np.array(function(q.T, qd.T, qdd.T, np.repeat(X[:, None], count, 1))).T
