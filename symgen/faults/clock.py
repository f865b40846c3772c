"""The clock of a recorder: repeated rows, and stamps with jitter."""

from __future__ import annotations

import numpy as np

from symgen.data.gaps import GAP
from symgen.data.log import Log
from symgen.data.mask import Bools, spans
from symgen.data.raw import FloatArray
from symgen.faults.channels import FEW_DIGITS, least_step

#: Step of a position after held rows, over the steps before and after.
_CATCHES_UP = 1.5


def stalled_rows(log: Log) -> Bools:
    """Return which rows repeat the previous row in all channels while the robot moves, (N,).

    A robot at rest, or slower than the last digit of its positions, also repeats rows. After a
    stall of the recorder, a position catches up: its step is larger than those before and after. If
    half of the short repetitions end like this, all of them are stalls.
    """
    same = np.ones(len(log.t) - 1, dtype=bool)
    for x in (log.q, log.qd, log.tau):
        for column in x.T if x is not None else ():
            same &= column[1:] == column[:-1]
    fresh = np.flatnonzero(np.concatenate([[True], ~same]))
    repeats = spans(same)
    place = np.searchsorted(fresh, repeats[:, 0])
    inside = (place > 0) & (place + 2 < len(fresh))
    repeats, place = repeats[inside], place[inside]
    before, first, after, last = (fresh[place + k] for k in (-1, 0, 1, 2))
    slow = np.abs(log.q[first] - log.q[before]) / (first - before)[:, None]
    later = np.abs(log.q[last] - log.q[after]) / (last - after)[:, None]
    step = np.abs(log.q[after] - log.q[first])
    digits = FEW_DIGITS * np.array([least_step(x) for x in log.q.T])
    far = (step >= _CATCHES_UP * np.maximum(slow, later)) & (step > digits)
    stalls = far.any(axis=1)
    short = repeats[:, 1] - repeats[:, 0] < GAP
    if 2 * stalls[short].sum() >= short.sum():
        stalls |= short
    at = np.zeros(len(log.t), dtype=bool)
    for start, end in repeats[stalls]:
        at[start + 1 : end + 1] = True
    return at


def uniform_clock(t: FloatArray) -> FloatArray:
    """Return the uniform clock nearest to stamps (N,), with or without lost rows."""
    step = np.diff(t)
    lost = np.cumsum(np.maximum(np.round(step / np.median(step)), 1.0))
    counts = np.arange(len(t), dtype=float), np.concatenate([[0.0], lost])
    clocks = [_line(count, t) for count in counts]
    return min(clocks, key=lambda clock: float(np.median(np.abs(clock - t))))


def _line(index: FloatArray, t: FloatArray) -> FloatArray:
    """Return the line through stamps with the least absolute errors."""
    weight = np.ones(len(t))
    line = t
    for _ in range(8):  # reweighting removes the influence of late stamps
        slope, start = np.polyfit(index, t, 1, w=np.sqrt(weight))
        line = start + slope * index
        weight = 1 / np.maximum(np.abs(t - line), 1e-3 * slope)
    return line


def roughness(q: FloatArray, t: FloatArray) -> float:
    """Return the typical change of the speed from step to step, a geometric mean over the joints.

    Args:
        q: (N, n) positions.
        t: (N,) their times.
    """
    change = np.diff(q, axis=0)
    moving = np.abs(change) >= np.maximum(np.median(np.abs(change), axis=0), 1e-300)
    rough = np.abs(np.diff(change / np.diff(t)[:, None], axis=0))
    both = moving[1:] & moving[:-1]
    sizes = [np.median(x[at]) for x, at in zip(rough.T, both.T, strict=True) if at.any()]
    sizes = [size for size in sizes if size > 0]
    return float(np.exp(np.mean(np.log(sizes)))) if sizes else 0.0
