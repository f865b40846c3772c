"""What the command line tells of a job while it runs: lines and a bar on stderr."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import click

_COUNT = re.compile(r"([\d,]+) of ([\d,]+)")
#: A job shorter than this, s, shows no bar.
_LONG = 2.0


def say(message: str) -> None:
    """Tell on stderr what is being done."""
    click.echo(click.style(f"  {message}", dim=True), err=True)


@contextmanager
def meter(label: str) -> Iterator[Callable[[float], None]]:
    """Yield what shows the part of a long job that is done, as a bar on a terminal's stderr.

    The bar comes when the job has taken 2 s, and says how long it still takes.
    """
    with _bar() as (bar, task, advance):
        bar.update(task, description=label)
        yield advance


@contextmanager
def stages(shares: Mapping[str, float]) -> Iterator[Callable[[str], None]]:
    """Yield a `say` that moves a bar as well, by what has been done when each stage begins.

    A message that counts, "days: 3 of 12 days", moves the bar within its stage.

    Args:
        shares: the first word of a message, and the part of the time that passes before it, about;
            a message that is not among them leaves the bar where it is.
    """
    with _bar() as (bar, task, advance):

        def told(message: str) -> None:
            say(message)
            word = message.split(maxsplit=1)[0].rstrip(":")
            share = shares.get(word, 0.0)
            if word in shares and (count := _COUNT.search(message)):
                done, total = (float(x.replace(",", "")) for x in count.groups())
                after = min((x for x in shares.values() if x > share), default=1.0)
                share += (after - share) * min(done / max(total, 1.0), 1.0)
            if share > bar.tasks[0].completed:
                advance(share)
            bar.update(task, description=message)

        yield told


@contextmanager
def _bar() -> Iterator[tuple[Any, Any, Callable[[float], None]]]:
    """Yield a bar with the time left, its task, and what sets the part that is done."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.table import Column

    console = Console(stderr=True)
    begun = time.monotonic()
    columns = (
        TextColumn("{task.description}", table_column=Column(ratio=1, no_wrap=True)),
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
    """Return how long a job still takes whose `part` was done in `elapsed` s; at first nothing."""
    if not 0.02 < part < 1:
        return ""
    left = elapsed * (1 - part) / part
    return f"about {left:.0f} s left" if left < 90 else f"about {left / 60:.0f} min left"
