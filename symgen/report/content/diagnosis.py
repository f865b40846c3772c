"""Content of a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import replace
from functools import partial

from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, FoundParameter, Gaps
from symgen.diagnosis.messages import (
    TONES,
    alike,
    describe_effects,
    grade,
    on_joints,
    placed,
    summary,
    tie,
    undeclared,
)
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    base_rows,
    frames_section,
    notes_section,
    number,
    percent,
    repairs_section,
    value_with_std,
)
from symgen.report.plots import diagnosis as diagnosis_plots
from symgen.robot.effect import described

_RESIDUAL = "Measured minus modelled torque in the motion's band, on data the search never saw."
_EFFECTS = (
    "An effect is a torque on the joint. symgen fits its values together with all other "
    "parameters. Constants without std come from a search."
)
_DEPENDS = (
    "Measured minus modelled torque at the joints with most of the torque error, {}. Each dot is a "
    "sample that the search never saw. A pattern is a torque that the model lacks."
)
_MENDED = (
    "A channel of each repair around its largest change, the largest one first: as recorded, then "
    "as repaired, each at its own scale. Masked samples are missing from the line."
)


def diagnosis_content(diagnosis: Diagnosis) -> Content:
    """Return verdict, effects, torque error, plots, rejected effects and settings."""
    lead = (
        f"Torque that the model of {diagnosis.robot} does not explain, on logs that the search for "
        "effects did not use.",
    )
    title = f"Diagnosis of {diagnosis.robot}"
    return Content(title, lead, tuple(_sections(diagnosis)), _banner(diagnosis))


def _banner(d: Diagnosis) -> Banner:
    labels = "torque error before", "torque error after", "noise floor", "candidates tried"
    facts = tuple(zip(labels, (*_totals(d.gaps), str(d.tried)), strict=True))
    named = describe_effects([e for e in d.effects if e.adopted], d.extended)
    return Banner(TONES[d.verdict], d.verdict, "", named, facts, summary(d))


def _totals(gaps: Gaps) -> tuple[str, ...]:
    """Return the totals before and after, and of the noise floor."""
    return tuple(percent(gap.total) for gap in (gaps.before, gaps.after, gaps.noise_floor))


def _sections(d: Diagnosis) -> list[Section]:
    tied = [e for e in d.effects if e.indistinguishable_from]
    alikes = [(placed(e, d.extended), alike(e, d.extended), e.separate) for e in tied]
    rejected = [(r.name, on_joints(r.joints, d.extended), r.reason) for r in d.rejected]
    found = [(p.name, *_value(p), p.unit) for p in d.parameters]
    changed = any(effect.adopted for effect in d.effects)
    models = "before and after the effects were added" if changed else "as it is"
    front = (
        Section(
            "Residual over what it depends on",
            (_DEPENDS.format(models),),
            figure=partial(diagnosis_plots.dependences, d),
        ),
        Section(
            "Torque",
            (f"Measured, and by the model {models}, in the motion's band.",),
            figure=partial(diagnosis_plots.torques, d),
        ),
        Section("Effects", (_EFFECTS,), _effect_table(d), printed=()),
        _gap_section(d),
        _advice_section(d, {*(tie(e, d.extended) for e in tied)}),
    )
    details = (
        Section(
            "Residual of every joint", (_RESIDUAL,), figure=partial(diagnosis_plots.residuals, d)
        ),
        repairs_section(d.repairs),
        Section("Repaired channels", (_MENDED,), figure=partial(diagnosis_plots.repaired, d)),
        Section(
            "Effects that these logs cannot distinguish",
            ("Other effects would explain the same torque as well.",),
            Table(("effect", "or", "motion that would distinguish them"), alikes),
        ),
        Section(
            "Rejected",
            (f"The best of {d.tried} candidates that were not accepted, and why.",),
            Table(("effect", "on", "reason"), rejected),
        ),
        *notes_section([note for note in d.notes if note not in d.advice]),
        Section("Settings", table=_settings(d)),
        Section(
            "Parameters",
            ("All parameters of the extended robot, as in parameters.toml.",),
            Table(("name", "value", "std", "unit"), found),
        ),
        frames_section(d.extended),
    )
    return [*front, *(replace(section, folded=True) for section in details)]


def _advice_section(d: Diagnosis, effect_lines: Container[str]) -> Section:
    more = undeclared(d)
    lines = tuple(f"note: {line}" for line in (*d.advice, *more))
    text = [*(line for line in d.advice if line not in effect_lines), *more]
    if any(effect.declared for effect in d.effects):
        text.append(
            "Identify the robot.toml next to this page with the same logs: it declares the named "
            "effects."
        )
    if d.command:
        text.append(d.command)
    return Section("What to do", tuple(text), printed=lines)


def _gap_section(d: Diagnosis) -> Section:
    text = (
        "The torque error is the RMS of measured minus modelled torque over the RMS of the "
        "measured torque. The noise floor is the error that the sensor noise alone would cause."
    )
    gaps = d.gaps
    errors = gaps.before, gaps.after, gaps.noise_floor
    by_joint = zip(*(gap.per_joint for gap in errors), strict=True)
    told = {p.joint: (f"{100 * p.share:.0f} %", p.pattern) for p in d.where}
    rows = []
    for joint, ratios in zip(d.joints, by_joint, strict=True):
        label, more = d.extended.labels[joint], told.get(joint, ("", ""))
        rows.append((label, *map(percent, ratios), *more))
    rows = [(*row, "", "") for row in base_rows(errors)] + rows
    rows.append(("all", *_totals(gaps), "", ""))
    if gaps.before != d.before:
        whole = Gaps(d.before, d.after, d.floor)
        rows.append(("all samples", *_totals(whole), "", ""))
    table = Table(("", "before", "after", "noise floor", "share", "depends on"), rows)
    return Section("Torque error by joint", (text,), table, printed=())


def _effect_table(d: Diagnosis) -> Table:
    rows = []
    for effect in d.effects:
        first = (effect.name, ", ".join(map(str, effect.joints)) or "all")
        sure = f"{effect.probability:.2f}, {grade(effect)}"
        last = (percent(effect.gap_reduction), sure, effect.expression + _at_rest(effect, d))
        cells = [(p.name, *_value(p), p.unit) for p in effect.parameters]
        for values in cells or [("",) * 4]:
            rows.append((*first, *values, *last))
            first, last = ("",) * 2, ("",) * 3
    header = ("effect", "joint", "parameter", "value", "std", "unit")
    return Table((*header, "closes", "probability", "torque"), rows)


def _at_rest(effect: FoundEffect, d: Diagnosis) -> str:
    """Return the position q0 at which a spring has no torque, K (q - q0) = K q + OF; or ''."""
    known = described(effect.name)
    if not known.offset or len(known.linear) != 1 or not effect.parameters:
        return ""  # a suspected effect has no known value
    k = effect.parameters[0]
    names = [f"OF{joint}" for joint in effect.joints]
    offsets = (p.value for p in d.parameters if p.name in names)
    value = -next(offsets, math.nan) / (k.value or math.nan)
    unit = k.unit.rpartition("/")[2]
    return f", q0 = {number(value, 4)} {unit}" if math.isfinite(value) else ""


def _value(p: FoundParameter) -> tuple[str, str]:
    value, std = value_with_std(p.value, p.std)
    return value, std if math.isfinite(p.std) else "searched"


def _settings(diagnosis: Diagnosis) -> Table:
    cutoff = diagnosis.cutoff_hz
    rows = (
        ("robot", diagnosis.robot),
        ("band of the motion", "no filter" if cutoff is None else f"up to {number(cutoff, 4)} Hz"),
        ("torque error measured on", ", ".join(c.name for c in diagnosis.curves) or "-"),
        ("candidates tried", str(diagnosis.tried)),
    )
    return Table(("item", "value"), rows)
