"""The nominal geometry of a robot: its design, without manufacturing errors.

A calibrated robot has axes that are parallel within 1e-3 rad, and that meet within 1e-3 m. Its
exact geometry separates parameters whose torques differ as little. The nominal geometry does not.
"""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from symgen.robot.exact_numbers import context, fraction_of_pi
from symgen.robot.types import Robot

#: Angles within this of a multiple of pi/24 are rounded to it.
ANGLE = 0.01  # rad
#: Lengths below this share of the reach are zero.
LENGTH = 1e-3


def nominal(robot: Robot) -> Robot:
    """Return the robot with nominal angles and lengths; named ones stay unchanged."""
    shortest = LENGTH * reach(robot)
    joints = tuple(
        replace(
            joint,
            gamma=_angle(joint.gamma),
            alpha=_angle(joint.alpha),
            theta=_angle(joint.theta),
            b=_length(joint.b, shortest),
            d=_length(joint.d, shortest),
            r=_length(joint.r, shortest),
        )
        for joint in robot.joints
    )
    return replace(robot, joints=joints)


def reach(robot: Robot) -> float:
    """Return the length of the longest path from the base to a joint, m; 1 if all are zero."""
    far = {0: 0.0}
    for joint in robot.with_values().joints:
        step = sum(abs(float(length)) for length in (joint.b, joint.d, joint.r))
        far[joint.number] = far[joint.antecedent] + step
    return max(far.values()) or 1.0


def _angle(angle: sp.Expr) -> sp.Expr:
    if angle.free_symbols:
        return angle
    k = fraction_of_pi(context().mpf(float(angle)), ANGLE)
    return angle if k is None else k * sp.pi


def _length(length: sp.Expr, shortest: float) -> sp.Expr:
    if length.free_symbols or abs(float(length)) >= shortest:
        return length
    return sp.S.Zero
