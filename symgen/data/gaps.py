"""Gaps in the time stamps of a log."""

from __future__ import annotations

import numpy as np

from symgen.data.raw import FloatArray, Places

#: A time step of this many medians is a gap; no interpolation may fill it.
GAP = 10.0
_CATCH_UP = 100  # samples to check after a wide step


def holes(t: FloatArray, step: float, longest: float | None = None) -> Places:
    """Return the samples before a gap: a time step above a limit.

    A busy computer writes stamps late, and then several at once. If the following samples catch up
    with the clock, up to half of the limit, there is no gap.

    Args:
        t: (N,) times, s.
        step: sampling step, s.
        longest: the limit, s; GAP steps by default.
    """
    longest = longest or GAP * step
    wide = np.flatnonzero(np.diff(t) > longest)
    missing = []
    for k in wide:
        after = t[k + 1 : k + 1 + _CATCH_UP]
        clock = np.arange(1, len(after) + 1)
        missing.append(np.min((after - t[k]) / step - clock))
    lost = step * np.array(missing, dtype=float)
    return np.asarray(wide[lost > longest / 2], dtype=np.int64)
