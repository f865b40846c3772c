"""Frames of Khalil and Kleinfinger on axes that stand anywhere.

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

gamma, b, alpha and d carry the z axis of one frame onto any line, with its direction; theta and r
then turn and shift the new frame about and along that line. Where the lines are not parallel, x is
their common normal (Khalil and Kleinfinger 1986). All numbers have 50 digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from symgen.robot.recognition import TOLERANCE, context

Vector = tuple[Any, Any, Any]
Matrix = tuple[Vector, Vector, Vector]
_PARALLEL = 1e-9  # sine of the angle of two axes
_TOUCH = 1e-12  # m
_TIE = 1e-9  # rad


def dot(a: Vector, b: Vector) -> Any:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def plus(a: Vector, b: Vector, factor: Any = 1) -> Vector:
    """Return a + factor b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2])


def norm(a: Vector) -> Any:
    """Return the length of a vector."""
    return context().sqrt(dot(a, a))


def scaled(a: Vector, factor: Any) -> Vector:
    """Return factor a."""
    return (factor * a[0], factor * a[1], factor * a[2])


@dataclass(frozen=True)
class Pose:
    """A frame in another: its axes and its origin."""

    x: Vector
    y: Vector
    z: Vector
    origin: Vector

    def turned(self, v: Vector) -> Vector:
        """Return a vector of this frame in the other one."""
        return plus(plus(scaled(self.x, v[0]), self.y, v[1]), self.z, v[2])

    def point(self, p: Vector) -> Vector:
        """Return a point of this frame in the other one."""
        return plus(self.turned(p), self.origin)

    def tensor(self, rows: Matrix) -> Matrix:
        """Return a symmetric tensor of this frame in the other one: R I R'."""
        half = [self.turned(row) for row in rows]  # I R'
        turned = [self.turned((half[0][i], half[1][i], half[2][i])) for i in range(3)]
        return turned[0], turned[1], turned[2]

    def times(self, pose: Pose) -> Pose:
        """Return a frame that stands in this one, in the other one."""
        x, y, z = (self.turned(axis) for axis in (pose.x, pose.y, pose.z))
        return Pose(x, y, z, self.point(pose.origin))

    def inverse(self) -> Pose:
        """Return the other frame in this one."""
        axes = (self.x, self.y, self.z)
        x, y, z = ((axes[0][i], axes[1][i], axes[2][i]) for i in range(3))
        back = (dot(self.x, self.origin), dot(self.y, self.origin), dot(self.z, self.origin))
        return Pose(x, y, z, scaled(back, -1))


def identity() -> Pose:
    """Return the frame that is the other one."""
    one, zero = context().mpf(1), context().mpf(0)
    return Pose((one, zero, zero), (zero, one, zero), (zero, zero, one), (zero, zero, zero))


def screw(axis: int, angle: Any, distance: Any) -> Pose:
    """Return Rot(axis, angle) Trans(axis, distance), axes numbered from 0."""
    digits = context()
    c, s, zero = digits.cos(angle), digits.sin(angle), digits.mpf(0)
    k, a, b = axis, (axis + 1) % 3, (axis + 2) % 3
    columns = [[zero] * 3 for _ in range(4)]
    columns[k][k] = digits.mpf(1)
    columns[a][a], columns[a][b] = c, s
    columns[b][a], columns[b][b] = -s, c
    columns[3][k] = digits.mpf(distance)
    x, y, z, origin = ((v[0], v[1], v[2]) for v in columns)
    return Pose(x, y, z, origin)


def turn(roll: Any, pitch: Any, yaw: Any) -> Pose:
    """Return Rot(z, yaw) Rot(y, pitch) Rot(x, roll)."""
    return screw(2, yaw, 0).times(screw(1, pitch, 0)).times(screw(0, roll, 0))


def turned_by(x: Vector, y: Vector, z: Vector) -> Vector:
    """Return roll, pitch and yaw of the frame with these axes.

    Where pitch is a right angle within TOLERANCE, only the sum or the difference of roll and yaw
    shows, and roll is zero.
    """
    digits = context()
    level = digits.hypot(x[0], x[1])
    pitch = digits.atan2(-x[2], level)
    if level < TOLERANCE:
        return digits.mpf(0), pitch, digits.atan2(-y[0], y[1])
    return digits.atan2(y[2], z[2]), pitch, digits.atan2(x[1], x[0])


@dataclass(frozen=True)
class Line:
    """A joint axis: a point and a unit direction, in frame 0."""

    point: Vector
    direction: Vector


def normal(first: Line, second: Line) -> tuple[Vector, Vector] | None:
    """Return the direction of the common normal and its foot on the first line.

    The foot on parallel lines is the first one's point. None where the lines are one.
    """
    between = plus(second.point, first.point, -1)
    across = cross(first.direction, second.direction)
    sine = norm(across)
    if sine > _PARALLEL:
        along = dot(cross(between, second.direction), across) / sine**2
        foot = plus(first.point, first.direction, along)
        return scaled(across, 1 / sine), foot
    apart = plus(between, first.direction, -dot(between, first.direction))
    distance = norm(apart)
    if distance > _TOUCH:
        return scaled(apart, 1 / distance), first.point
    return None


def parallel(first: Line, second: Line) -> bool:
    """Whether two axes have one direction, or opposite ones."""
    return bool(norm(cross(first.direction, second.direction)) <= _PARALLEL)


def reach(base: Pose, line: Line) -> tuple[Any, Any, Any, Any]:
    """Return gamma, b, alpha, d that carry the z axis of a frame onto a line.

    gamma is in (-pi/2, pi/2]; of parallel lines b is 0.
    """
    digits = context()
    zero = digits.mpf(0)
    z = Line(base.origin, base.z)
    found = normal(z, line)
    gamma, b, x = zero, zero, base.x
    if found is not None:
        x, foot = found
        gamma = half_turn(digits.atan2(dot(x, base.y), dot(x, base.x)))
        x = plus(scaled(base.x, digits.cos(gamma)), base.y, digits.sin(gamma))
        b = dot(plus(foot, base.origin, -1), base.z)
    alpha = _turn(dot(cross(base.z, line.direction), x), dot(base.z, line.direction))
    d = dot(plus(line.point, base.origin, -1), x)
    return gamma, b, alpha, d


def turn_of(x: Vector, before: Pose) -> Any:
    """Return theta in (-pi, pi], which turns the x axis of a frame into another about z."""
    return _turn(dot(x, before.y), dot(x, before.x))


def _turn(sine: Any, cosine: Any) -> Any:
    digits = context()
    angle = digits.atan2(sine, cosine)
    return angle + 2 * digits.pi if angle < _TIE - digits.pi else angle


def half_turn(angle: Any) -> Any:
    """Return the angle in (-pi/2, pi/2] of the same line; ties do not depend on the last digits."""
    digits = context()
    if angle > digits.pi / 2 + _TIE:
        return angle - digits.pi
    if angle <= -digits.pi / 2 + _TIE:
        return angle + digits.pi
    return angle
