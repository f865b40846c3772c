"""Whatever an MJCF contains: its torques are those of MuJoCo, or symgen names what is not read."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from support import sampled

import symgen
from symgen.errors import RobotError
from symgen.identification.parameters import read_parameters
from symgen.robot.toml_io import read_imported

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from oracles import parallelograms, random_mjcf  # noqa: E402

ARM = """<mujoco model="arm"><compiler angle="radian"/>{options}
  <worldbody>
    <body name="upper"><joint name="shoulder" axis="0 1 0" {shoulder}/>
      <inertial pos="0.25 0 0" mass="3" diaginertia="0.02 0.08 0.08"/>
      <body name="lower" pos="0.5 0 0"><joint name="elbow" axis="0 1 0" {elbow}/>
        <inertial pos="0.2 0 0" mass="1.8" diaginertia="0.01 0.03 0.03"/></body></body>
    {others}
  </worldbody>
  {sections}
</mujoco>
"""
MOTORS = (
    '<actuator><motor joint="shoulder" gear="100" armature="3e-5" damping="1e-4 2e-5 3e-6"/>'
    '<motor joint="elbow" gear="50" armature="4e-5"/></actuator>'
)
#: Content, and the parameters that it gives.
READ = {
    "motors": ({"shoulder": 'armature="0.15" damping="0.9"', "sections": MOTORS},
               {"IA1": 0.45, "FV1": 1.9, "IA2": 0.1, "FVN1": 0.2, "FVN1b": 0.03}),
    "damping of higher order": ({"shoulder": 'damping="0.5 0.9 0.4"'},
                                {"FV1": 0.5, "FVN1": 0.9, "FVN1b": 0.4}),
    "a spring of higher order": ({"elbow": 'stiffness="6 2.5 0.3" springref="0.2"'},
                                 {"C12": 6 - 1.0 + 0.036, "C32": 0.3}),
    "no damper": ({"shoulder": 'damping="0.5"', "sections": MOTORS,
                   "options": '<option><flag damper="disable"/></option>'}, {"FV1": 0.0}),
    "no spring": ({"shoulder": 'stiffness="5"',
                   "options": '<option><flag spring="disable"/></option>'}, {"FV1": 0.0}),
    "no friction loss": ({"shoulder": 'frictionloss="5"',
                          "options": '<option><flag frictionloss="disable"/></option>'},
                         {"FS1": 0.0}),
    "a follower": ({"elbow": 'armature="0.1" damping="0.4" frictionloss="0.2" stiffness="3"',
                    "sections": '<equality><joint joint1="elbow" joint2="shoulder" '
                                'polycoef="0.1 -0.5 0 0 0"/></equality>'},
                   {"IA1": 0.025, "FV1": 0.1, "FS1": 0.1, "K1": 0.75}),
}  # fmt: skip
EQUALITY = "<equality>{}</equality>"
REFUSED = {
    "no gravity": ({"options": '<option><flag gravity="disable"/></option>'}, "gravity is zero"),
    "a loop": ({"sections": EQUALITY.format('<connect name="rod" body1="upper" body2="lower" '
                                            'anchor="0 0 0.1"/>')}, "connect equality 'rod'"),
    "a weld": ({"sections": EQUALITY.format('<weld body1="other" body2="lower"/>'),
                "others": '<body name="other"><joint type="free"/><geom size="0.1"/></body>'},
               "weld equality"),
    "a curve": ({"sections": EQUALITY.format('<joint name="cam" joint1="elbow" joint2="shoulder" '
                                             'polycoef="0 1 0.2 0 0"/>')}, "joint equality 'cam'"),
    "a locked joint": ({"sections": EQUALITY.format('<joint joint1="elbow" polycoef="0.3"/>')},
                       'active="false"'),
}  # fmt: skip


LINKAGE = """<mujoco model="leg"><compiler angle="radian"/><worldbody><body name="thigh">
  <joint name="hip" axis="0 1 0"/><inertial pos="0 0 -0.1" mass="2" diaginertia=".02 .02 .01"/>
  <body name="crank"><joint name="crank" axis="0 1 0"/>
    <inertial pos="0.03 0 0" mass="0.3" diaginertia="0.001 0.001 0.001"/>
    <body name="rod" pos="0.06 0 0"><joint name="rod" axis="0 1 0"/>
      <inertial pos="0 0 -0.1" mass="0.4" diaginertia="0.003 0.003 0.001"/></body></body>
  <body name="shank" pos="0 0 -0.3"><joint name="knee" axis="0 1 0"/>
    <inertial pos="0 0 -0.1" mass="1.5" diaginertia="0.01 0.01 0.002"/></body>
  </body></worldbody>
  <equality><connect name="bar" body1="rod" body2="shank" anchor="0 0 {rod}"/></equality>
  <actuator>{motors}</actuator></mujoco>"""
MOTOR = '<motor joint="{}"/>'
#: Files of a linkage, and what their errors contain.
OPEN = {
    "a rod that is 1 cm short": ({"rod": -0.29}, ["connect equality 'bar' is off by 0.0"]),
    "no motor": ({"motors": MOTOR.format("hip")}, ["without an actuator", "'bar'"]),
    "two motors": ({"motors": MOTOR.format("crank") + MOTOR.format("knee")},
                   ["'bar' is off by", "as many actuators as free joints"]),
}  # fmt: skip


def written(tmp_path, **content: str):
    path = tmp_path / "arm.xml"
    slots = dict.fromkeys(("options", "shoulder", "elbow", "others", "sections"), "")
    path.write_text(ARM.format(**slots | content))
    return path


def torque_gap(path) -> float:
    """Largest difference of the torques from MuJoCo's, relative to the largest torque."""
    model = symgen.derive(read_imported(path).robot, ("inverse_dynamics",))
    evaluator = symgen.load(model, backend="casadi")
    q, qd, qdd = np.random.default_rng(2).uniform(-1, 1, (3, 6, model.robot.n))
    ours = evaluator.inverse_dynamics(q, qd, qdd, read_parameters(path, model))
    theirs = random_mjcf.torques(path.read_text(), model.robot.joint_names, q, qd, qdd)
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


@pytest.mark.parametrize("case", sampled(READ, 3, ["motors"]))
def test_motors_dampers_springs_flags_and_followers_are_read(tmp_path, case) -> None:
    content, wanted = READ[case]
    path = written(tmp_path, **content)
    values = dict(read_imported(path).parameters)
    found = {name: values[name] for name in wanted}
    assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    assert torque_gap(path) < 1e-9


def test_mujoco_may_be_older_than_a_flag(tmp_path, monkeypatch) -> None:
    """Up to 3.3.0, one flag switches springs and dampers off."""
    flags = mujoco.mjtDisableBit.__members__.items()
    older = {name: bit for name, bit in flags if not name.endswith(("SPRING", "DAMPER"))}
    monkeypatch.setattr(mujoco, "mjtDisableBit", SimpleNamespace(**older))
    values = dict(read_imported(written(tmp_path, shoulder='damping="0.5"')).parameters)
    assert values["FV1"] == 0.5


@pytest.mark.parametrize("case", REFUSED)
def test_what_binds_links_otherwise_is_refused_by_name(tmp_path, case) -> None:
    content, says = REFUSED[case]
    with pytest.raises(RobotError, match=says):
        read_imported(written(tmp_path, **content))


def test_what_is_not_read_is_named_with_its_share_of_the_torque(tmp_path) -> None:
    still = written(tmp_path)
    assert not any("not read" in note for note in read_imported(still).notes)
    windy = written(tmp_path, options='<option density="1000" viscosity="0.1"/>')
    notes = read_imported(windy).notes
    assert any("medium" in note for note in notes)
    assert any("% of the largest torque" in note for note in notes)


@pytest.mark.parametrize("seed", sampled(range(100, 140), 3))
def test_random_files_have_the_torques_of_mujoco(tmp_path, seed) -> None:
    text, named = random_mjcf.mjcf(seed)
    path = tmp_path / f"arm{seed}.xml"
    path.write_text(text)
    notes = " ".join(read_imported(path).notes)
    if named:
        assert all(word in notes for word in named)
    else:
        assert torque_gap(path) < 1e-9


@pytest.mark.parametrize(("motor", "follows"), [("crank", "knee"), ("knee", "crank")])
def test_the_joints_of_a_parallelogram_without_a_motor_follow(tmp_path, command, motor, follows):
    path, to = tmp_path / "leg.xml", tmp_path / "robot.toml"
    path.write_text(LINKAGE.format(rod=-0.3, motors=MOTOR.format("hip") + MOTOR.format(motor)))
    code, out, err = command("import", path, "--into", to)
    assert code == 0, err
    assert "actuator" not in out + err
    robot = symgen.read_robot(to)
    assert robot.joint_names == ["hip", motor]
    found = {joint.name: str(joint.follows) for joint in robot.joints if not joint.movable}
    assert found == {"rod": "-q2", follows: "q2"}


@pytest.mark.parametrize("case", OPEN)
def test_a_linkage_that_is_no_parallelogram_with_its_motors_is_refused(tmp_path, case) -> None:
    change, says = OPEN[case]
    path = tmp_path / "leg.xml"
    motors = MOTOR.format("hip") + MOTOR.format("crank")
    path.write_text(LINKAGE.format(**{"rod": -0.3, "motors": motors} | change))
    with pytest.raises(RobotError) as caught:
        read_imported(path)
    assert all(word in str(caught.value) for word in says)


def loop_gap(path, text: str) -> float:
    """Largest difference from the torques of MuJoCo's tree, projected on motions of the loop."""
    model = symgen.derive(read_imported(path).robot, ("inverse_dynamics",))
    arm = parallelograms.Closed(text, model.robot.joint_names)
    q, qd, qdd = np.random.default_rng(2).uniform(-0.3, 0.3, (3, 20, model.robot.n))
    q += arm.model.qpos0[arm.free]
    evaluator = symgen.load(model, backend="casadi")
    ours = evaluator.inverse_dynamics(q, qd, qdd, read_parameters(path, model))
    theirs = arm.torques(q, qd, qdd)
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


LAYOUTS = list(parallelograms.LAYOUTS)


@pytest.mark.parametrize("seed", sampled(range(15), 2))
def test_random_parallelograms_have_the_torques_of_mujoco(tmp_path, seed) -> None:
    text = parallelograms.mjcf(seed, LAYOUTS[seed % len(LAYOUTS)])
    path = tmp_path / "arm.xml"
    path.write_text(text)
    assert loop_gap(path, text) < 1e-9


def test_parallelograms_with_six_decimals_are_read(tmp_path) -> None:
    for seed, layout in enumerate(LAYOUTS):
        path = tmp_path / "arm.xml"
        path.write_text(parallelograms.mjcf(seed, layout, digits=6))
        robot = read_imported(path).robot
        passive = {joint.name for joint in robot.joints if joint.follows is not None}
        assert passive == parallelograms.LAYOUTS[layout][3]
        assert {abs(c) for joint in robot.moving for _, c in joint.shares} == {1}


@pytest.mark.parametrize("miss", parallelograms.MISSES)
def test_near_misses_of_parallelograms_are_refused_by_name(tmp_path, miss) -> None:
    for seed, layout in enumerate(LAYOUTS):
        path = tmp_path / "arm.xml"
        path.write_text(parallelograms.mjcf(seed, layout, miss))
        with pytest.raises(RobotError, match="the connect equality 'bar' is off by"):
            read_imported(path)


def test_losses_of_a_joint_that_follows_two_are_refused(tmp_path) -> None:
    text = parallelograms.mjcf(1, "palletizer")
    path = tmp_path / "arm.xml"
    path.write_text(text.replace('<joint name="rod"', '<joint name="rod" damping="0.1"'))
    with pytest.raises(RobotError, match="joint 'rod' follows two joints"):
        read_imported(path)


#: The crank of a palletising arm lifts the forearm; two parallelograms keep the flange level.
PALLETIZER = """<mujoco model="palletizer"><compiler angle="radian"/>
<default><joint axis="0 1 0"/></default><worldbody>
<body name="turn"><joint name="turn" axis="0 0 1"/>{inertia}
  <body name="upper"><joint name="upper"/>{inertia}
    <body name="triangle" pos="0 0 0.6"><joint name="triangle"/>{inertia}
      <body name="bar2" pos="0.08 0 0.12"><joint name="bar2"/>{inertia}</body></body>
    <body name="forearm" pos="0 0 0.6"><joint name="forearm"/>{inertia}
      <body name="flange" pos="0.5 0 0"><joint name="flange"/>{inertia}</body></body></body>
  <body name="crank"><joint name="crank"/>{inertia}
    <body name="rod" pos="-0.2 0 0"><joint name="rod"/>{inertia}</body></body>
  <body name="bar1" pos="-0.1 0 0.15"><joint name="bar1"/>{inertia}</body></body></worldbody>
<equality><connect body1="rod" body2="forearm" anchor="0 0 0.6"/>
  <connect body1="bar1" body2="triangle" anchor="0 0 0.6"/>
  <connect body1="flange" body2="bar2" anchor="0.08 0 0.12"/></equality>
<actuator><motor joint="turn"/><motor joint="upper"/><motor joint="crank"/></actuator></mujoco>"""


def test_a_chain_of_parallelograms_keeps_the_flange_level(tmp_path) -> None:
    inertia = '<inertial pos="0.1 0.02 0.05" mass="1" diaginertia="0.01 0.02 0.02"/>'
    path = tmp_path / "arm.xml"
    path.write_text(PALLETIZER.format(inertia=inertia))
    model = symgen.derive(read_imported(path).robot, ("inverse_dynamics",))
    robot = model.robot
    assert robot.joint_names == ["turn", "upper", "crank"]
    follows = {joint.name: str(joint.follows) for joint in robot.joints if not joint.movable}
    assert follows["forearm"] == "-q2 + q3"
    assert follows["flange"] == "-q3"
    arm = parallelograms.Closed(path.read_text(), robot.joint_names)
    q, qd, qdd = np.random.default_rng(2).uniform(-0.3, 0.3, (3, 4, 3))
    ours = symgen.load(model, backend="casadi").inverse_dynamics(
        q, qd, qdd, read_parameters(path, model)
    )
    theirs = arm.torques(q, qd, qdd)
    assert np.abs(ours - theirs).max() < 1e-9 * np.abs(theirs).max()
