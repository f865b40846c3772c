"""The command `payload`: mass, centre of mass and inertia of a load."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import LOGS, ROBOT, finish, into, options_of, reading_options
from symgen.cli.progress import stages


@click.command()
@ROBOT
@LOGS
@options_of("payload")
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
