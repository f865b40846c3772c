"""Data sets: many or long files, of which only a part is in memory at a time.

A source is a path, a pattern (`logs/*.parquet`), a folder, or a URL. `open_table` opens each file,
as it does for a single log. Parquet and uncompressed NPZ are read by rows, CSV and compressed NPZ
as a whole.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from symgen.data.bags import is_bag
from symgen.data.log import Log, checked
from symgen.data.raw import Reading, Wanted, columns_from, listed, refuse
from symgen.data.stretch import Stretch, holes, within
from symgen.data.tables import SUFFIXES, Table, arrow_reads, batches, open_table, parquet_file
from symgen.data.units import Units
from symgen.data.urls import is_remote, remote_files, remote_identity
from symgen.errors import located, plain

if TYPE_CHECKING:
    from symgen.robot.types import Robot

_ACCEPTED = "Parquet, CSV or NPZ files, a folder of them, a pattern such as 'logs/*.parquet', a URL"


def is_data_set(source: object) -> bool:
    """Whether a source is a data set: a pattern, a folder that is not a bag, or a URL."""
    if not isinstance(source, (str, os.PathLike)):
        return False
    name = str(source)
    if is_remote(name):
        return True
    if os.path.isdir(name):
        return not is_bag(Path(name))
    return glob.has_magic(name) and not os.path.exists(name)


def listed_files(sources: Sequence[str | Path]) -> list[str]:
    """Return the files of a data set in the order of the sources, sorted within each.

    Raises:
        LogError: a source has no log file, or a file occurs twice.
    """
    out: list[str] = []
    for source in sources:
        with located(source):
            found = remote_files(str(source)) if is_remote(str(source)) else _local(str(source))
            known = [name for name in found if name.lower().endswith(SUFFIXES)]
            if not known:
                refuse("no file of a log is there", _ACCEPTED)
        out += sorted(known)
    twice = sorted({name for name in out if out.count(name) > 1})
    if twice:
        refuse(f"{twice[0]}: is given twice", "each file once")
    return out


def _local(source: str) -> list[str]:
    try:
        if os.path.isdir(source):
            return [str(p) for p in Path(source).rglob("*") if p.is_file()]
        return [source] if os.path.exists(source) else glob.glob(source, recursive=True)
    except (OSError, ValueError, RecursionError) as error:  # a pattern with many "**"
        refuse(str(error), _ACCEPTED)


def identity(name: str) -> str:
    """Return size and modification time of a file, to recognize it in a later run."""
    if is_remote(name):
        with located(name):
            return remote_identity(name)
    about = os.stat(name)
    return f"size={about.st_size} mtime={about.st_mtime_ns}"


def constant_column(name: str, column: str) -> str:
    """Return the value of a Parquet column that has one value only.

    Raises:
        LogError: there is no such column, or it has several values.
    """
    with located(name):
        if not name.lower().endswith(".parquet"):
            refuse(f"--by {column}: is no Parquet file", "Parquet with that column")
        with parquet_file(name) as file:
            named = file.schema_arrow.names
            if column not in named:
                refuse(f"there is no column {column!r} (--by)", listed(named))
            values: set[str] = set()
            for batch in batches(file, [column]):
                with arrow_reads():
                    values |= {str(v) for v in batch.column(0).unique().to_pylist()}
        if len(values) != 1:
            refuse(f"column {column} has {len(values)} values", "one robot a file")
    return values.pop()


@dataclass(frozen=True)
class DataSet:
    """How to read the files of a data set.

    Attributes:
        robot: robot of the logs.
        reading: column names, span of time, and masks.
    """

    robot: Robot
    reading: Reading = field(default_factory=Reading)

    def stretches(self, name: str) -> list[Stretch]:
        """Return the stretches of a file without gaps in time; only the time column is read.

        Raises:
            LogError: the file cannot be read, or time decreases.
        """
        row, median, last = 0, 0.0, -np.inf
        begins: list[tuple[int, float, float]] = []  # first row, its time, time of the row before
        with located(name), self._open(name) as table:
            measured, units = table.measured, table.units
            for piece in table.times():
                with np.errstate(over="ignore"):  # too large numbers are refused below
                    t = np.asarray(piece, dtype=np.float64)
                steps = np.diff(t, prepend=last)
                bad = ~(np.isfinite(t) & (steps > 0))
                if bad.any():
                    k = int(np.argmax(bad))
                    what = f"column t, sample {row + k}: {t[k]:.9g} s"
                    refuse(what, "finite, strictly increasing time in s")
                if median == 0.0 and len(t) > 1:
                    median = float(np.median(steps[1:]))
                if row == 0:
                    begins = [(0, float(t[0]), last)]
                for k in holes(np.append(last, t)[row == 0 :], median or np.inf):
                    k = int(k) + (row == 0)  # the row after the gap
                    begins.append((row + k, float(t[k]), float(t[k - 1]) if k else last))
                row, last = row + len(t), float(t[-1])
        log = plain(name.rsplit("/", 1)[-1])
        out = []
        for k, ((first, begin, _), (end, _, until)) in enumerate(
            pairwise([*begins, (row, np.inf, last)])
        ):
            step = (until - begin) / (end - first - 1) if end - first > 1 else median
            label = log if len(begins) == 1 else f"{log}, stretch {k + 1}"
            out.append(Stretch(name, label, (first, end), (begin, until), step, measured, units))
        return [s for s in (within(s, *self.reading.span) for s in out) if s.count > 0]

    def logs(
        self, stretch: Stretch, spans: Sequence[tuple[int, int]], label: str = ""
    ) -> Iterator[Log]:
        """Yield rows of a file as logs on the joint side; each row is read once.

        Args:
            stretch: one of the file.
            spans: first row and row after the last of each log, increasing; they may overlap.
            label: name of the log; "" for that of the stretch.

        Raises:
            LogError: the file cannot be read, or its rows fail the checks of a log.
        """
        robot, name, label = self.robot, stretch.file, label or stretch.name
        units = replace(self.reading, start=None, until=None)
        # `stretches` has checked the file, and found its units.
        with located(name), self._open(name, True, stretch.units) as table:
            for (first, last), raw in zip(spans, table.spans(spans), strict=True):
                with located(f"rows {first} to {last}"):
                    log = checked(
                        label, raw, None, robot.sigma, robot.drive, robot.joint_names, units, True
                    )
                yield log

    def _open(
        self, name: str, sound: bool = False, units: Units | None = None
    ) -> AbstractContextManager[Table]:
        robot = self.robot
        # Robots that need temperatures or link positions are not estimated in chunks.
        wanted = Wanted(
            self.reading, robot.drive, robot.joint_names, robot.n, False, robot.sigma,
            columns_from(robot.log_columns),
        )  # fmt: skip
        return open_table(name, wanted, sound, units)
