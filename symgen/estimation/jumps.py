"""Single samples that stand out of a signal: found, and taken out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import NORMAL

FloatArray = NDArray[np.float64]
#: A jump is so many times the scatter of its channel, and so many times what is around it.
_JUMP, _AROUND = 12.0, 4.0
_NEAR = 8  # samples around a jump that it is compared with
#: Jumps meet where this many pairs are expected; a signal with more jumps than so is one of jumps.
_MEET, _MANY, _PASSES = 0.1, 0.05, 4


def jumps(x: FloatArray) -> NDArray[np.int64]:
    """Return the numbers of single samples that stand out of their neighbours.

    r_k = x_k - median(x_(k-3) .. x_(k+3)) of a jump is the jump, and next to nothing at a step, as
    of friction at a reversal (Hampel 1974). It counts where |r_k| is 12 times the scatter of
    x_k - (x_(k-1) + x_(k+1))/2 (median absolute deviation, or the last digit), which knows how the
    signal bends, and 4 times all around. Where there are some, others that stood in their shade are
    looked for, and where there are so many that two meet by chance, two in a row. It leaves its
    neighbours on both sides to the same hand: the corner at which a torque falls from braking to
    standstill does not.
    """
    found: set[int] = set()
    for _ in range(_PASSES):
        meet = len(found) ** 2 > _MEET * len(x)
        more = _outstanding(x, 2 if meet else 1, 1 if found else 0)
        if len(more) == 0:
            break
        found.update(map(int, more))
        x = without(x, more)
        if len(found) > _MANY * len(x):  # this is the signal
            return np.zeros(0, dtype=np.int64)
    return np.array(sorted(found), dtype=np.int64)


def least_step(x: FloatArray) -> float:
    """Return the smallest step of a signal from a sample to the next that is none; inf without."""
    steps = np.abs(np.diff(x))
    return float(np.min(steps, where=steps > 0, initial=np.inf))


def _outstanding(x: FloatArray, together: int, others: int) -> NDArray[np.int64]:
    """Return the samples that stand out of those around.

    Args:
        x: the signal.
        together: that may stand out in a row.
        others: jumps that may be near.
    """
    none = np.zeros(0, dtype=np.int64)
    if len(x) < 2 * _NEAR:
        return none
    size = x[:-2] + x[2:]  # in place: long logs come this way
    size *= -0.5
    size += x[1:-1]
    np.abs(size, out=size)
    largest = float(size.max())
    # Most are so large that the median is: nothing stands out, and nothing has to be sorted.
    if 2 * np.count_nonzero(size >= 2 * largest / (_JUMP * NORMAL)) > len(size):
        return none
    digit = least_step(x)
    scatter = NORMAL * float(np.median(size))
    least = _JUMP * max(scatter, digit if np.isfinite(digit) else 0.0)
    if least == 0.0 or largest <= least / 2:
        return none
    windows = np.lib.stride_tricks.sliding_window_view
    r: FloatArray = np.zeros(len(x))
    r[3:-3] = np.abs(x[3:-3] - np.median(windows(x, 7), axis=1))
    out: list[int] = []
    for k in np.flatnonzero(r > least):
        low, high = max(k - _NEAR, 0), min(k + _NEAR + 1, len(x))
        first, end = max(k - together + 1, 0), k + together
        near = np.concatenate([r[low:first], r[end:high]])
        if _there_and_back(x, int(k), together) < r[k] / 2:
            continue  # the corner of a signal that goes on elsewhere
        if r[k] > _AROUND * float(np.sort(near)[-1 - others]):
            out.append(int(k))
    return np.array(out, dtype=np.int64)


def _there_and_back(x: FloatArray, k: int, together: int) -> float:
    """Return by how much a sample stands out of both sides to the same hand.

    Of what a side leads to: its nearest sample, or the line through two, whichever is nearer.
    """
    sides = []
    for way in (-1, 1):
        found = []
        for s in range(1, together + 1):
            last, before = x[k + way * s], x[k + way * (s + 1)]
            away = x[k] - np.array([last, last + s * (last - before)])
            found.append(float(away[np.argmin(np.abs(away))]))
        sides.append(max(found, key=abs))
    left, right = sides
    return min(abs(left), abs(right)) if left * right > 0 else 0.0


def without(x: FloatArray, at: NDArray[np.int64]) -> FloatArray:
    """Return a signal with some samples on the line between those around."""
    good = np.setdiff1d(np.arange(len(x)), at)
    out = x.copy()
    out[at] = np.interp(at, good, x[good])
    return out
