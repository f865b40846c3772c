"""Instrumental variables: no bias from noise in the regressor; and a test of whether there is any.

Least squares is biased where the columns of W carry noise that is also in y - W X. Instruments Z
(as large as W) that follow the true motion but not this noise give an estimate without the bias,

    X = (Z'W)^-1 Z'y            (Young 1970; Janot, Vandanjon, Gautier 2014)

Where Z comes from is said in `instruments`. The Durbin-Wu-Hausman test asks whether what Z does not
explain of W helps to explain y (Hausman 1978; Davidson and MacKinnon 1993, section 7.9):

    y = W X + V d + e,   V = W - Z (Z'Z)^-1 Z'W,   d = 0 where least squares is consistent
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from symgen.errors import IdentificationError
from symgen.estimation.estimators import PASSES, Wls
from symgen.estimation.fold import triangle
from symgen.estimation.regression import (
    SINGULAR,
    Solution,
    column_norms,
    inverse_deviation,
    require_rows,
    robust_covariance,
    undetermined,
)
from symgen.estimation.statistics import f_tail
from symgen.estimation.system import Equations, LinearSystem
from symgen.estimation.values import Contrast, Endogeneity

FloatArray = NDArray[np.float64]
#: Columns whose part that the instruments leave is smaller than this share are not suspect.
_SUSPECT = 1e-7
#: Level of the Durbin-Wu-Hausman test below which least squares is called biased.
LEVEL = 0.01
_HARMLESS = 0.5  # bias, of a standard deviation
#: Correlation of a direction of W with the instruments under which they are called weak.
_WEAK = 0.3
#: A bias that intervals do not hold: in std, and as a share of a parameter known to another share.
_BEYOND, _MATERIAL, _KNOWN = 3.0, 0.05, 0.3
_UNTESTED = "no Durbin-Wu-Hausman test: the logs hold too few independent equations"
_FRICTION = re.compile(r"(FS|FV|OF)M?[0-9]")


@dataclass(frozen=True)
class InstrumentalVariables:
    """Instrumental variables X = (Z'W)^-1 Z'y, logs weighed by the deviation of their residual.

    Its covariance is the sandwich with instruments, (Z'W)^-1 S (W'Z)^-1 with S the long-run
    covariance of z e. Beside it stand weighted least squares and the Durbin-Wu-Hausman test.
    """

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
        least = Wls().solve(system)
        parts = [triangle(np.column_stack([_z(e), e.W, e.y])) for e in system.logs]
        weights: FloatArray = np.array(least.weights)
        reduced = _Reduced(parts, weights, system)
        for _ in range(PASSES if len(parts) > 1 else 0):
            p = len(reduced.X)
            rss = [float(np.sum((f[:, 2 * p] - f[:, p : 2 * p] @ reduced.X) ** 2)) for f in parts]
            weights = inverse_deviation(np.sqrt(np.array(rss) / [len(e.y) for e in system.logs]))
            reduced = _Reduced(parts, weights, system)
        scale, size = reduced.scale, reduced.size
        scores = [
            (w * w * (e.y - e.W @ reduced.X))[:, None] * (_z(e) / size)
            for w, e in zip(weights, system.logs, strict=True)
        ]
        A = reduced.Rz.T @ reduced.Rzw
        bread = np.asarray(np.linalg.inv(A), dtype=float)
        covariance = robust_covariance(system, bread, scores) / np.outer(scale, scale)
        tests = durbin_wu_hausman(system, weights)
        std = np.sqrt(np.maximum(np.diag(least.covariance), 0))
        notes = tuple(in_words(t, system.names, least.X, std, reduced.X) for t in tests[:1])
        notes = notes or (_UNTESTED,)
        if reduced.shared < _WEAK:
            notes += (
                "weak instruments: a combination of columns has a correlation of "
                f"{reduced.shared:.2g} with them; its estimate is uncertain, also beyond its std",
            )
        return Solution(
            reduced.X,
            covariance,
            float(np.linalg.cond(A)),
            tuple(map(float, weights)),
            notes,
            tests,
            (Contrast("wls", least.X, std),),
        )


def _z(equations: Equations) -> FloatArray:
    """Return the instruments, which were asked for before."""
    assert equations.Z is not None
    return equations.Z


class _Reduced:
    """Weighted [Z W y] = Q [Rz Rzw rzy; 0 Rv rv], with columns of Z and W of unit norm.

    Q'W is [Rzw; Rv], and Rv is the triangle of what Z leaves of W.
    """

    def __init__(
        self, parts: Sequence[FloatArray], weights: FloatArray, system: LinearSystem
    ) -> None:
        p = len(system.names)
        R = triangle(np.concatenate([w * f for w, f in zip(weights, parts, strict=True)]))
        norms = column_norms(R[:, : 2 * p])
        self.size, self.scale = norms[:p], norms[p:]
        R[:, : 2 * p] /= norms
        self.Rz, self.Rzw, self.Rv = R[:p, :p], R[:p, p : 2 * p], R[p : 2 * p, p : 2 * p]
        Rw = triangle(R[:, p : 2 * p])
        lost = undetermined(Rw, system.names)
        if lost:
            raise IdentificationError(lost)
        canonical = np.linalg.svd(np.linalg.solve(Rw.T, self.Rzw.T), compute_uv=False)
        #: Smallest canonical correlation of W with Z.
        self.shared = float(canonical[-1])
        if undetermined(self.Rz, system.names) or self.shared <= SINGULAR:
            raise IdentificationError(
                "the information matrix is singular: these instruments do not determine the "
                "parameters"
            )
        self.X: FloatArray = np.linalg.solve(self.Rzw, R[:p, 2 * p]) / self.scale


def durbin_wu_hausman(system: LinearSystem, weights: FloatArray) -> tuple[Endogeneity, ...]:
    """Test whether least squares is biased, for all columns, the inertial and the friction ones.

    F is the Wald statistic of d = 0 over its degrees of freedom, with the covariance that is robust
    to correlated residuals.

    Args:
        system: equations with instruments.
        weights: one a log.

    Returns:
        The tests; none where no column differs from what the instruments explain of it, or where
        the logs hold too few equations to test all of them together.
    """
    parts = [triangle(np.column_stack([_z(e), e.W, e.y])) for e in system.logs]
    reduced = _Reduced(parts, weights, system)
    left = np.linalg.norm(reduced.Rv, axis=0)
    suspect = left > _SUSPECT
    friction = np.array([_FRICTION.match(name) is not None for name in system.names])
    sets = {"all": suspect, "inertial": suspect & ~friction, "friction": suspect & friction}
    # V = [Z W] onto, in the units of the data
    explained = np.linalg.solve(reduced.Rz, reduced.Rzw)
    onto = np.concatenate([-explained / reduced.size[:, None], np.diag(1 / reduced.scale)])
    out = []
    for label, chosen in sets.items():
        if chosen.any() and (label == "all" or (chosen != suspect).any()):
            # an orthonormal basis of the suspect columns: what is tested is their span
            _, singular, turn = np.linalg.svd(reduced.Rv[:, chosen] / left[chosen])
            kept = singular > 1e-6 * singular[0]
            basis = onto[:, chosen] / left[chosen] @ (turn[kept].T / singular[kept])
            test = _wald(system, label, weights, reduced.scale, basis)
            if test is None:  # some columns alone do not say that nothing is biased
                break
            out.append(test)
    return tuple(out)


def _wald(
    system: LinearSystem, label: str, weights: FloatArray, scale: FloatArray, basis: FloatArray
) -> Endogeneity | None:
    p, extra = basis.shape[0] // 2, basis.shape[1]
    freedom = sum(len(e.y) / e.correlation for e in system.logs) - p - extra
    if freedom < 1:
        return None
    rows = [
        w * np.column_stack([e.W / scale, np.column_stack([_z(e), e.W]) @ basis, e.y])
        for w, e in zip(weights, system.logs, strict=True)
    ]
    whole = triangle(np.concatenate([triangle(r) for r in rows]))
    R = whole[: p + extra, : p + extra]
    singular = np.linalg.svd(R, compute_uv=False)
    if singular[-1] <= SINGULAR * singular[0]:
        return None
    found = np.linalg.solve(R, whole[: p + extra, -1])
    scores = [(r[:, -1] - r[:, :-1] @ found)[:, None] * r[:, :-1] for r in rows]
    inverse = np.linalg.inv(R)
    covariance = robust_covariance(system, inverse @ inverse.T, scores)[p:, p:]
    values, vectors = np.linalg.eigh(covariance)
    kept = values > 1e-12 * values[-1]
    size = float(np.sum((vectors[:, kept].T @ found[p:]) ** 2 / values[kept]))
    count = int(kept.sum())
    statistic = size / count
    return Endogeneity(label, statistic, (count, freedom), f_tail(statistic, count, freedom))


def bias_of_least_squares(system: LinearSystem, solution: Solution) -> tuple[Solution, str]:
    """Compare weighted least squares with instrumental variables, where there are instruments.

    Args:
        system: the equations that were solved.
        solution: by a method that takes the regressor as exact.

    Returns:
        The solution with tests and comparison, and in words a bias that the intervals do not hold,
        or "": significant, above 3 std, and above 5 % of a parameter that is known to 30 %.
    """
    if any(e.Z is None for e in system.logs):
        return solution, ""
    try:
        other = InstrumentalVariables().solve(system)
    except IdentificationError:
        return replace(solution, notes=(*solution.notes, _UNTESTED)), ""
    spread = np.sqrt(np.maximum(np.diag(other.covariance), 0))
    compared = replace(
        solution,
        notes=(*solution.notes, *other.notes),
        endogeneity=other.endogeneity,
        comparison=(*solution.comparison, Contrast("iv", other.X, spread)),
    )
    least = other.comparison[0]
    moves = np.abs(other.X - least.X)
    known = (spread < _KNOWN * np.abs(other.X)) & (moves > _MATERIAL * np.abs(other.X))
    certain = bool(other.endogeneity) and other.endogeneity[0].p_value < LEVEL
    ratio = np.where(known & (least.std > 0), moves / np.where(least.std > 0, least.std, 1.0), 0.0)
    worst = int(np.argmax(ratio))
    if not certain or ratio[worst] <= _BEYOND:
        return compared, ""
    share = 100 * moves[worst] / abs(other.X[worst])
    return compared, (
        f"plain least squares is biased by noise in the speeds: {system.names[worst]} by "
        f"{ratio[worst]:.2g} std, {share:.2g} %; compare method iv"
    )


def in_words(
    test: Endogeneity, names: Sequence[str], X: FloatArray, std: FloatArray, other: FloatArray
) -> str:
    """Say what a test found, and by how much another estimate moves X at most, in its std.

    Large logs make a bias certain that is far below the standard deviations: that is said, too.
    """
    moves = np.abs(other - X) / np.where(std > 0, std, np.inf)
    worst = int(np.argmax(moves))
    size = f"at most {moves[worst]:.2g} std of it, for {names[worst]}"
    figures = f"F({test.df[0]}, {test.df[1]:.0f}) = {test.statistic:.3g}, p = {test.p_value:.2g}"
    if test.p_value >= LEVEL:
        return f"no bias of plain least squares is seen: {size} ({figures})"
    known = "is biased" if moves[worst] > _HARMLESS else "is biased, though by less than matters"
    return f"plain least squares {known}: {size} ({figures})"
