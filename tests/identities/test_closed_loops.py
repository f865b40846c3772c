"""Parallelograms: the constraint, the base parameters and the torques of SR 400, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.following import FollowingArm, following_arm
from oracles.numeric_rank import NoGapError
from oracles.random_arms import random_parameters
from oracles.transforms import Arm, parameter_vector, world_transforms
from packages import c_files, run
from support import parsed, sampled

import symgen
from symgen.codegen.model import regrouping

D2, D3, D4, D8, RL4 = 0.4, 0.8, -0.2, 1.0, 1.0
_RIGHT = np.pi / 2
# The published table of SR 400 (Khalil and Kleinfinger 1986), with joint 9 closed by frame 10.
TABLE = {
    "sigma": (0, 0, 0, 0, 0, 0, 0, 0, 2, 2),
    "ant": (0, 1, 2, 3, 4, 5, 1, 7, 8, 3),
    "gamma": (0,) * 9 + (_RIGHT,),
    "alpha": (0, -_RIGHT, 0, -_RIGHT, _RIGHT, -_RIGHT, -_RIGHT, 0, 0, 0),
    "d": (0, D2, D3, D4, 0, 0, D2, D8, D3, -D8),
    "r": (0, 0, 0, RL4, 0, 0, 0, 0, 0, 0),
}
OWN = (1, 2, 4, 5, 6, 7)


def _closed(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Bring the passive joints 3 and 8 to where frames 9 and 10 meet, by Newton's method."""
    q_tree = np.zeros(8)
    q_tree[[0, 1, 3, 4, 5, 6]] = q
    q_tree[[2, 7]] = _RIGHT - q[1] + q[5] + 0.1, q[1] - q[5] - 0.1
    for _ in range(20):
        q_tree[[2, 7]] -= np.linalg.lstsq(_jacobian(arm, q_tree)[:, [2, 7]], _gap(arm, q_tree))[0]
    return q_tree


def _gap(arm: Arm, q_tree: np.ndarray) -> np.ndarray:
    frames = world_transforms(arm, q_tree)
    return frames[8][:3, 3] - frames[9][:3, 3]


def _jacobian(arm: Arm, q_tree: np.ndarray) -> np.ndarray:
    h = 1e-6
    steps = h * np.eye(len(q_tree))
    return np.array([(_gap(arm, q_tree + s) - _gap(arm, q_tree - s)) / (2 * h) for s in steps]).T


@pytest.fixture(scope="module")
def model() -> symgen.Model:
    return symgen.derive(symgen.read_robot("sr400"), "all")


def test_sr400_has_the_torques_that_its_closed_chain_needs(model: symgen.Model) -> None:
    pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
    from oracles.pinocchio_arm import PinocchioArm

    arm = Arm.from_table(TABLE)
    links, _ = random_parameters(arm, 3)
    rotors = [j in OWN for j in range(1, 11)]
    values = parameter_vector(arm, links, np.zeros(8), rotors)
    standard = [*values, *np.zeros(len(model.base.standard) - len(values))]
    X = regrouping(model) @ standard
    evaluator = symgen.load(model, backend="casadi")
    witness = PinocchioArm(arm, links)
    draw = np.random.default_rng(0)
    for _ in range(3):
        q, qd, qdd = draw.uniform(-0.6, 0.6, (3, 6))
        q_tree = _closed(arm, q)
        # Rates that keep the loop closed: the null space of the constraint, found in numbers.
        J = _jacobian(arm, q_tree)
        active = [0, 1, 3, 4, 5, 6]
        G = np.zeros((8, 6))
        G[active] = np.eye(6)
        G[[2, 7]] = -np.linalg.lstsq(J[:, [2, 7]], J[:, active])[0]
        tau = G.T @ witness.inverse_dynamics(q_tree, G @ qd, G @ qdd)
        np.testing.assert_allclose(
            evaluator["inverse_dynamics"](q, qd, qdd, X), tau, atol=1e-6 * np.abs(tau).max()
        )
        frames = evaluator["frames"](q)
        np.testing.assert_allclose(frames[8][:3, 3], frames[9][:3, 3], atol=1e-12)
        np.testing.assert_allclose(frames, world_transforms(arm, q_tree), atol=1e-9)


def test_sr400_has_42_inertial_base_parameters_in_formulas(model: symgen.Model) -> None:
    G = np.zeros((8, 6))
    G[[0, 1, 3, 4, 5, 6], range(6)] = 1
    G[2, [1, 5]], G[7, [1, 5]] = (-1, 1), (1, -1)
    c = np.array([0, 0, _RIGHT, 0, 0, 0, 0, 0])
    oracle = FollowingArm(Arm.from_table(TABLE), OWN, G, c, "")
    assert model.base.inertial == oracle.count_base_parameters() == 42
    formulas = {p.head: p.expression for p in model.base.parameters}
    assert formulas["MX7"] == "MX7 - D8/D3*MX8 + D8*M8 - D8/D3*MX9"


@pytest.mark.parametrize("block", sampled(range(4), 1))
def test_base_parameters_of_random_following_joints(block: int) -> None:
    for seed in range(200 + 15 * block, 215 + 15 * block):
        chosen = following_arm(seed)
        try:
            expected = chosen.count_base_parameters()
        except NoGapError:
            continue
        assert symgen.derive(parsed(chosen.text)).base.inertial == expected, seed


def test_a_robot_with_loops_is_written_and_read_again() -> None:
    robot = symgen.read_robot("sr400")
    assert symgen.parse_robot(symgen.robot_toml(robot)) == robot


PLANAR = """
[robot]
name = "four_bar"
[[joint]]
[[joint]]
d = 0.5
follows = "q3 - q1"
[[joint]]
antecedent = 0
[[joint]]
d = 0.3
follows = "q1 - q3"
[[joint]]
sigma = 2
antecedent = 2
d = 0.3
[[joint]]
sigma = 2
antecedent = 4
d = 0.5
[[loop]]
cut = [5, 6]
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cut = [5, 6]", "cut = [5, 9]", "no joint 9"),
        ("cut = [5, 6]", "cut = [5, 5]", "accepted: different joints"),
        ("q1 - q3", "q3 - q1", "loop 1: frames 5 and 6 separate by"),
        ("d = 0.3\nfollows", "d = 0.31\nfollows", "separate by 0.01 m"),
        ('follows = "q1 - q3"', "", "passive joints linear in the active ones"),
        ("q1 - q3", "q1*q3", "a sum of numbers times variables"),
        ("q1 - q3", "q1 - q2", "found 'q2'"),
        ("q1 - q3", "sqrt(2)*q1", "accepted for a revolute joint: fractions"),
        ("q1 - q3", "201*q1", "accepted: at most 200 in size"),
        ("q1 - q3", "1", "a sum of numbers times variables"),
        ('follows = "q1 - q3"', 'follows = "q1"\nfriction = ["viscous"]', "has none of its own"),
        ("sigma = 2\nantecedent = 4", 'sigma = 2\nfollows = "q1"', "a fixed joint"),
    ],
)
def test_what_does_not_close_or_is_not_linear_is_refused(old: str, new: str, message: str) -> None:
    assert symgen.parse_robot(PLANAR).n == 2
    with pytest.raises(symgen.RobotError, match=message) as caught:
        symgen.parse_robot(PLANAR.replace(old, new))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("sigma", [0, 1])
def test_a_factor_that_is_zero_at_the_values_is_refused(sigma: int) -> None:
    # It would be written as "0", which follows nothing.
    text = PLANAR.split("[[loop]]")[0].replace("[[joint]]", "[geometry]\nL1 = 0\n[[joint]]", 1)
    text = text.replace('d = 0.3\nfollows = "q1 - q3"', f'sigma = {sigma}\nfollows = "L1*q1"')
    with pytest.raises(symgen.RobotError, match="joint 4, key 'follows': the factor of q1 is 0"):
        symgen.parse_robot(text)


def test_the_only_entry_of_a_kernel_may_be_near_zero_at_a_point(tmp_path) -> None:
    # One variable: at one of the package's points C is a thousandth of what it is at the others.
    text = '[robot]\nname = "arm"\n[[joint]]\nfollows = "q2"\n[[joint]]\nd = 0.3\n'
    model = symgen.derive(symgen.parse_robot(text), ("coriolis", "mass_matrix"))
    symgen.write_package(symgen.generate(model, target="c"), tmp_path)
    run(["cc", "-O0", *c_files(tmp_path, check=True), "-lm", "-o", "checked"], tmp_path)
    run([tmp_path / "checked"], tmp_path)
