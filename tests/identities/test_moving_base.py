"""A base with an IMU: kernels and base parameters against Pinocchio's free flyer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import parameter_vector
from packages import STRICT, c_files, run
from support import parsed, robot_of, sampled

import symgen
from symgen.codegen.model import regrouping

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.pinocchio_arm import PinocchioArm

NEED = {
    "torque_regressor",
    "inverse_dynamics",
    "gravity_torque",
    "bias_torque",
    "forward_dynamics",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
}
COMPARED = ("torque_regressor", "inverse_dynamics", "forward_dynamics")
#: Of the size of the torque; forward dynamics loses the condition of the mass matrix.
CLOSE = 1e-12


def on_imu(robot: symgen.Robot) -> symgen.Robot:
    """The robot, as its file gives it with an IMU on its base."""
    text = symgen.robot_toml(robot)
    return parsed(text.replace("[robot]\n", '[robot]\nbase = "imu"\n', 1))


def base_motions(seed: int, count: int) -> np.ndarray:
    """Random specific forces, angular velocities and accelerations: (3, count, 3)."""
    size = np.array([12.0, 3.0, 8.0])[:, None, None]
    return size * np.random.default_rng(seed).uniform(-1, 1, (3, count, 3))


@pytest.mark.parametrize("seed", sampled(range(200), 6))
def test_joints_of_random_trees_on_a_random_base(seed: int) -> None:
    """Torques to 1e-12, accelerations, derivatives, and the rank by Pinocchio's torques."""
    arm = random_arm(seed, max_joints=5)
    model = symgen.derive(on_imu(robot_of(arm)), (*COMPARED, "inverse_dynamics_derivatives"))
    call = symgen.load(model, backend="casadi")
    links, rotors = random_parameters(arm, seed)
    X = regrouping(model) @ parameter_vector(arm, links, rotors)
    tree = PinocchioArm(arm, links, rotors, floating=True)
    base = base_motions(seed, 8)
    q, qd, qdd = np.random.default_rng(seed).uniform(-2, 2, (3, 8, arm.n))
    regressor = call["torque_regressor"](q, qd, qdd, *base)
    for k in range(8):
        state, imu = (q[k], qd[k], qdd[k]), base[:, k]
        tau, by_q, by_qd = tree.on_moving_base(*state, imu)
        size = 1 + np.abs(tau).max() + np.abs(by_q).max() + np.abs(by_qd).max()
        np.testing.assert_allclose(regressor[k] @ X, tau, atol=CLOSE * size)
        found = call["inverse_dynamics"](*state, X, *imu)
        np.testing.assert_allclose(found, tau, atol=CLOSE * size)
        slopes = call["inverse_dynamics_derivatives"](*state, X, *imu)
        np.testing.assert_allclose(slopes, (by_q, by_qd), atol=CLOSE * size)
    tau = call["inverse_dynamics"](q[0], qd[0], qdd[0], X, *base[:, 0])
    found = call["forward_dynamics"](q[0], qd[0], tau, X, *base[:, 0])
    lost = np.linalg.cond(PinocchioArm(arm, links, rotors).mass_matrix(q[0]))
    np.testing.assert_allclose(found, qdd[0], atol=CLOSE * lost * (1 + np.abs(tau).max()))
    assert len(model.base.parameters) == torque_rank(arm, seed)


def torque_rank(arm, seed: int) -> int:
    """Rank of Pinocchio's torques over unit parameters, rotors included."""
    count = 10 * arm.links
    samples = 10 + 2 * count // arm.n
    base = base_motions(seed + 1, samples)
    states = np.random.default_rng(seed + 1).uniform(-2, 2, (samples, 3, arm.n))
    columns = []
    for k in range(count):
        links = np.zeros((arm.links, 10))
        heavy = links.copy()  # Pinocchio takes only bodies that can exist
        heavy[:, [0, 3, 5, 9]] = 5.0
        links.flat[k] = 1.0
        trees = [PinocchioArm(arm, x, floating=True) for x in (heavy + links, heavy)]
        with_it, without = (
            np.array([t.on_moving_base(*s, base[:, i])[0] for i, s in enumerate(states)])
            for t in trees
        )
        columns.append((with_it - without).ravel())
    for j in range(arm.n):
        rotor = np.zeros(states[:, 2].shape)
        rotor[:, j] = states[:, 2, j]
        columns.append(rotor.ravel())
    matrix = np.array(columns).T
    return int(np.linalg.matrix_rank(matrix, tol=1e-9 * np.linalg.norm(matrix, 2)))


def test_the_package_takes_the_motion_of_the_base_where_gravity_stood(tmp_path: Path) -> None:
    model = symgen.derive(on_imu(robot_of(random_arm(2, max_joints=4))), "all")
    name = model.robot.name
    names = {k.name for k in model.kernels}
    for kernel in model.kernels:
        inputs = [a for a, _ in kernel.tape.inputs]
        assert (kernel.name in NEED) == (inputs[-3:] == ["f", "w", "wd"]), kernel.name
    assert names.isdisjoint({"energy_regressor", "power_regressor", "momentum_regressor", "energy"})
    tree = symgen.generate(model, target="c", kernels=tuple(NEED))
    symgen.write_package(tree, tmp_path / "arm")
    header = (tmp_path / "arm" / f"{name}.h").read_text()
    assert "const double f[3], const double w[3], const double wd[3], double tau[" in header
    assert symgen.read_robot(tmp_path / "arm") == model.robot
    files = c_files(tmp_path / "arm", check=True)
    run(["cc", *STRICT, "-O1", f"-I{tmp_path / 'arm'}", *files, "-lm", "-o", "check"], tmp_path)
    run([tmp_path / "check"], tmp_path)


def test_batches_and_panels_take_a_base_motion_a_sample() -> None:
    model = symgen.derive(on_imu(robot_of(random_arm(2, max_joints=4))), ("torque_regressor",))
    call = symgen.load(model)["torque_regressor"]
    q = np.random.default_rng(0).uniform(-1, 1, (3, 70, model.robot.n))
    base = base_motions(0, 70)
    together = call(*q, *base)
    panels = call.panels()
    if panels is not None:
        np.testing.assert_allclose(panels(*q, *base), together, atol=1e-12)
    for k in (0, 69):
        np.testing.assert_allclose(together[k], call(*q[:, k], *base[:, k]), atol=1e-12)
    with pytest.raises(symgen.SymgenError, match=r"motion of the base is an input"):
        call(*q)


def test_what_needs_a_base_at_rest_is_refused_with_the_reason() -> None:
    model = symgen.derive(on_imu(robot_of(random_arm(2, max_joints=4))), "all")
    with pytest.raises(symgen.SymgenError, match=r"energy_regressor.+base at rest.+IMU"):
        symgen.generate(model, kernels=("energy_regressor",))
    text = symgen.robot_toml(model.robot)
    for wrong in ('base = "ship"', 'base = "imu"\ngravity = "input"'):
        lines = [x for x in text.splitlines() if not x.startswith(("gravity", "base"))]
        with pytest.raises(symgen.SymgenError, match="base"):
            parsed("\n".join(lines).replace("[robot]", f"[robot]\n{wrong}", 1))
