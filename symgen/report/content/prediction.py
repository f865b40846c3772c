"""What is said of a prediction: measured and predicted torque of a log, the model's energy."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from symgen.identification.prediction import Prediction
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    notes_section,
    number,
    percent,
    run_lines,
)
from symgen.report.plots import curves as plots

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


def prediction_content(prediction: Prediction) -> Content:
    """Return the error of the torque per joint, curves, energies, notes."""
    trace, error = prediction.torque, prediction.error
    lead = (f"What the model of {prediction.robot} with given parameters says of {trace.log}.",)
    joints = [joint.label for joint in prediction.joints]
    rows = [*zip(joints, map(percent, error.per_joint or ()), strict=True)]
    table = Table(("", "error"), (*rows, ("all", percent(error.relative))))
    text = (
        "RMS of measured minus predicted over RMS of measured torque; in all that of all joints "
        "together."
    )
    told = (
        f"{text} Both have passed the same zero-phase low-pass at "
        f"{number(prediction.band.comparison_hz)} Hz, positions and speeds one at "
        f"{number(prediction.band.cutoff_hz)} Hz."
    )
    torques, energies = partial(_torques, prediction), partial(_energies, prediction)
    sections = (
        Section("Measured and predicted torque", (told,), table, torques, told=()),
        Section("Energy", ("Potential energy is known up to a constant.",), figure=energies),
        *notes_section(prediction.notes),
    )
    worst = max(zip(error.per_joint or (0.0,), joints, strict=False))
    banner = Banner(
        tone="plain",
        verdict=f"{percent(error.relative)} of the torque is not predicted",
        text=f"Most is left on {worst[1]}: {percent(worst[0])} of its torque.",
    )
    run = run_lines(prediction.band, prediction.repairs)
    return Content(f"Prediction of {prediction.robot}", lead, sections, banner, run)


def _torques(prediction: Prediction) -> Figure:
    trace, panels = prediction.torque, []
    for j, joint in enumerate(prediction.joints):
        measured, predicted = trace.measured[:, j], trace.predicted[:, j]
        series = {"measured": measured, "predicted": predicted, "residual": measured - predicted}
        panels.append(plots.Panel(joint.label, trace.t, series, f"torque, {joint.unit}"))
    return plots.line_grid(panels, title="Torque", columns=1)


def _energies(prediction: Prediction) -> Figure:
    t, shown = prediction.torque.t, {"kinetic": prediction.kinetic}
    shown["potential"] = prediction.potential
    return plots.lines(t, shown, title="Energy", xlabel="time, s", ylabel="energy, J")
