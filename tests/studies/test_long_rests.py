"""Errors after long standstills: `pytest -s -m slow tests/studies/test_long_rests.py`."""

from __future__ import annotations

import numpy as np
import pytest
import simulated_runs
from oracles import clean_runs, engineer, resting
from workflow.test_rests import true_error


@pytest.mark.slow
def test_moves_between_points_of_many_arms(capsys: pytest.CaptureFixture[str]) -> None:
    """Twenty draws over all arms: printed, what plain least squares gives at its best beside."""
    rows = []
    for seed in range(100, 120):
        arm = sorted(clean_runs.ARMS)[seed % len(clean_runs.ARMS)]
        run = resting.run(seed, arm)
        estimate = simulated_runs.identified(run)
        band = estimate["band"]["comparison_hz"]
        truth, log = simulated_runs.Truth(run, band), run.train
        even = engineer.even(log.t, log.q, log.qd, log.tau)
        kernel = simulated_runs.evaluator(run.robot_toml)["torque_regressor"]
        plain = min(
            truth.error(engineer.least_squares(*engineer.equations(kernel, even, hz, band)))
            for hz in (3.0, 5.0, 10.0)
        )
        rows.append((true_error(run, estimate), plain))
        with capsys.disabled():
            said = 100 * estimate["torque_residual"]["validation"]["relative"]
            own, other = (100 * x for x in rows[-1])
            print(
                f"{seed} {arm}, {100 * run.drawn['resting']:.0f} % at rest: "
                f"{estimate['verdict']}, says {said:.3g} %, is {own:.3g} %, plain {other:.3g} %"
            )
    own, plain = np.array(rows).T
    assert np.median(own / plain) < 0.2
    assert np.mean(own < plain) >= 0.9
