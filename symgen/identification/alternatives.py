"""Three ways to the same parameters: energy, momentum and torque from the same filtered logs.

Each model is fitted with one summary of its equations; what chooses between them is the error in
torque, in the comparison band, on folds of the training logs that a fit did not see. Where two of
them give parameters that differ by more than chance, the model of the robot misses something.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from symgen.errors import IdentificationError
from symgen.estimation.estimators import Wls
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.fit import fit
from symgen.estimation.masking import require_left
from symgen.estimation.recipe import Recipe
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
from symgen.identification.estimate import Alternative, Apart
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
#: Difference in standard deviations from which two estimates of one parameter disagree, for one
#: comparison; more for more of them, so that as few are chance (Bonferroni).
APART = 3.0


@dataclass(frozen=True, eq=False)
class _Fitted:
    recipe: Recipe
    equations: list[tuple[Equations, ...]]
    blocks: Blocks
    held_out: float


def alternatives(
    evaluator: Evaluator,
    train: Sequence[FilteredLog],
    held: Sequence[FilteredLog],
    recipes: Sequence[Recipe],
    weights: Sequence[float],
) -> tuple[tuple[Alternative, ...], dict[str, list[tuple[Equations, ...]]]]:
    """Fit every model and compare them.

    Args:
        evaluator: the compiled model, with the kernels of all recipes.
        train: the training logs in the band of the run.
        held: the validation logs: they report, and do not choose.
        recipes: of the equations of each model.
        weights: of the squared residuals of each training log.

    Returns:
        The alternatives, the chosen one first, and the equations of each model, log by log.

    Raises:
        IdentificationError: no model's equations fit these logs; the reason of the first.
    """
    compared = [torque_equations(evaluator, log) for log in train]
    torques = _summary(compared, 0.0, weights)
    fitted, lost = [], {}
    for recipe in recipes:
        try:
            equations = compared
            if recipe.model != "torque":
                equations = [recipe.equations(evaluator, log) for log in train]
            for log, own in zip(train, equations, strict=True):
                if log.mask is not None:
                    require_left(log.name, own)
            blocks = _summary(equations, recipe.gap, weights)
        except IdentificationError as error:
            lost[recipe.model] = error
            continue
        left = held_out_error(block_errors(blocks, torques))
        fitted.append(_Fitted(recipe, equations, blocks, left))
    if not fitted:
        raise next(iter(lost.values()))
    best = min(fitted, key=lambda f: f.held_out)
    found = [_alternative(evaluator, f, best, train, held) for f in fitted]
    found.sort(key=lambda a: (not a.chosen, a.held_out))
    found += [
        Alternative(model, math.inf, None, None, math.inf, False, str(error))
        for model, error in lost.items()
    ]
    return tuple(found), {f.recipe.model: f.equations for f in fitted}


def _summary(
    equations: Sequence[tuple[Equations, ...]], reach: float, weights: Sequence[float]
) -> Blocks:
    m = len(equations[0])
    weighed = [
        tuple(replace(e, weight=w) for e in log) for log, w in zip(equations, weights, strict=True)
    ]
    return summary(placed(weighed, reach), m)


def _alternative(
    evaluator: Evaluator,
    own: _Fitted,
    best: _Fitted,
    train: Sequence[FilteredLog],
    held: Sequence[FilteredLog],
) -> Alternative:
    names = evaluator.model.base.names
    linear = names[: own.blocks.grams.shape[-1] - 1]
    error = f"{100 * own.held_out:.3g} % torque error on folds left out"
    if own is best:
        reason = error
    else:
        reason = f"{error}, {own.held_out / max(best.held_out, 1e-300):.3g} times the best"
    try:
        system = LinearSystem(linear, tuple(e for log in own.equations for e in log))
        solution = Wls().solve(system)
    except (IdentificationError, np.linalg.LinAlgError) as lost:
        why = str(lost) if isinstance(lost, IdentificationError) else "singular"
        return Alternative(
            own.recipe.model, math.inf, None, None, own.held_out, own is best, f"{reason}; {why}"
        )
    X = np.pad(solution.X, (0, len(names) - len(linear)))
    apart = () if own is best else _apart(own.blocks, best.blocks, linear)
    return Alternative(
        own.recipe.model,
        solution.condition_number,
        fit(evaluator, train, X, "train").residual,
        fit(evaluator, held, X).residual,
        own.held_out,
        own is best,
        reason,
        apart,
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


def disagreement(found: Sequence[Alternative]) -> tuple[str, ...]:
    """Say which models see parameters apart; one model alone has nothing to disagree with."""
    if not found:
        return ()
    chosen = next(a.model for a in found if a.chosen)
    out = []
    for a in found:
        if a.apart:
            listed = ", ".join(
                f"{n} ({r:.2g} std)" for n, r in sorted(a.apart, key=lambda x: -x[1])[:5]
            )
            more = f" and {len(a.apart) - 5} more" if len(a.apart) > 5 else ""
            out.append(
                f"the {a.model} model sees {listed}{more} apart from the {chosen} model: the robot "
                "does something that its model does not"
            )
    return tuple(out)
