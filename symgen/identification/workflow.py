"""identify: from a robot and its logs to an estimate with a verdict.

Three passes over the logs. Look: they are read, mended, and the band of the run is chosen. Solve:
the equations of every model in that band. Judge: torques, energies and precision of what was found.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from symgen.codegen.model import derive
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.distributed import Workers, executor
from symgen.errors import IdentificationError
from symgen.estimation.equation_model import JUDGING, NEEDED, Recipe
from symgen.estimation.estimators import Estimator, bias_of_least_squares
from symgen.estimation.logs import (
    Source,
    held_out,
    listed_logs,
    require_logs,
    require_other_data,
)
from symgen.estimation.solve import Solution
from symgen.estimation.torque_error import TorqueFit
from symgen.faults.fault import Fault
from symgen.faults.logs import open_logs
from symgen.identification.assessment import judged, outcome
from symgen.identification.estimate import Estimate
from symgen.identification.model_choice import (
    Run,
    checked_run,
    chosen_case,
    determined,
    looked_at,
    require_condition,
)
from symgen.identification.out_of_core import identify_data_set, is_long, paths_of
from symgen.identification.parameters import read_prior
from symgen.identification.solving import Fit, Method, solved
from symgen.identification.static import METHODS as POSE_METHODS
from symgen.identification.static import STATIC, identify_poses
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.symbolic.near_angles import told_of_angles

AUTO = "auto"
MODELS = (AUTO, *NEEDED, STATIC)
_FEWEST = 10  # samples held out


def identify(
    robot: Robot | str | Path | Evaluator,
    logs: Sequence[Source] | Source,
    *,
    validation: Sequence[Source] | Source = (),
    model: str = AUTO,
    method: str | Estimator = "wls",
    window: float = 0.2,
    cutoff: float | None = None,
    fit: Fit | None = None,
    reading: Reading | None = None,
    workers: Workers | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Estimate:
    """Identify a robot's base parameters from measured logs.

    Logs that are a data set (a pattern, a folder, a URL), or for which workers are given, or
    Parquet and NPZ files of many samples for least squares, are read chunk by chunk, see
    `symgen.identification.out_of_core`.

    Args:
        robot: a robot, a path or library name, or a loaded evaluator.
        logs: paths of logs, or logs, to identify from.
        validation: logs to judge by; without any, the last fifth of each log is held out.
        model: "energy", the model of Gautier and Khalil; "momentum", n equations a window;
            "torque", with filtered accelerations; or "auto", all three, of which the one is taken
            that leaves the smallest torque error on folds of the training logs left out of its fit;
            or "static": rows are still poses, see `symgen.identification.static`.
        method: an estimator, such as `symgen.Wls()`, or its name: "wls" (each log and joint weighed
            by its own residual), "ols", "huber", "tls", "iv", "ridge", "essential"; "consistent"
            (parameters that a robot can have); or "recursive" (least squares that may forget).
        window: length of the sliding windows of energy and momentum, s.
        cutoff: of the zero-phase filter of positions and speeds, Hz; by default the one with the
            smallest torque error on folds of the training logs left out of the fit.
        fit: a prior, weights of logs, commanded motions, forgetting.
        reading: how logs are read, and what of them is left out of the equations.
        workers: who reads and folds chunks, and where what is finished is kept.
        progress: is told what is being done.

    Returns:
        The estimate, with precision, residuals on data that it never saw, and a verdict.

    Raises:
        LogError: a log cannot be read or does not belong to the robot.
        IdentificationError: the logs do not determine the parameters.
    """
    if model not in MODELS:
        raise IdentificationError(f"model {model!r}; accepted: {', '.join(MODELS)}")
    asked = fit or Fit()
    chosen = Method.of(method, asked.forgetting)
    if not (math.isfinite(window) and window > 0):
        raise IdentificationError(f"a window of {window:g} s; accepted: a length above 0")
    sources, motions = listed_logs(logs), listed_logs(asked.commanded)
    shares = asked.shares(len(sources), chosen.name)
    if motions and (chosen.name != "iv" or len(motions) != len(sources)):
        raise IdentificationError(
            f"{len(motions)} commanded motions for {len(sources)} logs and method {chosen.name}; "
            "accepted: one for each log, with method iv"
        )
    require_logs(sources)
    source = _robot(robot)
    with told_of_angles(source):
        if model == STATIC:
            evaluator = load(derive(source, JUDGING))
            return identify_poses(
                evaluator,
                sources,
                listed_logs(validation),
                _of_poses(chosen, asked.prior, shares, evaluator),
                chosen.name + (" with prior" if asked.prior is not None else ""),
                reading,
                progress,
            )
        recipes = _recipes(source, model, window, chosen)
        given = listed_logs(validation)
        plain = chosen.plain and asked.prior is None and asked.weights is None and not motions
        whole = source.loaded or bool(source.on_logs)
        if workers is not None or is_long([*sources, *given], plain and not whole):
            refused = {
                "weights": asked.weights,
                "prior": asked.prior,
                "commanded": motions,
                "effects on samples": source.on_logs,
            }
            for name, value in refused.items():
                if value:
                    raise IdentificationError(f"{name} on a data set; accepted: none there")
            with executor(workers) as by:
                return identify_data_set(
                    source,
                    paths_of(sources),
                    paths_of(given),
                    recipes,
                    chosen,
                    by=by,
                    cutoff=cutoff,
                    reading=reading,
                    work=None if workers is None or workers.work is None else Path(workers.work),
                    progress=progress,
                )
        train, held, repairs = _look(source, sources, given, reading, progress)
        progress("deriving and compiling the model")
        evaluator = _loaded(robot, source, recipes)
        if asked.prior is not None:
            chosen = replace(chosen, prior=read_prior(asked.prior, evaluator.model))
        own_speeds = chosen.name == "iv" and not motions
        run = looked_at(
            evaluator, train, held, repairs, bool(given), cutoff, progress, own_speeds=own_speeds
        )
        run, faults, _ = checked_run(run)
        return _solve(run, recipes, chosen, shares, motions, faults, progress)


def _of_poses(
    method: Method, prior: str | Path | None, shares: Sequence[float], evaluator: Evaluator
) -> Estimator:
    """Return the estimator of still poses; refuse what has no meaning for them."""
    if method.name not in POSE_METHODS or any(s != 1.0 for s in shares):
        raise IdentificationError(
            f"model static with method {method.name} or weights; accepted: "
            f"{', '.join(POSE_METHODS)}, without --weights"
        )
    if prior is not None:
        method = replace(method, prior=read_prior(prior, evaluator.model))
    return method.estimator(evaluator)


def _robot(robot: Robot | str | Path | Evaluator) -> Robot:
    if isinstance(robot, Evaluator):
        return robot.model.robot
    return read_robot(robot) if isinstance(robot, (str, Path)) else robot


def _recipes(robot: Robot, model: str, window: float, method: Method) -> tuple[Recipe, ...]:
    """Return the models that are tried; effects of the load leave the torque model alone."""
    tried = tuple(NEEDED) if model == AUTO else (model,)
    if model == AUTO and robot.loaded:
        tried = ("torque",)
    if model == AUTO and method.name == "recursive":
        tried = tuple(m for m in tried if m != "torque")
    return tuple(Recipe(name, window) for name in tried)


def _loaded(
    robot: Robot | str | Path | Evaluator, source: Robot, recipes: Sequence[Recipe]
) -> Evaluator:
    """Load the kernels that the models need."""
    if isinstance(robot, Evaluator):
        needed = {k for recipe in recipes for k in recipe.kernels(robot.model)}
        if all(robot.has(name) for name in needed):
            return robot
    kernels = dict.fromkeys(k for recipe in recipes for k in recipe.all_kernels)
    return load(derive(source, tuple(kernels)))


def _look(
    robot: Robot,
    logs: Sequence[Source],
    validation: Sequence[Source],
    reading: Reading | None,
    progress: Callable[[str], None],
) -> tuple[list[Samples], list[Samples], list[Fault]]:
    """Read and mend every log; without a validation log, hold out the end of each."""
    (train, held), repairs = open_logs((logs, validation), robot, reading, progress)
    require_other_data(train, held)
    if held:
        return train, held, repairs
    return *held_out(train, _FEWEST), repairs


def _solve(
    run: Run,
    recipes: Sequence[Recipe],
    method: Method,
    shares: Sequence[float],
    motions: Sequence[Source],
    faults: tuple[str, ...],
    progress: Callable[[str], None],
) -> Estimate:
    """Fit the models, take the one that predicts best, and judge it."""
    case = chosen_case(run, recipes, method, shares, motions, progress)
    system, known = case.system, case.chosen
    progress(f"solving {len(system.y)} equations for {len(system.names)} parameters")
    torques: tuple[TorqueFit, ...] = ()
    if method.is_wls and known is not None and isinstance(known.solution, Solution):
        solution, bias = bias_of_least_squares(system, known.solution)
        torques = known.torques
    else:
        with determined(case.fault):
            solution, bias = solved(run.evaluator, system, case.train, method, case.recipe)
    require_condition(solution, case.fault)
    progress("judging")
    return judged(case, method, solution, bias, faults, outcome(case, solution.X, torques))
