"""symgen predict on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from symgen.cli.options import CUTOFF, INTO, PARAMETERS, ROBOT, finish, reading_options
from symgen.cli.progress import stages

if TYPE_CHECKING:
    from symgen.data.raw import Reading


@click.command()
@ROBOT
@click.argument("log", type=click.Path())
@PARAMETERS
@CUTOFF
@reading_options
@INTO
def predict(
    robot: str, log: str, parameters: str, cutoff: float | None, reading: Reading, into: Path
) -> int:
    """Predict torque and energy of LOG with given parameters of ROBOT, and the error."""
    import symgen
    from symgen.files import check_replaceable

    check_replaceable(into, "prediction.json")
    with stages({"deriving": 0.02}) as told:
        told("deriving and compiling the model")
        prediction = symgen.predict(robot, log, parameters, cutoff=cutoff, reading=reading)
    finish(prediction, into)
    return 0
