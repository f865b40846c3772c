"""The declared model, its training and validation logs, and its torque along them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.diagnosis.effects import Score, Seen, Torques
from symgen.diagnosis.rests import RestingLogs, resting_logs, static_friction
from symgen.diagnosis.whitened_system import (
    WhitenedSystem,
    estimated,
    fitted_system,
    given_system,
    model_torque,
    modelled,
    torque_at,
    whitened,
)
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.misfit_evidence import MisfitEvidence
from symgen.estimation.predictive_score import PredictiveScore, Rests, dense, motion_folds
from symgen.estimation.system import torque_rows
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault, undo_faults
from symgen.identification.parameters import regrouping
from symgen.identification.segments import load_model
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.symbolic.variation import link_values

KERNELS = ("torque_regressor", "inverse_dynamics")


def model_of(robot: Robot) -> Evaluator:
    """Return the compiled model of a robot. Robots with the same file content share one model."""
    return load_model(robot_toml(robot), KERNELS)


@dataclass(frozen=True, eq=False)
class Baseline:
    """The start of a search: the declared model, its logs, and the rows of its equations.

    Attributes:
        evaluator: the declared model, compiled.
        base: the whitened equations of the declared model on the training logs.
        held: the validation logs, on which the gap is measured.
        X: (p,) parameters of the model: fitted to the training logs, or given.
        given: true if the parameters are given, false if they are fitted.
    """

    evaluator: Evaluator
    base: WhitenedSystem
    held: tuple[FilteredLog, ...]
    X: FloatArray
    given: bool

    @property
    def robot(self) -> Robot:
        """The robot as its file declares it."""
        return self.evaluator.model.robot

    def torques(self, found: WhitenedSystem) -> Sequence[Torques]:
        """Return the model's torque along every training log, at a reduced rate.

        Args:
            found: the equations, with the columns of the effects that were accepted so far.
        """
        X = self.parameters(found)
        return [self.torques_along(log.thinned, X) for log in self.base.logs]

    def torques_along(
        self,
        log: FilteredLog,
        X: FloatArray,
        extended: Evaluator | None = None,
        inside: FloatArray | None = None,
    ) -> Torques:
        """Return a model's torque along a log.

        Args:
            log: a log in the band of the run.
            X: (p,) parameters of the declared model, or of the extended one.
            extended: the extended model; None for the declared one.
            inside: (p,) parameters of the declared model from which link parameters in columns are
                taken; None for X.
        """
        whole, load = _split(extended or self.evaluator, X, log)
        friction = np.subtract(*_split(self.evaluator, self.X, log))
        links = link_values(self.robot, self.evaluator.model.base, X if inside is None else inside)
        return Torques(whole, load, friction, links, self._of_links)

    def _of_links(
        self, links: FloatArray, q: FloatArray, qd: FloatArray, qdd: FloatArray
    ) -> FloatArray:
        """Return the torque (k, n) of links with parameters (links, 10), without friction."""
        return torque_at(self.evaluator, self._regrouping @ links.ravel(), q, qd, qdd)

    @cached_property
    def _regrouping(self) -> FloatArray:
        """(p, 10 links) matrix from link parameters to base parameters."""
        model = self.evaluator.model
        at = {p.name: k for k, p in enumerate(model.base.standard)}
        own = [at[f"{key}{joint.number}"] for joint in self.robot.moving for key in names.LINK]
        return regrouping(model)[:, own]

    def seen(self, found: WhitenedSystem) -> Seen:
        """Return what gives columns of candidates on the training logs, see `torques`.

        The speed of a joint at rest is set to zero.
        """
        return Seen(self.halted, self.torques(found))

    @property
    def halted(self) -> tuple[FilteredLog, ...]:
        """The training logs, with the speed of joints at rest set to zero."""
        return self.base.logs if self._resting is None else self._resting.halted

    @cached_property
    def of_held(self) -> WhitenedSystem:
        """The whitened equations of the declared model on the validation logs."""
        return _system(self.evaluator, self.held, self.X if self.given else None)

    def parameters(self, found: WhitenedSystem) -> FloatArray:
        """Return X (p,), fitted together with the columns of `found`."""
        return self.X if self.given else found.X[: len(self.X)]

    def coefficients(self, found: WhitenedSystem) -> FloatArray:
        """Return the coefficients of the accepted effects, one effect after the other."""
        return found.X[self.base.W.shape[2] :]

    def beside(self, accepted: Iterable[Score]) -> WhitenedSystem:
        """Return the equations of the model with the columns of some effects added."""
        return self.base.with_columns(s.columns for s in accepted)

    def without(self, faults: Iterable[Fault]) -> Baseline:
        """Return the model on training logs whose samples with faults are left out."""
        faults = [*faults]
        if not faults:
            return self
        logs = tuple(undo_faults(log, faults)[0] for log in self.base.logs)
        base = whitened(logs, self.base.W, self.base.y)
        out = replace(self, base=base, X=self.X if self.given else estimated(base).X)
        for same in ("_folds", "features"):
            out.__dict__[same] = getattr(self, same)
        return out

    def score(
        self, found: WhitenedSystem, misfit: float, accepted: Sequence[Score] | None = None
    ) -> PredictiveScore:
        """Return the predictive score by which candidates beside `found` compete.

        Args:
            found: the equations, with the columns of the effects that were accepted so far.
            misfit: smallest model error to expect, as a part of a joint's torque.
            accepted: these effects; None leaves out samples at rest.
        """
        left = found.y - found.W @ found.X
        size = misfit * self.base.size
        rests = None if accepted is None else self._rests(found, accepted)
        return PredictiveScore(found.W, left, found.moves, found.sigma, self._folds, size, rests)

    def beside_misfit(self, found: WhitenedSystem, misfit: float) -> MisfitEvidence:
        """Return what says whether columns beside `found` are more than misfit.

        Args:
            found: the equations, with the columns of the effects that were accepted so far.
            misfit: model error to expect, as a part of a joint's torque.
        """
        left = found.y - found.W @ found.X
        size, random = misfit * self.base.size, np.concatenate(self.features)
        return MisfitEvidence(found.W, left, found.moves, found.sigma, random, size)

    @cached_property
    def _resting(self) -> RestingLogs | None:
        return resting_logs(self.base.logs)

    @cached_property
    def _still(self) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """(R, p) regressor, (R,) torque and (K, n) torques at creeping speed, at rests."""
        resting = self._resting
        assert resting is not None
        X = np.pad(self.X, (0, len(self.evaluator.model.base.parameters) - len(self.X)))
        model = partial(torque_at, self.evaluator, X)
        torques = [np.concatenate([modelled(s, model) for s in x]) for x in resting.creeping]
        if self.given:
            halted = given_system(self.evaluator, resting.halted, self.X)
            return resting.means(halted.W), resting.means(halted.y), torques
        W = np.concatenate([torque_rows(self.evaluator, s.unmasked, X) for s in resting.halted])
        return resting.means(W), resting.means(self.base.y), torques

    def _rests(self, found: WhitenedSystem, accepted: Sequence[Score]) -> Rests | None:
        """Return the equations at rest; None if the fit contains only samples at rest."""
        resting = self._resting
        if resting is None or np.any(resting.means(found.moves)):
            return None
        W, y, creeping = self._still
        at = [W]
        if accepted:
            torques, shape = self.torques(found), found.y.shape
            chosen, coefficients = [s.candidate for s in accepted], self.coefficients(found)
            columns, *slow = (
                np.concatenate([dense(c, shape) for c in Seen(logs, torques).each(chosen)], axis=2)
                for logs in (resting.halted, *resting.creeping)
            )
            at.append(resting.means(columns))
            creeping = [t + c @ coefficients for t, c in zip(creeping, slow, strict=True)]
        whole = np.concatenate(at, axis=1)
        limit = static_friction(resting, creeping)
        return Rests(resting.joint, resting.rows, whole, y - whole @ found.X, limit)

    @cached_property
    def features(self) -> list[FloatArray]:
        """Random functions of the state of each training log, (K, n, m), that stand for misfit."""
        known = features_of(self.base.logs, self.robot.sigma)
        return [known.in_band(log.unmasked.modelled) for log in self.base.logs]

    @cached_property
    def _folds(self) -> NDArray[np.intp]:
        return motion_folds(self.base.logs)


def baseline(
    evaluator: Evaluator,
    train: Sequence[FilteredLog],
    held: Sequence[FilteredLog],
    given: FloatArray | None = None,
) -> Baseline:
    """Fit a model to the training logs, or take given parameters (p,)."""
    base = _system(evaluator, train, given)
    X = estimated(base).X if given is None else given
    return Baseline(evaluator, base, tuple(held), X, given is not None)


def _system(
    evaluator: Evaluator, logs: Sequence[FilteredLog], given: FloatArray | None
) -> WhitenedSystem:
    """Return the equations of a model on some logs, with fitted or given parameters."""
    if given is None:
        return fitted_system(evaluator, logs)
    return given_system(evaluator, logs, given)


def _split(evaluator: Evaluator, X: FloatArray, log: FilteredLog) -> tuple[FloatArray, FloatArray]:
    """Return the torque of a model along a log, and its rigid-body part, (N, n) each."""
    rigid = np.where(np.arange(len(X)) < evaluator.model.inertial, X, 0.0)
    return model_torque(evaluator, X, log), model_torque(evaluator, rigid, log)
