"""Read logs as tables: CSV, NPZ, and Parquet on disk or at a URL.

Parquet is read in batches, each row once. Rows of NPZ are read alone, CSV completely.
"""

from __future__ import annotations

import csv
import mmap
import re
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from symgen.data.columns import Groups, assigned, require_wrenches, with_joints
from symgen.data.csv_text import csv_form, read_csv
from symgen.data.lerobot import (
    CLOCK,
    FRAMES,
    PAUSE,
    STATE,
    data_set_of,
    in_data_set,
    log_name,
)
from symgen.data.raw import (
    BESIDE,
    COLUMNS,
    DRIVING,
    KEYS,
    ROLES,
    FloatArray,
    Places,
    Raw,
    Reading,
    Wanted,
    listed,
    readable,
    refuse,
    require_shapes,
    require_size,
    shown,
    unused_torques,
)
from symgen.data.units import IN_SI, Units, paired, rest_of, units_of
from symgen.data.urls import is_remote, open_remote
from symgen.errors import SymgenError, located

BATCH = 1 << 15  # rows to read at once
_SHOWN = 1 << 14  # rows that show the rate of a file
_BUFFER = 1 << 20  # bytes to read at once
#: File endings of tables.
SUFFIXES = (".csv", ".parquet", ".npz")
#: Endings of single files only, not of logs in a folder.
TEXTS = (".tsv", ".txt")


@contextmanager
def open_table(name: str, wanted: Wanted, units: Units | None = None) -> Iterator[Table]:
    """Open a table of a log.

    Args:
        name: name of a file with an ending in SUFFIXES, or URL of a Parquet file.
        wanted: what to read.
        units: its units; None to determine them.

    Raises:
        LogError: it cannot be read, is not a log, or has an unknown unit.
    """
    path = Path(name)
    suffix = path.suffix.lower()
    try:
        if suffix == ".parquet":
            with parquet_file(name) as file:
                yield _in_si(_parquet(name, file, wanted), wanted, units)
            return
        if is_remote(name):
            refuse("is a CSV or NPZ at a URL", "Parquet at a URL, other files on a disk")
        if path.stat().st_size == 0:
            refuse("the file is empty", COLUMNS)
        table = _npz(path, wanted) if suffix == ".npz" else _csv(path, wanted)
        yield _in_si(table, wanted, units)
    except (OSError, ValueError, csv.Error) as error:
        refuse(f"cannot be read: {error}", "a CSV, Parquet or NPZ file")


def _in_si(table: Table, wanted: Wanted, units: Units | None) -> Table:
    """Return a table that converts its columns."""
    if units is None and table.rows:
        first = table.part(0, min(table.rows, _SHOWN))
        units = units_of(first, wanted)
    return replace(table, units=units or IN_SI)


def names_of(name: str, reading: Reading) -> Sequence[str]:
    """Return the columns of a table, or the arrays of an NPZ; () if it cannot be read."""
    suffix = Path(name).suffix.lower()
    with suppress(SymgenError, OSError, ValueError, zipfile.BadZipFile, csv.Error):
        if suffix == ".npz":
            return [key.removesuffix(".npy") for key in zipfile.ZipFile(name).namelist()]
        if suffix != ".parquet":
            return csv_form(Path(name), reading).header
        with parquet_file(name) as file:
            return [*_elements(file)]
    return ()


@dataclass(frozen=True)
class Table:
    """An open table with one column for each joint.

    Attributes:
        ends: row after the last one of each group of rows that is decoded at once.
        groups: role -> joint (from 0) -> place of its column.
        header: names of the columns of the file.
        notes: columns that were matched automatically.
        batches: yields columns, by their places, of groups of rows as arrays of Arrow or NumPy.
        units: units of its columns.
    """

    ends: Places
    groups: Groups
    header: Sequence[str]
    notes: tuple[str, ...]
    batches: Callable[[Sequence[int], Sequence[int]], Iterator[list[Any]]]
    units: Units = IN_SI

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.ends[-1]) if len(self.ends) else 0

    def times(self) -> Iterator[NDArray[Any]]:
        """Yield the time column in batches."""
        for (column,) in self.batches([self.groups["t"][0]], range(len(self.ends))):
            yield self.units.seconds(_numbers(column))

    def part(self, first: int, last: int) -> Raw:
        """Return the rows from `first` to before `last` as C-contiguous arrays."""
        columns = _columns(self.groups)
        groups = np.searchsorted(self.ends, [first, last - 1], side="right")
        begin, end = groups[0], min(groups[1] + 1, len(self.ends))
        chosen = range(begin, end)
        row = int(self.ends[begin - 1]) if begin else 0
        widths = {
            role: len(self.groups["q"]) if role in BESIDE else max(group) + 1
            for role, group in self.groups.items()
        }
        arrays = {role: np.full((last - first, width), np.nan) for role, width in widths.items()}
        stamps: list[NDArray[Any]] = []  # may be integers beyond those of a double
        for batch in self.batches([*columns], chosen):
            skipped, until = max(first - row, 0), max(last - row, 0)
            values = {k: _numbers(c)[skipped:until] for k, c in zip(columns, batch, strict=True)}
            stamps.append(values[self.groups["t"][0]])
            begin = max(row - first, 0)
            rows = slice(begin, begin + len(stamps[-1]))
            for role, group in self.groups.items():
                for j, k in group.items():
                    arrays[role][rows, j] = values[k]
            row += len(batch[0])
            if row >= last:
                break
        if row < last:
            refuse(f"ends before row {last}", "a file that does not change")
        arrays["t"] = np.concatenate(stamps or [np.zeros(0)])
        header = dict(enumerate(self.header))
        names = {column: header.pop(k) for k, column in columns.items()}
        ignored = tuple(header.values())
        return self.units.of(Raw(arrays, ignored, self.notes, names))


def _columns(groups: Groups) -> dict[int, str]:
    """Return place -> log column of all columns with a role."""
    return {
        k: "t" if role == "t" else f"{role}{j + 1}"
        for role, group in groups.items()
        for j, k in group.items()
    }


def _numbers(column: Any) -> NDArray[Any]:
    """Return a column as an array, without a copy if possible."""
    import pyarrow as pa

    if isinstance(column, np.ndarray):
        return column

    if column.null_count == 0 and not pa.types.is_temporal(column.type):
        with suppress(AttributeError, TypeError):  # not numeric, or an older Arrow
            return np.from_dlpack(column)
    return np.asarray(column.to_numpy(zero_copy_only=False))  # imports pandas if installed


def _csv(path: Path, wanted: Wanted) -> Table:
    """Read a CSV.

    Raises:
        LogError: the file is not a table of numbers with the columns of a log.
    """
    form = csv_form(path, wanted.reading)
    chosen_time = wanted.reading.pairs.get("t", "")
    header = paired(with_joints(path, form, wanted), chosen_time)
    groups, notes = assigned(header, path.name, wanted)
    used = _columns(groups)
    time = header[groups["t"][0]]
    rest = "" if time in form.header else rest_of(time)
    table = read_csv(path, form, {str(k): name for k, name in used.items()}, rest)
    about = list(form.notes)
    if (form.separator, form.decimal) != (",", "."):
        about.append(form.shown)
    lines = (f"{path.name}: {note}" for note in about)
    full = [f"{name}{unit}" for name, unit in zip(header, form.units, strict=True)]
    # Places as names: names of the file may occur twice.
    return Table(
        np.array([table.num_rows]), groups, full, (*lines, *notes),
        lambda columns, _: (x.columns for x in table.select([*map(str, columns)]).to_batches()),
    )  # fmt: skip


def _parquet(name: str, file: Any, wanted: Wanted) -> Table:
    """Return an open Parquet file as a table.

    Raises:
        LogError: it lacks columns of a log.
    """
    import pyarrow as pa

    schema, about = file.schema_arrow, file.metadata
    empty = pa.RecordBatch.from_pylist([], schema)
    elements = _elements(file)
    data_set = None if is_remote(name) else data_set_of(Path(name))
    if data_set is not None and elements.keys() >= {f"{STATE}[0]", *FRAMES}:
        wanted, rate = in_data_set(data_set, elements, wanted)
        elements[CLOCK] = _Element(FRAMES, partial(_times, rate=rate))
    header, sources = [*elements], [*elements.values()]
    groups, notes = assigned(header, log_name(Path(name)), wanted)
    used = _columns(groups)
    for k, column in used.items():
        kind = sources[k].of(empty).type
        numeric = pa.types.is_integer(kind) or pa.types.is_floating(kind)
        stamps = pa.types.is_timestamp(kind) or pa.types.is_duration(kind)
        if not (numeric or (column == "t" and stamps)):
            what = f"column {shown(column, {column: header[k]})} holds {kind}"
            refuse(what, "floats or integers")
    if not is_remote(name):
        require_size(Path(name), 8 * about.num_rows * len(used))
    sizes = [about.row_group(k).num_rows for k in range(about.num_row_groups)]
    return Table(
        np.cumsum(sizes, dtype=np.int64), groups, header, notes,
        lambda columns, chosen: _picked(file, [sources[k] for k in columns], chosen),
    )  # fmt: skip


@dataclass(frozen=True)
class _Element:
    """A column that a Parquet file has or gives: the columns it needs, and its values from them."""

    columns: tuple[str, ...]
    of: Callable[[Any], Any]


def _elements(file: Any) -> dict[str, _Element]:
    """Return the columns of a Parquet file, each element of a list as its own: "state[0]".

    A list has as many elements as in the first row.
    """
    schema = file.schema_arrow
    lists = [field.name for field in schema if hasattr(field.type, "value_type")]
    rows = next(batches(file, lists), None) if lists else None
    out: dict[str, _Element] = {}
    for name in schema.names:
        cell = rows[name][0].as_py() if rows and name in lists else None
        if cell and isinstance(cell, list):
            for k in range(len(cell)):
                of = partial(_element, name=name, k=k)
                out[f"{name}[{k}]"] = _Element((name,), of)
        else:
            out[name] = _Element((name,), itemgetter(name))
    return out


def _element(batch: Any, name: str, k: int) -> Any:
    """Return an element of the lists in a column."""
    import pyarrow.compute as pc

    return pc.list_element(batch[name], k)


def _times(batch: Any, rate: float) -> Any:
    """Return the times of rows by their frames, s, with a pause before each episode."""
    import pyarrow as pa

    frame, episode = (batch[name].to_numpy() for name in FRAMES)
    return pa.array(frame / rate + PAUSE * episode)


def _picked(file: Any, elements: Sequence[_Element], groups: Sequence[int]) -> Iterator[list[Any]]:
    """Yield columns, or elements of columns with lists, in batches."""
    needed = {name for element in elements for name in element.columns}
    for batch in batches(file, sorted(needed), groups):
        yield [element.of(batch) for element in elements]


@contextmanager
def parquet_file(name: str) -> Iterator[Any]:
    """Open a Parquet file on disk or at a URL.

    Raises:
        LogError: it is not a Parquet file.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    source = open_remote(name) if is_remote(name) else name
    with arrow_reads():
        file = pq.ParquetFile(source, pre_buffer=False, buffer_size=_BUFFER)
    try:
        yield file
    finally:
        file.close(force=True)
        pa.default_memory_pool().release_unused()


def batches(
    file: Any, columns: Sequence[str], groups: Sequence[int] | None = None
) -> Iterator[Any]:
    """Yield columns of a Parquet file in batches of some thousand rows.

    Raises:
        LogError: it cannot be decoded.
    """
    chosen = None if groups is None else list(groups)
    with arrow_reads():
        found = file.iter_batches(
            BATCH, row_groups=chosen, columns=list(columns), use_threads=False
        )
    while True:
        with arrow_reads():
            batch = next(found, None)
        if batch is None:
            return
        if batch.num_rows:
            yield batch


def arrow_reads() -> AbstractContextManager[None]:
    """Turn errors of Arrow or of a server into a LogError."""
    return readable("is not a readable Parquet file", f"a Parquet table of {COLUMNS}")


# Arrays of NumPy.


def _forget(x: Any) -> None:
    """Take the rows of a mapped array out of memory; the file keeps them."""
    if hasattr(mmap, "MADV_DONTNEED") and hasattr(x, "_mmap"):  # not on Windows
        x._mmap.madvise(mmap.MADV_DONTNEED)


def _npz(path: Path, wanted: Wanted) -> Table:
    """Read a file of numpy.savez.

    Args:
        path: the file.
        wanted: what to read; its columns map log arrays to arrays of the file.

    Raises:
        LogError: the file lacks the arrays of a log.
    """
    if not zipfile.is_zipfile(path):
        refuse("is not an NPZ archive", f"what numpy.savez writes, with {KEYS}")
    pairs = wanted.reading.pairs
    names = {role: pairs.get(role, role) for role in ROLES}
    framed = wanted.framed
    content = _content(path, frozenset([*names.values(), *framed]), path.stat().st_mtime_ns)
    for ours, theirs in pairs.items():
        if ours not in ROLES:
            refuse(f"--columns {ours}={theirs}: an NPZ has one array for all joints", KEYS)
        if theirs not in content:
            refuse(f"there is no array {theirs!r} (--columns {ours})", listed([*content]))
    arrays = {role: content[key] for role, key in names.items() if key in content}
    for role in unused_torques(arrays, wanted):
        del arrays[role]
    for role in ("t", "q", "tau") if wanted.n != 0 else ("t",):
        if role not in arrays and not (role == "tau" and arrays.keys() & DRIVING):
            present = listed([*content])
            refuse(f"there is no array {names[role]} among {present}", KEYS)
    t = arrays["t"]
    if len(t.shape) == 2 and 1 in t.shape:  # of MATLAB
        arrays["t"] = t.ravel()
    require_shapes(arrays)
    of_frames = {key: framed[key] for key in content if key in framed}
    used = {*of_frames, *(names[role] for role in arrays)}
    unused = [key for key in content if key not in used]
    rows = len(arrays["t"])
    for key in of_frames:
        if np.size(content[key]) != rows:
            refuse(f"{key} has the shape {content[key].shape}", f"{key} ({rows},)")
    groups: Groups = {}
    columns = list[NDArray[Any]]()
    for role, array in arrays.items():
        of_joints, first = np.atleast_2d(array.T), len(columns)
        groups[role] = {j: first + j for j in range(len(of_joints))}
        columns.extend(of_joints)
    header = [*_columns(groups).values(), *of_frames, *unused]
    for key, (role, number) in of_frames.items():
        groups.setdefault(role, {})[number - 1] = len(columns)
        columns.append(np.ravel(content[key]))
    require_wrenches(groups.get("forces", {}), wanted)

    def batches(places: Sequence[int], _: Sequence[int]) -> Iterator[list[Any]]:
        try:
            yield [columns[k] for k in places]
        finally:
            for array in content.values():
                _forget(array)

    ends = np.array([len(columns[0])])
    return Table(ends, groups, header, (), batches)


@lru_cache(maxsize=1)
def _content(path: Path, needed: frozenset[str], _changed: int) -> dict[str, Any]:
    """Return the arrays of a file of numpy.savez: those that are needed, and None for others.

    They are unpacked into temporary files, so that memory holds only rows that are used.

    Args:
        path: the file.
        needed: names of arrays.

    Raises:
        LogError: the file is damaged.
    """
    out: dict[str, Any] = {}
    try:
        with (
            tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
            zipfile.ZipFile(path) as archive,
        ):
            entries = archive.infolist()
            require_size(path, sum(entry.file_size for entry in entries))
            for entry in entries:
                key = entry.filename.removesuffix(".npy")
                out[key] = None
                if key in needed:
                    # a map never loads a pickle, which would run code of whoever wrote it
                    out[key] = np.load(archive.extract(entry, folder), mmap_mode="r")
    except SymgenError:
        raise
    except Exception as error:  # a damaged archive can raise any exception
        what = "an array holds Python objects" if "Python objects" in str(error) else str(error)
        return refuse(f"cannot be read: {what}", KEYS)
    return out


def rows_of(name: str) -> int:
    """Return the approximate number of rows of a file; 0 if only reading it would show it."""
    import pyarrow.parquet as pq

    try:
        if name.lower().endswith(".parquet"):
            return int(pq.read_metadata(name).num_rows)
        if name.lower().endswith(".npz"):
            return _rows_of_npz(name)
        with open(name, "rb") as file:
            blocks = iter(partial(file.read, _BUFFER), b"")
            return sum(block.count(b"\n") for block in blocks)
    except Exception:  # a damaged archive can raise any exception
        return 0


def _rows_of_npz(name: str) -> int:
    """Return the largest number of rows of the arrays in a file of numpy.savez."""
    most = 0
    with zipfile.ZipFile(name) as archive:
        for entry in archive.infolist():
            with archive.open(entry) as array:
                old = npy.read_magic(array) == (1, 0)
                read = npy.read_array_header_1_0 if old else npy.read_array_header_2_0
                most = max(most, *read(array)[0][:1])
    return most


def has_segments(name: str) -> bool:
    """Return whether rows of a file are read alone: of Parquet and NPZ."""
    return name.lower().endswith((".parquet", ".npz"))


# Motions, or torques, without the other columns of a log.


def read_columns(
    path: str | Path, needed: tuple[str, ...], optional: tuple[str, ...], accepted: str
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Read t (N,) and groups of numbered columns (N, n) from CSV; other columns are ignored.

    Raises:
        LogError: the file cannot be read, a column is missing, or a value is not a finite number.
    """
    with located(path), readable("cannot be read", accepted):
        form = csv_form(Path(path), Reading())
        header = {str(k): name for k, name in enumerate(form.header)}
        table = read_csv(Path(path), form, header)
        columns = {
            name: np.asarray(table.column(k), dtype=np.float64) for k, name in header.items()
        }
        out = {}
        for role in (*needed, *optional):
            numbered = re.compile(f"{role}[1-9][0-9]*")
            count = len([*filter(numbered.fullmatch, columns)])
            if count or role in needed:
                names = [f"{role}{j + 1}" for j in range(max(count, 1))]
                out[role] = np.column_stack([columns[name] for name in names])
        if len({x.shape for x in out.values()}) > 1:
            refuse(f"columns {listed(form.header)}", f"{accepted}, as many of each")
        finite = all(np.isfinite(x).all() for x in columns.values())
        if len(table) < 2 or not finite or np.diff(columns["t"]).min() <= 0:
            refuse("2 samples or more, of finite numbers and increasing time, are needed", accepted)
        return columns["t"], out
