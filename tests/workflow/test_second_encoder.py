"""A joint that bends between motor and link, with an encoder on both: its stiffness.

The oracle is two masses with a spring between them, each with its own equation, integrated by
SciPy: the motor with its friction and a controller, the link a pendulum.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symgen

STEP, SECONDS = 0.002, 20.0
K, D = 900.0, 0.8
LINK, MOTOR, WEIGHT, FS, FV = 0.9, 0.5, 18.0, 0.8, 0.6  # kg m2, kg m2, N m, N m, N m s/rad
ROBOT = """
[robot]
name = "bends"
gravity = [0.0, -9.81, 0.0]
[[joint]]
friction = ["coulomb", "viscous"]
"""


@cache
def motion(seed: int, stiffness: float) -> tuple[np.ndarray, ...]:
    """t, motor's position and speed, link's position, and the motor's torque."""
    rng = np.random.default_rng(seed)
    w, phase = np.array([1.1, 2.7, 5.3]), rng.uniform(0, 2 * np.pi, 3)
    a = np.array([0.8, 0.35, 0.12])

    def wanted(t):
        angle = w * np.asarray(t)[..., None] + phase
        return (a * np.sin(angle)).sum(-1), (a * w * np.cos(angle)).sum(-1)

    def torque(t, q, qd):
        aim, rate = wanted(t)
        return 900.0 * (aim - q) + 60.0 * (rate - qd)

    def slopes(t, x):
        q, qd, s, sd = x
        spring = stiffness * (q - s) + D * (qd - sd)
        dry = FS * np.tanh(qd / 1e-3)
        return [
            qd,
            (torque(t, q, qd) - spring - dry - FV * qd) / MOTOR,
            sd,
            (spring - WEIGHT * np.cos(s)) / LINK,
        ]

    t = np.arange(0.0, SECONDS, STEP)
    aim, rate = wanted(0.0)
    found = solve_ivp(
        slopes, (0, t[-1]), [aim, rate, aim - WEIGHT * np.cos(aim) / stiffness, rate],
        t_eval=t, method="LSODA", rtol=1e-8, atol=1e-10,
    )  # fmt: skip
    q, qd, s, _ = found.y
    return t, q, qd, s, torque(t, q, qd)


def log(seed: int, stiffness: float = K, *, second: bool = True, noise: float = 2e-5) -> symgen.Log:
    t, q, qd, s, tau = motion(seed, stiffness)
    rng = np.random.default_rng(seed + 100)
    tau = tau + 0.01 * np.std(tau) * rng.normal(size=len(t))
    measured = [x + noise * rng.normal(size=len(t)) for x in (q, s)]
    speed = qd + 1e-3 * rng.normal(size=len(t))
    return symgen.make_log(
        f"log {seed}", t, measured[0], tau, speed, qs=measured[1] if second else None
    )


def answered(**how) -> symgen.Diagnosis:
    effects = how.pop("effects", None)
    logs = [log(seed, **how) for seed in (1, 2, 3)]
    robot = symgen.parse_robot(ROBOT)
    return symgen.diagnose(robot, logs[:2], validation=logs[2:], effects=effects)


def test_the_stiffness_is_measured_within_its_std() -> None:
    answer = answered()
    (found,) = [e for e in answer.effects if e.name == "joint_elasticity"]
    stiffness, damping, *_ = found.parameters
    assert (stiffness.name, stiffness.unit) == ("K1", "N m/rad")
    assert stiffness.value == pytest.approx(K, rel=0.05)
    assert abs(stiffness.value - K) < 3 * stiffness.std < 0.05 * K
    assert abs(damping.value - D) < 3 * damping.std + 0.2 * D
    assert answer.after.total <= answer.before.total
    assert answer.verdict == "explained"


def test_a_soft_joint_alone_explains_its_torque() -> None:
    answer = answered(stiffness=250.0)
    assert [(e.name, e.joints) for e in answer.effects] == [("joint_elasticity", (1,))]
    values = {p.name: p for p in answer.effects[0].parameters}
    assert values["K1"].value == pytest.approx(250.0, rel=0.01)
    assert values["IA1"].value == pytest.approx(MOTOR, rel=0.1)  # the model has it in ZZ1R
    assert answer.after.total < 0.15 * answer.before.total


def test_the_std_covers_over_many_logs() -> None:
    from symgen.diagnosis.baseline import KERNELS
    from symgen.diagnosis.stiffness import stiffnesses
    from symgen.diagnosis.whitened_system import fitted_system
    from symgen.estimation.cutoff import choose_band
    from symgen.estimation.filtered_log import filter_log
    from symgen.faults.logs import open_samples

    robot = symgen.parse_robot(ROBOT)
    evaluator = symgen.load(symgen.derive(robot, KERNELS))
    off = []
    for seed in range(10, 18):
        samples, _ = open_samples(log(seed), robot)
        band = choose_band(evaluator, [samples])
        (found,) = stiffnesses(fitted_system(evaluator, [filter_log(samples, band)]))
        assert not found.fault
        off.append((found.stiffness[0] - K) / found.stiffness[1])
    assert np.mean(np.abs(off) < 3) > 0.8, off


def test_without_a_second_encoder_that_is_said() -> None:
    answer = answered(second=False, effects=["joint_elasticity"])
    assert not any(p.name == "K1" for e in answer.effects for p in e.parameters)
    assert any("without a second encoder" in note for note in answer.notes)


def test_a_stiff_joint_has_no_stiffness() -> None:
    answer = answered(stiffness=3e5, noise=1e-4)
    assert not answer.effects
    assert any("noise of its two encoders" in note for note in answer.notes)
