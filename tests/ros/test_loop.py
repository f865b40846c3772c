"""The controller of a ROS package in a loop with MuJoCo at 1 kHz: it holds, follows, and carries.

MuJoCo reads the URDF itself. Friction of the simulated joints is MuJoCo's own.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.urdf_arm import shipped, with_all_digits
from support_ros2 import Built, build, needs_ros, process

import symgen
from symgen.identification.parameters import read_values

pytestmark = pytest.mark.slow
mujoco = pytest.importorskip("mujoco", reason="MuJoCo (PyPI: mujoco) is not installed")

STEP = 0.001
COULOMB = np.array([8.0, 8.0, 5.0, 2.0, 2.0, 1.5])
VISCOUS = np.array([6.0, 6.0, 4.0, 1.5, 1.5, 1.0])
P = np.array([2000.0, 2000.0, 1500.0, 300.0, 300.0, 200.0])
D = np.array([200.0, 200.0, 120.0, 20.0, 20.0, 10.0])
UNLIMITED = np.full(6, 1e6)
LOAD = 3.0, (0.02, -0.03, 0.1), (0.02, 0.0, 0.0, 0.02, 0.0, 0.01)


def urdf() -> str:
    """Return the URDF of a UR10 without shapes."""
    found = [path for path in shipped() if path.name == "ur10_robot.urdf"]
    if not found:
        pytest.skip("example-robot-data (PyPI) is not installed")
    robot = ET.fromstring(with_all_digits(found[0].read_text()).encode())
    for link in robot.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    return ET.tostring(robot, encoding="unicode")


class Simulated:
    """The arm in MuJoCo, with or without friction, and with a load on the link tool0."""

    def __init__(self, text: str, friction: bool, load: bool = False) -> None:
        robot = ET.fromstring(text)
        compiler = ET.SubElement(ET.SubElement(robot, "mujoco"), "compiler")
        compiler.attrib.update(fusestatic="false", balanceinertia="false")
        if load:
            body = ET.SubElement(robot, "link", name="load")
            joint = ET.SubElement(robot, "joint", name="grip", type="fixed")
            ET.SubElement(joint, "parent", link="tool0")
            ET.SubElement(joint, "child", link="load")
            mass, com, inertia = LOAD
            inertial = ET.SubElement(body, "inertial")
            ET.SubElement(inertial, "origin", xyz=" ".join(map(str, com)))
            ET.SubElement(inertial, "mass", value=str(mass))
            keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
            ET.SubElement(inertial, "inertia", dict(zip(keys, map(str, inertia), strict=True)))
        self.model = mujoco.MjModel.from_xml_string(ET.tostring(robot, encoding="unicode"))
        self.model.opt.timestep = STEP
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self.model.jnt_limited[:] = 0
        if friction:
            self.model.dof_frictionloss[:] = COULOMB
            self.model.dof_damping[:] = VISCOUS
        self.data = mujoco.MjData(self.model)

    def start(self, q: np.ndarray) -> None:
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = q

    def step(self, tau: np.ndarray) -> None:
        self.data.qfrc_applied[:] = tau
        mujoco.mj_step(self.model, self.data)


@dataclass(frozen=True)
class Motion:
    """A periodic motion of all joints."""

    amplitudes: np.ndarray  # (n, k), rad
    frequencies: np.ndarray  # (n, k), rad/s
    middle: np.ndarray  # (n,), rad

    def at(self, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        a, w = self.amplitudes, self.frequencies
        q = self.middle + np.sum(a * (1 - np.cos(w * t)), axis=1)
        qd = np.sum(a * w * np.sin(w * t), axis=1)
        return q, qd, np.sum(a * w**2 * np.cos(w * t), axis=1)


def motion(seed: int) -> Motion:
    rng = np.random.default_rng(seed)
    amplitudes = rng.uniform(0.1, 0.4, (6, 3)) * rng.choice([-1.0, 1.0], (6, 3))
    frequencies = 2 * np.pi * rng.uniform([0.1, 0.3, 0.5], [0.3, 0.5, 0.8], (6, 3))
    middle = rng.uniform(-0.5, 0.5, 6) + np.array([0.0, -1.2, 1.2, 0.3, 0.8, 0.0])
    return Motion(amplitudes, frequencies, middle)


def record(text: str, seed: int, seconds: float, into: Path) -> Path:
    """Write a noisy log of the arm under PD control on a motion."""
    arm, path, rng = Simulated(text, friction=True), motion(seed), np.random.default_rng(seed)
    arm.start(path.at(0.0)[0])
    rows = []
    for k in range(round(seconds / STEP)):
        q, qd, _ = path.at(k * STEP)
        tau = P * (q - arm.data.qpos) + D * (qd - arm.data.qvel)
        if k % 2 == 0:
            measured = arm.data.qpos + rng.normal(0.0, 2e-5, 6)
            rows.append([k * STEP, *measured, *(tau + rng.normal(0.0, 0.01 * UNIT))])
        arm.step(tau)
    header = ",".join(["t", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))])
    file = into / f"log{seed}.csv"
    np.savetxt(file, np.array(rows), delimiter=",", header=header, comments="")
    return file


UNIT = np.array([100.0, 100.0, 60.0, 10.0, 10.0, 5.0])  # size of the torques, N m


@pytest.fixture(scope="module")
def true_arm(tmp_path_factory) -> Iterator[tuple[str, Built]]:
    """The ROS package with the parameters of the file."""
    needs_ros()
    folder = tmp_path_factory.mktemp("loop")
    text = urdf()
    (folder / "arm.urdf").write_text(text)
    model = symgen.derive(symgen.read_robot(folder / "arm.urdf"), "all")
    values = read_values(folder / "arm.urdf", model)
    still = replace(values, X=(*values.X[: model.base.inertial], *friction_free(model)))
    symgen.write_package(symgen.generate(model, target="ros2", values=still), folder / "arm")
    (package,) = folder.glob("arm/*_model")
    with process() as hosts:
        yield text, Built(build(package, "jazzy", folder / "jazzy"), package.name, hosts)


def friction_free(model: symgen.Model) -> list[float]:
    return [0.0] * (len(model.base.parameters) - model.base.inertial)


def test_an_arm_without_friction_stays_where_it_is(true_arm, capsys):
    text, built = true_arm
    host = built.host("controller", torque_limits=UNLIMITED)
    assert host.start("controller", text) == 0, host.log()
    arm, rng = Simulated(text, friction=False), np.random.default_rng(1)
    worst = 0.0
    for _ in range(20):
        pose = rng.uniform(-2.5, 2.5, 6)
        arm.start(pose)
        for _ in range(round(10.0 / STEP)):
            arm.step(host.cycle(arm.data.qpos, arm.data.qvel))
        worst = max(worst, np.abs(arm.data.qpos - pose).max())
    with capsys.disabled():
        print(f"\ndrift in 10 s from 20 poses: {worst * 1e3:.3g} mrad")
    assert worst < 1e-3


def tracking(host: Any, arm: Simulated, path: Motion, seconds: float = 10.0) -> np.ndarray:
    """Return the RMS position error of each joint, without the first second."""
    arm.start(path.at(0.0)[0])
    errors = []
    for k in range(round(seconds / STEP)):
        q, qd, qdd = path.at(k * STEP)
        state = arm.data.qpos.copy(), arm.data.qvel.copy()
        if host is None:
            tau = P * (q - state[0]) + D * (qd - state[1])
        else:
            host.refer(np.stack([q, qd, qdd, np.zeros(6)], axis=1).ravel())
            tau = host.cycle(*state)
        if k * STEP >= 1.0:
            errors.append(q - state[0])
        arm.step(tau)
    return np.sqrt(np.mean(np.square(errors), axis=0))


@pytest.fixture(scope="module")
def identified(true_arm, tmp_path_factory) -> np.ndarray:
    """X of noisy logs of the simulated arm."""
    folder = tmp_path_factory.mktemp("logs")
    text, _ = true_arm
    (folder / "arm.urdf").write_text(text)
    logs = [record(text, seed, 30.0, folder) for seed in (11, 12, 13)]
    estimate = symgen.identify(folder / "arm.urdf", logs[:2], validation=logs[2:])
    assert estimate.verdict == "trusted", estimate.reasons
    return np.array([p.value for p in estimate.parameters])


def test_identified_feedforward_tracks_five_times_better(true_arm, identified, capsys):
    text, built = true_arm
    host = built.host("controller", feedforward="full", torque_limits=UNLIMITED)
    for name, values in (("gains.p", P), ("gains.d", D), ("model.X", identified)):
        host.set(name, values)
    assert host.start("controller", text) == 0, host.log()
    host.chain(True)
    path = motion(99)
    lines = []
    ratios = {}
    for load in (False, True):
        arm = Simulated(text, friction=True, load=load)
        alone = tracking(None, arm, path)
        for known in (False, True) if load else (False,):
            host.load("tool0", *(LOAD if known else (0.0,)))
            ratio = tracking(host, arm, path) / alone
            case = ("no load", "load, not set", "load, set")[load + known]
            ratios[case] = np.sqrt(np.mean(ratio**2))
            lines.append(f"{case}: {', '.join(f'{r:.3f}' for r in ratio)}")
    with capsys.disabled():
        print("\nRMS position error over that of PD, joint by joint\n" + "\n".join(lines))
    assert ratios["no load"] < 0.2
    assert ratios["load, set"] < 0.2
