"""The estimators: least squares and its relatives as objects.

Every estimator is a frozen value with a name and a method `solve` from a LinearSystem to a
Solution. `excludes` says what its standard deviations leave out.

Instrumental variables remove the bias that least squares has where the columns of W carry noise
that is also in y - W X. Instruments Z (as large as W) that follow the true motion but not this
noise give an estimate without it,

    X = (Z'W)^-1 Z'y            (Young 1970; Janot, Vandanjon, Gautier 2014)

Where Z comes from is said in `instruments`. The Durbin-Wu-Hausman test asks whether what Z does not
explain of W helps to explain y (Hausman 1978; Davidson and MacKinnon 1993, section 7.9):

    y = W X + V d + e,   V = W - Z (Z'Z)^-1 Z'W,   d = 0 where least squares is consistent
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from symgen.data.signals import NORMAL
from symgen.errors import IdentificationError
from symgen.estimation.covariance import long_run_covariance, robust_covariance, scores
from symgen.estimation.misfit import Products
from symgen.estimation.solve import (
    SINGULAR,
    Solution,
    column_norms,
    condition,
    inverse_deviation,
    inverse_information,
    least_squares_solution,
    log_weights,
    merged,
    require_rows,
    residual_weights,
    undetermined,
    weighted_triangle,
)
from symgen.estimation.summary import bounded_deviation, summaries, triangle
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import Endogeneity, FloatArray, OtherEstimate

PASSES = 3
_PASSES_OF_A_PRIOR = 20  # on factors: cheap
NOISE_BIAS = (
    "bias from noise of positions and speeds in the regressor, and errors of the model that are no "
    "smooth function of positions and speeds"
)
#: Columns whose part that the instruments leave is smaller than this share are not suspect.
_SUSPECT = 1e-7
#: Level of the Durbin-Wu-Hausman test below which least squares is called biased.
LEVEL = 0.01
#: Correlation of a direction of W with the instruments under which they are called weak.
_WEAK = 0.3
#: A bias that intervals do not hold: in std, and as a share of a parameter known to another share.
_BEYOND, _MATERIAL, _KNOWN = 3.0, 0.05, 0.3
_UNTESTED = "no Durbin-Wu-Hausman test: the logs hold too few independent equations"


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
    parts = summaries(system)
    weights, *solved = log_weights(parts, system.names, passes)
    return least_squares_solution(system, parts, weights, (solved[0], solved[1], solved[2]))


@dataclass(frozen=True)
class Huber:
    """M-estimate by Huber's weights, iteratively reweighted: outliers lose their say (Huber 1964).

        sum rho(e_i / s_l) minimal,   rho(u) = u^2/2 for |u| < threshold, linear beyond

    s_l is 1.4826 times the median of |e| of each log and joint, taken anew in every pass. Precision
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
        X, even = Wls().solve(system).X, np.ones(len(system.logs))
        for _ in range(self.passes):
            before = X
            found = system.weighed(self._weights(system, X)[0])
            X, scale, R = merged((s.factor for s in summaries(found)), even, system.names)
            moved, size = (np.linalg.norm(R @ (scale * x)) for x in (X - before, X))
            if moved <= self.tolerance * size:
                break
        rows, inverse = self._weights(system, X)
        inside = [w == v for w, v in zip(rows, inverse, strict=True)]
        kept = summaries(system.weighed([v * i for v, i in zip(inverse, inside, strict=True)]))
        bread = inverse_information(*merged((s.factor for s in kept), even, system.names)[1:])
        own = [scores(e, X) for e in system.weighed(rows).logs]
        products = [Products.of_summary(s, 1.0) for s in kept]
        beyond = 1 - np.mean(np.concatenate(inside))
        return Solution(
            X,
            *robust_covariance(system, X, bread, own, products),
            condition(R),
            tuple(map(float, inverse)),
            (f"{100 * beyond:.3g} % of the equations lie beyond the threshold and weigh less",),
        )

    def _weights(self, system: LinearSystem, X: FloatArray) -> tuple[list[FloatArray], FloatArray]:
        """Return the weight of every row, (K,) a log, and 1/s of the logs."""
        errors = [np.abs(e.y - e.W @ X) for e in system.logs]
        sigma = np.array([np.median(e) for e in errors]) * NORMAL
        squares = np.array([e.square for e in system.logs])
        inverse = inverse_deviation(bounded_deviation(sigma, squares))
        rows = [
            v * np.sqrt(self.threshold / np.maximum(v * e, self.threshold))
            for e, v in zip(errors, inverse, strict=True)
        ]
        return rows, inverse


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
        parts = summaries(system)
        own = np.column_stack([np.diag(1 / self.std), self.mean / self.std])
        X = np.zeros_like(self.mean)  # the spread of y begins
        for _ in range(_PASSES_OF_A_PRIOR):
            weights = residual_weights(parts, X) / np.sqrt([max(s.correlation, 1) for s in parts])
            rows = [*(s.factor for s in parts), own]
            X, scale, R = merged(rows, np.append(weights, 1.0), system.names)
        solution = least_squares_solution(system, parts, weights, (X, scale, R))
        bread = inverse_information(scale, R)
        more = bread / self.std**2 @ bread  # A (meat + prior information) A
        return replace(solution, noise=solution.noise + more)


@dataclass(frozen=True, eq=False)
class TotalLeastSquares:
    """Total least squares: the smallest errors of [W y] that make W X = y exact.

        minimise sum of (y - w'X)^2 / (1 + X'C X),   C = diag(noise^2)

    With v = (X, -1), D = diag(noise, 1) and R the triangle of [W y] this is the smallest
    ||R v|| / ||D v||: v = R^-1 w, with w the first right singular vector of D R^-1 (Golub and Van
    Loan 1980; noise may be 0 as in Van Huffel and Vandewalle 1991, ch. 3). It removes the bias of
    least squares where the errors of the columns are independent of each other and from row to row,
    and their ratio to those of y is known. Those of a robot's regressor are neither: instrumental
    variables ask for less. Precision by the sandwich of its estimating equations
    sum e (w + e C X/(1 + X'C X)) = 0.

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

    def solve(self, system: LinearSystem) -> Solution:
        """Solve by QR and SVD of [W y], each log weighed as in weighted least squares."""
        require_rows(system)
        p = len(system.names)
        parts = summaries(system)
        weights, _, scale, _ = log_weights(parts, system.names, PASSES)
        whole = weighted_triangle((s.factor for s in parts), weights)
        noise = self._noise(scale, float(np.linalg.norm(whole[:, p])), p)
        X = _orthogonal(whole, noise)
        C = noise**2
        growth = 1 + float(C @ X**2)
        errors = [w * (e.y - e.W @ X) for w, e in zip(weights, system.logs, strict=True)]
        own = [
            x[:, None] * (w * e.W + np.outer(x, C * X / growth))
            for x, w, e in zip(errors, weights, system.logs, strict=True)
        ]
        rss = sum(float(x @ x) for x in errors)
        information = whole[:p, :p].T @ whole[:p, :p] - rss / growth * np.diag(C)
        unit = np.outer(scale, scale)
        values = np.linalg.eigvalsh(information / unit)
        if not values[0] > 0:
            raise IdentificationError(
                "total least squares has no solution here: the errors of the columns hide the "
                "least excited parameters; accepted: a richer motion, or method wls or iv"
            )
        bread = np.linalg.inv(information / unit) / unit
        products = [Products.of_summary(s, w) for s, w in zip(parts, weights, strict=True)]
        covariances = robust_covariance(system, X, bread, own, products)
        root = float(np.sqrt(values[-1] / values[0]))
        return Solution(X, *covariances, root, tuple(map(float, weights)))

    def _noise(self, scale: FloatArray, y: float, p: int) -> FloatArray:
        if self.noise is None:
            return scale / y
        noise = np.asarray(self.noise, dtype=float)
        if noise.shape != (p,) or not (np.isfinite(noise).all() and (noise >= 0).all()):
            raise IdentificationError(f"the noise of the columns is not {p} numbers of 0 or above")
        return noise


def _orthogonal(whole: FloatArray, noise: FloatArray) -> FloatArray:
    """Solve the triangular [W y] by the vector with the smallest residual for its errors."""
    norms = column_norms(whole)
    R, errors = whole / norms, np.append(noise, 1.0) / norms
    R[-1, -1] = max(abs(R[-1, -1]), 1e-300)
    inverse = np.linalg.inv(R)
    _, _, right = np.linalg.svd(errors[:, None] * inverse)
    v = inverse @ right[0]
    if abs(errors[-1] * v[-1]) < 1e-12 * np.linalg.norm(errors * v):
        raise IdentificationError("total least squares has no finite solution here")
    v /= norms
    return np.asarray(-v[:-1] / v[-1])


@dataclass(frozen=True)
class InstrumentalVariables:
    """Instrumental variables X = (Z'W)^-1 Z'y, logs weighed by the deviation of their residual.

    Its covariance is the sandwich with instruments, (Z'W)^-1 S (W'Z)^-1 with S the long-run
    covariance of z e. Beside it stand weighted least squares and the Durbin-Wu-Hausman test.

    Attributes:
        least: weighted least squares of the same equations, where it is known.
    """

    least: Solution | None = None
    name: ClassVar[str] = "iv"
    excludes: ClassVar[str] = (
        "bias where the noise of the instruments is not independent of that of the regressor, and "
        "errors of the model"
    )

    def solve(self, system: LinearSystem) -> Solution:
        """Solve y = W X with the instruments of the equations, Z of every log.

        Raises:
            IdentificationError: there are no instruments, or they do not follow the regressor.
        """
        require_rows(system)
        if any(e.Z is None for e in system.logs):
            raise IdentificationError(
                "method iv needs instruments; accepted: logs with measured speeds qd, whose "
                "instruments come from the encoders, or the commanded motion of every log"
            )
        least = self.least or Wls().solve(system)
        weights: FloatArray = np.array(least.weights)
        reduced, parts = _Reduced.of(system, weights), summaries(system)
        for _ in range(PASSES if len(parts) > 1 else 0):
            weights = residual_weights(parts, reduced.X)
            reduced = _Reduced.of(system, weights)
        X, A = reduced.X, reduced.Rz.T @ reduced.Rzw
        bread = np.linalg.inv(A) / np.outer(reduced.scale, reduced.size)
        rows, products = [], []
        for e, s, w in zip(system.logs, parts, weights, strict=True):
            Z, F = _z(e), np.zeros((len(e.y), 0)) if e.features is None else e.features
            rows.append(w**2 * (e.y - e.W @ X)[:, None] * Z)
            products.append(Products.of_summary(s, w, Z.T @ np.hstack([Z, F])))
        test = durbin_wu_hausman(system, weights)
        notes = [_UNTESTED if test is None else in_words(test, system.names, least, X)]
        if reduced.shared < _WEAK:
            notes.append(
                "weak instruments: a combination of columns has a correlation of "
                f"{reduced.shared:.2g} with them; its estimate is uncertain, also beyond its std"
            )
        return Solution(
            X,
            *robust_covariance(system, X, bread, rows, products),
            float(np.linalg.cond(A)),
            tuple(map(float, weights)),
            tuple(notes),
            () if test is None else (test,),
            (OtherEstimate.by("wls", system.names, least.X, least.std),),
        )


def _z(equations: Equations) -> FloatArray:
    """Return the instruments, which were asked for before."""
    assert equations.Z is not None
    return equations.Z


@dataclass(frozen=True, eq=False)
class _Reduced:
    """Weighted [Z W y] = Q [Rz Rzw rzy; 0 Rv rv], with columns of Z and W of unit norm.

    Attributes:
        X: the instrumental-variables estimate, (p,).
        size, scale: norms of the columns of Z and of W, (p,).
        Rz, Rzw, Rv: (p, p); Q'W is [Rzw; Rv], and Rv is the triangle of what Z leaves of W.
        shared: smallest canonical correlation of W with Z.
    """

    X: FloatArray
    size: FloatArray
    scale: FloatArray
    Rz: FloatArray
    Rzw: FloatArray
    Rv: FloatArray
    shared: float

    @classmethod
    def of(cls, system: LinearSystem, weights: FloatArray) -> _Reduced:
        """Reduce equations with instruments, one weight a log."""
        p, names = len(system.names), system.names
        rows = (triangle(np.column_stack([_z(e), e.W, e.y])) for e in system.logs)
        R = weighted_triangle(rows, weights)
        norms = column_norms(R[:, : 2 * p])
        R[:, : 2 * p] /= norms
        Rz, Rzw, Rv = R[:p, :p], R[:p, p : 2 * p], R[p : 2 * p, p : 2 * p]
        Rw = triangle(R[:, p : 2 * p])
        lost = undetermined(Rw, names)
        if lost:
            raise IdentificationError(lost)
        canonical = np.linalg.svd(np.linalg.solve(Rw.T, Rzw.T), compute_uv=False)
        shared = float(canonical[-1])
        if undetermined(Rz, names) or shared <= SINGULAR:
            raise IdentificationError(
                "the information matrix is singular: these instruments do not determine the "
                "parameters"
            )
        X = np.linalg.solve(Rzw, R[:p, 2 * p]) / norms[p:]
        return cls(X, norms[:p], norms[p:], Rz, Rzw, Rv, shared)


def durbin_wu_hausman(system: LinearSystem, weights: FloatArray) -> Endogeneity | None:
    """Test whether least squares is biased.

    F is the Wald statistic of d = 0 over its degrees of freedom, with the covariance that is robust
    to correlated residuals.

    Args:
        system: equations with instruments.
        weights: one a log.

    Returns:
        The test; None where no column differs from what the instruments explain of it, or where
        the logs hold too few equations.
    """
    reduced, p = _Reduced.of(system, weights), len(system.names)
    # V = (W - Z explained) / scale, in an orthonormal basis of its columns
    explained = np.linalg.solve(reduced.Rz * reduced.size, reduced.Rzw * reduced.scale)
    _, singular, turn = np.linalg.svd(reduced.Rv)
    kept = singular > _SUSPECT
    basis = turn[kept].T / singular[kept] / reduced.scale[:, None]
    extra = basis.shape[1]
    freedom = sum(len(e.y) / max(e.correlation, 1) for e in system.logs) - p - extra
    if extra == 0 or freedom < 1:
        return None
    rows = []
    for e, w in zip(system.logs, weights, strict=True):
        V = (e.W - _z(e) @ explained) @ basis
        rows.append(replace(e, W=w * np.column_stack([e.W, V]), y=w * e.y, Z=None, features=None))
    augmented = LinearSystem((*system.names, *["d"] * extra), tuple(rows))
    parts = summaries(augmented)
    try:
        X, scale, R = merged((s.factor for s in parts), np.ones(len(parts)), augmented.names)
    except IdentificationError:
        return None
    own = [scores(e, X) for e in rows]
    covariance = long_run_covariance(augmented, inverse_information(scale, R), own)[p:, p:]
    count = int(np.linalg.matrix_rank(covariance, hermitian=True))
    size = X[p:] @ np.linalg.pinv(covariance, hermitian=True) @ X[p:]
    statistic = float(size) / count
    return Endogeneity("all", statistic, (count, freedom), _f_tail(statistic, count, freedom))


def bias_of_least_squares(
    system: LinearSystem, solution: Solution, least: Solution | None = None
) -> tuple[Solution, str]:
    """Compare weighted least squares with instrumental variables, where there are instruments.

    Args:
        system: the equations that were solved.
        solution: by a method that takes the regressor as exact.
        least: weighted least squares of these equations, where it is known.

    Returns:
        The solution with tests and comparison, and in words a bias that the intervals do not hold,
        or "": significant, above 3 std, and above 5 % of a parameter that is known to 30 %.
    """
    if any(e.Z is None for e in system.logs):
        return solution, ""
    try:
        other = InstrumentalVariables(least).solve(system)
    except IdentificationError:
        return replace(solution, notes=(*solution.notes, _UNTESTED)), ""
    spread, size = other.std, np.abs(other.X)
    compared = replace(
        solution,
        notes=(*solution.notes, *other.notes),
        endogeneity=other.endogeneity,
        comparison=(*solution.comparison, OtherEstimate.by("iv", system.names, other.X, spread)),
    )
    plain = other.comparison[0]
    moves = np.abs(other.X - plain.X)
    known = (spread < _KNOWN * size) & (moves > _MATERIAL * size)
    certain = any(test.p_value < LEVEL for test in other.endogeneity)
    ratio = np.where(known & (plain.std > 0), moves / np.maximum(plain.std, 1e-300), 0.0)
    worst = int(np.argmax(ratio))
    if not certain or ratio[worst] <= _BEYOND:
        return compared, ""
    return compared, (
        f"plain least squares is biased by noise in the speeds: {system.names[worst]} by "
        f"{ratio[worst]:.2g} std, {100 * moves[worst] / size[worst]:.2g} %; compare method iv"
    )


def in_words(test: Endogeneity, names: Sequence[str], least: Solution, X: FloatArray) -> str:
    """Return a note on a test, and on how far least squares is from the other estimate X, (p,)."""
    moves = np.abs(X - least.X) / np.where(least.std > 0, least.std, np.inf)
    worst = int(np.argmax(moves))
    return (
        "instrumental variables differ from plain least squares by at most "
        f"{moves[worst]:.2g} std, for {names[worst]} (F({test.df[0]}, {test.df[1]:.0f}) = "
        f"{test.statistic:.3g}, p = {test.p_value:.2g})"
    )


#: Estimators that need nothing but the equations, by the name of `--method`.
ESTIMATORS: dict[str, Estimator] = {
    e.name: e
    for e in (
        Wls(),
        Ols(),
        Huber(),
        TotalLeastSquares(),
        InstrumentalVariables(),
    )
}
METHODS = tuple(ESTIMATORS)


def solve(system: LinearSystem, method: str = "wls") -> Solution:
    """Solve y = W X by a method of METHODS.

    Args:
        system: the equations, log by log.
        method: its name.

    Raises:
        IdentificationError: there is no such method, or the data do not determine the parameters.
    """
    if method not in ESTIMATORS:
        raise IdentificationError(f"method {method!r}; accepted: {', '.join(METHODS)}")
    return ESTIMATORS[method].solve(system)


def _f_tail(statistic: float, numerator: float, denominator: float) -> float:
    """Return the probability that F(numerator, denominator) is above a value."""
    from scipy.special import fdtrc

    return float(fdtrc(numerator, denominator, max(statistic, 0.0)))
