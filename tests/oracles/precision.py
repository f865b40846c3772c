"""The covariance of an estimate by hand: long-run sums of scores, and white noise as the least."""

from __future__ import annotations

import numpy as np


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


def at_least_white(
    covariance: np.ndarray,
    bread: np.ndarray,
    W: np.ndarray,
    y: np.ndarray,
    independent: float = 0.0,
    Z: np.ndarray | None = None,
) -> np.ndarray:
    """A covariance whose deviations are at least those of white noise in the rows of one joint.

    Args:
        covariance, bread: of the estimate, (p, p).
        W, y: rows of all logs of the joint, weighed.
        independent: of these rows, as they share samples; 0 for all.
        Z: instruments, weighed.
    """
    left = y - W @ np.linalg.lstsq(W, y, rcond=None)[0]
    variance = left @ left / (len(y) - W.shape[1]) * (len(y) / (independent or len(y)))
    own = W if Z is None else Z
    white = variance * bread @ own.T @ own @ bread.T
    scale = np.sqrt(np.maximum(np.diag(white) / np.diag(covariance), 1.0))
    return np.asarray(covariance * np.outer(scale, scale))
