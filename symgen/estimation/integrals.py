"""Integrals of sampled signals: along a whole log, and over many windows of one length.

Every interval between samples takes the integral of the polynomial of degree five through the six
samples around it: exact up to that degree, where the trapezoid biases coarse logs.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.values import FloatArray

#: Samples of the polynomial of an interval.
POINTS = 6
_TOGETHER = 16  # windows that one product integrates


def cumulative_integral(y: FloatArray, step: float) -> FloatArray:
    """Integrate from the first sample to each one: F_k = int from t_0 to t_k of y dt.

    Every interval takes the integral of the polynomial of degree five through the six samples
    around it: exact up to that degree, where the trapezoid biases coarse logs.

    Args:
        y: (N, ...) signal in uniform steps, N at least 2.
        step: sampling step in s.

    Returns:
        The integral, of the shape of y, zero at the first sample.
    """
    until = _integral(y.reshape(len(y), -1))
    at = np.arange(len(y))
    return np.asarray(step * (until(at) - until(at[:1]))).reshape(y.shape)


def over_windows(y: FloatArray, step: float, last: NDArray[np.int64], length: int) -> FloatArray:
    """Integrate over windows of `length` samples that end with some, as `cumulative_integral` does.

    The sum of the samples before is gone through once; the polynomials are taken at the ends alone.

    Args:
        y: (N, n) signal in uniform steps.
        step: sampling step in s.
        last: (K,) numbers of the samples at which windows end.
        length: of the windows, samples.

    Returns:
        (K, n).
    """
    until = _integral(y)
    return np.asarray(step * (until(last) - until(last - length)))


def _integral(y: FloatArray) -> Callable[[NDArray[np.int64]], FloatArray]:
    """Return a function from samples (K,) to the integral of y (N, n) up to them, (K, n).

    It has a constant of its own, and the step as its unit.
    """
    points, before, inner = _interior(len(y))
    sums = np.zeros((len(y) + 1, y.shape[1]))
    np.cumsum(y, axis=0, out=sums[1:])
    weights = _interval_weights(points, before)
    head = _edge(y[:points], range(before))
    tail = _edge(y[-points:], range(before + 1, points - 1))

    def until(at: NDArray[np.int64]) -> FloatArray:
        inside = np.clip(at - before, 0, inner)
        middle = sum(w * sums[inside + k] for k, w in enumerate(weights))
        edge = head[np.minimum(at, before)] + tail[np.maximum(at - before - inner, 0)]
        return np.asarray(middle + edge)

    return until


def _interior(samples: int) -> tuple[int, int, int]:
    """Return the samples of a polynomial, how many lie before its interval, and its intervals."""
    points = min(POINTS, samples)
    return points, (points - 2) // 2, samples - points + 1


def _edge(y: FloatArray, intervals: range) -> FloatArray:
    """Return the integral over the first 0, 1, .. of some intervals at an end, (k + 1, n)."""
    pieces = [_interval_weights(len(y), k) @ y for k in intervals]
    return np.cumsum([np.zeros(y.shape[1]), *pieces], axis=0)


class Integrals:
    """Integrals over windows of nodes, as those of `cumulative_integral`: products with a band."""

    def __init__(self, nodes: int, steps: int) -> None:
        """Take the number of nodes, and those of a window."""
        self._nodes, self._steps = nodes, steps
        self._inner: dict[tuple[int, int, int], FloatArray] = {}

    def __call__(self, ends: slice, span: slice, y: FloatArray) -> FloatArray:
        """Integrate, in steps from node to node.

        Args:
            ends: nodes at which windows end.
            span: nodes at which y is known.
            y: (nodes of the span, ...).
        """
        last = np.arange(ends.start, ends.stop, ends.step)
        flat = y.reshape(len(y), -1)
        out = np.empty((len(last), flat.shape[1]))
        for first in range(0, len(last) if flat.shape[1] else 0, _TOGETHER):
            own = last[first : first + _TOGETHER]
            low = max(int(own[0]) - self._steps - POINTS, span.start)
            high = min(int(own[-1]) + POINTS + 1, span.stop)
            inside = flat[low - span.start : high - span.start]
            np.matmul(self._weights(own, low, high), inside, out=out[first : first + len(own)])
        return out.reshape(len(last), *y.shape[1:])

    def _weights(self, last: NDArray[np.int64], low: int, high: int) -> FloatArray:
        """Return the weights of nodes low .. high in windows, (K, high - low)."""
        points, before, inner = _interior(self._nodes)
        begins = last - self._steps
        whole = begins[0] >= before and last[-1] <= before + inner
        key = (len(last), int(last[0]) - low, high - low)
        if whole and key in self._inner:
            return self._inner[key]
        out, own = np.zeros((len(last), high - low)), _interval_weights(points, before)
        for row, begin, end in zip(out, begins, last, strict=True):
            first, behind = max(begin, before), min(end, before + inner)
            if behind > first:
                at = first - before - low
                row[at : at + behind - first + points - 1] += np.convolve(
                    np.ones(behind - first), own
                )
            for k in (*range(begin, min(before, end)), *range(max(begin, before + inner), end)):
                start = 0 if k < before else self._nodes - points
                row[start - low : start - low + points] += _interval_weights(points, k - start)
        if whole:
            self._inner[key] = out
        return out


@cache
def _interval_weights(points: int, at: int) -> FloatArray:
    """Return the weights of some samples in the integral from sample `at` to the next."""
    powers = np.vander(np.arange(points) - at, points, increasing=True).astype(float)
    return np.linalg.solve(powers.T, 1.0 / np.arange(1, points + 1))
