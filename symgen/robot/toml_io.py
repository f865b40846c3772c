"""Read robots: robot.toml, other formats, generated packages, and the library."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from symgen import names
from symgen.errors import RobotError, SymgenWarning, located, told_by
from symgen.files import load_toml
from symgen.robot import exact_numbers, expressions
from symgen.robot.builtin import library, library_text
from symgen.robot.effect import (
    COUNTS,
    Effect,
    Sought,
    from_table,
)
from symgen.robot.exact_numbers import written_fraction
from symgen.robot.expressions import shortened
from symgen.robot.identifiers import (
    MAX_NAME,
    is_coefficient_name,
    is_geometry_name,
    is_robot_name,
)
from symgen.robot.imported import FORMATS, Imported, read_text
from symgen.robot.loop_check import require_closed
from symgen.robot.types import (
    ANGLES,
    GRAVITY_INPUT,
    LENGTHS,
    MAX_RATIO,
    OF_JOINTS,
    Coupling,
    Drive,
    Frame,
    Joint,
    Limits,
    Loop,
    Robot,
    Servo,
    joint_variable,
)

if TYPE_CHECKING:
    from symgen.robot.schema import EffectTable, FrameTable, JointTable, RobotFile

_MAX_DENOMINATOR = 10_000
_FOLLOWS = (
    "a joint that follows others has none of its own; accepted: on the joints that it follows, or "
    "as [[coupling]]"
)
_MAX_TURN = 4 * math.pi
#: Largest condition number of a matrix of gears, its rows scaled to unit length.
_MAX_CONDITION = 1e6


def read_robot(source: Robot | str | Path) -> Robot:
    """Read a robot from a file, a generated package, or the built-in library.

    Args:
        source: path of a robot.toml, .urdf, .par or .xml file; path of a folder with a robot.toml;
            or name of a library robot. A Robot is returned unchanged.

    Returns:
        The robot, with exact geometry.

    Raises:
        RobotError: there is no such robot, or the file is not a valid one.
    """
    if isinstance(source, Robot):
        return source
    accepted = (
        f"accepted: a path to robot.toml, a .urdf, a .par, an MJCF (.xml), a generated package, or "
        f"{', '.join(library())}"
    )
    if str(source) in library() and not Path(source).exists():
        return parse_robot(library_text(str(source)), f"library robot {source}")
    text, path = read_text(source, accepted)
    if path.suffix.lower() not in FORMATS:
        return parse_robot(text, str(path))
    imported = parse_imported(text, path)
    for line in imported.assumed:
        warnings.warn(f"{path}: {line}", SymgenWarning, stacklevel=2)
    return imported.robot


def read_imported(path: str | Path) -> Imported:
    """Read a .urdf, a .par of SYMORO, or an .xml of MuJoCo.

    Raises:
        RobotError: the file cannot be read, or symgen cannot represent the robot.
    """
    accepted = f"accepted: a path to a file with the ending {' or '.join(FORMATS)}"
    if Path(path).suffix.lower() not in FORMATS:
        raise RobotError(f"{shortened(str(path)) or '(empty)'}: not such a file; {accepted}")
    return parse_imported(*read_text(path, accepted))


def parse_imported(text: str, path: Path) -> Imported:
    """Read the text of a file; its ending gives the format.

    Raises:
        RobotError: symgen cannot represent the robot.
    """
    name = FORMATS[path.suffix.lower()]
    module = import_module(f"symgen.robot.formats.{name}")
    found: Imported = getattr(module, f"import_{name}")(text, str(path))
    return found


def parse_robot(text: str, where: str = "robot.toml") -> Robot:
    """Read a robot from the text of a robot.toml.

    Args:
        text: the file's text.
        where: name of the file in error messages.

    Raises:
        RobotError: the text is not a valid robot; the message names the joint and the key.
    """
    from symgen.robot.schema import validated

    with located(where):
        try:
            data = load_toml(text.removeprefix("\ufeff"), parse_float=Decimal)
        except (RecursionError, ArithmeticError, ValueError) as error:
            raise RobotError(f"not valid TOML: {told_by(error)}") from error
        return _Reader(where).robot(validated(data))


def _frames(tables: Sequence[FrameTable], joints: int) -> tuple[Frame, ...]:
    """Return the frames of a file.

    Raises:
        RobotError: two have one name, or there is no such joint.
    """
    known: set[str] = set()
    for table in tables:
        with located(f"frame {shortened(table.name)!r}"):
            if table.name in known:
                raise RobotError("the name stands twice; accepted: each name once")
            if table.joint > joints:
                raise RobotError(f"there is no joint {table.joint}; accepted: 0 to {joints}")
        known.add(table.name)
    return tuple(Frame(**vars(table)) for table in tables)


class _Reader:
    """Builds a Robot from a validated file; `where` names the file in warnings."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.geometry: dict[str, sp.Expr] = {}

    def robot(self, file: RobotFile) -> Robot:
        name = file.robot.name
        if not is_robot_name(name):
            raise RobotError(
                f"robot, key 'name': {shortened(name)!r} is not accepted; accepted: a C identifier "
                f"of at most {MAX_NAME} characters that is no word and no header of C"
            )
        for key, value in file.geometry.items():
            if not is_geometry_name(key):
                raise RobotError(
                    f"geometry, key {shortened(key)!r}: reserved, or not a C identifier"
                )
            with located(f"geometry, key {key!r}"):
                self.geometry[key] = written_fraction(self.expression(value, ()))
        rotors = file.drive is None or file.drive.side == "motor"
        joints = tuple(self.joint(k, table, rotors) for k, table in enumerate(file.joint, 1))
        pairs = list(zip(joints, file.joint, strict=True))
        movable = [j for j, table in pairs if j.movable and table.follows is None]
        if not movable:
            raise RobotError("no joint is movable; accepted: at least one sigma of 0 or 1")
        joints = tuple(
            j if table.follows is None else self.following(j, table, movable) for j, table in pairs
        )
        gravity: tuple[sp.Expr, ...] = GRAVITY_INPUT
        if file.robot.gravity != "input":
            with located("robot, key 'gravity'"):
                gravity = tuple(self.expression(g, self.geometry) for g in file.robot.gravity)
        sigma = {j.number: j.sigma for j in movable}
        effects, sought = self.effects(file, sigma)
        payload = None if file.payload is None else file.payload.joint
        if payload is not None and payload > len(joints):
            raise RobotError(f"payload, key 'joint': there is no joint {payload}")
        robot = Robot(
            name=name,
            gravity=(gravity[0], gravity[1], gravity[2]),
            joints=joints,
            geometry=tuple(self.geometry.items()),
            couplings=self.couplings(file, joints),
            payload=payload,
            limits=self.limits(file, len(movable)),
            loops=tuple(Loop(*table.cut) for table in file.loop),
            effects=tuple(effects),
            sought=tuple(sought),
            drive=self.drive(file, len(movable)),
            frames=_frames(file.frame, len(joints)),
            controller=self.controller(file, len(movable)),
            log_columns="" if file.log is None else file.log.columns,
        )
        require_closed(robot)
        return robot

    def at_values(self, expr: sp.Expr) -> sp.Expr:
        """Substitute the values of the named lengths."""
        named = {s: self.geometry[s.name] for s in expr.free_symbols if s.name in self.geometry}
        return expr.subs(named) if named else expr  # most expressions are plain numbers

    def expression(self, value: int | Decimal | str, known: Collection[str]) -> sp.Expr:
        written = repr(shortened(str(value)))
        try:
            expr = (
                expressions.parse(value, tuple(known))
                if isinstance(value, str)
                else expressions.exact(value)
            )
            with located(written):
                expressions.check_finite(self.at_values(expr))
                # sqrt(L1**2) is |L1|: the sign comes from the value in the file.
                expr = expr.replace(
                    lambda e: e.func is sp.Abs,
                    lambda e: e.args[0] if self.at_values(e.args[0]) >= 0 else -e.args[0],
                )
                expressions.check_plain(expr)
                expressions.check_plain(self.at_values(expr))
        except (ArithmeticError, ValueError, TypeError, RecursionError) as error:
            raise RobotError(f"{written} has no finite real value") from error
        return expr

    def angle(self, expr: sp.Expr, place: str) -> sp.Expr:
        """Replace decimals by the fractions of pi that they equal; refuse angles not in rad."""
        exact = sp.Add(*(written_fraction(_rationalised(term)) for term in sp.Add.make_args(expr)))
        with located(repr(expressions.text(expr))):
            expressions.check_plain(exact)
        value = float(self.at_values(exact).evalf(30))
        if abs(value) > _MAX_TURN:
            raise RobotError(
                f"{value:.6g} rad is over two turns; accepted: angles in rad, not degrees"
            )
        for term in sp.Add.make_args(sp.expand(exact)):
            number, base = term.as_coeff_Mul()
            if base is sp.pi and number.q > _MAX_DENOMINATOR:
                raise RobotError(
                    f"{expressions.text(term)}; accepted: fractions of pi with a "
                    f"denominator of at most {_MAX_DENOMINATOR}"
                )
        near = exact_numbers.fraction_of_pi(exact_numbers.context().mpf(value))
        if near is not None and (self.at_values(exact) - near * sp.pi).evalf(30) != 0:
            meant = expressions.text(near * sp.pi)
            warnings.warn(
                f"{self.where}: {place}: {shortened(expressions.text(exact))} is within 1e-4 of "
                f"{meant}, but not it; write {meant!r} if that is meant",
                SymgenWarning,
                stacklevel=2,
            )
        return exact

    def joint(self, number: int, table: JointTable, rotors: bool) -> Joint:
        antecedent = number - 1 if table.antecedent is None else table.antecedent
        if antecedent >= number:
            raise RobotError(
                f"joint {number}, key 'antecedent': {antecedent} is not an earlier joint; "
                f"accepted: 0 (the base) to {number - 1}"
            )
        fixed = table.sigma == names.FIXED
        rotor = rotors if table.rotor_inertia is None else table.rotor_inertia
        plain = fixed or table.follows is not None
        for key in (k for k in ("friction", "rotor_inertia", "coulomb_width") if plain):
            if getattr(table, key):
                what = "a fixed joint (sigma 2) has none" if fixed else _FOLLOWS
                raise RobotError(f"joint {number}, key {key!r}: {what}")
        friction = table.friction if table.friction is not None else ["coulomb", "viscous"]
        if len(set(friction)) != len(friction):
            raise RobotError(f"joint {number}, key 'friction': a word stands twice")
        values = {}
        for key in LENGTHS:
            with located(place := f"joint {number}, key {key!r}"):
                exact = self.expression(getattr(table, key), self.geometry)
                values[key] = self.angle(exact, place) if key in ANGLES else exact
        return Joint(
            number=number,
            sigma=table.sigma,
            antecedent=antecedent,
            friction=() if plain else tuple(w for w in names.FRICTION if w in friction),
            coulomb_width=float(table.coulomb_width),
            rotor_inertia=not plain and rotor,
            name=table.name,
            actuated=table.actuated,
            **values,
        )

    def following(self, joint: Joint, table: JointTable, movable: list[Joint]) -> Joint:
        """Return a joint whose position is linear in the variables of other joints."""
        with located(place := f"joint {joint.number}, key 'follows'"):
            return self.linear(joint, table.follows or "", movable, place)

    def linear(self, joint: Joint, text: str, movable: list[Joint], place: str) -> Joint:
        """Return a joint that follows a linear expression in the variables of other joints."""
        if joint.fixed:
            raise RobotError("a fixed joint (sigma 2) follows none")
        variables = {f"q{j.number}": j for j in movable}
        expr = sp.expand(self.expression(text, (*self.geometry, *variables)))
        joint = replace(joint, follows=expr)
        linear = sum((c * joint_variable(k) for k, c in joint.shares), joint.offset)
        accepted = "a sum of numbers times variables of movable joints, such as 'pi/2 + q7 - q2'"
        if not joint.shares or sp.expand(linear - expr) != 0:
            raise RobotError(f"{shortened(text)!r}; accepted: {accepted}")
        turns, shares = joint.turns, sp.S.Zero
        for k, c in joint.shares:
            factor, written = self.at_values(c), f"the factor of q{k} is {expressions.text(c)}"
            shares += factor * joint_variable(k)
            if {s.name for s in c.free_symbols} & set(variables):
                raise RobotError(f"not linear in q{k}; accepted: {accepted}")
            if factor.is_zero:
                raise RobotError(f"the factor of q{k} is 0 at the file's values")
            if turns and not (variables[f"q{k}"].turns and factor.is_Rational):
                raise RobotError(
                    f"{written}; accepted for a revolute joint: fractions, of the variables of "
                    "revolute joints"
                )
            if turns and abs(factor) > MAX_RATIO:
                raise RobotError(
                    f"{written}, which makes its rounding as much larger; accepted: at most "
                    f"{MAX_RATIO} in size"
                )
        if turns:
            self.angle(joint.offset, place)
            joint = replace(joint, follows=shares + joint.offset)
        return joint

    def couplings(self, file: RobotFile, joints: tuple[Joint, ...]) -> tuple[Coupling, ...]:
        found: list[Coupling] = []
        for number, table in enumerate(file.coupling, 1):
            first, second = table.joints
            with located(f"coupling {number}, key 'joints'"):
                for j in (first, second):
                    if not 1 <= j <= len(joints) or not joints[j - 1].movable:
                        raise RobotError(f"{j} is not a movable joint")
                if first == second:
                    raise RobotError("two different joints are needed")
                if any(second == c.second or {first, second} == {c.first, c.second} for c in found):
                    raise RobotError(f"a second coupling of the same joints or number {second}")
            with located(f"coupling {number}, key 'ratio'"):
                ratio = self.expression(table.ratio, self.geometry)
                if self.at_values(ratio).is_zero:
                    raise RobotError("zero couples nothing")
            found.append(Coupling(first, second, ratio))
        return tuple(found)

    def effects(
        self, file: RobotFile, sigma: Mapping[int, int]
    ) -> tuple[list[Effect], list[Sought]]:
        """Return effects of the model, and effects to search."""
        found: list[Effect] = []
        sought: list[Sought] = []
        for number, table in enumerate(file.effect, 1):
            joints = table.joints
            for j in joints:
                if j not in sigma:
                    raise RobotError(f"effect {number}, key 'joints': {j} is not a movable joint")
            if len(set(joints)) != len(joints) or not joints:
                raise RobotError(
                    f"effect {number}, key 'joints': each joint once, and at least one"
                )
            with located(f"effect {number}"):
                here, ranges = self.effect(table, sigma)
                earlier = (*found, *(s.effect for s in sought))
                others = [e for e in earlier if e.own or here[0].own or e.name == table.name]
                taken = {*self.geometry, *(n for e in others for n in e.names)}
                for name in (n for e in here for n in e.names):
                    if name in taken:
                        raise RobotError(f"{name} is declared twice")
                    taken.add(name)
                if not ranges:
                    found += here
                    continue
                wanted = [Sought(e, ranges) for e in here]
                for name, joint in {s.key for s in sought} & {s.key for s in wanted}:
                    raise RobotError(
                        f"a second {shortened(name)!r} to be searched on joint {joint}; accepted: "
                        "another name"
                    )
                sought += wanted
        return found, sought

    def effect(
        self, table: EffectTable, sigma: Mapping[int, int]
    ) -> tuple[list[Effect], tuple[tuple[str, sp.Expr, sp.Expr], ...]]:
        """Return the effects of a table, with the lower end of each range, and the ranges."""
        for name in table.linear:
            if not is_coefficient_name(name):
                raise RobotError(
                    f"key 'linear': {shortened(name)!r}: reserved, or not a capital letter "
                    "followed by letters and digits"
                )
        for name in table.nonlinear:
            if not is_geometry_name(name):
                raise RobotError(f"{shortened(name)!r}: reserved, or no C identifier")
        with located("key 'nonlinear'"):
            ends = {key: self.ends(value) for key, value in table.nonlinear.items()}
            ranges = tuple((name, *pair) for name, pair in ends.items() if len(pair) == 2)
            if len(ranges) > max(COUNTS):
                raise RobotError(
                    f"{len(ranges)} ranges; accepted: at most {max(COUNTS)}, and numbers for the "
                    "others"
                )
        lowest, *_ = [  # the torque must be valid at every corner of the ranges
            from_table(table, dict(zip(ends, corner, strict=True)), sigma, self.geometry)
            for corner in itertools.product(*ends.values())
        ]
        return lowest, ranges

    def ends(
        self, value: int | Decimal | str | tuple[int | Decimal | str, ...]
    ) -> tuple[sp.Expr, ...]:
        """Return the value of a constant, or both ends of its range."""
        values = value if isinstance(value, tuple) else (value,)
        out = tuple(self.expression(end, self.geometry) for end in values)
        if len(out) == 2 and self.at_values(out[0] - out[1]) >= 0:
            low, high = (shortened(expressions.text(end)) for end in out)
            raise RobotError(
                f"the range [{low}, {high}] is empty; accepted: [low, high], low below high"
            )
        return out

    def entries(self, table: str, values: Any, keys: Sequence[str], n: int) -> dict[str, Any]:
        """Return the entries of a table for n movable joints, or None if it has none."""
        out = {key: getattr(values, key) for key in keys}
        for key, given in out.items():
            if given is not None and len(given) != n:
                raise RobotError(
                    f"{table}, key {key!r}: {len(given)} entries; accepted: one for each of the "
                    f"{n} movable joints"
                )
        return {key: None if given is None else tuple(given) for key, given in out.items()}

    def limits(self, file: RobotFile, n: int) -> Limits | None:
        table = file.limits
        if table is None:
            return None
        columns = self.entries("limits", table, OF_JOINTS, n)
        for low, high in table.position or ():
            if low >= high:
                raise RobotError(f"limits, key 'position': [{low}, {high}] is empty")
        for k, box in enumerate(table.boxes, 1):
            if any(low >= high for low, high in box):
                what = "empty; accepted: [[x, x], [y, y], [z, z]]"
                raise RobotError(f"limits, key 'boxes', entry {k}: {what}")
        return Limits(**columns, floor=table.floor, tool=table.tool, boxes=tuple(table.boxes))

    def controller(self, file: RobotFile, n: int) -> Servo | None:
        table = file.controller
        if table is None:
            return None
        return Servo(**self.entries("controller", table, ("kp", "kd"), n), scale=table.scale)

    def drive(self, file: RobotFile, n: int) -> Drive | None:
        table = file.drive
        if table is None:
            return None
        if not table.model_fields_set:
            raise RobotError(
                "drive: declares nothing; accepted: ratio, torque_constant, gain or side"
            )
        ratio = table.ratio or [1.0] * n
        if len(ratio) != n:
            raise RobotError(
                f"drive, key 'ratio': {len(ratio)} entries; accepted: one number for each of the "
                f"{n} movable joints, or a {n} x {n} matrix"
            )
        matrix = np.array(ratio) if isinstance(ratio[0], list) else np.diag(ratio)
        sizes = np.linalg.norm(matrix, axis=1)
        if not sizes.all() or np.linalg.cond(matrix / sizes[:, None]) > _MAX_CONDITION:
            raise RobotError(
                "drive, key 'ratio': the matrix is singular; accepted: q_motor = N q_joint that "
                "can be solved for q_joint"
            )
        side = "joint" if table.side == "link" else "motor"
        return Drive(
            tuple(map(tuple, matrix.tolist())),
            position_side=table.position_side or side,
            torque_side=table.torque_side or side,
            **self.entries("drive", table, ("torque_constant", "gain", "gain_std"), n),
        )


def _rationalised(term: sp.Expr) -> sp.Expr:
    number, rest = term.as_independent(*term.free_symbols, as_Add=False)
    return sp.radsimp(number) * rest if number.has(sp.Pow) else term
