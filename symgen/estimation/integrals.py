"""Integrals of sampled signals, along the log or over many windows of one length.

The integrand of an interval is the polynomial of degree five through the six samples around it. It
is exact up to that degree; the trapezoid rule would bias logs with a low sampling rate.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
    flat = y.reshape(len(y), -1)
    sums = np.zeros((len(y) + 1, flat.shape[1]))
    np.cumsum(flat, axis=0, out=sums[1:])
    ends = flat[:POINTS], flat[-POINTS:]
    until = _integral(len(y), lambda at: sums[at], ends)
    out = step * (until(last) - until(last - length))
    return out.reshape(len(last), *y.shape[1:])


def window_weights(samples: int, last: Places, length: int) -> FloatArray:
    """Return the weights of some samples in the integrals over windows, (K, samples).

    Args:
        samples: number of samples.
        last, length: as in `over_windows`; the step is the unit of time.
    """
    numbers, points = np.arange(samples), min(POINTS, samples)
    ends = np.eye(points, samples), np.eye(points, samples, samples - points)
    until = _integral(samples, lambda at: numbers < at[:, None], ends)
    return until(last) - until(last - length)


def _integral(
    samples: int,
    sums: Callable[[Places], NDArray[Any]],
    ends: tuple[FloatArray, FloatArray],
) -> Callable[[Places], FloatArray]:
    """Return a function from samples (K,) to the integral of a signal up to them, (K, n).

    The function has an arbitrary constant, and the step as its unit of time.

    Args:
        samples: number of samples.
        sums: returns the sums of the samples before some, (K, n).
        ends: the first and the last samples, at most POINTS, with n values each.
    """
    points = min(POINTS, samples)
    # samples before the interval; number of inner intervals
    before, inner = (points - 2) // 2, samples - points + 1
    weights = _interval_weights(points, before)
    head = _edge(ends[0], range(before))
    tail = _edge(ends[1], range(before + 1, points - 1))

    def until(at: Places) -> FloatArray:
        inside = np.clip(at - before, 0, inner)
        middle = sum(w * sums(inside + k) for k, w in enumerate(weights))
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
