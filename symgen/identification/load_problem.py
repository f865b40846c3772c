"""Torque equations of logs with and without a load.

Link parameters s of a load that is fixed on a link enter the base parameters as those of the link
do, X = G s. With Y the torque regressor, torques are linear in s:

    tau = Y X + (Y G) s

All joints share X and s. A solution is a step of weighted least squares from parameters X0, s0,

    tau - m0 = Y dX + c Y G ds,    c = 1 in logs with the load, 0 in those without

with m0 the torque of the model before. Effects that depend on the torque of the model have their
columns at the parameters before, so several steps settle them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from symgen.codegen.model import regrouping
from symgen.errors import IdentificationError
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Wls
from symgen.estimation.features import features_of
from symgen.estimation.filtered_log import FilteredLog
from symgen.estimation.solve import Solution, identifiable_columns
from symgen.estimation.summary import triangle
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import FloatArray
from symgen.identification.load import SMALL, UNITS, Load
from symgen.identification.parameters import link_columns
from symgen.identification.solving import ROUNDS, SETTLED
from symgen.runtime.evaluator import Evaluator


@dataclass(frozen=True, eq=False)
class LoadFit:
    """A solution for robot and load.

    Attributes:
        X: (p,) the robot's parameters.
        a: (r,) the load, along the directions that torques show.
    """

    X: FloatArray
    a: FloatArray


class Solved(NamedTuple):
    """A fit, with the last step to it: r changes of the load, then of X.

    Attributes:
        problem: with the columns of that step.
        fit: the fit.
        solution: of the step.
        system: equations of the step.
    """

    problem: LoadProblem
    fit: LoadFit
    solution: Solution
    system: LinearSystem

    def by_given(self) -> FloatArray:
        """Return the derivative of the solution by X where X is not solved for, (k, p)."""
        rows = (*self.problem.carried, *self.problem.alone)
        weights = self.solution.weights
        own = [w * e.W for w, e in zip(weights, self.system.logs, strict=True)]
        given = [w * e.W for w, e in zip(weights, rows, strict=True)]
        slope = np.linalg.lstsq(np.concatenate(own), np.concatenate(given), rcond=None)[0]
        return -np.asarray(slope)


@dataclass(frozen=True, eq=False)
class LoadProblem:
    """Torque equations of logs with a load and without, joint by joint.

    Attributes:
        evaluator: the compiled model.
        model: of the equations.
        logs: those with the load, and those without.
        carried, alone: their equations.
        G: (p, 10) from the parameters of the load to X.
        V: (10, r) directions of the load that torques show, orthonormal in UNITS.
        known: (10,) what is known of the load: its mass, or nothing.
        free: places of the parameters of the robot that are solved for.
    """

    evaluator: Evaluator
    model: EquationModel
    logs: tuple[Sequence[FilteredLog], Sequence[FilteredLog]]
    carried: Sequence[Equations]
    alone: Sequence[Equations]
    G: FloatArray
    V: FloatArray
    known: FloatArray
    free: Sequence[int]

    def on_link(self, link: int) -> LoadProblem:
        """Return the problem of a load on another link."""
        G, V = _directions(self.evaluator, self.carried, link, bool(self.known.any()))
        return replace(self, G=G, V=V)

    def solve(self, start: LoadFit) -> Solved:
        """Solve for the load and the free parameters.

        Raises:
            IdentificationError: the steps do not converge.
        """
        found = self.step(start)
        if not self.evaluator.model.robot.loaded:
            return found
        for _ in range(ROUNDS):
            found = self.around(found.fit).step(found.fit)
            change = np.abs(found.solution.X)
            if (change <= SETTLED * found.solution.std + 1e-12).all():
                return found
        raise IdentificationError(
            "load and friction do not converge; accepted: logs with and without the load, of "
            "motions that turn it against gravity"
        )

    def around(self, fit: LoadFit) -> LoadProblem:
        """Return the problem with the effects that depend on the model's torque at a fit."""
        carried, alone = self.logs
        whole = fit.X + self.in_X(fit)
        return replace(
            self,
            carried=_rows(self.evaluator, self.model, carried, whole),
            alone=_rows(self.evaluator, self.model, alone, fit.X),
        )

    def step(self, at: LoadFit) -> Solved:
        """Solve for changes of the load and of the free parameters."""
        columns, load = self.G * UNITS @ self.V, self.in_X(at)
        rows = []
        logs = [(e, at.X + load, columns) for e in self.carried]
        logs += [(e, at.X, 0 * columns) for e in self.alone]
        for e, X, shown in logs:
            W = np.hstack([e.W @ shown, e.W[:, self.free]])
            rows.append(replace(e, W=W, y=e.y - e.W @ X))
        names = self.evaluator.model.base.names
        labels = [f"load {k + 1}" for k in range(len(at.a))]
        labels += [names[k] for k in self.free]
        system = LinearSystem(tuple(labels), tuple(rows))
        solution = Wls().solve(system)
        a, X = np.split(solution.X, [len(at.a)])
        whole = at.X.copy()
        whole[self.free] += X
        return Solved(self, LoadFit(whole, at.a + a), solution, system)

    def in_X(self, fit: LoadFit) -> FloatArray:
        """Return what the load adds to X, (p,)."""
        return self.G @ (self.known + UNITS * (self.V @ fit.a))

    def load(self, fit: LoadFit, covariance: FloatArray) -> Load:
        """Return the load of a fit, with the covariance of its directions, (r, r)."""
        from scipy.linalg import null_space

        onto = UNITS[:, None] * self.V
        null = null_space(np.column_stack([self.V, self.known != 0]).T)
        return Load(self.known + onto @ fit.a, onto @ covariance @ onto.T, null)


def load_problem(
    evaluator: Evaluator,
    logs: tuple[Sequence[FilteredLog], Sequence[FilteredLog]],
    X: FloatArray,
    link: int,
    mass: float | None,
    fixed: int,
) -> LoadProblem:
    """Return the problem of a load.

    Args:
        evaluator: the compiled model.
        logs: those with the load, and those without.
        X: (p,) at which effects take the model's torque.
        link: number of the joint whose link carries the load.
        mass: of the load, if it is known.
        fixed: number of the first parameters of the robot, which are not solved for.
    """
    features = features_of([*logs[0], *logs[1]], evaluator.model.robot.sigma)
    model = EquationModel("torque", 0.0, features=features)
    carried, alone = (_rows(evaluator, model, group, X) for group in logs)
    known = np.array([*[0.0] * 9, mass or 0.0])
    G, V = _directions(evaluator, carried, link, mass is not None)
    rows = np.concatenate([e.W for e in (*carried, *alone)])
    free = [k for k in identifiable_columns(rows).kept if k >= fixed]
    return LoadProblem(evaluator, model, logs, carried, alone, G, V, known, free)


def _rows(
    evaluator: Evaluator, model: EquationModel, logs: Sequence[FilteredLog], X: FloatArray
) -> list[Equations]:
    """Return the torque equations of logs, with effects of the model's torque at X (p,)."""
    settled = replace(model, at=tuple(X.tolist()))
    return [e for log in logs for e in settled.equations(evaluator, log)]


def _directions(
    evaluator: Evaluator, rows: Sequence[Equations], link: int, weighed: bool
) -> tuple[FloatArray, FloatArray]:
    """Return G (p, 10) of a load on a link, and the directions (10, r) of it that torques show.

    The directions are orthonormal, in the units of a load of 0.1 m and 1 kg; with a known mass they
    leave it as it is.
    """
    model = evaluator.model
    G, free = regrouping(model)[:, link_columns(model, link)], 10 - weighed
    scaled = (G * UNITS)[:, :free]
    _, sizes, V = np.linalg.svd(triangle(np.concatenate([e.W @ scaled for e in rows])))
    shown = V[: len(sizes)][sizes > SMALL * sizes[0]].T
    return G, np.pad(shown, ((0, 10 - free), (0, 0)))
