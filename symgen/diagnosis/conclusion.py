"""The conclusion of a diagnosis: the extended model, its gap, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice, repeat
from typing import NamedTuple

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.mask import rms
from symgen.diagnosis.baseline import Baseline, model_of
from symgen.diagnosis.contacts import NAME as CONTACT
from symgen.diagnosis.contacts import Contact, contacts_in
from symgen.diagnosis.diagnosis import (
    NOISE,
    Alike,
    Curves,
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gap,
    Rejected,
)
from symgen.diagnosis.effects import Candidate, Score, Seen, leave_out, odds_together
from symgen.diagnosis.extend import extended
from symgen.diagnosis.measuring_chain import CHAIN
from symgen.diagnosis.messages import held_at_rest, noisy, on_joints, tie
from symgen.diagnosis.noise_of_positions import shown_by_instruments
from symgen.diagnosis.refine import settled_constants, slopes
from symgen.diagnosis.residual_patterns import places
from symgen.diagnosis.rests import beyond_friction
from symgen.diagnosis.search import Selection
from symgen.diagnosis.whitened_system import (
    SETTLING,
    WhitenedSystem,
    compared,
    estimated,
    fitted_system,
    model_torque,
    modelled,
    static,
    torque_at,
)
from symgen.errors import IdentificationError, RobotError
from symgen.estimation.estimators import solve
from symgen.estimation.floor import grown, noise_floor, quiet
from symgen.estimation.predictive_score import (
    PredictiveScore,
    dense,
    everywhere,
    motion_folds,
    repeats_motion,
)
from symgen.estimation.solve import Solution
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.torque_error import TorqueFit, percent, relative_error, squares
from symgen.estimation.values import FloatArray
from symgen.faults.fault import undo_faults
from symgen.identification.parameters import base_values
from symgen.policy import LEAST, SURE
from symgen.robot.effect import definitions, numbered
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

_REPEAT = (
    "these logs repeat one motion, which confirms no effect: record a log of another motion "
    "(symgen excite plans one) and pass it with --validation"
)
_SHOWN = 12
#: Verdicts that leave a part of the torque unexplained.
_MISSING = ("partly-explained", "unexplained")


def plain(baseline: Baseline, notes: tuple[str, ...], least: float = LEAST) -> Diagnosis:
    """Return the diagnosis of the declared model, without any effect."""
    return conclude(baseline, Selection(()), notes, least)


def confirmed(baseline: Baseline, selection: Selection, least: float) -> Selection:
    """Confirm effects on the validation data, and drop those that these data contradict.

    With the parameters fitted to the training logs, each effect has to lower the validation error
    of a joint by at least `least`, in the presence of the other effects. The effect with the
    smallest improvement is dropped first. An effect without torque on the validation data, such as
    a contact during the training log, cannot be contradicted by them and stays. Data that only
    repeat the motion of the training logs confirm nothing: then all effects stay, marked as
    suspected.

    Args:
        baseline: the declared model and its logs.
        selection: effects that the search found on the training logs.
        least: smallest torque that matters, as a part of the joint's torque.
    """
    from scipy.special import expit

    if not selection.accepted:
        return selection
    if repeats_motion(baseline.base.logs, baseline.held):
        most = float(expit(SURE))
        rest = (
            replace(s, confirmed=s.candidate.measured, probability=min(s.probability, most))
            for s in selection.accepted
        )
        return replace(selection, accepted=tuple(rest))
    errors = partial(_errors, baseline)
    kept, out = list(selection.accepted), selection
    torques = _torques(baseline, baseline.of_held, kept, baseline.beside(kept))
    there = [bool(np.any(x)) for x in torques]
    pairs = zip(kept, there, strict=True)
    asked = {s.candidate for s, x in pairs if x and not s.candidate.measured}
    while kept:
        whole = errors(kept)
        fell = {
            s: float(np.max(np.sqrt(np.maximum(errors(leave_out(kept, s)) - whole, 0.0))))
            for s in kept
            if s.candidate in asked
        }
        worst = min(fell, key=lambda s: fell[s], default=None)
        if worst is None or fell[worst] >= least:
            break
        fault = (
            "suspected, not confirmed: it lowers the torque error of a joint on the validation "
            f"data by {100 * fell[worst]:.3g} %, which is less than --least {100 * least:.3g}"
        )
        kept.remove(worst)
        out = _without(out, [worst], fault)
    return out


def _torques(
    baseline: Baseline, held: WhitenedSystem, effects: Sequence[Score], system: WhitenedSystem
) -> list[FloatArray]:
    """Return the columns (K, n, m) of effects on the validation data, in the model `system`."""
    X = baseline.parameters(system)
    along = [baseline.torques_along(log.thinned, X) for log in held.logs]
    seen = Seen(held.logs, along).each(s.candidate for s in effects)
    return [dense(columns, held.y.shape) for columns in seen]


def _left(baseline: Baseline, held: WhitenedSystem, effects: Sequence[Score]) -> FloatArray:
    """Return the error (K, n) of the validation torque, for a fit to the training data."""
    system = baseline.beside(effects)
    more = _torques(baseline, held, effects, system)
    return np.asarray(held.y - np.concatenate([held.W, *more], axis=2) @ system.X)


def _errors(baseline: Baseline, effects: Sequence[Score]) -> FloatArray:
    """Return the squared error (n,) of the validation torque in motion, as a part of its square."""
    held = baseline.of_held
    weight = held.moves**2
    left = np.sum(weight * _left(baseline, held, effects) ** 2, axis=0)
    return np.asarray(left / np.maximum(weight.sum(axis=0), 1.0) / held.size**2)


def _larger_there(
    baseline: Baseline, selection: Selection, least: float
) -> tuple[Score, FloatArray, FloatArray] | None:
    """Return the most probable effect that is too small to be named, but not in other motion.

    It is probable on the training logs, and lowers the validation error of a joint by at least
    `least`.

    Returns:
        The effect, and the validation errors (n,) of the joints without and with it; None if there
        is none, or if the validation data only repeat the motion of the training logs.
    """
    small = [s for s in selection.rejected if s.odds > 0 and s.worth < least]
    if not small or repeats_motion(baseline.base.logs, baseline.held):
        return None
    was = _errors(baseline, selection.accepted)
    tried = ((s, _errors(baseline, [*selection.accepted, s])) for s in small)
    larger = ((s, np.sqrt(was), np.sqrt(now)) for s, now in tried if max(was - now) >= least**2)
    return next(larger, None)


def _touched(
    baseline: Baseline, effects: Sequence[Score], least: float, misfit: float
) -> tuple[Contact, ...]:
    """Return the contacts in the validation data, beside a fit of the model to these data."""
    held = baseline.of_held
    columns = _torques(baseline, held, effects, baseline.beside(effects))
    held = held.with_columns(map(everywhere, columns))
    fold, size = motion_folds(held.logs), misfit * held.size
    if np.max(fold) < 0:  # too short for two folds: no motion predicts another
        return ()
    left = held.y - held.W @ held.X
    score = PredictiveScore(held.W, left, held.moves, held.sigma, fold, size)
    return tuple(contacts_in(score, held.logs, held.size, least))


def _shown(
    baseline: Baseline, selection: Selection
) -> tuple[Selection, frozenset[tuple[str, tuple[int, ...]]]]:
    """Remove the effects that noise of q explains: their evidence is that of the instruments.

    The least one goes first, because the others are then tested again.

    Returns:
        The selection, and names and joints of effects with biased coefficients.
    """
    from scipy.special import expit

    while True:
        every = selection.accepted
        told = list(zip(every, shown_by_instruments(baseline, every), strict=True))
        loss = [max(0.0, s.evidence - x.evidence) for s, x in told]
        left = [replace(s, odds=s.odds - lost) for s, lost in zip(every, loss, strict=True)]
        odds = [odds_together(s, left) for s in left]
        doubted = [o if lost else math.inf for o, lost in zip(odds, loss, strict=True)]
        if min(doubted, default=math.inf) > 0:
            kept = (
                replace(s, probability=min(s.probability, expit(o)))
                for s, o in zip(every, odds, strict=True)
            )
            biased = frozenset(s.candidate.key for s, x in told if x.biased)
            return replace(selection, accepted=tuple(kept)), biased
        lost, x = told[int(np.argmin(doubted))]
        fault = (
            "noise of the positions explains it: the even samples do not show it in the odd ones "
            f"(log-likelihood ratio {x.evidence:.2g})"
        )
        selection = _without(selection, [lost], fault)


def _probable(selection: Selection, kept: Sequence[Score]) -> Selection:
    """Return a selection without effects that only those explained that the data do not confirm."""
    known = {s.candidate.key for s in kept}
    lost = [s for s in selection.accepted if s.candidate.key not in known]
    fault = "it does not predict other motion better beside the confirmed effects"
    return replace(_without(selection, lost, fault), accepted=tuple(kept))


def conclude(
    baseline: Baseline,
    selection: Selection,
    notes: tuple[str, ...],
    least: float = LEAST,
    misfit: float | None = None,
    probable: Callable[[Sequence[Score]], list[Score]] | None = None,
) -> Diagnosis:
    """Add the effects, identify the model again, and measure the gap on the validation data.

    Effects that the validation data do not confirm are not added. If the logs do not determine the
    extended model, or if the gap grows, the weakest effect is left out and the model solved again.

    Args:
        baseline: the declared model and its logs.
        selection: effects that the search found.
        notes: changes that were made to the logs.
        least: smallest torque that matters, as a part of the joint's torque.
        misfit: smallest model error to expect, as a part of a joint's torque; None for the declared
            model: then the places of the gap are not searched.
        probable: gives those of some effects that are probable beside one another; None if all are.
    """
    declared = baseline
    contacts = selection.contacts or ()
    baseline = declared.without(c.fault for c in contacts)
    accepted, _ = _settled(baseline, selection.accepted)
    if selection.contacts is not None and misfit is not None:
        contacts += _touched(baseline, accepted, least, misfit)
    faults = tuple(c.fault for c in contacts)
    if faults:
        held = tuple(undo_faults(log, faults)[0] for log in declared.held)
        baseline = replace(baseline, held=held)
    selection = confirmed(baseline, replace(selection, accepted=accepted), least)
    selection, biased = _shown(baseline, selection)
    if probable is not None and len(selection.accepted) < len(accepted):
        selection = _probable(selection, probable(selection.accepted))
    suspected = [s for s in selection.accepted if not s.confirmed]
    torque = rms(np.concatenate([log.unmasked.measured for log in baseline.held]))
    share = torque / np.maximum(torque, baseline.base.size)
    while True:
        accepted, seen = _settled(baseline, [s for s in selection.accepted if s.confirmed])
        selection = replace(selection, accepted=accepted)
        try:
            model = _extended_model(baseline, accepted, seen)
        except (IdentificationError, RobotError) as error:
            if not accepted:  # this is the declared model
                raise
            fault = "it lowers the torque error, but the model with it cannot be identified"
            culprit = _culprit(baseline, accepted)
            selection = _without(selection, [culprit], f"{fault}: {error}")
            continue
        gaps = _gaps(baseline, model, declared)
        raised = _raising(accepted, gaps, share, least)
        if raised is None:
            break
        score, was, now = raised
        fault = (
            "accepted on the training logs, but it raises the torque error on the validation data "
            f"from {100 * was:.3g} to {100 * now:.3g} %"
        )
        selection = _without(selection, [score], fault)
    found = _found_effects(baseline, model)
    if suspected:
        notes = (*notes, _REPEAT)
        lone = _coefficients(baseline, (*accepted, *suspected))[len(accepted) :]
        found += tuple(
            _found(baseline.robot, s, own, False, repeat(math.nan))
            for s, own in zip(suspected, lone, strict=True)
        )
    pairs = zip(found, (*accepted, *suspected), strict=True)
    found = tuple(replace(e, note=NOISE) if s.candidate.key in biased else e for e, s in pairs)
    found = (*_pushed(declared.robot, contacts), *found)
    told, moving = gaps.all, gaps.moving
    if told.after != moving.after:
        told_was, told_now, told_floor = (percent(gap.total) for gap in moving[:3])
        notes = (
            *notes,
            f"the torque error of joints in motion is {told_was} before and {told_now} after "
            f"(noise floor: {told_floor}). It decides the verdict, because static friction can "
            "take any value between its limits",
        )
    nothing = quiet(moving.after.per_joint, moving.floor.per_joint, least)
    verdict = _verdict((*accepted, *contacts), nothing)
    if suspected and verdict != "bad-measurement":
        verdict = "partly-explained"
    robot = baseline.robot
    stuck = [
        j.number
        for j, x in zip(robot.movable, gaps.held, strict=True)
        if not quiet([x], [0.0], least)
    ]
    holding = (held_at_rest(stuck, robot),) if stuck else ()
    asked = misfit is not None and verdict in _MISSING and not nothing
    larger = _larger_there(baseline, selection, least) if asked else None
    return Diagnosis(
        robot=robot.name,
        verdict=verdict,
        cutoff_hz=min((s.rows.cutoff for s in baseline.held if s.rows.cutoff), default=None),
        before=told.before,
        after=told.after,
        floor=told.floor,
        where=()
        if misfit is None or verdict == "consistent"
        else places(declared, accepted, contacts, moving.before, moving.floor, least),
        effects=found,
        rejected=tuple(
            Rejected(s.candidate.name, numbers(robot, s.candidate), s.fault)
            for s in selection.rejected[:_SHOWN]
        ),
        advice=(
            *holding,
            *(fault.fault for fault in faults),
            *_advice(found, robot, verdict, moving.after, nothing, larger),
        ),
        notes=notes,
        extended=model.robot,
        joints=tuple(j.number for j in robot.movable),
        curves=gaps.curves,
        tried=selection.tried,
        parameters=_parameters(baseline, model, found),
        declared=robot,
        values=tuple(map(float, baseline.X)),
        moving=moving,
        contacts=faults,
    )


@dataclass(frozen=True, eq=False)
class _Extended:
    """The model with the effects that were found, identified again.

    Attributes:
        robot: the robot with the effects that a robot file can declare.
        evaluator: the compiled model of that robot.
        names: names of its base parameters.
        accepted: the effects.
        alone: coefficients of each effect, fitted together beside the declared model.
        declared: the effects that the robot file declares.
        corrected: the other effects, whose columns stand beside the model.
        X: parameters of the robot, followed by the coefficients of the corrected effects.
        std: standard deviations of X, followed by those of the searched constants.
    """

    robot: Robot
    evaluator: Evaluator
    names: tuple[str, ...]
    accepted: Sequence[Score]
    alone: Sequence[Sequence[FoundParameter]]
    declared: Sequence[Score]
    corrected: Sequence[Score]
    X: FloatArray
    std: FloatArray


def _extended_model(baseline: Baseline, accepted: Sequence[Score], seen: Seen) -> _Extended:
    """Declare the effects that a robot file can hold, derive the robot, and identify it again.

    Raises:
        IdentificationError: the logs do not determine the extended model.
        RobotError: with its constants, the column of an effect depends on the others.
    """
    fitted = iter(baseline.coefficients(baseline.beside(accepted)))
    robot, declared = baseline.robot, []
    for score in accepted:
        c = score.candidate
        told, own = _told(baseline.robot, c), [*islice(fitted, c.size)]
        values = {} if baseline.given else dict(zip((n for n, _ in told), own, strict=False))
        more = extended(robot, c.definition, c.joints, c.constants, values)
        if more is not None:
            robot = more
            declared.append(score)
    alone = _coefficients(baseline, accepted)
    evaluator, system = baseline.evaluator, baseline.base
    if not baseline.given and robot is not baseline.robot:
        evaluator = model_of(robot)
        system = fitted_system(evaluator, system.logs)
    # With given parameters, the columns of all effects stand beside the model.
    corrected = [s for s in accepted if baseline.given or s not in declared]
    names = () if baseline.given else evaluator.model.base.names
    system = system.with_columns(seen(s.candidate) for s in corrected)
    extra = [f"{s.candidate.name} {i}" for s in corrected for i in range(s.candidate.size)]
    solution = _solved((*names, *extra), system, baseline.features)
    std = solution.std
    along = slopes(accepted, baseline.coefficients(baseline.beside(accepted)), seen)
    if along:
        # The uncertainty of a coefficient includes that of the constants: the slopes of the
        # columns along the constants enter the covariance (linearised model of nonlinear least
        # squares).
        count = sum(next(iter(columns.values())).shape[1] for columns in along)
        constants = [f"constant {i}" for i in range(count)]
        try:
            bent = system.with_columns(along)
            std = _solved((*names, *extra, *constants), bent, baseline.features).std
        except IdentificationError:  # the logs do not determine the constants
            std = np.concatenate([std, np.full(count, np.nan)])
    return _Extended(robot, evaluator, names, accepted, alone, declared, corrected, solution.X, std)


def _settled(baseline: Baseline, accepted: Sequence[Score]) -> tuple[tuple[Score, ...], Seen]:
    """Iterate the columns that depend on the model's torque, then the constants of all effects.

    Returns:
        The effects, and what gives columns beside them.
    """
    for _ in range(SETTLING if any(s.candidate.uses_model for s in accepted) else 0):
        seen = baseline.seen(baseline.beside(accepted))
        accepted = [
            replace(s, columns=seen(s.candidate)) if s.candidate.uses_model else s for s in accepted
        ]
    seen = baseline.seen(baseline.beside(accepted))
    return tuple(settled_constants(baseline, accepted, seen)), seen


def _coefficients(baseline: Baseline, accepted: Sequence[Score]) -> list[list[FoundParameter]]:
    """Return the coefficients of each effect, fitted together beside the declared model.

    A coefficient that the declared model can absorb has no std of its own, for example the inertia
    of a drive that turns two parallel joints. Its value is then that of the minimum-norm solution.
    """
    if not accepted:
        return []
    names = () if baseline.given else baseline.evaluator.model.base.names
    extra = [f"{s.candidate.name} {i}" for s in accepted for i in range(s.candidate.size)]
    system = baseline.beside(accepted)
    try:
        solution = _solved((*names, *extra), system, baseline.features)
        X, std = solution.X, solution.std
    except IdentificationError:
        X = estimated(system).X
        std = np.full(len(X), np.nan)
    rows = zip(X[len(names) :], std[len(names) :], strict=True)
    out = []
    for c in (s.candidate for s in accepted):
        pairs = zip(_told(baseline.robot, c), [*islice(rows, c.size)], strict=False)
        out.append([FoundParameter(n, float(x), float(s), u) for (n, u), (x, s) in pairs])
    return out


def _told(robot: Robot, candidate: Candidate) -> Sequence[tuple[str, str]]:
    """Return name and unit of the coefficients of an effect that have a physical meaning."""
    return candidate.coefficients or candidate.definition.coefficients(*_place(robot, candidate))


def _p_value(parameters: Sequence[FoundParameter]) -> float:
    """Return the p-value of the most significant coefficient, corrected for their number."""
    sure = [abs(p.value) / p.std for p in parameters if p.std > 0]
    return min(1.0, len(sure) * math.erfc(max(sure, default=0.0) / math.sqrt(2)))


def _found_effects(baseline: Baseline, model: _Extended) -> tuple[FoundEffect, ...]:
    """Return the effects with their coefficients, constants and standard deviations."""
    robot, p = baseline.robot, len(model.names)
    rows = zip(model.evaluator.model.base.parameters[:p], model.X, model.std, strict=False)
    known = {own.name: FoundParameter(own.name, float(x), float(s), own.unit) for own, x, s in rows}
    beside = iter(zip(model.X[p:], model.std[p:], strict=False))
    constants = iter(model.std[len(model.X) :])
    out = []
    for score, own in zip(model.accepted, model.alone, strict=True):
        c, d = score.candidate, score.candidate.definition
        if score in model.corrected:
            pairs = zip(own, list(islice(beside, c.size)), strict=False)
            parameters = [replace(p, value=float(x), std=float(s)) for p, (x, s) in pairs]
        else:  # built-in effects without a parameter belong to the extended geometry or gravity
            parameters = [known.get(p.name, p) for p in own if p.name in known or not d.native]
        declared = score in model.declared
        out.append(_found(robot, score, parameters, declared, constants))
    return tuple(out)


def _found(
    robot: Robot,
    score: Score,
    coefficients: Sequence[FoundParameter],
    declared: bool,
    std: Iterator[float],
) -> FoundEffect:
    """Return an effect with its numbers; `std` gives that of its refined constants."""
    c, d = score.candidate, score.candidate.definition
    suffix, sigma = _place(robot, c)
    alike = tuple(Alike(s.candidate.name, numbers(robot, s.candidate)) for s in score.alike)
    constants = (
        FoundParameter(
            d.named(name, suffix),
            float(value),
            float(next(std)) if c.smooth else math.nan,
            d.unit_of(name, sigma),
        )
        for name, value in c.constants.items()
    )
    return FoundEffect(
        name=c.name,
        joints=numbers(robot, c),
        parameters=(*coefficients, *constants),
        expression=numbered(d, suffix) or d.formula or d.says,
        p_value=_p_value(coefficients),
        gap_reduction=min(score.gain, 1.0),
        probability=score.probability,
        torque_rms=score.torque,
        confirmed=score.confirmed,
        indistinguishable_from=alike,
        separate=d.separate if alike else "",
        declared=declared,
    )


def _pushed(robot: Robot, contacts: Sequence[Contact]) -> Iterator[FoundEffect]:
    """Yield one effect for the contacts of the same joints, which no other motion can confirm."""
    by_joints: dict[tuple[int, ...], list[Contact]] = {}
    for c in contacts:
        by_joints.setdefault(c.event.joints, []).append(c)
    for at, same in by_joints.items():
        joints = tuple(robot.movable[j].number for j in at)
        times = (
            FoundParameter(f"{name}{joints[-1]}{f'_{k}' if k else ''}", x, std, "s")
            for k, c in enumerate(same)
            for name, x, std in c.fault.values
        )
        odds = max(c.odds for c in same)
        where = ", ".join(c.fault.log for c in same)
        yield FoundEffect(
            name=CONTACT,
            joints=joints,
            parameters=tuple(times),
            expression=f"{definitions()[CONTACT].formula}, in {where}",
            p_value=math.exp(-max(odds, 0.0)),
            gap_reduction=min(max(c.gain for c in same), 1.0),
            probability=max(c.probability for c in same),
            torque_rms=max(c.torque for c in same),
            declared=False,
        )


def numbers(robot: Robot, candidate: Candidate) -> tuple[int, ...]:
    """Return the joint numbers, as in the robot file, that an effect acts on."""
    return tuple(robot.movable[j].number for j in candidate.joints)


def _place(robot: Robot, candidate: Candidate) -> tuple[int | str, int]:
    """Return the joint number that ends the names of an effect, and the type of its first joint."""
    joints = numbers(robot, candidate)
    return (joints[-1], robot.movable[candidate.joints[0]].sigma) if joints else ("", 0)


def _parameters(
    baseline: Baseline, model: _Extended, found: Sequence[FoundEffect]
) -> tuple[FoundParameter, ...]:
    """Return the base parameters of the extended robot; given values plus what effects add."""
    whole, X, std = model.evaluator.model, model.X, model.std
    if baseline.given:
        if model.robot is not baseline.robot:
            whole = derive(model.robot, ())
        added = [p for e in found if e.declared for p in e.parameters]
        X = _changed(baseline, whole, added)
        std = np.full(len(X), np.nan)
    rows = zip(whole.base.parameters, X, std, strict=False)
    return tuple(FoundParameter(p.name, float(x), float(s), p.unit) for p, x, s in rows)


def _changed(baseline: Baseline, whole: Model, added: Sequence[FoundParameter]) -> FloatArray:
    """Return the base parameters of an extended model: given values plus what effects add.

    Args:
        baseline: the declared model with the given parameters.
        whole: the model with the effects declared.
        added: standard parameters of `whole` that effects change or add.
    """
    values = {p.name: 0.0 for p in whole.base.standard}
    for value, given in zip(baseline.X, baseline.evaluator.model.base.parameters, strict=True):
        values[given.head] = float(value)
    for p in added:
        # A parameter of the load that regroups others has R appended.
        name = p.name if p.name in values else p.name.removesuffix("R")
        if name in values:
            values[name] += p.value
    return base_values(values, whole, "the extended model")


class _Judged(NamedTuple):
    """The gap before and after, and the noise floor."""

    before: Gap
    after: Gap
    floor: Gap


class _Gaps(NamedTuple):
    """Gaps on the validation data: over all samples, and without static friction at rest.

    Torque at rest beyond the limits of static friction counts in both. `held` is that part of each
    joint's torque.
    """

    all: _Judged
    moving: _Judged
    curves: tuple[Curves, ...]
    held: FloatArray


def _gaps(baseline: Baseline, model: _Extended, recorded: Baseline) -> _Gaps:
    """Measure the gap of the declared and of the extended model on the validation data.

    Args:
        baseline: the declared model on the logs without contacts.
        model: the extended model.
        recorded: the declared model on the logs with them.
    """
    declared, p = baseline.evaluator, len(model.names)
    X = model.X[:p]
    if baseline.given or not model.accepted:  # X and the weights of the joints stay
        X = baseline.X
    # The torque that enters the columns of the effects.
    inside = baseline.parameters(baseline.beside(model.accepted))
    n, instants = baseline.robot.n, sum(len(log.kept) for log in baseline.held)
    was = now = TorqueFit.none(n)
    curves, variance = list[Curves](), np.zeros(n)
    count, moved, beyond = np.zeros(n), np.zeros(n), np.zeros((2, n))
    declared_torque = partial(torque_at, declared, recorded.X)
    for log, whole_log in zip(baseline.held, recorded.held, strict=True):
        torques = baseline.torques_along(log, X, model.evaluator, inside)
        whole, at = torques.model, p
        for c in (s.candidate for s in model.corrected):
            columns = dense(c.columns(log, torques), log.tau.shape)
            whole = whole + columns @ model.X[at : at + c.size]
            at += c.size
        before = after = modelled(log, declared_torque)
        if model.accepted or X is not recorded.X:
            after = before + compared(log, whole - model_torque(declared, recorded.X, log))
        measured, free = log.unmasked.measured, log.clear[log.kept]
        held = static(log)
        was += squares(whole_log.clear[log.kept], measured, before, held)
        now += squares(free, measured, after, held)
        motion = (log.t[log.kept], log.q[log.kept], log.qd[log.kept])
        mask = None if log.mask is None else free
        curves.append(Curves(log.name, *motion, measured, before, after, mask))
        after_torque = partial(model_torque, model.evaluator, X)
        noise = noise_floor(log, log.tau - whole, after_torque, free & ~held)
        extended_torque = partial(torque_at, model.evaluator, X)
        beyond[0] += beyond_friction(log, measured - before, declared_torque)
        beyond[1] += beyond_friction(log, measured - after, extended_torque)
        count, moved = count + free.sum(axis=0), moved + (free & ~held).sum(axis=0)
        share = len(free) / instants
        variance = variance + share * noise**2
    told = _judged(was, now, variance * np.maximum(count, 1))
    fits = [
        replace(x.in_motion, error=x.in_motion.error + more)
        for x, more in zip((was, now), beyond, strict=True)
    ]
    moving = _judged(fits[0], fits[1], variance * np.maximum(moved, 1))
    held = np.sqrt(beyond[1] / np.maximum(fits[1].size, 1e-300))
    return _Gaps(told, moving, tuple(curves), held)


def _raising(
    accepted: Sequence[Score], gaps: _Gaps, share: FloatArray, least: float
) -> tuple[Score, float, float] | None:
    """Return the weakest effect that does not improve the prediction of unseen data, and the gaps.

    The gap of a joint on which effects act may not grow, nor that of all joints.

    Args:
        accepted: the effects.
        gaps: gaps of the validation data.
        share: (n,) torque of the joints in these data over the largest torque in any data.
        least: smallest torque that matters, as a part of the joint's torque.
    """
    moving = gaps.moving
    for before, after, _ in (gaps.all, moving):
        if accepted and after.total > before.total:
            return accepted[-1], before.total, after.total
    was, now, noise = ([*(share * gap.per_joint)] for gap in moving)
    raised = grown(was, now, noise, least)
    for score in reversed(accepted):
        for j in score.candidate.joints:
            if raised[j]:
                return score, before.per_joint[j], after.per_joint[j]
    return None


def _judged(was: TorqueFit, now: TorqueFit, noise: FloatArray) -> _Judged:
    """Return the gaps and the noise floor of sums of squares; `noise` has shape (n,).

    The noise above the band is not always white. The floor is at most the remaining error.
    """
    noise = np.minimum(noise, np.minimum(was.error, now.error))
    found = (relative_error(error, was.size) for error in (was.error, now.error, noise))
    return _Judged(*(Gap(x.per_joint or (), x.relative) for x in found))


def _without(selection: Selection, scores: Sequence[Score], fault: str) -> Selection:
    """Return a selection without some effects, which are listed as rejected with the reason."""
    accepted = tuple(s for s in selection.accepted if s not in scores)
    failed = (replace(s, fault=fault) for s in scores)
    return replace(selection, accepted=accepted, rejected=(*failed, *selection.rejected))


def _culprit(baseline: Baseline, accepted: Sequence[Score]) -> Score:
    """Return the weakest of the effects that the logs cannot distinguish from the model."""
    whole = baseline.beside(accepted).rank
    tied = [
        s
        for s in accepted
        if baseline.beside(o for o in accepted if o is not s).rank + s.candidate.size > whole
    ]
    return (tied or accepted)[-1]


def _solved(
    names: tuple[str, ...], system: WhitenedSystem, features: Sequence[FloatArray]
) -> Solution:
    """Solve the final model; the solution is empty if no parameter is unknown."""
    if not names:
        none = np.zeros((0, 0))
        return Solution(np.zeros(0), none, none, 1.0, ())
    out, first, weights = [], 0, estimated(system).moves
    for log, known in zip(system.logs, features, strict=True):
        t = log.t[log.kept]
        for j in range(system.n):
            weight = weights[first : first + len(t), j]
            at = np.flatnonzero(weight)
            rows, weight = first + at, weight[at]
            W, y = weight[:, None] * system.W[rows, j], weight * system.y[rows, j]
            own = weight[:, None] * known[at, j]
            out.append(Equations(log.name, W, y, t[at], 2, j, features=own))
        first += len(t)
    return solve(LinearSystem(names, tuple(out)), "wls")


def _verdict(accepted: Sequence[Score | Contact], quiet: bool) -> str:
    largest = max(accepted, key=lambda s: s.worth, default=None)
    if isinstance(largest, Score) and largest.candidate.name in CHAIN:
        return "bad-measurement"
    if not accepted:
        return "consistent" if quiet else "unexplained"
    return "explained" if quiet else "partly-explained"


def _advice(
    found: Sequence[FoundEffect],
    robot: Robot,
    verdict: str,
    after: Gap,
    quiet: bool,
    larger: tuple[Score, FloatArray, FloatArray] | None,
) -> tuple[str, ...]:
    out = [noisy(e, robot) for e in found if e.note]
    out += [tie(e, robot) for e in found if e.indistinguishable_from and e.separate]
    if verdict not in _MISSING:
        return tuple(out)
    if quiet:
        return (*out, "the remaining torque error is noise and static friction at rest")
    if larger is not None:
        own, was, now = larger
        j = int(np.argmax(was**2 - now**2))
        where = on_joints(numbers(robot, own.candidate), robot)
        return (
            *out,
            f"{own.candidate.name} on {where} is probable, but too small on the training logs to "
            f"be named ({100 * own.worth:.2g} % of the torque). It is larger on the validation "
            f"data: there it reduces the torque error of {robot.label(robot.movable[j].number)} "
            f"from {percent(was[j])} to {percent(now[j])}. Train on logs with both motions",
        )
    return (
        *out,
        f"no known effect explains the remaining torque error of {percent(after.total)} in motion: "
        "the plots of the residual in report.html show what it depends on",
    )
