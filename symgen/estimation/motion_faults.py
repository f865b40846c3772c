"""Faults of the motion that the model shows: exchanged, turned, in degrees, another gear ratio."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.channels import Fault, gear_ratio, multiplied
from symgen.estimation.filtered import FilteredLog, filtered
from symgen.estimation.recorded import (
    CLEARER,
    Logs,
    Recorded,
    Rows,
    equations_of,
    recorded,
    what_is_left,
    with_column,
)
from symgen.estimation.summary import Blocks, block_errors, held_out_error, placed, summary
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: Such a fault leaves so much of the error, at most.
EXCHANGED = 0.7
#: Logarithms of gear ratios that are tried first, and how near they are found.
_LOGARITHMS, _NEAR = tuple(0.27 * k for k in range(-3, 4)), 0.01
_RATIO = 0.03  # of a gear ratio: what is nearer to 1 is not told from what models miss
_SLIGHT = 1e-4  # of a gear ratio, for its derivative
_NODES = 8_000  # of all logs together, at which faults are tried


@dataclass(frozen=True, eq=False)
class Trial:
    """Logs, no longer than needed, on which faults of the motion are tried.

    Attributes:
        evaluator: the compiled model.
        logs, held: training and validation logs.
        case: their torques as they are recorded.
        rows: equations of the training logs.
    """

    evaluator: Evaluator
    logs: Sequence[FilteredLog]
    held: Sequence[FilteredLog]
    case: Recorded
    rows: Rows

    def right(self, fault: Fault, group: Sequence[FilteredLog]) -> Blocks:
        """Summarise logs without a fault."""
        rows = equations_of(self.evaluator, map(fault.undone, group))
        return summary(placed(rows), len(self.case.base.size))

    def error(self, fault: Fault) -> float:
        """Return the error on folds left out of the training logs without it."""
        blocks = self.right(fault, self.logs)
        return held_out_error(block_errors(blocks, blocks))

    def judged(self, faults: Iterable[Fault]) -> list[Fault]:
        """Return the faults that leave little when they are undone."""
        found = []
        for fault in faults:
            left, _ = self.case.left(
                self.right(fault, self.logs), partial(self.right, fault, self.held)
            )
            if left < EXCHANGED:
                found.append(replace(fault, left=left))
        return found


def trial_of(evaluator: Evaluator, train: Logs, held: Logs, case: Recorded) -> Trial:
    """Take logs with their equations, or where they are long the first part of each."""
    if not (_long(train[0]) or _long(held[0])):
        return Trial(evaluator, train[0], held[0], case, train[1])
    logs, other = _short(train[0]), _short(held[0])
    rows = equations_of(evaluator, logs)
    return Trial(evaluator, logs, other, recorded(rows, equations_of(evaluator, other)), rows)


def geared_joints(trial: Trial) -> list[Fault]:
    """Find joints that were recorded through another gear ratio."""
    X = trial.case.base.fit()
    as_recorded = [_modelled(trial, log, X) for log in trial.logs]
    joints = range(len(trial.case.base.size))
    found = (
        _fitted_ratio(trial, j) for j in joints if _another_ratio_helps(trial, j, X, as_recorded)
    )
    # An error that falls to the end of what is tried is that of a joint of which little is known.
    inside = (f for f in found if _RATIO < abs(math.log(f.value)) < _LOGARITHMS[-1])
    return trial.judged(inside)


def _modelled(trial: Trial, log: FilteredLog, X: FloatArray) -> FloatArray:
    """Return the torque of a model along a log in the comparison band, (K, n)."""
    regressor = trial.evaluator["torque_regressor"]

    def torque(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        return np.asarray(np.asarray(regressor(q, qd, qdd))[:, :, : len(X)] @ X)

    return np.concatenate([x for _, x in log.modelled(torque)])


def _another_ratio_helps(
    trial: Trial, j: int, X: FloatArray, as_recorded: Sequence[FloatArray]
) -> bool:
    """Whether the error falls where the gear ratio of a joint changes from 1, to first order.

    tau = W X + delta (d/dr tau(r q, r qd, r qdd) + tau_j e_j), differences for d/dr.
    """
    case, extended = trial.case, []
    for log, rows, torque in zip(trial.logs, trial.rows, as_recorded, strict=True):
        turned = multiplied(log, (j,), 1 + _SLIGHT, ("q", "qd"))
        slope = (_modelled(trial, turned, X) - torque) / _SLIGHT
        slope[:, j] += log.measured[:, j]
        extended.append(with_column(log, rows, slope))
    blocks = summary(placed(extended), len(case.base.size))
    return what_is_left(case.own, block_errors(blocks, blocks))[0] <= CLEARER


def _fitted_ratio(trial: Trial, j: int) -> Fault:
    """Return the gear ratio of a joint that leaves the smallest error on folds left out."""

    def error(x: float) -> float:
        return trial.error(gear_ratio(j, math.exp(x)))

    tried = {x: error(x) for x in _LOGARITHMS}
    apart = _LOGARITHMS[1] - _LOGARITHMS[0]
    while apart > _NEAR:
        apart /= 2
        best = min(tried, key=lambda x: tried[x])
        tried |= {x: error(x) for x in (best - apart, best + apart)}
    return gear_ratio(j, math.exp(min(tried, key=lambda x: tried[x])))


def _nodes(logs: Sequence[FilteredLog]) -> int:
    return sum(log.rows.nodes for log in logs)


def _long(logs: Sequence[FilteredLog]) -> bool:
    return _nodes(logs) > _NODES


def _short(logs: Sequence[FilteredLog]) -> list[FilteredLog]:
    """Return the logs, or the first part of each where models are evaluated at many nodes."""
    if not _long(logs):
        return list(logs)
    total = _nodes(logs)
    cut = [log.samples.cut(slice(0, len(log.t) * _NODES // total)) for log in logs]
    return [filtered(s, log.band) for s, log in zip(cut, logs, strict=True)]
