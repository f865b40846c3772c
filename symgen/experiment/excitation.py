"""excite: find motions within limits from which the parameters of a robot can be identified.

The search maximises the precision of the parameters that noisy logs of the motion give (Swevers et
al. 1997). A condition number is not suitable: its columns have unit norm, so a slow motion in which
noise dominates counts as much as a fast one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.log import MIN_SAMPLES, read_only
from symgen.data.raw import FloatArray
from symgen.data.signals import Samples
from symgen.errors import IdentificationError, LogError, ParameterError
from symgen.estimation.equation_model import NEEDED, EquationModel, require_model
from symgen.estimation.filtered_log import unfiltered
from symgen.estimation.opening import HELD_OUT
from symgen.estimation.system import Rows, join
from symgen.experiment.bounds import (
    CELL,
    FINE,
    FRAMES,
    Bounds,
    Cell,
    LimitUse,
    bounds,
    largest_uses,
    space,
)
from symgen.experiment.plan import Plan, binding_text, geometric_mean
from symgen.experiment.search import SHRUNK, Clock, MotionCandidate, Objective, grid, largest_share
from symgen.experiment.trajectory import Trajectory, fourier_series
from symgen.identification.assessment import WINDOWS
from symgen.identification.estimate import joints_of
from symgen.identification.parameters import read_parameters
from symgen.parallel import Meter, Say, silent
from symgen.robot.tables import Limits
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot, require_gravity
from symgen.runtime.evaluator import Evaluator, load

#: Runs with a larger condition number are refused.
SINGULAR = 1e5
_USUAL = 10.0  # s, shortest duration by default
_MODELS = tuple(NEEDED)
_ROWS = 4  # minimum number of equations for each parameter in the search
_VISIBLE = 0.01  # share of a torque limit: default noise, and torque of a parameter that matters
#: Duration of the approach, over the distance at the allowed speed. A motion of degree five from
#: rest to rest has a peak speed of 1.875 times its mean. The peak is a tenth of the allowed speed.
_APPROACH = 18.75


@dataclass(frozen=True)
class Motion:
    """Number, duration and start of the runs of an excitation, with a Fourier series for every
    joint.

    Attributes:
        duration: duration of each run in s. None means at least 10 s, and long enough for
            `identify` to trust the result.
        runs: number of runs, each with its own coefficients.
        terms: number of harmonics of a joint; None chooses it from the duration.
        start: start position of every run, (n,), rad or m; None if free.
        rate: sampling rate of the references, Hz.

    Raises:
        ParameterError: a number is not valid.
    """

    duration: float | None = None
    runs: int = 1
    terms: int | None = None
    start: Sequence[float] | None = None
    rate: float = 200.0

    def __post_init__(self) -> None:
        _require_count("runs", self.runs)
        _require_positive("rate", self.rate)


@dataclass(frozen=True)
class Search:
    """Options of the search for runs.

    Attributes:
        budget: time limit, s. The search then stops and keeps its best result.
        searches: number of random starts to improve.
        iterations: maximum number of motions that each search tries.
        seed: seed of the random starts. The same seed gives the same runs, unless the time limit
            ends the search.

    Raises:
        ParameterError: a number is not valid.
    """

    budget: float = 60.0
    searches: int = 4
    iterations: int = 20_000
    seed: int = 0

    def __post_init__(self) -> None:
        _require_positive("budget", self.budget)
        _require_count("searches", self.searches)
        _require_count("iterations", self.iterations)


def _require_positive(what: str, value: float) -> None:
    """Raise ParameterError if a number is not above 0, or not finite."""
    if not 0 < value < math.inf:
        raise ParameterError(f"{what} {value:g}; accepted: a number above 0")


def _require_count(what: str, count: int) -> None:
    if count < 1:
        raise ParameterError(f"{what} {count}; accepted: 1 or more")


def condition_number(W: FloatArray) -> float:
    """Return the condition number of W (K, p) with columns scaled to unit norm; inf if singular."""
    norms = np.linalg.norm(W, axis=0)
    if len(W) < W.shape[1] or not norms.all():
        return math.inf
    return float(np.linalg.cond(np.linalg.qr(W / norms, mode="r")))


@dataclass(frozen=True, eq=False)
class Checked:
    """A motion of all runs, with its largest use of each limit, checked every millisecond."""

    runs: tuple[Trajectory, ...]
    uses: tuple[LimitUse, ...]


def _equations(
    evaluator: Evaluator, model: EquationModel, runs: Sequence[Trajectory], rate: float
) -> Rows:
    """Return the equations that identify would build from runs sampled at `rate` Hz.

    Raises:
        IdentificationError: a window does not fit a run.
    """
    out = []
    for k, run in enumerate(runs, 1):
        t = run.times(1 / rate)
        q, qd = (read_only(run.at(t, order)) for order in range(2))
        step = float(t[1] - t[0])
        samples = Samples(f"run {k}", t, q, qd, np.zeros_like(q), step, None, ())
        out.append(model.equations(evaluator, unfiltered(samples)))
    return join(out)


def _checked(objective: Objective, best: MotionCandidate) -> Checked:
    """Return the runs of a candidate, shrunk until all limits hold every millisecond."""
    fine = objective.at_steps(FINE)
    runs: list[Trajectory] = []
    uses: list[LimitUse] = []
    for run in best.runs:
        fitted = fine.fitted(run.z)
        runs.append(fine.space.trajectory(fitted.z, fine.sampled))
        uses += [*fine.limits.uses(fitted.motion), *fine.uses(fitted.motion)]
    return Checked(tuple(runs), largest_uses(uses))


def _scale(objective: Objective, torque: FloatArray) -> FloatArray:
    """Return the reference value of each parameter for its standard deviation, (p,).

    It is the value that alone causes 1 % of a joint's torque limit, or the value in the prior
    model if that is larger.

    Args:
        objective: its limits and prior model are used.
        torque: RMS torque of each parameter with a value of 1, (n, p).
    """
    shares = (torque / _visible(objective.limits)[:, None]).max(axis=0)
    small = 1 / np.maximum(shares, np.finfo(float).tiny)
    if objective.prior is not None:
        small = np.maximum(small, np.abs(objective.prior[: len(small)]))
    return np.asarray(small)


def excite(
    robot: Robot | str | Path,
    *,
    model: str = "momentum",
    limits: Limits | None = None,
    motion: Motion | None = None,
    search: Search | None = None,
    parameters: str | Path | None = None,
    noise: Sequence[float] | None = None,
    window: float = 0.2,
    progress: Say = silent,
    meter: Meter = silent,
) -> Plan:
    """Find runs within limits from which the parameters of a robot can be identified.

    Args:
        robot: a robot, a path or a library name.
        model: model to identify with: "energy", "momentum" or "torque".
        limits: limits of the motion. Missing ones come from the [limits] of the robot. Torque
            limits apply to the torque of the prior model.
        motion: number, duration and kind of the runs.
        search: time limit, number of searches, seed.
        parameters: parameters of the prior model: estimate.json, or TOML with [parameters].
        noise: standard deviation of the torque noise in the logs, (n,), N m or N. Default 1 % of
            the torque limits; 1 N m (or N) for joints without a torque limit.
        window: length of the windows of energy and momentum, s.
        progress: called with a text about the current step.
        meter: called with the finished part, from 0 to 1.

    Returns:
        The runs, which keep every limit at every millisecond. The condition numbers are those of
        the equations that `identify` would solve, for all three models.

    Raises:
        ParameterError: an argument is not valid.
        IdentificationError: no motion within the limits determines the parameters, or keeps the
            torque limits. The message names the limits that bind.
    """
    motion, search = motion or Motion(), search or Search()
    if model not in _MODELS:
        raise ParameterError(f"model {model!r}; accepted: {', '.join(_MODELS)}")
    _require_positive("window", window)
    source = read_robot(robot).at_rest()
    require_gravity(source, "an excitation")
    require_model(source, model)
    passed = limits or Limits()
    source = replace(source, limits=passed.over(source.limits))
    allowed = bounds(source)
    notes = _require_prior(parameters, allowed, requested=passed.torque is not None)
    progress("deriving and compiling the model")
    fence = source.limits if source.limits is not None and source.limits.cell else None
    every = [EquationModel(name, window) for name in _MODELS]
    kernels = dict.fromkeys(k for m in every for k in m.all_kernels)
    derived = derive(source, (*kernels, FRAMES) if fence else tuple(kernels))
    prior = None if parameters is None else read_parameters(parameters, derived)
    evaluator = load(derived)
    cell = Cell(evaluator, fence) if fence else None
    length = _duration(motion, derived, model, window)
    begin = None
    if motion.start is not None:
        where = "one position inside the limits"
        begin = _one_each("start", motion.start, allowed.low, allowed.high, where)
    choices = space(fourier_series(length, motion.terms), allowed, begin)
    count = len(derived.base.parameters)
    enough = _ROWS * count / (1 if model == "energy" else source.n) / motion.runs
    objective = Objective(
        evaluator, model, _noise(noise, allowed), motion.rate, allowed, prior, cell,
        choices, grid(choices, enough), motion.runs,
    )  # fmt: skip
    clock = Clock(search.budget)
    reached: list[tuple[MotionCandidate, MotionCandidate]] = []  # start and result of each search
    ended = 0
    with clock.listening():
        for k in range(search.searches):
            if k and clock.remaining <= 0:
                break
            draw = np.random.default_rng([search.seed, k])
            first = objective.drawn(draw)
            if k == 0:
                scale = _scale(objective, objective.torque(first))
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: begins at {_text(first, scale)}")
            last = objective.improved(first, draw, search.iterations, clock)
            ended += clock.remaining > 0
            reached.append((first, last))
            meter((k + 1) / search.searches)
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: reaches {_text(last, scale)}")
    best = min((last for _, last in reached), key=lambda candidate: candidate.rank)
    start = min((first for first, _ in reached), key=lambda candidate: candidate.rank)
    checked = _checked(objective, best)
    if best.rank[0] > 1 or largest_share(checked.uses) > 1:
        raise _too_much_torque(source, checked)
    conditions, independent = dict.fromkeys(_MODELS, math.inf), 0.0
    for other in every:
        # Skip a model whose windows or filter do not fit these runs.
        with suppress(IdentificationError, LogError):
            rows = _equations(evaluator, other, checked.runs, motion.rate)
            conditions[other.name] = condition_number(rows.W.reshape(-1, len(rows.names)))
            if other.name == model:
                independent = sum(e.rows / e.correlation for e in rows.parts)
    if not conditions[model] <= SINGULAR:
        raise _singular(source, model, checked, conditions[model])
    stopped = "done" if ended == search.searches else "budget"
    way = (allowed.high - allowed.low) / allowed.rates[0]
    names = derived.base.names
    return Plan(
        robot=source.name,
        model=model,
        window=window,
        rate=motion.rate,
        runs=checked.runs,
        conditions=conditions,
        std=dict(zip(names, best.std.tolist(), strict=False)),
        scale=dict(zip(names, scale.tolist(), strict=False)),
        start=geometric_mean(start.std / scale),
        uses=tuple(sorted(checked.uses, key=lambda u: u.joint)),
        parameters=count,
        independent=independent,
        searches=(ended, search.searches),
        stopped="interrupted" if clock.interrupted else stopped,
        notes=notes,
        approach=float(math.ceil(_APPROACH * way.max())),
        joints=joints_of(source),
        bounds=allowed,
        source=source,
    )


def _require_prior(
    parameters: str | Path | None, limits: Bounds, *, requested: bool
) -> tuple[str, ...]:
    """Return a note if torque limits of the robot are not checked without a prior model.

    Args:
        parameters: file of the prior model, or None.
        limits: limits of the joints.
        requested: whether the caller passed torque limits.

    Raises:
        ParameterError: the caller passed torque limits without a prior model.
    """
    if parameters is not None:
        return ()
    if requested:
        raise ParameterError(
            "limits of torque need a prior model; accepted: parameters as well (estimate.json, or "
            "TOML with [parameters])"
        )
    if not np.isfinite(limits.torque).any():
        return ()
    return ("torque limits are not checked: pass --parameters of a prior model to check them",)


def _visible(limits: Bounds) -> FloatArray:
    """Return the visible torque of each joint, (n,): 1 % of its limit, or 1 N m or N without a
    limit.
    """
    return np.where(np.isfinite(limits.torque), _VISIBLE * limits.torque, 1.0)


def _noise(noise: Sequence[float] | None, limits: Bounds) -> FloatArray:
    if noise is None:
        return _visible(limits)
    low = np.zeros_like(limits.low)
    return _one_each("noise", noise, low, low + math.inf, "one number above 0")


def _one_each(
    what: str, values: Sequence[float], low: FloatArray, high: FloatArray, accepted: str
) -> FloatArray:
    """Return a value of each joint, (n,).

    Raises:
        ParameterError: their number is wrong, or one is not between low and high.
    """
    out = np.array(values, dtype=float)
    if out.shape != low.shape or not ((low < out) & (out < high)).all():
        listed = ", ".join(f"{x:g}" for x in out.ravel())
        raise ParameterError(f"{what} {listed}; accepted: {accepted} for each of {len(low)} joints")
    return out


def _text(candidate: MotionCandidate, scale: FloatArray) -> str:
    excess = candidate.rank[0]
    if excess > 1:
        return "a motion that exceeds torque limits or comes too near to floor or boxes"
    return f"a standard deviation of {100 * geometric_mean(candidate.std / scale):.3g} %"


def _duration(motion: Motion, derived: Model, model: str, window: float) -> float:
    """Return the duration of each run in s: as requested, or long enough for identify."""
    if motion.duration is None:
        parameters = len(derived.base.parameters)
        per_window = 1 if model == "energy" else derived.robot.n
        needed = WINDOWS * parameters * window / per_window / (1 - HELD_OUT)
        usual = _USUAL if model == "torque" else max(_USUAL, needed / motion.runs + window)
        return float(math.ceil(usual))
    shortest = MIN_SAMPLES / motion.rate
    least = shortest if model == "torque" else window + shortest
    if not least < motion.duration < math.inf:
        raise ParameterError(
            f"a run of {motion.duration:g} s; accepted: more than {least:.4g} s (the window and "
            f"{MIN_SAMPLES} samples)"
        )
    return float(motion.duration)


def _too_much_torque(robot: Robot, closest: Checked) -> IdentificationError:
    use = max((u for u in closest.uses if u.limit in SHRUNK), key=lambda u: u.share)
    if use.limit in CELL:
        return IdentificationError(
            f"{robot.name}: no motion that was tried keeps clear of the {use.limit}: the frame of "
            f"{robot.label(use.joint)} has a clearance of {use.extreme:.3g} m; accepted: a range "
            "of positions whose middle is clear of floor and boxes, smaller ranges, or another "
            "cell in [limits]"
        )
    return IdentificationError(
        f"{robot.name}: no motion that was tried keeps the torque of {robot.label(use.joint)}: it "
        f"needs "
        f"{abs(use.extreme):.4g}, allowed {abs(use.allowed):.4g}; accepted: a higher limit, "
        "another range of positions, or a longer budget"
    )


def _singular(robot: Robot, model: str, best: Checked, condition: float) -> IdentificationError:
    binding = binding_text(tuple(u for u in best.uses if u.binds)) or "no limit binds"
    total = " + ".join(f"{run.duration:g}" for run in best.runs)
    return IdentificationError(
        f"{robot.name}: no motion of {total} s that was tried determines the parameters of the "
        f"model of {model} (condition number {condition:.3g}; {binding}); accepted: a longer "
        "duration, more runs or terms, or wider limits"
    )
