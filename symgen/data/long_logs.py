"""Long logs in files: the files of a source, their stretches without gaps, and reading by rows.

A source is a path, a pattern (`logs/*.parquet`), a folder, or a URL. Parquet and NPZ are read by
rows. CSV is read completely.
"""

from __future__ import annotations

import glob
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from symgen.data.bags import is_bag
from symgen.data.gaps import holes
from symgen.data.lerobot import data_set_of, log_name
from symgen.data.log import Log, checked_log, reading_of
from symgen.data.raw import Reading, readable, refuse, wanted_by
from symgen.data.tables import SUFFIXES, has_segments, open_table, rows_of
from symgen.data.units import IN_SI, Units
from symgen.data.urls import is_remote, remote_files
from symgen.errors import located, plain

if TYPE_CHECKING:
    from symgen.robot.types import Robot

#: Number of samples in all logs of a run above which they are read segment by segment, and samples
#: of a segment.
LIMIT = 1 << 18
Source = str | Path | Log
#: Note on a file whose rows cannot be read alone.
_COMPLETELY = "the file was read completely; Parquet and NPZ need less memory"
_ACCEPTED = "Parquet, CSV or NPZ files, a folder of them, a pattern such as 'logs/*.parquet', a URL"


def is_long(sources: Sequence[Source]) -> bool:
    """Return whether logs are read segment by segment: tables with many samples, or a URL.

    A single CSV is not.
    """
    names = ["" if isinstance(source, Log) else str(source) for source in sources]
    if not all(name.lower().endswith(SUFFIXES) for name in names):
        return False
    if any(map(is_remote, names)):
        return True
    parts = len(names) > 1 or all(map(has_segments, names))
    return parts and sum(map(rows_of, names)) > LIMIT


def expanded(sources: Sequence[Source]) -> list[Source]:
    """Replace patterns, folders and URLs by their files, sorted.

    Raises:
        LogError: a pattern, a folder or a URL has no log file.
    """
    out: list[Source] = []
    for source in sources:
        files = None if isinstance(source, Log) else _files(str(source))
        known = sorted(name for name in files or () if name.lower().endswith(SUFFIXES))
        if files is not None and not known:
            with located(str(source)):
                refuse("no file of a log is there", _ACCEPTED)
        out += [source] if files is None else known
    return out


def only_log(source: str | Path) -> str:
    """Return the log of a path: that inside a folder or pattern with one log.

    Raises:
        LogError: several logs are there, or none.
    """
    logs = expanded([source])
    if len(logs) > 1:
        refuse(f"has {len(logs)} logs", "one of them")
    return str(logs[0])


def _files(source: str) -> list[str] | None:
    """Return the files of a pattern, a folder or a URL; None for a single log."""
    with located(source), readable("cannot be read", _ACCEPTED):
        if is_remote(source):
            return remote_files(source)
        if os.path.isdir(source):
            inside = Path(source)
            if data_set_of(inside) == inside:  # not its tables of tasks and episodes
                inside = inside / "data"
            every = inside.rglob("*")
            return None if is_bag(Path(source)) else [str(p) for p in every if p.is_file()]
        if glob.has_magic(source) and not os.path.exists(source):
            return glob.glob(source, recursive=True)
        return None


@dataclass(frozen=True)
class Stretch:
    """Rows of a file without a gap in time: a log of the run.

    Attributes:
        file: name or URL.
        name: name of the log.
        rows: first row, and the row after the last.
        times: times of the first and the last row, s.
        step: sampling step, s.
        units: units of the columns of the file.
        kind: "train" or "validation".
    """

    file: str
    name: str
    rows: tuple[int, int]
    times: tuple[float, float]
    step: float
    units: Units = IN_SI
    kind: str = "train"

    @property
    def count(self) -> int:
        """Number of rows."""
        return self.rows[1] - self.rows[0]

    def between(self, first: int, last: int) -> Stretch:
        """Return the stretch between two rows of the file."""
        begin = self._time(first)
        end = self._time(last - 1)
        return replace(self, rows=(first, last), times=(begin, end))

    def _time(self, row: int) -> float:
        return self.times[0] + self.step * (row - self.rows[0])

    def within(self, low: float, high: float) -> Stretch:
        """Return the part between two times; one sample if no row is in between."""
        first = math.ceil(self._row(low) - 1e-6)
        last = math.floor(self._row(high) + 1e-6)
        return self.between(self.rows[0] + first, self.rows[0] + last + 1)

    def _row(self, time: float) -> float:
        """Return the place of a time, in rows after the first one."""
        begin, end = self.times
        inside = min(max(time, begin), end)
        return (inside - begin) / self.step


def stretches(name: str, robot: Robot, reading: Reading) -> list[Stretch]:
    """Return the stretches of a file without gaps in time; only the time column is read.

    Raises:
        LogError: the file cannot be read, or time decreases.
    """
    edges, times = [0], list[float]()
    row, step, last = 0, 0.0, np.zeros(0)
    with located(name):
        reading = reading_of(name, reading, robot.log)
    with located(name), open_table(name, wanted_by(robot, reading)) as table:
        for piece in table.times():
            with np.errstate(over="ignore"):  # too large numbers are refused below
                t = np.append(last, np.asarray(piece, dtype=np.float64))
            good = np.isfinite(t)
            good[1:] &= np.diff(t) > 0
            before = row - len(last)
            if not good.all():
                k = int(np.argmin(good))
                what = f"column t, sample {before + k}: {t[k]:.9g} s"
                refuse(what, "finite, strictly increasing time in s")
            times = times or [float(t[0])]
            if len(t) > 1:
                step = step or float(np.median(np.diff(t)))
            for k in holes(t, step) if len(t) > 1 else ():
                edges.append(before + int(k) + 1)
                times += t[k : k + 2].tolist()
            row += len(piece)
            last = t[-1:]
    edges.append(row)
    times += last.tolist()
    out = []
    log = plain(log_name(Path(name)))
    for k, rows in enumerate(pairwise(edges)):
        begin, end = times[2 * k], times[2 * k + 1]
        steps = max(rows[1] - rows[0] - 1, 1)
        label = log if len(edges) == 2 else f"{log}, stretch {k + 1}"
        s = Stretch(name, label, rows, (begin, end), (end - begin) / steps or step, table.units)
        out.append(s.within(*reading.span))
    return out


def read_rows(
    stretch: Stretch, rows: tuple[int, int], robot: Robot, reading: Reading, label: str = ""
) -> Log:
    """Return rows of a file as a log on the joint side.

    Args:
        stretch: a stretch of the file, checked by `stretches`.
        rows: first row and row after the last.
        robot: the robot of the log.
        reading: options of reading the file, without a span of time.
        label: name of the log; "" for that of the stretch.

    Raises:
        LogError: the file cannot be read, or its rows fail the checks of a log.
    """
    name = label or stretch.name
    wanted = wanted_by(robot, reading_of(stretch.file, reading, robot.log))
    with located(stretch.file), open_table(stretch.file, wanted, stretch.units) as table:
        raw = table.part(*rows)
        with located(f"rows {rows[0]} to {rows[1]}"):
            log = checked_log(name, raw, wanted, True)
    if rows[0] > 0 or has_segments(stretch.file):
        return log
    return replace(log, notes=(*log.notes, f"{stretch.name}: {_COMPLETELY}"))
