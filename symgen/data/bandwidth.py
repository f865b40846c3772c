"""Bandwidth of a motion, and a filter cutoff above it."""

from __future__ import annotations

import numpy as np

from symgen.data.raw import Bools, FloatArray

#: Share of the velocity's energy within the bandwidth of the motion.
ENERGY = 0.999

#: Cutoff over bandwidth. The filter loses (1/5)**8 = 3e-6 of the motion at its upper edge.
MARGIN = 5.0

#: Highest default cutoff, as a share of the Nyquist frequency.
HIGHEST = 0.8


def motion_bandwidth(q: FloatArray, step: float) -> float:
    """Choose the cutoff of a low-pass filter that does not distort the motion, in Hz.

    The bandwidth f of a joint contains 99.9 % of the energy of its velocity above the noise floor.
    The cutoff is five times the largest f of the moving joints: the usual practice is to filter
    well above the bandwidth (Gautier and co-workers).

    The spectrum is the cosine transform of the velocity. Its even continuation has no jump at the
    ends, so it needs no window. Kinks at the ends can at most double the result, for a log cut out
    of a motion. Noise is assumed white in position. Its power is the median over the upper half of
    the spectrum, and its share of the velocity is that times the gain (2 sin(pi f step) / step)**2
    of the differences.

    Args:
        q: (N, n) or (N,) positions in rad (m), at uniform time steps.
        step: sampling step in s.

    Returns:
        The cutoff in Hz, at most 0.8 of the Nyquist frequency; exactly that if nothing moves.
    """
    from scipy.fft import dct

    highest = HIGHEST * 0.5 / step
    velocity = np.diff(q.reshape(len(q), -1), axis=0) / step
    count = len(velocity)
    if count < 2:
        return highest
    frequency = np.arange(1, count) / (2 * count * step)
    gain = (2.0 * np.sin(np.pi * frequency * step) / step) ** 2
    power = dct(velocity, type=2, norm="ortho", axis=0)[1:] ** 2
    # Constant velocity counts as motion when deciding which joints move, not in the spectrum.
    constant = count * np.mean(velocity, axis=0) ** 2
    found = []
    for column, steady in zip(power.T, constant, strict=True):
        energy = _energy_above_noise(column, gain, frequency > 0.25 / step)
        total = float(np.sum(energy))
        if total > 0.0:
            edge = int(np.searchsorted(np.cumsum(energy), ENERGY * total))
            found.append((total + float(steady), float(frequency[min(edge, count - 2)])))
    if not found:
        return highest
    # A stationary joint trembles at any frequency: ignore joints below 1 % of the fastest RMS
    # velocity.
    largest = max(total for total, _ in found)
    bandwidth = max(edge for total, edge in found if total >= 1e-4 * largest)
    return min(MARGIN * bandwidth, highest)


def _energy_above_noise(power: FloatArray, gain: FloatArray, upper: Bools) -> FloatArray:
    """Return the part of each spectral line that is clearly above the noise floor."""
    floors = power[upper] / gain[upper]
    if len(floors) == 0:
        return power
    bands = np.array_split(floors, min(8, len(floors)))
    noise = float(np.median([np.mean(band) for band in bands])) * gain
    energy = np.zeros_like(power)
    start = 0
    while start < len(power):
        # A single noise line scatters as much as its size; the mean of eight or more stays below 4.
        band = slice(start, max(start + 8, int(1.15 * start)))
        if np.mean(power[band]) > 4.0 * np.mean(noise[band]):
            energy[band] = np.maximum(power[band] - noise[band], 0.0)
        start = band.stop
    return energy
