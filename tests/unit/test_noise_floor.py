"""What noise leaves of a torque, friction takes, and a recorder omits: on logs of known truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import symgen
from symgen.data.log import make_log
from symgen.data.signals import sampled
from symgen.estimation.band import Band
from symgen.estimation.filtered_log import FilteredLog, filter_log
from symgen.estimation.floor import noise_floor
from symgen.estimation.predictive_score import MISFIT
from symgen.faults.causes import Cause, unmendable
from symgen.faults.fault import undo_faults
from symgen.faults.scene import Rows, Scene, mean_friction_power
from symgen.faults.shapes import KINDS

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


def _pendulum(fault: Callable[[np.ndarray], np.ndarray]) -> tuple[FilteredLog, Scene, np.ndarray]:
    """Return a log of a pendulum (0.3 kg m2, 4 N m), its scene, and its true torque."""
    robot = symgen.parse_robot(ARM[: ARM.rindex("[[joint]]")], "arm")
    evaluator = symgen.load(symgen.derive(robot, ("torque_regressor", "inverse_dynamics")))
    q, qd = Q[:, :1], QD[:, :1]
    whole = -0.3 * q + 4.0 * np.cos(q) + 0.5 * qd + 0.2 * np.sign(qd)
    samples = sampled(make_log("log", T, q, whole + fault(whole), qd))
    log = filter_log(samples, Band(1 / STEP, 20.0, 5.0, "measured"))
    return log, Scene(Rows(evaluator, (log,), 1, MISFIT)), whole


def test_a_torque_without_half_of_the_weight_is_completed() -> None:
    log, scene, whole = _pendulum(lambda _: -2.0 * np.cos(Q[:, :1]))
    half = Cause("weightless", (), "", 0.0, np.zeros(1), shares=(1.0, 0.5))
    completed, _ = undo_faults(log, [unmendable(scene, half)])
    np.testing.assert_allclose(completed.tau, whole, atol=0.02)


def test_friction_that_grows_with_load_and_speed_is_physics_that_a_model_may_lack() -> None:
    _, scene, _ = _pendulum(lambda tau: 0.02 * QD[:, :1] * np.abs(tau))
    W, y = scene.rows.W[:, 0], scene.rows.y[:, 0]

    def left(columns: np.ndarray) -> float:
        A = np.hstack([W, columns])
        return float(np.linalg.norm(y - A @ np.linalg.lstsq(A, y, rcond=None)[0]))

    laws = [s.columns[0] for s in KINDS["physics"](scene) if s.size == np.inf]
    assert min(map(left, laws)) < 0.05 * left(W[:, :0])
