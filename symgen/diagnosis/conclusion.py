"""What a diagnosis concludes from what was found: the extended model, its gap, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import derive
from symgen.diagnosis.baseline import KERNELS, Study, torques_of
from symgen.diagnosis.diagnosis import (
    Curves,
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gap,
    Rejected,
)
from symgen.diagnosis.evidence import (
    Evidence,
    evidence,
    model_torque,
    ratio,
    torque_at,
)
from symgen.diagnosis.extend import extended, with_values
from symgen.diagnosis.floor import at_rest, noise_floor
from symgen.diagnosis.found import coefficients, found_effects, numbers
from symgen.diagnosis.given_parameters import changed, link_values
from symgen.diagnosis.messages import tie
from symgen.diagnosis.refine import all_slopes, settled_constants
from symgen.diagnosis.residual_patterns import places
from symgen.diagnosis.search import MEASURING, Selection
from symgen.diagnosis.select import Score
from symgen.diagnosis.shapes import Torques
from symgen.errors import IdentificationError, RobotError
from symgen.estimation.estimators import solve
from symgen.estimation.solve import Solution
from symgen.estimation.system import Equations, LinearSystem
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
#: Gap over noise floor up to which nothing is missing, where no effect is found.
_QUIET, _LOUD = 3.0, 5.0  # in all, on one joint
_SMALL = 0.01  # a gap that no model of friction comes below
_EXPLAINED = 0.15  # the largest gap that is called explained
_SHOWN = 12
_SETTLING = 4


def plain(study: Study, notes: tuple[str, ...]) -> Diagnosis:
    """Return what the model says as it is declared."""
    return conclude(study, Selection(study.base, (), (), (), 0), notes)


def conclude(study: Study, selection: Selection, notes: tuple[str, ...]) -> Diagnosis:
    """Add what was found, identify again, and measure the gap on the held-out data."""
    settled = _settled(study, selection.accepted)
    torques = study.torques(study.beside(settled))
    settled = settled_constants(study.base, settled, lambda c: c.seen(study.base, torques))
    selection = replace(selection, accepted=tuple(settled))
    beside = coefficients(study, settled)
    try:
        m = _extended_model(study, settled, beside, torques)
    except (IdentificationError, RobotError) as error:
        if not settled:  # it is the model as it is declared
            raise
        return conclude(study, _without(selection, _culprit(study, settled), str(error)), notes)
    robot, evaluator, names_, solution = m.robot, m.evaluator, m.names_, m.solution
    before, after, floor, curves = _gaps(study, evaluator, selection, m.corrected, solution)
    if selection.accepted and after.total > before.total:
        return conclude(study, _withdrawn(selection, before, after), notes)
    found = found_effects(
        study, selection, beside, m.corrected, m.declared, names_, solution.X, m.std, evaluator
    )
    measuring = [s for s in selection.accepted if s.candidate.name in MEASURING]
    verdict = _verdict(selection, measuring, before, after, floor)
    X, std, model = solution.X, m.std, evaluator.model
    if study.given:
        model = model if robot is study.robot else derive(robot, ())
        added = [p for e in found if e.declared for p in e.parameters]
        X = changed(study.evaluator.model, study.X, model, added)
        names_, std = model.base.names, np.full(len(X), np.nan)
    units = [p.unit for p in model.base.parameters]
    robot = with_values(robot, found)
    return Diagnosis(
        robot=study.robot.name,
        verdict=verdict,
        cutoff_hz=min((s.band for s in study.held if s.band), default=None),
        before=before,
        after=after,
        floor=floor,
        where=()
        if verdict == "consistent"
        else places(study.robot, study.base, study.torques(study.base), selection, before, floor),
        effects=found,
        rejected=tuple(
            Rejected(s.candidate.name, numbers(study.robot, s.candidate), s.fault)
            for s in selection.rejected[:_SHOWN]
        ),
        advice=_advice(found, verdict, _quiet(after, floor)),
        notes=notes,
        extended=robot,
        joints=tuple(j.number for j in study.robot.movable),
        curves=curves,
        tried=selection.tried,
        parameters=tuple(
            FoundParameter(name, float(x), float(s), u)
            for name, x, s, u in zip(names_, X, std, units, strict=False)
        ),
        declared=study.robot,
        values=tuple(map(float, study.X)),
    )


@dataclass(frozen=True, eq=False)
class _Model:
    """The model with the effects that were found, identified again.

    Attributes:
        robot: with the effects that a robot file declares.
        evaluator: of that robot.
        names_: of its base parameters.
        declared: the effects that it declares.
        corrected: the others, whose columns stand beside the model.
        solution: parameters of the robot, then coefficients of the others.
        std: the same, then those of smooth constants.
    """

    robot: Robot
    evaluator: Evaluator
    names_: tuple[str, ...]
    declared: Sequence[Score]
    corrected: Sequence[Score]
    solution: Solution
    std: FloatArray


def _extended_model(
    study: Study,
    settled: Sequence[Score],
    beside: Sequence[Sequence[FoundParameter]],
    torques: Sequence[Torques],
) -> _Model:
    """Declare what a robot file can declare, derive that robot, and identify it again.

    Raises:
        IdentificationError: the logs do not determine it.
        RobotError: an effect says nothing new with its constants.
    """
    robot, names_ = study.robot, study.evaluator.model.base.names
    declared: list[Score] = []
    for score, own in zip(settled, beside, strict=True):
        c = score.candidate
        values = {p.name: p.value for p in own} if not study.given else {}
        more = extended(robot, c.definition, c.joints, c.constants, values)
        if more is not None:
            robot = more
            declared.append(score)
    corrected = [s for s in settled if s not in declared]
    evaluator, final = study.evaluator, study.base
    if study.given:  # the effects' columns stand beside what is given
        corrected, names_ = list(settled), ()
    elif robot is not study.robot:
        evaluator = load(derive(robot, KERNELS))
        names_ = evaluator.model.base.names
        final = evidence(evaluator, study.base.scenes)
    extra = [f"{s.candidate.name} {i}" for s in corrected for i in range(s.candidate.size)]
    if corrected:
        final = final.with_columns(s.candidate.seen(study.base, torques) for s in corrected)
    solution = _solved((*names_, *extra), final)
    std = _std(study, settled, torques, (*names_, *extra), final, solution)
    return _Model(robot, evaluator, names_, declared, corrected, solution, std)


def _settled(study: Study, accepted: Sequence[Score]) -> Sequence[Score]:
    """Return the effects with the model's torque in their columns as it is beside them all."""
    for _ in range(_SETTLING if any(s.candidate.uses_model for s in accepted) else 0):
        torques = study.torques(study.beside(accepted))
        accepted = [
            replace(s, columns=s.candidate.seen(study.base, torques))
            if s.candidate.uses_model
            else s
            for s in accepted
        ]
    return accepted


def _gaps(
    study: Study,
    evaluator: Evaluator,
    selection: Selection,
    corrected: Sequence[Score],
    solution: Solution,
) -> tuple[Gap, Gap, Gap, tuple[Curves, ...]]:
    """Return gap before, after, noise floor, and the curves, on the held-out data."""
    p = len(solution.X) - sum(s.candidate.size for s in corrected)
    X = study.X if study.given else solution.X[:p]
    if not selection.accepted:  # nothing changes, not even the weights of the joints
        X = study.X
    # What stands in the effects' columns.
    inside = study.parameters(study.beside(selection.accepted))
    curves, noise, span, free = [], [], [], []
    for s in study.held:
        declared = model_torque(study.evaluator, study.X, s)
        torques = torques_of(evaluator, X, s, link_values(study.evaluator.model, inside))
        whole, at = torques.model.copy(), p
        for score in corrected:
            columns = score.candidate.columns(s, torques)
            for j, c in columns.items():
                whole[:, j] += c @ solution.X[at : at + score.candidate.size]
            at += score.candidate.size
        before = s.modelled(partial(torque_at, study.evaluator, study.X))
        differs = bool(selection.accepted)
        seen = Curves(
            s.name,
            s.t[s.kept],
            s.q[s.kept],
            s.qd[s.kept],
            s.measured,
            before,
            before + s.seen(whole - declared) if differs else before,
            None if s.mask is None else s.free[s.kept],
        )
        curves.append(seen)
        others = (*study.base.scenes, *study.held)
        noise.append(noise_floor(s, s.tau - whole, partial(model_torque, evaluator, X), others))
        held_still = at_rest(s, seen.measured - seen.after, partial(torque_at, evaluator, X))
        noise[-1] = np.hypot(noise[-1], held_still)
        span.append(len(seen.t))
        free.append(s.free[s.kept])
    say = np.concatenate(free)
    measured = say * np.concatenate([c.measured for c in curves])

    def gap(model: FloatArray) -> Gap:
        return Gap(tuple(map(float, ratio(measured - say * model, measured))))

    size = np.sqrt(np.sum(measured**2, axis=0) / np.maximum(say.sum(axis=0), 1))
    variance = np.average(np.square(noise), axis=0, weights=span)
    was = gap(np.concatenate([c.before for c in curves]))
    now = gap(np.concatenate([c.after for c in curves]))
    floor = np.sqrt(variance) / np.where(size > 0, size, np.inf)
    # Noise above the band is not always white: in the band there is no more than what is left.
    floor = np.minimum(floor, np.minimum(was.per_joint, now.per_joint))
    return was, now, Gap(tuple(map(float, floor))), tuple(curves)


def _std(
    study: Study,
    settled: Sequence[Score],
    torques: Sequence[Torques],
    names_: tuple[str, ...],
    final: Evidence,
    solution: Solution,
) -> FloatArray:
    """Return the standard deviations of coefficients, then those of smooth constants.

    What a coefficient is worth depends on the constants beside it: the slopes of the columns
    along them stand in the covariance (the linearised model of nonlinear least squares).
    """
    std = _deviations(solution)
    values = study.beside(settled).X[study.base.W.shape[2] :]
    loose = all_slopes(settled, values, lambda c: c.seen(study.base, torques))
    known = [columns for columns in loose if columns is not None]
    if known:
        count = sum(next(iter(columns.values())).shape[1] for columns in known)
        more = tuple(f"constant {i}" for i in range(count))
        try:
            return _deviations(_solved((*names_, *more), final.with_columns(known)))
        except IdentificationError:  # the logs do not determine the constants
            return np.concatenate([std, np.full(count, np.nan)])
    return std


def _deviations(solution: Solution) -> FloatArray:
    return np.asarray(np.sqrt(np.maximum(np.diag(solution.covariance), 0)))


def _withdrawn(selection: Selection, before: Gap, after: Gap) -> Selection:
    """Return a selection without effects: what made the gap on data that it never saw larger."""
    fault = (
        "accepted on the training log, but with what was accepted the gap on the validation data "
        f"grows from {100 * before.total:.2g} to {100 * after.total:.2g} %"
    )
    failed = tuple(replace(s, fault=fault) for s in selection.accepted)
    return replace(selection, accepted=(), alike=(), rejected=(*failed, *selection.rejected))


def _culprit(study: Study, settled: Sequence[Score]) -> Score:
    """Return the least of the effects that the logs do not tell from the rest of the model."""
    whole = study.beside(settled).rank
    tied = [
        s
        for s in settled
        if study.beside([other for other in settled if other is not s]).rank + s.candidate.size
        > whole
    ]
    return (tied or settled)[-1]


def _without(selection: Selection, score: Score, why: str) -> Selection:
    """Return a selection without an effect with which the model cannot be identified."""
    fault = f"it explains a part of the gap, but the model with it cannot be identified: {why}"
    at = selection.accepted.index(score)
    return replace(
        selection,
        accepted=selection.accepted[:at] + selection.accepted[at + 1 :],
        alike=selection.alike[:at] + selection.alike[at + 1 :],
        rejected=(replace(score, fault=fault), *selection.rejected),
    )


def _system(names_: tuple[str, ...], final: Evidence) -> LinearSystem:
    """Return the equations of the final model, log by log and joint by joint."""
    out, first = [], 0
    for s in final.scenes:
        t = s.t[s.kept]
        rows = slice(first, first + len(t))
        for j in range(final.n):
            moves = final.moves[rows, j] > 0
            weight = final.moves[rows, j][moves]
            W, y = weight[:, None] * final.W[rows, j][moves], weight * final.y[rows, j][moves]
            out.append(Equations(s.name, W, y, t[moves], 2, j))
        first += len(t)
    return LinearSystem(names_, tuple(out))


def _solved(names_: tuple[str, ...], final: Evidence) -> Solution:
    """Solve the final model; nothing is identified where all is given and nothing was found."""
    if names_:
        return solve(_system(names_, final), "wls")
    return Solution(np.zeros(0), np.zeros((0, 0)), 1.0, ())


def _verdict(
    selection: Selection, measuring: Sequence[Score], before: Gap, after: Gap, floor: Gap
) -> str:
    if measuring:
        return "bad-measurement"
    if not selection.accepted:
        quiet = _quiet(before, floor) and before.total <= _EXPLAINED
        return "consistent" if quiet else "unexplained"
    quiet = _quiet(after, floor) and after.total <= _EXPLAINED
    return "explained" if quiet else "partly-explained"


def _quiet(gap: Gap, floor: Gap) -> bool:
    """Whether a gap is near the noise, in all and on every joint."""
    pairs = zip(gap.per_joint, floor.per_joint, strict=True)
    joints = all(g <= max(_LOUD * f, _SMALL) for g, f in pairs)
    return joints and gap.total <= max(_QUIET * floor.total, _SMALL)


def _advice(found: Sequence[FoundEffect], verdict: str, quiet: bool) -> tuple[str, ...]:
    out = [tie(e) for e in found if e.indistinguishable_from and e.separate]
    if quiet and verdict in ("partly-explained", "unexplained"):
        out.append("what is left is noise and static friction at rest: no effect is missing in it")
        return tuple(out)
    if verdict == "partly-explained":
        out.append("a part of the gap has no name: look at the portraits of the residual")
    if verdict == "unexplained":
        out.append(
            "no effect of the library explains the gap: look at the portraits of the residual"
        )
    return tuple(out)
