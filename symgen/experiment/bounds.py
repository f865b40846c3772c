"""Limits of a motion: the allowed ranges, the share that a trajectory uses, motions within them.

A cell is a floor and boxes that link frames and the tool must avoid. The clearance of a point x is
its height above the floor, and its distance from a box: Euclidean outside, negative depth inside,

    d = ||max(|x - c| - h, 0)|| + min(max_i (|x - c| - h)_i, 0),   c the centre, h the half sizes
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.experiment.trajectory import Basis, Trajectory, fine_matrix
from symgen.robot.types import Limits, Robot
from symgen.runtime.evaluator import Evaluator

#: Step in s at which limits are checked, and number of steps between checks of the cell.
FINE, _EVERY = 1e-3, 5
#: A limit binds if a motion uses at least this share of it.
BINDING = 0.97
KEYS = ("position", "velocity", "acceleration", "jerk")
#: Kinds of use that are those of a cell, and the kernel that they need.
CELL, FRAMES = ("floor", "box"), "frames"
_STILL = 1e-9  # m: what moves less is part of the base
#: Share of a limit that may be used at the checked times, so that it holds between them too.
_INSIDE = 0.9995
Torque = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Bounds:
    """Limits of the movable joints: rad or m, and per s, s2, s3; N m or N; infinite for none.

    Attributes:
        low: (n,) lowest positions.
        high: (n,) highest positions.
        rates: (3, n) of speed, acceleration and jerk.
        torque: (n,) of the torque of the prior model.
        numbers: (n,) of the joints in the robot's file.
    """

    low: FloatArray
    high: FloatArray
    rates: FloatArray
    torque: FloatArray
    numbers: tuple[int, ...]

    @property
    def centre(self) -> FloatArray:
        """The middle of the positions, (n,)."""
        return (self.low + self.high) / 2

    @property
    def half(self) -> FloatArray:
        """Half the range of the positions, (n,)."""
        return (self.high - self.low) / 2

    def uses(self, run: Trajectory, torque: Torque | None = None) -> Iterator[Use]:
        """Yield the share of every limit that a run uses, every millisecond and at its ends.

        Args:
            run: the trajectory.
            torque: gives the torque of the prior model, (N, n), from q, qd, qdd; None without
                limits.
        """
        t = run.fine(FINE)
        motion = [run.at(t, order) for order in range(4)]
        every = [(motion[0], self.low, self.high)]
        every += [(x, -top, top) for x, top in zip(motion[1:], self.rates, strict=True)]
        if torque is not None:
            every.append((torque(*motion[:3]), -self.torque, self.torque))
        for key, (x, low, high) in zip((*KEYS, "torque"), every, strict=False):
            for j in np.flatnonzero(np.isfinite(high)):
                away = x[:, j] - (low[j] + high[j]) / 2
                k = int(np.argmax(np.abs(away)))
                share = float(abs(away[k]) / ((high[j] - low[j]) / 2))
                edge = high[j] if away[k] >= 0 else low[j]
                yield Use(key, self.numbers[j], share, float(x[k, j]), float(edge))


@dataclass(frozen=True)
class Use:
    """The largest use of a limit by a motion: the share is 1 at the limit.

    `joint` is the joint's number in the robot's file.
    """

    limit: str
    joint: int
    share: float
    extreme: float
    allowed: float

    @property
    def binds(self) -> bool:
        """Whether a wider limit would help."""
        return self.share >= BINDING


def bounds(robot: Robot) -> Bounds:
    """Return the limits of a robot.

    Raises:
        ParameterError: limits of position or speed are missing, or a limit is not valid.
    """
    own = robot.limits or Limits()
    where = f"limits of {robot.name}"
    needed, tops = {"position": "positions", "velocity": "speeds"}, []
    for key in (*KEYS, "torque"):
        values = getattr(own, key)
        if values is None and key in needed:
            raise ParameterError(
                f"{where}: {needed[key]} are not limited; accepted: {key} in [limits], or --{key}"
            )
        array = np.full(robot.n, math.inf) if values is None else np.array(values, dtype=float)
        if len(array) != robot.n:
            raise ParameterError(
                f"{where}: {key} has {len(array)} entries; accepted: one for each of {robot.n} "
                "movable joints"
            )
        span = np.diff(array) if array.ndim > 1 else array
        if values is not None and not (np.isfinite(array).all() and (span > 0).all()):
            accepted = "finite numbers above 0" if array.ndim == 1 else "LOW below HIGH, finite"
            raise ParameterError(f"{where}: {key}; accepted: for each joint {accepted}")
        tops.append(array)
    numbers = tuple(j.number for j in robot.movable)
    low, high = tops[0].T
    return Bounds(low, high, np.array(tops[1:4]), tops[4], numbers)


def worst(found: Iterable[Use]) -> tuple[Use, ...]:
    """Return the largest use of every limit of every joint over several runs."""
    out: dict[tuple[str, int], Use] = {}
    for use in found:
        key = use.limit, use.joint
        out[key] = max(out.get(key, use), use, key=lambda u: u.share)
    return tuple(out.values())


@dataclass(frozen=True, eq=False)
class Cell:
    """A floor and boxes in frame 0, and the point of the tool in the last link's frame."""

    evaluator: Evaluator
    limits: Limits

    def uses(self, run: Trajectory) -> Iterator[Use]:
        """Yield the smallest clearance of moving frames and tool from the floor and from each box.

        The share is 1 minus the smallest clearance in m, so 1 means contact. `extreme` is that
        clearance, and `allowed` is 0.
        """
        T = self.evaluator[FRAMES](run.at(run.fine(_EVERY * FINE)))
        numbers = [j.number for j in self.evaluator.model.robot.joints]
        tip = T[:, -1, :3, :3] @ np.array(self.limits.tool or (0.0, 0.0, 0.0)) + T[:, -1, :3, 3]
        x, numbers = np.concatenate([T[:, :, :3, 3], tip[:, None]], 1), [*numbers, numbers[-1]]
        moves = np.flatnonzero(np.ptp(x, axis=0).max(axis=1) > _STILL)
        x = x[:, moves]
        clearances = []
        if self.limits.floor is not None:
            clearances.append(("floor", x[..., 2] - self.limits.floor))
        for box in self.limits.boxes:
            low, high = np.array(box).T
            away = np.abs(x - (low + high) / 2) - (high - low) / 2
            outside = np.linalg.norm(np.maximum(away, 0), axis=-1)
            clearances.append(("box", outside + np.minimum(away.max(axis=-1), 0)))
        for limit, clearance in clearances:
            least = clearance.min(axis=0)
            k = int(np.argmin(least))
            yield Use(limit, numbers[moves[k]], 1 - float(least[k]), float(least[k]), 0.0)


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
    """The space of motions to choose from, with all coefficients in one vector z.

    q(t) = centre + B(t) P z. P is a basis of the coefficients with ends at rest (and at the start
    position, if there is one). All limits on q and its derivatives are then linear in z. The
    motions within the limits are a convex set around z = 0, the robot at rest in the centre.

    Attributes:
        blocks: one block for each joint of each run.
        centre: centre of the position limits, (n,).
        size: length of z.
        limits: limits of position, speed, acceleration and jerk.
    """

    blocks: tuple[Block, ...]
    centre: FloatArray
    size: int
    limits: Bounds

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.blocks[-1].run + 1

    def of(self, run: int) -> tuple[Block, ...]:
        """Return the joints of a run."""
        return tuple(b for b in self.blocks if b.run == run)

    def trajectories(self, z: FloatArray) -> tuple[Trajectory, ...]:
        """Return the runs of z (size,)."""
        return tuple(
            Trajectory(
                tuple(b.basis for b in self.of(run)),
                tuple(
                    self.centre[b.joint] * b.basis.constant + b.P @ z[b.part] for b in self.of(run)
                ),
            )
            for run in range(self.runs)
        )

    def limits_of(self, block: Block) -> Iterator[tuple[int, float, float]]:
        """Yield every limit of a joint in a run: order, and ends relative to the centre."""
        j, limits = block.joint, self.limits
        yield 0, limits.low[j] - self.centre[j], limits.high[j] - self.centre[j]
        for order in np.flatnonzero(np.isfinite(limits.rates[:, j])).tolist():
            yield order + 1, -limits.rates[order, j], limits.rates[order, j]

    def fitted(self, z: FloatArray, grow: bool = False) -> FloatArray:
        """Return z with every joint of every run scaled about the centre into its limits.

        Args:
            z: (size,).
            grow: also enlarge joints that do not reach their limits.
        """
        out = z.copy()
        for b in self.blocks:
            c, top = b.P @ z[b.part], 0.0
            for order, low, high in self.limits_of(b):
                x = fine_matrix(b.basis, FINE, order) @ c
                top = max(top, x.max() / high / _INSIDE, x.min() / low / _INSIDE)
            if top > 1 or (grow and top > 0):
                out[b.part] = z[b.part] / top
        return out

    def drawn(self, draw: np.random.Generator) -> FloatArray:
        """Draw a random motion that reaches its limits."""
        z = np.empty(self.size)
        for b in self.blocks:
            # Accelerations of all functions of like size: slow ones then move far.
            t = np.linspace(0, b.basis.duration, 200)
            size = np.sqrt(np.mean(b.matrix(t, 1) ** 2, axis=0)) + 1 / b.basis.duration
            z[b.part] = draw.normal(size=b.part.stop - b.part.start) / size
        return self.fitted(z, grow=True)


def space(
    bases: tuple[tuple[Basis, ...], ...], limits: Bounds, start: FloatArray | None = None
) -> Space:
    """Return the motions of some runs.

    Args:
        bases: basis of each joint of each run.
        limits: limits of the joints; positions define centre and range.
        start: start position of every run, (n,); None if free.
    """
    blocks, at = [], 0
    for run, joints in enumerate(bases):
        for j, basis in enumerate(joints):
            conditions = basis.rest()
            if start is not None:
                conditions = np.concatenate([conditions, basis.matrix(np.zeros(1))])
            null = np.linalg.qr(conditions.T, mode="complete")[0][:, len(conditions) :]
            P = limits.half[j] * null
            blocks.append(Block(run, j, basis, slice(at, at + P.shape[1]), P))
            at += P.shape[1]
    return Space(tuple(blocks), limits.centre if start is None else start, at, limits)
