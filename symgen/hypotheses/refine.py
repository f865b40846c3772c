"""Refine the searched constants of effects between the values of their grid.

Those that torques depend on smoothly: by the Gauss-Newton method, on the constants and coefficients
of all effects and of the model. Others, as the play of a gear: by a simplex, each effect alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from symgen.errors import RobotError
from symgen.estimation.values import FloatArray
from symgen.hypotheses.effects import Candidate, Score, Seen
from symgen.hypotheses.problem import Problem
from symgen.hypotheses.rows import Rows
from symgen.hypotheses.score import Columns

_STEPS = {1: 20, 2: 60}
_ROUNDS, _HALVINGS = 8, 4  # of the Gauss-Newton method
_DIFFERENCE = 1e-3  # relative step of a constant, for the slope of its columns


def refined(
    candidate: Candidate,
    grid: Iterable[Mapping[str, float]],
    seen: Seen,
    gain: Callable[[Columns], float],
) -> tuple[Candidate, Columns]:
    """Move the constants between their neighbours on the grid to the largest gain.

    Args:
        candidate: the best candidate on the grid.
        grid: constants of all candidates that were tried.
        seen: gives the columns of a candidate.
        gain: share of the residual that columns explain.

    Returns:
        The candidate with its constants, rounded to six digits, and its columns.
    """
    from scipy.optimize import minimize

    constants, start = dict(candidate.constants), seen(candidate)
    if candidate.smooth or not 0 < len(constants) <= max(_STEPS):
        return candidate, start
    points = [*grid, constants]
    bounds = [_neighbours({p[name] for p in points}, value) for name, value in constants.items()]
    if any(low == high for low, high in bounds):
        return candidate, start
    x0 = np.array(list(constants.values()))

    def made(x: FloatArray) -> Candidate:
        return candidate.moved({n: float(f"{v:.6g}") for n, v in zip(constants, x, strict=True)})

    simplex = [x0]
    for i, (low, high) in enumerate(bounds):
        corner = x0.copy()
        corner[i] += 0.4 * (high - x0[i]) if high > x0[i] else 0.4 * (low - x0[i])
        simplex.append(corner)

    def lost(x: FloatArray) -> float:
        with suppress(RobotError):  # the torque is not finite there
            return -gain(seen(made(x)))
        return 0.0

    found = minimize(
        lost,
        x0,
        method="Nelder-Mead",
        bounds=bounds,
        options={"maxfev": _STEPS[len(x0)], "initial_simplex": np.array(simplex)},
    )
    if -found.fun <= gain(start):
        return candidate, start
    better = made(found.x)
    return better, seen(better)


def _neighbours(values: set[float], value: float) -> tuple[float, float]:
    others = sorted(values)
    at = others.index(value)
    return others[max(at - 1, 0)], others[min(at + 1, len(others) - 1)]


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
            h = _DIFFERENCE * (abs(value) or 1.0)
            low, high = (seen(c.moved({name: value + d})) for d in (-h, h))
            for j in s.columns:
                found[j].append((high[j] - low[j]) @ own / (2 * h))
        out.append({j: np.column_stack(columns) for j, columns in found.items()})
    return out


@dataclass(frozen=True, eq=False)
class _Point:
    """Effects with given constants.

    Attributes:
        effects: the effects with their columns.
        now: the equations with these columns.
        both: the equations with these columns and the slopes along constants.
    """

    effects: Sequence[Score]
    now: Rows
    both: Rows

    @property
    def loose(self) -> int:
        """Number of columns and slopes of the effects with constants."""
        smooth = [s.candidate for s in self.effects if s.candidate.smooth]
        return sum(c.size + len(c.constants) for c in smooth)

    def squares(self, sigma: FloatArray) -> float:
        """Return the residual sum of squares with the effects."""
        return float(np.sum((self.now.residual * self.now.sigma / sigma) ** 2))

    def stepped(self, share: float, seen: Seen) -> list[Score]:
        """Return the effects after a part of the Gauss-Newton step of all constants."""
        step = iter(share * self.both.X[len(self.now.X) :])
        out = []
        for s in self.effects:
            if s.candidate.smooth:
                constants = s.candidate.constants.items()
                new = {name: float(f"{value + next(step):.6g}") for name, value in constants}
                candidate = s.candidate.moved(new)
                s = replace(s, candidate=candidate, columns=seen(candidate))
            out.append(s)
        return out


def settled_constants(baseline: Problem, accepted: Sequence[Score], seen: Seen) -> Sequence[Score]:
    """Fit the constants of all effects together by least squares of the whole model.

    Each step lowers the sum of squares and keeps the parameters determined; otherwise the constants
    stay.
    """
    firm = [s for s in accepted if not s.candidate.smooth]
    if len(firm) == len(accepted):
        return accepted

    def point(effects: Sequence[Score]) -> _Point:
        now = baseline.beside(effects)
        more = slopes(effects, baseline.coefficients(now), seen)
        columns = [*(s.columns for s in effects), *more]
        return _Point(effects, now, baseline.base.with_columns(columns))

    others, at = baseline.beside(firm).rank, point(accepted)
    sigma = at.now.sigma
    for _ in range(_ROUNDS):
        for halving in range(_HALVINGS):
            # The torque, or its square, is not finite there.
            with suppress(RobotError, np.linalg.LinAlgError):
                effects = at.stepped(0.5**halving, seen)
                whole = (np.vdot(c, c) for s in effects for c in s.columns.values())
                if not np.isfinite([*whole]).all():
                    continue
                trial = point(effects)
                smaller = trial.squares(sigma) < at.squares(sigma)
                if smaller and trial.both.rank == others + trial.loose:
                    break
        else:
            return at.effects
        at = trial
    return at.effects
