"""Measured speeds and torques against the motion: in a band, which positions alone give."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from symgen.data.mask import Bools, rms, touched
from symgen.data.raw import FloatArray
from symgen.data.signals import (
    OPEN,
    Samples,
    lowpass,
    lowpass_and_slopes,
    white_noise,
)
from symgen.faults.channels import moves
from symgen.faults.fault import Fault
from symgen.faults.rules import Rule, Symptom, apply
from symgen.faults.undo import shifted, with_column
from symgen.policy import LEAST

#: Correlation of speeds with dq/dt below which they are of something else.
_CORRELATED = 0.9
#: Part of the squared difference to dq/dt that gain, delay and offset explain.
_EXPLAINED = 0.2
#: Standard deviations of noise in the band that are motion.
_STILL = 3.0
_NOISY = 2.0  # difference of a speed to dq/dt over its noise, above which it is no noise
_PASSES = 3  # to find a delay of many samples
_SLOPES = 5.0  # band of the comparison, in comparison bands


def mended_speeds(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Fault, ...]]:
    """Replace measured speeds that disagree with dq/dt.

    Args:
        samples: a log with uniform steps and measured speeds.
        comparison_hz: comparison band of the run, Hz.
    """
    if samples.velocity_derived:
        return samples, ()
    return apply(SPEEDS, samples, _compared(samples, comparison_hz))


def silenced_torques(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Fault, ...]]:
    """Take the torque of a joint as zero that is noise throughout while the joint moves.

    Args:
        samples: a log with uniform steps.
        comparison_hz: comparison band of the run, Hz.
    """
    return apply((SILENT,), samples, comparison_hz)


def standing(samples: Samples, comparison_hz: float) -> Bools:
    """Return which joints stand still throughout, (n,): what they seem to move is noise."""
    step, band = samples.step, _within(comparison_hz, samples.step)
    return _at_standstill(samples.q, lowpass(samples.q, step, band), step, band)


def _at_standstill(x: FloatArray, low: FloatArray, step: float, band: float) -> Bools:
    """Return whether low-passed positions contain nothing but noise, (k,).

    Args:
        x: (N, k) positions.
        low: (N, k) low-passed positions.
        step: sampling step in s.
        band: cutoff of the filter in Hz, below Nyquist.
    """
    quiet = np.std(low, axis=0) <= _STILL * _noise(x - low, step, band)
    few = np.array([not moves(column) for column in x.T])
    return np.asarray(quiet | few)


def _within(band: float, step: float) -> float:
    """Return a band in Hz, or the largest that logs of this step have."""
    return min(band, 0.5 * OPEN / step)


def _noise(high: FloatArray, step: float, band: float) -> FloatArray:
    """Return the standard deviation in a band, (k,), of white noise with this part above it."""
    return white_noise(high, step, band) * math.sqrt(2 * band * step)


@dataclass(frozen=True, eq=False)
class _Speed:
    """A measured speed beside dq/dt: qd = (1 + GV) v(t - LV) + OV, v = dq/dt.

    Attributes:
        v: (N,) dq/dt in the band, rad/s (m/s).
        errors: (3,) GV, LV in s, and OV.
        std: (3,) their standard deviations.
        size: RMS difference of the fit to v, relative to v.
        explained: part of the squared difference of qd to v that the fit explains.
        correlation: of qd with v, at best.
    """

    v: FloatArray
    errors: FloatArray
    std: FloatArray
    size: float
    explained: float
    correlation: float

    @property
    def unrelated(self) -> bool:
        """Whether it is the speed of something else."""
        return self.correlation < _CORRELATED

    @property
    def wrong(self) -> bool:
        """Whether it has an error that matters."""
        return self.unrelated or (self.size > LEAST and self.explained > _EXPLAINED)

    def finding(self, j: int) -> Symptom:
        """Return what is wrong with the speed of joint j."""
        gain, delay, offset = self.errors
        numbers = {"gain": 1 + gain, "late": 1e3 * delay, "offset": offset}
        pairs = zip(("GV", "LV", "OV"), zip(self.errors, self.std, strict=True), strict=True)
        values = {} if self.unrelated else {name: (float(x), float(s)) for name, (x, s) in pairs}
        return Symptom("qd", j, len(self.v), self.v, numbers, values)


def _compared(samples: Samples, comparison_hz: float) -> dict[int, _Speed]:
    """Compare measured speeds with dq/dt in a band wider than the comparison band, by joint.

    Masked samples, and joints that stand still, are not compared.
    """
    step = samples.step
    band = _within(_SLOPES * comparison_hz, step)
    at = np.ones(len(samples.t), dtype=bool)
    if samples.mask is not None:  # without samples that the filter mixes with masked ones
        at = ~touched(samples.mask.robot, math.ceil(1 / (band * step)))
    positions, slopes, bends = lowpass_and_slopes(samples.q, step, band, 2)
    smooth = lowpass(samples.qd, step, band)
    still = _at_standstill(samples.q, positions, step, band)
    noise = _noise(samples.qd - smooth, step, band)
    found = {}
    for j in map(int, np.flatnonzero(~still)):
        v, w = slopes[:, j], smooth[:, j]
        if v[at].any() and rms((w - v)[at]) > _NOISY * noise[j]:
            found[j] = _fit(v, bends[:, j], w, at, step, 0.25 / comparison_hz)
    return found


def _fit(
    v: FloatArray, a: FloatArray, w: FloatArray, at: Bools, step: float, longest: float
) -> _Speed:
    """Fit a measured speed w by dq/dt = v and its derivative a, at some rows, by least squares.

    Args:
        v, a, w: (N,) in one band.
        at: (N,) the rows.
        step: sampling step, s.
        longest: largest delay, s.
    """
    A = np.column_stack([v, a, np.ones(len(v))])[at]
    delay, inverse = 0.0, np.linalg.pinv(A)
    for _ in range(_PASSES):
        moved = shifted(w, delay, step)[at]
        slope, bend, offset = inverse @ moved
        later = delay - bend / slope if slope else np.inf
        if abs(later) > longest:
            break
        delay = float(later)
    moved, fitted = shifted(w, delay, step)[at], A @ [slope, 0.0, offset]
    difference = (w - v)[at]
    rest = float(np.mean((moved - fitted) ** 2))
    error = A @ [slope - 1, -slope * delay, offset]
    # Filtered rows are correlated: one per period of the low-pass counts.
    noise = rest * max(longest / step, 1.0)
    std = np.sqrt(noise / np.maximum(np.sum(A**2, axis=0), 1e-300))
    return _Speed(
        v,
        np.array([slope - 1, delay, offset]),
        std,
        float(rms(error) / rms(v[at])),
        1 - rest / float(np.mean(difference**2)),
        float(np.corrcoef(moved, v[at])[0, 1]) if np.ptp(moved) else 0.0,
    )


def _unrelated(_: Samples, speeds: Mapping[int, _Speed]) -> Iterator[Symptom]:
    """Find measured speeds that are those of something else."""
    for j, speed in speeds.items():
        if speed.unrelated:
            yield speed.finding(j)


def _wrong(_: Samples, speeds: Mapping[int, _Speed]) -> Iterator[Symptom]:
    """Find measured speeds that are scaled, late or off."""
    for j, speed in speeds.items():
        if speed.wrong and not speed.unrelated:
            yield speed.finding(j)


def _replace(samples: Samples, found: Symptom) -> Samples:
    return with_column(samples, found.channel, found.joint or 0, found.data)


def _silent(samples: Samples, comparison_hz: float) -> Iterator[Symptom]:
    """Find torques that are noise throughout while the joint moves, if another torque is not.

    The RMS of noise is uncertain by 1 / sqrt(4 B T) in a band B.
    """
    step, band = samples.step, _within(comparison_hz, samples.step)
    low = lowpass(samples.tau, step, band)
    most = 1 + _STILL / math.sqrt(4 * band * step * len(low))
    drowned = rms(low) <= most * _noise(samples.tau - low, step, band)
    silent = low.any(axis=0) & drowned & ~drowned.all() & ~standing(samples, comparison_hz)
    for j in map(int, np.flatnonzero(silent)):
        yield Symptom("tau", j, len(low), np.zeros(len(low)))


#: Rules for speeds: each finder takes samples, and the speeds that are compared with dq/dt.
SPEEDS = (
    Rule("unrelated", _unrelated, "it does not follow dq/dt", "replaced by dq/dt", _replace),
    Rule(
        "speed", _wrong, "{gain} times dq/dt, {late} ms late, off by {offset}",
        "replaced by dq/dt", _replace,
    ),
)  # fmt: skip
SILENT = Rule(
    "silent", _silent, "noise throughout while the joint moves", "taken as zero", _replace
)
