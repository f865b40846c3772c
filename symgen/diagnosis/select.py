"""Whether an effect is there: a rule that rather misses one than invents one.

The whitened columns C of a candidate are projected on the complement of the model, C' = C - Q Q'C.
It is accepted only where all of this holds:

* at least 5 % of its columns is free of what the model can say;
* its coefficients are significant by an F test with errors that are robust to correlation in time
  (sums of scores over blocks, and not below the residual's own long-run variance), corrected for
  every candidate tried, constants counted (Bonferroni);
* with it the fit of its joints is better on every held-out fold of the training log;
* the residual of its joints falls by at least 1 %, and the whole gap, the root mean square over the
  joints of residual over torque, by at least 5 %: what is smaller waits for what is larger;
* sign and size are those of a real thing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.effects import Candidate
from symgen.diagnosis.robust import covariance
from symgen.diagnosis.whitened_system import Columns, WhitenedSystem, dense

FloatArray = NDArray[np.float64]
_FREE = 0.05
_FOLDS = 5  # which are held out
_SIGNIFICANCE = 0.001  # of all candidates together; refined constants are not counted
GAIN = 0.0199  # of the sum of squares: 1 % of the residual
_WHOLE = 0.0975  # of the square: 5 % of the whole gap
# Least gain of what belongs to the measuring chain, to reversals or to time: it is named where it
# is the main thing; small ones are mimicked by what is always a little wrong somewhere.
_MODEL = 0.2  # of what is linearised about the model
_CHAIN = 0.5


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
        closes: share of the whole gap's square that it closes.
        fault: why it is not accepted, or ''.
        alike: other candidates that the data cannot tell from it.
    """

    candidate: Candidate
    columns: Columns
    coefficients: FloatArray
    std: FloatArray
    gain: float
    explained: FloatArray | None = None
    p_value: float = 1.0
    closes: float = 0.0
    fault: str = ""
    alike: tuple[Score, ...] = ()


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


def quick_gain(evidence: WhitenedSystem, columns: Columns) -> float:
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


def project(evidence: WhitenedSystem, columns: Columns) -> Projection:
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
    known = (np.abs(M - np.eye(m)) * scale[:, None] <= _FREE * scale).all(axis=1)
    return Projection(C, free.reshape(K, n, len(values)), directions, fit, known)


def judge(evidence: WhitenedSystem, candidate: Candidate, columns: Columns, tried: int) -> Score:
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
    share = (evidence.sigma / evidence.size) ** 2
    left, was = (float(np.sum(e**2, axis=0) @ share) for e in (error, evidence.residual))
    spread = covariance(p.free, error, evidence.block)
    wald = float(p.fit @ np.linalg.solve(spread, p.fit))
    blocks = int(evidence.block.max()) + 1
    freedom = max(blocks - r, 1)
    p_value = float(fisher.sf(wald / r * freedom / max(blocks - 1, 1), r, freedom))
    coefficients = p.directions @ p.fit
    std = np.sqrt(np.maximum(np.diag(p.directions @ spread @ p.directions.T), 0))
    still = float(evidence.rest @ share)  # the whole gap counts rests, too
    closes = 1 - (left + still) / (was + still)
    score = Score(candidate, columns, coefficients, std, gain, explained, p_value, closes)
    return replace(score, fault=_fault(evidence, score, p, tried))


def _fault(evidence: WhitenedSystem, score: Score, p: Projection, tried: int) -> str:
    if score.gain < GAIN:
        return f"it explains {100 * score.gain:.2g} % of the residual's square; needed: 2 %"
    definition = score.candidate.definition
    least = {"linear": 0.0, "model": _MODEL, "log": _CHAIN}[definition.kind]
    least = 0.0 if definition.reads else least  # physics with a measurement of its own
    if score.gain < least:
        explains = f"it explains {100 * score.gain:.2g} % of the residual's square"
        return f"{explains}; needed: {100 * least:.2g} %"
    if score.closes < _WHOLE:
        share = 100 * (1 - np.sqrt(max(1 - score.closes, 0.0)))
        return f"it closes {share:.2g} % of the whole gap; needed: 5 %"
    if score.p_value * tried > _SIGNIFICANCE:
        return f"not significant: p = {score.p_value:.2g}, {tried} candidates were tried"
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


def _worse_fold(evidence: WhitenedSystem, p: Projection, joints: Sequence[int]) -> int:
    """Return the number (from 1) of a held-out fold whose joints it does not improve, or 0."""
    weight = evidence.moves / evidence.sigma
    W = evidence.W * weight[:, :, None]
    norms = np.sqrt(np.sum(W**2, axis=(0, 1)))
    W = W / np.where(norms > 0, norms, 1.0)
    rows = np.concatenate([W, p.free, (evidence.y * weight)[:, :, None]], axis=2)
    count = W.shape[2]
    # Folds in which it acts alike, so that what happens in one place is held out in parts, too.
    acting = np.cumsum(np.sum(p.free**2, axis=(1, 2)))
    fold = np.minimum((_FOLDS * acting / acting[-1]).astype(int), _FOLDS - 1)
    parts = [rows[fold == f].reshape(-1, rows.shape[2]) for f in range(_FOLDS)]
    grams = [part.T @ part for part in parts]
    whole = np.sum(grams, axis=0)
    # On its own joints: on others, what a fold teaches about their parameters weighs more.
    own = [rows[fold == f][:, joints].reshape(-1, rows.shape[2]) for f in range(_FOLDS)]
    for f in range(_FOLDS):
        rest, here = whole - grams[f], own[f].T @ own[f]
        errors = []
        for m in (count, len(whole) - 1):
            ridge = 1e-10 * np.eye(m)
            x = np.linalg.solve(rest[:m, :m] + ridge, rest[:m, -1])
            errors.append(float(here[-1, -1] - 2 * x @ here[:m, -1] + x @ here[:m, :m] @ x))
        if errors[1] >= errors[0]:
            return f + 1
    return 0
