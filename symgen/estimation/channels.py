"""Channels in other places, signs and units: what can be wrong with them, and a log without it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.filtered import FilteredLog
from symgen.estimation.speeds import shifted
from symgen.names import REVOLUTE
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Fault:
    """A fault of channels that the model shows.

    Attributes:
        channel: "tau3", "tau2, tau4", "q3, qd3", or "tau" for all joints.
        says: in words, with the value.
        left: error on folds left out with the fault undone, over that as it is.
        kind: gain, sign, exchange, units, ratio or delay.
        joints: positions of the joints.
        value: factor, or delay in s.
        undone: gives a log without it.
    """

    channel: str
    says: str
    left: float
    kind: str
    joints: tuple[int, ...]
    value: float
    undone: Callable[[FilteredLog], FilteredLog]


def earlier(log: FilteredLog, delay: float) -> FilteredLog:
    """Return a log whose torques were measured `delay` s earlier."""
    return replace(log, samples=shifted(log.samples, delay))


def swapped(log: FilteredLog, j: int, k: int, keys: Sequence[str]) -> FilteredLog:
    """Return a log with some channels of two joints exchanged."""
    order = np.arange(log.q.shape[1])
    order[[j, k]] = k, j
    return _changed(log, keys, lambda x: np.ascontiguousarray(x[:, order]))


def multiplied(
    log: FilteredLog, joints: Sequence[int], factor: float, keys: Sequence[str]
) -> FilteredLog:
    """Return a log with some channels of some joints times a factor."""
    scale = np.ones(log.q.shape[1])
    scale[list(joints)] = factor
    return _changed(log, keys, lambda x: x * scale)


def geared(log: FilteredLog, j: int, ratio: float) -> FilteredLog:
    """Return a log with the motion of a joint times a factor, its torque over it."""
    return multiplied(multiplied(log, (j,), ratio, ("q", "qd")), (j,), 1 / ratio, ("tau",))


def gear_ratio(j: int, ratio: float) -> Fault:
    """Return the fault that a joint was recorded through another gear ratio."""
    number = j + 1
    names = f"q{number}, qd{number}, tau{number}"
    says = (
        f"{names}: the gear ratio of joint {number} is off by a factor {ratio:.3g} (positions "
        "times it, torque over it)"
    )
    return Fault(names, says, 1.0, "ratio", (j,), ratio, partial(geared, j=j, ratio=ratio))


def _changed(
    log: FilteredLog, keys: Sequence[str], change: Callable[[FloatArray], FloatArray]
) -> FilteredLog:
    """Return a log with some channels changed, in the band and as they were sampled."""
    arrays: dict[str, Any] = {key: change(getattr(log.samples, key)) for key in keys}
    motion: dict[str, Any] = {key: change(getattr(log, key)) for key in keys if key != "tau"}
    return replace(log, samples=replace(log.samples, **arrays), **motion)


def hypotheses(evaluator: Evaluator) -> Iterator[Fault]:
    """Yield the faults of the motion that are tried."""
    joints = evaluator.model.robot.movable
    motion, whole = ("q", "qd"), ("q", "qd", "tau")
    for keys in (motion, whole):
        for j, k in combinations(range(len(joints)), 2):
            names = ", ".join(f"{key}{i + 1}" for i in (j, k) for key in keys)
            says = f"{names}: joints {j + 1} and {k + 1} stand in each other's place"
            undone = partial(swapped, j=j, k=k, keys=keys)
            yield Fault(names, says, 1.0, "exchange", (j, k), 0.0, undone)
        for j in range(len(joints)):
            names = ", ".join(f"{key}{j + 1}" for key in keys)
            undone = partial(multiplied, joints=(j,), factor=-1.0, keys=keys)
            says = f"{names} have the other sign"
            yield Fault(names, says, 1.0, "sign", (j,), -1.0, undone)
    turning = [j for j, joint in enumerate(joints) if joint.sigma == REVOLUTE]
    factor = np.pi / 180
    for group in ([turning] if len(turning) > 1 else []) + [[j] for j in turning]:
        names = "q, qd" if len(group) > 1 else f"q{group[0] + 1}, qd{group[0] + 1}"
        undone = partial(multiplied, joints=tuple(group), factor=factor, keys=motion)
        says = f"{names} are in degrees: multiply them by pi/180"
        yield Fault(names, says, 1.0, "units", tuple(group), 1 / factor, undone)
