"""Convert a log to samples with uniform time steps and velocities; filters and derivatives.

All filters have zero phase: a delay of q against tau would bias the parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np

from symgen.data.gaps import holes
from symgen.data.log import Log, rows
from symgen.data.mask import Bools, Mask, on_grid, rms, touched
from symgen.data.raw import Additions, FloatArray, read_only, refuse
from symgen.errors import LogError

#: Logs whose time steps vary by more than this share of the median are resampled.
STEP_TOLERANCE = 0.01

#: Share of the power of a joint's speed that lies below half the comparison band.
POWER = 0.99
#: Hz: limits of the comparison band. Friction steps at reversals need the upper part.
LOWEST, HIGHEST = 2.0, 10.0
#: Above this share of the sampling rate, a cutoff does not filter.
OPEN = 0.45
_SPECTRUM_HZ = 50.0  # Hz: highest frequency of the speeds in the spectrum
_GRID = np.linspace(0.0, _SPECTRUM_HZ, 2001)
#: Cutoff of missing speeds over the comparison band: the filter loses (1/10)**8 of the motion.
MARGIN = 5.0
#: Periods of the cutoff after which the impulse response of `lowpass` is below 1e-10 of its peak.
TAIL = 9.6

#: Channels of a base that moves.
_OF_BASE = ("pose", "forces", "touches", "up")
_SLOW = 10.0  # Hz
_LOST = 3.0  # steps that jitter or a lost row may take, for every motion
_BRIDGED = 0.025  # s: a quarter of a period of the highest comparison band
_MISSING = 0.3  # share of steps that may differ from the clock

NORMAL = 1.4826  # standard deviation over median absolute value of normal noise


@dataclass(frozen=True, eq=False)
class Samples(Additions):
    """A log that is ready for identification. All arrays are read-only float64.

    Attributes:
        name: name of the log.
        t: (N,) time in s, with uniform steps.
        q: (N, n) joint positions in rad (m).
        qd: (N, n) joint velocities in rad/s (m/s).
        tau: (N, n) joint torques in N m (forces in N), never filtered.
        step: sampling step in s.
        cutoff_hz: cutoff in Hz of the zero-phase filter for q and qd; None if qd was measured or q
            needed no filter.
        notes: changes to the log, one line each.
        velocity_derived: whether qd is the derivative of q because it was missing.
        mask: the masked samples, or None.
        piece: whether it is a representative piece of a longer log.
        reference: (N, n) reference of the controller in rad (m), or None.
    """

    name: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray
    tau: FloatArray
    step: float
    cutoff_hz: float | None
    notes: tuple[str, ...]
    velocity_derived: bool = False
    mask: Mask | None = None
    piece: bool = False
    reference: FloatArray | None = None

    @property
    def length(self) -> float:
        """Time between the first and the last sample, s."""
        return float(self.t[-1] - self.t[0])

    def cut(self, span: slice) -> Samples:
        """Return some of the samples."""
        mask = self.mask and rows(self.mask, span)
        return replace(rows(self, span), mask=mask)

    def masked(self, joint: Bools, robot: Bools) -> Samples:
        """Return the samples with a further mask, see `Mask`."""
        if self.mask is not None:
            joint = joint | self.mask.joint
            robot = robot | self.mask.robot
        return replace(self, mask=Mask(joint, robot))


def prepare(log: Log) -> Samples:
    """Give a log uniform time steps and a velocity.

    If the time steps vary by more than 1 %, a cubic spline resamples the log. Measured velocities
    stay unchanged. Missing velocities are the derivative of q after a zero-phase low-pass filter at
    five times the comparison band of the motion. q is then filtered too, so that both describe the
    same motion. No filter is used if the sampling rate is too low for it.

    Raises:
        LogError: gaps in time that are longer than the log, or currents instead of torques.
    """
    s = sampled(log)
    if not s.velocity_derived:
        return s
    cutoff = MARGIN * comparison_band([s])
    filtered = None
    if can_filter(cutoff, s.step):
        filtered = cutoff
        q, qd = lowpass_and_slopes(s.q, s.step, cutoff, 1)
        how = f"both through a zero-phase low-pass filter at {cutoff:.4g} Hz"
    else:
        q, qd = s.q, differentiate(s.q, s.step)
        how = f"unfiltered, as the Nyquist frequency is {0.5 / s.step:.4g} Hz"
    notes = (*s.notes[:-1], f"{log.name}: qd is missing and was derived from q, {how}")
    return replace(s, q=read_only(q), qd=read_only(qd), cutoff_hz=filtered, notes=notes)


def comparison_band(logs: Sequence[Samples]) -> float:
    """Return the band in which torques are compared, Hz.

    It is twice the lowest frequency with 99 % of the power of a joint's speed below it. The joint
    with the largest value over all logs counts, within 2 to 10 Hz. Speeds are central differences
    of positions below 50 Hz. The turning of a floating base counts like a joint. A piece of a
    longer log, or a log of such a base, begins and ends during motion, which would widen its
    spectrum. A Hann window therefore fades its speeds in and out (Welch 1967).
    """
    highest = LOWEST
    paths = [_paths(s) for s in logs]
    for j in range(paths[0].shape[1]):
        each = zip(logs, paths, strict=True)
        power = sum((_power(s, q[:, j]) for s, q in each), np.zeros(len(_GRID)))
        if power[-1] > 0:
            edge = _GRID[np.searchsorted(power, POWER * power[-1])]
            highest = max(highest, 2 * float(edge))
    return min(highest, HIGHEST)


def _floats(s: Samples) -> bool:
    return s.robot is not None and s.robot.floating


def _paths(s: Samples) -> FloatArray:
    """Return positions of joints and, of a floating base, angles that turn like it, (N, k)."""
    if not _floats(s):
        return s.q
    if s.imu is None:
        return s.q if s.pose is None else np.hstack([s.q, 2 * s.pose[:, 4:]])
    return np.hstack([s.q, s.step * np.cumsum(s.imu[:, 3:], axis=0)])


def _power(s: Samples, q: FloatArray) -> FloatArray:
    """Return the power of the speed of positions q (N,) below each frequency of the grid."""
    q = smoothed(q, s.step, _SPECTRUM_HZ)
    speed = np.gradient(q, s.step)
    speed = speed - speed.mean()
    if s.piece or _floats(s):
        fade = np.hanning(len(speed))
        middle = fade @ speed / fade.sum()
        speed = (speed - middle) * fade / rms(fade)
    size = np.abs(np.fft.rfft(speed))
    lines = size**2 * s.step / len(speed)
    frequency = np.fft.rfftfreq(len(speed), s.step)
    return np.interp(_GRID, frequency, np.cumsum(lines))


def smoothed(x: FloatArray, step: float, cutoff: float) -> FloatArray:
    """Return a signal through `lowpass`, or the signal itself if its rate is too low for it."""
    return lowpass(x, step, cutoff) if can_filter(cutoff, step) else x


def sampled(log: Log, clock: tuple[float, float] | None = None) -> Samples:
    """Give a log uniform time steps, without a filter (the filters of a run come later).

    Gaps in time are masked, so that windows and filters do not cross them. If speeds were not
    measured, `qd` is the derivative of positions below 10 Hz. This is enough to distinguish rest
    from motion. Equations compute their derivatives separately.

    Args:
        log: the measured log.
        clock: first time and step, s, of the longer log of which this log is a segment. A resampled
            segment uses the ticks of this clock.

    Raises:
        LogError: gaps in time that are longer than the log, or currents instead of torques.
    """
    if log.tau is None:
        raise LogError(
            f"{log.name}: has currents and no torques; accepted: a log mapped by the torque "
            "constants in [drive] of the robot file"
        )
    steps = np.diff(log.t)
    median = float(np.median(steps))
    notes = list(log.notes)
    mask = None
    log, inserted = _bridged(log, median)
    if inserted.any():
        joints = np.repeat(inserted[:, None], log.q.shape[1], axis=1)
        mask = Mask(joints, inserted)
        first = log.t[int(np.argmax(inserted))]
        lost = median * inserted.sum()
        notes.append(f"{log.name}: gaps in time: {lost:.3g} s from t = {first:.6g} s on are masked")
    t = log.t
    deviation = np.abs(np.diff(t) - median)
    off = deviation > STEP_TOLERANCE * median
    count, duration = len(t), float(t[-1] - t[0])
    if off.any() and off.mean() < _MISSING:  # a regular clock with missing rows
        count = round(duration / median) + 1
    step = duration / (count - 1) if clock is None else clock[1]
    if off.any():
        grid = np.linspace(t[0], t[-1], count) if clock is None else _ticks(t, *clock)
        if mask is not None:
            mask = Mask(on_grid(mask.joint, t, grid), on_grid(mask.robot, t, grid))
        log = _resampled(log, grid, smooth=True)
        notes.append(
            f"{log.name}: steps between {steps.min():.4g} s and {steps.max():.4g} s were resampled "
            f"to {step:.4g} s by a cubic spline"
        )
    qd = log.qd
    if qd is None:
        qd = read_only(differentiate(smoothed(log.q, step, _SLOW), step))
        notes.append(f"{log.name}: qd is missing and is derived from q")
    assert log.tau is not None
    additions = {f.name: getattr(log, f.name) for f in fields(Additions)}
    return Samples(
        log.name, log.t, log.q, qd, log.tau, step, None, tuple(notes), log.qd is None, mask,
        reference=log.qr, **additions,
    )  # fmt: skip


def _ticks(t: FloatArray, start: float, step: float) -> FloatArray:
    """Return the ticks of a clock within times t (N,)."""
    first, last = (t[[0, -1]] - start) / step
    begin, end = math.ceil(first - 1e-6), math.floor(last + 1e-6)
    ticks = start + step * np.arange(begin, end + 1)
    return np.clip(ticks, t[0], t[-1])


def _bridged(log: Log, step: float) -> tuple[Log, Bools]:
    """Insert rows into gaps that are too long to interpolate the motion.

    A spline follows a motion over at most a quarter of its shortest period.

    Returns:
        The log, and its inserted rows (N,).

    Raises:
        LogError: the gaps are longer than the log.
    """
    t = log.t
    missing = np.round(np.diff(t) / step).astype(int) - 1
    if missing.max() < _LOST:
        return log, np.zeros(len(t), dtype=bool)
    if missing.sum() > len(t):
        k = int(np.argmax(missing))
        until, since = f"{t[k]:.9g}", f"{t[k + 1]:.9g}"
        what = f"{log.name}: no samples between t = {until} s and t = {since} s"
        refuse(what, f"gaps shorter than the log, as with --until {until} or --from {since}")
    longest = max(_LOST * step, _BRIDGED)
    inserted = []
    for k in holes(t, step, longest):
        count = int(missing[k]) + 2
        inside = np.linspace(t[k], t[k + 1], count)
        inserted.append(inside[1:-1])
    times = np.sort(np.concatenate([t, *inserted]))
    lost = touched(~np.isin(times, t), round(longest / step))  # filters reach that far
    return _resampled(log, times, smooth=False), lost


def _resampled(log: Log, times: FloatArray, *, smooth: bool) -> Log:
    """Interpolate a log by cubic splines, or without overshoot; columns with NaN are NaN."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    curve = CubicSpline if smooth else PchipInterpolator
    arrays: dict[str, Any] = {"t": read_only(times)}
    for key in ("q", "qd", "tau", "command", "qs", "imu", "wrench", "qr", "duty", *_OF_BASE):
        x = getattr(log, key)
        if x is not None:
            known = np.isfinite(x).all(axis=0)
            out = np.full((len(times), x.shape[1]), np.nan)
            out[:, known] = curve(log.t, x[:, known])(times)
            arrays[key] = read_only(out)
    return replace(log, **arrays)


def interpolated(t: FloatArray, x: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Return the not-a-knot cubic spline through samples x (N, ...) at times t (N,), s.

    Returns:
        A function from times (T,) to values (T, ...), in the unit of x.
    """
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(t, x)
    return lambda at: np.asarray(spline(at), dtype=np.float64)


def lowpass(x: FloatArray, step: float, cutoff: float) -> FloatArray:
    """Apply a fourth-order Butterworth low-pass forwards and backwards: zero phase.

        gain = 1 / (1 + (f / cutoff)**8)

    The gain is one half at the cutoff. The weights sample the continuous impulse response, so the
    filter does not depend on the sampling rate; they end after TAIL periods. At both ends, the
    signal is continued by x(-s) = 2 x0 - x(s) + a0 s**2, with x0 and a0 from a local cubic. Unlike
    the odd continuation, this keeps the acceleration at the ends of a log.

    Args:
        x: (N,) or (N, k) signal with uniform steps.
        step: sampling step in s.
        cutoff: cutoff in Hz.

    Returns:
        The filtered signal, with the shape of x.

    Raises:
        LogError: the cutoff is not between 0 and the Nyquist frequency.
    """
    return lowpass_and_slopes(x, step, cutoff, 0)[0]


def lowpass_and_slopes(x: FloatArray, step: float, cutoff: float, slopes: int) -> list[FloatArray]:
    """Apply `lowpass` to a signal, and differentiate the result up to twice.

    Each derivative is the convolution with that of the impulse response. All results share one
    Fourier transform of the signal.

    Args:
        x, step, cutoff: as for `lowpass`.
        slopes: number of derivatives, 0 to 2.

    Returns:
        The filtered signal and its derivatives, each with the shape of x.

    Raises:
        LogError: the cutoff is not between 0 and the Nyquist frequency.
    """
    from scipy.fft import irfft, next_fast_len, rfft

    require_cutoff("low-pass filter", cutoff, step)
    samples = len(x)
    tail_length = math.ceil(TAIL / (cutoff * step))
    length = min(samples - 1, tail_length)
    flat = x.reshape(samples, -1)
    window = end_window(step, cutoff)
    head = continuation(flat, length, window)
    tail = continuation(flat[::-1], length, window)
    padded = np.concatenate([head, flat, tail[::-1]])
    size = int(next_fast_len(len(padded), real=True))
    gains = [rfft(response(step, cutoff, length, k), size) for k in range(slopes + 1)]
    outputs = [np.empty(flat.shape, order="F") for _ in gains]  # contiguous channels
    inside = slice(2 * length, 2 * length + samples)
    for channel in range(flat.shape[1]):
        transform = rfft(padded[:, channel], size)
        for out, gain in zip(outputs, gains, strict=True):
            out[:, channel] = irfft(transform * gain, size)[inside]
    return [out.reshape(x.shape) for out in outputs]


@lru_cache(maxsize=64)
def response(step: float, cutoff: float, length: int, slope: int = 0) -> FloatArray:
    """Return a derivative of the impulse response of `lowpass` at -length .. length steps.

        h(t) = sum over k = 0..3 of Re(-i w_k/8 exp(i w_k |t|)),
        w_k = 2 pi cutoff exp(i pi (2k + 1)/8)

    It is the inverse transform of 1 / (1 + (w / 2 pi cutoff)**8). Weights of the derivative `slope`
    are exact for polynomials up to that degree.

    Args:
        step: sampling step in s.
        cutoff: cutoff in Hz.
        length: number of weights on either side.
        slope: order of the derivative, 0 to 2.
    """
    odd = 2 * np.arange(4) + 1
    angles = 1j * np.pi * odd / 8
    poles = 2 * np.pi * cutoff * np.exp(angles)
    times = np.arange(length + 1)
    waves = np.exp(1j * step * np.outer(times, poles))
    amplitudes = -0.125j * poles * (1j * poles) ** slope
    half = np.real(waves @ amplitudes)
    mirrored = (-1) ** slope * half[:0:-1]
    weights = np.concatenate([mirrored, half])
    if slope:
        weights -= weights.sum() * response(step, cutoff, length)
    before = -step * np.arange(-length, length + 1)
    moment = before**slope @ weights
    return np.asarray(weights * math.factorial(slope) / moment)


def end_window(step: float, cutoff: float) -> int:
    """Return the number of end samples for the local cubic of `continuation`."""
    # Chosen on sines at a fifth of the cutoff: shorter windows pass noise, longer ones distort.
    return max(6, math.ceil(0.6 / (cutoff * step)))


def continuation(x: FloatArray, length: int, window: int) -> FloatArray:
    """Return `length` samples before a signal (N, k), in order of time.

    Args:
        x: the signal.
        length: fewer than N.
        window: number of samples for the local cubic at the first sample.
    """
    window = min(window, len(x))
    start, curvature = end_of_cubic(window) @ x[:window]
    back = np.arange(length, 0, -1, dtype=np.float64)[:, None]
    mirrored = 2.0 * start - x[length:0:-1]
    return np.asarray(mirrored + curvature * back**2)


@lru_cache(maxsize=32)
def end_of_cubic(window: int) -> FloatArray:
    """Return the matrix from samples to the value and second derivative of their cubic at the first
    one.
    """
    powers = min(3, window - 1) + 1
    s = np.arange(window) / window
    fit = np.linalg.pinv(np.vander(s, powers, increasing=True))
    curvature = np.zeros(window)
    if powers > 2:
        curvature = 2.0 * fit[2] / window**2
    return np.stack([fit[0], curvature])


def can_filter(cutoff: float, step: float) -> bool:
    """Return whether a cutoff in Hz is far enough below the Nyquist frequency for a low-pass."""
    return cutoff < OPEN / step


def noise_of_differences(x: FloatArray) -> FloatArray:
    """Return the standard deviation of white noise on each channel of a smooth signal (N, ...).

    It uses the median of absolute sixth differences, which motion and single jumps hardly affect.
    """
    size = np.median(np.abs(np.diff(x, 6, axis=0)), axis=0)
    gain = math.sqrt(math.comb(12, 6))
    return NORMAL * size / gain


def white_noise(
    high: FloatArray, step: float, band: float, free: Bools | None = None
) -> FloatArray:
    """Return the standard deviation of white noise from its part above a band.

    White noise with variance v has v band / Nyquist in the band and the rest above it.

    Args:
        high: (N, k) signal above the band; the ends, where filters settle, are not used.
        step: sampling step in s.
        band: cutoff of the filter that removed the band, Hz, below the Nyquist frequency.
        free: (N, k) samples to use; None for all.

    Returns:
        (k,), in the unit of `high`. It comes from the median absolute value, which friction steps
        at reversals do not affect; or from the RMS if the signal is constant most of the time.
    """
    used = np.ones(high.shape, dtype=bool)
    if free is not None:
        used &= free
    margin = int(1 / (band * step))
    if margin and len(high) > 4 * margin:
        used[:margin] = False
        used[-margin:] = False
    columns = zip(high.T, used.T, strict=True)
    size = [_typical(x[at]) for x, at in columns]
    nyquist = 0.5 / step
    return np.asarray(size) * math.sqrt(nyquist / (nyquist - band))


def _typical(x: FloatArray) -> float:
    if len(x) == 0:
        return 0.0
    usual = float(np.median(np.abs(x)))
    return NORMAL * usual or float(rms(x))


def differentiate(x: FloatArray, step: float) -> FloatArray:
    """Return dx/dt, the derivative of the interpolating spline of degree five, with zero phase.

    The degree is lower for few samples. It is exact for polynomials up to its degree. For a sine,
    the error at inner samples is of sixth order in the step.

    Args:
        x: (N,) or (N, k) signal with uniform steps, N at least 2.
        step: sampling step in s.

    Returns:
        The derivative, with the shape of x, in the unit of x per second.
    """
    from scipy.interpolate import make_interp_spline

    if not x.size:
        return x
    degree = max(k for k in (1, 3, 5) if k < max(len(x), 2))
    at = np.arange(len(x))
    return np.asarray(make_interp_spline(at, x, degree).derivative()(at) / step)


def require_cutoff(where: str, cutoff: float, step: float, duration: float = math.inf) -> None:
    """Raise LogError if a cutoff is not between 0 and the Nyquist frequency."""
    nyquist, lowest = 0.5 / step, 0.01 / duration
    if not lowest < cutoff < nyquist:
        raise LogError(
            f"{where}: the cutoff is {cutoff:.4g} Hz; accepted: above {lowest:.4g} Hz (a hundredth "
            f"of a period over the log) and below the Nyquist frequency of {nyquist:.4g} Hz"
        )
