"""Torques in another unit: the robot file states the size of torques by its masses and limits."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import symgen

G = 9.81
#: Masses, and distances of their centres from the joint, of a vertical arm of two links.
MASSES, CENTRES, LENGTH = (4.0, 2.0), (0.25, 0.2), 0.5
EFFORT = 120


def urdf(masses=MASSES, effort=EFFORT, rail=False) -> str:
    """Return the arm as a URDF; on a vertical rail if `rail`."""
    inertia = '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>'
    out = ['<robot name="arm"><link name="base"/>']
    kinds = [("rail", "prismatic", "0 0 1", 8.0, 0.0)] if rail else []
    kinds += [
        (name, "revolute", "0 1 0", mass, centre)
        for name, mass, centre in zip(("lift", "elbow"), masses, CENTRES, strict=True)
    ]
    before = "base"
    for name, kind, axis, mass, centre in kinds:
        out.append(
            f'<link name="{name}_link"><inertial><origin xyz="{centre} 0 0"/>'
            f'<mass value="{mass}"/>{inertia}</inertial></link>'
            f'<joint name="{name}" type="{kind}"><parent link="{before}"/>'
            f'<child link="{name}_link"/><axis xyz="{axis}"/>'
            f'<origin xyz="{LENGTH if name == "elbow" else 0} 0 0"/>'
            f'<limit lower="-3" upper="3" effort="{effort}" velocity="4"/></joint>'
        )
        before = f"{name}_link"
    return "".join([*out, "</robot>"])


def weight(q: np.ndarray) -> np.ndarray:
    """Return the torque (N, 2) that holds the arm; positive joints turn x towards -z."""
    (m1, m2), (c1, c2) = MASSES, CENTRES
    elbow = -m2 * c2 * G * np.cos(q.sum(axis=1))
    return np.column_stack([-(m1 * c1 + m2 * LENGTH) * G * np.cos(q[:, 0]) + elbow, elbow])


def written(path: Path, scale=1.0, role="tau", rail=0.0) -> Path:
    """Write a log of the arm with torques times `scale`; with forces of a rail times `rail`."""
    t = np.arange(0, 8, 0.02)
    q = np.column_stack([np.sin(1.7 * t), 1.2 * np.cos(2.3 * t)])
    qd = np.column_stack([1.7 * np.cos(1.7 * t), -2.76 * np.sin(2.3 * t)])
    tau = scale * (weight(q) + 2.0 * qd + 1.5 * np.sign(qd))
    if rail:
        q = np.column_stack([0.3 * np.sin(t), q])
        tau = np.column_stack([rail * (14.0 * G - 30.0 * np.sin(t)), tau])
    n = q.shape[1]
    names = ["t", *(f"q{k + 1}" for k in range(n)), *(f"{role}{k + 1}" for k in range(n))]
    table = np.column_stack([t, q, tau])
    np.savetxt(path, table, "%.8g", ",", header=",".join(names), comments="")
    return path


def identified(command, robot, log, *more) -> tuple[int, str, str]:
    return command("predict", robot, log, "--parameters", robot, "--into", "out", *more)


@pytest.fixture(autouse=True)
def arm(tmp_path, monkeypatch) -> Path:
    """The arm in the working folder."""
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(urdf())
    return Path("arm.urdf")


@pytest.mark.parametrize("verb", ["identify", "diagnose", "predict", "payload"])
def test_torques_1000_times_too_large_are_refused_with_the_unit_to_type(command, arm, verb) -> None:
    log, more = written(Path("log.csv"), 1e3), []
    if verb in ("predict", "payload"):
        more = ["--parameters", arm]
    code, _, err = command(verb, arm, log, "--into", "out", *more)
    assert code == 2
    error = err.splitlines()[-1]
    for words in ("log.csv", "lift (1) and elbow (2)", "--unit tau=mNm", "--unit tau=Nm"):
        assert words in error
    table = np.loadtxt(log, delimiter=",", skiprows=1)
    sizes = [np.linalg.norm(x) for x in (table[:, 3:], weight(table[:, 1:3]))]
    limit = np.sqrt(2 * len(table)) * EFFORT
    times = re.search("([0-9]+) times that of the masses .* and ([0-9]+) times the", error)
    assert times is not None, error
    # without a validation log, the first four fifths of the log count
    assert float(times[1]) == pytest.approx(sizes[0] / sizes[1], rel=0.1)
    assert float(times[2]) == pytest.approx(sizes[0] / limit, rel=0.1)


@pytest.mark.parametrize(("unit", "gap"), [("mNm", 0.3), ("Nm", 1.0)])
def test_a_unit_that_the_user_typed_is_believed(command, arm, unit, gap) -> None:
    code, _, err = identified(command, arm, written(Path("log.csv"), 1e3), "--unit", f"tau={unit}")
    assert code == 0, err
    error = json.loads(Path("out/prediction.json").read_text())["torque_error"]["relative"]
    assert error == pytest.approx(gap, rel=0.5)


def test_one_bound_alone_is_a_note(arm) -> None:
    sound = written(Path("sound.csv"))
    noted = {}
    for name, robot, log in (
        ("limits", urdf(effort=1), sound),  # limits that nobody filled in
        ("masses", urdf((0.05, 0.02)), sound),  # 100 times too light
        ("no limits", urdf(effort=0), written(Path("large.csv"), 1e3)),
        ("light", urdf((0.007, 0.007), 1), sound),  # states no weight
    ):
        arm.write_text(robot)
        noted[name] = " ".join(symgen.predict(arm, log, arm).notes)
    assert "times its limit" in noted["limits"]
    for name in ("masses", "no limits"):
        assert "times that of the masses" in noted[name], name
    for name in ("limits", "light"):
        assert "times that of the masses" not in noted[name], name


def test_one_joint_alone_is_a_note(arm) -> None:
    log = written(Path("log.csv"), np.array([1.0, 1e3]))
    assert "times that of the masses" in " ".join(symgen.predict(arm, log, arm).notes)


def test_forces_of_a_rail_and_torques_are_compared_apart(command, arm) -> None:
    arm.write_text(urdf(rail=True))
    code, _, err = identified(command, arm, written(Path("log.csv"), 1.0, rail=1e3))
    assert code == 2
    assert "--unit tau1=mN;" in err
    code, _, err = identified(command, arm, written(Path("log.csv"), 1e3, rail=1.0))
    assert code == 2
    assert "--unit tau2=mNm,tau3=mNm;" in err
    code, _, err = identified(command, arm, Path("log.csv"), "--unit", "tau2=mNm,tau3=mNm")
    assert code == 0, err


def test_currents_in_milliampere_are_refused_by_the_file_that_import_writes(command, arm) -> None:
    assert command("import", arm, "--into", "robot.toml")[0] == 0
    drive = "\n[drive]\nratio = [1.0, 1.0]\ntorque_constant = [1.0, 1.0]\n"
    robot = Path("robot.toml")
    robot.write_text(robot.read_text() + drive)
    log = written(Path("log.csv"), 1e3, "i")
    code, _, err = command("identify", robot, log, "--into", "out")
    assert code == 2
    assert "--unit i=mA" in err.splitlines()[-1]


MJCF = """<mujoco model="arm"><compiler angle="radian"/><worldbody><body>
<inertial pos="0.2 0 0" mass="2" diaginertia="0.01 0.02 0.02"/>
<joint name="lift" axis="0 1 0" range="-3 3" {joint}/><body pos="0.4 0 0">
<inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>
<joint name="elbow" axis="0 1 0" range="-3 3" actuatorfrcrange="-30 30"/></body></body></worldbody>
<actuator><motor joint="lift" gear="50" forcerange="-0.8 0.8"/><motor joint="elbow"/></actuator>
</mujoco>"""


@pytest.mark.parametrize(
    ("joint", "limits"), [("", (40.0, 30.0)), ('actuatorfrcrange="-25 20"', (25.0, 30.0))]
)
def test_force_ranges_of_an_mjcf_are_its_torque_limits(joint, limits) -> None:
    pytest.importorskip("mujoco")
    Path("arm.xml").write_text(MJCF.format(joint=joint))
    assert symgen.read_robot("arm.xml").limits.torque == limits
