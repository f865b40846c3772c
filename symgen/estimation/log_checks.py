"""Faults of sensors and recorders that no filter takes out: found, and masked where that helps.

`channel_faults` looks at one log sample by sample: torques cut off at a limit, channels that are
stuck while the robot moves. What it masks no equation touches. `torque_faults` looks at what the
model leaves: the torque of a joint that fits with another factor or sign, channels of two joints
that are exchanged, a torque that is late. Thresholds are ratios, of errors on folds that the fit
did not see.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from symgen.data.log import Log
from symgen.data.mask import Bools, Mask, on_grid
from symgen.data.raw import read_only
from symgen.data.signals import Samples, differentiate, lowpass
from symgen.estimation.blocks import (
    Blocks,
    block_errors,
    held_out_error,
    placed,
    residual_squares,
    solve_gram,
    summary,
)
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.repairs import Repair
from symgen.estimation.system import Equations

FloatArray = NDArray[np.float64]
#: A torque is cut off where it is so often at its extreme, and so many times as often as below.
_FLAT, _PILED = 10, 4.0
#: A channel is stuck for at least so many samples, and so many times the length of its other runs.
_STUCK, _LONGER = 20, 10.0
_DEAD = 0.5  # of the log
#: Speed of a robot that moves, of the RMS over the log.
_MOVES = 0.1
#: A fault is named where undoing it leaves so much of the error on folds left out, at most.
_CLEARER = 0.9
#: Factors of a torque that are looked at are at least so far from 1.
_GAIN = 0.03
#: Sign and exchange of torques are tried where the error is above this.
_LOUD, _EXCHANGED = 0.1, 0.7
_STD = 3.0


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
        flat = cut_off(log.tau[:, j])
        if flat.any():
            joint[:, j] |= flat
            limit = float(np.abs(log.tau[flat, j]).max())
            fault = f"cut off at {limit:.4g}"
            value = (("limit", limit, 0.0),)
            done.append(Repair(log.name, f"tau{j + 1}", fault, int(flat.sum()), "masked", value))
    qd = samples.qd if len(samples.t) == len(log.t) else _on(samples, log)
    moves = np.abs(qd) > _MOVES * np.sqrt(np.mean(qd**2, axis=0))
    qd_fixed = None
    for key in ("q", "qd", "tau"):
        x = getattr(log, key)
        for j in range(0 if x is None else x.shape[1]):
            others = moves[:, j] if key == "qd" else np.delete(moves, j, axis=1).any(axis=1)
            if key == "tau" or x.shape[1] == 1:
                others = moves.any(axis=1)
            stuck = stuck_runs(x[:, j], others, key != "tau")
            if not stuck.any() or stuck.mean() > _DEAD:
                continue  # a channel without a signal is not mended by a mask
            count = int(stuck.sum())
            if key == "tau":
                joint[:, j] |= stuck
                what = "masked"
            elif key == "q":
                joint |= stuck[:, None]
                whole |= stuck
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


def _on(samples: Samples, log: Log) -> FloatArray:
    """Return the speeds of samples at the stamps of their log."""
    return np.column_stack([np.interp(log.t, samples.t, v) for v in samples.qd.T])


def _smooth(samples: Samples, j: int) -> FloatArray:
    band = 10.0
    q = samples.q[:, j]
    return lowpass(q, samples.step, band) if band < 0.4 / samples.step else q


def cut_off(x: FloatArray) -> Bools:
    """Return where a signal is cut off: samples at an extreme that pile up there, (N,).

    A peak that is merely rounded to its last digit has nearly as many samples one digit below.
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
        if count > _PILED * max(below, 1) and _runs_of(at) >= 3:
            out |= at
    return out


def _runs_of(flags: Bools) -> int:
    """Return the length of the longest run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    lengths = edges[1::2] - edges[::2]
    return int(lengths.max(initial=0))


def stuck_runs(x: FloatArray, others: Bools, jumps: bool) -> Bools:
    """Return where a channel keeps one value much longer than it ever does, while the robot moves.

    Args:
        x: (N,) the channel.
        others: (N,) whether the robot moves, as other channels tell.
        jumps: whether the value has to jump away from where it was stuck, as a position does.
    """
    out = np.zeros(len(x), dtype=bool)
    same = np.concatenate([[False], x[1:] == x[:-1], [False]])
    edges = np.flatnonzero(np.diff(same.astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    if len(starts) == 0:
        return out
    lengths = ends - starts + 1
    steps = np.abs(np.diff(x))
    usual = float(np.percentile(lengths, 90)) if len(lengths) > 10 else 1.0
    largest = float(np.percentile(steps[steps > 0], 99)) if (steps > 0).any() else np.inf
    for start, end, length in zip(starts, ends, lengths, strict=True):
        span = slice(int(start), int(end))
        if length < max(_STUCK, _LONGER * usual) or others[span].mean() < 0.5:
            continue
        leaves = max(
            steps[end] if end < len(steps) else 0.0,
            steps[start - 1] if start > 0 else 0.0,
        )
        if jumps and leaves <= 3.0 * largest:
            continue
        out[int(start) : int(end) + 1] = True
    return out


@dataclass(frozen=True)
class Fault:
    """A fault of the torque channels that the model shows.

    Attributes:
        channel: "tau3", "tau2, tau4", or "tau" for all joints.
        says: in words, with the value.
        left: error on folds left out with the fault undone, over that as it is.
        kind: gain, sign, exchange or delay.
        joints: positions of the joints.
        value: factor, or delay in s.
    """

    channel: str
    says: str
    left: float
    kind: str
    joints: tuple[int, ...]
    value: float


def torque_faults(
    logs: Sequence[FilteredLog],
    equations: Sequence[tuple[Equations, ...]],
    held: Sequence[FilteredLog] = (),
    held_equations: Sequence[tuple[Equations, ...]] = (),
) -> tuple[Fault, ...]:
    """Find what is wrong with the torques, by the torque equations of the training logs.

    A fault counts where undoing it leaves, on some joint, at most nine tenths of the error on folds
    that the fit did not see, by three standard deviations over blocks of time, and of the error on
    logs that it never saw.

    Args:
        logs: in the band of the run.
        equations: of torque, log by log.
        held, held_equations: the same of the validation logs, where there are any.
    """
    n = len(equations[0])
    base = summary(placed(equations), n)
    other = summary(placed(held_equations), n) if held_equations else None
    case = _Case(base, other, block_errors(base, base))
    if case.own.sum() == 0.0:
        return ()
    found = _late(case, (logs, equations), (held, held_equations))
    found += [f for j in range(n) for f in _factor(case, j)]
    if held_out_error(case.own) > _LOUD:
        found += _exchanged(case, equations, held_equations)
    return tuple(sorted(found, key=lambda f: f.left))


@dataclass(frozen=True, eq=False)
class _Case:
    """Torques as they are recorded.

    Attributes:
        base: summary of the training logs.
        other: of the validation logs, or None.
        own: what `block_errors` are for the training logs.
    """

    base: Blocks
    other: Blocks | None
    own: FloatArray

    def left(self, train: Blocks, held: Blocks | None) -> tuple[float, float]:
        """Return what undoing a fault leaves, see `_left`; 1 where other logs do not confirm it.

        Args:
            train, held: the summaries with the fault undone.
        """
        share, together = _left(self.own, block_errors(train, train))
        if share > _CLEARER or self.other is None or held is None:
            return share, together
        before, X = _shares(self.other, self.base.fit()), train.fit()
        # The fault may be one of the training logs alone.
        plain = [] if held.grams.shape != self.other.grams.shape else [_shares(self.other, X)]
        for after in (_shares(held, X), *plain):
            ratio = after / np.where(before > 0, before, np.inf)
            if ratio.mean() < 1 and np.sqrt(ratio.min()) <= _CLEARER:
                return share, together
        return 1.0, 1.0


def _shares(blocks: Blocks, X: FloatArray) -> FloatArray:
    """Return ||y - W X||^2 / ||y||^2 by joint, (m,)."""
    grams = blocks.grams.sum(axis=0)
    measured = grams[:, -1, -1]
    return residual_squares(grams, X) / np.where(measured > 0, measured, np.inf)


def _left(own: FloatArray, other: FloatArray) -> tuple[float, float]:
    """Return what is left of the error of the joint that gains most, and of all; 1 for chance.

    All joints together, each in units of its own error, must gain; as must the torques themselves.
    """
    whole, rest = own.sum(axis=0), other.sum(axis=0)
    scale = 1 / np.where(whole > 0, whole, np.inf)
    together = float(np.sqrt((rest * scale).sum() / max((whole * scale).sum(), 1e-300)))
    if together >= 1.0 or rest.sum() >= whole.sum():
        return 1.0, 1.0
    gained = own - other
    deviation = gained.std(axis=0, ddof=1) * np.sqrt(len(gained))
    sure = (gained.sum(axis=0) > _STD * deviation) & (whole > 0)
    return float(np.sqrt(rest * scale)[sure].min(initial=1.0)), together


_Logs = tuple[Sequence[FilteredLog], Sequence[tuple[Equations, ...]]]


def _late(case: _Case, train: _Logs, held: _Logs) -> list[Fault]:
    """Find torques that are late against the motion: tau(t) = model(t - delay)."""
    blocks = _with_delay(*train)
    best, left = case.left(blocks, _with_delay(*held) if held[1] else None)
    delay = float(blocks.fit()[-1])
    if max(best, left) > _CLEARER:  # it is common to all joints, or none
        return []
    word = "late" if delay > 0 else "early"
    says = f"the torques of all joints are {1e3 * abs(delay):.2g} ms {word} against the motion"
    return [Fault("tau", says, left, "delay", tuple(range(len(case.base.size))), delay)]


def _with_delay(logs: Sequence[FilteredLog], equations: Sequence[tuple[Equations, ...]]) -> Blocks:
    """Summarise tau = W X - delay dtau/dt."""
    extended = []
    for log, rows in zip(logs, equations, strict=True):
        slope = log.compared(np.gradient(log.tau, log.step, axis=0))
        longer = []
        for j, e in enumerate(rows):
            d = slope[:, j] if log.mask is None else slope[log.free[:, j], j]
            longer.append(replace(e, W=np.column_stack([e.W, -d]), Z=None))
        extended.append(tuple(longer))
    return summary(placed(extended), len(equations[0]))


def _factor(case: _Case, j: int) -> list[Fault]:
    """Find a torque that fits better with another factor, beside those of the other joints."""
    base = case.base
    if len(base.size) == 1:
        return []

    best = _fitted_factor(base, j)
    if not 1e-6 < abs(best) < 1e6:
        return []
    held = None if case.other is None else _scaled(case.other, j, best)
    share, _ = case.left(_scaled(base, j, best), held)
    if share > _CLEARER or abs(best - 1) < _GAIN:
        return []
    if best < 0:
        return [Fault(f"tau{j + 1}", f"tau{j + 1} has the other sign", share, "sign", (j,), best)]
    says = (
        f"tau{j + 1} is {best:.3g} times what the other joints ask for (torque constant, gear "
        "ratio or unit)"
    )
    return [Fault(f"tau{j + 1}", says, share, "gain", (j,), best)]


def _fitted_factor(base: Blocks, j: int) -> float:
    """Return g with tau_j / g = W_j X, where the other joints say what X is.

    Weighted least squares of X and 1/g together: y_j stands on the side of the unknowns.
    """
    grams, rows = base.grams.sum(axis=0), np.maximum(base.rows.sum(axis=0), 1.0)
    left = residual_squares(grams, base.fit()) / rows
    weight = 1 / np.maximum(left, 1e-12 * base.size**2)
    weight[j] = 1 / base.size[j] ** 2
    p = grams.shape[-1] - 1
    whole = np.zeros((p + 2, p + 2))  # X, 1/g, and what the other joints measured
    for i, (gram, w) in enumerate(zip(grams, weight, strict=True)):
        own = np.arange(p + 2) != (p + 1 if i == j else p)
        signs = np.ones(p + 1)
        signs[-1] = -1.0 if i == j else 1.0
        whole[np.ix_(own, own)] += w * gram * np.outer(signs, signs)
    inverse = float(solve_gram(whole)[-1])
    return 1 / inverse if inverse else np.inf


def _scaled(base: Blocks, j: int, g: float) -> Blocks:
    grams = base.grams.copy()
    grams[:, j, -1, :] /= g
    grams[:, j, :, -1] /= g
    return Blocks(grams, base.rows)


def _exchanged(
    case: _Case,
    equations: Sequence[tuple[Equations, ...]],
    held: Sequence[tuple[Equations, ...]],
) -> list[Fault]:
    """Find two joints whose torques stand in each other's channel."""
    n = len(equations[0])
    if any(len(e.y) != len(log[0].y) for log in (*equations, *held) for e in log):
        return []  # masks differ from joint to joint
    out = []
    for j, k in combinations(range(n), 2):
        other = _turned(held, j, k) if held else None
        left, _ = case.left(_turned(equations, j, k), other)
        if left < _EXCHANGED:
            says = f"tau{j + 1} and tau{k + 1} stand in each other's place"
            channel = f"tau{j + 1}, tau{k + 1}"
            out.append(Fault(channel, says, left, "exchange", (j, k), 0.0))
    return sorted(out, key=lambda f: f.left)[:1]


def _turned(equations: Sequence[tuple[Equations, ...]], j: int, k: int) -> Blocks:
    """Summarise the equations with the torques of two joints exchanged."""
    turned = [
        tuple(
            replace(e, y=log[k if i == j else j].y) if i in (j, k) else e for i, e in enumerate(log)
        )
        for log in equations
    ]
    return summary(placed(turned), len(equations[0]))
