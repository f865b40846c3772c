"""Content of a prediction: measured and predicted torque of a log, and the energy of the model."""

from __future__ import annotations

from functools import partial

from symgen.estimation.floor import noise_accounts
from symgen.estimation.torque_error import largest
from symgen.identification.estimate import equation_titles
from symgen.identification.prediction import Prediction
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    error_table,
    notes_section,
    number,
    percent,
    repairs_section,
    run_lines,
)
from symgen.report.plots.figure import Figure, Panel, joint_panels

_ERROR = (
    "The error is the RMS of measured minus predicted torque of joints in motion. The percentage "
    "is its ratio to the RMS of the measured torque. The noise floor is the error that the noise "
    "of the log alone would cause."
)


def prediction_content(prediction: Prediction) -> Content:
    """Return the torque error of each joint, the curves, the energies and notes."""
    trace, moving, band = prediction.torque, prediction.moving, prediction.band
    lead = (
        f"Torque of the model of {prediction.robot} along {trace.log}, and the measured torque.",
    )
    labels = [joint.label for joint in prediction.joints]
    units = [joint.unit for joint in prediction.joints]
    ratios = moving.per_joint or ()
    errors = {"error": moving, "noise floor": prediction.noise}
    table = error_table(prediction.joints, trace.measured, errors)
    total, noise = moving.relative, prediction.noise.relative
    filters = (
        f"Both torques passed the same zero-phase low-pass at {number(band.comparison_hz, 3)} Hz, "
        f"positions and speeds one at {number(band.cutoff_hz, 3)} Hz."
    )
    torques, energies = partial(_torques, prediction), partial(_energies, prediction)
    sections = (
        Section("Measured and predicted torque", (filters,), figure=torques),
        Section("Torque error by joint", (_ERROR,), table, printed=()),
        Section(
            "Energy",
            ("Potential energy is known up to a constant.",),
            figure=energies,
            folded=True,
        ),
        repairs_section(prediction.repairs),
        *notes_section(prediction.notes),
    )
    text = f"{noise_accounts(noise, total).capitalize()}."
    if ratios:
        measured = trace.measured[:, -len(labels) :]
        text = f"It is largest on {largest(ratios, measured, labels, units)}. {text}"
    banner = Banner("plain", f"Torque error: {percent(total)}", text)
    run = run_lines(band, prediction.repairs)
    return Content(f"Prediction of {prediction.robot}", lead, sections, banner, run)


def _torques(prediction: Prediction) -> Figure:
    t, titles = prediction.torque, equation_titles(prediction.joints, prediction.moving)
    series = {"measured": t.measured, "predicted": t.predicted, "residual": t.residual}
    return Figure(tuple(joint_panels(titles, t.t, series)))


def _energies(prediction: Prediction) -> Figure:
    shown = {"kinetic": prediction.kinetic, "potential": prediction.potential}
    return Figure((Panel("energy, J", prediction.torque.t, shown),))
