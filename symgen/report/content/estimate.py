"""Content of an estimate."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from symgen.errors import first_of
from symgen.identification.estimate import Estimate, Identifiable, ParameterEstimate
from symgen.identification.uses import KNOWN
from symgen.report.content.parts import (
    PLAYBACK,
    Banner,
    Content,
    Section,
    Table,
    counted,
    error_table,
    frames_section,
    horizon_by_joint,
    horizon_table,
    notes_section,
    number,
    percent,
    repairs_section,
    run_lines,
    value_with_std,
)
from symgen.report.folded import folded
from symgen.report.plots import curves as plots

if TYPE_CHECKING:
    from symgen.estimation.values import Residual
    from symgen.robot.types import Robot

_SPECTRUM = {
    "energy": "The spectrum of white noise has notches at multiples of 1/T, for windows of length "
    "T. A peak is motion that the model does not explain.",
    "torque": "Both torques have passed the same low-pass (see Notes). A peak below its cutoff is "
    "motion that the model does not explain.",
}
_TORQUES = (
    "Measured and modelled torque passed the same low-pass. The thin grey line is the measured "
    "torque without it. The fit did not use the validation logs."
)
_ERROR = (
    "The error is the RMS of measured minus modelled torque. The percentage is its ratio to the "
    "RMS of the measured torque. Held-out data are those that the fit did not use. If joints stand "
    "still at times, their error in motion comes first: at rest, static friction can take any "
    "value."
)
_KNOWN = f"The standard deviation is at most {KNOWN:g} % of the value."
_COLUMNS = ("name", "value", "std", "relative std", "unit")
_FORMULAS = "Each base parameter in the standard parameters of the links; M3 + ... + M7 is a sum."
_MODELS = (
    "symgen fits all models to the same filtered logs. It keeps the one with the smallest torque "
    "error on folds of the training logs that the fit did not use."
)
_SUSPECTED = "What may be wrong but is not certain. It changes no verdict."
_DRIVES = (
    "A drive gives its torque times its input, less friction and back-EMF. Back-EMF has the form "
    "of viscous friction, and FV holds both; logs with open windings (--open) tell them apart. "
    "Stall torque and no-load speed are those at the largest input, without a load. The last "
    "column is the share of samples at this limit."
)
_VALUES = ("The distance is from the estimate, in standard deviations of the other value.",)
_IDENTIFIABLE = (
    "How many of the {} inertial parameters, or of their combinations, the equations of the "
    "training logs determine if the motion is rich enough. symgen proves this by exact "
    "elimination. A mass at a contact of unknown force changes no equation while it touches. "
    "Friction shows in the torques of the joints."
)
_LISTED = 12  # parameters in a cell
#: Correlation above which two parameters are listed as hardly distinguishable.
CORRELATED = 0.9


def estimate_content(estimate: Estimate, robot: Robot | None = None) -> Content:
    """Return verdict, torque error, parameters, models, and folded details."""
    count = len(estimate.parameters)
    lead = (
        f"{counted(count, 'base parameter')} of the robot {estimate.robot}, identified with the "
        f"{estimate.model} model by the method {estimate.method}.",
    )
    run = run_lines(estimate.band, estimate.repairs)
    title = f"Identification of {estimate.robot}"
    return Content(title, lead, _sections(estimate, robot), _banner(estimate), run)


def _banner(e: Estimate) -> Banner:
    trusted = e.verdict == "trusted"
    said, errors = _errors(e)
    errors.pop("noise floor", None)  # the headline states it
    facts = [(f"{said}, {data}", percent(r.relative)) for data, r in errors.items()]
    known = len(e.parameters) - sum(_weak(e, p) for p in e.parameters)
    facts.append((f"parameters known to {KNOWN:g} %", f"{known} of {len(e.parameters)}"))
    facts.append(("condition number", number(e.condition_number, 3)))
    tone = "good" if trusted else "warn"
    first, rest = ("", e.sentences) if not e.headline else (e.sentences[0], e.sentences[1:])
    return Banner(tone, e.verdict, "\n".join(rest), facts=tuple(facts), headline=first)


def _errors(e: Estimate) -> tuple[str, dict[str, Residual]]:
    """Return the subject of the errors, and the errors; those of joints in motion come first."""
    if e.torque_train is None or e.torque_validation is None:
        return f"{e.model} residual", {"held-out data": e.validation, "training logs": e.train}
    held, train = e.torque_validation, {"training logs": e.torque_train}
    noise = {} if e.noise_floor is None else {"noise floor": e.noise_floor}
    if e.moving in (None, held):
        return "torque error", {"held-out data": held} | noise | train
    return "torque error", {"in motion": e.moving} | noise | {"all samples": held} | train


def _sections(e: Estimate, robot: Robot | None) -> tuple[Section, ...]:
    front = (
        Section(
            "Measured and modelled torque",
            (_TORQUES,),
            figure=partial(plots.measured_and_predicted, e, "torque"),
        ),
        _error_section(e),
        *_suspected_sections(e),
        *_drive_sections(e),
        _known_section(e),
        *([] if e.identifiable is None else [_identifiable_section(e.identifiable)]),
        *_simulation_sections(e),
        *(_values_sections(e) if e.prior else ()),
        _model_section(e),
    )
    details = (replace(section, folded=True) for section in _details(e, robot))
    return tuple(sorted((*front, *details), key=lambda section: section.folded))


def _simulation_sections(e: Estimate) -> list[Section]:
    """Return the position errors of the simulated robot, if there are any."""
    if e.uses is None or not e.uses.simulation.horizons:
        return []
    use = e.uses.simulation
    own = (("values of the robot file", use.before),) if use.before else ()
    models = (*own, ("identified", use.horizons))
    table = horizon_table("model", models)
    text = [
        f"{counted(use.windows, 'window')} of held-out motion. Each begins in the measured state "
        f"and replays the measured torque. {PLAYBACK}"
    ]
    if use.diverged:
        text.append(f"The identified model diverges in {use.diverged} of the windows.")
    by_joint = horizon_by_joint(e.joints, models)
    heading = "Position error in simulation"
    return [
        Section(heading, tuple(text), table, printed=()),
        replace(by_joint, heading=f"{heading} {by_joint.heading}", folded=True),
    ]


def _details(e: Estimate, robot: Robot | None) -> tuple[Section, ...]:
    quantities = dict.fromkeys(t.quantity for t in e.traces)
    formulas = [(p.name, folded(p.expression)) for p in e.parameters]
    return (
        _weak_section(e),
        Section("Formulas", (_FORMULAS,), Table(("name", "formula"), formulas)),
        *([] if robot is None else [frames_section(robot)]),
        repairs_section(e.repairs),
        *(() if e.prior else _values_sections(e)),
        *(
            Section(
                f"Measured and predicted {quantity}",
                (),
                figure=partial(plots.measured_and_predicted, e, quantity),
            )
            for quantity in quantities
            if quantity != "torque"
        ),
        *(
            Section(
                f"Spectrum of the {quantity} residual",
                (_SPECTRUM.get(quantity, ""),),
                figure=partial(plots.residual_spectrum, e, quantity),
            )
            for quantity in quantities
        ),
        *_correlation_sections(e),
        *notes_section(e.notes),
        Section("Provenance", table=_provenance(e)),
    )


def _error_section(e: Estimate) -> Section:
    """Return the torque error of each joint, in N m or N and in percent."""
    said, errors = _errors(e)
    torques = [t for t in e.traces if t.quantity == "torque" and t.kind == "validation"]
    measured = np.concatenate([t.measured for t in torques]) if torques else None
    table = error_table(e.joints, measured, errors)
    return Section(f"{said.capitalize()} by joint", (_ERROR,), table, printed=())


def _model_section(e: Estimate) -> Section:
    """Return the errors of the fitted models."""
    rows = [
        (
            a.model + (" (chosen)" if a.chosen else ""),
            a.reason if a.validation is None else percent(a.held_out),
            "" if a.validation is None else percent(a.validation.relative),
            number(a.condition_number, 3),
        )
        for a in e.alternatives
    ]
    header = ("model", "error on folds", "error on held-out data", "condition number")
    return Section("Models", (_MODELS,), Table(header, rows if len(rows) > 1 else ()), printed=())


def _drive_sections(e: Estimate) -> list[Section]:
    """Return the drives, for logs of their inputs."""
    if not e.drives:
        return []
    names = {joint.number: joint for joint in e.joints}
    rows = []
    for d in e.drives:
        joint = names[d.joint]
        speed = _with_std(d.no_load, d.no_load_std)
        rows.append(
            (
                joint.label,
                *value_with_std(d.torque, d.std),
                d.unit,
                _with_std(d.stall, d.stall_std),
                f"{speed} {joint.place_unit}/s" if speed else "",
                _with_std(d.back_emf, d.back_emf_std),
                percent(d.limited),
            )
        )
    header = (
        "joint",
        "torque",
        "std",
        "unit",
        "stall torque",
        "no-load speed",
        "back-EMF",
        "limit",
    )
    return [Section("Drives", (_DRIVES,), Table(header, rows), printed=())]


def _with_std(value: float, std: float) -> str:
    return "" if math.isnan(value) else " +- ".join(value_with_std(value, std))


def _suspected_sections(e: Estimate) -> list[Section]:
    """Return the suspected faults, one paragraph each."""
    if not e.suspected:
        return []
    texts = [reason.text for reason in e.suspected]
    lines = tuple(f"suspected: {text}" for text in texts)
    return [Section("Suspected", (_SUSPECTED, *texts), printed=lines)]


def _known_section(e: Estimate) -> Section:
    rows = [row for p, row in zip(e.parameters, _rows(e), strict=True) if not _weak(e, p)]
    heading = f"Known parameters ({len(rows)} of {len(e.parameters)})"
    told = (
        f"Standard deviations exclude: {e.excludes or 'not stated'}.",
        f"Physical consistency: {e.physical.text}.",
    )
    return Section(heading, (_KNOWN, *told), Table(_COLUMNS, rows), printed=told)


def _identifiable_section(found: Identifiable) -> Section:
    """Return which equations of a floating base determine its parameters, and what else to log."""
    rows = []
    for part in (*found.logged, *found.lifted):
        share, names, what = percent(part.share), part.unknown, "not"
        if part in found.lifted:
            names = tuple(name for name in found.unknown if name not in part.unknown)
            share, what = "", "also"
        listed = f"{what} {first_of(names, _LISTED)} ({len(names)})" if names else "all"
        rows.append((part.equations, share, f"{part.rank} of {found.count}", listed))
    table = Table(("equations", "samples", "determined", "parameters"), rows)
    printed = () if found.unknown else None  # a terminal shows what is missing
    text = _IDENTIFIABLE.format(found.count)
    return Section("Identifiable parameters", (text,), table, printed=printed)


def _weak_section(e: Estimate) -> Section:
    rows = [row for p, row in zip(e.parameters, _rows(e), strict=True) if _weak(e, p)]
    text = (
        f"The standard deviation is above {KNOWN:g} % of the value. The logs hardly determine "
        "these parameters one by one. At bound: a constraint of possible robots holds the value."
    )
    return Section(f"Weak parameters ({len(rows)})", (text,), Table(_COLUMNS, rows))


def _rows(e: Estimate) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for p in e.parameters:
        value, std = value_with_std(p.value, p.std)
        relative = percent(p.relative_std_percent / 100)
        if p.name in e.at_bound:
            std, relative = "at bound", ""
        rows.append((p.name, value, std, relative, p.unit))
    return rows


def _values_sections(e: Estimate) -> list[Section]:
    """Return the parameters from the prior and from other methods, and the tests of bias."""
    others = {"prior": e.prior} if e.prior else {}
    others |= {f"by {other.method}": other for other in e.comparison}
    tests = bias_tests(e)
    if not others:
        return [Section("Bias", tests)]
    header = ("name", *(k for label in others for k in (label, "std", "distance, std")))
    rows = []
    for p in e.parameters:
        row = [p.name]
        for other in others.values():
            value, std = other.of(p.name)
            distance = (value - p.value) / std if std > 0 else math.nan
            known = [number(value), number(std, 3), number(distance, 3)]
            row += ["-"] * 3 if math.isinf(std) else known
        rows.append(tuple(row))
    sources = " and ".join(["prior"] * bool(e.prior) + ["other methods"] * bool(e.comparison))
    heading = f"Values from {sources}"
    return [Section(heading, (*_VALUES, *tests), Table(header, rows), printed=())]


def bias_tests(estimate: Estimate) -> tuple[str, ...]:
    """Return the results of the bias tests, one sentence each."""
    return tuple(
        f"Durbin-Wu-Hausman test, {e.columns} columns: F({e.df[0]}, {e.df[1]:.0f}) = "
        f"{number(e.statistic, 3)}, p = {number(e.p_value, 2)}. A small p says that plain least "
        "squares is biased."
        for e in estimate.endogeneity
    )


def _correlation_sections(e: Estimate) -> list[Section]:
    if not e.correlation.size:
        return []
    above = np.triu(np.nan_to_num(np.abs(e.correlation)), 1)
    pairs = sorted(np.argwhere(above > CORRELATED).tolist(), key=lambda at: (-above[*at], at))
    names, most = [p.name for p in e.parameters], pairs[:15]
    rows = [(names[i], names[j], number(e.correlation[i, j], 4)) for i, j in most]
    text = f"No two parameters are correlated beyond ±{CORRELATED:g}."
    if pairs:
        count = counted(len(pairs), "pair")
        text = f"{count} of parameters correlated beyond ±{CORRELATED:g}: the data hardly "
        text += "distinguish them."
        text += f" The {len(most)} strongest:" if len(pairs) > len(most) else ""
    table = Table(("parameter", "and", "correlation"), rows)
    return [Section("Correlation", (text,), table)]


def _provenance(e: Estimate) -> Table:
    filtered = "no filter" if e.cutoff_hz is None else f"{number(e.cutoff_hz)} Hz"
    rows = (
        ("robot", e.robot),
        ("model", e.model),
        ("method", e.method),
        ("band", e.band.in_words()) if e.band is not None else ("filter cutoff", filtered),
        ("energy window", "none" if e.window_s is None else f"{number(e.window_s)} s"),
        *(
            (f"residual of the {e.model} equations, {data}", percent(r.relative))
            for data, r in (("training logs", e.train), ("held-out data", e.validation))
        ),
        *e.provenance,
    )
    return Table(("item", "value"), rows)


def _weak(e: Estimate, parameter: ParameterEstimate) -> bool:
    """Return whether a parameter is not known: its deviation is large, NaN or missing."""
    known = parameter.relative_std_percent <= KNOWN
    return not known or parameter.name in e.at_bound
