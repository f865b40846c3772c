"""The command `excite`: identification motions within limits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from symgen.cli.options import ROBOT, numbers, options_of, taken
from symgen.cli.progress import meter, say_progress
from symgen.report.terminal import print_result, say


@click.command()
@ROBOT
@options_of("excite")
def excite(robot: str, into: Path, to: str, wanted: tuple[str, ...], **options: Any) -> int:
    """Find motions within limits from which the parameters of ROBOT can be identified.

    A limit is one number for all joints, or one for each, separated by commas. Limits that you do
    not give come from [limits] of the robot. Link frames and tool keep out of the boxes and above
    the floor that [limits] declares. Each run starts and ends at rest.

    --to ros adds a JointTrajectory as YAML; --to urscript adds a program. Both begin
    with a slow approach. Ctrl-C stops the search and keeps the best result.
    """
    import symgen
    from symgen import Limits, Motion, Search
    from symgen.diagnosis.extend import with_effect
    from symgen.experiment.plan import exported, paths
    from symgen.files import check_new, write_files
    from symgen.report.store import result_page

    if into.suffix != ".csv":
        raise click.UsageError(f"--into {into}: accepted: a path that ends in .csv")
    source = symgen.read_robot(robot)
    for effect in wanted:
        source = with_effect(source, effect)
    files = paths(into, options["runs"])
    page = into.with_suffix(".html")
    for path in (*files, page):
        check_new(path)
    keys = ("position", "velocity", "acceleration", "jerk", "torque", "noise", "start")
    for key in keys:
        such = "ranges, such as 2.5 or -2:1.5,0:3" if key == "position" else "numbers, such as 3"
        accepted = f"{such}; one, or one for each of {source.n}"
        read = _range if key == "position" else float
        found = numbers(f"--{key}", options[key], accepted, (1, source.n), read)
        options[key] = found and found * (source.n // len(found))
    limits, motion, search = (taken(kind, options) for kind in (Limits, Motion, Search))
    with meter("searching") as advance:
        plan = symgen.excite(
            source, limits=limits, motion=motion, search=search,
            progress=say_progress, meter=advance, **options,
        )  # fmt: skip
    found = exported(plan, source, into, to) | {page: result_page(plan).encode()}
    write_files(found.items())
    print_result(plan)
    say(f"written: {', '.join(map(str, found))}")
    return 0 if plan.good else 1


def _range(text: str) -> tuple[float, float]:
    """Return the limits of "LOW:HIGH", or of "HALF" (-HALF to HALF)."""
    low, colon, high = text.partition(":")
    return (float(low), float(high)) if colon else (-float(low), float(low))
