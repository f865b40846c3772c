"""The command `export`: identified link parameters in a copy of the robot file."""

from __future__ import annotations

from pathlib import Path

import click

from symgen.cli.options import PATH
from symgen.cli.progress import say
from symgen.errors import PackageError


@click.command()
@click.argument("estimate", type=PATH)
@click.option("--to", type=PATH, required=True, help="URDF or MJCF to write.")
@click.option("--from", "source", type=PATH, help="Robot file to copy; default the file of --to.")
@click.option("--robot", help="Robot that was identified; default robot.toml beside ESTIMATE.")
def export(estimate: Path, to: Path, source: Path | None, robot: str | None) -> None:
    """Write the link parameters of ESTIMATE into the URDF or MJCF of the robot.

    Only link parameters change. Many sets of link parameters fit an estimate: symgen takes the
    physically possible one that is nearest to the values in the file.
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
