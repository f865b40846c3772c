"""Simulated runs are of the robot that their robot.toml says, and faults do what they say."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import engineer
from oracles.faults import HEAVY, LIGHT, Log
from oracles.pinocchio_arm import load_pinocchio

try:
    load_pinocchio()
except ImportError as missing:
    pytest.skip(f"needs Pinocchio: {missing}", allow_module_level=True)

from oracles import clean_runs
from support import parsed

import symgen


def _error(run: clean_runs.Run) -> float:
    """What the declared parameters leave of the exact torques."""
    kernel = symgen.load(symgen.derive(parsed(run.robot_toml), ("torque_regressor",)))
    W = kernel["torque_regressor"](run.clean.q, run.clean.qd, run.clean.qdd)
    return engineer.residual(W, run.torque, engineer.least_squares(W, run.torque))[1]


@pytest.mark.parametrize(
    "arm",
    ["planar2r", *(pytest.param(a, marks=pytest.mark.slow) for a in ("arm4r", "wrist6r", "arm7r"))],
)
def test_where_nothing_is_missing_the_declared_parameters_give_the_exact_torques(arm: str) -> None:
    assert _error(clean_runs.run(1, arms=[arm], effects=False)) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("effect", clean_runs.MISSING)
def test_an_effect_that_is_missing_is_missed(effect: str, monkeypatch) -> None:
    monkeypatch.setattr(clean_runs, "MISSING", (effect,))
    run = next(
        run
        for seed in range(40)
        if (run := clean_runs.run(seed, arms=["elbow3r"], effects=True)).missing
        and max(share for *_, share in run.missing) > 0.08
    )
    assert {name for name, *_ in run.missing} == {effect}
    assert _error(run) > 1e-3


def _log(N: int = 4000, n: int = 3) -> Log:
    t = np.arange(N) * 1e-3
    w = 2 * np.pi * np.array([0.5, 0.8, 1.1])[:n]
    angle = t[:, None] * w + np.arange(n)
    return Log(t, np.sin(angle), w * np.cos(angle), 10 * np.sin(2 * angle) + 1)


@pytest.mark.slow
@pytest.mark.parametrize("speeds", [True, False])
@pytest.mark.parametrize("fault", [*LIGHT, *HEAVY], ids=lambda fault: fault.__name__)
def test_a_fault_changes_the_channels_that_it_says_and_no_others(fault, speeds: bool) -> None:
    clean = _log()
    log = clean if speeds else Log(clean.t, clean.q, None, clean.tau)
    if not speeds and fault.__name__ in ("late_speeds", "speeds_scaled", "speeds_delayed"):
        pytest.skip("a fault of speeds")
    for seed in range(20):
        spoiled, record = fault(log, np.random.default_rng(seed))
        assert record.name.startswith(fault.__name__)
        assert np.all(np.diff(spoiled.t) > 0)
        assert (spoiled.qd is None) == (log.qd is None)
        if len(spoiled.t) != len(log.t):
            continue  # rows were added
        changed = set() if np.array_equal(spoiled.t, log.t) else {"t"}
        for key in ("q", "qd", "tau"):
            before, after = getattr(log, key), getattr(spoiled, key)
            if before is not None:
                differ = np.any(before != after, axis=0)
                changed |= {f"{key}{j + 1}" for j in np.flatnonzero(differ)}
        assert changed, record
        assert not record.channels or changed <= set(record.channels), record
        named = {c for c in record.channels if speeds or not c.startswith("qd")}
        assert named <= changed or record.name == "wrapped", record
    np.testing.assert_array_equal(log.q, _log().q)
