"""symgen predict on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from symgen.cli.progress import stages
from symgen.cli.reading import reading_options, robot_names
from symgen.report.terminal import print_result

if TYPE_CHECKING:
    from symgen.data.raw import Reading


@click.command()
@click.argument("robot", shell_complete=robot_names)
@click.argument("log", type=click.Path())
@click.option(
    "--parameters",
    required=True,
    help="Result folder of identify, its estimate.json, or TOML with [parameters].",
)
@click.option(
    "--cutoff", type=float, help="Of the filter of q and qd, Hz; by default it is chosen."
)
@reading_options
@click.option("--into", type=click.Path(path_type=Path), required=True, help="Folder of results.")
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
    files = symgen.write(prediction, into)
    print_result(prediction)
    click.echo(f"written: {', '.join(map(str, files))}")
    return 0
