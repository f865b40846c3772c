"""The command `check`: generated packages against symgen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from symgen.cli.options import PATH
from symgen.cli.progress import meter, say
from symgen.report.terminal import table

if TYPE_CHECKING:
    from symgen.runtime.check import Checked


@click.command()
@click.argument("folder", type=PATH)
def check(folder: Path) -> int:
    """Check the generated packages in FOLDER.

    symgen generates each package again, compares the files, repeats the rank proof, and measures
    numerical error and stack. Exit code 1: a file differs.
    """
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
    lines = [f"{result.folder}: {line}" for result in results for line in result.differences]
    for line in lines:
        click.echo(line)
    return 1 if lines else 0


def _stack_table(results: Sequence[Checked]) -> None:
    """Print the worst-case stack of every function for one sample, one column for each package."""
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
    """Return the largest relative error of a backend, and its kernel, as text."""
    found = [(error, kernel) for b, kernel, error in errors if b == backend]
    return "-" if not found else "{:.1e} ({})".format(*max(found))
