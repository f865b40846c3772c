"""A simulated fleet with hidden changes: each is found and named, and nothing else."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from browser import BROWSER, clipped
from support import PROJECT, sampled
from workflow.fleet_study import CUTOFF, FIGURES, HIDDEN, ROBOT, false_alarms, named, simulated

import symgen
from symgen.cli import cli
from symgen.diagnosis.drift import Finding, Shift
from symgen.diagnosis.fleet import read_fleet
from symgen.report.store import read_result


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
    assert read_result(into).to_json() == content
    page = (into / "report.html").read_text()
    assert "friction of joint 1 up" in page
    assert "Trends" in page
    if BROWSER is not None:
        assert not any(clipped((into / "report.html").read_text("utf-8"), tmp_path).values())


def test_a_fleet_without_a_robot_or_a_day_is_refused(tmp_path: Path, robot: str) -> None:
    (tmp_path / "one.parquet").write_bytes(b"")
    with pytest.raises(symgen.LogError, match="tells no robot and day"):
        symgen.fleet(robot, str(tmp_path / "*.parquet"))


@pytest.fixture(scope="module")
def figures() -> dict[str, Any]:
    """What fleet_study.py wrote."""
    return dict(json.loads(FIGURES.read_text()))


@pytest.mark.parametrize(("number", "day"), sampled([(5, 2), (7, 6)], 1))
def test_the_figures_come_out_again(
    figures: dict[str, Any], tmp_path: Path, robot: str, number: int, day: int
) -> None:
    simulated(tmp_path / "logs", 20, 10, HIDDEN, only=(number, day))
    (file,) = (tmp_path / "logs").rglob("*.parquet")
    found = symgen.identify(robot, file, model="momentum", cutoff=CUTOFF)
    kept = figures["torque_residuals"][f"r{number}"][str(day)]
    assert found.torque_validation.relative == pytest.approx(kept, rel=1e-6)


@pytest.mark.slow
def test_five_hidden_changes_in_twenty_robots_and_ten_days(
    figures: dict[str, Any], tmp_path: Path, robot: str
) -> None:
    simulated(tmp_path / "logs", 20, 10, HIDDEN)
    found = symgen.fleet(robot, str(tmp_path / "logs"), cutoff=CUTOFF).to_json()
    assert (figures["robots"], figures["days"]) == (20, 10)
    findings = [*found["changes"], *found["outliers"]]
    assert named(findings) >= 4, findings
    assert not false_alarms(findings)
    keys = ("robot", "since", "effect", "joints")
    told = [[f[key] for key in keys] for f in findings]
    assert told == [[f[key] for key in keys] for f in figures["changes"] + figures["outliers"]]


def test_a_constant_without_a_deviation_is_read_again(tmp_path: Path) -> None:
    """Constants that a diagnosis searched have none: null in fleet.json."""
    searched = Finding("r1", "2", "backlash", (1,), (Shift("BL1", 0.01, math.nan),), 1e-4, "gap")
    whole = read_fleet(PROJECT / "tests/reference/schemas/fleet-1")
    content = replace(whole, changes=(searched,)).to_json()
    (tmp_path / "fleet.json").write_text(json.dumps(content, allow_nan=False))
    assert read_fleet(tmp_path).to_json() == content
