"""The views of a result in Python: figures, and the first panel of its page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from symgen.errors import ParameterError
from symgen.report.html import notebook_panel as panel_of
from symgen.report.store import Value, content

if TYPE_CHECKING:
    from symgen.report.plots.figure import Figure


def panel(result: Value) -> str:
    """Return the verdict and the first table of the page of a result, as HTML for a notebook."""
    return panel_of(content(result))


def figure(result: Value, name: str | None = None) -> Figure:
    """Return a figure of the page of a result.

    Args:
        result: a result of a function of symgen.
        name: heading of the figure on the page; by default its first figure.

    Raises:
        ParameterError: the page has no such figure.
    """
    drawn = (f for heading, f in _figures(result) if name in (None, heading))
    found = next(drawn, None)
    if found is None:
        names = ", ".join(heading for heading, _ in _figures(result)) or "none"
        what = "there is nothing to draw" if name is None else f"no figure {name!r}"
        raise ParameterError(f"{result!r}: {what}; accepted: {names}")
    return found


def _figures(result: Value) -> Iterator[tuple[str, Figure]]:
    """Yield heading and figure of the sections that have one; each is drawn on demand."""
    for section in content(result).sections:
        found = None if section.figure is None else section.figure()
        if found is not None:
            yield section.heading, found
