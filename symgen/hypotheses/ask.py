"""The short search that `identify` runs, and its results as reasons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.torque_error import relative_error
from symgen.estimation.values import Reason
from symgen.hypotheses.changes import Changed
from symgen.hypotheses.confirm import Weighed, confirm
from symgen.hypotheses.event import Contact
from symgen.hypotheses.held import TIME
from symgen.hypotheses.problem import Stage, make_problem
from symgen.hypotheses.registry import SearchResult, make_registry
from symgen.hypotheses.search import Judge, search
from symgen.parallel import Say, silent
from symgen.policy import LEAST, SHOWN, STEPS
from symgen.robot.effect import PHYSICS
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True, eq=False)
class Answer:
    """Result of a short search on the logs of an identification.

    Attributes:
        shown: faults of recorder or robot file that are shown as the cause.
        suspected: all other probable hypotheses.
        delays: delays of torques, which `identify` can undo.
        contacts: contacts in training logs, whose samples `identify` can mask.
        largest_fold_error: largest torque error of a fold, predicted by the fit to the other folds.
        found: the search, which can go on, and its result; None if the error is too small for one.
    """

    shown: tuple[Reason, ...] = ()
    suspected: tuple[Reason, ...] = ()
    delays: tuple[Changed, ...] = ()
    contacts: tuple[Contact, ...] = ()
    largest_fold_error: float = 0.0
    found: tuple[Judge, SearchResult] | None = None


def ask(
    evaluator: Evaluator,
    train: Sequence[FilteredLog],
    held: Sequence[FilteredLog],
    least: float = LEAST,
    progress: Say = silent,
) -> Answer:
    """Run a short search for what a model lacks and for faults of its logs.

    Args:
        evaluator: the compiled model.
        train, held: training and validation logs in the band of the run.
        least: smallest torque that matters, as a part of a joint's torque.
        progress: called with a text about the current trial.

    Raises:
        IdentificationError: the logs do not determine the model.
    """
    problem = make_problem(evaluator, train, held)
    stage = problem.stage()
    error = _largest_fold_error(stage)
    if (stage.lost < least).all():
        return Answer(largest_fold_error=error)
    judge = Judge(problem, make_registry(problem), least)
    result = search(judge, SearchResult(problem, problem), STEPS, progress)
    kept, weighed = confirm(result, least)
    delays = tuple(c for c in kept.changes if c.cause.delay)
    undone = (*delays, *kept.contacts)
    shown, suspected = list[Reason](), list[Reason]()
    for w in weighed:
        if w.item in undone:
            continue
        row = w.item.definition
        # A log in which the robot changes belongs to no single state of the robot.
        fault = row.side != PHYSICS or row.pattern == TIME
        (shown if w.shown and fault else suspected).append(reason_of(w, problem.robot))
    found = judge, result
    return Answer(tuple(shown), tuple(suspected), delays, kept.contacts, error, found)


def _largest_fold_error(stage: Stage) -> float:
    """Return the largest error of a fold, over all joints, as a part of the torque of all folds."""
    score = stage.score
    counts = np.maximum(score.counts, 1.0)
    error, size = score.alone.squares / counts, stage.problem.base.size**2
    kinds = stage.problem.robot.kinds
    return max(relative_error(part, size, kinds).relative for part in error.T)


def reason_of(w: Weighed, robot: Robot) -> Reason:
    """Return a reason that names a hypothesis, its joints, its size and the advice."""
    item, row = w.item, w.item.definition
    ending = f"; {row.advice}" if row.advice else ""
    text = f"{item.cause.in_words(robot)}: {row.says}{ending}"
    numbers = tuple(robot.numbers[j] for j in item.joints)
    return Reason(row.name, numbers, w.remaining, SHOWN, text)
