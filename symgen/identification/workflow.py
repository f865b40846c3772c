"""identify: from a robot and its logs to an estimate with a verdict."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import symgen.identification.verdict as verdicts
from symgen import names
from symgen.codegen.model import derive
from symgen.data.raw import Reading
from symgen.errors import IdentificationError, LogError
from symgen.identification.batch import (
    METHODS,
    Solution,
    column_norms,
    precision,
    solve,
    triangle,
    undetermined,
)
from symgen.identification.estimate import Convergence, Estimate, ParameterEstimate
from symgen.identification.masking import require_left, unmasked_pieces
from symgen.identification.physical import consistency
from symgen.identification.recipe import NEEDED, Recipe
from symgen.identification.recursive import Identifier
from symgen.identification.system import LinearSystem
from symgen.identification.validation import (
    Part,
    Source,
    TorqueComparison,
    digest,
    kinetic_energy,
    listed_logs,
    model_traces,
    open_samples,
    require_logs,
    require_other_data,
    residual,
)
from symgen.robot.toml_io import read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Robot
from symgen.runtime.evaluator import Evaluator, load

FloatArray = NDArray[np.float64]
MODELS = tuple(NEEDED)
ALL_METHODS = (*METHODS, "recursive")
#: Methods for which logs can be given weights.
WEIGHED = ("wls", "ols")
_HELD_OUT = 0.2
_CHECKPOINTS = 80


def identify(
    robot: Robot | str | Path | Evaluator,
    logs: Sequence[Source] | Source,
    *,
    validation: Sequence[Source] | Source = (),
    model: str = "energy",
    method: str = "wls",
    window: float = 0.2,
    cutoff: float | None = None,
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
        method: "wls" (each log weighed by its own residual), "ols", or "recursive" (the C core,
            sample by sample).
        window: length of the sliding windows of energy and momentum, s.
        cutoff: of the zero-phase filter where speeds were not measured, and of the torque model,
            Hz; by default from the motion's bandwidth.
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
    if method not in ALL_METHODS:
        raise IdentificationError(f"method {method!r}; accepted: {', '.join(ALL_METHODS)}")
    if not (math.isfinite(window) and window > 0):
        raise IdentificationError(f"a window of {window:g} s; accepted: a length above 0")
    shares = _weights(weights, len(listed_logs(logs)), method)
    progress("deriving and compiling the model")
    recipe = Recipe(model, window, cutoff)
    evaluator = _loaded(robot, recipe)
    parts = _parts(evaluator, listed_logs(logs), listed_logs(validation), recipe, reading, progress)
    train = [p for p in parts if p.kind == "train"]
    held = [p for p in parts if p.kind == "validation"]
    train = [_weighed(p, w) for p, w in zip(train, shares, strict=True)]
    require_other_data([p.samples for p in train], [p.samples for p in held])
    fault = verdicts.motion_fault([p.samples for p in train])
    system = LinearSystem(evaluator.model.base.names, tuple(e for p in train for e in p.equations))
    progress(f"solving {len(system.y)} equations for {len(system.names)} parameters")
    try:
        solution, convergence = _solved(evaluator, system, train, method, recipe)
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
        evaluator, solution, convergence, train, held, method, recipe, bool(validation)
    )


def _loaded(robot: Robot | str | Path | Evaluator, recipe: Recipe) -> Evaluator:
    """Load the kernels that the model needs."""
    if isinstance(robot, Evaluator):
        if all(robot.has(name) for name in recipe.kernels(robot.model)):
            return robot
        robot = robot.model.robot
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    return load(derive(source, recipe.all_kernels))


def _parts(
    evaluator: Evaluator,
    logs: Sequence[Source],
    validation: Sequence[Source],
    recipe: Recipe,
    reading: Reading | None,
    progress: Callable[[str], None],
) -> list[Part]:
    robot = evaluator.model.robot
    require_logs(logs)
    out = []
    for kind, sources in (("train", logs), ("validation", validation)):
        for source in sources:
            progress(f"reading {getattr(source, 'name', source)}")
            samples = open_samples(source, robot, reading, recipe.cutoff, wide=recipe.wide)
            equations = recipe.equations(evaluator, samples)
            if samples.mask is not None:
                require_left(samples.name, equations)
            out.append(Part(kind, samples, equations, recipe.model))
    return out if validation else [piece for part in out for piece in _split(part, recipe.gap)]


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


def _solved(
    evaluator: Evaluator, system: LinearSystem, train: Sequence[Part], method: str, recipe: Recipe
) -> tuple[Solution, Convergence]:
    drawn = _convergence(train, system.names)
    if method != "recursive":
        return solve(system, method), drawn
    if recipe.model == "torque":
        raise IdentificationError("method recursive works on the models of energy and momentum")
    steps = {max(1, round(recipe.window / p.samples.step)) for p in train}
    if len(steps) > 1:
        raise IdentificationError("method recursive needs logs of one sampling rate")
    identifier = Identifier(evaluator, steps.pop(), model=recipe.model)
    for part in train:
        for s in unmasked_pieces(part.samples, recipe.model):
            identifier.run(s.t, s.q, s.qd, s.tau)
    return precision(system, identifier.read()[0]), drawn


def _convergence(train: Sequence[Part], names_: tuple[str, ...]) -> Convergence:
    """Return the estimate after every chunk of the data: triangular factors merged in time.

    The equations of all joints of a log are taken together by their times.
    """
    p = len(names_)
    factor = np.zeros((0, p + 1))
    stride = max(1, sum(len(part.equations[0].t) for part in train) // _CHECKPOINTS)
    times, values, before = [], [], 0.0
    for part in train:
        t = max((e.t for e in part.equations), key=len)
        edges = [-math.inf, *t[stride::stride], math.inf]
        for at, (start, end) in enumerate(pairwise(edges)):
            piece = slice(at * stride, (at + 1) * stride)
            spans = [slice(*np.searchsorted(e.t, [start, end])) for e in part.equations]
            rows = [
                math.sqrt(e.weight) * np.column_stack([e.W[span], e.y[span]])
                for e, span in zip(part.equations, spans, strict=True)
            ]
            factor = triangle(np.concatenate([factor, *rows]))
            R = factor[:p, :p]
            if len(factor) >= p and not undetermined(R / column_norms(R), names_):
                times.append(before + float(t[piece][-1] - t[0]))
                values.append(np.linalg.solve(R, factor[:p, p]))
        before += float(t[-1] - t[0])
    return Convergence(np.array(times), np.array(values).reshape(len(times), p))


def _estimate(
    evaluator: Evaluator,
    solution: Solution,
    convergence: Convergence,
    train: Sequence[Part],
    held: Sequence[Part],
    method: str,
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
    reasons = verdicts.reasons(
        condition=solution.condition_number,
        train=train_residual,
        validation=held_residual,
        torque=held_torque,
        windows=sum(len(e.y) / e.correlation for p in train for e in p.equations),
        parameters=len(parameters),
    )
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
    if len(solution.weights) > 1 and method == "wls":
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
    moved = _moved_by_window(evaluator, train, method, recipe, solution.X, std)
    if moved:
        notes += (
            f"with windows of half the length {moved}: the model misses something of this size, "
            "which std does not tell",
        )
    flagged = [p.name for p in parameters if not p.relative_std_percent <= 30]
    if flagged:
        notes += (f"relative standard deviation above 30 %: {', '.join(flagged)}",)
    cutoffs = [band for p in train if (band := recipe.band(p.samples)) is not None]
    return Estimate(
        robot=evaluator.model.robot.name,
        joints=tuple((j.number, names.unit("FS", j.sigma)) for j in evaluator.model.robot.movable),
        model=recipe.model,
        method=method,
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
        traces=tuple(trace for p in (*train, *held) for trace in model_traces(p, solution.X))
        + train_traces
        + held_traces,
        convergence=convergence,
        provenance=_provenance(evaluator, train, held),
        physical=consistency(evaluator.model, solution.X, solution.covariance),
    )


def _moved_by_window(
    evaluator: Evaluator,
    train: Sequence[Part],
    method: str,
    recipe: Recipe,
    X: FloatArray,
    std: FloatArray,
) -> str:
    """Return in words the parameters that half the window moves by more than three std."""
    half = replace(recipe, window=recipe.window / 2)
    if recipe.model == "torque" or any(half.window < p.samples.step for p in train):
        return ""
    names_ = evaluator.model.base.names
    equations = (
        replace(e, weight=p.equations[0].weight)
        for p in train
        for e in half.equations(evaluator, p.samples)
    )
    try:
        other = solve(LinearSystem(names_, tuple(equations)), "ols" if method == "ols" else "wls").X
    except IdentificationError:
        return ""
    moves = [(abs(b - a) / s, n) for a, b, s, n in zip(X, other, std, names_, strict=True) if s > 0]
    worst = [(ratio, name) for ratio, name in moves if ratio > 3]
    return ", ".join(f"{name} moves by {ratio:.1f} std" for ratio, name in sorted(worst)[:-6:-1])


def _provenance(
    evaluator: Evaluator, train: Sequence[Part], held: Sequence[Part]
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
        ("robot, sha256 of its canonical robot.toml", robot),
    ]
    for part in (*train, *held):
        out.append((f"{part.kind} {part.samples.name}, sha256 of samples", digest(part.samples)))
    return tuple(out)
