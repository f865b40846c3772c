"""Choose the model of a run.

Three models give the same parameters from the same filtered logs: energy, momentum and torque.
symgen keeps the one with the smallest torque error, in the comparison band, on held-out folds of
the training logs. The fits to the other folds have a weak prior, since these folds alone may not
determine all parameters. Of models that are as good, symgen prefers momentum to energy, and energy
to torque, which needs accelerations: they are noisier than speeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symgen.errors import IdentificationError, LogError
from symgen.estimation.equation_model import EquationModel
from symgen.estimation.estimators import Wls
from symgen.estimation.features import features_of
from symgen.estimation.masking import require_equations
from symgen.estimation.opening import Source
from symgen.estimation.solve import (
    Solution,
    identifiable_columns,
)
from symgen.estimation.summary import Blocks, block_summary, summaries
from symgen.estimation.torque_error import TorqueFit, percent
from symgen.identification.campaign import Campaign
from symgen.identification.contacts import hidden_in_power, identifiable
from symgen.identification.estimate import Alternative, Identifiable
from symgen.identification.instruments import instrumented
from symgen.identification.proportional import blame_motion, motion_fault, proportional_joints
from symgen.identification.solving import (
    EquatedLog,
    Method,
    noise_columns,
    rows_of,
    settle_load,
    solve_equations,
)
from symgen.identification.weak_prior import WeakPrior
from symgen.parallel import Say
from symgen.policy import AS_GOOD, KNOWN, ROUNDING, VARIES
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

#: Torque equations, on which the models are compared.
_COMPARED = EquationModel("torque", 0.0)
#: Models in the order of preference if they are as good.
_PREFERRED = ("momentum", "energy", "torque")
#: Factor of the information of a prior that has no effect.
_NONE = 1e-9


@dataclass(frozen=True, eq=False)
class ModelCandidate:
    """A model with its equations and its weighted least-squares solution.

    Attributes:
        model: model of the equations.
        train: the training logs with their equations.
        blocks: summaries of the equations and of the torques, by blocks of time.
        prior: weak prior for what the equations do not determine.
        held_out: torque error on held-out folds, of fits with the prior.
        known: indices of the parameters that the equations determine; None for all.
        solution: the weighted least-squares solution, with the prior if the equations do not
            determine all parameters; None if there is none.
        torques: torques of the training and of the validation logs; empty without a solution.
        error: the error of the solver, if there is no solution.
    """

    model: EquationModel
    train: list[EquatedLog]
    blocks: tuple[Blocks, Blocks]
    prior: WeakPrior
    held_out: float = math.inf
    known: list[int] | None = None
    solution: Solution | None = None
    torques: tuple[TorqueFit, ...] = ()
    error: Exception | None = None

    @property
    def needed_prior(self) -> WeakPrior | None:
        """The prior if the equations do not determine all parameters."""
        return None if self.known is None else self.prior

    @cached_property
    def without_prior(self) -> float:
        """Torque error on held-out folds, of fits without the prior."""
        weaker = replace(self.prior, information=_NONE * self.prior.information)
        return weaker.held_out(self.blocks).relative

    @property
    def folds_tell(self) -> bool:
        """Whether the other folds determine the parameters without the prior."""
        return self.without_prior <= VARIES * self.held_out


@dataclass(frozen=True, eq=False)
class ChosenModel:
    """The logs of a run and the chosen model.

    Attributes:
        campaign: the logs.
        best: the chosen model. Its solution is None if the robot has load-dependent effects.
        held: the validation logs with the equations of the model.
        alternatives: the results of all fitted models, the chosen one first.
        fault: a text on a fault of the motion, or "".
        proportional: groups of joints whose speeds are proportional in all training logs.
        identifiable: for a floating base, what its logs can determine; else None.
    """

    campaign: Campaign
    best: ModelCandidate
    held: list[EquatedLog]
    alternatives: tuple[Alternative, ...]
    fault: str
    proportional: tuple[tuple[int, ...], ...]
    identifiable: Identifiable | None = None


def choose_model(
    campaign: Campaign,
    models: Sequence[EquationModel],
    method: Method,
    motions: Sequence[Source],
    progress: Say,
) -> ChosenModel:
    """Fit the models and keep the one with the smallest held-out torque error.

    Args:
        campaign: the logs.
        models: models to fit.
        method: method that later solves the equations of the chosen model.
        motions: commanded motion of each training log; empty if there are none.
        progress: called with a text about the current step.

    Raises:
        IdentificationError: no model fits these logs; the reason is that of the first model.
        LogError: a mask leaves too few samples, or a validation log is too short.
    """
    evaluator, robot = campaign.evaluator, campaign.robot
    proportional = proportional_joints(campaign.train)
    fault = motion_fault(proportional, robot)
    known = features_of(campaign.train, robot.sigma) if robot.n else None
    models = [replace(model, features=known) for model in models]
    alternatives: tuple[Alternative, ...] = ()
    shown = identifiable(evaluator.model, campaign.train) if robot.floating else None
    if robot.loaded:
        progress("settling the effects that hold the model's torque")
        model = settle_load(evaluator, campaign.train, models[0])
        train = _equations(campaign, model)
        torques = block_summary(rows_of(train), model.gap)
        prior = _weak_prior(campaign, train)
        best = ModelCandidate(model, train, (torques, torques), prior)
    else:
        progress(f"fitting {', '.join(m.name for m in models)}")
        # A prior determines the parameters that the motion does not.
        partial = bool(proportional) and method.prior is None
        with blame_motion(fault):
            best, alternatives = _best_model(campaign, models, partial, shown)
    train = []
    for k, part in enumerate(best.train):
        if method.name == "iv" or method.is_tested(part.log):
            part = instrumented(evaluator, part, best.model, motions[k] if motions else None)
        train.append(part)
    try:
        held = []
        for log in campaign.held:
            equations = best.model.equations(evaluator, log)
            held.append(EquatedLog("validation", log, equations))
    except IdentificationError as error:
        what = "; accepted: a longer log, or a second one for validation"
        raise LogError(f"{error}{what}") from error
    _require_equations(held, robot)
    return ChosenModel(
        campaign, replace(best, train=train), held, alternatives, fault, proportional, shown
    )


def _equations(campaign: Campaign, model: EquationModel) -> list[EquatedLog]:
    """Return the training logs with the equations of a model."""
    logs = [
        EquatedLog("train", log, model.equations(campaign.evaluator, log)) for log in campaign.train
    ]
    _require_equations(logs, campaign.robot)
    return logs


def _require_equations(logs: Sequence[EquatedLog], robot: Robot) -> None:
    """Refuse logs whose masks leave too few equations."""
    for part in logs:
        require_equations(part.log, part.equations, robot)


def _best_model(
    campaign: Campaign, models: Sequence[EquationModel], partial: bool, shown: Identifiable | None
) -> tuple[ModelCandidate, tuple[Alternative, ...]]:
    """Fit every model and compare them on folds of the training logs.

    Args:
        campaign: the logs.
        models: models to fit.
        partial: whether the equations may determine only some of the parameters.
        shown: for a floating base, what its logs can determine.

    Returns:
        The model with the smallest torque error, the first of equals, and the results of all
        models, that one first.
    """
    evaluator = campaign.evaluator
    hidden = () if shown is None else shown.unknown
    compared = _equations(campaign, replace(_COMPARED, features=models[0].features))
    torques = block_summary(rows_of(compared), _COMPARED.gap)
    candidates, errors = list[ModelCandidate](), dict[str, IdentificationError]()
    for model in models:
        try:
            train = compared
            if model.name != _COMPARED.name:
                train = _equations(campaign, model)
        except IdentificationError as error:
            errors[model.name] = error
            continue
        blocks = block_summary(rows_of(train), model.gap)
        prior = _weak_prior(campaign, train)
        held_out = prior.held_out((blocks, torques)).relative
        unknown = hidden
        if campaign.robot.floating and model.name == "energy":
            unknown = hidden_in_power(evaluator.model, campaign.train)
        known = (
            _known_parameters(campaign, train, model) if partial else _others(evaluator, unknown)
        )
        candidate = ModelCandidate(model, train, (blocks, torques), prior, held_out, known)
        candidates.append(_solved(campaign, candidate))
    if not candidates:
        raise next(iter(errors.values()))
    least = min(candidate.held_out for candidate in candidates)
    limit = AS_GOOD * max(least, ROUNDING)
    candidates.sort(key=lambda c: (max(c.held_out, limit), _PREFERRED.index(c.model.name)))
    best = candidates[0]
    alternatives = [_alternative(candidate, best) for candidate in candidates]
    for name, reason in errors.items():
        alternatives.append(Alternative(name, math.inf, None, None, math.inf, False, str(reason)))
    return best, tuple(alternatives)


def _solved(campaign: Campaign, candidate: ModelCandidate) -> ModelCandidate:
    """Return a candidate with its solution, or with the error of the solver."""
    plain, model = Method(Wls.name), candidate.model
    try:
        solution = solve_equations(candidate.train, plain, model, candidate.needed_prior)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return replace(candidate, error=error)
    return replace(candidate, solution=solution, torques=campaign.torques(solution.X))


def _others(evaluator: Evaluator, unknown: Sequence[str]) -> list[int] | None:
    """Return the numbers of the other parameters; None for all."""
    names = evaluator.model.base.names
    return [k for k, name in enumerate(names) if name not in unknown] if unknown else None


def _weak_prior(campaign: Campaign, train: Sequence[EquatedLog]) -> WeakPrior:
    """Return the weak prior for the equations of the training logs."""
    return WeakPrior.of(campaign.evaluator.model, summaries(rows_of(train).parts))


def _known_parameters(
    campaign: Campaign, train: Sequence[EquatedLog], model: EquationModel
) -> list[int] | None:
    """Return the parameters that some equations determine beyond noise; None for all.

    Noise E of the regressor W biases least squares: along a direction v of the parameters, by the
    share ||E v||^2 / ||W v||^2 (Fuller 1987, section 1.1). The equations determine v if this share
    is below `symgen.policy.KNOWN`.
    """
    W = np.concatenate([e.W for e in rows_of(train).parts])
    evaluator = campaign.evaluator
    noise = noise_columns(lambda log: model.equations(evaluator, log), campaign.train)
    known = identifiable_columns(W, noise / math.sqrt(KNOWN)).known
    return None if len(known) == W.shape[1] else known


def _alternative(candidate: ModelCandidate, best: ModelCandidate) -> Alternative:
    """Return the result of a model, compared with the best one."""
    number, train, held = math.inf, None, None
    reason = f"{percent(candidate.held_out)} torque error on folds left out"
    if not candidate.folds_tell:
        without = percent(candidate.without_prior)
        reason += (
            f" with a weak prior (without it {without}: folds do not determine all parameters)"
        )
    if candidate.held_out > best.held_out:
        reason += f", {candidate.held_out / max(best.held_out, 1e-300):.3g} times the best"
    if candidate.error is not None:
        reason += f"; {candidate.error}"
    if candidate.solution is not None:
        number = candidate.solution.condition_number
        train, held = (fit.residual for fit in candidate.torques)
    return Alternative(
        candidate.model.name, number, train, held, candidate.held_out, candidate is best, reason
    )
