"""The constants of a candidate, moved from their grid to where it explains most."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.candidates import Candidate
from symgen.diagnosis.evidence import Columns, Evidence
from symgen.diagnosis.select import Score
from symgen.errors import RobotError

FloatArray = NDArray[np.float64]
_STEPS = {1: 20, 2: 60}
_ROUNDS, _HALVINGS = 8, 4  # of Gauss and Newton's steps
_DIFFERENCE = 1e-3  # of a constant, for the slope of its columns
Seen = Callable[[Candidate], Columns]


def refined(
    candidate: Candidate,
    grid: Iterable[Mapping[str, float]],
    seen: Callable[[Candidate], Columns],
    gain: Callable[[Columns], float],
) -> tuple[Candidate, Columns]:
    """Move the constants between their neighbours on the grid to the largest gain.

    Args:
        candidate: the best one on the grid.
        grid: constants of all that were tried.
        seen: gives the columns of a candidate.
        gain: what columns explain.

    Returns:
        The candidate with its constants, six digits each, and its columns.
    """
    from scipy.optimize import minimize

    constants, remake = dict(candidate.constants), candidate.remake
    start = seen(candidate)
    if remake is None or not 0 < len(constants) <= max(_STEPS):
        return candidate, start
    points = [*grid, constants]
    bounds = [_neighbours({p[name] for p in points}, value) for name, value in constants.items()]
    if any(low == high for low, high in bounds):
        return candidate, start
    x0 = np.array(list(constants.values()))

    def made(x: FloatArray) -> Candidate:
        return remake({n: float(f"{v:.6g}") for n, v in zip(constants, x, strict=True)})

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


def slopes(score: Score, coefficients: FloatArray, seen: Seen) -> Columns | None:
    """Return d(columns @ coefficients)/d(constants), (K, c) by joint; None where there are none.

    Only effects that a file declares have constants that are smooth.
    """
    c = score.candidate
    if c.remake is None or not c.smooth:
        return None
    found: dict[int, list[FloatArray]] = {j: [] for j in score.columns}
    for name, value in c.constants.items():
        h = _DIFFERENCE * (abs(value) or 1.0)
        low, high = (seen(c.remake({**c.constants, name: value + d})) for d in (-h, h))
        for j in score.columns:
            found[j].append((high[j] - low[j]) @ coefficients / (2 * h))
    return {j: np.column_stack(columns) for j, columns in found.items()}


def all_slopes(
    accepted: Sequence[Score], coefficients: FloatArray, seen: Seen
) -> list[Columns | None]:
    """Return `slopes` of each effect; the coefficients of all stand one after the other."""
    out, at = [], 0
    for s in accepted:
        out.append(slopes(s, coefficients[at : at + s.candidate.size], seen))
        at += s.candidate.size
    return out


@dataclass(frozen=True, eq=False)
class _Point:
    """Effects with certain constants.

    Attributes:
        effects: with their columns.
        slopes: along the constants of each.
        now: the evidence with the columns.
        both: with the slopes, too.
    """

    effects: Sequence[Score]
    slopes: Sequence[Columns | None]
    now: Evidence
    both: Evidence

    @property
    def step(self) -> FloatArray:
        """Gauss and Newton's step of all constants."""
        return self.both.X[len(self.now.X) :]

    @property
    def loose(self) -> int:
        """Number of columns and slopes of the effects with constants."""
        return sum(
            s.candidate.size + len(s.candidate.constants)
            for s, slopes in zip(self.effects, self.slopes, strict=True)
            if slopes is not None
        )

    def squares(self, sigma: FloatArray) -> float:
        """Return the sum of squares that the effects leave."""
        error = self.now.moves * (self.now.y - self.now.W @ self.now.X) / sigma
        return float(np.sum(error**2))


def settled_constants(base: Evidence, accepted: Sequence[Score], seen: Seen) -> Sequence[Score]:
    """Move the constants of all effects together to the least squares of the whole model.

    On its own, beside a model that does not know it yet, an effect was refined to what explains
    most. These are steps of Gauss and Newton on constants and coefficients; each makes the sum of
    squares smaller and stays where the logs determine the model, or the constants stay.
    """
    firm = [s for s in accepted if not s.candidate.smooth]
    if len(firm) == len(accepted):
        return accepted
    others = base.with_columns(s.columns for s in firm).rank
    at = _point(base, accepted, seen)
    sigma = at.now.sigma
    for _ in range(_ROUNDS):
        step, least = at.step, at.squares(sigma)
        for _ in range(_HALVINGS):
            with suppress(RobotError):  # the torque is not finite there
                trial = _point(base, _stepped(at.effects, at.slopes, step, seen), seen)
                if trial.squares(sigma) < least and trial.both.rank == others + trial.loose:
                    break
            step = step / 2
        else:
            return at.effects
        at = trial
    return at.effects


def _point(base: Evidence, effects: Sequence[Score], seen: Seen) -> _Point:
    now = base.with_columns(s.columns for s in effects)
    moved = all_slopes(effects, now.X[base.W.shape[2] :], seen)
    more = [m for m in moved if m is not None]
    return _Point(effects, moved, now, base.with_columns([*(s.columns for s in effects), *more]))


def _stepped(
    accepted: Sequence[Score], moved: Sequence[Columns | None], step: FloatArray, seen: Seen
) -> list[Score]:
    out, at = [], 0
    for s, m in zip(accepted, moved, strict=True):
        if m is not None:
            c = s.candidate
            assert c.remake is not None
            new = {
                n: float(f"{v + step[at + i]:.6g}") for i, (n, v) in enumerate(c.constants.items())
            }
            at += len(new)
            candidate = c.remake(new)
            s = replace(s, candidate=candidate, columns=seen(candidate))
        out.append(s)
    return out
