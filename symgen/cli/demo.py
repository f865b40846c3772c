"""The command `demo`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from symgen.cli.options import into
from symgen.cli.progress import stages
from symgen.report.terminal import say

_STEPS = {"simulating": 0.05, "identifying": 0.3, "finishing": 0.85}
_MARKER = "diagnosis/diagnosis.json"


@click.command()
@into(_MARKER, required=False, default=Path("symgen-demo"), help="Folder of the results.")
def demo(into: Path) -> None:
    """Identify a 7-axis arm, and find the effect that its model lacks."""
    from symgen.cli.demonstration import demonstrate
    from symgen.files import write_folder

    with stages(_STEPS) as told:
        done = demonstrate(told)
        files = done.files()
    write_folder(into, files, _MARKER)
    say(done.text())
    place = into / "diagnosis/report.html"
    say(f"written: {place}")
    if sys.stdout.isatty():
        click.launch(str(place.absolute()))
