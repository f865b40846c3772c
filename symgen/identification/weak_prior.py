"""A weak prior for what the training logs do not determine, and fits to folds with it.

A fit to some folds extrapolates where the others ask for directions of the parameters that these
folds do not determine. Its error can then be a hundred times the error on the training logs, and
says nothing about a model or a method. The prior holds such directions at small parameters:

    minimise |W X - y|^2 + z' T^-1 z   with   X = B z

z are the standard parameters in units of the robot. T is diagonal: one size for all parameters of
links, and one for each other kind (rotor inertia, Coulomb friction, ...). The sizes maximise the
probability of the training logs (MacKay 1992, "Bayesian interpolation"), so that the prior has no
effect on what the logs determine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from symgen import names
from symgen.codegen.model import Model
from symgen.estimation.solve import shortest_weights, weighted_triangle
from symgen.estimation.summary import BLOCKS, FOLDS, Blocks, Summary
from symgen.estimation.torque_error import relative_error
from symgen.estimation.values import FloatArray, Residual
from symgen.identification.possible import Constraints

#: Most rounds for the sizes, and relative change at which they have converged.
_ROUNDS, _CONVERGED = 200, 1e-2
#: Smallest size, and smallest eigenvalue of a matrix in units of its diagonal, as parts of the
#: largest.
_SMALLEST = 1e-12
#: Smallest squared size, in units of a robot of 1 kg: of logs that are noise alone, it falls to 0.
_NOISE = 1e-24
#: X (p,) and its covariance (p, p).
Fitted = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class WeakPrior:
    """A weak prior of base parameters, and the equations that it is for.

    Attributes:
        sigma: (m,) kinds of the equations.
        information: inverse (p, p) of the covariance of the prior; its mean is zero.
        factor: triangle of independent equations [W y] with a deviation of one, (p + 1, p + 1).
        precision: (m,) weight of the squared residual of each joint.
    """

    sigma: tuple[int, ...]
    information: FloatArray
    factor: FloatArray
    precision: FloatArray

    @classmethod
    def of(cls, model: Model, parts: Sequence[Summary]) -> WeakPrior:
        """Return the prior for equations.

        Args:
            model: model of the robot.
            parts: summaries of the equations, one for each log and joint.
        """
        shared = np.array([max(part.correlation, 1) for part in parts])
        weights = shortest_weights(parts) / np.sqrt(shared)
        factor = weighted_triangle(parts, weights)
        joints = np.array([part.joint or 0 for part in parts])
        precision = np.bincount(joints, weights**2) / np.bincount(joints)
        return cls(model.robot.kinds, _information(model, factor), factor, precision)

    @property
    def rows(self) -> FloatArray:
        """Equations of the prior with a deviation of one, (p, p + 1)."""
        return np.pad(np.linalg.cholesky(self.information).T, ((0, 0), (0, 1)))

    def fit(self, gram: FloatArray | None = None) -> Fitted:
        """Solve equations with the prior.

        Args:
            gram: [W y]'[W y] of independent equations with a deviation of one; None for those of
                the prior.
        """
        if gram is None:
            gram = self.factor.T @ self.factor
        covariance = _inverse(gram[:-1, :-1] + self.information)
        return covariance @ gram[:-1, -1], covariance

    def held_out(
        self,
        blocks: tuple[Blocks, Blocks],
        moved: Callable[[FloatArray, FloatArray], FloatArray] = lambda X, _: X,
    ) -> Residual:
        """Return the torque error on held-out folds, of fits to the other folds with the prior.

        Args:
            blocks: summaries of the fitted equations, and of the torques, by blocks of time.
            moved: returns other parameters for X and its covariance.
        """
        equations, torques = blocks
        size = torques.grams[:, :, -1, -1].sum(axis=0)
        error = np.zeros_like(size)
        for fold in np.arange(BLOCKS).reshape(FOLDS, -1).tolist():
            grams = np.delete(equations.grams, fold, axis=0).sum(axis=0)
            fitted = self.fit(np.einsum("j,jab->ab", self.precision, grams))
            error += torques.errors(fold, moved(*fitted))
        return relative_error(error, size, self.sigma)


def _information(model: Model, factor: FloatArray) -> FloatArray:
    """Return the inverse covariance (p, p) of the prior that makes equations most probable.

    Args:
        model: model of the robot.
        factor: triangle of independent equations [W y] with a deviation of one, (k, p + 1).
    """
    scaled = Constraints.of(model, np.zeros(len(model.base.names)))
    B = scaled.G * scaled.scale
    H, y = factor[:, :-1] @ B, factor[:, -1]
    prefixes = ["" if p.prefix in names.LINK else p.prefix for p in model.base.standard]
    _, kind = np.unique(prefixes, return_inverse=True)
    sizes = np.ones(len(kind))
    for _ in range(_ROUNDS):
        inverse = np.linalg.inv(np.eye(len(y)) + H * sizes @ H.T)
        z = sizes * (H.T @ (inverse @ y))
        determined = sizes * np.sum(H * (inverse @ H), axis=0)  # a part of each parameter
        new = np.bincount(kind, z**2) / np.maximum(np.bincount(kind, determined), 1e-300)
        smallest = max(_SMALLEST * new.max(), _NOISE)
        before, sizes = sizes, np.maximum(new, smallest)[kind]
        if np.allclose(sizes, before, _CONVERGED, 0.0):
            break
    return _inverse(B * sizes @ B.T)


def _inverse(A: FloatArray) -> FloatArray:
    """Return the inverse of a positive definite matrix, whose units and rounding may be large."""
    unit = np.sqrt(np.diag(A))
    values, vectors = np.linalg.eigh(A / np.outer(unit, unit))
    half = vectors / np.sqrt(np.maximum(values, _SMALLEST * values[-1])) / unit[:, None]
    return np.asarray(half @ half.T)
