"""Repaired channels as recorded and as used, around the repair, for plots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from symgen.data.log import Log
from symgen.data.mask import rms
from symgen.data.signals import Samples
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.robot.effect import effect_unit

#: Largest number of plots, and number of samples on each side of a change.
_MOST, _MARGIN = 8, 60
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
        repaired: (2, M) t in s and the values that symgen uses; NaN where they are masked.
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
    logs: Iterable[tuple[Log, Samples]],
    faults: Sequence[Fault],
    sigma: Sequence[int],
) -> Iterator[MendedChannel]:
    """Yield the repaired channels, around their largest change.

    Args:
        logs: each log as recorded, mapped to the joint side, and as used.
        faults: the repairs.
        sigma: types of the movable joints.
    """
    for before, after in logs:
        of_channel: dict[str, Fault] = {}
        for fault in faults:
            for channel in fault.channel.split(", ") if fault.log == before.name else ():
                of_channel.setdefault(channel, fault)
        for key, kind in _KINDS.items():
            for j in range(len(sigma) if getattr(before, key) is not None else 0):
                channel = f"{key}{j + 1}"
                found = of_channel.get(channel) or of_channel.get(key) or of_channel.get("all")
                drawn = found and _around_change(before, after, key, j)
                if found and drawn:
                    says = found.in_words.removeprefix(f"{found.log}: {found.channel}: ")
                    unit = effect_unit(kind, sigma[j])
                    yield MendedChannel(before.name, channel, says, unit, *drawn)


def largest_repairs(channels: Iterable[MendedChannel]) -> tuple[MendedChannel, ...]:
    """Return the few channels with the largest changes."""
    return tuple(sorted(channels, key=lambda c: -c.size)[:_MOST])


def _around_change(
    before: Log, after: Samples, key: str, j: int
) -> tuple[FloatArray, FloatArray, float] | None:
    """Return t with recorded and used values, and the size of the change; None without a change."""
    t, x = before.t, getattr(before, key)[:, j]
    used = np.array(getattr(after, key)[:, j])
    if key == "tau" and after.mask is not None:
        used[after.mask.joint[:, j]] = np.nan
    spread = float(np.std(x)) or 1.0
    change = np.abs(np.interp(t, after.t, used) - x)
    change = np.nan_to_num(change, nan=spread)
    at = int(np.argmax(change))
    if change[at] <= 1e-9 * spread:
        return None
    near = slice(max(at - _MARGIN, 0), at + _MARGIN + 1)
    recorded = np.stack([t[near], x[near]])
    start, end = recorded[0, [0, -1]]
    shown = (after.t >= start) & (after.t <= end)
    repaired = np.stack([after.t[shown], used[shown]])
    return recorded, repaired, float(rms(change)) / spread
