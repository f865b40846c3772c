"""The command `study`: bias and precision of estimates, by simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import (
    ROBOT,
    finish,
    into,
    options_of,
    recording_options,
)
from symgen.cli.progress import meter, say_progress


@click.command()
@ROBOT
@options_of("study")
@recording_options
@options_of("study-runs")
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
