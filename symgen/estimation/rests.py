"""Joints at rest: static friction is anything between its limits, and equations hold to that only.

A log of moves between points is at rest for most of its time, and each rest is off by its own
share of Coulomb friction, which no column explains: least squares that counts all rows alike puts
it into gravity. Without these rows nothing is known of joints that hold while others move. So they
stay and weigh what they are worth: the deviation of a joint's torque in motion over that at rest,
as weighted least squares weighs logs (Gautier 1997), found from the training logs as the band is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symgen.data.mask import mean_speeds, resting, slow_speeds
from symgen.data.signals import Samples
from symgen.estimation.band import Band, Rests
from symgen.estimation.filtered import filtered
from symgen.estimation.summary import placed, summary
from symgen.estimation.system import torque_equations
from symgen.estimation.values import FloatArray
from symgen.runtime.evaluator import Evaluator

#: Weight of equations at rest before it is known, and what it is at least.
_FIRST, _LEAST = 0.1, 1e-3
_ROUNDS = 3
_WORSE = 0.5  # a deviation at rest is another one than in motion where it is twice as large
_FEWEST = 10  # rows at rest, and in motion, that a deviation is taken from


def rests_of(logs: Sequence[Samples], sigma: Sequence[int]) -> Rests | None:
    """Return what counts as rest in some logs, with a first weight; None where no joint rests.

    Args:
        logs: the training logs.
        sigma: (n,) types of the joints.
    """
    largest = np.max([np.abs(mean_speeds(s.q, s.step)).max(axis=0) for s in logs], axis=0)
    slow, still = slow_speeds(largest, sigma)
    slow = np.where(still, -1.0, slow)
    if not any(resting(s.q, s.step, slow).any() for s in logs):
        return None
    return Rests(tuple(map(float, slow)), (_FIRST,) * len(slow))


def weighed_rests(evaluator: Evaluator, logs: Sequence[Samples], band: Band) -> Band:
    """Return a band with the weight of equations at rest: deviation in motion over that at rest.

    Args:
        evaluator: the compiled model, with torque_regressor.
        logs: the training logs.
        band: of the run, with a first weight.
    """
    if band.rests is None:
        return band
    equations = [torque_equations(evaluator, filtered(s, band)) for s in logs]
    weight = [1.0] * len(equations[0])
    for _ in range(_ROUNDS):
        X = summary(placed(equations), len(weight)).fit()
        for j, own in enumerate(zip(*equations, strict=True)):
            left = np.concatenate([(e.y - e.W @ X) / e.scale for e in own])
            rest = [np.zeros(len(e.y), bool) if e.rest is None else e.rest for e in own]
            at_rest = np.concatenate(rest)
            weight[j] = _ratio(left[~at_rest], left[at_rest])
        equations = [
            tuple(e.with_rest_weight(w) for e, w in zip(log, weight, strict=True))
            for log in equations
        ]
    return replace(band, rests=replace(band.rests, weight=tuple(weight)))


def _ratio(moving: FloatArray, at_rest: FloatArray) -> float:
    """Return the deviation of what is left in motion over that at rest; 1 where they are alike."""
    if min(len(moving), len(at_rest)) < _FEWEST:
        return 1.0
    moved, rested = (float(np.sqrt(np.mean(x**2))) for x in (moving, at_rest))
    ratio = moved / max(rested, 1e-300)
    return max(ratio, _LEAST) if ratio < _WORSE else 1.0
