"""Friction with hysteresis, and cogging of a motor behind its gear, put into an arm's torque.

The arm is the paper's with gravity, its rigid torques from closed forms; what is hidden is written
here: Dahl's state is integrated step by step, cogging is a sine of the motor's angle.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles import planar2r

import symgen

X, L1, STEP = np.array([1.702, 0.05644, 0.15, 0.075]), 0.5, 0.002
FS, FV = np.array([1.0, 0.4]), np.array([0.6, 0.25])
RATIO, PERIODS = 60.0, 4
ROBOT = planar2r.robot_toml("hidden")
DRIVE = f"""
[drive]
ratio = [{RATIO}, {RATIO}]
position_side = "joint"
torque_side = "joint"
"""


def motion(seed: int, speed: float, seconds: float) -> tuple[np.ndarray, ...]:
    """t, q, qd, qdd of sums of three sines."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, STEP)
    w = speed * np.array([[0.9, 1.3], [2.1, 2.7], [3.7, 4.6]])
    a, phase = np.array([[0.7], [0.35], [0.2]]), rng.uniform(0, 2 * np.pi, w.shape)
    angle = t[:, None, None] * w + phase
    waves = (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle))
    return (t, *(x.sum(axis=1) for x in waves))


def dahl(q: np.ndarray, width: float) -> np.ndarray:
    """The state z, dz = dq (1 - z sign(dq))/width, in 20 steps a sample."""
    z, out = float(np.sign(q[1] - q[0])), [0.0] * len(q)
    for k in range(1, len(q)):
        out[k - 1] = z
        dq = (q[k] - q[k - 1]) / 20
        for _ in range(20):
            z += dq * (1 - z * np.sign(dq)) / width
    out[-1] = z
    return np.array(out)


def log(name: str, seed: int, hidden: str, speed: float = 1.0, seconds: float = 20.0) -> symgen.Log:
    t, q, qd, qdd = motion(seed, speed, seconds)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += FS * np.sign(qd) + FV * qd
    if hidden == "dahl":
        tau[:, 1] += 0.5 * dahl(q[:, 1], 0.1)
    if hidden == "cogging":
        tau[:, 1] += 0.15 * np.sin(PERIODS * RATIO * q[:, 1] + 0.4)
    rng = np.random.default_rng(seed + 100)
    tau += 0.01 * np.std(tau, axis=0) * rng.normal(size=tau.shape)
    return symgen.make_log(name, t, q + 1e-6 * rng.normal(size=q.shape), tau, qd)


def found(robot: str, hidden: str, **how: float) -> symgen.Diagnosis:
    return symgen.diagnose(
        symgen.parse_robot(robot),
        [log("train", 1, hidden, **how)],
        validation=[log("test", 2, hidden, **how)],
    )


def test_hysteresis_is_named_with_its_width() -> None:
    answer = found(ROBOT, "dahl")
    assert [(e.name, e.joints) for e in answer.effects][:1] == [("presliding_friction", (2,))]
    values = {p.name: p.value for p in answer.effects[0].parameters}
    assert values["FD2"] == pytest.approx(0.5, rel=0.15)
    assert values["xs2"] == pytest.approx(0.1, rel=0.4)
    assert "rad" in [p.unit for e in answer.effects for p in e.parameters if p.name == "xs2"]
    assert answer.after.total < 0.5 * answer.before.total


def test_cogging_is_told_in_periods_of_the_motor() -> None:
    answer = found(ROBOT + DRIVE, "cogging", speed=0.02, seconds=120.0)
    assert [(e.name, e.joints) for e in answer.effects] == [("motor_cogging", (2,))]
    values = {p.name: p.value for p in answer.effects[0].parameters}
    assert values["k2"] == pytest.approx(PERIODS * RATIO, rel=1e-3)
    assert np.hypot(values["CS2"], values["CC2"]) == pytest.approx(0.15, rel=0.05)
    assert "motor_cogging" in symgen.robot_toml(answer.extended)


@pytest.mark.parametrize("robot", [ROBOT, ROBOT + DRIVE])
def test_an_arm_without_them_is_consistent(robot) -> None:
    assert found(robot, "").verdict == "consistent"
