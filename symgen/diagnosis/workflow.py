"""diagnose: find where a model and measured data disagree, name why, and extend the model.

identify -> search on its repaired logs -> grade -> declare and identify again -> verdict
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path

import numpy as np

from symgen.data.log import Log
from symgen.data.long_logs import expanded, is_long
from symgen.data.raw import Reading, refuse
from symgen.diagnosis.adoption import Adopted, adopt, declare
from symgen.diagnosis.diagnosis import (
    Curves,
    Diagnosis,
    FoundEffect,
    FoundParameter,
    Gap,
    Gaps,
    Place,
    Rejected,
)
from symgen.diagnosis.extend import corrected
from symgen.diagnosis.gap import gap_of, moving_gap, places, validation_curves
from symgen.diagnosis.listing import joint_numbers, list_effects, robot_parameters
from symgen.diagnosis.messages import advice_of, corrections
from symgen.diagnosis.second_encoder import with_stiffness
from symgen.diagnosis.together import compared
from symgen.errors import ParameterError
from symgen.estimation.equation_model import kernels_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.floor import noise_fit, quiet
from symgen.estimation.opening import Source, Sources, listed_logs, open_log, require_logs
from symgen.estimation.torque_error import (
    TorqueFit,
    modelled_torque,
    percent,
    relative_error,
)
from symgen.estimation.values import FloatArray, Reason
from symgen.faults.mended import MendedChannel, largest_repairs, mended_channels
from symgen.hypotheses.changes import Change, Changed
from symgen.hypotheses.confirm import REPEATED, Weighed, confirm
from symgen.hypotheses.effects import Score
from symgen.hypotheses.event import Contact
from symgen.hypotheses.held import held_squares
from symgen.hypotheses.problem import make_problem
from symgen.hypotheses.registry import SearchResult, make_registry
from symgen.hypotheses.score import TINY
from symgen.hypotheses.search import Judge, search
from symgen.hypotheses.stiffness import stiffnesses
from symgen.identification.campaign import Campaign, Filtering, open_campaign
from symgen.identification.drives import in_torques
from symgen.identification.judgement import CHANGED, SEARCH
from symgen.identification.parameters import KnownParameters, read_known
from symgen.identification.searched import BROKEN
from symgen.identification.settle import EFFECT_MISSING, NO_ROBOT
from symgen.identification.workflow import (
    Identified,
    Settings,
    Solved,
    identified,
    solved,
)
from symgen.parallel import Say, silent
from symgen.policy import CHIEFLY, LEAST, MISFIT, WORTH
from symgen.robot.effect import RECORDER, definitions
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot, require_base
from symgen.runtime.evaluator import Evaluator, load_model

_LISTED = 12  # largest number of listed rejected candidates
_SATURATION = "saturation"
_NO_BETTER = "the fit of identify without it has no larger torque error on the validation data"
_UNSIMULATED = "a floating base is not simulated: torque errors alone decide on an effect"
#: Kinds of suspicions and of physical reasons that count as reasons.
_SERIOUS = (NO_ROBOT, EFFECT_MISSING, CHANGED)
_MANY = 2  # number of effects above which they are first judged without another search


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
    progress: Say = silent,
) -> Diagnosis:
    """Find where a model and measured data disagree, and name the missing effects.

    By default, symgen identifies the parameters from the logs, as `identify` does. With
    `parameters` from an earlier state of the robot, the logs show what changed since. The search
    tries the effects of the library, and those of the robot file whose constants are ranges.
    `symgen.hypotheses.search` accepts hypotheses, `symgen.hypotheses.confirm` grades them on the
    validation logs, and `symgen.diagnosis.adoption` writes them into the robot and identifies it
    again. The gap after is the torque error of that identification on held-out data.

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
        LogError: symgen cannot read a log, it belongs to another robot, or it is one of a flight.
        ParameterError: an effect does not exist, or the parameters do not belong to this robot.
        RobotError: the base floats, and the parameters are fixed.
        IdentificationError: the logs do not determine the parameters.
    """
    source = read_robot(robot)
    if parameters is not None:
        require_base(source, "diagnose --parameters", "symgen diagnose without it")
    library = dict.fromkeys((*definitions(), *(s.effect.name for s in source.sought)))
    unknown = [name for name in effects or () if name not in library]
    if unknown:
        raise ParameterError(f"effect {unknown[0]!r}; accepted: {', '.join(library)}")
    sources = expanded(listed_logs(logs)), expanded(listed_logs(validation))
    require_logs(sources[0])
    case = _Case(robot, source, sources, reading, least, progress, parameters, cutoff)
    if case.campaign.unsearched:
        refuse(
            f"robot {source.name!r}: diagnose takes neither flights nor a robot without joints",
            "symgen identify, or logs with forces or contacts of a robot with joints",
        )
    first = case.first if case.known is None else None
    found = _search(case, first, effects, misfit)
    if first is not None and first.estimate.has(NO_ROBOT) and not found[0].changes:
        found = _with_turned_torques(case, *found)
    progress("deriving, compiling and identifying the extended model")
    adopted = declare(*found)
    if first is not None:
        if len(adopted.result.effects) > _MANY:  # drop most of the weak ones at less cost
            adopted = adopt(*found, first, case.refitted, least)
        adopted = adopt(adopted.result, adopted.weighed, first, case.identified, least)
    return _conclude(case, first, adopted)


@dataclass(frozen=True, eq=False)
class _Case:
    """The logs of a diagnosis, and how `identify` fits a robot to them.

    Attributes:
        given: the robot, or the path of its file.
        source: the robot with the ranges of its constants.
        sources: the training and the validation logs.
        reading, least, progress, parameters, cutoff: as for `diagnose`.
        done: identifications that are done, by robot file and undone changes.
    """

    given: Robot | str | Path
    source: Robot
    sources: Sources
    reading: Reading | None
    least: float
    progress: Say
    parameters: str | Path | None
    cutoff: float | None
    done: dict[tuple[str, tuple[Changed, ...]], Identified] = field(default_factory=dict)

    @cached_property
    def robot(self) -> Robot:
        """The robot as its file declares it, without the ranges."""
        return replace(self.source, sought=())

    @cached_property
    def known(self) -> KnownParameters | None:
        """The fixed parameters; None to fit them."""
        if self.parameters is None:
            return None
        kernels = kernels_of(self._settings(self.robot).models)
        return read_known(self.parameters, load_model(robot_toml(self.robot), kernels).model)

    @cached_property
    def recorded(self) -> list[list[Log]] | None:
        """The logs as recorded; None for long logs."""
        if is_long([*chain(*self.sources)]):
            return None

        def opened(source: Source) -> Log:
            self.progress(f"reading {getattr(source, 'name', source)}")
            return open_log(source, self.robot, self.reading)

        return [[opened(source) for source in group] for group in self.sources]

    @cached_property
    def campaign(self) -> Campaign:
        """The repaired logs, or a sample of long ones."""
        if self.recorded is None:
            return self._opened(self.given, self.robot, self.sources, self.reading)
        reading = replace(self.reading or Reading(), start=None, until=None)
        logs = self.recorded[0], self.recorded[1]
        return self._opened(self.given, self.robot, logs, reading)

    def _opened(
        self, given: Robot | str | Path, robot: Robot, logs: Sources, reading: Reading | None
    ) -> Campaign:
        models = self._settings(robot).models
        known = self.known
        filtering = Filtering(self.cutoff, known=None if known is None else known.band)
        moving = known is None
        campaign = open_campaign(
            given, robot, logs, models, reading, filtering, self.progress, moving=moving
        )
        drives = None if known is None else known.drives
        return in_torques(campaign, given, reading=reading, drives=drives)

    @property
    def evaluator(self) -> Evaluator:
        """The compiled model of the declared robot."""
        return self.campaign.evaluator

    @cached_property
    def first(self) -> Identified:
        """The fit of the declared robot."""
        return identified(self.campaign, self._settings(self.robot))

    def identified(self, robot: Robot, changes: Sequence[Changed] = ()) -> Identified:
        """Identify another robot, with some changes of the logs undone.

        Args:
            robot: the robot; its [drive] may differ.
            changes: changes that no robot file can hold.
        """
        if robot == self.robot and not changes:
            return self.first
        key = robot_toml(robot), tuple(changes)
        if key not in self.done:
            self.done[key] = self._identified(robot, changes)
        return self.done[key]

    def _identified(self, robot: Robot, changes: Sequence[Changed]) -> Identified:
        settings, campaign = self._settings(robot), self.campaign
        if robot.drive != self.robot.drive:
            campaign = self._opened(robot, robot, self.sources, self.reading)
        for item in changes:
            campaign = campaign.changed(item.cause.undo)
        if changes or robot.drive == self.robot.drive:
            campaign = campaign.of_robot(robot, settings.models).in_new_band()
        return identified(campaign, settings)

    def refitted(self, robot: Robot, changes: Sequence[Changed] = ()) -> Solved:
        """Solve another robot without another search, by the model and on the logs of `first`."""
        if changes or robot.drive != self.robot.drive:
            return self.identified(robot, changes)
        settings = self._settings(robot)
        same = self.first.chosen.best.model.name
        models = tuple(m for m in settings.models if m.name == same) or settings.models
        campaign = self.first.campaign.of_robot(robot, models)
        return solved(campaign, replace(settings, models=models))

    def _settings(self, robot: Robot) -> Settings:
        return Settings.of(robot, least=self.least)


def _search(
    case: _Case,
    first: Identified | None,
    effects: Sequence[str] | None,
    misfit: float,
) -> tuple[SearchResult, tuple[Weighed, ...]]:
    """Search for missing effects, and grade them on the validation logs.

    Args:
        case: the logs.
        first: the fit of the declared robot, whose repaired logs are searched.
        effects: names of effects to try; None for all.
        misfit: smallest model error to expect.
    """
    campaign = case.campaign if first is None else first.campaign
    answer = campaign.answer
    X = None if case.known is None else case.known.X
    same = effects is None and misfit == MISFIT and not case.source.sought
    if answer.found and same:
        judge, start = answer.found
    else:
        problem = make_problem(case.evaluator, campaign.train, campaign.held, X, misfit)
        start = SearchResult(problem, problem)
        if any(reason.kind == BROKEN for reason in answer.shown):
            return start, ()
        judge = Judge(problem, make_registry(problem, case.source, effects), case.least)
    result = search(judge, start, progress=case.progress)
    return confirm(result, case.least)


def _with_turned_torques(
    case: _Case, result: SearchResult, weighed: tuple[Weighed, ...]
) -> tuple[SearchResult, tuple[Weighed, ...]]:
    """Return the search with all torques turned, if such a robot can exist.

    Negative masses explain turned torques as well as positive ones explain the others, so that no
    prediction tells them apart.
    """
    driven = tuple(j for j in range(case.robot.n) if j not in case.robot.passive)
    turned = Change(definitions()["wrong_sign"], driven, {"tau": -1.0})
    robot = corrected(case.robot, turned)
    estimate = None if robot is None else case.identified(robot).estimate
    if estimate is None or estimate.reasons or not estimate.possible:
        return result, weighed
    item = Changed(turned, odds=math.inf, worth=1.0, gain=1.0)
    grade = Weighed(item, fell=1.0, remaining=0.0)
    return result.with_items([item]), (grade,)


@dataclass(frozen=True, eq=False)
class _Gaps:
    """Torque errors on the validation logs, and the logs as they are drawn.

    Attributes:
        before, after: of the declared robot, and of the robot that is written.
        corrected: with what no robot file can hold; None if there is nothing of it.
        floor: noise floor of joints in motion.
        curves: torques for plots.
        promised: the fit of the robot that is written; None with fixed parameters.
    """

    before: TorqueFit
    after: TorqueFit
    corrected: TorqueFit | None
    floor: Gap
    curves: tuple[Curves, ...]
    promised: Identified | None = None

    @property
    def explained(self) -> Gap:
        """Torque error of joints in motion with all adopted effects."""
        return moving_gap(self.corrected or self.after)

    @property
    def trusted(self) -> bool | None:
        """Whether `identify` trusts the robot that is written; None with fixed parameters."""
        return None if self.promised is None else self.promised.estimate.verdict == "trusted"

    @property
    def moving(self) -> Gaps:
        """The errors of joints in motion."""
        return Gaps(moving_gap(self.before), moving_gap(self.after), self.floor)


def _measured(
    case: _Case, first: Identified | None, adopted: Adopted, contacts: Sequence[Contact]
) -> _Gaps:
    """Measure the torque errors of the declared robot and of the one that is written."""
    problem, together, last = adopted.result.problem, adopted.together, adopted.last
    if first is None or last is None:
        declared = adopted.result.declared
        logs = declared.held, problem.held
        unfitted = _torques(declared.evaluator, declared.X, declared.held)
        torques = unfitted, together.torques(problem.held)
        pairs = zip(logs, torques, strict=True)
        was, now = (compared(*pair, case.robot) for pair in pairs)
        noise = noise_fit(declared.evaluator, declared.held, declared.X).residual
        return _Gaps(was, now, None, gap_of(noise), validation_curves(logs, torques))
    promised = case.identified(adopted.robot) if adopted.undone else last
    assert isinstance(promised, Identified)
    logs = first.campaign.held, promised.campaign.held
    before, after = (
        _torques(x.campaign.evaluator, x.estimate.X, x.campaign.held) for x in (first, promised)
    )
    held, corrected = promised.campaign.held, None
    delays = adopted.delays if promised.campaign.answer.delays else ()
    if contacts or {*adopted.undeclared} - {*delays}:
        held = problem.without(contacts).held
        after = together.torques(held)
        corrected = compared(held, after, case.robot)
    floor = first.estimate.noise_floor
    assert floor is not None
    return _Gaps(
        first.outcome.torque_held,
        promised.outcome.torque_held,
        corrected,
        gap_of(floor),
        validation_curves((first.campaign.held, held), (before, after)),
        promised,
    )


def _contacts(first: Identified | None, adopted: Adopted) -> tuple[Contact, ...]:
    """Return the contacts in training logs, and those in validation logs on the same joints.

    Those whose flag `identify` sets are repairs.
    """
    result = adopted.result
    train = [*result.contacts]
    if first is not None:
        masked = [c for c in first.campaign.answer.contacts if not c.cause.frame]
        train = [*masked, *train]
    joints = {contact.joints for contact in train}
    held = [contact for contact in result.held_contacts if contact.joints in joints]
    return (*train, *held)


def _torques(evaluator: Evaluator, X: FloatArray, logs: Sequence[FilteredLog]) -> list[FloatArray]:
    """Return the torque of a model along some logs in the band, (K, n), masked samples included."""
    return [modelled_torque(evaluator, log.unmasked, X) for log in logs]


def _saturation(fitted: Identified | None, least: float) -> FoundEffect | None:
    """Return clipped torques as an effect of the recorder, if their samples hide a model's fit."""
    if fitted is None:
        return None
    campaign = fitted.campaign
    faults = [f for f in campaign.repairs if f.kind == "saturated"]
    if not faults:
        return None
    robot, held = campaign.robot, campaign.held
    torques = _torques(campaign.evaluator, fitted.estimate.X, held)
    whole = [log.unmasked for log in held]
    fits = (compared(logs, torques, robot) for logs in (whole, held))
    before, after = (np.array(fit.residual.per_joint) for fit in fits)
    if (before - after).max() < least:
        return None
    values = {}
    for name, value, std in (measured for f in faults for measured in f.values):
        values[name] = FoundParameter(name, value, std, "")
    d = definitions()[_SATURATION]
    return FoundEffect(
        name=d.name,
        joints=joint_numbers(robot, sorted({j for f in faults for j in f.joints})),
        parameters=tuple(values.values()),
        expression=d.formula,
        p_value=0.0,
        gap_reduction=1 - float(np.sum(after**2) / np.sum(before**2)),
        shown=True,
        declared=False,
    )


def _conclude(case: _Case, first: Identified | None, adopted: Adopted) -> Diagnosis:
    """Assemble the diagnosis from its intermediate results."""
    result, robot, least = adopted.result, case.robot, case.least
    contacts = _contacts(first, adopted)
    gaps = _measured(case, first, adopted, contacts)
    if gaps.corrected is not None and gaps.explained.total >= gaps.moving.after.total:
        adopted = adopted.without_columns(_NO_BETTER)
        result = adopted.result
        gaps = _measured(case, first, adopted, contacts)
    last = case.campaign if gaps.promised is None else gaps.promised.campaign
    suspected = _suspected(adopted, contacts, least)
    masked = case.reading is not None and _SATURATION in case.reading.mask
    clipped = None if masked else _saturation(gaps.promised, least)
    found = list_effects(adopted, contacts, suspected, delays=not last.answer.delays)
    effects = found if clipped is None else (clipped, *found)
    named = [e for e in effects if e.adopted]
    reasons = _reasons(gaps.promised)
    verdict = _verdict(adopted, gaps, effects, reasons, least)
    listed = {EFFECT_MISSING, *(e.name for e in effects)}
    where: tuple[Place, ...] = ()
    if verdict != "consistent":
        where = places(result, named, moving_gap(gaps.before), gaps.floor, gaps.curves, contacts)
    doubted = {w.item.key for w in suspected}
    others = [w for w in adopted.weighed if w.item.key not in doubted]
    scores = [w for w in others if isinstance(w.item, Score)]
    refused = [(w.item, w.reason) for w in scores if w.reason]
    refused += [(s, s.why) for s in result.rejected[:_LISTED]]
    cutoffs = [log.rows.cutoff for log in result.problem.held if log.rows.cutoff]
    values = result.declared.X if first is None else first.estimate.X
    diagnosis = Diagnosis(
        robot=robot.name,
        verdict=verdict,
        cutoff_hz=min(cutoffs, default=None),
        before=gap_of(gaps.before.residual),
        after=gap_of(gaps.after.residual),
        floor=gaps.floor,
        moving=gaps.moving,
        corrected=None if gaps.corrected is None else gaps.explained,
        trusted=gaps.trusted,
        where=where,
        effects=effects,
        rejected=tuple(
            Rejected(s.cause.name, joint_numbers(robot, s.joints), why) for s, why in refused
        ),
        advice=(
            *(r.text.removesuffix(f"; {SEARCH}") for r in reasons if r.kind not in listed),
            *(f"{line} (written into robot.toml)" for line in corrections(robot, adopted.robot)),
            *advice_of(effects, robot, verdict, gaps.explained),
        ),
        notes=_notes(case, first, adopted, gaps, named, last),
        extended=adopted.robot,
        joints=robot.numbers,
        curves=gaps.curves,
        tried=result.tried,
        parameters=robot_parameters(adopted),
        declared=robot,
        values=tuple(map(float, values)),
        repairs=last.repairs,
        mended=() if first is None else _mended(case, first.campaign),
        band=last.band,
        estimates=tuple(x.estimate for x in (first, gaps.promised) if x is not None),
    )
    return with_stiffness(diagnosis, robot, stiffnesses(result.problem.base))


def _suspected(adopted: Adopted, contacts: Sequence[Contact], least: float) -> list[Weighed]:
    """Return the hypotheses that matter but are not adopted: the largest of each joint."""
    refused = (w for w in adopted.weighed if not w.adopted)
    doubted = [w for w in refused if w.fell >= least and w.remaining < 1]
    others = (c for c in adopted.result.held_contacts if c not in contacts)
    doubted += [Weighed(c, c.worth, reason="no other motion confirms it") for c in others]
    out, taken = list[Weighed](), set[int]()
    for w in sorted(doubted, key=lambda w: -w.fell):
        joints = {*(w.item.joints or [-1])}  # -1: an effect on all joints
        if not joints & taken:
            out.append(w)
            taken |= joints
    return out


def _reasons(promised: Identified | None) -> tuple[Reason, ...]:
    """Return why `identify` doubts the written robot, and why no robot has these parameters."""
    if promised is None:
        return ()
    estimate = promised.estimate
    physical = [estimate.physical.reason] if estimate.physical.reason else []
    others = (*physical, *estimate.suspected)
    serious = (r for r in others if r.kind in _SERIOUS and not estimate.has(r.kind))
    return *estimate.reasons, *serious


def _verdict(
    adopted: Adopted,
    gaps: _Gaps,
    effects: Sequence[FoundEffect],
    reasons: Sequence[Reason],
    least: float,
) -> str:
    """Return one of VERDICTS."""
    kinds = {reason.kind for reason in reasons}
    clipped = sum(e.gap_reduction for e in effects if e.name == _SATURATION)
    if kinds & {BROKEN, NO_ROBOT} or _recorder_is_chief(adopted, clipped):
        return "bad-measurement"
    explained = quiet(gaps.explained.parts, gaps.floor.parts, least)
    if gaps.corrected is None:
        explained = explained and EFFECT_MISSING not in kinds
    if not any(e.adopted for e in effects):
        sound = explained and not effects and gaps.trusted is not False
        return "consistent" if sound else "unexplained"
    if gaps.corrected is None:
        explained = explained and gaps.trusted is not False
    return "explained" if explained else "partly-explained"


def _recorder_is_chief(adopted: Adopted, clipped: float) -> bool:
    """Whether faults that only a new recording mends close most of the gap.

    Args:
        adopted: the adopted effects.
        clipped: part of the squared error that clipped torques cause.
    """
    result = adopted.result
    wrong = (x for x in adopted.undeclared if x not in adopted.delays)
    faults = [x for x in wrong if x.definition.side == RECORDER]
    if not faults and not clipped:
        return False
    others = [x for x in result.items if x not in faults]
    kinds = result.problem.robot.kinds
    first, without, last = (
        relative_error(*held_squares(result, items), kinds).relative ** 2
        for items in ([], others, result.items)
    )
    masked = last * clipped / max(1 - clipped, TINY)
    remaining = math.sqrt(last / max(without + masked, TINY))
    by_faults = without - last + masked
    closed = first - last + masked
    return by_faults >= CHIEFLY * closed and 1 - remaining >= WORTH


def _notes(
    case: _Case,
    first: Identified | None,
    adopted: Adopted,
    gaps: _Gaps,
    named: Sequence[FoundEffect],
    last: Campaign,
) -> tuple[str, ...]:
    """Return notes on the logs, on the numbers, and on what the extended robot lacks."""
    opened, source = case.campaign, case.source
    out = [note for log in opened.logs for note in log.samples.notes]
    out += [*(fault.in_words for fault in last.repairs), f"band: {last.band.in_words()}"]
    if opened.long is not None:
        out += opened.long.in_words("read; the search is that of")
    if not opened.has_validation:
        out.append(
            "no validation log is given: the torque error is that of the last fifth of each log"
        )
    if source.floating:
        out.append(_UNSIMULATED)
    if any(w.reason == REPEATED for w in adopted.weighed):
        out.append(f"{REPEATED}: record another motion (symgen excite plans one)")
    if first is not None and gaps.promised is not None:
        out += _models(first, gaps.promised)
    if gaps.corrected is not None:
        out.append(
            f"with what no robot file can hold, the torque error is {percent(gaps.explained.total)}"
        )
    known = {(e.name, joint) for e in named for joint in e.joints}
    lost = [s.key for s in source.sought if s.key not in known]
    if lost:
        listed = ", ".join(f"{name} on {source.label(joint)}" for name, joint in lost)
        out.append(
            f"not found in these logs, so the extended robot.toml does not contain it: {listed}"
        )
    return tuple(out)


def _models(first: Identified, last: Identified) -> list[str]:
    """Return a note on the models of both errors if they differ."""
    was, now = (x.estimate.model for x in (first, last))
    if was == now:
        return []
    text = f"the torque error before is that of the {was} model, the one after of the {now} model"
    for a in first.estimate.alternatives:
        if a.model == now and a.validation is not None:
            error = percent(a.validation.relative)
            text += f"; by that model, the error before is {error} over all samples"
    return [text]


def _mended(case: _Case, campaign: Campaign) -> tuple[MendedChannel, ...]:
    """Return the channels that repairs changed the most."""
    used = {log.name: log.samples for log in campaign.logs}
    logs = [] if case.recorded is None else [*chain(*case.recorded)]
    pairs = [(log, used[log.name]) for log in logs if log.name in used]
    return largest_repairs(mended_channels(pairs, campaign.repairs, case.robot.sigma))
