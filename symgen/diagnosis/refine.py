"""The constants of a candidate, moved from their grid to where it explains most."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from symgen.diagnosis.candidates import Candidate
from symgen.diagnosis.evidence import Columns

FloatArray = NDArray[np.float64]
_STEPS = {1: 20, 2: 60}


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
    found = minimize(
        lambda x: -gain(seen(made(x))),
        x0,
        method="Nelder-Mead",
        bounds=bounds,
        options={"maxfev": _STEPS[len(x0)], "initial_simplex": np.array(simplex)},
    )
    better = made(found.x)
    columns = seen(better)
    return (better, columns) if gain(columns) > gain(start) else (candidate, start)


def _neighbours(values: set[float], value: float) -> tuple[float, float]:
    others = sorted(values)
    at = others.index(value)
    return others[max(at - 1, 0)], others[min(at + 1, len(others) - 1)]
