"""Effects as columns: the same torque in every kernel, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import symgen

BASE = """
[robot]
name = "arm"
[[joint]]
[[joint]]
alpha = "pi/2"
[[joint]]
d = 0.4
"""
EFFECTS = """
[[effect]]
name = "gravity_spring"
joints = [2]
[[effect]]
name = "stribeck_friction"
joints = [3, 1]
nonlinear = { vs = 0.05 }
[[effect]]
name = "nonlinear_viscous_friction"
joints = [1]
nonlinear = { p = 0.6 }
[[effect]]
name = "torque_ripple"
joints = [2]
nonlinear = { k = 8 }
[[effect]]
name = "detent"
joints = [1]
torque = "-A*(q1-c)*exp(-((q1-c)/w)**2) + B*max(qd2, 0.1)*tan(q3)/(2 + cos(q1))"
linear = { A = "N m/rad", B = "N m" }
nonlinear = { c = 0.31, w = 0.18 }
"""


@pytest.fixture(scope="module")
def model() -> symgen.Model:
    return symgen.derive(symgen.parse_robot(BASE + EFFECTS), "all")


def _expected(q, qd) -> dict[str, tuple[int, float]]:
    """Column (joint, value) of every coefficient, written by hand."""
    u = (q[0] - 0.31) / 0.18
    ripple = 8 * q[1]
    return {
        "K2": (1, q[1]),
        "FST3": (2, np.sign(qd[2]) * np.exp(-((qd[2] / 0.05) ** 2))),
        "FST1": (0, np.sign(qd[0]) * np.exp(-((qd[0] / 0.05) ** 2))),
        "FVN1": (0, np.sign(qd[0]) * abs(qd[0]) ** 0.6),
        "RS2": (1, -np.sin(ripple)),
        "RC2": (1, -np.cos(ripple)),
        "A": (0, (q[0] - 0.31) * np.exp(-(u**2))),
        "B": (0, -max(qd[1], 0.1) * np.tan(q[2]) / (2 + np.cos(q[0]))),
    }


@pytest.mark.parametrize("backend", [None, "casadi"])
def test_an_effect_is_the_same_column_in_every_kernel(model: symgen.Model, backend) -> None:
    evaluator = symgen.load(model, backend=backend) if backend else symgen.load(model)
    draw = np.random.default_rng(0)
    names = list(model.base.names)
    for _ in range(5):
        q, qd, qdd = draw.uniform(-1, 1, (3, 3))
        X = draw.uniform(0.1, 1, len(names))
        W = evaluator["torque_regressor"](q, qd, qdd)
        columns = _expected(q, qd)
        assert names[-len(columns) :] == list(columns)
        for name, (joint, value) in columns.items():
            expected = value * np.eye(3)[joint]
            np.testing.assert_allclose(W[:, names.index(name)], expected, atol=1e-13)
        tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
        np.testing.assert_allclose(W @ X, tau, atol=1e-12)
        power = evaluator["power_regressor"](q, qd, qdd)
        np.testing.assert_allclose(power, qd @ W, atol=1e-12)
        rubbing = slice(model.inertial, None)
        np.testing.assert_allclose(evaluator["friction_power"](q, qd), power[rubbing], atol=1e-13)
        np.testing.assert_allclose(evaluator["friction_torque"](q, qd), W[:, rubbing], atol=1e-13)
        M, bias = evaluator["mass_matrix"](q, X), evaluator["bias_torque"](q, qd, X)
        np.testing.assert_allclose(M @ qdd + bias, tau, atol=1e-12)


def test_a_robot_with_effects_is_written_and_read_again(model: symgen.Model) -> None:
    assert symgen.parse_robot(symgen.robot_toml(model.robot)) == model.robot


def test_an_effect_is_identified_as_a_parameter(model: symgen.Model) -> None:
    t = np.arange(0, 20, 0.004)
    draw = np.random.default_rng(1)
    f, phase = draw.uniform(0.1, 0.9, (2, 5, 3)), draw.uniform(0, 6, (5, 3))
    q = sum(0.3 * np.sin(2 * np.pi * f[0, k] * t[:, None] + phase[k]) for k in range(5))
    spline = __import__("scipy.interpolate", fromlist=["x"]).make_interp_spline(t, q, k=5)
    qd, qdd = spline.derivative()(t), spline.derivative(2)(t)
    X = draw.uniform(0.5, 1, len(model.base.names))
    evaluator = symgen.load(model)
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    log = symgen.Log("made", t, q, qd, tau)
    for kind in ("torque", "momentum"):
        estimate = symgen.identify(evaluator, log, model=kind, cutoff=60.0)
        found = {p.name: p.value for p in estimate.parameters}
        for name in ("K2", "RS2", "RC2", "A", "FVN1"):
            truth = X[model.base.names.index(name)]
            assert found[name] == pytest.approx(truth, rel=0.02), (kind, name)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('name = "torque_ripple"\njoints = [2]\nnonlinear = { k = 1 }', "RS2 is nothing new"),
        ('name = "own"\njoints = [1]\ntorque = "C*qd1"\nlinear = { C = "N" }', "C is nothing new"),
        ('name = "coulomb_friction"\njoints = [1]', "a word of the joint's friction: 'coulomb'"),
        ('name = "rotor_inertia"\njoints = [1]', "rotor_inertia of the joint"),
        ('name = "time_delay"\njoints = [1]', "kind log"),
        ('name = "what"\njoints = [1]', "'what' is no effect"),
        ('name = "torque_ripple"\njoints = [2]', "constants none; accepted: k"),
        ('name = "gravity_spring"\njoints = [9]', "9 is not a movable joint"),
        ('name = "gravity_spring"\njoints = [1, 1]', "each joint once"),
        ('name = "own"\njoints = [1]\ntorque = "A*A*q1"\nlinear = { A = "N" }', "not a sum of"),
        ('name = "own"\njoints = [1]\ntorque = "A*q1 + 1"\nlinear = { A = "N" }', "not a sum of"),
        ('name = "own"\njoints = [1]\ntorque = "q1"\nlinear = { A = "N" }', "not a sum of"),
        ('name = "own"\njoints = [1]\ntorque = "A*q8"\nlinear = { A = "N" }', "found 'q8'"),
        ('name = "own"\njoints = [1]\ntorque = "A*q1"\nlinear = { M1 = "N" }', "'M1': reserved"),
        ('name = "own"\njoints = [1]\ntorque = "open(A)"\nlinear = { A = "N" }', "found 'open'"),
    ],
)
def test_effects_that_are_refused(table: str, message: str) -> None:
    with pytest.raises(symgen.RobotError, match=message) as caught:
        symgen.derive(symgen.parse_robot(f"{BASE}[[effect]]\n{table}\n"))
    assert "\n" not in str(caught.value)


def test_an_effect_stands_once() -> None:
    with pytest.raises(symgen.RobotError, match="effect 6: K2 is declared twice"):
        symgen.parse_robot(BASE + EFFECTS + '[[effect]]\nname = "gravity_spring"\njoints = [2]\n')
