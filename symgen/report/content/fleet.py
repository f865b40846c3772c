"""Content of a fleet."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from symgen.diagnosis.drift import Finding
from symgen.diagnosis.fleet import Fleet, courses_of
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    counted,
    notes_section,
    number,
    percent,
)
from symgen.report.plots import curves as plots

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_MOST = 12  # largest number of trends in the plot


def fleet_content(found: Fleet) -> Content:
    """Return changes, outliers, trends, and all days."""
    robots = list(dict.fromkeys(e.robot for e in found.estimates))
    lead = (
        f"{counted(len(robots), 'robot')} of the model {found.robot}, an estimate for each of "
        f"{counted(len(found.estimates), 'day')}.",
    )
    says = tuple(f"{f.robot}: {f.says} since {f.since}" for f in (*found.changes, *found.outliers))
    facts = (("changes", str(len(found.changes))), ("outliers", str(len(found.outliers))))
    banner = Banner("good", "steady", "No robot changed, and there are no outliers.", facts=facts)
    if says:
        banner = Banner("warn", "changed", "", says, facts)
    days = [
        (e.robot, e.day, percent(e.torque) if math.isfinite(e.torque) else "-", e.verdict)
        for e in found.estimates
    ]
    changes = "Since when, with p corrected for all that was looked at."
    outliers = "Robots that differ from the fleet from their first day on."
    trends = "Parameters that moved, for each day; the band is two standard deviations."
    errors = partial(_errors, found, robots)
    sections = (
        Section("Changes", (changes,), _findings(found.changes), told=()),
        Section("Outliers", (outliers,), _findings(found.outliers), told=()),
        Section("Trends", (trends,), figure=partial(_trends, found)),
        Section("Torque error", ("On held-out motion of every day.",), figure=errors),
        Section("Days", (), Table(("robot", "day", "torque error", "verdict"), days)),
        *notes_section(found.notes),
    )
    return Content(f"Fleet of {found.robot}", lead, sections, banner)


def _findings(findings: tuple[Finding, ...]) -> Table:
    rows = []
    for f in findings:
        joints = ", ".join(map(str, f.joints))
        values = ", ".join(f"{n} {number(v, 3)} ± {number(s, 1)}" for n, v, s in f.parameters)
        rows.append((f.robot, f.since, f.says, f.effect, joints, values, number(f.p_value, 2)))
    return Table(("robot", "since", "what", "effect", "joints", "values", "p"), rows)


def _trends(found: Fleet) -> Figure | None:
    """Draw the parameters that moved, day by day, with two standard deviations."""
    courses = {c.robot: c for c in courses_of(found.estimates)}
    panels = []
    for f in (*found.changes, *found.outliers):
        course, names = courses.get(f.robot), [n for n, _, _ in f.parameters if n in found.names]
        for name in names[:2]:
            if course is None:
                continue
            k, x = found.names.index(name), np.arange(1.0, len(course.days) + 1)
            y, spread = course.X[:, k], 2 * np.sqrt(course.variance[:, k])
            title, band = f"{f.robot}, {name}", (y - spread, y + spread)
            panels.append(plots.Panel(title, x, {name: y}, name, band=band))
    panels = panels[:_MOST]
    if not panels:
        return None
    figure = plots.line_grid(panels, title="Trends", xlabel="day").update_layout(showlegend=False)
    return figure.update_xaxes(dtick=_every(max(len(panel.x) for panel in panels)))


def _errors(found: Fleet, robots: list[str]) -> Figure:
    """Draw the torque error of every robot by day."""
    own = {r: [100 * e.torque for e in found.estimates if e.robot == r] for r in robots}
    longest = max(map(len, own.values()))
    series = {r: np.full(longest, np.nan) for r in robots}
    for r, values in own.items():
        series[r][: len(values)] = np.where(np.isfinite(values), values, np.nan)
    days, label = np.arange(1.0, longest + 1), "torque error, %"
    figure = plots.lines(days, series, title="Torque error", xlabel="day", ylabel=label, height=420)
    return figure.update_xaxes(dtick=_every(longest))


def _every(days: int) -> int:
    """Return the whole number of days between two ticks."""
    return max(1, -(-days // 12))
