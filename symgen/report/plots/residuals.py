"""Figures of what a model leaves: its spectrum, its lag correlations, and the work it misses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from symgen.identification.estimate import Estimate
from symgen.report.plots.curves import (
    BLUE,
    GREEN,
    INK,
    LEVEL,
    ORANGE,
    POINTS,
    SKY,
    Panel,
    choose_log,
    components,
    curve,
    empty,
    line_grid,
    line_style,
    styled,
    traces_of,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

FloatArray = NDArray[np.float64]


def residual_spectrum(estimate: Estimate, quantity: str | None = None) -> Figure | None:
    """Draw the amplitude spectral density of the residual, log by log, by Welch's method.

    A good fit leaves a flat line below the cutoff; a peak is a motion or vibration the model lacks.
    None is returned where no trace is long enough (16 rows).
    """
    traces = tuple(t for t in traces_of(estimate, quantity) if len(t.t) >= 16)
    if not traces:
        return None
    named, columns = components(estimate, traces[0].quantity), traces[0].measured.shape[1]
    unit = " | ".join(dict.fromkeys(unit for _, unit in named))
    figure, low, high = empty(), np.inf, 0.0
    for trace in traces:
        f, density = amplitude_density(trace.t, trace.measured - trace.predicted)
        if np.any(density > 0):
            low, high = min(low, density[density > 0].min()), max(high, density.max())
        for column in range(columns):
            name = "residual" if columns == 1 else named[column][0]
            above = np.where(density[:, column] > 0, density[:, column], np.nan)
            figure.add_trace(curve(f, above, name, line_style(column)))
    # the cutoff goes last: it belongs to every log
    choose_log(figure, traces, columns)
    if estimate.cutoff_hz and high > 0:
        at, name = np.full(2, estimate.cutoff_hz), f"filter cutoff {estimate.cutoff_hz:.4g} Hz"
        figure.add_trace(curve(at, np.array([low, high]), name, LEVEL))
    figure.update_xaxes(type="log", title="frequency, Hz", tickformat="~g", dtick=1)
    figure.update_yaxes(type="log", title=f"residual, {unit}/√Hz", exponentformat="power", dtick=1)
    return styled(figure, f"Spectrum of the {traces[0].quantity} residual", 440)


def amplitude_density(t: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the one-sided amplitude spectral density of the longest stretch without a pause.

    Welch's method (1967): Hann windows that overlap by half, constant detrend; frequency 0 is left
    out.

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
    starts = range(0, len(piece) - length + 1, length - length // 2)
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
    power = np.zeros((even.shape[0], length // 2 + 1))
    for first in starts:
        part = even[:, first : first + length]
        level = part.mean(axis=1, keepdims=True)
        power += np.abs(np.fft.rfft(hann * (part - level), axis=1)) ** 2
    power *= 2 * step / (np.sum(hann**2) * len(starts))
    power[:, -1] /= 2 - length % 2  # half the rate has no mirror
    f = np.asarray(np.fft.rfftfreq(length, step), dtype=np.float64)
    return f[1:], np.sqrt(power[:, 1:]).T


def lag_correlation(estimate: Estimate) -> Figure | None:
    """Draw the lag correlations of every residual and the band that holds 95 % of chance ones.

    Those of validation data where they were tested, else of training data; None without any.
    """
    kinds = {w.kind for w in estimate.whiteness}
    if not kinds:
        return None
    kind = "validation" if "validation" in kinds else min(kinds)
    panels = []
    for w in estimate.whiteness:
        if w.kind != kind:
            continue
        lags, half = w.step_s * np.arange(1.0, len(w.bands) + 1), np.array(w.bands)
        name, _ = components(estimate, w.quantity)[w.component]
        title = w.quantity if name == w.quantity else f"{w.quantity}, {name}"
        series = {"correlation": np.array(w.correlations)}
        panels.append(Panel(title, lags, series, "correlation, -", band=(-half, half)))
    figure = line_grid(panels, title="Lag correlation", xlabel="lag, s", panel_height=190)
    figure.update_traces(mode="lines+markers", marker={"size": 5}, selector={"name": "correlation"})
    return figure.update_yaxes(zeroline=True)


def energy_balance(estimate: Estimate) -> Figure | None:
    """Draw the measured work over time, what the model says became of it, and the rest below."""
    from plotly.subplots import make_subplots

    balances = [b for b in estimate.balances if len(b.t)]
    if not balances:
        return None
    figure = make_subplots(2, 1, shared_xaxes=True, vertical_spacing=0.05, row_heights=[0.68, 0.32])
    for b in balances:
        for name, values, colour, width, row in (
            ("measured work", b.work, SKY, 4.0, 1),
            ("energy + friction", b.energy + b.friction, INK, 1.2, 1),
            ("change of energy", b.energy, BLUE, 1.2, 1),
            ("friction", b.friction, GREEN, 1.2, 1),
            ("rest", b.rest, ORANGE, 1.2, 2),
        ):
            line = {"color": colour, "width": width}
            figure.add_trace(curve(b.t, values, name, line), row=row, col=1)
    figure.update_yaxes(title="work since the start, J", row=1, col=1)
    figure.update_yaxes(title="rest, J", row=2, col=1)
    figure.update_xaxes(title="time, s", row=2, col=1)
    choose_log(figure, balances, 5)
    return styled(figure, "Energy balance", 560)
