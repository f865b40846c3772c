"""Small faults of a recorder, mended before anything is estimated, and counted.

Rows that repeat the one before are dropped, not interpolated through; stamps of a host that jitter
about a fixed clock are put on that clock where positions then agree better with speeds; single
samples that jump are taken out (Hampel 1974); turns of 2 pi are joined. Nothing is mended unless
what is compared agrees better afterwards; thresholds are ratios to the signal's own scatter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.data.holes import GAP, holes
from symgen.data.log import Log, rows
from symgen.data.mask import Bools, spans
from symgen.data.raw import read_only
from symgen.data.signals import STEP_TOLERANCE
from symgen.data.spline import interpolated
from symgen.estimation.jumps import jumps, least_step, without

FloatArray = NDArray[np.float64]
#: A channel as it is mended, what was wrong, how many samples were touched, and what was done.
_Mended = tuple[FloatArray, str, int, str]
#: A clock is taken where it leaves so much of the disagreement that the stamps leave, at most.
_CLOCK = 0.8
#: More repeated rows than chance would give, by this factor, and at least so many.
_CHANCE, _FEW = 5.0, 3
#: What is done about a fault that no repair takes away.
LEFT = "left as it is"
#: A channel is held where so many runs of one value hold so much of the log.
_HELD_RUNS, _HELD, _PACED = 20, 0.9, 0.4
_FIRST = 4096  # samples of a channel that are looked at before all of it
#: Steps of a channel that are worth a word, over its spread: encoders have 14 bits a turn and more.
_COARSE = {"q": 2e-3, "qd": 0.05, "tau": 0.05}


@dataclass(frozen=True)
class Repair:
    """What was wrong with a channel of a log, and what was done.

    Attributes:
        log: name of the log.
        channel: "t", "q2", "qd1", "tau3" or "all".
        fault: in words.
        samples: how many were touched.
        done: in words.
        values: of what was measured: name, value and standard deviation; GV of speeds that are
            (1 + GV) dq/dt, LV s late, and off by OV.
    """

    log: str
    channel: str
    fault: str
    samples: int
    done: str
    values: tuple[tuple[str, float, float], ...] = ()

    @property
    def in_words(self) -> str:
        """The repair in one line."""
        return f"{self.log}: {self.channel}: {self.fault}, {self.samples} samples: {self.done}"


def repaired(log: Log, sigma: Sequence[int]) -> tuple[Log, tuple[Repair, ...]]:
    """Mend what shows sample by sample: repeated rows, stamps, turns and jumps.

    Args:
        log: as it was recorded, mapped to the joint side.
        sigma: types of the joints.
    """
    done: list[Repair] = []
    ticks = np.arange(len(log.t), dtype=float)
    repeats = repeated_rows(log)
    if repeats.any():
        log, ticks = rows(log, ~repeats), ticks[~repeats]
        count = int(repeats.sum())
        done.append(Repair(log.name, "all", "rows that repeat the one before", count, "dropped"))
    log, found = _turned_back(log, sigma)
    done += found
    log, found = _without_jumps(log)
    done += found
    log, found = _released(log)
    done += found
    done += _coarse(log)
    log, found = _on_its_clock(log, ticks)
    return log, (*done, *found)


def repeated_rows(log: Log) -> Bools:
    """Find rows that hold the values of the row before, where that is no chance: (N,).

    Channels that stand still, or move by less than their last digit, repeat by themselves: rows are
    repeated where all channels are at once, far more often than if each did so on its own. Longer
    stretches are a robot at rest, or a recorder that is stuck, and are not touched.
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
    """Return which rows hold the values of the row before in all columns, (N - 1,)."""
    out = np.ones(len(arrays[0]) - 1, dtype=bool)
    for column in (column for x in arrays for column in x.T):
        if not out.any():
            break
        out &= column[1:] == column[:-1]
    return out


def _turned_back(log: Log, sigma: Sequence[int]) -> tuple[Log, list[Repair]]:
    """Join turns of 2 pi: steps of one turn between samples that hardly move."""
    q, done = log.q, []
    for j, kind in enumerate(sigma):
        if kind == names.PRISMATIC:
            continue
        steps = np.diff(q[:, j])
        if np.abs(steps).max(initial=0.0) <= np.pi:
            continue
        turns = np.round(steps / (2 * np.pi))
        off = np.abs(steps - 2 * np.pi * turns)
        others = float(np.max(np.abs(steps[turns == 0]), initial=0.0))
        wrapped = (turns != 0) & (off <= max(2 * others, 1e-6))
        if not wrapped.any() or others > 1.0:
            continue
        fixed = q.copy()
        fixed[1:, j] -= 2 * np.pi * np.cumsum(np.where(wrapped, turns, 0.0))
        q = fixed
        done.append(Repair(log.name, f"q{j + 1}", "turns of 2 pi", int(wrapped.sum()), "joined"))
    return (replace(log, q=read_only(q)) if done else log), done


def _without_jumps(log: Log) -> tuple[Log, list[Repair]]:
    """Put single samples that jump, or two, on the line between their neighbours."""

    def mended(x: FloatArray) -> _Mended | None:
        at = jumps(x)
        if len(at) == 0:
            return None
        done = "put on the line between their neighbours"
        return without(x, at), "single samples that jump", len(at), done

    return _each_channel(log, mended)


def _each_channel(
    log: Log, mended: Callable[[FloatArray], _Mended | None]
) -> tuple[Log, list[Repair]]:
    """Mend every channel of a log that has to be."""
    done: list[Repair] = []
    arrays: dict[str, Any] = {}
    for key in ("q", "qd", "tau"):
        x = getattr(log, key)
        if x is None:
            continue
        fixed = None
        for j in range(x.shape[1]):
            found = mended(np.ascontiguousarray(x[:, j]))
            if found is not None:
                fixed = x.copy() if fixed is None else fixed
                fixed[:, j], fault, count, what = found
                done.append(Repair(log.name, f"{key}{j + 1}", fault, count, what))
        if fixed is not None:
            arrays[key] = read_only(fixed)
    return (replace(log, **arrays) if done else log), done


def runs(x: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return where a signal takes a value, and for how many samples it keeps it."""
    first = np.flatnonzero(np.concatenate([[True], x[1:] != x[:-1]]))
    return first, np.diff(np.concatenate([first, [len(x)]]))


def held_for(x: FloatArray) -> int:
    """Return how many samples a channel holds every value, where it is read anew at such a pace.

    Two fifths of its runs of one value are of that length, and nine tenths within a sample of it;
    1 where it is not held. Longer ones, of a robot at rest, are left out. A coarse channel keeps
    its values for as long as the motion wants.
    """
    if 1.5 * (1 + np.count_nonzero(x[1:] != x[:-1])) > len(x):  # so many that half of them are 1
        return 1
    _, lengths = runs(x)
    k = round(float(np.median(lengths)))
    short = lengths[lengths <= 2 * k + 1]
    if k == 1 or len(short) < _HELD_RUNS:
        return 1
    paced = np.mean(short == k) >= _PACED and np.mean(np.abs(short - k) <= 1) >= _HELD
    return k if paced else 1


def _released(log: Log) -> tuple[Log, list[Repair]]:
    """Draw channels that are held between their readings through these readings."""

    def mended(x: FloatArray) -> _Mended | None:
        k = held_for(x)
        if k == 1:
            return None
        first, _ = runs(x)
        inside = log.t <= log.t[first[-1]]
        out = x.copy()
        out[inside] = interpolated(log.t[first], x[first])(log.t[inside])
        return out, f"read anew every {k} samples only", len(x), "drawn through its readings"

    return _each_channel(log, mended)


def _coarse(log: Log) -> list[Repair]:
    """Say which channels come in steps that count beside their motion."""
    out = []
    for key, least in _COARSE.items():
        x = getattr(log, key)
        for j in range(0 if x is None else x.shape[1]):
            column = np.ascontiguousarray(x[:, j])
            size = float(np.std(column))
            # What it comes in is no larger than any step: most channels show it at once.
            if any(1.5 * least_step(part) <= least * size for part in (column[:_FIRST], column)):
                continue
            step = _quantum(column)
            if step > least * size:
                fault = f"comes in steps of {step:.3g}, {100 * step / size:.2g} % of its spread"
                out.append(Repair(log.name, f"{key}{j + 1}", fault, len(x), LEFT))
    return out


def _quantum(x: FloatArray) -> float:
    """Return the step in which a signal comes, 0 where it comes in none."""
    apart = np.diff(np.unique(x))
    if not 1 < len(apart) < len(x) / 2:
        return 0.0
    step = float(np.median(apart[apart <= 1.5 * apart.min()]))  # printed digits scatter
    off = np.abs(apart / step - np.round(apart / step))
    return step if np.mean(off < 0.05) >= _HELD else 0.0


def _on_its_clock(log: Log, ticks: FloatArray) -> tuple[Log, list[Repair]]:
    """Put stamps on the clock of the sampler where positions and speeds agree better there.

    Args:
        log: without repeated rows.
        ticks: (N,) numbers of its rows among those that were recorded.
    """
    t = log.t
    steps = np.diff(t)
    median = float(np.median(steps))
    if float(np.max(np.abs(steps - median))) <= STEP_TOLERANCE * median or len(holes(t, median)):
        return log, []
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
        if found < least:
            best, least = clock, found
    if best is t:
        return log, []
    jitter = float(np.std(best - t))
    done = Repair(
        log.name,
        "t",
        f"stamps jitter by {1e3 * jitter:.2g} ms about a fixed clock",
        len(t),
        f"put on that clock, of {1e3 * float(np.min(np.diff(best))):.4g} ms",
    )
    return replace(log, t=read_only(best)), [done]


def _line(index: FloatArray, t: FloatArray) -> FloatArray:
    """Return the times of a clock that ticks evenly, nearest to stamps (least absolute errors)."""
    weight = np.ones(len(t))
    slope, start = 0.0, 0.0
    for _ in range(8):  # reweighted: late stamps of a busy host have no say
        mean_i, mean_t = np.average(index, weights=weight), np.average(t, weights=weight)
        x, y = index - mean_i, t - mean_t
        slope = float((weight * x) @ y / ((weight * x) @ x))
        start = float(mean_t - slope * mean_i)
        left = np.abs(t - start - slope * index)
        weight = 1 / np.maximum(left, 1e-3 * slope)
    return np.asarray(start + slope * index)


def _disagreement(log: Log) -> Callable[[FloatArray], float]:
    """Return how far positions are from what speeds, or else their neighbours, make of the times.

    Of speeds: q_(k+1) - q_k - (qd_k + qd_(k+1))/2 (t_(k+1) - t_k). Without speeds: the second
    divided difference of the times on either side. The median of the size over the samples that
    move, the geometric mean over the joints.
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
