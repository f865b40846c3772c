"""Logs as a data set: many files, or long ones, of which a part is in memory at a time.

A source is a path, a pattern (`logs/*.parquet`), a folder, or a URL of fsspec. Parquet is read row
group by row group, once in every pass; CSV and NPZ are read whole, file by file.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from symgen.data.bags import is_bag
from symgen.data.holes import holes
from symgen.data.log import READERS, Log, checked
from symgen.data.raw import BESIDE, ROLES, Raw, Reading, one_line, refuse
from symgen.data.stored import StoredArray, stored_arrays
from symgen.data.stretch import Stretch, within
from symgen.data.tables import COLUMNS, assigned
from symgen.errors import LogError, plain

if TYPE_CHECKING:
    from symgen.robot.types import Robot

FloatArray = NDArray[np.float64]
_SUFFIXES = (".parquet", ".csv", ".npz")
_ACCEPTED = "Parquet, CSV or NPZ files, a folder of them, a pattern such as 'logs/*.parquet', a URL"
_BATCH = 1 << 15  # rows that are decoded at once
_BUFFER = 1 << 20  # bytes of a column that are read at once


def is_remote(source: str) -> bool:
    """Whether a source is a URL."""
    return "://" in source


def is_data_set(source: object) -> bool:
    """Whether a source names a data set: a pattern, a folder that is no bag, or a URL."""
    if not isinstance(source, (str, Path)):
        return False
    name = str(source)
    if is_remote(name):
        return True
    path = Path(name)
    if path.is_dir():
        return not is_bag(path)
    return glob.has_magic(name) and not path.exists()


def listed_files(sources: Sequence[str | Path]) -> list[str]:
    """Return the files of a data set, in the order of the sources, each source sorted.

    Raises:
        LogError: a source has no file, or one of another kind.
    """
    out: list[str] = []
    for source in sources:
        found = _remote(str(source)) if is_remote(str(source)) else _local(str(source))
        known = [name for name in found if name.lower().endswith(_SUFFIXES)]
        if not known:
            refuse(str(source), "no file of a log is there", _ACCEPTED)
        out += sorted(known)
    twice = sorted({name for name in out if out.count(name) > 1})
    if twice:
        refuse(twice[0], "is given twice", "each file once")
    return out


def _local(source: str) -> list[str]:
    path = Path(source)
    if path.is_dir():
        return [str(p) for p in path.rglob("*") if p.is_file()]
    return glob.glob(source, recursive=True) if not path.exists() else [source]


def _remote(source: str) -> list[str]:
    system, path = _file_system(source)
    try:
        if glob.has_magic(path):
            found = system.glob(path)
        else:
            found = system.find(path) if system.isdir(path) else [path]
    except (OSError, ValueError) as error:
        raise LogError(one_line(f"{source}: cannot be listed: {error}")) from error
    return [str(system.unstrip_protocol(name)) for name in found]


def _file_system(url: str) -> tuple[Any, str]:
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise LogError(f"{url}: URLs need fsspec: pip install symgen[dask]") from error
    try:
        system, path = url_to_fs(url)
    except (ImportError, ValueError) as error:
        raise LogError(one_line(f"{url}: {error}")) from error
    return system, str(path)


def opened(name: str) -> BinaryIO:
    """Open a file of a data set.

    Raises:
        LogError: it cannot be opened.
    """
    try:
        if is_remote(name):
            system, path = _file_system(name)
            return cast(BinaryIO, system.open(path, "rb"))
        return Path(name).open("rb")
    except OSError as error:
        raise LogError(one_line(f"{name}: cannot be read: {error}")) from error


def identity(name: str) -> str:
    """Return what tells that a file is the one of an earlier run: size and time of change."""
    if is_remote(name):
        system, path = _file_system(name)
        try:
            about = system.info(path)
        except OSError as error:
            raise LogError(one_line(f"{name}: cannot be read: {error}")) from error
        keys = ("size", "mtime", "created", "etag", "ETag", "LastModified")
        return " ".join(f"{key}={about[key]}" for key in keys if about.get(key) is not None)
    about = os.stat(name)
    return f"size={about.st_size} mtime={about.st_mtime_ns}"


def constant_column(name: str, column: str) -> str:
    """Return the one value of a column of a Parquet file.

    Raises:
        LogError: there is no such column, or it has several values.
    """
    if not name.lower().endswith(".parquet"):
        refuse(name, f"--by {column}: is no Parquet file", "Parquet with that column")
    with opened(name) as file, _parquet(name, file) as table:
        if column not in table.schema_arrow.names:
            refuse(
                name, f"there is no column {column!r} (--by)", ", ".join(table.schema_arrow.names)
            )
        values: set[str] = set()
        for batch in table.iter_batches(_BATCH, columns=[column], use_threads=False):
            values |= {str(v) for v in batch.column(0).unique().to_pylist()}
    if len(values) != 1:
        refuse(name, f"column {column} has {len(values)} values", "one robot a file")
    return values.pop()


@dataclass(frozen=True)
class DataSet:
    """Where logs lie, and how they are read.

    Attributes:
        robot: whose columns they have.
        reading: names of columns; times and masks.
    """

    robot: Robot
    reading: Reading = field(default_factory=Reading)

    def stretches(self, name: str) -> list[Stretch]:
        """Return the stretches of a file, by its column of time alone.

        Raises:
            LogError: it cannot be read, or time decreases.
        """
        edges: list[int] = []  # first rows of stretches
        times: list[tuple[float, float]] = []  # of their first and last rows
        row, median, last = 0, 0.0, -np.inf
        low, high = self.reading.start, self.reading.until
        for t in self._times(name):
            steps = np.diff(t, prepend=last)
            if not np.isfinite(t).all() or (steps <= 0).any():
                k = int(np.argmax(~(np.isfinite(t) & (steps > 0))))
                what = f"column t, sample {row + k}: {t[k]:.9g} s"
                refuse(name, what, "finite, strictly increasing time in s")
            if median == 0.0 and len(t) > 1:
                median = float(np.median(steps[1:]))
            before = np.concatenate([[last], t]) if np.isfinite(last) else t
            cuts = holes(before, median or np.inf) + 1 - (len(before) - len(t))
            for begin, end in zip([0, *cuts], [*cuts, len(t)], strict=True):
                if begin == end:
                    continue
                if begin in cuts or not edges:
                    edges.append(row + int(begin))
                    times.append((float(t[begin]), float(t[end - 1])))
                else:
                    times[-1] = (times[-1][0], float(t[end - 1]))
            row, last = row + len(t), float(t[-1])
        out = []
        measured = self.measures_speed(name)
        for k, (first, span) in enumerate(zip(edges, times, strict=True)):
            count = (edges[k + 1] if k + 1 < len(edges) else row) - first
            step = (span[1] - span[0]) / (count - 1) if count > 1 else median
            log = plain(name.rsplit("/", 1)[-1])
            log = log if len(edges) == 1 else f"{log}, stretch {k + 1}"
            out.append(Stretch(name, log, (first, first + count), span, step, measured))
        if low is not None or high is not None:
            out = [s for s in (within(s, low, high) for s in out) if s.count > 0]
        return out

    def _times(self, name: str) -> Iterator[FloatArray]:
        """Yield the column of time, piece by piece."""
        stored = self._stored(name)
        if stored is not None:
            t = stored["t"]
            for first in range(0, t.shape[0], _BATCH):
                part = t.rows(Path(name), first, min(first + _BATCH, t.shape[0]))
                yield np.asarray(part, dtype=np.float64)
            return
        if not name.lower().endswith(".parquet"):
            yield np.asarray(self._whole(name).t, dtype=np.float64)
            return
        with opened(name) as file, _parquet(name, file) as table:
            names, _, _ = self._columns(name, table)
            stored = table.schema_arrow.names[names.index("t")]
            for batch in table.iter_batches(_BATCH, columns=[stored], use_threads=False):
                if batch.num_rows:
                    yield _numbers(batch.column(0)).astype(np.float64)

    def measures_speed(self, name: str) -> bool:
        """Whether a file has speeds."""
        stored = self._stored(name)
        if stored is not None:
            return "qd" in stored
        if not name.lower().endswith(".parquet"):
            return self._whole(name).qd is not None
        with opened(name) as file, _parquet(name, file) as table:
            return bool(self._columns(name, table)[1].get("qd"))

    def logs(self, name: str, spans: Sequence[tuple[int, int]], label: str) -> Iterator[Log]:
        """Yield rows of a file as logs on the joint side, each row read once.

        Args:
            name: of the file.
            spans: first row and the one behind the last of each, both increasing; they may overlap.
            label: name of the log.

        Raises:
            LogError: the file cannot be read, or the rows are refused as those of a log.
        """
        robot = self.robot
        joints = [joint.name for joint in robot.movable]
        for (first, last), raw in zip(spans, self._raw(name, spans), strict=True):
            where = f"{name}, rows {first} to {last}"
            yield checked(where, label, raw, None, robot.sigma, robot.drive, joints)

    def _raw(self, name: str, spans: Sequence[tuple[int, int]]) -> Iterator[Raw]:
        if name.lower().endswith(".parquet"):
            yield from self._streamed(name, spans)
            return
        stored = self._stored(name)
        if stored is not None:
            for first, last in spans:
                found = {role: x.rows(Path(name), first, last) for role, x in stored.items()}
                qd, tau, i = (found.get(role) for role in ("qd", "tau", "i"))
                yield Raw(found["t"], found["q"], qd, tau, i)
            return
        whole = self._whole(name)
        for first, last in spans:
            yield _rows(whole, slice(first, last))

    def _stored(self, name: str) -> Mapping[str, StoredArray] | None:
        """Return where the arrays of an NPZ lie, by role; None where it has to be read whole."""
        known = self.reading.columns
        if is_remote(name) or not name.lower().endswith(".npz") or known.keys() - set(ROLES):
            return None
        found = stored_arrays(Path(name)) or {}
        roles = ("t", "q", "qd", "tau", *(("i",) if self._currents else ()))
        own = {
            role: found[known.get(role, role)] for role in roles if known.get(role, role) in found
        }
        given = all(theirs in found for theirs in known.values())
        whole = {"t", "q"} <= own.keys() and ("tau" in own or "i" in own) and given
        alike = len({x.shape[0] for x in own.values()}) == 1
        return own if whole and alike else None

    def _whole(self, name: str) -> Raw:
        """Read a CSV or an NPZ."""
        path = Path(name)
        if is_remote(name):
            refuse(name, "is a CSV or NPZ at a URL", "Parquet at a URL, other files on a disk")
        suffix = path.suffix.lower()
        if suffix not in READERS:
            refuse(name, f"the extension {suffix!r} is not known", _ACCEPTED)
        names = [joint.name for joint in self.robot.movable]
        try:
            return READERS[suffix](path, self.reading.columns, self._currents, names, self.robot.n)
        except (OSError, ValueError) as error:
            raise LogError(one_line(f"{name}: cannot be read: {error}")) from error

    @property
    def _currents(self) -> bool:
        drive = self.robot.drive
        return drive is not None and drive.torque_constant is not None

    def _columns(
        self, name: str, table: Any
    ) -> tuple[list[str], Mapping[str, list[str]], tuple[str, ...]]:
        joints = [joint.name for joint in self.robot.movable]
        columns, n = self.reading.columns, self.robot.n
        schema = table.schema_arrow
        names, groups, notes = assigned(
            Path(name), schema.names, schema.types, columns, self._currents, joints, n
        )
        needed = {role: group for role, group in groups.items() if role not in BESIDE}
        return names, needed, notes  # no robot that reads the others is estimated chunk by chunk

    def _streamed(self, name: str, spans: Sequence[tuple[int, int]]) -> Iterator[Raw]:
        """Yield spans of a Parquet file, decoding the row groups that hold them once."""
        with opened(name) as file, _parquet(name, file) as table:
            names, groups, notes = self._columns(name, table)
            wanted = [column for group in groups.values() for column in group]
            stored = [table.schema_arrow.names[names.index(column)] for column in wanted]
            about = table.metadata
            ends = np.cumsum([about.row_group(k).num_rows for k in range(about.num_row_groups)])
            first_group = int(np.searchsorted(ends, spans[0][0], side="right"))
            last_group = int(np.searchsorted(ends, spans[-1][1] - 1, side="right"))
            row = int(ends[first_group - 1]) if first_group else 0
            batches = table.iter_batches(
                _BATCH,
                row_groups=list(range(first_group, last_group + 1)),
                columns=stored,
                use_threads=False,
            )
            held: list[tuple[int, list[NDArray[Any]]]] = []  # first row of each, and its columns
            for first, last in spans:
                held = [(start, x) for start, x in held if start + len(x[0]) > first]
                while row < last:
                    batch = next(batches, None)
                    if batch is None:
                        refuse(name, f"ends before row {last}", "a file that does not change")
                    if row + batch.num_rows > first and batch.num_rows:
                        found = {c: _numbers(batch.column(c)) for c in stored}
                        held.append((row, [found[c] for c in stored]))
                    row += batch.num_rows
                arrays, k = dict[str, FloatArray | None](), 0
                for role, group in groups.items():
                    columns = range(k, k + len(group))
                    arrays[role] = _filled(held, first, last, columns) if group else None
                    k += len(group)
                t, q = arrays["t"], arrays["q"]
                assert t is not None  # `assigned` has seen to it
                assert q is not None
                qd, tau, i = (arrays.get(role) for role in ("qd", "tau", "i"))
                yield Raw(t[:, 0], q, qd, tau, i, (), notes)


def _numbers(column: Any) -> NDArray[Any]:
    """Return a column of Arrow as an array: plain numbers where they lie."""
    try:
        return np.from_dlpack(column)
    except (AttributeError, TypeError):  # gaps, no numbers, or an Arrow that cannot
        return np.asarray(column.to_numpy(zero_copy_only=False))  # imports pandas, where it is


def _filled(
    held: Sequence[tuple[int, Sequence[NDArray[Any]]]], first: int, last: int, columns: range
) -> FloatArray:
    """Gather some columns of rows first .. last (exclusive), (N, columns), read-only.

    Each column lies in one piece, as in the file: whatever looks at a channel takes it as it is.
    """
    out = np.empty((last - first, len(columns)), order="F")
    for start, x in held:
        low, high = max(first - start, 0), min(last - start, len(x[0]))
        for j, k in enumerate(columns):
            out[start + low - first : start + high - first, j] = x[k][low:high]
    out.setflags(write=False)
    return out


def _rows(raw: Raw, span: slice) -> Raw:
    arrays: dict[str, Any] = {key: x[span] for key in ROLES if (x := getattr(raw, key)) is not None}
    return replace(raw, **arrays)


def _parquet(name: str, file: BinaryIO) -> Any:
    """Open a Parquet table for reading by pieces.

    Raises:
        LogError: it is none.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        source = file if is_remote(name) else name  # Arrow reads a path without a detour
        return pq.ParquetFile(source, pre_buffer=False, buffer_size=_BUFFER)
    except (pa.ArrowException, OSError, ValueError) as error:
        what = f"{name}: is not a readable Parquet file: {error}"
        raise LogError(one_line(f"{what}; accepted: a Parquet table of {COLUMNS}")) from error
