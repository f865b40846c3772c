"""Figures of a diagnosis: torques over time, residual over the state, repaired channels."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from symgen import names
from symgen.data.raw import FloatArray
from symgen.diagnosis.diagnosis import Curves, Diagnosis
from symgen.report.plots.figure import Figure, Panel

_DOTS = 400  # points of the residual plots of a joint
_UNITS = {names.REVOLUTE: ("N m", "rad"), names.PRISMATIC: ("N", "m")}


def torques(diagnosis: Diagnosis) -> Figure | None:
    """Draw the torque of every joint over time: measured, and modelled before and after."""
    changed = any(effect.adopted for effect in diagnosis.effects)
    shown = ("measured", "before", "after") if changed else ("measured", "before")
    return _over_time(diagnosis, lambda c: {x: getattr(c, x) for x in shown})


def residuals(diagnosis: Diagnosis) -> Figure | None:
    """Draw the torque residual of every joint over time, of the models before and after."""
    shown = ("before", "after") if diagnosis.effects else ("before",)
    return _over_time(diagnosis, lambda c: {x: c.measured - getattr(c, x) for x in shown})


def _over_time(
    diagnosis: Diagnosis, shown: Callable[[Curves], Mapping[str, FloatArray]]
) -> Figure | None:
    """Draw named torques (K, n) of every log, a plot for each joint; None without logs."""
    panels = []
    for c in _recorded(diagnosis):
        torque = shown(c)
        for j, (label, unit, _) in enumerate(_joints(diagnosis)):
            series = {name: x[:, j] for name, x in torque.items()}
            panels.append(Panel(f"{label}, {unit}", c.t, series, (c.name, "validation")))
    return Figure(tuple(panels)) if panels else None


def repaired(diagnosis: Diagnosis) -> Figure | None:
    """Draw one channel of each repair where it changes most, as recorded and as used."""
    panels, done = [], set()
    for c in diagnosis.mended:
        if (c.log, c.says) in done:
            continue
        done.add((c.log, c.says))
        where = f"{c.channel} of {c.log[:60]}, {c.unit}"
        before, after = {"as recorded": c.recorded}, {"as repaired": c.repaired}
        panels.append(Panel(f"{where}: {c.says[:90]}", c.recorded[0], before))
        panels.append(Panel(f"{where}: repaired", c.recorded[0], after))
    return Figure(tuple(panels)) if panels else None


def portraits(diagnosis: Diagnosis) -> Figure | None:
    """Draw the residual of the model before, for every joint, over velocity and position.

    If there are effects, the figure also shows their torque: the model after minus the model
    before.
    """
    panels = []
    logs = _recorded(diagnosis)
    for c in logs:
        some = np.unique(np.linspace(0, len(c.t) - 1, _DOTS // len(logs) + 1).astype(int))
        shown = {"residual before": c.measured - c.before}
        if diagnosis.effects:
            shown["found effects"] = c.after - c.before
        for j, (label, torque, unit) in enumerate(_joints(diagnosis)):
            for state, over in ((c.qd, f"speed, {unit}/s"), (c.q, f"position, {unit}")):
                x = state[some, j]
                series = {name: np.stack([x, y[some, j]]) for name, y in shown.items()}
                title = f"{label}, {torque}, over {over}"
                panels.append(Panel(title, x, series, (c.name, "validation")))
    return Figure(tuple(panels), "") if panels else None


def _recorded(diagnosis: Diagnosis) -> list[Curves]:
    return [c for c in diagnosis.curves if len(c.t)]


def _joints(diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """Return the label of each joint, and the units of its torque and of its position."""
    sigma = {j.number: j.sigma for j in diagnosis.extended.movable}
    labels = diagnosis.extended.labels
    return [(labels[number], *_UNITS[sigma[number]]) for number in diagnosis.joints]
