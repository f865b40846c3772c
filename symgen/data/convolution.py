"""Convolution of long signals with short weights: a low-pass filter, and a spline derivative.

`scipy.signal.oaconvolve` gives the same at the same speed, and its import takes 0.4 s. The spline
of all samples, by SciPy, takes four times as long as these weights.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, lru_cache

import numpy as np
import numpy.typing as npt

from symgen.data.raw import FloatArray

#: Fourier transforms of weights.
Spectrum = npt.NDArray[np.complex128]
#: Range of a sample in the interpolating spline: 0.43**64 is below rounding.
CARDINAL = 64
_CIRCLE = 4096  # smallest number of samples in one transform


def circle(samples: int, length: int) -> int:
    """Return the transform size for the convolution of a signal with 2 length + 1 weights.

    A short signal takes one transform. A long one takes many that fit into a cache, with a quarter
    of overlap.
    """
    from scipy.fft import next_fast_len

    size = max(_CIRCLE, 1 << (8 * length - 1).bit_length())
    return size if samples > size else int(next_fast_len(samples, real=True))


def convolved(
    x: FloatArray, gains: Sequence[Spectrum], length: int, size: int
) -> Iterator[FloatArray]:
    """Yield the valid samples of convolutions, by overlap-save (Stockham 1966).

    A sample is valid if x has `length` samples on both sides of it.

    Args:
        x: (N,).
        gains: transforms of the weights, of `size` samples, from `gain_of`.
        length: number of weights on each side.
        size: size of the transforms.
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
    """Return the transform of the impulse response of `lowpass`, of `size` samples."""
    return _transform(lowpass_weights(step, cutoff, length), size)


@lru_cache(maxsize=32)
def slope_gain(step: float, size: int) -> Spectrum:
    """Return the transform of the spline derivative, of `size` samples."""
    return _transform(cardinal_slope(), size) / step


def _transform(weights: FloatArray, size: int) -> Spectrum:
    circular = np.zeros(size)
    circular[: len(weights)] = weights
    return np.fft.rfft(np.roll(circular, -(len(weights) // 2)))


def lowpass_weights(step: float, cutoff: float, length: int) -> FloatArray:
    """Return the impulse response of `lowpass` at -length .. length steps; its sum is 1.

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
    """Return the contribution of one sample to the spline derivative at its neighbours."""
    impulse = np.zeros(4 * CARDINAL + 1)
    impulse[2 * CARDINAL] = 1.0
    return spline_slope(impulse)[CARDINAL : 3 * CARDINAL + 1]


def spline_slope(x: FloatArray) -> FloatArray:
    """Return the derivative of the interpolating spline with respect to the sample number.

    The degree is five, or less for few samples.
    """
    from scipy.interpolate import make_interp_spline

    degree = max(k for k in (1, 3, 5) if k < max(len(x), 2))
    at = np.arange(len(x))
    return np.asarray(make_interp_spline(at, x, degree).derivative()(at))
