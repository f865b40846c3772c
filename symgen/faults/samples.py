"""Faults that samples alone show. Each has one rule, which also undoes it.

The first rules look at a log as recorded, and the others at its samples with uniform steps. What
cannot be undone in samples is left for a new record. Thresholds are ratios to the usual steps and
the last digit of a channel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from symgen import names
from symgen.data.log import Log, long_runs, rows
from symgen.data.mask import Bools, moving_joints, on_grid, rms, spans
from symgen.data.raw import FloatArray, Places, read_only
from symgen.data.signals import STEP_TOLERANCE, Samples
from symgen.data.stretch import GAP
from symgen.estimation.filtered_log import FilteredLog
from symgen.faults.channels import (
    FEW_DIGITS,
    clipped,
    held_for,
    least_step,
    moves,
    outliers,
    resolution,
    runs,
    same_rows,
    signed,
    steps,
    unwrapped,
    usual_step,
    without,
)
from symgen.faults.fault import Fault
from symgen.faults.rules import Rule, Symptom, apply
from symgen.faults.undo import bridged, left_out, mask_samples, moved_back, sloped, with_column
from symgen.robot.types import WITHOUT_MOTOR

#: Step of a position after rows that are held, over the steps before and after; number of rows
#: that are no chance.
_CATCHES_UP, _CHANCE = 1.5, 3
_BRIEF = 3  # rows of a stall that are interpolated
#: Samples before and after a torque that show whether the motion follows it, and standard
#: deviations of that.
_AFTER, _FOLLOWS = 5, 4.0
#: Steps relative to the spread, above which a channel is coarse; encoders are finer.
_COARSE = {"q": 2e-3, "qd": 0.05, "tau": 0.05}
_LOOKED_AT = 4096  # samples that rule out most channels
#: Largest disagreement of neighbouring speeds with a uniform clock, over that with the stamps.
_CLOCK = 0.8
#: Shortest run of a channel that is stuck, in samples and over its other runs; smallest step after
#: it, in usual steps; speed of a moving joint over its RMS; share of a log without a signal.
_STUCK, _LONGER, _LEAVES, _MOVES, _DEAD = 20, 10.0, 3.0, 0.1, 0.5


def repaired(log: Log, sigma: Sequence[int]) -> tuple[Log, tuple[Fault, ...]]:
    """Repair what single samples of a log as recorded show.

    Args:
        log: the log, mapped to the joint side.
        sigma: types of the joints.
    """
    converted = [
        Fault(log.name, columns, unit, 0, done, kind="converted")
        for columns, unit, done in log.converted
    ]
    log, faults = apply(RECORDED, log, sigma)
    return log, (*converted, *faults)


def masked_stalls(log: Log, samples: Samples) -> Samples:
    """Mask the rows of stalls of the recorder that are too long to be interpolated.

    Args:
        log: the log without these rows.
        samples: the log with uniform steps.
    """
    steps = np.round(np.diff(log.t) / samples.step)
    after = np.clip(np.searchsorted(log.t, samples.t), 1, len(log.t) - 1)
    inside = (samples.t > log.t[after - 1]) & (samples.t < log.t[after])
    at = inside & (steps[after - 1] > _BRIEF + 1)
    return mask_samples(samples, at, range(samples.q.shape[1]))


def masked_gaps(log: Log, samples: Samples) -> tuple[Samples, tuple[Fault, ...]]:
    """Mask values that are missing for too long to be interpolated.

    Args:
        log: the log before it was resampled.
        samples: the log with uniform steps.
    """
    return apply(GAPS, samples, log)


def masked_faults(log: Log, samples: Samples) -> tuple[Samples, tuple[Fault, ...]]:
    """Mask clipped torques and stuck channels in a log with uniform steps.

    Args:
        log: the log before it was resampled.
        samples: the log with uniform steps.
    """
    return apply(SAMPLED, samples, log)


def _channels(log: Log | Samples, moving: bool = False) -> Iterator[tuple[str, int, FloatArray]]:
    """Yield the channels of a log: key, joint, and values (N,).

    Args:
        log: the log.
        moving: whether joints are left out that stay within a few last digits of their position.
    """
    n = log.q.shape[1]
    joints = [j for j in range(n) if not moving or moves(log.q[:, j])]
    for key in ("q", "qd", "tau"):
        x = getattr(log, key)
        for j in joints if x is not None else ():
            yield key, j, np.ascontiguousarray(x[:, j])


# Logs as recorded.


def _lost(log: Log) -> Iterator[tuple[str, int, Bools]]:
    """Yield channels with missing values: key, joint, and a mask (N,)."""
    if log.missing is not None:
        for k, key in enumerate(("q", "qd", "tau")):
            for j in map(int, np.flatnonzero(log.missing[:, :, k].any(axis=0))):
                yield key, j, log.missing[:, j, k]


def _missing(log: Log, _: object) -> Iterator[Symptom]:
    """Find values that were missing for a short time and interpolated while reading."""
    for key, j, lost in _lost(log):
        short = int((lost & ~long_runs(lost)).sum())
        if short:
            yield Symptom(key, j, short)


def _stalled(log: Log, _: object) -> Iterator[Symptom]:
    """Find rows that repeat the row before in all channels while the robot moves.

    A robot at rest, or slower than the last digit of its positions, repeats rows as well. After a
    stall of the recorder, a position catches up: it steps further than before and after. Where half
    of the short repetitions end so, all of them are stalls.
    """
    arrays = [x for x in (log.q, log.qd, log.tau) if x is not None]
    same = same_rows(arrays)
    held = spans(same)
    fresh = np.flatnonzero(np.concatenate([[True], ~same]))
    place = np.searchsorted(fresh, held[:, 0])
    held = held[(place > 0) & (place + 2 < len(fresh))]
    if len(held) == 0:
        return
    place = np.searchsorted(fresh, held[:, 0])
    before, first, after, last = (fresh[place + k] for k in (-1, 0, 1, 2))
    usual = np.maximum(
        np.abs(log.q[first] - log.q[before]) / (first - before)[:, None],
        np.abs(log.q[last] - log.q[after]) / (last - after)[:, None],
    )
    step = np.abs(log.q[after] - log.q[first])
    digits = FEW_DIGITS * np.array([least_step(x) for x in log.q.T])
    stalls = ((step >= _CATCHES_UP * usual) & (step > digits)).any(axis=1)
    short = held[:, 1] - held[:, 0] < GAP
    if 2 * stalls[short].sum() >= short.sum():
        stalls |= short
    at = np.zeros(len(log.t), dtype=bool)
    for start, end in held[stalls]:
        at[start + 1 : end + 1] = True
    if at.sum() > _CHANCE:
        longest = float(np.diff(log.t[held[stalls]]).max())
        yield Symptom("all", None, int(at.sum()), ~at, {"longest": longest})


def _without_rows(log: Log, found: Symptom) -> Log:
    return rows(log, found.data)


def _wrapped(log: Log, sigma: Sequence[int]) -> Iterator[Symptom]:
    """Find angles that jump by a turn between samples of a slow motion."""
    for key, j, x in _channels(log):
        whole = unwrapped(x, 2 * np.pi) if key == "q" and sigma[j] != names.PRISMATIC else None
        if whole is not None:
            yield Symptom(key, j, int(np.sum(np.abs(np.diff(whole - x)) > np.pi)), whole)


def _unsigned(log: Log, _: object) -> Iterator[Symptom]:
    """Find torques whose negative counts were stored as unsigned integers."""
    for key, j, x in _channels(log):
        counts = signed(x) if key == "tau" else None
        if counts is not None:
            wrong = int(np.sum(np.abs(counts - x) > least_step(x) / 2))
            yield Symptom(key, j, wrong, counts, {"span": np.abs(counts - x).max()})


def _with_values(log: Log, found: Symptom) -> Log:
    assert found.joint is not None
    return with_column(log, found.channel, found.joint, found.data)


def _outliers(log: Log, _: object) -> Iterator[Symptom]:
    """Find single samples that stand out, but for torques that the motion follows."""
    for key, j, x in _channels(log):
        at = outliers(x)
        if len(at) and not (key == "tau" and _follows(log.q[:, j], x, at)):
            yield Symptom(key, j, len(at), without(x, at))


def _follows(q: FloatArray, tau: FloatArray, at: Places) -> bool:
    """Return whether the speed of a joint changes where its torque stands out.

    With h the height of the torque and e the change of the mean speed from the samples before it
    to those after it, h e is zero on average for a torque that was not there.

    Args:
        q, tau: (N,) position and torque of the joint.
        at: the samples that stand out.
    """
    k = np.arange(_AFTER + 1, len(q) - _AFTER - 1)
    change = np.zeros(len(q))
    change[k] = (q[k + _AFTER + 1] - q[k + 1]) - (q[k - 1] - q[k - _AFTER - 1])
    smooth = 2 * _AFTER
    change[smooth:-smooth] -= (change[2 * smooth :] + change[: -2 * smooth]) / 2
    height = (tau - without(tau, at))[at]
    size = float(np.linalg.norm(height) * rms(change))
    return abs(float(height @ change[at])) > _FOLLOWS * size


def _held(log: Log, _: object) -> Iterator[Symptom]:
    """Find channels that hold their value between readings."""
    for key, j, x in _channels(log, moving=True):
        k = held_for(x)
        if k > 1:
            first, _lengths = runs(x)
            drawn = np.interp(log.t, log.t[first], x[first])
            yield Symptom(key, j, len(x), drawn, {"k": k})


def _coarse(log: Log, _: object) -> Iterator[Symptom]:
    """Find channels with a coarse resolution, relative to their motion."""
    for key, j, x in _channels(log, moving=True):
        size = float(np.std(x))
        least = _COARSE[key] * size
        # The resolution is at most the smallest step.
        if any(1.5 * least_step(part) <= least for part in (x[:_LOOKED_AT], x)):
            continue
        step = resolution(x)
        if step > least:
            yield Symptom(key, j, len(x), None, {"step": step, "percent": 100 * step / size})


def _jitter(log: Log, _: object) -> Iterator[Symptom]:
    """Find stamps that jitter: positions are smoother along a uniform clock."""
    step = np.diff(log.t)
    usual = float(np.median(step))
    if np.abs(step - usual).max() <= STEP_TOLERANCE * usual:
        return
    rows_lost = np.cumsum(np.maximum(np.round(step / usual), 1.0))
    counts = np.arange(len(log.t), dtype=float), np.concatenate([[0.0], rows_lost])
    clocks = [_line(count, log.t) for count in counts]
    clock = min(clocks, key=lambda x: float(np.median(np.abs(x - log.t))))
    if np.diff(clock).min() > 0 and _roughness(log.q, clock) < _CLOCK * _roughness(log.q, log.t):
        numbers = {"ms": 1e3 * float(np.std(clock - log.t))}
        yield Symptom("t", None, len(clock), clock, numbers)


def _line(index: FloatArray, t: FloatArray) -> FloatArray:
    """Return the times of the uniform clock nearest to the stamps (least absolute errors)."""
    weight = np.ones(len(t))
    clock = t
    for _ in range(8):  # reweighting removes the influence of late stamps
        slope, start = np.polyfit(index, t, 1, w=np.sqrt(weight))
        clock = start + slope * index
        weight = 1 / np.maximum(np.abs(t - clock), 1e-3 * slope)
    return clock


def _roughness(q: FloatArray, t: FloatArray) -> float:
    """Return the usual change of the speed from step to step, a geometric mean over the joints."""
    change = np.diff(q, axis=0)
    moving = np.abs(change) >= np.maximum(np.median(np.abs(change), axis=0), 1e-300)
    rough = np.abs(np.diff(change / np.diff(t)[:, None], axis=0))
    both = moving[1:] & moving[:-1]
    sizes = [np.median(x[at]) for x, at in zip(rough.T, both.T, strict=True) if at.any()]
    sizes = [size for size in sizes if size > 0]
    return float(np.exp(np.mean(np.log(sizes)))) if sizes else 0.0


def _with_clock(log: Log, found: Symptom) -> Log:
    return replace(log, t=read_only(found.data))


#: Rules for logs as recorded: each finder takes the log and the types of its joints.
RECORDED = (
    Rule("missing", _missing, "empty cells", "interpolated"),
    Rule(
        "stalled", _stalled, "rows that repeat the row before while the robot moves, up to "
        "{longest} s", f"interpolated up to {_BRIEF} in a row, masked beyond", _without_rows,
    ),
    Rule("wrapped", _wrapped, "jumps of 2 pi", "unwrapped", _with_values),
    Rule(
        "unsigned", _unsigned, "negative values are stored {span} too high, as unsigned integers",
        "subtracted", _with_values,
    ),
    Rule("jumps", _outliers, "outliers", "replaced by interpolation", _with_values),
    Rule("held", _held, "new values only every {k} samples", "interpolated", _with_values),
    Rule("coarse", _coarse, "comes in steps of {step}, {percent} % of its spread"),
    Rule(
        "jitter", _jitter, "time stamps jitter by {ms} ms", "replaced by a uniform clock",
        _with_clock,
    ),
)  # fmt: skip


# Samples with uniform steps.


def _gap(samples: Samples, log: Log, torques: bool) -> Iterator[Symptom]:
    """Find values that are missing for too long to be interpolated."""
    for key, j, lost in _lost(log):
        long = long_runs(lost)
        if long.any() and (key == "tau") == torques:
            yield Symptom(key, j, int(long.sum()), on_grid(long, log.t, samples.t))


def _saturated(samples: Samples, log: Log) -> Iterator[Symptom]:
    """Find clipped torques."""
    for key, j, x in _channels(log):
        at = clipped(x) if key == "tau" else np.zeros(0, dtype=bool)
        if at.any():
            limit = float(np.abs(x[at]).max())
            where = on_grid(at, log.t, samples.t)
            values = {"limit": (limit, 0.0)}
            yield Symptom(key, j, int(at.sum()), where, {"limit": limit}, values)


def _stuck(samples: Samples, log: Log, key: str) -> Iterator[Symptom]:
    """Find a channel that keeps a value much longer than usual while the robot moves."""
    for channel, j, x in _channels(log, moving=True):
        if channel != key:
            continue
        at = _constant(x, key, _moving(samples, log, key, j))
        if key == "tau":
            at &= ~clipped(x)
        if at.any() and at.mean() <= _DEAD:  # a mask does not repair a channel without a signal
            yield Symptom(key, j, int(at.sum()), on_grid(at, log.t, samples.t))


def _constant(x: FloatArray, key: str, moving: Bools) -> Bools:
    """Return where a channel keeps a value much longer than usual while the robot moves, (N,).

    A position or a speed that is stuck steps when it ends; a robot at rest does not.
    """
    out = np.zeros(len(x), dtype=bool)
    first, lengths = runs(x)
    varied = lengths[lengths > 1]
    usual = np.percentile(varied, 90) if len(varied) > 10 else 1.0
    long = lengths >= max(_STUCK, _LONGER * usual)
    if not long.any():
        return out
    size = np.abs(np.diff(x, prepend=x[0], append=x[-1]))  # before and after each sample
    least = -1.0 if key == "tau" else _LEAVES * usual_step(x)
    for start, end in zip(first[long], (first + lengths)[long], strict=True):
        if moving[start:end].mean() >= 0.5 and max(size[start], size[end]) > least:
            out[start:end] = True
    return out


def _moving(samples: Samples, log: Log, key: str, j: int) -> Bools:
    """Return where the robot moves, by other channels than one of joint j, at the log's times.

    A position is compared with the speed, a speed with the position, a torque with all positions.
    """
    if key == "q":
        return np.ones(len(log.t), dtype=bool) if log.qd is None else _fast(log.qd[:, [j]])
    joints = [j] if key == "qd" else range(log.q.shape[1])
    fast = _fast(np.gradient(samples.q[:, joints], samples.step, axis=0))
    return on_grid(fast, samples.t, log.t)


def _fast(speeds: FloatArray) -> Bools:
    """Return where a joint is faster than a part of its RMS speed, (N,), from speeds (N, k)."""
    return np.asarray((np.abs(speeds) > _MOVES * rms(speeds)).any(axis=1))


def _mask(samples: Samples, found: Symptom) -> Samples:
    """Mask what was found, for its joint if it is a torque, and for all joints otherwise."""
    n = samples.q.shape[1]
    joints = [found.joint or 0] if found.channel == "tau" else range(n)
    return mask_samples(samples, found.data, joints)


def _bridge(samples: Samples, found: Symptom) -> Samples:
    return bridged(samples, found.data, [found.joint or 0])


def _slope(samples: Samples, found: Symptom) -> Samples:
    return sloped(samples, found.data, found.joint or 0)


#: Rules for samples with uniform steps: each finder takes them and the log as recorded.
GAPS = tuple(
    Rule("gap", partial(_gap, torques=torques), "empty cells in a row", done, _mask)
    for torques, done in ((False, "masked, for all joints"), (True, "masked"))
)
SAMPLED = (
    Rule("saturated", _saturated, "clipped at {limit}", "masked", _mask),
    Rule("stuck", partial(_stuck, key="q"), "stuck", "masked, for all joints", _bridge),
    Rule("stuck", partial(_stuck, key="qd"), "stuck", "replaced by dq/dt", _slope),
    Rule("stuck", partial(_stuck, key="tau"), "stuck", "masked", _mask),
)


# What needs a new record.


def unmended_faults(
    samples: Samples, sigma: Sequence[int], passive: Sequence[int] = ()
) -> Iterator[Fault]:
    """Find faults that need a new record: channels without a signal, and positions that step.

    The undo of each takes a log in the band of a run.

    Args:
        samples: a log with uniform steps.
        sigma: types of the joints.
        passive: places of the joints that no motor drives: they have no torque.
    """
    for rule in LASTING:
        found = list(rule.find(samples, sigma, passive))
        if found:
            undo = partial(_undo, name=samples.name, rule=rule, found=found)
            yield replace(rule.fault(samples.name, found, samples.q.shape[1]), undo=undo)


def _undo(log: FilteredLog, name: str, rule: Rule, found: Sequence[Symptom]) -> FilteredLog:
    """Return the log with this name without what was found in it."""
    return rule.undone(log, found) if log.name == name else log


def _dead(
    samples: Samples, sigma: Sequence[int], passive: Sequence[int], key: str
) -> Iterator[Symptom]:
    """Find a position or a torque that keeps one value for most of a log while its joint moves."""
    known = key == "tau" or not samples.velocity_derived  # how the joint moves
    for j in moving_joints([samples.qd], sigma) if known else ():
        if key == "tau" and j in passive:
            continue
        first, lengths = runs(np.ascontiguousarray(getattr(samples, key)[:, j]))
        k = int(np.argmax(lengths))
        at = slice(int(first[k]), int(first[k] + lengths[k]))
        there = _fast(samples.qd[:, [j]])[at]
        if lengths[k] > _DEAD * len(samples.t) and there.mean() >= 0.5:
            times = {"since": samples.t[at][0], "until": samples.t[at][-1]}
            yield Symptom(key, j, int(lengths[k]), at, times)


def _steps(samples: Samples, *_: object) -> Iterator[Symptom]:
    """Find positions that jump from one sample to the next."""
    for key, j, x in _channels(samples, moving=True):
        at = steps(x) if key == "q" else np.zeros(0, dtype=np.int64)
        if len(at):
            k = int(at[0])
            yield Symptom(key, j, len(at), at, {"size": x[k + 1] - x[k], "at": samples.t[k]})


def _leave_out(log: FilteredLog, found: Symptom) -> FilteredLog:
    joints = [found.joint or 0] if found.channel == "tau" else range(log.q.shape[1])
    return left_out(log, log.name, found.data, joints)


def _move_back(log: FilteredLog, found: Symptom) -> FilteredLog:
    return moved_back(log, log.name, found.joint or 0, found.data)


_CONSTANT = (
    "{channels} of {log} is constant from t = {since} s to {until} s while the joint moves: check "
    "the sensor"
)
#: Rules for what needs a new record: each finder takes samples, types of joints, passive joints.
LASTING = (
    Rule("stuck", partial(_dead, key="q"), _CONSTANT, undo=_leave_out),
    Rule(
        "stuck", partial(_dead, key="tau"),
        f"{_CONSTANT}; if no motor drives the joint, {WITHOUT_MOTOR}", undo=_leave_out,
    ),
    Rule(
        "step", _steps, "{channels} of {log} jumps by {size} from one sample to the next at "
        "t = {at} s: leave that time out, or check the sensor", undo=_move_back,
    ),
)  # fmt: skip
