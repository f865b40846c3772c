"""Reports: one HTML page that holds everything, plotly.js too, and asks nothing of a network."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from symgen import plots
from symgen.files import rendered
from symgen.identification.estimate import Estimate, ParameterEstimate
from symgen.identification.export import values_header

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_SPECTRUM = {
    "energy": "A window of length T passes white noise with notches at multiples of 1/T. A peak "
    "beside them is motion that the model does not explain.",
    "torque": "Both torques have passed the same low-pass (see Notes). A peak below its cutoff is "
    "motion that the model does not explain.",
}
#: Correlation from which two parameters are named as hardly told apart by the data.
TIED = 0.9


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Attributes:
        header: one text a column.
        rows: one text a column in each.
        styles: "text", "number" or "formula" for each column; empty: all text.
        flagged: indices of the rows to point out.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    styles: tuple[str, ...] = ()
    flagged: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Section:
    """A heading with paragraphs, then a figure, then a table."""

    heading: str
    text: tuple[str, ...] = ()
    table: Table | None = None
    figure: Figure | None = None


@dataclass(frozen=True)
class Banner:
    """What the reader must see first.

    Attributes:
        tone: "good", "warn" or "bad": the colour.
        verdict: one or two words.
        text: what it means, in a sentence.
        reasons: why.
        facts: label and value of the few numbers that matter.
    """

    tone: str
    verdict: str
    text: str
    reasons: tuple[str, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()


def page(
    title: str,
    lead: tuple[str, ...],
    sections: Sequence[Section],
    banner: Banner | None = None,
) -> str:
    """Return a whole HTML page; the same arguments give the same text.

    Args:
        title: of the page.
        lead: paragraphs below the title.
        sections: in the order of the page.
        banner: the verdict, above all sections.
    """
    any_figure = any(section.figure is not None for section in sections)
    return rendered(
        "report/report.html",
        title=title,
        lead=lead,
        banner=banner,
        sections=[_view(k, section) for k, section in enumerate(sections, 1)],
        plotly=_plotly_js() if any_figure else None,
    )


def estimate_page(estimate: Estimate) -> str:
    """Return the page of an identification: verdict, fit, parameters, figures, provenance."""
    count = len(estimate.parameters)
    lead = (
        f"{_count(count, 'base parameter')} of the robot {estimate.robot}, identified with the "
        f"{estimate.model} model by the method {estimate.method}.",
    )
    return page(f"Identification of {estimate.robot}", lead, _sections(estimate), _banner(estimate))


def number(value: float, digits: int = 5) -> str:
    """Return a number with so many significant digits, in words where it is not finite."""
    if np.isnan(value):
        return "unknown"
    if np.isinf(value):
        return "∞" if value > 0 else "-∞"
    return f"{value or 0.0:#.{digits}g}".removesuffix(".")


def percent(ratio: float, digits: int = 4) -> str:
    """Return a ratio in percent."""
    return f"{number(100 * ratio, digits)} %"


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
        verdict=estimate.verdict.capitalize(),
        text=(
            "No check speaks against this estimate."
            if trusted
            else "Do not rely on this estimate before these points are settled:"
        ),
        reasons=estimate.reasons,
        facts=tuple(facts),
    )


def _sections(estimate: Estimate) -> list[Section]:
    sections = [
        Section(
            "Fit",
            ("Relative residual ‖y - W X‖ / ‖y‖. Validation data were not used to estimate.",),
            table=_fit_table(estimate),
        ),
        _parameter_section(estimate),
    ]
    for quantity in dict.fromkeys(t.quantity for t in estimate.traces):
        figure = plots.measured_and_predicted(estimate, quantity)
        if figure is not None:
            text = "The list above the plot chooses the log; validation stands on a tinted ground."
            sections.append(drawn(f"Measured and predicted {quantity}", text, figure))
    course = plots.convergence(estimate)
    if course is not None:
        text = (
            "Each estimate over its final value, as data come in: a line that still moves at the "
            "end needs more data. Weak parameters start hidden; click on the legend."
        )
        sections.append(drawn("Convergence", text, course))
    for quantity in dict.fromkeys(t.quantity for t in estimate.traces):
        figure = plots.residual_spectrum(estimate, quantity)
        if figure is not None:
            text = _SPECTRUM.get(quantity, "")
            sections.append(drawn(f"Spectrum of the {quantity} residual", text, figure))
    figure = plots.correlation(estimate)
    if figure is not None:
        sections.append(_correlation_section(estimate, figure))
    if estimate.comparison:
        sections.append(_comparison_section(estimate))
    if estimate.notes:
        sections.append(Section("Notes", estimate.notes))
    sections.append(Section("Provenance", table=_provenance(estimate)))
    return sections


def _fit_table(estimate: Estimate) -> Table:
    """One row for training, one for validation; columns: each total, then its joints."""
    pairs = [(f"{estimate.model} (fitted)", estimate.train, estimate.validation)]
    if estimate.torque_train is not None and estimate.torque_validation is not None:
        torque = (estimate.torque_train, estimate.torque_validation)
        if torque != (estimate.train, estimate.validation):
            pairs.append(("torque", *torque))
    header, rows = ["data"], [["training"], ["validation"]]
    for label, *both in pairs:
        joints = min(len(residual.per_joint or ()) for residual in both)
        header += [label, *(f"joint {number}" for number, _ in estimate.joints[:joints])]
        for row, residual in zip(rows, both, strict=True):
            row += map(percent, (residual.relative, *(residual.per_joint or ())[:joints]))
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
            p.expression,
        )
        for k, p in enumerate(found)
    )
    table = Table(
        ("name", "value", "std", "std, %", "unit", "formula"),
        rows,
        ("name", "number", "number", "number", "unit", "formula"),
        weak,
    )
    texts = (
        text,
        f"Standard deviations exclude: {estimate.excludes or 'not said'}.",
        f"Physical consistency: {estimate.physical.reason}.",
    )
    return Section("Parameters", texts, table, plots.parameters(estimate))


def _comparison_section(estimate: Estimate) -> Section:
    """The same parameters by other methods, and the tests of bias."""
    header, styles = ["name", estimate.method, "std"], ["name", "number", "number"]
    for other in estimate.comparison:
        header += [f"by {other.method}", "std", "apart, std"]
        styles += ["number"] * 3
    rows = []
    for k, p in enumerate(estimate.parameters):
        row = [p.name, number(p.value), number(p.std, 3)]
        for other in estimate.comparison:
            x, std = float(other.X[k]), float(other.std[k])
            apart = (x - p.value) / std if std > 0 else float("nan")
            row += [number(x), number(std, 3), number(apart, 3)]
        rows.append(tuple(row))
    texts = tuple(
        f"Durbin-Wu-Hausman test, {e.columns} columns: F({e.df[0]}, {e.df[1]:.0f}) = "
        f"{number(e.statistic, 3)}, p = {number(e.p_value, 2)}. A small p says that plain least "
        "squares is biased."
        for e in estimate.endogeneity
    )
    return Section("Other methods", texts, Table(tuple(header), tuple(rows), tuple(styles)))


def _correlation_section(estimate: Estimate, figure: Figure) -> Section:
    names = [p.name for p in estimate.parameters]
    above = np.triu(np.nan_to_num(np.abs(estimate.correlation)), 1)
    tied = [(above[i, j], i, j) for i, j in np.argwhere(above > TIED)]
    tied.sort(key=lambda entry: (-entry[0], entry[1], entry[2]))
    if not tied:
        text = f"No two parameters are correlated beyond ±{TIED:g}."
        return drawn("Correlation", text, figure)
    shown = tied[:15]
    text = (
        f"{_count(len(tied), 'pair')} of parameters correlated beyond ±{TIED:g}: the data hardly "
        "tell them apart." + (f" The {len(shown)} strongest:" if len(tied) > len(shown) else "")
    )
    rows = tuple((names[i], names[j], number(estimate.correlation[i, j], 4)) for _, i, j in shown)
    table = Table(("parameter", "and", "correlation"), rows, ("name", "name", "number"))
    return drawn("Correlation", text, figure, table)


def _provenance(estimate: Estimate) -> Table:
    cutoff, window = estimate.cutoff_hz, estimate.window_s
    rows = (
        ("robot", estimate.robot),
        ("model", estimate.model),
        ("method", estimate.method),
        ("filter cutoff", "no filter" if cutoff is None else f"{number(cutoff)} Hz"),
        ("energy window", "none" if window is None else f"{number(window)} s"),
        *estimate.provenance,
    )
    return Table(("item", "value"), rows)


def drawn(heading: str, text: str, figure: Figure, table: Table | None = None) -> Section:
    """A section whose heading stands for the figure's own title, which is taken off."""
    room = figure.layout.margin.t - 30
    figure.update_layout(title=None, margin={"t": max(room, 36)})
    return Section(heading, (text,), table, figure)


def _weak(parameter: ParameterEstimate) -> bool:
    # written so that an unknown deviation (NaN) is weak
    return not parameter.relative_std_percent <= plots.WEAK_PERCENT


def _count(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _view(place: int, section: Section) -> dict[str, Any]:
    """What the template places: texts, and figures as JSON that is safe inside a script."""
    view: dict[str, Any] = {
        "id": f"s{place}",
        "heading": section.heading,
        "text": section.text,
        "table": None,
        "figure": None,
    }
    if section.table is not None:
        table = section.table
        styles = table.styles or ("text",) * len(table.header)
        view["table"] = {
            "header": list(zip(styles, table.header, strict=True)),
            "rows": [
                {"flagged": k in table.flagged, "cells": list(zip(styles, row, strict=True))}
                for k, row in enumerate(table.rows)
            ],
        }
    if section.figure is not None:
        layout = section.figure.layout
        view["figure"] = {
            "id": f"figure{place}",
            "height": int(layout.height or 450),
            "min_width": int(layout.meta.get("min_width", 0))
            if isinstance(layout.meta, dict)
            else 0,
            "json": _script_safe(section.figure),
        }
    return view


def _script_safe(figure: Figure) -> Markup:
    """The figure's JSON with no character that could end the script element that holds it."""
    import plotly.io

    text = plotly.io.to_json(figure, engine="json")
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def _plotly_js() -> Markup:
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs())


def estimate_files(estimate: Estimate) -> dict[str, bytes]:
    """Return what `identify` writes into its folder: estimate.json, NAME_values.h, report.html."""
    content = json.dumps(estimate.to_json(), indent=1, allow_nan=False) + "\n"
    return {
        "estimate.json": content.encode(),
        f"{estimate.robot}_values.h": values_header(estimate).encode(),
        "report.html": estimate_page(estimate).encode(),
    }
