"""Assemble the estimate from a solution: its fit, its uses, and its provenance."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symgen.data.signals import Samples
from symgen.estimation.band import Band
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.floor import noise_accounts, noise_fit, quiet
from symgen.estimation.instrumental import bias_of_least_squares
from symgen.estimation.opening import samples_digest
from symgen.estimation.solve import Solution
from symgen.estimation.summary import Summary
from symgen.estimation.system import Equations
from symgen.estimation.torque_error import TorqueFit, equation_residual, percent
from symgen.estimation.values import FloatArray, OtherEstimate, Reason, Residual, Trace
from symgen.faults.fault import Fault
from symgen.identification.contacts import never_lifted
from symgen.identification.drives import drive_estimates
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
    with_incomplete_torques,
)
from symgen.identification.model_choice import ChosenModel
from symgen.identification.physical import implausible
from symgen.identification.scales import Scales
from symgen.identification.settle import Settled
from symgen.identification.simulation import simulation_use
from symgen.identification.solving import UNBIASED, EquatedLog, Method, rows_of
from symgen.identification.uses import Uses
from symgen.robot.toml_text import robot_toml
from symgen.runtime.evaluator import Evaluator

_PLENTY = 10  # independent equations per parameter below which a note warns
#: Condition number of the scaled regressor above which small errors of the data become large.
CONDITION = 500.0
#: Independent windows that each parameter needs.
WINDOWS = 3.0


@dataclass(frozen=True, eq=False)
class Outcome:
    """A solution and its fit to all equations and torques.

    Attributes:
        settled: the solution of the equations of the training logs.
        train, held: residuals of the equations of the training and of the validation logs.
        torque_train, torque_held: torques of the training and of the validation logs.
        windows: number of independent equations.
        repairs: repairs of the logs.
        notes: notes on long logs.
    """

    settled: Settled
    train: Residual
    held: Residual
    torque_train: TorqueFit
    torque_held: TorqueFit
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
    """Return the fit of a solution to the logs.

    Args:
        settled: the solution of the equations.
        model: model of the equations.
        equations: equations of the training and of the validation logs, or their summaries.
        torques: torques of the training and of the validation logs, at X.
        repairs, notes: see `Outcome`.
    """
    torque_train, torque_held = torques
    if model.name == "torque":
        residuals = torque_train.residual, torque_held.residual
    else:
        X, kinds = settled.solution.X, torque_train.sigma
        train, held = (equation_residual(parts, X, kinds) for parts in equations)
        residuals = train, held
    windows = sum(part.rows / part.correlation for part in equations[0])
    return Outcome(settled, *residuals, torque_train, torque_held, windows, repairs, notes)


def assess(chosen: ChosenModel, result: Outcome, accept: float, least: float) -> Estimate:
    """Return the estimate of a solution, with its fit, its verdict, and its curves.

    Args:
        chosen: the logs with the solved equations; for long logs, those of a sample.
        result: the solution and its fit to all logs.
        accept: largest torque error of a usable model, as a part of the torque.
        least: smallest torque that matters, as a part of the torque.
    """
    campaign, best, held = chosen.campaign, chosen.best, chosen.held
    model, train = best.model, best.train
    evaluator, robot = campaign.evaluator, campaign.robot
    settled = result.settled
    solution, method, bias = settled.solution, settled.method, ""
    if method.name not in UNBIASED and best.known is None:
        solution, bias = bias_of_least_squares(rows_of(train), solution, best.solution)
    X, std = solution.X, solution.std
    if best.known is not None:
        std = np.full(len(X), math.nan)
        std[best.known] = solution.std[best.known]
    parameters = _parameter_estimates(evaluator, X, std, campaign.scales)
    error = result.torque_held.in_motion.residual
    floor = noise_fit(evaluator, campaign.held, X).residual
    answer = with_incomplete_torques(campaign, X, floor)
    campaign = replace(campaign, answer=answer)
    unexplained = _unexplained(error, floor, least)
    limits = restrictions(chosen.proportional, robot)
    uses = Uses(
        prediction_use(campaign, settled, result.torque_held, floor, accept, least),
        parameters_use(
            parameters,
            settled,
            unexplained,
            bias,
            scale=scale_unknown(campaign),
            lift=[c.frame for c in never_lifted(robot, campaign.train)],
        ),
        simulation_use(campaign, X, parameters, limits),
    )
    headline = _headline(result.torque_held, floor, uses.prediction.large)
    model_traces = [t for part in (*train, *held) for t in _model_traces(part, model, X)]
    data = [(part.kind, part.log.samples) for part in (*train, *held)]
    prior = None
    if method.prior is not None:
        base = evaluator.model.base.names
        prior = OtherEstimate.by("prior", base, method.prior.mean, method.prior.std)
    size = np.sqrt(np.maximum(np.diag(solution.covariance), 0))
    size = np.where(size > 0, size, 1)
    labels = joints_of(robot)
    if campaign.scales is not None:
        units = [campaign.scales.unit_of(j, label.unit) for j, label in enumerate(labels)]
        labels = tuple(replace(x, unit=unit) for x, unit in zip(labels, units, strict=True))
    return Estimate(
        robot=robot.name,
        joints=labels,
        model=model.name,
        method=method.label,
        parameters=parameters,
        condition_number=solution.condition_number,
        train=result.train,
        validation=result.held,
        torque_train=result.torque_train.residual,
        torque_validation=result.torque_held.residual,
        moving=error,
        noise_floor=floor,
        unexplained=unexplained,
        cutoff_hz=campaign.band.cutoff_hz,
        window_s=None if model.name == "torque" else model.window,
        verdict="trusted" if uses.prediction.ok else "doubtful",
        reasons=uses.prediction.reasons,
        suspected=(
            *answer.suspected,
            *suspicions(campaign, solution, (result.torque_train, result.torque_held), accept),
        ),
        headline=BETWEEN_USES.join((headline, *uses.sentences)),
        uses=uses,
        band=campaign.band,
        alternatives=tuple(_alternatives(chosen.alternatives, method, solution, result)),
        repairs=result.repairs,
        drives=drive_estimates(campaign, solution),
        identifiable=chosen.identifiable,
        physical=settled.physical,
        at_bound=settled.at_bound,
        excludes=method.excludes,
        endogeneity=solution.endogeneity,
        comparison=solution.comparison,
        prior=prior,
        correlation=solution.covariance / np.outer(size, size),
        notes=(*_notes(chosen, solution, result), *result.notes),
        provenance=provenance(evaluator, data, _settings(method)),
        traces=(*model_traces, *result.torque_train.traces, *result.torque_held.traces),
    )


def _headline(held: TorqueFit, noise: Residual, large: Sequence[Reason]) -> str:
    """Return the torque error on held-out motion in one sentence, with the largest of a joint."""
    error = held.in_motion.residual.relative
    text = f"{percent(error)} torque error on motion it has not seen"
    if held.rest.any():
        text += f" ({percent(held.residual.relative)} over all samples)"
    text += "".join(f", up to {reason.text}" for reason in large[:1])
    return f"{text}; {noise_accounts(noise.relative, error)}."


def _unexplained(error: Residual, noise: Residual, least: float) -> float | None:
    """Return the part of the torque that neither model nor noise explains; None if invisible."""
    if quiet(error.per_joint or (), noise.per_joint or (), least):
        return None
    known = float(np.nan_to_num(noise.relative))  # the floor may be unknown
    return math.sqrt(max(error.relative**2 - known**2, 0.0))


def _parameter_estimates(
    evaluator: Evaluator, X: FloatArray, std: FloatArray, scales: Scales | None
) -> tuple[ParameterEstimate, ...]:
    """Return the base parameters with values and standard deviations, (p,) each."""
    robot, out = evaluator.model.robot, []
    positions = {number: k for k, number in enumerate(robot.numbers)}
    for b, x, s in zip(evaluator.model.base.parameters, X, std, strict=True):
        unit = b.unit
        if scales is not None:
            number = int(re.sub(r"\D", "", b.name))
            unit = scales.unit_of(positions[number], unit)
        out.append(ParameterEstimate(b.name, b.expression, float(x), float(s), unit))
    return tuple(out)


def _alternatives(
    models: Sequence[Alternative], method: Method, solution: Solution, result: Outcome
) -> list[Alternative]:
    """Return the models. The chosen one gets the fit to all logs instead of that to a sample."""
    out = []
    for model in models:
        if model.chosen and method.is_wls:
            model = replace(
                model,
                condition_number=solution.condition_number,
                train=result.torque_train.residual,
                validation=result.torque_held.residual,
            )
        out.append(model)
    return out


def _notes(chosen: ChosenModel, solution: Solution, result: Outcome) -> tuple[str, ...]:
    """Return notes on changes of the logs, and on the limits of the standard deviations."""
    campaign, count = chosen.campaign, len(solution.X)
    out = [*campaign.notes, *_of_rests(campaign.band, result.torque_held)]
    if not campaign.has_validation:
        out.append("no validation log is given: the last fifth of each log is held out")
    if result.windows < _PLENTY * count:
        out.append(
            f"{result.windows:.0f} independent equations for {count} parameters: under "
            f"{_PLENTY} each, the standard deviations tend to be too small"
        )
    out += solution.notes
    if len(set(solution.weights)) > 1:
        ratio = max(solution.weights) / min(solution.weights)
        out.append(
            f"equations are weighted by log and joint; largest over smallest weight: {ratio:.3g}"
        )
    out.append(implausible(campaign.evaluator, campaign.train, solution.X))
    return tuple(filter(None, out))


def _of_rests(band: Band, held: TorqueFit) -> tuple[str, ...]:
    """Return a note on the weight of samples at rest, if the validation logs have any."""
    if band.rests is None:
        return ()
    low = f"{min(band.rests.weight):.2g}"
    high = f"{max(band.rests.weight):.2g}"
    weights = low if low == high else f"{low} to {high}"
    return tuple(
        "joints stand still at times, where static friction can take any value between its limits: "
        f"{errors}; rows at rest have {weights} times the weight of "
        "rows in motion"
        for errors in held.motion_note
    )


def symgen_version() -> str:
    """Return the version of symgen; "unknown" if it is not installed."""
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
    """Return the provenance of an estimate: version of symgen, backend, robot, and logs.

    Args:
        evaluator: the compiled model.
        logs: kind and samples of each log.
        more: further pairs of label and value, which come before the logs.
    """
    robot = hashlib.sha256(robot_toml(evaluator.model.robot).encode()).hexdigest()
    head = (("symgen", symgen_version()), ("backend", evaluator.backend), (ROBOT_DIGEST, robot))
    data = ((f"{kind} {s.name}, {LOG_DIGEST}", samples_digest(s)) for kind, s in logs)
    return (*head, *more, *data)


def _settings(method: Method) -> list[tuple[str, str]]:
    """Return the options of a method, for the provenance of an estimate."""
    out = []
    if method.name == "recursive":
        out.append(("forgetting", f"{method.forgetting:g}"))
    if method.prior is not None:
        content = np.concatenate([method.prior.mean, method.prior.std]).tobytes()
        out.append(("prior, sha256 of its means and std", hashlib.sha256(content).hexdigest()))
    return out


def _model_traces(part: EquatedLog, model: EquationModel, X: FloatArray) -> tuple[Trace, ...]:
    """Return the measured and predicted sides of the equations of a model, for plots."""
    if model.name == "torque":  # `fit` has these curves
        return ()
    rows = part.equations
    used = rows.weight.all(axis=1)  # masks differ by joint
    measured, predicted = rows.y[used], rows.W[used] @ X
    return (Trace(part.log.name, part.kind, model.name, rows.t[used], measured, predicted),)
