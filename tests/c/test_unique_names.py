"""Every entry of X has a name of its own, whatever couplings and effects a robot has."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from packages import STRICT, run

import symgen

ROBOT = """
[robot]
name = "r34"
gravity = [0.0, -9.81, 0.0]
[[joint]]
sigma = 1
alpha = -0.764
friction = ["coulomb"]
[[joint]]
alpha = -0.978
friction = ["coulomb"]
[[coupling]]
joints = [1, 2]
ratio = -2.0
[[effect]]
name = "smooth_friction"
joints = [1, 2]
nonlinear = { w = 0.264 }
[[effect]]
name = "torque_ripple"
joints = [2]
nonlinear = { k = 3 }
[[effect]]
name = "motor_cogging"
joints = [2]
nonlinear = { k = 5 }
"""
RATIO, WIDTH = -2.0, 0.264


def test_a_coupling_and_effects_have_parameters_of_their_own() -> None:
    robot = symgen.parse_robot(ROBOT)
    model = symgen.derive(robot, ("inverse_dynamics",))
    assert len(set(model.base.names)) == len(model.base.names)
    torque = symgen.load(model, backend="casadi").inverse_dynamics
    q, qd = np.array([0.3, -0.7]), np.array([0.9, -0.2])
    u = qd[0] + RATIO * qd[1]
    coupled = np.sign(u) * np.array([1, RATIO])
    smooth = np.array([0, np.tanh(qd[1] / WIDTH) - np.sign(qd[1])])
    drives = [i for i, name in enumerate(model.base.names) if name.startswith("FSM2")]
    found = [torque(q, qd, 0 * q, np.eye(len(model.base.names))[i]) for i in drives]
    np.testing.assert_allclose(found, [coupled, smooth], atol=1e-14)
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
def test_the_package_of_a_coupling_and_effects_compiles(tmp_path: Path) -> None:
    model = symgen.derive(symgen.parse_robot(ROBOT), ("inverse_dynamics",))
    symgen.write_package(symgen.generate(model, target="c"), tmp_path)
    run(["cc", *STRICT, "-c", "r34_inverse_dynamics.c"], tmp_path)


@pytest.mark.parametrize(
    ("name", "length"),
    [("smooth_friction", ""), ("own", ""), ("stribeck_friction", "[geometry]\nFST2 = 0.4\n")],
)
def test_a_name_that_the_file_gives_twice_is_refused(name: str, length: str) -> None:
    entry = f'[[effect]]\nname = "{name}"\njoints = [2]\n'
    entry += {
        "smooth_friction": "nonlinear = { w = 0.264 }",
        "own": 'torque = "RS2*sin(q2)"\nlinear = { RS2 = "N m" }',
        "stribeck_friction": "nonlinear = { vs = 0.1 }",
    }[name]
    with pytest.raises(symgen.RobotError, match="2 is declared twice"):
        symgen.parse_robot(ROBOT.replace("[[joint]]", length + "[[joint]]", 1) + entry)
