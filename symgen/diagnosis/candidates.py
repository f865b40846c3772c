"""Candidates: what each effect of the library would add to the torque, on a log's samples.

A candidate has columns on one or more joints: minus the derivative of its torque by each of its
coefficients, so that tau gains columns times coefficients. The torque inside a column is always the
model's, never the measured one. Constants that are searched give one candidate a value.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.diagnosis.shapes import Shape, Torques, contact, dahl, drift, gain, pulse
from symgen.diagnosis.whitened_system import Columns, compared
from symgen.errors import RobotError
from symgen.estimation.filtered import FilteredLog
from symgen.robot.effect import Definition, Search, Sought, definitions
from symgen.robot.types import Robot
from symgen.symbolic.effects import definition_tape
from symgen.symbolic.independence import FUNCTIONS
from symgen.symbolic.tape import Numbers, Tape

FloatArray = NDArray[np.float64]
Logs = Sequence[FilteredLog]
#: What the tape of an effect takes: arrays (N,) of joints, and numbers.
Inputs = Mapping[str, Sequence[Any]]


@dataclass(frozen=True, eq=False)
class Candidate:
    """One effect on certain joints with certain constants.

    Attributes:
        definition: of the library, or of the robot file or the search for expressions.
        joints: positions of the movable joints; empty for an effect on the whole arm.
        constants: value of each searched constant.
        columns: gives the columns at full rate from a scene and the model's torques on it.
        size: number of coefficients.
        uses_model: whether the columns hold the model's torque, and change with it.
        remake: gives the same candidate with other constants, where these can be refined.
        coefficients: name and unit of those that mean something, where not as in the library.
        change: whether it changes a declared parameter, which may grow or fall.
        measured: whether the logs show by a measurement of its own that it is there.
    """

    definition: Definition
    joints: tuple[int, ...]
    columns: Callable[[FilteredLog, Torques], Columns]
    size: int
    constants: Mapping[str, float] = field(default_factory=dict)
    uses_model: bool = False
    remake: Callable[[Mapping[str, float]], Candidate] | None = None
    coefficients: tuple[tuple[str, str], ...] = ()
    change: bool = False
    measured: bool = False

    @property
    def complexity(self) -> int:
        """How many numbers it brings; a mean of the logs is none."""
        given = sum(s.scale == "mean temp" for s in self.definition.nonlinear.values())
        return self.size + len(self.constants) - given

    @property
    def smooth(self) -> bool:
        """Whether it has constants along which its columns have a slope: those of a formula."""
        return bool(self.constants) and self.remake is not None and self.definition.declarable

    def moved(self, constants: Mapping[str, float]) -> Candidate:
        """Return the candidate with other constants, where it can be remade."""
        assert self.remake is not None
        return self.remake({**self.constants, **constants})

    @property
    def name(self) -> str:
        """The definition's."""
        return self.definition.name

    @property
    def key(self) -> tuple[str, tuple[int, ...]]:
        """What it is apart from its constants."""
        return self.name, self.joints

    def seen(self, logs: Logs, torques: Sequence[Torques]) -> Columns:
        """Return the columns (K, m) in the band at the kept instants of all logs."""
        pairs = [(s, self.columns(s, t)) for s, t in zip(logs, torques, strict=True)]
        return {j: np.concatenate([compared(s, c[j]) for s, c in pairs]) for j in pairs[0][1]}


def candidates(
    robot: Robot, logs: Logs, chosen: Sequence[str] | None = None, *, given: bool = False
) -> Iterator[Candidate]:
    """Yield the candidates of a robot: every effect, joint and constant that is not declared yet.

    Args:
        robot: what it declares is no candidate; what it wants to be searched is, in place of the
            library's ranges.
        logs: give the ranges that constants are parts of.
        chosen: names of effects to try; None for all.
        given: whether the parameters are given: then declared friction may have changed.
    """
    own = {s.key for s in robot.sought}
    for definition in definitions().values():
        if chosen is not None and definition.name not in chosen:
            continue
        if definition.native == "coupling":
            yield from _couplings(robot, definition)
        elif definition.name in _SPECIAL:
            yield from _SPECIAL[definition.name](robot, definition, logs)
        elif definition.torque:
            for position in range(robot.n):
                drifted = _declared(robot, definition, position)
                if drifted and not (given and definition.native in names.FRICTION):
                    continue
                joint = robot.movable[position]
                if (definition.name, joint.number) in own:
                    continue
                if not _measured(definition, logs, position):
                    continue
                searches = definition.nonlinear
                if any(search.scale == "gear" for search in searches.values()):
                    searches = _geared(searches, robot, position)
                    if not searches:
                        continue
                points = grid(searches, logs, position, joint.sigma)
                for candidate in on_joint(definition, position, points, joint.coulomb_width):
                    yield replace(candidate, change=drifted)
    for sought in robot.sought:
        if chosen is None or sought.effect.name in chosen:
            yield from _sought(robot, sought, logs)


def _declared(robot: Robot, definition: Definition, position: int) -> bool:
    joint = robot.movable[position]
    if definition.native in names.FRICTION:
        return definition.native in joint.friction
    if definition.native == "rotor":
        return joint.rotor_inertia
    known = {(e.name, e.joint) for e in robot.on_logs}
    known |= {(e.name, j) for e in robot.effects for j in e.joints}
    return (definition.name, joint.number) in known


def _measured(definition: Definition, logs: Logs, position: int) -> bool:
    """Whether all logs have what an effect reads beside the motion of a joint."""
    found = [getattr(s.samples, role) for s in logs for role in definition.reads]
    return all(x is not None and np.isfinite(x[:, position]).all() for x in found)


def _sought(robot: Robot, sought: Sought, logs: Logs) -> Iterator[Candidate]:
    """Yield an effect of the robot file with each value of its ranges."""
    (joint,), lengths = sought.effect.joints, robot.values()
    position = [j.number for j in robot.movable].index(joint)
    definition = sought.definition(lengths)
    points = grid(sought.searches(lengths), logs, position)
    if not definition.own:
        yield from on_joint(definition, position, points, robot.movable[position].coulomb_width)
        return
    tape = definition_tape(definition, robot)
    arithmetic = Numbers(lengths, FUNCTIONS)

    def torque(inputs: Inputs) -> list[FloatArray]:
        with np.errstate(all="ignore"):
            out = tape.run(arithmetic, inputs)
        if all(np.isfinite(c).all() for c in out):
            return out
        values = zip(definition.nonlinear, inputs["c"], strict=True)
        raise RobotError(
            f"effect {definition.name!r} of joint {joint}: on these logs its torque is not a "
            f"finite number with {', '.join(f'{name} = {value:.6g}' for name, value in values)}; "
            "accepted: ranges in which it is"
        )

    for values in points:
        yield single(definition, position, values, torque, range(robot.n))


def on_joint(
    definition: Definition,
    position: int,
    points: Iterable[Mapping[str, float]],
    width: float = 0.0,
) -> Iterator[Candidate]:
    """Yield an effect of the library on one joint, one candidate for each point of its constants.

    sign(qd) has the joint's width.
    """
    tape = _tape(definition.name)
    sign = {"sign": lambda v: np.tanh(v / width)} if width else {}
    arithmetic = Numbers({}, {**FUNCTIONS, **sign})

    def torque(inputs: Inputs) -> list[FloatArray]:
        with np.errstate(divide="ignore"):
            return tape.run(arithmetic, inputs)

    for values in points:
        yield single(definition, position, values, torque, (position,))


def single(
    definition: Definition,
    position: int,
    constants: Mapping[str, float],
    torque: Callable[[Inputs], list[FloatArray]],
    sees: Sequence[int],
) -> Candidate:
    """Return an effect with a torque expression on one joint.

    Args:
        definition: the effect.
        position: of the movable joint that it acts on.
        constants: value of each that is searched.
        torque: runs the tape of its columns.
        sees: positions of the joints whose variables the tape takes.
    """
    values = [float(constants[name]) for name in definition.nonlinear]

    def columns(s: FilteredLog, torques: Torques) -> Columns:
        variables = {"q": s.q, "qd": s.qd, "qdd": s.qdd, "taur": torques.load}
        variables |= {role: getattr(s.samples, role) for role in definition.reads}
        inputs = {letter: [x[:, j] for j in sees] for letter, x in variables.items()}
        out = torque({**inputs, "c": values})
        shape = (len(s.t),)
        parts = [np.broadcast_to(np.asarray(c, dtype=float), shape) for c in out]
        if definition.offset:
            parts.append(np.ones(shape))
        return {position: np.stack(parts, axis=1)}

    return Candidate(
        definition,
        (position,),
        columns,
        len(definition.linear) + definition.offset,
        dict(constants),
        uses_model="taur" in definition.torque,
        remake=lambda other: single(definition, position, other, torque, sees),
    )


@cache
def _tape(name: str) -> Tape:
    return definition_tape(definitions()[name])


def grid(
    searches: Mapping[str, Search], logs: Logs, position: int, sigma: int = names.REVOLUTE
) -> Iterator[dict[str, float]]:
    """Yield the values of constants that are tried, in the units of the joint."""
    axes = []
    for search in searches.values():
        if search.scale == "mean temp":
            axes.append([_mean_temperature(logs, position)])
            continue
        unit = _unit(search, logs, position, sigma)
        spaced = np.geomspace if search.by_ratio else np.linspace
        values = spaced(search.low, search.high, search.count) * unit
        axes.append([float(v) for v in values])
    for point in itertools.product(*axes):
        yield dict(zip(searches, point, strict=True))


def _mean_temperature(logs: Logs, position: int) -> float:
    """Return the mean temperature of a joint over the logs, to 0.1 deg C."""
    measured = [s.samples.temp for s in logs]
    own = np.concatenate([x[:, position] for x in measured if x is not None])
    return round(float(np.mean(own)), 1)


def _geared(searches: Mapping[str, Search], robot: Robot, position: int) -> Mapping[str, Search]:
    """Return ranges that count turns of a motor; without those of a gear that is not known."""
    ratio = 0.0 if robot.drive is None else abs(robot.drive.ratio[position][position])
    return {
        name: search
        if search.scale != "gear"
        else replace(search, low=ratio * search.low, high=ratio * search.high)
        for name, search in searches.items()
        if ratio > 1 or search.scale != "gear"
    }


def _unit(search: Search, logs: Logs, position: int, sigma: int) -> float:
    if search.scale == "turn" and sigma == names.PRISMATIC:  # periods over the slide's way
        return 2 * np.pi / _unit(replace(search, scale="range"), logs, position, sigma)
    if search.scale == "speed":
        speeds = np.concatenate([s.qd[:, position] for s in logs])
        return float(np.sqrt(np.mean(speeds**2))) or 1.0
    if search.scale == "range":
        return max(float(np.ptp(s.q[s.kept, position])) for s in logs) or 1.0
    if search.scale == "duration":
        return max(float(s.t[-1] - s.t[0]) for s in logs)
    return 1.0


def _couplings(robot: Robot, definition: Definition) -> Iterator[Candidate]:
    """Yield drives that move two joints; the pair's second joint gives the parameters' number."""
    known = {frozenset((c.first, c.second)) for c in robot.couplings}
    numbers = [j.number for j in robot.movable]
    for j, k in itertools.combinations(range(robot.n), 2):
        if frozenset((numbers[j], numbers[k])) in known:
            continue
        for ratio in (1.0, -1.0):
            yield coupling(definition, j, k, ratio)


def coupling(definition: Definition, j: int, k: int, ratio: float) -> Candidate:
    """Return u = qd_j + ratio qd_k, F = IAM u' + FVM u + FSM sign(u) on j, ratio F on k."""

    def columns(s: FilteredLog, _: Torques) -> Columns:
        u = s.qd[:, j] + ratio * s.qd[:, k]
        F = np.stack([s.qdd[:, j] + ratio * s.qdd[:, k], u, np.sign(u)], axis=1)
        return {j: F, k: ratio * F}

    return Candidate(definition, (j, k), columns, 3, {"ratio": ratio})


def _delays(robot: Robot, definition: Definition, _: Logs) -> Iterator[Candidate]:
    """A torque that comes late by DT: tau(t) = model(t - DT), to first order -DT d(model)/dt."""

    def columns(s: FilteredLog, torques: Torques) -> Columns:
        rate = -np.gradient(torques.model, s.step, axis=0)
        return {j: rate[:, j : j + 1] for j in range(robot.n)}

    yield Candidate(definition, (), columns, 1, uses_model=True)


_Maker = Callable[[Robot, Definition, Logs], Iterator[Candidate]]


def _shaped(
    definition: Definition, position: int, constants: Mapping[str, float], shape: Shape
) -> Candidate:
    """Return an effect with one coefficient on one joint."""

    def columns(s: FilteredLog, torques: Torques) -> Columns:
        return {position: shape(s, torques, position, constants)[:, None]}

    return Candidate(
        definition,
        (position,),
        columns,
        1,
        dict(constants),
        uses_model=shape in (gain, drift),
        remake=lambda other: _shaped(definition, position, other, shape),
    )


def _each(shape: Shape) -> _Maker:
    """Return what yields an effect on every joint with every value of its constants."""

    def make(robot: Robot, definition: Definition, logs: Logs) -> Iterator[Candidate]:
        for position in range(robot.n):
            for values in grid(definition.nonlinear, logs, position):
                yield _shaped(definition, position, values, shape)

    return make


def _contacts(robot: Robot, definition: Definition, logs: Logs) -> Iterator[Candidate]:
    """Yield the contacts whose window of time lies within a log."""
    longest = max(float(s.t[s.kept][-1] - s.t[0]) for s in logs)
    for candidate in _each(contact)(robot, definition, logs):
        if candidate.constants["start"] + candidate.constants["length"] <= longest:
            yield candidate


_SPECIAL: dict[str, _Maker] = {
    "time_delay": _delays,
    "drive_gain_error": _each(gain),
    "thermal_drift": _each(drift),
    "backlash": _each(pulse),
    "dahl_friction": _each(dahl),
    "external_contact": _contacts,
}
