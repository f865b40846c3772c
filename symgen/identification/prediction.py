"""predict: torque and energy of a model with known parameters along a log."""

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
from symgen.estimation.floor import noise_fit
from symgen.estimation.system import torque_along
from symgen.estimation.torque_error import fit, percent
from symgen.estimation.values import FloatArray, Residual, Trace
from symgen.faults.fault import Fault
from symgen.identification.campaign import Filtering
from symgen.identification.curves import require_times
from symgen.identification.estimate import JointLabel, equation_titles, joints_of
from symgen.identification.known_band import error_of, open_in_known_band, without_offsets
from symgen.identification.parameters import read_known
from symgen.names import WRENCH_ENDS
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
        robot: name of the robot.
        torque: measured and predicted torque in the motion's band, (N, m), N m or N; what a
            floating base shows comes first.
        error: ||measured - predicted|| over ||measured|| in the comparison band, per joint and over
            all joints stacked; see `symgen.estimation.torque_error`.
        moving: the same for joints in motion.
        noise: torque error that noise alone causes, for joints in motion; NaN if unknown.
        kinetic: kinetic energy (N,), J; NaN if the base moves.
        potential: potential energy (N,), J, up to a constant; NaN if the base moves.
        band: the filters of the run; those of the estimate, if its file has them.
        notes: texts on the changes of the log.
        joints: number in the file and unit of the torque of each movable joint.
        repairs: repairs of the log.
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
        """Return the curves as the content of prediction.csv."""
        n = len(self.joints)
        base = WRENCH_ENDS[: self.torque.measured.shape[1] - n]
        of_one = [*(f"_base_{end}" for end in base), *map(str, range(1, n + 1))]
        labels = [f"{name}{row}" for name in ("tau", "predicted") for row in of_one]
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
    """Predict the torque and the energy along a log from known parameters.

    Args:
        robot: a robot, a path or a library name.
        log: a path or a log.
        parameters: the folder that `identify` or `diagnose` wrote, its estimate.json, or TOML with
            [parameters].
        cutoff: cutoff of the zero-phase filter of positions and speeds, Hz; by default that of the
            file of parameters, or else the one that suits the log best.
        reading: options of reading and masking. Masked samples do not count in the error.

    Raises:
        LogError: symgen cannot read the log, or it belongs to another robot.
        ParameterError: the parameters are of another robot.
    """
    source = read_robot(robot)
    model = derive(source, (*JUDGING, "energy"))
    known, evaluator = read_known(parameters, model), load(model)
    filtering = Filtering(cutoff, known=known.band)
    error = error_of(evaluator, known.X)
    campaign = open_in_known_band(
        evaluator, robot, [log], reading, filtering, known.shifts, error, drives=known.drives
    )
    campaign = without_offsets(campaign, known.X)
    (filtered,) = campaign.train
    compared = fit(evaluator, [filtered], known.X)
    noise = noise_fit(evaluator, [filtered], known.X).residual
    torque = torque_along(evaluator, known.X, filtered)
    measured = filtered.tau
    if filtered.rows.cutoff is not None:
        measured, torque = (
            lowpass(x, filtered.step, filtered.rows.cutoff) for x in (measured, torque)
        )
    kinetic = potential = np.full((len(filtered.t), 1), np.nan)  # on a base that moves
    if not source.imu:
        kinetic, potential = evaluator["energy"](filtered.q, filtered.qd, known.X)
    return Prediction(
        robot=source.name,
        joints=joints_of(source),
        log=filtered.name,
        error=compared.residual,
        moving=compared.in_motion.residual,
        noise=noise,
        band=campaign.band,
        repairs=campaign.repairs,
        notes=(*campaign.notes, *compared.motion_note),
        torque=Trace(filtered.name, "validation", "torque", filtered.t, measured, torque),
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
    drives: FloatArray | None = None,
) -> list[float]:
    """Return the torque error in motion along a log, of each of some sets of parameters, in a band.

    Args:
        robot: the robot.
        log: a path or a log.
        parameters: sets of base parameters (p,).
        band: the filters; by default, symgen chooses them.
        shifts: shifts of the torques in the run of the estimate, the last set of parameters.
        reading: options of reading the log.
        drives: (n,) torque of each drive per unit of its input, for a log of inputs.

    Raises:
        LogError: symgen cannot read the log, or it belongs to another robot.
    """
    evaluator = load(derive(robot, JUDGING))
    filtering = Filtering(known=band)
    error = error_of(evaluator, parameters[-1])
    campaign = open_in_known_band(
        evaluator, robot, [log], reading, filtering, shifts, error, drives=drives
    )
    campaign = without_offsets(campaign, parameters[-1])
    return [fit(evaluator, campaign.train, X).in_motion.residual.relative for X in parameters]


def read_prediction(path: str | Path) -> Prediction:
    """Read a prediction from prediction.json and from prediction.csv in the same folder.

    Args:
        path: the folder that `predict` wrote, or the prediction.json in it.

    Raises:
        ParameterError: a file does not exist or is damaged.
    """
    file = result_file(path, MARKER)
    curves = dict.fromkeys(("torque", "kinetic", "potential"))
    prediction = read_result(Prediction, file, SCHEMA, **curves)
    try:
        m = len(equation_titles(prediction.joints, prediction.moving))
        text = file.with_name(CURVES).read_text(encoding="utf-8")
        rows = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, ndmin=2)
        t, measured, predicted, kinetic, potential = np.split(rows, np.cumsum([1, m, m, 1]), axis=1)
        require_times(t[:, 0])
        moves = np.isnan(rows[:, -2:]).all()  # a base that moves has no energy
        finite = np.isfinite(rows[:, :-2] if moves else rows).all()
        if potential.shape[1] != 1 or not finite:
            raise ValueError("columns")
        errors = (prediction.error, prediction.moving, prediction.noise)
        if m == 0 or any(each.per_joint is None for each in errors):
            raise ValueError("torque_error")
    except (OSError, ValueError) as error:
        raise ParameterError(
            f"{file}: damaged, or {CURVES} beside it is ({type(error).__name__}); accepted: both "
            "as predict writes them"
        ) from error
    trace = Trace(prediction.log, "validation", "torque", t[:, 0], measured, predicted)
    return replace(prediction, torque=trace, kinetic=kinetic[:, 0], potential=potential[:, 0])
