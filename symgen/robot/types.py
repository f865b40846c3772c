"""The robot as a frozen value with exact geometry.

The notation is modified Denavit-Hartenberg (Khalil and Kleinfinger 1986). The transform from the
frame of the antecedent to the frame of joint j is

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

and q_j is added to theta (sigma 0) or to r (sigma 1). A joint that follows others, for example in a
parallelogram, has no variable: q_j = sum of c_jk q_k + constant.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated

import sympy as sp

from symgen import names
from symgen.errors import RobotError, shortened
from symgen.files import html_table
from symgen.robot import expressions
from symgen.robot.effect import Effect, Named, Sought, distinct
from symgen.robot.tables import (
    BESIDE,
    Angle,
    Check,
    Contact,
    Coupling,
    Drive,
    Frame,
    Limits,
    LogForm,
    Loop,
    Mount,
    Sensor,
    Servo,
    Title,
    Width,
    word_check,
)

_VARIABLE = re.compile(r"q\d+")
#: Gravity in frame 0 as an input of the kernels. No length in a file can have these names.
GRAVITY_INPUT = (
    sp.Symbol("X_g1", real=True),
    sp.Symbol("X_g2", real=True),
    sp.Symbol("X_g3", real=True),
)
#: The constants of a joint transform in the order of a table.
LENGTHS = ("gamma", "b", "alpha", "d", "theta", "r")
_SHOWN = 30  # characters of a name in the joint table, which is wide
#: Columns of `Robot.table`.
HEADER = ("joint", "name", "sigma", "antecedent", *LENGTHS, "follows")
#: Gravity along z for files without gravity, m/s2.
EARTH = sp.Rational(-981, 100)
#: The ways to declare a joint without a motor in a robot file.
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
    no motor, so its torque is zero.
    """

    number: Annotated[int, BESIDE]
    sigma: Annotated[int, Check("0 (revolute), 1 (prismatic) or 2 (fixed)", range(3).__contains__)]
    antecedent: int
    gamma: Angle = sp.S.Zero
    b: sp.Expr = sp.S.Zero
    alpha: Angle = sp.S.Zero
    d: sp.Expr = sp.S.Zero
    theta: Angle = sp.S.Zero
    r: sp.Expr = sp.S.Zero
    name: Title = ""
    actuated: bool = True
    follows: sp.Expr | None = None
    friction: tuple[Annotated[str, word_check(*names.FRICTION)], ...] = ("coulomb", "viscous")
    coulomb_width: Width = 0.0
    rotor_inertia: bool = True

    @property
    def movable(self) -> bool:
        """Whether the joint has a variable q."""
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
        """q_j with the joints that it follows at zero."""
        if self.follows is None:
            return sp.S.Zero
        return self.follows.subs({joint_variable(k): 0 for k, _ in self.shares})


#: Link 0 of a free base.
_BASE_LINK = Joint(0, names.FIXED, 0, name="base", friction=(), rotor_inertia=False)


def require_gravity(robot: Robot, what: str) -> None:
    """Raise RobotError if gravity is an input, or if the base has an IMU.

    Args:
        robot: the mechanism.
        what: the use that needs fixed gravity, for the message.
    """
    if robot.gravity_input:
        raise RobotError(
            f'robot {robot.name!r}: gravity = "input" has no place in {what}; accepted: three '
            "numbers there"
        )
    if robot.imu:
        elsewhere = (
            ", or MuJoCo with the file of symgen export ESTIMATE --to robot.xml --from FILE.xml"
        )
        raise RobotError(
            f"robot {robot.name!r}: base = {robot.base!r} has no place in {what}; accepted: a "
            f"robot file without it, for a base at rest{elsewhere if robot.floating else ''}"
        )


def require_base(robot: Robot, command: str, accepted: str) -> None:
    """Raise RobotError if the base floats.

    Args:
        robot: the mechanism.
        command: the command that takes no such robot.
        accepted: what helps.
    """
    if robot.floating:
        what = f"robot {robot.name!r}: {command} does not take logs of a floating base"
        raise RobotError(f"{what}; accepted: {accepted}")


@dataclass(frozen=True)
class Robot:
    """A mechanism: joints in file order, gravity in frame 0 [m/s2], named lengths and angles.

    Attributes:
        gravity: (3,) or GRAVITY_INPUT if gravity is an argument of every call.
        base: "fixed"; "imu" if an IMU measures the motion of the base, an argument of calls;
            "floating" if the base moves freely, with link 0 and six equations.
        geometry: pairs (name, exact value); the names are symbols in the expressions of joints.
        payload: number of the joint whose link carries a load, 0 for link 0, or None.
        sought: effects that a diagnosis searches. A robot with such effects has no model.
        frames: frames of links in a file of another format.
        sensor: force/torque sensor at one of these frames, or None.
        mount: place of the IMU of a base that moves, or None for the origin of frame 0.
        contacts: frames at which a floating base may touch its surroundings.
        controller: gains of the controller that moved the robot in its logs.
        log: form of its logs, or None.
        exact: whether its base parameters are always those of the exact geometry, even if the
            torques that separate them are small.
    """

    name: str
    gravity: tuple[sp.Expr, sp.Expr, sp.Expr]
    joints: tuple[Joint, ...]
    base: str = names.BASES[0]
    geometry: Named = ()
    couplings: tuple[Coupling, ...] = ()
    payload: int | None = None
    limits: Limits | None = None
    loops: tuple[Loop, ...] = ()
    effects: tuple[Effect, ...] = ()
    sought: tuple[Sought, ...] = ()
    drive: Drive | None = None
    frames: tuple[Frame, ...] = ()
    sensor: Sensor | None = None
    mount: Mount | None = None
    contacts: tuple[Contact, ...] = ()
    controller: Servo | None = None
    log: LogForm | None = None
    exact: bool = False

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
                shortened(j.name, _SHOWN),
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
        """Labels of the movable joints in results, by number."""
        return {j.number: names.joint_label(j.number, j.name) for j in self.movable}

    @property
    def load_link(self) -> int:
        """Number of the link that carries a load: that of [payload], or the last moving link."""
        if self.payload is not None:
            return self.payload
        return self.movable[-1].number if self.movable else 0

    def frame(self, name: str) -> Frame:
        """Return the frame with this name.

        Raises:
            RobotError: there is no such frame.
        """
        for frame in self.frames:
            if frame.name == name:
                return frame
        known = ", ".join(shortened(f.name) for f in self.frames[:24])
        raise RobotError(
            f"robot {self.name!r}: there is no frame {shortened(name)!r}; accepted: "
            f"{known or 'frames of an imported URDF or MJCF, or [[frame]] of the robot file'}"
        )

    def label(self, number: int) -> str:
        """Return the label of a joint for messages: its name in the file and its number."""
        return names.joint_label(number, self.joint(number).name)

    def listed(self, places: Iterable[int]) -> str:
        """Return movable joints as text for a message, by their positions in q: "elbow (2) and
        joint 3".
        """
        return names.joints_in_words([self.movable[j].number for j in places], self.labels)

    @property
    def joint_names(self) -> list[str]:
        """Names of the movable joints from a file of another format, or ""."""
        return [joint.name for joint in self.movable]

    @property
    def fixed(self) -> list[int]:
        """Numbers of the fixed joints."""
        return [joint.number for joint in self.joints if joint.fixed]

    @property
    def fixes(self) -> list[str]:
        """Values of `import --fix` that hold each movable joint, at 0 or at the limit next to 0."""
        ranges = (self.limits and self.limits.position) or [(0.0, 0.0)] * self.n
        nearest = [min(max(low, 0.0), high) for low, high in ranges]
        names = zip(self.joint_names, nearest, strict=True)
        return [f"{name}={at:g}" if name and at else name for name, at in names]

    @property
    def passive(self) -> list[int]:
        """Positions in q of the joints without a motor."""
        return [k for k, joint in enumerate(self.movable) if not joint.actuated]

    @property
    def gravity_input(self) -> bool:
        """Whether gravity is an argument of the kernels, for tilted mountings."""
        return self.gravity == GRAVITY_INPUT

    @property
    def imu(self) -> bool:
        """Whether the base moves, and an IMU on it measures its motion."""
        return self.base != names.BASES[0]

    @property
    def floating(self) -> bool:
        """Whether the base moves freely: it has parameters and equations."""
        return self.base == "floating"

    @property
    def bodies(self) -> tuple[Joint, ...]:
        """The joints with their links, in file order; a free base is link 0, a fixed joint."""
        return (_BASE_LINK, *self.joints) if self.floating else self.joints

    @property
    def free(self) -> tuple[int, ...]:
        """Numbers of the equations of a free base, behind those of the joints; () without one.

        They are those of the forces along x, y, z, then of the moments about the origin.
        """
        last = len(self.joints)
        return tuple(range(last + 1, last + 7)) if self.floating else ()

    @property
    def equations(self) -> tuple[int, ...]:
        """Numbers of the equations in their order: of a free base, then of the movable joints."""
        return (*self.free, *self.numbers)

    @property
    def kinds(self) -> tuple[int, ...]:
        """Kinds of the equations in their order: of a free base, then types of movable joints."""
        return (*names.BASE_KINDS[: len(self.free)], *self.sigma)

    def rows(self, places: Iterable[int]) -> list[int]:
        """Return the places of movable joints among the equations, by their positions in q."""
        return [len(self.free) + j for j in places]

    def at_rest(self) -> Robot:
        """Return the robot on a base that does not move.

        Raises:
            RobotError: no joint is movable.
        """
        if not self.movable:
            raise RobotError(f"robot {self.name!r}: no joint is movable; accepted: at least one")
        return replace(self, base=names.BASES[0], mount=None, contacts=())

    def mechanism(self) -> Robot:
        """Return the robot without content that derivations ignore, such as limits and names."""
        joints = tuple(replace(joint, name="", actuated=True) for joint in self.joints)
        return replace(
            self,
            joints=joints,
            limits=None,
            drive=None,
            frames=() if self.sensor is None else (self.frame(self.sensor.frame),),
            mount=None,
            contacts=(),
            controller=None,
            log=None,
        )

    @property
    def loaded(self) -> bool:
        """Whether an effect depends on the rigid-body torque."""
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
        if number == 0 and self.floating:
            return _BASE_LINK
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
