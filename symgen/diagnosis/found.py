"""What a diagnosis says of each effect: coefficients and constants, by name, with their std."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.baseline import Study
from symgen.diagnosis.candidates import Candidate
from symgen.diagnosis.diagnosis import Alike, FoundEffect, FoundParameter
from symgen.diagnosis.search import Selection
from symgen.diagnosis.select import Score, judge
from symgen.robot.effect import numbered
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]


def coefficients(study: Study, accepted: Sequence[Score]) -> list[list[FoundParameter]]:
    """Return the coefficients of each effect, all beside the declared model."""
    out, at = [], study.base.W.shape[2]
    values = study.beside(accepted).X
    for score in accepted:
        rest = study.beside([s for s in accepted if s is not score])
        c = score.candidate
        std = judge(rest, c, score.columns, 1).std
        triples = zip(_named(study.robot, c), values[at:], std, strict=False)
        out.append([FoundParameter(n, float(x), float(s), u) for (n, u), x, s in triples])
        at += c.size
    return out


def found_effects(
    study: Study,
    selection: Selection,
    beside: Sequence[Sequence[FoundParameter]],
    corrected: Sequence[Score],
    declared: Sequence[Score],
    names_: Sequence[str],
    X: FloatArray,
    std: FloatArray,
    evaluator: Evaluator,
) -> tuple[FoundEffect, ...]:
    units = {p.name: p.unit for p in evaluator.model.base.parameters}
    place = {name: i for i, name in enumerate(names_)}
    at = {
        id(s): len(names_) + sum(c.candidate.size for c in corrected[:k])
        for k, s in enumerate(corrected)
    }
    out, loose = [], iter(std[len(X) :])
    for score, own, alike in zip(selection.accepted, beside, selection.alike, strict=True):
        c, d = score.candidate, score.candidate.definition
        joints, suffix, sigma = (
            numbers(study.robot, c),
            _suffix(study.robot, c),
            _sigma(study.robot, c),
        )
        parameters = []
        for i, first in enumerate(own):
            k = at[id(score)] + i if id(score) in at else place.get(first.name)
            word = units.get(first.name, first.unit) if id(score) not in at else first.unit
            if k is not None:
                x, s = float(X[k]), float(std[k])
                parameters.append(FoundParameter(first.name, x, s, word))
            elif not c.definition.native:  # part of the extended geometry or gravity
                parameters.append(first)
        parameters += [
            FoundParameter(
                d.named(name, suffix),
                float(value),
                float(next(loose)) if c.smooth else float("nan"),
                d.unit_of(name, sigma),
            )
            for name, value in c.constants.items()
        ]
        out.append(
            FoundEffect(
                name=c.name,
                joints=joints,
                parameters=tuple(parameters),
                expression=numbered(d, suffix) or d.formula or d.says,
                p_value=score.p_value,
                gap_reduction=min(score.gain, 1.0),
                indistinguishable_from=tuple(
                    Alike(s.candidate.name, numbers(study.robot, s.candidate)) for s in alike
                ),
                separate=d.separate if alike else "",
                declared=score in declared or bool(d.reads),
            )
        )
    return tuple(out)


def numbers(robot: Robot, candidate: Candidate) -> tuple[int, ...]:
    """Return the numbers of the joints that an effect acts on."""
    return tuple(robot.movable[j].number for j in candidate.joints)


def _named(robot: Robot, c: Candidate) -> tuple[tuple[str, str], ...]:
    """Return name and unit of every coefficient that means something."""
    return c.coefficients or c.definition.coefficients(_suffix(robot, c), _sigma(robot, c))


def _suffix(robot: Robot, c: Candidate) -> int | str:
    joints = numbers(robot, c)
    return joints[-1] if joints else ""


def _sigma(robot: Robot, c: Candidate) -> int:
    return robot.movable[c.joints[0]].sigma if c.joints else 0
