"""Effects beyond rigid-body dynamics and friction: the library, and the effects of a robot.

An effect is a torque that acts on a joint and is linear in its coefficients:

    tau_motor = rigid body + friction - sum of effects,     column = -d(torque)/d(coefficient)

effects.toml is the library. A robot file can also define an effect with its own torque.
"""

from __future__ import annotations

import re
import string
import tomllib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache
from importlib import resources
from typing import Any

import sympy as sp

from symgen import names
from symgen.errors import RobotError, located
from symgen.robot import expressions

#: Names with their exact values.
Named = tuple[tuple[str, sp.Expr], ...]
#: Variables of the joint on which a library torque may depend, and the time from the start of the
#: log; the last three are for effects of kind log: torque and friction of the model.
OWN = ("q", "qd", "qdd", "taur", "tau", "friction", "t")
#: Largest number of constants of an effect that a diagnosis searches.
MAX_RANGES = 2
_POSITION = {names.REVOLUTE: "rad", names.PRISMATIC: "m"}
_TORQUE = {names.REVOLUTE: "N m", names.PRISMATIC: "N"}


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

    The torque of an own effect names the variables of any joint, with full names of coefficients
    and constants. Names of a library effect get the number of the joint.
    """

    name: str
    kind: str
    pattern: str
    says: str
    torque: str = ""
    linear: Mapping[str, str] = field(default_factory=dict)
    nonlinear: Mapping[str, SearchRange] = field(default_factory=dict)
    native: str = ""
    offset: bool = False
    sign: str = "any"
    confused: str = ""
    separate: str = ""
    formula: str = ""
    own: bool = False

    @property
    def declarable(self) -> bool:
        """Whether [[effect]] of a robot file may name it."""
        return self.kind != "log" and bool(self.torque) and not self.native

    def unit_of(self, constant: str, sigma: int) -> str:
        """Return the unit of a constant, which follows from the scale of its search."""
        scale = self.nonlinear[constant].scale if constant in self.nonlinear else ""
        per_length = "" if sigma == names.REVOLUTE else "1/m"
        units = {"speed": effect_unit("speed", sigma), "duration": "s"}
        units |= dict.fromkeys(("play", "range", "place"), effect_unit("position", sigma))
        units |= dict.fromkeys(("turn", "gear"), per_length)
        return units.get(scale, "")

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
        joints: numbers of the joints on which it acts.
        linear: name and unit of each coefficient.
        nonlinear: name and value of each constant.
        torque: (joint, torque on it), in q1, qd1, ... and the names above.
        own: whether the file defines the torque, rather than the library.
    """

    name: str
    joints: tuple[int, ...]
    linear: tuple[tuple[str, str], ...]
    nonlinear: Named
    torque: tuple[tuple[int, sp.Expr], ...]
    own: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its coefficients, then of its constants."""
        return tuple(name for name, _ in (*self.linear, *self.nonlinear))

    @property
    def kind(self) -> str:
        """ "linear", or "model" if the torque depends on the rigid-body torque."""
        return "model" if any(self.loads(name) for name, _ in self.linear) else "linear"

    def loads(self, coefficient: str) -> bool:
        """Whether the torque of a coefficient depends on the rigid-body torque, taur."""
        loads = {sp.Symbol(f"taur{j}", real=True) for j in self.joints}
        return any(c.has(*loads) for c in self.columns(coefficient).values())

    @property
    def constants(self) -> Named:
        """The constants with their names in the file, without the joint number of the library."""
        if self.own:
            return self.nonlinear
        library = definitions()[self.name].nonlinear
        return tuple((n, value) for n, (_, value) in zip(library, self.nonlinear, strict=True))

    def columns(self, coefficient: str) -> dict[int, sp.Expr]:
        """Return the regressor column of a coefficient by joint, at the constants' values."""
        constants = {sp.Symbol(name, real=True): value for name, value in self.nonlinear}
        symbol = sp.Symbol(coefficient, real=True)
        found = {j: -sp.diff(t, symbol).subs(constants) for j, t in self.torque}
        return {j: c for j, c in found.items() if c != 0}


def distinct(effects: Sequence[Effect], taken: Iterable[str]) -> tuple[Effect, ...]:
    """Return effects, those of the library with a letter after each name that is taken: FSM2b.

    Args:
        effects: in the order of the file; the first with a name keeps it.
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
                torque=tuple((j, torque.xreplace(symbols)) for j, torque in effect.torque),
            )
        out.append(effect)
    return tuple(out)


def _free(name: str, used: Collection[str]) -> str:
    """Return a name, with the first letter from b on that makes it a new one."""
    letters = iter(string.ascii_lowercase[1:])
    free = name
    while free in used:
        free = name + next(letters)
    return free


@cache
def effect_tables() -> Mapping[str, Mapping[str, Any]]:
    """Return the tables of effects.toml by name."""
    return tomllib.loads((resources.files("symgen.robot") / "effects.toml").read_text("utf-8"))


@cache
def definitions() -> Mapping[str, Definition]:
    """Return the library of effects by name."""
    known = {f.name for f in fields(Definition)}
    out = {}
    for name, table in effect_tables().items():
        scale = table.get("scale", {})
        searches = {}
        for key, (low, high, count) in table.get("nonlinear", {}).items():
            unit = scale.get(key, "")
            by_ratio = low > 0 and unit not in ("turn", "gear")
            searches[key] = SearchRange(float(low), float(high), int(count), unit, by_ratio)
        kept = {key: value for key, value in table.items() if key in known}
        out[name] = Definition(**{**kept, "name": name, "nonlinear": searches})
    return out


@dataclass(frozen=True)
class Sought:
    """An effect whose constants a diagnosis searches.

    Attributes:
        effect: the effect, with the lower end of each range as its value.
        ranges: (constant, lower end, upper end), exact, with names from the file.
    """

    effect: Effect
    ranges: tuple[tuple[str, sp.Expr, sp.Expr], ...]

    @property
    def key(self) -> tuple[str, int]:
        """Its name and the number of its joint, which are unique."""
        return self.effect.name, self.effect.joints[0]

    @property
    def torque(self) -> str:
        """The torque as a text; constants without a range have their values."""
        searched = {name for name, *_ in self.ranges}
        fixed = {sp.Symbol(n, real=True): v for n, v in self.effect.constants if n not in searched}
        ((_, torque),) = self.effect.torque
        return expressions.text(torque.subs(fixed))

    def ends(self, lengths: Mapping[sp.Symbol, sp.Expr]) -> dict[str, tuple[float, float]]:
        """Return the ends of each range.

        Args:
            lengths: values of the named lengths that the ranges may contain.
        """
        pairs = ((name, low.subs(lengths), high.subs(lengths)) for name, low, high in self.ranges)
        return {name: (float(low), float(high)) for name, low, high in pairs}


def require_constants(sought: Sequence[Sought]) -> None:
    """Refuse a robot whose effects still have ranges: it has no model.

    Raises:
        RobotError: an effect has a range; the message names the first.
    """
    for s in sought:
        (name, joint), (constant, *ends) = s.key, s.ranges[0]
        low, high = map(expressions.text, ends)
        raise RobotError(
            f"effect {name!r} of joint {joint}: {constant} is the range [{low}, {high}], which "
            "`symgen diagnose` searches; accepted in a model: a number"
        )


def effect_unit(written: str, sigma: int) -> str:
    """Return the unit for a unit word of effects.toml on a joint of this type."""
    words = {
        "torque": _TORQUE[sigma],
        "position": _POSITION[sigma],
        "speed": f"{_POSITION[sigma]}/s",
        "position2": f"{_POSITION[sigma]}2",
        "position3": f"{_POSITION[sigma]}3",
        "acceleration": f"{_POSITION[sigma]}/s2",
    }
    if written == "torque/speed":
        return names.unit("FV", sigma)
    if written == "torque/acceleration":
        return names.unit("IA", sigma)
    return "/".join(words.get(word, word) for word in written.split("/"))


def numbered(definition: Definition, joint: int | str) -> str:
    """Return the torque of an effect with the joint number appended to its names."""
    if definition.own:
        return definition.torque
    own = {*OWN, *definition.linear, *definition.nonlinear} - {"t"}
    return re.sub(
        r"[A-Za-z]\w*", lambda m: f"{m[0]}{joint}" if m[0] in own else m[0], definition.torque
    )


def of_library(
    definition: Definition,
    joint: int,
    sigma: int,
    constants: Mapping[str, sp.Expr],
    geometry: Mapping[str, sp.Expr] | None = None,
) -> Effect:
    """Return an effect of the library on one joint.

    Args:
        definition: from `definitions`.
        joint: number of the joint.
        sigma: type of the joint.
        constants: name in the library -> value of each nonlinear constant.
        geometry: values of the named lengths that the constants may contain.

    Raises:
        RobotError: a constant is missing or unknown, or the torque has no finite value.
    """
    if set(constants) != set(definition.nonlinear):
        accepted = ", ".join(definition.nonlinear) or "none"
        raise RobotError(f"constants {', '.join(constants) or 'none'}; accepted: {accepted}")
    own = {f"{n}{joint}": constants[n] for n in definition.nonlinear}
    variables = [f"{n}{joint}" for n in (*OWN, *definition.linear)]
    torque = _torque(numbered(definition, joint), variables, own, geometry or {})
    return Effect(
        name=definition.name,
        joints=(joint,),
        linear=definition.coefficients(joint, sigma),
        nonlinear=tuple(own.items()),
        torque=((joint, torque),),
    )


def _torque(
    text: str,
    variables: Collection[str],
    constants: Mapping[str, sp.Expr],
    geometry: Mapping[str, sp.Expr],
) -> sp.Expr:
    """Parse a torque. Its constants stay symbols; their values must be accepted too.

    Raises:
        RobotError: the torque is not an expression of the grammar.
    """
    functions = expressions.EFFECT_FUNCTIONS
    known = (*variables, *constants, *geometry)
    lengths = {sp.Symbol(name, real=True): value for name, value in geometry.items()}
    values = {**geometry, **{name: c.subs(lengths) for name, c in constants.items()}}
    with located("key 'torque'"):
        expr = expressions.parse(text, known, functions)
        expressions.check_powers(expr)
        # Refuse what could not be read again from a file that symgen writes.
        expr = expressions.parse(expressions.text(expr), known, functions)
        expressions.check_powers(expressions.parse(text, known, functions, values))
    return expr


def of_file(
    name: str,
    joint: int,
    torque: str,
    linear: Mapping[str, str],
    nonlinear: Mapping[str, sp.Expr],
    variables: Collection[str],
    geometry: Mapping[str, sp.Expr],
) -> Effect:
    """Return an effect with a torque from a robot file.

    Args:
        name: name in the file.
        joint: number of the joint on which it acts.
        torque: expression, linear in the names of `linear`.
        linear: coefficient -> unit.
        nonlinear: constant -> value.
        variables: q1, qd1, ... that may occur.
        geometry: named length -> value; these may occur too.

    Raises:
        RobotError: the torque is not of the grammar, or not linear in its coefficients.
    """
    expr = _torque(torque, (*variables, *linear), nonlinear, geometry)
    symbols = [sp.Symbol(n, real=True) for n in linear]
    rest = expr.subs(dict.fromkeys(symbols, 0))
    slopes = [sp.diff(expr, s) for s in symbols]
    if not symbols or rest != 0 or any(d.has(*symbols) for d in slopes):
        raise RobotError(
            f"key 'torque': {expressions.shortened(torque)!r} is not a sum of the coefficients of "
            "'linear', each times an expression without them"
        )
    load = sp.Symbol(f"taur{joint}", real=True)
    if not all(_degree(d, load) in (0, 1) for d in slopes):
        raise RobotError(
            f"key 'torque': {expressions.shortened(torque)!r} is not of the form "
            f"a*taur{joint} + b*abs(taur{joint}) for a coefficient that taur{joint} goes with, "
            "with a and b of positions and speeds"
        )
    for key, declared in (("linear", linear), ("nonlinear", nonlinear)):
        for n in declared:
            if sp.Symbol(n, real=True) not in expr.free_symbols:
                raise RobotError(f"key {key!r}: {n} does not occur in the torque")
    return Effect(
        name=name,
        joints=(joint,),
        linear=tuple(linear.items()),
        nonlinear=tuple(nonlinear.items()),
        torque=((joint, expr),),
        own=True,
    )


def _degree(expr: sp.Expr, load: sp.Symbol) -> sp.Expr | None:
    """Return k if the expression is abs(load)**k times its value at sign(load), else None.

    With k = 1, forward dynamics has a closed form.
    """
    if expr == load:
        return sp.S.One
    if not expr.has(load):
        return sp.S.Zero
    degrees = [_degree(part, load) for part in expr.args]
    if any(k is None for k in degrees):
        return None
    if expr.is_Add:
        return degrees[0] if len(set(degrees)) == 1 else None
    if expr.is_Mul:
        return sp.Add(*degrees)
    if expr.is_Pow and not expr.exp.has(load):
        return degrees[0] * expr.exp
    if expr.func is sp.Abs:
        return degrees[0]
    if expr.func is sp.sign or not any(degrees):
        return sp.S.Zero
    return None


def from_table(
    table: Any,
    constants: Mapping[str, sp.Expr],
    movable: Mapping[int, int],
    geometry: Mapping[str, sp.Expr],
) -> list[Effect]:
    """Return the effects of one [[effect]] table, one for each joint.

    Args:
        table: the validated table: name, joints, torque, linear.
        constants: nonlinear constant -> exact value.
        movable: number of each movable joint -> its type.
        geometry: named length of the file -> value.

    Raises:
        RobotError: the message names the key.
    """
    known = definitions()
    if not table.torque:
        chosen = known.get(table.name)
        if chosen is None or not chosen.declarable:
            where = "" if chosen is None else f" ({_declared_by(chosen)})"
            accepted = ", ".join(n for n, d in known.items() if d.declarable)
            raise RobotError(
                f"key 'name': {expressions.shortened(table.name)!r} is no effect that needs no "
                f"'torque'{where}; accepted: {accepted}, or an own name with a torque"
            )
        if table.linear:
            raise RobotError("key 'linear': an effect of the library has its own")
        return [of_library(chosen, j, movable[j], constants, geometry) for j in table.joints]
    if table.name in known:
        raise RobotError(f"key 'torque': {table.name} is an effect of the library and has its own")
    if len(table.joints) != 1:
        raise RobotError("key 'joints': an effect with a torque acts on one joint")
    j = table.joints[0]
    known_names = torque_variables(j, movable)
    return [of_file(table.name, j, table.torque, table.linear, constants, known_names, geometry)]


def torque_variables(joint: int, movable: Iterable[int]) -> list[str]:
    """Return the variables that the torque of an own effect may contain.

    Args:
        joint: number of the joint on which it acts.
        movable: numbers of all movable joints.
    """
    return [*(f"{letter}{k}" for letter in ("q", "qd") for k in movable), f"taur{joint}"]


def _declared_by(definition: Definition) -> str:
    if definition.native in ("coulomb", "viscous", "offset"):
        return f"a word of the joint's friction: {definition.native!r}"
    if definition.native:
        return {"rotor": "rotor_inertia of the joint"}.get(
            definition.native, f"a table of its own: {definition.native}"
        )
    return f"kind {definition.kind}: a robot file does not declare it"
