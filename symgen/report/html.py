"""Pages: one HTML file that contains everything and needs no network."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from symgen.files import rendered
from symgen.report.content.parts import Banner, Content, Table

#: Letters that fit into one line on a phone.
_NARROW = 48
#: Length from which a cell wraps, in letters. No entry of a column of numbers is that long.
_LONG = 24
_NUMBER = re.compile(r"(▲ )?[-+]?[\d.∞].{0,12}$|$|-$|unknown|searched|never|not determined")


def page(content: Content) -> str:
    """Return the HTML page of some content; the same content gives the same text."""
    views = []
    for section in content.sections:
        figure = None if section.figure is None else section.figure()
        table = section.table if section.table and section.table.rows else None
        alone = section.text and not (section.figure or section.table)
        if figure or table or section.picture or alone:
            views.append((section, figure, None if table is None else _table(table)))
    banner = _banner(content.banner)
    return rendered("report/report.html", content=content, banner=banner, sections=views)


def notebook_panel(content: Content) -> str:
    """Return the first panel of a page, for a notebook: the verdict and the first table."""
    first = next((s for s in content.sections if s.table and s.table.rows), None)
    table = None if first is None or first.table is None else _table(first.table)
    return rendered(
        "report/panel.html",
        title=content.title,
        banner=_banner(content.banner),
        heading="" if first is None else first.heading,
        table=table,
    )


def _banner(banner: Banner | None) -> Banner | None:
    """Return the banner for a page: its verdict begins with a capital letter."""
    if banner is None:
        return None
    verdict = banner.verdict.replace("partly-", "partly ").replace("bad-", "bad ")
    return replace(banner, verdict=verdict[:1].upper() + verdict[1:])


def _table(table: Table) -> dict[str, Any]:
    """Return the values for the template: rows, highlighted or not, and styles of cells."""
    columns = list(zip(table.header, *table.rows, strict=True))
    styles = [_style(cells, k == 0) for k, (_, *cells) in enumerate(columns)]
    width = sum(2 + max(map(len, column)) for column in columns)
    return {
        "wide": bool({"words", "formula"} & set(styles)) or width > _NARROW,
        "header": list(zip(styles, table.header, strict=True)),
        "rows": [
            (any(c.startswith(("▲", "never")) for c in row), list(zip(styles, row, strict=True)))
            for row in table.rows
        ],
    }


def _style(cells: Sequence[str], first: bool) -> str:
    """Return the style of a column: "number", "formula", "words" (which wrap), "name" or "unit"."""
    if not first and all(_NUMBER.match(cell) for cell in cells):
        return "number"
    if any("*" in cell for cell in cells):
        return "formula"
    if max(map(len, cells), default=0) > _LONG:
        return "words"
    return "name" if first else "unit"
