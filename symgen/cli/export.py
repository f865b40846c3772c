"""The command `export`: identified link parameters in the robot's own file."""

from __future__ import annotations

from pathlib import Path

import click

from symgen.cli.options import PATH
from symgen.cli.progress import say
from symgen.errors import PackageError


@click.command()
@click.argument("estimate", type=PATH)
@click.option("--to", type=PATH, required=True, help="The URDF or MJCF to write.")
@click.option("--from", "source", type=PATH, help="The robot's file; by default that of --to.")
@click.option("--robot", help="The robot that was identified; default robot.toml by the estimate.")
def export(estimate: Path, to: Path, source: Path | None, robot: str | None) -> None:
    """Write the link parameters of ESTIMATE into the robot's URDF or MJCF, and nothing else.

    Of all parameters that a robot can have and that give the identified ones, those nearest to the
    file's own are taken.
    """
    from symgen.files import replace_file
    from symgen.identification.export import export as exported
    from symgen.robot.formats.urdf import without_inertials
    from symgen.robot.imported import read_text

    for path in {to, source or to}:
        if path.suffix.lower() not in (".urdf", ".xml") or path.suffix != to.suffix:
            raise click.UsageError(f"{path}: accepted: both end in .urdf, or both in .xml")
    say("deriving the model, and finding link parameters")
    text, said = exported(estimate, source or to, robot)
    if to.exists():
        old, _ = read_text(to, "accepted: a new file")
        if without_inertials(old, str(to)) != without_inertials(text):
            raise PackageError(f"{to}: exists, and is another robot's; accepted: a new file")
    marked = (source or to).read_bytes().startswith(b"\xef\xbb\xbf")
    replace_file(to, text.encode("utf-8-sig" if marked else "utf-8"))
    click.echo(f"note: {said}")
    click.echo(f"written: {to}")
