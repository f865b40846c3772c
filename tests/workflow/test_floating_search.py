"""The search for missing effects and for faults of the logs of a floating base."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import symgen

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from workflow.test_floating_logs import Case, crawled, crawler, walk, walker

#: What is wrong with a log: a function from q, qd and tau of its joints to the torques.
Fault = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
LATE = 5  # samples


def sprung(q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """A spring on joint 2."""
    return tau + 3 * q * np.eye(q.shape[1])[1]


def rubbed(q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Dry friction on joint 2."""
    return tau + 0.6 * np.sign(qd) * np.eye(q.shape[1])[1]


def turned(q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """The torque of joint 2 has the wrong sign."""
    return tau * (1 - 2 * np.eye(q.shape[1])[1])


def delayed(q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """All torques are late."""
    return np.vstack([np.repeat(tau[:1], LATE, axis=0), tau[:-LATE]])


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
    tau = fault(log.q, log.qd, log.tau)
    return symgen.identify(case.robot, replace(log, tau=tau), method="wls", cutoff=14)


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
    estimate = estimate_of(name, lambda q, qd, tau: tau)
    assert not named(estimate)
    assert not estimate.repairs
