"""identify: estimate parameters from a robot and its logs, with a verdict.

open logs -> choose band -> undo delay -> equations -> choose model -> solve -> assess
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

from symgen.data.long_logs import LIMIT, expanded, is_long
from symgen.data.raw import Reading
from symgen.errors import IdentificationError
from symgen.estimation.equation_model import (
    NEEDED,
    EquationModel,
    models_of,
    require_model,
)
from symgen.estimation.estimators import Estimator
from symgen.estimation.opening import (
    Source,
    listed_logs,
    require_logs,
)
from symgen.estimation.solve import Solution
from symgen.identification.assessment import (
    Outcome,
    assess,
    outcome,
)
from symgen.identification.campaign import Campaign, Filtering, open_campaign
from symgen.identification.drives import in_torques, with_back_emf
from symgen.identification.estimate import UNCHECKED, Estimate
from symgen.identification.model_choice import ChosenModel, choose_model
from symgen.identification.parameters import read_prior
from symgen.identification.proportional import blame_motion
from symgen.identification.searched import searched
from symgen.identification.segments import solve_segments
from symgen.identification.settle import Settled, settle
from symgen.identification.solving import AUTO, FOLDED, FitOptions, Method, rows_of, solve_equations
from symgen.parallel import Say, silent
from symgen.policy import ACCEPT, LEAST
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator

MODELS = (AUTO, *NEEDED)


def identify(
    robot: Robot | str | Path | Evaluator,
    logs: Sequence[Source] | Source,
    *,
    validation: Sequence[Source] | Source = (),
    model: str = AUTO,
    method: str | Estimator = AUTO,
    window: float = 0.2,
    cutoff: float | None = None,
    accept: float = ACCEPT,
    least: float = LEAST,
    fit: FitOptions | None = None,
    reading: Reading | None = None,
    exact: bool = False,
    executor: Executor | None = None,
    progress: Say = silent,
) -> Estimate:
    """Identify a robot's base parameters from measured logs.

    symgen reads files with more than 2**18 samples in total, and files at a URL, segment by segment
    (see `symgen.identification.segments`).

    Args:
        robot: a robot, a path or library name, or a loaded evaluator.
        logs: training logs or their paths; a pattern or a folder stands for its files.
        validation: held-out logs for the verdict; if empty, the last fifth of each log is held out.
        model: "energy", the model of Gautier and Khalil; "momentum", with n equations for each
            window; "torque", with filtered accelerations; "auto", which fits all three and keeps
            the one with the smallest torque error on held-out folds of the training logs.
        method: an estimator, such as `symgen.Wls()`, or its name: "wls" (each log and joint has a
            weight from its own residual), "ols", "huber", "tls", "iv", "consistent" (the nearest
            physically possible parameters), or "recursive" (least squares with forgetting). The
            default "auto" is "consistent". If that raises the torque error on held-out folds, it is
            "wls".
        window: length of the sliding windows of energy and momentum, s.
        cutoff: cutoff of the zero-phase filter of positions and speeds, Hz; by default the one with
            the smallest torque error on held-out folds of the training logs.
        accept: largest torque error on held-out motion of a usable model, as a part of the torque.
        least: smallest torque that matters, as a part of the joint's torque.
        fit: prior, commanded motions, forgetting.
        reading: columns, span and masks of the logs.
        exact: whether to keep parameters that only the exact geometry separates.
        executor: executor of the work on segments of long logs, for example
            `dask.distributed.Client.get_executor()`. None for threads of this process, one for each
            core, at most four.
        progress: called with a text about the current step.

    Returns:
        The estimate, with standard deviations, residuals on held-out data, and a verdict.

    Raises:
        LogError: symgen cannot read a log, or it belongs to another robot.
        IdentificationError: an option is invalid, or the logs do not determine the parameters.
    """
    source = read_robot(robot.model.robot if isinstance(robot, Evaluator) else robot)
    source = replace(source, exact=exact or source.exact)
    options = fit or FitOptions()
    about = Settings.of(source, model, method, window, options, accept, least)
    sources, held = expanded(listed_logs(logs)), expanded(listed_logs(validation))
    carried = expanded(listed_logs(options.carried))
    motions = options.motions(len(sources), about.method.name)
    require_logs(sources)
    body = options.body
    needed = _needs_memory(source, about.method, options)
    if needed and is_long([*sources, *held]):
        raise IdentificationError(
            f"{needed} on a long log; accepted: methods {', '.join(FOLDED)} alone, or files "
            f"on a disk of {LIMIT:,} samples together"
        )
    filtering = Filtering(cutoff, own_speeds=about.method.name == "iv" and not motions)
    campaign = open_campaign(
        robot, source, (sources, held), about.models, reading, filtering, progress, executor
    )
    campaign = in_torques(campaign, robot, carried, body, reading)
    about = replace(about.with_prior(options, campaign.evaluator), motions=tuple(motions))
    estimate = identified(campaign, about).estimate
    opened = expanded(listed_logs(options.opened))
    return with_back_emf(estimate, campaign, robot, opened, reading) if opened else estimate


@dataclass(frozen=True, eq=False)
class Settings:
    """Options of an identification, besides those of reading.

    Attributes:
        models: models to fit.
        method: method of the solution.
        motions: commanded motion of each training log; empty if there are none.
        accept: largest torque error of a usable model, as a part of the torque.
        least: smallest torque that matters, as a part of the joint's torque.
    """

    models: tuple[EquationModel, ...]
    method: Method
    motions: tuple[Source, ...] = ()
    accept: float = ACCEPT
    least: float = LEAST

    @classmethod
    def of(
        cls,
        robot: Robot,
        model: str = AUTO,
        method: str | Estimator = AUTO,
        window: float = 0.2,
        fit: FitOptions | None = None,
        accept: float = ACCEPT,
        least: float = LEAST,
    ) -> Settings:
        """Return the settings for the arguments of `identify`.

        Raises:
            IdentificationError: an argument is invalid.
        """
        if model not in MODELS:
            raise IdentificationError(f"model {model!r}; accepted: {', '.join(MODELS)}")
        if not (math.isfinite(window) and window > 0):
            raise IdentificationError(f"a window of {window:g} s; accepted: a length above 0")
        by = Method.of(method, (fit or FitOptions()).forgetting)
        models = _equation_models(robot, model, window, by)
        return cls(models, by, (), accept, least)

    def with_prior(self, fit: FitOptions, evaluator: Evaluator) -> Settings:
        """Return the settings with the prior of a fit."""
        if fit.prior is None:
            return self
        prior = read_prior(fit.prior, evaluator.model)
        return replace(self, method=replace(self.method, prior=prior))


@dataclass(frozen=True, eq=False)
class Solved:
    """The chosen model of some logs, and its solution."""

    chosen: ChosenModel
    outcome: Outcome

    @property
    def campaign(self) -> Campaign:
        """The logs, with what a search undid."""
        return self.chosen.campaign


@dataclass(frozen=True, eq=False)
class Identified(Solved):
    """An identification: a solved model and its estimate."""

    estimate: Estimate


def identified(campaign: Campaign, settings: Settings) -> Identified:
    """Undo faults of the logs, choose the model, solve and judge."""
    campaign.progress("searching for faults of the logs and missing effects")
    campaign = searched(campaign, settings.least)
    by, progress = settings.method, campaign.progress
    chosen = choose_model(campaign, settings.models, by, settings.motions, progress)
    with blame_motion(chosen.fault):
        result = _solve(chosen, by)
    solution = result.settled.solution
    if campaign.scales is not None:
        names = campaign.evaluator.model.base.names
        solution = campaign.scales.with_uncertainty(solution, names)
    if campaign.imu is not None:
        solution = campaign.imu.with_uncertainty(solution)
    result = replace(result, settled=replace(result.settled, solution=solution))
    progress("judging")
    estimate = assess(chosen, result, settings.accept, settings.least)
    return Identified(chosen, result, estimate)


def solved(campaign: Campaign, settings: Settings) -> Solved:
    """Choose the model and solve it by least squares, without a search or a judgement."""
    plain = settings.method.unconstrained
    chosen = choose_model(campaign, settings.models, plain, settings.motions, campaign.progress)
    settled = Settled(_least_squares(chosen, plain), plain, UNCHECKED)
    return Solved(chosen, _outcome(chosen, settled))


def _solve(chosen: ChosenModel, method: Method) -> Outcome:
    """Solve the equations of the chosen model, over all segments of long logs."""
    if chosen.campaign.long is not None:
        return solve_segments(chosen, method)
    rows = sum(part.equations.count for part in chosen.best.train)
    names = chosen.campaign.evaluator.model.base.names
    chosen.campaign.progress(f"solving {rows} equations for {len(names)} parameters")
    solution = _least_squares(chosen, method)
    return _outcome(chosen, settle(chosen, method, solution, chosen.best.prior))


def _least_squares(chosen: ChosenModel, method: Method) -> Solution:
    """Return the solution without constraints, if possible that of the choice."""
    best = chosen.best
    if method.is_wls and best.solution is not None:
        return best.solution
    return solve_equations(best.train, method, best.model, best.needed_prior)


def _outcome(chosen: ChosenModel, settled: Settled) -> Outcome:
    """Return the fit of a solution to logs in memory."""
    campaign, best, X = chosen.campaign, chosen.best, settled.solution.X
    is_plain = best.solution is not None and X is best.solution.X
    torques = best.torques if is_plain else campaign.torques(X)
    train, held = (rows_of(logs).parts for logs in (best.train, chosen.held))
    return outcome(settled, best.model, (train, held), torques, campaign.repairs)


def _equation_models(
    robot: Robot, model: str, window: float, method: Method
) -> tuple[EquationModel, ...]:
    """Return the models to fit."""
    tried = models_of(robot) if model == AUTO else (model,)
    for name in tried:
        require_model(robot, name)
    if model == AUTO and method.name == "recursive":
        tried = tuple(m for m in tried if m != "torque") or tried
    return tuple(EquationModel(name, window) for name in tried)


def _needs_memory(robot: Robot, method: Method, options: FitOptions) -> str:
    """Return the option that needs all samples in memory, or ""."""
    needed = {
        "prior": options.prior,
        "effects that hold the torque of links": robot.loaded,
        f"method {method.label}": not method.plain,
    }
    return next((name for name, value in needed.items() if value), "")
