"""What is said of a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, FoundParameter, work
from symgen.diagnosis.replay import Replay
from symgen.diagnosis.words import (
    TONES,
    alike,
    on_joints,
    percent,
    placed,
    summary,
    tie,
    told_once,
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
)
from symgen.report.plots import diagnosis as diagnosis_plots

_MENDED = (
    "Around the place where the repair changed the channel most, the largest change first; a line "
    "that is missing is masked."
)


def diagnosis_content(diagnosis: Diagnosis, motion: Replay | None = None) -> Content:
    """Return verdict, gap, effects, torques, motion, portraits, rejected, settings."""
    lead = (
        f"What the model of {diagnosis.robot} and its logs disagree about, measured on data that "
        "the search never saw.",
    )
    title = f"Diagnosis of {diagnosis.robot}"
    return Content(title, lead, tuple(_sections(diagnosis, motion)), _banner(diagnosis))


def _banner(diagnosis: Diagnosis) -> Banner:
    return Banner(
        tone=TONES[diagnosis.verdict],
        verdict=diagnosis.verdict,
        text=summary(diagnosis),
        reasons=told_once(diagnosis.effects),
        facts=(
            ("gap before", percent(diagnosis.before.total)),
            ("gap after", percent(diagnosis.after.total)),
            ("noise floor", percent(diagnosis.floor.total)),
            ("candidates tried", str(diagnosis.tried)),
        ),
    )


def _sections(diagnosis: Diagnosis, motion: Replay | None) -> list[Section]:
    text = "Measured minus modelled torque in the motion's band, on data the search never saw."
    mended = partial(diagnosis_plots.mended, diagnosis)
    sections = [
        Section("What is left", (text,), figure=partial(diagnosis_plots.residuals, diagnosis)),
        _gap_section(diagnosis),
        *_repair_sections(diagnosis),
        Section("Repaired channels", (_MENDED,), figure=mended),
    ]
    if diagnosis.effects:
        text = (
            "An effect is a torque on the joint. Values come from the logs, identified with all "
            "other parameters; a constant without std was searched."
        )
        sections.append(Section("Effects", (text,), _effect_table(diagnosis.effects), told=()))
    tied = [e for e in diagnosis.effects if e.indistinguishable_from]
    if tied:
        text = "On these logs other effects would explain the same part of the gap as well."
        sections.append(Section("Not told apart", (text,), _alike_table(tied)))
    told = {tie(effect) for effect in tied}
    advice = tuple(line for line in diagnosis.advice if line not in told) + undeclared(diagnosis)
    if advice or diagnosis.advice or diagnosis.effects:
        next_ = (*diagnosis.advice, *undeclared(diagnosis), *_actions(diagnosis))
        lines = tuple(f"next: {line}" for line in next_)
        sections.append(Section("What to do", advice + _actions(diagnosis), told=lines))
    found = "with the effects that were found" if diagnosis.effects else "as it is"
    text = f"Measured, and by the model {found}; both in the motion's band."
    figure = partial(diagnosis_plots.torques, diagnosis)
    sections.append(Section("Torque", (text,), figure=figure))
    if motion is not None:
        sections.append(_motion_section(diagnosis, motion))
    text = "Measured minus modelled torque before" + (
        ", and on top of it what the found effects changed. Where black covers blue nothing is "
        "left."
        if diagnosis.effects
        else ", against speed and position: a shape in it is what no effect explains."
    )
    figure = partial(diagnosis_plots.portraits, diagnosis)
    sections.append(Section("Portraits of the residual", (text,), figure=figure))
    if diagnosis.rejected:
        text = f"The best of {diagnosis.tried} candidates that were not accepted, and why."
        rows = [(r.name, on_joints(r.joints), r.reason) for r in diagnosis.rejected]
        sections.append(Section("Rejected", (text,), _table(("effect", "on", "reason"), rows)))
    sections += notes_section(diagnosis.notes)
    sections.append(Section("Settings", table=_settings(diagnosis)))
    if diagnosis.parameters:
        text = "All parameters of the extended robot; parameters.toml holds them."
        sections.append(Section("Parameters", (text,), _parameter_table(diagnosis.parameters)))
    return [*sections, frames_section(diagnosis.extended)]


def _actions(diagnosis: Diagnosis) -> tuple[str, ...]:
    """The commands that come next."""
    out = []
    if any(effect.indistinguishable_from for effect in diagnosis.effects):
        out.append(
            "symgen excite robot.toml --into motion.csv writes a motion over the whole [limits]; "
            "record it, and diagnose again with both logs."
        )
    if any(effect.declared for effect in diagnosis.effects):
        out.append(
            "symgen identify robot.toml LOG --into result, with the robot.toml beside this page, "
            "which declares what was found."
        )
    return tuple(out)


def _gap_section(diagnosis: Diagnosis) -> Section:
    text = (
        "RMS of measured minus modelled torque over RMS of measured torque, in the band of the "
        "motion. The noise floor is what noise of torque, position and speed alone leaves there."
    )
    done = work(diagnosis.curves)
    if done is not None:
        text += (
            f" As energy, over windows of {done.window_s:g} s, the model leaves "
            f"{percent(done.before)} of the work before and {percent(done.after)} after."
        )
    figure = partial(diagnosis_plots.gaps, diagnosis)
    return Section("Gap", (text,), _gap_table(diagnosis), figure, told=())


def _repair_sections(diagnosis: Diagnosis) -> list[Section]:
    if not diagnosis.repairs:
        return []
    rows = [(r.channel, r.log, r.fault, str(r.samples), r.done) for r in diagnosis.repairs]
    header = ("channel", "log", "fault", "samples", "what was done")
    table = Table(header, tuple(rows), ("name", "text", "words", "number", "words"))
    text = "Mended before anything else was looked for; the search went on behind it."
    return [Section("Repairs", (text,), table)]


def _motion_section(diagnosis: Diagnosis, motion: Replay) -> Section:
    text = (
        f"Simulated minus measured position where the gap before is largest, on {motion.log}: each "
        "model is moved by the measured torques, and a feedback of 1 Hz holds it to the measured "
        "motion, so that what a model misses shows as a distance."
    )
    if motion.left_out:
        text += f" No part in it has what robot.toml does not hold: {', '.join(motion.left_out)}."
    pairs = zip(diagnosis.joints, *motion.rms, motion.units, strict=True)
    rows = tuple((f"joint {j}", number(a, 3), number(b, 3), unit) for j, a, b, unit in pairs)
    header = ("RMS distance", "before", "after", "unit")
    table = Table(header, rows, ("name", "number", "number", "unit"))
    figure = partial(diagnosis_plots.motion, diagnosis, motion)
    return Section("Motion under the measured torques", (text,), table, figure)


def _table(header: Sequence[str], rows: Sequence[tuple[str, ...]]) -> Table:
    """Return a table of texts whose first column holds names."""
    return Table(tuple(header), tuple(rows), ("name", *("text",) * (len(header) - 1)))


def _gap_table(diagnosis: Diagnosis) -> Table:
    where = {p.joint: p for p in diagnosis.where}
    columns = [g.per_joint for g in (diagnosis.before, diagnosis.after, diagnosis.floor)]
    rows = []
    for k, joint in enumerate(diagnosis.joints):
        place = where.get(joint)
        told = ("", "") if place is None else (f"{100 * place.share:.0f} %", place.pattern)
        rows.append((f"joint {joint}", *(percent(c[k]) for c in columns), *told))
    totals = (diagnosis.before, diagnosis.after, diagnosis.floor)
    rows.append(("all", *(percent(g.total) for g in totals), "", ""))
    header = ("", "before", "after", "noise floor", "share", "organised by")
    return Table(header, tuple(rows), ("name", *("number",) * 4, "text"))


def _effect_table(effects: Sequence[FoundEffect]) -> Table:
    rows = []
    for effect in effects:
        first = (effect.name, ", ".join(map(str, effect.joints)) or "all")
        last = (percent(effect.gap_reduction), f"{effect.p_value:.1g}", effect.expression)
        found: Sequence[FoundParameter | None] = effect.parameters or (None,)
        for k, p in enumerate(found):
            cells = ("", "", "", "") if p is None else (p.name, number(p.value), _std(p), p.unit)
            rows.append((*(first if k == 0 else ("", "")), *cells, *(last if k == 0 else [""] * 3)))
    header = ("effect", "joint", "parameter", "value", "std", "unit", "closes", "p", "torque")
    styles = ("name", "unit", "unit", "number", "number", "unit", "number", "number", "formula")
    return Table(header, tuple(rows), styles)


def _alike_table(effects: Sequence[FoundEffect]) -> Table:
    rows = [(placed(e), alike(e), e.separate) for e in effects]
    return _table(("effect", "looks like", "motion that would tell them apart"), rows)


def _parameter_table(parameters: Sequence[FoundParameter]) -> Table:
    rows = tuple((p.name, number(p.value), _std(p), p.unit) for p in parameters)
    return Table(("name", "value", "std", "unit"), rows, ("name", "number", "number", "unit"))


def _std(p: FoundParameter) -> str:
    return number(p.std, 2) if math.isfinite(p.std) else "searched"


def _settings(diagnosis: Diagnosis) -> Table:
    cutoff = diagnosis.cutoff_hz
    rows = (
        ("robot", diagnosis.robot),
        ("band of the motion", "no filter" if cutoff is None else f"up to {number(cutoff, 4)} Hz"),
        ("gap shown on", ", ".join(c.name for c in diagnosis.curves) or "-"),
        ("candidates tried", str(diagnosis.tried)),
    )
    return Table(("item", "value"), rows)
