"""The command `export`: identified values in a copy of the robot file."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from symgen.cli.options import PATH, again, options_of, reading_options
from symgen.cli.progress import say_progress
from symgen.errors import PackageError
from symgen.report.terminal import say

if TYPE_CHECKING:
    from symgen.data.raw import Reading


@click.command()
@click.argument("estimate", type=PATH)
@options_of("export")
@partial(reading_options, start="--start")
def export(
    estimate: Path,
    to: Path,
    source: Path | None,
    robot: str | None,
    logs: tuple[Path, ...],
    least: float,
    samples: int | None,
    seed: int,
    mujoco: str,
    actuator: str | None,
    reading: Reading,
) -> int:
    """Write the identified values of ESTIMATE into the URDF or MJCF of the robot.

    Links, friction, rotor inertia, springs and coupled drives are written, as far as the format
    can hold them. Many sets of link parameters fit an estimate: symgen takes the physically
    possible one that is nearest to the values in the file. Exit code 1: the torque error of the
    written file on a --log is above that of the estimate by more than --least.
    """
    from symgen.identification.export import (
        beyond_limits,
        file_errors,
        read_identified,
        write_copies,
    )

    named = [path for path in (source, None if samples else to) if path is not None]
    kinds = {path.suffix.lower() for path in named}
    if len(kinds) > 1 or not kinds <= {".urdf", ".xml"}:
        listed = " and ".join(map(str, named))
        raise click.UsageError(f"{listed}: accepted: both end in .urdf, or both in .xml")
    if logs and actuator == "dcmotor":
        raise click.UsageError(
            "--log compares torques, and a dcmotor holds the viscous friction: accepted: "
            "--actuator motor with --log"
        )
    copied = _checked(source, to, bool(samples))
    found, known = read_identified(estimate, robot)
    # Logs are read first, so that an unreadable one leaves no file.
    limits = [note for log in logs for note in beyond_limits(log, known, copied, reading)]
    say_progress("deriving the model, and finding link parameters")
    higher = mujoco == "3.7"
    paths, first = write_copies(
        to,
        copied,
        found,
        known,
        samples=samples,
        seed=seed,
        higher=higher,
        actuator=actuator,
    )
    for note in (*first.notes, *limits):
        say(f"note: {note}")
    left_out = ", ".join(name for name, _, _ in first.left_out)
    if left_out:
        values = (f"{name} = {value:.3g} {unit}" for name, value, unit in first.left_out)
        say(f"note: the format cannot hold {', '.join(values)}")
    code = 0
    for log in logs:
        say_progress(f"comparing with {log}")
        errors = file_errors(paths, log, found, known or copied, reading)
        say(errors.in_words)
        if not samples and errors.exceed(least / 100):
            why = "symgen diagnose searches for what the model lacks"
            if left_out:
                why = f"the format cannot hold {left_out}"
            say(f"this is more than --least {least:g} % above the estimate: {why}")
            code = 1
    say(f"written: {to}")
    return code


def _checked(source: Path | None, to: Path, folder: bool) -> Path:
    """Return the file to copy.

    Args:
        source: path of --from.
        to: path of --to.
        folder: whether --to is a folder, which is checked when it is written.

    Raises:
        PackageError: there is no --from, or --to is a file that symgen may not replace. The message
            has the command that copies that file to a new one.
    """
    from symgen.files import check_text_replaceable

    try:
        if not folder:
            check_text_replaceable(to)
        if source is None:
            raise PackageError("--from is missing; accepted: the URDF or MJCF to copy")
    except PackageError as error:
        new = to
        while new.exists():
            new = new.with_stem(f"{new.stem}_identified")
        line = again(source=to if to.is_file() else source or "FILE", to=new)
        raise PackageError(f"{error}; try: {line}") from error
    return source
