"""What may be wrong with a log or with the gravity of the robot file: changes that undo it.

Each change is one point of a hypothesis: a name, its joints, and the size that is undone. Changes
of torques alone share the regressor and are always tried. A change of positions needs new rows: it
is tried where the model fails loudly, on a piece of the logs.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.faults.undo import backwards, earlier, rearranged, sharpened
from symgen.hypotheses.score import Key
from symgen.robot.effect import Definition, definitions
from symgen.robot.types import Robot

#: Gives the torque in the band (K, n) of logs whose torques are so many seconds earlier.
Torque = Callable[[float], FloatArray]
MOTION = ("q", "qd")
#: Delays and time constants that are tried, s.
_DELAYS = tuple(0.002 * 2**k for k in range(9))
_STEP = 1e-3  # s, of the slope of a torque
#: Most joints whose signs are tried in sets.
_SETS = 10
_DEGREES = math.pi / 180
#: Factors between units of torque, in N m: N mm, kN m, kgf m, per cent, and their inverses.
_UNITS = (1e-3, 1e3, 9.80665, 1 / 9.80665, 1e-2, 1e2)
#: Ratios of gears that are tried: whole numbers, halves, and their inverses.
_RATIOS = tuple(r**s for s in (1, -1) for r in (1.25, 1.5, 2.0, 3.0, 5.0, 100.0))


@dataclass(frozen=True, eq=False)
class Change:
    """What is wrong with the channels of all logs, and how to undo it.

    Attributes:
        definition: its row of the library.
        joints: positions; empty for all.
        factors: the channels that are wrong, and what undoes them multiplies them by.
        constants: name, value and unit of its size.
        among: positions of the joints that change where `joints` is empty; empty for all.
        order: (n,) column of each joint in these channels; empty for its own.
        delay: s by which the torques are late.
        lag: s, time constant of a first-order filter of the torques.
        turns: whether the samples are in reversed order.
        gravity: in frame 0, m/s2, of another gravity; None for that of the file.
    """

    definition: Definition
    joints: tuple[int, ...]
    factors: Mapping[str, float]
    constants: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    among: tuple[int, ...] = ()
    order: tuple[int, ...] = ()
    delay: float = 0.0
    lag: float = 0.0
    turns: bool = False
    gravity: tuple[float, ...] | None = None

    @property
    def key(self) -> Key:
        """Name and joints, without the size."""
        return self.definition.name, self.joints

    @property
    def channels(self) -> str:
        """The channels that are wrong, as "tau" or "q, qd"."""
        return ", ".join(self.factors)

    @property
    def scale(self) -> float:
        """Size of the recorded torque of its joints over that of the undone one."""
        return 1 / abs(self.factors.get("tau", 1.0))

    def undo(self, log: FilteredLog) -> FilteredLog:
        """Return a log without it."""
        n = log.q.shape[1]
        at = self._columns(n)
        if self.turns:
            return backwards(log)
        if self.delay:
            return earlier(log, self.delay, at)
        if self.lag:
            return sharpened(log, self.lag, at)
        factors = {}
        for key, factor in self.factors.items():
            factors[key] = np.ones(n)
            factors[key][at] = factor
        return rearranged(log, self.order or range(n), factors) if factors else log

    def torque(self, of: Torque) -> FloatArray:
        """Return the torque in the band (K, n) without it, from that of all delays."""
        out = of(0.0).copy()
        at = self._columns(out.shape[1])
        if self.order:
            return out[:, list(self.order)]
        if self.delay:
            out[:, at] = of(self.delay)[:, at]
        elif self.lag:
            slope = (of(_STEP) - of(-_STEP)) / (2 * _STEP)
            out[:, at] += self.lag * slope[:, at]
        else:
            out[:, at] *= self.factors["tau"]
        return out

    def _columns(self, n: int) -> list[int]:
        """Return the positions of the joints that change, of n."""
        return list(self.joints or self.among or range(n))


def torque_changes(robot: Robot, work: FloatArray) -> Iterator[list[Change]]:
    """Yield the hypotheses of which the rows need no other regressor, each with its grid.

    Args:
        robot: whose logs they are.
        work: (n,) that the torques do in all logs, J.
    """
    yield from ([c] for c in _torque_signs(robot, work))
    yield from _orders(robot, ("tau",))
    yield [late((), sign * d) for sign in (1, -1) for d in _DELAYS]
    single = [(j,) for j in range(robot.n)] if robot.n > 1 else []
    for joints in single:
        yield [late(joints, d) for d in _DELAYS]
    for some in ((), *single):
        yield [slow(some, T) for T in _DELAYS]


def motion_changes(robot: Robot) -> Iterator[list[Change]]:
    """Yield the hypotheses that need other rows, each with its grid."""
    rows = definitions()
    n = robot.n
    for keys in (MOTION, (*MOTION, "tau")):
        for j in range(n):
            yield [Change(rows["wrong_sign"], (j,), dict.fromkeys(keys, -1.0))]
        yield from _orders(robot, keys)
    turning = tuple(j for j, joint in enumerate(robot.movable) if joint.turns)
    degrees = dict.fromkeys(MOTION, _DEGREES)
    size = {"factor": (1 / _DEGREES, "")}
    if len(turning) > 1:
        yield [Change(rows["wrong_unit"], (), degrees, size, turning)]
    for j in turning:
        yield [Change(rows["wrong_unit"], (j,), degrees, size)]
    yield [Change(rows["reversed_time"], (), {"t": 1.0}, turns=True)]
    for j in range(n):
        yield [geared_by(j, r) for r in _RATIOS]
        yield [
            Change(rows["wrong_unit"], (j,), {"tau": 1 / f}, {"factor": (f, "")}) for f in _UNITS
        ]
    yield from gravities(robot)


def gravities(robot: Robot) -> Iterator[list[Change]]:
    """Yield gravity along every axis of frame 0, both ways, and none; without the file's."""
    for g in _gravities(robot):
        constants = {f"g{x}": (v, "m/s2") for x, v in zip("xyz", g, strict=True)}
        yield [Change(definitions()["gravity_direction"], (), {}, constants, gravity=g)]


def _torque_signs(robot: Robot, work: FloatArray) -> Iterator[Change]:
    """Yield all sets of torques that are turned, up to half of the joints; single ones if many.

    A set and the rest of the joints fit alike. Friction takes energy, so the torques of all joints
    together do positive work: that tells which of the two is turned.
    """
    driven = [j for j in range(robot.n) if j not in robot.passive]
    most = len(driven) // 2 if robot.n <= _SETS else 1
    for count in range(1, max(1, most) + 1):
        for joints in itertools.combinations(driven, count):
            turned = joints
            if 2 * work[list(joints)].sum() > work.sum():
                turned = tuple(j for j in driven if j not in joints)
            yield Change(definitions()["wrong_sign"], turned, {"tau": -1.0})


def _orders(robot: Robot, keys: Iterable[str]) -> Iterator[list[Change]]:
    """Yield exchanges of some channels of two joints, and channels in the order of the names."""
    rows, same = definitions(), dict.fromkeys(keys, 1.0)
    for j, k in itertools.combinations(range(robot.n), 2):
        order = [*range(robot.n)]
        order[j], order[k] = k, j
        yield [Change(rows["exchanged_channels"], (j, k), same, order=tuple(order))]
    if alphabetical := _alphabetical(robot):
        yield [Change(rows["joint_order"], (), same, order=alphabetical)]


def _alphabetical(robot: Robot) -> tuple[int, ...]:
    """Return the column of each joint if columns are sorted by name; empty if that is the file's.

    Args:
        robot: with the names of its joints.
    """
    names = [joint.name for joint in robot.movable]
    columns = sorted(names)
    if not all(names):
        return ()
    order = tuple(columns.index(name) for name in names)
    moved = [j for j, column in enumerate(order) if j != column]
    return order if moved[2:] else ()  # two are an exchange


def late(joints: tuple[int, ...], delay: float) -> Change:
    """Return the torques of some joints (all for none) that are late by so many seconds."""
    size = {"DT": (delay, "s")}
    return Change(definitions()["time_delay"], joints, {"tau": 1.0}, size, delay=delay)


def slow(joints: tuple[int, ...], lag: float) -> Change:
    """Return the torques of some joints (all for none) behind a first-order filter of `lag` s."""
    size = {"TF": (lag, "s")}
    return Change(definitions()["torque_filter"], joints, {"tau": 1.0}, size, lag=lag)


def geared_by(j: int, ratio: float) -> Change:
    """Return the joint that was recorded with 1 / `ratio` times its motion."""
    factors = {"q": ratio, "qd": ratio, "tau": 1 / ratio}
    return Change(definitions()["gear_ratio"], (j,), factors, {"ratio": (ratio, "")})


def _gravities(robot: Robot) -> Iterator[tuple[float, ...]]:
    if robot.imu:
        return
    plain = robot.with_values().gravity
    own = np.array([float(g) for g in plain])
    size = float(np.linalg.norm(own)) or 9.81
    for axis in (*np.eye(3), *-np.eye(3)):
        if np.linalg.norm(size * axis - own) > 0.1 * size:
            yield tuple(float(x) for x in size * axis + 0.0)  # without -0.0
    if own.any():
        yield (0.0, 0.0, 0.0)
