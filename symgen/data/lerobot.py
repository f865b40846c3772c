"""LeRobot data sets: what meta/info.json states about their Parquet files.

A file has lists of positions, `observation.state`, and of references, `action`. Their unit is not
stated: it may be rad, degrees, or -100 to 100 of the range of a joint.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from symgen.data.columns import by_name, joints_of_file
from symgen.data.raw import TORQUES, Wanted, readable, refuse, role_of, roles_with_unit

#: Column of the times of the frames, the columns that it needs, and that of the positions.
CLOCK, FRAMES, STATE = "index/fps", ("index", "episode_index"), "observation.state"
#: Pause between two episodes of a file, s: a gap in time.
PAUSE = 1.0
_ACTION, _EFFORT = "action", "observation.effort"


def data_set_of(path: Path) -> Path | None:
    """Return the folder of the data set that contains a file or folder, or None."""
    near = (path, *path.absolute().parents[:3])
    return next((folder for folder in near if (folder / "meta/info.json").is_file()), None)


def log_name(path: Path) -> str:
    """Return the name of a log: that of its file, in a data set after that of its folder.

    Files of all data sets have the same names.
    """
    folder = data_set_of(path)
    return path.name if folder is None else f"{folder.absolute().name}/{path.name}"


def in_data_set(folder: Path, elements: Collection[str], wanted: Wanted) -> tuple[Wanted, float]:
    """Return what to read, with the columns that a data set states, and its frames per second.

    Args:
        folder: folder of the data set.
        elements: columns of a file, "observation.state[0]" for an element of a list.
        wanted: the robot, and names from the user, which come first.

    Raises:
        LogError: the file meta/info.json is none, a joint is not in the data set, or the unit of
            the positions is unknown.
    """
    reading = wanted.reading
    named = {role_of(ours) for ours in reading.pairs}
    lists = {"q": STATE}
    if f"{_EFFORT}[0]" not in elements and not named & TORQUES:
        lists["qr"] = _ACTION
    if not (lists.keys() <= roles_with_unit(reading) or reading.range):
        ranges = "range = [[low, high], ..] in rad in [log] of the robot file for -100 to 100"
        what = "a LeRobot data set does not state the unit of its positions"
        refuse(what, f"--unit deg, --unit rad, or {ranges}")
    pairs = dict(reading.pairs)
    with readable("meta/info.json cannot be read", "that of a LeRobot data set"):
        info = json.loads((folder / "meta/info.json").read_text("utf-8"))
        rate = float(info["fps"])
        pairs.setdefault("t", CLOCK)
        for role, column in lists.items():
            if role not in named and f"{column}[0]" in elements:
                places = _places(info["features"][column], wanted)
                for j, k in enumerate(places, 1):
                    pairs[f"{role}{j}"] = f"{column}[{k}]"
    return replace(wanted, reading=replace(reading, columns=pairs)), rate


def _places(feature: Mapping[str, Any], wanted: Wanted) -> Sequence[int]:
    """Return the place of each joint in a list: by its name, otherwise in the order of the list."""
    names = feature.get("names") or []
    if isinstance(names, dict):  # {"motors": [..]}
        names = next(iter(names.values()))
    names = [name.removesuffix(".pos") for name in names]
    joints = wanted.reading.joints or wanted.joints
    for found in by_name(names, joints).values():
        if len(found) == len(joints):
            return [names.index(found[j]) for j in range(len(joints))]
    width = feature["shape"][0]
    if not wanted.kept(width):
        joints_of_file(wanted, names)  # refuses the joint that lacks a place
    return range(width)
