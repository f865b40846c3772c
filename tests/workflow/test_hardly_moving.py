"""Logs in which a joint does not move, or the arm rests: no number that is trusted and wrong."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from oracles.arm import HANGING, IN_PLANE, sines
from oracles.planar2r import robot_toml
from support import sampled

import symgen

STEP = 0.004
ROBOT = robot_toml("tried", gravity=IN_PLANE)


def log(name: str, size: float, seed: int, speeds: bool = True, rest: float = 0.0) -> symgen.Log:
    """Joint 2 swings by `size` rad; at the end, brakes hold for `rest` s and the drives are off."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 16.0, STEP)
    w = np.array([[1.1, 1.7], [2.9, 4.3]])
    phase = rng.uniform(0, 2 * np.pi, w.shape)
    own, pace, slope = slowed(t) if rest else (t, 1 + 0 * t, 0 * t)
    q, first, second = sines(own, np.outer([0.8, 0.3], [1.0, size]), w, phase)
    qd = first * pace[:, None]
    qdd = second * pace[:, None] ** 2 + first * slope[:, None]
    tau = HANGING.torque(q, qd, qdd)
    tau += 0.01 * np.std(tau, axis=0) * rng.normal(size=tau.shape)
    if rest:
        k = round(rest / STEP)
        q = np.concatenate([q, np.repeat(q[-1:], k, axis=0)])
        qd, tau = (np.concatenate([x, np.zeros((k, 2))]) for x in (qd, tau))
        t = np.arange(len(q)) * STEP
    q = q + 1e-5 * rng.normal(size=q.shape)
    qd = qd + 1e-3 * rng.normal(size=q.shape)
    return symgen.make_log(name, t, q, tau, qd if speeds else None)


def slowed(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A time that stops smoothly over the last two seconds of t, with its two derivatives."""
    x = np.clip(np.pi / 2 * (t - t[-1] + 2.0), 0.0, np.pi)
    pace, slope = (1 + np.cos(x)) / 2, -np.pi / 4 * np.sin(x)
    return np.minimum(t, t[-1] - 2.0) + (x + np.sin(x)) / np.pi, pace, slope


@pytest.fixture(scope="module")
def robot() -> symgen.Robot:
    """The robot, its model compiled."""
    found = symgen.parse_robot(ROBOT)
    symgen.identify(found, log("a", 1.0, 2), model="torque")
    return found


URDF = """<robot name="two"><link name="a"/><link name="b"/><link name="c"/>
<joint name="shoulder" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
</joint><joint name="finger tip" type="continuous"><parent link="b"/><child link="c"/>
<origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint></robot>"""


@pytest.mark.parametrize("verb", ["identify", "diagnose"])
def test_a_joint_that_stands_still_is_refused_first_with_the_command(
    command, tmp_path, monkeypatch, verb
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(URDF)
    one = log("still", 0.0, 1)
    held = one.q + np.array([0.0, 0.02 - one.q[0, 1]])
    np.savez(tmp_path / "still.npz", t=one.t, q=held, qd=one.qd, tau=one.tau)
    code, _, err = command(verb, "arm.urdf", "still.npz", "--into", "out")
    assert code == 2
    assert "deriving" not in err
    advice = re.search(r"symgen (import arm.urdf --fix .* --into robot.toml)", err)
    assert advice is not None, err
    code, out, err = command(*shlex.split(advice[1]))
    assert code == 0, err
    assert "held at 0.02" in out
    assert symgen.read_robot("robot.toml").n == 1


def test_all_joints_that_rest_are_named_at_once(command, tmp_path, monkeypatch) -> None:
    """One joint moves, one stands, and one is shaken by the motion of the first."""
    monkeypatch.chdir(tmp_path)
    links = URDF.replace(
        "</robot>",
        '<link name="d"/><joint name="wrist" type="continuous"><parent link="c"/><child link="d"/>'
        '<origin xyz="0.3 0 0"/><axis xyz="0 1 0"/></joint></robot>',
    )
    Path("arm.urdf").write_text(links)
    one = log("still", 0.0, 1)
    shaken = 0.5 + 1e-3 * (one.q[:, 0] - one.q[0, 0])
    q, tau = (np.column_stack([x, shaken]) for x in (one.q, one.tau))
    np.savez("still.npz", t=one.t, q=q, tau=tau)
    code, _, err = command("identify", "arm.urdf", "still.npz", "--into", "out")
    assert code == 2
    advice = re.search(r"symgen (import arm.urdf --fix .* --into robot.toml)", err)
    assert advice is not None, err
    assert command(*shlex.split(advice[1]))[0] == 0
    assert symgen.read_robot("robot.toml").joint_names == ["shoulder"]
    asked = ["robot.toml", "still.npz", "--model", "torque", "--into", "out"]
    code, _, err = command("identify", *asked)
    assert code in (0, 1), err


@pytest.mark.parametrize("mask", [(), ("rest",)])
def test_a_diagnosis_of_logs_in_each_of_which_one_joint_moves(robot, mask) -> None:
    whole, logs = log("a", 1.0, 2), []
    for k in range(4):
        q, qd, tau = (x.copy() for x in (whole.q, whole.qd, whole.tau))
        for x, level in ((q, 0.3 * k), (qd, 0.0), (tau, 1.0)):
            x[:, k % 2] = level
        logs.append(symgen.make_log(f"log{k}", whole.t, q, tau, qd))
    found = symgen.diagnose(
        robot, logs, effects=["gravity_spring"], reading=symgen.Reading(mask=mask)
    )
    assert found.before.total > 0


@pytest.mark.parametrize("size", sampled([5e-4, 5e-3], 0, always=[5e-4]))
def test_a_joint_that_hardly_moves_is_suspected(robot, size) -> None:
    logs = [log("a", size, 2)], [log("b", size, 3)]
    estimate = symgen.identify(robot, logs[0], validation=logs[1], model="torque")
    (reason,) = [r for r in estimate.suspected if r.kind == "hardly_moving"]
    assert reason.joints == (2,)
    assert reason.value == pytest.approx(np.ptp(logs[0][0].q[:, 1]), rel=0.1)


@pytest.mark.parametrize("size", sampled([3e-5, 3e-4, 1e-3], 1, always=[3e-4]))
def test_logs_that_hardly_move_have_a_possible_robot(robot, size) -> None:
    """One with the torques of least squares, though rotor inertia and friction are unknown."""
    logs = [log("a", size, 2)], [log("b", size, 3)]
    found = symgen.identify(robot, logs[0], validation=logs[1], model="torque", method="consistent")
    assert (found.possible, found.method) == (True, "consistent")
    assert 0 < found.physical.distance_sigma < 3
    least, possible = found.physical.held_out
    assert possible < 1.1 * least
    symgen.link_parameters(symgen.derive(robot), found.X)


def test_a_joint_that_moves_is_trusted(robot) -> None:
    estimate = symgen.identify(robot, [log("a", 1.0, 2)], validation=[log("b", 1.0, 3)])
    assert estimate.verdict == "trusted", estimate.reasons


def test_brakes_at_the_end_spoil_nothing_and_are_told_apart(command, tmp_path) -> None:
    (tmp_path / "robot.toml").write_text(ROBOT)
    for name, seed in (("train", 2), ("test", 3)):
        one = log(name, 1.0, seed, rest=8.0)
        np.savez(tmp_path / f"{name}.npz", t=one.t, q=one.q, qd=one.qd, tau=one.tau)
    asked = ("identify", tmp_path / "robot.toml", tmp_path / "train.npz")
    asked += ("--validation", tmp_path / "test.npz", "--into", tmp_path / "out")
    code, out, err = command(*asked)
    assert code == 0, out + err
    assert "stand still at times" in out
    code, out, err = command(*asked[:-1], tmp_path / "masked", "--mask", "rest")
    assert code == 0, out + err
