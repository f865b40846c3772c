"""Errors of a fit that are robust to a residual correlated in time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def covariance(free: FloatArray, error: FloatArray, block: NDArray[np.int64]) -> FloatArray:
    """Return the covariance (r, r) of a fit: sums of scores over blocks, and long-run variance.

    Args:
        free: columns (K, n, r), whitened.
        error: residual (K, n) of the fit.
        block: (K,) number of the block of each instant.
    """
    r = free.shape[2]
    bread = np.linalg.inv(np.einsum("kna,knb->ab", free, free))
    scores = np.einsum("kna,kn->ka", free, error)
    blocks = int(block.max()) + 1
    sums = np.zeros((blocks, r))
    np.add.at(sums, block, scores)
    small = blocks / max(blocks - r, 1)
    robust = small * bread @ (sums.T @ sums) @ bread
    long_run = long_run_variance(error, block)
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
