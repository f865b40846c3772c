"""Integrals of sampled signals over many windows of one length, as weights of the samples.

The integrand of an interval is the polynomial of degree five through the six samples around it. It
is exact up to that degree; the trapezoid rule would bias logs with a low sampling rate.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from symgen.data.raw import Places
from symgen.estimation.values import FloatArray

#: Samples of the polynomial of an interval.
POINTS = 6


def window_weights(samples: int, last: Places, length: int) -> FloatArray:
    """Return the weights of samples in integrals over windows, (K, samples), in steps.

    Args:
        samples: number of samples, in uniform steps.
        last: (K,) numbers of the samples at which windows end.
        length: length of the windows, samples.
    """
    return _until(samples, last) - _until(samples, last - length)


def _until(samples: int, at: Places) -> FloatArray:
    """Return the weights of samples in the integral up to some of them, up to a constant."""
    points = min(POINTS, samples)
    # samples before the interval; number of inner intervals
    before, inner = (points - 2) // 2, samples - points + 1
    numbers, inside = np.arange(samples), np.clip(at - before, 0, inner)
    out = np.zeros((len(at), samples))
    for k, weight in enumerate(_interval_weights(points, before)):
        out += weight * (numbers < inside[:, None] + k)
    head, tail = _edge(points, range(before)), _edge(points, range(before + 1, points - 1))
    out[:, :points] += head[np.minimum(at, before)]
    out[:, -points:] += tail[np.maximum(at - before - inner, 0)]
    return out


def _edge(points: int, intervals: range) -> FloatArray:
    """Return the weights of the samples at an end in its first 0, 1, .. intervals."""
    pieces = [_interval_weights(points, k) for k in intervals]
    return np.cumsum([np.zeros(points), *pieces], axis=0)


@cache
def _interval_weights(points: int, at: int) -> FloatArray:
    """Return the weights of some samples in the integral from sample `at` to the next."""
    powers = np.vander(np.arange(points) - at, points, increasing=True).astype(float)
    return np.linalg.solve(powers.T, 1.0 / np.arange(1, points + 1))
