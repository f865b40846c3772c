"""The command `demo`: the example of the paper."""

from __future__ import annotations

from pathlib import Path

import click

from symgen.cli.options import into
from symgen.cli.progress import stages
from symgen.report.terminal import print_content

_SHOWING = {"compiling": 0.05, "(a)": 0.15, "(b)": 0.55}
_MARKER, _PAGE = "demo.json", "demo.html"


@click.command()
@into(
    _MARKER,
    required=False,
    default=Path("symgen-demo"),
    help="Folder for the page.",
)
@click.option(
    "--runs",
    default=1000,
    type=click.IntRange(10, 100_000),
    help="Number of simulated experiments.",
)
def demo(into: Path, runs: int) -> None:
    """Reproduce the example of Gautier and Khalil (1988), and write a page."""
    from symgen.experiment.paper import reproduce
    from symgen.files import write_folder
    from symgen.report.content.demo import demo_content
    from symgen.report.html import page

    with stages(_SHOWING) as told:
        found = reproduce(runs, told)
        said = demo_content(found)
    write_folder(into, {_PAGE: page(said).encode(), **found.files(_MARKER)}, _MARKER)
    print_content(said)
    click.echo(f"written: {into / _PAGE}")
