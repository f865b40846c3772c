"""Figures of a page: small plots of curves as HTML and SVG, without scripts.

Curves stretch with the page. Labels are text, so their size is the same on a phone, on a wide
screen and on paper. The colours of Okabe and Ito (2008) are distinct for colour-blind readers.
Curves in one plot also differ in width or dashes, so that they are distinct in grey.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from symgen.data.raw import FloatArray
from symgen.files import rendered, write_text

BLUE, ORANGE, GREEN, SKY, INK = "#0072B2", "#D55E00", "#009E73", "#56B4E9", "#24292f"
#: Colours of curves that are not in `_LOOKS`.
_COLOURS = (INK, ORANGE, GREEN, "#CC79A7", "#B07800")
_DASHES = ("", "7 3", "2 3", "9 3 2 3")
#: Maximum number of points of a curve: one for each pixel of a wide page.
POINTS = 1200
#: Maximum number of points of a figure, half a megabyte, shared by its curves; and minimum for each
#: curve.
_OF_ALL, _FEW = 60_000, 40
#: Units of a plot from left to right, and from top to bottom.
_WIDE, _HIGH = 2000, 1000
_INTERVALS = 2.5  # minimum number of intervals between the ticks of an axis
_ROUND = (10, 5, 2, 1)  # steps of an axis, times a power of ten
_MARGIN = 0.05  # share of the ordinate, above and below the curves
_FLAT = 1e-9  # a smaller relative range is drawn as a constant
_GAP = 5  # steps without a sample that interrupt a line
_COLUMNS = 4  # maximum number of plots in a row of a wide page
_KINDS = {"train": "training"}


class Look(NamedTuple):
    """Colour, width in pixels and dashes of a curve."""

    colour: str
    width: float = 1.5
    dash: str = ""
    dots: bool = False

    @property
    def style(self) -> str:
        """The look as CSS."""
        cap = ";stroke-linecap:round" if self.dots else ""
        return f"stroke:{self.colour};stroke-width:{self.width};stroke-dasharray:{self.dash}{cap}"


_FAINT = Look("#9aa4ae", 0.8)
_LIMIT = Look(INK, 1.0, "7 3")
_UNDER, _OVER, _WRONG = Look(SKY, 4.0), Look(INK, 1.2), Look(ORANGE, 2.5)
#: Looks of curves by their names.
_LOOKS = {
    "unfiltered": _FAINT,
    "measured": _UNDER,
    "predicted": _OVER,
    "after": _OVER,
    "with the load": _OVER,
    "as repaired": Look(BLUE, 2.0),
    "without the load": _WRONG,
    "before": _WRONG,
    "as recorded": _WRONG,
    "residual": Look(ORANGE, 1.2, "2 2"),
    "upper limit": _LIMIT,
    "lower limit": _LIMIT,
    "residual before": Look(ORANGE, 4.0, dots=True),
    "residual after": Look(INK, 2.5, dots=True),
    "position": Look(BLUE, 2.5),
    "velocity": Look(ORANGE),
    "acceleration": _FAINT,
}


@dataclass(frozen=True, eq=False)
class Panel:
    """One plot of a figure.

    Attributes:
        title: its title, with the unit of the ordinate.
        x: abscissa, (K,).
        series: name and values of each curve, (K,); or (2, M) with its abscissa, drawn without
            thinning. Thinning keeps peaks.
        log: name and kind of the log in the plot.
        logarithmic: whether both axes are.
        xlabel: quantity of the abscissa, with its unit, if that of the figure is not it.
    """

    title: str
    x: FloatArray
    series: Mapping[str, FloatArray]
    log: tuple[str, str] = ("", "")
    logarithmic: bool = False
    xlabel: str = ""

    def curves(self, points: int) -> dict[str, FloatArray]:
        """Return the points to draw of each series, (2, M): about `points` points."""
        return {
            name: y if y.ndim > 1 else np.stack(thin(self.x, y, points))
            for name, y in self.series.items()
        }


def joint_panels(
    titles: Sequence[str],
    x: FloatArray,
    series: Mapping[str, FloatArray],
    log: tuple[str, str] = ("", ""),
) -> list[Panel]:
    """Return a plot for each column of arrays (K, n)."""
    columns = zip(*(y.T for y in series.values()), strict=True)
    joints = zip(titles, columns, strict=False)
    return [Panel(title, x, dict(zip(series, each, strict=True)), log) for title, each in joints]


@dataclass(frozen=True, eq=False)
class Figure:
    """Plots of a result, log by log; a notebook displays them.

    Attributes:
        panels: the plots; each has the data of its curves.
        xlabel: quantity of the abscissa, with its unit.
    """

    panels: tuple[Panel, ...]
    xlabel: str = "time, s"

    @property
    def looks(self) -> dict[str, Look]:
        """The look of each curve, by its name."""
        names = dict.fromkeys(name for panel in self.panels for name in panel.series)
        others = [name for name in names if name not in _LOOKS]
        every = dict(_LOOKS)
        for k, name in enumerate(others):
            every[name] = Look(_COLOURS[k % len(_COLOURS)], dash=_DASHES[k % len(_DASHES)])
        return {name: every[name] for name in names}

    @property
    def html(self) -> str:
        """The figure as a part of a page."""
        curves = sum(len(panel.series) for panel in self.panels)
        points = min(POINTS, max(_FEW, _OF_ALL // curves))
        logs: dict[tuple[str, str], list[_Drawn]] = {}
        for panel in self.panels:
            logs.setdefault(panel.log, []).append(_drawn(panel, self.looks, points))
        unseen = sorted(logs, key=lambda log: log[1] != "validation")  # a page opens the first one
        parts = [(_log_title(log), _columns(len(logs[log])), logs[log]) for log in unseen]
        return rendered("report/figure.html", figure=self, logs=parts)

    def save(self, path: str | Path) -> None:
        """Write the figure as an HTML file, which opens without a network.

        Raises:
            PackageError: the path contains a file that symgen did not write, or that was changed.
        """
        write_text(Path(path), self._repr_html_())

    def _repr_html_(self) -> str:
        return rendered("report/alone.html", figure=self)


class _Drawn(NamedTuple):
    """Values for the template: ticks in percent of the plot, curves as SVG paths."""

    title: str
    words: str
    ticks: tuple[list[tuple[float, str]], list[tuple[float, str]]]
    curves: list[tuple[str, str]]
    xlabel: str


class _Axis(NamedTuple):
    """The range of an axis; of logarithms to base ten if it is logarithmic."""

    low: float
    high: float
    logarithmic: bool

    def share(self, values: FloatArray) -> FloatArray:
        """Return the positions of values on the axis, from 0 to 1; NaN for values outside."""
        share: FloatArray = (_scaled(values, self.logarithmic) - self.low) / (self.high - self.low)
        return share

    def ticks(self) -> list[tuple[float, str]]:
        """Return round values on the axis: their positions in percent, and their texts."""
        span = self.high - self.low
        most = span / _INTERVALS
        power = 10.0 ** np.floor(np.log10(most))
        step = next(power * k for k in _ROUND if power * k <= most)
        if self.logarithmic and span >= 1:
            step = np.ceil(step)  # powers of ten
        at = step * np.arange(np.ceil(self.low / step), np.floor(self.high / step) + 1)
        values = 10.0**at if self.logarithmic else at
        digits = 2 if self.logarithmic else 8
        places = (100 * (at - self.low) / span).tolist()
        texts = [f"{value + 0.0:.{digits}g}" for value in values.tolist()]
        return list(zip(places, texts, strict=True))


def _axis(values: FloatArray, logarithmic: bool, margin: float = 0.0) -> _Axis:
    """Return an axis that contains all finite values."""
    scaled = _scaled(values, logarithmic)
    there = scaled[np.isfinite(scaled)]
    low, high = (float(there.min()), float(there.max())) if there.size else (0.0, 1.0)
    if high - low <= _FLAT * max(abs(low), abs(high)):
        half = 0.5 * abs(low) or 1.0
        low, high = low - half, high + half
    room = margin * (high - low)
    return _Axis(low - room, high + room, logarithmic)


def _scaled(values: FloatArray, logarithmic: bool) -> FloatArray:
    if not logarithmic:
        return values
    return np.log10(np.where(values > 0, values, np.nan))


def _drawn(panel: Panel, looks: Mapping[str, Look], points: int) -> _Drawn:
    curves = panel.curves(points)
    every = np.concatenate(list(curves.values()), axis=1)
    across = _axis(every[0], panel.logarithmic)
    up = _axis(every[1], panel.logarithmic, _MARGIN)
    paths = []
    for name, (x, y) in curves.items():
        path = _path(across.share(x), up.share(y), looks[name].dots)
        paths.append((looks[name].style, path))
    finite = every[1][np.isfinite(every[1])]
    words = f"{panel.title}: {', '.join(curves)}"
    if finite.size:
        words += f"; values from {finite.min():.3g} to {finite.max():.3g}"
    return _Drawn(panel.title, words, (across.ticks(), up.ticks()), paths, panel.xlabel)


def _path(x: FloatArray, y: FloatArray, dots: bool) -> str:
    """Return points as an SVG path: dots, or a line that breaks at NaN.

    Args:
        x, y: shares of the plot from its lower left corner, (K,).
    """
    there = np.isfinite(x) & np.isfinite(y)
    points = np.stack([_WIDE * x[there], _HIGH * (1 - y[there])], axis=1)
    rounded = np.rint(points).astype(int)
    if dots:
        return "".join(f"M{a} {b}h0" for a, b in rounded.tolist())
    breaks = np.flatnonzero(np.diff(np.cumsum(~there)[there])) + 1
    return "".join(map(_line, np.split(rounded, breaks)))


def _line(points: FloatArray) -> str:
    """Return a line through points in units of the plot, (K, 2); "" without points."""
    if not len(points):
        return ""
    steps = np.diff(points, axis=0)
    moves = [f"{a} {b}" for a, b in steps[steps.any(axis=1)].tolist()]
    return f"M{points[0, 0]} {points[0, 1]}l{' '.join(moves or ['0 0'])}"


def thin(x: FloatArray, y: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
    """Return at most about `points` points that keep every peak.

    The abscissa is divided into equal intervals. Each keeps its lowest and its highest point. A gap
    of more than five steps interrupts the line.

    Args:
        x: abscissa, increasing, shape (K,).
        y: values, shape (K,).
        points: 4 or more.
    """
    keep = np.arange(len(y))
    if len(y) > points:
        width = -(-len(y) // (points // 2 - 1))
        rows = np.pad(y, (0, -len(y) % width), constant_values=np.nan).reshape(-1, width)
        start, bad = width * np.arange(len(rows)), ~np.isfinite(rows)
        low = start + np.where(bad, np.inf, rows).argmin(axis=1)
        high = start + np.where(bad, -np.inf, rows).argmax(axis=1)
        keep = np.unique(np.concatenate([[0], low, high, [len(y) - 1]]))
    xs, ys = x[keep], y[keep]
    if len(x) > 2:
        step = np.diff(x)
        after = x[1:][step > _GAP * np.median(step)]
        at = np.searchsorted(xs, after)
        xs, ys = np.insert(xs, at, after), np.insert(ys, at, np.nan)
    return xs, ys


def _log_title(log: tuple[str, str]) -> str:
    name, kind = log
    return f"{name} ({_KINDS.get(kind, kind)})" if kind else name


def _columns(count: int) -> int:
    """Return the number of plots in a row, so that rows have nearly equal lengths."""
    rows = -(-count // _COLUMNS)
    return -(-count // rows)
