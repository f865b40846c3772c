"""Repaired channels as recorded and as used, around the repair, for plots."""

from __future__ import annotations

import itertools
import string
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from symgen.data.log import Log
from symgen.data.signals import Samples
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.robot.effect import unit

#: Largest number of plots; most and least samples in one; share of the largest change that is
#: shown.
_MOST, _POINTS, _FEWEST, _NEAR = 8, 300, 60, 0.1
_WHOLE = 0.5  # part of a log: if more is repaired, the plot shows where the change is largest
_KINDS = {"q": "position", "qd": "speed", "tau": "torque"}


@dataclass(frozen=True, eq=False)
class MendedChannel:
    """One channel around its repair.

    Attributes:
        log: name of the log.
        channel: name of the channel, for example "q2" or "tau1".
        says: the fault and its repair.
        unit: unit of the values.
        recorded: (2, K) t in s and the recorded values.
        repaired: (2, M) t in s and the values that are used; NaN where they are masked.
        size: RMS change by the repair, relative to the spread of the channel.
    """

    log: str
    channel: str
    says: str
    unit: str
    recorded: FloatArray
    repaired: FloatArray
    size: float


def mended_channels(
    logs: Iterable[tuple[Log, Samples]], repairs: Sequence[Fault], sigma: Sequence[int]
) -> tuple[MendedChannel, ...]:
    """Return the channels that were repaired before the search, around their largest change.

    Args:
        logs: each log as recorded, mapped to the joint side, and as it is used.
        repairs: repairs of the logs.
        sigma: types of the movable joints.
    """
    out: list[MendedChannel] = []
    for (log, samples), repair in itertools.product(logs, repairs):
        key = repair.channel.rstrip(string.digits)
        if repair.log != log.name or repair.kind == "coarse" or key == "t":
            continue  # time stamps have no other channel to be plotted over
        digits = repair.channel[len(key) :]
        keys = [
            own for own in (_KINDS if key == "all" else (key,)) if getattr(log, own) is not None
        ]
        joints = [int(digits) - 1] if digits else range(len(sigma))
        says = f"{repair.fault}, {repair.samples} samples: {repair.done}"
        changed = [
            c
            for own, j in itertools.product(keys, joints)
            for c in _channel(log, samples, own, j, says, sigma[j])
        ]
        out += sorted(changed, key=lambda c: -c.size)[:1]
    return tuple(out)


def undone_channels(
    before: Sequence[FilteredLog], after: Sequence[FilteredLog], sigma: Sequence[int]
) -> tuple[MendedChannel, ...]:
    """Return the channels that were corrected because of the torque equations."""
    says = "as the torque equations want it"
    return tuple(
        c
        for b, a in zip(before, after, strict=True)
        for key, j in itertools.product(_KINDS, range(len(sigma)))
        if key != "qd" or np.array_equal(b.q[:, j], a.q[:, j])
        for c in _channel(b, a, key, j, says, sigma[j])
    )


def largest(channels: Sequence[MendedChannel]) -> tuple[MendedChannel, ...]:
    """Return the few channels with the largest changes, one for each channel and log."""
    best: dict[tuple[str, str], MendedChannel] = {}
    for c in sorted(channels, key=lambda c: -c.size):
        best.setdefault((c.log, c.channel), c)
    return tuple(best.values())[:_MOST]


def _channel(
    before: Log | FilteredLog,
    after: Samples | FilteredLog,
    key: str,
    j: int,
    says: str,
    sigma: int,
) -> Iterator[MendedChannel]:
    """Yield a channel around its largest change, if a repair changed it."""
    t, x = before.t, getattr(before, key)[:, j]
    used = np.array(getattr(after, key)[:, j])
    if key == "tau" and isinstance(after, Samples) and after.mask is not None:
        used[after.mask.joint[:, j]] = np.nan
    there = np.interp(t, after.t, used)
    spread = float(np.std(x)) or 1.0
    change = np.where(np.isnan(there), spread, np.abs(there - x))
    if change.max() > 1e-9 * spread:
        size = float(np.sqrt(np.mean(change**2))) / spread
        window = _window(t, change)
        parts = _part(t, x, *window), _part(after.t, used, *window)
        dimension = unit(_KINDS[key], sigma)
        yield MendedChannel(before.name, f"{key}{j + 1}", says, dimension, *parts, size)


def _window(t: FloatArray, change: FloatArray) -> tuple[float, float]:
    """Return the time span around the largest change, s."""
    at = int(np.argmax(change))
    near = change > _NEAR * change[at]
    if near.mean() > _WHOLE:
        first, last = at - _POINTS // 2, at + _POINTS // 2
    else:
        still = np.flatnonzero(~near)
        before, after = still[still < at], still[still > at]
        first = int(before[-1]) if len(before) else 0
        last = int(after[0]) if len(after) else len(t) - 1
        margin = max(last - first, _FEWEST // 2)
        first, last = first - margin, last + margin
    return float(t[max(first, 0)]), float(t[min(last, len(t) - 1)])


def _part(t: FloatArray, x: FloatArray, start: float, end: float) -> FloatArray:
    """Return (2, K) of t and x in a time span, at most a few hundred points."""
    inside = np.flatnonzero((t >= start) & (t <= end))
    every = max(1, -(-len(inside) // _POINTS))
    return np.stack([t[inside[::every]], x[inside[::every]]])
