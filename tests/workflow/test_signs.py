"""A gear that turns the other way than [drive] says is named, where the logs can tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symgen

ARM = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[[joint]]
rotor_inertia = false
[[joint]]
d = 0.5
rotor_inertia = false
"""


@pytest.fixture(scope="module")
def motors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of motors behind gears of 100 and 80, of an arm written by hand."""
    t = np.arange(0, 20, 0.005)
    amplitude = np.array([[1.2, 0.6], [1.0, 0.7]])
    rate, phase = np.array([[1.1, 2.3], [1.7, 3.1]]), np.array([[0, 0], [1, 0]])
    angle = rate[:, :, None] * t + phase[:, :, None]
    q = np.einsum("jk,jkt->tj", amplitude, np.sin(angle))
    qd = np.einsum("jk,jkt->tj", amplitude * rate, np.cos(angle))
    qdd = np.einsum("jk,jkt->tj", -amplitude * rate**2, np.sin(angle))
    m2, l2, i2, i1, g, L = 2.0, 0.25, 0.03, 0.6, 9.81, 0.5
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    h = m2 * L * l2
    m22 = i2 + m2 * l2**2
    m12 = m22 + h * c
    m11 = i1 + m22 + m2 * L**2 + 2 * h * c
    weight = m2 * g * l2 * np.cos(q.sum(axis=1))
    tau = np.stack(
        [
            m11 * qdd[:, 0] + m12 * qdd[:, 1] - h * s * (2 * qd[:, 0] + qd[:, 1]) * qd[:, 1]
            + (1.5 + m2 * L) * g * np.cos(q[:, 0]) + weight,
            m12 * qdd[:, 0] + m22 * qdd[:, 1] + h * s * qd[:, 0] ** 2 + weight,
        ],
        axis=1,
    )  # fmt: skip
    tau += 0.4 * np.sign(qd) + 0.5 * qd + 0.05 * np.random.default_rng(0).normal(size=q.shape)
    path = tmp_path_factory.mktemp("motors") / "log.npz"
    gears = np.array([100.0, 80.0])
    np.savez(path, t=t, q=q * gears, qd=qd * gears, tau=tau / gears)
    return path


@pytest.mark.parametrize("model", ["energy", "torque"])
@pytest.mark.parametrize(("ratio", "joint"), [("[100, -80]", 2), ("[-100, 80]", 1)])
def test_the_joint_whose_gear_turns_the_other_way_is_named(motors, model, ratio, joint) -> None:
    robot = symgen.parse_robot(f"{ARM}[drive]\nratio = {ratio}\n")
    estimate = symgen.identify(robot, motors, model=model)
    assert estimate.verdict == "doubtful"
    assert any(f"joint {joint} fits better with the other sign" in r for r in estimate.reasons)


@pytest.mark.parametrize("model", ["energy", "torque"])
def test_the_right_signs_are_trusted(motors, model) -> None:
    robot = symgen.parse_robot(f"{ARM}[drive]\nratio = [100, 80]\n")
    estimate = symgen.identify(robot, motors, model=model)
    assert estimate.verdict == "trusted", estimate.reasons
