"""Torques without a known law: free functions of one or two variables.

The variables are position, speed (with its sign) and load of a joint. A spline shows on which of
them a torque depends, but not by which law. Splines compete by the same score as effects. symgen
adds no spline to the robot. It shows a spline that predicts held-out motion much better than the
named law, or any useful spline if there is no law.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from symgen.diagnosis.baseline import Baseline
from symgen.diagnosis.diagnosis import FreeFunction
from symgen.diagnosis.effects import Score
from symgen.diagnosis.residual_patterns import EXPLAINED
from symgen.diagnosis.whitened_system import compared
from symgen.estimation.predictive_score import SURE, Fit, PredictiveScore
from symgen.estimation.values import FloatArray
from symgen.robot.effect import numbered

_DEGREE = 3
#: Numbers of splines that are tried, by the number of variables; the score selects one.
_SIZES: dict[int, tuple[int, ...]] = {1: (5, 10, 20), 2: (5,)}
_GOOD = 0.8  # gain of a law over that of a free function, above which the law has the right shape
_POINTS = 61  # points of a curve
_LEVELS = (0.1, 0.5, 0.9)  # quantiles of a second variable at which curves are drawn
_LETTERS = ("q", "qd", "taur")
#: Indices of q, then qd, then the load, of all joints.
Variables = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class _Splines:
    """Cubic splines with knots at quantiles; splines in a speed differ between its two signs.

    Attributes:
        states: (N, 3 n) q, qd and load of all joints along the training logs, at a reduced rate.
        variables: arguments of the function; the joint's own position, speed or load comes first.
        width: width w of tanh(qd/w) in place of sign(qd), rad/s (m/s); 0 for sign(qd).
        size: number of splines in each variable.
    """

    states: FloatArray
    variables: Variables
    width: float
    size: int

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.states.shape[1]) // 3

    @cached_property
    def speed(self) -> int:
        """Index of the joint's own speed."""
        return self.n + self.variables[0] % self.n

    @cached_property
    def _knots(self) -> list[FloatArray]:
        inner = np.linspace(0, 1, self.size - _DEGREE + 1)
        ends = [self._known(self.states, v) for v in self.variables]
        knots = (np.quantile(x, inner) for x in ends)
        return [np.pad(k, _DEGREE, mode="edge") for k in knots]

    def _known(self, states: FloatArray, v: int) -> FloatArray:
        """Return the argument of the splines for a variable, (N,)."""
        return np.abs(states[:, v]) if v == self.speed else states[:, v]

    def sign(self, states: FloatArray) -> FloatArray:
        """Return the sign of the joint's speed as in its friction model, (N,)."""
        speed = states[:, self.speed]
        return np.tanh(speed / self.width) if self.width else np.sign(speed)

    def __call__(self, states: FloatArray) -> FloatArray:
        """Return the splines (N, m) at states (N, 3 n)."""
        from scipy.interpolate import BSpline

        out = np.ones((len(states), 1))
        for v, knots in zip(self.variables, self._knots, strict=True):
            x = np.clip(self._known(states, v), knots[0], knots[-1])
            own = BSpline.design_matrix(x, knots, _DEGREE).toarray()
            if v == self.speed:
                own = np.hstack([own, self.sign(states)[:, None] * own])
            out = (out[:, :, None] * own[:, None]).reshape(len(states), -1)
        return out

    def grid(self) -> tuple[FloatArray, list[float], FloatArray]:
        """Return values of both variables and the states (.., .., 3 n) at these values."""
        first, *more = self.variables
        values = self.states[:, first]
        grid = np.linspace(values.min(), values.max(), _POINTS)
        at = [float(np.quantile(self.states[:, v], p)) for v in more for p in _LEVELS]
        out = np.tile(np.median(self.states, axis=0), (max(len(at), 1), _POINTS, 1))
        out[:, :, first] = grid
        for v in more:
            out[:, :, v] = np.array(at)[:, None]
        return grid, at, out


def free_functions(
    baseline: Baseline, accepted: Sequence[Score], least: float, misfit: float, *, left: bool
) -> tuple[FreeFunction, ...]:
    """Return the free functions that predict much better than the laws on their joint.

    Args:
        baseline: the declared model and its training logs.
        accepted: the effects that were found.
        least: smallest torque that matters, as a part of the joint's torque.
        misfit: smallest model error to expect, as a part of a joint's torque.
        left: whether a part of the gap is unexplained; then functions without a law are tried.
    """
    states = _states(baseline)

    def asked(effects: Sequence[Score]) -> _Asked:
        score = baseline.score(baseline.beside(effects), misfit)
        return _Asked(baseline, effects, score, states)

    found: list[FreeFunction] = []
    known = {id(s): _variables(baseline, s) for s in accepted}
    for j, variables in dict.fromkeys(known.values()):
        if variables:
            laws = [
                s for s in accepted if known[id(s)][0] == j and {*known[id(s)][1]} <= {*variables}
            ]
            rest = [s for s in accepted if all(s is not law for law in laws)]
            found += asked(rest).beside_laws(j, variables, laws, least)
    if left:
        whole = asked(accepted)
        told = {f.joint for f in found}
        for j, joint in enumerate(baseline.robot.movable):
            if joint.number not in told and whole.missing(j) > least * baseline.base.size[j]:
                found += whole.alone(j)
    return tuple(found)


def _variables(baseline: Baseline, score: Score) -> tuple[int, Variables]:
    """Return the joint that an effect acts on and the arguments of its torque.

    The list of arguments is empty if the torque depends on more than two of them, on time, on the
    acceleration, or on another state.
    """
    robot, c = baseline.robot, score.candidate
    none = (-1, ())
    if len(c.joints) != 1 or not c.definition.torque:
        return none
    (j,) = c.joints
    places = {str(joint.number): k for k, joint in enumerate(robot.movable)}
    written = re.findall(
        r"\b(q|qd|qdd|taur)(\d+)\b", numbered(c.definition, robot.movable[j].number)
    )
    if any(letter not in _LETTERS for letter, _ in written):
        return none
    found = {_LETTERS.index(letter) * robot.n + places[number] for letter, number in written}
    own = sorted(found, key=lambda v: (v % robot.n != j, v))
    return (j, tuple(own)) if 0 < len(own) <= max(_SIZES) else none


class _Fitted(NamedTuple):
    """A free function with its columns (K, m) in the band, and its fit."""

    fit: Fit
    splines: _Splines
    columns: FloatArray


@dataclass(frozen=True, eq=False)
class _Asked:
    """The model with effects, whose residual is compared with free functions.

    Attributes:
        baseline: the declared model.
        effects: the effects that are added to it.
        score: the predictive score of its equations.
        states: q, qd and load of all joints along each training log, at a reduced rate, (N, 3 n).
    """

    baseline: Baseline
    effects: Sequence[Score]
    score: PredictiveScore
    states: Sequence[FloatArray]

    def missing(self, j: int) -> float:
        """Return the RMS of the unexplained held-out torque of joint j, N m or N."""
        return float(np.sqrt(self.score.alone.left[j]))

    def beside_laws(
        self, j: int, variables: Variables, laws: Sequence[Score], least: float
    ) -> Iterator[FreeFunction]:
        """Yield the function of the laws' variables if it predicts much better than the laws."""
        # The prior of a law limits its size: a spring may carry more than the missing torque.
        law = np.hstack([s.columns[j] for s in laws])
        alone, named = self.score.alone, self.score.beside({j: law})
        free = self._best(j, [variables])
        ratio = (named.score - alone.score) / max(free.fit.score - alone.score, 1e-300)
        better = math.sqrt(max(named.left[j] - free.fit.left[j], 0.0)) / self.baseline.base.size[j]
        if free.fit.score - named.score > SURE and ratio < _GOOD and better > least:
            yield self._drawn(j, free, named, laws, ratio)

    def alone(self, j: int) -> Iterator[FreeFunction]:
        """Yield the function that explains most, and at least half, of joint j's missing torque."""
        sets, alone = [*_sets(self.baseline.robot.n, j)], self.score.alone
        free = self._best(j, sets)
        sure = free.fit.score - alone.score > SURE + math.log(len(sets))
        if sure and free.fit.left[j] < EXPLAINED * alone.left[j]:
            yield self._drawn(j, free, alone)

    def _best(self, j: int, sets: Iterable[Variables]) -> _Fitted:
        """Return the function on joint j that predicts best, with its columns in the band."""
        joint, logs = self.baseline.robot.movable[j], self.baseline.base.logs
        whole, tried = np.concatenate(self.states), []
        for variables in sets:
            for size in _SIZES[len(variables)]:
                splines = _Splines(whole, variables, joint.coulomb_width, size)
                pairs = zip(logs, self.states, strict=True)
                columns = np.concatenate([compared(log, splines(x)) for log, x in pairs])
                fit = self.score.beside({j: columns}, self.missing(j))
                tried.append(_Fitted(fit, splines, columns))
        return max(tried, key=lambda found: found.fit.score)

    def _drawn(
        self,
        j: int,
        free: _Fitted,
        before: Fit,
        laws: Sequence[Score] = (),
        ratio: float = 0.0,
    ) -> FreeFunction:
        """Return the curve of a function on joint j, and that of the laws it replaces."""
        robot, size = self.baseline.robot, self.baseline.base.size[j]
        splines = free.splines
        grid, at, states = splines.grid()
        flat = states.reshape(-1, states.shape[2])
        d, b = self.score.fits({j: free.columns}, self.missing(j))
        torque = self._friction(j, splines, flat, d) + splines(flat) @ b.T
        parts = torque[:, :-1]
        # Jackknife over the folds: the change of the fit when a fold of motion is left out.
        std = np.sqrt((parts.shape[1] - 1) * np.var(parts, axis=1))
        law = self._law(j, splines, flat, laws) if laws else np.zeros(0)
        return FreeFunction(
            joint=robot.movable[j].number,
            variables=tuple(
                f"{_LETTERS[v // robot.n]}{robot.movable[v % robot.n].number}"
                for v in splines.variables
            ),
            effects=tuple(dict.fromkeys(s.candidate.name for s in laws)),
            grid=tuple(grid),
            at=tuple(at),
            torque=_rows(torque[:, -1]),
            std=_rows(std),
            law=_rows(law),
            gain_ratio=ratio,
            before=math.sqrt(before.left[j]) / size,
            after=math.sqrt(free.fit.left[j]) / size,
        )

    def _friction(self, j: int, splines: _Splines, states: FloatArray, d: FloatArray) -> FloatArray:
        """Return the declared friction (N, F) of joint j at states, for parameter changes d (F, p).

        Splines can represent this friction too. Only the sum is determined.
        """
        speed, number = states[:, splines.speed], self.baseline.robot.movable[j].number
        values = {f"OF{number}": np.ones(len(states))}
        if splines.speed in splines.variables:
            values |= {f"FS{number}": splines.sign(states), f"FV{number}": speed}
        base, X = self.baseline.evaluator.model.base, self.baseline.beside(self.effects).X
        out = np.zeros((len(states), len(d)))
        for k, p in enumerate(base.parameters[: self.baseline.base.W.shape[2]]):
            if p.head in values:
                out += values[p.head][:, None] * (X + d)[:, k]
        return out

    def _law(
        self, j: int, splines: _Splines, states: FloatArray, laws: Sequence[Score]
    ) -> FloatArray:
        """Return the torque (N,) of laws on joint j at states, with its declared friction."""
        d, b = self.score.fits({j: np.hstack([s.columns[j] for s in laws])})
        log, (torques, *_) = self.baseline.base.logs[0], self.baseline.torques(self.baseline.base)
        q, qd, load = np.hsplit(states, 3)
        samples = replace(log.samples, t=np.zeros(len(states)))
        here, along = replace(log, samples=samples, q=q, qd=qd), replace(torques, load=load)
        own = np.hstack([s.candidate.columns(here, along)[j] for s in laws])
        return np.asarray(self._friction(j, splines, states, d[-1:])[:, 0] + own @ b[-1])


def _rows(x: FloatArray) -> tuple[tuple[float, ...], ...]:
    """Return curves of equal length as rows."""
    return tuple(tuple(map(float, row)) for row in x.reshape(-1, _POINTS))


def _sets(n: int, j: int) -> Iterator[Variables]:
    """Yield the possible arguments of a torque on joint j."""
    own = (j, n + j, 2 * n + j)
    yield from ((v,) for v in own)
    yield from itertools.combinations(own, 2)
    for k in range(2 * n):
        if k % n != j:
            yield from ((v, k) for v in own[:2])


def _states(baseline: Baseline) -> list[FloatArray]:
    """Return q, qd and load of all joints along each training log, at a reduced rate, (N, 3 n)."""
    logs = [log.thinned for log in baseline.base.logs]
    along = baseline.torques(baseline.base)
    return [np.hstack([s.q, s.qd, t.load]) for s, t in zip(logs, along, strict=True)]
