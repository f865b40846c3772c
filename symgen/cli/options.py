"""Options that several commands share, and the output of results."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import fields
from functools import cache, wraps
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from symgen.names import LICENSE, MAINTAINER
from symgen.policy import ACCEPT, LEAST
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


def share(_context: Any, _option: Any, percent: float) -> float:
    """Convert percent to a share."""
    return percent / 100


ROBOT = click.argument("robot", shell_complete=robot_names)
LOGS = click.argument("logs", nargs=-1, required=True, type=click.Path())


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


#: Words of options.toml for values that TOML does not have.
_WORDS = {
    "path": PATH,
    "folder": click.Path(path_type=Path, exists=True, file_okay=False),
    "number": float,
    "integer": int,
    "percent": click.FloatRange(0, 100, min_open=True),
    "joined": _joined,
    "opposite": _opposite,
    "share": share,
    "ACCEPT": 100 * ACCEPT,
    "LEAST": 100 * LEAST,
    "LICENSE": LICENSE,
    "MAINTAINER": MAINTAINER,
}
#: Kinds of types in options.toml, made of a list.
_TYPES: dict[str, Callable[[list[Any]], Any]] = {
    "choice": click.Choice,
    "range": lambda ends: click.IntRange(*ends),
}


@cache
def _groups() -> dict[str, Any]:
    """Return the groups of options.toml."""
    return tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))


def options_of(group: str, start: str = "--from") -> Callable[[Command], Command]:
    """Return a decorator that adds a group of options.toml to a command.

    Args:
        group: name of the group.
        start: name that replaces --from.
    """

    def added(command: Command) -> Command:
        for names, table in reversed(_groups()[group].items()):
            words = names.replace("--from", start).split()
            command = click.option(*words, **_arguments(names, table))(command)
        return command

    return added


def _arguments(names: str, table: Any) -> dict[str, Any]:
    """Return the arguments of click.option for an option of options.toml."""
    out: dict[str, Any] = {}
    for key, value in (_groups()["shared"][names] if table == "shared" else table).items():
        if key in _TYPES:
            out["type"] = _TYPES[key](value)
        else:
            out[key] = _WORDS.get(value, value)
    return out


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

    return options_of("reading", start)(with_reading)


def recording_options(command: Command) -> Command:
    """Add the options of simulated logs to a command, as one argument `recording`."""

    @wraps(command)
    def with_recording(**options: Any) -> Any:
        from symgen import Controller, Instruments, Recording

        options["instruments"] = taken(Instruments, options)
        options["controller"] = taken(Controller, options)
        return command(recording=taken(Recording, options), **options)

    return options_of("recording")(with_recording)


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
