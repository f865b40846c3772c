"""A fault of a recorder: its kind, place, size, and how to undo it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Annotated

from symgen.schemas import BESIDE, OrNan, at

#: Kind of a unit conversion, which is not a fault but is listed with them.
CONVERTED = "converted"
#: Text for a fault that is not corrected.
LEFT = "left as it is"
#: Channel of all readings of an IMU.
IMU = "imu"
#: Log name of a fault in all logs.
EVERYWHERE = "all logs"


@dataclass(frozen=True)
class Fault:
    """A fault of the channels of a log, and its correction.

    Attributes:
        log: name of the log, or EVERYWHERE.
        channel: "t", "q2", "tau2, tau4", "tau" for all joints, or "all".
        why: text with the value.
        samples: number of affected samples; 0 for complete columns.
        done: text on the correction.
        values: name, value and standard deviation of measured quantities. Speeds are (1 + GV)
            dq/dt, delayed by LV s, with an offset OV. Torques, or the IMU, were delayed by DT s and
            are shifted. `limit` is that of a clipped torque.
        kind: kind of the fault, for programs, such as "converted" of a column in other units.
        gap_reduction: share of the squared torque error that the correction removes; NaN if it is
            unknown.
        value, std: value and standard deviation of the first of `values`; NaN without values.
        joints: indices of the joints; empty for all.
    """

    log: str
    channel: str
    why: Annotated[str, at("fault")]
    samples: int = 0
    done: str = LEFT
    values: tuple[tuple[str, float, OrNan], ...] = ()
    kind: str = field(default="", compare=False)
    gap_reduction: OrNan = field(default=math.nan, compare=False)
    value: OrNan = field(init=False, compare=False)
    std: OrNan = field(init=False, compare=False)
    joints: Annotated[tuple[int, ...], BESIDE] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        first = self.values[0] if self.values else ("", math.nan, math.nan)
        object.__setattr__(self, "value", first[1])
        object.__setattr__(self, "std", first[2])

    @property
    def in_words(self) -> str:
        """The fault in one line."""
        samples = f", {self.samples} samples" if self.samples else ""
        return f"{self.log}: {self.channel}: {self.why}{samples}: {self.done}"


def delay_of(fault: Fault) -> float:
    """Return the shift DT of the torques of all joints, s; 0 if they are not shifted."""
    return sum(value for name, value, _ in fault.values if name == "DT")


def shifted_torques(channel: str, delay: float, std: float = math.nan, who: str = "") -> Fault:
    """Return the repair of late torques in all logs.

    Args:
        channel: "tau" for all joints, or "tau2, tau4".
        delay: s by which they are late.
        std: its standard deviation.
        who: text with the joints.
    """
    word = "late" if delay > 0 else "early"
    joints = who or ("all joints" if channel == "tau" else channel)
    text = f"the torques of {joints} are {1e3 * abs(delay):.3g} ms {word} against the motion"
    values = (("DT", delay, std),)
    return Fault(EVERYWHERE, channel, text, done="shifted", values=values, kind="delay")


def shifted_imu(delay: float, std: float = math.nan) -> Fault:
    """Return the repair of an IMU that is late by `delay` s, with its standard deviation."""
    word = "late" if delay > 0 else "early"
    text = f"the IMU is {1e3 * abs(delay):.3g} ms {word} against the torques and forces"
    values = (("DT", delay, std),)
    return Fault(EVERYWHERE, IMU, text, done="shifted", values=values, kind="delay")


def torques_of(fault: Fault) -> list[int] | None:
    """Return the positions of the torque channels of a fault; None for all."""
    if fault.channel == "tau":
        return None
    return [int(name.removeprefix("tau")) - 1 for name in fault.channel.split(", ")]


def merge_faults(faults: Iterable[Fault]) -> list[Fault]:
    """Return one fault for each log, channel and kind, from the faults of several segments.

    Numbers differ slightly between segments; those of the first segment are kept.
    """
    out: dict[tuple[str, str, str], Fault] = {}
    for f in faults:
        known = out.get((f.log, f.channel, f.kind))
        samples = f.samples + (known.samples if known else 0)
        out[f.log, f.channel, f.kind] = replace(known or f, samples=samples)
    return list(out.values())
