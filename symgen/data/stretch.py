"""Where samples of a log are missing, by its stamps, and the rows between which none are."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from symgen.data.raw import FloatArray, Places

#: A step of this many medians is a hole in the log, which no interpolation may fill.
GAP = 10.0
_MADE_GOOD = 100  # samples after a wide step that are looked at


def holes(t: FloatArray, step: float) -> Places:
    """Return after which samples others are missing: those before a step of over GAP steps.

    Stamps of a busy host come late and then several at once: where the samples after a wide step
    make it good within some ten times GAP of them, but for half of GAP, none is missing.

    Args:
        t: (N,) times, s.
        step: between samples, s.
    """
    wide = np.flatnonzero(np.diff(t) > GAP * step)
    missing = []
    for k in wide:
        after = t[k + 1 : k + 1 + _MADE_GOOD]
        missing.append(np.min((after - t[k]) / step - np.arange(1, len(after) + 1)))
    return np.asarray(wide[np.array(missing, dtype=float) > GAP / 2], dtype=np.int64)


@dataclass(frozen=True)
class Stretch:
    """Rows of a file between which no time is missing.

    Attributes:
        file: name or URL.
        name: of the log.
        rows: first row, and the one behind the last.
        times: of its first and last row, s.
        step: sampling step, s.
        measured: whether the file has speeds.
    """

    file: str
    name: str
    rows: tuple[int, int]
    times: tuple[float, float]
    step: float
    measured: bool

    @property
    def count(self) -> int:
        """Number of rows."""
        return self.rows[1] - self.rows[0]

    def between(self, first: int, last: int) -> Stretch:
        """Return the rows from one to another of the file, by its step."""
        begin, end = (self.times[0] + self.step * (k - self.rows[0]) for k in (first, last - 1))
        return replace(self, rows=(first, last), times=(begin, end))


def within(s: Stretch, low: float, high: float) -> Stretch:
    """Return the rows of a stretch between two times, by its step."""
    if low <= s.times[0] and high >= s.times[1]:
        return s
    first, last = s.rows
    if low > s.times[0]:
        first = min(first + math.ceil((low - s.times[0]) / s.step - 1e-6), last)
    if high < s.times[1]:
        last = s.rows[0] + math.floor((high - s.times[0]) / s.step + 1e-6) + 1
    return s.between(first, max(last, first))
