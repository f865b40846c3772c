"""The clock of a recorder: repeated rows, and stamps with jitter."""

from __future__ import annotations

import numpy as np

from symgen.data.gaps import GAP
from symgen.data.log import Log
from symgen.data.mask import Bools, spans
from symgen.data.raw import FloatArray, Places
from symgen.faults.channels import FEW_DIGITS, last_digit

#: Step of a position after repeated rows, over the steps before and after.
_CATCHES_UP = 1.5


def stalled_rows(log: Log) -> Bools:
    """Return which rows repeat the previous row in all channels while the robot moves, (N,).

    A robot at rest, or slower than the last digit of its positions, also repeats rows. After a
    stall of the recorder, a position catches up: its step is larger than those before and after. If
    half of the short repetitions end like this, all of them are stalls.
    """
    same = np.ones(len(log.t) - 1, dtype=bool)
    for x in (log.q, log.qd, log.tau):
        if x is not None:
            same &= (x[1:] == x[:-1]).all(axis=1)
    fresh = np.flatnonzero(~np.concatenate([[False], same]))
    repeats = spans(same)
    place = np.searchsorted(fresh, repeats[:, 0])
    inside = (place > 0) & (place + 2 < len(fresh))
    repeats, place = repeats[inside], place[inside]
    before, first = fresh[place - 1], fresh[place]
    after, last = fresh[place + 1], fresh[place + 2]
    earlier, later = _rates(log.q, before, first), _rates(log.q, after, last)
    slower = np.maximum(earlier, later)
    step = np.abs(log.q[after] - log.q[first])
    digits = [FEW_DIGITS * last_digit(x) for x in log.q.T]
    far = (step >= _CATCHES_UP * slower) & (step > digits)
    stalls = np.asarray(far.any(axis=1))
    short = repeats[:, 1] - repeats[:, 0] < GAP
    if 2 * stalls[short].sum() >= short.sum():
        stalls |= short
    at = np.zeros(len(log.t), dtype=bool)
    for start, end in repeats[stalls]:
        at[start + 1 : end + 1] = True
    return at


def _rates(q: FloatArray, first: Places, last: Places) -> FloatArray:
    """Return the mean changes of positions from row to row between some rows, (K, n)."""
    rows = (last - first)[:, None]
    change = np.abs(q[last] - q[first])
    return np.asarray(change / rows)


def uniform_clock(t: FloatArray) -> FloatArray:
    """Return the uniform clock nearest to stamps (N,), with or without lost rows."""
    step = np.diff(t)
    ticks = np.maximum(np.round(step / np.median(step)), 1.0)
    lost = np.concatenate([[0.0], np.cumsum(ticks)])
    every = np.arange(len(t), dtype=float)
    clocks = [_line(every, t), _line(lost, t)]
    return min(clocks, key=lambda clock: float(np.median(np.abs(clock - t))))


def _line(index: FloatArray, t: FloatArray) -> FloatArray:
    """Return the line through stamps with the least absolute errors."""
    weight = np.ones(len(t))
    line = t
    for _ in range(8):  # reweighting removes the influence of late stamps
        slope, start = np.polyfit(index, t, 1, w=np.sqrt(weight))
        line = start + slope * index
        error = np.abs(t - line)
        weight = 1 / np.maximum(error, 1e-3 * slope)
    return line


def roughness(q: FloatArray, t: FloatArray) -> float:
    """Return the typical change of the speed from step to step, a geometric mean over the joints.

    Args:
        q: (N, n) positions.
        t: (N,) their times.
    """
    change = np.diff(q, axis=0)
    speed = change / np.diff(t)[:, None]
    rough = np.abs(np.diff(speed, axis=0))
    size = np.abs(change)
    moving = size >= np.maximum(np.median(size, axis=0), 1e-300)
    both = moving[1:] & moving[:-1]
    logs = []
    for x, at in zip(rough.T, both.T, strict=True):
        usual = np.median(x[at]) if at.any() else 0.0
        if usual > 0:
            logs.append(np.log(usual))
    return float(np.exp(np.mean(logs))) if logs else 0.0
