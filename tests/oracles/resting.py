"""Logs of moves between points with rests, where static friction is anything between its limits.

Bodies and friction in motion are those of `clean_runs`; at rest, a joint's friction is a share of
its Coulomb friction that is drawn for every rest.
"""

from __future__ import annotations

import numpy as np

from oracles import clean_runs
from oracles.random_arms import to_toml


def run(seed: int, arm_name: str, seconds: float = 40.0, dwell: float = 1.5) -> clean_runs.Run:
    """Draw a run of an arm of `clean_runs.ARMS` whose logs rest for more than half of their time.

    Args:
        seed: same seed, same run.
        arm_name: of the arm.
        seconds: length of the training log; that to judge by is half as long.
        dwell: of each rest, about, s.
    """
    rng = np.random.default_rng([seed, 77])
    arm, rate = clean_runs.ARMS[arm_name], 250
    top, home = float(rng.uniform(0.3, 1.0)), rng.uniform(-0.8, 0.8, arm.n)
    reach = rng.uniform(0.5, 1.8, arm.n)
    moves = [_moves(rng, seconds * k, 1 / rate, top, dwell, reach, home) for k in (1.0, 0.5)]
    clean = clean_runs.motion_of(rng, "fourier", top, reach, home, 20.0, 1 / clean_runs.CLEAN_RATE)
    machine = clean_runs.machine_of(rng, arm, clean)
    instruments = clean_runs.instruments_of(rng, True, (0.005, 0.02))
    logs = []
    for motion, share in moves:
        tau = machine.torque(motion) + np.where(motion.qd == 0, machine.coulomb * share, 0.0)
        logs.append(clean_runs.recorded(rng, motion, tau, instruments))
    friction = ("coulomb", "viscous", "offset") if machine.offset.any() else ("coulomb", "viscous")
    toml = to_toml(arm, arm_name, friction)
    resting = float(np.mean(moves[0][0].qd == 0))
    return clean_runs.Run(
        toml,
        logs[0],
        logs[1],
        clean,
        machine.torque(clean),
        machine.torque,
        (),
        {"resting": resting},
    )


def _moves(
    rng: np.random.Generator,
    seconds: float,
    step: float,
    top: float,
    dwell: float,
    reach: np.ndarray,
    home: np.ndarray,
) -> tuple[clean_runs.Motion, np.ndarray]:
    """A motion, and the share of Coulomb friction that a rest holds, (N, n) in -1 .. 1."""
    t = np.arange(round(seconds / step) + 1) * step
    n = len(reach)
    q, qd, qdd = (np.zeros((len(t), n)) for _ in range(3))
    at, begin = rng.uniform(-1, 1, n), 2 * dwell
    q[:], share = at, np.ones((len(t), n)) * rng.uniform(-1, 1, n)
    while begin < t[-1] - 2 * dwell:
        way, length = rng.uniform(-1, 1, n) - at, 0.5 / top * rng.uniform(0.8, 1.5)
        here = t >= begin
        s = np.clip((t[here] - begin) / length, 0, 1)[:, None]
        q[here] = at + way * s**3 * (10 - 15 * s + 6 * s**2)
        qd[here] = way / length * 30 * s**2 * (1 - s) ** 2
        qdd[here] = way / length**2 * 60 * s * (1 - s) * (1 - 2 * s)
        share[here] = rng.uniform(-1, 1, n)
        at, begin = at + way, begin + length + dwell * rng.uniform(0.5, 1.5)
    limit = [np.abs(x).max(axis=0) + 1e-9 for x in (q, qd, qdd)]
    scale = np.minimum(reach / limit[0], np.minimum(3 / limit[1], 20 / limit[2]))
    return clean_runs.Motion(t, home + scale * q, scale * qd, scale * qdd), share
