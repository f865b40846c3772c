"""The covariance of an estimate, robust to correlated residuals and to what a model misses.

Residuals that are correlated in time are summed up over neighbours (Newey and West 1987). What a
model misses is there in all joints at once, and another one in another part of the motion: that
shows by how an estimate changes without each block of time, the jackknife. The larger of the two
deviations counts for each parameter.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.summary import BLOCKS, Summary, nonzero_columns
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import FloatArray

_FEWEST = 5  # blocks
_APART = 2.0  # independent rows of a joint in a block, at least
_ALONE = 0.01  # of what all blocks say of a combination: less is not known without one of them


def scores(
    e: Equations, X: FloatArray, scale: FloatArray, weight: float | FloatArray
) -> FloatArray:
    """Return w^2 (y - W X) W / scale of every row, (K, p).

    Args:
        e: the equations.
        X: (p,) at which they are taken.
        scale: (p,) norms of the weighted columns.
        weight: of the rows: a number, or (K,).
    """
    out: FloatArray = e.W / scale
    out *= (np.square(weight) * (e.y - e.W @ X))[:, None]
    return out


def bartlett(scores: FloatArray, lag: int, lead: int = 0, ended: bool = True) -> FloatArray:
    """Return the long-run covariance sum of scores (K, p): overlapping sums over `lag` rows.

    Args:
        scores: of consecutive rows of a log.
        lag: rows of a sum.
        lead: rows before those that are this chunk's own: sums that end in them are another's.
        ended: whether the log ends with these rows.
    """
    moved, last = nonzero_columns(scores), lag + len(scores)
    total = np.zeros((last + (lag if ended else 0), len(moved)))
    np.cumsum(scores[:, moved], axis=0, out=total[lag:last])
    total[last:] = total[last - 1]
    sums = (total[lag:] - total[:-lag])[lead:]
    meat = np.zeros((scores.shape[1],) * 2)
    meat[np.ix_(moved, moved)] = sums.T @ sums / lag
    return meat


def robust_covariance(
    system: LinearSystem,
    bread: FloatArray,
    scores: Sequence[FloatArray],
    weights: Sequence[float | FloatArray] | FloatArray,
    instruments: bool = False,
) -> FloatArray:
    """Return the covariance (p, p) of an estimate, see `sandwich` and `jackknife`.

    Args:
        system: whose logs the scores belong to.
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        scores: s_i, (K, p) a log.
        weights: of the rows in that derivative, a number or (K,) a log.
        instruments: whether its rows are those of Z, on one side.
    """
    parts = [counts(e) for e in system.logs]
    numbers, p = _numbers(system.logs), len(bread)
    count = max(BLOCKS, *(1 + int(own.max(initial=0)) for own in numbers))
    products, sums = np.zeros((count, p, p)), np.zeros((count, p))
    for e, s, w, own in zip(system.logs, scores, weights, numbers, strict=True):
        W = e.W * np.reshape(w, (-1, 1))
        Z = e.Z * np.reshape(w, (-1, 1)) if instruments and e.Z is not None else W
        for b in np.unique(own):
            at = own == b
            products[b] += Z[at].T @ W[at]
            sums[b] += s[at].sum(axis=0)
    whole = long_run_covariance(system, bread, scores)
    return widened(whole, jackknife(bread, products, sums, parts))


def long_run_covariance(
    system: LinearSystem, bread: FloatArray, scores: Sequence[FloatArray]
) -> FloatArray:
    """Return the covariance (p, p) by `sandwich` alone; arguments as for `robust_covariance`."""
    parts = [counts(e) for e in system.logs]
    meat = sum(bartlett(s, part.lag) for s, part in zip(scores, parts, strict=True))
    return sandwich(bread, np.asarray(meat), parts)


def counts(e: Equations) -> Summary:
    """Return what the covariance has to know of equations: how many there are, and their lag."""
    return Summary(e.W[:0], len(e.y), e.correlation, joint=e.joint)


def sandwich(bread: FloatArray, meat: FloatArray, parts: Iterable[Summary]) -> FloatArray:
    """Return the covariance (p, p), robust to correlated residuals (Newey and West 1987).

        cov = c f^2 A [sum over logs, lags k of b_k s_i s_(i+k)'] A',    c = m/(m - p)

    with Bartlett weights b_k over eight times the rows that overlap, m windows that do not, and f
    the critical value at 5 % of Kiefer and Vogelsang (2005) over that of the normal law: the sum
    itself is uncertain where few independent stretches are summed.

    Args:
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        meat: what is in the brackets, (p, p).
        parts: the logs, of which rows and lags count.
    """
    stretches = m = 0.0
    for part in parts:
        stretches += part.rows / part.lag
        m += part.rows / max(part.correlation, 1)
    b = 1 / max(stretches, 1.0)
    wider = 1 + (2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96
    factor = wider**2 * m / max(m - len(bread), 1.0)
    return factor * (bread @ meat @ bread.T)


def jackknife(
    bread: FloatArray, products: FloatArray, sums: FloatArray, parts: Iterable[Summary]
) -> FloatArray:
    """Return the variances (p,) that an estimate has by how it changes without each block of time.

        var = f^2 (B - 1)/B sum over blocks of (d_b - mean d)^2,    d_b = (A^-1 - A_b^-1)^-1 s_b

    with A_b^-1 and s_b what block b adds to A^-1 and to the scores, and f Student's critical value
    at 5 % for B - 1 degrees of freedom over the normal law's (Efron and Tibshirani 1993, chapter
    11). What one block alone determines is left to the sandwich.

    Args:
        bread: A (p, p), inverse derivative of the estimating equations.
        products: (B, p, p) A_b^-1.
        sums: (B, p) s_b.
        parts: the logs: blocks of few independent rows are joined.
    """
    from scipy.special import stdtrit

    rows: dict[int | None, float] = {}
    for part in parts:
        if part.correlation:  # rows that are no series are blocks by themselves
            own = part.rows / part.correlation
            rows[part.joint] = rows.get(part.joint, 0.0) + own
    few = min(rows.values(), default=np.inf)
    while len(products) >= 2 * _FEWEST and few < _APART * len(products):
        products, sums = products[::2] + products[1::2], sums[::2] + sums[1::2]
    filled = np.any(products, axis=(1, 2))
    products, sums, count = products[filled], sums[filled], int(filled.sum())
    if count < 2:
        return np.zeros(len(bread))
    scale = np.sqrt(np.maximum(np.diag(bread), 1e-300))
    left = np.eye(len(bread)) - bread @ products * scale / scale[:, None]
    steps = np.linalg.pinv(left, rcond=_ALONE) @ (sums @ bread.T / scale)[..., None]
    spread = np.sum((steps[..., 0] - steps[..., 0].mean(axis=0)) ** 2, axis=0)
    wider = float(stdtrit(count - 1, 0.975)) / 1.96
    return np.asarray(wider**2 * (count - 1) / count * spread * scale**2)


def widened(covariance: FloatArray, variances: FloatArray) -> FloatArray:
    """Return a covariance whose deviations are at least those of some variances, (p,)."""
    own = np.maximum(np.diag(covariance), 1e-300)
    wider = np.sqrt(np.maximum(variances / own, 1.0))
    return np.asarray(covariance * np.outer(wider, wider))


def shares_of_time(spans: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the parts of all training time at which logs begin and end, from their stamps, s."""
    edges = np.cumsum([0.0, *(end - start for start, end in spans)])
    edges = edges / max(edges[-1], 1e-300)
    return [(float(a), float(b)) for a, b in pairwise(edges)]


def blocks_at(
    t: FloatArray, span: tuple[float, float], place: tuple[float, float]
) -> NDArray[np.intp]:
    """Return the block of time of each row.

    Args:
        t: (K,) times of the rows, s.
        span: when their log begins and ends, s.
        place: as `shares_of_time` has it.
    """
    part = (t - span[0]) / max(span[1] - span[0], 1e-300)
    whole = place[0] + part * (place[1] - place[0])
    return np.clip((whole * BLOCKS).astype(np.intp), 0, BLOCKS - 1)


def _numbers(logs: Sequence[Equations]) -> list[NDArray[np.intp]]:
    """Return the block of each row; rows that are no series are one block for each time."""
    if all(e.correlation == 0 for e in logs):
        names = sorted({(e.log, t) for e in logs for t in e.t.tolist()})
        known = {name: k for k, name in enumerate(names)}
        return [np.array([known[e.log, t] for t in e.t.tolist()], dtype=np.intp) for e in logs]
    spans: dict[str, tuple[float, float]] = {}
    for e in logs:
        own = e.span or (float(e.t.min(initial=np.inf)), float(e.t.max(initial=-np.inf)))
        old = spans.get(e.log, own)
        spans[e.log] = (min(own[0], old[0]), max(own[1], old[1]))
    place = dict(zip(spans, shares_of_time(spans.values()), strict=True))
    return [blocks_at(e.t, spans[e.log], place[e.log]) for e in logs]
