"""Logs of an arm with play in a gear: a motor and a link that touch on one flank, or not at all.

Two links in a vertical plane, by Lagrange's equations. Encoders, friction and rotors are on the
motors' side. In the loose joint a stiff damped contact pushes where a flank is met and never pulls;
SciPy integrates. Arrays are (2,), in rad, s, kg m2 and N m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

LENGTH, GRAVITY, WIDTH = 0.5, 9.81, 4e-3  # m, m/s2, rad/s of tanh(qd/width)
ROTOR, COULOMB, VISCOUS = np.array([0.4, 0.15]), np.array([3.0, 1.2]), np.array([2.5, 1.0])
TURNED, COUPLED, OUTER = 2.4, 0.55, 0.4  # of the mass matrix, kg m2
WEIGHT = np.array([2.5, 1.1])  # first moments, kg m
BANDWIDTH = 40.0  # rad/s, of the position loop
_JOINT = f'friction = ["coulomb", "viscous"]\ncoulomb_width = {WIDTH}'
ROBOT = f"""
[robot]
name = "loose"
gravity = [0.0, -{GRAVITY}, 0.0]
[[joint]]
{_JOINT}
[[joint]]
d = {LENGTH}
{_JOINT}
"""
Log = dict[str, np.ndarray]


@dataclass(frozen=True)
class Gear:
    """The loose joint (0 or 1), its whole play in rad, stiffness and damping of its flanks."""

    joint: int = 1
    play: float = 0.0
    stiffness: float = 6e4
    damping: float = 60.0


def links(q: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrix (2, 2) of the links alone, and the torque (2,) of their weight and speeds."""
    c, s = COUPLED * np.cos(q[1]), COUPLED * np.sin(q[1])
    M = np.array([[TURNED + 2 * c, OUTER + c], [OUTER + c, OUTER]])
    outer = GRAVITY * WEIGHT[1] * np.cos(q[0] + q[1])
    inner = GRAVITY * WEIGHT[0] * np.cos(q[0])
    turning = qd[1] * (2 * qd[0] + qd[1])
    return M, np.array([inner + outer - s * turning, outer + s * qd[0] ** 2])


def reference(seed: int, t: np.ndarray) -> tuple[np.ndarray, ...]:
    """q, qd, qdd (N, 2) of sums of four sines that differ by seed."""
    rng = np.random.default_rng(seed)
    ends = np.array([[0.15, 0.3], [0.5, 0.8], [1.0, 1.4], [1.6, 2.1]])
    w = 2 * np.pi * rng.uniform(ends[:, :1], ends[:, 1:], (4, 2))
    a = np.array([[0.5], [0.2], [0.12], [0.07]]) * rng.uniform(0.7, 1.0, (4, 2))
    angle = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (4, 2))
    waves = a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle)
    q, qd, qdd = (x.sum(axis=1) for x in waves)
    return q + [-0.9, 0.4], qd, qdd


def recorded(seed: int, gear: Gear, seconds: float = 15.0, rate: float = 250.0) -> Log:
    """Track a reference by PD on the motors; return t, and q, qd, tau (N, 2) of their side."""
    j, (inertia, _) = gear.joint, links(np.array([0.0, 0.7]), np.zeros(2))
    Kp, Kd = np.array([[BANDWIDTH**2], [1.6 * BANDWIDTH]]) * (np.diag(inertia) + ROTOR)
    t = np.arange(round(seconds * rate)) / rate
    fine = np.linspace(0, t[-1], 4 * len(t))
    aim, speed, bend = reference(seed, fine)
    ahead = [M @ a + bias for a, (M, bias) in zip(bend, map(links, aim, speed), strict=True)]
    ahead = 0.9 * np.array(ahead) + ROTOR * bend + 0.8 * COULOMB * np.tanh(speed / WIDTH)
    law = CubicSpline(fine, ahead + Kp * aim + Kd * speed)

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        q, v, own, rate = x[:2], x[2:4], x[:2].copy(), x[2:4].copy()
        own[j], rate[j] = x[4:]
        torque = law(t) - Kp * q - Kd * v - COULOMB * np.tanh(v / WIDTH) - VISCOUS * v
        bent = q[j] - own[j]
        over = bent - min(max(bent, -gear.play / 2), gear.play / 2)
        side = np.sign(over)
        push = side * max(side * (gear.stiffness * over + gear.damping * (v[j] - rate[j])), 0.0)
        turned, torque[j] = (torque[j] - push) / ROTOR[j], push
        M, bias = links(own, rate)
        M[1 - j, 1 - j] += ROTOR[1 - j]
        a = np.linalg.solve(M, torque - bias)
        out = np.array([v[0], v[1], *a, rate[j], a[j]])
        out[2 + j] = turned
        return out

    (M, bias), load = links(aim[0], speed[0]), bend[0]
    load = (M @ load + bias)[j]
    at = aim[0, j] - np.sign(load) * gear.play / 2 - load / gear.stiffness
    begin = [*aim[0], *speed[0], at, speed[0, j]]
    found = solve_ivp(rates, (0, t[-1]), begin, "LSODA", t, rtol=1e-5, atol=1e-7, max_step=4e-3)
    q, v = found.y[:2].T, found.y[2:4].T
    tau, noise = (
        law(t) - Kp * q - Kd * v,
        np.random.default_rng([seed, 1]).normal(size=(3, *q.shape)),
    )
    size = np.sqrt(np.mean(tau**2, axis=0))
    return {
        "t": t,
        "q": q + 2e-5 * noise[0],
        "qd": v + 2e-3 * noise[1],
        "tau": tau + 0.01 * size * noise[2],
        "link": found.y[4],
    }
