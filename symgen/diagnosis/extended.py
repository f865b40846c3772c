"""The extended model: the robot with its adopted effects, derived and identified again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.diagnosis.diagnosis import Alike, FoundEffect, FoundParameter
from symgen.diagnosis.extend import extended
from symgen.errors import IdentificationError
from symgen.estimation.estimators import Wls
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import kept_spans
from symgen.estimation.solve import Solution
from symgen.estimation.system import Equations, LinearSystem, joint_equations
from symgen.estimation.values import FloatArray
from symgen.hypotheses.changes import Change
from symgen.hypotheses.confirm import Weighed, settled
from symgen.hypotheses.effects import Candidate, LogColumns, Score
from symgen.hypotheses.event import Contact
from symgen.hypotheses.problem import Problem, Stage, model_of
from symgen.hypotheses.refine import slopes
from symgen.hypotheses.registry import Changed, SearchResult
from symgen.hypotheses.rows import Rows, make_rows, with_rests
from symgen.identification.parameters import base_values
from symgen.robot.effect import numbered
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

_CORRELATION = 2  # number of correlated rows that count as one, at four rows a period


@dataclass(frozen=True, eq=False)
class Extended:
    """The model with the adopted effects, identified again.

    Attributes:
        problem: the declared model on the corrected logs.
        robot: the robot with the effects that a robot file can declare.
        evaluator: the compiled model of that robot.
        effects: the adopted effects with columns.
        declared: effects that the robot file declares.
        as_columns: effects that are columns added to the model.
        alone: coefficients of each effect, from one fit of all effects with the declared model.
        X, std: values and standard deviations. Both have the parameters of the robot, then the
            coefficients of `as_columns`. std also has the searched constants.
        covariance: covariance of the parameters of the robot.
    """

    problem: Problem
    robot: Robot
    evaluator: Evaluator
    effects: tuple[Score, ...]
    declared: tuple[Score, ...]
    as_columns: tuple[Score, ...]
    alone: tuple[tuple[FoundParameter, ...], ...]
    X: FloatArray
    std: FloatArray
    covariance: FloatArray

    @property
    def count(self) -> int:
        """Number of the robot's parameters in X."""
        return 0 if self.problem.is_fixed else len(self.evaluator.model.base.parameters)

    @property
    def of_robot(self) -> FloatArray:
        """(p,) parameters of the robot: fixed, or identified with the effects."""
        known = self.problem.known
        return self.X[: self.count] if known is None else known


def extend_model(result: SearchResult) -> Extended:
    """Declare the adopted effects that a robot file can hold, and identify the robot again.

    Raises:
        IdentificationError: the logs do not determine the extended model.
        RobotError: with its constants, the column of an effect depends on other columns.
    """
    problem = result.problem
    effects, log_columns = settled(problem, result.effects)
    robot, declared = problem.robot, []
    stage = problem.stage(effects)
    fitted = iter(stage.coefficients)
    for score in effects:
        c = score.candidate
        pairs = zip(_named(problem.robot, c), [*islice(fitted, c.size)], strict=False)
        values = {} if problem.is_fixed else {name: value for (name, _), value in pairs}
        more = extended(robot, c.definition, c.joints, c.constants, values)
        if more is not None:
            robot = more
            declared.append(score)
    evaluator, rows = problem.evaluator, problem.base
    if not problem.is_fixed and robot is not problem.robot:
        evaluator = model_of(robot)
        rows = make_rows(evaluator, rows.logs)
    # With fixed parameters, all effects are columns added to the model.
    as_columns = tuple(s for s in effects if problem.is_fixed or s not in declared)
    rows = rows.with_columns(log_columns(s.candidate) for s in as_columns)
    names = () if problem.is_fixed else evaluator.model.base.names
    names += _coefficient_names(as_columns)
    solution = _solve(problem, names, rows)
    std = _with_constants(stage, log_columns, names, rows, solution.std)
    alone = tuple(map(tuple, _alone(stage)))
    about = problem, robot, evaluator, effects, tuple(declared), as_columns, alone
    p = len(names) - sum(s.candidate.size for s in as_columns)
    return Extended(*about, solution.X, std, solution.covariance[:p, :p])


def _coefficient_names(effects: Sequence[Score]) -> tuple[str, ...]:
    return tuple(f"{s.candidate.name} {i}" for s in effects for i in range(s.candidate.size))


def _with_constants(
    stage: Stage, log_columns: LogColumns, names: tuple[str, ...], rows: Rows, std: FloatArray
) -> FloatArray:
    """Return standard deviations that include the uncertainty of the searched constants.

    The derivatives of the columns with respect to the constants are additional columns, as in
    linearised nonlinear least squares.
    """
    along = slopes(stage, log_columns)
    if not along:
        return std
    count = sum(next(iter(columns.values())).shape[1] for columns in along)
    constants = tuple(f"constant {i}" for i in range(count))
    try:
        return _solve(stage.problem, (*names, *constants), rows.with_columns(along)).std
    except IdentificationError:  # the logs do not determine the constants
        return np.concatenate([std, np.full(count, np.nan)])


def _alone(stage: Stage) -> Iterator[list[FoundParameter]]:
    """Yield the coefficients of each effect, from one fit of all effects with the declared model.

    The declared model may absorb a coefficient, for example the inertia of a drive that turns two
    parallel joints. The values are then those of the minimum-norm solution, and std is NaN.
    """
    problem, effects, rows = stage.problem, stage.effects, stage.rows
    if not effects:
        return
    names = () if problem.is_fixed else problem.evaluator.model.base.names
    try:
        solution = _solve(problem, (*names, *_coefficient_names(effects)), rows)
        X, std = solution.X, solution.std
    except IdentificationError:
        X, std = rows.X, np.full(len(rows.X), np.nan)
    numbers = zip(X[len(names) :], std[len(names) :], strict=True)
    for c in (s.candidate for s in effects):
        pairs = zip(_named(problem.robot, c), [*islice(numbers, c.size)], strict=False)
        yield [FoundParameter(n, float(x), float(s), u) for (n, u), (x, s) in pairs]


def _solve(problem: Problem, names: tuple[str, ...], rows: Rows) -> Solution:
    """Solve rows for parameters and standard deviations; empty if there are no parameters."""
    if not names:
        none = np.zeros((0, 0))
        return Solution(np.zeros(0), none, none, 1.0, ())
    known = features_of(rows.logs, problem.robot.sigma)
    rested = with_rests(rows)
    out: list[Equations] = []
    for log, at in zip(rows.logs, kept_spans(rows.logs), strict=True):
        W = rows.W[at].transpose(1, 0, 2)
        random = known.in_band(log.unmasked.modelled).transpose(1, 0, 2)
        free = rested.moves[at] > 0
        out += joint_equations(
            log, W, rows.y[at], log.compared_t, _CORRELATION, random, log.resting, free
        )
    return Wls().solve(LinearSystem(names, tuple(out)))


def list_effects(model: Extended, weighed: Sequence[Weighed]) -> tuple[FoundEffect, ...]:
    """Return the adopted and the suspected effects, with values and standard deviations.

    Args:
        model: the extended model.
        weighed: the grades of all hypotheses that the search accepted.
    """
    robot, p = model.problem.robot, model.count
    rows = zip(model.evaluator.model.base.parameters[:p], model.X, model.std, strict=False)
    known = {b.name: FoundParameter(b.name, float(x), float(s), b.unit) for b, x, s in rows}
    values = iter(zip(model.X[p:], model.std[p:], strict=False))
    constants = iter(model.std[len(model.X) :])
    by_key = {w.item.key: w for w in weighed}
    out = []
    for score, alone in zip(model.effects, model.alone, strict=True):
        c, d = score.candidate, score.candidate.definition
        if score in model.as_columns:
            pairs = zip(alone, list(islice(values, c.size)), strict=False)
            parameters = [replace(a, value=float(x), std=float(s)) for a, (x, s) in pairs]
        else:  # a native effect without a parameter is part of the geometry or the gravity
            parameters = [known.get(a.name, a) for a in alone if a.name in known or not d.native]
        searched = [
            FoundParameter(name, value, float(next(constants)) if c.smooth else math.nan, unit)
            for name, value, unit in _constants(robot, c)
        ]
        declared = score in model.declared
        w, numbers = by_key[score.key], (*parameters, *searched)
        out.append(_with_columns(robot, w, score, numbers, declared))
    for w in weighed:
        if not w.adopted and isinstance(w.item, Score):
            out.append(_with_columns(robot, w, w.item, (), False))
    undone = [_undone(robot, w, w.item.change) for w in weighed if isinstance(w.item, Changed)]
    contacts: dict[tuple[int, ...], list[Weighed]] = {}
    for w in weighed:
        if isinstance(w.item, Contact):
            contacts.setdefault(w.item.joints, []).append(w)
    touched = [_touched(robot, same) for same in contacts.values()]
    return (*undone, *touched, *out)


def _constants(robot: Robot, c: Candidate) -> Iterator[tuple[str, float, str]]:
    """Yield name, value and unit of the constants of an effect."""
    suffix, sigma = _place(robot, c)
    for name, value in c.constants.items():
        yield c.definition.named(name, suffix), float(value), c.definition.unit_of(name, sigma)


def _plain(robot: Robot, w: Weighed) -> FoundEffect:
    """Return a hypothesis as an effect, without its parameters."""
    from scipy.special import expit

    item = w.item
    return FoundEffect(
        name=item.definition.name,
        joints=joint_numbers(robot, item.joints),
        parameters=(),
        expression=item.definition.formula,
        p_value=math.exp(-max(item.odds, 0.0)),
        gap_reduction=min(item.gain, 1.0),
        probability=float(expit(item.odds)),
        torque_rms=item.torque,
        adopted=w.adopted,
        shown=w.shown,
        declared=False,
    )


def _with_columns(
    robot: Robot,
    w: Weighed,
    score: Score,
    parameters: tuple[FoundParameter, ...],
    declared: bool,
) -> FoundEffect:
    """Return an effect with columns, with its score and its parameters."""
    d = score.definition
    suffix, _ = _place(robot, score.candidate)
    alike = tuple(Alike(s.definition.name, joint_numbers(robot, s.joints)) for s in score.alike)
    return replace(
        _plain(robot, replace(w, item=score)),
        parameters=parameters,
        expression=numbered(d, suffix) or d.formula or d.says,
        p_value=_p_value(parameters),
        probability=score.probability,
        indistinguishable_from=alike,
        separate=d.separate if alike else "",
        declared=declared,
    )


def _undone(robot: Robot, w: Weighed, change: Change) -> FoundEffect:
    """Return a change of the logs as an effect."""
    plain = _plain(robot, w)
    suffix = plain.joints[-1] if plain.joints else ""
    constants = (
        FoundParameter(f"{name}{suffix}", value, change.std.get(name, math.nan), unit)
        for name, (value, unit) in change.constants.items()
    )
    where = change.channels or "robot file"
    expression = f"{plain.expression} ({where})"
    declared = change.gravity is not None
    return replace(plain, parameters=tuple(constants), expression=expression, declared=declared)


def _touched(robot: Robot, same: Sequence[Weighed]) -> FoundEffect:
    """Return contacts on the same joints as one effect, with the share of the largest contact."""
    plain = _plain(robot, max(same, key=lambda w: w.item.gain))
    spans = [w.item.span for w in same if isinstance(w.item, Contact)]
    times = []
    for k, span in enumerate(spans):
        suffix = f"{plain.joints[-1]}{f'_{k}' if k else ''}"
        times.append(FoundParameter(f"start{suffix}", span.start, math.nan, "s"))
        times.append(FoundParameter(f"length{suffix}", span.end - span.start, math.nan, "s"))
    where = ", ".join(span.log for span in spans)
    return replace(
        plain,
        parameters=tuple(times),
        expression=f"{plain.expression}, in {where}",
        adopted=any(w.adopted for w in same),
        shown=any(w.shown for w in same),
    )


def joint_numbers(robot: Robot, positions: Sequence[int]) -> tuple[int, ...]:
    """Return the joint numbers in the robot file of some positions."""
    return tuple(robot.movable[j].number for j in positions)


def _named(robot: Robot, candidate: Candidate) -> Sequence[tuple[str, str]]:
    """Return the name and the unit of each coefficient of an effect with a physical meaning."""
    return candidate.coefficients or candidate.definition.coefficients(*_place(robot, candidate))


def _place(robot: Robot, candidate: Candidate) -> tuple[int | str, int]:
    """Return the joint number in the parameter names of an effect, and sigma of its first joint."""
    joints = joint_numbers(robot, candidate.joints)
    return (joints[-1], robot.movable[candidate.joints[0]].sigma) if joints else ("", 0)


def _p_value(parameters: Sequence[FoundParameter]) -> float:
    """Return the p-value of the most significant coefficient, with Bonferroni's correction."""
    sure = [abs(p.value) / p.std for p in parameters if p.std > 0]
    return min(1.0, len(sure) * math.erfc(max(sure, default=0.0) / math.sqrt(2)))


def robot_parameters(model: Extended, effects: Sequence[FoundEffect]) -> tuple[FoundParameter, ...]:
    """Return the base parameters of the extended robot.

    Fixed parameters get the values that declared effects add, and no standard deviation.
    """
    extended_model, X, std = model.evaluator.model, model.X, model.std
    if model.problem.is_fixed:
        if model.robot is not model.problem.robot:
            extended_model = derive(model.robot, ())
        added = [p for e in effects if e.declared for p in e.parameters]
        X = _with_added(model.problem, extended_model, added)
        std = np.full(len(X), np.nan)
    rows = zip(extended_model.base.parameters, X, std, strict=False)
    return tuple(FoundParameter(p.name, float(x), float(s), p.unit) for p, x, s in rows)


def _with_added(
    problem: Problem, extended_model: Model, added: Sequence[FoundParameter]
) -> FloatArray:
    """Return the base parameters of an extended model: fixed values plus those of effects.

    Args:
        problem: the declared model with its fixed parameters.
        extended_model: the model with the effects declared.
        added: standard parameters of `extended_model` that effects change or add.
    """
    values = {p.name: 0.0 for p in extended_model.base.standard}
    for value, base in zip(problem.X, problem.evaluator.model.base.parameters, strict=True):
        values[base.head] = float(value)
    for p in added:
        # R is appended to the name of a load parameter with which others are regrouped.
        name = p.name if p.name in values else p.name.removesuffix("R")
        if name in values:
            values[name] += p.value
    return base_values(values, extended_model, "the extended model")
