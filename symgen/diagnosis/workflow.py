"""diagnose: compare, locate, name, add, show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import derive
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.diagnosis.baseline import KERNELS, Study, studied
from symgen.diagnosis.candidates import candidates
from symgen.diagnosis.chance_test import beyond_misfit
from symgen.diagnosis.conclusion import conclude, plain
from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect, Gap
from symgen.diagnosis.evidence import Scene, scene
from symgen.diagnosis.measuring_chain import (
    check,
    closed,
    corrected,
    is_effect,
    judged,
    mended,
    name_of,
    rejected,
    rivals_physics,
    with_chain,
)
from symgen.diagnosis.mended import MendedChannel, largest, mended_channels, undone_channels
from symgen.diagnosis.model_based_effects import special_candidates
from symgen.diagnosis.search import Search
from symgen.diagnosis.sparse_terms import with_unnamed
from symgen.diagnosis.stiffness import NAME as STIFFNESS
from symgen.diagnosis.stiffness import has_links, stiffnesses, with_stiffness
from symgen.errors import IdentificationError, ParameterError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered import filtered
from symgen.estimation.logs import (
    HELD_OUT,
    Source,
    listed_logs,
    open_log,
    require_logs,
    require_other_data,
)
from symgen.estimation.masking import rests_in_words
from symgen.faults.fault import MASKED, Fault
from symgen.faults.logs import in_one_band, open_logs, open_samples
from symgen.identification.parameters import read_given
from symgen.robot.effect import definitions
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
#: Share of the square of the gap that undoing a fault of the measuring chain has to close.
_CLOSES = 0.1
#: Gaps that are as good as equal.
_ALIKE = 1.05


def diagnose(
    robot: Robot | str | Path,
    logs: Sequence[Source] | Source,
    *,
    validation: Sequence[Source] | Source = (),
    effects: Sequence[str] | None = None,
    parameters: str | Path | None = None,
    cutoff: float | None = None,
    reading: Reading | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find where a model and measured data disagree, and name what is missing.

    Effects of the robot whose constants are ranges are tried beside the library. The model is
    identified from the logs by the torque equations in the motion's band, or has
    given parameters, of an earlier state of the robot, and the logs show what changed; candidates
    are accepted by the rule of `symgen.diagnosis.select`; the extended model is derived, compiled
    and identified again; the gap is shown on data that the selection never saw.

    Args:
        robot: a robot, a path or a library name.
        logs: paths of logs, or logs, to diagnose.
        validation: logs that show the gap; without any, the last fifth of each log.
        effects: names of effects to try; None for the whole library and the robot's own.
        parameters: parameters that are not identified again: the folder that `identify` wrote, its
            estimate.json, TOML with [parameters], or the URDF of the robot.
        cutoff: of the zero-phase low-pass, Hz; None for the motion's bandwidth.
        reading: how logs are read, and what of them has no say.
        progress: is told what is being tried.

    Raises:
        LogError: a log cannot be read or belongs to another robot.
        ParameterError: there is no such effect, or the parameters are not this robot's.
        IdentificationError: the logs do not determine the parameters.
    """
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    library = dict.fromkeys((*definitions(), *(s.effect.name for s in source.sought)))
    unknown = [name for name in effects or () if name not in library]
    if unknown:
        raise ParameterError(f"effect {unknown[0]!r}; accepted: {', '.join(library)}")
    progress("deriving and compiling the model")
    evaluator = load(derive(replace(source, sought=()), KERNELS))
    known = None if parameters is None else read_given(parameters, evaluator.model)
    given = None if known is None else known.X
    look = _look(source, logs, validation, reading, progress)
    stated = None if known is None else known.band
    band = stated or choose_band(evaluator, look.train, cutoff)
    band = band if cutoff is None else replace(band, cutoff_hz=cutoff)
    train, held, notes = _scenes(look, band)
    asked = _Asked(source, evaluator, look, band, train, held, given, effects, notes, progress)
    progress("checking the logs")
    faults = check(evaluator, [s.log for s in train], [s.log for s in held if look.held])
    if any(f.undo is None for f in faults):  # nothing can be said until it is recorded again
        try:
            found = judged(faults, asked.declared, asked.declared)
            return _with_left_out(found, source)
        except IdentificationError as error:  # a dead channel leaves nothing to identify
            raise IdentificationError(f"{faults[0].fault} ({error})") from error
    whole = asked.answer(faults)
    rivals = [f for f in faults if rivals_physics(f)]
    if rivals:
        sure = [f for f in faults if not rivals_physics(f)]
        whole = _of_rivals(whole, asked.answer(sure), rivals, source)
    drawn = (*whole.mended, *_mended(look, source, (logs, validation), reading))
    whole = replace(whole, repairs=look.repairs, mended=largest(drawn))
    return _with_left_out(whole, source)


def _mended(
    look: _Look,
    robot: Robot,
    groups: tuple[Sequence[Source] | Source, ...],
    reading: Reading | None,
) -> tuple[MendedChannel, ...]:
    """Return the channels of the logs that were mended, beside how they were recorded."""
    named = {r.log for r in look.repairs}
    sources = [s for group in groups for s in listed_logs(group)]
    pairs = zip(sources, (*look.train, *look.held), strict=True)
    logs = ((open_log(s, robot, reading), used) for s, used in pairs if used.name in named)
    return mended_channels(logs, look.repairs, robot.sigma)


def _of_rivals(
    undone: Diagnosis, physics: Diagnosis, faults: Sequence[Fault], robot: Robot
) -> Diagnosis:
    """Return what leaves the smaller gap: the faults undone, or what physics makes of them.

    Physics is named where both do the same: it needs no part of the recorder to be wrong. Where it
    names one of the faults itself, that is undone.
    """
    same = {*map(name_of, faults)} & {e.name for e in physics.effects}
    if same or physics.after.total > _ALIKE * undone.after.total:
        return undone
    percent = 100 * undone.after.total
    so = f": undone, {percent:.3g} % of the torque is left; {_without(physics)}"
    told = (rejected(f, robot, so) for f in faults)
    return replace(physics, rejected=(*told, *physics.rejected))


def _without(physics: Diagnosis) -> str:
    names = ", ".join(dict.fromkeys(e.name for e in physics.effects)) or "the model alone"
    return f"with {names} in its place {100 * physics.after.total:.3g} %"


def _with_left_out(diagnosis: Diagnosis, robot: Robot) -> Diagnosis:
    """Note which effects of the robot file the extended robot is without."""
    named = {(e.name, joint) for e in diagnosis.effects for joint in e.joints}
    left = [s.key for s in robot.sought if s.key not in named]
    if not left:
        return diagnosis
    listed = ", ".join(f"{name} on joint {joint}" for name, joint in left)
    note = f"not named, hence not in the extended robot.toml: {listed}"
    return replace(diagnosis, notes=(*diagnosis.notes, note))


@dataclass(frozen=True, eq=False)
class _Look:
    """The logs as they were read and mended."""

    train: list[Samples]
    held: list[Samples]
    repairs: tuple[Fault, ...]
    unmended: _Look | None = None


def _look(
    robot: Robot,
    logs: Sequence[Source] | Source,
    validation: Sequence[Source] | Source,
    reading: Reading | None,
    progress: Callable[[str], None],
) -> _Look:
    """Read and mend the logs."""
    require_logs(listed_logs(logs))
    sources = listed_logs(logs), listed_logs(validation)
    (train, held), done = open_logs(sources, robot, reading, progress)
    require_other_data(train, held)
    raw = None
    plain = [train, held]
    if any(r.kind in MASKED for r in done):
        plain = [
            [open_samples(s, robot, reading, mask_faults=False)[0] for s in group]
            for group in sources
        ]
    train, held, more = in_one_band(train, held)
    if more or plain[0] is not train:
        raw = _Look(plain[0], plain[1], ())
    return _Look(train, held, (*done, *more), raw)


@dataclass(frozen=True, eq=False)
class _Asked:
    """What is diagnosed: a model, its logs in the band, and what may be named."""

    robot: Robot
    evaluator: Evaluator
    look: _Look
    band: Band
    train: list[Scene]
    held: list[Scene]
    given: FloatArray | None
    effects: Sequence[str] | None
    notes: tuple[str, ...]
    progress: Callable[[str], None]

    @cached_property
    def study(self) -> Study:
        return studied(self.evaluator, self.train, self.held, self.given)

    @cached_property
    def declared(self) -> Diagnosis:
        """The model as it is declared, on the logs as they are."""
        return plain(self.study, self.notes)

    @cached_property
    def raw(self) -> Gap | None:
        """The gap on the logs as they were recorded, where anything was mended."""
        if self.look.unmended is None:
            return None
        band = replace(self.band, velocity="measured")
        train, held, _ = _scenes(self.look.unmended, band)
        return plain(studied(self.evaluator, train, held, self.given), self.notes).before

    @property
    def unseen(self) -> tuple[str, ...]:
        """What was asked for and these logs cannot show well, in words."""
        lone = not any(has_links(self.train, j) for j in range(self.robot.n))
        if lone and self.effects is not None and STIFFNESS in self.effects:
            return (
                f"{STIFFNESS}: without a second encoder (qs1.., on the link side) it shows near "
                "its resonance alone",
            )
        return ()

    def answer(self, faults: Sequence[Fault]) -> Diagnosis:
        """Undo faults where that closes a part of the gap, and look for physics behind them."""
        study, notes = self.study, self.notes
        named: list[FoundEffect] = []
        drawn: tuple[MendedChannel, ...] = ()
        says: tuple[str, ...] = ()
        closes = 0.0
        if faults:
            train, held = (corrected(faults, group) for group in (self.train, self.held))
            fixed = studied(self.evaluator, train, held, self.given)
            repaired = judged(faults, self.declared, plain(fixed, notes))
            share = closed(repaired.before, repaired.after)
            if share >= _CLOSES:
                named, study = list(repaired.effects), fixed
                drawn = undone_channels(self.train, train, self.robot.sigma)
                notes += tuple(f"repaired: {f.fault}" for f in faults)
                says = tuple(f.fault for f in faults if not is_effect(f))
                closes = share if says else 0.0
        if self.raw is not None:
            named += mended(self.look.repairs, self.robot, self.raw, self.declared.before, _CLOSES)
        pool = chain.from_iterable(
            make(self.robot, study.base, self.effects, given=self.given is not None)
            for make in (candidates, special_candidates)
        )
        search = Search(study.base, pool, study.torques, self.progress)
        selection, noise = search.run(), study.noise()
        if self.given is None and (self.effects is None or "unnamed" in self.effects):
            selection = with_unnamed(selection, self.robot, search, noise, self.progress)
        if self.given is None:
            selection = beyond_misfit(selection, search, noise)
        self.progress("deriving, compiling and identifying the extended model")
        rests = rests_in_words([*self.look.train, *self.look.held], self.robot)
        whole = conclude(study, selection, (*notes, *rests, *self.unseen))
        whole = with_stiffness(whole, self.robot, stiffnesses(study.base))
        whole = replace(whole, mended=drawn)
        if named or says:
            before = self.declared.before if self.raw is None else self.raw
            before = before if self.given is None else whole.before
            whole = with_chain(whole, named, before, closes, says)
        if rests and whole.verdict in ("unexplained", "partly-explained"):
            whole = replace(whole, advice=(*whole.advice, *rests))
        return whole


def _scenes(look: _Look, band: Band) -> tuple[list[Scene], list[Scene], tuple[str, ...]]:
    """Return what is searched, what the gap is shown on, and what was done to the logs."""
    given = [scene(filtered(s, band)) for s in look.train]
    held = [scene(filtered(s, band)) for s in look.held]
    notes = tuple(note for s in (*look.train, *look.held) for note in s.notes)
    notes += (*(r.in_words for r in look.repairs), f"band: {band.in_words()}")
    if held:
        return given, held, notes
    train, late = [], []
    for s in given:
        cut = s.t[0] + (1 - HELD_OUT) * (s.t[-1] - s.t[0])
        train.append(s.cut(float(s.t[0]), float(cut)))
        late.append(replace(s.cut(float(cut), float(s.t[-1])), name=f"{s.name} (last fifth)"))
    note = "no validation log is given: the gap is that of the last fifth of each log"
    return train, late, (*notes, note)
