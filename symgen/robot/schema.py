"""The schema of robot.toml: keys and types, validated by pydantic."""

from __future__ import annotations

import re
from collections.abc import Callable
from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    StrictBool,
    StrictInt,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from symgen.errors import RobotError
from symgen.robot.types import MAX_JOINTS

_LARGEST = 100  # decimal exponent of the largest number
_GEARS = (1e-6, 1e6)
_SMALLEST_WIDTH = 1e-12
_MAX_TITLE = 200
_UNIT = re.compile(r"[A-Za-z0-9 /^().-]{0,40}", re.ASCII)


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, Decimal, float)):
        raise ValueError("a number")
    number = Decimal(value)
    if not number.is_finite() or number.adjusted() > _LARGEST:
        raise ValueError(f"a finite number under 1e{_LARGEST}")
    return float(number)


def _only(good: Callable[[float], bool], accepted: str) -> Callable[[object], float]:
    """Return a validator for a number that must satisfy a condition."""

    def check(value: object) -> float:
        number = _number(value)
        if not good(number):
            raise ValueError(accepted)
        return number

    return check


def _number_or_text(value: object) -> object:
    if isinstance(value, str):
        return value
    try:
        _number(value)
    except ValueError as error:
        raise ValueError(f"{error} or an expression in quotes") from error
    return value


def _constant(value: object) -> object:
    if not isinstance(value, list):
        return _number_or_text(value)
    if len(value) != 2:
        raise ValueError("a number, or [low, high] to be searched by `symgen diagnose`")
    return tuple(_number_or_text(end) for end in value)


def _title(value: object) -> str:
    if not isinstance(value, str) or not value.isprintable() or len(value) > _MAX_TITLE:
        raise ValueError(f"a text in quotes of at most {_MAX_TITLE} printable characters")
    return value


Scalar = Annotated[Any, PlainValidator(_number_or_text)]
Constant = Annotated[Any, PlainValidator(_constant)]
Finite = Annotated[float, PlainValidator(_number)]
Range = tuple[Finite, Finite]
Title = Annotated[str, PlainValidator(_title)]
Positive = Annotated[float, PlainValidator(_only(lambda x: x > 0, "a number above 0"))]
Gain = Annotated[float, PlainValidator(_only(lambda x: x >= 0, "a number of 0 or more"))]
Width = Annotated[
    float,
    PlainValidator(
        _only(
            lambda x: x == 0 or x >= _SMALLEST_WIDTH,
            f"0, or a width of at least {_SMALLEST_WIDTH:g}",
        )
    ),
]
_factor = _only(
    lambda x: _GEARS[0] <= abs(x) <= _GEARS[1],
    f"a number other than 0, {_GEARS[0]:g} to {_GEARS[1]:g} in size",
)
Factor = Annotated[float, PlainValidator(_factor)]


def _unit(value: object) -> str:
    # A unit appears in comments of C, in tables and in formulas.
    if not isinstance(value, str) or _UNIT.fullmatch(value) is None:
        raise ValueError(
            "a unit in quotes, such as 'N m/rad', of letters, digits, spaces, / ^ . ( ) -"
        )
    return value


def _gears(value: object) -> list[float] | list[list[float]]:
    if not isinstance(value, list) or not value:
        raise ValueError("a list of one number for each movable joint, or an n x n matrix")
    if not any(isinstance(row, list) for row in value):
        return [_factor(number) for number in value]
    if not all(isinstance(row, list) and len(row) == len(value) for row in value):
        raise ValueError("an n x n matrix, as a list of n rows of n numbers")
    if max(abs(_number(number)) for row in value for number in row) > _GEARS[1]:
        raise ValueError(f"numbers up to {_GEARS[1]:g} in size")
    return [[_number(number) for number in row] for row in value]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=False, arbitrary_types_allowed=True)


def _gravity(value: object, three: ValidatorFunctionWrapHandler) -> Any:
    return value if value == "input" else three(value)


class RobotTable(_Table):
    name: str
    convention: Literal["modified-dh"] = "modified-dh"
    gravity: Annotated[
        tuple[Scalar, Scalar, Scalar] | Literal["input"], WrapValidator(_gravity)
    ] = (0, 0, Decimal("-9.81"))


class JointTable(_Table):
    sigma: Annotated[StrictInt, Field(ge=0, le=2)] = 0
    antecedent: Annotated[StrictInt, Field(ge=0)] | None = None
    gamma: Scalar = 0
    b: Scalar = 0
    alpha: Scalar = 0
    d: Scalar = 0
    theta: Scalar = 0
    r: Scalar = 0
    friction: list[Literal["coulomb", "viscous", "offset"]] | None = None
    coulomb_width: Width = 0.0
    rotor_inertia: StrictBool | None = None
    follows: str | None = None
    name: Title = ""
    actuated: StrictBool = True


class CouplingTable(_Table):
    joints: tuple[StrictInt, StrictInt]
    ratio: Scalar = 1


class PayloadTable(_Table):
    joint: Annotated[StrictInt, Field(ge=1)]


class FrameTable(_Table):
    name: Annotated[Title, Field(min_length=1)]
    joint: Annotated[StrictInt, Field(ge=0)]
    xyz: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)
    rpy: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)


class LoopTable(_Table):
    cut: tuple[StrictInt, StrictInt]


class EffectTable(_Table):
    name: Annotated[Title, Field(min_length=1)]
    joints: list[StrictInt]
    torque: str | None = None
    linear: dict[str, Annotated[str, PlainValidator(_unit)]] = {}
    nonlinear: dict[str, Constant] = {}


class LimitsTable(_Table):
    position: list[Range] | None = None
    velocity: list[Positive] | None = None
    acceleration: list[Positive] | None = None
    jerk: list[Positive] | None = None
    torque: list[Positive] | None = None
    floor: Finite | None = None
    boxes: list[tuple[Range, Range, Range]] = []
    tool: tuple[Finite, Finite, Finite] | None = None


class DriveTable(_Table):
    ratio: Annotated[Any, PlainValidator(_gears)] = None
    torque_constant: list[Factor] | None = None
    gain: list[Factor] | None = None
    gain_std: list[Positive] | None = None
    side: Literal["motor", "link"] = "motor"
    position_side: Literal["motor", "joint"] | None = None
    torque_side: Literal["motor", "joint"] | None = None


class ControllerTable(_Table):
    kp: list[Gain]
    kd: list[Gain]
    scale: Literal["known", "unknown"] = "known"


class LogTable(_Table):
    columns: str


class RobotFile(_Table):
    robot: RobotTable
    geometry: dict[str, Scalar] = {}
    joint: Annotated[list[JointTable], Field(min_length=1, max_length=MAX_JOINTS)]
    coupling: list[CouplingTable] = []
    payload: PayloadTable | None = None
    limits: LimitsTable | None = None
    drive: DriveTable | None = None
    controller: ControllerTable | None = None
    log: LogTable | None = None
    effect: list[EffectTable] = []
    loop: list[LoopTable] = []
    frame: list[FrameTable] = []


_TABLES: dict[str, type[BaseModel]] = {
    "robot": RobotTable,
    "joint": JointTable,
    "coupling": CouplingTable,
    "payload": PayloadTable,
    "limits": LimitsTable,
    "drive": DriveTable,
    "controller": ControllerTable,
    "log": LogTable,
    "loop": LoopTable,
    "frame": FrameTable,
    "effect": EffectTable,
}
#: For the author of another Denavit-Hartenberg table.
_TABLE = (
    "; the table is modified Denavit-Hartenberg: d is the length along x and r the length along z "
    "(Craig's a and d), and alpha and d come before theta and r; alpha and a of row j of a "
    "standard table are alpha and d of row j + 1"
)
# Error type of pydantic -> message for the author of the file.
_WORDS = {
    "missing": "is missing; it must be given",
    "model_type": "is not a table; accepted: [name] with keys below it, [[name]] where it repeats",
    "dict_type": "is not a table; accepted: [name] with keys below it",
    "list_type": "is not a list; accepted: [...] ([] for none), or [[name]] for each table",
    "tuple_type": "is not a list; accepted: [...]",
    "int_type": "is no integer; accepted: an integer",
    "bool_type": "is not a truth value; accepted: true or false",
    "string_type": "is not a text; accepted: a text in quotes",
}


def validated(data: dict[str, object]) -> RobotFile:
    """Check keys and types of a parsed file.

    Raises:
        RobotError: the message gives the place of the first error, and the accepted input.
    """
    try:
        return RobotFile.model_validate(data)
    except ValidationError as error:
        fault = error.errors()[0]
        place, kind = _place(fault["loc"]), fault["type"]
        if kind == "extra_forbidden":
            table = _TABLES[str(fault["loc"][0])] if len(fault["loc"]) > 1 else RobotFile
            what = f"unknown key; accepted: {', '.join(table.model_fields)}"
        elif kind in _WORDS:
            what = _WORDS[kind]
        elif kind in ("too_short", "too_long"):
            context = fault["ctx"]
            limit = context.get("min_length") or context.get("max_length")
            side = "at least" if kind == "too_short" else "at most"
            what = f"{context['actual_length']} entries; accepted: {side} {limit}"
        else:
            message = fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
            what = f"accepted: {message}"
        if fault["loc"][-1] in ("convention", "a"):
            what += _TABLE
        raise RobotError(f"{place}: {what}") from error


def _place(loc: tuple[str | int, ...]) -> str:
    """Write a position in the file for a reader: joint 2, key 'alpha'."""
    words: list[str] = []
    for part in loc:
        if isinstance(part, int) and words:
            words[-1] += f" {part + 1}" if len(words) == 1 else f", entry {part + 1}"
        elif len(words) < 2:
            words.append(str(part) if not words else f"key {part!r}")
    return ", ".join(words) or "file"
