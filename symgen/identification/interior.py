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
#: Largest part of the way to the limit of the possible that a step takes.
_PART = 0.9
#: A step becomes shorter while the function rises at its end by more than this part of its fall.
_RISE, _SHORTEST = 0.5, 1e-9


@dataclass(frozen=True, eq=False)
class Positive:
    """Matrices A_k(y) = E_k y + f_k that are positive definite.

    Attributes:
        E: (K, d, d, n) symmetric slopes.
        f: (K, d, d) symmetric offsets.
        weight: weights w_k of log det A_k, (K,) or a number.
    """

    E: FloatArray
    f: FloatArray
    weight: FloatArray | float = 0.0

    @classmethod
    def numbers(cls, E: FloatArray, f: FloatArray) -> Positive:
        """Return the constraints that the numbers E y + f are positive, E (K, n) and f (K,)."""
        return cls(E[:, None, None, :], f[:, None, None])

    def at(self, y: FloatArray) -> FloatArray:
        """Return A_k(y), (K, d, d)."""
        return self.E @ y + self.f

    def whitened(self, y: FloatArray) -> FloatArray:
        """Return R_k^-1 E_k R_k^-T (K, d, d, n) with R_k R_k' = A_k(y).

        Raises:
            LinAlgError: a matrix is not positive definite.
        """
        K, d, _, n = self.E.shape
        root = np.linalg.inv(np.linalg.cholesky(self.at(y)))
        half = (root @ self.E.reshape(K, d, d * n)).reshape(K, d, d, n)
        turned = half.swapaxes(1, 2).reshape(K, d, d * n)
        out: FloatArray = (root @ turned).reshape(K, d, d, n)
        return out


class Minimum(NamedTuple):
    """The result of `minimise`.

    Attributes:
        y: (n,) variables, which satisfy the constraints.
        duals: dual matrices (K, d, d) of each set of constraints.
        gap: the function is at most this much above its smallest value, as feasible dual matrices
            prove; infinite if the last step of the search is too long for this proof.
    """

    y: FloatArray
    duals: list[FloatArray]
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
    barriers = [np.full(len(k.f), _size(P, c, y)) for k in constraints]
    while True:
        y, step = _centred(P, c, constraints, barriers, y)
        values = [k.at(y) for k in constraints]
        least = _FAINT * _size(P, c, y)
        falling = [
            (m > least) & (np.linalg.eigvalsh(A)[:, 0] > _NEAR)
            for m, A in zip(barriers, values, strict=True)
        ]
        if not any(some.any() for some in falling):
            break
        barriers = [np.where(some, _FALL * m, m) for some, m in zip(falling, barriers, strict=True)]
    gap = 0.0
    for k, m in zip(constraints, barriers, strict=True):
        turns = k.whitened(y) @ step  # the dual matrices after the step are m R^-T (I - turn) R^-1
        is_dual = np.linalg.eigvalsh(turns).max(initial=0.0) <= 1.0
        gap += float(m @ (k.f.shape[1] - np.trace(turns, axis1=1, axis2=2))) if is_dual else np.inf
    duals = [m[:, None, None] * np.linalg.inv(A) for m, A in zip(barriers, values, strict=True)]
    return Minimum(y, duals, gap)


def _size(P: FloatArray, c: FloatArray, y: FloatArray) -> float:
    """Return the size of the function without logarithms, at least 1."""
    return max(1.0, abs(float(y @ P @ y / 2 + c @ y)))


def _centred(
    P: FloatArray,
    c: FloatArray,
    constraints: Sequence[Positive],
    barriers: Sequence[FloatArray],
    y: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the minimum of the function with barriers, and the next Newton step from it."""
    weights = [k.weight + m for k, m in zip(constraints, barriers, strict=True)]
    enough = _SETTLED * min(m.min(initial=np.inf) for m in barriers)
    slopes = [k.whitened(y) for k in constraints]
    for _ in range(_STEPS):
        gradient, H = P @ y + c, P.copy()
        for w, slope in zip(weights, slopes, strict=True):
            gradient -= w @ np.trace(slope, axis1=1, axis2=2)
            rows = (np.sqrt(w)[:, None, None, None] * slope).reshape(-1, len(y))
            H += rows.T @ rows
        step = -_solve(H, gradient)
        fall = -gradient @ step
        if not fall > enough:
            break
        lowest = min(np.linalg.eigvalsh(slope @ step).min(initial=0.0) for slope in slopes)
        length = 1.0 if lowest > -_PART else -_PART / lowest
        while length > _SHORTEST:
            ahead = y + length * step
            with suppress(np.linalg.LinAlgError):
                slopes_ahead = [k.whitened(ahead) for k in constraints]
                rise = (P @ ahead + c) @ step
                for w, slope in zip(weights, slopes_ahead, strict=True):
                    rise -= w @ np.trace(slope, axis1=1, axis2=2) @ step
                if rise < _RISE * fall:
                    break
            length /= 2
        else:
            break
        y, slopes = ahead, slopes_ahead
    return y, step


def _solve(H: FloatArray, b: FloatArray) -> FloatArray:
    """Return H^-1 b for a positive definite H (n, n), whose rows may have very different sizes."""
    diagonal = np.diag(H)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = H / np.outer(size, size)
    scaled += len(H) * np.finfo(float).eps * np.eye(len(H))
    out: FloatArray = np.linalg.solve(scaled, b / size) / size
    return out
