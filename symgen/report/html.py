"""Pages: one HTML file that holds everything, plotly.js too, and asks nothing of a network."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from symgen.files import rendered
from symgen.report.content.parts import Content, Section

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


#: Columns of numbers that fit side by side on a phone.
_NARROW = 5


def page(content: Content) -> str:
    """Return a whole HTML page; the same content gives the same text."""
    drawn = [(s, None if s.figure is None else s.figure()) for s in content.sections]
    shown = [
        (s, figure)
        for s, figure in drawn
        if figure is not None or s.table or s.picture or (s.text and s.figure is None)
    ]
    banner = content.banner
    if banner is not None:  # a sentence on top of a page
        verdict = banner.verdict.replace("partly-", "partly ").replace("bad-", "bad ")
        banner = replace(banner, verdict=verdict[:1].upper() + verdict[1:])
    return rendered(
        "report/report.html",
        title=content.title,
        lead=content.lead,
        banner=banner,
        pictures=any(section.picture for section, _ in shown),
        sections=[_view(k, section, figure) for k, (section, figure) in enumerate(shown, 1)],
        plotly=_plotly_js() if any(figure is not None for _, figure in shown) else None,
    )


def _view(place: int, section: Section, figure: Figure | None) -> dict[str, Any]:
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
    if figure is not None:
        layout = figure.layout
        # the heading stands for the figure's own title
        figure.update_layout(title=None, margin={"t": max(layout.margin.t - 30, 36)})
        meta = layout.meta if isinstance(layout.meta, dict) else {}
        view["figure"] = {
            "id": f"figure{place}",
            "height": int(layout.height or 450),
            "min_width": int(meta.get("min_width", 0)),
            "grid": bool(meta.get("grid", False)),
            "json": _script_safe(figure),
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
