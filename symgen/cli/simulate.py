"""The command `simulate`: a log of a simulated robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import (
    ROBOT,
    options_of,
    recording_options,
)
from symgen.cli.progress import meter, say_progress
from symgen.report.terminal import print_simulation, say


@click.command()
@ROBOT
@options_of("simulate")
@recording_options
@options_of("simulate-runs")
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
