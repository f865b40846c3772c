"""symgen demo on the command line."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from symgen.cli.options import into
from symgen.cli.progress import stages
from symgen.report.terminal import print_content, say

_STEPS = {"simulating": 0.05, "identifying": 0.2, "diagnosing": 0.4, "finishing": 0.8}
_PAPER = {"compiling": 0.05, "(a)": 0.15, "(b)": 0.55}


_MARKER = "demo.json"


@click.command()
@into(_MARKER, required=False, default=Path("symgen-demo"), help="Folder of the results.")
@click.option("--paper", is_flag=True, help="Run the example of Gautier and Khalil (1988).")
@click.option(
    "--runs", default=1000, type=click.IntRange(10, 100_000), help="Runs of the paper's example."
)
def demo(into: Path, paper: bool, runs: int) -> None:
    """Identify a 7-axis arm, find the effect that its model lacks, and compile the better model."""
    from symgen.cli.demonstration import demonstrate
    from symgen.files import write_folder

    if paper:
        from symgen.experiment.paper import reproduce
        from symgen.report.content.demo import demo_content
        from symgen.report.html import page

        with stages(_PAPER) as told:
            found = reproduce(runs, told)
            content = demo_content(found)
        files = {"demo.html": page(content).encode(), **found.files(_MARKER)}
    else:
        with stages(_STEPS) as told:
            done = demonstrate(told)
            files = done.files(_MARKER)
    write_folder(into, files, _MARKER)
    if paper:
        print_content(content)
    else:
        for line in done.lines():
            say(line)
    place = into / ("demo.html" if paper else "diagnosis/report.html")
    click.echo(f"written: {place}")
    if sys.stdout.isatty():
        click.launch(str(place.absolute()))
