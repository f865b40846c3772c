"""Friction of the standard model in place of an expression that says the same.

A joint whose file leaves its friction out misses several effects at once, none of which explains
much alone; a sparse expression takes them together. Where Coulomb friction, viscous friction and an
offset, or these and one effect of the library more, leave no more than it does, they are named.
"""

from __future__ import annotations

from collections.abc import Sequence

from symgen.diagnosis.candidates import Candidate
from symgen.diagnosis.refine import refined
from symgen.diagnosis.search import Search
from symgen.diagnosis.select import Score, judge, quick_gain
from symgen.diagnosis.whitened_system import Columns, WhitenedSystem

#: What is left on the joint, over what the expression leaves.
_ALIKE = 1.05
Entry = tuple[Candidate, Columns]


def friction_instead(
    search: Search, j: int, rest: Sequence[Score], expression: Score
) -> list[Score] | None:
    """Return effects on a joint that leave no more than an expression, or None.

    Args:
        search: with its candidates.
        j: position of the joint.
        rest: all other effects.
        expression: on the joint.
    """
    wanted = float(_with(search, [*rest, expression]).sigma[j])
    taken = {s.candidate.key for s in rest}
    own = [e for e in search.on_joints((j,)) if e[0].key not in taken]
    plain = [e for e in own if e[0].definition.native and not e[0].change]
    more = [e for e in own if not e[0].definition.native]
    found = _needed(search, rest, plain)
    if found and _left(search, rest, found, j) <= _ALIKE * wanted:
        return found
    beside = _with(search, [*rest, *found])
    if not more:
        return None
    best, _ = max(more, key=lambda entry: quick_gain(beside, entry[1]))
    best, columns = refined(
        best,
        [c.constants for c, _ in more if c.key == best.key],
        search.baseline.seen(search.baseline.base),
        lambda c: quick_gain(beside, c),
    )
    found = _needed(search, rest, [*plain, (best, columns)])
    return found if found and _left(search, rest, found, j) <= _ALIKE * wanted else None


def _with(search: Search, scores: Sequence[Score]) -> WhitenedSystem:
    return search.baseline.beside(scores)


def _left(search: Search, rest: Sequence[Score], found: Sequence[Score], j: int) -> float:
    return float(_with(search, [*rest, *found]).sigma[j])


def _needed(search: Search, rest: Sequence[Score], entries: Sequence[Entry]) -> list[Score]:
    """Return the effects that hold beside each other, without those that do not, least first."""
    tried, kept = len(search.pool), list(entries)
    while kept:
        scores = []
        for candidate, columns in kept:
            beside = [c for other, c in kept if other is not candidate]
            evidence = _with(search, rest).with_columns(beside)
            scores.append(judge(evidence, candidate, columns, tried))
        failing = [(s.gain, k) for k, s in enumerate(scores) if s.fault]
        if not failing:
            return scores
        del kept[min(failing)[1]]
    return []
