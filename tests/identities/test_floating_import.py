"""URDF and MJCF of robots with a floating base: import, export, and values in MuJoCo."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support import parsed
from support_estimate import write_estimate

import symgen
from symgen.codegen.model import regrouping
from symgen.identification.physical import bodies
from symgen.robot.body import Dynamics
from symgen.robot.formats.urdf import import_urdf, updated_urdf
from symgen.robot.toml_io import read_imported

TRUNK = '<inertial pos="0.02 -0.01 0.03" mass="4" fullinertia="0.05 0.06 0.07 0.004 -0.003 0.002"/>'
LEG = """<body name="hip{i}" pos="0.2 {y} 0"><joint name="roll{i}" axis="1 0 0"/>
<inertial pos="0.01 0 0.02" mass="0.6" diaginertia="0.003 0.004 0.005"/>
<body name="shin{i}" pos="0 0.05 -0.2" euler="0 20 0"><joint name="pitch{i}" axis="0 1 0"/>
<inertial pos="0 0.01 -0.1" mass="0.4" diaginertia="0.002 0.003 0.001"/></body></body>"""
LEGS = "".join(LEG.format(i=i, y=y) for i, y in ((1, 0.1), (2, -0.1)))
BIPED = (
    f'<mujoco model="biped"><worldbody><geom type="plane" size="1 1 1"/>'
    f'<body name="trunk" pos="0 0 1" euler="10 0 30"><freejoint/>{TRUNK}{LEGS}</body>'
    "</worldbody></mujoco>"
)


def mjcf(folder: Path, text: str = BIPED) -> Path:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    path = folder / "biped.xml"
    path.write_text(text)
    return path


def vectors(imported, model: symgen.Model) -> np.ndarray:
    """X of the values of the file."""
    values = dict(imported.parameters)
    return regrouping(model) @ [values.get(p.name, 0.0) for p in model.base.standard]


def test_a_free_joint_is_link_0_and_moves_as_in_mujoco(tmp_path: Path) -> None:
    path = mjcf(tmp_path)
    import mujoco

    imported = read_imported(path, "floating")
    robot = imported.robot
    assert (robot.base, robot.n, robot.free) == ("floating", 4, (5, 6, 7, 8, 9, 10))
    model = symgen.derive(robot, ("forward_dynamics", "inverse_dynamics"))
    call, X = symgen.load(model, backend="casadi"), vectors(imported, model)
    for want, state in inverses(mujoco.MjModel.from_xml_path(str(path)), 5):
        found = call.inverse_dynamics(*state[:3], X, *state[3:])
        np.testing.assert_allclose(found, want, rtol=0, atol=1e-9 * np.abs(want).max())


def inverses(plant, count: int) -> Iterator[tuple[np.ndarray, tuple[np.ndarray, ...]]]:
    """Wrench on the base and torques in MuJoCo, and q, qd, qdd, f, w and wd, at random states."""
    import mujoco

    data, draw = mujoco.MjData(plant), np.random.default_rng(0)
    for _ in range(count):
        data.qpos[:], data.qvel[:] = draw.uniform(-1, 1, plant.nq), draw.uniform(-1, 1, plant.nv)
        mujoco.mj_normalizeQuat(plant, data.qpos)
        data.qacc[:] = draw.uniform(-3, 3, plant.nv)
        mujoco.mj_inverse(plant, data)
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, data.qpos[3:7])
        R = turn.reshape(3, 3)
        f = R.T @ (data.qacc[:3] - plant.opt.gravity)
        force, w, wd = data.qfrc_inverse, data.qvel[3:6], data.qacc[3:6]
        state = data.qpos[7:], data.qvel[6:], data.qacc[6:], f, w, wd
        yield np.array([*R.T @ force[:3], *force[3:]]), tuple(x.copy() for x in state)


def test_a_free_joint_needs_a_word_on_the_base(tmp_path: Path) -> None:
    path = mjcf(tmp_path)
    line = r"trunk.+free joint.+symgen import biped\.xml --into robot\.toml --base floating"
    with pytest.raises(symgen.RobotError, match=line):
        symgen.read_robot(path)
    fixed, moved, free = (read_imported(path, base) for base in ("fixed", "imu", "floating"))
    assert (fixed.robot.base, moved.robot.base) == ("fixed", "imu")
    assert len(fixed.robot.joints) == 5  # with the trunk, which is fixed on the world
    assert moved.robot.joints == free.robot.joints
    assert float(free.robot.gravity[2]) == pytest.approx(-9.81 * np.cos(np.radians(10)))
    assert parsed(symgen.robot_toml(free.robot)) == free.robot


def test_two_free_bodies_are_refused(tmp_path: Path) -> None:
    ball = '<body name="ball"><freejoint name="rolls"/><geom size="0.1"/></body></worldbody>'
    path = mjcf(tmp_path, BIPED.replace("</worldbody>", ball))
    with pytest.raises(symgen.RobotError, match=r"'ball_fixed' does not hang on the free link"):
        read_imported(path, "floating")


def test_values_of_link_0_come_back_from_an_mjcf_and_a_urdf(tmp_path: Path) -> None:
    from symgen.robot.formats.mjcf_writer import updated_mjcf

    path = mjcf(tmp_path)
    imported = read_imported(path, "floating")
    values = {name: 1.1 * value for name, value in imported.parameters}
    links = Dynamics(bodies(imported.robot, values))
    path.write_text(updated_mjcf(path, links, base="floating"))
    again = dict(read_imported(path, "floating").parameters)
    for name, value in values.items():
        assert again[name] == pytest.approx(value, abs=1e-12), name
    found = import_urdf(URDF, base="floating")
    values = {name: 1.1 * value for name, value in found.parameters}
    text = updated_urdf(URDF, Dynamics(bodies(found.robot, values)), base="floating")
    again = dict(import_urdf(text, base="floating").parameters)
    for name, value in values.items():
        assert again[name] == pytest.approx(value, abs=1e-12), name


ROTOR = 0.02  # kg m2


def identified(folder: Path, imported) -> tuple[symgen.Model, np.ndarray]:
    """A model and its X, whose links are up to 30 % off the file; an estimate of it in a folder."""
    model = symgen.derive(imported.robot, ("inverse_dynamics", "mass_matrix"))
    draw, values = np.random.default_rng(1), dict(imported.parameters)
    factors = draw.uniform(0.7, 1.3, len(imported.robot.joints) + 1)
    links = [factors[p.joint] * values.get(p.name, 0.0) for p in model.base.standard]
    drives = {"IA": ROTOR, "FV": 0.3}
    given = [drives.get(p.prefix, x) for p, x in zip(model.base.standard, links, strict=True)]
    X = regrouping(model) @ given
    write_estimate(folder, model, X)
    return model, X


def test_mujoco_moves_an_exported_floating_base_as_the_estimate(tmp_path: Path) -> None:
    path = mjcf(tmp_path)
    import mujoco

    model, X = identified(tmp_path / "id", read_imported(path, "floating"))
    call = symgen.load(model, backend="casadi")
    text = symgen.export(tmp_path / "id", path).text
    plant = mujoco.MjModel.from_xml_string(text)
    for want, state in inverses(plant, 5):
        found = call.inverse_dynamics(*state[:3], X, *state[3:])
        np.testing.assert_allclose(found, want, rtol=0, atol=1e-9 * np.abs(want).max())


def test_an_export_is_compared_with_a_log(tmp_path: Path, command) -> None:
    path, t = mjcf(tmp_path), np.linspace(0.0, 4.0, 401)
    robot = read_imported(path, "floating").robot
    identified(tmp_path / "id", read_imported(path, "floating"))
    q, tau = (np.sin(np.outer(t, np.arange(1, 5)) + phase) for phase in (0.0, 1.0))
    imu = np.concatenate([0 * q[:, :2], 9.81 + 0 * q[:, :1], q[:, :3]], axis=1)
    np.savez(tmp_path / "a.npz", t=t, q=q, tau=tau, imu=imu)
    to = tmp_path / "new.xml"
    words = ("export", tmp_path / "id", "--from", path, "--to", to, "--log", tmp_path / "a.npz")
    code, out, err = command(*words)
    assert code == 0, err
    assert "torque error on " in out
    assert read_imported(to, "floating").robot.joints == robot.joints


def test_pinocchio_moves_an_exported_floating_base_as_the_estimate(tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
    path = tmp_path / "r.urdf"
    path.write_text(URDF)
    model, X = identified(tmp_path / "id", read_imported(path, "floating"))
    call = symgen.load(model, backend="casadi")
    text = rooted(symgen.export(tmp_path / "id", path).text)
    there = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    data, draw = there.createData(), np.random.default_rng(2)
    there.armature[6:] = ROTOR  # of a URDF, Pinocchio reads none
    for _ in range(5):
        q, qd, qdd = draw.uniform(-1, 1, (3, 1))
        v, w, vd, wd = draw.uniform(-1, 1, (4, 3))
        turn = pin.Quaternion(draw.uniform(-1, 1, 4)).normalized()
        place = np.array([0, 0, 0, *turn.coeffs(), *np.cos(q), *np.sin(q)])
        f = vd + np.cross(w, v) - turn.matrix().T @ there.gravity.linear
        want = pin.rnea(there, data, place, np.array([*v, *w, *qd]), np.array([*vd, *wd, *qdd]))
        want += [*np.zeros(6), *there.damping[6:] * qd]
        found = call.inverse_dynamics(q, qd, qdd, X, f, w, wd)
        np.testing.assert_allclose(found, want, rtol=0, atol=1e-9 * np.abs(want).max())
        M = np.triu(pin.crba(there, data, place))
        np.testing.assert_allclose(np.triu(call.mass_matrix(q, X)), M, rtol=0, atol=1e-9 * M.max())


def rooted(text: str) -> str:
    """The URDF without its world: Pinocchio's free flyer stands for the floating joint."""
    root = re.escape('<joint name="root" type="floating">') + ".*?</joint>"
    return re.sub(root, "", text.replace('<link name="world"/>', ""), flags=re.DOTALL)


INERTIA = '<inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0" izz="0.04"/>'
BODY = f'<inertial><origin xyz="0.1 0 0.02"/><mass value="2"/>{INERTIA}</inertial>'
URDF = (
    '<robot name="r"><link name="world"/>'
    f'<link name="base">{BODY}</link><link name="box">{BODY}</link><link name="a">{BODY}</link>'
    '<joint name="root" type="floating"><parent link="world"/><child link="base"/></joint>'
    '<joint name="lid" type="fixed"><origin xyz="0 0 0.1"/>'
    '<parent link="base"/><child link="box"/></joint>'
    '<joint name="j" type="continuous"><origin xyz="0.3 0 0" rpy="0.2 0 0"/>'
    '<parent link="base"/><child link="a"/></joint></robot>'
)


def test_the_root_link_of_a_urdf_is_link_0() -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
    imported = import_urdf(URDF, base="floating")
    values = dict(imported.parameters)
    assert (values["M0"], values["MX0"], values["MZ0"]) == (2.0, 0.2, pytest.approx(0.04))
    model = symgen.derive(imported.robot, ("inverse_dynamics", "mass_matrix"))
    X = vectors(imported, model)
    M = symgen.load(model, backend="casadi").mass_matrix([0.4], X)
    there = pin.buildModelFromXML(rooted(URDF), pin.JointModelFreeFlyer())
    data = there.createData()
    place = [0, 0, 0, 0, 0, 0, 1, np.cos(0.4), np.sin(0.4)]
    want = np.triu(pin.crba(there, data, np.array(place, float)))
    np.testing.assert_allclose(np.triu(M), want, atol=1e-12)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("[base]\nposition = [0, 0, 1, 2]\n", "position.+4 entries; accepted: 3"),
        ('[[contact]]\nframe = "toe"\nkind = "point"\n', "contact 1, key 'frame'.+no frame 'toe'"),
        ('[[contact]]\nframe = "toe"\nkind = "rope"\n', "kind.+'point' or 'surface'"),
    ],
)
def test_tables_of_a_floating_base_are_checked(table: str, message: str) -> None:
    head = '[robot]\nname = "drone"\nbase = "floating"\n'
    with pytest.raises(symgen.RobotError, match=message):
        parsed(head + table)


def test_the_place_of_the_imu_and_contacts_are_read_and_written() -> None:
    text = (
        '[robot]\nname = "drone"\nbase = "floating"\n[[frame]]\nname = "skid"\njoint = 0\n'
        "[base]\nposition = [0.1, 0.0, 0.02]\nrotation = [0.0, 0.0, 1.5]\n"
        '[[contact]]\nframe = "skid"\nkind = "surface"\n'
    )
    robot = parsed(text)
    assert robot.mount.position == (0.1, 0.0, 0.02)
    assert parsed(symgen.robot_toml(robot)) == robot
    for base in ("fixed", "imu"):
        with pytest.raises(symgen.RobotError, match=r"contact: accepted|base: accepted"):
            parsed(text.replace("floating", base) + "[[joint]]\n")
