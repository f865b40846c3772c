"""The noise floor: what is left of the torque in the band when the model is right.

Two sources, squared and added up joint by joint:

* torque noise, white: of density D it has D band in the band and D (Nyquist - band) above it, where
  the residual is read. A torque that was filtered before it was recorded has no noise there, and
  its noise in the band is unknown: the floor is NaN;
* noise of positions and speeds, which the model's torque carries on: its density is read above the
  band too, and a draw of it is put on top of the motion; reversals of friction are in this part.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from symgen.data.mask import Bools, rms
from symgen.data.signals import differentiate, lowpass, white_noise
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.system import torque_at
from symgen.estimation.torque_error import TorqueFit
from symgen.estimation.values import SEED, FloatArray
from symgen.runtime.evaluator import Evaluator

#: Gap of a joint over its noise, and over what matters, from which something is missing.
_LOUD, _VISIBLE = 3.0, 2.0
#: Largest noise density in one octave over the next one. Logs of six robots have 0.4 to 10, and
#: torques through a low-pass of second order 75 and more.
_STEEP = 30.0
_NOISE = 1e-4  # noise over its torque that every instrument exceeds


def noise_floor(
    log: FilteredLog,
    error: FloatArray,
    model: Callable[[FilteredLog], FloatArray],
    counts: Bools | None = None,
) -> FloatArray:
    """Return the standard deviation of the residual that noise alone leaves in the band, (n,).

    It is NaN for a torque that was filtered before it was recorded.

    Args:
        log: in the band of the run.
        error: (N, n) measured minus modelled torque, unfiltered.
        model: gives the modelled torque (N, n) of a log.
        counts: (K, n) kept rows that are asked about; None for all.
    """
    band, edge = log.rows.cutoff, passband(log)
    if band is None:
        return np.zeros(error.shape[1])
    above = edge or band  # below it the modelled torque has noise of its own
    high = error - lowpass(error, log.step, above)
    variance = white_noise(high, log.step, above, log.clear) ** 2 * band * 2 * log.step
    if edge is not None:
        carried = log.unmasked.compared(model(_shaken(log, edge)) - model(log))
        rows = np.ones(carried.shape, dtype=bool) if counts is None else counts
        variance += np.sum(rows * carried**2, axis=0) / np.maximum(rows.sum(axis=0), 1)
    variance[_filtered(log, band)] = np.nan
    return np.asarray(np.sqrt(variance))


def _filtered(log: FilteredLog, band: float) -> Bools:
    """Return which torques were filtered before they were recorded, (n,).

    In the two highest octaves, their noise is below that of any instrument, or falls steeply.
    """
    nyquist = 0.5 / log.step
    if nyquist / 4 < band:  # the motion reaches into these octaves
        return np.zeros(log.tau.shape[1], dtype=bool)
    half = lowpass(log.tau, log.step, nyquist / 2)
    quarter = lowpass(half, log.step, nyquist / 4)
    upper = white_noise(log.tau - half, log.step, nyquist / 2, log.clear)
    lower = white_noise(half - quarter, log.step, 3 * nyquist / 4, log.clear)
    quiet = np.minimum(upper, lower) < _NOISE * rms(log.tau)
    return np.asarray(quiet | (lower**2 > _STEEP * upper**2))


def noise_fit(evaluator: Evaluator, logs: Sequence[FilteredLog], X: FloatArray) -> TorqueFit:
    """Return what noise alone leaves of the torque of joints in motion, with that torque.

    Args:
        evaluator: the compiled model, with inverse_dynamics.
        logs: in the band of the run.
        X: parameters, (p,).
    """
    out = TorqueFit.none(evaluator.model.robot.n)

    def model(log: FilteredLog) -> FloatArray:
        return torque_at(evaluator, X, *(np.ascontiguousarray(x) for x in log.motion))

    for log in logs:
        counts = log.free if log.resting is None else log.free & ~log.resting
        noise = noise_floor(log, log.tau - model(log), model, counts=counts)
        size = np.sum(counts * log.measured**2, axis=0)
        out += TorqueFit(counts.sum(axis=0) * noise**2, size, (), np.zeros((2, len(size))))
    return out


def quiet(gap: Sequence[float], noise: Sequence[float], least: float) -> bool:
    """Whether no joint has a gap that is visible: above the noise, and twice what matters.

    Noise that is unknown, NaN, counts as none.
    """
    pairs = zip(gap, np.nan_to_num(noise), strict=True)
    return all(g <= max(_LOUD * f, _VISIBLE * least) for g, f in pairs)


def passband(log: FilteredLog) -> float | None:
    """Return the cutoff of the low-pass of positions and speeds, Hz; None where they pass none."""
    return log.band.cutoff_hz if log.band.filters(log.step) else None


def _shaken(log: FilteredLog, edge: float) -> FilteredLog:
    """Return the log with its own noise of the motion, white up to `edge`, once more."""
    draw, samples = np.random.default_rng(SEED), log.samples

    def noise(x: FloatArray, smooth: FloatArray) -> FloatArray:
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
