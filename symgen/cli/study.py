"""The command `study`: bias and precision of an estimate, by simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import (
    DURATION,
    METHODS,
    MODELS,
    PARAMETERS,
    ROBOT,
    SEED,
    WINDOW,
    finish,
    into,
    one_of,
    recording_options,
    share,
    worker_options,
)
from symgen.cli.progress import meter, say


@click.command()
@ROBOT
@PARAMETERS
@click.option(
    "--trajectory", "trajectories", multiple=True, help="CSV of a motion, one log each; repeatable."
)
@click.option("--held-out", help="CSV of the motion along which torque is predicted.")
@recording_options
@click.option(
    "--model",
    "models",
    multiple=True,
    shell_complete=one_of(*MODELS),
    help="Repeatable; default all.",
)
@click.option(
    "--method", "methods", multiple=True, shell_complete=one_of(*METHODS),
    help="Repeatable; default ols, wls and iv.",
)  # fmt: skip
@WINDOW
@click.option("--cutoff", type=float, help="Of the filter, Hz; by default that of the first run.")
@DURATION
@click.option("--runs", default=100, help="Simulated and identified.")
@click.option("--target", default=2.0, callback=share, help="To know a parameter to, %.")
@SEED
@worker_options
@into("study.json")
def study(methods: tuple[str, ...], into: Path, **options: Any) -> int:
    """Tell how well motions and sensors determine ROBOT, and how long must be recorded.

    Runs are simulated with --parameters and the noise of the sensors, and identified; what is found
    is compared with what they were made of.
    """
    import symgen

    usual = methods or ("ols", "wls", "iv")
    with meter("studying") as advance:
        found = symgen.study(methods=usual, progress=say, meter=advance, **options)
    return finish(found, into)
