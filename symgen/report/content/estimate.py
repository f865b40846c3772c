"""What is said of an estimate."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from symgen.identification.assessment import LEVEL, in_words
from symgen.identification.estimate import Estimate, ParameterEstimate
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    counted,
    frames_section,
    notes_section,
    number,
    percent,
    run_lines,
)
from symgen.report.folded import folded
from symgen.report.plots import curves as plots
from symgen.report.plots import parameters as parameter_plots
from symgen.report.plots import residuals as residual_plots

if TYPE_CHECKING:
    from symgen.robot.types import Robot

_SPECTRUM = {
    "energy": "A window of length T passes white noise with notches at multiples of 1/T. A peak "
    "beside them is motion that the model does not explain.",
    "torque": "Both torques have passed the same low-pass (see Notes). A peak below its cutoff is "
    "motion that the model does not explain.",
}
_LOGS = "The list above the plot chooses the log; validation stands on a tinted ground."
_BALANCE = (
    "Measured work of the drives since the start of the log; by the model it became kinetic and "
    "potential energy, which come back, and friction, which does not. A rest that grows steadily "
    "is a loss or an offset that the model misses."
)
_CONVERGENCE = (
    "Each estimate over its final value, as data come in: a line that still moves at the end needs "
    f"more data. At first the {plots.COURSES} are drawn that moved most in the second half, weak "
    "ones apart; a click on the legend shows others."
)
#: Correlation from which two parameters are named as hardly told apart by the data.
TIED = 0.9


def estimate_content(estimate: Estimate, robot: Robot | None = None) -> Content:
    """Return verdict, torque, uses, parameters, the robot, what is left, provenance."""
    count = len(estimate.parameters)
    lead = (
        f"{counted(count, 'base parameter')} of the robot {estimate.robot}, identified with the "
        f"{estimate.model} model by the method {estimate.method}.",
    )
    run = run_lines(estimate.band, estimate.repairs)
    sections = tuple(_sections(estimate, robot))
    title = f"Identification of {estimate.robot}"
    return Content(title, lead, sections, _banner(estimate), run)


def _banner(estimate: Estimate) -> Banner:
    trusted = estimate.verdict == "trusted"
    weak = sum(map(_weak, estimate.parameters))
    facts = [
        (f"{estimate.model} residual, training", percent(estimate.train.relative, 3)),
        (f"{estimate.model} residual, validation", percent(estimate.validation.relative, 3)),
    ]
    if estimate.torque_validation is not None and estimate.model != "torque":
        facts.append(
            ("torque residual, validation", percent(estimate.torque_validation.relative, 3))
        )
    facts += [
        (f"parameters weak (std over {plots.WEAK_PERCENT:g} %)",
         f"{weak} of {len(estimate.parameters)}"),
        ("condition number, scaled", number(estimate.condition_number, 4)),
    ]  # fmt: skip
    return Banner(
        tone="good" if trusted else "warn",
        verdict=estimate.verdict,
        text=(
            estimate.headline or "No check speaks against this estimate."
            if trusted
            else "Do not rely on this estimate before these points are settled:"
        ),
        reasons=estimate.reasons,
        facts=tuple(facts),
    )


def _sections(estimate: Estimate, robot: Robot | None) -> list[Section]:
    choice = _choice_sections(estimate)
    sections = [
        _fit_section(estimate),
        *choice[:1],
        _parameter_section(estimate),
        _formula_section(estimate),
        *([] if robot is None else [frames_section(robot)]),  # before what explains the numbers
        *choice[1:],
        *_values_sections(estimate),
    ]
    quantities = dict.fromkeys(t.quantity for t in estimate.traces)
    for quantity in quantities:
        if quantity != "torque":
            figure = partial(plots.measured_and_predicted, estimate, quantity)
            sections.append(Section(f"Measured and predicted {quantity}", (_LOGS,), figure=figure))
    sections += [
        Section(
            "Energy balance", (_BALANCE,), figure=partial(residual_plots.energy_balance, estimate)
        ),
        Section("Convergence", (_CONVERGENCE,), figure=partial(plots.convergence, estimate)),
    ]
    for quantity in quantities:
        figure = partial(residual_plots.residual_spectrum, estimate, quantity)
        text = (_SPECTRUM.get(quantity, ""),)
        sections.append(Section(f"Spectrum of the {quantity} residual", text, figure=figure))
    return [
        *sections,
        *_whiteness_sections(estimate),
        *_correlation_sections(estimate),
        *notes_section(estimate.notes),
        Section("Provenance", table=_provenance(estimate)),
    ]


def _fit_section(estimate: Estimate) -> Section:
    """Measured beside predicted torque, and how far apart they are."""
    text, table = (
        "Relative residual ‖y - W X‖ / ‖y‖. Validation data were not used to estimate.",
        _fit_table(estimate),
    )
    if not plots.traces_of(estimate, "torque"):
        return Section("Fit", (text,), table, told=())
    figure = partial(plots.measured_and_predicted, estimate, "torque")
    heading = "Measured and predicted torque"
    return Section(heading, (f"{_LOGS} {text}",), table, figure, told=())


def _choice_sections(estimate: Estimate) -> list[Section]:
    """What the estimate may be used for, which models were tried, and what was mended."""
    out = []
    if estimate.uses:
        uses = tuple(
            (use.name, "yes" if use.ok else "no", "; ".join(use.reasons)) for use in estimate.uses
        )
        table = Table(("use", "", "what speaks against it"), uses, ("name", "name", "words"))
        out.append(Section("What it may be used for", (), table=table))
    if len(estimate.alternatives) > 1:
        text = (
            "All models were fitted to the same filtered logs. The one is taken that leaves the "
            "smallest torque error on folds of the training logs that its fit did not see."
        )
        models = tuple(
            (
                a.model + (" (chosen)" if a.chosen else ""),
                percent(a.held_out),
                "" if a.validation is None else percent(a.validation.relative),
                number(a.condition_number, 3),
                ", ".join(f"{name} ({size:.2g} std)" for name, size in a.apart[:5]),
                a.reason,
            )
            for a in estimate.alternatives
        )
        header = (
            "model",
            "folds left out",
            "held-out motion",
            "condition",
            "apart from the chosen",
            "",
        )
        styles = ("name", "number", "number", "number", "words", "words")
        out.append(Section("Models", (text,), table=Table(header, models, styles), told=()))
    if estimate.repairs:
        mended = tuple(
            (r.log, r.channel, r.fault, str(r.samples), r.done) for r in estimate.repairs
        )
        columns = ("log", "channel", "fault", "samples", "what was done")
        kinds = ("name", "name", "words", "number", "words")
        out.append(Section("Repairs", (), table=Table(columns, mended, kinds)))
    return out


def _fit_table(estimate: Estimate) -> Table:
    """A row for all joints together and one for each; columns: training and validation."""
    pairs = [(f"{estimate.model} (fitted)", estimate.train, estimate.validation)]
    if estimate.torque_train is not None and estimate.torque_validation is not None:
        torque = (estimate.torque_train, estimate.torque_validation)
        if torque != (estimate.train, estimate.validation):
            pairs.append(("torque", *torque))
    header, count = [""], 1 + max(len(p.per_joint or ()) for _, *both in pairs for p in both)
    labels = ("all", *(f"joint {number}" for number, _ in estimate.joints))
    rows = [[label] for label in labels[:count]]
    for label, *both in pairs:
        for data, residual in zip(("training", "validation"), both, strict=True):
            header.append(f"{label}, {data}")
            own = (residual.relative, *(residual.per_joint or ()))
            for row, value in zip(rows, (*map(percent, own), *[""] * count), strict=False):
                row.append(value)
    styles = ("name", *("number",) * (len(header) - 1))
    return Table(tuple(header), tuple(map(tuple, rows)), styles)


def _parameter_section(estimate: Estimate) -> Section:
    found = estimate.parameters
    weak = frozenset(k for k, p in enumerate(found) if _weak(p))
    text = (
        f"Rows marked ▲ have a relative standard deviation over {plots.WEAK_PERCENT:g} %: the "
        "data do not determine them well."
        if weak
        else f"All relative standard deviations are below {plots.WEAK_PERCENT:g} %."
    )
    rows = tuple(
        (
            p.name,
            number(p.value),
            number(p.std, 4),
            ("▲ " if k in weak else "") + number(p.relative_std_percent, 4),
            p.unit,
        )
        for k, p in enumerate(found)
    )
    table = Table(
        ("name", "value", "std", "std, %", "unit"),
        rows,
        ("name", "number", "number", "number", "unit"),
        weak,
    )
    texts = (
        text,
        f"Standard deviations exclude: {estimate.excludes or 'not said'}.",
        f"Physical consistency: {estimate.physical.reason}.",
    )
    figure = partial(plots.parameters, estimate)
    return Section("Parameters", texts, table, figure, told=texts[1:])


def _formula_section(estimate: Estimate) -> Section:
    """What each parameter is, equal factors once."""
    rows = tuple((p.name, folded(p.expression)) for p in estimate.parameters)
    text = "Each base parameter in the standard parameters of the links; M3 + ... + M7 is a sum."
    table = Table(("name", "formula"), rows, ("name", "formula"))
    return Section("Formulas", (text,), table, told=())


def _values_sections(estimate: Estimate) -> list[Section]:
    """The same parameters by their prior and by other methods, and the tests of bias."""
    known, tests = estimate.prior, bias_tests(estimate)
    others = [] if known is None else [(known, "prior")]
    others += [(other, f"by {other.method}") for other in estimate.comparison]
    if not others:
        return [Section("Bias", tests)] if tests else []
    texts = (
        "Each value over the estimate's own, with 2 std to either side: 1 is the estimate. "
        "Weak parameters are pale, and their bars may leave the plot; a value of zero is left out.",
        *tests,
    )
    figure = partial(parameter_plots.values, estimate)
    header, styles = ["name"], ["name"]
    for _, label in others:
        header += [label, "std", "apart, std"]
        styles += ["number"] * 3
    rows = []
    for p in estimate.parameters:
        row = [p.name]
        for other, _ in others:
            value = next((v for v in other.parameters if v.name == p.name), None)
            if value is None:
                row += ["-"] * 3
                continue
            apart = (value.value - p.value) / value.std if value.std > 0 else float("nan")
            row += [number(value.value), number(value.std, 3), number(apart, 3)]
        rows.append(tuple(row))
    told = " and ".join(
        (["prior"] if known else []) + ["other methods"] * bool(estimate.comparison)
    )
    table = Table(tuple(header), tuple(rows), tuple(styles))
    return [Section(f"Values beside {told}", texts, table, figure, told=())]


def bias_tests(estimate: Estimate) -> tuple[str, ...]:
    """Return what the tests of bias say, a sentence each."""
    return tuple(
        f"Durbin-Wu-Hausman test, {e.columns} columns: F({e.df[0]}, {e.df[1]:.0f}) = "
        f"{number(e.statistic, 3)}, p = {number(e.p_value, 2)}. A small p says that plain least "
        "squares is biased."
        for e in estimate.endogeneity
    )


def _whiteness_sections(estimate: Estimate) -> list[Section]:
    tested = estimate.whiteness
    if not tested:
        return []
    off = sum(w.p_value < LEVEL for w in tested)
    verdict = (
        "All residuals are white as far as these lags show."
        if not off
        else f"{off} of {len(tested)} residuals are not white: they hold motion that the model "
        "with these parameters does not explain. Standard deviations allow for it, but not for a "
        "bias that comes with it."
    )
    text = (
        f"{verdict} Residuals are taken so far apart that they share no window and nothing that a "
        "filter spreads; the band holds 95 % of the correlations of a white residual, of whatever "
        f"changing size. A residual counts as not white where p is below {LEVEL:g}."
    )
    rows = []
    for w in tested:
        name, _ = plots.components(estimate, w.quantity)[w.component]
        label = w.quantity if name == w.quantity else f"{w.quantity}, {name}"
        kind = "training" if w.kind == "train" else w.kind
        rows.append((label, kind, str(w.rows), str(len(w.bands)), f"{w.p_value:.2g}", in_words(w)))
    table = Table(
        ("residual", "data", "rows", "lags", "p", "in words"),
        tuple(rows),
        ("name", "unit", "number", "number", "number", "text"),
        frozenset(k for k, w in enumerate(tested) if w.p_value < LEVEL),
    )
    held = [w for w in tested if w.kind == "validation"] or tested
    white = len(held) - sum(w.p_value < LEVEL for w in held)
    worst = min(held, key=lambda w: w.p_value)
    told = f"residuals: {white} of {len(held)} white; {in_words(worst)}"
    figure = partial(residual_plots.lag_correlation, estimate)
    return [Section("Whiteness", (text,), table, figure), Section("", told=(told,))]


def _correlation_sections(estimate: Estimate) -> list[Section]:
    if not estimate.correlation.size:
        return []
    figure = partial(plots.correlation, estimate)
    names = [p.name for p in estimate.parameters]
    above = np.triu(np.nan_to_num(np.abs(estimate.correlation)), 1)
    tied = [(above[i, j], i, j) for i, j in np.argwhere(above > TIED)]
    tied.sort(key=lambda entry: (-entry[0], entry[1], entry[2]))
    if not tied:
        text = f"No two parameters are correlated beyond ±{TIED:g}."
        return [Section("Correlation", (text,), figure=figure)]
    shown = tied[:15]
    text = (
        f"{counted(len(tied), 'pair')} of parameters correlated beyond ±{TIED:g}: the data hardly "
        "tell them apart." + (f" The {len(shown)} strongest:" if len(tied) > len(shown) else "")
    )
    rows = tuple((names[i], names[j], number(estimate.correlation[i, j], 4)) for _, i, j in shown)
    table = Table(("parameter", "and", "correlation"), rows, ("name", "name", "number"))
    return [Section("Correlation", (text,), table, figure)]


def _provenance(estimate: Estimate) -> Table:
    cutoff, window = estimate.cutoff_hz, estimate.window_s
    rows = (
        ("robot", estimate.robot),
        ("model", estimate.model),
        ("method", estimate.method),
        *(
            (("filter cutoff", "no filter" if cutoff is None else f"{number(cutoff)} Hz"),)
            if estimate.band is None
            else (("band", estimate.band.in_words()),)
        ),
        ("energy window", "none" if window is None else f"{number(window)} s"),
        *estimate.provenance,
    )
    return Table(("item", "value"), rows)


def _weak(parameter: ParameterEstimate) -> bool:
    # written so that an unknown deviation (NaN) is weak
    return not parameter.relative_std_percent <= plots.WEAK_PERCENT
