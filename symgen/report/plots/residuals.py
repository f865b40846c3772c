"""The spectrum of the residual."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from symgen.data.raw import FloatArray
from symgen.identification.estimate import Estimate
from symgen.report.plots.curves import (
    LEVEL,
    POINTS,
    Panel,
    components,
    line_grid,
    traces_of,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


def residual_spectrum(estimate: Estimate, quantity: str) -> Figure | None:
    """Draw the amplitude spectral density of the residual of each log, by Welch's method.

    A good fit has a flat line below the cutoff. A peak is a motion or vibration that the model
    lacks. The result is None if no trace is long enough (16 rows).
    """
    traces = tuple(t for t in traces_of(estimate, quantity) if len(t.t) >= 16)
    if not traces:
        return None
    panels, named = [], components(estimate, quantity)
    unit = " | ".join(dict.fromkeys(unit for _, unit in named))
    for t in traces:
        f, density = amplitude_density(t.t, t.measured - t.predicted)
        above = np.where(density > 0, density, np.nan)
        labels = [name for name, _ in named] if len(named) > 1 else ["of the residual"]
        series = dict(zip(labels, above.T, strict=False))
        panels.append(Panel("", f, series, f"residual, {unit}/√Hz", log=(t.log, t.kind)))
    title = f"Spectrum of the {quantity} residual"
    figure = line_grid(panels, title=title, xlabel="frequency, Hz", panel_height=310)
    if estimate.cutoff_hz:  # it belongs to every log
        name = f"filter cutoff {estimate.cutoff_hz:.4g} Hz"
        figure.add_vline(x=estimate.cutoff_hz, line=LEVEL, name=name, showlegend=True)
        figure.update_layout(showlegend=True)
    figure.update_xaxes(type="log", tickformat="~g", dtick=1)
    return figure.update_yaxes(type="log", exponentformat="power", dtick=1)


def amplitude_density(t: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the one-sided amplitude spectral density of the longest part without a gap.

    The method is that of Welch (1967): Hann windows that overlap by half, without their mean. The
    result does not contain frequency 0.

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
    length = min(len(piece), max(64, min(2 * POINTS, len(piece) // 6)))
    # Welch's mean of periodograms; scipy.signal would take longer to import than a page to write.
    windows = np.lib.stride_tricks.sliding_window_view(even, length, axis=1)
    windows = windows[:, :: length - length // 2]
    hann = np.hanning(length + 1)[:-1]
    lines = np.fft.rfft(hann * (windows - windows.mean(axis=2, keepdims=True)), axis=2)
    power = 2 * step / np.sum(hann**2) * np.mean(np.abs(lines) ** 2, axis=1)
    power[:, -1] /= 2 - length % 2  # half the rate has no mirror
    density: FloatArray = np.sqrt(power[:, 1:]).T
    frequencies = np.asarray(np.fft.rfftfreq(length, step)[1:], dtype=np.float64)
    return frequencies, density
