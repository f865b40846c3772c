"""The command `payload`: what the arm carries."""

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
    "--parameters", help="Of the robot alone: result folder, estimate.json or TOML [parameters]."
)
@click.option("--without", multiple=True, help="A log without the load; may be repeated.")
@click.option("--mass", type=float, help="Of the load, kg, where it was weighed.")
@click.option("--gain", type=float, help="Std of the drives' gains, %; a part of every std.")
@click.option(
    "--calibrate", is_flag=True, help="Find the drives' gains too, by --mass and --without."
)
@click.option("--model", default="torque", help="torque; or static: rows are still poses.")
@CUTOFF
@reading_options
@into("payload.json")
def payload(robot: str, calibrate: bool, into: Path, **options: Any) -> None:
    """Identify mass, centre of mass and inertia of what ROBOT carries in LOGS.

    The robot alone is known by --parameters, or by logs --without the load, best of the same
    motions: what they have in common cancels. A load of known --mass calibrates the drives: their
    gains are written into [drive] of a robot.toml beside the result, which later runs then use.
    """
    import symgen
    from symgen.identification.payload import with_gains

    with stages({"reading": 0.05, "deriving": 0.1, "band": 0.6, "solving": 0.8}) as told:
        found = symgen.payload(robot, calibrate=calibrate, progress=told, **options)
    gains = {}
    if calibrate:
        gains["robot.toml"] = with_gains(symgen.read_robot(robot), found).encode()
    finish(found, into, more=gains)
