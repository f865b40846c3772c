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
from symgen.plots import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    SKY,
    choose_log,
    curve,
    empty,
    styled,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

FloatArray = NDArray[np.float64]
_DOTS = 600  # of a portrait
_SPREAD = 20.0  # largest over smallest bar from which the axis is logarithmic
_UNITS = {names.REVOLUTE: ("N m", "rad"), names.PRISMATIC: ("N", "m")}


def gaps(diagnosis: Diagnosis) -> Figure:
    """Draw the gap of every joint, and of all, before and after, beside the noise floor."""
    labels = [*(f"joint {number}" for number in diagnosis.joints), "all"]
    figure, seen = empty(), []
    for name, gap, colour in (
        ("before", diagnosis.before, ORANGE),
        ("after", diagnosis.after, BLUE),
        ("noise floor", diagnosis.floor, GREEN),
    ):
        values = 100 * np.array([*gap.per_joint, gap.total])
        seen.append(values[np.isfinite(values) & (values > 0)])
        hover = f"%{{x}}, {name}: %{{y:.3g}} %<extra></extra>"
        figure.add_bar(x=labels, y=values, name=name, marker_color=colour, hovertemplate=hover)
    drawn = np.concatenate(seen)
    wide = drawn.size > 0 and drawn.max() > _SPREAD * drawn.min()
    if wide:
        limits = np.log10([0.5 * drawn.min(), 1.4 * drawn.max()])
        ticks = {"dtick": "D2", "tickformat": "~g"}
        figure.update_yaxes(type="log", range=list(limits), **ticks)
    figure.update_yaxes(title="gap, % of measured torque")
    figure.update_xaxes(title="joint", showgrid=False)
    figure.update_layout(barmode="group", bargap=0.25, bargroupgap=0.05)
    return styled(figure, "Gap", 400, min_width=80 * len(labels))


def torques(diagnosis: Diagnosis) -> Figure | None:
    """Draw the torque of every joint over time: measured, and by the model before and after."""
    shown = [c for c in diagnosis.curves if len(c.t)]
    if not shown:
        return None
    figure = _rows(diagnosis, 1, 165)
    for c in shown:
        for j in range(len(diagnosis.joints)):
            for name, values, colour, width in (
                ("measured", c.measured, SKY, 4.0),
                ("before", c.before, ORANGE, 1.2),
                ("after", c.after, INK, 1.2),
            ):
                line = {"color": colour, "width": width}
                once = {"legendgroup": name, "showlegend": j == 0}
                figure.add_trace(curve(c.t, values[:, j], name, line, **once), row=j + 1, col=1)
    for j, (number, (torque, _)) in enumerate(_units(diagnosis)):
        figure.update_yaxes(title=f"joint {number}, {torque}", row=j + 1, col=1)
    figure.update_xaxes(title="time, s", row=len(diagnosis.joints), col=1)
    _choose(figure, shown, 3 * len(diagnosis.joints))
    return styled(figure, "Torque", 150 + 165 * len(diagnosis.joints))


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
    """Draw the residual of every joint before, against velocity, position and time.

    On top of it stands what the effects changed: the model after minus the model before.
    """
    shown = [c for c in diagnosis.curves if len(c.t)]
    if not shown:
        return None
    figure = _rows(diagnosis, 3, 210)
    for c in shown:
        some = np.unique(np.linspace(0, len(c.t) - 1, _DOTS).astype(int))
        for j in range(len(diagnosis.joints)):
            residual, fitted = (c.measured - c.before)[:, j], (c.after - c.before)[:, j]
            for column, x in ((1, c.qd[:, j]), (2, c.q[:, j])):
                for name, values, colour, size in (
                    ("residual before", residual, SKY, 5),
                    ("found effects", fitted, INK, 3),
                ):
                    dots = _dots(x[some], values[some], name, colour, size)
                    dots.update(showlegend=j == 0 and column == 1)
                    figure.add_trace(dots, row=j + 1, col=column)
            for name, values, colour, width in (
                ("residual before", residual, SKY, 2.0),
                ("found effects", fitted, INK, 1.2),
            ):
                line = {"color": colour, "width": width}
                once = {"legendgroup": name, "showlegend": False}
                figure.add_trace(curve(c.t, values, name, line, **once), row=j + 1, col=3)
    for j, (number, (torque, position)) in enumerate(_units(diagnosis)):
        figure.update_yaxes(title=f"joint {number}, {torque}", row=j + 1, col=1)
        for column, label in ((1, f"speed, {position}/s"), (2, f"position, {position}")):
            figure.update_xaxes(title={"text": label, "standoff": 2}, row=j + 1, col=column)
        figure.update_xaxes(title={"text": "time, s", "standoff": 2}, row=j + 1, col=3)
    _choose(figure, shown, 6 * len(diagnosis.joints))
    figure.update_layout(legend={"itemsizing": "constant"})
    return styled(figure, "Residual", 150 + 210 * len(diagnosis.joints), min_width=760)


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
