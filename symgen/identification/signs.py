"""Signs of a drive that the logs contradict: a gear declared to turn the other way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered import filtered
from symgen.estimation.recipe import Recipe
from symgen.estimation.system import LinearSystem
from symgen.identification.validation import Part, residual
from symgen.runtime.evaluator import Evaluator

_LOUD = 0.03  # relative residual above which signs are tried
_BETTER = 0.5  # of the residual that another sign has to leave at most


def wrong_sign(evaluator: Evaluator, train: Sequence[Part], recipe: Recipe, left: float) -> str:
    """Say which joint fits at least twice as well when its drive turns the other way, or "".

    Tried for robots with [drive] alone, whose signs nothing else can prove.

    Args:
        evaluator: the compiled model.
        train: the training logs.
        recipe: of their equations.
        left: relative residual of the estimate on them.
    """
    robot = evaluator.model.robot
    if robot.drive is None or left < _LOUD:
        return ""
    found: dict[int, float] = {}
    for at, joint in enumerate(robot.movable):
        turn = np.ones(robot.n)
        turn[at] = -1.0
        moved = turn if robot.drive.position_side == "motor" else np.ones(robot.n)
        parts = []
        for p in train:
            s = p.samples
            other = replace(s, q=s.q * moved, qd=s.qd * moved, tau=s.tau * turn)
            log = filtered(other, p.log.band)
            parts.append(replace(p, log=log, equations=recipe.equations(evaluator, log)))
        system = LinearSystem(
            evaluator.model.base.names, tuple(e for p in parts for e in p.equations)
        )
        try:
            found[joint.number] = residual(parts, Wls().solve(system).X).relative
        except (IdentificationError, np.linalg.LinAlgError):
            continue
    best = min(found, key=lambda j: found[j], default=None)
    if best is None or found[best] > _BETTER * left:
        return ""
    return (
        f"joint {best} fits better with the other sign of its ratio in [drive]: the residual falls "
        f"from {100 * left:.2g} to {100 * found[best]:.2g} %"
    )
