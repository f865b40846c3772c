"""Which effects are there: stepwise, by a rule that rather misses one than invents one.

The whitened columns C of a candidate are projected on the complement of the model, C' = C - Q Q'C.
It is accepted only where all of this holds:

* at least 5 % of its columns is free of what the model can say;
* its coefficients are significant by an F test with errors that are robust to correlation in time
  (sums of scores over blocks, and not below the residual's own long-run variance), corrected for
  every candidate tried, constants counted (Bonferroni);
* with it the fit is better on every held-out fold of the training log in which it acts;
* the residual of its joints falls by at least 1 %;
* sign and size are those of a real thing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.diagnose.candidates import Candidate, Torques
from symgen.diagnose.evidence import Evidence

FloatArray = NDArray[np.float64]
Columns = Mapping[int, FloatArray]
_FREE = 0.05
_SIGNIFICANCE = 0.05
_GAIN = 0.0199  # of the sum of squares: 1 % of the residual
_ALIKE = 0.8
_NEARLY = 0.9  # of the best gain: the simpler candidate is preferred
_ACTS = 0.02  # share of a column's square in a fold below which it does not act there
_PLAIN = 0.75  # the same for parameters of the standard model
_MOST = 8  # effects
_CHAIN = 0.2  # least gain of a fault of the measuring chain: a small one hides in the model


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
    return Projection(C, free.reshape(K, n, -1), directions, fit)


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
    covariance = _covariance(evidence, p.free, error)
    wald = float(p.fit @ np.linalg.solve(covariance, p.fit))
    blocks = int(evidence.block.max()) + 1
    freedom = max(blocks - r, 1)
    p_value = float(fisher.sf(wald / r * freedom / max(blocks - 1, 1), r, freedom))
    coefficients = p.directions @ p.fit
    std = np.sqrt(np.maximum(np.diag(p.directions @ covariance @ p.directions.T), 0))
    score = Score(candidate, columns, coefficients, std, gain, explained, p_value)
    return replace(score, fault=_fault(evidence, score, p, tried))


def _covariance(evidence: Evidence, free: FloatArray, error: FloatArray) -> FloatArray:
    """Return the covariance of the fit: sums of scores over blocks, and the long-run variance."""
    r = free.shape[2]
    bread = np.linalg.inv(np.einsum("kna,knb->ab", free, free))
    scores = np.einsum("kna,kn->ka", free, error)
    blocks = int(evidence.block.max()) + 1
    sums = np.zeros((blocks, r))
    np.add.at(sums, evidence.block, scores)
    small = blocks / max(blocks - r, 1)
    robust = small * bread @ (sums.T @ sums) @ bread
    long_run = long_run_variance(error, evidence.block)
    plain = bread @ np.einsum("kna,n,knb->ab", free, long_run, free) @ bread
    # The larger of two covariances, direction by direction.
    half = np.linalg.cholesky(plain + 1e-12 * np.trace(plain) * np.eye(r))
    inverse = np.linalg.inv(half)
    values, turn = np.linalg.eigh(inverse @ robust @ inverse.T)
    whole = half @ turn
    out: FloatArray = (whole * np.maximum(values, 1.0)) @ whole.T
    return out


def long_run_variance(error: FloatArray, block: NDArray[np.int64]) -> FloatArray:
    """Return K times the variance of the mean of each residual, (n,): Bartlett's weights."""
    K = len(error)
    lag = max(1, min(40, K // (2 * (int(block.max()) + 1))))
    total = np.mean(error**2, axis=0)
    for k in range(1, lag + 1):
        total = total + 2 * (1 - k / (lag + 1)) * np.mean(error[k:] * error[:-k], axis=0)
    out: FloatArray = np.maximum(total, np.mean(error**2, axis=0))
    return out


def _fault(evidence: Evidence, score: Score, p: Projection, tried: int) -> str:
    if score.gain < _GAIN:
        return f"it explains {100 * score.gain:.2g} % of the residual's square; needed: 2 %"
    if score.candidate.name in MEASURING and score.gain < _CHAIN:
        return f"it explains {100 * score.gain:.2g} % of the residual's square; needed: 20 %"
    if score.p_value * tried > _SIGNIFICANCE:
        return f"not significant: p = {score.p_value:.2g}, {tried} candidates were tried"
    definition = score.candidate.definition
    named = score.coefficients[: len(definition.linear)]
    std = score.std[: len(definition.linear)]
    signed = definition.sign == "positive" and not score.candidate.change
    if signed and ((named < -2 * std).any() or not (named > 2 * std).any()):
        return "its coefficient has the wrong sign"
    size = np.sqrt(np.mean((p.C @ score.coefficients) ** 2, axis=0)) * evidence.sigma
    torque = np.sqrt(np.mean(evidence.y**2, axis=0))
    if (size > 3 * torque).any():
        return "its torque would be larger than the torque itself"
    worse = _worse_fold(evidence, p)
    return f"the fit of held-out fold {worse} is not better with it" if worse else ""


def _worse_fold(evidence: Evidence, p: Projection) -> int:
    """Return the number (from 1) of a held-out fold that the candidate does not improve, or 0."""
    weight = evidence.moves / evidence.sigma
    W = evidence.W * weight[:, :, None]
    norms = np.sqrt(np.sum(W**2, axis=(0, 1)))
    W = W / np.where(norms > 0, norms, 1.0)
    rows = np.concatenate([W, p.free, (evidence.y * weight)[:, :, None]], axis=2)
    count = W.shape[2]
    folds = int(evidence.fold.max()) + 1
    parts = [rows[evidence.fold == f].reshape(-1, rows.shape[2]) for f in range(folds)]
    grams = [part.T @ part for part in parts]
    whole = np.sum(grams, axis=0)
    acting = np.array([np.trace(g[count:-1, count:-1]) for g in grams])
    for f in range(folds):
        if acting[f] < _ACTS * acting.sum() or acting[f] > (1 - _ACTS) * acting.sum():
            continue
        rest, here = whole - grams[f], grams[f]
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
            evidence = self._with(accepted)
            passing, rejected = self._judged(evidence, ranked)
            if not passing:
                break
            best = self._simplest(passing)
            best = self._refined(evidence, best, accepted)
            accepted.append(best)
            alike[best.candidate.key] = tuple(
                s for s in passing if s.candidate.key != best.candidate.key and _alike(s, best)
            )
            accepted = self._backward(accepted)
            chosen = frozenset(s.candidate.key for s in accepted)
            if chosen in seen:  # one displaces the other in turn: they are as good as each other
                break
            seen.add(chosen)
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
        self, evidence: Evidence, ranked: Sequence[tuple[float, int, Columns]]
    ) -> tuple[list[Score], list[Score]]:
        passing: list[Score] = []
        failing: list[Score] = []
        for gain, i, columns in ranked:
            if gain < _GAIN / 4 and len(failing) >= 5:
                break
            if passing and gain < 0.25 * passing[0].gain:
                break
            score = judge(evidence, self.pool[i], columns, len(self.pool))
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
        near = [s for s in passing if s is best or _alike(s, best)]
        plain = [s for s in near if s.candidate.definition.native and s.gain >= enough * best.gain]
        close = plain or [s for s in near if s.gain >= _NEARLY * best.gain]
        return min(close, key=lambda s: (s.candidate.complexity, -s.gain))

    def _refined(self, evidence: Evidence, score: Score, accepted: Sequence[Score]) -> Score:
        """Move a single constant between its neighbours on the grid to the largest gain."""
        from scipy.optimize import minimize_scalar

        candidate = score.candidate
        remake = candidate.remake
        if remake is None or len(candidate.constants) != 1:
            return score
        name, value = next(iter(candidate.constants.items()))
        others = sorted({c.constants[name] for c in self.pool if c.key == candidate.key} | {value})
        at = others.index(value)
        low, high = others[max(at - 1, 0)], others[min(at + 1, len(others) - 1)]
        if not low < high or candidate.name == "coupled_transmission":
            return score
        torques = self.torques(accepted)

        def loss(x: float) -> float:
            return -quick_gain(evidence, remake({name: x}).seen(evidence, torques))

        found = minimize_scalar(loss, bounds=(low, high), method="bounded", options={"maxiter": 20})
        if -found.fun <= score.gain:
            return score
        finer = remake({name: float(f"{found.x:.6g}")})
        better = judge(evidence, finer, finer.seen(evidence, torques), 3 * len(self.pool))
        return score if better.fault or better.gain < score.gain else better

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
_REPEATED = ("external_contact", "torque_ripple")


def _alike(a: Score, b: Score) -> bool:
    """Whether two candidates explain the same part of the residual."""
    if a.explained is None or b.explained is None:
        return False
    sizes = float(np.linalg.norm(a.explained) * np.linalg.norm(b.explained))
    return abs(float(np.sum(a.explained * b.explained))) > _ALIKE * sizes
