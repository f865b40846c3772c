"""Content of a comparison of simulated robots with logs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from symgen.experiment.playback import SimulationComparison
from symgen.report.content.parts import (
    PLAYBACK,
    Banner,
    Content,
    Section,
    horizon_by_joint,
    horizon_table,
    notes_section,
    percent,
)
from symgen.report.plots.figure import Figure, joint_panels


def simulation_content(result: SimulationComparison) -> Content:
    """Return the position errors by file and horizon and by joint, and one window."""
    first = result.files[0]
    models = [(f.file, f.horizons) for f in result.files]
    table = horizon_table(
        "file",
        models,
        {"diverged": [f"{f.diverged} of {result.windows}" for f in result.files]},
    )
    last = first.horizons[-1].seconds
    by_joint = horizon_by_joint(result.joints, models)
    moved = "replays the measured torque" + (" with feedback" if result.feedback else "")
    if result.driven_by != "torque":
        moved = f"is driven by the recorded {result.driven_by}, by the actuators of the file"
    text = (
        f"{result.windows} windows of {', '.join(result.logs)}. Each begins in the measured state "
        f"and {moved}. {PLAYBACK}",
    )
    sections = (
        Section("A window", figure=partial(_window, result)),
        Section("Position error over the horizon", text, table, printed=()),
        replace(by_joint, heading=f"Position error {by_joint.heading}"),
        *notes_section(result.notes),
    )  # fmt: skip
    best = min(result.files, key=lambda f: f.horizons[-1].position_error)
    error = percent(best.horizons[-1].position_error)
    headline = f"Position error of {best.file} after {last:g} s: {error} of the distance moved"
    others = [
        f"{f.file} {percent(f.horizons[-1].position_error)}" for f in result.files if f is not best
    ]
    banner = Banner("plain", headline, f"The others: {', '.join(others)}." if others else "")
    title = f"Simulations of {result.robot}"
    return Content(
        title, (f"How far robot files move from the logs of {result.robot}.",), sections, banner
    )


def _window(result: SimulationComparison) -> Figure | None:
    if result.measured is None:
        return None
    t, q = result.measured
    titles = [f"{joint.label}: position, {joint.place_unit}" for joint in result.joints]
    files = [f.file for f in result.files]
    series = {"measured": q, **dict(zip(files, result.courses, strict=True))}
    return Figure(tuple(joint_panels(titles, t, series)))
