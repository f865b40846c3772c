"""diagnose: compare, locate, name, add, show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import derive
from symgen.data.log import Log
from symgen.data.signals import Samples, prepare
from symgen.diagnosis.candidates import Candidate, Torques, candidates
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
    Scene,
    evidence,
    given_evidence,
    ratio,
    regressor,
    scene,
)
from symgen.diagnosis.extend import extended
from symgen.diagnosis.gate import check, corrected, judged
from symgen.diagnosis.given import changed, link_values
from symgen.diagnosis.portrait import places
from symgen.diagnosis.select import MEASURING, Score, Search, Selection, dense
from symgen.diagnosis.special import special_candidates
from symgen.diagnosis.unnamed import with_unnamed
from symgen.diagnosis.words import tie
from symgen.errors import IdentificationError, LogError, ParameterError
from symgen.identification.batch import Solution, solve
from symgen.identification.parameters import read_parameters
from symgen.identification.system import Equations, LinearSystem
from symgen.identification.validation import open_log
from symgen.robot.effect import definitions, numbered, unit
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
Source = str | Path | Log
_HELD_OUT = 0.2
_KERNELS = ("torque_regressor", "inverse_dynamics")
#: Gap over noise floor up to which nothing is missing, where no effect is found.
_QUIET = 3.0
_SHOWN = 12
_SETTLING = 4


def diagnose(
    robot: Robot | str | Path,
    logs: Sequence[Source] | Source,
    *,
    validation: Sequence[Source] | Source = (),
    effects: Sequence[str] | None = None,
    parameters: str | Path | None = None,
    cutoff: float | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find where a model and measured data disagree, and name what is missing.

    The model is identified from the logs by the torque equations in the motion's band, or has
    given parameters, of an earlier state of the robot, and the logs show what changed; candidates
    are accepted by the rule of `symgen.diagnosis.select`; the extended model is derived, compiled
    and identified again; the gap is shown on data that the selection never saw.

    Args:
        robot: a robot, a path or a library name.
        logs: paths of logs, or logs, to diagnose.
        validation: logs that show the gap; without any, the last fifth of each log.
        effects: names of effects to try; None for the whole library.
        parameters: a file of parameters that are not identified again: an estimate.json, TOML
            with [parameters], or the URDF of the robot.
        cutoff: of the zero-phase low-pass, Hz; None for the motion's bandwidth.
        progress: is told what is being tried.

    Raises:
        LogError: a log cannot be read or belongs to another robot.
        ParameterError: there is no such effect, or the parameters are not this robot's.
        IdentificationError: the logs do not determine the parameters.
    """
    unknown = [name for name in effects or () if name not in definitions()]
    if unknown:
        raise ParameterError(f"effect {unknown[0]!r}; accepted: {', '.join(definitions())}")
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    progress("deriving and compiling the model")
    evaluator = load(derive(source, _KERNELS))
    given = None if parameters is None else read_parameters(parameters, evaluator.model)
    train, held, notes, samples = _scenes(source, logs, validation, cutoff, progress)
    study = _Study(evaluator, train, held, given)
    progress("checking the logs")
    later = [*zip(samples[len(train) :], held, strict=False)]
    faults = check(evaluator, study.base, samples[: len(train)], later)
    if faults:
        fixed = _Study(evaluator, corrected(faults, train), corrected(faults, held), given)
        try:
            return judged(faults, study.plain(notes), fixed.plain(notes))
        except IdentificationError as error:  # a dead channel leaves nothing to identify
            raise IdentificationError(f"{faults[0].says} ({error})") from error
    pool = chain.from_iterable(
        make(source, study.base, effects, given=given is not None)
        for make in (candidates, special_candidates)
    )
    selection = Search(study.base, pool, study.torques, progress).run()
    if given is None and (effects is None or "unnamed" in effects):
        selection = with_unnamed(selection, source, study.base, study.noise(), progress)
    progress("deriving, compiling and identifying the extended model")
    return study.conclude(selection, notes)


def _listed(logs: Sequence[Source] | Source) -> list[Source]:
    return [logs] if isinstance(logs, (str, Path, Log)) else list(logs)


def _scenes(
    robot: Robot,
    logs: Sequence[Source] | Source,
    validation: Sequence[Source] | Source,
    cutoff: float | None,
    progress: Callable[[str], None],
) -> tuple[list[Scene], list[Scene], tuple[str, ...], list[Samples]]:
    """Return what is searched, what the gap is shown on, what was done to the logs, and these."""
    if not _listed(logs):
        raise LogError("no log is given; accepted: one or more CSV, Parquet or NPZ files")

    def seen(source: Source) -> tuple[Scene, Samples]:
        progress(f"reading {getattr(source, 'name', source)}")
        samples = prepare(open_log(source, robot), cutoff)
        return scene(samples, cutoff), samples

    given = [seen(s) for s in _listed(logs)]
    held = [seen(s) for s in _listed(validation)]
    notes = tuple(note for _, s in (*given, *held) for note in s.notes)
    samples = [s for _, s in (*given, *held)]
    if held:
        band = min((s.band for s, _ in given if s.band), default=None)
        return (
            [s for s, _ in given],
            [scene(samples, cutoff or band) for _, samples in held],
            notes,
            samples,
        )
    train, late = [], []
    for s, _ in given:
        cut = s.t[0] + (1 - _HELD_OUT) * (s.t[-1] - s.t[0])
        train.append(s.cut(float(s.t[0]), float(cut)))
        late.append(replace(s.cut(float(cut), float(s.t[-1])), name=f"{s.name} (last fifth)"))
    note = "no validation log is given: the gap is that of the last fifth of each log"
    return train, late, (*notes, note), samples


class _Study:
    """One diagnosis: the model, the logs, and the model's torques on them."""

    def __init__(
        self,
        evaluator: Evaluator,
        train: Sequence[Scene],
        held: Sequence[Scene],
        given: FloatArray | None = None,
    ) -> None:
        self.evaluator, self.held, self.given = evaluator, tuple(held), given
        self.robot = evaluator.model.robot
        if given is None:
            self.base = evidence(evaluator, train)
        else:
            self.base = given_evidence(evaluator, train, given)
        self.X = self.base.X if given is None else given
        self._full = [regressor(evaluator, s) for s in train]

    def torques(self, accepted: Sequence[Score]) -> Sequence[Torques]:
        """Return the model's torque and its friction on every training log."""
        X = self._parameters(accepted)
        return [self._split(W, X) for W in self._full]

    def noise(self) -> FloatArray:
        """Return the standard deviation of each torque's noise in the band, (n,)."""
        pairs = zip(self.base.scenes, self._full, strict=True)
        parts = [_noise(s, s.tau - W @ self.base.X) ** 2 for s, W in pairs]
        return np.asarray(np.sqrt(np.mean(parts, axis=0)))

    def _parameters(self, accepted: Sequence[Score]) -> FloatArray:
        p = self.base.W.shape[2]
        if not accepted or self.given is not None:
            return self.X
        columns = [dense(s.columns, self.base.y.shape) for s in accepted]
        return self.base.with_columns(np.concatenate(columns, axis=2)).X[:p]

    def _settled(self, accepted: Sequence[Score]) -> Sequence[Score]:
        """Return the effects with the model's torque in their columns as it is beside them all."""
        for _ in range(_SETTLING if any(s.candidate.uses_model for s in accepted) else 0):
            torques = self.torques(accepted)
            accepted = [
                replace(s, columns=s.candidate.seen(self.base, torques))
                if s.candidate.uses_model
                else s
                for s in accepted
            ]
        return accepted

    def _split(self, W: FloatArray, X: FloatArray) -> Torques:
        model = self.evaluator.model
        first = model.inertial
        return Torques(W @ X, W[:, :, first:] @ X[first:], link_values(model, X))

    def plain(self, notes: tuple[str, ...]) -> Diagnosis:
        """Return what the model says as it is declared."""
        return self.conclude(Selection(self.base, (), (), (), 0), notes)

    def conclude(self, selection: Selection, notes: tuple[str, ...]) -> Diagnosis:
        """Add what was found, identify again, and measure the gap on the held-out data."""
        robot, names_ = self.robot, self.evaluator.model.base.names
        declared: list[Score] = []
        for score in selection.accepted:
            c = score.candidate
            more = extended(robot, c.definition, c.joints, c.constants)
            if more is not None:
                robot = more
                declared.append(score)
        corrected = [s for s in selection.accepted if s not in declared]
        evaluator, final = self.evaluator, self.base
        if self.given is not None:  # the effects' columns stand beside what is given
            corrected, names_ = list(selection.accepted), ()
        elif robot is not self.robot:
            evaluator = load(derive(robot, _KERNELS))
            names_ = evaluator.model.base.names
            final = evidence(evaluator, self.base.scenes)
        extra = [f"{s.candidate.name} {i}" for s in corrected for i in range(s.candidate.size)]
        if corrected:
            torques = self.torques(self._settled(selection.accepted))
            parts = [
                dense(s.candidate.seen(self.base, torques), self.base.y.shape) for s in corrected
            ]
            final = final.with_columns(np.concatenate(parts, axis=2))
        solution = _solved((*names_, *extra), final)
        before, after, floor, curves = self._gaps(evaluator, selection, corrected, solution)
        found = self._effects(selection, corrected, declared, names_, solution, evaluator)
        measuring = [s for s in selection.accepted if s.candidate.name in MEASURING]
        verdict = _verdict(selection, measuring, before, after, floor)
        std = np.sqrt(np.maximum(np.diag(solution.covariance), 0))
        X, model = solution.X, evaluator.model
        if self.given is not None:
            model = model if robot is self.robot else derive(robot, ())
            added = [p for e in found if e.declared for p in e.parameters]
            X = changed(self.evaluator.model, self.given, model, added)
            names_, std = model.base.names, np.full(len(X), np.nan)
        units = [p.unit for p in model.base.parameters]
        return Diagnosis(
            robot=self.robot.name,
            verdict=verdict,
            cutoff_hz=min((s.band for s in self.held if s.band), default=None),
            before=before,
            after=after,
            floor=floor,
            where=()
            if verdict == "consistent"
            else places(self.robot, self.base, self.torques(()), selection, before, floor),
            effects=found,
            rejected=tuple(
                Rejected(s.candidate.name, self._numbers(s.candidate), s.fault)
                for s in selection.rejected[:_SHOWN]
            ),
            advice=_advice(found, verdict),
            notes=notes,
            extended=robot,
            joints=tuple(j.number for j in self.robot.movable),
            curves=curves,
            tried=selection.tried,
            parameters=tuple(
                FoundParameter(name, float(x), float(s), u)
                for name, x, s, u in zip(names_, X, std, units, strict=False)
            ),
        )

    def _numbers(self, candidate: Candidate) -> tuple[int, ...]:
        return tuple(self.robot.movable[j].number for j in candidate.joints)

    def _gaps(
        self,
        evaluator: Evaluator,
        selection: Selection,
        corrected: Sequence[Score],
        solution: Solution,
    ) -> tuple[Gap, Gap, Gap, tuple[Curves, ...]]:
        """Return gap before, after, noise floor, and the curves, on the held-out data."""
        p = len(solution.X) - sum(s.candidate.size for s in corrected)
        X = solution.X[:p] if self.given is None else self.given
        inside = self._parameters(selection.accepted)  # of what stands in the effects' columns
        curves, noise, span = [], [], []
        for s in self.held:
            W0, W1 = regressor(self.evaluator, s), regressor(evaluator, s)
            before, whole = W0 @ self.X, W1 @ X
            rigid = evaluator.model.inertial
            links = self._split(W0, inside).links
            torques = Torques(whole.copy(), W1[:, :, rigid:] @ X[rigid:], links)
            at = p
            for score in corrected:
                columns = score.candidate.columns(s, torques)
                for j, c in columns.items():
                    whole[:, j] += c @ solution.X[at : at + score.candidate.size]
                at += score.candidate.size
            whole = s.limited(whole)
            seen = Curves(
                s.name,
                s.t[s.kept],
                s.q[s.kept],
                s.qd[s.kept],
                s.seen(s.tau),
                s.seen(before),
                s.seen(whole),
            )
            curves.append(seen)
            noise.append(_noise(s, s.tau - whole))
            span.append(len(seen.t))
        measured = np.concatenate([c.measured for c in curves])

        def gap(model: FloatArray) -> Gap:
            return Gap(tuple(map(float, ratio(measured - model, measured))))

        size = np.sqrt(np.mean(measured**2, axis=0))
        variance = np.average(np.square(noise), axis=0, weights=span)
        floor = np.sqrt(variance) / np.where(size > 0, size, np.inf)
        return (
            gap(np.concatenate([c.before for c in curves])),
            gap(np.concatenate([c.after for c in curves])),
            Gap(tuple(map(float, floor))),
            tuple(curves),
        )

    def _effects(
        self,
        selection: Selection,
        corrected: Sequence[Score],
        declared: Sequence[Score],
        names_: Sequence[str],
        solution: Solution,
        evaluator: Evaluator,
    ) -> tuple[FoundEffect, ...]:
        std = np.sqrt(np.maximum(np.diag(solution.covariance), 0))
        units = {p.name: p.unit for p in evaluator.model.base.parameters}
        place = {name: i for i, name in enumerate(names_)}
        at = {
            id(s): len(names_) + sum(c.candidate.size for c in corrected[:k])
            for k, s in enumerate(corrected)
        }
        out = []
        for score, alike in zip(selection.accepted, selection.alike, strict=True):
            c, d = score.candidate, score.candidate.definition
            numbers = self._numbers(c)
            suffix = numbers[-1] if numbers else ""
            sigma = self.robot.movable[c.joints[0]].sigma if c.joints else 0
            parameters = []
            library = tuple((f"{name}{suffix}", unit(w, sigma)) for name, w in d.linear.items())
            for i, (full, word) in enumerate(c.coefficients or library):
                if id(score) in at:
                    k = at[id(score)] + i
                    parameters.append(
                        FoundParameter(full, float(solution.X[k]), float(std[k]), word)
                    )
                elif full in place:
                    k = place[full]
                    parameters.append(
                        FoundParameter(full, float(solution.X[k]), float(std[k]), units[full])
                    )
            parameters += [
                FoundParameter(
                    f"{name}{suffix}", float(value), float("nan"), d.unit_of(name, sigma)
                )
                for name, value in c.constants.items()
            ]
            out.append(
                FoundEffect(
                    name=c.name,
                    joints=numbers,
                    parameters=tuple(parameters),
                    expression=numbered(d, suffix) or d.formula or d.says,
                    p_value=score.p_value,
                    gap_reduction=min(score.gain, 1.0),
                    indistinguishable_from=tuple(
                        (s.candidate.name, self._numbers(s.candidate)) for s in alike
                    ),
                    separate=d.separate if alike else "",
                    declared=score in declared,
                )
            )
        return tuple(out)


def _system(names_: tuple[str, ...], final: Evidence) -> LinearSystem:
    """Return the equations of the final model, log by log and joint by joint."""
    out, first = [], 0
    for s in final.scenes:
        t = s.t[s.kept]
        rows = slice(first, first + len(t))
        for j in range(final.n):
            moves = final.moves[rows, j] > 0
            W, y = final.W[rows, j][moves], final.y[rows, j][moves]
            out.append(Equations(s.name, W, y, t[moves], 2, j))
        first += len(t)
    return LinearSystem(names_, tuple(out))


def _solved(names_: tuple[str, ...], final: Evidence) -> Solution:
    """Solve the final model; nothing is identified where all is given and nothing was found."""
    if names_:
        return solve(_system(names_, final), "wls")
    return Solution(np.zeros(0), np.zeros((0, 0)), 1.0, ())


def _noise(s: Scene, error: FloatArray) -> FloatArray:
    """Return the standard deviation of torque noise in the band, (n,), from that above it.

    White noise of density D has D band in the band and D (Nyquist - band) above it.
    """
    if s.band is None:
        return np.zeros(error.shape[1])
    above = error - s.smooth(error)
    margin = int(1 / (s.band * s.step))
    inside = above[margin:-margin] if len(above) > 4 * margin else above
    nyquist = 0.5 / s.step
    out: FloatArray = np.sqrt(np.mean(inside**2, axis=0) * s.band / (nyquist - s.band))
    return out


def _verdict(
    selection: Selection, measuring: Sequence[Score], before: Gap, after: Gap, floor: Gap
) -> str:
    if measuring:
        return "bad-measurement"
    if not selection.accepted:
        return "consistent" if before.total <= _QUIET * max(floor.total, 1e-9) else "unexplained"
    return "explained" if after.total <= _QUIET * max(floor.total, 1e-9) else "partly-explained"


def _advice(found: Sequence[FoundEffect], verdict: str) -> tuple[str, ...]:
    out = [tie(e) for e in found if e.indistinguishable_from and e.separate]
    if verdict == "partly-explained":
        out.append("a part of the gap has no name: look at the portraits of the residual")
    if verdict == "unexplained":
        out.append(
            "no effect of the library explains the gap: look at the portraits of the residual"
        )
    return tuple(out)
