"""Choose the filter cutoff and the kind of speeds with the smallest held-out torque error.

A low cutoff distorts the motion; a high one lets noise of accelerations into the regressor. Both
increase the torque error on folds of the training logs that the fit does not use. symgen measures
this error in one comparison band for all cutoffs. Joints have equal weight, each relative to its
smallest error. All errors contain the same torque noise, so symgen compares them block by block of
time. A cutoff is as good as the best one if its error is at most one standard deviation of the
difference larger. This is the one-standard-error rule (Breiman et al. 1984, section 3.4.3).

In a log of point-to-point moves, joints are at rest most of the time. At each rest, Coulomb
friction has another value, which no column explains. Plain least squares would attribute it to
gravity. But rows at rest are the only information on joints that hold a position while others move.
They therefore keep a weight: the torque deviation of the joint in motion over that at rest (Gautier
1997). symgen estimates it from the training logs. The residual at a rest is one unknown torque in
all of its rows, so a rest counts as one observation, however long it lasts. The deviation at rest
is therefore computed from sums over rests, per square root of a row.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.data.log import MIN_SAMPLES
from symgen.data.mask import Bools, resting, rms, spans
from symgen.data.signals import (
    OPEN,
    Samples,
    comparison_band,
    lowpass,
    noise_of_differences,
    require_cutoff,
)
from symgen.estimation.band import Band, Rests, rest_speeds
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.masking import require_equations
from symgen.estimation.solve import PASSES
from symgen.estimation.summary import BLOCKS, block_errors, block_summary
from symgen.estimation.system import Rows, join, torque_equations
from symgen.estimation.values import FloatArray
from symgen.parallel import in_order
from symgen.policy import ROUNDING
from symgen.runtime.evaluator import Evaluator

#: Initial weight of equations at rest, and its lower limit.
_FIRST, _LEAST = 0.1, 1e-3


def find_rests(logs: Sequence[Samples], sigma: Sequence[int]) -> Rests | None:
    """Return the speeds of rest in the logs, with initial weights; None if no joint rests.

    Args:
        logs: the training logs.
        sigma: (n,) types of the joints.
    """
    slow = rest_speeds(logs, sigma)
    if not sigma:
        return None
    if not any(resting(s.q, s.step, slow).any() for s in logs):
        return None
    return Rests(tuple(map(float, slow)), (_FIRST,) * len(slow))


def weigh_rests(evaluator: Evaluator, logs: Sequence[Samples], band: Band) -> Band:
    """Return a band with the weights of equations at rest: deviation in motion over that at rest.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs.
        band: band of the run, with initial weights.
    """
    if band.rests is None:
        return band
    rows = join([torque_equations(evaluator, filter_log(s, band)) for s in logs])
    used = rows.weight > 0
    rest = used & (rows.weight < 1)  # the initial weights are below one
    weight = np.full(rest.shape[1], _LEAST)  # joints in motion determine X before joints at rest do
    for _ in range(PASSES):
        weighted = replace(rows, weight=np.where(rest, weight, used * 1.0))
        error = rows.y - rows.W @ block_summary(weighted).fit()
        for j, of_joint in enumerate(used.T):
            errors, rests = error[of_joint, j], rest[of_joint, j]
            weight[j] = rest_weight(errors, rests)
    weight = weight[len(weight) - len(band.rests.slow) :]  # the base has none
    return replace(band, rests=replace(band.rests, weight=tuple(weight.tolist())))


def rest_weight(error: FloatArray, rest: Bools) -> float:
    """Return the residual deviation in motion over that at rest; 1 if they do not differ.

    Args:
        error: (K,) residuals of a joint, in the order of time.
        rest: (K,) which of them a rest of the joint affects.
    """
    moved = error[~rest]
    if min(len(moved), int(rest.sum())) < MIN_SAMPLES:
        return 1.0
    rested = error[rest]
    sums = np.array([error[slice(*span)].sum() for span in spans(rest)])
    squares = max(float(sums @ sums), float(rested @ rested))
    at_rest = max(squares / len(rested), 1e-300)
    ratio = math.sqrt(float(np.mean(moved**2)) / at_rest)
    return min(max(ratio, _LEAST), 1.0)


#: Cutoffs to try, in comparison bands.
CUTOFFS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)
_FINER = 2**0.5  # approximate ratio of two neighbours


def choose_band(
    evaluator: Evaluator,
    logs: Sequence[Samples],
    cutoff: float | None = None,
    *,
    measured_speeds: bool = False,
    threads: int = 1,
) -> Band:
    """Choose the band of a run from its training logs.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs.
        cutoff: cutoff of the filter, Hz; None to choose it.
        measured_speeds: whether to always use measured speeds, as instrumental variables need.
        threads: number of threads that try cutoffs.

    Raises:
        LogError: no filter can have this cutoff, or the mask covers all samples.
    """
    for s in logs:
        if cutoff is not None:
            require_cutoff(s.name, cutoff, s.step, s.length)
    rate = min(1 / s.step for s in logs)
    measured = not any(s.velocity_derived for s in logs)
    velocity = "measured" if measured else "derived"
    rests = find_rests(logs, evaluator.model.robot.sigma)
    start = Band(rate, cutoff or rate / 2, comparison_band(logs), velocity, rests)
    grid = [start.cutoff_hz]
    if cutoff is None:
        grid = [c * start.comparison_hz for c in CUTOFFS]
        grid = [hz for hz in grid if hz < OPEN * rate]
        # no filter: the sampling rate is low
        grid += [start.cutoff_hz] if len(grid) < len(CUTOFFS) else []
    kinds = [velocity] if measured_speeds or not measured else ["measured", "derived"]
    if len(grid) == len(kinds) == 1:
        return weigh_rests(evaluator, logs, start)

    unfiltered = [FilteredLog(s, start, s.q, s.qd) for s in logs]
    torques = [log.measured for log in unfiltered]  # the same for every cutoff

    def errors_at(hz: float) -> FloatArray:
        bands = [replace(start, cutoff_hz=hz, velocity=kind) for kind in kinds]
        errors = _errors(evaluator, logs, torques, bands)
        return np.maximum(errors, ROUNDING**2 / BLOCKS)

    alike = list(in_order(errors_at, grid, threads))
    # Encoder steps widen the comparison band beyond the motion. If the lowest cutoff is the best, a
    # lower one may be better, as long as it removes noise and no motion.
    while cutoff is None and _best(alike)[1] == 0 and _takes_noise(logs, grid[0] / _FINER):
        grid.insert(0, grid[0] / _FINER)
        alike.insert(0, errors_at(grid[0]))
    errors = np.stack(alike, axis=1)
    least = errors.sum(axis=2)[_best(alike)]
    size = np.where(least > 0, least, np.inf)
    errors = (errors / size).sum(axis=3)
    middle = [_middle(same) for same in errors]
    totals = [same[i].sum() for same, i in zip(errors, middle, strict=True)]
    k = int(np.argmin(totals))
    hz = grid[middle[k]]
    chosen = replace(start, cutoff_hz=hz, velocity=kinds[k])
    return weigh_rests(evaluator, logs, chosen)


def _takes_noise(logs: Sequence[Samples], hz: float) -> bool:
    """Return whether a low-pass removes from every position less motion than it contains noise."""
    return all(
        1 / hz < s.length  # one period over the log
        and (rms(s.q - lowpass(s.q, s.step, hz)) <= 2**0.5 * channel_noise(s.q)).all()
        for s in logs
    )


def channel_noise(x: FloatArray) -> FloatArray:
    """Return the noise (n,) of channels (N, n) from sixth differences, at least the rounding."""
    steps = np.abs(np.diff(x, axis=0))
    least = np.min(steps, axis=0, where=steps > 0, initial=np.inf)
    rounding = np.where(np.isfinite(least), least, 0.0) / math.sqrt(12)
    return np.maximum(noise_of_differences(x), rounding)


def _best(errors: Sequence[FloatArray]) -> tuple[int, int]:
    """Return the kind of speed and the cutoff with the smallest error, (kinds, B, m) each."""
    totals = [e.sum(axis=(1, 2)) for e in errors]
    total = np.stack(totals, axis=1)
    kind, k = np.unravel_index(total.argmin(), total.shape)
    return int(kind), int(k)


def _middle(errors: FloatArray) -> int:
    """Return the middle of the range of cutoffs that are as good as the best one.

    Below this range the filter distorts the motion; above it, noise enters.

    Args:
        errors: (C, B) squared errors by cutoff and block.
    """
    best = int(errors.sum(axis=1).argmin())
    more = errors - errors[best]
    blocks = more.shape[1]
    std = math.sqrt(blocks) * more.std(axis=1, ddof=1)
    good = more.sum(axis=1) <= std
    low = high = best
    while low > 0 and good[low - 1]:
        low -= 1
    while high < len(good) - 1 and good[high + 1]:
        high += 1
    return (low + high) // 2


def _errors(
    evaluator: Evaluator,
    logs: Sequence[Samples],
    measured: Sequence[FloatArray],
    bands: Sequence[Band],
) -> list[FloatArray]:
    """Return the squared errors of weighted least squares of the torque equations, (B, m) a band.

    Each block of time is predicted by a fit without its fold. Bands may differ in their speeds
    only.
    """
    parts: list[list[Rows]] = [[] for _ in bands]
    for s, torque in zip(logs, measured, strict=True):
        q = None
        for out, band in reversed(list(zip(parts, bands, strict=True))):  # derived speeds first
            log = filter_log(s, band, q)
            q, equations = log.q, torque_equations(evaluator, log, measured=torque)
            require_equations(s, equations, evaluator.model.robot)
            out.append(equations)
    blocks = [block_summary(join(rows)) for rows in parts]
    return [block_errors(b, b) for b in blocks]
