"""The covariance of an estimate, robust to correlated residuals and to what a model misses.

Residuals that are correlated in time are summed up over neighbours (Newey and West 1987). What a
model misses comes back whenever the robot comes by, so that no sum over neighbours tells it: it is
taken as a random function of the motion's state (`features`), whose size is estimated joint by
joint from the residual. The two parts add up.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.estimation.summary import Summary, nonzero_columns
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import FloatArray

_RANK = 1e-10  # of a matrix of products: eigenvalues below are zero


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
) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of an estimate, (p, p) each: of noise, and of what the model misses.

    Args:
        system: whose logs the scores belong to.
        bread: A (p, p), inverse derivative of the estimating equations sum s_i(X) = 0.
        scores: s_i, (K, p) a log.
        weights: of the rows in that derivative, a number or (K,) a log.
        instruments: whether its rows are those of Z, on one side.
    """
    pairs = zip(system.logs, weights, strict=True)
    parts = [Products.of(e, w, instruments) for e, w in pairs if e.features is not None]
    noise = long_run_covariance(system, bread, scores)
    return noise, misfit_covariance(bread, parts)


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


@dataclass(frozen=True, eq=False)
class Products:
    """What the covariance of a misfit has to know of the weighted equations of one joint of a log.

    Attributes:
        joint: its position, None for energy.
        rows, correlation: see `Summary`.
        gram: [W F y]'[W F y] with F the random functions, (p + m + 1, p + m + 1).
        cross: W'F, or Z'F of instruments Z, (p, m).
    """

    joint: int | None
    rows: int
    correlation: int
    gram: FloatArray
    cross: FloatArray

    @classmethod
    def of(cls, e: Equations, weight: float | FloatArray, instruments: bool = False) -> Products:
        """Return those of equations; arguments as for `robust_covariance`."""
        assert e.features is not None
        whole = np.column_stack([e.W, e.features, e.y]) * np.reshape(weight, (-1, 1))
        gram, p = whole.T @ whole, e.W.shape[1]
        cross = gram[:p, p:-1]
        if instruments and e.Z is not None:
            cross = (e.Z * np.reshape(weight, (-1, 1))).T @ whole[:, p:-1]
        return cls(e.joint, len(e.y), e.correlation, gram, cross)

    @classmethod
    def of_summary(cls, s: Summary, weight: float) -> Products:
        """Return those of a summary."""
        assert s.features is not None
        own, m = s.factor.T @ s.factor, len(s.features)
        p, beside = len(own) - 1, np.delete(s.features, np.s_[-m - 1 : -1], axis=1)
        gram = np.insert(own, [p] * m, beside.T, axis=1)
        gram = np.insert(gram, [p] * m, s.features, axis=0)
        return cls(s.joint, s.rows, s.correlation, weight**2 * gram, weight**2 * beside[:, :-1].T)

    def __add__(self, other: Products) -> Products:
        return replace(
            self,
            rows=self.rows + other.rows,
            gram=self.gram + other.gram,
            cross=self.cross + other.cross,
        )


def misfit_covariance(bread: FloatArray, parts: Iterable[Products]) -> FloatArray:
    """Return the covariance (p, p) that an unknown function of the motion's state gives X.

        cov = sum over joints of s_j^2 (A W_j'F_j) (A W_j'F_j)'

    with F the random functions, whose coefficients have the deviation s_j: one function for each
    joint, the same in all logs.

    Args:
        bread: A (p, p), inverse derivative of the estimating equations.
        parts: by log and joint; none where functions are not known.
    """
    joints: dict[int | None, Products] = {}
    for part in parts:
        known = joints.get(part.joint)
        joints[part.joint] = part if known is None else known + part
    out = np.zeros_like(bread)
    for own in joints.values():
        moved = bread @ own.cross
        out += misfit_variance(own) * (moved @ moved.T)
    return out


def misfit_variance(own: Products) -> float:
    """Return s^2 of the coefficients of random functions, by restricted likelihood.

        y = W X + F c + e,   c of variance s^2,   e of variance sigma^2, rows counted once

    in what is left of y beside W, where X has no say (Patterson and Thompson 1971). With the
    eigenvalues l_k of F'F beside W, and z_k the share of y in their directions, z_k has the
    variance s^2 l_k + sigma^2; what is left beside F, too, has sigma^2 alone. s^2 is the mean over
    the likelihood of s/sigma.
    """
    p = len(own.cross)
    gram, scale = own.gram[p:, p:], np.sqrt(np.maximum(np.diag(own.gram)[:p], 0.0))
    scale = np.where(scale > 0, scale, np.inf)
    values, vectors = np.linalg.eigh(own.gram[:p, :p] / np.outer(scale, scale))
    kept = values > _RANK * values[-1]
    beside = (vectors[:, kept].T / np.sqrt(values[kept])[:, None] / scale) @ own.gram[:p, p:]
    gram = gram - beside.T @ beside
    shown, directions = np.linalg.eigh(gram[:-1, :-1])
    seen = shown > _RANK * np.trace(own.gram[p:-1, p:-1])
    shown, z = shown[seen], (directions.T @ gram[:-1, -1])[seen]
    z2 = z**2 / shown
    each = max(own.correlation, 1)  # rows that count once
    free = own.rows - kept.sum() - seen.sum()
    left = max(gram[-1, -1] - z2.sum(), 0.0)
    count = max(free / each, 0.0)
    noise = left / count if free > 0 and count > 0 else 0.0
    ratio = np.append(0.0, np.geomspace(1e-4, 1e6, 101) / max(shown.max(initial=0.0), 1e-300))
    spread = 1 + ratio[:, None] * shown
    sigma2 = np.maximum((np.sum(z2 / spread, axis=1) + count * noise) / (count + len(z2)), 1e-300)
    fit = -0.5 * (np.log(spread).sum(axis=1) + (count + len(z2)) * np.log(sigma2))
    likely = np.exp(fit - fit.max())
    return float(np.sum(likely * ratio * sigma2) / likely.sum())
