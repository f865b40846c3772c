"""A Go2 that differs from its file trots in MuJoCo: writes go2.xml, train.npz and test.npz."""

from importlib.metadata import files
from pathlib import Path

import mujoco
import numpy as np

LEGS = ("FL", "FR", "RL", "RR")
STAND = np.tile([0.0, 0.9, -1.8], 4)
NOISE = np.repeat([1e-5, 2e-3, 0.05, 0.02, 0.002], [12, 12, 12, 3, 3])  # q, qd, tau, f, w


def go2():
    """Return the URDF with a free base, an IMU, point feet and a floor."""
    (urdf,) = (f.locate() for f in files("example-robot-data") if f.name == "go2.urdf")
    spec = mujoco.MjSpec.from_string(urdf.read_text())
    spec.option.timestep, spec.compiler.fusestatic = 0.001, False
    for shape in [*spec.geoms]:
        spec.delete(shape)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[9, 9, 1])
    base, sensor, site = spec.body("base"), mujoco.mjtSensor, mujoco.mjtObj.mjOBJ_SITE
    base.add_freejoint()
    base.add_site(name="imu")
    spec.add_sensor(type=sensor.mjSENS_ACCELEROMETER, objtype=site, objname="imu")
    spec.add_sensor(type=sensor.mjSENS_GYRO, objtype=site, objname="imu")
    for leg in LEGS:
        foot = spec.body(f"{leg}_foot")
        foot.add_geom(size=[0.001, 0, 0])
        foot.add_site(name=leg, size=[0.01, 0.01, 0.01])
        spec.add_sensor(type=sensor.mjSENS_TOUCH, objtype=site, objname=leg)
    return spec


def trot(robot, draw):
    """Return q, qd, tau, the IMU and which feet touch, at 250 Hz."""
    data, rows = mujoco.MjData(robot), []
    rate, phase = draw.uniform(1, 5, 12), draw.uniform(0, 6, 12)
    data.qpos[2], data.qpos[7:] = 0.28, STAND
    for _ in range(17_000):
        swing = np.sin(5 * data.time + np.pi * np.array([0, 1, 1, 0]))
        lift = np.kron(np.maximum(swing - 0.5, 0), [0, 0.5, -1])
        sway = 0.05 * np.sin(rate * data.time + phase)
        q, qd = data.qpos[7:].copy(), data.qvel[6:].copy()
        tau = 200 * (STAND + lift + sway - q) - 5 * qd
        data.qfrc_applied[6:] = tau
        mujoco.mj_step(robot, data)
        rows.append([*q, *qd, *tau, *data.sensordata])
    rows = np.array(rows[1000::4])
    rows[:, :42] += NOISE * draw.normal(size=(len(rows), 42))
    return np.split(rows, [12, 24, 36, 42], axis=1)


spec = go2()
robot = spec.compile()
Path("go2.xml").write_text(spec.to_xml())
heavier = np.random.default_rng(0).uniform(1.1, 1.3, robot.nbody)
robot.body_mass *= heavier
robot.body_inertia *= heavier[:, None]
robot.dof_armature[6:], robot.dof_damping[6:], robot.dof_frictionloss[6:] = 0.01, 0.1, 0.2
print(f"the robot has {robot.body_mass.sum():.2f} kg")
for seed, name in enumerate(("train.npz", "test.npz")):
    q, qd, tau, imu, touch = trot(robot, np.random.default_rng(seed))
    flags = {f"{leg}_foot.contact": touch[:, k] > 0 for k, leg in enumerate(LEGS)}
    np.savez(name, t=0.004 * np.arange(len(q)), q=q, qd=qd, tau=tau, imu=imu, **flags)
