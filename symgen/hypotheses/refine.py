"""Refine the searched constants of effects between the values of their grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from symgen.errors import RobotError
from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import Candidate, Score, Seen
from symgen.hypotheses.priors import START
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.rows import Rows
from symgen.hypotheses.score import Columns, dense

_EVALUATIONS = 20
_DIFFERENCE = 1e-3  # relative step of a constant, for the slope of its columns


def slopes(accepted: Sequence[Score], coefficients: FloatArray, seen: Seen) -> list[Columns]:
    """Return d(columns @ coefficients)/d(constants), (K, c) by joint, of each smooth effect.

    `coefficients` holds those of all effects, one effect after the other.
    """
    out: list[Columns] = []
    at = 0
    for s in accepted:
        c, own = s.candidate, coefficients[at : at + s.candidate.size]
        at += c.size
        if not c.smooth:
            continue
        found: dict[int, list[FloatArray]] = {j: [] for j in s.columns}
        for name, value in c.constants.items():
            h = _step(c, name, value)
            low, high = (seen(c.moved({name: value + d})) for d in (-h, h))
            for j in s.columns:
                found[j].append((high[j] - low[j]) @ own / (2 * h))
        out.append({j: np.column_stack(columns) for j, columns in found.items()})
    return out


def _step(candidate: Candidate, name: str, value: float) -> float:
    """Return the step of a difference; a time is sought within half of the distance to the next."""
    if name == START:
        times = candidate.definition.nonlinear[name]
        return (times.high - times.low) / (2 * times.count)
    return _DIFFERENCE * (abs(value) or 1.0)


def settled_constants(baseline: Problem, accepted: Sequence[Score], seen: Seen) -> Sequence[Score]:
    """Fit the constants of all effects together by least squares of the whole model.

    Variable projection: the parameters and coefficients are fitted at each value of the constants.
    The constants stay if the logs do not determine the new ones.

    Golub and Pereyra 1973, SIAM Journal on Numerical Analysis 10; Jacobian of Kaufman 1975.
    """
    from scipy.optimize import least_squares

    chosen = [s.candidate for s in accepted if s.candidate.smooth]
    start = [value for c in chosen for value in c.constants.values()]
    if not start:
        return accepted
    positive = [c.definition.nonlinear[name].by_ratio for c in chosen for name in c.constants]
    low = np.where(positive, 0.0, -np.inf)
    sigma = baseline.beside(accepted).sigma

    @lru_cache(maxsize=2)
    def point(*constants: float) -> tuple[Sequence[Score], Rows]:
        effects = _moved(accepted, constants, seen)
        return effects, baseline.beside(effects)

    def residual(constants: FloatArray) -> FloatArray:
        try:
            _, system = point(*constants)
        except (RobotError, np.linalg.LinAlgError):  # a torque is not finite: a shorter step
            return np.full(baseline.base.y.size, np.inf)
        return (system.residual * system.sigma / sigma).ravel()

    def jacobian(constants: FloatArray) -> FloatArray:
        effects, system = point(*constants)
        along = slopes(effects, baseline.coefficients(system), seen)
        columns = np.concatenate([dense(c, system.y.shape) for c in along], axis=2)
        rows = columns * (system.moves / system.sigma)[:, :, None]
        flat = rows.reshape(system.y.size, -1)
        basis = system.basis.reshape(system.y.size, -1)
        free = (flat - basis @ (basis.T @ flat)).reshape(rows.shape)
        return -(free * (system.sigma / sigma)[:, None]).reshape(flat.shape)

    try:
        fit = least_squares(
            residual, start, jacobian, (low, np.inf), x_scale="jac", max_nfev=_EVALUATIONS
        )
    except (RobotError, np.linalg.LinAlgError):  # a torque near the start is not finite
        return accepted
    effects, system = point(*fit.x)
    along = slopes(effects, baseline.coefficients(system), seen)
    columns = [*(s.columns for s in effects), *along]
    determined = baseline.base.with_columns(columns).rank == system.rank + len(start)
    return effects if determined else accepted


def _moved(accepted: Sequence[Score], constants: Sequence[float], seen: Seen) -> list[Score]:
    """Return the effects with other constants, of six digits.

    Raises:
        RobotError: a torque of an effect of the robot file is not finite.
        LinAlgError: that of another effect is not finite.
    """
    values = iter(constants)
    out = []
    for s in accepted:
        if s.candidate.smooth:
            new = {name: float(f"{next(values):.6g}") for name in s.candidate.constants}
            candidate = s.candidate.moved(new)
            columns = seen(candidate)
            if not all(np.isfinite(np.vdot(c, c)) for c in columns.values()):
                raise np.linalg.LinAlgError
            s = replace(s, candidate=candidate, columns=columns)
        out.append(s)
    return out
