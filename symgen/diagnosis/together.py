"""All effects of a diagnosis as columns of the declared model, fitted together on torque rows.

This fit gives the values of what a robot file cannot declare, and the standard deviations of
searched constants. With fixed parameters it is the only fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.estimators import Wls
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog, kept_spans
from symgen.estimation.solve import Solution
from symgen.estimation.system import Equations, LinearSystem, joint_equations
from symgen.estimation.torque_error import TorqueFit, squares
from symgen.estimation.values import FloatArray
from symgen.hypotheses.confirm import settled
from symgen.hypotheses.effects import LogColumns, Score
from symgen.hypotheses.problem import Problem, Stage
from symgen.hypotheses.refine import slopes
from symgen.hypotheses.registry import SearchResult
from symgen.hypotheses.rows import Rows, with_rests
from symgen.hypotheses.score import dense
from symgen.robot.types import Robot

_CORRELATION = 2  # number of correlated rows that count as one, at four rows a period


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
        effects: the effects, with settled constants.
        X: (p + c,) parameters of the model, which are empty if they are fixed, and coefficients.
        values: the values of each effect.
    """

    problem: Problem
    effects: tuple[Score, ...]
    X: FloatArray
    values: tuple[Coefficients, ...]

    def of(self, score: Score) -> Coefficients:
        """Return the values of one of the effects."""
        return self.values[self.effects.index(score)]

    def torques(self, logs: Sequence[FilteredLog]) -> list[FloatArray]:
        """Return the torque along some logs, in the band, (K, n)."""
        problem, known = self.problem, self.problem.known
        count = len(self.X) - sum(s.cause.size for s in self.effects)
        X = self.X[:count] if known is None else known
        out = []
        for log in logs:
            torques = problem.torques_along(log, X)
            torque, at = torques.model, count
            for c in (s.cause for s in self.effects):
                columns = dense(c.columns(log, torques), log.tau.shape)
                torque = torque + columns @ self.X[at : at + c.size]
                at += c.size
            out.append(log.unmasked.compared(torque))
        return out


def compared(logs: Sequence[FilteredLog], torques: Sequence[FloatArray], robot: Robot) -> TorqueFit:
    """Compare modelled torques (K, n) of some logs with the measured ones."""
    out = TorqueFit.none(robot)
    for log, torque in zip(logs, torques, strict=True):
        out += squares(log.clear[log.kept], log.unmasked.measured, torque, log.resting)
    return out


def fit_together(result: SearchResult) -> Together:
    """Fit the declared model and the columns of all accepted effects to the training logs."""
    problem = result.problem
    effects, log_columns = settled(problem, result.effects)
    stage = problem.stage(effects)
    names = () if problem.is_fixed else problem.evaluator.model.base.names
    p, count = len(names), sum(s.cause.size for s in effects)
    names += tuple(f"{s.cause.name} {i}" for s in effects for i in range(s.cause.size))
    X, covariance = stage.rows.X, np.full((p + count, p + count), np.nan)
    try:
        solution = _solve(problem, names, stage.rows)
        X, covariance = solution.X, solution.covariance
    except IdentificationError:  # the declared model absorbs a coefficient: the shortest solution
        pass
    wider = _with_constants(stage, log_columns, names)
    if wider is not None:
        covariance = wider.covariance
    constants = iter([] if wider is None else wider.std[p + count :])
    values, at = [], p
    for c in (s.cause for s in effects):
        here = slice(at, at + c.size)
        std = np.full(len(c.constants), np.nan)
        if c.smooth and wider is not None:
            std = np.array([next(constants) for _ in c.constants])
        values.append(Coefficients(X[here], covariance[here, here], std))
        at += c.size
    return Together(problem, effects, X, tuple(values))


def _with_constants(
    stage: Stage, log_columns: LogColumns, names: tuple[str, ...]
) -> Solution | None:
    """Return the solution with a column for each searched constant; None if there is none.

    The derivatives of the columns with respect to the constants are additional columns, as in
    linearised nonlinear least squares.
    """
    along = slopes(stage, log_columns)
    count = sum(next(iter(columns.values())).shape[1] for columns in along)
    if not count:
        return None
    constants = tuple(f"constant {i}" for i in range(count))
    try:
        return _solve(stage.problem, (*names, *constants), stage.rows.with_columns(along))
    except IdentificationError:  # the logs do not determine the constants
        return None


def _solve(problem: Problem, names: tuple[str, ...], rows: Rows) -> Solution:
    """Solve rows for parameters and standard deviations; empty if there are no parameters."""
    if not names:
        none = np.zeros((0, 0))
        return Solution(np.zeros(0), none, none, 1.0, ())
    known = features_of(rows.logs, problem.robot.sigma)
    rested = with_rests(rows)
    out: list[Equations] = []
    for log, at in zip(rows.logs, kept_spans(rows.logs), strict=True):
        W = rows.W[at].transpose(1, 0, 2)
        random = known.in_band(log.unmasked.modelled).transpose(1, 0, 2)
        free = rested.moves[at] > 0
        out += joint_equations(
            log, W, rows.y[at], log.compared_t, _CORRELATION, random, log.resting, free
        )
    return Wls().solve(LinearSystem(names, tuple(out)))
