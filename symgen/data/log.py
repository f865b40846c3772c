"""Read and check measured logs, from files or arrays.

A checked log needs no further checks: its values are finite, its time increases, and its shapes
match. Other logs are refused. The message names the file, the column, the sample, and the accepted
input.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from symgen.data.bags import FIELDS, is_bag, read_bag
from symgen.data.columns import another_number
from symgen.data.drive import joint_side
from symgen.data.gaps import GAP
from symgen.data.lerobot import log_name
from symgen.data.mask import STILL, rms, spans
from symgen.data.raw import (
    BESIDE,
    CHANNELS,
    DRIVING,
    FRAMED,
    KEYS,
    TORQUES,
    VECTORS,
    Bools,
    FloatArray,
    Raw,
    Reading,
    Wanted,
    columns_from,
    refuse,
    require_shapes,
    roles_with_unit,
    shown,
)
from symgen.data.raw import Log as Log
from symgen.data.raw import read_only as read_only
from symgen.data.tables import SUFFIXES, TEXTS, names_of, open_table
from symgen.data.units import Converted, split_unit, units_of
from symgen.errors import located, plain
from symgen.names import PRISMATIC

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from symgen.robot.tables import Drive, LogForm

#: Fewer samples determine neither a derivative nor a noise level.
MIN_SAMPLES = 10

#: A value whose arrays have one row for each sample.
Rows = TypeVar("Rows", bound="DataclassInstance")

#: Range of a revolute joint in rad above which its positions are probably in degrees.
_MAX_RANGE = 50.0
_DEGREES = 180.0 / np.pi
_CHANGING = 0.95  # share of stamps that differ from the previous one, in a file that rounds them
_CHECKED_SAMPLES = 1 << 14  # samples that show the unit of the speeds
#: Duty over its range, and voltage over that of the supply, that rounding may cause.
_OVER = 1.05
_FILES = "a .csv, .tsv, .txt, .parquet, .npz, .mcap or .db3 file, or the folder of a ROS 2 bag"
#: Ending of a file that symgen does not read -> how to convert it.
_CONVERTED = {
    ".mat": "an .npz: numpy.savez('log.npz', **scipy.io.loadmat('log.mat'))",
    ".bag": "a ROS 2 bag: rosbags-convert --src log.bag --dst log",
}


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

    CSV and Parquet files have columns t, q1.., tau1.. and optional qd1... Duty u1.. may replace
    tau1... Names of a recorder (panda_joint1_position, pos_1, time) are matched. Some joints may
    also have qs1.. (a second encoder). The motion of a base with an IMU is fx, fy, fz (specific
    force a - g) and wx, wy, wz (angular velocity), in its axes; the wrench of a sensor is wfx to
    wfz and wnx to wnz. Other columns are ignored. NPZ files have arrays t (N,), q and tau (N, n),
    and optional qd and qs (N, n), imu and wrench (N, 6), of float or integer type; (N,) is accepted
    for a single joint. MCAP files and bags have messages sensor_msgs/msg/JointState, whose effort
    is tau. Columns in other units (deg, ms, mNm, dates) are converted if an option or the header
    says so. Empty cells are interpolated.

    Args:
        path: the file, or the folder of a bag.
        n: number of movable joints of the robot; None for that of the log.
        sigma: (n,) types of the movable joints (0 revolute, 1 prismatic); None for all revolute.
        drive: gears and motors of the robot. The log is converted to the joint side. Currents
            i1.. are read if the drive has torque constants.
        reading: names of columns, joints and topic in the file, and the span of time.
        names: names of the movable joints of the robot, for bags and column names.

    Returns:
        The checked log.

    Raises:
        LogError: the file cannot be read, or fails the checks of `make_log`.
    """
    wanted = Wanted(reading or Reading(), drive, names, n, tuple(sigma or ()))
    return read_wanted(path, wanted)


def read_wanted(path: str | Path, wanted: Wanted) -> Log:
    """Read a log from a file or bag, see `read_log`."""
    path, reading = Path(path), wanted.reading
    with located(path):
        try:
            if path.is_dir() and not is_bag(path):
                refuse("is a folder", _FILES)
            if not path.exists():
                refuse("there is no such file", _FILES)
            if is_bag(path):
                if reading.time_unit or roles_with_unit(reading) - TORQUES:
                    what = "--unit and --time-unit: positions, speeds and stamps of messages are "
                    refuse(f"{what}in rad, rad/s and s", "--unit of tau, i or u")
                messages = read_bag(path, wanted)
                raw = units_of(messages, wanted).of(messages)
            elif path.suffix.lower() not in (*SUFFIXES, *TEXTS):
                how = _CONVERTED.get(path.suffix.lower(), _FILES)
                refuse(f"the extension {path.suffix!r} is not known", how)
            else:
                with open_table(str(path), wanted) as table:
                    raw = table.part(0, table.rows)
        except (OSError, ValueError) as error:
            refuse(f"cannot be read: {error}", _FILES)
        return checked_log(plain(log_name(path)), raw, wanted)


def reading_of(name: str, reading: Reading, log: LogForm | None) -> Reading:
    """Return the options of reading a file, completed with [log] of the robot file.

    A file with the names of a log (q1, tau1), such as a simulated one, is not in the form of [log],
    unless [log] names columns that the file has.

    Args:
        name: the file or URL.
        reading: options from the user.
        log: the table [log].

    Raises:
        LogError: it is unclear whether the units of [log] are those of the file.
    """
    if log is None:
        return reading
    full = reading.over(log)
    if is_bag(Path(name)):
        fields = {ours: theirs for ours, theirs in full.pairs.items() if theirs in FIELDS}
        return replace(reading, columns=reading.columns or fields, joints=full.joints)
    names = names_of(name, reading)
    ours = not {"q1", "q"}.isdisjoint(split_unit(name)[0] for name in names)
    columns = columns_from(log.columns).values()
    starts = [re.split(r"[*+]", column)[0] for column in columns]
    found = [any(name.startswith(start) for name in names) for start in starts]
    fits = starts and all(found)
    if fits or not ours:
        return full
    if not starts and (log.unit or log.time_unit) and not (reading.unit or reading.time_unit):
        what = "[log] of the robot file has units and no columns, and the file has those of a log"
        refuse(what, "columns in [log], such as q=q*,tau=tau*; or --unit rad (deg), --time-unit s")
    return reading


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
    qs: npt.ArrayLike | None = None,
    qr: npt.ArrayLike | None = None,
    qdr: npt.ArrayLike | None = None,
    imu: npt.ArrayLike | None = None,
    duty: npt.ArrayLike | None = None,
    supply: npt.ArrayLike | None = None,
    wrench: npt.ArrayLike | None = None,
    pose: npt.ArrayLike | None = None,
    forces: npt.ArrayLike | None = None,
    touches: npt.ArrayLike | None = None,
) -> Log:
    """Make a log from arrays, with the checks of a log file. The arrays are copied.

    Args:
        name: name of the log in messages and reports.
        t: (N,) time in s.
        q: (N, n) positions in rad (m). For a single joint, q, qd and tau may be (N,).
        tau: (N, n) torques in N m (N); None if `current`, `duty`, `qr` or `wrench` is
            given.
        qd: (N, n) velocities in rad/s (m/s), or None.
        n: number of movable joints of the robot; None for that of the log.
        sigma: (n,) types of the movable joints (0 revolute, 1 prismatic); None for all revolute.
        current: (N, n) motor currents in A, or None.
        drive: gears and motors of the robot. The log is converted to the joint side.
        qs: (N, n) link positions in rad (m), NaN for joints without a second encoder; or None.
        qr: (N, n) reference positions of the controller in rad (m), or None.
        qdr: (N, n) reference speeds of the controller in rad/s (m/s), or None.
        imu: (N, 6) motion of a base that moves, in its axes: specific force a - g of its origin,
            m/s2, and angular velocity, rad/s; or None.
        duty: (N, n) input of the drives, -1 to 1; or None.
        supply: (N,) voltage of the supply, V; or None.
        wrench: (N, 6) force, N, and moment, N m, that the arm exerts on its tool, in the frame of
            [sensor]; or None.
        pose: (N, 7) place of the origin of a base that moves, m, and quaternion qw, qx, qy, qz from
            its axes to those of the world; or None.
        forces: (N, 6 F) wrench of the world on each [[frame]] of a robot with a floating base, NaN
            for frames without; or None.
        touches: (N, C) 1 where the robot touches its surroundings at each [[contact]], else 0; or
            None.

    Raises:
        LogError: fewer than 10 samples, different shapes, a value that is not finite, time that
            does not increase, a wrong number of joints, or degrees instead of radians.
    """
    arrays = {"t": t, "q": q, "qd": qd, "tau": tau, "i": current, "qs": qs, "qr": qr,
             "qdr": qdr, "imu": imu, "u": duty, "supply": supply, "wrench": wrench,
             "pose": pose, "forces": forces, "touches": touches}  # fmt: skip
    with located(name):
        try:
            plain_arrays = {
                role: np.asarray(x, order="C") for role, x in arrays.items() if x is not None
            }
        except ValueError as error:
            refuse(str(error), KEYS)
        wanted = Wanted(Reading(), drive, (), n, tuple(sigma or ()))
        return checked_log(name, Raw(plain_arrays), wanted)


def cut(log: Log, start: float | None, until: float | None) -> Log:
    """Return the part of a log between two times of its column t, s; None for no limit.

    Raises:
        LogError: fewer than 10 samples remain.
    """
    reading = Reading(start=start, until=until)
    span, notes = _used(log.name, log.t, reading)
    if not notes:
        return log
    return replace(rows(log, span), notes=(*log.notes, *notes))


def _used(name: str, t: FloatArray, reading: Reading) -> tuple[slice, tuple[str, ...]]:
    """Return the rows of the selected span, and a note on them.

    The clock may go back. The rows begin after the last one before the span, and end before the
    first one after it.
    """
    low, high = reading.span
    if reading.start is None and reading.until is None:
        return slice(None), ()
    early = np.flatnonzero(t < low)
    begin = int(early.max(initial=-1)) + 1
    late = np.flatnonzero(t[begin:] > high)
    count = int(late.min(initial=len(t) - begin))
    if count < MIN_SAMPLES:
        have = f"the log runs from {t[0]:.6g} s to {t[-1]:.6g} s"
        what = f"{count} samples lie between {low:g} s and {high:g} s; {have}"
        refuse(what, f"a span with at least {MIN_SAMPLES} samples")
    used = t[begin : begin + count]
    ends = f"t = {used[0]:.6g} s to {used[-1]:.6g} s"
    note = f"{name}: cut to {ends}, {count} of {len(t)} samples"
    return slice(begin, begin + count), (note,)


def rows(log: Rows, chosen: slice | Bools) -> Rows:
    """Return some rows of a log, or of another value with one row for each sample."""
    return _with(log, {key: x[chosen] for key, x in _arrays(log)})


def _arrays(log: Any) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    """Yield the fields of a log that are arrays."""
    for key, x in vars(log).items():
        if isinstance(x, np.ndarray):
            yield key, x


def _with(log: Rows, arrays: Mapping[str, npt.NDArray[Any]]) -> Rows:
    """Return a log with other arrays, read-only."""
    for x in arrays.values():
        x.setflags(write=False)
    return replace(log, **arrays)


def checked_log(name: str, raw: Raw, wanted: Wanted, part: bool = False) -> Log:
    """Check the content of a file and return it as a log on the joint side; see `read_log`.

    Args:
        name: name of the log.
        raw: content of the file.
        wanted: the robot, the span of time, and units from the user.
        part: whether it is a part of a log, in which a channel may be missing.

    Raises:
        LogError: a check fails.
    """
    require_shapes(raw.arrays)
    t = read_only(raw.arrays["t"])
    if len(t) < MIN_SAMPLES:
        refuse(f"has {len(t) or 'no'} samples", f"at least {MIN_SAMPLES} samples")
    if wanted.n == 0:
        none = np.zeros((len(t), 0))
        raw = replace(raw, arrays={**raw.arrays, "q": none, "tau": none})
    if not raw.arrays.keys() & DRIVING:
        refuse("has neither torques nor currents nor duty", KEYS)
    _require_finite("t", t[:, None], t, raw.names)
    span, notes = _used(name, t, wanted.reading)
    arrays: dict[str, Any] = {}
    for role, x in raw.arrays.items():
        column = read_only(x if x.ndim == 2 else x[:, None])
        arrays[role] = read_only(column[span]) if notes else column
    t, rounded = _clock(arrays["t"][:, 0], shown("t", raw.names))
    for role in arrays.keys() & set(BESIDE):
        if not _has_values(role, arrays[role]):
            del arrays[role]
    if "qd" in arrays and np.isnan(arrays["qd"]).all() and not part:
        del arrays["qd"]  # the recorder has no speeds
    missing: Bools = np.zeros((*arrays["q"].shape, 3), dtype=bool)
    for role, channel in CHANNELS.items():
        k = channel.missing
        if k is not None and role in arrays:
            empty = np.isnan(arrays[role])
            x = _filled(role, arrays[role], empty, t, raw.names, part)
            _require_finite(role, x, t, raw.names)
            arrays[role] = x
            missing[:, :, k] |= empty
    missing.setflags(write=False)
    for role in arrays.keys() & VECTORS.keys():
        _require_finite(role, arrays[role], t, raw.names)
    for role in arrays.keys() & {*FRAMED}:
        absent = np.isnan(arrays[role]).all(axis=0)
        _require_finite(role, np.where(absent, 0.0, arrays[role]), t, raw.names)
    channels: dict[str, Any] = {}
    for role, channel in CHANNELS.items():
        channels[channel.key] = arrays.get(role)
    log = Log(
        name, t, **channels, ignored=raw.ignored, notes=(*raw.notes, *notes),
        missing=missing if missing.any() else None,
        converted=(*raw.converted, *rounded),
        drive_unit="" if channels["duty"] is None else raw.drive_unit,
    )  # fmt: skip
    log = of_movable_joints(log, wanted, part)
    _require_duty(log, wanted)
    log = joint_side(log, wanted.drive)
    kept = wanted.kept(missing.shape[1])
    types = dict(enumerate(wanted.sigma))
    turning = {j: k for j, k in enumerate(kept) if types.get(j) != PRISMATIC}
    sure = "q" in roles_with_unit(wanted.reading)
    _require_radians(log, turning, sure, raw.names)
    return log


def of_movable_joints(log: Log, wanted: Wanted, part: bool = False) -> Log:
    """Return a log without the columns of fixed joints.

    Raises:
        LogError: the number of joints is wrong, or a fixed joint moves. A part of a log may be too
            short to show that.
    """
    width = log.q.shape[1]
    kept = wanted.kept(width)
    if width == wanted.n == 0:
        return log
    if not kept:
        refuse(*another_number(width, wanted))
    if len(kept) == width:
        return log
    span = np.ptp(log.q, axis=0)
    fixed = [k for k in range(width) if k not in kept]
    moving = [k + 1 for k in fixed if span[k] > STILL * span.max()]
    if moving and not part:
        what = f"q{moving[0]} moves, and joint {moving[0]} is fixed in the robot file"
        refuse(what, "a log in which it stands still, or a robot in which it moves")
    arrays = {key: x for key, x in _arrays(log) if key not in ("t", *VECTORS, *FRAMED)}
    arrays = {key: x.take(kept, axis=1) for key, x in arrays.items()}
    note = f"{log.name}: the columns of fixed joints are not used"
    return _with(replace(log, notes=(*log.notes, note)), arrays)


def _clock(t: FloatArray, column: str) -> tuple[FloatArray, tuple[Converted, ...]]:
    """Return increasing times: those of the log, or those of a uniform clock behind rounded stamps.

    Stamps are rounded if some repeat, and if each new stamp is within a sample of the uniform
    clock.

    Args:
        t: (N,) stamps, s.
        column: their column, for messages.

    Raises:
        LogError: the clock goes back, or stamps repeat in another way.
    """
    steps = np.diff(t)
    change = np.flatnonzero(steps) + 1
    if steps.min() > 0:
        return t, ()
    if steps.min() == 0 and MIN_SAMPLES < len(change) < _CHANGING * len(steps):
        step, start = np.polyfit(change, t[change], 1)
        if np.abs(t[change] - start - step * change).max() < 1.5 * step:
            usual = np.median(steps[change - 1])
            text = f"stamps are rounded to {1e3 * usual:.3g} ms"
            done = f"replaced by a uniform clock of {1e3 * step:.4g} ms"
            clock = start + step * np.arange(len(t))
            return read_only(clock), ((column, text, done),)
    k = int(np.argmin(steps)) + 1
    accepted = "strictly increasing time in s, with all its digits"
    if steps.min() < 0:
        k = int(np.argmax(steps < 0)) + 1
        before, after = t[[max(k - 2, 0), min(k + 1, len(t) - 1)]]
        accepted = f"a clock that is not set back: --until {before}, or --from {after}"
    what = f"column {column}, sample {k}: {t[k]:.9g} s comes after {t[k - 1]:.9g} s"
    return refuse(what, accepted)


def _require_duty(log: Log, wanted: Wanted) -> None:
    """Refuse duty beyond -1 to 1, and voltages beyond the supply."""
    volts = log.drive_unit == "V"
    supply = wanted.drive and wanted.drive.supply
    if log.duty is None or (volts and not supply):
        return
    largest = np.abs(log.duty).max(axis=0)
    bounds = np.array(supply if volts else 1.0) + 0 * largest
    j = int(np.argmax(largest / bounds))
    if largest[j] <= _OVER * bounds[j]:
        return
    what = f"u{j + 1} is up to {largest[j]:.4g}"
    if volts:
        how = "the supply of this log in [drive], or --unit u=% for duty"
        refuse(f"{what} V, and the supply of [drive] {bounds[j]:g} V", how)
    unit = "%" if largest[j] <= 100 * _OVER else "0.1%"
    refuse(f"{what}, and duty lies in -1 to 1", f"--unit u={unit}, or --unit u=V for volts")


def _filled(
    role: str,
    x: FloatArray,
    empty: Bools,
    t: FloatArray,
    names: Mapping[str, str],
    part: bool,
) -> FloatArray:
    """Interpolate missing values: by a cubic over few samples, otherwise without overshoot.

    Values before the first one and after the last one are constant.
    """
    if not empty.any():
        return x
    from scipy.interpolate import CubicSpline, PchipInterpolator

    out = x.copy()
    for j in map(int, np.flatnonzero(empty.any(axis=0))):
        lost = empty[:, j]
        known = ~lost & np.isfinite(x[:, j])
        if known.sum() < MIN_SAMPLES and not part:
            column = shown(f"{role}{j + 1}", names)
            what = f"column {column}: {lost.sum()} of {len(t)} cells empty"
            refuse(what, f"at least {MIN_SAMPLES} numbers in a column")
        at, values = t[known], x[known, j]
        if len(at) == 0:
            out[lost, j] = 0.0
            continue
        out[lost, j] = np.interp(t[lost], at, values)
        if len(at) == 1:
            continue
        start, end = at[[0, -1]]
        inside = lost & (t > start) & (t < end)
        long = long_runs(lost)
        for where, curve in ((inside & ~long, CubicSpline), (inside & long, PchipInterpolator)):
            if where.any():
                out[where, j] = curve(at, values)(t[where])
    return read_only(out)


def long_runs(lost: Bools) -> Bools:
    """Return the samples (N,) in runs that must not be interpolated: 10 steps long or at an end."""
    out = np.zeros(len(lost), dtype=bool)
    for first, end in spans(lost):
        if end - first >= GAP - 1 or first == 0 or end == len(lost):
            out[first:end] = True
    return out


def _require_finite(role: str, array: FloatArray, t: FloatArray, names: Mapping[str, str]) -> None:
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        sample, j = map(int, bad[0])
        column = shown(role if role == "t" else f"{role}{j + 1}", names)
        when = f" (t = {t[sample]:.6g} s)" if role != "t" else ""
        value = array[sample, j]
        what = "nan, or an empty cell" if np.isnan(value) else f"{value}"
        refuse(f"column {column}, sample {sample}{when}: {what}", "finite numbers")


def _require_radians(
    log: Log, turning: Mapping[int, int], sure: bool, names: Mapping[str, str]
) -> None:
    """Refuse positions or speeds of revolute joints that look like degrees."""
    t, q, qd = log.t, log.q, log.qd
    accepted = "rad and rad/s, on the joint side or with [drive], or --unit "
    for j, k in turning.items():
        span = float(np.ptp(q[:, j]))
        if span > _MAX_RANGE and not sure:
            column = shown(f"q{k + 1}", names)
            what = f"column {column} spans {span:.4g}, over {_MAX_RANGE:g} rad, as degrees would"
            one = f"q{k + 1}=deg"
            if qd is not None:
                one += f",qd{k + 1}=deg/s"
            refuse(what, f"{accepted}deg, or --unit {one}, or --unit rad if it turns so far")
    if qd is None:
        return
    # about ten thousand samples over the log are enough to find the unit
    every = max(1, len(t) // _CHECKED_SAMPLES)
    before = np.arange(0, len(t) - 2, every)
    after = before + 2
    duration = t[after] - t[before]
    slope = (q[after] - q[before]) / duration[:, None]
    speed = qd[before + 1]
    sizes = rms(slope), rms(speed)
    # At rest both are noise with an arbitrary ratio: require that they move together.
    power = np.mean(slope * speed, axis=0)
    in_step = power >= 0.5 * sizes[0] * sizes[1]
    for j, k in turning.items():
        columns = [shown(f"{role}{k + 1}", names) for role in ("q", "qd")]
        for degrees, units in enumerate(("q=deg,qd=rad/s", "q=rad,qd=deg/s")):
            large, small = sizes[degrees][j], sizes[1 - degrees][j]
            factor = large / (small or np.inf)
            if in_step[j] and abs(factor / _DEGREES - 1.0) < 0.05:
                what = (
                    f"qd{k + 1} and the slope of q{k + 1} differ by {factor:.3g}: "
                    f"{columns[degrees]} looks like degrees and {columns[1 - degrees]} like radians"
                )
                refuse(what, f"{accepted}with the units of both, such as --unit {units}")


def _has_values(role: str, x: FloatArray) -> bool:
    """Return whether a column such as qs (N, n) has values; refuse incomplete ones of a joint."""
    bad = np.count_nonzero(~np.isfinite(x), axis=0)
    absent = np.isnan(x).all(axis=0)
    for j in np.flatnonzero((bad > 0) & ~absent):
        what = f"column {role}{j + 1}: {bad[j]} values are missing or not finite"
        refuse(what, "rad (m) in every sample")
    return not absent.all()
