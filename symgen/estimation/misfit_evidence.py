"""Evidence of columns beside what a model may miss of any shape: by restricted likelihood.

    y_j = W_j X + C_j b + F_j c_j + e_j,    cov c_j = s_j^2 D,    cov e_j = v_j

with F_j the random functions of the state (`features`). A model that misses a little misses it
everywhere alike: a few functions of the state, not as many independent errors as there are rows.
Columns are shown only by what they explain better than such functions. The evidence is

    log p(y | W and C) - log p(y | W),

with X, b, s_j and the share of friction in D integrated out, and v_j at its most probable value.
s_j has the half-Cauchy law (Gelman 2006), its scale the misfit to expect. b has the density that
Student's t with 3 degrees of freedom has at zero: a large b costs in the search. Rows count as in
the predictive score.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from symgen.estimation.features import WAVES, mixtures
from symgen.estimation.predictive_score import TEMPERATURE, Columns
from symgen.estimation.values import FloatArray

#: Sizes of the misfit over that to expect.
_SIZES = np.geomspace(0.03, 3000.0, 201)
_TURNS = 3  # of the sizes of several joints
_SWEEPS = 3  # of the variance of the rows, for a misfit of which half is friction
_EVEN = np.ones((1, 2 * WAVES))
_DEPENDENT = 1e-9  # of a column: what is left of it beside the others
#: Of a coefficient: log of the density of Student's t at zero, and of (2 pi)^(1/2).
_OCCAM = math.log(2 / (math.pi * math.sqrt(3.0)) * math.sqrt(2 * math.pi))


@dataclass(frozen=True, eq=False)
class MisfitEvidence:
    """The rows of a model, and the random functions that stand for its misfit.

    Attributes:
        W: (K, n, p) regressor.
        residual: (K, n) of y - W X.
        weight: (K, n) of the rows; 0.0 for those without a say.
        sigma: (n,) standard deviation of each joint's residual.
        features: (K, n, m) random functions.
        misfit: (n,) to expect, which rows are never righter than, N m or N.
    """

    W: FloatArray
    residual: FloatArray
    weight: FloatArray
    sigma: FloatArray
    features: FloatArray
    misfit: FloatArray
    _alone: dict[tuple[int, ...], float] = field(default_factory=dict)

    @cached_property
    def _rows(self) -> FloatArray:
        """Weighted rows [W, F, y] of each joint, W of unit columns, (n, K, p + m + 1)."""
        misfit = self.features * self.misfit[:, None]
        W = self.W / self._norms
        whole = np.concatenate([W, misfit, self.residual[:, :, None]], axis=2)
        return np.ascontiguousarray(np.moveaxis(whole * self.weight[:, :, None], 1, 0))

    @cached_property
    def _norms(self) -> FloatArray:
        rows = self.W * (self.weight / self.sigma)[:, :, None]
        norms = np.sqrt(np.sum(rows**2, axis=(0, 1)))
        return np.where(norms > 0, norms, 1.0)

    @cached_property
    def _products(self) -> FloatArray:
        """(n, p + m + 1, p + m + 1) products of the rows of each joint."""
        return np.asarray(self._rows.swapaxes(1, 2) @ self._rows) / TEMPERATURE

    @cached_property
    def _counts(self) -> FloatArray:
        return np.asarray(np.maximum(np.sum(self.weight**2, axis=0) / TEMPERATURE, 1.0))

    def units(self, columns: Columns, sizes: FloatArray) -> FloatArray:
        """Return the coefficients (m,) at which columns have torques of some sizes.

        Args:
            columns: by position of the joint.
            sizes: (n,) RMS torque of each joint, which one joint has and no other exceeds.
        """
        weight, none = self.weight, np.zeros(next(iter(columns.values())).shape[1])
        squares = [
            np.sum((c * weight[:, [j]]) ** 2, axis=0) / np.sum(weight[:, j] ** 2) / sizes[j] ** 2
            for j, c in columns.items()
            if weight[:, j].any()
        ]
        largest = np.sqrt(np.max([none, *squares], axis=0))
        return np.asarray(1 / np.where(largest > 0, largest, 1.0))

    def of(self, columns: Columns, units: FloatArray, among: Iterable[int] | None = None) -> float:
        """Return the evidence of columns (K, m) on some joints, nats.

        Args:
            columns: by position of the joint.
            units: (m,) coefficients to expect.
            among: joints that have a misfit; None for those of the columns. Columns of different
                joints compare only among the same.
        """
        joints = tuple(columns if among is None else among)
        if joints not in self._alone:
            self._alone[joints] = self._likelihood(joints, self._products)
        m, p = len(units), self.W.shape[2]
        whole = np.insert(np.insert(self._products, [p] * m, 0.0, axis=1), [p] * m, 0.0, axis=2)
        for j, c in columns.items():
            own = c * units * self.weight[:, [j]]
            W, rest = np.split(self._rows[j], [p], axis=1)
            cross = own.T @ np.hstack([W, own, rest]) / TEMPERATURE
            whole[j, p : p + m], whole[j, :, p : p + m] = cross, cross.T
        return self._likelihood(joints, whole, m) - self._alone[joints]

    def _likelihood(self, joints: tuple[int, ...], products: FloatArray, more: int = 0) -> float:
        """Return log p(y) where some joints have a misfit.

        Args:
            joints: their positions.
            products: of the rows [W, C, F, y] of each joint.
            more: number of columns C.
        """
        from scipy.linalg import block_diag

        at, p = list(joints), self.W.shape[2]
        q, own = p + more, products[at]
        A, FA, FF = own[:, :q, :q], own[:, q:-1, :q], own[:, q:-1, q:-1]
        a, Fy, yy = own[:, :q, -1], own[:, q:-1, -1], own[:, -1, -1]
        loose = np.diag(np.repeat([_DEPENDENT, 1.0], [p, more]))
        least, v = self.misfit**2, np.maximum(self.sigma, self.misfit) ** 2
        for last in (*[False] * _SWEEPS, True):
            H = np.einsum("jab,j->ab", products[:, :q, :q], 1 / v) + loose
            h = np.einsum("ja,j->a", products[:, :q, -1], 1 / v)
            B = np.concatenate(FA / v[at, None, None])
            HB, Hh = np.linalg.solve(H, B.T), np.linalg.solve(H, h)
            G = block_diag(*(FF / v[at, None, None])) - B @ HB
            z = (Fy / v[at, None]).ravel() - B @ Hh
            fits, c = _integrated(G, z, mixtures() if last else _EVEN, len(at))
            b, c = Hh - HB @ c, c.reshape(len(at), -1)
            if last:
                break
            left = yy - 2 * a @ b + np.einsum("a,jab,b->j", b, A, b)
            left -= np.sum(c * (Fy - FA @ b), axis=1)
            v[at] = np.maximum(left / self._counts[at], least[at])
        noise = np.sum(products[:, -1, -1] / v) - h @ Hh + np.sum(self._counts[at] * np.log(v[at]))
        drawn = float(b[p:] @ b[p:])  # to zero, which only keeps b determined
        flat = noise - drawn + np.linalg.slogdet(H)[1]
        return fits - 0.5 * float(flat) + more * _OCCAM


def _integrated(
    G: FloatArray, z: FloatArray, mixed: FloatArray, n: int
) -> tuple[float, FloatArray]:
    """Return the log of the mean over s_1 .. s_n and D of p(z), over p(z | s = 0).

        cov z = G + G T G,    T = blocks of s_j^2 D

    Each size is integrated with the others at their most probable values.

    Returns:
        It, and the c of the most probable s and D.
    """
    found = []
    for D in mixed:
        d = np.sqrt(np.tile(D, n))
        value, c = _sized(G * np.outer(d, d), z * d, n)
        found.append((value, d * c))
    values = np.array([value for value, _ in found])
    return float(np.logaddexp.reduce(values) - np.log(len(values))), found[values.argmax()][1]


def _sized(G: FloatArray, z: FloatArray, n: int) -> tuple[float, FloatArray]:
    """Return the log of the mean over the sizes of p(z), and the most probable c, for D = 1."""
    blocks, squares = np.arange(len(z)).reshape(n, -1), _SIZES[:, None] ** 2
    prior = np.log(_SIZES / (1 + _SIZES**2))
    widths = most = rest = 0.0
    at = np.full(n, int(np.abs(_SIZES - 1).argmin()))
    for _ in range(_TURNS if n > 1 else 1):
        widths = 0.0
        for j, own in enumerate(blocks):
            others = np.delete(blocks, j, axis=0).ravel()
            scale = np.repeat(np.delete(_SIZES[at], j), blocks.shape[1])
            B = np.eye(len(others)) + G[np.ix_(others, others)] * np.outer(scale, scale)
            own_by, shown_by = G[np.ix_(others, own)] * scale[:, None], z[others] * scale
            explained = np.linalg.solve(B, np.column_stack([own_by, shown_by]))
            left = G[np.ix_(own, own)] - own_by.T @ explained[:, :-1]
            shown, ways = np.linalg.eigh(left)
            shown, along = np.maximum(shown, 0.0), ways.T @ (z[own] - own_by.T @ explained[:, -1])
            taken = squares / (1 + squares * shown)
            fits = prior + 0.5 * np.sum(taken * along**2 - np.log1p(squares * shown), axis=1)
            at[j], most = int(fits.argmax()), float(fits.max())
            widths += float(np.logaddexp.reduce(fits)) - most
            rest = 0.5 * float(shown_by @ explained[:, -1] - np.linalg.slogdet(B)[1])
    # The highest value, times the width of its peak along the size of each joint.
    whole = most + widths + rest + float(np.sum(prior[at[:-1]])) - n * np.log(len(_SIZES))
    scale = np.repeat(_SIZES[at], blocks.shape[1])
    S = np.eye(len(z)) + G * np.outer(scale, scale)
    return whole, scale * np.linalg.solve(S, scale * z)
