"""Logs as tables: CSV, Parquet on a disk or at a URL, and NPZ, alone or in a data set.

Parquet is read batch by batch, each row once; CSV whole.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.beside import spread
from symgen.data.npz import open_npz, rows_of_npz
from symgen.data.raw import (
    BATCH,
    BESIDE,
    COLUMNS,
    NUMBERED,
    ROLES,
    FloatArray,
    Raw,
    Table,
    Wanted,
    listed,
    one_line,
    refuse,
    refuse_currents,
    require_size,
)
from symgen.data.recorders import matched
from symgen.data.urls import is_remote, opened
from symgen.errors import LogError, SymgenError

_LOOKED_AT = 1000  # columns that are searched for a bad cell
_PATTERN = {"t": "t=NAME", "q1": "q=*_NAME", "tau1": "tau=*_NAME"}
_BUFFER = 1 << 20  # bytes of a column that are read at once
#: Ends of names of tables.
SUFFIXES = (".csv", ".parquet", ".npz")


@contextmanager
def open_table(name: str, wanted: Wanted, sound: bool = False) -> Iterator[Table]:
    """Open a table of a log.

    Args:
        name: of the file, one of SUFFIXES; or the URL of a Parquet file.
        wanted: what is read of it.
        sound: whether checksums were found right before.

    Raises:
        LogError: it cannot be read, or is no log.
    """
    path, suffix = Path(name), name[name.rfind(".") :].lower()
    try:
        if suffix == ".parquet":
            with parquet_file(name) as file:
                yield _parquet(name, file, wanted)
            return
        if is_remote(name):
            refuse(name, "is a CSV or NPZ at a URL", "Parquet at a URL, other files on a disk")
        if path.stat().st_size == 0:
            refuse(path, "the file is empty", COLUMNS)
        yield open_npz(path, wanted, sound) if suffix == ".npz" else _csv(path, wanted)
    except (OSError, ValueError, csv.Error) as error:
        why = f"{name}: cannot be read: {error}; accepted: a CSV, Parquet or NPZ file"
        raise LogError(one_line(why)) from error


def whole(table: Table) -> Raw:
    """Read all rows of a table, as arrays in rows."""
    (raw,) = table.spans([(0, table.rows)])
    held = {role: x for role in ROLES if (x := getattr(raw, role)) is not None}
    arrays: dict[str, Any] = {role: np.ascontiguousarray(x) for role, x in held.items()}
    return replace(raw, **arrays)


@dataclass(frozen=True)
class ColumnTable:
    """A table with a column for each joint that is open.

    Attributes:
        name: of the file, or its URL.
        ends: the row behind the last of each group of rows that is decoded at once.
        groups: our columns by role.
        stored: names in the file, by ours.
        notes: which columns were matched by themselves.
        batches: yields some columns of some groups of rows, as record batches of Arrow.
    """

    name: str
    ends: NDArray[np.int64]
    groups: Mapping[str, list[str]]
    stored: Mapping[str, str]
    notes: tuple[str, ...]
    batches: Callable[[Sequence[str], Sequence[int]], Iterator[Any]]

    @property
    def rows(self) -> int:
        """The number of its rows."""
        return int(self.ends[-1]) if len(self.ends) else 0

    @property
    def measured(self) -> bool:
        """Whether it has speeds."""
        return bool(self.groups["qd"])

    def times(self) -> Iterator[NDArray[Any]]:
        """Yield the column of time, batch by batch."""
        for batch in self.batches([self.stored["t"]], range(len(self.ends))):
            yield _numbers(batch.column(0))

    def spans(self, spans: Sequence[tuple[int, int]]) -> Iterator[Raw]:
        """Yield rows, decoding the groups of rows that hold them once."""
        used = {column: None for group in self.groups.values() for column in group}
        ignored = tuple(name for name in self.stored if name not in used)
        first_group, last_group = np.searchsorted(
            self.ends, [spans[0][0], spans[-1][1] - 1], side="right"
        )
        row = int(self.ends[first_group - 1]) if first_group else 0
        chosen = range(first_group, min(last_group + 1, len(self.ends)))
        found = self.batches([self.stored[column] for column in used], chosen)
        held: list[tuple[int, list[NDArray[Any]]]] = []  # first row of each, and its columns
        for first, last in spans:
            held = [(start, x) for start, x in held if start + len(x[0]) > first]
            while row < last:
                batch = next(found, None)
                if batch is None:
                    refuse(self.name, f"ends before row {last}", "a file that does not change")
                if row + batch.num_rows > first:
                    held.append((row, [_numbers(column) for column in batch.columns]))
                row += batch.num_rows
            arrays, k = dict[str, FloatArray | None](), 0
            for role, group in self.groups.items():
                arrays[role] = _filled(held, first, last, range(k, k + len(group)))
                k += len(group)
            q, t = arrays.pop("q"), arrays.pop("t")
            assert q is not None  # `_assigned` has seen to it
            for role in BESIDE:
                arrays[role] = spread(arrays.get(role), self.groups.get(role, ()), q.shape[1])
            time = np.arange(first, last) if t is None else t[:, 0]
            yield Raw(time, q, **arrays, ignored=ignored, notes=self.notes)


def _numbers(column: Any) -> NDArray[Any]:
    """Return a column of Arrow as an array: plain numbers where they lie."""
    if column.null_count == 0:
        with suppress(AttributeError, TypeError):  # no numbers, or an Arrow that cannot
            return np.from_dlpack(column)
    return np.asarray(column.to_numpy(zero_copy_only=False))  # imports pandas, where it is


def _filled(
    held: Sequence[tuple[int, Sequence[NDArray[Any]]]], first: int, last: int, columns: range
) -> FloatArray | None:
    """Gather some columns of rows first .. last (exclusive), (N, columns), read-only.

    Each column lies in one piece, as in the file: whatever looks at a channel takes it as it is.
    """
    if not columns:
        return None
    out = np.empty((last - first, len(columns)), order="F")
    for start, x in held:
        low, high = max(first - start, 0), min(last - start, len(x[0]))
        for j, k in enumerate(columns):
            out[start + low - first : start + high - first, j] = x[k][low:high]
    out.setflags(write=False)
    return out


def _csv(path: Path, wanted: Wanted) -> ColumnTable:
    """Read a CSV with a header.

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
    names, groups, notes = _assigned(path, header, wanted)
    used = [name for group in groups.values() for name in group]
    try:
        table = pacsv.read_csv(
            path,
            read_options=pacsv.ReadOptions(column_names=names, skip_rows=skip),
            convert_options=pacsv.ConvertOptions(
                include_columns=used, column_types=dict.fromkeys(used, pa.float64())
            ),
        )
    except (pa.ArrowInvalid, pa.ArrowKeyError) as error:
        what = _bad_cell(path, names, used) or str(error)
        accepted = "at least 10 rows of numbers, separated by commas"
        raise LogError(one_line(f"{path}: {what}; accepted: {accepted}")) from error
    return ColumnTable(
        str(path), np.array([table.num_rows]), groups, {name: name for name in names}, notes,
        lambda columns, _: iter(table.select(columns).to_batches()),
    )  # fmt: skip


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


def _parquet(name: str, file: Any, wanted: Wanted) -> ColumnTable:
    """Return a Parquet file, which is open, as a log.

    Raises:
        LogError: it is not a table with the columns of a log.
    """
    import pyarrow as pa

    schema, about = file.schema_arrow, file.metadata
    names, groups, notes = _assigned(Path(name), schema.names, wanted)
    used = [column for group in groups.values() for column in group]
    for column in used:
        kind = schema.types[names.index(column)]
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
            refuse(name, f"column {column} holds {kind}", "floats or integers")
    if not is_remote(name):
        require_size(Path(name), 8 * about.num_rows * len(used))
    sizes = [about.row_group(k).num_rows for k in range(about.num_row_groups)]
    return ColumnTable(
        name, np.cumsum(sizes, dtype=np.int64), groups,
        dict(zip(names, schema.names, strict=True)), notes,
        lambda columns, chosen: batches(name, file, columns, chosen),
    )  # fmt: skip


@contextmanager
def parquet_file(name: str) -> Iterator[Any]:
    """Open a Parquet file, on a disk or at a URL.

    Raises:
        LogError: it is none.
    """
    import pyarrow.parquet as pq

    with opened(name) as remote:
        with arrow_reads(name):  # Arrow reads a path without a detour
            source = name if remote is None else remote
            file = pq.ParquetFile(source, pre_buffer=False, buffer_size=_BUFFER)
        with file:
            yield file


def batches(
    name: str, file: Any, columns: Sequence[str], groups: Sequence[int] | None = None
) -> Iterator[Any]:
    """Yield some columns of a Parquet file, some thousand rows at a time.

    Raises:
        LogError: it cannot be decoded.
    """
    chosen = None if groups is None else list(groups)
    with arrow_reads(name):
        found = file.iter_batches(
            BATCH, row_groups=chosen, columns=list(columns), use_threads=False
        )
    while True:
        with arrow_reads(name):
            batch = next(found, None)
        if batch is None:
            return
        if batch.num_rows:
            yield batch


def rows_of_parquet(path: Path) -> int:
    """Return the rows of a Parquet file; 0 where it cannot be read."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return int(pq.read_metadata(path).num_rows)
    except (pa.ArrowException, OSError, ValueError):
        return 0


@contextmanager
def arrow_reads(name: str) -> Iterator[None]:
    """Refuse a file that Arrow cannot read, or that its server does not give."""
    try:
        yield
    except SymgenError:
        raise
    except Exception as error:  # those of Arrow, and of whatever reads the URL
        what = f"{name}: is not a readable Parquet file: {error}"
        raise LogError(one_line(f"{what}; accepted: a Parquet table of {COLUMNS}")) from error


#: Tables that tell their rows without being read, 0 where they do not: whoever reads says why.
COUNTED = {".parquet": rows_of_parquet, ".npz": rows_of_npz}


def _assigned(
    path: Path, stored: Sequence[str], wanted: Wanted
) -> tuple[list[str], dict[str, list[str]], tuple[str, ...]]:
    """Return what the columns of a table are.

    One that another takes the name of is lost.

    Returns:
        Our names in the order of `stored`, those of every role, and which were matched by
        themselves.

    Raises:
        LogError: a column is missing, or is not the only one.
    """
    names, columns = [name.strip() for name in stored], wanted.columns
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
    found, notes = matched(path, given, patterns, wanted)
    return found, _groups(path, found, wanted), notes


def _groups(path: Path, names: list[str], wanted: Wanted) -> dict[str, list[str]]:
    """Sort the names of columns into {"t": [t], "q": [q1, ..], "qd": [..], ..}, by number."""
    currents, poses = wanted.currents, wanted.poses
    named = [name for name in names if name]
    name, count = Counter(named).most_common(1)[0] if named else ("", 0)
    if count > 1:
        refuse(path, f"the column {name} occurs {count} times", "each column once")
    numbered = [match for name in named if (match := NUMBERED.fullmatch(name))]
    numbers = {
        role: sorted(int(match[2]) for match in numbered if match[1] == role)
        for role in ("q", "qd", "tau", "i", *(BESIDE if wanted.beside else ()))
    }
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
    for role, have in numbers.items():
        if role in BESIDE:  # some joints have it
            have = [number for number in have if 1 <= number <= len(numbers["q"])]
        elif have != list(range(1, len(have) + 1)):
            gap = ", ".join(f"{role}{number}" for number in have)
            refuse(path, f"the columns {gap} are not numbered 1, 2, .. without gaps", COLUMNS)
        groups[role] = [f"{role}{number}" for number in have]
    return groups
