"""Faults undone: logs with channels multiplied, exchanged, shifted, drawn anew or masked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symgen.data.log import Rows
from symgen.data.mask import Bools, touched
from symgen.data.raw import FloatArray, read_only
from symgen.data.signals import Samples, can_filter, differentiate, interpolated, lowpass
from symgen.estimation.decimation import ENDS
from symgen.estimation.filtered_log import FilteredLog
from symgen.faults.fault import Fault, delay_of

_SMOOTH = 10.0  # Hz: band in which a speed is drawn from positions


# Logs as they were recorded, and samples.


def with_column(log: Rows, key: str, j: int, x: FloatArray) -> Rows:
    """Return a log, or what was made of one, with another column (N,) of a channel."""
    columns = getattr(log, key).copy()
    columns[:, j] = x
    columns.setflags(write=False)
    changed: dict[str, Any] = {key: columns}
    return replace(log, **changed)


def masked(samples: Samples, at: Bools, joints: Sequence[int]) -> Samples:
    """Return samples of which no equation of some joints, nor a common one, touches some, (N,)."""
    joint = np.zeros(samples.q.shape, dtype=bool)
    joint[:, list(joints)] = at[:, None]
    return samples.masked(joint, at)


def bridged(samples: Samples, at: Bools, joints: Sequence[int]) -> Samples:
    """Return samples with positions drawn over a time in which they were not seen, and masked."""
    q, t = samples.q.copy(), samples.t
    for j in joints:
        q[at, j] = interpolated(t[~at], q[~at, j])(t[at])
    return masked(replace(samples, q=read_only(q)), at, range(q.shape[1]))


def sloped(samples: Samples, at: Bools, j: int) -> Samples:
    """Return samples with the speed of a joint replaced by dq/dt at some of them."""
    q, step = samples.q[:, j], samples.step
    q = lowpass(q, step, _SMOOTH) if can_filter(_SMOOTH, step) else q
    return with_column(samples, "qd", j, np.where(at, differentiate(q, step), samples.qd[:, j]))


def shifted(x: FloatArray, delay: float, step: float) -> FloatArray:
    """Return a signal as it was `delay` s later, between samples by a cubic (Catmull and Rom)."""
    if delay == 0.0:
        return x
    at = np.arange(len(x)) + delay / step
    at = np.clip(at, 0.0, len(x) - 1.0)
    k = np.clip(at.astype(np.int64), 0, len(x) - 2)
    u = at - k
    p0, p1 = x[np.maximum(k - 1, 0)], x[k]
    p2, p3 = x[k + 1], x[np.minimum(k + 2, len(x) - 1)]
    return np.asarray(
        p1
        + 0.5 * u * (p2 - p0 + u * (2 * p0 - 5 * p1 + 4 * p2 - p3 + u * (3 * (p1 - p2) + p3 - p0)))
    )


def with_earlier_torques(
    samples: Samples, delay: float, joints: Sequence[int] | None = None
) -> Samples:
    """Return samples whose torques, of some joints or of all, were measured `delay` s earlier."""
    tau = samples.tau.copy()
    for j in range(tau.shape[1]) if joints is None else joints:
        tau[:, j] = shifted(tau[:, j], delay, samples.step)
    return replace(samples, tau=read_only(tau))


def with_known_shifts(
    samples: Samples, shifts: Sequence[Fault]
) -> tuple[Samples, tuple[Fault, ...]]:
    """Return a log with the torques shifted as an estimate did, and the repairs of this log."""
    for fault in shifts:
        samples = with_earlier_torques(samples, delay_of(fault))
    return samples, tuple(replace(f, log=samples.name, samples=len(samples.t)) for f in shifts)


# Logs in the band of a run.


def earlier(log: FilteredLog, delay: float, joints: Sequence[int]) -> FilteredLog:
    """Return a log whose torques, of some joints, were measured `delay` s earlier.

    Where that needs torques from before or after the log, these joints are masked, unless it is
    less than is left out at the ends in any case.
    """
    samples = with_earlier_torques(log.samples, delay, joints)
    if abs(delay) > ENDS / 2:
        then = log.t + delay
        samples = masked(samples, (then < log.t[0]) | (then > log.t[-1]), joints)
    return replace(log, samples=samples)


def exchanged(log: FilteredLog, j: int, k: int, keys: Sequence[str]) -> FilteredLog:
    """Return a log with some channels of two joints exchanged."""
    order = np.arange(log.q.shape[1])
    order[[j, k]] = k, j
    return _changed(log, keys, lambda x: np.ascontiguousarray(x[:, order]))


def multiplied(
    log: FilteredLog, joints: Sequence[int], factor: float, keys: Sequence[str]
) -> FilteredLog:
    """Return a log with some channels of some joints times a factor."""
    scale = np.ones(log.q.shape[1])
    scale[list(joints)] = factor
    return _changed(log, keys, lambda x: x * scale)


def geared(log: FilteredLog, j: int, ratio: float) -> FilteredLog:
    """Return a log with the motion of a joint times a factor, its torque over it."""
    return multiplied(multiplied(log, (j,), ratio, ("q", "qd")), (j,), 1 / ratio, ("tau",))


def derived(log: FilteredLog, j: int) -> FilteredLog:
    """Return a log with the speed of a joint replaced by dq/dt, in the same band."""
    return with_column(log, "qd", j, differentiate(log.q[:, j], log.step))


def levelled(log: FilteredLog, name: str, j: int, steps: Mapping[int, float]) -> FilteredLog:
    """Return the log of a name without the steps (height after each sample) of a torque.

    The torque before the first one is taken for the right one.
    """
    if log.name != name:
        return log
    tau = log.tau[:, j].copy()
    for i, height in steps.items():
        tau[i + 1 :] -= height
    return replace(log, samples=with_column(log.samples, "tau", j, tau))


def unlimited(log: FilteredLog, j: int, limits: Mapping[str, float]) -> FilteredLog:
    """Return a log without torques of a joint at its limit, and what the low-pass made of them.

    It carries them to their neighbours, half a period of its cutoff away.
    """
    reach = 0 if log.rows.cutoff is None else int(0.5 / (log.rows.cutoff * log.step))
    at = touched(np.abs(log.tau[:, j]) > limits[log.name], reach)
    return replace(log, samples=masked(log.samples, at, [j]))


def _changed(
    log: FilteredLog, keys: Sequence[str], change: Callable[[FloatArray], FloatArray]
) -> FilteredLog:
    """Return a log with some channels changed, in the band and as they were sampled."""
    arrays: dict[str, Any] = {key: change(getattr(log.samples, key)) for key in keys}
    motion: dict[str, Any] = {key: change(getattr(log, key)) for key in keys if key != "tau"}
    return replace(log, samples=replace(log.samples, **arrays), **motion)
