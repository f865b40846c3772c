"""Print to the command line: tables and verdicts on stdout."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from symgen.errors import plain

if TYPE_CHECKING:
    from symgen.experiment.simulate import Simulation
    from symgen.report.content.parts import Banner, Content
    from symgen.report.store import Value
    from symgen.robot.types import Robot

_SHORT = 20  # maximum length of a cell that does not wrap
_COLOURS = {"good": "green", "warn": "yellow", "bad": "red"}
#: Letters that a terminal may not support.
_PLAIN = str.maketrans({"▲": "!", "∞": "inf", "±": "+-", "‖": "||", "√": "sqrt ", "é": "e"})


def table(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    """Print a table no wider than the terminal; files and pipes get the full width.

    Cells wrap between words. If the longest words of the columns do not fit into a line, a row
    becomes a paragraph.
    """
    from rich.console import Console
    from rich.table import Column, Table
    from rich.text import Text

    header, rows = tuple(map(plain, header)), [tuple(map(plain, row)) for row in rows]
    widths = _widths(header, rows)
    if widths is None:
        for row in rows:
            say(_paragraph(header, row))
        return
    columns = (Column(Text(name), width=width) for name, width in zip(header, widths, strict=True))
    grid = Table(*columns, box=None, pad_edge=False, header_style="bold")
    for row in rows:
        grid.add_row(*map(Text, row))  # as Text, so that brackets in a name are no markup
    console = Console(highlight=False, width=sum(widths) + 2 * len(widths))
    with console.capture() as captured:
        console.print(grid)
    for line in captured.get().splitlines():
        _print(line.rstrip())


def _room() -> int | None:
    """Return the number of letters in a line of the terminal; None for a file or a pipe."""
    shown = sys.stdout is not None and sys.stdout.isatty()  # None: closed by the shell
    return shutil.get_terminal_size().columns if shown else None


def _widths(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[int] | None:
    """Return the widths of the columns; None if their longest words do not fit into a line."""
    columns = [[name, *cells] for name, *cells in zip(header, *rows, strict=True)]
    wanted = [max(map(len, column)) for column in columns]
    least = [
        max(len(part) for k, text in enumerate(column) for part in _parts(text, k == 0))
        for column in columns
    ]
    room = _room()
    if room is None or sum(wanted) + 2 * len(wanted) <= room:
        return wanted
    spare = room - sum(least) - 2 * len(least)
    if spare < 0:
        return None
    widths, left = least, sorted(range(len(least)), key=lambda k: wanted[k] - least[k])
    # the narrowest columns get their width first, and the rest is shared
    for done, k in enumerate(left):
        more = min(wanted[k] - least[k], spare // (len(left) - done))
        widths[k], spare = least[k] + more, spare - more
    return widths


def _parts(text: str, head: bool) -> list[str]:
    """Return the parts that do not wrap: words, or a short cell such as "0.445 N m"."""
    return text.split(" ") if head or len(text) > _SHORT else [text]


def _paragraph(header: tuple[str, ...], row: tuple[str, ...]) -> str:
    """Return a row as text: its first cell, then the others with the headers of their columns."""
    first, *others = row
    cells = [
        f"{name}: {cell}" if name else cell
        for name, cell in zip(header[1:], others, strict=True)
        if cell
    ]
    return "\n".join(filter(None, (first, wrapped("; ".join(cells), "  "))))


def wrapped(text: str, indent: str = "") -> str:
    """Return a text with lines no longer than those of the terminal."""
    room = _room()
    if room is None or len(indent + text) <= room:
        return indent + text
    lines = textwrap.wrap(
        text.replace(" %", "\xa0%"),  # no break between a number and its percent sign
        room,
        initial_indent=indent,
        subsequent_indent=indent + "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return "\n".join(lines).replace("\xa0", " ")


def say(text: str) -> None:
    """Print lines of text without control characters, which a terminal would interpret."""
    _print("\n".join(map(plain, text.split("\n"))))


def _print(text: str) -> None:
    """Print a text; replace letters that the terminal does not support."""
    try:
        text.encode(getattr(sys.stdout, "encoding", None) or "utf-8")
    except UnicodeEncodeError:
        known = text.translate(_PLAIN)
        text = "".join("*" if ord(c) > 0x2800 else c if ord(c) < 128 else "-" for c in known)
    click.echo(text)


def print_simulation(done: Simulation, robot: Robot) -> None:
    """Print the largest position, speed and torque of each joint of a simulation, and the notes."""
    rows = [
        (
            robot.label(number),
            f"{done.q[:, :, j].min():.4g} to {done.q[:, :, j].max():.4g}",
            f"{abs(done.qd[:, :, j]).max():.4g}",
            f"{abs(done.tau[:, :, j]).max():.4g}",
            f"{100 * float((done.qd[:, :, j] == 0).mean()):.3g} %",
        )
        for j, number in enumerate(done.joints)
    ]
    table(("joint", "position", "top speed", "top torque", "at rest"), rows)


def print_result(result: Value) -> bool:
    """Print a result: notes on the logs, tables, and the verdict at the end.

    Returns:
        Whether the verdict is positive (trusted, consistent, explained, ...), or there is none.
    """
    from symgen.report.store import content

    shown = content(result)
    print_content(shown)
    return shown.good


def print_content(content: Content) -> None:
    """Print the content of a result."""
    for line in content.lead:
        say(wrapped(line))
    if content.banner is not None:
        _print_verdict(content.banner)
    for section in (s for s in content.sections if s.printed is not None):
        if section.table is not None and section.table.rows and not section.folded:
            click.echo(f"\n{click.style(section.heading, bold=True)}")
            table(section.table.header, section.table.rows)
        for line in section.printed or ():
            say(wrapped(line))
    for line in content.run:
        say(wrapped(line))


def _print_verdict(banner: Banner) -> None:
    """Print the verdict, its reasons, and the most important numbers."""
    start = "" if banner.tone == "plain" else "verdict: "
    verdict = plain(banner.verdict)
    _print("\n" + start + click.style(verdict, fg=_COLOURS.get(banner.tone), bold=True))
    headline = [banner.headline] if banner.headline else []
    reasons = (f"- {reason}" for reason in banner.reasons)
    for line in (*headline, *banner.text.splitlines(), *reasons):
        say(wrapped(line, "  "))
    for label, value in banner.facts:
        say(f"{label}: {value}")
