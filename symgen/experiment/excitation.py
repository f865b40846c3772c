"""excite: motions that determine a robot's parameters, within the limits of its user.

The method is Gautier and Khalil's (1992) and Swevers' (1997): the coefficients of a trajectory are
those that make the base regressor best conditioned. Here the regressor is that of the model that
will be used, built from the same windows: a motion may be good for torques and singular for energy.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symgen.errors import IdentificationError, ParameterError
from symgen.estimation.logs import HELD_OUT
from symgen.estimation.recipe import require_model
from symgen.experiment.bounds import Bounds, bounds
from symgen.experiment.cell import KINDS
from symgen.experiment.criterion import FloatArray
from symgen.experiment.judge import MODELS, SHRUNK, Found, Judge, judge
from symgen.experiment.objective import Objective, smooth_robot
from symgen.experiment.options import Motion, Search, require_positive
from symgen.experiment.plan import Plan, binding_text
from symgen.experiment.search import Clock, Program
from symgen.experiment.space import space
from symgen.experiment.trajectory import SMOOTH, basis
from symgen.identification.assessment import WINDOWS
from symgen.robot.toml_io import read_robot
from symgen.robot.types import Limits, Robot, require_gravity

#: Condition number above which runs determine nothing: refused.
SINGULAR = 1e5
_DRAWS = 8  # random motions of which each search begins with the best
_LONGEST = 600.0  # s, of a run
_USUAL = 10.0  # s, the shortest run that is chosen without being asked for


def excite(
    robot: Robot | str | Path,
    *,
    model: str = "momentum",
    limits: Limits | None = None,
    motion: Motion | None = None,
    search: Search | None = None,
    parameters: str | Path | None = None,
    window: float = 0.2,
    progress: Callable[[str], None] = lambda _: None,
    meter: Callable[[float], None] = lambda _: None,
) -> Plan:
    """Find runs within limits from which the parameters of a robot can be identified.

    Args:
        robot: a robot, a path or a library name.
        model: that will be used to identify: "energy", "momentum" or "torque".
        limits: of the motion; what they leave open is taken from the robot's [limits]. Torques are
            those of the prior model.
        motion: how many runs, how long, of which kind.
        search: criterion, budget, seed.
        parameters: of the prior model: estimate.json, or TOML with [parameters].
        window: length of the windows of energy and momentum, s.
        progress: is told what is being done.
        meter: is told which part is done, from 0 to 1.

    Returns:
        The runs, which keep every limit every millisecond, with the condition numbers that they
        give in identify's own equations for all three models.

    Raises:
        ParameterError: an argument has no meaning.
        IdentificationError: no motion within the limits determines the parameters, or keeps the
            torques; the message names the limits that bind.
    """
    motion, search = motion or Motion(), search or Search()
    clock = Clock(search.budget)
    if model not in MODELS:
        raise ParameterError(f"model {model!r}; accepted: {', '.join(MODELS)}")
    require_positive("window", window)
    source = read_robot(robot) if isinstance(robot, (str, Path)) else robot
    require_gravity(source, "an excitation")
    require_model(source, model)
    given = limits or Limits()
    source = replace(source, limits=given.over(source.limits))
    allowed = bounds(source)
    kinds = _kinds(motion.kind, source.n, allowed)
    progress("deriving and compiling the model")
    task = judge(source, model, window, motion.rate, allowed, parameters, given.torque is not None)
    lengths = _durations(motion.duration, motion.runs, task)
    bases = tuple(tuple(basis(k, length, motion.terms) for k in kinds) for length in lengths)
    choices = space(bases, allowed, _start(motion.start, allowed, source.n))
    objective = Objective(smooth_robot(source, allowed), choices, model, window, task.model)
    program = Program(objective, allowed, task.prior, clock, search.iterations)
    best: Found | None = None
    ended, closest = 0, None
    with clock.listening():
        for k in range(search.searches):
            if k and clock.left <= 0:
                break
            draw = np.random.default_rng([search.seed, k])
            drawn = [choices.drawn(draw, allowed) for _ in range(_DRAWS if clock.left > 0 else 1)]
            first = min(drawn, key=lambda z: objective(z, search.criterion)[0])
            before = task.judged(choices, first)
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: begins at {before.text}")
            z = first if clock.left <= 0 else program.solve(first, search.criterion)
            after = task.judged(choices, z)
            ended += clock.left > 0
            for found in (before, after):
                if not found.keeps and (closest is None or found.excess < closest.excess):
                    closest = found
                better = best is None or _value(found, search) < _value(best, search)
                if found.keeps and better:
                    best = found.beginning(before)
            shown = "none keeps its limits" if best is None else f"best {best.text}"
            meter((k + 1) / search.searches)
            progress(f"{clock.elapsed:5.1f} s  search {k + 1}: reaches {after.text}; {shown}")
    if best is None:
        raise _too_much_torque(source.name, closest)
    if not best.condition <= SINGULAR:
        raise _singular(source, model, lengths, best)
    stopped = (
        "interrupted" if clock.interrupted else "done" if ended == search.searches else "budget"
    )
    return task.plan(best, (ended, search.searches), stopped)


def _value(found: Found, search: Search) -> float:
    return found.condition if search.criterion == "condition" else -found.log_det


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
        needed = WINDOWS * parameters * task.window / per_window / (1 - HELD_OUT)
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
