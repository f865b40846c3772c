"""Torques of an arm that stands still, from plain 4x4 transforms, with friction that holds it.

    tau_j = dU/dq_j + f_j,   U = -g . sum of (M P + A MS)

by central differences of the potential energy of `oracles.transforms`, whose code shares nothing
with symgen. Friction holds anything within its bound.
"""

from __future__ import annotations

import numpy as np

from oracles.transforms import Arm, potential_regressor


def gravity_torque(arm: Arm, links: np.ndarray, q: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Torques (K, n) of gravity at poses q (K, n), for links (links, 10) as XX .. M."""
    values = np.asarray(links).ravel()
    out = np.empty_like(q)
    for j in range(q.shape[1]):
        move = step * np.eye(q.shape[1])[j]
        ahead, behind = (potential_regressor(arm, q + s * move, False) for s in (1, -1))
        out[:, j] = (ahead - behind) @ values / (2 * step)
    return out


def held(
    rng: np.random.Generator, bound: np.ndarray, direction: np.ndarray, least: float
) -> np.ndarray:
    """Friction (K, n) that holds each joint: between `least` times its bound and the bound.

    In the direction of the last motion; for a direction of 0, either way and from nothing on.
    """
    size = rng.uniform(least, 1, direction.shape)
    free = rng.uniform(-1, 1, direction.shape)
    return bound * np.where(direction == 0, free, direction * size)
