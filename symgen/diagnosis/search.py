"""Search for the effects that are present: sets of effects compete by prediction of other motion.

The score of a set is its predictive score on folds (`symgen.estimation.predictive_score`) and its
prior:

    log-odds of an effect = score with it - score without + log(prior odds) + log(prior of its size)

Constants on a grid are marginalised. Sizes have a Student t prior with 3 degrees of freedom. An
effect competes with two models: the one without it, and that with a misfit of any shape
(`symgen.estimation.misfit_evidence`). The more probable of the two decides. Effects are added one
by one, and removed, while that raises the odds. An effect that lowers the held-out torque error of
every joint by less than `least` is never named. Effects that explain the same form one class. The
odds give the probability of each of its names. A short span with an error of its own
(`symgen.estimation.events`) competes as a contact; the other effects then compete on the other
rows.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from symgen import names
from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.contacts import Contact, probable_contact, weighed
from symgen.diagnosis.effects import Candidate, Score, Seen, leave_out, odds_together
from symgen.diagnosis.refine import settled_constants
from symgen.diagnosis.terms import NAME as UNNAMED
from symgen.diagnosis.terms import expressions as terms_of
from symgen.diagnosis.whitened_system import WhitenedSystem, explained
from symgen.estimation.misfit_evidence import MisfitEvidence
from symgen.estimation.predictive_score import Columns, Fit, Folded, PredictiveScore, price_of_size
from symgen.estimation.values import FloatArray
from symgen.parallel import Say, silent
from symgen.policy import LEAST, MISFIT

#: Name and joints of a candidate.
Key = tuple[str, tuple[int, ...]]
#: What is named: effects, and the number of contacts.
_Present = tuple[frozenset[Key], int]
#: Correlation above which two effects are one class; and above which they are alternatives.
_SAME, _ALIKE = 0.98, 0.8
#: Prior std of a size over the expected size, which limits what the rows do not determine.
_LOOSE = 10.0
_TURNED = "the logs ask for a coefficient with a sign that it cannot have"


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
        keys: names and joints of the effects.
        of_misfit: makes `beside_misfit`.
    """

    system: WhitenedSystem
    score: PredictiveScore
    seen: Seen
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
        self.expressions = terms_of(baseline) if expressions else None
        #: Candidates whose columns do not hold the model's torque, and those whose do.
        self._fixed: Sequence[_Group] | None = None
        self._moving: Sequence[_Group] = ()
        #: Names of friction that is not declared; other effects may require it.
        self._plain = [
            c for c in self.pool if c.definition.native in names.FRICTION and not c.change
        ]

    def run(self) -> Selection:
        """Add and remove effects while the odds rise."""
        accepted: list[Score] = []
        contacts: list[Contact] = []
        seen = {_present(accepted, contacts)}
        while True:
            self.progress(f"trying {len(self.pool)} candidates for effect {len(accepted) + 1}")
            stage = self._stage(accepted)
            self._moving = self._grouped(stage, uses_model=True)
            options, found = self._step(stage, accepted, contacts, seen)
            if found is None:
                told = self._told_apart(accepted)
                if (others := self._exchanged(told)) is None:
                    break
                found = others, contacts
                if _present(*found) in seen:
                    told = self._told_apart(others)
                    break
            accepted, contacts = found
            seen.add(_present(accepted, contacts))
        named = sorted(told, key=lambda s: -s.gain)
        taken = {s.candidate.key for s in named}
        rejected = (self._reasoned(stage, s) for s in options if s.candidate.key not in taken)
        left_out = tuple(contacts) if self.contacts else None
        return Selection(tuple(named), tuple(rejected), len(self.pool), left_out)

    def _step(
        self,
        stage: _Stage,
        accepted: list[Score],
        contacts: list[Contact],
        seen: Set[_Present],
    ) -> tuple[list[Score], tuple[list[Score], list[Contact]] | None]:
        """Add what is most probable beside some effects, and remove what is not probable then.

        What leads back to effects that were seen gives way to the next.

        Returns:
            What may be added; and the effects and contacts that are not in `seen`, None if all are.
        """
        options, fine, tried = self._options(stage), False, set[Key | None]()
        logs, size = self.baseline.base.logs, self.baseline.base.size
        while True:
            left = [s for s in options if s.candidate.key not in tried]
            odds, best = self._best(stage, left, accepted)
            if not best and not fine:  # a law may be sharper than its grid is fine
                options, fine = self._between(stage, options, accepted), True
                continue
            search = self.contacts and None not in tried
            own = probable_contact(stage.score, logs, size, self.least) if search else None
            if own is not None and own.odds > odds:
                effects, marked = accepted, self._leave_out([*contacts, own])
                tried.add(None)
            elif best:
                effects = [*accepted, *best]
                effects, marked = [*settled_constants(self.baseline, effects, stage.seen)], contacts
                tried |= {s.candidate.key for s in best}
            else:
                return options, None
            effects = self._backward(effects)
            marked = self._needed(marked, effects)
            if _present(effects, marked) not in seen:
                return options, (effects, marked)
            if [c.fault for c in marked] != [c.fault for c in contacts]:
                self._leave_out(contacts)

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
        from scipy.special import expit

        known = {s.candidate.key: s for s in accepted}
        out = []
        beside = self._backward([*accepted])
        for s in beside:
            was = known[s.candidate.key]
            probability = min(was.probability, float(expit(odds_together(s, beside))))
            out.append(
                replace(s, probability=probability, alike=was.alike, confirmed=was.confirmed)
            )
        return out

    def _reasoned(self, stage: _Stage, s: Score) -> Score:
        """Return an effect that is not named with the reason."""
        if s.fault:
            return s
        if s.worth < self.least:
            fault = (
                f"it lowers the error on motion it was not fitted on by {100 * s.worth:.2f} % of "
                f"the torque; what matters: {100 * self.least:.2g} %"
            )
        elif s.odds > 0:
            s = self._doubted(stage, s)
            fault = (
                "a function of the state of any shape explains this torque as well: log-odds of "
                f"the law {s.odds:.1f}"
            )
        else:
            fault = f"it does not predict other motion better: log-odds {s.odds:.1f}"
        return replace(s, fault=fault)

    def _stage(self, accepted: Sequence[Score]) -> _Stage:
        system = self.baseline.beside(accepted)
        keys = frozenset(s.candidate.key for s in accepted)
        score = self.baseline.score(system, self.misfit, accepted)
        misfit = partial(self.baseline.beside_misfit, system, self.misfit)
        return _Stage(system, score, self.baseline.seen(system), keys, misfit)

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
            terms = self.expressions if key[0] == UNNAMED else None
            count = len(found) if terms is None else terms.count
            whole = float(np.logaddexp.reduce(odds)) - np.log(count)
            out.append(replace(best, odds=whole, cost=best.odds - whole))
        return sorted(out, key=_odds, reverse=True)

    def _between(
        self, stage: _Stage, options: Sequence[Score], accepted: Sequence[Score]
    ) -> list[Score]:
        """Return the options, the best of each joint with constants between those of its grid."""
        tried, out = set[tuple[int, ...]](), []
        lacks = np.sqrt(stage.score.alone.left) >= self.least * self.baseline.base.size
        for s in options:
            c = s.candidate
            # No effect lowers an error by more than there is.
            matters = s.evidence > 0 and lacks[list(s.columns)].any()
            if c.smooth and matters and c.joints not in tried:
                tried.add(c.joints)
                *_, own = settled_constants(self.baseline, [*accepted, s], stage.seen)
                s = max(s, self._scored(stage, own), key=_odds)
            out.append(s)
        return sorted(out, key=_odds, reverse=True)

    def _fits(
        self, stage: _Stage, joints: frozenset[int] | None
    ) -> Iterator[tuple[Candidate, Columns, Fit]]:
        """Yield the candidates that may be added to a stage, with their columns and scores.

        Columns without the model's torque are computed once. Columns with it are computed for all
        joints whenever an effect is added.
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
        own_terms = candidate.name == UNNAMED and candidate.definition.own
        if candidate.key in stage.keys and not own_terms:
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

    def _judged(self, stage: _Stage, candidate: Candidate, columns: Columns, fit: Fit) -> Score:
        alone, known = stage.score.alone, {name for name, _ in stage.keys}
        prior = np.log(candidate.definition.odds) * (0.5 if candidate.name in known else 1.0)
        if candidate.scales is not None:
            scales = np.array(candidate.scales)
            part = np.abs(fit.coefficients[: len(scales)]) / scales
        else:
            part = fit.torque / self._sizes(candidate)
        size = price_of_size(float(np.max(part)))
        prior -= size
        if fit.score - alone.score + prior > 0:
            fit = self._possible(stage, candidate, columns, fit)
        evidence = fit.score - alone.score
        base = self.baseline.base.size
        fell = alone.left - fit.left
        joints = list(candidate.joints) or list(columns)
        was = float(np.sum((alone.left / base**2)[joints]))
        gain = float(np.sum((fell / base**2)[joints])) / max(was, 1e-300)
        torque = float(np.max(fit.torque))
        worth = float(np.max(np.sqrt(np.maximum(fell, 0.0)) / base))
        odds, rests = evidence + prior, fit.rests - alone.rests
        own = Score(candidate, columns, odds, 0.0, evidence, rests, fit.left, worth, gain, torque)
        return own if fit is not alone else replace(own, fault=_TURNED)

    def _possible(self, stage: _Stage, candidate: Candidate, columns: Columns, fit: Fit) -> Fit:
        """Return the fit in which a coefficient with a physically impossible sign is 0."""
        if candidate.definition.sign != "positive" or candidate.change:
            return fit
        own, named = [*range(candidate.size)], len(candidate.definition.linear)
        while wrong := {
            k for k, c in zip(own, fit.coefficients, strict=True) if k < named and c < 0
        }:
            own = [k for k in own if k not in wrong]
            if not any(k < named for k in own):
                return stage.score.alone
            left = {j: c[:, own] for j, c in columns.items()}
            fit = stage.score.beside(left, self._expected(candidate, columns))
        return fit

    def _best(
        self, stage: _Stage, options: Sequence[Score], accepted: Sequence[Score]
    ) -> tuple[float, list[Score]]:
        """Return the most probable effect that matters with its odds; none if none is probable.

        Effects are asked in the order of their odds, as long as the misfit, which only lowers them,
        may leave them the most probable. Friction may come with other friction of its joint, or
        with an effect that requires it.
        """
        best: list[Score] = []
        left, told = 0.0, dict[Key, Score]()

        def doubted(s: Score) -> Score:
            key = s.candidate.key
            return told[key] if key in told else told.setdefault(key, self._doubted(stage, s))

        for s in options:
            if s.odds <= left:
                break
            if s.worth >= self.least and (own := doubted(s)).odds > left:
                best, left = [own], own.odds
        plain = {c.key for c in self._plain}
        for s in options:
            if s.candidate.key not in plain or s.odds <= 0 or s.worth < self.least:
                continue
            own, beside = doubted(s), self._stage([*accepted, s])
            for more in self._options(beside, frozenset(s.candidate.joints)):
                if own.odds + more.odds <= left:
                    break
                law = more.candidate.key in plain or more.candidate.presumes(s.candidate)
                if law and more.worth >= self.least:
                    more = self._doubted(beside, more)
                    if own.odds + more.odds > left:
                        best, left = [own, more], own.odds + more.odds
        return left, best

    def _doubted(self, stage: _Stage, s: Score, among: Iterable[int] | None = None) -> Score:
        """Return an effect with the odds that a misfit of any shape leaves it.

        Args:
            stage: the model and the accepted effects.
            s: the effect beside them.
            among: joints that have a misfit; None for those of the effect.
        """
        shown = stage.beside_misfit.of(s.columns, self._units(stage, s), among)
        lost = max(s.evidence - s.rests - shown, 0.0)
        return replace(s, odds=s.odds - lost, evidence=s.evidence - lost)

    def _units(self, stage: _Stage, s: Score) -> FloatArray:
        """Return the expected coefficients of an effect, (m,)."""
        units = stage.beside_misfit.units(s.columns, self._sizes(s.candidate))
        known = s.candidate.scales or ()
        return np.asarray([*known, *units[len(known) :]])

    def _scored(self, stage: _Stage, own: Score) -> Score:
        """Return an effect beside others; the cost of its grid stays."""
        columns = stage.seen(own.candidate) if own.candidate.uses_model else own.columns
        fit = stage.score.beside(columns, self._expected(own.candidate, columns))
        found = self._judged(stage, own.candidate, columns, fit)
        return replace(found, odds=found.odds - own.cost, cost=own.cost)

    def _again(self, stage: _Stage, own: Score) -> Score:
        """Return an effect beside others, with the odds that a misfit of any shape leaves it."""
        return self._doubted(stage, self._scored(stage, own))

    def _backward(self, accepted: list[Score]) -> list[Score]:
        """Remove effects that are not probable beside the others, the least probable first."""
        while accepted:
            again = [self._again(self._stage(leave_out(accepted, s)), s) for s in accepted]
            odds = [odds_together(s, again) for s in again]
            failing = [k for k, s in enumerate(again) if odds[k] <= 0 or s.worth < self.least]
            if not failing:
                return again
            worst = min(failing, key=lambda k: (odds[k], again[k].worth))
            accepted = leave_out(accepted, accepted[worst])
        return accepted

    def _exchanged(self, told: Sequence[Score]) -> list[Score] | None:
        """Return effects with one replaced by another that is like it and more probable."""
        for own in sorted(told, key=lambda s: s.probability):
            other = max(own.alike, key=_odds, default=own)
            if other.odds > odds_together(own, told):  # the probability is that of the class
                return self._backward([*(s for s in told if s is not own), other])
        return None

    def _told_apart(self, accepted: Sequence[Score]) -> list[Score]:
        """Return the effects with their probabilities and their alternatives."""
        from scipy.special import softmax

        out = []
        for own in accepted:
            stage = self._stage(leave_out(accepted, own))
            joints = frozenset(own.columns)
            taken = {s.candidate.key for s in accepted}
            options = [s for s in self._options(stage, joints) if s.candidate.key not in taken]
            alone = self._scored(stage, own)
            again = self._doubted(stage, alone)
            e = explained(stage.system, again.columns)
            rivals = []
            for s in options:
                if s.odds < again.odds - 5:
                    break
                other = explained(stage.system, s.columns)
                alike = _correlation(e, other)
                if alike > _ALIKE:
                    rivals.append((alike, s))
            # The same torque may be written on other joints: all compare beside the same misfit.
            among = sorted({*own.columns, *(j for _, s in rivals for j in s.columns)})
            again = self._doubted(stage, alone, among)
            rivals = [(alike, self._doubted(stage, s, among)) for alike, s in rivals]
            weight = softmax([odds_together(again, accepted), *(s.odds for _, s in rivals), 0.0])
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


def _odds(s: Score) -> float:
    return s.odds


def _present(effects: Iterable[Score], contacts: Sequence[Contact]) -> _Present:
    return frozenset(s.candidate.key for s in effects), len(contacts)


def _correlation(a: FloatArray, b: FloatArray) -> float:
    sizes = float(np.linalg.norm(a) * np.linalg.norm(b))
    return abs(float(np.sum(a * b))) / max(sizes, 1e-300)
