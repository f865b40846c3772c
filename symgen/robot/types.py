"""The robot as a frozen value with exact geometry.

The notation is modified Denavit-Hartenberg (Khalil and Kleinfinger 1986). The transform from the
frame of the antecedent to the frame of joint j is

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

and q_j is added to theta (sigma 0) or to r (sigma 1). A joint that follows others, for example in a
parallelogram, has no variable: q_j = sum of c_jk q_k + constant.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from symgen import names
from symgen.errors import RobotError
from symgen.files import html_table
from symgen.robot import expressions
from symgen.robot.effect import Effect, Named, Sought, distinct

_VARIABLE = re.compile(r"q\d+")
#: Gravity in frame 0 if it is an input of the kernels. No length of a file can have these names.
GRAVITY_INPUT = (
    sp.Symbol("X_g1", real=True),
    sp.Symbol("X_g2", real=True),
    sp.Symbol("X_g3", real=True),
)
#: The constants of a joint transform in the order of a table.
ANGLES = ("gamma", "alpha", "theta")
LENGTHS = ("gamma", "b", "alpha", "d", "theta", "r")
#: Limits with one entry for each movable joint.
OF_JOINTS = ("position", "velocity", "acceleration", "jerk", "torque")
_SHOWN = 30  # characters of a name in the table of joints, which is wide
#: Columns of `Robot.table`.
HEADER = ("joint", "name", "sigma", "antecedent", *LENGTHS, "follows")
#: Gravity along z for files that give none, m/s2.
EARTH = sp.Rational(-981, 100)
_ROUNDING = 1e-15  # of the sine and cosine of a right angle
#: How a robot file says that no motor drives a joint.
WITHOUT_MOTOR = (
    "write actuated = false under its [[joint]] in robot.toml (symgen import FILE writes one)"
)
#: Largest number of joints in a file.
MAX_JOINTS = 200
#: Largest factor by which a revolute joint follows another; it amplifies rounding errors.
MAX_RATIO = 200


def joint_variable(number: int) -> sp.Symbol:
    """Return the symbol of a joint variable: q and the joint's number in the file."""
    return sp.Symbol(f"q{number}", real=True)


class Typed:
    """Base class with a joint type: `sigma` 0 revolute, 1 prismatic, 2 fixed."""

    sigma: int

    @property
    def turns(self) -> bool:
        """Whether the joint is revolute."""
        return self.sigma == names.REVOLUTE

    @property
    def slides(self) -> bool:
        """Whether the joint is prismatic."""
        return self.sigma == names.PRISMATIC

    @property
    def fixed(self) -> bool:
        """Whether the joint is fixed."""
        return self.sigma == names.FIXED


@dataclass(frozen=True)
class Joint(Typed):
    """One joint and its link. Lengths in m, angles in rad, exact or in named symbols.

    `follows` is None, or q_j as a linear expression in the symbols q1, q2, ... of other joints.
    `name` is the name of the joint in a file of another format. A joint that is not `actuated` has
    no motor: its torque is zero.
    """

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
    follows: sp.Expr | None = None
    name: str = ""
    actuated: bool = True

    @property
    def movable(self) -> bool:
        """Whether the joint has a variable q of its own."""
        return not self.fixed and self.follows is None

    @property
    def shares(self) -> tuple[tuple[int, sp.Expr], ...]:
        """Pairs (k, dq_j/dq_k) of the movable joints k that move this joint."""
        if self.follows is None:
            return ((self.number, sp.S.One),) if self.movable else ()
        numbers = sorted(
            int(s.name[1:]) for s in self.follows.free_symbols if _VARIABLE.fullmatch(s.name)
        )
        return tuple((k, self.follows.coeff(joint_variable(k))) for k in numbers)

    @property
    def offset(self) -> sp.Expr:
        """q_j where the joints that it follows are at zero."""
        if self.follows is None:
            return sp.S.Zero
        return self.follows.subs({joint_variable(k): 0 for k, _ in self.shares})


@dataclass(frozen=True)
class Coupling:
    """A drive that moves two joints: u = qd_j + ratio qd_k. Its parameters have the number k."""

    first: int
    second: int
    ratio: sp.Expr


@dataclass(frozen=True)
class Loop:
    """A closed chain: frames on both sides of the cut joint, with common origin and z axis."""

    first: int
    second: int


@dataclass(frozen=True)
class Frame:
    """A frame on a link, such as a flange or a tool: constant in the frame of its joint.

    Attributes:
        name: of the link in a file of another format.
        joint: number of the joint that moves the link; 0 for the base.
        xyz: origin in the frame of the joint, m.
        rpy: roll, pitch and yaw, rad, as in a URDF: Rot(z, yaw) Rot(y, pitch) Rot(x, roll).
    """

    name: str
    joint: int
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def transform(self) -> tuple[tuple[float, ...], ...]:
        """The (4, 4) transform of points from this frame to that of the joint."""
        (cr, cp, cy), (sr, s, sy) = (tuple(map(f, self.rpy)) for f in (math.cos, math.sin))
        turn = (
            (cy * cp, cy * s * sr - sy * cr, cy * s * cr + sy * sr),
            (sy * cp, sy * s * sr + cy * cr, sy * s * cr - cy * sr),
            (-s, cp * sr, cp * cr),
        )
        rows = (
            (*(x if abs(x) > _ROUNDING else 0.0 for x in row), at)
            for row, at in zip(turn, self.xyz, strict=True)
        )
        return (*rows, (0.0, 0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Limits:
    """Limits of the movable joints and of the work cell; None if there is no limit.

    Attributes:
        position: lowest and highest position of each joint, rad or m.
        velocity: largest speed of each joint, rad/s or m/s.
        acceleration: largest acceleration of each joint, rad/s2 or m/s2.
        jerk: largest jerk of each joint, rad/s3 or m/s3.
        torque: largest torque of each joint, N m or N.
        floor: height in frame 0, m; moving link frames and the tool stay above it.
        tool: position of the tool in the frame of the last link, m.
        boxes: regions in frame 0, m, that they avoid: x, y and z, each from low to high.
    """

    position: tuple[tuple[float, float], ...] | None = None
    velocity: tuple[float, ...] | None = None
    acceleration: tuple[float, ...] | None = None
    jerk: tuple[float, ...] | None = None
    torque: tuple[float, ...] | None = None
    floor: float | None = None
    tool: tuple[float, float, float] | None = None
    boxes: tuple[tuple[tuple[float, float], ...], ...] = ()

    def __post_init__(self) -> None:
        for key, value in vars(self).items():  # lists are accepted too
            object.__setattr__(self, key, _tuples(value))

    def over(self, own: Limits | None) -> Limits:
        """Return these limits, completed with the limits of a robot."""
        said = {key: value for key, value in vars(self).items() if value not in (None, ())}
        return replace(own or Limits(), **said)

    @property
    def cell(self) -> bool:
        """Whether there is a floor or a box to avoid."""
        return self.floor is not None or bool(self.boxes)


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, (list, tuple)) else value


def require_gravity(robot: Robot, what: str) -> None:
    """Refuse a robot whose gravity is an input.

    Args:
        robot: the mechanism.
        what: the use that needs fixed gravity, for the message.

    Raises:
        RobotError: the robot's gravity is an input.
    """
    if robot.gravity_input:
        raise RobotError(
            f'robot {robot.name!r}: gravity = "input" has no place in {what}; accepted: three '
            "numbers there"
        )


@dataclass(frozen=True)
class Drive:
    """Gears and motors between the sensors of a log and the joints: q_motor = N q_joint.

    Both sides have the same power, so tau_joint = N' tau_motor; and tau_motor = K i.

    Attributes:
        ratio: (n, n) N, in motor turns per joint turn (rad/m where the joint is prismatic).
        torque_constant: (n,) K in N m/A on the motor side; None if logs contain torques.
        position_side: the side of q and qd in logs, "motor" or "joint".
        torque_side: the side of tau in logs, "motor" or "joint"; currents are those of the motors.
        gain: (n,) factors for the torques on the joint side; None for 1.
        gain_std: (n,) standard deviations of the gains.
    """

    ratio: tuple[tuple[float, ...], ...]
    torque_constant: tuple[float, ...] | None = None
    gain: tuple[float, ...] | None = None
    gain_std: tuple[float, ...] | None = None
    position_side: str = "motor"
    torque_side: str = "motor"

    @property
    def gain_uncertainty_percent(self) -> float | None:
        """Largest relative standard deviation of a gain, percent; None if unknown."""
        if self.gain_std is None:
            return None
        gain = self.gain or (1.0,) * len(self.gain_std)
        return 100 * max(s / abs(g) for s, g in zip(self.gain_std, gain, strict=True))


@dataclass(frozen=True)
class Servo:
    """Position control of the joints: tau = kp (qr - q) + kd (qdr - qd), on the joint side.

    Attributes:
        kp: (n,) N m/rad (N/m).
        kd: (n,) N m s/rad (N s/m).
        scale: "known", or "unknown" if the gains are known up to a common factor.
    """

    kp: tuple[float, ...]
    kd: tuple[float, ...]
    scale: str = "known"


@dataclass(frozen=True)
class Robot:
    """A mechanism: joints in file order, gravity in frame 0 [m/s2], named lengths and angles.

    Attributes:
        gravity: (3,) or GRAVITY_INPUT if gravity is an argument of every call.
        geometry: pairs (name, exact value); the names are symbols in the expressions of joints.
        payload: number of the joint whose link carries a load, or None.
        sought: effects that a diagnosis searches. A robot with any has no model.
        frames: frames of links in a file of another format.
        controller: gains of the controller that moved the robot in its logs.
        log_columns: text of --columns for its logs; "" if none.
    """

    name: str
    gravity: tuple[sp.Expr, sp.Expr, sp.Expr]
    joints: tuple[Joint, ...]
    geometry: Named = ()
    couplings: tuple[Coupling, ...] = ()
    payload: int | None = None
    limits: Limits | None = None
    loops: tuple[Loop, ...] = ()
    effects: tuple[Effect, ...] = ()
    sought: tuple[Sought, ...] = ()
    drive: Drive | None = None
    frames: tuple[Frame, ...] = ()
    controller: Servo | None = None
    log_columns: str = ""

    def __post_init__(self) -> None:
        drives = (names.COUPLING_INERTIA, *names.COUPLING_FRICTION)
        taken = {f"{prefix}{c.second}" for prefix in drives for c in self.couplings}
        taken |= {name for name, _ in self.geometry}
        object.__setattr__(self, "effects", distinct(self.effects, taken))

    def __repr__(self) -> str:
        """Return the name and the number of movable joints."""
        return f"<Robot {self.name}: {self.n} of {len(self.joints)} joints movable>"

    def _repr_html_(self) -> str:
        return html_table(repr(self), HEADER, self.table())

    def table(self) -> list[tuple[str, ...]]:
        """Return one row for each joint of the file, with the columns of `HEADER`."""
        return [
            (
                str(j.number),
                expressions.shortened(j.name, _SHOWN),
                str(j.sigma),
                str(j.antecedent),
                *(_short(getattr(j, key)) for key in LENGTHS),
                "" if j.follows is None else expressions.text(j.follows),
            )
            for j in self.joints
        ]

    @property
    def movable(self) -> tuple[Joint, ...]:
        """The joints with a variable, in file order; arrays and log columns have the same order."""
        return tuple(joint for joint in self.joints if joint.movable)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Numbers of the movable joints."""
        return tuple(joint.number for joint in self.movable)

    @property
    def labels(self) -> dict[int, str]:
        """How results call the movable joints, by number."""
        return {j.number: names.joint_label(j.number, j.name) for j in self.movable}

    def frame(self, name: str) -> Frame:
        """Return the frame with this name.

        Raises:
            RobotError: there is no such frame.
        """
        for frame in self.frames:
            if frame.name == name:
                return frame
        known = ", ".join(expressions.shortened(f.name) for f in self.frames[:24])
        raise RobotError(
            f"robot {self.name!r}: there is no frame {expressions.shortened(name)!r}; accepted: "
            f"{known or 'frames of an imported URDF or MJCF, or [[frame]] of the robot file'}"
        )

    def label(self, number: int) -> str:
        """Return how messages call a joint: by its name in the file, and by its number."""
        return names.joint_label(number, self.joint(number).name)

    def listed(self, places: Iterable[int]) -> str:
        """Return movable joints for a message, by their places in q: "elbow (2) and joint 3"."""
        return names.joints_in_words([self.movable[j].number for j in places], self.labels)

    @property
    def joint_names(self) -> list[str]:
        """Names of the movable joints from a file of another format, or ""."""
        return [joint.name for joint in self.movable]

    @property
    def passive(self) -> list[int]:
        """Places in q of the joints that no motor drives."""
        return [k for k, joint in enumerate(self.movable) if not joint.actuated]

    @property
    def gravity_input(self) -> bool:
        """Whether gravity is an argument of the kernels, for tilted mountings."""
        return self.gravity == GRAVITY_INPUT

    @property
    def loaded(self) -> bool:
        """Whether an effect depends on the torque of the rigid body."""
        return any(e.loads(name) for e in self.effects for name, _ in e.linear)

    @property
    def moving(self) -> tuple[Joint, ...]:
        """The joints that move, including those that follow others."""
        return tuple(joint for joint in self.joints if not joint.fixed)

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
        """Return the robot with values in place of the named symbols."""
        values = self.values()
        joints = tuple(
            replace(
                joint,
                **{key: getattr(joint, key).subs(values) for key in LENGTHS},
                follows=None if joint.follows is None else sp.expand(joint.follows.subs(values)),
            )
            for joint in self.joints
        )
        couplings = tuple(replace(c, ratio=c.ratio.subs(values)) for c in self.couplings)
        x, y, z = (g.subs(values) for g in self.gravity)
        return replace(self, joints=joints, couplings=couplings, gravity=(x, y, z), geometry=())


def _short(expr: sp.Expr) -> str:
    """Write an exact value; long decimals get 9 digits."""
    written = expressions.text(expr)
    return f"{float(expr):.9g}" if expr.is_Rational and len(written) > 12 else written
