"""Times that are not one number: durations as text, and seconds with their fraction apart."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import refuse
from symgen.data.units import unit_of

#: Log column of the fraction of a second, where a file has the seconds in another column.
FRACTION = "t+"
_SECOND = 10**9  # ns
_VALUE = re.compile(r"([+-]?[0-9.]+(?:e[+-]?[0-9]+)?) *([a-zµμ]+)", re.IGNORECASE)  # 0.005 sec
_CLOCK = re.compile(r"(?:([0-9]+) days?,? )?(?:([0-9]+):)?([0-9]+):([0-9]+(?:\.[0-9]*)?)")
_FRACTION = re.compile(r"(.*?)(nano|n|micro|u)(sec|secs|seconds)", re.IGNORECASE)


def durations(texts: Sequence[str]) -> NDArray[Any] | None:
    """Return texts of durations in whole ns, (N,) timedelta64; None if one is no duration."""
    ticks = [_ticks(text.replace(",", ".").strip()) for text in texts]
    return None if None in ticks else np.array(ticks, dtype="timedelta64[ns]")


def _ticks(text: str) -> int | None:
    if value := _VALUE.fullmatch(text):
        unit = unit_of(value[2], "time")
        return None if unit is None else round(float(value[1]) * unit.size * _SECOND)
    clock = _CLOCK.fullmatch(text)
    if clock is None or not (clock[2] or "." in clock[4]):  # 10:30 may be hours or minutes
        return None
    days, hours, minutes, seconds = (float(part or 0) for part in clock.groups())
    return round((86400 * days + 3600 * hours + 60 * minutes + seconds) * _SECOND)


def fractions(names: Sequence[str]) -> dict[str, str]:
    """Return columns of whole seconds -> columns of the rest, such as sec -> nanosec."""
    pairs = {}
    for name in names:
        match = _FRACTION.fullmatch(name)
        if match and match[1] + match[3] in names:
            pairs[match[1] + match[3]] = name
    return pairs


def joined(seconds: NDArray[Any], fraction: NDArray[Any], column: str) -> NDArray[Any]:
    """Return whole seconds and the rest as times in whole ns, (N,) timedelta64.

    Args:
        seconds: (N,) whole seconds.
        fraction: (N,) the rest, in us if the name of its column says so, otherwise in ns.
        column: that name.

    Raises:
        LogError: they are no whole seconds, or no rest of a second.
    """
    match = _FRACTION.fullmatch(column)
    rest = np.asarray(fraction) * (1000 if match and match[2] in ("micro", "u") else 1)
    apart = np.ptp(seconds) >= 2 and 0 < rest.max() < _SECOND / 1000  # ms or us
    if apart or not ((seconds % 1 == 0).all() and rest.min() >= 0 and rest.max() < _SECOND):
        what = f"t is not whole seconds, and their rest in {column!r}"
        refuse(what, "the rest in ns, or in us by a name such as usec")
    stamps = seconds.astype(np.int64) * _SECOND + rest.astype(np.int64)
    return stamps.astype("timedelta64[ns]")
