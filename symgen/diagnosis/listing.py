"""The effects of a diagnosis with their values, as they stand in diagnosis.json."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.diagnosis.adoption import Adopted, coefficient_names, place
from symgen.diagnosis.diagnosis import Alike, FoundEffect, FoundParameter
from symgen.diagnosis.together import Coefficients
from symgen.estimation.values import FloatArray
from symgen.hypotheses.changes import Change
from symgen.hypotheses.confirm import Weighed
from symgen.hypotheses.effects import Score
from symgen.hypotheses.event import Contact
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.registry import Changed, Item
from symgen.identification.parameters import base_values
from symgen.identification.workflow import Identified
from symgen.robot.effect import numbered
from symgen.robot.types import Robot


def list_effects(
    adopted: Adopted,
    contacts: Sequence[Contact],
    suspected: Sequence[Weighed],
    *,
    delays: bool,
) -> tuple[FoundEffect, ...]:
    """Return the adopted and the suspected effects, with values and standard deviations.

    Args:
        adopted: the adopted effects.
        contacts: contacts in training logs.
        suspected: the grades of the suspected effects.
        delays: whether delays are effects, since `identify` did not undo any.
    """
    robot = adopted.result.problem.robot
    by_key = {w.item.key: w for w in adopted.weighed}
    found = zip(adopted.together.effects, adopted.together.values, strict=True)
    values = {score.key: value for score, value in found}
    identified = {p.name: p for p in robot_parameters(adopted)}
    out = []
    for item in adopted.result.items:
        w = by_key[item.key]
        declared = item in adopted.declared
        if isinstance(item, Changed):
            if delays or not item.change.delay:
                out.append(_undone(robot, w, item.change, declared=declared))
        elif isinstance(item, Score):
            known = identified if declared and adopted.last is not None else {}
            numbers = _parameters(robot, item, values[item.key], known)
            out.append(_with_columns(robot, w, item, numbers, declared=declared))
    for joints in dict.fromkeys(c.joints for c in contacts):
        out.append(_touched(robot, [c for c in contacts if c.joints == joints]))
    for w in suspected:
        if isinstance(w.item, Score):
            out.append(_with_columns(robot, w, w.item, (), declared=False))
        elif isinstance(w.item, Changed):
            out.append(_undone(robot, w, w.item.change, declared=False))
        else:
            out.append(replace(_touched(robot, [w.item]), adopted=False, shown=False))
    return tuple(out)


def _parameters(
    robot: Robot, score: Score, found: Coefficients, known: dict[str, FoundParameter]
) -> tuple[FoundParameter, ...]:
    """Return the coefficients and the constants of an effect.

    Args:
        robot: the robot.
        score: the effect.
        found: its values as columns of the declared model.
        known: identified parameters by name.
    """
    c, d = score.candidate, score.definition
    std = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    out = []
    for (name, unit), value, deviation in zip(
        coefficient_names(robot, c), found.values, std, strict=False
    ):
        if name in known:
            out.append(known[name])
        elif not (known and d.native):  # geometry and gravity contain a native effect otherwise
            out.append(FoundParameter(name, float(value), float(deviation), unit))
    suffix, sigma = place(robot, c)
    for (name, value), deviation in zip(c.constants.items(), found.constants_std, strict=True):
        unit = d.unit_of(name, sigma)
        out.append(FoundParameter(d.named(name, suffix), float(value), float(deviation), unit))
    return tuple(out)


def _plain(robot: Robot, item: Item) -> FoundEffect:
    """Return a hypothesis as an adopted effect, without its parameters."""
    from scipy.special import expit

    return FoundEffect(
        name=item.definition.name,
        joints=joint_numbers(robot, item.joints),
        parameters=(),
        expression=item.definition.formula,
        p_value=math.exp(-max(item.odds, 0.0)),
        gap_reduction=min(item.gain, 1.0),
        probability=float(expit(item.odds)),
        torque_rms=item.torque,
        declared=False,
    )


def _with_columns(
    robot: Robot,
    w: Weighed,
    score: Score,
    parameters: tuple[FoundParameter, ...],
    *,
    declared: bool,
) -> FoundEffect:
    """Return an effect with columns, with its score and its parameters."""
    d = score.definition
    suffix, _ = place(robot, score.candidate)
    alike = tuple(Alike(s.definition.name, joint_numbers(robot, s.joints)) for s in score.alike)
    return replace(
        _plain(robot, score),
        parameters=parameters,
        expression=numbered(d, suffix) or d.formula or d.says,
        p_value=_p_value(parameters),
        probability=score.probability,
        indistinguishable_from=alike,
        separate=d.separate if alike else "",
        declared=declared,
        adopted=w.adopted,
        shown=w.shown,
    )


def _undone(robot: Robot, w: Weighed, change: Change, *, declared: bool) -> FoundEffect:
    """Return a change of the logs as an effect."""
    plain = _plain(robot, w.item)
    suffix = plain.joints[-1] if plain.joints else ""
    constants = (
        FoundParameter(f"{name}{suffix}", value, change.std.get(name, math.nan), unit)
        for name, (value, unit) in change.constants.items()
    )
    where = change.channels or "robot file"
    expression = f"{plain.expression} ({where})"
    return replace(
        plain,
        parameters=tuple(constants),
        expression=expression,
        declared=declared,
        adopted=w.adopted,
        shown=w.shown,
    )


def _touched(robot: Robot, same: Sequence[Contact]) -> FoundEffect:
    """Return contacts on the same joints as one effect, with the share of the largest contact."""
    plain = _plain(robot, max(same, key=lambda contact: contact.gain))
    times = []
    for k, span in enumerate(contact.span for contact in same):
        suffix = f"{plain.joints[-1]}{f'_{k}' if k else ''}"
        times.append(FoundParameter(f"start{suffix}", span.start, math.nan, "s"))
        times.append(FoundParameter(f"length{suffix}", span.end - span.start, math.nan, "s"))
    where = ", ".join(contact.span.log for contact in same)
    expression = f"{plain.expression}, in {where}"
    return replace(plain, parameters=tuple(times), expression=expression, shown=True)


def joint_numbers(robot: Robot, positions: Sequence[int]) -> tuple[int, ...]:
    """Return the joint numbers in the robot file of some positions."""
    return tuple(robot.movable[j].number for j in positions)


def _p_value(parameters: Sequence[FoundParameter]) -> float:
    """Return the p-value of the most significant coefficient, with Bonferroni's correction."""
    sure = [abs(p.value) / p.std for p in parameters if p.std > 0]
    return min(1.0, len(sure) * math.erfc(max(sure, default=0.0) / math.sqrt(2)))


def robot_parameters(adopted: Adopted) -> tuple[FoundParameter, ...]:
    """Return the base parameters of the extended robot.

    Fixed parameters get the values that declared effects add, and no standard deviation.
    """
    if isinstance(adopted.last, Identified):
        estimate = adopted.last.estimate
        return tuple(FoundParameter(p.name, p.value, p.std, p.unit) for p in estimate.parameters)
    problem, robot = adopted.result.problem, adopted.robot
    model, X = problem.evaluator.model, problem.X
    if robot is not problem.robot:
        model = derive(robot, ())
        X = _with_added(problem, model, [*_added(adopted)])
    rows = zip(model.base.parameters, X, strict=True)
    return tuple(FoundParameter(p.name, float(x), math.nan, p.unit) for p, x in rows)


def _added(adopted: Adopted) -> Iterator[tuple[str, float]]:
    """Yield name and value of the coefficients of declared effects."""
    robot = adopted.result.problem.robot
    for score, found in zip(adopted.together.effects, adopted.together.values, strict=True):
        if score in adopted.declared:
            names = (name for name, _ in coefficient_names(robot, score.candidate))
            yield from zip(names, map(float, found.values), strict=False)


def _with_added(
    problem: Problem, extended_model: Model, added: Sequence[tuple[str, float]]
) -> FloatArray:
    """Return the base parameters of an extended model: fixed values plus those of effects.

    Args:
        problem: the declared model with its fixed parameters.
        extended_model: the model with the effects declared.
        added: standard parameters of `extended_model` that effects change or add.
    """
    values = {p.name: 0.0 for p in extended_model.base.standard}
    for value, base in zip(problem.X, problem.evaluator.model.base.parameters, strict=True):
        values[base.head] = float(value)
    for given, value in added:
        # R is appended to the name of a load parameter with which others are regrouped.
        name = given if given in values else given.removesuffix("R")
        if name in values:
            values[name] += value
    return base_values(values, extended_model, "the extended model")
