"""The registry of hypotheses, and what a search finds among them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from symgen import names
from symgen.hypotheses.changes import Change
from symgen.hypotheses.effects import Candidate, Score, candidates
from symgen.hypotheses.event import NAME as CONTACT
from symgen.hypotheses.event import Contact
from symgen.hypotheses.model_based_effects import special_candidates
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.stiffness import stiffnesses
from symgen.hypotheses.terms import NAME as UNNAMED
from symgen.robot.types import Robot

#: Name and joints of a hypothesis.
Key = tuple[str, tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Registry:
    """The hypotheses of a search.

    Attributes:
        pool: candidates with columns, one for each point of their grids.
        changes: whether changes of all logs are tried.
        contacts: whether contacts are tried.
        expressions: whether expressions without a name are tried.
    """

    pool: tuple[Candidate, ...]
    changes: bool = True
    contacts: bool = True
    expressions: bool = True

    @cached_property
    def friction(self) -> list[Candidate]:
        """Friction that is not declared; other effects may require it."""
        return [c for c in self.pool if c.definition.native in names.FRICTION and not c.change]


def make_registry(
    problem: Problem, robot: Robot | None = None, chosen: Sequence[str] | None = None
) -> Registry:
    """Return the hypotheses of a problem.

    Args:
        problem: the model and its logs.
        robot: with the ranges of constants of its file; None for that of the model.
        chosen: names of effects to try; None for all.
    """
    source, given = robot or problem.robot, problem.given
    bent = stiffnesses(problem.base)
    pool = (
        *candidates(source, problem.logs, chosen, given=given),
        *special_candidates(source, bent, chosen, given=given, logs=problem.logs),
    )
    every = chosen is None
    expressions = not given and (chosen is None or UNNAMED in chosen)
    return Registry(pool, every, chosen is None or CONTACT in chosen, expressions)


@dataclass(frozen=True, eq=False)
class Changed:
    """A change of all logs beside a model.

    Attributes:
        change: what is undone.
        odds: log-odds, marginalised over its grid.
        worth: reduction of the held-out error as a part of a joint's torque, from squares.
        gain: share of the held-out sum of squares that it explains.
    """

    change: Change
    odds: float
    worth: float
    gain: float

    @property
    def key(self) -> Key:
        """Name and joints."""
        return self.change.key


@dataclass(frozen=True, eq=False)
class Found:
    """What a search accepts.

    Attributes:
        declared: the problem of the logs as they were.
        problem: the problem with changes undone and without the samples of contacts.
        effects: effects with columns, the largest share in closing the gap first.
        changes: changes of all logs.
        contacts: contacts.
        rejected: the other effects, the most probable first, with the reason.
        tried: number of candidates.
    """

    declared: Problem
    problem: Problem
    effects: tuple[Score, ...] = ()
    changes: tuple[Changed, ...] = ()
    contacts: tuple[Contact, ...] = ()
    rejected: tuple[Score, ...] = ()
    tried: int = 0

    @property
    def keys(self) -> frozenset[Key]:
        """Name and joints of all that is accepted; contacts with their times."""
        spans = ((CONTACT, (c.span.first, c.span.last)) for c in self.contacts)
        effects = (s.candidate.key for s in self.effects)
        return frozenset((*effects, *(c.key for c in self.changes), *spans))


def rebuilt(found: Found) -> Found:
    """Return what is found with its changes undone and its contacts left out of the first logs."""
    problem = found.declared
    for c in found.changes:
        problem = problem.changed(c.change)
    problem = problem.without(found.contacts)
    return replace(found, problem=problem, effects=columns_in(problem, found.effects))


def columns_in(problem: Problem, effects: Sequence[Score]) -> tuple[Score, ...]:
    """Return effects with their columns on the logs of a problem."""
    if not effects:
        return ()
    seen = problem.seen(problem.base)
    columns = seen.each(s.candidate for s in effects)
    return tuple(replace(s, columns=c) for s, c in zip(effects, columns, strict=True))
