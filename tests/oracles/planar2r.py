"""Closed form of the two-link planar arm whose axes are parallel to gravity, in plain NumPy.

Written by hand from Lagrange's equations in X = [ZZ1R, ZZ2, MX2, MY2], ZZ1R = ZZ1 + L1**2 M2.
With w = qd1 + qd2 the origin of link 2 moves at L1 qd1 (sin q2, cos q2) in its own frame, hence

    T = ZZ1R qd1**2 / 2 + ZZ2 w**2 / 2 + c qd1 w,   c = L1 (MX2 cos q2 - MY2 sin q2),

and U is constant. With s = -dc/dq2 = L1 (MX2 sin q2 + MY2 cos q2):

    tau1 = ZZ1R qdd1 + ZZ2 (qdd1 + qdd2) + c (2 qdd1 + qdd2) - s (2 qd1 + qd2) qd2,
    tau2 = ZZ2 (qdd1 + qdd2) + c qdd1 + s qd1**2.

Arrays q, qd, qdd, tau are (..., 2) in rad, rad/s, rad/s2, N m; X is (4,) in kg m2 and kg m.
"""

import numpy as np

NAMES = ("ZZ1R", "ZZ2", "MX2", "MY2")


def robot_toml(
    name: str, joint: str = 'friction = ["coulomb", "viscous"]', gravity: str = "[0.0, 0.0, -9.81]"
) -> str:
    """The arm as a robot.toml, L1 = 0.5 m; joint holds the lines of both joints."""
    return f"""
[robot]
name = "{name}"
gravity = {gravity}
[[joint]]
{joint}
[[joint]]
d = 0.5
{joint}
"""


def harmonic_motion(
    rng: np.random.Generator, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """t (N,) of 12 s at 200 Hz, and q, qd, qdd (N, 2) of five harmonics; the seed sets the rate."""
    t = np.arange(0, 12, 0.005)[:, None, None]
    w = 2 * np.pi * 0.15 * np.arange(1, 6) * (1 + 0.03 * seed)
    a, phase = rng.uniform(0.1, 0.5, (2, 5)), rng.uniform(0, 6, (2, 5))
    q, qd, qdd = (
        np.sum(a * w**d * np.sin(w * t + phase + d * np.pi / 2), axis=2) for d in (0, 1, 2)
    )
    return t.ravel(), q, qd, qdd


def energy_regressor(q: np.ndarray, qd: np.ndarray, L1: float) -> np.ndarray:
    """Row (..., 4) of the energy, which is the Lagrangian here."""
    _, q2, qd1, qd2 = _split(q, qd)
    w = qd1 + qd2
    product = L1 * w * qd1
    return np.stack([qd1**2 / 2, w**2 / 2, product * np.cos(q2), -product * np.sin(q2)], axis=-1)


def momentum_regressor(q: np.ndarray, qd: np.ndarray, L1: float) -> tuple[np.ndarray, np.ndarray]:
    """dT/dqd and dL/dq, each (..., 2, 4)."""
    _, q2, qd1, qd2 = _split(q, qd)
    w, cos, sin, zero = qd1 + qd2, L1 * np.cos(q2), L1 * np.sin(q2), 0 * q2
    momentum = _rows(
        [qd1, w, cos * (2 * qd1 + qd2), -sin * (2 * qd1 + qd2)],
        [zero, w, cos * qd1, -sin * qd1],
    )
    slope = _rows([zero] * 4, [zero, zero, -sin * w * qd1, -cos * w * qd1])
    return momentum, slope


def torque_regressor(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, L1: float) -> np.ndarray:
    """Torques per unit parameter, (..., 2, 4)."""
    _, q2, qd1, qd2 = _split(q, qd)
    _, _, a1, a2 = _split(q, qdd)
    cos, sin, zero = L1 * np.cos(q2), L1 * np.sin(q2), 0 * q2
    turning = (2 * qd1 + qd2) * qd2
    return _rows(
        [
            a1,
            a1 + a2,
            cos * (2 * a1 + a2) - sin * turning,
            -sin * (2 * a1 + a2) - cos * turning,
        ],
        [zero, a1 + a2, cos * a1 + sin * qd1**2, -sin * a1 + cos * qd1**2],
    )


def mass_matrix(q: np.ndarray, X: np.ndarray, L1: float) -> np.ndarray:
    """M(q), (..., 2, 2)."""
    ZZ1R, ZZ2, _, _ = X
    c, _ = _coupling(q, X, L1)
    return _rows([ZZ1R + ZZ2 + 2 * c, ZZ2 + c], [ZZ2 + c, ZZ2 + 0 * c])


def coriolis(q: np.ndarray, qd: np.ndarray, X: np.ndarray, L1: float) -> np.ndarray:
    """C(q, qd) of Christoffel's symbols, (..., 2, 2): dM/dt - 2 C is skew-symmetric."""
    _, _, qd1, qd2 = _split(q, qd)
    _, s = _coupling(q, X, L1)
    return _rows([-s * qd2, -s * (qd1 + qd2)], [s * qd1, 0 * s])


def inverse_dynamics(
    q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, X: np.ndarray, L1: float
) -> np.ndarray:
    """Torques (..., 2)."""
    M, C = mass_matrix(q, X, L1), coriolis(q, qd, X, L1)
    return (M @ np.asarray(qdd)[..., None] + C @ np.asarray(qd)[..., None])[..., 0]


def _coupling(q: np.ndarray, X: np.ndarray, L1: float) -> tuple[np.ndarray, np.ndarray]:
    q2 = np.asarray(q)[..., 1]
    c = L1 * (X[2] * np.cos(q2) - X[3] * np.sin(q2))
    s = L1 * (X[2] * np.sin(q2) + X[3] * np.cos(q2))
    return c, s


def _split(q: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, ...]:
    q, qd = np.asarray(q, dtype=float), np.asarray(qd, dtype=float)
    return q[..., 0], q[..., 1], qd[..., 0], qd[..., 1]


def _rows(*rows: list[np.ndarray]) -> np.ndarray:
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
