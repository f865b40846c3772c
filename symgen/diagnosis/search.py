"""Search for the effects that are present: sets of effects compete by prediction of other motion.

The score of a set is its predictive score on folds (`symgen.estimation.predictive_score`) and its
prior:

    log-odds of an effect = score with it - score without + log(prior odds) + log(prior of its size)

Constants on a grid are marginalised. Sizes have a Student t prior with 3 degrees of freedom. An
effect competes with two models: the one without it, and that with a misfit of any shape
(`symgen.estimation.misfit_evidence`). The more probable of the two decides. Effects are added one
by one or as pairs on a joint, of which one may require the other, removed and exchanged while that
raises the odds. An effect that lowers the held-out torque error of every joint by less than `least`
is never named. Effects that explain the same form one class. The odds give the probability of each
of its names. A short span with an error of its own (`symgen.estimation.events`) competes as a
contact; the other effects then compete on the other rows.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from symgen import names
from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.contacts import Contact, probable_contact, weighed
from symgen.diagnosis.effects import Candidate, Score, Seen, leave_out
from symgen.diagnosis.refine import refined
from symgen.diagnosis.terms import NAME as UNNAMED
from symgen.diagnosis.terms import Expressions
from symgen.diagnosis.whitened_system import WhitenedSystem, explained, gain_of
from symgen.distributed import Say, in_turn, own_threads, silent
from symgen.estimation.misfit_evidence import MisfitEvidence
from symgen.estimation.predictive_score import (
    LEAST,
    MISFIT,
    Columns,
    Fit,
    Folded,
    PredictiveScore,
)
from symgen.estimation.values import FloatArray

#: Name and joints of a candidate.
Key = tuple[str, tuple[int, ...]]
#: Correlation above which two effects are one class; and above which they are alternatives.
_SAME, _ALIKE = 0.98, 0.8
_TIE = 3.0  # nats, difference below which the data do not distinguish two effects of one class
_FREEDOM = 3.0  # degrees of freedom of Student's t for sizes
#: Prior std of a size over the expected size, which limits what the rows do not determine.
_LOOSE = 10.0
_WRONG_SIGN = 6.0  # nats, penalty of a physically impossible sign
_PART = 0.3  # of an effect's largest column: smallest other column whose sign is tested
_FINE = 8  # number of best effects whose constants are refined between the grid
_PAIRED = 7  # number of best effects that are tried in pairs on a joint
_MOST = 12  # largest number of effects
#: Effects of the measuring chain.
MEASURING = ("time_delay", "velocity_sensor_error", "saturation", "drive_gain_error")


@dataclass(frozen=True, eq=False)
class Selection:
    """The result of the search.

    Attributes:
        accepted: accepted effects, the largest share in closing the gap first.
        rejected: the other effects, the most probable first, with the reason.
        tried: number of candidates.
        contacts: the contacts, whose samples the fit does not contain; None if none was searched.
    """

    accepted: tuple[Score, ...]
    rejected: tuple[Score, ...] = ()
    tried: int = 0
    contacts: tuple[Contact, ...] | None = None


@dataclass(frozen=True, eq=False)
class _Stage:
    """The model with the effects accepted so far.

    Attributes:
        system: the whitened equations.
        score: the predictive score for candidates beside it.
        seen: gives columns of candidates.
        names: names of the effects.
        keys: names and joints of the effects.
        of_misfit: makes `beside_misfit`.
    """

    system: WhitenedSystem
    score: PredictiveScore
    seen: Seen
    names: frozenset[str]
    keys: frozenset[Key]
    of_misfit: Callable[[], MisfitEvidence]

    @cached_property
    def beside_misfit(self) -> MisfitEvidence:
        """What says whether candidates are more than misfit."""
        return self.of_misfit()


@dataclass(frozen=True, eq=False)
class _Group:
    """Candidates on the same joints with as many columns, which are scored together.

    Attributes:
        candidates: what they are.
        columns: of each.
        folded: these columns together.
        sizes: RMS of the torque that a column of each is expected to have, N m or N.
    """

    candidates: Sequence[Candidate]
    columns: Sequence[Columns]
    folded: Folded
    sizes: FloatArray


class _Set(NamedTuple):
    """Effects that are added together.

    Attributes:
        odds: log-odds that they are present.
        evidence: part of the odds that is of the data.
        rests: part of the evidence that is of rests.
        effects: the effects.
    """

    odds: float = 0.0
    evidence: float = 0.0
    rests: float = 0.0
    effects: Sequence[Score] = ()


class Search:
    """The search among candidates.

    Args:
        baseline: the declared model and its logs.
        pool: the candidates.
        expressions: whether expressions without a name are candidates.
        contacts: whether contacts are candidates.
        least: smallest torque that matters, as a part of the joint's torque.
        misfit: smallest model error to expect, as a part of a joint's torque.
        progress: called with a text about what is being tried.
    """

    def __init__(
        self,
        baseline: Baseline,
        pool: Iterable[Candidate],
        expressions: bool = True,
        contacts: bool = True,
        least: float = LEAST,
        misfit: float = MISFIT,
        progress: Say = silent,
    ) -> None:
        self.whole, self.pool, self.progress = baseline, tuple(pool), progress
        #: The model and its logs without the contacts.
        self.baseline = baseline
        self.contacts = contacts
        self.least, self.misfit = least, misfit
        self.expressions = Expressions(baseline) if expressions else None
        #: Candidates whose columns do not hold the model's torque, and those whose do.
        self._fixed: Sequence[_Group] | None = None
        self._moving: Sequence[_Group] = ()
        #: Names of friction that is not declared; other effects may require it.
        self._plain = [
            c for c in self.pool if c.definition.native in names.FRICTION and not c.change
        ]

    def run(self) -> Selection:
        """Add, remove and exchange effects while the odds rise."""
        accepted: list[Score] = []
        contacts: list[Contact] = []
        seen: set[tuple[frozenset[Key], int]] = set()
        options: list[Score] = []
        while len(accepted) + len(contacts) < _MOST:
            self.progress(f"trying {len(self.pool)} candidates for effect {len(accepted) + 1}")
            stage = self._stage(accepted)
            self._moving = self._grouped(stage, uses_model=True)
            options = self._between(stage, self._options(stage))
            best = self._best(stage, options, self._built(accepted, options))
            logs, size = self.baseline.base.logs, self.baseline.base.size
            own = probable_contact(stage.score, logs, size, self.least) if self.contacts else None
            if own is not None and own.odds > best.odds:
                contacts = self._leave_out([*contacts, own])
                accepted = self._backward(accepted)
                continue
            if best.effects:
                chosen = [self._plainest(stage, s, options) for s in best.effects]
                new = [self._refined(stage, s) for s in chosen]
                accepted = self._exchanged(self._backward([*accepted, *new]), new)
            else:
                accepted = self._exchanged(self._backward(accepted), accepted)
            keys, count = frozenset(s.candidate.key for s in accepted), len(contacts)
            contacts = self._needed(contacts, accepted)
            # Two effects that replace each other in turn are equally good.
            if (keys, len(contacts)) in seen or (keys == stage.keys and len(contacts) == count):
                break
            seen.add((keys, len(contacts)))
        # The last exchange may have made another effect superfluous.
        found = self._told_apart(self._backward(accepted))
        found = self._merged(found)
        found.sort(key=lambda s: -s.gain)
        taken = {s.candidate.key for s in found}
        rejected = (self._reasoned(s) for s in options if s.candidate.key not in taken)
        left_out = tuple(contacts) if self.contacts else None
        return Selection(tuple(found), tuple(rejected), len(self.pool), left_out)

    def _leave_out(self, contacts: list[Contact]) -> list[Contact]:
        """Leave the samples of contacts out of all that follows."""
        self.baseline = self.whole.without(c.fault for c in contacts)
        self._fixed = None
        return contacts

    def _needed(self, contacts: list[Contact], accepted: Sequence[Score]) -> list[Contact]:
        """Return the contacts that are still probable beside the effects."""
        kept = list(contacts)
        for own in contacts:
            others = [c for c in kept if c is not own]
            self.baseline = self.whole.without(c.fault for c in others)
            score = self._stage(accepted).score
            again = weighed(score, own.event, own.fault, self.baseline.base.size)
            if again.odds <= 0 or again.worth < self.least:
                kept = others
            else:
                kept[kept.index(own)] = again
        return self._leave_out(kept) if contacts else kept

    def probable(self, accepted: Sequence[Score]) -> list[Score]:
        """Return those of some effects that are probable beside one another.

        Args:
            accepted: effects that the search found; others that it found may lack.
        """
        found = self._backward([*accepted])
        known = {s.candidate.key: s for s in accepted}
        return [
            replace(
                s,
                probability=min(
                    known[s.candidate.key].probability, 1 / (1 + float(np.exp(-s.odds)))
                ),
                alike=known[s.candidate.key].alike,
                confirmed=known[s.candidate.key].confirmed,
            )
            for s in found
        ]

    def _merged(self, found: list[Score]) -> list[Score]:
        """Return the effects with their expressions merged: one expression for each joint."""
        parts = [s for s in found if s.candidate.name == UNNAMED]
        if self.expressions is None or len(parts) < 2:
            return found
        rest = [s for s in found if s not in parts]
        sums = self.expressions.merged(s.candidate for s in parts)
        for candidate, columns in sums:
            whole = [*rest, *(Score(c, x) for c, x in sums if c is not candidate)]
            own = [s for s in parts if s.candidate.joints == candidate.joints]
            again = self._again(self._stage(whole), Score(candidate, columns))
            found = [
                *[s for s in found if s not in own],
                replace(again, probability=own[0].probability),
            ]
        return found

    def _reasoned(self, s: Score) -> Score:
        if s.worth < self.least:
            fault = (
                f"it lowers the error on motion it was not fitted on by {100 * s.worth:.2f} % of "
                f"the torque; what matters: {100 * self.least:.2g} %"
            )
        else:
            fault = f"it does not predict other motion better: log-odds {s.odds:.1f}"
        return replace(s, fault=fault)

    def _stage(self, accepted: Sequence[Score]) -> _Stage:
        system = self.baseline.beside(accepted)
        keys = frozenset(s.candidate.key for s in accepted)
        score = self.baseline.score(system, self.misfit, accepted)
        names = frozenset(name for name, _ in keys)
        misfit = partial(self.baseline.beside_misfit, system, self.misfit)
        return _Stage(system, score, self.baseline.seen(system), names, keys, misfit)

    def _options(self, stage: _Stage, joints: frozenset[int] | None = None) -> list[Score]:
        """Return every effect that may be added to a stage, the most probable first.

        Args:
            stage: the model and the accepted effects.
            joints: an effect has to act on one of these; None for all.
        """
        entries: dict[Key, list[Score]] = {}
        for candidate, columns, fit in self._fits(stage, joints):
            own = self._judged(stage, candidate, columns, fit)
            entries.setdefault(candidate.key, []).append(own)
        out = []
        for key, found in entries.items():
            odds = np.array([s.odds for s in found])
            best = found[int(np.argmax(odds))]
            count = self._grid(best.candidate) if key[0] == UNNAMED else len(found)
            whole = float(np.logaddexp.reduce(odds)) - np.log(count)
            out.append(replace(best, odds=whole))
        return sorted(out, key=lambda s: -s.odds)

    def _between(self, stage: _Stage, options: Sequence[Score]) -> list[Score]:
        """Return the options; the constants of the first ones are refined where that scores better.

        A grid may miss a narrow peak. A refined value still pays the prior cost of the whole grid.
        """
        out = list(options)
        best = in_turn(lambda s: self._refined(stage, s), options[:_FINE], own_threads())
        for k, (s, own) in enumerate(zip(options, best, strict=False)):
            fit = None
            if own.candidate is not s.candidate:
                fit = self._fit(stage, own.candidate, own.columns)
            if fit is not None:
                found = self._judged(stage, own.candidate, own.columns, fit)
                odds = found.odds - np.log(self._grid(s.candidate))
                if odds > s.odds:
                    out[k] = replace(found, odds=odds)
        return sorted(out, key=lambda s: -s.odds)

    def _fits(
        self, stage: _Stage, joints: frozenset[int] | None
    ) -> Iterator[tuple[Candidate, Columns, Fit]]:
        """Yield the candidates that may be added to a stage, with their columns and scores.

        Columns without the model's torque are computed once. Columns with it are computed for all
        joints whenever an effect is added; exchanges in between change them little.
        """
        self._fixed = self._fixed or self._grouped(stage, uses_model=False)
        terms = [] if self.expressions is None else self.expressions.best(stage.system, joints)
        for group in (*self._fixed, *self._moving, *self._together(stage, terms)):
            own = [self._admitted(c, stage, joints) for c in group.candidates]
            if any(own):
                fits = stage.score.each(group.folded, group.sizes)
                rows = zip(group.candidates, group.columns, fits, strict=True)
                yield from itertools.compress(rows, own)

    def _grouped(self, stage: _Stage, *, uses_model: bool) -> list[_Group]:
        """Return candidates with their columns beside a stage, without those of no number."""
        candidates = [c for c in self.pool if c.uses_model == uses_model]
        found = zip(candidates, stage.seen.each(candidates), strict=True)
        finite = (x for x in found if all(np.isfinite(c).all() for c in x[1].values()))
        return self._together(stage, finite)

    def _together(self, stage: _Stage, found: Iterable[tuple[Candidate, Columns]]) -> list[_Group]:
        """Return candidates and their columns, those together that are scored together."""
        alike: dict[tuple[object, ...], list[tuple[Candidate, Columns]]] = {}
        for candidate, columns in found:
            count = next(iter(columns.values())).shape[1]
            alike.setdefault((candidate.joints, tuple(columns), count), []).append(
                (candidate, columns)
            )
        out = []
        for same in alike.values():
            own, torques = [c for c, _ in same], [c for _, c in same]
            sizes = np.array([self._expected(*x) for x in same])
            out.append(_Group(own, torques, stage.score.folded(torques), sizes))
        return out

    def _admitted(self, candidate: Candidate, stage: _Stage, joints: frozenset[int] | None) -> bool:
        """Whether a candidate is new, acts on one of `joints`, and has the effects it requires."""
        if candidate.key in stage.keys and candidate.name != UNNAMED:
            return False
        if any(candidate.presumes(c) and c.key not in stage.keys for c in self._plain):
            return False
        return joints is None or not candidate.joints or bool(joints & {*candidate.joints})

    def _sizes(self, candidate: Candidate) -> FloatArray:
        """Return the expected RMS torque of an effect on its joints, (n,)."""
        return candidate.definition.size * self.baseline.base.size

    def _expected(self, candidate: Candidate, columns: Columns) -> float:
        """Return the RMS torque of a column from which it is drawn to zero, N m or N."""
        size = self._sizes(candidate)
        return _LOOSE * max(float(size[j]) for j in columns)

    def _fit(self, stage: _Stage, candidate: Candidate, columns: Columns) -> Fit | None:
        if not all(np.isfinite(c).all() for c in columns.values()):
            return None
        return stage.score.beside(columns, self._expected(candidate, columns))

    def _judged(self, stage: _Stage, candidate: Candidate, columns: Columns, fit: Fit) -> Score:
        alone, d = stage.score.alone, candidate.definition
        prior = np.log(d.odds) * (0.5 if candidate.name in stage.names else 1.0)
        if candidate.scales is not None:
            scales = np.array(candidate.scales)
            part = np.abs(fit.coefficients[: len(scales)]) / scales
        else:
            part = fit.torque / self._sizes(candidate)
        size = (_FREEDOM + 1) / 2 * float(np.log1p(np.max(part) ** 2 / _FREEDOM))
        turned = self._turned(candidate, columns, fit)
        prior -= size + _WRONG_SIGN * turned
        evidence = fit.score - alone.score
        base = self.baseline.base.size
        fell = alone.left - fit.left
        joints = list(candidate.joints) or list(columns)
        was = float(np.sum((alone.left / base**2)[joints]))
        gain = float(np.sum((fell / base**2)[joints])) / max(was, 1e-300)
        torque = float(np.max(fit.torque))
        worth, odds = self._worth(stage, fit), evidence + prior
        rests = fit.rests - alone.rests
        return Score(
            candidate, columns, odds, evidence, rests, fit.left, worth, gain, torque, turned
        )

    def _worth(self, stage: _Stage, fit: Fit) -> float:
        """Return the largest relative reduction of a joint's torque error by a fit."""
        fell = np.maximum(stage.score.alone.left - fit.left, 0)
        return float(np.max(np.sqrt(fell) / self.baseline.base.size))

    def _turned(self, candidate: Candidate, columns: Columns, fit: Fit) -> bool:
        """Whether a coefficient has a physically impossible sign."""
        if candidate.definition.sign != "positive" or candidate.change:
            return False
        size = np.sqrt(np.sum([np.sum(c**2, axis=0) for c in columns.values()], axis=0))
        told = (size * fit.coefficients)[: len(candidate.definition.linear)]
        return bool((told < -_PART * np.abs(told).max(initial=0.0)).any())

    def _best(self, stage: _Stage, options: Sequence[Score], built: Iterable[_Set]) -> _Set:
        """Return the most probable set of effects that matter; an empty one if none is probable.

        Sets are asked in the order of their odds, as long as the misfit, which only lowers them,
        may leave them the most probable.
        """
        best, left = _Set(), 0.0
        for own in sorted((*self._sets(stage, options), *built), key=lambda s: -s.odds):
            if own.odds <= left:
                break
            odds = own.odds - self._lost(stage, own)
            if odds > left:
                best, left = own, odds
        return best

    def _lost(self, stage: _Stage, own: _Set) -> float:
        """Return by how much a misfit of any shape lowers the odds of a set of effects, nats."""
        columns, units = own.effects[0].columns, self._units(stage, own.effects[0])
        for s in own.effects[1:]:
            columns = _beside(columns, s.columns, stage.system.y.shape)
            units = np.concatenate([units, self._units(stage, s)])
        return max(own.evidence - own.rests - stage.beside_misfit.of(columns, units), 0.0)

    def _units(self, stage: _Stage, s: Score) -> FloatArray:
        """Return the expected coefficients of an effect, (m,)."""
        sizes, weight = self._sizes(s.candidate), stage.system.moves
        squares = [
            np.sum((c * weight[:, [j]]) ** 2, axis=0) / np.sum(weight[:, j] ** 2) / sizes[j] ** 2
            for j, c in s.columns.items()
            if weight[:, j].any()
        ]
        largest = np.sqrt(np.max(squares, axis=0, initial=0.0))
        units = 1 / np.where(largest > 0, largest, 1.0)
        known = s.candidate.scales or ()
        return np.asarray([*known, *units[len(known) :]])

    def _sets(self, stage: _Stage, options: Sequence[Score]) -> Iterator[_Set]:
        """Yield the odds of single effects, and of pairs on a joint, that matter."""
        for s in options:
            if s.worth >= self.least:
                yield _Set(s.odds, s.evidence, s.rests, [s])
        for a, b in itertools.combinations(options[:_PAIRED], 2):
            if (
                not set(a.columns) & set(b.columns)
                or a.candidate.uses_model != b.candidate.uses_model
            ):
                continue
            both = _beside(a.columns, b.columns, stage.system.y.shape)
            fit = stage.score.beside(both, _LOOSE * float(np.max(self._sizes(a.candidate))))
            if self._worth(stage, fit) < self.least * np.sqrt(2):
                continue
            # priors and grids of each effect, as computed alone
            priors = sum(s.odds - s.evidence for s in (a, b))
            evidence = fit.score - stage.score.alone.score
            rests = fit.rests - stage.score.alone.rests
            yield _Set(evidence + priors, evidence, rests, [a, b])

    def _built(self, accepted: Sequence[Score], options: Sequence[Score]) -> Iterator[_Set]:
        """Yield the odds of friction with an effect that requires it, as pairs that matter."""
        plain = {c.key for c in self._plain}
        for s in options:
            if s.candidate.key not in plain or s.odds <= 0 or s.worth < self.least:
                continue
            stage = self._stage([*accepted, s])
            for more in self._options(stage, frozenset(s.candidate.joints)):
                if more.candidate.presumes(s.candidate) and more.worth >= self.least:
                    odds, evidence = s.odds + more.odds, s.evidence + more.evidence
                    yield _Set(odds, evidence, s.rests + more.rests, [s, more])

    def _plainest(self, stage: _Stage, best: Score, options: Sequence[Score]) -> Score:
        """Return the simplest effect that explains the same as the best one.

        If the held-out torque differs by less than `least`, prior odds and the number of parameters
        decide.
        """
        if best.left is None:
            return best
        own, base = explained(stage.system, best.columns), self.baseline.base.size
        near = [best]
        for s in options:
            plainer = _plainness(s) > _plainness(best)
            if not plainer or s.left is None or not set(s.columns) & set(best.columns):
                continue
            more = np.sqrt(np.maximum(s.left - best.left, 0)) / base
            tied = s.odds > best.odds - _TIE or bool((more < self.least).all())
            equal = s.odds > 0 and tied
            if equal and _correlation(own, explained(stage.system, s.columns)) > _SAME:
                near.append(s)
        return max(near, key=_plainness)

    def _refined(self, stage: _Stage, s: Score) -> Score:
        """Return an effect with constants between the values of the grid."""
        if self.expressions is not None and s.candidate.name == UNNAMED:
            candidate, columns = self.expressions.refined(stage.system, s.candidate)
            return replace(s, candidate=candidate, columns=columns)
        grid = [c.constants for c in self.pool if c.key == s.candidate.key]
        candidate, columns = refined(
            s.candidate, grid, stage.seen, lambda c: gain_of(stage.system, c)
        )
        return replace(s, candidate=candidate, columns=columns)

    def _again(self, stage: _Stage, own: Score) -> Score:
        """Return the score of an effect beside others; the cost of its grid stays."""
        columns = stage.seen(own.candidate) if own.candidate.uses_model else own.columns
        fit = self._fit(stage, own.candidate, columns)
        assert fit is not None  # it was finite before
        found = self._judged(stage, own.candidate, columns, fit)
        odds = found.odds - np.log(self._grid(own.candidate)) / 2
        return self._doubted(stage, replace(found, odds=odds))

    def _doubted(self, stage: _Stage, s: Score) -> Score:
        """Return an effect with the odds that a misfit of any shape leaves it."""
        lost = self._lost(stage, _Set(s.odds, s.evidence, s.rests, [s]))
        return replace(s, odds=s.odds - lost, evidence=s.evidence - lost)

    def _grid(self, candidate: Candidate) -> int:
        if self.expressions is not None and candidate.name == UNNAMED:
            return self.expressions.count
        return max(1, sum(c.key == candidate.key for c in self.pool))

    def _backward(self, accepted: list[Score]) -> list[Score]:
        """Remove effects that are not probable beside the others, the least probable first."""
        while accepted:
            again = [self._again(self._stage(leave_out(accepted, s)), s) for s in accepted]
            failing = [k for k, s in enumerate(again) if s.odds <= 0 or s.worth < self.least]
            if not failing:
                return again
            worst = min(failing, key=lambda k: (again[k].odds, again[k].worth))
            accepted = leave_out(accepted, accepted[worst])
        return accepted

    def _exchanged(self, accepted: list[Score], new: Sequence[Score]) -> list[Score]:
        """Select effects again among all on their joints, beside the other effects.

        Args:
            accepted: all effects.
            new: the latest effects. An effect that shares no joint with another one of them is not
                selected again.
        """
        fresh = [s.candidate.key for s in new]
        joints = {key: frozenset(s.columns) for key, s in zip(fresh, new, strict=True)}
        for at in range(len(accepted) if len(accepted) > 1 else 0):
            rest, own = accepted[:at] + accepted[at + 1 :], accepted[at]
            beside = [joints[key] for key in fresh if key != own.candidate.key]
            if len(leave_out(accepted, own)) < len(rest) or not any(
                map(frozenset(own.columns).intersection, beside)
            ):
                continue  # other effects require it, or nothing changed on its joints
            stage = self._stage(rest)
            near = frozenset(own.candidate.joints) or None
            options = [s for s in self._options(stage, near) if s.worth >= self.least]
            if options and options[0].candidate.key != own.candidate.key:
                options = self._between(stage, options)
                best = self._refined(stage, self._plainest(stage, options[0], options))
                if (
                    best.candidate.key != own.candidate.key
                    and self._doubted(stage, best).odds > self._again(stage, own).odds
                ):
                    accepted = [*accepted[:at], best, *accepted[at + 1 :]]
                    fresh.append(best.candidate.key)
                    joints[best.candidate.key] = frozenset(best.columns)
        return accepted

    def _told_apart(self, accepted: Sequence[Score]) -> list[Score]:
        """Return the effects with their probabilities and their alternatives."""
        out = []
        for own in accepted:
            stage = self._stage(leave_out(accepted, own))
            joints = frozenset(own.columns)
            taken = {s.candidate.key for s in accepted}
            options = [s for s in self._options(stage, joints) if s.candidate.key not in taken]
            again = self._again(stage, own)
            e = explained(stage.system, again.columns)
            rivals = []
            for s in options:
                if s.odds < again.odds - 5:
                    break
                other = explained(stage.system, s.columns)
                alike = _correlation(e, other)
                if alike > _ALIKE:
                    rivals.append((alike, self._doubted(stage, s)))
            odds = np.array([again.odds, *(s.odds for _, s in rivals), 0.0])
            weight = np.exp(odds - odds.max())
            weight /= weight.sum()
            same = weight[0] + sum(
                w for w, (alike, _) in zip(weight[1:], rivals, strict=False) if alike > _SAME
            )
            others = tuple(
                replace(s, probability=float(w))
                for w, (_, s) in zip(weight[1:], rivals, strict=False)
                if w > 0.05
            )
            out.append(replace(again, probability=float(same), alike=others))
        return out


def _plainness(s: Score) -> tuple[bool, float, int]:
    """Return a key to compare by: possible signs, prior odds, minus the number of parameters."""
    c = s.candidate
    return not s.turned, c.definition.odds, -(c.size + len(c.constants))


def _correlation(a: FloatArray, b: FloatArray) -> float:
    sizes = float(np.linalg.norm(a) * np.linalg.norm(b))
    return abs(float(np.sum(a * b))) / max(sizes, 1e-300)


def _beside(a: Columns, b: Columns, shape: tuple[int, ...]) -> Columns:
    """Return the columns of two effects on the joints of both."""
    out = {}
    sizes = [next(iter(c.values())).shape[1] for c in (a, b)]
    for j in sorted({*a, *b}):
        parts = [c.get(j, np.zeros((shape[0], m))) for c, m in zip((a, b), sizes, strict=True)]
        out[j] = np.concatenate(parts, axis=1)
    return out
