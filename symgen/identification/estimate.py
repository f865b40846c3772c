"""The result of an identification, as a frozen value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.estimation.band import Band
from symgen.estimation.values import (
    Endogeneity,
    OtherEstimate,
    Reason,
    Residual,
    Trace,
)
from symgen.faults.fault import Fault, delay_of
from symgen.identification.curves import FILE, read_traces
from symgen.identification.uses import Uses, joined
from symgen.names import BASE_ROWS, BASE_UNITS, joint_label, unit
from symgen.robot.types import Robot
from symgen.schemas import (
    BESIDE,
    MATRIX,
    OPTIONAL,
    PAIRS,
    OrNan,
    Size,
    SizeOrInf,
    SizeOrNan,
    at,
    read_result,
    result_file,
    to_json,
)
from symgen.views import Viewable

SCHEMA = "symgen.estimate/2"
MARKER = "estimate.json"
#: Separator of the sentences of a headline, which is one line in the file.
BETWEEN_USES = " | "
#: Schemas that symgen can read.
READ = (SCHEMA, "symgen.estimate/1")
#: Labels in the provenance: that of the robot, and the end of that of a log.
ROBOT_DIGEST, LOG_DIGEST = "robot, sha256 of its canonical robot.toml", "sha256 of samples"


@dataclass(frozen=True)
class JointLabel:
    """A joint: its number in the file, the unit of its torque, and its name in the file."""

    number: int
    unit: str
    name: Annotated[str | None, OPTIONAL] = None

    @property
    def label(self) -> str:
        """Name of the joint in results."""
        return joint_label(self.number, self.name or "")

    @property
    def torque(self) -> str:
        """Label of its torque in figures, with the unit."""
        return f"{self.label}, {self.unit}"

    @property
    def place_unit(self) -> str:
        """The unit of its position."""
        return "m" if self.unit == "N" else "rad"


def joints_of(robot: Robot) -> tuple[JointLabel, ...]:
    """Return the movable joints of a robot."""
    return tuple(JointLabel(j.number, unit("FS", j.sigma), j.name or None) for j in robot.movable)


def equation_titles(joints: Sequence[JointLabel], error: Residual) -> list[str]:
    """Return the titles of what is compared in figures; that of a floating base comes first.

    Args:
        joints: the movable joints.
        error: the error of the comparison.
    """
    base = zip(BASE_ROWS, BASE_UNITS, strict=True)
    of_base = [f"{row}, {unit}" for row, unit in base]
    floats = error.base_force is not None
    return [*of_base[: len(of_base) * floats], *(joint.torque for joint in joints)]


@dataclass(frozen=True)
class ParameterEstimate:
    """One identified parameter: value and standard deviation, in `unit`.

    `relative_std_percent` is 100 std / |value|, or infinite if the value is zero.
    """

    name: str
    expression: str
    value: float
    std: SizeOrNan
    unit: str
    relative_std_percent: float = field(init=False, compare=False)

    def __post_init__(self) -> None:
        relative = 100 * self.std / abs(self.value) if self.value else math.inf
        object.__setattr__(self, "relative_std_percent", relative)


@dataclass(frozen=True)
class Consistency:
    """Whether the base parameters are physically possible.

    Attributes:
        distance_sigma: distance from least squares to the nearest physically possible base
            parameters, in standard deviations; None if unknown.
        reason: why the estimate is not possible; None if it is possible.
        held_out: torque errors of least squares and of the nearest possible parameters on held-out
            folds; None if both are the same, or if there is no such comparison.
    """

    distance_sigma: Size | None
    reason: Reason | None = None
    held_out: tuple[Size, Size] | None = None

    @property
    def possible(self) -> bool | None:
        """Whether some robot has the parameters of the estimate; None if it is not decided."""
        if self.reason is None:
            return True
        return None if self.distance_sigma is None else False

    @property
    def text(self) -> str:
        """The result in one sentence."""
        if self.reason is not None:
            return self.reason.text
        return "bodies of positive mass can have these base parameters"


@dataclass(frozen=True)
class DriveEstimate:
    """The drive of a joint, from logs of its input u: torque u without friction and back-EMF.

    Viscous friction of the joint contains the back-EMF, which has the same form.

    Attributes:
        joint: number of the joint.
        torque: torque at u = 1.
        std: its standard deviation; 0 for a reference.
        unit: unit of `torque`: "N m per duty", or by a reference "duty of joint 1 per duty".
        stall: torque at rest at the limit of u, less Coulomb friction, in the same unit; NaN if the
            limit is unknown.
        stall_std: its standard deviation.
        no_load: speed at the limit of u without a load, rad/s (m/s); NaN if it is unknown.
        no_load_std: its standard deviation.
        limited: share of the samples at the limit of u.
        back_emf: the part of the viscous friction that the drive adds, N m s/rad (N s/m), from logs
            with open windings; NaN if it is unknown.
        back_emf_std: its standard deviation.
    """

    joint: int
    torque: Size
    std: Size
    unit: str
    stall: OrNan
    stall_std: SizeOrNan
    no_load: OrNan
    no_load_std: SizeOrNan
    limited: Size
    back_emf: OrNan = math.nan
    back_emf_std: SizeOrNan = math.nan


@dataclass(frozen=True)
class EquationRank:
    """What some equations of a floating base can determine.

    Attributes:
        equations: the kind of the equations, in words.
        share: part of the samples of the training logs with such equations.
        rank: number of combinations of inertial parameters that they determine.
        unknown: the inertial parameters that they do not determine.
    """

    equations: str
    share: Size
    rank: int
    unknown: tuple[str, ...]


@dataclass(frozen=True)
class Identifiable:
    """Which inertial parameters the logs of a floating base can determine, by exact elimination.

    Attributes:
        count: number of inertial base parameters.
        logged: the kinds of equations in the training logs, and last all of them together.
        lifted: the same equations with a motion in which another contact lifts.
    """

    count: int
    logged: tuple[EquationRank, ...]
    lifted: tuple[EquationRank, ...]

    @property
    def unknown(self) -> tuple[str, ...]:
        """The inertial parameters that the logs do not determine."""
        return self.logged[-1].unknown


UNCHECKED = Consistency(None, Reason("not_checked", text="not checked"))


@dataclass(frozen=True, eq=False)
class Alternative:
    """One of the fitted models of an identification.

    Attributes:
        model: energy, momentum or torque.
        condition_number: condition number of its regressor with columns scaled to unit norm.
        train, validation: torque residuals; None if the logs do not determine the parameters.
        held_out: torque error on held-out folds, RMS over the joints.
        chosen: whether this model is the estimate.
        reason: a text with its torque error, or why it has no solution.
    """

    model: str
    condition_number: SizeOrInf
    train: Annotated[Residual | None, at("torque_residual.train")]
    validation: Annotated[Residual | None, at("torque_residual.validation")]
    held_out: Annotated[SizeOrInf, at("held_out_folds")]
    chosen: bool
    reason: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Estimate(Viewable):
    """Identified parameters with their precision, the fit, and a verdict in words.

    Attributes:
        robot: name of the robot.
        joints: number in the file and unit of the torque of each movable joint.
        model: energy, momentum or torque.
        method: name of the estimator.
        parameters: the base parameters, in the order of X.
        condition_number: condition number of the regressor with its columns scaled to unit norm.
        train: residual of the equations of the model on the training data.
        validation: the same on the validation data.
        torque_train: torque residual of the same parameters on the training data.
        torque_validation: the same on the validation data.
        moving: torque_validation for joints in motion; None if unknown.
        noise_floor: torque error on the validation data that noise alone causes, for joints in
            motion; None if unknown.
        unexplained: part of the torque that neither the model nor noise explains; None if no
            joint's error is visible above its noise.
        cutoff_hz: cutoff of the zero-phase filter, Hz; None without a filter.
        window_s: length of the windows of energy and momentum, s; None for the torque model.
        verdict: "trusted" or "doubtful".
        reasons: why it is doubtful; empty for "trusted".
        suspected: possible faults that are not certain and do not change the verdict.
        notes: texts on the changes of the logs and on the fit.
        correlation: correlation of the parameters, (p, p).
        possible: whether some robot has these parameters; None if it is not decided.
        at_bound: names of the parameters at a bound of possible robots; their standard deviations
            are not valid.
        physical: distance of least squares from a possible robot, and why the estimate is not
            possible.
        excludes: a text with the errors that the standard deviations do not include.
        endogeneity: tests for a bias of least squares, if there are instruments.
        comparison: the same parameters by other methods, for example wls in an estimate by iv.
        prior: values of the prior, with infinite std for parameters without one; None without a
            prior.
        band: the filters of the run; None in an older file.
        repairs: repairs of the logs.
        alternatives: the fitted models, the chosen one first.
        drives: the drives of the joints, from logs of their inputs; empty for logs of torques.
        identifiable: for a floating base, which equations determine its parameters; else None.
        uses: the uses of the estimate; None in a file of schema 1.
        headline: the torque error and a sentence for each use, separated by BETWEEN_USES.
        provenance: pairs of label and value: version, backend, digests of robot and logs, options.
        traces: curves of the fit, for plots.
    """

    GONE: ClassVar = ("whiteness",)

    robot: str
    joints: tuple[JointLabel, ...] = ()
    model: str
    method: str
    parameters: tuple[ParameterEstimate, ...]
    condition_number: Size
    train: Annotated[Residual, at("residual.train")]
    validation: Annotated[Residual, at("residual.validation")]
    torque_train: Annotated[Residual | None, at("torque_residual.train")] = None
    torque_validation: Annotated[Residual | None, at("torque_residual.validation")] = None
    noise_floor: Annotated[Residual | None, OPTIONAL] = None
    unexplained: Annotated[Size | None, OPTIONAL] = None
    cutoff_hz: float | None
    window_s: float | None
    verdict: str
    reasons: tuple[Reason, ...]
    suspected: tuple[Reason, ...] = ()
    headline: str = ""
    uses: Uses | None = None
    band: Band | None = None
    alternatives: Annotated[tuple[Alternative, ...], at("models")] = ()
    repairs: tuple[Fault, ...] = ()
    drives: Annotated[tuple[DriveEstimate, ...], OPTIONAL] = ()
    identifiable: Annotated[Identifiable | None, OPTIONAL] = None
    possible: bool | None = field(init=False)
    at_bound: tuple[str, ...] = ()
    physical: Consistency = UNCHECKED
    excludes: Annotated[str, at("std_excludes")] = ""
    endogeneity: tuple[Endogeneity, ...] = ()
    comparison: tuple[OtherEstimate, ...] = ()
    prior: OtherEstimate | None = None
    correlation: Annotated[FloatArray, MATRIX] = field(default_factory=lambda: np.empty((0, 0)))
    notes: tuple[str, ...] = ()
    provenance: Annotated[tuple[tuple[str, str], ...], PAIRS] = ()
    traces: Annotated[tuple[Trace, ...], BESIDE] = ()
    moving: Annotated[Residual | None, at("torque_residual_in_motion"), OPTIONAL] = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "possible", self.physical.possible)
        count = len({p.name for p in self.parameters})
        if not 0 < count == len(self.parameters) or self.correlation.size not in (0, count**2):
            raise ValueError(
                "parameters are missing, or there twice, or correlation has another size"
            )

    def __repr__(self) -> str:
        """Return robot, model, method and verdict."""
        return (
            f"<Estimate of {self.robot}: {len(self.parameters)} parameters by {self.model} and "
            f"{self.method}, {self.verdict}>"
        )

    def has(self, kind: str) -> bool:
        """Whether a reason of some kind makes it doubtful."""
        return any(reason.kind == kind for reason in self.reasons)

    @property
    def X(self) -> FloatArray:
        """The values (p,), in the order that all kernels use."""
        return np.array([p.value for p in self.parameters])

    @property
    def sentences(self) -> tuple[str, ...]:
        """The sentences of the headline; in a file of schema 1, the reasons."""
        if self.headline:
            return tuple(self.headline.split(BETWEEN_USES))
        return (joined(self.reasons),) if self.reasons else ()

    @property
    def shifts(self) -> tuple[Fault, ...]:
        """Repairs that shifted channels of all logs. Other logs of the robot need them too."""
        return tuple(fault for fault in self.repairs if delay_of(fault))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of X, (p, p)."""
        std = np.array([p.std for p in self.parameters])
        return self.correlation * np.outer(std, std)

    def to_json(self) -> dict[str, Any]:
        """Return the content of estimate.json (schema symgen.estimate/2)."""
        return to_json(self, SCHEMA)


def read_estimate(path: str | Path) -> Estimate:
    """Read an estimate from estimate.json.

    The curves for plots come from curves.npz in the same folder, if that file exists. Values that
    an older estimate.json lacks are empty.

    Args:
        path: the folder that `identify` wrote, or the estimate.json in it.

    Raises:
        ParameterError: there is no estimate, or it is damaged.
    """
    file = result_file(path, MARKER)
    others = sorted(other.name for other in file.parent.glob("*.json"))
    if Path(path).is_dir() and others and not file.exists():
        raise ParameterError(
            f"{path}: the folder has {', '.join(others)} and no {file.name}; accepted: a result of "
            "symgen identify, for a diagnosis that of the line next: which it printed"
        )
    estimate = read_result(Estimate, file, *READ)
    torque_error = estimate.torque_validation
    torque = torque_error and torque_error.per_joint
    unnamed = tuple(JointLabel(j, "N m or N") for j in range(1, len(torque or ()) + 1))
    joints = estimate.joints or unnamed
    count = len(equation_titles(joints, torque_error)) if torque_error else len(joints)
    traces = read_traces(file.with_name(FILE), count)
    return replace(estimate, joints=joints, traces=traces)
