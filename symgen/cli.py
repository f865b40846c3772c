"""The command line: parse, call one public function, print.

Results go to stdout and files, progress and messages to stderr. Exit codes: 0 done, 1 done and the
answer is "no", 2 could not.
"""

from __future__ import annotations

import io
import os
import sys
import traceback
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from symgen.cli_excite import excite
from symgen.cli_export import export
from symgen.cli_fleet import fleet
from symgen.cli_generate import generate
from symgen.cli_identify import identify
from symgen.cli_payload import payload
from symgen.cli_reading import effect_names, listed, reading_options, robot_names
from symgen.cli_report import doctor, report
from symgen.cli_simulate import simulate
from symgen.cli_study import study
from symgen.errors import SymgenError, SymgenWarning
from symgen.terminal import (
    print_diagnosis,
    print_prediction,
    print_robot,
    print_text,
    table,
)
from symgen.terminal_progress import meter, say, stages

#: What a shell sets to ask for completion.
COMPLETE = "_SYMGEN_COMPLETE"
#: First word of what a command says, and the part of its time that has passed then.
_DIAGNOSING = {"reading": 0.02, "deriving": 0.05, "checking": 0.12, "trying": 0.2,
               "looking": 0.6, "writing": 0.85}  # fmt: skip

_SHOWING = {"compiling": 0.05, "(a)": 0.15, "(b)": 0.55}

if TYPE_CHECKING:
    from symgen.data.raw import Reading
    from symgen.runtime.check import Checked


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option("--debug", is_flag=True, help="Show tracebacks of errors.")
@click.version_option(None, "-V", "--version", package_name="symgen")
def cli(debug: bool) -> None:
    """Dynamic models of robots in closed form, and their parameters from measured logs."""


@cli.command()
def robots() -> None:
    """List the built-in robots."""
    from symgen.robot.builtin import library, library_summary

    table(("name", "joints", "robot"), [(name, *library_summary(name)) for name in library()])


@cli.command("import")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--fix", multiple=True, help="A joint held still, NAME or NAME=VALUE; repeatable.")
@click.option("--into", type=click.Path(path_type=Path), help="The robot.toml to write.")
def import_(file: Path, fix: tuple[str, ...], into: Path | None) -> int:
    """Read FILE (.urdf, .par of SYMORO, .xml of MuJoCo), print its table, write it as robot.toml.

    Values of parameters that the file has go into NAME_parameters.toml beside it. Without --into
    the table is printed alone.
    """
    import symgen
    from symgen.files import check_text_replaceable, write_text
    from symgen.robot.fixed import with_fixed
    from symgen.robot.foreign import read_imported
    from symgen.robot.toml_text import parameters_toml

    if into is not None and into.suffix != ".toml":
        raise click.UsageError(f"--into {into}: accepted: a path that ends in .toml")
    found = with_fixed(read_imported(file), fix)
    files = {} if into is None else {into: symgen.robot_toml(found.robot)}
    if into is not None and found.parameters:
        values = into.with_name(f"{found.robot.name}_parameters.toml")
        files[values] = parameters_toml(found.parameters)
    for path in files:
        check_text_replaceable(path)
    for path, text in files.items():
        write_text(path, text)
    print_robot(found.robot)
    for line in found.notes:
        click.echo(f"note: {line}")
    for line in found.assumed:
        warnings.warn(f"{file}: {line}", SymgenWarning, stacklevel=1)
    if files:
        click.echo(f"written: {', '.join(map(str, files))}")
    return 0


@cli.command()
@click.argument("folder", type=click.Path(path_type=Path))
def check(folder: Path) -> int:
    """Check generated packages: write them again, compare, prove again, measure error and stack."""
    import symgen

    say("deriving, compiling and comparing")
    with meter("checking") as advance:
        results = symgen.check(folder, meter=advance)
    rows = [
        (
            result.folder.name,
            "different" if result.differences else "equal",
            str(result.rank),
            str(len({kernel for _, kernel, _ in result.errors})),
            *(_worst(result.errors, backend) for backend in ("c", "casadi")),
        )
        for result in results
    ]
    table(("package", "files", "rank", "kernels", "worst of C", "worst of CasADi"), rows)
    _stack_table(results)
    for result in results:
        for line in result.differences:
            click.echo(f"{result.folder}: {line}")
    return 1 if any(result.differences for result in results) else 0


def _stack_table(results: Sequence[Checked]) -> None:
    """Write the worst-case stack of every function for one sample, a column for each package."""
    measured = {r.folder.name: r.stacks for r in results if r.stacks is not None}
    missing = [r.folder.name for r in results if r.stacks is None]
    functions = sorted({f for stacks in measured.values() for f in stacks if f[-6:] != "_batch"})
    if functions:
        rows = [(f, *(str(stacks.get(f, "-")) for stacks in measured.values())) for f in functions]
        table(("worst-case stack, bytes", *measured), rows)
        click.echo("as this C compiler builds them at -O2; what libm takes comes on top")
    if missing:
        click.echo(f"stack not measured: {', '.join(missing)} (no C, or no compiler that counts)")


def _worst(errors: Sequence[tuple[str, str, float]], backend: str) -> str:
    """Write the largest measured relative error of a backend, and the kernel that shows it."""
    found = [(error, kernel) for b, kernel, error in errors if b == backend]
    return "-" if not found else "{:.1e} ({})".format(*max(found))


@cli.command()
@click.argument("robot", shell_complete=robot_names)
@click.argument("log", type=click.Path())
@click.option("--parameters", required=True, help="estimate.json, or TOML with [parameters].")
@click.option(
    "--cutoff", type=float, help="Of the filter of q and qd, Hz; by default it is chosen."
)
@reading_options
@click.option("--into", type=click.Path(path_type=Path), required=True, help="Folder of results.")
def predict(
    robot: str, log: str, parameters: str, cutoff: float | None, reading: Reading, into: Path
) -> int:
    """Predict torque and energy of LOG with given parameters of ROBOT, and the error."""
    import symgen
    from symgen.files import check_replaceable

    check_replaceable(into, "prediction.json")
    with stages({"deriving": 0.02}) as told:
        told("deriving and compiling the model")
        prediction = symgen.predict(robot, log, parameters, cutoff=cutoff, reading=reading)
    files = symgen.write(prediction, into)
    print_prediction(prediction)
    click.echo(f"written: {', '.join(map(str, files))}")
    return 0


@cli.command()
@click.argument("robot", shell_complete=robot_names)
@click.argument("logs", nargs=-1, required=True, type=click.Path())
@click.option("--validation", multiple=True, help="A log to show the gap on; may be repeated.")
@click.option("--parameters", help="Given ones, not identified again: what has changed since?")
@click.option("--effects", help="Comma-separated names to try; default all (symgen explain).")
@click.option(
    "--cutoff", type=float, help="Of the filter of q and qd, Hz; by default it is chosen."
)
@reading_options
@click.option("--into", type=click.Path(path_type=Path), required=True, help="Folder of results.")
def diagnose(
    robot: str,
    logs: tuple[str, ...],
    validation: tuple[str, ...],
    parameters: str | None,
    effects: str | None,
    cutoff: float | None,
    reading: Reading,
    into: Path,
) -> int:
    """Find what the model of ROBOT misses in LOGS, name it, add it, and show the gap shrink."""
    import symgen
    from symgen.diagnosis_page import MARKER
    from symgen.files import check_replaceable

    check_replaceable(into, MARKER)
    with stages(_DIAGNOSING) as told:
        diagnosis = symgen.diagnose(
            robot,
            list(logs),
            validation=list(validation),
            parameters=parameters,
            effects=None if effects is None else listed(effects),
            cutoff=cutoff,
            reading=reading,
            progress=told,
        )
        told("writing the page and the extended model")
        symgen.write(diagnosis, into)
    print_diagnosis(diagnosis, into)
    names = "diagnosis.json, report.html, robot.toml, parameters.toml, generated/"
    click.echo(f"written: {into} ({names})")
    return 0 if diagnosis.verdict in ("consistent", "explained") else 1


@cli.command()
@click.argument("effect", required=False, shell_complete=effect_names)
def explain(effect: str | None) -> None:
    """Tell what EFFECT is, its formula, what it looks like and how to declare it."""
    from symgen.explain import explained, listed

    if effect is None:
        table(("effect", "kind", "what it is"), listed())
    else:
        print_text(explained(effect))


@cli.command()
@click.option(
    "--into",
    type=click.Path(path_type=Path),
    default=Path("symgen-demo"),
    show_default=True,
    help="Folder of the page.",
)
@click.option("--runs", default=1000, show_default=True, type=click.IntRange(10, 100_000))
def demo(into: Path, runs: int) -> int:
    """Run the example of Gautier and Khalil (1988) end to end."""
    from symgen.demo import run_demo

    blocks = []
    with stages(_SHOWING) as told:
        for block in run_demo(into, runs, told):
            blocks.append(block)
    click.echo("\n".join(blocks))
    return 0


cli.add_command(fleet)
cli.add_command(generate)
cli.add_command(identify)
cli.add_command(excite)
cli.add_command(export)
cli.add_command(payload)
cli.add_command(report)
cli.add_command(doctor)
cli.add_command(simulate)
cli.add_command(study)


def main() -> None:
    """Run the command line and exit; every foreseen error is one line on stderr."""
    # The matrices here are small: threads of a BLAS that wait for each other cost more than they
    # do, tenfold where other programs run. Set before NumPy is imported, unless the user did.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    arguments = sys.argv[1:]
    debug = "--debug" in arguments
    if debug:
        arguments = ["--debug", *(a for a in arguments if a != "--debug")]
    if isinstance(sys.stdout, io.TextIOWrapper):  # a name that this terminal has no letters for
        sys.stdout.reconfigure(errors="backslashreplace")
    warnings.simplefilter("always", SymgenWarning)
    shown = warnings.showwarning

    def show(message: Any, category: Any, *rest: Any, **more: Any) -> None:
        if issubclass(category, SymgenWarning):
            click.echo(f"symgen: warning: {message}", err=True)
        else:
            shown(message, category, *rest, **more)

    warnings.showwarning = show
    try:
        code = _run(arguments)
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.ClickException as error:
        code = _fail(" ".join(error.format_message().split()) or "arguments are missing")
    except SymgenError as error:
        if debug:
            traceback.print_exc()
        code = _fail(str(error))
    except (KeyboardInterrupt, click.Abort):
        click.echo("symgen: interrupted", err=True)
        code = 130
    except BrokenPipeError:  # the reader has gone; what it wanted it has
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    except OSError as error:
        if debug:
            traceback.print_exc()
        code = _fail(f"{error.filename or 'output'}: {error.strerror or error}")
    except MemoryError:
        code = _fail("out of memory; use shorter logs")
    sys.exit(code)


def _run(arguments: list[str]) -> int:
    """Run one subcommand and return its exit code; errors pass through as exceptions."""
    if instruction := os.environ.get(COMPLETE):
        from click.shell_completion import shell_complete

        return shell_complete(cli, {}, "symgen", COMPLETE, instruction)
    try:
        with cli.make_context("symgen", arguments, max_content_width=100) as context:
            return int(cli.invoke(context) or 0)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return 2
    except click.exceptions.Exit as done:
        return done.exit_code


def _fail(message: str) -> int:
    click.echo(f"symgen: error: {SymgenError(message)}", err=True)  # one line, and plain
    return 2
