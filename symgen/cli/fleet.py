"""The command `fleet`: drift and outliers among many robots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import PATH, finish, into, reading_options, worker_options
from symgen.cli.progress import stages

#: First word of a progress message, and the share of the time that has passed by then.
_DAYS = {"choosing": 0.02, "days": 0.1, "diagnosing": 0.85}


@click.command()
@click.argument("robot")
@click.argument("logs", nargs=-1, required=True)
@click.option("--by", help="Column with the name of the robot; default from folder and file names.")
@click.option("--reference", help="Parameters that every robot should have: estimate.json or TOML.")
@click.option("--model", default="momentum", help="energy, momentum or torque.")
@click.option(
    "--cutoff", type=float, help="Cutoff of the filter for q and qd, Hz; chosen by default."
)
@worker_options
@click.option(
    "--work", type=PATH, help="Folder that keeps finished days, to continue an interrupted run."
)
@reading_options
@into("fleet.json")
def fleet(into: Path, **options: Any) -> int:
    """Identify every robot and day in LOGS, and report drift and outliers.

    LOGS are files, patterns, folders or URLs, named robot=NAME/day=DAY/FILE, ROBOT/DAY.parquet or
    ROBOT_DAY.parquet.
    """
    import symgen

    with stages(_DAYS) as told:
        found = symgen.fleet(progress=told, **options)
    return finish(found, into)
