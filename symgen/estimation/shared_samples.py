"""Whether a log holds a piece of another one: noise does not come twice.

Torques above the band of the motion are correlated at every shift at once. Where the logs were
sampled at different rates, both are brought to four times the higher one first.
"""

from __future__ import annotations

import math

import numpy as np

from symgen.data.raw import FloatArray
from symgen.data.signals import Samples, lowpass

#: Seconds of noise that two logs share, and the correlation from which they do; seconds at the ends
#: of a log in which its filter swings in.
_SHORT, _SAME, _ENDS = 1.0, 0.99, 0.3
_QUIET = 0.01  # of the mean square of the noise: less says nothing
_NEAR = 0.01  # of the spread of positions in the span
_ABOVE = 10.0  # Hz: motion is below, noise above
_PART = 0.25  # of the rate: the cutoff where the rate is low
_OVER = 4  # times the rate, where rates differ
_RATES = 1e-3  # by which steps of one rate differ
_LONG = 1 << 18  # samples, above which every log is judged by its first part


def shared_span(known: Samples, asked: Samples) -> tuple[tuple[float, float], ...] | None:
    """Return when a log holds what another one holds: spans in s of `known` and `asked`; or None.

    A span counts where a second and more of high-passed torque correlates above 0.99, and positions
    are the same to a hundredth.
    """
    step = known.step
    a, b = (_noise(s) for s in (known, asked))
    if abs(asked.step / known.step - 1) > _RATES:
        step = min(known.step, asked.step) / _OVER
        a, b = _sampled(a, known.step, step), _sampled(b, asked.step, step)
    size = np.maximum(np.sqrt(np.mean(a**2, axis=0)), 1e-300)
    a, b = a / size, b / size
    width = round(_SHORT / step)
    if min(len(a), len(b)) <= width or not (np.any(a) and np.any(b)):
        return None
    at = _shift(a, b)
    first, last = max(at, 0), min(len(a), at + len(b))
    if last - first <= width:
        return None
    x, y = a[first:last], b[first - at : last - at]
    sums = [_moving(np.sum(z, axis=1), width) for z in (x * y, x * x, y * y)]
    loud = np.minimum(sums[1], sums[2]) > _QUIET * width * a.shape[1]
    alike = loud & (sums[0] > _SAME * np.sqrt(sums[1] * sums[2]))
    if not alike.any():
        return None
    where = np.flatnonzero(alike)
    begin, end = int(where[0]), int(where[-1]) + width
    spans = tuple(
        (
            float(s.t[0] + (begin + first - shift) * step),
            float(s.t[0] + (end + first - shift) * step),
        )
        for s, shift in ((known, 0), (asked, at))
    )
    return spans if _same_motion(known, asked, *spans) else None


def _same_motion(
    known: Samples, asked: Samples, there: tuple[float, float], here: tuple[float, float]
) -> bool:
    """Whether positions agree: without noise, the torques of other motion may look alike."""
    at = (asked.t >= here[0]) & (asked.t <= here[1])
    t = asked.t[at] - here[0] + there[0]
    q = asked.q[at]
    apart = [np.interp(t, known.t, a) - b for a, b in zip(known.q.T, q.T, strict=True)]
    return bool((np.std(apart, axis=1) < _NEAR * q.std(axis=0)).all())


def _noise(s: Samples) -> FloatArray:
    """Return the torques above the motion, (N, n)."""
    rate, tau = 1 / s.step, s.tau[:_LONG]
    out = tau - lowpass(tau, s.step, min(_ABOVE, _PART * rate))
    ends = math.ceil(_ENDS * rate)
    out[:ends] = out[-ends:] = 0.0
    return out


def _sampled(x: FloatArray, step: float, other: float) -> FloatArray:
    """Return a signal (N, n) at a smaller step, band-limited."""
    # Not by scipy.signal, whose import takes longer than all spectra of the logs.
    count = math.ceil(len(x) * step / other)
    return np.asarray(np.fft.irfft(np.fft.rfft(x, axis=0), count, axis=0) * (count / len(x)))


def _shift(a: FloatArray, b: FloatArray) -> int:
    """Return the sample of `a` at which `b` begins, where they are most alike."""
    from scipy.fft import next_fast_len

    size = next_fast_len(len(a) + len(b), real=True)
    A, B = (np.fft.rfft(x, size, axis=0) for x in (a, b))
    at = int(np.argmax(np.fft.irfft(np.sum(A * B.conj(), axis=1), size)))
    return at if at < len(a) else at - size


def _moving(x: FloatArray, width: int) -> FloatArray:
    """Return sums over `width` samples, (N - width + 1,)."""
    total = np.concatenate([[0.0], np.cumsum(x)])
    return np.asarray(total[width:] - total[:-width])
