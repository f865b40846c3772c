"""What is said of base parameters beside their formulas: proof, bound, and what has no effect."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.random_arms import to_toml
from oracles.transforms import Arm, column_names, energy_regressor

import symgen
from symgen.symbolic.base_parameters import bound

ARMS = {
    "planar": Arm.from_table({"sigma": [0, 0], "d": [0, 0.5], "gravity": [0, -9.81, 0]}),
    "mixed": Arm.from_table({"sigma": [0, 1, 0], "alpha": [0, 0.5, 1.1], "d": [0, 0.2, 0.4],
                             "theta": [0, 0.3, 0], "r": [0, 0, 0.1]}),
    "level": Arm.from_table({"sigma": [1, 0], "alpha": [0.4, 0.4], "gravity": [0, 0, 0]}),
}  # fmt: skip


def _base(
    name: str, friction: tuple[str, ...] = ()
) -> symgen.symbolic.base_parameters.BaseParameters:
    text = to_toml(ARMS[name], name="arm", friction=friction, rotor=False)
    return symgen.derive(symgen.parse_robot(text), ()).base


@pytest.mark.parametrize("name", ARMS)
def test_what_no_motion_shows_alone_has_no_effect(name: str) -> None:
    arm = ARMS[name]
    q, qd = np.random.default_rng(1).uniform(-3, 3, (2, 80, arm.n))
    columns = energy_regressor(arm, q, qd, False)
    still = np.ptp(columns, axis=0) < 1e-12
    expected = {n for n, s in zip(column_names(arm, False), still, strict=True) if s}
    assert expected
    assert set(_base(name).no_effect) == expected


@pytest.mark.parametrize("friction", [(), ("coulomb",), ("coulomb", "viscous", "offset")])
@pytest.mark.parametrize("name", ARMS)
def test_the_proof_counts_what_it_proves(name: str, friction: tuple[str, ...]) -> None:
    base = _base(name, friction)
    proof = base.proof
    assert proof.rank == len(base.parameters)
    assert proof.structural_relations + proof.lifted_relations == len(base.standard) - len(
        base.parameters
    )
    # ten points more than there are columns, and one of them is what all others are compared with
    columns = sum(p.inertial or p.prefix == "OF" for p in base.standard)
    assert proof.points == columns + 9
    assert len(set(proof.primes)) == len(set(proof.seeds)) == 2


@pytest.mark.parametrize(
    ("sigma", "most"),
    [
        ([0], 3),
        ([1], 1),
        ([0, 0], 11),
        ([1, 0, 1], 14),
        ([0, 1], 8),
        ([2, 1, 0], 9),
        ([0, 2, 0], 11),
    ],
)
def test_the_bound_counts_each_type_of_joint(sigma: list[int], most: int) -> None:
    """8 a revolute and 5 a prismatic joint, less 4, less 1 where a revolute one is first."""
    robot = symgen.parse_robot(to_toml(Arm.from_table({"sigma": sigma}), name="arm"))
    assert bound(robot) == most
