"""Minimise a convex function over positive definite matrices by an interior-point method.

    minimise 1/2 y'P y + c'y - sum of w_k log det A_k(y)   with   A_k(y) positive definite,

and A_k(y) = E_k y + f_k. Newton steps minimise the function with barriers (Boyd and Vandenberghe
2004, section 11.3)

    1/2 y'P y + c'y - sum of (w_k + m_k) log det A_k(y)

for falling m_k. Every iterate satisfies the constraints, hence there is a result at any accuracy.
At a minimum with barriers, the matrices m_k A_k^-1 are feasible in the dual program, and the
function is at most sum of m_k dim A_k above its smallest value.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from symgen.estimation.values import FloatArray

#: Factor by which barriers fall.
_FALL = 0.1
#: A barrier falls until its matrix has an eigenvalue of this size: rounding is far below it.
_NEAR = 1e-10
#: Size of barriers that no longer matter, relative to the function.
_FAINT = 1e-13
#: Newton steps for each size of the barriers, and the decrease that ends them, relative to it.
_STEPS, _SETTLED = 30, 1e-4
#: A step is halved while the function rises at its end by more than this part of its first fall.
_RISE, _HALVINGS = 0.5, 20
#: Part of the diagonal that is added to the second derivatives.
_ROUNDING = 1e-14


@dataclass(frozen=True, eq=False)
class Positive:
    """Matrices A_k(y) = E_k y + f_k that are positive definite.

    Attributes:
        E: (K, d, d, n) symmetric slopes.
        f: (K, d, d) symmetric offsets.
        weight: weight w of log det A_k, a number or (K,).
    """

    E: FloatArray
    f: FloatArray
    weight: FloatArray | float = 0.0

    @classmethod
    def numbers(cls, E: FloatArray, f: FloatArray) -> Positive:
        """Return the constraints that the numbers E y + f are positive, E (K, n) and f (K,)."""
        return cls(E[:, None, None, :], f[:, None, None])

    def slopes(self, y: FloatArray) -> FloatArray:
        """Return R_k^-1 E_k R_k^-T (K, d, d, n) with R_k R_k' = A_k(y).

        Raises:
            LinAlgError: a matrix is not positive definite.
        """
        root = np.linalg.inv(np.linalg.cholesky(self.E @ y + self.f))
        half = np.einsum("kab,kbcn->kacn", root, self.E)
        return np.asarray(np.einsum("kdc,kacn->kadn", root, half))


class Minimum(NamedTuple):
    """The result of `minimise`.

    Attributes:
        y: (n,) variables, which satisfy the constraints.
        barriers: sizes m_k of the barriers of all constraints.
        gap: a linear function is at most this much above its smallest value, as dual matrices
            prove; infinite if the last Newton step is too long for this proof.
    """

    y: FloatArray
    barriers: FloatArray
    gap: float


def minimise(
    P: FloatArray, c: FloatArray, constraints: Sequence[Positive], y: FloatArray
) -> Minimum:
    """Return the minimum of 1/2 y'P y + c'y - sum of w_k log det A_k(y).

    Args:
        P: positive semidefinite matrix (n, n).
        c: vector (n,).
        constraints: matrices that are positive definite.
        y: (n,) variables that satisfy the constraints.
    """
    ends = np.cumsum([len(k.f) for k in constraints])
    barriers = np.full(ends[-1], np.inf)
    falling = barriers > 0
    while falling.any():
        size = max(1.0, abs(float(y @ P @ y / 2 + c @ y)))
        barriers[falling] = np.minimum(size, _FALL * barriers[falling])
        sizes = np.split(barriers, ends[:-1])
        weights = [k.weight + m for k, m in zip(constraints, sizes, strict=True)]
        y, step = _centred(P, c, constraints, weights, y, _SETTLED * float(barriers.min()))
        nearest = [np.linalg.eigvalsh(k.E @ y + k.f)[:, 0] for k in constraints]
        falling = (barriers > _FAINT * size) & (np.concatenate(nearest) > _NEAR)
    # After the next step, the dual matrices are m R^-T (I - S) R^-1, with S the slope along it.
    are_dual = all(np.linalg.norm(k.slopes(y) @ step) <= 1.0 for k in constraints)
    largest = max(k.f.shape[1] for k in constraints)
    gap = 2 * largest * float(barriers.sum()) if are_dual else np.inf
    return Minimum(y, barriers, gap)


def _centred(
    P: FloatArray,
    c: FloatArray,
    constraints: Sequence[Positive],
    weights: Sequence[FloatArray],
    y: FloatArray,
    enough: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the minimum of the function with barriers, and the next Newton step.

    The steps end where the function would fall by at most `enough`.
    """
    gradient, H = _derivatives(P, c, constraints, weights, y)
    for _ in range(_STEPS):
        size = np.sqrt(np.diag(H) + np.finfo(float).tiny)
        scaled = H / np.outer(size, size) + _ROUNDING * np.eye(len(y))
        step = -np.linalg.solve(scaled, gradient / size) / size
        fall = float(-gradient @ step)
        if not fall > enough:
            break
        for halvings in range(_HALVINGS):
            ahead = y + step / 2**halvings
            with suppress(np.linalg.LinAlgError):
                there = _derivatives(P, c, constraints, weights, ahead)
                if there[0] @ step < _RISE * fall:
                    break
        else:
            break
        y, (gradient, H) = ahead, there
    return y, step


def _derivatives(
    P: FloatArray,
    c: FloatArray,
    constraints: Sequence[Positive],
    weights: Sequence[FloatArray],
    y: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the gradient (n,) and the second derivatives (n, n) of the function with barriers."""
    gradient, H = P @ y + c, P.copy()
    for k, w in zip(constraints, weights, strict=True):
        slopes = k.slopes(y)
        gradient -= w @ np.trace(slopes, axis1=1, axis2=2)
        rows = (np.sqrt(w)[:, None, None, None] * slopes).reshape(-1, len(y))
        H += rows.T @ rows
    return gradient, H
