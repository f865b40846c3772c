"""Content of the motions of `excite`."""

from __future__ import annotations

from functools import partial

import numpy as np

from symgen.experiment.bounds import BINDING, KEYS
from symgen.experiment.plan import Plan
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    counted,
    notes_section,
    number,
)
from symgen.report.plots.figure import Figure, Panel

_LARGEST = 10
_USES = (
    "Largest use of each limit over all runs, checked every millisecond. A limit that is used to "
    f"{100 * BINDING:g} % or more restricts the search: a wider one gives a better motion."
)
_CONDITIONS = (
    "Condition number of the equations that identify builds from these runs, columns scaled to "
    "unit norm. A smaller one is better. Search with --model NAME for the model that you will use."
)
_DEVIATIONS = (
    "Expected standard deviation of a parameter from one log of every run. The percentage compares "
    "it with the value in the prior model, or with the value that alone causes 1 % of a joint's "
    "torque limit (1 N m or N without limits) if that is larger. The search minimizes the "
    f"geometric mean of all percentages. The table lists the {_LARGEST} largest."
)
_MOTION = (
    "Position, speed and acceleration of each joint as a share of its limits: 100 % is the upper "
    "limit, -100 % the lower one. A quantity without limits is drawn in its own unit."
)
_QUANTITIES = ("rad or m", "rad/s or m/s", "rad/s2 or m/s2")


def plan_content(plan: Plan) -> Content:
    """Return verdict, use of the limits, condition numbers, motions, and notes."""
    lengths = dict.fromkeys(f"{run.duration:g}" for run in plan.runs)
    lead = (
        f"{counted(len(plan.runs), 'run')} of {', '.join(lengths)} s, from which identify can "
        f"determine the parameters of {plan.robot} with the {plan.model} model.",
    )
    done, total = plan.searches
    why = "" if plan.stopped == "done" else f"; stopped: {plan.stopped}"
    search = f"completed searches: {done} of {total}{why}"
    rows = [
        (name + (" (searched for)" if name == plan.model else ""), number(condition, 3))
        for name, condition in plan.conditions.items()
    ]
    conditions = Table(("model", "condition number"), rows)
    facts = (
        ("expected standard deviation", f"{number(100 * plan.deviation, 3)} %"),
        ("best random motion", f"{number(100 * plan.start, 3)} %"),
        (f"condition number, {plan.model} model", number(plan.condition, 3)),
        ("independent equations", f"{plan.independent:.0f} for {plan.parameters} parameters"),
    )
    banner = Banner(
        "good" if plan.good else "warn",
        _label(plan),
        "The runs keep every limit. They determine the parameters well."
        if plan.good
        else "The runs keep every limit, but a better motion is possible or needed.",
        plan.warnings,
        facts,
    )
    notes = (*plan.notes, *(f"{text}." for text in plan.other_models))
    sections = (
        Section("Motion", (_MOTION,), figure=partial(_motion, plan)),
        Section("Use of the limits", (_USES,), _uses(plan), printed=()),
        Section("Expected standard deviations", (_DEVIATIONS,), _deviations(plan), printed=()),
        Section("Condition numbers", (_CONDITIONS, search), conditions, printed=(search,)),
        *notes_section(notes),
    )
    return Content(f"Motion for {plan.robot}", lead, sections, banner)


def _label(plan: Plan) -> str:
    if not plan.optimised:
        return "not optimised"
    return "good for identification" if plan.good else "not good enough"


def _deviations(plan: Plan) -> Table:
    rows = []
    for name, share in list(plan.relative_std.items())[:_LARGEST]:
        rows.append((name, number(plan.std[name], 3), f"{number(100 * share, 3)} %"))
    return Table(("parameter", "standard deviation", "relative"), rows)


def _uses(plan: Plan) -> Table:
    keys = list(dict.fromkeys(u.limit for u in plan.uses))
    used = {(u.joint, u.limit): f"{number(100 * u.share, 3)} %" for u in plan.uses}
    labels = {joint.number: joint.label for joint in plan.joints}
    rows = [
        (labels.get(j, f"joint {j}"), *(used.get((j, key), "") for key in keys))
        for j in sorted({u.joint for u in plan.uses})
    ]
    return Table(("joint", *keys), rows)


def _motion(plan: Plan) -> Figure | None:
    """Draw position, speed and acceleration of every joint, run by run."""
    if plan.bounds is None:
        return None
    high = np.array([plan.bounds.half, *plan.bounds.rates[:2]])
    centre = np.array([plan.bounds.centre, 0 * plan.bounds.half, 0 * plan.bounds.half])
    panels = []
    for k, run in enumerate(plan.runs, 1):
        t = run.times(1 / plan.rate)
        for order, (key, unit) in enumerate(zip(KEYS, _QUANTITIES, strict=False)):
            x, limited = run.at(t, order), bool(np.isfinite(high[order]).all())
            if limited:
                x = 100 * (x - centre[order]) / high[order]
            series = {joint.label: x[:, j] for j, joint in enumerate(plan.joints)}
            if limited:
                ends = t[[0, -1, -1, 0]]  # a closed line around the allowed range
                series["limit"] = np.array([ends, [100.0, 100.0, -100.0, -100.0]])
            label = "% of the limit" if limited else unit
            log = (f"run {k}", f"{run.duration:g} s")
            panels.append(Panel(f"{key}, {label}", t, series, log))
    return Figure(tuple(panels))
