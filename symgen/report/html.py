"""Pages: one HTML file that holds everything, plotly.js too, and asks nothing of a network."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from symgen.files import rendered
from symgen.report.content.parts import Banner, Content, Table

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


#: Letters that fit side by side on a phone.
_NARROW = 48
#: Letters of a cell from which it wraps; what stands in a column of numbers, none of it among them.
_LONG = 24
_NUMBER = re.compile(r"(▲ )?[-+]?[\d.∞].{0,12}$|$|-$|unknown|searched|never|not determined")


def page(content: Content) -> str:
    """Return a whole HTML page; the same content gives the same text."""
    views = []
    for section in content.sections:
        figure = None if section.figure is None else section.figure()
        table = section.table if section.table and section.table.rows else None
        alone = section.text and not (section.figure or section.table)
        if figure or table or section.picture or alone:
            drawn = None if figure is None else _figure(figure)
            views.append((section, drawn, None if table is None else _table(table)))
    return rendered(
        "report/report.html",
        content=content,
        banner=_banner(content.banner),
        sections=views,
        plotly=_plotly_js() if any(drawn for _, drawn, _ in views) else None,
    )


def notebook_panel(content: Content) -> str:
    """Return the first panel of a page for a notebook: the verdict and the first table."""
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
    """Return the verdict as a page writes it: with a capital letter."""
    if banner is None:
        return None
    verdict = banner.verdict.replace("partly-", "partly ").replace("bad-", "bad ")
    return replace(banner, verdict=verdict[:1].upper() + verdict[1:])


def _table(table: Table) -> dict[str, Any]:
    """Return what the template places: rows, whether they are pointed out, and styles of cells."""
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


def _figure(figure: Figure) -> dict[str, Any]:
    """Return what the template places: JSON that is safe inside a script, and its size."""
    layout = figure.layout
    # the heading stands for the figure's own title
    figure.update_layout(title=None, margin={"t": max(layout.margin.t - 30, 36)})
    meta = {"min_width": 0, "grid": False, **(layout.meta or {})}
    import plotly.io

    text = plotly.io.to_json(figure, engine="json")
    for character in "<>&\u2028\u2029":  # no character that could end the script that holds it
        text = text.replace(character, f"\\u{ord(character):04x}")
    return {**meta, "height": int(layout.height or 450), "json": Markup(text)}


def _style(cells: Sequence[str], first: bool) -> str:
    """Return how a column is set: "number", "formula", "words" that wrap, "name" or "unit"."""
    if not first and all(_NUMBER.match(cell) for cell in cells):
        return "number"
    if any("*" in cell for cell in cells):
        return "formula"
    if max(map(len, cells), default=0) > _LONG:
        return "words"
    return "name" if first else "unit"


def _plotly_js() -> Markup:
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs())
