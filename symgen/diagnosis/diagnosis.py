"""What a diagnosis says: the gap before and after, where it is, and the effects that close it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.mended import MendedChannel
from symgen.errors import ParameterError
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.schemas import BESIDE, OPTIONAL, OrNan, at, from_json, read_json, result_file, to_json
from symgen.views import Viewable

MARKER = "diagnosis.json"
SCHEMA = "symgen.diagnosis/1"
NOISE = "may be noise of q"
VERDICTS = ("consistent", "explained", "partly-explained", "unexplained", "bad-measurement")


@dataclass(frozen=True)
class Gap:
    """RMS of measured minus modelled torque over RMS of measured torque, in the motion's band.

    The torque error of `identify`, per joint and over all joints stacked.
    """

    per_joint: tuple[OrNan, ...]
    total: OrNan


@dataclass(frozen=True)
class FoundParameter:
    """A coefficient or a constant of an effect; std is NaN for a constant that was searched."""

    name: str
    value: OrNan
    std: OrNan
    unit: str


class Alike(NamedTuple):
    """An effect that these data cannot tell from another."""

    name: str
    joints: tuple[int, ...]


@dataclass(frozen=True)
class FoundEffect:
    """One effect that the data show.

    Attributes:
        name: of the library, "unnamed", or the robot file's.
        joints: numbers in the file; empty for the whole arm.
        parameters: with units and standard deviations.
        expression: the torque ON the joint.
        p_value: of its surest coefficient, the number of its coefficients counted.
        gap_reduction: share of the gap's square on its joints that it closes.
        indistinguishable_from: (name, joints) of others that these data cannot tell from it.
        separate: the motion that would tell them apart.
        declared: whether the extended robot.toml and its C code hold it.
        probability: that it, or one of those that the data cannot tell from it, is there.
        torque_rms: RMS of its torque on its joint, N m or N.
        confirmed: whether motion that it was not found on shows it; only then the robot has it.
        note: a doubt about it, NOISE; None without any.
    """

    name: str
    joints: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    expression: str
    p_value: OrNan
    gap_reduction: OrNan
    indistinguishable_from: tuple[Alike, ...] = ()
    separate: str = ""
    declared: Annotated[bool, at("in_robot_toml")] = True
    probability: float = 1.0
    torque_rms: OrNan = np.nan
    confirmed: bool = True
    note: Annotated[str | None, OPTIONAL] = None


@dataclass(frozen=True)
class FreeFunction:
    """A torque on a joint that no known law has the shape of.

    Attributes:
        joint: number in the file.
        variables: one or two of q, qd and taur with the number of their joint: the torque is a
            function of these.
        effects: the named laws that it predicts much better than; none where no law explains
            anything.
        grid: (G,) values of the first variable.
        at: (L,) of the second one; empty where there is none.
        torque: (1 or L, G) of the function, N m or N, the declared friction of the joint with it:
            only the sum is determined.
        std: of the torque.
        law: what the named laws give in its place; empty where there is none.
        gain_ratio: what the laws gain in predicting other motion, over what the function gains.
        before, after: RMS of what is left of the joint's held-out torque, without the function and
            with it in place of the laws, as a part of the torque.
    """

    joint: int
    variables: tuple[str, ...]
    effects: tuple[str, ...]
    grid: tuple[float, ...]
    at: tuple[float, ...]
    torque: tuple[tuple[float, ...], ...]
    std: tuple[tuple[float, ...], ...]
    law: tuple[tuple[float, ...], ...]
    gain_ratio: float
    before: float
    after: float


@dataclass(frozen=True)
class Place:
    """Where the gap is: a joint, its share, and what it is organised by."""

    joint: int
    share: float
    pattern: str
    time_window: tuple[float, float] | None = None


@dataclass(frozen=True)
class Rejected:
    """A candidate that was looked at, and why it is not named."""

    name: str
    joints: tuple[int, ...]
    reason: str


@dataclass(frozen=True, eq=False)
class Curves:
    """Torques of one validation log in the motion's band, (K, n), and the motion beside them.

    Where `free` (K, n) is given, torques count where it is true: the user masked the others.
    """

    name: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray
    free: NDArray[np.bool_] | None = None


@dataclass(frozen=True)
class Work:
    """The gap as energy: RMS of the work that a model leaves over RMS of the measured work.

    Work is the integral of qd' tau over windows of `window_s`, as in the energy model: joints
    count by their power, not each for itself.
    """

    window_s: float
    before: float
    after: float


def work(curves: Sequence[Curves], window: float = 0.2) -> Work | None:
    """Compare measured and modelled work on validation logs; None where no window fits."""
    parts = []
    for c in curves:
        step = float(np.median(np.diff(c.t))) if len(c.t) > 1 else np.inf
        size = max(1, round(window / step))
        if len(c.t) > size:
            torques, free = (
                np.stack([c.measured, c.before, c.after]),
                1 if c.free is None else c.free,
            )
            power = np.sum(c.qd * torques * free, axis=2)
            total = np.zeros(power.shape)
            np.cumsum((power[:, 1:] + power[:, :-1]) / 2 * step, axis=1, out=total[:, 1:])
            parts.append(total[:, size:] - total[:, :-size])
    if not parts:
        return None
    measured, *models = np.concatenate(parts, axis=1)
    rms = [float(np.sqrt(np.mean(x**2))) for x in (measured, *(measured - m for m in models))]
    before, after = (left / (rms[0] or np.inf) for left in rms[1:])
    return Work(window, before, after)


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(Viewable):
    """The answer of `diagnose`.

    Attributes:
        robot: name.
        verdict: one of VERDICTS.
        cutoff_hz: of the low-pass that every torque passes; None where none fits.
        metric: of the gap: "torque".
        before, after, floor: the gap on data that the selection never saw.
        energy: the same as work of the curves; None without them.
        where: joints with the gap, the largest share first; empty where consistent.
        effects: in the order of their share in closing the gap.
        free_functions: curves of torques that no known law has the shape of; None without any.
        rejected: what else was looked at.
        advice: what to do, in words.
        notes: what was done to the logs, and what the extended robot leaves out.
        extended: the robot with the effects added.
        joints: numbers of the movable joints.
        curves: for drawing.
        tried: number of candidates.
        parameters: base parameters of the extended robot, in the order of X.
        declared: the robot as it was declared.
        values: its base parameters X, of the model before.
        repairs: what was mended in the logs.
        replay: RMS distances of the motion under the measured torques, of a folder that was read.
        digests: SHA-256 of the other files of that folder.
        mended: the channels that this changed most, for drawing.
        moving: the gap before and after, and its floor, where friction at rest has no say.
    """

    robot: str
    verdict: str
    cutoff_hz: float | None
    metric: Annotated[Literal["torque"], at("gap.metric")] = "torque"
    before: Annotated[Gap, at("gap.before")]
    after: Annotated[Gap, at("gap.after")]
    floor: Annotated[Gap, at("gap.noise_floor")]
    energy: Work | None = field(init=False)
    where: tuple[Place, ...]
    effects: tuple[FoundEffect, ...]
    free_functions: Annotated[tuple[FreeFunction, ...] | None, OPTIONAL] = None
    rejected: tuple[Rejected, ...]
    tried: Annotated[int, at("candidates_tried")] = 0
    advice: tuple[str, ...]
    notes: tuple[str, ...]
    parameters: tuple[FoundParameter, ...] = ()
    repairs: tuple[Fault, ...] = ()
    replay: dict[str, Any] | None = None
    digests: Annotated[dict[str, str] | None, OPTIONAL] = None
    extended: Annotated[Robot, BESIDE]
    joints: Annotated[tuple[int, ...], BESIDE]
    curves: Annotated[tuple[Curves, ...], BESIDE] = ()
    declared: Annotated[Robot | None, BESIDE] = None
    values: Annotated[tuple[float, ...], BESIDE] = ()
    mended: Annotated[tuple[MendedChannel, ...], BESIDE] = ()
    moving: Annotated[tuple[Gap, ...], BESIDE] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "energy", work(self.curves))

    def __repr__(self) -> str:
        """Return robot, verdict and the gap before and after."""
        return (
            f"<Diagnosis of {self.robot}: {self.verdict}, torque error "
            f"{100 * self.before.total:.3g} % to {100 * self.after.total:.3g} %>"
        )

    def to_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json (schema symgen.diagnosis/1)."""
        return to_json(self, SCHEMA)


def read_diagnosis(path: str | Path) -> Diagnosis:
    """Read a diagnosis again: diagnosis.json, and the extended robot.toml beside it.

    Curves over time are not kept there: `curves` is empty.

    Args:
        path: the folder that `diagnose` wrote, or the diagnosis.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
        RobotError: robot.toml beside it cannot be read.
    """
    file = result_file(path, MARKER)
    content, extended = read_json(file, SCHEMA), read_robot(file.with_name("robot.toml"))
    joints = tuple(j.number for j in extended.movable)
    found = from_json(Diagnosis, content, file, extended=extended, joints=joints)
    sizes = {len(gap.per_joint) for gap in (found.before, found.after, found.floor)}
    if found.verdict not in VERDICTS or sizes != {len(joints)}:
        what = "gap.per_joint" if found.verdict in VERDICTS else f"verdict {found.verdict!r}"
        raise ParameterError(
            f"{file}: damaged at {what}; accepted: schema {SCHEMA} as diagnose writes it"
        )
    return found
