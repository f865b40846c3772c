"""What the validation logs say of hypotheses, whose columns are computed on them as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import Score
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.registry import Found, Item
from symgen.hypotheses.score import TINY, dense

#: Rounds in which columns that contain the model's torque follow it, and the relative change of
#: its parameters that ends them.
_ROUNDS, _SETTLED = 12, 1e-3
#: Pattern of effects that depend on the time since a log began.
TIME = "time"


def held_squares(found: Found, items: Sequence[Item]) -> tuple[FloatArray, FloatArray]:
    """Return sums of squares of error and torque on the validation logs in motion, (n,) each.

    Args:
        found: what a search accepts.
        items: those of it that are corrected; the model is fitted to the training logs with them.
    """
    part = found.with_items(items)
    problem, effects = part.problem, following(part.problem, part.effects)
    stage, held = problem.stage(effects), problem.held_rows
    columns = problem.seen(held.logs, stage.X).each(s.candidate for s in effects)
    W = np.concatenate([held.W, *(dense(c, held.y.shape) for c in columns)], axis=2)
    weight = held.moves**2
    measured = np.concatenate([log.unmasked.measured for log in held.logs])
    error = np.sum(weight * (held.y - W @ stage.rows.X) ** 2, axis=0)
    size = np.sum(weight * measured**2, axis=0)
    return error, np.maximum(size, TINY)


def in_one_log(found: Found) -> Found:
    """Return what is found; what changes in time is left out of validation logs without it."""
    fading = [s for s in found.effects if s.definition.pattern == TIME]
    if not fading or not found.problem.held:
        return found
    items = found.items
    least = held_squares(found, items)[0].sum()
    for item in fading:
        here = replace(item, candidate=item.candidate.only_in(found.declared.logs))
        others = tuple(here if x is item else x for x in items)
        squares = held_squares(found, others)[0].sum()
        if squares < least:
            items, least = others, squares
    return found.with_items(items)


def following(problem: Problem, effects: Sequence[Score]) -> Sequence[Score]:
    """Return effects whose columns follow the model's torque, which they change, until it settles.

    A gain g takes -g times the error of a round into the next one: the mean of both is nearer.
    """
    X = problem.stage(effects).X
    for _ in range(_ROUNDS if any(s.candidate.uses_model for s in effects) else 0):
        seen = problem.seen(problem.logs, X)
        effects = [
            replace(s, columns=seen(s.candidate)) if s.candidate.uses_model else s for s in effects
        ]
        found = problem.stage(effects).X
        if np.linalg.norm(found - X) < _SETTLED * np.linalg.norm(X):
            break
        X = (X + found) / 2
    return effects
