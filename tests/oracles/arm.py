"""The two-link arm of the tests: every torque from one set of parameters, weight and friction too.

The links are planar2r's closed form. With u = q1 + q2, and gravity g along -y of frame 0:

    tau1 = links + g (MX1R cos q1 + MX2 cos u - MY2 sin u) + FS1 sign qd1 + FV1 qd1,
    tau2 = links + g (MX2 cos u - MY2 sin u) + IA2 qdd2 + FS2 sign qd2 + FV2 qd2.

MX1R = MX1 + L1 M2. Arrays q, qd, qdd, tau are (..., 2) in rad, rad/s, rad/s2, N m; t is in s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from oracles import planar2r

#: Parameters of the paper.
X = np.array([1.702, 0.05644, 0.15, 0.075])
Arrays = tuple[np.ndarray, ...]


@dataclass(frozen=True, eq=False)
class Arm:
    """X = [ZZ1R, ZZ2, MX2, MY2]; g is 0 where the axes are parallel to gravity."""

    X: np.ndarray
    MX1R: float = 0.0
    g: float = 0.0
    FS: np.ndarray | float = 0.0
    FV: np.ndarray | float = 0.0
    IA2: float = 0.0
    L1: float = 0.5

    @property
    def values(self) -> dict[str, float]:
        """Parameters by name."""
        names = (*planar2r.NAMES, "MX1R", "IA2", "FS1", "FS2", "FV1", "FV2")
        two = np.ones(2)
        numbers = [*self.X, self.MX1R, self.IA2, *self.FS * two, *self.FV * two]
        return dict(zip(names, map(float, numbers), strict=True))

    def torque(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Torques of the motors."""
        links = planar2r.inverse_dynamics(q, qd, qdd, self.X, self.L1)
        rotor = self.IA2 * qdd * [0.0, 1.0]
        return links + rotor + self.weight(q) + self.FS * np.sign(qd) + self.FV * qd

    def weight(self, q: np.ndarray) -> np.ndarray:
        """Torques that hold the arm at rest, without friction."""
        u = q[..., 0] + q[..., 1]
        second = self.X[2] * np.cos(u) - self.X[3] * np.sin(u)
        return self.g * np.stack([self.MX1R * np.cos(q[..., 0]) + second, second], axis=-1)

    def acceleration(self, q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """Accelerations under torques of the motors."""
        M = planar2r.mass_matrix(q, self.X, self.L1) + np.diag([0.0, self.IA2])
        return np.linalg.solve(M, (tau - self.torque(q, qd, 0 * qd))[..., None])[..., 0]

    def carrying(self, mass: float, at: float) -> Arm:
        """The arm with a point mass at x = `at` of its second link."""
        X = self.X + mass * np.array([self.L1**2, at**2, at, 0.0])
        return replace(self, X=X, MX1R=self.MX1R + mass * self.L1)

    def recorded(
        self, t: np.ndarray, motion: Arrays, rng: np.random.Generator, torque: float = 0.01,
        position: float = 1e-5, speed: float = 1e-3,
    ) -> Arrays:  # fmt: skip
        """t, q, tau and qd of a log, with noise: `torque` is a share of each joint's torque."""
        q, qd, _ = motion
        tau = self.torque(*motion)
        tau = tau + torque * np.std(tau, axis=0) * rng.normal(size=tau.shape)
        q = q + position * rng.normal(size=q.shape)
        return t, q, tau, qd + speed * rng.normal(size=q.shape)


#: An arm of the paper in a vertical plane, with friction, and the gravity of its file.
HANGING = Arm(X, MX1R=0.6, g=9.81, FS=np.array([0.25, 0.08]), FV=np.array([0.15, 0.05]))
IN_PLANE = "[0.0, -9.81, 0.0]"


#: What planar2r has in logs of `save_planar2r`.
PLANAR2R = np.array([1.7, 0.15, 0.3, 0.02])


def save_planar2r(
    path: Path,
    seed: int,
    more: Callable[..., np.ndarray | float] | None = None,
    noise: float = 0.01,
) -> Path:
    """Write an npz log of planar2r, with further torques (q, qd, tau) -> (N, 2) and noise."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    tau = Arm(PLANAR2R).torque(q, qd, qdd)
    if more is not None:
        tau = tau + more(q, qd, tau)
    tau = tau + noise * tau.std(axis=0) * rng.normal(size=tau.shape)
    np.savez(path, t=t, q=q, qd=qd, tau=tau)
    return path


def sines(t: np.ndarray, a: object, w: object, phase: object = 0.0) -> Arrays:
    """q, qd, qdd (N, n) of sums over k of a sin(w t + phase); a, w, phase are (k, n) or (n,)."""
    a, w, phase = (np.atleast_2d(np.asarray(x, dtype=float)) for x in (a, w, phase))
    angle = t[:, None, None] * w + phase
    waves = (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle))
    return tuple(np.sum(x, axis=1) for x in waves)
