"""Measured logs: read from files or made of arrays, and checked before anything is computed.

A log that passes is safe to use without further checks: finite, increasing in time, with as many
positions as torques. One that does not is refused with one line that names the file, the column
and the sample, and says what is accepted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from symgen.data.bags import is_bag, read_bag
from symgen.data.beside import links, temperatures
from symgen.data.columns import another_number
from symgen.data.drive import joint_side
from symgen.data.raw import (
    KEYS,
    ROLES,
    FloatArray,
    Raw,
    Reading,
    Wanted,
    one_line,
    refuse,
    require_shapes,
)
from symgen.data.raw import Log as Log
from symgen.data.raw import read_only as read_only
from symgen.data.tables import SUFFIXES, open_table, whole
from symgen.errors import LogError, plain
from symgen.names import PRISMATIC

if TYPE_CHECKING:
    from symgen.robot.types import Drive

#: Fewer samples than this determine neither a derivative nor a noise level.
MIN_SAMPLES = 10

#: A revolute joint that travels further than this, in rad, is taken to be written in degrees.
MAX_RANGE = 50.0

_DEGREES = 180.0 / np.pi
_LOOKED_AT = 1 << 14  # samples whose speeds tell the unit
_FILES = "a .csv, .parquet, .npz, .mcap or .db3 file, or the folder of a ROS 2 bag"


def read_log(
    path: str | Path,
    n: int | None = None,
    *,
    sigma: Sequence[int] | None = None,
    drive: Drive | None = None,
    reading: Reading | None = None,
    names: Sequence[str] = (),
) -> Log:
    """Read a log from a CSV, Parquet, NPZ or MCAP file, or from a ROS 2 bag.

    CSV and Parquet have the columns t, q1.., optional qd1.., tau1.., or those of a recorder
    (panda_joint1_position, pos_1, time), which are matched by name; all others are ignored. Some
    joints may have temp1.. (deg C) and qs1.. (a second encoder) besides. NPZ
    has the arrays t (N,), q, tau and optional qd, temp, qs (N, n), of any float or integer type;
    (N,) will do for q, qd and tau of a single joint. MCAP files and bags have messages
    sensor_msgs/msg/JointState, whose effort is tau.

    Args:
        path: the file, or the folder of a bag.
        n: number of movable joints of the robot, None to take what the log has.
        sigma: (n,) types of the movable joints (0 revolute, 1 prismatic); None for all revolute.
        drive: gears and motors of the robot; the log is mapped to the joint side, and currents
            i1.. are read where it has torque constants.
        reading: names of columns, joints and topic in the file, and the span of time.
        names: what the robot calls its movable joints, for bags and names of columns.

    Returns:
        The checked log.

    Raises:
        LogError: the file cannot be read, or is refused by `make_log`.
    """
    path = Path(path)
    reading = reading or Reading()
    currents = drive is not None and drive.torque_constant is not None
    try:
        if path.is_dir() and not is_bag(path):
            refuse(path, "is a folder", _FILES)
        if not path.exists():
            refuse(path, "there is no such file", _FILES)
        if is_bag(path):
            raw = read_bag(path, reading, names, currents)
        elif path.suffix.lower() not in SUFFIXES:
            refuse(path, f"the extension {path.suffix!r} is not known", _FILES)
        else:
            own = len(sigma) if sigma is not None else n
            wanted = Wanted(reading.columns, currents, names, own, reading.poses)
            with open_table(str(path), wanted) as table:
                raw = whole(table)
    except (OSError, ValueError) as error:
        raise LogError(one_line(f"{path}: cannot be read: {error}; accepted: {_FILES}")) from error
    return checked(str(path), plain(path.name), raw, n, sigma, drive, names, reading.poses)


def make_log(
    name: str,
    t: npt.ArrayLike,
    q: npt.ArrayLike,
    tau: npt.ArrayLike | None,
    qd: npt.ArrayLike | None = None,
    n: int | None = None,
    *,
    sigma: Sequence[int] | None = None,
    current: npt.ArrayLike | None = None,
    drive: Drive | None = None,
    temp: npt.ArrayLike | None = None,
    qs: npt.ArrayLike | None = None,
) -> Log:
    """Make a log of arrays, with the same checks as a file gets. The arrays are copied.

    Args:
        name: what messages and reports call the log.
        t: (N,) time in s.
        q: (N, n) positions in rad (m); (N,) for a single joint, as for qd and tau.
        tau: (N, n) torques in N m (N); None where currents are given in their place.
        qd: (N, n) velocities in rad/s (m/s), or None.
        n: number of movable joints of the robot, None to take what the log has.
        sigma: (n,) types of the movable joints (0 revolute, 1 prismatic); None for all revolute.
        current: (N, n) motor currents in A, or None.
        drive: gears and motors of the robot; the log is mapped to the joint side.
        temp: (N, n) temperatures, deg C, NaN on joints without, or None.
        qs: (N, n) positions of links in rad (m), NaN on joints without, or None.

    Raises:
        LogError: fewer than 10 samples, shapes that differ, a value that is not a finite number,
            time that does not increase, another number of joints than n, or degrees for radians.
    """
    try:
        speed, torque, motor, warm, link = (
            None if a is None else np.asarray(a, order="C") for a in (qd, tau, current, temp, qs)
        )
        positions = np.asarray(q, order="C")
        raw = Raw(np.asarray(t), positions, speed, torque, motor, temp=warm, qs=link)
    except ValueError as error:
        raise LogError(one_line(f"{name}: {error}; accepted: {KEYS}")) from error
    return checked(name, name, raw, n, sigma, drive)


def cut(log: Log, start: float | None, until: float | None) -> Log:
    """Return the part of a log between two times of its column t, s; None for no bound.

    Raises:
        LogError: fewer than 10 samples lie between them.
    """
    if start is None and until is None:
        return log
    low, high = (-np.inf if start is None else start), (np.inf if until is None else until)
    inside = np.flatnonzero((log.t >= low) & (log.t <= high))
    have = f"the log runs from {log.t[0]:.6g} s to {log.t[-1]:.6g} s"
    if len(inside) < MIN_SAMPLES:
        what = f"{len(inside)} samples lie between {low:g} s and {high:g} s; {have}"
        refuse(log.name, what, f"a span with at least {MIN_SAMPLES} samples")
    span = slice(int(inside[0]), int(inside[-1]) + 1)
    out = rows(log, span)
    ends = f"t = {out.t[0]:.6g} s to {out.t[-1]:.6g} s"
    note = f"{log.name}: cut to {ends}, {len(out.t)} of {len(log.t)} samples"
    return replace(out, notes=(*log.notes, note))


def rows(log: Log, chosen: slice | npt.NDArray[np.bool_]) -> Log:
    """Return some rows of a log."""
    arrays: dict[str, Any] = {
        key: read_only(getattr(log, key)[chosen])
        for key in ("t", "q", "qd", "tau", "current", "temp", "qs")
        if getattr(log, key) is not None
    }
    return replace(log, **arrays)


def checked(
    file: str,
    name: str,
    raw: Raw,
    n: int | None,
    sigma: Sequence[int] | None,
    drive: Drive | None,
    names: Sequence[str] = (),
    poses: bool = False,
) -> Log:
    """Return what a file held as a log on the joint side, or refuse it; see `read_log`.

    Args:
        file: what messages call it.
        name: of the log.
        raw: what it held.
        n, sigma, drive, names: of the robot.

    Raises:
        LogError: it is none.
    """
    if sigma is not None and n is not None and len(sigma) != n:
        raise ValueError(f"sigma has {len(sigma)} entries for {n} joints")
    n = len(sigma) if sigma is not None else n
    held = {role: x for role in ROLES if (x := getattr(raw, role)) is not None}
    require_shapes(file, held)
    t = read_only(held.pop("t"))
    if len(t) < MIN_SAMPLES:
        refuse(file, f"has {len(t) or 'no'} samples", f"at least {MIN_SAMPLES} samples")
    if raw.tau is None and raw.i is None:
        refuse(file, "has neither torques nor currents", KEYS)
    arrays = {role: read_only(x[:, None] if x.ndim == 1 else x) for role, x in held.items()}
    q = arrays["q"]
    qd, tau, current, temp, qs = map(arrays.get, ("qd", "tau", "i", "temp", "qs"))
    joints = q.shape[1]
    if n is not None and joints != n:
        refuse(file, *another_number(joints, n, names))
    for role, array in (("t", t[:, None]), ("q", q), ("qd", qd), ("tau", tau), ("i", current)):
        if array is not None:
            _require_finite(file, role, array, t)
    late = np.flatnonzero(np.diff(t) <= 0)
    if len(late):
        k = int(late[0]) + 1
        what = f"column t, sample {k}: {t[k]:.9g} s comes after {t[k - 1]:.9g} s"
        refuse(file, what, "strictly increasing time in s")
    revolute = [j for j in range(joints) if sigma is None or sigma[j] != PRISMATIC]
    warm = None if temp is None else temperatures(file, t, temp)
    link = None if qs is None else links(file, qs)
    log = Log(name, t, q, qd, tau, raw.ignored, current, raw.notes, temp=warm, qs=link)
    log = log if drive is None else joint_side(log, drive)
    _require_radians(file, t, log.q, None if poses else log.qd, revolute)
    return log


def _require_finite(file: str, role: str, array: FloatArray, t: FloatArray) -> None:
    if not np.isfinite(array).all():
        bad = np.argwhere(~np.isfinite(array))
        sample, j = (int(index) for index in bad[0])
        column = role if role == "t" else f"{role}{j + 1}"
        when = f" (t = {t[sample]:.6g} s)" if role != "t" else ""
        value = array[sample, j]
        shown = "nan, or an empty cell" if np.isnan(value) else f"{value}"
        refuse(file, f"column {column}, sample {sample}{when}: {shown}", "finite numbers")


def _require_radians(
    file: str, t: FloatArray, q: FloatArray, qd: FloatArray | None, revolute: list[int]
) -> None:
    accepted = "rad and rad/s (m and m/s for a prismatic joint), on the joint side or with [drive]"
    for j in revolute:
        span = float(np.ptp(q[:, j]))
        if span > MAX_RANGE:
            what = f"column q{j + 1} spans {span:.4g}, over {MAX_RANGE:g} rad, as degrees would"
            refuse(file, what, accepted)
    if qd is None:
        return
    # at some tens of thousands of samples all over the log: the unit is that of all of it
    at = np.arange(0, len(t) - 2, max(1, len(t) // _LOOKED_AT))
    slope, qd = (q[at + 2] - q[at]) / (t[at + 2] - t[at])[:, None], qd[at + 1]
    moved, told = (np.sqrt(np.mean(x**2, axis=0)) for x in (slope, qd))
    together = np.mean(slope * qd, axis=0)
    for j in revolute:
        # At rest both are noise, whose ratio can be anything: demand that they move together.
        if not together[j] >= 0.5 * moved[j] * told[j] > 0:
            continue
        for role, other, factor in (
            ("q", "qd", moved[j] / told[j]),
            ("qd", "q", told[j] / moved[j]),
        ):
            if abs(factor / _DEGREES - 1.0) < 0.05:
                what = (
                    f"qd{j + 1} and the slope of q{j + 1} differ by {factor:.3g}: {role}{j + 1} "
                    f"looks like degrees and {other}{j + 1} like radians"
                )
                refuse(file, what, accepted)
