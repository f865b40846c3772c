"""The URDFs that example-robot-data ships: equal torques and frames in Pinocchio.

Whole robots with at most 12 moving joints, and the arms, legs and hands of larger ones on a fixed
base. Three comparisons: rounded angles read as fractions of pi against the URDF with all digits of
them; the same against the URDF as it is, which differs by what the rounding explains; and the
angles read as written against the URDF as it is.
"""

import pytest
from oracles.urdf_arm import PinocchioUrdf, limbs, shipped, with_all_digits
from support_urdf import Ours, place_gap, torque_gap

from symgen.robot.formats.urdf import import_urdf
from symgen.robot.toml_io import parse_robot
from symgen.robot.toml_text import robot_toml

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")
ROUNDING = 1e-3  # of torque, and m: pi/2 written 1.5708, 1.571 is not touched


def _cases():
    for path in shipped():
        text = path.read_text("utf-8")
        for limb, part in limbs(text):
            marks = [pytest.mark.slow] if limb else []
            yield pytest.param(path.stem, limb, part, id=f"{path.stem}-{limb}", marks=marks)


CASES = list(_cases())


@pytest.mark.skipif(not CASES, reason="example-robot-data is not installed")
def test_the_shipped_robots_are_there():
    assert len([c for c in CASES if not c.marks]) > 25


@pytest.mark.parametrize(("name", "limb", "text"), CASES)
def test_torques_and_frames_are_those_of_pinocchio(name, limb, text):
    imported = import_urdf(text, name)
    ours, all_digits, written = Ours(imported), with_all_digits(text), PinocchioUrdf(text)
    exact = PinocchioUrdf(all_digits)
    errors = torque_gap(ours, exact), place_gap(ours, exact)
    assert max(errors) < 1e-12
    rounded = torque_gap(ours, written, 2), place_gap(ours, written, 2)
    assert max(rounded) < ROUNDING
    if not imported.notes:
        assert max(rounded) < 2e-9  # nearly parallel axes put frames far away, which costs digits
    print(f"{name:27} {limb:28} {ours.robot.n:2} joints, torque {errors[0]:.1e}, as written "
          f"{rounded[0]:.1e}")  # fmt: skip


@pytest.mark.parametrize(("name", "limb", "text"), [c for c in CASES if not c.marks][::4])
def test_what_is_written_as_toml_is_the_same_robot(name, limb, text):
    robot = import_urdf(text, name + limb).robot
    assert parse_robot(robot_toml(robot)) == robot
