"""Limits of a motion: allowed ranges, the used share of each limit, and motions within the limits.

A cell is a floor and boxes that link frames and the tool must avoid. The clearance of a point x is
its height above the floor, and its distance from a box: Euclidean outside, negative depth inside,

    d = ||max(|x - c| - h, 0)|| + min(max_i (|x - c| - h)_i, 0),   c the centre, h the half sizes
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symgen.data.raw import FloatArray, Places
from symgen.errors import ParameterError
from symgen.experiment.trajectory import Fourier, Trajectory
from symgen.robot.tables import Limits
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Step in s at which limits are checked.
FINE = 1e-3
#: A limit binds if a motion uses at least this share of it.
BINDING = 0.97
KEYS = ("position", "velocity", "acceleration", "jerk")
#: Limits of a cell, and the kernel that they need.
CELL, FRAMES = ("floor", "box"), "frames"
_STILL = 1e-9  # m: points that move less are part of the base
#: Share of a limit that may be used at the checked times, so that the limit also holds between
#: them.
_INSIDE = 0.9995


@dataclass(frozen=True, eq=False)
class Bounds:
    """Limits of the movable joints in rad or m, per s, s2, s3, and in N m or N; infinite for none.

    Attributes:
        low: (n,) lowest positions.
        high: (n,) highest positions.
        rates: (3, n) limits of speed, acceleration and jerk.
        torque: (n,) limits of the torque of the prior model.
        numbers: (n,) joint numbers in the robot file.
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

    def uses(self, motion: FloatArray) -> Iterator[LimitUse]:
        """Yield the largest share of every limit that a motion uses.

        Args:
            motion: q, qd, qdd and jerk, (4, N, n).
        """
        yield from self.used("position", motion[0], self.low, self.high)
        for key, x, top in zip(KEYS[1:], motion[1:], self.rates, strict=True):
            yield from self.used(key, x, -top, top)

    def used(
        self, key: str, x: FloatArray, low: FloatArray, high: FloatArray
    ) -> Iterator[LimitUse]:
        """Yield the largest share of one limit for every joint that has it; x is (N, n)."""
        for j in np.flatnonzero(np.isfinite(high)):
            away = x[:, j] - (low[j] + high[j]) / 2
            k = int(np.argmax(np.abs(away)))
            share = float(abs(away[k]) / ((high[j] - low[j]) / 2))
            edge = high[j] if away[k] >= 0 else low[j]
            yield LimitUse(key, self.numbers[j], share, float(x[k, j]), float(edge))


@dataclass(frozen=True)
class LimitUse:
    """The largest use of a limit by a motion: the share is 1 at the limit.

    `joint` is the joint number in the robot file.
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
                f"{where}: {needed[key]} are not limited for every joint (symgen import names the "
                f"joints without limits); accepted: {key} in [limits], or --{key} with one value "
                f"for all or one for each of {robot.n} joints"
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


def largest_uses(uses: Iterable[LimitUse]) -> tuple[LimitUse, ...]:
    """Return the largest use of every limit of every joint over several runs."""
    out: dict[tuple[str, int], LimitUse] = {}
    for use in uses:
        key = use.limit, use.joint
        out[key] = max(out.get(key, use), use, key=lambda u: u.share)
    return tuple(out.values())


@dataclass(frozen=True, eq=False)
class Cell:
    """A floor and boxes in frame 0, and the point of the tool in the last link's frame."""

    evaluator: Evaluator
    limits: Limits

    def points(self, q: FloatArray) -> FloatArray:
        """Return the origins of all frames and the point of the tool, (N, links + 1, 3)."""
        T = self.evaluator[FRAMES](q)
        tool = T[:, -1, :3, :3] @ np.array(self.limits.tool or (0.0, 0.0, 0.0)) + T[:, -1, :3, 3]
        return np.concatenate([T[:, :, :3, 3], tool[:, None]], axis=1)

    @cached_property
    def moving(self) -> Places:
        """The points that are not part of the base."""
        q = np.random.default_rng(0).normal(size=(8, self.evaluator.model.robot.n))
        return np.flatnonzero(np.ptp(self.points(q), axis=0).max(axis=1) > _STILL)

    def uses(self, q: FloatArray) -> Iterator[LimitUse]:
        """Yield the smallest clearance of moving frames and tool from the floor and from each box.

        Positions q are (N, n). The share is 1 minus the smallest clearance in m, so 1 means
        contact. `extreme` is that clearance, and `allowed` is 0.
        """
        numbers = [j.number for j in self.evaluator.model.robot.joints]
        numbers.append(numbers[-1])
        moves = self.moving
        x = self.points(q)[:, moves]
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
            yield LimitUse(limit, numbers[moves[k]], 1 - float(least[k]), float(least[k]), 0.0)


@dataclass(frozen=True, eq=False)
class Space:
    """The motions of one run from rest to rest, with coefficients z (n, m).

    Joint j moves as q(t) = q(0) + (B(t) - B(0)) P z_j. P is a basis of the coefficients of motions
    from rest to rest, without the constant function. Its columns have similar speeds.

    Attributes:
        series: B, the functions of time.
        P: (2 terms + 1, m), see above.
        limits: limits of position, speed, acceleration and jerk.
        start: start position, (n,); None if free. The middle of a motion is then that of the
            limits.
    """

    series: Fourier
    P: FloatArray
    limits: Bounds
    start: FloatArray | None = None

    def draw(self, draw: np.random.Generator) -> FloatArray:
        """Return random coefficients."""
        return draw.normal(size=(len(self.limits.low), self.P.shape[1]))

    def sampled(self, t: FloatArray) -> FloatArray:
        """Return (B - B(0)) P and its first three derivatives at times t, (4, N, m)."""
        out = np.stack([self.series.matrix(t, order) @ self.P for order in range(4)])
        out[0] -= self.series.matrix(np.zeros(1)) @ self.P
        return out

    def motion(self, z: FloatArray, sampled: FloatArray) -> FloatArray:
        """Return q, qd, qdd and jerk, (4, N, n)."""
        out = sampled @ z.T
        out[0] += self._begins(out[0])
        return out

    def trajectory(self, z: FloatArray, sampled: FloatArray) -> Trajectory:
        """Return the run with the coefficients z."""
        begins, coefficients = self._begins(sampled[0] @ z.T), z @ self.P.T
        moved = self.series.matrix(np.zeros(1)) @ coefficients.T
        coefficients[:, 0] += begins - moved[0]
        return Trajectory(self.series, coefficients)

    def _begins(self, x: FloatArray) -> FloatArray:
        """Return q(0), (n,), for positions relative to it, (N, n)."""
        if self.start is not None:
            return self.start
        return np.asarray(self.limits.centre - (x.max(axis=0) + x.min(axis=0)) / 2)

    def fitted(self, z: FloatArray, sampled: FloatArray, grow: bool = False) -> FloatArray:
        """Return z with every joint scaled into its limits, which hold at the sampled times.

        Args:
            z: the coefficients.
            sampled: see `sampled`.
            grow: also enlarge joints that do not reach their limits.
        """
        x, bounds = sampled @ z.T, self.limits
        begins = self._begins(x[0])
        low, high = bounds.low - begins, bounds.high - begins
        if self.start is None:  # the middle stays in place
            x[0] += begins - bounds.centre
            low, high = -bounds.half, bounds.half
        rates = np.abs(x[1:]).max(axis=1) / bounds.rates
        shares = [x[0].max(axis=0) / high, x[0].min(axis=0) / low, *rates]
        used = np.max(shares, axis=0) / _INSIDE
        used = used if grow else np.maximum(used, 1.0)
        return np.asarray(z / used[:, None])


def space(series: Fourier, limits: Bounds, start: FloatArray | None = None) -> Space:
    """Return the motions of a run: speed and acceleration are zero at both ends.

    Args:
        series: functions of time.
        limits: limits of the joints.
        start: start position, (n,); None if free.
    """
    speed = np.sqrt(np.mean(series.matrix(np.linspace(0, series.duration, 200), 1) ** 2, axis=0))
    size = 1 / np.where(speed > 0, speed, speed.max())  # coefficients for a speed of 1
    at_rest = [series.matrix(np.zeros(1), order) * size for order in (1, 2)]
    conditions = np.concatenate([*at_rest, np.eye(1, len(size))])
    null = np.linalg.qr(conditions.T, mode="complete")[0][:, len(conditions) :]
    return Space(series, size[:, None] * null, limits, start)
