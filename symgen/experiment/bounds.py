"""Limits of a motion: what the user allows, how much of it a trajectory takes, how to keep it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.errors import ParameterError
from symgen.experiment.trajectory import Trajectory
from symgen.robot.types import Limits, Robot

FloatArray = NDArray[np.float64]
#: Step in s at which limits are checked.
FINE = 1e-3
#: A limit of which a motion takes this share or more binds.
BINDING = 0.97
KEYS = ("position", "velocity", "acceleration", "jerk")
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


@dataclass(frozen=True)
class Use:
    """How much of a limit a motion takes, at most: the share is 1 at the limit.

    `joint` is the joint's number in the robot's file.
    """

    limit: str
    joint: int
    share: float
    extreme: float
    allowed: float


def bounds(robot: Robot) -> Bounds:
    """Return the limits of a robot.

    Raises:
        ParameterError: limits of position or speed are missing, or a limit has no meaning.
    """
    own = robot.limits or Limits()
    where, ranges = f"limits of {robot.name}", own.position
    if ranges is None:
        raise ParameterError(
            f"{where}: positions are not limited; accepted: position in [limits], or --position"
        )
    _require_count(where, "position", len(ranges), robot.n)
    low, high = np.array(ranges, dtype=np.float64).reshape(robot.n, 2).T
    if not (np.isfinite(low).all() and np.isfinite(high).all() and (low < high).all()):
        raise ParameterError(f"{where}: position; accepted: for each joint LOW below HIGH, finite")
    rows = [_positive(where, key, getattr(own, key), robot.n) for key in KEYS[1:]]
    if not np.isfinite(rows[0]).all():
        raise ParameterError(
            f"{where}: speeds are not limited; accepted: velocity in [limits], or --velocity"
        )
    tau = _positive(where, "torque", own.torque, robot.n)
    return Bounds(low, high, np.array(rows), tau, tuple(j.number for j in robot.movable))


def _positive(where: str, key: str, values: Sequence[float] | None, n: int) -> FloatArray:
    if values is None:
        return np.full(n, math.inf)
    _require_count(where, key, len(values), n)
    if not all(math.isfinite(v) and v > 0 for v in values):
        raise ParameterError(f"{where}: {key}; accepted: finite numbers above 0")
    return np.array(values, dtype=float)


def _require_count(where: str, key: str, found: int, n: int) -> None:
    if found != n:
        raise ParameterError(
            f"{where}: {key} has {found} entries; accepted: one for each of {n} movable joints"
        )


def uses(limits: Bounds, run: Trajectory, torque: Torque | None = None) -> tuple[Use, ...]:
    """Return how much of every limit a run takes, every millisecond and at its ends.

    Args:
        limits: of the joints.
        run: the trajectory.
        torque: of the prior model, (N, n) from q, qd, qdd; None where torques are not limited.
    """
    t = run.fine(FINE)
    motion = [run.at(t, order) for order in range(4)]
    out = []
    for j, number in enumerate(limits.numbers):
        q = motion[0][:, j]
        far = q[np.argmax(np.abs(q - limits.centre[j]))]
        edge = limits.high[j] if far > limits.centre[j] else limits.low[j]
        share = abs(far - limits.centre[j]) / limits.half[j]
        out.append(Use("position", number, float(share), float(far), float(edge)))
        peaks = [(KEYS[k], motion[k][:, j], limits.rates[k - 1, j]) for k in (1, 2, 3)]
        out += [
            _use(key, number, x, allowed) for key, x, allowed in peaks if math.isfinite(allowed)
        ]
    if torque is not None:
        tau = torque(*motion[:3])
        pairs = zip(limits.numbers, tau.T, limits.torque, strict=True)
        out += [_use("torque", *pair) for pair in pairs]
    return tuple(u for u in out if math.isfinite(u.allowed))


def _use(key: str, number: int, x: FloatArray, allowed: float) -> Use:
    extreme = x[np.argmax(np.abs(x))]
    share = float(abs(extreme) / allowed)
    return Use(key, number, share, float(extreme), float(math.copysign(allowed, extreme)))


def worst(found: Sequence[Use]) -> dict[tuple[str, int], Use]:
    """Return the largest use of every limit of every joint over several runs."""
    out: dict[tuple[str, int], Use] = {}
    for use in found:
        known = out.get((use.limit, use.joint))
        if known is None or use.share > known.share:
            out[use.limit, use.joint] = use
    return out
