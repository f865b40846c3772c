"""Logs as tables: what their columns are, and CSV."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from symgen.data.beside import spread
from symgen.data.raw import (
    BESIDE,
    COLUMNS,
    NUMBERED,
    FloatArray,
    Raw,
    listed,
    one_line,
    refuse,
    refuse_currents,
)
from symgen.data.recorders import matched
from symgen.errors import LogError

_LOOKED_AT = 1000  # columns that are searched for a bad cell
_PATTERN = {"t": "t=NAME", "q1": "q=*_NAME", "tau1": "tau=*_NAME"}


def read_csv(
    path: Path,
    columns: Mapping[str, str],
    currents: bool,
    joints: Sequence[str] = (),
    n: int | None = None,
    poses: bool = False,
) -> Raw:
    """Read a CSV with a header.

    Args:
        path: the file.
        columns: names in the file of our columns; those of a recorder are matched, see `matched`.
        currents: whether currents i1.. are read, and may stand in place of torques.
        joints: what the robot calls its movable joints.
        n: their number, None where it is not known.
        poses: whether rows are still poses, which need no t: their number is taken for it.

    Raises:
        LogError: the file is not a table of numbers with the columns of a log.
    """
    import pyarrow as pa
    import pyarrow.csv as pacsv

    try:
        # utf-8-sig drops the byte order mark that spreadsheets write.
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = csv.reader(file)
            header = next((row for row in rows if row), [])
            skip = rows.line_num
    except (UnicodeDecodeError, csv.Error) as error:
        raise LogError(f"{path}: is not a text file; accepted: CSV in UTF-8") from error
    stripped = [name.strip() for name in header]
    names, notes = _renamed(path, stripped, columns, joints, n, currents)
    groups = _groups(path, names, currents, poses)
    wanted = [name for group in groups.values() for name in group]
    try:
        table = pacsv.read_csv(
            path,
            read_options=pacsv.ReadOptions(column_names=names, skip_rows=skip),
            convert_options=pacsv.ConvertOptions(
                include_columns=wanted, column_types=dict.fromkeys(wanted, pa.float64())
            ),
        )
    except (pa.ArrowInvalid, pa.ArrowKeyError) as error:
        what = _bad_cell(path, names, wanted) or str(error)
        accepted = "at least 10 rows of numbers, separated by commas"
        raise LogError(one_line(f"{path}: {what}; accepted: {accepted}")) from error
    return _from_columns(table, names, groups, notes)


def _bad_cell(path: Path, names: list[str], wanted: list[str]) -> str | None:
    """Find the first row of a refused CSV that is too short, too long, or holds a text.

    The CSV reader works in blocks, on several threads, and cannot tell the row itself.
    """
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        rows = (row for row in csv.reader(file) if row)
        next(rows)
        places = {name: names.index(name) for name in wanted[:_LOOKED_AT]}
        sample = -1
        for sample, row in enumerate(rows):
            if len(row) != len(names):
                return f"sample {sample}: {len(row)} values for {len(names)} columns"
            for name, place in places.items():
                cell = row[place].strip()
                try:
                    float(cell or "nan")
                except ValueError:
                    return f"column {name}, sample {sample}: {cell[:40]!r} is not a number"
    return "has a header and no samples" if sample < 0 else None


def assigned(
    path: Path,
    stored: Sequence[str],
    types: Sequence[Any],
    columns: Mapping[str, str],
    currents: bool,
    joints: Sequence[str],
    n: int | None,
    poses: bool = False,
) -> tuple[list[str], dict[str, list[str]], tuple[str, ...]]:
    """Return what the columns of a Parquet table are.

    Args:
        path: the file.
        stored: names of its columns.
        types: their types, of pyarrow.
        columns, currents, joints, n, poses: as for `read_csv`.

    Returns:
        Our names in the order of `stored`, those of every role, and notes.

    Raises:
        LogError: a column is missing or holds no numbers.
    """
    import pyarrow as pa

    stripped = [name.strip() for name in stored]
    names, notes = _renamed(path, stripped, columns, joints, n, currents)
    groups = _groups(path, names, currents, poses)
    for name in (name for group in groups.values() for name in group):
        kind = types[names.index(name)]
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
            refuse(path, f"column {name} holds {kind}", "floats or integers")
    return names, groups, notes


def _renamed(
    path: Path,
    names: list[str],
    columns: Mapping[str, str],
    joints: Sequence[str],
    n: int | None,
    currents: bool,
) -> tuple[list[str], tuple[str, ...]]:
    """Return the names of a file's columns as ours, and which were matched by themselves.

    One that another takes the name of is lost.
    """
    patterns = {ours: theirs for ours, theirs in columns.items() if "*" in theirs and ours != "t"}
    columns = {ours: theirs for ours, theirs in columns.items() if ours not in patterns}
    for ours, theirs in columns.items():
        if ours != "t" and NUMBERED.fullmatch(ours) is None:
            refuse(path, f"--columns {ours}={theirs}: a table has one column a joint", COLUMNS)
        if theirs not in names:
            refuse(path, f"there is no column {theirs!r} (--columns {ours})", listed(names))
    ours_of = {theirs: ours for ours, theirs in columns.items()}
    given = [
        ours_of.get(name, f"{name} (of the file)" if name in columns else name) for name in names
    ]
    return matched(path, given, patterns, joints, n, currents)


def _groups(
    path: Path, names: list[str], currents: bool, poses: bool = False
) -> dict[str, list[str]]:
    """Sort the names of columns into {"t": [t], "q": [q1, ..], "qd": [..], ..}, by number."""
    named = [name for name in names if name]
    name, count = Counter(named).most_common(1)[0] if named else ("", 0)
    if count > 1:
        refuse(path, f"the column {name} occurs {count} times", "each column once")
    numbers: dict[str, list[int]] = {role: [] for role in ("q", "qd", "tau", "i", *BESIDE)}
    for name in named:
        if match := NUMBERED.fullmatch(name):
            numbers[match[1]].append(int(match[2]))
    measured = numbers["tau"] or (numbers["i"] if currents else [])
    for role, present in (("t", poses or "t" in named), ("q1", numbers["q"]), ("tau1", measured)):
        if role == "tau1" and not present and numbers["i"]:
            refuse_currents(path)
        if not present:
            how = f'{COLUMNS}, or --columns "{_PATTERN[role]}"'
            refuse(path, f"there is no column {role} among {listed(names)}", how)
    if not currents or (numbers["tau"] and len(numbers["i"]) != len(numbers["q"])):
        del numbers["i"]
    groups = {"t": [] if poses else ["t"]}
    for role in numbers:
        have = sorted(numbers[role])
        if role in BESIDE:  # some joints have it
            have = [number for number in have if 1 <= number <= len(numbers["q"])]
        elif have != list(range(1, len(have) + 1)):
            gap = ", ".join(f"{role}{number}" for number in have)
            refuse(path, f"the columns {gap} are not numbered 1, 2, .. without gaps", COLUMNS)
        groups[role] = [f"{role}{number}" for number in have]
    return groups


def _from_columns(
    table: Any, names: list[str], groups: dict[str, list[str]], notes: tuple[str, ...]
) -> Raw:
    def stack(role: str) -> FloatArray | None:
        columns = [table[name].to_numpy().astype(np.float64) for name in groups.get(role, ())]
        return np.column_stack(columns) if columns else None

    used = {name for group in groups.values() for name in group}
    q = stack("q")
    assert q is not None  # _groups has seen to it
    beside = {role: spread(stack(role), groups.get(role, ()), q.shape[1]) for role in BESIDE}
    return Raw(
        t=table["t"].to_numpy() if groups["t"] else np.arange(len(q)),
        q=q,
        qd=stack("qd"),
        tau=stack("tau"),
        i=stack("i"),
        ignored=tuple(name for name in names if name not in used),
        notes=notes,
        **beside,
    )
