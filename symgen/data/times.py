"""Times that are not one number: durations as text, and seconds with their rest apart."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import refuse
from symgen.data.units import unit_of

_SECOND = 10**9  # ns
_VALUE = re.compile(r"([+-]?[0-9.]+(?:e[+-]?[0-9]+)?) *([a-zµμ]+)", re.IGNORECASE)  # 0.005 sec
_CLOCK = re.compile(r"(?:([0-9]+) days?,? )?(?:([0-9]+):)?([0-9]+):([0-9]+(?:\.[0-9]*)?)")
_DATE = re.compile("[0-9]{4}-[0-9]{2}-[0-9]{2}")
_REST = re.compile(r"(.*?)(nano|n|micro|u)(sec|secs|seconds)", re.IGNORECASE)


def durations(texts: Sequence[str]) -> NDArray[Any]:
    """Return texts of durations in whole ns, (N,) timedelta64.

    Raises:
        ValueError: one is no duration.
    """
    seconds = [_seconds(text.replace(",", ".").strip()) for text in texts]
    return np.array([round(_SECOND * t) for t in seconds], dtype="timedelta64[ns]")


def are_times(texts: Sequence[str]) -> bool:
    """Return whether texts are dates, such as 2026-01-31T13:00:00.250, or durations."""
    with suppress(ValueError):
        return all(map(_DATE.match, texts)) or len(durations(texts)) > 0
    return False


def _seconds(text: str) -> float:
    value, clock = _VALUE.fullmatch(text), _CLOCK.fullmatch(text)
    if value and (unit := unit_of(value[2], "time")):
        return float(value[1]) * unit.size
    if clock and (clock[2] or "." in clock[4]):  # 10:30 may be hours or minutes
        days, hours, minutes, seconds = (float(part or 0) for part in clock.groups())
        return 86400 * days + 3600 * hours + 60 * minutes + seconds
    raise ValueError(f"column t: {text!r} is no duration")


def paired(names: Sequence[str], chosen: str) -> list[str]:
    """Return names of columns, with "sec+nanosec" for the whole seconds of a time in two columns.

    Args:
        names: the columns of the file.
        chosen: the column of the time that the user names, or two columns with + between them.
    """
    pairs = {match[1] + match[3]: match[0] for match in map(_REST.fullmatch, names) if match}
    seconds, _, rest = chosen.partition("+")
    if rest in names:
        pairs[seconds] = rest
    return [f"{name}+{pairs[name]}" if name in pairs else name for name in names]


def rest_of(name: str) -> str:
    """Return the second of the two columns of a time, or ""."""
    return name.partition("+")[2]


def is_sum(name: str) -> bool:
    """Return whether a name is that of two columns of a time, by their names."""
    return _REST.fullmatch(rest_of(name)) is not None


def joined(seconds: NDArray[Any], rest: NDArray[Any], column: str) -> NDArray[Any]:
    """Return whole seconds and the rest as times in whole ns, (N,) timedelta64.

    Args:
        seconds: (N,) whole seconds.
        rest: (N,) the rest, in us if the name of its column says so, otherwise in ns.
        column: that name.

    Raises:
        LogError: they are no whole seconds, or no rest of a second.
    """
    match = _REST.fullmatch(column)
    micro = match is not None and match[2].lower() in ("micro", "u")
    rest = rest * (1000 if micro else 1)
    whole = (seconds % 1 == 0).all() and rest.min() >= 0 and rest.max() < _SECOND
    too_small = np.ptp(seconds) >= 2 and rest.max() < _SECOND / 1000  # ms or us
    if too_small or not whole:
        what = f"t is not whole seconds, and their rest in {column!r}"
        refuse(what, "the rest in ns, or in us by a name such as usec")
    stamps = seconds.astype(np.int64) * _SECOND + rest.astype(np.int64)
    return stamps.astype("timedelta64[ns]")
