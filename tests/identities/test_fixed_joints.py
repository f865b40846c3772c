"""Joints of an imported robot that are held still: the rest moves as Pinocchio says it does."""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles.urdf_arm import PinocchioUrdf
from support_urdf import Ours

from symgen.errors import LogError, RobotError
from symgen.robot.fixed import with_fixed
from symgen.robot.formats.urdf import import_urdf
from symgen.robot.toml_io import parse_robot, read_robot
from symgen.robot.toml_text import parameters_toml, robot_toml

ARM = """<robot name="gripper_arm">
 <link name="base"/>
 <link name="upper"><inertial><origin xyz="0.1 0.02 0.2"/><mass value="2.0"/>
  <inertia ixx="0.05" ixy="0.001" ixz="0" iyy="0.06" iyz="0" izz="0.02"/></inertial></link>
 <link name="lower"><inertial><origin xyz="0 0.01 0.15" rpy="0.1 0 0"/><mass value="1.2"/>
  <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.005"/></inertial></link>
 <link name="left"><inertial><origin xyz="0 0.03 0.02"/><mass value="0.2"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
 <link name="right"><inertial><origin xyz="0 0.01 0.02"/><mass value="0.3"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.001"/></inertial></link>
 <link name="tip"><inertial><origin xyz="0.01 0 0"/><mass value="0.1"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
 <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
  <origin xyz="0 0 0.3" rpy="0 0.4 0"/><axis xyz="0 1 0"/>
  <limit lower="-2" upper="2" effort="50" velocity="3"/></joint>
 <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
  <origin xyz="0 0.05 0.4"/><axis xyz="1 0 0"/>
  <limit lower="-2" upper="-0.1" effort="40" velocity="3"/></joint>
 <joint name="finger" type="prismatic"><parent link="lower"/><child link="left"/>
  <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
  <limit lower="0" upper="0.04" effort="20" velocity="0.2"/><dynamics friction="0.3"/></joint>
 <joint name="other_finger" type="prismatic"><parent link="lower"/><child link="right"/>
  <origin xyz="0 0 0.3"/><axis xyz="0 -1 0"/><mimic joint="finger" offset="0.005"/>
  <limit lower="0" upper="0.05" effort="20" velocity="0.2"/></joint>
 <joint name="nail" type="fixed"><parent link="left"/><child link="tip"/>
  <origin xyz="0 0 0.05"/></joint>
</robot>
"""


@pytest.mark.parametrize(("fix", "at"), [("finger", 0.0), ("finger=0.02", 0.02), ("3=0.04", 0.04)])
def test_a_held_joint_and_its_follower_are_carried_along(fix: str, at: float) -> None:
    held = with_fixed(import_urdf(ARM), [fix])
    ours, pinocchio = Ours(held), PinocchioUrdf(ARM)
    assert ours.names == ["shoulder", "elbow"]
    states = ours.states(6)
    tau = ours.torques(**states)
    still = {"finger": 0.0, "other_finger": 0.0}
    for i in range(6):
        q, qd, qdd = (
            dict(zip(ours.names, states[k][i], strict=True)) | still for k in ("q", "qd", "qdd")
        )
        want = pinocchio.torques(q | {"finger": at, "other_finger": at + 0.005}, qd, qdd)
        np.testing.assert_allclose(tau[i], [want[n] for n in ours.names], rtol=1e-9, atol=1e-9)


def test_limits_parameters_and_the_written_file_are_those_of_the_rest() -> None:
    held = with_fixed(import_urdf(ARM), ["finger"])
    assert held.robot.limits is not None
    assert held.robot.limits.position == ((-2.0, 2.0), (-2.0, -0.1))
    assert held.robot.limits.torque == (50.0, 40.0)
    names = [name for name, _ in held.parameters]
    assert {"M3", "M4", "FS1", "IA2"} <= set(names)
    assert not {"IA3", "FS3", "FV3", "IA4"} & set(names)
    assert parse_robot(robot_toml(held.robot)) == held.robot


@pytest.mark.parametrize(
    ("fix", "says"),
    [
        (["thumb"], "accepted: --fix once for each, of shoulder, elbow, finger"),
        (["finger=wide"], "NAME=VALUE in rad or m"),
        (["finger=nan"], "NAME=VALUE in rad or m"),
        (["finger", "3"], "given twice"),
        (["elbow"], "--fix elbow=-0.1"),
        (["other_finger"], "no such movable joint"),
        (["shoulder", "elbow=-1", "finger"], "no joint of gripper_arm would be movable"),
    ],
)
def test_what_cannot_be_held_is_refused_in_one_line(fix: list[str], says: str) -> None:
    with pytest.raises(RobotError, match="--fix") as caught:
        with_fixed(import_urdf(ARM), fix)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_log_without_the_finger_names_it_and_the_command(tmp_path, command) -> None:
    import symgen

    arm, held, log = tmp_path / "arm.urdf", tmp_path / "robot.toml", tmp_path / "log.csv"
    arm.write_text(ARM)
    t = np.linspace(0, 1, 50)
    table = np.column_stack([t, np.sin(t), np.cos(t), t, t])
    np.savetxt(log, table, delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    code, _, err = command("identify", arm, log, "--into", tmp_path / "out")
    assert code == 2
    assert "no column for finger" in err
    assert f"symgen import {arm} --fix finger --into robot.toml" in err
    made = symgen.make_log("made", t, table[:, 1:3], table[:, 3:])
    with pytest.raises(LogError, match="--fix finger"):
        symgen.identify(arm, made)
    code, out, err = command("import", arm, "--fix", "finger=0.02", "--into", held)
    assert (code, err) == (0, "")
    assert "joint finger is held at 0.02" in out
    assert "joint other_finger is held, as it follows one" in out
    assert read_robot(held).n == 2
    assert read_robot(held).joint(3).r.is_Rational  # exactly as it was written


def test_the_printed_command_holds_a_joint_whose_zero_is_outside_its_limits(
    tmp_path, command, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(ARM)
    t = np.linspace(0, 1, 50)
    header = "time,shoulder_position,shoulder_effort"
    table = np.column_stack([t, np.sin(t), t])
    np.savetxt("log.csv", table, delimiter=",", header=header, comments="")
    asked = ["arm.urdf", "log.csv", "--parameters", "arm.urdf", "--into", "out"]
    code, _, err = command("predict", *asked)
    assert code == 2
    advice = re.search("symgen (import .* --into robot.toml)", err)
    assert advice is not None, err
    assert advice[1] == "import arm.urdf --fix elbow=-0.1 --fix finger --into robot.toml"
    code, out, err = command(*shlex.split(advice[1]))
    assert code == 0, err
    assert "elbow is held at -0.1" in out
    asked = ["predict", "robot.toml", "log.csv", "--parameters", "gripper_arm_parameters.toml"]
    code, _, err = command(*asked, "--into", "out")
    assert code == 0, err


@pytest.mark.parametrize("kind", ["csv", "npz", "arrays"])
@pytest.mark.parametrize("held", [1, 3])
def test_a_log_keeps_the_column_of_a_joint_that_was_fixed(tmp_path, held: int, kind: str) -> None:
    import symgen

    imported = with_fixed(import_urdf(ARM), [f"{held}=0.03"])
    parameters = tmp_path / "parameters.toml"
    parameters.write_text(parameters_toml(imported.parameters))
    rng = np.random.default_rng(2)
    t = np.arange(0, 4, 0.01)
    q = np.column_stack([np.sin(k * t) for k in (1, 2, 3)]) * [1.0, 0.8, 0.02]
    tau = rng.standard_normal(q.shape)
    q[:, held - 1] = 0.03 + 1e-5 * rng.standard_normal(len(t))
    rest = [k for k in range(3) if k != held - 1]

    def log(q, tau):
        if kind == "arrays":
            return symgen.make_log("log", t, q, tau)
        path, n = tmp_path / f"log.{kind}", q.shape[1]
        if kind == "npz":
            np.savez(path, t=t, q=q, tau=tau)
        else:
            header = ",".join(["t", *(f"{c}{k + 1}" for c in ("q", "tau") for k in range(n))])
            np.savetxt(
                path, np.hstack([t[:, None], q, tau]), delimiter=",", header=header, comments=""
            )
        return path

    def error(log) -> float:
        return symgen.predict(imported.robot, log, parameters).error.relative

    alone = error(log(q[:, rest], tau[:, rest]))
    assert error(log(q, tau)) == pytest.approx(alone, rel=1e-9)
    q[:, held - 1] *= np.linspace(0, 30, len(t))
    with pytest.raises(LogError, match=f"q{held} moves, and joint {held} is fixed"):
        error(log(q, tau))


def test_units_are_those_of_the_columns_of_the_file(tmp_path) -> None:
    """The column of a fixed joint has any unit; those behind it keep their type."""
    from symgen.estimation.opening import open_log

    robot = with_fixed(import_urdf(ARM), ["shoulder"]).robot
    t = np.arange(0, 4, 0.01)
    elbow, finger = 50 + 40 * np.cos(t), 20 + 10 * np.sin(t)
    table = np.column_stack([t, 0 * t + 7, -elbow, finger, t, t, t])
    header = "t,q1 [mm],q2 [deg],q3 [mm],tau1,tau2,tau3"
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header=header, comments="")
    log = open_log(tmp_path / "log.csv", robot)
    np.testing.assert_allclose(log.q, np.column_stack([-np.radians(elbow), 1e-3 * finger]))


def test_inertias_of_the_file_are_a_prior_of_the_robot_with_held_joints(tmp_path) -> None:
    import symgen
    from symgen.identification.parameters import read_parameters

    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    held = with_fixed(import_urdf(ARM), ["finger=0.02"])
    model = symgen.derive(held.robot)
    X = dict(zip(model.base.names, read_parameters(path, model), strict=True))
    from_toml = tmp_path / "robot_parameters.toml"
    from_toml.write_text(parameters_toml(held.parameters))
    again = dict(zip(model.base.names, read_parameters(from_toml, model), strict=True))
    assert again == X


def test_zeros_of_rotors_that_a_robot_has_not_are_no_fault(tmp_path) -> None:
    import symgen
    from symgen.errors import ParameterError
    from symgen.identification.parameters import read_parameters

    imported = import_urdf(ARM)
    values = tmp_path / "parameters.toml"
    values.write_text(parameters_toml(imported.parameters))
    bare = replace(
        imported.robot,
        joints=tuple(replace(j, rotor_inertia=False) for j in imported.robot.joints),
    )
    model = symgen.derive(bare)
    assert np.isfinite(read_parameters(values, model)).all()
    values.write_text(values.read_text().replace("IA1 = 0.0", "IA1 = 0.2"))
    with pytest.raises(ParameterError, match="IA1 is no parameter"):
        read_parameters(values, model)


def test_links_on_fixed_joints_have_no_columns_of_their_own() -> None:
    """The search for wrong lengths and other gravity sees two links, with the true torques."""
    import symgen
    from symgen.identification.parameters import base_values
    from symgen.symbolic.variation import link_values, variation

    nails = "".join(
        f'<link name="n{k}"><inertial><origin xyz="0.01 0 0"/><mass value="0.1"/>'
        '<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>'
        f'<joint name="f{k}" type="fixed"><parent link="left"/><child link="n{k}"/>'
        f'<origin xyz="0 0.0{k} 0.05"/></joint>'
        for k in range(10, 30)
    )
    text = ARM.replace("</robot>", f"{nails}</robot>")
    held = with_fixed(import_urdf(text), ["finger=0.02"])
    model = symgen.derive(held.robot, ())
    links = link_values(model.robot, model.base, base_values(dict(held.parameters), model, "arm"))
    assert links.shape == (2, 10)
    v = variation(model.robot)
    assert {joint for joint, _ in v.lengths} <= {1, 2}
    q, qd, qdd = np.random.default_rng(3).uniform(-1, 1, (3, 5, 2))
    tau, pinocchio = v.torque((q, qd, qdd), links), PinocchioUrdf(text)
    for i in range(5):
        state = [dict(zip(("shoulder", "elbow"), x[i], strict=True)) for x in (q, qd, qdd)]
        at = [{"finger": 0.02, "other_finger": 0.025}, *2 * [{"finger": 0.0, "other_finger": 0.0}]]
        want = pinocchio.torques(*(x | fixed for x, fixed in zip(state, at, strict=True)))
        np.testing.assert_allclose(tau[i], [want["shoulder"], want["elbow"]], rtol=1e-9, atol=1e-9)
