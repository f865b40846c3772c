"""The command `study`: bias and precision of an estimate, by simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import (
    DURATION,
    INTO,
    PARAMETERS,
    ROBOT,
    SEED,
    WINDOW,
    finish,
    one_of,
    recording_options,
    worker_options,
    workers_of,
)
from symgen.cli.progress import meter, say

_MODELS = ("energy", "momentum", "torque")
_METHODS = ("ols", "wls", "iv", "huber", "tls", "ridge", "essential", "consistent", "recursive")


@click.command()
@ROBOT
@PARAMETERS
@click.option("--trajectory", multiple=True, help="CSV of a motion, one log each; repeatable.")
@click.option("--held-out", help="CSV of the motion along which torque is predicted.")
@recording_options
@click.option(
    "--model", multiple=True, shell_complete=one_of(*_MODELS), help="Repeatable; default all."
)
@click.option(
    "--method", multiple=True, shell_complete=one_of(*_METHODS),
    help="Repeatable; default ols, wls and iv.",
)  # fmt: skip
@WINDOW
@click.option("--cutoff", type=float, help="Of the filter, Hz; by default that of the first run.")
@DURATION
@click.option("--runs", default=100, show_default=True, help="Simulated and identified.")
@click.option("--target", default=2.0, show_default=True, help="To know a parameter to, %.")
@SEED
@worker_options
@INTO
def study(
    robot: str,
    parameters: str,
    trajectory: tuple[str, ...],
    model: tuple[str, ...],
    method: tuple[str, ...],
    target: float,
    workers: int | None,
    scheduler: str | None,
    into: Path,
    **options: Any,
) -> int:
    """Tell how well motions and sensors determine ROBOT, and how long must be recorded.

    Runs are simulated with --parameters and the noise of the sensors, and identified; what is found
    is compared with what they were made of.
    """
    import symgen
    from symgen.experiment.study_result import MARKER
    from symgen.files import check_replaceable

    check_replaceable(into, MARKER)
    with meter("studying") as advance:
        found = symgen.study(
            robot,
            parameters,
            trajectories=trajectory,
            models=model,
            methods=method or _METHODS[:3],
            target=target / 100,
            workers=workers_of(workers, scheduler),
            progress=say,
            meter=advance,
            **options,
        )
    return finish(found, into)
