"""export to MJCF and URDF: MuJoCo moves the file as symgen moves the model, and reads it again."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from support import sampled
from support_estimate import write_estimate

import symgen
from symgen.identification.parameters import base_values, cad_parameters, read_parameters
from symgen.robot.declared_effects import of_library
from symgen.robot.effect import definitions
from symgen.robot.tables import Coupling
from symgen.robot.toml_io import read_imported

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

#: Degrees, classes, single quotes, a '>' in a name, a joint away from its body's origin.
ARM = """<mujoco model="arm">
  <!-- an arm -->
  <compiler angle="degree"/>
  <option gravity="0 0 -9.81"/>
  <default>
    <joint damping="0.3"/>
    <default class="heavy"><joint armature="0.2" frictionloss="0.5"/></default>
  </default>
  <worldbody>
    <body name="upper" pos="0 0 0.3">
      <joint name='a > b' axis="0 1 0" class="heavy" range="-120 120"/>
      <inertial pos="0.1 0.02 0.2" mass="2" fullinertia="0.05 0.06 0.02 0.001 0 0"/>
      <body name="lower" pos="0 0.05 0.4" euler="10 20 0">
        <joint name="elbow" axis="1 0 0" pos="0.02 0 0.01"/>
        <inertial pos="0 0.01 0.15" mass="1.2" diaginertia="0.02 0.02 0.005"/>
        <body name="wrist" pos="0 0 0.3">
          <joint name="wrist" axis="0 1 0.2"/>
          <inertial pos="0.01 0.03 0.05" mass="0.6" diaginertia="0.004 0.003 0.002"/>
          <geom type="sphere" size="0.05" pos="0 0 0.1"/>
          <body name="tool" pos="0 0 0.1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
TWO = """<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.1 0.02 0.2"/><mass value="2.0"/>
    <inertia ixx="0.05" ixy="0.001" ixz="0" iyy="0.06" iyz="0" izz="0.02"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 0.15" rpy="0.1 0 0"/><mass value="1.2"/>
    <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.005"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0 0.4 0"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0.05 0.4"/><axis xyz="1 0 0"/></joint>
</robot>
"""
VALUES = {
    "FS1": 0.7, "FV1": 0.4, "OF1": 0.2, "FS2": 0.3, "FV2": 0.5, "OF2": -1.3, "K2": 7.0,
    "FS3": 0.1, "FV3": 0.2, "IAM3": 0.05, "FVM3": 0.3, "FSM3": 0.4, "IA1": 0.33, "IA2": 0.1,
    "IA3": 0.02,
}  # fmt: skip


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """A folder with arm.xml, and an estimate of it with a spring, offsets and a coupled drive."""
    folder = tmp_path_factory.mktemp("mjcf")
    path = folder / "arm.xml"
    path.write_text(ARM)
    found = read_imported(path)
    joints = (
        replace(j, friction=("coulomb", "viscous", "offset")) if j.number < 3 else j
        for j in found.robot.joints
    )
    spring = of_library(definitions()["gravity_spring"], 2, 0, {}, {})
    robot = replace(
        found.robot, joints=tuple(joints), effects=(spring,),
        couplings=(Coupling((2, 3), sp.Rational(-3, 2)),),
    )  # fmt: skip
    model = symgen.derive(robot, ("inverse_dynamics",))
    X = base_values({**dict(found.parameters), **VALUES}, model, "values")
    write_estimate(folder / "result", model, X)
    return folder, model, X


def states(count: int, n: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-2, 2, (count, 3, n))


def inverse(model, data, q, qd, qdd) -> np.ndarray:
    """Torque of the motors in MuJoCo."""
    data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
    mujoco.mj_inverse(model, data)
    return data.qfrc_inverse.copy()


def without_offset(model: symgen.Model, X: np.ndarray) -> np.ndarray:
    """What an MJCF holds of X: all but the offset of joint 1, which has no spring."""
    held = X.copy()
    held[model.base.names.index("OF1")] = 0.0
    return held


def test_smooth_torques_are_those_of_the_model(arm, tmp_path, command) -> None:
    folder, model, X = arm
    to = tmp_path / "out.xml"
    code, out, err = command("export", folder / "result", "--from", folder / "arm.xml", "--to", to)
    assert code == 0, err
    assert "the format cannot hold OF1 = 0.2 N m\n" in out
    made = mujoco.MjModel.from_xml_path(str(to))
    made.dof_frictionloss[:], made.tendon_frictionloss[:] = 0, 0
    smooth = X.copy()
    for name in ("FS1", "FS2", "FS3", "FSM3", "OF1"):
        smooth[model.base.names.index(name)] = 0.0
    evaluator, data = symgen.load(model), mujoco.MjData(made)
    q, qd, qdd = np.moveaxis(states(1000, 3), 1, 0)
    ours = evaluator.inverse_dynamics(q, qd, qdd, smooth)
    theirs = [inverse(made, data, *row) for row in zip(q, qd, qdd, strict=True)]
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-10)


def test_friction_that_slides_is_that_of_the_model(arm, tmp_path, command) -> None:
    folder, model, X = arm
    to = tmp_path / "out.xml"
    command("export", folder / "result", "--from", folder / "arm.xml", "--to", to)
    made = mujoco.MjModel.from_xml_path(str(to))
    evaluator, data = symgen.load(model), mujoco.MjData(made)
    q, qd, _ = np.moveaxis(states(200, 3, 1), 1, 0)
    qd = np.sign(qd) * (1 + np.abs(qd))
    zero = np.zeros_like(q)
    ours = evaluator.inverse_dynamics(q, qd, zero, without_offset(model, X))
    theirs = [inverse(made, data, *row) for row in zip(q, qd, zero, strict=True)]
    sliding = np.abs(qd[:, 1] - 1.5 * qd[:, 2]) > 1  # the coupled drive, too
    assert sliding.sum() > 100
    np.testing.assert_allclose(np.array(theirs)[sliding], ours[sliding], rtol=0, atol=1e-10)


def creep(text: str) -> float:
    """Speed after 0.2 s of joints held up with half of their friction missing, rad/s."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    data.qfrc_applied[:] = data.qfrc_bias - data.qfrc_passive + model.dof_frictionloss / 2
    mujoco.mj_step(model, data, 100)
    return float(np.abs(data.qvel).max())


def test_joints_stick_unless_the_file_has_softness_of_its_own(arm, tmp_path, command) -> None:
    folder, *_ = arm
    added = ' solreffriction="0.004 1" solimpfriction="0.99 0.99 0.001"'
    kept = {
        "own.xml": ('damping="0.3"', 'damping="0.3" solreffriction="0.01 1"'),
        "unsafe.xml": ("<default>", '<option><flag refsafe="disable"/></option><default>'),
    }
    for name, (old, new) in {"arm.xml": ("", ""), **kept}.items():
        source, to = tmp_path / name, tmp_path / f"out_{name}"
        source.write_text(ARM.replace(old, new))
        code, _, err = command("export", folder / "result", "--from", source, "--to", to)
        assert code == 0, err
        text = to.read_text()
        assert text.count(added) == (0 if name in kept else 3)
        if name not in kept:  # R / b of the soft constraint: 0.111 x 9.5 ms to 0.0101 x 2 ms
            assert creep(text) < creep(text.replace(added, "")) / 20


def test_what_is_written_is_read_again(arm, tmp_path, command) -> None:
    folder, model, X = arm
    to = tmp_path / "out.xml"
    export = ["export", folder / "result", "--from", folder / "arm.xml", "--to", to]
    assert command(*export)[0] == 0
    held = without_offset(model, X)
    np.testing.assert_allclose(read_parameters(to, model), held, rtol=1e-9, atol=1e-11)
    again = read_imported(to).robot
    assert [e.name for e in again.effects] == ["gravity_spring"]
    assert [(c.first, c.second, float(c.ratio)) for c in again.couplings] == [(2, 3, -1.5)]
    # Written into what it wrote before, nothing stands twice.
    code, _, err = command("export", folder / "result", "--from", to, "--to", to)
    assert code == 0, err
    np.testing.assert_allclose(read_parameters(to, model), held, rtol=1e-9, atol=1e-11)
    text = to.read_text()
    assert text.count("<fixed") == text.count(", digest ") == 1
    assert "<!-- an arm -->" in text
    assert 'range="-120 120"' in text
    assert '<body name="tool" pos="0 0 0.1"/>' in text  # a frame stays a frame


def test_a_frame_with_geometry_does_not_weigh_in_mujoco(tmp_path, command) -> None:
    """MuJoCo gives the geometry of a URDF link without <inertial> the density of water."""
    path, to = tmp_path / "two.urdf", tmp_path / "out.urdf"
    tool = """<link name="tool"><collision><geometry><box size="0.1 0.1 0.1"/></geometry>
      </collision></link><joint name="flange" type="fixed"><parent link="lower"/>
      <child link="tool"/></joint>"""
    path.write_text(TWO.replace("</robot>", f"{tool}</robot>"))
    found = read_imported(path)
    model = symgen.derive(found.robot, ("inverse_dynamics",))
    X = base_values(dict(found.parameters), model, "values")
    result = write_estimate(tmp_path / "result", model, X)
    code, _, err = command("export", result, "--from", path, "--to", to)
    assert code == 0, err
    q, qd, qdd = np.moveaxis(states(20, 2), 1, 0)
    ours = symgen.load(model).inverse_dynamics(q, qd, qdd, read_parameters(to, model))
    made = mujoco.MjModel.from_xml_path(str(to))
    data = mujoco.MjData(made)
    theirs = [inverse(made, data, *row) for row in zip(q, qd, qdd, strict=True)]
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-6 * np.abs(ours).max())


def test_a_joint_without_a_spring_gets_none_and_no_inertia_is_a_rounding_error(
    arm, tmp_path, command
) -> None:
    folder, *_ = arm
    sprung = tmp_path / "sprung.xml"
    sprung.write_text(ARM.replace('name="wrist" axis', 'name="wrist" stiffness="3" axis'))
    for source, joints in ((folder / "arm.xml", {"elbow"}), (sprung, {"elbow", "wrist"})):
        to = tmp_path / f"out_{source.name}"
        code, _, err = command("export", folder / "result", "--from", source, "--to", to)
        assert code == 0, err
        text = to.read_text()
        sprung_joints = re.findall(r"<joint name=.(\w+).[^>]*stiffness=", text)
        assert set(sprung_joints) == joints
        for entries in re.findall('fullinertia="(.*?)"', text):
            sizes = np.abs(np.array(entries.split(), dtype=float))
            assert not ((sizes > 0) & (sizes < 1e-12 * sizes.max())).any()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('angle="degree"', 'angle="degree" settotalmass="9"'),
        ('angle="degree"', 'angle="degree" boundinertia="0.1"'),
        ('name="elbow"', 'name="elbow" springdamper="1 0.5"'),
        ('joint damping="0.3"', 'joint damping="0.3" springdamper="1 0.5"'),
    ],
)
def test_what_changes_the_written_values_is_refused(arm, tmp_path, command, old, new) -> None:
    folder, *_ = arm
    path = tmp_path / "arm.xml"
    path.write_text(ARM.replace(old, new))
    to = tmp_path / "to.xml"
    code, _, err = command("export", folder / "result", "--from", path, "--to", to)
    assert code == 2
    assert "arm.xml" in err
    assert not to.exists()


@pytest.mark.parametrize("place", ["arm.xml", "arm.urdf"])
def test_a_payload_is_part_of_its_link(arm, tmp_path, command, place) -> None:
    folder, *_ = arm
    source = folder / place
    if place == "arm.urdf":
        source = tmp_path / place
        source.write_text(TWO)
    found = read_imported(source)
    robot = replace(found.robot, payload=2)
    model = symgen.derive(robot, ("inverse_dynamics",))
    load = {"XXL": 0.03, "XYL": 0.0, "XZL": 0.0, "YYL": 0.03, "YZL": 0.0, "ZZL": 0.01,
            "MXL": 0.02, "MYL": 0.05, "MZL": 0.1, "ML": 0.9}  # fmt: skip
    X = base_values({**dict(found.parameters), **load}, model, "values")
    result, to = write_estimate(tmp_path / "result", model, X), tmp_path / f"out{source.suffix}"
    code, _, err = command("export", result, "--from", source, "--to", to)
    assert code == 0, err
    plain = symgen.derive(replace(robot, payload=None))  # of which the payload is part of a link
    np.testing.assert_allclose(read_parameters(to, plain), X, rtol=1e-9, atol=1e-11)


def test_gravcomp_that_carries_weight_of_the_motors_is_refused(arm, tmp_path, command) -> None:
    folder, model, X = arm
    path, to = tmp_path / "arm.xml", tmp_path / "out.xml"
    text = ARM.replace('name="lower"', 'name="lower" gravcomp="0.7"')
    path.write_text(text)
    code, _, err = command("export", folder / "result", "--from", path, "--to", to)
    assert code == 2
    assert "gravcomp" in err
    assert not to.exists()
    # MuJoCo counts it as torque of the actuators: it may stay.
    path.write_text(text.replace("<joint ", '<joint actuatorgravcomp="true" '))
    code, _, err = command("export", folder / "result", "--from", path, "--to", to)
    assert code == 0, err
    made = mujoco.MjModel.from_xml_path(str(to))
    data, rest = mujoco.MjData(made), np.zeros(3)
    made.dof_frictionloss[:], made.tendon_frictionloss[:] = 0, 0
    q = states(20, 3)[:, 0]
    ours = symgen.load(model).inverse_dynamics(q, 0 * q, 0 * q, without_offset(model, X))
    theirs = [inverse(made, data, row, rest, rest) for row in q]
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-10)


@pytest.mark.rounding
def test_links_are_the_files_own_where_they_give_X(arm) -> None:
    folder, *_ = arm
    found = read_imported(folder / "arm.xml")
    model = symgen.derive(found.robot)
    prior = cad_parameters(folder / "arm.xml", model)
    X = base_values(prior, model, "arm.xml")
    links = symgen.link_parameters(model, X, prior=prior).values
    # The divergence, about 4 a link, is least to 1e-10 of itself, and |dP|^2/2 near its least.
    off = np.sqrt(2 * 1e-10 * 4 * len(found.robot.joints))
    size = dict.fromkeys((p.unit for p in model.base.standard), 0.0)
    for p in model.base.standard:
        size[p.unit] = max(size[p.unit], abs(prior[p.name]))
    for p in model.base.standard:
        assert abs(links[p.name] - prior[p.name]) < 2 * off * size[p.unit], p.name
    # A change of X moves them in proportion.
    step = 1e-2 * X * np.random.default_rng(2).uniform(-1, 1, len(X))
    moved = [
        symgen.link_parameters(model, X + k * step, prior=prior).values["M2"] - prior["M2"]
        for k in (1, 2)
    ]
    assert moved[1] == pytest.approx(2 * moved[0], rel=0.02, abs=3 * off * prior["M2"])


ROCK = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.mark.parametrize(
    ("settings", "mesh"),
    sampled(
        [
            ('<compiler angle="degree"/>', "parts/rock.obj"),
            ("", "parts/rock.obj"),
            ('<compiler angle="degree" meshdir="parts"/>', "rock.obj"),
            ('<compiler assetdir="parts"/>', "rock.obj"),
        ],
        0,
        always=[("", "parts/rock.obj"), ('<compiler assetdir="parts"/>', "rock.obj")],
    ),
)
def test_meshes_are_found_from_another_folder(arm, tmp_path, command, settings, mesh) -> None:
    folder, *_ = arm
    ball = '<geom type="sphere" size="0.05" pos="0 0 0.1"/>'
    text = ARM.replace('<compiler angle="degree"/>', f'{settings}<include file="more/rocks.xml"/>')
    text = text.replace(ball, '<geom type="mesh" mesh="rock" contype="0"/>')
    text = text.replace(
        "<worldbody>", f'<asset><mesh name="rock" file="{mesh}"/></asset><worldbody>'
    )
    again = f'<mujoco><asset><mesh name="again" file="{mesh}"/></asset></mujoco>'
    source = tmp_path / "arm.xml"
    for name, content in (("arm.xml", text), ("parts/rock.obj", ROCK), ("more/rocks.xml", again)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content)
    export = ["export", folder / "result", "--from", source]
    for to, made in (("a & b/c/out.xml", "a & b/c/out.xml"), ("many", "many/arm_0.xml")):
        more = ["--samples", "2"] if to == "many" else []
        code, _, err = command(*export, "--to", tmp_path / to, *more)
        assert code == 0, err
        assert mujoco.MjModel.from_xml_path(str(tmp_path / made)).nmesh == 2
    assert command(*export, "--to", tmp_path / "out.xml")[0] == 0
    assert settings in (tmp_path / "out.xml").read_text()


@pytest.mark.slow
def test_a_file_from_a_log_of_mujoco_moves_as_the_log(tmp_path, command) -> None:
    """Friction and armature are unknown; the torque error is taken in MuJoCo, from the file."""
    from scipy.signal import butter, filtfilt

    path = tmp_path / "arm.xml"
    path.write_text(ARM.replace(' armature="0.2" frictionloss="0.5"', ""))
    real = mujoco.MjModel.from_xml_path(str(path))
    real.dof_armature[:], real.dof_frictionloss[:] = (0.4, 0.2, 0.05), (1.1, 0.8, 0.2)
    real.dof_damping.reshape(3, -1)[:, 0] = (0.9, 0.6, 0.25)
    real.opt.timestep = 5e-4
    logs = {}
    for name, seed, seconds in (("train", 1, 20), ("test", 2, 10)):
        rng = np.random.default_rng(seed)
        a, w = rng.uniform(0.1, 0.4, (3, 4)), rng.uniform(0.6, 5.0, (3, 4))
        data, rows = mujoco.MjData(real), []
        for k in range(int(seconds / 5e-4)):
            t = 5e-4 * k
            want = np.sum(a * np.sin(w * t), axis=1)
            speed = np.sum(a * w * np.cos(w * t), axis=1)
            if k == 0:
                data.qvel[:] = speed
            data.qfrc_applied[:] = (400, 250, 60) * (want - data.qpos)
            data.qfrc_applied[:] += (40, 25, 5) * (speed - data.qvel)
            if k % 8 == 0:
                rows.append([t, *data.qpos, *data.qvel, *data.qfrc_applied])
            mujoco.mj_step(real, data)
        logs[name] = np.array(rows)
        columns = [f"{c}{j}" for c in ("q", "qd", "tau") for j in (1, 2, 3)]
        np.savetxt(tmp_path / f"{name}.csv", rows, delimiter=",", comments="",
                   header=",".join(["t", *columns]))  # fmt: skip
    train, test, out = (tmp_path / name for name in ("train.csv", "test.csv", "result"))
    code, _, err = command("identify", path, train, "--validation", test, "--into", out)
    assert code == 0, err
    to = tmp_path / "identified.xml"
    code, printed, err = command("export", out, "--from", path, "--to", to, "--log", test)
    assert code == 0, err
    file, estimate = map(
        float, re.search(r"torque error on .*: (\S+) %; the estimate (\S+) %", printed).groups()
    )
    assert file <= 1.1 * estimate
    # The same in MuJoCo, from the file alone, with SciPy's filters.
    t, q, qd, tau = np.split(logs["test"], [1, 4, 7], axis=1)
    low = butter(4, 2 * 10 * 4e-3)
    qdd = np.gradient(filtfilt(*low, qd, axis=0), 4e-3, axis=0)
    errors = {}
    for name, used in (("before", path), ("after", to)):
        model = mujoco.MjModel.from_xml_path(str(used))
        data = mujoco.MjData(model)
        torque = [inverse(model, data, *row) for row in zip(q, qd, qdd, strict=True)]
        residual = filtfilt(*butter(4, 2 * 2 * 4e-3), tau - torque, axis=0)
        moves = np.all(np.abs(qd) > 0.1, axis=1)
        errors[name] = np.linalg.norm(residual[moves]) / np.linalg.norm(tau[moves])
    assert errors["after"] < 0.1 * errors["before"]
    robot = symgen.read_robot(out / "robot.toml")
    evaluator = symgen.load(symgen.derive(robot, ("inverse_dynamics",)))
    X = symgen.read_estimate(out).X
    own = filtfilt(
        *butter(4, 2 * 2 * 4e-3), tau - evaluator.inverse_dynamics(q, qd, qdd, X), axis=0
    )
    ours = np.linalg.norm(own[moves]) / np.linalg.norm(tau[moves])
    print(f"torque error away from rest: {100 * errors['before']:.3g} % before, "
          f"{100 * errors['after']:.3g} % in MuJoCo, {100 * ours:.3g} % of the model")  # fmt: skip
    assert errors["after"] <= 1.1 * ours
    # Moved by the measured torque, the identified file follows the log, and the other does not.
    into = tmp_path / "simulated"
    code, printed, err = command("compare-sim", path, to, test, "--into", into)
    assert code == 0, err
    found = json.loads((into / "simulation.json").read_text())
    assert found["windows"] >= 5
    old, new = ([h["position_error"] for h in f["horizons"]] for f in found["files"])
    assert [h["seconds"] for h in found["files"][0]["horizons"]] == [0.2, 0.5, 1.0]
    assert all(b < 0.2 * a for a, b in zip(old, new, strict=True)), printed
    assert "identified.xml" in (into / "report.html").read_text()
    assert max(new) < 0.1
    held = tmp_path / "held.toml"
    command("import", to, "--into", held)
    gains = "[controller]\nkp = [400, 250, 60]\nkd = [40, 25, 5]\n"
    held.write_text(held.read_text() + gains)
    code, _, err = command("compare-sim", to, test, "--robot", held, "--into", tmp_path / "held")
    assert code == 0, err
    held = json.loads((tmp_path / "held" / "simulation.json").read_text())
    assert held["files"][0]["horizons"][-1]["position_error"] < 0.5 * new[-1]


def swinging(folder: Path) -> Path:
    """A log of a joint about the vertical with 0.5 kg m2."""
    t = np.arange(0, 4, 4e-3)
    rows = [t, 0.3 * np.sin(4 * t), 1.2 * np.cos(4 * t), -2.4 * np.sin(4 * t)]
    head = "t,q1,qd1,tau1"
    np.savetxt(folder / "log.csv", np.column_stack(rows), "%.17g", ",", header=head, comments="")
    return folder / "log.csv"


#: A joint about the vertical with 0.5 kg m2, and what its file may say of that instead.
TURNTABLE = """<mujoco model="table"><worldbody><body name="table"><joint name="turn" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="1" diaginertia="1 1 {}"/></body></worldbody></mujoco>"""


def test_a_simulation_that_runs_away_counts_no_less_than_one_that_runs_far(
    tmp_path, command
) -> None:
    """The lighter the file, the larger its error: up to a state that MuJoCo calls not finite."""
    log = swinging(tmp_path)
    files = []
    for izz in (0.5, 0.1, 0.02, 1e-3, 1e-9, 1e-14):
        files.append(tmp_path / f"{izz:g}.xml")
        files[-1].write_text(TURNTABLE.format(izz))
    into = tmp_path / "simulated"
    code, _, err = command("compare-sim", *files, log, "--into", into)
    assert code == 0, err
    found = json.loads((into / "simulation.json").read_text())
    errors = [f["horizons"][-1]["position_error"] for f in found["files"]]
    diverged = [f["diverged"] for f in found["files"]]
    assert errors[0] < 0.01
    assert errors == sorted(errors)
    assert diverged == sorted(diverged)
    assert diverged[:2] == [0, 0]
    assert diverged[-1] == found["windows"]
    (turn,) = found["files"][-1]["horizons"][-1]["per_joint"]
    assert turn == pytest.approx(10 * 0.6, rel=0.01)  # ten times the motion in the log


@pytest.mark.parametrize("rotor", [0.02, 0.0])
def test_a_urdf_in_mujoco_lacks_its_rotor_inertia(tmp_path, command, rotor: float) -> None:
    log, path = swinging(tmp_path), tmp_path / "turn.urdf"
    path.write_text(f"""<robot name="turn">
  <link name="base"/><link name="table"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="table"/>
    <axis xyz="0 0 1"/><dynamics armature="{rotor}"/></joint>
</robot>""")
    code, out, err = command("compare-sim", path, log, "--into", tmp_path / "out")
    assert code == 0, err
    assert ("note: MuJoCo ignores the rotor inertia of turn.urdf" in out) == (rotor > 0)


def test_a_urdf_that_runs_away_in_mujoco_leaves_no_log_of_warnings(
    tmp_path, command, monkeypatch
) -> None:
    """By itself MuJoCo prints that the simulation is unstable, and writes MUJOCO_LOG.TXT."""
    log, path = swinging(tmp_path), tmp_path / "turn.urdf"
    path.write_text("""<robot name="turn">
  <link name="base"/><link name="table"><inertial><mass value="1e-14"/>
    <inertia ixx="1e-14" iyy="1e-14" izz="1e-14" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="table"/>
    <axis xyz="0 0 1"/></joint>
</robot>""")
    monkeypatch.chdir(tmp_path)
    code, _, err = command("compare-sim", path, log, "--into", tmp_path / "out")
    assert code == 0, err
    found = json.loads((tmp_path / "out" / "simulation.json").read_text())
    assert found["files"][0]["diverged"] == found["windows"]
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()


@pytest.mark.parametrize("case", ["right", "older", "geometry"])
def test_a_urdf_has_its_own_inertias_in_mujoco(tmp_path, command, monkeypatch, case: str) -> None:
    """MuJoCo before 4.0 loses the orientation of an inertial frame."""
    log, path, other = swinging(tmp_path), tmp_path / "turn.urdf", tmp_path / "other.urdf"
    box = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    text = f"""<robot name="turn">
  <link name="base"/><link name="table"><inertial><origin xyz="0.1 0 0" rpy="0 0.6 0"/>
    <mass value="1"/><inertia ixx="0.1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool">{box if case == "geometry" else ""}</link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="table"/>
    <axis xyz="0 0 1"/><dynamics damping="2"/></joint>
  <link name="finger"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="follows" type="continuous"><parent link="table"/><child link="finger"/>
    <axis xyz="1 0 0"/><mimic joint="turn"/><dynamics damping="2"/></joint>
  <joint name="flange" type="fixed"><parent link="table"/><child link="tool"/>
    <origin xyz="0.3 0 0"/></joint>
</robot>"""
    path.write_text(text)
    other.write_text(text.replace("0.6", "0"))
    if case == "older":
        load = mujoco.MjModel.from_xml_path
        monkeypatch.setattr(mujoco, "__version__", "3.3.7")
        monkeypatch.setattr(
            mujoco, "MjModel", SimpleNamespace(from_xml_path=lambda _: load(str(other)))
        )
    code, out, err = command("compare-sim", path, log, "--into", tmp_path / "out")
    if case == "older":
        assert code == 2
        assert "MuJoCo 3.3.7 has other inertias than turn.urdf" in err
        assert "accepted: MuJoCo 4.0 or later" in err
        return
    assert code == 0, err
    assert ("has other inertias than turn.urdf" in out) == (case == "geometry")
    assert ("the mass of their geometry" in out) == (case == "geometry")


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (["arm.xml"], "one or more .xml or .urdf files, then one or more logs"),
        (["none.xml", "log.csv"], "no such file"),
        (["arm.xml", "other.xml", "log.csv"], "there is no joint"),
        (
            ["arm.xml", "short.csv"],
            "symgen import arm.xml --fix wrist --into robot.toml, then --robot robot.toml",
        ),
    ],
)
def test_what_cannot_be_compared_is_refused(tmp_path, command, monkeypatch, given, says) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.xml").write_text(ARM)
    Path("other.xml").write_text(ARM.replace("elbow", "knee"))
    Path("gains.toml").write_text("[controller]\nkp = [1, 2]\nkd = [1, 2]\n")
    rows = np.column_stack([np.arange(2000) / 500, np.random.default_rng(0).normal(size=(2000, 6))])
    np.savetxt("log.csv", rows, delimiter=",", header="t,q1,q2,q3,tau1,tau2,tau3", comments="")
    names = [f"{joint}_{what}" for what in ("pos", "torque") for joint in ("a > b", "elbow")]
    np.savetxt("short.csv", rows[:, :5], delimiter=",", header=",".join(["t", *names]), comments="")
    code, _, err = command("compare-sim", *given, "--into", "out")
    assert code == 2
    assert says in err
    assert not Path("out").exists()
