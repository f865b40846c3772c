"""Rows of a file between which no time is missing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


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


def within(s: Stretch, low: float | None, high: float | None) -> Stretch:
    """Return the rows of a stretch between two times, by its step."""
    first, last = s.rows
    if low is not None and low > s.times[0]:
        first = s.rows[0] + int(np.ceil((low - s.times[0]) / s.step - 1e-6))
    if high is not None and high < s.times[1]:
        last = s.rows[0] + int(np.floor((high - s.times[0]) / s.step + 1e-6)) + 1
    return s.between(min(first, s.rows[1]), max(last, first))
