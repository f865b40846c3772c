"""Angles that are close to a multiple of pi/24, and add base parameters because of the difference.

If axes are exactly parallel or perpendicular, some parameters have no effect. An angle of 1.571
instead of pi/2 adds them to the base parameters, and no log determines them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import sympy as sp

from symgen.errors import IdentificationError
from symgen.robot import exact_numbers
from symgen.robot.expressions import text
from symgen.robot.types import ANGLES, Joint, Robot
from symgen.symbolic.base_parameters import count_base

_NEAR = 0.01  # rad: what is farther off is meant so


def costly_angles(robot: Robot) -> tuple[str, ...]:
    """Return a line for every angle near a multiple of pi/24 that adds base parameters.

    symgen counts the base parameters with all such angles at their multiples, and with each angle
    as the file has it.
    """
    plain = robot.with_values()
    near = [
        (joint.number, key, fraction)
        for joint in plain.joints
        for key in ANGLES
        if (fraction := _fraction(joint, key)) is not None
    ]
    least = count_base(_with(plain, near)) if near else 0
    lines = []
    for one in near:
        number, key, fraction = one
        more = count_base(_with(plain, [other for other in near if other is not one])) - least
        if more > 0:
            angle = getattr(plain.joint(number), key)
            lines.append(_line(robot.label(number), key, angle, fraction, more))
    return tuple(lines)


@contextmanager
def told_of_angles(robot: Robot) -> Iterator[None]:
    """Add the angles that add base parameters to an error about undetermined parameters.

    Raises:
        IdentificationError: the data do not determine the parameters.
    """
    try:
        yield
    except IdentificationError as error:
        lines = costly_angles(robot)
        if not lines:
            raise
        raise IdentificationError("; ".join((str(error), *lines))) from error


def _fraction(joint: Joint, key: str) -> sp.Expr | None:
    """Return the multiple of pi/24 that a constant angle is near, without being equal to it."""
    if key == "theta" and joint.turns:  # where q is counted from
        return None
    angle = getattr(joint, key)
    k = round(float(angle) * exact_numbers.PARTS / math.pi)
    fraction = sp.Rational(k, exact_numbers.PARTS) * sp.pi
    gap = abs(float((angle - fraction).evalf(30)))
    return fraction if 0 < gap < _NEAR else None


def _with(robot: Robot, angles: Sequence[tuple[int, str, sp.Expr]]) -> Robot:
    """Return a robot with some of its constant angles replaced."""
    new = {joint.number: joint for joint in robot.joints}
    for number, key, angle in angles:
        new[number] = replace(new[number], **{key: angle})
    return replace(robot, joints=tuple(new.values()))


def _line(label: str, key: str, angle: sp.Expr, fraction: sp.Expr, more: int) -> str:
    value, meant = float(angle), text(fraction)
    cost = "one more base parameter" if more == 1 else f"{more} more base parameters"
    return (
        f"{label}: {key} is {value:.9g} rad, "
        f"{abs(value - float(fraction)):.2g} rad from {meant}, which costs {cost}; if {meant} is "
        "meant, write it in the robot file"
    )
