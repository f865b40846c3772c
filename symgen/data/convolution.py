"""Convolutions of long signals with short weights: those of a low-pass, and of a spline's slope."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, lru_cache

import numpy as np
import numpy.typing as npt

from symgen.data.raw import FloatArray

#: Transforms of weights.
Spectrum = npt.NDArray[np.complex128]
#: Samples after which a sample has no part in the interpolating spline: 0.43**64.
CARDINAL = 64
_CIRCLE = 4096  # samples that are transformed at once, at least


def circle(samples: int, length: int) -> int:
    """Return the size of the transforms that convolve a signal with 2 length + 1 weights.

    One for a short signal; for a long one many that stay in a cache, with an overlap of a quarter.
    """
    from scipy.fft import next_fast_len

    size = max(_CIRCLE, 1 << (8 * length - 1).bit_length())
    return size if samples > size else int(next_fast_len(samples, real=True))


def convolved(
    x: FloatArray, gains: Sequence[Spectrum], length: int, size: int
) -> Iterator[FloatArray]:
    """Yield the samples of convolutions that `length` samples of x on either side reach.

    Circle by circle, of each of which the inner samples are right (overlap-save; Stockham 1966).

    Args:
        x: (N,).
        gains: transforms of the weights on a circle of `size` samples, as of `gain_of`.
        length: samples that weights reach to either side.
        size: of the circles.
    """
    count, apart = len(x) - 2 * length, size - 2 * length
    if len(x) <= size:
        whole = np.fft.rfft(x, size)
        for gain in gains:
            yield np.fft.irfft(whole * gain, size)[length : len(x) - length]
        return
    circles = -(-count // apart)
    filled = np.zeros(circles * apart + 2 * length)
    filled[: len(x)] = x
    transforms = np.fft.rfft(np.lib.stride_tricks.sliding_window_view(filled, size)[::apart])
    for gain in gains:
        found = np.fft.irfft(transforms * gain, size)[:, length : size - length]
        yield found.reshape(-1)[:count]


@lru_cache(maxsize=32)
def gain_of(step: float, cutoff: float, length: int, size: int) -> Spectrum:
    """Return the transform of the impulse response, of a circle of `size` samples."""
    return _transform(lowpass_weights(step, cutoff, length), size)


@lru_cache(maxsize=32)
def slope_gain(step: float, size: int) -> Spectrum:
    """Return the transform of the spline's slope, of a circle of `size` samples."""
    return _transform(cardinal_slope(), size) / step


def _transform(weights: FloatArray, size: int) -> Spectrum:
    circular = np.zeros(size)
    circular[: len(weights)] = weights
    return np.fft.rfft(np.roll(circular, -(len(weights) // 2)))


def lowpass_weights(step: float, cutoff: float, length: int) -> FloatArray:
    """Return the impulse response of `lowpass` at -length .. length steps, of sum 1.

    h(t) = sum over the poles w_k = 2 pi fc exp(i pi (2k + 1)/8), k = 0..3, of -i w_k/8 exp(i w_k t)
    is the inverse transform of 1 / (1 + (w / 2 pi fc)**8).
    """
    poles = 2 * np.pi * cutoff * step * np.exp(1j * np.pi * (2 * np.arange(4) + 1) / 8)
    k = np.arange(length + 1)
    half = np.real(np.exp(1j * np.outer(k, poles)) @ (-0.125j * poles))
    whole = np.concatenate([half[:0:-1], half])
    return np.asarray(whole / whole.sum())


@cache
def cardinal_slope() -> FloatArray:
    """Return what one sample adds to the slope of the spline at those around it."""
    impulse = np.zeros(4 * CARDINAL + 1)
    impulse[2 * CARDINAL] = 1.0
    return spline_slope(impulse)[CARDINAL : 3 * CARDINAL + 1]


def spline_slope(x: FloatArray) -> FloatArray:
    """Return the derivative of the interpolating spline by the number of the sample.

    Of degree five, or what few samples allow, with the knots of SciPy's `make_interp_spline`.
    """
    degree = max(k for k in (1, 3, 5) if k < max(len(x), 2))
    return np.tensordot(_slopes(len(x), degree), x, 1)


@lru_cache(maxsize=8)
def _slopes(count: int, degree: int) -> FloatArray:
    """Return what takes samples to the slopes of their spline, (count, count).

    The basis is that of Cox and de Boor; no knot lies at the samples next to the ends.
    """
    at, beside, outer = np.arange(count), (degree + 1) // 2, np.arange(degree + 1)
    knots = np.concatenate([outer - degree, at[beside:-beside], count - 1 + outer]).astype(float)
    inside = np.minimum(at, count - 1.5)[:, None]  # the last sample ends the interval before it
    basis = ((knots[:-1] <= inside) & (inside < knots[1:])).astype(float)
    lower, width = basis, knots
    for k in range(1, degree + 1):
        lower, width = basis, knots[k:] - knots[:-k]
        rising = (at[:, None] - knots[:-k]) / width
        basis = rising[:, :-1] * lower[:, :-1] + (1 - rising[:, 1:]) * lower[:, 1:]
    slope = -degree * np.diff(lower / width, axis=1)
    return np.asarray(np.linalg.solve(basis.T, slope.T).T)
