"""Figures of an identification: measured and modelled quantities, and spectra of the residual."""

from __future__ import annotations

import numpy as np

from symgen.data.raw import FloatArray
from symgen.estimation.values import Residual, Trace
from symgen.identification.estimate import Estimate, equation_titles
from symgen.report.plots.figure import POINTS, Figure, Panel, joint_panels

_UNITS = {"energy": "J"}
_PER_JOINT = {"torque": "", "momentum": " s"}  # suffix of the torque unit
_SHORTEST = 16  # minimum number of rows of a trace with a spectrum
_WINDOWS = 6  # minimum number of windows of a spectrum
_WINDOW = 64  # minimum number of rows of a window


def measured_and_predicted(estimate: Estimate, quantity: str) -> Figure | None:
    """Draw the measured and the modelled quantity and their difference for each log.

    `quantity` is "energy", "momentum" or "torque". The result is None without such a trace.
    """
    panels = []
    for t in traces_of(estimate, quantity):
        series = {} if t.raw is None else {"unfiltered": t.raw}
        series |= {"measured": t.measured, "predicted": t.predicted, "residual": t.residual}
        panels += joint_panels(components(estimate, quantity), t.t, series, (t.log, t.kind))
    xlabel = "number of the pose" if estimate.model == "static" else "time, s"
    return Figure(tuple(panels), xlabel) if panels else None


def residual_spectrum(estimate: Estimate, quantity: str) -> Figure | None:
    """Draw the amplitude spectral density of the residual of each log, by Welch's method.

    A good fit has a flat line below the cutoff. A peak is a motion or vibration that the model
    lacks. The result is None if no trace is long enough (16 rows).
    """
    panels = []
    for t in traces_of(estimate, quantity):
        if len(t.t) < _SHORTEST:
            continue
        f, density = amplitude_density(t.t, t.residual)
        named = components(estimate, quantity)
        for title, column in zip(named, density.T, strict=False):
            series = {"density of the residual": column}
            if estimate.cutoff_hz:
                ends = [column.min(), column.max()]
                name = f"filter cutoff, {estimate.cutoff_hz:.4g} Hz"
                series[name] = np.array([[estimate.cutoff_hz] * 2, ends])
            panels.append(Panel(f"{title}/√Hz", f, series, (t.log, t.kind), logarithmic=True))
    return Figure(tuple(panels), "frequency, Hz") if panels else None


def amplitude_density(t: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the one-sided amplitude spectral density of the longest part without a gap.

    The method is that of Welch (1967): Hann windows that overlap by half, with their mean removed.
    The result does not contain frequency 0.

    Args:
        t: time, s, (K,).
        values: (K, m).

    Returns:
        Frequencies in Hz (F,), and densities in unit/sqrt(Hz), (F, m).
    """
    step = float(np.median(np.diff(t)))
    pieces = np.split(np.arange(len(t)), np.flatnonzero(np.diff(t) > 5 * step) + 1)
    piece = max(pieces, key=len)
    grid = t[piece[0]] + step * np.arange(len(piece))
    even = np.stack([np.interp(grid, t[piece], column[piece]) for column in values.T])
    length = min(len(piece), max(_WINDOW, min(2 * POINTS, len(piece) // _WINDOWS)))
    # Welch's mean of periodograms. Importing scipy.signal would take longer than writing a page.
    windows = np.lib.stride_tricks.sliding_window_view(even, length, axis=1)
    windows = windows[:, :: length - length // 2]
    hann = np.hanning(length + 1)[:-1]
    lines = np.fft.rfft(hann * (windows - windows.mean(axis=2, keepdims=True)), axis=2)
    power = 2 * step / np.sum(hann**2) * np.mean(np.abs(lines) ** 2, axis=1)
    power[:, -1] /= 2 - length % 2  # the Nyquist frequency has no negative counterpart
    density: FloatArray = np.sqrt(power[:, 1:]).T
    frequencies = np.asarray(np.fft.rfftfreq(length, step)[1:], dtype=np.float64)
    return frequencies, density


def traces_of(estimate: Estimate, quantity: str) -> tuple[Trace, ...]:
    """Return the non-empty traces of one quantity."""
    return tuple(t for t in estimate.traces if len(t.t) and t.quantity == quantity)


def components(estimate: Estimate, quantity: str) -> list[str]:
    """Return the title of each column of a quantity, with its unit."""
    if quantity not in _PER_JOINT:
        return [f"{quantity}, {_UNITS.get(quantity, '-')}"]
    titles = equation_titles(estimate.joints, estimate.torque_validation or Residual(0.0))
    return [title + _PER_JOINT[quantity] for title in titles]
