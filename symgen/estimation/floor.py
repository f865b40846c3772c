"""The noise floor: the torque error in the comparison band that the noise of the channels causes.

No residual enters, so that a model which explains little does not raise it. It can be above the
error, and is then an upper bound. It has two parts. Their squares are added up joint by joint:

* White torque noise. symgen reads its density in the recorded torque, far above the comparison
  band, and multiplies it by the width of the band. A torque that was filtered before recording has
  no noise there; the floor is then NaN.
* Noise of positions and speeds. symgen reads its density above the passband, adds a random draw to
  the motion, and takes the change of the modelled torque. Only inertia, weight and friction turn
  noise of the motion into torque, so this part takes the parameters of the declared model. It
  contains the reversals of friction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.data.mask import Bools, rms
from symgen.data.signals import differentiate, lowpass, noise_of_differences, white_noise
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.system import torque_along
from symgen.estimation.torque_error import TorqueFit, percent
from symgen.estimation.values import SEED, FloatArray
from symgen.policy import NOISES, VISIBLE
from symgen.runtime.evaluator import Evaluator

#: Largest ratio of the noise density in one octave to that in the next. It is 0.4 to 10 in logs of
#: six robots, and at least 75 in torques after a second-order low-pass.
_STEEP = 30.0
_NOISE = 1e-4  # noise over torque, below that of any instrument
#: Multiple of the comparison band above which the torque of a motion is below its noise, except for
#: a short time after each reversal. Products of three signals reach up to 1.5 times the band.
_ABOVE = 4.0


def _noise_floor(
    evaluator: Evaluator, X: FloatArray, log: FilteredLog, counts: Bools
) -> FloatArray:
    """Return the standard deviation (n,) of the residual in the band that noise alone causes.

    It is NaN for a torque that was filtered before it was recorded, and for a log that is sampled
    too slowly for a low-pass at the comparison band. Where a log has no octave above that band, the
    motion adds to the reading, which is then an upper bound.

    Args:
        evaluator, X: the declared model and its parameters.
        log: the log in the band of the run.
        counts: (K, n) kept rows to use.
    """
    band, edge = log.rows.cutoff, passband(log)
    if band is None:
        return np.full(counts.shape[1], np.nan)
    above = max(edge or band, min(_ABOVE * band, 0.25 / log.step))
    high = log.tau - lowpass(log.tau, log.step, above)
    variance = white_noise(high, log.step, above, log.clear) ** 2 * band * 2 * log.step
    shaken = torque_along(evaluator, X, _shaken(log, edge))
    change = log.unmasked.compared(shaken - torque_along(evaluator, X, log))
    variance += np.sum(counts * change**2, axis=0) / np.maximum(counts.sum(axis=0), 1)
    variance[_filtered(log, band)] = np.nan
    return np.asarray(np.sqrt(variance))


def _filtered(log: FilteredLog, band: float) -> Bools:
    """Return which torques were filtered before they were recorded, (n,).

    In the two highest octaves, their noise is below that of any instrument or falls steeply.
    """
    nyquist = 0.5 / log.step
    if nyquist / 4 < band:  # the motion has power in these octaves
        return np.zeros(log.tau.shape[1], dtype=bool)
    half = lowpass(log.tau, log.step, nyquist / 2)
    quarter = lowpass(half, log.step, nyquist / 4)
    upper = white_noise(log.tau - half, log.step, nyquist / 2, log.clear)
    lower = white_noise(half - quarter, log.step, 3 * nyquist / 4, log.clear)
    quiet = np.minimum(upper, lower) < _NOISE * rms(log.tau)
    return np.asarray(quiet | (lower**2 > _STEEP * upper**2))


def noise_fit(evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray) -> TorqueFit:
    """Return the noise floor of joints in motion, with the size of their torque.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: the logs in the band of the run.
        X: parameters, (p,).
    """
    out = TorqueFit.none(evaluator.model.robot)
    for log in logs:
        counts = log.free if log.resting is None else log.free & ~log.resting
        noise = _noise_floor(evaluator, X, log, counts)
        size = np.sum(counts * log.measured**2, axis=0)
        out += TorqueFit(counts.sum(axis=0) * noise**2, size, (), np.zeros((2, len(size))))
    return out


def quiet(gap: Sequence[float], noise: Sequence[float], matters: float) -> bool:
    """Return whether no joint has a visible gap: above three noise floors and twice `matters`."""
    return not above_noise(gap, noise, VISIBLE * matters).any()


def above_noise(gap: Sequence[float] | FloatArray, noise: Sequence[float], matters: float) -> Bools:
    """Return which gaps are above `matters` and three noise floors; an unknown floor is 0."""
    return np.asarray(gap) > np.maximum(NOISES * np.nan_to_num(noise), matters)


def noise_accounts(noise: float, error: float) -> str:
    """Return a sentence on a noise floor; one above the error is an upper bound."""
    if math.isnan(noise):
        return "the noise floor is unknown"
    return f"noise accounts for {'at most ' if noise > error else ''}{percent(noise)}"


def passband(log: FilteredLog) -> float | None:
    """Return the cutoff of the low-pass of positions and speeds, Hz; None without a filter."""
    return log.band.cutoff_hz if log.band.filters(log.step) else None


def _shaken(log: FilteredLog, edge: float | None) -> FilteredLog:
    """Return the log with another draw of the noise of its motion, white up to `edge`.

    Without a passband, the noise is white, and symgen reads it from differences of the samples.
    """
    draw, samples = np.random.default_rng(SEED), log.samples

    def noise(x: FloatArray, smooth: FloatArray) -> FloatArray:
        if edge is None:
            return draw.normal(size=x.shape) * noise_of_differences(x)
        drawn = draw.normal(size=x.shape) * white_noise(x - smooth, log.step, edge)
        return lowpass(drawn, log.step, edge)

    q = noise(samples.q, log.q)
    derived = log.band.velocity == "derived" or samples.velocity_derived
    qd = differentiate(q, log.step) if derived else noise(samples.qd, log.qd)
    base = log.base
    if samples.imu is not None:
        force, w = np.hsplit(noise(samples.imu, np.hstack(base[:2])), 2)
        shaken = force, w, differentiate(w, log.step)
        base = tuple(x + e for x, e in zip(base, shaken, strict=True))
    return replace(log, q=log.q + q, qd=log.qd + qd, base=base)
