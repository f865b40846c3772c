"""The search over the registry: hypotheses compete by how well they predict held-out motion.

    log-odds = score with it - score without + log(prior odds) + log(prior of its size)

The score is the log of a predictive density on folds of motion (`symgen.hypotheses.score`). The
prior of a size is Student's t. Constants on a grid are marginalised. Each step adds the most
probable hypothesis that lowers the held-out error of a joint by a part that matters. It then drops
the hypotheses that are no longer probable. A hypothesis is one of three kinds:

    columns added to the model         an effect of physics, a gain, an error of the geometry
    a change of all logs               a wrong sign, exchanged channels, a delay, a gear ratio
    a span with a separate variance    a contact, whose rows the fit does not use
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.estimation.values import FloatArray
from symgen.hypotheses.changes import TILT, Changed
from symgen.hypotheses.effects import Candidate, Score, total_odds
from symgen.hypotheses.event import Contact, judged_contact, likeliest_contact
from symgen.hypotheses.held import in_one_log
from symgen.hypotheses.judged import Judged
from symgen.hypotheses.problem import Problem, Stage
from symgen.hypotheses.refine import settled_constants
from symgen.hypotheses.registry import Registry, SearchResult, columns_in, leave_out
from symgen.hypotheses.rows import explained
from symgen.hypotheses.score import (
    DIGITS,
    TINY,
    Columns,
    Folded,
    Key,
    ScoreFit,
    price_of_size,
    worth_and_gain,
)
from symgen.hypotheses.terms import NAME as UNNAMED
from symgen.hypotheses.terms import Expressions, expressions
from symgen.hypotheses.touches import with_frame
from symgen.hypotheses.trials import exact_change, exact_gravity, motion_trials, torque_trials
from symgen.parallel import Say, silent
from symgen.policy import ALIKE, APART, LEAST, LISTED, LOUD, SAME, SHOWN, SURE

#: Ratio of the prior std of a size to the expected size. It limits undetermined coefficients.
_LOOSE = 10.0


def search(
    judge: Judge,
    start: SearchResult,
    steps: int | None = None,
    progress: Say = silent,
) -> SearchResult:
    """Add the most probable hypothesis and drop improbable ones, until none can be added.

    Args:
        judge: the hypotheses, and what a search on the same logs has already computed.
        start: the problem, without hypotheses or with those of a search with fewer steps.
        steps: largest number of hypotheses to add, without alternatives; None for no limit.
        progress: called with a text about the current trial.
    """
    registry, matters, result = judge.registry, judge.matters, start
    visited = {frozenset[Key](), result.keys}
    options: list[Score] = []
    for count in itertools.count(1) if steps is None else range(1, steps + 1):
        progress(f"trying {len(registry.pool)} candidates for effect {count}")
        stage = result.problem.stage(result.effects)
        options = judge.options(stage)
        others = judge.others(stage, result)
        every: list[Judged] = sorted((*options, *others), key=_odds, reverse=True)
        probable = [o for o in every if o.odds > 0 and o.worth >= matters]
        probable = judge.refined(stage, probable)
        nexts = (judge.pruned(judge.added(result, stage, o)) for o in probable)
        new = next((f for f in nexts if f.keys not in visited), None)
        if new is None:
            break
        result = new
        visited.add(result.keys)
    for tilt in result.changes:
        if tilt.definition.name == TILT:  # fit it again, on all logs and beside all effects
            rest = result.with_items(leave_out(result.items, tilt))
            stage = rest.problem.stage(rest.effects)
            exact = exact_gravity(stage, np.array(tilt.cause.gravity))
            result = rest.with_items((replace(tilt, cause=exact), *rest.items))
    result = in_one_log(result)
    if registry.contacts and result.problem.held:
        result = replace(result, held_contacts=tuple(_held_contacts(result, matters)))
    if steps is not None:
        return result
    rejected = tuple(judge.reasoned(s) for s in options if s.key not in result.keys)
    result = result.with_effects(sorted(judge.compared(result), key=lambda s: -s.gain))
    ranges = {s.key: registry.ranges(s.cause) for s in result.effects}
    return replace(result, rejected=rejected, tried=len(registry.pool), ranges=ranges)


def _held_contacts(result: SearchResult, matters: float) -> Iterator[Contact]:
    """Yield contacts in the validation logs without which little of their joint's error remains."""
    joined, size = result.problem.joined, result.problem.base.size
    held = result.problem.held
    effects = columns_in(joined, result.effects)
    score = joined.stage(effects).score
    while True:
        contact = likeliest_contact(score, held, size)
        if contact is None or contact.odds <= 0 or contact.worth < matters:
            return
        joined = joined.without([contact])
        held = joined.logs[: len(held)]
        before, score = score, joined.stage(effects).score
        remaining = np.sqrt(score.alone.variance / np.maximum(before.alone.variance, TINY))
        if remaining[contact.cause.equations].min() <= SHOWN:
            yield contact


@dataclass(frozen=True, eq=False)
class _Group:
    """Candidates on the same joints with equal numbers of columns, which share one score call."""

    members: Sequence[tuple[Candidate, Columns]]
    folded: Folded
    sizes: FloatArray


class Judge:
    """Scores the hypotheses of a registry in a model with accepted hypotheses.

    It stores the columns of one problem.

    Attributes:
        registry: the hypotheses.
        matters: smallest torque that matters, as a part of a joint's torque.
    """

    def __init__(self, problem: Problem, registry: Registry, matters: float = LEAST) -> None:
        """Judge hypotheses down to the misfit of a problem, if that is smaller than `matters`."""
        self.registry = registry
        # An effect that is small on the training motion may matter on other motion. `confirm`
        # decides.
        self.matters = min(matters, problem.misfit)
        self._problem: Problem | None = None
        #: Trials of the motion, by the undone changes and by whether more than gravity is tried.
        self._moved: dict[tuple[frozenset[Key], bool], list[Changed]] = {}
        self._groups: list[_Group] = []
        self._terms: Expressions | None = None
        #: Columns of the candidates, and what identifies the motion that they belong to.
        self._along: dict[Candidate, Columns] = {}
        self._motion: list[int] = []

    def options(self, stage: Stage, joints: frozenset[int] | None = None) -> list[Score]:
        """Return every effect that may be added to a stage, the most probable first.

        Args:
            stage: the model and the accepted effects.
            joints: positions of joints, on one of which an effect has to act; None for all.
        """
        entries: dict[Key, list[Score]] = {}
        for candidate, columns, fit in self._fits(stage, joints):
            judged = self._judged(stage, candidate, columns, fit)
            entries.setdefault(candidate.key, []).append(judged)
        out = []
        for (name, _), scores in entries.items():
            odds = np.array([s.odds for s in scores])
            best = scores[int(np.argmax(odds.round(DIGITS)))]
            terms = self._terms if name == UNNAMED else None
            count = len(scores) if terms is None else terms.count
            total = float(np.logaddexp.reduce(odds)) - np.log(count)
            out.append(replace(best, odds=total, cost=best.odds - total))
        return sorted(out, key=_odds, reverse=True)

    def others(self, stage: Stage, result: SearchResult) -> Iterator[Changed | Contact]:
        """Yield the most probable contact, and the changes of the logs that may be undone."""
        problem = stage.problem
        if self.registry.contacts:
            contact = likeliest_contact(stage.score, problem.logs, problem.base.size)
            if contact is not None:
                yield with_frame(stage, contact) if contact.odds > 0 else contact
        if not self.registry.changes or problem.is_fixed:
            return
        loud, moved = self._loud(stage), list[Changed]()
        # Accepted hypotheses may already explain the error that a change of the motion explains.
        if loud or not result.items:
            key = problem.undone, bool(loud)
            if key not in self._moved:
                self._moved[key] = [*motion_trials(problem, loud)]
            moved = self._moved[key]
        for trial in (*torque_trials(stage), *moved):
            if trial.key not in problem.undone:
                yield trial

    def refined(self, stage: Stage, probable: Sequence[Judged]) -> list[Judged]:
        """Return hypotheses in the order of their odds, and refine those near the best one.

        A grid may be too coarse for a sharp law. Hypotheses that are not certainly less probable
        than the best one therefore compete with fitted constants.

        Args:
            stage: the model and the accepted effects.
            probable: hypotheses that may be added, the most probable first.
        """
        near = [o for o in probable if o.odds > probable[0].odds - SURE]
        out = [*probable]
        for k, o in enumerate(near):
            if isinstance(o, Score):
                out[k] = o = self._scored(stage, o)
                if len(near) > 1 and o.cause.smooth:
                    out[k] = max(o, self._scored(stage, _refined(stage, o)), key=_odds)
        return sorted(out, key=_odds, reverse=True)

    def added(self, result: SearchResult, stage: Stage, new: Judged) -> SearchResult:
        """Return the result with one more hypothesis."""
        if isinstance(new, Score):
            exact = new.cause.first_order
            new = exact_change(stage, new) if exact else _refined(stage, new)
        return result.with_items((*result.items, new))

    def pruned(self, result: SearchResult) -> SearchResult:
        """Drop hypotheses that are improbable in a model with the others, the least probable first.

        Changes of all logs stay.
        """
        effects = list(result.effects)
        while effects:
            again = [self._scored(result.problem.stage(leave_out(effects, s)), s) for s in effects]
            failing = []
            for k, s in enumerate(again):
                odds = total_odds(s, again)
                if odds <= 0 or s.worth < self.matters:
                    failing.append((odds, s.worth, k))
            if not failing:
                effects = again
                break
            *_, weakest = min(failing)
            effects = leave_out(effects, effects[weakest])
        result = result.with_effects(effects)
        for contact in result.contacts:
            rest = result.with_items(leave_out(result.items, contact))
            stage = rest.problem.stage(rest.effects)
            alone = judged_contact(stage.score, contact.cause, stage.problem.base.size)
            if alone.odds <= 0 or alone.worth < self.matters:
                result = rest
        return result

    def compared(self, result: SearchResult) -> list[Score]:
        """Return the effects with their probabilities and their alternatives.

        Of effects that explain the same, the simplest is returned and the others are alternatives.
        """
        from scipy.special import softmax

        out = []
        for effect in result.effects:
            stage = result.problem.stage(leave_out(result.effects, effect))
            again = self._scored(stage, effect)
            e = explained(stage.rows, again.columns)
            rivals = []
            before = len(stage.problem.robot.free)
            reached = frozenset(row - before for row in effect.columns if row >= before)
            for s in self.options(stage, reached):
                if s.key in result.keys:
                    continue
                if s.odds < again.odds + math.log(LISTED):
                    break
                alike = _correlation(e, explained(stage.rows, s.columns))
                if alike > ALIKE:
                    rivals.append((alike, s))
            first = _simplest(again, [s for alike, s in rivals if alike > SAME])
            if first is not again:
                rivals = [(alike, again if s is first else s) for alike, s in rivals]
                again = _refined(stage, first)
            odds = [total_odds(again, result.effects), *(s.odds for _, s in rivals), 0.0]
            same, *weights, _ = softmax(odds).tolist()
            alternatives = []
            for weight, (alike, s) in zip(weights, rivals, strict=True):
                same += weight * (alike > SAME)
                if weight > LISTED:
                    alternatives.append(replace(s, probability=weight))
            out.append(replace(again, probability=same, alike=tuple(alternatives)))
        return out

    def reasoned(self, s: Score) -> Score:
        """Return a rejected effect with the reason."""
        why = f"it does not predict other motion better: log-odds {s.odds:.1f}"
        if s.worth < self.matters:
            why = (
                f"it lowers the error on motion it was not fitted on by {100 * s.worth:.2f} % of "
                f"the torque; what matters: {100 * self.matters:.2g} %"
            )
        return replace(s, why=s.why or why)

    def _loud(self, stage: Stage) -> frozenset[int]:
        """Return the joints whose error is large, or far above that of the quietest quarter."""
        lost = stage.lost[len(stage.problem.robot.free) :]
        usual = max(self.matters, np.sort(lost)[len(lost) // 4])
        return frozenset(map(int, np.flatnonzero(lost > min(LOUD, APART * usual))))

    def _prepare(self, stage: Stage) -> None:
        """Compute the columns of all candidates if the problem is new.

        Candidates whose columns are not finite on these logs are dropped. Changes of the torques
        leave the columns that depend on the motion alone.
        """
        if stage.problem is self._problem:
            return
        motion = [id(log.q) for log in stage.problem.logs]
        if motion != self._motion:
            self._motion, self._along, self._terms = motion, {}, None
        self._along = {c: x for c, x in self._along.items() if not c.uses_model}
        self._problem, loud = stage.problem, self._loud(stage)
        pool = [c for c in self.registry.pool if not c.rare or loud.issuperset(c.joints)]
        new = [c for c in pool if c not in self._along]
        self._along.update(zip(new, stage.log_columns.each(new), strict=True))
        pairs = ((c, self._along[c]) for c in pool)
        finite = (x for x in pairs if all(np.isfinite(c).all() for c in x[1].values()))
        self._groups = self._group(stage, finite)
        if self.registry.expressions and self._terms is None:
            self._terms = expressions(stage.problem)

    def _fits(
        self, stage: Stage, joints: frozenset[int] | None
    ) -> Iterator[tuple[Candidate, Columns, ScoreFit]]:
        """Yield the candidates that may be added to a stage, with their columns and fits.

        Columns are computed once for a problem. Accepted effects change the model's torque, so
        `refined` computes columns with this torque again for probable candidates.
        """
        self._prepare(stage)
        terms = () if self._terms is None else self._terms.best(stage.rows, joints)
        taken = {s.key for s in stage.effects}
        for group in (*self._groups, *self._group(stage, terms)):
            free = [self._admitted(c, stage, taken, joints) for c, _ in group.members]
            if any(free):
                fits = stage.score.each(group.folded, group.sizes)
                rows = zip(group.members, fits, strict=True)
                for (candidate, columns), fit in itertools.compress(rows, free):
                    yield candidate, columns, fit

    def _group(self, stage: Stage, pairs: Iterable[tuple[Candidate, Columns]]) -> list[_Group]:
        """Return candidates and their columns in groups that share one score call."""
        alike: dict[tuple[object, ...], list[tuple[Candidate, Columns]]] = {}
        for candidate, columns in pairs:
            count = next(iter(columns.values())).shape[1]
            key = candidate.joints, tuple(columns), count
            alike.setdefault(key, []).append((candidate, columns))
        out = []
        for same in alike.values():
            sizes = np.array([self._expected(stage, *x) for x in same])
            out.append(_Group(same, stage.score.folded([c for _, c in same]), sizes))
        return out

    def _admitted(
        self, candidate: Candidate, stage: Stage, taken: set[Key], joints: frozenset[int] | None
    ) -> bool:
        """Whether a candidate is new, acts on one of `joints`, and finds the effects it requires.

        Required friction counts as present if the robot declares it.
        """
        if candidate.key in taken and candidate.name != UNNAMED:
            return False
        if candidate.first_order and candidate.key in stage.problem.undone:
            return False
        if candidate.definition.motor and {*candidate.joints} & {*stage.problem.robot.passive}:
            return False
        if any(candidate.presumes(c) and c.key not in taken for c in self.registry.friction):
            return False
        return joints is None or not candidate.joints or bool(joints & {*candidate.joints})

    def _expected(self, stage: Stage, candidate: Candidate, columns: Columns) -> float:
        """Return the scale of the prior of a column's RMS torque, N m or N."""
        size = candidate.definition.size * stage.problem.base.size
        return _LOOSE * float(size[_acting(stage, candidate, columns)].max())

    def _judged(self, stage: Stage, candidate: Candidate, columns: Columns, fit: ScoreFit) -> Score:
        alone, base = stage.score.alone, stage.problem.base.size
        rows = _acting(stage, candidate, columns)
        known = {s.definition.name for s in stage.effects}
        # An effect on one joint makes the same effect on another joint more probable.
        row = candidate.definition
        prior = math.log(row.odds) * (0.5 if candidate.name in known else 1.0)
        if candidate.scales is not None:
            scales = np.array(candidate.scales)
            part = np.abs(fit.coefficients[: len(scales)]) / scales
        else:
            part = (fit.torque / (row.size * base))[rows]
        prior -= price_of_size(float(np.max(part)))
        # A ratio is 1, and a torque has a law with a name, unless another one is certainly better.
        product = candidate.name == UNNAMED and not candidate.constants
        prior -= SURE * (candidate.rare or product)
        if fit.score - alone.score + prior > 0:
            fit = self._possible(stage, candidate, columns, fit)
        evidence = fit.score - alone.score
        of_joints = stage.problem.robot.rows(candidate.joints) or rows
        worth, gain = worth_and_gain(alone.variance, fit.variance, base, of_joints)
        torque = float(np.max(fit.torque[rows]))
        why = "" if fit is not alone else "its coefficient would have a sign that it cannot have"
        odds = evidence + prior
        return Score(candidate, odds, worth, gain, torque, columns=columns, why=why)

    def _possible(
        self, stage: Stage, candidate: Candidate, columns: Columns, fit: ScoreFit
    ) -> ScoreFit:
        """Return the fit with coefficients of a physically impossible sign set to 0."""
        if candidate.definition.sign != "positive" or candidate.alters:
            return fit
        kept, named = [*range(candidate.size)], len(candidate.definition.linear)
        while wrong := {
            k for k, c in zip(kept, fit.coefficients, strict=True) if k < named and c < 0
        }:
            kept = [k for k in kept if k not in wrong]
            if not any(k < named for k in kept):
                return stage.score.alone
            signed = {j: c[:, kept] for j, c in columns.items()}
            fit = stage.score.fit_with(signed, self._expected(stage, candidate, columns))
        return fit

    def _scored(self, stage: Stage, score: Score) -> Score:
        """Return an effect with its score in a stage; the cost of its grid stays."""
        columns = score.columns
        if score.cause.uses_model:
            columns = stage.log_columns(score.cause)
        fit = stage.score.fit_with(columns, self._expected(stage, score.cause, columns))
        judged = self._judged(stage, score.cause, columns, fit)
        return replace(judged, odds=judged.odds - score.cost, cost=score.cost)


def _acting(stage: Stage, candidate: Candidate, columns: Columns) -> list[int]:
    """Return the equations by which the size of an effect is judged.

    These are all with columns. On a floating base, projected columns stand in other equations than
    those of its joints, too.
    """
    robot = stage.problem.robot
    return robot.rows(candidate.joints) if robot.floating else [*columns]


def _simplest(best: Score, same: Sequence[Score]) -> Score:
    """Return the simplest of the effects that explain the same and are about as probable.

    A law that contains another one, as a polynomial contains a spring, predicts as well where its
    further coefficients are zero.
    """
    equal = [s for s in same if s.odds > best.odds - SURE and s.cause.name != UNNAMED]
    return min([best, *equal], key=lambda s: s.cause.degrees)


def _refined(stage: Stage, new: Score) -> Score:
    """Return an effect with its constants fitted; the constants of the stage stay."""
    problem = replace(stage.problem, base=stage.rows)
    return settled_constants(problem, [new], stage.log_columns)[0]


def _odds(s: Judged) -> float:
    return round(s.odds, DIGITS)


def _correlation(a: FloatArray, b: FloatArray) -> float:
    sizes = float(np.linalg.norm(a) * np.linalg.norm(b))
    return abs(float(np.sum(a * b))) / max(sizes, TINY)
