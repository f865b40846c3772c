"""symgen demo on the command line."""

from __future__ import annotations

from pathlib import Path

import click

from symgen.cli.options import PATH
from symgen.cli.progress import stages
from symgen.report.terminal import print_content

_SHOWING = {"compiling": 0.05, "(a)": 0.15, "(b)": 0.55}


@click.command()
@click.option(
    "--into",
    type=PATH,
    default=Path("symgen-demo"),
    show_default=True,
    help="Folder of the page.",
)
@click.option("--runs", default=1000, show_default=True, type=click.IntRange(10, 100_000))
def demo(into: Path, runs: int) -> int:
    """Run the example of Gautier and Khalil (1988) end to end."""
    from symgen.experiment.paper import MARKER, PAGE, reproduce
    from symgen.files import check_replaceable, write_folder
    from symgen.report.content.demo import demo_content
    from symgen.report.html import page

    check_replaceable(into, MARKER)
    with stages(_SHOWING) as told:
        found = reproduce(runs, told)
        said = demo_content(found)
    write_folder(into, {PAGE: page(said).encode(), **found.files()}, MARKER)
    print_content(said)
    click.echo(f"written: {into / PAGE}")
    return 0
