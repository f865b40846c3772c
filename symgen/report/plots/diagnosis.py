"""Figures of a diagnosis: torque error by joint, torques over time, residual over the state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from symgen import names
from symgen.data.raw import FloatArray
from symgen.diagnosis.diagnosis import Curves, Diagnosis
from symgen.report.plots.curves import (
    BLUE,
    GREEN,
    ORANGE,
    Panel,
    add_menu,
    empty,
    escape_text,
    line_grid,
    styled,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_DOTS = 600  # points of a residual plot
_UNITS = {names.REVOLUTE: ("N m", "rad"), names.PRISMATIC: ("N", "m")}


def gaps(diagnosis: Diagnosis) -> Figure:
    """Draw the torque error of each joint and in total, before and after, and the noise floor.

    The axis begins at zero; a button makes it logarithmic.
    """
    labels = [
        *(escape_text(diagnosis.extended.labels[number]) for number in diagnosis.joints),
        "all",
    ]
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
        add_menu(figure, buttons, type="buttons", direction="right")
    figure.update_yaxes(title="torque error, % of measured torque", rangemode="tozero")
    figure.update_xaxes(title="joint", showgrid=False)
    figure.update_layout(barmode="group", bargroupgap=0.05)
    return styled(figure, "Torque error", 400, min_width=80 * len(labels))


def residuals(diagnosis: Diagnosis) -> Figure | None:
    """Draw the torque residual of every joint over time, of the models before and after."""
    shown = ("before", "after") if diagnosis.effects else ("before",)
    return _over_time(
        diagnosis, lambda c: {x: c.measured - getattr(c, x) for x in shown}, "What is left", 130
    )


def torques(diagnosis: Diagnosis) -> Figure | None:
    """Draw the torque of every joint over time: measured, and by the extended model."""
    shown = ("measured", "after" if diagnosis.effects else "before")
    return _over_time(diagnosis, lambda c: {x: getattr(c, x) for x in shown}, "Torque", 165)


def _over_time(
    diagnosis: Diagnosis,
    shown: Callable[[Curves], Mapping[str, FloatArray]],
    title: str,
    height: int,
) -> Figure | None:
    """Draw named torques (K, n) of every log, a row for each joint; None without logs."""
    panels = [
        Panel(
            "",
            c.t,
            {name: x[:, j] for name, x in shown(c).items()},
            label,
            log=_log(c),
        )
        for c in diagnosis.curves
        for j, (label, _) in enumerate(_labels(diagnosis))
        if len(c.t)
    ]
    return line_grid(panels, title=title, columns=1, panel_height=height) if panels else None


def portraits(diagnosis: Diagnosis) -> Figure | None:
    """Draw the residual of the model before, for every joint, over velocity and position.

    If there are effects, the figure also shows their torque: the model after minus the model
    before.
    """
    panels = []
    for c in (c for c in diagnosis.curves if len(c.t)):
        some = np.unique(np.linspace(0, len(c.t) - 1, _DOTS).astype(int))
        shown = {"residual before": c.measured - c.before}
        if diagnosis.effects:
            shown["found effects"] = c.after - c.before
        for j, (label, unit) in enumerate(_labels(diagnosis)):
            series = {name: x[some, j] for name, x in shown.items()}
            for x, ylabel, xlabel in (
                (c.qd, label, f"speed, {unit}/s"),
                (c.q, "", f"position, {unit}"),
            ):
                panels.append(Panel("", x[some, j], series, ylabel, xlabel=xlabel, log=_log(c)))
    if not panels:
        return None
    figure = line_grid(panels, title="Residual", columns=2, panel_height=210)
    return figure.update_layout(legend_itemsizing="constant")


def _labels(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Return the label of each joint with the unit of its torque, and the unit of its position."""
    sigma = {j.number: j.sigma for j in diagnosis.extended.movable}
    units = ((number, *_UNITS[sigma[number]]) for number in diagnosis.joints)
    labels = diagnosis.extended.labels
    return [(f"{labels[number]}, {torque}", position) for number, torque, position in units]


def _log(c: Curves) -> tuple[str, str]:
    return c.name, "validation"
