"""What a robot file of another program holds: links as rigid bodies, and the torques of joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Body:
    """One link in the frame of its joint (modified Denavit-Hartenberg).

    Attributes:
        joint: number of the joint in the file. A payload is part of its link.
        mass: kg.
        com: centre of mass (3,), m.
        inertia: inertia matrix (3, 3) about the centre of mass, kg m2. Entry (0, 1) is
            -integral of x y dm.
    """

    joint: int
    mass: float
    com: FloatArray
    inertia: FloatArray


@dataclass(frozen=True)
class JointDynamics:
    """Torque of the motor of one joint, beside that of the links.

        tau = armature qdd + frictionloss sign(qd) + damping qd + stiffness (q - springref)

    Attributes:
        joint: number of the joint in the file.
        armature: inertia of the rotor on the joint side, kg m2 or kg.
        damping: viscous friction, N m s/rad or N s/m.
        frictionloss: Coulomb friction, N m or N.
        stiffness: of a spring, N m/rad or N/m.
        springref: position of the joint at which the spring has no torque, rad or m.
    """

    joint: int
    armature: float = 0.0
    damping: float = 0.0
    frictionloss: float = 0.0
    stiffness: float = 0.0
    springref: float = 0.0


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
    """All that a robot file can hold of an identified robot.

    Attributes:
        bodies: the links in the frames of their joints, fixed ones included.
        joints: the torques of movable joints.
        couplings: the drives that move two joints.
    """

    bodies: tuple[Body, ...]
    joints: tuple[JointDynamics, ...] = ()
    couplings: tuple[CouplingDynamics, ...] = ()
