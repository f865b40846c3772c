"""Views of results in Python: plots and notebook panels from the report package."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol


class Figure(Protocol):
    """A figure of a page, which a notebook displays."""

    def save(self, path: str | Path) -> None:
        """Write the figure to a file."""


class Views(Protocol):
    """The functions of the report package."""

    def figure(self, result: Any, name: str | None) -> Figure:
        """Return a figure of the page of a result."""

    def panel(self, result: Any) -> str:
        """Return the first panel of the page of a result, as HTML."""


def _views() -> Views:
    import symgen

    return symgen.load_views()


class Viewable:
    """A result with the views of its page: a panel in notebooks, and figures."""

    def plot(self, name: str | None = None) -> Figure:
        """Return a figure of the report page; a notebook displays it, `.save(path)` writes it.

        Args:
            name: heading of the figure on the page; by default its first figure.

        Raises:
            ParameterError: the page has no figure with this name; the message lists the names.
        """
        return _views().figure(self, name)

    def _repr_html_(self) -> str:
        return _views().panel(self)
