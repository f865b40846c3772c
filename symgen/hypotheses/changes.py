"""What may be wrong with a log or with the gravity of the robot file: changes that undo it.

Each change is one point of a hypothesis: a name, its joints, and the size that is undone. Changes
of torques alone share the regressor and are always tried. A change of positions needs new rows: it
is tried where the model fails loudly, on a piece of the logs.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symgen.data.raw import read_only
from symgen.data.signals import lowpass_and_slopes
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.faults.undo import backwards, earlier, exchanged, geared, multiplied
from symgen.robot.effect import Definition, definitions
from symgen.robot.types import Robot

#: Gives the torque in the band (K, n) of logs whose torques are so many seconds earlier.
Torque = Callable[[float], FloatArray]
Undo = Callable[[FilteredLog], FilteredLog]
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
        undo: returns a log without it.
        channels: the channels that are wrong, as "tau" or "q, qd".
        constants: name, value and unit of its size.
        torque: gives the torque of the undone logs, (K, n), of torques alone.
        scale: recorded over undone torque of its joints.
        gravity: in frame 0, m/s2, of another gravity; None for that of the file.
        turns: whether it turns the order of the samples.
    """

    definition: Definition
    joints: tuple[int, ...]
    undo: Undo
    channels: str
    constants: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    torque: Callable[[Torque], FloatArray] | None = None
    scale: float = 1.0
    gravity: tuple[float, ...] | None = None
    turns: bool = False

    @property
    def name(self) -> str:
        """Name in the library."""
        return self.definition.name

    @property
    def key(self) -> tuple[str, tuple[int, ...]]:
        """Name and joints, without the size."""
        return self.name, self.joints


def torque_changes(robot: Robot) -> Iterator[list[Change]]:
    """Yield the hypotheses of which the rows need no other regressor, each with its grid."""
    yield from ([c] for c in _torque_signs(robot))
    for j, k in itertools.combinations(range(robot.n), 2):
        yield [_exchange(robot, j, k, ("tau",))]
    if order := _alphabetical(robot):
        yield [_sorted(order, ("tau",))]
    yield [late(robot, (), sign * d) for sign in (1, -1) for d in _DELAYS]
    if robot.n > 1:
        for j in range(robot.n):
            yield [late(robot, (j,), d) for d in _DELAYS]
    for joints in ((), *((j,) for j in range(robot.n if robot.n > 1 else 0))):
        yield [slow(robot, joints, T) for T in _DELAYS]


def motion_changes(robot: Robot) -> Iterator[list[Change]]:
    """Yield the hypotheses that need other rows, each with its grid."""
    rows = definitions()
    n = robot.n
    for keys in (MOTION, (*MOTION, "tau")):
        for j in range(n):
            undo = partial(multiplied, joints=(j,), factor=-1.0, keys=keys)
            yield [Change(rows["wrong_sign"], (j,), undo, ", ".join(keys))]
        for j, k in itertools.combinations(range(n), 2):
            yield [_exchange(robot, j, k, keys)]
        if order := _alphabetical(robot):
            yield [_sorted(order, keys)]
    turning = [j for j, joint in enumerate(robot.movable) if joint.turns]
    for joints in ([turning] if n > 1 else []) + [[j] for j in turning]:
        undo = partial(multiplied, joints=tuple(joints), factor=_DEGREES, keys=MOTION)
        size = {"factor": (1 / _DEGREES, "")}
        named = () if len(joints) > 1 else tuple(joints)
        yield [Change(rows["wrong_unit"], named, undo, "q, qd", size)]
    yield [Change(rows["reversed_time"], (), backwards, "t", turns=True)]
    for j in range(n):
        yield [geared_by(j, r) for r in _RATIOS]
        yield [
            Change(
                rows["wrong_unit"],
                (j,),
                partial(multiplied, joints=(j,), factor=1 / f, keys=("tau",)),
                "tau",
                {"factor": (f, "")},
                scale=f,
            )
            for f in _UNITS
        ]
    for g in _gravities(robot):
        constants = {f"g{x}": (v, "m/s2") for x, v in zip("xyz", g, strict=True)}
        row = rows["gravity_direction"]
        yield [Change(row, (), _same, "", constants, gravity=g)]


def _same(log: FilteredLog) -> FilteredLog:
    return log


def _torque_signs(robot: Robot) -> Iterator[Change]:
    """Yield all sets of torques that are turned, up to half of the joints; single ones if many.

    A set and its complement fit alike: the smaller one is meant.
    """
    n = robot.n
    driven = [j for j in range(n) if j not in robot.passive]
    most = len(driven) // 2 if n <= _SETS else 1
    for count in range(1, max(1, most) + 1):
        for joints in itertools.combinations(driven, count):
            signs = np.ones(n)
            signs[list(joints)] = -1.0
            yield Change(
                definitions()["wrong_sign"],
                joints,
                partial(multiplied, joints=joints, factor=-1.0, keys=("tau",)),
                "tau",
                torque=partial(_times, signs),
            )


def _times(signs: FloatArray, torque: Torque) -> FloatArray:
    return torque(0.0) * signs


def _exchange(robot: Robot, j: int, k: int, keys: Sequence[str]) -> Change:
    order = np.arange(robot.n)
    order[[j, k]] = k, j
    undo = partial(exchanged, j=j, k=k, keys=keys)
    torque = partial(_ordered, tuple(map(int, order))) if tuple(keys) == ("tau",) else None
    row = definitions()["exchanged_channels"]
    return Change(row, (j, k), undo, ", ".join(keys), torque=torque)


def _ordered(order: Sequence[int], torque: Torque) -> FloatArray:
    return torque(0.0)[:, list(order)]


def _alphabetical(robot: Robot) -> list[int]:
    """Return the column of each joint if columns are sorted by name; empty if that is the file's.

    Args:
        robot: with the names of its joints.
    """
    names = [joint.name for joint in robot.movable]
    if not all(names) or sorted(names) == names:
        return []
    columns = sorted(names)
    order = [columns.index(name) for name in names]
    moved = [j for j, column in enumerate(order) if j != column]
    return order if len(moved) > 2 else []  # two are an exchange


def _sorted(order: Sequence[int], keys: Sequence[str]) -> Change:
    def undo(log: FilteredLog) -> FilteredLog:
        return reordered(log, order, keys)

    torque = partial(_ordered, tuple(order)) if tuple(keys) == ("tau",) else None
    return Change(definitions()["joint_order"], (), undo, ", ".join(keys), torque=torque)


def reordered(log: FilteredLog, order: Sequence[int], keys: Sequence[str]) -> FilteredLog:
    """Return a log whose channels of each joint are those of another column."""
    place = list(range(len(order)))
    for j, column in enumerate(order):
        at = place.index(column)
        if at != j:
            log = exchanged(log, j, at, keys)
            place[j], place[at] = place[at], place[j]
    return log


def late(robot: Robot, joints: tuple[int, ...], delay: float) -> Change:
    """Return the torques of some joints (all for none) that are late by so many seconds."""
    at = list(joints or range(robot.n))

    def torque(of: Torque) -> FloatArray:
        out = of(0.0).copy()
        out[:, at] = of(delay)[:, at]
        return out

    undo = partial(earlier, delay=delay, joints=tuple(at))
    size = {"DT": (delay, "s")}
    return Change(definitions()["time_delay"], joints, undo, "tau", size, torque)


def slow(robot: Robot, joints: tuple[int, ...], T: float) -> Change:
    """Return the torques of some joints (all for none) behind a first-order filter of T seconds."""
    at = list(joints or range(robot.n))

    def torque(of: Torque) -> FloatArray:
        out = of(0.0).copy()
        slope = (of(_STEP) - of(-_STEP)) / (2 * _STEP)
        out[:, at] += T * slope[:, at]
        return out

    undo = partial(_sharpened, joints=at, T=T)
    size = {"TF": (T, "s")}
    return Change(definitions()["torque_filter"], joints, undo, "tau", size, torque)


def _sharpened(log: FilteredLog, joints: Sequence[int], T: float) -> FilteredLog:
    """Return a log with tau + T d(tau)/dt in place of tau, for some joints."""
    smooth = log.rows.cutoff
    if smooth is None:
        slope = np.gradient(log.tau, log.step, axis=0)
    else:  # the slope of what the comparison band passes
        _, slope = lowpass_and_slopes(log.tau, log.step, 2 * smooth, 1)
    tau = log.tau.copy()
    tau[:, list(joints)] += T * slope[:, list(joints)]
    return replace(log, samples=replace(log.samples, tau=read_only(tau)))


def geared_by(j: int, ratio: float) -> Change:
    """Return the joint that was recorded with 1 / `ratio` times its motion."""
    undo = partial(geared, j=j, ratio=ratio)
    size = {"ratio": (ratio, "")}
    return Change(definitions()["gear_ratio"], (j,), undo, "q, qd, tau", size, scale=ratio)


def _gravities(robot: Robot) -> Iterator[tuple[float, ...]]:
    """Yield gravity along every axis of frame 0, both ways, and none; without the file's."""
    if robot.imu:
        return
    plain = robot.with_values().gravity
    own = np.array([float(g) for g in plain])
    size = float(np.linalg.norm(own)) or 9.81
    for axis in (*np.eye(3), *-np.eye(3)):
        if np.linalg.norm(size * axis - own) > 0.1 * size:
            yield tuple(float(x) for x in size * axis)
    if own.any():
        yield (0.0, 0.0, 0.0)
