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
from oracles import random_mjcf  # noqa: E402

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
                       "--fix"),
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
