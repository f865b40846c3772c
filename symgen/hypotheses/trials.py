"""Trials of changes: how much better the model predicts with each point of their grids undone.

Changes of torques share the regressor, so all of them are tried. A change of the motion needs new
rows. It is tried only if the model error is large, and on a piece of the logs. Another gravity is
also tried at small errors, because least squares hide most of it in other parameters.

A first-order column and the axes of frame 0 show that gravity is wrong. `exact_gravity` then turns
it to the best fit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.solve import SINGULAR
from symgen.estimation.values import FloatArray
from symgen.hypotheses.changes import (
    TILT,
    Change,
    Changed,
    another_gravity,
    geared_by,
    gravities,
    late,
    motion_changes,
    slow,
    torque_changes,
)
from symgen.hypotheses.effects import Score
from symgen.hypotheses.problem import Problem, Stage
from symgen.hypotheses.score import DIGITS, TINY, ScoreFit, worth_and_gain
from symgen.policy import SURE, TEMPERATURE
from symgen.symbolic.variation import variation

#: Duration of each log for trials of the motion, and for trials of gravity alone, s.
_PIECE, _LONGER = 10.0, 60.0
#: Log-odds against a change at a first look, to no change or to another size, that end its trial.
#: On two real arms, a first look is within 3 of an exact trial where one of them is probable.
_DOUBTFUL = 4.0
_ROUNDS = 3  # of Newton's method for the size of a gear ratio
#: Tolerance of the logarithm of a delay, and half the span of its second difference.
_EXACT, _APART = 1e-3, 0.05
_TURNS = 8  # most, of gravity by the Gauss-Newton method
_ROUNDED = 1e-5  # m/s2, last digit of gravity


def torque_trials(stage: Stage) -> Iterator[Changed]:
    """Yield the changes of torques with their scores, each with the most probable size.

    Wrong signs of joints on which friction would drive come first: nothing else explains that.
    """
    problem, rows = stage.problem, stage.problem.base
    links = slice(problem.evaluator.model.inertial)
    speed = np.concatenate([log.qd[log.kept] for log in problem.logs])
    lost = rows.weight * (rows.y - rows.W[..., links] @ rows.X[links])
    work = np.sum(speed * lost[:, len(problem.robot.free) :], axis=0)
    for grid in torque_changes(problem.robot, work):
        trial = _torque_trial(stage, grid)
        signs = trial.definition.name == "wrong_sign" and (work[list(trial.joints)] < 0).all()
        yield replace(trial, odds=math.inf) if signs and trial.odds > 0 else trial


def motion_trials(problem: Problem, loud: frozenset[int]) -> Iterator[Changed]:
    """Yield the changes of the motion with their scores, on a piece of the logs without effects.

    Changes that are improbable at a first look are not yielded, and get no exact trial.

    Args:
        problem: the model and its logs.
        loud: joints with large errors. Gear ratios and exchanges are tried on these joints alone,
            signs and units on all. If the set is empty, gravity alone is tried.
    """
    piece = problem.piece(_PIECE if loud else _LONGER)
    alone = piece.stage()
    for grid in motion_changes(piece.robot, loud) if loud else gravities(piece.robot):
        fits, least = [alone.score.alone] * len(grid), -math.inf
        if grid[0].factors and not grid[0].turns:
            fits = [_look(alone, change) for change in grid]
            least = max(fit.score for fit in fits) - _DOUBTFUL
            if _best_of(alone, grid, fits).odds < -_DOUBTFUL:
                continue
        for k, change in enumerate(grid):
            if fits[k].score < least:
                continue
            try:
                fits[k] = _fit_of_motion(alone, change)
            except (IdentificationError, np.linalg.LinAlgError):
                fits[k] = alone.score.alone
        best = _best_of(alone, grid, fits)
        if any(best.cause.gravity or ()):
            # The opposite gravity carries the same weight if all first moments change their sign.
            nearest = np.array(best.cause.gravity)
            first = [exact_gravity(alone, g, turns=1) for g in (nearest, -nearest)]
            near = [np.array(change.gravity) for change in first if _may_lead(alone, change)]
            both = [exact_gravity(alone, gravity) for gravity in near]
            # A turned gravity must beat an axis by SURE, and by twice that if it points away from
            # the gravity of the file.
            for change in both:
                against = np.dot(change.gravity or (), variation(piece.robot).gravity) < 0
                fit = _fit_of_motion(alone, change)
                fits.append(fit._replace(score=fit.score - SURE * (1 + against)))
            best = _best_of(alone, [*grid, *both], fits)
        yield best


def exact_change(stage: Stage, new: Score) -> Changed:
    """Return the gear ratio or tilt whose first-order approximation is the column of an effect."""
    problem, size = stage.problem, 1.0
    if new.cause.name == TILT:
        change = exact_gravity(stage, variation(problem.robot).gravity)
    else:
        (j,) = new.cause.joints
        for _ in range(_ROUNDS):
            other = problem if size == 1.0 else problem.changed(geared_by(j, size))
            rows = other.stage()
            fit = rows.score.fit_with(rows.log_columns(new.cause))
            size *= 1 + float(fit.coefficients[0])
        change = geared_by(j, size)
    return Changed(change, new.odds, new.worth, new.gain)


def exact_gravity(stage: Stage, gravity: FloatArray, turns: int = _TURNS) -> Change:
    """Turn gravity to the best fit of a model whose link parameters are fitted to each direction.

    Gauss-Newton with the columns of the turn orthogonal to the model (variable projection).

    Args:
        stage: the model with the gravity of the file, and the accepted effects.
        gravity: (3,) near the solution, m/s2; its norm stays.
        turns: largest number of steps.
    """
    problem, size = stage.problem, np.linalg.norm(gravity)
    for _ in range(turns):
        change = another_gravity(problem.robot, gravity)
        rows = problem.tried(change).stage(stage.effects).rows
        pulls = problem.pulls @ rows.X[: problem.pulls.shape[-1]]
        fields = -np.cross(np.eye(3), gravity)  # d gravity/d angle about each axis
        free = rows.orthogonal_part(rows.whitened(np.tensordot(pulls, fields, (0, 1))))
        inverse = np.linalg.pinv(free.T @ free, SINGULAR)
        turn = inverse @ (free.T @ rows.whitened_residual.ravel()) @ fields
        gravity = gravity + turn
        gravity = gravity * (size / np.linalg.norm(gravity))
        if np.abs(turn).max() < _ROUNDED:
            break
    std = np.sqrt(TEMPERATURE * np.diag(fields.T @ inverse @ fields))
    hidden = np.linalg.norm(fields.T @ (np.eye(3) - inverse @ (free.T @ free)), axis=1)
    std[hidden > np.sqrt(SINGULAR) * size] = np.nan  # torque does not depend on this component
    return another_gravity(problem.robot, gravity, std.tolist())


def _torque_trial(stage: Stage, grid: Sequence[Change]) -> Changed:
    """Return the most probable point of a grid of changes of the torques, refined."""
    fits = [_fit_of_torque(stage, c) for c in grid]
    best = _best_of(stage, grid, fits)
    if not (best.cause.delay or best.cause.lag) or best.odds <= 0:
        return best
    change = _refined_change(stage, best.cause)
    fit = _fit_of_torque(stage, change)
    again = _best_of(stage, [change], [fit])
    return again if again.odds > best.odds else best


def _may_lead(alone: Stage, change: Change) -> bool:
    """Whether a change is not improbable."""
    return _best_of(alone, [change], [_fit_of_motion(alone, change)]).odds > -_DOUBTFUL


def _look(alone: Stage, change: Change) -> ScoreFit:
    """Return the fit to the changed logs in the weights of rows and joints of the model."""
    problem = alone.problem
    if [*change.factors] == ["tau"]:
        fit = _fit_of_torque(alone, change)
        return _as_recorded(alone, change, fit, alone.score.counts)
    score = problem.looked(change).stage().score
    return _as_recorded(alone, change, score.alone, score.counts)


def _fit_of_motion(alone: Stage, change: Change) -> ScoreFit:
    """Return the fit to the changed logs."""
    problem = alone.problem
    if [*change.factors] == ["tau"] and not problem.robot.floating:  # the regressor stays
        scale = change.scale(problem.robot)
        problem = replace(problem, base=problem.base.with_torque(1 / scale))
    else:
        problem = problem.tried(change)
    score = problem.stage().score
    return _as_recorded(alone, change, score.alone, score.counts)


def _as_recorded(alone: Stage, change: Change, fit: ScoreFit, counts: FloatArray) -> ScoreFit:
    """Return a fit to changed logs, (m, folds) counts of rows, as one of the recorded torque."""
    score = alone.score
    squared = change.scale(alone.problem.robot) ** 2
    variance = squared[:, None] * fit.squares / np.maximum(counts, 1.0)
    logs = np.log(np.maximum(variance + score.misfit[:, None] ** 2, TINY))
    density = -0.5 / score.temperature * float(np.sum(score.counts * logs))
    return fit._replace(score=density, variance=fit.variance * squared)


def _best_of(stage: Stage, grid: Sequence[Change], fits: Sequence[ScoreFit]) -> Changed:
    """Return the most probable point of a grid, with the odds marginalised over the grid."""
    alone, size = stage.score.alone, stage.problem.base.size
    odds = np.array([fit.score - alone.score for fit in fits])
    k = int(np.argmax(odds.round(DIGITS)))
    change = grid[k]
    # Each wrong sign costs the same. A set and its complement fit alike: the smaller one counts.
    few = min(len(change.joints), stage.problem.robot.n - len(change.joints))
    prior = math.log(change.definition.odds) * max(1, few)
    odds_of_grid = float(np.logaddexp.reduce(odds)) - math.log(len(grid)) + prior
    worth, gain = worth_and_gain(alone.variance, fits[k].variance, size, ())
    return Changed(change, odds_of_grid, worth, gain)


def _fit_of_torque(stage: Stage, change: Change) -> ScoreFit:
    """Return the fit to the torques with a change undone."""
    problem = stage.problem
    return stage.score.of_torque(problem.torque_without(change) - problem.base.measured)


def _refined_change(stage: Stage, change: Change) -> Change:
    """Return a delay or a filter with its most probable size, and the deviation of that."""
    from scipy.optimize import minimize_scalar

    make, value = (late, change.delay) if change.delay else (slow, change.lag)

    def changed(x: float) -> Change:
        return make(change.joints, math.copysign(math.exp(x), value))

    def cost(x: float) -> float:
        return -_fit_of_torque(stage, changed(x)).score

    near = math.log(abs(value))
    bounds = near - math.log(2), near + math.log(2)
    best = minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": _EXACT})
    low, high = cost(best.x - _APART), cost(best.x + _APART)
    curvature = (low + high - 2 * best.fun) / _APART**2
    if curvature <= 0:
        return changed(best.x)
    (size,) = changed(best.x).sizes
    known = size._replace(std=abs(size.value) / math.sqrt(curvature))
    return replace(changed(best.x), sizes=(known,))
