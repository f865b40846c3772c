"""Plotly figures of an identification; functions return them and show nothing.

The colours of Okabe and Ito (2008) are distinct for colour-blind readers. Repeated colours have
another dash pattern. Names from files pass through `escape_text`, as plotly reads labels as HTML.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import repeat
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import FloatArray
from symgen.estimation.values import Trace
from symgen.identification.estimate import Estimate
from symgen.identification.uses import KNOWN
from symgen.robot.expressions import shortened

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


BLUE, ORANGE, GREEN, SKY = "#0072B2", "#D55E00", "#009E73", "#56B4E9"
INK, GREY = "#24292f", "#8c959f"
COLOURS = (BLUE, ORANGE, GREEN, "#CC79A7", "#E69F00", SKY, "#4D4D4D")
DASHES = ("solid", "dash", "dot", "dashdot")
VALIDATION_GROUND = "#fdf8e8"  # behind curves that the estimate never saw

_LEGEND = 40  # characters of a name in a legend: a phone has no room for more
POINTS = 1800  # that a curve is drawn with at most: three for two pixels of a wide page

_UNITS = {"energy": "J"}
_PER_JOINT = {"torque": "", "momentum": " s"}  # what follows the unit of a torque
LEVEL = {"color": INK, "width": 1.2, "dash": "dash"}
_UNDER, _OVER = {"color": SKY, "width": 3.5}, {"color": INK, "width": 1.0}
_WRONG = {"color": ORANGE, "width": 2.5}
#: Looks of curves by what they show; those with a size are dots.
_LOOKS: dict[str, dict[str, Any]] = {
    "unfiltered": {"color": "#c9ced4", "width": 0.8},
    "measured": _UNDER,
    "measured work": _UNDER,
    "predicted": _OVER,
    "after": _OVER,
    "with the load": _OVER,
    "without the load": _WRONG,
    "as repaired": _OVER,
    "before": _WRONG,
    "as recorded": _WRONG,
    "residual": {"color": ORANGE, "width": 1.0, "dash": "dot"},
    "true value": LEVEL,
    "residual before": {"color": SKY, "size": 5, "opacity": 0.7},
    "free function": {"color": BLUE, "width": 2.5},
    "named law": {"color": INK, "width": 1.5, "dash": "dash"},
    "found effects": {"color": INK, "size": 3, "opacity": 0.7},
}
_KINDS = {"train": "training"}
NAMED_AXIS = {"tickangle": -90, "tickfont": {"size": 10}}


@dataclass(frozen=True, eq=False)
class Panel:
    """One small plot of `line_grid`.

    Attributes:
        title: title of the panel.
        x: abscissa of every series, shape (K,).
        series: name and values of each line, (K,), or (2, M) with a separate abscissa. Equal names
            share colour and legend.
        ylabel: label of the ordinate with its unit.
        level: a true or expected value, drawn as a dashed horizontal line.
        band: lower and upper limit, each (K,), drawn as a shaded region, for example +- 2 std.
        xlabel: label of the abscissa, if it differs from that of the figure.
        share: height relative to the other panels.
        log: name and kind of the log; a menu above the figure selects one.
    """

    title: str
    x: FloatArray
    series: Mapping[str, FloatArray]
    ylabel: str = ""
    level: float | None = None
    band: tuple[FloatArray, FloatArray] | None = None
    xlabel: str = ""
    share: float = 1.0
    log: tuple[str, str] | None = None


def escape_text(text: str) -> str:
    """Return `text` escaped, so that plotly shows it literally: no tag, formula or template."""
    tags = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return tags.replace("$", "&#36;").replace("%{", "%&#123;")


def parameters(estimate: Estimate) -> Figure:
    """Draw the relative standard deviation of each parameter on a log axis; weak ones hatched.

    Values differ in unit and by orders of magnitude, so the axis shows 100 std / |value|. The hover
    text has value +- 2 std.
    """
    found = estimate.parameters
    percent = np.array([p.relative_std_percent for p in found], dtype=float)
    drawn = percent[np.isfinite(percent) & (percent > 0)]
    bottom = 10 ** np.floor(np.log10(min(drawn.min(initial=1.0), 1.0)))
    top = 1.5 * min(max(drawn.max(initial=KNOWN), 2 * KNOWN), 1e4)
    height = np.clip(np.where(np.isfinite(percent), percent, top), bottom, top)
    names = (f"up to {KNOWN:g} %", f"weak: over {KNOWN:g} %, or unknown")
    hover = [
        f"{p.name} = {p.value:.5g} ± {2 * p.std:.3g} {p.unit} (2 std), relative std "
        f"{p.relative_std_percent:.3g} %"
        for p in found
    ]
    labels = [p.name for p in found]
    figure = bars(labels, height, ~(percent <= KNOWN), names, hover, [KNOWN])
    figure.update_yaxes(type="log", range=list(np.log10([bottom, top])), dtick=1, tickformat="~g")
    figure.update_yaxes(title="relative std, %")
    figure.update_xaxes(title="parameter, in the order of X")
    return styled(figure, "Relative standard deviation", 440, min_width=14 * len(found))


def bars(
    labels: Sequence[str],
    heights: FloatArray,
    beyond: NDArray[np.bool_],
    names: tuple[str, str],
    hover: Sequence[str],
    levels: Sequence[float],
) -> Figure:
    """Draw a bar for each parameter, hatched if it is beyond a level, and the levels."""
    figure, shown = empty(), [escape_text(label) for label in labels]
    looks = ({"color": BLUE}, {"color": ORANGE, "pattern": {"shape": "/"}})
    for name, chosen, marker in zip(names, (~beyond, beyond), looks, strict=True):
        at = np.flatnonzero(chosen & np.isfinite(heights)).tolist()
        told = {"hovertext": [escape_text(hover[k]) for k in at], "hoverinfo": "text"}
        figure.add_bar(x=[shown[k] for k in at], y=heights[at], name=name, marker=marker, **told)
    for level in levels:
        figure.add_hline(y=level, line={"color": INK, "width": 1, "dash": "dash"})
    figure.update_xaxes(categoryorder="array", categoryarray=shown, showgrid=False, **NAMED_AXIS)
    return figure.update_layout(barmode="overlay")


def measured_and_predicted(estimate: Estimate, quantity: str) -> Figure | None:
    """Draw the measured and the modelled quantity and their difference, for each log.

    The figure shows one log, at first the first validation log; a menu selects another. Held-out
    data have a tinted background. `quantity` is "energy" or "torque". The result is None without
    such a trace.
    """
    traces, panels = traces_of(estimate, quantity), list[Panel]()
    if not traces:
        return None
    alone = traces[0].measured.shape[1] == 1
    for t in traces:
        raws = repeat(None) if t.raw is None else t.raw.T
        columns = zip(
            components(estimate, quantity), raws, t.measured.T, t.predicted.T, strict=False
        )
        for (name, unit), raw, measured, predicted in columns:
            both = {} if raw is None else {"unfiltered": raw}
            both |= {"measured": measured, "predicted": predicted}
            residual, log = {"residual": measured - predicted}, (t.log, t.kind)
            if alone:
                panels.append(Panel("", t.t, both, f"{quantity}, {unit}", share=0.62, log=log))
                label = f"residual, {unit}"
                panels.append(Panel("", t.t, residual, label, share=0.38, log=log))
            else:
                panels.append(Panel(name, t.t, both | residual, unit, log=log))
    return line_grid(
        panels,
        title=f"Measured and predicted {quantity}",
        xlabel="number of the pose" if estimate.model == "static" else "time, s",
        columns=1,
        panel_height=215 if alone else 165,
    )


def correlation(estimate: Estimate) -> Figure | None:
    """Draw the correlation of the estimated parameters as a heat map; None without one."""
    if not estimate.correlation.size:
        return None
    names = [escape_text(p.name) for p in estimate.parameters]
    bar = {"title": {"text": "correlation, -", "side": "right"}, "thickness": 12}
    figure = empty().add_heatmap(
        **{"x": names, "y": names, "z": np.round(estimate.correlation, 3).astype(np.float32)},
        **{"zmin": -1, "zmax": 1, "colorbar": bar},
        colorscale=[[0, ORANGE], [0.5, "#ffffff"], [1, BLUE]],
        hovertemplate="%{y}, %{x}: %{z:.3f}<extra></extra>",
    )
    figure.update_xaxes(title="parameter", showgrid=False, **NAMED_AXIS)
    figure.update_yaxes(title="parameter", showgrid=False, autorange="reversed", tickfont_size=10)
    height = int(np.clip(13 * len(names) + 170, 360, 1000))
    return styled(figure, "Correlation of the parameters", height, min_width=height - 40)


def lines(
    x: FloatArray,
    series: Mapping[str, FloatArray],
    *,
    title: str,
    xlabel: str,
    ylabel: str,
    height: int = 400,
) -> Figure:
    """Draw named lines, each (K,), over one abscissa (K,); labels contain the units."""
    panel = Panel("", x, series, ylabel)
    return line_grid([panel], title=title, xlabel=xlabel, panel_height=height - 130)


def line_grid(
    panels: Sequence[Panel],
    *,
    title: str,
    xlabel: str = "time, s",
    columns: int = 3,
    panel_height: int = 230,
) -> Figure:
    """Draw a grid of small panels.

    Panels in one column share their abscissa, unless one has its own label. A panel without a label
    of the ordinate shares that of the panel to its left. Every log has the same number of panels.
    """
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    logs: dict[tuple[str, str] | None, list[Panel]] = {}
    for panel in panels:
        logs.setdefault(panel.log, []).append(panel)
    first = next(iter(logs.values()))
    titled, beside = any(p.title for p in first), any(not p.ylabel for p in first)
    columns = max(1, min(columns, len(first)))
    rows = -(-len(first) // columns)
    stacked = columns == 1 and not any(p.xlabel for p in first)
    apart = (46 if titled else 30) if stacked else 75
    height = 130 + rows * panel_height
    figure = make_subplots(
        rows,
        columns,
        subplot_titles=[escape_text(panel.title) for panel in first],
        shared_xaxes=stacked,
        shared_yaxes=beside,
        vertical_spacing=apart / height if rows > 1 else 0.0,
        horizontal_spacing=0.03 if beside else 0.24 / columns,
        row_heights=[panel.share for panel in first[::columns]],
    )
    order = list(dict.fromkeys(name for panel in first for name in panel.series))
    places = [{"row": k // columns + 1, "col": k % columns + 1} for k in range(len(first))]
    owners: list[tuple[str, str] | None] = []
    for log, shown in logs.items():
        told: set[str] = set()
        for place, panel in zip(places, shown, strict=True):
            if panel.band is not None:
                (x, low), (back, high) = (thin(panel.x, limit) for limit in panel.band)
                area = go.Scatter(
                    x=np.concatenate([x, back[::-1]]),
                    y=np.concatenate([low, high[::-1]]),
                    **{"fill": "toself", "fillcolor": "rgba(0,114,178,0.15)", "line_width": 0},
                    **{"hoverinfo": "skip", "showlegend": False},
                )
                figure.add_trace(area, **place)
            curves = [(name, panel.x, y) for name, y in panel.series.items()]
            if panel.level is not None and len(panel.x):
                curves.append(("true value", panel.x[[0, -1]], np.full(2, panel.level)))
            for name, x, y in curves:
                look = _LOOKS.get(name) or line_style(order.index(name))
                across, up = y if y.ndim == 2 else (x, y)
                line = curve(across, up, name, look, legendgroup=escape_text(name))
                figure.add_trace(line.update(showlegend=name not in told), **place)
                told.add(name)
            owners += [log] * (len(figure.data) - len(owners))
    for k, (place, panel) in enumerate(zip(places, first, strict=True)):
        label = panel.xlabel or (xlabel if k + columns >= len(first) else "")
        figure.update_xaxes(title={"text": escape_text(label), "standoff": 2}, **place)
        figure.update_yaxes(title=escape_text(panel.ylabel), title_standoff=4, **place)
    figure.update_layout(showlegend=len({c.name for c in figure.data}) > 1)
    figure.update_annotations(font_size=12)
    if columns == 1:
        figure.update_annotations(x=0, xanchor="left")
    choose_log(figure, [log for log in logs if log is not None], owners)
    styled(figure, escape_text(title), height)
    # panels side by side need their room on a phone, too
    meta = {"min_width": 240 * columns, "grid": True}
    return figure.update_layout(margin={"t": figure.layout.margin.t + 26 * titled}, meta=meta)


def thin(x: FloatArray, y: FloatArray) -> tuple[Any, Any]:
    """Return at most about POINTS points that keep every peak, in single precision.

    The abscissa is divided into equal intervals. Each keeps its lowest and its highest point. A gap
    of more than five steps interrupts the line.

    Args:
        x: abscissa, increasing, shape (K,).
        y: values, shape (K,).
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    keep = np.arange(len(y))
    if len(y) > POINTS:
        width = -(-len(y) // (POINTS // 2 - 1))
        rows = np.pad(y, (0, -len(y) % width), constant_values=np.nan).reshape(-1, width)
        start, bad = width * np.arange(len(rows)), ~np.isfinite(rows)
        low = start + np.where(bad, np.inf, rows).argmin(axis=1)
        high = start + np.where(bad, -np.inf, rows).argmax(axis=1)
        keep = np.unique(np.concatenate([[0], low, high, [len(y) - 1]]))
    xs, ys = x[keep], y[keep]
    if len(x) > 2:
        step = np.diff(x)
        after = x[1:][step > 5 * np.median(step)]
        at = np.searchsorted(xs, after)
        xs, ys = np.insert(xs, at, after), np.insert(ys, at, np.nan)
    return xs.astype(np.float32), ys.astype(np.float32)


def traces_of(estimate: Estimate, quantity: str) -> tuple[Trace, ...]:
    """Return the non-empty traces of one quantity."""
    return tuple(t for t in estimate.traces if len(t.t) and t.quantity == quantity)


def choose_log(
    figure: Figure, logs: Sequence[tuple[str, str]], owners: Sequence[tuple[str, str] | None]
) -> None:
    """Add a menu of logs to a figure; `owners` has the log (name and kind) of each curve."""
    if not logs:
        return
    first = next((log for log in logs if log[1] == "validation"), logs[0])
    ground = {log: VALIDATION_GROUND if log[1] == "validation" else "#ffffff" for log in logs}
    buttons, every = [], list(range(len(owners)))
    for log in logs:
        seen = {"visible": [owner == log for owner in owners]}
        label = f"{escape_text(log[0])} ({_KINDS.get(log[1], escape_text(log[1]))})"
        act = [seen, {"plot_bgcolor": ground[log]}, every]
        buttons.append({"label": label, "method": "update", "args": act})
    for drawn, owner in zip(figure.data, owners, strict=True):
        drawn.visible = owner == first
    figure.update_layout(plot_bgcolor=ground[first])
    add_menu(figure, buttons, active=logs.index(first), bordercolor=GREY)


def add_menu(figure: Figure, buttons: Sequence[Mapping[str, Any]], **more: Any) -> None:
    """Add a menu above a figure."""
    above = 26 if figure.layout.annotations else 8  # the title of the first panel
    place = {"x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom", "pad": {"b": above}}
    menu = {"buttons": buttons, "bgcolor": "#ffffff", **place, **more}
    figure.update_layout(updatemenus=[menu])


def components(estimate: Estimate, quantity: str) -> list[tuple[str, str]]:
    if quantity not in _PER_JOINT:
        return [(quantity, _UNITS.get(quantity, "-"))]
    return [(joint.label, joint.unit + _PER_JOINT[quantity]) for joint in estimate.joints]


def line_style(k: int) -> dict[str, Any]:
    dash = DASHES[k // len(COLOURS) % len(DASHES)]
    return {"color": COLOURS[k % len(COLOURS)], "dash": dash, "width": 1.5}


def empty() -> Figure:
    import plotly.graph_objects as go

    return go.Figure()


def curve(x: FloatArray, y: FloatArray, name: str, line: dict[str, Any], **options: Any) -> Any:
    import plotly.graph_objects as go

    if "size" in line:
        told = {"x": np.asarray(x, np.float32), "y": np.asarray(y, np.float32), "marker": line}
    else:
        told = {**dict(zip("xy", thin(x, y), strict=True)), "line": line}
    mode = "markers" if "size" in line else "lines"
    return go.Scatter(name=escape_text(shortened(name, _LEGEND)), mode=mode, **told, **options)


def styled(figure: Figure, title: str, height: int, min_width: int = 0) -> Figure:
    """Apply the common style of all figures; layout.meta keeps `min_width` in pixels for the page.

    A page narrower than 600 pixels ignores it, except for figures marked "grid".
    """
    axis = {"gridcolor": "#e6e8eb", "linecolor": GREY, "showline": True, "automargin": True}
    ticks = {"ticks": "outside", "tickcolor": GREY, "ticklen": 4, "hoverformat": ".5g"}
    # once for all axes, not once for each
    every = {
        "xaxis": {"zeroline": False, **axis, **ticks},
        "yaxis": {"zeroline": True, "zerolinecolor": "#b8bec5", **axis, **ticks},
    }
    figure.layout.template = {"layout": every}  # and nothing of plotly's own
    top = 84 if figure.layout.updatemenus else 52
    legend = figure.layout.showlegend is not False
    head = {"x": 0, "xref": "paper", "y": 1, "yref": "container", "yanchor": "top"}
    below = {"orientation": "h", "x": 0.5, "xanchor": "center", "y": 0, "yanchor": "bottom"}
    return figure.update_layout(
        title={"text": title, "font": {"size": 15}, "pad": {"t": 14}, **head},
        font={"family": "system-ui, 'Segoe UI', Helvetica, Arial, sans-serif", "color": INK},
        paper_bgcolor="#ffffff",
        height=height,
        showlegend=legend,
        margin={"l": 64, "r": 16, "t": top, "b": 92 if legend else 60},
        legend={"yref": "container", **below},
        hovermode="closest",
        meta={"min_width": min_width},
    )
