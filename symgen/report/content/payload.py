"""The page and the files of a payload."""

from __future__ import annotations

import json

from symgen.identification.payload_result import MARKER, Payload
from symgen.report.html import Banner, Section, Table, number, page, percent


def payload_files(found: Payload) -> dict[str, bytes]:
    """Return payload.json and report.html."""
    return {
        MARKER: (json.dumps(found.to_json(), indent=1) + "\n").encode(),
        "report.html": payload_page(found).encode(),
    }


def payload_page(found: Payload) -> str:
    """Return the page: the load with its precision, how well it explains the logs, notes."""
    left, rows = found.residual, []
    for name, q, unit in found.rows():
        value = "not determined" if q.value is None else number(q.value)
        std = "" if q.std is None else number(q.std, 2)
        rows.append((name, value, std, unit))
    lead = (
        f"What {found.robot} carries, in the frame of joint {found.frame}; inertia is about the "
        "centre of mass.",
    )
    styles = ("name", "number", "number", "unit")
    table = Table(("", "value", "std", "unit"), tuple(rows), styles)
    fit = Table(
        ("error of torque", ""),
        (
            ("without the load", percent(left.before)),
            ("with it", percent(left.after)),
        ),
        ("name", "number"),
    )
    text = f"By {found.method}; error is ||measured - model|| over ||measured||."
    sections = [Section("Load", (), table), Section("Fit", (text,), fit)]
    if found.notes:
        sections.append(Section("Notes", found.notes))
    mass = found.mass
    told = "The mass is not determined" if mass.value is None else f"{number(mass.value, 4)} kg"
    if mass.value is not None and mass.std is not None:
        told += f" ± {number(2 * mass.std, 2)} kg"
    text = (
        f"With the load the model leaves {percent(left.after, 3)} of the torque, without it "
        f"{percent(left.before, 3)}; ± is twice the standard deviation."
    )
    return page(f"Payload of {found.robot}", lead, sections, Banner("plain", told, text))
