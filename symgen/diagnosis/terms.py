"""What no name fits: a sparse expression in the variables that a joint's residual depends on.

    torque on joint j = UA term_1 + UB term_2 + UC term_3

The terms are texts of the effects' grammar in the positions and speeds of all joints: powers, sines
and absolute values, products of two, and bumps exp(-((q - c)/w)**2) and their slopes, whose centre
c and width w are searched on a grid and refined. One is taken after the other, each by the strict
rule of `symgen.diagnosis.select` with every term that was looked at counted; named effects that
the expression makes needless are dropped. A sum that leaves most of the residual is not reported.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.effects import Candidate, Constants, Torques
from symgen.diagnosis.refine import refined
from symgen.diagnosis.search import Search, Selection
from symgen.diagnosis.select import Score, judge, quick_gain
from symgen.diagnosis.whitened_system import Columns, WhitenedSystem, compared
from symgen.estimation.filtered_log import FilteredLog
from symgen.robot.effect import Search as Range
from symgen.robot.effect import definitions, unit
from symgen.robot.types import Robot

FloatArray = NDArray[np.float64]
NAME = "unnamed"
_MOST = 3  # terms on one joint
_STRUCTURED = 3.0  # residual over noise below which a joint is left alone
_LEFT = 0.3  # of the residual's square after the named search that an expression may leave
_NUMBER = 1.2  # the residual that one more number has to be worth
_FREE = 0.05
_CENTRES, _WIDTHS = 15, (0.1, 0.15, 0.22, 0.33, 0.5, 0.75)  # of half the joint's range
_HALVINGS, _STARTS = 7, 6  # of the refinement of bumps
_CHUNK = 64
#: Where the model's columns are proved to be independent: no bump may lie beyond.
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
_POSITION = tuple(_FUNCTIONS)[:7]
_SPEED = ("{0}", "abs({0})", "{0}**2", "{0}*abs({0})", "sign({0})")
#: Factors of a position before a factor of a speed; products of two positions.
_MIXED = ("{0}", "{0}**2", "sin({0})", "cos({0})"), ("{0}", "abs({0})", "sign({0})")
_WAVES = ("sin({0})", "cos({0})")
_BUMPS: Mapping[str, Callable[[FloatArray, float, float], FloatArray]] = {
    "exp(-(({q} - {c})/{w})**2)": lambda q, c, w: np.exp(-(((q - c) / w) ** 2)),
    "({q} - {c})*exp(-(({q} - {c})/{w})**2)": lambda q, c, w: (
        (q - c) * np.exp(-(((q - c) / w) ** 2))
    ),
}
#: A function of the position (q) or the speed (qd) of a joint: text, letter, place of the joint.
Factor = tuple[str, int, str]


@dataclass(frozen=True, eq=False)
class Term:
    """One term of the library.

    Attributes:
        text: in the variables q1, qd1, ...; {c} and {w} stand for the names of constants.
        values: gives it at full rate, (N,), by its constants.
        dimension: its unit.
        constants: centre and width of a bump.
    """

    text: str
    values: Callable[..., FloatArray]
    dimension: str
    constants: Mapping[str, float] = field(default_factory=dict)

    def along(self, log: FilteredLog) -> FloatArray:
        """Return the term along a log at full rate, (N,)."""
        return self.values(log, **self.constants)


def library(robot: Robot, logs: Sequence[FilteredLog]) -> list[Term]:
    """Return every term in the positions and speeds of a robot's joints, bumps on their grid."""
    return [*(_product(robot, *factors) for factors in _factors(robot.n)), *_bumps(robot, logs)]


def _factors(n: int) -> Iterator[tuple[Factor, ...]]:
    """Yield the factors of each term that is no bump."""
    for letter, functions in (("q", _POSITION), ("qd", _SPEED)):
        for k, text in itertools.product(range(n), functions):
            yield ((letter, k, text),)
    for j, k in itertools.product(range(n), range(n)):
        for first, second in itertools.product(*_MIXED):
            yield ("q", j, first), ("qd", k, second)
    for j, k in itertools.combinations(range(n), 2):
        yield ("q", j, "{0}"), ("q", k, "{0}")
        yield ("qd", j, "{0}"), ("qd", k, "{0}")
        for first, second in itertools.product(_WAVES, repeat=2):
            yield ("q", j, first), ("q", k, second)


def _product(robot: Robot, *factors: Factor) -> Term:
    """Return a product of functions."""

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

    def columns(s: FilteredLog, _: Torques, __: Constants) -> Columns:
        return {position: -np.stack([t.along(s) for t in terms], axis=1)}

    return Candidate(definition, (position,), columns, len(terms), constants, refinable=False)


def _seen(terms: Sequence[Term], scenes: Sequence[FilteredLog]) -> FloatArray:
    """Return minus the terms in the band at the kept instants of all logs, (K, T)."""
    out = []
    for s in scenes:
        parts = [
            compared(s, np.stack([t.along(s) for t in terms[i : i + _CHUNK]], axis=1))
            for i in range(0, len(terms), _CHUNK)
        ]
        out.append(np.concatenate(parts, axis=1))
    return -np.concatenate(out)


def _gains(system: WhitenedSystem, j: int, columns: FloatArray) -> FloatArray:
    """Return the share of a joint's sum of squares that each column (K, T) explains, (T,)."""
    C = columns * (system.moves[:, j] / system.sigma[j])[:, None]
    whole = np.sum(C**2, axis=0)
    left = whole - np.sum((system.basis[:, j].T @ C) ** 2, axis=0)
    free = left > _FREE**2 * whole
    size = float(np.sum(system.residual[:, j] ** 2)) or 1.0
    out = (C.T @ system.residual[:, j]) ** 2 / np.where(free, left, np.inf) / size
    return np.asarray(np.where(np.isfinite(out), out, 0.0))


def _short(value: float) -> float:
    return float(f"{value:.6g}")


class _Finder:
    """The search for an expression on a joint.

    Args:
        baseline: the model as it is declared.
        terms: the library.
        columns: of its terms, (K, T).
        tried: number of candidates, every term on every joint among them.
        noise: standard deviation of the joint's torque noise in the band.
        j: position of the joint.
    """

    def __init__(
        self,
        baseline: Baseline,
        terms: Sequence[Term],
        columns: FloatArray,
        tried: int,
        noise: float,
        j: int,
    ) -> None:
        self.robot, self.logs, self.system = baseline.robot, baseline.base.logs, baseline.beside
        self.terms, self.columns, self.tried, self.j = terms, columns, tried, j
        self.quiet = _STRUCTURED * max(noise, 1e-6 * float(np.std(baseline.base.y)))

    def structured(self, system: WhitenedSystem) -> bool:
        """Whether more than noise is left."""
        return float(system.sigma[self.j]) >= self.quiet

    def scored(self, beside: Sequence[Score], terms: Sequence[Term]) -> Score:
        """Judge the sum of some terms beside some effects."""
        columns = {self.j: _seen(terms, self.logs)}
        candidate = expression(self.robot, self.j, terms)
        return judge(self.system(beside), candidate, columns, self.tried)

    def instead(self, named: Sequence[Score]) -> list[Score] | None:
        """Return the effects with an expression; None where named ones do as well.

        It is looked for beside all that is named, and in place of the joint's own effects: first
        of those outside the standard model of friction, then of all. It has to do better than any
        member of the classes of these, too.
        """
        own = [s for s in named if s.candidate.joints == (self.j,)]
        odd = [s for s in own if not s.candidate.definition.native]
        others = [
            [other if s is mine else s for s in named] for mine in own for other in mine.alike
        ]
        best, least = None, _LEFT * min(map(self._cost, (named, *others)))
        for away in ([], *([odd] if odd else []), *([own] if own != odd else [])):
            whole = self._beside([s for s in named if s not in away])
            cost = np.inf if whole is None else self._cost(whole)
            if cost < least:
                best, least = whole, cost
        return best

    def _cost(self, accepted: Sequence[Score]) -> float:
        """Return the square of the joint's residual, its effects' numbers weighed in."""
        own = (s.candidate for s in accepted if s.candidate.joints == (self.j,))
        square = float(self.system(accepted).sigma[self.j] ** 2)
        return square * _NUMBER ** sum(c.complexity for c in own)

    def _beside(self, named: list[Score]) -> list[Score] | None:
        """Return the named effects that stay and an expression; None where there is none."""
        terms: list[Term] = []
        whole = named
        while len(terms) < _MOST and self.structured(here := self.system(whole)):
            new = self._best(here)
            if self.scored(whole, [new]).fault:
                break
            terms = self._settled(named, [*terms, new])
            found = self.scored(named, terms)
            # Named effects of the joint that the expression makes needless go.
            for own in [s for s in named if s.candidate.joints == (self.j,)]:
                rest = [s for s in named if s is not own]
                beside = self.system([*rest, found])
                if judge(beside, own.candidate, own.columns, self.tried).fault:
                    terms = self._settled(rest, terms)
                    named, found = rest, self.scored(rest, terms)
            if found.fault:
                return None
            whole = [*named, found]
        return whole if terms else None

    def _best(self, system: WhitenedSystem) -> Term:
        """Return the term that leaves least, a bump's two numbers weighed in."""
        left = 1 - _gains(system, self.j, self.columns)
        order = np.argsort(left)
        plain = next(int(i) for i in order if not self.terms[i].constants)
        bumps = [self.terms[i] for i in order if self.terms[i].constants][:_STARTS]
        refined = [self._refined(system, bump) for bump in bumps]
        bump, gain = max(refined, key=lambda entry: entry[1], default=(self.terms[plain], 0.0))
        return bump if (1 - gain) * _NUMBER**2 < left[plain] else self.terms[plain]

    def _refined(self, system: WhitenedSystem, term: Term) -> tuple[Term, float]:
        """Move centre and width of a bump to the largest gain, on grids of half the mesh each."""
        best, gain = term, float(_gains(system, self.j, _seen([term], self.logs))[0])
        shift, ratio = term.constants["w"] / 2, 1.3
        for _ in range(_HALVINGS):
            c, w = best.constants["c"], best.constants["w"]
            near = [
                replace(best, constants={"c": _short(c + a * shift), "w": _short(w * ratio**b)})
                for a, b in itertools.product((-1, 0, 1), repeat=2)
            ]
            gains = _gains(system, self.j, _seen(near, self.logs))
            at = int(np.argmax(gains))
            if gains[at] > gain:
                best, gain = near[at], float(gains[at])
            shift, ratio = shift * 0.6, ratio**0.6
        return best, gain

    def _settled(self, named: Sequence[Score], terms: list[Term]) -> list[Term]:
        """Refine each bump beside all others."""
        for i, term in enumerate(terms):
            if term.constants:
                others = [t for k, t in enumerate(terms) if k != i]
                beside = [self.scored(named, others)] if others else []
                terms[i], _ = self._refined(self.system([*named, *beside]), term)
        return terms


def with_unnamed(selection: Selection, search: Search, noise: FloatArray) -> Selection:
    """Add expressions for what the named effects leave; friction where it leaves no more.

    Args:
        selection: of the named search.
        search: with the candidates, and the model as it is declared.
        noise: (n,) standard deviation of the torque's noise in the band.
    """
    baseline, accepted = search.baseline, list(selection.accepted)
    loud = baseline.beside(accepted).sigma / np.maximum(noise, 1e-300)
    if not (loud > _STRUCTURED).any():
        return selection
    search.progress("looking for expressions that have no name")
    terms = library(baseline.robot, baseline.base.logs)
    columns, tried = _seen(terms, baseline.base.logs), selection.tried + len(terms) * len(loud)
    for j in map(int, np.argsort(-loud)):
        finder = _Finder(baseline, terms, columns, tried, float(noise[j]), j)
        structured = finder.structured(baseline.beside(accepted))
        whole = finder.instead(accepted) if structured else None
        if whole is not None:
            *rest, found = whole
            accepted = [*rest, *(friction_instead(search, j, rest, found) or [found])]
    accepted.sort(key=lambda s: -s.gain)
    return replace(selection, accepted=tuple(accepted), tried=tried)


# Friction of the standard model in place of an expression that says the same. A joint whose file
# leaves its friction out misses several effects at once, none of which explains much alone; a
# sparse expression takes them together.

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
    system = search.baseline.beside
    wanted = _ALIKE * float(system([*rest, expression]).sigma[j])
    taken = {s.candidate.key for s in rest}
    own = [e for e in search.on_joints((j,)) if e[0].key not in taken]
    plain = [e for e in own if e[0].definition.native and not e[0].change]
    more = [e for e in own if not e[0].definition.native]
    found = _needed(search, rest, plain)
    beside = system([*rest, *found])
    if found and float(beside.sigma[j]) <= wanted:
        return found
    if not more:
        return None
    best, _ = max(more, key=lambda entry: quick_gain(beside, entry[1]))
    entry = refined(
        best,
        [c.constants for c, _ in more if c.key == best.key],
        search.baseline.seen(search.baseline.base),
        lambda c: quick_gain(beside, c),
    )
    found = _needed(search, rest, [*plain, entry])
    return found if found and float(system([*rest, *found]).sigma[j]) <= wanted else None


def _needed(search: Search, rest: Sequence[Score], entries: Sequence[Entry]) -> list[Score]:
    """Return the effects that hold beside each other, without those that do not, least first."""
    kept, system = list(entries), search.baseline.beside(rest)
    while kept:
        scores = []
        for candidate, columns in kept:
            beside = system.with_columns(c for other, c in kept if other is not candidate)
            scores.append(judge(beside, candidate, columns, len(search.pool)))
        failing = [(s.gain, k) for k, s in enumerate(scores) if s.fault]
        if not failing:
            return scores
        del kept[min(failing)[1]]
    return []
