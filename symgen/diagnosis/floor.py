"""The noise floor: what is left of the torque in the band when the model is right.

Three sources, squared and added up joint by joint:

* torque noise, white: of density D it has D band in the band and D (Nyquist - band) above it, where
  the residual is read;
* noise of positions and speeds, which the model's torque carries on: its density is read above the
  band too, and a draw of it is put on top of the motion; reversals of friction are in this part;
* with a repeat of the same motion, half the square of the difference of the two torques takes the
  place of both.

At rest, friction is anything up to what it is in motion: what is left there counts up to that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from symgen.data.signals import differentiate, lowpass, white_noise
from symgen.diagnosis.evidence import Scene

FloatArray = NDArray[np.float64]
_SEED = 1988
_SAME = 0.01  # RMS distance of two runs of one motion, of its RMS size


def noise_floor(
    s: Scene,
    error: FloatArray,
    model: Callable[[Scene], FloatArray],
    others: Sequence[Scene] = (),
) -> FloatArray:
    """Return the standard deviation of the residual that noise alone leaves in the band, (n,).

    Args:
        s: the log.
        error: (N, n) measured minus modelled torque, unfiltered.
        model: gives the modelled torque (N, n) of a log.
        others: logs among which a repeat of the motion is looked for.
    """
    if s.band is None:
        return np.zeros(error.shape[1])
    for other in others:
        if other is not s and repeats(s, other):
            difference = s.measured - other.measured
            return np.asarray(np.sqrt(np.mean(difference**2, axis=0) / 2))
    variance = _torque_noise(s, error) ** 2
    if s.noise is not None:
        carried = s.seen(model(_shaken(s, s.noise)) - model(s))
        variance = variance + np.mean(carried**2, axis=0)
    return np.asarray(np.sqrt(variance))


def at_rest(
    s: Scene,
    error: FloatArray,
    model: Callable[[FloatArray, FloatArray, FloatArray], FloatArray],
) -> FloatArray:
    """Return the RMS of what static friction may leave at rest, of all rows, (n,).

    Args:
        s: the log.
        error: (K, n) measured minus modelled torque in the band, at the kept instants.
        model: torque from q, qd, qdd, (k, n) each.
    """
    still, known = s.log.at_rest, s.log.band.rests
    if still is None or known is None:
        return np.zeros(error.shape[1])
    q = np.ascontiguousarray(s.q[s.kept])
    slow, none = np.tile(np.abs(known.slow), (len(q), 1)), np.zeros_like(q)
    friction = np.abs(model(q, slow, none) - model(q, -slow, none)) / 2
    worse = still[s.kept] & (np.array(known.weight) < 1)  # than joints in motion
    left = np.where(worse, np.minimum(np.abs(error), friction), 0.0)
    return np.asarray(np.sqrt(np.mean(left**2, axis=0)))


def _torque_noise(s: Scene, error: FloatArray) -> FloatArray:
    """Return the standard deviation of torque noise in the band, (n,), from that above it."""
    if s.band is None:
        return np.zeros(error.shape[1])
    edge = s.wide or s.band  # below it the modelled torque has noise of its own
    white = white_noise(error - lowpass(error, s.step, edge), s.step, edge, s.free)
    return np.asarray(white * np.sqrt(s.band * 2 * s.step))


def repeats(s: Scene, other: Scene) -> bool:
    """Whether two logs are runs of one motion, sample by sample."""
    if s.q.shape != other.q.shape or s.step != other.step or s.kept != other.kept:
        return False
    size = np.sqrt(np.mean((s.q - s.q.mean(axis=0)) ** 2, axis=0))
    apart = np.sqrt(np.mean((s.q - other.q) ** 2, axis=0))
    return bool((apart <= _SAME * size).all())


def _shaken(s: Scene, noise: tuple[FloatArray, FloatArray | None]) -> Scene:
    """Return the log with its own noise of positions and speeds once more."""
    draw = np.random.default_rng(_SEED)
    edge = s.wide or s.band or 0.0
    of_q, of_qd = noise
    q = lowpass(draw.normal(size=s.q.shape) * of_q, s.step, edge)
    if of_qd is None:
        qd = differentiate(q, s.step)
    else:
        qd = lowpass(draw.normal(size=s.q.shape) * of_qd, s.step, edge)
    return s.along(s.q + q, s.qd + qd)
