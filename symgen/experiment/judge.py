"""What motions are judged by: limits every millisecond, and the equations that identify builds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.log import read_only
from symgen.data.signals import Samples
from symgen.errors import IdentificationError, LogError, ParameterError
from symgen.estimation.filtered import unfiltered
from symgen.estimation.recipe import NEEDED, Recipe
from symgen.estimation.system import Equations
from symgen.experiment.bounds import Bounds, Torque, Use, uses, worst
from symgen.experiment.cell import KERNEL, KINDS, Cell
from symgen.experiment.criterion import FloatArray, condition_number, log_determinant
from symgen.experiment.plan import Plan
from symgen.experiment.space import Space
from symgen.experiment.trajectory import Trajectory
from symgen.identification.parameters import read_parameters
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

MODELS = tuple(NEEDED)
_SHRINK = 0.9  # of a motion with too much torque or too near to the cell, again and again
SHRUNK = ("torque", *KINDS)  # limits that are kept so
_SMALLEST, _SMALLEST_IN_CELL = 0.5, 0.25
_SLOW = 0.1  # of the allowed speeds, in the approach
_PEAK = 1.875  # of the mean speed of a motion of degree five from rest to rest
_HALVINGS = 5  # of the last step


def _within(found: Sequence[Use]) -> bool:
    """Whether the torques are within their limits, and the cell is kept clear."""
    return all(u.share <= 1 for u in found if u.limit in SHRUNK)


@dataclass(frozen=True, eq=False)
class Found:
    """A motion of all runs, with its condition number and use of limits on a fine grid."""

    runs: tuple[Trajectory, ...]
    condition: float
    log_det: float
    uses: tuple[Use, ...]
    start: float

    @property
    def excess(self) -> float:
        """Largest share that is used of a limit of torque, or of the cell."""
        return max((u.share for u in self.uses if u.limit in SHRUNK), default=0.0)

    @property
    def keeps(self) -> bool:
        """Whether torques and cell are within their limits; the other limits always are."""
        return _within(self.uses)

    @property
    def text(self) -> str:
        """The condition number in words."""
        return f"condition number {self.condition:.4g}"

    def beginning(self, first: Found) -> Found:
        """Return it with the condition number of the start of its search."""
        return replace(self, start=first.condition)


@dataclass(frozen=True, eq=False)
class Judge:
    """What motions are judged by: the compiled model, limits, prior, windows and rate."""

    evaluator: Evaluator
    name: str
    window: float
    rate: float
    limits: Bounds
    prior: FloatArray | None
    notes: tuple[str, ...]
    cell: Cell | None = None

    @property
    def approach(self) -> float:
        """s, in which the farthest way between positions takes a tenth of the allowed speeds."""
        way = (self.limits.high - self.limits.low) / (_SLOW * self.limits.rates[0])
        return float(math.ceil(_PEAK * way.max()))

    @property
    def model(self) -> Model:
        """The derived model."""
        return self.evaluator.model

    @property
    def torque(self) -> Torque | None:
        """The torque of the prior model, None where torques are not limited."""
        X = self.prior
        if X is None:
            return None
        inverse = self.evaluator["inverse_dynamics"]
        return lambda q, qd, qdd: np.asarray(inverse(q, qd, qdd, X))

    def equations(self, runs: Sequence[Trajectory], name: str) -> tuple[Equations, ...]:
        """Return the equations that identify would build from these runs.

        Raises:
            IdentificationError: a window does not fit a run.
        """
        recipe = Recipe(name, self.window)
        out: list[Equations] = []
        for k, run in enumerate(runs, 1):
            t = run.times(1 / self.rate)
            q, qd = (read_only(run.at(t, order)) for order in range(2))
            step = float(t[1] - t[0])
            samples = Samples(f"run {k}", t, q, qd, np.zeros_like(q), step, None, ())
            out += recipe.equations(self.evaluator, unfiltered(samples))
        return tuple(out)

    def regressor(self, runs: Sequence[Trajectory], name: str) -> FloatArray:
        """Return identify's regressor of these runs, (K, p)."""
        return np.concatenate([e.W for e in self.equations(runs, name)])

    def judged(self, choices: Space, z: FloatArray) -> Found:
        """Return a motion that keeps its limits, and what it is worth.

        Joints are shrunk about the centre as far as their own limits ask for, all of them together
        as far as the torques and the cell do.
        """
        z = choices.fitted(z, self.limits)
        runs, found = self._used(choices, z)
        factor, too_much = 1.0, 1.0
        smallest = _SMALLEST if self.cell is None else _SMALLEST_IN_CELL
        while not _within(found) and factor > smallest:
            too_much, factor = factor, _SHRINK * factor
            runs, found = self._used(choices, factor * z)
        for _ in range(_HALVINGS if too_much > factor and _within(found) else 0):
            middle = (factor + too_much) / 2
            tried = self._used(choices, middle * z)
            if _within(tried[1]):
                factor, (runs, found) = middle, tried
            else:
                too_much = middle
        W = self.regressor(runs, self.name)
        return Found(runs, condition_number(W), log_determinant(W), found, math.nan)

    def _used(
        self, choices: Space, z: FloatArray
    ) -> tuple[tuple[Trajectory, ...], tuple[Use, ...]]:
        """Return the runs of z, and how much of every limit they take."""
        runs = choices.trajectories(z)
        every = [u for r in runs for u in uses(self.limits, r, self.torque)]
        if self.cell is not None:
            every += [u for r in runs for u in self.cell.uses(r)]
        found = worst(every)
        return runs, tuple(found.values())

    def plan(self, best: Found, searches: tuple[int, int], stopped: str) -> Plan:
        """Return the plan, with what the other models would make of it."""
        own = self.equations(best.runs, self.name)
        conditions = {}
        for name in MODELS:
            try:
                conditions[name] = condition_number(self.regressor(best.runs, name))
            except (IdentificationError, LogError):  # its windows or filter do not fit these runs
                conditions[name] = math.inf
        return Plan(
            robot=self.model.robot.name,
            model=self.name,
            window=self.window,
            rate=self.rate,
            runs=best.runs,
            conditions=conditions,
            log_det=best.log_det,
            start=best.start,
            uses=tuple(sorted(best.uses, key=lambda u: u.joint)),
            parameters=len(self.model.base.parameters),
            independent=sum(len(e.y) / e.correlation for e in own),
            searches=searches,
            stopped=stopped,
            notes=self.notes,
            approach=self.approach,
        )


def judge(
    robot: Robot,
    name: str,
    window: float,
    rate: float,
    limits: Bounds,
    parameters: str | Path | None,
    asked: bool,
) -> Judge:
    """Load what motions are judged by.

    Args:
        robot: the mechanism.
        name: of the model that will be used.
        window: of energy and momentum, s.
        rate: of the samples, Hz.
        limits: of the joints.
        parameters: file of the prior model, None where torques are not looked at.
        asked: whether limits of torque were given on purpose.

    Raises:
        ParameterError: limits of torque without a prior model, or the other way round.
    """
    kernels = dict.fromkeys(k for m in MODELS for k in Recipe(m, window).all_kernels)
    fenced = robot.limits is not None and robot.limits.cell
    kernels |= {KERNEL: None} if fenced else {}
    model = derive(robot, tuple(kernels))
    limited = bool(np.isfinite(limits.torque).any())
    notes: tuple[str, ...] = ()
    if parameters is None and asked:
        raise ParameterError(
            "limits of torque need a prior model; accepted: parameters as well (estimate.json, or "
            "TOML with [parameters])"
        )
    if parameters is not None and not limited:
        raise ParameterError(
            "parameters are given and no torque is limited; accepted: torque in [limits], or "
            "--torque"
        )
    if parameters is None and limited:
        notes = ("limits of torque are not looked at: that needs --parameters of a prior model",)
    prior = None if parameters is None else read_parameters(parameters, model)
    evaluator = load(model)
    cell = Cell(evaluator, robot.limits) if fenced and robot.limits is not None else None
    return Judge(evaluator, name, window, rate, limits, prior, notes, cell)
