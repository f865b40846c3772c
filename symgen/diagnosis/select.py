"""Which effects are there: stepwise, by a rule that rather misses one than invents one.

The whitened columns C of a candidate are projected on the complement of the model, C' = C - Q Q'C.
It is accepted only where all of this holds:

* at least 5 % of its columns is free of what the model can say;
* its coefficients are significant by an F test with errors that are robust to correlation in time
  (sums of scores over blocks, and not below the residual's own long-run variance), corrected for
  every candidate tried, constants counted (Bonferroni);
* with it the fit of its joints is better on every held-out fold of the training log;
* the residual of its joints falls by at least 1 %;
* sign and size are those of a real thing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.candidates import Candidate, Torques
from symgen.diagnosis.evidence import FOLDS, Evidence
from symgen.diagnosis.refine import refined
from symgen.diagnosis.robust import covariance

FloatArray = NDArray[np.float64]
Columns = Mapping[int, FloatArray]
_FREE = 0.05
_SIGNIFICANCE = 0.05
_GAIN = 0.0199  # of the sum of squares: 1 % of the residual
_ALIKE = 0.8
# Of the best gain: the simpler candidate is preferred, and parameters of the standard model.
_NEARLY, _PLAIN = 0.9, 0.75
_LEAVES = 2.0  # but it leaves at most this many times the square that the best one leaves
_MOST = 8  # effects
_REFINED = 6  # candidates whose constants are refined before they are judged
# Least gain of what belongs to the measuring chain, to reversals or to time: small ones are
# mimicked by what is always a little wrong, such as how friction builds up at a reversal.
_CHAIN = 0.2


@dataclass(frozen=True, eq=False)
class Score:
    """How a candidate does against some evidence.

    Attributes:
        candidate: what it is.
        columns: in the band at the kept instants, by joint.
        coefficients, std: (m,) of its columns; directions that the model absorbs are at zero.
        gain: share of its joints' sum of squares that it explains.
        explained: whitened contribution (K, n) after projection.
        p_value: of the robust test, not corrected.
        fault: why it is not accepted, or ''.
    """

    candidate: Candidate
    columns: Columns
    coefficients: FloatArray
    std: FloatArray
    gain: float
    explained: FloatArray | None = None
    p_value: float = 1.0
    fault: str = ""


@dataclass(frozen=True, eq=False)
class Projection:
    """A candidate's whitened columns, the part that the model cannot say, and its fit."""

    C: FloatArray  # (K, n, m) whitened
    free: FloatArray  # (K, n, r) after projection, in the directions that are free
    directions: FloatArray  # (m, r)
    fit: FloatArray  # (r,)
    known: NDArray[
        np.bool_
    ]  # (m,) coefficients in which no direction that the model absorbs shares


def dense(columns: Columns, shape: tuple[int, int]) -> FloatArray:
    """Return the columns of all joints, (K, n, m)."""
    m = next(iter(columns.values())).shape[1]
    out = np.zeros((*shape, m))
    for j, c in columns.items():
        out[:, j] = c
    return out


def quick_gain(evidence: Evidence, columns: Columns) -> float:
    """Return the share of the sum of squares of its joints that a candidate explains."""
    A0, b, g, size = 0.0, 0.0, 0.0, 0.0
    for j, c in columns.items():
        C = c * (evidence.moves[:, j] / evidence.sigma[j])[:, None]
        A0 = A0 + C.T @ C
        b = b + evidence.basis[:, j].T @ C
        g = g + C.T @ evidence.residual[:, j]
        size += float(np.sum(evidence.residual[:, j] ** 2))
    A = np.asarray(A0 - np.asarray(b).T @ b)
    directions, values = _free_directions(np.asarray(A0), A)
    if directions.shape[1] == 0 or size == 0:
        return 0.0
    along = directions.T @ np.asarray(g)
    return float(np.sum(along**2 / values) / size)


def _free_directions(A0: FloatArray, A: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return combinations V of columns with V'AV diagonal, of which the model absorbs < 95 %."""
    size = np.sqrt(np.maximum(np.diag(A0), 0))
    scale = np.where(size > 0, size, 1.0)
    whole, turn = np.linalg.eigh(A0 / np.outer(scale, scale))
    independent = whole > 1e-10 * max(whole.max(initial=0.0), 1e-300)
    half = turn[:, independent] / np.sqrt(whole[independent])
    values, inner = np.linalg.eigh(half.T @ (A / np.outer(scale, scale)) @ half)
    free = values > _FREE**2
    V = (half @ inner[:, free]) / scale[:, None]
    return V, values[free]


def project(evidence: Evidence, columns: Columns) -> Projection:
    """Take out of a candidate's columns what the model can say; fit the rest to the residual."""
    C = dense(columns, evidence.y.shape) * (evidence.moves / evidence.sigma)[:, :, None]
    K, n, m = C.shape
    Q = evidence.basis.reshape(K * n, -1)
    flat = C.reshape(K * n, m)
    left = flat - Q @ (Q.T @ flat)
    directions, values = _free_directions(flat.T @ flat, left.T @ left)
    free = left @ directions
    fit = free.T @ evidence.residual.ravel() / values if len(values) else np.zeros(0)
    # What the fit makes of true coefficients c: M c. Known is one with 1 in its row of M.
    M = (directions / values) @ free.T @ left
    scale = np.linalg.norm(flat, axis=0)
    off = np.abs((M - np.eye(m)) * scale[:, None] / np.where(scale > 0, scale, 1.0))
    return Projection(C, free.reshape(K, n, -1), directions, fit, off.max(axis=1) < _FREE)


def judge(evidence: Evidence, candidate: Candidate, columns: Columns, tried: int) -> Score:
    """Test one candidate by the whole rule; `tried` is the number of candidates looked at."""
    from scipy.stats import f as fisher

    p = project(evidence, columns)
    m, r = p.directions.shape
    zero = np.zeros(m)
    if r == 0:
        return Score(candidate, columns, zero, zero, 0.0, fault="the model absorbs it")
    explained = p.free @ p.fit
    joints = list(columns)
    before = float(np.sum(evidence.residual[:, joints] ** 2))
    error = evidence.residual - explained
    gain = float(np.sum(explained**2)) / before
    spread = covariance(p.free, error, evidence.block)
    wald = float(p.fit @ np.linalg.solve(spread, p.fit))
    blocks = int(evidence.block.max()) + 1
    freedom = max(blocks - r, 1)
    p_value = float(fisher.sf(wald / r * freedom / max(blocks - 1, 1), r, freedom))
    coefficients = p.directions @ p.fit
    std = np.sqrt(np.maximum(np.diag(p.directions @ spread @ p.directions.T), 0))
    score = Score(candidate, columns, coefficients, std, gain, explained, p_value)
    return replace(score, fault=_fault(evidence, score, p, tried))


def _fault(evidence: Evidence, score: Score, p: Projection, tried: int) -> str:
    if score.gain < _GAIN:
        return f"it explains {100 * score.gain:.2g} % of the residual's square; needed: 2 %"
    if score.candidate.definition.kind != "linear" and score.gain < _CHAIN:
        return f"it explains {100 * score.gain:.2g} % of the residual's square; needed: 20 %"
    if score.p_value * tried > _SIGNIFICANCE:
        return f"not significant: p = {score.p_value:.2g}, {tried} candidates were tried"
    definition = score.candidate.definition
    known = np.flatnonzero(p.known[: len(definition.linear)])
    named, std = score.coefficients[known], score.std[known]
    signed = definition.sign == "positive" and not score.candidate.change
    if signed and ((named < -2 * std).any() or not (named > 2 * std).any()):
        return "its coefficient has the wrong sign"
    size = np.sqrt(np.mean((p.C @ score.coefficients) ** 2, axis=0)) * evidence.sigma
    torque = np.sqrt(np.mean(evidence.y**2, axis=0))
    if (size > 3 * torque).any():
        return "its torque would be larger than the torque itself"
    worse = _worse_fold(evidence, p, list(score.columns))
    return f"the fit of held-out fold {worse} is not better with it" if worse else ""


def _worse_fold(evidence: Evidence, p: Projection, joints: Sequence[int]) -> int:
    """Return the number (from 1) of a held-out fold whose joints it does not improve, or 0."""
    weight = evidence.moves / evidence.sigma
    W = evidence.W * weight[:, :, None]
    norms = np.sqrt(np.sum(W**2, axis=(0, 1)))
    W = W / np.where(norms > 0, norms, 1.0)
    rows = np.concatenate([W, p.free, (evidence.y * weight)[:, :, None]], axis=2)
    count = W.shape[2]
    # Folds in which it acts alike, so that what happens in one place is held out in parts, too.
    acting = np.cumsum(np.sum(p.free**2, axis=(1, 2)))
    fold = np.minimum((FOLDS * acting / acting[-1]).astype(int), FOLDS - 1)
    parts = [rows[fold == f].reshape(-1, rows.shape[2]) for f in range(FOLDS)]
    grams = [part.T @ part for part in parts]
    whole = np.sum(grams, axis=0)
    # On its own joints: on others, what a fold teaches about their parameters weighs more.
    own = [rows[fold == f][:, joints].reshape(-1, rows.shape[2]) for f in range(FOLDS)]
    for f in range(FOLDS):
        rest, here = whole - grams[f], own[f].T @ own[f]
        errors = []
        for m in (count, len(whole) - 1):
            ridge = 1e-10 * np.eye(m)
            x = np.linalg.solve(rest[:m, :m] + ridge, rest[:m, -1])
            errors.append(float(here[-1, -1] - 2 * x @ here[:m, -1] + x @ here[:m, :m] @ x))
        if errors[1] >= errors[0]:
            return f + 1
    return 0


@dataclass(frozen=True, eq=False)
class Selection:
    """What the stepwise search found.

    Attributes:
        evidence: with the columns of all accepted effects.
        accepted: in the order of their share in closing the gap.
        alike: for each, other candidates that the data cannot tell from it.
        rejected: the best of the others, with the reason.
        tried: number of candidates.
    """

    evidence: Evidence
    accepted: tuple[Score, ...]
    alike: tuple[tuple[Score, ...], ...]
    rejected: tuple[Score, ...]
    tried: int


class Search:
    """A stepwise search among candidates.

    Args:
        base: the evidence of the model as it is declared.
        pool: the candidates.
        torques: gives the model's torques on every log from the accepted scores.
        progress: is told what is being tried.
    """

    def __init__(
        self,
        base: Evidence,
        pool: Iterable[Candidate],
        torques: Callable[[Sequence[Score]], Sequence[Torques]],
        progress: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.base, self.pool = base, tuple(pool)
        self.torques, self.progress = torques, progress
        self._fixed: dict[int, Columns] = {}

    def run(self) -> Selection:
        accepted: list[Score] = []
        alike: dict[tuple[str, tuple[int, ...]], tuple[Score, ...]] = {}
        rejected: list[Score] = []
        seen: set[frozenset[tuple[str, tuple[int, ...]]]] = set()
        while len(accepted) < _MOST:
            self.progress(f"trying {len(self.pool)} candidates for effect {len(accepted) + 1}")
            # Members of one class do not stand beside each other: the data do not tell them apart.
            same = {s.candidate.key for group in alike.values() for s in group}
            ranked = [r for r in self._ranked(accepted) if self.pool[r[1]].key not in same]
            passing, rejected = self._judged(accepted, ranked)
            if not passing:
                break
            best = self._simplest(passing)
            accepted.append(best)
            alike[best.candidate.key] = tuple(
                s for s in passing if s.candidate.key != best.candidate.key and _alike(s, best)
            )
            accepted = self._backward(accepted)
            chosen = frozenset(s.candidate.key for s in accepted)
            if chosen in seen:  # one displaces the other in turn: they are as good as each other
                break
            seen.add(chosen)
        accepted = self._swapped(accepted, alike)
        accepted.sort(key=lambda s: -s.gain)
        return Selection(
            self._with(accepted),
            tuple(accepted),
            tuple(alike.get(s.candidate.key, ()) for s in accepted),
            tuple(rejected),
            len(self.pool),
        )

    def _with(self, accepted: Sequence[Score]) -> Evidence:
        if not accepted:
            return self.base
        columns = [dense(s.columns, self.base.y.shape) for s in accepted]
        return self.base.with_columns(np.concatenate(columns, axis=2))

    def _columns(self, i: int, evidence: Evidence, torques: Sequence[Torques]) -> Columns:
        candidate = self.pool[i]
        if not candidate.uses_model:
            if i not in self._fixed:
                self._fixed[i] = candidate.seen(evidence, torques)
            return self._fixed[i]
        return candidate.seen(evidence, torques)

    def _ranked(self, accepted: Sequence[Score]) -> list[tuple[float, int, Columns]]:
        """Return the best constants of every candidate, the largest gain first."""
        evidence, torques = self._with(accepted), self.torques(accepted)
        taken = {s.candidate.key for s in accepted}
        best: dict[tuple[str, tuple[int, ...]], tuple[float, int, Columns]] = {}
        for i, candidate in enumerate(self.pool):
            if candidate.key in taken and candidate.name not in _REPEATED:
                continue
            columns = self._columns(i, evidence, torques)
            gain = quick_gain(evidence, columns)
            if gain > best.get(candidate.key, (0.0, 0, {}))[0]:
                best[candidate.key] = (gain, i, columns)
        return sorted(best.values(), key=lambda entry: -entry[0])

    def _judged(
        self, accepted: Sequence[Score], ranked: Sequence[tuple[float, int, Columns]]
    ) -> tuple[list[Score], list[Score]]:
        """Judge the best candidates, the first of them with constants between the grid's."""
        evidence, torques = self._with(accepted), self.torques(accepted)
        passing: list[Score] = []
        failing: list[Score] = []
        for place, (gain, i, columns) in enumerate(ranked):
            if gain < _GAIN / 4 and len(failing) >= 5:
                break
            if passing and gain < 0.25 * passing[0].gain:
                break
            candidate = self.pool[i]
            if place < _REFINED:
                candidate, columns = refined(
                    candidate,
                    [c.constants for c in self.pool if c.key == candidate.key],
                    lambda c: c.seen(evidence, torques),
                    lambda c: quick_gain(evidence, c),
                )
            score = judge(evidence, candidate, columns, len(self.pool))
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
        enough = _PLAIN if self.base.W.shape[2] else _NEARLY
        best = passing[0]
        least = max(1 - best.gain, 0.0)
        near = [
            s
            for s in passing
            if s is best or (_alike(s, best) and 1 - s.gain <= _LEAVES * least + _GAIN)
        ]
        plain = [s for s in near if s.candidate.definition.native and s.gain >= enough * best.gain]
        close = plain or [s for s in near if s.gain >= _NEARLY * best.gain]
        return min(close, key=lambda s: (s.candidate.complexity, -s.gain))

    def _swapped(
        self, accepted: list[Score], alike: dict[tuple[str, tuple[int, ...]], tuple[Score, ...]]
    ) -> list[Score]:
        """Choose each effect again among all on its joints, now that the others stand beside it."""
        for at in range(len(accepted) if len(accepted) > 1 else 0):
            rest, own = accepted[:at] + accepted[at + 1 :], accepted[at]
            joints = own.candidate.joints
            same = {s.candidate.key for r in rest for s in alike.get(r.candidate.key, ())}
            ranked = [
                r
                for r in self._ranked(rest)
                if self.pool[r[1]].joints == joints and self.pool[r[1]].key not in same
            ]
            passing, _ = self._judged(rest, ranked)
            if not passing:
                continue
            accepted[at] = best = self._simplest(passing)
            known = {s.candidate.key: s for s in (*alike.get(own.candidate.key, ()), *passing)}
            alike[best.candidate.key] = tuple(
                s for key, s in known.items() if key != best.candidate.key and _alike(s, best)
            )
        return accepted

    def _backward(self, accepted: list[Score]) -> list[Score]:
        """Test every effect again beside all others; drop what no longer holds."""
        at = 0
        while len(accepted) > 1 and at < len(accepted):
            rest = accepted[:at] + accepted[at + 1 :]
            own = accepted[at]
            again = judge(self._with(rest), own.candidate, own.columns, len(self.pool))
            if again.fault:
                accepted = rest
            else:
                accepted[at] = again
                at += 1
        return accepted


#: Effects of the measuring chain.
MEASURING = ("time_delay", "velocity_sensor_error", "saturation", "drive_gain_error")
_REPEATED = ("external_contact",)


def _alike(a: Score, b: Score) -> bool:
    """Whether two candidates explain the same part of the residual."""
    if a.explained is None or b.explained is None:
        return False
    sizes = float(np.linalg.norm(a.explained) * np.linalg.norm(b.explained))
    return abs(float(np.sum(a.explained * b.explained))) > _ALIKE * sizes
