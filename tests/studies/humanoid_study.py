"""A humanoid of example-robot-data steps in place in MuJoCo; its logs are identified.

    python tests/studies/humanoid_study.py --seeds 5 [--hidden] [--offsets]

The Unitree G1 has flat feet. A gantry with a force sensor at its pelvis carries a part of the
weight, and keeps it upright while it sways and lifts one foot after the other. Masses are 10 to
30 % off the file, joints have friction and the sensors noise. The wrenches on the feet are
measured, or hidden with the contacts declared. The lines are those of floating_study.py.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from floating_study import (
    ARMATURE,
    BOUNCE,
    ENCODER,
    EVERY,
    FORCE,
    IMU,
    SOLIMP,
    SOLREF,
    SPEED,
    STEP,
    TORQUE,
    changed,
    judged,
    off,
    run,
    urdf_of,
)
from scipy.ndimage import binary_dilation

import symgen
from symgen.data.log import make_log
from symgen.robot.tables import Contact, Frame
from symgen.robot.toml_io import read_imported

SIDES = ("left", "right")
FEET = tuple(f"{side}_ankle_roll_link" for side in SIDES)
#: Joints that move, with gains N m/rad and N m s/rad. The others are welded.
LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARMS = ("shoulder_pitch", "shoulder_roll", "elbow")
MOVING = (
    *(f"{side}_{name}_joint" for side in SIDES for name in LEG),
    "waist_yaw_joint",
    *(f"{side}_{name}_joint" for side in SIDES for name in ARMS),
)
GAIN, DAMPING = 200.0, 5.0
CROUCH, LIFT = 0.35, 0.5  # rad, of hip and ankle; the knee bends twice as much
PERIOD, UP = 4.0, 0.4  # s; part of it in which a foot is up
MOMENT = 0.03  # N m, noise of the sensors of wrenches
#: Springs of the gantry: N/m and N s/m, N m/rad and N m s/rad.
ROPES = ((3000.0, 300.0), (300.0, 20.0))
SHARE = 0.3  # of the weight, before the springs of the gantry


def welded(text: str) -> str:
    """Return a URDF in which only some joints move, without limits."""
    root = ET.fromstring(text.encode())
    for joint in root.findall("joint"):
        moves = joint.get("name") in MOVING
        joint.set("type", "continuous" if moves else "fixed")
    return ET.tostring(root, "unicode")


def plant(urdf: str) -> mujoco.MjModel:
    """Return a URDF in MuJoCo with a free base, an IMU, feet and a floor."""
    spec = mujoco.MjSpec.from_string(urdf)
    spec.compiler.fusestatic = False
    spec.option.timestep, spec.option.iterations = STEP, 100
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 20
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    site = mujoco.mjtObj.mjOBJ_SITE
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[9, 9, 1])
    pelvis = spec.body("pelvis")
    pelvis.add_freejoint()
    pelvis.add_site(name="imu")
    spec.add_sensor(type=mujoco.mjtSensor.mjSENS_ACCELEROMETER, objtype=site, objname="imu")
    spec.add_sensor(type=mujoco.mjtSensor.mjSENS_GYRO, objtype=site, objname="imu")
    for name in FEET:
        for x, y in ((-0.05, 0.025), (-0.05, -0.025), (0.12, 0.03), (0.12, -0.03)):
            spec.body(name).add_geom(size=[0.005, 0, 0], pos=[x, y, -0.03], mass=0)
    model = spec.compile()
    model.dof_armature[6:] = ARMATURE
    model.dof_solref[6:], model.dof_solimp[6:, :3] = SOLREF, SOLIMP
    return model


def waves(draw: np.random.Generator, size: np.ndarray, fastest: float):
    """Return a function of time: sums of three sines with some sizes."""
    rate = 2 * np.pi * draw.uniform(0.15, fastest, (3, len(size)))
    phase = draw.uniform(0, 2 * np.pi, (3, len(size)))
    return lambda t: size * np.sin(rate * t + phase).mean(axis=0)


class Steps:
    """Wanted motion of joints and pelvis: it sways, and swings one leg after the other."""

    def __init__(self, seed: int, names: list[str]) -> None:
        draw = np.random.default_rng(1000 + seed)
        self.bend = np.zeros(len(names))
        self.legs = []
        for side in SIDES:
            leg = [names.index(f"{side}_{name}_joint") for name in LEG]
            self.bend[leg] = np.array([-1, 0, 0, 2, -1, 0])
            self.legs.append(leg)
        still = np.array([0.5 if "shoulder" in n or "elbow" in n else 0.03 for n in names])
        still[names.index("waist_yaw_joint")] = 0.5
        self.sway = waves(draw, 1.5 * still, 0.8)
        self.swing = waves(draw, np.full(len(names), 1.0), 1.2)
        self.pelvis = waves(draw, np.array([0.04, 0.05, 0.02, 0.1, 0.1, 0.2]) * 1.5, 0.8)

    def joints(self, t: float) -> np.ndarray:
        """Return the wanted positions."""
        starts = min(t, 1.0)
        q = CROUCH * self.bend + starts * self.sway(t)
        swing = self.swing(t)
        for k, leg in enumerate(self.legs):
            part = (t / PERIOD + k / 2) % 1.0 / UP
            height = starts * max(4 * part * (1 - part), 0.0) ** 1.5
            q[leg] += height * (LIFT * self.bend[leg] + swing[leg])
        return q


def wrench_on(data: mujoco.MjData, body: int, root: int) -> np.ndarray:
    """Return the external force on a body and its moment about its frame, in its axes, (6,)."""
    moment, force = np.split(data.cfrc_ext[body], 2)
    moment = moment + np.cross(data.subtree_com[root] - data.xpos[body], force)
    axes = data.xmat[body].reshape(3, 3)
    return np.array([*axes.T @ force, *axes.T @ moment])


def step(m: mujoco.MjModel, seed: int, seconds: float) -> dict[str, np.ndarray]:
    """Simulate steps in place, and record t, q, qd, tau, imu and wrenches on pelvis and feet."""
    d = mujoco.MjData(m)
    names = [m.joint(k).name for k in range(1, m.njnt)]
    steps, base = Steps(seed, names), m.body("pelvis").id
    places = [base, *(m.body(name).id for name in FEET)]
    d.qpos[3], d.qpos[7:] = 1.0, steps.joints(0.0)
    mujoco.mj_forward(m, d)
    d.qpos[2] = 0.036 - d.xpos[places[1:], 2].min()
    height, weight = d.qpos[2], 9.81 * m.body_mass.sum()
    rows, turn = [], np.zeros(3)
    for k in range(round((seconds + 1) / STEP)):
        t = k * STEP
        wanted, later = steps.joints(t), steps.joints(t + STEP)
        speed = (later - wanted) / STEP
        d.qfrc_applied[6:] = GAIN * (wanted - d.qpos[7:]) + DAMPING * (speed - d.qvel[6:])
        place = min(t, 1.0) * steps.pelvis(t)
        (kx, dx), (kr, dr) = ROPES
        force = kx * (place[:3] + [0, 0, height] - d.qpos[:3]) - dx * d.qvel[:3]
        force[2] += SHARE * weight
        mujoco.mju_quat2Vel(turn, d.qpos[3:7], 1.0)
        axes = d.xmat[base].reshape(3, 3)
        moment = kr * (place[3:] - turn) - dr * axes @ d.qvel[3:6]
        lever = d.xpos[base] - d.xipos[base]
        d.xfrc_applied[base] = [*force, *(moment + np.cross(lever, force))]
        q, qd, tau, z = d.qpos[7:].copy(), d.qvel[6:].copy(), d.qfrc_applied[6:].copy(), d.qpos[2]
        mujoco.mj_forward(m, d)
        if k % EVERY == 0 and t >= 1:
            mujoco.mj_rnePostConstraint(m, d)
            wrenches = [wrench_on(d, body, m.body_rootid[base]) for body in places]
            rows.append([t - 1, *q, *qd, *tau, *d.sensordata, *np.ravel(wrenches), z])
        mujoco.mj_step(m, d)
    sizes = [1, *[len(names)] * 3, 6, 18]
    t, q, qd, tau, imu, wrenches, z = np.split(np.array(rows), np.cumsum(sizes), axis=1)
    wrenches = wrenches.reshape(-1, 3, 6)
    down = np.abs(wrenches[:, 1:]).max(axis=2) > 1e-6
    share = wrenches[:, 0, 2].mean() / weight
    print(
        f"  height {z.min():.3f} to {z.max():.3f} m, feet down {down.mean(axis=0)}, the gantry "
        f"carries {share:.2f} of the weight", flush=True,
    )  # fmt: skip
    down = binary_dilation(down, np.ones((2 * BOUNCE + 1, 1)))
    return {"t": t[:, 0], "q": q, "qd": qd, "tau": tau, "imu": imu, "wrenches": wrenches,
            "touches": down, "names": names}  # fmt: skip


def log_of(
    name: str, clean: dict, robot: symgen.Robot, hidden: bool, offsets: bool, seed: int
) -> symgen.Log:
    """Return a log with noise, and the wrench of the gantry, and of the feet unless hidden."""
    draw = np.random.default_rng(seed)

    def noisy(x: np.ndarray, size) -> np.ndarray:
        return x + size * draw.normal(size=x.shape)

    imu = off(clean["t"], clean["imu"], draw) if offsets else clean["imu"]
    order = [clean["names"].index(name) for name in robot.joint_names]
    q, qd, tau = (clean[role][:, order] for role in ("q", "qd", "tau"))
    frames = [frame.name for frame in robot.frames]
    forces = np.full((len(q), len(frames), 6), np.nan)
    known = ("gantry",) if hidden else ("gantry", *FEET)
    for k, frame in enumerate(known):
        noise = np.repeat([FORCE, MOMENT], 3)
        forces[:, frames.index(frame)] = noisy(clean["wrenches"][:, k], noise)
    return make_log(
        name, clean["t"], noisy(q, ENCODER), noisy(tau, TORQUE), noisy(qd, SPEED),
        imu=noisy(imu, np.repeat(IMU, 3)), touches=clean["touches"].astype(float),
        forces=forces.reshape(len(q), -1),
    )  # fmt: skip


def study(seed: int, hidden: bool, offsets: bool, seconds: float) -> tuple[float, ...]:
    """Return the error of the total mass, the coverage, and the ratio of torque errors."""
    urdf = changed(welded(urdf_of("g1_29dof_rev_1_0")), seed)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "g1.urdf"
        file.write_text(urdf)
        imported = read_imported(file, base="floating")
    contacts = tuple(Contact(name, "surface") for name in FEET)
    frames = (*imported.robot.frames, Frame("gantry", 0))
    robot = replace(imported.robot, contacts=contacts, frames=frames)
    m = plant(urdf)
    logs = [
        log_of(f"log{k}", step(m, 2 * seed + k, seconds), robot, hidden, offsets, 2 * seed + k)
        for k in range(2)
    ]
    return judged(seed, robot, dict(imported.parameters), m.body_mass.sum(), logs)


if __name__ == "__main__":
    run(study, __doc__)
