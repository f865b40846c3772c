"""The command `identify`: parameters from logs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from symgen.cli.options import (
    CUTOFF,
    LOGS,
    METHODS,
    MODELS,
    PATH,
    ROBOT,
    WINDOW,
    again,
    into,
    numbers,
    one_of,
    reading_options,
    worker_options,
)
from symgen.cli.progress import stages
from symgen.report.terminal import print_result

if TYPE_CHECKING:
    from symgen import Workers

#: First word of a progress message, and the share of the time that has passed by then.
_IDENTIFYING = {"reading": 0.03, "deriving": 0.1, "choosing": 0.25, "fitting": 0.5,
                "solving": 0.7, "judging": 0.75, "writing": 0.85}  # fmt: skip


@click.command()
@ROBOT
@LOGS
@click.option(
    "--validation",
    multiple=True,
    help="Held-out log that tests the model; repeatable. Default: the last fifth of each log.",
)
@click.option(
    "--model",
    default="auto",
    help="auto, energy, momentum or torque; or static: each row is a pose at rest.",
    shell_complete=one_of("auto", *MODELS, "static"),
)
@click.option(
    "--method",
    default="wls",
    help="wls, ols, huber, tls, iv, ridge, essential, consistent or recursive.",
    shell_complete=one_of(*METHODS),
)
@WINDOW
@CUTOFF
@click.option("--prior", help="Prior values for wls and consistent: estimate.json, TOML or .urdf.")
@click.option(
    "--forgetting",
    default=1.0,
    help="Forgetting factor for each new sample, for method recursive.",
)
@click.option(
    "--commanded",
    multiple=True,
    help="Commanded motion of a log, for method iv; once for each log.",
)
@click.option("--weights", help="Weight of the squared residuals of each log: 1,0.5,..")
@worker_options
@click.option(
    "--work", type=PATH, help="Folder that keeps an unfinished run; default beside --into."
)
@reading_options
@into("estimate.json")
def identify(
    robot: str,
    logs: tuple[str, ...],
    validation: tuple[str, ...],
    model: str,
    method: str,
    prior: str | None,
    forgetting: float,
    commanded: tuple[str, ...],
    weights: str | None,
    workers: Workers | None,
    into: Path,
    **options: Any,
) -> int:
    """Identify the parameters of ROBOT from LOGS (CSV, Parquet, NPZ, MCAP or ROS 2 bags).

    symgen reads LOGS in chunks, so they need not fit into memory, if LOGS is a pattern in quotes
    ('logs/*.parquet'), a folder or a URL, or with --workers or --scheduler. To continue an
    interrupted run, give the same command again. Exit code 1: the verdict is doubtful.
    """
    import symgen
    from symgen.distributed import WorkFolder
    from symgen.identification.export import identified_file, require_precise
    from symgen.identification.out_of_core import is_long
    from symgen.identification.solving import FOLDED

    source = symgen.read_robot(robot)
    kept = None
    inputs = prior or weights or commanded
    plain = method in FOLDED and not (inputs or source.loaded)
    if workers or is_long([*logs, *validation], plain and model != "static"):
        workers = workers or symgen.Workers()
        if workers.work is None:
            # Beside the results: the same command continues from there.
            kept = into.absolute().with_name(f".{into.name}-work")
            workers = replace(workers, work=kept)
    with stages(_IDENTIFYING) as told:
        estimate = symgen.identify(
            robot,
            logs,
            validation=validation,
            model=model,
            method=method,
            fit=symgen.Fit(prior, numbers("--weights", weights), commanded, forgetting),
            workers=workers,
            progress=told,
            **options,
        )
        told("writing the report")
        said, urdf = "", {}
        if robot.endswith(".urdf"):
            try:
                file = identified_file(robot, estimate, folder=into)
                if workers is None and model != "static":
                    require_precise(file, source, validation or logs, estimate, options["reading"])
                said = "; ".join(file.notes)
                urdf[f"{estimate.robot}.urdf"] = file.text.encode()
            except symgen.ParameterError as error:
                said = f"no URDF is written: {error}"
        files = symgen.write(estimate, into, robot=source, more=urdf)
    if kept is not None:
        WorkFolder(kept).remove()
    trusted = print_result(estimate)
    sound = all(use.ok for use in estimate.uses if use.name == "simulation")
    if model != "auto" and not trusted:
        click.echo(f"try: {again(model='auto', into=f'{into}-auto')}")
    elif model != "static" and not (trusted and sound and estimate.unexplained is None):
        click.echo(f"try: {again('diagnose', into=f'{into}-why')}")
    if trusted and estimate.physical.feasible is False and method == "wls":
        click.echo(f"try: {again(method='consistent', into=f'{into}-consistent')}")
    if said:
        click.echo(f"note: {said}")
    click.echo(f"written: {', '.join(map(str, files))}")
    return 0 if trusted else 1
