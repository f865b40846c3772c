"""References to be tracked: sums of sines, from rest, slowed down in one window."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from oracles.hidden.machines import Machine

STEP = 1e-3  # s, of the integrator


@dataclass(frozen=True, eq=False)
class Motion:
    """Samples of a motion: t (N,), q, qd, qdd, turn (N, n); turn is q at the last reversal."""

    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    turn: np.ndarray


def generator(*words: object) -> np.random.Generator:
    """A random generator that depends on the words and on nothing else."""
    return np.random.default_rng(zlib.crc32(" ".join(map(str, words)).encode()))


def reference(machine: Machine, kind: str, seed: int, step: float = STEP) -> Motion:
    """Draw the motion to be tracked; kind is "train" or "validation".

    q = home + e(t) sum a_k sin(2 pi f_k s(t) + phi_k): f_k multiples of 0.1 Hz up to 1.5 Hz, e
    rises from rest within a second, and ds/dt falls to 0.2 in a window, which gives slow reversals.
    """
    rng = generator("motion", machine.name, kind, seed)
    # Knots beyond both ends, so that the spline's end conditions are felt by nobody.
    knots = np.arange(-0.2, machine.seconds + 0.2, 0.01)
    centre, half = rng.uniform(0.35, 0.7) * machine.seconds, 0.12 * machine.seconds
    slow = 0.8 * np.exp(-((2 * (knots - centre) / half) ** 2))
    phase = np.cumsum(1.0 - slow) * 0.01
    rise = np.clip(knots, 0, 1)
    envelope = rise**4 * (35 - 84 * rise + 70 * rise**2 - 20 * rise**3)
    columns = []
    for j in range(machine.n):
        low, rest = rng.choice([1, 2]), rng.choice(np.arange(3, 16), 4, replace=False)
        f = 0.1 * np.array([low, *rest])
        shape = np.sin(2 * np.pi * f * phase[:, None] + rng.uniform(0, 2 * np.pi, 5))
        shape = envelope * (shape @ (rng.uniform(0.6, 1.0, 5) / f**0.8))
        rate = np.sqrt(np.mean(np.gradient(shape, 0.01) ** 2))
        scale = min(machine.speed[j] / rate, machine.reach[j] / np.abs(shape).max())
        columns.append(machine.home[j] + scale * shape)
    spline = make_interp_spline(knots, np.array(columns).T, k=5)
    t = np.arange(round(machine.seconds / step) + 1) * step
    q, qd, qdd = (spline(t, nu=order) for order in range(3))
    return Motion(t, q, qd, qdd, turning_points(q, qd))


def turning_points(q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Position of each joint at the last reversal of its speed; far away before the first one."""
    turn = np.empty_like(q)
    for j in range(q.shape[1]):
        moving = np.where(np.abs(qd[:, j]) > 1e-3, np.sign(qd[:, j]), 0)
        place, direction = 1e3, 0.0
        for i, s in enumerate(moving):
            if s and s != direction:
                place = q[i, j] if direction else place
                direction = s
            turn[i, j] = place
    return turn
