"""The command `predict`: torque and energy of a log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import ROBOT, finish, into, options_of, reading_options
from symgen.cli.progress import say_progress


@click.command()
@ROBOT
@click.argument("log", type=click.Path())
@options_of("predict")
@reading_options
@into("prediction.json")
def predict(into: Path, **options: Any) -> None:
    """Predict torque and energy of LOG with known parameters of ROBOT, and report the error."""
    import symgen

    say_progress("deriving and compiling the model")
    finish(symgen.predict(**options), into)
