"""Options of commands whose work can be spread."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import click

_OPTIONS = (
    click.option("--workers", type=click.IntRange(min=1), help="Processes that share the work."),
    click.option("--scheduler", help="Address of a Dask scheduler whose workers do it."),
)


def worker_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the arguments `workers` and `scheduler`."""
    return reduce(lambda wrapped, option: option(wrapped), reversed(_OPTIONS), command)
