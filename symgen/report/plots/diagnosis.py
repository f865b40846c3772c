"""Figures of a diagnosis: the gap per joint, torques over time, portraits of the residual."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.diagnosis.diagnosis import Curves, Diagnosis
from symgen.diagnosis.replay import Replay
from symgen.estimation.values import Trace
from symgen.report.plots.curves import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    SKY,
    choose_log,
    curve,
    empty,
    plain,
    styled,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

FloatArray = NDArray[np.float64]
_DOTS = 600  # of a portrait
_UNITS = {names.REVOLUTE: ("N m", "rad"), names.PRISMATIC: ("N", "m")}


def gaps(diagnosis: Diagnosis) -> Figure:
    """Draw the gap of every joint, and of all, before and after, beside the noise floor.

    The axis begins at zero; a button makes it logarithmic.
    """
    labels = [*(f"joint {number}" for number in diagnosis.joints), "all"]
    figure, seen = empty(), []
    for name, gap, colour, hatch in (
        ("before", diagnosis.before, ORANGE, "/"),
        ("after", diagnosis.after, BLUE, ""),
        ("noise floor", diagnosis.floor, GREEN, "."),
    ):
        values = 100 * np.array([*gap.per_joint, gap.total])
        seen.append(values[np.isfinite(values) & (values > 0)])
        hover = f"%{{x}}, {name}: %{{y:.3g}} %<extra></extra>"
        marker = {"color": colour, "pattern": {"shape": hatch}}
        figure.add_bar(x=labels, y=values, name=name, marker=marker, hovertemplate=hover)
    drawn = np.concatenate(seen)
    if drawn.size:
        limits = np.log10([0.5 * drawn.min(), 1.4 * drawn.max()]).tolist()
        scales = (
            ("linear", {"yaxis.type": "linear", "yaxis.range": [0, 1.05 * drawn.max()]}),
            ("logarithmic", {"yaxis.type": "log", "yaxis.range": limits}),
        )
        buttons = [{"label": name, "method": "relayout", "args": [axis]} for name, axis in scales]
        place = {"x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom", "pad": {"b": 8}}
        menu = {"buttons": buttons, "type": "buttons", "direction": "right", "bgcolor": "#ffffff"}
        figure.update_layout(updatemenus=[{**menu, **place}])
    figure.update_yaxes(title="gap, % of measured torque", rangemode="tozero")
    figure.update_xaxes(title="joint", showgrid=False)
    figure.update_layout(barmode="group", bargap=0.25, bargroupgap=0.05)
    return styled(figure, "Gap", 400, min_width=80 * len(labels))


def residuals(diagnosis: Diagnosis) -> Figure | None:
    """Draw what the models before and after leave of the torque of every joint over time."""
    shown = [c for c in diagnosis.curves if len(c.t)]
    if not shown:
        return None
    figure, found = _rows(diagnosis, 1, 130), bool(diagnosis.effects)
    for c in shown:
        for j in range(len(diagnosis.joints)):
            kinds = [("before", c.before, ORANGE, 2.5)] + [("after", c.after, INK, 1.0)] * found
            for name, modelled, colour, width in kinds:
                line = {"color": colour, "width": width}
                once = {"legendgroup": name, "showlegend": j == 0}
                left = c.measured[:, j] - modelled[:, j]
                figure.add_trace(curve(c.t, left, name, line, **once), row=j + 1, col=1)
    for j, (number, (torque, _)) in enumerate(_units(diagnosis)):
        figure.update_yaxes(title=f"joint {number}, {torque}", row=j + 1, col=1)
    figure.update_xaxes(title="time, s", row=len(diagnosis.joints), col=1)
    figure.update_yaxes(zeroline=True)
    _choose(figure, shown, (1 + found) * len(diagnosis.joints))
    return styled(figure, "What is left", 150 + 130 * len(diagnosis.joints))


def torques(diagnosis: Diagnosis) -> Figure | None:
    """Draw the torque of every joint over time: measured, and by the model with what was found."""
    shown = [c for c in diagnosis.curves if len(c.t)]
    if not shown:
        return None
    figure = _rows(diagnosis, 1, 165)
    last = "after" if diagnosis.effects else "before"
    kinds = (("measured", SKY, 4.0), (last, INK, 1.2))
    for c in shown:
        for j in range(len(diagnosis.joints)):
            for name, colour, width in kinds:
                values = getattr(c, name)
                line = {"color": colour, "width": width}
                once = {"legendgroup": name, "showlegend": j == 0}
                figure.add_trace(curve(c.t, values[:, j], name, line, **once), row=j + 1, col=1)
    for j, (number, (torque, _)) in enumerate(_units(diagnosis)):
        figure.update_yaxes(title=f"joint {number}, {torque}", row=j + 1, col=1)
    figure.update_xaxes(title="time, s", row=len(diagnosis.joints), col=1)
    _choose(figure, shown, len(kinds) * len(diagnosis.joints))
    return styled(figure, "Torque", 150 + 165 * len(diagnosis.joints))


def mended(diagnosis: Diagnosis) -> Figure | None:
    """Draw the channels that were repaired, around the repair: as recorded and as used."""
    from plotly.subplots import make_subplots

    shown = diagnosis.mended
    if not shown:
        return None
    count, height = len(shown), 150
    titles = [f"{plain(c.channel)} of {plain(c.log)[:60]}: {plain(c.says)[:90]}" for c in shown]
    between = 62 / (height * count) if count > 1 else 0.0
    figure = make_subplots(count, 1, subplot_titles=titles, vertical_spacing=between)
    figure.update_annotations(font_size=12, x=0, xanchor="left")
    for k, c in enumerate(shown, 1):
        for name, part, colour, width in (
            ("as recorded", c.recorded, ORANGE, 2.5),
            ("as repaired", c.repaired, INK, 1.0),
        ):
            line = {"color": colour, "width": width}
            once = {"legendgroup": name, "showlegend": k == 1}
            figure.add_trace(curve(part[0], part[1], name, line, **once), row=k, col=1)
        figure.update_yaxes(title=plain(c.unit), row=k, col=1)
    figure.update_xaxes(title="time, s", row=count, col=1)
    return styled(figure, "Repaired channels", 150 + height * count)


def motion(diagnosis: Diagnosis, replay: Replay) -> Figure:
    """Draw simulated minus measured position of every joint under the measured torques."""
    figure = _rows(diagnosis, 1, 165)
    for j, (number, unit) in enumerate(zip(diagnosis.joints, replay.units, strict=True)):
        for name, values, colour in (
            ("before", replay.before, ORANGE),
            ("after", replay.after, INK),
        ):
            once = {"legendgroup": name, "showlegend": j == 0}
            line = {"color": colour, "width": 1.6}
            figure.add_trace(curve(replay.t, values[:, j], name, line, **once), row=j + 1, col=1)
        figure.update_yaxes(title=f"joint {number}, {unit}", row=j + 1, col=1)
    figure.update_yaxes(tickformat="~g")  # no prefixes before rad
    figure.update_xaxes(title="time, s", row=len(diagnosis.joints), col=1)
    return styled(figure, "Motion", 150 + 165 * len(diagnosis.joints))


def portraits(diagnosis: Diagnosis) -> Figure | None:
    """Draw the residual of every joint before, against velocity and position.

    On top of it stands what the effects changed, where there are any: the model after minus the
    model before.
    """
    shown = [c for c in diagnosis.curves if len(c.t)]
    if not shown:
        return None
    figure = _rows(diagnosis, 2, 210)
    count = 2 if diagnosis.effects else 1
    for c in shown:
        some = np.unique(np.linspace(0, len(c.t) - 1, _DOTS).astype(int))
        for j in range(len(diagnosis.joints)):
            residual, fitted = (c.measured - c.before)[:, j], (c.after - c.before)[:, j]
            for column, x in ((1, c.qd[:, j]), (2, c.q[:, j])):
                for name, values, colour, size in (
                    ("residual before", residual, SKY, 5),
                    ("found effects", fitted, INK, 3),
                )[:count]:
                    dots = _dots(x[some], values[some], name, colour, size)
                    dots.update(showlegend=j == 0 and column == 1)
                    figure.add_trace(dots, row=j + 1, col=column)
    for j, (number, (torque, position)) in enumerate(_units(diagnosis)):
        figure.update_yaxes(title=f"joint {number}, {torque}", row=j + 1, col=1)
        for column, label in ((1, f"speed, {position}/s"), (2, f"position, {position}")):
            figure.update_xaxes(title={"text": label, "standoff": 2}, row=j + 1, col=column)
    _choose(figure, shown, 2 * count * len(diagnosis.joints))
    figure.update_layout(legend={"itemsizing": "constant"})
    return styled(figure, "Residual", 150 + 210 * len(diagnosis.joints), min_width=520)


def _rows(diagnosis: Diagnosis, columns: int, height: int) -> Figure:
    """Return a row of panels for every joint; those of one row share the ordinate."""
    from plotly.subplots import make_subplots

    rows = len(diagnosis.joints)
    between = (30 if columns == 1 else 62) / (height * rows)
    return make_subplots(
        rows,
        columns,
        shared_xaxes=columns == 1,
        shared_yaxes=columns > 1,
        vertical_spacing=between if rows > 1 else 0.0,
        horizontal_spacing=0.03,
    )


def _units(diagnosis: Diagnosis) -> list[tuple[int, tuple[str, str]]]:
    sigma = {j.number: j.sigma for j in diagnosis.extended.movable}
    return [(number, _UNITS[sigma[number]]) for number in diagnosis.joints]


def _choose(figure: Figure, shown: Sequence[Curves], curves: int) -> None:
    traces = [Trace(c.name, "validation", "torque", c.t, c.measured, c.after) for c in shown]
    choose_log(figure, traces, curves)


def _dots(x: FloatArray, y: FloatArray, name: str, colour: str, size: int) -> Any:
    import plotly.graph_objects as go

    marker = {"color": colour, "size": size, "opacity": 0.7}
    values = {"x": x.astype(np.float32), "y": y.astype(np.float32)}
    return go.Scatter(**values, name=name, legendgroup=name, mode="markers", marker=marker)
