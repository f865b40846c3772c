"""The search for missing effects and for faults of the logs of a floating base."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import symgen

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.legged import crawl
from workflow.test_floating_logs import (
    Case,
    crawled,
    crawler,
    imu_of,
    log_of,
    walk,
    walker,
)

#: What is wrong with the torques of a log.
Fault = Callable[[symgen.Log], np.ndarray]
LATE = 5  # samples


def sprung(log: symgen.Log) -> np.ndarray:
    """A spring on joint 2."""
    return log.tau + 3 * log.q * np.eye(log.q.shape[1])[1]


def rubbed(log: symgen.Log) -> np.ndarray:
    """Dry friction on joint 2."""
    return log.tau + 0.6 * np.sign(log.qd) * np.eye(log.q.shape[1])[1]


def turned(log: symgen.Log) -> np.ndarray:
    """The torque of joint 2 has the wrong sign."""
    return log.tau * (1 - 2 * np.eye(log.q.shape[1])[1])


def delayed(log: symgen.Log) -> np.ndarray:
    """All torques are late."""
    return np.vstack([np.repeat(log.tau[:1], LATE, axis=0), log.tau[:-LATE]])


@cache
def logs() -> dict[str, tuple[Case, symgen.Log]]:
    """Logs with measured forces on two or four feet, and with hidden forces."""
    return {
        "walk": (walker(), walk(1)),
        "measured": (crawler(), crawled(1, lifts=True, measured=4)),
        "hidden": (crawler(), crawled(1, lifts=True)),
    }


def estimate_of(name: str, fault: Fault) -> symgen.Estimate:
    case, log = logs()[name]
    return symgen.identify(case.robot, replace(log, tau=fault(log)), method="wls", cutoff=14)


def named(estimate: symgen.Estimate) -> list[tuple[str, tuple[int, ...]]]:
    """The hypotheses among the reasons, with their joints."""
    kinds = symgen.robot.effect.definitions()
    reasons = (*estimate.reasons, *estimate.suspected)
    return [(r.kind, r.joints) for r in reasons if r.kind in kinds]


NAMED = [
    (sprung, ("gravity_spring", (2,))),
    (rubbed, ("coulomb_friction", (2,))),
    (turned, ("wrong_sign", (2,))),
]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["walk", "measured", "hidden"])
@pytest.mark.parametrize(("fault", "expected"), NAMED)
def test_a_missing_effect_or_a_fault_is_named(name: str, fault: Fault, expected) -> None:
    assert named(estimate_of(name, fault)) == [expected]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["walk", "measured", "hidden"])
def test_late_torques_are_shifted(name: str) -> None:
    case, _ = logs()[name]
    estimate = estimate_of(name, delayed)
    (repair,) = estimate.repairs
    (delay,) = (value for name, value, _ in repair.values if name == "DT")
    assert delay == pytest.approx(LATE * 0.004, rel=0.03)
    assert estimate.verdict == "trusted"
    assert not named(estimate)
    assert np.abs(case.off(estimate)).max() < 4.5


@pytest.fixture(scope="module")
def turned_walk() -> symgen.Estimate:
    return estimate_of("walk", turned)


def test_a_wrong_sign_beside_measured_forces_is_named(turned_walk) -> None:
    assert named(turned_walk) == [("wrong_sign", (2,))]
    assert turned_walk.verdict == "doubtful"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["walk", "measured", "hidden"])
def test_nothing_is_wrong_with_a_clean_log(name: str) -> None:
    estimate = estimate_of(name, lambda log: log.tau)
    assert not named(estimate)
    assert not estimate.repairs


def crawl_of(flags: Callable[[np.ndarray], None]) -> symgen.Log:
    """A log with hidden forces on the feet, whose flags of contacts (N, 4) a function changes."""
    motion, touches = crawl(1, 12.0)
    tau, _ = crawler().body.supported(motion, touches, 3)
    shown = touches.astype(float)
    flags(shown)
    return log_of(motion, tau[:, 6:], 1, imu=imu_of(motion, 1), touches=shown)


def lost(flags: np.ndarray) -> None:
    """The first foot stands, and its flag is lost."""
    flags[1301:1450, 0] = 0


def found_late(flags: np.ndarray) -> None:
    """The flag of the third foot comes 0.15 s after it touches down."""
    first = np.flatnonzero(np.diff(flags[:, 2]) == 1)[0] + 1
    flags[first : first + 38, 2] = 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flags", "foot", "start", "end"),
    [(lost, "foot3", 5.2, 5.8), (found_late, "foot9", 2.88, 3.04)],
)
def test_a_foot_that_touches_without_its_flag_is_named(flags, foot, start, end) -> None:
    robot, log = crawler().robot, crawl_of(flags)
    estimate = symgen.identify(robot, log, method="wls", cutoff=14)
    (repair,) = estimate.repairs
    assert f"{foot} touches from " in repair.why
    assert f"{foot}.contact is 0" in repair.why
    times = [float(word) for word in repair.why.split() if word[0].isdigit()]
    assert times[0] <= start + 0.01
    assert times[1] >= end - 0.01
    assert times[1] - times[0] < end - start + 0.3
    assert estimate.torque_validation.relative < 0.005
    assert np.abs(crawler().off(estimate)).max() < 4.5


def dragged(seed: int) -> symgen.Log:
    """Every foot drags over the ground in a part of its swing, and its flag is 1."""
    motion, touches = crawl(seed, 12.0)
    for flags in touches.T:
        for lift in np.flatnonzero(np.diff(flags.astype(int)) == -1):
            flags[lift : lift + 80] = True
    tau, _ = crawler().body.supported(motion, touches, 3)
    more = {"touches": touches.astype(float)}
    return log_of(motion, tau[:, 6:], seed, imu=imu_of(motion, seed), **more)


@pytest.mark.slow
def test_a_contact_that_slips_does_no_harm() -> None:
    estimate = symgen.identify(crawler().robot, dragged(1), method="wls", cutoff=14)
    assert estimate.verdict == "trusted"
    assert np.abs(crawler().off(estimate)).max() < 4.5
    assert not named(estimate)
    assert not estimate.repairs
