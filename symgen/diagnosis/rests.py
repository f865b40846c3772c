"""Samples at rest: static friction can take any value between its limits.

    |tau - W X| <= F,    W the regressor with the joint's own speed zero

A torque within the limits contains no information. A torque beyond them counts by its distance to
the limit. F is 1.5 times the model's friction at creeping speed, because static friction is larger
than friction in motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import SLOW, Bools, spans, touched
from symgen.diagnosis.whitened_system import modelled, standing
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.values import FloatArray

#: Largest ratio of static to kinetic friction, from tables of materials.
_STATIC = 1.5
#: Gives the torque from q, qd, qdd, (k, n) each.
Torque = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


def with_speed(log: FilteredLog, still: Bools, share: float) -> FilteredLog:
    """Return a log in which joints at rest (N, n) move at a part of their largest speed."""
    slow = share * np.abs(log.qd).max(axis=0)
    out = replace(log, qd=np.where(still, slow, log.qd))
    out.__dict__["qdd"] = log.qdd  # fills the cached property: no joint jumps
    return out


@dataclass(frozen=True, eq=False)
class RestingLogs:
    """Logs in which joints are at rest.

    Attributes:
        logs: logs in the band of the run.
        halted: the same logs with the speed of resting joints zero.
        creeping: the same logs with a small speed of resting joints, backward and forward.
        joint: (R,) index of the joint of each rest.
        rows: (R, 2) first kept row of each rest, and the row after its last.
    """

    logs: tuple[FilteredLog, ...]
    halted: tuple[FilteredLog, ...]
    creeping: tuple[tuple[FilteredLog, ...], ...]
    joint: NDArray[np.intp]
    rows: NDArray[np.intp]

    def means(self, torque: FloatArray) -> FloatArray:
        """Return the means (R, ...) of values (K, n, ...) over the rests, for the joint of each."""
        pairs = zip(self.joint, self.rows, strict=True)
        return np.array([torque[a:b, j].mean(axis=0) for j, (a, b) in pairs])


def resting_logs(logs: Sequence[FilteredLog]) -> RestingLogs | None:
    """Find rests that the low-pass does not mix with motion; None if there are none."""
    still = [standing(log) for log in logs]
    found = [
        (j, first + span.start, last + span.start)
        for log, own, span in zip(logs, still, kept_spans(logs), strict=True)
        for j, first, last in _deep(log, own)
    ]
    if not found:
        return None
    pairs = [*zip(logs, still, strict=True)]
    joint, *rows = np.array(found).T
    return RestingLogs(
        tuple(logs),
        tuple(with_speed(log, own, 0.0) for log, own in pairs),
        tuple(tuple(with_speed(log, own, s) for log, own in pairs) for s in (-SLOW, SLOW)),
        joint,
        np.stack(rows, axis=1),
    )


def _deep(log: FilteredLog, still: Bools) -> Iterator[tuple[int, int, int]]:
    """Yield joint and kept rows of rests that the filter does not mix with motion or a mask."""
    for j, deep in enumerate(deep_rows(log, still).T):
        for first, last in spans(deep):
            yield j, int(first), int(last)


def deep_rows(log: FilteredLog, still: Bools) -> Bools:
    """Return the kept rows of rests that the filter does not mix with motion or a mask, (K, n)."""
    moving = [touched(~joint, log.reach) for joint in still.T]
    return (~np.column_stack(moving) & log.clear)[log.kept]


def static_friction(resting: RestingLogs, torque: Sequence[FloatArray]) -> FloatArray:
    """Return the limit of static friction of each rest, (R,).

    resting: the logs.
    torque: torque of the model with joints creeping backward and forward, (K, n) each.
    """
    back, forth = map(resting.means, torque)
    return _STATIC * np.abs(forth - back) / 2


def beyond_friction(log: FilteredLog, error: FloatArray, model: Torque) -> FloatArray:
    """Return how far torques at rest exceed the limits of static friction, (n,).

    The values are sums of squares over the kept rows.

    Args:
        log: a log in the band of the run.
        error: (K, n) measured minus modelled torque, in the band, at the kept samples.
        model: gives the modelled torque.
    """
    still = standing(log)
    deep = deep_rows(log, still)
    if not deep.any():
        return np.zeros(error.shape[1])
    back, halted, forth = (
        modelled(with_speed(log, still, share), model) for share in (-SLOW, 0.0, SLOW)
    )
    left = np.abs(error + modelled(log, model) - halted)
    beyond = np.maximum(left - _STATIC * np.abs(forth - back) / 2, 0.0)
    return np.asarray(np.sum(np.where(deep, beyond, 0.0) ** 2, axis=0))
