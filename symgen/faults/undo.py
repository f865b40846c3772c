"""Undo faults: scale, exchange, shift, replace or mask channels of logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symgen.data.log import Rows, rows
from symgen.data.mask import Bools
from symgen.data.raw import FloatArray, read_only
from symgen.data.signals import (
    Samples,
    differentiate,
    interpolated,
    lowpass_and_slopes,
    smoothed,
)
from symgen.estimation.decimation import ENDS
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floating import base_motion
from symgen.faults.fault import IMU, Fault, delay_of, torques_of

_SMOOTH = 10.0  # Hz: band in which speeds are computed from positions


# Logs as recorded, and samples.


def with_column(log: Rows, key: str, j: int, x: FloatArray) -> Rows:
    """Return a log, or samples, with another column (N,) of a channel."""
    columns = getattr(log, key).copy()
    columns[:, j] = x
    columns.setflags(write=False)
    changed: dict[str, Any] = {key: columns}
    return replace(log, **changed)


def mask_samples(samples: Samples, at: Bools, joints: Sequence[int]) -> Samples:
    """Mask some samples (N,) for some joints."""
    joint = np.zeros(samples.q.shape, dtype=bool)
    joint[:, list(joints)] = at[:, None]
    return samples.masked(joint, at)


def bridged(samples: Samples, at: Bools, joints: Sequence[int]) -> Samples:
    """Interpolate positions over some samples, and mask these."""
    q, t = samples.q.copy(), samples.t
    for j in joints:
        curve = interpolated(t[~at], q[~at, j])
        q[at, j] = curve(t[at])
    every = range(q.shape[1])
    return mask_samples(replace(samples, q=read_only(q)), at, every)


def sloped(samples: Samples, at: Bools, j: int) -> Samples:
    """Replace the speed of a joint by dq/dt at some samples."""
    q = smoothed(samples.q[:, j], samples.step, _SMOOTH)
    slope = differentiate(q, samples.step)
    qd = np.where(at, slope, samples.qd[:, j])
    return with_column(samples, "qd", j, qd)


def shifted(x: FloatArray, delay: float, step: float) -> FloatArray:
    """Return a signal `delay` s later, by cubic interpolation (Catmull and Rom)."""
    if delay == 0.0:
        return x
    last = len(x) - 1
    at = np.arange(len(x)) + delay / step
    at = np.clip(at, 0.0, float(last))
    k = np.clip(at.astype(np.int64), 0, last - 1)
    u = at - k
    before = np.maximum(k - 1, 0)
    after = np.minimum(k + 2, last)
    p0, p1 = x[before], x[k]
    p2, p3 = x[k + 1], x[after]
    cubic = 3 * (p1 - p2) + p3 - p0
    square = 2 * p0 - 5 * p1 + 4 * p2 - p3
    change = p2 - p0 + u * (square + u * cubic)
    return np.asarray(p1 + 0.5 * u * change)


def with_earlier_torques(
    samples: Samples, delay: float, joints: Sequence[int] | None = None
) -> Samples:
    """Shift the torques of some joints, or of all, earlier by `delay` s."""
    tau = samples.tau.copy()
    for j in range(tau.shape[1]) if joints is None else joints:
        tau[:, j] = shifted(tau[:, j], delay, samples.step)
    return replace(samples, tau=read_only(tau))


def with_imu(samples: Samples, delay: float, offsets: FloatArray | float = 0.0) -> Samples:
    """Shift the readings of an IMU earlier by `delay` s, and subtract offsets (6,)."""
    if samples.imu is None:
        return samples
    earlier = [shifted(x, delay, samples.step) for x in samples.imu.T]
    return replace(samples, imu=read_only(np.column_stack(earlier) - offsets))


def with_known_shifts(
    samples: Samples, shifts: Sequence[Fault]
) -> tuple[Samples, tuple[Fault, ...]]:
    """Shift the channels of a log as an estimate did; return also the repairs of this log."""
    repairs = []
    for fault in shifts:
        if fault.channel == IMU:
            samples = with_imu(samples, delay_of(fault))
        else:
            samples = with_earlier_torques(samples, delay_of(fault), torques_of(fault))
        repairs.append(replace(fault, log=samples.name, samples=len(samples.t)))
    return samples, tuple(repairs)


# Logs in the band of a run.


def earlier(log: FilteredLog, delay: float, joints: Sequence[int]) -> FilteredLog:
    """Shift the torques of some joints earlier by `delay` s.

    If this needs torques outside the log, these joints are masked there, unless the ends that are
    left out anyway already cover it.
    """
    samples = with_earlier_torques(log.samples, delay, joints)
    if abs(delay) > ENDS / 2:
        then, (start, end) = log.t + delay, log.t[[0, -1]]
        outside = (then < start) | (then > end)
        samples = mask_samples(samples, outside, joints)
    return replace(log, samples=samples)


def rearranged(
    log: FilteredLog, order: Sequence[int], factors: Mapping[str, FloatArray]
) -> FilteredLog:
    """Take some channels of a log from other columns, and multiply them.

    Args:
        log: log in the band of the run.
        order: (n,) source column of each joint.
        factors: (n,) factors of the joints, by channel; other channels stay unchanged.
    """
    samples: dict[str, Any] = {}
    motion: dict[str, Any] = {}
    for key, factor in factors.items():
        samples[key] = _taken(getattr(log.samples, key), order) * factor
        if key != "tau":  # torques in the band are computed from the samples
            motion[key] = _taken(getattr(log, key), order) * factor
        if key == "qd":
            motion["slopes"] = motion[key], _taken(log.rates, order) * factor
    return replace(log, samples=replace(log.samples, **samples), **motion)


def _taken(x: FloatArray, order: Sequence[int]) -> FloatArray:
    return np.ascontiguousarray(x[:, list(order)])


def sharpened(log: FilteredLog, time: float, joints: Sequence[int]) -> FilteredLog:
    """Replace tau of some joints by tau + T d(tau)/dt."""
    smooth = log.rows.cutoff
    if smooth is None:
        slope = np.gradient(log.samples.tau, log.step, axis=0)
    else:  # the slope within the comparison band
        _, slope = lowpass_and_slopes(log.samples.tau, log.step, 2 * smooth, 1)
    tau, columns = log.samples.tau.copy(), list(joints)
    tau[:, columns] += time * slope[:, columns]
    return replace(log, samples=replace(log.samples, tau=read_only(tau)))


def backwards(log: FilteredLog) -> FilteredLog:
    """Reverse a log in time: the last sample comes first, and speeds change their sign."""
    samples = log.samples
    changed: dict[str, Any] = {
        "q": read_only(samples.q[::-1]),
        "tau": read_only(samples.tau[::-1]),
        "qd": read_only(-samples.qd[::-1]),
    }
    if samples.imu is not None:
        half = np.repeat([1.0, -1.0], 3)  # angular velocities change their sign
        changed["imu"] = read_only(samples.imu[::-1] * half)
    if samples.mask is not None:
        changed["mask"] = rows(samples.mask, slice(None, None, -1))
    q = np.ascontiguousarray(log.q[::-1])
    qd = np.ascontiguousarray(-log.qd[::-1])
    turned = replace(log, samples=replace(samples, **changed), q=q, qd=qd)
    return replace(turned, base=base_motion(turned.samples, log.band))


def left_out(log: FilteredLog, at: slice, joints: Sequence[int]) -> FilteredLog:
    """Leave out the equations of some samples and joints."""
    there = np.zeros(len(log.t), dtype=bool)
    there[at] = True
    return replace(log, samples=mask_samples(log.samples, there, joints))


def touching_in(log: FilteredLog, at: slice, frame: str) -> FilteredLog:
    """Set the flag of a contact of a floating base to 1 in some samples."""
    samples = log.samples
    assert samples.touches is not None
    assert samples.robot is not None
    touches = samples.touches.copy()
    frames = [contact.frame for contact in samples.robot.contacts]
    touches[at, frames.index(frame)] = 1.0
    return replace(log, samples=replace(samples, touches=read_only(touches)))
