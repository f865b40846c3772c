"""Robots as a calibration leaves them: axes that are nearly parallel, offsets that nearly meet."""

import pytest
from oracles.calibrated import calibrated_urdf
from oracles.urdf_arm import PinocchioUrdf
from support import sampled
from support_urdf import Ours, place_gap, torque_gap

import symgen
from symgen.robot.formats.urdf import import_urdf
from symgen.robot.toml_io import parse_robot

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")
ROTATION, SHIFT = 0.7e-3, 0.5e-3  # rad and m
ROBOTS = (
    "lwr4", "panda", "puma560", "rx90", "scara", "stanford", "twin", "tx40", "ur10e", "wam7",
)  # fmt: skip
CASES = [(ROBOTS[seed % len(ROBOTS)], seed) for seed in range(200)]


def lengths(robot):
    """All lengths of a table, m: the frames are as far away as their sum at most."""
    return [abs(float(x)) for j in robot.joints for x in (j.b, j.d, j.r)]


@pytest.mark.parametrize(("name", "seed"), sampled(CASES, 6, always=[("ur10e", 8)]))
def test_import_keeps_motion_and_torque_exactly_and_frames_near(name, seed):
    plain = symgen.read_robot(name)
    text = calibrated_urdf(plain, ROTATION, SHIFT, seed)
    imported = import_urdf(text)
    ours, pinocchio = Ours(imported), PinocchioUrdf(text)
    assert place_gap(ours, pinocchio) < 1e-12
    assert torque_gap(ours, pinocchio) < 1e-11
    nominal = import_urdf(calibrated_urdf(plain)).robot
    assert sum(lengths(imported.robot)) < sum(lengths(nominal)) + 0.1
    assert parse_robot(symgen.robot_toml(imported.robot)) == imported.robot


def test_import_says_where_it_put_frames(command, tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(calibrated_urdf(symgen.read_robot("ur10e"), ROTATION, SHIFT), "utf-8")
    code, out, err = command("import", path)
    assert code == 0
    assert err == ""
    (note,) = (line for line in out.splitlines() if line.startswith("note:"))
    assert "fixed frames between nearly parallel axes" in note
    assert note.endswith("before joint j1, j3, j4")
