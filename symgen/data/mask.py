"""Masks of samples: joints at rest, and saturated torques.

At rest, Coulomb friction can take any value between its limits. A saturated torque is not the
commanded one, or was not measured. Masked samples stay in the log, so that nothing is interpolated
over them; equations that contain them are removed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symgen.data.raw import Bools as Bools
from symgen.data.raw import FloatArray, Places

#: A joint below this share of its largest speed, for this long in s, is at rest.
SLOW, REST = 0.02, 0.1
#: A joint ten times slower, for a third of that time, is also at rest: a stop between two moves.
STOPPED, STOP = 0.1, 0.03
#: A joint whose largest speed is below this share of the fastest one of its type never moves.
STILL = 0.02
#: A torque this close to a declared limit, or this many times in a row at its extreme, is
#: saturated.
NEAR, STUCK = 0.999, 5
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Mask:
    """The masked samples.

    Attributes:
        joint: (N, n) mask for equations of a joint: momentum and torque.
        robot: (N,) mask for equations of all joints: energy.
    """

    joint: Bools
    robot: Bools

    def near(self, reach: int) -> Bools:
        """Return (N, n): whether a masked sample of the joint is at most `reach` samples away."""
        return touched(self.joint, reach)


def rms(x: FloatArray) -> FloatArray:
    """Return the root mean square of every column."""
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def touched(masked: Bools, reach: int) -> Bools:
    """Return (N, ...): whether a masked sample is at most `reach` samples away."""
    at = np.arange(len(masked))
    first = np.maximum(at - reach, 0)
    last = np.minimum(at + reach, len(masked) - 1)
    return ~untouched(masked, first, last)


def untouched(masked: Bools, first: Places, last: Places) -> Bools:
    """Return which windows from sample `first` to `last` (inclusive) have no masked sample.

    Args:
        masked: (N, ...) mask of the log.
        first, last: (K,) numbers of samples.

    Returns:
        (K, ...).
    """
    none = np.zeros((1, *masked.shape[1:]), dtype=int)
    count = np.concatenate([none, np.cumsum(masked, axis=0)])
    return count[last + 1] <= count[first]


def slow_speeds(largest: FloatArray, sigma: Sequence[int]) -> tuple[FloatArray, Bools]:
    """Return the speed limits of rest, rad/s (m/s), and which joints never move, (n,) each.

    Args:
        largest: (n,) largest speeds of the joints.
        sigma: (n,) types of the joints.
    """
    kinds = np.asarray(sigma)
    still: Bools = np.zeros(len(kinds), dtype=bool)
    for kind in {*sigma}:
        alike = kinds == kind
        speeds = largest[alike]
        still[alike] = speeds <= STILL * speeds.max()
    return SLOW * largest, still


def moving_joints(speeds: Sequence[FloatArray], sigma: Sequence[int]) -> list[int]:
    """Return the joints that move in at least one log.

    Args:
        speeds: (N, n) of each log, rad/s (m/s).
        sigma: (n,) types of the joints.
    """
    peaks = [np.abs(qd).max(axis=0) for qd in speeds]
    _, still = slow_speeds(np.max(peaks, axis=0), sigma)
    return np.flatnonzero(~still).tolist()


def mean_speeds(q: FloatArray, step: float, span: float = REST) -> FloatArray:
    """Return the mean speed of joints over a span, (N, n), rad/s (m/s).

    It is computed from positions: noise of measured speeds would hide a rest.

    Args:
        q: (N, n) positions, rad (m).
        step: sampling step in s.
        span: length of the span, s.
    """
    half = max(1, round(span / step / 2))
    at = np.arange(len(q))
    last = np.minimum(at + half, len(q) - 1)
    steps = last - np.maximum(at - half, 0)
    padded = np.pad(q, ((half, half), (0, 0)), mode="edge")  # no copy of the slices
    change = padded[2 * half :] - padded[: -2 * half]
    duration = np.maximum(steps, 1) * step
    return np.asarray(change / duration[:, None])


def resting(q: FloatArray, step: float, slow: FloatArray) -> Bools:
    """Find where joints are at rest: slower than a limit for 0.1 s, or stopped.

    A joint is stopped if it is ten times slower for 0.03 s: a reversal without a stop is shorter.

    Args:
        q: (N, n) positions, rad (m).
        step: sampling step in s.
        slow: (n,) limits of the mean speed over 0.1 s, rad/s (m/s).

    Returns:
        (N, n): at rest.
    """
    return _slower(q, step, REST, slow) | _slower(q, step, STOP, STOPPED * slow)


def _slower(q: FloatArray, step: float, span: float, limits: FloatArray) -> Bools:
    """Return where the mean speed over a span is below its limit for that long, (N, n)."""
    slow = np.abs(mean_speeds(q, step, span)) <= limits
    shortest = max(2, round(span / step))
    return np.column_stack([_runs(column, shortest) for column in slow.T])


def saturated(
    tau: FloatArray, limits: Sequence[float] | None, ratio: Sequence[Sequence[float]] | None
) -> Bools:
    """Find saturated torques: at a declared limit, or constant at an extreme of the log.

    A torque is constant at an extreme if it has the largest or smallest value of the log five times
    in a row.

    Args:
        tau: (N, n) torques on the joint side, N m (N).
        limits: (n,) torque limits of the joints, or None.
        ratio: (n, n) gear ratios of [drive], or None. A saturated motor masks the joints that it
            moves.

    Returns:
        (N, n): whether the torque of a joint is saturated.
    """
    moved = np.array(np.eye(tau.shape[1]) if ratio is None else ratio)
    motors = np.linalg.solve(moved.T, tau.T)
    stuck = np.column_stack([_stuck(motor) for motor in motors])
    out = stuck @ (moved != 0)
    if limits is not None:
        out |= np.abs(tau) >= NEAR * np.array(limits)
    return np.asarray(out)


def _stuck(x: FloatArray) -> Bools:
    """Return where a signal is constant at an extreme of at least half its largest size."""
    size = float(np.abs(x).max())
    out = np.zeros(len(x), dtype=bool)
    if np.ptp(x) <= _SAME * size:
        return out
    for extreme in (x.max(), x.min()):
        if abs(extreme) >= 0.5 * size:
            out |= _runs(np.abs(x - extreme) <= _SAME * size, STUCK)
    return out


def _runs(flags: Bools, shortest: int) -> Bools:
    """Return the flags that are in runs of at least `shortest`."""
    out = np.zeros(len(flags), dtype=bool)
    for start, end in spans(flags):
        out[start:end] = end - start >= shortest
    return out


def spans(flags: Bools) -> Places:
    """Return the runs of flags, (k, 2): first position, and position after the last."""
    if not flags.any():  # most channels have none
        return np.zeros((0, 2), dtype=np.int64)
    edges = np.flatnonzero(np.diff(flags, prepend=False, append=False))
    return edges.reshape(-1, 2)


def on_grid(masked: Bools, t: FloatArray, grid: FloatArray) -> Bools:
    """Transfer a mask (N, ...) from times t to a grid; masked samples mask both neighbours."""
    if np.array_equal(t, grid):
        return masked
    after = np.searchsorted(t, grid)
    after = np.clip(after, 0, len(t) - 1)
    before = np.maximum(after - 1, 0)
    return masked[after] | masked[before]
