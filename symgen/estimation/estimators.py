"""Least squares as objects: ordinary, weighted, robust to outliers, and towards a prior.

Every estimator is a frozen value with a name and a method `solve` from a LinearSystem to a
Solution. `excludes` says what its standard deviations leave out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from symgen.errors import IdentificationError
from symgen.estimation.fold import summaries
from symgen.estimation.regression import (
    Solution,
    condition,
    factors,
    inverse_deviation,
    least_squares_solution,
    log_weights,
    merged,
    require_rows,
    robust_covariance,
)
from symgen.estimation.system import LinearSystem

FloatArray = NDArray[np.float64]
PASSES = 3
_PASSES_OF_A_PRIOR = 20  # on factors: cheap
NOISE_BIAS = "bias from noise of positions and speeds in the regressor, and errors of the model"


class Estimator(Protocol):
    """A method: from equations y = W X to X, its covariance, and what was noticed."""

    name: ClassVar[str]
    excludes: ClassVar[str]

    def solve(self, system: LinearSystem) -> Solution:
        """Solve y = W X.

        Raises:
            IdentificationError: the data do not determine the parameters.
        """


@dataclass(frozen=True)
class Ols:
    """Ordinary least squares: minimise ||y - W X||, all equations alike (Gauss 1809)."""

    name: ClassVar[str] = "ols"
    excludes: ClassVar[str] = NOISE_BIAS

    def solve(self, system: LinearSystem) -> Solution:
        """Solve by QR of [W y], log by log."""
        return _weighted(system, 0)


@dataclass(frozen=True)
class Wls:
    """Least squares, each log and joint weighed by the deviation of its own residual, iterated.

    minimise sum over logs of ||y_l - W_l X||^2 / sigma_l^2 (Gautier 1997, "Dynamic identification
    of robots with power model"). The equations of each joint count as a log.

    Attributes:
        prior: what is known beforehand, see `Prior`; None for nothing.
    """

    prior: Prior | None = None
    name: ClassVar[str] = "wls"
    excludes: ClassVar[str] = NOISE_BIAS

    def solve(self, system: LinearSystem) -> Solution:
        """Solve by QR of [W y], log by log, on whose factors the weights are iterated."""
        return _weighted(system, PASSES) if self.prior is None else self.prior.solve(system)


def _weighted(system: LinearSystem, passes: int) -> Solution:
    require_rows(system)
    weights, X, scale, R = log_weights(summaries(system), system.names, passes)
    return least_squares_solution(system, X, scale, R, [float(w) for w in weights])


@dataclass(frozen=True)
class Huber:
    """M-estimate by Huber's weights, iteratively reweighted: outliers lose their say (Huber 1964).

        sum rho(e_i / s_l) minimal,   rho(u) = u^2/2 for |u| < threshold, linear beyond

    s_l is the median of |e| over 0.6745 of each log and joint, taken anew in every pass. Precision
    from Huber (1981), section 7.6: A = (sum of w w' over rows within the threshold)^-1.

    Attributes:
        threshold: in deviations; 1.345 has 95 % of the efficiency of least squares under a normal
            law.
        passes: at most so many.
        tolerance: relative change of X at which they end.
    """

    threshold: float = 1.345
    passes: int = 50
    tolerance: float = 1e-8
    name: ClassVar[str] = "huber"
    excludes: ClassVar[str] = NOISE_BIAS

    def solve(self, system: LinearSystem) -> Solution:
        """Solve by QR of the reweighted rows."""
        require_rows(system)
        X = Wls().solve(system).X
        ones = np.ones(len(system.logs))
        for _ in range(self.passes):
            rows, inside, _ = self._weights(system, X)
            before = X
            X, scale, R = merged(factors(system, rows), ones, system.names)
            if np.linalg.norm(R @ (scale * (X - before))) <= self.tolerance * np.linalg.norm(
                R @ (scale * X)
            ):
                break
        rows, inside, deviation = self._weights(system, X)
        scores = [
            (np.square(w) * (e.y - e.W @ X))[:, None] * (e.W / scale)
            for w, e in zip(rows, system.logs, strict=True)
        ]
        kept = [
            (e.W / scale)[i] / s for e, i, s in zip(system.logs, inside, deviation, strict=True)
        ]
        bread = np.linalg.inv(sum(k.T @ k for k in kept))
        covariance = robust_covariance(system, bread, scores) / np.outer(scale, scale)
        beyond = 1 - np.mean(np.concatenate(inside))
        note = f"{100 * beyond:.3g} % of the equations lie beyond the threshold and weigh less"
        return Solution(X, covariance, condition(R), tuple(map(float, 1 / deviation)), (note,))

    def _weights(
        self, system: LinearSystem, X: FloatArray
    ) -> tuple[list[FloatArray], list[NDArray[np.bool_]], FloatArray]:
        errors = [np.abs(e.y - e.W @ X) for e in system.logs]
        deviation = np.array([float(np.median(e)) for e in errors]) / 0.6744897501960817
        inverse = inverse_deviation(deviation)
        sizes = [e * s for e, s in zip(errors, inverse, strict=True)]
        rows = [
            s * np.sqrt(self.threshold / np.maximum(u, self.threshold))
            for u, s in zip(sizes, inverse, strict=True)
        ]
        return rows, [u <= self.threshold for u in sizes], 1 / inverse


@dataclass(frozen=True, eq=False)
class Prior:
    """Weighted least squares and a prior, from CAD for example (Theil and Goldberger 1961).

        minimise sum of (y - W X)^2 / (sigma_l^2 c_l)  +  sum of ((X_i - mean_i) / std_i)^2

    c_l counts the rows that share samples, so that overlapping windows do not outvote the prior.

    Attributes:
        mean: (p,), in the units of X.
        std: (p,), how far each may be from its mean; infinite where nothing is known.
    """

    mean: FloatArray
    std: FloatArray
    name: ClassVar[str] = "prior"
    excludes: ClassVar[str] = NOISE_BIAS + "; errors of the prior beyond the std that it was given"

    def solve(self, system: LinearSystem) -> Solution:
        """Solve by QR of the rows and the prior below them."""
        require_rows(system)
        if self.mean.shape != (len(system.names),) or self.std.shape != self.mean.shape:
            raise IdentificationError(f"the prior is not one of {len(system.names)} parameters")
        if not (np.isfinite(self.mean).all() and (self.std > 0).all()):
            raise IdentificationError("the prior's means are not finite, or a std is not above 0")
        parts = factors(system)
        own = np.column_stack([np.diag(1 / self.std), self.mean / self.std])
        weights = np.ones(len(parts))
        X = self.mean
        for k in range(_PASSES_OF_A_PRIOR):
            if k:
                rss = [float(np.sum((f[:, -1] - f[:, :-1] @ X) ** 2)) for f in parts]
            else:  # the spread of y begins
                rss = [float(np.sum(f[:, -1] ** 2)) for f in parts]
            weights = inverse_deviation(np.sqrt(np.array(rss) / [len(e.y) for e in system.logs]))
            counted = weights / np.sqrt([max(e.correlation, 1) for e in system.logs])
            X, scale, R = merged([*parts, own], np.append(counted, 1.0), system.names)
        return _with_prior(system, X, scale, R, counted, 1 / self.std**2)


@dataclass(frozen=True)
class Ridge:
    """Ridge regression on columns of unit norm (Hoerl and Kennard 1970).

        minimise ||(y - W X)/sigma||^2 + strength ||D X||^2,   D the norms of the weighted columns

    Attributes:
        strength: None for p / ||D X_wls||^2, that of Hoerl, Kennard and Baldwin (1975).
    """

    strength: float | None = None
    name: ClassVar[str] = "ridge"
    excludes: ClassVar[str] = NOISE_BIAS + "; the bias towards zero of its own"

    def solve(self, system: LinearSystem) -> Solution:
        """Solve by QR of the rows and the penalty below them."""
        require_rows(system)
        if self.strength is not None and not self.strength >= 0:
            raise IdentificationError(f"ridge strength {self.strength:g}; accepted: 0 or above")
        own_logs = summaries(system)
        parts = [s.factor for s in own_logs]
        weights, X, scale, _ = log_weights(own_logs, system.names, PASSES)
        rss = [s.rss(X) for s in own_logs]
        rows, p = sum(len(e.y) for e in system.logs), len(X)
        sigma = np.sqrt(float(weights**2 @ rss) / (rows - p))
        strength = self.strength
        if strength is None:
            strength = p * sigma**2 / float(np.sum((scale * X) ** 2))
        penalty = np.sqrt(strength) * np.diag(scale)
        own = np.column_stack([penalty, np.zeros(p)])
        X, after, R = merged([*parts, own], np.append(weights, 1.0), system.names)
        inverse = np.linalg.inv(R)
        scores = [
            (w * w * (e.y - e.W @ X))[:, None] * (e.W / after)
            for w, e in zip(weights, system.logs, strict=True)
        ]
        covariance = robust_covariance(system, inverse @ inverse.T, scores)
        note = f"ridge strength {strength:.3g} on columns of unit norm"
        return Solution(
            X,
            covariance / np.outer(after, after),
            condition(R),
            tuple(map(float, weights)),
            (note,),
        )


def _with_prior(
    system: LinearSystem,
    X: FloatArray,
    scale: FloatArray,
    R: FloatArray,
    weights: FloatArray,
    information: FloatArray,
) -> Solution:
    """Return A (meat + prior information) A with A the inverse of both informations."""
    solution = least_squares_solution(system, X, scale, R, [float(w) for w in weights])
    bread = np.linalg.inv(R)
    bread = bread @ bread.T / np.outer(scale, scale)
    return replace(solution, covariance=solution.covariance + bread * information @ bread)
