"""Effects that hold the torque of the rigid body: dynamics by hand, both ways, and identified."""

from __future__ import annotations

import numpy as np
import pytest

import symgen
from symgen.codegen.package import generate

ARM = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[[joint]]
[[joint]]
d = 0.5
alpha = "pi/2"
coulomb_width = 0.01
[[joint]]
d = 0.4
friction = ["coulomb", "viscous", "offset"]
"""
EFFECTS = """
[[effect]]
name = "load_dependent_friction"
joints = [1, 2]
[[effect]]
name = "mine"
joints = [3]
torque = "-A*q3 - B*abs(taur3)*sign(qd3) - C*taur3*cos(q3)"
linear = { A = "N m/rad", B = "", C = "" }
"""


@pytest.fixture(scope="module")
def evaluator() -> symgen.Evaluator:
    return symgen.load(symgen.derive(symgen.parse_robot(ARM + EFFECTS), "all"))


@pytest.fixture(scope="module")
def X(evaluator) -> np.ndarray:
    rigid = {"ZZ1R": 3.0, "ZZ2R": 1.2, "ZZ3": 0.4, "XX2R": 0.2, "XX3R": -0.1, "IA3": 0.2}
    loads = {"FL1": 0.05, "FL2": 0.1, "B": 0.08, "C": 0.04}
    return np.array([{**rigid, **loads}.get(n, 0.3) for n in evaluator.model.base.names])


def _states(count: int = 40) -> np.ndarray:
    return np.random.default_rng(3).normal(size=(3, count, 3))


def test_coefficients_of_the_load_come_last_and_have_no_column(evaluator) -> None:
    base = evaluator.model.base
    assert base.names[base.linear :] == ("FL1", "FL2", "B", "C")
    assert base.names[base.linear - 1] == "A"
    columns = evaluator.model.kernel("torque_regressor").outputs[0].columns
    assert columns == base.names[: base.linear]


def test_inverse_dynamics_is_rigid_body_friction_and_share_of_the_load(evaluator, X) -> None:
    q, qd, qdd = _states()
    base = evaluator.model.base
    W = evaluator["torque_regressor"](q, qd, qdd)
    rigid = W[:, :, : base.inertial] @ X[: base.inertial]
    friction = W[:, :, base.inertial :] @ X[base.inertial : base.linear]
    sign = np.sign(qd)
    sign[:, 1] = np.tanh(qd[:, 1] / 0.01)
    share = np.abs(rigid) * sign * [0.05, 0.1, 0.08]
    share[:, 2] += 0.04 * rigid[:, 2] * np.cos(q[:, 2])
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    assert tau == pytest.approx(rigid + friction + share, abs=1e-12)


def test_forward_dynamics_undoes_it(evaluator, X) -> None:
    q, qd, qdd = _states()
    # M(q) of made-up parameters is positive definite at these states.
    M = evaluator["mass_matrix"](q, X[: evaluator.model.inertial])
    good = np.linalg.eigvalsh(M).min(axis=1) > 0.05
    assert good.sum() > 10
    q, qd, qdd = q[good], qd[good], qdd[good]
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    assert evaluator["forward_dynamics"](q, qd, tau, X) == pytest.approx(qdd, abs=1e-10)


def test_a_share_of_the_load_that_lets_nothing_through_is_refused(evaluator, X) -> None:
    stuck = X.copy()
    stuck[evaluator.model.base.names.index("FL1")] = 1.5
    with pytest.raises(symgen.SymgenError, match="an effect of the load leaves no unique"):
        evaluator["forward_dynamics"]([0.1] * 3, [1.0] * 3, [1.0] * 3, stuck)


def test_a_package_with_them_has_no_identifier_and_says_their_kind(evaluator) -> None:
    import json

    tree = generate(evaluator.model)
    assert not [path for path in tree.files if "identifier" in path]
    manifest = json.loads(tree.files["manifest.json"])
    assert {"name": "mine", "kind": "model"} in manifest["effects"]
    assert {"name": "load_dependent_friction", "kind": "model"} in manifest["effects"]
    assert [p["name"] for p in manifest["base_parameters"]] == list(evaluator.model.base.names)


@pytest.mark.parametrize("torque", ["-B*taur3**2", "-B*taur3*sin(taur3)", "-B*taur1*sign(qd3)"])
def test_torques_that_forward_dynamics_cannot_solve_are_refused(torque: str) -> None:
    text = f'[[effect]]\nname = "mine"\njoints = [3]\ntorque = "{torque}"\nlinear = {{ B = "" }}\n'
    with pytest.raises(symgen.RobotError, match="taur"):
        symgen.parse_robot(ARM + text)
