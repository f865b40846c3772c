"""Effects without a name: sparse expressions in the variables on which a residual depends.

    torque on joint j = UA term_1 + UB term_2 + UC term_3

The terms are expressions in the positions and speeds of all joints, in the grammar of effects:
powers, sines and absolute values, products of two, and bumps exp(-((q - c)/w)**2) and their slopes.
Centre c and width w are searched on a grid. Each term competes by the score of effects
(`symgen.diagnosis.search`), with a penalty for the number of terms that were tried.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symgen import names
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import Candidate, Constants, Torques
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.rows import Rows, in_band
from symgen.hypotheses.score import Columns
from symgen.robot.effect import Search as Range
from symgen.robot.effect import definitions, unit
from symgen.robot.types import Robot

NAME = "unnamed"
_BEST = 12  # number of terms of a joint that are scored
_FREE = 0.05
_CENTRES, _WIDTHS = 15, (0.1, 0.15, 0.22, 0.33, 0.5, 0.75)  # of half the joint's range
#: Range in which the model's columns are proved to be independent; no bump lies outside.
_REACH = {names.REVOLUTE: 3.0, names.PRISMATIC: 1.0}

_FUNCTIONS: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "{0}": lambda x: x,
    "{0}**2": lambda x: x**2,
    "{0}**3": lambda x: x**3,
    "sin({0})": np.sin,
    "cos({0})": np.cos,
    "sin(2*{0})": lambda x: np.sin(2 * x),
    "cos(2*{0})": lambda x: np.cos(2 * x),
    "abs({0})": np.abs,
    "{0}*abs({0})": lambda x: x * np.abs(x),
    "sign({0})": np.sign,
}
_POSITION = tuple(text for text in _FUNCTIONS if "abs" not in text and "sign" not in text)
_SPEED = ("{0}", "abs({0})", "{0}**2", "{0}*abs({0})", "sign({0})")
#: Products of two positions have the third degree at most, as powers have.
_POWERS = ("{0}", "{0}"), ("{0}**2", "{0}"), ("{0}", "{0}**2")
#: Functions of a position before a function of a speed; products of two positions.
_MIXED = ("{0}", "{0}**2", "sin({0})", "cos({0})"), ("{0}", "abs({0})", "sign({0})")
_WAVES = ("sin({0})", "cos({0})")
_BUMPS: Mapping[str, Callable[[FloatArray, float, float], FloatArray]] = {
    "exp(-(({q} - {c})/{w})**2)": lambda q, c, w: np.exp(-(((q - c) / w) ** 2)),
    "({q} - {c})*exp(-(({q} - {c})/{w})**2)": lambda q, c, w: (
        (q - c) * np.exp(-(((q - c) / w) ** 2))
    ),
}
#: A function of the position (q) or the speed (qd) of a joint: text, letter, index of the joint.
Factor = tuple[str, int, str]


@dataclass(frozen=True, eq=False)
class Term:
    """One term of the library.

    Attributes:
        text: expression in the variables q1, qd1, ...; {c} and {w} stand for the constants.
        values: gives the term along a log, (N,), from its constants.
        dimension: its unit.
        constants: centre and width of a bump.
    """

    text: str
    values: Callable[..., FloatArray]
    dimension: str
    constants: Mapping[str, float] = field(default_factory=dict)

    @property
    def analytic(self) -> bool:
        """Whether it is a smooth function of the motion."""
        return "abs" not in self.text and "sign" not in self.text

    def along(self, log: FilteredLog) -> FloatArray:
        """Return the term along a log, (N,)."""
        return self.values(log, **self.constants)


def library(robot: Robot, logs: Sequence[FilteredLog]) -> list[Term]:
    """Return all terms in positions and speeds of a robot's joints, with bumps on their grid."""
    return [*(_product(robot, *factors) for factors in _factors(robot.n)), *_bumps(robot, logs)]


def _factors(n: int) -> Iterator[tuple[Factor, ...]]:
    """Yield the factors of each term that is not a bump."""
    for letter, functions in (("q", _POSITION), ("qd", _SPEED)):
        for k, text in itertools.product(range(n), functions):
            yield ((letter, k, text),)
    for j, k in itertools.product(range(n), range(n)):
        for first, second in itertools.product(*_MIXED):
            yield ("q", j, first), ("qd", k, second)
    for j, k in itertools.combinations(range(n), 2):
        for first, second in _POWERS:
            yield ("q", j, first), ("q", k, second)
        yield ("qd", j, "{0}"), ("qd", k, "{0}")
        for first, second in itertools.product(_WAVES, repeat=2):
            yield ("q", j, first), ("q", k, second)


def _product(robot: Robot, *factors: Factor) -> Term:
    """Return the product of some functions."""

    def values(log: FilteredLog) -> FloatArray:
        parts = (_FUNCTIONS[text](getattr(log, key)[:, k]) for key, k, text in factors)
        return math.prod(parts, start=np.ones(len(log.t)))

    texts, dimension = [], []
    for letter, k, text in factors:
        joint = robot.movable[k]
        texts.append(text.format(f"{letter}{joint.number}"))
        power = int(text[-1]) if "**" in text else 2 if "*abs" in text else 1
        if "(" not in text or "abs" in text:
            own = unit("position" if letter == "q" else "speed", joint.sigma)
            dimension += [own] * power
    return Term("*".join(texts), values, " ".join(dimension))


def _bumps(robot: Robot, logs: Sequence[FilteredLog]) -> Iterator[Term]:
    for k, joint in enumerate(robot.movable):
        q = np.concatenate([log.q[log.kept, k] for log in logs])
        low, high = float(q.min()), float(q.max())
        for (text, own), c in itertools.product(_BUMPS.items(), np.linspace(low, high, _CENTRES)):
            shape, dimension = partial(_bump, own, k), unit("position", joint.sigma)
            for w in _WIDTHS if high > low and abs(c) < _REACH[joint.sigma] else ():
                yield Term(
                    text.replace("{q}", f"q{joint.number}"),
                    shape,
                    dimension if text.startswith("(") else "",
                    {"c": float(c), "w": w * (high - low) / 2},
                )


def _bump(
    own: Callable[[FloatArray, float, float], FloatArray],
    k: int,
    log: FilteredLog,
    c: float,
    w: float,
) -> FloatArray:
    return own(log.q[:, k], c, w)


@dataclass(frozen=True, eq=False)
class _Sum:
    """Gives the columns of some terms on one joint; their constants come one after the other."""

    position: int
    terms: Sequence[Term]

    def __call__(self, log: FilteredLog, _: Torques, constants: Constants) -> Columns:
        columns = [term.along(log) for term in self.at(constants)]
        return {self.position: -np.stack(columns, axis=1)}

    def at(self, constants: Constants) -> list[Term]:
        """Return the terms with other values of their constants."""
        values = iter(constants.values())
        return [
            replace(t, constants={key: next(values) for key in t.constants}) for t in self.terms
        ]


def expression(robot: Robot, position: int, terms: Sequence[Term]) -> Candidate:
    """Return the sum of some terms on one joint as a candidate."""
    joint = robot.movable[position]
    declared = (*robot.effects, *(s.effect for s in robot.sought))
    taken = {name for e in declared for name in e.names}
    free = [x for x in "ABCDEFGHIJKLMNOPQRSTUVWXYZ" if f"U{x}{joint.number}" not in taken]
    torque, linear, constants = [], {}, {}
    force = unit("torque", joint.sigma)
    for letter, term in zip((f"{x}{joint.number}" for x in free), terms, strict=False):
        own = {key: f"U{key}{letter}" for key in term.constants}
        torque.append(f"U{letter}*{term.text.format(**own)}")
        over = term.dimension if len(term.dimension.split()) < 2 else f"({term.dimension})"
        linear[f"U{letter}"] = f"{force}/{over}" if over else force
        constants.update({own[key]: value for key, value in term.constants.items()})
    definition = replace(
        definitions()[NAME],
        torque=" + ".join(torque),
        linear=linear,
        nonlinear={name: Range(value, value, 1) for name, value in constants.items()},
        own=True,
    )

    return Candidate(definition, (position,), _Sum(position, terms), len(terms), constants)


def _seen(terms: Sequence[Term], logs: Sequence[FilteredLog]) -> FloatArray:
    """Return minus the terms, in the band, at the kept samples of all logs, (K, T)."""
    out = np.empty((sum(len(log.kept) for log in logs), len(terms)))
    for analytic in (True, False):
        at = [i for i, term in enumerate(terms) if term.analytic == analytic]
        strides = [log.smooth_stride if analytic else log.rows.stride for log in logs]
        thin = [log.every(k) for log, k in zip(logs, strides, strict=True)]

        def columns(i: int, k: int, thin: Sequence[FilteredLog] = thin) -> Columns:
            return {0: -terms[i].along(thin[k])[:, None]}

        for i, found in zip(at, in_band(logs, at, columns, strides), strict=True):
            out[:, i] = found[0][:, 0]
    return out


def _gains(system: Rows, j: int, columns: FloatArray, squares: FloatArray) -> FloatArray:
    """Return the share of joint j's sum of squares that each column (K, T) explains, (T,).

    `squares` (K, T) are those of the values of the columns.
    """
    weight = system.moves[:, j] / system.sigma[j]
    whole = weight**2 @ squares
    residual = system.residual[:, j]
    own = (np.column_stack([system.basis[:, j], residual]) * weight[:, None]).T @ columns
    left = whole - np.sum(own[:-1] ** 2, axis=0)
    free = left > _FREE**2 * whole
    size = float(np.sum(residual**2)) or 1.0
    out = own[-1] ** 2 / np.where(free, left, np.inf) / size
    return np.asarray(np.where(np.isfinite(out), out, 0.0))


class Expressions:
    """The terms that can be added to a joint, one after the other, as an effect without a name.

    Args:
        baseline: the declared model.
    """

    def __init__(self, baseline: Problem) -> None:
        self.robot, self.logs = baseline.robot, baseline.logs
        self.terms = library(self.robot, self.logs)
        self.columns = _seen(self.terms, self.logs)
        self._squares = self.columns**2

    @property
    def count(self) -> int:
        """Number of terms; the prior odds are divided by it."""
        return len(self.terms)

    def best(
        self, system: Rows, joints: frozenset[int] | None
    ) -> Iterator[tuple[Candidate, Columns]]:
        """Yield the few terms of each joint that explain most of its residual."""
        for j in range(system.n) if joints is None else sorted(joints):
            gains = _gains(system, j, self.columns, self._squares)
            for i in np.argsort(-gains, kind="stable")[:_BEST]:
                term = self.terms[i]
                yield expression(self.robot, j, (term,)), {j: self.columns[:, [i]]}

    def merged(self, parts: Iterable[Candidate]) -> list[tuple[Candidate, Columns]]:
        """Return the terms on each joint as one expression."""
        by_joint: dict[int, list[Term]] = {}
        for c in parts:
            assert isinstance(c.torque, _Sum)
            by_joint.setdefault(c.torque.position, []).extend(c.torque.at(c.constants))
        return [
            (expression(self.robot, j, terms), {j: _seen(terms, self.logs)})
            for j, terms in by_joint.items()
        ]
