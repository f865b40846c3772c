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
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.candidates import Candidate
from symgen.diagnosis.search import Search as NamedSearch
from symgen.diagnosis.search import Selection
from symgen.diagnosis.select import Score, judge
from symgen.diagnosis.shapes import Torques
from symgen.diagnosis.standard_friction import friction_instead
from symgen.diagnosis.whitened_system import WhitenedSystem, compared
from symgen.estimation.filtered import FilteredLog
from symgen.robot.effect import Search, definitions, unit
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

_POSITION: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "{}": lambda q: q,
    "{}**2": lambda q: q**2,
    "{}**3": lambda q: q**3,
    "sin({})": np.sin,
    "cos({})": np.cos,
    "sin(2*{})": lambda q: np.sin(2 * q),
    "cos(2*{})": lambda q: np.cos(2 * q),
}
_SPEED: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "{}": lambda v: v,
    "abs({})": np.abs,
    "{}**2": lambda v: v**2,
    "{0}*abs({0})": lambda v: v * np.abs(v),
    "sign({})": np.sign,
}
#: Factors of a position before a factor of a speed; products of two positions.
_MIXED = ("{}", "{}**2", "sin({})", "cos({})"), ("{}", "abs({})", "sign({})")
_BUMPS: Mapping[str, Callable[[FloatArray, float, float], FloatArray]] = {
    "exp(-(({q} - {c})/{w})**2)": lambda q, c, w: np.exp(-(((q - c) / w) ** 2)),
    "({q} - {c})*exp(-(({q} - {c})/{w})**2)": lambda q, c, w: (
        (q - c) * np.exp(-(((q - c) / w) ** 2))
    ),
}
_UNITS = {"q": "position", "qd": "speed"}


@dataclass(frozen=True, eq=False)
class Term:
    """One term of the library.

    Attributes:
        text: in the variables q1, qd1, ...; {c} and {w} stand for the names of constants.
        values: gives it at full rate, (N,).
        dimension: its unit.
        constants: centre and width of a bump.
        remake: gives the same bump elsewhere.
    """

    text: str
    values: Callable[[FilteredLog], FloatArray]
    dimension: str
    constants: Mapping[str, float] = field(default_factory=dict)
    remake: Callable[[float, float], Term] | None = None


def library(robot: Robot, scenes: Sequence[FilteredLog]) -> list[Term]:
    """Return every term in the positions and speeds of a robot's joints, bumps on their grid."""
    return [*_plain(robot), *_products(robot), *_bumps(robot, scenes)]


def _plain(robot: Robot) -> Iterator[Term]:
    for letter, functions in (("q", _POSITION), ("qd", _SPEED)):
        for k in range(robot.n):
            for text in functions:
                yield _product(robot, (letter, k, text))


def _products(robot: Robot) -> Iterator[Term]:
    joints = range(robot.n)
    positions, speeds = _MIXED
    for j, k in itertools.product(joints, joints):
        for first, second in itertools.product(positions, speeds):
            yield _product(robot, ("q", j, first), ("qd", k, second))
    for j, k in itertools.combinations(joints, 2):
        yield _product(robot, ("q", j, "{}"), ("q", k, "{}"))
        yield _product(robot, ("qd", j, "{}"), ("qd", k, "{}"))
        for first, second in itertools.product(("sin({})", "cos({})"), repeat=2):
            yield _product(robot, ("q", j, first), ("q", k, second))


def _product(robot: Robot, *factors: tuple[str, int, str]) -> Term:
    """Return a product of functions, each (q or qd, position of the joint, text)."""
    functions = {"q": _POSITION, "qd": _SPEED}

    def values(s: FilteredLog) -> FloatArray:
        out = np.ones(len(s.t))
        for letter, k, text in factors:
            x = s.q[:, k] if letter == "q" else s.qd[:, k]
            out = out * functions[letter][text](x)
        return out

    texts, dimension = [], []
    for letter, k, text in factors:
        joint = robot.movable[k]
        texts.append(text.format(f"{letter}{joint.number}"))
        power = int(text[-1]) if "**" in text else 2 if "*abs" in text else 1
        if "(" not in text or "abs" in text:
            own = unit(_UNITS[letter], joint.sigma)
            dimension += [own] * power
    return Term("*".join(texts), values, " ".join(dimension))


def _bumps(robot: Robot, scenes: Sequence[FilteredLog]) -> Iterator[Term]:
    for k in range(robot.n):
        q = np.concatenate([s.q[s.kept, k] for s in scenes])
        low, high = float(q.min()), float(q.max())
        reach = _REACH[robot.movable[k].sigma]
        for text in _BUMPS:
            for c in np.linspace(low, high, _CENTRES):
                if high > low and abs(c) < reach:
                    for w in _WIDTHS:
                        yield _bump(robot, k, text, float(c), w * (high - low) / 2)


def _bump(robot: Robot, k: int, text: str, c: float, w: float) -> Term:
    joint, own = robot.movable[k], _BUMPS[text]
    return Term(
        text.replace("{q}", f"q{joint.number}"),
        lambda s: own(s.q[:, k], c, w),
        unit("position", joint.sigma) if text.startswith("(") else "",
        {"c": c, "w": w},
        lambda c, w: _bump(robot, k, text, c, w),
    )


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
        nonlinear={name: Search(value, value, 1) for name, value in constants.items()},
        own=True,
    )

    def columns(s: FilteredLog, _: Torques) -> Mapping[int, FloatArray]:
        return {position: -np.stack([t.values(s) for t in terms], axis=1)}

    return Candidate(definition, (position,), columns, len(terms), constants)


def _seen(terms: Sequence[Term], scenes: Sequence[FilteredLog]) -> FloatArray:
    """Return minus the terms in the band at the kept instants of all logs, (K, T)."""
    out = []
    for s in scenes:
        parts = [
            compared(s, np.stack([t.values(s) for t in terms[i : i + _CHUNK]], axis=1))
            for i in range(0, len(terms), _CHUNK)
        ]
        out.append(np.concatenate(parts, axis=1))
    return -np.concatenate(out)


def _gains(evidence: WhitenedSystem, j: int, columns: FloatArray) -> FloatArray:
    """Return the share of a joint's sum of squares that each column (K, T) explains, (T,)."""
    C = columns * (evidence.moves[:, j] / evidence.sigma[j])[:, None]
    whole = np.sum(C**2, axis=0)
    left = whole - np.sum((evidence.basis[:, j].T @ C) ** 2, axis=0)
    free = left > _FREE**2 * whole
    size = float(np.sum(evidence.residual[:, j] ** 2)) or 1.0
    out = (C.T @ evidence.residual[:, j]) ** 2 / np.where(free, left, np.inf) / size
    return np.asarray(np.where(np.isfinite(out), out, 0.0))


def _on(j: int, accepted: Sequence[Score]) -> list[Score]:
    """Return the effects on one joint alone."""
    return [s for s in accepted if s.candidate.joints == (j,)]


class _Finder:
    """The search for expressions, joint by joint."""

    def __init__(self, baseline: Baseline, noise: FloatArray, tried: int) -> None:
        self.robot, self.system, self.noise = baseline.robot, baseline.beside, noise
        self.terms = library(self.robot, baseline.base.logs)
        self.columns = _seen(self.terms, baseline.base.logs)
        self.tried = tried + len(self.terms) * self.robot.n

    def structured(self, evidence: WhitenedSystem) -> FloatArray:
        """Return the residual over the noise, (n,)."""
        return np.asarray(evidence.sigma / np.maximum(self.noise, 1e-6 * np.std(evidence.y)))

    def score(self, evidence: WhitenedSystem, j: int, terms: Sequence[Term]) -> Score:
        """Judge the sum of some terms on one joint."""
        return judge(
            evidence,
            expression(self.robot, j, terms),
            {j: _seen(terms, evidence.logs)},
            self.tried,
        )

    def on_joint(self, j: int, named: Sequence[Score]) -> tuple[list[Score], Score] | None:
        """Return the named effects that stay, and the expression; None where there is none."""
        terms: list[Term] = []
        found: Score | None = None
        while len(terms) < _MOST:
            here = self.system([*named, found] if found else named)
            if self.structured(here)[j] < _STRUCTURED:
                break
            new = self._best(here, j)
            if self.score(here, j, [new]).fault:
                break
            terms = self._settled(j, named, [*terms, new])
            found = self.score(self.system(named), j, terms)
            named, found, terms = self._lean(j, named, found, terms)
            if found.fault:
                return None
        return None if found is None else (list(named), found)

    def instead(self, j: int, named: Sequence[Score]) -> list[Score] | None:
        """Return the effects with an expression on a joint; None where named ones do as well.

        It is looked for beside all that is named, and in place of the joint's own effects: first
        of those outside the standard model of friction, then of all. It has to do better than any
        member of the classes of these, too.
        """
        own = _on(j, named)
        odd = [s for s in own if not s.candidate.definition.native]
        others = [
            [other if s is mine else s for s in named] for mine in own for other in mine.alike
        ]
        costs = [self._cost(one, j, _on(j, one)) for one in (named, *others)]
        best, least = None, _LEFT * min(costs)
        for away in (own[:0], *([odd] if odd else []), *([own] if own != odd else [])):
            found = self.on_joint(j, [s for s in named if all(s is not a for a in away)])
            if found is not None:
                whole = [*found[0], found[1]]
                cost = self._cost(whole, j, _on(j, whole))
                if cost < least:
                    best, least = whole, cost
        return best

    def _cost(self, accepted: Sequence[Score], j: int, own: Sequence[Score]) -> float:
        """Return the square of a joint's residual, its effects' numbers weighed in."""
        numbers = sum(s.candidate.complexity for s in own)
        return float(self.system(accepted).sigma[j] ** 2) * _NUMBER**numbers

    def _best(self, evidence: WhitenedSystem, j: int) -> Term:
        """Return the term that leaves least, a bump's two numbers weighed in."""
        left = 1 - _gains(evidence, j, self.columns)
        order = np.argsort(left)
        plain = next(int(i) for i in order if not self.terms[i].constants)
        bumps = [self.terms[i] for i in order if self.terms[i].constants][:_STARTS]
        if not bumps:
            return self.terms[plain]
        refined = [self._refined(evidence, j, bump) for bump in bumps]
        bump, gain = max(refined, key=lambda entry: entry[1])
        return bump if (1 - gain) * _NUMBER**2 < left[plain] else self.terms[plain]

    def _refined(self, evidence: WhitenedSystem, j: int, term: Term) -> tuple[Term, float]:
        """Move centre and width of a bump to the largest gain, on grids of half the mesh each."""
        best, gain = term, float(_gains(evidence, j, _seen([term], evidence.logs))[0])
        if term.remake is None:
            return best, gain
        c, w = term.constants["c"], term.constants["w"]
        shift, ratio = w / 2, 1.3
        for _ in range(_HALVINGS):
            near = [
                term.remake(float(f"{c + a * shift:.6g}"), float(f"{w * ratio**b:.6g}"))
                for a in (-1, 0, 1)
                for b in (-1, 0, 1)
            ]
            gains = _gains(evidence, j, _seen(near, evidence.logs))
            at = int(np.argmax(gains))
            if gains[at] > gain:
                best, gain = near[at], float(gains[at])
                c, w = best.constants["c"], best.constants["w"]
            shift, ratio = shift * 0.6, ratio**0.6
        return best, gain

    def _settled(self, j: int, named: Sequence[Score], terms: list[Term]) -> list[Term]:
        """Refine each bump beside all others."""
        for i, term in enumerate(terms):
            if term.constants:
                others = [t for k, t in enumerate(terms) if k != i]
                beside = [self.score(self.system(named), j, others)] if others else []
                terms[i], _ = self._refined(self.system([*named, *beside]), j, term)
        return terms

    def _lean(
        self, j: int, named: Sequence[Score], found: Score, terms: list[Term]
    ) -> tuple[list[Score], Score, list[Term]]:
        """Drop named effects of the joint that the expression makes needless."""
        kept = list(named)
        for own in [s for s in named if s.candidate.joints == (j,)]:
            rest = [s for s in kept if s is not own]
            evidence = self.system([*rest, found])
            again = judge(evidence, own.candidate, own.columns, self.tried)
            if again.fault:
                terms = self._settled(j, rest, terms)
                kept, found = rest, self.score(self.system(rest), j, terms)
        return kept, found, terms


def with_unnamed(selection: Selection, search: NamedSearch, noise: FloatArray) -> Selection:
    """Add expressions for what the named effects leave; friction where it leaves no more.

    Args:
        selection: of the named search.
        search: with the candidates, and the model as it is declared.
        noise: (n,) standard deviation of the torque's noise in the band.
    """
    accepted = list(selection.accepted)
    loud = search.baseline.beside(accepted).sigma / np.maximum(noise, 1e-300)
    if not (loud > _STRUCTURED).any():
        return selection
    search.progress("looking for expressions that have no name")
    finder = _Finder(search.baseline, noise, selection.tried)
    for j in np.argsort(-loud):
        if finder.structured(finder.system(accepted))[j] < _STRUCTURED:
            continue
        whole = finder.instead(int(j), accepted)
        if whole is None:
            continue
        *rest, expression = whole
        accepted = [*rest, *(friction_instead(search, int(j), rest, expression) or [expression])]
    accepted.sort(key=lambda s: -s.gain)
    return replace(selection, accepted=tuple(accepted), tried=finder.tried)
