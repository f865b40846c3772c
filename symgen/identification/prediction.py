"""predict: what a model with given parameters says of a log."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from symgen.codegen.model import derive
from symgen.data.log import Log
from symgen.data.raw import Reading, csv_bytes
from symgen.data.signals import lowpass
from symgen.errors import ParameterError
from symgen.estimation.band import Band
from symgen.estimation.equation_model import JUDGING
from symgen.estimation.motion_error import motion_error
from symgen.estimation.system import torque_at
from symgen.estimation.torque_error import fit, percent
from symgen.estimation.values import FloatArray, Residual, Trace
from symgen.faults.fault import Fault
from symgen.identification.estimate import JointLabel, joints_of
from symgen.identification.known_band import open_in_band
from symgen.identification.parameters import read_given
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import load
from symgen.schemas import BESIDE, at, read_result, result_file, to_json
from symgen.views import Viewable

SCHEMA = "symgen.prediction/2"
MARKER, CURVES = "prediction.json", "prediction.csv"


@dataclass(frozen=True, eq=False, kw_only=True)
class Prediction(Viewable):
    """Torque and energy of a model along a log.

    Attributes:
        robot: its name.
        torque: measured and predicted torque in the motion's band, (N, n), N m or N.
        error: ||measured - predicted|| over ||measured|| in the comparison band, per joint and over
            all joints stacked; see `symgen.estimation.torque_error`.
        moving: the same for joints in motion.
        noise: what noise alone leaves of `moving`.
        kinetic: kinetic energy (N,), J; NaN if the base moves.
        potential: potential energy (N,), J, up to a constant.
        band: the filters of the run: those of the estimate, where it states them.
        notes: what was done to the log.
        joints: number in the file and unit of the torque of each movable joint.
        repairs: what was mended in the log.
    """

    robot: str
    joints: tuple[JointLabel, ...]
    log: str
    error: Annotated[Residual, at("torque_error")]
    moving: Annotated[Residual, at("torque_error_in_motion")]
    noise: Annotated[Residual, at("noise_floor")]
    band: Band
    repairs: tuple[Fault, ...] = ()
    notes: tuple[str, ...]
    torque: Annotated[Trace, BESIDE]
    kinetic: Annotated[FloatArray, BESIDE]
    potential: Annotated[FloatArray, BESIDE]

    def __repr__(self) -> str:
        """Return robot, log and error."""
        error = percent(self.moving.relative)
        return f"<Prediction of {self.robot} along {self.log}: torque error {error}>"

    def to_json(self) -> dict[str, Any]:
        """Return the content of prediction.json."""
        return to_json(self, SCHEMA)

    def to_csv(self) -> bytes:
        """Return the curves, prediction.csv."""
        n = self.torque.measured.shape[1]
        labels = [f"tau{j}" for j in range(1, n + 1)] + [f"predicted{j}" for j in range(1, n + 1)]
        columns = [self.torque.t, self.torque.measured, self.torque.predicted]
        rows = np.column_stack([*columns, self.kinetic, self.potential])
        return csv_bytes(["t", *labels, "kinetic", "potential"], rows)


def predict(
    robot: Robot | str | Path,
    log: str | Path | Log,
    parameters: str | Path,
    *,
    cutoff: float | None = None,
    reading: Reading | None = None,
) -> Prediction:
    """Predict the torque and the energy of a log from given parameters.

    Args:
        robot: a robot, a path or a library name.
        log: a path, or a log.
        parameters: the folder that `identify` or `diagnose` wrote, its estimate.json, or TOML with
            [parameters].
        cutoff: of the zero-phase filter of positions and speeds, Hz; by default that of the
            parameters' file, or else the one that suits the log best.
        reading: how the log is read, and what of it has no say in the error.

    Raises:
        LogError: the log cannot be read or belongs to another robot.
        ParameterError: the parameters are not this robot's.
    """
    source = read_robot(robot)
    model = derive(source, (*JUDGING, "energy"))
    given, evaluator = read_given(parameters, model), load(model)
    opened = open_in_band(
        evaluator, [log], reading, band=given.band, shifts=given.shifts, cutoff=cutoff
    )
    (seen,) = opened.logs
    compared = fit(evaluator, [seen], given.X)
    judged = motion_error(evaluator, [seen], given.X, compared)
    torque = torque_at(evaluator, given.X, *seen.motion)
    measured = seen.tau
    if seen.rows.cutoff is not None:
        measured, torque = (lowpass(x, seen.step, seen.rows.cutoff) for x in (measured, torque))
    kinetic = potential = np.full((len(seen.t), 1), np.nan)  # on a base that moves
    if not source.imu:
        kinetic, potential = evaluator["energy"](seen.q, seen.qd, given.X)
    return Prediction(
        robot=source.name,
        joints=joints_of(source),
        log=seen.name,
        error=compared.residual,
        moving=judged.error,
        noise=judged.noise,
        band=opened.band,
        repairs=opened.repairs,
        notes=(*opened.notes, *compared.motion_note),
        torque=Trace(seen.name, "validation", "torque", seen.t, measured, torque),
        kinetic=kinetic[:, 0],
        potential=potential[:, 0],
    )


def torque_errors(
    robot: Robot,
    log: str | Path | Log,
    parameters: Sequence[FloatArray],
    band: Band | None = None,
    shifts: Sequence[Fault] = (),
    reading: Reading | None = None,
) -> list[float]:
    """Return the relative torque error of some parameters along a log, in one band.

    Args:
        robot: the robot.
        log: a path, or a log.
        parameters: (p,) base parameters of each.
        band: the filters; by default those that suit the log best.
        shifts: of the torques of all logs, done by the estimate.
        reading: how the log is read.

    Raises:
        LogError: the log cannot be read or belongs to another robot.
    """
    evaluator = load(derive(robot, JUDGING))
    opened = open_in_band(evaluator, [log], reading, band=band, shifts=shifts)
    return [fit(evaluator, opened.logs, X).residual.relative for X in parameters]


def read_prediction(path: str | Path) -> Prediction:
    """Read a prediction again: prediction.json, and prediction.csv beside it.

    Args:
        path: the folder that `predict` wrote, or the prediction.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    file = result_file(path, MARKER)
    curves = dict.fromkeys(("torque", "kinetic", "potential"))
    found = read_result(Prediction, file, SCHEMA, **curves)
    try:
        n = len(found.joints)
        text = file.with_name(CURVES).read_text(encoding="utf-8")
        rows = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, ndmin=2)
        t, measured, predicted, kinetic, potential = np.split(rows, np.cumsum([1, n, n, 1]), axis=1)
        if potential.shape[1] != 1 or not np.isfinite(rows).all():
            raise ValueError("columns")
        errors = (found.error, found.moving, found.noise)
        if n == 0 or any(len(each.per_joint or ()) != n for each in errors):
            raise ValueError("torque_error")
    except (OSError, ValueError) as error:
        raise ParameterError(
            f"{file}: damaged, or {CURVES} beside it is ({type(error).__name__}); accepted: both "
            "as predict writes them"
        ) from error
    trace = Trace(found.log, "validation", "torque", t[:, 0], measured, predicted)
    return replace(found, torque=trace, kinetic=kinetic[:, 0], potential=potential[:, 0])
