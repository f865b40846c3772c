"""Joints that move in proportion: what is determined is solved and predicts, the rest is said.

The arm is the paper's, its torques from its closed form, friction and instruments written here.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from oracles import planar2r

import symgen

X, L1 = np.array([1.702, 0.05644, 0.15, 0.075]), 0.5
FS, FV = np.array([0.25, 0.08]), np.array([0.15, 0.05])
STEP, NOISE = 0.008, 0.01
ROBOT = """
[robot]
name = "tried"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["coulomb", "viscous"]
[[joint]]
d = 0.5
friction = ["coulomb", "viscous"]
"""
#: With q2 = q1/2 each inertia is felt in one combination with the others.
HIDDEN = ["ZZ1R", "ZZ2", "IA2"]


@cache
def log(name: str, seed: int, own: float = 0.0, noise: float = 1.0) -> symgen.Log:
    """Joint 2 moves half as far as joint 1, and `own` of a motion of its own besides."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 16.0, STEP)
    w = np.array([[1.1, 1.7], [2.9, 4.3]])
    phase, a = rng.uniform(0, 2 * np.pi, w.shape), np.array([[0.8, 0.8], [0.3, 0.3]])
    angle = t[:, None, None] * w + phase
    shapes = (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle))
    mixed = np.array([[1.0, 0.5], [0.0, own]])
    q, qd, qdd = (np.sum(x, axis=1) @ mixed for x in shapes)
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += 9.81 * 0.05 * np.column_stack([4 * np.cos(q[:, 0]), 0 * t])
    tau += 9.81 * 0.05 * np.cos(q.sum(1))[:, None] + FS * np.sign(qd) + FV * qd
    tau += NOISE * np.std(tau, axis=0) * rng.normal(size=tau.shape)
    q = q + noise * 1e-5 * rng.normal(size=q.shape)
    return symgen.make_log(name, t, q, tau, qd + noise * 1e-3 * rng.normal(size=q.shape))


def hidden(estimate: symgen.Estimate) -> list[str]:
    return [p.name for p in estimate.parameters if math.isnan(p.std)]


@pytest.mark.parametrize("noise", [0.0, 1.0, 10.0])
def test_what_moves_in_proportion_predicts_and_what_is_not_determined_is_named(noise) -> None:
    train, held = log("a", 2, noise=noise), log("b", 3, noise=noise)
    found = symgen.identify(symgen.parse_robot(ROBOT), train, validation=held)
    assert hidden(found) == HIDDEN
    assert found.to_json()["possible"] is None
    assert found.verdict == "trusted", found.reasons
    # Noise of 1 % of the torque, in a comparison band that lets a part of it pass; sign(qd) at
    # reversals of filtered speeds is the rest.
    assert found.torque_validation.relative < 0.03
    (restriction,) = found.uses.simulation.reasons
    assert (restriction.kind, restriction.joints) == ("in_proportion", (1, 2))
    assert not set(HIDDEN) & set(found.uses.parameters.known)
    reason = next(r for r in found.uses.parameters.reasons if r.kind == "not_determined")
    assert reason.value == len(HIDDEN)
    assert ", ".join(HIDDEN) in reason.text
    truth = {"FS1": FS[0], "FS2": FS[1], "FV1": FV[0], "FV2": FV[1], "MX2": 0.05}
    for p in found.parameters:
        if p.name in truth:
            assert abs(p.value - truth[p.name]) < 4 * p.std, p


def test_motion_out_of_proportion_is_judged_by_its_error() -> None:
    robot = symgen.parse_robot(ROBOT)
    found = symgen.identify(robot, log("a", 2, own=0.003), validation=log("b", 3, own=1.0))
    assert found.torque_train.relative < 0.03 < 0.2 < found.torque_validation.relative
    assert found.verdict == "doubtful"


def test_a_prior_tells_what_the_motion_does_not(tmp_path: Path) -> None:
    robot, logs = symgen.parse_robot(ROBOT), (log("a", 2), log("b", 3))
    names = [p.name for p in symgen.identify(robot, logs[0], validation=logs[1]).parameters]
    values = dict.fromkeys(names, 0.1) | {"IA2": 1e-3, "ZZ2": X[1], "MX2": 0.05}
    lines = [f"{name} = {value}" for name, value in values.items()]
    (tmp_path / "prior.toml").write_text("\n".join(["[parameters]", *lines]))
    fit = symgen.Fit(prior=tmp_path / "prior.toml")
    found = symgen.identify(robot, logs[0], validation=logs[1], model="torque", fit=fit)
    assert hidden(found) == []
