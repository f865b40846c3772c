"""Forward dynamics by articulated bodies, as robots with many joints have it, on small arms too."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import parameter_vector
from support import parsed, robot_of, sampled

import symgen
from symgen.codegen.kernels import regrouped
from symgen.symbolic import forward
from symgen.symbolic.tape import Numbers

FUNCTIONS = {"sin": np.sin, "cos": np.cos, "abs": np.abs, "sign": np.sign, "tanh": np.tanh}


def of(model: symgen.Model, name: str, **given: np.ndarray) -> np.ndarray:
    """Run the tape of a kernel."""
    (kernel,) = (k for k in model.kernels if k.name == name)
    columns = {n: list(given[n][: len(s)]) for n, s in kernel.tape.inputs}
    return np.array(kernel.tape.run(Numbers(model.robot.values(), FUNCTIONS), columns), float)


@pytest.mark.parametrize("seed", sampled(range(12), 5))
def test_it_undoes_inverse_dynamics_and_its_pivots_are_those_of_the_mass_matrix(
    seed, monkeypatch
) -> None:
    """Chains and trees, joints that turn, slide or are fixed; the factor of M is the witness."""
    arm = random_arm(seed, max_joints=6)
    robot = robot_of(arm, ("viscous",), True)
    kernels = ("inverse_dynamics", "forward_dynamics", "mass_matrix")
    monkeypatch.setattr(forward, "MANY", 1)
    model = symgen.derive(robot, kernels)
    links, rotors = random_parameters(arm, seed)
    n, p = arm.n, model.base.standard
    inertial = parameter_vector(arm, links, rotors, True)
    draw = np.random.default_rng(seed)
    standard = [*inertial, *draw.uniform(0.1, 1, len(p) - len(inertial))]
    X = np.array(regrouped(model.base, standard, robot.values()))
    q, qd, qdd = draw.uniform(-2, 2, (3, n))
    tau = of(model, "inverse_dynamics", q=q, qd=qd, qdd=qdd, X=X)
    found = of(model, "forward_dynamics", q=q, qd=qd, tau=tau, X=X)
    np.testing.assert_allclose(found[:n], qdd, rtol=1e-9, atol=1e-9)
    M = of(model, "mass_matrix", q=q, X=X).reshape(n, n)
    least = np.linalg.cholesky(M[::-1, ::-1])  # from the tips
    np.testing.assert_allclose(found[n:], np.diag(least) ** 2, rtol=1e-9)


def test_twice_the_joints_are_twice_the_steps() -> None:
    """Where the mass matrix is factored they are three times as many."""

    def steps(joints: int) -> int:
        joint = '[[joint]]\nalpha = "pi/2"\nd = 0.1\nr = 0.2\n'
        robot = parsed('[robot]\nname = "arm"\ngravity = [0, 0, -9.81]\n' + joints * joint)
        (kernel,) = symgen.derive(robot, ("forward_dynamics",)).kernels
        return len(kernel.tape.steps)

    few = steps(forward.MANY)
    assert 1.9 * few < steps(2 * forward.MANY) < 2.2 * few
