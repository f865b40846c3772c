"""Numeric frames and rigid bodies, and the identified values that a robot file can contain.

Frames are homogeneous transforms (4, 4), rotations (3, 3), vectors (3,). Their entries are floats
or numbers with 50 digits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.robot.exact_numbers import context

FloatArray = NDArray[np.float64]
Array = NDArray[Any]
#: Parameter of a coupling -> its loss, in the order of `CouplingDynamics`.
COUPLING = {"IAM": "armature", "FVM": "damping", "FSM": "frictionloss"}


def screw(axis: int, angle: Any, distance: Any) -> Array:
    """Return Rot(axis, angle) Trans(axis, distance), axes numbered from 0.

    A float angle gives floats; any other angle gives 50 digits.
    """
    numbers = math if isinstance(angle, float) else context()
    c, s, out = numbers.cos(angle), numbers.sin(angle), np.eye(4, dtype=object)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    out[axis, 3] = distance
    return out


def pose(turned: Array, origin: Array | Sequence[float]) -> Array:
    """Return the frame (4, 4) of a rotation matrix and an origin."""
    out = np.eye(4, dtype=object)
    out[:3, :3], out[:3, 3] = turned, origin
    return out


def inverse(frame: Array) -> Array:
    """Return the inverse of a homogeneous transform."""
    back = frame[:3, :3].T
    return pose(back, -back @ frame[:3, 3])


def turn(roll: Any, pitch: Any, yaw: Any) -> Array:
    """Return the rotation Rot(z, yaw) Rot(y, pitch) Rot(x, roll)."""
    z, y, x = (screw(k, angle, 0)[:3, :3] for k, angle in ((2, yaw), (1, pitch), (0, roll)))
    return z @ y @ x


@dataclass(frozen=True, eq=False)
class Body:
    """One link in the frame of its joint (modified Denavit-Hartenberg).

    Attributes:
        joint: number of the joint in the file. A payload is part of its link.
        mass: mass, kg.
        com: centre of mass (3,), m.
        inertia: inertia matrix (3, 3) about the centre of mass, kg m2. Entry (0, 1) is
            -integral of x y dm.
    """

    joint: int
    mass: float
    com: Array
    inertia: Array

    def moved(self, placed: Array) -> Body:
        """Return the body in another frame, in which its present frame is `placed`, (4, 4)."""
        R = placed[:3, :3]
        return replace(self, com=R @ self.com + placed[:3, 3], inertia=R @ self.inertia @ R.T)

    @property
    def standard(self) -> list[Any]:
        """XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame."""
        J = self.inertia + steiner(self.mass, self.com)
        return [*J[np.triu_indices(3)], *(self.mass * self.com), self.mass]


def steiner(mass: Any, at: Array) -> Array:
    """Return M (c'c 1 - c c'), the inertia of a point mass at c (Huygens and Steiner)."""
    return np.asarray(mass * (at @ at * np.eye(3, dtype=at.dtype) - np.outer(at, at)))


def pseudo_inertia(link: Sequence[float] | FloatArray) -> FloatArray:
    """Return the pseudo-inertia (4, 4) of a link, the integral of x x' dm over x = (r, 1).

    Args:
        link: XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the frame, (10,).
    """
    J, m, M = link_matrices(link)
    out = np.zeros((4, 4))
    out[:3, :3] = np.trace(J) / 2 * np.eye(3) - J
    out[:3, 3] = out[3, :3] = m
    out[3, 3] = M
    return out


def link_matrices(link: Sequence[float] | FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return J (3, 3), m (3,) and M of ten link parameters; see `pseudo_inertia`."""
    J = np.zeros((3, 3))
    J[np.triu_indices(3)] = link[:6]
    J += np.triu(J, 1).T
    return J, np.array(link[6:9], dtype=float), float(link[9])


def merge_bodies(bodies: Sequence[Body]) -> Body:
    """Return bodies in one frame as one body."""
    if len(bodies) == 1:
        return bodies[0]
    mass = sum(b.mass for b in bodies)
    com = np.sum([b.mass * b.com for b in bodies], axis=0) / (mass or 1.0)
    inertia = np.sum([b.inertia + steiner(b.mass, b.com - com) for b in bodies], axis=0)
    return Body(bodies[0].joint, mass, com, inertia)


@dataclass(frozen=True)
class JointDynamics:
    """Motor torque of one joint, without that of the links.

        tau = armature qdd + frictionloss sign(qd) + damping qd + stiffness (q - springref)
              + d1 qd |qd| + d2 qd^3 + s1 (q - springref)^2 + s2 (q - springref)^3

    Attributes:
        joint: number of the joint in the file.
        armature: inertia of the rotor on the joint side, kg m2 or kg.
        damping: viscous friction, N m s/rad or N s/m.
        frictionloss: Coulomb friction, N m or N.
        stiffness: stiffness of a spring, N m/rad or N/m.
        springref: position of the joint at which the spring has no torque, rad or m.
        damping_2, damping_3, stiffness_2, stiffness_3: d1, d2, s1 and s2.
    """

    joint: int
    armature: float = 0.0
    damping: float = 0.0
    frictionloss: float = 0.0
    stiffness: float = 0.0
    springref: float = 0.0
    damping_2: float = 0.0
    damping_3: float = 0.0
    stiffness_2: float = 0.0
    stiffness_3: float = 0.0

    @property
    def springy(self) -> bool:
        """Whether the joint has a spring."""
        return any((self.stiffness, self.stiffness_2, self.stiffness_3))


@dataclass(frozen=True)
class CouplingDynamics:
    """A drive that moves two joints, with u = qd_first + ratio qd_second.

        F = armature u' + frictionloss sign(u) + damping u,  tau_first += F,  tau_second += ratio F

    Attributes:
        first, second: numbers of the joints in the file.
        ratio, armature, damping, frictionloss: see the equation.
    """

    first: int
    second: int
    ratio: float
    armature: float = 0.0
    damping: float = 0.0
    frictionloss: float = 0.0


@dataclass(frozen=True, eq=False)
class Dynamics:
    """All identified values that a robot file can contain.

    Attributes:
        bodies: the links in the frames of their joints, fixed ones included.
        joints: the torques of movable joints.
        couplings: the drives that move two joints.
    """

    bodies: tuple[Body, ...]
    joints: tuple[JointDynamics, ...] = ()
    couplings: tuple[CouplingDynamics, ...] = ()
