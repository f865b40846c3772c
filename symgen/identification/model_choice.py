"""A run with the equations of the model that was chosen for it, ready to be judged.

There are three ways to the same parameters: energy, momentum and torque from the same filtered
logs. What chooses between them is the error in torque, in the comparison band, on folds of the
training logs that a fit did not see. Where two of them give parameters that differ by more than
chance, the model of the robot misses something.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from symgen.data.signals import Samples
from symgen.errors import IdentificationError, LogError
from symgen.estimation.band import Band
from symgen.estimation.cutoff import choose_band
from symgen.estimation.equation_model import Recipe
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered import FilteredLog, filtered
from symgen.estimation.logs import Source
from symgen.estimation.masking import require_left
from symgen.estimation.solve import Solution
from symgen.estimation.statistics import student_quantile
from symgen.estimation.summary import (
    BLOCKS,
    Blocks,
    block_errors,
    deviation_of_difference,
    held_out_error,
    placed,
    summary,
)
from symgen.estimation.system import Equations, LinearSystem, torque_equations
from symgen.estimation.torque_error import TorqueFit, fit
from symgen.faults.fault import Fault, undone
from symgen.faults.logs import in_one_band
from symgen.faults.model import channel_faults
from symgen.faults.samples import at_standstill
from symgen.identification.estimate import Alternative, Apart
from symgen.identification.instruments import instrumented
from symgen.identification.solving import Method, Part, settled
from symgen.runtime.evaluator import Evaluator

_SHIFTS = 3  # of torques that are late
#: Difference in standard deviations from which two estimates of one parameter disagree, for one
#: comparison; more for more of them, so that as few are chance (Bonferroni).
APART = 3.0
#: Speeds closer than this to a linear relation are proportional.
PROPORTIONAL = 0.03
#: Condition number from which a motion with proportional speeds is refused.
PROPORTIONAL_CONDITION = 10.0


@dataclass(frozen=True, eq=False)
class Run:
    """What was looked at: the model, the band, and the logs in it."""

    evaluator: Evaluator
    band: Band
    train: tuple[FilteredLog, ...]
    held: tuple[FilteredLog, ...]
    repairs: tuple[Fault, ...]
    given: bool

    @property
    def logs(self) -> tuple[FilteredLog, ...]:
        """All logs."""
        return (*self.train, *self.held)


def looked_at(
    evaluator: Evaluator,
    train: Sequence[Samples],
    held: Sequence[Samples],
    repairs: Sequence[Fault],
    given: bool,
    cutoff: float | None,
    progress: Callable[[str], None],
    *,
    own_speeds: bool = False,
    threads: int = 1,
) -> Run:
    """Mend speeds, choose the band, and filter the logs in it.

    Args:
        evaluator: the compiled model.
        train, held: the logs.
        repairs: what was mended in them before.
        given: whether validation logs were given.
        cutoff: of the filter, Hz, where the user gives it.
        progress: is told what is being done.
        own_speeds: whether measured speeds are kept in any case.
        threads: that look for the band at once.
    """
    progress("choosing the band")
    train, held, more = in_one_band(train, held)
    band = choose_band(evaluator, train, cutoff, own_speeds=own_speeds, threads=threads)
    progress(f"band: {band.in_words()}")
    return Run(
        evaluator,
        band,
        tuple(filtered(s, band) for s in train),
        tuple(filtered(s, band) for s in held),
        (*repairs, *more),
        given,
    )


def checked_run(run: Run) -> tuple[Run, tuple[str, ...], float]:
    """Look at the torques by the model; shift them where they are late, say what is left.

    Returns:
        The run, the faults that are left in words, and by how much torques were shifted, s.
    """
    if run.evaluator.model.robot.loaded:
        return run, (), 0.0
    shift = 0.0
    for _ in range(_SHIFTS):
        faults = channel_faults(run.evaluator, run.train, run.held)
        late = next((f for f in faults if f.kind == "delay"), None)
        if late is None:
            break
        shift += late.value
        told = replace(late, samples=sum(len(s.t) for s in run.logs), done="shifted", undo=None)
        train, held = (
            tuple(undone(log, [late])[0] for log in group) for group in (run.train, run.held)
        )
        run = replace(run, train=train, held=held, repairs=(*run.repairs, told))
    return run, tuple(_in_words(f) for f in faults if f.kind != "delay"), shift


def _in_words(fault: Fault) -> str:
    """Say a fault, and where physics of the joint may be taken for it that it may be that."""
    rivals = "; or an effect that the model lacks: symgen diagnose"
    return f"{fault.fault}{rivals if fault.kind in ('gain', 'ratio') else ''}"


Equated = list[tuple[Equations, ...]]


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model with its equations, solved by weighted least squares.

    Attributes:
        recipe: of the equations.
        equations: of the training logs, log by log.
        blocks: products of these.
        held_out: error in torque on folds that were left out of the fit.
        solution: by weighted least squares; the error where the equations determine none.
        torques: of the training and the validation logs; empty without a solution.
    """

    recipe: Recipe
    equations: Equated
    blocks: Blocks
    held_out: float
    solution: Solution | Exception
    torques: tuple[TorqueFit, ...] = ()


@dataclass(frozen=True, eq=False)
class Case:
    """A run with the model that was chosen for it.

    Attributes:
        run: what was looked at.
        recipe: of the chosen model.
        train, held: the logs with its equations.
        found: the models that were fitted, the chosen one first.
        fault: of the motion, in words, or "".
        chosen: the model as it was fitted to choose it; None where there was no choice.
    """

    run: Run
    recipe: Recipe
    train: list[Part]
    held: list[Part]
    found: tuple[Alternative, ...]
    fault: str
    chosen: Fitted | None = None

    @property
    def system(self) -> LinearSystem:
        """The equations of the training logs."""
        return _system(self.run.evaluator, [p.equations for p in self.train])


def chosen_case(
    run: Run,
    recipes: Sequence[Recipe],
    method: Method,
    shares: Sequence[float],
    motions: Sequence[Source],
    progress: Callable[[str], None],
) -> Case:
    """Fit the models and take the one that predicts best.

    Args:
        run: what was looked at.
        recipes: of the equations of each model.
        method: that solves them then.
        shares: weights of the squared residuals of each training log.
        motions: the commanded motion of each training log, or none.
        progress: is told what is being done.

    Raises:
        IdentificationError: no model's equations fit these logs; the reason of the first.
        LogError: a mask leaves too little, or a validation log is too short.
    """
    evaluator = run.evaluator
    found: tuple[Alternative, ...] = ()
    still = standing(run.train)
    fault = motion_fault(run.train, still)
    joints = evaluator.model.robot.movable
    if any(joints[j].friction or joints[j].rotor_inertia for j in still):
        raise IdentificationError(f"these data do not determine the parameters: {fault}")
    best = None
    if evaluator.model.robot.loaded:
        progress("settling the effects that hold the model's torque")
        recipe = settled(evaluator, run.train, recipes[0])
        equations = _equations(run, recipe, shares)
    else:
        progress(f"fitting {', '.join(r.model for r in recipes)}")
        with determined(fault):
            best, found = _alternatives(run, recipes, shares)
        recipe, equations = best.recipe, best.equations
    train = [
        Part("train", log, own, recipe.model) for log, own in zip(run.train, equations, strict=True)
    ]
    train = [
        instrumented(evaluator, part, recipe, motions[k] if motions else None)
        if method.name == "iv" or method.is_tested(part.log)
        else part
        for k, part in enumerate(train)
    ]
    held = [_held(run, log, recipe) for log in run.held]
    return Case(run, recipe, train, held, found, fault, best)


def _system(evaluator: Evaluator, logs: Sequence[tuple[Equations, ...]]) -> LinearSystem:
    return LinearSystem(evaluator.model.base.names, tuple(e for log in logs for e in log))


def _equations(
    run: Run, recipe: Recipe, shares: Sequence[float], known: Equated | None = None
) -> Equated:
    """Return the equations of the training logs, weighed as it was asked for.

    Args:
        run: the logs.
        recipe: of the equations.
        shares: weights of the squared residuals of each log.
        known: the equations without a weight, where they were built before.
    """
    out = []
    own = known or [recipe.equations(run.evaluator, log) for log in run.train]
    for log, equations, weight in zip(run.train, own, shares, strict=True):
        require_left(log, equations)
        out.append(tuple(replace(e, weight=weight) for e in equations))
    return out


def _held(run: Run, log: FilteredLog, recipe: Recipe) -> Part:
    """Return a validation log with its equations."""
    try:
        equations = recipe.equations(run.evaluator, log)
    except IdentificationError as error:
        what = "; accepted: a longer log, or a second one for validation"
        raise LogError(f"{error}{what}") from error
    require_left(log, equations)
    return Part("validation", log, equations, recipe.model)


def _alternatives(
    run: Run, recipes: Sequence[Recipe], shares: Sequence[float]
) -> tuple[Fitted, tuple[Alternative, ...]]:
    """Fit every model and compare them; validation logs report, and do not choose.

    Returns:
        The model that predicts best, and what is told of all, that one first.
    """
    compared = [torque_equations(run.evaluator, log) for log in run.train]
    weighed = [
        tuple(replace(e, weight=w) for e in log) for log, w in zip(compared, shares, strict=True)
    ]
    torques = summary(placed(weighed), len(compared[0]))
    fitted, lost = list[Fitted](), dict[str, IdentificationError]()
    for recipe in recipes:
        try:
            known = compared if recipe.model == "torque" else None
            equations = _equations(run, recipe, shares, known)
        except IdentificationError as error:
            lost[recipe.model] = error
            continue
        blocks = summary(placed(equations, recipe.gap), len(equations[0]))
        left = held_out_error(block_errors(blocks, torques))
        fitted.append(Fitted(recipe, equations, blocks, left, *_solved(run, equations)))
    if not fitted:
        raise next(iter(lost.values()))
    best = min(fitted, key=lambda f: f.held_out)
    found = [_told(f, best, run.evaluator.model.base.names) for f in fitted]
    found.sort(key=lambda a: (not a.chosen, a.held_out))
    found += [
        Alternative(model, math.inf, None, None, math.inf, False, str(error))
        for model, error in lost.items()
    ]
    return best, tuple(found)


def _solved(run: Run, equations: Equated) -> tuple[Solution | Exception, tuple[TorqueFit, ...]]:
    """Solve by weighted least squares, and compare torques on all logs."""
    try:
        solution = Wls().solve(_system(run.evaluator, equations))
    except (IdentificationError, np.linalg.LinAlgError) as lost:
        return lost, ()
    return solution, (
        fit(run.evaluator, run.train, solution.X, "train"),
        fit(run.evaluator, run.held, solution.X),
    )


def _told(own: Fitted, best: Fitted, names: Sequence[str]) -> Alternative:
    """Return what is told of a model beside the best one."""
    reason = f"{100 * own.held_out:.3g} % torque error on folds left out"
    if own is not best:
        reason += f", {own.held_out / max(best.held_out, 1e-300):.3g} times the best"
    if isinstance(own.solution, Exception):
        singular = isinstance(own.solution, np.linalg.LinAlgError)
        reason += "; singular" if singular else f"; {own.solution}"
        model, left = own.recipe.model, own.held_out
        return Alternative(model, math.inf, None, None, left, own is best, reason)
    return Alternative(
        own.recipe.model,
        own.solution.condition_number,
        own.torques[0].residual,
        own.torques[1].residual,
        own.held_out,
        own is best,
        reason,
        () if own is best else _apart(own.blocks, best.blocks, names),
    )


def _apart(a: Blocks, b: Blocks, names: Sequence[str]) -> tuple[Apart, ...]:
    """Return the parameters that two models see apart, with how far, in std of the difference."""
    filled = [k for k in range(BLOCKS) if a.rows[k].any() and b.rows[k].any()]
    if len(filled) < BLOCKS // 2:
        return ()
    std = deviation_of_difference(a, b, filled)
    # the level of 3 std for one comparison, shared by all of them, under Student's law
    tail = (1 - NormalDist().cdf(APART)) / max(len(names), 1)
    level = student_quantile(tail, len(filled) - 1)
    ratio = np.abs(a.fit() - b.fit()) / np.where(std > 0, std, np.inf)
    return tuple(Apart(name, float(r)) for name, r in zip(names, ratio, strict=True) if r > level)


@contextmanager
def determined(fault: str) -> Iterator[None]:
    """Say why data do not determine parameters, where the motion is why.

    Raises:
        IdentificationError: they do not.
    """
    try:
        yield
    except IdentificationError as error:
        raise IdentificationError(f"{error}; {fault}" if fault else str(error)) from error
    except np.linalg.LinAlgError as error:
        raise IdentificationError(
            "the information matrix is singular: these data do not determine the parameters"
            + (f"; {fault}" if fault else "")
        ) from error


def require_condition(solution: Solution, fault: str) -> None:
    """Raise IdentificationError where the motion has a fault and the solution suffers from it."""
    if fault and solution.condition_number > PROPORTIONAL_CONDITION:
        raise IdentificationError(
            f"these data do not determine the parameters: {fault} (condition number "
            f"{solution.condition_number:.3g})"
        )


def standing(logs: Sequence[FilteredLog]) -> list[int]:
    """Return the joints that stand still in all logs: what they seem to move is noise."""
    n = logs[0].q.shape[1]
    still = np.ones(n, dtype=bool)
    for log in logs:
        same = np.ptp(log.samples.q, axis=0) == 0
        if log.band.filters(log.step):
            same |= at_standstill(log.samples.q, log.q, log.step, log.band.cutoff_hz)
        still &= same
    return [int(j) for j in np.flatnonzero(still)]


def motion_fault(logs: Sequence[FilteredLog], still: Sequence[int]) -> str:
    """Return in words why a motion cannot excite a model, or ''.

    Gautier and Khalil warn of joint speeds that stay proportional: the arm then moves as one body
    with one degree of freedom, and the information matrix is singular.

    Args:
        logs: in the band of the run.
        still: the joints that stand still in all of them.
    """
    qd = np.concatenate([log.samples.qd for log in logs])
    if still:
        return (
            f"movable joints {', '.join(str(j + 1) for j in still)} do not move: move them too, or "
            "fix them in the robot (sigma = 2; symgen import --fix)"
        )
    if qd.shape[1] < 2:
        return ""
    norms = np.linalg.norm(qd, axis=0)
    cosines = (qd / norms).T @ (qd / norms)
    pairs = [
        (j + 1, k + 1, float(np.sqrt(max(0.0, 1 - cosines[j, k] ** 2))))
        for j in range(qd.shape[1])
        for k in range(j)
    ]
    j, k, apart = min(pairs, key=lambda pair: pair[2])
    if apart < PROPORTIONAL:
        return (
            f"the speeds of movable joints {k} and {j} are proportional to each other throughout "
            f"(to {100 * apart:.2g} %); move the joints independently"
        )
    return ""
