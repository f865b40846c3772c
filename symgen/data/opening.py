"""The one door to tables: CSV, Parquet and NPZ, alone or in a data set."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen.data.npz import open_npz, rows_of_npz
from symgen.data.parquet import open_parquet, rows_of_parquet
from symgen.data.raw import BESIDE, COLUMNS, ROLES, Arrays, Raw, Table, one_line, refuse
from symgen.data.tables import read_csv
from symgen.data.urls import is_remote
from symgen.errors import LogError

#: Ends of names of tables.
SUFFIXES = (".csv", ".parquet", ".npz")
#: Those that tell their rows without being read, 0 where they do not: whoever reads says why.
COUNTED = {".parquet": rows_of_parquet, ".npz": rows_of_npz}


@contextmanager
def open_table(
    name: str,
    columns: Mapping[str, str],
    currents: bool,
    joints: Sequence[str] = (),
    n: int | None = None,
    poses: bool = False,
    beside: bool = True,
    sound: bool = False,
) -> Iterator[Table]:
    """Open a table of a log.

    Args:
        name: of the file, one of SUFFIXES; or the URL of a Parquet file.
        columns, currents, joints, n, poses: as for `read_csv`.
        beside: whether temperatures and positions of links are read, too.
        sound: whether checksums were found right before.

    Raises:
        LogError: it cannot be read, or is no log.
    """
    path, suffix = Path(name), name[name.rfind(".") :].lower()
    try:
        if suffix == ".parquet":
            with open_parquet(name, columns, currents, joints, n, poses, beside) as table:
                yield table
            return
        if is_remote(name):
            refuse(name, "is a CSV or NPZ at a URL", "Parquet at a URL, other files on a disk")
        if path.stat().st_size == 0:
            refuse(path, "the file is empty", COLUMNS)
        if suffix == ".npz":
            found = open_npz(path, columns, currents, poses, sound)
        else:
            raw = read_csv(path, columns, currents, joints, n, poses)
            held = {role: x for role in ROLES if (x := getattr(raw, role)) is not None}
            found = Arrays(held, raw.ignored, raw.notes)
        yield found if beside else found.without(BESIDE)
    except (OSError, ValueError, csv.Error) as error:
        why = f"{name}: cannot be read: {error}; accepted: a CSV, Parquet or NPZ file"
        raise LogError(one_line(why)) from error


def whole(table: Table) -> Raw:
    """Read all rows of a table, as arrays in rows."""
    (raw,) = table.spans([(0, table.rows)])
    held = {role: x for role in ROLES if (x := getattr(raw, role)) is not None}
    arrays: dict[str, Any] = {role: np.ascontiguousarray(x) for role, x in held.items()}
    return replace(raw, **arrays)
