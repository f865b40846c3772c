"""The command `report`: print a result again, or compare two estimates."""

from __future__ import annotations

from pathlib import Path

import click

from symgen.cli.options import PATH, options_of
from symgen.report.terminal import print_result, say


@click.command()
@click.argument("folder", type=PATH)
@click.argument("other", type=PATH, required=False)
@options_of("report")
def report(folder: Path, other: Path | None, into: Path | None) -> int:
    """Print the result in FOLDER again, or compare the estimates in FOLDER and OTHER.

    FOLDER is a result of identify, diagnose, predict, payload or study. --into writes its
    page again. The exit code is that of the command that wrote the result. For a comparison, it is
    0 if the two agree.
    """
    import symgen
    from symgen.files import check_new, write_files
    from symgen.report.store import load_result, result_page, result_robot

    if into is not None:
        if into.suffix != ".html":
            raise click.UsageError(f"--into {into}: accepted: a path that ends in .html")
        check_new(into)
    result = load_result(folder) if other is None else symgen.compare(folder, other)
    if into is not None:
        write_files([(into, result_page(result, result_robot(folder)).encode())])
    good = print_result(result)
    if into is not None:
        say(f"written: {into}")
    return 0 if good else 1
