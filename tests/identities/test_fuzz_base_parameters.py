"""Base parameters of more than 1,000 random robots: the count of each, and a sample of them again.

The whole run takes minutes and is made on purpose:

    pytest -m slow tests/identities/test_fuzz_base_parameters.py

The default suite takes some of these robots. Where a rank is
uncertain, the oracle says nothing.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles.following import following_arm
from oracles.numeric_rank import NoGapError, count_base_parameters, difference_matrix
from oracles.random_arms import named_arm, random_arm
from oracles.transforms import Arm
from support import parsed, regrouping_error, robot_of, sampled

import symgen

FRICTION = [(), ("coulomb", "viscous"), ("coulomb", "viscous", "offset"), ("offset",)]
# Trees with prismatic joints, several of them on the base, are where grouping by rules fails.
OPEN, FOLLOWING, NAMED = 1100, 200, 300


def _open(seed: int) -> bool:
    """Compare one random arm with the oracle: count, and every regrouping by its columns."""
    arm = random_arm(7_000_000 + seed, max_joints=7, tree=None if seed % 2 else True)
    rotor, friction = bool(seed % 3), FRICTION[seed % 4]
    return _compared(seed, arm, robot_of(arm, friction, rotor), rotor, friction)


def _named(seed: int) -> bool:
    """The same for an arm whose lengths are named, times roots and fractions."""
    arm, text = named_arm(9_000_000 + seed)
    return _compared(seed, arm, parsed(text, "named"), True, ())


def _compared(
    seed: int, arm: Arm, robot: symgen.Robot, rotor: bool, friction: tuple[str, ...]
) -> bool:
    base = symgen.derive(robot, ()).base
    try:
        expected = count_base_parameters(arm, rotor, friction)
    except NoGapError:
        return False
    assert len(base.parameters) == expected == base.proof.rank, seed
    W, names = difference_matrix(arm, rotor, friction)
    column = dict(zip(names, W.T, strict=True))
    error = regrouping_error(base.parameters, column, robot.values())
    assert error < 1e-8 * max(1.0, np.abs(W).max()), seed
    still = {name for name, values in column.items() if np.abs(values).max() < 1e-10}
    assert set(base.no_effect) == still, seed
    proof = base.proof
    found = proof.structural_relations + proof.lifted_relations
    assert found == len(base.standard) - len(base.parameters), seed
    # ten points more than there are columns, and one of them is what all others are compared with
    assert proof.points == sum(p.inertial or p.prefix == "OF" for p in base.standard) + 9
    assert len(set(proof.primes)) == len(set(proof.seeds)) == 2
    return True


def _following(seed: int) -> bool:
    chosen = following_arm(3_000 + seed)
    count = symgen.derive(parsed(chosen.text)).base.inertial
    try:
        expected = chosen.count_base_parameters()
    except NoGapError:
        return False
    assert count == expected, seed
    return True


@pytest.mark.slow
def test_every_robot() -> None:
    certain = sum(_open(seed) for seed in range(OPEN))
    certain += sum(_following(seed) for seed in range(FOLLOWING))
    assert certain >= 0.9 * (OPEN + FOLLOWING)


@pytest.mark.slow
def test_every_robot_with_named_lengths() -> None:
    certain = sum(_named(seed) for seed in range(NAMED))
    assert certain >= 0.9 * NAMED


@pytest.mark.parametrize("start", sampled(range(4), 1))
def test_named_lengths_times_roots_and_fractions(start: int) -> None:
    for seed in range(start, NAMED, 75):
        _named(seed)


@pytest.mark.parametrize(
    ("angle", "length"),
    sampled([(a, x) for a in ("0.3", '"pi/6"')
             for x in ("sqrt(2)*L1/2", "sqrt(3)*L1/3", "2*L1/3")], 3),
)  # fmt: skip
def test_a_prismatic_joint_at_a_named_length_times_a_root(angle: str, length: str) -> None:
    joint = f'[[joint]]\nsigma = 1\ngamma = {angle}\nd = "{length}"\n'
    head = '[robot]\nname = "x"\nconvention = "modified-dh"\ngravity = [0.0, 0.0, -9.81]\n'
    robot = parsed(f"{head}[geometry]\nL1 = 0.5\n[[joint]]\n{joint}[[joint]]\n", "x")
    ours = symgen.derive(robot, ()).base
    gamma = 0.3 if angle == "0.3" else np.pi / 6
    d = {"sqrt(2)*L1/2": 0.5**1.5, "sqrt(3)*L1/3": 3**-0.5 / 2, "2*L1/3": 1 / 3}[length]
    arm = Arm.from_table({"sigma": (0, 1, 0), "gamma": (0, gamma, 0), "d": (0, d, 0)})
    friction = ("coulomb", "viscous")
    assert len(ours.parameters) == count_base_parameters(arm, True, friction)


@pytest.mark.parametrize("start", sampled(range(4), 1))
def test_a_sample_again(start: int) -> None:
    assert sum(_open(seed) for seed in range(7 * start, OPEN, 131)) > 5
    assert sum(_following(seed) for seed in range(start, FOLLOWING, 67)) > 1
