"""The command `fleet`: what drifted, and which robot stands out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import PATH, finish, into, reading_options, worker_options
from symgen.cli.progress import stages

#: First word of what is said, and the part of the time that has passed then.
_DAYS = {"choosing": 0.02, "days": 0.1, "diagnosing": 0.85}


@click.command()
@click.argument("robot")
@click.argument("logs", nargs=-1, required=True)
@click.option("--by", help="Column that names the robot; by default folders and files do.")
@click.option("--reference", help="What every robot should be: estimate.json or TOML.")
@click.option("--model", default="momentum", help="energy, momentum or torque.")
@click.option("--cutoff", type=float, help="Of the filter of q and qd, Hz; by default chosen.")
@worker_options
@click.option("--work", type=PATH, help="Keeps the days that are finished.")
@reading_options
@into("fleet.json")
def fleet(into: Path, **options: Any) -> int:
    """Identify every robot and day of LOGS; say which drifted since when, and which stands out.

    LOGS are files, patterns, folders or URLs: robot=NAME/day=DAY/FILE, ROBOT/DAY.parquet, or
    ROBOT_DAY.parquet.
    """
    import symgen

    with stages(_DAYS) as told:
        found = symgen.fleet(progress=told, **options)
    return finish(found, into)
