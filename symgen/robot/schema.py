"""Read the tables of a robot file as the frozen dataclasses of `tables` and `types`.

A message contains the table, the key, and what is accepted.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import MISSING, fields
from decimal import Decimal
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

import sympy as sp

from symgen.errors import RobotError, located, shortened
from symgen.robot import expressions
from symgen.robot.exact_numbers import written_fraction
from symgen.robot.tables import ANGLE, BESIDE, NOTATION, PER_JOINT, Before, Check, JointNumber

Table = TypeVar("Table")
# cached, because evaluating annotations takes longer than reading a table
_hints = cache(get_type_hints)
_LARGEST = 100  # decimal exponent of the largest number
_MAX_DENOMINATOR = 10_000
_MAX_TURNS = 2
_PLAIN = {int: "an integer", bool: "true or false", str: "a text in quotes"}


def keys(kind: type) -> Mapping[str, Any]:
    """Return the keys of a table, a dataclass, with their annotations."""
    hints = _hints(kind, include_extras=True)
    return {key: hint for key, hint in hints.items() if BESIDE not in get_args(hint)}


def per_joint(kind: type) -> list[str]:
    """Return the keys of a table with one entry for each movable joint."""
    return [key for key, hint in keys(kind).items() if PER_JOINT in get_args(hint)]


def require_keys(table: Any, known: Collection[str], place: str) -> None:
    """Raise RobotError with the accepted keys if a value is not a table, or has an unknown key."""
    if not isinstance(table, dict):
        raise RobotError(
            f"{place}: is not a table; accepted: [name] with keys below it, [[name]] where it "
            "repeats"
        )
    for key in table:
        if key not in known:
            notation = NOTATION if key == "a" else ""
            raise RobotError(
                f"{place}, key {shortened(key)!r}: unknown key; accepted: {', '.join(known)}"
                f"{notation}"
            )


class TableReader:
    """Reads the tables of one file.

    Attributes:
        joints: number of joints.
        movable: numbers of the movable joints.
        floats: whether the base floats.
        geometry: the named lengths and angles, with their exact values.
    """

    def __init__(self, joints: int = 0, movable: Collection[int] = ()) -> None:
        self.joints, self.movable = joints, movable
        self.floats = False
        self.geometry: dict[str, sp.Expr] = {}

    def table(self, kind: type[Table], table: Any, place: str, **more: Any) -> Table:
        """Return a table as a frozen value.

        Args:
            kind: the dataclass.
            table: the content in the file.
            place: name of the table in messages, such as "joint 2".
            more: values of the fields that are not keys.

        Raises:
            RobotError: a key is unknown or missing, or its value is not accepted.
        """
        known = keys(kind)
        require_keys(table, known, place)
        found = dict(more)
        for key, value in table.items():
            found[key] = self.value(known[key], value, f"{place}, key {key!r}")
        for f in fields(kind):  # type: ignore[arg-type]  # every kind is a dataclass
            if f.name not in found and f.default is MISSING and f.default_factory is MISSING:
                checks = [m for m in get_args(known[f.name]) if isinstance(m, Check)]
                needed = f"accepted: {checks[0].accepted}" if checks else "it must be given"
                raise RobotError(f"{place}, key {f.name!r}: is missing; {needed}")
        return kind(**found)

    def value(self, hint: Any, value: Any, place: str) -> Any:
        """Return a value of the file as its annotation describes it."""
        origin, parts = get_origin(hint), get_args(hint)
        if origin is Annotated:
            return self._checked(parts[0], parts[1:], value, place)
        if origin in (Union, UnionType):  # a list or not; no file can contain None
            chosen = parts[1] if isinstance(value, list) and parts[1] is not NoneType else parts[0]
            return self.value(chosen, value, place)
        if origin is tuple:
            return self._list(parts, value, place)
        if origin is dict:
            require_keys(value, value, place)
            found = {}
            for key, x in value.items():
                inner = f"{place}, {shortened(key)!r}"
                found[self.value(parts[0], key, inner)] = self.value(parts[1], x, inner)
            return found
        if hint is float:
            return finite_number(value, place)
        if hint is sp.Expr:
            with located(place):
                return self.expression(value, self.geometry)
        if type(value) is not hint:
            raise RobotError(f"{place}: accepted: {_PLAIN[hint]}")
        return value

    def _checked(self, hint: Any, marks: tuple[Any, ...], value: Any, place: str) -> Any:
        for mark in marks:
            if isinstance(mark, Before):
                value = mark.convert(value)
        value = self.value(hint, value, place)
        if PER_JOINT in marks and len(value) != len(self.movable):
            raise RobotError(
                f"{place}: {len(value)} entries; accepted: one for each of the "
                f"{len(self.movable)} movable joints"
            )
        for mark in marks:
            if isinstance(mark, JointNumber):
                self._require_joint(value, mark, place)
            if isinstance(mark, Check) and not mark.passes(value):
                raise RobotError(f"{place}: accepted: {mark.accepted}")
        return self.angle(value, place) if ANGLE in marks else value

    def _require_joint(self, number: int, mark: JointNumber, place: str) -> None:
        """Refuse a joint number that the file does not contain, or that is not movable."""
        if mark.movable and number not in self.movable:
            accepted = ", ".join(map(str, self.movable))
            raise RobotError(f"{place}: {number} is not a movable joint; accepted: {accepted}")
        least = 0 if mark.base or (mark.link and self.floats) else 1
        if not least <= number <= self.joints:
            raise RobotError(
                f"{place}: there is no joint {number}; accepted: {least} to {self.joints}"
            )

    def _list(self, parts: tuple[Any, ...], value: Any, place: str) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise RobotError(f"{place}: is not a list; accepted: [...] ([] for none)")
        hints = [parts[0]] * len(value) if parts[-1] is Ellipsis else parts
        if len(hints) != len(value):
            raise RobotError(f"{place}: {len(value)} entries; accepted: {len(hints)}")
        pairs = enumerate(zip(hints, value, strict=True), 1)
        return tuple(self.value(hint, x, f"{place}, entry {k}") for k, (hint, x) in pairs)

    def at_values(self, expr: sp.Expr) -> sp.Expr:
        """Substitute the values of the named lengths."""
        named = {s: self.geometry[s.name] for s in expr.free_symbols if s.name in self.geometry}
        return expr.subs(named) if named else expr  # most expressions are plain numbers

    def expression(self, value: Any, known: Collection[str]) -> sp.Expr:
        """Return a number or a text of the safe grammar as an exact expression.

        Args:
            value: the value in the file.
            known: names that may occur.

        Raises:
            RobotError: the value is not an expression, or is not finite and real.
        """
        if not isinstance(value, str):
            finite_number(value, "", " or an expression in quotes")
        written = repr(shortened(str(value)))
        try:
            expr = (
                expressions.parse(value, tuple(known))
                if isinstance(value, str)
                else expressions.exact(value)
            )
            with located(written):
                expressions.check_finite(self.at_values(expr))
                # sqrt(L1**2) is |L1|: the value in the file determines the sign.
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
        """Return an angle with decimals replaced by the fractions of pi that they equal.

        Raises:
            RobotError: the angle is not in rad, or a fraction of pi with too large a denominator.
        """
        with located(place):
            exact = sp.Add(*(written_fraction(_rational(term)) for term in sp.Add.make_args(expr)))
            with located(repr(expressions.text(expr))):
                expressions.check_plain(exact)
            value = float(self.at_values(exact).evalf(30))
            if abs(value) > _MAX_TURNS * math.tau:
                raise RobotError(
                    f"{value:.6g} rad is over two turns; accepted: angles in rad, not degrees"
                )
            for term in sp.Add.make_args(sp.expand(exact)):
                factor, base = term.as_coeff_Mul()
                if base is sp.pi and factor.q > _MAX_DENOMINATOR:
                    raise RobotError(
                        f"{expressions.text(term)}; accepted: fractions of pi with a "
                        f"denominator of at most {_MAX_DENOMINATOR}"
                    )
        return exact


def finite_number(value: Any, place: str, more: str = "") -> float:
    """Return a number from a file.

    Raises:
        RobotError: it is not a finite number; `more` is appended to the accepted input.
    """
    start = f"{place}: accepted: " if place else "accepted: "
    if isinstance(value, bool) or not isinstance(value, (int, float, Decimal)):
        raise RobotError(f"{start}a number{more}")
    found = Decimal(value)
    if not found.is_finite() or found.adjusted() > _LARGEST:
        raise RobotError(f"{start}a finite number under 1e{_LARGEST}{more}")
    return float(found)


def _rational(term: sp.Expr) -> sp.Expr:
    factor, rest = term.as_independent(*term.free_symbols, as_Add=False)
    return sp.radsimp(factor) * rest if factor.has(sp.Pow) else term
