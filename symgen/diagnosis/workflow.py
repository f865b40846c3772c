"""diagnose: find where a model and measured data disagree, name why, and extend the model.

open logs -> problem -> search -> confirm -> extend the model -> measure the gap -> verdict
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np

from symgen.data.log import Log
from symgen.data.long_logs import expanded, is_long
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.diagnosis.diagnosis import (
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Rejected,
)
from symgen.diagnosis.extended import (
    Extended,
    extend_model,
    joint_numbers,
    list_effects,
    robot_parameters,
)
from symgen.diagnosis.gap import Measured, error_in_motion, measure_gap, places
from symgen.diagnosis.messages import advice_of
from symgen.diagnosis.second_encoder import with_stiffness
from symgen.errors import IdentificationError, ParameterError, RobotError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.floor import quiet
from symgen.estimation.logs import (
    Source,
    hold_out,
    listed_logs,
    open_log,
    require_logs,
    require_other_data,
)
from symgen.estimation.torque_error import percent
from symgen.estimation.values import Reason
from symgen.faults.fault import Fault
from symgen.faults.logs import join_bands, open_logs, open_samples, require_motion
from symgen.faults.mended import MendedChannel, largest_repairs, mended_channels
from symgen.faults.samples import unmended_faults
from symgen.hypotheses.confirm import REPEATED, Weighed, confirm, restricted
from symgen.hypotheses.effects import Score
from symgen.hypotheses.held import held_squares
from symgen.hypotheses.priors import RECORDER, prior_of
from symgen.hypotheses.problem import Problem, make_problem, model_of
from symgen.hypotheses.registry import SearchResult, make_registry
from symgen.hypotheses.score import TINY
from symgen.hypotheses.search import search
from symgen.hypotheses.stiffness import stiffnesses
from symgen.identification.judgement import changed_state
from symgen.identification.parameters import read_known, values_of_file
from symgen.identification.possible import nearest_possible
from symgen.identification.segments import sample_logs
from symgen.identification.settle import EFFECT_MISSING, largest_error, like_no_robot
from symgen.identification.torque_scale import in_torque_scale
from symgen.parallel import thread_count
from symgen.policy import ACCEPT, EXPLAINED, LEAST, MISFIT
from symgen.robot.effect import definitions
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot

Groups = tuple[Sequence[Samples], Sequence[Samples]]
#: Kind of a repair -> name of the effect.
_REPAIRED = {
    "speed": "velocity_sensor_error",
    "saturated": "saturation",
}
_LISTED = 12  # largest number of listed rejected candidates
_GROWS = "with it the torque error on the validation data is not smaller"


def diagnose(
    robot: Robot | str | Path,
    logs: Sequence[Source] | Source,
    *,
    validation: Sequence[Source] | Source = (),
    effects: Sequence[str] | None = None,
    parameters: str | Path | None = None,
    cutoff: float | None = None,
    least: float = LEAST,
    misfit: float = MISFIT,
    reading: Reading | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find where a model and measured data disagree, and name the missing effects.

    By default, symgen identifies the parameters from the logs, with the torque equations in the
    motion's band. With `parameters` from an earlier state of the robot, the logs show what changed
    since. The search tries the effects of the library, and those of the robot file whose constants
    are ranges. `symgen.hypotheses.search` accepts hypotheses, and `symgen.hypotheses.confirm`
    adopts them on the validation logs. symgen then derives, compiles and identifies the extended
    model. The gap is measured on held-out data.

    Args:
        robot: a robot, a path or a library name.
        logs: logs or paths of logs; a pattern or a folder stands for its files. symgen reads evenly
            spaced pieces of files with more than 2**18 samples and of files at a URL.
        validation: logs on which the gap is measured; if empty, the last fifth of each log.
        effects: names of effects to try; None for all of the library and of the robot file.
        parameters: fixed parameters: the folder that `identify` wrote, its estimate.json, TOML with
            [parameters], or the URDF of the robot.
        cutoff: cutoff of the zero-phase low-pass, Hz; None for the motion's bandwidth.
        least: smallest torque that matters, as a part of the joint's torque; smaller effects are
            not named.
        misfit: smallest model error to expect, as a part of a joint's torque.
        reading: options of reading and masking.
        progress: called with a text about the current step.

    Raises:
        LogError: symgen cannot read a log, or it belongs to another robot.
        ParameterError: an effect does not exist, or the parameters do not belong to this robot.
        IdentificationError: the logs do not determine the parameters.
    """
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    library = dict.fromkeys((*definitions(), *(s.effect.name for s in source.sought)))
    unknown = [name for name in effects or () if name not in library]
    if unknown:
        raise ParameterError(f"effect {unknown[0]!r}; accepted: {', '.join(library)}")
    named = expanded(listed_logs(logs)), expanded(listed_logs(validation))
    opened = _open(source, named, reading, progress)
    if parameters is None:
        require_motion(opened.train, source)
    progress("deriving and compiling the model")
    evaluator = model_of(replace(source, sought=()))
    file_values = values_of_file(robot, evaluator.model)
    opened = in_torque_scale(opened, file_values, evaluator, reading)
    known = None if parameters is None else read_known(parameters, evaluator.model)
    band = known.band if known is not None else None
    band = band or choose_band(evaluator, opened.train, cutoff, threads=thread_count())
    band = band if cutoff is None else replace(band, cutoff_hz=cutoff)
    X = None if known is None else known.X
    problem = make_problem(evaluator, *_in_band(opened.groups, band), X, misfit)
    samples = (*opened.train, *opened.held)
    broken = [f for s in samples for f in unmended_faults(s, source.passive)]
    registry = make_registry(problem, source, effects)
    result = SearchResult(problem, problem)
    if not broken:
        result = search(problem, registry, least, progress=progress)
    progress("deriving, compiling and identifying the extended model")
    result, weighed = confirm(result, least)
    result, weighed, model, gaps = _extend(result, weighed)
    listed = (*_repaired(opened, band, problem, least), *list_effects(model, weighed))
    reasons = [Reason(fault.kind, fault.joints, text=fault.fault) for fault in broken]
    reasons = reasons or _impossible(model, gaps)
    concluded = _Concluded(source, result, weighed, model, gaps, listed, tuple(reasons))
    return _conclude(opened, band, concluded, least)


@dataclass(frozen=True, eq=False)
class _Opened:
    """The logs of a diagnosis.

    Attributes:
        train, held: the repaired logs. Without validation logs, `held` is the end of each training
            log.
        has_validation: whether there are validation logs from the user.
        repairs: the repairs.
        changed: the channels that the repairs changed.
        unmended: both groups without masks of faults and with the measured speeds; None if no
            repair has the name of an effect.
        notes: texts about the pieces of long logs.
    """

    train: Sequence[Samples]
    held: Sequence[Samples]
    has_validation: bool
    repairs: tuple[Fault, ...]
    changed: Sequence[MendedChannel] = ()
    unmended: Groups | None = None
    notes: tuple[str, ...] = ()

    @property
    def groups(self) -> Groups:
        """The training and the validation logs."""
        return self.train, self.held


def _open(
    robot: Robot,
    sources: tuple[Sequence[Source], Sequence[Source]],
    reading: Reading | None,
    progress: Callable[[str], None],
) -> _Opened:
    """Read each log once and repair it."""
    require_logs(sources[0])
    has_validation = bool(sources[1])
    if is_long([*chain(*sources)]):
        sampled = sample_logs(robot, *sources, reading or Reading(), 0.0, progress)
        words = sampled.in_words("read; the diagnosis is that of")
        train, held, more = join_bands(sampled.train, sampled.held)
        groups = (train, held) if has_validation else hold_out(train)
        done = (*sampled.repairs, *more)
        return _Opened(*groups, has_validation, done, notes=(*sampled.notes, *words))

    def opened(source: Source) -> Log:
        progress(f"reading {getattr(source, 'name', source)}")
        return open_log(source, robot, reading)

    recorded = [[opened(source) for source in group] for group in sources]
    uncut = replace(reading or Reading(), start=None, until=None)
    (train, held), repairs = open_logs(recorded, robot, uncut, lambda _: None)
    require_other_data(train, held)
    train, held, more = join_bands(train, held)
    logs, done = [*chain(*recorded)], (*repairs, *more)
    changed = [*mended_channels(zip(logs, (*train, *held), strict=True), done, robot.sigma)]
    groups = (train, held) if has_validation else hold_out(train)
    unmended = None
    if any(r.kind in _REPAIRED for r in done):
        first, last = (
            [open_samples(log, robot, uncut, mask_faults=False)[0] for log in group]
            for group in recorded
        )
        unmended = (first, last) if has_validation else hold_out(first)
    return _Opened(*groups, has_validation, done, changed, unmended)


def _in_band(groups: Groups, band: Band) -> tuple[list[FilteredLog], list[FilteredLog]]:
    train, held = ([filter_log(s, band) for s in group] for group in groups)
    return train, held


def _extend(
    result: SearchResult, weighed: tuple[Weighed, ...]
) -> tuple[SearchResult, tuple[Weighed, ...], Extended, Measured]:
    """Extend the model; drop the weakest hypothesis while identification fails or the gap grows."""
    while True:
        items = result.items
        lost = ""
        try:
            model = extend_model(result)
            gaps = measure_gap(result, model)
            if not items or not gaps.grew:
                return result, weighed, model, gaps
        except (IdentificationError, RobotError) as error:
            if not items:  # the declared model itself
                raise
            lost = f"the model with it cannot be identified: {error}"
        fell = {w.item.key: w.fell for w in weighed}  # by key, because new constants make new items
        weakest = min(items, key=lambda x: fell.get(x.key, 0.0))
        result = restricted(result, [x for x in items if x is not weakest])
        if lost and isinstance(weakest, Score):
            result = replace(result, rejected=(replace(weakest, fault=lost), *result.rejected))
            weighed = tuple(w for w in weighed if w.item.key != weakest.key)
        weighed = tuple(
            replace(w, adopted=False, reason=_GROWS) if w.item.key == weakest.key else w
            for w in weighed
        )


def _impossible(model: Extended, gaps: Measured) -> list[Reason]:
    """Return a reason if the model explains the logs but the nearest possible robot does not."""
    free = gaps.moving.after.total
    if model.problem.is_fixed or free > ACCEPT:
        return []
    try:
        near = nearest_possible(model.evaluator.model, model.of_robot, model.covariance)
    except ParameterError:  # the covariance is invalid
        return []
    if not near.fault:
        return []
    X = np.concatenate([near.X, model.X[model.count :]])
    bounded = error_in_motion(replace(model, X=X), model.problem.held)
    limit = largest_error(free)
    if bounded <= limit:
        return []
    text = f"{near.fault}; the nearest possible robot has {percent(bounded)} torque error"
    missing = Reason(EFFECT_MISSING, value=bounded, limit=limit, text=text)
    fitted = model.evaluator.model, model.of_robot, model.covariance
    return like_no_robot(*fitted, (free, bounded), ACCEPT) or [missing]


def _repaired(
    opened: _Opened, band: Band, problem: Problem, least: float
) -> tuple[FoundEffect, ...]:
    """Return repairs of samples as effects of the recorder, if they close a part of the gap."""
    if opened.unmended is None:
        return ()
    measured = replace(band, velocity="measured")
    try:
        raw = make_problem(
            problem.evaluator, *_in_band(opened.unmended, measured), problem.known, problem.misfit
        )
    except IdentificationError:  # the logs as recorded determine no model
        return ()
    (was, size), (now, other) = (held_squares(SearchResult(p, p), []) for p in (raw, problem))
    before, after = np.sqrt(was / size), np.sqrt(now / other)
    if (before - after).max() < least or (after - before).max() >= least:
        return ()
    share = 1 - float(np.sum(after**2) / np.sum(before**2))
    by_name: dict[str, list[Fault]] = {}
    for r in opened.repairs:
        if r.kind in _REPAIRED:
            by_name.setdefault(_REPAIRED[r.kind], []).append(r)
    return tuple(_recorder_effect(*x, problem.robot, share) for x in by_name.items())


def _recorder_effect(name: str, faults: Sequence[Fault], robot: Robot, share: float) -> FoundEffect:
    """Return the repairs of one kind as one effect, with the first value of each parameter."""
    joints = sorted({j for f in faults for j in f.joints})
    values: dict[str, FoundParameter] = {}
    for fault in faults:
        for key, value, std in fault.values:
            values.setdefault(key, FoundParameter(key, value, std, ""))
    d = definitions()[name]
    return FoundEffect(
        name=name,
        joints=joint_numbers(robot, joints),
        parameters=tuple(values.values()),
        expression=d.formula,
        p_value=0.0,
        gap_reduction=share,
        adopted=True,
        shown=True,
        declared=False,
    )


@dataclass(frozen=True, eq=False)
class _Concluded:
    """The intermediate results of a diagnosis; `robot` is as its file declares it."""

    robot: Robot
    result: SearchResult
    weighed: tuple[Weighed, ...]
    model: Extended
    gaps: Measured
    effects: tuple[FoundEffect, ...]
    #: Reasons why the measurement is wrong, or why no robot has these parameters.
    reasons: tuple[Reason, ...]


def _verdict(c: _Concluded, least: float) -> str:
    """Return one of VERDICTS."""
    impossible = any(reason.kind == EFFECT_MISSING for reason in c.reasons)
    wrong = bool(c.reasons) and not impossible
    if wrong or _recorder_closes_more(c):
        return "bad-measurement"
    after, floor = c.gaps.moving.after, c.gaps.moving.noise_floor
    explained = quiet(after.per_joint, floor.per_joint, least) and not impossible
    if not any(e.adopted for e in c.effects):
        return "consistent" if explained else "unexplained"
    return "explained" if explained and after.total <= EXPLAINED else "partly-explained"


def _recorder_closes_more(c: _Concluded) -> bool:
    """Whether adopted faults of the recorder explain more of the torque than all other effects."""
    # The search starts from the error after the repairs.
    before = c.gaps.all_samples.before.total**2
    shares = [e.gap_reduction for e in c.effects if e.name in _REPAIRED.values()]
    closed = {RECORDER: sum(before * share / max(1 - share, TINY) for share in shares)}
    for w in c.weighed:
        side = prior_of(w.item.definition).side
        closed[side] = closed.get(side, 0.0) + w.adopted * w.fell**2
    return 2 * closed[RECORDER] > sum(closed.values())


def _conclude(opened: _Opened, band: Band, c: _Concluded, least: float) -> Diagnosis:
    """Assemble the diagnosis from its intermediate results."""
    result, robot = c.result, c.result.declared.robot
    verdict = _verdict(c, least)
    adopted = [e for e in c.effects if e.adopted]
    where = () if verdict == "consistent" else places(result, adopted, c.gaps)
    doubts = [(w.item, w.reason) for w in c.weighed if not w.adopted]
    refused = [(s, why) for s, why in doubts if isinstance(s, Score)]
    refused += [(s, s.fault) for s in result.rejected[:_LISTED]]
    rejected = (
        Rejected(s.definition.name, joint_numbers(robot, s.joints), why) for s, why in refused
    )
    train = result.problem.base
    remaining = c.gaps.moving.after
    changed: list[Reason] = []
    if opened.has_validation and verdict in ("unexplained", "partly-explained"):
        changed = changed_state(error_in_motion(c.model, result.problem.logs), remaining.total)
    cutoffs = [log.rows.cutoff for log in result.problem.held if log.rows.cutoff]
    diagnosis = Diagnosis(
        robot=robot.name,
        verdict=verdict,
        cutoff_hz=min(cutoffs, default=None),
        before=c.gaps.all_samples.before,
        after=c.gaps.all_samples.after,
        floor=c.gaps.all_samples.noise_floor,
        moving=c.gaps.moving,
        where=where,
        effects=c.effects,
        rejected=tuple(rejected),
        advice=(
            *(r.text for r in (*c.reasons, *changed)),
            *advice_of(c.effects, robot, verdict, remaining),
        ),
        notes=_notes(opened, band, c),
        extended=c.model.robot,
        joints=tuple(j.number for j in robot.movable),
        curves=c.gaps.curves,
        tried=result.tried,
        parameters=robot_parameters(c.model, c.effects),
        declared=robot,
        values=tuple(map(float, result.declared.estimate)),
        repairs=opened.repairs,
        mended=largest_repairs(opened.changed),
        band=band,
    )
    return with_stiffness(diagnosis, robot, stiffnesses(train))


def _notes(opened: _Opened, band: Band, c: _Concluded) -> tuple[str, ...]:
    """Return the changes of the logs, and the effects that the extended robot does not contain."""
    out = [note for s in (*opened.train, *opened.held) for note in s.notes]
    out += [*opened.notes, *(r.in_words for r in opened.repairs), f"band: {band.in_words()}"]
    if not opened.has_validation:
        out.append(
            "no validation log is given: the torque error is that of the last fifth of each log"
        )
    if any(w.reason == REPEATED for w in c.weighed):
        out.append(f"{REPEATED}: record another motion (symgen excite plans one)")
    named = {(e.name, joint) for e in c.effects if e.adopted for joint in e.joints}
    lost = [s.key for s in c.robot.sought if s.key not in named]
    if lost:
        listed = ", ".join(f"{name} on {c.robot.label(joint)}" for name, joint in lost)
        out.append(
            f"not found in these logs, so the extended robot.toml does not contain it: {listed}"
        )
    return tuple(out)
