"""Measured speeds against dq/dt: late, scaled or off, and mended; torques that are late, too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import Bools, touched
from symgen.data.raw import read_only
from symgen.data.signals import Samples, lowpass, lowpass_and_slopes, white_noise
from symgen.estimation.band import OPEN
from symgen.estimation.repairs import Repair

FloatArray = NDArray[np.float64]
#: Speeds are mended where that leaves so much of the square of their disagreement, at most.
_SPEEDS = 0.8
#: Correlation of speeds with dq/dt under which they are replaced by it.
_FOLLOWS = 0.9
_LATE, _SCALED = 0.1, 0.02  # of a sample; of 1
_NOISY = 2.0  # times its noise a speed may be off before it is said not to follow
_SETTLED = 1e-3  # of a sample
_STILL = 3.0  # spreads of noise in the band within which a position is noise
_SLOPES = 5.0  # the band of that comparison, in comparison bands


def mended_speeds(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Repair, ...]]:
    """Shift and rescale measured speeds that are late or scaled against dq/dt; replace wrong ones.

    In a band somewhat wider than the comparison band, least squares
    qd = g (v - delay a) + offset with v = dq/dt and a its derivative; what is masked for the robot,
    a position that is stuck say, is not compared.

    Args:
        samples: a log on uniform steps, with measured speeds.
        comparison_hz: of the run.
    """
    if samples.velocity_derived:
        return samples, ()
    step = samples.step
    band = min(_SLOPES * comparison_hz, 0.5 * OPEN / step)
    qd = samples.qd.copy()
    seen = _compared(samples, band)
    positions, slopes, bends = lowpass_and_slopes(samples.q, step, band, 2)
    smooth = lowpass(qd, step, band)
    found: list[_Speed] = []
    done: list[Repair] = []
    still = at_standstill(samples.q, positions, step, band)
    noise = white_noise(samples.qd - smooth, step, band) * math.sqrt(2 * band * step)
    for j in map(int, np.flatnonzero(~still)):  # the rest have no motion that a speed could follow
        v, w = np.ascontiguousarray(slopes[:, j]), np.ascontiguousarray(smooth[:, j])
        if not np.any(v[seen]):
            continue
        a = np.ascontiguousarray(bends[:, j])
        speed = _speed(j, v, a, w, step, 0.25 / comparison_hz, seen)
        if speed is None and float(np.std((w - v)[seen])) <= _NOISY * noise[j]:
            continue  # the joint is slower than the noise of its sensor
        if speed is None:
            qd[:, j] = v
            done.append(_replaced(samples, j, "it does not follow dq/dt"))
        elif speed.wrong:
            found.append(speed)
            moved = _shifted(qd[:, j], speed.delay, step)
            qd[:, j] = (moved - speed.offset) / speed.gain
    done += _said(samples, found)
    if not done:
        return samples, ()
    return replace(samples, qd=read_only(qd)), tuple(done)


def at_standstill(x: FloatArray, low: FloatArray, step: float, band: float) -> Bools:
    """Whether positions never leave their place: what a low-pass lets pass of them is noise.

    Args:
        x: (N, k) positions.
        low: what passed the filter.
        step: sampling step in s.
        band: cutoff of the filter in Hz, below Nyquist.

    Returns:
        (k,) true where the spread of `low` is not three times that of white noise in the band, or
        where x stays within two of its smallest steps.
    """
    noise = white_noise(x - low, step, band) * np.sqrt(2 * band * step)
    steps = np.abs(np.diff(x, axis=0))
    least = np.min(np.where(steps > 0, steps, np.inf), axis=0, initial=np.inf)
    within = np.ptp(x, axis=0) <= 2.5 * np.where(np.isfinite(least), least, 0.0)
    return np.asarray((np.std(low, axis=0) <= _STILL * noise) | within)


def _compared(samples: Samples, band: float) -> Bools:
    """Return the samples that a filter of that band keeps clear of what is masked, (N,)."""
    if samples.mask is None or not samples.mask.robot.any():
        return np.ones(len(samples.t), dtype=bool)
    return ~touched(samples.mask.robot, math.ceil(1 / (band * samples.step)))


@dataclass(frozen=True)
class _Speed:
    """What is wrong with the speed of joint j: qd = gain (dq/dt - delay d2q/dt2) + offset."""

    j: int
    delay: float = 0.0
    gain: float = 1.0
    offset: float = 0.0
    std: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def wrong(self) -> bool:
        """Whether anything is."""
        return bool(self.delay or self.offset or self.gain != 1.0)


def _speed(
    j: int,
    v: FloatArray,
    a: FloatArray,
    w: FloatArray,
    step: float,
    longest: float,
    seen: Bools,
) -> _Speed | None:
    """Compare a measured speed w with v = dq/dt where it is seen; None if it does not follow it.

    Delay, then gain, then offset are taken where each of them leaves at most four fifths of the
    square of the disagreement.
    """
    delay, v, a = 0.0, v[seen], a[seen]
    for _ in range(3):
        moved = _shifted(w, delay, step)[seen]
        g, d, _ = _least_squares(np.column_stack([v, a, np.ones(len(v))]), moved)
        if g == 0 or abs(delay - d / g) > longest:
            break
        delay -= float(d / g)
        if abs(d / g) < _SETTLED * step:
            break
    moved, w = _shifted(w, delay, step)[seen], w[seen]
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
    # Rows that pass the low-pass share samples: one in a period of it counts.
    noise = left / max(len(v), 1) * max(longest / step, 1.0)
    std = tuple(float(np.sqrt(noise / max(float(x @ x), 1e-300))) for x in (a, v, np.ones(len(v))))
    return _Speed(j, delay, gain, offset, (std[0], std[1], std[2]))


def _least_squares(A: FloatArray, y: FloatArray) -> FloatArray:
    """Solve y = A x of a few columns by their products: one pass over many rows."""
    size = np.sqrt(np.einsum("ka,ka->a", A, A))
    size = np.where(size > 0, size, 1.0)
    found = np.linalg.lstsq(A.T @ A / np.outer(size, size), (y @ A) / size, rcond=None)[0]
    return np.asarray(found / size)


def _replaced(samples: Samples, j: int, fault: str) -> Repair:
    return Repair(samples.name, f"qd{j + 1}", fault, len(samples.t), "replaced by dq/dt")


def _said(samples: Samples, found: Sequence[_Speed]) -> list[Repair]:
    """Say delays: one of the recorder where all joints share it, else joint by joint."""
    n, count = samples.q.shape[1], len(samples.t)
    delays = np.array([speed.delay for speed in found])
    out = []
    common = len(found) == n > 1 and np.ptp(delays) <= max(0.2 * abs(delays.mean()), samples.step)
    if common and all(f.gain == 1.0 and f.offset == 0.0 for f in found):
        fault = f"speeds of all joints are {_late(float(delays.mean()))} (recorder or stamps)"
        std = float(np.mean([f.std[0] for f in found]))
        mean = (("LV", float(delays.mean()), std),)
        return [Repair(samples.name, "qd", fault, count, "shifted", mean)]
    for f in found:
        faults, done, values = [], [], []
        if f.gain != 1.0:
            faults.append(f"{f.gain:.4g} times dq/dt")
            done.append("rescaled")
            values.append(("GV", f.gain - 1, f.std[1]))
        if f.delay:
            faults.append(_late(f.delay))
            done.append("shifted")
            values.append(("LV", f.delay, f.std[0]))
        if f.offset:
            faults.append(f"off by {f.offset:.3g}")
            done.append("moved to zero")
            values.append(("OV", f.offset, f.std[2]))
        said, what = " and ".join(faults), " and ".join(done)
        out.append(Repair(samples.name, f"qd{f.j + 1}", said, count, what, tuple(values)))
    return out


def _late(delay: float) -> str:
    return f"{abs(1e3 * delay):.2g} ms {'late' if delay > 0 else 'early'}"


def shifted(samples: Samples, delay: float) -> Samples:
    """Return a log whose torques were measured `delay` s earlier."""
    columns = [_shifted(x, delay, samples.step) for x in samples.tau.T]
    return replace(samples, tau=read_only(np.column_stack(columns)))


def _shifted(x: FloatArray, delay: float, step: float) -> FloatArray:
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
