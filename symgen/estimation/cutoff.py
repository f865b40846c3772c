"""Which cutoff, and which speeds: those with the smallest error on data that the fit did not see.

A cutoff too low bends the motion, one too high lets the noise of accelerations into the regressor.
Neither is known beforehand, and both show in the same number: the error in torque, in a comparison
band that is the same for all, on folds of the training logs that were left out of the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from symgen.data.signals import Samples, require_cutoff
from symgen.estimation.band import OPEN, Band, comparison_band
from symgen.estimation.blocks import FOLDS, block_errors, held_out_error, placed, summary
from symgen.estimation.filtered import filtered
from symgen.estimation.masking import require_left
from symgen.estimation.system import torque_equations
from symgen.runtime.evaluator import Evaluator

#: Cutoffs that are tried, in comparison bands.
CUTOFFS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)
#: Derived speeds are taken where they leave an error smaller by this share.
_BETTER = 0.02
#: Errors that differ by less are as good as each other.
_AS_GOOD = 0.01
_SAMPLES = 120_000  # of all logs together, that the scan looks at


def choose_band(
    evaluator: Evaluator,
    logs: Sequence[Samples],
    cutoff: float | None = None,
    *,
    own_speeds: bool = False,
) -> Band:
    """Choose the band of a run from its training logs.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs.
        cutoff: of the filter, Hz, where the user gives it.
        own_speeds: whether measured speeds are kept in any case, as instrumental variables ask.

    Raises:
        LogError: a cutoff that no filter can have, or a mask that leaves nothing.
    """
    for s in logs:
        if cutoff is not None:
            require_cutoff(s.name, cutoff, s.step, float(s.t[-1] - s.t[0]))
    rate = min(1 / s.step for s in logs)
    measured = not any(s.velocity_derived for s in logs)
    velocity = "measured" if measured else "derived"
    start = Band(rate, cutoff or rate / 2, comparison_band(logs), velocity)
    seen = _sample(logs)
    tried: dict[tuple[float, str], float] = {}

    def error(hz: float, velocity: str) -> float:
        if (hz, velocity) not in tried:
            band = replace(start, cutoff_hz=hz, velocity=velocity)
            tried[hz, velocity] = _error(evaluator, seen, band)
        return tried[hz, velocity]

    best = start.cutoff_hz
    if cutoff is None:
        grid = [c * start.comparison_hz for c in CUTOFFS]
        grid = [hz for hz in grid if hz < OPEN * rate]
        grid += [best] if len(grid) < len(CUTOFFS) else []  # no filter, where the rate is low
        best = _middle(grid, lambda hz: error(hz, start.velocity))
    chosen = (best, start.velocity)
    if measured and not own_speeds:
        near = [best] if cutoff is not None else [best / 1.4, best, 1.4 * best]
        lowest = CUTOFFS[0] * start.comparison_hz
        near = [hz for hz in near if lowest <= hz < OPEN * rate] or [best]
        other = _middle(near, lambda hz: error(hz, "derived"))
        own = error(*chosen) if cutoff is not None else tried[chosen]
        if error(other, "derived") < (1 - _BETTER) * own:
            chosen = (other, "derived")
    return replace(start, cutoff_hz=chosen[0], velocity=chosen[1])


def _middle(cutoffs: Sequence[float], error: Callable[[float], float]) -> float:
    """Return the middle of the cutoffs around the best whose errors are as good as its own.

    The motion is bent below them, and noise comes in above.
    """
    errors = [error(hz) for hz in cutoffs]
    low = high = errors.index(min(errors))
    good = (1 + _AS_GOOD) * errors[low]
    while low > 0 and errors[low - 1] <= good:
        low -= 1
    while high < len(errors) - 1 and errors[high + 1] <= good:
        high += 1
    return cutoffs[(low + high) // 2]


def _sample(logs: Sequence[Samples]) -> list[Samples]:
    """Return the logs, or where they are long FOLDS stretches of each."""
    total = sum(len(s.t) for s in logs)
    if total <= _SAMPLES:
        return list(logs)
    out = []
    for s in logs:
        count = len(s.t)
        length = int(count * _SAMPLES / total / FOLDS)
        for f in range(FOLDS):
            first = f * count // FOLDS
            out.append(s.cut(slice(first, first + length)))
    return out


def _error(evaluator: Evaluator, logs: Sequence[Samples], band: Band) -> float:
    """Return the error of weighted least squares of the torque equations on folds left out."""
    found = []
    for s in logs:
        equations = torque_equations(evaluator, filtered(s, band))
        if s.mask is not None:
            require_left(s.name, equations)
        found.append(equations)
    torques = summary(placed(found), logs[0].q.shape[1])
    return held_out_error(block_errors(torques, torques))
