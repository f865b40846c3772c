"""What is said of an estimate."""

from __future__ import annotations

import math
from functools import partial
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from symgen.identification.assessment import KNOWN, LEVEL, in_words
from symgen.identification.estimate import BETWEEN_USES, Estimate, ParameterEstimate
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
    repairs_section,
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
_FORMULAS = "Each base parameter in the standard parameters of the links; M3 + ... + M7 is a sum."
_MODELS = (
    "All models were fitted to the same filtered logs. The one is taken that leaves the smallest "
    "torque error on folds of the training logs that its fit did not see."
)
_VALUES = (
    "Each value over the estimate's own, with 2 std to either side: 1 is the estimate. Weak "
    "parameters are pale, and their bars may leave the plot; a value of zero is left out."
)
_WHITENESS = (
    "Residuals are taken so far apart that they share no window and nothing that a filter spreads; "
    "the band holds 95 % of the correlations of a white residual, of whatever changing size. A "
    f"residual counts as not white where p is below {LEVEL:g}."
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
    title = f"Identification of {estimate.robot}"
    return Content(title, lead, _sections(estimate, robot), _banner(estimate), run)


def _banner(e: Estimate) -> Banner:
    trusted, torque = e.verdict == "trusted", e.torque_validation
    facts = {
        f"{e.model} residual, training": percent(e.train.relative, 3),
        f"{e.model} residual, validation": percent(e.validation.relative, 3),
    }
    if torque is not None and e.model != "torque":
        facts["torque residual, validation"] = percent(torque.relative, 3)
    weak = f"{sum(map(_weak, e.parameters))} of {len(e.parameters)}"
    facts[f"parameters weak (std over {KNOWN:g} %)"] = weak
    facts["condition number, scaled"] = number(e.condition_number, 4)
    tone = "good" if trusted else "warn"
    text = "\n".join(e.headline.split(BETWEEN_USES))
    return Banner(tone, e.verdict, text, () if text else e.reasons, tuple(facts.items()))


def _sections(e: Estimate, robot: Robot | None) -> tuple[Section, ...]:
    quantities = dict.fromkeys(t.quantity for t in e.traces)
    uses = [(use.name, "yes" if use.ok else "no", "; ".join(use.reasons)) for use in e.uses]
    formulas = [(p.name, folded(p.expression)) for p in e.parameters]
    return (
        _fit_section(e),
        Section("What it may be used for", (), Table(("use", "", "what speaks against it"), uses)),
        _parameter_section(e),
        Section("Formulas", (_FORMULAS,), Table(("name", "formula"), formulas), told=()),
        *([] if robot is None else [frames_section(robot)]),  # before what explains the numbers
        _model_section(e),
        repairs_section(e.repairs),
        *_values_sections(e),
        *(
            Section(
                f"Measured and predicted {quantity}",
                (_LOGS,),
                figure=partial(plots.measured_and_predicted, e, quantity),
            )
            for quantity in quantities
            if quantity != "torque"
        ),
        Section("Energy balance", (_BALANCE,), figure=partial(residual_plots.energy_balance, e)),
        Section("Convergence", (_CONVERGENCE,), figure=partial(plots.convergence, e)),
        *(
            Section(
                f"Spectrum of the {quantity} residual",
                (_SPECTRUM.get(quantity, ""),),
                figure=partial(residual_plots.residual_spectrum, e, quantity),
            )
            for quantity in quantities
        ),
        *_whiteness_sections(e),
        *_correlation_sections(e),
        *notes_section(e.notes),
        Section("Provenance", table=_provenance(e)),
    )


def _fit_section(e: Estimate) -> Section:
    """Measured beside predicted torque, and how far apart they are: in all, and by joint."""
    pairs = {f"{e.model} (fitted)": (e.train, e.validation)}
    if e.torque_train is not None and e.torque_validation is not None:
        torque = (e.torque_train, e.torque_validation)
        pairs |= {} if torque == (e.train, e.validation) else {"torque": torque}
    columns = {
        f"{label}, {data}": (residual.relative, *(residual.per_joint or ()))
        for label, both in pairs.items()
        for data, residual in zip(("training", "validation"), both, strict=True)
    }
    labels = ("all", *(f"joint {number}" for number, _ in e.joints))
    cells = zip_longest(
        *([percent(x) for x in column] for column in columns.values()), fillvalue=""
    )
    table = Table(
        ("", *columns), [(label, *row) for label, row in zip(labels, cells, strict=False)]
    )
    text = "Relative residual ‖y - W X‖ / ‖y‖. Validation data were not used to estimate."
    if not plots.traces_of(e, "torque"):
        return Section("Fit", (text,), table, told=())
    figure = partial(plots.measured_and_predicted, e, "torque")
    return Section("Measured and predicted torque", (f"{_LOGS} {text}",), table, figure, told=())


def _model_section(e: Estimate) -> Section:
    """Which models were tried."""
    rows = [
        (
            a.model + (" (chosen)" if a.chosen else ""),
            percent(a.held_out),
            "" if a.validation is None else percent(a.validation.relative),
            number(a.condition_number, 3),
            ", ".join(f"{name} ({size:.2g} std)" for name, size in a.apart[:5]),
            a.reason,
        )
        for a in e.alternatives
    ]
    header = (
        *("model", "folds left out", "held-out motion", "condition", "apart from the chosen"),
        "",
    )
    return Section("Models", (_MODELS,), Table(header, rows if len(rows) > 1 else ()), told=())


def _parameter_section(e: Estimate) -> Section:
    rows = [
        (
            p.name,
            number(p.value),
            number(p.std, 4),
            "▲ " * _weak(p) + number(p.relative_std_percent, 4),
            p.unit,
        )
        for p in e.parameters
    ]
    text = (
        f"Rows marked ▲ have a relative standard deviation over {KNOWN:g} %: the "
        "data do not determine them well."
        if any(map(_weak, e.parameters))
        else f"All relative standard deviations are below {KNOWN:g} %."
    )
    told = (
        f"Standard deviations exclude: {e.excludes or 'not said'}.",
        f"Physical consistency: {e.physical.reason}.",
    )
    table = Table(("name", "value", "std", "std, %", "unit"), rows)
    return Section("Parameters", (text, *told), table, partial(plots.parameters, e), told=told)


def _values_sections(e: Estimate) -> list[Section]:
    """The same parameters by their prior and by other methods, and the tests of bias."""
    others = {"prior": e.prior} if e.prior else {}
    others |= {f"by {other.method}": other for other in e.comparison}
    tests = bias_tests(e)
    if not others:
        return [Section("Bias", tests)]
    header = ("name", *(k for label in others for k in (label, "std", "apart, std")))
    rows = []
    for p in e.parameters:
        row = [p.name]
        for other in others.values():
            value, std = other.of(p.name)
            apart = (value - p.value) / std if std > 0 else math.nan
            known = [number(value), number(std, 3), number(apart, 3)]
            row += ["-"] * 3 if math.isinf(std) else known
        rows.append(tuple(row))
    told = " and ".join(["prior"] * bool(e.prior) + ["other methods"] * bool(e.comparison))
    figure = partial(parameter_plots.values, e)
    return [
        Section(f"Values beside {told}", (_VALUES, *tests), Table(header, rows), figure, told=())
    ]


def bias_tests(estimate: Estimate) -> tuple[str, ...]:
    """Return what the tests of bias say, a sentence each."""
    return tuple(
        f"Durbin-Wu-Hausman test, {e.columns} columns: F({e.df[0]}, {e.df[1]:.0f}) = "
        f"{number(e.statistic, 3)}, p = {number(e.p_value, 2)}. A small p says that plain least "
        "squares is biased."
        for e in estimate.endogeneity
    )


def _whiteness_sections(e: Estimate) -> list[Section]:
    tested = e.whiteness
    if not tested:
        return []
    rows, off = [], [w for w in tested if w.p_value < LEVEL]
    for w in tested:
        kind = "training" if w.kind == "train" else w.kind
        p = f"{'▲ ' * (w in off)}{w.p_value:.2g}"
        label = plots.component(e, w)
        rows.append((label, kind, str(w.rows), str(len(w.bands)), p, in_words(w)))
    verdict = (
        f"{len(off)} of {len(tested)} residuals are not white: they hold motion that the model "
        "with these parameters does not explain. Standard deviations allow for it, but not for a "
        "bias that comes with it."
        if off
        else "All residuals are white as far as these lags show."
    )
    table = Table(("residual", "data", "rows", "lags", "p", "in words"), rows)
    held = [w for w in tested if w.kind == "validation"] or tested
    white = sum(w not in off for w in held)
    worst = min(held, key=lambda w: w.p_value)
    told = f"residuals: {white} of {len(held)} white; {in_words(worst)}"
    figure = partial(residual_plots.lag_correlation, e)
    text = (f"{verdict} {_WHITENESS}",)
    return [Section("Whiteness", text, table, figure), Section("", told=(told,))]


def _correlation_sections(e: Estimate) -> list[Section]:
    if not e.correlation.size:
        return []
    above = np.triu(np.nan_to_num(np.abs(e.correlation)), 1)
    tied = sorted(np.argwhere(above > TIED).tolist(), key=lambda at: (-above[*at], at))
    names, most = [p.name for p in e.parameters], tied[:15]
    rows = [(names[i], names[j], number(e.correlation[i, j], 4)) for i, j in most]
    text = f"No two parameters are correlated beyond ±{TIED:g}."
    if tied:
        text = f"{counted(len(tied), 'pair')} of parameters correlated beyond ±{TIED:g}: the data "
        text += "hardly tell them apart."
        text += f" The {len(most)} strongest:" if len(tied) > len(most) else ""
    table = Table(("parameter", "and", "correlation"), rows)
    return [Section("Correlation", (text,), table, partial(plots.correlation, e))]


def _provenance(e: Estimate) -> Table:
    filtered = "no filter" if e.cutoff_hz is None else f"{number(e.cutoff_hz)} Hz"
    rows = (
        ("robot", e.robot),
        ("model", e.model),
        ("method", e.method),
        ("band", e.band.in_words()) if e.band is not None else ("filter cutoff", filtered),
        ("energy window", "none" if e.window_s is None else f"{number(e.window_s)} s"),
        *e.provenance,
    )
    return Table(("item", "value"), rows)


def _weak(parameter: ParameterEstimate) -> bool:
    # written so that an unknown deviation (NaN) is weak
    return not parameter.relative_std_percent <= KNOWN
