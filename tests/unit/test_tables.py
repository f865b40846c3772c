"""Every table of a robot file is read, written and read again; a message names table and key."""

from __future__ import annotations

import pytest

import symgen

ALL = """
[robot]
name = "arm"
gravity = ["-h", 0.0, -9.81]
[geometry]
h = 0.5
[[joint]]
name = "waist"
coulomb_width = 0.01
[[joint]]
alpha = "pi/2"
actuated = false
[[joint]]
d = "h"
follows = "-q2 + pi/2"
[[joint]]
sigma = 2
antecedent = 1
[[coupling]]
joints = [1, 2]
ratio = "2*h"
[payload]
joint = 4
[[frame]]
name = "flange"
joint = 4
rpy = [0.0, 0.1, 0.0]
[limits]
position = [[-1, 1], [0, 2]]
velocity = [2.0, 3.0]
floor = -0.5
boxes = [[[0, 1], [0, 1], [0, 2]]]
[drive]
ratio = [[10, 1], [0, 20]]
gain = [1.1, 0.9]
torque_side = "joint"
[controller]
kp = [1, 2]
kd = [0, 1]
scale = "unknown"
[log]
columns = "q1=a"
[[effect]]
name = "detent"
joints = [1]
torque = "-A*sin(n*q1)"
linear = { A = "N m" }
nonlinear = { n = [2, "8*h"] }
"""


def test_every_table_is_written_and_read_again() -> None:
    robot = symgen.parse_robot(ALL)
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot
    assert robot.limits is not None
    assert robot.limits.boxes == (((0.0, 1.0), (0.0, 1.0), (0.0, 2.0)),)
    assert robot.drive is not None
    assert (robot.drive.position_side, robot.drive.torque_side) == ("motor", "joint")
    assert robot.couplings[0].second == 2


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "flange"', 'name = ""', "frame 1, key 'name': accepted: a text that is not empty"),
        ("rpy = [0.0, 0.1", "rpy = [true, 0.1", "frame 1, key 'rpy', entry 1: accepted: a number"),
        ("rpy = [0.0, ", "rpy = [", "frame 1, key 'rpy': 2 entries; accepted: 3"),
        ("[0, 2]]\n", "[2, 2]]\n", "limits, key 'position', entry 2: accepted: [low, high]"),
        ("[2.0, 3.0]", "[2.0, 0]", "limits, key 'velocity', entry 2: accepted: a number above 0"),
        ("kp = [1, 2]\n", "", "controller, key 'kp': is missing"),
        ("kp = [1, 2]", "kp = [1, -2]", "controller, key 'kp', entry 2: accepted: a number of 0"),
        ('"unknown"', '"what"', "controller, key 'scale': accepted: 'known' or 'unknown'"),
        (
            "[payload]\njoint = 4",
            "[payload]\njoint = 9",
            "payload, key 'joint': there is no joint 9; accepted: 1 to 4",
        ),
        ('"q1=a"', "3", "log, key 'columns': accepted: a text in quotes"),
        ("columns =", "column =", "log, key 'column': unknown key; accepted: columns"),
        ('A = "N m"', "A = 3", "effect 1, key 'linear', 'A': accepted: a text in quotes"),
        ("[[frame]]", "[frame]", "frame: is not a list; accepted: [[frame]] for each table"),
        ("[log]\n", "[[log]]\n", "log: is not a table"),
    ],
)
def test_a_message_names_the_file_the_table_the_key_and_what_is_accepted(
    old: str, new: str, message: str
) -> None:
    assert ALL.count(old) == 1
    with pytest.raises(symgen.RobotError) as caught:
        symgen.parse_robot(ALL.replace(old, new), "file.toml")
    assert str(caught.value).startswith(f"file.toml: {message}")
