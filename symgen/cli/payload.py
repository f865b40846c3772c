"""The command `payload`: mass, centre of mass and inertia of a load."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import CUTOFF, LOGS, ROBOT, finish, into, reading_options
from symgen.cli.progress import stages


@click.command()
@ROBOT
@LOGS
@click.option(
    "--parameters",
    help="The robot without load: a result folder, estimate.json or TOML with [parameters].",
)
@click.option("--without", multiple=True, help="Log without the load; repeatable.")
@click.option(
    "--frame",
    default="",
    show_default=False,
    help="Frame of the result: a link of the URDF, such as tool0; default that of the joint.",
)
@click.option("--mass", type=float, help="Mass of the load, kg, if you weighed it.")
@click.option(
    "--gain",
    type=float,
    help="Uncertainty of the drive gains, % (std); included in every standard deviation.",
)
@click.option(
    "--sensor",
    is_flag=True,
    help="Load from the wrench of the sensor in [sensor] (columns wfx..wnz), in its frame.",
)
@CUTOFF
@reading_options
@into("payload.json")
def payload(robot: str, into: Path, **options: Any) -> None:
    """Identify mass, centre of mass and inertia of the load that ROBOT carries in LOGS.

    symgen needs the robot without load: --parameters, or logs --without the load. Logs of the same
    motions are best, because their common errors cancel. With --sensor, the wrench of a
    force/torque sensor at the wrist is enough.
    """
    import symgen

    with stages({"reading": 0.05, "deriving": 0.1, "band": 0.6, "solving": 0.8}) as told:
        found = symgen.payload(robot, progress=told, **options)
    finish(found, into)
