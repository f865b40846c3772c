"""Gaps in the time stamps of a log, and the stretches without gaps."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from symgen.data.raw import FloatArray, Places
from symgen.data.units import IN_SI, Units

#: A time step of this many medians is a gap; no interpolation may fill it.
GAP = 10.0
_MADE_GOOD = 100  # samples to check after a wide step


def holes(t: FloatArray, step: float, longest: float | None = None) -> Places:
    """Return the samples before a gap: a time step above a limit.

    A busy host writes stamps late, and then several at once. If the following samples catch up with
    the clock, up to half of the limit, there is no gap.

    Args:
        t: (N,) times, s.
        step: sampling step, s.
        longest: the limit, s; GAP steps by default.
    """
    longest = longest or GAP * step
    wide = np.flatnonzero(np.diff(t) > longest)
    missing = []
    for k in wide:
        after = t[k + 1 : k + 1 + _MADE_GOOD]
        missing.append(np.min((after - t[k]) / step - np.arange(1, len(after) + 1)))
    return np.asarray(wide[step * np.array(missing, dtype=float) > longest / 2], dtype=np.int64)


@dataclass(frozen=True)
class Stretch:
    """Rows of a file without a gap in time.

    Attributes:
        file: name or URL.
        name: name of the log.
        rows: first row, and the row after the last.
        times: times of the first and the last row, s.
        step: sampling step, s.
        measured: whether the file has speeds.
        units: of the columns of the file.
    """

    file: str
    name: str
    rows: tuple[int, int]
    times: tuple[float, float]
    step: float
    measured: bool
    units: Units = IN_SI

    @property
    def count(self) -> int:
        """Number of rows."""
        return self.rows[1] - self.rows[0]

    def between(self, first: int, last: int) -> Stretch:
        """Return the stretch between two rows of the file."""
        begin, end = (self.times[0] + self.step * (k - self.rows[0]) for k in (first, last - 1))
        return replace(self, rows=(first, last), times=(begin, end))


def within(s: Stretch, low: float, high: float) -> Stretch:
    """Return the part of a stretch between two times."""
    if low <= s.times[0] and high >= s.times[1]:
        return s
    first, last = s.rows
    if low > s.times[0]:
        first = min(first + math.ceil((low - s.times[0]) / s.step - 1e-6), last)
    if high < s.times[1]:
        last = s.rows[0] + math.floor((high - s.times[0]) / s.step + 1e-6) + 1
    return s.between(first, max(last, first))
