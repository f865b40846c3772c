"""The size of the noise and of the model misfit of an estimate, by restricted likelihood.

    y_j = W_j X + F_j c_j + e_j,    c_jk of variance s_jk^2,    e_j of variance sigma_j^2

for every joint j, with F_j the random functions of the state (`features`). They are one function
for each joint, the same in all logs. Rows that share samples count once. sigma_j^2 is that of the
part of y_j that W_j does not explain (Patterson and Thompson 1971). The s_jk^2 have one size for
smooth functions and one for friction. They are estimated from the products of F_j with the
residual, given the noise of all joints and the misfit of the others.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from symgen.estimation.features import mixtures
from symgen.estimation.summary import Summary, inverse_root
from symgen.estimation.values import FloatArray

_RANK = 1e-10  # relative; smaller eigenvalues of the products of W are zero
_ROUNDING = 1e-7  # relative; smaller eigenvalues of the products of F are zero
#: The same for misfits. A smaller direction may be torque that is no sum of these functions, which
#: would look like a large misfit. Chosen on runs of interval_study.py, --seed 61000.
_SHOWN = 1e-4
_SWEEPS = 3  # over the joints, since the misfit of one affects the estimates of the others
#: Variances of a misfit over that of noise, in the direction with the largest misfit.
_RATIOS = np.geomspace(1e-4, 1e6, 101)


class Products(NamedTuple):
    """Products of the weighted equations of one joint.

    Attributes:
        rows: number of equations.
        independent: approximate number of rows that share no samples.
        gram: [W F y]'[W F y], (p + m + 1, p + m + 1).
        cross: W'[W F], or Z'[Z F] of instruments Z, (p, p + m).
    """

    rows: int
    independent: float
    gram: FloatArray
    cross: FloatArray

    @classmethod
    def of_summary(cls, s: Summary, weight: float, cross: FloatArray | None = None) -> Products:
        """Return the products of a summary with one weight for all its rows.

        Args:
            s: the summary.
            weight: weight of its rows.
            cross: Z'[Z F] of unweighted instruments Z; None without any.
        """
        products = s.factor.T @ s.factor
        p = len(products) - 1
        F = s.features
        if F is None:
            F = np.zeros((0, p + 1))
        WF, others = F[:, :p], F[:, p:]
        FF, Fy = np.hsplit(others, [-1])
        rows = [
            [products[:p, :p], WF.T, products[:p, p:]],
            [WF, FF, Fy],
            [products[p:, :p], Fy.T, products[p:, p:]],
        ]
        gram = np.block(rows)
        cross = gram[:p, :-1] if cross is None else cross
        square = weight**2
        return cls(s.rows, s.independent, square * gram, square * cross)


def covariances(
    X: FloatArray, bread: FloatArray, parts: Iterable[tuple[int | None, Products]]
) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of an estimate from white noise, and from model misfit.

        A [sum over j of sigma_j^2 W_j'W_j] A'    and    sum over j of (A W_j'F_j) S_j (A W_j'F_j)'

    with S_j the diagonal of s_jk^2.

    Args:
        X: the estimate, (p,).
        bread: A (p, p), inverse derivative of the estimating equations.
        parts: joint and products of the equations of each log and joint.
    """
    of_joint: dict[int | None, Products] = {}
    for joint, part in parts:
        known = of_joint.get(joint)
        if known is not None:
            part = Products(*map(operator.add, known, part))
        of_joint[joint] = part
    joints, p = list(of_joint.values()), len(bread)
    noise = [noise_variance(products) for products in joints]
    pairs = zip(noise, joints, strict=True)
    scatter = np.zeros((p, p))
    for v, products in pairs:
        scatter += v * products.cross[:, :p]
    white = bread @ scatter @ bread.T
    moves = [bread @ products.cross[:, p:] for products in joints]
    misfit = np.zeros((len(joints), p, p))
    for _ in range(_SWEEPS if moves[0].size else 0):
        for j, (products, moved) in enumerate(zip(joints, moves, strict=True)):
            others = white + misfit.sum(axis=0) - misfit[j]
            variances = misfit_variances(products, X, moved, noise[j], others)
            misfit[j] = (moved * variances) @ moved.T
    return white, misfit.sum(axis=0)


def noise_variance(products: Products) -> float:
    """Return the noise variance sigma^2 of a joint by restricted likelihood; its rows count once.

    W leaves a residual of y and of F. With l_k the eigenvalues of F'F of this residual and z_k the
    components of y in their directions, z_k has the variance s^2 l_k + sigma^2. The part that F
    does not explain either has the variance sigma^2. s and sigma maximise the likelihood. The
    result is 0.0 if W and F explain y exactly.
    """
    p = len(products.cross)
    WW, WF_Wy, others = _blocks(products.gram, p)
    basis = inverse_root(WW, _RANK)
    projected = basis.T @ WF_Wy
    residual = others - projected.T @ projected
    FF, Fy, yy = _blocks(residual, -1)
    shown, directions = np.linalg.eigh(FF)
    of_F, *_ = _blocks(others, -1)
    nonzero = shown > _ROUNDING * np.trace(of_F)
    shown = shown[nonzero]
    along = directions[:, nonzero].T @ Fy[:, 0]
    z2 = along**2 / shown
    fitted = basis.shape[1] + len(z2)
    free = products.independent * max(1 - fitted / max(products.rows, 1), 0.0)
    freedom = free + len(z2)
    if freedom == 0:
        return 0.0
    rest = max(float(yy[0, 0] - z2.sum()), 0.0)
    ratios = np.append(0.0, _RATIOS)
    spread = 1 + np.outer(ratios, shown / shown.max(initial=0.0))
    squares = np.sum(z2 / spread, axis=1) + rest
    sigma2 = np.maximum(squares / freedom, 1e-300)
    likely = np.log(spread).sum(axis=1) + freedom * np.log(sigma2)
    return float(sigma2[likely.argmin()])


def _blocks(products: FloatArray, at: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the blocks of a symmetric matrix before a column, beside them, and after it."""
    before, after = slice(None, at), slice(at, None)
    return products[before, before], products[before, after], products[after, after]


def misfit_variances(
    products: Products, X: FloatArray, moved: FloatArray, noise: float, others: FloatArray
) -> FloatArray:
    """Return the misfit variances s_k^2 at a joint, (m,): their mean over the likelihood.

        u = F'(y - W X),    cov u = s^2 N D N' + V,    N = F'F - F'W A W'F

    V contains the noise of the joint and the errors of X that other joints cause. D is one of the
    mixtures of smooth functions and friction, with equal prior probabilities. The prior of s is
    half-Cauchy (Gelman 2006). Its scale is the s at which misfit equals noise in the direction of u
    with the largest misfit.

    Args:
        products: products of the joint.
        X: the estimate, (p,).
        moved: A W'F, the change of X from the misfit, (p, m).
        noise: sigma^2 of the joint.
        others: covariance of X from noise and from the misfit of other joints, (p, p).
    """
    p = len(X)
    of_F = products.gram[p:-1]
    FW, others_of_F = np.hsplit(of_F, [p])
    G, u = others_of_F[:, :-1], others_of_F[:, -1]
    moves = FW @ moved
    V = noise * (G - moves - moves.T)
    V += FW @ others @ FW.T
    values, vectors = np.linalg.eigh(V)
    nonzero = values > _SHOWN * noise * np.trace(G)
    if not nonzero.any():
        return np.zeros(len(u))
    kept = vectors[:, nonzero]
    whiten = (kept / np.sqrt(values[nonzero])).T
    residual = whiten @ (u - FW @ X)
    N = whiten @ (G - moves)
    sizes, fits = [], []
    for D in mixtures():
        directions, sizes_of_N, _ = np.linalg.svd(N * np.sqrt(D))
        shown = np.square(sizes_of_N)
        if not shown[0]:
            continue  # a joint at rest has no friction
        z2 = (directions.T @ residual) ** 2
        spread = 1 + np.outer(_RATIOS, shown / shown[0])
        cost = np.log(spread) + z2 / spread
        fits.append(-0.5 * cost.sum(axis=1))
        sizes.append(_RATIOS[:, None] / shown[0] * D)
    of_sizes = np.sqrt(_RATIOS) / (1 + _RATIOS)
    likely = of_sizes * np.exp(fits - np.max(fits))
    return np.asarray(np.einsum("sr,srm->m", likely / likely.sum(), sizes))
