"""The motions that a search may choose from: all coefficients of all runs as one vector z.

q(t) = centre + B(t) P z with P a basis of the coefficients that keep the ends at rest (and at the
start, where one is given). Every limit on q and its derivatives is then linear in z, and the
motions within the limits are a convex set around z = 0, the robot at rest in the centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.experiment.bounds import FINE, Bounds
from symgen.experiment.trajectory import Basis, FloatArray, Trajectory, fine_matrix

#: What is left of a limit between the milliseconds at which it is checked.
_INSIDE = 0.9995


@dataclass(frozen=True, eq=False)
class Block:
    """One joint in one run: its part of z, and P scaled to the joint's range."""

    run: int
    joint: int
    basis: Basis
    part: slice
    P: FloatArray

    def matrix(self, t: FloatArray, order: int) -> FloatArray:
        """Return B(t) P, or its derivative of this order, (N, m)."""
        return self.basis.matrix(t, order) @ self.P


@dataclass(frozen=True, eq=False)
class Space:
    """The motions of some runs: blocks run by run, joint by joint; centre (n,), size of z."""

    blocks: tuple[Block, ...]
    centre: FloatArray
    size: int

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.blocks[-1].run + 1

    def duration(self, run: int) -> float:
        """Return the length of a run in s."""
        return next(b.basis.duration for b in self.blocks if b.run == run)

    def trajectories(self, z: FloatArray) -> tuple[Trajectory, ...]:
        """Return the runs of z (size,)."""
        out = []
        for run in range(self.runs):
            own = [b for b in self.blocks if b.run == run]
            coefficients = tuple(
                self.centre[b.joint] * b.basis.constant + b.P @ z[b.part] for b in own
            )
            out.append(Trajectory(tuple(b.basis for b in own), coefficients))
        return tuple(out)

    def fitted(self, z: FloatArray, limits: Bounds, grow: bool = False) -> FloatArray:
        """Return z with every joint of every run shrunk about the centre into its limits.

        Args:
            z: (size,).
            limits: of position, speed, acceleration and jerk.
            grow: widen joints that do not reach their limits too.
        """
        out = z.copy()
        for b in self.blocks:
            j, c = b.joint, b.P @ z[b.part]
            q = fine_matrix(b.basis, FINE, 0) @ c
            room = (limits.high[j] - self.centre[j], self.centre[j] - limits.low[j])
            shares = [max(q.max() / room[0], -q.min() / room[1])]
            for order in (1, 2, 3):
                if np.isfinite(limits.rates[order - 1, j]):
                    peak = np.abs(fine_matrix(b.basis, FINE, order) @ c).max()
                    shares.append(peak / limits.rates[order - 1, j])
            top = max(shares) / _INSIDE
            if top > 1 or (grow and top > 0):
                out[b.part] = z[b.part] / top
        return out

    def drawn(self, draw: np.random.Generator, limits: Bounds) -> FloatArray:
        """Draw a random motion that reaches its limits."""
        z = np.empty(self.size)
        for b in self.blocks:
            # Accelerations of all functions of like size: slow ones then move far.
            t = np.linspace(0, b.basis.duration, 200)
            size = np.sqrt(np.mean(b.matrix(t, 1) ** 2, axis=0)) + 1 / b.basis.duration
            z[b.part] = draw.normal(size=b.part.stop - b.part.start) / size
        return self.fitted(z, limits, grow=True)


def space(
    bases: tuple[tuple[Basis, ...], ...], limits: Bounds, start: FloatArray | None = None
) -> Space:
    """Return the motions of some runs.

    Args:
        bases: of each run, of each joint.
        limits: the positions among them set centre and range.
        start: (n,) where every run begins, None for anywhere.
    """
    blocks, at = [], 0
    for run, joints in enumerate(bases):
        for j, basis in enumerate(joints):
            conditions = basis.rest()
            if start is not None:
                conditions = np.concatenate([conditions, basis.matrix(np.zeros(1))])
            P = limits.half[j] * _null_space(conditions)
            blocks.append(Block(run, j, basis, slice(at, at + P.shape[1]), P))
            at += P.shape[1]
    return Space(tuple(blocks), limits.centre if start is None else start, at)


def _null_space(conditions: NDArray[np.float64]) -> FloatArray:
    """Return orthonormal columns N (size, m) with conditions N = 0."""
    count, size = conditions.shape
    if count == 0:
        return np.eye(size)
    scaled = conditions / np.linalg.norm(conditions, axis=1, keepdims=True)
    return np.asarray(np.linalg.qr(scaled.T, mode="complete")[0][:, count:])
