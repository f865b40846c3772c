"""excite: motions that determine a robot's parameters, within the limits of its user.

The method is Gautier and Khalil's (1992) and Swevers' (1997): the coefficients of a trajectory are
those that make the base regressor best conditioned. Here the regressor is that of the model that
will be used, built from the same windows: a motion may be good for torques and singular for energy.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from symgen.errors import IdentificationError, ParameterError
from symgen.estimation.recipe import require_model
from symgen.experiment.bounds import Bounds, bounds
from symgen.experiment.cell import KINDS
from symgen.experiment.criterion import CRITERIA, FloatArray
from symgen.experiment.judge import MODELS, SHRUNK, Found, Judge, judge
from symgen.experiment.objective import Objective, smooth_robot
from symgen.experiment.plan import Plan, binding_text
from symgen.experiment.search import Clock, Program
from symgen.experiment.space import space
from symgen.experiment.trajectory import SMOOTH, basis
from symgen.identification.verdict import WINDOWS
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Robot, require_gravity

#: Condition number above which runs determine nothing: refused.
SINGULAR = 1e5
_DRAWS = 8  # random motions of which each search begins with the best
_HELD_OUT = 0.2
_LONGEST = 600.0  # s, of a run
_USUAL = 10.0  # s, the shortest run that is chosen without being asked for


def excite(
    robot: Robot | str | Path,
    *,
    model: str = "energy",
    position: Sequence[tuple[float, float]] | None = None,
    velocity: Sequence[float] | None = None,
    acceleration: Sequence[float] | None = None,
    jerk: Sequence[float] | None = None,
    torque: Sequence[float] | None = None,
    parameters: str | Path | None = None,
    start: Sequence[float] | None = None,
    duration: float | Sequence[float] | None = None,
    runs: int = 1,
    kind: str | Sequence[str] = "fourier",
    terms: int | None = None,
    window: float = 0.2,
    criterion: str = "condition",
    rate: float = 200.0,
    budget: float = 60.0,
    searches: int = 4,
    iterations: int = 500,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> Plan:
    """Find runs within limits from which the parameters of a robot can be identified.

    Args:
        robot: a robot, a path or a library name.
        model: that will be used to identify: "energy", "momentum" or "torque".
        position: lowest and highest q of each movable joint, rad or m. This and the next limits
            are taken from the robot's [limits] where they are None.
        velocity: largest speeds, rad/s or m/s.
        acceleration: largest accelerations, rad/s2 or m/s2.
        jerk: largest jerks, rad/s3 or m/s3.
        torque: largest torques by the prior model, N m or N.
        parameters: of the prior model: estimate.json, or TOML with [parameters].
        start: where every run begins, (n,), rad or m; None for anywhere.
        duration: of each run, s; by default 10 s, or what identify trusts in all.
        runs: how many, each with coefficients of its own.
        kind: "fourier", "bspline", or the paper's "cubic" and "cosine"; one for all joints or one
            for each.
        terms: harmonics, coefficients (bspline) or strokes (cubic) of a joint; by default from the
            duration.
        window: length of the windows of energy and momentum, s.
        criterion: "condition" number, or "logdet" of the information matrix.
        rate: of the sampled references, Hz.
        budget: of time, s: the search stops then with the best that it has.
        searches: how many random starts are improved.
        iterations: of IPOPT for each, at most.
        seed: of the random starts. The same seed gives the same runs where the budget lasts.
        progress: is told what is being done.

    Returns:
        The runs, which keep every limit every millisecond, with the condition numbers that they
        give in identify's own equations for all three models.

    Raises:
        ParameterError: an argument has no meaning.
        IdentificationError: no motion within the limits determines the parameters, or keeps the
            torques; the message names the limits that bind.
    """
    clock = Clock(budget)
    _require_settings(model, criterion, window, rate, budget, searches, iterations, runs)
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    require_gravity(source, "an excitation")
    require_model(source, model)
    limits = bounds(source, position, velocity, acceleration, jerk, torque)
    kinds = _kinds(kind, source.n, limits)
    progress("deriving and compiling the model")
    task = judge(source, model, window, rate, limits, parameters, torque is not None)
    lengths = _durations(duration, runs, task)
    bases = tuple(tuple(basis(k, length, terms) for k in kinds) for length in lengths)
    choices = space(bases, limits, _start(start, limits, source.n))
    objective = Objective(smooth_robot(source, limits), choices, model, window, task.model)
    program = Program(objective, limits, task.prior, clock, iterations)
    best: Found | None = None
    ended, closest = 0, None
    with clock.listening():
        for k in range(searches):
            if k and clock.left <= 0:
                break
            draw = np.random.default_rng([seed, k])
            drawn = [choices.drawn(draw, limits) for _ in range(_DRAWS if clock.left > 0 else 1)]
            first = min(drawn, key=lambda z: objective(z, criterion)[0])
            before = task.judged(choices, first)
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: begins at {before.text}")
            z = first if clock.left <= 0 else program.solve(first, criterion)
            after = task.judged(choices, z)
            ended += clock.left > 0
            for found in (before, after):
                if not found.keeps and (closest is None or found.excess < closest.excess):
                    closest = found
                better = best is None or _value(found, criterion) < _value(best, criterion)
                if found.keeps and better:
                    best = found.beginning(before)
            shown = "none keeps its limits" if best is None else f"best {best.text}"
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: reaches {after.text}; {shown}")
    if best is None:
        raise _too_much_torque(source.name, closest)
    if not best.condition <= SINGULAR:
        raise _singular(source, model, lengths, best)
    stopped = "interrupted" if clock.interrupted else "done" if ended == searches else "budget"
    return task.plan(best, (ended, searches), stopped)


def _value(found: Found, criterion: str) -> float:
    return found.condition if criterion == "condition" else -found.log_det


def _require_settings(
    model: str,
    criterion: str,
    window: float,
    rate: float,
    budget: float,
    searches: int,
    iterations: int,
    runs: int,
) -> None:
    if model not in MODELS:
        raise ParameterError(f"model {model!r}; accepted: {', '.join(MODELS)}")
    if criterion not in CRITERIA:
        raise ParameterError(f"criterion {criterion!r}; accepted: {', '.join(CRITERIA)}")
    for what, value in (("window", window), ("rate", rate), ("budget", budget)):
        if not (math.isfinite(value) and value > 0):
            raise ParameterError(f"{what} {value:g}; accepted: a number above 0")
    for what, count in (("searches", searches), ("iterations", iterations), ("runs", runs)):
        if not 1 <= count <= 10_000:
            raise ParameterError(f"{what} {count}; accepted: 1 to 10000")


def _kinds(kind: str | Sequence[str], n: int, limits: Bounds) -> tuple[str, ...]:
    kinds = (kind,) * n if isinstance(kind, str) else tuple(kind)
    if len(kinds) != n:
        raise ParameterError(f"{len(kinds)} kinds; accepted: one, or one for each of {n} joints")
    for j, name in enumerate(kinds):
        if name not in SMOOTH and np.isfinite(limits.rates[2, j]):
            raise ParameterError(
                f"joint {j + 1}: accelerations of kind {name} jump, and its jerk is limited; "
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
    """Return the length of each run in s: given, or what identify trusts from the energy model."""
    if duration is None:
        parameters = len(task.model.base.parameters)
        per_window = 1 if task.name == "energy" else task.model.robot.n
        needed = WINDOWS * parameters * task.window / per_window / (1 - _HELD_OUT)
        usual = _USUAL if task.name == "torque" else max(_USUAL, needed / runs + task.window)
        return (float(math.ceil(usual)),) * runs
    given = [duration] if isinstance(duration, (int, float)) else list(duration)
    lengths = tuple(map(float, given * runs if len(given) == 1 else given))
    if len(lengths) != runs:
        raise ParameterError(f"{len(lengths)} durations; accepted: one, or one for each run")
    least = task.window if task.name != "torque" else 0.0
    for length in lengths:
        if not (math.isfinite(length) and least + 10 / task.rate < length <= _LONGEST):
            raise ParameterError(
                f"a run of {length:g} s; accepted: more than {least + 10 / task.rate:.4g} s (the "
                f"window and ten samples), at most {_LONGEST:g} s"
            )
    return lengths


def _too_much_torque(name: str, closest: Found | None) -> IdentificationError:
    assert closest is not None
    use = max((u for u in closest.uses if u.limit in SHRUNK), key=lambda u: u.share)
    if use.limit in KINDS:
        return IdentificationError(
            f"{name}: no motion that was tried keeps clear of the {use.limit}: the frame of joint "
            f"{use.joint} comes {-use.extreme:.3g} m too far; accepted: a range of positions whose "
            "middle is clear of floor and boxes, smaller ranges, or another cell in [limits]"
        )
    return IdentificationError(
        f"{name}: no motion that was tried keeps the torque of joint {use.joint}: it needs "
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
