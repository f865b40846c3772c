"""excite: find motions within limits from which the parameters of a robot can be identified.

The search maximizes the precision of the parameters that noisy logs of the motion give (Swevers et
al. 1997). A condition number would not do: its columns have unit norm, so a slow motion in which
noise dominates counts as much as a fast one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from symgen.codegen.model import Model, derive
from symgen.data.log import read_only
from symgen.data.raw import FloatArray
from symgen.data.signals import Samples
from symgen.errors import IdentificationError, LogError, ParameterError
from symgen.estimation.equation_model import NEEDED, EquationModel, require_model
from symgen.estimation.filtered_log import unfiltered
from symgen.estimation.logs import HELD_OUT
from symgen.estimation.system import Equations
from symgen.experiment.bounds import (
    CELL,
    FINE,
    FRAMES,
    Bounds,
    Cell,
    Coefficients,
    Space,
    Use,
    bounds,
    space,
    worst,
)
from symgen.experiment.plan import Plan, binding_text, geometric_mean
from symgen.experiment.search import Candidate, Clock, Objective, grid
from symgen.experiment.trajectory import SMOOTH, Trajectory, basis
from symgen.identification.assessment import WINDOWS
from symgen.identification.estimate import joints_of
from symgen.identification.parameters import read_parameters
from symgen.parallel import Meter, Say, silent
from symgen.robot.tables import Limits
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot, require_gravity
from symgen.runtime.evaluator import Evaluator, load

#: Condition number above which runs determine nothing: refused.
SINGULAR = 1e5
_USUAL = 10.0  # s, the shortest run that is chosen without being asked for
_MODELS = tuple(NEEDED)
_SHRUNK = ("torque", *CELL)  # limits that are kept by shrinking the whole motion
_SHRINK, _SMALLEST = 0.99, 0.9  # of it, again and again: between the samples of the search
_ROWS = 4  # equations for each parameter in the search, at least
_VISIBLE = 0.01  # share of a torque limit: default noise, and torque of a parameter that matters
#: Duration of the approach, over the way at the allowed speed: a tenth of that speed is the peak,
#: 1.875 times the mean, of a motion of degree five from rest to rest.
_APPROACH = 18.75


@dataclass(frozen=True)
class Motion:
    """Number, duration and kind of the runs of an excitation.

    Attributes:
        duration: duration in s, one value for all runs or one for each. None means at least 10 s,
            and long enough for `identify` to trust the result.
        runs: number of runs, each with its own coefficients.
        kind: "fourier", "bspline", or "cubic" and "cosine" of the paper; one for all joints or one
            for each.
        terms: number of harmonics, coefficients (bspline) or strokes (cubic) of a joint; None
            chooses it from the duration.
        start: start position of every run, (n,), rad or m; None if free.
        rate: sampling rate of the references, Hz.

    Raises:
        ParameterError: a number is not valid.
    """

    duration: float | Sequence[float] | None = None
    runs: int = 1
    kind: str | Sequence[str] = "fourier"
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
        iterations: largest number of motions that each search tries.
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


def _excess(uses: Iterable[Use]) -> float:
    """Return the largest used share of the torque limits and of the cell."""
    return max((u.share for u in uses if u.limit in _SHRUNK), default=0.0)


def condition_number(W: FloatArray) -> float:
    """Return the condition number of W (K, p), its columns scaled to unit norm; inf if singular."""
    norms = np.linalg.norm(W, axis=0)
    if len(W) < W.shape[1] or not norms.all():
        return math.inf
    return float(np.linalg.cond(np.linalg.qr(W / norms, mode="r")))


@dataclass(frozen=True, eq=False)
class Checked:
    """A motion of all runs, with its largest use of each limit, every millisecond."""

    runs: tuple[Trajectory, ...]
    uses: tuple[Use, ...]


@dataclass(frozen=True, eq=False)
class Judge:
    """Judges motions by the limits every millisecond, and by the equations of `identify`."""

    evaluator: Evaluator
    name: str
    window: float
    rate: float
    limits: Bounds
    prior: FloatArray | None
    notes: tuple[str, ...]
    cell: Cell | None

    @property
    def model(self) -> Model:
        """The derived model."""
        return self.evaluator.model

    def equations(self, runs: Sequence[Trajectory], name: str) -> tuple[Equations, ...]:
        """Return the equations that identify would build from these runs.

        Raises:
            IdentificationError: a window does not fit a run.
        """
        model = EquationModel(name, self.window)
        out: list[Equations] = []
        for k, run in enumerate(runs, 1):
            t = run.times(1 / self.rate)
            q, qd = (read_only(run.at(t, order)) for order in range(2))
            step = float(t[1] - t[0])
            samples = Samples(f"run {k}", t, q, qd, np.zeros_like(q), step, None, ())
            out += model.equations(self.evaluator, unfiltered(samples))
        return tuple(out)

    def condition(self, runs: Sequence[Trajectory], name: str) -> float:
        """Return the condition number of identify's regressor of these runs."""
        return condition_number(np.concatenate([e.W for e in self.equations(runs, name)]))

    def checked(self, spaces: Sequence[Space], best: Candidate) -> Checked:
        """Return the runs of a candidate, shrunk until all limits hold every millisecond."""
        sampled = [s.sampled(s.times(math.ceil(s.bases[0].duration / FINE))) for s in spaces]
        parts = [*zip(spaces, sampled, strict=True)]
        pairs = zip(parts, best.runs, strict=True)
        found = [s.fitted(run.z, m) for (s, m), run in pairs]
        factor, uses = 1.0, tuple[Use, ...]()
        while not uses or (_excess(uses) > 1 and factor > _SMALLEST):
            factor *= _SHRINK if uses else 1.0
            every: list[Use] = []
            for (s, m), z in zip(parts, found, strict=True):
                motion = s.motion(_scaled(z, factor), m)
                every += [*self.limits.uses(motion), *self.uses(motion)]
            uses = worst(every)
        runs = (s.trajectory(_scaled(z, factor), m) for (s, m), z in zip(parts, found, strict=True))
        return Checked(tuple(runs), uses)

    def uses(self, motion: FloatArray) -> Iterator[Use]:
        """Yield the used share of the torque limits and of the cell by q, qd, qdd, (3, N, n)."""
        q, qd, qdd = (np.ascontiguousarray(x) for x in motion[:3])
        if self.prior is not None:
            torque = self.evaluator["inverse_dynamics"](q, qd, qdd, self.prior)
            top = self.limits.torque
            yield from self.limits.used("torque", torque, -top, top)
        if self.cell is not None:
            yield from self.cell.uses(q)

    def objective(self, spaces: tuple[Space, ...], noise: FloatArray) -> Objective:
        """Return what the search minimizes; noise is that of the torques, (n,)."""
        parameters, lines = len(self.model.base.parameters), self.model.robot.n
        enough = _ROWS * parameters / (1 if self.name == "energy" else lines) / len(spaces)
        sampled = tuple(grid(choices, enough) for choices in spaces)
        return Objective(
            self.evaluator,
            self.name,
            noise,
            self.rate,
            spaces,
            sampled,
            lambda motion: _excess(self.uses(motion)),
        )

    def scale(self, torque: FloatArray) -> FloatArray:
        """Return the value of each parameter that its standard deviation is compared with, (p,).

        It is the value that alone causes 1 % of a joint's torque limit, or the value in the prior
        model if that is larger.

        Args:
            torque: RMS torque that each parameter causes with a value of 1, (n, p).
        """
        shares = (torque / _visible(self.limits)[:, None]).max(axis=0)
        small = 1 / np.maximum(shares, np.finfo(float).tiny)
        if self.prior is not None:
            small = np.maximum(small, np.abs(self.prior[: len(small)]))
        return np.asarray(small)

    def plan(
        self,
        best: Checked,
        std: FloatArray,
        scale: FloatArray,
        start: float,
        searches: tuple[int, int],
        stopped: str,
    ) -> Plan:
        """Return the plan, with the condition numbers of all models."""
        own = self.equations(best.runs, self.name)
        conditions = dict.fromkeys(_MODELS, math.inf)
        for name in _MODELS:
            # Where windows or filter do not fit these runs.
            with suppress(IdentificationError, LogError):
                conditions[name] = self.condition(best.runs, name)
        way = (self.limits.high - self.limits.low) / self.limits.rates[0]
        return Plan(
            robot=self.model.robot.name,
            model=self.name,
            window=self.window,
            rate=self.rate,
            runs=best.runs,
            conditions=conditions,
            std=dict(zip(self.model.base.names, std.tolist(), strict=False)),
            scale=dict(zip(self.model.base.names, scale.tolist(), strict=False)),
            start=start,
            uses=tuple(sorted(best.uses, key=lambda u: u.joint)),
            parameters=len(self.model.base.parameters),
            independent=sum(len(e.y) / e.correlation for e in own),
            searches=searches,
            stopped=stopped,
            notes=self.notes,
            approach=float(math.ceil(_APPROACH * way.max())),
            joints=joints_of(self.model.robot),
            bounds=self.limits,
        )


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
        meter: called with the part that is done, from 0 to 1.

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
    source = read_robot(robot)
    require_gravity(source, "an excitation")
    require_model(source, model)
    given = limits or Limits()
    source = replace(source, limits=given.over(source.limits))
    allowed = bounds(source)
    kinds = _kinds(motion.kind, source, allowed)
    progress("deriving and compiling the model")
    task = _judge(source, model, window, motion.rate, allowed, parameters, given.torque is not None)
    lengths = _durations(motion.duration, motion.runs, task)
    begin = None
    if motion.start is not None:
        where = "one position inside the limits"
        begin = _one_each("start", motion.start, allowed.low, allowed.high, where)
    spaces = []
    for length in lengths:
        joints = tuple(basis(kind, length, motion.terms) for kind in kinds)
        spaces.append(space(joints, allowed, begin))
    objective = task.objective(tuple(spaces), _noise(noise, allowed))
    clock = Clock(search.budget)
    reached: list[tuple[Candidate, Candidate]] = []  # where searches begin and end
    ended = 0
    with clock.listening():
        for k in range(search.searches):
            if k and clock.left <= 0:
                break
            draw = np.random.default_rng([search.seed, k])
            first = objective.drawn(draw)
            if k == 0:
                scale = task.scale(objective.torque(first))
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: begins at {_text(first, scale)}")
            last = objective.improved(first, draw, search.iterations, clock)
            ended += clock.left > 0
            reached.append((first, last))
            meter((k + 1) / search.searches)
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: reaches {_text(last, scale)}")
    best = min((last for _, last in reached), key=lambda candidate: candidate.rank)
    start = min((first for first, _ in reached), key=lambda candidate: candidate.rank)
    checked = task.checked(spaces, best)
    if best.rank[0] > 1 or _excess(checked.uses) > 1:
        raise _too_much_torque(source, checked)
    condition = task.condition(checked.runs, model)
    if not condition <= SINGULAR:
        raise _singular(source, model, lengths, checked, condition)
    stopped = (
        "interrupted" if clock.interrupted else "done" if ended == search.searches else "budget"
    )
    begun = geometric_mean(start.std / scale)
    return task.plan(checked, best.std, scale, begun, (ended, search.searches), stopped)


def _judge(
    robot: Robot,
    name: str,
    window: float,
    rate: float,
    limits: Bounds,
    parameters: str | Path | None,
    asked: bool,
) -> Judge:
    """Load the models and limits that motions are judged by.

    Args:
        robot: the mechanism.
        name: name of the model that will be used.
        window: window of energy and momentum, s.
        rate: sampling rate, Hz.
        limits: limits of the joints.
        parameters: file of the prior model, or None.
        asked: whether the caller passed torque limits.

    Raises:
        ParameterError: limits of torque without a prior model.
    """
    limited = bool(np.isfinite(limits.torque).any())
    notes: tuple[str, ...] = ()
    if parameters is None and asked:
        raise ParameterError(
            "limits of torque need a prior model; accepted: parameters as well (estimate.json, or "
            "TOML with [parameters])"
        )
    if parameters is None and limited:
        notes = ("torque limits are not checked: pass --parameters of a prior model to check them",)
    fence = robot.limits if robot.limits is not None and robot.limits.cell else None
    kernels = dict.fromkeys(k for m in _MODELS for k in EquationModel(m, window).all_kernels)
    model = derive(robot, (*kernels, FRAMES) if fence else tuple(kernels))
    prior = None if parameters is None else read_parameters(parameters, model)
    evaluator = load(model)
    cell = Cell(evaluator, fence) if fence else None
    return Judge(evaluator, name, window, rate, limits, prior, notes, cell)


def _scaled(z: Coefficients, factor: float) -> Coefficients:
    return tuple(factor * part for part in z)


def _visible(limits: Bounds) -> FloatArray:
    """Return the torque of each joint that counts as visible, (n,): 1 N m or N without a limit."""
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


def _text(candidate: Candidate, scale: FloatArray) -> str:
    excess = candidate.rank[0]
    if excess > 1:
        return "a motion that exceeds torque limits or comes too near to floor or boxes"
    return f"a standard deviation of {100 * geometric_mean(candidate.std / scale):.3g} %"


def _kinds(kind: str | Sequence[str], robot: Robot, limits: Bounds) -> tuple[str, ...]:
    n = robot.n
    kinds = (kind,) * n if isinstance(kind, str) else tuple(kind)
    if len(kinds) != n:
        raise ParameterError(f"{len(kinds)} kinds; accepted: one, or one for each of {n} joints")
    for j, name in enumerate(kinds):
        if name not in SMOOTH and np.isfinite(limits.rates[2, j]):
            raise ParameterError(
                f"{robot.listed([j])}: accelerations of kind {name} jump, and its jerk is limited; "
                f"accepted: {', '.join(SMOOTH)}"
            )
    return kinds


def _durations(
    duration: float | Sequence[float] | None, runs: int, task: Judge
) -> tuple[float, ...]:
    """Return the duration of each run in s: as requested, or long enough for the energy model."""
    if duration is None:
        parameters = len(task.model.base.parameters)
        per_window = 1 if task.name == "energy" else task.model.robot.n
        needed = WINDOWS * parameters * task.window / per_window / (1 - HELD_OUT)
        usual = _USUAL if task.name == "torque" else max(_USUAL, needed / runs + task.window)
        return (float(math.ceil(usual)),) * runs
    given = np.atleast_1d(np.asarray(duration, dtype=float))
    lengths = tuple(given.tolist()) * (runs if len(given) == 1 else 1)
    if len(lengths) != runs:
        raise ParameterError(f"{len(lengths)} durations; accepted: one, or one for each run")
    least = task.window if task.name != "torque" else 0.0
    for length in lengths:
        if not least + 10 / task.rate < length < math.inf:
            raise ParameterError(
                f"a run of {length:g} s; accepted: more than {least + 10 / task.rate:.4g} s (the "
                "window and ten samples)"
            )
    return lengths


def _too_much_torque(robot: Robot, closest: Checked) -> IdentificationError:
    use = max((u for u in closest.uses if u.limit in _SHRUNK), key=lambda u: u.share)
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


def _singular(
    robot: Robot, model: str, lengths: Sequence[float], best: Checked, condition: float
) -> IdentificationError:
    binding = binding_text(tuple(u for u in best.uses if u.share >= 0.9)) or "no limit binds"
    total = " + ".join(f"{x:g}" for x in lengths)
    return IdentificationError(
        f"{robot.name}: no motion of {total} s that was tried determines the parameters of the "
        f"model of {model} (condition number {condition:.3g}; {binding}); accepted: a longer "
        "duration, more runs or terms, or wider limits"
    )
