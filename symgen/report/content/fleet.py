"""What is said of a fleet."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from symgen.diagnosis.fleet import Finding, Fleet
from symgen.diagnosis.robot_days import courses_of
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

_MOST = 12  # trends that are drawn


def fleet_content(found: Fleet) -> Content:
    """Return what changed, what stands out, trends, every day."""
    robots = list(dict.fromkeys(e.robot for e in found.estimates))
    lead = (
        f"{counted(len(robots), 'robot')} of the model {found.robot}, an estimate for each of "
        f"{counted(len(found.estimates), 'day')}.",
    )
    all_findings = (*found.changes, *found.outliers)
    says = tuple(f"{f.robot}: {f.says} since {f.since}" for f in all_findings)
    banner = Banner(
        tone="warn" if all_findings else "good",
        verdict="changed" if all_findings else "steady",
        text="" if all_findings else "No robot changed, and none stands out.",
        reasons=says,
        facts=(("changes", str(len(found.changes))), ("outliers", str(len(found.outliers)))),
    )
    sections = [
        Section(heading, (text,), _findings(findings), told=())
        for heading, text, findings in (
            ("Changes", "Since when, with p corrected for all that was looked at.", found.changes),
            ("Outliers", "Robots that were others from their first day on.", found.outliers),
        )
        if findings
    ]
    trends = "What moved, day by day; the band is two standard deviations."
    errors = partial(_errors, found, robots)
    sections += [
        Section("Trends", (trends,), figure=partial(_trends, found)),
        Section("Torque error", ("On held-out motion of every day.",), figure=errors),
        Section("Days", (), _days(found)),
        *notes_section(found.notes),
    ]
    return Content(f"Fleet of {found.robot}", lead, tuple(sections), banner)


def _findings(findings: tuple[Finding, ...]) -> Table:
    rows = []
    for f in findings:
        joints = ", ".join(map(str, f.joints))
        values = ", ".join(f"{n} {number(v, 3)} ± {number(s, 1)}" for n, v, s in f.parameters)
        rows.append((f.robot, f.since, f.says, f.effect, joints, values, number(f.p_value, 2)))
    head = ("robot", "since", "what", "effect", "joints", "values", "p")
    return Table(head, tuple(rows), ("name", "name", "words", "name", "name", "words", "number"))


def _trends(found: Fleet) -> Figure | None:
    """Draw the parameters that moved, day by day, with two standard deviations."""
    courses = {c.robot: c for c in courses_of(found.estimates)}
    panels: list[plots.Panel] = []
    for f in (*found.changes, *found.outliers):
        course = courses.get(f.robot)
        names = [n for n, _, _ in f.parameters if n in found.names]
        for name in names[:2]:
            if course is None or len(panels) == _MOST:
                continue
            k = found.names.index(name)
            x = np.arange(1.0, len(course.days) + 1)
            y, std = course.X[:, k], np.sqrt(course.variance[:, k])
            band = (y - 2 * std, y + 2 * std)
            panels.append(plots.Panel(f"{f.robot}, {name}", x, {name: y}, name, band=band))
    if not panels:
        return None
    figure = plots.line_grid(panels, title="Trends", xlabel="day").update_layout(showlegend=False)
    return figure.update_xaxes(dtick=_every(max(len(panel.x) for panel in panels)))


def _errors(found: Fleet, robots: list[str]) -> Figure:
    """Draw the torque error of every robot by day."""
    longest = max(sum(e.robot == r for e in found.estimates) for r in robots)
    x = np.arange(1.0, longest + 1)
    series = {}
    for r in robots:
        values = [100 * e.torque if math.isfinite(e.torque) else math.nan
                  for e in found.estimates if e.robot == r]  # fmt: skip
        series[r] = np.array([*values, *[math.nan] * (longest - len(values))])
    figure = plots.lines(
        x, series, title="Torque error", xlabel="day", ylabel="torque error, %", height=420
    )
    return figure.update_xaxes(dtick=_every(longest))


def _every(days: int) -> int:
    """Return the whole number of days between two ticks."""
    return max(1, -(-days // 12))


def _days(found: Fleet) -> Table:
    rows = tuple(
        (
            e.robot,
            e.day,
            percent(e.torque, 3) if math.isfinite(e.torque) else "-",
            e.verdict,
        )
        for e in found.estimates
    )
    return Table(
        ("robot", "day", "torque error", "verdict"), rows, ("name", "name", "number", "name")
    )
