"""Samples that no equation may touch: joints at rest, and torques in saturation.

At rest the torque of Coulomb friction can be anything between its limits, and a torque in
saturation is not the one that was asked for, or not measured at all. Masked samples stay in the
log, so that nothing is interpolated over them; equations that touch them are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symgen.data.raw import Bools as Bools
from symgen.data.raw import FloatArray, Places

#: Below this part of its largest speed, for this long in s, a joint is at rest.
SLOW, REST = 0.02, 0.1
#: Ten times slower, for a third of that time, it is as well: a stop between two moves.
STOPPED, STOP = 0.1, 0.03
#: A joint whose largest speed is below this part of the fastest one's of its kind never moves.
STILL = 0.02
#: So near to a declared limit, and so often in a row at its own extreme, a torque is saturated.
NEAR, STUCK = 0.999, 5
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Mask:
    """What no equation may touch.

    Attributes:
        joint: (N, n) for the equations of each joint: momentum and torque.
        robot: (N,) for the equations that all joints share: energy.
    """

    joint: Bools
    robot: Bools

    def near(self, reach: int) -> Bools:
        """Return (N, n) whether a masked sample of the joint is at most `reach` samples away."""
        return np.column_stack([touched(column, reach) for column in self.joint.T])


def rms(x: FloatArray) -> FloatArray:
    """Return the root mean square of every column."""
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def touched(masked: Bools, reach: int) -> Bools:
    """Return (N,) whether a masked sample is at most `reach` samples away."""
    count = np.concatenate([[0], np.cumsum(masked)])
    at = np.arange(len(masked))
    low, high = np.maximum(at - reach, 0), np.minimum(at + reach + 1, len(masked))
    return count[high] > count[low]


def untouched(masked: Bools, first: Places, last: Places) -> Bools:
    """Return which windows from sample `first` to sample `last`, both included, have none masked.

    Args:
        masked: (N,) of the log.
        first, last: (K,) numbers of samples.
    """
    count = np.concatenate([[0], np.cumsum(masked)])
    return np.asarray(count[last + 1] == count[first])


def at_rest(qd: FloatArray, step: float, sigma: Sequence[int]) -> tuple[Bools, Bools]:
    """Find where joints are at rest: under 2 % of their largest speed for 0.1 s or longer.

    A reversal is no rest. A joint that is slower than 2 % of the fastest of its kind throughout is
    held still: it never moves and is not at rest either.

    Args:
        qd: (N, n) speeds in rad/s (m/s).
        step: sampling step in s.
        sigma: (n,) types of the joints.

    Returns:
        (N, n) at rest, and (n,) held still.
    """
    slow, still = slow_speeds(np.max(np.abs(qd), axis=0), sigma)
    return _long(np.abs(qd) <= np.maximum(slow, SLOW * 1e-300), step) & ~still, still


def slow_speeds(largest: FloatArray, sigma: Sequence[int]) -> tuple[FloatArray, Bools]:
    """Return below which speeds joints are at rest, rad/s (m/s), and which are held still, (n,).

    Args:
        largest: (n,) speeds of the joints.
        sigma: (n,) types of the joints.
    """
    kinds = np.asarray(sigma)
    fastest = np.array([largest[kinds == kind].max() for kind in kinds])
    return SLOW * largest, np.asarray(largest <= STILL * fastest)


def moving_joints(speeds: Sequence[FloatArray], sigma: Sequence[int]) -> list[int]:
    """Return the joints that are not held still in all of some logs.

    Args:
        speeds: (N, n) of each log, rad/s (m/s).
        sigma: (n,) types of the joints.
    """
    largest = np.max([np.abs(qd).max(axis=0) for qd in speeds], axis=0)
    return [int(j) for j in np.flatnonzero(~slow_speeds(largest, sigma)[1])]


def mean_speeds(q: FloatArray, step: float, span: float = REST) -> FloatArray:
    """Return how fast joints move on the average of a span, 0.1 s, (N, n), rad/s (m/s).

    Encoders tell it better than tachometers, whose noise hides a rest.

    Args:
        q: (N, n) positions, rad (m).
        step: sampling step in s.
        span: s.
    """
    half, at = max(1, round(span / step / 2)), np.arange(len(q))
    apart = np.minimum(at + half, len(q) - 1) - np.maximum(at - half, 0)
    held = np.pad(q, ((half, half), (0, 0)), mode="edge")  # slices of it are no copies
    change = held[2 * half :] - held[: -2 * half]
    return np.asarray(change / (np.maximum(apart, 1) * step)[:, None])


def resting(q: FloatArray, step: float, slow: FloatArray) -> Bools:
    """Find where joints are at rest: slower than some speed for 0.1 s, or stopped, see `stops`.

    Args:
        q: (N, n) positions, rad (m).
        step: sampling step in s.
        slow: (n,) rad/s (m/s), on the average of 0.1 s.

    Returns:
        (N, n) at rest.
    """
    return _long(np.abs(mean_speeds(q, step)) <= slow, step) | stops(q, step, STOPPED * slow)


def stops(q: FloatArray, step: float, slow: FloatArray) -> Bools:
    """Find where joints stop, however short: on the average of 0.03 s slower than a speed, so long.

    A reversal without a stop is over sooner. Arguments and result as for `resting`.
    """
    return in_rows(np.abs(mean_speeds(q, step, STOP)) <= slow, max(2, round(STOP / step)))


def saturated(
    tau: FloatArray, limits: Sequence[float] | None, ratio: Sequence[Sequence[float]] | None
) -> Bools:
    """Find where torques are at a limit: a declared one, or one where they are stuck.

    Stuck is a drive's torque at the largest or smallest value of the log five times in a row.

    Args:
        tau: (N, n) torques on the joint side, N m (N).
        limits: (n,) of the joints' torques, or None.
        ratio: (n, n) of [drive], or None: through it a saturated motor concerns the joints that
            it moves.

    Returns:
        (N, n) whether the torque of a joint is saturated.
    """
    moved = np.eye(tau.shape[1]) if ratio is None else np.array(ratio)
    motors = np.linalg.solve(moved.T, tau.T).T
    stuck = np.column_stack([_stuck(column) for column in motors.T])
    out = stuck @ (moved != 0)
    return np.asarray(out if limits is None else out | (np.abs(tau) >= NEAR * np.array(limits)))


def _stuck(x: FloatArray) -> Bools:
    """Return where a signal is flat at an extreme that is at least half its largest size."""
    size = float(np.abs(x).max())
    if np.ptp(x) <= _SAME * size:
        return np.zeros(len(x), dtype=bool)
    out = np.zeros(len(x), dtype=bool)
    for extreme in (x.max(), x.min()):
        if abs(extreme) >= 0.5 * size:
            out |= _runs(np.abs(x - extreme) <= _SAME * size, STUCK)
    return out


def _long(slow: Bools, step: float) -> Bools:
    """Return where joints (N, n) are slow for long enough to be at rest."""
    return in_rows(slow, max(2, round(REST / step)))


def in_rows(flags: Bools, least: int) -> Bools:
    """Return the flags (N, n) that stand in runs of at least `least` samples."""
    return np.column_stack([_runs(column, least) for column in flags.T])


def _runs(flags: Bools, least: int) -> Bools:
    """Return the flags that stand in runs of at least `least`."""
    out = np.zeros(len(flags), dtype=bool)
    for start, end in spans(flags):
        out[start:end] = end - start >= least
    return out


def spans(flags: Bools) -> Places:
    """Return where flags stand in a row: (k, 2) first, and behind the last."""
    if not flags.any():  # as of most channels
        return np.zeros((0, 2), dtype=np.int64)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return edges.reshape(-1, 2)


def on_grid(masked: Bools, t: FloatArray, grid: FloatArray) -> Bools:
    """Carry a mask (N, ...) at times t over to a grid: a sample between two with one masked is."""
    if len(t) == len(grid) and np.array_equal(t, grid):
        return masked
    after = np.clip(np.searchsorted(t, grid), 0, len(t) - 1)
    return masked[after] | masked[np.maximum(after - 1, 0)]
