"""Names that a file gives to the columns of a log: written out, or in a small TOML file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from symgen.data.raw import one_line
from symgen.errors import LogError, plain
from symgen.files import load_toml

#: How the command begins that holds joints still; a command line puts its own file in.
IMPORT = "symgen import FILE "
_ACCEPTED = "ours=theirs separated by commas, such as t=time,q1=shoulder_pos, or a .toml file"


def columns_from(text: str) -> dict[str, str]:
    """Return the names in a file by ours, as `Reading.columns` takes them.

    Args:
        text: "t=time,q1=shoulder_pos", or the path of a TOML file with a table [columns].

    Raises:
        LogError: the text or the file is not such a map.
    """
    if text.endswith(".toml"):
        return _from_file(Path(text))
    found: dict[str, str] = {}
    for pair in text.split(","):
        ours, sign, theirs = (part.strip() for part in pair.partition("="))
        if not (ours and sign and theirs):
            raise LogError(f"--columns: {pair[:40]!r}; accepted: {_ACCEPTED}")
        if ours in found:
            raise LogError(f"--columns: {ours} is given twice; accepted: {_ACCEPTED}")
        found[ours] = theirs
    return found


def _from_file(path: Path) -> dict[str, str]:
    accepted = 'accepted: a table [columns] of texts, such as q1 = "shoulder_pos"'
    try:
        data = load_toml(path.read_text("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        raise LogError(one_line(f"--columns {path}: {error}; {accepted}")) from error
    table = data.get("columns")
    if set(data) != {"columns"} or not isinstance(table, dict):
        raise LogError(f"--columns {path}: holds {', '.join(data) or 'nothing'}; {accepted}")
    for ours, theirs in table.items():
        if not isinstance(theirs, str):
            raise LogError(f"--columns {path}: {ours} is not a text; {accepted}")
    return dict(table)


def another_number(joints: int, n: int, names: Sequence[str] = ()) -> tuple[str, str]:
    """Return what is wrong with a log of another number of joints than its robot, and what is not.

    Args:
        joints: number of joints in the log.
        n: number of movable joints of the robot.
        names: what the robot calls them, in order.
    """
    count = f"{joints} joint{'s' if joints > 1 else ''}"
    what, accepted = f"the log has {count}, the robot has {n}", "one q and tau per movable joint"
    beyond = [plain(name) for name in names[joints:]]
    if not beyond or not all(beyond):
        return what, accepted
    return f"{what}: no column for {', '.join(beyond)}", f"{accepted}, or {held_still(beyond)}"


def held_still(joints: Sequence[str]) -> str:
    """Return the command that takes joints out of an imported robot."""
    fixes = " ".join(f"--fix {plain(joint)}" for joint in joints)
    return f"joints without columns held still: {IMPORT}{fixes} --into robot.toml"
