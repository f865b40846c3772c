"""Torque equations of logs with and without a load.

The link parameters s of a load that is fixed on a link enter the base parameters like those of the
link, X = G s. With Y the torque regressor, torques are linear in s:

    tau = Y X + (Y G) s

All joints share X and s. A solution is a step of weighted least squares from parameters X0, s0,

    tau - m0 = Y dX + c Y G ds,    c = 1 in logs with the load, 0 in those without

with m0 the torque of the model at X0, s0. Effects that depend on the torque of the model have their
columns at X0, s0 too, so they need several steps.
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
from symgen.estimation.system import Rows, join
from symgen.estimation.torque_error import fit
from symgen.estimation.values import FloatArray
from symgen.identification.load import SMALL, UNITS, Load
from symgen.identification.parameters import link_columns
from symgen.identification.solving import ROUNDS, SETTLED
from symgen.runtime.evaluator import Evaluator


class Solved(NamedTuple):
    """A solution for robot and load, and the last step to it.

    Attributes:
        problem: the problem with the columns of that step.
        X: (p,) parameters of the robot.
        a: (r,) the load along its determined directions.
        solution: changes of the load (r,), then of X, in that step.
        rows: equations of that step.
    """

    problem: LoadSystem
    X: FloatArray
    a: FloatArray
    solution: Solution
    rows: Rows

    @property
    def with_load(self) -> FloatArray:
        """Parameters of the robot with the load, (p,)."""
        return self.X + self.problem.in_X(self.a)

    def load(self, covariance: FloatArray | None = None) -> Load:
        """Return the load, from the covariance (k, k) of the solution; None for its own."""
        from scipy.linalg import null_space

        V, known = self.problem.V, self.problem.known
        onto = UNITS[:, None] * V
        directions = V.shape[1]
        covariance = self.solution.covariance if covariance is None else covariance
        covariance = covariance[:directions, :directions]
        null = null_space(np.column_stack([V, known != 0]).T)
        return Load(known + onto @ self.a, onto @ covariance @ onto.T, null)

    def derivative_by_known(self) -> FloatArray:
        """Return the derivative of the solution with respect to known parameters X, (k, p)."""
        weights = self.solution.weights
        fitted, known = (
            np.concatenate([w * e.W for w, e in zip(weights, rows.parts, strict=True)])
            for rows in (self.rows, self.problem.rows)
        )
        slope, *_ = np.linalg.lstsq(fitted, known, rcond=None)
        return -np.asarray(slope)


@dataclass(frozen=True, eq=False)
class LoadSystem:
    """Equations of logs with a load and without, linear in parameters X and in the load.

    Attributes:
        rows: equations of all logs.
        loaded: (K, 1) 1.0 for the rows of logs with the load, 0.0 for the others.
        G: (p, 10) matrix from the parameters of the load to X.
        V: (10, r) determined directions of the load, orthonormal in UNITS.
        known: (10,) known parameters of the load: its mass or 0, and zeros.
        free: indices of the fitted parameters in X.
    """

    rows: Rows
    loaded: FloatArray
    G: FloatArray
    V: FloatArray
    known: FloatArray
    free: Sequence[int]

    def step(self, X: FloatArray, a: FloatArray) -> Solved:
        """Solve for changes of the load a (r,) and of the free parameters of X (p,)."""
        W, loaded = self.rows.W, self.loaded
        robot = self.rows.y - W @ X
        y = robot - loaded * (W @ self.in_X(a))
        labels = [f"load {k + 1}" for k in range(len(a))]
        labels += [self.rows.names[k] for k in self.free]
        of_load = loaded[..., None] * (W @ (self.G * UNITS @ self.V))
        both = np.concatenate([of_load, W[:, :, self.free]], axis=2)
        rows = replace(self.rows, names=tuple(labels), W=both, y=y)
        solution = Wls().solve(rows)
        changed, moved = np.split(solution.X, [len(a)])
        updated = X.copy()
        updated[self.free] += moved
        return Solved(self, updated, a + changed, solution, rows)

    def in_X(self, a: FloatArray) -> FloatArray:
        """Return the contribution of the load a (r,) to X, (p,)."""
        return self.G @ (self.known + UNITS * (self.V @ a))


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadProblem(LoadSystem):
    """Torque equations of logs with a load and without, joint by joint.

    Attributes:
        evaluator: the compiled model.
        model: model of the equations.
        logs: logs with the load, and logs without it.
    """

    evaluator: Evaluator
    model: EquationModel
    logs: tuple[Sequence[FilteredLog], Sequence[FilteredLog]]

    def on_link(self, link: int) -> LoadProblem:
        """Return the problem of a load on another link."""
        weighed = bool(self.known.any())
        G, V = _directions(self.evaluator, self.rows, self.loaded, link, weighed)
        return replace(self, G=G, V=V)

    def solve(self, X: FloatArray) -> Solved:
        """Solve for the load and the free parameters, from those of the robot alone, X (p,).

        Raises:
            IdentificationError: the steps do not converge.
        """
        solved = self.step(X, np.zeros(self.V.shape[1]))
        if not self.evaluator.model.robot.loaded:
            return solved
        for _ in range(ROUNDS):
            at = solved.with_load, solved.X
            rows = _rows(self.evaluator, self.model, self.logs, at)
            solved = replace(self, rows=rows).step(solved.X, solved.a)
            change = np.abs(solved.solution.X)
            if (change <= SETTLED * solved.solution.std + 1e-12).all():
                return solved
        raise IdentificationError(
            "load and friction do not converge; accepted: logs with and without the load, of "
            "motions that turn it against gravity"
        )

    def error(self, X: FloatArray) -> float:
        """Return the torque error in motion of the logs with the load, one step from X (p,)."""
        solved = self.step(X, np.zeros(self.V.shape[1]))
        torques = fit(self.evaluator, self.logs[0], solved.with_load)
        return torques.in_motion.residual.relative


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
        logs: logs with the load, and logs without it.
        X: (p,) parameters at which load-dependent effects are evaluated.
        link: number of the joint whose link carries the load.
        mass: known mass of the load, kg; None if unknown.
        fixed: number of leading parameters of the robot that are not fitted.
    """
    features = features_of([*logs[0], *logs[1]], evaluator.model.robot.sigma)
    model = EquationModel("torque", 0.0, features=features)
    rows = _rows(evaluator, model, logs, (X, X))
    known = np.array([*[0.0] * 9, mass or 0.0])
    counts = [len(log.kept) for group in logs for log in group]
    carries = np.arange(len(counts)) < len(logs[0])
    loaded = np.repeat(carries, counts)[:, None].astype(float)
    G, V = _directions(evaluator, rows, loaded, link, mass is not None)
    determined = identifiable_columns(np.concatenate([e.W for e in rows.parts])).kept
    free = [k for k in determined if k >= fixed]
    return LoadProblem(
        rows, loaded, G, V, known, free, evaluator=evaluator, model=model, logs=logs
    )  # fmt: skip


def _rows(
    evaluator: Evaluator,
    model: EquationModel,
    logs: tuple[Sequence[FilteredLog], Sequence[FilteredLog]],
    X: tuple[FloatArray, FloatArray],
) -> Rows:
    """Return the torque equations of logs, with load-dependent effects evaluated at X (p,)."""
    out = []
    for group, at in zip(logs, X, strict=True):
        settled = replace(model, at=tuple(at.tolist()))
        out += [settled.equations(evaluator, log) for log in group]
    return join(out)


def _directions(
    evaluator: Evaluator, rows: Rows, loaded: FloatArray, link: int, weighed: bool
) -> tuple[FloatArray, FloatArray]:
    """Return G (p, 10) of a load on a link, and its determined directions (10, r).

    The directions are orthonormal in units of 0.1 m and 1 kg. They do not change a known mass.
    """
    model = evaluator.model
    G = regrouping(model)[:, link_columns(model, link)]
    free = 10 - weighed
    scaled = (G * UNITS)[:, :free]
    parts = [e.W @ scaled for e in rows.weighed(loaded).parts]
    shown = shown_directions(np.concatenate(parts))
    return G, np.vstack([shown, np.zeros((10 - free, shown.shape[1]))])


def shown_directions(columns: FloatArray, noise: FloatArray | None = None) -> FloatArray:
    """Return the directions (10, r) of the load that its columns show, orthonormal.

    Args:
        columns: (K, 10) columns of the load.
        noise: (L, 10) their noise, which the columns have to exceed; None if they are exact.
    """
    _, sizes, V = np.linalg.svd(triangle(columns))
    lost = np.full(len(sizes), SMALL * sizes[0])
    if noise is not None:
        lost = np.maximum(lost, np.linalg.norm(noise @ V.T, axis=0))
    return np.asarray(V[: len(sizes)][sizes > lost].T)
