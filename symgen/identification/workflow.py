"""identify: from a robot and its logs to an estimate with a verdict."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import symgen.identification.verdict as verdicts
from symgen import names
from symgen.codegen.model import derive
from symgen.data.raw import Reading
from symgen.data.signals import Samples
from symgen.errors import IdentificationError, LogError
from symgen.identification.estimate import (
    LOG_DIGEST,
    ROBOT_DIGEST,
    Contrast,
    Convergence,
    Estimate,
    ParameterEstimate,
)
from symgen.identification.instruments import instrumented
from symgen.identification.masking import require_left
from symgen.identification.physical import consistency
from symgen.identification.prior import read_prior
from symgen.identification.recipe import NEEDED, Recipe
from symgen.identification.regression import Solution
from symgen.identification.signs import wrong_sign
from symgen.identification.solving import Method, convergence, moved_by_window, settled, solved
from symgen.identification.system import LinearSystem
from symgen.identification.validation import (
    Part,
    Source,
    TorqueComparison,
    digest,
    energy_balances,
    kinetic_energy,
    listed_logs,
    model_traces,
    open_samples,
    require_logs,
    require_other_data,
    residual,
)
from symgen.identification.whiteness import whiteness
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
MODELS = tuple(NEEDED)
#: Methods for which logs can be given weights.
WEIGHED = ("wls", "ols")
_HELD_OUT = 0.2
_PLENTY = 10  # independent equations for each parameter


def identify(
    robot: Robot | str | Path | Evaluator,
    logs: Sequence[Source] | Source,
    *,
    validation: Sequence[Source] | Source = (),
    model: str = "energy",
    method: str = "wls",
    window: float = 0.2,
    cutoff: float | None = None,
    prior: str | Path | None = None,
    forgetting: float = 1.0,
    commanded: Sequence[Source] | Source = (),
    reading: Reading | None = None,
    weights: Sequence[float] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Estimate:
    """Identify a robot's base parameters from measured logs.

    Args:
        robot: a robot, a path or library name, or a loaded evaluator.
        logs: paths of logs, or logs, to identify from.
        validation: logs to judge by; without any, the last fifth of each log is held out.
        model: "energy", the model of Gautier and Khalil; "momentum", n equations a window; or
            "torque", with filtered accelerations.
        method: an estimator of `symgen.identification.batch`: "wls" (each log and joint weighed by
            its own residual), "ols", "huber", "tls", "iv", "ridge", "essential"; "consistent"
            (parameters that a robot can have); or "recursive" (the C core, sample by sample).
        window: length of the sliding windows of energy and momentum, s.
        cutoff: of the zero-phase filter where speeds were not measured, and of the torque model,
            Hz; by default from the motion's bandwidth.
        prior: estimate.json, TOML with [parameters], or the .urdf that the robot was imported
            from: pulls methods wls and consistent towards its values (see `read_prior`).
        forgetting: weight of the past for each new equation, of method recursive, in (0, 1].
        commanded: the commanded motion of each log, in their order, for the instruments of method
            iv; by default they come from the encoders, where speeds were measured too.
        reading: how logs are read, and what of them is left out of the equations.
        weights: one a log, of its squared residuals; by default all alike. For wls and ols.
        progress: is told what is being done.

    Returns:
        The estimate, with precision, residuals on data that it never saw, and a verdict.

    Raises:
        LogError: a log cannot be read or does not belong to the robot.
        IdentificationError: the logs do not determine the parameters.
    """
    if model not in MODELS:
        raise IdentificationError(f"model {model!r}; accepted: {', '.join(MODELS)}")
    chosen = Method(method, forgetting)
    if not (math.isfinite(window) and window > 0):
        raise IdentificationError(f"a window of {window:g} s; accepted: a length above 0")
    shares = _weights(weights, len(listed_logs(logs)), method)
    progress("deriving and compiling the model")
    recipe = Recipe(model, window, cutoff)
    evaluator = _loaded(robot, recipe)
    if prior is not None:
        chosen = replace(chosen, prior=read_prior(prior, evaluator.model))
    sources, motions = listed_logs(logs), listed_logs(commanded)
    if motions and (method != "iv" or len(motions) != len(sources)):
        raise IdentificationError(
            f"{len(motions)} commanded motions for {len(sources)} logs and method {method}; "
            "accepted: one for each log, with method iv"
        )
    given = listed_logs(validation)
    read = _read(evaluator.model.robot, sources, given, recipe, reading, progress)

    def parts_of(recipe: Recipe, read: Sequence[tuple[str, Samples]]) -> list[Part]:
        return _parts(evaluator, read, recipe, chosen, motions, bool(given))

    if evaluator.model.robot.loaded:
        progress("settling the effects that hold the model's torque")
        training = [entry for entry in read if entry[0] == "train"]
        recipe = settled(evaluator, lambda at: parts_of(at, training), recipe)
    parts = parts_of(recipe, read)
    train = [p for p in parts if p.kind == "train"]
    held = [p for p in parts if p.kind == "validation"]
    train = [_weighed(p, w) for p, w in zip(train, shares, strict=True)]
    require_other_data([p.samples for p in train], [p.samples for p in held])
    fault = verdicts.motion_fault([p.samples for p in train])
    system = LinearSystem(evaluator.model.base.names, tuple(e for p in train for e in p.equations))
    progress(f"solving {len(system.y)} equations for {len(system.names)} parameters")
    try:
        solution, bias = solved(evaluator, system, train, chosen, recipe)
    except IdentificationError as error:
        raise IdentificationError(f"{error}; {fault}" if fault else str(error)) from error
    except np.linalg.LinAlgError as error:
        raise IdentificationError(
            "the information matrix is singular: these data do not determine the parameters"
            + (f"; {fault}" if fault else "")
        ) from error
    if fault and solution.condition_number > verdicts.PROPORTIONAL_CONDITION:
        raise IdentificationError(
            f"these data do not determine the parameters: {fault} (condition number "
            f"{solution.condition_number:.3g})"
        )
    progress("validating")
    return _estimate(
        evaluator,
        solution,
        bias,
        convergence(train, system.names),
        train,
        held,
        chosen,
        recipe,
        bool(validation),
    )


def _loaded(robot: Robot | str | Path | Evaluator, recipe: Recipe) -> Evaluator:
    """Load the kernels that the model needs."""
    if isinstance(robot, Evaluator):
        if all(robot.has(name) for name in recipe.kernels(robot.model)):
            return robot
        robot = robot.model.robot
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    return load(derive(source, recipe.all_kernels))


def _read(
    robot: Robot,
    logs: Sequence[Source],
    validation: Sequence[Source],
    recipe: Recipe,
    reading: Reading | None,
    progress: Callable[[str], None],
) -> list[tuple[str, Samples]]:
    """Return the samples of every log, and what it is for."""
    require_logs(logs)
    out = []
    for kind, sources in (("train", logs), ("validation", validation)):
        for source in sources:
            progress(f"reading {getattr(source, 'name', source)}")
            samples = open_samples(source, robot, reading, recipe.cutoff, wide=recipe.wide)
            out.append((kind, samples))
    return out


def _parts(
    evaluator: Evaluator,
    read: Sequence[tuple[str, Samples]],
    recipe: Recipe,
    method: Method,
    commanded: Sequence[Source],
    given: bool,
) -> list[Part]:
    """Build the equations of every log; without a validation log, hold out the end of each."""
    out = []
    for k, (kind, samples) in enumerate(read):
        equations = recipe.equations(evaluator, samples)
        if samples.mask is not None:
            require_left(samples.name, equations)
        part = Part(kind, samples, equations, recipe.model)
        if kind == "train" and (method.name == "iv" or method.is_tested(samples)):
            part = instrumented(evaluator, part, recipe, commanded[k] if commanded else None)
        out.append(part)
    return out if given else [piece for part in out for piece in _split(part, recipe.gap)]


def _weights(weights: Sequence[float] | None, logs: int, method: str) -> Sequence[float]:
    """Return one weight a log; refuse what cannot weigh."""
    if weights is None:
        return [1.0] * logs
    if method not in WEIGHED:
        raise IdentificationError(f"weights with method {method}; accepted: {', '.join(WEIGHED)}")
    if len(weights) != logs or not all(0 < w < math.inf for w in weights):
        shown = ", ".join(f"{w:g}" for w in weights)
        raise IdentificationError(
            f"weights {shown}; accepted: a number above 0 for each of {logs} logs"
        )
    return weights


def _weighed(part: Part, weight: float) -> Part:
    return replace(part, equations=tuple(replace(e, weight=weight) for e in part.equations))


def _split(part: Part, gap: float) -> list[Part]:
    """Hold out the last fifth; no window spans the cut."""
    s = part.samples
    cut = int(len(s.t) * (1 - _HELD_OUT))
    name = f"{s.name} (last fifth)"
    kept = tuple(e.where(e.t <= s.t[cut], e.name) for e in part.equations)
    held = tuple(e.where(e.t >= s.t[cut] + gap, name) for e in part.equations)
    if any(len(e.y) < 10 for e in (*kept, *held)):
        if s.mask is not None:
            raise LogError(
                f"{s.name}: the mask leaves next to no window of {gap:g} s in its first four "
                "fifths or in the last, which is held out; accepted: a longer log, or --validation"
            )
        raise LogError(
            f"{s.name}: too short to hold out its last fifth in windows of {gap:g} s; "
            "accepted: a longer log, or a second one for validation"
        )
    late, early = (s.cut(span) for span in (slice(cut, None), slice(None, cut)))
    late = replace(late, name=name, notes=())
    return [
        replace(part, kind="train", samples=early, equations=kept),
        replace(part, kind="validation", samples=late, equations=held),
    ]


def _estimate(
    evaluator: Evaluator,
    solution: Solution,
    bias: str,
    course: Convergence,
    train: Sequence[Part],
    held: Sequence[Part],
    method: Method,
    recipe: Recipe,
    given: bool,
) -> Estimate:
    base = evaluator.model.base
    std = np.sqrt(np.maximum(np.diag(solution.covariance), 0))
    parameters = tuple(
        ParameterEstimate(b.name, b.expression, float(x), float(s), b.unit)
        for b, x, s in zip(base.parameters, solution.X, std, strict=True)
    )
    outside = np.where(std > 0, std, 1)
    torque = TorqueComparison(evaluator, solution.X)
    train_torque, train_traces = torque.residual(train)
    held_torque, held_traces = torque.residual(held)
    train_residual, held_residual = residual(train, solution.X), residual(held, solution.X)
    windows = sum(len(e.y) / e.correlation for p in train for e in p.equations)
    reasons = verdicts.reasons(
        condition=solution.condition_number,
        train=train_residual,
        validation=held_residual,
        torque=held_torque,
        windows=windows,
        parameters=len(parameters),
    )
    reasons += (bias,) if bias else ()
    turned = wrong_sign(evaluator, train, recipe, train_residual.relative)
    reasons += (turned,) if turned else ()
    reasons += verdicts.unphysical(parameters, kinetic_energy(evaluator, train, solution.X))
    reasons += tuple(
        fault for p in (*train, *held) for fault in verdicts.velocity_faults(p.samples)
    )
    notes = tuple(note for p in (*train, *held) for note in p.samples.notes)
    if not given:
        notes += (
            "no validation log is given: the last fifth of each log is held out (its filter was "
            "chosen on the whole log)",
        )
    if windows < _PLENTY * len(parameters):
        notes += (
            f"{windows:.0f} independent equations for {len(parameters)} parameters: under "
            f"{_PLENTY} each, the intervals tend to be short",
        )
    notes += solution.notes
    if len(set(solution.weights)) > 1:
        low, high = min(solution.weights), max(solution.weights)
        notes += (
            f"equations are weighed by log and joint, largest over smallest {high / low:.2f}",
        )
    if any(p.equations[0].weight != 1.0 for p in train):
        shares = ", ".join(f"{p.equations[0].weight:g}" for p in train)
        notes += (f"squared residuals of the logs are weighed by {shares}",)
    if math.isfinite(torque.band):
        notes += (
            f"torques are compared below {torque.band:.3g} Hz, through a zero-phase low-pass",
        )
    moved = moved_by_window(evaluator, train, method, recipe, solution.X, std)
    if moved:
        notes += (
            f"with other windows {moved}: the model misses something of this size, "
            "which std does not tell",
        )
    flagged = [p.name for p in parameters if not p.relative_std_percent <= 30]
    if flagged:
        notes += (f"relative standard deviation above 30 %: {', '.join(flagged)}",)
    traces = tuple(trace for p in (*train, *held) for trace in model_traces(p, solution.X))
    traces += train_traces + held_traces
    known = method.prior
    cutoffs = [band for p in train if (band := recipe.band(p.samples)) is not None]
    return Estimate(
        robot=evaluator.model.robot.name,
        joints=tuple((j.number, names.unit("FS", j.sigma)) for j in evaluator.model.robot.movable),
        model=recipe.model,
        method=method.label,
        parameters=parameters,
        condition_number=solution.condition_number,
        train=train_residual,
        validation=held_residual,
        torque_train=train_torque,
        torque_validation=held_torque,
        cutoff_hz=max(cutoffs) if cutoffs else None,
        window_s=None if recipe.model == "torque" else recipe.window,
        verdict="doubtful" if reasons else "trusted",
        reasons=reasons,
        notes=notes,
        correlation=solution.covariance / np.outer(outside, outside),
        traces=traces,
        convergence=course,
        provenance=_provenance(evaluator, method, train, held),
        physical=consistency(evaluator.model, solution.X, solution.covariance),
        excludes=method.excludes,
        endogeneity=solution.endogeneity,
        comparison=solution.comparison,
        prior=None if known is None else Contrast("prior", known.mean, known.std),
        balances=energy_balances(evaluator, (*train, *held), solution.X),
        whiteness=whiteness(traces),
    )


def _provenance(
    evaluator: Evaluator, method: Method, train: Sequence[Part], held: Sequence[Part]
) -> tuple[tuple[str, str], ...]:
    from importlib.metadata import PackageNotFoundError, version

    try:
        own = version("symgen")
    except PackageNotFoundError:
        own = "unknown"
    robot = hashlib.sha256(robot_toml(evaluator.model.robot).encode()).hexdigest()
    out = [
        ("symgen", own),
        ("backend", evaluator.backend),
        (ROBOT_DIGEST, robot),
    ]
    if method.name == "recursive":
        out.append(("forgetting", f"{method.forgetting:g}"))
    if method.prior is not None:
        given = np.concatenate([method.prior.mean, method.prior.std]).tobytes()
        out.append(("prior, sha256 of its means and std", hashlib.sha256(given).hexdigest()))
    for part in (*train, *held):
        out.append((f"{part.kind} {part.samples.name}, {LOG_DIGEST}", digest(part.samples)))
    return tuple(out)
