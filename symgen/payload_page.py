"""The page and the files of a payload."""

from __future__ import annotations

import json

from symgen.identification.payload_result import MARKER, Payload
from symgen.report import Section, Table, number, page, percent


def payload_files(found: Payload) -> dict[str, bytes]:
    """Return payload.json and report.html."""
    return {
        MARKER: (json.dumps(found.to_json(), indent=1) + "\n").encode(),
        "report.html": payload_page(found).encode(),
    }


def payload_page(found: Payload) -> str:
    """Return the page: the load with its precision, how well it explains the logs, notes."""
    rows = []
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
        (("without the load", percent(found.before)), ("with it", percent(found.after))),
        ("name", "number"),
    )
    text = f"By {found.method}; error is ||measured - model|| over ||measured||."
    sections = [Section("Load", (), table), Section("Fit", (text,), fit)]
    if found.notes:
        sections.append(Section("Notes", found.notes))
    return page(f"Payload of {found.robot}", lead, sections)
