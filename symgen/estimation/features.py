"""Random functions of the state of a motion, which represent model misfit.

Model misfit is an unknown function of positions and speeds. It is the same whenever the robot
returns to a state. symgen treats it as random: a sum of waves with random directions and lengths in
the state and independent coefficients (random Fourier features, Rahimi and Recht 2007). The
variance of the coefficients falls with the frequency of the wave.

    m_j(q, qd) = sum over waves k of (a_k cos(d_k'x) + b_k sin(d_k'x)) s_k,
    x = (state - middle) / spread

One half of the waves is smooth, s_k = 1, and depends on all joints. The other half is friction, s_k
= sign qd_j: it depends on the position and speed of joint j only, and jumps where the joint
reverses. The share of friction in the misfit is unknown: it is one of SHARES (`mixtures`).

Torque equations contain the functions filtered to the comparison band; window equations contain
their integrals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from symgen.data.mask import moving_joints
from symgen.estimation.filtered_log import FilteredLog, Nodes
from symgen.estimation.values import SEED, FloatArray

#: Number of waves, each with a cosine and a sine, and number of friction waves among them.
WAVES, RUBS = 32, 16
#: Possible shares of friction in the variance of a misfit, with equal prior probabilities.
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
#: Radians of a wave over one spread of the motion: from nearly a straight line to a full wave.
_SLOW, _FAST = 0.5, 2 * np.pi


@dataclass(frozen=True)
class Features:
    """Random functions of the state of a motion.

    Attributes:
        middle: mean of q and of qd over the motion, (2 n).
        scale: 1 over their standard deviations, (2 n); 0 for joints that hardly move.
        size: (n,) RMS of the torque of each joint, which scales the functions of the single energy
            equation.
    """

    middle: tuple[float, ...]
    scale: tuple[float, ...]
    size: tuple[float, ...]

    def __call__(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Return the functions at states (K, n), (K, n, 2 WAVES); the sum of their squares is 1."""
        smooth_waves, friction_waves, sizes, _ = _drawn(len(self.size))
        x = (np.hstack([q, qd]) - self.middle) * self.scale
        # Single precision makes sines five times as fast, and the functions are random anyway.
        smooth = (x @ smooth_waves).astype(np.float32)[:, None]  # the same for all joints
        rubs = np.einsum("kcj,cw->kjw", x.reshape(len(x), 2, -1), friction_waves).astype(np.float32)
        m = smooth.shape[2]
        jumps = np.sign(qd)[:, :, None] * sizes[m:]
        out: FloatArray = np.empty((*q.shape, 2, len(sizes)))
        for k, wave in enumerate((np.cos, np.sin)):
            out[:, :, k, :m] = sizes[:m] * wave(smooth)
            out[:, :, k, m:] = jumps * wave(rubs)
        return out.reshape(*q.shape, -1)

    def powers(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Return the power of the functions, (K, 1, 2 WAVES): each is a torque in its direction."""
        *_, torques = _drawn(len(self.size))
        powers = np.einsum("kjm,kj,jm->km", self(q, qd), qd * self.size, torques)
        return np.asarray(powers[:, None])

    def in_band(self, nodes: Nodes) -> FloatArray:
        """Return the functions in the comparison band, (K, m, 2 WAVES).

        The equations of a floating base have the smooth functions only.

        Args:
            nodes: a log in the band of the run, at its nodes.
        """
        return nodes.modelled(lambda q, qd, *_: self.of_equations(q, qd, nodes.base_rows))

    def of_equations(self, q: FloatArray, qd: FloatArray, base_rows: int) -> FloatArray:
        """Return the functions of all equations, (k, m, 2 WAVES)."""
        of_joints = self(q, qd)
        if not base_rows:
            return of_joints
        smooth = np.tile(np.arange(WAVES) < WAVES - RUBS, 2)
        of_base = np.repeat(of_joints[:, :1] * smooth, base_rows, axis=1)
        return np.concatenate([of_base, of_joints], axis=1)


def mixtures() -> FloatArray:
    """Return the variances of the functions for each of SHARES, over their mean, (S, 2 WAVES)."""
    rubs = np.tile(np.arange(WAVES) >= WAVES - RUBS, 2)
    return 2 * np.array([np.where(rubs, share, 1 - share) for share in SHARES])


@cache
def _drawn(n: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the random draws for n joints.

    Returns:
        Smooth waves, (2 n, WAVES - RUBS); those of friction, (2, RUBS); the sizes of all, (WAVES),
        whose squares sum to 1; and directions of torque, (n, 2 WAVES).
    """
    rng = np.random.default_rng(SEED)
    ways = [rng.normal(size=(2 * n, WAVES - RUBS)), rng.normal(size=(2, RUBS))]
    sizes = []
    for d in ways:
        lengths = np.exp(rng.uniform(np.log(_SLOW), np.log(_FAST), d.shape[1]))
        d *= lengths / np.linalg.norm(d, axis=0)
        size = lengths**-0.5  # long waves have larger coefficients than short ones
        sizes.append(size / np.linalg.norm(size) / np.sqrt(len(ways)))
    return ways[0], ways[1], np.concatenate(sizes), rng.normal(size=(n, 2 * WAVES))


def features_of(logs: Sequence[FilteredLog], sigma: Sequence[int]) -> Features:
    """Return random functions of the state of some logs, on the scale of their motion.

    Args:
        logs: the logs in the band of the run.
        sigma: (n,) types of the joints.
    """
    states = np.concatenate([np.hstack([log.q, log.qd]) for log in logs])
    moving = np.isin(np.arange(len(sigma)), moving_joints([log.qd for log in logs], sigma))
    spread = np.where(np.tile(moving, 2), states.std(axis=0), np.inf)
    scale = 1 / np.where(spread > 0, spread, np.inf)
    size = np.sqrt(np.mean(np.concatenate([np.square(log.samples.tau) for log in logs]), axis=0))
    return Features(*(tuple(map(float, x)) for x in (states.mean(axis=0), scale, size)))
