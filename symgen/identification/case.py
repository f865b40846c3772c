"""A run with the equations of the model that was chosen for it, ready to be solved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

import symgen.identification.verdict as verdicts
from symgen.data.signals import Samples
from symgen.errors import IdentificationError, LogError
from symgen.estimation.channel_faults import channel_faults
from symgen.estimation.channels import Fault
from symgen.estimation.cutoff import choose_band
from symgen.estimation.filtered import FilteredLog, filtered
from symgen.estimation.logs import Source, in_one_band
from symgen.estimation.masking import require_left
from symgen.estimation.recipe import Recipe
from symgen.estimation.repairs import Repair
from symgen.estimation.solve import Solution
from symgen.estimation.system import Equations, LinearSystem
from symgen.identification.alternatives import alternatives
from symgen.identification.estimate import Alternative
from symgen.identification.instruments import instrumented
from symgen.identification.judging import Run
from symgen.identification.solving import Method, settled
from symgen.identification.validation import Part
from symgen.runtime.evaluator import Evaluator

_SHIFTS = 3  # of torques that are late


def looked_at(
    evaluator: Evaluator,
    train: Sequence[Samples],
    held: Sequence[Samples],
    repairs: Sequence[Repair],
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
        done = Repair("all logs", "tau", late.says, sum(len(s.t) for s in run.logs), "shifted")
        run = replace(
            run,
            train=tuple(map(late.undone, run.train)),
            held=tuple(map(late.undone, run.held)),
            repairs=(*run.repairs, done),
        )
    return run, tuple(_in_words(f) for f in faults if f.kind != "delay"), shift


def _in_words(fault: Fault) -> str:
    """Say a fault, and where physics of the joint may be taken for it that it may be that."""
    rivals = "; or an effect that the model lacks: symgen diagnose"
    return f"{fault.says}{rivals if fault.kind in ('gain', 'ratio') else ''}"


@dataclass(frozen=True, eq=False)
class Case:
    """A run with the model that was chosen for it.

    Attributes:
        run: what was looked at.
        recipe: of the chosen model.
        train, held: the logs with its equations.
        found: the models that were fitted, the chosen one first.
        fault: of the motion, in words, or "".
    """

    run: Run
    recipe: Recipe
    train: list[Part]
    held: list[Part]
    found: tuple[Alternative, ...]
    fault: str

    @property
    def system(self) -> LinearSystem:
        """The equations of the training logs."""
        names = self.run.evaluator.model.base.names
        return LinearSystem(names, tuple(e for p in self.train for e in p.equations))


def chosen_case(
    run: Run,
    recipes: Sequence[Recipe],
    method: Method,
    shares: Sequence[float],
    motions: Sequence[Source],
    progress: Callable[[str], None],
) -> Case:
    """Fit the models and take the one that predicts best."""
    evaluator = run.evaluator
    found: tuple[Alternative, ...] = ()
    still = verdicts.standing(run.train)
    fault = verdicts.motion_fault(run.train, still)
    joints = evaluator.model.robot.movable
    if any(joints[j].friction or joints[j].rotor_inertia for j in still):
        raise IdentificationError(f"these data do not determine the parameters: {fault}")
    if evaluator.model.robot.loaded:
        progress("settling the effects that hold the model's torque")
        recipe = settled(evaluator, run.train, recipes[0])
        equations = [recipe.equations(evaluator, log) for log in run.train]
    else:
        progress(f"fitting {', '.join(r.model for r in recipes)}")
        try:
            found, fitted = alternatives(evaluator, run.train, run.held, recipes, shares)
        except IdentificationError as error:
            raise IdentificationError(f"{error}; {fault}" if fault else str(error)) from error
        recipe = next(r for r in recipes if r.model == found[0].model)
        equations = fitted[recipe.model]
    train = [
        _part(log, own, recipe, weight)
        for log, own, weight in zip(run.train, equations, shares, strict=True)
    ]
    train = [
        instrumented(evaluator, part, recipe, motions[k] if motions else None)
        if method.name == "iv" or method.is_tested(part.log)
        else part
        for k, part in enumerate(train)
    ]
    held = [_held(run, log, recipe) for log in run.held]
    return Case(run, recipe, train, held, found, fault)


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
    if fault and solution.condition_number > verdicts.PROPORTIONAL_CONDITION:
        raise IdentificationError(
            f"these data do not determine the parameters: {fault} (condition number "
            f"{solution.condition_number:.3g})"
        )


def _part(
    log: FilteredLog, equations: tuple[Equations, ...], recipe: Recipe, weight: float
) -> Part:
    """Return a training log with its equations, weighed as it was asked for."""
    if log.mask is not None:
        require_left(log.name, equations)
    return Part("train", log, tuple(replace(e, weight=weight) for e in equations), recipe.model)


def _held(run: Run, log: FilteredLog, recipe: Recipe) -> Part:
    """Return a validation log with its equations."""
    try:
        equations = recipe.equations(run.evaluator, log)
    except IdentificationError as error:
        what = "; accepted: a longer log, or a second one for validation"
        raise LogError(f"{error}{what}") from error
    if log.mask is not None:
        require_left(log.name, equations)
    return Part("validation", log, equations, recipe.model)
