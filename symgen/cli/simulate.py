"""symgen simulate on the command line."""

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
    numbers,
    recording_options,
)
from symgen.cli.progress import meter, say
from symgen.report.terminal import print_simulation


@click.command()
@ROBOT
@PARAMETERS
@click.option("--trajectory", help="CSV with t, q1.. to follow; default a Fourier series.")
@click.option("--torque", help="CSV with t, tau1.. to play instead of a controller.")
@click.option("--hold", is_flag=True, help="Hold each of these torques until the next stamp.")
@click.option(
    "--temperature", help="START,END,SECONDS: temp1.. in the log, deg C, and how fast they change."
)
@recording_options
@DURATION
@click.option("--runs", default=1, help="Logs: LOG_1.csv and so on.")
@SEED
@click.option("--into", type=PATH, required=True, help="log.csv or log.npz.")
def simulate(temperature: str | None, runs: int, into: Path, **options: Any) -> None:
    """Simulate ROBOT with given parameters under a controller, and write the log that it leaves."""
    import symgen
    from symgen.experiment.simulate import log_paths
    from symgen.files import check_new, write_files

    paths = log_paths(into, runs)
    for path in paths:
        check_new(path)
    accepted = "START,END in deg C and SECONDS, such as 25,45,60"
    course = numbers("--temperature", temperature, accepted, (3,))
    with meter("simulating") as advance:
        done = symgen.simulate(
            temperature=course, runs=runs, progress=say, meter=advance, **options
        )
    write_files(done.files(into))
    print_simulation(done)
    click.echo(f"written: {', '.join(map(str, paths))}")
