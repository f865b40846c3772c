"""What a file of measurements held, before any check of its values, and how it is to be read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from symgen.errors import LogError, plain

FloatArray = npt.NDArray[np.float64]

#: Names of columns: t, q1.., qd1.., tau1.., i1..; and those that some joints alone may have.
NUMBERED = re.compile(r"(qd|qs|q|tau|i|temp)(0|[1-9][0-9]*)")
ROLES = ("t", "q", "qd", "tau", "i", "temp", "qs")
#: What is measured beside the motion: temperatures, and positions behind an elastic joint.
BESIDE = ("temp", "qs")
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
        span = (self.start, self.until)
        if any(s is not None and not abs(s) < float("inf") for s in span):
            raise LogError("--from, --until: accepted: finite times in s")
        if self.start is not None and self.until is not None and not self.start < self.until:
            raise LogError(
                f"--from {self.start:g} --until {self.until:g}: accepted: a span above 0 s"
            )


@dataclass(frozen=True, eq=False)
class Raw:
    """What a file held. Arrays as in the file; tau or i is None where there is none.

    `temp` and `qs` are (N, n) with NaN on joints that have none. `notes` says what was done to read
    it. What a terminal will show is plain text.
    """

    t: npt.NDArray[Any]
    q: npt.NDArray[Any]
    qd: npt.NDArray[Any] | None
    tau: npt.NDArray[Any] | None
    i: npt.NDArray[Any] | None = None
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    temp: npt.NDArray[Any] | None = None
    qs: npt.NDArray[Any] | None = None

    def __post_init__(self) -> None:
        """Make names of the file plain."""
        object.__setattr__(self, "ignored", tuple(map(plain, self.ignored)))
        object.__setattr__(self, "notes", tuple(map(plain, self.notes)))


def one_line(message: str) -> str:
    """Return a message without line breaks."""
    return " ".join(message.splitlines())


def refuse(file: str | Path, what: str, accepted: str) -> NoReturn:
    """Refuse a log.

    Raises:
        LogError: always.
    """
    raise LogError(one_line(f"{file}: {what}; accepted: {accepted}"))


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
        refuse(
            path, what, f"at most {_PACKING} times the size on the disk and {_UNPACKED >> 20} MB"
        )


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
