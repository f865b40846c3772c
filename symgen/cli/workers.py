"""Options of commands whose work can be spread."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from symgen import Workers

_OPTIONS = (
    click.option("--workers", type=click.IntRange(min=1), help="Processes that share the work."),
    click.option("--scheduler", help="Address of a Dask scheduler whose workers do it."),
)


def worker_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the arguments `workers` and `scheduler`."""
    return reduce(lambda wrapped, option: option(wrapped), reversed(_OPTIONS), command)


def workers_of(
    processes: int | None, scheduler: str | None, work: Path | None = None
) -> Workers | None:
    """Return who does the work, or None where no option says so."""
    from symgen import Workers

    asked = Workers(processes, scheduler, work)
    return None if asked == Workers() else asked
