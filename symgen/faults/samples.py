"""Faults that samples alone show. Each has one finder, which also corrects it.

Repeated rows are dropped. Time stamps with jitter are replaced by a uniform clock if positions then
agree better with speeds. Single samples that jump are replaced (Hampel 1974). Jumps of 2 pi are
unwrapped. Clipped torques and stuck channels are masked. Measured speeds that are late, scaled or
offset against dq/dt are corrected. A repair is made only if the compared channels agree better
afterwards. Thresholds are ratios to the signal's own scatter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from symgen import names
from symgen.data.log import Log, long_runs, rows
from symgen.data.mask import Bools, moving_joints, on_grid, rms, spans, touched
from symgen.data.raw import FloatArray, Places, read_only
from symgen.data.signals import (
    NORMAL,
    STEP_TOLERANCE,
    Samples,
    interpolated,
    lowpass,
    lowpass_and_slopes,
    noise_of_differences,
    white_noise,
)
from symgen.data.stretch import GAP, holes
from symgen.estimation.band import OPEN
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.summary import solve_gram
from symgen.faults.fault import Fault, fault_of, undo_faults
from symgen.faults.undo import (
    bridged,
    derived,
    left_out,
    masked,
    moved_back,
    shifted,
    sloped,
    with_column,
)
from symgen.robot.types import WITHOUT_MOTOR

#: Largest disagreement with a uniform clock, relative to that with the stamps, to use the clock.
_CLOCK = 0.8
#: Factor of repeated rows over the number expected by chance, and their smallest number.
_CHANCE, _FEW = 5.0, 3
#: Smallest number of runs of a held channel, and shares of the log and of the runs.
_HELD_RUNS, _HELD, _PACED = 20, 0.9, 0.4
_FIRST = 4096  # samples of a channel that are checked before all of it
#: Steps relative to the spread, above which a channel is reported as coarse; encoders are finer.
_COARSE = {"q": 2e-3, "qd": 0.05, "tau": 0.05}
#: Smallest jump, relative to the scatter of its channel, and to its surroundings.
_JUMP, _AROUND = 12.0, 4.0
_NEAR = 8  # samples around a jump that it is compared with
#: Expected number of adjacent jumps above which pairs are searched; largest share of jumps; passes.
_MEET, _MANY, _PASSES = 0.1, 0.05, 4
#: Smallest number of samples at the extreme of a clipped torque, and their ratio to those below.
_FLAT, _PILED = 10, 4.0
_RUN = 3  # times the runs of other values
#: Shortest run of a stuck channel in samples, and in lengths of its other runs.
_STUCK, _LONGER = 20, 10.0
_DEAD = 0.5  # of the log
_SILENT = 3.0  # standard deviations of the RMS of noise by which a torque must exceed noise
#: Smallest jump of a position after it was stuck, over its largest usual step.
_LEAVES = 3.0
#: Speed of a moving robot, relative to the RMS over the log.
_MOVES = 0.1
#: Largest remaining part of the squared disagreement for a repair of speeds.
_SPEEDS = 0.8
#: Correlation of speeds with dq/dt below which dq/dt replaces them.
_FOLLOWS = 0.9
_LATE, _SCALED = 0.1, 0.02  # smallest delay in samples, and smallest relative scale error
_NOISY = 2.0  # error of a speed over its noise, above which it does not follow the position
_SETTLED = 1e-3  # in samples
_STILL = 3.0  # noise std in the band, below which a position is noise
_SLOPES = 5.0  # band of that comparison, in comparison bands
#: Smallest step over the largest usual difference (99th percentile), and distance in samples.
_STEP, _APART = 5.0, 5
#: Relative noise that every measured torque exceeds, and samples needed to estimate it.
_NOISE, _SIXTH = 1e-4, 100
#: Noise that every measured position exceeds, rad or m; an encoder of 20 bits has 1.7e-6 rad.
_ENCODER = 1e-6


def repaired(log: Log, sigma: Sequence[int]) -> tuple[Log, tuple[Fault, ...]]:
    """Repair the faults that single samples show, in a log as recorded.

    Args:
        log: the log, mapped to the joint side.
        sigma: types of the joints.
    """
    ticks = np.flatnonzero(~repeated_rows(log)).astype(float)
    told: list[Fault] = []
    for find in FINDERS.values():
        log, found = undo_faults(log, find(log, sigma, ticks))
        told += found
    return log, tuple(told)


def masked_faults(log: Log, samples: Samples) -> tuple[Samples, tuple[Fault, ...]]:
    """Mask clipped torques and stuck channels in a log with uniform steps.

    Args:
        log: the log before it was resampled.
        samples: the log with uniform steps.
    """
    assert log.tau is not None  # open_log requires it
    flat = np.column_stack([cut_off(np.ascontiguousarray(x)) for x in log.tau.T])
    return undo_faults(samples, (*_saturated(log, samples, flat), *_stuck(log, samples, flat)))


def _channels(log: Log) -> Iterator[tuple[str, int, FloatArray]]:
    """Yield the channels of a log: key, joint, and values (N,)."""
    for key in ("q", "qd", "tau"):
        x = getattr(log, key)
        for j in range(0 if x is None else x.shape[1]):
            yield key, j, np.ascontiguousarray(x[:, j])


def _converted(log: Log, *_: object) -> Iterator[Fault]:
    """Yield columns that were converted from another unit while reading."""
    for columns, unit, done in log.converted:
        yield Fault(log.name, columns, unit, 0, done, kind="converted")


def _missing(log: Log, *_: object) -> Iterator[Fault]:
    """Yield values that were missing for a short time and interpolated while reading."""
    for key, j, lost in _lost(log):
        short = int((lost & ~long_runs(lost)).sum())
        if short:
            yield fault_of(log.name, "missing", key, j, "empty cells", short, "interpolated")


def _lost(log: Log) -> Iterator[tuple[str, int, Bools]]:
    """Yield channels with missing values: key, joint, and a mask (N,)."""
    if log.missing is not None:
        for k, key in enumerate(("q", "qd", "tau")):
            for j in map(int, np.flatnonzero(log.missing[:, :, k].any(axis=0))):
                yield key, j, log.missing[:, j, k]


def masked_gaps(log: Log, samples: Samples) -> tuple[Samples, tuple[Fault, ...]]:
    """Mask values that are missing for too long to be interpolated.

    Args:
        log: the log before it was resampled.
        samples: the log with uniform steps.
    """
    found, everyone = list[Fault](), range(log.q.shape[1])
    for key, j, lost in _lost(log):
        long = long_runs(lost)
        if long.any():
            joints, done = ([j], "masked") if key == "tau" else (everyone, "masked, for all joints")
            undo = partial(masked, at=on_grid(long, log.t, samples.t), joints=joints)
            count = int(long.sum())
            found.append(
                fault_of(log.name, "gap", key, j, "empty cells in a row", count, done, undo)
            )
    return undo_faults(samples, found)


def _repeated(log: Log, _: object, ticks: FloatArray) -> Iterator[Fault]:
    """Find rows that repeat the values of the row before."""
    count = len(log.t) - len(ticks)
    if count:
        undo = partial(rows, chosen=np.isin(np.arange(len(log.t)), ticks))
        fault = "repeated rows"
        yield Fault(log.name, "all", fault, count, "dropped", kind="repeated", undo=undo)


def repeated_rows(log: Log) -> Bools:
    """Find rows that repeat the values of the row before more often than by chance: (N,).

    Channels at rest, or with a motion below their last digit, repeat by themselves. Rows count as
    repeated if all channels repeat together, much more often than independent channels would.
    Longer repetitions are a robot at rest or a stuck recorder, and do not count.
    """
    arrays = [x for x in (log.q, log.qd, log.tau) if x is not None]
    whole, out = same_rows(arrays), np.zeros(len(log.t), dtype=bool)
    if whole.sum() <= _FEW:
        return out
    same = np.concatenate([np.mean(x[1:] == x[:-1], axis=0) for x in arrays])
    if whole.sum() <= _CHANCE * float(np.prod(same)) * len(whole) + _FEW:
        return out
    for start, end in spans(whole):
        if end - start < GAP - 1:
            out[start + 1 : end + 1] = True
    return out


def same_rows(arrays: Sequence[FloatArray]) -> Bools:
    """Return which rows repeat the row before in all columns, (N - 1,)."""
    out = np.ones(len(arrays[0]) - 1, dtype=bool)
    for column in (column for x in arrays for column in x.T):
        if not out.any():
            break
        out &= column[1:] == column[:-1]
    return out


def _wrapped(log: Log, sigma: Sequence[int], _: object) -> Iterator[Fault]:
    """Find jumps of 2 pi between samples of a slow motion."""
    for j, kind in enumerate(sigma):
        steps = np.diff(log.q[:, j])
        if kind == names.PRISMATIC or np.abs(steps).max(initial=0.0) <= np.pi:
            continue
        turns = np.round(steps / (2 * np.pi))
        off = np.abs(steps - 2 * np.pi * turns)
        others = float(np.max(np.abs(steps[turns == 0]), initial=0.0))
        wrapped = (turns != 0) & (off <= max(2 * others, 1e-6))
        if not wrapped.any() or others > 1.0:
            continue
        whole = log.q[:, j].copy()
        whole[1:] -= 2 * np.pi * np.cumsum(np.where(wrapped, turns, 0.0))
        count = int(wrapped.sum())
        yield _mended(log, "wrapped", "q", j, whole, "jumps of 2 pi", count, "unwrapped")


def _mended(
    log: Log | Samples,
    kind: str,
    key: str,
    j: int,
    x: FloatArray,
    fault: str,
    count: int,
    done: str,
) -> Fault:
    """Return the fault of a channel whose corrected values are x (N,)."""
    undo = partial(with_column, key=key, j=j, x=x)
    return fault_of(log.name, kind, key, j, fault, count, done, undo)


def _jumping(log: Log, *_: object) -> Iterator[Fault]:
    """Find one or two samples that jump away from the line between their neighbours."""
    for key, j, x in _channels(log):
        at = jumps(x)
        if len(at):
            what = "outliers", len(at), "replaced by interpolation"
            yield _mended(log, "jumps", key, j, without(x, at), *what)


def jumps(x: FloatArray) -> Places:
    """Return the indices of single samples that stand out from their neighbours.

    The residual r_k = x_k - median(x_(k-3) .. x_(k+3)) of a jump is the jump; at a step, as of
    friction at a reversal, it is almost zero (Hampel 1974). A jump has |r_k| above 12 times the
    scatter of x_k - (x_(k-1) + x_(k+1))/2 (median absolute deviation, or the last digit), which
    includes the curvature of the signal, and above 4 times the values around it. After jumps are
    found, others that they masked are searched for. If jumps are so frequent that two meet by
    chance, pairs are searched for. A jump leaves both neighbours in the same direction; the corner
    at which a braking torque ends at standstill does not.
    """
    found: set[int] = set()
    for _ in range(_PASSES):
        meet = len(found) ** 2 > _MEET * len(x)
        more = _outstanding(x, 2 if meet else 1, 1 if found else 0)
        if len(more) == 0:
            break
        found.update(map(int, more))
        x = without(x, more)
        if len(found) > _MANY * len(x):  # these are the signal
            return np.zeros(0, dtype=np.int64)
    return np.array(sorted(found), dtype=np.int64)


def _usual_step(x: FloatArray) -> float:
    """Return the 99th percentile of a signal's steps; inf if it never changes."""
    size = np.abs(np.diff(x))
    return float(np.quantile(size[size > 0], 0.99)) if size.any() else np.inf


def least_step(x: FloatArray) -> float:
    """Return the smallest non-zero step between samples; inf if there is none."""
    steps = np.abs(np.diff(x))
    return float(np.min(steps, where=steps > 0, initial=np.inf))


def _outstanding(x: FloatArray, together: int, others: int) -> Places:
    """Return the samples that stand out from those around.

    Args:
        x: the signal.
        together: largest number of adjacent samples that stand out.
        others: number of jumps that may be near.
    """
    none = np.zeros(0, dtype=np.int64)
    if len(x) < 2 * _NEAR:
        return none
    size = x[:-2] + x[2:]  # in place, because logs can be long
    size *= -0.5
    size += x[1:-1]
    np.abs(size, out=size)
    largest = float(size.max())
    # The median is usually far above zero: nothing stands out, and no sort is needed.
    if 2 * np.count_nonzero(size >= 2 * largest / (_JUMP * NORMAL)) > len(size):
        return none
    digit = least_step(x)
    _, lengths = runs(x)
    moves = np.repeat(lengths < _STUCK, lengths)[1:-1]  # the scatter excludes stuck channels
    scatter = NORMAL * float(np.median(size[moves])) if moves.any() else 0.0
    least = _JUMP * max(scatter, digit if np.isfinite(digit) else 0.0)
    if least == 0.0 or largest <= least / 2:
        return none
    windows = np.lib.stride_tricks.sliding_window_view
    signed: FloatArray = np.zeros(len(x))
    signed[3:-3] = x[3:-3] - np.median(windows(x, 7), axis=1)
    r = np.abs(signed)
    out: list[int] = []
    for k in map(int, np.flatnonzero(r > least)):
        low, high = max(k - _NEAR, 0), min(k + _NEAR + 1, len(x))
        first, end = max(k - together + 1, 0), k + together
        around = [*range(low, first), *range(end, high)]
        # An adjacent value that jumps in the other direction is another jump.
        near = r[[i for i in around if abs(i - k) > 1 or signed[i] * signed[k] >= 0]]
        if _there_and_back(x, k, together) < r[k] / 2:
            continue  # a corner of the signal
        if r[k] > _AROUND * float(np.sort(near)[-1 - others]):
            out.append(k)
    return np.array(out, dtype=np.int64)


def _there_and_back(x: FloatArray, k: int, together: int) -> float:
    """Return how far a sample stands out from both sides in the same direction.

    Each side is its nearest sample, or the line through two samples, whichever is nearer.
    """
    s = np.arange(1, together + 1)

    def side(way: int) -> float:
        last, before = x[k + way * s], x[k + way * (s + 1)]
        own, line = x[k] - last, x[k] - (last + s * (last - before))
        return float(max(np.where(np.abs(line) < np.abs(own), line, own), key=abs))

    left, right = side(-1), side(1)
    return min(abs(left), abs(right)) if left * right > 0 else 0.0


def without(x: FloatArray, at: Places) -> FloatArray:
    """Return a signal with some samples replaced by interpolation."""
    good = np.setdiff1d(np.arange(len(x)), at)
    out = x.copy()
    out[at] = np.interp(at, good, x[good])
    return out


def _held(log: Log, *_: object) -> Iterator[Fault]:
    """Find channels that hold their value between readings."""
    for key, j, x in _channels(log):
        k = held_for(x)
        if k > 1:
            first, _lengths = runs(x)
            inside = log.t <= log.t[first[-1]]
            drawn = x.copy()
            drawn[inside] = interpolated(log.t[first], x[first])(log.t[inside])
            fault = f"new values only every {k} samples"
            yield _mended(log, "held", key, j, drawn, fault, len(x), "interpolated")


def runs(x: FloatArray) -> tuple[Places, Places]:
    """Return where each run of one value starts, and its length in samples."""
    first = np.flatnonzero(np.concatenate([[True], x[1:] != x[:-1]]))
    return first, np.diff(np.concatenate([first, [len(x)]]))


def held_for(x: FloatArray) -> int:
    """Return for how many samples a channel holds each value; 1 if it does not.

    Two fifths of its runs have that length, and nine tenths differ from it by at most one sample.
    Longer runs, of a robot at rest, are left out. A coarse channel has runs of any length.
    """
    if 1.5 * (1 + np.count_nonzero(x[1:] != x[:-1])) > len(x):  # half of the runs have length 1
        return 1
    _, lengths = runs(x)
    k = round(float(np.median(lengths)))
    short = lengths[lengths <= 2 * k + 1]
    if k == 1 or len(short) < _HELD_RUNS:
        return 1
    paced = np.mean(short == k) >= _PACED and np.mean(np.abs(short - k) <= 1) >= _HELD
    return k if paced else 1


def _coarse(log: Log, *_: object) -> Iterator[Fault]:
    """Find channels with a coarse resolution, relative to their motion."""
    for key, j, x in _channels(log):
        size = float(np.std(x))
        least = _COARSE[key] * size
        # The resolution is at most the smallest step, which rules out most channels quickly.
        if any(1.5 * least_step(part) <= least for part in (x[:_FIRST], x)):
            continue
        step = _quantum(x)
        if step > least:
            fault = f"comes in steps of {step:.3g}, {100 * step / size:.2g} % of its spread"
            yield fault_of(log.name, "coarse", key, j, fault, len(x))


def _quantum(x: FloatArray) -> float:
    """Return the resolution of a signal; 0 if it has none."""
    apart = np.diff(np.unique(x))
    if not 1 < len(apart) < len(x) / 2:
        return 0.0
    step = float(np.median(apart[apart <= 1.5 * apart.min()]))  # printed digits scatter
    off = np.abs(apart / step - np.round(apart / step))
    return step if np.mean(off < 0.05) >= _HELD else 0.0


def _jittering(log: Log, _: object, ticks: FloatArray) -> Iterator[Fault]:
    """Find time stamps with jitter: with a uniform clock, positions and speeds agree better.

    Args:
        log: the log without repeated rows.
        ticks: (N,) indices of its rows among the recorded ones.
    """
    t = log.t
    steps = np.diff(t)
    median = float(np.median(steps))
    if float(np.max(np.abs(steps - median))) <= STEP_TOLERANCE * median or len(holes(t, median)):
        return
    disagree = _disagreement(log)
    own = disagree(t)
    numbers = np.arange(len(t), dtype=float)
    whole = np.concatenate([[0.0], np.cumsum(np.maximum(np.round(steps / median), 1.0))])
    best, least = t, _CLOCK * own
    for index in (ticks, numbers, whole):
        clock = _line(index, t)
        if np.diff(clock).min() <= 0:
            continue
        found = disagree(clock)
        if found < least:  # a further clock has to be better by the same factor
            best, least = clock, _CLOCK * found
    if best is t:
        return
    fault = f"time stamps jitter by {1e3 * float(np.std(best - t)):.2g} ms"
    done = f"replaced by a uniform clock of {1e3 * float(np.min(np.diff(best))):.4g} ms"
    undo = partial(replace, t=read_only(best))
    yield Fault(log.name, "t", fault, len(t), done, kind="jitter", undo=undo)


def _line(index: FloatArray, t: FloatArray) -> FloatArray:
    """Return the times of the uniform clock nearest to the stamps (least absolute errors)."""
    weight = np.ones(len(t))
    slope, start = 0.0, 0.0
    for _ in range(8):  # reweighting removes the influence of late stamps
        mean_i, mean_t = np.average(index, weights=weight), np.average(t, weights=weight)
        x, y = index - mean_i, t - mean_t
        slope = float((weight * x) @ y / ((weight * x) @ x))
        start = float(mean_t - slope * mean_i)
        left = np.abs(t - start - slope * index)
        weight = 1 / np.maximum(left, 1e-3 * slope)
    return start + slope * index


def _disagreement(log: Log) -> Callable[[FloatArray], float]:
    """Return a function of the times: how far positions disagree with speeds or with neighbours.

    With speeds, it is q_(k+1) - q_k - (qd_k + qd_(k+1))/2 (t_(k+1) - t_k). Without speeds, it is
    the second divided difference. The result is the median size over the moving samples, and the
    geometric mean over the joints.
    """
    change = np.diff(log.q, axis=0)
    moving = np.abs(change) >= np.maximum(np.median(np.abs(change), axis=0), 1e-300)
    qd = log.qd

    def at(t: FloatArray) -> float:
        step = np.diff(t)[:, None]
        if qd is not None:
            left = np.abs(change - (qd[1:] + qd[:-1]) / 2 * step)
            say = moving
        else:
            speed = change / step
            left = np.abs(np.diff(speed, axis=0))
            say = moving[1:] & moving[:-1]
        sizes = [float(np.median(x[s])) for x, s in zip(left.T, say.T, strict=True) if s.any()]
        sizes = [s for s in sizes if s > 0]
        return float(np.exp(np.mean(np.log(sizes)))) if sizes else 0.0

    return at


#: Finders for logs as recorded, in this order; each finder sees the earlier repairs.
FINDERS: Mapping[str, Callable[[Log, Sequence[int], FloatArray], Iterator[Fault]]] = {
    "converted": _converted,
    "missing": _missing,
    "repeated": _repeated,
    "wrapped": _wrapped,
    "jumps": _jumping,
    "held": _held,
    "coarse": _coarse,
    "jitter": _jittering,
}


def _saturated(log: Log, samples: Samples, flat: Bools) -> Iterator[Fault]:
    """Find clipped torques, where `flat` (N, n) is true."""
    assert log.tau is not None
    for j in map(int, np.flatnonzero(flat.any(axis=0))):
        at = flat[:, j]
        limit = float(np.abs(log.tau[at, j]).max())
        undo = partial(masked, at=on_grid(at, log.t, samples.t), joints=[j])
        says, value = f"clipped at {limit:.4g}", (("limit", limit, 0.0),)
        found = fault_of(log.name, "saturated", "tau", j, says, int(at.sum()), "masked", undo)
        yield replace(found, values=value)


def _stuck(log: Log, samples: Samples, flat: Bools) -> Iterator[Fault]:
    """Find times with a stuck recorder, and stuck channels; `flat` torques are not stuck."""
    everyone, n = "masked, for all joints", log.q.shape[1]
    hidden = flat.copy()  # from the equations of a joint
    frozen = stuck_rows(log)
    if frozen.any():
        undo = partial(bridged, at=on_grid(frozen, log.t, samples.t), joints=range(n))
        yield Fault(log.name, "all", "stuck", int(frozen.sum()), everyone, kind="stuck", undo=undo)
    hidden |= frozen[:, None]
    moving = _moving(log, samples)
    for key, j, x in _channels(log):
        stuck = stuck_runs(x, partial(_others_tell, moving, key, j), key != "tau")
        if stuck.any():
            stuck &= ~(hidden[:, j] if key == "tau" else frozen)
        if not stuck.any() or stuck.mean() > _DEAD:
            continue  # a mask does not repair a channel without signal
        at = on_grid(stuck, log.t, samples.t)
        undo, done = partial(masked, at=at, joints=[j]), "masked"
        if key == "q":
            undo, done = partial(bridged, at=at, joints=[j]), everyone
            hidden |= stuck[:, None]
        elif key == "qd":
            undo, done = partial(sloped, at=at, j=j), "replaced by dq/dt"
        yield fault_of(log.name, "stuck", key, j, "stuck", int(stuck.sum()), done, undo)


def _moving(log: Log, samples: Samples) -> Bools:
    """Return where the joints of a log move, at its own stamps, (N, n)."""
    qd = samples.qd
    if len(samples.t) != len(log.t):
        qd = np.column_stack([np.interp(log.t, samples.t, v) for v in qd.T])
    return _fast(qd)


def _fast(qd: FloatArray) -> Bools:
    return np.asarray(np.abs(qd) > _MOVES * rms(qd))


def _others_tell(moving: Bools, key: str, j: int) -> Bools:
    """Return where the robot moves, judged without q or qd of joint j, (N,)."""
    if key == "qd":
        return moving[:, j]
    alone = key == "tau" or moving.shape[1] == 1
    return np.asarray((moving if alone else np.delete(moving, j, axis=1)).any(axis=1))


def stuck_rows(log: Log) -> Bools:
    """Return where a recorder is stuck: all channels keep their values, then a position jumps.

    A robot at rest continues from its position without a jump.
    """
    out = np.zeros(len(log.t), dtype=bool)
    long = [
        (start, end)
        for start, end in spans(same_rows([x for x in (log.q, log.qd, log.tau) if x is not None]))
        if end - start + 1 >= _STUCK and end < len(log.t) - 1
    ]
    if not long:
        return out
    usual = np.array([_usual_step(x) for x in log.q.T])
    for start, end in long:
        if (np.abs(log.q[end + 1] - log.q[end]) > _LEAVES * usual).any():
            out[start : end + 1] = True
    out &= out.mean() <= _DEAD
    return out


def cut_off(x: FloatArray) -> Bools:
    """Return where a signal is clipped: samples that accumulate at an extreme, (N,).

    A peak that is rounded to its last digit has nearly as many samples one digit below. A held or
    coarse channel keeps its other values as long.
    """
    out = np.zeros(len(x), dtype=bool)
    for side in (1.0, -1.0):
        y = side * x
        top = float(y.max())
        if top < 0.5 * float(np.abs(x).max()):
            continue
        at = y >= top - 1e-9 * abs(top)
        count = int(at.sum())
        if count < _FLAT:
            continue
        levels = np.unique(y[y > top - 0.1 * (top - float(y.min()))])
        digit = float(np.min(np.diff(levels))) if len(levels) > 1 else 0.0
        below = int(((y < top - 1e-9 * abs(top)) & (y >= top - 1.5 * digit)).sum())
        first, lengths = runs(x)
        others = lengths[~at[first]]
        usual = float(np.percentile(others, 90)) if len(others) else math.inf
        piled = count >= _FLAT * usual and count > _PILED * max(below, 1)
        if piled and int(np.diff(spans(at)).max()) >= _RUN * usual:
            out |= at
    return out


def stuck_runs(x: FloatArray, others: Callable[[], Bools], jumps: bool) -> Bools:
    """Return where a channel keeps a value much longer than usual while the robot moves, (N,).

    Args:
        x: (N,) the channel.
        others: returns (N,) whether the robot moves, judged by other channels.
        jumps: whether the value has to jump after the run, as a position does.
    """
    out = np.zeros(len(x), dtype=bool)
    starts, ends = spans(x[1:] == x[:-1]).T
    lengths = ends - starts + 1
    if lengths.max(initial=0) < _STUCK:
        return out
    usual = float(np.percentile(lengths, 90)) if len(lengths) > 10 else 1.0
    long = lengths >= max(_STUCK, _LONGER * usual)
    if not long.any():
        return out
    moves, least = others(), _LEAVES * _usual_step(x) if jumps else -1.0
    steps = np.abs(np.diff(x, prepend=x[0], append=x[-1]))  # before and after each sample
    for start, end in zip(starts[long], ends[long], strict=True):
        if moves[start:end].mean() >= 0.5 and max(steps[start], steps[end + 1]) > least:
            out[start : end + 1] = True
    return out


def mended_speeds(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Fault, ...]]:
    """Correct measured speeds that are late or scaled against dq/dt; replace unrelated ones.

    In a band wider than the comparison band, least squares fits
    qd = g (v - delay a) + offset with v = dq/dt and its derivative a. Samples that are masked for
    the robot, for example at a stuck position, are left out.

    Args:
        samples: a log with uniform steps and measured speeds.
        comparison_hz: comparison band of the run, Hz.
    """
    if samples.velocity_derived:
        return samples, ()
    step = samples.step
    band = _within(_SLOPES * comparison_hz, step)
    qd = samples.qd.copy()
    seen = np.ones(len(samples.t), dtype=bool)
    if samples.mask is not None:  # without samples that the filter mixes with masked ones
        seen = ~touched(samples.mask.robot, math.ceil(1 / (band * step)))
    positions, slopes, bends = lowpass_and_slopes(samples.q, step, band, 2)
    smooth = lowpass(qd, step, band)
    found: list[_Speed] = []
    done: list[Fault] = []
    still = at_standstill(samples.q, positions, step, band)
    noise = _noise(samples.qd - smooth, step, band)
    for j in map(int, np.flatnonzero(~still)):  # the other joints have no motion to compare
        v, w = slopes[:, j], smooth[:, j]
        if not np.any(v[seen]):
            continue
        speed = _speed(j, v, bends[:, j], w, step, 0.25 / comparison_hz, seen)
        if speed is None and float(np.std((w - v)[seen])) <= _NOISY * noise[j]:
            continue  # the joint is slower than the noise of its sensor
        if speed is None:
            qd[:, j] = v
            says, what = "it does not follow dq/dt", "replaced by dq/dt"
            done.append(fault_of(samples.name, "unrelated", "qd", j, says, len(samples.t), what))
        elif speed.delay or speed.offset or speed.gain != 1.0:
            found.append(speed)
            moved = shifted(qd[:, j], speed.delay, step)
            qd[:, j] = (moved - speed.offset) / speed.gain
    done += _speed_faults(samples, found)
    if not done:
        return samples, ()
    return replace(samples, qd=read_only(qd)), tuple(done)


def at_standstill(x: FloatArray, low: FloatArray, step: float, band: float) -> Bools:
    """Return whether low-passed positions contain nothing but noise.

    Args:
        x: (N, k) positions.
        low: (N, k) low-passed positions.
        step: sampling step in s.
        band: cutoff of the filter in Hz, below Nyquist.

    Returns:
        (k,) true if the spread of `low` is below three times that of white noise in the band, or if
        x stays within two of its smallest steps.
    """
    noise = _noise(x - low, step, band)
    least = np.array([least_step(column) for column in x.T])
    within = np.ptp(x, axis=0) <= 2.5 * np.where(np.isfinite(least), least, 0.0)
    return np.asarray((np.std(low, axis=0) <= _STILL * noise) | within)


@dataclass(frozen=True)
class _Speed:
    """The errors of joint j's speed: qd = gain (dq/dt - delay d2q/dt2) + offset."""

    j: int
    delay: float
    gain: float
    offset: float
    std: tuple[float, ...]

    def fault(self, samples: Samples) -> Fault:
        """Return the error as a fault of the joint's speed."""
        wrong, (late, scaled, off) = [], self.std
        if self.gain != 1.0:
            values = ("GV", self.gain - 1, scaled)
            wrong.append((f"{self.gain:.4g} times dq/dt", "rescaled", values))
        if self.delay:
            wrong.append((_late(self.delay), "shifted", ("LV", self.delay, late)))
        if self.offset:
            values = ("OV", self.offset, off)
            wrong.append((f"off by {self.offset:.3g}", "moved to zero", values))
        says, done, told = zip(*wrong, strict=True)
        what = " and ".join(says), len(samples.t), " and ".join(done)
        return replace(fault_of(samples.name, "speed", "qd", self.j, *what), values=told)


def _speed(
    j: int,
    v: FloatArray,
    a: FloatArray,
    w: FloatArray,
    step: float,
    longest: float,
    seen: Bools,
) -> _Speed | None:
    """Compare a measured speed w with v = dq/dt at the rows `seen`; None if it does not follow v.

    Delay, then gain, then offset are included if each leaves at most four fifths of the squared
    disagreement.
    """
    delay, v, a = 0.0, v[seen], a[seen]
    for _ in range(3):
        moved = shifted(w, delay, step)[seen]
        g, d, _ = _least_squares(np.column_stack([v, a, np.ones(len(v))]), moved)
        if g == 0 or abs(delay - d / g) > longest:
            break
        delay -= float(d / g)
        if abs(d / g) < _SETTLED * step:
            break
    moved, w = shifted(w, delay, step)[seen], w[seen]
    level, own = moved - moved.mean(), v - v.mean()
    spread = float(np.sqrt((own @ own) * (level @ level)))
    if spread == 0.0 or float(own @ level) < _FOLLOWS * spread:
        return None
    left = float(np.sum((w - v) ** 2))
    late = float(np.sum((moved - v) ** 2))
    if late > _SPEEDS * left or abs(delay) <= _LATE * step:
        delay, moved = 0.0, w
    else:
        left = late
    gain, offset = 1.0, 0.0
    A = np.column_stack([v, np.ones(len(v))])
    for columns in ([0], [1], [0, 1]):
        fixed = moved - (0.0 if 0 in columns else v)
        found = _least_squares(A[:, columns], fixed)
        error = float(np.sum((fixed - A[:, columns] @ found) ** 2))
        if error <= _SPEEDS * left and (1 in columns or abs(found[0] - 1) > _SCALED):
            left = error
            gain = float(found[0]) if 0 in columns else 1.0
            offset = float(found[-1]) if 1 in columns else 0.0
    # Filtered rows are correlated: one per period of the low-pass counts.
    noise = left / max(len(v), 1) * max(longest / step, 1.0)
    std = tuple(float(np.sqrt(noise / max(float(x @ x), 1e-300))) for x in (a, v, np.ones(len(v))))
    return _Speed(j, delay, gain, offset, std)


def _least_squares(A: FloatArray, y: FloatArray) -> FloatArray:
    """Solve y = A x of a few columns by the normal equations: one pass over many rows."""
    both = np.column_stack([A, y])
    return solve_gram(both.T @ both)


def _speed_faults(samples: Samples, found: Sequence[_Speed]) -> list[Fault]:
    """Return delays as one fault of the recorder if all joints share it, else joint by joint."""
    n, delays = samples.q.shape[1], np.array([speed.delay for speed in found])
    common = len(found) == n > 1 and np.ptp(delays) <= max(0.2 * abs(delays.mean()), samples.step)
    if common and all(f.gain == 1.0 and f.offset == 0.0 for f in found):
        delay, std = float(delays.mean()), float(np.mean([f.std[0] for f in found]))
        says = f"speeds of all joints are {_late(delay)} (recorder or stamps)"
        what = says, len(samples.t), "shifted", (("LV", delay, std),)
        return [Fault(samples.name, "qd", *what, kind="speed")]
    return [f.fault(samples) for f in found]


def _late(delay: float) -> str:
    return f"{abs(1e3 * delay):.2g} ms {'late' if delay > 0 else 'early'}"


def silenced_torques(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Fault, ...]]:
    """Take the torque of a joint as zero that is noise throughout while the joint moves.

    Its RMS in the comparison band is not above that of white noise there by three standard
    deviations (of 2 B T values, each with a relative one of 1 / sqrt(2)), and that of another
    joint is.

    Args:
        samples: a log with uniform steps.
        comparison_hz: comparison band of the run, Hz.
    """
    step, band = samples.step, _within(comparison_hz, samples.step)
    low = lowpass(samples.tau, step, band)
    most = 1 + _SILENT / math.sqrt(4 * band * step * len(low))
    drowned = rms(low) <= most * _noise(samples.tau - low, step, band)
    silent = low.any(axis=0) & drowned & ~drowned.all() & ~standing(samples, comparison_hz)
    what = np.zeros(len(low)), "noise throughout while the joint moves", len(low), "taken as zero"
    found = (_mended(samples, "silent", "tau", int(j), *what) for j in np.flatnonzero(silent))
    return undo_faults(samples, found)


def standing(samples: Samples, comparison_hz: float) -> Bools:
    """Return which joints stand still throughout, (n,): what they seem to move is noise."""
    step, band = samples.step, _within(comparison_hz, samples.step)
    return at_standstill(samples.q, lowpass(samples.q, step, band), step, band)


def _within(band: float, step: float) -> float:
    """Return a band in Hz, or the largest that logs of this step have."""
    return min(band, 0.5 * OPEN / step)


def _noise(high: FloatArray, step: float, band: float) -> FloatArray:
    """Return the standard deviation in a band, (k,), of white noise with this part above it."""
    return white_noise(high, step, band) * math.sqrt(2 * band * step)


def unmended_faults(
    samples: Samples, sigma: Sequence[int], passive: Sequence[int] = ()
) -> Iterator[Fault]:
    """Find the remaining faults of single channels: dead channels and steps.

    Steps of a speed are undone on a log in the band of a run.

    Args:
        samples: a log with uniform steps.
        sigma: types of the joints.
        passive: places of the joints that no motor drives: they have no torque.
    """
    yield from _dead(samples, sigma, passive)
    for key, x in (("q", samples.q), ("qd", samples.qd)):
        for j in range(0 if key == "qd" and samples.velocity_derived else x.shape[1]):
            at = steps(x[:, j])
            if key == "qd":
                at = at[[not _moved(samples.q[:, j], x[:, j], i, samples.step) for i in at]]
            if len(at):
                undo = partial(moved_back, name=samples.name, j=j, at=tuple(at))
                yield step(samples, key, j, at, partial(derived, j=j) if key == "qd" else undo)


def lasting(found: Iterable[Fault]) -> tuple[Fault, ...]:
    """Return those of `unmended_faults` that need a new record: all but faults of speeds."""
    return tuple(f for f in found if not f.channel.startswith("qd"))


def _dead(samples: Samples, sigma: Sequence[int], passive: Sequence[int]) -> Iterator[Fault]:
    """Find positions and torques that keep one value for most of a log while the joint moves."""
    moves = _fast(samples.qd)
    for key in ("tau",) if samples.velocity_derived else ("q", "tau"):
        for j in moving_joints([samples.qd], sigma):
            first, lengths = runs(np.ascontiguousarray(getattr(samples, key)[:, j]))
            k = int(np.argmax(lengths))
            at = slice(int(first[k]), int(first[k] + lengths[k]))
            advice, throughout = "leave that time out", lengths[k] == len(moves)
            if key == "tau" and throughout:
                if j in passive:
                    continue
                advice = f"if no motor drives the joint, {WITHOUT_MOTOR}"
            elif lengths[k] <= _DEAD * len(moves) or moves[at, j].mean() < _DEAD:
                continue
            says = (
                f"{key}{j + 1} of {samples.name} is constant from t = {samples.t[at][0]:.4g} s "
                f"to {samples.t[at][-1]:.4g} s while the joint moves: {advice}, or check the sensor"
            )
            joints = (j,) if key == "tau" else range(samples.q.shape[1])
            undo = partial(left_out, name=samples.name, at=at, joints=joints)
            yield fault_of(samples.name, "stuck", key, j, says, int(lengths[k]), undo=undo)


def torques_look_computed(samples: Samples) -> bool:
    """Return whether a torque of a log has no noise, judged by sixth differences.

    A recorder has the same instruments on all joints. A channel whose differences are exactly zero
    is held or coarse.
    """
    noise = noise_of_differences(samples.tau) if len(samples.t) >= _SIXTH else np.zeros(0)
    return bool(((noise > 0) & (noise <= _NOISE * rms(samples.tau)[: len(noise)])).any())


def positions_look_measured(samples: Samples) -> bool:
    """Return whether the position of any joint has encoder noise."""
    return bool((noise_of_differences(samples.q) > _ENCODER).any())


def steps(x: FloatArray) -> Places:
    """Return the indices of samples after which x steps by several times its usual difference."""
    d = np.diff(x)
    around = np.median([np.roll(d, k) for k in (-3, -2, -1, 1, 2, 3)], axis=0)
    found = np.flatnonzero((np.abs(d - around) > _STEP * _usual_step(x))[3:-3]) + 3
    return found[np.diff(found, prepend=-_APART - 1) > _APART]  # a step and its return are one


def step(
    samples: Samples,
    key: str,
    j: int,
    at: Places,
    undo: Callable[[FilteredLog], FilteredLog] | None,
) -> Fault:
    """Return the fault that a channel of a joint steps after some samples."""
    x, i = getattr(samples, key)[:, j], int(at[0])
    says = (
        f"{key}{j + 1} of {samples.name} jumps by {x[i + 1] - x[i]:.4g} from one sample to the "
        f"next at t = {samples.t[i]:.6g} s ({len(at)} such jumps): leave that time out, or check "
        "the sensor"
    )
    return fault_of(samples.name, "step", key, j, says, len(at), undo=undo)


def _moved(q: FloatArray, qd: FloatArray, i: int, step: float) -> bool:
    """Return whether a speed jump after sample i is part of the motion, as at a hard stop.

    In this case the mean speed over some samples changes with the slope of q. A single wrong sample
    shifts the mean by a fifth of the jump, a sensor step by all of it.
    """
    before, after = max(i - _APART, 0), min(i + 1 + _APART, len(q) - 1)
    slopes = (q[i] - q[before]) / (i - before), (q[after] - q[i + 1]) / (after - i - 1)
    means = [
        float(np.mean((v[1:] + v[:-1]) / 2)) for v in (qd[before : i + 1], qd[i + 1 : after + 1])
    ]
    change = means[1] - means[0] - (slopes[1] - slopes[0]) / step
    return abs(float(change)) < 0.15 * abs(float(qd[i + 1] - qd[i]))
