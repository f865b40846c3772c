"""The command `simulate`: a log of a simulated robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import (
    DURATION,
    PARAMETERS,
    PATH,
    ROBOT,
    SEED,
    recording_options,
)
from symgen.cli.progress import meter, say_progress
from symgen.report.terminal import print_simulation, say


@click.command()
@ROBOT
@PARAMETERS
@click.option(
    "--trajectory", help="CSV with t, q1.. that the controller follows; default a Fourier series."
)
@click.option("--torque", help="CSV with t, tau1.. that replaces the controller.")
@click.option(
    "--hold", is_flag=True, help="Hold each torque of --torque until the next time stamp."
)
@click.option(
    "--width",
    default=1e-5,
    help="Speed over which Coulomb friction changes its sign, rad/s or m/s.",
)
@recording_options
@DURATION
@click.option("--runs", default=1, help="Number of logs: LOG_1.csv and so on.")
@SEED
@click.option("--into", type=PATH, required=True, help="Log to write, .csv or .npz.")
def simulate(runs: int, into: Path, **options: Any) -> None:
    """Simulate ROBOT under a controller, and write the log that its instruments record."""
    import symgen
    from symgen.experiment.simulate import log_paths
    from symgen.files import check_new, write_files

    paths = log_paths(into, runs)
    for path in paths:
        check_new(path)
    with meter("simulating") as advance:
        done = symgen.simulate(runs=runs, progress=say_progress, meter=advance, **options)
    write_files(done.files(into))
    print_simulation(done, symgen.read_robot(options["robot"]))
    say(f"written: {', '.join(map(str, paths))}")
