"""Effects beyond rigid-body dynamics and friction: the library, and those of a robot.

An effect is a torque that acts on a joint and is linear in its coefficients:

    tau_motor = rigid body + friction - sum of effects,     column = -d(torque)/d(coefficient)

effects.toml is the library. A robot file can also define an effect by a torque.
"""

from __future__ import annotations

import re
import string
import tomllib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from typing import Annotated, Any

import sympy as sp

from symgen import names
from symgen.errors import RobotError, located
from symgen.robot import expressions
from symgen.robot.schema import TableReader
from symgen.robot.tables import BESIDE, word_check

#: Names with exact values.
Named = tuple[tuple[str, sp.Expr], ...]
#: Variables of a library torque on its joint. The last three are for effects of kind log only:
#: torque and friction of the model, and the time from the start of the log.
OWN = ("q", "qd", "qdd", "taur", "tau", "friction", "t")
#: Largest number of constants of an effect that a diagnosis searches.
MAX_RANGES = 2
#: Quantities on which the residual of an effect depends.
_PATTERNS = (
    "velocity-sign", "velocity", "low-speed", "reversal", "position", "spectrum", "load",
    "acceleration", "kinematic", "other-joint", "time", "all",
)  # fmt: skip
#: Sources of an error, with "file": the robot file is wrong.
PHYSICS, RECORDER = "physics", "recorder"
#: Scale of the values of a constant in a search, and its unit in effects.toml.
_SCALES = {
    "speed": "speed",
    "range": "position",
    "play": "position",
    "place": "position",
    "duration": "s",
    "angle": "rad",
    "turn": "",
    "gear": "",
}
_PERIODS = ("turn", "gear")  # per turn of a revolute joint, per meter of a prismatic one
#: Unit words of effects.toml by joint type: each unit with its exponent.
_POSITION = {names.REVOLUTE: {"rad": 1}, names.PRISMATIC: {"m": 1}}
_TORQUE = {names.REVOLUTE: {"N": 1, "m": 1}, names.PRISMATIC: {"N": 1}}
_QUANTITIES = ("torque", "position", "speed", "acceleration", "rad", "m", "s", "1")
_QUANTITY = re.compile(rf"({'|'.join(_QUANTITIES)})([2-9]?)")


@dataclass(frozen=True)
class SearchRange:
    """The values of a constant that a search tries: from low to high, in multiples of `scale`."""

    low: float
    high: float
    count: int
    scale: str = ""
    by_ratio: bool = False


@dataclass(frozen=True)
class Definition:
    """An effect of the library (a table of effects.toml), or of a robot file (`own`).

    A torque from a file contains the variables of any joint, and full names of coefficients and
    constants. Names in a library torque get the number of the joint. effects.toml describes the
    keys.
    """

    name: Annotated[str, BESIDE]
    kind: Annotated[str, word_check("linear", "model", "log")]
    pattern: Annotated[str, word_check(*_PATTERNS)]
    says: str
    torque: str = ""
    linear: dict[str, str] = field(default_factory=dict)
    nonlinear: Annotated[Mapping[str, SearchRange], BESIDE] = field(default_factory=dict)
    native: str = ""
    offset: bool = False
    motor: bool = False
    sign: Annotated[str, word_check("positive", "any")] = "any"
    confused: str = ""
    separate: str = ""
    formula: str = ""
    odds: float = 0.02
    size: float = 0.3
    expected: float = 0.0
    begins: float = 0.0
    presumes: str = ""
    side: Annotated[str, word_check(PHYSICS, RECORDER, "file")] = PHYSICS
    advice: str = ""
    own: Annotated[bool, BESIDE] = False

    @property
    def declarable(self) -> bool:
        """Whether [[effect]] in a robot file may use this effect."""
        return self.kind != "log" and bool(self.torque) and not self.native

    def unit_of(self, constant: str, sigma: int) -> str:
        """Return the unit of a constant, from the scale of its search."""
        scale = self.nonlinear[constant].scale if constant in self.nonlinear else ""
        if scale in _PERIODS and sigma == names.PRISMATIC:
            return "1/m"
        return effect_unit(_SCALES.get(scale, ""), sigma)

    def named(self, name: str, joint: int | str) -> str:
        """Return the full name of a coefficient or constant on a joint."""
        return name if self.own else f"{name}{joint}"

    def coefficients(self, joint: int | str, sigma: int) -> tuple[tuple[str, str], ...]:
        """Return the full name and the unit of each coefficient on a joint of this type."""
        return tuple(
            (self.named(name, joint), written if self.own else effect_unit(written, sigma))
            for name, written in self.linear.items()
        )


@dataclass(frozen=True)
class Effect:
    """One effect of a robot.

    Attributes:
        name: name in the library, or in the file.
        joint: number of the joint on which it acts.
        linear: name and unit of each coefficient.
        nonlinear: name and value of each constant.
        torque: torque on the joint, in q1, qd1, ... and the names above.
        own: whether the file defines the torque, and not the library.
    """

    name: str
    joint: int
    linear: tuple[tuple[str, str], ...]
    nonlinear: Named
    torque: sp.Expr
    own: bool = False

    @property
    def joints(self) -> tuple[int, ...]:
        """The joint, for tables with a list of joints."""
        return (self.joint,)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its coefficients, then of its constants."""
        return tuple(name for name, _ in (*self.linear, *self.nonlinear))

    @property
    def kind(self) -> str:
        """ "linear", or "model" if the torque depends on the rigid-body torque."""
        return "model" if any(self.loads(name) for name, _ in self.linear) else "linear"

    def loads(self, coefficient: str) -> bool:
        """Return whether the torque of a coefficient depends on the rigid-body torque, taur."""
        return bool(self.column(coefficient).has(sp.Symbol(f"taur{self.joint}", real=True)))

    @property
    def constants(self) -> Named:
        """The constants with their names in the file, without the joint number of the library."""
        if self.own:
            return self.nonlinear
        library = definitions()[self.name].nonlinear
        return tuple((n, value) for n, (_, value) in zip(library, self.nonlinear, strict=True))

    def column(self, coefficient: str) -> sp.Expr:
        """Return the regressor column of a coefficient, at the values of the constants."""
        constants = {sp.Symbol(name, real=True): value for name, value in self.nonlinear}
        return -sp.diff(self.torque, sp.Symbol(coefficient, real=True)).subs(constants)


def distinct(effects: Sequence[Effect], taken: Iterable[str]) -> tuple[Effect, ...]:
    """Return effects with distinct names: library effects get a letter if a name is taken: FSM2b.

    Args:
        effects: effects in the order of the file; the first one with a name keeps it.
        taken: names of lengths and of parameters of couplings.
    """
    used = {*taken, *(name for e in effects if e.own for name in e.names)}
    out = []
    for effect in effects:
        if not effect.own:
            free = {name: _free(name, used) for name in effect.names}
            used |= set(free.values())
            symbols = {sp.Symbol(a, real=True): sp.Symbol(b, real=True) for a, b in free.items()}
            effect = replace(
                effect,
                linear=tuple((free[name], unit) for name, unit in effect.linear),
                nonlinear=tuple((free[name], value) for name, value in effect.nonlinear),
                torque=effect.torque.xreplace(symbols),
            )
        out.append(effect)
    return tuple(out)


def _free(name: str, used: Collection[str]) -> str:
    """Return a name that is free, with a letter from b on if needed."""
    letters = iter(string.ascii_lowercase[1:])
    free = name
    while free in used:
        free = name + next(letters)
    return free


_SCALE = Annotated[str, word_check(*_SCALES)]
_GRID = tuple[float, float, int]


@cache
def definitions() -> Mapping[str, Definition]:
    """Return the library of effects by name."""
    text = (resources.files("symgen.robot") / "effects.toml").read_text("utf-8")
    with located("effects.toml"):
        return {name: definition(name, table) for name, table in tomllib.loads(text).items()}


def described(name: str) -> Definition:
    """Return the row of an effect; the library says nothing on those of a robot file."""
    own = Definition(name, "linear", "all", "an effect of the robot file")
    return definitions().get(name, own)


def definition(name: str, table: Mapping[str, Any]) -> Definition:
    """Return an effect of the library.

    Args:
        name: name of the effect.
        table: its table in effects.toml.

    Raises:
        RobotError: a key is missing or its value is not accepted; the message names both.
    """
    reader = TableReader()
    kept = {key: value for key, value in table.items() if key not in ("nonlinear", "scale")}
    scales = reader.value(dict[str, _SCALE], table.get("scale", {}), f"[{name}], key 'scale'")
    grids = reader.value(dict[str, _GRID], table.get("nonlinear", {}), f"[{name}], key 'nonlinear'")
    searches = {}
    for key, (low, high, count) in grids.items():
        scale = scales.get(key, "")
        by_ratio = low > 0 and scale not in _PERIODS
        searches[key] = SearchRange(low, high, count, scale, by_ratio)
    found = reader.table(Definition, kept, f"[{name}]", name=name, nonlinear=searches)
    for key, unit in found.linear.items():
        with located(f"[{name}], key 'linear', {key!r}"):
            effect_unit(unit, names.REVOLUTE)
    return found


@dataclass(frozen=True)
class Sought:
    """An effect with constants that a diagnosis searches.

    Attributes:
        effect: the effect, with the lower end of each range as its value.
        ranges: (constant, lower end, upper end), exact, with names from the file.
    """

    effect: Effect
    ranges: tuple[tuple[str, sp.Expr, sp.Expr], ...]

    @property
    def key(self) -> tuple[str, int]:
        """Its name and joint number, which are unique."""
        return self.effect.name, self.effect.joint

    @property
    def torque(self) -> str:
        """The torque as a text; constants without a range have their values."""
        searched = {name for name, *_ in self.ranges}
        fixed = {sp.Symbol(n, real=True): v for n, v in self.effect.constants if n not in searched}
        return expressions.text(self.effect.torque.subs(fixed))

    def ends(self, lengths: Mapping[sp.Symbol, sp.Expr]) -> dict[str, tuple[float, float]]:
        """Return the ends of each range.

        Args:
            lengths: values of the named lengths that the ranges may contain.
        """
        pairs = ((name, low.subs(lengths), high.subs(lengths)) for name, low, high in self.ranges)
        return {name: (float(low), float(high)) for name, low, high in pairs}


def require_constants(sought: Sequence[Sought]) -> None:
    """Raise RobotError if effects have ranges, because the robot then has no model."""
    for s in sought:
        (name, joint), (constant, *ends) = s.key, s.ranges[0]
        low, high = map(expressions.text, ends)
        raise RobotError(
            f"effect {name!r} of joint {joint}: {constant} is the range [{low}, {high}], which "
            "`symgen diagnose` searches; accepted in a model: a number"
        )


def effect_unit(written: str, sigma: int) -> str:
    """Return the unit for a unit of effects.toml on a joint of this type.

    Args:
        written: quantities with exponents, separated by a slash: "torque/speed2" is N m s2/rad2.
        sigma: type of the joint.

    Raises:
        RobotError: a word is not a quantity.
    """
    if written == "torque/acceleration":
        return names.unit("IA", sigma)
    exponents: dict[str, int] = {}
    for place, word in enumerate(written.split("/") if written else []):
        match = _QUANTITY.fullmatch(word)
        if match is None:
            raise RobotError(
                f"{word!r} in the unit {written!r}; accepted: {', '.join(_QUANTITIES)}, with an "
                "exponent behind it (speed2), and / between two"
            )
        power = int(match[2] or 1) * (-1 if place else 1)
        for unit, exponent in _units(match[1], sigma).items():
            exponents[unit] = exponents.get(unit, 0) + power * exponent
    over = [_power(unit, e) for unit, e in exponents.items() if e > 0]
    under = [_power(unit, -e) for unit, e in exponents.items() if e < 0]
    if not under:
        return " ".join(over)
    below = under[0] if len(under) == 1 else f"({' '.join(under)})"
    return f"{' '.join(over) or '1'}/{below}"


def _units(quantity: str, sigma: int) -> Mapping[str, int]:
    """Return the units of a quantity with their exponents."""
    if quantity == "torque":
        return _TORQUE[sigma]
    orders = {"position": 0, "speed": 1, "acceleration": 2}
    if quantity == "1":
        return {}
    if quantity not in orders:
        return {quantity: 1}
    order = orders[quantity]
    return {**_POSITION[sigma], **({"s": -order} if order else {})}


def _power(unit: str, exponent: int) -> str:
    return unit if exponent == 1 else f"{unit}{exponent}"


def numbered(definition: Definition, joint: int | str) -> str:
    """Return the torque of an effect with the joint number appended to its names."""
    if definition.own:
        return definition.torque
    own = {*OWN, *definition.linear, *definition.nonlinear} - {"t"}
    return re.sub(
        r"[A-Za-z]\w*", lambda m: f"{m[0]}{joint}" if m[0] in own else m[0], definition.torque
    )
