"""excite: find motions within limits from which the parameters of a robot can be identified.

The method is that of Gautier and Khalil (1992) and Swevers (1997): choose the coefficients of a
trajectory with the best condition number of the base regressor. symgen uses the regressor of the
model that will be identified, with the same windows, because a motion can be good for the torque
model and singular for the energy model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
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
from symgen.experiment.bounds import CELL, FRAMES, Bounds, Cell, Space, Use, bounds, space, worst
from symgen.experiment.plan import Plan, binding_text
from symgen.experiment.search import CRITERIA, Clock, Program
from symgen.experiment.trajectory import SMOOTH, Trajectory, basis
from symgen.identification.assessment import WINDOWS
from symgen.identification.estimate import joints_of
from symgen.identification.parameters import read_parameters
from symgen.parallel import Meter, Say, silent
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Limits, Robot, require_gravity
from symgen.runtime.evaluator import Evaluator, load

#: Condition number above which runs determine nothing: refused.
SINGULAR = 1e5
_DRAWS = 8  # random motions of which each search begins with the best
_LONGEST = 600.0  # s, of a run
_USUAL = 10.0  # s, the shortest run that is chosen without being asked for
_MODELS = tuple(NEEDED)
_SHRUNK = ("torque", *CELL)  # limits that are kept by shrinking the whole motion
_SHRINK = 0.9  # of it, again and again
_SMALLEST, _SMALLEST_IN_CELL = 0.5, 0.25
_HALVINGS = 5  # of the last step
_SLOW = 0.1  # of the allowed speeds, in the approach
_PEAK = 1.875  # of the mean speed of a motion of degree five from rest to rest
_MOST = 10_000  # runs, searches, iterations


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
        criterion: "condition" number, or "logdet" of the information matrix.
        budget: time limit, s. The search then stops and keeps its best result.
        searches: number of random starts to improve.
        iterations: largest number of IPOPT iterations for each start.
        seed: seed of the random starts. The same seed gives the same runs, unless the time limit
            ends the search.

    Raises:
        ParameterError: a number is not valid.
    """

    criterion: str = "condition"
    budget: float = 60.0
    searches: int = 4
    iterations: int = 500
    seed: int = 0

    def __post_init__(self) -> None:
        if self.criterion not in CRITERIA:
            raise ParameterError(f"criterion {self.criterion!r}; accepted: {', '.join(CRITERIA)}")
        _require_positive("budget", self.budget)
        _require_count("searches", self.searches)
        _require_count("iterations", self.iterations)


def _require_positive(what: str, value: float) -> None:
    """Raise ParameterError if a number is not above 0, or not finite."""
    if not 0 < value < math.inf:
        raise ParameterError(f"{what} {value:g}; accepted: a number above 0")


def _require_count(what: str, count: int) -> None:
    if not 1 <= count <= _MOST:
        raise ParameterError(f"{what} {count}; accepted: 1 to {_MOST}")


@dataclass(frozen=True, eq=False)
class Found:
    """A motion of all runs, with its use of limits on a fine grid and its condition number.

    `start` is the condition number of the random motion that its search began with.
    """

    runs: tuple[Trajectory, ...]
    uses: tuple[Use, ...]
    condition: float = math.nan
    log_det: float = math.nan
    start: float = math.nan

    def __str__(self) -> str:
        return f"condition number {self.condition:.4g}"

    @property
    def excess(self) -> float:
        """Largest used share of the torque limits and of the cell."""
        return max((u.share for u in self.uses if u.limit in _SHRUNK), default=0.0)

    @property
    def keeps(self) -> bool:
        """Whether torques and cell are within their limits; the other limits always hold."""
        return self.excess <= 1


def quality(W: FloatArray) -> tuple[float, float]:
    """Return condition number and log det of W'W, columns of W (K, p) scaled to unit norm.

    They are inf and -inf if W is singular.
    """
    norms = np.linalg.norm(W, axis=0)
    if len(W) < W.shape[1] or not norms.all():
        return math.inf, -math.inf
    singular = np.linalg.svd(np.linalg.qr(W / norms, mode="r"), compute_uv=False)
    if singular[-1] <= 1e-14 * singular[0]:
        return math.inf, -math.inf
    return float(singular[0] / singular[-1]), float(2 * np.log(singular).sum())


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

    def quality(self, runs: Sequence[Trajectory], name: str) -> tuple[float, float]:
        """Return condition number and log det of identify's regressor of these runs."""
        return quality(np.concatenate([e.W for e in self.equations(runs, name)]))

    def judged(self, choices: Space, z: FloatArray, start: float = 0.0) -> Found:
        """Return a motion scaled into its limits, with its condition number.

        `start` is the condition number that its search began with, by default its own.

        Each joint is scaled about the centre into its own limits. Then all joints together are
        scaled until the torques and the cell are within their limits.
        """
        z = choices.fitted(z)
        found, factor, too_much = self._used(choices, z), 1.0, 1.0
        smallest = _SMALLEST if self.cell is None else _SMALLEST_IN_CELL
        while not found.keeps and factor > smallest:
            too_much, factor = factor, _SHRINK * factor
            found = self._used(choices, factor * z)
        for _ in range(_HALVINGS if too_much > factor and found.keeps else 0):
            middle = (factor + too_much) / 2
            tried = self._used(choices, middle * z)
            if tried.keeps:
                factor, found = middle, tried
            else:
                too_much = middle
        condition, log_det = self.quality(found.runs, self.name)
        return Found(found.runs, found.uses, condition, log_det, start or condition)

    def _used(self, choices: Space, z: FloatArray) -> Found:
        """Return the runs of z, and the used share of every limit."""
        runs, torque = choices.trajectories(z), None
        if self.prior is not None:
            torque = partial(self.evaluator["inverse_dynamics"], X=self.prior)
        every = [u for r in runs for u in self.limits.uses(r, torque)]
        every += [u for r in runs if self.cell for u in self.cell.uses(r)]
        return Found(runs, worst(every))

    def plan(self, best: Found, searches: tuple[int, int], stopped: str) -> Plan:
        """Return the plan, with the condition numbers of the other models."""
        own = self.equations(best.runs, self.name)
        conditions = dict.fromkeys(_MODELS, math.inf)
        for name in _MODELS:
            # Where windows or filter do not fit these runs.
            with suppress(IdentificationError, LogError):
                conditions[name] = self.quality(best.runs, name)[0]
        # The farthest way between positions takes a tenth of the allowed speeds.
        way = (self.limits.high - self.limits.low) / (_SLOW * self.limits.rates[0])
        return Plan(
            robot=self.model.robot.name,
            model=self.name,
            window=self.window,
            rate=self.rate,
            runs=best.runs,
            conditions=conditions,
            log_det=best.log_det,
            start=best.start,
            uses=tuple(sorted(best.uses, key=lambda u: u.joint)),
            parameters=len(self.model.base.parameters),
            independent=sum(len(e.y) / e.correlation for e in own),
            searches=searches,
            stopped=stopped,
            notes=self.notes,
            approach=float(math.ceil(_PEAK * way.max())),
            joints=joints_of(self.model.robot),
            bounds=self.limits,
        )


def judge(
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
        parameters: file of the prior model; None if torques are not limited.
        asked: whether the caller passed torque limits.

    Raises:
        ParameterError: limits of torque without a prior model, or the other way round.
    """
    limited = bool(np.isfinite(limits.torque).any())
    notes: tuple[str, ...] = ()
    if parameters is None and asked:
        raise ParameterError(
            "limits of torque need a prior model; accepted: parameters as well (estimate.json, or "
            "TOML with [parameters])"
        )
    if parameters is not None and not limited:
        raise ParameterError(
            "--parameters without torque limits has no effect; accepted: torque in [limits], or "
            "--torque"
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


def excite(
    robot: Robot | str | Path,
    *,
    model: str = "momentum",
    limits: Limits | None = None,
    motion: Motion | None = None,
    search: Search | None = None,
    parameters: str | Path | None = None,
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
        search: criterion, time limit, seed.
        parameters: parameters of the prior model: estimate.json, or TOML with [parameters].
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
    clock = Clock(search.budget)

    def value(found: Found) -> float:
        return found.condition if search.criterion == "condition" else -found.log_det

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
    task = judge(source, model, window, motion.rate, allowed, parameters, given.torque is not None)
    lengths = _durations(motion.duration, motion.runs, task)
    bases = tuple(tuple(basis(k, length, motion.terms) for k in kinds) for length in lengths)
    choices = space(bases, allowed, _start(motion.start, allowed, source.n))
    program = Program(
        source, choices, model, window, search.criterion, task.prior, clock, search.iterations
    )
    tried: list[Found] = []
    ended = 0
    with clock.listening():
        for k in range(search.searches):
            if k and clock.left <= 0:
                break
            draw = np.random.default_rng([search.seed, k])
            drawn = [choices.drawn(draw) for _ in range(_DRAWS if clock.left > 0 else 1)]
            first = min(drawn, key=lambda z: float(program.loss(z)))
            before = task.judged(choices, first)
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: begins at {before}")
            z = first if clock.left <= 0 else program.solve(first)
            after = task.judged(choices, z, before.condition)
            ended += clock.left > 0
            tried += [before, after]
            best = min((found for found in tried if found.keeps), key=value, default=None)
            shown = f"best {best}" if best else "none keeps its limits"
            meter((k + 1) / search.searches)
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: reaches {after}; {shown}")
    if best is None:
        raise _too_much_torque(source, min(tried, key=lambda found: found.excess))
    if not best.condition <= SINGULAR:
        raise _singular(source, model, lengths, best)
    stopped = (
        "interrupted" if clock.interrupted else "done" if ended == search.searches else "budget"
    )
    return task.plan(best, (ended, search.searches), stopped)


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


def _start(start: Sequence[float] | None, limits: Bounds, n: int) -> FloatArray | None:
    if start is None:
        return None
    q = np.array(start, dtype=float)
    if q.shape != (n,) or not ((limits.low < q) & (q < limits.high)).all():
        raise ParameterError(
            f"start {', '.join(f'{x:g}' for x in q.ravel())}; accepted: one position for each of "
            f"{n} joints, inside the limits"
        )
    return q


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
    given = [duration] if isinstance(duration, (int, float)) else list(duration)
    lengths = tuple(map(float, given * (runs if len(given) == 1 else 1)))
    if len(lengths) != runs:
        raise ParameterError(f"{len(lengths)} durations; accepted: one, or one for each run")
    least = task.window if task.name != "torque" else 0.0
    for length in lengths:
        if not least + 10 / task.rate < length <= _LONGEST:
            raise ParameterError(
                f"a run of {length:g} s; accepted: more than {least + 10 / task.rate:.4g} s (the "
                f"window and ten samples), at most {_LONGEST:g} s"
            )
    return lengths


def _too_much_torque(robot: Robot, closest: Found) -> IdentificationError:
    use = max((u for u in closest.uses if u.limit in _SHRUNK), key=lambda u: u.share)
    if use.limit in CELL:
        return IdentificationError(
            f"{robot.name}: no motion that was tried keeps clear of the {use.limit}: the frame of "
            f"{robot.label(use.joint)} comes {-use.extreme:.3g} m too far; accepted: a range of "
            "positions whose "
            "middle is clear of floor and boxes, smaller ranges, or another cell in [limits]"
        )
    return IdentificationError(
        f"{robot.name}: no motion that was tried keeps the torque of {robot.label(use.joint)}: it "
        f"needs "
        f"{abs(use.extreme):.4g}, allowed {abs(use.allowed):.4g}; accepted: a higher limit, "
        "another range of positions, or a longer budget"
    )


def _singular(
    robot: Robot, model: str, lengths: Sequence[float], best: Found
) -> IdentificationError:
    binding = binding_text(tuple(u for u in best.uses if u.share >= 0.9)) or "no limit binds"
    total = " + ".join(f"{x:g}" for x in lengths)
    return IdentificationError(
        f"{robot.name}: no motion of {total} s that was tried determines the parameters of the "
        f"model of {model} (condition number {best.condition:.3g}; {binding}); accepted: a longer "
        "duration, more runs or terms, or wider limits"
    )
