"""MJCF in and out: MuJoCo moves the file, and what was written into it, as symgen says."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from oracles.urdf_arm import PinocchioUrdf
from support import sampled
from support_estimate import write_estimate
from support_urdf import Ours

import symgen
from symgen.errors import RobotError
from symgen.robot.fixed import with_fixed
from symgen.robot.toml_io import read_imported

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

MJCF = """<mujoco model="mjarm">
  <!-- a remark -->
  <compiler angle="degree" autolimits="true"/>
  <option gravity="0 0.5 -9.7"/>
  <default><joint damping="0.5" armature="0.1"/></default>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="base" pos="0 0 0.1" quat="0.9 0 0 0.4">
      <inertial pos="0 0 0" mass="4" diaginertia="0.1 0.1 0.1"/>
      <body name="upper" pos="0 0 0.3" euler="0 23 0">
        <joint name="shoulder" axis="0 1 0" range="-110 110" frictionloss="0.3"/>
        <inertial pos="0.1 0.02 0.2" mass="2" fullinertia="0.05 0.06 0.02 0.001 0 0"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0 0 0.4"/>
        <body name="lower" pos="0 0.05 0.4">
          <joint name="elbow" axis="1 0 0" pos="0.02 0.01 0.03" range="-110 110"/>
          <joint name="slide" type="slide" axis="0 0.6 0.8" range="-0.1 0.2"/>
          <inertial pos="0 0.01 0.15" quat="0.98 0.1 0 0.05" mass="1.2"
                    diaginertia="0.02 0.02 0.005"/>
          <body name="flange" pos="0 0 0.3" euler="10 -20 30">
            <inertial pos="0 0 0.02" mass="0.3" diaginertia="0.001 0.001 0.001"/>
            <body name="tip" pos="0 0 0.05">
              <joint name="finger" type="slide" axis="0 1 0" range="0 0.04"/>
              <geom type="box" size="0.01 0.02 0.03" pos="0 0.02 0.03" mass="0.2"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def torques(text: str, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """Rigid-body torques of an MJCF by MuJoCo, without rotors, friction and contact."""
    model = mujoco.MjModel.from_xml_string(text)
    model.dof_armature[:] = model.dof_damping[:] = model.dof_frictionloss[:] = 0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return inverse(model, q, qd, qdd)


def inverse(model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """Torques of a model in states, (N, n)."""
    data = mujoco.MjData(model)
    out = []
    for x, v, a in zip(q, qd, qdd, strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = x, v, a
        mujoco.mj_inverse(model, data)
        out.append(data.qfrc_inverse.copy())
    return np.array(out)


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(MJCF)
    return path


def test_an_imported_mjcf_has_the_torques_of_mujoco(arm) -> None:
    found = read_imported(arm)
    ours = Ours(found)
    assert ours.names == ["shoulder", "elbow", "slide", "finger"]
    states = ours.states(8)
    want = torques(MJCF, **states)
    np.testing.assert_allclose(ours.torques(**states), want, rtol=1e-9, atol=1e-9)
    values = dict(found.parameters)
    assert (values["IA1"], values["FV2"], values["FS1"], values["FS2"]) == (0.1, 0.5, 0.3, 0.0)
    assert found.robot.limits is not None
    np.testing.assert_allclose(
        found.robot.limits.position,
        [np.radians((-110, 110)), np.radians((-110, 110)), (-0.1, 0.2), (0, 0.04)],
    )


def test_identified_parameters_go_into_the_mjcf_and_nothing_else_changes(tmp_path, command) -> None:
    from symgen.identification.parameters import read_parameters

    source = re.sub('<joint name="slide".*?/>', "", MJCF)
    arm = tmp_path / "arm.xml"
    arm.write_text(source)
    robot = with_fixed(read_imported(arm), ["finger=0.01"]).robot
    joints = tuple(replace(joint, rotor_inertia=False) for joint in robot.joints)
    robot = replace(robot, joints=joints)  # what is identified is in the links alone
    model = symgen.derive(robot)
    result = tmp_path / "result"
    write_estimate(result, model, 1.3 * read_parameters(arm, model))
    to = tmp_path / "out.xml"
    code, out, err = command("export", result, "--from", arm, "--to", to)
    assert code == 0, err
    assert "base parameters do not determine link parameters" in out
    new = to.read_text()
    assert _rest(new) == _rest(source)
    assert "<!-- a remark -->" in new
    rng = np.random.default_rng(2)
    q, qd, qdd = rng.uniform(-1, 1, (3, 6, 3))
    q[:, 2], qd[:, 2], qdd[:, 2] = 0.01, 0, 0
    want = 1.3 * torques(source, q, qd, qdd)
    np.testing.assert_allclose(torques(new, q, qd, qdd)[:, :2], want[:, :2], rtol=1e-5, atol=1e-5)


# The same two joints in another file, whose links and fixed links are others.
URDF = """<robot name="two">
 <link name="world"/><link name="upper"><inertial><origin xyz="0.1 0.02 0.2"/><mass value="2"/>
  <inertia ixx="0.05" ixy="0.001" ixz="0" iyy="0.06" iyz="0" izz="0.02"/></inertial></link>
 <link name="lower"><inertial><origin xyz="0 0.01 0.15" rpy="0.1 0 0"/><mass value="1.2"/>
  <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.005"/></inertial></link>
 <link name="flange"/><link name="tool"><inertial><origin xyz="0 0 0.1"/><mass value="0.7"/>
  <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.002"/></inertial></link>
 <joint name="shoulder" type="continuous"><parent link="world"/><child link="upper"/>
  <origin xyz="0 0 0.3" rpy="0 0.4 0"/><axis xyz="0 1 0"/></joint>
 <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
  <origin xyz="0 0.05 0.4"/><axis xyz="1 0 0"/></joint>
 <joint name="end" type="fixed"><parent link="lower"/><child link="flange"/>
  <origin xyz="0 0 0.3" rpy="0.3 0 0.5"/></joint>
 <joint name="grip" type="fixed"><parent link="flange"/><child link="tool"/></joint>
</robot>
"""
TWO = """<mujoco model="two"><compiler angle="radian"/><worldbody>
 <body name="upper" pos="0 0 0.3" euler="0 0.4 0"><joint name="shoulder" axis="0 1 0"/>
  <inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
  <body name="lower" pos="0 0.05 {height}"><joint name="elbow" axis="1 0 0"/>
   <inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.1 0.1"/></body></body>
</worldbody></mujoco>
"""


def test_an_estimate_of_a_urdf_goes_into_an_mjcf_with_the_same_moving_frames(
    tmp_path, command
) -> None:
    from symgen.identification.parameters import read_parameters

    urdf, mjcf, to = (tmp_path / name for name in ("two.urdf", "two.xml", "out.xml"))
    urdf.write_text(URDF)
    robot = read_imported(urdf).robot
    joints = tuple(replace(j, rotor_inertia=False, friction=()) for j in robot.joints)
    model = symgen.derive(replace(robot, joints=joints))
    write_estimate(tmp_path / "result", model, 1.2 * read_parameters(urdf, model))
    mjcf.write_text(TWO.format(height=0.4))
    code, _, err = command("export", tmp_path / "result", "--from", mjcf, "--to", to)
    assert code == 0, err
    arm = PinocchioUrdf(URDF)
    q, qd, qdd = np.random.default_rng(4).uniform(-1, 1, (3, 6, 2))
    tau = torques(to.read_text(), q, qd, qdd)
    for i in range(6):
        want = arm.torques(*(dict(zip(("shoulder", "elbow"), x[i], strict=True))
                             for x in (q, qd, qdd)))  # fmt: skip
        np.testing.assert_allclose(
            tau[i], [1.2 * want["shoulder"], 1.2 * want["elbow"]], rtol=1e-5, atol=1e-5
        )
    assert np.allclose(read_parameters(to, model), 1.2 * read_parameters(urdf, model), atol=1e-6)
    mjcf.write_text(TWO.format(height=0.5))
    code, _, err = command(
        "export", tmp_path / "result", "--from", mjcf, "--to", tmp_path / "x.xml"
    )
    assert code == 2
    assert "shoulder (1)" in err or "elbow (2)" in err
    assert not (tmp_path / "x.xml").exists()


TWO_MOTORS = """<mujoco model="arm"><compiler angle="radian"/><worldbody>
<body name="upper"><joint name="shoulder" axis="0 1 0" armature="0.15" damping="0.9 0.5 0.1"
  stiffness="6 2.5 0.3" springref="0.2"/>
  <inertial pos="0.25 0 0" mass="3" diaginertia=".02 .08 .1"/>
<body name="lower" pos="0.5 0 0"><joint name="elbow" axis="0 1 0" armature="0.05" damping="0.4"/>
  <inertial pos="0.2 0 0" mass="1.8" diaginertia="0.01 0.03 0.03"/></body></body></worldbody>
<actuator><motor joint="shoulder" gear="100" armature="{armature}" damping="1e-4 2e-5 3e-6"/>
<motor joint="elbow" gear="50" armature="4e-5"/></actuator></mujoco>"""


def test_what_motors_add_is_subtracted_and_higher_orders_need_the_option(tmp_path, command) -> None:
    from symgen.identification.parameters import read_parameters

    arm, out = tmp_path / "arm.xml", tmp_path / "out.xml"
    arm.write_text(TWO_MOTORS.format(armature="3e-5"))
    model = symgen.derive(read_imported(arm).robot)
    write_estimate(tmp_path / "result", model, read_parameters(arm, model))
    to = ("export", tmp_path / "result", "--from", arm, "--to")
    code, _, err = command(*to, out, "--mujoco", "3.7")
    assert code == 0, err
    np.testing.assert_allclose(
        read_parameters(out, model), read_parameters(arm, model), rtol=1e-6, atol=1e-7
    )
    _, elbow, *_ = re.findall('armature="(.*?)"', out.read_text())  # that of the shoulder joins ZZ1
    assert float(elbow) == pytest.approx(0.05, abs=1e-6)
    arm.write_text(TWO_MOTORS.format(armature="3e-3"))  # 30 kg m2 at the joint
    code, _, err = command(*to, tmp_path / "x.xml", "--mujoco", "3.7")
    assert code == 2
    assert "armature 30, more than the identified 0." in err
    assert not (tmp_path / "x.xml").exists()
    code, _, err = command(*to, tmp_path / "x.xml", "--mujoco", "new")
    assert (code, "3.7" in err) == (2, True)


def _rest(text: str) -> list[str]:
    """Words of an MJCF without its inertias and joint dynamics, and what symgen says of them."""
    without = re.sub("<!-- written by symgen.*?-->", "", text, flags=re.DOTALL)
    without = re.sub("<inertial.*?/>", " ", without, flags=re.DOTALL)
    written = ' (armature|damping|frictionloss|stiffness|sol(ref|imp)friction)=".*?"'
    return re.sub(written, "", without).split()


MESH = '<asset><mesh name="m" file="nothere.stl"/></asset>'
DRAWN = '<geom type="mesh" mesh="m"/>'
REFUSED = {
    "a floating base": ('<joint name="shoulder" axis="0 1 0"', '<joint name="shoulder" type="ball"',
                        "it is ball"),
    "no MJCF": ("<worldbody>", "<worldbodies>", "MuJoCo refuses it"),
    "a mesh that is not there and has mass": (
        '<geom type="box" size="0.01 0.02 0.03" pos="0 0.02 0.03" mass="0.2"/>',
        DRAWN, "nothere.stl",
    ),
    "an axis without a direction": ('axis="1 0 0" pos', 'axis="1e300 0 0" pos', "no direction"),
    "an infinite mass": ('mass="1.2"', 'mass="inf"', "body 'lower': Infinity is out of range"),
    "no position": ('"0 0 0.3" euler="0 23', '"nan 0 0" euler="0 23', "body 'upper': NaN"),
    "no armature": ('name="finger"', 'armature="nan" name="finger"', "finger', armature: NaN"),
    "no number of gravity": ('gravity="0 0.5 -9.7"', 'gravity="0 nan 0"', "gravity: NaN"),
    "no gravity": ('gravity="0 0.5 -9.7"', 'gravity="0 0 0"', "gravity is zero"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_arm_is_refused_in_one_line(arm, case) -> None:
    old, new, says = REFUSED[case]
    text = MJCF.replace(old, new)
    if DRAWN in text:
        text = text.replace("<worldbody>", f"{MESH}<worldbody>")
    if case == "a floating base":
        text = text.replace(' range="-110 110" frictionloss', " frictionloss")
    arm.write_text(text)
    with pytest.raises(RobotError, match=says) as caught:
        read_imported(arm)
    assert "\n" not in str(caught.value)


def test_joints_whose_ref_is_not_zero_have_the_torques_of_mujoco(arm) -> None:
    text = MJCF.replace('axis="1 0 0" pos', 'axis="1 0 0" ref="10" pos')
    arm.write_text(text.replace('axis="0 0.6 0.8"', 'axis="0 0.6 0.8" ref="0.05"'))
    ours = Ours(read_imported(arm))
    states = ours.states(8)
    want = torques(arm.read_text(), **states)
    np.testing.assert_allclose(ours.torques(**states), want, rtol=1e-9, atol=1e-9)


def test_a_joint_that_an_equality_binds_follows_as_in_mujoco(arm) -> None:
    """tau of the leader is that of both joints, by the factor."""
    text = MJCF.replace('axis="0 0.6 0.8"', 'axis="0 0.6 0.8" ref="0.05"')
    bound = '<joint joint1="finger" joint2="slide" polycoef="0.01 -0.5 0 0 0"/>'
    arm.write_text(text.replace("</mujoco>", f"<equality>{bound}</equality></mujoco>"))
    found = read_imported(arm)
    ours = Ours(found, free=False)
    assert ours.names == ["shoulder", "elbow", "slide"]
    states = ours.states(8)
    q, qd, qdd = states.values()
    follower = [0.01 - 0.5 * (q[:, 2:] - 0.05), -0.5 * qd[:, 2:], -0.5 * qdd[:, 2:]]
    tau = torques(text, *map(np.hstack, zip(states.values(), follower, strict=True)))
    want = tau[:, :3] + tau[:, 3:] * [0, 0, -0.5]
    np.testing.assert_allclose(ours.torques(**states), want, rtol=1e-9, atol=1e-9)


def test_a_mesh_for_display_need_not_be_there(arm) -> None:
    whole = read_imported(arm)
    text = MJCF.replace("<worldbody>", f"{MESH}<worldbody>")
    arm.write_text(text.replace('<body name="flange"', f'{DRAWN}<body name="flange"'))
    found = read_imported(arm)
    assert (found.robot, found.parameters) == (whole.robot, whole.parameters)
    assert any("nothere.stl" in note for note in found.notes)


def test_what_mujoco_warns_of_is_written_nowhere(arm, tmp_path, monkeypatch, capfd) -> None:
    """By itself it prints, and writes MUJOCO_LOG.TXT into the folder where one stands."""
    text = MJCF.replace('pos="0.1 0.02 0.2" mass="2"', 'pos="0.1 0.02 4e9" mass="2"')
    text = text.replace("1.2", "1e-9").replace('armature="0.1"', "")
    arm.write_text(text)
    monkeypatch.chdir(tmp_path)
    before = set(tmp_path.iterdir())
    mujoco.MjModel.from_xml_path(str(arm))
    assert (tmp_path / "MUJOCO_LOG.TXT").exists()  # the file is one that MuJoCo warns of
    (tmp_path / "MUJOCO_LOG.TXT").unlink()
    capfd.readouterr()
    read_imported(arm)
    assert set(tmp_path.iterdir()) == before
    assert capfd.readouterr() == ("", "")


# Joint 2 is perpendicular to joint 1, joint 3 parallel to joint 2 and joint 4 perpendicular to it.
ARM = """<mujoco model="rounded">
  <compiler angle="radian"/>
  <worldbody>
    <body name="one" pos="0 0 0.3">
      <joint name="j1" axis="0 0 1"/>
      <inertial pos="0.1 0.02 0.2" mass="2" diaginertia="0.1 0.1 0.1"/>
      <body name="two" pos="0 0 0.2" {turn}>
        <joint name="j2" axis="{axis}"/>
        <inertial pos="0.1 0.02 0.2" mass="2" diaginertia="0.1 0.1 0.1"/>
        <body name="three" pos="0.4 0 0.01">
          <joint name="j3" axis="{axis}"/>
          <inertial pos="0.1 0.02 0.2" mass="2" diaginertia="0.1 0.1 0.1"/>
          <body name="four" pos="0.3 0.02 0.1" {back}>
            <joint name="j4" axis="0 0 1"/>
            <inertial pos="0.1 0.02 0.2" mass="2" diaginertia="0.1 0.1 0.1"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def _words(values, digits: int) -> str:
    return " ".join(f"{v:.{digits}f}" for v in values)


def _quat(angle: float, axis) -> np.ndarray:
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * np.array(axis))])


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    out = np.empty(4)
    mujoco.mju_mulQuat(out, a, b)
    return out


def _from_rounded_rpy(angle: float, digits: int) -> str:
    """Write a quaternion with six digits of an angle that a URDF had rounded before."""
    return f'quat="{_words(_quat(round(angle, digits), (1, 0, 0)), 6)}"'


RIGHT, HALF = math.pi / 2, math.sqrt(0.5)
# How a file may write that frame two is turned by a right angle about x, then by `more` about z.
NOTATIONS = {
    "quat": lambda d: f'quat="{_words(_quat(RIGHT, (1, 0, 0)), d)}"',
    "quat off by one": lambda d: f'quat="{_words((HALF - 10.0**-d / 2, HALF, 0, 0), d)}"',
    "quat of a rounded angle": lambda d: _from_rounded_rpy(RIGHT, d),
    "quat of two turns": lambda d: (
        f'quat="{_words(_product(_quat(RIGHT, (1, 0, 0)), _quat(math.pi / 3, (0, 0, 1))), d)}"'
    ),
    "quat of a generic turn": lambda d: (
        f'quat="{_words(_product(_quat(0.3, (0, 0, 1)), _quat(RIGHT, (1, 0, 0))), d)}"'
    ),
    "quat about y, then z": lambda d: (
        f'quat="{_words(_product(_quat(RIGHT, (0, 1, 0)), _quat(0.7, (0, 0, 1))), d)}"'
    ),
    "euler": lambda d: f'euler="{_words((RIGHT, 0, 0.3), d)}"',
    "euler of a right pitch": lambda d: f'euler="{_words((0.4, RIGHT, 0.3), d)}"',
    "axisangle": lambda d: f'axisangle="1 0 0 {RIGHT:.{d}f}"',
    "xyaxes": lambda d: (
        f'xyaxes="{_words((math.cos(0.3), math.sin(0.3), 0), d)} 0 0 1"'
    ),
    "zaxis": lambda d: f'zaxis="{_words((math.sin(math.pi / 6), -math.cos(math.pi / 6), 0), d)}"',
}  # fmt: skip


@pytest.fixture
def quiet():
    """Keep MuJoCo from writing that bodies have no mass."""
    mujoco.set_mju_user_warning(lambda _: None)
    yield
    mujoco.set_mju_user_warning(None)


def _rank(text: str) -> int:
    """Number of base parameters by MuJoCo: singular values of the torques of unit parameters."""
    model = mujoco.MjModel.from_xml_string(text)
    rng = np.random.default_rng(3)
    q, qd, qdd = rng.uniform(-2, 2, (3, 60, model.nv))
    columns = []
    model.body_mass[1:] = 0
    zero = model.body_ipos.copy() * 0
    for b in range(1, model.nbody):
        for i in range(10):
            mass, com, inertia = _unit(i)
            model.body_mass[:], model.body_inertia[:], model.body_ipos[:] = 0, 0, zero
            model.body_iquat[:] = (1, 0, 0, 0)
            model.body_mass[b], model.body_ipos[b] = mass, com
            values, turn = np.linalg.eigh(inertia)
            turn[:, 2] *= np.linalg.det(turn)
            mujoco.mju_mat2Quat(model.body_iquat[b], turn.ravel())
            model.body_inertia[b] = values
            mujoco.mj_setConst(model, mujoco.MjData(model))
            columns.append(inverse(model, q, qd, qdd).ravel())
    model.body_mass[:] = model.body_inertia[:] = 0
    for k in range(model.nv):
        column = np.zeros(q.shape)
        column[:, k] = qdd[:, k]
        columns.append(column.ravel())
    W = np.column_stack(columns)
    size = np.linalg.norm(W, axis=0)
    W = W[:, size > 1e-8] / size[size > 1e-8]
    values = np.linalg.svd(W, compute_uv=False)
    return int((values > 1e-8 * values[0]).sum())


def _unit(i: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Ten bodies (mass, centre, inertia about it) that span the inertial parameters of a link."""
    inertia = np.diag([0.3, 0.4, 0.5])
    if i < 3:
        inertia[i, i] += 0.1
    elif i < 6:
        a, b = ((0, 1), (0, 2), (1, 2))[i - 3]
        inertia[a, b] = inertia[b, a] = 0.1
    com = np.zeros(3)
    if i >= 7:
        com[i - 7] = 0.3
    return (2.0 if i == 6 else 1.0), com, inertia


def _without_losses(robot: symgen.Robot) -> symgen.Robot:
    return replace(robot, joints=tuple(replace(j, friction=()) for j in robot.joints))


@pytest.mark.parametrize(
    ("notation", "digits"), sampled([(n, d) for n in NOTATIONS for d in (4, 5, 6, 7)], 8)
)
@pytest.mark.usefixtures("quiet")
def test_rounded_angles_of_any_notation_cost_no_base_parameter(tmp_path, notation, digits) -> None:
    full = ARM.format(turn=NOTATIONS[notation](15), back='euler="0 1.570796326794897 0"',
                      axis="0 0 1")  # fmt: skip
    text = ARM.format(turn=NOTATIONS[notation](digits), axis="0 0 1",
                      back=f'quat="{_words(_quat(RIGHT, (0, 1, 0)), digits)}"')  # fmt: skip
    rank = _rank(full)
    path = tmp_path / "rounded.xml"
    path.write_text(text)
    robot = _without_losses(read_imported(path).robot)
    assert len(symgen.derive(robot, ()).base.parameters) == rank
