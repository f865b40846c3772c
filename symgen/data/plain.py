"""Plain tables of t and numbered columns in CSV: motions and torques without the rest of a log."""

from __future__ import annotations

import csv
import re
from collections import Counter
from pathlib import Path

import numpy as np

from symgen.data.raw import FloatArray, refuse
from symgen.errors import LogError

_COLUMN = re.compile(r"(qdd|qd|q|tau)([1-9][0-9]*)")


def read_columns(
    path: str | Path, needed: tuple[str, ...], optional: tuple[str, ...], accepted: str
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Read t (N,) and groups of numbered columns (N, n) from CSV; other columns are ignored.

    Raises:
        LogError: the file cannot be read, a column is missing, or a value is not a finite number.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or "not a text file"
        raise LogError(f"{path}: cannot be read ({reason}); accepted: {accepted}") from error
    header = [name.strip() for name in rows[0]] if rows else []
    counts = Counter(match[1] for name in header if (match := _COLUMN.fullmatch(name)))
    if "t" not in header or not counts.keys() >= set(needed):
        refuse(path, f"columns {', '.join(header[:12]) or 'none'}", accepted)
    if len(rows) < 3:
        refuse(path, "fewer than 2 samples", accepted)
    try:
        table = np.array(rows[1:], dtype=float)
    except ValueError as error:
        raise LogError(f"{path}: not a table of numbers ({error}); accepted: {accepted}") from error
    if table.shape[1] != len(header) or not np.isfinite(table).all():
        refuse(path, "a value is not a finite number, or rows differ in length", accepted)
    t, joints, out = table[:, header.index("t")], counts[needed[0]], {}
    if np.diff(t).min() <= 0:
        refuse(path, "time does not increase", accepted)
    for role in (role for role in (*needed, *optional) if role in counts):
        names = [f"{role}{j}" for j in range(1, joints + 1)]
        if counts[role] != joints or not set(names) <= set(header):
            refuse(path, f"the columns of {role} are not numbered 1 to {joints}", accepted)
        out[role] = np.ascontiguousarray(table[:, [header.index(name) for name in names]])
    return t, out
