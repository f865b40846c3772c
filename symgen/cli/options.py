"""What commands share: their options, and what they say in the end."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import fields
from functools import reduce, wraps
from pathlib import Path
from typing import Any

import click

from symgen.report.terminal import print_result


def robot_names(_context: Any, _parameter: Any, incomplete: str) -> list[Any]:
    """Complete ROBOT: built-in robots and robot files here, else what the shell knows of files."""
    from click.shell_completion import CompletionItem

    from symgen.robot.builtin import library

    files = sorted(p.name for p in Path().iterdir() if p.suffix in (".toml", ".urdf", ".par"))
    known = [name for name in (*files, *library()) if name.startswith(incomplete)]
    return list(map(CompletionItem, known)) or [CompletionItem(incomplete, type="file")]


def one_of(*words: str) -> Callable[..., list[str]]:
    """Return what completes an option that takes one of these words."""
    return lambda _context, _parameter, incomplete: [w for w in words if w.startswith(incomplete)]


def effect_names(_context: Any, _parameter: Any, incomplete: str) -> list[str]:
    """Complete EFFECT: those of the library."""
    from symgen.robot.effect import definitions

    return [name for name in definitions() if name.startswith(incomplete)]


def listed(text: str | None) -> tuple[str, ...]:
    """Return the parts of a text between commas."""
    return () if text is None else tuple(part.strip() for part in text.split(","))


def numbers(
    option: str,
    text: str | None,
    accepted: str = "numbers, separated by commas",
    counts: Sequence[int] = (),
    read: Callable[[str], Any] = float,
) -> Any:
    """Return the numbers of a text between commas, as a tuple; None for none.

    Args:
        option: for messages.
        text: that was typed.
        accepted: for messages.
        counts: how many there may be; empty for any.
        read: what makes a number of a part.

    Raises:
        UsageError: one is not a number, or there are others than COUNTS.
    """
    if text is None:
        return None
    with suppress(ValueError):
        found = tuple(map(read, listed(text)))
        if not counts or len(found) in counts:
            return found
    raise click.UsageError(f"{option} {text[:100]}: accepted: {accepted}")


Command = Callable[..., Any]
PATH = click.Path(path_type=Path)


def share(_context: Any, _option: Any, percent: float) -> float:
    """Return what is typed in percent as a share."""
    return percent / 100


ROBOT = click.argument("robot", shell_complete=robot_names)
LOGS = click.argument("logs", nargs=-1, required=True, type=click.Path())
PARAMETERS = click.option(
    "--parameters",
    required=True,
    help="Result folder of identify, its estimate.json, or TOML with [parameters].",
)
CUTOFF = click.option(
    "--cutoff", type=float, help="Of the filter of q and qd, Hz; by default it is chosen."
)
WINDOW = click.option("--window", default=0.2, help="Length of the windows, s.")
DURATION = click.option("--duration", default=20.0, help="Of the Fourier series, s.")
SEED = click.option("--seed", default=0, help="Of noise and Fourier series.")
MODELS = ("energy", "momentum", "torque")
METHODS = ("wls", "ols", "huber", "tls", "iv", "ridge", "essential", "consistent", "recursive")


def into(marker: str, **options: Any) -> Command:
    """Return the option --into of a folder of results, new or of that marker: looked at at once."""

    def replaceable(_context: Any, _option: Any, folder: Path) -> Path:
        from symgen.files import check_replaceable

        check_replaceable(folder, marker)
        return folder

    told = {"required": True, "help": "Folder of results.", **options}
    return click.option("--into", type=PATH, callback=replaceable, **told)


_READING = (
    click.option("--columns", help="Names of columns in the file: t=time,q1=..; or a .toml file."),
    click.option("--joints", help="Names of the joints in a bag, in the robot's order: a,b,.."),
    click.option(
        "--topic", default="", show_default=False, help="Topic of the joint states in a bag."
    ),
    click.option("--mask", help="What no equation may touch: rest, saturation, rest,saturation."),
    click.option("--from", "start", type=float, help="Use each log from this t on, s."),
    click.option("--until", type=float, help="Use each log up to this t, s."),
)

_RECORDING = (
    click.option("--controller", "kind", default="computed-torque", help="Or pd."),
    click.option("--bandwidth", default=40.0, help="Of the controller, rad/s."),
    click.option("--scale", default=1.0, help="Its parameters over the robot's."),
    click.option("--feedback", default="true", help="Or measured, at stamps."),
    click.option("--encoder", "encoder_step", default=0.0, help="Step of the encoders, rad or m."),
    click.option("--position-noise", default=0.0, help="Standard deviation of q, rad or m."),
    click.option("--velocity-noise", default=0.0, help="Of qd, rad/s or m/s."),
    click.option("--velocity-gain", default=1.0, help="Of the tachometers."),
    click.option(
        "--no-velocity",
        "velocity",
        is_flag=True,
        callback=lambda _context, _option, out: not out,
        help="Leave qd out of the log.",
    ),
    click.option("--torque-noise", default=0.0, help="Of tau in the log, N m or N."),
    click.option(
        "--torque-noise-percent",
        "torque_noise_relative",
        default=0.0,
        callback=share,
        help="Of tau in the log, of its RMS.",
    ),
    click.option("--delay", default=0.0, help="Of q and qd behind tau in the log, s."),
    click.option(
        "--disturbance", default=0.0, help="Torques that the log does not show, N m or N."
    ),
    click.option(
        "--rate", type=float, help="Of the log, Hz; default from the trajectory, or 1000."
    ),
    click.option("--clip", is_flag=True, help="Keep torques within [limits] instead of refusing."),
)

_WORKERS = (
    click.option(
        "--workers", "processes", type=click.IntRange(min=1), help="Processes that share the work."
    ),
    click.option("--scheduler", help="Address of a Dask scheduler whose workers do it."),
)


def _with(options: Sequence[Command], command: Command) -> Command:
    return reduce(lambda wrapped, option: option(wrapped), reversed(options), command)


def taken(kind: Any, options: dict[str, Any]) -> Any:
    """Make an object of options, and take those off that it holds."""
    return kind(**{f.name: options.pop(f.name) for f in fields(kind) if f.name in options})


def reading_options(command: Command) -> Command:
    """Give a command the options of reading logs, as one argument `reading`."""

    @wraps(command)
    def with_reading(**options: Any) -> Any:
        from symgen.data.columns import IMPORT, columns_from
        from symgen.data.raw import Reading
        from symgen.errors import LogError
        from symgen.robot.imported import FORMATS

        columns, robot = options["columns"], options["robot"]
        options["columns"] = {} if columns is None else columns_from(columns)
        options |= {key: listed(options[key]) for key in ("joints", "mask")}
        reading = taken(Reading, options)
        try:
            return command(reading=reading, **options)
        except LogError as error:  # the file that the advice is about is known here
            text = str(error).replace(IMPORT, f"symgen import {shlex.quote(robot)} ")
            if robot.lower().endswith(tuple(FORMATS)) and text != str(error):
                raise LogError(text) from error
            raise

    return _with(_READING, with_reading)


def recording_options(command: Command) -> Command:
    """Give a command the options of simulated logs, as one argument `recording`."""

    @wraps(command)
    def with_recording(**options: Any) -> Any:
        from symgen import Controller, Instruments, Recording

        options["instruments"] = taken(Instruments, options)
        options["controller"] = taken(Controller, options)
        return command(recording=taken(Recording, options), **options)

    return _with(_RECORDING, with_recording)


def worker_options(command: Command) -> Command:
    """Give a command the options of sharing its work, as one argument `workers`."""

    @wraps(command)
    def with_workers(**options: Any) -> Any:
        from symgen import Workers

        asked = taken(Workers, options)
        return command(workers=None if asked == Workers() else asked, **options)

    return _with(_WORKERS, with_workers)


def finish(result: Any, into: Path, **more: Any) -> int:
    """Write a result, print it, and return the exit code: 1 where its answer is "no"."""
    import symgen

    files = symgen.write(result, into, **more)
    good = print_result(result)
    click.echo(f"written: {', '.join(map(str, files))}")
    return 0 if good else 1


def again(**changed: str) -> str:
    """Return the command that was given with some of its options changed, for the shell.

    Args:
        changed: options without their dashes, and what they are to be.
    """
    words = iter(sys.argv[1:])
    kept = ["symgen"]
    for word in words:
        name, sign, _ = word.partition("=")
        if name.removeprefix("--") not in changed or not name.startswith("--"):
            kept.append(word)
        elif not sign:
            next(words, None)
    return shlex.join([*kept, *(part for key in changed for part in (f"--{key}", changed[key]))])


def diagnosing(robot: str, logs: Sequence[str], validation: Sequence[str], into: str) -> str:
    """Return the command that tells why a model is doubtful, for the shell."""
    held = [part for log in validation for part in ("--validation", log)]
    return shlex.join(["symgen", "diagnose", robot, *logs, *held, "--into", into])
