"""One diagnosis: what the model says on the logs, and the conclusion from what was found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import derive
from symgen.diagnosis.candidates import Candidate, Torques
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
)
from symgen.diagnosis.extend import extended
from symgen.diagnosis.floor import noise_floor
from symgen.diagnosis.given import changed, link_values
from symgen.diagnosis.portrait import places
from symgen.diagnosis.refine import settled_constants, slopes
from symgen.diagnosis.search import MEASURING, Selection
from symgen.diagnosis.select import Score, judge
from symgen.diagnosis.words import tie
from symgen.estimation.batch import solve
from symgen.estimation.regression import Solution
from symgen.estimation.system import Equations, LinearSystem
from symgen.robot.effect import numbered
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
KERNELS = ("torque_regressor", "inverse_dynamics")
#: Gap over noise floor up to which nothing is missing, where no effect is found.
_QUIET, _LOUD = 3.0, 5.0  # in all, on one joint
_SMALL = 0.01  # a gap that no model of friction comes below
_EXPLAINED = 0.15  # the largest gap that is called explained
_SHOWN = 12
_SETTLING = 4


class Study:
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
        self._full = [regressor(evaluator, s, self.X) for s in train]

    def torques(self, found: Evidence) -> Sequence[Torques]:
        """Return the model's torque and its friction on every training log, beside what is found.

        Args:
            found: the evidence with the columns of what was accepted so far.
        """
        X = self._parameters(found)
        return [self._split(W, X) for W in self._full]

    def noise(self) -> FloatArray:
        """Return the standard deviation of the residual that noise alone leaves, (n,)."""
        model = partial(_model_torque, self.evaluator, self.X)
        pairs = zip(self.base.scenes, self._full, strict=True)
        parts = [noise_floor(s, s.tau - W @ self.X, model, self.base.scenes) ** 2 for s, W in pairs]
        return np.asarray(np.sqrt(np.mean(parts, axis=0)))

    def _parameters(self, found: Evidence) -> FloatArray:
        return self.X if self.given is not None else found.X[: len(self.X)]

    def _beside(self, accepted: Sequence[Score]) -> Evidence:
        return self.base.with_columns(s.columns for s in accepted)

    def _settled(self, accepted: Sequence[Score]) -> Sequence[Score]:
        """Return the effects with the model's torque in their columns as it is beside them all."""
        for _ in range(_SETTLING if any(s.candidate.uses_model for s in accepted) else 0):
            torques = self.torques(self._beside(accepted))
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
        settled = self._settled(selection.accepted)
        torques = self.torques(self._beside(settled))
        settled = settled_constants(self.base, settled, lambda c: c.seen(self.base, torques))
        selection = replace(selection, accepted=tuple(settled))
        beside = self._coefficients(settled)
        declared: list[Score] = []
        for score, own in zip(selection.accepted, beside, strict=True):
            c = score.candidate
            values = {p.name: p.value for p in own} if self.given is None else {}
            more = extended(robot, c.definition, c.joints, c.constants, values)
            if more is not None:
                robot = more
                declared.append(score)
        corrected = [s for s in selection.accepted if s not in declared]
        evaluator, final = self.evaluator, self.base
        if self.given is not None:  # the effects' columns stand beside what is given
            corrected, names_ = list(selection.accepted), ()
        elif robot is not self.robot:
            evaluator = load(derive(robot, KERNELS))
            names_ = evaluator.model.base.names
            final = evidence(evaluator, self.base.scenes)
        extra = [f"{s.candidate.name} {i}" for s in corrected for i in range(s.candidate.size)]
        if corrected:
            final = final.with_columns(s.candidate.seen(self.base, torques) for s in corrected)
        solution = _solved((*names_, *extra), final)
        std = self._std(settled, torques, (*names_, *extra), final, solution)
        before, after, floor, curves = self._gaps(evaluator, selection, corrected, solution)
        if selection.accepted and after.total > before.total:
            return self.conclude(_withdrawn(selection, before, after), notes)
        found = self._effects(
            selection, beside, corrected, declared, names_, solution.X, std, evaluator
        )
        measuring = [s for s in selection.accepted if s.candidate.name in MEASURING]
        verdict = _verdict(selection, measuring, before, after, floor)
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
            else places(self.robot, self.base, self.torques(self.base), selection, before, floor),
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
            declared=self.robot,
            values=tuple(map(float, self.X)),
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
        if not selection.accepted:  # nothing changes, not even the weights of the joints
            X = self.X
        # What stands in the effects' columns.
        inside = self._parameters(self._beside(selection.accepted))
        curves, noise, span, free = [], [], [], []
        for s in self.held:
            W0, W1 = regressor(self.evaluator, s, self.X), regressor(evaluator, s, X)
            declared, whole = W0 @ self.X, W1 @ X
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
            before = s.modelled(partial(_torque, self.evaluator, self.X))
            differs = bool(selection.accepted) or s.limit is not None
            seen = Curves(
                s.name,
                s.t[s.kept],
                s.q[s.kept],
                s.qd[s.kept],
                s.seen(s.tau),
                before,
                before + s.seen(whole - declared) if differs else before,
                None if s.mask is None else s.free[s.kept],
            )
            curves.append(seen)
            others = (*self.base.scenes, *self.held)
            noise.append(
                noise_floor(s, s.tau - whole, partial(_model_torque, evaluator, X), others)
            )
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
        self,
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
        covariance = solution.covariance
        at, values, loose = self.base.W.shape[2], self._beside(settled).X, []
        for s in settled:
            own = values[at : at + s.candidate.size]
            loose.append(slopes(s, own, lambda c: c.seen(self.base, torques)))
            at += s.candidate.size
        known = [columns for columns in loose if columns is not None]
        if known:
            count = sum(next(iter(columns.values())).shape[1] for columns in known)
            more = tuple(f"constant {i}" for i in range(count))
            covariance = _solved((*names_, *more), final.with_columns(known)).covariance
        return np.asarray(np.sqrt(np.maximum(np.diag(covariance), 0)))

    def _coefficients(self, accepted: Sequence[Score]) -> list[list[FoundParameter]]:
        """Return the coefficients of each effect, all beside the declared model."""
        out, at = [], self.base.W.shape[2]
        values = self._beside(accepted).X
        for score in accepted:
            rest = self._beside([s for s in accepted if s is not score])
            c = score.candidate
            std = judge(rest, c, score.columns, 1).std
            triples = zip(self._named(c), values[at:], std, strict=False)
            out.append([FoundParameter(n, float(x), float(s), u) for (n, u), x, s in triples])
            at += c.size
        return out

    def _named(self, c: Candidate) -> tuple[tuple[str, str], ...]:
        """Return name and unit of every coefficient that means something."""
        return c.coefficients or c.definition.coefficients(self._suffix(c), self._sigma(c))

    def _suffix(self, c: Candidate) -> int | str:
        numbers = self._numbers(c)
        return numbers[-1] if numbers else ""

    def _sigma(self, c: Candidate) -> int:
        return self.robot.movable[c.joints[0]].sigma if c.joints else 0

    def _effects(
        self,
        selection: Selection,
        beside: Sequence[Sequence[FoundParameter]],
        corrected: Sequence[Score],
        declared: Sequence[Score],
        names_: Sequence[str],
        X: FloatArray,
        std: FloatArray,
        evaluator: Evaluator,
    ) -> tuple[FoundEffect, ...]:
        units = {p.name: p.unit for p in evaluator.model.base.parameters}
        place = {name: i for i, name in enumerate(names_)}
        at = {
            id(s): len(names_) + sum(c.candidate.size for c in corrected[:k])
            for k, s in enumerate(corrected)
        }
        out, loose = [], iter(std[len(X) :])
        for score, own, alike in zip(selection.accepted, beside, selection.alike, strict=True):
            c, d = score.candidate, score.candidate.definition
            numbers, suffix, sigma = self._numbers(c), self._suffix(c), self._sigma(c)
            parameters = []
            for i, first in enumerate(own):
                k = at[id(score)] + i if id(score) in at else place.get(first.name)
                word = units.get(first.name, first.unit) if id(score) not in at else first.unit
                if k is not None:
                    x, s = float(X[k]), float(std[k])
                    parameters.append(FoundParameter(first.name, x, s, word))
                elif not c.definition.native:  # part of the extended geometry or gravity
                    parameters.append(first)
            parameters += [
                FoundParameter(
                    d.named(name, suffix),
                    float(value),
                    float(next(loose)) if c.smooth else float("nan"),
                    d.unit_of(name, sigma),
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


def _withdrawn(selection: Selection, before: Gap, after: Gap) -> Selection:
    """Return a selection without effects: what made the gap on data that it never saw larger."""
    fault = (
        "accepted on the training log, but with what was accepted the gap on the validation data "
        f"grows from {100 * before.total:.2g} to {100 * after.total:.2g} %"
    )
    failed = tuple(replace(s, fault=fault) for s in selection.accepted)
    return replace(selection, accepted=(), alike=(), rejected=(*failed, *selection.rejected))


def _torque(
    evaluator: Evaluator, X: FloatArray, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Return the model's torque at some states, (k, n)."""
    return np.asarray(evaluator["inverse_dynamics"](q, qd, qdd, X))


def _model_torque(evaluator: Evaluator, X: FloatArray, s: Scene) -> FloatArray:
    """Return the model's torque at full rate, (N, n)."""
    return _torque(evaluator, X, s.q, s.qd, s.qdd)


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


def _advice(found: Sequence[FoundEffect], verdict: str) -> tuple[str, ...]:
    out = [tie(e) for e in found if e.indistinguishable_from and e.separate]
    if verdict == "partly-explained":
        out.append("a part of the gap has no name: look at the portraits of the residual")
    if verdict == "unexplained":
        out.append(
            "no effect of the library explains the gap: look at the portraits of the residual"
        )
    return tuple(out)
