"""Progress of a command on stderr: lines and a bar."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import click

from symgen.errors import plain

_COUNT = re.compile(r"([\d,]+) of ([\d,]+)")
#: Shorter jobs show no bar, s.
_LONG = 2.0


def say_progress(message: str) -> None:
    """Print a progress message to stderr."""
    click.echo(click.style(f"  {plain(message)}", dim=True), err=True)


@contextmanager
def meter(label: str) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the finished share of a job (0 to 1) and shows it as a bar.

    The bar appears on a terminal after 2 s, with the estimated remaining time.
    """
    with _bar() as (bar, task, advance):
        bar.update(task, description=label)
        yield advance


@contextmanager
def stages(shares: Mapping[str, float]) -> Iterator[Callable[[str], None]]:
    """Yield a `say_progress` that also moves a bar at the start of a stage.

    A message with a count, "days: 3 of 12 days", moves the bar within its stage.

    Args:
        shares: first word of a message -> approximate share of the time that passes before it. A
            message that is not listed does not move the bar.
    """
    with _bar() as (bar, task, advance):

        def told(message: str) -> None:
            say_progress(message)
            word = message.split(maxsplit=1)[0].rstrip(":")
            share = shares.get(word, 0.0)
            if word in shares and (count := _COUNT.search(message)):
                done, total = (float(x.replace(",", "")) for x in count.groups())
                after = min((x for x in shares.values() if x > share), default=1.0)
                share += (after - share) * min(done / max(total, 1.0), 1.0)
            if share > bar.tasks[0].completed:
                advance(share)
            bar.update(task, description=plain(message))

        yield told


@contextmanager
def _bar() -> Iterator[tuple[Any, Any, Callable[[float], None]]]:
    """Yield a bar, its task, and a function that sets the finished share."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.table import Column

    console = Console(stderr=True)
    begun = time.monotonic()
    columns = (
        TextColumn("{task.description}", table_column=Column(ratio=1, no_wrap=True), markup=False),
        BarColumn(bar_width=20),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("", total=1.0, visible=False, left="")

        def advance(part: float) -> None:
            now = time.monotonic() - begun
            bar.update(task, completed=part, visible=now > _LONG, left=_left(now, part))

        yield bar, task, advance


def _left(elapsed: float, part: float) -> str:
    """Return the estimated remaining time as text; "" if it is too early for an estimate."""
    if not 0.02 < part < 1:
        return ""
    left = elapsed * (1 - part) / part
    return f"about {left:.0f} s left" if left < 90 else f"about {left / 60:.0f} min left"
