"""Content of a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from dataclasses import replace
from functools import partial

from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, FoundParameter
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
    frames_section,
    notes_section,
    number,
    percent,
    repairs_section,
    value_with_std,
)
from symgen.report.plots import diagnosis as diagnosis_plots
from symgen.robot.effect import definitions

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
    gaps = (
        ("torque error before", d.gaps.before),
        ("torque error after", d.gaps.after),
        ("noise floor", d.gaps.noise_floor),
    )
    facts = tuple((label, percent(gap.total)) for label, gap in gaps)
    facts += (("candidates tried", str(d.tried)),)
    named = describe_effects([e for e in d.effects if e.adopted], d.extended)
    return Banner(TONES[d.verdict], d.verdict, "", named, facts, summary(d))


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


def _gap_section(diagnosis: Diagnosis) -> Section:
    text = (
        "The torque error is the RMS of measured minus modelled torque over the RMS of the "
        "measured torque. The noise floor is the error that the sensor noise alone would cause."
    )
    return Section("Torque error by joint", (text,), _gap_table(diagnosis), printed=())


def _gap_table(d: Diagnosis) -> Table:
    where, rows = {p.joint: p for p in d.where}, []
    gaps = d.gaps.before, d.gaps.after, d.gaps.noise_floor
    for k, joint in enumerate(d.joints):
        place = where.get(joint)
        told = ("", "") if place is None else (f"{100 * place.share:.0f} %", place.pattern)
        rows.append((d.extended.labels[joint], *(percent(gap.per_joint[k]) for gap in gaps), *told))
    rows.append(("all", *(percent(gap.total) for gap in gaps), "", ""))
    if d.gaps.before != d.before:
        whole = d.before, d.after, d.floor
        rows.append(("all samples", *(percent(gap.total) for gap in whole), "", ""))
    return Table(("", "before", "after", "noise floor", "share", "depends on"), rows)


def _effect_table(d: Diagnosis) -> Table:
    rows = []
    for effect in d.effects:
        first = (effect.name, ", ".join(map(str, effect.joints)) or "all")
        sure = f"{effect.probability:.2f}, {grade(effect)}"
        last = (percent(effect.gap_reduction), sure, effect.expression + _at_rest(effect, d))
        found: Sequence[FoundParameter | None] = effect.parameters or (None,)
        for k, p in enumerate(found):
            cells = ("", "", "", "") if p is None else (p.name, *_value(p), p.unit)
            rows.append((*(first if k == 0 else ("", "")), *cells, *(last if k == 0 else [""] * 3)))
    header = (
        "effect",
        "joint",
        "parameter",
        "value",
        "std",
        "unit",
        "closes",
        "probability",
        "torque",
    )
    return Table(header, rows)


def _at_rest(effect: FoundEffect, d: Diagnosis) -> str:
    """Return the position q0 at which a spring has no torque, K (q - q0) = K q + OF; or ''."""
    known = definitions().get(effect.name)
    if known is None or not known.offset or len(known.linear) != 1 or not effect.parameters:
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
