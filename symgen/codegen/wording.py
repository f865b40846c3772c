"""How documents of a package say shapes, inputs, columns and names."""

from __future__ import annotations

import html
import re
import textwrap

from symgen.codegen.kernels import LINK, SCALARS

_LINE = 100  # columns of a header


def shape_text(shape: tuple[int, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"


def input_text(prefix: str, name: str, size: int) -> str:
    if name == LINK:
        return (
            f"number of a joint in robot.toml, 1 to {size}; with any other the function returns "
            f"{prefix}_NO_SUCH_LINK and writes nothing"
        )
    return "a number" if name in SCALARS else f"({size},)"


def wrapped(text: str, indent: str = "", width: int = _LINE - 4) -> list[str]:
    return textwrap.wrap(
        text, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def columns_text(columns: tuple[str, ...]) -> str:
    return f": {', '.join(columns)}" if columns else ""


def markdown(name: str) -> str:
    """Return a free text as Markdown that shows it: no tag of HTML, no link, no cell of its own."""
    return re.sub(r"([\\`*\[\]|!])", r"\\\1", html.escape(name, quote=False))
