"""Possible faults beside a model, to first order: columns C with tau = W X + C theta.

An error of the geometry also has its exact regressor W, for any size.

    zero of a joint                  d tau / d q_j
    gain of a torque                 tau_j
    gear ratio of a joint            tau_j + d tau / d(scale of q_j and its derivatives)
    slow filter of a torque          - d tau_j / dt
    length of the geometry           d tau / d length
    weight that something carries    - tau_j at rest
    a load on the last link          tau of its mass and its moments
    friction of a joint              sign(qd_j), qd_j
    an external torque on a joint    1

Zeros, gains and the last three may begin within a log, or grow along it. The last three are no
fault if they are permanent. Physics that the model may lack also has columns, without a name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from symgen import names
from symgen.data.mask import rms
from symgen.estimation.decimation import BLOCK
from symgen.estimation.features import WAVES
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import LACKS
from symgen.estimation.predictive_score import Columns, everywhere
from symgen.estimation.values import FloatArray
from symgen.faults.scene import Scene
from symgen.faults.undo import geared, multiplied
from symgen.symbolic.variation import link_values

#: Returns a log without a fault.
Undo = Callable[[FilteredLog], FilteredLog]
#: Sizes that sound robots have: zeros 0.5 degrees, factors 5 %.
ZERO, FACTOR = math.radians(0.5), 0.05
_FAR = 0.7  # rad: largest zero offset that is found
_SLOW = 0.02  # s: filters that sound drives have
_LONG = 0.5  # largest relative error of a length that is found
_WHOLE = 1.5  # largest compensated share of a weight, with the error of the estimate
_STEP = 1e-4  # rad or relative, step of differences
_PHYSICS = "physics"


class Sized(NamedTuple):
    """The model with a fault of one size: tau = W X + C theta, theta added to the size.

    Attributes:
        x: the size.
        W: (K, n, p) regressor.
        columns: C, the change of torque with the size.
    """

    x: float
    W: FloatArray
    columns: Columns


@dataclass(frozen=True, eq=False)
class Shape:
    """Columns beside the model, and the meaning of their first coefficient.

    Attributes:
        kind: a key of KINDS.
        joints: indices; empty for all.
        columns: (K, m) by joint.
        words: message, with {x} for the coefficient and {when} for its time.
        channel: the channel of the logs; "" if none is wrong.
        least: size that sound robots have.
        within: possible range of the coefficient.
        shown: converts the coefficient to {x}.
        changes: whether it may begin within a log.
        fades: whether it may fall along a log, as friction does in a joint that warms up.
        always: whether it may be permanent.
        undo: returns a log without the fault of that coefficient; None if no log can be corrected.
        size: expected RMS torque of each column, N m or N.
        at: returns the exact regressor (K, n, p) for a coefficient; None if `columns` are exact or
            a log without the fault shows its size.
        sized: the model with the fault of a size near that of the fit; None for size 0.
    """

    kind: str
    joints: tuple[int, ...]
    columns: Columns
    words: str = ""
    channel: str = ""
    least: float = 0.0
    within: tuple[float, float] = (-math.inf, math.inf)
    shown: Callable[[float], float] = float
    changes: bool = False
    fades: bool = False
    always: bool = True
    undo: Callable[[float], Undo] | None = None
    size: float = math.inf
    at: Callable[[float], FloatArray] | None = None
    sized: Sized | None = None

    @property
    def physics(self) -> bool:
        """Whether it is physics without a name."""
        return self.kind == _PHYSICS

    @property
    def free(self) -> bool:
        """Whether it is physics of any shape."""
        return math.isfinite(self.size)

    def says(self, x: float, when: str = "") -> str:
        """Return the message for a coefficient; "" if it is no larger than in every robot."""
        told = self.words.format(x=self.shown(x), when=when)
        return told if abs(x) > self.least else ""


_BRACES = str.maketrans("{}", "()")  # `words` is a format string


def _label(scene: Scene, j: int) -> str:
    robot = scene.rows.evaluator.model.robot
    return robot.label(robot.movable[j].number).translate(_BRACES)


def _slope(scene: Scene, moved: Callable[[float], Callable[..., FloatArray]]) -> FloatArray:
    """Return d tau / dx at 0 of a model that moves with x, (K, n), without friction."""

    def difference(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        low, high = (moved(h)(q, qd, qdd) for h in (-_STEP, _STEP))
        return np.asarray((high - low) / (2 * _STEP))

    return scene.rows.along(difference, smooth=True)


def _zeros(scene: Scene) -> Iterator[Shape]:
    """Yield zero offsets of revolute joints."""
    for j, joint in enumerate(scene.rows.evaluator.model.robot.movable):
        if joint.sigma != names.REVOLUTE or joint.follows is not None:
            continue
        unit = np.eye(scene.n)[j]

        def moved(h: float, unit: FloatArray = unit) -> Callable[..., FloatArray]:
            return lambda q, qd, qdd: scene.torque(q + h * unit, qd, qdd)

        def model(x: float, unit: FloatArray = unit) -> FloatArray:
            regressor, p = scene.rows.evaluator["torque_regressor"], scene.rows.W.shape[2]

            def change(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
                moved, own = regressor(q + x * unit, qd, qdd), regressor(q, qd, qdd)
                return np.asarray((moved - own)[:, :, :p])

            return scene.rows.W + scene.rows.along(change, BLOCK, smooth=True)

        label = _label(scene, j)
        yield Shape(
            "zero",
            (j,),
            everywhere(_slope(scene, moved)[:, :, None]),
            f"the zero of {label} is off by about {{x:.2g}} degrees{{when}}: correct theta "
            f"of {label}; symgen diagnose --effects zero_offset gives the value",
            least=ZERO,
            within=(-_FAR, _FAR),
            shown=lambda x: abs(math.degrees(x)),
            changes=True,
            at=model,
        )


def _divided(j: int, x: float) -> Undo:
    return partial(multiplied, joints=(j,), factor=1 / (1 + x), keys=("tau",))


def _regeared(j: int, x: float) -> Undo:
    return partial(geared, j=j, ratio=1 + x)


def _gains(scene: Scene) -> Iterator[Shape]:
    """Yield torques with another factor than those of the other joints."""
    for j in range(scene.n if scene.n > 1 else 0):
        yield Shape(
            "gain",
            (j,),
            {j: scene.model[:, [j]]},
            f"tau{j + 1} is {{x:.3g}} times as large as the other joints require{{when}}: check "
            "the torque constant, the gear ratio and the unit",
            f"tau{j + 1}",
            least=FACTOR,
            within=(_STEP - 1, math.inf),  # signs are tried in sets
            shown=lambda x: 1 + x,
            changes=True,
            undo=partial(_divided, j),
        )


def _ratios(scene: Scene) -> Iterator[Shape]:
    """Yield joints that were recorded with another gear ratio."""
    for j in range(scene.n if scene.n > 1 else 0):
        unit = np.eye(scene.n)[j]

        def moved(h: float, unit: FloatArray = unit) -> Callable[..., FloatArray]:
            by = 1 + h * unit
            return lambda q, qd, qdd: scene.torque(by * q, by * qd, by * qdd)

        columns = _slope(scene, moved)
        columns[:, j] += scene.model[:, j]
        channel = f"q{j + 1}, qd{j + 1}, tau{j + 1}"
        yield Shape(
            "ratio",
            (j,),
            everywhere(columns[:, :, None]),
            f"{channel}: the gear ratio of {_label(scene, j)} is off by a factor "
            "{x:.3g} (positions times it, torque over it): check it",
            channel,
            least=FACTOR,
            within=(_STEP - 1, math.inf),
            shown=lambda x: 1 + x,
            undo=partial(_regeared, j),
        )


def _filtered(scene: Scene) -> Iterator[Shape]:
    """Yield torques that pass a slow first-order filter with time constant T, of all or of one.

        tau = W X - T d tau / dt

    This is exact for any T. If the delay of a filter of all torques is undone, T^2/2 d2 tau / dt2
    remains.
    """
    rate = [-np.gradient(log.tau, log.step, axis=0) for log in scene.rows.logs]
    bent = [-np.gradient(x, log.step, axis=0) for log, x in zip(scene.rows.logs, rate, strict=True)]
    for order, slopes in enumerate((rate, bent), 1):
        parts = [log.unmasked.compared(x) for log, x in zip(scene.rows.logs, slopes, strict=True)]
        column = np.concatenate(parts)[:, :, None]
        # Only a delay of all torques is undone.
        alone = range(scene.n if scene.n > 1 and order == 1 else 0)
        for joints in ((), *((j,) for j in alone)):
            channel, which = (f"tau{joints[0] + 1}", "it") if joints else ("tau", "all torques")
            yield Shape(
                "filter",
                joints,
                {j: column[:, j] for j in joints or range(scene.n)},
                f"{channel}: a slow filter of about {{x:.2g}} ms delays {which}: log "
                f"{'it' if joints else 'them'} without it",
                least=_SLOW**order / order,
                within=(0.0, math.inf),
                shown=partial(_filter_ms, order),
            )


def _filter_ms(order: int, x: float) -> float:
    return float(1e3 * (order * x) ** (1 / order))


def _weights(scene: Scene) -> Iterator[Shape]:
    """Yield torques of one joint without its weight, or a part of it."""
    weight = scene.rows.at_rest @ scene.X
    for j in range(scene.n):
        if np.any(weight[:, j]):
            yield Shape(
                "weight",
                (j,),
                {j: -weight[:, [j]]},
                f"tau{j + 1} lacks about {{x:.2g}} % of the weight that "
                f"{_label(scene, j)} supports: something else carries it (a spring, a "
                "counterweight, a controller's gravity compensation); symgen diagnose --effects "
                "gravity_compensation",
                least=FACTOR,
                within=(0.0, _WHOLE),
                shown=lambda x: 100 * x,
            )


def _lengths(scene: Scene) -> Iterator[Shape]:
    """Yield errors of the non-zero lengths, for robots without loops."""
    model, v = scene.rows.evaluator.model, scene.rows.variation
    if model.robot.loops or any(j.follows is not None for j in model.robot.joints):
        return
    links = link_values(model.robot, model.base, scene.whole)
    units = np.array([link_values(model.robot, model.base, X) for X in np.eye(len(scene.whole))])
    own = np.flatnonzero(units.any(axis=(1, 2)))
    for number, key in v.lengths:

        def moved(h: float, at: tuple[int, str] = (number, key)) -> Callable[..., FloatArray]:
            return lambda q, qd, qdd: v.torque((q, qd, qdd), links, changes={at: h})

        def longer(x: float, at: tuple[int, str] = (number, key)) -> FloatArray:
            def columns(*state: FloatArray) -> FloatArray:
                return v.regressor(state, units[own], changes={at: x})

            W = scene.rows.W.copy()
            W[:, :, own] = scene.rows.along(columns, BLOCK, smooth=True)
            return W

        length = abs(float(getattr(model.robot.with_values().joint(number), key)))
        yield Shape(
            f"length {key}{number}",
            (),
            everywhere(_slope(scene, moved)[:, :, None]),
            f"the length {key} of {model.robot.label(number).translate(_BRACES)} is off by "
            f"about {{x:.2g}} mm: correct it; symgen "
            "diagnose --effects geometry_error gives the value",
            least=0.01 * length,
            within=(-_LONG * length, _LONG * length),
            shown=lambda x: 1e3 * abs(x),
            at=longer,
        )


def _loads(scene: Scene) -> Iterator[Shape]:
    """Yield a load on the last link from some time on; a permanent load belongs to the link."""
    robot = scene.rows.evaluator.model.robot
    links = np.zeros((4, len(robot.moving), len(names.LINK)))
    last = robot.moving.index(robot.movable[-1])
    for i, prefix in enumerate((names.MASS, *names.MOMENT)):
        links[i, last, names.LINK.index(prefix)] = 1.0

    def loaded(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        return scene.rows.variation.regressor((q, qd, qdd), links).reshape(len(q), -1)

    columns = scene.rows.along(loaded, BLOCK, smooth=True).reshape(*scene.rows.y.shape, -1)
    words = (
        "the last link carries another load{when}: identify from logs with one load; symgen "
        "payload gives its mass"
    )
    yield Shape("load", (), everywhere(columns), words, changes=True, always=False)


def _frictions(scene: Scene) -> Iterator[Shape]:
    """Yield a change of friction of one joint; permanent friction belongs to the joint."""
    speeds = scene.rows.along(lambda _, qd, __: np.hstack([np.sign(qd), qd]))
    for j in range(scene.n):
        words = (
            f"the friction of {_label(scene, j)} changes{{when}}: a brake, or a joint that warms "
            "up; identify from logs in one state"
        )
        columns = {j: speeds[:, [j, scene.n + j]]}
        yield Shape("friction", (j,), columns, words, changes=True, fades=True, always=False)


def _offsets(scene: Scene) -> Iterator[Shape]:
    """Yield an external torque on one joint that begins or grows."""
    for j in range(scene.n):
        words = (
            f"tau{j + 1} drifts, or an external load acts{{when}}: zero the sensor, and leave the "
            "time of contact out"
        )
        columns = {j: np.ones((len(scene.rows.y), 1))}
        yield Shape("offset", (j,), columns, words, changes=True, always=False)


def _rivals(scene: Scene) -> Iterator[Shape]:
    """Yield physics of one joint that a model may lack.

    It depends on the joint's friction, load, position and inertia, on the motion of other joints,
    or on any function of positions and speeds. This function may jump where the joint turns back.
    """
    typical = rms(np.concatenate([log.qd for log in scene.rows.logs]))
    typical = np.where(typical > 0, typical, 1.0)

    def laws(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> list[list[FloatArray]]:
        sign, load, v = np.sign(qd), np.abs(scene.torque(q, qd, qdd)), qd / typical
        return [
            [sign, v, v * np.abs(v), sign * np.exp(-((v / 0.3) ** 2))],
            [sign * q, sign * np.sin(q), sign * np.cos(q)],
            [sign * load, v * load],
            [np.ones_like(q), q, np.sin(q), np.cos(q), np.sin(2 * q), np.cos(2 * q)],
            [qdd],
        ]

    def flat(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        return np.stack([c for law in laws(q, qd, qdd) for c in law], axis=2).reshape(len(q), -1)

    columns = scene.rows.along(flat).reshape(*scene.rows.y.shape, -1)
    ends = np.cumsum([len(law) for law in laws(*np.zeros((3, 1, scene.n)))])[:-1]
    for j in range(scene.n):
        for own in np.split(columns[:, j], ends, axis=1):
            yield Shape(_PHYSICS, (j,), {j: own})
    moved = scene.rows.along(lambda _, qd, qdd: np.hstack([qd, np.sign(qd), qdd]))
    for j in range(scene.n if scene.n > 1 else 0):
        others = np.arange(moved.shape[1]) % scene.n != j
        yield Shape(_PHYSICS, (j,), {j: moved[:, others]})
    for j, size in enumerate(LACKS * scene.rows.size / math.sqrt(2 * WAVES)):
        yield Shape(_PHYSICS, (j,), {j: scene.rows.waves[:, j]}, size=float(size))


#: Shapes that are tried beside a model.
KINDS: Mapping[str, Callable[[Scene], Iterator[Shape]]] = {
    "zero": _zeros,
    "gain": _gains,
    "ratio": _ratios,
    "filter": _filtered,
    "weight": _weights,
    "length": _lengths,
    "load": _loads,
    "friction": _frictions,
    "offset": _offsets,
    _PHYSICS: _rivals,
}
