"""The command `compare-sim`: position errors of simulated robots against logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import PATH, finish, into, options_of, reading_options
from symgen.cli.progress import say_progress
from symgen.errors import ParameterError


@click.command("compare-sim")
@click.argument("paths", metavar="FILE.xml|FILE.urdf... LOG...", nargs=-1, required=True, type=PATH)
@options_of("compare-sim")
@reading_options
@into("simulation.json")
def compare_sim(paths: tuple[Path, ...], into: Path, **options: Any) -> int:
    """Simulate robot files along logs in MuJoCo, and report how far they move from the logs.

    Windows begin in a measured state and replay the measured torque for 1 s. Logs of duty have no
    torques: their reference then drives the actuators of the files. Give several files to compare
    them side by side.
    """
    from symgen.experiment.playback import compare_simulations

    files = [path for path in paths if path.suffix.lower() in (".xml", ".urdf")]
    logs = [path for path in paths if path not in files]
    if not files or not logs:
        raise ParameterError(
            "compare-sim: accepted: one or more .xml or .urdf files, then one or more logs"
        )
    return finish(compare_simulations(files, logs, progress=say_progress, **options), into)
