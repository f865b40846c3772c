"""The covariance of an estimate by hand: long-run sums of scores, and the jackknife over blocks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.stats

BLOCKS = 20


def wider(*lagged: tuple[int, int]) -> float:
    """Critical values of Kiefer and Vogelsang (2005), table 1, over that of the normal law."""
    b = 1 / sum(rows / lag for rows, lag in lagged)
    return (1.96 + 2.9694 * b + 0.4160 * b**2 - 0.5324 * b**3) / 1.96


def long_run(s: np.ndarray, lag: int) -> np.ndarray:
    """Products of scores with those of up to `lag` - 1 rows later, by Bartlett's weights."""
    out = s.T @ s
    for k in range(1, lag):
        out += (1 - k / lag) * (s[k:].T @ s[:-k] + s[:-k].T @ s[k:])
    return out


def blocks(times: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The block of each row of logs that follow each other: twenty of one length in all."""
    lengths = [t[-1] - t[0] for t in times]
    before = np.cumsum([0.0, *lengths[:-1]])
    parts = [(b + t - t[0]) / sum(lengths) for b, t in zip(before, times, strict=True)]
    return [np.minimum((BLOCKS * part).astype(int), BLOCKS - 1) for part in parts]


def jackknifed(
    covariance: np.ndarray,
    bread: np.ndarray,
    scores: Sequence[np.ndarray],
    slopes: Sequence[tuple[np.ndarray, np.ndarray]],
    numbers: Sequence[np.ndarray],
) -> np.ndarray:
    """A covariance whose deviations are at least those of estimates without each block.

    Args:
        covariance, bread: of the estimate, (p, p).
        scores: (K, p) a log.
        slopes: rows whose products are the inverse of the bread: those of Z and W, weighed.
        numbers: block of each row.
    """
    whole, count = np.linalg.inv(bread), 1 + max(int(n.max()) for n in numbers)
    steps = []
    for b in range(count):
        at = [n == b for n in numbers]
        if not any(a.any() for a in at):
            continue
        own = sum(Z[a].T @ W[a] for (Z, W), a in zip(slopes, at, strict=True))
        change = sum(s[a].sum(axis=0) for s, a in zip(scores, at, strict=True))
        steps.append(np.linalg.solve(whole - own, change))
    spread = np.sum((np.array(steps) - np.mean(steps, axis=0)) ** 2, axis=0)
    critical = scipy.stats.t.ppf(0.975, len(steps) - 1) / 1.96
    variances = critical**2 * (len(steps) - 1) / len(steps) * spread
    scale = np.sqrt(np.maximum(variances / np.diag(covariance), 1.0))
    return np.asarray(covariance * np.outer(scale, scale))
