"""The robot as a frozen value: what a robot file says, checked, with exact geometry.

Khalil and Kleinfinger's modified Denavit-Hartenberg notation (1986): the frame of joint j is
placed on that of its antecedent by

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

and q_j is added to theta (sigma 0) or to r (sigma 1).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import sympy as sp

from symgen import names
from symgen.errors import RobotError


@dataclass(frozen=True)
class Joint:
    """One joint and the link behind it; lengths in m, angles in rad, exact or in named symbols."""

    number: int
    sigma: int
    antecedent: int
    gamma: sp.Expr = sp.S.Zero
    b: sp.Expr = sp.S.Zero
    alpha: sp.Expr = sp.S.Zero
    d: sp.Expr = sp.S.Zero
    theta: sp.Expr = sp.S.Zero
    r: sp.Expr = sp.S.Zero
    friction: tuple[str, ...] = ("coulomb", "viscous")
    coulomb_width: float = 0.0
    rotor_inertia: bool = True

    @property
    def movable(self) -> bool:
        """Whether the joint has a variable q."""
        return self.sigma != names.FIXED


@dataclass(frozen=True)
class Coupling:
    """A drive that moves two joints: u = qd_j + ratio qd_k; its parameters take k's number."""

    first: int
    second: int
    ratio: sp.Expr


@dataclass(frozen=True)
class Limits:
    """Limits of the movable joints: rad or m, rad/s, rad/s2, N m (or per metre)."""

    position: tuple[tuple[float, float], ...] | None = None
    velocity: tuple[float, ...] | None = None
    acceleration: tuple[float, ...] | None = None
    torque: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Robot:
    """A mechanism: joints in file order, gravity in frame 0 [m/s2], named lengths and angles.

    `geometry` holds pairs (name, exact value); the names stay symbols in the joints' expressions.
    `payload` is the number of the joint whose link carries a load, or None.
    """

    name: str
    gravity: tuple[sp.Expr, sp.Expr, sp.Expr]
    joints: tuple[Joint, ...]
    geometry: tuple[tuple[str, sp.Expr], ...] = ()
    couplings: tuple[Coupling, ...] = ()
    payload: int | None = None
    limits: Limits | None = None

    @property
    def movable(self) -> tuple[Joint, ...]:
        """The joints that have a variable, in file order: arrays and log columns follow them."""
        return tuple(joint for joint in self.joints if joint.movable)

    @property
    def n(self) -> int:
        """Number of movable joints."""
        return len(self.movable)

    @property
    def sigma(self) -> tuple[int, ...]:
        """Types of the movable joints (0 revolute, 1 prismatic)."""
        return tuple(joint.sigma for joint in self.movable)

    def joint(self, number: int) -> Joint:
        """Return the joint with this number of the file.

        Raises:
            RobotError: there is no such joint.
        """
        if not 1 <= number <= len(self.joints):
            raise RobotError(
                f"robot {self.name!r}: there is no joint {number}; "
                f"accepted: 1 to {len(self.joints)}"
            )
        return self.joints[number - 1]

    def values(self) -> dict[sp.Symbol, sp.Expr]:
        """Map the symbol of every named length or angle to its exact value."""
        return {sp.Symbol(name, real=True): value for name, value in self.geometry}

    def with_values(self) -> Robot:
        """Return the robot with the file's values in place of the named symbols."""
        values = self.values()
        keys = ("gamma", "b", "alpha", "d", "theta", "r")
        joints = tuple(
            replace(joint, **{key: getattr(joint, key).subs(values) for key in keys})
            for joint in self.joints
        )
        couplings = tuple(replace(c, ratio=c.ratio.subs(values)) for c in self.couplings)
        x, y, z = (g.subs(values) for g in self.gravity)
        return replace(self, joints=joints, couplings=couplings, gravity=(x, y, z), geometry=())
