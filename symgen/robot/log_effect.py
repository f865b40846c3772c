"""Effects that depend on what a log has beside the motion: known by their values, on samples alone.

No kernel takes a temperature. The torque of such an effect is linear in coefficients that a
diagnosis has found and a robot file gives; it is taken off the torques of every log that is read
for the robot, and what is left is that of the model.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from symgen.errors import RobotError
from symgen.robot.effect import Definition, definitions
from symgen.robot.expressions import shortened


@dataclass(frozen=True)
class LogEffect:
    """One effect on the samples of a joint.

    Attributes:
        name: of the library.
        joint: its number.
        values: of every coefficient, then of every constant, by their names in the library.
    """

    name: str
    joint: int
    values: tuple[tuple[str, sp.Expr], ...]

    @property
    def definition(self) -> Definition:
        """Its table of the library."""
        return definitions()[self.name]


def is_log_effect(name: str) -> bool:
    """Whether an effect of the library depends on what logs have beside the motion."""
    return name in definitions() and bool(definitions()[name].reads)


def read_log_effects(
    tables: Iterable[Any],
    value: Callable[[Any, str], sp.Expr],
    movable: Mapping[int, int],
    fail: Callable[[str], RobotError],
) -> tuple[LogEffect, ...]:
    """Return the effects on samples that the [[effect]] tables of a robot file declare.

    Args:
        tables: the validated ones, of which those of other effects are left out.
        value: gives the exact value of what the file writes at a place.
        movable: type of every movable joint by its number.
        fail: makes an error that names the file.

    Raises:
        RobotError: the message names table and key.
    """
    out: dict[tuple[str, int], LogEffect] = {}
    for number, table in enumerate(tables, 1):
        if not is_log_effect(table.name):
            continue
        place = f"effect {number}"
        _require_values_alone(table, place, fail)
        for j in table.joints:
            if j not in movable:
                raise fail(f"{place}, key 'joints': {j} is not a movable joint")
            if (table.name, j) in out:
                raise fail(f"{place}: a second {table.name} on joint {j}")
            values = tuple(
                (name, value(table.values[name], f"{place}, key 'values'"))
                for name in _names(table.name)
            )
            out[table.name, j] = LogEffect(table.name, j, values)
    return tuple(out.values())


def _names(effect: str) -> tuple[str, ...]:
    d = definitions()[effect]
    return (*d.linear, *d.nonlinear)


def _require_values_alone(table: Any, place: str, fail: Callable[[str], RobotError]) -> None:
    for key in ("torque", "linear", "nonlinear"):
        if getattr(table, key):
            raise fail(f"{place}, key {key!r}: {table.name} has values alone")
    wanted = _names(table.name)
    if set(table.values) != set(wanted):
        given = ", ".join(map(shortened, table.values)) or "none"
        raise fail(
            f"{place}, key 'values': {given}; accepted: a number for each of {', '.join(wanted)}, "
            "as symgen diagnose finds them"
        )
    if not table.joints:
        raise fail(f"{place}, key 'joints': at least one")
