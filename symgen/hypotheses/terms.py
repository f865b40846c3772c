"""Unnamed effects: products of functions of positions and speeds.

    torque on joint j = U12Jj term_12,    term_12 = q1*q3**2, for example

Torques near an angle are no such product, so they have a table in effects.toml. Each term has the
score of an effect, with a penalty for the number of terms that are tried.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import Candidate, Constants, Torques
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.rows import FittedRows
from symgen.hypotheses.score import Columns
from symgen.robot.effect import definitions, effect_unit
from symgen.robot.types import Robot

NAME = "unnamed"
_BEST = 12  # number of terms of a joint that are scored
_FREE = 0.05  # a scored term has at least this part of its norm orthogonal to the model


class _Function(NamedTuple):
    """A function of a position or a speed, and its degree in the unit of its argument."""

    values: Callable[[FloatArray], FloatArray]
    degree: int


_FUNCTIONS: Mapping[str, _Function] = {
    "{0}": _Function(lambda x: x, 1),
    "{0}**2": _Function(np.square, 2),
    "{0}**3": _Function(lambda x: x**3, 3),
    "sin({0})": _Function(np.sin, 0),
    "cos({0})": _Function(np.cos, 0),
    "sin(2*{0})": _Function(lambda x: np.sin(2 * x), 0),
    "cos(2*{0})": _Function(lambda x: np.cos(2 * x), 0),
    "abs({0})": _Function(np.abs, 1),
    "{0}*abs({0})": _Function(lambda x: x * np.abs(x), 2),
    "sign({0})": _Function(np.sign, 0),
}
#: Functions with a step, in the value or in the slope.
_BENT = ("abs({0})", "{0}*abs({0})", "sign({0})")
_POSITION = tuple(text for text in _FUNCTIONS if text not in _BENT)
_SPEED = ("{0}", "{0}**2", *_BENT)
#: Functions of a position, and functions of a speed, for their products.
_MIXED = ("{0}", "{0}**2", "sin({0})", "cos({0})"), ("{0}", "abs({0})", "sign({0})")
#: Products of functions of two positions.
_PAIRS = (
    *(("{0}", "{0}"), ("{0}**2", "{0}"), ("{0}", "{0}**2")),
    *itertools.product(("sin({0})", "cos({0})"), repeat=2),
)


class Factor(NamedTuple):
    """A function of the positions (q) or the speeds (qd) of a joint, by its index."""

    letter: str
    joint: int
    function: str


Term = tuple[Factor, ...]


def all_terms(n: int) -> Iterator[Term]:
    """Yield all terms in the positions and speeds of n joints."""
    for letter, functions in (("q", _POSITION), ("qd", _SPEED)):
        for k, function in itertools.product(range(n), functions):
            yield (Factor(letter, k, function),)
    for j, k in itertools.product(range(n), repeat=2):
        for first, second in itertools.product(*_MIXED):
            yield Factor("q", j, first), Factor("qd", k, second)
    for j, k in itertools.combinations(range(n), 2):
        for first, second in _PAIRS:
            yield Factor("q", j, first), Factor("q", k, second)
        yield Factor("qd", j, "{0}"), Factor("qd", k, "{0}")


def _columns(term: Term, position: int, log: FilteredLog, _: Torques, __: Constants) -> Columns:
    """Return minus the values of a term along a log, as the column of a joint."""
    product = -np.ones(len(log.t))
    for factor in term:
        variable = log.q if factor.letter == "q" else log.qd
        product = product * _FUNCTIONS[factor.function].values(variable[:, factor.joint])
    return {position: product[:, None]}


def expression(robot: Robot, position: int, number: int, term: Term) -> Candidate:
    """Return a term on one joint, with its number among the terms, as a candidate."""
    texts = []
    dimension = []
    for factor in term:
        joint = robot.movable[factor.joint]
        texts.append(factor.function.format(f"{factor.letter}{joint.number}"))
        kind = effect_unit("position" if factor.letter == "q" else "speed", joint.sigma)
        dimension += [kind] * _FUNCTIONS[factor.function].degree
    joint = robot.movable[position]
    coefficient = f"U{number}J{joint.number}"
    force = effect_unit("torque", joint.sigma)
    per = f"({' '.join(dimension)})" if len(dimension) > 1 else "".join(dimension)
    definition = replace(
        definitions()[NAME],
        torque="*".join([coefficient, *texts]),
        linear={coefficient: f"{force}/{per}" if per else force},
        nonlinear={},
        own=True,
    )
    smooth = all(factor.function not in _BENT for factor in term)
    torque = partial(_columns, term, position)
    return Candidate(definition, (position,), torque, 1, analytic=smooth)


@dataclass(frozen=True, eq=False)
class Expressions:
    """The terms that a search can add to a joint as unnamed effects.

    Attributes:
        robot: the declared robot.
        terms: all terms.
        columns: (K, T) columns of the terms in the band, at the kept samples of all logs.
    """

    robot: Robot
    terms: tuple[Term, ...]
    columns: FloatArray

    @property
    def count(self) -> int:
        """Number of unnamed effects on a joint, which divides the prior odds."""
        local = definitions()[NAME].nonlinear.values()
        return len(self.terms) + int(np.prod([search.count for search in local]))

    def best(
        self, system: FittedRows, joints: frozenset[int] | None
    ) -> Iterator[tuple[Candidate, Columns]]:
        """Yield the terms of each joint that explain most of its residual.

        Args:
            system: the equations of the model with the accepted effects.
            joints: indices of the joints; None for all.
        """
        for j in range(self.robot.n) if joints is None else sorted(joints):
            (row,) = self.robot.rows([j])
            for i in np.argsort(-self._gains(system, row), kind="stable")[:_BEST]:
                candidate = expression(self.robot, j, int(i), self.terms[i])
                yield candidate, {row: self.columns[:, [i]]}

    def _gains(self, system: FittedRows, j: int) -> FloatArray:
        """Return the part of equation j's sum of squares that each term explains, (T,)."""
        rows = self.columns * (system.weight[:, j] / system.sigma[j])[:, None]
        squares = np.sum(rows**2, axis=0)
        free = squares - np.sum((system.basis[:, j].T @ rows) ** 2, axis=0)
        along = system.whitened_residual[:, j] @ rows
        scored = free > _FREE**2 * squares
        return np.where(scored, along**2 / np.where(scored, free, 1.0), 0.0)


def expressions(baseline: Problem) -> Expressions:
    """Return the terms along the training logs of a declared model."""
    robot = baseline.robot
    terms = tuple(all_terms(robot.n))
    candidates = [expression(robot, 0, i, term) for i, term in enumerate(terms)]
    of_first = baseline.stage().log_columns.each(candidates)
    columns = [column for by_row in of_first for column in by_row.values()]
    return Expressions(robot, terms, np.concatenate(columns, axis=1))
