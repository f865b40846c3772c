"""What `diagnose` writes: the page of a diagnosis, and the files of its folder."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from symgen.codegen.model import derive
from symgen.codegen.package import generate
from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, FoundParameter, work
from symgen.diagnosis.reading import MARKER
from symgen.diagnosis.replay import Replay, replayed
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
from symgen.errors import SymgenError
from symgen.report.html import Banner, Section, Table, drawn, frames_section, number, page
from symgen.report.plots import diagnosis as diagnosis_plots
from symgen.robot.toml_text import parameters_toml, robot_toml


def diagnosis_files(diagnosis: Diagnosis) -> dict[str, bytes]:
    """Return what `diagnose` writes into its folder.

    Returns:
        diagnosis.json, report.html, robot.toml and parameters.toml of the extended robot, and its
        package under generated/.
    """
    model = derive(diagnosis.extended, "all")
    tree = generate(model)
    motion = None
    try:
        motion = replayed(diagnosis, model)
    except SymgenError as error:
        note = f"no motion under the measured torques: {error}"
        diagnosis = replace(diagnosis, notes=(*diagnosis.notes, note))
    files = {
        "report.html": diagnosis_page(diagnosis, motion).encode(),
        "robot.toml": robot_toml(diagnosis.extended).encode(),
        **{f"generated/{path}": content for path, content in tree.files.items()},
    }
    values = {p.name: p.value for p in diagnosis.parameters if math.isfinite(p.value)}
    if values:
        files["parameters.toml"] = parameters_toml(values.items()).encode()
    # By these names a later diagnosis knows which files of the folder it may replace.
    digests = {path: hashlib.sha256(content).hexdigest() for path, content in sorted(files.items())}
    moved = None if motion is None else motion.to_json()
    content = _finite({**diagnosis.to_json(), "replay": moved, "digests": digests})
    files[MARKER] = (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()
    return files


def _finite(value: Any) -> Any:
    """Return the value with null for every number that JSON has no word for."""
    if isinstance(value, dict):
        return {key: _finite(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def diagnosis_page(diagnosis: Diagnosis, motion: Replay | None = None) -> str:
    """Return the page: verdict, gap, effects, torques, motion, portraits, rejected, settings."""
    lead = (
        f"What the model of {diagnosis.robot} and its logs disagree about, measured on data that "
        "the search never saw.",
    )
    title = f"Diagnosis of {diagnosis.robot}"
    return page(title, lead, _sections(diagnosis, motion), _banner(diagnosis))


def _banner(diagnosis: Diagnosis) -> Banner:
    return Banner(
        tone=TONES[diagnosis.verdict],
        verdict=diagnosis.verdict.replace("-", " ").capitalize(),
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
    sections = []
    figure = diagnosis_plots.residuals(diagnosis)
    if figure is not None:
        text = "Measured minus modelled torque in the motion's band, on data the search never saw."
        sections.append(drawn("What is left", text, figure))
    sections += [_gap_section(diagnosis), *_repair_sections(diagnosis)]
    sections += _mended_sections(diagnosis)
    if diagnosis.effects:
        text = (
            "An effect is a torque on the joint. Values come from the logs, identified with all "
            "other parameters; a constant without std was searched."
        )
        sections.append(Section("Effects", (text,), _effect_table(diagnosis.effects)))
    tied = [e for e in diagnosis.effects if e.indistinguishable_from]
    if tied:
        text = "On these logs other effects would explain the same part of the gap as well."
        sections.append(Section("Not told apart", (text,), _alike_table(tied)))
    told = {tie(effect) for effect in tied}
    advice = tuple(line for line in diagnosis.advice if line not in told) + undeclared(diagnosis)
    if advice or diagnosis.effects:
        sections.append(Section("What to do", advice + _actions(diagnosis)))
    figure = diagnosis_plots.torques(diagnosis)
    if figure is not None:
        found = "with the effects that were found" if diagnosis.effects else "as it is"
        text = f"Measured, and by the model {found}; both in the motion's band."
        sections.append(drawn("Torque", text, figure))
    if motion is not None:
        sections.append(_motion_section(diagnosis, motion))
    figure = diagnosis_plots.portraits(diagnosis)
    if figure is not None:
        text = "Measured minus modelled torque before" + (
            ", and on top of it what the found effects changed. Where black covers blue nothing is "
            "left."
            if diagnosis.effects
            else ", against speed and position: a shape in it is what no effect explains."
        )
        sections.append(drawn("Portraits of the residual", text, figure))
    if diagnosis.rejected:
        text = f"The best of {diagnosis.tried} candidates that were not accepted, and why."
        rows = [(r.name, on_joints(r.joints), r.reason) for r in diagnosis.rejected]
        sections.append(Section("Rejected", (text,), _table(("effect", "on", "reason"), rows)))
    if diagnosis.notes:
        sections.append(Section("Notes", diagnosis.notes))
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
            f" As energy, over windows of {done.window:g} s, the model leaves "
            f"{percent(done.before)} of the work before and {percent(done.after)} after."
        )
    return drawn("Gap", text, diagnosis_plots.gaps(diagnosis), _gap_table(diagnosis))


def _repair_sections(diagnosis: Diagnosis) -> list[Section]:
    if not diagnosis.repairs:
        return []
    rows = [(r.channel, r.log, r.fault, str(r.samples), r.done) for r in diagnosis.repairs]
    header = ("channel", "log", "fault", "samples", "what was done")
    table = Table(header, tuple(rows), ("name", "text", "words", "number", "words"))
    text = "Mended before anything else was looked for; the search went on behind it."
    return [Section("Repairs", (text,), table)]


def _mended_sections(diagnosis: Diagnosis) -> list[Section]:
    figure = diagnosis_plots.mended(diagnosis)
    if figure is None:
        return []
    text = (
        "Around the place where the repair changed the channel most, the largest change first; a "
        "line that is missing is masked."
    )
    return [drawn("Repaired channels", text, figure)]


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
    heading = "Motion under the measured torques"
    return drawn(heading, text, diagnosis_plots.motion(diagnosis, motion), table)


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
