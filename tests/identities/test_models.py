"""Every model of random serial and tree arms: identities, and Pinocchio as a witness."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from oracles.following import following_arm
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import jacobians, parameter_vector, world_transforms
from support import parsed, robot_of, sampled

import symgen
from symgen.codegen.kernels import regrouped

# From 100 on, some joints follow others.
SEEDS = [*sampled(range(24), 6), *sampled(range(100, 116), 3)]


KERNELS = (
    "energy_regressor",
    "friction_power",
    "power_regressor",
    "momentum_regressor",
    "torque_regressor",
    "inverse_dynamics",
    "mass_matrix",
    "gravity_torque",
    "coriolis",
    "bias_torque",
    "forward_dynamics",
    "energy",
    "frames",
    "jacobian",
)


class Case:
    """One random arm with its compiled model, physical parameters and a state."""

    def __init__(self, seed: int, friction: tuple[str, ...]) -> None:
        if seed < 100:
            self.arm = random_arm(seed, max_joints=6)
            self.G, self.c = np.eye(self.arm.n), np.zeros(self.arm.n)
            robot, flags = robot_of(self.arm, friction, True), True
        else:
            chosen = following_arm(seed)
            self.arm, self.G, self.c = chosen.arm, chosen.G, chosen.c
            words = ", ".join(f'"{word}"' for word in friction)
            text = chosen.text.replace('["coulomb", "viscous"]', f"[{words}]")
            robot, flags = parsed(text), chosen.rotors()
        self.model = symgen.derive(robot, KERNELS)
        self.evaluator = symgen.load(self.model, backend="casadi")
        self.links, rotors = random_parameters(self.arm, seed)
        inertial = parameter_vector(self.arm, self.links, rotors, flags)
        own = np.array([flags is True or flags[j - 1] for j in self.arm.movable])
        self.rotors = rotors * own
        draw = np.random.default_rng(seed)
        count = len(self.model.base.standard) - len(inertial)
        standard = [*inertial, *draw.uniform(0.1, 1, count)]
        self.X = np.array(regrouped(self.model.base, standard, robot.values()))
        self.q, self.qd, self.qdd = draw.uniform(-1, 1, (3, robot.n))
        self.q_tree = self.G @ self.q + self.c

    def __call__(self, kernel: str, *inputs):
        return self.evaluator[kernel](*inputs)


@cache
def case(seed: int, rub: bool = True) -> Case:
    return Case(seed, ("coulomb", "viscous", "offset") if rub else ())


def _close(a, b, tolerance: float = 1e-10) -> None:
    np.testing.assert_allclose(a, b, atol=tolerance * (1 + np.abs(b).max(initial=0.0)), rtol=0)


@pytest.mark.parametrize("seed", SEEDS)
def test_regressors_times_parameters_are_the_models(seed: int) -> None:
    c = case(seed)
    tau = c("inverse_dynamics", c.q, c.qd, c.qdd, c.X)
    _close(c("torque_regressor", c.q, c.qd, c.qdd) @ c.X, tau)
    _close(c("power_regressor", c.q, c.qd, c.qdd) @ c.X, c.qd @ tau)
    p, _ = c("momentum_regressor", c.q, c.qd)
    inertial = c.X[: c.model.inertial]
    _close(p @ inertial, c("mass_matrix", c.q, c.X) @ c.qd)
    T, U = c("energy", c.q, c.qd, c.X)
    _close(c.evaluator.energy_regressor(c.q, c.qd) @ inertial, T[0] + U[0])
    _close(T[0], 0.5 * c.qd @ c("mass_matrix", c.q, c.X) @ c.qd)


@pytest.mark.parametrize("seed", SEEDS)
def test_power_is_the_rate_of_energy_plus_friction(seed: int) -> None:
    c = case(seed)
    h = 1e-5
    ahead, behind = (
        c.evaluator.energy_regressor(c.q + s * c.qd + s * s / 2 * c.qdd, c.qd + s * c.qdd)
        for s in (h, -h)
    )
    rate = (ahead - behind) / (2 * h)
    power = c("power_regressor", c.q, c.qd, c.qdd)
    _close(power[: c.model.inertial], rate, 1e-7)
    _close(power[c.model.inertial :], c.evaluator.friction_power(c.q, c.qd))


@pytest.mark.parametrize("seed", SEEDS)
def test_momentum_columns_are_derivatives_of_the_energy_columns(seed: int) -> None:
    c = case(seed)
    h = 1e-5
    p, dl = c("momentum_regressor", c.q, c.qd)
    zero = np.zeros_like(c.qd)

    def lagrangian(q, qd):
        return c.evaluator.energy_regressor(q, qd) - 2 * c.evaluator.energy_regressor(q, zero)

    for j in range(len(c.q)):
        step = h * np.eye(len(c.q))[j]
        by_speed = lagrangian(c.q, c.qd + step) - lagrangian(c.q, c.qd - step)
        by_place = lagrangian(c.q + step, c.qd) - lagrangian(c.q - step, c.qd)
        _close(p[j], by_speed / (2 * h), 1e-7)
        _close(dl[j], by_place / (2 * h), 1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_inverse_dynamics_is_the_sum_of_its_parts(seed: int) -> None:
    c = case(seed)
    M, bias = c("mass_matrix", c.q, c.X), c("bias_torque", c.q, c.qd, c.X)
    tau = c("inverse_dynamics", c.q, c.qd, c.qdd, c.X)
    _close(M @ c.qdd + bias, tau)
    friction = c("torque_regressor", c.q, c.qd, 0 * c.q)[:, c.model.inertial :]
    rubbing = friction @ c.X[c.model.inertial :]
    coriolis = c("coriolis", c.q, c.qd, c.X) @ c.qd
    _close(coriolis + c("gravity_torque", c.q, c.X) + rubbing, bias)
    _close(c("forward_dynamics", c.q, c.qd, tau, c.X), c.qdd, 1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrix_is_symmetric_positive_definite_and_its_rate_matches_coriolis(
    seed: int,
) -> None:
    c = case(seed)
    M = c("mass_matrix", c.q, c.X)
    _close(M, M.T, 1e-14)
    assert np.linalg.eigvalsh(M).min() > 0
    h = 1e-5
    rate = (c("mass_matrix", c.q + h * c.qd, c.X) - c("mass_matrix", c.q - h * c.qd, c.X)) / (2 * h)
    skew = rate - 2 * c("coriolis", c.q, c.qd, c.X)
    _close(skew + skew.T, np.zeros_like(skew), 1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_coriolis_is_the_factor_of_christoffel_symbols(seed: int) -> None:
    # Theirs alone among the skew-symmetric ones is symmetric: C(q, a) b = C(q, b) a.
    c = case(seed)
    a, b = c.qd, c.qdd
    _close(c("coriolis", c.q, a, c.X) @ b, c("coriolis", c.q, b, c.X) @ a, 1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_frames_and_jacobian_are_those_of_plain_transforms(seed: int) -> None:
    c = case(seed)
    frames = world_transforms(c.arm, c.q_tree)
    _close(c("frames", c.q), frames, 1e-13)
    _close(c("jacobian", c.q), jacobians(c.arm, frames)[-1] @ c.G, 1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_dynamics_are_those_of_pinocchio(seed: int) -> None:
    pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
    from oracles.pinocchio_arm import PinocchioArm

    c = case(seed, rub=False)
    witness = PinocchioArm(c.arm, c.links, c.rotors)
    tau = witness.inverse_dynamics(c.q_tree, c.G @ c.qd, c.G @ c.qdd)
    _close(c("inverse_dynamics", c.q, c.qd, c.qdd, c.X), c.G.T @ tau)
    _close(c("mass_matrix", c.q, c.X), c.G.T @ witness.mass_matrix(c.q_tree) @ c.G)
    still = np.zeros_like(c.q_tree)
    weight = witness.inverse_dynamics(c.q_tree, still, still)
    _close(c("gravity_torque", c.q, c.X), c.G.T @ weight)


def test_forward_dynamics_says_that_the_mass_matrix_is_not_positive_definite() -> None:
    model = symgen.derive(symgen.read_robot("planar2r"), "all")
    X = np.array([1.702, -0.05644, 0.15, 0.075])
    q = np.zeros(2)
    evaluator = symgen.load(model)
    if evaluator.backend != "c":
        pytest.skip("no C compiler")
    with pytest.raises(symgen.ParameterError, match="not positive definite"):
        evaluator["forward_dynamics"](q, q, q, X)
    with pytest.raises(symgen.ParameterError, match="not positive definite"):
        evaluator["forward_dynamics"](np.zeros((3, 2)), np.zeros((3, 2)), np.zeros((3, 2)), X)


def test_couplings_and_payload_are_in_torques_and_regressors() -> None:
    text = """
    [robot]
    name = "wrist"
    gravity = [0.5, 1.0, -9.7]
    [[joint]]
    [[joint]]
    alpha = "pi/2"
    d = 0.3
    [[joint]]
    alpha = "-pi/2"
    r = 0.2
    [[coupling]]
    joints = [2, 3]
    ratio = -1.5
    [payload]
    joint = 3
    """
    kernels = ("inverse_dynamics", "torque_regressor", "power_regressor")
    model = symgen.derive(symgen.parse_robot(text), kernels)
    assert {"IAM3", "FVM3", "FSM3"} <= set(model.base.names)
    assert "XX3 - YY3 + XXL - YYL" in {p.expression for p in model.base.parameters}
    evaluator = symgen.load(model)
    draw = np.random.default_rng(0)
    q, qd, qdd = draw.uniform(-1, 1, (3, 3))
    X = draw.uniform(0.5, 1, len(model.base.parameters))
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    # F = IAM u' + FVM u + FSM sign(u) on joint 2, ratio F on joint 3.
    value = dict(zip(model.base.names, X, strict=True))
    without = X.copy()
    for name in ("IAM3", "FVM3", "FSM3"):
        without[model.base.names.index(name)] = 0.0
    u, up = qd[1] - 1.5 * qd[2], qdd[1] - 1.5 * qdd[2]
    F = value["IAM3"] * up + value["FVM3"] * u + value["FSM3"] * np.sign(u)
    rest = evaluator["inverse_dynamics"](q, qd, qdd, without)
    np.testing.assert_allclose(tau - rest, [0, F, -1.5 * F], atol=1e-12)
    np.testing.assert_allclose(evaluator["torque_regressor"](q, qd, qdd) @ X, tau)
    np.testing.assert_allclose(evaluator["power_regressor"](q, qd, qdd) @ X, qd @ tau)
