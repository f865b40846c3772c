"""A quadruped of example-robot-data trots in MuJoCo; its logs are identified.

    python tests/studies/floating_study.py --seeds 5 [--hidden] [--offsets]

Masses are 10 to 30 % off the file, joints have friction and the sensors noise. The forces on the
feet are measured, or hidden with the contacts declared. For each seed, it prints the error of the
total mass, the share of 95 % intervals that contain the parameter, and the held-out torque error
over that of the true parameters.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import binary_dilation

sys.path.insert(0, str(Path(__file__).parents[1]))

from oracles.pinocchio_arm import load_pinocchio
from oracles.urdf_arm import shipped

import symgen
from symgen.data.log import make_log
from symgen.identification.parameters import base_values
from symgen.identification.prediction import torque_errors
from symgen.robot.tables import Contact
from symgen.robot.toml_io import read_imported

LEGS = ("FL", "FR", "RL", "RR")
STEP, EVERY = 0.0005, 4  # s of a simulation, and its steps from sample to sample
PERIOD, DUTY, LIFT, HEIGHT = 1.2, 0.68, 0.05, 0.27  # s; part on the ground; m
GAIN, DAMPING = 120.0, 3.0
COULOMB, VISCOUS, ARMATURE = 0.2, 0.1, 0.01
#: Dry friction in MuJoCo as files of symgen have it: by default it is soft, and does not stick.
SOLREF, SOLIMP = (0.004, 1), (0.99, 0.99, 0.001)
ENCODER, SPEED, TORQUE, FORCE = 1e-5, 2e-3, 0.05, 0.3
BOUNCE = 10  # samples
IMU, OFFSETS, LATE = (0.02, 0.002), (0.05, 0.005), 0.0005


def urdf_of(name: str) -> str:
    """Return a URDF of example-robot-data."""
    texts = [path.read_text() for path in shipped() if path.stem == name]
    if not texts:
        sys.exit("example-robot-data is not installed")
    return texts[0]


def changed(text: str, seed: int) -> str:
    """Return a URDF with masses 10 to 30 % off, and with the friction of this study.

    All links that a joint moves together have one factor.
    """
    root = ET.fromstring(text.encode())
    draw = np.random.default_rng(seed)
    behind = {j.find("child").get("link"): j for j in root.findall("joint")}
    factors: dict[str, float] = {}
    for link in root.findall("link"):
        name = link.get("name")
        while name in behind and behind[name].get("type") == "fixed":
            name = behind[name].find("parent").get("link")
        factor = 1 + draw.choice([-1, 1]) * draw.uniform(0.1, 0.3)
        factor = factors.setdefault(name, factor)
        for entry in [*link.iterfind("inertial/mass"), *link.iterfind("inertial/inertia")]:
            for key, value in entry.attrib.items():
                entry.set(key, repr(float(factor * float(value))))
        for tag in ("visual", "collision"):
            for shape in link.findall(tag):
                link.remove(shape)
    for joint in behind.values():
        if joint.get("type") != "fixed":
            dynamics = joint.find("dynamics")
            if dynamics is None:
                dynamics = ET.SubElement(joint, "dynamics")
            dynamics.set("damping", repr(VISCOUS))
            dynamics.set("friction", repr(COULOMB))
    return ET.tostring(root, "unicode")


class Quadruped:
    """The quadruped in Pinocchio, with masses off its file, and in MuJoCo."""

    def __init__(self, seed: int) -> None:
        pin = load_pinocchio()
        self.urdf = changed(urdf_of("go1"), seed)
        self.model = pin.buildModelFromXML(self.urdf, pin.JointModelFreeFlyer())
        self.feet = []
        for leg in LEGS:
            frame = self.model.frames[self.model.getFrameId(f"{leg}_foot")]
            self.feet.append((frame.parentJoint, frame.placement))
        self.mj = mujoco.MjModel.from_xml_string(self._mjcf())

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return sum(inertia.mass for inertia in self.model.inertias)

    def _mjcf(self) -> str:
        bodies = self._body(1)
        return f"""<mujoco><option timestep="{STEP}" cone="elliptic"
          impratio="20" iterations="100"><flag eulerdamp="disable"/></option>
        <worldbody><geom type="plane" size="9 9 1" friction="1"/>{bodies}</worldbody></mujoco>"""

    def _body(self, number: int) -> str:
        """Return a link with all behind it."""
        model, inertia = self.model, self.model.inertias[number]
        at, turned = model.jointPlacements[number], np.zeros(4)
        mujoco.mju_mat2Quat(turned, np.ascontiguousarray(at.rotation).ravel())
        A = inertia.inertia
        entries = A[0, 0], A[1, 1], A[2, 2], A[0, 1], A[0, 2], A[1, 2]
        name = model.names[number]
        joint = '<freejoint name="base"/>'
        if number > 1:
            axis = _row(_AXES[model.joints[number].shortname()[-1]])
            joint = (
                f'<joint name="{name}" axis="{axis}" armature="{ARMATURE}" damping="{VISCOUS}" '
                f'frictionloss="{COULOMB}" solreffriction="{_row(SOLREF)}" '
                f'solimpfriction="{_row(SOLIMP)}"/>'
            )
        feet = "".join(
            f'<geom name="{leg}" type="sphere" size="0.001" pos="{_row(place.translation)}" '
            'mass="0" friction="1" solref="0.02 1"/>'
            for leg, (parent, place) in zip(LEGS, self.feet, strict=True)
            if parent == number
        )
        below = "".join(self._body(k) for k, p in enumerate(model.parents) if k > 1 and p == number)
        return (
            f'<body name="{name}" pos="{_row(at.translation)}" quat="{_row(turned)}">{joint}'
            f'<inertial pos="{_row(inertia.lever)}" mass="{inertia.mass!r}" '
            f'fullinertia="{_row(entries)}"/>{feet}{below}</body>'
        )


_JOINTS = ("hip", "thigh", "calf")
_AXES = {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1)}
#: Hips of the legs, side of the thigh, and lengths of thigh and calf, m.
HIPS = {"FL": (1, 1), "FR": (1, -1), "RL": (-1, 1), "RR": (-1, -1)}
HIP, SIDE, THIGH = (0.1881, 0.04675), 0.08, 0.213


def _row(values) -> str:
    return " ".join(repr(float(x)) for x in values)


def gait(t: float, seed: int) -> np.ndarray:
    """Return the wanted positions of the joints in a trot, (12,)."""
    draw = np.random.default_rng(1000 + seed)
    rate = 2 * np.pi * draw.uniform(0.2, 0.9, (6, 3))
    phase = draw.uniform(0, 2 * np.pi, (6, 3))
    size = np.array([0.02, 0.015, 0.02, 0.09, 0.09, 0.12])
    x, y, z, roll, pitch, yaw = size * np.sin(rate * t + phase).mean(axis=1) * 1.5
    turned = np.zeros(4)
    mujoco.mju_euler2Quat(turned, np.array([roll, pitch, yaw]), "xyz")
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, turned)
    rotation = rotation.reshape(3, 3)
    starts = min(t / 1.0, 1.0)
    out = []
    for front, left in HIPS.values():
        part = (t / PERIOD + (0.5 if front * left < 0 else 0.0)) % 1.0
        swing = max(part - DUTY, 0.0) / (1 - DUTY)
        height = LIFT * starts * (16 * (swing * (1 - swing)) ** 2)
        hip = np.array([front * HIP[0], left * HIP[1], 0.0])
        ground = hip + [0, left * SIDE, -HEIGHT + height]
        foot = rotation.T @ (ground - starts * np.array([x, y, z])) - hip
        out += leg_angles(foot, left * SIDE)
    return np.array(out)


def leg_angles(foot: np.ndarray, side: float) -> list[float]:
    """Return the angles of hip, thigh and calf for a foot in the axes of the hip."""
    x, y, z = foot
    down = np.sqrt(max(y**2 + z**2 - side**2, 1e-4))
    hip = np.arctan2(y, -z) - np.arctan2(side, down)
    reach = min(np.hypot(x, down), 1.999 * THIGH)
    calf = -2 * np.arccos(reach / (2 * THIGH))
    return [hip, np.arctan2(-x, down) - calf / 2, calf]


def trot(robot: Quadruped, seed: int, seconds: float) -> dict[str, np.ndarray]:
    """Simulate a trot and record t, q, qd, tau, imu, forces and touches."""
    m = robot.mj
    d = mujoco.MjData(m)
    joints = [m.joint(f"{leg}_{j}_joint") for leg in LEGS for j in _JOINTS]
    at_q = np.array([j.qposadr[0] for j in joints])
    at_v = np.array([j.dofadr[0] for j in joints])
    ids = [m.geom(leg).id for leg in LEGS]
    bodies = [m.geom_bodyid[k] for k in ids]
    d.qpos[:3], d.qpos[3:7], d.qpos[at_q] = (0, 0, HEIGHT + 0.002), (1, 0, 0, 0), gait(0.0, seed)
    base, rows, wrench = m.body("root_joint").id, [], np.zeros(6)
    for k in range(round((seconds + 1) / STEP)):
        t = k * STEP
        wanted, later = gait(t, seed), gait(t + STEP, seed)
        force = GAIN * (wanted - d.qpos[at_q]) + DAMPING * ((later - wanted) / STEP - d.qvel[at_v])
        d.qfrc_applied[at_v] = np.clip(force, -33.5, 33.5)
        mujoco.mj_forward(m, d)
        if k % EVERY == 0 and t >= 1:
            mujoco.mj_rnePostConstraint(m, d)
            axes = d.xmat[base].reshape(3, 3)
            # cacc is about the centre of the tree, in world axes, minus gravity
            angular, linear = d.cacc[base][:3], d.cacc[base][3:]
            arm = d.xpos[base] - d.subtree_com[m.body_rootid[base]]
            w = axes @ d.qvel[3:6]
            v = d.qvel[:3]
            f = linear + np.cross(angular, arm) + np.cross(w, v)
            feet, down = np.zeros((4, 3)), np.zeros(4)
            for c in range(d.ncon):
                contact = d.contact[c]
                i = ids.index(max(contact.geom))
                mujoco.mj_contactForce(m, d, c, wrench)
                push = contact.frame.reshape(3, 3).T @ wrench[:3]
                feet[i] = d.xmat[bodies[i]].reshape(3, 3).T @ push
                down[i] = wrench[0] > 1e-6
            rows.append(
                [t - 1, *d.qpos[at_q], *d.qvel[at_v], *d.qfrc_applied[at_v], *axes.T @ f,
                 *d.qvel[3:6], *feet.ravel(), *down, d.qpos[2]]
            )  # fmt: skip
        mujoco.mj_step(m, d)
    t, q, qd, tau, imu, feet, down, z = np.split(
        np.array(rows), np.cumsum([1, 12, 12, 12, 6, 12, 4]), axis=1
    )
    print(f"  height {z.min():.3f} to {z.max():.3f} m, feet down {down.mean(axis=0)}", flush=True)
    feet = feet.reshape(-1, 4, 3)
    down = binary_dilation(down > 0, np.ones((2 * BOUNCE + 1, 1)))  # a foot may bounce
    forces = np.concatenate([feet, 0 * feet], axis=2)
    return {
        "t": t[:, 0],
        "q": q,
        "qd": qd,
        "tau": tau,
        "imu": imu,
        "forces": forces,
        "touches": down,
    }


def off(t: np.ndarray, imu: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """Return the readings of an IMU that is late and has offsets."""
    late = CubicSpline(t, imu)(np.maximum(t - LATE, 0))
    return late + np.repeat(OFFSETS, 3) * draw.choice([-1, 1], 6)


def log_of(
    name: str,
    clean: dict[str, np.ndarray],
    robot: symgen.Robot,
    hidden: bool,
    offsets: bool,
    seed: int,
) -> symgen.Log:
    """Return a log with noise, and the forces on the feet or which of them touch the ground."""
    draw = np.random.default_rng(seed)

    def noisy(x: np.ndarray, size) -> np.ndarray:
        return x + size * draw.normal(size=x.shape)

    t, imu = clean["t"], clean["imu"]
    if offsets:
        imu = off(t, imu, draw)
    of_legs = [f"{leg}_{joint}_joint" for leg in LEGS for joint in _JOINTS]
    order = [of_legs.index(name) for name in robot.joint_names]  # that of the file
    q, qd, tau = (clean[role][:, order] for role in ("q", "qd", "tau"))
    more: dict[str, np.ndarray] = {"touches": clean["touches"].astype(float)}
    if not hidden:
        names = [frame.name for frame in robot.frames]
        forces = np.full((len(t), len(names), 6), np.nan)
        for k, leg in enumerate(LEGS):
            of_leg = noisy(clean["forces"][:, k], FORCE)
            of_leg[:, 3:] = 0.0
            forces[:, names.index(f"{leg}_foot")] = of_leg
        more["forces"] = forces.reshape(len(t), -1)
    return make_log(
        name, t, noisy(q, ENCODER), noisy(tau, TORQUE), noisy(qd, SPEED),
        imu=noisy(imu, np.repeat(IMU, 3)), **more,
    )  # fmt: skip


def study(seed: int, hidden: bool, offsets: bool, seconds: float) -> tuple[float, ...]:
    """Return the error of the total mass, the coverage, and the ratio of torque errors."""
    quadruped = Quadruped(seed)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "go1.urdf"
        file.write_text(quadruped.urdf)
        imported = read_imported(file, base="floating")
    contacts = tuple(Contact(f"{leg}_foot", "point") for leg in LEGS)
    robot = replace(imported.robot, contacts=contacts)
    logs = []
    for k in range(2):
        clean = trot(quadruped, 2 * seed + k, seconds)
        logs.append(log_of(f"log{k}", clean, robot, hidden, offsets, 2 * seed + k))
    return judged(seed, robot, dict(imported.parameters), quadruped.mass, logs)


def judged(
    seed: int, robot: symgen.Robot, given: dict[str, float], mass: float, logs: list[symgen.Log]
) -> tuple[float, ...]:
    """Print and return how an estimate of the first log compares with the true parameters."""
    estimate = symgen.identify(robot, logs[0], validation=logs[1])
    model = symgen.derive(robot, ("inverse_dynamics", "torque_regressor"))
    given |= {p.name: ARMATURE for p in model.base.standard if p.prefix == "IA"}
    X = base_values(given, model, "the URDF")
    found = np.array([p.value for p in estimate.parameters])
    away = np.array([abs(p.value - x) / p.std for p, x in zip(estimate.parameters, X, strict=True)])
    errors = torque_errors(robot, logs[1], [X, found], estimate.band, estimate.shifts)
    total = next(p.value for p in estimate.parameters if p.name == "M0R")
    result = total / mass - 1, float(np.mean(away < 1.96)), errors[1] / errors[0]
    error = estimate.torque_validation
    print(
        f"seed {seed}: {estimate.verdict}, total mass {100 * result[0]:+.3f} %, intervals "
        f"{100 * result[1]:.1f} %, torque error {error.relative:.4f} (base force "
        f"{error.base_force:.4f}, moment {error.base_moment:.4f}, joints {error.joints:.4f}), "
        f"{result[2]:.3f} of the true parameters, band {estimate.band.in_words()}", flush=True,
    )  # fmt: skip
    return result


def run(study: Callable[..., tuple[float, ...]], doc: str | None) -> None:
    """Run a study with the options of the command line."""
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--hidden", action="store_true", help="hide the forces on the feet")
    parser.add_argument("--offsets", action="store_true", help="offsets and delay of the IMU")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    runs = [study(seed, options.hidden, options.offsets, options.seconds) for seed in seeds]
    mass, inside, ratio = np.array(runs).T
    print(
        f"total mass: largest error {100 * np.abs(mass).max():.3f} %; intervals that contain the "
        f"parameter: {100 * inside.mean():.1f} %; torque error over that of the true parameters: "
        f"up to {ratio.max():.3f}"
    )


if __name__ == "__main__":
    run(study, __doc__)
