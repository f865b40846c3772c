"""How fast a motion is, and the cutoffs of filters that spare it."""

from __future__ import annotations

import numpy as np

from symgen.data.raw import Bools, FloatArray

#: Part of the velocity's energy that lies within the motion's bandwidth.
ENERGY = 0.999

#: Cutoff over bandwidth. The filter loses (1/5)**8 = 3e-6 of the motion at its upper edge.
MARGIN = 5.0

#: Highest cutoff that is chosen without being asked for, as a part of the Nyquist frequency.
HIGHEST = 0.8


def motion_bandwidth(q: FloatArray, step: float) -> float:
    """Choose the cutoff of a low-pass filter that spares the motion, in Hz.

    The bandwidth f of a joint holds 99.9 % of its velocity's energy above the noise floor; the
    cutoff is five times the largest f of the joints that move, after the practice of the field
    (Gautier and co-workers) of filtering well above the bandwidth.

    The spectrum is the cosine transform of
    the velocity, whose even continuation has no jump at the ends and so needs no window that would
    hide them; its kinks there only raise the result, for a log cut out of a motion to twice. Noise
    is taken as white in position, its power as the median over the upper half of the spectrum, and
    its part in the velocity as that times the gain
    (2 sin(pi f step) / step)**2 of the differences.

    Args:
        q: (N, n) or (N,) positions in rad (m), in uniform steps.
        step: sampling step in s.

    Returns:
        The cutoff in Hz, at most 0.8 of the Nyquist frequency, and that where nothing moves.
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
    # A constant velocity is motion too: it says which joints move, not how fast the filter must be.
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
    # A joint that is held still trembles at any frequency: below 1 % of the fastest one's RMS
    # velocity it has no say.
    largest = max(total for total, _ in found)
    bandwidth = max(edge for total, edge in found if total >= 1e-4 * largest)
    return min(MARGIN * bandwidth, highest)


def _energy_above_noise(power: FloatArray, gain: FloatArray, upper: Bools) -> FloatArray:
    """Return the part of each spectral line that stands clearly above the noise floor."""
    floors = power[upper] / gain[upper]
    if len(floors) == 0:
        return power
    bands = np.array_split(floors, min(8, len(floors)))
    noise = float(np.median([np.mean(band) for band in bands])) * gain
    energy = np.zeros_like(power)
    start = 0
    while start < len(power):
        # Single lines of noise scatter by their own size; means of eight or more do not reach 4.
        band = slice(start, max(start + 8, int(1.15 * start)))
        if np.mean(power[band]) > 4.0 * np.mean(noise[band]):
            energy[band] = np.maximum(power[band] - noise[band], 0.0)
        start = band.stop
    return energy
