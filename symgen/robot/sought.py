"""Effects of a robot file whose constants are ranges: no part of the model, tried by `diagnose`."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from symgen.errors import RobotError
from symgen.robot.effect import Definition, Effect, Search, definitions, from_table
from symgen.robot.expressions import text

#: Values that are tried of each constant, by the number of ranges of an effect.
COUNTS = {1: 20, 2: 12}
_BY_RATIO = 10  # the ends' ratio above which the values are spaced by ratio


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
            torque=text(torque.subs(fixed)),
            linear=dict(self.effect.linear),
            nonlinear=searches,
            own=True,
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


def read_effects(
    table: Any,
    ends: Mapping[str, Sequence[sp.Expr]],
    movable: Mapping[int, int],
    geometry: Mapping[str, sp.Expr],
) -> tuple[list[Effect], list[Sought]]:
    """Return what one [[effect]] table declares, and what it wants to be searched: one a joint.

    Args:
        table: the validated table.
        ends: exact value of every constant, or both ends of its range.
        movable: type of every movable joint by its number.
        geometry: value of each of the file's named lengths.

    Raises:
        RobotError: the message names the key.
    """
    ranges = tuple((name, pair[0], pair[1]) for name, pair in ends.items() if len(pair) == 2)
    if len(ranges) > max(COUNTS):
        raise RobotError(
            f"key 'nonlinear': {len(ranges)} ranges; accepted: at most {max(COUNTS)}, and numbers "
            "for the others"
        )
    corners = [
        table.model_copy(update={"nonlinear": dict(zip(ends, corner, strict=True))})
        for corner in itertools.product(*ends.values())
    ]
    lowest, *_ = [from_table(corner, movable, geometry) for corner in corners]
    return ([], [Sought(e, ranges) for e in lowest]) if ranges else (lowest, [])


def require_constants(sought: Sequence[Sought]) -> None:
    """Refuse a model of a robot with effects that are to be searched.

    Raises:
        RobotError: the message names the first of them.
    """
    for s in sought:
        (name, joint), (constant, *ends) = s.key, s.ranges[0]
        low, high = map(text, ends)
        raise RobotError(
            f"effect {name!r} of joint {joint}: {constant} is the range [{low}, {high}], which "
            "`symgen diagnose` searches; accepted in a model: a number"
        )
