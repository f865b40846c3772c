"""What drifted: found on its day, named, and no alarm where nothing did."""

from __future__ import annotations

import numpy as np
import pytest

from symgen.diagnosis.drift import Course, named, scatter, steps
from symgen.diagnosis.fleet import grouped
from symgen.errors import LogError

NAMES = ("ZZ1R", "ZZ2", "MX2", "MY2", "FS1", "FV1", "FS2", "FV2")
X = np.array([3.5, 0.4, 0.3, 0.05, 1.0, 2.0, 0.5, 0.8])
L1, ROBOTS, DAYS = 0.5, 20, 10
#: Of a body on link 2: ZZ1R gains L1**2 M.
LOAD = np.zeros((8, 10))
LOAD[0, 9], LOAD[1, 5], LOAD[2, 6], LOAD[3, 7] = L1**2, 1.0, 1.0, 1.0


def covariance(rng: np.random.Generator) -> np.ndarray:
    root = rng.normal(size=(8, 8)) / 8 + np.eye(8)
    std = 0.01 * np.abs(X)
    C = root @ root.T
    return C * np.outer(std, std) / np.sqrt(np.outer(np.diag(C), np.diag(C)))


def simulated(seed: int, changes=(), short: float = 1.0, own: float = 0.0) -> list[Course]:
    """Estimates of a fleet; `short`: std is said that much too small; `own`: robots differ."""
    rng = np.random.default_rng(seed)
    C = covariance(rng)
    out = []
    for r in range(ROBOTS):
        mean = np.tile(X * (1 + own * rng.normal(size=8)), (DAYS, 1))
        for robot, since, change in changes:
            if robot == r:
                mean[since:] += change
        noise = short * rng.multivariate_normal(np.zeros(8), C, DAYS)
        days = tuple(f"day{k + 1}" for k in range(DAYS))
        out.append(Course(f"r{r}", days, mean + noise, np.tile(C, (DAYS, 1, 1))))
    return out


@pytest.mark.parametrize("short", [1.0, 3.0])
@pytest.mark.parametrize("own", [0.0, 0.1])
def test_no_false_alarm_also_where_std_is_too_small_or_robots_differ(
    short: float, own: float
) -> None:
    alarms = sum(bool(steps(simulated(seed, (), short, own), NAMES)) for seed in range(20))
    assert alarms <= 2  # 0.2 are expected at the level of 1 %
    assert scatter(simulated(1, (), 3.0)) == pytest.approx(3.0, rel=0.25)


def test_changes_are_found_on_their_day_and_named() -> None:
    friction, load = np.zeros(8), LOAD @ np.array([0, 0, 0, 0, 0, 0.05, 0.3, 0, 0, 1.2])
    friction[7] = 0.2 * X[7]
    found = steps(simulated(3, [(4, 3, friction), (7, 0, load), (11, 6, load)]), NAMES)
    assert [(s.robot, s.since) for s in found] == [("r4", "day4"), ("r7", "day1"), ("r11", "day7")]
    (drift,) = named(found[0], NAMES, LOAD, 2)
    assert (drift.effect, drift.joints) == ("viscous_friction", (2,))
    assert "friction of joint 2 up" in drift.says
    ((name, value, std),) = drift.parameters
    assert name == "FV2"
    assert abs(value - friction[7]) < 4 * std
    for step in found[1:]:
        (carried,) = named(step, NAMES, LOAD, 2)
        assert (carried.effect, carried.joints) == ("payload", (2,))
        mass, std = next((v, s) for n, v, s in carried.parameters if n == "ML")
        assert abs(mass - 1.2) < 4 * std < 0.8
        assert step.p_value < 0.01


def test_a_change_that_is_no_load_is_left_to_diagnose() -> None:
    change = np.zeros(8)
    change[0], change[2] = -0.4, 0.1  # a load would add to ZZ1R
    (step,) = steps(simulated(5, [(2, 5, change)]), NAMES)
    (found,) = named(step, NAMES, LOAD, 2)
    assert found.effect == ""
    assert "ZZ1R" in found.says


def test_a_reference_tells_of_each_robot_alone() -> None:
    (only,) = simulated(1)[:1]
    assert not steps([only], NAMES, X)
    assert not steps([only], NAMES)
    (step,) = steps([only], NAMES, X * np.where(np.arange(8) == 5, 1.2, 1.0))
    assert (step.since, step.first, step.moved[0].name) == ("day1", True, "FV1")


def test_robot_and_day_are_those_of_the_path() -> None:
    def found(*files: str) -> list[tuple[str, str]]:
        return [(d.robot, d.day) for d in grouped(files, None)]

    hive = [f"data/robot=r{r}/day={d}/part.parquet" for r in (10, 2) for d in (10, 9)]
    assert found(*hive) == [("r2", "9"), ("r2", "10"), ("r10", "9"), ("r10", "10")]
    assert found("logs/a/day1.parquet", "logs/b/day1.csv") == [("a", "day1"), ("b", "day1")]
    assert found("x/a_d2.npz", "x/a_d1.npz") == [("a", "d1"), ("a", "d2")]
    with pytest.raises(LogError, match=r"accepted: robot=NAME/day=DAY/FILE"):
        found("x/one.npz", "x/two.npz")
