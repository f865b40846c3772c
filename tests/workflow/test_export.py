"""export: link parameters in the robot's own file, with a finger held and a frame without mass."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.robot.body import Dynamics
from symgen.robot.formats.urdf import updated_urdf

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")

URDF = """<?xml version="1.0"?>
<!-- an arm with a gripper -->
<robot name="gripper_arm">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base"><inertial><mass value="9"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0.1 0.02 0.2"/><mass value="2.0"/>
    <inertia ixx="0.05" ixy="0.001" ixz="0" iyy="0.06" iyz="0" izz="0.02"/></inertial>
    <visual><geometry><sphere radius="0.1"/></geometry></visual></link>
  <link name="lower"><inertial><origin xyz="0 0.01 0.15" rpy="0.1 0 0"/><mass value="1.2"/>
    <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.005"/></inertial></link>
  <link name="flange"/>
  <link name="finger_link"><inertial><origin xyz="0 0.03 0.02"/><mass value="0.2"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0 0.4 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0.05 0.4"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="40" velocity="3"/></joint>
  <joint name="flange_joint" type="fixed"><parent link="lower"/><child link="flange"/>
    <origin xyz="0 0 0.3" rpy="0.3 0 0.5"/></joint>
  <joint name="finger" type="prismatic"><parent link="flange"/><child link="finger_link"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.2"/></joint>
</robot>
"""
HELD = 0.03


def _rest(text: str) -> str:
    """All of a URDF but the elements that an estimate sets."""
    text = re.sub(r"\s*<inertial>.*?</inertial>", "", text, flags=re.DOTALL)
    text = re.sub(r"(<link [^>]*)>\s*</link>", r"\1/>", text)
    return re.sub(r"\s+", "", re.sub(r"\s*<dynamics [^>]*>", "", text))


def weights(pin, text: str, q: np.ndarray) -> np.ndarray:
    """Torques of gravity and mass matrices of a URDF whose finger stands at HELD, by Pinocchio."""
    model = pin.buildModelFromXML(text)
    model.armature[:] = 0
    data = model.createData()
    out = []
    for row in q:
        at = np.append(row, HELD)
        out.append(np.append(pin.computeGeneralizedGravity(model, data, at)[:2],
                             np.triu(pin.crba(model, data, at))[:2, :2]))  # fmt: skip
    return np.array(out)


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """A folder with the robot, its URDF and an estimate that is 20 % heavier than the URDF."""
    from symgen.identification.estimate import Estimate, JointLabel, ParameterEstimate, Residual
    from symgen.identification.parameters import read_parameters
    from symgen.robot.fixed import with_fixed
    from symgen.robot.formats.urdf import import_urdf

    folder = tmp_path_factory.mktemp("identified")
    (folder / "arm.urdf").write_text(URDF)
    robot = with_fixed(import_urdf(URDF), [f"finger={HELD}"]).robot
    # A URDF has no rotors: without them in the model, all that is identified goes into its links.
    joints = tuple(replace(joint, rotor_inertia=False) for joint in robot.joints)
    robot = replace(robot, joints=joints)
    (folder / "robot.toml").write_text(symgen.robot_toml(robot))
    model = symgen.derive(robot)
    X = 1.2 * read_parameters(folder / "arm.urdf", model)
    parameters = tuple(
        ParameterEstimate(p.name, p.expression, float(x), 0.01, p.unit)
        for p, x in zip(model.base.parameters, X, strict=True)
    )
    fit = Residual(0.02)
    estimate = Estimate(
        robot=robot.name, joints=(JointLabel(1, "N m"), JointLabel(2, "N m")), model="momentum",
        method="wls", parameters=parameters, condition_number=3.0, train=fit, validation=fit,
        cutoff_hz=8.0, window_s=0.2, verdict="trusted", reasons=(),
        correlation=np.eye(len(X)),
    )  # fmt: skip
    (folder / "estimate.json").write_text(json.dumps(estimate.to_json()))
    return folder


def test_the_written_file_moves_as_the_estimate_and_is_else_the_same(
    identified, tmp_path, command
) -> None:
    from oracles.pinocchio_arm import load_pinocchio

    to = tmp_path / "out.urdf"
    source = identified / "arm.urdf"
    code, out, err = command("export", identified, "--from", source, "--to", to)
    assert code == 0, err
    assert "base parameters do not determine link parameters" in out
    new = to.read_text()
    text, _, mark = new.rpartition("<!--")
    assert mark.startswith(" written by symgen, digest ")
    assert _rest(text) == _rest(URDF)
    assert '<mass value="9"/>' in new  # the base is not seen
    flange = re.search('<link name="flange">(.*?)</link>', new, re.DOTALL).group(1)
    assert '<mass value="1e-9"/>' in flange  # PyBullet reads 1 kg where a link has no <inertial>
    pin = load_pinocchio()
    q = np.random.default_rng(3).uniform(-1.5, 1.5, (5, 2))
    np.testing.assert_allclose(weights(pin, new, q), 1.2 * weights(pin, URDF, q), rtol=1e-6)
    first = to.read_bytes()
    assert command("export", identified, "--from", source, "--to", to)[0] == 0
    assert to.read_bytes() == first


@pytest.mark.parametrize("source", [True, False], ids=["from", "no from"])
def test_a_file_of_the_user_is_kept_and_the_printed_line_copies_it(
    identified, tmp_path, command, source
) -> None:
    mine = tmp_path / "my arm.urdf"
    mine.write_text(URDF)
    code, _, err = command("export", identified, *(["--from", mine] * source), "--to", mine)
    assert (code, mine.read_text()) == (2, URDF)
    words = shlex.split(err.partition("try: symgen ")[2])
    assert words[words.index("--from") + 1] == str(mine)
    written = Path(words[words.index("--to") + 1])
    assert command(*words)[0] == 0
    assert command(*words)[0] == 0  # what nobody changed is replaced
    edited = written.read_text().replace("flange", "tool0")
    written.write_text(edited)
    code, _, err = command(*words)
    assert (code, written.read_text()) == (2, edited)
    assert f"--from '{written}'" in err


def test_meshes_are_found_from_another_folder(identified, tmp_path, command) -> None:
    parts, source = tmp_path / "a & b", tmp_path / "arms" / "arm.urdf"
    kept = '<mesh filename="package://arm/mesh.stl"/>'
    for folder in (parts, source.parent):
        folder.mkdir()
    (parts / "rock.obj").write_text("v 0 0 0\nv 1 2 3\n")
    source.write_text(
        URDF.replace('<sphere radius="0.1"/>', '<mesh filename="../a &amp; b/rock.obj"/>').replace(
            '<link name="flange"/>',
            f'<link name="flange"><visual><geometry>{kept}</geometry></visual></link>',
        )
    )
    to = tmp_path / "deep" / "er" / "out.urdf"
    code, _, err = command("export", identified, "--from", source, "--to", to)
    assert code == 0, err
    assert 'filename="../../a &amp; b/rock.obj"' in to.read_text()
    assert kept in to.read_text()
    beside = source.with_name("beside.urdf")
    assert command("export", identified, "--from", source, "--to", beside)[0] == 0
    assert 'filename="../a &amp; b/rock.obj"' in beside.read_text()


def test_escape_bytes_of_a_name_reach_no_terminal(identified, tmp_path, command) -> None:
    t = np.linspace(0.0, 5.0, 501)
    motion = np.column_stack([t, np.sin(2 * t), np.cos(3 * t), np.sin(t), np.cos(t)])
    log, to = (tmp_path / f"\x1b]0;x\x07{name}" for name in ("log.csv", "out.urdf"))
    np.savetxt(log, motion, delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    source = identified / "arm.urdf"
    code, out, err = command("export", identified, "--from", source, "--to", to, "--log", log)
    assert code in (0, 1), err
    assert "comparing with" in err
    assert "\x1b]" not in out + err


def test_torques_above_the_limits_of_the_file_are_named(identified, tmp_path, command) -> None:
    """The file limits the elbow to 40 N m and the shoulder to 50 N m."""
    t = np.linspace(0.0, 5.0, 501)
    motion = np.column_stack([t, np.sin(2 * t), np.cos(3 * t), 45 * np.sin(t), 45 * np.cos(t)])
    log = tmp_path / "log.csv"
    np.savetxt(log, motion, delimiter=",", header="t,q1,q2,tau1,tau2", comments="")
    source, to = identified / "arm.urdf", tmp_path / "out.urdf"
    code, out, err = command("export", identified, "--from", source, "--to", to, "--log", log)
    assert code in (0, 1), err
    assert (
        "note: log.csv: torques of elbow (2) are above the limits in arm.urdf, where Drake, "
        "Genesis and the actuators of MuJoCo clip them" in " ".join(out.split())
    )


def test_link_parameters_go_into_a_urdf_as_they_are(identified) -> None:
    robot = symgen.read_robot(identified / "robot.toml")
    model = symgen.derive(robot)
    links = symgen.link_parameters(model, symgen.read_estimate(identified).X)
    assert updated_urdf(URDF, Dynamics(links.bodies)) != URDF


REFUSED = {
    "nothing to copy": ("other.urdf", "--from is missing"),
    "another name": ("arm.txt", "both end in .urdf, or both in .xml"),
    "a file of somebody": ("mine.urdf", "mine_identified.urdf --from"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_written_is_refused(identified, tmp_path, command, case) -> None:
    name, says = REFUSED[case]
    (tmp_path / "mine.urdf").write_text('<robot name="mine"><link name="a"/></robot>')
    asked = ["export", identified, "--to", tmp_path / name]
    if name == "mine.urdf":
        asked += ["--from", identified / "arm.urdf"]
    code, _, err = command(*asked)
    assert code == 2
    assert says in err
    assert "mine" in (tmp_path / "mine.urdf").read_text()
