"""The registry of hypotheses, and the result of a search."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

from symgen import names
from symgen.hypotheses.changes import Changed
from symgen.hypotheses.effects import Candidate, Score, candidates
from symgen.hypotheses.event import NAME as CONTACT
from symgen.hypotheses.event import Contact
from symgen.hypotheses.judged import Judged
from symgen.hypotheses.model_based_effects import special_candidates
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.score import Key
from symgen.hypotheses.stiffness import stiffnesses
from symgen.hypotheses.terms import NAME as UNNAMED
from symgen.robot.types import Robot


@dataclass(frozen=True, eq=False)
class Registry:
    """The hypotheses of a search.

    Attributes:
        pool: candidates with columns, one for each point of their grids.
        changes: whether to try changes of all logs.
        contacts: whether to try contacts.
        expressions: whether to try unnamed expressions.
    """

    pool: tuple[Candidate, ...]
    changes: bool = True
    contacts: bool = True
    expressions: bool = True

    def ranges(self, candidate: Candidate) -> dict[str, tuple[float, float]]:
        """Return the range of each constant of an effect: its grid, and one more step at both ends.

        A constant with one value has no range.
        """
        out = {}
        same = [c.constants for c in self.pool if c.key == candidate.key]
        for name in candidate.constants:
            grid = sorted({constants[name] for constants in same})
            search = candidate.definition.nonlinear.get(name)
            if len(grid) > 1 and search is not None:
                ends = (grid[0], grid[1]), (grid[-1], grid[-2])
                low, high = (_beyond(*end, by_ratio=search.by_ratio) for end in ends)
                out[name] = low, high
        return out

    @cached_property
    def friction(self) -> list[Candidate]:
        """Undeclared friction, which other effects may require."""
        return [c for c in self.pool if c.definition.native in names.FRICTION and not c.alters]


def _beyond(end: float, inner: float, *, by_ratio: bool) -> float:
    """Return the next value after the end of a grid."""
    return end**2 / inner if by_ratio else 2 * end - inner


def make_registry(
    problem: Problem, robot: Robot | None = None, chosen: Sequence[str] | None = None
) -> Registry:
    """Return the hypotheses of a problem.

    Args:
        problem: the model and its logs.
        robot: the robot whose file has the ranges of constants; None for that of the model.
        chosen: names of effects to try; None for all.
    """
    source, fixed = robot or problem.robot, problem.is_fixed
    pool, terms = _pool(problem, source), not (fixed or problem.hides)
    if chosen is None:
        return Registry(pool, expressions=terms)
    tried = tuple(c for c in pool if c.name in chosen)
    return Registry(tried, False, CONTACT in chosen, UNNAMED in chosen and terms)


def _pool(problem: Problem, robot: Robot) -> tuple[Candidate, ...]:
    """Return the candidates with columns.

    On a floating base, those are left out that need the model of the links, and those of which
    there are very many. Where forces at contacts are unknown, so is the torque of the joints.
    """
    fixed = problem.is_fixed
    library = candidates(robot, problem.logs, fixed=fixed)
    if robot.floating:
        usual = (c for c in library if not c.rare)
        return tuple(c for c in usual if not (c.uses_model and problem.hides))
    bent = stiffnesses(problem.base)
    return *library, *special_candidates(robot, bent, fixed=fixed, logs=problem.logs)


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The result of a search.

    Attributes:
        declared: the problem with the logs as read.
        problem: the problem with changes undone and the samples of contacts masked.
        items: the accepted hypotheses. The columns of effects are those on the logs of `problem`.
        rejected: the other effects with the reason, the most probable first.
        tried: number of candidates.
        ranges: the range of each searched constant, by the key of its effect.
        held_contacts: contacts in the validation logs, which no other motion confirms.
    """

    declared: Problem
    problem: Problem
    items: tuple[Judged, ...] = ()
    rejected: tuple[Score, ...] = ()
    tried: int = 0
    ranges: Mapping[Key, Mapping[str, tuple[float, float]]] = field(default_factory=dict)
    held_contacts: tuple[Contact, ...] = ()

    @property
    def effects(self) -> tuple[Score, ...]:
        """Accepted effects with columns."""
        return tuple(x for x in self.items if isinstance(x, Score))

    @property
    def changes(self) -> tuple[Changed, ...]:
        """Accepted changes of all logs."""
        return tuple(x for x in self.items if isinstance(x, Changed))

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Accepted contacts."""
        return tuple(x for x in self.items if isinstance(x, Contact))

    @property
    def keys(self) -> frozenset[Key]:
        """Keys of all accepted hypotheses."""
        return frozenset(x.key for x in self.items)

    def with_effects(self, effects: Iterable[Score]) -> SearchResult:
        """Return the result with other effects."""
        return replace(self, items=(*self.changes, *self.contacts, *effects))

    def with_items(self, items: Iterable[Judged]) -> SearchResult:
        """Return the result with other items, and with logs that are corrected by them."""
        other = replace(self, items=tuple(items))
        if (other.changes, other.contacts) == (self.changes, self.contacts):
            return other
        problem = self.declared
        for change in other.changes:
            problem = problem.corrected(change.cause)
        problem = problem.without(other.contacts)
        return replace(other, problem=problem).with_effects(columns_in(problem, other.effects))


Kind = TypeVar("Kind", bound=Judged)


def leave_out(items: Iterable[Kind], item: Judged) -> list[Kind]:
    """Return the items without one of them and without those that require it."""
    rest = [x for x in items if x is not item]
    return [x for x in rest if not x.cause.presumes(item.cause)]


def columns_in(problem: Problem, effects: Sequence[Score]) -> tuple[Score, ...]:
    """Return effects with their columns on the logs of a problem."""
    if not effects:
        return ()
    columns = problem.stage().log_columns.each(s.cause for s in effects)
    return tuple(replace(s, columns=c) for s, c in zip(effects, columns, strict=True))
