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
from symgen.report.plots.figure import Figure, joint_panels
from symgen.report.plots.robot import drawing

_LARGEST = 10
_LIMITS = {"upper limit": 100.0, "lower limit": -100.0}
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
    "Position, velocity and acceleration of each joint as a share of its limits, which are dashed. "
    "An acceleration without limits is not drawn."
)
_ARM = (
    "The arm after 10, 30, 50, 70 and 90 % of the first run, from light to dark. The z axis of "
    "frame 0 points up. Revolute joints are circles, prismatic ones squares. The end is the x axis "
    "of the last frame."
)


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
        Section("Arm", (_ARM,), picture=_arm(plan)),
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


def _arm(plan: Plan) -> str:
    """Draw the arm at five moments of the first run."""
    numbers, run = [joint.number for joint in plan.joints], plan.runs[0]
    q = run.at(run.duration * np.linspace(0.1, 0.9, 5))  # a run ends where it begins
    moments = [dict(zip(numbers, each, strict=True)) for each in q.tolist()]
    return "" if plan.source is None else drawing(plan.source, *moments)


def _motion(plan: Plan) -> Figure | None:
    """Draw the motion of every joint within its limits, run by run."""
    if plan.bounds is None:
        return None
    high = np.array([plan.bounds.half, *plan.bounds.rates[:2]])
    titles, panels = [f"{joint.label}, % of its limits" for joint in plan.joints], []
    for k, run in enumerate(plan.runs, 1):
        t = run.times(1 / plan.rate)
        motion = [run.at(t) - plan.bounds.centre, run.at(t, 1), run.at(t, 2)]
        shares = {key: 100 * x / top for key, x, top in zip(KEYS, motion, high, strict=False)}
        series = {key: x for key, x in shares.items() if x.any()}
        series |= {key: np.full_like(motion[0], top) for key, top in _LIMITS.items()}
        panels += joint_panels(titles, t, series, (f"run {k}", f"{run.duration:g} s"))
    return Figure(tuple(panels))
