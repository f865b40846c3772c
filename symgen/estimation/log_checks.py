"""Faults of sensors and recorders that no filter takes out: found, and masked where that helps.

One log is looked at sample by sample: torques cut off at a limit, channels that are stuck while the
robot moves. No equation touches what is masked. What the model shows of the channels is found in
`symgen.estimation.channel_faults`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from symgen.data.log import Log
from symgen.data.mask import Bools, Mask, on_grid, spans
from symgen.data.raw import read_only
from symgen.data.signals import Samples, differentiate, lowpass
from symgen.data.spline import interpolated
from symgen.estimation.repairs import Repair, runs, same_rows

FloatArray = NDArray[np.float64]
#: A torque is cut off where it is so often at its extreme, and so many times as often as below.
_FLAT, _PILED = 10, 4.0
_RUN = 3  # times the runs of other values, at least
#: A channel is stuck for at least so many samples, and so many times the length of its other runs.
_STUCK, _LONGER = 20, 10.0
_DEAD = 0.5  # of the log
#: A position that was stuck jumps by so many times its largest usual step.
_LEAVES = 3.0
#: Speed of a robot that moves, of the RMS over the log.
_MOVES = 0.1


def masked_faults(log: Log, samples: Samples) -> tuple[Samples, tuple[Repair, ...]]:
    """Mask what is cut off or stuck, in a log on uniform steps.

    Args:
        log: the log that it came from, before it was resampled.
        samples: the log on uniform steps.
    """
    assert log.tau is not None  # open_log has seen to it
    joint, whole = np.zeros(log.q.shape, dtype=bool), np.zeros(len(log.t), dtype=bool)
    done = []
    for j in range(log.q.shape[1]):
        flat = cut_off(np.ascontiguousarray(log.tau[:, j]))
        if flat.any():
            joint[:, j] |= flat
            limit = float(np.abs(log.tau[flat, j]).max())
            fault = f"cut off at {limit:.4g}"
            value = (("limit", limit, 0.0),)
            done.append(Repair(log.name, f"tau{j + 1}", fault, int(flat.sum()), "masked", value))
    moves = _Moves(log, samples)
    qd_fixed, q_fixed = None, samples.q.copy()
    frozen = stuck_rows(log)
    if frozen.any():
        joint |= frozen[:, None]
        whole |= frozen
        count = int(frozen.sum())
        done.append(Repair(log.name, "all", "stuck", count, "masked, for all joints"))
        at = on_grid(frozen[:, None], log.t, samples.t)[:, 0]
        bridged(q_fixed, samples.t, at, range(log.q.shape[1]))
    for key in ("q", "qd", "tau"):
        x = getattr(log, key)
        for j in range(0 if x is None else x.shape[1]):
            column = np.ascontiguousarray(x[:, j])
            stuck = stuck_runs(column, partial(moves.beside, key, j), key != "tau")
            if stuck.any():
                stuck &= ~(frozen | joint[:, j] if key == "tau" else frozen)
            if not stuck.any() or stuck.mean() > _DEAD:
                continue  # a channel without a signal is not mended by a mask
            count = int(stuck.sum())
            if key == "tau":
                joint[:, j] |= stuck
                what = "masked"
            elif key == "q":
                joint |= stuck[:, None]
                whole |= stuck
                bridged(q_fixed, samples.t, on_grid(stuck[:, None], log.t, samples.t)[:, 0], [j])
                what = "masked, for all joints"
            else:
                qd_fixed = samples.qd.copy() if qd_fixed is None else qd_fixed
                at = on_grid(stuck[:, None], log.t, samples.t)[:, 0]
                slope = differentiate(_smooth(samples, j), samples.step)
                qd_fixed[at, j] = slope[at]
                what = "replaced by dq/dt"
            done.append(Repair(log.name, f"{key}{j + 1}", "stuck", count, what))
    if qd_fixed is not None:
        samples = replace(samples, qd=read_only(qd_fixed))
    if whole.any():
        samples = replace(samples, q=read_only(q_fixed))
    if joint.any():
        whole |= joint.any(axis=1)
        mask = Mask(
            on_grid(joint, log.t, samples.t), on_grid(whole[:, None], log.t, samples.t)[:, 0]
        )
        old = samples.mask
        if old is not None:
            mask = Mask(mask.joint | old.joint, mask.robot | old.robot)
        samples = replace(samples, mask=mask)
    return samples, tuple(done)


class _Moves:
    """Where the joints of a log move, looked at once a channel asks."""

    def __init__(self, log: Log, samples: Samples) -> None:
        self._log, self._samples = log, samples

    @cached_property
    def _joints(self) -> Bools:
        log, samples = self._log, self._samples
        qd = samples.qd if len(samples.t) == len(log.t) else _on(samples, log)
        return np.asarray(np.abs(qd) > _MOVES * np.sqrt(np.mean(qd**2, axis=0)))

    def beside(self, key: str, j: int) -> Bools:
        """Return where the robot moves, as others tell than q or qd of joint j, (N,)."""
        moves = self._joints
        if key == "tau" or (moves.shape[1] == 1 and key == "q"):
            return np.asarray(moves.any(axis=1))
        return np.asarray(moves[:, j] if key == "qd" else np.delete(moves, j, axis=1).any(axis=1))


def stuck_rows(log: Log) -> Bools:
    """Return where a recorder is stuck: all channels keep their values, and a position then jumps.

    A robot at rest goes on from where it stood.
    """
    out = np.zeros(len(log.t), dtype=bool)
    long = [
        (start, end)
        for start, end in spans(same_rows([x for x in (log.q, log.qd, log.tau) if x is not None]))
        if end - start + 1 >= _STUCK and end < len(log.t) - 1
    ]
    if not long:
        return out
    steps = np.abs(np.diff(log.q, axis=0))
    usual = np.array([np.percentile(s[s > 0], 99) if (s > 0).any() else np.inf for s in steps.T])
    for start, end in long:
        if (steps[end] > _LEAVES * usual).any():
            out[start : end + 1] = True
    return out if out.mean() <= _DEAD else np.zeros(len(log.t), dtype=bool)


def bridged(q: FloatArray, t: FloatArray, at: Bools, joints: Iterable[int]) -> None:
    """Draw positions, in place, over a time in which they were not seen, so that none jumps."""
    good = ~at
    for j in joints:
        q[at, j] = interpolated(t[good], q[good, j])(t[at])


def _on(samples: Samples, log: Log) -> FloatArray:
    """Return the speeds of samples at the stamps of their log."""
    return np.column_stack([np.interp(log.t, samples.t, v) for v in samples.qd.T])


def _smooth(samples: Samples, j: int) -> FloatArray:
    band = 10.0
    q = samples.q[:, j]
    return lowpass(q, samples.step, band) if band < 0.4 / samples.step else q


def cut_off(x: FloatArray) -> Bools:
    """Return where a signal is cut off: samples at an extreme that pile up there, (N,).

    A peak that is merely rounded to its last digit has nearly as many samples one digit below; a
    channel that is held for some samples, or is coarse, keeps other values as long.
    """
    out = np.zeros(len(x), dtype=bool)
    for side in (1.0, -1.0):
        y = side * x
        top = float(y.max())
        if top < 0.5 * float(np.abs(x).max()):
            continue
        at = y >= top - 1e-9 * abs(top)
        count = int(at.sum())
        if count < _FLAT or count > 0.9 * len(x):
            continue
        levels = np.unique(y[y > top - 0.1 * (top - float(y.min()))])
        digit = float(np.min(np.diff(levels))) if len(levels) > 1 else 0.0
        below = int(((y < top - 1e-9 * abs(top)) & (y >= top - 1.5 * digit)).sum())
        first, lengths = runs(x)
        others = lengths[~at[first]]
        usual = float(np.percentile(others, 90)) if len(others) else 1.0
        piled = count >= _FLAT * usual and count > _PILED * max(below, 1)
        if piled and int(np.diff(spans(at)).max()) >= _RUN * usual:
            out |= at
    return out


def stuck_runs(x: FloatArray, others: Callable[[], Bools], jumps: bool) -> Bools:
    """Return where a channel keeps one value much longer than it ever does, while the robot moves.

    Args:
        x: (N,) the channel.
        others: gives (N,) whether the robot moves, as other channels tell.
        jumps: whether the value has to jump away from where it was stuck, as a position does.
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
    moves, steps = others(), np.abs(np.diff(x))
    largest = float(np.percentile(steps[steps > 0], 99)) if (steps > 0).any() else np.inf
    for start, end in zip(starts[long], ends[long], strict=True):
        if moves[int(start) : int(end)].mean() < 0.5:
            continue
        leaves = max(
            steps[end] if end < len(steps) else 0.0,
            steps[start - 1] if start > 0 else 0.0,
        )
        if jumps and leaves <= _LEAVES * largest:
            continue
        out[int(start) : int(end) + 1] = True
    return out
