"""The estimators: least squares and related methods.

Every estimator is a frozen value with a name and a method `solve` from Rows to a Solution.
`excludes` names what its standard deviations do not contain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from symgen.data.signals import NORMAL
from symgen.errors import IdentificationError
from symgen.estimation.covariance import robust_covariance, summed_scores
from symgen.estimation.instrumental import InstrumentalVariables
from symgen.estimation.solve import (
    Solution,
    column_norms,
    condition,
    inverse_deviation,
    inverse_information,
    log_weights,
    merged,
    require_rows,
    sum_of_scores,
    weighted_least_squares,
    weighted_triangle,
)
from symgen.estimation.summary import summaries
from symgen.estimation.system import Equations, Rows
from symgen.estimation.values import FloatArray

NOISE_BIAS = (
    "bias from noise of positions and speeds in the regressor, and errors of the model that are no "
    "smooth function of positions and speeds"
)


class Estimator(Protocol):
    """An estimator: it solves the equations y = W X for X and its covariance."""

    name: ClassVar[str]
    excludes: ClassVar[str]

    def solve(self, rows: Rows) -> Solution:
        """Solve y = W X.

        Raises:
            IdentificationError: the data do not determine the parameters.
        """


@dataclass(frozen=True)
class Ols:
    """Ordinary least squares: minimise ||y - W X|| with equal weights (Gauss 1809)."""

    name: ClassVar[str] = "ols"
    excludes: ClassVar[str] = NOISE_BIAS

    def solve(self, rows: Rows) -> Solution:
        """Solve by QR of [W y], log by log."""
        return weighted_least_squares(rows, 0)


@dataclass(frozen=True)
class Wls:
    """Iterated least squares with a weight for each log and joint: 1 over its residual deviation.

    minimise sum over logs of ||y_l - W_l X||^2 / sigma_l^2 (Gautier 1997, "Dynamic identification
    of robots with power model"). The equations of each joint count as a log.
    """

    name: ClassVar[str] = "wls"
    excludes: ClassVar[str] = NOISE_BIAS

    def solve(self, rows: Rows) -> Solution:
        """Solve by QR of [W y], log by log; the weights are iterated on the factors."""
        return weighted_least_squares(rows)


@dataclass(frozen=True)
class Huber:
    """Huber's M-estimate, iteratively reweighted: outliers have less influence (Huber 1964).

        sum rho(e_i / s_l) minimal,   rho(u) = u^2/2 for |u| < threshold, linear beyond

    s_l is 1.4826 times the median of |e| of each log and joint, computed in every pass. Precision
    from Huber (1981), section 7.6: A = (sum of w w' over rows within the threshold)^-1.

    Attributes:
        threshold: threshold in deviations; 1.345 has 95 % of the efficiency of least squares under
            normal noise.
        passes: maximum number of passes.
        tolerance: relative change of X at which the passes end.
    """

    threshold: float = 1.345
    passes: int = 50
    tolerance: float = 1e-8
    name: ClassVar[str] = "huber"
    excludes: ClassVar[str] = NOISE_BIAS

    def solve(self, rows: Rows) -> Solution:
        """Solve by QR of the reweighted rows."""
        X = weighted_least_squares(rows).X
        equations, names = rows.parts, rows.names
        even = np.ones(len(equations))
        for _ in range(self.passes):
            before = X
            weights, _ = self._weights(equations, X)
            parts = summaries(map(Equations.weighed, equations, weights))
            X, scale, R = merged(parts, even, names)
            moved = np.linalg.norm(R @ (scale * (X - before)))
            if moved <= self.tolerance * np.linalg.norm(R @ (scale * X)):
                break
        weights, inverse = self._weights(equations, X)
        inside = [w == v for w, v in zip(weights, inverse, strict=True)]
        within = [v * i for v, i in zip(inverse, inside, strict=True)]
        kept = summaries(map(Equations.weighed, equations, within))
        _, *factor = merged(kept, even, names)
        bread = inverse_information(*factor)
        meat = sum_of_scores(map(Equations.weighed, equations, weights), kept, even, X)
        covariances = robust_covariance(X, bread, meat, kept, even)
        beyond = 1 - np.mean(np.concatenate(inside))
        note = f"{100 * beyond:.3g} % of the equations lie beyond the threshold and weigh less"
        return Solution(X, *covariances, condition(R), tuple(map(float, inverse)), (note,))

    def _weights(
        self, equations: Sequence[Equations], X: FloatArray
    ) -> tuple[list[FloatArray], FloatArray]:
        """Return the weight of every row, (k,) a log, and 1/s of the logs."""
        errors = [np.abs(e.residual(X)) for e in equations]
        sigma = np.array([np.median(e) for e in errors]) * NORMAL
        squares = np.array([e.square for e in equations])
        inverse = inverse_deviation(sigma, squares)
        weights = []
        for e, v in zip(errors, inverse, strict=True):
            beyond = np.maximum(v * e, self.threshold)
            weights.append(v * np.sqrt(self.threshold / beyond))
        return weights, inverse


@dataclass(frozen=True, eq=False)
class Prior:
    """Weighted least squares with a prior, from CAD for example (Theil and Goldberger 1961).

        minimise sum of (y - W X)^2 / (sigma_l^2 c_l)  +  sum of ((X_i - mean_i) / std_i)^2

    c_l is the number of rows that share samples. It keeps overlapping windows from outweighing the
    prior.

    Attributes:
        mean: (p,), in the units of X.
        std: (p,) standard deviation of each mean; infinite where nothing is known.
    """

    mean: FloatArray
    std: FloatArray
    name: ClassVar[str] = "prior"
    excludes: ClassVar[str] = NOISE_BIAS + "; errors of the prior beyond its std"

    def solve(self, rows: Rows) -> Solution:
        """Solve by QR of the rows and the prior below them."""
        require_rows(rows)
        if self.mean.shape != (len(rows.names),) or self.std.shape != self.mean.shape:
            raise IdentificationError(f"the prior is not one of {len(rows.names)} parameters")
        if not (np.isfinite(self.mean).all() and (self.std > 0).all()):
            raise IdentificationError("the prior's means are not finite, or a std is not above 0")
        precision = 1 / self.std
        prior_rows = np.column_stack([np.diag(precision), precision * self.mean])
        return weighted_least_squares(rows, prior=prior_rows)


@dataclass(frozen=True, eq=False)
class TotalLeastSquares:
    """Total least squares: the smallest errors of [W y] that make W X = y exact.

        minimise sum of (y - w'X)^2 / (1 + X'C X),   C = diag(noise^2)

    With v = (X, -1), D = diag(noise, 1) and R the triangle of [W y], this is the smallest ||R v|| /
    ||D v||. Its solution is v = R^-1 w, with w the first right singular vector of D R^-1 (Golub and
    Van Loan 1980; noise may be 0 as in Van Huffel and Vandewalle 1991, ch. 3).

    It removes the bias of least squares under two conditions. The errors of the columns are
    independent of each other and from row to row, and their ratio to those of y is known. A robot's
    regressor does not satisfy them; instrumental variables need less. The precision is the sandwich
    of the estimating equations sum e (w + e C X/(1 + X'C X)) = 0.

    Attributes:
        noise: (p,) standard deviation of the error of each column over that of y; 0 where exact.
            None: in proportion to the norm of the column over that of y.
    """

    noise: FloatArray | None = None
    name: ClassVar[str] = "tls"
    excludes: ClassVar[str] = (
        "bias where the errors of the columns have other sizes than it takes them to have, or are "
        "correlated"
    )

    def solve(self, rows: Rows) -> Solution:
        """Solve by QR and SVD of [W y], with the log weights of weighted least squares."""
        require_rows(rows)
        p, equations = len(rows.names), rows.parts
        parts = summaries(equations)
        weights, (_, scale, _) = log_weights(parts, rows.names)
        factor = weighted_triangle(parts, weights)
        size = float(np.linalg.norm(factor[:, p]))
        noise = self._noise(scale, size, p)
        X = _orthogonal(factor, noise)
        C = noise**2
        growth = 1 + float(C @ X**2)
        toward = C * X / growth
        scores, rss = [], 0.0
        for w, e in zip(weights, equations, strict=True):
            error = w * e.residual(X)
            nearest = w * e.W + np.outer(error, toward)
            scores.append(error[:, None] * nearest)
            rss += float(error @ error)
        R = factor[:p, :p]
        information = R.T @ R - rss / growth * np.diag(C)
        unit = np.outer(scale, scale)
        values = np.linalg.eigvalsh(information / unit)
        if not values[0] > 0:
            raise IdentificationError(
                "total least squares has no solution here: the errors of the columns hide the "
                "least excited parameters; accepted: a richer motion, or method wls or iv"
            )
        bread = np.linalg.inv(information / unit) / unit
        meat = summed_scores(scores, parts)
        covariances = robust_covariance(X, bread, meat, parts, weights)
        root = float(np.sqrt(values[-1] / values[0]))
        return Solution(X, *covariances, root, tuple(map(float, weights)))

    def _noise(self, scale: FloatArray, y: float, p: int) -> FloatArray:
        if self.noise is None:
            return scale / y
        noise = np.asarray(self.noise, dtype=float)
        if noise.shape != (p,) or not (np.isfinite(noise).all() and (noise >= 0).all()):
            raise IdentificationError(f"the noise of the columns is not {p} numbers of 0 or above")
        return noise


def _orthogonal(factor: FloatArray, noise: FloatArray) -> FloatArray:
    """Solve the triangular [W y] by the vector with the smallest residual for its errors."""
    norms = column_norms(factor)
    R, sizes = factor / norms, np.append(noise, 1.0)
    R[-1, -1] = max(abs(R[-1, -1]), 1e-300)
    inverse, errors = np.linalg.inv(R), sizes / norms
    _, _, right = np.linalg.svd(errors[:, None] * inverse)
    v = inverse @ right[0]
    if abs(errors[-1] * v[-1]) < 1e-12 * np.linalg.norm(errors * v):
        raise IdentificationError("total least squares has no finite solution here")
    v /= norms
    return np.asarray(-v[:-1] / v[-1])


#: Estimators that need only the equations, by the name of `--method`.
ESTIMATORS: dict[str, Estimator] = {
    e.name: e for e in (Wls(), Ols(), Huber(), TotalLeastSquares(), InstrumentalVariables())
}
METHODS = tuple(ESTIMATORS)
