"""Reports: one HTML page that holds everything, plotly.js too, and asks nothing of a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from symgen.files import rendered
from symgen.report.plots.robot import drawing
from symgen.robot.table import HEADER, table_rows

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

    from symgen.robot.types import Robot


#: Columns of numbers that fit side by side on a phone.
_NARROW = 5


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
    """A heading with paragraphs, then a figure or a picture (SVG of our own), then a table."""

    heading: str
    text: tuple[str, ...] = ()
    table: Table | None = None
    figure: Figure | None = None
    picture: str = ""


@dataclass(frozen=True)
class Banner:
    """What the reader must see first.

    Attributes:
        tone: "good", "warn", "bad", or "plain" where there is no verdict: the colour.
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
        pictures=any(section.picture for section in sections),
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


def frames_section(robot: Robot) -> Section:
    """The frames of a robot as its Denavit-Hartenberg table has them."""
    text = (
        "The table with all joints at zero: axes z as lines, x dashed; revolute joints are "
        "circles, prismatic ones squares, each with the number of its frame."
    )
    rows = tuple(row[:-1] if not any(j.follows for j in robot.joints) else row
                 for row in table_rows(robot))  # fmt: skip
    header = HEADER[: len(rows[0])]
    table = Table(header, rows, ("name", *("text",) * (len(header) - 1)))
    return Section("The robot", (text,), table, picture=drawing(robot))


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
        "picture": Markup(section.picture),
    }
    if section.table is not None:
        table = section.table
        styles = table.styles or ("text",) * len(table.header)
        view["table"] = {
            "wide": len(styles) > _NARROW or bool({"words", "formula"} & set(styles)),
            "header": list(zip(styles, table.header, strict=True)),
            "rows": [
                {"flagged": k in table.flagged, "cells": list(zip(styles, row, strict=True))}
                for k, row in enumerate(table.rows)
            ],
        }
    if section.figure is not None:
        layout = section.figure.layout
        meta = layout.meta if isinstance(layout.meta, dict) else {}
        view["figure"] = {
            "id": f"figure{place}",
            "height": int(layout.height or 450),
            "min_width": int(meta.get("min_width", 0)),
            "grid": bool(meta.get("grid", False)),
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
