"""Changes: possible faults of all logs, or of the gravity of the robot file, with their undo.

A change is one point of a hypothesis: a name, its joints, and the size to undo. Changes of torques
alone share the regressor, so the search always tries them. A change of positions needs new rows.
The search tries it only if the model error is large, and on a piece of the logs.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.values import FloatArray
from symgen.faults.undo import backwards, earlier, rearranged, sharpened
from symgen.hypotheses.judged import Hypothesis, Judged, Size
from symgen.hypotheses.score import Key
from symgen.robot.effect import definitions
from symgen.robot.types import Robot
from symgen.symbolic.variation import variation

#: Returns torques in the band, (K, n) or on a floating base (K, m, n), that are moved earlier by
#: some seconds, with the channel that lies some places further in place of that of each joint.
Torque = Callable[[float, int], FloatArray]
MOTION = ("q", "qd")
#: Name of the hypothesis that the gravity of the file is wrong, by any angle or altogether.
TILT = "base_tilt"
#: Grid of delays and time constants, s.
_DELAYS = tuple(0.002 * 2**k for k in range(9))
_STEP = 1e-3  # s, half width of the central difference of a torque
#: Largest number of joints for which sets of wrong signs are tried.
_SETS = 10
_DEGREES = math.pi / 180
#: Values of 1 N m in other units, with their names for --unit: kgf m and per cent have none.
_UNITS = {1e-3: "kNm", 1e3: "mNm", 9.80665: "", 1 / 9.80665: "", 1e-2: "", 1e2: "Ncm"}
#: Grid of gear ratios, with their inverses.
_RATIOS = tuple(r**s for s in (1, -1) for r in (1.25, 1.5, 2.0, 3.0, 5.0, 100.0))


@dataclass(frozen=True, eq=False)
class Change(Hypothesis):
    """A fault of the channels of all logs, and how to undo it.

    Attributes:
        factors: the wrong channels, each with the factor that corrects it.
        sizes: its size.
        among: positions of the joints that change if `joints` is empty; empty for all.
        order: (n,) correct column of each joint in these channels; empty to keep the order.
        delay: s by which the torques are late.
        lag: s, time constant of a first-order filter of the torques.
        turns: whether the samples are in reversed order.
        gravity: corrected gravity in frame 0, m/s2; None for that of the file.
        unit: the unit of the channels that --unit takes; "" if there is none.
    """

    factors: Mapping[str, float]
    sizes: Sequence[Size] = ()
    among: tuple[int, ...] = ()
    order: tuple[int, ...] = ()
    delay: float = 0.0
    lag: float = 0.0
    turns: bool = False
    gravity: tuple[float, ...] | None = None
    unit: str = ""

    @property
    def key(self) -> Key:
        """Name and joints, without the size."""
        return self.name if self.gravity is None else TILT, self.joints

    def expression(self, robot: Robot) -> str:
        """Return what it does to the channels, or to the robot file."""
        where = ",".join(self.assigned) or "robot file"
        return f"{super().expression(robot)} ({where})"

    @property
    def assigned(self) -> list[str]:
        """Its columns, each with its source for --columns, or with its unit for --unit."""
        out = []
        for key, j in itertools.product(self.factors, self.joints):
            source = f"{key}{self.order[j] + 1}" if self.order else self.unit
            out.append(f"{key}{j + 1}={source}".rstrip("="))
        return out or [*self.factors]

    def scale(self, robot: Robot) -> FloatArray:
        """Return the ratio of the recorded torque of each equation to the corrected one, (m,)."""
        out = np.ones(len(robot.kinds))
        out[robot.rows(self.joints)] /= abs(self.factors.get("tau", 1.0))
        return out

    def in_words(self, robot: Robot) -> str:
        """Return its channels, its name, its joints and its size."""
        listed = ", ".join(self.assigned)
        text = super().in_words(robot)
        return f"{listed}: {text}" if listed else text

    def undo(self, log: FilteredLog) -> FilteredLog:
        """Return a log with the change undone."""
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
        """Return the torques in the band, see `Torque`, with the change undone.

        Args:
            of: function from a delay in s and a number of places to the torques.
        """
        out = of(0.0, 0).copy()
        n = out.shape[-1]
        at = self._columns(n)
        if "tau" not in self.factors:
            return out
        if self.order:
            for j, k in enumerate(self.order):
                out[..., j] = of(0.0, (k - j) % n)[..., j]
            return out
        if self.delay:
            out[..., at] = of(self.delay, 0)[..., at]
        elif self.lag:
            slope = (of(_STEP, 0) - of(-_STEP, 0)) / (2 * _STEP)
            out[..., at] += self.lag * slope[..., at]
        else:
            out[..., at] *= self.factors["tau"]
        return out

    def _columns(self, n: int) -> list[int]:
        """Return the positions of the joints that change, among n joints."""
        return list(self.joints or self.among or range(n))


@dataclass(frozen=True, eq=False)
class Changed(Judged):
    """A change of all logs and its score; `cause` is the change to undo."""

    cause: Change


def torque_changes(robot: Robot, work: FloatArray) -> Iterator[list[Change]]:
    """Yield the hypotheses that share the regressor of the logs, each with its grid.

    Wrong signs of a set of torques and of all others fit alike. Friction takes energy, so the set
    with less work has the wrong sign.

    Args:
        robot: the robot of the logs.
        work: (n,) work of the torques less that of the links in the fit of the model.
    """
    sign, driven = definitions()["wrong_sign"], _driven(robot)
    for joints in _sets(driven):
        others = tuple(j for j in driven if j not in joints)
        turned = min(joints, others, key=lambda some: work[list(some)].sum())
        yield [Change(sign, turned, {"tau": -1.0})]
    yield from _orders(robot, ("tau",), driven)
    yield [late((), sign * d) for sign in (1, -1) for d in _DELAYS]
    single = [(j,) for j in driven] if robot.n > 1 else []
    for joints in single:
        yield [late(joints, d) for d in _DELAYS]
    for some in ((), *single):
        yield [slow(some, T) for T in _DELAYS]


def motion_changes(robot: Robot, loud: frozenset[int]) -> Iterator[list[Change]]:
    """Yield the hypotheses of large errors, each with its grid.

    Args:
        robot: the robot of the logs.
        loud: joints with large errors, on which exchanges and gear ratios are tried.
    """
    rows, driven = definitions(), _driven(robot)
    for keys in (MOTION, (*MOTION, "tau")):
        for j in driven:
            yield [Change(rows["wrong_sign"], (j,), dict.fromkeys(keys, -1.0))]
        yield from _orders(robot, keys, [j for j in driven if j in loud])
    turning = tuple(j for j, joint in enumerate(robot.movable) if joint.turns)
    degrees = dict.fromkeys(MOTION, _DEGREES)
    size = (Size("factor", 1 / _DEGREES, ""),)
    if len(turning) > 1:
        yield [Change(rows["wrong_unit"], (), degrees, size, turning, unit="deg")]
    for j in turning:
        yield [Change(rows["wrong_unit"], (j,), degrees, size, unit="deg")]
    if not robot.floating:
        yield [Change(rows["reversed_time"], (), {"t": 1.0}, turns=True)]
    for j in loud if driven[1:] else ():  # a lone motor has the scale of all torques
        yield [geared_by(j, r) for r in _RATIOS]
    for some in _sets(driven):
        if loud.issuperset(some[1:]):
            named = {*turning}.issuperset(some) and robot.drive is None  # N m in the log
            yield [
                Change(
                    rows["wrong_unit"],
                    some,
                    {"tau": 1 / f},
                    (Size("factor", f, ""),),
                    unit=name * named,
                )
                for f, name in _UNITS.items()
            ]
    yield from gravities(robot)


def gravities(robot: Robot) -> Iterator[list[Change]]:
    """Yield the grid of one hypothesis: both directions of each axis of frame 0, and no gravity.

    It skips the gravity of the file and directions near it. `symgen.hypotheses.trials` finds the
    directions between the axes.
    """
    if not robot.imu:
        declared = variation(robot).gravity
        size = np.linalg.norm(declared) or 9.81
        grid = size * np.concatenate([np.eye(3), -np.eye(3), np.zeros((1, 3))])
        far = np.linalg.norm(grid - declared, axis=1) > 0.1 * size
        yield [another_gravity(robot, g) for g in grid[far]]


def another_gravity(
    robot: Robot, gravity: FloatArray, std: Iterable[float] = (math.nan,) * 3
) -> Change:
    """Return the change of the gravity of the file to another one, along an axis or by a tilt.

    Its constants are the components of gravity and, for a tilt, the rotation vector T of the base:
    gravity turns by -T in frame 0.

    Args:
        robot: the robot with the gravity of its file.
        gravity: (3,) in frame 0, m/s2.
        std: standard deviations of its components.
    """
    from scipy.spatial.transform import Rotation

    declared, name = variation(robot).gravity, "gravity_direction"
    after = np.round(gravity, 5) + 0.0  # without -0.0
    axes = zip("xyz", after.tolist(), std, strict=True)
    sizes = [Size(f"g{axis}", x, "m/s2", deviation) for axis, x, deviation in axes]
    if declared.any() and np.count_nonzero(after) > 1:
        name = TILT
        turn = Rotation.align_vectors(declared, after)[0].as_rotvec().round(6).tolist()
        turned = dict(zip(("TX", "TY", "TZ"), turn, strict=True))
        sizes += [Size(axis, x, "rad") for axis, x in turned.items() if x]
    return Change(definitions()[name], (), {}, sizes, gravity=tuple(after.tolist()))


def _driven(robot: Robot) -> list[int]:
    """Return the positions of the joints with a motor."""
    return [j for j, joint in enumerate(robot.movable) if joint.actuated]


def _sets(joints: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Yield the sets of up to half of some joints; single joints if there are many."""
    most = len(joints) // 2 if len(joints) <= _SETS else 1
    for count in range(1, most + 1):
        yield from itertools.combinations(joints, count)


def _orders(robot: Robot, keys: Iterable[str], joints: Iterable[int]) -> Iterator[list[Change]]:
    """Yield exchanged channels of two joints, and channels sorted by joint name."""
    rows, same = definitions(), dict.fromkeys(keys, 1.0)
    for j, k in itertools.combinations(joints, 2):
        order = [*range(robot.n)]
        order[j], order[k] = k, j
        yield [Change(rows["exchanged_channels"], (j, k), same, order=tuple(order))]
    if alphabetical := _alphabetical(robot):
        yield [Change(rows["joint_order"], (), same, order=alphabetical)]


def _alphabetical(robot: Robot) -> tuple[int, ...]:
    """Return the column of each joint if columns are sorted by joint name.

    The order is empty if a joint has no name, or if at most two joints change their column.
    """
    names = [joint.name for joint in robot.movable]
    columns = sorted(names)
    if not all(names):
        return ()
    order = tuple(columns.index(name) for name in names)
    moved = [j for j, column in enumerate(order) if j != column]
    return order if moved[2:] else ()  # `exchanged_channels` covers two joints


def late(joints: tuple[int, ...], delay: float) -> Change:
    """Return a delay of the torques of some joints, in s; an empty `joints` means all."""
    size = (Size("DT", delay, "s"),)
    return Change(definitions()["time_delay"], joints, {"tau": 1.0}, size, delay=delay)


def slow(joints: tuple[int, ...], lag: float) -> Change:
    """Return a first-order filter of the torques, time constant `lag` s; empty `joints`: all."""
    size = (Size("TF", lag, "s"),)
    return Change(definitions()["torque_filter"], joints, {"tau": 1.0}, size, lag=lag)


def geared_by(j: int, ratio: float) -> Change:
    """Return the change that multiplies the motion of a joint by `ratio`, its torque by 1/ratio."""
    factors = {"q": ratio, "qd": ratio, "tau": 1 / ratio}
    return Change(definitions()["gear_ratio"], (j,), factors, (Size("ratio", ratio, ""),))
