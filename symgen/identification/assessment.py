"""The estimate that a solution is: its fit, what it may be used for, and how it was made."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from symgen.data.signals import Samples
from symgen.estimation.band import Band
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.floor import quiet
from symgen.estimation.instrumental import bias_of_least_squares
from symgen.estimation.logs import samples_digest
from symgen.estimation.motion_error import motion_error
from symgen.estimation.solve import Solution
from symgen.estimation.summary import Summary
from symgen.estimation.system import Equations
from symgen.estimation.torque_error import TorqueFit, equation_residual, percent
from symgen.estimation.values import FloatArray, OtherEstimate, Residual, Trace
from symgen.faults.fault import Fault
from symgen.identification.estimate import (
    BETWEEN_USES,
    LOG_DIGEST,
    ROBOT_DIGEST,
    Alternative,
    Estimate,
    ParameterEstimate,
    joints_of,
)
from symgen.identification.judgement import (
    parameters_use,
    prediction_use,
    restrictions,
    scale_unknown,
    suspicions,
)
from symgen.identification.model_choice import ChosenModel
from symgen.identification.physical import implausible
from symgen.identification.settle import Settled
from symgen.identification.simulation import simulation_use
from symgen.identification.solving import UNBIASED, EquatedLog, Method, system_of
from symgen.identification.uses import Uses
from symgen.robot.toml_text import robot_toml
from symgen.runtime.evaluator import Evaluator

_PLENTY = 10  # independent equations for each parameter
#: Condition number of the scaled regressor above which small errors of the data become large.
CONDITION = 500.0
#: Independent windows that each parameter needs.
WINDOWS = 3.0


@dataclass(frozen=True, eq=False)
class Outcome:
    """A solution, and how it fits all equations and torques.

    Attributes:
        settled: the solution of the equations of the training logs.
        train: residual of these equations.
        held: of those of the validation logs.
        own: torques of the training logs.
        seen: of the validation logs.
        windows: number of independent equations.
        repairs: what was mended in the logs.
        notes: of the logs, beside those of every run.
    """

    settled: Settled
    train: Residual
    held: Residual
    own: TorqueFit
    seen: TorqueFit
    windows: float
    repairs: tuple[Fault, ...]
    notes: tuple[str, ...] = ()


def outcome(
    settled: Settled,
    model: EquationModel,
    equations: tuple[Sequence[Equations | Summary], Sequence[Equations | Summary]],
    torques: Sequence[TorqueFit],
    repairs: tuple[Fault, ...],
    notes: tuple[str, ...] = (),
) -> Outcome:
    """Return how a solution fits the logs.

    Args:
        settled: the solution of the equations.
        model: of the equations.
        equations: of the training and of the validation logs, or their summaries.
        torques: of both, at X.
        repairs, notes: see `Outcome`.
    """
    own, seen = torques
    if model.name == "torque":
        residuals = own.residual, seen.residual
    else:
        train, held = (equation_residual(parts, settled.solution.X) for parts in equations)
        residuals = train, held
    windows = sum(part.rows / part.correlation for part in equations[0])
    return Outcome(settled, *residuals, own, seen, windows, repairs, notes)


def assess(
    chosen: ChosenModel,
    found: Outcome,
    own_values: FloatArray | None,
    accept: float,
    least: float,
) -> Estimate:
    """Return the estimate that a solution is, with its fit, its verdict, and what is drawn of it.

    Args:
        chosen: the run with the equations that were solved, or with those of a sample.
        found: the solution, and how it fits all logs.
        own_values: parameters (p,) of the robot's own file, None where it has none.
        accept: largest torque error of a usable model, as a part of the torque.
        least: smallest torque that matters, as a part of the torque.
    """
    run, best, held = chosen.run, chosen.best, chosen.held
    model, train = best.model, best.train
    evaluator, robot = run.evaluator, run.evaluator.model.robot
    settled = found.settled
    solution, method, bias = settled.solution, settled.method, ""
    if method.name not in UNBIASED and best.columns is None:
        system = system_of(evaluator, train)
        solution, bias = bias_of_least_squares(system, solution, best.solution)
    X, std = solution.X, solution.std
    if best.columns is not None:
        known = best.columns.known
        std = np.full(len(X), math.nan)
        std[known] = solution.std[known]
    parameters = _parameter_estimates(evaluator, X, std)
    judged = motion_error(evaluator, run.held, X, found.seen)
    error, floor = judged.error, judged.noise
    unexplained = _unexplained(error, floor, least)
    limits = restrictions(chosen.together, robot)
    uses = Uses(
        prediction_use(run, settled, found.seen, floor, accept, least),
        parameters_use(parameters, settled, unexplained, bias, scaled=scale_unknown(run)),
        simulation_use(evaluator, (run.train, run.held), X, parameters, limits, own_values),
    )
    own_traces = [t for part in (*train, *held) for t in _model_traces(part, model, X)]
    data = [(part.kind, part.log.samples) for part in (*train, *held)]
    prior = None
    if method.prior is not None:
        base = evaluator.model.base.names
        prior = OtherEstimate.by("prior", base, method.prior.mean, method.prior.std)
    size = np.sqrt(np.maximum(np.diag(solution.covariance), 0))
    size = np.where(size > 0, size, 1)
    return Estimate(
        robot=robot.name,
        joints=joints_of(robot),
        model=model.name,
        method=method.label,
        parameters=parameters,
        condition_number=solution.condition_number,
        train=found.train,
        validation=found.held,
        torque_train=found.own.residual,
        torque_validation=found.seen.residual,
        moving=error,
        noise_floor=floor,
        unexplained=unexplained,
        cutoff_hz=run.band.cutoff_hz,
        window_s=None if model.name == "torque" else model.window,
        verdict="trusted" if uses.prediction.ok else "doubtful",
        reasons=uses.prediction.reasons,
        suspected=(*run.suspected, *suspicions(run, solution, found.seen, accept)),
        headline=BETWEEN_USES.join((_headline(found.seen, floor), *uses.sentences)),
        uses=uses,
        band=run.band,
        alternatives=tuple(_alternatives(chosen.found, method, solution, found)),
        repairs=found.repairs,
        physical=settled.physical,
        at_bound=settled.at_bound,
        excludes=method.excludes,
        endogeneity=solution.endogeneity,
        comparison=solution.comparison,
        prior=prior,
        correlation=solution.covariance / np.outer(size, size),
        notes=(*_notes(chosen, solution, found), *found.notes),
        provenance=provenance(evaluator, data, _settings(method)),
        traces=(*own_traces, *found.own.traces, *found.seen.traces),
    )


def _headline(seen: TorqueFit, noise: Residual) -> str:
    """Return the torque error on held-out motion in one sentence."""
    error = seen.in_motion.residual.relative
    text = f"{percent(error)} torque error on motion it has not seen"
    if seen.rest.any():
        text += f" ({percent(seen.residual.relative)} with joints at rest)"
    if math.isnan(noise.relative):
        return f"{text}; the noise floor is unknown."
    return f"{text}; noise accounts for {percent(noise.relative)}."


def _unexplained(error: Residual, noise: Residual, least: float) -> float | None:
    """Return the part of a torque that noise does not explain; None where no joint shows any."""
    if quiet(error.per_joint or (), noise.per_joint or (), least):
        return None
    known = float(np.nan_to_num(noise.relative))  # the floor may be unknown
    return math.sqrt(max(error.relative**2 - known**2, 0.0))


def _parameter_estimates(
    evaluator: Evaluator, X: FloatArray, std: FloatArray
) -> tuple[ParameterEstimate, ...]:
    """Return the base parameters with values and standard deviations, (p,) each."""
    return tuple(
        ParameterEstimate(b.name, b.expression, float(x), float(s), b.unit)
        for b, x, s in zip(evaluator.model.base.parameters, X, std, strict=True)
    )


def _alternatives(
    models: Sequence[Alternative], method: Method, solution: Solution, found: Outcome
) -> list[Alternative]:
    """Return the models; the chosen one with the fit of all logs, not of the sample it had."""
    out = []
    for model in models:
        if model.chosen and method.is_wls:
            model = replace(
                model,
                condition_number=solution.condition_number,
                train=found.own.residual,
                validation=found.seen.residual,
            )
        out.append(model)
    return out


def _notes(chosen: ChosenModel, solution: Solution, found: Outcome) -> tuple[str, ...]:
    """Say what was done to the logs, and what the intervals do not tell."""
    run, count = chosen.run, len(solution.X)
    out = [note for log in run.logs for note in log.samples.notes]
    out += [f"band: {run.band.in_words()}", *_of_rests(run.band, found.seen)]
    if not run.given:
        out.append("no validation log is given: the last fifth of each log is held out")
    if found.windows < _PLENTY * count:
        out.append(
            f"{found.windows:.0f} independent equations for {count} parameters: under "
            f"{_PLENTY} each, the standard deviations tend to be too small"
        )
    out += solution.notes
    if len(set(solution.weights)) > 1:
        ratio = max(solution.weights) / min(solution.weights)
        out.append(
            f"equations are weighted by log and joint; largest over smallest weight: {ratio:.3g}"
        )
    out.append(implausible(run.evaluator, run.train, solution.X))
    return tuple(filter(None, out))


def _of_rests(band: Band, seen: TorqueFit) -> tuple[str, ...]:
    """Say what rests do, where the logs that judge have any."""
    if band.rests is None:
        return ()
    low, high = (f"{w:.2g}" for w in (min(band.rests.weight), max(band.rests.weight)))
    weights = low if low == high else f"{low} to {high}"
    return tuple(
        "joints stand still at times, where static friction can take any value between its limits: "
        f"{told}; rows at rest have {weights} times the weight of "
        "rows in motion"
        for told in seen.motion_note
    )


def own_version() -> str:
    """Return symgen's version; "unknown" where it is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("symgen")
    except PackageNotFoundError:
        return "unknown"


def provenance(
    evaluator: Evaluator,
    logs: Iterable[tuple[str, Samples]],
    more: Iterable[tuple[str, str]] = (),
) -> tuple[tuple[str, str], ...]:
    """Return what made an estimate: symgen's version, the backend, the robot, and the logs.

    Args:
        evaluator: the compiled model.
        logs: with their kind.
        more: what else has to be told, before the logs.
    """
    robot = hashlib.sha256(robot_toml(evaluator.model.robot).encode()).hexdigest()
    own = (("symgen", own_version()), ("backend", evaluator.backend), (ROBOT_DIGEST, robot))
    data = ((f"{kind} {s.name}, {LOG_DIGEST}", samples_digest(s)) for kind, s in logs)
    return (*own, *more, *data)


def _settings(method: Method) -> list[tuple[str, str]]:
    """Return what the provenance of an estimate says of its method."""
    out = []
    if method.name == "recursive":
        out.append(("forgetting", f"{method.forgetting:g}"))
    if method.prior is not None:
        given = np.concatenate([method.prior.mean, method.prior.std]).tobytes()
        out.append(("prior, sha256 of its means and std", hashlib.sha256(given).hexdigest()))
    return out


def _model_traces(part: EquatedLog, model: EquationModel, X: FloatArray) -> tuple[Trace, ...]:
    """Return what the model's own equations measure and predict, for drawing."""
    if model.name == "torque":  # drawn from `fit`
        return ()
    t = reduce(np.intersect1d, [e.t for e in part.equations])  # a mask is by joint
    kept = [(e, np.isin(e.t, t)) for e in part.equations]
    measured = np.stack([(e.y / e.scale)[k] for e, k in kept], axis=1)
    predicted = np.stack([(e.W @ X / e.scale)[k] for e, k in kept], axis=1)
    return (Trace(part.log.name, part.kind, model.name, t, measured, predicted),)
