"""From a system of equations to a solution, by the method that was asked for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from symgen.data.signals import Samples
from symgen.errors import IdentificationError
from symgen.estimation.equation_model import Recipe, require_model
from symgen.estimation.estimators import (
    ESTIMATORS,
    METHODS,
    NOISE_BIAS,
    Estimator,
    InstrumentalVariables,
    Prior,
    TotalLeastSquares,
    Wls,
    bias_of_least_squares,
)
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.logs import Source
from symgen.estimation.solve import Solution, column_norms, undetermined, weighed
from symgen.estimation.summary import triangle
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.torque_error import relative_error
from symgen.estimation.values import Convergence, FloatArray, Residual
from symgen.identification.physical import Consistent
from symgen.runtime.evaluator import Evaluator

#: Methods for which logs can be given weights.
WEIGHED = ("wls", "ols")


@dataclass(frozen=True)
class Fit:
    """How equations are solved.

    Attributes:
        prior: estimate.json, TOML with [parameters], or the .urdf that the robot was imported from:
            pulls methods wls and consistent towards its values (see `read_prior`).
        weights: one a log, of its squared residuals; None: all alike. For wls and ols.
        commanded: the commanded motion of each log, in their order, for the instruments of method
            iv; by default they come from the encoders, where speeds were measured too.
        forgetting: weight of the past for each new sample, of method recursive, in (0, 1]: some
            1 / (1 - forgetting) samples are remembered, whatever the model and the window.
    """

    prior: str | Path | None = None
    weights: Sequence[float] | None = None
    commanded: Sequence[Source] | Source = ()
    forgetting: float = 1.0

    def shares(self, logs: int, method: str) -> Sequence[float]:
        """Return one weight a log.

        Raises:
            IdentificationError: the method weighs no logs, or these are no weights of them.
        """
        weights = self.weights
        if weights is None:
            return [1.0] * logs
        if method not in WEIGHED:
            raise IdentificationError(
                f"weights with method {method}; accepted: {', '.join(WEIGHED)}"
            )
        if len(weights) != logs or not all(0 < w < math.inf for w in weights):
            shown = ", ".join(f"{w:g}" for w in weights)
            raise IdentificationError(
                f"weights {shown}; accepted: a number above 0 for each of {logs} logs"
            )
        return weights


ALL_METHODS = (*METHODS, Consistent.name, "recursive")
#: Methods that need no more of the logs than sums over their parts.
FOLDED = (Wls.name, "ols")
_WITH_PRIOR = (Wls.name, Consistent.name)
#: Methods that account for noise in the regressor.
_UNBIASED = (InstrumentalVariables.name, TotalLeastSquares.name)
_CHECKPOINTS = 80
_WINDOWS, _FEWEST, _MOVED = (0.5, 2.0, 4.0), 20, 3.0  # that are scanned
_ROUNDS, _SETTLED = 30, 1e-3  # of the standard deviation


@dataclass(frozen=True, eq=False)
class Part:
    """One log in the band of the run, for one purpose: "train" or "validation"."""

    kind: str
    log: FilteredLog
    equations: tuple[Equations, ...]
    quantity: str = "energy"

    @property
    def samples(self) -> Samples:
        """The log as it was sampled."""
        return self.log.samples


def residual(parts: Sequence[Part], X: FloatArray) -> Residual:
    """Return ||y - W X|| / ||y|| of some equations, in all and by joint."""
    equations = [e for p in parts for e in p.equations]
    joints = 1 + max(e.joint or 0 for e in equations)
    sums = np.zeros((2, joints))
    for e in equations:
        sums[:, e.joint or 0] += np.sum((e.y - e.W @ X) ** 2), np.sum(e.y**2)
    return relative_error(sums[0], sums[1], equations[0].joint is not None)


@dataclass(frozen=True, eq=False)
class Method:
    """The name of a method, and what it is given.

    Attributes:
        name: one of ALL_METHODS.
        forgetting: of method recursive, in (0, 1].
        prior: of methods wls and consistent.
        given: the estimator itself, where the user made one.
    """

    name: str
    forgetting: float = 1.0
    prior: Prior | None = None
    given: Estimator | None = None

    @classmethod
    def of(cls, method: str | Estimator, forgetting: float = 1.0) -> Method:
        """Return the method of a name, or of an estimator with settings of its own."""
        if isinstance(method, str):
            return cls(method, forgetting)
        prior = getattr(method, "prior", method if isinstance(method, Prior) else None)
        return cls("wls" if prior else method.name, forgetting, prior, method)

    def __post_init__(self) -> None:
        if self.name not in ALL_METHODS:
            raise IdentificationError(f"method {self.name!r}; accepted: {', '.join(ALL_METHODS)}")
        if not (math.isfinite(self.forgetting) and 0 < self.forgetting <= 1):
            raise IdentificationError(
                f"forgetting {self.forgetting:g}; accepted: above 0 and at most 1"
            )
        if self.forgetting < 1 and self.name != "recursive":
            raise IdentificationError(
                f"method {self.name} does not forget; accepted: method recursive with forgetting"
            )
        if self.prior is not None and self.name not in _WITH_PRIOR:
            raise IdentificationError(
                f"method {self.name} takes no prior; accepted: {', '.join(_WITH_PRIOR)}"
            )

    @property
    def plain(self) -> bool:
        """Whether it is least squares, which folds of chunks solve."""
        return self.name in FOLDED and self.prior is None and self.given is None

    @property
    def is_wls(self) -> bool:
        """Whether it is the least squares that models are chosen by."""
        return self.name == Wls.name and self.plain

    @property
    def label(self) -> str:
        """What an estimate calls it."""
        return self.name + (" with prior" if self.prior is not None else "")

    @property
    def excludes(self) -> str:
        """What its standard deviations leave out."""
        if self.name == "recursive":
            return NOISE_BIAS
        if self.name == Consistent.name:
            return Consistent.excludes
        return (self.prior or ESTIMATORS[self.name]).excludes

    def is_tested(self, log: FilteredLog) -> bool:
        """Whether a log can tell that least squares is biased: speeds of their own sensors."""
        return self.name not in _UNBIASED and log.band.velocity == "measured"

    def estimator(self, evaluator: Evaluator) -> Estimator:
        """Return the estimator of a robot."""
        if self.given is not None:
            return self.given
        plain = self.prior or Wls()
        if self.name == Consistent.name:
            return Consistent(evaluator.model, plain)
        return plain if self.name == Wls.name else ESTIMATORS[self.name]


def solved(
    evaluator: Evaluator,
    system: LinearSystem,
    train: Sequence[Part],
    method: Method,
    recipe: Recipe,
) -> tuple[Solution, str]:
    """Solve the equations of the training logs; and say what bias the intervals do not hold.

    Raises:
        IdentificationError: they do not determine the parameters, or the method cannot be used.
    """
    if method.name == "recursive":
        if recipe.model == "torque":
            raise IdentificationError("method recursive works on the models of energy and momentum")
        solution = weighed(system, _memory(train, method.forgetting))
    else:
        solution = method.estimator(evaluator).solve(system)
    if method.name in _UNBIASED:
        return solution, ""
    return bias_of_least_squares(system, solution)


def settled(evaluator: Evaluator, logs: Sequence[FilteredLog], recipe: Recipe) -> Recipe:
    """Return the recipe whose effects of the load take the torque of the X that it leads to.

    Their columns hold the model's own torque: they are taken at the X of the round before, weighted
    least squares first without and then with them, until X stays.

    Args:
        evaluator: the compiled model.
        logs: the training logs in the band of the run.
        recipe: of the torque model.

    Raises:
        IdentificationError: another model, whose equations have no accelerations, or X does not
            settle.
    """
    require_model(evaluator.model.robot, recipe.model)
    base = evaluator.model.base
    for _ in range(_ROUNDS):
        names = base.names if recipe.at is not None else base.names[: base.linear]
        rows = tuple(e for log in logs for e in recipe.equations(evaluator, log))
        solution = ESTIMATORS[Wls.name].solve(LinearSystem(names, rows))
        X = np.pad(solution.X, (0, len(base.names) - len(names)))
        moved = np.inf if recipe.at is None else np.abs(X - np.array(recipe.at))
        recipe = replace(recipe, at=tuple(map(float, X)))
        if len(names) == len(X) and np.all(moved <= _SETTLED * solution.std + 1e-12 * np.abs(X)):
            return recipe
    raise IdentificationError(
        "effects of the load do not settle: their share of the torque is too large"
    )


def _memory(train: Sequence[Part], forgetting: float) -> list[FloatArray]:
    """Return the weight of every row in a recursion that forgets, (K,) a log and joint.

    Its squared residual weighs forgetting^k, with k the samples from the end of its window to the
    last end of all: whatever the window, its overlap and the joints, 1 / (1 - forgetting) samples
    are remembered. Time of which a mask leaves no equation is not counted.
    """
    out: list[FloatArray] = []
    later = 0.0  # samples after this log
    for part in reversed(train):
        ends = np.unique(np.concatenate([e.t for e in part.equations]))
        hop = float(np.diff(ends).min(initial=part.log.t[-1] - part.log.t[0])) / part.samples.step
        ages = [later + hop * (len(ends) - 1 - np.searchsorted(ends, e.t)) for e in part.equations]
        out = [*(forgetting ** (age / 2) for age in ages), *out]
        later += hop * len(ends)
    return out


def convergence(train: Sequence[Part], names: tuple[str, ...]) -> Convergence:
    """Return the least-squares estimate after every chunk of the data: factors merged in time.

    The equations of all joints of a log are taken together by their times.
    """
    p = len(names)
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
            if len(factor) >= p and not undetermined(R / column_norms(R), names):
                times.append(before + float(t[piece][-1] - t[0]))
                values.append(np.linalg.solve(R, factor[:p, p]))
        before += float(t[-1] - t[0])
    return Convergence(np.array(times), np.array(values).reshape(len(times), p))


def moved_by_window(
    evaluator: Evaluator,
    train: Sequence[Part],
    method: Method,
    recipe: Recipe,
    X: FloatArray,
    std: FloatArray,
) -> str:
    """Return in words the parameters that other windows move by more than three std.

    Half the window, twice and four times are tried, as far as the logs hold twenty of them.
    """
    known = method.name in ("wls", "ols", "recursive") and method.forgetting == 1
    if recipe.model == "torque" or not known:
        return ""
    names = evaluator.model.base.names
    estimator = (
        (method.prior or Wls()) if method.name == "recursive" else method.estimator(evaluator)
    )
    worst: dict[str, tuple[float, float]] = {}
    for factor in _WINDOWS:
        other = replace(recipe, window=recipe.window * factor)
        fits = [p.samples.step <= other.window <= np.ptp(p.samples.t) / _FEWEST for p in train]
        if not all(fits):
            continue
        equations = (
            replace(e, weight=p.equations[0].weight)
            for p in train
            for e in other.equations(evaluator, p.log)
        )
        try:
            found = estimator.solve(LinearSystem(names, tuple(equations)))
        except IdentificationError:
            continue
        spread = np.maximum(std, found.std)
        for name, move, size in zip(names, np.abs(found.X - X), spread, strict=True):
            if size > 0 and move > _MOVED * size:
                worst[name] = max(worst.get(name, (0.0, 0.0)), (move / size, other.window))
    listed = sorted(worst.items(), key=lambda entry: -entry[1][0])[:5]
    return ", ".join(f"{name} moves by {r:.1f} std at {w:.3g} s" for name, (r, w) in listed)
