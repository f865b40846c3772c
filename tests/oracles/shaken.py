"""An arm in MuJoCo on a base that is shaken, with the IMU of the base, and on one that rests."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

#: Standard deviations of a common IMU (Bosch BMI088) at 250 Hz: its noise densities of
#: 175 ug/sqrt(Hz) and 0.014 deg/s/sqrt(Hz) up to 125 Hz; m/s2 and rad/s.
ACCELEROMETER, GYROSCOPE = 0.019, 0.0027
STEP = 0.004  # s
ENCODER, TORQUE = 1e-5, 0.05  # rad; N m

#: The arm, in the frame of its base.
ARM = """
<body name="l1" pos="0 0 0.2"><joint name="j1" axis="0 0 1" armature="0.05" damping="0.4"
  frictionloss="0.3"/><inertial pos="0.02 0.01 0.1" mass="3" diaginertia="0.03 0.025 0.02"/>
 <body name="l2" pos="0 0.05 0.2"><joint name="j2" axis="0 1 0" armature="0.05" damping="0.5"
   frictionloss="0.4"/><inertial pos="0.15 0.03 -0.02" mass="2.5" diaginertia="0.01 0.04 0.05"/>
  <body name="l3" pos="0.35 0 0"><joint name="j3" axis="0 1 0" armature="0.03" damping="0.3"
    frictionloss="0.2"/><inertial pos="0.1 -0.02 0.03" mass="1.5" diaginertia="0.004 0.015 0.013"/>
   <body name="l4" pos="0.25 0 0.05"><joint name="j4" axis="1 0 0" armature="0.01" damping="0.1"
     frictionloss="0.1"/><inertial pos="0.03 0.04 0.02" mass="0.8"
     diaginertia="0.002 0.003 0.0025"/></body></body></body></body>
"""
FIXED = f"<mujoco><worldbody>{ARM}</worldbody></mujoco>"
MOVING = f"""
<mujoco><worldbody><body name="base"><freejoint/><inertial pos="0 0 0" mass="20"
 diaginertia="1 1 1"/><site name="imu"/>{ARM}</body></worldbody>
<sensor><accelerometer site="imu"/><gyro site="imu"/></sensor></mujoco>
"""


def waves(t: np.ndarray, size: np.ndarray, fastest: float, draw: np.random.Generator) -> np.ndarray:
    """Sums of five sines with their first two derivatives, (3, N, k)."""
    rate = 2 * np.pi * draw.uniform(0.1, fastest, (5, len(size)))
    phase, share = draw.uniform(0, 2 * np.pi, (2, 5, len(size)))
    share = size * share / share.sum(axis=0)
    angle = rate * t[:, None, None] + phase
    slopes = np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)
    return np.array([np.sum(share * x, axis=1) for x in slopes])


def turned(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quaternion (w first), angular velocity and acceleration in the axes of the body.

    Args:
        angles: (3, N, 3) roll, pitch and yaw of Rot(z) Rot(y) Rot(x), with two derivatives.
    """
    (a, b, c), rates, faster = (x.T for x in angles)
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    da, db, _ = rates
    none, one = np.zeros_like(a), np.ones_like(a)
    E = np.array([[one, none, -sb], [none, ca, cb * sa], [none, -sa, cb * ca]])
    dE = np.array(
        [
            [none, none, -cb * db],
            [none, -sa * da, cb * ca * da - sb * sa * db],
            [none, -ca * da, -cb * sa * da - sb * ca * db],
        ]
    )
    w = np.einsum("ikt,kt->ti", E, rates)
    wd = np.einsum("ikt,kt->ti", dE, rates) + np.einsum("ikt,kt->ti", E, faster)
    quaternion = Rotation.from_euler("ZYX", np.column_stack([c, b, a])).as_quat()
    return np.roll(quaternion, 1, axis=1), w, wd


def recorded(
    seed: int, seconds: float = 30.0, *, moves: bool, dry: bool = True, noisy: bool = True
) -> dict[str, np.ndarray]:
    """A log of the arm: t, q, qd, tau, and imu on a base that moves.

    The base moves by decimetres and turns by tenths of a radian, at up to 1.5 Hz.

    Args:
        seed: of the motion and the noise.
        seconds: length of the log.
        moves: whether the base moves.
        dry: whether joints have dry friction.
        noisy: whether sensors have noise.
    """
    import mujoco

    draw = np.random.default_rng(seed)
    t = np.arange(0, seconds, STEP)
    joints = waves(t, np.array([1.8, 1.2, 1.5, 2.0]), 0.8, draw)
    place = waves(t, np.full(3, 0.15), 1.5, draw)
    pose, w, wd = turned(waves(t, np.full(3, 0.3), 1.0, draw))
    model = mujoco.MjModel.from_xml_string(MOVING if moves else FIXED)
    if not dry:
        model.dof_frictionloss[:] = 0
    data = mujoco.MjData(model)
    tau, imu = np.zeros((len(t), 4)), np.zeros((len(t), 6))
    for k in range(len(t)):
        at, speed, rate = (joints[i, k] for i in range(3))
        if moves:
            at = np.concatenate([place[0, k], pose[k], at])
            speed = np.concatenate([place[1, k], w[k], speed])
            rate = np.concatenate([place[2, k], wd[k], rate])
        data.qpos[:], data.qvel[:], data.qacc[:] = at, speed, rate
        mujoco.mj_inverse(model, data)
        tau[k] = data.qfrc_inverse[-4:]
        if moves:
            imu[k] = data.sensordata
    log = {"t": t, "q": joints[0], "qd": joints[1], "tau": tau} | ({"imu": imu} if moves else {})
    return with_noise(log, draw) if noisy else log


def with_noise(log: dict[str, np.ndarray], draw: np.random.Generator) -> dict[str, np.ndarray]:
    """The log as sensors measure it."""
    noise, log = np.repeat([ACCELEROMETER, GYROSCOPE], 3), dict(log)
    sizes = {"q": ENCODER, "qd": 50 * ENCODER, "tau": TORQUE, "imu": noise}
    for key in (key for key in sizes if key in log):
        log[key] = log[key] + sizes[key] * draw.normal(size=log[key].shape)
    return log
