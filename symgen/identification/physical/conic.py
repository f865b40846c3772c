"""The conic solver: quadratic objective, affine equations, signs and semidefinite matrices.

    minimise 1/2 y'P y + c'y   with   E y + f = 0, >= 0, a positive semidefinite matrix,
                                      or (a, b, c) with b exp(a/b) <= c

by Clarabel (Goulart and Chen 2024). Symmetric matrices are vectors: the upper triangle column by
column, off-diagonal entries times sqrt(2), so that tr(A B) is a scalar product.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.errors import ParameterError

FloatArray = NDArray[np.float64]
_SOLVED = ("Solved", "AlmostSolved")  # to the accuracy, or to a hundred times it
_ACCURACY = 1e-10


@dataclass(frozen=True, eq=False)
class Cone:
    """E y + f lies in a cone; E (m, n), f (m,).

    kind is "zero", "nonnegative", "semidefinite" or "exponential".
    """

    kind: str
    E: FloatArray
    f: FloatArray


def triangle_vector(matrix: FloatArray) -> FloatArray:
    """Return a symmetric matrix (m, m) as a vector (m (m + 1)/2,)."""
    rows, columns = np.triu_indices(len(matrix))
    order = np.lexsort((rows, columns))
    rows, columns = rows[order], columns[order]
    scaled: FloatArray = matrix[rows, columns] * np.where(rows == columns, 1.0, np.sqrt(2.0))
    return scaled


def minimise(
    P: FloatArray, c: FloatArray, cones: Sequence[Cone]
) -> tuple[FloatArray, list[FloatArray]]:
    """Return the minimiser y (n,), and the dual vector of every cone.

    Args:
        P: positive semidefinite (n, n).
        c: (n,).
        cones: what y obeys.

    Raises:
        ParameterError: Clarabel finds no solution.
    """
    import clarabel
    from scipy.sparse import csc_matrix

    kinds = {
        "zero": clarabel.ZeroConeT,
        "nonnegative": clarabel.NonnegativeConeT,
        "exponential": lambda _: clarabel.ExponentialConeT(),
        "semidefinite": lambda m: clarabel.PSDTriangleConeT(round((2 * m + 0.25) ** 0.5 - 0.5)),
    }
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    for name in ("gap_abs", "gap_rel", "feas"):
        setattr(settings, f"tol_{name}", _ACCURACY)
        setattr(settings, f"reduced_tol_{name}", 100 * _ACCURACY)
    solver = clarabel.DefaultSolver(
        csc_matrix(np.triu(P)),
        c,
        csc_matrix(-np.concatenate([cone.E for cone in cones])),
        np.concatenate([cone.f for cone in cones]),
        [kinds[cone.kind](len(cone.f)) for cone in cones],
        settings,
    )
    solution = solver.solve()
    if str(solution.status) not in _SOLVED:
        raise ParameterError(f"the solver Clarabel ends with {solution.status}")
    ends = np.cumsum([len(cone.f) for cone in cones])[:-1]
    return np.array(solution.x), np.split(np.array(solution.z), ends)
