"""What is said of a payload."""

from __future__ import annotations

from symgen.identification.payload import Payload
from symgen.report.content.parts import (
    Banner,
    Content,
    Section,
    Table,
    notes_section,
    number,
    percent,
    run_lines,
)


def payload_content(found: Payload) -> Content:
    """Return the load with its precision, how well it explains the logs, notes."""
    left, rows = found.residual, []
    for name, q, unit in found.rows():
        value = "not determined" if q.value is None else number(q.value)
        std = "" if q.std is None else number(q.std, 2)
        rows.append((name, value, std, unit))
    lead = (
        f"What {found.robot} carries, in the frame of joint {found.frame}; inertia is about the "
        "centre of mass.",
    )
    table = Table(("", "value", "std", "unit"), rows)
    fit = Table(
        ("error of torque", ""),
        (
            ("without the load", percent(left.before)),
            ("with it", percent(left.after)),
        ),
    )
    text = f"By {found.method}; error is ||measured - model|| over ||measured||."
    sections = (
        Section("Load", (), table, told=()),
        Section("Fit", (text,), fit, told=()),
        *notes_section(found.notes),
    )
    mass = found.mass
    told = "The mass is not determined" if mass.value is None else f"{number(mass.value, 4)} kg"
    if mass.value is not None and mass.std is not None:
        told += f" ± {number(2 * mass.std, 2)} kg"
    text = (
        f"With the load the model leaves {percent(left.after)} of the torque, without it "
        f"{percent(left.before)}; ± is twice the standard deviation."
    )
    banner, run = Banner("plain", told, text), run_lines(found.band, found.repairs)
    return Content(f"Payload of {found.robot}", lead, sections, banner, run)
