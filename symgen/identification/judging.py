"""The last pass of identify: what an estimate is worth, and all that is said of it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import symgen.identification.verdict as verdicts
from symgen import names
from symgen.estimation.band import Band
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.fit import TorqueFit, fit
from symgen.estimation.logs import digest
from symgen.estimation.masking import seldom_moving
from symgen.estimation.recipe import Recipe
from symgen.estimation.repairs import LEFT, Repair
from symgen.estimation.solve import Solution
from symgen.estimation.values import Contrast, Residual
from symgen.identification.alternatives import disagreement
from symgen.identification.estimate import (
    LOG_DIGEST,
    ROBOT_DIGEST,
    Alternative,
    Estimate,
    Joint,
    ParameterEstimate,
    other_estimate,
)
from symgen.identification.physical.links import consistency
from symgen.identification.physical.plausibility import implausible
from symgen.identification.signs import wrong_sign
from symgen.identification.solving import Method, convergence, moved_by_window
from symgen.identification.validation import Part, energy_balances, model_traces, residual
from symgen.identification.whiteness import whiteness
from symgen.robot.toml_text import robot_toml
from symgen.runtime.evaluator import Evaluator
from symgen.symbolic.near_angles import costly_angles

FloatArray = NDArray[np.float64]
_PLENTY = 10  # independent equations for each parameter


@dataclass(frozen=True, eq=False)
class Run:
    """What was looked at: the model, the band, and the logs in it."""

    evaluator: Evaluator
    band: Band
    train: tuple[FilteredLog, ...]
    held: tuple[FilteredLog, ...]
    repairs: tuple[Repair, ...]
    given: bool

    @property
    def logs(self) -> tuple[FilteredLog, ...]:
        """All logs."""
        return (*self.train, *self.held)


@dataclass(frozen=True, eq=False)
class Outcome:
    """How a solution fits all equations and torques, those of the logs of a run or of more.

    Attributes:
        train: residual of the equations of the training logs.
        held: of the validation logs.
        own: torques of the training logs.
        seen: of the validation logs.
        windows: number of independent equations.
    """

    train: Residual
    held: Residual
    own: TorqueFit
    seen: TorqueFit
    windows: float


def outcome(
    run: Run, recipe: Recipe, X: FloatArray, train: Sequence[Part], held: Sequence[Part]
) -> Outcome:
    """Return how X fits the logs of a run; arguments as for `judged`."""
    own, seen = fit(run.evaluator, run.train, X, "train"), fit(run.evaluator, run.held, X)
    windows = sum(len(e.y) / e.correlation for p in train for e in p.equations)
    if recipe.model == "torque":
        return Outcome(own.residual, seen.residual, own, seen, windows)
    return Outcome(residual(train, X), residual(held, X), own, seen, windows)


def judged(
    run: Run,
    recipe: Recipe,
    method: Method,
    solution: Solution,
    bias: str,
    found: tuple[Alternative, ...],
    faults: tuple[str, ...],
    train: Sequence[Part],
    held: Sequence[Part],
    known: Outcome | None = None,
) -> Estimate:
    """Return the estimate that a solution is, with its fit, its verdict, and what is drawn of it.

    Args:
        run: what was looked at.
        recipe: of the equations that were solved.
        method: that solved them.
        solution: what it gave.
        bias: of least squares beyond its intervals, in words, or "".
        found: the models that were fitted, the chosen one first.
        faults: of the torques, in words.
        train, held: the logs with their equations.
        known: how the solution fits all logs, where those of the run are a sample of them.
    """
    evaluator, X = run.evaluator, solution.X
    robot = evaluator.model.robot
    out = outcome(run, recipe, X, train, held) if known is None else known
    base = evaluator.model.base
    std = solution.std
    parameters = tuple(
        ParameterEstimate(b.name, b.expression, float(x), float(s), b.unit)
        for b, x, s in zip(base.parameters, X, std, strict=True)
    )
    own, seen = out.own, out.seen
    physical = consistency(evaluator.model, X, solution.covariance)
    turned = wrong_sign(evaluator, train, recipe, out.train.relative)
    elsewhere = verdicts.error_elsewhere(evaluator, run.train, solution.covariance)
    verdict = verdicts.verdict(
        verdicts.prediction_use(
            own,
            seen,
            elsewhere,
            (
                *faults,
                *verdicts.hardly_moving(run.train, robot.sigma),
                *verdicts.driving_friction(parameters),
                *((turned,) if turned else ()),
            ),
            (
                *(f"{r.log}: {r.channel} {r.fault}" for r in run.repairs if r.done == LEFT),
                *seldom_moving(run.train),
            ),
        ),
        verdicts.parameters_use(
            parameters, physical, (*((bias,) if bias else ()), *disagreement(found))
        ),
        verdicts.simulation_use(evaluator, run.train, X, parameters),
        len(parameters),
        seen.told_apart,
    )
    notes = tuple(note for log in run.logs for note in log.samples.notes)
    notes += (f"band: {run.band.in_words()}", *_of_rests(run.band, seen), *costly_angles(robot))
    if not run.given:
        notes += ("no validation log is given: the last fifth of each log is held out",)
    if out.windows < _PLENTY * len(parameters):
        notes += (
            f"{out.windows:.0f} independent equations for {len(parameters)} parameters: under "
            f"{_PLENTY} each, the intervals tend to be short",
        )
    notes += solution.notes
    if len(set(solution.weights)) > 1:
        low, high = min(solution.weights), max(solution.weights)
        notes += (
            f"equations are weighed by log and joint, largest over smallest {high / low:.2f}",
        )
    if any(p.equations[0].weight != 1.0 for p in train):
        listed = ", ".join(f"{p.equations[0].weight:g}" for p in train)
        notes += (f"squared residuals of the logs are weighed by {listed}",)
    notes += tuple(filter(None, (implausible(evaluator, run.train, X),)))
    moved = moved_by_window(evaluator, train, method, recipe, X, std)
    if moved:
        notes += (
            f"with other windows {moved}: the model misses something of this size, "
            "which std does not tell",
        )
    traces = tuple(trace for p in (*train, *held) for trace in model_traces(p, X))
    traces += own.traces + seen.traces
    outside, prior = np.where(std > 0, std, 1), method.prior
    return Estimate(
        robot=evaluator.model.robot.name,
        joints=tuple(
            Joint(j.number, names.unit("FS", j.sigma)) for j in evaluator.model.robot.movable
        ),
        model=recipe.model,
        method=method.label,
        parameters=parameters,
        condition_number=solution.condition_number,
        train=out.train,
        validation=out.held,
        torque_train=own.residual,
        torque_validation=seen.residual,
        cutoff_hz=run.band.cutoff_hz,
        window_s=None if recipe.model == "torque" else recipe.window,
        verdict=verdict.word,
        reasons=verdict.reasons,
        notes=notes,
        correlation=solution.covariance / np.outer(outside, outside),
        traces=traces,
        convergence=convergence(train, base.names),
        provenance=_provenance(evaluator, method, train, held),
        physical=physical,
        excludes=method.excludes,
        endogeneity=solution.endogeneity,
        comparison=tuple(other_estimate(c, base.names) for c in solution.comparison),
        prior=None
        if prior is None
        else other_estimate(Contrast("prior", prior.mean, prior.std), base.names),
        balances=energy_balances(evaluator, (*train, *held), X),
        whiteness=whiteness(traces),
        band=run.band,
        repairs=run.repairs,
        alternatives=found,
        uses=verdict.uses,
        headline=verdict.headline,
    )


def _of_rests(band: Band, seen: TorqueFit) -> tuple[str, ...]:
    """Say what rests do, where the logs that judge have any."""
    if band.rests is None:
        return ()
    weights = band.rests.weight
    return tuple(
        f"joints stand still at times, where friction can be anything between its limits: {told}; "
        f"equations at rest weigh {min(weights):.2g} to {max(weights):.2g} of those in motion"
        for told in seen.told_apart
    )


def own_version() -> str:
    """Return symgen's version; "unknown" where it is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("symgen")
    except PackageNotFoundError:
        return "unknown"


def own_provenance(evaluator: Evaluator) -> list[tuple[str, str]]:
    """Return what made an estimate: symgen's version, the backend, and the robot's digest."""
    robot = hashlib.sha256(robot_toml(evaluator.model.robot).encode()).hexdigest()
    return [("symgen", own_version()), ("backend", evaluator.backend), (ROBOT_DIGEST, robot)]


def _provenance(
    evaluator: Evaluator, method: Method, train: Sequence[Part], held: Sequence[Part]
) -> tuple[tuple[str, str], ...]:
    out = own_provenance(evaluator)
    if method.name == "recursive":
        out.append(("forgetting", f"{method.forgetting:g}"))
    if method.prior is not None:
        given = np.concatenate([method.prior.mean, method.prior.std]).tobytes()
        out.append(("prior, sha256 of its means and std", hashlib.sha256(given).hexdigest()))
    for part in (*train, *held):
        out.append((f"{part.kind} {part.samples.name}, {LOG_DIGEST}", digest(part.samples)))
    return tuple(out)
