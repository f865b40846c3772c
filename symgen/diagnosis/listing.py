"""The effects of a diagnosis with their values, as they stand in diagnosis.json."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from symgen.codegen.model import derive
from symgen.diagnosis.adoption import Adopted, coefficient_names
from symgen.diagnosis.diagnosis import Alike, FoundEffect, FoundParameter
from symgen.diagnosis.together import Coefficients
from symgen.hypotheses.confirm import Weighed
from symgen.hypotheses.effects import Score
from symgen.hypotheses.event import Contact
from symgen.hypotheses.judged import Judged
from symgen.identification.parameters import base_values
from symgen.identification.workflow import Identified
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
    result = adopted.result
    robot = result.problem.robot
    grades = {w.item.key: w for w in adopted.weighed}
    identified = {p.name: p for p in robot_parameters(adopted)} if adopted.last else {}
    out = []
    for change in result.changes:
        if delays or not change.cause.delay:
            found = _found(robot, grades[change.key], _sizes(robot, [change]))
            out.append(replace(found, declared=change in adopted.declared))
    for score in result.effects:
        declared = score in adopted.declared
        value = adopted.together.values[score]
        numbers = _parameters(robot, score, value, identified if declared else {})
        found = _found(robot, replace(grades[score.key], item=score), numbers)
        out.append(replace(found, declared=declared))
    for joints in dict.fromkeys(c.joints for c in contacts):
        same = [c for c in contacts if c.joints == joints]
        largest = max(same, key=lambda contact: contact.gain)
        found = _found(robot, Weighed(largest, remaining=0.0), _sizes(robot, same))
        first, *others = (c.cause for c in same)
        places = first.expression(robot), *(span.log for span in others)
        out.append(replace(found, expression=", ".join(places)))
    for w in suspected:
        numbers = () if isinstance(w.item, Score) else _sizes(robot, [w.item])
        out.append(_found(robot, w, numbers))
    return tuple(out)


def _sizes(robot: Robot, items: Sequence[Judged]) -> tuple[FoundParameter, ...]:
    """Return the constants of hypotheses on the same joints; those after the first are numbered."""
    suffix, _ = items[0].cause.place(robot)
    out = []
    for k, item in enumerate(items):
        more = f"_{k}" if k else ""
        for s in item.cause.sizes:
            name = f"{s.name}{suffix}{more}"
            out.append(FoundParameter(name, s.value, s.std, s.unit))
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
    c, d = score.cause, score.definition
    std = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    out = []
    for (name, unit), value, deviation in zip(
        coefficient_names(robot, c), found.values, std, strict=False
    ):
        if name in known:  # the fit with constants as columns has their uncertainty, too
            std_of = max(known[name].std, float(np.nan_to_num(deviation) if c.smooth else 0.0))
            out.append(replace(known[name], std=std_of))
        elif not (known and d.native):  # geometry and gravity contain a native effect otherwise
            out.append(FoundParameter(name, float(value), float(deviation), unit))
    suffix, sigma = c.place(robot)
    for (name, value), deviation in zip(c.constants.items(), found.constants_std, strict=True):
        unit = d.unit_of(name, sigma)
        out.append(FoundParameter(d.named(name, suffix), float(value), float(deviation), unit))
    return tuple(out)


def _found(robot: Robot, w: Weighed, parameters: tuple[FoundParameter, ...]) -> FoundEffect:
    """Return a hypothesis with its grade and its parameters as an effect, not yet declared."""
    item, d = w.item, w.item.definition
    alike = []
    for other in item.alike:
        alike.append(Alike(other.cause.name, joint_numbers(robot, other.joints)))
    by_std = isinstance(item, Score)
    return FoundEffect(
        name=d.name,
        joints=joint_numbers(robot, item.joints),
        parameters=parameters,
        expression=item.cause.expression(robot),
        p_value=_p_value(parameters) if by_std else math.exp(-max(item.odds, 0.0)),
        gap_reduction=min(item.gain, 1.0),
        indistinguishable_from=tuple(alike),
        separate=d.separate if alike else "",
        declared=False,
        probability=item.probability,
        torque_rms=item.torque,
        adopted=w.adopted,
        shown=w.shown,
    )


def joint_numbers(robot: Robot, positions: Sequence[int]) -> tuple[int, ...]:
    """Return the joint numbers in the robot file of some positions."""
    return tuple(robot.numbers[j] for j in positions)


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
        heads = [base.head for base in model.base.parameters]
        model = derive(robot, ())
        values = {p.name: 0.0 for p in model.base.standard}
        values.update(zip(heads, map(float, X), strict=True))
        for given, value in _added(adopted):
            # R is appended to the name of a load parameter with which others are regrouped.
            name = given if given in values else given.removesuffix("R")
            if name in values:
                values[name] += value
        X = base_values(values, model, "the extended model")
    rows = zip(model.base.parameters, X, strict=True)
    return tuple(FoundParameter(p.name, float(x), math.nan, p.unit) for p, x in rows)


def _added(adopted: Adopted) -> Iterator[tuple[str, float]]:
    """Yield name and value of the coefficients of declared effects."""
    for score, found in adopted.together.values.items():
        if score in adopted.declared:
            named = coefficient_names(adopted.result.problem.robot, score.cause)
            yield from zip((name for name, _ in named), found.values.tolist(), strict=False)
