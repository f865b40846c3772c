"""What a file of measurements held, before any check of its values, and how it is to be read."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt

from symgen.errors import LogError, SymgenError, plain

if TYPE_CHECKING:
    from symgen.robot.types import Drive

FloatArray = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
#: Numbers of samples.
Places = npt.NDArray[np.int64]

#: Names of columns: t, q1.., qd1.., tau1.., i1..; and those that some joints alone may have.
NUMBERED = re.compile(r"(qd|qs|q|tau|i|temp)(0|[1-9][0-9]*)")
ROLES = ("t", "q", "qd", "tau", "i", "temp", "qs")
#: What is measured beside the motion: temperatures, and positions behind an elastic joint.
BESIDE = ("temp", "qs")
#: What a table has, and what an NPZ.
COLUMNS = "t, q1.., optional qd1.., tau1.."
KEYS = "t (N,), q (N, n), tau (N, n), optional qd (N, n)"
#: What a file may unpack to: bytes, and times its size on the disk.
_UNPACKED, _PACKING = 256 << 20, 20
MASKS = ("rest", "saturation")
_ROLES = (
    "t, q1.., qd1.., tau1.., i1.., temp1.., qs1.. (t, q, qd, tau, i, temp, qs for NPZ; q, qd, tau, "
    "i for a bag)"
)


@dataclass(frozen=True)
class Reading:
    """How logs are read; the same for every log of a command.

    Attributes:
        columns: names in the file of our columns, {"t": "time", "q1": "shoulder"}, or a pattern
            with * for the joint, {"q": "*_position"}; in a bag the field of the message,
            {"i": "effort"}.
        joints: names of the robot's movable joints in the messages of a bag, in the robot's order;
            empty to take those of the robot.
        topic: of the messages in a bag, "" where only one topic has joint states.
        start, until: the part of each log that is used, in s of its column t, None for all.
        mask: what no equation may touch, any of "rest" and "saturation".
        poses: whether rows are still poses: t is not needed and not used, and qd is the direction
            in which each joint moved last.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    topic: str = ""
    start: float | None = None
    until: float | None = None
    mask: tuple[str, ...] = ()
    poses: bool = False

    def __post_init__(self) -> None:
        """Refuse what no log could be read with.

        Raises:
            LogError: an unknown column or mask, a name given twice, or an empty span of time.
        """
        for ours in self.columns:
            if ours not in ROLES and NUMBERED.fullmatch(ours) is None:
                raise LogError(f"--columns: {ours!r} is no column of a log; accepted: {_ROLES}")
        for what, given in (("--columns", self.columns.values()), ("--joints", self.joints)):
            names = list(given)
            twice = [name for name in names if names.count(name) > 1]
            if twice or not all(names):
                fault = f"{twice[0]!r} is given twice" if twice else "an empty name"
                raise LogError(f"{what}: {fault}; accepted: every name once")
        for word in self.mask:
            if word not in MASKS:
                raise LogError(f"--mask: {word!r}; accepted: {', '.join(MASKS)}")
        if any(s is not None and not abs(s) < np.inf for s in (self.start, self.until)):
            raise LogError("--from, --until: accepted: finite times in s")
        low, high = self.span
        if not low < high:
            raise LogError(f"--from {low:g} --until {high:g}: accepted: a span above 0 s")

    @property
    def span(self) -> tuple[float, float]:
        """First and last time that is used, s."""
        low = -np.inf if self.start is None else self.start
        return low, np.inf if self.until is None else self.until


@dataclass(frozen=True)
class Wanted:
    """What is read of a table, and for which robot.

    Attributes:
        reading: names of columns; the number of a still pose is taken for its t.
        drive: of the robot; with torque constants, currents i1.. may stand in place of torques.
        joints: what the robot calls its movable joints; texts may be empty.
        n: their number, None where it is not known.
        beside: whether temperatures and positions of links are read, too.
    """

    reading: Reading
    drive: Drive | None = None
    joints: Sequence[str] = ()
    n: int | None = None
    beside: bool = True

    @property
    def currents(self) -> bool:
        """Whether currents are read."""
        return self.drive is not None and self.drive.torque_constant is not None


@dataclass(frozen=True, eq=False)
class Raw:
    """What a file held. What a terminal will show is plain text.

    Attributes:
        arrays: by role, as in the file, t first; tau or i may be absent, temp and qs are (N, n)
            with NaN on joints that have none.
        ignored: the other columns of the file.
        notes: what was done to read it.
    """

    arrays: Mapping[str, npt.NDArray[Any]]
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Make names of the file plain."""
        object.__setattr__(self, "ignored", tuple(map(plain, self.ignored)))
        object.__setattr__(self, "notes", tuple(map(plain, self.notes)))


@dataclass(frozen=True, eq=False)
class Log:
    """One measured log. All arrays are read-only float64; C-contiguous, but in a chunk of Parquet.

    It is as it was recorded, on the motor side where the robot has a [drive], until `joint_side`
    has mapped it, which `mapped` tells; without a [drive] both are the same.

    Attributes:
        name: file name without its folder.
        t: (N,) time in s, strictly increasing.
        q: (N, n) positions in rad (m for a prismatic joint).
        qd: (N, n) measured velocities in rad/s (m/s), None when the log has none.
        tau: (N, n) torques in N m (forces in N), None when the log has currents in their place.
        ignored: the other columns of the file, which nothing reads.
        current: (N, n) motor currents in A, None where none are used.
        notes: what was done to the log, in words, one line each.
        mapped: whether q, qd and tau have been mapped to the joint side.
        temp: (N, n) temperatures of joints or their motors, deg C, NaN on joints without; or None.
        qs: (N, n) positions of links, behind what bends in the joint, in rad (m), NaN on joints
            without a second encoder; or None. They are never mapped by [drive].
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
    temp: FloatArray | None = None
    qs: FloatArray | None = None


def require_shapes(arrays: Mapping[str, Any]) -> None:
    """Refuse arrays whose types or shapes are not those of a log.

    Args:
        arrays: by role.

    Raises:
        LogError: t is not (N,), another not (N, n) or (N,), or one holds no numbers.
    """
    samples = arrays["t"].shape
    for role, array in arrays.items():
        if array.dtype.kind not in "iuf":
            refuse(f"{role} holds {array.dtype}", "floats or integers")
        if role == "t" and len(samples) != 1:
            refuse(f"t has the shape {samples}", "t (N,)")
        matrix = (*array.shape, 1)[:2] if len(array.shape) < 3 else ()
        if role != "t" and (len(array.shape) == 0 or matrix[:1] != samples or matrix[1] == 0):
            what = f"{role} has the shape {array.shape}, and t has {samples[0]} samples"
            refuse(what, f"{role} ({samples[0]}, n)")
    counts = {role: (*x.shape, 1)[1] for role, x in arrays.items() if role != "t"}
    for role, count in counts.items():
        if count != counts["q"]:
            what = f"columns of q: {counts['q']}, of {role}: {count}"
            refuse(what, "as many of q and tau, and of what else there is")


def listed(names: Sequence[str]) -> str:
    """Return the first names of a file in words."""
    named = [name for name in names if name]
    return (", ".join(named[:12]) + (", .." if len(named) > 12 else "")) or "none"


def refuse(what: str, accepted: str) -> NoReturn:
    """Refuse a log; `located` says which.

    Raises:
        LogError: always.
    """
    raise LogError(f"{what}; accepted: {accepted}")


@contextmanager
def readable(what: str, accepted: str) -> Iterator[None]:
    """Refuse what a library cannot read, whatever it raises."""
    try:
        yield
    except SymgenError:
        raise
    except Exception as error:  # each has a dozen kinds
        refuse(f"{what}: {error or type(error).__name__}", accepted)


def refuse_currents() -> NoReturn:
    """Refuse currents without what makes torques of them.

    Raises:
        LogError: always.
    """
    refuse(
        "the torque columns tau1.. are missing, and motor currents i1.. need torque_constant in "
        "[drive] of the robot file",
        COLUMNS,
    )


def require_size(path: Path, announced: int) -> None:
    """Refuse a file that would unpack to far more than it takes on the disk.

    Measured signals hold noise and pack a few times at most; so much more is made to fill memory.

    Args:
        path: the file.
        announced: bytes of what it says that it holds.

    Raises:
        LogError: it would.
    """
    stored = path.stat().st_size
    if announced > _UNPACKED + _PACKING * stored:
        what = f"would unpack from {stored / 1e6:.3g} MB to {announced / 1e6:.3g} MB"
        refuse(what, f"at most {_PACKING} times the size on the disk and {_UNPACKED >> 20} MB")


def read_only(array: npt.ArrayLike) -> FloatArray:
    """Return a read-only float64 copy of an array; itself where it is one, in rows or columns."""
    if (
        isinstance(array, np.ndarray)
        and array.dtype == np.float64
        and array.flags.forc
        and array.flags.owndata
        and not array.flags.writeable
    ):
        return array
    # An extended double beyond the range becomes inf, which the checks then name.
    with np.errstate(over="ignore"):
        copy = np.array(array, dtype=np.float64, order="C")
    copy.setflags(write=False)
    return copy
