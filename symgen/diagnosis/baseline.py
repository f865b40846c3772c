"""The model as it is declared, its logs, and the model's torques on them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
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
)
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.predictive_score import PredictiveScore, Rests, dense, motion_folds
from symgen.estimation.system import torque_rows
from symgen.estimation.values import FloatArray
from symgen.identification.out_of_core import load_model
from symgen.identification.parameters import regrouping
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator
from symgen.symbolic.variation import link_values

KERNELS = ("torque_regressor", "inverse_dynamics")


def model_of(robot: Robot) -> Evaluator:
    """Return the compiled model of a robot, derived once for a text of its file."""
    return load_model(robot_toml(robot), KERNELS)


@dataclass(frozen=True, eq=False)
class Baseline:
    """What a search begins with.

    Attributes:
        evaluator: the model as it is declared.
        base: what it leaves of the training logs.
        held: the logs that show the gap.
        X: (p,) parameters of the model: fitted to the training logs, or given.
        given: whether they are given.
    """

    evaluator: Evaluator
    base: WhitenedSystem
    held: tuple[FilteredLog, ...]
    X: FloatArray
    given: bool

    @property
    def robot(self) -> Robot:
        """The robot as it is declared."""
        return self.evaluator.model.robot

    def torques(self, found: WhitenedSystem) -> Sequence[Torques]:
        """Return the model's torques along every training log, thinned, beside what is found.

        Args:
            found: the system with the columns of what was accepted so far.
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
        """Return a model's torques along a log.

        Args:
            log: in the band of the run.
            X: (p,) parameters of the declared model, or of an extended one.
            extended: that one, compiled.
            inside: (p,) parameters of the declared model whose links stand in columns; None for X.
        """
        whole, load = _split(extended or self.evaluator, X, log)
        friction = np.subtract(*_split(self.evaluator, self.X, log))
        links = link_values(self.robot, self.evaluator.model.base, X if inside is None else inside)
        return Torques(whole, load, friction, links, self._of_links)

    def _of_links(
        self, links: FloatArray, q: FloatArray, qd: FloatArray, qdd: FloatArray
    ) -> FloatArray:
        """Return the torque (k, n) of links (links, 10) alone."""
        return torque_at(self.evaluator, self._regrouping @ links.ravel(), q, qd, qdd)

    @cached_property
    def _regrouping(self) -> FloatArray:
        """(p, 10 links) from parameters of the links to base parameters."""
        model = self.evaluator.model
        at = {p.name: k for k, p in enumerate(model.base.standard)}
        own = [at[f"{key}{joint.number}"] for joint in self.robot.joints for key in names.LINK]
        return regrouping(model)[:, own]

    def seen(self, found: WhitenedSystem) -> Seen:
        """Return what candidates show on the training logs beside what is found, see `torques`.

        A joint that stands has no speed.
        """
        return Seen(self.halted, self.torques(found))

    @property
    def halted(self) -> tuple[FilteredLog, ...]:
        """The training logs, without speed of joints that stand."""
        return self.base.logs if self._resting is None else self._resting.halted

    def system_of(self, logs: Sequence[FilteredLog]) -> WhitenedSystem:
        """Return the system of the declared model on some logs."""
        return _system(self.evaluator, logs, self.X if self.given else None)

    def parameters(self, found: WhitenedSystem) -> FloatArray:
        """Return X beside what is found, (p,)."""
        return self.X if self.given else found.X[: len(self.X)]

    def coefficients(self, found: WhitenedSystem) -> FloatArray:
        """Return the coefficients of what is found, one effect after the other."""
        return found.X[self.base.W.shape[2] :]

    def beside(self, accepted: Iterable[Score]) -> WhitenedSystem:
        """Return the system of the model with the columns of some effects."""
        return self.base.with_columns(s.columns for s in accepted)

    def score(
        self, found: WhitenedSystem, misfit: float, accepted: Sequence[Score] | None = None
    ) -> PredictiveScore:
        """Return what predicts the rows of a system: candidates beside it compete by it.

        Args:
            found: the system with the columns of what was accepted so far.
            misfit: part of a joint's torque that no model is righter than.
            accepted: that; None where rests have no say.
        """
        left = found.y - found.W @ found.X
        size = misfit * self.base.size
        rests = None if accepted is None else self._rests(found, accepted)
        return PredictiveScore(found.W, left, found.moves, found.sigma, self._folds, size, rests)

    @cached_property
    def _resting(self) -> RestingLogs | None:
        return resting_logs(self.base.logs)

    @cached_property
    def _still(self) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """The model at rests: regressor (R, p), torque (R,), and torque (K, n) creeping."""
        resting = self._resting
        assert resting is not None
        X = np.pad(self.X, (0, len(self.evaluator.model.base.parameters) - len(self.X)))
        model = partial(torque_at, self.evaluator, X)
        torques = [np.concatenate([modelled(s, model) for s in x]) for x in resting.creeping]
        if self.given:
            known = np.concatenate([modelled(s, model) for s in resting.halted])
            y = np.concatenate([s.unmasked.measured for s in resting.logs]) - known
            return np.zeros((len(resting.joint), 0)), resting.means(y), torques
        W = np.concatenate([torque_rows(self.evaluator, s.unmasked, X) for s in resting.halted])
        return resting.means(W), resting.means(self.base.y), torques

    def _rests(self, found: WhitenedSystem, accepted: Sequence[Score]) -> Rests | None:
        """Return what rests say beside what is found; None where the fit is made of them."""
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
    """Return the system of a model on some logs, fitted to them or of given parameters."""
    if given is None:
        return fitted_system(evaluator, logs)
    return given_system(evaluator, logs, given)


def _split(evaluator: Evaluator, X: FloatArray, log: FilteredLog) -> tuple[FloatArray, FloatArray]:
    """Return the torque of a model along a log, and what of it the rigid body asks, (N, n)."""
    rigid = np.where(np.arange(len(X)) < evaluator.model.inertial, X, 0.0)
    return model_torque(evaluator, X, log), model_torque(evaluator, rigid, log)
