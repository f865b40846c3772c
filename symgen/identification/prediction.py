"""predict: what a model with given parameters says of a log."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from symgen import names
from symgen.codegen.model import derive
from symgen.data.log import Log
from symgen.data.raw import Reading
from symgen.data.signals import lowpass
from symgen.errors import ParameterError
from symgen.estimation.band import Band, comparison_band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered import filtered
from symgen.estimation.logs import open_samples
from symgen.estimation.recipe import JUDGING
from symgen.estimation.repairs import Repair
from symgen.estimation.speeds import mended_speeds
from symgen.estimation.torque_error import fit
from symgen.estimation.values import FloatArray, Residual, Trace
from symgen.identification.parameters import read_given
from symgen.identification.reading import Joint
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import load
from symgen.schemas import from_json, read_json, result_file, to_json

SCHEMA = "symgen.prediction/2"
#: Whose error is that of the one band that it states, instead of a comparison band.
OLDER = "symgen.prediction/1"
MARKER, CURVES = "prediction.json", "prediction.csv"


@dataclass(frozen=True, kw_only=True)
class _File:
    """prediction.json, key by key; the older schema had one low-pass, and no repairs."""

    robot: str
    joints: tuple[Joint, ...]
    log: str
    torque_error: Residual
    band: Band | None = None
    repairs: tuple[Repair, ...] = ()
    notes: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class _Older(_File):
    band_hz: float | None


@dataclass(frozen=True, eq=False)
class Prediction:
    """Torque and energy of a model along a log.

    Attributes:
        robot: its name.
        torque: measured and predicted torque in the motion's band, (N, n), N m or N.
        error: ||measured - predicted|| over ||measured|| in the comparison band, per joint and over
            all joints stacked; see `symgen.estimation.torque_error`.
        kinetic: kinetic energy (N,), J.
        potential: potential energy (N,), J, up to a constant.
        band: the filters of the run: those of the estimate, where it states them.
        notes: what was done to the log.
        joints: number in the file and unit of the torque of each movable joint.
        repairs: what was mended in the log.
    """

    robot: str
    torque: Trace
    error: Residual
    kinetic: FloatArray
    potential: FloatArray
    band: Band
    notes: tuple[str, ...]
    joints: tuple[tuple[int, str], ...] = ()
    repairs: tuple[Repair, ...] = ()

    def __repr__(self) -> str:
        """Return robot, log and error."""
        error = f"{100 * self.error.relative:.3g} %"
        return f"<Prediction of {self.robot} along {self.torque.log}: torque error {error}>"

    def to_files(self) -> dict[str, bytes]:
        """Return prediction.json and prediction.csv."""
        n = self.torque.measured.shape[1]
        labels = [f"tau{j}" for j in range(1, n + 1)] + [f"predicted{j}" for j in range(1, n + 1)]
        columns = [self.torque.t, self.torque.measured, self.torque.predicted]
        rows = np.column_stack([*columns, self.kinetic, self.potential])
        lines = [",".join(["t", *labels, "kinetic", "potential"])]
        lines += [",".join(f"{v:.9g}" for v in row) for row in rows]
        summary = _File(
            robot=self.robot,
            joints=tuple(Joint(*joint) for joint in self.joints),
            log=self.torque.log,
            torque_error=self.error,
            band=self.band,
            repairs=self.repairs,
            notes=self.notes,
        )
        return {
            MARKER: (json.dumps(to_json(summary, SCHEMA), indent=1) + "\n").encode(),
            CURVES: ("\n".join(lines) + "\n").encode(),
        }


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
        parameters: the folder that `identify` wrote, its estimate.json, or TOML with [parameters].
        cutoff: of the zero-phase filter of positions and speeds, Hz; by default that of the
            estimate, or else the one that suits the log best.
        reading: how the log is read, and what of it has no say in the error.

    Raises:
        LogError: the log cannot be read or belongs to another robot.
        ParameterError: the parameters are not this robot's.
    """
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    samples, repairs = open_samples(log, source, reading)
    model = derive(source, (*JUDGING, "energy"))
    given = read_given(parameters, model)
    evaluator, X, known = load(model), given.X, given.band
    comparison = comparison_band([samples]) if known is None else known.comparison_hz
    samples, mended = mended_speeds(samples, comparison)
    band = known or choose_band(evaluator, [samples], cutoff)
    if cutoff is not None:
        band = replace(band, cutoff_hz=cutoff)
    seen = filtered(samples, band)
    compared = fit(evaluator, [seen], X)
    torque = np.asarray(evaluator["inverse_dynamics"](seen.q, seen.qd, seen.qdd, X))
    beside = 0.0 if samples.beside is None else samples.beside
    measured, torque = seen.tau + beside, torque + beside
    if seen.rows.cutoff is not None:
        measured, torque = (lowpass(x, seen.step, seen.rows.cutoff) for x in (measured, torque))
    kinetic, potential = evaluator["energy"](seen.q, seen.qd, X)
    return Prediction(
        source.name,
        Trace(samples.name, "validation", "torque", seen.t, measured, torque, 0),
        compared.residual,
        kinetic[:, 0],
        potential[:, 0],
        band,
        (*samples.notes, f"band: {band.in_words()}", *compared.told_apart),
        tuple((j.number, names.unit("FS", j.sigma)) for j in source.movable),
        (*repairs, *mended),
    )


def read_prediction(path: str | Path) -> Prediction:
    """Read a prediction again: prediction.json, and prediction.csv beside it.

    Args:
        path: the folder that `predict` wrote, or the prediction.json in it.

    Raises:
        ParameterError: there is none, or it is damaged.
    """
    file = result_file(path, MARKER)
    content = read_json(file, SCHEMA, OLDER)
    try:
        found = from_json(_Older if content["schema"] == OLDER else _File, content, file)
        n = len(found.joints)
        text = file.with_name(CURVES).read_text(encoding="utf-8")
        rows = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, ndmin=2)
        t, measured, predicted, kinetic, potential = np.split(rows, np.cumsum([1, n, n, 1]), axis=1)
        if potential.shape[1] != 1 or not np.isfinite(rows).all():
            raise ValueError("columns")
        if n == 0 or len(found.torque_error.per_joint or ()) != n:
            raise ValueError("torque_error")
        band = found.band
        if isinstance(found, _Older):
            band = _older_band(found.band_hz, t[:, 0])
        if band is None:
            raise ValueError("band")
        band.require()
        trace = Trace(found.log, "validation", "torque", t[:, 0], measured, predicted)
        joints = tuple((j.number, j.unit) for j in found.joints)
        return Prediction(
            found.robot, trace, found.torque_error, kinetic[:, 0], potential[:, 0], band,
            found.notes, joints, found.repairs,
        )  # fmt: skip
    except (OSError, ValueError) as error:
        raise ParameterError(
            f"{file}: damaged, or {CURVES} beside it is ({type(error).__name__}); accepted: both "
            "as predict writes them"
        ) from error


def _older_band(band_hz: float | None, t: FloatArray) -> Band:
    """Return the one low-pass of an older prediction; None where no filter was needed."""
    if len(t) < 2 or not (np.diff(t) > 0).all():
        raise ValueError("t")
    rate = float(1 / np.median(np.diff(t)))
    cutoff = rate / 2 if band_hz is None else band_hz
    return Band(rate, cutoff, cutoff, "measured")
