"""The command `study`: bias and precision of estimates, by simulation."""

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
    recording_options,
)
from symgen.cli.progress import meter, say_progress


@click.command()
@ROBOT
@PARAMETERS
@click.option(
    "--trajectory",
    "trajectories",
    multiple=True,
    help="CSV of a motion; repeatable, one log for each.",
)
@click.option("--held-out", help="CSV of the motion on which torque is predicted.")
@recording_options
@click.option(
    "--model",
    "models",
    multiple=True,
    type=click.Choice(MODELS),
    help="Model to study; repeatable, default all.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    type=click.Choice(METHODS),
    help="Method to study; repeatable, default ols, wls and iv.",
)
@WINDOW
@click.option(
    "--cutoff",
    type=float,
    help="Cutoff of the filter for q and qd, Hz; default from the first run.",
)
@DURATION
@click.option("--runs", default=100, help="Number of simulated identifications.")
@SEED
@into("study.json")
def study(methods: tuple[str, ...], into: Path, **options: Any) -> int:
    """Find out how well motions and sensors determine ROBOT.

    symgen simulates runs with --parameters and sensor noise, identifies them, and compares the
    estimates with the true parameters.
    """
    import symgen

    usual = methods or ("ols", "wls", "iv")
    with meter("studying") as advance:
        found = symgen.study(methods=usual, progress=say_progress, meter=advance, **options)
    return finish(found, into)
