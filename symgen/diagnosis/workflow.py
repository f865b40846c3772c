"""diagnose: compare model and logs, locate the gap, name effects, and extend the model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from pathlib import Path

import numpy as np

from symgen.data.log import Log
from symgen.data.long_logs import expanded, is_long
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.diagnosis.baseline import Baseline, baseline, model_of
from symgen.diagnosis.conclusion import conclude, plain
from symgen.diagnosis.contacts import NAME as CONTACT
from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect
from symgen.diagnosis.effects import candidates
from symgen.diagnosis.measuring_chain import (
    check,
    closed,
    is_effect,
    matters,
    mended,
    name_of,
    named_effects,
    places_of,
    rejected,
    rivals_physics,
    with_chain,
)
from symgen.diagnosis.model_based_effects import special_candidates
from symgen.diagnosis.search import Search
from symgen.diagnosis.stiffness import NAME as STIFFNESS
from symgen.diagnosis.stiffness import stiffnesses, with_stiffness
from symgen.errors import IdentificationError, ParameterError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.logs import (
    Source,
    hold_out,
    listed_logs,
    open_log,
    require_logs,
    require_other_data,
)
from symgen.estimation.masking import rests_in_words
from symgen.estimation.values import FloatArray
from symgen.faults.causes import find_cause
from symgen.faults.fault import MASKED, Fault, undo_faults
from symgen.faults.logs import join_bands, open_logs, open_samples, require_motion
from symgen.faults.mended import MendedChannel, largest, mended_channels
from symgen.faults.scene import Rows, Scene
from symgen.identification.parameters import read_given
from symgen.identification.segments import sample_logs
from symgen.parallel import own_threads
from symgen.policy import LEAST, MISFIT
from symgen.robot.effect import definitions
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

Groups = tuple[Sequence[Samples], Sequence[Samples]]


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

    By default, the parameters are identified from the logs by the torque equations in the motion's
    band. With `parameters`, of an earlier state of the robot, the logs show what has changed since.
    Effects of the robot file with ranges as constants are tried together with the library.
    Candidates are accepted by the rule of `symgen.diagnosis.search`. The extended model is derived,
    compiled and identified again. The gap is measured on data that the selection did not use.

    Args:
        robot: a robot, a path or a library name.
        logs: logs, or paths of logs, to diagnose; a pattern or a folder stands for its files. Of
            files of more than 2**18 samples, and of those at a URL, evenly spaced pieces are read.
        validation: logs on which the gap is measured; without any, the last fifth of each log.
        effects: names of effects to try; None for the whole library and the robot's own.
        parameters: fixed parameters: the folder that `identify` wrote, its estimate.json, TOML with
            [parameters], or the URDF of the robot.
        cutoff: cutoff of the zero-phase low-pass, Hz; None for the motion's bandwidth.
        least: smallest torque that matters, as a part of the joint's torque; smaller effects are
            not named.
        misfit: smallest model error to expect, as a part of a joint's torque.
        reading: how logs are read, and what is masked.
        progress: called with a text about what is being tried.

    Raises:
        LogError: a log cannot be read or belongs to another robot.
        ParameterError: an effect does not exist, or the parameters do not belong to this robot.
        IdentificationError: the logs do not determine the parameters.
    """
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    library = dict.fromkeys((*definitions(), *(s.effect.name for s in source.sought)))
    unknown = [name for name in effects or () if name not in library]
    if unknown:
        raise ParameterError(f"effect {unknown[0]!r}; accepted: {', '.join(library)}")
    named = expanded(listed_logs(logs)), expanded(listed_logs(validation))
    opened = _opened(source, named, reading, progress)
    if parameters is None:
        require_motion(opened.train, source)
    progress("deriving and compiling the model")
    evaluator = model_of(replace(source, sought=()))
    known = None if parameters is None else read_given(parameters, evaluator.model)

    def band_of(train: Sequence[Samples]) -> Band:
        band = known.band if known is not None else None
        band = band or choose_band(evaluator, train, cutoff, threads=own_threads())
        return band if cutoff is None else replace(band, cutoff_hz=cutoff)

    given = None if known is None else known.X
    asked = _Question(source, evaluator, opened, band_of, given, effects, least, misfit, progress)
    progress("checking the logs")
    faults, lasting = check(evaluator, *asked.logs, opened.repairs)
    try:
        whole = asked.answer(faults, lasting)
    except IdentificationError as error:
        if not lasting:
            raise
        try:  # without these channels, nothing can be identified
            whole = asked.unsearched(faults, lasting)
        except IdentificationError:
            raise IdentificationError(f"{lasting[0].fault} ({error})") from error
    rivals = [f for f in faults if rivals_physics(f)]
    if rivals:
        sure = [f for f in faults if not rivals_physics(f)]
        whole = _of_rivals(whole, asked.answer(sure), rivals, source, least)
    if whole.verdict in ("unexplained", "partly-explained"):
        train, held = asked.logs
        free = tuple(undo_faults(log, whole.contacts)[0] for log in (*train, *held))
        rows = Rows(evaluator, free, len(train), misfit)
        cause = find_cause(Scene(rows), repairs=opened.repairs, least=least)
        if cause is not None:
            whole = replace(whole, advice=(cause.says, *whole.advice))
    drawn = (*whole.mended, *opened.changed)
    whole = replace(whole, repairs=opened.repairs, mended=largest(drawn), band=asked.band)
    return _with_left_out(whole, source)


def _of_rivals(
    undone: Diagnosis, physics: Diagnosis, faults: Sequence[Fault], robot: Robot, least: float
) -> Diagnosis:
    """Return the diagnosis with the smaller gap: with the faults undone, or of the physics.

    If both gaps are the same, the physics is named, because it needs no fault of the recorder. If
    the physics names one of the faults itself, the fault is undone.
    """
    same = {*map(name_of, faults)} & {e.name for e in physics.effects}
    if same or matters(physics.moving[1], undone.moving[1], least):
        return undone
    names = ", ".join(dict.fromkeys(e.name for e in physics.effects)) or "the model alone"
    so = (
        f": the torque error is {100 * undone.after.total:.3g} % if it is corrected, and "
        f"{100 * physics.after.total:.3g} % with {names} instead"
    )
    told = (rejected(f, robot, so) for f in faults)
    return replace(physics, rejected=(*told, *physics.rejected))


def _with_left_out(diagnosis: Diagnosis, robot: Robot) -> Diagnosis:
    """Note which effects of the robot file the extended robot does not have."""
    named = {(e.name, joint) for e in diagnosis.effects for joint in e.joints}
    left = [s.key for s in robot.sought if s.key not in named]
    if not left:
        return diagnosis
    listed = ", ".join(f"{name} on {robot.label(joint)}" for name, joint in left)
    note = f"not found in these logs, so the extended robot.toml does not contain it: {listed}"
    return replace(diagnosis, notes=(*diagnosis.notes, note))


@dataclass(frozen=True, eq=False)
class _Opened:
    """The logs of a diagnosis.

    Attributes:
        train, held: the repaired logs.
        repairs: the repairs.
        changed: the channels that the repairs changed.
        unmended: both groups without masks of faults and with the measured speeds; None if these
            are the same.
        notes: texts about a sample of long logs.
    """

    train: Sequence[Samples]
    held: Sequence[Samples]
    repairs: tuple[Fault, ...]
    changed: Sequence[MendedChannel]
    unmended: Groups | None
    notes: tuple[str, ...] = ()


def _opened(
    robot: Robot,
    sources: tuple[Sequence[Source], Sequence[Source]],
    reading: Reading | None,
    progress: Callable[[str], None],
) -> _Opened:
    """Read each log once, and repair it."""
    require_logs(sources[0])
    if is_long([*chain(*sources)]):
        sampled = sample_logs(robot, *sources, reading or Reading(), 0.0, progress)
        said = sampled.in_words("read; the diagnosis is that of")
        train, held, more = join_bands(sampled.train, sampled.held)
        done = (*sampled.repairs, *more)
        return _Opened(train, held, done, (), None, (*sampled.notes, *said))

    def opened(source: Source) -> Log:
        progress(f"reading {getattr(source, 'name', source)}")
        return open_log(source, robot, reading)

    recorded = [[opened(source) for source in group] for group in sources]
    uncut = replace(reading or Reading(), start=None, until=None)
    (train, held), repairs = open_logs(recorded, robot, uncut, lambda _: None)
    require_other_data(train, held)
    plain = train, held
    masked = any(r.kind in MASKED for r in repairs)
    if masked:
        as_read = (
            [open_samples(log, robot, uncut, mask_faults=False)[0] for log in group]
            for group in recorded
        )
        plain = next(as_read), next(as_read)
    train, held, more = join_bands(train, held)
    unmended = plain if masked or more else None
    logs, done = [*chain(*recorded)], (*repairs, *more)
    changed = [*mended_channels(zip(logs, (*train, *held), strict=True), done, robot.sigma)]
    return _Opened(train, held, done, changed, unmended)


@dataclass(frozen=True, eq=False)
class _Question:
    """What is diagnosed: a model, its logs in the band, and the effects to try."""

    robot: Robot
    evaluator: Evaluator
    opened: _Opened
    band_of: Callable[[Sequence[Samples]], Band]
    given: FloatArray | None
    effects: Sequence[str] | None
    least: float
    misfit: float
    progress: Callable[[str], None]

    @cached_property
    def band(self) -> Band:
        """The band of the logs as they are."""
        return self.band_of(self.opened.train)

    @cached_property
    def logs(self) -> tuple[list[FilteredLog], list[FilteredLog]]:
        """The training and validation logs in the band."""
        return _in_band((self.opened.train, self.opened.held), self.band)

    def fitted(self, logs: tuple[list[FilteredLog], list[FilteredLog]]) -> Baseline:
        """Return the model on logs; without validation logs, their last fifth measures the gap."""
        train, held = logs
        if not held:
            groups = hold_out([log.samples for log in train])
            train, held = (
                [_part(log, s) for log, s in zip(train, group, strict=True)] for group in groups
            )
        return baseline(self.evaluator, train, held, self.given)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the repairs of the logs."""
        opened = self.opened
        notes = tuple(note for s in (*opened.train, *opened.held) for note in s.notes)
        notes += opened.notes
        notes += (*(r.in_words for r in opened.repairs), f"band: {self.band.in_words()}")
        if opened.held:
            return notes
        return (
            *notes,
            "no validation log is given: the torque error is that of the last fifth of each log",
        )

    @cached_property
    def baseline(self) -> Baseline:
        """The model on the repaired logs."""
        return self.fitted(self.logs)

    @cached_property
    def declared(self) -> Diagnosis:
        """The declared model, on the repaired logs."""
        return plain(self.baseline, self.notes, self.least)

    @cached_property
    def raw(self) -> Diagnosis | None:
        """The declared model on the logs as recorded.

        None if nothing was repaired, or if these logs determine no model.
        """
        if self.opened.unmended is None:
            return None
        logs = _in_band(self.opened.unmended, replace(self.band, velocity="measured"))
        try:
            return plain(self.fitted(logs), self.notes)
        except IdentificationError:
            return None

    @cached_property
    def repaired(self) -> Diagnosis:
        """The declared model on the repaired logs, with measured speeds as in `raw`.

        Derived speeds may be better without any repair.
        """
        if self.band.velocity == "measured":
            return self.declared
        opened = self.opened.train, self.opened.held
        logs = _in_band(opened, replace(self.band, velocity="measured"))
        return plain(self.fitted(logs), self.notes)

    @cached_property
    def rests(self) -> tuple[str, ...]:
        """Notes on joints at rest."""
        return rests_in_words([*self.opened.train, *self.opened.held], self.robot)

    @cached_property
    def physics(self) -> Diagnosis:
        """The diagnosis of the physics on the repaired logs."""
        return self.searched(self.baseline)

    def searched(self, model: Baseline, repaired: Sequence[str] = ()) -> Diagnosis:
        """Search for missing physics in logs; `repaired` lists the faults undone in them."""
        given, bent = model.given, stiffnesses(model.base)
        pool = (
            *candidates(self.robot, model.base.logs, self.effects, given=given),
            *special_candidates(self.robot, bent, self.effects, given=given),
        )
        expressions = not given and (self.effects is None or "unnamed" in self.effects)
        contacts = self.effects is None or CONTACT in self.effects
        search = Search(model, pool, expressions, contacts, self.least, self.misfit, self.progress)
        selection = search.run()
        self.progress("deriving, compiling and identifying the extended model")
        notes = (*self.notes, *(f"repaired: {fault}" for fault in repaired), *self.rests)
        if not bent and self.effects is not None and STIFFNESS in self.effects:
            notes += (
                f"{STIFFNESS}: without a second encoder (qs1.., on the link side) it shows only "
                "near its resonance",
            )
        found = conclude(model, selection, notes, self.least, self.misfit, search.probable)
        return with_stiffness(found, self.robot, bent)

    def undone(
        self, faults: Sequence[Fault], lasting: Sequence[Fault]
    ) -> tuple[Baseline, Sequence[FilteredLog]]:
        """Return the model on the corrected logs, and the corrected training logs.

        Validation logs may be without a fault of the training logs. They are corrected if the model
        then predicts them better.
        """
        train, held = ([undo_faults(log, faults)[0] for log in group] for group in self.logs)
        if any(f.kind == "delay" for f in faults):  # the band was not selected by a model
            recorded = [log.samples for log in train], [log.samples for log in held]
            train, held = _in_band(recorded, self.band_of(recorded[0]))
        fixed = self.fitted((train, held))
        if not held or not lasting:
            return fixed, train
        other = self.fitted((train, self.logs[1]))
        return min(fixed, other, key=lambda b: plain(b, self.notes).before.total), train

    def unsearched(self, faults: Sequence[Fault], lasting: Sequence[Fault]) -> Diagnosis:
        """Return the declared model with the faults named, on logs that determine nothing else."""
        whole, before = replace(self.declared, advice=()), self.declared.before
        named = named_effects(faults, self.robot, before, before)
        says = (*(f.fault for f in faults), "symgen searches for no effects in a faulty log")
        whole = replace(whole, where=places_of(faults, before, self.robot))
        return with_chain(whole, named, before, 0.0, says, lasting)

    def answer(self, faults: Sequence[Fault], lasting: Sequence[Fault] = ()) -> Diagnosis:
        """Undo the faults whose correction closes a part of the gap, then search for physics.

        Args:
            faults: faults of the logs, each with its correction.
            lasting: those that need a new record. They are corrected and named in any case.
        """
        named: list[FoundEffect] = []
        says: tuple[str, ...] = ()
        whole, closes = None, 0.0
        if faults:
            fixed, train = self.undone(faults, lasting)
            undone, was = plain(fixed, self.notes), self.declared.before
            left = undone.after if any(f.undo for f in faults) else was
            if lasting or matters(self.declared.moving[0], undone.moving[0], self.least):
                share = closed(was, left)
                named = named_effects(faults, self.robot, was, left)
                says = tuple(f.fault for f in faults if not is_effect(f))
                closes = share if says else 0.0
                pairs, told = (
                    zip(self.logs[0], train, strict=True),
                    [replace(f, done="corrected for the search") for f in faults],
                )
                drawn = mended_channels(pairs, told, self.robot.sigma)
                whole = self.searched(fixed, [f.fault for f in faults])
                whole = replace(whole, mended=tuple(drawn))
                if lasting:
                    whole = replace(whole, where=places_of(faults, was, self.robot))
        whole = whole or self.physics
        if self.raw is not None:
            repairs = self.opened.repairs
            logs = [*chain(*self.logs)]
            named += mended(repairs, logs, self.robot, self.raw, self.repaired, self.least)
        if named or says:
            first = whole if self.given is not None else self.raw or self.declared
            whole = with_chain(whole, named, first.before, closes, says, lasting)
        if self.rests and whole.verdict in ("unexplained", "partly-explained"):
            whole = replace(whole, advice=(*whole.advice, *self.rests))
        return whole


def _in_band(groups: Groups, band: Band) -> tuple[list[FilteredLog], list[FilteredLog]]:
    train, held = ([filter_log(s, band) for s in group] for group in groups)
    return train, held


def _part(log: FilteredLog, samples: Samples) -> FilteredLog:
    """Return a log with some of its samples, in the band of the whole log."""
    first = int(np.searchsorted(log.t, samples.t[0]))
    span = slice(first, first + len(samples.t))
    return replace(log, samples=samples, q=log.q[span], qd=log.qd[span])
