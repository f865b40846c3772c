"""The texts of robots, and robots from files of other programs, with parameter values and notes.

Reading a text needs no heavy import.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from symgen.errors import RobotError, message_of, shortened
from symgen.robot.builtin import library, library_text
from symgen.robot.identifiers import MAX_NAME, is_robot_name, robot_name

if TYPE_CHECKING:
    from symgen.robot.types import Robot

#: File ending -> module of `symgen.robot.formats` that reads it.
FORMATS = {".urdf": "urdf", ".xacro": "urdf", ".par": "par", ".xml": "mjcf"}
_MAX_BYTES = 1_000_000
_MAX_FOREIGN_BYTES = 20_000_000  # a URDF can contain geometry for display


@dataclass(frozen=True)
class Imported:
    """A robot from a file of another program.

    Attributes:
        robot: the robot, with exact geometry.
        parameters: (name, value) of the standard parameters in the file (XX1, FV2).
        notes: differences between the robot and the file, one line each.
        assumed: assumptions for content that the file lacks, one line each.
    """

    robot: Robot
    parameters: tuple[tuple[str, float], ...]
    notes: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()


def with_name(imported: Imported, name: str) -> Imported:
    """Return an imported robot with another name.

    Raises:
        RobotError: the name is not a C identifier, or hides a C header.
    """
    if not is_robot_name(name):
        raise RobotError(
            f"--name {shortened(name)}: accepted: a C identifier of at most {MAX_NAME} characters "
            f"that is no word and no header of C, such as {robot_name(name)}"
        )
    notes = tuple(n for n in imported.notes if not n.endswith(f" is called {imported.robot.name}"))
    return replace(imported, robot=replace(imported.robot, name=name), notes=notes)


def robot_text(source: str | Path) -> tuple[str, Path]:
    """Return the text of a robot, and the path of its file, or "library robot NAME".

    Args:
        source: as for `read_robot`.

    Raises:
        RobotError: there is no such robot, or the file cannot be read.
    """
    if str(source) in library() and not Path(source).exists():
        return library_text(str(source)), Path(f"library robot {source}")
    accepted = (
        f"accepted: a path to robot.toml, a .urdf, a .par, an MJCF (.xml), a generated package, or "
        f"{', '.join(library())}"
    )
    return read_text(source, accepted)


def read_text(source: str | Path, accepted: str) -> tuple[str, Path]:
    """Read a robot file of reasonable size as UTF-8.

    Args:
        source: path of the file, or of a folder with a robot.toml.
        accepted: the accepted input, for error messages.

    Returns:
        The text, and the path of the file.

    Raises:
        RobotError: there is no such file, or it cannot be read.
    """
    shown = shortened(str(source)) or "(empty)"
    try:
        path = Path(source)
        if str(source) and path.is_dir():
            path = path / "robot.toml"
            if not path.exists():
                raise RobotError(f"{shown}: a folder without a robot.toml; {accepted}")
        if not str(source) or not path.exists():
            raise RobotError(f"{shown}: no such file or library robot; {accepted}")
        if not path.is_file():
            raise RobotError(f"{shown}: not a regular file; {accepted}")
        limit = _MAX_FOREIGN_BYTES if path.suffix.lower() in FORMATS else _MAX_BYTES
        with path.open("rb") as file:
            content = file.read(limit + 1)
        text = content.decode("utf-8-sig")
    except (OSError, ValueError) as error:
        what = f"{shown}: cannot be read as UTF-8 text ({message_of(error)})"
        raise RobotError(f"{what}; {accepted}") from error
    if len(content) > limit:
        raise RobotError(f"{shown}: larger than {limit} bytes; {accepted}")
    return text, path
