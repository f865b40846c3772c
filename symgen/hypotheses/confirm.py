"""Grade the results of a search on the validation logs: adopted, shown as the cause, or suspected.

    adopted     explains a part of a joint's torque that matters, and makes no error worse, see
                `rising`
    shown       is adopted, and removes at least half of its joint's error above the noise floor
    suspected   everything else that is probable

The search does not use the validation logs. If they only repeat the motion of the training logs,
nothing is adopted, except contacts and separately measured effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.estimation.floor import noise_fit
from symgen.estimation.torque_error import percent, relative_error
from symgen.estimation.values import FloatArray, Residual
from symgen.hypotheses.changes import Changed
from symgen.hypotheses.effects import LogColumns, Score
from symgen.hypotheses.event import Contact
from symgen.hypotheses.held import following, held_squares
from symgen.hypotheses.judged import Judged
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.refine import settled_constants
from symgen.hypotheses.registry import SearchResult, leave_out
from symgen.hypotheses.score import TINY, repeats_motion
from symgen.policy import LEAST, RISE, ROUNDING, SHOWN
from symgen.robot.types import Robot

REPEATED = "the held-out data only repeat the motion of the training logs, which confirms nothing"


@dataclass(frozen=True, eq=False)
class Weighed:
    """A hypothesis and its grade on the validation logs, in a model with the other hypotheses.

    Attributes:
        item: the hypothesis.
        fell: part of a joint's torque that it explains, less the largest rise of an error.
        remaining: remaining part of its joint's error above the noise floor.
        reason: why it is not adopted, or "".
    """

    item: Judged
    fell: float = 0.0
    remaining: float = 1.0
    reason: str = ""

    @property
    def adopted(self) -> bool:
        """Whether it corrects the model or the logs."""
        return not self.reason

    @property
    def shown(self) -> bool:
        """Whether it is shown as the cause."""
        return self.adopted and self.remaining <= SHOWN


def confirm(
    result: SearchResult, matters: float = LEAST
) -> tuple[SearchResult, tuple[Weighed, ...]]:
    """Keep the hypotheses that lower the error on the validation logs.

    The weakest hypothesis is rejected first, until all others are adopted.

    Args:
        result: the result of a search.
        matters: smallest torque that matters, as a part of a joint's torque.

    Returns:
        The result with the adopted hypotheses, and the grade of every accepted hypothesis.
    """
    items: Sequence[Judged] = result.items
    if not items:
        return result, ()
    out: list[Weighed] = []
    if repeats_motion(result.declared.logs, result.declared.held):
        free = [x for x in items if x.cause.measured]
        out = [replace(_on_training(x), reason=REPEATED) for x in items if x not in free]
        items = free
    while items:
        weighed = _weigh(result, items, matters)
        failing = [w for w in weighed if not w.adopted]
        if not failing:
            out = [*weighed, *out]
            break
        for weakest in _weakest_of_joints(failing):
            kept = leave_out(items, weakest.item)
            dropped = [w for w in weighed if w.item in items and w.item not in kept]
            out += [replace(w, reason=w.reason or weakest.reason) for w in dropped]
            items = kept
    return restricted(result, items), tuple(out)


def _weakest_of_joints(failing: Sequence[Weighed]) -> list[Weighed]:
    """Return the weakest failing item, and the weakest ones on joints that it does not act on.

    Args:
        failing: items that are not adopted.
    """
    first, *others = sorted(failing, key=lambda w: w.fell)
    out, taken = [first], {*first.item.joints}
    for w in others if taken else ():
        joints = {*w.item.joints}
        if joints and not joints & taken:
            out.append(w)
            taken |= joints
    return out


def restricted(result: SearchResult, items: Sequence[Judged]) -> SearchResult:
    """Return the result of a search with some of its items, and with constants fitted again."""
    part = result.with_items(items)
    effects, _ = settled(part.problem, part.effects)
    return part.with_effects(effects)


def settled(problem: Problem, effects: Sequence[Score]) -> tuple[tuple[Score, ...], LogColumns]:
    """Iterate the columns that depend on the model's torque, then fit the constants of all effects.

    Returns:
        The effects, and the columns of candidates for the model with these effects.
    """
    stage = following(problem, effects)
    accepted = settled_constants(problem, stage.effects, stage.log_columns)
    return tuple(accepted), stage.log_columns


def _weigh(result: SearchResult, items: Sequence[Judged], matters: float) -> list[Weighed]:
    """Grade each item by the validation error with it and without it."""
    squares, size = held_squares(result, items)
    kinds, floor = result.problem.robot.kinds, _floor(result)
    after = relative_error(squares, size, kinds)
    now = np.array(after.parts)
    out = []
    for item in items:
        without, size_without = held_squares(result, leave_out(items, item))
        if isinstance(item, Contact) or np.array_equal(without, squares):
            # It changes the training logs alone: the held-out score of the search decides.
            out.append(_on_training(item))
            continue
        before = relative_error(without, size_without, kinds)
        was = np.array(before.parts)
        more = (1 - ROUNDING) * was**2 - now**2
        fall = np.sqrt(np.maximum(more, 0.0))  # explained part of the torque
        # A wrong channel of one joint spoils the fit of others.
        places = () if isinstance(item, Changed) else item.joints
        j = max(places or range(len(fall)), key=lambda j: fall[j])  # whose cause it may be
        noise = floor[j] if floor[j] < was[j] ** 2 else 0.0
        above = np.sqrt(np.maximum(np.square([now[j], was[j]]) - noise, 0.0))
        remaining = float(above[0] / max(above[1], TINY))
        fell, reason = float(fall.max()), ""
        if item.cause.measured:
            pass
        elif fell < matters:
            reason = (
                f"on the validation data it explains {percent(fell)} of the torque of a joint; "
                f"what matters: {100 * matters:.2g} %"
            )
        else:
            reason = rising(before, after, result.problem.robot, matters)
        rose = max(float(np.max(now - was)), 0.0)
        out.append(Weighed(item, fell - rose, remaining, reason))
    return out


def rising(before: Residual, after: Residual, robot: Robot, matters: float) -> str:
    """Return which torque error on the validation data gets worse, or "".

    The error of all joints may not rise, and that of a joint by `RISE` times the largest fall of
    one, or by `RISE` times what matters.

    Args:
        before, after: torque errors without some hypotheses, and with them.
        robot: gives the names of joints.
        matters: smallest torque that matters, as a part of a joint's torque.
    """
    was, now = np.array(before.parts), np.array(after.parts)
    k = int(np.argmax(now - was))
    fall = max(float(np.max(was - now)), matters)
    if now[k] > was[k] + RISE * fall:
        place = robot.listed([k]) if k < robot.n else "the base"
        where, low, high = f" of {place}", was[k], now[k]
    elif after.relative > (1 + ROUNDING) * before.relative:
        where, low, high = "", before.relative, after.relative
    else:
        return ""
    rise = f"from {percent(low)} to {percent(high)}"
    return f"with it, the torque error{where} on the validation data rises {rise}"


def _on_training(item: Judged) -> Weighed:
    """Return the grade of an item by the held-out score of the search."""
    share = max(1.0 - item.gain, 0.0)
    return Weighed(item, item.worth, float(np.sqrt(share)))


def _floor(result: SearchResult) -> FloatArray:
    """Return the squared ratio of noise floor to torque on the validation logs, see `parts`.

    The motion's part takes the declared model. An unknown floor counts as zero.
    """
    problem = result.declared
    noise = noise_fit(problem.evaluator, problem.held, problem.X).residual
    return np.nan_to_num(np.square(noise.parts))
