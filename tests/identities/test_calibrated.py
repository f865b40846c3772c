"""Robots as a calibration leaves them: axes that are nearly parallel, offsets that nearly meet."""

import itertools
import json

import numpy as np
import pytest
from oracles.calibrated import calibrated_urdf
from oracles.urdf_arm import PinocchioUrdf
from support import sampled
from support_urdf import FUNCTIONS, Ours, place_gap, rigid, torque_gap

import symgen
from symgen.robot.formats.urdf import import_urdf
from symgen.robot.toml_io import parse_robot
from symgen.symbolic.tape import Numbers

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


@pytest.mark.parametrize(("name", "seed"), sampled(CASES, 3, always=[("ur10e", 8)]))
def test_the_nominal_rank_is_that_of_the_robot_without_errors(name, seed):
    plain = symgen.read_robot(name)
    drawn = symgen.derive(import_urdf(calibrated_urdf(plain)).robot, ()).base
    found = symgen.derive(import_urdf(calibrated_urdf(plain, ROTATION, SHIFT, seed)).robot, ()).base
    assert drawn.nominal is None
    assert found.nominal.rank == drawn.proof.rank
    assert found.nominal.exact_rank > found.nominal.rank
    assert len(found.parameters) == found.nominal.rank + len(found.nominal.kept)
    assert max(found.nominal.missing) < 1e-3


@pytest.mark.parametrize(
    ("rotation", "seed"),
    sampled(itertools.product([0.2e-3, 0.7e-3, 2e-3], range(5)), 1, always=[(2e-3, 1)]),
)
def test_the_base_parameters_express_the_torque_of_pinocchio(rotation, seed):
    text = calibrated_urdf(symgen.read_robot("ur10e"), rotation, SHIFT, seed)
    robot = rigid(import_urdf(text).robot)
    model = symgen.derive(robot, ("torque_regressor",))
    pinocchio, draw = PinocchioUrdf(text), np.random.default_rng(seed)
    states = [size * draw.uniform(-1, 1, (400, 6)) for size in (np.pi, 1.5, 3.0)]
    names = robot.joint_names
    tau = np.array(
        [
            [torque[name] for name in names]
            for torque in (
                pinocchio.torques(*(dict(zip(names, x[i], strict=True)) for x in states))
                for i in range(400)
            )
        ]
    )
    inputs = dict(zip(("q", "qd", "qdd"), (list(x.T) for x in states), strict=True))
    out = model.kernel("torque_regressor").tape.run(Numbers({}, FUNCTIONS), inputs)
    W = np.stack([np.broadcast_to(x, 400) for x in out], axis=1).reshape(400, 6, -1)
    rms = np.sqrt(np.mean(tau**2, axis=0))
    rows = (W / rms[:, None])[:200].reshape(1200, -1)
    norms = np.linalg.norm(rows, axis=0)
    assert np.linalg.cond(rows / norms) < 20
    X = np.linalg.lstsq(rows / norms, (tau[:200] / rms).ravel(), rcond=None)[0] / norms
    missing = np.sqrt(np.mean((tau - W @ X)[200:] ** 2, axis=0)) / rms
    assert missing.max() < 1e-3


def test_exact_sets_and_what_the_manifest_says(command, tmp_path):
    path, file = tmp_path / "arm.urdf", tmp_path / "robot.toml"
    path.write_text(calibrated_urdf(symgen.read_robot("ur10e"), ROTATION, SHIFT, 8), "utf-8")
    only = ("--target", "c", "--kernels", "energy_regressor")
    assert command("import", path, "--exact", "--into", file)[0] == 0
    assert command("generate", file, *only, "--into", tmp_path / "exact")[0] == 0
    code, out, _ = command("generate", path, *only, "--into", tmp_path / "practical")
    assert code == 0
    exact, practical = (
        json.loads((tmp_path / name / "manifest.json").read_text("utf-8"))
        for name in ("exact", "practical")
    )
    assert "nominal" not in exact
    assert len(exact["base_parameters"]) == practical["nominal"]["exact_rank"] == 55
    assert practical["nominal"]["rank"] == 52
    separated = {name for name, _ in practical["nominal"]["separated"]}
    kept = {p["name"].removesuffix("R") for p in practical["base_parameters"]}
    assert separated - set(practical["nominal"]["kept"]) == separated - kept
    assert max(practical["nominal"]["missing"]) < practical["nominal"]["limit"] < 1e-3
    assert "rank 52 for the nominal geometry, 55 for the exact one" in out


def test_dust_in_angles_needs_no_parameter_of_its_own():
    robot = import_urdf(calibrated_urdf(symgen.read_robot("scara"), 1e-8, 0.0, 1)).robot
    assert len(symgen.derive(robot, ()).base.parameters) == 19


def test_a_small_angle_beside_zeros_is_kept(tmp_path) -> None:
    """0 has no rounded digit, so that -3.0e-6 beside it is a measured angle."""
    link = '<link name="{}"><inertial><mass value="1"/>' + (
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
    )
    file = tmp_path / "one.urdf"
    file.write_text(
        '<robot name="one"><link name="base"/>'
        + '<joint name="j1" type="continuous"><parent link="base"/><child link="arm"/>'
        + '<origin xyz="0 0 0.2" rpy="0 0 -3.0e-6"/><axis xyz="0 0 1"/></joint>'
        + link.format("arm")
        + "</robot>"
    )
    robot = symgen.read_robot(file)
    (frame,) = [f for f in robot.frames if f.name == "arm"]
    turned = float(robot.joints[0].theta) + frame.rpy[2]
    assert turned == pytest.approx(-3e-6, rel=1e-9)
