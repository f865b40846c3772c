"""Joints that follow, a screw, a coupling, a payload, effects and named lengths in one robot."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.random_arms import random_parameters
from oracles.transforms import LINK_PARAMETERS, Arm, world_transforms

import symgen
from symgen.codegen.model import regrouping

TEXT = """
[robot]
name = "together"
gravity = ["gx", 0, -9.81]
[geometry]
L1 = 0.4
L2 = 0.25
lead = 0.005
gx = 1.5
[[joint]]
friction = ["coulomb", "viscous", "offset"]
[[joint]]
alpha = "pi/2"
d = "L1"
[[joint]]                          # 3: a screw on joint 2
sigma = 1
r = 0.1
follows = "lead/(2*pi)*q2 + L1/2"
[[joint]]
antecedent = 2
d = "L2"
alpha = 0.3
follows = "pi/2 - q1 + L1/L2*q2/2"
[[joint]]
d = "L1"
alpha = "-pi/2"
[[joint]]                          # 6: on the screw
sigma = 2
antecedent = 3
d = "sqrt(2)*L1"
[[joint]]                          # 7: a mark on the base
sigma = 2
antecedent = 0
d = 1
[[coupling]]
joints = [1, 5]
ratio = "-L1"
[payload]
joint = 4
[[effect]]
name = "gravity_spring"
joints = [5]
[[effect]]
name = "a | b \\\\ c"
joints = [2]
torque = "X*sin(q1*L1/w)*pow(q5, 1.5) + I*abs(qd1)"
linear = { X = "N m", I = "N m s/rad" }
nonlinear = { w = "L2/2" }
"""
L1, L2, LEAD, RATIO = 0.4, 0.25, 0.005, -0.4
OWN = (1, 2, 5)
ARM = Arm.from_table(
    {
        "sigma": (0, 0, 1, 0, 0, 2, 2),
        "ant": (0, 1, 2, 2, 4, 3, 0),
        "alpha": (0, np.pi / 2, 0, 0.3, -np.pi / 2, 0, 0),
        "d": (0, L1, 0, L2, L1, np.sqrt(2) * L1, 1),
        "r": (0, 0, 0.1, 0, 0, 0, 0),
        "gravity": (1.5, 0, -9.81),
    }
)
G = np.array([[1, 0, 0], [0, 1, 0], [0, LEAD / (2 * np.pi), 0], [-1, 0.8, 0], [0, 0, 1.0]])
SHIFT = np.array([0, 0, L1 / 2, np.pi / 2, 0])
DRIVE = np.array([1, 0, RATIO])  # u = qd1 + ratio qd5


@pytest.fixture(scope="module")
def model() -> symgen.Model:
    return symgen.derive(symgen.parse_robot(TEXT), "all")


@pytest.mark.parametrize("backend", ["casadi", pytest.param("c", marks=pytest.mark.slow)])
def test_every_kernel_is_that_of_the_constrained_tree(model: symgen.Model, backend: str) -> None:
    pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
    from oracles.pinocchio_arm import PinocchioArm

    draw = np.random.default_rng(3)
    links, _ = random_parameters(ARM, 5)
    load = random_parameters(ARM, 6)[0][0]
    value = {p.name: draw.uniform(0.2, 1) for p in model.base.standard}
    for j, row in enumerate(links, 1):
        value |= {f"{name}{j}": x for name, x in zip(LINK_PARAMETERS, row, strict=True)}
    value |= {f"{name}L": x for name, x in zip(LINK_PARAMETERS, load, strict=True)}
    standard = [value[p.name] for p in model.base.standard]
    X = regrouping(model) @ standard
    carried = links.copy()
    carried[3] += load
    tree = PinocchioArm(ARM, carried)
    rotor = np.diag([value[f"IA{j}"] for j in OWN]) + value["IAM5"] * np.outer(DRIVE, DRIVE)

    def rubbing(q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        out = np.array(
            [
                value[f"FV{j}"] * v + value[f"FS{j}"] * np.sign(v)
                for j, v in zip(OWN, qd, strict=True)
            ]
        )
        u = DRIVE @ qd
        out += DRIVE * (value["FVM5"] * u + value["FSM5"] * np.sign(u))
        effect = value["X"] * np.sin(q[0] * 3.2) * abs(q[2]) ** 1.5 + value["I"] * abs(qd[0])
        return out + [value["OF1"], -effect, value["K5"] * q[2]]

    def mass(q: np.ndarray) -> np.ndarray:
        return G.T @ tree.mass_matrix(G @ q + SHIFT) @ G + rotor

    def torque(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        rigid = G.T @ tree.inverse_dynamics(G @ q + SHIFT, G @ qd, G @ qdd)
        return rigid + rotor @ qdd

    def lagrangian(q: np.ndarray, qd: np.ndarray) -> float:
        return qd @ mass(q) @ qd / 2 - tree.potential_energy(G @ q + SHIFT)

    f = symgen.load(model, backend=backend)
    inertial = X[: model.inertial]
    zero, step = np.zeros(3), 1e-5
    potential = f["energy"](zero, zero, inertial)[1] - tree.potential_energy(SHIFT)
    for _ in range(4):
        q, qd, qdd = draw.uniform(-2, 2, (3, 3))
        rigid, friction = torque(q, qd, qdd), rubbing(q, qd)
        tau = rigid + friction
        same = {"rtol": 0, "atol": 1e-11 * max(1.0, float(np.abs(tau).max()))}
        np.testing.assert_allclose(f["inverse_dynamics"](q, qd, qdd, X), tau, **same)
        np.testing.assert_allclose(f["torque_regressor"](q, qd, qdd) @ X, tau, **same)
        np.testing.assert_allclose(f["power_regressor"](q, qd, qdd) @ X, qd @ tau, **same)
        rubbed = X[model.inertial :]
        np.testing.assert_allclose(f["friction_torque"](q, qd) @ rubbed, friction, **same)
        np.testing.assert_allclose(f["friction_power"](q, qd) @ rubbed, qd @ friction, **same)
        M = mass(q)
        np.testing.assert_allclose(f["mass_matrix"](q, inertial), M, **same)
        np.testing.assert_allclose(f["bias_torque"](q, qd, X), tau - M @ qdd, **same)
        held = torque(q, zero, zero)
        np.testing.assert_allclose(f["gravity_torque"](q, inertial), held, **same)
        C = f["coriolis"](q, qd, inertial)
        np.testing.assert_allclose(C @ qd, rigid - M @ qdd - held, **same)
        slope = (mass(q + step * qd) - mass(q - step * qd)) / (2 * step)
        np.testing.assert_allclose(slope, C + C.T, atol=1e-7)
        np.testing.assert_allclose(f["forward_dynamics"](q, qd, tau, X), qdd, atol=1e-9)
        T, U = f["energy"](q, qd, inertial)
        np.testing.assert_allclose(T, qd @ M @ qd / 2, **same)
        np.testing.assert_allclose(U, tree.potential_energy(G @ q + SHIFT) + potential, atol=1e-10)
        np.testing.assert_allclose(f["energy_regressor"](q, qd) @ inertial, T + U, **same)
        momentum, change = f["momentum_regressor"](q, qd)
        np.testing.assert_allclose(momentum @ inertial, M @ qd, **same)
        slopes = [
            (lagrangian(q + e, qd) - lagrangian(q - e, qd)) / (2 * step) for e in step * np.eye(3)
        ]
        np.testing.assert_allclose(change @ inertial, slopes, atol=1e-6)
        frames = world_transforms(ARM, G @ q + SHIFT)
        np.testing.assert_allclose(f["frames"](q), frames, atol=1e-12)
        # The mark on the base does not move: the Jacobian is that of frame 6, on the screw.
        tips = [
            (
                world_transforms(ARM, G @ (q + e) + SHIFT)
                - world_transforms(ARM, G @ (q - e) + SHIFT)
            )
            / (2 * step)
            for e in step * np.eye(3)
        ]
        J = f["jacobian"](q)
        np.testing.assert_allclose(J[:3].T, [tip[5, :3, 3] for tip in tips], atol=1e-8)
        spins = [tip[5, :3, :3] @ frames[5, :3, :3].T for tip in tips]
        np.testing.assert_allclose(J[3:].T, [(s[2, 1], s[0, 2], s[1, 0]) for s in spins], atol=1e-8)


def test_it_is_written_and_read_again(model: symgen.Model) -> None:
    assert symgen.parse_robot(symgen.robot_toml(model.robot)) == model.robot
