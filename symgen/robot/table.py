"""The Denavit-Hartenberg table of a robot in words, for terminals and notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy as sp

from symgen.robot.expressions import text

if TYPE_CHECKING:
    from symgen.robot.types import Robot

_KEYS = ("gamma", "b", "alpha", "d", "theta", "r")
HEADER = ("joint", "name", "sigma", "antecedent", *_KEYS, "follows")


def table_rows(robot: Robot) -> list[tuple[str, ...]]:
    """Return a row for each joint of the file, as `HEADER` names the cells."""
    return [
        (
            str(j.number),
            j.name,
            str(j.sigma),
            str(j.antecedent),
            *(_short(getattr(j, key)) for key in _KEYS),
            "" if j.follows is None else text(j.follows),
        )
        for j in robot.joints
    ]


def _short(expr: sp.Expr) -> str:
    """Write an exact value; one that is no short decimal with 9 digits."""
    written = text(expr)
    return f"{float(expr):.9g}" if expr.is_Rational and len(written) > 12 else written
