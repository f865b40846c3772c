"""Integrals of sampled signals, along the log or over many windows of one length.

The integrand of an interval is the polynomial of degree five through the six samples around it. It
is exact up to that degree; the trapezoid rule would bias logs with a low sampling rate.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from symgen.data.raw import Places
from symgen.estimation.values import FloatArray

#: Samples of the polynomial of an interval.
POINTS = 6


def over_windows(y: FloatArray, step: float, last: Places, length: int) -> FloatArray:
    """Integrate over windows of `length` samples.

    One running sum serves all windows. The polynomials are evaluated at the window ends only.

    Args:
        y: (N, ...) signal in uniform steps.
        step: sampling step in s.
        last: (K,) numbers of the samples at which windows end.
        length: length of the windows, samples.

    Returns:
        (K, ...).
    """
    until = _integral(y.reshape(len(y), -1))
    out = step * (until(last) - until(last - length))
    return out.reshape(len(last), *y.shape[1:])


def _integral(y: FloatArray) -> Callable[[Places], FloatArray]:
    """Return a function from samples (K,) to the integral of y (N, n) up to them, (K, n).

    The function has an arbitrary constant, and the step as its unit of time.
    """
    points = min(POINTS, len(y))
    # samples before the interval; number of inner intervals
    before, inner = (points - 2) // 2, len(y) - points + 1
    sums = np.zeros((len(y) + 1, y.shape[1]))
    np.cumsum(y, axis=0, out=sums[1:])
    weights = _interval_weights(points, before)
    head = _edge(y[:points], range(before))
    tail = _edge(y[-points:], range(before + 1, points - 1))

    def until(at: Places) -> FloatArray:
        inside = np.clip(at - before, 0, inner)
        middle = sum(w * sums[inside + k] for k, w in enumerate(weights))
        edge = head[np.minimum(at, before)] + tail[np.maximum(at - before - inner, 0)]
        return np.asarray(middle + edge)

    return until


def _edge(y: FloatArray, intervals: range) -> FloatArray:
    """Return the integral over the first 0, 1, .. of some intervals at an end, (k + 1, n)."""
    pieces = [_interval_weights(len(y), k) @ y for k in intervals]
    return np.cumsum([np.zeros(y.shape[1]), *pieces], axis=0)


@cache
def _interval_weights(points: int, at: int) -> FloatArray:
    """Return the weights of some samples in the integral from sample `at` to the next."""
    powers = np.vander(np.arange(points) - at, points, increasing=True).astype(float)
    return np.linalg.solve(powers.T, 1.0 / np.arange(1, points + 1))
