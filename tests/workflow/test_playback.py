"""Held-out motion is simulated: position errors in `uses.simulation` beside an own integration."""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np
import pytest
from oracles import planar2r
from oracles.arm import Arm
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import symgen

X, FV = np.array([3.7, 0.8, 1.2, 0.3]), np.array([2.0, 0.5])
ROBOT = planar2r.robot_toml("arm", 'friction = ["viscous"]\nrotor_inertia = false')
#: 1.2 s: room for one window of 1 s, which begins at the first sample.
HELD = 240


def motion(seed: int, X: np.ndarray = X) -> tuple[np.ndarray, ...]:
    t, q, qd, qdd = planar2r.harmonic_motion(np.random.default_rng(seed), seed)
    return t, q, qd, Arm(X, FV=FV).torque(q, qd, qdd)


def simulated(
    rows: tuple[np.ndarray, ...], X: np.ndarray, FV: np.ndarray, kp: np.ndarray, kd: np.ndarray
) -> np.ndarray:
    """Positions after 0.2, 0.5 and 1 s under the torques of a log, from its first state."""
    t, q, qd, tau = rows
    measured = CubicSpline(t, np.concatenate([tau, q, qd], axis=1))
    arm = Arm(X, FV=FV)

    def slope(at: float, x: np.ndarray) -> np.ndarray:
        m = measured(at)
        tau = m[:2] + kp * (m[2:4] - x[:2]) + kd * (m[4:] - x[2:])
        return np.concatenate([x[2:], arm.acceleration(x[:2], x[2:], tau)])

    start = np.concatenate([q[0], qd[0]])
    moved = solve_ivp(slope, (0, 1), start, t_eval=[0.2, 0.5, 1.0], rtol=1e-9, atol=1e-9)
    return moved.y[:2].T


def relative(rows: tuple[np.ndarray, ...], moved: np.ndarray) -> list[float]:
    at = rows[1][[40, 100, 200]]
    way = np.sqrt(np.mean((at - rows[1][0]) ** 2, axis=1))
    return list(np.sqrt(np.mean((moved - at) ** 2, axis=1)) / way)


def write(path: Path, rows: tuple[np.ndarray, ...]) -> Path:
    np.savetxt(path, np.column_stack(rows), delimiter=",", comments="",
               header="t,q1,q2,qd1,qd2,tau1,tau2")  # fmt: skip
    return path


def test_identify_simulates_held_out_motion_before_and_after(tmp_path, command) -> None:
    # The held-out log is of a robot with a heavier link, so that both models are wrong on it.
    held = tuple(x[:HELD] for x in motion(4, X * [1.1, 1.2, 1.2, 1.2]))
    train, test = write(tmp_path / "train.csv", motion(3)), write(tmp_path / "test.csv", held)
    robot = tmp_path / "robot.toml"
    robot.write_text(ROBOT)
    own = np.array([3.0, 0.7, 1.0, 0.3])
    values = "".join(f"{n} = {v}\n" for n, v in zip(planar2r.NAMES, own, strict=True))
    (tmp_path / "arm_parameters.toml").write_text("[parameters]\n" + values)
    code, _, err = command("identify", robot, train, "--validation", test, "--cutoff", "40",
                                 "--into", tmp_path / "out")  # fmt: skip
    assert code in (0, 1), err
    use = json.loads((tmp_path / "out" / "estimate.json").read_text())["uses"]["simulation"]
    assert use["windows"] == 1
    assert use["diverged"] == 0
    zero = np.zeros(2)
    expected = {
        "horizons": simulated(held, X, FV, zero, zero),
        "before": simulated(held, own, zero, zero, zero),
    }
    for key, moved in expected.items():
        assert [h["seconds"] for h in use[key]] == [0.2, 0.5, 1.0]
        errors = [h["position_error"] for h in use[key]]
        assert errors == pytest.approx(relative(held, moved), rel=0.03), key
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Position error in simulation" in page
    for angle in use["horizons"][-1]["per_joint"]:
        assert f"{angle:.3g} rad" in page


def test_a_model_worse_than_standing_still_is_not_good_for_simulation() -> None:
    t, q, qd, tau = motion(3)
    # Torques at the end are those of another robot.
    tau = np.where((np.arange(len(t)) < 0.8 * len(t))[:, None], tau, -4 * tau)
    found = symgen.identify(
        symgen.parse_robot(ROBOT, "robot"), symgen.make_log("log", t, q, tau, qd)
    )
    use = found.uses.simulation
    assert not use.ok
    reason = next(r for r in use.reasons if r.kind == "position_error")
    assert reason.value == use.horizons[0].position_error > reason.limit == 1


def test_a_robot_without_values_has_none_before() -> None:
    t, q, qd, tau = motion(3)
    found = symgen.identify(
        symgen.parse_robot(ROBOT, "robot"), symgen.make_log("log", t, q, tau, qd)
    )
    use = found.uses.simulation
    assert use.ok
    assert use.before == ()
    assert use.horizons[-1].position_error < 1e-3


def test_torques_above_the_limits_of_the_file_are_said(tmp_path) -> None:
    robot = symgen.parse_robot(ROBOT + "[limits]\ntorque = [1000.0, 0.5]\n", "robot")
    t, q, qd, tau = motion(3)
    factor = f"{np.abs(tau[:, 1]).max() / 0.5:.3g} times"
    found = symgen.identify(robot, symgen.make_log("log", t, q, tau, qd))
    (tmp_path / "estimate.json").write_text(json.dumps(found.to_json()))
    again = symgen.predict(robot, symgen.make_log("other", t, q, tau, qd), tmp_path)
    for notes in (found.notes, again.notes):
        (said,) = (note for note in notes if factor in note)
        assert "tau2" in said
        assert "--unit" in said
        assert "tau1" not in said


URDF = """<robot name="two"><link name="base"/>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/></joint><link name="upper"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0 -1"/><axis xyz="0 1 0"/></joint>
<link name="lower"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link></robot>"""


def test_a_simulation_ends_far_from_the_motion(tmp_path) -> None:
    """Torques in another unit, 5000 times too large, whirl the robot of the file around."""
    (tmp_path / "two.urdf").write_text(URDF)
    t, q, qd, tau = motion(3)
    began = time.process_time()
    found = symgen.identify(tmp_path / "two.urdf", symgen.make_log("log", t, q, 5000 * tau, qd))
    assert time.process_time() - began < 10
    assert found.uses.simulation.before[0].position_error > 1


def test_a_simulation_that_hardly_advances_ends(tmp_path) -> None:
    """The file has a spring of an absurd stiffness: the elbow swings a million times a second."""
    spring = '[[effect]]\nname = "gravity_spring"\njoints = [2]\n'
    (tmp_path / "robot.toml").write_text(ROBOT + spring)
    values = dict(zip((*planar2r.NAMES, "FV1", "FV2", "K2"), (*X, *FV, 5e13), strict=True))
    lines = "".join(f"{name} = {value}\n" for name, value in values.items())
    (tmp_path / "arm_parameters.toml").write_text("[parameters]\n" + lines)
    t, q, qd, tau = motion(3)
    log = symgen.make_log("log", t, q, tau, qd)
    t, q, qd, tau = (x[:HELD] for x in motion(4))
    held = symgen.make_log("held", t, q, tau, qd)
    began = time.process_time()
    found = symgen.identify(tmp_path / "robot.toml", log, validation=held, model="momentum")
    assert time.process_time() - began < 10
    assert found.uses.simulation.before[0].position_error > 1
    assert found.uses.simulation.horizons[-1].position_error < 1e-3
