"""symgen doctor on the command line."""

from __future__ import annotations

import click

from symgen.report.terminal import table


@click.command()
def doctor() -> int:
    """Look at what symgen uses on this machine. Exit code 1: something that it needs is missing."""
    from symgen.runtime.doctor import examine

    found = examine()
    table(("", "found"), [(f.name if f.well else f"{f.name} !", f.found) for f in found])
    for f in found:
        if f.advice:  # whole, to be copied: a table would break it in a narrow terminal
            click.echo(f"{f.name}: {f.advice}")
    return 0 if all(f.well for f in found) else 1
