"""Candidates: the columns that each effect of the library adds to the torque equations.

A candidate has columns on one or more joints. A column is minus the derivative of the effect's
torque with respect to one coefficient. The motor torque gains columns times coefficients. A column
contains only torques of the model, because the measured torque correlates with the noise. A
candidate has one value for each searched constant.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import Any

import numpy as np

from symgen import names
from symgen.errors import RobotError
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.opening import LATE
from symgen.estimation.values import FloatArray
from symgen.hypotheses.judged import Hypothesis, Judged, Size
from symgen.hypotheses.score import Columns, Key, everywhere
from symgen.hypotheses.sought import sought_definition, sought_searches
from symgen.parallel import in_order, thread_count
from symgen.robot.effect import OWN, Definition, SearchRange, definitions
from symgen.robot.types import Robot
from symgen.symbolic.effects import definition_tape
from symgen.symbolic.sampling import FUNCTIONS
from symgen.symbolic.tape import Numbers, Tape

Logs = Sequence[FilteredLog]
_BATCH = 48  # candidates whose columns pass the filter in one call
#: Smallest searched pitch of a rack or screw, m, if the search stays within this multiple.
_PITCH, _MOST = 0.01, 10
_PINION = 0.05  # m, radius of a pinion: converts its play in rad to the play of the rack
#: Name of the constant of an effect that begins within a log: its time, s.
START = "start"
_STARTS = 16  # start times to try for an effect that begins within a log
Constants = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Torques:
    """Torques of the model along a log.

    Attributes:
        model: (N, n) torque of the model.
        load: (N, n) rigid-body torque of the joints: taur of effects.
        friction: (N, n) friction of the declared model, without accepted effects.
        links: (links, 10) link parameters that give this torque, one of many such sets.
        of_links: function from the arrays of `FilteredLog.motion` to the torque (k, n) of these
            links, in the geometry of the file.
        gravity: gravity of the model in frame 0, (3,) m/s2.
    """

    model: FloatArray
    load: FloatArray
    friction: FloatArray
    links: FloatArray
    of_links: Callable[..., FloatArray]
    gravity: FloatArray

    def rigid(self, s: FilteredLog) -> FloatArray:
        """Return the torque of the links along a log, (N, n)."""
        return self.of_links(*s.motion)

    def weight(self, s: FilteredLog) -> FloatArray:
        """Return the torque of the links at rest along a log, (N, n)."""
        rest = np.zeros_like(s.q)
        return self.of_links(s.q, rest, rest, *s.base)

    def moved(self, s: FilteredLog, j: int, along: FloatArray) -> FloatArray:
        """Return `rigid` with other positions, speeds and accelerations of joint j.

        Args:
            s: the log.
            j: position of the joint.
            along: (3, N) or (3, 1), added to position, speed and acceleration.
        """
        state = [x.copy() for x in (s.q, s.qd, s.qdd)]
        for x, a in zip(state, along, strict=True):
            x[:, j] += a
        return self.of_links(*state, *s.base)


#: Returns columns at the rate of a log from the log, the model's torques and the constants.
Torque = Callable[[FilteredLog, Torques, Constants], Columns]


@dataclass(frozen=True, eq=False)
class Candidate(Hypothesis):
    """One effect on certain joints with certain constants.

    Attributes:
        torque: function that returns the columns.
        size: number of coefficients.
        constants: value of each searched constant.
        uses_model: whether the columns contain the model's torque.
        analytic: whether the columns are smooth functions of the motion, without sign(qd).
        coefficients: name and unit of the coefficients; empty for those of the library.
        alters: whether it changes a declared parameter, which may then have either sign.
        first_order: whether its column is the first-order approximation of a change of the logs.
        scales: expected size of each coefficient in its unit; None to use the expected torque.
    """

    torque: Torque
    size: int
    constants: Constants = field(default_factory=dict)
    uses_model: bool = False
    analytic: bool = False
    coefficients: tuple[tuple[str, str], ...] = ()
    alters: bool = False
    scales: tuple[float, ...] | None = None
    first_order: bool = False

    @property
    def degrees(self) -> int:
        """Number of coefficients and searched constants."""
        return self.size + len(self.constants)

    @property
    def smooth(self) -> bool:
        """Whether its constants can be refined between the points of their grid."""
        return bool(self.constants) and self.definition.native != "coupling"

    @property
    def rare(self) -> bool:
        """Whether it is tried only on joints with large errors."""
        return self.name == "balancer" or abs(self.constants.get("ratio", 1.0)) != 1.0

    def moved(self, constants: Constants) -> Candidate:
        """Return the candidate with some constants changed."""
        return replace(self, constants={**self.constants, **constants})

    def only_in(self, logs: Iterable[FilteredLog]) -> Candidate:
        """Return the candidate with zero torque on all other logs."""
        inside = {log.name for log in logs}

        def torque(log: FilteredLog, torques: Torques, constants: Constants) -> Columns:
            columns = self.torque(log, torques, constants)
            return {j: c * (log.name in inside) for j, c in columns.items()}

        return replace(self, torque=torque)

    @property
    def key(self) -> Key:
        """Name and joints, without the constants; "NAME begins" if it begins within a log."""
        return f"{self.name} begins" if START in self.constants else self.name, self.joints

    @property
    def sizes(self) -> Sequence[Size]:
        """Its constants, in the units of a revolute joint."""
        unit_of = self.definition.unit_of
        return [Size(name, x, unit_of(name, names.REVOLUTE)) for name, x in self.constants.items()]

    def columns(self, log: FilteredLog, torques: Torques) -> Columns:
        """Return the columns (N, m) at the rate of the log."""
        return self.torque(log, torques, self.constants)


@dataclass(frozen=True, eq=False)
class LogColumns:
    """The columns of candidates on some logs, for one model.

    Attributes:
        logs: logs in the band of the run.
        torques: torques of the model along each log, at a reduced rate.
    """

    logs: Logs
    torques: Sequence[Torques]

    def __call__(self, candidate: Candidate) -> Columns:
        """Return the columns of a candidate by equation, in the band at the kept samples of all
        logs.
        """
        return next(self.each([candidate]))

    def each(self, candidates: Iterable[Candidate]) -> Iterator[Columns]:
        """Yield the columns of several candidates.

        It filters many columns in one call, in threads, which is faster than one call for each.
        """
        for kind, group in itertools.groupby(candidates, lambda c: (c.measured, c.analytic)):
            of_kind = [*group]
            strides = [_stride(log, *kind) for log in self.logs]
            thin = [log.every(k) for log, k in zip(self.logs, strides, strict=True)]
            filtered = partial(self._filtered, strides=strides, thin=thin)
            starts = range(0, len(of_kind), _BATCH)
            batches = [of_kind[k : k + _BATCH] for k in starts]
            threads = min(thread_count(), len(batches))
            yield from itertools.chain.from_iterable(in_order(filtered, batches, threads))

    def _filtered(
        self, batch: Sequence[Candidate], strides: Sequence[int], thin: Logs
    ) -> list[Columns]:
        """Return the columns of some candidates in the band.

        Args:
            batch: the candidates.
            strides: sampling step of each thinned log, in samples of the log.
            thin: the thinned logs.
        """
        parts = []
        of_batch: list[Columns] = []
        for log, stride, s, torques in zip(self.logs, strides, thin, self.torques, strict=True):
            of_batch = [candidate.columns(s, torques) for candidate in batch]
            if log.base_rows:
                of_batch = [self._by_equation(log, stride, columns) for columns in of_batch]
            raw = [x for columns in of_batch for x in columns.values()]
            parts.append(log.unmasked.compared(np.concatenate(raw, axis=1), stride))
        band, at = np.concatenate(parts), 0
        out: list[Columns] = []
        for columns in of_batch:  # all logs have columns on the same equations
            of_candidate = {}
            for j, x in columns.items():
                end = at + x.shape[1]
                of_candidate[j] = np.ascontiguousarray(band[:, at:end])
                at = end
            out.append(of_candidate)
        return out

    def _by_equation(self, log: FilteredLog, stride: int, columns: Columns) -> Columns:
        """Return columns on joints by equation of a floating base.

        Where forces at contacts are unknown, columns are projected as the equations are, see
        `symgen.estimation.floating`, and then stand in all of them.
        """
        if not any(x.hides for x in self.logs):
            return {log.base_rows + j: c for j, c in columns.items()}
        spread = log.spread(stride)
        parts = [spread[:, :, [j]] * c[:, None] for j, c in columns.items()]
        return everywhere(sum(parts[1:], parts[0]))


def _stride(log: FilteredLog, measured: bool, analytic: bool) -> int:
    """Return the sampling step of columns along a log, in samples."""
    if measured:  # a noisy channel has to pass the filter at the full rate
        return 1
    return log.smooth_stride if analytic else log.rows.stride


@dataclass(frozen=True, eq=False)
class Score(Judged):
    """The score of an effect in a model with other effects.

    Attributes:
        cause: the effect with its constants.
        columns: columns by joint, in the band at the kept samples.
        cost: log-odds of the best constants minus `odds`.
        probability: probability that the effect, or one of its class, is present.
        why: reason why it is not accepted, or "".
    """

    cause: Candidate
    columns: Columns = field(default_factory=dict)
    cost: float = 0.0
    probability: float = 1.0
    why: str = ""


def total_odds(score: Score, scores: Iterable[Score]) -> float:
    """Return the log-odds of an effect plus those of the effects that require it."""
    requiring = [s for s in scores if s.cause.presumes(score.cause)]
    return score.odds + sum(s.odds for s in requiring)


def candidates(robot: Robot, logs: Logs, *, fixed: bool = False) -> Iterator[Candidate]:
    """Yield the candidates of a robot: all effects, joints and constants that it does not declare.

    Args:
        robot: the robot. Ranges in its file replace those of the library.
        logs: define the ranges of constants that are relative to the motion.
        fixed: whether the parameters are fixed. Then a change of declared friction is a candidate.
    """
    for definition in definitions().values():
        if definition.native == "coupling":
            yield from _couplings(robot, definition)
        elif definition.name == "crosstalk":
            for j, k in itertools.permutations(range(robot.n), 2):
                yield Candidate(definition, (j, k), partial(_crossed, j, k), 1, uses_model=True)
        elif definition.torque or definition.name == "presliding_friction":
            for position in range(robot.n):
                yield from _of_library(robot, definition, position, logs, fixed=fixed)
    values = robot.values()
    numbers = [joint.number for joint in robot.movable]
    for sought in robot.sought:
        position = numbers.index(sought.effect.joints[0])
        plain = _on_joint(robot, sought_definition(sought, values), position)
        for constants in constant_grid(robot, sought_searches(sought, values), logs, position):
            yield replace(plain, constants=constants)


def _of_library(
    robot: Robot, definition: Definition, position: int, logs: Logs, *, fixed: bool
) -> Iterator[Candidate]:
    """Yield an effect of the library on one joint, for all constants of its grid."""
    joint = robot.movable[position]
    declared = _declared(robot, definition, position)
    changes = fixed and definition.native in names.FRICTION
    sought = {s.key for s in robot.sought}
    plain = _on_joint(robot, definition, position)
    if (changes or not declared) and (definition.name, joint.number) not in sought:
        for constants in constant_grid(robot, definition.nonlinear, logs, position):
            yield replace(plain, constants=constants, alters=declared)
    yield from begun(plain, logs)


def _declared(robot: Robot, definition: Definition, position: int) -> bool:
    joint = robot.movable[position]
    if definition.native == "rotor":
        return joint.rotor_inertia
    known = {e.name for e in robot.effects if joint.number in e.joints}
    return definition.name in known or definition.native in joint.friction


def begun(candidate: Candidate, logs: Logs) -> Iterator[Candidate]:
    """Yield an effect that begins at a time within one of the logs and lasts to its end.

    The times are spread evenly over all logs. An effect whose odds `begins` are 0 yields nothing.
    """
    definition = candidate.definition
    begins = definition.begins
    lengths = [log.samples.length for log in logs]
    for log, length in zip(logs, lengths, strict=True):
        first = float(log.t[0])
        count = max(1, round(_STARTS * length / sum(lengths))) if begins else 0
        late = replace(
            definition,
            kind="log",
            pattern="time",
            native="",
            torque="",
            formula=f"{definition.formula or definition.torque}, in {log.name} from t = start on",
            nonlinear={START: SearchRange(first, first + length, count, "duration")},
            sign="any",
            odds=begins,
            advice="identify from logs in one state",
        )
        for part in range(count):
            yield replace(
                candidate,
                definition=late,
                torque=partial(_after, log.name, candidate.torque),
                constants={START: first + length * (part + 1) / (count + 1)},
                analytic=False,
            )


def _after(
    name: str, torque: Torque, s: FilteredLog, torques: Torques, constants: Constants
) -> Columns:
    """Return the columns of an effect in one log after its start time, and zeros elsewhere."""
    on = np.clip((s.t - constants[START]) / s.step + 0.5, 0.0, 1.0)
    if s.name.removesuffix(LATE) != name:
        on = np.zeros_like(s.t)
    return {j: c * on[:, None] for j, c in torque(s, torques, constants).items()}


def _on_joint(robot: Robot, definition: Definition, position: int) -> Candidate:
    """Return an effect on one joint, without constants."""
    size = len(definition.linear) + definition.offset
    if not definition.torque:
        return Candidate(definition, (position,), partial(_presliding, position), size)
    torque = _written(robot, definition, position)
    uses_model = "tau" in definition.torque or "friction" in definition.torque
    return Candidate(definition, (position,), torque, size, uses_model=uses_model)


def _written(robot: Robot, definition: Definition, position: int) -> Torque:
    """Return the columns of an effect whose torque is an expression."""
    joint = robot.movable[position]
    functions: dict[str, Callable[..., Any]] = dict(FUNCTIONS)
    if definition.own:  # its expression contains variables of any joint
        tape, joints = definition_tape(definition, robot), slice(None)
    else:
        tape, joints = _tape(definition.name), slice(position, position + 1)
        if joint.coulomb_width:  # the width of sign(qd)
            functions["sign"] = lambda v: np.tanh(v / joint.coulomb_width)
    arithmetic = Numbers(robot.values() if definition.own else {}, functions)

    def columns(s: FilteredLog, torques: Torques, constants: Constants) -> Columns:
        time = np.broadcast_to((s.t - s.t[0])[:, None], s.q.shape)
        motion = (s.q, s.qd, s.qdd)
        model = (torques.load, torques.model, torques.friction)
        variables = dict(zip(OWN, (*motion, *model, time), strict=True))
        inputs = dict[str, list[Any]]()
        for key, x in variables.items():
            inputs[key] = [*x[:, joints].T]
        inputs["c"] = [np.float64(constants[name]) for name in definition.nonlinear]
        with np.errstate(all="ignore"):
            parts = tape.run(arithmetic, inputs)
        if definition.offset:
            parts = [*parts, 1.0]
        column = np.column_stack([np.broadcast_to(np.asarray(c, float), s.t.shape) for c in parts])
        if definition.own and not np.isfinite(column).all():
            values = ", ".join(f"{name} = {constants[name]:.6g}" for name in definition.nonlinear)
            raise RobotError(
                f"effect {definition.name!r} of {names.joint_label(joint.number, joint.name)}: "
                "on these logs its torque is "
                f"not a finite number with {values}; accepted: ranges in which it is"
            )
        return {position: column}

    return columns


@cache
def _tape(name: str) -> Tape:
    return definition_tape(definitions()[name])


def constant_grid(
    robot: Robot, searches: Mapping[str, SearchRange], logs: Logs, position: int
) -> Iterator[dict[str, float]]:
    """Yield the values of constants to try, in the units of the joint.

    A range in turns of the motor yields nothing if the gear ratio is unknown.
    """
    axes = []
    for search in searches.values():
        origin, unit = _scale(robot, search.scale, logs, position)
        spaced = np.geomspace if search.by_ratio else np.linspace
        high, count = search.high, search.count
        if search.scale == "turn" and robot.movable[position].slides:
            periods = round(2 * np.pi / (unit * _PITCH))
            high = min(max(high, periods), _MOST * high)
            count = round(high - search.low) + 1
        values = spaced(search.low, high, count)
        if search.scale == "turn":  # two periods or fewer are any smooth function
            _, travel = _scale(robot, "range", logs, position)
            values = values[unit * travel * values > 4.001 * np.pi]
        axes.append([float(origin + unit * v) for v in values] if unit else [])
    for point in itertools.product(*axes):
        yield dict(zip(searches, point, strict=True))


def _scale(robot: Robot, scale: str, logs: Logs, position: int) -> tuple[float, float]:
    """Return the origin and the unit of a range; the unit is 0 if it is unknown."""
    slides = robot.movable[position].sigma == names.PRISMATIC
    if scale == "play":
        return 0.0, _PINION if slides else 1.0
    if scale == "angle":  # on the first joint, gravity of the link is no other torque
        return 0.0, float(position > 0 and not slides)
    if scale == "gear":
        ratio = 0.0 if robot.drive is None else abs(robot.drive.ratio[position][position])
        return 0.0, ratio if ratio > 1 else 0.0
    if scale == "speed":
        speeds = np.concatenate([s.qd[:, position] for s in logs])
        return 0.0, float(np.sqrt(np.mean(speeds**2))) or 1.0
    if scale == "duration":
        return 0.0, max(s.samples.length for s in logs)
    if scale in ("range", "place") or (scale == "turn" and slides):
        q = np.concatenate([s.q[s.kept, position] for s in logs])
        travel = float(np.ptp(q)) or 1.0
        if scale == "turn":  # periods over the travel of the slide
            return 0.0, 2 * np.pi / travel
        return float(q.min()) if scale == "place" else 0.0, travel
    return 0.0, 1.0


def _couplings(robot: Robot, definition: Definition) -> Iterator[Candidate]:
    """Yield drives that move two joints; parameter names take the number of the second joint."""
    known = [{c.first, c.second} for c in robot.couplings]
    for j, k in itertools.combinations(range(robot.n), 2):
        if {robot.movable[j].number, robot.movable[k].number} in known:
            continue
        for constants in constant_grid(robot, definition.nonlinear, (), j):
            if constants["ratio"]:
                yield Candidate(definition, (j, k), partial(_coupled, j, k), 3, constants)


def _coupled(j: int, k: int, s: FilteredLog, _: Torques, constants: Constants) -> Columns:
    """Return u = qd_j + ratio qd_k, F = IAM u' + FVM u + FSM sign(u) on j, ratio F on k."""
    ratio = constants["ratio"]
    u = s.qd[:, j] + ratio * s.qd[:, k]
    du = s.qdd[:, j] + ratio * s.qdd[:, k]
    F = np.column_stack([du, u, np.sign(u)])
    return {j: F, k: ratio * F}


def _crossed(j: int, k: int, _: FilteredLog, torques: Torques, __: Constants) -> Columns:
    """Return the torque of joint k in the channel of joint j."""
    return {j: torques.model[:, [k]]}


def _presliding(j: int, s: FilteredLog, _: Torques, constants: Constants) -> Columns:
    """Return Dahl's friction of 1 N m, dz/dq = (1 - z sign(qd))/xs.

    The joint slides at the start. The solution is exact between samples without a reversal.
    """
    way = np.diff(s.q[:, j])
    kept = np.exp(-np.abs(way) / constants["xs"])
    gained = (1 - kept) * np.sign(way)
    z = float(np.sign(way[0]))
    out = [z]
    for share, more in zip(kept.tolist(), gained.tolist(), strict=True):
        z = share * z + more
        out.append(z)
    return {j: np.array(out)[:, None]}
