"""The commands `robots` and `import`: built-in robots, and robots from other formats."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import click

from symgen.cli.options import PATH, options_of
from symgen.errors import SymgenWarning
from symgen.report.terminal import say, table


@click.command()
def robots() -> None:
    """List the built-in robots."""
    from symgen.robot.builtin import library, library_summary

    table(("name", "joints", "robot"), [(name, *library_summary(name)) for name in library()])


@click.command("import")
@click.argument("file", type=PATH)
@options_of("import")
def import_(
    file: Path,
    name: str | None,
    fix: tuple[str, ...],
    base: str | None,
    exact: bool,
    into: Path | None,
) -> None:
    """Convert FILE (.urdf, .par of SYMORO, .xml of MuJoCo) to robot.toml and print its table.

    If FILE has values of parameters, symgen writes them to NAME_parameters.toml beside robot.toml.
    Without --into, symgen only prints the table.
    """
    import symgen
    from symgen.files import check_text_replaceable, write_text
    from symgen.robot.fixed import with_fixed
    from symgen.robot.imported import with_name
    from symgen.robot.toml_io import read_imported
    from symgen.robot.toml_text import parameters_toml
    from symgen.robot.types import HEADER

    if into is not None and into.suffix != ".toml":
        raise click.UsageError(f"--into {into}: accepted: a path that ends in .toml")
    found = with_fixed(read_imported(file, base), fix)
    if name is not None:
        found = with_name(found, name)
    robot = replace(found.robot, exact=exact)
    files = {} if into is None else {into: symgen.robot_toml(robot)}
    if into is not None and found.parameters:
        values = into.with_name(f"{found.robot.name}_parameters.toml")
        files[values] = parameters_toml(found.parameters)
    for path in files:
        check_text_replaceable(path)
    for path, text in files.items():
        write_text(path, text)
    table(HEADER, found.robot.table())
    for line in found.notes:
        say(f"note: {line}")
    for line in found.assumed:
        warnings.warn(f"{file}: {line}", SymgenWarning, stacklevel=1)
    if files:
        say(f"written: {', '.join(map(str, files))}")
