"""A simulated fleet with hidden changes: which of them are found and named.

    python tests/workflow/fleet_study.py [--robots 20] [--days 10]

Planar arms of two joints that differ by some percent of friction, a log of 20 s of another motion
on every day; five of the robots change on a day that is not told. What `symgen fleet` makes of it
goes to fleet_figures.json, which the default tests take a part of again.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from oracles import planar2r

import symgen

FIGURES = Path(__file__).with_name("fleet_figures.json")
CUTOFF = 10.0  # Hz
#: Robot: day of the change, and what changes.
HIDDEN = {
    3: (4, "friction"), 7: (6, "payload"), 11: (2, "viscous"), 14: (8, "spring"),
    18: (1, "payload"),
}  # fmt: skip
EFFECTS = {
    "friction": {"coulomb_friction", "viscous_friction"},
    "viscous": {"viscous_friction"},
    "payload": {"payload"},
    "spring": {"gravity_spring"},
}
X, L1 = np.array([3.5, 0.4, 0.3, 0.05]), 0.5
FRICTION = np.array([[1.0, 2.0], [0.5, 0.8]])  # Coulomb, viscous
ROBOT = """[robot]
name = "p"
convention = "modified-dh"
gravity = [0.0, 0.0, -9.81]
[[joint]]
[[joint]]
d = 0.5
rotor_inertia = false
"""


def load(mass: float, at: float) -> np.ndarray:
    """What a point mass on link 2 adds to ZZ1R, ZZ2, MX2, MY2."""
    return np.array([mass * L1**2, mass * at**2, mass * at, 0.0])


def log(path: Path, seed: int, X: np.ndarray, friction: np.ndarray, spring: float = 0.0) -> None:
    """20 s of sines at 100 Hz, with noise; every seed another motion."""
    rng = np.random.default_rng(seed)
    t = 0.01 * np.arange(2000)
    w, phase = rng.uniform(1.0, 6.0, (4, 2)), rng.uniform(0, 6, (4, 2))
    angle = t[:, None, None] * w + phase
    q, qd, qdd = (
        (a * f(angle)).sum(axis=1) / 3 for a, f in ((1, np.sin), (w, np.cos), (-(w**2), np.sin))
    )
    tau = np.array([planar2r.inverse_dynamics(*s, X, L1) for s in zip(q, qd, qdd, strict=True)])
    tau += friction[:, 0] * np.sign(qd) + friction[:, 1] * qd + np.array([0, spring]) * q
    tau += 0.02 * rng.normal(size=tau.shape)
    qd = qd + 1e-3 * rng.normal(size=qd.shape)
    columns = {"t": t}
    for name, x in (("q", q), ("qd", qd), ("tau", tau)):
        columns |= {f"{name}{j + 1}": x[:, j] for j in range(2)}
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table(columns), path)


def simulated(
    folder: Path,
    robots: int,
    days: int,
    changes: dict[int, tuple[int, str]],
    only: tuple[int, int] | None = None,
) -> None:
    """Write robot=NAME/day=DAY/log.parquet; robots differ by some percent of friction."""
    rng = np.random.default_rng(0)
    for r in range(1, robots + 1):
        own = FRICTION * (1 + 0.03 * rng.normal(size=(2, 2)))
        for d in range(1, days + 1):
            mine, friction, spring = X, own.copy(), 0.0
            since, kind = changes.get(r, (days + 1, ""))
            if d >= since:
                if kind == "friction":
                    friction[1] *= 1.2
                if kind == "viscous":
                    friction[0, 1] *= 1.2
                if kind == "payload":
                    mine = X + load(1.2, 0.3)
                if kind == "spring":
                    spring = 1.5
            path = folder / f"robot=r{r}" / f"day={d}" / "log.parquet"
            if only not in (None, (r, d)):
                continue
            log(path, 1000 * r + d, mine, friction, spring)


def named(findings: list[dict[str, Any]]) -> int:
    """How many of the hidden changes are found on their day and called what they are."""
    out = 0
    for r, (since, kind) in HIDDEN.items():
        own = [f for f in findings if f["robot"] == f"r{r}"]
        out += any(f["effect"] in EFFECTS[kind] and int(f["since"]) == since for f in own)
    return out


def false_alarms(findings: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What is said of robots on which nothing changed, or of days before it did."""
    since = {f"r{r}": day for r, (day, _) in HIDDEN.items()}
    return [f for f in findings if int(f["since"]) < since.get(f["robot"], 10**6)]


def main() -> None:
    """Simulate, look, print and write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--days", type=int, default=10)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "p.toml").write_text(ROBOT)
        simulated(folder / "logs", given.robots, given.days, HIDDEN)
        begin = time.process_time()
        found = symgen.fleet(folder / "p.toml", folder / "logs", cutoff=CUTOFF).to_json()
        seconds = time.process_time() - begin
    findings = [*found["changes"], *found["outliers"]]
    residuals: dict[str, dict[str, float]] = {}
    for e in found["estimates"]:
        residuals.setdefault(e["robot"], {})[e["day"]] = e["torque_residual"]
    figures = {
        "robots": given.robots,
        "days": given.days,
        "changes": found["changes"],
        "outliers": found["outliers"],
        "torque_residuals": residuals,
    }
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n")
    print(f"{named(findings)} of {len(HIDDEN)} named, false alarms: {false_alarms(findings)}")
    print(f"{seconds / len(found['estimates']):.2f} s of the processor for a robot and day")


if __name__ == "__main__":
    main()
