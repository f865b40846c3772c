"""Adopt effects: write them into the robot, and ask the fit of `identify` whether they hold.

    declare the effects -> identify the robot -> test each effect in that fit -> drop the weakest

An effect stays if its coefficients are together as far from zero as `BEYOND` deviations of one
coefficient, if the validation error of a joint rises by what matters without it, if no joint's
error rises by a quarter of that with it, and if the simulation gets no worse. A base that moves is
not simulated. The last fit is therefore the one that `identify` makes of the written robot file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.codegen.model import Model
from symgen.diagnosis.extend import corrected, extended, with_torques_scaled
from symgen.diagnosis.together import Coefficients, Together, fit_together
from symgen.errors import IdentificationError, RobotError
from symgen.estimation.covariance import is_chance
from symgen.estimation.solve import residual_weights, shortest, weighted_triangle
from symgen.estimation.summary import summaries
from symgen.estimation.torque_error import fit, percent
from symgen.estimation.values import FloatArray, Residual
from symgen.hypotheses.changes import Changed
from symgen.hypotheses.confirm import Weighed, restricted, rising
from symgen.hypotheses.effects import Candidate, Score
from symgen.hypotheses.judged import Judged
from symgen.hypotheses.registry import SearchResult
from symgen.identification.estimate import Estimate
from symgen.identification.settle import NO_ROBOT
from symgen.identification.solving import rows_of
from symgen.identification.workflow import Identified, Solved
from symgen.policy import BEYOND, WORSE
from symgen.robot.types import Robot

#: Name of the effect that [drive] corrects.
GAIN = "drive_gain_error"
_INTERVAL = 2.0  # standard deviations of a constant that half of its range must contain
#: Identifies a robot, after some changes of the logs that no robot file can hold.
Identify = Callable[[Robot, Sequence[Changed]], Solved]


@dataclass(frozen=True, eq=False)
class Adopted:
    """The effects that hold in the fit of `identify`.

    Attributes:
        result: the search, restricted to them.
        weighed: the grades of all hypotheses.
        robot: the robot with those that a robot file can hold.
        declared: these effects.
        together: all of them as columns of the declared model.
        last: the fit of the robot; with changes of the logs that no robot file can hold undone.
            None with fixed parameters.
    """

    result: SearchResult
    weighed: tuple[Weighed, ...]
    robot: Robot
    declared: tuple[Judged, ...]
    together: Together
    last: Solved | None = None

    @property
    def undeclared(self) -> tuple[Judged, ...]:
        """What no robot file can hold."""
        return tuple(x for x in self.result.items if x not in self.declared)

    @property
    def delays(self) -> tuple[Changed, ...]:
        """Delays of torques, which `identify` undoes."""
        return tuple(c for c in self.result.changes if c.cause.delay)

    @property
    def undone(self) -> tuple[Changed, ...]:
        """Changes that no robot file can hold; without delays, which `identify` undoes."""
        changes = (c for c in self.result.changes if c not in self.delays)
        return tuple(c for c in changes if c in self.undeclared)

    def without_columns(self, reason: str) -> Adopted:
        """Return the effects without those with columns that no robot file can hold."""
        lost = {x.key for x in self.result.effects if x not in self.declared}
        kept = [x for x in self.result.items if x.key not in lost]
        weighed = [replace(w, reason=reason) if w.item.key in lost else w for w in self.weighed]
        return replace(declare(restricted(self.result, kept), weighed), last=self.last)


def adopt(
    result: SearchResult,
    weighed: Sequence[Weighed],
    first: Identified,
    identify: Identify,
    least: float,
) -> Adopted:
    """Drop effects until all others hold in the fit of `identify`.

    Args:
        result: the search, restricted to hypotheses that lower the error on the validation logs.
        weighed: the grades of all hypotheses.
        first: the fit of the declared robot.
        identify: identifies a robot.
        least: smallest torque that matters, as a part of a joint's torque.
    """
    while True:
        adopted = declare(result, weighed)
        try:
            last = identify(adopted.robot, adopted.undone)
            adopted = replace(adopted, last=last)
            failing = _failing(adopted, first, least)
        except (IdentificationError, RobotError) as error:
            if not result.items:  # the declared model itself
                raise
            reason = f"the model with it cannot be identified: {error}"
            lost = _weakest(adopted)
            failing = {lost: reason}
            weighed = [replace(w, fell=0.0) if w.item.key == lost else w for w in weighed]
        if not failing:
            return adopted
        weighed = [replace(w, reason=failing.get(w.item.key, w.reason)) for w in weighed]
        result = restricted(result, [x for x in result.items if x.key not in failing])


def declare(result: SearchResult, weighed: Sequence[Weighed]) -> Adopted:
    """Write the accepted hypotheses into the robot, as far as its file can hold them."""
    together = fit_together(result)
    result = result.with_effects(together.values)
    robot, declared = result.problem.robot, list[Judged]()
    items: list[Changed | Score] = [*result.changes, *result.effects]
    for item in items:
        if isinstance(item, Score):
            more = _with_effect(robot, together, item)
        else:
            more = corrected(robot, item.cause)
        if more is not None:
            robot = more
            declared.append(item)
    return Adopted(result, tuple(weighed), robot, tuple(declared), together)


def _with_effect(robot: Robot, together: Together, score: Score) -> Robot | None:
    """Return the robot with an effect; None if its file cannot hold it."""
    c, values = score.cause, together.values[score].values.tolist()
    if c.name == GAIN:  # the channel has 1 + G times the torque
        return with_torques_scaled(robot, c.joints[0], 1 / (1 + values[0]))
    problem = together.problem
    names = (name for name, _ in coefficient_names(problem.robot, c))
    known = {} if problem.is_fixed else dict(zip(names, values, strict=False))
    return extended(robot, c.definition, c.joints, c.constants, known)


def coefficient_names(robot: Robot, c: Candidate) -> Sequence[tuple[str, str]]:
    """Return the name and the unit of each coefficient of an effect with a physical meaning."""
    return c.coefficients or c.definition.coefficients(*c.place(robot))


def _weakest(adopted: Adopted) -> object:
    """Return the key of the accepted hypothesis that explains the least."""
    fell = {w.item.key: w.fell for w in adopted.weighed}
    return min((x.key for x in adopted.result.items), key=lambda key: fell.get(key, 0.0))


def _failing(adopted: Adopted, first: Identified, least: float) -> dict[object, str]:
    """Return the hypotheses to drop, by key, each with the reason; empty if all hold."""
    assert adopted.last is not None
    refits = _Refits.of(adopted.last)
    declared = adopted.result.problem.evaluator.model
    values = adopted.together.values
    kept = {s: refits.columns(declared, s) for s in values}
    without: list[int] = []
    out: dict[object, str] = {}
    while kept:
        failing, now = {}, refits.errors(without)
        for score, at in kept.items():
            before = refits.errors([*without, *at]) if at else now
            errors = before, now
            explained, reason = refits.test(score, at, errors, values[score], least)
            ranges = adopted.result.ranges.get(score.key, {})
            reason = reason or _out_of_range(score, values[score], ranges)
            if reason:
                failing[score] = explained, reason
        if not failing:
            break
        weakest = min(failing, key=lambda score: failing[score][0])
        out[weakest.key] = failing[weakest][1]
        without += kept.pop(weakest)
    if not out and adopted.result.items:
        reason = _worse(first, adopted.last, least)
        if reason:
            out[_weakest(adopted)] = reason
    return out


def _worse(first: Identified, last: Solved, least: float) -> str:
    """Return why a fit is worse than the first one, or ""."""
    reason = ""
    before, after = (x.outcome.torque_held.in_motion.residual for x in (first, last))
    if not first.estimate.has(NO_ROBOT):
        reason = rising(before, after, last.campaign.robot, least)
    if reason or not isinstance(last, Identified):
        return reason
    was, now = (_position_errors(x.estimate) for x in (first, last))
    for seconds in was.keys() & now.keys():
        if math.isfinite(was[seconds]) and not now[seconds] <= WORSE * was[seconds]:
            return (
                f"with it, the position error of a simulation after {seconds:g} s rises from "
                f"{percent(was[seconds])} to {percent(now[seconds])} of the distance moved"
            )
    return ""


def _position_errors(estimate: Estimate) -> dict[float, float]:
    """Return the position error of the simulation after some times, by these in s; empty if the
    base moves.
    """
    if estimate.uses is None:
        return {}
    return {h.seconds: h.position_error for h in estimate.uses.simulation.horizons}


@dataclass(frozen=True, eq=False)
class _Refits:
    """Fits of the chosen model of an identification without some of its parameters.

    Attributes:
        last: the identification.
        factor: (p + 1, p + 1) triangular factor of its weighted equations [W y].
        X: (p,) the weighted least-squares solution.
    """

    last: Solved
    factor: FloatArray
    X: FloatArray

    @classmethod
    def of(cls, last: Solved) -> _Refits:
        """Return the refits of an identification, with the weights of its solution."""
        parts = summaries(rows_of(last.chosen.best.train).parts)
        weights = residual_weights(parts, last.outcome.settled.solution.X)
        factor = weighted_triangle(parts, weights)
        return cls(last, factor, shortest(factor))

    def columns(self, declared: Model, score: Score) -> list[int]:
        """Return the positions in X of the coefficients of an effect; empty if it has none.

        Args:
            declared: the model without the effect.
            score: the effect.
        """
        c, robot = score.cause, declared.robot
        names = [name for name, _ in coefficient_names(robot, c)]
        if c.definition.offset:
            names += [f"OF{robot.numbers[j]}" for j in c.joints]
        new = {*names} - {*declared.base.names}
        every = self.last.campaign.evaluator.model.base.names
        return [k for k, name in enumerate(every) if name in new]

    def errors(self, without: Sequence[int]) -> Residual:
        """Return the torque errors on the validation logs without some parameters."""
        kept = np.setdiff1d(np.arange(len(self.X)), without)
        X = np.zeros(len(self.X))
        columns = [*kept, len(self.X)]
        X[kept] = shortest(self.factor[:, columns])
        logs = self.last.campaign
        return fit(logs.evaluator, logs.held, X).in_motion.residual

    def test(
        self,
        score: Score,
        at: Sequence[int],
        errors: tuple[Residual, Residual],
        found: Coefficients,
        least: float,
    ) -> tuple[float, str]:
        """Return the part of a torque that an effect explains, and why it does not hold, or "".

        Args:
            score: the effect.
            at: positions of its coefficients in X; empty if X has none.
            errors: torque errors on the validation logs without the effect, and with it.
            found: its values as columns of the declared model.
            least: smallest torque that matters, as a part of a joint's torque.
        """
        # The fit with columns for the searched constants has their uncertainty, too.
        reason = _wrong_sign(score, found) or _unknown(found.values, found.covariance)
        if not at:
            return score.worth, reason
        covariance = self.last.outcome.settled.solution.covariance
        own = covariance[np.ix_(at, at)]
        reason = reason or _unknown(self.X[list(at)], own)
        was, now = (np.array(error.per_joint) for error in errors)
        explained = float(np.sqrt(np.maximum(was**2 - now**2, 0.0)).max())
        if not reason and explained < least:
            reason = (
                f"identified with it, it explains {percent(explained)} of the torque of a joint on "
                f"the validation data; what matters: {100 * least:.2g} %"
            )
        reason = reason or rising(*errors, self.last.campaign.robot, least)
        return explained, reason


def _wrong_sign(score: Score, found: Coefficients) -> str:
    """Return why the known coefficients of an effect are impossible, or ""."""
    if score.definition.sign != "positive" or score.cause.alters:
        return ""
    count = len(score.definition.linear)
    std = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    if (found.values < -BEYOND * std)[:count].any():
        return "its coefficient would have a sign that it cannot have"
    return ""


def _out_of_range(
    score: Score, found: Coefficients, ranges: Mapping[str, tuple[float, float]]
) -> str:
    """Return why a searched constant is not known within its range, or ""."""
    for (name, value), std in zip(score.cause.constants.items(), found.constants_std, strict=True):
        low, high = ranges.get(name, (-math.inf, math.inf))
        # The standard deviation is NaN if the logs do not determine the constants.
        reach = float(np.nan_to_num(std))
        inside = low - reach <= value <= high + reach
        if not inside or _INTERVAL * reach > (high - low) / 2:
            return f"its constant {name} = {value:.3g} +- {std:.2g} is not known within its range"
    return ""


def _unknown(values: FloatArray, covariance: FloatArray) -> str:
    """Return why the coefficients of an effect are not known, or ""."""
    if not np.isfinite(covariance).all():
        return ""  # the declared model absorbs a coefficient
    if not is_chance(values, covariance):
        return ""
    return f"its coefficients are not known: within {BEYOND:g} deviations, they are zero"
