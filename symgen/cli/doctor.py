"""The command `doctor`: the state of the installation."""

from __future__ import annotations

import click

from symgen.report.terminal import say, table


@click.command()
def doctor() -> int:
    """Check compiler, libraries and cache. Exit code 1: something that symgen needs is missing."""
    from symgen.runtime.doctor import examine

    found = examine()
    table(("", "found"), [(f.name if f.well else f"{f.name} !", f.found) for f in found])
    for f in found:
        if f.advice:  # one line to copy, which a narrow table would break
            say(f"{f.name}: {f.advice}")
    return 0 if all(f.well for f in found) else 1
