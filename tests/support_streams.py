"""Logs that are read chunk by chunk in tests: a small robot, its motion, files of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from oracles import planar2r
from oracles.arm import Arm, X, sines

import symgen

FRICTION, STEP = 0.3, 0.01


def motion(
    samples: int, seed: int = 0, start: float = 0.0, step: float = STEP
) -> dict[str, np.ndarray]:
    """Sines with noise on every channel, torques from the paper's closed form."""
    rng = np.random.default_rng(seed)
    t = start + step * np.arange(samples)
    w, phase = rng.uniform(0.5, 6.0, (3, 2)), rng.uniform(0, 6, (3, 2))
    q, qd, qdd = sines(t, np.full((3, 2), 1 / 3), w, phase)
    tau = Arm(X, FV=FRICTION).torque(q, qd, qdd)
    tau += 0.01 * rng.normal(size=tau.shape)
    columns = {"t": t}
    for name, x, noise in (("q", q, 1e-4), ("qd", qd, 1e-3), ("tau", tau, 0.0)):
        for j in range(2):
            columns[f"{name}{j + 1}"] = x[:, j] + noise * rng.normal(size=samples)
    return columns


def parquet(path: Path, columns: dict[str, np.ndarray], rows: int = 700) -> Path:
    pq.write_table(pa.table(columns), path, row_group_size=rows)
    return path


def robot() -> symgen.Robot:
    joint = 'friction = ["viscous"]\nrotor_inertia = false'
    return symgen.parse_robot(planar2r.robot_toml("p", joint), "p")
