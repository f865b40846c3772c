"""Friction that a robot file leaves out of every joint: named as friction, and no sensor is late.

The arm is the paper's with gravity, its rigid torques from closed forms, friction written here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from oracles import planar2r

import symgen

X, L1, STEP = np.array([1.702, 0.05644, 0.15, 0.075]), 0.5, 0.004
FS, FV = np.array([1.0, 0.4]), np.array([0.6, 0.25])
ROBOT = """
[robot]
name = "bare"
gravity = [0.0, 0.0, -9.81]
[[joint]]
friction = []
[[joint]]
d = 0.5
friction = []
"""


def log(name: str, seed: int, friction: Callable[[np.ndarray], np.ndarray]) -> symgen.Log:
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 20.0, STEP)
    w = np.array([[0.9, 1.3], [2.1, 2.7], [3.7, 4.6]])
    a, phase = np.array([[0.7], [0.35], [0.2]]), rng.uniform(0, 2 * np.pi, w.shape)
    angle = t[:, None, None] * w + phase
    waves = (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle))
    q, qd, qdd = (x.sum(axis=1) for x in waves)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += friction(qd)
    tau += 0.01 * np.std(tau, axis=0) * rng.normal(size=tau.shape)
    return symgen.make_log(name, t, q + 1e-6 * rng.normal(size=q.shape), tau, qd)


def found(friction: Callable[[np.ndarray], np.ndarray]) -> symgen.Diagnosis:
    logs = log("train", 1, friction), log("test", 2, friction)
    return symgen.diagnose(symgen.parse_robot(ROBOT), logs[:1], validation=logs[1:])


def test_coulomb_and_viscous_friction_are_named_on_both_joints() -> None:
    answer = found(lambda v: FS * np.sign(v) + FV * v)
    names = {(e.name, e.joints) for e in answer.effects}
    assert names == {(f"{w}_friction", (j,)) for w in ("coulomb", "viscous") for j in (1, 2)}
    values = {p.name: p.value for p in answer.parameters}
    for j in (1, 2):
        assert values[f"FS{j}"] == pytest.approx(FS[j - 1], rel=0.05)
        assert values[f"FV{j}"] == pytest.approx(FV[j - 1], rel=0.05)
    assert answer.verdict == "explained"
    assert all(
        "friction" in joint for joint in symgen.robot_toml(answer.extended).split("[[joint]]")[1:]
    )


def test_friction_that_rises_from_rest_is_no_stribeck_friction() -> None:
    def rises(v: np.ndarray) -> np.ndarray:
        return FS * np.sign(v) * (1 - 0.4 * np.exp(-((v / 0.3) ** 2)))

    logs = log("train", 1, rises), log("test", 2, rises)
    effects = ["coulomb_friction", "stribeck_friction"]
    answer = symgen.diagnose(
        symgen.parse_robot(ROBOT), logs[:1], validation=logs[1:], effects=effects
    )
    assert [(e.name, e.joints) for e in answer.effects] == [
        ("coulomb_friction", (1,)),
        ("coulomb_friction", (2,)),
    ]
