"""Effects beyond rigid body and friction: their definitions, and one effect on a robot's joints.

An effect is the torque that it exerts ON a joint, linear in its coefficients:

    tau_motor = rigid body + friction - sum of effects,     column = -d(torque)/d(coefficient)

The library is effects.toml; an effect of a robot file may give its own torque instead.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any

import sympy as sp

from symgen import names
from symgen.errors import RobotError, located
from symgen.robot import expressions

#: Names with their exact values.
Named = tuple[tuple[str, sp.Expr], ...]
#: What a torque of the library may depend on, of its own joint.
OWN = ("q", "qd", "qdd", "taur")
#: And on columns of a log beside the motion, which no kernel takes; kind log then.
BESIDE = ("temp",)
#: Values that are tried of each constant, by the number of ranges of an effect.
COUNTS = {1: 20, 2: 12}
#: Prior odds of an effect that a robot file asks for.
_ASKED = 0.5
_BY_RATIO = 10  # the ends' ratio above which the values are spaced by ratio
_POSITION = {names.REVOLUTE: "rad", names.PRISMATIC: "m"}
_TORQUE = {names.REVOLUTE: "N m", names.PRISMATIC: "N"}


@dataclass(frozen=True)
class Search:
    """The values of a constant that are tried: from low to high, parts of what `scale` says."""

    low: float
    high: float
    count: int
    scale: str = ""
    by_ratio: bool = False


@dataclass(frozen=True)
class Definition:
    """An effect of the library, a table of effects.toml; or an own one.

    The torque of an own one names the variables of any joint, and its coefficients and constants
    have their full names; those of the library get the joint's number.
    """

    name: str
    kind: str
    pattern: str
    says: str
    torque: str = ""
    linear: Mapping[str, str] = field(default_factory=dict)
    nonlinear: Mapping[str, Search] = field(default_factory=dict)
    native: str = ""
    offset: bool = False
    sign: str = "any"
    confused: str = ""
    separate: str = ""
    formula: str = ""
    own: bool = False
    # prior odds that a joint has it, and the part of its joint's torque that is expected of it
    odds: float = 0.02
    size: float = 0.3
    presumes: str = ""  # the friction word that a joint has to have before

    @property
    def reads(self) -> tuple[str, ...]:
        """What of a log beside the motion its torque depends on."""
        used = set() if self.own else set(re.findall(r"[A-Za-z]\w*", self.torque))
        return tuple(role for role in BESIDE if role in used)

    @property
    def declarable(self) -> bool:
        """Whether [[effect]] of a robot file may name it: its torque is part of the dynamics."""
        return self.kind != "log" and bool(self.torque) and not self.native

    def unit_of(self, constant: str, sigma: int) -> str:
        """Return the unit of a constant, as its range is part of a speed or of a log's duration."""
        scale = self.nonlinear[constant].scale if constant in self.nonlinear else ""
        per_length = "" if sigma == names.REVOLUTE else "1/m"
        units = {"speed": unit("speed", sigma), "duration": "s"}
        units |= dict.fromkeys(("turn", "gear"), per_length) | {"mean temp": "degC"}
        return units.get(scale, "")

    def named(self, name: str, joint: int | str) -> str:
        """Return the full name of a coefficient or constant on a joint."""
        return name if self.own else f"{name}{joint}"

    def coefficients(self, joint: int | str, sigma: int) -> tuple[tuple[str, str], ...]:
        """Return full name and unit of every coefficient on a joint of this type."""
        return tuple(
            (self.named(name, joint), written if self.own else unit(written, sigma))
            for name, written in self.linear.items()
        )


@dataclass(frozen=True)
class Effect:
    """One effect of a robot.

    Attributes:
        name: of the library, or the file's own.
        joints: numbers of the joints that it acts on.
        linear: name and unit of every coefficient.
        nonlinear: name and value of every constant.
        torque: (joint, torque on it), in q1, qd1, ... and the names above.
        own: whether the file gives the torque, not the library.
    """

    name: str
    joints: tuple[int, ...]
    linear: tuple[tuple[str, str], ...]
    nonlinear: Named
    torque: tuple[tuple[int, sp.Expr], ...]
    own: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The names that it declares: coefficients, then constants."""
        return tuple(name for name, _ in (*self.linear, *self.nonlinear))

    @property
    def kind(self) -> str:
        """ "linear", or "model" where a torque holds that of the rigid body."""
        return "model" if any(self.loads(name) for name, _ in self.linear) else "linear"

    def loads(self, coefficient: str) -> bool:
        """Whether the torque of a coefficient holds that of the rigid body, taur."""
        loads = {sp.Symbol(f"taur{j}", real=True) for j in self.joints}
        return any(c.has(*loads) for c in self.columns(coefficient).values())

    @property
    def constants(self) -> Named:
        """The constants by their names in the file; the library adds the joint's number."""
        digits = 0 if self.own else len(str(self.joints[0]))
        return tuple((name[: len(name) - digits], value) for name, value in self.nonlinear)

    def columns(self, coefficient: str) -> dict[int, sp.Expr]:
        """Return what a coefficient adds to the motor torque of each joint, constants put in."""
        constants = {sp.Symbol(name, real=True): value for name, value in self.nonlinear}
        symbol = sp.Symbol(coefficient, real=True)
        found = {j: -sp.diff(t, symbol).subs(constants) for j, t in self.torque}
        return {j: c for j, c in found.items() if c != 0}


@cache
def definitions() -> Mapping[str, Definition]:
    """Return the library of effects by name."""
    text = (resources.files("symgen.robot") / "effects.toml").read_text("utf-8")
    out = {}
    for name, table in tomllib.loads(text).items():
        scale = table.pop("scale", {})
        searches = {
            key: Search(
                float(low),
                float(high),
                int(count),
                scale.get(key, ""),
                by_ratio=low > 0 and scale.get(key, "turn") not in ("turn", "gear", "mean temp"),
            )
            for key, (low, high, count) in table.pop("nonlinear", {}).items()
        }
        out[name] = Definition(name=name, nonlinear=searches, **table)
    return out


@dataclass(frozen=True)
class LogEffect:
    """One effect on the samples of a joint: its torque is taken off every log of the robot.

    No kernel takes a temperature; such an effect is linear in coefficients that a diagnosis finds.

    Attributes:
        name: of the library.
        joint: its number.
        values: of every coefficient, then of every constant, by their names in the library.
    """

    name: str
    joint: int
    values: Named

    @property
    def definition(self) -> Definition:
        """Its table of the library."""
        return definitions()[self.name]


@dataclass(frozen=True)
class Sought:
    """One effect to be searched.

    Attributes:
        effect: with the lower end in place of every range.
        ranges: (constant, lower end, upper end), exact, by the names in the file.
    """

    effect: Effect
    ranges: tuple[tuple[str, sp.Expr, sp.Expr], ...]

    @property
    def key(self) -> tuple[str, int]:
        """Its name and its joint's number: one effect of a name is searched on a joint."""
        return self.effect.name, self.effect.joints[0]

    def definition(self, lengths: Mapping[sp.Symbol, sp.Expr]) -> Definition:
        """Return the library's entry; or one of its own, constants that are numbers put in.

        Args:
            lengths: value of every named length that the ranges may hold.
        """
        if not self.effect.own:
            return definitions()[self.effect.name]
        searches = self.searches(lengths)
        fixed = {sp.Symbol(n, real=True): v for n, v in self.effect.constants if n not in searches}
        ((_, torque),) = self.effect.torque
        return Definition(
            name=self.effect.name,
            kind=self.effect.kind,
            pattern="all",
            says="an effect of the robot file",
            torque=expressions.text(torque.subs(fixed)),
            linear=dict(self.effect.linear),
            nonlinear=searches,
            own=True,
            odds=_ASKED,
            size=1.0,
        )

    def searches(self, lengths: Mapping[sp.Symbol, sp.Expr]) -> dict[str, Search]:
        """Return the values that are tried of each searched constant.

        Args:
            lengths: as for `definition`.
        """
        out = {}
        for name, *ends in self.ranges:
            low, high = (float(end.subs(lengths)) for end in ends)
            by_ratio = low > 0 and high > _BY_RATIO * low
            out[name] = Search(low, high, COUNTS[len(self.ranges)], by_ratio=by_ratio)
        return out


def require_constants(sought: Sequence[Sought]) -> None:
    """Refuse a model of a robot with effects that are to be searched.

    Raises:
        RobotError: the message names the first of them.
    """
    for s in sought:
        (name, joint), (constant, *ends) = s.key, s.ranges[0]
        low, high = map(expressions.text, ends)
        raise RobotError(
            f"effect {name!r} of joint {joint}: {constant} is the range [{low}, {high}], which "
            "`symgen diagnose` searches; accepted in a model: a number"
        )


def unit(written: str, sigma: int) -> str:
    """Return the unit that a word of effects.toml stands for on a joint of this type."""
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
    """Return the torque of an effect with the joint's number at every name of its own."""
    if definition.own:
        return definition.torque
    own = {*OWN, *BESIDE, *definition.linear, *definition.nonlinear}
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
        joint: its number.
        sigma: its type.
        constants: value of every nonlinear constant, by its name in the library.
        geometry: value of every named length that the constants may hold.

    Raises:
        RobotError: a constant is missing or unknown, or the torque has no value with it.
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
    """Return a torque with its constants as symbols; at their values it must be of the grammar too.

    Raises:
        RobotError: it is not.
    """
    functions = expressions.EFFECT_FUNCTIONS
    known = (*variables, *constants, *geometry)
    lengths = {sp.Symbol(name, real=True): value for name, value in geometry.items()}
    values = {**geometry, **{name: c.subs(lengths) for name, c in constants.items()}}
    with located("key 'torque'"):
        expr = expressions.parse(text, known, functions)
        expressions.check_powers(expr)
        # As files that symgen writes have it: what cannot be read again is refused now.
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
    """Return an effect whose torque the file gives.

    Args:
        name: what the file calls it.
        joint: number of the joint that it acts on.
        torque: its expression, linear in the names of `linear`.
        linear: unit of every coefficient.
        nonlinear: value of every constant.
        variables: q1, qd1, ... that may occur.
        geometry: value of every named length, which may occur too.

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
    """Return k where an expression is size**k times its value at sign(load), size = abs(load).

    None where its form does not show such a k. With k = 1 forward dynamics has a closed form.
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
    """Return the effects that one [[effect]] table declares: one a joint.

    Args:
        table: the validated table: name, joints, torque, linear.
        constants: exact value of every nonlinear constant.
        movable: type of every movable joint by its number.
        geometry: value of each of the file's named lengths.

    Raises:
        RobotError: the message names the key.
    """
    known = definitions()
    if table.torque is None:
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
    known_names = variables(j, movable)
    return [of_file(table.name, j, table.torque, table.linear, constants, known_names, geometry)]


def variables(joint: int, movable: Iterable[int]) -> list[str]:
    """Return what the torque of a robot file's own effect may depend on.

    Args:
        joint: number of the joint that it acts on.
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
