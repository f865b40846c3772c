"""Logs of joints that stick: dry friction by complementarity, a servo, moves between points.

Bodies are those of `hidden.machines`, by Pinocchio; nothing else is shared with the simulator of
`hidden`. Friction holds a joint where that needs no more than its limit, else it slides.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from oracles.hidden.engines import PinocchioEngine
from oracles.hidden.machines import Machine
from oracles.hidden.motion import generator, reference
from oracles.pinocchio_arm import load_pinocchio

STEP = 5e-4  # s, of the integrator
BANDWIDTH = 30.0  # rad/s, of the position loop
SWEEPS = 12  # of Gauss-Seidel over the joints' friction
Law = Callable[[float, np.ndarray, np.ndarray], np.ndarray]
Log = dict[str, np.ndarray]


def moves(
    machine: Machine, rng: np.random.Generator, seconds: float, together: bool
) -> tuple[np.ndarray, ...]:
    """Return t, q, qd, qdd of quintic moves with rests of 0.3 to 1.2 s between them."""
    t, n = np.arange(0, seconds, STEP), machine.n
    q = np.tile(machine.home.astype(float), (len(t), 1))
    for joints in [range(n)] if together else [[j] for j in range(n)]:
        own = list(joints)
        at, begin = machine.home[own], rng.uniform(0.2, 0.6)
        while begin < seconds - 1:
            new = machine.home[own] + machine.reach[own] * rng.uniform(-1, 1, len(own))
            length = max(float(np.max(1.875 * np.abs(new - at) / (2.2 * machine.speed[own]))), 0.4)
            s = np.clip((t - begin) / length, 0, 1)[:, None]
            q[:, own] += (new - at) * s**3 * (10 - 15 * s + 6 * s**2)
            at, begin = new, begin + length + rng.uniform(0.3, 1.2)
    qd = np.gradient(q, STEP, axis=0)
    return t, q, qd, np.gradient(qd, STEP, axis=0)


def recorded(
    machine: Machine,
    believed: Machine,
    seed: int,
    kind: str,
    *,
    points: str = "",
    limit: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    extra: Law | None = None,
) -> Log:
    """Simulate a log and read it: encoders with steps, noise of tachometers and torques.

    Args:
        machine: what moves; `believed` is what the servo feeds forward.
        seed, kind: of the motion and the noise.
        points: "together" or "apart" for moves between points; "" for sums of sines.
        limit: of dry friction (n,) from speeds and the motors' torques; None for Coulomb's.
        extra: torque on the joints from t, q, qd.
    """
    pin, rng = load_pinocchio(), generator("stiction", machine.name, seed, kind, points)
    if points:
        t, aim, rate, bend = moves(machine, rng, 20.0, points == "together")
    else:
        drawn = reference(believed, kind, seed, STEP)
        t, aim, rate, bend = drawn.t, drawn.q, drawn.qd, drawn.qdd
    plant, healthy = PinocchioEngine(machine), PinocchioEngine(believed)
    inertia = healthy.inertia(machine.home)
    Kp, Kd = BANDWIDTH**2 * inertia, 1.8 * BANDWIDTH * inertia
    forward = 0.9 * healthy.torque(aim, rate, bend)
    q, qd, held = aim[0].copy(), np.zeros(machine.n), np.zeros(machine.n)
    rows = np.empty((len(t), 3, machine.n))
    for i in range(len(t)):
        tau = forward[i] + Kp * (aim[i] - q) + Kd * (rate[i] - qd)
        u = tau - machine.viscous * qd
        if extra is not None:
            u = u + extra(t[i], q, qd)
        M = np.triu(pin.crba(plant.model, plant.data, q))
        inverse = np.linalg.inv(M + np.triu(M, 1).T)
        free = u - pin.nonLinearEffects(plant.model, plant.data, q, qd)
        most = (machine.coulomb if limit is None else limit(qd, u)) * STEP
        speed = qd + STEP * (inverse @ free) + inverse @ held
        for _ in range(SWEEPS):
            for j in range(machine.n):
                new = max(-most[j], min(most[j], held[j] - speed[j] / inverse[j, j]))
                speed = speed + inverse[:, j] * (new - held[j])
                held[j] = new
        rows[i] = q, qd, tau
        q = q + STEP * (qd + speed) / 2
        qd = speed
    every = 4
    q, qd, tau = (rows[::every, k] for k in range(3))
    size = np.sqrt(np.mean(tau**2, axis=0))
    return {
        "t": t[::every],
        "q": np.round(q / machine.resolution) * machine.resolution,
        "qd": qd + machine.tacho * rng.normal(size=q.shape),
        "tau": tau + 0.005 * size * rng.normal(size=q.shape),
    }
