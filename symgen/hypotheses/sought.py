"""The effects of a robot file whose constants are ranges, with the grids of a search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from symgen.robot.effect import Definition, SearchRange, Sought, described

#: Number of ranges of an effect -> number of values that a search tries for each constant.
_COUNTS = {1: 20, 2: 12}
_BY_RATIO = 10  # ratio of the ends above which the values are spaced geometrically


def sought_searches(sought: Sought, lengths: Mapping[Any, Any]) -> dict[str, SearchRange]:
    """Return the search range of each constant that has a range in the robot file.

    Args:
        sought: the effect.
        lengths: values of the named lengths that the ranges may contain, by symbol.
    """
    out = {}
    for name, (low, high) in sought.ends(lengths).items():
        by_ratio = low > 0 and high > _BY_RATIO * low
        out[name] = SearchRange(low, high, _COUNTS[len(sought.ranges)], by_ratio=by_ratio)
    return out


def sought_definition(sought: Sought, lengths: Mapping[Any, Any]) -> Definition:
    """Return the definition of an effect to search: from the library, or from the robot file.

    Args:
        sought: the effect.
        lengths: as for `sought_searches`.
    """
    effect = sought.effect
    row = described(effect.name)
    if not effect.own:
        return row
    return replace(
        row,
        kind=effect.kind,
        torque=sought.torque,
        linear=dict(effect.linear),
        nonlinear=sought_searches(sought, lengths),
        odds=0.5,
        size=1.0,
        own=True,
    )
