"""Read SYMORO+ and OpenSYMORO files (.par): tables of `key = {...}` in the same DH notation.

A .par names lengths without values. They become names of [geometry], with values that the user must
replace. The joint variable (th2, t2, r3) is removed from theta or r; an added constant remains.
Format: W. Khalil, A. Vijayalingam et al., OpenSYMORO (2014).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path

import sympy as sp

from symgen import names
from symgen.errors import RobotError, located
from symgen.robot import exact_numbers, expressions
from symgen.robot.effect import Named
from symgen.robot.expressions import shortened
from symgen.robot.identifiers import is_geometry_name, robot_name
from symgen.robot.imported import Imported
from symgen.robot.types import ANGLES, EARTH, LENGTHS, MAX_JOINTS, Joint, Robot

_COMMENT = re.compile(r"\(\*.*?\*\)", re.DOTALL)
_TITLE = re.compile(r"\(\*\s*Robotname\s*=\s*'([^']*)'\s*\*\)", re.IGNORECASE)
_ENTRY = re.compile(r"([A-Za-z_]\w*)[ \t]*=[ \t]*(\{[^{}]*\}|[^\s{}]+)", re.ASCII)
_NUMBER = re.compile(r"[0-9]{1,4}")  # no other Unicode digits
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_VARIABLE = {
    names.REVOLUTE: re.compile(r"(?:th|theta|t|q)([0-9]+)", re.IGNORECASE),
    names.PRISMATIC: re.compile(r"(?:r|q)([0-9]+)", re.IGNORECASE),
}
_TYPES = ("0 (simple chain)", "1 (tree)")


def import_par(text: str, where: str = "robot.par") -> Imported:
    """Read a .par as a robot; inertial entries that are numbers become parameter values.

    Args:
        text: the file's text.
        where: name of the file in error messages.

    Raises:
        RobotError: the text is not a .par, or not an open chain; the message names the entry.
    """
    with located(where):
        return _Reader(text, Path(where).stem).imported()


class _Reader:
    """The entries of one file, and the names found in them."""

    def __init__(self, text: str, stem: str) -> None:
        title = _TITLE.search(text)
        self.title = title.group(1) if title else stem
        self.entries: dict[str, str] = {}
        for key, value in _ENTRY.findall(_COMMENT.sub(" ", text)):
            # Ant and ant, B and b are one key; G is gravity, g none.
            key = key.lower() if key.lower() in ("ant", "sigma", *LENGTHS) else key
            if key in self.entries:
                raise RobotError(f"{key}: the key stands twice")
            self.entries[key] = value
        self.joints = self.count("NJ")
        self.require_open()
        self.geometry: dict[str, bool] = {}  # name -> whether it is an angle
        self.notes: list[str] = []

    def count(self, key: str) -> int:
        value = self.entries.get(key)
        if value is None or not _NUMBER.fullmatch(value) or not 1 <= int(value) <= MAX_JOINTS:
            found = "is missing" if value is None else f"is {shortened(value)!r}"
            raise RobotError(f"{key} {found}; accepted: a number from 1 to {MAX_JOINTS}")
        return int(value)

    def require_open(self) -> None:
        """Refuse closed chains and moving bases."""
        links = self.count("NL") if "NL" in self.entries else self.joints
        if self.joints != links or self.entries.get("Type", "0") not in ("0", "1"):
            raise RobotError(
                f"{self.joints} joints, {links} links and Type "
                f"{shortened(self.entries.get('Type', '0'))}: not an open chain; accepted: Type "
                f"{' or '.join(_TYPES)}; write a parallelogram as robot.toml with 'follows'"
            )
        if self.entries.get("is_mobile", "0").lower() not in ("0", "false"):
            raise RobotError("is_mobile: the base moves; accepted: 0, a base at rest")

    def items(self, key: str, size: int, default: str | None = "0") -> list[str]:
        """Return the entries of a list."""
        if key not in self.entries and default is None:
            raise RobotError(f"{key} is missing; accepted: a list of {size} entries")
        value = self.entries.get(key, f"{{{','.join([default or ''] * size)}}}")
        items = [item.strip() for item in value.strip("{}").split(",")]
        if not value.startswith("{") or len(items) != size or not all(items):
            raise RobotError(
                f"{key} is {shortened(value)}; accepted: a list {{...}} of {size} entries"
            )
        return items

    def integers(self, key: str, accepted: Collection[int]) -> list[int]:
        items = self.items(key, self.joints, None)
        for number, item in enumerate(items, 1):
            if not _NUMBER.fullmatch(item) or int(item) not in accepted:
                raise RobotError(
                    f"{key}, entry {number}: {shortened(item)!r}; accepted: "
                    f"{', '.join(map(str, accepted))}"
                )
        return [int(item) for item in items]

    def imported(self) -> Imported:
        sigma = self.integers("sigma", (0, 1, 2))
        antecedent = self.integers("ant", range(self.joints + 1))
        for number, before in enumerate(antecedent, 1):
            if before >= number:
                raise RobotError(
                    f"ant, entry {number}: {before} is not an earlier joint; accepted: 0 (the "
                    f"base) to {number - 1}"
                )
        if set(sigma) == {names.FIXED}:
            raise RobotError("sigma: no joint is movable; accepted: at least one 0 or 1")
        table = {key: self.column(key, sigma) for key in (*ANGLES, "b", "d", "r")}
        declared = {key: self.declared(key) for key in ("FS", "FV", names.ROTOR)}
        joints = tuple(
            Joint(
                number=i + 1,
                sigma=sigma[i],
                antecedent=antecedent[i],
                friction=tuple(
                    word
                    for word in ("coulomb", "viscous")
                    if sigma[i] != names.FIXED and declared[names.FRICTION[word]][i]
                ),
                rotor_inertia=sigma[i] != names.FIXED and declared[names.ROTOR][i],
                **{key: column[i] for key, column in table.items()},
            )
            for i in range(self.joints)
        )
        geometry, assumed = self.values()
        gravity, more = self.gravity()
        name = robot_name(self.title)
        if name != self.title:
            self.notes.append(f"the robot {shortened(self.title)!r} is called {name}")
        robot = Robot(name=name, gravity=gravity, joints=joints, geometry=geometry)
        parameters = self.parameters(robot)
        return Imported(robot, parameters, tuple(self.notes), (*assumed, *more))

    def column(self, key: str, sigma: Sequence[int]) -> list[sp.Expr]:
        """Return the geometric entries of a list."""
        out = []
        for number, item in enumerate(self.items(key, self.joints), 1):
            with located(f"{key}, entry {number}"):
                out.append(self.entry(key, number, item, sigma[number - 1]))
        return out

    def entry(self, key: str, number: int, item: str, kind: int) -> sp.Expr:
        """Return a geometric entry without the joint variable; names become geometry."""
        expr = _expression(item)
        if (key, kind) in (("theta", names.REVOLUTE), ("r", names.PRISMATIC)):
            expr = _constant(key, number, item, expr, _VARIABLE[kind])
        for symbol in sorted(expr.free_symbols, key=str):
            other = _VARIABLE[names.REVOLUTE].fullmatch(symbol.name) if key == "theta" else None
            if other is not None or not is_geometry_name(symbol.name):
                raise RobotError(
                    f"{shortened(item)!r}: {symbol.name} cannot name a length or an angle; "
                    "accepted: names that are no variable, no parameter and no word of C"
                )
            self.geometry.setdefault(symbol.name, key in ANGLES)
        if key not in ANGLES:
            return expr
        terms = []
        for term in sp.Add.make_args(expr):
            k = exact_numbers.fraction_of_pi(term) if term.is_Rational and term != 0 else None
            if k is not None:
                self.notes.append(f"{key}, entry {number}: {term.evalf(15)} is read as {k * sp.pi}")
            terms.append(term if k is None else k * sp.pi)
        return sp.Add(*terms)

    def declared(self, key: str) -> list[bool]:
        """Return which joints have a parameter; as in SYMORO, 0 means that it does not exist."""
        if key not in self.entries:
            return [True] * self.joints
        return [item not in ("0", "0.0") for item in self.items(key, self.joints)]

    def values(self) -> tuple[Named, list[str]]:
        """Return the named quantities with distinct placeholder values."""
        primes = sp.primerange(29, 10_000)
        geometry = tuple((name, sp.Rational(next(primes), 100)) for name in self.geometry)
        if not geometry:
            return (), []
        shown = ", ".join(
            f"{name} = {expressions.text(value)} {'rad' if self.geometry[name] else 'm'}"
            for name, value in geometry
        )
        return geometry, [f"values that are not in the file, replace them in robot.toml: {shown}"]

    def gravity(self) -> tuple[tuple[sp.Expr, sp.Expr, sp.Expr], list[str]]:
        """Return gravity in frame 0; one named component is -9.81."""
        items = self.items("G", 3) if "G" in self.entries else ["0", "0", "G3"]
        with located("G"):
            values = list(map(_expression, items))
        named = [i for i, value in enumerate(values) if value.free_symbols]
        if len(named) > 1 or any(not values[i].is_Symbol for i in named):
            raise RobotError("G: accepted: three numbers, or one name among them")
        if named:
            axis = "xyz"[named[0]]
            line = f"gravity {items[named[0]]} has no value in the file: -9.81 m/s2 along {axis}0"
            values[named[0]] = EARTH
        return (values[0], values[1], values[2]), [line] if named else []

    def parameters(self, robot: Robot) -> tuple[tuple[str, float], ...]:
        """Return the numeric entries of the parameter lists, for parameters that exist."""
        found: list[tuple[str, float]] = []
        for joint in robot.joints:
            friction = {names.FRICTION[word] for word in joint.friction}
            keys = [k for k in (*names.LINK, names.ROTOR, "FS", "FV") if k in self.entries]
            for key in keys:
                name, item = f"{key}{joint.number}", self.items(key, self.joints)[joint.number - 1]
                has = key in names.LINK or key in friction
                if item == name or not (has or (key == names.ROTOR and joint.rotor_inertia)):
                    continue
                with located(f"{key}, entry {joint.number}"):
                    value = _expression(item)
                if value.free_symbols:
                    self.notes.append(f"{name} is {shortened(item)!r} in the file: left out")
                else:
                    found.append((name, float(value.evalf(17))))
        return tuple(found)


def _expression(item: str) -> sp.Expr:
    """Return an entry as an exact expression in any names."""
    item = re.sub(r"\bPi\b", "pi", item)
    return expressions.parse(item, sorted(set(_NAME.findall(item)) - {"pi", "sqrt"}))


def _constant(key: str, number: int, item: str, expr: sp.Expr, pattern: re.Pattern[str]) -> sp.Expr:
    """Remove the joint variable from theta or r."""
    own = [
        s
        for s in expr.free_symbols
        if (match := pattern.fullmatch(s.name)) and int(match.group(1)) == number
    ]
    rest = expr - own[0] if len(own) == 1 else expr
    if len(own) != 1 or own[0] in sp.expand(rest).free_symbols:
        variable = f"th{number}" if key == "theta" else f"r{number}"
        raise RobotError(
            f"{shortened(item)!r}; accepted: the joint's variable "
            f"{variable}, and a constant added to it"
        )
    return sp.expand(rest)
