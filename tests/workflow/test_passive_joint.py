"""A double pendulum whose first joint has no motor: `actuated = false`, and what is said without.

The pendulum is moved here by its closed form and the Runge-Kutta method of order 4.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.diagnosis.messages import summary
from symgen.estimation.estimators import ESTIMATORS
from symgen.estimation.system import Extent, Rows

ZZ1R, MX1R, ZZ2, MX2, FV, STEP = 1.33, 1.5, 1.33, 1.0, 0.05, 0.005
TRUE = {"ZZ1R": ZZ1R, "MX1R": MX1R, "ZZ2": ZZ2, "MX2": MX2, "FV1": FV, "FV2": FV}
ROBOT = """[robot]
name = "pendulum"
gravity = [0.0, -9.81, 0.0]
[[joint]]
name = "shoulder"
rotor_inertia = false
friction = ["viscous"]
{}
[[joint]]
name = "elbow"
d = 1.0
rotor_inertia = false
friction = ["viscous"]
"""
PASSIVE = ROBOT.format("actuated = false")
MJCF = """<mujoco><worldbody>
<body><joint name="shoulder" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -1" size="0.04"/>
<body pos="0 0 -1"><joint name="elbow" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -1" size="0.04"/></body></body></worldbody>
<actuator><motor joint="elbow"/>{}</actuator></mujoco>"""


def accelerated(x: np.ndarray, tau: float) -> np.ndarray:
    q1, q2, v1, v2 = x
    c, s = MX2 * np.cos(q2), MX2 * np.sin(q2)
    M = np.array([[ZZ1R + ZZ2 + 2 * c, ZZ2 + c], [ZZ2 + c, ZZ2]])
    both = 9.81 * MX2 * np.cos(q1 + q2)
    h = np.array([9.81 * MX1R * np.cos(q1) + both - s * v2 * (2 * v1 + v2), both + s * v1 * v1])
    return np.concatenate([[v1, v2], np.linalg.solve(M, [0.0, tau] - h - FV * x[2:])])


@cache
def swung(seed: int) -> tuple[np.ndarray, ...]:
    """t, q, qd and tau of a swing, with noise of the instruments; tau1 is zero."""
    rng = np.random.default_rng(seed)
    phase, t = rng.uniform(0, 2 * np.pi, 3), np.arange(0.0, 15.0, STEP)
    x, states, torques = np.array([-1.5, 0.2, 0.0, 0.0]), [], []
    for now in t:
        tau = 2 * np.sin(np.multiply([1.9, 3.1, 4.7], now) + phase).sum() - 4 * x[1]
        states.append(x)
        torques.append(tau)
        k1 = accelerated(x, tau)
        k2 = accelerated(x + STEP / 2 * k1, tau)
        k3 = accelerated(x + STEP / 2 * k2, tau)
        k4 = accelerated(x + STEP * k3, tau)
        x = x + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    q, qd = np.split(np.array(states), 2, axis=1)
    tau = np.column_stack([0 * t, torques])
    held = (tau + np.roll(tau, 1, axis=0)) / 2  # each is held from stamp to stamp
    held[:, 1] += 0.02 * rng.normal(size=len(t))
    q, qd = q + 1e-4 * rng.normal(size=q.shape), qd + 0.05 * rng.normal(size=q.shape)
    return t, q, qd, held


def logs(folder: Path, shoulder: float | str) -> list[Path]:
    """Write a training and a validation log; the shoulder's torque is noise, or a text's sine."""
    out = []
    for seed in (1, 2):
        t, q, qd, tau = swung(seed)
        tau = tau.copy()
        rng = np.random.default_rng(seed)
        tau[:, 0] = np.sin(t) if shoulder == "sine" else shoulder * rng.normal(size=len(t))
        out.append(folder / f"{seed}.npz")
        np.savez(out[-1], t=t, q=q, qd=qd, tau=tau)
    return out


def identified(command, folder: Path, robot: str, shoulder: float | str) -> tuple[int, dict]:
    (folder / "robot.toml").write_text(robot)
    train, held = logs(folder, shoulder)
    asked = ("identify", folder / "robot.toml", train, "--validation", held)
    code, _, err = command(*asked, "--into", folder / "out")
    assert code in (0, 1), err
    return code, json.loads((folder / "out" / "estimate.json").read_text())


def require_true(estimate: dict) -> None:
    found = {p["name"]: p["value"] for p in estimate["parameters"]}
    assert TRUE.keys() <= found.keys()
    for name, value in found.items():
        near = 0.005 if name[0] == "F" else 0.015
        assert value == pytest.approx(TRUE.get(name, 0.0), abs=near), name


@pytest.mark.parametrize("shoulder", [0.0, 0.01, "sine"])
def test_no_torque_counts_on_a_joint_without_motor(command, tmp_path, shoulder) -> None:
    code, estimate = identified(command, tmp_path, PASSIVE, shoulder)
    assert code == 0, estimate["reasons"]
    require_true(estimate)


def test_the_headline_is_that_of_the_joint_with_a_motor(command, tmp_path) -> None:
    _, estimate = identified(command, tmp_path, PASSIVE, 0.0)
    error = estimate["torque_residual_in_motion"]
    assert error["relative"] == error["per_joint"][1]


@pytest.mark.parametrize("shoulder", [0.0, 0.01])
def test_a_torque_of_noise_alone_is_named_with_the_option(command, tmp_path, shoulder) -> None:
    code, estimate = identified(command, tmp_path, ROBOT.format(""), shoulder)
    assert code == 1
    reason = next(r["text"] for r in estimate["reasons"] if r["kind"] == "broken_channel")
    assert reason.startswith("tau1 of 1.npz")
    assert "actuated = false" in reason
    assert "leave that time out" not in reason
    require_true(estimate)


def test_a_diagnosis_blames_no_drive_that_is_not_there(tmp_path) -> None:
    train, held = logs(tmp_path, 0.01)
    found = symgen.diagnose(
        symgen.parse_robot(PASSIVE), [train], validation=[held],
        effects=["drive_gain_error", "gravity_spring"],
    )  # fmt: skip
    assert found.verdict == "consistent"
    assert not any(e.adopted for e in found.effects)
    floor = found.floor.total
    for times, said in ((2.5, False), (7.3, True)):
        after = replace(found.after, total=times * floor)
        headline = summary(replace(found, verdict="explained", after=after, moving=None))
        assert (f"{times:g} times" in headline) == said


@pytest.mark.parametrize("method", ["wls", "huber"])
def test_equations_without_torque_do_not_take_the_parameters_to_zero(method) -> None:
    rng = np.random.default_rng(3)
    X, W = np.array([1.0, -0.5, 0.3]), rng.normal(size=(2, 4000, 3))
    W[0] -= np.outer(W[0] @ X, X) / (X @ X)  # 0 = W X
    noisy = W + 0.5 * rng.normal(size=W.shape)
    y = np.column_stack([np.zeros(4000), W[1] @ X])
    about = np.arange(4000.0), np.ones(y.shape), (Extent(4000, 1),)
    rows = Rows(("A", "B", "C"), noisy.swapaxes(0, 1), y, *about)
    found = ESTIMATORS[method].solve(rows)
    assert np.linalg.norm(found.X - X) < 0.4 * np.linalg.norm(X)  # of least squares: 0.34


def test_a_robot_file_is_written_as_it_was_read() -> None:
    robot = symgen.parse_robot(PASSIVE)
    assert [joint.actuated for joint in robot.joints] == [False, True]
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot
    with pytest.raises(symgen.RobotError, match=r"joint 1, key 'actuated'"):
        symgen.parse_robot(ROBOT.format('actuated = "no"'))


def test_a_simulation_that_drives_every_joint_is_refused(command, tmp_path) -> None:
    (tmp_path / "robot.toml").write_text(PASSIVE)
    (tmp_path / "x.toml").write_text(
        "[parameters]\n" + "".join(f"{name} = {value}\n" for name, value in TRUE.items())
    )
    code, _, err = command(
        "simulate", tmp_path / "robot.toml", "--parameters", tmp_path / "x.toml", "--into",
        tmp_path / "log.csv",
    )  # fmt: skip
    assert code == 2
    assert "shoulder" in err
    assert "actuated = false" in err


def test_an_mjcf_asks_for_the_motor_of_a_joint_without_actuator(command, tmp_path) -> None:
    pytest.importorskip("mujoco")
    for name, more in (("half", ""), ("whole", '<motor joint="shoulder"/>')):
        (tmp_path / f"{name}.xml").write_text(MJCF.format(more))
    code, _, err = command("import", tmp_path / "half.xml", "--into", tmp_path / "robot.toml")
    assert code == 0
    assert "shoulder" in err
    assert "actuated = false" in err
    assert "actuated" not in (tmp_path / "robot.toml").read_text()
    assert "actuated" not in command("import", tmp_path / "whole.xml")[2]


def test_a_joint_without_a_motor_is_not_blamed_for_one() -> None:
    """With a wrong length, no channel of the shoulder has another unit, gear, sign or offset."""
    short = symgen.parse_robot(PASSIVE.replace("d = 1.0", "d = 0.4"))
    logs = []
    for seed in (1, 2):
        t, q, qd, tau = swung(seed)
        logs.append(symgen.make_log(f"{seed}", t, q, tau, qd))
    found = symgen.diagnose(short, logs[0], validation=logs[1])
    blamed = {e.name for e in found.effects if 1 in e.joints}
    assert not blamed & {"wrong_unit", "gear_ratio", "exchanged_channels", "torque_offset"}
