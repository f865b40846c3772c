"""Reports: one HTML page that holds everything, plotly.js too, and asks nothing of a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from symgen.files import rendered

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Attributes:
        header: one text a column.
        rows: one text a column in each.
        styles: "text", "number", "name", "words" or "formula" for each column; empty: all text.
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


def drawn(heading: str, text: str, figure: Figure, table: Table | None = None) -> Section:
    """A section whose heading stands for the figure's own title, which is taken off."""
    room = figure.layout.margin.t - 30
    figure.update_layout(title=None, margin={"t": max(room, 36)})
    return Section(heading, (text,), table, figure)


def counted(count: int, noun: str) -> str:
    """Return "1 pair", "2 pairs"."""
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
