"""Content of a comparison of simulated robots with logs."""

from __future__ import annotations

from functools import partial

from symgen.experiment.playback import SimulationComparison
from symgen.report.content.parts import (
    PLAYBACK,
    Banner,
    Content,
    Section,
    Table,
    horizon_table,
    notes_section,
    percent,
)
from symgen.report.plots.figure import Figure, Panel


def simulation_content(found: SimulationComparison) -> Content:
    """Return the position errors by file and horizon and by joint, and one window."""
    first = found.files[0]
    table = horizon_table(
        "file",
        [(f.file, f.horizons) for f in found.files],
        {"diverged": [f"{f.diverged} of {found.windows}" for f in found.files]},
    )
    joints = [joint.label for joint in found.joints]
    last = first.horizons[-1].seconds
    units = ["m" if joint.unit == "N" else "rad" for joint in found.joints]
    by_joint = [
        (name, *(f"{f.horizons[-1].per_joint[j]:.3g} {units[j]}" for f in found.files))
        for j, name in enumerate(joints)
    ]
    moved = "replays the measured torque" + (" with feedback" if found.feedback else "")
    text = (
        f"{found.windows} windows of {', '.join(found.logs)}. Each begins in the measured state "
        f"and {moved}. {PLAYBACK}",
    )
    sections = (
        Section("A window", figure=partial(_window, found, joints, units)),
        Section("Position error over the horizon", text, table, told=()),
        Section(
            f"Position error by joint after {last:g} s", (),
            Table(("joint", *(f.file for f in found.files)), by_joint), told=(),
        ),
        *notes_section(found.notes),
    )  # fmt: skip
    best = min(found.files, key=lambda f: f.horizons[-1].position_error)
    left = percent(best.horizons[-1].position_error)
    said = f"Position error of {best.file} after {last:g} s: {left} of the distance moved"
    others = [
        f"{f.file} {percent(f.horizons[-1].position_error)}" for f in found.files if f is not best
    ]
    banner = Banner("plain", said, f"The others: {', '.join(others)}." if others else "")
    title = f"Simulations of {found.robot}"
    return Content(
        title, (f"How far robot files move from the logs of {found.robot}.",), sections, banner
    )


def _window(found: SimulationComparison, joints: list[str], units: list[str]) -> Figure | None:
    if found.measured is None:
        return None
    t, q = found.measured
    panels = []
    for j, (name, unit) in enumerate(zip(joints, units, strict=True)):
        series = {"measured": q[:, j]}
        series |= {f.file: c[:, j] for f, c in zip(found.files, found.courses, strict=True)}
        panels.append(Panel(f"{name}: position, {unit}", t, series))
    return Figure(tuple(panels))
