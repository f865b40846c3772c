"""The cell of a robot: a floor and boxes that link frames and the tool stay clear of.

Clearance of a point x is its height above the floor, and its distance from a box: Euclidean
outside, negative depth inside,

    d = ||max(|x - c| - h, 0)|| + min(max_i (|x - c| - h)_i, 0),   c the centre, h the half sizes
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.experiment.bounds import FINE, Use
from symgen.experiment.trajectory import Trajectory
from symgen.robot.types import Limits
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: Kinds of use that are those of a cell.
KINDS = ("floor", "box")
KERNEL = "frames"
_STILL = 1e-9  # m: what moves less is part of the base
_EVERY = 5  # samples of the fine grid


@dataclass(frozen=True, eq=False)
class Cell:
    """A floor and boxes in frame 0, and the point of the tool in the last link's frame."""

    evaluator: Evaluator
    limits: Limits

    def points(self, q: FloatArray) -> tuple[FloatArray, tuple[int, ...]]:
        """Return the origins of the link frames that move, and the tool, (N, k, 3), by joint."""
        T = self.evaluator[KERNEL](np.ascontiguousarray(q))
        numbers = [j.number for j in self.evaluator.model.robot.joints]
        x = T[:, :, :3, 3]
        if self.limits.tool is not None:
            tip = x[:, -1] + T[:, -1, :3, :3] @ np.array(self.limits.tool)
            x, numbers = np.concatenate([x, tip[:, None]], axis=1), [*numbers, numbers[-1]]
        moves = np.ptp(x, axis=0).max(axis=1) > _STILL
        return x[:, moves], tuple(n for n, m in zip(numbers, moves, strict=True) if m)

    def uses(self, run: Trajectory) -> tuple[Use, ...]:
        """Return how near a run comes to the floor and to each box; a share of 1 touches.

        The share is 1 less the smallest clearance in m; extreme is that clearance, allowed is 0.
        """
        x, numbers = self.points(run.at(run.fine(_EVERY * FINE)))
        out = []
        if self.limits.floor is not None:
            out.append(_use("floor", x[..., 2] - self.limits.floor, numbers))
        for box in self.limits.boxes:
            low, high = np.array(box).T
            away = np.abs(x - (low + high) / 2) - (high - low) / 2
            outside = np.linalg.norm(np.maximum(away, 0), axis=-1)
            out.append(_use("box", outside + np.minimum(away.max(axis=-1), 0), numbers))
        return tuple(out)


def _use(limit: str, clearance: FloatArray, numbers: tuple[int, ...]) -> Use:
    least = clearance.min(axis=0)
    k = int(np.argmin(least))
    return Use(limit, numbers[k], 1 - float(least[k]), float(least[k]), 0.0)
