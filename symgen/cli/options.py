"""Options that several commands share, and the output of results."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import fields
from functools import reduce, wraps
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from symgen.report.terminal import print_result, say


def robot_names(_context: Any, _parameter: Any, incomplete: str) -> list[Any]:
    """Complete ROBOT with built-in robots and robot files in this folder, or else any file."""
    from click.shell_completion import CompletionItem

    from symgen.robot.builtin import library
    from symgen.robot.imported import FORMATS

    files = sorted(p.name for p in Path().iterdir() if p.suffix in (".toml", *FORMATS))
    known = [name for name in (*files, *library()) if name.startswith(incomplete)]
    return list(map(CompletionItem, known)) or [CompletionItem(incomplete, type="file")]


def _opposite(_context: Any, _option: Any, given: bool) -> bool:
    """Convert the flag of a --no option to the value of the option itself."""
    return not given


def _joined(_context: Any, _option: Any, values: tuple[str, ...]) -> str:
    """Join the values of an option that may be repeated."""
    return ",".join(values)


def effect_names(_context: Any, _parameter: Any, incomplete: str) -> list[str]:
    """Complete EFFECT with the effects of the library."""
    from symgen.robot.effect import definitions

    return [name for name in definitions() if name.startswith(incomplete)]


def split_list(text: str | None) -> tuple[str, ...]:
    """Split a text at commas."""
    return () if text is None else tuple(part.strip() for part in text.split(","))


def numbers(
    option: str,
    text: str | None,
    accepted: str = "numbers, separated by commas",
    counts: Sequence[int] = (),
    read: Callable[[str], Any] = float,
) -> Any:
    """Return comma-separated numbers as a tuple; None if there is no text.

    Args:
        option: name of the option, for the error.
        text: the typed text.
        accepted: accepted input, for the error.
        counts: accepted numbers of values; empty for any.
        read: converts one part.

    Raises:
        UsageError: a part is not a number, or their number is not in `counts`.
    """
    if text is None:
        return None
    with suppress(ValueError):
        found = tuple(map(read, split_list(text)))
        if not counts or len(found) in counts:
            return found
    raise click.UsageError(f"{option} {text[:100]}: accepted: {accepted}")


Command = Callable[..., Any]
PATH = click.Path(path_type=Path)
PERCENT = click.FloatRange(0, 100, min_open=True)


def share(_context: Any, _option: Any, percent: float) -> float:
    """Convert percent to a share."""
    return percent / 100


ROBOT = click.argument("robot", shell_complete=robot_names)
LOGS = click.argument("logs", nargs=-1, required=True, type=click.Path())
PARAMETERS = click.option(
    "--parameters",
    required=True,
    help="Result folder of identify, its estimate.json, or a TOML file with [parameters].",
)
CUTOFF = click.option(
    "--cutoff", type=float, help="Cutoff of the filter for q and qd, Hz; chosen by default."
)
WINDOW = click.option("--window", default=0.2, help="Length of the sliding windows, s.")
DURATION = click.option("--duration", default=20.0, help="Duration of the Fourier series, s.")
SEED = click.option("--seed", default=0, help="Seed of noise and Fourier series.")
EXACT = click.option(
    "--exact",
    is_flag=True,
    help="Base parameters of the exact geometry, not of the nominal one.",
)
#: Words of options. They are typed here because their tables take half a second to import; a test
#: compares both.
MODELS = ("energy", "momentum", "torque")
DTYPES = ("double", "float")
FORMATS = ("csv", "ros", "urscript")
METHODS = ("auto", "wls", "ols", "huber", "tls", "iv", "consistent", "recursive")


def into(marker: str, **options: Any) -> Command:
    """Return the option --into of a result folder; the folder must be new or contain a file
    `marker`.
    """

    def replaceable(_context: Any, _option: Any, folder: Path) -> Path:
        from symgen.files import check_replaceable

        check_replaceable(folder, marker)
        return folder

    told = {"required": True, "help": "Result folder to write.", **options}
    return click.option("--into", type=PATH, callback=replaceable, **told)


_READING = (
    click.option(
        "--columns",
        multiple=True,
        callback=_joined,
        help="Column names of the file: t=time,q1=..; default of this and the options below: [log] "
        "of the robot.",
    ),
    click.option("--joints", help="Joint names in the file, in the order of the robot: a,b,.."),
    click.option(
        "--topic", default="", show_default=False, help="Topic of the joint states in a bag."
    ),
    click.option(
        "--mask",
        help="Samples to leave out of the equations: rest, saturation, or rest,saturation.",
    ),
    click.option(
        "--unit",
        help="Unit of angles, deg or rad; or of columns: q=deg,qd=rad/s,tau2=mNm; u=% or u=V of "
        "servos; tau=% of [drive] rated; steps: u=0.1%, q=ticks4096, u=sign10:0.1%.",
    ),
    click.option(
        "--time-unit", default="", show_default=False, help="Unit of t in the file: s, ms, us, ns."
    ),
    click.option(
        "--separator",
        default="",
        show_default=False,
        help="Character between the columns of a CSV: ';', ',' or tab; default: by its header.",
    ),
    click.option(
        "--decimal",
        default="",
        show_default=False,
        help="Decimal mark of a CSV: '.' or ','; default: by its first numbers.",
    ),
    click.option(
        "--no-header",
        "header",
        is_flag=True,
        callback=_opposite,
        help="The CSV has no header; --columns gives the numbers of its columns: t=1,q1=2,..",
    ),
)

_RECORDING = (
    click.option("--controller", "kind", default="computed-torque", help="computed-torque or pd."),
    click.option("--bandwidth", default=40.0, help="Bandwidth of the controller, rad/s."),
    click.option(
        "--scale", default=1.0, help="Parameters of the controller divided by those of the robot."
    ),
    click.option(
        "--feedback",
        default="true",
        help="Motion that the controller sees: true, or measured (at the time stamps).",
    ),
    click.option(
        "--encoder", "encoder_step", default=0.0, help="Resolution of the encoders, rad or m."
    ),
    click.option(
        "--position-noise", default=0.0, help="Standard deviation of the noise of q, rad or m."
    ),
    click.option(
        "--velocity-noise", default=0.0, help="Standard deviation of the noise of qd, rad/s or m/s."
    ),
    click.option("--velocity-gain", default=1.0, help="Gain of the speed sensors."),
    click.option(
        "--no-velocity",
        "velocity",
        is_flag=True,
        callback=_opposite,
        help="Write no qd.",
    ),
    click.option(
        "--torque-noise", default=0.0, help="Standard deviation of the noise of tau, N m or N."
    ),
    click.option(
        "--torque-noise-percent",
        "torque_noise_relative",
        default=0.0,
        callback=share,
        help="Standard deviation of the noise of tau, % of its RMS.",
    ),
    click.option("--delay", default=0.0, help="Delay of q and qd after tau, s."),
    click.option(
        "--disturbance", default=0.0, help="Size of torques that the log does not show, N m or N."
    ),
    click.option(
        "--rate", type=float, help="Sampling rate, Hz; default from the trajectory, or 1000."
    ),
)


def _with(options: Sequence[Command], command: Command) -> Command:
    return reduce(lambda wrapped, option: option(wrapped), reversed(options), command)


def taken(kind: Any, options: dict[str, Any]) -> Any:
    """Build an object from options, and remove them from the dictionary."""
    return kind(**{f.name: options.pop(f.name) for f in fields(kind) if f.name in options})


def reading_options(command: Command, start: str = "--from") -> Command:
    """Add the options for reading logs to a command, as one argument `reading`.

    Args:
        command: the command.
        start: name of the option for the first time to use.
    """

    @wraps(command)
    def with_reading(**options: Any) -> Any:
        from symgen.data.columns import IMPORT
        from symgen.data.raw import Reading, separator_of, units_from
        from symgen.errors import IdentificationError, LogError
        from symgen.robot.imported import FORMATS

        options |= {key: split_list(options[key]) for key in ("joints", "mask")}
        options["unit"] = units_from(options["unit"] or "")
        options["separator"] = separator_of(options["separator"])
        reading = taken(Reading, options)
        try:
            return command(reading=reading, **options)
        except (
            IdentificationError,
            LogError,
        ) as error:  # only here, the robot file for the advice is known
            given = (options["robot"], *options.get("paths", ()))  # the robot, or the first file
            robot = next((str(path) for path in given if path is not None), "FILE")
            text = str(error)
            if robot.lower().endswith(tuple(FORMATS)):
                text = text.replace(IMPORT, f"symgen import {shlex.quote(robot)} ")
            if text != str(error):
                then = "" if options["robot"] else ", then --robot robot.toml"
                raise type(error)(text + then) from error
            raise

    first = click.option(start, "start", type=float, help="First time of each log to use, s.")
    last = click.option("--until", type=float, help="Last time of each log to use, s.")
    return _with((*_READING, first, last), with_reading)


def recording_options(command: Command) -> Command:
    """Add the options of simulated logs to a command, as one argument `recording`."""

    @wraps(command)
    def with_recording(**options: Any) -> Any:
        from symgen import Controller, Instruments, Recording

        options["instruments"] = taken(Instruments, options)
        options["controller"] = taken(Controller, options)
        return command(recording=taken(Recording, options), **options)

    return _with(_RECORDING, with_recording)


def finish(result: Any, into: Path, **more: Any) -> int:
    """Write a result, print it, and return the exit code: 1 if its answer is "no"."""
    import symgen

    files = symgen.write(result, into, **more)
    good = print_result(result)
    say(f"written: {', '.join(map(str, files))}")
    return 0 if good else 1


def again(command: str = "", **changed: Any) -> str:
    """Return this command, or another one with the same options, as a line for the shell.

    Args:
        command: name of the other command. It gets the options of this command that it also has.
        changed: new values of arguments and options, by parameter name.
    """
    context = click.get_current_context()
    group = context.parent.command if context.parent else None
    other = group.commands[command] if command and isinstance(group, click.Group) else None
    taken = {p.name for p in (other or context.command).params}
    words, options = ["symgen", command or str(context.command.name)], []
    for p in context.command.params:
        name, value = str(p.name), context.params.get(str(p.name))
        given = context.get_parameter_source(name) is not ParameterSource.DEFAULT
        if name not in taken or not (given or name in changed):
            continue
        values = changed.pop(name, value)
        listed = values if isinstance(values, tuple) else (values,)
        if isinstance(p, click.Argument):
            words += map(str, listed)
        elif isinstance(p, click.Option) and p.is_flag:
            options += p.opts[:1]
        else:
            options += [part for v in listed for part in (p.opts[0], str(v))]
    for p in other.params if other else ():
        if str(p.name) in changed:
            options += [p.opts[0], changed.pop(str(p.name))]
    return shlex.join([*words, *options])
