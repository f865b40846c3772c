"""A problem: a model, its training and validation logs, and the changes that are undone.

logs with changes undone -> rows of the model -> rows with the columns of effects -> score
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.codegen.model import regrouping
from symgen.estimation.equation_model import JUDGING
from symgen.estimation.filtered_log import FilteredLog, Nodes
from symgen.estimation.solve import column_norms, shortest
from symgen.estimation.system import join, torque_along, torque_at, torque_rows
from symgen.estimation.values import FloatArray
from symgen.faults.undo import with_earlier_torques
from symgen.hypotheses.changes import Change, Torque
from symgen.hypotheses.effects import LogColumns, Score, Torques
from symgen.hypotheses.event import Contact
from symgen.hypotheses.rows import FittedRows, fitted, make_rows
from symgen.hypotheses.score import Key, PredictiveScore, motion_folds
from symgen.policy import MISFIT, TEMPERATURE
from symgen.robot.expressions import exact
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load_model
from symgen.symbolic.variation import link_values, variation

_BLOCK = 160  # nodes of a log in one batch of columns of all links: more do not fit into a cache

_CLIPPED = 3.0  # multiple of the median residual beyond which a residual counts no more


@dataclass(frozen=True, eq=False)
class Problem:
    """A model and its logs.

    Attributes:
        evaluator: the model, compiled.
        base: its rows on the training logs.
        held: the validation logs.
        known: (p,) fixed parameters; None to fit them.
        misfit: smallest error to expect of any model, as a part of a joint's torque.
        fold: (K,) fold of each row.
        undone: name and joints of the changes that are undone.
    """

    evaluator: Evaluator
    base: FittedRows
    held: tuple[FilteredLog, ...]
    known: FloatArray | None
    misfit: float
    fold: NDArray[np.intp]
    undone: frozenset[Key] = frozenset()

    @property
    def robot(self) -> Robot:
        """The robot as its file declares it."""
        return self.evaluator.model.robot

    @property
    def logs(self) -> tuple[FilteredLog, ...]:
        """The training logs."""
        return self.base.logs

    @property
    def is_fixed(self) -> bool:
        """Whether the parameters are fixed."""
        return self.known is not None

    @property
    def X(self) -> FloatArray:
        """(p,) parameters of the model, fixed or fitted to the training logs."""
        return self.base.X if self.known is None else self.known

    @cached_property
    def temperature(self) -> float:
        """Number of correlated rows that count as one in the score.

        On a floating base, noise of its motion is in all equations of a sample, and projected
        equations depend on each other. The number is then multiplied by |C|^2/m, with C the (m, m)
        correlation of the residuals. They are clipped, so that short spans count little.
        """
        if not self.robot.floating:
            return TEMPERATURE
        residual = self.base.whitened_residual[self.base.weight.any(axis=1)]
        most = _CLIPPED * np.median(np.abs(residual), axis=0)
        rows = np.clip(residual, -most, most)
        unit = rows / column_norms(rows)
        C = unit.T @ unit
        return TEMPERATURE * float(np.mean(np.sum(C**2, axis=0)))

    @cached_property
    def held_rows(self) -> FittedRows:
        """The rows of the model on the validation logs."""
        return make_rows(self.evaluator, self.held, self.known)

    @cached_property
    def joined(self) -> Problem:
        """The problem of all logs: the validation logs come first and are a separate fold."""
        held = self.held_rows
        logs = (*self.held, *self.logs)
        base = fitted(logs, join([held, self.base]))
        fold_of_held = np.full(len(held.y), self.fold.max() + 1)
        fold = np.concatenate([fold_of_held, self.fold])
        return replace(self, base=base, held=(), fold=fold)

    def changed(self, change: Change) -> Problem:
        """Return the problem with a change undone in all logs, or in the robot file."""
        undone = self.undone | {change.key}
        if change.gravity is not None:
            robot = replace(self.robot, gravity=tuple(map(exact, change.gravity)))
            model = load_model(robot_toml(robot), JUDGING)
            other = make_problem(model, self.logs, self.held, None, self.misfit)
            return replace(other, undone=undone)
        logs = tuple(map(change.undo, self.logs))
        held = tuple(map(change.undo, self.held))
        base = make_rows(self.evaluator, logs, self.known)
        fold = self.fold
        if change.turns:
            turned = [fold[span][::-1] for span in base.spans]
            fold = np.concatenate(turned)
        return replace(self, base=base, held=held, fold=fold, undone=undone)

    def without(self, contacts: Iterable[Contact]) -> Problem:
        """Return the problem with contacts undone, see `Span.undo`."""
        logs, held, contacts = self.logs, self.held, [*contacts]
        for contact in contacts:
            logs = tuple(map(contact.cause.undo, logs))
            held = tuple(map(contact.cause.undo, held))
        if (logs, held) == (self.logs, self.held):
            return self
        projects = any(contact.cause.frame for contact in contacts)
        same = self.base if not projects else make_rows(self.evaluator, logs, self.known)
        base = fitted(logs, same)
        return replace(self, base=base, held=held)

    @property
    def hides(self) -> bool:
        """Whether unknown forces act at contacts."""
        return any(log.hides for log in (*self.logs, *self.held))

    def piece(self, seconds: float) -> Problem:
        """Return the problem on the first seconds of each training log."""
        logs = []
        for log in self.logs:
            count = int(seconds / log.step)
            span = slice(0, count)
            samples, base = log.samples.cut(span), tuple(x[span] for x in log.base)
            logs.append(replace(log, samples=samples, q=log.q[span], qd=log.qd[span], base=base))
        if all(len(a.t) == len(b.t) for a, b in zip(logs, self.logs, strict=True)):
            return self
        return make_problem(self.evaluator, logs, (), self.known, self.misfit)

    def tried(self, change: Change) -> Problem:
        """Return the problem with a change undone, without deriving a new model.

        For another gravity, each standard parameter has a separate column, because base parameters
        depend on the direction of gravity.
        """
        if change.gravity is None:
            return self.changed(change)
        standard = self.evaluator.model.base.standard
        others = [k for k, p in enumerate(standard) if p.prefix not in names.LINK]
        onto = regrouping(self.evaluator.model)[: len(self.base.names)]
        links = self._free + np.tensordot(change.gravity, self.pulls, 1)
        more = self.base.W @ onto[:, others]
        W = np.concatenate([links, more], axis=2)
        return replace(self, base=fitted(self.logs, self.base.with_regressor(W)))

    def looked(self, change: Change) -> Problem:
        """Return the problem with a change undone in the training logs, at a first look.

        Rows and joints keep their weights, and effects that use the model's torque keep that of
        the present parameters. The change must not reverse the logs.
        """
        parts, measured = [], list[FloatArray]()
        for log in self.logs:
            thinned = change.undo(log.thinned)
            motion = tuple(map(np.ascontiguousarray, thinned.motion))
            nodes = Nodes(log.rows, motion, None, thinned.contacts(), log.base_rows)
            parts.append(torque_rows(self.evaluator, nodes, self.X))
            if log.base_rows:  # forces depend on the positions of joints
                measured.append(change.undo(log.unmasked).measured)
        W = np.concatenate(parts)
        y = np.concatenate(measured) if measured else self.torque_without(change)
        equations = np.concatenate([W, y[..., None]], axis=2)
        X = shortest(self.base.whitened(equations))
        return replace(self, base=replace(self.base, W=W, y=y, X=X))

    @cached_property
    def _free(self) -> FloatArray:
        """(K, n, 10 links) regressor of all link parameters without gravity."""
        return self._of_all_links(np.zeros(3), 1.0)

    @cached_property
    def pulls(self) -> FloatArray:
        """(3, K, n, 10 links) regressors for 1 m/s2 of gravity along each axis of frame 0."""
        return np.array([self._of_all_links(axis, 0.0) for axis in np.eye(3)])

    def _of_all_links(self, gravity: FloatArray, moving: float) -> FloatArray:
        """Return the regressor of all link parameters, (K, n, 10 links).

        Args:
            gravity: (3,) in frame 0, m/s2.
            moving: factor on speeds and accelerations: 1.0, or 0.0 for the arm at rest.
        """
        v = variation(self.robot)
        heavy = np.isin(names.LINK, (names.MASS, *names.MOMENT))
        acting = np.resize(heavy | bool(moving), len(v.units))  # inertias have no torque at rest
        units = v.units[acting]

        def links(q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
            return v.regressor((q, moving * qd, moving * qdd), units, gravity)

        nodes = [log.unmasked.at_nodes(log.smooth_stride) for log in self.logs]
        parts = [of_log.modelled(links, _BLOCK) for of_log in nodes]
        out = np.zeros((*self.base.y.shape, len(acting)))
        out[..., acting] = np.concatenate(parts)
        return out

    @cached_property
    def corrected(self) -> Callable[[Change], Problem]:
        """`changed`, which keeps the last problems: a search asks for the same ones again."""
        return lru_cache(maxsize=8)(self.changed)

    @cached_property
    def torque(self) -> Torque:
        """`_moved_torque`, which keeps the last torques: every step of a search asks for them."""
        return lru_cache(maxsize=64)(self._moved_torque)

    def _moved_torque(self, earlier: float, places: int) -> FloatArray:
        """Return the torque in the band, (K, n), moved earlier by some seconds, see `Torque`.

        On a floating base, return what the torque of each joint adds to each equation, (K, m, n).
        """
        parts = []
        for log in self.logs:
            tau = with_earlier_torques(log.samples, earlier).tau if earlier else log.samples.tau
            parts.append(_in_equations(log, np.roll(tau, -places, axis=1)))
        return np.concatenate(parts)

    def torque_without(self, change: Change) -> FloatArray:
        """Return the torque in the band, (K, m), with a change undone in the torque channels."""
        torque = change.torque(self.torque)
        if not self.robot.floating:
            return torque
        more = torque - self.torque(0.0, 0)
        return np.asarray(self.base.measured + more.sum(axis=2))

    def stage(self, effects: Iterable[Score] = ()) -> Stage:
        """Return the problem with the columns of some effects."""
        return Stage(self, tuple(effects))

    def make_columns(self, logs: Sequence[FilteredLog], X: FloatArray) -> LogColumns:
        """Return the columns of candidates on some logs, for parameters X (p,)."""
        return LogColumns(logs, [self.torques_along(log.thinned, X) for log in logs])

    def torques_along(self, log: FilteredLog, X: FloatArray) -> Torques:
        """Return the torque of the model with parameters X (p,) along a log in the band."""
        torque, load = _split(self.evaluator, X, log)
        total, rigid = _split(self.evaluator, self.X, log)
        links = link_values(self.robot, self.evaluator.model.base, X)
        gravity = variation(self.robot).gravity
        return Torques(torque, load, total - rigid, links, partial(self._of_links, links), gravity)

    def _of_links(self, links: FloatArray, *motion: FloatArray) -> FloatArray:
        """Return the torque (k, n) of links with parameters (links, 10), without friction."""
        return torque_at(self.evaluator, self._regrouping @ links.ravel(), *motion)

    @cached_property
    def _regrouping(self) -> FloatArray:
        """(p, 10 links) matrix from link parameters to base parameters."""
        model = self.evaluator.model
        at = {p.name: k for k, p in enumerate(model.base.standard)}
        keys = []
        for joint in self.robot.moving:
            keys += [at[f"{key}{joint.number}"] for key in names.LINK]
        return regrouping(model)[:, keys]


@dataclass(frozen=True, eq=False)
class Stage:
    """A problem with the columns of some effects.

    Attributes:
        problem: the model and its logs.
        effects: the effects.
    """

    problem: Problem
    effects: tuple[Score, ...]

    @cached_property
    def rows(self) -> FittedRows:
        """The rows of the model with the columns of the effects."""
        return self.problem.base.with_columns(s.columns for s in self.effects)

    @property
    def X(self) -> FloatArray:
        """(p,) parameters of the model, fixed or fitted in one step with the effects."""
        known = self.problem.known
        return self.rows.X[: self._count] if known is None else known

    @property
    def coefficients(self) -> FloatArray:
        """Coefficients of the effects, in the order of the effects."""
        return self.rows.X[self._count :]

    @property
    def _count(self) -> int:
        return int(self.problem.base.W.shape[2])

    @cached_property
    def score(self) -> PredictiveScore:
        """The score of further candidates, which are added to these effects."""
        rows, problem = self.rows, self.problem
        misfit = problem.misfit * problem.base.size
        fitted_rows = rows.W, rows.residual, rows.weight, rows.sigma
        return PredictiveScore(*fitted_rows, problem.fold, misfit, problem.temperature)

    @cached_property
    def log_columns(self) -> LogColumns:
        """The columns of candidates on the training logs."""
        return self.problem.make_columns(self.problem.logs, self.X)

    @property
    def lost(self) -> FloatArray:
        """(n,) held-out error of each joint, as a part of its torque."""
        deviation = np.sqrt(self.score.alone.variance)
        return np.asarray(deviation / self.problem.base.size)


def make_problem(
    evaluator: Evaluator,
    train: Sequence[FilteredLog],
    held: Sequence[FilteredLog],
    known: FloatArray | None = None,
    misfit: float = MISFIT,
) -> Problem:
    """Fit a model to the training logs, or take known parameters (p,)."""
    base = make_rows(evaluator, train, known)
    return Problem(evaluator, base, tuple(held), known, misfit, motion_folds(train))


def _split(evaluator: Evaluator, X: FloatArray, log: FilteredLog) -> tuple[FloatArray, FloatArray]:
    """Return the torque of a model along a log and its rigid-body part, (N, n) each.

    On a floating base, measured wrenches carry a part of it.
    """
    of_links = np.arange(len(X)) < evaluator.model.inertial
    rigid = np.where(of_links, X, 0.0)
    first = log.base_rows
    carried = log.tau[:, first:] - log.samples.tau if first else 0.0
    torque, load = (torque_along(evaluator, x, log)[:, first:] - carried for x in (X, rigid))
    return torque, load


def _in_equations(log: FilteredLog, tau: FloatArray) -> FloatArray:
    """Return torques of joints (N, n) in the band, (K, n).

    On a floating base, return what each adds to each equation, (K, m, n).
    """
    if log.hides:
        return log.unmasked.compared(tau[:, None] * log.spread(1))
    torque = log.unmasked.compared(tau)
    return torque[:, None] * log.spread(1) if log.base_rows else torque
