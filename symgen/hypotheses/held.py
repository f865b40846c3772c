"""Errors of hypotheses on the validation logs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import Score
from symgen.hypotheses.judged import Judged
from symgen.hypotheses.problem import Problem, Stage
from symgen.hypotheses.registry import SearchResult
from symgen.hypotheses.score import TINY, dense

#: Most rounds in which columns follow the model's torque; relative change of the parameters that
#: ends them.
_ROUNDS, _SETTLED = 12, 1e-3
#: Pattern of effects that depend on the time since a log began.
TIME = "time"


def held_squares(result: SearchResult, items: Sequence[Judged]) -> tuple[FloatArray, FloatArray]:
    """Return the sums of squares of the error and of the torque on the validation logs, (n,) each.

    Rows at rest do not count.

    Args:
        result: the result of a search.
        items: the hypotheses of it with which the model is fitted to the training logs.
    """
    part = result.with_items(items)
    problem, held = part.problem, part.problem.held_rows
    stage = following(problem, part.effects)
    columns = problem.make_columns(held.logs, stage.X).each(s.cause for s in stage.effects)
    more = [dense(c, held.y.shape) for c in columns]
    W = np.concatenate([held.W, *more], axis=2)
    weight = held.weight**2
    residual = held.y - W @ stage.rows.X
    error = np.sum(weight * residual**2, axis=0)
    size = np.sum(weight * held.measured**2, axis=0)
    return error, np.maximum(size, TINY)


def in_one_log(result: SearchResult) -> SearchResult:
    """Limit time-dependent effects to the training logs if this lowers the validation error."""
    fading = [s for s in result.effects if s.definition.pattern == TIME]
    if not fading or not result.problem.held:
        return result
    items = result.items
    smallest = held_squares(result, items)[0].sum()
    for item in fading:
        here = replace(item, cause=item.cause.only_in(result.declared.logs))
        others = tuple(here if x is item else x for x in items)
        squares = held_squares(result, others)[0].sum()
        if squares < smallest:
            items, smallest = others, squares
    return result.with_items(items)


def following(problem: Problem, effects: Sequence[Score]) -> Stage:
    """Return the stage whose columns contain the model's torque, which the effects change.

    With a gain g, each round has -g times the error of the round before. The mean of two rounds is
    therefore nearer to the solution.
    """
    stage = problem.stage(effects)
    X = stage.X
    for _ in range(_ROUNDS if any(s.cause.uses_model for s in effects) else 0):
        columns_of = problem.make_columns(problem.logs, X)
        effects = [
            replace(s, columns=columns_of(s.cause)) if s.cause.uses_model else s for s in effects
        ]
        stage = problem.stage(effects)
        if np.linalg.norm(stage.X - X) < _SETTLED * np.linalg.norm(X):
            break
        X = (X + stage.X) / 2
    return stage
