"""robot.toml to a Robot and back; the format is described in the README."""

from __future__ import annotations

import math
import re
import tomllib
import warnings
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING

import sympy as sp

from symgen import names
from symgen.errors import ExpressionError, RobotError, SymgenWarning
from symgen.robot import expressions
from symgen.robot.builtin import library, library_text
from symgen.robot.types import Coupling, Joint, Limits, Robot

if TYPE_CHECKING:
    from pydantic import BaseModel

    from symgen.robot.schema import JointTable, RobotFile

_LENGTHS = ("b", "d", "r")
_ANGLES = ("gamma", "alpha", "theta")
_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_MAX_BYTES = 1_000_000
# Words that C or C++ keeps for itself, and the names that symgen gives to variables.
_KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long main register restrict return short signed sizeof static struct switch "
    "typedef union unsigned void volatile while asm bool catch class delete false friend mutable "
    "namespace new operator private protected public template this throw true try using virtual "
    "abs sign sqrt sin cos tan exp tanh min max pi g taur".split()
)
_RESERVED = re.compile(
    r"(q|qd|qdd|tau|i)\d*|(XX|XY|XZ|YY|YZ|ZZ|MX|MY|MZ|M|IA|IAM|FS|FV|OF|FSM|FVM)\d+R?"
)


def read_robot(source: str | Path) -> Robot:
    """Read a robot from a file, a generated package, or the built-in library.

    Args:
        source: path of a robot.toml, of a folder that holds one, or the name of a library robot.

    Returns:
        The robot, with exact geometry.

    Raises:
        RobotError: there is no such robot, or the file is not a valid one.
    """
    path = Path(source)
    if path.is_dir():
        if not (path / "robot.toml").is_file():
            raise RobotError(f"{path}: a folder without robot.toml; accepted: a generated package")
        path = path / "robot.toml"
    elif not path.exists() and str(source) in library():
        return parse_robot(library_text(str(source)), f"library robot {source}")
    elif not path.exists():
        raise RobotError(
            f"{source}: no such file or library robot; accepted: a path to robot.toml, "
            f"a generated package, or one of {', '.join(library())}"
        )
    elif path.suffix in (".urdf", ".par"):
        raise RobotError(f"{path}: {path.suffix} files cannot be read yet; accepted: .toml")
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise RobotError(f"{path}: larger than {_MAX_BYTES} bytes; not a robot.toml")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RobotError(f"{path}: cannot be read as UTF-8 text: {error}") from error
    return parse_robot(text, str(path))


def parse_robot(text: str, where: str = "robot.toml") -> Robot:
    """Read a robot from the text of a robot.toml.

    Args:
        text: the file's text.
        where: what error messages call the file.

    Raises:
        RobotError: the text is not a valid robot; the message names the joint and the key.
    """
    try:
        data = tomllib.loads(text, parse_float=Decimal)
    except (tomllib.TOMLDecodeError, RecursionError, ArithmeticError, ValueError) as error:
        raise RobotError(f"{where}: not valid TOML: {_one_line(error)}") from error
    return _Reader(where).robot(_validated(data, where))


def _validated(data: dict[str, object], where: str) -> RobotFile:
    """Check keys and types; report the first fault with its place."""
    from pydantic import ValidationError

    from symgen.robot.schema import RobotFile

    try:
        return RobotFile.model_validate(data)
    except ValidationError as error:
        fault = error.errors()[0]
        place = _place(fault["loc"])
        if fault["type"] == "extra_forbidden":
            table = _table_at(fault["loc"][:-1])
            raise RobotError(
                f"{where}: {place}: unknown key; accepted: {', '.join(table)}"
            ) from error
        message = fault["msg"].removeprefix("Value error, ")
        raise RobotError(f"{where}: {place}: accepted: {message}") from error


def _table_at(loc: tuple[str | int, ...]) -> list[str]:
    """Return the keys that the table at `loc` accepts."""
    from symgen.robot import schema

    tables: dict[str, type[BaseModel]] = {
        "robot": schema.RobotTable,
        "joint": schema.JointTable,
        "coupling": schema.CouplingTable,
        "payload": schema.PayloadTable,
        "limits": schema.LimitsTable,
    }
    return list((tables[str(loc[0])] if loc else schema.RobotFile).model_fields)


def _place(loc: tuple[str | int, ...]) -> str:
    """Write a position in the file as a person would: joint 2, key alpha."""
    words: list[str] = []
    for part in loc:
        if isinstance(part, int) and words:
            words[-1] += f" {part + 1}"
        elif isinstance(part, str) and not part.startswith(("function-", "is-instance")):
            words.append(part if not words else f"key {part!r}" if len(words) == 1 else part)
    return ", ".join(words) or "file"


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())


class _Reader:
    """Gives meaning to a validated file; `where` names the file in messages."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.geometry: dict[str, sp.Expr] = {}

    def fail(self, message: str) -> RobotError:
        return RobotError(f"{self.where}: {message}")

    def robot(self, file: RobotFile) -> Robot:
        for key in ("drive", "effect", "loop"):
            if getattr(file, key) is not None:
                raise self.fail(f"[{key}] is not supported by this version of symgen")
        name = file.robot.name
        if not _IDENTIFIER.fullmatch(name) or name in _KEYWORDS:
            raise self.fail(f"robot, key 'name': {name!r} is not a C identifier")
        for key, value in file.geometry.items():
            if not _IDENTIFIER.fullmatch(key) or key in _KEYWORDS or _RESERVED.fullmatch(key):
                raise self.fail(f"geometry, key {key!r}: reserved, or not a C identifier")
            self.geometry[key] = _snapped(self.expression(value, f"geometry, key {key!r}", ()))
        joints = tuple(self.joint(number, table) for number, table in enumerate(file.joint, 1))
        movable = [joint for joint in joints if joint.movable]
        if not movable:
            raise self.fail("no joint is movable; accepted: at least one sigma of 0 or 1")
        gravity = tuple(
            self.expression(g, "robot, key 'gravity'", self.geometry) for g in file.robot.gravity
        )
        return Robot(
            name=name,
            gravity=(gravity[0], gravity[1], gravity[2]),
            joints=joints,
            geometry=tuple(self.geometry.items()),
            couplings=self.couplings(file, joints),
            payload=self.payload(file, joints),
            limits=self.limits(file, len(movable)),
        )

    def expression(
        self, value: int | Decimal | str, place: str, known: dict[str, sp.Expr] | tuple[()]
    ) -> sp.Expr:
        try:
            if isinstance(value, str):
                expr = expressions.parse(value, tuple(known))
            else:
                expr = expressions.exact(value)
            numbers = {sp.Symbol(k, real=True): v for k, v in self.geometry.items()}
            if expr.free_symbols:
                expressions.check_finite(expr.subs(numbers), str(value))
        except ExpressionError as error:
            raise self.fail(f"{place}: {error}") from error
        except (ArithmeticError, ValueError, TypeError, RecursionError) as error:
            raise self.fail(f"{place}: {value!r} has no finite real value") from error
        return expr

    def joint(self, number: int, table: JointTable) -> Joint:
        antecedent = number - 1 if table.antecedent is None else table.antecedent
        if antecedent >= number:
            raise self.fail(
                f"joint {number}, key 'antecedent': {antecedent} is not an earlier joint; "
                f"accepted: 0 (the base) to {number - 1}"
            )
        fixed = table.sigma == names.FIXED
        if fixed and (table.friction or table.rotor_inertia or table.coulomb_width):
            raise self.fail(
                f"joint {number}: a fixed joint (sigma 2) has no friction and no rotor inertia"
            )
        friction = table.friction if table.friction is not None else ["coulomb", "viscous"]
        if len(set(friction)) != len(friction):
            raise self.fail(f"joint {number}, key 'friction': a word stands twice")
        values = {
            key: self.expression(getattr(table, key), f"joint {number}, key {key!r}", self.geometry)
            for key in (*_LENGTHS, *_ANGLES)
        }
        for key in _ANGLES:
            values[key] = _snapped(values[key])
            self.warn_near_fraction(values[key], f"joint {number}, key {key!r}")
        return Joint(
            number=number,
            sigma=table.sigma,
            antecedent=antecedent,
            friction=() if fixed else tuple(w for w in names.FRICTION if w in friction),
            coulomb_width=float(table.coulomb_width),
            rotor_inertia=not fixed and table.rotor_inertia is not False,
            **values,
        )

    def warn_near_fraction(self, angle: sp.Expr, place: str) -> None:
        numbers = {sp.Symbol(k, real=True): v for k, v in self.geometry.items()}
        value = angle.subs(numbers)
        k = round(float(value.evalf(30)) * 24 / math.pi)
        gap = abs(float((value - sp.pi * sp.Rational(k, 24)).evalf(30)))
        if 0 < gap < 1e-4:
            fraction = expressions.text(sp.pi * sp.Rational(k, 24))
            warnings.warn(
                f"{self.where}: {place}: {expressions.text(angle)} is within 1e-4 of "
                f"{fraction}, but not it; write {fraction!r} if that is meant",
                SymgenWarning,
                stacklevel=2,
            )

    def couplings(self, file: RobotFile, joints: tuple[Joint, ...]) -> tuple[Coupling, ...]:
        found: list[Coupling] = []
        for number, table in enumerate(file.coupling, 1):
            place = f"coupling {number}, key 'joints'"
            first, second = table.joints
            for j in (first, second):
                if not 1 <= j <= len(joints) or not joints[j - 1].movable:
                    raise self.fail(f"{place}: {j} is not a movable joint")
            if first == second:
                raise self.fail(f"{place}: two different joints are needed")
            if any(second == c.second for c in found):
                raise self.fail(f"{place}: a second coupling with number {second}")
            ratio = self.expression(table.ratio, f"coupling {number}, key 'ratio'", self.geometry)
            if ratio.is_zero:
                raise self.fail(f"coupling {number}, key 'ratio': zero couples nothing")
            found.append(Coupling(first, second, ratio))
        return tuple(found)

    def payload(self, file: RobotFile, joints: tuple[Joint, ...]) -> int | None:
        if file.payload is None:
            return None
        if file.payload.joint > len(joints):
            raise self.fail(f"payload, key 'joint': there is no joint {file.payload.joint}")
        return file.payload.joint

    def limits(self, file: RobotFile, n: int) -> Limits | None:
        if file.limits is None:
            return None
        table = file.limits
        for key in ("position", "velocity", "acceleration", "torque"):
            values = getattr(table, key)
            if values is not None and len(values) != n:
                raise self.fail(
                    f"limits, key {key!r}: {len(values)} entries; accepted: one for each of "
                    f"the {n} movable joints"
                )
        for low, high in table.position or ():
            if low >= high:
                raise self.fail(f"limits, key 'position': [{low}, {high}] is empty")
        return Limits(
            position=None if table.position is None else tuple(table.position),
            velocity=None if table.velocity is None else tuple(table.velocity),
            acceleration=None if table.acceleration is None else tuple(table.acceleration),
            torque=None if table.torque is None else tuple(table.torque),
        )


def _snapped(angle: sp.Expr) -> sp.Expr:
    """Turn a decimal that is k pi/24 to its last digit into that fraction of pi."""
    if not angle.is_Rational or angle.is_zero:
        return angle
    value = float(angle)
    k = round(value * 24 / math.pi)
    if k and abs(value - k * math.pi / 24) <= 5e-16 * max(1.0, abs(value)):
        return sp.pi * sp.Rational(k, 24)
    return angle


def robot_toml(robot: Robot) -> str:
    """Return the robot as the text of a robot.toml; reading it gives the same robot."""

    def scalar(expr: sp.Expr) -> str:
        written = expressions.text(expr)
        try:
            plain = expr.is_Rational and expressions.exact(Decimal(written)) == expr
        except ArithmeticError:
            plain = False
        return written if plain else f'"{written}"'

    def plain_list(values: tuple[object, ...]) -> str:
        return "[" + ", ".join(str(list(v) if isinstance(v, tuple) else v) for v in values) + "]"

    out = [
        "[robot]",
        f'name = "{robot.name}"',
        'convention = "modified-dh"',
        f"gravity = [{', '.join(scalar(g) for g in robot.gravity)}]",
    ]
    if robot.geometry:
        out += ["", "[geometry]", *(f"{key} = {scalar(v)}" for key, v in robot.geometry)]
    for joint in robot.joints:
        out += ["", f"[[joint]]  # {joint.number}", f"sigma = {joint.sigma}"]
        if joint.antecedent != joint.number - 1:
            out.append(f"antecedent = {joint.antecedent}")
        for key in ("gamma", "b", "alpha", "d", "theta", "r"):
            if not getattr(joint, key).is_zero:
                out.append(f"{key} = {scalar(getattr(joint, key))}")
        if joint.movable:
            words = ", ".join(f'"{word}"' for word in joint.friction)
            out.append(f"friction = [{words}]")
            if joint.coulomb_width:
                out.append(f"coulomb_width = {joint.coulomb_width!r}")
            out.append(f"rotor_inertia = {str(joint.rotor_inertia).lower()}")
    for coupling in robot.couplings:
        out += ["", "[[coupling]]", f"joints = [{coupling.first}, {coupling.second}]"]
        out.append(f"ratio = {scalar(coupling.ratio)}")
    if robot.payload is not None:
        out += ["", "[payload]", f"joint = {robot.payload}"]
    if robot.limits is not None:
        out += ["", "[limits]"]
        for key in ("position", "velocity", "acceleration", "torque"):
            values = getattr(robot.limits, key)
            if values is not None:
                out.append(f"{key} = {plain_list(values)}")
    return "\n".join(out) + "\n"
