"""Where samples of a log are missing, by its stamps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import FloatArray

#: A step of this many medians is a hole in the log, which no interpolation may fill.
GAP = 10.0
_MADE_GOOD = 100  # samples after a wide step that are looked at


def holes(t: FloatArray, step: float) -> NDArray[np.int64]:
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
