"""Refine the searched constants of effects between their grid values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from symgen.errors import RobotError
from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import START, Candidate, LogColumns, Score
from symgen.hypotheses.problem import Problem, Stage
from symgen.hypotheses.score import Columns, dense

_EVALUATIONS = 20
#: Relative change of the sum of squares that ends a fit: a tenth of a std for ten thousand rows.
_CHANGE = 1e-6
_DIFFERENCE = 1e-3  # relative step of a constant in the difference of its columns


def slopes(stage: Stage, log_columns: LogColumns) -> list[Columns]:
    """Return d(columns @ coefficients)/d(constants), (K, c) by joint, of each smooth effect."""
    out: list[Columns] = []
    at = 0
    for s in stage.effects:
        c, coefficients = s.cause, stage.coefficients[at : at + s.cause.size]
        at += c.size
        if not c.smooth:
            continue
        parts: dict[int, list[FloatArray]] = {j: [] for j in s.columns}
        for name, value in c.constants.items():
            h = _step(c, name, value)
            low, high = (log_columns(c.moved({name: value + d})) for d in (-h, h))
            for j in s.columns:
                parts[j].append((high[j] - low[j]) @ coefficients / (2 * h))
        out.append({j: np.column_stack(columns) for j, columns in parts.items()})
    return out


def _step(candidate: Candidate, name: str, value: float) -> float:
    """Return the step of the difference of a constant; for a start time, half a grid step."""
    if name == START:
        times = candidate.definition.nonlinear[name]
        return (times.high - times.low) / (2 * times.count)
    return _DIFFERENCE * (abs(value) or 1.0)


def settled_constants(
    baseline: Problem, accepted: Sequence[Score], log_columns: LogColumns
) -> Sequence[Score]:
    """Fit the constants of all effects in one least-squares problem with the model.

    Variable projection: each value of the constants has a fit of parameters and coefficients. The
    constants stay unchanged if the logs do not determine the new ones.

    Golub and Pereyra 1973, SIAM Journal on Numerical Analysis 10; Jacobian of Kaufman 1975.
    """
    from scipy.optimize import least_squares

    chosen = [s.cause for s in accepted if s.cause.smooth]
    start = [value for c in chosen for value in c.constants.values()]
    if not start:
        return accepted
    positive = [c.definition.nonlinear[name].by_ratio for c in chosen for name in c.constants]
    low = np.where(positive, 0.0, -np.inf)
    sigma = baseline.stage(accepted).rows.sigma

    @lru_cache(maxsize=2)
    def point(*constants: float) -> Stage:
        return baseline.stage(_moved(accepted, constants, log_columns))

    def residual(constants: FloatArray) -> FloatArray:
        try:
            system = point(*constants).rows
        except (RobotError, np.linalg.LinAlgError):  # a torque is not finite: shorten the step
            return np.full(baseline.base.y.size, np.inf)
        return (system.whitened_residual * system.sigma / sigma).ravel()

    def jacobian(constants: FloatArray) -> FloatArray:
        stage = point(*constants)
        system, along = stage.rows, slopes(stage, log_columns)
        columns = np.concatenate([dense(c, system.y.shape) for c in along], axis=2)
        if not np.isfinite(columns).all():  # a torque with a kink
            raise np.linalg.LinAlgError
        free = system.orthogonal_part(system.whitened(columns))
        scale = np.tile(system.sigma / sigma, len(system.y))  # rows are joint by joint
        return -free * scale[:, None]

    try:
        fit = least_squares(
            residual,
            start,
            jacobian,
            (low, np.inf),
            ftol=_CHANGE,
            x_scale="jac",
            max_nfev=_EVALUATIONS,
        )
    except (RobotError, np.linalg.LinAlgError):  # a torque near the start is not finite
        return accepted
    stage = point(*fit.x)
    rank = stage.rows.with_columns(slopes(stage, log_columns)).rank
    return stage.effects if rank == stage.rows.rank + len(start) else accepted


def _moved(
    accepted: Sequence[Score], constants: Sequence[float], log_columns: LogColumns
) -> list[Score]:
    """Return the effects with new constants, rounded to six digits.

    Raises:
        RobotError: the torque of an effect of the robot file is not finite.
        LinAlgError: the torque of another effect is not finite.
    """
    values = iter(constants)
    out = []
    for s in accepted:
        if s.cause.smooth:
            new = {name: float(f"{next(values):.6g}") for name in s.cause.constants}
            candidate = s.cause.moved(new)
            columns = log_columns(candidate)
            if not all(np.isfinite(np.vdot(c, c)) for c in columns.values()):
                raise np.linalg.LinAlgError
            s = replace(s, cause=candidate, columns=columns)
        out.append(s)
    return out
