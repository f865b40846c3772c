"""Actuators of identified drives in an exported MJCF, and simulations that they drive."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from oracles import servos
from support_estimate import write_estimate

import symgen
from symgen.identification.estimate import DriveEstimate, read_estimate
from symgen.identification.parameters import read_parameters
from symgen.robot.tables import Drive, Servo

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

KP, KD, LIMIT, SUPPLY = (15.0, 12.0, 9.0), (0.2, 0.0, 0.1), (1.0, 0.9, 0.8), (12.0, 7.4, 11.1)
SIDES = {"position_side": "joint", "torque_side": "joint"}


@dataclass(frozen=True)
class Leg:
    """An arm, its file, and the estimate of its true values."""

    arm: servos.Arm
    file: Path
    result: Path

    def export(self, command, to: Path, *options: object, source: Path | None = None):
        """Run the command; return exit code, both texts, and the model of MuJoCo."""
        given = "export", self.result, "--from", source or self.file, "--to", to, *options
        code, out, err = command(*given)
        return code, out, err, mujoco.MjModel.from_xml_path(str(to)) if code == 0 else None


def leg_in(folder: Path, arm: servos.Arm, **tables: object) -> Leg:
    folder.mkdir(exist_ok=True)
    file = folder / "leg.xml"
    file.write_text(servos.mjcf(arm))
    robot = replace(symgen.read_robot(file), **tables)
    model = symgen.derive(robot, "all")
    X = read_parameters(file, model)
    for j in range(arm.n):
        X[model.base.names.index(f"FV{j + 1}")] += arm.b[j]
    result = write_estimate(folder / "result", model, X)
    drives = tuple(
        DriveEstimate(j + 1, float(a), 0.01, "N m per duty", float(a), 0.1, 5.0, 0.1, 0.0)
        for j, a in enumerate(arm.a)
    )
    estimate = replace(read_estimate(result), drives=drives)
    (result / "estimate.json").write_text(json.dumps(estimate.to_json()))
    return Leg(arm, file, result)


@pytest.fixture(scope="module")
def arm() -> servos.Arm:
    return servos.random_arm("leg", np.random.default_rng(11))


@pytest.fixture(scope="module")
def leg(tmp_path_factory: pytest.TempPathFactory, arm: servos.Arm) -> Leg:
    ratio = tuple(map(tuple, np.eye(3).tolist()))
    drive = Drive(ratio=ratio, supply=SUPPLY, limit=LIMIT, **SIDES)
    controller = Servo(KP, KD, unit="duty")
    return leg_in(tmp_path_factory.mktemp("leg"), arm, drive=drive, controller=controller)


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory, arm: servos.Arm) -> Leg:
    """The same without [drive] and [controller]."""
    return leg_in(tmp_path_factory.mktemp("bare"), arm)


def torques(model, ctrl, q, qd) -> np.ndarray:
    """Torques of actuators, damping and friction in MuJoCo, (K, n)."""
    data, out = mujoco.MjData(model), []
    model.opt.timestep = 1e-5  # friction is as hard as the step is short
    for row in zip(ctrl, q, qd, strict=True):
        data.ctrl[:], data.qpos[:], data.qvel[:] = row
        data.qacc_warmstart[:] = 0
        mujoco.mj_forward(model, data)
        out.append(data.qfrc_actuator + data.qfrc_passive + data.qfrc_constraint)
    return np.array(out)


@pytest.mark.parametrize("kind", [None, "position", "motor", "dcmotor"])
def test_the_torque_of_an_exported_drive_is_the_identified_one(
    leg: Leg, tmp_path: Path, command, kind: str | None
) -> None:
    arm = leg.arm
    options = ("--actuator", kind) if kind else ()
    code, _, err, model = leg.export(command, tmp_path / "out.xml", *options)
    assert code == 0, err
    ctrl, q, qd = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 200, 3))
    qd += np.sign(qd)  # above the speed at which friction of MuJoCo is soft
    u = ctrl
    if kind in (None, "position"):
        u = np.array(KP) * (ctrl - q) - np.array(KD) * qd
    if kind == "dcmotor":
        ctrl = ctrl * SUPPLY
    ours = arm.a * np.clip(u, -np.array(LIMIT), LIMIT)
    ours -= (arm.b + arm.viscous) * qd + arm.coulomb * np.sign(qd)
    theirs = torques(model, ctrl, q, qd)
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-6 * arm.a.max())


def test_without_a_controller_the_control_of_a_motor_is_the_duty(
    bare: Leg, tmp_path: Path, command
) -> None:
    code, _, err, model = bare.export(command, tmp_path / "out.xml")
    assert code == 0, err
    np.testing.assert_allclose(model.actuator_gear[:, 0], bare.arm.a, rtol=1e-12)
    assert model.actuator_ctrlrange.tolist() == [[-1, 1]] * 3
    assert model.actuator_gainprm[:, 0].tolist() == [1, 1, 1]


#: A maker's file: classes, a servo with a range, one with several attributes; joint 3 has none.
MAKERS = """<actuator>
  <position class="servo" name="hip" joint="joint1" ctrlrange="-2 2" dampratio="1"/> <!-- hip -->
  <motor name="knee" joint="joint2" gear="50" group="2"/>
</actuator>"""
CLASSES = (
    '<default class="servo"><position kp="998" dampratio="1" forcerange="-2.9 2.9"/></default>'
    '<motor ctrlrange="-0.5 0.5" ctrllimited="true"/></default>'
)


def makers(leg: Leg, folder: Path, actuators: str) -> Path:
    text = re.sub("<actuator>.*</actuator>", actuators, leg.file.read_text())
    text = text.replace("</default>", CLASSES).replace('range="-3 3"', 'actuatorfrcrange="-1 1"')
    path = folder / "makers.xml"
    path.write_text(text)
    return path


def test_actuators_are_rewritten_in_place_and_missing_ones_are_added(
    leg: Leg, tmp_path: Path, command
) -> None:
    source = makers(leg, tmp_path, MAKERS)
    code, _, err, model = leg.export(command, tmp_path / "out.xml", source=source)
    assert code == 0, err
    written = (tmp_path / "out.xml").read_text()
    assert "/> <!-- hip -->\n  <position" in written
    assert [model.actuator(k).name for k in range(3)] == ["hip", "knee", ""]
    assert model.actuator_group.tolist() == [0, 2, 0]
    assert model.actuator_trnid[:, 0].tolist() == [0, 1, 2]
    np.testing.assert_allclose(model.actuator_gainprm[:, 0], leg.arm.a * KP)
    np.testing.assert_allclose(model.actuator_biasprm[:, 2], -leg.arm.a * KD)
    np.testing.assert_allclose(model.actuator_forcerange[:, 1], leg.arm.a * LIMIT)
    assert not model.actuator_ctrllimited.any()
    assert not model.jnt_actfrclimited.any()
    source = makers(leg, tmp_path, "")
    code, _, err, model = leg.export(command, tmp_path / "added.xml", source=source)
    assert code == 0, err
    assert model.nu == 3


def test_a_dcmotor_has_no_damping_beside_it_and_a_comment_says_so(
    leg: Leg, tmp_path: Path, command
) -> None:
    _, _, _, model = leg.export(command, tmp_path / "out.xml", "--actuator", "dcmotor")
    assert not np.any(model.dof_damping)
    assert "<!-- motorconst holds the viscous friction" in (tmp_path / "out.xml").read_text()
    constant = np.array(SUPPLY) * (leg.arm.b + leg.arm.viscous) / leg.arm.a
    text = (tmp_path / "out.xml").read_text()
    written = np.array(re.findall('motorconst="([^"]+)" resistance="([^"]+)"', text), dtype=float)
    np.testing.assert_allclose(written[:, 0], constant, rtol=1e-6)
    np.testing.assert_allclose(written[:, 1], constant * SUPPLY / leg.arm.a, rtol=1e-6)


def test_a_dcmotor_leaves_the_viscous_friction_that_open_windings_tell_to_the_joint(
    leg: Leg, tmp_path: Path, command
) -> None:
    estimate = read_estimate(leg.result)
    drives = tuple(
        replace(drive, back_emf=float(b), back_emf_std=0.01)
        for drive, b in zip(estimate.drives, leg.arm.b, strict=True)
    )
    shutil.copytree(leg.result, tmp_path / "result")
    known = replace(estimate, drives=drives).to_json()
    (tmp_path / "result" / "estimate.json").write_text(json.dumps(known))
    separated = replace(leg, result=tmp_path / "result")
    *_, model = separated.export(command, tmp_path / "out.xml", "--actuator", "dcmotor")
    np.testing.assert_allclose(model.dof_damping, leg.arm.viscous, rtol=1e-6)
    text = (tmp_path / "out.xml").read_text()
    assert "holds the viscous friction" not in text
    written = np.array(re.findall('motorconst="([^"]+)"', text), dtype=float)
    np.testing.assert_allclose(written, np.array(SUPPLY) * leg.arm.b / leg.arm.a, rtol=1e-6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--actuator", "position"), r'[controller] with kp, kd and unit = "duty"'),
        (("--actuator", "dcmotor"), "supply in [drive]"),
        (("--actuator", "dcmotor", "--log", "log.csv"), "--actuator motor with --log"),
    ],
)
def test_what_an_actuator_needs(bare: Leg, tmp_path: Path, command, options, said: str) -> None:
    code, _, err, _ = bare.export(command, tmp_path / "out.xml", *options)
    assert code != 0
    assert said in err
    assert len(err.strip().splitlines()) <= 3


def test_an_estimate_from_torques_has_no_actuators(
    arm: servos.Arm, tmp_path: Path, command
) -> None:
    made = leg_in(tmp_path, arm)
    estimate = replace(read_estimate(made.result), drives=())
    (made.result / "estimate.json").write_text(json.dumps(estimate.to_json()))
    code, _, err, _ = made.export(command, tmp_path / "out.xml", "--actuator", "motor")
    assert code != 0
    assert "accepted: an estimate from logs of duty" in err
    code, _, _, _ = made.export(command, tmp_path / "out.xml")
    assert code == 0
    before, after = (p.read_text() for p in (made.file, tmp_path / "out.xml"))
    (actuators,) = re.findall("<actuator>.*</actuator>", before)
    assert actuators in after


def test_a_file_in_which_another_actuator_moves_a_joint_is_refused(
    leg: Leg, tmp_path: Path, command
) -> None:
    two = '<actuator><motor joint="joint1"/><velocity joint="joint1" kv="3"/></actuator>'
    weak = tmp_path / "weak.xml"  # the default of all actuators clips
    weak.write_text(makers(leg, tmp_path, "").read_text().replace("ctrlrange", "forcerange"))
    weak.write_text(weak.read_text().replace("ctrllimited", "forcelimited"))
    source = makers(leg, tmp_path, two)
    for file, kind in ((source, "motor"), (source, "position"), (weak, "dcmotor")):
        options = "--actuator", kind
        code, _, err, _ = leg.export(command, tmp_path / "out.xml", *options, source=file)
        assert code != 0
        assert "one actuator at most of the joint, in the file itself" in err
        assert not (tmp_path / "out.xml").exists()


def moved(arm: servos.Arm, folder: Path, *, reference: bool) -> Path:
    """The file of a log of duty."""
    log = servos.recorded(arm, "log", np.random.default_rng(3), 6.0)
    assert log.duty is not None
    columns, names = [log.t[:, None], log.q, log.duty], ["t"]
    names += [f"{key}{j}" for key in ("q", "u") for j in range(1, 4)]
    if reference:
        columns.append(log.qr)
        names += [f"qr{j}" for j in range(1, 4)]
    path = folder / "log.csv"
    np.savetxt(path, np.hstack(columns), delimiter=",", header=",".join(names), comments="")
    return path


def compared(command, into: Path, *given: Path) -> dict:
    code, _, err = command("compare-sim", *given, "--into", into)
    assert code == 0, err
    return json.loads((into / "simulation.json").read_text())


def test_the_recorded_reference_drives_the_exported_file(
    bare: Leg, tmp_path: Path, command
) -> None:
    path = moved(bare.arm, tmp_path, reference=True)
    gains = Servo((bare.arm.gain,) * 3, (0.0,) * 3, unit="duty")
    with_gains = leg_in(tmp_path / "gains", bare.arm, controller=gains)
    with_gains.export(command, tmp_path / "reference.xml")
    found = compared(command, tmp_path / "by-reference", tmp_path / "reference.xml", path)
    assert found["driven_by"] == "reference"
    assert found["files"][0]["horizons"][-1]["position_error"] < 0.01


@pytest.mark.parametrize(
    ("kind", "reference", "said"),
    [
        ("position", False, "no torques and no reference; accepted: a log with qr1.."),
        ("motor", True, "symgen export --actuator position"),
    ],
)
def test_duty_is_no_torque_to_replay(
    leg: Leg, tmp_path: Path, command, kind: str, reference: bool, said: str
) -> None:
    path = moved(leg.arm, tmp_path, reference=reference)
    leg.export(command, tmp_path / "out.xml", "--actuator", kind)
    code, _, err = command("compare-sim", tmp_path / "out.xml", path, "--into", tmp_path / "into")
    assert code != 0
    assert said in err
