"""The example of Gautier and Khalil (1988): two revolute joints, its motion, noise and set-ups.

Joint 1 follows a cubic, q1 = D (3 s^2 - 2 s^3) with s = t/T; joint 2 a sine, q2 = A (1 - cos w t).
Set-up (a), the paper's figure 3: the robot follows the reference exactly, the measurements alone
are noisy. Set-up (b), its figure 2: torques computed from wrong parameters X_d, plus torque noise,
drive a simulated robot; what is known to the identification is the computed torque.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.casadi_model import Dynamics

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
_SUBSTEPS = 8


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


def exact_run(dynamics: Dynamics) -> Runs:
    """Return the reference with its torque and no noise at all."""
    t = times()
    q, qd, qdd = reference(t)
    return Runs(t, q[None], qd[None], _torque(dynamics, q, qd, qdd, X_TRUE)[None])


def setup_a(dynamics: Dynamics, runs: int, seed: int) -> Runs:
    """Return runs that follow the reference exactly, with noisy measurements."""
    clean = exact_run(dynamics)
    draw = np.random.default_rng([seed, 1])
    q, qd = _measured(draw, np.repeat(clean.q, runs, 0), np.repeat(clean.qd, runs, 0))
    return Runs(clean.t, q, qd, np.repeat(clean.tau, runs, 0))


def setup_b(dynamics: Dynamics, runs: int, seed: int) -> Runs:
    """Return runs of a simulated robot driven by wrong computed torques plus torque noise.

    The robot is integrated by Runge and Kutta's fourth-order rule, 8 steps a sample; the noise is
    constant over a sample.
    """
    t = times()
    draw = np.random.default_rng([seed, 2])
    computed = _torque(dynamics, *reference(t), WRONG * X_TRUE)
    noise = (
        TORQUE_NOISE * np.sqrt(np.mean(computed**2, axis=0)) * draw.normal(size=(len(t), runs, 2))
    )
    forward = dynamics.forward.map(runs)
    parameters = np.repeat(X_TRUE[:, None], runs, 1)

    def rate(q: FloatArray, qd: FloatArray, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        return qd, np.array(forward(q, qd, tau, parameters))

    start = reference(t[:1])
    q = np.repeat(start[0].T, runs, 1)
    qd = np.repeat(start[1].T, runs, 1)
    states = [(q, qd)]
    h = STEP / _SUBSTEPS
    for k in range(SAMPLES):
        for i in range(_SUBSTEPS):
            at = t[k] + h * np.array([i, i + 0.5, i + 1])
            first, middle, last = (
                wanted[:, None] + noise[k].T
                for wanted in _torque(dynamics, *reference(at), WRONG * X_TRUE)
            )
            a1, b1 = rate(q, qd, first)
            a2, b2 = rate(q + h / 2 * a1, qd + h / 2 * b1, middle)
            a3, b3 = rate(q + h / 2 * a2, qd + h / 2 * b2, middle)
            a4, b4 = rate(q + h * a3, qd + h * b3, last)
            q = q + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            qd = qd + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
        states.append((q, qd))
    true_q = np.array([s[0].T for s in states]).transpose(1, 0, 2)
    true_qd = np.array([s[1].T for s in states]).transpose(1, 0, 2)
    measured = _measured(draw, true_q, true_qd)
    return Runs(t, *measured, np.repeat(computed[None], runs, 0))


def proportional_run(dynamics: Dynamics, seed: int | None = None) -> Runs:
    """Return the motion the paper warns of: joint 2 moves as joint 1 does, at half its speed."""
    t = times()
    q, qd, qdd = (np.stack([x[:, 0], 0.5 * x[:, 0]], axis=-1) for x in reference(t))
    tau = _torque(dynamics, q, qd, qdd, X_TRUE)
    if seed is not None:
        q, qd = _measured(np.random.default_rng([seed, 3]), q, qd)
    return Runs(t, q[None], qd[None], tau[None])


def _measured(
    draw: np.random.Generator, q: FloatArray, qd: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Add the encoders' error, uniform over a step, and the tachometers' noise."""
    step = 2 * math.pi / _ENCODER_POINTS
    return (
        q + draw.uniform(-step / 2, step / 2, q.shape),
        qd + _TACHOMETER * draw.normal(size=qd.shape),
    )


def _torque(
    dynamics: Dynamics, q: FloatArray, qd: FloatArray, qdd: FloatArray, X: FloatArray
) -> FloatArray:
    """Return the torque (N, 2) of the robot with parameters X along a motion."""
    count = len(q)
    function = dynamics.inverse.map(count)
    return np.array(function(q.T, qd.T, qdd.T, np.repeat(X[:, None], count, 1))).T
