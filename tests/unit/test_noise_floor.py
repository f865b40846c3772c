"""What noise leaves of a torque, and what friction takes: on logs whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

import symgen
from symgen.data.log import make_log
from symgen.data.signals import sampled
from symgen.estimation.band import Band
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.floor import noise_floor
from symgen.faults.scene import mean_friction_power

ARM = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["coulomb", "viscous"]
[[joint]]
d = 0.5
friction = ["coulomb", "viscous", "offset"]
"""
STEP = 0.002
T = np.arange(0, 40, STEP)
Q = np.column_stack([np.sin(T), np.cos(0.7 * T)])
QD = np.column_stack([np.cos(T), -0.7 * np.sin(0.7 * T)])


def _log(qd: np.ndarray, velocity: str) -> FilteredLog:
    samples = sampled(make_log("log", T, Q, np.zeros_like(Q), qd))
    return filter_log(samples, Band(1 / STEP, 20.0, 5.0, velocity))


@pytest.mark.parametrize(("velocity", "share"), [("measured", 1.0), ("derived", 0.0)])
def test_the_floor_has_the_noise_of_speeds_where_they_are_used(velocity: str, share: float) -> None:
    """Of 0.1 rad/s, white, a part 5 Hz / 250 Hz is in the band; viscous friction 3 makes torque."""
    log = _log(QD + np.random.default_rng(3).normal(0, 0.1, QD.shape), velocity)
    floor = noise_floor(log, np.zeros_like(Q), lambda log: 3.0 * log.qd)
    assert floor == pytest.approx(share * 3.0 * 0.1 * np.sqrt(5 / 250), rel=0.2, abs=1e-3)


def test_friction_takes_the_power_of_its_torque_times_the_speed() -> None:
    robot = symgen.parse_robot(ARM, "arm")
    evaluator = symgen.load(symgen.derive(robot, ("torque_regressor",)))
    power, speed = mean_friction_power(evaluator, [_log(QD, "measured")], len(T))
    names = [p.name for p in evaluator.model.base.parameters]
    for j in (0, 1):
        taken = dict(zip(names, power[j], strict=True))
        assert taken.pop(f"FS{j + 1}") == pytest.approx(np.mean(np.abs(QD[:, j])), rel=2e-2)
        assert taken.pop(f"FV{j + 1}") == pytest.approx(np.mean(QD[:, j] ** 2), rel=2e-2)
        assert not any(taken.values())
    assert speed == pytest.approx(np.sqrt(np.mean(QD**2, axis=0)), rel=2e-2)
