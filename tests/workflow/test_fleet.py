"""A simulated fleet with hidden changes: each is found and named, and nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from oracles import planar2r

import symgen
from symgen.cli import cli

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


def simulated(folder: Path, robots: int, days: int, changes: dict[int, tuple[int, str]]) -> None:
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
            log(path, 1000 * r + d, mine, friction, spring)


@pytest.fixture
def robot(tmp_path: Path) -> str:
    (tmp_path / "p.toml").write_text(ROBOT)
    return str(tmp_path / "p.toml")


def test_a_small_fleet(tmp_path: Path, robot: str) -> None:
    simulated(tmp_path / "logs", 4, 3, {2: (2, "viscous"), 3: (3, "payload")})
    into = tmp_path / "fleet"
    given = ["fleet", robot, str(tmp_path / "logs"), "--into", str(into), "--cutoff", "10"]
    assert cli.main(given, standalone_mode=False) == 1
    content = json.loads((into / "fleet.json").read_text())
    assert content["schema"] == "symgen.fleet/1"
    assert len(content["estimates"]) == 12
    assert all(e["torque_residual"] < 0.05 for e in content["estimates"])
    found = {(f["robot"], f["since"], f["effect"], *f["joints"]) for f in content["changes"]}
    assert found == {("r2", "2", "viscous_friction", 1), ("r3", "3", "payload", 2)}
    assert content["outliers"] == []
    (carried,) = (f for f in content["changes"] if f["effect"] == "payload")
    mass = next(p for p in carried["parameters"] if p["name"] == "ML")
    assert abs(mass["value"] - 1.2) < 4 * mass["std"]
    page = (into / "report.html").read_text()
    assert "friction of joint 1 up" in page
    assert "Trends" in page


def test_a_fleet_without_a_robot_or_a_day_is_refused(tmp_path: Path, robot: str) -> None:
    (tmp_path / "one.parquet").write_bytes(b"")
    with pytest.raises(symgen.LogError, match="tells no robot and day"):
        symgen.fleet(robot, str(tmp_path / "*.parquet"))


@pytest.mark.slow
def test_five_hidden_changes_in_twenty_robots_and_ten_days(tmp_path: Path, robot: str) -> None:
    hidden = {
        3: (4, "friction"), 7: (6, "payload"), 11: (2, "viscous"), 14: (8, "spring"),
        18: (1, "payload"),
    }  # fmt: skip
    effects = {
        "friction": {"coulomb_friction", "viscous_friction"},
        "viscous": {"viscous_friction"},
        "payload": {"payload"},
        "spring": {"gravity_spring"},
    }
    simulated(tmp_path / "logs", 20, 10, hidden)
    found = symgen.fleet(robot, str(tmp_path / "logs"), cutoff=10.0)
    findings = (*found.changes, *found.outliers)
    assert {f.robot for f in findings} <= {f"r{r}" for r in hidden}, "a false alarm"
    named = 0
    for r, (since, kind) in hidden.items():
        own = [f for f in findings if f.robot == f"r{r}"]
        named += any(f.effect in effects[kind] and int(f.since) == since for f in own)
    assert named >= 4, findings
