"""Logs as Parquet, on a disk or at a URL: read batch by batch, each row once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.beside import spread
from symgen.data.raw import BATCH, BESIDE, COLUMNS, FloatArray, Raw, one_line, refuse, require_size
from symgen.data.tables import assigned
from symgen.data.urls import is_remote, opened
from symgen.errors import LogError, SymgenError

_BUFFER = 1 << 20  # bytes of a column that are read at once


@dataclass(frozen=True)
class ParquetTable:
    """A Parquet file that is open, as a log.

    Attributes:
        name: of the file, or its URL.
        file: of pyarrow.
        groups: our columns by role, as `assigned` returns them.
        stored: names in the file, by ours.
        ignored: the other columns.
        notes: which columns were matched by themselves.
    """

    name: str
    file: Any
    groups: Mapping[str, list[str]]
    stored: Mapping[str, str]
    ignored: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def rows(self) -> int:
        """The number of its rows."""
        return int(self.file.metadata.num_rows)

    @property
    def measured(self) -> bool:
        """Whether it has speeds."""
        return bool(self.groups["qd"])

    def times(self) -> Iterator[NDArray[Any]]:
        """Yield the column of time, batch by batch."""
        for batch in batches(self.name, self.file, [self.stored["t"]]):
            yield _numbers(batch.column(0))

    def spans(self, spans: Sequence[tuple[int, int]]) -> Iterator[Raw]:
        """Yield rows, decoding the row groups that hold them once."""
        groups = self.groups
        stored = [self.stored[column] for group in groups.values() for column in group]
        about = self.file.metadata
        ends = np.cumsum([about.row_group(k).num_rows for k in range(about.num_row_groups)])
        first_group = int(np.searchsorted(ends, spans[0][0], side="right"))
        last_group = int(np.searchsorted(ends, spans[-1][1] - 1, side="right"))
        row = int(ends[first_group - 1]) if first_group else 0
        chosen = range(first_group, min(last_group + 1, len(ends)))
        found = batches(self.name, self.file, stored, chosen)
        held: list[tuple[int, list[NDArray[Any]]]] = []  # first row of each, and its columns
        for first, last in spans:
            held = [(start, x) for start, x in held if start + len(x[0]) > first]
            while row < last:
                batch = next(found, None)
                if batch is None:
                    refuse(self.name, f"ends before row {last}", "a file that does not change")
                if row + batch.num_rows > first:
                    held.append((row, [_numbers(batch.column(column)) for column in stored]))
                row += batch.num_rows
            arrays, k = dict[str, FloatArray | None](), 0
            for role, group in groups.items():
                arrays[role] = _filled(held, first, last, range(k, k + len(group)))
                k += len(group)
            q, t = arrays.pop("q"), arrays.pop("t")
            assert q is not None  # `assigned` has seen to it
            for role in BESIDE:
                arrays[role] = spread(arrays.get(role), groups.get(role, ()), q.shape[1])
            time = np.arange(first, last) if t is None else t[:, 0]
            yield Raw(time, q, **arrays, ignored=self.ignored, notes=self.notes)


@contextmanager
def open_parquet(
    name: str,
    columns: Mapping[str, str],
    currents: bool,
    joints: Sequence[str] = (),
    n: int | None = None,
    poses: bool = False,
    beside: bool = True,
) -> Iterator[ParquetTable]:
    """Open a Parquet file as a log.

    Args:
        name: of the file, or its URL.
        columns, currents, joints, n, poses: as for `read_csv`.
        beside: whether temperatures and positions of links are read, too.

    Raises:
        LogError: the file is not a table with the columns of a log.
    """
    with parquet_file(name) as file:
        schema = file.schema_arrow
        names, groups, notes = assigned(
            Path(name), schema.names, schema.types, columns, currents, joints, n, poses
        )
        if not beside:
            groups = {role: group for role, group in groups.items() if role not in BESIDE}
        used = {name for group in groups.values() for name in group}
        stored = dict(zip(names, schema.names, strict=True))
        if not is_remote(name):
            require_size(Path(name), 8 * file.metadata.num_rows * len(used))
        ignored = tuple(name for name in names if name not in used)
        yield ParquetTable(name, file, groups, stored, ignored, notes)


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
