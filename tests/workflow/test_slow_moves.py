"""Slow moves with coarse encoders: as good as the fit of an engineer who filters near the motion.

The speed of quantised positions is mostly steps of the encoder, up to any frequency; the motion
lies below half a hertz, and who looks at it filters at 1 Hz. Bodies are Pinocchio's.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles import clean_runs, engineer
from oracles.random_arms import to_toml
from simulated_runs import Truth, evaluator, identified
from support import sampled

FILTER = 1.0  # Hz, of the engineer


def slow(seed: int) -> clean_runs.Run:
    """Joints move at 0.05 to 0.3 rad/s, read in steps of 1e-3 to 5e-3 rad, for 25 s."""
    rng = np.random.default_rng([seed, 79])
    arm, rate = clean_runs.ARMS["planar2r"], 200.0
    home, top = rng.uniform(-0.8, 0.8, arm.n), float(rng.uniform(0.2, 0.4))
    motions = [
        clean_runs.motion_of(rng, "fourier", top, rng.uniform(0.5, 1.8, arm.n), home, *span)
        for span in ((25.0, 1 / rate), (12.5, 1 / rate), (12.5, 1 / clean_runs.CLEAN_RATE))
    ]
    slower = min(1.0, rng.uniform(0.05, 0.3) / np.abs(motions[0].qd).max())
    motions = [
        clean_runs.Motion(m.t, home + slower * (m.q - home), slower * m.qd, slower * m.qdd)
        for m in motions
    ]
    machine = clean_runs.machine_of(rng, arm, motions[0])
    torques = [machine.torque(m) for m in motions]
    how = clean_runs.instruments_of(rng, False, (0.005, 0.02))
    how |= {"encoder": float(rng.uniform(1e-3, 5e-3))}
    train, held, _ = (
        clean_runs.recorded(rng, m, tau, how) for m, tau in zip(motions, torques, strict=True)
    )
    friction = ("coulomb", "viscous", *(("offset",) if machine.offset.any() else ()))
    text = to_toml(arm, "slow", friction)
    return clean_runs.Run(text, train, held, motions[2], torques[2], machine.torque, (), how)


@pytest.mark.parametrize("seed", sampled([1, 2, 3], 0, always=[1]))
def test_slow_moves_are_filtered_near_the_motion(seed: int) -> None:
    run = slow(seed)
    log = engineer.even(run.train.t, run.train.q, None, run.train.tau)
    comparison = engineer.comparison_band([log])
    kernel = evaluator(run.robot_toml)["torque_regressor"]
    own = engineer.least_squares(*engineer.equations(kernel, log, FILTER, comparison, True))
    found = np.array([p["value"] for p in identified(run)["parameters"]])
    truth = Truth(run, comparison)
    # What is below 0.2 % of the torque matters to nobody.
    assert truth.error(found) < max(1.1 * truth.error(own), 0.002)
