"""Logs before and after checks, and options for reading them."""

from __future__ import annotations

import io
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt

from symgen.errors import LogError, SymgenError, first_of, plain
from symgen.names import WRENCH_ENDS

if TYPE_CHECKING:
    from symgen.robot.tables import Drive, LogForm
    from symgen.robot.types import Robot

FloatArray = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
#: Numbers of samples.
Places = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Channel:
    """A channel of logs: a column for each joint, or columns of its own.

    Attributes:
        key: its name in `Log`.
        quantities: what it measures at a revolute joint, and at a prismatic one; or in each of its
            own columns; empty if it has SI units in every file.
        missing: its place in `Log.missing`, 2 if the torques of a log follow from it; None if only
            some joints may have it, without gaps.
        words: words for it in the column names of recorders; empty if the user has to name it.
        columns: names of its own columns, without gaps; empty if it has one for each joint.
        framed: whether its columns are those of frames of the robot: FRAME.fx.
    """

    key: str
    quantities: tuple[str, ...]
    missing: int | None = None
    words: str = ""
    columns: tuple[str, ...] = ()
    framed: bool = False


#: Columns of the motion of the base in its axes: specific force, m/s2, and angular velocity, rad/s.
IMU = ("fx", "fy", "fz", "wx", "wy", "wz")
#: Columns of what the arm exerts on its tool, in the axes of the frame of [sensor]: force, N, and
#: moment about the origin of this frame, N m.
WRENCH = ("wfx", "wfy", "wfz", "wnx", "wny", "wnz")
#: Columns of the pose of the base: place of its origin, m, and quaternion from its axes to those of
#: the world.
POSE = ("px", "py", "pz", "qw", "qx", "qy", "qz")
_MOTION = ("angle", "length")
_SPEED = ("rate", "speed")
_FORCES = ("force",) * 3 + ("torque",) * 3
#: Role, which begins the names of columns of joints (q1, q2, ..) -> channel.
CHANNELS = {
    "q": Channel("q", _MOTION, 0, "q pos position positions angle"),
    "qd": Channel("qd", _SPEED, 1, "qd dq vel velocity velocities speed"),
    "tau": Channel("tau", ("torque", "force"), 2, "tau torque torques trq effort efforts eff"),
    "i": Channel("current", ("current", "current"), 2, "i current currents"),
    "u": Channel("duty", ("duty", "duty"), 2, "duty pwm"),
    "qs": Channel("qs", _MOTION),
    "qr": Channel("qr", _MOTION),
    "qdr": Channel("qdr", _SPEED),
    "supply": Channel("supply", ("voltage",), columns=("supply",)),
    "imu": Channel("imu", (), columns=IMU),
    "wrench": Channel("wrench", _FORCES, columns=WRENCH),
    "pose": Channel("pose", (), columns=POSE),
    "forces": Channel("forces", (), framed=True),
    "touches": Channel("touches", (), framed=True),
}
#: Channels of which each gives the torques of a log, and those of which a log has at least one.
TORQUES = frozenset(role for role in CHANNELS if CHANNELS[role].missing == 2)
DRIVING = TORQUES | {"qr", "wrench"}
#: Channels with columns of their own, and the names of these.
VECTORS = {role: channel.columns for role, channel in CHANNELS.items() if channel.columns}
#: Channels with columns of frames, FRAME.fx to FRAME.nz or FRAME.contact.
FRAMED = tuple(role for role, channel in CHANNELS.items() if channel.framed)
#: Channels that only some joints may have.
BESIDE = tuple(
    role for role, x in CHANNELS.items() if x.missing is None and not x.columns and not x.framed
)
ROLES = ("t", *(role for role in CHANNELS if role not in FRAMED))
#: Column names with the number of a joint, or of an own column: q1.., qd1.., tau1.., wrench1.., ...
NUMBERED = re.compile(rf"({'|'.join(sorted(ROLES[1:], reverse=True))})(0|[1-9][0-9]*)")
#: Ending of the column of a contact, and names of columns of frames.
CONTACT_END = "contact"
_OF_FRAME = re.compile(rf".+\.({'|'.join((*WRENCH_ENDS, CONTACT_END))})")
#: Column names without the number of a joint -> role, and number among its columns.
NAMED = {"t": ("t", 1)}
for _role, _columns in VECTORS.items():
    NAMED |= {name: (_role, k) for k, name in enumerate(_columns, 1)}
#: Accepted columns of a table, and arrays of an NPZ.
COLUMNS = "t, q1.., optional qd1.., tau1.."
KEYS = "t (N,), q (N, n), tau (N, n), optional qd (N, n)"
#: Limits on the unpacked size of a file: bytes, and multiple of its size on the disk.
_UNPACKED, _PACKING = 256 << 20, 20
_PAIRS = "ours=theirs separated by commas, such as t=time,q1=shoulder_pos"
#: Text in double quotes that a shell would change.
_CHANGED = re.compile(r'"([^"]*[$`\\][^"]*)"')
MASKS = ("rest", "saturation")
#: Units that an option gives to all angles.
ANGLES = ("deg", "rad")
TIME_UNITS = ("s", "ms", "us", "ns")
_ROLES = (
    f"{', '.join(NAMED)}, {', '.join(f'{role}1..' for role in ROLES[1:])} ({', '.join(ROLES)} for "
    "NPZ; q, qd, tau, i, u for a bag)"
)


def columns_from(text: str) -> dict[str, str]:
    """Return log column -> column of the file, from "t=time,q1=shoulder_pos".

    Raises:
        LogError: the text has another form, or names a column twice.
    """
    columns: dict[str, str] = {}
    for pair in text.split(",") if text else ():
        ours, sign, theirs = (part.strip() for part in pair.partition("="))
        if not (ours and sign and theirs):
            raise LogError(f"--columns: {pair[:40]!r}; accepted: {_PAIRS}")
        if ours in columns:
            raise LogError(f"--columns: {ours} is given twice; accepted: {_PAIRS}")
        columns[ours] = theirs
    return columns


def units_from(text: str) -> dict[str, str]:
    """Return column or role -> unit, for `Reading.unit`, from "deg" or "q=deg,tau2=mNm"."""
    pairs = [part.strip().partition("=") for part in text.split(",") if part.strip()]
    return {ours.strip() if sign else "": (unit or ours).strip() for ours, sign, unit in pairs}


def separator_of(text: str) -> str:
    """Return the separator that a text names: a character, or the word tab."""
    return text.replace("tab", "\t").replace("\\t", "\t")


@dataclass(frozen=True)
class Reading:
    """Options for reading logs; the same for every log of a command.

    Attributes:
        columns: log column -> column of the file, {"t": "time", "q1": "shoulder"}; or a pattern
            with * for the joint, {"q": "*_position"}, for the joints without a column of their own;
            or seconds and their rest, {"t": "sec+nanosec"}; or the field of a message,
            {"i": "effort"}; or the text of --columns, "t=time,q=*_position". Empty for [log] of the
            robot.
        joints: names of the movable joints in the file, in the order of the robot; empty for the
            names of the robot.
        topic: topic of the messages in a bag; "" if only one topic has joint states.
        start, until: first and last time of each log to use, s of its column t; None for all.
        mask: samples to leave out of the equations: "rest", "saturation", or both.
        unit: column or role -> its unit in the file, {"q": "deg", "tau1": "mNm"}; "" for all
            angles, {"": "deg"}; "sign10" for counts with the sign in bit 10, "ticks4096" for steps
            of an encoder, "0.1%" for steps of a register.
        time_unit: unit of t in the file, "s", "ms", "us" or "ns"; "" if it is s, or if the header
            states it.
        separator: character between the columns of a CSV; "" for that of its header.
        decimal: decimal mark of a CSV, "." or ","; "" for that of its first numbers.
        header: whether the first line of a CSV contains the names of its columns. Without it, they
            are 1, 2, ...
        range: lowest and highest position of each movable joint, rad (m), of a file with positions
            from -100 to 100; empty for other files.
        wrench: whether to read the wrench of a sensor, without which the log is refused; torques
            may then be missing, and are zero.
        open_windings: whether the windings of the drives are open: the torques are zero.
    """

    columns: Mapping[str, str] | str = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    topic: str = ""
    start: float | None = None
    until: float | None = None
    mask: tuple[str, ...] = ()
    unit: Mapping[str, str] = field(default_factory=dict)
    time_unit: str = ""
    separator: str = ""
    decimal: str = ""
    header: bool = True
    range: tuple[tuple[float, float], ...] = ()
    wrench: bool = False
    open_windings: bool = False

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            LogError: an unknown column, mask or unit, a repeated name, an empty span of time, a
                separator of several characters, or an invalid decimal mark.
        """
        if isinstance(self.columns, str):
            object.__setattr__(self, "columns", columns_from(self.columns))
        for column, unit in self.unit.items():
            known = not column or column in ROLES[1:] or NUMBERED.fullmatch(column)
            if not (known and (column or unit in ANGLES)):
                accepted = "deg, rad, or pairs such as q=deg,qd=rad/s,tau2=mNm"
                raise LogError(f"--unit {column}={unit}: accepted: {accepted}".replace(" =", " "))
        if self.time_unit and self.time_unit not in TIME_UNITS:
            raise LogError(f"--time-unit {self.time_unit}: accepted: {', '.join(TIME_UNITS)}")
        if len(self.separator) > 1 or self.separator in ('"', ".", "\n", "\r"):
            raise LogError(f"--separator {self.separator!r}: accepted: ';', ',' or tab")
        if self.decimal not in ("", ".", ",") or (self.decimal and self.decimal == self.separator):
            accepted = "'.' or ',', and not the separator"
            raise LogError(f"--decimal {self.decimal!r}: accepted: {accepted}")
        for ours in self.pairs:
            known = ours in (*ROLES, *NAMED) or NUMBERED.fullmatch(ours)
            if not (known or _OF_FRAME.fullmatch(ours)):
                raise LogError(f"--columns: {ours!r} is no column of a log; accepted: {_ROLES}")
        for what, values in (("--columns", self.pairs.values()), ("--joints", self.joints)):
            names = list(values)
            twice = [name for name in names if names.count(name) > 1]
            if twice or not all(names):
                why = f"{twice[0]!r} is given twice" if twice else "an empty name"
                raise LogError(f"{what}: {why}; accepted: every name once")
        for word in self.mask:
            if word not in MASKS:
                raise LogError(f"--mask: {word!r}; accepted: {', '.join(MASKS)}")
        if any(s is not None and not abs(s) < np.inf for s in (self.start, self.until)):
            raise LogError("--from, --until: accepted: finite times in s")
        low, high = self.span
        if not low < high:
            raise LogError(f"--from {low:g} --until {high:g}: accepted: a span above 0 s")

    @property
    def pairs(self) -> Mapping[str, str]:
        """Log column -> column of the file."""
        assert not isinstance(self.columns, str)
        return self.columns

    def over(self, log: LogForm) -> Reading:
        """Return these options, completed with [log] of a robot file."""
        chosen = {key: value for key, value in vars(self).items() if value}
        unit, separator = units_from(log.unit), separator_of(log.separator)
        header = self.header and log.header
        return Reading(
            **(vars(log) | {"unit": unit, "separator": separator} | chosen | {"header": header})
        )

    @property
    def span(self) -> tuple[float, float]:
        """First and last time to use, s."""
        low = -np.inf if self.start is None else self.start
        return low, np.inf if self.until is None else self.until


def roles_with_unit(reading: Reading) -> set[str]:
    """Return the roles whose unit the user set."""
    every = {"q", "qd", "qs", "qr", "qdr"} if "" in reading.unit else set[str]()
    return every | {*map(role_of, reading.unit)}


def role_of(column: str) -> str:
    """Return the role of a log column: q for q1."""
    return column.rstrip("0123456789")


@dataclass(frozen=True)
class Wanted:
    """What to read from a table, and for which robot.

    Attributes:
        reading: names of columns. The row number of a pose replaces its t.
        drive: drive of the robot. If it has torque constants, currents may replace torques.
        joints: names of the movable joints; they may be empty.
        n: number of movable joints, or None if unknown.
        sigma: types of the movable joints; empty if all are revolute.
        fixed: numbers of the fixed joints.
        fixes: the value of `import --fix` that holds each movable joint.
        frames: names of the frames of a robot with a floating base.
        contacts: names of those where it may touch its surroundings.
    """

    reading: Reading
    drive: Drive | None = None
    joints: Sequence[str] = ()
    n: int | None = None
    sigma: Sequence[int] = ()
    fixed: Collection[int] = ()
    fixes: Sequence[str] = ()
    frames: Sequence[str] = ()
    contacts: Sequence[str] = ()

    def __post_init__(self) -> None:
        if self.sigma:
            if self.n not in (None, len(self.sigma)):
                raise ValueError(f"sigma has {len(self.sigma)} entries for {self.n} joints")
            object.__setattr__(self, "n", len(self.sigma))

    def kept(self, width: int) -> list[int]:
        """Return the columns, from 0, of the movable joints; empty if there are too many or few.

        A log with a column for each joint of the file has columns of fixed joints too.
        """
        fixed = () if self.n in (None, width) else self.fixed
        kept = [k for k in range(width) if k + 1 not in fixed]
        return kept if self.n in (None, len(kept)) else []

    @property
    def framed(self) -> dict[str, tuple[str, int]]:
        """Role and number of the columns of frames, such as foot.fx."""
        ends = [f"{frame}.{end}" for frame in self.frames for end in WRENCH_ENDS]
        flags = [f"{frame}.{CONTACT_END}" for frame in self.contacts]
        out = {column: ("forces", k) for k, column in enumerate(ends, 1)}
        return out | {column: ("touches", k) for k, column in enumerate(flags, 1)}

    @property
    def currents(self) -> bool:
        """Whether currents are read."""
        return self.drive is not None and self.drive.torque_constant is not None


def wanted_by(robot: Robot, reading: Reading) -> Wanted:
    """Return what to read for a robot."""
    frames = [frame.name for frame in robot.frames] if robot.floating else []
    contacts = [contact.frame for contact in robot.contacts]
    return Wanted(
        reading, robot.drive, robot.joint_names, robot.n, robot.sigma, robot.fixed, robot.fixes,
        frames, contacts,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Raw:
    """The unchecked content of a log file. Its names are plain text, safe for a terminal.

    Attributes:
        arrays: role -> array of the file, t first. tau or i may be absent. qs is (N, n), with
            NaN for joints that have none.
        drive_unit: unit of u, "duty" or "V".
        ignored: the other columns of the file.
        notes: how the file was read.
        names: log column ("q1") -> column of the file, for messages.
        converted: columns in another unit: (columns, unit and its source, conversion).
    """

    arrays: Mapping[str, npt.NDArray[Any]]
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    converted: tuple[tuple[str, str, str], ...] = ()
    drive_unit: str = "duty"

    def __post_init__(self) -> None:
        """Make names of the file plain."""
        object.__setattr__(self, "ignored", tuple(map(plain, self.ignored)))
        object.__setattr__(self, "notes", tuple(map(plain, self.notes)))
        converted = tuple(tuple(map(plain, entry)) for entry in self.converted)
        object.__setattr__(self, "converted", converted)


@dataclass(frozen=True, eq=False, kw_only=True)
class Additions:
    """What a log may have besides times, positions, speeds and torques; arrays are read-only.

    Attributes:
        qs: (N, n) link positions in rad (m), measured behind the elasticity of the joint, NaN for
            joints without a second encoder; or None. [drive] does not convert them.
        command: (N, n) part of tau from the reference, N m (N), if tau comes from the gains of the
            controller; or None.
        imu: (N, 6) motion of the base as in IMU, or None.
        duty: (N, n) duty of the drives, -1 to 1, or their voltage in V, as recorded; on the joint
            side the input in drive_unit, which drives hold from its stamp; or None.
        drive_unit: unit of tau if it is the input of the drives, "duty" or "V"; "" for torques in
            N m. Before `joint_side`, it is the unit of duty.
        wrench: (N, 6) wrench on the tool as in WRENCH, or None.
        pose: (N, 7) pose of the base as in POSE, or None.
        forces: (N, 6 F) wrench of the world on F frames of a robot with a floating base, in file
            order: force, N, and moment about the origin of the frame, N m, in its axes. NaN for
            frames without; or None.
        touches: (N, C) whether the robot touches its surroundings at its contacts, 0 or 1; NaN for
            contacts without a column; or None.
        up: (N, 3) direction against gravity in the axes of the base, if it has round feet; None
            before `open_log`.
        robot: the robot, if its base moves; None before `open_log`.
    """

    qs: FloatArray | None = None
    command: FloatArray | None = None
    imu: FloatArray | None = None
    duty: FloatArray | None = None
    drive_unit: str = ""
    wrench: FloatArray | None = None
    pose: FloatArray | None = None
    forces: FloatArray | None = None
    touches: FloatArray | None = None
    up: FloatArray | None = None
    robot: Robot | None = None


@dataclass(frozen=True, eq=False)
class Log(Additions):
    """One measured log. All arrays are read-only float64.

    If the robot has a [drive], a recorded log is on the motor side until `joint_side` converts it;
    `mapped` is then true. Without a [drive], both sides are the same.

    Attributes:
        name: file name without its folder.
        t: (N,) time in s, strictly increasing.
        q: (N, n) positions in rad (m for a prismatic joint).
        qd: (N, n) measured velocities in rad/s (m/s), or None.
        tau: (N, n) torques in N m (forces in N), or None if the log has currents or a reference
            instead.
        ignored: columns of the file that are not used.
        current: (N, n) motor currents in A, or None.
        notes: changes to the log, one line each.
        mapped: whether q, qd and tau are on the joint side.
        qr, qdr: (N, n) reference of the controller in rad (m) and rad/s (m/s), or None.
        missing: (N, n, 3) values of q, qd and tau (or i, u) that are missing in the file and
            interpolated; or None.
        converted: as in `Raw`.
        supply: (N, 1) recorded voltage of the supply, V; or None.
    """

    name: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray | None
    tau: FloatArray | None
    ignored: tuple[str, ...] = ()
    current: FloatArray | None = None
    notes: tuple[str, ...] = ()
    mapped: bool = False
    qr: FloatArray | None = None
    qdr: FloatArray | None = None
    missing: Bools | None = None
    converted: tuple[tuple[str, str, str], ...] = ()
    supply: FloatArray | None = None


def require_shapes(arrays: Mapping[str, Any]) -> None:
    """Check types and shapes of the arrays of a log.

    Args:
        arrays: role -> array.

    Raises:
        LogError: t is not (N,), another array is not (N, n) or (N,), or one is not numeric.
    """
    samples = arrays["t"].shape
    for role, array in arrays.items():
        if array.dtype.kind not in ("iufM" if role == "t" else "iuf"):
            refuse(f"{role} holds {array.dtype}", "floats or integers")
        if role == "t" and len(samples) != 1:
            refuse(f"t has the shape {samples}", "t (N,)")
        matrix = (*array.shape, 1)[:2] if len(array.shape) < 3 else ()
        if role != "t" and (len(array.shape) == 0 or matrix[:1] != samples or matrix[1] == 0):
            what = f"{role} has the shape {array.shape}, and t has {samples[0]} samples"
            refuse(what, f"{role} ({samples[0]}, n)")
    counts = {role: (*x.shape, 1)[1] for role, x in arrays.items() if role != "t"}
    for role, count in counts.items():
        if columns := VECTORS.get(role):
            if count != len(columns):
                refuse(f"columns of {role}: {count}", f"{len(columns)}: {', '.join(columns)}")
        elif role not in FRAMED and count != counts.get("q"):
            what = f"columns of q: {counts.get('q', 0)}, of {role}: {count}"
            refuse(what, "as many of q and tau, and of what else there is")


def listed(names: Sequence[str]) -> str:
    """Return the first names of a file as text."""
    return first_of([*filter(None, names)], 12) or "none"


def shown(column: str, names: Mapping[str, str]) -> str:
    """Return a column for a message, with its name in the file."""
    name = names.get(column, column)
    return column if name == column else f"{plain(name[:80])} ({column})"


def refuse(what: str, accepted: str) -> NoReturn:
    """Refuse a log; `located` adds its name.

    Args:
        what: what happened.
        accepted: what helps. Of options in double quotes, a shell would change $, ` and \\: those
            with one get single quotes.

    Raises:
        LogError: always.
    """
    typed = _CHANGED.sub(lambda option: quote(option[1]), accepted)
    raise LogError(f"{what}; accepted: {typed}")


@contextmanager
def readable(what: str, accepted: str) -> Iterator[None]:
    """Turn any exception of a library that reads files into a LogError."""
    try:
        yield
    except SymgenError:
        raise
    except Exception as error:  # each library has many kinds
        refuse(f"{what}: {error or type(error).__name__}", accepted)


def unused_torques(present: Iterable[str], wanted: Wanted) -> set[str]:
    """Return the channels that a log does not use, because another one gives the torques.

    Args:
        present: roles of the channels in the file.
        wanted: names of columns, and the drive, without whose constants currents give no torques.

    Raises:
        LogError: the log has currents alone without their constants, or duty and torques or
            currents, of which the user does not name one.
    """
    driving = DRIVING.intersection(present)
    if driving == {"i"} and not wanted.currents:
        what = "the torque columns tau1.. are missing, and motor currents i1.. need their constants"
        refuse(what, f"torque_constant in [drive] of the robot file, or {COLUMNS}")
    useless = set[str]() if wanted.currents else {"i"}.intersection(driving)
    found = sorted(driving & TORQUES - useless)
    if "u" not in found or len(found) == 1:
        return useless
    chosen = {*map(role_of, wanted.reading.pairs)}.intersection(found)
    if len(chosen) != 1:
        what = f"the log has {' and '.join(found)} of its joints, and only one gives the torques"
        refuse(what, " or ".join(f"--columns {role}=.." for role in found))
    return useless.union(found) - chosen


def require_size(path: Path, announced: int) -> None:
    """Refuse a file whose unpacked size is far above its size on the disk.

    Noise limits the compression of measured signals to a small factor. A larger factor indicates a
    file made to exhaust memory.

    Args:
        path: the file.
        announced: unpacked size that the file announces, bytes.

    Raises:
        LogError: the announced size is too large.
    """
    stored = path.stat().st_size
    if announced > _UNPACKED + _PACKING * stored:
        what = f"would unpack from {stored / 1e6:.3g} MB to {announced / 1e6:.3g} MB"
        refuse(what, f"at most {_PACKING} times the size on the disk and {_UNPACKED >> 20} MB")


def csv_bytes(names: Sequence[str], rows: FloatArray, digits: int = 9) -> bytes:
    """Return the content of a CSV with named columns of rows (N, c)."""
    out = io.BytesIO()
    np.savetxt(out, rows, f"%.{digits}g", ",", header=",".join(names), comments="")
    return out.getvalue()


def read_only(array: npt.ArrayLike) -> FloatArray:
    """Return a read-only float64 copy of an array, or the array itself if it is one already."""
    if (
        isinstance(array, np.ndarray)
        and array.dtype == np.float64
        and array.flags.forc
        and array.flags.owndata
        and not array.flags.writeable
    ):
        return array
    # An extended double beyond the range becomes inf; the checks report it.
    with np.errstate(over="ignore"):
        copy = np.array(array, dtype=np.float64, order="C")
    copy.setflags(write=False)
    return copy
