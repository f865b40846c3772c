"""Measured logs: read from CSV, Parquet or NPZ, and checked before anything is computed.

A log that passes is safe to use without further checks: finite, increasing in time, with as many
positions as torques. One that does not is refused with one line that names the file, the column
and the sample, and says what is accepted.
"""

from __future__ import annotations

import csv
import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from symgen.errors import LogError
from symgen.names import PRISMATIC

FloatArray = npt.NDArray[np.float64]

#: Fewer samples than this determine neither a derivative nor a noise level.
MIN_SAMPLES = 10

#: A revolute joint that travels further than this, in rad, is taken to be written in degrees.
MAX_RANGE = 50.0

_DEGREES = 180.0 / np.pi
_NUMBERED = re.compile(r"(qd|q|tau|i)(0|[1-9][0-9]*)")
_COLUMNS = "t, q1.., optional qd1.., tau1.."
_KEYS = "t (N,), q (N, n), tau (N, n), optional qd (N, n)"


@dataclass(frozen=True, eq=False)
class Log:
    """One measured log, as it was recorded. All arrays are read-only, C-contiguous float64.

    Attributes:
        name: file name without its folder.
        t: (N,) time in s, strictly increasing.
        q: (N, n) joint positions in rad (m for a prismatic joint).
        qd: (N, n) measured joint velocities in rad/s (m/s), None when the log has none.
        tau: (N, n) joint torques in N m (forces in N).
        ignored: the other columns of the file, which nothing reads.
    """

    name: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray | None
    tau: FloatArray
    ignored: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class _Raw:
    """What a file held, before any check of the values."""

    t: npt.NDArray[Any]
    q: npt.NDArray[Any]
    qd: npt.NDArray[Any] | None
    tau: npt.NDArray[Any]
    ignored: tuple[str, ...] = ()


def read_log(path: str | Path, n: int | None = None, *, sigma: Sequence[int] | None = None) -> Log:
    """Read a log from a .csv, .parquet or .npz file.

    CSV and Parquet have the columns t, q1.., optional qd1.., tau1..; all others are ignored. NPZ
    has the arrays t (N,), q, tau and optional qd (N, n), of any float or integer type; (N,) will
    do for q, qd and tau of a single joint.

    Args:
        path: the file.
        n: number of movable joints of the robot, None to take what the log has.
        sigma: (n,) types of the movable joints (0 revolute, 1 prismatic); None for all revolute.

    Returns:
        The checked log.

    Raises:
        LogError: the file cannot be read, or is refused by `make_log`.
    """
    path = Path(path)
    readers = {".csv": _read_csv, ".parquet": _read_parquet, ".npz": _read_npz}
    accepted = "a .csv, .parquet or .npz file"
    try:
        if path.is_dir():
            _refuse(path, "is a folder", accepted)
        if not path.exists():
            _refuse(path, "there is no such file", accepted)
        if path.suffix.lower() not in readers:
            _refuse(path, f"the extension {path.suffix!r} is not known", accepted)
        if path.stat().st_size == 0:
            _refuse(path, "the file is empty", _COLUMNS)
        raw = readers[path.suffix.lower()](path)
    except (OSError, ValueError, csv.Error) as error:
        raise LogError(_line(f"{path}: cannot be read: {error}; accepted: {accepted}")) from error
    return _checked(str(path), path.name, raw, n, sigma)


def make_log(
    name: str,
    t: npt.ArrayLike,
    q: npt.ArrayLike,
    tau: npt.ArrayLike,
    qd: npt.ArrayLike | None = None,
    n: int | None = None,
    *,
    sigma: Sequence[int] | None = None,
) -> Log:
    """Make a log of arrays, with the same checks as a file gets. The arrays are copied.

    Args:
        name: what messages and reports call the log.
        t: (N,) time in s.
        q: (N, n) positions in rad (m); (N,) for a single joint, as for qd and tau.
        tau: (N, n) torques in N m (N).
        qd: (N, n) velocities in rad/s (m/s), or None.
        n: number of movable joints of the robot, None to take what the log has.
        sigma: (n,) types of the movable joints (0 revolute, 1 prismatic); None for all revolute.

    Raises:
        LogError: fewer than 10 samples, shapes that differ, a value that is not a finite number,
            time that does not increase, another number of joints than n, or degrees for radians.
    """
    try:
        velocity = None if qd is None else np.asarray(qd)
        raw = _Raw(np.asarray(t), np.asarray(q), velocity, np.asarray(tau))
    except ValueError as error:
        raise LogError(_line(f"{name}: {error}; accepted: {_KEYS}")) from error
    return _checked(name, name, raw, n, sigma)


def read_only(array: npt.ArrayLike) -> FloatArray:
    """Return a read-only, C-contiguous float64 copy of an array."""
    # An extended double beyond the range becomes inf, which the checks then name.
    with np.errstate(over="ignore"):
        copy = np.array(array, dtype=np.float64, order="C")
    copy.setflags(write=False)
    return copy


def _line(message: str) -> str:
    return " ".join(message.splitlines())


def _refuse(file: str | Path, what: str, accepted: str) -> NoReturn:
    raise LogError(_line(f"{file}: {what}; accepted: {accepted}"))


# --- the three formats ---------------------------------------------------------------------------


def _read_csv(path: Path) -> _Raw:
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
    names = [name.strip() for name in header]
    groups = _groups(path, names)
    wanted = ["t", *(name for group in groups.values() for name in group)]
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
        accepted = f"at least {MIN_SAMPLES} rows of numbers, separated by commas"
        raise LogError(_line(f"{path}: {what}; accepted: {accepted}")) from error
    return _from_columns(table, names, groups)


def _bad_cell(path: Path, names: list[str], wanted: list[str]) -> str | None:
    """Find the first row of a refused CSV that is too short, too long, or holds a text.

    The CSV reader works in blocks, on several threads, and cannot tell the row itself.
    """
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        rows = (row for row in csv.reader(file) if row)
        next(rows)
        sample = -1
        for sample, row in enumerate(rows):
            if len(row) != len(names):
                return f"sample {sample}: {len(row)} values for {len(names)} columns"
            for name in wanted:
                cell = row[names.index(name)].strip()
                try:
                    float(cell or "nan")
                except ValueError:
                    return f"column {name}, sample {sample}: {cell[:40]!r} is not a number"
    return "has a header and no samples" if sample < 0 else None


def _read_parquet(path: Path) -> _Raw:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            schema = file.schema_arrow
            names = [name.strip() for name in schema.names]
            groups = _groups(path, names)
            wanted = ["t", *(name for group in groups.values() for name in group)]
            for name in wanted:
                kind = schema.types[names.index(name)]
                if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
                    _refuse(path, f"column {name} holds {kind}", "floats or integers")
            stored = [schema.names[names.index(name)] for name in wanted]
            table = file.read(columns=stored).select(stored).rename_columns(wanted)
    except (pa.ArrowException, OSError, ValueError) as error:
        what = f"{path}: is not a readable Parquet file: {error}"
        raise LogError(_line(f"{what}; accepted: a Parquet table of {_COLUMNS}")) from error
    return _from_columns(table, names, groups)


def _groups(path: Path, names: list[str]) -> dict[str, list[str]]:
    """Sort the names of columns into {"q": [q1, ..], "qd": [..], "tau": [..]}, by number."""
    named = [name for name in names if name]
    for name in named:
        if named.count(name) > 1:
            _refuse(path, f"the column {name} occurs {named.count(name)} times", "each column once")
    numbers: dict[str, list[int]] = {"q": [], "qd": [], "tau": [], "i": []}
    for name in named:
        if match := _NUMBERED.fullmatch(name):
            numbers[match[1]].append(int(match[2]))
    found = ", ".join(named[:12]) + (", .." if len(named) > 12 else "")
    for role, present in (("t", "t" in named), ("q1", numbers["q"]), ("tau1", numbers["tau"])):
        if role == "tau1" and not present and numbers["i"]:
            _refuse_currents(path)
        if not present:
            _refuse(path, f"there is no column {role} among {found or 'none'}", _COLUMNS)
    groups = {}
    for role in ("q", "qd", "tau"):
        have = sorted(numbers[role])
        if have != list(range(1, len(have) + 1)):
            gap = ", ".join(f"{role}{number}" for number in have)
            _refuse(path, f"the columns {gap} are not numbered 1, 2, .. without gaps", _COLUMNS)
        groups[role] = [f"{role}{number}" for number in have]
    return groups


def _refuse_currents(path: Path) -> NoReturn:
    _refuse(
        path,
        "the torque columns tau1.. are missing, and motor currents i1.. need [drive] in the robot "
        "file, which is not supported yet",
        _COLUMNS,
    )


def _from_columns(table: Any, names: list[str], groups: dict[str, list[str]]) -> _Raw:
    def stack(columns: list[str]) -> FloatArray:
        return np.column_stack([table[name].to_numpy().astype(np.float64) for name in columns])

    used = {"t", *(name for group in groups.values() for name in group)}
    return _Raw(
        t=table["t"].to_numpy(),
        q=stack(groups["q"]),
        qd=stack(groups["qd"]) if groups["qd"] else None,
        tau=stack(groups["tau"]),
        ignored=tuple(name for name in names if name not in used),
    )


def _read_npz(path: Path) -> _Raw:
    if not zipfile.is_zipfile(path):
        _refuse(path, "is not an NPZ archive", f"what numpy.savez writes, with {_KEYS}")
    try:
        # allow_pickle stays off: a pickle in a log would run code of whoever wrote it. The file is
        # opened here because numpy leaves it open when the archive is damaged.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            keys = list(archive.files)
            arrays = {
                key: np.asarray(archive[key]) for key in ("t", "q", "qd", "tau") if key in keys
            }
    except Exception as error:  # a damaged archive raises one of a dozen kinds
        what = "an array holds Python objects" if "Object arrays" in str(error) else str(error)
        raise LogError(_line(f"{path}: cannot be read: {what}; accepted: {_KEYS}")) from error
    if "tau" not in arrays and "i" in keys:
        _refuse_currents(path)
    for key in ("t", "q", "tau"):
        if key not in arrays:
            _refuse(path, f"there is no array {key} among {', '.join(keys) or 'none'}", _KEYS)
    ignored = tuple(key for key in keys if key not in arrays)
    return _Raw(arrays["t"], arrays["q"], arrays.get("qd"), arrays["tau"], ignored)


# --- the checks ----------------------------------------------------------------------------------


def _checked(file: str, name: str, raw: _Raw, n: int | None, sigma: Sequence[int] | None) -> Log:
    if sigma is not None and n is not None and len(sigma) != n:
        raise ValueError(f"sigma has {len(sigma)} entries for {n} joints")
    n = len(sigma) if sigma is not None else n
    t = _numeric(file, "t", raw.t)
    if t.ndim != 1:
        _refuse(file, f"t has the shape {t.shape}", "t (N,)")
    if len(t) == 0:
        _refuse(file, "has no samples", f"at least {MIN_SAMPLES} samples")
    if len(t) < MIN_SAMPLES:
        _refuse(file, f"has {len(t)} samples", f"at least {MIN_SAMPLES} samples")
    q = _matrix(file, "q", raw.q, len(t))
    tau = _matrix(file, "tau", raw.tau, len(t))
    qd = None if raw.qd is None else _matrix(file, "qd", raw.qd, len(t))
    joints = q.shape[1]
    if n is not None and joints != n:
        count = f"{joints} joint{'s' if joints > 1 else ''}"
        _refuse(file, f"the log has {count}, the robot has {n}", "one q and tau per movable joint")
    for role, array in (("qd", qd), ("tau", tau)):
        if array is not None and array.shape[1] != joints:
            what = f"columns of q: {joints}, of {role}: {array.shape[1]}"
            _refuse(file, what, "as many of q and tau, and of qd when there is any")
    _require_finite(file, "t", t[:, None], t)
    for role, array in (("q", q), ("qd", qd), ("tau", tau)):
        if array is not None:
            _require_finite(file, role, array, t)
    _require_increasing(file, t)
    revolute = [j for j in range(joints) if sigma is None or sigma[j] != PRISMATIC]
    _require_radians(file, t, q, qd, revolute)
    return Log(name, t, q, qd, tau, raw.ignored)


def _numeric(file: str, role: str, array: npt.NDArray[Any]) -> FloatArray:
    if array.dtype.kind not in "iuf":
        _refuse(file, f"{role} holds {array.dtype}", "floats or integers")
    return read_only(array)


def _matrix(file: str, role: str, array: npt.NDArray[Any], samples: int) -> FloatArray:
    matrix = array[:, None] if array.ndim == 1 else array
    if matrix.ndim != 2 or len(matrix) != samples or matrix.shape[1] == 0:
        what = f"{role} has the shape {array.shape}, and t has {samples} samples"
        _refuse(file, what, f"{role} ({samples}, n)")
    return _numeric(file, role, matrix)


def _require_finite(file: str, role: str, array: FloatArray, t: FloatArray) -> None:
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        sample, j = (int(index) for index in bad[0])
        column = role if role == "t" else f"{role}{j + 1}"
        when = f" (t = {t[sample]:.6g} s)" if role != "t" else ""
        value = array[sample, j]
        shown = "nan, or an empty cell" if np.isnan(value) else f"{value}"
        _refuse(file, f"column {column}, sample {sample}{when}: {shown}", "finite numbers")


def _require_increasing(file: str, t: FloatArray) -> None:
    late = np.flatnonzero(np.diff(t) <= 0)
    if len(late):
        k = int(late[0]) + 1
        what = f"column t, sample {k}: {t[k]:.9g} s comes after {t[k - 1]:.9g} s"
        _refuse(file, what, "strictly increasing time in s")


def _require_radians(
    file: str, t: FloatArray, q: FloatArray, qd: FloatArray | None, revolute: list[int]
) -> None:
    accepted = "rad and rad/s (m and m/s for a prismatic joint)"
    for j in revolute:
        span = float(np.ptp(q[:, j]))
        if span > MAX_RANGE:
            what = f"column q{j + 1} spans {span:.4g}, over {MAX_RANGE:g} rad, as degrees would"
            _refuse(file, what, accepted)
    if qd is None:
        return
    slope = np.gradient(q, t, axis=0)
    for j in revolute:
        moved, told = (float(np.sqrt(np.mean(x[:, j] ** 2))) for x in (slope, qd))
        if moved == 0.0 or told == 0.0:
            continue
        # At rest both are noise, whose ratio can be anything: demand that they move together.
        together = float(np.mean(slope[:, j] * qd[:, j])) / (moved * told)
        if together < 0.5:
            continue
        for role, factor in (("q", moved / told), ("qd", told / moved)):
            if abs(factor / _DEGREES - 1.0) < 0.05:
                other = "qd" if role == "q" else "q"
                what = (
                    f"qd{j + 1} and the slope of q{j + 1} differ by {factor:.3g}: {role}{j + 1} "
                    f"looks like degrees and {other}{j + 1} like radians"
                )
                _refuse(file, what, accepted)
