"""Weighted least squares from triangles, shared by all estimators, and its solution."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np

from symgen.errors import IdentificationError, first_of
from symgen.estimation.covariance import robust_covariance, scores, summed_scores
from symgen.estimation.summary import Summary, bounded_deviation, summaries, triangle
from symgen.estimation.system import Equations, Rows
from symgen.estimation.values import Endogeneity, FloatArray, OtherEstimate

#: Singular values of the scaled regressor below this share of the largest count as zero.
SINGULAR = 1e-8
_SHORTEST = 1e-9  # the same for a search, which tests columns that may be dependent
#: Passes in which the log weights follow the residuals.
PASSES = 3
_PASSES_OF_A_PRIOR = 19  # cheap, as it uses the factors
#: X (p,), the norms of the columns (p,), and the factor R (p, p) of the scaled regressor.
Merged = tuple[FloatArray, FloatArray, FloatArray]
Solved = TypeVar("Solved")
#: A parameter with a smaller share than this in an undetermined combination is not part of it.
_SHARE = 1e-3


@dataclass(frozen=True, eq=False)
class Solution:
    """The result of an estimator.

    Attributes:
        X: the parameters, (p,), in the units of the model.
        noise: covariance of X from noise, (p, p), robust to residuals that are correlated in time.
        misfit: covariance of X from model misfit, (p, p); 0 if unknown.
        condition_number: condition number of the regressor with columns scaled to unit norm.
        weights: 1/sigma of the residuals, one a log.
        notes: notes on the solution, as text.
        endogeneity: tests of whether least squares is biased.
        comparison: the same parameters by other methods.
    """

    X: FloatArray
    noise: FloatArray
    misfit: FloatArray
    condition_number: float
    weights: tuple[float, ...]
    notes: tuple[str, ...] = ()
    endogeneity: tuple[Endogeneity, ...] = ()
    comparison: tuple[OtherEstimate, ...] = ()

    @property
    def covariance(self) -> FloatArray:
        """Covariance of X, (p, p)."""
        return self.noise + self.misfit

    @property
    def std(self) -> FloatArray:
        """Standard deviations of X, (p,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0))


def require_rows(rows: Rows) -> None:
    """Raise IdentificationError if there are no more equations than parameters."""
    count, p = rows.count, len(rows.names)
    if count <= p:
        raise IdentificationError(f"{count} equations for {p} parameters: the log is too short")


def weighted_triangle(parts: Iterable[Summary], weights: FloatArray) -> FloatArray:
    """Return the triangular factor of weighted equations, one weight a summary."""
    factors = [w * s.factor for w, s in zip(weights, parts, strict=True)]
    return triangle(np.concatenate(factors))


def merged(parts: Iterable[Summary], weights: FloatArray, names: tuple[str, ...]) -> Merged:
    """Merge weighted equations and solve.

    Args:
        parts: summaries of the equations.
        weights: one a part.
        names: names of the p columns of W.

    Returns:
        X (p,), the norms of the columns (p,), and the triangular factor R (p, p) of the scaled W.

    Raises:
        IdentificationError: the data do not determine the parameters; the message says which.
    """
    p, factor = len(names), weighted_triangle(parts, weights)
    scale = column_norms(factor[:, :p])
    R, y = factor[:p, :p] / scale, factor[:p, p]
    lost = undetermined(R, names)
    if lost:
        raise IdentificationError(lost)
    return np.linalg.solve(R, y) / scale, scale, R


def reweighted(
    solve: Callable[[FloatArray], Solved],
    weigh: Callable[[Solved], FloatArray],
    weights: FloatArray,
    passes: int = PASSES,
) -> tuple[FloatArray, Solved]:
    """Solve least squares, and let the weights of its parts follow their residuals.

    Args:
        solve: returns the solution for weights, one a part.
        weigh: returns the weights for a solution, such as `residual_weights`.
        weights: the first weights.
        passes: number of updates of the weights.

    Returns:
        The last weights, and the solution with them.
    """
    solved = solve(weights)
    for _ in range(passes):
        weights = weigh(solved)
        solved = solve(weights)
    return weights, solved


def log_weights(
    parts: Sequence[Summary],
    names: tuple[str, ...],
    passes: int = PASSES,
    prior: FloatArray | None = None,
) -> tuple[FloatArray, Merged]:
    """Return the log weights 1/sigma by iteration, with sigma the residual deviation of each log.

    With a prior, the weights contain the number of rows that share samples, so that overlapping
    windows do not outweigh it.

    Args:
        parts: the summaries of the logs; read once a pass.
        names: names of the columns.
        passes: number of updates of the weights; 0 for equal weights.
        prior: equations of a prior with a deviation of one, (k, p + 1), for any number of passes.

    Returns:
        The weights (1/sigma, one a log), and the result of `merged` with them.
    """
    even = np.ones(len(parts))
    if prior is None:
        rounds = passes if len(parts) > 1 else 0
        return reweighted(
            lambda weights: merged(parts, weights, names),
            lambda solved: residual_weights(parts, solved[0]),
            even,
            rounds,
        )
    shared = np.sqrt([max(s.correlation, 1) for s in parts])
    both = [*parts, Summary(prior, len(prior))]

    def weigh(X: FloatArray) -> FloatArray:
        return residual_weights(parts, X) / shared

    return reweighted(
        lambda weights: merged(both, np.append(weights, 1.0), names),
        lambda solved: weigh(solved[0]),
        weigh(np.zeros(len(names))),  # the first deviation is that of y
        _PASSES_OF_A_PRIOR,
    )


def shortest_weights(parts: Sequence[Summary]) -> FloatArray:
    """Return the log weights 1/sigma, as `log_weights`, of the shortest solution."""
    even = np.ones(len(parts))
    weigh = partial(residual_weights, parts)
    return weigh(reweighted(partial(shortest_of, parts), weigh, even)[1])


def shortest_of(parts: Iterable[Summary], weights: FloatArray) -> FloatArray:
    """Return the shortest solution of weighted equations from their summaries, (p,)."""
    return _shortest(weighted_triangle(parts, weights))


def shortest(rows: FloatArray) -> FloatArray:
    """Solve least squares from rows of [W y], or triangles of them: the shortest solution, (p,).

    Columns are scaled to unit norm first. Undetermined directions are zero.

    Args:
        rows: (k, p + 1).
    """
    return _shortest(triangle(rows))


def _shortest(factor: FloatArray) -> FloatArray:
    """Return the shortest solution from the triangular factor of [W y]."""
    p = factor.shape[1] - 1
    if p == 0:
        return np.zeros(0)
    scale = column_norms(factor[:, :p])
    R, y = factor[:p, :p] / scale, factor[:p, p]
    if len(R) == p and R.diagonal().all():
        inverse = np.linalg.inv(R)
        condition = np.linalg.norm(R, 1) * np.linalg.norm(inverse, 1)
        if condition * _SHORTEST < 1:  # no singular value is zero
            return np.asarray(inverse @ y / scale)
    return np.linalg.lstsq(R, y, rcond=_SHORTEST)[0] / scale


def residual_weights(parts: Sequence[Summary], X: FloatArray) -> FloatArray:
    """Return 1/sigma of the residual of each part; see `bounded_deviation`."""
    sigma = np.sqrt([s.rss(X) / max(s.rows, 1) for s in parts])
    squares = np.array([s.square for s in parts])
    return inverse_deviation(sigma, squares)


def inverse_deviation(sigma: FloatArray, squares: FloatArray) -> FloatArray:
    """Return 1/sigma of `bounded_deviation`, with sigma at least a millionth of the largest."""
    sigma = bounded_deviation(sigma, squares)
    return 1 / np.maximum(sigma, max(1e-6 * sigma.max(), 1e-300))


def inverse_information(scale: FloatArray, R: FloatArray) -> FloatArray:
    """Return (W'W)^-1 (p, p) from the column norms of W and the factor R of the scaled W."""
    inverse: FloatArray = np.linalg.inv(R) / scale[:, None]
    return inverse @ inverse.T


def least_squares_solution(
    parts: Sequence[Summary],
    weights: FloatArray,
    solved: Merged,
    meat: FloatArray,
    prior: FloatArray | None = None,
) -> Solution:
    """Return the solution of weighted least squares with its precision.

    Args:
        parts: summaries of the logs.
        weights: weights of the rows, one a log.
        solved: the result of `merged` with these weights.
        meat: their `summed_scores`, (p, p).
        prior: equations of the prior in the solution, (k, p + 1).
    """
    X, scale, R = solved
    bread = inverse_information(scale, R)
    noise, misfit = robust_covariance(X, bread, meat, parts, weights)
    if prior is not None:
        rows = prior[:, :-1] @ bread
        noise = noise + rows.T @ rows
    return Solution(X, noise, misfit, condition(R), tuple(map(float, weights)))


def sum_of_scores(
    equations: Iterable[Equations], parts: Sequence[Summary], weights: FloatArray, X: FloatArray
) -> FloatArray:
    """Return the `summed_scores` of weighted least squares, (p, p)."""
    pairs = zip(weights, equations, strict=True)
    return summed_scores((scores(e, X, w) for w, e in pairs), parts)


def weighted_least_squares(
    rows: Rows, passes: int = PASSES, prior: FloatArray | None = None
) -> Solution:
    """Solve by QR of [W y], log by log; the weights are iterated on the factors.

    Args:
        rows: the equations.
        passes, prior: as in `log_weights`.

    Raises:
        IdentificationError: the data do not determine the parameters.
    """
    if prior is None:
        require_rows(rows)
    equations = rows.parts
    parts = summaries(equations)
    weights, solved = log_weights(parts, rows.names, passes, prior)
    meat = sum_of_scores(equations, parts, weights, solved[0])
    return least_squares_solution(parts, weights, solved, meat, prior)


def condition(R: FloatArray) -> float:
    """Return the condition number of a triangular factor."""
    singular = np.linalg.svd(R, compute_uv=False)
    return float(singular[0] / singular[-1])


def column_norms(R: FloatArray) -> FloatArray:
    """Return the norms of the columns; 1 for a column that is zero."""
    norms: FloatArray = np.linalg.norm(R, axis=0)
    return np.where(norms > 0, norms, 1.0)


def _null_space(R: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the combinations of columns that do not exceed noise, of unit norm, one a row.

    Args:
        R: triangular factor of columns of unit norm, (p, p).
        noise: triangular factor of the noise in these columns, (p, p), not singular.
    """
    ratio = R @ np.linalg.inv(noise)
    _, singular, right = np.linalg.svd(ratio)
    hidden = right[np.count_nonzero(singular > 1) :]
    null = np.linalg.solve(noise, hidden.T)
    return np.asarray((null / np.linalg.norm(null, axis=0)).T)


def undetermined(R: FloatArray, names: tuple[str, ...]) -> str:
    """Return a text with the parameters that a scaled regressor does not determine, or ''.

    Args:
        R: triangular factor of the regressor with columns of unit norm, (p, p).
        names: names of its columns.
    """
    rounding = SINGULAR * (float(np.linalg.norm(R, 2)) or 1.0)
    null = _null_space(R, rounding * np.eye(len(R)))
    if len(null) == 0:
        return ""
    share = np.linalg.norm(null, axis=0)
    involved = [name for name, s in zip(names, share, strict=True) if s > _SHARE]
    return (
        "the information matrix is singular: these data do not determine "
        f"{first_of(involved)} "
        f"({len(null)} of {len(names)} combinations of parameters have no effect on them)"
    )


class IdentifiableColumns(NamedTuple):
    """The parameters that some equations determine.

    Attributes:
        kept: indices in X of linearly independent columns; earlier columns have priority.
        known: those of `kept` that take no part in an undetermined combination.
    """

    kept: list[int]
    known: list[int]


def identifiable_columns(W: FloatArray, noise: FloatArray | None = None) -> IdentifiableColumns:
    """Return the columns of a regressor that its rows determine; none if all are zero.

    Columns have unit norm. A combination v is determined if ||W v|| exceeds both ||E v|| and 1e-8
    ||v||, which is the effect of rounding.

    Args:
        W: (K, p).
        noise: E (L, p), the noise of the columns; None if they are exact.
    """
    R = triangle(W)
    norms = np.linalg.norm(R, axis=0)
    scale = np.where(norms > SINGULAR * norms.max(), norms, np.inf)
    R /= scale
    rounding = SINGULAR * np.eye(len(norms))
    if noise is not None:
        rounding = np.concatenate([noise / scale, rounding])
    E = triangle(rounding)
    kept: list[int] = []
    for k in np.flatnonzero(R.any(axis=0)).tolist():
        tried = [*kept, k]
        of_noise = triangle(E[:, tried])
        ratio = R[:, tried] @ np.linalg.inv(of_noise)
        if np.linalg.svd(ratio, compute_uv=False)[-1] > 1:
            kept.append(k)
    open_ = np.linalg.norm(_null_space(R, E), axis=0)
    return IdentifiableColumns(kept, [k for k in kept if open_[k] <= _SHARE])
