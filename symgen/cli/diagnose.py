"""symgen diagnose on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import CUTOFF, LOGS, ROBOT, into, listed, reading_options
from symgen.cli.progress import stages
from symgen.report.terminal import print_result

PERCENT = click.FloatRange(0, 100, min_open=True)
#: First word of what a command says, and the part of its time that has passed then.
_DIAGNOSING = {"reading": 0.02, "deriving": 0.05, "checking": 0.12, "trying": 0.2,
               "looking": 0.6, "writing": 0.85}  # fmt: skip


@click.command()
@ROBOT
@LOGS
@click.option("--validation", multiple=True, help="A log to show the gap on; may be repeated.")
@click.option("--parameters", help="Given ones, not identified again: what has changed since?")
@click.option("--effects", help="Comma-separated names to try; default all (symgen explain).")
@CUTOFF
@click.option("--least", type=PERCENT, default=0.8, help="Percent of a torque that matters.")
@click.option("--misfit", type=PERCENT, default=0.4, help="Percent no model is righter than.")
@reading_options
@into("diagnosis.json")
def diagnose(effects: str | None, into: Path, least: float, misfit: float, **options: Any) -> int:
    """Find what the model of ROBOT misses in LOGS, name it, add it, and show the gap shrink."""
    import symgen

    tried = None if effects is None else listed(effects)
    with stages(_DIAGNOSING) as told:
        diagnosis = symgen.diagnose(
            effects=tried, least=least / 100, misfit=misfit / 100, progress=told, **options
        )
        told("writing the page and the extended model")
        symgen.write(diagnosis, into)
    good = print_result(diagnosis)
    names = "diagnosis.json, report.html, robot.toml, parameters.toml, generated/"
    click.echo(f"written: {into} ({names})")
    return 0 if good else 1
