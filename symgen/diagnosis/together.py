"""All effects of a diagnosis as columns of the declared model, fitted together on torque rows.

This fit gives the values of what a robot file cannot declare, and the standard deviations of
searched constants. With fixed parameters it is the only fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.estimators import Wls
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import Solution
from symgen.estimation.torque_error import TorqueFit, modelled_torque, squares
from symgen.estimation.values import FloatArray
from symgen.hypotheses.confirm import settled
from symgen.hypotheses.effects import Score
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.refine import slopes
from symgen.hypotheses.registry import SearchResult
from symgen.hypotheses.rows import FittedRows, rest_weights
from symgen.hypotheses.score import dense
from symgen.robot.types import Robot


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Values of an effect: coefficients (c,) and constants (k,), with their uncertainty.

    Attributes:
        values: (c,) coefficients.
        covariance: (c, c) of the coefficients; NaN if the logs do not determine them.
        constants_std: (k,) standard deviations of the searched constants; NaN if unknown.
    """

    values: FloatArray
    covariance: FloatArray
    constants_std: FloatArray


@dataclass(frozen=True, eq=False)
class Together:
    """The declared model with the columns of all effects.

    Attributes:
        problem: the declared model on the corrected logs.
        X: (p,) parameters of the model.
        values: the effects, with settled constants, each with its values.
    """

    problem: Problem
    X: FloatArray
    values: Mapping[Score, Coefficients]

    def torques(self, logs: Sequence[FilteredLog]) -> list[FloatArray]:
        """Return the torque along some logs, in the band, (K, m)."""
        out = []
        for log in logs:
            if log.base_rows:
                out.append(self._with_base(log))
                continue
            torques = self.problem.torques_along(log, self.X)
            torque = torques.model
            for score, found in self.values.items():
                columns = dense(score.cause.columns(log, torques), log.tau.shape)
                torque = torque + columns @ found.values
            out.append(log.unmasked.compared(torque))
        return out

    def _with_base(self, log: FilteredLog) -> FloatArray:
        """Return the torque of a floating base and its joints along a log, in the band, (K, m)."""
        torque = modelled_torque(self.problem.evaluator, log.unmasked, self.X)
        columns_of = self.problem.make_columns([log], self.X)
        for score, found in self.values.items():
            torque = torque + dense(columns_of(score.cause), torque.shape) @ found.values
        return torque


def compared(logs: Sequence[FilteredLog], torques: Sequence[FloatArray], robot: Robot) -> TorqueFit:
    """Compare modelled torques (K, m) of some logs with the measured ones."""
    out = TorqueFit.none(robot)
    for log, torque in zip(logs, torques, strict=True):
        out += squares(log.clear[log.kept], log.unmasked.measured, torque, log.resting)
    return out


def fit_together(result: SearchResult) -> Together:
    """Fit the declared model and the columns of all accepted effects to the training logs.

    The derivatives of the columns with respect to the searched constants are additional columns, as
    in linearised nonlinear least squares. They give the standard deviations of the constants.
    """
    problem = result.problem
    effects, log_columns = settled(problem, result.effects)
    stage = problem.stage(effects)
    along = slopes(stage, log_columns)
    plain = _solve(problem, stage.rows)
    wider = _solve(problem, stage.rows.with_columns(along)) if along else None
    X = stage.rows.X if plain is None else plain.X  # the shortest solution
    best = wider or plain
    unknown = np.full((len(X), len(X)), np.nan)
    covariance = unknown if best is None else best.covariance
    constants = iter([] if wider is None else wider.std[len(X) :])
    values, at = {}, problem.base.W.shape[2]
    known = X[:at] if problem.known is None else problem.known
    for score in effects:
        c = score.cause
        here = slice(at, at + c.size)
        std = np.full(len(c.constants), np.nan)
        if c.smooth and wider is not None:
            std = np.array([next(constants) for _ in c.constants])
        values[score] = Coefficients(X[here], covariance[here, here], std)
        at += c.size
    return Together(problem, known, values)


def _solve(problem: Problem, rows: FittedRows) -> Solution | None:
    """Solve rows for parameters and standard deviations; None if the rows do not determine them."""
    known = features_of(rows.logs, problem.robot.sigma)
    features = [known.in_band(log.unmasked.at_nodes()) for log in rows.logs]
    weighted = replace(rows, weight=rest_weights(rows), features=np.concatenate(features))
    try:
        return Wls().solve(weighted) if rows.names else None
    except IdentificationError:  # the declared model absorbs a coefficient
        return None
