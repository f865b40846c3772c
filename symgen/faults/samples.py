"""Faults that samples alone reveal: a table of rules, each with its finder and its undo.

The first rules take a log as recorded, the others its samples with uniform steps. Faults that
cannot be undone need a new recording. Thresholds are relative to the usual steps and the last digit
of a channel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from symgen.data.log import Log, long_runs, rows
from symgen.data.mask import Bools, on_grid, rms, spans
from symgen.data.raw import FloatArray, read_only
from symgen.data.signals import STEP_TOLERANCE, Samples
from symgen.faults.channels import (
    clipped,
    hold_length,
    last_digit,
    outliers,
    runs,
    signed,
    steps,
    unwrapped,
    usual_step,
    without,
)
from symgen.faults.clock import roughness, stalled_rows, uniform_clock
from symgen.faults.fault import CONVERTED, Fault
from symgen.faults.rules import Channel, Rule, Symptom, apply, with_values
from symgen.faults.undo import bridged, mask_samples, sloped
from symgen.names import PRISMATIC
from symgen.robot.types import WITHOUT_MOTOR

_BRIEF = 3  # rows in stalls that are ignored
#: Samples before and after a torque peak that show whether the motion follows it, and threshold in
#: standard deviations.
_AFTER, _FOLLOWS = 5, 4.0
#: Largest ratio of speed changes from step to step, along a uniform clock over along the stamps.
_CLOCK = 0.8
#: Shortest run of a stuck channel, in samples and over its other runs; smallest step after it, in
#: usual steps; speed of a moving joint over its RMS; share of a log without a signal.
_STUCK, _LONGER, _LEAVES, _MOVES, _DEAD = 20, 10.0, 3.0, 0.1, 0.5
_VARIED = 10  # runs of other lengths, which give the usual length


def repaired(log: Log, sigma: Sequence[int]) -> tuple[Log, tuple[Fault, ...]]:
    """Repair faults that single samples of a recorded log reveal.

    Args:
        log: the log, mapped to the joint side.
        sigma: types of the joints.
    """
    log, faults = apply(RECORDED, log, sigma)
    converted = [
        Fault(log.name, columns, unit, 0, done, kind=CONVERTED)
        for columns, unit, done in log.converted
    ]
    return log, (*converted, *faults)


# Logs as recorded.


def _missing(c: Channel) -> Symptom | None:
    """Find missing values, in gaps short enough that reading interpolates them."""
    lost = _lost(c, c.log)
    short = lost & ~long_runs(lost)
    return Symptom(int(short.sum())) if short.any() else None


def _lost(c: Channel, log: Log) -> Bools:
    """Return which values of a channel are missing in a log as recorded, (N,)."""
    if log.missing is None:
        return np.zeros(len(log.t), dtype=bool)
    place = ("q", "qd", "tau").index(c.key)
    return log.missing[:, c.joint, place]


def _stalled(c: Channel) -> Symptom | None:
    """Find rows that repeat the previous row in all channels while the robot moves."""
    at = stalled_rows(c.log)
    if at.sum() <= _BRIEF:
        return None
    rows_of_longest = np.diff(spans(at)).max()
    step = np.median(np.diff(c.log.t))
    longest = float(rows_of_longest * step)
    return Symptom(int(at.sum()), ~at, {"longest": longest})


def _wrapped(c: Channel) -> Symptom | None:
    """Find angles that jump by one turn between samples of a slow motion."""
    angle = unwrapped(c.x, 2 * np.pi)
    if angle is None or c.about[c.joint] == PRISMATIC:
        return None
    turns = np.diff(angle - c.x)
    jumps = np.abs(turns) > np.pi
    return Symptom(int(jumps.sum()), angle)


def _unsigned(c: Channel) -> Symptom | None:
    """Find torques whose negative counts were stored as unsigned integers."""
    counts = signed(c.x)
    if counts is None:
        return None
    high = np.abs(counts - c.x)
    changed = high > last_digit(c.x) / 2
    return Symptom(int(changed.sum()), counts, {"span": high.max()})


def _outliers(c: Channel) -> Symptom | None:
    """Find single outliers, except torques that the motion follows."""
    at = outliers(c.x)
    if len(at) == 0:
        return None
    x = without(c.x, at)
    if c.key == "tau" and _follows(c.q, c.x - x):
        return None
    return Symptom(len(at), x)


def _follows(q: FloatArray, height: FloatArray) -> bool:
    """Return whether the speed of a joint changes at the peaks of its torque.

    h is the height of a torque peak, and e the change of the mean speed from before it to after it.
    For a torque that did not act, h e is zero on average.

    Args:
        q: (N,) position of the joint.
        height: (N,) heights of the torque peaks.
    """
    change, reach = np.zeros(len(q)), _AFTER + 1
    moved = q[_AFTER:] - q[:-_AFTER]
    change[reach:-reach] = moved[reach + 1 :] - moved[: -reach - 1]
    later = np.roll(change, 2 * _AFTER)
    earlier = np.roll(change, -2 * _AFTER)
    change -= (later + earlier) / 2
    size = float(np.linalg.norm(height) * rms(change))
    return abs(float(height @ change)) > _FOLLOWS * size


def _held(c: Channel) -> Symptom | None:
    """Find channels that hold their value between readings."""
    k = hold_length(c.x) if c.moves else 1
    if k == 1:
        return None
    first, _ = runs(c.x)
    t = c.log.t
    x = np.interp(t, t[first], c.x[first])
    return Symptom(len(x), x, {"k": k})


def _jitter(c: Channel) -> Symptom | None:
    """Find stamps with jitter: the motion is smoother along a uniform clock."""
    t, q = c.x, c.log.q
    step = np.diff(t)
    usual = np.median(step)
    if np.abs(step - usual).max() <= STEP_TOLERANCE * usual:
        return None
    clock = uniform_clock(t)
    if np.diff(clock).min() <= 0 or roughness(q, clock) >= _CLOCK * roughness(q, t):
        return None
    jitter = float(np.std(clock - t))
    return Symptom(len(t), clock, {"ms": 1e3 * jitter})


#: Rules for logs as recorded; their further data are the types of the joints.
RECORDED = (
    Rule("missing", ("q", "qd", "tau"), _missing, "empty cells", "interpolated"),
    Rule(
        "stalled", ("all",), _stalled,
        "rows that repeat the row before while the robot moves, up to {longest} s",
        "interpolated, or masked as a gap in time",
        lambda log, _, at: rows(log, at),
    ),
    Rule("wrapped", ("q",), _wrapped, "jumps of 2 pi", "unwrapped", with_values),
    Rule(
        "unsigned", ("tau",), _unsigned,
        "negative values are stored {span} too high, as unsigned integers", "subtracted",
        with_values,
    ),
    Rule(
        "jumps", ("q", "qd", "tau"), _outliers, "outliers", "replaced by interpolation",
        with_values,
    ),
    Rule(
        "held", ("q", "qd", "tau"), _held, "new values only every {k} samples", "interpolated",
        with_values,
    ),
    Rule(
        "jitter", ("t",), _jitter, "time stamps jitter by {ms} ms", "replaced by a uniform clock",
        lambda log, _, t: replace(log, t=read_only(t)),
    ),
)  # fmt: skip


# Samples with uniform steps.


def _gap(c: Channel) -> Symptom | None:
    """Find values that are missing for too long to interpolate."""
    return _masked(c, long_runs(_lost(c, c.about)))


def _masked(c: Channel, at: Bools, **numbers: float) -> Symptom | None:
    """Return the symptom of a mask (N,) at the times of the recorded log; None if it is empty.

    The numbers are those of the message, and also the measured quantities.
    """
    if not at.any():
        return None
    values = {name: (x, 0.0) for name, x in numbers.items()}
    mask = on_grid(at, c.about.t, c.log.t)
    return Symptom(int(at.sum()), mask, numbers, values)


def _saturated(c: Channel) -> Symptom | None:
    """Find clipped torques. A duty acts as recorded, also at its limit."""
    if c.about.drive_unit:
        return None
    x = _recorded(c)
    at = clipped(x)
    limit = float(np.abs(x[at]).max(initial=0.0))
    return _masked(c, at, limit=limit)


def _recorded(c: Channel) -> FloatArray:
    """Return the values of a channel in the recorded log, (N,)."""
    return np.ascontiguousarray(getattr(c.about, c.key)[:, c.joint])


def _stuck(c: Channel) -> Symptom | None:
    """Find a channel that keeps a value while the robot moves, for a part of the log."""
    if c.key == "qd" and c.about.qd is None:
        return None
    if c.key == "tau" and c.about.drive_unit:
        return None
    x = _recorded(c)
    at = _constant(c, x, c.about)
    if c.key == "tau":
        at &= ~clipped(x)
    # A mask does not repair a channel without a signal.
    return None if at.mean() > _DEAD else _masked(c, at)


def _constant(c: Channel, x: FloatArray, log: Log | Samples) -> Bools:
    """Return where a channel keeps a value much longer than usual while the robot moves, (N,).

    A position is compared with the measured speed, a speed with the position, and a torque with all
    positions. A stuck position or speed steps when it continues, if it does.

    Args:
        c: the channel of samples.
        x: (N,) its values in the log.
        log: the log as recorded, or the samples.
    """
    out = np.zeros(len(x), dtype=bool)
    first, lengths = runs(x)
    varied = lengths[lengths > 1]
    usual = np.percentile(varied, 90) if len(varied) > _VARIED else 1.0
    long = lengths >= max(_STUCK, _LONGER * usual)
    if not long.any() or not c.moves:
        return out
    moving = _moving(c, log)
    size = np.abs(np.diff(x, prepend=x[0], append=x[-1]))  # before and after each sample
    smallest = -1.0 if c.key == "tau" else _LEAVES * usual_step(x)
    for start, count in zip(first[long], lengths[long], strict=True):
        end = start + count
        steps_on = max(size[start], size[end]) > smallest
        steps_on |= count > _DEAD * len(x)
        if steps_on and 2 * moving[start:end].sum() >= count:
            out[start:end] = True
    return out


def _moving(c: Channel, log: Log | Samples) -> Bools:
    """Return where the other channels of a joint, or of the robot, show a motion, (N,)."""
    joint = slice(None) if c.key == "tau" else [c.joint or 0]
    if c.key != "q":
        q = c.log.q[:, joint]
        speeds = np.gradient(q, c.log.step, axis=0)
        return on_grid(_fast(speeds), c.log.t, log.t)
    if c.log.velocity_derived or log.qd is None:
        return np.ones(len(log.t), dtype=bool)
    return _fast(log.qd[:, joint])


def _fast(speeds: FloatArray) -> Bools:
    """Return where a joint is faster than a share of its RMS speed, (N,), from speeds (N, k)."""
    fast = np.abs(speeds) > _MOVES * rms(speeds)
    return np.asarray(fast.any(axis=1))


def _mask(samples: Samples, c: Channel, at: Bools) -> Samples:
    """Mask samples of the joints whose equations a channel affects: one for a torque, else all."""
    every = range(samples.q.shape[1])
    joints = [c.joint or 0] if c.key == "tau" else every
    return mask_samples(samples, at, joints)


#: Rules for samples with uniform steps; their further data are the recorded log.
MASKED = (
    Rule("gap", ("q", "qd"), _gap, "empty cells in a row", "masked, for all joints", _mask),
    Rule("gap", ("tau",), _gap, "empty cells in a row", "masked", _mask),
    Rule("saturated", ("tau",), _saturated, "clipped at {limit}", "masked", _mask),
    Rule(
        "stuck", ("q",), _stuck, "stuck", "masked, for all joints",
        lambda samples, c, at: bridged(samples, at, [c.joint or 0]),
    ),
    Rule(
        "stuck", ("qd",), _stuck, "stuck", "replaced by dq/dt",
        lambda samples, c, at: sloped(samples, at, c.joint or 0),
    ),
    Rule("stuck", ("tau",), _stuck, "stuck", "masked", _mask),
)  # fmt: skip


# Faults that need a new recording.


def unmended_faults(samples: Samples, passive: Sequence[int] = ()) -> Iterator[Fault]:
    """Find faults that need a new recording: channels without a signal, and positions with steps.

    Args:
        samples: a log with uniform steps.
        passive: indices of the joints without a motor, which have no torque.
    """
    for rule in LASTING:
        if findings := rule.search(samples, passive):
            yield rule.fault(findings)


def _dead(c: Channel) -> Symptom | None:
    """Find a channel that keeps one value for most of a log while the robot moves."""
    unknown = c.log.velocity_derived if c.key == "q" else c.joint in c.about
    at = np.flatnonzero(_constant(c, c.x, c.log))
    if unknown or len(at) <= _DEAD * len(c.x):
        return None
    since, until = c.log.t[at[[0, -1]]]
    return Symptom(len(at), numbers={"since": since, "until": until})


def _steps(c: Channel) -> Symptom | None:
    """Find positions that jump from one sample to the next."""
    at = steps(c.x)
    if len(at) == 0 or not c.moves:
        return None
    k = int(at[0])
    size = c.x[k + 1] - c.x[k]
    return Symptom(len(at), numbers={"size": size, "at": c.log.t[k]})


_CONSTANT = (
    "{channels} of {log} is constant from t = {since} s to {until} s while the robot moves: check "
    "the sensor"
)
#: Rules for faults that need a new recording; their further data are the passive joints.
LASTING = (
    Rule("stuck", ("q",), _dead, _CONSTANT),
    Rule("stuck", ("tau",), _dead, f"{_CONSTANT}; if no motor drives the joint, {WITHOUT_MOTOR}"),
    Rule(
        "step", ("q",), _steps,
        "{channels} of {log} jumps by {size} from one sample to the next at t = {at} s: leave "
        "that time out, or check the sensor",
    ),
)  # fmt: skip
