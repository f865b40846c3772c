"""The tables of a robot file as frozen values: a dataclass is the schema of its table.

A field is a key. Its annotation describes the accepted values: a number, a text, a list (tuple), an
exact expression, and conditions. `schema` reads every table by its annotations, and `toml_text`
writes it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, TypeAlias

import numpy as np
import sympy as sp

from symgen import names
from symgen.robot.body import pose, turn
from symgen.robot.identifiers import is_coefficient_name, is_geometry_name

#: For users of another Denavit-Hartenberg notation.
NOTATION = (
    "; the table is modified Denavit-Hartenberg: d is the length along x and r the length along z "
    "(Craig's a and d), and alpha and d come before theta and r; alpha and a of row j of a "
    "standard table are alpha and d of row j + 1"
)
CONVENTION = "modified-dh"
_GEARS = (1e-6, 1e6)
#: Largest condition number of a gear matrix with rows scaled to unit length.
_MAX_CONDITION = 1e6
_SMALLEST_WIDTH = 1e-12
_MAX_TITLE = 200
_ROUNDING = 1e-15  # of the sine and cosine of a right angle
_UNIT = re.compile(r"[A-Za-z0-9 /^().-]{0,40}", re.ASCII)


@dataclass(frozen=True)
class Check:
    """A condition on a value, with a text of the accepted values."""

    accepted: str
    passes: Callable[[Any], bool]


@dataclass(frozen=True)
class Before:
    """A conversion of the value in the file to the annotated type."""

    convert: Callable[[Any], Any]


@dataclass(frozen=True)
class JointNumber:
    """Marks an integer as the number of a joint: any joint, a movable one, 0 for the base, or 0 for
    link 0 of a base that floats.
    """

    movable: bool = False
    base: bool = False
    link: bool = False


#: Marks a list with one entry for each movable joint.
PER_JOINT = "per joint"
#: Marks an expression as an angle in rad.
ANGLE = "angle"
#: Marks a field that is not a key of the file.
BESIDE = "beside"


def word_check(*words: str) -> Check:
    """Return the condition that a value is one of `words`."""
    return Check(" or ".join(map(repr, words)), words.__contains__)


Angle = Annotated[sp.Expr, ANGLE]
Positive = Annotated[float, Check("a number above 0", lambda x: x > 0)]
NotNegative = Annotated[float, Check("a number of 0 or more", lambda x: x >= 0)]
Width = Annotated[
    float,
    Check(
        f"0, or a width of at least {_SMALLEST_WIDTH:g}", lambda x: x == 0 or x >= _SMALLEST_WIDTH
    ),
]
Factor = Annotated[
    float,
    Check(
        f"a number other than 0, {_GEARS[0]:g} to {_GEARS[1]:g} in size",
        lambda x: _GEARS[0] <= abs(x) <= _GEARS[1],
    ),
]
#: One number for each movable joint, or none.
Positives = Annotated[tuple[Positive, ...] | None, PER_JOINT]
Factors = Annotated[tuple[Factor, ...] | None, PER_JOINT]
Range = Annotated[tuple[float, float], Check("[low, high], low below high", lambda r: r[0] < r[1])]
Triple = tuple[float, float, float]
Movable = Annotated[int, JointNumber(movable=True)]
Distinct = Check("different joints, at least one", lambda x: len(x) == len(set(x)) > 0)
GeometryName = Annotated[str, Check("a C identifier that is not reserved", is_geometry_name)]
CoefficientName = Annotated[
    str,
    Check("a capital letter followed by letters and digits, not reserved", is_coefficient_name),
]
Title = Annotated[
    str,
    Check(
        f"a text in quotes of at most {_MAX_TITLE} printable characters",
        lambda text: text.isprintable() and len(text) <= _MAX_TITLE,
    ),
]
Name = Annotated[Title, Check("a text that is not empty", bool)]
# A unit is used in C comments, tables and formulas.
Unit = Annotated[
    str,
    Check(
        "a unit in quotes, such as 'N m/rad', of letters, digits, spaces, / ^ . ( ) -",
        lambda text: _UNIT.fullmatch(text) is not None,
    ),
]


@dataclass(frozen=True)
class Head:
    """[robot]: gravity in frame 0, m/s2; `exact` for base parameters of the exact geometry."""

    name: str
    gravity: tuple[sp.Expr, sp.Expr, sp.Expr]
    base: Annotated[str, word_check(*names.BASES)] = names.BASES[0]
    convention: Annotated[str, Check(f"'{CONVENTION}'{NOTATION}", CONVENTION.__eq__)] = CONVENTION
    exact: bool = False


@dataclass(frozen=True)
class PayloadTable:
    """[payload]: a load on the link of a joint, or on link 0 of a floating base."""

    joint: Annotated[int, JointNumber(link=True)]


@dataclass(frozen=True)
class LogForm:
    """[log]: the form of the robot's logs, as the options of the same names.

    Attributes:
        columns: text of --columns, "t=time,q=*_position".
        unit: text of --unit, "q=deg,tau=mNm".
        time_unit: unit of t.
        joints: names of the movable joints in the file.
        separator: character between the columns of a CSV, or "tab".
        decimal: decimal mark of a CSV.
        header: whether a CSV has names of columns.
        range: positions of each movable joint at -100 and at 100, rad (m), if the file has
            positions from -100 to 100.
    """

    columns: str = ""
    unit: str = ""
    time_unit: str = ""
    joints: tuple[Name, ...] = ()
    separator: str = ""
    decimal: str = ""
    header: bool = True
    range: Annotated[tuple[tuple[float, float], ...], PER_JOINT] = ()


@dataclass(frozen=True)
class Coupling:
    """A drive that moves two joints: u = qd_j + ratio qd_k. Its parameters have the number k."""

    joints: Annotated[tuple[Movable, Movable], Distinct]
    ratio: sp.Expr

    @property
    def first(self) -> int:
        """The number j."""
        return self.joints[0]

    @property
    def second(self) -> int:
        """The number k."""
        return self.joints[1]


@dataclass(frozen=True)
class Loop:
    """A closed chain: frames on both sides of the cut joint, with common origin and z axis."""

    cut: Annotated[tuple[Annotated[int, JointNumber()], Annotated[int, JointNumber()]], Distinct]


@dataclass(frozen=True)
class Frame:
    """A frame on a link, such as a flange or a tool: constant in the frame of its joint.

    Attributes:
        name: name of the link in a file of another format.
        joint: number of the joint that moves the link; 0 for the base.
        xyz: origin in the frame of the joint, m.
        rpy: roll, pitch and yaw, rad, as in a URDF: Rot(z, yaw) Rot(y, pitch) Rot(x, roll).
    """

    name: Name
    joint: Annotated[int, JointNumber(base=True)]
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)

    @property
    def transform(self) -> tuple[tuple[float, ...], ...]:
        """The (4, 4) transform of points from this frame to that of the joint."""
        transform = pose(turn(*self.rpy), self.xyz)
        rounded = np.where(abs(transform) > _ROUNDING, transform, 0.0)
        rounded[:3, 3] = self.xyz
        return tuple(map(tuple, rounded.astype(float).tolist()))


@dataclass(frozen=True)
class Mount:
    """[base]: the place of the IMU of a base that moves, in frame 0.

    Attributes:
        position: its origin, m.
        rotation: roll, pitch and yaw of its axes, rad, as in a URDF.
    """

    position: Triple = (0.0, 0.0, 0.0)
    rotation: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Contact:
    """[[contact]]: a place where a robot with a floating base may touch its surroundings.

    Attributes:
        frame: name of a [[frame]]; its origin is the place.
        kind: "point" for a force without a moment, as of a foot or a rope; or "surface".
        radius: radius of a round foot, m, whose centre is the origin of the frame. On level ground,
            the force acts below it.
    """

    frame: Name
    kind: Annotated[str, word_check("point", "surface")]
    radius: NotNegative = 0.0

    @property
    def rows(self) -> int:
        """Number of components of its force, the first of those of a wrench."""
        return 3 if self.kind == "point" else 6


@dataclass(frozen=True)
class Sensor:
    """[sensor]: a force/torque sensor between the arm and its tool, at a [[frame]] of the file."""

    frame: Name


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

    position: Annotated[tuple[Range, ...] | None, PER_JOINT] = None
    velocity: Positives = None
    acceleration: Positives = None
    jerk: Positives = None
    torque: Positives = None
    floor: float | None = None
    tool: Triple | None = None
    boxes: tuple[tuple[Range, Range, Range], ...] = ()

    def __post_init__(self) -> None:
        for key, value in vars(self).items():  # accept lists too
            object.__setattr__(self, key, _tuples(value))

    def over(self, robot_limits: Limits | None) -> Limits:
        """Return these limits, completed with the limits of a robot."""
        limits = {key: value for key, value in vars(self).items() if value not in (None, ())}
        return replace(robot_limits or Limits(), **limits)

    @property
    def cell(self) -> bool:
        """Whether there is a floor or a box to avoid."""
        return self.floor is not None or bool(self.boxes)


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, (list, tuple)) else value


def _as_matrix(ratio: Any) -> Any:
    """Return a list of gear ratios as rows of a diagonal matrix; other values unchanged."""
    if not isinstance(ratio, list) or any(isinstance(row, list) for row in ratio):
        return ratio
    return [[x if i == k else 0 for k in range(len(ratio))] for i, x in enumerate(ratio)]


def _is_square(rows: tuple[tuple[float, ...], ...]) -> bool:
    return all(len(row) == len(rows) for row in rows)


def _is_invertible(rows: tuple[tuple[float, ...], ...]) -> bool:
    matrix = np.array(rows)
    sizes = np.linalg.norm(matrix, axis=1)
    if sizes.min() < _GEARS[0] or abs(matrix).max() > _GEARS[1]:
        return False
    return bool(np.linalg.cond(matrix / sizes[:, None]) <= _MAX_CONDITION)


@dataclass(frozen=True)
class Drive:
    """Gears and motors between the sensors of a log and the joints: q_motor = N q_joint.

    Both sides have the same power, so tau_joint = N' tau_motor; and tau_motor = K i.

    Attributes:
        ratio: (n, n) N, in motor turns per joint turn (rad/m for a prismatic joint).
        torque_constant: (n,) K in N m/A on the motor side; None if logs contain torques.
        rated: (n,) torques in N m (forces in N) of 100 %, on the side of tau; None if unknown.
        gain: (n,) factors for the torques on the joint side; None for 1.
        gain_std: (n,) standard deviations of the gains.
        position_side: the side of q and qd in logs, "motor" or "joint".
        torque_side: the side of tau and of duty in logs, "motor" or "joint"; currents are those of
            the motors.
        supply: (n,) nominal voltages of the supply, V; None if unknown.
        resistance: (n,) resistances of the windings, ohm; None if unknown.
        limit: (n,) largest duty of the drives; None for 1.
    """

    ratio: Annotated[
        tuple[tuple[float, ...], ...],
        Before(_as_matrix),
        PER_JOINT,
        Check("one number for each movable joint, or the rows of an n x n matrix", _is_square),
        Check(
            f"numbers other than 0 of {_GEARS[0]:g} to {_GEARS[1]:g} in size, or a matrix that is "
            "not singular: q_motor = N q_joint can be solved for q_joint",
            _is_invertible,
        ),
    ]
    torque_constant: Factors = None
    rated: Positives = None
    gain: Factors = None
    gain_std: Positives = None
    position_side: Annotated[str, word_check("motor", "joint")] = "motor"
    torque_side: Annotated[str, word_check("motor", "joint")] = "motor"
    supply: Positives = None
    resistance: Positives = None
    limit: Positives = None

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
        kp: (n,) N m/rad (N/m); duty or A instead of N m according to `unit`.
        kd: (n,) N m s/rad (N s/m); likewise.
        scale: "known", or "unknown" if the gains are known up to a common factor.
        unit: what the controller commands: torque in "N m", "duty", or motor current in "A".
    """

    kp: Annotated[tuple[NotNegative, ...], PER_JOINT]
    kd: Annotated[tuple[NotNegative, ...], PER_JOINT]
    scale: Annotated[str, word_check("known", "unknown")] = "known"
    unit: Annotated[str, word_check("N m", "duty", "A")] = "N m"


_ENDS = Check("a number, or [low, high] to be searched by `symgen diagnose`", lambda x: len(x) == 2)
#: The value of a constant, or both ends of the range that a diagnosis searches.
Constant: TypeAlias = sp.Expr | Annotated[tuple[sp.Expr, ...], _ENDS]


@dataclass(frozen=True)
class EffectTable:
    """[[effect]]: an effect of the library, or one with a torque from the file.

    Attributes:
        name: name in the library, or any other name.
        joints: numbers of the joints.
        torque: torque on the joint, in the safe grammar; "" for an effect of the library.
        linear: unit of each coefficient in the torque.
        nonlinear: value or range of each constant.
    """

    name: Name
    joints: Annotated[tuple[Movable, ...], Distinct]
    torque: str = ""
    linear: dict[CoefficientName, Unit] = field(default_factory=dict)
    nonlinear: dict[GeometryName, Constant] = field(default_factory=dict)
