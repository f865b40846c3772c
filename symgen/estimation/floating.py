"""A base that moves: its motion, and the forces on its robot.

The motion of the base is f = a - g, w and wd of the origin of frame 0, in the axes of frame 0. Logs
have it from an IMU, which may stand at another place, or as a pose. A robot with a floating base
has six equations before those of its joints. Forces on its links enter all of them:

    tau = [0; tau_joints] + sum over frames of J' [R F; R M]

with the measured wrench F, M of a frame and its Jacobian J. The forces at declared contacts are not
measured. They have no part in the rows P tau, with the projector of each sample

    P = I - J' (J J')^-1 J

and J the velocities of the points and surfaces in contact. Both sides of the equations are
projected before any filter. The force on a round foot acts on the ground below its centre, at
-radius u, with u the direction against gravity in the axes of frame 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from symgen.data.log import Log
from symgen.data.raw import Bools
from symgen.data.signals import Samples, differentiate, lowpass, lowpass_and_slopes
from symgen.estimation.band import Band
from symgen.estimation.values import FloatArray
from symgen.names import WRENCH_ENDS
from symgen.robot.body import turn
from symgen.robot.tables import Frame, Mount
from symgen.robot.types import Robot
from symgen.symbolic.placement import frames_tape, link_jacobian_tape, selected_link
from symgen.symbolic.sampling import columns_at
from symgen.symbolic.tape import Tape

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

#: Samples that are evaluated at once.
_CHUNK = 1 << 13
#: Share of J J' by which contacts that depend on each other are apart.
_RIDGE = 1e-12
#: Flag of a contact above which it touches.
HALF = 0.5
_BASE = 6  # equations of the base
_SECONDS = 10.0  # over which the mean of a specific force points upward


def base_motion(samples: Samples, band: Band) -> tuple[FloatArray, ...]:
    """Return specific force, angular velocity and acceleration of the base, (N, 3) each.

    They pass the filter of the speeds. Without a log of the base, there are none.
    """
    if samples.pose is not None:
        return _motion_of_pose(samples, band)
    if samples.imu is None:
        return ()
    force, w = np.hsplit(samples.imu, 2)
    if band.filters(samples.step):
        force = lowpass(force, samples.step, band.cutoff_hz)
        w, wd = lowpass_and_slopes(w, samples.step, band.cutoff_hz, 1)
    else:
        wd = differentiate(w, samples.step)
    mount = None if samples.robot is None else samples.robot.mount
    return (force, w, wd) if mount is None else _at_origin(force, w, wd, mount)


def _at_origin(
    force: FloatArray, w: FloatArray, wd: FloatArray, mount: Mount
) -> tuple[FloatArray, ...]:
    """Return the motion of frame 0 from that of an IMU at another place.

    f0 = R f - wd x r - w x (w x r)
    """
    turned = np.asarray(turn(*mount.rotation), dtype=np.float64)
    force, w, wd = (np.ascontiguousarray(x @ turned.T) for x in (force, w, wd))
    r = np.array(mount.position)
    return force - np.cross(wd, r) - np.cross(w, np.cross(w, r)), w, wd


def _motion_of_pose(samples: Samples, band: Band) -> tuple[FloatArray, ...]:
    """Return the motion of the base from its pose p, Q in the world.

    f = R(Q)' (p'' - g), w = 2 Im(Q* Q') / |Q|^2
    """
    assert samples.pose is not None
    assert samples.robot is not None
    step = samples.step
    if band.filters(step):
        x, rate, bend = lowpass_and_slopes(samples.pose, step, band.cutoff_hz, 2)
    else:
        x, rate = samples.pose, differentiate(samples.pose, step)
        bend = differentiate(rate, step)
    gravity = [float(g) for g in samples.robot.with_values().gravity]
    s, v = x[:, 3:4], x[:, 4:]
    ds, dv = rate[:, 3:4], rate[:, 4:]
    square = s**2 + np.sum(v**2, axis=1, keepdims=True)
    w = 2 * (s * dv - ds * v - np.cross(v, dv)) / square
    pull = bend[:, :3] - gravity
    across = np.cross(pull, v)  # of the inverse rotation
    force = pull + 2 * (s * across + np.cross(across, v)) / square
    return force, w, differentiate(w, step)


@lru_cache(maxsize=8)
def _tapes(robot: Robot) -> tuple[Tape, Tape]:
    """Return the tapes of a point's Jacobian and of all frames."""
    return link_jacobian_tape(robot), frames_tape(robot)


def frame_jacobian(robot: Robot, frame: Frame, q: FloatArray) -> FloatArray:
    """Return the Jacobian of a frame's origin in the axes of frame 0, (k, 6, m).

    Args:
        robot: a robot with a floating base and numbers for its lengths.
        frame: the frame.
        q: (k, n) positions.
    """
    link = selected_link(robot, frame.joint)
    inputs = {"q": list(q.T), "link": link, "point": list(frame.xyz)}
    tape, _ = _tapes(robot)
    return columns_at(tape, {}, inputs, len(q)).reshape(len(q), _BASE, -1)


def _axes(robot: Robot, frame: Frame, q: FloatArray) -> FloatArray:
    """Return the axes of a frame in those of frame 0, (k, 3, 3)."""
    turned = np.array(frame.transform)[:3, :3]
    if frame.joint == 0:
        return np.broadcast_to(turned, (len(q), 3, 3))
    _, tape = _tapes(robot)
    of_links = columns_at(tape, {}, {"q": list(q.T)}, len(q)).reshape(len(q), -1, 4, 4)
    return np.asarray(of_links[:, frame.joint - 1, :3, :3] @ turned)


def upward(log: Log, robot: Robot) -> FloatArray:
    """Return the direction against gravity in the axes of frame 0, (N, 3).

    With an IMU, the angular velocity turns the specific force into the axes of the first sample.
    There, its mean over some seconds points upward, because accelerations cancel.

    Args:
        log: a log with the motion of the base.
        robot: the robot.
    """
    from scipy.signal import savgol_filter
    from scipy.spatial.transform import Rotation

    if log.pose is not None:
        attitude = Rotation.from_quat(log.pose[:, [4, 5, 6, 3]])
        gravity = np.array([float(g) for g in robot.with_values().gravity])
        return np.asarray(attitude.inv().apply(-gravity / np.linalg.norm(gravity)))
    assert log.imu is not None
    force, w = np.hsplit(log.imu.copy(), 2)
    if robot.mount is not None:
        turned = np.asarray(turn(*robot.mount.rotation), dtype=np.float64)
        force, w = force @ turned.T, w @ turned.T
    step = float(np.median(np.diff(log.t)))
    attitude = chained(Rotation.from_rotvec(step * w))
    window = min(round(_SECONDS / step), len(w) // 2) // 2 * 2 + 1
    mean = savgol_filter(attitude.apply(force), window, 1, axis=0)
    up = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    return np.asarray(attitude.inv().apply(up))


def chained(turns: Rotation) -> Rotation:
    """Return the products of the first turns: of one, of two, and so on."""
    step = 1
    while step < len(turns):
        later = turns[:-step] * turns[step:]
        turns = turns.concatenate([turns[:step], later])
        step *= 2
    return turns


def contact_jacobian(samples: Samples, q: FloatArray) -> FloatArray | None:
    """Return J at samples, (k, c, m), with rows of zeros for contacts that do not touch.

    None if no contact has an unknown force.

    Args:
        samples: k samples.
        q: (k, n) their positions.
    """
    flags, robot = touching(samples), samples.robot
    if flags is None or robot is None:
        return None
    robot, parts = robot.with_values(), []
    for contact, active in zip(robot.contacts, flags.T, strict=True):
        J = frame_jacobian(robot, robot.frame(contact.frame), q)
        if contact.radius and samples.up is not None:
            below = -contact.radius * samples.up
            J[:, :3] += np.cross(J[:, 3:], below[:, :, None], axis=1)
        parts.append(J[:, : contact.rows] * active[:, None, None])
    return np.concatenate(parts, axis=1)


def touching(samples: Samples) -> Bools | None:
    """Return which contacts have an unknown force, (N, C); None if none ever has one."""
    robot = samples.robot
    if samples.touches is None or robot is None:
        return None
    flags = samples.touches > HALF
    known = {frame.name for frame, _ in _wrenches(samples)}
    flags &= [contact.frame not in known for contact in robot.contacts]
    return flags if flags.any() else None


def _wrenches(samples: Samples) -> Iterator[tuple[Frame, FloatArray]]:
    """Yield the frames with a measured wrench, and the wrench, (N, 6)."""
    if samples.forces is None or samples.robot is None:
        return
    wrenches = samples.forces.reshape(len(samples.t), -1, len(WRENCH_ENDS)).swapaxes(0, 1)
    for frame, wrench in zip(samples.robot.frames, wrenches, strict=False):
        if not np.isnan(wrench[0, 0]):
            yield frame, wrench


def projected(x: FloatArray, J: FloatArray | None) -> FloatArray:
    """Return P x for (k, m, ...), with J (k, c, m); x itself without contacts."""
    if J is None:
        return x
    columns = x.reshape(*x.shape[:2], -1)
    across = J.swapaxes(1, 2)
    gram = J @ across
    size = np.trace(gram, axis1=1, axis2=2)[:, None]
    at = np.arange(gram.shape[1])
    gram[:, at, at] += np.where(gram[:, at, at] > 0, _RIDGE * size, 1.0)
    out = columns - across @ np.linalg.solve(gram, J @ columns)
    return np.asarray(out.reshape(x.shape))


def measured_forces(samples: Samples, q: FloatArray) -> FloatArray:
    """Return what is measured in each equation of a floating base, projected, (N, m).

    Args:
        samples: the log.
        q: (N, n) smooth positions.
    """
    count = len(samples.t)
    out = np.concatenate([np.zeros((count, _BASE)), samples.tau], axis=1)
    for first in range(0, count, _CHUNK):
        at = slice(first, first + _CHUNK)
        some = samples.cut(at)
        out[at] += _of_wrenches(some, q[at])
        out[at] = projected(out[at], contact_jacobian(some, q[at]))
    return out


def _of_wrenches(samples: Samples, q: FloatArray) -> FloatArray:
    """Return the generalised forces of the measured wrenches, (k, m)."""
    total = np.zeros((len(q), _BASE + q.shape[1]))
    if samples.robot is None:
        return total
    robot = samples.robot.with_values()
    for frame, wrench in _wrenches(samples):
        axes = _axes(robot, frame, q)
        in_base = axes[:, None] @ wrench.reshape(-1, 2, 3, 1)
        J = frame_jacobian(robot, frame, q)
        total += np.einsum("kcm,kc->km", J, in_base.reshape(-1, _BASE))
    return total
