"""Instrumental variables, and the test of least squares that they allow.

Least squares is biased where the columns of W contain noise that y - W X contains too. Instruments
Z, of the size of W, follow the true motion without this noise. They give an estimate without this
bias,

    X = (Z'W)^-1 Z'y            (Young 1970; Janot, Vandanjon, Gautier 2014)

`symgen.identification.instruments` computes Z. The Durbin-Wu-Hausman test asks whether the part of
W that Z does not explain helps to explain y (Hausman 1978; Davidson and MacKinnon 1993, section
7.9):

    y = W X + V d + e,   V = W - Z (Z'Z)^-1 Z'W,   d = 0 where least squares is consistent
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np

from symgen.errors import IdentificationError
from symgen.estimation.covariance import robust_covariance, sandwich, summed_scores
from symgen.estimation.solve import (
    PASSES,
    SINGULAR,
    Solution,
    column_norms,
    inverse_information,
    merged,
    require_rows,
    residual_weights,
    reweighted,
    sum_of_scores,
    undetermined,
    weighted_least_squares,
    weighted_triangle,
)
from symgen.estimation.summary import summaries, summarise, triangle
from symgen.estimation.system import Equations, Rows
from symgen.estimation.torque_error import percent
from symgen.estimation.values import Endogeneity, FloatArray, OtherEstimate
from symgen.policy import BEYOND, KNOWN

#: A column is not tested if the instruments leave less than this share of it unexplained.
_SUSPECT = 1e-7
#: Significance level of the Durbin-Wu-Hausman test for bias.
SIGNIFICANCE = 0.01
#: Instruments are weak if their correlation with a direction of W is below this.
_WEAK = 0.3
#: Share of a parameter from which a bias matters.
_MATERIAL = 0.05
_UNTESTED = "no Durbin-Wu-Hausman test: the logs hold too few independent equations"


@dataclass(frozen=True)
class InstrumentalVariables:
    """Instrumental variables X = (Z'W)^-1 Z'y, with a weight a log from its residual deviation.

    Its covariance is the sandwich with instruments, (Z'W)^-1 S (W'Z)^-1, with S the long-run
    covariance of z e. The solution also contains weighted least squares and the Durbin-Wu-Hausman
    test.

    Attributes:
        plain: weighted least squares of the same equations, if already solved.
    """

    plain: Solution | None = None
    name: ClassVar[str] = "iv"
    excludes: ClassVar[str] = (
        "bias where the noise of the instruments is not independent of that of the regressor, and "
        "errors of the model"
    )

    def solve(self, rows: Rows) -> Solution:
        """Solve y = W X with the instruments of the rows.

        Raises:
            IdentificationError: there are no instruments, or they do not follow the regressor.
        """
        require_rows(rows)
        if rows.Z is None:
            raise IdentificationError(
                "method iv needs instruments; accepted: logs with measured speeds qd, whose "
                "instruments come from the encoders, or the commanded motion of every log"
            )
        plain = self.plain or weighted_least_squares(rows)
        equations, names = rows.parts, rows.names
        parts = summaries(equations)
        weights, reduced = reweighted(
            partial(_Reduced.of, equations, names),
            lambda x: residual_weights(parts, x.X),
            np.array(plain.weights),
            PASSES if len(parts) > 1 else 0,
        )
        X, A = reduced.X, reduced.Rz.T @ reduced.Rzw
        bread = np.linalg.inv(A) / np.outer(reduced.scale, reduced.size)
        scores, crosses = [], []
        for e, w in zip(equations, weights, strict=True):
            Z, error = _z(e), w**2 * e.residual(X)
            scores.append(error[:, None] * Z)
            functions = Z if e.features is None else np.hstack([Z, e.features])
            crosses.append(Z.T @ functions)
        meat = summed_scores(scores, parts)
        test = durbin_wu_hausman(rows, weights)
        notes = [] if test is not None else [_UNTESTED]
        if reduced.shared < _WEAK:
            notes.append(
                "weak instruments: a combination of columns has a correlation of "
                f"{reduced.shared:.2g} with them; its estimate is uncertain, also beyond its std"
            )
        return Solution(
            X,
            *robust_covariance(X, bread, meat, parts, weights, crosses),
            float(np.linalg.cond(A)),
            tuple(map(float, weights)),
            tuple(notes),
            () if test is None else (test,),
            (OtherEstimate.by("wls", names, plain.X, plain.std),),
        )


def _z(equations: Equations) -> FloatArray:
    """Return the instruments of equations that have them."""
    assert equations.Z is not None
    return equations.Z


@dataclass(frozen=True, eq=False)
class _Reduced:
    """Weighted [Z W y] = Q [Rz Rzw rzy; 0 Rv rv], with columns of Z and W of unit norm.

    Attributes:
        X: the instrumental-variables estimate, (p,).
        size, scale: norms of the columns of Z and of W, (p,).
        Rz, Rzw, Rv: (p, p); Q'W is [Rzw; Rv], and Rv is the triangle of the part of W that Z does
            not explain.
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
    def of(
        cls, equations: Sequence[Equations], names: tuple[str, ...], weights: FloatArray
    ) -> _Reduced:
        """Reduce equations with instruments, one weight a log."""
        p = len(names)
        parts = []
        for e in equations:
            both = np.column_stack([_z(e), e.W])
            parts.append(summarise(replace(e, W=both, features=None)))
        factor = weighted_triangle(parts, weights)
        R, y = factor[:, :-1], factor[:p, -1]
        norms = column_norms(R)
        Rz, of_W = np.hsplit(R / norms, 2)
        Rz, Rzw, Rv = Rz[:p], of_W[:p], of_W[p : 2 * p]
        Rw = triangle(of_W)
        lost = undetermined(Rw, names)
        if lost:
            raise IdentificationError(lost)
        common = np.linalg.solve(Rw.T, Rzw.T)
        canonical = np.linalg.svd(common, compute_uv=False)
        shared = float(canonical[-1])
        if undetermined(Rz, names) or shared <= SINGULAR:
            raise IdentificationError(
                "the information matrix is singular: these instruments do not determine the "
                "parameters"
            )
        size, scale = np.split(norms, 2)
        X = np.linalg.solve(Rzw, y) / scale
        return cls(X, size, scale, Rz, Rzw, Rv, shared)


def durbin_wu_hausman(rows: Rows, weights: FloatArray) -> Endogeneity | None:
    """Test whether least squares is biased.

    F is the Wald statistic of d = 0 over its degrees of freedom, with the covariance that is robust
    to correlated residuals.

    Args:
        rows: rows with instruments.
        weights: one for each log and joint.

    Returns:
        The test; None if the instruments explain every column, or if the logs contain too few
        equations.
    """
    equations, names = rows.parts, rows.names
    p, reduced = len(names), _Reduced.of(equations, names, weights)
    scale = reduced.scale
    # V = (W - Z explained) / scale, in an orthonormal basis of its columns
    explained = np.linalg.solve(reduced.Rz * reduced.size, reduced.Rzw * scale)
    _, singular, turn = np.linalg.svd(reduced.Rv)
    kept = singular > _SUSPECT
    basis = (turn[kept] / scale).T / singular[kept]
    extra = basis.shape[1]
    if extra == 0:
        return None
    augmented = []
    for e, w in zip(equations, weights, strict=True):
        V = (e.W - _z(e) @ explained) @ basis
        W = w * np.column_stack([e.W, V])
        augmented.append(Equations(W, w * e.y, e.correlation, e.joint))
    parts, even = summaries(augmented), np.ones(len(augmented))
    freedom = sum(s.independent for s in parts) - p - extra
    if freedom < 1:
        return None
    try:
        known = (*names, *["d"] * extra)
        X, scale, R = merged(parts, even, known)
    except IdentificationError:
        return None
    meat = sum_of_scores(augmented, parts, even, X)
    bread = inverse_information(scale, R)
    covariance = sandwich(bread, meat, parts)[p:, p:]
    count = int(np.linalg.matrix_rank(covariance, hermitian=True))
    rounding = extra * np.finfo(float).eps  # as in the rank
    d, precision = X[p:], np.linalg.pinv(covariance, rounding, hermitian=True)
    size = d @ precision @ d
    statistic = float(size) / count
    return Endogeneity("all", statistic, (count, freedom), _f_tail(statistic, count, freedom))


def bias_of_least_squares(
    rows: Rows, solution: Solution, wls: Solution | None = None
) -> tuple[Solution, str]:
    """Compare weighted least squares with instrumental variables, if there are instruments.

    Args:
        rows: the equations that were solved.
        solution: the solution by a method that treats the regressor as exact.
        wls: weighted least squares of these equations, if already solved.

    Returns:
        The solution with tests and comparison, and a text on a bias that the intervals do not
        contain, or "". Such a bias is significant, above 3 std, and above 5 % of a parameter that
        is known to 30 %.
    """
    if rows.Z is None:
        return solution, ""
    try:
        other = InstrumentalVariables(wls).solve(rows)
    except IdentificationError:
        return replace(solution, notes=(*solution.notes, _UNTESTED)), ""
    spread, size = other.std, np.abs(other.X)
    compared = replace(
        solution,
        notes=(*solution.notes, *other.notes),
        endogeneity=other.endogeneity,
        comparison=(*solution.comparison, OtherEstimate.by("iv", rows.names, other.X, spread)),
    )
    plain = other.comparison[0]
    moves = np.abs(other.X - plain.X)
    known = (spread < KNOWN * size) & (moves > _MATERIAL * size)
    certain = any(test.p_value < SIGNIFICANCE for test in other.endogeneity)
    certain_of = known & (plain.std > 0)
    ratio = np.where(certain_of, moves / np.maximum(plain.std, 1e-300), 0.0)
    largest = int(np.argmax(ratio))
    if not certain or ratio[largest] <= BEYOND:
        return compared, ""
    return compared, (
        f"plain least squares is biased by noise in the speeds: {rows.names[largest]} by "
        f"{ratio[largest]:.2g} std, {percent(moves[largest] / size[largest])}; compare method iv"
    )


def _f_tail(statistic: float, numerator: float, denominator: float) -> float:
    """Return the probability that F(numerator, denominator) exceeds a value."""
    from scipy.special import fdtrc

    return float(fdtrc(numerator, denominator, max(statistic, 0.0)))
