"""The short search that `identify` runs, and its results as reasons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.torque_error import relative_error
from symgen.estimation.values import Reason
from symgen.hypotheses.confirm import Weighed, confirm
from symgen.hypotheses.effects import Candidate
from symgen.hypotheses.event import Contact
from symgen.hypotheses.held import TIME
from symgen.hypotheses.priors import PHYSICS, prior_of
from symgen.hypotheses.problem import Stage, make_problem
from symgen.hypotheses.registry import Changed, Item, SearchResult, make_registry
from symgen.hypotheses.search import search
from symgen.parallel import Say, silent
from symgen.policy import LEAST, SHOWN
from symgen.runtime.evaluator import Evaluator

#: Largest number of hypotheses that `identify` adds; `diagnose` has no limit.
STEPS = 3


@dataclass(frozen=True, eq=False)
class Answer:
    """Result of a short search on the logs of an identification.

    Attributes:
        shown: faults of recorder or robot file that are shown as the cause.
        suspected: all other probable hypotheses.
        delays: delays of torques, which `identify` can undo.
        contacts: contacts in training logs, whose samples `identify` can mask.
        largest_fold_error: largest torque error of a fold, predicted by the fit to the other folds.
        result: the search; None if the error is too small for one.
    """

    shown: tuple[Reason, ...] = ()
    suspected: tuple[Reason, ...] = ()
    delays: tuple[Changed, ...] = ()
    contacts: tuple[Contact, ...] = ()
    largest_fold_error: float = 0.0
    result: SearchResult | None = None


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
    result = search(problem, make_registry(problem), least, STEPS, progress)
    _, weighed = confirm(result, least)
    shown, suspected, delays = [], [], []
    # Contacts in validation logs stay in: masking them could hide what the model lacks.
    names = {log.name for log in train}
    touched = [w.item for w in weighed if w.adopted and isinstance(w.item, Contact)]
    contacts = [c for c in touched if c.span.log in names]
    for w in weighed:
        if w.item in contacts:
            continue
        if isinstance(w.item, Changed) and w.adopted and w.item.change.delay:
            delays.append(w.item)
            continue
        reason = reason_of(w, result)
        row = w.item.definition
        # A log in which the robot changes belongs to no single state of the robot.
        fault = prior_of(row).side != PHYSICS or row.pattern == TIME
        if w.shown and fault and w.item not in touched:
            shown.append(reason)
        else:
            suspected.append(reason)
    about = tuple(shown), tuple(suspected), tuple(delays), tuple(contacts)
    return Answer(*about, error, result)


def _largest_fold_error(stage: Stage) -> float:
    """Return the largest error of a fold, over all joints, as a part of the torque of all folds."""
    score = stage.score
    counts = np.maximum(score.counts, 1.0)
    error, size = score.alone.squares / counts, stage.problem.base.size**2
    sigma = stage.problem.robot.sigma
    return max(relative_error(part, size, sigma).relative for part in error.T)


def reason_of(w: Weighed, result: SearchResult) -> Reason:
    """Return a reason that names a hypothesis, its joints, its size and the advice."""
    robot, item = result.declared.robot, w.item
    row, joints = item.definition, item.joints
    labels = robot.listed(list(joints)) if joints else "the whole arm"
    where = f"{_channels(item)}{row.name.replace('_', ' ')} on {labels}{_size(item)}"
    advice = prior_of(row).advice
    ending = f"; {advice}" if advice else ""
    numbers = tuple(robot.movable[j].number for j in joints)
    return Reason(row.name, numbers, w.remaining, SHOWN, f"{where}: {row.says}{ending}")


def _channels(item: Item) -> str:
    """Return the channels of a change, as "tau2: "; "" for other items."""
    if not isinstance(item, Changed) or not item.change.channels:
        return ""
    keys = item.change.channels.split(", ")
    joints = item.change.joints
    if not joints or keys == ["t"]:
        return f"{item.change.channels}: "
    named = [f"{key}{j + 1}" for j in joints for key in keys]
    return f"{', '.join(named)}: "


def _size(item: Item) -> str:
    """Return the size of an item, as ", DT = 0.012 s"."""
    if isinstance(item, Changed):
        pairs = [(n, x, unit) for n, (x, unit) in item.change.constants.items()]
    elif isinstance(item, Contact):
        span = item.span
        return f" in {span.log}, {span.start:.3g} to {span.end:.3g} s"
    else:
        pairs = _constants(item.candidate)
    return "".join(f", {name} = {x:.3g} {unit}".rstrip() for name, x, unit in pairs)


def _constants(c: Candidate) -> list[tuple[str, float, str]]:
    d = c.definition
    return [(name, x, d.unit_of(name, 0)) for name, x in c.constants.items() if not math.isnan(x)]
