"""Evidence of faults in one channel of a log: runs, last digit, outliers, wraps and clipping."""

from __future__ import annotations

import math

import numpy as np

from symgen.data.mask import Bools
from symgen.data.raw import FloatArray, Places
from symgen.data.signals import NORMAL

#: A channel that stays within this many of its last digits does not move.
FEW_DIGITS = 5
#: Smallest outlier over the scatter of its channel, and over the steps around it.
_JUMP, _AROUND = 12.0, 4.0
_NEAR = 8  # samples on each side of an outlier to compare with
_MANY = 0.05  # share of outliers above which they belong to the signal
#: Largest step of a channel that wraps, in periods.
_SLOW = 1 / 6
#: Bits of the integers in recorders.
_BITS = (8, 15, 16, 32)
#: For a channel that holds its values: smallest number of runs, share of runs with exactly its
#: length, and share with nearly this length.
_HOLDS, _PACED, _NEARLY = 20, 0.4, 0.9
#: Smallest step over the usual one, and distance between two steps in samples.
_STEP, _APART = 5.0, 5
#: For a clipped channel, samples at the extreme: in total, over those one digit below, and in a
#: row.
_FLAT, _PILED, _RUN = 10, 4.0, 3


def last_digit(x: FloatArray) -> float:
    """Return the last digit of a channel: the smallest non-zero step; inf if there is none."""
    steps = np.abs(np.diff(x))
    return float(np.min(steps, where=steps > 0, initial=np.inf))


def usual_step(x: FloatArray) -> float:
    """Return the 99th percentile of the steps of a channel; inf if it never changes."""
    size = np.abs(np.diff(x))
    size = size[size > 0]
    return float(np.quantile(size, 0.99)) if len(size) else np.inf


def moves(x: FloatArray) -> bool:
    """Return whether a position moves beyond a few of its last digits."""
    return bool(np.ptp(x) > FEW_DIGITS * last_digit(x))


def runs(x: FloatArray) -> tuple[Places, Places]:
    """Return where each run of one value starts, and its length in samples."""
    changed = x[1:] != x[:-1]
    first = np.flatnonzero(np.concatenate([[True], changed]))
    return first, np.diff(first, append=len(x))


def outliers(x: FloatArray) -> Places:
    """Return the indices of single samples that stand out from their neighbours.

    An outlier differs from both neighbours in the same direction. The difference exceeds four
    limits: 12 times the usual distance of a sample from the mean of its neighbours, 12 last digits,
    4 times the adjacent steps, and 4 times the third largest step around it. The two largest steps
    may belong to another outlier.

    Args:
        x: (N,) the channel.
    """
    none = np.zeros(0, dtype=np.int64)
    if len(x) < 2 * _NEAR:
        return none
    d = np.diff(x)
    size = np.abs(d)
    before, after = d[:-1], -d[1:]
    smaller = np.minimum(size[:-1], size[1:])
    height = np.where(before * after > 0, smaller, 0.0)
    changes = (before != 0) | (after != 0)
    usual = 0.0
    if changes.any():
        usual = float(np.median(np.abs(before + after)[changes])) / 2
    smallest = _JUMP * max(NORMAL * usual, last_digit(x))
    indices = []
    for k in np.flatnonzero(height > smallest) + 1:
        left = size[max(k - _NEAR, 0) : k - 1]
        right = size[k + 1 : k + _NEAR]
        around = np.sort(np.concatenate([left, right]))
        adjacent = np.concatenate([left[-1:], right[:1]])
        if height[k - 1] > _AROUND * max(around[-3], adjacent.max(initial=0)):
            indices.append(int(k))
    if len(indices) > _MANY * len(x):
        return none
    return np.array(indices, dtype=np.int64)


def without(x: FloatArray, at: Places) -> FloatArray:
    """Return a channel with some samples replaced by interpolation."""
    good = np.setdiff1d(np.arange(len(x)), at)
    out = x.copy()
    out[at] = np.interp(at, good, x[good])
    return out


def unwrapped(x: FloatArray, period: float) -> FloatArray | None:
    """Return a slow channel without jumps of a period; None if it has no jumps or is not slow."""
    if np.abs(np.diff(x)).max() <= period / 2:
        return None
    y = np.unwrap(x, period=period)
    slow = np.abs(np.diff(y)).max() <= _SLOW * period
    return y if slow else None


def signed(x: FloatArray) -> FloatArray | None:
    """Return counts stored as unsigned integers with their sign; None if they have it already.

    Negative counts of b bits are stored as their value plus 2^b.
    """
    small = np.unique(x[x < x.max() / 2])  # its last digit is exact
    if x.min() < 0 or len(small) <= 1:
        return None
    digit = float(np.diff(small).min())
    for bits in _BITS:
        period = math.ldexp(digit, bits)
        y = unwrapped(x, period) if x.max() < period else None
        if y is not None:
            turns = np.round(np.median(y) / period)
            return y - period * turns
    return None


def hold_length(x: FloatArray) -> int:
    """Return the number of samples for which a channel holds each value; 1 if it does not.

    Two fifths of its runs have this length, and nine tenths differ from it by at most one sample.
    Longer runs, of a robot at rest, are not counted. A coarse channel has runs of all lengths.
    """
    _, lengths = runs(x)
    k = round(float(np.median(lengths)))
    short = lengths[lengths <= 2 * k + 1]
    if k == 1 or len(short) < _HOLDS:
        return 1
    exact = np.mean(short == k)
    near = np.mean(np.abs(short - k) <= 1)
    return k if exact >= _PACED and near >= _NEARLY else 1


def clipped(x: FloatArray) -> Bools:
    """Return where a channel is clipped, (N,): samples that accumulate at an extreme.

    A peak that is rounded to its last digit has nearly as many samples one digit below. A held or
    coarse channel also keeps its other values for as long.
    """
    out = np.zeros(len(x), dtype=bool)
    first, lengths = runs(x)
    most = float(np.abs(x).max())
    for y in (x, -x):
        top, bottom = float(y.max()), float(y.min())
        at = y >= top - 1e-9 * abs(top)
        others = lengths[~at[first]]
        if top < 0.5 * most or at.sum() < _FLAT or len(others) == 0:
            continue
        levels = np.unique(y[y > top - 0.1 * (top - bottom)])
        digit = np.diff(levels)[-1] if len(levels) > 1 else 0.0
        near = int(np.sum(y >= top - 1.5 * digit))
        below = near - int(at.sum())
        usual = float(np.percentile(others, 90))
        longest = lengths[at[first]].max()
        piled = at.sum() > _PILED * max(below, 1)
        if piled and at.sum() >= _FLAT * usual and longest >= _RUN * usual:
            out |= at
    return out


def steps(x: FloatArray) -> Places:
    """Return the samples after which a channel steps by five times its usual step."""
    d = np.diff(x)
    others = [np.roll(d, k) for k in (-3, -2, -1, 1, 2, 3)]
    excess = np.abs(d - np.median(others, axis=0))
    large = excess > _STEP * usual_step(x)
    indices = np.flatnonzero(large[3:-3]) + 3
    # A step and its return count as one.
    distance = np.diff(indices, prepend=-_APART - 1)
    return indices[distance > _APART]
