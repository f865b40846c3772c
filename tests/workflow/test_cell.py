"""excite on a real cell: floor and boxes are kept clear of, runs are written for controllers.

Files are read back by readers that share no code with what writes them: PyYAML, the MCAP reader of
the format's authors, and a grammar of two statements for URScript.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from oracles.transforms import Arm, world_transforms

import symgen
from symgen.experiment.bounds import Cell
from symgen.experiment.plan import Plan, exported
from symgen.experiment.trajectory import Trajectory, fourier_series
from symgen.robot.tables import Limits

#: Two links that swing in the vertical plane x, z.
SWING = """[robot]
name = "swing"
[[joint]]
alpha = "pi/2"
r = 0.1
[[joint]]
d = 0.5
[limits]
position = [[-1.5, 1.5], [-2, 2]]
velocity = [2, 3]
acceleration = [10, 15]
"""
ARM = Arm.from_table({"sigma": [0, 0], "alpha": [np.pi / 2, 0], "d": [0, 0.5], "r": [0.1, 0]})
TOOL = np.array([0.4, 0.0, 0.05])


def points(q: np.ndarray) -> np.ndarray:
    """Origins of the frames that move, and the tool, (N, 2, 3)."""
    T = world_transforms(ARM, q)
    return np.stack([T[:, 1, :3, 3], T[:, 1, :3, 3] + T[:, 1, :3, :3] @ TOOL], axis=1)


def run(n: int, seed: int = 3) -> Trajectory:
    """A Fourier series from rest to rest."""
    own, ends = fourier_series(10.0, 4), np.zeros(1)
    rng = np.random.default_rng(seed)
    rest = np.concatenate([own.matrix(ends, order) for order in (1, 2)])
    null = np.linalg.svd(rest)[2][len(rest) :]
    return Trajectory(own, rng.normal(0, 0.3, (n, 9)) @ null.T @ null)


def plan(n: int) -> Plan:
    return Plan("arm", "energy", 0.2, 100.0, (run(n),), {"energy": 5.0}, {"M": 0.1},
                {"M": 1.0}, 0.2, (), 4, 100.0, (1, 1), "done", approach=12.5)  # fmt: skip


def test_runs_that_are_too_short_say_how_long_they_must_be() -> None:
    [told] = replace(plan(2), independent=3.0).warnings
    needed, seconds = re.search(r"from (\d+): .* ask for (\d+) s in all", told).groups()
    assert int(seconds) == math.ceil(10.0 * int(needed) / 3)
    assert replace(plan(2), independent=float(needed)).good


def test_clearance_is_that_of_plain_transforms() -> None:
    evaluator = symgen.load(symgen.derive(symgen.parse_robot(SWING), ("frames",)))
    box = ((0.2, 0.6), (-0.3, 0.1), (0.1, 0.9))
    q = run(2).at(np.linspace(0, 10, 2001))
    floor, near = Cell(evaluator, Limits(floor=-0.6, boxes=(box,), tool=tuple(TOOL))).uses(q)
    x = points(q)
    np.testing.assert_allclose(floor.extreme, (x[..., 2] + 0.6).min(), atol=1e-6)
    low, high = np.array(box).T
    inside = ((x > low) & (x < high)).all(axis=-1)
    gap = np.maximum(np.maximum(low - x, x - high), 0)
    if inside.any():
        assert near.share > 1
    else:
        np.testing.assert_allclose(near.extreme, np.linalg.norm(gap, axis=-1).min(), atol=1e-6)


def over_the_floor(x: np.ndarray):
    """A floor 0.1 m above the lowest point of a motion, and what keeps clear of it."""
    floor = float(x[..., 2].min()) + 0.1
    return f"floor = {floor!r}", lambda y: (y[..., 2] > floor).all()


def beside_a_box(x: np.ndarray):
    """A box of 0.2 m about the highest point of a motion, and what keeps clear of it."""
    top = x.reshape(-1, 3)[np.argmax(x[..., 2])]
    sides = [[float(c) - 0.1, float(c) + 0.1] for c in top]
    return f"boxes = [{sides}]", lambda y: (np.abs(y - top) >= 0.1).any(axis=-1).all()


def test_runs_keep_clear(tmp_path, command) -> None:
    """Of what the motion that is found without it touches."""
    path = tmp_path / "robot.toml"
    options = ["--model", "momentum", "--iterations", 300, "--searches", 1, "--duration", 8]
    path.write_text(SWING)
    command("excite", path, *options, "--into", tmp_path / "free.csv")
    free = points(np.loadtxt(tmp_path / "free.csv", delimiter=",", skiprows=1)[:, 1:3])
    for cell in (over_the_floor, beside_a_box):
        limit, clear = cell(free)
        assert not clear(free)
        path.write_text(f"{SWING}{limit}\ntool = {TOOL.tolist()}\n")
        kept = tmp_path / f"{cell.__name__}.csv"
        code, _, err = command("excite", path, *options, "--into", kept)
        assert code == 0, err
        rows = np.loadtxt(kept, delimiter=",", skiprows=1)
        assert clear(points(rows[:, 1:3]))
        assert np.abs(rows[[0, -1], 3:5]).max() < 1e-9  # at rest at both ends


def test_a_cell_without_room_is_a_line(tmp_path, command) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(f"{SWING}floor = 2.0\n")
    asked = ["excite", path, "--iterations", 50, "--searches", 1, "--into", tmp_path / "a.csv"]
    code, _, err = command(*asked)
    assert code == 2
    assert "clear of the floor" in err


def test_a_trajectory_for_ros_is_read_back(tmp_path) -> None:
    yaml = pytest.importorskip("yaml")
    robot = symgen.parse_robot(SWING)
    own = plan(2)
    files = exported(own, robot, tmp_path / "a.csv", "ros")
    assert files == exported(own, robot, tmp_path / "a.csv", "ros")
    told = yaml.safe_load(files[tmp_path / "a.yaml"])
    assert told["joint_names"] == ["joint1", "joint2"]
    t = own.runs[0].times(0.01)
    for k, a in enumerate(told["points"]):
        stamp = a["time_from_start"]
        assert stamp["sec"] + 1e-9 * stamp["nanosec"] == pytest.approx(t[k] + 12.5, abs=1e-9)
        for order, key in enumerate(("positions", "velocities", "accelerations")):
            true = own.runs[0].at(t[k : k + 1], order)[0]
            np.testing.assert_allclose(a[key], true, atol=1e-10)


def test_a_program_for_universal_robots_is_read_back(tmp_path) -> None:
    robot = symgen.parse_robot('[robot]\nname = "six"\n' + "[[joint]]\nd = 0.2\n" * 6)
    own = plan(6)
    text = exported(own, robot, tmp_path / "a.csv", "urscript")[tmp_path / "a.script"].decode()
    lines = text.splitlines()
    assert lines[0] == "def six_excite():"
    assert lines[-1] == "end"
    numbers = [re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", line) for line in lines[1:-1]]
    assert lines[1].strip().startswith("movej([")
    np.testing.assert_allclose([float(x) for x in numbers[0][:6]], own.runs[0].at(np.zeros(1))[0],
                               atol=1e-9)  # fmt: skip
    served = [x for x, line in zip(numbers, lines[1:-1], strict=True) if "servoj" in line]
    assert all(len(x) == 11 for x in served)  # q, a, v, t, lookahead, gain
    step = float(served[0][8])
    assert step <= 0.008
    t = step * np.arange(len(served))
    assert t[-1] == pytest.approx(10.0)
    q = np.array([[float(v) for v in x[:6]] for x in served])
    np.testing.assert_allclose(q, own.runs[0].at(t), atol=1e-8)


def test_a_robot_that_a_format_does_not_drive_is_refused(tmp_path) -> None:
    with pytest.raises(symgen.ParameterError, match="six revolute"):
        exported(plan(2), symgen.parse_robot(SWING), tmp_path / "a.csv", "urscript")
