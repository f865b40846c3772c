"""The command line: parse the arguments, call one public function, print the result.

Results go to stdout and to files, progress and messages to stderr. Exit code 0: done. 1: done, and
the answer is "no". 2: failed.
"""

from __future__ import annotations

import io
import os
import sys
import traceback
import warnings
from typing import Any

import click

from symgen.cli.compare_sim import compare_sim
from symgen.cli.demo import demo
from symgen.cli.diagnose import diagnose
from symgen.cli.doctor import doctor
from symgen.cli.excite import excite
from symgen.cli.explain import explain
from symgen.cli.export import export
from symgen.cli.generate import generate
from symgen.cli.identify import identify
from symgen.cli.payload import payload
from symgen.cli.predict import predict
from symgen.cli.report import report
from symgen.cli.robots import import_, robots
from symgen.cli.simulate import simulate
from symgen.cli.study import study
from symgen.errors import SymgenError, SymgenWarning

_SETTINGS = {
    "help_option_names": ["-h", "--help"],
    "max_content_width": 100,
    "show_default": True,
}
#: Environment variable of a shell that requests completion.
COMPLETE = "_SYMGEN_COMPLETE"


@click.group(context_settings=_SETTINGS)
@click.option("--debug", is_flag=True, help="Show tracebacks of errors.")
@click.version_option(None, "-V", "--version", package_name="symgen")
def cli(debug: bool) -> None:
    """Derive dynamic models of robots, identify their parameters, and diagnose model errors."""


for _command in (compare_sim, demo, diagnose, doctor, excite, explain, export,
                 generate, identify, import_, payload, predict, report, robots, simulate,
                 study):  # fmt: skip
    cli.add_command(_command)


def main() -> None:
    """Run the command line and exit; each expected error prints one line to stderr."""
    # The matrices are small, so BLAS threads mostly wait for each other: ten times slower on a busy
    # computer. The variable must be set before NumPy is imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # The kernels of a large robot repeat many expressions, and by default SymPy caches only 1000
    # results of each function. This cache takes 100 MB at most. SymPy must be imported later.
    os.environ.setdefault("SYMPY_CACHE_SIZE", "100000")
    arguments = sys.argv[1:]
    debug = "--debug" in arguments
    if debug:
        arguments = ["--debug", *(a for a in arguments if a != "--debug")]
    # names may have letters that the terminal does not support
    if isinstance(sys.stdout, io.TextIOWrapper):
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
    except BrokenPipeError:  # the reader closed the pipe
        _discard_output()
        code = 0
    except OSError as error:
        if debug:
            traceback.print_exc()
        code = _fail(f"{error.filename or 'output'}: {error.strerror or error}")
        if error.filename is None:  # Python would write the rest of the output again at its end
            _discard_output()
    except MemoryError:
        code = _fail("out of memory; use shorter logs")
    sys.exit(code)


def _discard_output() -> None:
    """Send the rest of the output nowhere."""
    if sys.stdout is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _run(arguments: list[str]) -> int:
    """Run one command and return its exit code. Errors are exceptions."""
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
    click.echo(
        f"symgen: error: {SymgenError(message)}", err=True
    )  # one line without control characters
    return 2
