"""The command `identify`: parameters from logs."""

from __future__ import annotations

import math
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from symgen.cli.options import (
    LOGS,
    ROBOT,
    again,
    into,
    numbers,
    options_of,
    reading_options,
    taken,
)
from symgen.cli.progress import stages
from symgen.report.terminal import print_result, say

#: First word of a progress message, and the share of the time that has passed before it.
_IDENTIFYING = {"reading": 0.03, "deriving": 0.1, "choosing": 0.25, "fitting": 0.5,
                "solving": 0.7, "judging": 0.75, "writing": 0.85}  # fmt: skip


@click.command()
@ROBOT
@LOGS
@options_of("identify")
@reading_options
@into("estimate.json")
def identify(
    robot: str,
    logs: tuple[str, ...],
    validation: tuple[str, ...],
    model: str,
    accept: float,
    least: float,
    exact: bool,
    workers: int | None,
    scheduler: str | None,
    into: Path,
    **options: Any,
) -> int:
    """Identify the parameters of ROBOT from LOGS (CSV, Parquet, NPZ, MCAP or ROS 2 bags).

    LOGS may also be a pattern in quotes ('logs/*.parquet'), a folder or a URL. Files of more than
    2^18 samples together need not fit into memory: they are read in segments, by as many threads
    as there are cores, at most 4. Exit code 1: the verdict is doubtful.
    """
    import symgen
    from symgen.identification.export import identified_file
    from symgen.identification.judgement import CHANGED
    from symgen.identification.settle import EFFECT_MISSING
    from symgen.parallel import executor_of

    source = symgen.read_robot(robot)
    source = replace(source, exact=exact or source.exact)
    options["com"] = numbers("--com", options["com"], "X,Y,Z in m", (3,))
    fit = taken(symgen.FitOptions, options)
    with stages(_IDENTIFYING) as told, executor_of(workers, scheduler) as executor:
        estimate = symgen.identify(
            robot,
            logs,
            validation=validation,
            model=model,
            accept=accept / 100,
            least=least / 100,
            fit=fit,
            exact=exact,
            executor=executor,
            progress=told,
            **options,
        )
        told("writing the report")
        said, urdf = "", {}
        reason = estimate.physical.reason
        if robot.endswith(".urdf") and reason is not None and reason.kind == EFFECT_MISSING:
            said = f"no URDF is written: {reason.text}; symgen export writes the nearest one"
        elif robot.endswith(".urdf"):
            try:
                file = identified_file(robot, estimate, robot=source, folder=into)
                said = "; ".join(file.notes)
                urdf[f"{estimate.robot}.urdf"] = file.text.encode()
            except symgen.ParameterError as error:
                said = f"no URDF is written: {error}"
        written = symgen.write(estimate, into, robot=source, more=urdf)
    trusted = print_result(estimate)
    simulated = estimate.uses is not None and estimate.uses.simulation.ok
    sound = simulated or source.floating  # which is not simulated
    residual = estimate.torque_validation
    flies = residual is not None and math.isnan(residual.base_force or 0.0)
    searched = source.n > 0 and not flies
    unclear = not (trusted and sound and estimate.unexplained is None)
    changed = any(reason.kind == CHANGED for reason in estimate.suspected)
    if model != "auto" and not trusted:
        say(f"try: {again(model='auto', into=f'{into}-auto')}")
    elif changed and not source.floating:  # whose parameters diagnose does not fix
        since = {"logs": validation, "validation": (), "parameters": str(into)}
        say(f"try: {again('diagnose', into=f'{into}-why', **since)}")
    elif unclear and searched:
        say(f"try: {again('diagnose', into=f'{into}-why')}")
    elif trusted:
        exactly = ["--exact"] if exact else []
        line = shlex.join(["symgen", "generate", robot, *exactly, "--parameters", str(into)])
        say(f"next: {line}")
    if said:
        say(f"note: {said}")
    say(f"written: {', '.join(map(str, written))}")
    return 0 if trusted else 1
