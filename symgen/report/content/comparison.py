"""What is said of a comparison: two estimates of one robot."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from symgen.estimation.values import Residual
from symgen.identification.comparison import Comparison
from symgen.identification.estimate import Estimate
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    counted,
    number,
    percent,
)
from symgen.report.folded import folded
from symgen.report.plots import parameters as parameter_plots

TONES = {"agree": "good", "differ": "warn", "unknown": "warn"}


def comparison_content(comparison: Comparison) -> Content:
    """Return verdict, parameters and their differences, residuals, provenance."""
    a, b = comparison.names
    lead = (f"Two estimates of the robot {comparison.a.robot}: a is {a}, b is {b}.",)
    banner = Banner(
        tone=TONES[comparison.verdict],
        verdict=comparison.verdict,
        text=comparison.summary,
        reasons=tuple(
            f"{p.name}: {number(p.a.value, 4)} in a, {number(p.b.value, 4)} {p.a.unit} in b, "
            f"{number(p.sigmas, 3)} combined std apart"
            for p in comparison.moved[:10]
        ),
        facts=(
            ("parameters compared", str(len(comparison.parameters))),
            ("moved", str(len(comparison.moved))),
            ("not compared", str(len(comparison.left_out))),
            ("verdict of a", comparison.a.verdict),
            ("verdict of b", comparison.b.verdict),
        ),
    )
    title = f"Two estimates of {comparison.a.robot}"
    return Content(title, lead, tuple(_sections(comparison)), banner)


def _side_by_side(comparison: Comparison) -> tuple[tuple[str, str, str], ...]:
    """Return label, a, b of what the two say of themselves."""

    def share(residual: Residual | None) -> str:
        return "-" if residual is None else percent(residual.relative, 3)

    def size(value: float | None) -> str:
        return "-" if value is None else f"{value:g}"

    rows: tuple[tuple[str, Callable[[Estimate], str]], ...] = (
        ("verdict", lambda e: e.verdict),
        ("model", lambda e: e.model),
        ("method", lambda e: e.method),
        ("residual, training", lambda e: share(e.train)),
        ("residual, validation", lambda e: share(e.validation)),
        ("torque residual, training", lambda e: share(e.torque_train)),
        ("torque residual, validation", lambda e: share(e.torque_validation)),
        ("condition number, scaled", lambda e: number(e.condition_number, 4)),
        ("window, s", lambda e: size(e.window_s)),
        ("filter cutoff, Hz", lambda e: size(e.cutoff_hz)),
    )
    return tuple((label, told(comparison.a), told(comparison.b)) for label, told in rows)


def _sections(comparison: Comparison) -> list[Section]:
    difference = (
        "b minus a over the square root of the sum of both variances, which assumes independent "
        "data."
    )
    rows = tuple(
        (
            p.name,
            number(p.a.value),
            number(p.a.std, 3),
            number(p.b.value),
            number(p.b.std, 3),
            ("▲ " if p.moved else "") + number(p.sigmas, 3),
            p.a.unit,
            folded(p.a.expression),
        )
        for p in comparison.parameters
    )
    table = Table(
        ("name", "a", "std", "b", "std", "apart, std", "unit", "formula"),
        rows,
        ("name", *("number",) * 5, "unit", "formula"),
        frozenset(k for k, p in enumerate(comparison.parameters) if p.moved),
    )
    text = (
        "Each value over that of the first estimate, with 2 std to either side; weak ones are pale."
    )
    moved = partial(parameter_plots.moved, comparison)
    sections = [
        Section("Differences", (difference,), table, moved, told=()),
        Section("Values", (text,), figure=partial(parameter_plots.both_values, comparison)),
        Section(
            "Side by side",
            ("Residuals of different models and logs are not of the same quantity.",),
            Table(("", "a", "b"), _side_by_side(comparison), ("name", "number", "number")),
            told=(),
        ),
    ]
    for label, estimate in (("a", comparison.a), ("b", comparison.b)):
        if estimate.reasons:
            sections.append(Section(f"Why {label} is {estimate.verdict}", estimate.reasons))
    if comparison.left_out:
        told = f"{counted(len(comparison.left_out), 'parameter')} cannot be compared."
        left = Table(("name", "why"), comparison.left_out, ("name", "text"))
        sections.append(Section("Not compared", (told,), left, told=()))
    notes = tuple(f"{n[:1].upper()}{n[1:]}." for n in comparison.notes)
    sections.append(Section("Notes", notes, told=tuple(f"note: {n}" for n in comparison.notes)))
    a, b = (dict(e.provenance) for e in (comparison.a, comparison.b))
    origin = [
        (key, _short(a.get(key, "-")), _short(b.get(key, "-"))) for key in dict.fromkeys((*a, *b))
    ]
    table = Table(("item", "a", "b"), (("estimate", *comparison.names), *origin))
    sections.append(Section("Provenance", table=table))
    return sections


def _short(text: str) -> str:
    """Return the start of a digest; the estimates hold it whole."""
    return f"{text[:12]}..." if len(text) == 64 and " " not in text else text
