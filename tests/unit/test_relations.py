"""Relations that hold by structure: on point masses, and on plain transforms of random arms."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.random_arms import random_arm, to_toml
from oracles.transforms import (
    LINK_PARAMETERS,
    Arm,
    column_names,
    energy_regressor,
    world_transforms,
)

import symgen
from symgen.symbolic.relations import structural_relations


def ten(points: np.ndarray, masses: np.ndarray) -> dict[str, float]:
    """Return the ten parameters of point masses (K, 3), (K,) about the origin."""
    x, y, z = points.T
    values = (
        masses @ (y * y + z * z), -masses @ (x * y), -masses @ (x * z), masses @ (x * x + z * z),
        -masses @ (y * z), masses @ (x * x + y * y), masses @ x, masses @ y, masses @ z,
        masses.sum(),
    )  # fmt: skip
    return dict(zip(LINK_PARAMETERS, map(float, values), strict=True))


def test_each_of_the_ten_alone_is_a_body_on_what_a_fixed_joint_stands_on() -> None:
    """The map of point masses is linear: its columns, from 40 bodies by least squares."""
    draw = np.random.default_rng(5)
    geometry = {"gamma": 0.4, "b": 0.3, "alpha": 1.2, "d": -0.7, "theta": 0.9, "r": 1.1}
    arm = Arm.from_table({"sigma": [0, 2], **{k: [0, v] for k, v in geometry.items()}})
    T = world_transforms(arm, np.zeros(1))[1]
    before, after = [], []
    for _ in range(40):
        points, masses = draw.normal(size=(9, 3)), draw.normal(size=9)
        before.append([*ten(points, masses).values()])
        after.append([*ten(points @ T[:3, :3].T + T[:3, 3], masses).values()])
    expected = np.linalg.lstsq(np.array(before), np.array(after), rcond=None)[0]
    relations = structural_relations(symgen.parse_robot(to_toml(arm, name="arm")))[3:]
    for name, row, relation in zip(LINK_PARAMETERS, expected, relations, strict=True):
        assert relation.pop(f"{name}2") == 1
        found = [-float(relation.get(f"{k}1", 0)) for k in LINK_PARAMETERS]
        np.testing.assert_allclose(found, row, atol=1e-9)


TABLES = {
    "parallel": Arm.from_table({"sigma": [0, 0, 0], "d": [0.1, 0.5, 0.4], "r": [0.2, 0, 0.3],
                                "gravity": [0, -9.81, 0]}),
    "twisted": Arm.from_table({"sigma": [0, 0, 0], "alpha": [0.2, 0.9, -0.5], "b": [0, 0.3, 0.4],
                               "d": [0, 0.5, 0.4], "gamma": [0, 0.6, 0.1], "r": [0.2, 0.1, 0.3]}),
    "prismatic": Arm.from_table({"sigma": [1, 0, 1, 0, 1], "alpha": [0.4, 0.7, 0.3, 0, 1.1],
                                 "theta": [0.2, 0, -0.8, 0, 0.5], "d": [0, 0.2, 0.1, 0.4, 0],
                                 "gamma": [0.1, 0, 0.5, 0, 0.3], "b": [0, 0.2, 0, 0, 0.6]}),
    "along": Arm.from_table({"sigma": [0, 1, 0, 1], "d": [0, 0.3, 0.2, 0.1],
                             "gravity": [0, 0, 0]}),
    "fixed": Arm.from_table({"sigma": [0, 2, 0, 2], "alpha": [0, 0.5, 1.3, 0.2],
                             "theta": [0, 0.7, 0, 0.4], "r": [0, 0.2, 0.1, 0.3],
                             "d": [0, 0.3, 0.4, 0.1]}),
    "tree": Arm.from_table({"sigma": [0, 0, 1, 0], "ant": [0, 1, 1, 0], "d": [0, 0.5, 0.3, 0.2],
                            "gamma": [0, 0.2, 0.9, 0], "b": [0, 0.1, 0.4, 0],
                            "alpha": [0, 0, 0.8, 0.4]}),
}  # fmt: skip
ARMS = {**TABLES, **{f"random {seed}": random_arm(seed, max_joints=4) for seed in range(3)}}


def constant_parts(arm: Arm, seed: int = 0) -> dict[str, np.ndarray]:
    """Return the columns of energy at random states, less what they are at the first."""
    draw = np.random.default_rng(seed)
    q, qd = draw.uniform(-3, 3, (2, 60, arm.n))
    names = column_names(arm, False)
    h = energy_regressor(arm, q, qd, False)
    return dict(zip(names, (h - h[0]).T, strict=True))


@pytest.mark.parametrize("name", ARMS)
def test_no_motion_shows_a_relation(name: str) -> None:
    arm = ARMS[name]
    columns = constant_parts(arm)
    robot = symgen.parse_robot(to_toml(arm, name="arm"))
    relations = structural_relations(robot)
    for relation in relations:
        total = sum(float(c) * columns[k] for k, c in relation.items())
        assert np.abs(total).max() < 1e-9, relation
    independent = np.array([[float(r.get(k, 0)) for k in columns] for r in relations])
    assert np.linalg.matrix_rank(independent) == len(relations)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        # 3 of each revolute, 6 of each prismatic, 10 of each fixed one, and directions kept
        ("parallel", 9), ("twisted", 9), ("prismatic", 25), ("along", 3 + 7 + 3 + 7),
        ("fixed", 3 + 10 + 3 + 10), ("tree", 3 + 3 + 7 + 3),
    ],
)  # fmt: skip
def test_each_type_of_joint_has_its_relations(name: str, count: int) -> None:
    assert len(structural_relations(symgen.parse_robot(to_toml(ARMS[name], name="arm")))) == count


def test_a_direction_is_kept_up_to_the_second_axis_that_is_not_parallel() -> None:
    """The moment along the first axis of a prismatic link, until a revolute joint turns it."""
    kept = Arm.from_table({"sigma": [0, 1, 0, 1], "alpha": [0, 0.5, -0.5, 0.7]})
    lost = Arm.from_table({"sigma": [0, 1, 0, 1], "alpha": [0, 0.5, 0.4, 0.7]})
    for arm, links in ((kept, ("2", "4")), (lost, ("2",))):
        robot = symgen.parse_robot(to_toml(arm, name="arm"))
        found = structural_relations(robot)
        moments = [
            r for r in found if all(k[:2] in ("MX", "MY", "MZ") for k in r) and len(r) > 1
            if len({k[2:] for k in r}) == 1
        ]  # fmt: skip
        assert [next(iter(r))[2:] for r in moments] == [*links]
        columns = constant_parts(arm)
        for r in moments:
            assert np.abs(sum(float(c) * columns[k] for k, c in r.items())).max() < 1e-9


def test_a_payload_is_a_body_on_its_link() -> None:
    robot = symgen.parse_robot(
        '[robot]\nname = "a"\n[[joint]]\n[[joint]]\nalpha = "pi/2"\n[payload]\njoint = 2\n'
    )
    payload = structural_relations(robot)[-10:]
    assert payload == [{f"{p}L": 1, f"{p}2": -1} for p in LINK_PARAMETERS]
