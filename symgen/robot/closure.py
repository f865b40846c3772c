"""Closed chains: whether the two sides of each cut joint stay together in every position.

A loop is opened at one joint, which leaves a tree; a frame (a fixed joint of the file) marks either
side of the cut. The constraint is that their origins and z axes coincide. For parallelograms it
makes the passive joints linear in the active ones, q_p = sum of c q_a + constant, which is what
`follows` declares (Khalil and Kleinfinger 1986; Khalil and Dombre 2002). Here it is checked.
"""

from __future__ import annotations

import math
import random

from symgen import names
from symgen.errors import RobotError
from symgen.robot.types import Joint, Robot

Place = list[list[float]]  # homogeneous transform (4, 4)
_POSITIONS = 5
_GAP = 1e-9  # m, and of unit vectors


def require_closed(robot: Robot) -> None:
    """Check the loops of a robot at its values.

    Raises:
        RobotError: a loop names no frame, or its sides come apart where the joints move.
    """
    if not robot.loops:
        return
    plain = robot.with_values()
    draw = random.Random(1)
    for number, loop in enumerate(robot.loops, 1):
        for j in (loop.first, loop.second):
            if not 1 <= j <= len(robot.joints):
                raise RobotError(f"loop {number}, key 'cut': there is no joint {j}")
        if loop.first == loop.second:
            raise RobotError(f"loop {number}, key 'cut': two different frames are needed")
    for _ in range(_POSITIONS):
        q = {j.number: draw.uniform(-1, 1) for j in plain.movable}
        places = placed(plain, q)
        for number, loop in enumerate(robot.loops, 1):
            first, second = places[loop.first], places[loop.second]
            apart = math.dist([row[3] for row in first[:3]], [row[3] for row in second[:3]])
            turned = math.dist([row[2] for row in first[:3]], [row[2] for row in second[:3]])
            if max(apart, turned) > _GAP:
                what = f"{apart:.3g} m" if apart > _GAP else f"{math.degrees(turned):.3g} degrees"
                raise RobotError(
                    f"loop {number}: frames {loop.first} and {loop.second} come apart by {what} "
                    "where the joints move; accepted: loops that close with passive joints linear "
                    "in the active ones, as parallelograms do (key 'follows' of a joint)"
                )


def placed(robot: Robot, q: dict[int, float]) -> dict[int, Place]:
    """Return the transforms 0T_j at a position, in floating point."""
    out: dict[int, Place] = {0: [[float(i == k) for k in range(4)] for i in range(4)]}
    for joint in robot.joints:
        at = sum(float(c) * q[k] for k, c in joint.shares) + float(joint.offset)
        out[joint.number] = _product(out[joint.antecedent], _transform(joint, at))
    return out


def _transform(joint: Joint, q: float) -> Place:
    """Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)."""
    theta = float(joint.theta) + (q if joint.sigma == names.REVOLUTE else 0.0)
    r = float(joint.r) + (q if joint.sigma == names.PRISMATIC else 0.0)
    first = _screw(2, float(joint.gamma), float(joint.b))
    second = _screw(0, float(joint.alpha), float(joint.d))
    return _product(_product(first, second), _screw(2, theta, r))


def _screw(axis: int, angle: float, length: float) -> Place:
    """Rotation about an axis and translation along it."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out = [[float(i == k) for k in range(4)] for i in range(4)]
    out[a][a] = out[b][b] = math.cos(angle)
    out[b][a] = math.sin(angle)
    out[a][b] = -out[b][a]
    out[axis][3] = length
    return out


def _product(A: Place, B: Place) -> Place:
    return [[sum(A[i][k] * B[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
