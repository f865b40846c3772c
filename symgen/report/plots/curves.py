"""Figures of an identification: plotly figures that are returned, never shown.

Colours are those of Okabe and Ito (2008), told apart by colour-blind readers too; where they must
repeat, dashes do. Names that come from files pass through `plain`, since plotly reads its labels as
a small HTML.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.values import Balance, Trace
from symgen.identification.estimate import Estimate

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

FloatArray = NDArray[np.float64]

BLUE, ORANGE, GREEN, SKY = "#0072B2", "#D55E00", "#009E73", "#56B4E9"
INK, GREY = "#24292f", "#8c959f"
COLOURS = (BLUE, ORANGE, GREEN, "#CC79A7", "#E69F00", SKY, "#4D4D4D")
DASHES = ("solid", "dash", "dot", "dashdot")
VALIDATION_GROUND = "#fdf8e8"  # behind curves that the estimate never saw

COURSES = 8  # parameters whose convergence is drawn at first
POINTS = 1800  # that a curve is drawn with at most: three for two pixels of a wide page
#: Relative standard deviation, in percent, from which a parameter counts as weak.
WEAK_PERCENT = 30.0

_UNITS = {"energy": "J"}
_PER_JOINT = {"torque": "", "momentum": " s"}  # what follows the unit of a torque
LEVEL = {"color": INK, "width": 1.2, "dash": "dash"}
_KINDS = {"train": "training"}
NAMED_AXIS = {"tickangle": -90, "tickfont": {"size": 10}}


@dataclass(frozen=True, eq=False)
class Panel:
    """One small plot of `line_grid`.

    Attributes:
        title: what it shows.
        x: abscissa of every series, shape (K,).
        series: name and values, shape (K,), of each line; equal names share colour and legend.
        ylabel: label of the ordinate with its unit.
        level: a true or expected value, drawn as a dashed horizontal line.
        band: lower and upper limit, each (K,), drawn as a shaded region, say +- 2 std.
    """

    title: str
    x: FloatArray
    series: Mapping[str, FloatArray]
    ylabel: str = ""
    level: float | None = None
    band: tuple[FloatArray, FloatArray] | None = None


def plain(text: str) -> str:
    """Return `text` such that plotly shows it letter by letter and sees no tag in it."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def parameters(estimate: Estimate) -> Figure:
    """Draw the relative standard deviation of each parameter on a log axis; weak ones hatched.

    Values differ by orders of magnitude and in unit; what compares between them is
    100 std / |value|. The hover gives value +- 2 std.
    """
    found = estimate.parameters
    names = [plain(p.name) for p in found]
    percent = np.array([p.relative_std_percent for p in found], dtype=float)
    drawn = percent[np.isfinite(percent) & (percent > 0)]
    bottom = 10 ** np.floor(np.log10(min(drawn.min(initial=1.0), 1.0)))
    top = 1.5 * min(max(drawn.max(initial=WEAK_PERCENT), 2 * WEAK_PERCENT), 1e4)
    height = np.clip(np.where(np.isfinite(percent), percent, top), bottom, top)
    weak = ~(percent <= WEAK_PERCENT)
    figure = empty()
    for name, chosen, colour, hatch in (
        (f"up to {WEAK_PERCENT:g} %", ~weak, BLUE, ""),
        (f"weak: over {WEAK_PERCENT:g} %, or unknown", weak, ORANGE, "/"),
    ):
        at = np.flatnonzero(chosen)
        hover = [
            f"<b>{names[k]}</b> = {found[k].value:.5g} ± {2 * found[k].std:.3g} "
            f"{plain(found[k].unit)} (2 std)<br>relative std {percent[k]:.3g} %"
            for k in at
        ]
        marker = {"color": colour, "pattern": {"shape": hatch}}
        shown = {"hovertext": hover, "hoverinfo": "text", "marker": marker}
        figure.add_bar(x=[names[k] for k in at], y=height[at], name=name, **shown)
    figure.add_hline(y=WEAK_PERCENT, line={"color": INK, "width": 1, "dash": "dash"})
    figure.update_xaxes(title="parameter, in the order of X", showgrid=False, **NAMED_AXIS)
    figure.update_xaxes(categoryorder="array", categoryarray=names)
    figure.update_yaxes(type="log", range=list(np.log10([bottom, top])), dtick=1, tickformat="~g")
    figure.update_layout(bargap=0.25, barmode="overlay", yaxis_title="relative std, %")
    return styled(figure, "Relative standard deviation", 440, min_width=14 * len(found))


def measured_and_predicted(estimate: Estimate, quantity: str | None = None) -> Figure | None:
    """Draw what was measured, what the model predicts, and their difference, log by log.

    One log is seen at a time, the first validation log to begin with; a list chooses another. Data
    that the estimate never saw stand on a tinted ground. `quantity` is "energy" or "torque", by
    default that of the first trace; None is returned where there is no such trace.
    """
    from plotly.subplots import make_subplots

    traces = traces_of(estimate, quantity)
    if not traces:
        return None
    quantity, columns = traces[0].quantity, traces[0].measured.shape[1]
    alone, named = columns == 1, components(estimate, quantity)
    rows = 2 if alone else columns
    shares = [0.62, 0.38] if alone else None
    gap = 0.05 if alone else 0.12 / rows
    figure = make_subplots(rows, 1, shared_xaxes=True, vertical_spacing=gap, row_heights=shares)
    for trace in traces:
        residual = trace.measured - trace.predicted
        for column in range(columns):
            for name, values, colour, width in (
                ("measured", trace.measured, SKY, 3.5),
                ("predicted", trace.predicted, INK, 1.0),
                ("residual", residual, ORANGE, 1.0),
            ):
                style = {"color": colour, "width": width}
                if name == "residual" and not alone:  # told from the others without colour
                    style["dash"] = "dot"
                once = {"legendgroup": name, "showlegend": column == 0}
                line = curve(trace.t, values[:, column], name, style, **once)
                row = (2 if name == "residual" else 1) if alone else column + 1
                figure.add_trace(line, row=row, col=1)
    for row in range(1, rows + 1):
        name, unit = named[0 if alone else row - 1]
        label = (quantity, "residual")[row - 1] if alone else name
        figure.update_yaxes(title=f"{label}, {unit}", row=row, col=1)
    across = "number of the pose" if estimate.model == "static" else "time, s"
    figure.update_xaxes(title=across, row=rows, col=1)
    figure.update_yaxes(zeroline=True)
    choose_log(figure, traces, 3 * columns)
    height = 560 if alone else 150 + 165 * columns
    return styled(figure, f"Measured and predicted {quantity}", height)


def convergence(estimate: Estimate) -> Figure | None:
    """Draw the recursive estimate over the data seen, each parameter relative to its final value.

    Those are drawn at first that moved most in the second half, weak ones apart; a click on the
    legend shows others. One that ends at zero is absent.
    """
    course = estimate.convergence
    if course is None or not len(course.t):
        return None
    final = course.values[-1]
    known = np.array([p.relative_std_percent <= WEAK_PERCENT for p in estimate.parameters])
    late = course.values[len(course.t) // 2 :]
    with np.errstate(divide="ignore", invalid="ignore"):
        moved = np.nan_to_num(np.nanmax(np.abs(late / final - 1), axis=0), nan=0.0, posinf=0.0)
    first = set(np.argsort(-np.where(known, moved, -1.0), kind="stable")[:COURSES].tolist())
    figure, every = empty(), slice(1 - len(course.t) % 2, None, 2)  # the last is among them
    for k, parameter in enumerate(estimate.parameters):
        if not final[k] or not np.isfinite(final[k]):
            continue
        ratio = course.values[every, k] / final[k]
        line = curve(course.t[every], ratio, parameter.name, line_style(k))
        figure.add_trace(line.update(visible=True if k in first else "legendonly"))
    figure.update_xaxes(title="data seen, s")
    figure.update_yaxes(title="estimate / final value", range=[-0.1, 2.1])
    styled(figure, "Recursive estimate", 460)
    legend = {"orientation": "v", "yref": "paper", "x": 1.01, "xanchor": "left", "y": 1}
    return figure.update_layout(
        legend={**legend, "yanchor": "top"}, margin={"b": 60, "r": 110}, meta={"min_width": 400}
    )


def correlation(estimate: Estimate) -> Figure | None:
    """Draw the correlation of the estimated parameters as a heat map; None where there is none."""
    if not estimate.correlation.size:
        return None
    names = [plain(p.name) for p in estimate.parameters]
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
    log_y: bool = False,
    height: int = 400,
) -> Figure:
    """Draw named lines, each (K,), over one abscissa (K,); labels carry the units."""
    panel = Panel("", x, series, ylabel)
    figure = line_grid([panel], title=title, xlabel=xlabel, panel_height=height - 130)
    figure.update_yaxes(type="log" if log_y else "linear")
    return figure.update_layout(margin={"t": 52})


def line_grid(
    panels: Sequence[Panel],
    *,
    title: str,
    xlabel: str = "time, s",
    columns: int = 3,
    panel_height: int = 230,
) -> Figure:
    """Draw small multiples: trajectories, or parameters that approach their true value."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    columns = max(1, min(columns, len(panels)))
    rows = max(1, -(-len(panels) // columns))
    height = 130 + rows * panel_height
    gaps = {"vertical_spacing": 75 / height if rows > 1 else 0.0}
    gaps["horizontal_spacing"] = 0.24 / columns
    titles = [plain(panel.title) for panel in panels]
    figure = make_subplots(rows, columns, subplot_titles=titles, **gaps)
    order = list(dict.fromkeys(name for panel in panels for name in panel.series))
    told: set[str] = set()
    for k, panel in enumerate(panels):
        place = {"row": k // columns + 1, "col": k % columns + 1}
        if panel.band is not None:
            (x, low), (back, high) = (thin(panel.x, limit) for limit in panel.band)
            area = go.Scatter(
                x=np.concatenate([x, back[::-1]]),
                y=np.concatenate([low, high[::-1]]),
                **{"fill": "toself", "fillcolor": "rgba(0,114,178,0.15)", "line": {"width": 0}},
                **{"hoverinfo": "skip", "showlegend": False},
            )
            figure.add_trace(area, **place)
        curves = [(n, panel.x, y, line_style(order.index(n))) for n, y in panel.series.items()]
        if panel.level is not None and len(panel.x):
            curves.append(("true value", panel.x[[0, -1]], np.full(2, panel.level), LEVEL))
        for name, abscissa, values, style in curves:
            once = {"legendgroup": plain(name), "showlegend": name not in told}
            told.add(name)
            figure.add_trace(curve(abscissa, values, name, style, **once), **place)
        last = k + columns >= len(panels)
        figure.update_xaxes(title=plain(xlabel) if last else None, **place)
        figure.update_yaxes(title=plain(panel.ylabel), title_standoff=4, **place)
    figure.update_layout(showlegend=len(told) > 1)
    figure.update_annotations(font={"size": 12})
    styled(figure, plain(title), height)
    # panels side by side need their room on a phone, too
    meta = {"min_width": 240 * columns if columns > 1 else 0, "grid": columns > 1}
    return figure.update_layout(margin={"t": 78}, meta=meta)


def thin(x: FloatArray, y: FloatArray, points: int = POINTS) -> tuple[Any, Any]:
    """Return at most about `points` points that keep every peak, in single precision.

    The abscissa is cut into equal buckets of which the lowest and the highest point stay; a pause
    of more than five steps breaks the line.

    Args:
        x: abscissa, increasing, shape (K,).
        y: values, shape (K,).
        points: the number of points to keep.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    keep = np.arange(len(y))
    if len(y) > points:
        width = -(-len(y) // (points // 2 - 1))
        count = -(-len(y) // width)
        start = width * np.arange(count)
        padded = np.full(count * width, np.nan)
        padded[: len(y)] = np.where(np.isfinite(y), y, np.nan)
        table = padded.reshape(count, width)
        lowest = np.where(np.isnan(table), np.inf, table).argmin(axis=1) + start
        highest = np.where(np.isnan(table), -np.inf, table).argmax(axis=1) + start
        keep = np.unique(np.concatenate([[0], lowest, highest, [len(y) - 1]]))
    xs, ys = x[keep], y[keep]
    if len(x) > 2:
        step = np.diff(x)
        after = x[1:][step > 5 * np.median(step)]
        at = np.searchsorted(xs, after)
        xs, ys = np.insert(xs, at, after), np.insert(ys, at, np.nan)
    return xs.astype(np.float32), ys.astype(np.float32)


def traces_of(estimate: Estimate, quantity: str | None = None) -> tuple[Trace, ...]:
    """Return the non-empty traces of one quantity, by default that of the first."""
    held = [t for t in estimate.traces if len(t.t)]
    wanted = quantity or (held[0].quantity if held else None)
    return tuple(t for t in held if t.quantity == wanted)


def choose_log(figure: Figure, traces: Sequence[Trace | Balance], curves: int) -> None:
    """Give the figure a list of logs, each with `curves` curves in order; curves after stay."""
    first = next((k for k, trace in enumerate(traces) if trace.kind == "validation"), 0)
    labels = [f"{plain(t.log)} ({_KINDS.get(t.kind, plain(t.kind))})" for t in traces]
    ground = [VALIDATION_GROUND if t.kind == "validation" else "#ffffff" for t in traces]
    every = list(range(curves * len(traces)))
    buttons = []
    for chosen, label in enumerate(labels):
        seen = {"visible": [k // curves == chosen for k in every]}
        act = [seen, {"plot_bgcolor": ground[chosen]}, every]
        buttons.append({"label": label, "method": "update", "args": act})
    for k in every:
        figure.data[k].visible = k // curves == first
    menu = {"buttons": buttons, "active": first, "bgcolor": "#ffffff", "bordercolor": GREY}
    place = {"x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom", "pad": {"b": 8}}
    figure.update_layout(plot_bgcolor=ground[first], updatemenus=[{**menu, **place}])


def components(estimate: Estimate, quantity: str) -> list[tuple[str, str]]:
    if quantity not in _PER_JOINT:
        return [(quantity, _UNITS.get(quantity, "-"))]
    return [(f"joint {number}", unit + _PER_JOINT[quantity]) for number, unit in estimate.joints]


def line_style(k: int) -> dict[str, Any]:
    dash = DASHES[k // len(COLOURS) % len(DASHES)]
    return {"color": COLOURS[k % len(COLOURS)], "dash": dash, "width": 1.5}


def empty() -> Figure:
    import plotly.graph_objects as go

    return go.Figure()


def curve(x: FloatArray, y: FloatArray, name: str, line: dict[str, Any], **options: Any) -> Any:
    import plotly.graph_objects as go

    xs, ys = thin(x, y)
    return go.Scatter(x=xs, y=ys, name=plain(name), mode="lines", line=line, **options)


def styled(figure: Figure, title: str, height: int, min_width: int = 0) -> Figure:
    """The one look of all figures; `min_width` in pixels is kept for the page in layout.meta.

    A page narrower than 600 pixels takes no notice of it, but for figures of which it says "grid".
    """
    axis = {"gridcolor": "#e6e8eb", "linecolor": GREY, "showline": True, "automargin": True}
    ticks = {"ticks": "outside", "tickcolor": GREY, "ticklen": 4, "hoverformat": ".5g"}
    # once for all axes, not once for each
    every = {
        "xaxis": {"zeroline": False, **axis, **ticks},
        "yaxis": {"zerolinecolor": "#b8bec5", **axis, **ticks},
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
