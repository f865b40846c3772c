"""The joint stiffness that a second encoder measures, in a diagnosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symgen import names
from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, FoundParameter
from symgen.hypotheses.stiffness import NAME, Stiffness
from symgen.robot.effect import effect_unit
from symgen.robot.types import Robot

_EXPRESSION = "-K{0}*(q{0} - qs{0}) - D{0}*(qd{0} - qsd{0})"


def with_stiffness(diagnosis: Diagnosis, robot: Robot, results: Sequence[Stiffness]) -> Diagnosis:
    """Return a diagnosis with the results of the second encoders.

    Each joint with a second encoder gets an elasticity, even if it closes no part of the gap. An
    elasticity that the search accepted gets the measured stiffness.
    """
    effects, notes = list(diagnosis.effects), list(diagnosis.notes)
    verdict = diagnosis.verdict
    for s in results:
        number, sigma = robot.numbers[s.joint], robot.sigma[s.joint]
        if s.why:
            notes.append(f"{robot.label(number)}, second encoder: {s.why}")
            continue
        same = [e for e in effects if (e.name, e.joints) == (NAME, (number,))]
        rotor = (p for e in same for p in e.parameters if p.name.startswith("IA"))
        measured = FoundEffect(
            name=NAME,
            joints=(number,),
            parameters=(
                FoundParameter(f"K{number}", *s.stiffness, effect_unit("torque/position", sigma)),
                FoundParameter(f"D{number}", *s.damping, names.unit("FV", sigma)),
                *rotor,
            ),
            expression=_EXPRESSION.format(number),
            p_value=s.p_value,
            gap_reduction=sum(e.gap_reduction for e in same),
            declared=False,
        )
        effects = [measured if e in same else e for e in effects] + ([] if same else [measured])
        verdict = "explained" if verdict == "consistent" else verdict
    return replace(diagnosis, effects=tuple(effects), notes=tuple(notes), verdict=verdict)
