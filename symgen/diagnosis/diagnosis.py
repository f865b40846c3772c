"""The result of a diagnosis: gap before and after, joints with a gap, and effects that close it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from symgen.errors import ParameterError
from symgen.estimation.band import Band
from symgen.estimation.torque_error import percent
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.faults.mended import MendedChannel
from symgen.identification.estimate import Estimate
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.schemas import (
    BESIDE,
    OPTIONAL,
    OrNan,
    Size,
    SizeOrNan,
    at,
    from_json,
    read_json,
    result_file,
    to_json,
)
from symgen.views import Viewable

MARKER = "diagnosis.json"
SCHEMA = "symgen.diagnosis/1"
VERDICTS = ("consistent", "explained", "partly-explained", "unexplained", "bad-measurement")


@dataclass(frozen=True)
class Gap:
    """RMS of measured minus modelled torque, divided by the RMS of measured torque.

    This is the torque error of `identify`, in the comparison band, per joint and over all joints
    stacked.

    Attributes:
        per_joint: of each joint.
        total: over all joints; on a floating base, the largest of the three below.
        base_force, base_moment, joints: of the forces on a floating base, of the moments on it, and
            of the joints; None for other bases.
    """

    per_joint: tuple[SizeOrNan, ...]
    total: SizeOrNan
    base_force: Annotated[SizeOrNan | None, OPTIONAL] = None
    base_moment: Annotated[SizeOrNan | None, OPTIONAL] = None
    joints: Annotated[SizeOrNan | None, OPTIONAL] = None

    @property
    def parts(self) -> tuple[float, ...]:
        """Those of the joints, then those of the forces and of the moments on a floating base."""
        of_base = (x for x in (self.base_force, self.base_moment) if x is not None)
        return (*self.per_joint, *of_base)


@dataclass(frozen=True)
class Gaps:
    """The gap of the declared model, the gap of the extended model, and the noise floor."""

    before: Gap
    after: Gap
    noise_floor: Gap


@dataclass(frozen=True)
class FoundParameter:
    """A coefficient or a constant of an effect; std is NaN if it is unknown."""

    name: str
    value: OrNan
    std: SizeOrNan
    unit: str


class Alike(NamedTuple):
    """An effect that these data cannot distinguish from another one."""

    name: str
    joints: tuple[int, ...]


@dataclass(frozen=True)
class FoundEffect:
    """One effect that the search accepts.

    Attributes:
        name: name in the library or in the robot file, or "unnamed".
        joints: joint numbers in the robot file; empty for an effect on all joints.
        parameters: coefficients and constants, with units and standard deviations.
        expression: the torque ON the joint.
        p_value: p-value of the most significant coefficient, corrected for their number.
        gap_reduction: share of the squared gap on its joints that the effect closes.
        indistinguishable_from: (name, joints) of effects that these data cannot distinguish from
            it.
        separate: the motion that would distinguish them.
        declared: whether the extended robot.toml and its C code contain the effect.
        probability: probability that this effect, or one that the data cannot distinguish from it,
            is present.
        torque_rms: RMS of its torque on its joint, N m or N.
        adopted: whether it holds in the fit of `identify`. The extended robot contains only
            adopted effects.
        shown: whether it is shown as the cause, because it removes at least half of its joint's
            error above the noise floor.
    """

    name: str
    joints: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    expression: str
    p_value: SizeOrNan
    gap_reduction: OrNan
    indistinguishable_from: tuple[Alike, ...] = ()
    separate: str = ""
    declared: Annotated[bool, at("in_robot_toml")] = True
    probability: Size = 1.0
    torque_rms: SizeOrNan = np.nan
    adopted: bool = True
    shown: bool = False


@dataclass(frozen=True)
class Place:
    """A joint with a gap, its share of the gap, and the pattern of its residual.

    `time_window` is the span of a contact on the joint, in s; None if there is no contact.
    """

    joint: int
    share: Size
    pattern: str
    time_window: tuple[float, float] | None = None


@dataclass(frozen=True)
class Rejected:
    """A candidate that is not adopted, and the reason."""

    name: str
    joints: tuple[int, ...]
    reason: str


@dataclass(frozen=True, eq=False)
class Curves:
    """Torques (K, n) and motion (K, n) of one validation log, in the comparison band.

    `residuals` are measured minus modelled torque before and after, NaN at samples that do not
    count: the user masked them or, after, they are a part of a contact. Before, the measured torque
    is that of the log as read; `measured` is without the adopted faults of the recorder.
    """

    name: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray
    residuals: tuple[FloatArray, FloatArray]


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(Viewable):
    """The result of `diagnose`.

    Attributes:
        robot: name of the robot.
        verdict: one of VERDICTS.
        cutoff_hz: cutoff of the low-pass for all torques, Hz; None if no low-pass fits.
        metric: the quantity that the gap measures: "torque".
        before, after, floor: torque error that `identify` prints of the declared and of the
            extended robot, and noise floor, on held-out data.
        moving: the same for joints in motion; None in an older file.
        corrected: the gap after of joints in motion, with effects that no robot file can hold; None
            if there are none.
        trusted: whether `identify` trusts the extended robot on these logs; None with fixed
            parameters.
        where: joints with a gap, the largest share first; empty if consistent.
        effects: the effects, the largest share in closing the gap first.
        rejected: the most probable of the other candidates.
        advice: what to do next.
        notes: changes of the logs, and effects that the extended robot does not contain.
        extended: the robot with the effects added.
        joints: joint numbers of the movable joints.
        curves: torques of the validation logs, for plots.
        tried: number of candidates.
        parameters: base parameters of the extended robot, in the order of X.
        declared: the robot as its file declares it.
        values: base parameters X of the declared model.
        repairs: repairs of the logs, as `identify` makes them; they are no effects.
        digests: SHA-256 of the other files of the result folder.
        mended: the channels that repairs changed most, for plots.
        band: filters of the logs.
        command: the command to run next; "" if there is none.
        estimates: what `identify` finds for the declared and for the extended robot on these logs;
            () with fixed parameters.
    """

    GONE: ClassVar = ("replay", "free_functions", "energy")

    robot: str
    verdict: str
    cutoff_hz: float | None
    metric: Annotated[Literal["torque"], at("gap.metric")] = "torque"
    before: Annotated[Gap, at("gap.before")]
    after: Annotated[Gap, at("gap.after")]
    floor: Annotated[Gap, at("gap.noise_floor")]
    moving: Annotated[Gaps | None, at("gap.in_motion"), OPTIONAL] = None
    corrected: Annotated[Gap | None, at("gap.after_with_log_effects", missing=True), OPTIONAL] = (
        None
    )
    trusted: Annotated[bool | None, OPTIONAL] = None
    where: tuple[Place, ...]
    effects: tuple[FoundEffect, ...]
    rejected: tuple[Rejected, ...]
    tried: Annotated[int, at("candidates_tried")] = 0
    advice: tuple[str, ...]
    notes: tuple[str, ...]
    parameters: tuple[FoundParameter, ...] = ()
    repairs: tuple[Fault, ...] = ()
    digests: Annotated[dict[str, str] | None, OPTIONAL] = None
    extended: Annotated[Robot, BESIDE]
    joints: Annotated[tuple[int, ...], BESIDE]
    curves: Annotated[tuple[Curves, ...], BESIDE] = ()
    declared: Annotated[Robot | None, BESIDE] = None
    values: Annotated[tuple[float, ...], BESIDE] = ()
    mended: Annotated[tuple[MendedChannel, ...], BESIDE] = ()
    band: Annotated[Band | None, BESIDE] = None
    command: Annotated[str, BESIDE] = ""
    estimates: Annotated[tuple[Estimate, ...], BESIDE] = ()

    def __repr__(self) -> str:
        """Return robot, verdict and the gap before and after."""
        return (
            f"<Diagnosis of {self.robot}: {self.verdict}, torque error "
            f"{percent(self.gaps.before.total)} to {percent(self.gaps.after.total)}>"
        )

    @property
    def gaps(self) -> Gaps:
        """The gaps of joints in motion; those of all samples if the file does not have them."""
        return self.moving or Gaps(self.before, self.after, self.floor)

    @property
    def good(self) -> bool:
        """Whether `identify` trusts the extended robot; with fixed parameters, by the verdict."""
        if self.trusted is None:
            return self.verdict in ("consistent", "explained")
        return self.trusted

    @property
    def is_better(self) -> bool:
        """Whether the extended robot has an effect that its file did not declare."""
        return any(effect.declared and effect.adopted for effect in self.effects)

    def to_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json (schema symgen.diagnosis/1)."""
        return to_json(self, SCHEMA)


def read_diagnosis(path: str | Path) -> Diagnosis:
    """Read a diagnosis from diagnosis.json and the extended robot.toml in the same folder.

    The files do not contain the curves over time, so `curves` is empty.

    Args:
        path: the folder that `diagnose` wrote, or the diagnosis.json in it.

    Raises:
        ParameterError: the file does not exist or is damaged.
        RobotError: symgen cannot read the robot.toml.
    """
    file = result_file(path, MARKER)
    content, extended = read_json(file, SCHEMA), read_robot(file.with_name("robot.toml"))
    joints = tuple(j.number for j in extended.movable)
    diagnosis = from_json(Diagnosis, content, file, extended=extended, joints=joints)
    if diagnosis.verdict not in VERDICTS:
        raise ParameterError(
            f"{file}: damaged at verdict {diagnosis.verdict!r}; accepted: {', '.join(VERDICTS)}"
        )
    return diagnosis
