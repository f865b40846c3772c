"""Check of closed chains: both sides of each cut joint must coincide in every position.

Cutting each loop at one joint leaves a tree. Two frames (fixed joints of the file) mark the sides
of the cut. Their origins and z axes must coincide. In a parallelogram, the passive joints are then
linear in the active ones, q_p = sum of c q_a + constant. `follows` declares this (Khalil and
Kleinfinger 1986; Khalil and Dombre 2002).
"""

from __future__ import annotations

import math
import random

from symgen.errors import RobotError
from symgen.robot import dh
from symgen.robot.types import Robot

_POSITIONS = 5
_GAP = 1e-9  # m, and of unit vectors


def require_closed(robot: Robot) -> None:
    """Check the loops of a robot at random positions.

    Raises:
        RobotError: the sides of a loop separate as the joints move.
    """
    if not robot.loops:
        return
    plain, draw = robot.with_values(), random.Random(1)
    for _ in range(_POSITIONS):
        places = dh.frames(plain, {j.number: draw.uniform(-1, 1) for j in plain.movable})
        for number, loop in enumerate(robot.loops, 1):
            first, second = (places[j] for j in loop.cut)
            turned, distance = (math.dist(first[:3, k], second[:3, k]) for k in (2, 3))
            if max(distance, turned) > _GAP:
                what = (
                    f"{distance:.3g} m"
                    if distance > _GAP
                    else f"{math.degrees(turned):.3g} degrees"
                )
                raise RobotError(
                    f"loop {number}: frames {loop.cut[0]} and {loop.cut[1]} separate by {what} "
                    "as the joints move; accepted: loops that close with passive joints linear "
                    "in the active ones, as parallelograms do (key 'follows' of a joint)"
                )
