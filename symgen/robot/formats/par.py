"""Translate SYMORO+ and OpenSYMORO files (.par) to robot.toml; both use the same DH notation.

A .par contains names of lengths without values. They become names in [geometry], with values that
the user must replace. The joint variable (th2, t2, r3) is removed from theta or r; an added
constant remains. The reader of robot.toml checks the result. Values of inertial parameters are not
read. Format: W. Khalil, A. Vijayalingam et al., OpenSYMORO (2014).
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from symgen.errors import RobotError, located, shortened
from symgen.robot.identifiers import robot_name
from symgen.robot.imported import Imported
from symgen.robot.toml_io import parse_robot

_COMMENT = re.compile(r"\(\*.*?\*\)", re.DOTALL)
#: A list that does not end is an entry too, so that it is refused.
_ENTRY = re.compile(r"\b([A-Za-z_]\w*)[ \t]*=[ \t]*(\{[^{}]*\}?|[^\s{}]+)", re.ASCII)
_NAME = re.compile(r"(?<![\w.])(?!(?:pi|sqrt)\b)[A-Za-z_]\w*", re.ASCII)
_KEYS = {"ant": "antecedent", **{k: k for k in "sigma gamma b alpha d theta r".split()}}
#: The column with the variable of a joint, and the letters of that variable.
_VARIABLE = {"0": ("theta", "(?:th|theta|t|q)"), "1": ("r", "(?:r|q)")}


def import_par(text: str, where: str = "robot.par", base: str | None = None) -> Imported:
    """Read a .par as a robot.

    Args:
        text: the file's text.
        where: name of the file in error messages.
        base: base of the robot; None for a fixed one.

    Raises:
        RobotError: the text is not a .par, or not an open chain; the message names the entry.
    """
    entries = {}
    for key, value in _ENTRY.findall(_COMMENT.sub(" ", text)):
        items = value.strip("{}").replace("Pi", "pi").split(",")
        entries[key if key == "G" else key.lower()] = [item.strip() for item in items]
    with located(where):
        if entries.get("type", ["0"])[0] not in "01" or not {"ant", "sigma"} <= entries.keys():
            raise RobotError(
                "not an open chain with lists ant = {...} and sigma = {...}; accepted: Type 0 "
                "(simple chain) or 1 (tree); write a parallelogram as robot.toml with 'follows'"
            )
        lines, lengths = [], set[str]()
        for number in range(1, len(entries["ant"]) + 1):
            joint = _joint(entries, number)
            lengths.update(name for value in joint.values() for name in _NAME.findall(value))
            lines.append("[[joint]]")
            for key, value in joint.items():
                lines.append(f"{key} = {value if value.isdecimal() else json.dumps(value)}")
            lines += _declared(entries, number)
    # Distinct values, so that no length cancels another by chance.
    geometry = [f"{name} = 0.{29 + 2 * k}" for k, name in enumerate(sorted(lengths))]
    gravity = [x if not _NAME.search(x) else "-9.81" for x in entries.get("G", ["0", "0", "G3"])]
    head = [
        f'[robot]\nname = "{robot_name(Path(where).stem)}"',
        f"gravity = [{', '.join(gravity)}]",
    ]
    if base is not None:
        head.append(f'base = "{base}"')
    robot = parse_robot("\n".join([*head, "[geometry]", *geometry, *lines]), where)
    assumed = ["values that are not in the file; replace them in robot.toml: ", *geometry]
    return Imported(robot, (), (), (" ".join(assumed),) if geometry else ())


def _joint(entries: dict[str, list[str]], number: int) -> dict[str, str]:
    """Return the geometry of a joint by the keys of robot.toml, without the joint variable."""
    joint = {}
    for key, name in _KEYS.items():
        items = entries.get(key, ["0"] * number)
        if len(items) < number:
            raise RobotError(f"{key} has {len(items)} entries; accepted: one for each joint")
        joint[name] = shortened(items[number - 1])
    if joint["sigma"] not in (*_VARIABLE, "2"):
        raise RobotError(f"sigma, entry {number}: {joint['sigma']!r}; accepted: 0, 1 or 2")
    if joint["sigma"] in _VARIABLE:
        key, letters = _VARIABLE[joint["sigma"]]
        variable = rf"(?:^|\+)\s*{letters}{number}(?=\s*(?:[+-]|$))"
        rest, times = re.subn(variable, "", joint[key], flags=re.IGNORECASE)
        if times != 1:
            raise RobotError(
                f"{key}, entry {number}: {joint[key]!r}; accepted: the joint's variable and a "
                "constant added to it"
            )
        joint[key] = rest.strip() or "0"
    if re.search(r"\b(?:th|theta|t|q)[0-9]+\b", joint["theta"], re.IGNORECASE):
        raise RobotError(
            f"theta, entry {number}: {joint['theta']!r} holds another joint's variable"
        )
    return joint


def _declared(entries: dict[str, list[str]], number: int) -> list[str]:
    """Return the declared friction and rotor of a joint. As in SYMORO, a parameter 0 does not
    exist.
    """
    if entries["sigma"][number - 1] not in _VARIABLE:
        return []
    zeros = [
        key for key in ("fs", "fv", "ia") if entries.get(key, [])[number - 1 : number] == ["0"]
    ]
    friction = [word for word, key in (("coulomb", "fs"), ("viscous", "fv")) if key not in zeros]
    return [f"friction = {friction}", f"rotor_inertia = {str('ia' not in zeros).lower()}"]
