"""Which effects are there: the stepwise search, and what it found."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.diagnosis.baseline import Baseline, Seen
from symgen.diagnosis.effects import Candidate
from symgen.diagnosis.refine import refined
from symgen.diagnosis.select import GAIN, Score, judge, quick_gain
from symgen.diagnosis.whitened_system import Columns, WhitenedSystem

#: Name and joints of a candidate; gain, number and columns of one.
Key = tuple[str, tuple[int, ...]]
Ranked = tuple[float, int, Columns]
_ALIKE = 0.8
# Of the best gain: the simpler candidate is preferred, and parameters of the standard model.
_NEARLY, _PLAIN = 0.9, 0.75
_LEAVES = 3.0  # but it leaves at most this many times the square that the best one leaves
_MOST = 8  # effects, or more where joints have no friction: two of each joint, and two
_SINGLE = 0.001  # of what one test alone is made for
_REFINED = 6  # candidates whose constants are refined before they are judged


@dataclass(frozen=True, eq=False)
class Selection:
    """What the stepwise search found.

    Attributes:
        accepted: in the order of their share in closing the gap.
        rejected: the best of the others, with the reason.
        tried: number of candidates.
    """

    accepted: tuple[Score, ...]
    rejected: tuple[Score, ...] = ()
    tried: int = 0


@dataclass(frozen=True, eq=False)
class _Stage:
    """The system with some effects accepted, what gives columns then, and their names."""

    system: WhitenedSystem
    seen: Seen
    taken: frozenset[Key]


class Search:
    """A stepwise search among candidates.

    Args:
        baseline: the model as it is declared, and its logs.
        pool: the candidates.
        progress: is told what is being tried.
    """

    def __init__(
        self,
        baseline: Baseline,
        pool: Iterable[Candidate],
        progress: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.baseline, self.pool, self.progress = baseline, tuple(pool), progress
        self._fixed: dict[int, Columns] = {}

    def run(self) -> Selection:
        accepted = self._measured()
        alike: dict[Key, tuple[Score, ...]] = {}
        rejected: list[Score] = []
        seen: set[frozenset[Key]] = set()
        while len(accepted) < max(_MOST, 2 * self.baseline.robot.n + 2):
            self.progress(f"trying {len(self.pool)} candidates for effect {len(accepted) + 1}")
            # Members of one class do not stand beside each other: the data do not tell them apart.
            same = {s.candidate.key for group in alike.values() for s in group if _own(s)}
            stage = self._stage(accepted)
            passing, rejected = self._judged(stage, self._ranked(stage, same))
            if not passing:
                break
            best = self._simplest(passing)
            accepted.append(best)
            alike[best.candidate.key] = _class_of(best, passing, rejected)
            accepted = self._backward(accepted)
            chosen = frozenset(s.candidate.key for s in accepted)
            if chosen in seen:  # one displaces the other in turn: they are as good as each other
                break
            seen.add(chosen)
        accepted = self._swapped(accepted, alike)
        found = [replace(s, alike=alike.get(s.candidate.key, ())) for s in accepted]
        found.sort(key=lambda s: -s.gain)
        return Selection(tuple(found), tuple(rejected), len(self.pool))

    def _measured(self) -> list[Score]:
        """Return what a measurement of its own shows, where the torques have it: one test each."""
        out: list[Score] = []
        for i, candidate in enumerate(self.pool):
            if candidate.measured:
                stage = self._stage(out)
                score = judge(stage.system, candidate, self._columns(i, stage), 1)
                if score.p_value < _SINGLE:
                    out.append(replace(score, fault=""))
        return out

    def _stage(self, accepted: Sequence[Score]) -> _Stage:
        system = self.baseline.beside(accepted)
        taken = frozenset(s.candidate.key for s in accepted)
        return _Stage(system, self.baseline.seen(system), taken)

    def _columns(self, i: int, stage: _Stage) -> Columns:
        candidate = self.pool[i]
        if candidate.uses_model:
            return stage.seen(candidate)
        if i not in self._fixed:
            self._fixed[i] = stage.seen(candidate)
        return self._fixed[i]

    def on_joints(self, joints: tuple[int, ...]) -> Iterator[tuple[Candidate, Columns]]:
        """Yield every candidate on some joints with its columns beside the declared model."""
        stage = self._stage(())
        for i, candidate in enumerate(self.pool):
            if candidate.joints == joints:
                yield candidate, self._columns(i, stage)

    def _ranked(self, stage: _Stage, without: Container[Key]) -> list[Ranked]:
        """Return the best constants of every candidate, the largest gain first."""
        best: dict[Key, Ranked] = {}
        for i, candidate in enumerate(self.pool):
            if candidate.key in stage.taken and candidate.name not in _REPEATED:
                continue
            columns = self._columns(i, stage)
            gain = quick_gain(stage.system, columns)
            if gain > best.get(candidate.key, (0.0, 0, {}))[0]:
                best[candidate.key] = (gain, i, columns)
        ranked = (entry for key, entry in best.items() if key not in without)
        return sorted(ranked, key=lambda entry: -entry[0])

    def _judged(self, stage: _Stage, ranked: Sequence[Ranked]) -> tuple[list[Score], list[Score]]:
        """Judge the best candidates, the first of them with constants between the grid's."""
        passing: list[Score] = []
        failing: list[Score] = []
        for place, (gain, i, columns) in enumerate(ranked):
            if gain < GAIN / 4 and len(failing) >= 5:
                break
            if passing and gain < 0.25 * passing[0].gain:
                break
            candidate = self.pool[i]
            if place < _REFINED:
                candidate, columns = refined(
                    candidate,
                    [c.constants for c in self.pool if c.key == candidate.key],
                    stage.seen,
                    lambda c: quick_gain(stage.system, c),
                )
            score = judge(stage.system, candidate, columns, len(self.pool))
            (failing if score.fault else passing).append(score)
            if len(passing) + len(failing) >= 30:
                break
        return sorted(passing, key=lambda s: -s.gain), failing

    def _simplest(self, passing: Sequence[Score]) -> Score:
        """Return the plainest candidate among those that explain the same, nearly as well.

        The parameters of the standard friction model come before any other effect that looks like
        them; then the fewest numbers count. Where all parameters are given they are only changes,
        and have no more say than others.
        """
        enough = _NEARLY if self.baseline.given else _PLAIN
        best = passing[0]
        least = max(1 - best.gain, 0.0)
        near = [
            s
            for s in passing
            if s is best or (_alike(s, best) and 1 - s.gain <= _LEAVES * least + GAIN)
        ]
        plain = [s for s in near if s.candidate.definition.native and s.gain >= enough * best.gain]
        close = plain or [s for s in near if s.gain >= _NEARLY * best.gain]
        return min(close, key=lambda s: (s.candidate.complexity, -s.gain))

    def _swapped(self, accepted: list[Score], alike: dict[Key, tuple[Score, ...]]) -> list[Score]:
        """Choose each effect again among all on its joints, now that the others stand beside it."""
        for at in range(len(accepted) if len(accepted) > 1 else 0):
            rest, own = accepted[:at] + accepted[at + 1 :], accepted[at]
            if own.candidate.measured:
                continue
            joints = own.candidate.joints
            twins = (s for r in rest for s in alike.get(r.candidate.key, ()))
            same = {s.candidate.key for s in twins if _own(s)}
            stage = self._stage(rest)
            ranked = [r for r in self._ranked(stage, same) if self.pool[r[1]].joints == joints]
            passing, failing = self._judged(stage, ranked)
            if not passing:
                continue
            accepted[at] = best = self._simplest(passing)
            known = {s.candidate.key: s for s in (*alike.get(own.candidate.key, ()), *passing)}
            alike[best.candidate.key] = _class_of(best, known.values(), failing)
        return accepted

    def _backward(self, accepted: list[Score]) -> list[Score]:
        """Test every effect again beside all others; drop what no longer holds."""
        at = 0
        while len(accepted) > 1 and at < len(accepted):
            rest = accepted[:at] + accepted[at + 1 :]
            own = accepted[at]
            again = judge(self.baseline.beside(rest), own.candidate, own.columns, len(self.pool))
            if again.fault and not own.candidate.measured:
                accepted = rest
            else:
                accepted[at] = again
                at += 1
        return accepted


#: Effects of the measuring chain.
MEASURING = ("time_delay", "velocity_sensor_error", "saturation", "drive_gain_error")
_REPEATED = ("external_contact",)


def _own(score: Score) -> bool:
    """Whether an effect is no part of the standard model, whose parts stand beside each other."""
    return not score.candidate.definition.native


def _class_of(best: Score, passing: Iterable[Score], failing: Iterable[Score]) -> tuple[Score, ...]:
    """Return the other candidates that the data cannot tell from an accepted one.

    One that explains as much of the same belongs to them even where it fails a part of the rule:
    which of two equals passes is chance.
    """
    twins = (s for s in failing if s.gain >= _NEARLY * best.gain and _alike(s, best))
    others = {s.candidate.key: s for s in (*(s for s in passing if _alike(s, best)), *twins)}
    others.pop(best.candidate.key, None)
    return tuple(others.values())


def _alike(a: Score, b: Score) -> bool:
    """Whether two candidates explain the same part of the residual."""
    if a.explained is None or b.explained is None:
        return False
    sizes = float(np.linalg.norm(a.explained) * np.linalg.norm(b.explained))
    return abs(float(np.sum(a.explained * b.explained))) > _ALIKE * sizes
