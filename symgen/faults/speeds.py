"""Compare measured speeds and torques with the motion, in a band."""

from __future__ import annotations

import math

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
from symgen.faults.rules import Channel, Rule, Symptom, apply, with_values
from symgen.faults.undo import shifted
from symgen.policy import BEYOND, LEAST

#: Smallest correlation of speeds with dq/dt; below it they measure something else. Share of the
#: squared difference to dq/dt that gain, delay and offset must explain.
_CORRELATED, _EXPLAINED = 0.9, 0.2
_SLOPES = 5.0  # band in which speeds are compared, in comparison bands
_PASSES = 3  # to find a delay of many samples


def mended_speeds(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Fault, ...]]:
    """Replace measured speeds that disagree with dq/dt.

    In a band wider than the comparison band, least squares fits

        qd = (1 + GV) v(t - LV) + OV,    v = dq/dt

    v replaces a speed if the fit differs from v by more than what matters. The fit must also
    explain a fifth of the squared difference between the speed and v. v also replaces a speed
    without correlation to v.

    Args:
        samples: a log with uniform steps and measured speeds.
        comparison_hz: comparison band of the run, Hz.
    """
    return (samples, ()) if samples.velocity_derived else apply((SPEED,), samples, comparison_hz)


def silenced_torques(samples: Samples, comparison_hz: float) -> tuple[Samples, tuple[Fault, ...]]:
    """Set the torque of a joint to zero if it contains only noise while the joint moves.

    Args:
        samples: a log with uniform steps.
        comparison_hz: comparison band of the run, Hz.
    """
    silent = _drowned(samples, comparison_hz) & ~standing(samples, comparison_hz)
    return apply((SILENT,), samples, silent)


def standing(samples: Samples, comparison_hz: float) -> Bools:
    """Return which joints never move, (n,): their positions contain only noise."""
    band = _within(comparison_hz, samples.step)
    low = lowpass(samples.q, samples.step, band)
    noise = _noise(samples.q - low, samples.step, band)
    fixed = np.array([not moves(q) for q in samples.q.T], dtype=bool)
    quiet = np.std(low, axis=0) <= BEYOND * noise
    return np.asarray(quiet | fixed)


def _within(band: float, step: float) -> float:
    """Return a band in Hz, limited to the largest one that this sampling step allows."""
    return min(band, 0.5 * OPEN / step)


def _noise(high: FloatArray, step: float, band: float) -> FloatArray:
    """Return the standard deviation in a band, (k,), of white noise with `high` above the band."""
    share = 2 * band * step
    return white_noise(high, step, band) * math.sqrt(share)


def _speed(c: Channel) -> Symptom | None:
    """Find a measured speed that disagrees with dq/dt; masked samples are not compared."""
    samples, comparison_hz = c.log, c.about
    step, longest = samples.step, 0.25 / comparison_hz
    band = _within(_SLOPES * comparison_hz, step)
    at = np.ones(len(c.x), dtype=bool)
    if samples.mask is not None:  # without samples that the filter mixes with masked ones
        reach = math.ceil(1 / (band * step))
        at = ~touched(samples.mask.robot, reach)
    q, v, a = lowpass_and_slopes(c.q, step, band, 2)
    w = lowpass(c.x, step, band)
    difference = (w - v)[at]
    high = np.column_stack([c.q - q, c.x - w])
    of_q, of_w = BEYOND * _noise(high, step, band)
    if not c.moves or np.std(q) <= of_q or rms(difference) <= of_w or not v[at].any():
        return None
    columns = np.column_stack([v, a, np.ones(len(v))])
    A = columns[at]
    delay, inverse = 0.0, np.linalg.pinv(A)
    for _ in range(_PASSES):
        gain, bend, offset = inverse @ shifted(w, delay, step)[at]
        later = delay - bend / gain if gain else math.inf
        if abs(later) > longest:
            break
        delay = float(later)
    moved = shifted(w, delay, step)[at]
    residual = moved - A @ [gain, 0.0, offset]
    rest = float(np.mean(residual**2))
    change = A @ [gain - 1, -gain * delay, offset]
    error = float(rms(change))
    alike = 0.0
    if np.ptp(moved):
        alike = float(np.corrcoef(moved, v[at])[0, 1])
    before = float(np.mean(difference**2))
    explained = rest <= (1 - _EXPLAINED) * before
    matters = error > LEAST * float(rms(v[at]))
    if alike >= _CORRELATED and not (explained and matters):
        return None
    # Filtered rows are correlated: only one per period of the low-pass counts.
    variance = rest * max(longest / step, 1.0)
    squares = np.sum(A**2, axis=0)
    std = np.sqrt(variance / squares).tolist()
    found = float(gain - 1), delay, float(offset)
    values = dict(zip(("GV", "LV", "OV"), zip(found, std, strict=True), strict=True))
    numbers = {"gain": gain, "late": 1e3 * delay, "offset": offset, "alike": alike}
    return Symptom(len(v), v, numbers, values)


def _drowned(samples: Samples, comparison_hz: float) -> Bools:
    """Return which torques contain only noise, (n,); none if all do.

    The RMS of noise is uncertain by 1 / sqrt(4 B T) in a band B.
    """
    step, band = samples.step, _within(comparison_hz, samples.step)
    low = lowpass(samples.tau, step, band)
    noise = _noise(samples.tau - low, step, band)
    most = 1 + BEYOND / math.sqrt(4 * band * step * len(low))
    drowned = rms(low) <= most * noise
    return low.any(axis=0) & drowned & ~drowned.all()


def _silent(c: Channel) -> Symptom | None:
    """Find a torque that contains only noise while its joint moves."""
    silence = np.zeros(len(c.x))
    return Symptom(len(c.x), silence) if c.about[c.joint] else None


#: Its further data are the comparison band, Hz.
SPEED = Rule(
    "speed", ("qd",), _speed,
    "{gain} times dq/dt, {late} ms late, off by {offset}, correlation {alike}",
    "replaced by dq/dt", with_values,
)  # fmt: skip
#: Its further data are the torques that contain only noise.
SILENT = Rule(
    "silent", ("tau",), _silent, "noise throughout while the joint moves", "taken as zero",
    with_values,
)  # fmt: skip
