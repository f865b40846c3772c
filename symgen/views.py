"""Views of results in Python: plots and notebook panels, which the report layer makes."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol


class Figure(Protocol):
    """A figure of a page, which a notebook shows."""

    def save(self, path: str | Path) -> None:
        """Write it as a file."""


class Views(Protocol):
    """The functions of the report layer."""

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
        """Return a figure of the report page; a notebook shows it, `.save(path)` writes it.

        Args:
            name: heading of the figure on the page; by default its first figure.

        Raises:
            ParameterError: the page has no figure of this name; the message lists the names.
        """
        return _views().figure(self, name)

    def _repr_html_(self) -> str:
        return _views().panel(self)
