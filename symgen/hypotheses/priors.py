"""Priors of effects, and the grids of their constants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from symgen.robot.effect import Definition, SearchRange, Sought, definitions, effect_tables
from symgen.robot.schema import TableReader, keys, require_keys

#: Name of the constant of an effect that begins within a log: its time, s.
START = "start"
PHYSICS, RECORDER = "physics", "recorder"
#: Number of ranges of an effect -> number of values that a search tries for each constant.
_COUNTS = {1: 20, 2: 12}
_BY_RATIO = 10  # ratio of the ends above which the values are spaced geometrically


@dataclass(frozen=True)
class EffectPrior:
    """Prior of an effect, from effects.toml.

    Attributes:
        odds: prior odds that a joint has it.
        size: expected share of the joint's torque.
        expected: expected size of a coefficient; 0 to use `size`.
        begins: prior odds that it begins within a log.
        presumes: friction word that the joint must already have.
        side: source of the error: physics, recorder or file.
        advice: what the user can do about it.
    """

    odds: float = 0.02
    size: float = 0.3
    expected: float = 0.0
    begins: float = 0.0
    presumes: str = ""
    side: str = PHYSICS
    advice: str = ""


#: Prior of an effect that a robot file proposes.
_PROPOSED = EffectPrior(odds=0.5, size=1.0)


@cache
def priors() -> Mapping[str, EffectPrior]:
    """Return the priors of the effects of the library by name."""
    reader, expected = TableReader(), keys(EffectPrior)
    described = {*keys(Definition), "nonlinear", "scale"}
    out = {}
    for name, table in effect_tables().items():
        place = f"effects.toml: [{name}]"
        require_keys(table, sorted({*described, *expected}), place)
        kept = {key: value for key, value in table.items() if key not in described}
        out[name] = reader.table(EffectPrior, kept, place)
    return out


def prior_of(definition: Definition) -> EffectPrior:
    """Return the prior of an effect, including one that begins within a log."""
    prior = priors().get(definition.name, _PROPOSED)
    if START in definition.nonlinear:
        return replace(prior, odds=prior.begins, advice="identify from logs in one state")
    return prior


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
    if not effect.own:
        return definitions()[effect.name]
    return Definition(
        name=effect.name,
        kind=effect.kind,
        pattern="all",
        says="an effect of the robot file",
        torque=sought.torque,
        linear=dict(effect.linear),
        nonlinear=sought_searches(sought, lengths),
        own=True,
    )
