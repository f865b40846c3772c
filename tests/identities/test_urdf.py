"""Properties of imported URDFs: motion, inertia, exactness, order, and the way back."""

import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import sympy as sp
from oracles.random_urdf import random_urdf
from oracles.urdf_arm import PinocchioUrdf, with_all_digits
from scipy.spatial.transform import Rotation
from support import sampled
from support_urdf import Ours, place_gap, torque_gap

import symgen
from symgen import robot_toml
from symgen.robot.body import Body, Dynamics
from symgen.robot.exact_numbers import fraction_of_pi
from symgen.robot.formats.urdf import import_urdf, updated_urdf
from symgen.robot.toml_io import parse_robot

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")


def joint(name, kind="revolute", ends=("base", "tip"), origin="", axis="0 0 1", inside=""):
    place = origin if origin.startswith("<") or not origin else f"<origin {origin}/>"
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{ends[0]}"/><child link="{ends[1]}"/>'
        f'{place}<axis xyz="{axis}"/>{inside}</joint>'
    )


def urdf(*joints, links=("base", "tip"), name="arm"):
    text = "".join(f'<link name="{link}"/>' for link in links) + "".join(joints)
    return f'<robot name="{name}">{text}</robot>'


@pytest.mark.parametrize("seed", sampled(range(40), 10))
def test_random_trees_have_pinocchios_torques_and_frames(seed):
    text = random_urdf(seed)
    ours, pinocchio = Ours(import_urdf(text)), PinocchioUrdf(with_all_digits(text))
    assert torque_gap(ours, pinocchio) < 1e-11
    assert place_gap(ours, pinocchio) < 1e-12


@pytest.mark.parametrize("seed", sampled(range(20), 4))
def test_quaternions_are_orientations(seed):
    text = random_urdf(seed)
    written = re.sub(r'rpy="([^"]*)"', _as_quaternion, with_all_digits(text))
    written = written.replace("<robot ", '<robot version="1.1" ', 1)
    ours = Ours(import_urdf(written))
    assert torque_gap(ours, PinocchioUrdf(with_all_digits(text))) < 1e-11


def _as_quaternion(found: re.Match[str]) -> str:
    """Return rpy as a quaternion; scipy names the angles of rotating axes zyx in upper case."""
    roll, pitch, yaw = map(float, found[1].split())
    quaternion = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()
    return f'quat_xyzw="{" ".join(repr(float(x)) for x in quaternion)}"'


def test_a_quaternion_of_a_right_angle_is_exact(tmp_path, command):
    files = {}
    for key, turn in (
        ("rpy", 'rpy="1.5707963267948966 0 0"'),
        ("quat", 'quat_xyzw="0.7071067811865476 0 0 0.7071067811865476"'),
    ):
        joints = joint("hip"), joint("knee", ends=("tip", "foot"), origin=f'xyz="0.5 0 0" {turn}')
        text = urdf(*joints, links=("base", "tip", "foot"))
        (tmp_path / f"{key}.urdf").write_text(text.replace("<robot ", '<robot version="1.1" '))
        code, _, err = command(
            "import", tmp_path / f"{key}.urdf", "--into", tmp_path / f"{key}/robot.toml"
        )
        assert code == 0, err
        files[key] = (tmp_path / f"{key}/robot.toml").read_text()
    assert files["quat"] == files["rpy"]
    assert "pi/2" in files["quat"]


ENDS = {"hip": ("base", "thigh"), "knee": ("thigh", "foot")}
LINKS = ("base", *(child for _, child in ENDS.values()))
BODY = """<inertial><mass value="1"/><inertia ixx="0.02" iyy="0.08" izz="0.09" ixy="0" ixz="0"
  iyz="0"/></inertial>"""


def _imported(tmp_path, command, joints, *rest, more=(), inside=BODY):
    """Return what `symgen import` prints, robot.toml and the parameters of a leg."""
    text = urdf(*joints, *rest, links=LINKS)
    text = text.replace('<link name="foot"/>', f'<link name="foot">{inside}</link>')
    (tmp_path / "leg.urdf").write_text(text)
    into = tmp_path / "leg" / "robot.toml"
    code, out, err = command("import", tmp_path / "leg.urdf", *more, "--into", into)
    assert code == 0, err
    return out, into.read_text(), (into.parent / "arm_parameters.toml").read_text()


def _leg(**inside):
    return [joint(name, ends=ends, inside=inside.get(name, "")) for name, ends in ENDS.items()]


def test_limits_of_acceleration_and_jerk_are_read(tmp_path, command):
    plain = '<limit lower="-1" upper="2" velocity="3" effort="40"'
    hip, knee = f'{plain} acceleration="9" deceleration="8"/>', f'{plain} acceleration="7"/>'
    _, robot, _ = _imported(tmp_path, command, _leg(hip=hip, knee=knee))
    assert "acceleration = [8.0, 7.0]" in robot
    jerks = {"hip": f'{plain} jerk="90"/>', "knee": f'{plain} jerk="80"/>'}
    assert "jerk = [90.0, 80.0]" in _imported(tmp_path, command, _leg(**jerks))[1]
    out, robot, _ = _imported(tmp_path, command, _leg(hip=hip, knee=f"{plain}/>"))
    assert "acceleration" not in robot
    assert "no acceleration limits are read: knee has none" in out


def _transmission(name, *motors):
    inside = "".join(f"<{tag}>{value}</{tag}>" for tag, value in motors)
    return (
        f'<transmission name="of_{name}"><type>transmission_interface/SimpleTransmission</type>'
        f'<joint name="{name}"/><actuator name="motor">{inside}</actuator></transmission>'
    )


def _motor(ratio, inertia):
    return ("mechanicalReduction", ratio), ("motorInertia", inertia)


def test_transmissions_give_the_gears_and_the_rotors(tmp_path, command):
    motors = _transmission("hip", *_motor(113.9, 1e-5)), _transmission("knee", *_motor(-50, 2e-5))
    out, robot, values = _imported(tmp_path, command, _leg(), *motors)
    assert "ratio = [113.9, -50.0]" in robot
    assert robot.count('_side = "joint"') == 2  # logs of a URDF's robot are on the joint side
    assert "not read" not in out
    IA = {k: float(v) for k, v in re.findall(r"IA(\d) = (\S+)", values)}
    assert IA["1"] == pytest.approx(113.9**2 * 1e-5, rel=1e-15)
    assert IA["2"] == pytest.approx(50**2 * 2e-5, rel=1e-15)
    leg = _leg(knee='<dynamics armature="0.3"/>')  # the inertia on the joint side wins
    assert "IA2 = 0.3" in _imported(tmp_path, command, leg, *motors)[2]
    _, robot, _ = _imported(tmp_path, command, _leg(), *motors, more=("--fix", "hip"))
    assert "ratio = [-50.0]" in robot


@pytest.mark.parametrize(
    "second",
    [
        "",
        _transmission("knee", ("mechanicalReduction", 50)),
        _transmission("knee", *_motor(0, 1e-5)),
        _transmission("hip", *_motor(50, 1e-5)),
        _transmission("knee", *_motor(50, 1e-5)).replace(
            "<actuator", '<joint name="hip"/><actuator'
        ),
    ],
    ids=["one", "no inertia", "no ratio", "two motors", "differential"],
)
def test_transmissions_that_do_not_give_both_are_named(tmp_path, command, second):
    first = _transmission("hip", *_motor(100, 1e-5))
    out, robot, values = _imported(tmp_path, command, _leg(), first, second)
    assert "not read, and may change the dynamics: " in out
    assert "<mechanicalReduction> (line " in out
    assert "<motorInertia> (line " in out
    assert "[drive]" not in robot
    assert "IA1 = 0.0" in values


def test_a_transmission_without_gear_needs_no_word(tmp_path, command):
    plain = [_transmission(name, ("mechanicalReduction", 1)) for name in ENDS]
    out, robot, _ = _imported(tmp_path, command, _leg(), *plain)
    assert "note" not in out
    assert "[drive]" not in robot


@pytest.mark.parametrize(
    ("inside", "named"),
    [
        (
            '<gazebo reference="hip"><springStiffness>3</springStiffness></gazebo>',
            "<springStiffness>",
        ),
        ('<gazebo><joint name="loop" type="revolute"/></gazebo>', "<joint>"),
        ('<loop_joint name="loop"/>', "<loop_joint>"),
        (
            "<ros2_control><transmission><mechanical_reduction>50</mechanical_reduction>"
            "</transmission></ros2_control>",
            "<mechanical_reduction>",
        ),
        ('<gazebo reference="hip"><mu1>3</mu1></gazebo><material name="red"/>', ""),
    ],
)
def test_what_may_change_the_dynamics_is_named(tmp_path, command, inside, named):
    out, *_ = _imported(tmp_path, command, _leg(), inside)
    assert ("not read, and may change the dynamics" in out) == bool(named)
    assert named in out


def test_unknown_content_of_a_joint_is_named(tmp_path, command):
    leg = _leg(hip='<dynamics damping="1" stiffness="3"/>', knee="<spring/>")
    out, *_ = _imported(tmp_path, command, leg)
    assert "<spring> (line " in out
    assert "<dynamics stiffness> (line " in out


@pytest.mark.parametrize("seed", sampled(range(20), 6))
def test_joints_that_mimic_follow(seed):
    text = random_urdf(seed, mimics=True)
    imported = import_urdf(text)
    ours, pinocchio = Ours(imported), PinocchioUrdf(with_all_digits(text))
    assert torque_gap(ours, pinocchio) < 1e-11  # each joint by itself
    factors = _factors(text)
    for j in imported.robot.joints:
        if j.name not in factors:
            assert j.follows is None
            continue
        master, factor, offset = factors[j.name]
        ((k, share),) = j.shares
        assert imported.robot.joint(k).name == master
        assert float(share) == pytest.approx(factor)
        assert float(j.offset) == pytest.approx(offset, abs=1e-5)  # 1.5708 is pi/2
        assert not j.friction
        assert not j.rotor_inertia


@pytest.mark.skipif(
    "sr400" not in symgen.library(), reason="the kernels do not move joints that follow yet"
)
@pytest.mark.parametrize("seed", sampled(range(20), 6))
def test_torques_of_joints_that_mimic_reach_the_joint_that_they_follow(seed):
    text = random_urdf(seed, mimics=True)
    imported = import_urdf(text)
    ours, pinocchio = Ours(imported, free=False), PinocchioUrdf(with_all_digits(text))
    robot = imported.robot
    states = ours.states(4)
    tau = ours.torques(**states)
    column = {j.number: i for i, j in enumerate(robot.movable)}
    for i in range(4):
        full = [{}, {}, {}]
        for j in robot.moving:
            for target, x, constant in zip(full, states.values(), (j.offset, 0, 0), strict=True):
                own = sum(float(c) * x[i, column[k]] for k, c in j.shares)
                target[j.name] = own + float(constant)
        free = pinocchio.torques(*full)
        want = np.zeros(robot.n)
        for j in robot.moving:
            for k, c in j.shares:
                want[column[k]] += float(c) * free[j.name]
        assert np.abs(tau[i] - want).max() < 1e-11 * np.abs(want).max()


def _factors(text):
    """Follow the mimics of a URDF: joint to master, factor and offset."""
    mimic = {
        j.get("name"): j.find("mimic")
        for j in ET.fromstring(text.encode()).findall("joint")
        if j.find("mimic") is not None
    }
    out = {}
    for name in mimic:
        factor, offset, at = 1.0, 0.0, name
        while at in mimic:
            offset += factor * float(mimic[at].get("offset"))
            factor *= float(mimic[at].get("multiplier"))
            at = mimic[at].get("joint")
        out[name] = at, factor, offset
    return out


@pytest.mark.parametrize("seed", sampled(range(0, 20, 3), 3))
def test_writing_the_same_bodies_back_changes_no_torque_and_nothing_else(seed):
    text = random_urdf(seed).replace("<link", "<!-- a < remark --><link", 3)
    imported = import_urdf(text)
    values = dict(imported.parameters)
    bodies = []
    for j in imported.robot.joints:
        xx, xy, xz, yy, yz, zz, mx, my, mz, m = (
            values[f"{key}{j.number}"]
            for key in ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
        )
        c = np.array([mx, my, mz]) / (m or 1.0)
        about_origin = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        about_centre = about_origin - m * (c @ c * np.eye(3) - np.outer(c, c))
        bodies.append(Body(j.number, m, c, about_centre))
    new = updated_urdf(text, Dynamics(tuple(bodies)))
    assert _rest(new) == _rest(text)
    assert "do not determine link parameters" in new
    assert new.count("<!-- a < remark -->") == 3
    old_joints, new_joints = (
        [ET.tostring(j) for j in ET.fromstring(t.encode()).findall("joint")] for t in (text, new)
    )
    assert old_joints == new_joints
    again = dict(import_urdf(new).parameters)
    assert again.keys() == values.keys()
    assert all(math.isclose(again[k], v, abs_tol=1e-14) for k, v in values.items())
    assert torque_gap(Ours(imported), PinocchioUrdf(with_all_digits(new))) < 1e-11


def _rest(text: str) -> str:
    """All of a URDF but its <inertial> elements."""
    return re.sub(r"<inertial>.*?</inertial>", "", text, flags=re.DOTALL)


def test_only_the_links_that_are_named_change():
    link = (
        '<link name="{}"><inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" '
        'iyz="0" izz="1"/></inertial></link>'
    )
    text = f'<robot name="a">{link.format("base")}\n  {link.format("tip")}{joint("j")}</robot>'
    new = updated_urdf(text, Dynamics((Body(1, 3.0, np.array([0.1, 0.0, 0.0]), np.eye(3)),)))
    assert _rest(new) == _rest(text)
    base, tip = ET.fromstring(new).findall("link")
    assert base.find("inertial/mass").get("value") == "2"
    assert tip.find("inertial/mass").get("value") == "3.0"
    assert tip.find("inertial/origin").get("xyz") == "0.1 0.0 0.0"


@pytest.mark.parametrize("seed", sampled(range(10), 4))
def test_the_robot_toml_is_the_same_robot(seed):
    robot = import_urdf(random_urdf(seed, mimics=True)).robot
    assert parse_robot(robot_toml(robot)) == robot


def test_an_arm_of_right_angles_and_short_decimals_stays_exact():
    links = ("base", "a", "b", "tip", "tool")
    text = urdf(
        joint("lift", origin='xyz="0 0 0.333"', ends=("base", "a")),
        joint("bend", origin='xyz="0 0.1 0" rpy="-1.5708 0 0"', ends=("a", "b")),
        joint("roll", "continuous", ("b", "tip"), 'xyz="0.25 0 0" rpy="0 0 0.7854"', "1 0 0"),
        joint("hold", "fixed", ("tip", "tool"), 'xyz="0.1 0 0" rpy="0 1.57079632679 0"'),
        links=links,
    )
    imported = import_urdf(text)
    for j in imported.robot.joints:
        for key in ("gamma", "alpha", "theta"):
            assert (getattr(j, key) * 24 / sp.pi).is_Integer, (j, key)
        for key in ("b", "d", "r"):
            size = getattr(j, key)
            assert size == 0 or (size**2 * 10**4).is_Rational, (j, key)
    assert any("1.5708" in note for note in imported.notes)


@pytest.mark.parametrize(
    ("written", "meant"),
    [("1.5708", (1, 2)), ("1.5707", (1, 2)), ("-3.14159", (-1, 1)), ("0.7854", (1, 4)),
     ("1.570796327", (1, 2)), ("1.57079632679000", (1, 2)), ("0.2618", (1, 12)),
     ("4.71238898038", (3, 2)), ("0.130899694", (1, 24)), ("1.11759e-08", (0, 1)), ("0", (0, 1)),
     ("1.571", None), ("1.57", None), ("3.14", None), ("1.5706", None), ("0.1", None),
     ("1.57081", (1, 2)), ("1.57090", None), ("0.00019159", None), ("100.53096", None)],
)  # fmt: skip
def test_an_angle_near_a_fraction_of_pi_is_that_fraction(written, meant):
    want = None if meant is None else sp.Rational(*meant)
    assert fraction_of_pi(sp.Rational(written)) == want


@pytest.mark.parametrize(
    ("rpy", "axis"),
    [("1.570790 0 0", "0 0 1"), ("1.5707 0 0", "0.00002 0 1"), ("0 1.57081 0", "0 0 1"),
     ("0.613502 1.570800 2.184298", "0 0 1"), ("0 0 0.78539", "0.707105 0.707108 0"),
     ("0.523599 0 0", "0 0.866025 0.5")],
)  # fmt: skip
def test_rounded_digits_leave_axes_at_multiples_of_15_degrees(rpy, axis):
    turn = joint("b", ends=("a", "b"), origin=f'xyz="0 0.1 0.2" rpy="{rpy}"', axis=axis)
    after = joint("c", ends=("b", "c"), origin='xyz="0.3 0 0" rpy="0 0 0"', axis=axis)
    robot = import_urdf(urdf(joint("a", ends=("base", "a")), turn, after,
                             links=("base", "a", "b", "c"))).robot  # fmt: skip
    for j in robot.joints:
        for angle in (j.gamma, j.alpha, j.theta):
            assert (angle * 24 / sp.pi).is_Integer, j
    assert robot.joint(3).alpha == 0


@pytest.mark.parametrize(("after", "axis"), [("0 0 0.4", "0 0 1"), ("0 0 -0.3", "0 0 -1")])
def test_axes_that_coincide_need_no_angle_and_no_length_beside_those_of_a_chain(after, axis):
    turn = joint("b", ends=("a", "b"), origin=f'xyz="{after}"', axis=axis)
    robot = import_urdf(urdf(joint("a", ends=("base", "a")), turn, links=("base", "a", "b"))).robot
    second = robot.joint(2)
    assert (second.gamma, second.b, second.d) == (0, 0, 0)
    assert second.theta == 0


def test_movable_joints_keep_the_order_of_the_document_and_fixed_ones_come_last():
    text = urdf(
        joint("second", ends=("a", "b")),
        joint("stand", "fixed", ("base", "mount")),
        joint("first", ends=("mount", "a")),
        joint("other", ends=("mount", "c")),
        links=("c", "b", "a", "mount", "base"),
    )
    robot = import_urdf(text).robot
    assert [j.name for j in robot.joints] == ["first", "second", "other", "stand"]
    assert [j.antecedent for j in robot.joints] == [0, 1, 0, 0]


def test_a_leg_that_hangs_on_a_fixed_root_takes_gravity_along_the_root_axes():
    imported = import_urdf(urdf(joint("hip", axis="0 -1 0", origin='xyz="0 0 -0.2"')))
    assert imported.robot.gravity == (0, 0, sp.Rational(-981, 100))
    assert imported.parameters == ()


def test_limits_are_there_when_all_movable_joints_have_them():
    full = '<limit lower="-1" upper="2" velocity="3" effort="40"/>'
    part = '<limit lower="-1" upper="2" velocity="3" effort="0"/>'
    ends = (("base", "a"), ("a", "b"))
    names = ("base", "a", "b")

    def limits(*inside, kind="revolute"):
        joints = [joint(f"j{i}", kind, e, "", "0 0 1", x) for i, (e, x) in
                  enumerate(zip(ends, inside, strict=True))]  # fmt: skip
        return import_urdf(urdf(*joints, links=names)).robot.limits

    both = limits(full, full)
    assert both.position == ((-1.0, 2.0), (-1.0, 2.0))
    assert (both.velocity, both.torque) == ((3.0, 3.0), (40.0, 40.0))
    assert limits(full, part).torque is None
    assert limits(full, part).velocity == (3.0, 3.0)
    assert limits(full, "") is None
    assert limits(full, full, kind="continuous").position is None


def test_losses_of_the_file_are_friction_parameters():
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        "</inertial>"
    )
    text = urdf(joint("j", inside='<dynamics damping="0.7" friction="0.3"/>'), name="ur5-e")
    imported = import_urdf(
        text.replace('<link name="tip"/>', f'<link name="tip">{inertial}</link>')
    )
    values = dict(imported.parameters)
    assert (values["FV1"], values["FS1"], values["IA1"], values["ZZ1"]) == (0.7, 0.3, 0.0, 1.0)
    assert imported.robot.name == "ur5_e"
    assert any("ur5_e" in note for note in imported.notes)


@pytest.mark.parametrize(
    ("given", "name"),
    [("2 arms", "robot_2_arms"), ("", "robot"), ("math", "robot_math"), ("Ärm", "Arm"),
     ("x" * 100, "x" * 58)],
)  # fmt: skip
def test_every_robot_gets_a_name_that_c_accepts(given, name):
    assert import_urdf(urdf(joint("j"), name=given)).robot.name == name


def test_cad_inertias_are_parameters_of_the_robot_that_they_belong_to(tmp_path):
    path = tmp_path / "drawn.urdf"
    path.write_text(random_urdf(3))
    model = symgen.derive(symgen.read_robot(path), ("inverse_dynamics",))
    from symgen.identification.parameters import read_parameters

    X = read_parameters(path, model)
    rigid_body = Ours(import_urdf(path.read_text()))
    states = rigid_body.states(3)
    inverse = symgen.load(model)["inverse_dynamics"](*states.values(), X)
    assert np.allclose(inverse, rigid_body.torques(**states), rtol=1e-9, atol=1e-10)
    with pytest.raises(symgen.ParameterError, match="the frame of joint 1 is not that of"):
        read_parameters(path, symgen.derive(symgen.read_robot("planar2r")))
