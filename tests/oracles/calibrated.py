"""URDFs of library robots as a calibration leaves them: no axis is parallel to another.

The pose of every joint comes from the table of the robot. A small rotation and a small shift are
added to each, as text with all digits.
"""

from __future__ import annotations

import math

import numpy as np

from symgen.robot.types import Robot


def calibrated_urdf(robot: Robot, rotation: float = 0.0, shift: float = 0.0, seed: int = 0) -> str:
    """Return the URDF of a serial arm or a tree without joints that follow others.

    Args:
        robot: the mechanism, whose joints have numbers as names: j1, j2, ...
        rotation: standard deviation of roll, pitch and yaw of every origin, rad.
        shift: standard deviation of the coordinates of every origin, m.
        seed: of these errors; the links are always the same.
    """
    errors, bodies = np.random.default_rng(seed), np.random.default_rng(1)
    parts = ['<link name="link0"/>']
    for joint in robot.with_values().joints:
        T = _transform(*(float(getattr(joint, key)) for key in _KEYS))
        xyz = T[:3, 3] + shift * errors.standard_normal(3)
        rpy = _angles(T) + rotation * errors.standard_normal(3)
        parts.append(
            f'<joint name="j{joint.number}" type="{_TYPES[joint.sigma]}">'
            f'<parent link="link{joint.antecedent}"/><child link="link{joint.number}"/>'
            f'<origin xyz="{_words(xyz)}" rpy="{_words(rpy)}"/><axis xyz="0 0 1"/>'
            '<limit lower="-3" upper="3" velocity="2" effort="100"/></joint>'
        )
        parts.append(_link(joint.number, bodies))
    return f'<robot name="{robot.name}">\n' + "\n".join(parts) + "\n</robot>\n"


_KEYS = ("gamma", "b", "alpha", "d", "theta", "r")
_TYPES = ("continuous", "prismatic", "fixed")


def _link(number: int, draw: np.random.Generator) -> str:
    mass, com = draw.uniform(1, 5), draw.uniform(-0.2, 0.2, 3)
    xx, yy, zz = mass * 0.01 * draw.uniform(0.7, 1.0, 3)
    return (
        f'<link name="link{number}"><inertial><origin xyz="{_words(com)}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _words(numbers: np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def _transform(
    gamma: float, b: float, alpha: float, d: float, theta: float, r: float
) -> np.ndarray:
    def along(axis: int, angle: float, length: float) -> np.ndarray:
        c, s = math.cos(angle), math.sin(angle)
        T, (i, j) = np.eye(4), ((1, 2) if axis == 0 else (0, 1))
        T[i, i], T[i, j], T[j, i], T[j, j] = c, -s, s, c
        T[axis, 3] = length
        return T

    return along(2, gamma, b) @ along(0, alpha, d) @ along(2, theta, r)


def _angles(T: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw; multiples of pi/24 are exact in double."""
    pitch = math.atan2(-T[2, 0], math.hypot(T[0, 0], T[1, 0]))
    if abs(abs(pitch) - math.pi / 2) < 1e-9:
        out = np.array([0.0, pitch, math.atan2(-T[0, 1], T[1, 1])])
    else:
        out = np.array([math.atan2(T[2, 1], T[2, 2]), pitch, math.atan2(T[1, 0], T[0, 0])])
    steps = np.round(out * 24 / math.pi) * math.pi / 24
    return np.where(np.abs(out - steps) < 1e-9, steps, out)
