"""The command `diagnose`: effects that the model lacks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from symgen.cli.options import (
    LOGS,
    ROBOT,
    again,
    into,
    options_of,
    reading_options,
    split_list,
)
from symgen.cli.progress import stages
from symgen.report.terminal import print_result, say

#: First word of a progress message, and the share of the time that has passed before it.
_DIAGNOSING = {"reading": 0.02, "deriving": 0.05, "checking": 0.12, "trying": 0.2,
               "looking": 0.6, "writing": 0.85}  # fmt: skip


@click.command()
@ROBOT
@LOGS
@options_of("diagnose")
@reading_options
@into("diagnosis.json")
def diagnose(effects: str | None, into: Path, least: float, misfit: float, **options: Any) -> int:
    """Find the effects in LOGS that the model of ROBOT lacks.

    symgen names the effects, adds them to the model, and shows the torque error before and after.
    Exit code 0 if `identify` trusts the extended robot on these logs, else 1.
    """
    import symgen

    tried = None if effects is None else split_list(effects)
    with stages(_DIAGNOSING) as told:
        diagnosis = symgen.diagnose(
            effects=tried, least=least / 100, misfit=misfit / 100, progress=told, **options
        )
        if diagnosis.is_better:
            command = again("identify", robot=str(into / "robot.toml"), into=f"{into}-better")
        elif any(effect.indistinguishable_from for effect in diagnosis.effects):
            motion = again("excite", into=f"{into}-motion.csv")
            command = f"{motion}  # record this motion, then diagnose with both logs"
        else:
            command = ""
        diagnosis = replace(diagnosis, command=command)
        told("writing the page and the extended model")
        symgen.write(diagnosis, into)
    print_result(diagnosis)
    names = "diagnosis.json, report.html, robot.toml, parameters.toml, generated/"
    if command:
        say(f"next: {command}")
    say(f"written: {into} ({names})")
    return 0 if diagnosis.good else 1
