"""Modified Denavit-Hartenberg notation (Khalil and Kleinfinger 1986): joint transforms and frames.

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

gamma, b, alpha and d move the z axis of a frame onto any line. theta and r then rotate and shift
the new frame about and along that line. If the lines are not parallel, x is their common normal.

Frames are homogeneous transforms (4, 4), rotations (3, 3), vectors (3,). Their entries are floats
or numbers with 50 digits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.robot.body import Array, screw
from symgen.robot.exact_numbers import TOLERANCE, context
from symgen.robot.types import Robot

#: A point on a joint axis, and its unit direction, both in frame 0.
Line = tuple[Array, Array]
_PARALLEL = 1e-9  # sine of the angle between two axes
#: Sine of an angle between axes below which their common normal can be far outside the robot.
NEARLY_PARALLEL = 0.05
_TOUCH = 1e-12  # m
_TIE = 1e-9  # rad


def frames(robot: Robot, q: dict[int, float]) -> list[NDArray[np.float64]]:
    """Return frame 0 and the frame of every joint in frame 0, (4, 4) each, at joint positions q.

    Args:
        robot: the mechanism, with numeric values.
        q: number of a movable joint -> position, rad or m.
    """
    out = [np.eye(4)]
    for joint in robot.joints:
        at = sum((c * q[k] for k, c in joint.shares), joint.offset)
        slides = joint.slides
        theta, r = joint.theta + (0 if slides else at), joint.r + (at if slides else 0)
        frame = out[joint.antecedent]
        for axis, *lengths in ((2, joint.gamma, joint.b), (0, joint.alpha, joint.d), (2, theta, r)):
            frame = frame @ screw(axis, *map(float, lengths)).astype(float)
        out.append(frame)
    return out


def norm(a: Array) -> Any:
    """Return the length of a vector."""
    return context().sqrt(a @ a)


def turned_by(rotation: Array, within: float = TOLERANCE) -> tuple[Any, Any, Any]:
    """Return roll, pitch and yaw of a rotation.

    If the pitch is a right angle within `within`, only the sum or the difference of roll and yaw is
    defined. Roll is then zero.
    """
    digits, (x, y, z) = context(), rotation.T
    horizontal = digits.hypot(x[0], x[1])
    pitch = digits.atan2(-x[2], horizontal)
    if horizontal < within:
        return digits.mpf(0), pitch, digits.atan2(-y[0], y[1])
    return digits.atan2(y[2], z[2]), pitch, digits.atan2(x[1], x[0])


def nearly_parallel(first: Array, second: Array) -> bool:
    """Return whether two directions are nearly parallel, but not parallel."""
    return bool(_PARALLEL < norm(np.cross(first, second)) < NEARLY_PARALLEL)


def normal(first: Line, second: Line, parallel: float = _PARALLEL) -> Line | None:
    """Return the common normal of two lines: its foot on the first line, and its direction.

    For parallel lines, the foot is the point of the first line. The result is None if the lines
    coincide.

    Args:
        first, second: the lines.
        parallel: sine of the angle up to which lines are parallel.
    """
    (point, along), (other, direction) = first, second
    between, across = other - point, np.cross(along, direction)
    sine = norm(across)
    if sine > parallel:
        return point + along * (np.cross(between, direction) @ across / sine**2), across / sine
    offset = between - along * (between @ along)
    distance = norm(offset)
    return (point, offset / distance) if distance > _TOUCH else None


def crossing(base: Array, line: Line) -> Array:
    """Return a frame (4, 4) between a frame and a line that is nearly parallel to its z axis.

    Its z axis starts in the origin of the frame and meets the line at a right angle. Its origin is
    this point. Both joint transforms through this frame are short.
    """
    point, along = line
    origin = base[:3, 3]
    meeting = point + along * ((origin - point) @ along)
    across = meeting - origin
    if norm(across) <= _TOUCH:
        across = np.cross(along, base[:3, 1])
    frame = np.eye(4, dtype=object)
    frame[:3, 2] = z = across / norm(across)
    frame[:3, 0] = np.cross(z, along)
    frame[:3, 1] = along
    frame[:3, 3] = meeting
    return frame


def row_to_line(base: Array, line: Line) -> tuple[Any, Any, Any, Any]:
    """Return gamma, b, alpha, d that move the z axis of a frame onto a line.

    gamma is in (-pi/2, pi/2]. b is 0 if the lines are parallel.
    """
    digits = context()
    gamma, b = digits.mpf(0), digits.mpf(0)
    x, y, z, origin = base[:3].T
    found = normal((origin, z), line)
    if found is not None:
        foot, common = found
        gamma = half_turn(digits.atan2(common @ y, common @ x))
        x = x * digits.cos(gamma) + y * digits.sin(gamma)
        b = (foot - origin) @ z
    alpha = _turn(np.cross(z, line[1]) @ x, z @ line[1])
    return gamma, b, alpha, (line[0] - origin) @ x


def turn_of(x: Array, before: Array) -> Any:
    """Return theta in (-pi, pi] that rotates the x axis of frame `before` onto x, about z."""
    return _turn(x @ before[:3, 1], x @ before[:3, 0])


def _turn(sine: Any, cosine: Any) -> Any:
    digits = context()
    angle = digits.atan2(sine, cosine)
    return angle + 2 * digits.pi if angle < _TIE - digits.pi else angle


def half_turn(angle: Any) -> Any:
    """Return the angle in (-pi/2, pi/2] of the same line, independent of rounding errors."""
    digits = context()
    if angle > digits.pi / 2 + _TIE:
        return angle - digits.pi
    if angle <= -digits.pi / 2 + _TIE:
        return angle + digits.pi
    return angle
