"""MJCF in and out: MuJoCo moves the file, and what was written into it, as symgen says."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from support_urdf import Ours

import symgen
from symgen.errors import RobotError
from symgen.robot.fixed import with_fixed
from symgen.robot.foreign import read_imported

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
    pytest.importorskip("clarabel", reason="Clarabel is not installed")
    from symgen.identification.estimate import Estimate, Joint, ParameterEstimate, Residual
    from symgen.identification.parameters import read_parameters

    source = re.sub('<joint name="slide".*?/>', "", MJCF)
    arm = tmp_path / "arm.xml"
    arm.write_text(source)
    robot = with_fixed(read_imported(arm), ["finger=0.01"]).robot
    joints = tuple(replace(joint, rotor_inertia=False) for joint in robot.joints)
    robot = replace(robot, joints=joints)  # what is identified is in the links alone
    model = symgen.derive(robot)
    result = tmp_path / "result"
    result.mkdir()
    (result / "robot.toml").write_text(symgen.robot_toml(robot))
    X = 1.3 * read_parameters(arm, model)
    parameters = tuple(
        ParameterEstimate(p.name, p.expression, float(x), 0.01, p.unit)
        for p, x in zip(model.base.parameters, X, strict=True)
    )
    fit = Residual(0.02)
    estimate = Estimate(
        robot=robot.name, joints=(Joint(1, "N m"), Joint(2, "N m")), model="torque",
        method="wls", parameters=parameters, condition_number=3.0, train=fit, validation=fit,
        cutoff_hz=8.0, window_s=None, verdict="trusted", reasons=(),
        correlation=np.eye(len(X)),
    )  # fmt: skip
    (result / "estimate.json").write_text(json.dumps(estimate.to_json()))
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


def _rest(text: str) -> list[str]:
    """Words of an MJCF without its inertias and what symgen says of them."""
    without = re.sub("<!-- written by symgen.*?-->", "", text, flags=re.DOTALL)
    return re.sub("<inertial.*?/>", " ", without, flags=re.DOTALL).split()


REFUSED = {
    "a floating base": ('<joint name="shoulder" axis="0 1 0"', '<joint name="shoulder" type="ball"',
                        "it is ball"),
    "no MJCF": ("<worldbody>", "<worldbodies>", "MuJoCo refuses it"),
    "another zero": ('axis="1 0 0" pos', 'axis="1 0 0" ref="10" pos', "its ref is"),
    "an axis without a direction": ('axis="1 0 0" pos', 'axis="1e300 0 0" pos', "no direction"),
    "no gravity": ('gravity="0 0.5 -9.7"', 'gravity="0 0 0"', "gravity is zero"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_arm_is_refused_in_one_line(arm, case) -> None:
    old, new, says = REFUSED[case]
    text = MJCF.replace(old, new)
    if case == "a floating base":
        text = text.replace(' range="-110 110" frictionloss', " frictionloss")
    arm.write_text(text)
    with pytest.raises(RobotError, match=says) as caught:
        read_imported(arm)
    assert "\n" not in str(caught.value)


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
