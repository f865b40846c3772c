"""Robots from other programs' files, each read by the module of its format."""

from __future__ import annotations

from pathlib import Path

from symgen.errors import RobotError
from symgen.robot.expressions import shortened
from symgen.robot.imported import FORMATS, Imported, read_text


def read_imported(path: str | Path) -> Imported:
    """Read a .urdf, a .par of SYMORO, or an .xml of MuJoCo.

    Raises:
        RobotError: it cannot be read, or is not a robot that symgen can have.
    """
    accepted = f"accepted: a path to a file with the ending {' or '.join(FORMATS)}"
    if Path(path).suffix.lower() not in FORMATS:
        raise RobotError(f"{shortened(str(path)) or '(empty)'}: not such a file; {accepted}")
    return parse_imported(*read_text(path, accepted))


def parse_imported(text: str, path: Path) -> Imported:
    """Read the text of a file whose ending tells its format.

    Raises:
        RobotError: it is not a robot that symgen can have.
    """
    if path.suffix.lower() == ".par":
        from symgen.robot.par_io import import_par

        return import_par(text, str(path))
    if path.suffix.lower() == ".xml":
        from symgen.robot.mjcf_io import import_mjcf

        return import_mjcf(path)
    from symgen.robot.urdf_io import import_urdf

    return import_urdf(text, str(path))
