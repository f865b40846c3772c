"""The page of a prediction: measured and predicted torque of a log, and the model's energy."""

from __future__ import annotations

from symgen.identification.prediction import Prediction
from symgen.report.html import Banner, Section, Table, drawn, number, page, percent
from symgen.report.plots import curves as plots


def prediction_page(prediction: Prediction) -> str:
    """Return the page: error of the torque per joint, curves, energies, notes."""
    trace, error = prediction.torque, prediction.error
    lead = (f"What the model of {prediction.robot} with given parameters says of {trace.log}.",)
    joints = [f"joint {joint}" for joint, _ in prediction.joints]
    rows = [*zip(joints, map(percent, error.per_joint or ()), strict=True)]
    table = Table(("", "error"), (*rows, ("all", percent(error.relative))), ("name", "number"))
    text = (
        "RMS of measured minus predicted over RMS of measured torque; in all that of all joints "
        "together."
    )
    panels = []
    for j, (joint, unit) in enumerate(prediction.joints):
        measured, predicted = trace.measured[:, j], trace.predicted[:, j]
        series = {"measured": measured, "predicted": predicted, "residual": measured - predicted}
        panels.append(plots.Panel(f"joint {joint}", trace.t, series, f"torque, {unit}"))
    figure = plots.line_grid(panels, title="Torque", columns=1)
    told = (
        f"{text} Both have passed the same zero-phase low-pass at "
        f"{number(prediction.band.comparison_hz)} Hz, positions and speeds one at "
        f"{number(prediction.band.cutoff_hz)} Hz."
    )
    sections = [drawn("Measured and predicted torque", told, figure, table)]
    energies = {"kinetic": prediction.kinetic, "potential": prediction.potential}
    figure = plots.lines(trace.t, energies, title="Energy", xlabel="time, s", ylabel="energy, J")
    sections.append(drawn("Energy", "Potential energy is known up to a constant.", figure))
    if prediction.notes:
        sections.append(Section("Notes", prediction.notes))
    worst = max(zip(error.per_joint or (0.0,), joints, strict=False))
    banner = Banner(
        tone="plain",
        verdict=f"{percent(error.relative, 3)} of the torque is not predicted",
        text=f"Most is left on {worst[1]}: {percent(worst[0], 3)} of its torque.",
    )
    return page(f"Prediction of {prediction.robot}", lead, sections, banner)
