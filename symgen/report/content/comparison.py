"""Content of a comparison: two estimates of one robot."""

from __future__ import annotations

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

_DIFFERENCE = (
    "b minus a over the square root of the sum of both variances, which assumes independent data."
)
TONES = {"agree": "good", "differ": "warn", "unknown": "warn"}


def comparison_content(c: Comparison) -> Content:
    """Return verdict, parameters and their differences, residuals, and provenance."""
    lead = (f"Two estimates of the robot {c.a.robot}: a is {c.names[0]}, b is {c.names[1]}.",)
    reasons = tuple(
        f"{p.name}: {number(p.a.value, 4)} in a, {number(p.b.value, 4)} {p.a.unit} in b, "
        f"a difference of {number(p.sigmas, 3)} combined std"
        for p in c.moved[:10]
    )
    facts = (
        ("parameters compared", str(len(c.parameters))),
        ("moved", str(len(c.moved))),
        ("not compared", str(len(c.left_out))),
        ("verdict of a", c.a.verdict),
        ("verdict of b", c.b.verdict),
    )
    banner = Banner(TONES[c.verdict], c.verdict, c.summary, reasons, facts)
    return Content(f"Two estimates of {c.a.robot}", lead, _sections(c), banner)


def _of_itself(e: Estimate) -> dict[str, str]:
    """Return the summary of one estimate."""
    residuals = {
        "residual, training": e.train,
        "residual, validation": e.validation,
        "torque residual, training": e.torque_train,
        "torque residual, validation": e.torque_validation,
    }
    return {
        **{"verdict": e.verdict, "model": e.model, "method": e.method},
        **{k: "-" if r is None else percent(r.relative) for k, r in residuals.items()},
        "condition number, scaled": number(e.condition_number, 4),
        "window, s": "-" if e.window_s is None else f"{e.window_s:g}",
        "filter cutoff, Hz": "-" if e.cutoff_hz is None else f"{e.cutoff_hz:g}",
    }


def _sections(c: Comparison) -> tuple[Section, ...]:
    rows = [
        (
            *(p.name, number(p.a.value), number(p.a.std, 3), number(p.b.value), number(p.b.std, 3)),
            "▲ " * p.moved + number(p.sigmas, 3),
            p.a.unit,
            folded(p.a.expression),
        )
        for p in c.parameters
    ]
    table = Table(("name", "a", "std", "b", "std", "distance, std", "unit", "formula"), rows)
    second = _of_itself(c.b)
    sides = [(key, value, second[key]) for key, value in _of_itself(c.a).items()]
    left = f"{counted(len(c.left_out), 'parameter')} cannot be compared."
    a, b = (dict(e.provenance) for e in (c.a, c.b))
    origin = [(key, _short(a.get(key, "-")), _short(b.get(key, "-"))) for key in {**a, **b}]
    return (
        Section("Differences", (_DIFFERENCE,), table, printed=()),
        Section(
            "Side by side",
            ("Residuals of different models and logs are not of the same quantity.",),
            Table(("", "a", "b"), sides),
            printed=(),
        ),
        Section(f"Why a is {c.a.verdict}", tuple(r.text for r in c.a.reasons)),
        Section(f"Why b is {c.b.verdict}", tuple(r.text for r in c.b.reasons)),
        Section("Not compared", (left,), Table(("name", "why"), c.left_out), printed=()),
        Section(
            "Notes",
            tuple(f"{n[:1].upper()}{n[1:]}." for n in c.notes),
            printed=tuple(f"note: {n}" for n in c.notes),
        ),
        Section("Provenance", table=Table(("item", "a", "b"), (("estimate", *c.names), *origin))),
    )


def _short(text: str) -> str:
    """Return the start of a digest; the estimate file contains the full digest."""
    return f"{text[:12]}..." if len(text) == 64 and " " not in text else text
