"""How well a motion determines the parameters: the spectrum of the scaled base regressor.

With W the regressor of the model that will be used, its columns scaled to unit norm, and
lambda_i the eigenvalues of G = W'W, the condition number is sqrt(lambda_max / lambda_min) and
log det G = sum of log lambda_i, 0 at best (Gautier and Khalil 1992, Swevers et al. 1997).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symgen.estimation.integrals import cumulative_integral

FloatArray = NDArray[np.float64]
CRITERIA = ("condition", "logdet")
_FLOOR = 1e-13
_POWER = 6  # of the mean that stands for the largest and the smallest eigenvalue
_LARGE = 0.05  # what columns e times as large are worth, in logs of the condition number
#: What the equations of each model are made of: kernels, with sizes in entries of n and columns.
KERNELS: dict[str, tuple[str, ...]] = {
    "energy": ("energy_regressor", "friction_power"),
    "momentum": ("momentum_regressor", "friction_torque"),
    "torque": ("torque_regressor",),
}


def condition_number(W: FloatArray) -> float:
    """Return the condition number of W (K, p) with columns of unit norm; inf where singular."""
    norms = np.linalg.norm(W, axis=0)
    if len(W) < W.shape[1] or not norms.all():
        return float("inf")
    singular = np.linalg.svd(np.linalg.qr(W / norms, mode="r"), compute_uv=False)
    least = float(singular[-1])
    return float(singular[0]) / least if least > 1e-14 * singular[0] else float("inf")


def log_determinant(W: FloatArray) -> float:
    """Return log det G of W (K, p) with columns of unit norm; -inf where singular."""
    norms = np.linalg.norm(W, axis=0)
    if len(W) < W.shape[1] or not norms.all():
        return float("-inf")
    R = np.abs(np.diag(np.linalg.qr(W / norms, mode="r")))
    return float(2 * np.log(R).sum()) if R.min() > 0 else float("-inf")


def loss(W: FloatArray, criterion: str) -> tuple[float, FloatArray]:
    """Return a smooth loss of W (K, p) and its gradient (K, p).

    "logdet" is -log det G. "condition" is the log of the condition number with power means of
    order 6 in place of the extreme eigenvalues, which are not smooth where two meet. Scaled columns
    do not tell a large motion from a small one, which drowns in noise: a small share of the mean
    log norm of the columns prefers the large one.
    """
    norms = np.maximum(np.linalg.norm(W, axis=0), 1e-150)
    scaled = W / norms
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    values = np.maximum(values, _FLOOR)
    if criterion == "logdet":
        value, slope = -float(np.log(values).sum()), -1 / values
    else:
        value, slope = 0.0, np.zeros_like(values)
        for power in (_POWER, -_POWER):
            reference = values[-1] if power > 0 else values[0]
            terms = (values / reference) ** power
            total = terms.sum()
            value += float(np.log(reference) * np.sign(power) + np.log(total) / _POWER) / 2
            slope += np.sign(power) * terms / total / values / 2
    turned = scaled @ (2 * (vectors * slope) @ vectors.T)
    share = _LARGE / len(norms)
    value -= share * float(np.log(norms).sum())
    return value, (turned - scaled * (np.sum(scaled * turned, axis=0) + share)) / norms


@dataclass(frozen=True, eq=False)
class Windows:
    """Equations of one run from samples of the kernels: linear, with its transpose.

    Energy: [h(t2) - h(t1), integral of f]; momentum: [p(t2) - p(t1) - integral of dL/dq, integral
    of F]; torque: the samples themselves. The same equations as identify's, on a coarser grid.
    """

    model: str
    difference: FloatArray
    integral: FloatArray

    def rows(self, samples: tuple[FloatArray, ...]) -> FloatArray:
        """Return W (K, p) from the outputs of the kernels, each (N, ...)."""
        D, S = self.difference, self.integral
        if self.model == "torque":
            return _flat(samples[0])
        if self.model == "energy":
            return np.column_stack([D @ samples[0], *(S @ f for f in samples[1:])])
        p, slope, *friction = samples
        change = _apply(D, p) - _apply(S, slope)
        return _flat(np.concatenate([change, *(_apply(S, f) for f in friction)], axis=2))

    def transposed(
        self, gradient: FloatArray, samples: tuple[FloatArray, ...]
    ) -> tuple[FloatArray, ...]:
        """Return the gradient with respect to the samples from that with respect to W."""
        D, S = self.difference.T, self.integral.T
        if self.model == "torque":
            return (gradient.reshape(samples[0].shape),)
        inertial = samples[0].shape[-1]
        if self.model == "energy":
            return (D @ gradient[:, :inertial], *(S @ gradient[:, inertial:] for _ in samples[1:]))
        cube = gradient.reshape(D.shape[1], -1, gradient.shape[1])
        first, rest = cube[:, :, :inertial], cube[:, :, inertial:]
        return (_apply(D, first), -_apply(S, first), *(_apply(S, rest) for _ in samples[2:]))


def windows(model: str, count: int, step: float, length: int) -> Windows:
    """Return the equations of a run of `count` samples in windows of `length` steps."""
    if model == "torque":
        return Windows(model, np.zeros((0, 0)), np.zeros((0, 0)))
    identity = np.eye(count)
    integral = cumulative_integral(identity, step)
    return Windows(
        model, identity[length:] - identity[:-length], integral[length:] - integral[:-length]
    )


def _apply(matrix: FloatArray, samples: FloatArray) -> FloatArray:
    return np.tensordot(matrix, samples, axes=1)


def _flat(cube: FloatArray) -> FloatArray:
    return cube.reshape(-1, cube.shape[-1])
