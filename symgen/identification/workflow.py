"""identify: estimate parameters from a robot and its logs, with a verdict.

open logs -> choose band -> undo delay -> equations -> choose model -> solve -> assess
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from symgen.codegen.model import derive
from symgen.data.raw import Reading
from symgen.distributed import Say, Workers, silent
from symgen.errors import IdentificationError, ParameterError, SymgenError
from symgen.estimation.equation_model import JUDGING, NEEDED, EquationModel
from symgen.estimation.estimators import Estimator
from symgen.estimation.logs import (
    Source,
    hold_out,
    listed_logs,
    require_logs,
    require_other_data,
)
from symgen.estimation.playback import Gains, Window, gains_of, with_controller
from symgen.estimation.predictive_score import LEAST
from symgen.estimation.system import Equations
from symgen.estimation.values import FloatArray
from symgen.faults.fault import Fault, undo_faults
from symgen.faults.logs import open_logs, require_motion
from symgen.faults.recorder import late_fault
from symgen.identification import output_error
from symgen.identification.assessment import (
    Outcome,
    Trials,
    assess,
    impossible,
    in_motion,
    level_exceeded,
    like_no_robot,
    outcome,
)
from symgen.identification.estimate import Estimate, FittedConstant
from symgen.identification.model_choice import (
    ChosenModel,
    OpenLogs,
    blame_motion,
    choose_model,
    filter_in_time,
    name_cause,
)
from symgen.identification.out_of_core import ChunkedLogs, is_long, open_data_set
from symgen.identification.parameters import read_prior, values_of_file
from symgen.identification.physical import Consistent
from symgen.identification.solving import FOLDED, EquatedLog, Fit, Method, equate, solve, system_of
from symgen.identification.static import STATIC, identify_poses
from symgen.robot.toml_io import parse_robot, read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load
from symgen.symbolic.near_angles import told_of_angles

AUTO, SIMULATION = "auto", "simulation"
_NOT_REFINED = "not refined by simulation"
MODELS = (AUTO, *NEEDED, STATIC)


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
    refine: str | None = None,
    controller: str | Path | None = None,
    reading: Reading | None = None,
    workers: Workers | None = None,
    progress: Say = silent,
) -> Estimate:
    """Identify a robot's base parameters from measured logs.

    symgen reads data sets (a pattern, a folder, a URL) chunk by chunk, and also large Parquet and
    NPZ files for least squares, and all logs if `workers` is set. See
    `symgen.identification.out_of_core`.

    Args:
        robot: a robot, a path or library name, or a loaded evaluator.
        logs: training logs, or their paths.
        validation: held-out logs for the verdict; without any, the last fifth of each log is held
            out.
        model: "energy", the model of Gautier and Khalil; "momentum", with n equations for each
            window; "torque", with filtered accelerations; "auto", which fits all three and keeps
            the one with the smallest torque error on held-out folds of the training logs; or
            "static", in which each row is a pose at rest (`symgen.identification.static`).
        method: an estimator, such as `symgen.Wls()`, or its name: "wls" (each log and joint has a
            weight from its own residual), "ols", "huber", "tls", "iv", "ridge", "essential",
            "consistent" (physically possible parameters), or "recursive" (least squares with
            forgetting).
        window: length of the sliding windows of energy and momentum, s.
        cutoff: cutoff of the zero-phase filter of positions and speeds, Hz; by default the one with
            the smallest torque error on held-out folds of the training logs.
        fit: prior, weights of logs, commanded motions, forgetting.
        refine: "simulation" refines the solution by output error: the parameters whose simulated
            positions are nearest to the measured ones, if they simulate held-out folds better
            (`symgen.identification.output_error`). None for the solution itself.
        controller: TOML with [controller] kp and kd, (n,) each: held-out motion is simulated with
            this feedback to the measured motion too.
        reading: columns, span and masks of the logs.
        workers: processes or scheduler that read chunks, and the folder of an unfinished run.
        progress: called with a text about the current step.

    Returns:
        The estimate, with standard deviations, residuals on held-out data, and a verdict.

    Raises:
        LogError: a log cannot be read or does not belong to the robot.
        IdentificationError: the logs do not determine the parameters.
    """
    if model not in MODELS:
        raise IdentificationError(f"model {model!r}; accepted: {', '.join(MODELS)}")
    if refine not in (None, SIMULATION) or (refine and model == STATIC):
        raise IdentificationError(
            f"refine {refine!r} with model {model}; accepted: {SIMULATION}, and no model {STATIC}"
        )
    if not (math.isfinite(window) and window > 0):
        raise IdentificationError(f"a window of {window:g} s; accepted: a length above 0")
    asked = fit or Fit()
    by = Method.of(method, asked.forgetting)
    sources, given = listed_logs(logs), listed_logs(validation)
    shares, motions = asked.shares(len(sources), by.name), asked.motions(len(sources), by.name)
    require_logs(sources)
    source = read_robot(robot.model.robot if isinstance(robot, Evaluator) else robot)
    source = with_controller(source, controller)
    robot = source if controller and isinstance(robot, Evaluator) else robot
    with told_of_angles(source):
        if model == STATIC:
            return identify_poses(source, (sources, given), by, asked, reading, progress)
        models = _equation_models(source, model, window, by)
        data: AbstractContextManager[LogsInMemory | ChunkedLogs]
        whole = _whole(source, by, asked, refine)
        if workers is not None or is_long([*sources, *given], not whole):
            if whole:
                raise IdentificationError(
                    f"{whole} on a data set; accepted: {', '.join(FOLDED)} alone, or logs that "
                    "fit into memory"
                )
            data = open_data_set(source, sources, given, models, reading, workers, progress)
        else:
            data = _open_in_memory(robot, source, (sources, given), models, reading, progress)
        with data as opened:
            if asked.prior is not None:
                by = replace(by, prior=read_prior(asked.prior, opened.evaluator.model))
            own_speeds = by.name == "iv" and not motions
            run = filter_in_time(opened, cutoff, own_speeds=own_speeds)
            progress("asking what else could be wrong")
            run = name_cause(run)
            chosen = choose_model(run, models, by, shares, motions, progress)
            with blame_motion(chosen.fault):
                found = opened.solve(chosen, by)
            by, found = _possible(opened, chosen, by, found)
            trials = Trials(values_of_file(robot, opened.evaluator.model), gains_of(source))
            if not refine:
                progress("judging")
                return assess(chosen, by, found, trials)
            progress("refining by simulation")
            refined = _refined(chosen, by, found, trials.gains)
            progress("judging")
            after = assess(*refined, trials)
            if not refined[1].refined:
                return after
            before = assess(chosen, by, found, trials)
            farther = _farther(before, after)
            return replace(before, notes=(*before.notes, farther)) if farther else after


def _possible(
    opened: LogsInMemory | ChunkedLogs, chosen: ChosenModel, by: Method, found: Outcome
) -> tuple[Method, Outcome]:
    """Return the nearest possible parameters if those of least squares are surely impossible.

    The exception: they raise the held-out torque error of a joint by an amount that matters. Then
    an effect is missing, and the least-squares solution stays. If that error is above the level of
    an unknown cause, the least-squares solution is not good for prediction.
    """
    evaluator, logs = chosen.run.evaluator, chosen.run.train
    if not by.is_wls or evaluator.model.robot.loaded or chosen.columns is not None:
        return by, found
    wrong = impossible(evaluator, logs, found.solution.X, found.solution.covariance)
    if not wrong:
        return by, found
    bounded = replace(by, name=Consistent.name)
    try:
        other = opened.solve(chosen, bounded)
    except ParameterError as error:
        reason = like_no_robot(wrong, "none are found")
        return by, replace(found, notes=(*found.notes, *wrong, str(error)), faults=(reason,))
    moving = [in_motion(o.seen).residual for o in (found, other)]
    before, after = (np.square(r.per_joint or (r.relative,)) for r in moving)
    if np.max(after - before) > LEAST**2:
        worse = (
            "physically possible parameters have a larger torque error "
            f"({100 * other.seen.residual.relative:.3g} % on held-out data): an effect is missing; "
            "symgen diagnose searches for it"
        )
        left = level_exceeded(evaluator, chosen.run.held, other)
        faults = (like_no_robot(wrong, left),) if left else ()
        return by, replace(found, notes=(*found.notes, *wrong, worse), faults=faults)
    told = "least squares gives physically impossible parameters"
    notes = tuple(f"{told}: {reason}" for reason in wrong)
    return bounded, replace(other, notes=(*other.notes, *notes))


def _refined(
    chosen: ChosenModel, by: Method, found: Outcome, gains: Gains | None
) -> tuple[ChosenModel, Method, Outcome]:
    """Return the run, the method and the parameters of output error.

    The solution stays where these do not simulate held-out windows better; a note says why.
    """
    run, before = chosen.run, found.solution

    def unchanged(reason: str) -> tuple[ChosenModel, Method, Outcome]:
        return chosen, by, replace(found, notes=(*found.notes, f"{_NOT_REFINED}: {reason}"))

    if chosen.columns is not None:
        return unchanged("the logs do not determine all parameters")
    evaluator = load(derive(run.evaluator.model.robot, (*output_error.NEEDED, *JUDGING)))

    def without(windows: Sequence[Window]) -> FloatArray:
        parts = [
            _without(part, [w.log.t[w.rows] for w in windows if w.log is log], chosen.model.gap)
            for log, part in zip(run.train, chosen.train, strict=True)
        ]
        return solve(run.evaluator, parts, by, chosen.model).X

    try:
        refined = output_error.refine(
            evaluator, run.train, before.X, without=without, late=run.delay != 0.0, gains=gains
        )
    except (ParameterError, IdentificationError) as error:
        return unchanged(str(error))
    old, new = refined.residuals
    told = (
        "on held-out windows of the training logs, positions are "
        f"{old:.3g} standard deviations off with {by.label} and {new:.3g} refined "
        f"(p = {refined.p_value:.2g} that this is chance)"
    )
    if not refined.better:
        return unchanged(told)
    try:
        chosen, repairs = _as_refined(chosen, refined, found.repairs)
    except SymgenError as error:  # a robot file cannot have these constants
        return unchanged(str(error))
    covariance = refined.covariance[: len(before.X), : len(before.X)]
    solution = replace(before, X=refined.X, noise=covariance, misfit=np.zeros_like(covariance))
    own, held = (system_of(run.evaluator, logs).logs for logs in (chosen.train, chosen.held))
    fits = chosen.run.torques(refined.X)
    better = outcome(solution, chosen.model, (own, held), fits, repairs)
    constants, told_of_constants = _refined_constants(refined)
    notes = (*found.notes, f"refined by simulation: {told}", *told_of_constants)
    by = replace(by, refined=True)
    better = replace(better, notes=notes, provenance=found.provenance, constants=constants)
    return chosen, by, better


def _farther(before: Estimate, after: Estimate) -> str:
    """Return why the refined estimate is not kept on held-out motion; "" if it is kept."""
    (linear,), (refined,) = (
        [use.horizons[-1:] for use in e.uses if use.name == "simulation"] for e in (before, after)
    )
    if not linear or (refined and refined[0].position_error <= linear[0].position_error):
        return ""
    told = f"{100 * refined[0].position_error:.3g} %" if refined else "unknown"
    return (
        f"{_NOT_REFINED}: on held-out motion, the position error after {linear[0].seconds:g} s is "
        f"{100 * linear[0].position_error:.3g} % with {before.method} and {told} refined"
    )


def _without(part: EquatedLog, times: Sequence[FloatArray], gap: float) -> EquatedLog:
    """Return a log without the equations that share time with some stretches of it.

    Args:
        part: the log with its equations.
        times: (K,) of each stretch, s.
        gap: time that an equation reaches back, s.
    """

    def apart(e: Equations) -> Equations:
        shared = [(e.t > t[0]) & (e.t - gap < t[-1]) for t in times]
        return e.where(~np.any(shared, axis=0), e.name)

    return replace(part, equations=tuple(apart(e) for e in part.equations)) if times else part


def _refined_constants(
    refined: output_error.Refinement,
) -> tuple[tuple[FittedConstant, ...], tuple[str, ...]]:
    """Return the constants that were fitted, and notes on them and on those that were not."""
    own = refined.constants
    std = iter(np.sqrt(np.diag(refined.covariance))[len(refined.covariance) - own.fitted.sum() :])
    constants = tuple(
        FittedConstant(name, effect, float(f"{value:.6g}"), float(next(std)))
        for name, effect, value, fitted in zip(
            own.every.names, own.every.owners, own.values, own.fitted, strict=True
        )
        if fitted
    )
    old = dict(zip(own.every.names, own.every.values, strict=True))
    notes = [
        f"refined by simulation: {c.name} of {c.effect} is {c.value:.4g} ({c.std:.2g} standard "
        f"deviation; {old[c.name]:.4g} in the robot file)"
        for c in constants
    ]
    stay = [n for n, fitted in zip(own.every.names, own.fitted, strict=True) if not fitted]
    if stay:
        notes.append(f"not refined, because the logs do not determine it: {', '.join(stay)}")
    if own.every.others:
        notes.append(
            "not refined, because the effect depends on acceleration or load: "
            f"{', '.join(own.every.others)}"
        )
    return constants, tuple(notes)


def _as_refined(
    chosen: ChosenModel, refined: output_error.Refinement, repairs: tuple[Fault, ...]
) -> tuple[ChosenModel, tuple[Fault, ...]]:
    """Return the run with the refined constants and delay, and the repairs with it.

    Raises:
        SymgenError: no robot has the refined constants.
    """
    run, moved = chosen.run, refined.constants
    if not (refined.delay or moved.fitted.any()):
        return chosen, repairs
    evaluator, train, held = run.evaluator, run.train, run.held
    if moved.fitted.any():
        robot = moved.every.moved(moved.values)
        robot = parse_robot(robot_toml(robot), robot.name)  # refuses what no file can have
        kernels = [kernel.name for kernel in evaluator.model.kernels]
        evaluator = load(derive(robot, kernels))
    if refined.delay:
        n = evaluator.model.robot.n
        common = [f for f in repairs if f.kind == "delay" and len(f.joints) == n]
        shift = late_fault(refined.delay, n)
        whole = late_fault(refined.delay + sum(f.value for f in common), n)
        train, held = (
            tuple(undo_faults(log, [shift])[0] for log in group) for group in (train, held)
        )
        p = len(refined.X)
        told = replace(
            whole, samples=sum(len(log.t) for log in run.logs), done="shifted", undo=None,
            values=(("DT", whole.value, math.sqrt(refined.covariance[p, p])),),
        )  # fmt: skip
        repairs = (*(f for f in repairs if f not in common), told)
    run = replace(run, evaluator=evaluator, train=train, held=held, delay=run.delay + refined.delay)
    sides = (
        [
            equate(evaluator, log, chosen.model, part.equations[0].weight, part.kind)
            for log, part in zip(logs, parts, strict=True)
        ]
        for logs, parts in ((train, chosen.train), (held, chosen.held))
    )
    return replace(chosen, run=run, train=next(sides), held=next(sides)), repairs


def _equation_models(
    robot: Robot, model: str, window: float, method: Method
) -> tuple[EquationModel, ...]:
    """Return the models to try; with effects of the load, only the torque model."""
    tried = tuple(NEEDED) if model == AUTO else (model,)
    if model == AUTO and robot.loaded:
        tried = ("torque",)
    if model == AUTO and method.name == "recursive":
        tried = tuple(m for m in tried if m != "torque")
    return tuple(EquationModel(name, window) for name in tried)


def _whole(robot: Robot, method: Method, asked: Fit, refine: str | None) -> str:
    """Return the option that needs all samples in memory, or ''."""
    needed = {
        "weights": asked.weights,
        "prior": asked.prior,
        "commanded": listed_logs(asked.commanded),
        "effects on samples": robot.on_logs,
        "effects that hold the torque of links": robot.loaded,
        f"method {method.label}": not method.plain,
        f"refine {refine}": refine,
    }
    return next((name for name, value in needed.items() if value), "")


class LogsInMemory(OpenLogs):
    """Logs that are in memory as a whole."""

    def solve(self, chosen: ChosenModel, method: Method) -> Outcome:
        """Solve the equations of the chosen model, reusing the least squares of the choice."""
        run = chosen.run
        rows = sum(e.rows for p in chosen.train for e in p.equations)
        names = run.evaluator.model.base.names
        self.progress(f"solving {rows} equations for {len(names)} parameters")
        known = chosen.plain if method.is_wls else None
        about = run.evaluator, chosen.train, method, chosen.model
        solution = known or solve(*about, chosen.kept)
        fits = chosen.torques if known else run.torques(solution.X)
        own, held = (system_of(run.evaluator, logs).logs for logs in (chosen.train, chosen.held))
        return outcome(solution, chosen.model, (own, held), fits, run.repairs)


@contextmanager
def _open_in_memory(
    robot: Robot | str | Path | Evaluator,
    source: Robot,
    logs: tuple[Sequence[Source], Sequence[Source]],
    models: Sequence[EquationModel],
    reading: Reading | None,
    progress: Say,
) -> Iterator[LogsInMemory]:
    """Read and repair every log; without a validation log, hold out the end of each."""
    (train, held), repairs = open_logs(logs, source, reading, progress)
    require_other_data(train, held)
    given = bool(held)
    if not given:
        train, held = hold_out(train)
    require_motion(train, source)
    progress("deriving and compiling the model")
    kernels = dict.fromkeys(k for model in models for k in model.all_kernels)
    evaluator = robot if isinstance(robot, Evaluator) else None
    if evaluator is None or not all(
        evaluator.has(k) for model in models for k in model.kernels(evaluator.model)
    ):
        evaluator = load(derive(source, tuple(kernels)))
    yield LogsInMemory(evaluator, train, held, repairs, given, progress)
